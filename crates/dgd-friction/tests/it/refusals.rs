use dgd_friction::{
    CONDITION_LIMIT, FrictionError, Loss, LsqError, RobustOptions, Samples, SweepOptions, Terms,
    delay_sweep, fit,
};

use crate::Recording;

fn recording() -> Recording {
    Recording::new(500, 0, |q| 1e8 * q * q, 0.0)
}

#[test]
fn unequal_lengths_are_refused_by_name() {
    let recording = recording();
    let samples = Samples {
        keep: &recording.keep[1..],
        ..recording.samples()
    };
    assert_eq!(
        fit(&samples, 0, &Terms::Quadratic, Loss::Squared),
        Err(FrictionError::Length {
            name: "keep",
            found: 499,
            expected: 500
        })
    );
}

#[test]
fn kept_nan_is_refused_with_its_index() {
    let mut recording = recording();
    recording.friction[77] = f64::NAN;
    assert_eq!(
        delay_sweep(
            &recording.samples(),
            &Terms::Quadratic,
            &SweepOptions::default()
        ),
        Err(FrictionError::NonFinite { index: 77 })
    );
}

#[test]
fn constant_flow_excites_too_little_and_the_terms_are_named() {
    let mut recording = recording();
    for (i, q) in recording.flow.iter_mut().enumerate() {
        *q = 0.05 * (1.0 + 1e-4 * crate::noise(i));
    }
    let refused = delay_sweep(
        &recording.samples(),
        &Terms::OffsetCubic,
        &SweepOptions::default(),
    );
    match refused {
        Err(FrictionError::Fit(LsqError::NotExcited {
            columns, condition, ..
        })) => {
            assert_eq!(columns, ["1", "q^2", "q^3"]);
            assert!(condition > 1e4);
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_robust_fit_asks_for_as_much_excitation_as_a_plain_one() {
    let mut recording = recording();
    for (i, q) in recording.flow.iter_mut().enumerate() {
        *q = 0.05 * (1.0 + 1e-4 * crate::noise(i));
    }
    for loss in [Loss::Squared, Loss::Huber(RobustOptions::default())] {
        let refused = fit(&recording.samples(), 0, &Terms::Quadratic, loss);
        let Err(FrictionError::Fit(LsqError::NotExcited { condition, .. })) = refused else {
            panic!("{refused:?}");
        };
        assert!((1e4..1e6).contains(&condition), "{condition}");
    }
}

#[test]
fn no_flow_at_all_is_refused() {
    let mut recording = recording();
    recording.flow.fill(0.0);
    match fit(&recording.samples(), 0, &Terms::Quadratic, Loss::Squared) {
        Err(FrictionError::Fit(LsqError::NotExcited { columns, .. })) => {
            assert_eq!(columns, ["q", "q^2"]);
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn nothing_kept_and_nothing_there_are_too_few_rows() {
    let mut recording = recording();
    recording.keep.fill(false);
    let few = |samples: &Samples, delay| {
        matches!(
            fit(samples, delay, &Terms::Quadratic, Loss::Squared),
            Err(FrictionError::Fit(LsqError::TooFewRows { found: 0, .. }))
        )
    };
    assert!(few(&recording.samples(), 0));
    recording.keep.fill(true);
    assert!(few(&recording.samples(), i64::MAX));
    assert!(few(&recording.samples(), i64::MIN));
}

#[test]
fn delays_outside_the_recording_are_refused() {
    let recording = recording();
    #[expect(clippy::reversed_empty_ranges, reason = "the empty range is the point")]
    let ranges = [5..=4, 0..=500, -500..=0, i64::MIN..=i64::MAX];
    for delays in ranges {
        let options = SweepOptions {
            delays,
            ..SweepOptions::default()
        };
        assert!(matches!(
            delay_sweep(&recording.samples(), &Terms::Quadratic, &options),
            Err(FrictionError::Delays { samples: 500, .. })
        ));
    }
}

#[test]
fn an_empty_recording_is_refused() {
    let samples = Samples {
        flow_m3_s: &[],
        friction_pa: &[],
        keep: &[],
        keep_delayed: false,
    };
    assert!(delay_sweep(&samples, &Terms::Quadratic, &SweepOptions::default()).is_err());
    assert!(fit(&samples, 3, &Terms::Quadratic, Loss::Squared).is_err());
}

#[test]
fn a_sampling_interval_of_zero_is_refused() {
    let options = SweepOptions {
        dt_s: 0.0,
        ..SweepOptions::default()
    };
    assert!(matches!(
        delay_sweep(&recording().samples(), &Terms::Quadratic, &options),
        Err(FrictionError::Domain { name: "dt_s", .. })
    ));
}

#[test]
fn the_condition_limit_of_a_robust_fit_may_be_lower_but_not_higher() {
    let mut recording = recording();
    let mut refused_at = |spread: f64, condition_limit| {
        for (i, q) in recording.flow.iter_mut().enumerate() {
            *q = 0.05 * (1.0 + spread * crate::noise(i));
        }
        let loss = Loss::Huber(RobustOptions {
            condition_limit,
            ..RobustOptions::default()
        });
        match fit(&recording.samples(), 0, &Terms::Quadratic, loss) {
            Err(FrictionError::Fit(LsqError::NotExcited { limit, .. })) => Some(limit),
            other => other.map(|_| None).unwrap(),
        }
    };
    // Conditions of some 350 and 35,000.
    assert_eq!(refused_at(1e-2, 1e10), None);
    assert_eq!(refused_at(1e-2, 100.0), Some(100.0));
    assert_eq!(refused_at(1e-4, 1e10), Some(CONDITION_LIMIT));
}

#[test]
fn a_condition_limit_of_a_robust_fit_that_is_no_number_is_refused() {
    for condition_limit in [f64::NAN, 0.0, -1.0] {
        let loss = Loss::Huber(RobustOptions {
            condition_limit,
            ..RobustOptions::default()
        });
        let refused = fit(&recording().samples(), 0, &Terms::Quadratic, loss);
        assert!(
            matches!(
                refused,
                Err(FrictionError::Fit(LsqError::Option {
                    name: "condition_limit",
                    ..
                }))
            ),
            "{refused:?}"
        );
    }
}
