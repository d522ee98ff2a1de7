//! Many samples made few shapes: clouds to occupied cells, curves to what a pixel column can show.

use crate::color::Color;
use crate::scene::{Runs, Shape};

/// A rectangle on paper with the values at its edges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Frame {
    pub left: f64,
    pub top: f64,
    pub width: f64,
    pub height: f64,
    pub x: [f64; 2],
    pub y: [f64; 2],
}

impl Frame {
    /// Place on paper; may lie outside the frame, is never infinite or NaN for finite values.
    pub(crate) fn place(&self, x: f64, y: f64) -> [f64; 2] {
        let share = |v: f64, [low, high]: [f64; 2]| {
            let share = (v - low) / (high - low);
            if share.is_nan() {
                0.5
            } else {
                share.clamp(-1e4, 1e4)
            }
        };
        [
            self.left + share(x, self.x) * self.width,
            self.top + (1.0 - share(y, self.y)) * self.height,
        ]
    }

    pub(crate) fn holds(&self, x: f64, y: f64) -> bool {
        x >= self.x[0] && x <= self.x[1] && y >= self.y[0] && y <= self.y[1]
    }

    pub(crate) fn right(&self) -> f64 {
        self.left + self.width
    }

    pub(crate) fn bottom(&self) -> f64 {
        self.top + self.height
    }
}

/// A cloud of points in up to four shades, sparse first.
pub(crate) struct Thinned {
    pub shades: [Runs; 4],
    /// Width of the dots.
    pub dot: f64,
    /// True if the shade says something.
    pub shaded: bool,
}

/// Cells of the frame that hold a point. `most_runs` bounds the size of what comes out: cells grow until it holds.
pub(crate) fn cells(frame: &Frame, x: &[f64], y: &[f64], most_runs: usize, shade: bool) -> Thinned {
    let inside = x
        .iter()
        .zip(y)
        .filter(|&(&x, &y)| frame.holds(x, y))
        .count();
    // Few points: larger dots, placed to half a unit.
    let (mut cell, dot): (f64, f64) = match inside {
        0..=800 => (0.5, 4.4),
        801..=6000 => (0.5, 2.8),
        _ => (1.0, 1.9),
    };
    loop {
        let grid = Grid::fill(frame, x, y, cell);
        let shaded = shade && inside > 6000;
        let shades = grid.runs(frame, shaded);
        let runs: usize = shades.iter().map(|s| s.runs.len()).sum();
        if runs <= most_runs || cell >= 16.0 {
            return Thinned {
                shades,
                dot: dot.max(cell),
                shaded,
            };
        }
        cell *= 2.0;
    }
}

struct Grid {
    columns: usize,
    rows: usize,
    cell: f64,
    count: Vec<u32>,
}

impl Grid {
    fn fill(frame: &Frame, x: &[f64], y: &[f64], cell: f64) -> Self {
        let columns = index(frame.width / cell) + 1;
        let rows = index(frame.height / cell) + 1;
        let mut count = vec![0_u32; columns * rows];
        for (&x, &y) in x.iter().zip(y).filter(|&(&x, &y)| frame.holds(x, y)) {
            let [px, py] = frame.place(x, y);
            let column = index((px - frame.left) / cell).min(columns - 1);
            let row = index((py - frame.top) / cell).min(rows - 1);
            let held = &mut count[row * columns + column];
            *held = held.saturating_add(1);
        }
        Self {
            columns,
            rows,
            cell,
            count,
        }
    }

    /// Points in the 5 by 5 cells around each occupied cell: smooth enough to be a shade, not a speckle.
    fn crowd(&self) -> Vec<u64> {
        let wide = self.columns + 1;
        let mut sum = vec![0_u64; wide * (self.rows + 1)];
        for row in 0..self.rows {
            let mut line = 0_u64;
            for column in 0..self.columns {
                line += u64::from(self.count[row * self.columns + column]);
                sum[(row + 1) * wide + column + 1] = sum[row * wide + column + 1] + line;
            }
        }
        let mut crowd = vec![0; self.count.len()];
        for row in 0..self.rows {
            let (top, bottom) = (row.saturating_sub(2), (row + 3).min(self.rows));
            for column in 0..self.columns {
                let (left, right) = (column.saturating_sub(2), (column + 3).min(self.columns));
                crowd[row * self.columns + column] = sum[bottom * wide + right]
                    + sum[top * wide + left]
                    - sum[top * wide + right]
                    - sum[bottom * wide + left];
            }
        }
        crowd
    }

