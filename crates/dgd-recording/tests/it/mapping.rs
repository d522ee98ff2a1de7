use crate::wells::{column, source, table, unit, well};
use dgd_recording::{
    Added, BlockGrid, Channel, ChannelError, ChannelSource, IssueKind, Recording, RecordingError,
    Table, TimeSource, Well, WellError,
};
use dgd_units::{Dimension, STANDARD_ATMOSPHERE_PA, Unit};

const GPM: f64 = 6.3090e-5;
const PSI: f64 = 6894.75729;

#[test]
fn columns_are_found_by_name_or_by_their_last_part_and_become_si() {
    let mut fits = table(&[10.0, 11.0, 12.0]);
    fits.columns[1].tag = "FT1".into();
    let (recording, issues) = Recording::from_table(fits, &well()).unwrap();
    assert_eq!(issues, []);
    assert_eq!(recording.time_s, [0.0, 1.0, 2.0]);
    assert_eq!(recording.mud_pump_flow_m3_s[0], 500.0 * GPM);
    assert_eq!(recording.pump_outlet_pressure_pa[1][0], 592.0 * PSI);
    assert_eq!(recording.pump_speed_pct[0], 50.0);
    assert_eq!(recording.series().len(), 10);
    assert!((recording.mean_inlet_pressure_pa()[0] - 351.0 * PSI).abs() < 1e-6);
    assert!((recording.inflow_m3_s()[0] - 730.0 * GPM).abs() < 1e-12);
}

#[test]
fn an_exact_name_wins_and_an_ambiguous_suffix_is_none() {
    let mut two = table(&[0.0, 1.0]);
    two.columns.push(column("other.FT4", "gpm", &[1.0, 1.0]));
    let error = Recording::from_table(two.clone(), &well()).unwrap_err();
    assert!(matches!(error, RecordingError::NoColumn { .. }), "{error}");
    two.columns.push(column("FT4", "gpm", &[7.0, 7.0]));
    let (recording, _) = Recording::from_table(two, &well()).unwrap();
    assert_eq!(recording.return_flow_m3_s, [7.0 * GPM, 7.0 * GPM]);
}

#[test]
fn a_missing_tag_is_told_with_what_the_file_has() {
    let mut well = well();
    well.channels.return_flow = source("FT9", "gpm");
    let error = Recording::from_table(table(&[0.0, 1.0]), &well).unwrap_err();
    assert_eq!(
        error.to_string(),
        "channel `return_flow` is mapped to the tag `FT9`, which the recording does not have; it has \
         gom.t, gom.FT1, gom.FT2, gom.FT3, gom.FT4, gom.PT1, gom.PT2, gom.PT3, gom.PT4, gom.PT5, gom.SPM"
    );
    let mut two = well.clone();
    two.channels.pump_inlet_pressure[1] = source("PT0", "psia");
    let error = Recording::from_table(table(&[0.0, 1.0]), &two).unwrap_err();
    let both = "the tag `FT9`, which the recording does not have, nor `PT0` of `pump_inlet_pressure 2`; it has";
    assert!(error.to_string().contains(both), "{error}");
    let mut wide = table(&[0.0, 1.0]);
    wide.columns
        .extend((0..100).map(|n| column(&format!("extra{n}"), "1", &[])));
    let error = Recording::from_table(wide, &well).unwrap_err().to_string();
    assert!(error.ends_with("extra12, and 87 more"), "{error}");
}

#[test]
fn a_tag_that_differs_in_marks_or_ends_is_proposed_if_it_is_the_only_one() {
    let refused = |tag: &str| {
        let mut well = well();
        well.channels.return_flow = source(tag, "gpm");
        Recording::from_table(table(&[0.0, 1.0]), &well)
            .unwrap_err()
            .to_string()
    };
    assert!(refused("ft 4 (gpm)").contains("did you mean `gom.FT4`?"));
    for tag in ["FT", "FT9", "flow", "-"] {
        assert!(!refused(tag).contains("did you mean"), "{tag}");
    }
}

