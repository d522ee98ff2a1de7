//! What was put into a bench comes out by name.

use crate::benches::{
    Loop, Tanks, growing_string, names, pump_loop, tank_with_crest, told, two_tanks, well,
};
use dgd_revise::{Excuse, Outcome, Verdict};

const OVERFLOW: Tanks = Tanks {
    caught: 0.4,
    brim_known: true,
    siphon: 0.0,
    sigma: 1e-3,
    memory: 0.0,
    wander: 0.0,
};

#[test]
fn overflow_that_falls_into_the_lower_tank_is_named_with_its_share() {
    let found = two_tanks(OVERFLOW, 400);
    assert_eq!(found.verdict, Verdict::Explained, "{}", told(&found));
    assert_eq!(names(&found), ["upper.overflow_caught"], "{}", told(&found));
    let share = &found.findings[0].parameters[0];
    assert!((share.value - 0.4).abs() < 0.02, "{}", told(&found));
    assert!(share.ci95.0 < 0.4 && share.ci95.1 > 0.4, "{}", told(&found));
    // A brim that was not stated, at the height of the one that was, does the same.
    assert!(
        found.findings[0]
            .alternatives
            .iter()
            .any(|a| a.0 == "upper.unseen_brim"),
        "{}",
        told(&found)
    );
    // The right one leaves noise, so that none is looked for beside it.
    let larger = found.contenders.iter().find(|c| c.members.len() > 1);
    assert!(larger.is_none(), "{}", told(&found));
    let level = &found.outputs[0];
    assert!(
        level.test.1 < 1.1e-3 && level.test.0 > 5e-3,
        "{}",
        told(&found)
    );
}

#[test]
fn an_unstated_brim_is_named_with_its_height() {
    let found = two_tanks(
        Tanks {
            brim_known: false,
            ..OVERFLOW
        },
        400,
    );
    assert_eq!(names(&found), ["upper.unseen_brim"], "{}", told(&found));
    let height = &found.findings[0].parameters[0];
    assert!((height.value - 0.3).abs() < 0.01, "{}", told(&found));
}

#[test]
fn a_level_above_an_unstated_brim_is_named_though_it_shows_nothing_without_that() {
    let found = tank_with_crest(400);
    let mut names = names(&found);
    names.sort();
    assert_eq!(
        names,
        ["tank.brim_head", "tank.unseen_brim"],
        "{}",
        told(&found)
    );
    let level = &found.outputs[0];
    assert!(level.test.1 < 1.1 * 5e-4, "{}", told(&found));
}

#[test]
fn nothing_is_found_on_a_clean_bench() {
    let found = two_tanks(
        Tanks {
            caught: 0.0,
            ..OVERFLOW
        },
        400,
    );
    assert_eq!(found.verdict, Verdict::Consistent, "{}", told(&found));
    assert_eq!(found.excused, None);
    assert!(found.findings.is_empty() && found.classes.is_empty());
    // It says how small an effect it would have seen.
    let limit = |component: &str, effect: &str| {
        found
            .tested
            .iter()
            .find(|t| t.component == component && t.effect == effect)
            .and_then(|t| t.limit)
    };
    assert!(
        limit("upper", "overflow_caught").unwrap() < 0.1,
        "{:?}",
        found.tested
    );
    assert!(found.tested.iter().all(|t| t.outcome != Outcome::Found));
}

