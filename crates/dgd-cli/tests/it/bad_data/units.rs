//! Units that are not those of the recording.

use super::rig::{Rig, line_of};

#[test]
fn one_pressure_in_another_unit_is_told_with_the_unit_that_fits() {
    for (tag, wrong) in [("PT1", "kPa"), ("PT3", "bar"), ("PT5", "bar")] {
        let told = format!("\"{tag}\", unit = \"psia\"");
        let rig = Rig::sound().saying(&told, &format!("\"{tag}\", unit = \"{wrong}\""));
        rig.fitted().suspects(
            line_of(&format!("\"{tag}\"")),
            &["read as", wrong, "as psia", &format!("`{tag}` would be")],
        );
    }
    let ran = Rig::sound()
        .saying("\"PT1\", unit = \"psia\"", "\"PT1\", unit = \"bar\"")
        .fit();
    ran.refused(&[
        "as psia pump_inlet_pressure `PT1` would be 26.4 bar",
        "no pressure rise",
    ]);
}

#[test]
fn all_pressures_in_another_unit_are_told_at_once() {
    for wrong in ["bar", "kPa"] {
        let rig = Rig::sound().saying("psia", wrong);
        rig.fitted().suspects(
            line_of("PT1"),
            &[
                &format!("is read as {wrong}"),
                "as psia all pressures would be 26.4 bar",
            ],
        );
    }
}

/// Whatever it then makes of such pressures: the unit is told before.
#[test]
fn a_diagnosis_of_psi_taken_for_bar_tells_the_unit_that_fits() {
    for (found, instead, line, told) in [
        (
            "\"PT1\", unit = \"psia\"",
            "\"PT1\", unit = \"bar\"",
            "\"PT1\"",
            "as psia pump_inlet_pressure `PT1` would be",
        ),
        (
            "\"PT3\", unit = \"psia\"",
            "\"PT3\", unit = \"bar\"",
            "\"PT3\"",
            "as psia pump_outlet_pressure `PT3` would be",
        ),
        ("psia", "bar", "\"PT1\"", "as psia all pressures would be"),
    ] {
        let rig = Rig::first(3600).saying(found, instead);
        rig.diagnosed().suspects(line_of(line), &[told]);
    }
}

#[test]
fn a_gauge_reading_among_absolute_ones_is_told() {
    let rig = Rig::sound().saying("\"PT1\", unit = \"psia\"", "\"PT1\", unit = \"psig\"");
    rig.fitted().suspects(
        line_of("PT1"),
        &[
            "differ by one atmosphere",
            "both must be gauge or both absolute",
        ],
    );
}

#[test]
fn all_pressures_gauge_for_absolute_move_the_offset_alone() {
    let read = Rig::sound().saying("psia", "psig").fitted();
    read.suspects_nothing();
    let (offset, sound) = (read.friction_pa(), Rig::sound().fitted().friction_pa());
    assert!(
        (offset - sound - 101_325.0).abs() < 10.0,
        "{offset} {sound}"
    );
}

/// Beside the influx that is concealed in it.
#[test]
fn a_density_that_is_a_little_off_is_told_beside_the_offset_that_it_makes() {
    const MUD: f64 = 1210.0;
    assert_eq!(Rig::of_hours().diagnosed().same_as(), []);
    for described in [1186.0, 1234.0] {
        let density = format!("{:.3} sg", 1e-3 * described);
        let found = Rig::of_hours().saying("1.210 sg", &density).diagnosed();
        assert!(found.claimed().contains(&"influx"));
        let told = found.same_as();
        let (mud, rest) = (told[0].1.strip_prefix("mud of ").unwrap())
            .split_once(" kg/m3 in the line, described as ")
            .unwrap();
        let off = mud.parse::<f64>().unwrap() / MUD - 1.0;
        assert!(off.abs() < 5e-3, "{mud}");
        assert!(rest.starts_with(&format!("{described:.0};")), "{rest}");
    }
}

/// Beside the influx: whichever way a density or a depth is off, no cause is made up of it without a word.
#[test]
fn a_density_or_a_depth_far_off_is_asked_about_before_anything_else_is_believed() {
    for (found, instead, asks) in [
        (
            "1.210 sg",
            "1.089 sg",
            &["is the mud's density right?", "the description says 1089"][..],
        ),
        (
            "pump_outlet_depth = \"313.50 m\"",
            "pump_outlet_depth = \"373.50 m\"",
            &[
                "is the description right?",
                "too little throughout",
                "m less of the mud",
            ],
        ),
    ] {
        let told = Rig::of_hours().saying(found, instead).diagnosed();
        let warned = told.json["warnings"].to_string();
        assert!(asks.iter().all(|words| warned.contains(words)), "{warned}");
        assert!(told.claimed().contains(&"influx"), "{:?}", told.claimed());
        let made_up = ["cuttings_loading", "yield_stress", "unknown"];
        assert!(
            told.claimed().iter().all(|id| !made_up.contains(id)),
            "{:?}",
            told.claimed()
        );
    }
    assert_eq!(
        Rig::of_hours().diagnosed().json["warnings"],
        serde_json::json!([])
    );
}

