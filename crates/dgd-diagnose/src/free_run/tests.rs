//! Claims about the two free runs, and about what they are worth on samples that were chosen.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

use super::{Errors, Part, errors, headline_gain, simulate};
use crate::numbers::mean;
use crate::record::Record;
use crate::test_rig::{DT_S, Hidden, cut, drilled, normals, parabolas, recorded, setting, steady};
use crate::{DiagnoseError, Signal, Simulation};
use dgd_effects::{AppliedEffect, AugmentedModel, Inputs};

const START_S: f64 = 5000.0;

fn signal(name: &'static str, before: Vec<f64>, after: Vec<f64>) -> Signal {
    Signal {
        name,
        measured: vec![7.0; before.len()],
        before: before.iter().map(|e| 7.0 + e).collect(),
        after: after.iter().map(|e| 7.0 - e).collect(),
    }
}

/// A sample a second, all of them trusted, held out from some on.
fn simulated(from: usize, signals: Vec<Signal>) -> Simulation {
    let n = signals[0].measured.len();
    Simulation {
        t_s: (0..n).map(|i| i as f64).collect(),
        held_out: (0..n).map(|i| i >= from).collect(),
        valid: vec![true; n],
        signals,
    }
}

#[test]
fn errors_are_those_of_samples_that_are_chosen_trusted_and_whole() {
    // Errors of 3 and 5 before, of 1 and 2 after, held out; of 30 and 10 elsewhere.
    let off_by = |first: f64, held: [f64; 2]| -> Vec<f64> {
        (0..1200)
            .map(|i| if i < 600 { first } else { held[i % 2] })
            .collect()
    };
    let mut whole = simulated(
        600,
        vec![signal(
            "a",
            off_by(30.0, [3.0, 5.0]),
            off_by(10.0, [1.0, 2.0]),
        )],
    );
    whole.valid[700] = false;
    whole.valid[701] = false;
    whole.signals[0].before[700..702].fill(1e9);
    whole.signals[0].measured[702] = f64::NAN;
    whole.signals[0].before[703] = f64::NAN;
    whole.signals[0].after[704] = f64::INFINITY;
    whole.signals[0].after[705] = f64::NAN;
    let Errors { before, after } = errors(&whole, Part::HeldOut)[0].unwrap();
    let ci = headline_gain(&whole).unwrap().improvement_ci95;
    assert!((before - 17.0_f64.sqrt()).abs() < 1e-12, "{before}");
    assert!((after - 2.5_f64.sqrt()).abs() < 1e-12, "{after}");
    // Both stretches of five minutes gain alike.
    let gain = 1.0 - (2.5_f64 / 17.0).sqrt();
    assert!(
        (ci.0 - gain).abs() < 1e-3 && (ci.1 - gain).abs() < 1e-3,
        "{ci:?}"
    );
    let Errors { before, after } = errors(&whole, Part::Training)[0].unwrap();
    assert!((before - 30.0).abs() < 1e-12 && (after - 10.0).abs() < 1e-12);
}

/// Of two stretches one is drawn twice once in four times: the interval ends at what each gains by itself.
#[test]
fn what_hangs_together_for_five_minutes_is_drawn_together() {
    let gained = |i: usize, last: usize| if i <= last { 0.9 } else { 0.2 };
    // A stretch holds what comes within 300 s of its first sample, that included.
    for (gap, last) in [(0, 300), (40, 300)] {
        let after = (0..600).map(|i| 1.0 - gained(i, last)).collect();
        let mut two = simulated(0, vec![signal("a", vec![1.0; 600], after)]);
        // What is not chosen belongs to none.
        for i in 250..250 + gap {
            two.valid[i] = false;
        }
        let ci = headline_gain(&two).unwrap().improvement_ci95;
        assert!(
            (ci.0 - 0.2).abs() < 1e-12 && (ci.1 - 0.9).abs() < 1e-12,
            "{ci:?}"
        );
    }
}

