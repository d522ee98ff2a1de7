//! What a simulation costs: fits call it thousands of times.
#![allow(missing_docs, clippy::unwrap_used, reason = "bench")]

use criterion::{Criterion, criterion_group, criterion_main};
use dgd_assembly::{Assembly, FitOptions, Portion, Record, SimulationOptions, Simulator, fit};
use std::hint::black_box;

fn two_tanks(c: &mut Criterion) {
    let assembly = Assembly::parse(include_str!("../examples/two_tanks.toml")).unwrap();
    let u: Vec<f64> = (0..1000).map(|i| 4.0 + 2.0 * f64::from(i).sin()).collect();
    let record = Record {
        columns: vec![("u", &u)],
    };
    let window = assembly.windows(&record, Portion::Train).unwrap().remove(0);
    let theta = assembly.start();
    let mut simulator =
        Simulator::new(&assembly, &window, 0, &SimulationOptions::default()).unwrap();
    c.bench_function("two tanks, 1000 samples, input held anew at each", |b| {
        b.iter(|| simulator.run(black_box(&theta)).unwrap());
    });
}

fn return_line(c: &mut Criterion) {
    let assembly = Assembly::parse(include_str!("../examples/return_line.toml")).unwrap();
    let t: Vec<f64> = (0..1000).map(f64::from).collect();
    let q: Vec<f64> = t.iter().map(|t| 0.05 + 0.004 * (t * 0.7).sin()).collect();
    let w: Vec<f64> = t.iter().map(|t| 62.0 + 3.0 * (t * 0.5).cos()).collect();
    let record = Record {
        columns: vec![("t", &t), ("q_in", &q), ("w", &w)],
    };
    let window = assembly.windows(&record, Portion::Train).unwrap().remove(0);
    let mut simulator =
        Simulator::new(&assembly, &window, 0, &SimulationOptions::default()).unwrap();
    c.bench_function("return line, 1000 s, inputs bent at each", |b| {
        b.iter(|| simulator.run(black_box(&[])).unwrap());
    });
}

fn six_states(c: &mut Criterion) {
    let assembly = Assembly::parse(include_str!("../examples/dual_gradient.toml")).unwrap();
    let t: Vec<f64> = (0..1000).map(f64::from).collect();
    let p: Vec<f64> = t.iter().map(|t| 0.035 + 0.004 * (t * 0.7).sin()).collect();
    let b = vec![0.01; 1000];
    let f = vec![0.001; 1000];
    let w: Vec<f64> = t.iter().map(|t| 62.0 + 3.0 * (t * 0.5).cos()).collect();
    let columns: Vec<(&str, &[f64])> = vec![
        ("t", &t),
        ("q_p", &p),
        ("q_bp", &b),
        ("q_tf", &f),
        ("w", &w),
    ];
    let window = assembly
        .windows(&Record { columns }, Portion::Train)
        .unwrap()
        .remove(0);
    let theta = assembly.start();
    let mut simulator =
        Simulator::new(&assembly, &window, 0, &SimulationOptions::default()).unwrap();
    c.bench_function("dual gradient, six states, 1000 s", |b| {
        b.iter(|| simulator.run(black_box(&theta)).unwrap());
    });
}

fn fitting(c: &mut Criterion) {
    let base = Assembly::parse(include_str!("../examples/two_tanks.toml")).unwrap();
    let u: Vec<f64> = (0..1000)
        .map(|i| 6.0 + 5.0 * (f64::from(i) * 0.07).sin())
        .collect();
    let mut window = base
        .windows(
            &Record {
                columns: vec![("u", &u)],
            },
            Portion::Train,
        )
        .unwrap()
        .remove(0);
    let with = base
        .with_effect("upper", "overflow_caught", &["share"])
        .unwrap()
        .with_effect("lower_outlet", "laminar_resistance", &["drop"])
        .unwrap();
    let truth = with.start();
    window.readings = with
        .simulate(&truth, &window, 0, &SimulationOptions::default())
        .unwrap()
        .outputs;
    // A millimetre of ripple, or the cost would fall for ever.
    for (i, reading) in (0..).zip(window.readings.iter_mut().flatten()) {
        *reading += 1e-3 * (f64::from(i) * 1.7).sin();
    }
    let start: Vec<f64> = with
        .parameters()
        .iter()
        .map(|p| 0.8 * p.start + 0.2 * p.low)
        .collect();
    let windows = [window];
    c.bench_function("fit of six parameters to 1000 samples of two tanks", |b| {
        b.iter(|| {
            fit(
                &with,
                &windows,
                &FitOptions {
                    start: Some(start.clone()),
                    ..FitOptions::default()
                },
            )
            .unwrap()
        });
    });
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = two_tanks, return_line, six_states, fitting
}
criterion_main!(benches);