/// Beside the influx, too.
#[test]
fn a_flow_in_gallons_of_the_other_kind_is_a_gain_that_is_told_as_such() {
    for (tag, effect, told) in [
        ("FT4", "return_flow_gain", "a flow in US gallons (gpm)"),
        (
            "FT1",
            "inflow_gain",
            "liners 9.6 % wider than those in the pump; or a flow in US gallons (gpm)",
        ),
    ] {
        let unit = |unit: &str| format!("\"{tag}\", unit = \"{unit}\"");
        let rig = Rig::of_hours().saying(&unit("gpm"), &unit("impgpm"));
        let found = rig.diagnosed();
        assert_eq!(found.claimed(), [effect, "influx"]);
        found.finds(effect, "gain", 1.200_95, 5e-3);
        let same_as = found.same_as();
        assert_eq!(same_as[0].0, effect);
        assert!(same_as[0].1.contains(told), "{same_as:?}");
    }
}

#[test]
fn flows_in_another_unit_are_told() {
    for wrong in ["l/min", "m3/h", "l/s", "bbl/min"] {
        let rig = Rig::sound().saying(
            "\"FT4\", unit = \"gpm\"",
            &format!("\"FT4\", unit = \"{wrong}\""),
        );
        rig.fitted().suspects(
            line_of("\"FT4\""),
            &[
                "of the flow pumped in",
                wrong,
                "as gpm return_flow `FT4` would be 3,105 L/min",
            ],
        );
    }
    for wrong in ["l/min", "m3/h", "l/s"] {
        let rig = Rig::sound().saying("\"gpm\"", &format!("\"{wrong}\""));
        rig.fitted().suspects(
            line_of("\"FT1\""),
            &["as gpm all flows would be 2,132 L/min"],
        );
    }
}

#[test]
fn a_speed_that_is_no_percentage_is_told() {
    let share = Rig::sound().each(&["SPM"], |_, w| w / 100.0).fitted();
    share.suspects(
        line_of("SPM"),
        &["it reaches 0.58", "as a share of 1 it would reach 58"],
    );
    let rpm = Rig::sound().each(&["SPM"], |_, w| 18.0 * w).fit();
    rpm.refused(&["it reaches 1,060 %", "out of range"]);
}

#[test]
fn a_speed_in_rpm_beside_its_full_speed_is_right() {
    let rpm = Rig::sound()
        .each(&["SPM"], |_, w| 18.0 * w)
        .saying("unit = \"%\"", "unit = \"rpm\", full = \"1800 rpm\"");
    rpm.fitted().right(0.0).suspects_nothing();
    let open = Rig::sound().saying("unit = \"%\"", "unit = \"rpm\"");
    open.fit()
        .refused(&["with the full speed", "full = \"1800 rpm\""]);
}

#[test]
fn lengths_and_density_in_another_unit_are_told() {
    let feet = Rig::sound()
        .saying("350.30 m", "350.30 ft")
        .saying("352.10 m", "352.10 ft");
    feet.fitted().suspects(
        line_of("pump_inlet_depth"),
        &["it would fit a pump at 350 m", "metres written as ft"],
    );
    let metres = Rig::sound()
        .saying("350.30 m", "1149.3 m")
        .saying("352.10 m", "1155.2 m");
    metres.fitted().suspects(
        line_of("pump_inlet_depth"),
        &["it would fit a pump at 350 m"],
    );
    let ppg = Rig::sound().saying("1.080 sg", "1.080 ppg");
    ppg.fitted().suspects(
        line_of("density"),
        &[
            "mud of 129 kg/m3 is not a drilling mud",
            "mud of 1,080 kg/m3",
        ],
    );
    // Within what mud may be off by; but the line would have to push.
    let pounds = Rig::sound().saying("1.080 sg", "10.80 ppg").fitted();
    pounds.warns("is the density too high");
    // The other way, by as much.
    let light = Rig::sound().saying("1.080 sg", "0.990 sg").fitted();
    light.warns("is the density too low");
    let line = Rig::sound().saying("6.000 in", "6.000 cm");
    line.fitted().suspects(
        line_of("return_line_id"),
        &["friction factor", "a return line of 0.152 m"],
    );
    let riser = Rig::sound().saying("19.5 in", "19.5 cm");
    riser.fitted().suspects(
        line_of("riser_id"),
        &["the riser level moves", "a riser of 0.495 m"],
    );
}
