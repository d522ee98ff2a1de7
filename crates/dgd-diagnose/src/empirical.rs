//! The competitor: a correction of one relation along one quantity, with no physics in it.

use crate::record::{MASS_BLOCKS, Record, tails, whole};
use crate::relations::Applied;
use crate::scan::joined;
use crate::step::Step;
use crate::tangent::{Tangent, dot};
use dgd_effects::{Effect, KNOTS, Method, QUANTITIES, RELATIONS, Relation, unknown};
use nalgebra::{DMatrix, DVector};

/// Prior width of a knot, in the unit of the relation.
const WIDTHS: [f64; 3] = [1.5e4, 2.0e4, 8e-4];

/// A correction, weighed.
#[derive(Clone)]
pub(crate) struct Correction {
    pub applied: Applied,
    /// What it takes out of the residuals, off the tangent.
    pub signature: Vec<f64>,
    /// Logarithm of the Bayes factor against nothing.
    pub evidence: f64,
    pub relation: usize,
    pub quantity: usize,
}

/// The range of a quantity in the recording.
fn range(record: &Record, quantity: usize) -> (f64, f64) {
    let f = &record.filled;
    let quantiles = |values: &[f64]| tails(values, 50).unwrap_or((0.0, 0.0));
    match quantity {
        0 => record.setting.span_s,
        1 => quantiles(&f.inlet),
        2 => quantiles(&f.mud_pump),
        3 => quantiles(&f.booster),
        4 => {
            let moving: Vec<f64> = f.flow.iter().copied().filter(|q| *q > 2e-3).collect();
            quantiles(&moving)
        }
        5 => {
            let turning: Vec<f64> = f.speed.iter().copied().filter(|w| *w > 10.0).collect();
            quantiles(&turning)
        }
        6 => (0.0, 4.5),
        _ => (-2e-4, 2e-4),
    }
}

/// Every correction that the recording excites, best first.
pub(crate) fn corrections(
    record: &Record,
    tangent: &Tangent,
    state: &[Applied],
) -> Vec<Correction> {
    let effect = unknown();
    let mut out = Vec::new();
    for quantity in 0..QUANTITIES.len() {
        let (from, to) = range(record, quantity);
        if to - from <= 1e-9 * to.abs().max(1e-3) {
            continue;
        }
        for relation in 0..RELATIONS.len() {
            // A curve of flow and speed is the relation itself there: identification, no finding. A mass balance
            // along the rate of the flow is timing.
            let own = matches!((relation, quantity), (0, 4) | (1, 4 | 5) | (2, 7));
            if own {
                continue;
            }
            let mut columns: Vec<Vec<f64>> = Vec::with_capacity(KNOTS);
            let unit = WIDTHS[relation];
            for k in 0..KNOTS {
                let mut parameters = vec![relation as f64, quantity as f64, from, to];
                parameters.extend((0..KNOTS).map(|j| if j == k { unit } else { 0.0 }));
                let one = Applied::new(effect, parameters);
                columns.push(tangent.signature(record, &joined(state, &one)));
            }
            let gram = DMatrix::from_fn(KNOTS, KNOTS, |a, b| {
                dot(&columns[a], &columns[b]) + if a == b { 1.0 } else { 0.0 }
            });
            let right = DVector::from_fn(KNOTS, |a, _| dot(&columns[a], &tangent.off));
            let Some(factor) = gram.cholesky() else {
                continue;
            };
            let coefficients = factor.solve(&right);
            let determinant: f64 = factor.l().diagonal().iter().map(|d| d.ln()).sum();
            let evidence = 0.5 * right.dot(&coefficients) - determinant;
            let signature: Vec<f64> = (0..columns[0].len())
                .map(|i| {
                    (columns.iter().zip(&coefficients))
                        .map(|(c, w)| w * c[i])
                        .sum()
                })
                .collect();
            let evidence = if record.takes(Step::Busiest) {
                evidence - busiest(record, tangent, &signature)
            } else {
                evidence
            };
            let mut parameters = vec![relation as f64, quantity as f64, from, to];
            parameters.extend(coefficients.iter().map(|c| c * unit));
            out.push(Correction {
                applied: Applied::new(effect, parameters),
                signature,
                evidence,
                relation,
                quantity,
            });
        }
    }
    out.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    out
}

/// Whether an effect is the empirical correction itself.
pub(crate) fn is_correction(effect: &dyn Effect) -> bool {
    effect.about().search.method == Method::Correction
}

/// Evidence that corrections reach on sound recordings.
pub(crate) fn hurdle(c: &Correction) -> f64 {
    match c.relation {
        1 if c.quantity == 1 => 110.0,
        1 => 55.0,
        0 => 50.0,
        _ => 30.0,
    }
}

/// Evidence that a signature owes to its busiest ten minutes: a reading that freezes once is no law of the rig.
fn busiest(record: &Record, tangent: &Tangent, signature: &[f64]) -> f64 {
    const WINDOW_S: f64 = 600.0;
    let mut by_block = vec![0.0; record.blocks];
    for (k, section) in tangent.layout.sections().into_iter().enumerate() {
        for (i, row) in section.enumerate() {
            let block = if k == 3 { i * MASS_BLOCKS } else { i };
            let (s, off) = (signature[row], tangent.off[row]);
            by_block[block] += s * (off - 0.5 * s);
        }
    }
    let reach = whole(WINDOW_S / (record.dt_s * record.per_block as f64)).max(1);
    let mut most = 0.0_f64;
    let mut sum = 0.0;
    for b in 0..by_block.len() {
        sum += by_block[b];
        if let Some(gone) = b.checked_sub(reach) {
            sum -= by_block[gone];
        }
        most = most.max(sum);
    }
    most
}

/// Whether a correction is more than the accuracy of instruments: its spread over the recording, and in the mass balance, which
/// holds no constant of its own, its size.
pub(crate) fn plausible(c: &Correction) -> bool {
    let knots = &c.applied.parameters[4..];
    let balance = RELATIONS[c.relation] == Relation::RiserMassBalance;
    let mean = if balance {
        0.0
    } else {
        knots.iter().sum::<f64>() / knots.len() as f64
    };
    let spread =
        (knots.iter().map(|k| (k - mean).powi(2)).sum::<f64>() / knots.len() as f64).sqrt();
    spread > [3e3, 6e3, 1.5e-4][c.relation]
}
