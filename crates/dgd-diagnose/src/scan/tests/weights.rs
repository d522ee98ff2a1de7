//! Claims about what a candidate is worth.

use crate::ablation::Step;
use crate::record::Record;
use crate::scan::weigh;
use crate::test_rig::{Hidden, INFLUX_S, drilled, one, tangent_at};
use dgd_lsq::dot;

fn drilling(late_s: f64, influx_m3_s: f64) -> Record {
    drilled(Hidden {
        late_s,
        influx_m3_s,
        ..Hidden::default()
    })
}

#[test]
fn what_is_no_proportion_is_worth_half_of_what_the_misfit_falls_by() {
    let record = drilling(2.0, 0.0);
    let tangent = tangent_at(&record, &[]);
    let misfit = dot(&tangent.off, &tangent.off);
    for one in [
        one("u_tube", &[6.0, 1.0, 0.0]),
        one("pump_speed_lag", &[2.0]),
        one("return_flow_delay", &[2.0]),
    ] {
        let c = weigh(&record, &tangent, &[], one);
        let apart = tangent.off.iter().zip(&c.signature);
        let left: f64 = apart.map(|(off, s)| (off - s).powi(2)).sum();
        let saved = 0.5 * (misfit - left);
        assert!(saved.abs() > 0.1);
        assert!((c.evidence - saved).abs() < 1e-9 * misfit, "{saved}");
    }
}

#[test]
fn what_is_not_late_takes_nothing_away() {
    let mut record = drilling(2.0, 0.0);
    // A lateness that is named, of 0 here, leaves no flow free to be late.
    record.without = vec![Step::LateFlows];
    let tangent = tangent_at(&record, &[]);
    for id in ["return_flow_delay", "pump_speed_lag"] {
        let c = weigh(&record, &tangent, &[], one(id, &[0.0]));
        assert!(c.signature.iter().all(|v| v.abs() < 1e-6));
        assert!(c.evidence.abs() < 1e-6 && c.energy < 1e-6, "{}", c.evidence);
    }
}

#[test]
fn a_proportional_effect_weighs_the_same_at_any_strength_and_against_its_sign_nothing() {
    let (from, lasts, rise) = INFLUX_S;
    let weighed = |rate: f64, tried: f64| {
        let record = drilling(0.0, rate);
        let influx = one("influx", &[tried, from, lasts, rise]);
        weigh(&record, &tangent_at(&record, &[]), &[], influx)
    };
    let (small, large) = (weighed(3e-3, 1e-3), weighed(3e-3, 4e-3));
    assert!((small.score / small.energy / 3e-3 - 1.0).abs() < 0.1);
    assert!((small.energy / large.energy - 1.0).abs() < 1e-6);
    assert!((small.score / large.score - 1.0).abs() < 1e-6);
    assert!(small.evidence > 30.0 && (small.evidence / large.evidence - 1.0).abs() < 1e-6);
    // Mud that is lost is no influx.
    let lost = weighed(-3e-3, 1e-3);
    assert!(lost.score < 0.0 && lost.evidence < 0.0, "{}", lost.evidence);
}
