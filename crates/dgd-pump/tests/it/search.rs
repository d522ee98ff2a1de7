use dgd_pump::{
    ConstrainedOptions, HeadCurve, Limit, Rule, SearchOptions, SearchStatus, fit_constrained,
    fit_unconstrained, search_exponents,
};

use crate::{PUMP, Recording};

const TRUTH: HeadCurve = HeadCurve {
    c0: 0.08,
    c1: 2.0,
    c2: 6e3,
    n0: 1.93,
    n2: 1.64,
};

#[test]
fn known_exponents_are_recovered() {
    let recording = Recording::new(8000, &TRUTH, 0.1);
    let found = search_exponents(&recording.samples(), &SearchOptions::default()).unwrap();
    assert_eq!(found.status, SearchStatus::Converged);
    assert!(found.limits.is_empty());
    assert!((found.fit.curve.n0 - 1.93).abs() < 2e-3, "{:?}", found.fit);
    assert!((found.fit.curve.n2 - 1.64).abs() < 2e-2, "{:?}", found.fit);
    assert!((found.fit.mse_m2 / (0.01 / 3.0) - 1.0).abs() < 0.05);
    assert!(found.table_error < 1e-6);
}

/// Nine intervals in ten of 95 % at the least, of exponents and of coefficients beside them; with the exponents as known that of c0 holds
/// fewer than one in three.
#[test]
fn errors_of_coefficients_and_exponents_together_hold_the_truth() {
    const DRAWS: usize = 60;
    let (mut held, mut as_known) = ([0_usize; 5], 0_usize);
    for seed in 0..DRAWS {
        let mut recording = Recording::new(4000, &TRUTH, 0.0);
        for (i, head) in recording.head.iter_mut().enumerate() {
            *head += 0.5 * crate::noise(i + 104_729 * (seed + 1));
        }
        let found = search_exponents(&recording.samples(), &SearchOptions::default()).unwrap();
        let joint = found.joint.unwrap();
        let HeadCurve { c0, c1, c2, n0, n2 } = found.fit.curve;
        let [e0, e1, e2] = joint.coefficients.map(Option::unwrap);
        let [m0, m2] = joint.exponents.map(Option::unwrap);
        let off = [
            c0 - TRUTH.c0,
            c1 - TRUTH.c1,
            c2 - TRUTH.c2,
            n0 - TRUTH.n0,
            n2 - TRUTH.n2,
        ];
        for ((held, off), error) in held.iter_mut().zip(off).zip([e0, e1, e2, m0, m2]) {
            *held += usize::from(off.abs() < 1.96 * error);
        }
        as_known += usize::from(off[0].abs() < 1.96 * found.fit.standard_errors[0].unwrap());
    }
    assert!(held.iter().all(|held| 10 * held >= 9 * DRAWS), "{held:?}");
    assert!(3 * as_known < DRAWS, "{as_known}");
}

/// What rests on an end or was held has no error, and longer recordings are measured by every so many-th row.
#[test]
fn what_was_not_free_has_no_joint_error_and_rows_may_be_left_out() {
    let recording = Recording::new(8000, &TRUTH, 0.1);
    let options = SearchOptions {
        n0: 1.0..=1.9,
        ..SearchOptions::default()
    };
    let found = search_exponents(&recording.samples(), &options).unwrap();
    assert_eq!(found.limits, [Limit::C1Zero, Limit::N0Upper]);
    let joint = found.joint.unwrap();
    assert_eq!((joint.coefficients[1], joint.exponents[0]), (None, None));
    let free = [
        joint.coefficients[0],
        joint.coefficients[2],
        joint.exponents[1],
    ];
    assert!(free.iter().all(Option::is_some));
    let errors = |samples: usize| {
        let recording = Recording::new(samples, &TRUTH, 0.1);
        let found = search_exponents(&recording.samples(), &SearchOptions::default()).unwrap();
        found.joint.unwrap().exponents[1].unwrap()
    };
    // A fifth of the rows, and the noise of all of them.
    let share = errors(40_960) / errors(8192);
    assert!((share * 5.0_f64.sqrt() - 1.0).abs() < 0.1, "{share}");
}

/// The closer a curve fits, the less the table's rounding may count as a difference, and keep the search going.
#[test]
fn a_curve_that_fits_closely_or_exactly_ends_and_is_trusted() {
    for noise in [0.0, 1e-6, 1e-3, 1e-2, 0.1, 3.0] {
        let recording = Recording::new(2000, &TRUTH, noise);
        let found = search_exponents(&recording.samples(), &SearchOptions::default()).unwrap();
        assert_eq!(found.status, SearchStatus::Converged, "{noise}");
        assert!(found.table_error < 1e-6, "{noise}: {}", found.table_error);
        let most = 1e-5 + 0.02 * noise;
        assert!((found.fit.curve.n0 - 1.93).abs() < most, "{noise}");
        assert!((found.fit.curve.n2 - 1.64).abs() < 10.0 * most, "{noise}");
    }
}