#[test]
fn a_siphon_that_no_catalogue_holds_is_unknown_with_its_place() {
    let found = two_tanks(
        Tanks {
            caught: 0.0,
            siphon: 2e-5,
            ..OVERFLOW
        },
        500,
    );
    assert_eq!(found.verdict, Verdict::Unexplained, "{}", told(&found));
    assert_eq!(names(&found), ["lower.unknown"], "{}", told(&found));
    let shape = found.findings[0].shape.as_ref().unwrap();
    assert_eq!(
        (shape.of.as_str(), shape.along.as_str()),
        ("lower", "lower.level")
    );
    // The outflow is strongest at 0.12 m.
    let least = (0..shape.knots.len()).min_by(|a, b| shape.values[*a].total_cmp(&shape.values[*b]));
    assert!(
        (shape.knots[least.unwrap()] - 0.12).abs() < 0.02,
        "{shape:?}"
    );
    // The curve is part of the readings after, and of no model.
    assert_eq!(found.unwritten(), found.findings.first());
    assert_eq!(found.after.theta, found.before.theta);
    assert_eq!(found.after.parameters, found.before.parameters);
    let (before, after) = found.outputs[0].training;
    assert!(after < before, "{}", told(&found));
}

#[test]
fn slip_and_clogging_that_hide_each_other_are_named_together() {
    let found = pump_loop(
        Loop {
            slip: 2e-10,
            clogging: 0.25,
            ..Loop::default()
        },
        400,
    );
    let mut names = names(&found);
    names.sort();
    assert_eq!(
        names,
        ["pump.pump_slip", "valve.clogging"],
        "{}",
        told(&found)
    );
    // Each alone leaves more than half of the error; together next to nothing.
    let of = |n: usize| {
        found
            .contenders
            .iter()
            .filter(move |c| c.members.len() == n)
    };
    assert!(of(1).all(|c| c.left_out > 0.5), "{}", told(&found));
    assert!(of(2).any(|c| c.left_out < 0.05), "{}", told(&found));
    let held =
        |c: &&dgd_revise::Check| c.name.starts_with("placebo") || c.name.contains("test part");
    assert_eq!(
        found
            .checks
            .iter()
            .filter(held)
            .filter(|c| c.passed)
            .count(),
        4,
        "{}",
        told(&found)
    );
}

#[test]
fn a_loss_left_out_of_a_relation_is_named_and_holds_where_it_was_not_fitted() {
    let found = well(6e4, 6e4, 0.0, 300);
    assert_eq!(found.verdict, Verdict::Explained, "{}", told(&found));
    // String and bit are in series: the same loss in either cannot be told apart.
    let class = &found.classes[0];
    for name in ["string.line_laminar", "bit.laminar_resistance"] {
        assert!(
            class.members.iter().any(|m| *m == [name]),
            "{}",
            told(&found)
        );
    }
    assert_eq!(found.sections.len(), 1, "{}", told(&found));
}

#[test]
fn a_cause_that_changes_along_the_depth_is_given_in_sections() {
    let found = well(3e4, 9e4, 800.0, 300);
    assert!(found.sections.len() > 1, "{}", told(&found));
    assert!(
        found
            .sections
            .iter()
            .any(|s| (s.from - 800.0).abs() < 100.0),
        "{}",
        told(&found)
    );
}

#[test]
fn what_does_not_hold_on_the_test_part_is_withdrawn() {
    let found = well(6e4, -6e4, 1500.0, 300);
    assert_eq!(found.verdict, Verdict::Unexplained, "{}", told(&found));
    let stands = found
        .checks
        .iter()
        .find(|c| c.name == "stands on the test part")
        .unwrap();
    assert!(!stands.passed, "{}", told(&found));
    assert_eq!(found.after.theta, found.before.theta);
}

/// Both are withdrawn, by different rules.
#[test]
fn what_is_withdrawn_is_told_by_the_rule_that_withdrew_it() {
    for (below, from, says) in [
        (-6e4, 1000.0, "does not fit the test part better"),
        (
            0.0,
            1500.0,
            "improves no instrument on the test part by more than chance",
        ),
    ] {
        let found = well(6e4, below, from, 300);
        let title = &found.findings[0].title;
        assert!(title.contains(says), "{}", told(&found));
        let mut checks = found.checks.iter();
        let stands = checks.find(|c| c.name == "stands on the test part");
        // `standpipe: 0.925 of what it was, ..`: the numbers say the same.
        let (_, share) = stands.unwrap().detail.split_once(": ").unwrap();
        let share: f64 = share.split(' ').next().unwrap().parse().unwrap();
        assert_eq!(share < 1.0, below == 0.0, "{share}");
    }
}

