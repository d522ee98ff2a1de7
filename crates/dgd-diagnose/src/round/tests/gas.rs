//! Claims about a pump that lifts less for a while, or from then on.

use crate::belief::calibrate;
use crate::contest::Contender;
use crate::record::Record;
use crate::round::Round;
use crate::select::{Sought, select};
use crate::selection::{Named, Selection};
use crate::test_rig::{Hidden, drilled};

/// The same drilling with a pump that lifts less by a share, for which it turns faster, by the time, s, and the speed, %, that it would turn with.
fn lifting_less(loss: impl Fn(f64, f64) -> f64) -> Record {
    let mut record = drilled(Hidden::default());
    for i in 0..record.t_s.len() {
        let loss = loss(record.t_s[i], record.speed[i]);
        let lift = record.outlet[i] - record.inlet[i];
        // Its head is 45 bar times the square of the speed over 70 %, less what the flow takes.
        let more = lift * loss / (1.0 - loss) / 45e5 * 70.0_f64.powi(2);
        record.speed[i] = (record.speed[i].powi(2) + more).sqrt();
    }
    record.filled.speed.clone_from(&record.speed);
    record
}

#[test]
fn a_head_that_is_lost_for_a_while_is_gas_and_one_that_stays_lost_is_nothing_of_the_catalogue() {
    let ends = 5400.0;
    for (stretch_s, is_gas) in [
        (1800.0..3600.0, true),
        (1800.0..ends, false),
        // It may have come before the recording began.
        (-1.0..3600.0, true),
    ] {
        let record = lifting_less(|t_s, _| if stretch_s.contains(&t_s) { 0.05 } else { 0.0 });
        let mut found = select(&record, &[], Sought::Any(3), |_| {}).unwrap().named;
        calibrate(&mut found);
        let gas = |n: &&Named| n.applied.id() == "gas_in_pump" && n.probability > 0.5;
        assert_eq!(found.iter().any(|n| gas(&n)), is_gas, "{stretch_s:?}");
        let unknown = |n: &Named| {
            let told = n
                .alternatives
                .iter()
                .any(|(id, p)| id == "unknown" && *p > 0.5);
            n.applied.is_correction() || told
        };
        assert_eq!(found.iter().any(unknown), !is_gas, "{stretch_s:?}");
    }
}

#[test]
fn a_head_that_is_lost_at_one_speed_whenever_that_comes_is_a_curve_of_the_speed_and_no_gas() {
    let along_speed = |record: &Record, id: &str| {
        let nothing = Selection {
            held: 0,
            allowances: Vec::new(),
            named: Vec::new(),
            first: Vec::new(),
            stays: false,
        };
        let round = Round::about(record, &nothing).unwrap();
        let it = |c: &&Contender| c.id() == id;
        let it = round.contenders.iter().find(it).unwrap();
        round.of_speed(it).map(|(found, _)| found.curve)
    };
    let passing = lifting_less(|t_s, _| {
        if (1800.0..3600.0).contains(&t_s) {
            0.05
        } else {
            0.0
        }
    });
    assert!(along_speed(&passing, "gas_in_pump").is_none());
    // The pump turns that fast now and then.
    let fast = lifting_less(|_, speed_pct| 0.05 * (-((speed_pct - 53.0) / 0.6).powi(2)).exp());
    // Wear does not pass, and an influx is not the pump's.
    for id in ["pump_wear", "influx"] {
        assert!(along_speed(&fast, id).is_none(), "{id}");
    }
    let curve = along_speed(&fast, "gas_in_pump").unwrap();
    assert!(
        curve.at(54.0) < curve.at(curve.from).min(curve.at(curve.to)),
        "{curve:?}"
    );
}

#[test]
fn what_the_pumps_own_curve_of_its_speed_may_be_is_no_gas() {
    let nothing = Selection {
        held: 0,
        allowances: Vec::new(),
        named: Vec::new(),
        first: Vec::new(),
        stays: false,
    };
    let passing = lifting_less(|t_s, _| {
        if (1800.0..3600.0).contains(&t_s) {
            0.05
        } else {
            0.0
        }
    });
    let seen = Round::about(&passing, &nothing).unwrap().contenders;
    let mut gas = seen.into_iter().find(|c| c.id() == "gas_in_pump").unwrap();
    (gas.evidence, gas.formed) = (30.0, 30.0);
    // Off by up to 4 bar about 52 % a straight line in the speed tells most of it, off by 12 about 53 % it does not.
    for (loss, at_pct, wide_pct, is_own) in [(0.1, 52.0, 2.0, true), (0.3, 53.0, 1.5, false)] {
        let record =
            lifting_less(|_, speed_pct| loss * (-((speed_pct - at_pct) / wide_pct).powi(2)).exp());
        let mut round = Round::about(&record, &nothing).unwrap();
        round.contenders = vec![gas.clone()];
        assert!(round.best(&[]).is_some());
        let likeliest = round.likeliest();
        assert_eq!(likeliest.is_none(), is_own, "{loss}");
        assert!(likeliest.is_none_or(|gas| gas.of_speed.is_some()));
    }
}
