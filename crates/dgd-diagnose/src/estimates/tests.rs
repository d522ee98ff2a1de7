//! Claims about estimates and their intervals: the curvature of a quadratic, by the closed forms of one parameter and of two.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

use super::{Estimator, Profile, direction, shrunk};
use crate::ablation::Step;
use crate::diagnosis::ParameterEstimate;
use crate::record::Record;
use crate::relations::Applied;
use crate::selection::{Named, Selection};
use crate::tangent::{Bend, Tangent};
use crate::test_rig::{Hidden, INFLUX_S, drilled, named};
use dgd_effects::{Role, find, unknown};
use dgd_lsq::dot;
use nalgebra::DMatrix;

fn selected(allowances: Vec<Applied>, named: Vec<Named>) -> Selection {
    Selection {
        held: 0,
        allowances,
        named,
        first: Vec::new(),
        stays: false,
    }
}

/// Of the effect that was named `k`th.
fn estimates(
    record: &Record,
    selection: &Selection,
    k: usize,
    full: &Tangent,
) -> Vec<ParameterEstimate> {
    Estimator::of(record, &selection.state(), full).estimates(&selection.named[k])
}

/// Half of an interval in standard deviations, on the side where a size is larger.
fn sd(one: &ParameterEstimate) -> f64 {
    let halves = [one.ci95.1 - one.estimate, one.estimate - one.ci95.0];
    halves[0].max(halves[1]) / 1.96
}

/// An effect that is there is not of size none, on whichever side of it.
#[test]
fn the_end_of_the_smaller_size_is_so_many_times_smaller() {
    let near = |found: [f64; 2], expected: [f64; 2]| {
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{found} for {expected}");
        }
    };
    let e = std::f64::consts::E;
    near(
        shrunk([-3.0, 3.0], 3.0, true),
        [-3.0 * (1.0 - 1.0 / e), 3.0],
    );
    near(
        shrunk([-3.0, 3.0], 3.0, false),
        [-3.0, 3.0 * (1.0 - 1.0 / e)],
    );
    // Where it is told well, both ends are as far.
    near(shrunk([-1e-7, 1e-7], 3.0, true), [-1e-7, 1e-7]);
    near(shrunk([-1e9, 1e9], 3.0, true), [-3.0, 1e9]);
    // What has no size has none to shrink.
    near(shrunk([-3.0, 3.0], 0.0, true), [-3.0, 3.0]);

    let record = drilled(Hidden::default());
    for value in [0.01, -0.01] {
        let selection = selected(Vec::new(), vec![named("inflow_gain", &[value])]);
        let full = about(&record, &selection);
        let one = &estimates(&record, &selection, 0, &full)[0];
        let (low, high) = one.ci95;
        assert!(low < one.estimate && one.estimate < high);
        assert!(low > 1.0 || high < 1.0, "{low} {high}");
        let (inward, outward) = match value > 0.0 {
            true => (one.estimate - low, high - one.estimate),
            false => (high - one.estimate, one.estimate - low),
        };
        assert!((inward + 0.01 * (-outward / 0.01).exp_m1()).abs() < 1e-9);
    }
}

/// What a unit more of a parameter takes out of the rows, by differences to either side.
fn along(record: &Record, full: &Tangent, state: &[Applied], (e, j): (usize, usize)) -> Vec<f64> {
    let step = 1e-2 * state[e].parameters[j].abs().max(1e-3);
    let [more, less] = [step, -step].map(|step| {
        let mut next = state.to_vec();
        next[e].parameters[j] += step;
        full.signature(record, &next)
    });
    let pairs = more.iter().zip(&less);
    pairs.map(|(m, l)| (m - l) / (2.0 * step)).collect()
}

/// Drilling that conceals an influx of a rate, and the influx.
fn influx_of(rate: f64) -> (Record, Named) {
    let (from, lasts, rise) = INFLUX_S;
    let record = drilled(Hidden {
        influx_m3_s: rate,
        ..Hidden::default()
    });
    (record, named("influx", &[rate, from, lasts, rise]))
}

/// The tangent about all that is selected.
fn about(record: &Record, selection: &Selection) -> Tangent {
    Tangent::at(record, &selection.state(), &[], Bend::Stiff).unwrap()
}

