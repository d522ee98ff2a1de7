use dgd_report::{
    Axis, Curve, Residuals, Role, Scatter, SearchPath, Series, TimePanel, all_samples, delay_sweep,
    exponent_search, friction_fit, kept_samples, residual_histogram, time_series,
};

fn axis() -> Axis {
    Axis::new("Return flow [%]")
}

#[test]
fn far_outliers_are_left_out_and_counted() {
    let mut x: Vec<f64> = (0..5000).map(|i| f64::from(i % 100)).collect();
    let mut y = x.clone();
    x.extend([50.0, 50.0, 1e6]);
    y.extend([9e5, -9e5, 50.0]);
    let figure = all_samples(Scatter { x: &x, y: &y }, &axis(), &Axis::new("Loss [%]")).unwrap();
    assert_eq!(
        figure.caption(),
        "Loss [%] against return flow [%]: all 5,003 samples. 3 samples are outside the frame."
    );
}

#[test]
fn a_range_given_by_the_caller_rules_and_is_counted() {
    let x: Vec<f64> = (0..=100).map(f64::from).collect();
    let figure = all_samples(Scatter { x: &x, y: &x }, &axis().within(0.0, 50.0), &axis()).unwrap();
    assert!(
        figure
            .caption()
            .ends_with("50 samples are outside the frame."),
        "{}",
        figure.caption()
    );
}

#[test]
fn samples_without_a_value_are_counted() {
    let x = [1.0, 2.0, f64::NAN];
    let figure = all_samples(
        Scatter {
            x: &x,
            y: &[1.0, 2.0, 3.0],
        },
        &axis(),
        &axis(),
    )
    .unwrap();
    assert!(
        figure
            .caption()
            .ends_with("One sample without a value is not shown."),
        "{}",
        figure.caption()
    );
}

#[test]
fn kept_samples_are_not_counted_twice() {
    let x = [1.0, 2.0, 100.0];
    let points = Scatter { x: &x, y: &x };
    let figure = kept_samples(points, points, &axis().within(0.0, 10.0), &axis()).unwrap();
    assert!(
        figure
            .caption()
            .ends_with("One sample is outside the frame."),
        "{}",
        figure.caption()
    );
}

#[test]
fn a_model_beyond_the_frame_is_no_lost_sample() {
    let x = [1.0, 2.0];
    let model = Curve {
        x: &[0.0, 100.0],
        y: &[0.0, 100.0],
    };
    let figure = friction_fit(
        Scatter { x: &x, y: &x },
        model,
        &axis().within(0.0, 3.0),
        &axis(),
    )
    .unwrap();
    assert!(
        !figure.caption().contains("outside"),
        "{}",
        figure.caption()
    );
}

#[test]
fn the_smallest_error_is_named() {
    let figure = delay_sweep(
        &[0.0, 1.0, 2.0, 3.0],
        &[3.0, f64::NAN, 1.25, 2.0],
        &Axis::new("MSE [%²]"),
    )
    .unwrap();
    assert!(
        figure.caption().ends_with("The smallest is 1.25 at 2 s."),
        "{}",
        figure.caption()
    );
    assert!(figure.svg().contains("Smallest: 1.25 at 2 s"));
}

#[test]
fn refused_search_steps_are_named() {
    let path = SearchPath {
        n0: &[1.0, 2.0, 1.5],
        n2: &[2.0, 0.5, 2.5],
        cost: &[3.0, f64::INFINITY, 1.0],
    };
    let figure = exponent_search(&path, None, &Axis::new("MSE [%²]")).unwrap();
    assert_eq!(
        figure.caption(),
        "Search path of the exponents (n₀, n₂) in 3 steps, from (1, 2) to (1.5, 2.5); MSE [%²] falls from 3 to 1. A red \
         cross is a point rejected by the constraints (1)."
    );
}

#[test]
fn the_histogram_tells_median_and_middle_half() {
    let value: Vec<f64> = (0..=1000).map(|i| f64::from(i) / 100.0 - 4.0).collect();
    let sets = [Residuals {
        label: "Model",
        role: Role::Model,
        value: &value,
    }];
    let figure = residual_histogram(&sets, &Axis::new("Residual [%]")).unwrap();
    assert_eq!(
        figure.caption(),
        "Distribution of the residual [%]. Model: median 1.00, middle half from −1.50 to 3.50."
    );
}

#[test]
fn empty_data_say_so_in_the_picture() {
    let nothing = Scatter { x: &[], y: &[] };
    let gaps = Scatter {
        x: &[f64::NAN],
        y: &[1.0],
    };
    let lost = [Series {
        label: "Lost",
        role: Role::Measured,
        time_s: &[1.0],
        value: &[f64::NAN],
    }];
    let panel = TimePanel {
        axis: axis(),
        title: "",
        series: &lost,
    };
    for figure in [
        all_samples(nothing, &axis(), &axis()).unwrap(),
        all_samples(gaps, &axis(), &axis()).unwrap(),
        time_series(&[], &[]).unwrap(),
        time_series(&[panel], &[]).unwrap(),
        residual_histogram(&[], &axis()).unwrap(),
        delay_sweep(&[], &[], &axis()).unwrap(),
        exponent_search(
            &SearchPath {
                n0: &[],
                n2: &[],
                cost: &[],
            },
            None,
            &axis(),
        )
        .unwrap(),
    ] {
        let svg = figure.svg();
        assert!(
            [
                "No samples to show",
                "No delay was tried",
                "No search step to show"
            ]
            .iter()
            .any(|w| svg.contains(w)),
            "{}",
            figure.caption()
        );
    }
}

#[test]
fn time_is_told_in_seconds_or_hours() {
    let label = |end: f64| {
        let series = [Series {
            label: "a",
            role: Role::Measured,
            time_s: &[0.0, end],
            value: &[1.0, 2.0],
        }];
        time_series(
            &[TimePanel {
                axis: axis(),
                title: "",
                series: &series,
            }],
            &[],
        )
        .unwrap()
        .svg()
    };
    assert!(label(6000.0).contains("Time [s]"));
    assert!(label(305_820.0).contains("Time [h]"));
}

#[test]
fn a_figure_takes_another_number_and_caption() {
    let x = [1.0];
    let figure = all_samples(Scatter { x: &x, y: &x }, &axis(), &axis()).unwrap();
    assert_eq!(figure.number(), "3.2");
    let figure = figure.with_number("7").with_caption("Other words.");
    assert_eq!((figure.number(), figure.caption()), ("7", "Other words."));
}
