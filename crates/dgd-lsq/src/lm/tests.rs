//! Valleys, walls, kinks, masks and weights.

use super::*;

const SPARING: Effort = Effort {
    steps: 200,
    tolerance: 1e-12,
    fresh: 100,
    stale: 2,
    patience: 5,
};

fn within(low: &[f64], high: &[f64]) -> Bounds {
    Bounds::new(low.to_vec(), high.to_vec()).expect("bounds in order")
}

fn cube(low: f64, high: f64) -> Bounds {
    within(&[low; 2], &[high; 2])
}

#[test]
fn the_valley_is_followed_to_its_end_with_few_jacobians_and_with_many() {
    let mut f = |t: &[f64]| Some(vec![10.0 * (t[1] - t[0] * t[0]), 1.0 - t[0]]);
    for effort in [SPARING, Effort::default()] {
        let found = minimise(&mut f, &[-1.2, 1.0], &cube(-2.0, 2.0), None, None, effort);
        assert!((found.theta[0] - 1.0).abs() < 1e-5, "{found:?}");
        assert_eq!(found.ending, Ending::Converged);
    }
}

#[test]
fn a_minimum_outside_the_box_is_met_at_its_wall() {
    let mut f = |t: &[f64]| Some(vec![t[0] + t[1] - 3.0, t[0] - t[1]]);
    let bounds = within(&[0.0; 2], &[1.0, 5.0]);
    let found = minimise(&mut f, &[0.2, 4.0], &bounds, None, None, SPARING);
    // With the first at 1: (b - 2)² + (b - 1)² is least at 1.5.
    assert!((found.theta[0] - 1.0).abs() < 1e-9 && (found.theta[1] - 1.5).abs() < 1e-6);
}

#[test]
fn a_parameter_that_tells_a_millionth_of_another_is_found_too() {
    for slight in [1e-6, 1e-9] {
        // The steep one is bent, so that it takes several steps.
        let mut f = |t: &[f64]| {
            let steep = (t[0] - 0.3) * (2.0 + t[0]);
            Some(vec![steep / slight, t[1] - 0.5])
        };
        for effort in [SPARING, Effort::default()] {
            let found = minimise(&mut f, &[0.0; 2], &cube(0.0, 1.0), None, None, effort);
            assert_eq!(found.ending, Ending::Converged);
            assert!((found.theta[0] - 0.3).abs() < 1e-6, "{found:?}");
            assert!((found.theta[1] - 0.5).abs() < 1e-4, "{slight}: {found:?}");
        }
    }
    // One that tells nothing stays.
    let mut f = |t: &[f64]| Some(vec![t[0] - 0.3, 0.1]);
    let found = minimise(&mut f, &[0.0, 0.7], &cube(0.0, 1.0), None, None, SPARING);
    assert_eq!((found.ending, found.theta[1]), (Ending::Converged, 0.7));
}

#[test]
fn rows_left_out_do_not_pull() {
    let mut f = |t: &[f64]| Some(vec![t[0] - 0.3, t[0] - 0.9]);
    let bounds = within(&[0.0], &[1.0]);
    let keep = [true, false];
    let found = minimise(&mut f, &[0.5], &bounds, Some(&keep), None, SPARING);
    assert!((found.theta[0] - 0.3).abs() < 1e-6 && found.residuals.len() == 2);
}

struct Weighted;
impl Residuals for Weighted {
    fn at(&mut self, t: &[f64]) -> Option<Vec<f64>> {
        Some(vec![t[0], t[0] - 1.0])
    }
    fn weights(&self, _: &[f64]) -> Option<Vec<f64>> {
        Some(vec![3.0, 1.0])
    }
}

#[test]
fn a_row_of_three_times_the_weight_pulls_three_times_as_much() {
    let bounds = within(&[-1.0], &[1.0]);
    let found = minimise(
        &mut Weighted,
        &[0.9],
        &bounds,
        None,
        None,
        Effort::default(),
    );
    assert!((found.theta[0] - 0.25).abs() < 1e-9);
    assert!((found.cost - 0.5 * (3.0 * 0.0625 + 0.5625)).abs() < 1e-9);
}

#[test]
fn rows_that_do_not_count_may_be_anything_and_those_that_do_must_be_numbers() {
    let mut holed = |t: &[f64]| Some(vec![f64::NAN, t[0] - 0.3]);
    let start = |f: &mut dyn FnMut(&[f64]) -> Option<Vec<f64>>, keep: Option<&[bool]>| {
        minimise(f, &[0.5], &Bounds::unit(1), keep, None, Effort::default())
    };
    let found = start(&mut holed, Some(&[false, true]));
    assert_eq!(found.ending, Ending::Converged);
    assert!((found.theta[0] - 0.3).abs() < 1e-9, "{:?}", found.theta);
    assert_eq!(start(&mut holed, None).ending, Ending::NoStart);
}

