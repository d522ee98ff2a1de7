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
    assert!(
        told[3]
            .1
            .contains("unknown unit `gmp`; did you mean `gpm`?"),
        "{told:?}"
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
        let tag = tag.to_owned();
        well.channels.return_flow = ChannelSource::Column { tag, unit };
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
