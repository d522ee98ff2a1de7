use dgd_documents::{read_well, write_well};
use dgd_recording::{Channel, ChannelSource, TimeSource};

/// The wells of Table 2.2.
pub(crate) const GOM: &str = include_str!("../data/well.toml");

fn messages(source: &str) -> Vec<(usize, String)> {
    let error = read_well(source).unwrap_err();
    error
        .problems
        .iter()
        .zip(&error.places)
        .map(|(p, (line, _))| (*line, p.message.clone()))
        .collect()
}

#[test]
fn the_wells_of_table_2_2_are_read_in_si() {
    let (well, warnings) = read_well(GOM).unwrap();
    assert!(warnings.is_empty());
    assert_eq!(well.mud_density_kg_m3, 1080.0);
    assert!((well.geometry.riser_id_m - 0.4953).abs() < 1e-12);
    assert!((well.geometry.riser_area_m2() - 0.170_437).abs() < 1e-5);
    assert_eq!(well.channels.pump_inlet_pressure.len(), 2);
    assert_eq!(well.channels.pump_outlet_pressure.len(), 1);
    assert_eq!(
        well.channels.topfill_flow,
        ChannelSource::Constant {
            si: 30.0 * 6.3090e-5
        }
    );
    assert_eq!(well.channels.riser_pressure, None);
}

#[test]
fn what_is_written_is_read_back_the_same() {
    let (well, _) = read_well(GOM).unwrap();
    let (again, warnings) = read_well(&write_well(&well)).unwrap();
    assert_eq!(again, well);
    assert!(warnings.is_empty());
}

#[test]
fn every_problem_is_told_at_its_line() {
    let broken = GOM
        .replace("\"1.080 sg\"", "1.08")
        .replace("\"6.625 in\"", "\"6.625 psi\"")
        .replace("return_flow = { tag = \"FT4\", unit = \"gpm\" }\n", "")
        .replace("unit = \"%\"", "unit = \"gmp\"");
    let told = messages(&broken);
    let lines: Vec<usize> = told.iter().map(|(line, _)| *line).collect();
    assert_eq!(lines, [2, 6, 13, 20], "{told:#?}");
    assert_eq!(told[0].1, "`density` is a number without a unit");
    assert!(
        told[1]
            .1
            .contains("`psi` is a unit of pressure, expected a unit of length"),
        "{told:?}"
    );
    assert!(
        told[2].1.contains("[channels] has no `return_flow`"),
        "{told:?}"
    );
    // Near a unit of flow, which no speed has.
    assert!(told[3].1.ends_with("unknown unit `gmp`"), "{told:?}");
    let flow = messages(&GOM.replacen("unit = \"gpm\"", "unit = \"gmp\"", 1));
    assert!(
        flow[0]
            .1
            .contains("unknown unit `gmp`; did you mean `gpm`?"),
        "{flow:?}"
    );
}

#[test]
fn keys_that_a_section_lacks_are_told_together_with_lines_to_add() {
    let broken = GOM
        .replace("riser_id = \"19.5 in\"\n", "")
        .replace("mud_pump_flow =", "# ")
        .replace("pump_outlet_pressure =", "# ")
        .replace("pump_speed =", "# ");
    let error = read_well(&broken).unwrap_err();
    let told: Vec<&str> = error.problems.iter().map(|p| p.message.as_str()).collect();
    assert_eq!(
        told,
        [
            "[geometry] has no `riser_id`",
            "[channels] has no `mud_pump_flow`, `pump_outlet_pressure` and `pump_speed`",
        ]
    );
    let help = error.problems[1].help.as_deref().unwrap();
    assert_eq!(
        help,
        "add lines such as\n  mud_pump_flow = { tag = \"FT1\", unit = \"gpm\" }\n  \
         pump_outlet_pressure = [{ tag = \"PT3\", unit = \"psia\" }]\n  \
         pump_speed = { tag = \"SPM\", unit = \"%\" }"
    );
}

