//! Estimates of parameters and their intervals.

use crate::ablation::Step;
use crate::diagnosis::ParameterEstimate;
use crate::record::Record;
use crate::relations::{Applied, on_grid};
use crate::selection::Named;
use crate::tangent::{Tangent, alike};
use dgd_effects::{Parameter, Role};
use dgd_lsq::dot;
use nalgebra::{DMatrix, DVector};

/// Factor on standard errors: residuals are whiter in the model than on a rig. Set on simulated recordings, so that 95 of 100 intervals hold: `PROOF.md`.
const WIDENING: f64 = 2.0;

/// The same of onsets and durations, of which the forms lack more: with 2.0, 89 of 100 intervals held (plant seeds 841 and 842).
const WIDENING_OF_TIMES: f64 = 2.5;

/// What the estimates of all findings have in common.
pub(crate) struct Estimator<'a> {
    record: &'a Record,
    /// All that was found and allowed for.
    state: &'a [Applied],
    /// The tangent about that.
    full: &'a Tangent,
    directions: Vec<Direction>,
    covariance: Option<DMatrix<f64>>,
}

/// What a parameter of an effect changes in the rows, by its unit.
#[derive(Clone)]
struct Direction {
    /// Of the state, which effect.
    effect: usize,
    parameter: usize,
    change: Vec<f64>,
}

impl<'a> Estimator<'a> {
    /// Intervals come from the joint curvature of every continuous parameter of every effect.
    pub(crate) fn of(record: &'a Record, state: &'a [Applied], full: &'a Tangent) -> Self {
        let mut directions = Vec::new();
        for (effect, one) in state.iter().enumerate() {
            if one.allowance || one.is_correction() {
                continue;
            }
            for (parameter, of) in one.effect.about().parameters.iter().enumerate() {
                if is_continuous(of.role) {
                    let change = direction(record, full, state, (effect, parameter), None);
                    directions.push(Direction {
                        effect,
                        parameter,
                        change,
                    });
                }
            }
        }
        Self {
            covariance: gram(state, &directions).try_inverse(),
            record,
            state,
            full,
            directions,
        }
    }

    /// Estimates of the parameters of a named effect, their intervals widened for what the forms lack; bare where [`Step::Calibration`] is
    /// left out. A correction has none.
    pub(crate) fn estimates(&self, named: &Named) -> Vec<ParameterEstimate> {
        if named.applied.is_correction() {
            return Vec::new();
        }
        let about = named.applied.effect.about();
        // The same effect may have come more than once.
        let this = std::slice::from_ref(&named.applied);
        let of_this = |a: &Applied| !a.allowance && alike(std::slice::from_ref(a), this);
        let effect = self.state.iter().position(of_this);
        let each = about.parameters.iter().enumerate();
        each.map(|(j, parameter)| self.estimate(&named.applied, (effect, j), parameter))
            .collect()
    }

    /// The estimate of one parameter of an effect, which stands in the state at `e`.
    fn estimate(
        &self,
        one: &Applied,
        (e, j): (Option<usize>, usize),
        parameter: &Parameter,
    ) -> ParameterEstimate {
        let calibrated = self.record.takes(Step::Calibration);
        let widened = |by: f64| if calibrated { by } else { 1.0 };
        let span = self.record.setting.span_s;
        let value = one.parameters[j];
        let (shift, factor) = parameter.shown.scale(&self.record.setting);
        let shown = |v: f64| shift + factor * v;
        let sized = j == 0 && calibrated;
        let size = parameter.shown.size(shown(value)) / factor;
        let mut sd = widened(WIDENING) * self.curvature_sd((e, j));
        if sized {
            // What the forms lack is no smaller for more rows.
            sd = sd.hypot(one.effect.about().search.size_error * size);
        }
        let reach = match (e, parameter.role) {
            (Some(e), Role::Onset | Role::Duration(_)) => {
                let profile = Profile {
                    estimator: self,
                    most: 0.5 * (1.96 * widened(WIDENING_OF_TIMES)).powi(2),
                };
                let lacks_s = if calibrated {
                    parameter.time_error_s
                } else {
                    0.0
                };
                [-1.0, 1.0].map(|side| side * profile.reach((e, j), side).hypot(1.96 * lacks_s))
            }
            _ if sized => {
                let grows = shown(value) >= parameter.shown.neutral();
                shrunk([-1.96 * sd, 1.96 * sd], size, grows)
            }
            _ => [-1.96 * sd, 1.96 * sd],
        };
        // Curvature reaches beyond what is plausible: no gel is negative, and no recording shows what began before it.
        let within = |v: f64| match parameter.role {
            Role::Onset => v.clamp(span.0, span.1.max(value).max(span.0)),
            // A search may leave what is plausible, and an interval holds its estimate.
            _ => v.clamp(parameter.low.min(value), parameter.high.max(value)),
        };
        let before = parameter.role == Role::Onset && value < span.0;
        let end = |by: f64| shown(within(value + by));
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
    }