#[test]
fn two_channels_cannot_share_a_column() {
    let mut well = well();
    well.channels.pump_inlet_pressure[1] = source("PT1", "psia");
    let error = Recording::from_table(table(&[0.0, 1.0]), &well).unwrap_err();
    assert_eq!(
        error.to_string(),
        "tag `PT1` is mapped to both `pump_inlet_pressure 1` and `pump_inlet_pressure 2`"
    );
}

#[test]
fn a_column_of_another_length_is_refused() {
    let mut short = table(&[0.0, 1.0, 2.0]);
    short.columns[4].values.pop();
    let error = Recording::from_table(short, &well()).unwrap_err();
    let expected = RecordingError::Length {
        tag: "FT4".into(),
        found: 2,
        expected: 3,
    };
    assert_eq!(error, expected);
}

#[test]
fn no_samples_are_no_recording() {
    let error = Recording::from_table(table(&[]), &well()).unwrap_err();
    assert_eq!(error, RecordingError::Empty);
}

#[test]
fn the_description_s_unit_wins_and_only_real_disagreement_is_told() {
    let told = |in_file: &str| {
        let mut table = table(&[0.0, 1.0]);
        table.columns[5].unit = Some(in_file.into());
        let (recording, issues) = Recording::from_table(table, &well()).unwrap();
        assert_eq!(recording.pump_inlet_pressure_pa[0][0], 350.0 * PSI);
        issues
    };
    // `psi` leaves open what `psia` says, and an unknown unit says nothing.
    for silent in ["psia", "PSI", "psi(a)", "wombat"] {
        assert_eq!(told(silent), [], "{silent}");
    }
    for loud in ["psig", "bar", "gpm"] {
        let issues = told(loud);
        assert_eq!(issues.len(), 1, "{loud}");
        assert_eq!(issues[0].kind, IssueKind::UnitDisagrees);
        assert_eq!(
            issues[0].to_string(),
            format!(
                "pump_inlet_pressure 1: the file gives `{loud}`, the well description `psia`; the description was used"
            )
        );
    }
}

#[test]
fn gauge_pressures_become_absolute() {
    let mut well = well();
    well.channels.pump_inlet_pressure = vec![source("PT1", "psig")];
    let (recording, _) = Recording::from_table(table(&[0.0, 1.0]), &well).unwrap();
    assert_eq!(
        recording.pump_inlet_pressure_pa,
        [[350.0, 350.01].map(|p| p * PSI + STANDARD_ATMOSPHERE_PA)]
    );
}

#[test]
fn a_channel_without_transmitter_is_constant() {
    let mut well = well();
    well.channels.topfill_flow = ChannelSource::Constant { si: 0.002 };
    well.channels.riser_pressure = None;
    let (recording, _) = Recording::from_table(table(&[0.0, 1.0]), &well).unwrap();
    assert_eq!(recording.topfill_flow_m3_s, [0.002, 0.002]);
    assert_eq!(recording.riser_pressure_pa, None);
    assert_eq!(recording.series().len(), 9);
}

#[test]
fn without_stamps_the_interval_is_the_clock() {
    let mut well = well();
    well.channels.time = TimeSource::Interval { step_s: 0.5 };
    let (recording, _) = Recording::from_table(table(&[9.0, 9.0, 9.0]), &well).unwrap();
    assert_eq!(recording.time_s, [0.0, 0.5, 1.0]);
    for step_s in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let mut odd = well.clone();
        odd.channels.time = TimeSource::Interval { step_s };
        let error = Recording::from_table(table(&[9.0, 9.0]), &odd).unwrap_err();
        assert!(matches!(error, RecordingError::Step { .. }), "{error}");
        let mut joined = recording.clone();
        let error = joined.append(recording.clone(), step_s).unwrap_err();
        assert!(matches!(error, RecordingError::Step { .. }), "{error}");
        assert_eq!(joined, recording);
    }
    for seam in [100_001, usize::MAX] {
        let mut joined = recording.clone();
        let error = joined.append_after(recording.clone(), 1.0, seam);
        let error = error.unwrap_err();
        assert!(matches!(error, RecordingError::Seam { .. }), "{error}");
        assert_eq!(joined, recording);
    }
    well.channels.return_flow = source("FT9", "gpm");
    let error = Recording::from_table(table(&[9.0, 9.0]), &well).unwrap_err();
    assert!(matches!(error, RecordingError::NoColumn { .. }), "{error}");
}