#[test]
fn what_was_left_to_fill_in_and_a_comma_in_a_number_are_told_as_such() {
    let broken = GOM
        .replace("\"1.080 sg\"", "\"? sg\"")
        .replace("\"19.5 in\"", "\"495,3 mm\"")
        .replace("\"6.625 in\"", "\"wide\"");
    let error = read_well(&broken).unwrap_err();
    let told: Vec<&str> = error.problems.iter().map(|p| p.message.as_str()).collect();
    assert_eq!(
        told,
        [
            "`density` is not filled in",
            "`riser_id`: `495,3 mm` has a comma in its number; write a decimal point and no thousands separator",
            "`drillpipe_od`: `wide` does not begin with a number",
        ]
    );
    let help = error.problems[0].help.as_deref();
    assert_eq!(
        help,
        Some("write its value, such as `density = \"1.08 sg\"`")
    );
}

#[test]
fn a_drill_pipe_wider_than_the_riser_is_refused() {
    let told = messages(&GOM.replace("6.625 in", "25 in"));
    assert!(
        told[0].1.contains("does not fit into the riser"),
        "{told:?}"
    );
}

#[test]
fn a_length_of_nothing_is_refused() {
    let told = messages(&GOM.replace("\"6.000 in\"", "\"0 in\""));
    assert_eq!(
        told,
        [(
            8,
            "`return_line_id` is 0 m, expected more than 0".to_owned()
        )]
    );
}

#[test]
fn a_key_nobody_reads_is_a_warning_not_an_error() {
    let (_, warnings) = read_well(&GOM.replace("casing_od", "casing_odd")).unwrap();
    assert_eq!(warnings.len(), 1);
    assert_eq!(
        warnings[0].message,
        "`casing_odd` in [geometry] is not read"
    );
}

#[test]
fn a_recording_without_time_stamps_may_say_its_interval() {
    let (well, _) = read_well(&GOM.replace(
        "{ tag = \"t\", unit = \"s\" }",
        "{ interval = \"0.5 min\" }",
    ))
    .unwrap();
    assert_eq!(well.channels.time, TimeSource::Interval { step_s: 30.0 });
    let told = messages(&GOM.replace("{ tag = \"t\", unit = \"s\" }", "{ interval = \"0 s\" }"));
    assert_eq!(told[0].0, 14);
}

#[test]
fn broken_toml_is_told_with_its_place() {
    let told = messages("[mud]\ndensity = \"1.08 sg\n");
    assert_eq!(told[0].0, 2);
    assert!(told[0].1.starts_with("this is not TOML"), "{told:?}");
}

#[test]
fn an_empty_list_of_transmitters_is_refused() {
    let told = messages(&GOM.replace(
        "[{ tag = \"PT1\", unit = \"psia\" }, { tag = \"PT2\", unit = \"psia\" }]",
        "[]",
    ));
    assert_eq!(
        told,
        [(19, "`pump_inlet_pressure` lists no transmitter".to_owned())]
    );
}

#[test]
fn odd_tags_are_read_back_the_same() {
    let (mut well, _) = read_well(GOM).unwrap();
    let unit = dgd_units::Unit::parse("gpm").unwrap();
    for tag in [
        "say \"q\"",
        "it's",
        "C:\\rig\\q",
        "two\nlines",
        "q [gpm] æøå 漢",
        "\u{7f}\u{0}",
    ] {
        well.channels.return_flow = ChannelSource::column(tag, unit);
        let (again, warnings) = read_well(&write_well(&well)).unwrap();
        assert_eq!(again, well);
        assert!(warnings.is_empty());
    }
}

#[test]
fn a_channel_without_a_transmitter_takes_a_constant_in_any_unit_of_its_kind() {
    let source = GOM.replace("{ tag = \"SPM\", unit = \"%\" }", "\"60 %\"");
    let (well, _) = read_well(&source).unwrap();
    assert_eq!(
        well.channels.pump_speed,
        ChannelSource::Constant { si: 60.0 }
    );
    let told = messages(&GOM.replace("\"30 gpm\"", "\"30 psi\""));
    assert_eq!(told[0].0, 17);
    let told = messages(&GOM.replace("\"30 gpm\"", "30"));
    assert_eq!(
        told,
        [(
            17,
            "`topfill_flow` is an integer, expected { tag = \"...\", unit = \"gpm\" }".to_owned()
        )]
    );
}

