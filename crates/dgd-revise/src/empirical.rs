//! Corrections with no physics, which compete with the catalogue: piecewise linear along one quantity, added to a reading
//! or to the inflow of a tank or volume.

use crate::baseline::Baseline;
use crate::blocks::Blocks;
use crate::context::{Context, Trial};
use crate::stack::{Data, Runner, run_once};
use crate::tangent::{Tangent, dot};
use crate::validate::{Folds, LeftOut};
use dgd_assembly::{Assembly, Between, Component, Input, Kind, Setting, Window};
use dgd_lsq::lm::{self, Bounds, Effort, Minimum};
use std::collections::BTreeMap;

/// Where a correction acts.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Place {
    /// On a reading.
    Output(usize),
    /// On the inflow of this component.
    Inflow(String),
}

/// A place, a quantity, and its values in each window.
#[derive(Debug, Clone)]
pub(crate) struct Candidate {
    pub place: Place,
    pub along: String,
    /// By window and sample.
    pub quantity: Vec<Vec<f64>>,
    pub knots: Vec<f64>,
    /// Correction of one unit of a coefficient.
    pub unit: f64,
    /// Share of the residual's square that goes, linearly.
    pub gain: f64,
    /// Block sums for the gate, whitened and plain, by direction.
    pub sums: (Vec<Vec<f64>>, Vec<Vec<f64>>),
}

/// A fitted correction.
#[derive(Debug, Clone)]
pub(crate) struct Corrected {
    pub candidate: Candidate,
    pub minimum: Minimum,
    pub left: LeftOut,
    /// At the knots.
    pub values: Vec<f64>,
}

const KNOTS: usize = 6;
/// Name of the inflow that is added.
const NAME: &str = "empirical_correction";

/// Quantities by name, by window and sample, as simulated by a fitted set.
pub(crate) fn quantities(
    context: &Context<'_>,
    data: &Data,
    members: &[usize],
    theta: &[f64],
) -> Option<Vec<(String, Vec<Vec<f64>>)>> {
    let built = context.build(members)?;
    let mut runner = Runner::new(&built, data, &context.simulation).ok()?;
    let mut all = Vec::new();
    let column = |f: &dyn Fn(usize) -> Vec<f64>| (0..data.windows.len()).map(f).collect();
    all.push((
        context.assembly.system().independent.clone(),
        column(&|w| data.windows[w].time.clone()),
    ));
    for (i, name) in context.assembly.inputs().into_iter().enumerate() {
        all.push((name, column(&|w| data.windows[w].inputs[i].clone())));
    }
    let states = runner.states(theta)?;
    for (i, name) in context.assembly.states().into_iter().enumerate() {
        all.push((name, column(&|w| states[w][i].clone())));
    }
    let outputs = runner.outputs(theta)?;
    for (i, name) in context.assembly.outputs().into_iter().enumerate() {
        all.push((name, column(&|w| outputs[w][i].clone())));
    }
    Some(all)
}

/// Knots at even shares of the samples; fewer than three distinct ones make no shape.
fn knots(quantity: &[Vec<f64>]) -> Option<Vec<f64>> {
    let mut all: Vec<f64> = quantity
        .iter()
        .flatten()
        .copied()
        .filter(|v| v.is_finite())
        .collect();
    all.sort_by(f64::total_cmp);
    let (low, high) = (*all.first()?, *all.last()?);
    let mut knots: Vec<f64> = Vec::new();
    for k in 0..KNOTS {
        let q = all[k * (all.len() - 1) / (KNOTS - 1)];
        if knots.last().is_none_or(|l| q - l > 1e-3 * (high - low)) {
            knots.push(q);
        }
    }
    (knots.len() >= 3).then_some(knots)
}

/// Weights of the two knots around a value.
fn hat(knots: &[f64], z: f64) -> [(usize, f64); 2] {
    let last = knots.len() - 1;
    let right = knots.partition_point(|k| *k <= z).clamp(1, last);
    let share = ((z - knots[right - 1]) / (knots[right] - knots[right - 1])).clamp(0.0, 1.0);
    [(right - 1, 1.0 - share), (right, share)]
}

