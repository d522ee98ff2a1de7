//! Every effect of the catalogue as a direction off the tangent of the re-fitted base.

use crate::baseline::Baseline;
use crate::blocks::Blocks;
use crate::context::{Context, Values, with};
use crate::stack::Runner;
use crate::tangent::dot;
use dgd_assembly::{EffectParameter, Hypothesis};
use std::sync::Arc;

/// Standard deviations at which an effect shows.
pub(crate) const SHOWS: f64 = 5.0;

/// An effect at one strength and shape.
#[derive(Debug, Clone)]
pub(crate) struct Point {
    /// Parameters from which a fit would start.
    pub values: Vec<f64>,
    /// Those of the base beside it.
    pub from: Arc<Values>,
    /// Share of the residual's square that goes, linearly, strength within its bounds.
    pub gain: f64,
    /// Square of the whitened score: chi-square of 1 if nothing is left out.
    pub score: f64,
    /// Change of the readings off the tangent, scaled.
    pub direction: Vec<f64>,
}

/// How an effect fared.
#[derive(Debug, Clone)]
pub(crate) struct Screened {
    /// Number of the hypothesis.
    pub number: usize,
    /// The best by gain, then by score; at most three.
    pub points: Vec<Point>,
    /// Greatest share of a change that a re-fit cannot make.
    pub kept: f64,
    /// Smallest strength, as distance from neutral, that would show at five standard deviations.
    pub limit: f64,
    /// Whether anything moved at any strength.
    pub moves: bool,
    /// Greatest whitened score.
    pub score: f64,
    /// Greatest linear gain.
    pub gain: f64,
    /// For the gate: by grid point, block sums of direction times residual, whitened and plain.
    pub sums: Vec<(Vec<f64>, Vec<f64>)>,
}

impl Screened {
    /// Whether a re-fit of the base takes up nearly all that it does.
    pub(crate) fn absorbed(&self) -> bool {
        self.moves && self.kept < 1e-4
    }

    /// Whether it is worth a fit.
    pub(crate) fn usable(&self) -> bool {
        self.moves && self.kept >= 1e-4 && !self.points.is_empty()
    }
}

/// Most strengths and shapes of one effect.
pub(crate) const MOST: usize = 48;
/// The same beside effects that are in already, besides those that were best without.
pub(crate) const FEWER: usize = 10;

/// Strengths and shapes at which an effect is looked at.
pub(crate) fn grid(h: &Hypothesis, most: usize) -> Vec<Vec<f64>> {
    let Some(first) = h.parameters.first() else {
        return Vec::new();
    };
    let mut grid: Vec<Vec<f64>> = strengths(first).into_iter().map(|s| vec![s]).collect();
    let per = match h.parameters.len() {
        0..=2 => 4,
        _ => 3,
    };
    for p in &h.parameters[1..] {
        let shapes = shapes(p, per);
        grid = grid
            .iter()
            .flat_map(|g| {
                shapes.iter().map(move |s| {
                    let mut v = g.clone();
                    v.push(*s);
                    v
                })
            })
            .collect();
    }
    let stride = grid.len().div_ceil(most).max(1);
    grid.into_iter().step_by(stride).collect()
}

fn strengths(p: &EffectParameter) -> Vec<f64> {
    if !p.neutral.is_finite() {
        return (0..11)
            .map(|k| p.low + (p.high - p.low) * (f64::from(k) + 0.5) / 11.0)
            .collect();
    }
    let away = p.usual - p.neutral;
    let away = if away == 0.0 {
        0.1 * (p.high - p.low)
    } else {
        away
    };
    let mut all = Vec::new();
    for factor in [1.0, 4.0, -1.0, -4.0] {
        let s = (p.neutral + factor * away).clamp(p.low, p.high);
        let known = all
            .iter()
            .any(|a: &f64| (a - s).abs() < 1e-9 * (p.high - p.low));
        if !known && (s - p.neutral).abs() > 1e-6 * (p.high - p.low) {
            all.push(s);
        }
    }
    all
}

fn shapes(p: &EffectParameter, n: i32) -> Vec<f64> {
    let share = |k: i32| (f64::from(k) + 0.5) / f64::from(n);
    if p.low > 0.0 && p.high / p.low > 20.0 {
        return (0..n)
            .map(|k| p.low * (p.high / p.low).powf(share(k)))
            .collect();
    }
    (0..n)
        .map(|k| p.low + (p.high - p.low) * share(k))
        .collect()
}

/// Screens hypotheses beside what is in the base already.
pub(crate) fn screen(
    context: &Context<'_>,
    base: &Baseline,
    blocks: &Blocks,
    numbers: &[usize],
) -> Vec<Screened> {
    let from = Arc::new(base.values.clone());
    context.threads.map(numbers, |&number| {
        let grid = grid(&context.hypotheses[number], MOST);
        one(context, base, &from, blocks, number, &grid)
    })
}

/// Screens again what was screened before, on a coarser grid and where it was best.
pub(crate) fn screen_again(
    context: &Context<'_>,
    base: &Baseline,
    blocks: &Blocks,
    known: &[&Screened],
) -> Vec<Screened> {
    let from = Arc::new(base.values.clone());
    context.threads.map(known, |s| {
        let mut grid = grid(&context.hypotheses[s.number], FEWER);
        grid.extend(s.points.iter().map(|p| p.values.clone()));
        one(context, base, &from, blocks, s.number, &grid)
    })
}