#[test]
fn a_tachometer_is_read_in_percent_of_its_full_speed_and_written_back() {
    let tachometer = "unit = \"rpm\", full = \"30 Hz\"";
    let (well, warnings) = read_well(&GOM.replace("unit = \"%\"", tachometer)).unwrap();
    assert!(warnings.is_empty());
    let ChannelSource::Column { unit, .. } = &well.channels.pump_speed else {
        panic!("a column");
    };
    assert_eq!(unit.to_si(900.0), 50.0);
    let written = write_well(&well);
    assert!(
        written.contains("unit = \"rpm\", full = \"1800 rpm\""),
        "{written}"
    );
    assert_eq!(read_well(&written).unwrap().0, well);
}

#[test]
fn a_tachometer_without_its_full_speed_is_refused_with_what_to_add() {
    let error = read_well(&GOM.replace("unit = \"%\"", "unit = \"rpm\"")).unwrap_err();
    let [problem] = error.problems.as_slice() else {
        panic!("{error}");
    };
    assert!(
        problem.message.contains("with the full speed"),
        "{problem:?}"
    );
    assert!(
        problem
            .help
            .as_ref()
            .unwrap()
            .contains("full = \"1800 rpm\"")
    );
    let none = GOM.replace("unit = \"%\"", "unit = \"rpm\", full = \"0 rpm\"");
    assert!(messages(&none)[0].1.contains("expected more than 0"));
}

#[test]
fn strokes_are_read_as_a_flow_by_their_volume_and_written_back() {
    let counted = |keys: &str| {
        GOM.replace(
            "tag = \"FT1\", unit = \"gpm\"",
            &format!("tag = \"SPM1\", {keys}"),
        )
    };
    for (keys, at_100_m3_s) in [
        ("unit = \"spm\", stroke = \"15.9 L\"", 0.0265),
        ("unit = \"strokes/min\", stroke = \"4.2 gal\"", 0.0265),
        ("unit = \"Hz\", stroke = \"0.1 bbl\"", 1.5899),
    ] {
        let (well, warnings) = read_well(&counted(keys)).unwrap();
        assert!(warnings.is_empty());
        let ChannelSource::Column { unit, .. } = &well.channels.mud_pump_flow else {
            panic!("a column");
        };
        assert!(
            (unit.to_si(100.0) / at_100_m3_s - 1.0).abs() < 1e-3,
            "{keys}"
        );
        let written = write_well(&well);
        assert!(written.contains("stroke = \"0.01"), "{written}");
        assert_eq!(read_well(&written).unwrap().0, well);
    }
    let error = read_well(&counted("unit = \"spm\"")).unwrap_err();
    let help = error.problems[0].help.as_ref().unwrap();
    assert!(help.contains("stroke = \"15.9 L\""), "{error}");
    let none = counted("unit = \"spm\", stroke = \"0 L\"");
    assert!(messages(&none)[0].1.contains("expected more than 0"));
}