    fn runs(&self, frame: &Frame, shaded: bool) -> [Runs; 4] {
        let crowd = if shaded { self.crowd() } else { Vec::new() };
        let limits = limits(&self.count, &crowd);
        let shade_of = |place: usize| -> usize {
            if !shaded {
                return 3;
            }
            limits
                .iter()
                .filter(|&&limit| crowd[place] >= limit)
                .count()
        };
        let empty = || Runs {
            origin: [frame.left + 0.5 * self.cell, frame.top + 0.5 * self.cell],
            cell: self.cell,
            runs: Vec::new(),
        };
        let mut shades = [empty(), empty(), empty(), empty()];
        for row in 0..self.rows {
            for column in 0..self.columns {
                let place = row * self.columns + column;
                if self.count[place] == 0 {
                    continue;
                }
                let [row, column] = [row, column].map(|v| u32::try_from(v).unwrap_or(u32::MAX));
                let runs = &mut shades[shade_of(place)].runs;
                match runs.last_mut() {
                    Some([r, _, last]) if *r == row && *last + 1 == column => *last = column,
                    _ => runs.push([row, column, column]),
                }
            }
        }
        shades
    }
}

/// Crowds at which a cell turns to the next shade, even in the logarithm.
fn limits(count: &[u32], crowd: &[u64]) -> [u64; 3] {
    let mut held: Vec<u64> = crowd
        .iter()
        .zip(count)
        .filter(|&(_, &n)| n > 0)
        .map(|(&c, _)| c)
        .collect();
    if held.is_empty() {
        return [0; 3];
    }
    let place = held.len() - 1 - held.len() / 50;
    let top = *held.select_nth_unstable(place).1;
    #[expect(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a shade"
    )]
    let at = |share: f64| (top.max(1) as f64).powf(share).ceil().max(2.0) as u64;
    [at(0.35), at(0.6), at(0.85)]
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped; a paper is small"
)]
fn index(v: f64) -> usize {
    v.clamp(0.0, 100_000.0) as usize
}

/// A curve on paper, cut at gaps and at the frame.
#[derive(Debug, Default)]
pub(crate) struct Path {
    pub lines: Vec<Vec<[f64; 2]>>,
    /// Where many samples fall on one unit of width: the band they span; the line is then their mean.
    pub bands: Vec<Vec<[f64; 2]>>,
    /// Abscissas and ordinates, in the frame's units, of points between gaps: a line through one would not be seen.
    pub lone: [Vec<f64>; 2],
}

impl Path {
    /// The dots of the lone points; no more than a line's worth.
    pub(crate) fn dots(&self, frame: &Frame, color: Color) -> impl Iterator<Item = Shape> {
        const MOST_RUNS: usize = 6000;
        let [x, y] = &self.lone;
        let thin = cells(frame, x, y, MOST_RUNS, false);
        let held = |runs: &Runs| !runs.runs.is_empty();
        let dot = move |runs| Shape::Dots {
            runs,
            width: thin.dot,
            color,
        };
        thin.shades.into_iter().filter(held).map(dot)
    }
}

/// The curve with no more points than paper can show.
pub(crate) fn curve(frame: &Frame, x: &[f64], y: &[f64]) -> Path {
    let mut path = Path::default();
    let mut run: Vec<[f64; 2]> = Vec::new();
    let mut last = [f64::NAN; 2];
    let mut end = |run: &mut Vec<[f64; 2]>, [x, y]: [f64; 2]| {
        if run.len() == 1 {
            path.lone[0].push(x);
            path.lone[1].push(y);
        } else {
            add_run(frame, run, &mut path);
        }
        run.clear();
    };
    for (&x, &y) in x.iter().zip(y) {
        if x.is_finite() && y.is_finite() {
            run.push(frame.place(x, y));
            last = [x, y];
        } else {
            end(&mut run, last);
        }
    }
    end(&mut run, last);
    path
}

fn add_run(frame: &Frame, run: &[[f64; 2]], path: &mut Path) {
    let [Some(first), Some(last)] = [run.first(), run.last()] else {
        return;
    };
    let width = last[0] - first[0];
    let forward = || run.windows(2).all(|pair| pair[0][0] <= pair[1][0]);
    // Five samples a unit: a line through them all would be a blot.
    #[expect(clippy::cast_precision_loss, reason = "a number of samples")]
    let dense = width > 4.0 && run.len() as f64 > 5.0 * width;
    if dense && forward() {
        let (band, mean) = envelope(frame, run);
        path.bands.push(band);
        clip(frame, &mean, &mut path.lines);
    } else {
        clip(frame, &columns(run), &mut path.lines);
    }
}

