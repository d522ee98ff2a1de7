//! All parameters of an effect, moved to where it explains most beside the others.
//!
//! Edges make kinks, and between two of them the misfit may have a hollow of its own: long steps of one parameter at a time get over those. From there
//! all go together, as few valleys lie along one of them: a longer influx that rises more slowly brings in as much mud.

use crate::cores::apiece;
use crate::incremental::Incremental;
use crate::record::Record;
use crate::relations::{Applied, on_grid};
use crate::tangent::Tangent;
use dgd_effects::{About, Parameter, Role};
use dgd_lsq::dot;
use dgd_lsq::lm::{Bounds, Effort, Residuals, minimise};
use nalgebra::DMatrix;

/// Long steps of one parameter, and what one must gain, e-folds. Set by hand.
const STEPS: usize = 3;
const GAIN: f64 = 0.025;

/// How far all go together, in long steps of each; and the part of one that its slope is told by. Set by hand.
const REACH: f64 = 40.0;
const SLOPE: f64 = 0.25;

/// Moves an effect of a state on the residuals of a tangent about it.
pub(super) fn climb(record: &Record, tangent: &Tangent, state: &mut [Applied], k: usize) {
    let mut climber = Climber::of(record, tangent, state, k);
    let about = climber.own.effect.about();
    let start = climber.strode(&state[k].parameters);
    let (low, high) = (about.parameters.iter().zip(&state[k].parameters))
        .map(|(parameter, value)| within(parameter, *value))
        .unzip();
    // A parameter that is no number leads nowhere.
    state[k].parameters = Bounds::new(low, high).map_or(start.clone(), |bounds| {
        minimise(&mut climber, &start, &bounds, None, None, effort()).theta
    });
}

/// How far all parameters go together: beyond a few hundredths of an e-fold nothing is gained.
fn effort() -> Effort {
    Effort {
        steps: 15,
        tolerance: 1e-6,
        patience: 5,
        ..Effort::default()
    }
}

/// One effect that moves: all others are run once.
struct Climber<'a> {
    record: &'a Record,
    tangent: &'a Tangent,
    others: Vec<Applied>,
    ground: Incremental,
    own: Applied,
}

impl<'a> Climber<'a> {
    fn of(record: &'a Record, tangent: &'a Tangent, state: &[Applied], k: usize) -> Self {
        let mut others = state.to_vec();
        let own = others.remove(k);
        Self {
            ground: Incremental::under(record, &others),
            record,
            tangent,
            others,
            own,
        }
    }

    /// What is left of the residuals where its parameters are these.
    fn left(&self, parameters: &[f64]) -> Vec<f64> {
        let one = Applied {
            parameters: parameters.to_vec(),
            ..self.own.clone()
        };
        let blocks = (self.ground.with(self.record, &one)).unwrap_or_else(|| {
            let all: Vec<Applied> = self.others.iter().cloned().chain([one]).collect();
            self.ground.other(self.record, &all)
        });
        let tangent = self.tangent;
        let shift = tangent.beyond(self.record, &tangent.change_to(&blocks));
        tangent.off.iter().zip(&shift).map(|(a, b)| a - b).collect()
    }

