//! Cost of the pump fits on 85 h at 1 Hz: `cargo bench -p dgd-pump`.
#![allow(missing_docs, clippy::cast_possible_truncation, reason = "a benchmark")]
use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use dgd_pump::{
    ConstrainedOptions, HeadCurve, Samples, SearchOptions, fit_constrained, fit_unconstrained,
    search_exponents,
};

const ROWS: usize = 305_820;

/// Deterministic noise of mean 0 in -1..1.
fn noise(i: usize) -> f64 {
    let mut z = (i as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    f64::from((z >> 40) as u32 & 0xFF_FFFF) / 2f64.powi(23) - 1.0
}

fn search(c: &mut Criterion) {
    let curve = HeadCurve {
        c0: 0.08,
        c1: 2.0,
        c2: 6e3,
        n0: 1.93,
        n2: 1.64,
    };
    // Speed in steps of 0.1 %, flow in steps of 0.5 gpm.
    let speed: Vec<f64> = (0..ROWS)
        .map(|i| ((70.0 + 20.0 * (i as f64 / 5000.0).sin() + 5.0 * noise(i)) * 10.0).round() / 10.0)
        .collect();
    let flow: Vec<f64> = (0..ROWS)
        .map(|i| {
            let step = 0.5 * 6.3090e-5;
            let q = 0.045 + 0.03 * (i as f64 / 3100.0).cos() + 0.01 * noise(i + ROWS);
            (q / step).round() * step
        })
        .collect();
    let head: Vec<f64> = (0..ROWS)
        .map(|i| curve.head_m(speed[i], flow[i]) + noise(i + 2 * ROWS))
        .collect();
    let keep: Vec<bool> = (0..ROWS).map(|i| i / 500 % 8 != 3).collect();
    let quantised = Samples {
        speed_pct: &speed,
        flow_m3_s: &flow,
        head_m: &head,
        keep: &keep,
    };
    c.bench_function("search_exponents/quantised", |b| {
        b.iter(|| search_exponents(black_box(&quantised), &SearchOptions::default()));
    });
    c.bench_function("fit_unconstrained", |b| {
        b.iter(|| fit_unconstrained(black_box(&quantised), 2.0, 2.0));
    });
    c.bench_function("fit_constrained", |b| {
        b.iter(|| {
            fit_constrained(
                black_box(&quantised),
                2.0,
                2.0,
                &ConstrainedOptions::default(),
            )
        });
    });
    let spread = |x: &[f64]| -> Vec<f64> {
        x.iter()
            .enumerate()
            .map(|(i, x)| x * (1.0 + 1e-7 * noise(i)))
            .collect()
    };
    let (speed, flow) = (spread(&speed), spread(&flow));
    let continuous = Samples {
        speed_pct: &speed,
        flow_m3_s: &flow,
        ..quantised
    };
    let mut slow = c.benchmark_group("search_exponents");
    slow.sample_size(10);
    slow.bench_function("nothing_repeats", |b| {
        b.iter(|| search_exponents(black_box(&continuous), &SearchOptions::default()));
    });
}

criterion_group!(benches, search);
criterion_main!(benches);