pub(crate) fn at(knots: &[f64], values: &[f64], z: f64) -> f64 {
    hat(knots, z).iter().map(|&(k, w)| w * values[k]).sum()
}

/// The assembly of a set with an inflow into a component, and the place of that input.
fn with_inflow(
    context: &Context<'_>,
    members: &[usize],
    component: &str,
) -> Option<(Assembly, usize)> {
    let mut system = context.build(members)?.system().clone();
    system.components.insert(
        NAME.into(),
        Component {
            kind: Kind::Boundary,
            settings: BTreeMap::from([("flow".into(), Setting::Number(0.0))]),
        },
    );
    system.connections.push(format!("{NAME} -> {component}"));
    let path = format!("{NAME}.flow");
    system.inputs.insert(
        path.clone(),
        Input {
            channel: NAME.into(),
            between: Between::Held,
            unit: None,
        },
    );
    let built = Assembly::new(system).ok()?;
    let place = built.inputs().iter().position(|p| *p == path)?;
    Some((built, place))
}

/// Runs a set with a correction of given values at the knots; by window, output and sample.
pub(crate) fn run_corrected(
    context: &Context<'_>,
    data: &Data,
    members: &[usize],
    theta: &[f64],
    candidate: &Candidate,
    values: &[f64],
) -> Option<Vec<Vec<Vec<f64>>>> {
    let shift = |w: usize| -> Vec<f64> {
        candidate.quantity[w]
            .iter()
            .map(|z| at(&candidate.knots, values, *z))
            .collect()
    };
    match &candidate.place {
        Place::Output(o) => {
            let built = context.build(members)?;
            let mut runner = Runner::new(&built, data, &context.simulation).ok()?;
            let mut outputs = runner.outputs(theta)?;
            for (w, window) in outputs.iter_mut().enumerate() {
                for (v, s) in window[*o].iter_mut().zip(shift(w)) {
                    *v += s;
                }
            }
            Some(outputs)
        }
        Place::Inflow(component) => {
            let (built, place) = with_inflow(context, members, component)?;
            let mut windows = data.windows.clone();
            for (w, window) in windows.iter_mut().enumerate() {
                window.inputs.insert(place, shift(w));
            }
            let with = Data::new(windows, data.training);
            Runner::new(&built, &with, &context.simulation)
                .ok()?
                .outputs(theta)
        }
    }
}

/// Residuals of a set with a correction, coefficients after the parameters; one set of windows for all runs.
struct Problem<'c, 'a> {
    context: &'c Context<'a>,
    built: Assembly,
    place: Option<usize>,
    candidate: &'c Candidate,
    windows: Vec<Window>,
    parameters: usize,
    stiff: bool,
}

impl<'c, 'a> Problem<'c, 'a> {
    fn new(context: &'c Context<'a>, members: &[usize], candidate: &'c Candidate) -> Option<Self> {
        let mut windows = context.data.windows.clone();
        let (built, place) = match &candidate.place {
            Place::Output(_) => (context.build(members)?, None),
            Place::Inflow(component) => {
                let (built, place) = with_inflow(context, members, component)?;
                for window in &mut windows {
                    window.inputs.insert(place, vec![0.0; window.time.len()]);
                }
                (built, Some(place))
            }
        };
        let parameters = built.parameters().len();
        Some(Self {
            context,
            built,
            place,
            candidate,
            windows,
            parameters,
            stiff: false,
        })
    }

