//! Estimates of parameters and their intervals.

use crate::diagnosis::ParameterEstimate;
use crate::empirical::is_correction;
use crate::record::Record;
use crate::relations::{Applied, on_grid};
use crate::select::Selection;
use crate::step::Step;
use crate::tangent::Tangent;
use dgd_effects::Role;
use dgd_lsq::dot;

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
    let span = record.setting.span_s;
    let widening = if calibrated { WIDENING } else { 1.0 };
    let state = selection.state();
    // One direction a continuous parameter of every effect.
    let mut directions: Vec<(usize, usize, Vec<f64>)> = Vec::new();
    for (e, one) in state.iter().enumerate() {
        if one.allowance || is_correction(one.effect) {
            continue;
        }
        for (j, parameter) in one.effect.about().parameters.iter().enumerate() {
            if is_continuous(parameter.role) {
                directions.push((e, j, direction(record, full, &state, (e, j), None)));
            }
        }
    }
    let covariance = gram(&state, &directions).try_inverse();
    let index = state
        .iter()
        .position(|a| !a.allowance && a.effect.about().id == about.id);
    let profile = Profile {
        record,
        full,
        state: &state,
        directions: &directions,
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
            let sized = j == 0 && calibrated;
            let size = parameter.shown.size(shown(value)) / factor;
            // What the forms lack is no smaller for more rows.
            let sd = if sized {
                sd.hypot(about.search.size_error * size)
            } else {
                sd
            };
            // Curvature reaches beyond what is plausible: no gel is negative, and no recording shows what began before it.
            let within = |v: f64| match parameter.role {
                Role::Onset => v.clamp(span.0, span.1.max(value).max(span.0)),
                // A search may leave what is plausible, and an interval holds its estimate.
                _ => v.clamp(parameter.low.min(value), parameter.high.max(value)),
            };
            let before = parameter.role == Role::Onset && value < span.0;
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
                _ if sized => {
                    let reach = [-1.96 * sd, 1.96 * sd];
                    let grows = shown(value) >= parameter.shown.neutral();
                    shrunk(reach, size, grows)
                }
                _ => [-1.96 * sd, 1.96 * sd],
            };
            ParameterEstimate {
                name: parameter.name.to_owned(),
                meaning: if before {
                    format!("{}: before the recording begins", parameter.meaning)
                } else {
                    parameter.meaning.to_owned()
                },
                estimate: shown(within(value)),
                ci95: (end(reach[0]), end(reach[1])),
            }
        })
        .collect()
}

/// An interval of a size, as distances from it, of which the end that is the smaller size is so many times smaller instead: if the effect is
/// there, its size is not none.
fn shrunk(reach: [f64; 2], size: f64, grows: bool) -> [f64; 2] {
    if size <= 0.0 {
        return reach;
    }
    let times = |by: f64| -size * (-by.abs() / size).exp_m1();
    if grows {
        [-times(reach[0]), reach[1]]
    } else {
        [reach[0], times(reach[1])]
    }
}

/// Whether rows change smoothly with a parameter.
fn is_continuous(role: Role) -> bool {
    !matches!(role, Role::Sensor(_) | Role::Onset | Role::Duration)
}

/// What a parameter of an effect changes in the rows, by its unit; beside what a state changes in them, if it is not the full one.
fn direction(
    record: &Record,
    full: &Tangent,
    state: &[Applied],
    (e, j): (usize, usize),
    here: Option<&[f64]>,
) -> Vec<f64> {
    let one = &state[e];
    let (value, usual) = (one.parameters[j], one.effect.about().parameters[j].usual);
    let step = if j == 0 && !on_grid(one.effect.about()) {
        (0.03 * value.abs()).max(0.02 * usual)
    } else {
        (0.05 * value.abs()).max(0.02)
    };
    let mut next = state.to_vec();
    next[e].parameters[j] = value + step;
    let mut change = full.signature(record, &next);
    if let Some(here) = here {
        for (there, here) in change.iter_mut().zip(here) {
            *there -= here;
        }
    }
    change.iter_mut().for_each(|v| *v /= step);
    change
}

/// How directions overlap, with the priors of their parameters.
fn gram(state: &[Applied], directions: &[(usize, usize, Vec<f64>)]) -> nalgebra::DMatrix<f64> {
    let n = directions.len();
    nalgebra::DMatrix::from_fn(n, n, |a, b| {
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
    })
}

/// What moving a time costs, beside the strengths and shapes that give way to it.
struct Profile<'a> {
    record: &'a Record,
    full: &'a Tangent,
    state: &'a [Applied],
    /// What each strength and shape changes, by effect and parameter.
    directions: &'a [(usize, usize, Vec<f64>)],
    /// Evidence that the ends of an interval may cost.
    most: f64,
}

impl Profile<'_> {
    /// How far a time may move to one side: no curvature tells, as rows hold nothing between blocks.
    fn reach(&self, (e, j): (usize, usize), side: f64) -> f64 {
        /// A time is told with a standard error of three blocks of 10 s at best.
        const LEAST_S: f64 = 1.96 * 30.0;
        const GROWTH: f64 = 1.5;
        let (from, to) = self.record.setting.span_s;
        let still = self.misfit(self.state, e);
        let costs = |by: f64| {
            let moved = self.moved((e, j), side * by);
            moved.is_none_or(|moved| self.misfit(&moved, e) - still > self.most)
        };
        let (mut near, mut far) = (0.0, LEAST_S);
        while far < to - from && !costs(far) {
            (near, far) = (far, GROWTH * far);
        }
        // To an eighth of the last step.
        if near > 0.0 {
            for _ in 0..3 {
                let middle = 0.5 * (near + far);
                if costs(middle) {
                    far = middle;
                } else {
                    near = middle;
                }
            }
        }
        far.min(to - from)
    }

    /// The state with a time of an effect moved, its end kept where its beginning is moved; `None` where it ends before it begins, or
    /// begins beyond the recording.
    fn moved(&self, (e, j): (usize, usize), by: f64) -> Option<Vec<Applied>> {
        let about = self.state[e].effect.about();
        let mut moved = self.state.to_vec();
        let parameters = &mut moved[e].parameters;
        parameters[j] += by;
        if Some(j) == about.onset() && parameters[j] > self.record.setting.span_s.1 {
            return None;
        }
        if let Some(duration) = about.duration() {
            if Some(j) == about.onset() {
                parameters[duration] -= by;
            }
            if parameters[duration] < about.parameters[duration].low {
                return None;
            }
        }
        Some(moved)
    }

    /// Half the square of what a state leaves, its strengths and shapes fitted to it, those of an effect where that is.
    fn misfit(&self, state: &[Applied], e: usize) -> f64 {
        let change = self.full.signature(self.record, state);
        let left: Vec<f64> = (self.full.off.iter().zip(&change))
            .map(|(off, change)| off - change)
            .collect();
        let there = |(of, j, s): &(usize, usize, Vec<f64>)| {
            let s = if *of == e {
                direction(self.record, self.full, state, (e, *j), Some(&change))
            } else {
                s.clone()
            };
            (*of, *j, s)
        };
        let directions: Vec<_> = self.directions.iter().map(there).collect();
        let pull = nalgebra::DVector::from_iterator(
            directions.len(),
            directions.iter().map(|(.., s)| dot(s, &left)),
        );
        let given = gram(state, &directions)
            .try_inverse()
            .map_or(0.0, |c| pull.dot(&(c * &pull)));
        0.5 * (dot(&left, &left) - given)
    }
}

#[cfg(test)]
mod tests;
