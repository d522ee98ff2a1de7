//! The recording as the engine uses it: one even working clock, gaps bridged for states, masks for evidence.

use crate::ablation::Step;
use crate::cost::Tally;
use crate::frozen_speed::{
    quantum, stopping_with_the_flow, without_late_steps, without_seldom_rest,
};
use crate::layout::BALANCE_BLOCKS;
use crate::numbers::{Means, bridged, mean, whole};
use crate::stops::{Readings, Stop, stops};
use crate::suction::heads_lost;
use crate::told::{Told, reads};
use dgd_effects::{Laminar, STANDING_PCT, Setting};
use dgd_identify::Prepared;
use dgd_recording::{Channel, Rank, Recording, SLOWEST_S, Well, held_for, quantile, readings};
use dgd_replay::fill_gaps;
use dgd_units::{STANDARD_ATMOSPHERE_PA, STANDARD_GRAVITY_M_S2};
use std::f64::consts::PI;
use std::ops::Range;
use std::sync::Arc;

/// Length of a block of relation residuals, s.
pub(crate) const BLOCK_S: f64 = 10.0;
/// Step of the working clock, s, where the recording is finer.
const CLOCK_S: f64 = 2.0;
/// From this length on, s, clock and blocks are twice as long.
const LONG_S: f64 = 40.0 * 3600.0;
/// How long the sound recordings lasted, s, whose evidence hurdles were set above.
pub(crate) const MEASURED_S: f64 = 8.0 * 3600.0;

/// Straight lines lie between the readings of a channel that is read at fewer than this share of the samples, whether those between are missing or
/// repeat the last one: what is read now and then over [`SLOWEST_S`], and what comes irregularly, or lacks readings here and there, over so many seconds
/// or steps, whichever is longer. Gaps beyond that stay gaps.
const WHOLE: f64 = 0.95;
const IRREGULAR_S: f64 = 6.0;
const IRREGULAR_STEPS: f64 = 3.0;

/// What is read no further apart than this, steps, as a mean, has edges, so that its stops tell the path of the return flow's meter.
const EDGES_STEPS: f64 = 1.2;

/// Share of its quantum that a block of the pump's speed may be off by: rounding alone is 0.29, and the drive rounds too.
const SPEED_QUANTA: f64 = 0.5;

/// Series on the working clock. NaN where a transmitter cannot be trusted.
#[derive(Debug, Clone)]
pub(crate) struct Record {
    pub setting: Setting,
    pub t_s: Vec<f64>,
    pub dt_s: f64,
    pub mud_pump: Vec<f64>,
    pub booster: Vec<f64>,
    pub topfill: Vec<f64>,
    pub flow: Vec<f64>,
    /// Without the rests in which the reading may be frozen.
    pub speed: Vec<f64>,
    /// How the line's flow is laminar where it is slow; `None` where all of it is turbulent.
    pub laminar: Option<Laminar>,
    /// What a block of the reading may be off by, %: part of its quantum, and its noise.
    pub speed_error_pct: f64,
    /// What the balance of a row may be off by as the inlet pressure is rounded, m³/s.
    pub coarse_m3_s: f64,
    pub inlet: Vec<f64>,
    /// The first two inlet transmitters; one where there is one.
    pub inlets: Vec<Vec<f64>>,
    /// Riser pressure, where it has a transmitter.
    pub riser: Option<Vec<f64>>,
    pub outlet: Vec<f64>,
    /// The first two outlet transmitters; one where there is one.
    pub outlets: Vec<Vec<f64>>,
    /// The same with gaps bridged, for the states of effects.
    pub filled: Filled,
    /// Channels on straight lines between their readings, with the time between two, s.
    pub seldom: Vec<(Channel, f64)>,
    /// How often the slower of return flow and outlet pressure tells something new, s.
    pub told_every_s: f64,
    /// Steps of the chain that are left out.
    pub without: Vec<Step>,
    /// Samples in a block.
    pub per_block: usize,
    pub blocks: usize,
    pub tally: Arc<Tally>,
    /// What the suction loses, in velocity heads of the return line; `None` where nothing tells it.
    pub suction_heads: Option<f64>,
    /// When nothing was read.
    pub told: Told,
    /// Stops of the pump that tell the path of the return flow's meter.
    pub stops: Vec<Stop>,
}