#[test]
fn several_mud_pumps_are_a_list_that_is_added_and_written_back() {
    let listed = |list: &str| GOM.replace("{ tag = \"FT1\", unit = \"gpm\" }", list);
    let two = "[{ tag = \"SPM1\", unit = \"spm\", stroke = \"15.9 L\", late = \"5 s\" }, { tag = \"FT12\", unit = \"gpm\", late = \"5 s\" }]";
    let (well, warnings) = read_well(&listed(two)).unwrap();
    assert!(warnings.is_empty());
    let tags: Vec<&str> = well.channels.tags().into_iter().map(|t| t.1).collect();
    assert_eq!(tags[..3], ["SPM1", "FT12", "FT2"]);
    let written = write_well(&well);
    assert_eq!(read_well(&written).unwrap().0, well);
    let one = "[{ tag = \"FT1\", unit = \"gpm\" }]";
    assert_eq!(read_well(&listed(one)).unwrap(), read_well(GOM).unwrap());
    for (list, words) in [
        ("[]", "`mud_pump_flow` lists no pump"),
        (
            "[{ tag = \"A\", unit = \"gpm\" }, { tag = \"B\", unit = \"gpm\", late = \"5 s\" }]",
            "late by different times",
        ),
        (
            "[{ tag = \"A\", unit = \"gpm\" }, { tag = \"B\", unit = \"psi\" }]",
            "`psi` is a unit of pressure",
        ),
        (
            "[{ tag = \"A\", unit = \"gpm\" }, \"30 gpm\"]",
            "`mud_pump_flow` is a string",
        ),
    ] {
        let told = messages(&listed(list));
        assert!(told[0].1.contains(words), "{told:?}");
    }
    // Two return meters are no two flows.
    let returns = GOM
        .replace("return_flow = {", "return_flow = [{")
        .replace("\"FT4\", unit = \"gpm\" }", "\"FT4\", unit = \"gpm\" }]");
    let told = messages(&returns);
    assert!(told[0].1.contains("`return_flow` is an array"), "{told:?}");
}

#[test]
fn a_pump_that_a_rig_has_not_and_a_paddle_in_percent_are_told_how_to_write() {
    let help = |source: &str| {
        let error = read_well(source).unwrap_err();
        error.problems[0].help.clone().unwrap_or_default()
    };
    let without = help(&GOM.replace("booster_flow =", "# "));
    assert_eq!(
        without,
        "add a line such as `booster_flow = { tag = \"FT2\", unit = \"gpm\" }  # or \"0 gpm\" if the rig has none`"
    );
    let paddle = help(&GOM.replace("\"FT4\", unit = \"gpm\"", "\"FT4\", unit = \"%\""));
    assert!(paddle.contains("calibrated first"), "{paddle}");
}

#[test]
fn an_empty_or_absent_tag_is_told() {
    let told = messages(&GOM.replace("\"FT4\"", "\"\""));
    assert_eq!(told, [(18, "`tag` of `return_flow` is empty".to_owned())]);
    let told = messages(&GOM.replace("tag = \"FT4\", ", ""));
    assert_eq!(
        told,
        [(18, "[channels.return_flow] has no `tag`".to_owned())]
    );
}

#[test]
fn the_channel_names_of_a_recording_are_the_keys_of_the_document() {
    for channel in [
        Channel::MudPumpFlow,
        Channel::BoosterFlow,
        Channel::TopfillFlow,
        Channel::ReturnFlow,
        Channel::PumpInletPressure(0),
        Channel::PumpOutletPressure(0),
        Channel::PumpSpeed,
    ] {
        let renamed = GOM.replace(&format!("\n{} =", channel.name()), "\nodd =");
        let expected = format!("[channels] has no `{}`", channel.name());
        assert_eq!(messages(&renamed)[0].1, expected);
    }
}

#[test]
fn a_channel_with_a_clock_of_its_own_is_read_and_written_back() {
    let late = |late: &str| GOM.replace("tag = \"SPM\"", &format!("tag = \"SPM\", late = {late}"));
    for (written, expected_s) in [("\"20 s\"", 20.0), ("\"-0.5 min\"", -30.0)] {
        let (well, warnings) = read_well(&late(written)).unwrap();
        assert!(warnings.is_empty());
        let ChannelSource::Column { late_s, .. } = well.channels.pump_speed else {
            panic!("a column");
        };
        assert!((late_s - expected_s).abs() < 1e-12, "{late_s}");
        assert_eq!(read_well(&write_well(&well)).unwrap().0, well);
    }
    let told = messages(&late("20"));
    assert_eq!(told[0].1, "`late` is a number without a unit");
    // The clock of the file is the one that others are late on.
    let (_, warnings) =
        read_well(&GOM.replace("tag = \"t\"", "tag = \"t\", late = \"1 s\"")).unwrap();
    assert!(warnings[0].message.contains("late"), "{warnings:?}");
}
