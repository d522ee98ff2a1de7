//! Figure 3.10: where the search for the exponents went.

use crate::axis::{Axis, roomy, short};
use crate::color::{Color, FRAME, INK, PAPER, Role, SOFT_INK, sequence, tone};
use crate::data::same_length;
use crate::error::ReportError;
use crate::figure::Figure;
use crate::font::text_width;
use crate::panel::{Drawn, LEGEND, Line, Panel, Stack, TICK, draw};
use crate::scene::{Anchor, Pen, Shape};
use crate::thin::Frame;

/// Points of the path that are drawn one by one; a longer path is thinned evenly.
const MOST_STEPS: usize = 2000;
const MOST_GRID: usize = 250_000;

/// Exponents tried, in the order of the search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SearchPath<'a> {
    /// Exponent of the speed, shape `(n,)`.
    pub n0: &'a [f64],
    /// Exponent of the flow, shape `(n,)`.
    pub n2: &'a [f64],
    /// Cost at each point, shape `(n,)`; not finite where the constraints refused it. Empty if not known.
    pub cost: &'a [f64],
}

/// The cost on a grid of exponents, for contours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CostGrid<'a> {
    /// Speed exponents, increasing, shape `(a,)`.
    pub n0: &'a [f64],
    /// Flow exponents, increasing, shape `(b,)`.
    pub n2: &'a [f64],
    /// Cost at `(n0[i], n2[j])` in `cost[j * a + i]`, shape `(a·b,)`; not finite where refused.
    pub cost: &'a [f64],
}

/// Figure 3.10: the search path over `(n0, n2)`, coloured by cost, over contours of the cost if a grid is given.
///
/// # Errors
/// [`ReportError::Length`] on unequal slices, [`ReportError::TooMany`] for a grid above 250,000 points,
/// [`ReportError::Range`] on a cost axis range that cannot be drawn.
pub fn exponent_search(
    path: &SearchPath<'_>,
    grid: Option<&CostGrid<'_>>,
    cost: &Axis,
) -> Result<Figure, ReportError> {
    same_length("path.n2", path.n0, path.n2)?;
    if !path.cost.is_empty() {
        same_length("path.cost", path.n0, path.cost)?;
    }
    if let Some(grid) = grid {
        check_grid(grid)?;
    }
    let steps = steps(path);
    let shades = Shades::over(&steps, grid, cost)?;
    let contours: Vec<(f64, [Vec<f64>; 2])> =
        grid.zip(shades.as_ref())
            .map_or_else(Vec::new, |(grid, shades)| {
                shades
                    .levels()
                    .into_iter()
                    .map(|level| (level, contour(grid, level)))
                    .collect()
            });
    let accepted: [Vec<f64>; 2] = steps
        .iter()
        .filter(|s| !s.refused)
        .map(|s| (s.n0, s.n2))
        .collect::<(_, _)>()
        .into();

    let (x, y) = (around(&steps, |s| s.n0), around(&steps, |s| s.n2));
    let axis = |label: &str, range: Option<[f64; 2]>| Axis {
        label: label.to_owned(),
        range,
    };
    let mut panel = Panel::new(&axis("Exponent of the flow, n₂", y), 380.0);
    panel.empty = "No search step to show";
    for (level, [cx, cy]) in &contours {
        let color = shades
            .as_ref()
            .map_or(FRAME, |s| tone(s.color(*level), 0.55));
        panel.lines.push(Line {
            counted: false,
            ..Line::new(cx, cy, Pen::new(color, 1.1))
        });
    }
    panel.lines.push(Line {
        counted: false,
        ..Line::new(&accepted[0], &accepted[1], Pen::new(SOFT_INK, 1.0))
    });
    let mut stack = Stack::new(&axis("Exponent of the speed, n₀", x), vec![panel]);
    stack.side_room = if shades.is_some() { 84.0 } else { 0.0 };
    let mut drawn = draw(&stack)?;
    if let Some(frame) = drawn.frames.first().copied() {
        draw_steps(&mut drawn, &frame, &steps, shades.as_ref());
        if let Some(shades) = &shades {
            bar(&mut drawn, &frame, shades, &cost.label);
        }
    }
    Ok(Figure::new(
        "3.10",
        caption(path, &steps, grid.is_some(), cost),
        drawn,
    ))
}

#[derive(Clone, Copy)]
struct Step {
    n0: f64,
    n2: f64,
    cost: Option<f64>,
    refused: bool,
}

