//! The list itself: ids, parameters, what is said of them.

use crate::{SPAN_S, drive, members, moments, setting, usual};
use dgd_effects::{
    Changes, Extent, KNOTS, MeterPath, Method, Relation, Role, Search, Setting, Shown, Timing,
    catalogue, find, told_apart_by, unknown,
};
use std::collections::BTreeSet;

/// Ids with the parameter that carries the strength, or names the effect's size, as they stand in written diagnoses.
const CONTRACT: [(&str, &str); 24] = [
    ("return_flow_delay", "delay_s"),
    ("return_flow_gain", "gain"),
    ("inflow_gain", "gain"),
    ("outlet_pressure_bias", "bias_pa"),
    ("outlet_pressure_bias_step", "bias_pa"),
    ("mud_density_change", "delta_rho_kg_m3"),
    ("cuttings_loading", "delta_rho_kg_m3"),
    ("yield_stress", "drop_pa"),
    ("gel_strength", "tau_gel_pa"),
    ("line_drainage", "rate_m_s"),
    ("pump_wear", "leak_m3_s"),
    ("gas_in_pump", "head_loss_fraction"),
    ("pump_speed_lag", "tau_s"),
    ("influx", "rate_m3_s"),
    ("lost_circulation", "J_m3_s_pa"),
    ("u_tube", "tau_s"),
    ("booster_line_storage", "tau_s"),
    ("annulus_area", "area_m2"),
    ("pipe_displacement", "volume_m3"),
    ("heave", "period_s"),
    ("viscosity_drift", "relative_mu_change"),
    ("line_restriction", "K"),
    ("line_leak", "leak_m3_s"),
    ("line_gas_storage", "tau_s"),
];

#[test]
fn ids_and_first_parameters_are_those_of_written_diagnoses() {
    let listed: Vec<(&str, &str)> = catalogue()
        .iter()
        .map(|e| (e.about().id, e.about().parameters[0].name))
        .collect();
    assert_eq!(listed, CONTRACT);
    let ids: BTreeSet<&str> = listed.iter().map(|(id, _)| *id).collect();
    assert_eq!(ids.len(), CONTRACT.len());
    let sensor = find("outlet_pressure_bias_step").unwrap().about();
    assert_eq!(sensor.sensor(), sensor.position("sensor"));
    assert!(sensor.sensor().is_some());
}

#[test]
fn every_id_is_found_and_the_correction_by_its_own() {
    for effect in catalogue() {
        let id = effect.about().id;
        assert_eq!(find(id).unwrap().about().id, id);
    }
    assert_eq!(find("unknown").unwrap().about(), unknown().about());
    assert!(find("").is_none() && find("Influx").is_none());
}

#[test]
fn descriptions_are_whole() {
    for effect in catalogue() {
        let about = effect.about();
        for text in [about.title, about.equation, about.source, about.excited_by] {
            assert!(!text.trim().is_empty(), "{}", about.id);
        }
        let names: BTreeSet<&str> = about.parameters.iter().map(|p| p.name).collect();
        assert_eq!(names.len(), about.parameters.len(), "{}", about.id);
        for p in about.parameters {
            assert!(!p.name.is_empty() && !p.meaning.is_empty(), "{}", about.id);
            assert!(p.low < p.high, "{} {}", about.id, p.name);
            assert!(
                (p.low..=p.high).contains(&p.usual),
                "{} {}",
                about.id,
                p.name
            );
            if let Role::Grid(values)
            | Role::Shape(values)
            | Role::Choice(values)
            | Role::Sensor(values) = p.role
            {
                assert!(values.is_sorted(), "{} {}", about.id, p.name);
                assert!(
                    values.iter().all(|v| (p.low..=p.high).contains(v)),
                    "{} {}",
                    about.id,
                    p.name
                );
            }
        }
        for (other, test) in about.confusable {
            assert!(
                find(other).is_some() && *other != about.id,
                "{}: {other}",
                about.id
            );
            assert!(!test.is_empty());
        }
    }
}

