//! What effects keep in mind, and when they act.

use crate::{drive, members, moments, setting, usual};
use dgd_effects::{Changes, Curve, Extent, KNOTS, Place, Quantity, catalogue, find};

#[test]
fn an_effect_changes_nothing_outside_its_interval_and_may_begin_at_its_onset() {
    let (setting, moments) = (setting(), moments());
    for effect in catalogue() {
        let about = effect.about();
        if about.extent() == Extent::Always {
            continue;
        }
        let p = usual(about);
        let (from, to) = about.interval_s(&p, setting.span_s);
        let whole = drive(about.id, &p, &setting, &moments);
        for (moment, changes) in moments.iter().zip(&whole) {
            if moment.t_s < from || moment.t_s > to {
                assert_eq!(
                    *changes,
                    Changes::default(),
                    "{} at {}",
                    about.id,
                    moment.t_s
                );
            }
        }
        let first = moments.partition_point(|m| m.t_s < from);
        let late = drive(about.id, &p, &setting, &moments[first..]);
        assert!(whole[first..] == late[..], "{}", about.id);
    }
}

#[test]
fn what_an_effect_saw_before_it_remembers_moves_it_by_rounding_alone() {
    const AT: usize = 5900;
    let (setting, moments) = (setting(), moments());
    let begins_anew = |id: &str, p: &[f64]| {
        let memory_s = find(id).unwrap().memory_s(p);
        if !memory_s.is_finite() {
            return;
        }
        let whole = drive(id, p, &setting, &moments);
        let start = moments.partition_point(|m| m.t_s < moments[AT].t_s - memory_s.ceil());
        let late = drive(id, p, &setting, &moments[start..]);
        for (whole, late) in whole[AT..].iter().zip(&late[AT - start..]) {
            for ((name, a, size), (_, b, _)) in members(whole).into_iter().zip(members(late)) {
                assert!(
                    (a - b).abs() <= 1e-13 * size.max(a.abs()),
                    "{id}, {name}: {a} {b}"
                );
            }
        }
    };
    for effect in catalogue() {
        let about = effect.about();
        begins_anew(about.id, &usual(about));
    }
    for quantity in [
        Quantity::ReturnFlow,
        Quantity::SinceStart,
        Quantity::FlowRate,
    ] {
        let curve = Curve::new(
            Place::Head,
            quantity,
            (0.0, 4.5),
            (0..KNOTS).map(|k| 1e4 * (k as f64).cos()).collect(),
        );
        begins_anew("unknown", &curve.parameters());
    }
}

#[test]
fn switches_remember_nothing_and_stores_of_mud_may_remember_everything() {
    for effect in catalogue() {
        let p = usual(effect.about());
        if effect.is_switch() {
            assert_eq!(effect.memory_s(&p), 0.0, "{}", effect.about().id);
        }
    }
    let density = find("mud_density_change").unwrap();
    assert!(density.memory_s(&usual(density.about())).is_infinite());
}