/// For many independent stretches the interval is that of a normal mean, by the linearised root of a ratio.
#[test]
fn the_interval_holds_ninety_five_of_a_hundred_draws() {
    let stretches = 400;
    let share: Vec<f64> = normals(3, stretches)
        .iter()
        .map(|v| 1.0 + 0.3 * v)
        .collect();
    let n = 301 * stretches;
    let after = (0..n)
        .map(|i| 0.5 * share[i / 301].max(0.0).sqrt())
        .collect();
    let long = simulated(0, vec![signal("a", vec![1.0; n], after)]);
    let best = headline_gain(&long).unwrap();
    let (gain, ci) = (
        1.0 - best.rmse_after / best.rmse_before,
        best.improvement_ci95,
    );
    // The mean of squares is 0.25 with a share of 0.3 / 20 of it as its deviation; the root has half of that.
    let sd = 0.5 * 0.5 * 0.3 / 20.0;
    for end in [gain - ci.0, ci.1 - gain] {
        assert!(
            (end / (1.96 * sd) - 1.0).abs() < 0.25,
            "{end} for {}",
            1.96 * sd
        );
    }
}

#[test]
fn what_was_exact_stays_exact_and_without_samples_there_is_no_error() {
    let exact = simulated(0, vec![signal("a", vec![0.0; 400], vec![0.0; 400])]);
    let best = headline_gain(&exact).unwrap();
    assert_eq!((best.rmse_before, best.rmse_after), (0.0, 0.0));
    assert_eq!(best.improvement_ci95, (1.0, 1.0));
    assert!(errors(&exact, Part::Training)[0].is_none());
}

#[test]
fn the_headline_signal_has_the_least_share_left_whatever_the_unit_and_where_none_gains_the_most() {
    let of = |before: f64, after: f64, name| signal(name, vec![before; 700], vec![after; 700]);
    let mut many = simulated(
        300,
        vec![
            of(1e-3, 5e-4, "half"),
            of(1e3, 1e2, "tenth"),
            of(1e5, 9e4, "most"),
            of(f64::NAN, 0.0, "none"),
        ],
    );
    let best = headline_gain(&many).unwrap();
    assert_eq!(best.signal, "tenth");
    assert!((best.rmse_before - 1e3).abs() < 1e-6 && (best.rmse_after - 1e2).abs() < 1e-6);
    assert!((best.improvement_ci95.0 - 0.9).abs() < 1e-9);
    assert!((best.improvement_ci95.1 - 0.9).abs() < 1e-9);
    many.held_out.fill(false);
    assert!(headline_gain(&many).is_none());
    let harmed = vec![
        of(1e-3, 1.1e-3, "tenth"),
        of(1.0, 5.0, "worst"),
        of(2.0, 3.0, "half"),
    ];
    assert_eq!(
        headline_gain(&simulated(300, harmed)).unwrap().signal,
        "worst"
    );
}

/// The curves by which the drilling was made.
fn model() -> AugmentedModel {
    AugmentedModel {
        curves: parabolas(4e5, 45e5, 5e5),
        speed_range_pct: (50.0, 90.0),
        ratio_range: (1e-4, 1e-3),
        span_s: None,
        inlet_range_pa: None,
        effects: Vec::new(),
    }
}

/// The same with an influx from the start on.
fn with_influx() -> AugmentedModel {
    AugmentedModel {
        effects: vec![AppliedEffect {
            id: "influx".to_owned(),
            parameters: vec![1e-3, 0.0, 1e5, 0.01],
        }],
        ..model()
    }
}

fn ran(record: &Record, windows: &[(f64, f64)]) -> Simulation {
    let (well, prepared) = recorded(record, START_S);
    let windows: Vec<(f64, f64)> = windows
        .iter()
        .map(|w| (w.0 + START_S, w.1 + START_S))
        .collect();
    simulate(&well, record, &prepared, &windows, &model(), &with_influx()).unwrap()
}

#[test]
fn samples_are_held_out_from_the_start_of_a_window_to_before_its_end() {
    let mut record = steady(90);
    record.setting = setting((START_S, START_S + 900.0));
    let run = ran(&record, &[(100.0, 200.0), (200.0, 230.0), (600.0, 610.0)]);
    for (i, t) in run.t_s.iter().enumerate() {
        assert_eq!(*t, START_S + DT_S * i as f64);
        let within = |a: f64, b: f64| *t >= START_S + a && *t < START_S + b;
        assert_eq!(
            run.held_out[i],
            within(100.0, 230.0) || within(600.0, 610.0),
            "{t}"
        );
    }
    assert_eq!(run.valid, vec![true; record.t_s.len()]);
}

