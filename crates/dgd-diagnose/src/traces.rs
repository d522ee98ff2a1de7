//! Residuals of each relation over time.

use crate::diagnosis::{Trace, times};
use crate::error_budget::wander;
use crate::layout::Section;
use crate::noise::Wander;
use crate::record::Record;
use crate::relations::Applied;
use crate::tangent::Tangent;
use crate::twins::{Pair, Twins};
use dgd_effects::Relation;

/// Residuals by relation, before and after: tangents with their hypotheses.
pub(crate) fn traces(
    record: &Record,
    (before, start): (&Tangent, &[Applied]),
    (after, state): (&Tangent, &[Applied]),
) -> Vec<Trace> {
    let layout = before.layout;
    let [b, a] = [before, after].map(levelled);
    let may = wander(record, &after.curves);
    let starts_s = record.setting.span_s.0;
    let trace = |section: Section| {
        // Of the model before, too, what no fit has seen is shown, and stops that its curves are made without.
        let pick = |values: &[f64]| on_rows(after, section, values);
        let (noise, wander) = sizes(after, section, may);
        let step_s = record.block_s() * section.blocks_per_row() as f64;
        Trace {
            relation: section.relation(),
            pair: None,
            unit: if section == Section::Balance {
                "m3/s"
            } else {
                "Pa"
            },
            t_s: (0..layout.rows(section).len())
                .map(|i| starts_s + (i as f64 + 0.5) * step_s)
                .collect(),
            before: pick(&b),
            after: pick(&a),
            offset: 0.0,
            noise,
            wander,
        }
    };
    let mut out: Vec<Trace> = [Section::Friction, Section::Head, Section::Balance]
        .map(trace)
        .into();
    // A transmitter that is mapped and says nothing has no neighbour to differ from.
    if after.rows.outlets.contains(&true) {
        out.push(Trace {
            pair: Some(Pair::Outlets.name()),
            offset: Pair::Outlets.offset(record).unwrap_or(f64::NAN),
            ..trace(Section::Outlets)
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

/// How many times as much a tangent keeps in a section as noise and wander make (root mean square), by section; NaN of one without rows.
pub(crate) fn excess<'a>(record: &Record, tangent: &'a Tangent) -> impl Fn(Section) -> f64 + 'a {
    let residual = levelled(tangent);
    let may = wander(record, &tangent.curves);
    move |section| {
        let (noise, wander) = sizes(tangent, section, may);
        times(&on_rows(tangent, section, &residual), noise.hypot(wander))
    }
}

/// Values of a section where its rows are used, else NaN.
fn on_rows(tangent: &Tangent, section: Section, values: &[f64]) -> Vec<f64> {
    let values = &values[tangent.layout.rows(section)];
    let each = values.iter().zip(tangent.rows.of_section(section));
    each.map(|(v, valid)| if *valid { *v } else { f64::NAN })
        .collect()
}

/// Standard deviations of noise, and of what instruments within their accuracy may wander by, in a row of a section.
fn sizes(tangent: &Tangent, section: Section, may: Wander) -> (f64, f64) {
    let rows = tangent.layout.rows(section);
    let noise = tangent.whitening.noise(rows);
    let [slow, hidden] = may.of(section);
    (noise, slow.hypot(hidden))
}

/// The residual of a tangent about the curves of the model that runs: what stands off where mud flows is theirs.
fn levelled(tangent: &Tangent) -> Vec<f64> {
    let mut residual = tangent.clean_residual();
    let (friction, head) = tangent.flowing_level(&residual, &[]);
    for (value, still) in residual.iter_mut().zip(&tangent.rows.still) {
        *value -= if *still { 0.0 } else { friction };
    }
    for value in &mut residual[tangent.layout.rows(Section::Head)] {
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
        wander: may.outlets_pa,
    })
}

#[cfg(test)]
mod tests;