/// Twice the posterior's deviation, and the form's error beside it.
fn widened(variance: f64, form: f64) -> f64 {
    (2.0 * variance.sqrt()).hypot(form)
}

#[test]
fn a_strength_by_itself_has_the_deviation_of_its_energy_and_its_prior() {
    let record = drilled(Hidden::default());
    for value in [0.0, 0.02, -0.1] {
        let selection = selected(Vec::new(), vec![named("inflow_gain", &[value])]);
        let full = about(&record, &selection);
        let found = estimates(&record, &selection, 0, &full);
        let gain = find("inflow_gain").unwrap().about();
        assert_eq!((found[0].name.as_str(), found.len()), ("gain", 1));
        assert_eq!(found[0].meaning, gain.parameters[0].meaning);
        assert!((found[0].estimate - 1.0 - value).abs() < 1e-12);
        let s = along(&record, &full, &selection.state(), (0, 0));
        // The prior is three times as wide as a usual gain of 0.03.
        let variance = 1.0 / (dot(&s, &s) + 1.0 / (0.09 * 0.09));
        let expected = widened(variance, gain.search.size_error * value.abs());
        let found = sd(&found[0]);
        assert!(
            (found / expected - 1.0).abs() < 0.02,
            "{value}: {found} for {expected}"
        );
    }
}

/// Told as an area, a strength is uncertain by its area too.
#[test]
fn what_is_shown_in_another_unit_is_as_uncertain_in_it() {
    let mut record = drilled(Hidden::default());
    let area = record.setting.riser_area_m2;
    let selection = selected(Vec::new(), vec![named("annulus_area", &[-0.1])]);
    let about_it = find("annulus_area").unwrap().about();
    let [calibrated, bare] = [Vec::new(), vec![Step::Calibration]].map(|without| {
        record.without = without;
        let full = about(&record, &selection);
        estimates(&record, &selection, 0, &full).remove(0)
    });
    let (shift, factor) = about_it.parameters[0].shown.scale(&record.setting);
    assert!(factor != 1.0 && (calibrated.estimate - shift + 0.1 * factor).abs() < 1e-12 * area);
    let lacks = about_it.search.size_error * about_it.parameters[0].shown.size(calibrated.estimate);
    let expected = widened((sd(&bare)).powi(2), lacks);
    assert!((sd(&calibrated) / expected - 1.0).abs() < 1e-9);
}

#[test]
fn what_is_not_calibrated_is_the_posterior_by_itself() {
    let mut record = drilled(Hidden::default());
    let selection = selected(Vec::new(), vec![named("inflow_gain", &[-0.1])]);
    let [calibrated, bare] = [Vec::new(), vec![Step::Calibration]].map(|without| {
        record.without = without;
        let full = about(&record, &selection);
        sd(&estimates(&record, &selection, 0, &full)[0])
    });
    let share = find("inflow_gain").unwrap().about().search.size_error;
    let expected = widened(bare * bare, 0.1 * share);
    assert!(
        (calibrated / expected - 1.0).abs() < 1e-9,
        "{calibrated} {bare}"
    );
}

#[test]
fn no_interval_reaches_beyond_what_is_plausible() {
    const START_S: f64 = 1000.0;
    let mut record = drilled(Hidden::default());
    record.setting.span_s = (START_S, START_S + 5400.0);
    record.t_s.iter_mut().for_each(|t| *t += START_S);
    // A little gel that breaks and grows who knows how, and an influx of two and a half minutes that begins with the recording.
    let (gel, gain) = (&[0.5, 0.2, 300.0][..], &[0.02][..]);
    let influx = &[3e-3, START_S + 10.0, 150.0, 0.15][..];
    for (id, parameters) in [
        ("gel_strength", gel),
        ("inflow_gain", gain),
        ("influx", influx),
    ] {
        let selection = selected(Vec::new(), vec![named(id, parameters)]);
        let full = about(&record, &selection);
        let found = estimates(&record, &selection, 0, &full);
        let about = find(id).unwrap().about();
        for (one, parameter) in found.iter().zip(about.parameters) {
            let (shift, factor) = parameter.shown.scale(&record.setting);
            let least = shift + factor * parameter.low;
            assert!(one.ci95.0 >= least, "{}: {:?}", one.name, one.ci95);
            // No recording shows what began before it.
            if parameter.role == Role::Onset {
                assert_eq!(one.ci95.0, START_S);
            }
            assert!(one.ci95.0 <= one.estimate && one.estimate <= one.ci95.1);
        }
        assert_eq!(found[0].ci95.0 == 0.0, id == "gel_strength");
    }
}

