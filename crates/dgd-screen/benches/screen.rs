//! Screening of 10,000 to 305,820 samples of nine series.
#![allow(missing_docs, reason = "criterion's macros define undocumented items")]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use dgd_recording::Recording;
use dgd_screen::{ScreenOptions, screen};
use std::hint::black_box;

/// Noisy, quantised, with a pump stop of 5 minutes every hour and a stuck meter after it.
fn recording(n: usize) -> Recording {
    let mut state = 1u64;
    let mut noise = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / f64::from(1u32 << 23) - 1.0
    };
    let mut series = |level: f64, sigma: f64, quantum: f64, off: f64| -> Vec<f64> {
        (0..n)
            .map(|i| {
                let stopped = i % 3600 < 300;
                let truth = level * (1.0 + 0.05 * (i as f64 / 700.0).sin());
                let value = if stopped {
                    off
                } else {
                    truth + sigma * noise()
                };
                (value / quantum).round() * quantum
            })
            .collect()
    };
    let mut recording = Recording {
        time_s: (0..n).map(|i| i as f64).collect(),
        mud_pump_flow_m3_s: series(0.03, 2e-4, 6.309e-5, 0.0),
        booster_flow_m3_s: series(0.014, 1e-4, 6.309e-5, 0.0),
        topfill_flow_m3_s: series(0.002, 5e-5, 3.155e-5, 0.002),
        return_flow_m3_s: series(0.045, 4e-4, 3.155e-5, 0.0),
        pump_inlet_pressure_pa: vec![
            series(24e5, 3e3, 1379.0, 24e5),
            series(24e5, 3e3, 1379.0, 24e5),
        ],
        pump_outlet_pressure_pa: vec![
            series(40e5, 8e3, 1379.0, 38e5),
            series(40e5, 8e3, 1379.0, 38e5),
        ],
        riser_pressure_pa: Some(series(25e5, 3e3, 1379.0, 25e5)),
        pump_speed_pct: series(60.0, 0.05, 0.1, 0.0),
    };
    for start in (1000..n.saturating_sub(200)).step_by(3600) {
        let held = recording.return_flow_m3_s[start];
        recording.return_flow_m3_s[start..start + 200].fill(held);
        recording.pump_outlet_pressure_pa[0][start + 100] = 0.0;
    }
    recording
}

fn screening(c: &mut Criterion) {
    let mut group = c.benchmark_group("screen");
    for n in [10_000, 100_000, 305_820] {
        let recording = recording(n);
        group.throughput(Throughput::Elements(n as u64));
        group.bench_with_input(
            BenchmarkId::from_parameter(n),
            &recording,
            |b, recording| {
                b.iter(|| screen(black_box(recording), 1.0, &ScreenOptions::default()));
            },
        );
    }
    group.finish();
}

criterion_group!(benches, screening);
criterion_main!(benches);
