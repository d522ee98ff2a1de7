use crate::wells::{column, table};
use dgd_recording::{Proposal, Table, propose_channels, survey};

fn proposed(table: &Table) -> Proposal {
    propose_channels(&survey(table))
}

fn tags(proposal: &Proposal) -> Vec<(&str, &str)> {
    proposal
        .channels
        .iter()
        .map(|c| (c.channel, c.tag.as_str()))
        .collect()
}

fn stamps() -> Vec<f64> {
    (0..50).map(f64::from).collect()
}

#[test]
fn the_names_of_table_2_1_need_no_help() {
    let proposal = proposed(&table(&stamps()));
    assert_eq!(
        tags(&proposal),
        [
            ("time", "gom.t"),
            ("mud_pump_flow", "gom.FT1"),
            ("booster_flow", "gom.FT2"),
            ("topfill_flow", "gom.FT3"),
            ("return_flow", "gom.FT4"),
            ("pump_inlet_pressure", "gom.PT1"),
            ("pump_inlet_pressure", "gom.PT2"),
            ("pump_outlet_pressure", "gom.PT3"),
            ("pump_outlet_pressure", "gom.PT4"),
            ("riser_pressure", "gom.PT5"),
            ("pump_speed", "gom.SPM"),
        ]
    );
    assert_eq!(proposal.missing, [] as [&str; 0]);
    assert_eq!(proposal.doubts, [] as [&str; 0]);
    assert!(proposal.channels.iter().all(|c| !c.reason.is_empty()));
}

#[test]
fn a_clock_of_a_spreadsheet_counts_days() {
    let unit = |step: f64, written: Option<&str>| {
        let stamps: Vec<f64> = (0..50).map(|k| 45_591.9 + step * f64::from(k)).collect();
        let mut table = table(&stamps);
        table.columns[0].unit = written.map(str::to_owned);
        proposed(&table).channels[0].unit.clone()
    };
    assert_eq!(unit(1.0 / 86_400.0, None), "d");
    assert_eq!(unit(10.0 / 86_400.0, None), "d");
    let stamps: Vec<f64> = (0..3601)
        .map(|k| 45_591.9 + f64::from(k) / 86_400.0)
        .collect();
    let doubts = proposed(&table(&stamps)).doubts;
    assert!(doubts[0].contains("as a clock in days would"), "{doubts:?}");
    let clock = survey(&table(&stamps)).clock_in_seconds();
    assert_eq!(clock, survey(&table(&stamps)).clock, "its unit is written");
    let mut bare = table(&stamps);
    bare.columns[0].unit = None;
    let clock = survey(&bare).clock_in_seconds().unwrap().unwrap();
    assert!((clock.step_s - 1.0).abs() < 1e-6, "{}", clock.step_s);
    let hour = clock.span_s.1 - clock.span_s.0;
    assert!((hour - 3600.0).abs() < 1e-3, "{hour}");
    let told = clock.issues()[0].message.clone();
    assert!(
        told.ends_with("s around 1 s; samples moved to the nearest step"),
        "{told}"
    );
    assert!(
        !told.contains(" 0 s") && !told.contains("0.000 s"),
        "{told}"
    );
    // A unit that is written stands, and so does a step that is one of seconds.
    assert_eq!(unit(1.0 / 86_400.0, Some("h")), "h");
    assert_eq!(unit(0.1, None), "s");
}

#[test]
fn other_spellings_are_understood() {
    let spellings: [[&str; 8]; 2] = [
        [
            "Boost line flow",
            "Flow In",
            "Top fill flow",
            "Return flow line",
            "Suction pressure",
            "Discharge pressure",
            "Riser pressure",
            "Pump speed",
        ],
        [
            "BoosterPumpFlow",
            "MudPumpFlow",
            "TopFillFlow",
            "FlowOut",
            "PumpInletPressure",
            "PumpOutletPressure",
            "RiserPressure",
            "PumpSpeed",
        ],
    ];
    let from = [2, 1, 3, 4, 5, 7, 9, 10];
    let channels = [
        "booster_flow",
        "mud_pump_flow",
        "topfill_flow",
        "return_flow",
        "pump_inlet_pressure",
        "pump_outlet_pressure",
        "riser_pressure",
        "pump_speed",
    ];
    for names in spellings {
        let whole = table(&stamps());
        let mut columns = vec![whole.columns[0].clone()];
        for (name, from) in names.iter().zip(from) {
            let mut column = whole.columns[from].clone();
            column.tag = (*name).into();
            columns.push(column);
        }
        let proposal = proposed(&Table {
            columns,
            ..Table::default()
        });
        for (name, channel) in names.iter().zip(channels) {
            assert!(
                tags(&proposal).contains(&(channel, name)),
                "{name}: {:?}",
                tags(&proposal)
            );
        }
        assert_eq!(proposal.missing, [] as [&str; 0]);
    }
}

