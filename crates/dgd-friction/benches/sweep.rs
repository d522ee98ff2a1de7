//! Cost of the delay sweep on 85 h at 1 Hz: `cargo bench -p dgd-friction`.
#![allow(missing_docs, clippy::cast_possible_truncation, reason = "a benchmark")]
use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use dgd_friction::{Loss, Samples, SweepOptions, Terms, delay_sweep, fit};

const ROWS: usize = 305_820;

/// Deterministic noise of mean 0 in -1..1.
fn noise(i: usize) -> f64 {
    let mut z = (i as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    f64::from((z >> 40) as u32 & 0xFF_FFFF) / 2f64.powi(23) - 1.0
}

fn sweep(c: &mut Criterion) {
    let at = |t: f64| 0.045 + 0.02 * (t / 4000.0).sin() + 0.003 * (t / 37.0).sin();
    // Flow in steps of 0.5 gpm; every eighth stretch of 500 samples is not kept.
    let flow: Vec<f64> = (0..ROWS)
        .map(|i| {
            let step = 0.5 * 6.3090e-5;
            (at(i as f64 - 6.0) / step).round() * step
        })
        .collect();
    let friction: Vec<f64> = (0..ROWS)
        .map(|i| {
            let q = at(i as f64);
            1e6 * q + 9.5e7 * q * q + 5e3 * noise(i)
        })
        .collect();
    let keep: Vec<bool> = (0..ROWS).map(|i| i / 500 % 8 != 3).collect();
    let samples = Samples {
        flow_m3_s: &flow,
        friction_pa: &friction,
        keep: &keep,
        keep_delayed: false,
    };
    let options = SweepOptions::default();
    for (name, terms) in [
        ("quadratic", Terms::Quadratic),
        ("offset_cubic", Terms::OffsetCubic),
    ] {
        c.bench_function(&format!("sweep_31_delays/{name}"), |b| {
            b.iter(|| delay_sweep(black_box(&samples), &terms, &options));
        });
        c.bench_function(&format!("fit_one_delay/{name}"), |b| {
            b.iter(|| fit(black_box(&samples), 6, &terms, Loss::Squared));
        });
    }
}

criterion_group!(benches, sweep);
criterion_main!(benches);
