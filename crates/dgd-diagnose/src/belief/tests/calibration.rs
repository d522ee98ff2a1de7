//! Claims about the calibration of probabilities.

use crate::belief::{
    CALIBRATION, archived, beside_unnamed, calibrate, is_unnamed, left_over, unmodelled,
};
use crate::relations::Applied;
use crate::selection::Named;

const HURDLE: f64 = 10.0;
const CONSTANT: f64 = CALIBRATION[0];
const MARGIN: f64 = CALIBRATION[1];
const SHARE: f64 = CALIBRATION[2];

fn named(evidence: f64, probability: f64) -> Named {
    Named {
        applied: Applied::new(dgd_effects::catalogue()[0], Vec::new()),
        evidence,
        bent: 0.0,
        hurdle: HURDLE,
        probability,
        alternatives: vec![("lost_circulation".to_owned(), 0.5 * (1.0 - probability))],
        held: None,
        most: None,
    }
}

fn correction(probability: f64) -> Named {
    Named {
        applied: Applied::new(dgd_effects::unknown(), Vec::new()),
        ..named(HURDLE, probability)
    }
}

fn logit(p: f64) -> f64 {
    (p / (1.0 - p)).ln()
}

/// Logit of the first of `count` findings alike, `folds` e-folds over their hurdle.
fn logit_of(count: usize, folds: f64, share: f64) -> f64 {
    let mut all = vec![named(HURDLE * folds.exp(), share); count];
    calibrate(&mut all);
    logit(all[0].probability)
}

fn close(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-9, "{found} for {expected}");
}

#[test]
fn logits_add_up_from_evidence_over_the_hurdle_and_the_share_among_alternatives() {
    const { assert!(CONSTANT < 0.0 && MARGIN > 0.0 && SHARE > 0.0) };
    // At the hurdle and with even odds, the constant alone.
    close(logit_of(1, 0.0, 0.5), CONSTANT);
    close(logit_of(1, 2.0, 0.5), CONSTANT + MARGIN * 2.0);
    close(logit_of(1, 0.0, 0.8), CONSTANT + SHARE * logit(0.8));
    // Below its hurdle it is judged as at it, and a hurdle below 1 as 1.
    close(logit_of(1, -3.0, 0.5), CONSTANT);
    let mut low = [Named {
        hurdle: 0.1,
        ..named(1.0, 0.5)
    }];
    calibrate(&mut low);
    close(logit(low[0].probability), CONSTANT);
}

#[test]
fn a_correction_that_no_model_runs_with_has_a_quarter_of_its_odds_and_a_cause_keeps_them() {
    let cause = named(HURDLE, 0.9);
    let mut one = cause.clone();
    unmodelled(&mut one);
    assert_eq!(one.probability, cause.probability);
    one.applied = correction(0.9).applied;
    let all = |n: &Named| n.probability + n.alternatives.iter().map(|a| a.1).sum::<f64>();
    unmodelled(&mut one);
    close(logit(all(&one)), logit(all(&cause)) - 4.0_f64.ln());
    // What looks like it loses with it.
    let share = |n: &Named| n.alternatives[0].1 / n.probability;
    close(share(&one), share(&cause));
}

#[test]
fn a_correction_beside_what_it_may_be_instead_is_not_let_go_for_that() {
    let mut one = correction(0.6);
    one.alternatives = vec![("gel_strength".to_owned(), 0.395)];
    unmodelled(&mut one);
    // As a sum of 0.99: its own odds alone would come to 0.27.
    close(one.probability, 0.6 * (0.25 / (0.25 * 0.99 + 0.01)));
    assert!(one.probability > 0.5 && one.likely() > 0.9);
}

#[test]
fn a_share_of_none_or_all_is_no_certainty() {
    close(logit_of(1, 0.0, 0.0), CONSTANT + SHARE * logit(1e-9));
    close(logit_of(1, 0.0, 1.0), CONSTANT + SHARE * logit(0.99));
}

#[test]
fn a_cause_that_leaves_more_than_noise_has_a_fifth_of_its_odds_and_what_is_none_of_the_catalogue_the_rest()
 {
    let before = named(HURDLE, 0.96);
    let mut one = before.clone();
    left_over(&mut one, false);
    close(logit(one.probability), logit(0.96) - 5.0_f64.ln());
    let all = |n: &Named| n.probability + n.alternatives.iter().map(|a| a.1).sum::<f64>();
    close(all(&one), all(&before));
    assert_eq!(one.alternatives[0].0, "unknown");
    // A correction is not the catalogue's.
    let mut unnamed = correction(0.96);
    left_over(&mut unnamed, false);
    assert_eq!(unnamed.probability, 0.96);
}