#[test]
fn a_parameter_whose_bounds_meet_is_held_and_the_others_go_on() {
    let bounds = within(&[0.0, 0.0, 3.0], &[1.0, 1.0, 3.0]);
    let mut f = |t: &[f64]| Some(vec![t[1] - 0.7, t[0] - 0.4, 0.1 * (t[2] - 3.0)]);
    let found = minimise(
        &mut f,
        &[0.5, 0.5, 3.0],
        &bounds,
        None,
        None,
        Effort::default(),
    );
    assert_eq!(found.ending, Ending::Converged);
    assert!((found.theta[0] - 0.4).abs() < 1e-8 && (found.theta[1] - 0.7).abs() < 1e-8);
    assert_eq!(found.theta[2], 3.0);
    assert!(found.jacobian.iter().all(|v| v.is_finite()));
}

/// Where there are no residuals to the one side, the other may lie outside.
#[test]
fn differences_ask_for_nothing_outside_the_bounds() {
    let bounds = within(&[0.0, -1.0], &[1.0, 1.0]);
    for theta in [[0.0, -1.0], [1.0, 1.0], [0.5, 0.0], [1e-5, 1.0 - 1e-5]] {
        for refused in 0..3_usize {
            let mut asked = Vec::new();
            let mut rows = |t: &[f64]| {
                asked.push(t.to_vec());
                (asked.len() > refused).then(|| vec![3.0 * t[0], t[1]])
            };
            let start = [3.0 * theta[0], theta[1]];
            let slopes = differences(&mut rows, &theta, &start, &bounds);
            if refused == 0 {
                assert!((slopes[(0, 0)] - 3.0).abs() < 1e-9 && slopes[(1, 0)] == 0.0);
                assert!((slopes[(1, 1)] - 2.0).abs() < 1e-9, "by half the box");
            }
            let inside = |t: &Vec<f64>| {
                (t.iter().zip(&bounds.low)).all(|(t, low)| t >= low)
                    && (t.iter().zip(&bounds.high)).all(|(t, high)| t <= high)
            };
            assert!(asked.iter().all(inside), "{theta:?} {refused}: {asked:?}");
        }
    }
}

#[test]
fn a_start_that_cannot_be_run_and_one_that_cannot_be_left_are_told() {
    let bounds = within(&[0.0], &[1.0]);
    let mut none = |_: &[f64]| None::<Vec<f64>>;
    let found = minimise(&mut none, &[0.5], &bounds, None, None, SPARING);
    assert!(found.ending == Ending::NoStart && found.cost.is_infinite());
    // The differences promise descent, no step keeps it. A high kink has a short step, which damping alone makes tiny.
    for kink in [1e-3, 2e-2, 5e-2] {
        let mut kinked = |t: &[f64]| Some(vec![1.0 + if t[0] == 0.5 { 0.0 } else { kink }]);
        for effort in [SPARING, Effort::default()] {
            let found = minimise(&mut kinked, &[0.5], &bounds, None, None, effort);
            assert_eq!((found.ending, found.theta[0]), (Ending::NoProgress, 0.5));
        }
    }
}

#[test]
fn bounds_that_cannot_be_are_refused_with_the_parameter() {
    let wrong = [
        [1.0, 0.0],
        [f64::NAN, 1.0],
        [0.0, f64::NAN],
        [f64::NEG_INFINITY, 1.0],
        [0.0, f64::INFINITY],
        [-1e308, 1e308],
    ];
    for [low, high] in wrong {
        let refusal = Bounds::new(vec![0.0, low], vec![1.0, high]);
        assert!(matches!(refusal, Err(LsqError::Bound { index: 1, .. })));
    }
    let refusal = Bounds::new(vec![0.0], Vec::new());
    assert_eq!(refusal, Err(LsqError::BoundCount { low: 1, high: 0 }));
    assert_eq!(Bounds::unit(2), cube(0.0, 1.0));
}

#[test]
fn a_start_of_another_length_or_that_is_no_number_is_none() {
    let mut f = |t: &[f64]| Some(vec![t.iter().sum::<f64>() - 0.3]);
    let starts: [&[f64]; 4] = [&[], &[0.5], &[0.5; 3], &[0.5, f64::NAN]];
    for start in starts {
        let none = minimise(&mut f, start, &cube(0.0, 1.0), None, None, SPARING);
        assert_eq!((none.ending, none.steps), (Ending::NoStart, 0));
        assert!(none.cost.is_infinite() && none.theta.len() == start.len());
    }
    // What is infinite has a nearest place inside.
    let start = [f64::INFINITY, f64::NEG_INFINITY];
    let found = minimise(&mut f, &start, &cube(0.0, 1.0), None, None, SPARING);
    assert_eq!(found.ending, Ending::Converged);
    let none = minimise(
        &mut f,
        &[0.5],
        &Bounds::default(),
        None,
        None,
        Effort::default(),
    );
    assert_eq!(none.ending, Ending::NoStart);
}

#[test]
fn residuals_of_another_length_are_none() {
    // As many as there are readings on the way, of which there are fewer beyond 0.6.
    let mut f = |t: &[f64]| Some(vec![t[0] - 0.7; if t[0] > 0.6 { 1 } else { 2 }]);
    let bounds = within(&[0.0], &[1.0]);
    let found = minimise(&mut f, &[0.2], &bounds, None, None, Effort::default());
    assert!(
        found.residuals.len() == 2 && found.theta[0] <= 0.6,
        "{found:?}"
    );
    // The slope at the edge is that of the other side.
    let slope = differences(&mut f, &[0.6], &[-0.1; 2], &bounds);
    assert!((slope[(0, 0)] - 1.0).abs() < 1e-9 && (slope[(1, 0)] - 1.0).abs() < 1e-9);
}

