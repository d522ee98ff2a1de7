//! Residuals of each relation over time.

use crate::diagnosis::Trace;
use crate::noise::Wander;
use crate::record::{MASS_BLOCKS, Record};
use crate::relations::Applied;
use crate::tangent::Tangent;
use crate::twins::{Pair, Twins};
use crate::unrest::wander;
use dgd_effects::Relation;
use dgd_recording::{Rank, quantile};

/// Residuals by relation, before and after: tangents with their hypotheses.
pub(crate) fn traces(
    record: &Record,
    (before, start): (&Tangent, &[Applied]),
    (after, state): (&Tangent, &[Applied]),
) -> Vec<Trace> {
    let (l, rows) = (before.layout, &after.rows);
    let seconds = record.block_s();
    let [b, a] = [before, after].map(levelled);
    let may = wander(record, &after.curves);
    let starts_s = record.setting.span_s.0;
    let section = |relation: Relation,
                   unit: &'static str,
                   from: usize,
                   len: usize,
                   step: f64,
                   wander: f64,
                   valid: &dyn Fn(usize) -> bool| {
        // Of the model before, too, what no fit has seen is shown, and stops that its curves are made without.
        let pick = |values: &[f64]| -> Vec<f64> {
            (0..len)
                .map(|i| if valid(i) { values[from + i] } else { f64::NAN })
                .collect()
        };
        let weights = after.whitening.weight[from..from + len].iter().copied();
        let noise =
            quantile(weights.filter(|w| *w > 0.0), Rank::MEDIAN).map_or(f64::NAN, |w| 1.0 / w);
        Trace {
            relation,
            pair: None,
            unit,
            t_s: (0..len)
                .map(|i| starts_s + (i as f64 + 0.5) * step)
                .collect(),
            before: pick(&b),
            after: pick(&a),
            offset: 0.0,
            noise,
            wander,
        }
    };
    let mut out = vec![
        section(
            Relation::ReturnLineFriction,
            "Pa",
            0,
            l.blocks,
            seconds,
            may.friction_pa.hypot(may.hidden_friction_pa),
            &|i| rows.friction[i],
        ),
        section(
            Relation::PumpHead,
            "Pa",
            l.head(),
            l.blocks,
            seconds,
            may.head_pa.hypot(may.hidden_head_pa),
            &|i| rows.head[i],
        ),
        section(
            Relation::RiserMassBalance,
            "m3/s",
            l.mass_at(),
            l.mass,
            seconds * MASS_BLOCKS as f64,
            may.mass_m3_s,
            &|i| rows.mass[i],
        ),
    ];
    // A transmitter that is mapped and says nothing has no neighbour to differ from.
    if rows.difference.contains(&true) {
        let outlets = section(
            Relation::Instrument,
            "Pa",
            l.difference_at(),
            l.difference,
            seconds,
            may.difference_pa,
            &|i| rows.difference[i],
        );
        out.push(Trace {
            pair: Some(Pair::Outlets.name()),
            offset: Pair::Outlets.offset(record).unwrap_or(f64::NAN),
            ..outlets
        });
    }
    let beside = [Pair::Inlets, Pair::InletAndRiser];
    out.extend(
        beside
            .map(|pair| twins(record, pair, (start, state), may))
            .into_iter()
            .flatten(),
    );
    out
}

/// The residual of a tangent about the curves of the model that runs: what stands off where mud flows is theirs.
fn levelled(tangent: &Tangent) -> Vec<f64> {
    let mut residual = tangent.clean_residual();
    let (friction, head) = tangent.flowing_level(&residual, &[]);
    let (n, rows) = (tangent.layout.blocks, &tangent.rows);
    for (value, still) in residual.iter_mut().zip(&rows.still) {
        *value -= if *still { 0.0 } else { friction };
    }
    for value in &mut residual[tangent.layout.head()..][..n] {
        *value -= head;
    }
    residual
}

/// Two transmitters against each other, if there are two that say something: as far as either hypothesis leaves them apart.
fn twins(
    record: &Record,
    pair: Pair,
    (start, state): (&[Applied], &[Applied]),
    may: Wander,
) -> Option<Trace> {
    let [before, after] = [start, state].map(|held| Twins::of(record, pair, held, may, &[]));
    let (before, after) = (before?, after?);
    Some(Trace {
        relation: Relation::Instrument,
        pair: Some(pair.name()),
        unit: "Pa",
        t_s: after.t_s().to_vec(),
        before: before.residual().to_vec(),
        after: after.residual().to_vec(),
        offset: pair.offset(record)?,
        noise: after.noise_pa(),
        wander: may.difference_pa,
    })
}

#[cfg(test)]
mod tests;
