//! Claims about probabilities: doubt, shares among alternatives, calibration.

mod calibration;

use super::{calibrate, doubt, shared};
use crate::relations::Applied;
use crate::selection::Named;
use dgd_effects::find;

fn named(evidence: f64, probability: f64, alternative: f64) -> Named {
    let effect = dgd_effects::catalogue()[0];
    Named {
        applied: Applied::new(effect, Vec::new()),
        evidence,
        bent: 0.0,
        hurdle: 10.0,
        probability,
        alternatives: vec![("lost_circulation".to_owned(), alternative)],
        held: None,
        most: None,
    }
}

#[test]
fn a_form_at_its_strange_end_is_four_times_likelier_something_else() {
    let gel = |broken: f64| {
        let mut one = named(40.0, 0.9, 0.05);
        let effect = find("gel_strength").expect("an effect of the catalogue");
        one.applied = Applied::new(effect, vec![8.0, broken, 300.0]);
        doubt(&mut one);
        one
    };
    let (sound, strange) = (gel(0.2), gel(2.99));
    assert_eq!((sound.probability, sound.alternatives.len()), (0.9, 1));
    assert!((strange.probability / 0.9 - 0.198).abs() < 1e-3);
    let all: f64 = strange.alternatives.iter().map(|a| a.1).sum();
    assert!((strange.probability + all - 0.95).abs() < 1e-12);
    assert_eq!(strange.alternatives[0].0, "unknown");
    // What it was doubted for already counts as well.
    let mut twice = gel(2.99);
    doubt(&mut twice);
    let ids =
        |one: &Named| -> Vec<String> { one.alternatives.iter().map(|a| a.0.clone()).collect() };
    assert_eq!(ids(&twice), ids(&strange));
    assert!((twice.probability / strange.probability - 0.198).abs() < 1e-3);
    let all: f64 = twice.alternatives.iter().map(|a| a.1).sum();
    assert!((twice.probability + all - 0.95).abs() < 1e-12);
    // Each has its own end.
    let strange = |id: &str, parameters: &[f64]| {
        let mut one = named(40.0, 0.9, 0.05);
        one.applied = Applied::new(find(id).expect("of the catalogue"), parameters.to_vec());
        doubt(&mut one);
        one.probability < 0.5
    };
    for (mixing, share, seems) in [
        (0.01, 1.0, true),
        (0.1, 1.0, false),
        (1.9, 1.0, false),
        (2.0, 1.0, true),
        (0.5, 0.05, true),
        (0.5, 1.5, false),
    ] {
        assert_eq!(
            strange("mud_density_change", &[20.0, 3600.0, mixing, share]),
            seems,
            "{mixing} {share}"
        );
    }
    assert!(strange("viscosity_drift", &[0.3, 3.0]));
    assert!(!strange("viscosity_drift", &[0.3, -0.9]));
    // Fitted anew beside another cause, an annulus has come to what none is.
    let area = &find("annulus_area")
        .expect("of the catalogue")
        .about()
        .parameters[0];
    assert!(strange("annulus_area", &[area.low]) && strange("annulus_area", &[area.high]));
    assert!(!strange("annulus_area", &[0.9 * area.low]));
}

#[test]
fn a_calibrated_probability_grows_with_evidence_and_leaves_room_for_alternatives() {
    let mut last = 0.0;
    for evidence in [10.0, 20.0, 80.0, 1e4] {
        let mut one = [named(evidence, 0.7, 0.25)];
        calibrate(&mut one);
        assert!(one[0].probability > last);
        last = one[0].probability;
        assert!(last + one[0].alternatives[0].1 <= 1.0);
    }
}

#[test]
fn what_is_shared_adds_up_and_what_does_not_count_is_dropped() {
    let others = [("a", 0.25), ("b", 0.5), ("c", 1e-3)].map(|(id, w)| (id.to_owned(), w));
    let (own, others) = shared(0.9, others.to_vec());
    let ids: Vec<&str> = others.iter().map(|o| o.0.as_str()).collect();
    assert_eq!(ids, ["b", "a"]);
    assert!((others[0].1 / own - 0.5).abs() < 1e-12);
    let sum = own + others[0].1 + others[1].1;
    assert!((sum + 1e-3 * own - 0.9).abs() < 1e-12, "{sum}");
}

#[test]
fn a_cause_without_rivals_keeps_the_whole() {
    assert_eq!(shared(0.7, Vec::new()), (0.7, Vec::new()));
}