    /// The parameters after long steps of each but the strength, which is solved for beside them.
    fn strode(&self, from: &[f64]) -> Vec<f64> {
        let about = self.own.effect.about();
        let left = self.left(from);
        // The direction of a little more strength.
        let along = (!on_grid(about)).then(|| {
            let step = SLOPE * long_step(&about.parameters[0], from[0]);
            let mut p = from.to_vec();
            p[0] += step;
            let more = self.left(&p);
            let slope: Vec<f64> = (left.iter().zip(&more))
                .map(|(a, b)| (a - b) / step)
                .collect();
            let energy = dot(&slope, &slope).max(1e-300);
            (slope, energy)
        });
        // Misfit, and how much more strength is best.
        let weighed = |left: &[f64]| -> (f64, f64) {
            let all = 0.5 * dot(left, left);
            along.as_ref().map_or((all, 0.0), |(slope, energy)| {
                let pull = dot(left, slope);
                (all - 0.5 * pull * pull / energy, pull / energy)
            })
        };
        let mut best = (from.to_vec(), weighed(&left));
        let first = usize::from(along.is_some());
        let moves = |(_, parameter): &(usize, &Parameter)| !is_held(parameter);
        let moved = || (about.parameters.iter().enumerate().skip(first)).filter(moves);
        // Two transmitters tell an edge to seconds: beside it no strength is right.
        let edges = || moved().filter(|(_, parameter)| is_time(parameter));
        let halves = [0.5, 0.25, 0.125];
        let finer = halves
            .into_iter()
            .flat_map(|scale| edges().map(move |of| (scale, of)));
        for (scale, (j, parameter)) in moved().map(|of| (1.0, of)).chain(finer) {
            for _ in 0..STEPS {
                let tried = |sign: f64| {
                    let mut p = best.0.clone();
                    p[j] += sign * scale * long_step(parameter, p[j]);
                    p[j] = p[j].clamp(parameter.low, parameter.high);
                    let weighed = weighed(&self.left(&p));
                    (p, weighed)
                };
                let tried: [_; 2] = rayon::join(|| tried(1.0), || tried(-1.0)).into();
                let nearer = (tried.into_iter()).min_by(|a, b| a.1.0.total_cmp(&b.1.0));
                let Some(nearer) = nearer.filter(|nearer| nearer.1.0 < best.1.0 - GAIN) else {
                    break;
                };
                best = nearer;
            }
        }
        let (mut best, (_, more)) = best;
        if along.is_some() {
            let p = &about.parameters[0];
            let limit = best[0].abs().max(p.usual);
            best[0] = (best[0] + more.clamp(-limit, limit)).clamp(p.low, p.high);
        }
        best
    }
}

impl Residuals for Climber<'_> {
    fn at(&mut self, theta: &[f64]) -> Option<Vec<f64>> {
        Some(self.left(theta))
    }

    fn jacobian(&mut self, theta: &[f64], r: &[f64], bounds: &Bounds) -> Option<DMatrix<f64>> {
        let about: &About = self.own.effect.about();
        let slopes = apiece((0..theta.len()).collect(), |j| {
            let step = SLOPE * long_step(&about.parameters[j], theta[j]);
            let mut moved = theta.to_vec();
            moved[j] = if theta[j] + step > bounds.high()[j] {
                (theta[j] - step).max(bounds.low()[j])
            } else {
                theta[j] + step
            };
            // Held by bounds that meet.
            let share = (moved[j] - theta[j]) / bounds.span(j);
            if share == 0.0 || is_held(&about.parameters[j]) {
                return vec![0.0; r.len()];
            }
            let there = self.left(&moved);
            there.iter().zip(r).map(|(a, b)| (a - b) / share).collect()
        });
        Some(DMatrix::from_fn(r.len(), theta.len(), |row, j| {
            slopes[j][row]
        }))
    }
}

/// Whether a parameter is one of a few values, and not moved.
fn is_held(parameter: &Parameter) -> bool {
    matches!(parameter.role, Role::Choice(_) | Role::Sensor(_))
}

fn is_time(parameter: &Parameter) -> bool {
    matches!(parameter.role, Role::Onset | Role::Duration(_))
}

/// Where a parameter may go from a value.
fn within(parameter: &Parameter, value: f64) -> (f64, f64) {
    if is_held(parameter) {
        return (value, value);
    }
    let reach = REACH * long_step(parameter, value);
    let (mut low, mut high) = (value - reach, value + reach);
    if parameter.role == Role::Amplitude {
        // Towards the other sign it goes to nothing, or by a usual strength.
        let least = value.abs().max(parameter.usual);
        if value > 0.0 {
            low = value - least;
        } else {
            high = value + least;
        }
    }
    (low.max(parameter.low), high.min(parameter.high))
}

/// The longest step of a parameter from a value.
fn long_step(parameter: &Parameter, value: f64) -> f64 {
    let size = value.abs();
    match parameter.role {
        Role::Onset | Role::Duration(_) => 80.0,
        Role::Grid(_) => 0.15 * size.max(1.0),
        Role::Amplitude => 0.2 * size.max(parameter.usual),
        _ => 0.2 * size.max(0.1 * parameter.usual).max(0.1),
    }
}
