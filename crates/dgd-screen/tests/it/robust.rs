use crate::synthetic::{every, steady};
use dgd_recording::{Recording, Uneven};
use dgd_screen::{Limits, Reasons, ScreenError, ScreenOptions, screen};
use proptest::prelude::*;

#[test]
fn a_series_of_another_length_is_refused_by_name() {
    let mut recording = steady(100, 1.0);
    recording.pump_outlet_pressure_pa[1].pop();
    let error = screen(&recording, 1.0, &ScreenOptions::default()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "`pump_outlet_pressure 2` has 99 samples, expected 100 to match the time"
    );
}

#[test]
fn a_step_that_is_none_is_refused() {
    for step_s in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = screen(&steady(10, 1.0), step_s, &ScreenOptions::default()).unwrap_err();
        assert!(matches!(error, ScreenError::Step { .. }), "{error}");
    }
}

#[test]
fn a_clock_that_is_not_even_or_of_another_step_is_refused() {
    let options = ScreenOptions::default();
    let mut jumped = steady(100, 1.0);
    jumped.time_s[40..].iter_mut().for_each(|t| *t += 500.0);
    let error = screen(&jumped, 1.0, &options).unwrap_err();
    let expected = Uneven::Step {
        sample: 40,
        found_s: 501.0,
        step_s: 1.0,
    };
    assert_eq!(error, ScreenError::Uneven(expected));
    for step_s in [0.5, 0.97, 1.4, 60.0] {
        let error = screen(&steady(100, 1.0), step_s, &options).unwrap_err();
        assert!(matches!(error, ScreenError::Uneven(_)), "{step_s}: {error}");
    }
}

#[test]
fn an_option_that_cannot_be_is_refused_by_name() {
    let wrong = [
        (
            "settle_s",
            ScreenOptions {
                settle_s: -1.0,
                ..ScreenOptions::default()
            },
        ),
        (
            "stuck_chance",
            ScreenOptions {
                stuck_chance: 1.0,
                ..ScreenOptions::default()
            },
        ),
        (
            "pump_on_above_pct",
            ScreenOptions {
                pump_on_above_pct: f64::NAN,
                ..ScreenOptions::default()
            },
        ),
        (
            "flow_m3_s.low",
            ScreenOptions {
                flow_m3_s: Limits {
                    low: 1.0,
                    high: 0.0,
                },
                ..ScreenOptions::default()
            },
        ),
        (
            "flow_m3_s.high",
            ScreenOptions {
                flow_m3_s: Limits {
                    low: 0.0,
                    high: f64::NAN,
                },
                ..ScreenOptions::default()
            },
        ),
    ];
    for (field, options) in wrong {
        match screen(&steady(10, 1.0), 1.0, &options).unwrap_err() {
            ScreenError::Option { name, .. } => assert_eq!(name, field),
            other => panic!("{other}"),
        }
    }
}

#[test]
fn empty_short_and_silent_recordings_have_nothing_to_keep() {
    let options = ScreenOptions::default();
    assert_eq!(
        screen(&Recording::default(), 1.0, &options).unwrap().keep(),
        []
    );
    for n in 1..12 {
        let screening = screen(&steady(n, 1.0), 1.0, &options).unwrap();
        assert_eq!(screening.reasons.len(), n);
    }
    let mut silent = steady(500, 1.0);
    silent.pump_inlet_pressure_pa[0].fill(f64::NAN);
    silent.pump_inlet_pressure_pa[1].fill(f64::NAN);
    silent.pump_speed_pct.fill(f64::NAN);
    let screening = screen(&silent, 1.0, &options).unwrap();
    assert!(screening.reasons.iter().all(|r| *r == Reasons::GAP));
    let mut without = steady(500, 1.0);
    without.pump_outlet_pressure_pa.clear();
    without.riser_pressure_pa = None;
    let screening = screen(&without, 1.0, &options).unwrap();
    assert!(screening.reasons.iter().all(|r| *r == Reasons::GAP));
}

#[test]
fn a_short_and_noisy_recording_keeps_its_samples() {
    let screening = screen(&steady(12, 1.0), 1.0, &ScreenOptions::default()).unwrap();
    assert_eq!(screening.keep(), [true; 12]);
}

fn value() -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => 0.0..1e7f64,
        4 => prop_oneof![Just(0.0), Just(1.0), Just(60.0), Just(0.05), Just(4e6)],
        1 => prop_oneof![
            Just(f64::NAN),
            Just(f64::INFINITY),
            Just(f64::NEG_INFINITY),
            Just(f64::MAX),
            Just(f64::MIN),
            Just(f64::MIN_POSITIVE),
            Just(-0.0)
        ],
    ]
}

/// Runs of drawn values, so that there is something to be stuck.
fn series(n: usize) -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec((value(), 1..40usize), 1..=n.max(1)).prop_map(move |runs| {
        let values = runs
            .iter()
            .cycle()
            .flat_map(|(v, k)| std::iter::repeat_n(*v, *k));
        values.take(n).collect()
    })
}

pub(crate) fn recording() -> impl Strategy<Value = Recording> {
    (0..160usize, 0..4usize, 0..4usize, any::<bool>()).prop_flat_map(
        |(n, inlets, outlets, riser)| {
            prop::collection::vec(series(n), 6 + inlets + outlets).prop_map(move |mut all| {
                let mut take = || all.pop().unwrap_or_default();
                Recording {
                    time_s: (0..n).map(|i| i as f64).collect(),
                    mud_pump_flow_m3_s: take(),
                    booster_flow_m3_s: take(),
                    topfill_flow_m3_s: take(),
                    return_flow_m3_s: take(),
                    riser_pressure_pa: Some(take()).filter(|_| riser),
                    pump_speed_pct: take(),
                    pump_inlet_pressure_pa: (0..inlets).map(|_| take()).collect(),
                    pump_outlet_pressure_pa: (0..outlets).map(|_| take()).collect(),
                }
            })
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn no_input_panics_and_kept_samples_are_sound(
        recording in recording(),
        step_s in prop_oneof![Just(0.1), Just(1.0), Just(10.0), Just(1e-300), Just(1e300)],
        thesis in any::<bool>(),
    ) {
        let options = if thesis { ScreenOptions::thesis() } else { ScreenOptions::default() };
        let recording = every(step_s, recording);
        let screening = screen(&recording, step_s, &options).unwrap();
        prop_assert_eq!(screening.reasons.len(), recording.len());
        for (i, kept) in screening.keep().iter().enumerate().filter(|(_, k)| **k) {
            prop_assert!(*kept);
            prop_assert!(recording.return_flow_m3_s[i] > 0.0);
            prop_assert!(recording.pump_speed_pct[i] > options.pump_on_above_pct);
            prop_assert!(screening.outlet_pressure_pa[i] > screening.inlet_pressure_pa[i]);
        }
        let rejected = screening.keep().iter().filter(|k| !**k).count();
        prop_assert_eq!(screening.tally().iter().map(|t| t.first).sum::<usize>(), rejected);
    }
}