#[test]
fn a_name_beside_what_the_catalogue_does_not_hold_has_a_third_of_its_odds_and_is_doubted_once() {
    let beside = |other: Named| {
        let mut both = [named(HURDLE, 0.96), other];
        beside_unnamed(&mut both);
        both.map(|n| n.probability)
    };
    let [name, unnamed] = beside(correction(0.9));
    close(logit(name), logit(0.96) + 0.35_f64.ln());
    // What its relation keeps is of the same cause.
    let mut doubted = named(HURDLE, name);
    left_over(&mut doubted, true);
    close(logit(doubted.probability), logit(0.96) - 5.0_f64.ln());
    assert_eq!(unnamed, 0.9);
    assert_eq!(beside(correction(0.4))[0], 0.96);
    assert_eq!(beside(named(HURDLE, 0.9)), [0.96, 0.9]);
    // A name that is likelier no cause of the catalogue is as good as none, and loses nothing by it.
    let mut as_good = named(HURDLE, 0.2);
    as_good.alternatives = vec![("unknown".to_owned(), 0.75)];
    assert!(is_unnamed(&as_good) && !is_unnamed(&named(HURDLE, 0.9)));
    assert_eq!(beside(as_good), [name, 0.2]);
}

#[test]
fn a_cause_that_a_rival_leaves_next_to_no_share_is_not_likely_for_all_its_evidence() {
    let mut one = [named(1e4 * HURDLE, 1e-6)];
    one[0].alternatives = vec![("lost_circulation".to_owned(), 0.99)];
    calibrate(&mut one);
    let [one] = one;
    assert!(one.probability < 0.5, "{}", one.probability);
    assert!(one.probability + one.alternatives[0].1 <= 1.0);
}

#[test]
fn what_bounds_a_probability_bounds_it_however_much_evidence_there_is_and_another_has_the_rest() {
    let bounded = |bound: Option<(f64, &'static str)>| {
        let mut one = [Named {
            most: bound,
            ..named(1e6, 0.9)
        }];
        calibrate(&mut one);
        let [one] = one;
        one
    };
    let free = bounded(None);
    let other = free.alternatives[0].clone();
    let rest = free.probability - 0.6;
    let one = bounded(Some((0.6, "influx")));
    assert_eq!(one.probability, 0.6);
    assert_eq!(
        one.alternatives,
        [("influx".to_owned(), rest), other.clone()]
    );
    // One that is an alternative already is likelier by it.
    let known = dgd_effects::find(&other.0).map_or("", |e| e.about().id);
    assert_eq!(
        bounded(Some((0.6, known))).alternatives,
        [(other.0, other.1 + rest)]
    );
    let above = bounded(Some((0.999_999, "influx")));
    assert_eq!(
        (above.probability, above.alternatives),
        (free.probability, free.alternatives)
    );
}

#[test]
fn company_neither_adds_to_a_probability_nor_takes_from_it() {
    for (folds, share) in [(0.0, 0.99), (1.5, 0.625), (5.0, 0.99)] {
        let alone = logit_of(1, folds, share);
        for count in [2, 3, 6] {
            close(logit_of(count, folds, share), alone);
        }
    }
}

#[test]
fn what_the_cause_gains_its_alternatives_lose_and_what_it_loses_they_lose_with_it() {
    for (folds, share) in [(4.0, 0.6), (0.0, 0.6), (2.0, 0.9)] {
        let mut one = [named(HURDLE * f64::exp(folds), share)];
        calibrate(&mut one);
        let (own, other) = (one[0].probability, one[0].alternatives[0].1);
        let expected = if own > share {
            // They keep their part of what is left.
            0.5 * (1.0 - own)
        } else {
            0.5 * (1.0 - share) * own / share
        };
        close(other, expected);
    }
    // Both ways were gone.
    assert!(logit_of(1, 4.0, 0.6) > logit(0.6) && logit_of(1, 0.0, 0.6) < logit(0.6));
}

#[test]
fn an_empirical_correction_is_no_cause_and_keeps_its_probability() {
    let mut all = [correction(0.5), named(100.0, 0.5)];
    calibrate(&mut all);
    assert_eq!(all[0].probability, 0.5);
    assert_ne!(all[1].probability, 0.5);
}

#[test]
fn what_an_archive_can_make_up_is_likelier_something_else_unless_it_is_next_to_certain() {
    let [made_up, certain] = [0.96, 0.99].map(|probability| {
        let mut one = named(HURDLE, probability);
        archived(&mut one);
        one
    });
    close(logit(made_up.probability), logit(0.96) + 0.03_f64.ln());
    assert!(made_up.probability < 0.5 && certain.probability > 0.5);
    assert_eq!(made_up.alternatives[0].0, "unknown");
    let all = |n: &Named| n.probability + n.alternatives.iter().map(|a| a.1).sum::<f64>();
    close(all(&made_up), all(&named(HURDLE, 0.96)));
}
