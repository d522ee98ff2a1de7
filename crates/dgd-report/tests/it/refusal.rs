use dgd_report::{
    Axis, Compared, CostGrid, Curve, Interval, ReportError, Residuals, Role, Scatter, SearchPath,
    Series, SpeedFamily, TimePanel, all_samples, delay_sweep, exponent_search, final_pump_curves,
    residual_histogram, return_flow, time_series,
};

const ONE: [f64; 1] = [1.0];
const TWO: [f64; 2] = [1.0, 2.0];

fn axis() -> Axis {
    Axis::new("Flow [%]")
}

fn length(name: &'static str, expected: usize, found: usize) -> ReportError {
    ReportError::Length {
        name,
        expected,
        found,
    }
}

#[test]
fn unequal_slices_are_refused_by_name() {
    let bad = Curve { x: &TWO, y: &ONE };
    let good = Curve { x: &TWO, y: &TWO };
    let scatter = all_samples(Scatter { x: &TWO, y: &ONE }, &axis(), &axis());
    assert_eq!(scatter.unwrap_err(), length("samples.y", 2, 1));
    assert_eq!(
        delay_sweep(&TWO, &ONE, &axis()).unwrap_err(),
        length("mse", 2, 1)
    );
    let flow = Compared {
        measured: good,
        simulated: bad,
    };
    assert_eq!(
        return_flow(&flow, good, &axis(), &axis()).unwrap_err(),
        length("flow.simulated.y", 2, 1)
    );
    let flow = Compared {
        measured: good,
        simulated: good,
    };
    assert_eq!(
        return_flow(&flow, bad, &axis(), &axis()).unwrap_err(),
        length("speed.y", 2, 1)
    );
    let path = SearchPath {
        n0: &TWO,
        n2: &TWO,
        cost: &ONE,
    };
    assert_eq!(
        exponent_search(&path, None, &axis()).unwrap_err(),
        length("path.cost", 2, 1)
    );
    let path = SearchPath { cost: &[], ..path };
    let grid = CostGrid {
        n0: &TWO,
        n2: &TWO,
        cost: &TWO,
    };
    assert_eq!(
        exponent_search(&path, Some(&grid), &axis()).unwrap_err(),
        length("grid.cost", 4, 2)
    );
}

#[test]
fn the_message_names_found_and_expected() {
    let error = delay_sweep(&TWO, &ONE, &axis()).unwrap_err();
    assert_eq!(error.to_string(), "`mse` has 1 values, expected 2");
}

#[test]
fn a_range_that_cannot_be_drawn_is_refused() {
    for (low, high) in [
        (1.0, 1.0),
        (2.0, 1.0),
        (f64::NAN, 1.0),
        (0.0, f64::INFINITY),
        (f64::MIN, f64::MAX),
    ] {
        let samples = Scatter { x: &TWO, y: &TWO };
        let across = all_samples(samples, &axis().within(low, high), &axis());
        assert!(
            matches!(across, Err(ReportError::Range { .. })),
            "{low} to {high}"
        );
        let up = all_samples(samples, &axis(), &axis().within(low, high));
        assert!(
            matches!(up, Err(ReportError::Range { .. })),
            "{low} to {high}"
        );
    }
}

#[test]
fn more_than_fits_is_refused() {
    let curve = Curve { x: &TWO, y: &TWO };
    let family = SpeedFamily {
        speed_pct: 30.0,
        samples: Scatter { x: &TWO, y: &TWO },
        model: curve,
    };
    let speeds = final_pump_curves(&[family; 17], 0.1, &axis(), &axis());
    assert_eq!(
        speeds.unwrap_err(),
        ReportError::TooMany {
            what: "speeds",
            found: 17,
            most: 16
        }
    );
    let panel = TimePanel {
        axis: axis(),
        title: "",
        series: &[],
    };
    let panels = time_series(&vec![panel.clone(); 13], &[]);
    assert_eq!(
        panels.unwrap_err(),
        ReportError::TooMany {
            what: "panels",
            found: 13,
            most: 12
        }
    );
    let interval = Interval {
        start_s: 0.0,
        end_s: 1.0,
        label: "",
    };
    assert!(matches!(
        time_series(&[panel], &vec![interval; 1001]),
        Err(ReportError::TooMany { .. })
    ));
    let series = [Series {
        label: "",
        role: Role::Measured,
        time_s: &TWO,
        value: &TWO,
    }; 13];
    let panel = TimePanel {
        axis: axis(),
        title: "",
        series: &series,
    };
    assert!(matches!(
        time_series(&[panel], &[]),
        Err(ReportError::TooMany { .. })
    ));
    let set = Residuals {
        label: "",
        role: Role::Model,
        value: &TWO,
    };
    assert!(matches!(
        residual_histogram(&[set; 13], &axis()),
        Err(ReportError::TooMany { .. })
    ));
    let line = vec![0.0; 501];
    let grid = CostGrid {
        n0: &line,
        n2: &line,
        cost: &[],
    };
    let path = SearchPath {
        n0: &TWO,
        n2: &TWO,
        cost: &[],
    };
    assert!(matches!(
        exponent_search(&path, Some(&grid), &axis()),
        Err(ReportError::TooMany { .. })
    ));
}