/// Series without gaps.
#[derive(Debug, Clone)]
pub(crate) struct Filled {
    pub mud_pump: Vec<f64>,
    pub booster: Vec<f64>,
    pub topfill: Vec<f64>,
    pub flow: Vec<f64>,
    pub speed: Vec<f64>,
    pub inlet: Vec<f64>,
    pub outlet: Vec<f64>,
    pub pumping: Vec<bool>,
}

impl Record {
    /// Length of a block, s.
    pub(crate) fn block_s(&self) -> f64 {
        self.dt_s * self.per_block as f64
    }

    /// Length of a row of the mass balance, s.
    pub(crate) fn row_s(&self) -> f64 {
        self.block_s() * BALANCE_BLOCKS as f64
    }

    /// By what a hurdle is multiplied for what acts between two times, s. Errors of the model's form add evidence in proportion to the time that is read, and
    /// more where samples lie far apart, as these blur what the pumps do.
    pub(crate) fn times_usual(&self, interval_s: (f64, f64)) -> f64 {
        /// Longest step on which hurdles hold as they were set, s.
        const USUAL_STEP_S: f64 = 10.0;
        /// By which power of the step they grow beyond. Set by hand.
        const POWER: f64 = 1.5;
        let lasts = (self.told.between_s(interval_s) / MEASURED_S).max(1.0);
        lasts * (self.dt_s / USUAL_STEP_S).max(1.0).powf(POWER)
    }

    /// For how long anything was read, s.
    pub(crate) fn told_s(&self) -> f64 {
        self.told.between_s(self.setting.span_s)
    }

    /// How long the recording lasts, s.
    pub(crate) fn lasts_s(&self) -> f64 {
        self.setting.span_s.1 - self.setting.span_s.0
    }

    /// Samples that tell the level where two rows of the mass balance meet: it is smooth, and a few about the edge tell it.
    pub(crate) fn about_edge(&self, i: usize) -> Range<usize> {
        let half = whole(2.0 / self.dt_s).max(1);
        i.saturating_sub(half)..(i + half).min(self.inlet.len())
    }