#[test]
fn no_neighbour_is_better_and_the_fit_is_that_of_qr() {
    let recording = Recording::new(8000, &TRUTH, 1.0);
    let found = search_exponents(&recording.samples(), &SearchOptions::default()).unwrap();
    let HeadCurve { n0, n2, .. } = found.fit.curve;
    let at = |n0, n2| fit_unconstrained(&recording.samples(), n0, n2).unwrap();
    let same = at(n0, n2);
    assert!((same.curve.c1 / found.fit.curve.c1 - 1.0).abs() < 1e-9);
    assert!((same.mse_m2 / found.fit.mse_m2 - 1.0).abs() < 1e-12);
    for (d0, d2) in [
        (1e-3, 0.0),
        (-1e-3, 0.0),
        (0.0, 2e-2),
        (0.0, -2e-2),
        (1e-3, 2e-2),
    ] {
        assert!(at(n0 + d0, n2 + d2).mse_m2 > same.mse_m2);
    }
}

#[test]
fn the_start_does_not_matter() {
    let recording = Recording::new(8000, &TRUTH, 1.0);
    let mut ends = Vec::new();
    for start in [(1.9, 1.6), (2.0, 2.0), (2.5, 3.0), (50.0, -3.0)] {
        let options = SearchOptions {
            start,
            ..SearchOptions::default()
        };
        let found = search_exponents(&recording.samples(), &options).unwrap();
        ends.push((found.fit.curve.n0, found.fit.curve.n2, found.start));
    }
    for (n0, n2, _) in &ends {
        assert!(
            (n0 - ends[0].0).abs() < 1e-4 && (n2 - ends[0].1).abs() < 1e-3,
            "{ends:?}"
        );
    }
    assert_ne!(ends[3].2, (50.0, -3.0), "an impossible guess is replaced");
}

#[test]
fn the_path_falls_and_the_trials_hold_every_cost() {
    let recording = Recording::new(2000, &TRUTH, 1.0);
    let found = search_exponents(&recording.samples(), &SearchOptions::default()).unwrap();
    let first: Vec<_> = found.path.iter().filter(|p| p.search == 0).collect();
    assert!(first.len() > 10);
    assert!(
        first
            .windows(2)
            .all(|pair| pair[1].mse_m2 <= pair[0].mse_m2)
    );
    assert!(
        first
            .iter()
            .enumerate()
            .all(|(i, p)| p.iteration == i as u64)
    );
    let last = first.last().unwrap();
    assert_eq!((last.n0, last.n2), (found.first.n0, found.first.n2));
    for p in &found.path {
        let tried = |t: &&dgd_pump::Trial| t.n0 == p.n0 && t.n2 == p.n2;
        let trial = found.trials.iter().find(tried).unwrap();
        assert_eq!(trial.mse_m2, Some(p.mse_m2));
    }
}

#[test]
fn refused_trials_break_a_condition_and_the_others_do_not() {
    let recording = Recording::new(2000, &TRUTH, 1.0);
    let options = SearchOptions {
        start: (1.7, 1.05),
        rule: Rule::Refuse,
        ..SearchOptions::default()
    };
    let found = search_exponents(&recording.samples(), &options).unwrap();
    let refused = found.trials.iter().filter(|t| t.mse_m2.is_none()).count();
    assert!(refused > 0);
    for trial in &found.trials {
        let outside = trial.n2 <= 1.0 || trial.n2 > 4.0 || trial.n0 < 0.5 || trial.n0 > 4.0;
        if outside {
            assert_eq!(trial.mse_m2, None);
            continue;
        }
        let exact = fit_unconstrained(&recording.samples(), trial.n0, trial.n2).unwrap();
        let falls = exact.curve.c1 > 0.0 && exact.curve.c2 > 0.0;
        assert_eq!(trial.mse_m2.is_some(), falls, "{trial:?} {exact:?}");
        if let Some(mse) = trial.mse_m2 {
            assert!((mse / exact.mse_m2 - 1.0).abs() < 1e-8);
        }
    }
}

