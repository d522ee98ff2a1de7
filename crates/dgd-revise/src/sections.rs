//! Whether the same cause with the same parameters holds along the independent variable.
//!
//! Binary segmentation: the cut at which a re-fit on both sides takes most away, against signs of blocks drawn anew (Bai, J.
//! and Perron, P., *Econometrica* 66 (1998), for the statistic; Wu, C. F. J., *Ann. Stat.* 14 (1986), for the draws).

use crate::baseline::fresh_jacobian;
use crate::blocks::{Blocks, null_probability};
use crate::conclude::Evidence;
use crate::context::{Context, Trial};
use crate::revision::Section;
use crate::sets::Scored;
use crate::stack::Runner;
use crate::tangent::{Tangent, dot};
use dgd_lsq::lm::{self, Effort};
use nalgebra::DMatrix;

/// Cuts tried within a stretch.
const CUTS: usize = 16;
/// Least share of all samples in a section.
const LEAST: usize = 12;
/// Least share of a stretch's squares that a cut must take away.
const WORTH: f64 = 0.1;

/// Sections of the training part: for the claimed set, or for a smaller one that leaves clearly less when it may change its
/// parameters along the way.
///
/// - `rivals`: sets that may take its place.
pub(crate) fn sections(
    context: &Context<'_>,
    claimed: &Trial,
    rivals: &[Scored],
    evidence: &Evidence<'_, '_>,
) -> Vec<Section> {
    let size = claimed.members.len();
    let mut trials: Vec<&Trial> = vec![claimed];
    trials.extend(
        rivals
            .iter()
            .map(|s| &s.trial)
            .filter(|t| t.members.len() <= size.min(1)),
    );
    // A residual that remembers itself says less than its readings are many.
    let n = context.data.rows.len() as f64 / evidence.memory.max(1) as f64;
    let divided = context.threads.map(&trials, |trial| {
        let stretches = divide(context, trial)?;
        let all: Vec<(Section, f64)> = stretches
            .iter()
            .map(|rows| describe(context, trial, rows, evidence))
            .collect();
        let cost: f64 = all.iter().map(|s| s.1).sum();
        let freedom = trial.paths.len() * all.len();
        // Akaike's price of a parameter, and of a cut that of the places it was picked from.
        let cuts = (all.len() - 1) as f64 * (CUTS as f64).ln();
        let price = 0.5 * n * cost.max(1e-300).ln() + freedom as f64 + cuts;
        Some((price, all.into_iter().map(|s| s.0).collect::<Vec<_>>()))
    });
    let mut best: Option<(f64, Vec<Section>)> = None;
    for (k, (price, sections)) in divided.into_iter().flatten().enumerate() {
        // Another set than the claimed one must be clearly better, and only in sections.
        let margin = if k == 0 { 0.0 } else { 10.0 };
        let better = best.as_ref().is_none_or(|b| price + margin < b.0);
        if better && (k == 0 || sections.len() > 1) {
            best = Some((price, sections));
        }
    }
    best.map_or_else(Vec::new, |b| b.1)
}

/// Rows of each section of a fitted set, in the order of the independent variable.
fn divide(context: &Context<'_>, trial: &Trial) -> Option<Vec<Vec<usize>>> {
    let jacobian = fresh_jacobian(context, trial)?;
    let data = context.data;
    let mut order: Vec<usize> = (0..data.rows.len()).collect();
    let time = |i: usize| data.time(&data.rows[i]);
    order.sort_by(|a, b| time(*a).total_cmp(&time(*b)));
    // Signs of single samples where nothing is remembered; what a cut takes away is itself remembered, so no more than a
    // few samples.
    let blocks = Blocks::new(data, 1);
    let mut open = vec![order];
    let mut closed: Vec<Vec<usize>> = Vec::new();
    while let Some(stretch) = open.pop() {
        let cut = if open.len() + closed.len() < 4 {
            best_cut(
                &stretch,
                &jacobian,
                &trial.minimum.residuals,
                &blocks,
                data.rows.len(),
            )
        } else {
            None
        };
        match cut {
            Some(k) => {
                open.push(stretch[k..].to_vec());
                open.push(stretch[..k].to_vec());
            }
            None => closed.push(stretch),
        }
    }
    closed.sort_by(|a, b| time(a[0]).total_cmp(&time(b[0])));
    Some(closed)
}