    /// Brings a screened recording onto the working clock.
    pub(crate) fn new(well: &Well, prepared: &Prepared, without: &[Step]) -> Self {
        let recording = &prepared.recording;
        let step_s = prepared.step_s;
        let Clock {
            fold,
            dt_s,
            per_block,
        } = Clock::of(step_s, recording.time_s.len());
        let slow = Slow::of(recording, step_s);
        let thin = |values: &[f64]| -> Vec<f64> {
            let lines = slow.between(values);
            let values = lines.as_deref().unwrap_or(values);
            values.chunks(fold).map(mean).collect()
        };
        let both = |side: &[Vec<f64>]| -> Vec<Vec<f64>> {
            side.iter().take(2).map(|values| thin(values)).collect()
        };
        let t_s: Vec<f64> = recording.time_s.chunks(fold).map(mean).collect();
        let [mud_pump, booster, topfill, flow, speed, inlet, outlet] = [
            &recording.mud_pump_flow_m3_s,
            &recording.booster_flow_m3_s,
            &recording.topfill_flow_m3_s,
            &recording.return_flow_m3_s,
            &recording.pump_speed_pct,
            &prepared.inlet_pressure_pa,
            &prepared.outlet_pressure_pa,
        ]
        .map(|values| thin(values));
        let riser = recording.riser_pressure_pa.as_deref().map(thin);
        let setting = slow.setting(well, prepared, dt_s);
        let speed_noise_pct = setting.noise.speed_pct / (per_block as f64).sqrt();
        let rounded_pct = SPEED_QUANTA * quantum(&recording.pump_speed_pct, step_s);
        let coarse_m3_s = {
            let inlet_pa = &prepared.inlet_pressure_pa;
            // At both edges of a row.
            let noise_pa = setting.noise.inlet_pa * (fold as f64).sqrt();
            let rounded_pa = 2.0_f64.sqrt() * rounding(quantum(inlet_pa, step_s), noise_pa);
            let row_s = dt_s * (per_block * BALANCE_BLOCKS) as f64;
            riser_m3_per_pa(&setting) * rounded_pa / row_s
        };
        let (told_flow, told_outlet) = (bridged(&flow), bridged(&outlet));
        let told_speed = stopping_with_the_flow(&speed, &told_flow, &told_outlet, dt_s);
        let filled = Filled {
            pumping: told_speed.iter().map(|w| *w > STANDING_PCT).collect(),
            mud_pump: bridged(&mud_pump),
            booster: bridged(&booster),
            topfill: bridged(&topfill),
            flow: told_flow,
            speed: told_speed,
            // Effects see pressures without their noise, which the residuals hold (errors in variables).
            inlet: smoothed(&bridged(&inlet), dt_s),
            outlet: smoothed(&told_outlet, dt_s),
        };
        let head_pa = |i: usize| velocity_head_pa(&setting, filled.flow[i]);
        let suction_heads =
            (riser.as_deref()).and_then(|riser| heads_lost(&inlet, riser, head_pa, dt_s));
        let noise_m3_s = setting.noise.flow_m3_s * (fold as f64).sqrt();
        let told_speeds = without_late_steps(
            &without_seldom_rest(&recording.pump_speed_pct, step_s),
            &recording.return_flow_m3_s,
            noise_m3_s,
            step_s,
        );
        let stop_readings = Readings {
            step_s,
            speed_pct: &recording.pump_speed_pct,
            flow_m3_s: &recording.return_flow_m3_s,
            outlet_pa: &prepared.outlet_pressure_pa,
            noise_m3_s,
            per_block: fold * per_block,
        };
        let of_stops = [
            stop_readings.speed_pct,
            stop_readings.flow_m3_s,
            stop_readings.outlet_pa,
        ];
        let has_edges = |values: &&[f64]| {
            let every_s = slow.every_s(values);
            every_s.is_none_or(|every_s| every_s <= EDGES_STEPS * step_s)
        };
        let tell = of_stops.iter().all(has_edges);
        let stops = if tell && !without.contains(&Step::Stops) {
            stops(&stop_readings)
        } else {
            Vec::new()
        };
        let told = [&recording.return_flow_m3_s, &prepared.outlet_pressure_pa];
        let told = told.map(|values| new_every_s(values, step_s));
        Self {
            told: Told::of(&reads(recording), setting.span_s.0, step_s),
            stops,
            suction_heads,
            told_every_s: told.into_iter().fold(dt_s, f64::max),
            setting,
            blocks: t_s.len() / per_block,
            without: without.to_vec(),
            per_block,
            t_s,
            dt_s,
            mud_pump,
            booster,
            topfill,
            flow,
            laminar: None,
            speed: thin(&told_speeds),
            speed_error_pct: speed_noise_pct.hypot(rounded_pct),
            coarse_m3_s,
            inlet,
            inlets: both(&recording.pump_inlet_pressure_pa),
            riser,
            outlet,
            outlets: both(&recording.pump_outlet_pressure_pa),
            filled,
            seldom: (recording.series().into_iter())
                .filter_map(|(channel, values)| Some((channel, slow.every_s(values)?)))
                .collect(),
            tally: Arc::default(),
        }
    }

    /// The same of a line whose flow is laminar where it is slow.
    pub(crate) fn with_laminar(&self, laminar: Laminar) -> Self {
        Self {
            laminar: Some(laminar),
            ..self.clone()
        }
    }

    /// Whether a step of the chain is taken.
    pub(crate) fn takes(&self, step: Step) -> bool {
        !self.without.contains(&step)
    }

    /// Pressure of the full, unmixed return line, Pa absolute.
    pub(crate) fn column_pa(&self) -> f64 {
        STANDARD_ATMOSPHERE_PA
            + self.setting.density_kg_m3 * STANDARD_GRAVITY_M_S2 * self.setting.line_length_m
    }

    /// Velocity head of the return line at a flow, Pa.
    pub(crate) fn velocity_head_pa(&self, flow_m3_s: f64) -> f64 {
        velocity_head_pa(&self.setting, flow_m3_s)
    }

    /// What the suction loses at a flow, as far as that is known, Pa.
    pub(crate) fn suction_pa(&self, flow_m3_s: f64) -> f64 {
        self.suction_heads.unwrap_or(0.0) * self.velocity_head_pa(flow_m3_s)
    }

