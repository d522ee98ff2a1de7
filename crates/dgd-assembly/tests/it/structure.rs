//! What is told about systems that are not well posed.

use dgd_assembly::{Assembly, AssemblyError};

fn problems(text: &str) -> String {
    match Assembly::parse(text) {
        Err(error @ AssemblyError::IllPosed(_)) => error.to_string(),
        other => format!("{other:?}"),
    }
}

const HEAD: &str = r#"
[components]
tank = { kind = "tank", area = 1.0 }
valve = { kind = "valve", flow_coefficient = 1e-3 }
gauge = { kind = "instrument", measures = "level", of = "tank" }
[initial]
"tank.level" = 2.0
"#;

#[test]
fn a_loose_end_is_named_with_its_mend() {
    let found = problems(&format!("connections = [\"tank -> valve\"]{HEAD}"));
    assert!(
        found.contains("valve.outlet: leads nowhere") && found.contains("atmosphere"),
        "{found}"
    );
}

#[test]
fn two_pumps_in_series_are_an_equation_in_excess() {
    let text = r#"connections = ["atmosphere -> a -> b -> atmosphere"]
[components]
a = { kind = "displacement_pump", input = 1.0 }
b = { kind = "displacement_pump", input = 1.0 }
"#;
    let found = problems(text);
    assert!(
        found.contains("too many equations: law of a, law of b, mass balance at a.outlet/b.inlet"),
        "{found}"
    );
    assert!(found.contains("pressure at a.outlet/b.inlet"), "{found}");
}

#[test]
fn a_closed_loop_without_pressure_hangs_on_nothing() {
    let text = r#"connections = ["pump -> line -> pump"]
[components]
pump = { kind = "centrifugal_pump", speed = 1.0, c0 = 1.0, c2 = 1.0 }
line = { kind = "line", quadratic = 1.0 }
"#;
    assert!(
        problems(text).contains("no pressure is defined"),
        "{}",
        problems(text)
    );
}

#[test]
fn two_tanks_with_nothing_between_are_refused() {
    let text = format!(
        "connections = [\"tank -> valve -> atmosphere\", \"other.outlet -> tank.outlet\"]{HEAD}\"other.level\" = 1.0\n[components.other]\nkind = \"tank\"\narea = 1.0\n"
    );
    assert!(
        problems(&text).contains("joined with nothing between"),
        "{}",
        problems(&text)
    );
}

#[test]
fn three_heavy_lines_at_a_junction_are_a_balance_in_excess() {
    let text = r#"connections = ["atmosphere -> a -> j", "j -> b -> atmosphere", "j -> c -> atmosphere"]
[components]
j = { kind = "junction" }
a = { kind = "line", length = 10.0, bore = 0.1, inertia = true }
b = { kind = "line", length = 10.0, bore = 0.1, inertia = true }
c = { kind = "line", length = 10.0, bore = 0.1, inertia = true }
"#;
    assert!(
        problems(text).contains("j: mass balance in excess"),
        "{}",
        problems(text)
    );
}

