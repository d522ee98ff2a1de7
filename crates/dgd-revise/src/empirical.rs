//! Corrections with no physics, which compete with the catalogue: piecewise linear along one quantity, added to a reading
//! or to the inflow of a tank or volume.

mod fit;
mod survey;

pub(crate) use fit::{Corrected, fit};
pub(crate) use survey::survey;

use crate::context::Context;
use crate::stack::{Data, Runner, run_once};
use dgd_assembly::{Assembly, Between, Component, Input, Kind, Setting, Window};
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
    // Effects may have states of their own in between.
    let places = built.states();
    for name in context.assembly.states() {
        let i = places.iter().position(|s| *s == name)?;
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

impl Candidate {
    /// The correction at each sample of a window.
    fn shift(&self, values: &[f64], window: usize) -> Vec<f64> {
        self.quantity[window]
            .iter()
            .map(|z| at(&self.knots, values, *z))
            .collect()
    }
}

/// The assembly of a set with an inflow into a component, and windows in which the correction is that inflow.
fn fed(
    context: &Context<'_>,
    data: &Data,
    members: &[usize],
    component: &str,
    candidate: &Candidate,
    values: &[f64],
) -> Option<(Assembly, Data)> {
    let (built, place) = with_inflow(context, members, component)?;
    let mut windows = data.windows.clone();
    for (w, window) in windows.iter_mut().enumerate() {
        window.inputs.insert(place, candidate.shift(values, w));
    }
    Some((built, Data::new(windows, data.numbers.clone())))
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
    match &candidate.place {
        Place::Output(o) => {
            let built = context.build(members)?;
            let mut runner = Runner::new(&built, data, &context.simulation).ok()?;
            let mut outputs = runner.outputs(theta)?;
            for (w, window) in outputs.iter_mut().enumerate() {
                for (v, s) in window[*o].iter_mut().zip(candidate.shift(values, w)) {
                    *v += s;
                }
            }
            Some(outputs)
        }
        Place::Inflow(component) => {
            let (built, with) = fed(context, data, members, component, candidate, values)?;
            Runner::new(&built, &with, &context.simulation)
                .ok()?
                .outputs(theta)
        }
    }
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
    let output = context
        .assembly
        .outputs()
        .iter()
        .position(|o| *o == candidate.along);
    let Place::Inflow(component) = &candidate.place else {
        return None;
    };
    let (built, with) = fed(context, data, members, component, candidate, values)?;
    let state = built.states().iter().position(|s| *s == candidate.along);
    let mut runner = Runner::new(&built, &with, &context.simulation).ok()?;
    let (of, all) = match (state, output) {
        (Some(s), _) => (s, runner.states(theta)?),
        (None, Some(o)) => (o, runner.outputs(theta)?),
        (None, None) => return None,
    };
    Some(all.into_iter().map(|mut w| w.swap_remove(of)).collect())
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