/// A stretch is simulated by itself: an hour, or a window, or what is between two.
#[test]
fn every_stretch_starts_from_the_mean_of_its_first_five_seconds_and_runs_free() {
    let record = drilled(Hidden::default());
    let (well, prepared) = recorded(&record, START_S);
    let run = ran(&record, &[(1000.0, 2260.0)]);
    let [flow, level, outlet, head] = &run.signals[..] else {
        panic!("{} signals", run.signals.len());
    };
    let names = [flow.name, level.name, outlet.name, head.name];
    assert_eq!(
        names,
        [
            "return_flow_m3_s",
            "riser_level_m",
            "pump_outlet_pressure_pa",
            "pump_head_m"
        ]
    );
    assert_eq!(flow.measured, record.flow);
    assert_eq!(outlet.measured, record.outlet);
    let inputs = Inputs {
        time_s: &run.t_s,
        step_s: DT_S,
        mud_pump_m3_s: &record.mud_pump,
        booster_m3_s: &record.booster,
        topfill_m3_s: &record.filled.topfill,
        speed_pct: &record.speed,
    };
    // From 0 s, 1000 s, 2260 s; the last stretch is shorter than an hour.
    for stretch in [0..500, 500..1130, 1130..record.t_s.len()] {
        // Three samples, two seconds apart.
        let few = stretch.start..stretch.start + 3;
        let state = (mean(&record.inlet[few.clone()]), mean(&record.flow[few]));
        for (model, after) in [(model(), false), (with_influx(), true)] {
            let alone = model
                .free_run(&record.setting, inputs, stretch.clone(), state)
                .unwrap();
            for (k, i) in stretch.clone().enumerate() {
                let of = |s: &Signal| if after { s.after[i] } else { s.before[i] };
                assert_eq!(of(flow), alone.return_flow_m3_s[k]);
                assert_eq!(of(outlet), alone.outlet_pa[k]);
                assert_eq!(of(level), well.level_m(alone.inlet_pa[k]));
                assert_eq!(of(head), well.head_m(alone.inlet_pa[k], alone.outlet_pa[k]));
                assert_eq!(
                    level.measured[i],
                    well.level_m(prepared.inlet_pressure_pa[i])
                );
                assert_eq!(
                    head.measured[i],
                    well.head_m(prepared.inlet_pressure_pa[i], record.outlet[i])
                );
            }
        }
    }
    // By the equations that it was made by, the run stays with the drilling.
    let far = |s: &Signal| {
        let both = s.measured.iter().zip(&s.before);
        both.map(|(m, b)| (m - b).abs()).fold(0.0, f64::max)
    };
    assert!(
        far(level) < 5.0 && far(flow) < 5e-3,
        "{} m, {} m3/s",
        far(level),
        far(flow)
    );
}

#[test]
fn an_hour_is_run_at_a_time() {
    let mut long = steady(800);
    // A level that the steady flows do not have: the run drifts until it starts anew.
    long.booster.fill(0.012);
    let run = ran(&long, &[]);
    let level = &run.signals[1];
    let off = |i: usize| (level.before[i] - level.measured[i]).abs();
    assert!(off(0) < 1e-9 && off(1800) < 1e-9, "{} m", off(1800));
    assert!(
        (1..1800).all(|i| off(i) > 0.0) && off(1799) > 1.0,
        "{} m",
        off(1799)
    );
}

#[test]
fn a_stretch_begins_at_its_first_sample_with_a_level_and_a_flow_that_is_not_negative() {
    let mut record = steady(90);
    record.inlet[..7].fill(f64::NAN);
    record.flow[5..11].fill(f64::NAN);
    record.flow[11..16].fill(-0.01);
    let run = ran(&record, &[]);
    let flow = &run.signals[0];
    for series in [&flow.before, &flow.after] {
        assert!(series[..11].iter().all(|v| v.is_nan()));
        assert!(series[11..].iter().all(|v| v.is_finite()));
        assert_eq!(series[11], 0.0);
    }
    // Without either there is nothing to start from.
    record.flow.fill(f64::NAN);
    let run = ran(&record, &[]);
    assert!(run.signals[0].before.iter().all(|v| v.is_nan()));
}

#[test]
fn a_model_of_unknown_effects_cannot_be_run_and_an_empty_recording_gives_nothing() {
    let record = steady(30);
    let (well, prepared) = recorded(&record, START_S);
    let strange = AugmentedModel {
        effects: vec![AppliedEffect {
            id: "poltergeist".to_owned(),
            parameters: vec![1.0],
        }],
        ..model()
    };
    let refused = simulate(&well, &record, &prepared, &[], &model(), &strange).unwrap_err();
    assert!(matches!(refused, DiagnoseError::UnknownEffect(_)));
    let empty = cut(record, 0);
    let run = ran(&empty, &[]);
    assert!(run.t_s.is_empty() && run.signals.len() == 4);
}
