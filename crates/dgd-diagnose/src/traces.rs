//! Residuals of each relation over time.

use crate::diagnosis::Trace;
use crate::empirical::is_correction;
use crate::noise::Wander;
use crate::record::{MASS_BLOCKS, Record};
use crate::relations::Applied;
use crate::tangent::Tangent;
use crate::unrest::wander;
use crate::witness::Witness;
use dgd_effects::{Action, Changes, Moment, Rank, Relation, quantile};

/// The pump's inlet beside the riser's transmitter.
pub(crate) const INLET_AND_RISER: &str = "pump inlet less riser pressure";

/// Residuals by relation, before and after: tangents with their hypotheses.
pub(crate) fn traces(
    record: &Record,
    (before, start): (&Tangent, &[Applied]),
    (after, state): (&Tangent, &[Applied]),
) -> Vec<Trace> {
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
            pair: None,
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
        let outlets = section(
            Relation::Instrument,
            "Pa",
            l.difference_at(),
            l.difference,
            seconds,
            may.difference_pa,
            &|t, i| t.rows.difference[i],
        );
        out.push(Trace {
            pair: Some("outlet transmitters, first less second"),
            ..outlets
        });
    }
    out.extend(inlets(record, start, state, may));
    out
}

/// The inlet's transmitters against the riser's, if it has one.
fn inlets(record: &Record, start: &[Applied], state: &[Applied], may: Wander) -> Option<Trace> {
    let witness = Witness::of(record, may, &[])?;
    // Each as far as its corrections explain it; what does not move tells nothing.
    let less = |hypothesis: &[Applied]| -> Option<Vec<f64>> {
        let bias = inlet_bias(record, hypothesis, witness.t_s());
        let left: Vec<f64> = (witness.residual().iter().zip(&bias))
            .map(|(v, b)| v - b)
            .collect();
        let middle = quantile(left.iter().copied(), Rank::MEDIAN)?;
        Some(left.iter().map(|v| v - middle).collect())
    };
    let (before, after) = (less(start)?, less(state)?);
    Some(Trace {
        relation: Relation::Instrument,
        pair: Some(INLET_AND_RISER),
        unit: "Pa",
        t_s: (witness.t_s().iter())
            .map(|t| t - record.setting.span_s.0)
            .collect(),
        before,
        after,
        noise: witness.noise_pa(),
        wander: may.difference_pa,
    })
}

/// What the corrections of a hypothesis hold the inlets to read too much, at some times, Pa.
fn inlet_bias(record: &Record, state: &[Applied], t_s: &[f64]) -> Vec<f64> {
    let corrections = state.iter().filter(|a| is_correction(a.effect));
    // They are corrected over time alone: the readings of a moment do not count.
    let mut actions: Vec<Action> = corrections
        .map(|a| a.effect.begin(&a.parameters, &record.setting))
        .collect();
    let seconds = record.block_s();
    (t_s.iter().enumerate())
        .map(|(index, t)| {
            let i = (index * record.per_block).min(record.t_s.len() - 1);
            let f = &record.filled;
            let moment = Moment {
                index,
                t_s: *t,
                dt_s: seconds,
                mud_pump_m3_s: f.mud_pump[i],
                booster_m3_s: f.booster[i],
                topfill_m3_s: f.topfill[i],
                flow_m3_s: f.flow[i],
                speed_pct: f.speed[i],
                inlet_pa: f.inlet[i],
                outlet_pa: f.outlet[i],
                pumping: f.pumping[i],
            };
            let mut changes = Changes::default();
            for action in &mut actions {
                action(&moment, &mut changes);
            }
            changes.inlet_bias_pa
        })
        .collect()
}