    fn run(&mut self, all: &[f64]) -> Option<Vec<f64>> {
        let (theta, c) = all.split_at(self.parameters);
        let values: Vec<f64> = c.iter().map(|c| c * self.candidate.unit).collect();
        let shift = |w: usize, i: usize| {
            at(
                &self.candidate.knots,
                &values,
                self.candidate.quantity[w][i],
            )
        };
        if let Some(place) = self.place {
            for (w, window) in self.windows.iter_mut().enumerate() {
                for (i, v) in window.inputs[place].iter_mut().enumerate() {
                    *v = shift(w, i);
                }
            }
        }
        let data = self.context.data;
        let mut outputs = Vec::with_capacity(self.windows.len());
        for (number, window) in self.windows.iter().enumerate() {
            let run = run_once(
                &self.built,
                window,
                number,
                theta,
                &self.context.simulation,
                &mut self.stiff,
            )?;
            outputs.push(run.outputs);
        }
        let simulated: Vec<f64> = data
            .rows
            .iter()
            .map(|row| {
                let plain = outputs[row.window][row.output][row.sample];
                match self.candidate.place {
                    Place::Output(o) if o == row.output => plain + shift(row.window, row.sample),
                    _ => plain,
                }
            })
            .collect();
        simulated
            .iter()
            .all(|v| v.is_finite())
            .then(|| self.context.residual(simulated))
    }
}

/// All places and quantities, by linear gain, best first.
pub(crate) fn survey(
    context: &Context<'_>,
    base: &Baseline,
    trial: &Trial,
    blocks: &Blocks,
) -> Vec<Candidate> {
    let Some(quantities) = quantities(context, context.data, &trial.members, &trial.minimum.theta)
    else {
        return Vec::new();
    };
    let mut places: Vec<Place> = (0..context.scale.len())
        .filter(|&o| !context.data.of_output(o).is_empty())
        .map(Place::Output)
        .collect();
    for state in context.assembly.states() {
        if let Some(component) = state
            .strip_suffix(".level")
            .or_else(|| state.strip_suffix(".pressure"))
        {
            places.push(Place::Inflow(component.into()));
        }
    }
    let mut tasks = Vec::new();
    for place in places {
        for (name, quantity) in &quantities {
            if let Some(knots) = knots(quantity) {
                tasks.push(Candidate {
                    place: place.clone(),
                    along: name.clone(),
                    quantity: quantity.clone(),
                    knots,
                    unit: 0.0,
                    gain: 0.0,
                    sums: (Vec::new(), Vec::new()),
                });
            }
        }
    }
    let mut all: Vec<Candidate> = context
        .threads
        .map(&tasks, |task| {
            weigh(context, base, trial, blocks, task.clone())
        })
        .into_iter()
        .flatten()
        .collect();
    all.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    all
}