fn check_grid(grid: &CostGrid<'_>) -> Result<(), ReportError> {
    let expected = grid.n0.len().saturating_mul(grid.n2.len());
    if expected > MOST_GRID {
        return Err(ReportError::TooMany {
            what: "grid points",
            found: expected,
            most: MOST_GRID,
        });
    }
    if grid.cost.len() != expected {
        return Err(ReportError::Length {
            name: "grid.cost",
            expected,
            found: grid.cost.len(),
        });
    }
    Ok(())
}

fn steps(path: &SearchPath<'_>) -> Vec<Step> {
    let stride = path.n0.len().div_ceil(MOST_STEPS).max(1);
    let last = path.n0.len().saturating_sub(1);
    (0..path.n0.len())
        .filter(|i| i % stride == 0 || *i == last)
        .map(|i| {
            let cost = path.cost.get(i).copied();
            Step {
                n0: path.n0[i],
                n2: path.n2[i],
                cost: cost.filter(|c| c.is_finite()),
                refused: cost.is_some_and(|c| !c.is_finite()),
            }
        })
        .filter(|s| s.n0.is_finite() && s.n2.is_finite())
        .collect()
}

fn around(steps: &[Step], of: impl Fn(&Step) -> f64) -> Option<[f64; 2]> {
    let (low, high) = steps
        .iter()
        .map(of)
        .fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
    let margin = (0.13 * (high - low)).max(1e-3 * high.abs()).max(1e-6);
    let range = [low - margin, high + margin];
    (low <= high && (range[1] - range[0]).is_finite()).then_some(range)
}

/// Cost to colour; logarithmic where the cost spans more than a factor of two, as the start is mostly far off.
struct Shades {
    low: f64,
    high: f64,
    log: bool,
}

impl Shades {
    fn over(
        steps: &[Step],
        grid: Option<&CostGrid<'_>>,
        axis: &Axis,
    ) -> Result<Option<Self>, ReportError> {
        let given = crate::axis::given(axis)?;
        let costs = steps.iter().filter_map(|s| s.cost);
        let mut all: Vec<f64> = costs.collect();
        if all.is_empty() {
            all.extend(grid.iter().flat_map(|g| g.cost).filter(|c| c.is_finite()));
        }
        let range = given.or_else(|| {
            let low = all.iter().copied().min_by(f64::total_cmp)?;
            Some([low, all.iter().copied().max_by(f64::total_cmp)?])
        });
        // One cost alone still needs a scale around it.
        let wide = |[low, high]: [f64; 2]| {
            if high > low {
                [low, high]
            } else {
                roomy(Some([low, high]))
            }
        };
        Ok(range
            .map(wide)
            .filter(|r| (r[1] - r[0]).is_finite())
            .map(|[low, high]| {
                let log = low > 0.0 && high > 2.0 * low;
                Self { low, high, log }
            }))
    }

    fn share(&self, cost: f64) -> f64 {
        let f = |v: f64| if self.log { v.ln() } else { v };
        ((f(cost.clamp(self.low, self.high)) - f(self.low)) / (f(self.high) - f(self.low)))
            .clamp(0.0, 1.0)
    }

    /// Dark is good: the eye finds the bottom of the valley.
    fn color(&self, cost: f64) -> Color {
        sequence(self.share(cost))
    }

    fn at(&self, share: f64) -> f64 {
        let between = |a: f64, b: f64| a + share * (b - a);
        if self.log {
            between(self.low.ln(), self.high.ln()).exp()
        } else {
            between(self.low, self.high)
        }
    }

    fn levels(&self) -> Vec<f64> {
        (1..12).map(|i| self.at(f64::from(i) / 12.0)).collect()
    }

    fn ticks(&self) -> Vec<f64> {
        if !self.log {
            return (0..5).map(|i| self.at(f64::from(i) / 4.0)).collect();
        }
        let leads: &[f64] = if self.high / self.low > 3000.0 {
            &[1.0]
        } else if self.high / self.low > 10.0 {
            &[1.0, 2.0, 5.0]
        } else {
            &[1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0]
        };
        let first = self.low.log10().floor();
        (0..40)
            .flat_map(|i| {
                leads
                    .iter()
                    .map(move |lead| lead * 10f64.powf(first + f64::from(i)))
            })
            .filter(|v| *v >= self.low && *v <= self.high)
            .take(12)
            .collect()
    }
}

