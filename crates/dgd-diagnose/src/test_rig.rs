//! What many tests are made on: a recording in which nothing happens but what a claim sets, and normal draws.

mod draws;

pub(crate) use draws::normals;

use crate::diagnosis::Finding;
use crate::record::{Filled, Record};
use crate::relations::{Applied, Blocks};
use crate::selection::{Named, Selection};
use crate::stops::{Readings, Stop, stops};
use crate::tangent::{Bend, Tangent};
use crate::told::Told;
use dgd_effects::{Curves, FRICTION_TERMS, HEAD_TERMS, Noise, Relation, Scale, Setting, find};
use dgd_identify::Prepared;
use dgd_recording::{ChannelMap, ChannelSource, Geometry, Recording, TimeSource, Well};
use dgd_units::STANDARD_GRAVITY_M_S2;
use std::ops::Range;
use std::sync::Arc;

pub(crate) const DT_S: f64 = 2.0;
pub(crate) const PER_BLOCK: usize = 5;
/// Length of a block, s.
pub(crate) const BLOCK_S: f64 = 10.0;
pub(crate) const FLOW_M3_S: f64 = 0.04;
pub(crate) const SPEED_PCT: f64 = 70.0;
pub(crate) const MUD_PUMP_M3_S: f64 = 0.03;

/// An effect of the catalogue with its parameters.
pub(crate) fn one(id: &str, parameters: &[f64]) -> Applied {
    Applied::new(
        find(id).expect("an effect of the catalogue"),
        parameters.to_vec(),
    )
}

/// About a hypothesis, with every row.
pub(crate) fn tangent_at(record: &Record, state: &[Applied]) -> Tangent {
    Tangent::at(record, state, &[], Bend::Stiff).expect("enough rows")
}

/// A finding of high probability without alternatives.
pub(crate) fn named(id: &str, parameters: &[f64]) -> Named {
    Named {
        applied: one(id, parameters),
        evidence: 40.0,
        bent: 0.0,
        hurdle: 3.5,
        probability: 0.9,
        alternatives: Vec::new(),
        held: None,
        most: None,
    }
}

/// What a search has found that allowed for nothing.
pub(crate) fn selection(named: Vec<Named>) -> Selection {
    Selection {
        held: 0,
        allowances: Vec::new(),
        named,
        first: Vec::new(),
        stays: false,
    }
}

/// A finding of the pump's head without parameters.
pub(crate) fn found(effect: &str, probability: f64) -> Finding {
    Finding {
        effect: effect.to_owned(),
        resembles: None,
        title: String::new(),
        probability,
        alternatives: Vec::new(),
        relation: Relation::PumpHead,
        shows_in: Vec::new(),
        pair: None,
        intervals_s: Vec::new(),
        region: String::new(),
        parameters: Vec::new(),
        curve: None,
        held_out: None,
        equation_before: String::new(),
        equation_after: String::new(),
        source: String::new(),
        evidence: 50.0,
        hurdle: 8.0,
        separating_test: None,
        same_as: None,
    }
}

/// A rig without connections, whose instruments have no noise.
pub(crate) fn setting(span_s: (f64, f64)) -> Setting {
    Setting {
        density_kg_m3: 1200.0,
        riser_area_m2: 0.16,
        line_area_m2: 0.02,
        line_diameter_m: 0.16,
        line_length_m: 1500.0,
        riser_volume_m3: 200.0,
        span_s,
        inlet_range_pa: (163e5, 165e5),
        outlets: 2,
        connections: Vec::new(),
        noise: Noise::default(),
    }
}

