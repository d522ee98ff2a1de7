#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

use super::{over, tell};
use crate::ablation::Step;
use crate::layout::Section;
use crate::record::Record;
use crate::selection::{Named, Selection};
use crate::test_rig::{Hidden, drilled, named, selection, tangent_at};
use dgd_effects::{Place, Quantity};
use std::f64::consts::TAU;

/// Drilling of which a reading swings to and fro twice by so much, while what it reads does not.
fn swinging(by: f64, reading: impl Fn(&mut Record) -> &mut Vec<f64>) -> Record {
    let mut record = drilled(Hidden::default());
    let n = record.t_s.len() as f64;
    for (i, value) in reading(&mut record).iter_mut().enumerate() {
        *value += by * (2.0 * TAU * i as f64 / n).sin();
    }
    record.speed.clone_from(&record.filled.speed);
    record.mud_pump.clone_from(&record.filled.mud_pump);
    record
}

/// The pump turns by up to so many % less or more than is read.
fn turning(by_pct: f64) -> Record {
    swinging(by_pct, |record| &mut record.filled.speed)
}

fn told(record: &Record, named: Vec<Named>) -> Selection {
    let mut selection = selection(named);
    tell(record, &mut selection);
    selection
}

fn gas() -> Named {
    named("gas_in_pump", &[0.01, 1500.0, 1200.0, 150.0])
}

fn ids(selection: &Selection) -> Vec<&'static str> {
    let each = selection.named.iter();
    each.map(|n| n.applied.id()).collect()
}

#[test]
fn of_a_sound_rig_nothing_remains_and_what_was_named_stays() {
    let record = drilled(Hidden::default());
    let sound = tangent_at(&record, &[]);
    for section in [Section::Friction, Section::Head, Section::Balance] {
        let over = over(&record, &sound)(section);
        assert!(over < 0.8, "{section:?} {over}");
    }
    assert!(over(&record, &sound)(Section::Outlets).is_nan());
    assert!(told(&record, Vec::new()).named.is_empty());
    let none = named("gas_in_pump", &[0.0, 1500.0, 1200.0, 150.0]);
    assert_eq!(ids(&told(&record, vec![none])), ["gas_in_pump"]);
}

#[test]
fn what_remains_of_the_head_where_nothing_was_named_is_told_beyond_a_limit_and_grows_likelier() {
    assert!(told(&turning(0.1), Vec::new()).named.is_empty());
    let found = |by_pct: f64| {
        let mut found = told(&turning(by_pct), Vec::new()).named;
        assert_eq!(found.len(), 1, "{by_pct}");
        let one = found.remove(0);
        let curve = one.applied.curve().unwrap();
        assert_eq!((curve.place, curve.quantity), (Place::Head, Quantity::Time));
        assert!(one.alternatives.is_empty() && one.evidence > one.hurdle);
        one.probability
    };
    let [small, large] = [0.8, 1.0].map(found);
    assert!(
        0.7 < small && small < large && large < 1.0,
        "{small} {large}"
    );
}

#[test]
fn what_remains_of_the_balance_is_told_there() {
    let record = swinging(1e-3, |record| &mut record.filled.mud_pump);
    let found = told(&record, Vec::new()).named;
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].applied.curve().unwrap().place, Place::Balance);
}

#[test]
fn effects_of_the_head_give_way_to_what_leaves_less_and_share_what_it_is_short_of_certainty() {
    let record = turning(1.0);
    let once = told(&record, vec![gas()]).named;
    let mut again = gas();
    again.applied.parameters[1] = 4000.0;
    let both = vec![gas(), named("inflow_gain", &[0.001]), again];
    let twice = told(&record, both);
    assert_eq!(ids(&twice), ["inflow_gain", "unknown"]);
    for found in [&once[0], &twice.named[1]] {
        let alternatives: Vec<&str> = found.alternatives.iter().map(|a| a.0.as_str()).collect();
        assert_eq!(alternatives, ["gas_in_pump"]);
        assert!(found.likely() > found.probability && found.likely() <= 1.0);
    }
}

#[test]
fn beside_another_relation_or_a_correction_nothing_more_is_told() {
    let record = turning(1.0);
    assert_eq!(
        ids(&told(&record, vec![named("inflow_gain", &[0.02])])),
        ["inflow_gain"]
    );
    let unknown = told(&record, Vec::new()).named.remove(0);
    assert_eq!(
        ids(&told(&record, vec![unknown, gas()])),
        ["unknown", "gas_in_pump"]
    );
}

#[test]
fn nothing_is_told_without_the_step_or_without_corrections() {
    for step in [Step::Remains, Step::Corrections] {
        let mut record = turning(1.0);
        record.without = vec![step];
        assert!(told(&record, Vec::new()).named.is_empty());
    }
}