    /// Standard deviation of a parameter by the joint curvature; 0 of one that has none, and infinite where nothing tells it.
    fn curvature_sd(&self, (e, j): (Option<usize>, usize)) -> f64 {
        let this = |d: &Direction| Some(d.effect) == e && d.parameter == j;
        let at = self.directions.iter().position(this);
        let Some(a) = at else {
            return 0.0;
        };
        let variance = self.covariance.as_ref().map(|c| c[(a, a)]);
        let told = variance.filter(|v| v.is_finite());
        told.map_or(f64::INFINITY, |v| v.max(0.0).sqrt())
    }
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
    match role {
        Role::Amplitude | Role::Grid(_) | Role::Shape(_) | Role::Edge(_) => true,
        Role::Choice(_) | Role::Sensor(_) | Role::Onset | Role::Duration(_) => false,
    }
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
fn gram(state: &[Applied], directions: &[Direction]) -> DMatrix<f64> {
    let n = directions.len();
    DMatrix::from_fn(n, n, |a, b| {
        let of = &directions[a];
        let prior = if a == b {
            let one = &state[of.effect];
            let p = &one.effect.about().parameters[of.parameter];
            let width = if p.usual > 0.0 {
                3.0 * p.usual
            } else {
                one.parameters[of.parameter].abs().max(0.1)
            };
            1.0 / (width * width)
        } else {
            0.0
        };
        dot(&of.change, &directions[b].change) + prior
    })
}

/// What moving a time costs, beside the strengths and shapes that give way to it.
struct Profile<'a> {
    estimator: &'a Estimator<'a>,
    /// Evidence that the ends of an interval may cost.
    most: f64,
}

impl Profile<'_> {
    /// How far a time may move to one side: no curvature tells, as rows hold nothing between blocks.
    fn reach(&self, (e, j): (usize, usize), side: f64) -> f64 {
        /// A time is told with a standard error of three blocks of 10 s at best.
        const LEAST_S: f64 = 1.96 * 30.0;
        const GROWTH: f64 = 1.5;
        let (from, to) = self.estimator.record.setting.span_s;
        let still = self.misfit(self.estimator.state, e);
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
        let Estimator { record, state, .. } = self.estimator;
        let about = state[e].effect.about();
        let mut moved = state.to_vec();
        let parameters = &mut moved[e].parameters;
        parameters[j] += by;
        if Some(j) == about.onset() && parameters[j] > record.setting.span_s.1 {
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
        let Estimator { record, full, .. } = self.estimator;
        let change = full.signature(record, state);
        let left: Vec<f64> = (full.off.iter().zip(&change))
            .map(|(off, change)| off - change)
            .collect();
        let there = |d: &Direction| {
            if d.effect != e {
                return d.clone();
            }
            let change = direction(record, full, state, (e, d.parameter), Some(&change));
            Direction { change, ..*d }
        };
        let directions: Vec<Direction> = self.estimator.directions.iter().map(there).collect();
        let pull = DVector::from_iterator(
            directions.len(),
            directions.iter().map(|d| dot(&d.change, &left)),
        );
        let given = gram(state, &directions)
            .try_inverse()
            .map_or(0.0, |c| pull.dot(&(c * &pull)));
        0.5 * (dot(&left, &left) - given)
    }
}

#[cfg(test)]
mod tests;