/// So many blocks of steady drilling without noise.
pub(crate) fn steady(blocks: usize) -> Record {
    let n = blocks * PER_BLOCK;
    let t_s: Vec<f64> = (0..n).map(|i| DT_S * i as f64).collect();
    let all = |value: f64| vec![value; n];
    Record {
        setting: setting((0.0, DT_S * n as f64)),
        dt_s: DT_S,
        speed_error_pct: 0.0,
        coarse_m3_s: 0.0,
        riser: None,
        inlets: Vec::new(),
        outlets: vec![all(184e5)],
        filled: Filled {
            mud_pump: all(MUD_PUMP_M3_S),
            booster: all(0.01),
            topfill: all(0.0),
            flow: all(FLOW_M3_S),
            speed: all(SPEED_PCT),
            inlet: all(164e5),
            outlet: all(184e5),
            pumping: vec![true; n],
        },
        without: Vec::new(),
        seldom: Vec::new(),
        tally: Arc::default(),
        laminar: None,
        suction_heads: None,
        told: Told::default(),
        stops: Vec::new(),
        told_every_s: 2.0,
        per_block: PER_BLOCK,
        blocks,
        t_s,
        mud_pump: all(MUD_PUMP_M3_S),
        booster: all(0.01),
        topfill: all(0.0),
        flow: all(FLOW_M3_S),
        speed: all(SPEED_PCT),
        inlet: all(164e5),
        outlet: all(184e5),
    }
}

/// Three stops of the pump at half an hour each, told by a meter that is late by whole seconds.
pub(crate) fn stops_told_late(late_s: usize) -> Vec<Stop> {
    let n = 5400;
    let stands = |k: usize| k % 1800 >= 1700;
    let while_turning = |value: f64| move |k: usize| if stands(k) { 0.0 } else { value };
    let series = |of: &dyn Fn(usize) -> f64| (0..n).map(of).collect::<Vec<f64>>();
    let metered = |k: usize| while_turning(FLOW_M3_S)(k.saturating_sub(late_s));
    stops(&Readings {
        step_s: 1.0,
        speed_pct: &series(&while_turning(SPEED_PCT)),
        flow_m3_s: &series(&metered),
        outlet_pa: &series(&|k| 180e5 + while_turning(4e5)(k)),
        noise_m3_s: 1e-4,
        per_block: 10,
    })
}

/// Lets the rig's pump stand in some samples.
pub(crate) fn stand(record: &mut Record, samples: &Range<usize>) {
    record.filled.pumping[samples.clone()].fill(false);
    for values in [
        &mut record.flow,
        &mut record.filled.flow,
        &mut record.speed,
        &mut record.filled.speed,
    ] {
        values[samples.clone()].fill(0.0);
    }
}

/// The block means of that drilling.
pub(crate) fn blocks(count: usize) -> Blocks {
    let all = |value: f64| vec![value; count];
    Blocks {
        flow: all(FLOW_M3_S),
        averaged: all(1.0),
        through: all(FLOW_M3_S),
        speed: all(SPEED_PCT),
        drop: all(0.0),
        friction_factor: all(1.0),
        lift: all(20e5),
        head_factor: all(1.0),
        difference: Vec::new(),
        imbalance: vec![0.0; count / 3],
    }
}

/// Friction `f·(q/0.04)²` and head `h·(w/70)² − r·(q/0.04)²`, all in Pa.
pub(crate) fn parabolas(f: f64, h: f64, r: f64) -> Curves {
    let mut curves = Curves {
        scale: Scale {
            flow_m3_s: FLOW_M3_S,
            speed_pct: SPEED_PCT,
            laminar: None,
        },
        friction: [0.0; FRICTION_TERMS],
        head: [0.0; HEAD_TERMS],
    };
    curves.friction[3] = f;
    (curves.head[1], curves.head[3]) = (h, -r);
    curves
}

/// What the drilling of [`drilled`] conceals.
#[derive(Clone, Copy, Default)]
pub(crate) struct Hidden {
    /// By how much the return flow's meter is late, s.
    pub late_s: f64,
    /// Time constant of a store before that meter, s.
    pub store_s: f64,
    /// Time constant with which the pump follows the speed that is measured, s.
    pub lag_s: f64,
    /// Rate of an influx, m³/s: from [`INFLUX_S`] on it rises, stands, and dies away.
    pub influx_m3_s: f64,
    /// How much later the same comes again, s; 0: it does not.
    pub again_s: f64,
    /// How much further than else the flow's levels lie from 0.045 m³/s, as a share.
    pub further: f64,
}