#[test]
fn what_is_allowed_for_is_too_small_to_be_named() {
    let mut some = 0;
    for effect in catalogue() {
        let (about, search) = (effect.about(), effect.about().search);
        let least = search.least.unwrap_or(f64::INFINITY);
        for strength in search.allowance {
            // A clock of its own may make a time early as well, which nothing in the catalogue does.
            let early = *strength < 0.0 && *strength >= -5.0 && search.timing.is_some();
            assert!(
                early || (*strength > 0.0 && *strength <= least),
                "{} {strength}",
                about.id
            );
            // What is allowed for is always there, as it usually is.
            assert!(
                about.onset().is_none() && about.sensor().is_none(),
                "{}",
                about.id
            );
            some += 1;
        }
    }
    assert!(some > 0);
}

#[test]
fn what_makes_the_meter_late_is_what_stands_between_it_and_the_line() {
    for effect in catalogue() {
        let about = effect.about();
        let path = effect.meter_path(&usual(about)) != MeterPath::default();
        let timing = about.search.timing;
        assert_eq!(path, timing == Some(Timing::Meter), "{}", about.id);
        let Role::Grid(_) = about.parameters[0].role else {
            assert_eq!(timing, None, "{}", about.id);
            continue;
        };
        if timing == Some(Timing::Meter) {
            let shapes = about.parameters[1..].iter();
            let mut shapes = shapes.map(|p| matches!(p.role, Role::Shape(_)));
            assert!(shapes.all(|shape| shape), "{}", about.id);
        }
        // What is tried on a grid and bends a curve must have the curves fitted again.
        let bends = about.relation != Relation::RiserMassBalance;
        let sought = about.search.method == Method::Relations;
        assert_eq!(timing.is_some(), bends && sought, "{}", about.id);
    }
}

#[test]
fn the_correction_alone_stands_against_all_others() {
    for effect in catalogue().iter().copied().chain([unknown()]) {
        let about = effect.about();
        assert_eq!(
            about.search.method == Method::Correction,
            about.id == "unknown"
        );
    }
    assert_eq!(unknown().about().search.belief, Search::BASE.belief);
}

#[test]
fn gains_and_areas_are_shown_whole() {
    let setting = setting();
    let shown = |id: &str, carried: f64| {
        let (offset, factor) = find(id).unwrap().about().parameters[0]
            .shown
            .scale(&setting);
        offset + factor * carried
    };
    assert_eq!(shown("return_flow_gain", 0.03), 1.03);
    assert_eq!(shown("inflow_gain", -0.03), 0.97);
    assert_eq!(shown("annulus_area", 0.5), 1.5 * setting.riser_area_m2);
    assert_eq!(shown("influx", 1e-3), 1e-3);
    for effect in catalogue() {
        let about = effect.about();
        // Whole is only what is carried as an excess: at its strength of 0 it is no zero.
        for p in &about.parameters[1..] {
            assert_eq!(p.shown, Shown::AsCarried, "{} {}", about.id, p.name);
        }
    }
}

#[test]
fn an_effect_without_strength_changes_nothing() {
    let (setting, moments) = (setting(), moments());
    for effect in catalogue() {
        let about = effect.about();
        let mut p = usual(about);
        p[0] = match about.parameters[0].role {
            Role::Amplitude => 0.0,
            _ => 1e-12,
        };
        let proportional = about.parameters[0].role == Role::Amplitude;
        for (i, c) in drive(about.id, &p, &setting, &moments).iter().enumerate() {
            for ((name, found, size), (_, none, _)) in
                members(c).iter().zip(members(&Changes::default()))
            {
                let allowed = if proportional { 0.0 } else { 1e-9 * size };
                assert!(
                    (found - none).abs() <= allowed,
                    "{} {name} at {i}: {found}",
                    about.id
                );
            }
        }
        p[0] = 0.0;
        assert_eq!(effect.meter_path(&p), MeterPath::default(), "{}", about.id);
    }
    let none = vec![0.0; 4 + KNOTS];
    assert!(
        drive("unknown", &none, &setting, &moments)
            .iter()
            .all(|c| *c == Changes::default())
    );
}

