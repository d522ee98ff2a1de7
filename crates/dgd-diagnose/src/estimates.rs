//! Estimates of parameters and their intervals.

use crate::diagnosis::ParameterEstimate;
use crate::empirical::is_correction;
use crate::record::Record;
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
    about
        .parameters
        .iter()
        .enumerate()
        .map(|(j, parameter)| {
            let value = named.applied.parameters[j];
            let found = directions
                .iter()
                .position(|(e, i, _)| Some(*e) == index && *i == j);
            let sd = match (&covariance, found) {
                (Some(c), Some(a)) => c[(a, a)].max(0.0).sqrt() * widening,
                _ => match parameter.role {
                    Role::Onset | Role::Duration => 30.0,
                    _ => 0.0,
                },
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
            // Beyond what is plausible no curvature reaches: no gel is negative. Times may lie anywhere.
            let timed = matches!(parameter.role, Role::Onset | Role::Duration);
            let within = |v: f64| {
                let plausible = v.min(parameter.high).max(parameter.low);
                if timed { v } else { plausible }
            };
            let end = |by: f64| shown(within(value + by));
            ParameterEstimate {
                name: parameter.name.to_owned(),
                meaning: parameter.meaning.to_owned(),
                estimate: shown(value),
                ci95: (end(-1.96 * sd), end(1.96 * sd)),
            }
        })
        .collect()
}

#[cfg(test)]
mod tests;
