//! A correction fitted on top of a set, and scored on left-out blocks.

use super::{Candidate, Problem, at, knots, seen};
use crate::context::{Context, Trial};
use crate::validate::{Folds, LeftOut};
use dgd_lsq::lm::{self, Bounds, Effort, Minimum};

/// A fitted correction.
#[derive(Debug, Clone)]
pub(crate) struct Corrected {
    pub candidate: Candidate,
    pub minimum: Minimum,
    pub left: LeftOut,
    /// At the knots.
    pub values: Vec<f64>,
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
    let with = |of: &[f64], knots: f64| [of, &vec![knots; n]].concat();
    let bounds = Bounds::new(
        with(trial.bounds.low(), -1e3),
        with(trial.bounds.high(), 1e3),
    )
    .ok()?;
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
    let declared = Context::start(&context.build(&trial.members)?, &Default::default())?.1;
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
