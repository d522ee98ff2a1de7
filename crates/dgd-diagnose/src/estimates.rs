//! Estimates of parameters and their intervals.

use crate::diagnosis::ParameterEstimate;
use crate::empirical::is_correction;
use crate::record::Record;
use crate::relations::Applied;
use crate::scan::on_grid;
use crate::select::Selection;
use crate::step::Step;
use crate::tangent::{Tangent, dot};
use dgd_effects::Role;

/// Factor on standard errors: residuals are whiter in the model than on a rig.
const WIDENING: f64 = 2.5;

/// Estimates of the effect's parameters; intervals from the joint curvature of every continuous parameter, widened for
/// what the forms lack; bare where [`Step::Calibration`] is left out.
pub(crate) fn estimates(
    record: &Record,
    selection: &Selection,
    k: usize,
    full: &Tangent,
) -> Vec<ParameterEstimate> {
    let named = &selection.named[k];
    let about = named.applied.effect.about();
    if named.correction.is_some() {
        return Vec::new();
    }
    let calibrated = record.takes(Step::Calibration);
    let widening = if calibrated { WIDENING } else { 1.0 };
    let state = selection.state();
    // One direction a continuous parameter of every effect.
    let mut directions: Vec<(usize, usize, Vec<f64>)> = Vec::new();
    for (e, one) in state.iter().enumerate() {
        if one.allowance || is_correction(one.effect) {
            continue;
        }
        for (j, parameter) in one.effect.about().parameters.iter().enumerate() {
            let value = one.parameters[j];
            if matches!(
                parameter.role,
                Role::Sensor(_) | Role::Onset | Role::Duration
            ) {
                continue;
            }
            let step = if j == 0 && !on_grid(one.effect.about()) {
                (0.03 * value.abs()).max(0.02 * parameter.usual)
            } else {
                (0.05 * value.abs()).max(0.02)
            };
            let mut next = state.clone();
            next[e].parameters[j] = value + step;
            let s = full
                .signature(record, &next)
                .iter()
                .map(|v| v / step)
                .collect();
            directions.push((e, j, s));
        }
    }
    let n = directions.len();
    let gram = nalgebra::DMatrix::from_fn(n, n, |a, b| {
        let (e, j, s) = &directions[a];
        let prior = if a == b {
            let p = &state[*e].effect.about().parameters[*j];
            let width = if p.usual > 0.0 {
                3.0 * p.usual
            } else {
                state[*e].parameters[*j].abs().max(0.1)
            };
            1.0 / (width * width)
        } else {
            0.0
        };
        dot(s, &directions[b].2) + prior
    });
    let covariance = gram.try_inverse();
    let index = state
        .iter()
        .position(|a| !a.allowance && a.effect.about().id == about.id);
    let profile = Profile {
        record,
        full,
        state: &state,
        directions: &directions,
        covariance: covariance.as_ref(),
        most: 0.5 * (1.96 * widening).powi(2),
    };
    about
        .parameters
        .iter()
        .enumerate()
        .map(|(j, parameter)| {
            let value = named.applied.parameters[j];
            let timed = matches!(parameter.role, Role::Onset | Role::Duration);
            let found = directions
                .iter()
                .position(|(e, i, _)| Some(*e) == index && *i == j);
            let sd = match (&covariance, found) {
                (Some(c), Some(a)) => c[(a, a)].max(0.0).sqrt() * widening,
                _ => 0.0,
            };
            let (shift, factor) = parameter.shown.scale(&record.setting);
            let shown = |v: f64| shift + factor * v;
            // What the forms lack is no smaller for more rows.
            let sd = if j == 0 && calibrated {
                let lacks = about.search.size_error * parameter.shown.size(shown(value));
                sd.hypot(lacks / factor)
            } else {
                sd
            };
            // Curvature reaches beyond what is plausible: no gel is negative. An onset alone may lie anywhere.
            let within = |v: f64| match parameter.role {
                Role::Onset => v,
                _ => v.clamp(parameter.low, parameter.high),
            };
            let end = |by: f64| shown(within(value + by));
            let reach = match index {
                Some(e) if timed => [-1.0, 1.0].map(|side: f64| {
                    let lacks = if calibrated {
                        parameter.time_error_s
                    } else {
                        0.0
                    };
                    side * profile.reach((e, j), side).hypot(1.96 * lacks)
                }),
                _ => [-1.96 * sd, 1.96 * sd],
            };
            ParameterEstimate {
                name: parameter.name.to_owned(),
                meaning: parameter.meaning.to_owned(),
                estimate: shown(value),
                ci95: (end(reach[0]), end(reach[1])),
            }
        })
        .collect()
}

/// What moving a time costs, beside the strengths and shapes that give way to it.
struct Profile<'a> {
    record: &'a Record,
    full: &'a Tangent,
    state: &'a [Applied],
    /// What each strength and shape changes, by effect and parameter.
    directions: &'a [(usize, usize, Vec<f64>)],
    covariance: Option<&'a nalgebra::DMatrix<f64>>,
    /// Evidence that the ends of an interval may cost.
    most: f64,
}

impl Profile<'_> {
    /// How far a time may move to one side: no curvature tells, as rows hold nothing between blocks.
    fn reach(&self, (e, j): (usize, usize), side: f64) -> f64 {
        /// A time is told to three blocks of 10 s to either side at best.
        const LEAST_S: f64 = 59.0;
        const GROWTH: f64 = 1.5;
        let (from, to) = self.record.setting.span_s;
        let costs = |by: f64| self.cost((e, j), side * by) > self.most;
        let (mut near, mut far) = (0.0, LEAST_S);
        while far < to - from && !costs(far) {
            (near, far) = (far, GROWTH * far);
        }
        // To a tenth of the last step.
        for _ in 0..3 {
            let middle = 0.5 * (near + far);
            if near == 0.0 {
                break;
            }
            if costs(middle) {
                far = middle;
            } else {
                near = middle;
            }
        }
        far.min(to - from)
    }

    /// Evidence that is lost where a time of an effect is moved, its end kept where its beginning is moved.
    fn cost(&self, (e, j): (usize, usize), by: f64) -> f64 {
        let about = self.state[e].effect.about();
        let mut moved = self.state.to_vec();
        let parameters = &mut moved[e].parameters;
        parameters[j] += by;
        if let Some(duration) = about.duration() {
            if Some(j) == about.onset() {
                parameters[duration] -= by;
            }
            // Beyond its end there is nothing left to begin.
            if parameters[duration] < about.parameters[duration].low {
                return f64::INFINITY;
            }
        }
        let change = self.full.signature(self.record, &moved);
        let pull = nalgebra::DVector::from_iterator(
            self.directions.len(),
            self.directions.iter().map(|(.., s)| dot(s, &change)),
        );
        let given = self.covariance.map_or(0.0, |c| pull.dot(&(c * &pull)));
        0.5 * (dot(&change, &change) - given) - dot(&change, &self.full.off)
    }
}

#[cfg(test)]
mod tests;