#[test]
fn what_is_not_there_is_missing_and_not_guessed() {
    let mut table = table(&stamps());
    table.columns.truncate(4);
    let proposal = proposed(&table);
    assert_eq!(
        proposal.missing,
        [
            "return_flow",
            "pump_inlet_pressure",
            "pump_outlet_pressure",
            "pump_speed"
        ]
    );
    // A column without a value, or of another dimension, is no candidate.
    let mut empty = crate::wells::table(&stamps());
    empty.columns[4].values.fill(f64::NAN);
    empty.columns[10].unit = Some("psi".into());
    assert_eq!(proposed(&empty).missing, ["return_flow", "pump_speed"]);
}

#[test]
fn a_file_without_units_gets_the_thesis_s_and_says_so() {
    let mut bare = table(&stamps());
    bare.columns.iter_mut().for_each(|c| c.unit = None);
    let proposal = proposed(&bare);
    let flow = &proposal.channels[1];
    assert_eq!(flow.unit, "gpm");
    assert!(
        flow.reason.contains("no unit in the file, `gpm` assumed"),
        "{}",
        flow.reason
    );
    let mut open = table(&stamps());
    open.columns[5].unit = Some("psi".into());
    let inlet = proposed(&open).channels[5].clone();
    assert_eq!(
        (inlet.tag.as_str(), inlet.unit.as_str()),
        ("gom.PT1", "psia")
    );
}

#[test]
fn an_assumed_unit_comes_with_the_reason() {
    let mut bare = table(&stamps());
    bare.columns[4].unit = None;
    bare.columns[5].unit = Some("kgf".into());
    let proposal = proposed(&bare);
    let assumed: Vec<(&str, &str)> = (proposal.channels.iter())
        .filter_map(|c| Some((c.tag.as_str(), c.unit_assumed.as_deref()?)))
        .collect();
    assert_eq!(
        assumed,
        [
            ("gom.FT4", "the file names none"),
            ("gom.PT1", "the file's `kgf` is none that is known for it")
        ]
    );
    assert!(proposal.channels[5].reason.ends_with("`psia` assumed"));
}

/// What is proposed for the pump speed beside columns of these tags and units.
fn speed_of(others: &[(&str, &str)]) -> Option<(String, String)> {
    let mut columns = vec![column("t", "s", &stamps())];
    columns.extend(
        others
            .iter()
            .map(|(tag, unit)| column(tag, unit, &stamps())),
    );
    let proposal = proposed(&Table {
        columns,
        ..Table::default()
    });
    let found = proposal.channels.iter().find(|c| c.channel == "pump_speed");
    found.map(|c| (c.tag.clone(), c.unit.clone()))
}

#[test]
fn the_pump_speed_is_the_only_percent_or_a_tachometer_of_its_name() {
    let is = |tag: &str, unit: &str| Some((tag.to_owned(), unit.to_owned()));
    assert_eq!(speed_of(&[("ST1", "%"), ("ST2", "%")]), is("ST1", "%"));
    assert_eq!(speed_of(&[("SSP", "%")]), is("SSP", "%"));
    assert_eq!(speed_of(&[("SSP", "%"), ("X", "%")]), None);
    assert_eq!(speed_of(&[("Choke opening", "%")]), None);
    assert_eq!(speed_of(&[("SSP rpm", "rpm")]), is("SSP rpm", "rpm"));
    assert_eq!(speed_of(&[("Subsea Pump", "Hz")]), is("Subsea Pump", "Hz"));
    for (tag, unit) in [
        ("Rotary speed", "rpm"),
        ("Mud pump speed", "rpm"),
        ("Pump speed", "strokes/min"),
    ] {
        assert_eq!(speed_of(&[(tag, unit)]), None, "{tag}");
    }
    // Percent of full speed needs nothing to be looked up.
    let both = [("SSP rpm", "rpm"), ("Pump speed", "%")];
    assert_eq!(speed_of(&both), is("Pump speed", "%"));
}