#[test]
fn a_jacobian_that_is_no_number_ends_where_it_began() {
    let mut asked = 0;
    let mut f = |t: &[f64]| {
        asked += 1;
        assert!(!t[0].is_nan());
        Some(vec![t[0] + t[1], t[1] - 0.2])
    };
    let (r, slopes) = ([1.0, 0.3], DMatrix::from_element(2, 2, f64::NAN));
    let known = Some((&r[..], &slopes));
    let found = minimise(&mut f, &[0.5; 2], &cube(0.0, 1.0), None, known, SPARING);
    assert!(found.theta == [0.5; 2] && found.ending != Ending::StepLimit);
    let half = DMatrix::from_row_slice(2, 2, &[1.0, f64::NAN, 0.0, 1.0]);
    let known = Some((&r[..], &half));
    let found = minimise(&mut f, &[0.5; 2], &cube(0.0, 1.0), None, known, SPARING);
    assert_eq!(
        (found.ending, found.theta),
        (Ending::NoProgress, vec![0.5; 2])
    );
    assert_eq!(asked, 0);
}

#[test]
fn a_start_at_the_minimum_has_converged_though_nothing_is_gained() {
    let bounds = within(&[0.0], &[1.0]);
    let mut f = |t: &[f64]| Some(vec![t[0] - 0.3, t[0] - 0.9, 0.1 * (5.0 * t[0]).sin()]);
    let found = minimise(&mut f, &[0.5], &bounds, None, None, Effort::default());
    for effort in [SPARING, Effort::default()] {
        let again = minimise(&mut f, &found.theta, &bounds, None, None, effort);
        assert_eq!(again.ending, Ending::Converged, "{again:?}");
    }
}

/// What only has its slopes: the Jacobian is exact, by one column a parameter.
struct Exact<F, J>(F, J);
impl<F: Fn(&[f64]) -> Vec<f64>, J: Fn(&[f64]) -> [[f64; 2]; 2]> Residuals for Exact<F, J> {
    fn at(&mut self, t: &[f64]) -> Option<Vec<f64>> {
        Some((self.0)(t))
    }
    fn jacobian(&mut self, t: &[f64], _: &[f64], bounds: &Bounds) -> Option<DMatrix<f64>> {
        let slopes = (self.1)(t);
        Some(DMatrix::from_fn(2, 2, |i, j| slopes[i][j] * bounds.span(j)))
    }
}

#[test]
fn with_an_exact_jacobian_bounds_may_be_as_wide_as_they_like() {
    for wide in [1e3, 1e6, 1e9, 1e12, 1e15] {
        let bounds = cube(-wide, wide);
        let mut line = Exact(
            |t: &[f64]| vec![t[0] - 1.0, t[1] - 2.0],
            |_: &[f64]| [[1.0, 0.0], [0.0, 1.0]],
        );
        let found = minimise(&mut line, &[0.0; 2], &bounds, None, None, SPARING);
        assert_eq!(found.ending, Ending::Converged);
        assert!((found.theta[0] - 1.0).abs() < 1e-5, "{wide}: {found:?}");
        assert!((found.theta[1] - 2.0).abs() < 1e-5, "{wide}: {found:?}");
        let mut valley = Exact(
            |t: &[f64]| vec![10.0 * (t[1] - t[0] * t[0]), 1.0 - t[0]],
            |t: &[f64]| [[-20.0 * t[0], 10.0], [-1.0, 0.0]],
        );
        let effort = Effort::default();
        let found = minimise(&mut valley, &[-1.2, 1.0], &bounds, None, None, effort);
        assert_eq!(found.ending, Ending::Converged, "{wide}");
        assert!((found.theta[0] - 1.0).abs() < 1e-4, "{wide}: {found:?}");
    }
}

#[test]
fn in_bounds_too_wide_for_differences_nothing_is_called_a_minimum_that_is_none() {
    let mut f = |t: &[f64]| Some(vec![10.0 * (t[1] - t[0] * t[0]), 1.0 - t[0]]);
    for wide in [1e9, 1e12] {
        for effort in [SPARING, Effort::default()] {
            let bounds = cube(-wide, wide);
            let found = minimise(&mut f, &[-1.2, 1.0], &bounds, None, None, effort);
            let met = (found.theta[0] - 1.0).abs() < 1e-3;
            assert!(met || found.ending != Ending::Converged, "{found:?}");
        }
    }
}

#[test]
fn residuals_whose_squares_are_beyond_numbers_are_no_start() {
    let mut f = |t: &[f64]| Some(vec![1e160 * (t[0] - 0.3)]);
    let found = minimise(&mut f, &[0.5], &Bounds::unit(1), None, None, SPARING);
    assert_eq!((found.ending, found.theta), (Ending::NoStart, vec![0.5]));
}
