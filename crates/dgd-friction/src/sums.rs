//! The sums of a sweep's normal equations, all delays in one walk along the recording.

use crate::CONDITION_LIMIT;
use crate::fit::{BATCH, Samples};
use crate::polynomial::fill_terms;
use dgd_lsq::Accumulator;
use rayon::prelude::*;

/// Delays correlated at once: their sums stay in registers.
const LANES: usize = 16;

/// Samples summed before the sums are added up: keeps rounding from growing with the recording.
const CHUNK: usize = 4096;

/// Everything the normal equations need, per delay.
pub(crate) struct Sums {
    p: usize,
    /// From the basis back to the regressors, p×p.
    triangle: Vec<f64>,
    pub(crate) n: Vec<u64>,
    /// Σ F², per delay.
    square: Vec<f64>,
    /// Σ z_i z_j, per delay p×p.
    gram: Vec<f64>,
    /// Σ z_j F, per delay p.
    cross: Vec<f64>,
}

/// What the sums are taken of.
#[derive(Clone, Copy)]
pub(crate) struct Problem<'a> {
    pub(crate) samples: &'a Samples<'a>,
    pub(crate) powers: &'a [f64],
    /// From the regressors to the basis, p×p, row-major, upper triangle.
    pub(crate) inverse: &'a [f64],
    /// First delay, samples.
    pub(crate) first: i64,
    /// Delays.
    pub(crate) count: usize,
}

impl Problem<'_> {
    /// The flow at places of the delayed grid from `from` on, and whether it is usable; 0 where not. Delay `d` pairs
    /// place `t + d` with friction sample `t`.
    fn flows(&self, from: usize, q: &mut [f64], usable: &mut [bool]) {
        q.fill(0.0);
        usable.fill(false);
        let flow_m3_s = self.samples.flow_m3_s;
        let at = |place: usize| {
            let at = i64::try_from(place).unwrap_or(i64::MAX);
            usize::try_from(at.saturating_add(self.first)).unwrap_or(0)
        };
        // Places before the first sample come first of all.
        let before = usize::try_from(-self.first).unwrap_or(0);
        let skip = before.saturating_sub(from).min(q.len());
        let (start, end) = (at(from + skip), at(from + q.len()).min(flow_m3_s.len()));
        let inside = start.min(end)..end;
        let sources = flow_m3_s[inside.clone()]
            .iter()
            .zip(&self.samples.keep[inside]);
        let places = q[skip..].iter_mut().zip(&mut usable[skip..]);
        for ((q, usable), (flow, keep)) in places.zip(sources) {
            *usable = flow.is_finite() & (*keep | !self.samples.keep_delayed);
            *q = if *usable { *flow } else { 0.0 };
        }
    }
}

/// Basis columns over a stretch of the delayed grid that moves along: an array of the whole recording would cost more to
/// write and read back than to work out where it is needed.
struct Strip<'a> {
    problem: Problem<'a>,
    /// Columns worked out; the ones before the first are not.
    columns: std::ops::Range<usize>,
    /// Places held: of each column, from the same place on.
    places: std::ops::Range<usize>,
    room: usize,
    z: Vec<Vec<f64>>,
    usable: Vec<bool>,
}

impl<'a> Strip<'a> {
    fn new(problem: Problem<'a>, columns: std::ops::Range<usize>) -> Self {
        // Twice what is asked for at most, so that what is kept is moved once in so many places.
        let room = 2 * (CHUNK + problem.count + LANES);
        Self {
            problem,
            places: 0..0,
            room,
            z: vec![vec![0.0; room]; columns.len()],
            usable: vec![false; room],
            columns,
        }
    }

    /// Holds a chunk and what lies up to all delays after it; places only move on. Returns where it starts.
    fn reach(&mut self, from: usize, to: usize) -> usize {
        let to = to + self.problem.count + LANES;
        if to > self.places.end {
            let kept = from.max(self.places.start)..self.places.end.max(from);
            let moved = kept.start.min(self.places.end) - self.places.start..self.places.len();
            for column in &mut self.z {
                column.copy_within(moved.clone(), 0);
            }
            self.usable.copy_within(moved, 0);
            self.places = kept.start..kept.start + self.room;
            self.fill(kept.end);
        }
        from - self.places.start
    }

    /// Works out the columns from a place to the end; 0 where the flow is not usable.
    fn fill(&mut self, from: usize) {
        let mut q = [0.0; BATCH];
        let mut x = [0.0; BATCH];
        for from in (from..self.places.end).step_by(BATCH) {
            let to = self.places.end.min(from + BATCH);
            let at = from - self.places.start;
            let (q, x) = (&mut q[..to - from], &mut x[..to - from]);
            let usable = &mut self.usable[at..][..to - from];
            self.problem.flows(from, q, usable);
            for column in &mut self.z {
                column[at..][..to - from].fill(0.0);
            }
            for (i, power) in self.problem.powers.iter().enumerate() {
                if *power == 0.0 {
                    x.iter_mut()
                        .zip(usable.iter())
                        .for_each(|(x, u)| *x = f64::from(*u));
                } else {
                    fill_terms(x, q, *power);
                }
                for (j, column) in self.columns.clone().zip(&mut self.z) {
                    if j < i {
                        continue;
                    }
                    let share = self.problem.inverse[i * self.problem.powers.len() + j];
                    for (z, x) in column[at..].iter_mut().zip(x.iter()) {
                        *z += x * share;
                    }
                }
            }
        }
    }
}

