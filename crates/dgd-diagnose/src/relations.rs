//! The four relations in block form, under a hypothesis.
//!
//! Rows: line friction (Eq. 3.13 with the inertia of Eq. 3.46), pump head (Eq. 2.27), the redundant outlet
//! transmitters, and the riser's mass balance (Eq. 3.45) in integral form over half a minute.

mod blocks;
mod level_rate;
mod line_flow;
mod parts;
mod rows;
#[cfg(test)]
mod tests;

pub(crate) use blocks::Blocks;
pub(crate) use level_rate::{LevelRate, imbalance_per_head};
pub(crate) use line_flow::{LineFlow, blurred, meter_path};
pub(crate) use parts::{Parts, Touched};
pub(crate) use rows::{Rows, is_full, is_topped, repeats};

use crate::layout::BALANCE_BLOCKS;
use crate::record::Record;
use dgd_effects::{
    About, Action, Changes, Curve, Effect, KNOTS, Method, Moment, Role, leaking_m3_s, unknown,
};
use parts::Row;
use std::ops::Range;

/// An effect with its parameters.
#[derive(Clone)]
pub(crate) struct Applied {
    pub effect: &'static dyn Effect,
    pub parameters: Vec<f64>,
    /// Whether it only allows for timing: no finding.
    pub allowance: bool,
}

impl Applied {
    /// An effect that counts as a finding.
    pub(crate) fn new(effect: &'static dyn Effect, parameters: Vec<f64>) -> Self {
        Self {
            effect,
            parameters,
            allowance: false,
        }
    }

    /// What a sound rig may have of an effect, as it usually is.
    pub(crate) fn allowed(effect: &'static dyn Effect, strength: f64) -> Self {
        Self {
            effect,
            parameters: effect.about().of_strength(strength),
            allowance: true,
        }
    }

    /// Which of the catalogue it is.
    pub(crate) fn id(&self) -> &'static str {
        self.effect.about().id
    }

    /// Whether it is the empirical correction.
    pub(crate) fn is_correction(&self) -> bool {
        self.effect.about().search.method == Method::Correction
    }

    /// Whether it is a finding of something late.
    pub(crate) fn names_lateness(&self) -> bool {
        let search = &self.effect.about().search;
        !self.allowance && (search.timing.is_some() || !search.allowance.is_empty())
    }

    /// The curve of a correction; `None` of an effect, and of a correction of no place that there is.
    pub(crate) fn curve(&self) -> Option<Curve> {
        (self.is_correction())
            .then(|| Curve::read(&self.parameters))
            .flatten()
    }

    /// From when to when it acts within a recording from and to so many seconds.
    pub(crate) fn interval_s(&self, span_s: (f64, f64)) -> (f64, f64) {
        let episode = self.curve().and_then(|curve| curve.episode_s(span_s));
        episode.unwrap_or_else(|| self.effect.about().interval_s(&self.parameters, span_s))
    }
}

impl From<&Curve> for Applied {
    fn from(curve: &Curve) -> Self {
        Self::new(unknown(), curve.parameters())
    }
}

/// The state with one effect more; a timing allowance of the same effect gives way to it.
pub(crate) fn joined(state: &[Applied], one: &Applied) -> Vec<Applied> {
    let id = one.id();
    let mut out: Vec<Applied> = state
        .iter()
        .filter(|a| !(a.allowance && a.id() == id))
        .cloned()
        .collect();
    out.push(one.clone());
    out
}

/// Knots along the inlet pressure, as the level goes up and down a riser by many lengths of what happens there; and along the time
/// of a period, in which a filter may be cleaned at once.
pub(crate) const FINE_KNOTS: usize = 3 * (KNOTS - 1) + 1;

/// Whether the strength of an effect is on a grid.
pub(crate) fn on_grid(about: &About) -> bool {
    matches!(about.parameters[0].role, Role::Grid(_))
}

/// What effects do between line and meter.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Metered {
    gain: f64,
    leak_m3_s: f64,
}

impl Metered {
    pub(crate) fn under(c: &Changes) -> Self {
        Self {
            gain: c.meter_gain,
            leak_m3_s: c.leak_m3_s,
        }
    }

    /// Flow that leaves the line for a reading, m³/s.
    fn outflow_m3_s(self, read_m3_s: f64) -> f64 {
        read_m3_s / self.gain
    }

    /// Flow through the line for a reading, m³/s; of mud that stands nothing leaks on.
    fn line_m3_s(self, read_m3_s: f64) -> f64 {
        let outflow = self.outflow_m3_s(read_m3_s);
        outflow + leaking_m3_s(self.leak_m3_s, outflow)
    }
}

impl Default for Metered {
    fn default() -> Self {
        Self::under(&Changes::default())
    }
}

/// Effects at the beginning of a recording, of which they have seen nothing: called for each sample in order, writes what all of them change.
pub(crate) fn begun<'a>(
    record: &Record,
    applied: impl IntoIterator<Item = &'a Applied>,
) -> impl FnMut(&Moment, &mut Changes) {
    let begin = |one: &Applied| one.effect.begin(&one.parameters, &record.setting);
    let mut actions: Vec<Action> = applied.into_iter().map(begin).collect();
    move |moment, c| {
        *c = Changes::default();
        for action in &mut actions {
            action(moment, c);
        }
    }
}

/// Runs effects over samples of a recording, from where a row of the mass balance begins, and lays what they come to into `parts`.
///
/// `meter` is what effects do to the meter in the sample before, which the flow that they see in the first one follows.
/// `changes` is called for each sample in order and writes what the effects change over what is there of some other sample, for it is
/// large to hand about; it tells what that touches of what `parts` hold already.
pub(crate) fn run(
    record: &Record,
    (line, rates): (&LineFlow, &LevelRate),
    samples: Range<usize>,
    mut meter: Metered,
    parts: &mut Parts,
    mut changes: impl FnMut(&Moment, &mut Changes) -> Touched,
) {
    record.tally.ran(samples.len());
    let (_, filled_flow) = line.of(record);
    let filled = &record.filled;
    let per_row = record.per_block * BALANCE_BLOCKS;
    // Row by row: samples need not be held once their means are taken.
    let mut row = Row::of(record, line, rates);
    row.changes.resize(per_row, Changes::default());
    let mut touched = Touched::default();
    let mut laid = samples.start;
    for i in samples.clone() {
        let moment = Moment {
            index: i,
            t_s: record.t_s[i],
            dt_s: record.dt_s,
            mud_pump_m3_s: filled.mud_pump[i],
            booster_m3_s: filled.booster[i],
            topfill_m3_s: filled.topfill[i],
            flow_m3_s: meter.line_m3_s(filled_flow[i]),
            outflow_m3_s: meter.outflow_m3_s(filled_flow[i]),
            speed_pct: filled.speed[i],
            inlet_pa: filled.inlet[i],
            outlet_pa: filled.outlet[i],
            pumping: filled.pumping[i],
        };
        let here = &mut row.changes[i - laid];
        touched = touched.or(changes(&moment, here));
        meter = Metered::under(here);
        let length = i + 1 - laid;
        if length == per_row || i + 1 == samples.end {
            row.changes.truncate(length);
            row.lay_into(parts, laid, touched);
            laid = i + 1;
            touched = Touched::default();
        }
    }
}