#[test]
fn where_the_curvature_cannot_be_inverted_a_strength_may_be_all_that_is_plausible() {
    let record = drilled(Hidden::default());
    let one = named("inflow_gain", &[0.02]);
    let selection = selected(Vec::new(), vec![one.clone()]);
    let (state, full) = (selection.state(), about(&record, &selection));
    let about = one.applied.effect.about().parameters[0];
    let (shift, factor) = about.shown.scale(&record.setting);
    let size = |found: &[ParameterEstimate]| found[0].ci95;
    let told = Estimator::of(&record, &state, &full);
    let inside = size(&told.estimates(&one));
    for covariance in [None, Some(DMatrix::from_element(1, 1, f64::NAN))] {
        let untold = Estimator {
            covariance,
            ..Estimator::of(&record, &state, &full)
        };
        let (low, high) = size(&untold.estimates(&one));
        assert!(low < inside.0 && high > inside.1);
        assert_eq!(high, shift + factor * about.high);
    }
}

#[test]
fn two_strengths_that_look_alike_are_less_certain_together() {
    let record = drilled(Hidden::default());
    let both = vec![
        named("inflow_gain", &[0.0]),
        named("return_flow_gain", &[0.0]),
    ];
    let selection = selected(Vec::new(), both.clone());
    let full = about(&record, &selection);
    let [a, b] = [0, 1].map(|e| along(&record, &full, &selection.state(), (e, 0)));
    let usual = both
        .iter()
        .map(|n| 3.0 * n.applied.effect.about().parameters[0].usual);
    let priors: Vec<f64> = usual.map(|w| 1.0 / (w * w)).collect();
    let (aa, bb, ab) = (
        dot(&a, &a) + priors[0],
        dot(&b, &b) + priors[1],
        dot(&a, &b),
    );
    let determinant = aa * bb - ab * ab;
    // They do look alike: one alone is better known.
    assert!(determinant < 0.9 * aa * bb);
    for (k, own) in [(0, bb), (1, aa)] {
        let expected = widened(own / determinant, 0.0);
        let found = sd(&estimates(&record, &selection, k, &full)[0]);
        assert!(
            (found / expected - 1.0).abs() < 0.03,
            "{k}: {found} for {expected}"
        );
    }
}

#[test]
fn what_allows_for_timing_and_a_correction_take_no_certainty_away() {
    let record = drilled(Hidden::default());
    let mut lag = Applied::new(find("pump_speed_lag").unwrap(), vec![2.0]);
    lag.allowance = true;
    let knots = vec![0.0; unknown().about().parameters.len()];
    let gain = named("inflow_gain", &[0.0]);
    let correction = Named {
        applied: Applied::new(unknown(), knots),
        held: None,
        most: None,
        ..gain.clone()
    };
    let selection = selected(vec![lag], vec![gain, correction]);
    let full = about(&record, &selection);
    let a = along(&record, &full, &selection.state(), (1, 0));
    let expected = widened(1.0 / (dot(&a, &a) + 1.0 / (0.09 * 0.09)), 0.0);
    let found = sd(&estimates(&record, &selection, 0, &full)[0]);
    assert!(
        (found / expected - 1.0).abs() < 0.02,
        "{found} for {expected}"
    );
    assert!(estimates(&record, &selection, 1, &full).is_empty());
}

