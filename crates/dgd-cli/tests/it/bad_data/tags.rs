//! Tags that are swapped.

use super::rig::{Rig, line_of};

#[test]
fn swapped_sides_of_the_pump_are_told() {
    Rig::sound().swapped("PT1", "PT3").fitted().suspects(
        line_of("PT1"),
        &[
            "pump_inlet_pressure `PT1` and pump_outlet_pressure `PT3`",
            "if their tags are swapped",
        ],
    );
    let both = Rig::sound().swapped("PT1", "PT3").swapped("PT2", "PT4");
    both.fit().refused(&[
        "the pressure falls by",
        "if their tags are swapped",
        "no pressure rise",
    ]);
}

#[test]
fn swapped_flows_are_told() {
    for (a, b) in [("FT1", "FT4"), ("FT2", "FT4")] {
        Rig::sound().swapped(a, b).fitted().suspects(
            line_of(&format!("\"{a}\"")),
            &[
                "of the flow pumped in",
                &format!("`{a}` and return_flow `FT4`"),
                "if their tags are swapped",
            ],
        );
    }
}

#[test]
fn swapped_speed_is_told() {
    for (other, line) in [("FT3", "FT3"), ("FT4", "FT4")] {
        Rig::sound().swapped("SPM", other).fitted().suspects(
            line_of(&format!("\"{line}\"")),
            &[
                &format!("`{other}` and pump_speed `SPM`"),
                "if their tags are swapped",
            ],
        );
    }
    let ran = Rig::sound().swapped("SPM", "PT1").fit();
    ran.refused(&[
        "`PT1` and pump_speed `SPM`",
        "if their tags are swapped",
        "out of range",
    ]);
}

#[test]
fn swapped_inflows_change_nothing() {
    Rig::sound()
        .swapped("FT1", "FT2")
        .fitted()
        .right(0.0)
        .suspects_nothing();
}

/// Whatever it then makes of such channels: the swap is told before, as a suspicion or beside the refusal.
#[test]
fn a_diagnosis_of_swapped_tags_tells_them() {
    for (a, b) in [("PT1", "PT3"), ("FT1", "FT4")] {
        let rig = Rig::first(3600).swapped(a, b);
        let told = [format!("`{a}`"), format!("`{b}`")];
        rig.diagnosed().suspects(
            line_of(&format!("\"{a}\"")),
            &[&told[0], &told[1], "if their tags are swapped"],
        );
    }
    let (bench, ran) = Rig::first(3600).swapped("SPM", "FT4").diagnose();
    ran.refused(&[
        "`FT4` and pump_speed `SPM`",
        "if their tags are swapped",
        "blocks of 10 s, a diagnosis needs 60 besides its held-out windows",
    ]);
    assert!(!bench.path("d").exists());
}

#[test]
fn a_diagnosis_of_swapped_inflows_names_the_late_meter_still() {
    let swapped = Rig::first(3600).swapped("FT1", "FT2").diagnosed();
    swapped.finds("return_flow_delay", "delay_s", 12.0, 0.5);
    assert_eq!(swapped.json["warnings"], serde_json::json!([]));
}
