//! Two-state simulation, 1 Hz inputs whose slope changes at every sample, output at 1 s.
#![allow(clippy::unwrap_used, missing_docs, reason = "bench")]

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use dgd_dynamics::inputs::{Interpolation, Signal};
use dgd_dynamics::integrate::{Method, Status};
use dgd_dynamics::return_line::{
    Friction, LineState, PumpHead, ReturnLine, SimulationOptions, simulate_coupled, steady_state,
};

/// A line of the size of the thesis's.
fn line() -> ReturnLine {
    ReturnLine {
        density_kg_m3: 1080.0,
        riser_area_m2: 0.170_44,
        line_area_m2: 0.018_241,
        inlet_depth_m: 350.3,
        outlet_depth_m: 350.3,
        friction: Friction {
            b_pa: 12_650.0,
            d_pa_s2_m6: 1.28e8,
            e_pa_s3_m9: -2.3e8,
            ..Friction::default()
        },
        pump: PumpHead {
            c0: 0.068_78,
            c1: 0.05,
            c2: 8926.0,
            n0: 1.9546,
            n2: 1.6243,
        },
        non_return_valve: true,
        b_is_offset: false,
    }
}

/// Inflow and speed with slow swings and noise from a fixed linear congruential generator.
fn inputs(seconds: u32) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let mut seed = 12_345_u64;
    let mut noise = || {
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        f64::from(u32::try_from(seed >> 32).unwrap()) / f64::from(u32::MAX) - 0.5
    };
    let time: Vec<f64> = (0..=seconds).map(f64::from).collect();
    let inflow = time
        .iter()
        .map(|t| 0.05 + 0.004 * (t * 0.003).sin() + 0.001 * noise())
        .collect();
    let speed = time
        .iter()
        .map(|t| 62.0 + 2.0 * (t * 0.002).cos() + 0.2 * noise())
        .collect();
    (time, inflow, speed)
}

fn benches(c: &mut Criterion) {
    let line = line();
    for seconds in [6_000, 305_820] {
        let (time, inflow, speed) = inputs(seconds);
        let mut group = c.benchmark_group(format!("coupled_{seconds}_s"));
        for method in [Method::Rodas3, Method::Rodasp, Method::DormandPrince] {
            let options = SimulationOptions {
                method,
                ..SimulationOptions::default()
            };
            group
                .sample_size(20)
                .bench_function(format!("{method:?}"), |b| {
                    b.iter(|| {
                        let u = Signal::new("u", &time, &inflow, Interpolation::Linear).unwrap();
                        let w = Signal::new("w", &time, &speed, Interpolation::Linear).unwrap();
                        let start = LineState {
                            level_m: 140.0,
                            flow_m3_s: 0.05,
                        };
                        let run =
                            simulate_coupled(black_box(&line), start, &u, &w, &time, &options)
                                .unwrap();
                        assert_eq!(run.status, Status::Finished);
                        run
                    });
                });
        }
        let level = vec![140.0; time.len()];
        group.bench_function("steady_state", |b| {
            b.iter(|| steady_state(black_box(&line), &level, &speed).unwrap());
        });
        group.finish();
    }
}

criterion_group!(simulate, benches);
criterion_main!(simulate);