/// Three blocks are the standard error of a time at best; the rate and the ramp share what the rows tell.
#[test]
fn times_are_known_to_a_minute_at_best_and_a_rate_no_better_than_its_form() {
    let (record, one) = influx_of(3e-3);
    let state = [one.applied.clone()];
    let full = Tangent::at(&record, &state, &[], Bend::Stiff).unwrap();
    let found = estimates(&record, &selected(Vec::new(), vec![one]), 0, &full);
    let names: Vec<&str> = found.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["rate_m3_s", "onset_s", "duration_s", "ramp"]);
    // Its end is told worse than its beginning, by what the form of a kick lacks.
    let [onset, lasting] = [&found[1], &found[2]].map(|p| p.ci95.1 - p.estimate);
    let lacks = 1.96 * find("influx").unwrap().about().parameters[2].time_error_s;
    assert!((58.7..120.0).contains(&onset), "{onset}");
    assert!(
        lasting > lacks && lasting < lacks.hypot(2.0 * onset),
        "{lasting}"
    );
    let rate = sd(&found[0]);
    let lacks = find("influx").unwrap().about().search.size_error * 3e-3;
    assert!(rate > lacks && rate < 5.0 * lacks, "{rate}");
    // By differences of the joint curve itself.
    let [a, b] = [0, 3].map(|j| along(&record, &full, &state, (0, j)));
    let (aa, bb, ab) = (
        dot(&a, &a) + 1.0 / (4.5e-3_f64).powi(2),
        dot(&b, &b) + 1.0 / (0.45_f64).powi(2),
        dot(&a, &b),
    );
    let determinant = aa * bb - ab * ab;
    assert!(
        (rate / widened(bb / determinant, lacks) - 1.0).abs() < 0.02,
        "{rate}"
    );
    let ramp = sd(&found[3]) / widened(aa / determinant, 0.0);
    assert!((ramp - 1.0).abs() < 0.1, "{ramp}");
}

/// By the normal equations of what the strengths and shapes of the moved state change.
#[test]
fn moving_a_time_costs_what_no_strength_or_shape_makes_good() {
    // Of a small influx noise tells as much as its times do.
    for rate in [3e-3, 2e-4] {
        moved_as_expected(rate);
    }
}

fn moved_as_expected(rate: f64) {
    let (record, influx) = influx_of(rate);
    let (from, lasts, rise) = INFLUX_S;
    let state = [named("inflow_gain", &[0.01]).applied, influx.applied];
    let full = Tangent::at(&record, &state, &[], Bend::Stiff).unwrap();
    let (onset, free) = ((1, 1), [(0, 0), (1, 0), (1, 3)]);
    let profile = Profile {
        estimator: &Estimator::of(&record, &state, &full),
        most: 1.0,
    };
    let expected = |state: &[Applied]| {
        let change = full.signature(&record, state);
        let left: Vec<f64> = (full.off.iter().zip(&change)).map(|(o, c)| o - c).collect();
        let along = free.map(|at| direction(&record, &full, state, at, Some(&change)));
        let widths = [0.09, 4.5e-3, 0.45_f64];
        let gram = nalgebra::Matrix3::from_fn(|a, b| {
            let prior = if a == b { widths[a].powi(-2) } else { 0.0 };
            dot(&along[a], &along[b]) + prior
        });
        let pull = nalgebra::Vector3::from_fn(|a, _| dot(&along[a], &left));
        0.5 * (dot(&left, &left) - pull.dot(&gram.lu().solve(&pull).unwrap()))
    };
    let still = [profile.misfit(&state, 1), expected(&state)];
    for by in [-900.0, -300.0, 300.0, 900.0] {
        let moved = profile.moved(onset, by).unwrap();
        // Its end stays where it is.
        assert_eq!(moved[1].parameters, [rate, from + by, lasts - by, rise]);
        let found = profile.misfit(&moved, 1) - still[0];
        let wanted = expected(&moved) - still[1];
        assert!(
            (found - wanted).abs() < 1e-3 * wanted.abs().max(1.0),
            "{by}: {found} for {wanted}"
        );
    }
    assert!(profile.moved(onset, lasts).is_none());
}

/// A time reaches as far as the evidence allows, and three blocks at least.
#[test]
fn a_time_reaches_to_where_moving_it_costs_what_an_interval_may() {
    let (record, one) = influx_of(5e-4);
    let from = INFLUX_S.0;
    let state = [one.applied.clone()];
    let full = Tangent::at(&record, &state, &[], Bend::Stiff).unwrap();
    let estimator = Estimator::of(&record, &state, &full);
    let within = |most: f64| Profile {
        estimator: &estimator,
        most,
    };
    // Two and a half of its deviations at 95 %: (1.96 x 2.5)^2 / 2.
    let usual = within(12.005);
    for side in [-1.0, 1.0] {
        assert_eq!(within(1e-6).reach((0, 1), side), 1.96 * 30.0);
        let far = usual.reach((0, 1), side);
        let costs = |by: f64| {
            let moved = usual.moved((0, 1), side * by).unwrap();
            usual.misfit(&moved, 0) - usual.misfit(&state, 0)
        };
        assert!(far > 1.96 * 30.0 && costs(far) > 12.005, "{far}");
        assert!(costs(far * (1.0 - 1.0 / 16.0)) <= 12.005, "{far}");
    }
    let found = estimates(&record, &selected(Vec::new(), vec![one]), 0, &full);
    let lacks = 1.96 * find("influx").unwrap().about().parameters[1].time_error_s;
    let (low, high) = found[1].ci95;
    for (side, found) in [(-1.0, from - low), (1.0, high - from)] {
        let told = usual.reach((0, 1), side).hypot(lacks);
        assert!((found - told).abs() < 1e-9, "{found} for {told}");
    }
}

