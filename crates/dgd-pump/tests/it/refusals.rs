use dgd_pump::{
    ConstrainedOptions, CurveFit, HeadCurve, LsqError, PumpError, Rule, Samples, SearchOptions,
    fit_constrained, fit_unconstrained, search_exponents,
};

use crate::{PUMP, Recording};

/// The refusal is the same whichever fit is asked.
fn refusals(samples: &Samples) -> PumpError {
    let plain: Result<CurveFit, _> = fit_unconstrained(samples, 2.0, 2.0);
    let bound = fit_constrained(samples, 2.0, 2.0, &ConstrainedOptions::default());
    let search = search_exponents(samples, &SearchOptions::default());
    let refusal = plain.unwrap_err();
    assert_eq!(
        std::mem::discriminant(&bound.unwrap_err()),
        std::mem::discriminant(&refusal)
    );
    assert_eq!(
        std::mem::discriminant(&search.unwrap_err()),
        std::mem::discriminant(&refusal)
    );
    refusal
}

#[test]
fn unequal_lengths_are_refused_by_name() {
    let recording = Recording::new(100, &PUMP, 1.0);
    let samples = Samples {
        head_m: &recording.head[..99],
        ..recording.samples()
    };
    assert_eq!(
        refusals(&samples),
        PumpError::Length {
            name: "head_m",
            found: 99,
            expected: 100
        }
    );
}

#[test]
fn kept_nan_is_refused_with_its_index() {
    let mut recording = Recording::new(100, &PUMP, 1.0);
    recording.flow[42] = f64::NAN;
    assert_eq!(
        refusals(&recording.samples()),
        PumpError::NonFinite {
            name: "flow_m3_s",
            index: 42
        }
    );
}

#[test]
fn kept_backflow_is_refused_with_its_value() {
    let mut recording = Recording::new(100, &PUMP, 1.0);
    recording.flow[42] = -0.01;
    assert_eq!(
        refusals(&recording.samples()),
        PumpError::Negative {
            name: "flow_m3_s",
            index: 42,
            found: -0.01
        }
    );
}

#[test]
fn whatever_is_wrong_with_a_kept_sample_is_named_and_zeros_before_it_are_not() {
    for (name, bad) in [
        ("speed_pct", f64::NAN),
        ("speed_pct", -0.5),
        ("flow_m3_s", f64::INFINITY),
        ("flow_m3_s", -1e-9),
        ("head_m", f64::NEG_INFINITY),
    ] {
        let mut recording = Recording::new(100, &PUMP, 1.0);
        recording.speed[7] = 0.0;
        recording.flow[8] = 0.0;
        recording.head[9] = -3.0;
        let series = match name {
            "speed_pct" => &mut recording.speed,
            "flow_m3_s" => &mut recording.flow,
            _ => &mut recording.head,
        };
        series[42] = bad;
        let index = 42;
        let expected = if bad.is_finite() {
            let found = bad;
            PumpError::Negative { name, index, found }
        } else {
            PumpError::NonFinite { name, index }
        };
        assert_eq!(refusals(&recording.samples()), expected);
    }
}

#[test]
fn a_head_beyond_all_squares_is_an_error_and_no_panic() {
    for rows in [100, 256, 257, 1000] {
        let mut recording = Recording::new(rows, &PUMP, 1.0);
        recording.head.fill(1e300);
        let refused = fit_unconstrained(&recording.samples(), 2.0, 2.0);
        assert!(matches!(refused, Err(PumpError::Fit(_))), "{refused:?}");
    }
}

#[test]
fn too_few_samples_are_refused() {
    let recording = Recording::new(3, &PUMP, 1.0);
    assert!(matches!(
        refusals(&recording.samples()),
        PumpError::Fit(LsqError::TooFewRows {
            found: 3,
            columns: 3
        })
    ));
}