fn best_cut(
    stretch: &[usize],
    jacobian: &DMatrix<f64>,
    residuals: &[f64],
    blocks: &Blocks,
    all: usize,
) -> Option<usize> {
    let n = stretch.len();
    let least = all.div_ceil(LEAST).max(2 * jacobian.ncols());
    if n < 2 * least {
        return None;
    }
    // Rows outside the stretch are nought throughout.
    let mut inside = vec![0.0; residuals.len()];
    let mut r = vec![0.0; residuals.len()];
    for &i in stretch {
        inside[i] = 1.0;
        r[i] = residuals[i];
    }
    let columns: Vec<Vec<f64>> = jacobian
        .column_iter()
        .map(|c| c.iter().zip(&inside).map(|(c, w)| c * w).collect())
        .collect();
    let common = Tangent::of(columns.iter().cloned());
    let off = common.off(&r);
    let total = dot(&off, &off);
    let mut cuts = Vec::new();
    for c in 1..CUTS {
        let k = c * n / CUTS;
        if k < least || n - k < least {
            continue;
        }
        let mut left = vec![0.0; residuals.len()];
        for &i in &stretch[..k] {
            left[i] = 1.0;
        }
        let own = Tangent::of(columns.iter().map(|c| {
            let half: Vec<f64> = c.iter().zip(&left).map(|(c, l)| c * l).collect();
            common.off(&half)
        }));
        let sums: Vec<Vec<f64>> = own.each().map(|u| blocks.coarse(u, &off, 1.0)).collect();
        cuts.push((k, own.within(&off) / total.max(1e-300), sums));
    }
    let best = cuts.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let groups = cuts
        .iter()
        .map(|c| c.2.iter().map(Vec::as_slice).collect::<Vec<_>>());
    (best.1 >= WORTH && null_probability(groups, 5) <= 0.01).then_some(best.0)
}

/// A section, and half the squares that its own parameters leave there.
fn describe(
    context: &Context<'_>,
    trial: &Trial,
    rows: &[usize],
    evidence: &Evidence<'_, '_>,
) -> (Section, f64) {
    let data = context.data;
    let mut keep = vec![false; data.rows.len()];
    rows.iter().for_each(|&i| keep[i] = true);
    let effort = Effort {
        steps: 30,
        tolerance: 1e-5,
        fresh: 10,
        ..crate::baseline::SPARING
    };
    let own = context.build(&trial.members).and_then(|built| {
        let mut runner = Runner::new(&built, data, &context.simulation).ok()?;
        Some(lm::minimise(
            &mut |x: &[f64]| runner.run(x).map(|s| context.residual(s)),
            &trial.minimum.theta,
            &trial.bounds,
            Some(&keep),
            None,
            effort,
        ))
    });
    let rms = |r: &[f64]| -> Vec<f64> {
        (0..context.scale.len())
            .map(|o| {
                let of: Vec<f64> = rows
                    .iter()
                    .filter(|&&i| data.rows[i].output == o)
                    .map(|&i| r[i] * context.scale[o])
                    .collect();
                (dot(&of, &of) / of.len() as f64).sqrt()
            })
            .collect()
    };
    let section = Section {
        from: rows.first().map_or(f64::NAN, |&i| data.time(&data.rows[i])),
        to: rows.last().map_or(f64::NAN, |&i| data.time(&data.rows[i])),
        cause: evidence.names(&trial.members),
        parameters: own.as_ref().map_or_else(Vec::new, |o| {
            trial
                .paths
                .iter()
                .cloned()
                .zip(o.theta.iter().copied())
                .collect()
        }),
        common: rms(&trial.minimum.residuals),
        own: own.as_ref().map_or_else(Vec::new, |o| rms(&o.residuals)),
    };
    (section, own.map_or(f64::INFINITY, |o| o.cost))
}
