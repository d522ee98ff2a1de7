//! Residuals of each relation over time.

use crate::diagnosis::Trace;
use crate::record::{MASS_BLOCKS, Record};
use crate::tangent::Tangent;
use crate::unrest::wander;
use dgd_effects::{Rank, Relation, quantile};

/// Residuals by relation, before and after.
pub(crate) fn traces(record: &Record, before: &Tangent, after: &Tangent) -> Vec<Trace> {
    let l = before.layout;
    let seconds = record.block_s();
    let (b, a) = (before.clean_residual(), after.clean_residual());
    let may = wander(record, &after.curves);
    let section = |relation: Relation,
                   unit: &'static str,
                   from: usize,
                   len: usize,
                   step: f64,
                   wander: f64,
                   valid: &dyn Fn(&Tangent, usize) -> bool| {
        let pick = |values: &[f64], t: &Tangent| -> Vec<f64> {
            (0..len)
                .map(|i| {
                    if valid(t, i) {
                        values[from + i]
                    } else {
                        f64::NAN
                    }
                })
                .collect()
        };
        let weights = after.whitening.weight[from..from + len].iter().copied();
        let noise =
            quantile(weights.filter(|w| *w > 0.0), Rank::MEDIAN).map_or(f64::NAN, |w| 1.0 / w);
        Trace {
            relation,
            unit,
            t_s: (0..len).map(|i| (i as f64 + 0.5) * step).collect(),
            before: pick(&b, before),
            after: pick(&a, after),
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
            &|t, i| t.rows.friction[i],
        ),
        section(
            Relation::PumpHead,
            "Pa",
            l.head(),
            l.blocks,
            seconds,
            may.head_pa.hypot(may.hidden_head_pa),
            &|t, i| t.rows.head[i],
        ),
        section(
            Relation::RiserMassBalance,
            "m3/s",
            l.mass_at(),
            l.mass,
            seconds * MASS_BLOCKS as f64,
            may.mass_m3_s,
            &|t, i| t.rows.mass[i],
        ),
    ];
    // A transmitter that is mapped and says nothing has no neighbour to differ from.
    if after.rows.difference.contains(&true) {
        out.push(section(
            Relation::Instrument,
            "Pa",
            l.difference_at(),
            l.difference,
            seconds,
            may.difference_pa,
            &|t, i| t.rows.difference[i],
        ));
    }
    out
}