fn weigh(
    context: &Context<'_>,
    base: &Baseline,
    trial: &Trial,
    blocks: &Blocks,
    mut candidate: Candidate,
) -> Option<Candidate> {
    candidate.unit = 1.0;
    let n = candidate.knots.len();
    let mut change: Vec<Vec<f64>> = Vec::new();
    let total = dot(&base.off, &base.off).max(1e-300);
    match candidate.place {
        Place::Output(o) => {
            candidate.unit = context.scale[o];
            for k in 0..n {
                let column = context
                    .data
                    .rows
                    .iter()
                    .map(|row| {
                        let z = candidate.quantity[row.window][row.sample];
                        let hats = hat(&candidate.knots, z);
                        let weight: f64 =
                            hats.iter().filter(|(i, _)| *i == k).map(|(_, w)| w).sum();
                        if row.output == o { weight } else { 0.0 }
                    })
                    .collect();
                change.push(column);
            }
        }
        Place::Inflow(_) => {
            // A flow of which nobody knows what is usual: one that moves the readings about as far as they are off.
            candidate.unit = 1e-6;
            for _ in 0..12 {
                let fixed = candidate.clone();
                let mut problem = Problem::new(context, &trial.members, &fixed)?;
                let mut theta = trial.minimum.theta.clone();
                theta.extend(std::iter::repeat_n(1.0, n));
                let size = problem.run(&theta).map_or(f64::INFINITY, |there| {
                    let d: Vec<f64> = there
                        .iter()
                        .zip(&base.residual)
                        .map(|(a, b)| a - b)
                        .collect();
                    (dot(&d, &d) / total).sqrt()
                });
                if (0.2..3.0).contains(&size) {
                    break;
                }
                candidate.unit *= if size.is_finite() {
                    (1.0 / size.max(1e-6)).clamp(1e-3, 1e3)
                } else {
                    0.1
                };
            }
            let fixed = candidate.clone();
            let mut problem = Problem::new(context, &trial.members, &fixed)?;
            let mut theta = trial.minimum.theta.clone();
            let p = theta.len();
            theta.extend(std::iter::repeat_n(0.0, n));
            for k in 0..n {
                theta[p + k] = 0.3;
                let there = problem.run(&theta)?;
                change.push(
                    there
                        .iter()
                        .zip(&base.residual)
                        .map(|(a, b)| (a - b) / 0.3)
                        .collect(),
                );
                theta[p + k] = 0.0;
            }
        }
    }
    let directions = Tangent::of(change.iter().map(|c| base.tangent.off(c)));
    candidate.gain = directions.within(&base.off) / total;
    let white = Tangent::of(
        change
            .iter()
            .map(|c| base.white_tangent.off(&base.noise.whiten(context.data, c))),
    );
    candidate.sums = (
        white
            .each()
            .map(|u| blocks.fine(u, &base.white_off, 1.0))
            .collect(),
        directions
            .each()
            .map(|u| blocks.coarse(u, &base.off, 1.0))
            .collect(),
    );
    Some(candidate)
}

/// Times the mean square it must get below at which a candidate is given up after a few steps.
const FAR: f64 = 2.0;
/// Rounds in which the quantity is taken anew from the corrected run.
const ROUNDS: usize = 3;

/// Fits a candidate on top of a set and scores it on left-out blocks. The quantity is that of the corrected run itself, by
/// a few rounds.
///
/// `enough`: the mean square on left-out blocks that it must get below; one that is far off after a few steps is given up.
pub(crate) fn fit(
    context: &Context<'_>,
    folds: &Folds,
    trial: &Trial,
    candidate: &Candidate,
    enough: f64,
) -> Option<Corrected> {
    let n = candidate.knots.len();
    let p = trial.minimum.theta.len();
    let mut bounds: Bounds = trial.bounds.clone();
    bounds.low.extend(std::iter::repeat_n(-1e3, n));
    bounds.high.extend(std::iter::repeat_n(1e3, n));
    let effort = Effort {
        steps: 16,
        tolerance: 1e-3,
        fresh: 6,
        ..crate::baseline::SPARING
    };
    let brief = Effort {
        steps: 6,
        fresh: 2,
        ..effort
    };
    let given = candidate;
    let mut first: Option<Minimum> = None;
    // From the fit without the correction, and from where that began: what it did to make up for the lack may be far from
    // what is right with the correction.
    let declared = Context::start(&context.build(&trial.members)?, &Default::default()).1;
    let mut problem = Problem::new(context, &trial.members, given)?;
    // Beside effects that fit, the fit itself is start enough.
    let starts = if trial.members.is_empty() { 2 } else { 1 };
    for from in [&trial.minimum.theta, &declared].into_iter().take(starts) {
        let mut start = from.clone();
        start.extend(std::iter::repeat_n(0.0, n));
        let found = lm::minimise(
            &mut |t: &[f64]| problem.run(t),
            &start,
            &bounds,
            None,
            None,
            brief,
        );
        if first.as_ref().is_none_or(|b| found.cost < b.cost) {
            first = Some(found);
        }
    }
    let first = first?;
    let mean = 2.0 * first.cost / first.residuals.len().max(1) as f64;
    if !(mean < FAR * enough) {
        return None;
    }
    let best = settle(context, trial, given, &first.theta, &bounds, effort);
    let (candidate, mut minimum) = best?;
    let mut problem = Problem::new(context, &trial.members, &candidate)?;
    minimum.jacobian = lm::differences(
        &mut |t: &[f64]| problem.run(t),
        &minimum.theta,
        &minimum.residuals,
        &bounds,
    );
    let left = folds.score(
        context.data,
        context.scale.len(),
        &mut |t: &[f64]| problem.run(t),
        &minimum.theta,
        &bounds,
        (&minimum.residuals, &minimum.jacobian),
    );
    let values = values(&candidate, &minimum.theta[p..]);
    Some(Corrected {
        candidate,
        minimum,
        left,
        values,
    })
}