#[test]
fn stamps_in_hours_start_at_zero_seconds() {
    let mut well = well();
    well.channels.time = TimeSource::Column {
        tag: "t".into(),
        unit: unit("h"),
    };
    let (recording, _) = Recording::from_table(table(&[1.0, 1.5, 2.0]), &well).unwrap();
    assert_eq!(recording.time_s, [0.0, 1800.0, 3600.0]);
}

/// A reader makes seconds of stamps in milliseconds from 1970, which are what the description tells of the file.
#[test]
fn the_clock_that_a_reader_has_made_seconds_is_in_seconds_whatever_the_file_was_in() {
    let mut well = well();
    well.channels.time = TimeSource::Column {
        tag: "t".into(),
        unit: unit("ms"),
    };
    let mut table = table(&[0.0, 1.0, 2.0]);
    let of = |table: &Table| Recording::from_table(table.clone(), &well).unwrap();
    assert_eq!(of(&table).0.time_s, [0.0, 0.001, 0.002]);
    assert_eq!(table.first_stamp_s(&well.channels.time), Some(0.0));
    table.origin = Some("2026-03-01T10:00:00Z".to_owned());
    table.clock = Some(0);
    table.columns[0].values = vec![1.0, 2.0, 3.0];
    let (recording, issues) = of(&table);
    assert_eq!(
        (recording.time_s.as_slice(), issues),
        (&[0.0, 1.0, 2.0][..], Vec::new())
    );
    assert_eq!(table.first_stamp_s(&well.channels.time), Some(1.0));
    let began = table.began(&well.channels.time).unwrap();
    assert_eq!(began.to_string(), "2026-03-01 10:00:01 UTC");
}

#[test]
fn the_mean_of_redundant_transmitters_leaves_the_silent_one_out() {
    let recording = Recording {
        time_s: vec![0.0, 1.0, 2.0],
        pump_inlet_pressure_pa: vec![vec![1.0, f64::NAN, f64::NAN], vec![3.0, 3.0, f64::NAN]],
        pump_outlet_pressure_pa: vec![
            vec![1.0, f64::NAN, 1.0],
            vec![2.0, 2.0, f64::NAN],
            vec![6.0, 4.0, 3.0],
        ],
        ..Recording::default()
    };
    let inlet = recording.mean_inlet_pressure_pa();
    assert_eq!(inlet[..2], [2.0, 3.0]);
    assert!(inlet[2].is_nan());
    assert_eq!(recording.mean_outlet_pressure_pa(), [3.0, 3.0, 2.0]);
}

#[test]
fn a_transmitter_whose_series_ends_early_leaves_the_mean_to_the_others() {
    let mean = |series: &[&[f64]]| {
        let recording = Recording {
            time_s: vec![0.0, 1.0, 2.0],
            pump_inlet_pressure_pa: series.iter().map(|values| values.to_vec()).collect(),
            ..Recording::default()
        };
        let mean = recording.mean_inlet_pressure_pa();
        assert_eq!(mean.len(), 3, "{series:?}");
        mean
    };
    assert_eq!(mean(&[&[1.0, 2.0, 3.0], &[3.0]]), [2.0, 2.0, 3.0]);
    let three = mean(&[&[1.0, 2.0, 3.0], &[3.0], &[5.0, 4.0, 5.0, 6.0]]);
    assert_eq!(three, [3.0, 3.0, 4.0]);
    assert!(mean(&[&[1.0, 2.0]])[2].is_nan());
    assert!(mean(&[]).iter().all(|p| p.is_nan()));
}