#[test]
fn every_effect_but_heave_changes_something_when_it_has_strength() {
    let (setting, moments) = (setting(), moments());
    for effect in catalogue() {
        let about = effect.about();
        let p = usual(about);
        let changed = drive(about.id, &p, &setting, &moments)
            .iter()
            .any(|c| *c != Changes::default());
        let seen = changed || effect.meter_path(&p) != MeterPath::default();
        assert_eq!(seen, about.id != "heave", "{}", about.id);
    }
}

#[test]
fn nothing_changes_outside_the_interval_of_an_effect() {
    let (setting, moments) = (setting(), moments());
    for effect in catalogue() {
        let about = effect.about();
        let p = usual(about);
        let (from, to) = about.interval_s(&p, setting.span_s);
        let expected = match about.extent() {
            Extent::Always => (0.0, SPAN_S),
            Extent::FromOnset => (1500.0, SPAN_S),
            Extent::Passing => (1500.0, 3500.0),
        };
        assert_eq!((from, to), expected, "{}", about.id);
        let changes = drive(about.id, &p, &setting, &moments);
        for (m, c) in moments.iter().zip(&changes) {
            if m.t_s < from || m.t_s > to {
                assert_eq!(*c, Changes::default(), "{} at {}", about.id, m.t_s);
            }
        }
    }
}

#[test]
fn an_offset_is_told_as_the_description_that_would_show_it() {
    let s = setting();
    let bias = find("outlet_pressure_bias").unwrap();
    let told = |pa: f64, s: &Setting| bias.same_as(&[pa], s);
    // The weight of a line of mud that is heavier by 20 kg/m³.
    let weight = 20.0 * 9.80665 * s.line_length_m;
    let heavier = told(weight, &s).unwrap();
    let described = s.density_kg_m3;
    let mud = format!(
        "mud of {:.0} kg/m3 in the line, described as {described:.0};",
        described + 20.0
    );
    assert!(heavier.starts_with(&mud), "{heavier}");
    let longer = 20.0 * s.line_length_m / described;
    assert!(
        heavier.contains(&format!("or {longer:.1} m more of the mud")),
        "{heavier}"
    );
    assert!(
        told(-weight, &s)
            .unwrap()
            .contains(&format!("{longer:.1} m less"))
    );
    // No mud is lighter than nothing.
    let lighter = told(-2.0 * weight * described / 20.0, &s).unwrap();
    let shorter = format!("{:.1} m less of the mud", 2.0 * s.line_length_m);
    assert!(lighter.starts_with(&shorter), "{lighter}");
    // An atmosphere is one, within a tenth.
    for (pa, begins) in [
        (
            -101_325.0,
            "gauge outlet transmitters described as absolute; or mud",
        ),
        (
            95_000.0,
            "absolute outlet transmitters described as gauge; or mud",
        ),
        (85_000.0, "mud"),
        (-115_000.0, "mud"),
    ] {
        assert!(told(pa, &s).unwrap().starts_with(begins), "{pa}");
    }
    let bare = Setting {
        line_length_m: 0.0,
        ..s.clone()
    };
    assert_eq!(told(1e4, &bare), None);
    assert_eq!(find("yield_stress").unwrap().same_as(&[1.0; 2], &s), None);
    // Less area, or a heavier mud: the pressure rises as much for as much mud.
    let area = |off: f64| find("annulus_area").unwrap().same_as(&[off], &s);
    let mud = format!(
        "mud of {:.0} kg/m3 in the riser, described as {described:.0}",
        described / 0.98
    );
    assert_eq!(area(-0.02), Some(mud));
    assert!(area(-0.1).is_some());
    assert_eq!(area(0.21), None);
}