/// Rounds of fits, each with the quantity that the last one's run shows; `from` holds the coefficients as well.
fn settle(
    context: &Context<'_>,
    trial: &Trial,
    candidate: &Candidate,
    from: &[f64],
    bounds: &Bounds,
    effort: Effort,
) -> Option<(Candidate, Minimum)> {
    let n = candidate.knots.len();
    let p = trial.minimum.theta.len();
    let mut candidate = candidate.clone();
    let mut start = from.to_vec();
    let mut best: Option<(Candidate, Minimum)> = None;
    for _ in 0..ROUNDS {
        let mut problem = Problem::new(context, &trial.members, &candidate)?;
        let minimum = lm::minimise(
            &mut |t: &[f64]| problem.run(t),
            &start,
            bounds,
            None,
            None,
            effort,
        );
        if !minimum.cost.is_finite() {
            break;
        }
        let values = values(&candidate, &minimum.theta[p..]);
        start.clone_from(&minimum.theta);
        let theta = minimum.theta[..p].to_vec();
        if best.as_ref().is_none_or(|b| minimum.cost < b.1.cost) {
            best = Some((candidate.clone(), minimum));
        } else {
            break;
        }
        // What does not depend on the run stays as it is.
        let Some(quantity) = seen(
            context,
            context.data,
            &trial.members,
            &theta,
            &candidate,
            &values,
        ) else {
            break;
        };
        candidate.quantity = quantity;
        if let Some(knots) = knots(&candidate.quantity).filter(|k| k.len() == n) {
            // The shape found so far, at the knots of the new quantity.
            for (k, z) in knots.iter().enumerate() {
                start[p + k] = at(&candidate.knots, &values, *z) / candidate.unit;
            }
            candidate.knots = knots;
        }
    }
    best
}

fn values(candidate: &Candidate, coefficients: &[f64]) -> Vec<f64> {
    coefficients.iter().map(|c| c * candidate.unit).collect()
}

/// The candidate's quantity as the corrected run over `data` sees it; `None` if it is given (time, an input) or the run
/// fails.
pub(crate) fn seen(
    context: &Context<'_>,
    data: &Data,
    members: &[usize],
    theta: &[f64],
    candidate: &Candidate,
    values: &[f64],
) -> Option<Vec<Vec<f64>>> {
    let state = context
        .assembly
        .states()
        .iter()
        .position(|s| *s == candidate.along);
    let output = context
        .assembly
        .outputs()
        .iter()
        .position(|o| *o == candidate.along);
    let Place::Inflow(component) = &candidate.place else {
        return None;
    };
    let (built, place) = with_inflow(context, members, component)?;
    let mut windows = data.windows.clone();
    for (w, window) in windows.iter_mut().enumerate() {
        let shift = candidate.quantity[w]
            .iter()
            .map(|z| at(&candidate.knots, values, *z));
        window.inputs.insert(place, shift.collect());
    }
    let with = Data::new(windows, data.training);
    let mut runner = Runner::new(&built, &with, &context.simulation).ok()?;
    // The correction adds no state, so places stay as they are.
    let (of, all) = match (state, output) {
        (Some(s), _) => (s, runner.states(theta)?),
        (None, Some(o)) => (o, runner.outputs(theta)?),
        (None, None) => return None,
    };
    Some(all.into_iter().map(|mut w| w.swap_remove(of)).collect())
}