#[test]
fn noise_that_remembers_itself_is_no_finding() {
    let found = two_tanks(
        Tanks {
            caught: 0.0,
            memory: 0.95,
            ..OVERFLOW
        },
        400,
    );
    assert_eq!(found.verdict, Verdict::Consistent, "{}", told(&found));
}

#[test]
fn a_cause_that_the_base_hides_by_fitting_its_friction_away_is_named() {
    let found = growing_string(None, 600);
    let friction = &found.before.parameters[1];
    assert!(
        friction.path == "string.quadratic" && friction.at_bound,
        "{friction:?}"
    );
    assert_eq!(names(&found), ["string.tool_joints"], "{}", told(&found));
    let weight = found.findings[0].probability.unwrap();
    assert!((0.5..=1.0).contains(&weight), "{weight}");
    let (before, after) = found.outputs[0].test;
    assert!(after < 0.1 * before, "{before} {after}");
}

#[test]
fn what_the_instruments_are_not_good_for_is_no_mismatch() {
    let found = growing_string(Some(5e6), 600);
    assert_eq!(found.verdict, Verdict::Consistent, "{}", told(&found));
    assert!(found.findings.is_empty() && found.sections.is_empty());
    // There is a mismatch, and it does not matter.
    assert_eq!(found.excused, Some(Excuse::Accuracy));
    let check = |c: &&dgd_revise::Check| c.name.contains("accuracy");
    assert!(found.checks.iter().find(check).is_some_and(|c| c.passed));
}

#[test]
fn what_is_less_than_a_few_per_cent_of_the_noise_is_too_small_to_matter() {
    let found = two_tanks(
        Tanks {
            caught: 0.0,
            siphon: 2e-7,
            ..OVERFLOW
        },
        400,
    );
    assert_eq!(found.verdict, Verdict::Consistent, "{}", told(&found));
    let check = |c: &&dgd_revise::Check| c.name.contains("the noise to ten per cent");
    let check = found.checks.iter().find(check);
    assert!(check.is_some_and(|c| c.passed), "{}", told(&found));
}

#[test]
fn what_several_instruments_remember_is_the_systems_and_what_each_does_for_itself_is_not() {
    let wandering = pump_loop(
        Loop {
            wander: 0.02,
            ..Loop::default()
        },
        400,
    );
    assert_eq!(
        wandering.verdict,
        Verdict::Unexplained,
        "{}",
        told(&wandering)
    );
    let unknown = &wandering.findings[0];
    assert!(
        // Which of the two shows more does not tell where it sits.
        unknown.effect == "unknown"
            && unknown.component.is_empty()
            && ["discharge", "flow"]
                .iter()
                .all(|i| unknown.title.contains(i)),
        "{}",
        told(&wandering)
    );
    let gauges = pump_loop(
        Loop {
            memory: 0.9,
            ..Loop::default()
        },
        400,
    );
    assert_eq!(gauges.verdict, Verdict::Consistent, "{}", told(&gauges));
}

#[test]
fn what_a_named_cause_leaves_far_above_the_noise_is_unknown_beside_it() {
    let found = two_tanks(
        Tanks {
            caught: 0.6,
            wander: 0.015,
            ..OVERFLOW
        },
        400,
    );
    assert_eq!(found.verdict, Verdict::PartlyExplained, "{}", told(&found));
    let names = names(&found);
    assert_eq!(
        names.first().map(String::as_str),
        Some("upper.overflow_caught")
    );
    assert_eq!(names.last().map(String::as_str), Some("level.unknown"));
    let check = |c: &&dgd_revise::Check| c.name.contains("twice the noise");
    let check = found.checks.iter().find(check);
    assert!(check.is_some_and(|c| !c.passed), "{}", told(&found));
}
