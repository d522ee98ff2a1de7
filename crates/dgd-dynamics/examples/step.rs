//! A pump that is turned up: how far the riser falls, and how fast the flow follows.
//!
//! `cargo run -p dgd-dynamics --example step`
#![expect(clippy::print_stdout, reason = "an example prints")]

use dgd_dynamics::DynamicsError;
use dgd_dynamics::inputs::{Interpolation, Signal};
use dgd_dynamics::integrate::Status;
use dgd_dynamics::return_line::{
    Friction, LineState, PumpHead, ReturnLine, SimulationOptions, simulate_coupled, steady_flow,
};

/// A return line of 350 m.
const LINE: ReturnLine = ReturnLine {
    density_kg_m3: 1080.0,
    riser_area_m2: 0.1704,
    line_area_m2: 0.01824,
    inlet_depth_m: 350.3,
    outlet_depth_m: 350.3,
    friction: Friction {
        b_pa: 0.0,
        c_pa_s_m3: 0.0,
        d_pa_s2_m6: 1.2e8,
        e_pa_s3_m9: 0.0,
    },
    pump: PumpHead {
        c0: 0.0688,
        c1: 0.0,
        c2: 2.4e3,
        n0: 1.95,
        n2: 1.62,
    },
    non_return_valve: true,
    b_is_offset: false,
};

fn main() -> Result<(), DynamicsError> {
    // From 60 to 62 % after 10 s, while as much flows in as before.
    let (before_pct, after_pct, level_m) = (60.0, 62.0, 150.0);
    let (flow_m3_s, _) = steady_flow(&LINE, level_m, before_pct)?;
    let time_s: Vec<f64> = (0..=36_000).map(|i| 0.1 * f64::from(i)).collect();
    let (flows, speeds) = ([flow_m3_s; 2], [before_pct, after_pct, after_pct]);
    let inflow = Signal::new("inflow", &[0.0, 3600.0], &flows, Interpolation::Linear)?;
    let speed = Signal::new("speed", &[0.0, 10.0, 3600.0], &speeds, Interpolation::Hold)?;
    let start = LineState { level_m, flow_m3_s };
    let options = SimulationOptions::default();
    let run = simulate_coupled(&LINE, start, &inflow, &speed, &time_s, &options)?;
    if run.status != Status::Finished {
        println!("the simulation ended early: {:?}", run.status);
        return Ok(());
    }
    let most = run.flow_m3_s.iter().copied().fold(0.0, f64::max);
    let half = flow_m3_s + 0.5 * (most - flow_m3_s);
    let reached = run.time_s.iter().zip(&run.flow_m3_s);
    let half_s = reached.filter(|(_, q)| **q >= half).map(|(t, _)| *t - 10.0);
    println!(
        "the flow rises from {:.1} to {:.1} L/s, half of it within {:.1} s",
        1e3 * flow_m3_s,
        1e3 * most,
        half_s.fold(f64::INFINITY, f64::min)
    );
    let (level, flow) = (&run.level_m, &run.flow_m3_s);
    println!(
        "the riser falls by {:.1} m in an hour, until the pump lifts no more than flows in: {:.1} L/s",
        level.last().map_or(f64::NAN, |h| h - level_m),
        flow.last().map_or(f64::NAN, |q| 1e3 * q)
    );
    Ok(())
}