impl Sums {
    pub(crate) fn of(problem: Problem<'_>, triangle: &[f64]) -> Self {
        let Problem { samples, count, .. } = problem;
        let p = problem.powers.len();
        let runs = runs(samples.keep);
        let mut sums = Self {
            p,
            triangle: triangle.to_vec(),
            n: vec![0; count],
            square: vec![0.0; count],
            gram: vec![0.0; count * p * p],
            cross: vec![0.0; count * p],
        };
        // Side by side, each in its own order: the number of cores changes no digit.
        let (crosses, ()) = rayon::join(
            || -> Vec<Vec<f64>> {
                let of = |j: usize| crosses(problem, j, &runs);
                (0..p).into_par_iter().map(of).collect()
            },
            || {
                sums.autos(problem, &runs);
                sums.squares(problem, &runs);
            },
        );
        for (j, column) in crosses.iter().enumerate() {
            for (d, cross) in column.iter().enumerate() {
                sums.cross[d * p + j] = *cross;
            }
        }
        sums
    }

    /// Gram matrices and counts: the window of each kept run slides by one sample per delay.
    fn autos(&mut self, problem: Problem<'_>, runs: &[(usize, usize)]) {
        let (p, count) = (self.p, problem.count);
        let mut strip = Strip::new(problem, 0..p);
        let mut gram = vec![0.0; p * p];
        let mut n = 0_u64;
        // What each delay adds to the one before.
        let mut steps = vec![0.0; count * p * p];
        let (mut come_in, mut gone_out) = (vec![0_u64; count], vec![0_u64; count]);
        // The start of the run in the basis, until its end is known.
        let mut opening = vec![vec![0.0; count]; p];
        let mut of_run = vec![0.0; p * p];
        for &(start, end) in runs {
            of_run.fill(0.0);
            for from in (start..end).step_by(CHUNK) {
                let to = end.min(from + CHUNK);
                let at = strip.reach(from, to);
                let here = at..at + (to - from);
                let usable = strip.usable[here.clone()].iter();
                n += usable.map(|u| u64::from(*u)).sum::<u64>();
                for i in 0..p {
                    for j in i..p {
                        of_run[i * p + j] +=
                            dot(&strip.z[i][here.clone()], &strip.z[j][here.clone()]);
                    }
                }
                if from == start {
                    for (opening, z) in opening.iter_mut().zip(&strip.z) {
                        opening.copy_from_slice(&z[at..][..count]);
                    }
                    let usable = &strip.usable[at..][..count];
                    for (gone, usable) in gone_out.iter_mut().zip(usable) {
                        *gone += u64::from(*usable);
                    }
                }
                if to == end {
                    let usable = &strip.usable[here.end..][..count];
                    for (come, usable) in come_in.iter_mut().zip(usable) {
                        *come += u64::from(*usable);
                    }
                    for (k, step) in steps.chunks_exact_mut(p * p).enumerate() {
                        for i in 0..p {
                            let (come_i, out_i) = (strip.z[i][here.end + k], opening[i][k]);
                            for j in i..p {
                                let (come_j, out_j) = (strip.z[j][here.end + k], opening[j][k]);
                                step[i * p + j] += come_i * come_j - out_i * out_j;
                            }
                        }
                    }
                }
            }
            for (gram, of_run) in gram.iter_mut().zip(&of_run) {
                *gram += of_run;
            }
        }
        for d in 0..count {
            if let Some(k) = d.checked_sub(1) {
                n = n + come_in[k] - gone_out[k];
                for (g, s) in gram.iter_mut().zip(&steps[k * p * p..][..p * p]) {
                    *g += s;
                }
            }
            self.n[d] = n;
            self.gram[d * p * p..][..p * p].copy_from_slice(&gram);
        }
    }

    /// Σ F² over the rows used: all kept rows less those whose flow is not usable.
    fn squares(&mut self, problem: Problem<'_>, runs: &[(usize, usize)]) {
        let f = problem.samples.friction_pa;
        let all: f64 = runs
            .iter()
            .flat_map(|&(start, end)| f[start..end].chunks(CHUNK))
            .map(|chunk| dot(chunk, chunk))
            .sum();
        let count = self.square.len();
        let mut lost = vec![0.0; count];
        let n = f.len();
        let (mut q, mut usable) = ([0.0; BATCH], [false; BATCH]);
        for from in (0..n + count).step_by(BATCH) {
            problem.flows(from, &mut q, &mut usable);
            if usable.iter().fold(true, |all, u| all & u) {
                continue;
            }
            let places = (from..n + count).zip(&usable);
            for place in places.filter(|(_, u)| !**u).map(|(place, _)| place) {
                // Delay d pairs this place with friction sample `place - d`.
                let least = (place + 1).saturating_sub(n);
                for (d, lost) in lost.iter_mut().enumerate().take(place + 1).skip(least) {
                    let t = place - d;
                    if problem.samples.keep[t] {
                        *lost += f[t] * f[t];
                    }
                }
            }
        }
        for (square, lost) in self.square.iter_mut().zip(lost) {
            *square = all - lost;
        }
    }

