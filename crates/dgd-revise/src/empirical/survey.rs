//! Every place and quantity of a correction, weighed linearly.

use super::{Candidate, Place, Problem, hat, knots, quantities};
use crate::baseline::Baseline;
use crate::blocks::Blocks;
use crate::context::{Context, Trial};
use crate::tangent::{Tangent, dot};

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