#[test]
fn an_interval_stays_within_the_recording() {
    let influx = find("influx").unwrap().about();
    assert_eq!(
        influx.interval_s(&[1e-3, -50.0, 100.0, 0.1], (0.0, 40.0)),
        (0.0, 40.0)
    );
    assert_eq!(
        influx.interval_s(&[1e-3, 10.0, 20.0, 0.1], (0.0, 40.0)),
        (10.0, 30.0)
    );
    // It lasts from when it began, not from where the recording does.
    assert_eq!(
        influx.interval_s(&[1e-3, -50.0, 70.0, 0.1], (0.0, 40.0)),
        (0.0, 20.0)
    );
    assert_eq!(
        influx.interval_s(&[1e-3, -50.0, 20.0, 0.1], (0.0, 40.0)),
        (0.0, 0.0)
    );
}

#[test]
fn names_of_relations_are_those_of_written_diagnoses() {
    let names = [
        (Relation::ReturnLineFriction, "return_line_friction"),
        (Relation::PumpHead, "pump_head"),
        (Relation::RiserMassBalance, "riser_mass_balance"),
        (Relation::Momentum, "momentum"),
        (Relation::Instrument, "instrument"),
    ];
    for (relation, name) in names {
        assert_eq!(relation.name(), name);
    }
}

#[test]
fn a_switch_depends_on_the_moment_alone() {
    let (setting, moments) = (setting(), moments());
    for effect in catalogue().iter().filter(|e| e.is_switch()) {
        let about = effect.about();
        let p = usual(about);
        let whole = drive(about.id, &p, &setting, &moments);
        // Started late it does what it would have done anyway.
        let late = drive(about.id, &p, &setting, &moments[2500..]);
        assert_eq!(whole[2500..], late[..], "{}", about.id);
    }
}

/// Pairs whose forms are alike.
#[test]
fn what_is_taken_for_each_other_has_a_test_whichever_of_the_two_was_named() {
    for (one, other) in [
        ("return_flow_delay", "line_gas_storage"),
        ("inflow_gain", "return_flow_gain"),
        ("inflow_gain", "lost_circulation"),
        ("inflow_gain", "line_leak"),
        ("cuttings_loading", "outlet_pressure_bias"),
        ("line_restriction", "viscosity_drift"),
        ("line_restriction", "mud_density_change"),
        ("lost_circulation", "return_flow_gain"),
        ("lost_circulation", "line_leak"),
        ("lost_circulation", "influx"),
        ("mud_density_change", "outlet_pressure_bias_step"),
        ("outlet_pressure_bias", "yield_stress"),
        ("annulus_area", "u_tube"),
        ("annulus_area", "booster_line_storage"),
        ("annulus_area", "unknown"),
    ] {
        let ways = [(one, other), (other, one)];
        for (a, b) in ways {
            assert!(told_apart_by(a, b).is_some(), "{a} {b}");
        }
    }
    assert_eq!(told_apart_by("heave", "influx"), None);
    assert_eq!(told_apart_by("unknown", "unknown"), None);
    assert_eq!(told_apart_by("unknown", "nothing"), None);
}

#[test]
fn another_cause_is_listed_once_and_where_it_does_not_list_back_the_same_test_is_told_from_its_side()
 {
    for effect in catalogue() {
        let about = effect.about();
        for (k, (other, test)) in about.confusable.iter().enumerate() {
            let again = about.confusable[..k].iter().any(|(id, _)| id == other);
            assert!(!again, "{}: {other}", about.id);
            let others = find(other).unwrap().about().confusable;
            if !others.iter().any(|(id, _)| *id == about.id) {
                assert_eq!(told_apart_by(other, about.id), Some(*test));
            }
            assert!(!test.ends_with('.') && *test == test.trim(), "{test}");
        }
    }
}

