#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

use super::{over, tell};
use crate::ablation::Step;
use crate::layout::Section;
use crate::record::Record;
use crate::selection::{Named, Selection};
use crate::test_rig::{DT_S, Hidden, drilled, named, tangent_at};
use dgd_effects::{Place, Quantity, Relation};
use std::f64::consts::TAU;

/// Drilling whose pump turns by up to so many % more or less than is read, to and fro twice.
fn turning_to_and_fro(more_pct: f64) -> Record {
    let mut record = drilled(Hidden::default());
    let whole = TAU / (DT_S * record.t_s.len() as f64);
    for (speed, t_s) in record.filled.speed.iter_mut().zip(&record.t_s) {
        *speed -= more_pct * (2.0 * whole * t_s).sin();
    }
    record.speed.clone_from(&record.filled.speed);
    record
}

fn selection(named: Vec<Named>) -> Selection {
    Selection {
        held: 0,
        allowances: Vec::new(),
        named,
        first: Vec::new(),
    }
}

fn told(record: &Record, named: Vec<Named>) -> Selection {
    let mut selection = selection(named);
    tell(record, &mut selection);
    selection
}

fn gas() -> Named {
    named("gas_in_pump", &[0.01, 1500.0, 1200.0, 150.0])
}

#[test]
fn of_a_sound_rig_nothing_remains() {
    let record = drilled(Hidden::default());
    for section in [Section::Friction, Section::Head, Section::Balance] {
        let over = over(&record, &tangent_at(&record, &[]), section);
        assert!(over < 0.8, "{section:?} {over}");
    }
    assert!(told(&record, Vec::new()).named.is_empty());
}

#[test]
fn what_remains_where_nothing_was_named_is_told_in_its_relation_and_grows_likelier_with_its_size() {
    let found = |more_pct: f64| {
        let record = turning_to_and_fro(more_pct);
        let mut found = told(&record, Vec::new()).named;
        assert_eq!(found.len(), 1, "{more_pct}");
        let one = found.remove(0);
        let curve = one.applied.curve().unwrap();
        assert_eq!(curve.place, Place::Head);
        assert_eq!(curve.quantity, Quantity::Time);
        assert!(one.alternatives.is_empty());
        one.probability
    };
    let [small, large] = [0.8, 1.0].map(found);
    assert!(
        small > 0.75 && large > small && large < 1.0,
        "{small} {large}"
    );
}

#[test]
fn an_effect_of_the_head_gives_way_to_what_leaves_less_and_is_an_alternative_to_it() {
    let record = turning_to_and_fro(1.0);
    let found = told(&record, vec![named("inflow_gain", &[0.0]), gas()]).named;
    let ids: Vec<&str> = (found.iter())
        .map(|n| n.applied.effect.about().id)
        .collect();
    assert_eq!(ids, ["inflow_gain", "unknown"]);
    let alternatives = &found[1].alternatives;
    assert_eq!(alternatives[0].0, "gas_in_pump");
    assert!(found[1].likely() <= 1.0);
}

#[test]
fn what_another_relation_was_named_for_or_the_catalogue_does_not_hold_stays_alone() {
    let record = turning_to_and_fro(1.0);
    let elsewhere = named("inflow_gain", &[0.02]);
    assert_eq!(told(&record, vec![elsewhere]).named.len(), 1);
    let unknown = told(&record, Vec::new()).named;
    let found = told(&record, vec![unknown[0].clone(), gas()]).named;
    assert_eq!(found.len(), 2);
    assert!(
        found
            .iter()
            .any(|n| n.applied.effect.about().relation == Relation::PumpHead)
    );
}

#[test]
fn nothing_is_told_without_the_step() {
    let mut record = turning_to_and_fro(1.0);
    record.without = vec![Step::Remains];
    assert!(told(&record, Vec::new()).named.is_empty());
}