fn draw_steps(drawn: &mut Drawn, frame: &Frame, steps: &[Step], shades: Option<&Shades>) {
    for step in steps {
        if !frame.holds(step.n0, step.n2) {
            drawn.outside += 1;
            continue;
        }
        let [x, y] = frame.place(step.n0, step.n2);
        if step.refused {
            let (pen, r) = (Pen::new(Role::Rejected.color(), 1.8), 3.5);
            let arms = vec![
                vec![[x - r, y - r], [x + r, y + r]],
                vec![[x - r, y + r], [x + r, y - r]],
            ];
            drawn.scene.lines(arms, pen);
            continue;
        }
        let fill = step
            .cost
            .zip(shades)
            .map_or(Role::Model.color(), |(cost, shades)| shades.color(cost));
        let rim = Some(Pen::new(PAPER, 0.8));
        drawn.scene.shapes.push(Shape::Circle {
            centre: [x, y],
            radius: 4.2,
            fill: Some(fill),
            pen: rim,
        });
    }
    let mut accepted = steps
        .iter()
        .filter(|s| !s.refused && frame.holds(s.n0, s.n2));
    let ends = [(accepted.next(), "Start"), (accepted.next_back(), "End")];
    let mut taken = Vec::new();
    for (step, word) in ends {
        let Some(step) = step else { continue };
        let [x, y] = frame.place(step.n0, step.n2);
        let ring = Some(Pen::new(INK, 1.8));
        drawn.scene.shapes.push(Shape::Circle {
            centre: [x, y],
            radius: 7.5,
            fill: None,
            pen: ring,
        });
        let words = format!("{word} ({}, {})", short(step.n0), short(step.n2));
        let size = [text_width(&words, LEGEND, true), LEGEND];
        let [left, base] = free_place(frame, [x, y], size, steps, &taken);
        taken.push([left, base]);
        drawn
            .scene
            .rect([left - 3.0, base - 12.0], [size[0] + 6.0, 16.0], PAPER);
        drawn
            .scene
            .bold([left, base], &words, LEGEND, INK, Anchor::Start);
    }
}

/// Where words around a ring hide the fewest steps; left end and base line.
fn free_place(
    frame: &Frame,
    at: [f64; 2],
    size: [f64; 2],
    steps: &[Step],
    taken: &[[f64; 2]],
) -> [f64; 2] {
    let [x, y] = at;
    let [width, height] = size;
    let places: Vec<[f64; 2]> = steps.iter().map(|s| frame.place(s.n0, s.n2)).collect();
    // The steps and what lies between them.
    let between = |pair: &[[f64; 2]], share: f64| {
        [0, 1].map(|k| pair[0][k] + share * (pair[1][k] - pair[0][k]))
    };
    let trail: Vec<[f64; 2]> = places
        .windows(2)
        .flat_map(|pair| (0..=9).map(|i| between(pair, f64::from(i) / 9.0)))
        .collect();
    let mut best = ([x + 13.0, y - 10.0], usize::MAX);
    for distance in [0.0, 10.0, 20.0, 35.0, 50.0, 70.0] {
        for (left, base) in [
            (x + 13.0 + distance, y - 10.0 - distance / 2.0),
            (x + 13.0 + distance, y + 20.0 + distance / 2.0),
            (x - 13.0 - distance - width, y - 10.0 - distance / 2.0),
            (x - 13.0 - distance - width, y + 20.0 + distance / 2.0),
            (x - width / 2.0, y - 16.0 - distance),
            (x - width / 2.0, y + 26.0 + distance),
        ] {
            let (top, bottom) = (base - height - 4.0, base + 8.0);
            let (from, to) = (left - 7.0, left + width + 7.0);
            let out = from < frame.left
                || to > frame.right()
                || top < frame.top
                || bottom > frame.bottom();
            let hidden = trail
                .iter()
                .filter(|p| p[0] > from && p[0] < to && p[1] > top && p[1] < bottom)
                .count();
            let clash = taken
                .iter()
                .any(|t| (t[0] - left).abs() < width && (t[1] - base).abs() < 2.0 * height);
            let cost = hidden + if out { 100_000 } else { 0 } + if clash { 10_000 } else { 0 };
            if cost < best.1 {
                best = ([left, base], cost);
            }
        }
    }
    best.0
}

