//! What named effects may still be wrong by: their parameters, and a form that no rig follows to the letter.
//!
//! A second effect must stand out from all of it; what a first one leaves over for want of form is no finding.

use crate::numbers::{finite_or_0, mean};
use crate::record::Record;
use crate::relations::{Applied, Blocks, joined, on_grid};
use crate::tangent::Tangent;
use crate::twins::seen_curve;
use crate::vectors::Sparse;
use dgd_effects::{Curve, Excitation, Place, Role, STANDING_M3_S};
use std::sync::Arc;

/// A direction in which the model may be off: a column in the units of the rows, and the prior width of its coefficient.
#[derive(Debug, Clone)]
pub(crate) struct Slack {
    /// Most belong to a single stand, and tangents share them.
    pub column: Arc<Sparse>,
    pub width: f64,
}

/// Stands that are told apart at the most; in days of drilling neighbours share a column.
const MOST_STANDS: usize = 24;
/// One direction's share of the error of a form.
const FORM_SHARE: f64 = 0.5;
/// Share of a strength that its derivative is taken over.
const NUDGE: f64 = 0.05;
/// Prior width of an onset, s.
const ONSET_WIDTH_S: f64 = 120.0;

/// The slack of effect `k` of a hypothesis, about the tangent of that hypothesis.
pub(crate) fn slack(
    record: &Record,
    tangent: &Tangent,
    applied: &[Applied],
    k: usize,
) -> Vec<Slack> {
    let one = &applied[k];
    if one.allowance {
        return Vec::new();
    }
    if let Some(curve) = seen_curve(one) {
        return elsewhere(record, tangent, applied, &curve);
    }
    if one.is_correction() {
        return Vec::new();
    }
    let mut out = parameters(record, tangent, applied, k);
    out.extend(form(record, tangent, applied, k));
    out
}

/// What two transmitters part by, in the other places where some of it may sit: what the relations tell of how it is shared is
/// less than what the two tell of the curve.
fn elsewhere(record: &Record, tangent: &Tangent, applied: &[Applied], curve: &Curve) -> Vec<Slack> {
    let others: &[Place] = match curve.place {
        // It is there because the relations find none of it.
        Place::RiserReading => &[],
        Place::FirstOutlet | Place::SecondOutlet => &[Place::OutletReading],
        _ => &[Place::Head, Place::Suction],
    };
    let of = |other: &Place| {
        let there = Curve {
            place: *other,
            ..curve.clone()
        };
        let change = tangent.change(record, &joined(applied, &Applied::from(&there)));
        let column: Vec<f64> = change.into_iter().map(finite_or_0).collect();
        Slack {
            column: Arc::new(Sparse::of(&column, &tangent.layout.sections())),
            width: 1.0,
        }
    };
    others.iter().map(of).collect()
}

/// One direction a parameter.
fn parameters(record: &Record, tangent: &Tangent, applied: &[Applied], k: usize) -> Vec<Slack> {
    let one = &applied[k];
    let along = |j: usize, step: f64, width: f64| -> Slack {
        let mut next = applied.to_vec();
        next[k].parameters[j] += step;
        let change = tangent.change(record, &next);
        let column: Vec<f64> = change.iter().map(|v| finite_or_0(v / step)).collect();
        Slack {
            column: Arc::new(Sparse::of(&column, &tangent.layout.sections())),
            width,
        }
    };
    one.effect
        .about()
        .parameters
        .iter()
        .enumerate()
        .filter_map(|(j, parameter)| {
            let size = one.parameters[j].abs();
            match parameter.role {
                Role::Choice(_) | Role::Sensor(_) => None,
                Role::Onset | Role::Duration(_) => Some(along(j, 30.0, ONSET_WIDTH_S)),
                Role::Amplitude => Some(along(
                    j,
                    (0.05 * size).max(0.01 * parameter.usual),
                    size.max(parameter.usual),
                )),
                Role::Grid(_) | Role::Shape(_) | Role::Edge(_) => {
                    let size = if size > 0.0 { size } else { parameter.usual };
                    Some(along(j, (0.1 * size).max(0.1), (0.3 * size).max(1.0)))
                }
            }
        })
        .collect()
}