/// What half a rate tells of its onset is less than half of what the whole tells.
#[test]
fn the_smaller_an_effect_the_less_is_told_of_when_it_began() {
    let from = INFLUX_S.0;
    let onset = |rate: f64| {
        let (record, one) = influx_of(rate);
        let state = [one.applied.clone()];
        let full = Tangent::at(&record, &state, &[], Bend::Stiff).unwrap();
        let found = estimates(&record, &selected(Vec::new(), vec![one]), 0, &full);
        let (low, high) = found[1].ci95;
        assert!(low < from && from < high);
        high - low
    };
    let [small, large] = [5e-4, 1e-2].map(onset);
    assert!(small > 2.0 * large, "{small} {large}");
    // Rows hold nothing between blocks.
    assert!((large - 2.0 * 1.96 * 30.0).abs() < 1e-9, "{large}");
}

/// Without a connection no pipe moves, and nothing tells of it: three times what is usual, and of a choice nothing.
#[test]
fn what_the_recording_does_not_show_is_known_as_well_as_before() {
    let record = drilled(Hidden::default());
    let pipe = find("pipe_displacement").unwrap().about();
    let values: Vec<f64> = pipe
        .parameters
        .iter()
        .map(|p| 0.5 * p.usual.max(1.0))
        .collect();
    let selection = selected(Vec::new(), vec![named(pipe.id, &values)]);
    let found = estimates(&record, &selection, 0, &about(&record, &selection));
    for (j, (one, parameter)) in found.iter().zip(pipe.parameters).enumerate() {
        let chosen = matches!(parameter.role, Role::Choice(_));
        let width = if chosen { 0.0 } else { 3.0 * parameter.usual };
        let form = if j == 0 {
            pipe.search.size_error * values[0]
        } else {
            0.0
        };
        let half = 1.96 * (2.0 * width).hypot(form);
        let low = match j {
            0 => values[0] * (-half / values[0]).exp(),
            _ => values[j] - half,
        };
        let ends = [low, values[j] + half].map(|end| end.clamp(parameter.low, parameter.high));
        let off = [one.ci95.0 - ends[0], one.ci95.1 - ends[1]];
        assert!(
            off.iter().all(|off| off.abs() <= 1e-9 * half),
            "{}",
            parameter.name
        );
    }
}

/// A window may begin amid an event, and a search may leave what is plausible.
#[test]
fn an_onset_before_the_recording_is_told_as_one_and_an_interval_holds_its_estimate() {
    let (mut record, mut one) = influx_of(3e-3);
    let (from, _, _) = INFLUX_S;
    record.setting.span_s.0 = from + 600.0;
    let state = [one.applied.clone()];
    let full = Tangent::at(&record, &state, &[], Bend::Stiff).unwrap();
    let found = estimates(&record, &selected(Vec::new(), vec![one.clone()]), 0, &full);
    let onset = &found[1];
    assert_eq!((onset.estimate, onset.ci95.0), (from + 600.0, from + 600.0));
    assert_eq!(
        onset.meaning,
        "when it sets in: before the recording begins"
    );
    // Shorter than an influx is known to last.
    one.applied.parameters[2] = 0.5 * find("influx").unwrap().about().parameters[2].low;
    let found = estimates(&record, &selected(Vec::new(), vec![one]), 0, &full);
    for told in &found {
        assert!(
            told.ci95.0 <= told.estimate && told.estimate <= told.ci95.1,
            "{told:?}"
        );
    }
}