#[test]
fn both_rules_agree_on_an_optimum_in_the_open() {
    let recording = Recording::new(4000, &TRUTH, 1.0);
    let by = |rule| {
        let options = SearchOptions {
            rule,
            start: (1.93, 1.8),
            ..SearchOptions::default()
        };
        search_exponents(&recording.samples(), &options).unwrap()
    };
    let (hold, refuse) = (by(Rule::Hold), by(Rule::Refuse));
    assert_eq!(refuse.status, SearchStatus::Converged);
    assert!((hold.fit.curve.n0 - refuse.fit.curve.n0).abs() < 1e-4);
    assert!((hold.fit.mse_m2 / refuse.fit.mse_m2 - 1.0).abs() < 1e-8);
}

#[test]
fn data_that_want_a_rising_curve_end_at_the_best_of_the_limit() {
    // Head that rises with speed times flow: c1 < 0 at the exponents of the truth.
    let rising = HeadCurve { c1: -1.0, ..PUMP };
    let recording = Recording::new(4000, &rising, 1.0);
    let samples = recording.samples();
    let found = search_exponents(&samples, &SearchOptions::default()).unwrap();
    assert_eq!(found.status, SearchStatus::Converged);
    assert_eq!(found.limits, [Limit::C1Zero]);
    assert_eq!(found.fit.curve.c1, 0.0);
    assert_eq!(found.fit.standard_errors[1], None);
    assert!(found.table_error < 1e-6);
    let HeadCurve { n0, n2, .. } = found.fit.curve;
    let bounds = ConstrainedOptions {
        floor_share: 1e-12,
        ..ConstrainedOptions::default()
    };
    for (d0, d2) in [
        (2e-3, 0.0),
        (-2e-3, 0.0),
        (0.0, 3e-2),
        (0.0, -3e-2),
        (2e-3, 3e-2),
    ] {
        let near = fit_constrained(&samples, n0 + d0, n2 + d2, &bounds).unwrap();
        assert!(near.fit.mse_m2 > found.fit.mse_m2, "{d0} {d2}");
    }
}

#[test]
fn refusing_as_the_thesis_does_stops_at_the_wall_and_says_so() {
    let rising = HeadCurve { c1: -1.0, ..PUMP };
    let recording = Recording::new(4000, &rising, 1.0);
    let options = SearchOptions {
        rule: Rule::Refuse,
        ..SearchOptions::default()
    };
    let refuse = search_exponents(&recording.samples(), &options).unwrap();
    assert_eq!(refuse.status, SearchStatus::AtWall);
    assert_eq!(refuse.limits, [Limit::C1Zero]);
    let hold = search_exponents(&recording.samples(), &SearchOptions::default()).unwrap();
    assert!(hold.fit.mse_m2 < refuse.fit.mse_m2);
}

#[test]
fn a_head_that_only_rises_loses_both_terms() {
    let rising = HeadCurve {
        c1: -5.0,
        c2: -1e4,
        ..PUMP
    };
    let recording = Recording::new(2000, &rising, 0.1);
    let found = search_exponents(&recording.samples(), &SearchOptions::default()).unwrap();
    assert!(found.limits.contains(&Limit::C1Zero) && found.limits.contains(&Limit::C2Zero));
    assert_eq!((found.fit.curve.c1, found.fit.curve.c2), (0.0, 0.0));
}

#[test]
fn a_truth_below_the_concave_range_ends_at_its_lower_end() {
    let below = HeadCurve {
        n2: 0.6,
        c2: 200.0,
        c1: 2.0,
        ..PUMP
    };
    let recording = Recording::new(4000, &below, 0.1);
    let found = search_exponents(&recording.samples(), &SearchOptions::default()).unwrap();
    assert!(found.fit.curve.n2 > 1.0);
    assert!(
        found.limits.contains(&Limit::N2Lower),
        "{:?} {:?}",
        found.fit,
        found.limits
    );
}

#[test]
fn limits_of_iterations_and_restarts_are_statuses() {
    let recording = Recording::new(2000, &TRUTH, 1.0);
    let with = |max_iterations, restarts| {
        let options = SearchOptions {
            max_iterations,
            restarts,
            ..SearchOptions::default()
        };
        search_exponents(&recording.samples(), &options)
            .unwrap()
            .status
    };
    assert_eq!(with(3, 0), SearchStatus::IterationLimit);
    assert_eq!(with(400, 0), SearchStatus::RestartLimit);
}

#[test]
fn the_same_recording_gives_the_same_bytes() {
    let recording = Recording::new(2000, &TRUTH, 1.0);
    let search = || search_exponents(&recording.samples(), &SearchOptions::default()).unwrap();
    assert_eq!(search(), search());
}