#[test]
fn the_readme_has_a_row_for_every_effect() {
    let readme = include_str!("../../README.md");
    let quoted = |names: Vec<&str>| match names.as_slice() {
        [] => "-".to_owned(),
        names => format!("`{}`", names.join("`, `")),
    };
    for effect in catalogue() {
        let about = effect.about();
        let row = format!(
            "| `{}` | {} | {} | `{}` | {} | {} | {} |",
            about.id,
            format!("{:?}", about.component).to_lowercase(),
            about.relation.name().replace('_', " "),
            about.equation,
            quoted(about.parameters.iter().map(|p| p.name).collect()),
            about.excited_by,
            quoted(about.confusable.iter().map(|c| c.0).collect()),
        );
        assert!(readme.contains(&row), "the README lacks\n{row}");
    }
}

#[test]
fn what_comes_upon_flowing_mud_does_nothing_at_rest() {
    let rest = |changes: &[Changes]| changes[3150..3290].to_vec();
    for effect in catalogue().iter().filter(|e| e.about().search.flowing) {
        let about = effect.about();
        let changes = drive(about.id, &usual(about), &setting(), &moments());
        for c in rest(&changes) {
            let standing = Changes {
                // A factor on the friction of no flow, and a leak of it, are nothing.
                friction_factor: 1.0,
                leak_m3_s: 0.0,
                ..c
            };
            assert_eq!(standing, Changes::default(), "{}", about.id);
        }
    }
}

#[test]
fn an_influx_that_no_well_gives_is_told_as_a_pump() {
    let told = |rate: f64| {
        let influx = find("influx").unwrap();
        influx.same_as(&[rate, 0.0, 2400.0, 0.05], &setting())
    };
    assert_eq!(told(0.004), None);
    assert!(told(0.028).unwrap().starts_with("a pump of 1680 L/min"));
}

#[test]
fn a_store_and_a_leak_before_the_meter_say_what_the_meter_alone_would_show() {
    let told = |id: &str, parameters: &[f64]| find(id).unwrap().same_as(parameters, &setting());
    let store = told("line_gas_storage", &[12.4, 0.0]).unwrap();
    assert!(store.contains("damps it by 12 s"), "{store}");
    let leak = told("line_leak", &[1e-3, 600.0]).unwrap();
    assert!(leak.contains("reads less in that time"), "{leak}");
}

#[test]
fn a_gain_is_told_as_the_liner_or_the_gallon_that_would_show_it() {
    let s = setting();
    let told = |id: &str, gain: f64| find(id).unwrap().same_as(&[gain - 1.0], &s);
    // 6.5 inches for 6.
    let liner = told("inflow_gain", (6.5_f64 / 6.0).powi(2)).unwrap();
    assert_eq!(
        liner,
        "strokes counted for liners 8.3 % wider than those in the pump"
    );
    let narrow = told("inflow_gain", (6.0_f64 / 6.5).powi(2)).unwrap();
    assert!(narrow.contains("7.7 % narrower"), "{narrow}");
    // An efficiency.
    assert_eq!(told("inflow_gain", 1.05), None);
    let litres = [3.785_411_784, 4.546_09];
    for (gain, is) in [
        (litres[0] / litres[1], "a flow in imperial gallons"),
        (litres[1] / litres[0], "a flow in US gallons"),
    ] {
        assert!(
            told("return_flow_gain", gain).unwrap().starts_with(is),
            "{gain}"
        );
        let inflow = told("inflow_gain", gain).unwrap();
        assert!(inflow.contains(&format!("; or {is}")), "{inflow}");
    }
    assert_eq!(told("return_flow_gain", 1.17), None);
    assert_eq!(told("return_flow_gain", 0.86), None);
}

#[test]
fn cuttings_that_never_wash_out_are_a_heavier_mud() {
    let s = setting();
    let cuttings = find("cuttings_loading").unwrap();
    let told =
        |drilled: f64, begun: f64| cuttings.same_as(&[50.0, drilled, 0.3, 0.0, begun, 0.02], &s);
    let heavier = format!("mud of {:.0} kg/m3", s.density_kg_m3 + 50.0);
    assert!(told(1.0, 1.0).unwrap().starts_with(&heavier));
    assert_eq!(told(0.82, 1.0), None);
    assert_eq!(told(1.0, 0.0), None);
}