    /// Mean squared error at a delay by Cholesky of its Gram matrix; NaN if that fails.
    pub(crate) fn mse(&self, d: usize) -> f64 {
        let p = self.p;
        let gram = &self.gram[d * p * p..][..p * p];
        let mut half = vec![0.0; p * p];
        let mut rest = self.square[d];
        let mut reduced = vec![0.0; p];
        for j in 0..p {
            for i in 0..=j {
                let sum: f64 = (0..i).map(|k| half[k * p + i] * half[k * p + j]).sum();
                let left = gram[i * p + j] - sum;
                if i < j {
                    half[i * p + j] = left / half[i * p + i];
                } else if left > 0.0 {
                    half[j * p + j] = left.sqrt();
                } else {
                    return f64::NAN;
                }
            }
            let sum: f64 = (0..j).map(|k| half[k * p + j] * reduced[k]).sum();
            reduced[j] = (self.cross[d * p + j] - sum) / half[j * p + j];
            rest -= reduced[j] * reduced[j];
        }
        if !self.is_excited(&half) {
            return f64::NAN;
        }
        match self.n[d].checked_sub(p as u64) {
            #[expect(clippy::cast_precision_loss, reason = "row counts stay far below 2^53")]
            Some(degrees) if degrees > 0 => rest.max(0.0) / degrees as f64,
            _ => f64::NAN,
        }
    }

    /// Whether [`fit_checked`](crate::fit::fit_checked) would take the regressors whose triangle in the basis is `half`.
    ///
    /// Where they cannot be told apart, rounding of the sums leaves a condition far above the limit.
    fn is_excited(&self, half: &[f64]) -> bool {
        let p = self.p;
        let Ok(mut rows) = Accumulator::new((0..p).map(|j| j.to_string())) else {
            return false;
        };
        // A row of zeros makes one more than columns; the condition does not see it.
        let pushed = (0..=p).all(|i| {
            let product = |j| {
                (i..p)
                    .map(|k| half[i * p + k] * self.triangle[k * p + j])
                    .sum()
            };
            let row: Vec<f64> = (0..p).map(product).collect();
            rows.push(&row, 0.0).is_ok()
        });
        pushed && rows.reduce().solve(CONDITION_LIMIT).is_ok()
    }
}

/// Σ F(t) z_j(t + d) for every delay: a correlation over the kept runs.
fn crosses(problem: Problem<'_>, j: usize, runs: &[(usize, usize)]) -> Vec<f64> {
    let (f, count) = (problem.samples.friction_pa, problem.count);
    let mut strip = Strip::new(problem, j..j + 1);
    let mut totals = vec![[0.0; LANES]; count.div_ceil(LANES)];
    for &(start, end) in runs {
        for from in (start..end).step_by(CHUNK) {
            let to = end.min(from + CHUNK);
            let at = strip.reach(from, to);
            for (d0, total) in (0..).step_by(LANES).zip(&mut totals) {
                let z = &strip.z[0][at + d0..];
                let mut sum = [0.0; LANES];
                for (y, window) in f[from..to].iter().zip(z.windows(LANES)) {
                    for (s, z) in sum.iter_mut().zip(window) {
                        *s += y * z;
                    }
                }
                for (t, s) in total.iter_mut().zip(sum) {
                    *t += s;
                }
            }
        }
    }
    let mut cross: Vec<f64> = totals.into_iter().flatten().collect();
    cross.truncate(count);
    cross
}

/// Eight partial sums: the compiler may not reorder a sum, so the order is spelled out.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    for (x, y) in a.chunks(8).zip(b.chunks(8)) {
        for ((s, x), y) in sums.iter_mut().zip(x).zip(y) {
            *s += x * y;
        }
    }
    sums.iter().sum()
}

/// Half-open runs of kept samples.
fn runs(keep: &[bool]) -> Vec<(usize, usize)> {
    let mut runs = Vec::new();
    let mut start = None;
    for (t, kept) in keep.iter().copied().chain([false]).enumerate() {
        match (kept, start) {
            (true, None) => start = Some(t),
            (false, Some(from)) => {
                runs.push((from, t));
                start = None;
            }
            _ => {}
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_half_open_and_reach_both_ends() {
        let keep = [true, true, false, true, false, false, true];
        assert_eq!(runs(&keep), [(0, 2), (3, 4), (6, 7)]);
        assert_eq!(runs(&[false; 3]), []);
    }
}