    /// What a pascal at the pump inlet is worth in the riser, m³.
    pub(crate) fn riser_m3_per_pa(&self) -> f64 {
        riser_m3_per_pa(&self.setting)
    }

    /// Inertia of the line, Pa/(m³/s²).
    pub(crate) fn inertia(&self) -> f64 {
        self.setting.density_kg_m3 * self.setting.line_length_m / self.setting.line_area_m2
    }
}

/// What a pascal at the pump inlet is worth in the riser, m³.
fn riser_m3_per_pa(s: &Setting) -> f64 {
    s.riser_area_m2 / (s.density_kg_m3 * STANDARD_GRAVITY_M_S2)
}

/// Standard deviation of what rounding to a quantum leaves of a mean: noise that crosses quanta averages it out (Widrow and Kollár, Quantization Noise, 2008).
fn rounding(quantum: f64, noise: f64) -> f64 {
    let ratio = noise / quantum;
    if quantum > 0.0 {
        quantum / 12.0_f64.sqrt() * (-2.0 * PI * PI * ratio * ratio).exp()
    } else {
        0.0
    }
}

/// Velocity head of the return line at a flow, Pa.
fn velocity_head_pa(setting: &Setting, flow_m3_s: f64) -> f64 {
    let velocity = flow_m3_s / setting.line_area_m2;
    0.5 * setting.density_kg_m3 * velocity * velocity.abs()
}

/// Moving mean over a minute.
fn smoothed(values: &[f64], dt_s: f64) -> Vec<f64> {
    let half = whole(30.0 / dt_s).max(1);
    let means = Means::of(values);
    (0..values.len())
        .map(|i| means.between(i.saturating_sub(half), i + half + 1))
        .collect()
}

/// The working clock, and how a recording is brought onto it.
struct Clock {
    /// Samples of the recording that are averaged into one.
    fold: usize,
    dt_s: f64,
    /// Samples of the working clock in a block.
    per_block: usize,
}

impl Clock {
    /// For a recording of so many samples, a step apart; those of a gap cost as much time as others.
    fn of(step_s: f64, samples: usize) -> Self {
        // Days are searched at half the resolution: they have rows enough.
        let (clock_s, block_s) = if step_s * samples as f64 > LONG_S {
            (2.0 * CLOCK_S, 2.0 * BLOCK_S)
        } else {
            (CLOCK_S, BLOCK_S)
        };
        let fold = whole((clock_s / step_s).floor()).max(1);
        let dt_s = step_s * fold as f64;
        Self {
            fold,
            dt_s,
            per_block: whole(block_s / dt_s).max(1),
        }
    }
}

/// How a channel is read that lies on straight lines between its readings.
#[derive(Clone, Copy)]
struct Rhythm {
    /// Usual time between readings, s.
    every_s: f64,
    /// The longest time over which straight lines lie between them, s.
    reach_s: f64,
}

/// Channels that are read now and then, or lack readings.
struct Slow {
    step_s: f64,
    /// Where a channel of them is read whose readings are held; empty if there is none.
    held_at: Vec<usize>,
}

impl Slow {
    fn of(recording: &Recording, step_s: f64) -> Self {
        let series = recording.series();
        let held = series.iter().find(|(_, values)| {
            let every = held_for(values);
            every > 1 && every as f64 * step_s <= SLOWEST_S
        });
        Self {
            step_s,
            held_at: held.map_or_else(Vec::new, |(_, values)| readings(values, step_s).collect()),
        }
    }

    /// Where a channel is read: a set-point that moves only where others are read is read with them.
    fn readings<'a>(&'a self, values: &'a [f64]) -> Box<dyn Iterator<Item = usize> + 'a> {
        if self.is_held_too(values) {
            let at = self.held_at.iter().copied();
            return Box::new(at.filter(|i| values.get(*i).is_some_and(|v| v.is_finite())));
        }
        Box::new(readings(values, self.step_s))
    }