/// Screens again, from inside the bounds, what the re-fitted base on its bounds could not show: an effect on friction does
/// nothing where the fit has made friction zero.
pub(crate) fn screen_inside(
    context: &Context<'_>,
    inside: &Baseline,
    blocks: &Blocks,
    screened: &mut [Screened],
) {
    let numbers: Vec<usize> = screened
        .iter()
        .filter(|s| !s.usable())
        .map(|s| s.number)
        .collect();
    for again in screen(context, inside, blocks, &numbers) {
        if let Some(s) = screened.iter_mut().find(|s| s.number == again.number)
            && again.usable()
        {
            // The gate asks what is left of the base as fitted: there this one has no say.
            *s = Screened {
                sums: Vec::new(),
                ..again
            };
        }
    }
}

fn one(
    context: &Context<'_>,
    base: &Baseline,
    from: &Arc<Values>,
    blocks: &Blocks,
    number: usize,
    grid: &[Vec<f64>],
) -> Screened {
    let mut screened = Screened {
        number,
        points: Vec::new(),
        kept: 0.0,
        limit: f64::INFINITY,
        moves: false,
        score: 0.0,
        gain: 0.0,
        sums: Vec::new(),
    };
    let h = &context.hypotheses[number];
    let mut members = base.members.clone();
    members.push(number);
    let Some(built) = context.build(&members) else {
        return screened;
    };
    let Ok(mut runner) = Runner::new(&built, context.data, &context.simulation) else {
        return screened;
    };
    let total = dot(&base.off, &base.off).max(1e-300);
    let mut best = Best::default();
    for values in grid {
        let start = Context::start(&built, &with(&base.values, h, values));
        let Some(simulated) = start.and_then(|(_, theta, _)| runner.run(&theta)) else {
            continue;
        };
        let there = context.residual(simulated);
        let change: Vec<f64> = there
            .iter()
            .zip(&base.residual)
            .map(|(a, b)| a - b)
            .collect();
        let size = dot(&change, &change);
        let white_change = base.noise.whiten(context.data, &change);
        // A thousandth of the noise in all is nothing.
        if !(size > 0.0) || dot(&white_change, &white_change) < 1e-6 {
            continue;
        }
        screened.moves = true;
        let off = base.tangent.off(&change);
        let square = dot(&off, &off);
        screened.kept = screened.kept.max(square / size);
        let white = base.white_tangent.off(&white_change);
        let white_square = dot(&white, &white);
        if square < 1e-6 * size || !(white_square > 0.0) {
            continue;
        }
        let first = &h.parameters[0];
        // The residual is simulated less measured: the effect must take it away.
        let slope = -dot(&off, &base.off);
        let (low, high) = multiples(first, values[0]);
        let times = (slope / square).clamp(low, high);
        let gain = (2.0 * times * slope - times * times * square) / total;
        let score = dot(&white, &base.white_off).powi(2) / white_square;
        if first.neutral.is_finite() {
            let limit = SHOWS * (values[0] - first.neutral).abs() / white_square.sqrt();
            screened.limit = screened.limit.min(limit);
        }
        screened.sums.push((
            blocks.fine(&white, &base.white_off, 1.0 / white_square.sqrt()),
            blocks.coarse(&off, &base.off, 1.0 / square.sqrt()),
        ));
        screened.score = screened.score.max(score);
        screened.gain = screened.gain.max(gain);
        best.add(Point {
            values: scaled(first, values, times),
            from: Arc::clone(from),
            gain,
            score,
            direction: off,
        });
    }
    screened.points = best.into_points();
    screened
}

/// How many times the change at a strength the effect may make within its bounds.
fn multiples(first: &EffectParameter, strength: f64) -> (f64, f64) {
    if !first.neutral.is_finite() {
        return (0.3, 2.0);
    }
    let away = strength - first.neutral;
    let a = (first.low - first.neutral) / away;
    let b = (first.high - first.neutral) / away;
    (a.min(b), a.max(b))
}

/// The values of a grid point, `times` as strong; never none.
fn scaled(first: &EffectParameter, values: &[f64], times: f64) -> Vec<f64> {
    let mut start = values.to_vec();
    if first.neutral.is_finite() {
        let away = values[0] - first.neutral;
        start[0] = first.neutral + times * away;
        if start[0] == first.neutral {
            start[0] = first.neutral + 0.1 * away;
        }
    }
    start
}

/// The two best by gain, and the best by score.
#[derive(Default)]
struct Best {
    by_gain: Vec<Point>,
    by_score: Option<Point>,
}

impl Best {
    fn add(&mut self, point: Point) {
        if self.by_score.as_ref().is_none_or(|b| point.score > b.score) {
            self.by_score = Some(point.clone());
        }
        self.by_gain.push(point);
        self.by_gain.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        self.by_gain.truncate(2);
    }

    fn into_points(self) -> Vec<Point> {
        let mut points = self.by_gain;
        if let Some(point) = self.by_score
            && points.iter().all(|p| p.values != point.values)
        {
            points.push(point);
        }
        points
    }
}