/// Refused by both fronts, alike.
fn refusal(well: &Well) -> ChannelError {
    let Err(WellError::Channel(error)) = well.check() else {
        panic!("{:?}", well.check());
    };
    let refused = Recording::from_table(table(&[0.0, 1.0]), well).unwrap_err();
    assert!(matches!(refused, RecordingError::Channel(_)), "{refused}");
    assert_eq!(refused.to_string(), error.to_string());
    error
}

#[test]
fn a_channel_in_a_unit_of_something_else_is_refused_with_what_it_measures() {
    assert_eq!(well().check(), Ok(()));
    let mut odd = well();
    odd.channels.return_flow = source("FT4", "psi");
    assert_eq!(
        refusal(&odd).to_string(),
        "`return_flow` is in `psi`, a unit of pressure, expected a unit of flow rate such as `gpm`"
    );
    let mut odd = well();
    odd.channels.pump_inlet_pressure[1] = source("PT2", "%");
    let expected = ChannelError::Unit {
        channel: Channel::PumpInletPressure(1),
        unit: unit("%"),
        expected: Dimension::Pressure,
    };
    assert_eq!(refusal(&odd), expected);
    // A tachometer counts as percent only once its full reading is known.
    let mut odd = well();
    odd.channels.pump_speed = source("SPM", "rpm");
    assert!(matches!(refusal(&odd), ChannelError::Unit { .. }));
    let tachometer = unit("rpm").in_percent_of(1800.0).unwrap();
    odd.channels.pump_speed = ChannelSource::column("SPM", tachometer);
    assert_eq!(odd.check(), Ok(()));
    let mut odd = well();
    odd.channels.time = TimeSource::Column {
        tag: "t".into(),
        unit: unit("m"),
    };
    assert_eq!(
        refusal(&odd).to_string(),
        "the clock is in `m`, a unit of length, expected a unit of time such as `s`"
    );
}

#[test]
fn a_constant_or_a_lateness_that_is_no_number_is_refused() {
    for found in [f64::NAN, f64::INFINITY] {
        let mut odd = well();
        odd.channels.topfill_flow = ChannelSource::Constant { si: found };
        assert_eq!(
            refusal(&odd).to_string(),
            format!("`si` of `topfill_flow` is {found}, expected a finite number")
        );
        let mut odd = well();
        odd.channels.riser_pressure = Some(ChannelSource::Column {
            tag: "PT5".into(),
            unit: unit("psia"),
            late_s: found,
            added: Vec::new(),
        });
        let ChannelError::NotFinite { channel, name, .. } = refusal(&odd) else {
            panic!("{}", refusal(&odd));
        };
        assert_eq!((channel, name), (Channel::RiserPressure, "late_s"));
        let head = table(&[]);
        assert!(BlockGrid::new(&head, 10, &odd).is_err());
    }
}

#[test]
fn a_slice_holds_the_same_samples_of_every_channel() {
    let stamps: Vec<f64> = (0..40).map(f64::from).collect();
    let (mut recording, _) = Recording::from_table(table(&stamps), &well()).unwrap();
    for riser in [None, Some(stamps.clone())] {
        recording.riser_pressure_pa = riser;
        let part = recording.slice(7..19);
        assert_eq!(part.time_s, stamps[7..19]);
        assert_eq!(part.series().len(), recording.series().len());
        for ((channel, all), (same, part)) in recording.series().iter().zip(part.series()) {
            assert_eq!((*channel, &all[7..19]), (same, part));
        }
        assert_eq!(recording.slice(0..40), recording);
        assert!(recording.slice(40..40).is_empty());
    }
}