/// The band and the mean of the samples over each unit of width; columns of equal width, so that none is left over.
///
/// In the mean a sample counts by the width that it stands for: one that shares its place with its neighbours is in the
/// band alone.
fn envelope(frame: &Frame, run: &[[f64; 2]]) -> (Vec<[f64; 2]>, Vec<[f64; 2]>) {
    let (mut above, mut below, mut mean) = (Vec::new(), Vec::new(), Vec::new());
    let (start, end) = (run[0][0], run[run.len() - 1][0]);
    let columns = (end - start).floor().max(2.0);
    let unit = (end - start) / columns;
    let column = |p: &[f64; 2]| ((p[0] - start) / unit).floor().min(columns - 1.0);
    let inside = |x: f64, y: f64| {
        [
            x.clamp(frame.left, frame.right()),
            y.clamp(frame.top, frame.bottom()),
        ]
    };
    let mut at = 0;
    for group in run.chunk_by(|a, b| column(a) == column(b)) {
        let from = at;
        at += group.len();
        let (mut sum, mut widths) = (0.0, 0.0);
        for (i, p) in (from..).zip(group) {
            let before = run[i.saturating_sub(1)][0];
            let width = run[(i + 1).min(run.len() - 1)][0] - before;
            sum += width * p[1];
            widths += width;
        }
        // The outermost means reach to the ends, so that the line starts where the data do.
        let x = match column(&group[0]) {
            0.0 => start,
            last if last >= columns - 1.0 => end,
            inner => start + (inner + 0.5) * unit,
        };
        let (low, high) = group
            .iter()
            .fold((f64::MAX, f64::MIN), |(l, h), p| (l.min(p[1]), h.max(p[1])));
        above.push(inside(x, low));
        below.push(inside(x, high));
        mean.push([
            x,
            if widths > 0.0 {
                sum / widths
            } else {
                group[0][1]
            },
        ]);
    }
    below.reverse();
    above.append(&mut below);
    (above, mean)
}

/// First, lowest, highest and last point of every half unit of width, in their order; the picture stays the same.
fn columns(run: &[[f64; 2]]) -> Vec<[f64; 2]> {
    if run.len() < 1500 {
        return run.to_vec();
    }
    let column = |p: &[f64; 2]| (p[0] * 2.0).floor();
    let mut out = Vec::new();
    for group in run.chunk_by(|a, b| column(a) == column(b)) {
        if group.len() <= 4 {
            out.extend_from_slice(group);
            continue;
        }
        let by_height =
            |&(_, a): &(usize, &[f64; 2]), &(_, b): &(usize, &[f64; 2])| a[1].total_cmp(&b[1]);
        let extreme = |found: Option<(usize, &[f64; 2])>| found.map_or(0, |(i, _)| i);
        let mut keep = [
            0,
            extreme(group.iter().enumerate().min_by(by_height)),
            extreme(group.iter().enumerate().max_by(by_height)),
            group.len() - 1,
        ];
        keep.sort_unstable();
        let mut last = None;
        for i in keep {
            if last != Some(i) {
                out.push(group[i]);
            }
            last = Some(i);
        }
    }
    out
}

/// Liang and Barsky, segment by segment.
fn clip(frame: &Frame, run: &[[f64; 2]], lines: &mut Vec<Vec<[f64; 2]>>) {
    let mut line: Vec<[f64; 2]> = Vec::new();
    for pair in run.windows(2) {
        let Some((from, to)) = clip_segment(frame, pair[0], pair[1]) else {
            continue;
        };
        if line.last() != Some(&from) {
            if line.len() > 1 {
                lines.push(std::mem::take(&mut line));
            }
            line = vec![from];
        }
        line.push(to);
    }
    if line.len() > 1 {
        lines.push(line);
    }
}