#[test]
fn heads_in_other_units_give_the_same_exponents_to_the_last_bit() {
    // A power of 2 as the unit changes no digit, so not a single decision of the search.
    let rising = HeadCurve { c1: -1.0, ..PUMP };
    for (truth, rule) in [
        (TRUTH, Rule::Hold),
        (TRUTH, Rule::Refuse),
        (rising, Rule::Hold),
        (rising, Rule::Refuse),
    ] {
        let options = SearchOptions {
            rule,
            ..SearchOptions::default()
        };
        let mut recording = Recording::new(2000, &truth, 1.0);
        let plain = search_exponents(&recording.samples(), &options).unwrap();
        for unit in [2_f64.powi(-40), 2_f64.powi(40)] {
            let before = recording.head.clone();
            recording.head.iter_mut().for_each(|h| *h *= unit);
            let found = search_exponents(&recording.samples(), &options).unwrap();
            recording.head = before;
            let (a, b) = (&found.fit.curve, &plain.fit.curve);
            assert_eq!((a.n0, a.n2), (b.n0, b.n2), "{rule:?}, unit {unit}");
            assert_eq!((a.c0, a.c1), (b.c0 * unit, b.c1 * unit));
            assert_eq!(found.trials.len(), plain.trials.len());
            assert_eq!(found.limits, plain.limits);
            assert_eq!(found.status, plain.status);
        }
    }
}

#[test]
fn restarts_try_the_four_orientations_of_the_simplex_from_the_best_point() {
    let recording = Recording::new(2000, &TRUTH, 1.0);
    let found = search_exponents(&recording.samples(), &SearchOptions::default()).unwrap();
    let last = found.trials.last().unwrap().search;
    assert!(last >= 4, "four restarts without a gain end it: {last}");
    let mut best = found.start;
    let mut least = f64::INFINITY;
    for search in 0..=last {
        let mut corners: Vec<_> = found.trials.iter().filter(|t| t.search == search).collect();
        if search == 0 {
            corners.remove(0); // the guess itself, before there is a simplex
        }
        let turned = |n: f64, from: f64| (n / from - 1.0) / 0.05;
        let signs = [(1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0)][search as usize % 4];
        assert_eq!((corners[0].n0, corners[0].n2), best, "search {search}");
        assert!((turned(corners[1].n0, best.0) - signs.0).abs() < 1e-9);
        assert_eq!(corners[1].n2, best.1);
        assert_eq!(corners[2].n0, best.0);
        assert!((turned(corners[2].n2, best.1) - signs.1).abs() < 1e-9);
        for p in found.path.iter().filter(|p| p.search == search) {
            if p.mse_m2 < least {
                (least, best) = (p.mse_m2, (p.n0, p.n2));
            }
        }
    }
    assert_eq!(best, (found.fit.curve.n0, found.fit.curve.n2));
}

#[test]
fn a_start_that_is_refused_gives_way_to_the_best_of_the_grid() {
    let recording = Recording::new(2000, &TRUTH, 1.0);
    let options = SearchOptions {
        start: (2.0, 0.5),
        n0: 1.0..=3.6,
        n2: 1.0..=3.6,
        ..SearchOptions::default()
    };
    let found = search_exponents(&recording.samples(), &options).unwrap();
    assert_eq!(found.trials[0].mse_m2, None);
    let grid = &found.trials[1..170];
    // Middles of 13 equal parts of 2.6, that is of 0.2.
    for (k, trial) in grid.iter().enumerate() {
        let place = |i: usize| 1.1 + 0.2 * i as f64;
        assert!((trial.n0 - place(k / 13)).abs() < 1e-12, "{k}: {trial:?}");
        assert!((trial.n2 - place(k % 13)).abs() < 1e-12, "{k}: {trial:?}");
    }
    let least = grid
        .iter()
        .filter_map(|t| t.mse_m2)
        .fold(f64::MAX, f64::min);
    let at_start = grid.iter().find(|t| (t.n0, t.n2) == found.start).unwrap();
    assert_eq!(at_start.mse_m2, Some(least));
}

#[test]
fn each_end_of_a_range_that_holds_the_exponents_is_told() {
    let recording = Recording::new(4000, &TRUTH, 0.1);
    let limits = |n0, n2| {
        let options = SearchOptions {
            n0,
            n2,
            ..SearchOptions::default()
        };
        let mut limits = search_exponents(&recording.samples(), &options)
            .unwrap()
            .limits;
        // A forced exponent may cost a term, too.
        limits.retain(|l| !matches!(l, Limit::C1Zero | Limit::C2Zero));
        limits
    };
    assert_eq!(limits(1.0..=4.0, 1.0..=4.0), []);
    assert_eq!(limits(1.0..=1.9, 1.0..=4.0), [Limit::N0Upper]);
    assert_eq!(limits(1.96..=4.0, 1.0..=4.0), [Limit::N0Lower]);
    assert_eq!(limits(1.0..=4.0, 1.9..=4.0), [Limit::N2Lower]);
    assert_eq!(limits(1.0..=4.0, 1.0..=1.4), [Limit::N2Upper]);
}