#[test]
fn channels_are_made_anew_in_the_order_of_the_series() {
    let (recording, _) = Recording::from_table(table(&[0.0, 1.0]), &well()).unwrap();
    let mut count = 0.0;
    let counted = recording.map_channels(vec![5.0], |_| {
        count += 1.0;
        vec![count]
    });
    assert_eq!(counted.time_s, [5.0]);
    for (n, (channel, values)) in counted.series().iter().enumerate() {
        assert_eq!(*values, [n as f64 + 1.0], "{channel}");
    }
}

#[test]
fn channels_are_counted_from_one_for_people() {
    assert_eq!(
        Channel::PumpInletPressure(1).to_string(),
        "pump_inlet_pressure 2"
    );
    assert_eq!(Channel::ReturnFlow.to_string(), "return_flow");
}

#[test]
fn level_head_and_friction_follow_the_hydrostatic_column() {
    let well = well();
    let full = STANDARD_ATMOSPHERE_PA + 1080.0 * 9.80665 * 350.3;
    assert!(well.level_m(full).abs() < 1e-9);
    assert!(well.line_friction_pa(full).abs() < 1e-6);
    assert!((well.head_m(full, full + 1080.0 * 9.80665 * 12.0) - 12.0).abs() < 1e-9);
    let area = std::f64::consts::PI / 4.0 * (0.4953f64.powi(2) - 0.168_275f64.powi(2));
    assert!((well.geometry.riser_area_m2() - area).abs() < 1e-12);
}

/// Pump speeds counted from 0 at stamps, with the stamps of the speed so late.
fn speeds(stamps: &[f64], late_s: f64) -> (Recording, Vec<dgd_recording::Issue>) {
    let mut table = table(stamps);
    let speed = table.columns.last_mut().unwrap();
    speed.values = (0..stamps.len()).map(|row| row as f64).collect();
    let mut well = well();
    well.channels.pump_speed = ChannelSource::Column {
        tag: "SPM".into(),
        unit: unit("%"),
        late_s,
        added: Vec::new(),
    };
    Recording::from_table(table, &well).unwrap()
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|v| v.to_bits()).collect()
}

#[test]
fn a_channel_whose_stamps_are_late_is_moved_back_and_the_others_stay() {
    const NO: f64 = f64::NAN;
    let even = [0.0, 2.0, 4.0, 6.0, 8.0];
    // A gap, and rows that are out of order.
    let gap = [0.0, 2.0, 4.0, 10.0, 12.0];
    let turned = [8.0, 0.0, 4.0, 2.0, 6.0];
    for (stamps, late_s, expected) in [
        (even, 4.0, [2.0, 3.0, 4.0, NO, NO]),
        (even, -2.0, [NO, 0.0, 1.0, 2.0, 3.0]),
        (even, 0.9, [0.0, 1.0, 2.0, 3.0, 4.0]),
        (even, 1e300, [NO; 5]),
        (gap, 2.0, [1.0, 2.0, NO, 4.0, NO]),
        (turned, 2.0, [NO, 3.0, 4.0, 2.0, 0.0]),
    ] {
        let (moved, _) = speeds(&stamps, late_s);
        assert_eq!(bits(&moved.pump_speed_pct), bits(&expected), "{late_s}");
        let (still, _) = speeds(&stamps, 0.0);
        assert_eq!(moved.time_s, still.time_s);
        assert_eq!(moved.return_flow_m3_s, still.return_flow_m3_s);
    }
}

#[test]
fn stamps_are_moved_by_whole_steps_which_is_told() {
    let stamps = [0.0, 2.0, 4.0, 6.0];
    assert_eq!(speeds(&stamps, 4.0).1, []);
    let (moved, issues) = speeds(&stamps, 3.5);
    assert_eq!(
        bits(&moved.pump_speed_pct),
        bits(&[2.0, 3.0, f64::NAN, f64::NAN])
    );
    assert_eq!(issues[0].kind, IssueKind::LateStamps);
    assert_eq!(
        issues[0].to_string(),
        "pump_speed: is 3.5 s late; its samples were moved by 4 s, whole steps of the clock"
    );
}