/// Onset, duration, and the share of it in which the influx rises.
pub(crate) const INFLUX_S: (f64, f64, f64) = (1500.0, 1300.0, 0.15);

/// Levels of the return flow, m³/s.
const LEVELS: [f64; 24] = [
    0.040, 0.047, 0.043, 0.052, 0.038, 0.049, 0.045, 0.041, 0.050, 0.042, 0.053, 0.047, 0.039,
    0.046, 0.051, 0.044, 0.038, 0.048, 0.052, 0.043, 0.040, 0.047, 0.050, 0.042,
];

/// An hour and a half of drilling at changing flow, by the equations of the relations, with white noise.
pub(crate) fn drilled(hidden: Hidden) -> Record {
    drilled_through(hidden, &parabolas(4e5, 45e5, 5e5))
}

/// The same through a line of another friction.
pub(crate) fn drilled_through(hidden: Hidden, curves: &Curves) -> Record {
    let mut record = steady(540);
    let n = record.t_s.len();
    // A new level every four minutes, reached within half a minute; what is pumped in came to it before.
    let flow = |t: f64| {
        let steps = LEVELS.windows(2).enumerate().map(|(k, w)| {
            let at = 240.0 * (k + 1) as f64;
            0.5 * (w[1] - w[0]) * (1.0 + ((t - at) / 8.0).tanh())
        });
        let level = LEVELS[0] + steps.sum::<f64>();
        level + hidden.further * (level - 0.045)
    };
    let pumped = |t: f64| flow(t + 20.0);
    let inflow = |t: f64| pumped(t) + hidden_rate(hidden, t);
    let s = &record.setting;
    let pa_m3 = s.density_kg_m3 * STANDARD_GRAVITY_M_S2 / s.riser_area_m2;
    let (column, inertia) = (record.column_pa(), record.inertia());
    let mut inlet = 164e5;
    let mut series = [(); 5].map(|()| Vec::with_capacity(n));
    for t in record.t_s.iter().copied() {
        let q = flow(t);
        let rate = (flow(t + 0.5) - flow(t - 0.5)) / 1.0;
        let outlet = column + curves.friction_pa(q) + inertia * rate;
        // The speed at which the pump lifts that much: its head is `h·(w/70)² − r·(q/0.04)²`.
        let square = (outlet - inlet + 5e5 * (q / FLOW_M3_S).powi(2)) / 45e5;
        for (series, value) in series.iter_mut().zip([
            flow(t - hidden.late_s),
            SPEED_PCT * square.sqrt(),
            inlet,
            outlet,
            // The booster pumps the rest.
            pumped(t) - 0.01,
        ]) {
            series.push(value);
        }
        inlet += DT_S * pa_m3 * (inflow(t + 0.5 * DT_S) - flow(t + 0.5 * DT_S));
    }
    if hidden.store_s > 0.0 {
        let share = 1.0 - (-DT_S / hidden.store_s).exp();
        for i in 1..n {
            series[0][i] = series[0][i - 1] + share * (series[0][i] - series[0][i - 1]);
        }
    }
    if hidden.lag_s > 0.0 {
        // The set-point is ahead of the speed by its slope.
        let speed = series[1].clone();
        for i in 1..n - 1 {
            series[1][i] += hidden.lag_s * (speed[i + 1] - speed[i - 1]) / (2.0 * DT_S);
        }
    }
    let sizes = [2e-4, 0.05, 500.0, 1500.0, 1e-5];
    for (k, (series, size)) in series.iter_mut().zip(sizes).enumerate() {
        let noise = normals(k as u64 + 1, n);
        (series.iter_mut().zip(noise)).for_each(|(v, noise)| *v += size * noise);
    }
    let [flow, speed, inlet, outlet, mud_pump] = series;
    record.setting.noise = Noise {
        mud_pump_m3_s: 1e-5,
        booster_m3_s: 0.0,
        flow_m3_s: 2e-4,
        speed_pct: 0.05,
        inlet_pa: 500.0,
    };
    record.speed_error_pct = 0.03;
    record.outlets = vec![outlet.clone()];
    record.filled.mud_pump.clone_from(&mud_pump);
    record.filled.flow.clone_from(&flow);
    record.filled.speed.clone_from(&speed);
    record.filled.inlet.clone_from(&inlet);
    record.filled.outlet.clone_from(&outlet);
    (record.flow, record.speed, record.mud_pump) = (flow, speed, mud_pump);
    (record.inlet, record.outlet) = (inlet, outlet);
    record
}