fn bar(drawn: &mut Drawn, frame: &Frame, shades: &Shades, label: &str) {
    let left = frame.right() + 18.0;
    let slices = 60_u32;
    let height = frame.height / f64::from(slices);
    for slice in 0..slices {
        let share = (f64::from(slice) + 0.5) / f64::from(slices);
        let top = frame.bottom() - f64::from(slice + 1) * height;
        // A hair of overlap hides the seams.
        drawn.scene.rect(
            [left, top],
            [13.0, height + if slice == 0 { 0.0 } else { 0.5 }],
            sequence(share),
        );
    }
    let ticks = shades.ticks();
    for tick in &ticks {
        let y = frame.bottom() - shades.share(*tick) * frame.height;
        drawn
            .scene
            .line([left + 13.0, y], [left + 17.0, y], Pen::new(FRAME, 1.0));
        drawn.scene.text(
            [left + 20.0, y + TICK * 0.36],
            &short(*tick),
            TICK,
            INK,
            Anchor::Start,
        );
    }
    let widest = ticks
        .iter()
        .map(|t| text_width(&short(*t), TICK, false))
        .fold(0.0, f64::max);
    let x = (left + 20.0 + widest + 17.0).min(drawn.scene.width - 5.0);
    drawn
        .scene
        .upright([x, frame.top + frame.height / 2.0], label, TICK, INK);
}

fn caption(path: &SearchPath<'_>, steps: &[Step], contours: bool, cost: &Axis) -> String {
    let refused = path.cost.iter().filter(|c| !c.is_finite()).count();
    let mut text = format!(
        "Search path of the exponents (n₀, n₂) in {} steps",
        path.n0.len()
    );
    let mut accepted = steps.iter().filter(|s| !s.refused);
    if let (Some(first), Some(last)) = (accepted.next(), accepted.next_back()) {
        text.push_str(&format!(
            ", from ({}, {}) to ({}, {})",
            short(first.n0),
            short(first.n2),
            short(last.n0),
            short(last.n2)
        ));
        if let (Some(before), Some(after)) = (first.cost, last.cost) {
            text.push_str(&format!(
                "; {} falls from {} to {}",
                cost.in_sentence(),
                short(before),
                short(after)
            ));
        }
    }
    text.push('.');
    if contours {
        text.push_str(" Thin lines join points of equal cost.");
    }
    if refused > 0 {
        text.push_str(&format!(
            " A red cross is a point rejected by the constraints ({refused})."
        ));
    }
    text
}

/// Marching squares: the segments of one level, parted by NaN.
fn contour(grid: &CostGrid<'_>, level: f64) -> [Vec<f64>; 2] {
    let (mut xs, mut ys) = (Vec::new(), Vec::new());
    let columns = grid.n0.len();
    for j in 1..grid.n2.len() {
        for i in 1..columns {
            let corners = [(i - 1, j - 1), (i, j - 1), (i, j), (i - 1, j)]
                .map(|(i, j)| (grid.n0[i], grid.n2[j], grid.cost[j * columns + i]));
            if corners.iter().any(|c| !c.2.is_finite()) {
                continue;
            }
            let crossings: Vec<(f64, f64)> = (0..4)
                .filter_map(|k| {
                    let (a, b) = (corners[k], corners[(k + 1) % 4]);
                    if (a.2 < level) == (b.2 < level) {
                        return None;
                    }
                    let t = (level - a.2) / (b.2 - a.2);
                    Some((a.0 + t * (b.0 - a.0), a.1 + t * (b.1 - a.1)))
                })
                .collect();
            // Two crossings make one segment, a saddle's four make two.
            for pair in crossings.chunks_exact(2) {
                xs.extend([pair[0].0, pair[1].0, f64::NAN]);
                ys.extend([pair[0].1, pair[1].1, f64::NAN]);
            }
        }
    }
    [xs, ys]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_contour_of_a_bowl_is_a_circle() {
        let axis: Vec<f64> = (-20..=20).map(|i| f64::from(i) / 10.0).collect();
        let cost: Vec<f64> = axis
            .iter()
            .flat_map(|b| axis.iter().map(move |a| a * a + b * b))
            .collect();
        let [x, y] = contour(
            &CostGrid {
                n0: &axis,
                n2: &axis,
                cost: &cost,
            },
            1.0,
        );
        let radii: Vec<f64> = x
            .iter()
            .zip(&y)
            .filter(|(x, _)| x.is_finite())
            .map(|(x, y)| x.hypot(*y))
            .collect();
        assert!(radii.len() > 50);
        // Linear between grid lines 0.1 apart: off by 0.1² / 8 at most.
        assert!(radii.iter().all(|r| (r - 1.0).abs() < 1.3e-3));
    }
}