#[test]
fn a_channel_with_a_clock_of_its_own_does_not_come_in_blocks() {
    let mut well = well();
    well.channels.pump_outlet_pressure[1] = ChannelSource::Column {
        tag: "PT4".into(),
        unit: unit("psia"),
        late_s: -1.0,
        added: Vec::new(),
    };
    let channel = Channel::PumpOutletPressure(1);
    assert_eq!(well.channels.off_clock(), Some(channel));
    let refused = BlockGrid::new(&table(&[]), 10, &well).unwrap_err();
    assert_eq!(refused, RecordingError::OffClock { channel });
}

/// Two mud pumps, each with its own column and unit.
#[test]
fn columns_of_several_pumps_are_added_in_si() {
    let mut well = well();
    let mut table = table(&[0.0, 1.0, 2.0]);
    table
        .columns
        .push(column("SPM2", "spm", &[60.0, f64::NAN, 30.0]));
    let strokes = Unit::parse("spm").unwrap().in_flow_of(0.016).unwrap();
    well.channels.mud_pump_flow = ChannelSource::Column {
        tag: "FT1".into(),
        unit: unit("gpm"),
        late_s: 0.0,
        added: vec![Added {
            tag: "SPM2".into(),
            unit: strokes,
        }],
    };
    let mud = |table: &Table, well: &Well| {
        let (recording, _) = Recording::from_table(table.clone(), well).unwrap();
        recording.mud_pump_flow_m3_s
    };
    let sum = mud(&table, &well);
    let one = mud(&table, &crate::wells::well());
    assert!((sum[0] - one[0] - 0.016).abs() < 1e-12, "{sum:?}");
    assert!(sum[1].is_nan());
    assert!((sum[2] - one[2] - 0.008).abs() < 1e-12);
    let tags: Vec<&str> = well.channels.tags().into_iter().map(|t| t.1).collect();
    assert_eq!(tags[..3], ["FT1", "SPM2", "FT2"]);
    // In blocks as well.
    let mut grid = BlockGrid::new(&table, 3, &well).unwrap();
    grid.add(&table);
    while grid.next_pass().unwrap() {
        grid.add(&table);
    }
    let mut blocks = Vec::new();
    grid.each(&table, |part| {
        blocks.extend(part.mud_pump_flow_m3_s);
        Ok::<(), RecordingError>(())
    })
    .unwrap();
    assert_eq!(blocks[0].to_bits(), sum[0].to_bits());
    assert_eq!(blocks[2].to_bits(), sum[2].to_bits());
    // Each must be there, a flow, and as long as the others.
    let with = |change: &dyn Fn(&mut Added)| {
        let mut other = well.clone();
        if let ChannelSource::Column { added, .. } = &mut other.channels.mud_pump_flow {
            change(&mut added[0]);
        }
        Recording::from_table(table.clone(), &other).unwrap_err()
    };
    let absent = with(&|one| one.tag = "SPM3".into());
    assert!(
        matches!(absent, RecordingError::NoColumn { .. }),
        "{absent}"
    );
    let pressure = with(&|one| one.unit = unit("psi"));
    assert!(pressure.to_string().contains("mud_pump_flow"), "{pressure}");
    let twice = with(&|one| one.tag = "FT1".into());
    assert!(
        matches!(twice, RecordingError::SharedColumn { .. }),
        "{twice}"
    );
    table.columns.last_mut().unwrap().values.pop();
    let short = Recording::from_table(table.clone(), &well).unwrap_err();
    assert!(matches!(short, RecordingError::Length { .. }), "{short}");
}