    /// Whether a channel moves, and hardly ever where no other is read.
    fn is_held_too(&self, values: &[f64]) -> bool {
        let (mut next, mut moves, mut beside) = (0, 0_usize, 0_usize);
        for (i, pair) in values.windows(2).enumerate() {
            if pair[0] == pair[1] || !pair[0].is_finite() || !pair[1].is_finite() {
                continue;
            }
            next += self.held_at[next..].partition_point(|at| *at < i + 1);
            moves += 1;
            beside += usize::from(self.held_at.get(next) != Some(&(i + 1)));
        }
        moves > 0 && 20 * beside <= moves && !self.held_at.is_empty()
    }

    /// How far apart the readings of a channel are, s; `None` of one that has one at hardly fewer samples than there are.
    fn every_s(&self, values: &[f64]) -> Option<f64> {
        Some(self.rhythm(values)?.every_s)
    }

    fn rhythm(&self, values: &[f64]) -> Option<Rhythm> {
        let mut last: Option<usize> = None;
        let mut apart = Vec::new();
        for i in self.readings(values) {
            apart.extend(last.map(|last| (i - last) as f64 * self.step_s));
            last = Some(i);
        }
        if (apart.len() + 1) as f64 >= WHOLE * values.len() as f64 {
            return None;
        }
        let usual_s = quantile(apart.iter().copied(), Rank::MEDIAN)?;
        let furthest_s = quantile(apart.iter().copied(), Rank::Upper(10))?;
        if usual_s > 1.5 * self.step_s {
            let (every_s, reach_s) = (usual_s, SLOWEST_S);
            return (furthest_s <= reach_s).then_some(Rhythm { every_s, reach_s });
        }
        // What comes after one, two or five seconds, or is missing here and there: as if all were as far apart as they are on the mean. What lies in
        // longer gaps is not logged at all.
        let reach_s = IRREGULAR_S.max(IRREGULAR_STEPS * self.step_s);
        apart.retain(|s| *s <= reach_s);
        let every_s = mean(&apart);
        let seldom = WHOLE * every_s > self.step_s && furthest_s <= reach_s;
        seldom.then_some(Rhythm { every_s, reach_s })
    }

    /// The rig as a recording shows it, with the noise that channels have on the working clock, of step `dt_s`.
    fn setting(&self, well: &Well, prepared: &Prepared, dt_s: f64) -> Setting {
        let recording = &prepared.recording;
        let mut setting = Setting::of(well, recording, &prepared.inlet_pressure_pa);
        let noise = &mut setting.noise;
        for (noise, values) in [
            (&mut noise.mud_pump_m3_s, &recording.mud_pump_flow_m3_s),
            (&mut noise.booster_m3_s, &recording.booster_flow_m3_s),
            (&mut noise.flow_m3_s, &recording.return_flow_m3_s),
            (&mut noise.speed_pct, &recording.pump_speed_pct),
            (&mut noise.inlet_pa, &prepared.inlet_pressure_pa),
        ] {
            // A mean over several readings has less; samples on the line between two of them share theirs.
            *noise *= (self.every_s(values).unwrap_or(self.step_s) / dt_s).sqrt();
        }
        setting
    }

    /// Straight lines between the readings of such a channel, but not over its longer gaps; `None` of any other.
    fn between(&self, values: &[f64]) -> Option<Vec<f64>> {
        let Rhythm { reach_s, .. } = self.rhythm(values)?;
        let mut lines = vec![f64::NAN; values.len()];
        let mut last: Option<usize> = None;
        for i in self.readings(values) {
            lines[i] = values[i];
            let near = |from: &usize| (i - from) as f64 * self.step_s <= reach_s;
            if let Some(from) = last.filter(near) {
                fill_gaps(&mut lines[from..=i]);
            }
            last = Some(i);
        }
        Some(lines)
    }
}

/// Usual time until a reading tells another value, s, whether it is held or missing until then; 0 of one that never does.
fn new_every_s(values: &[f64], step_s: f64) -> f64 {
    let mut last: Option<(usize, f64)> = None;
    let mut apart = Vec::new();
    for (i, v) in values.iter().enumerate().filter(|(_, v)| v.is_finite()) {
        if last.is_none_or(|(_, before)| before != *v) {
            apart.extend(last.map(|(at, _)| (i - at) as f64 * step_s));
            last = Some((i, *v));
        }
    }
    quantile(apart, Rank::MEDIAN).unwrap_or(0.0)
}

#[cfg(test)]
mod tests;