#[test]
fn discharge_may_be_shortened() {
    let pressures = ["Disch P1", "Disch P2"].map(|tag| column(tag, "psig", &stamps()));
    let proposal = proposed(&Table {
        columns: [vec![column("t", "s", &stamps())], pressures.to_vec()].concat(),
        ..Table::default()
    });
    assert_eq!(
        tags(&proposal)[1..],
        [
            ("pump_outlet_pressure", "Disch P1"),
            ("pump_outlet_pressure", "Disch P2")
        ]
    );
}

#[test]
fn a_unit_at_the_end_of_a_name_is_taken_and_a_word_is_not() {
    let table = Table {
        columns: vec![
            column("time", "", &stamps()),
            column("Booster m3/h", "", &stamps()),
            column("return_flow_lpm", "", &stamps()),
            column("inlet P_bara", "", &stamps()),
            column("flow in", "", &stamps()),
        ],
        ..Table::default()
    };
    let proposal = proposed(&table);
    let unit = |channel: &str| {
        let found = proposal.channels.iter().find(|c| c.channel == channel);
        found.map(|c| c.unit.as_str())
    };
    assert_eq!(unit("booster_flow"), Some("m3/h"));
    assert_eq!(unit("return_flow"), Some("l/min"));
    assert_eq!(unit("pump_inlet_pressure"), Some("bara"));
    assert_eq!(unit("mud_pump_flow"), Some("gpm"));
}

#[test]
fn swapped_pump_sides_raise_a_doubt() {
    let mut swapped = table(&stamps());
    for pair in [(5, 7), (6, 8)] {
        let tag = swapped.columns[pair.0].tag.clone();
        swapped.columns[pair.0].tag = swapped.columns[pair.1].tag.clone();
        swapped.columns[pair.1].tag = tag;
    }
    let doubts = proposed(&swapped).doubts;
    assert_eq!(
        doubts,
        ["`gom.PT3` is below `gom.PT1` in the median: are inlet and outlet swapped?"]
    );
}

#[test]
fn values_that_do_not_fit_their_unit_raise_a_doubt() {
    let doubt = |index: usize, factor: f64| {
        let mut wrong = table(&stamps());
        wrong.columns[index]
            .values
            .iter_mut()
            .for_each(|v| *v *= factor);
        proposed(&wrong).doubts
    };
    // bar in a column that says psi; l/s that say gpm; rpm that say percent.
    let inlet = doubt(5, 1.0 / 14.5 / 10.0);
    assert!(
        inlet
            .iter()
            .any(|d| d.contains("gom.PT1") && d.contains("is the unit right?"))
    );
    let flow = doubt(4, 1.0 / 60.0);
    assert!(flow.iter().any(|d| d.contains("gom.FT4")), "{flow:?}");
    let speed = doubt(10, 30.0);
    assert!(
        speed.iter().any(|d| d.contains("expected 0 to 100 %")),
        "{speed:?}"
    );
}

#[test]
fn a_table_without_columns_has_everything_missing() {
    let proposal = proposed(&Table::default());
    assert_eq!(proposal.channels, []);
    assert_eq!(proposal.missing.len(), 8);
    let only = Table {
        columns: vec![column("x", "1", &[])],
        ..Table::default()
    };
    assert_eq!(proposed(&only).channels, []);
}

#[test]
fn a_name_in_percent_is_no_flow_rate() {
    let mut log = table(&stamps());
    log.columns[4].tag = "Flow Out %".into();
    log.columns[4].unit = None;
    assert_eq!(proposed(&log).missing, ["return_flow"]);
}