#[test]
fn a_share_is_written_in_per_cent_or_as_it_is_and_in_no_other_unit() {
    let text = |valve: &str, unit: &str| {
        format!(
            r#"connections = ["atmosphere -> valve -> tank"]
[components]
tank = {{ kind = "tank", area = 1.0 }}
valve = {{ kind = "valve", flow_coefficient = 1e-5{valve} }}
[initial]
"tank.level" = 1.0
[inputs]
{unit}
"#
        )
    };
    let driven = |unit: &str| {
        let input = format!(r#""valve.opening" = {{ channel = "z", unit = "{unit}" }}"#);
        text("", &input)
    };
    let held = |value: &str| text(&format!(r#", opening = "{value}""#), "");
    for (unit, value) in [("%", 80.0), ("1", 0.8)] {
        let read = Assembly::parse(&driven(unit)).unwrap();
        let unit = read.input_unit("valve.opening").unwrap();
        assert_eq!(unit.to_si(value), 0.8);
    }
    assert!(Assembly::parse(&held("80 %")).is_ok());
    let found = problems(&held("80"));
    assert!(
        found.contains("valve.opening: is 80, expected 0 to 1"),
        "{found}"
    );
    for wrong in ["degC", "psi"] {
        for text in [driven(wrong), held(&format!("80 {wrong}"))] {
            let found = problems(&text);
            assert!(
                found.contains(&format!("valve.opening: `{wrong}` is a unit of")),
                "{found}"
            );
        }
    }
}

#[test]
fn each_mistake_in_a_document_is_told_with_its_line() {
    let text = r#"connections = ["tank -> valve -> atmosphre"]
[components]
tank = { kind = "tank", are = 1.0 }
valve = { kind = "valve" }
[inputs]
"valve.opening" = { channel = "" }
[free]
"valve.colour" = { start = 0.0, low = 1.0, high = 2.0 }
"#;
    let found = problems(text);
    for expected in [
        "line 1: connections[0]: there is no component `atmosphre`",
        "line 3: tank.are: is not a property here",
        "line 3: tank.area: has no value",
        "line 4: valve: has no flow law, or several",
        "line 6: valve.opening: is an input without a channel",
        "line 8: valve.colour: in [free] is not a property",
    ] {
        assert!(found.contains(expected), "`{expected}` is not in:\n{found}");
    }
}

#[test]
fn an_unknown_key_and_bad_toml_are_told_with_line_and_column() {
    for text in [
        "connections = []\ncolour = 1\n[components]\n",
        "connections = [\n",
        "connections = []\n[components]\nx = { kind = \"pipe\" }\n",
    ] {
        let error = Assembly::parse(text).unwrap_err();
        assert!(
            matches!(error, AssemblyError::Syntax { line: 1..=3, .. }),
            "{error}"
        );
    }
}

#[test]
fn free_parameters_and_inputs_that_reach_no_output_are_warned_of() {
    let text = r#"connections = ["atmosphere -> pump -> upper -> hole -> lower -> drain -> atmosphere"]
[components]
pump = { kind = "displacement_pump" }
upper = { kind = "tank", area = 1.0 }
lower = { kind = "tank", area = 1.0 }
hole = { kind = "valve", flow_coefficient = 1e-3 }
drain = { kind = "valve" }
gauge = { kind = "instrument", measures = "level", of = "upper" }
[inputs]
"pump.input" = { channel = "u" }
[initial]
"upper.level" = 1.0
"lower.level" = 1.0
[free]
"drain.flow_coefficient" = { start = 1e-3, low = 1e-4, high = 1e-2 }
"hole.flow_coefficient" = { start = 1e-3, low = 1e-4, high = 1e-2 }
"#;
    let assembly = Assembly::parse(text).unwrap();
    let paths: Vec<String> = assembly.warnings().into_iter().map(|w| w.path).collect();
    assert_eq!(paths, ["drain.flow_coefficient"]);
}

#[test]
fn instruments_that_measure_nothing_or_nonsense_are_refused() {
    let head = HEAD.replace("measures = \"level\", of = \"tank\"", "OF");
    let text = format!("connections = [\"tank -> valve -> atmosphere\"]{head}");
    for (of, expected) in [
        ("channel = \"y\"", "gauge: measures nothing"),
        (
            "measures = \"level\", of = \"valve\"",
            "`level` of `valve` is not measurable",
        ),
        (
            "measures = \"flow\", of = \"vlave\"",
            "there is no component `vlave`",
        ),
        (
            "measures = \"level\", of = \"tank\", unit = \"furlong\"",
            "furlong",
        ),
    ] {
        let found = problems(&text.replace("OF", of));
        assert!(found.contains(expected), "`{expected}` is not in:\n{found}");
    }
}

#[test]
fn starts_that_are_missing_or_of_no_state_are_told() {
    let text = format!("connections = [\"tank -> valve -> atmosphere\"]{HEAD}");
    let found = problems(&text.replace("\"tank.level\" = 2.0", "\"tank.height\" = 2.0"));
    assert!(
        found.contains("tank.height: in [initial] is not a state (states: tank.level"),
        "{found}"
    );
    let unmeasured = text
        .replace("\"tank.level\" = 2.0", "")
        .replace("\"level\", of = \"tank\"", "\"flow\", of = \"valve\"");
    assert!(
        problems(&unmeasured).contains("tank.level: has no start"),
        "{}",
        problems(&unmeasured)
    );
}

#[test]
fn a_start_is_measured_by_an_instrument_of_its_own_dimension() {
    let text = format!("connections = [\"tank -> valve -> atmosphere\"]{HEAD}").replace(
        "\"tank.level\" = 2.0",
        "\"tank.level\" = { measured = \"gauge\" }",
    );
    assert!(Assembly::parse(&text).is_ok());
    for (measures, said) in [
        (
            "measures = \"pressure\", of = \"tank\"",
            "line 7: tank.level: is in m, but `gauge` measures what is in Pa",
        ),
        (
            "measures = \"flow\", of = \"valve\"",
            "tank.level: is in m, but `gauge` measures what is in m3/s",
        ),
    ] {
        let found = problems(&text.replace("measures = \"level\", of = \"tank\"", measures));
        assert!(found.contains(said), "`{said}` is not in:\n{found}");
    }
}

#[test]
fn a_tank_in_a_relation_without_time_is_refused() {
    let text =
        format!("independent = \"depth\"\nconnections = [\"tank -> valve -> atmosphere\"]{HEAD}");
    assert!(
        problems(&text).contains("independent: is no time, but tank would fill"),
        "{}",
        problems(&text)
    );
}

#[test]
fn values_out_of_range_and_units_of_another_kind_are_refused() {
    let text = format!("connections = [\"tank -> valve -> atmosphere\"]{HEAD}");
    assert!(
        problems(&text.replace("area = 1.0", "area = -1.0"))
            .contains("tank.area: is -1 m2, expected a number above 0")
    );
    for step in ["0", "-1", "nan", "inf"] {
        let found = problems(&format!("{text}\n[record]\nstep = {step}"));
        assert!(
            found.contains("record.step: is") && found.contains("above 0"),
            "{found}"
        );
    }
    let found = problems(&text.replace("area = 1.0", "area = \"3 bar\""));
    assert!(found.contains("tank.area"), "{found}");
}

#[test]
fn a_line_with_darcy_friction_or_inertia_needs_a_length() {
    let line = |keys: &str| {
        problems(&format!(
            "connections = [\"tank -> valve -> riser -> atmosphere\"]{HEAD}\"riser.flow\" = 0.0\n[components.riser]\nkind = \"line\"\n{keys}"
        ))
    };
    let missing = "line 9: riser.length: is missing or 0";
    for keys in [
        "bore = 0.04\nfriction = \"darcy\"\ninertia = true",
        "flow_area = 0.01\ninertia = true",
        "bore = 0.04\nfriction = \"darcy\"\nminor_loss = 2.0",
        "bore = 0.04",
    ] {
        let found = line(keys);
        assert!(found.contains(missing), "{keys}: {found}");
    }
    for keys in [
        "bore = 0.04\nlength = 12.0\nfriction = \"darcy\"\ninertia = true",
        // The loss of a bend at the speed in its bore.
        "bore = 0.04\nminor_loss = 2.0",
        "quadratic = 1e6",
    ] {
        let found = line(keys);
        assert!(!found.contains("riser.length"), "{keys}: {found}");
    }
}

#[test]
fn what_was_misspelt_is_told_with_what_was_meant() {
    let text = format!("connections = [\"tank -> valve -> atmosphere\"]{HEAD}");
    let cases = [
        ("-> valve", "-> valv", "did you mean `valve`?"),
        ("atmosphere", "atmosphre", "did you mean `atmosphere`?"),
        ("of = \"tank\"", "of = \"tnak\"", "did you mean `tank`?"),
        ("area = 1.0", "aera = 1.0", "did you mean `area`?"),
        (
            "kind = \"valve\"",
            "kind = \"vlave\"",
            "did you mean `valve`?",
        ),
        ("[initial]", "[intial]", "did you mean `initial`?"),
    ];
    for (right, wrong, meant) in cases {
        let found = Assembly::parse(&text.replacen(right, wrong, 1))
            .unwrap_err()
            .to_string();
        assert!(found.contains(meant), "{wrong}: {found}");
    }
    // What carries no flow is no end of a connection.
    let found = problems(&text.replacen("-> valve", "-> valv", 1));
    assert!(
        found.contains("components: tank, valve, atmosphere"),
        "{found}"
    );
}

#[test]
fn a_unit_that_is_suggested_is_of_the_dimension_that_is_asked_for() {
    let text = format!("connections = [\"tank -> valve -> atmosphere\"]{HEAD}");
    let area = problems(&text.replace("area = 1.0", "area = \"3 dm\""));
    assert!(
        area.contains("unknown unit `dm`, expected one such as `m2`"),
        "{area}"
    );
    let density = problems(&format!("{text}[fluid]\ndensity = \"1.30 kg\"\n"));
    assert!(
        density.contains("unknown unit `kg`; did you mean `sg`?"),
        "{density}"
    );
    // Near a unit of pressure alone.
    let gauge = text.replace("of = \"tank\"", "of = \"tank\", unit = \"baar\"");
    let level = problems(&gauge);
    assert!(
        level.contains("`baar`") && !level.contains("`bar`"),
        "{level}"
    );
}

#[test]
fn what_contradicts_itself_is_refused_with_its_numbers() {
    let text = format!("connections = [\"tank -> valve -> atmosphere\"]{HEAD}");
    assert!(Assembly::parse(&text).is_ok());
    let tank = |properties: &str, level: &str, more: &str| {
        let text = text.replace("area = 1.0", properties);
        problems(&format!(
            "{}\n{more}",
            text.replace("\"tank.level\" = 2.0", level)
        ))
    };
    let whole = "\"tank.level\" = 2.0";
    for (found, said) in [
        (
            tank("area = 1.0, brim = \"1.5 m\"", whole, ""),
            "tank.level: starts at 2 m, above the brim at 1.5 m",
        ),
        (
            tank("area = 1.0, brim = 1.5", "\"tank.level\" = \"160 cm\"", ""),
            "tank.level: starts at 1.6 m, above the brim at 1.5 m",
        ),
        (
            tank(
                "area = 1.0, brim = 1.5",
                "\"tank.level\" = { start = 1.7, low = 0.0, high = 1.8 }",
                "",
            ),
            "tank.level: starts at 1.7 m, above the brim at 1.5 m",
        ),
        (
            tank(
                "area = 1.0, area_profile = [[0.0, 1.0], [2.0, 1.5]]",
                whole,
                "",
            ),
            "tank.area: is given beside `area_profile`",
        ),
        (
            tank("area = 1.0", whole, "[scale]\ntime = 0.0"),
            "scale.time: is 0, expected a positive number",
        ),
    ] {
        assert!(found.contains(said), "{found}");
    }
    // A brim that is sought may come to lie above.
    let sought = "[free]\n\"tank.brim\" = { start = 1.5, low = 1.0, high = 3.0 }";
    let sought = Assembly::parse(&format!("{text}\n{sought}"));
    assert!(sought.is_ok(), "{sought:?}");
}

#[test]
fn a_value_of_another_form_is_refused_with_the_forms_there_are() {
    let text = |more: &str| {
        let text = format!("connections = [\"tank -> valve -> atmosphere\"]{HEAD}{more}");
        Assembly::parse(&text).unwrap_err().to_string()
    };
    for (more, said) in [
        (
            "[free]\n\"tank.area\" = 0.6",
            "start = .., low = .., high = ..",
        ),
        (
            "[free]\n\"tank.area\" = { start = \"1 m2\", low = 0.5, high = 2.0 }",
            "expected a number in SI units, without a unit",
        ),
        (
            "\"valve.flow\" = { from = 0.1 }",
            "{ measured = \"instrument\" }",
        ),
        (
            "[fluid]\ndensity = [1000.0]",
            "a number with its unit such as \"19.5 in\"",
        ),
    ] {
        assert!(text(more).contains(said), "{more}: {}", text(more));
    }
}