#[test]
fn an_exponent_of_the_flow_of_one_is_not_concave_and_is_refused() {
    let recording = Recording::new(2000, &TRUTH, 1.0);
    let from = |n2| {
        let options = SearchOptions {
            start: (1.9, n2),
            ..SearchOptions::default()
        };
        let found = search_exponents(&recording.samples(), &options).unwrap();
        (found.trials[0].mse_m2, found.start == (1.9, n2))
    };
    assert_eq!(from(1.0), (None, false));
    assert!(matches!(from(1.0 + 1e-9), (Some(_), true)));
}

#[test]
fn a_search_costs_what_it_did() {
    // Pairs of exponents tried; more are slower and want a reason, fewer are to be written down here. Another library of mathematical
    // functions may move them a little.
    for (noise_m, told) in [(0.1, 317_usize), (1.0, 319)] {
        let recording = Recording::new(8000, &TRUTH, noise_m);
        let found = search_exponents(&recording.samples(), &SearchOptions::default()).unwrap();
        let now = found.trials.len();
        assert!(now.abs_diff(told) * 50 <= told, "{now}, were {told}");
    }
}

/// Along a wall where c2 is next to nothing n2 is next to unknown.
#[test]
fn beside_a_wall_coefficients_comply_and_an_exponent_that_nothing_tells_has_no_error() {
    for (c1, c2) in [(60.0, -4e3), (5.0, -1e3), (3.0, -10.0)] {
        let convex = HeadCurve {
            c1,
            c2,
            n2: 2.0,
            ..TRUTH
        };
        let recording = Recording::new(3000, &convex, 0.5);
        let options = SearchOptions {
            rule: Rule::Refuse,
            ..SearchOptions::default()
        };
        let found = search_exponents(&recording.samples(), &options).unwrap();
        assert!(found.fit.curve.c1 > 0.0 && found.fit.curve.c2 > 0.0);
        let [n0, n2] = found.joint.unwrap().exponents;
        assert!(n0.unwrap() < 0.1 && n2.is_none(), "{n0:?} {n2:?}");
    }
    // Away from the ends of the range too.
    let speed_alone = HeadCurve {
        c1: 0.0,
        c2: 0.0,
        ..TRUTH
    };
    let recording = Recording::new(3000, &speed_alone, 1e-3);
    let options = SearchOptions {
        rule: Rule::Refuse,
        ..SearchOptions::default()
    };
    let found = search_exponents(&recording.samples(), &options).unwrap();
    assert_eq!(found.limits, [Limit::C1Zero, Limit::C2Zero]);
    assert_eq!(found.joint.unwrap().exponents[1], None);
}

#[test]
fn an_exponent_whose_range_is_one_value_is_held_there() {
    let recording = Recording::new(8000, &TRUTH, 0.1);
    let search = |n0, n2| {
        let options = SearchOptions {
            n0,
            n2,
            ..SearchOptions::default()
        };
        search_exponents(&recording.samples(), &options).unwrap()
    };
    let found = search(1.93..=1.93, 1.0..=4.0);
    assert_eq!(found.status, SearchStatus::Converged);
    assert!((found.fit.curve.n2 - 1.64).abs() < 1e-2, "{:?}", found.fit);
    let errors = found.joint.unwrap().exponents;
    assert!(
        errors[0].is_none() && errors[1].unwrap() < 1e-2,
        "{errors:?}"
    );
    assert!(found.path.iter().all(|at| at.n0 == 1.93));
    assert!(found.trials.iter().all(|at| at.n0 == 1.93));
    // What fits best with n2 held is no worse than at a neighbour.
    let found = search(1.0..=4.0, 2.0..=2.0);
    let HeadCurve { n0, n2, .. } = found.fit.curve;
    assert_eq!(n2, 2.0);
    for beside in [n0 - 1e-3, n0 + 1e-3] {
        let options = ConstrainedOptions::default();
        let other = fit_constrained(&recording.samples(), beside, 2.0, &options).unwrap();
        assert!(other.fit.mse_m2 > found.fit.mse_m2);
    }
    let found = search(2.0..=2.0, 2.0..=2.0);
    assert_eq!((found.fit.curve.n0, found.fit.curve.n2), (2.0, 2.0));
}