fn clip_segment(frame: &Frame, a: [f64; 2], b: [f64; 2]) -> Option<([f64; 2], [f64; 2])> {
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    let d = [b[0] - a[0], b[1] - a[1]];
    let edges = [
        (-d[0], a[0] - frame.left),
        (d[0], frame.right() - a[0]),
        (-d[1], a[1] - frame.top),
        (d[1], frame.bottom() - a[1]),
    ];
    for (p, q) in edges {
        if p == 0.0 {
            if q < 0.0 {
                return None;
            }
        } else if p < 0.0 {
            enter = enter.max(q / p);
        } else {
            leave = leave.min(q / p);
        }
    }
    if enter > leave {
        return None;
    }
    let at = |t: f64| [a[0] + t * d[0], a[1] + t * d[1]];
    // Untouched ends stay bit for bit, so that segments join again.
    Some((
        if enter == 0.0 { a } else { at(enter) },
        if leave >= 1.0 { b } else { at(leave) },
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: Frame = Frame {
        left: 10.0,
        top: 20.0,
        width: 500.0,
        height: 300.0,
        x: [0.0, 1.0],
        y: [0.0, 1.0],
    };

    #[test]
    fn a_curve_that_leaves_the_frame_is_cut_at_its_edge() {
        let lines = curve(&FRAME, &[0.0, 0.5, 1.0], &[0.5, 1.5, 0.5]).lines;
        assert_eq!(lines.len(), 2);
        assert!(
            lines
                .iter()
                .flatten()
                .all(|p| p[1] >= 20.0 - 1e-9 && p[1] <= 320.0 + 1e-9)
        );
    }

    #[test]
    fn a_gap_breaks_the_curve() {
        assert_eq!(
            curve(
                &FRAME,
                &[0.0, 0.2, 0.4, 0.6, 0.8],
                &[0.1, 0.2, f64::NAN, 0.3, 0.4]
            )
            .lines
            .len(),
            2
        );
    }

    #[test]
    fn a_point_between_gaps_is_a_dot() {
        let y = [0.1, f64::NAN, 0.2, 0.3, f64::NAN, 0.4];
        let path = curve(&FRAME, &[0.0, 0.2, 0.4, 0.6, 0.8, 1.0], &y);
        assert_eq!(path.lone, [vec![0.0, 1.0], vec![0.1, 0.4]]);
        assert_eq!(path.lines.len(), 1);
        let dots: Vec<Shape> = path.dots(&FRAME, Color(0, 0, 0)).collect();
        assert!(matches!(&dots[..], [Shape::Dots { runs, .. }] if runs.runs.len() == 2));
    }

    #[test]
    fn thinning_keeps_a_single_sample_spike() {
        let n = 100_000;
        let x: Vec<f64> = (0..n).map(|i| f64::from(i) / f64::from(n)).collect();
        let mut y = vec![0.2; x.len()];
        y[54_321] = 0.9;
        let path = curve(&FRAME, &x, &y);
        let points: usize = path.lines.iter().chain(&path.bands).map(Vec::len).sum();
        assert!(points < 4 * 501);
        let highest = path
            .bands
            .iter()
            .flatten()
            .map(|p| p[1])
            .fold(f64::MAX, f64::min);
        assert!((highest - FRAME.place(0.0, 0.9)[1]).abs() < 1e-9);
    }

    #[test]
    fn what_takes_no_time_is_in_the_band_and_not_in_the_mean() {
        let (mut x, mut y) = (Vec::new(), Vec::new());
        for i in 0..8000 {
            let t = f64::from(i) / 8000.0;
            x.extend([t; 4]);
            y.extend([0.4, 0.1, 0.9, 0.4]);
        }
        let path = curve(&FRAME, &x, &y);
        let mean = FRAME.place(0.0, 0.4)[1];
        assert!(
            path.lines
                .iter()
                .flatten()
                .all(|p| (p[1] - mean).abs() < 1e-9)
        );
        let ends = [0.1, 0.9].map(|v| FRAME.place(0.0, v)[1]);
        assert!(
            path.bands
                .iter()
                .flatten()
                .all(|p| ends.iter().any(|e| (p[1] - e).abs() < 1e-9))
        );
    }

    #[test]
    fn every_point_in_the_frame_has_a_dot() {
        let x = [0.1, 0.1, 0.5, 2.0, f64::NAN];
        let y = [0.1, 0.1, 0.5, 0.5, 0.5];
        let thin = cells(&FRAME, &x, &y, 1000, true);
        assert_eq!(thin.shades.iter().map(|s| s.runs.len()).sum::<usize>(), 2);
    }

    #[test]
    fn the_bound_on_runs_holds_on_noise() {
        let mut state = 1_u64;
        let mut next = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            f64::from(u32::try_from(state >> 33).unwrap_or(0)) / f64::from(1_u32 << 31)
        };
        let (x, y): (Vec<f64>, Vec<f64>) = (0..80_000).map(|_| (next(), next())).unzip();
        for bound in [40_000, 5_000] {
            let thin = cells(&FRAME, &x, &y, bound, true);
            assert!(thin.shades.iter().map(|s| s.runs.len()).sum::<usize>() <= bound);
        }
    }
}
