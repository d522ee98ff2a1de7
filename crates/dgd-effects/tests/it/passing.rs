//! What sets in, in the form that ends.

use crate::{close, drive, moments, setting, usual};
use dgd_effects::{
    AppliedEffect, Changes, Effect, Extent, Role, catalogue, find, find_taking, unknown,
};
use std::collections::BTreeMap;

const ENDING: [&str; 5] = [
    "outlet_pressure_bias_step",
    "mud_density_change",
    "lost_circulation",
    "line_restriction",
    "line_leak",
];

fn ending(id: &str) -> &'static dyn Effect {
    find(id).unwrap().passing().unwrap()
}

#[test]
fn what_sets_in_and_stays_has_a_form_that_ends_and_nothing_else_has() {
    let having: Vec<&str> = (catalogue().iter())
        .filter(|effect| effect.passing().is_some())
        .map(|effect| effect.about().id)
        .collect();
    assert_eq!(having, ENDING);
    let setting_in = (catalogue().iter())
        .filter(|effect| effect.about().extent() == Extent::FromOnset)
        .map(|effect| effect.about().id);
    assert!(setting_in.eq(ENDING));
    assert!(unknown().passing().is_none());
}

#[test]
fn the_form_that_ends_is_the_same_effect_with_a_duration_behind() {
    for id in ENDING {
        let (stays, ends) = (find(id).unwrap().about(), ending(id).about());
        let own = stays.parameters.len();
        assert_eq!((ends.id, ends.relation), (id, stays.relation));
        assert_eq!(ends.search, stays.search);
        assert_eq!(&ends.parameters[..own], stays.parameters, "{id}");
        assert!(matches!(ends.parameters[own..], [p] if matches!(p.role, Role::Duration(_))));
        assert_ne!(ends.title, stays.title);
        assert_eq!(ends.extent(), Extent::Passing);
        let lasting = ending(id).lasting().unwrap();
        assert_eq!(lasting.about().parameters, stays.parameters);
        assert!(find(id).unwrap().lasting().is_none());
        // By the number of its parameters.
        assert!(find_taking(id, own).unwrap().lasting().is_none());
        assert!(find_taking(id, own + 1).unwrap().lasting().is_some());
        assert!(find_taking(id, own + 2).is_none());
    }
}

#[test]
fn until_its_end_it_does_what_the_effect_that_stays_does() {
    let (setting, moments) = (setting(), moments());
    for id in ENDING {
        let p = usual(ending(id).about());
        let (_, end) = ending(id).about().interval_s(&p, setting.span_s);
        let ends = drive(id, &p, &setting, &moments);
        let stays = drive(id, &p[..p.len() - 1], &setting, &moments);
        let until = moments.partition_point(|m| m.t_s < end);
        assert!(ends[..until] == stays[..until], "{id}");
        assert!(ends[until..] != stays[until..], "{id}");
        if ending(id).is_switch() {
            assert!(ends[until..].iter().all(|c| *c == Changes::default()));
        }
        let (from, to) = ending(id).acts_s(&p, setting.span_s);
        for (moment, changes) in moments.iter().zip(&ends) {
            let outside = moment.t_s < from || moment.t_s > to;
            assert!(!outside || *changes == Changes::default(), "{id}");
        }
    }
}

#[test]
fn mud_of_another_weight_mixes_out_as_it_has_mixed_in() {
    let (setting, moments) = (setting(), moments());
    let mut p = usual(ending("mud_density_change").about());
    let (onset, lasts) = (500.0, 3000.0);
    (p[1], p[4]) = (onset, lasts);
    let whole = drive("mud_density_change", &p, &setting, &moments);
    let at = |t: f64| whole[moments.partition_point(|m| m.t_s < t)].riser_kg_m3;
    assert!(at(onset + lasts) > 0.4 * p[0] && at(6000.0) < at(onset + lasts));
    // What had come in by then, less what has come in since.
    let alone = drive("mud_density_change", &p[..4], &setting, &moments);
    let later = {
        let mut late = p[..4].to_vec();
        late[1] = onset + lasts;
        drive("mud_density_change", &late, &setting, &moments)
    };
    for ((whole, alone), later) in whole.iter().zip(&alone).zip(&later) {
        let left = alone.riser_kg_m3 - later.riser_kg_m3;
        assert!((whole.riser_kg_m3 - left).abs() < 1e-9);
    }
}

#[test]
fn a_later_recording_knows_it_as_over_and_a_pressure_stays_that_pressure() {
    let mut model = crate::model(&[]);
    for id in ENDING {
        model.effects.push(AppliedEffect {
            id: id.to_owned(),
            parameters: usual(ending(id).about()),
        });
    }
    let over = model.clone().carry_over(&setting()).over;
    let mut sorted = ENDING.to_vec();
    sorted.sort_unstable();
    assert_eq!(over, sorted);

    let loss = ending("lost_circulation");
    let p = [1e-8, 100.0, 0.5, 900.0];
    let moved = loss.ranged(&p, (100e5, 200e5), (100e5, 300e5)).unwrap();
    let by_name: BTreeMap<&str, f64> = (loss.about().parameters.iter())
        .zip(&moved)
        .map(|(parameter, value)| (parameter.name, *value))
        .collect();
    close(by_name["fracture"], 0.25, 1e-12);
    close(by_name["duration_s"], 900.0, 1e-12);
}
