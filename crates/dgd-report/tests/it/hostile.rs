//! Values no instrument gives must neither panic nor reach the paper.

use dgd_report::{
    Axis, Compared, CostGrid, Curve, Figure, Interval, ReportError, Residuals, Role, Scatter,
    SearchPath, Series, SpeedFamily, TimePanel, all_samples, complete_dynamics, delay_sweep,
    exponent_search, final_pump_curves, friction_fit, kept_samples, residual_histogram,
    riser_level, time_series,
};

use crate::svg::assert_sound;
use crate::synthetic::Noise;

const NASTY: [f64; 14] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f64::MIN,
    f64::MIN_POSITIVE,
    5e-324,
    -0.0,
    0.0,
    1.0,
    -1.0,
    1e300,
    1e-300,
    1e16 + 2.0,
];

fn figures(x: &[f64], y: &[f64]) -> Vec<Result<Figure, ReportError>> {
    let (across, up) = (Axis::new("x [-]"), Axis::new("y [-]"));
    let (points, curve) = (Scatter { x, y }, Curve { x, y });
    let both = Compared {
        measured: curve,
        simulated: curve,
    };
    let series = [Series {
        label: "a",
        role: Role::Measured,
        time_s: x,
        value: y,
    }];
    let panel = TimePanel {
        axis: up.clone(),
        title: "t",
        series: &series,
    };
    let family = [SpeedFamily {
        speed_pct: x.first().copied().unwrap_or(0.0),
        samples: points,
        model: curve,
    }];
    let interval = [Interval {
        start_s: x.first().copied().unwrap_or(0.0),
        end_s: y.last().copied().unwrap_or(0.0),
        label: "i",
    }];
    let grid_cost: Vec<f64> = x.iter().flat_map(|_| y.iter().copied()).collect();
    let grid = CostGrid {
        n0: y,
        n2: x,
        cost: &grid_cost,
    };
    vec![
        all_samples(points, &across, &up),
        kept_samples(points, points, &across, &up),
        friction_fit(points, curve, &across, &up),
        delay_sweep(x, y, &up),
        final_pump_curves(&family, 0.1, &across, &up),
        exponent_search(
            &SearchPath {
                n0: x,
                n2: y,
                cost: x,
            },
            Some(&grid),
            &up,
        ),
        riser_level(&both, &series, &up, &up),
        complete_dynamics(&both, &both, &up, &up),
        time_series(&[panel], &interval),
        residual_histogram(
            &[Residuals {
                label: "r",
                role: Role::Model,
                value: y,
            }],
            &up,
        ),
    ]
}

fn all_sound(x: &[f64], y: &[f64]) {
    for figure in figures(x, y) {
        let figure = figure.unwrap();
        assert_sound(
            &format!("{} of {x:?}, {y:?}", figure.number()),
            &figure.svg(),
        );
        if x[0].to_bits() == x[1].to_bits() {
            figure.png(0.5).unwrap();
        }
    }
}

#[test]
fn pairs_of_nasty_values_are_drawn_or_left_out() {
    for a in NASTY {
        for b in NASTY {
            all_sound(&[a, b, 2.0], &[b, 3.0, a]);
        }
    }
}

#[test]
fn long_runs_with_nasty_values_are_drawn_or_left_out() {
    let mut noise = Noise::new(4);
    let n = 12_000;
    let mut nasty = NASTY.into_iter().cycle();
    let mut value = || {
        let pick = noise.even();
        if pick < 0.01 {
            nasty.next().unwrap()
        } else {
            100.0 * noise.even()
        }
    };
    let y: Vec<f64> = (0..n).map(|_| value()).collect();
    let clock: Vec<f64> = (0..n).map(f64::from).collect();
    let (across, up) = (Axis::new("x"), Axis::new("y"));
    let series = [Series {
        label: "a",
        role: Role::Before,
        time_s: &clock,
        value: &y,
    }];
    for figure in [
        all_samples(Scatter { x: &clock, y: &y }, &across, &up).unwrap(),
        time_series(
            &[TimePanel {
                axis: up.clone(),
                title: "",
                series: &series,
            }],
            &[],
        )
        .unwrap(),
        residual_histogram(
            &[Residuals {
                label: "r",
                role: Role::Model,
                value: &y,
            }],
            &up,
        )
        .unwrap(),
    ] {
        assert_sound(figure.caption(), &figure.svg());
    }
}

#[test]
fn a_clock_that_jumps_back_is_drawn() {
    let clock: Vec<f64> = (0..20_000).map(|i| f64::from(i % 7000)).collect();
    let y: Vec<f64> = clock.iter().map(|t| t.sin()).collect();
    let series = [Series {
        label: "a",
        role: Role::Measured,
        time_s: &clock,
        value: &y,
    }];
    let figure = time_series(
        &[TimePanel {
            axis: Axis::new("y"),
            title: "",
            series: &series,
        }],
        &[],
    )
    .unwrap();
    assert_sound("jump", &figure.svg());
    assert!(figure.svg().len() < 1_000_000);
}