/// The effect's own trace, swelling and fading with time and load, and from stand to stand where each has its own.
fn form(record: &Record, tangent: &Tangent, applied: &[Applied], k: usize) -> Vec<Slack> {
    let about = applied[k].effect.about();
    // What a share of the strength makes: a line that has drained to balance stands there at any rate.
    let mut other = applied.to_vec();
    let share = if on_grid(about) {
        other.remove(k);
        -1.0
    } else {
        other[k].parameters[0] *= 1.0 - NUDGE;
        -NUDGE
    };
    let trace: Vec<f64> = tangent
        .change(record, &other)
        .iter()
        .map(|v| finite_or_0(v / share))
        .collect();
    let span = record.setting.span_s;
    let seconds = record.block_s();
    let layout = tangent.layout;
    let time = |row: usize| span.0 + layout.block(row) as f64 * seconds;
    let modulated = |by: &dyn Fn(usize) -> f64, width: f64| {
        let rows = trace.iter().enumerate();
        let column: Vec<f64> = rows.map(|(row, v)| v * by(row)).collect();
        Slack {
            column: Arc::new(Sparse::of(&column, &layout.sections())),
            width,
        }
    };
    let interval = about.interval_s(&applied[k].parameters, span);
    let through = |row: usize| {
        let share = (time(row) - interval.0) / (interval.1 - interval.0).max(1.0);
        2.0 * share.clamp(0.0, 1.0) - 1.0
    };
    let flow = Blocks::under(record, applied).flow;
    let moving: Vec<f64> = flow
        .iter()
        .copied()
        .filter(|q| *q > STANDING_M3_S)
        .collect();
    let typical = finite_or_0(mean(&moving)).max(STANDING_M3_S);
    let load = |row: usize| {
        let q = flow.get(layout.block(row)).copied().unwrap_or(f64::NAN);
        finite_or_0((q / typical - 1.0).clamp(-1.0, 1.0))
    };
    let error = FORM_SHARE * about.search.form_error;
    let mut out = vec![
        modulated(&through, error),
        modulated(&|row| 2.0 * through(row).powi(2) - 1.0, error),
        modulated(&load, error),
    ];
    if let Some(error) = about.search.stand_error {
        // At a stop little but the strength itself can differ; between connections it swells and fades as well.
        let stops = about.search.needs.contains(&Excitation::PumpStops);
        let ends: Vec<f64> = if stops {
            starts(record).collect()
        } else {
            (record.setting.connections.iter().map(|c| c.to_s)).collect()
        };
        let mut edges = vec![f64::NEG_INFINITY];
        let apart = ends.len().min(MOST_STANDS - 1);
        edges.extend((1..=apart).map(|k| ends[k * (ends.len() + 1) / (apart + 1) - 1]));
        edges.push(f64::INFINITY);
        for w in edges.windows(2) {
            let (from, to) = (w[0].max(span.0), w[1].min(span.1));
            let inside = |row: usize| (w[0]..w[1]).contains(&time(row));
            let along = |row: usize| (2.0 * time(row) - from - to) / (to - from).max(1.0);
            out.push(modulated(&|row| if inside(row) { 1.0 } else { 0.0 }, error));
            if !stops {
                out.push(modulated(
                    &|row| if inside(row) { along(row) } else { 0.0 },
                    error,
                ));
            }
        }
    }
    out
}

/// When the subsea pump starts again after a stop of a minute or more, s.
fn starts(record: &Record) -> impl Iterator<Item = f64> {
    let mut rested_s = 0.0;
    record
        .t_s
        .iter()
        .zip(&record.filled.pumping)
        .filter_map(move |(t, pumping)| {
            if !pumping {
                rested_s += record.dt_s;
                return None;
            }
            (std::mem::take(&mut rested_s) >= 60.0).then_some(*t)
        })
}

#[cfg(test)]
mod tests;