/// Rate of the influx at a time.
fn hidden_rate(hidden: Hidden, t: f64) -> f64 {
    let (from, lasts, rise) = INFLUX_S;
    let one = |t: f64| {
        let x = (t - from) / lasts;
        (x / rise).min((1.0 - x) / rise).clamp(0.0, 1.0)
    };
    let again = if hidden.again_s > 0.0 {
        one(t - hidden.again_s)
    } else {
        0.0
    };
    hidden.influx_m3_s * (one(t) + again)
}

/// The recording that a record was made of, and its well, with a clock that starts at some time.
pub(crate) fn recorded(record: &Record, start_s: f64) -> (Well, Prepared) {
    let s = &record.setting;
    let none = || ChannelSource::Constant { si: 0.0 };
    let well = Well {
        mud_density_kg_m3: s.density_kg_m3,
        geometry: Geometry {
            riser_id_m: (4.0 * (s.riser_area_m2 + 0.02) / std::f64::consts::PI).sqrt(),
            drillpipe_od_m: (4.0 * 0.02 / std::f64::consts::PI).sqrt(),
            casing_od_m: None,
            return_line_id_m: (4.0 * s.line_area_m2 / std::f64::consts::PI).sqrt(),
            booster_line_id_m: None,
            pump_inlet_depth_m: 1500.0,
            pump_outlet_depth_m: s.line_length_m,
            riser_pressure_sensor_depth_m: None,
        },
        channels: ChannelMap {
            time: TimeSource::Interval { step_s: DT_S },
            mud_pump_flow: none(),
            booster_flow: none(),
            topfill_flow: none(),
            return_flow: none(),
            pump_inlet_pressure: vec![none()],
            pump_outlet_pressure: vec![none()],
            riser_pressure: None,
            pump_speed: none(),
        },
    };
    let recording = Recording {
        time_s: record.t_s.iter().map(|t| t + start_s).collect(),
        mud_pump_flow_m3_s: record.mud_pump.clone(),
        booster_flow_m3_s: record.booster.clone(),
        topfill_flow_m3_s: record.topfill.clone(),
        return_flow_m3_s: record.flow.clone(),
        pump_inlet_pressure_pa: vec![record.inlet.clone()],
        pump_outlet_pressure_pa: vec![record.outlet.clone()],
        riser_pressure_pa: None,
        pump_speed_pct: record.speed.clone(),
    };
    let prepared = Prepared {
        step_s: DT_S,
        keep: vec![true; record.t_s.len()],
        inlet_pressure_pa: record.inlet.clone(),
        outlet_pressure_pa: record.outlet.clone(),
        tally: Vec::new(),
        stuck: Vec::new(),
        dropouts: Vec::new(),
        recording,
    };
    (well, prepared)
}

/// The first samples that a record measured; what is filled stays whole.
pub(crate) fn cut(mut record: Record, n: usize) -> Record {
    for values in [
        &mut record.t_s,
        &mut record.mud_pump,
        &mut record.booster,
        &mut record.topfill,
        &mut record.flow,
        &mut record.speed,
        &mut record.inlet,
        &mut record.outlet,
    ]
    .into_iter()
    .chain(&mut record.outlets)
    {
        values.truncate(n);
    }
    record
}