#[test]
fn flow_tied_to_speed_excites_nothing_and_the_terms_are_named() {
    let mut recording = Recording::new(1000, &PUMP, 1.0);
    for i in 0..1000 {
        recording.flow[i] = 7e-4 * recording.speed[i];
    }
    match fit_unconstrained(&recording.samples(), 2.0, 2.0) {
        Err(PumpError::Fit(LsqError::NotExcited { columns, .. })) => {
            assert_eq!(columns, ["w^n0", "-w q", "-q^n2"]);
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_pump_that_stands_is_refused() {
    let mut recording = Recording::new(100, &PUMP, 1.0);
    recording.speed.fill(0.0);
    assert!(matches!(
        search_exponents(&recording.samples(), &SearchOptions::default()),
        Err(PumpError::Domain {
            name: "speed_pct",
            ..
        })
    ));
    assert!(matches!(
        fit_unconstrained(&recording.samples(), 2.0, 2.0),
        Err(PumpError::Fit(LsqError::NotExcited { .. }))
    ));
}

#[test]
fn refusing_a_head_that_only_rises_leaves_no_exponents() {
    let rising = HeadCurve {
        c1: -5.0,
        c2: -1e4,
        ..PUMP
    };
    let recording = Recording::new(2000, &rising, 0.1);
    let options = SearchOptions {
        rule: Rule::Refuse,
        ..SearchOptions::default()
    };
    match search_exponents(&recording.samples(), &options) {
        Err(PumpError::NoFeasibleExponents { tried }) => assert_eq!(tried, 170),
        other => panic!("{other:?}"),
    }
}

#[test]
fn exponents_starts_and_tolerances_out_of_domain_are_refused() {
    let recording = Recording::new(100, &PUMP, 1.0);
    let samples = recording.samples();
    assert!(matches!(
        fit_unconstrained(&samples, 0.0, 2.0),
        Err(PumpError::Domain { name: "n0", .. })
    ));
    let plain = SearchOptions::default();
    let start = (2.0, f64::NAN);
    let mut cases = vec![(
        "start.1",
        SearchOptions {
            start,
            ..plain.clone()
        },
    )];
    for tolerance in [0.0, 1.0, -1e-3] {
        let options = plain.clone();
        cases.push((
            "tolerance",
            SearchOptions {
                tolerance,
                ..options
            },
        ));
    }
    for (expected, options) in cases {
        match search_exponents(&samples, &options) {
            Err(PumpError::Domain { name, .. }) => assert_eq!(name, expected),
            other => panic!("{expected}: {other:?}"),
        }
    }
}

#[test]
fn a_range_of_exponents_is_refused_with_both_ends() {
    let recording = Recording::new(100, &PUMP, 1.0);
    let refused = |n0: std::ops::RangeInclusive<f64>, n2: std::ops::RangeInclusive<f64>| {
        let options = SearchOptions {
            n0,
            n2,
            ..SearchOptions::default()
        };
        match search_exponents(&recording.samples(), &options) {
            Err(PumpError::Range { name, from, to, .. }) => Some((name, from, to)),
            _ => None,
        }
    };
    let any = || 1.0..=4.0;
    let falling = 4.0..=1.0;
    assert_eq!(refused(falling, any()), Some(("n0", 4.0, 1.0)));
    assert_eq!(refused(0.05..=4.0, any()), Some(("n0", 0.05, 4.0)));
    assert_eq!(refused(1.0..=10.5, any()), Some(("n0", 1.0, 10.5)));
    assert!(refused(1.0..=f64::NAN, any()).is_some());
    assert_eq!(refused(any(), 0.5..=4.0), Some(("n2", 0.5, 4.0)));
    assert_eq!(refused(any(), 1.0..=1.0), Some(("n2", 1.0, 1.0)));
    assert_eq!(refused(0.1..=10.0, 1.0..=10.0), None, "the widest allowed");
}

#[test]
fn a_head_that_is_upside_down_or_zero_is_refused() {
    let mut recording = Recording::new(2000, &PUMP, 0.1);
    recording.head.iter_mut().for_each(|h| *h = -*h);
    for rule in [Rule::Hold, Rule::Refuse] {
        let options = SearchOptions {
            rule,
            ..SearchOptions::default()
        };
        match search_exponents(&recording.samples(), &options) {
            Err(PumpError::Domain {
                name: "c0", found, ..
            }) => assert!(found < 0.0),
            Err(PumpError::NoFeasibleExponents { .. }) if rule == Rule::Refuse => {}
            other => panic!("{other:?}"),
        }
    }
    recording.head.fill(0.0);
    let samples = recording.samples();
    let search = search_exponents(&samples, &SearchOptions::default()).unwrap_err();
    let bound = fit_constrained(&samples, 2.0, 2.0, &ConstrainedOptions::default()).unwrap_err();
    for refused in [search, bound] {
        assert!(
            matches!(refused, PumpError::Domain { name: "head_m", .. }),
            "{refused}"
        );
    }
}
