//! A recording made by integrating the model that is replayed.

use dgd_dynamics::inputs::{Interpolation, Signal};
use dgd_dynamics::return_line::{
    Friction, LineState, PumpHead, ReturnLine, SimulationOptions, derive_outputs, measured_flow,
    simulate_coupled,
};
use dgd_recording::Recording;
use dgd_replay::{Kind, Replay, ReplayOptions, replay};

pub(crate) const DELAY_S: f64 = 12.0;
pub(crate) const START: LineState = LineState {
    level_m: 160.0,
    flow_m3_s: 0.05,
};

pub(crate) fn line() -> ReturnLine {
    ReturnLine {
        density_kg_m3: 1080.0,
        riser_area_m2: 0.1704,
        line_area_m2: 0.01824,
        inlet_depth_m: 350.3,
        outlet_depth_m: 350.3,
        friction: Friction {
            b_pa: 2e4,
            c_pa_s_m3: 0.0,
            d_pa_s2_m6: 1.2e8,
            e_pa_s3_m9: 4e8,
        },
        pump: PumpHead {
            c0: 0.0688,
            c1: 3.0,
            c2: 2.4e3,
            n0: 1.95,
            n2: 1.62,
        },
        non_return_valve: true,
        b_is_offset: false,
    }
}

/// Tight enough that what is left is not the integrator's.
pub(crate) fn tight() -> SimulationOptions {
    SimulationOptions {
        relative: 1e-9,
        level_tolerance_m: 1e-8,
        flow_tolerance_m3_s: 1e-10,
        ..SimulationOptions::default()
    }
}

/// `samples` seconds at 1 Hz: ramps of speed, a varying inflow of three pumps, two transmitters a
/// side that lie 2 kPa apart.
pub(crate) fn recording(samples: u32) -> Recording {
    let time_s: Vec<f64> = (0..samples).map(f64::from).collect();
    let of =
        |value: &dyn Fn(f64) -> f64| -> Vec<f64> { time_s.iter().map(|t| value(*t)).collect() };
    let mud = of(&|t| 0.035 + 0.004 * (t / 210.0).sin());
    let booster = of(&|t| 0.012 + 0.002 * (t / 75.0).cos());
    let topfill = of(&|_| 0.002);
    let speed = of(&|t| 62.0 + 2.0 * (t / 120.0).sin().clamp(-0.5, 0.5));
    let inflow: Vec<f64> = (0..time_s.len())
        .map(|i| mud[i] + booster[i] + topfill[i])
        .collect();
    let signal = |name, values| Signal::new(name, &time_s, values, Interpolation::Linear).unwrap();
    let (q_in, w) = (signal("inflow", &inflow), signal("speed", &speed));
    let run = simulate_coupled(&line(), START, &q_in, &w, &time_s, &tight()).unwrap();
    let seen = derive_outputs(&line(), &run.level_m, &run.flow_m3_s, &speed, true).unwrap();
    let twins = |values: &[f64]| {
        [-1e3, 1e3]
            .map(|off| values.iter().map(|p| p + off).collect())
            .to_vec()
    };
    Recording {
        return_flow_m3_s: measured_flow(&time_s, &run.flow_m3_s, DELAY_S).unwrap(),
        pump_inlet_pressure_pa: twins(&seen.inlet_pa),
        pump_outlet_pressure_pa: twins(&seen.outlet_pa),
        riser_pressure_pa: None,
        mud_pump_flow_m3_s: mud,
        booster_flow_m3_s: booster,
        topfill_flow_m3_s: topfill,
        pump_speed_pct: speed,
        time_s,
    }
}

pub(crate) fn options(kind: Kind) -> ReplayOptions {
    ReplayOptions {
        kind,
        delay_s: DELAY_S,
        solver: tight(),
        ..ReplayOptions::default()
    }
}

pub(crate) fn run(recording: &Recording, options: &ReplayOptions) -> Replay {
    replay(&line(), recording, options).unwrap()
}
