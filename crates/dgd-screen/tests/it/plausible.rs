//! What a recording makes unlikely in its well description.

use super::synthetic::{GPM, PSI, every, steady, with_speed};
use dgd_recording::{Channel, ChannelMap, ChannelSource, Geometry, Recording, TimeSource, Well};
use dgd_screen::{BlockSuspect, Coarse, ScreenError, Suspicion, suspect};
use dgd_units::Unit;
use proptest::prelude::*;

/// What is told of channels of which a historian keeps too little.
fn coarse(recording: &Recording, step_s: f64, well: &Well) -> Result<Vec<Suspicion>, ScreenError> {
    dgd_screen::coarse(recording, step_s, well).map(|all| Coarse::suspicions(&all))
}

fn column(tag: &str, unit: &str) -> ChannelSource {
    ChannelSource::column(tag, Unit::parse(unit).unwrap())
}

/// The well that the synthetic recordings fit.
fn well() -> Well {
    Well {
        mud_density_kg_m3: 1080.0,
        geometry: Geometry {
            riser_id_m: 0.4953,
            drillpipe_od_m: 0.1683,
            casing_od_m: None,
            return_line_id_m: 0.1524,
            booster_line_id_m: None,
            pump_inlet_depth_m: 350.3,
            pump_outlet_depth_m: 350.3,
            riser_pressure_sensor_depth_m: Some(352.1),
        },
        channels: ChannelMap {
            time: TimeSource::Column {
                tag: "t".into(),
                unit: Unit::parse("s").unwrap(),
            },
            mud_pump_flow: column("FT1", "gpm"),
            booster_flow: column("FT2", "gpm"),
            topfill_flow: ChannelSource::Constant { si: 0.0 },
            return_flow: column("FT4", "gpm"),
            pump_inlet_pressure: vec![column("PT1", "psia"), column("PT2", "psia")],
            pump_outlet_pressure: vec![column("PT3", "psia"), column("PT4", "psia")],
            riser_pressure: Some(column("PT5", "psia")),
            pump_speed: column("SPM", "%"),
        },
    }
}

fn suspicions(recording: &Recording, well: &Well) -> Vec<Suspicion> {
    let found = suspect(recording, 1.0, well).unwrap();
    // In blocks the same.
    for length in [1000, 1 << 20] {
        let mut blocks = BlockSuspect::new(1.0).unwrap();
        for from in (0..recording.len()).step_by(length) {
            let to = (from + length).min(recording.len());
            blocks.add(&recording.slice(from..to)).unwrap();
        }
        assert_eq!(blocks.finish(well), found);
    }
    found
}

#[track_caller]
fn only(found: &[Suspicion]) -> &Suspicion {
    assert_eq!(found.len(), 1, "{found:#?}");
    &found[0]
}

/// The recording as it is read where a channel's description says `wrong` and the file means `right`.
fn misread(values: &mut [f64], wrong: &str, right: &str) {
    let (wrong, right) = (Unit::parse(wrong).unwrap(), Unit::parse(right).unwrap());
    for value in values {
        *value = wrong.to_si(right.from_si(*value));
    }
}

#[test]
fn a_sound_recording_is_not_suspected() {
    assert_eq!(suspicions(&steady(7200, 1.0), &well()), []);
}

#[test]
fn nothing_is_suspected_of_nothing() {
    assert_eq!(suspicions(&Recording::default(), &well()), []);
}

#[test]
fn what_cannot_be_judged_is_refused_and_not_called_sound() {
    let sound = steady(100, 1.0);
    let all = |recording: &Recording, step_s: f64| {
        let in_blocks = BlockSuspect::new(step_s).and_then(|mut blocks| blocks.add(recording));
        let refused = suspect(recording, step_s, &well()).unwrap_err();
        assert_eq!(in_blocks.unwrap_err().to_string(), refused.to_string());
        let coarse = dgd_screen::coarse(recording, step_s, &well()).unwrap_err();
        assert_eq!(coarse.to_string(), refused.to_string());
        refused
    };
    for step_s in [f64::NAN, 0.0, -1.0, f64::INFINITY] {
        assert!(matches!(all(&sound, step_s), ScreenError::Step { .. }));
    }
    assert!(matches!(all(&sound, 2.0), ScreenError::Uneven(_)));
    let mut short = sound.clone();
    short.return_flow_m3_s.pop();
    assert!(matches!(all(&short, 1.0), ScreenError::Unequal(_)));
}

#[test]
fn a_block_with_other_transmitters_or_after_a_jump_is_refused() {
    let recording = steady(100, 1.0);
    let mut blocks = BlockSuspect::new(1.0).unwrap();
    blocks.add(&recording.slice(0..50)).unwrap();
    let mut fewer = recording.slice(50..100);
    fewer.pump_inlet_pressure_pa.pop();
    let error = blocks.add(&fewer).unwrap_err();
    assert_eq!(
        error.to_string(),
        "a block of 9 channels, expected the 10 of the blocks before"
    );
    // As many, but others.
    let moved = fewer.pump_inlet_pressure_pa[0].clone();
    fewer.pump_outlet_pressure_pa.push(moved);
    assert!(blocks.add(&fewer).is_err());
    let error = blocks.add(&recording.slice(60..100)).unwrap_err();
    assert!(matches!(error, ScreenError::Uneven(_)), "{error}");
    blocks.add(&recording.slice(50..100)).unwrap();
    let whole = suspect(&recording, 1.0, &well()).unwrap();
    assert_eq!(blocks.finish(&well()), whole);
}

#[test]
fn a_pressure_in_another_unit_is_named_with_the_unit_that_fits() {
    for wrong in ["bar", "kPa", "MPa", "Pa"] {
        let mut well = well();
        let mut recording = steady(7200, 1.0);
        well.channels.pump_outlet_pressure[1] = column("PT4", wrong);
        misread(&mut recording.pump_outlet_pressure_pa[1], wrong, "psia");
        let found = suspicions(&recording, &well);
        let found = only(&found);
        assert_eq!(found.place.key, "pump_outlet_pressure", "{wrong}");
        assert_eq!(found.place.transmitter, Some(1), "{wrong}");
        assert!(
            found
                .message
                .contains("as psia pump_outlet_pressure `PT4` would be"),
            "{found}"
        );
    }
}

#[test]
fn depths_in_feet_are_suspected_and_not_the_pressures() {
    let mut well = well();
    let geometry = &mut well.geometry;
    for depth_m in [
        &mut geometry.pump_inlet_depth_m,
        &mut geometry.pump_outlet_depth_m,
        geometry.riser_pressure_sensor_depth_m.as_mut().unwrap(),
    ] {
        *depth_m *= 0.3048;
    }
    let found = suspicions(&steady(7200, 1.0), &well);
    assert_eq!(only(&found).place.key, "pump_inlet_depth");
}

/// By so much that it can be one, and yet no tag of a flow is proposed for it.
#[test]
fn a_riser_transmitter_that_is_off_by_metres_of_mud_is_asked_about_by_its_depth() {
    let recording = steady(7200, 1.0);
    for (sensor_m, inlet_m) in [(402.1, 350.3), (352.1, 300.3)] {
        let mut well = well();
        well.geometry.riser_pressure_sensor_depth_m = Some(sensor_m);
        well.geometry.pump_inlet_depth_m = inlet_m;
        let found = suspicions(&recording, &well);
        let told = found.iter().map(|s| s.message.as_str());
        let told = told.collect::<Vec<_>>().join("\n");
        assert!(
            told.contains("m of the mud") && told.contains("`riser_pressure_sensor_depth`"),
            "{told}"
        );
        assert!(!told.contains("swapped"), "{told}");
    }
}

#[test]
fn one_depth_in_feet_is_told_with_its_own_line() {
    let recording = steady(7200, 1.0);
    let in_feet = |which: fn(&mut Geometry) -> &mut f64| {
        let mut well = well();
        *which(&mut well.geometry) *= 0.3048;
        only(&suspicions(&recording, &well)).clone()
    };
    for (found, key, fits) in [
        (
            in_feet(|g| &mut g.pump_inlet_depth_m),
            "pump_inlet_depth",
            "an inlet at 350 m",
        ),
        (
            in_feet(|g| &mut g.pump_outlet_depth_m),
            "pump_outlet_depth",
            "an outlet at 350 m",
        ),
    ] {
        assert_eq!((found.place.section, found.place.key), ("geometry", key));
        assert!(
            found.message.contains("107 m") && found.message.contains(fits),
            "{found}"
        );
    }
}

#[test]
fn no_flow_that_no_rig_pumps_is_proposed_and_one_that_is_described_is_told() {
    let recording = steady(7200, 1.0);
    let mut well = well();
    well.channels.topfill_flow = ChannelSource::Constant { si: 1.0 };
    let filled = Recording {
        topfill_flow_m3_s: vec![1.0; recording.len()],
        ..recording.clone()
    };
    let told = suspicions(&filled, &well);
    assert!(
        told.iter()
            .any(|s| s.message.contains("60,000 L/min are more than rigs pump")),
        "{told:#?}"
    );
    let mut misread_all = recording.clone();
    for flow in [
        &mut misread_all.mud_pump_flow_m3_s,
        &mut misread_all.booster_flow_m3_s,
        &mut misread_all.return_flow_m3_s,
    ] {
        misread(flow, "m3/min", "gpm");
    }
    let told = suspicions(&misread_all, &self::well());
    assert!(
        told.iter().all(|s| !s.message.contains("000,000 L/min")),
        "{told:#?}"
    );
}

/// Where something else moves the outlet pressure nearly as much as the flow does, the friction factor is known within bounds.
#[test]
fn a_diameter_in_another_unit_is_suspected_however_steady_the_rig_runs() {
    let mut recording = steady(7200, 1.0);
    for outlet in &mut recording.pump_outlet_pressure_pa {
        for (t, value) in outlet.iter_mut().enumerate() {
            *value += 13.0 * PSI * (t as f64 / 211.0).sin();
        }
    }
    assert_eq!(suspicions(&recording, &well()), []);
    for times in [2.54, 1.0 / 2.54] {
        let mut well = well();
        well.geometry.return_line_id_m *= times;
        let found = suspicions(&recording, &well);
        let said = &only(&found).message;
        assert!(
            said.contains("friction factor") && said.contains("0.152 m"),
            "{said}"
        );
    }
}

#[test]
fn swapped_sides_are_told_as_a_swap() {
    let mut recording = steady(7200, 1.0);
    let one = recording.pump_inlet_pressure_pa[0].clone();
    recording.pump_inlet_pressure_pa[0] = recording.pump_outlet_pressure_pa[1].clone();
    recording.pump_outlet_pressure_pa[1] = one;
    let found = suspicions(&recording, &well());
    let told = &only(&found).message;
    assert!(
        told.contains("`PT1` and pump_outlet_pressure `PT4` would be"),
        "{told}"
    );
    assert!(told.contains("if their tags are swapped"), "{told}");
}

#[test]
fn two_mistakes_are_told_as_two() {
    let mut recording = steady(7200, 1.0);
    let mut well = well();
    well.channels.pump_inlet_pressure[0] = column("PT1", "bar");
    misread(&mut recording.pump_inlet_pressure_pa[0], "bar", "psia");
    well.channels.return_flow = column("FT4", "m3/h");
    misread(&mut recording.return_flow_m3_s, "m3/h", "gpm");
    let keys: Vec<&str> = suspicions(&recording, &well)
        .iter()
        .map(|s| s.place.key)
        .collect();
    assert_eq!(keys, ["pump_inlet_pressure", "return_flow"]);
}

/// The recording as it is read where all its pressures, or those of the inlet, and all its flows, or that of the return, are
/// described in other units than it has.
fn misread_both(pressures: (&str, bool), flows: (&str, bool)) -> (Recording, Well) {
    let (mut recording, mut well) = (steady(7200, 1.0), well());
    let (unit, all) = pressures;
    let channels = &mut well.channels;
    for (n, source) in channels.pump_inlet_pressure.iter_mut().enumerate() {
        *source = column(["PT1", "PT2"][n], unit);
        misread(&mut recording.pump_inlet_pressure_pa[n], unit, "psia");
    }
    if all {
        for (n, source) in channels.pump_outlet_pressure.iter_mut().enumerate() {
            *source = column(["PT3", "PT4"][n], unit);
            misread(&mut recording.pump_outlet_pressure_pa[n], unit, "psia");
        }
        channels.riser_pressure = Some(column("PT5", unit));
        misread(recording.riser_pressure_pa.as_mut().unwrap(), unit, "psia");
    }
    let (unit, all) = flows;
    channels.return_flow = column("FT4", unit);
    misread(&mut recording.return_flow_m3_s, unit, "gpm");
    if all {
        channels.mud_pump_flow = column("FT1", unit);
        channels.booster_flow = column("FT2", unit);
        misread(&mut recording.mud_pump_flow_m3_s, unit, "gpm");
        misread(&mut recording.booster_flow_m3_s, unit, "gpm");
    }
    (recording, well)
}

#[test]
fn a_unit_of_pressures_and_one_of_flows_are_told_together() {
    let all_pressures = ["bar", "kPa"].map(|unit| (unit, true));
    for pressures in all_pressures.into_iter().chain([("bar", false)]) {
        for flows in [("l/min", true), ("l/s", true), ("l/min", false)] {
            let (recording, well) = misread_both(pressures, flows);
            let found = suspicions(&recording, &well);
            let said: Vec<&str> = found.iter().map(|s| s.message.as_str()).collect();
            let case = format!("{pressures:?} {flows:?}: {said:#?}");
            assert_eq!(found.len(), 2, "{case}");
            let of = |key: &str| found.iter().find(|s| s.place.key == key);
            let flow = if flows.1 {
                "mud_pump_flow"
            } else {
                "return_flow"
            };
            for (key, says) in [("pump_inlet_pressure", "; as psia "), (flow, "; as gpm ")] {
                let told = of(key).is_some_and(|s| s.message.contains(says));
                assert!(told, "{key}, {case}");
            }
        }
    }
}

/// Ten hours in which the booster is switched by itself, and the mud pump at other times, and all comes back.
fn switched() -> Recording {
    let on = |t: f64, period_s: f64| (t / period_s).fract() < 0.5;
    let booster = |t: f64| if on(t, 2100.0) { 200.0 } else { 0.0 };
    let mud = |t: f64| if on(t, 3000.0) { 560.0 } else { 480.0 };
    let mut recording = with_speed(36_000, 1.0, |t| (mud(t) + booster(t)) / 12.0);
    for (i, t) in recording.time_s.iter().enumerate() {
        recording.booster_flow_m3_s[i] = booster(*t) * GPM;
        recording.mud_pump_flow_m3_s[i] = mud(*t) * GPM;
    }
    recording
}

#[test]
fn a_pump_of_which_another_share_comes_back_than_it_pumps_is_asked_about() {
    let sound = switched();
    assert_eq!(suspicions(&sound, &well()), []);
    // A fifth of what the mud pump puts in, so that the volumes balance well enough.
    let mut recording = sound.clone();
    misread(&mut recording.booster_flow_m3_s, "l/min", "gpm");
    let mut described = well();
    described.channels.booster_flow = column("FT2", "l/min");
    let found = suspicions(&recording, &described);
    let told = only(&found);
    assert_eq!(told.place.key, "booster_flow");
    assert!(
        told.message.contains("`FT2`, read as l/min") && told.message.contains("as gpm"),
        "{}",
        told.message
    );
    // No unit makes a flow of a column that has nothing to do with it.
    let mut recording = sound.clone();
    recording.booster_flow_m3_s.rotate_left(525);
    let found = suspicions(&recording, &well());
    let told = only(&found);
    assert!(
        told.place.key == "booster_flow" && told.message.ends_with("check tag and unit"),
        "{}",
        told.message
    );
    // Nor is noise of one that runs at one rate related to anything.
    let mut steady = steady(36_000, 1.0);
    steady.booster_flow_m3_s.rotate_left(18_000);
    assert_eq!(suspicions(&steady, &well()), []);
}

#[test]
fn an_atmosphere_between_twins_is_suspected_only_where_one_is_gauge() {
    let mut recording = steady(7200, 1.0);
    recording.pump_inlet_pressure_pa[0]
        .iter_mut()
        .for_each(|p| *p += 101_325.0);
    assert_eq!(
        suspicions(&recording, &well()),
        [],
        "a bias is no wrong unit"
    );
    let mut well = well();
    well.channels.pump_inlet_pressure[0] = column("PT1", "psig");
    let found = suspicions(&recording, &well);
    assert!(
        only(&found)
            .message
            .contains("both must be gauge or both absolute")
    );
}

#[test]
fn a_number_that_stands_for_no_value_is_told_and_upsets_nothing_else() {
    let filled = |every: usize, value: f64| {
        let mut recording = steady(7200, 1.0);
        for reading in recording.pump_inlet_pressure_pa[1]
            .iter_mut()
            .step_by(every)
        {
            *reading = value;
        }
        suspicions(&recording, &well())
    };
    for (every, times) in [(1200, 6), (300, 24), (50, 144)] {
        let found = filled(every, 99_999.0 * PSI);
        let found = only(&found);
        assert_eq!(found.place.channel, Some(Channel::PumpInletPressure(1)));
        let told = format!("`PT2` reads 99,999 psia {times} times, and besides 35");
        assert!(found.message.contains(&told), "{found}");
    }
    // Twice may be a spike, and what is not far off a pressure.
    assert_eq!(filled(3600, 99_999.0 * PSI), []);
    assert_eq!(filled(1200, 900.0 * PSI), []);
}

#[test]
fn a_channel_without_values_and_one_that_rests_are_told() {
    let mut recording = steady(7200, 1.0);
    recording.riser_pressure_pa.as_mut().unwrap().fill(f64::NAN);
    recording.pump_inlet_pressure_pa[1].fill(24e5);
    let found = suspicions(&recording, &well());
    let told: Vec<&str> = found.iter().map(|s| s.place.key).collect();
    assert_eq!(told, ["pump_inlet_pressure", "riser_pressure"]);
    assert!(found[0].message.contains("never changes"), "{}", found[0]);
    assert!(found[1].message.contains("has no value"), "{}", found[1]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// What a diagnosis is for is not suspected: gains of 10 %, offsets of 3 bar, mud 10 % off.
    #[test]
    fn effects_are_no_wrong_units(
        gains in proptest::array::uniform3(0.9..1.1f64),
        offsets in proptest::array::uniform5(-3e5..3e5f64),
        mud in 0.92..1.1f64,
    ) {
        let mut recording = steady(3600, 1.0);
        let flows = [
            &mut recording.mud_pump_flow_m3_s,
            &mut recording.booster_flow_m3_s,
            &mut recording.return_flow_m3_s,
        ];
        for (flow, gain) in flows.into_iter().zip(gains) {
            flow.iter_mut().for_each(|q| *q *= gain);
        }
        let pressures = recording
            .pump_inlet_pressure_pa
            .iter_mut()
            .chain(&mut recording.pump_outlet_pressure_pa)
            .chain(&mut recording.riser_pressure_pa);
        for (pressure, offset) in pressures.zip(offsets) {
            pressure.iter_mut().for_each(|p| *p += offset);
        }
        let mut well = well();
        well.mud_density_kg_m3 *= mud;
        // Two at one depth 6 bar apart are more than a bias; keep the pairs within 5, and the riser's beside both of the inlet.
        let apart = |a: &[f64], b: &[f64]| (a[100] - b[100]).abs();
        prop_assume!(apart(&recording.pump_inlet_pressure_pa[0], &recording.pump_inlet_pressure_pa[1]) < 4.8e5);
        for inlet in &recording.pump_inlet_pressure_pa {
            let riser = recording.riser_pressure_pa.as_ref().unwrap();
            prop_assume!(apart(inlet, riser) < 4.8e5);
        }
        prop_assume!(apart(&recording.pump_outlet_pressure_pa[0], &recording.pump_outlet_pressure_pa[1]) < 4.8e5);
        prop_assert_eq!(suspect(&recording, 1.0, &well), Ok(vec![]));
    }

    /// Whatever a recording holds, it is looked at to the end.
    #[test]
    fn nothing_makes_it_panic(
        scale in proptest::array::uniform9(prop_oneof![Just(0.0), Just(f64::NAN), Just(f64::INFINITY), -1e12..1e12f64]),
        n in 0usize..400,
        step_s in prop_oneof![Just(1e-9), Just(1.0), Just(1e9)],
    ) {
        let mut recording = every(step_s, steady(n, 1.0));
        let mut scales = scale.iter().cycle();
        let series = [
            &mut recording.mud_pump_flow_m3_s,
            &mut recording.booster_flow_m3_s,
            &mut recording.return_flow_m3_s,
            &mut recording.pump_speed_pct,
        ];
        for values in series
            .into_iter()
            .chain(&mut recording.pump_inlet_pressure_pa)
            .chain(&mut recording.pump_outlet_pressure_pa)
            .chain(&mut recording.riser_pressure_pa)
        {
            let by = scales.next().unwrap();
            values.iter_mut().for_each(|v| *v *= by);
        }
        for suspicion in suspect(&recording, step_s, &well()).unwrap() {
            prop_assert!(!suspicion.message.is_empty());
        }
    }
}

/// Codes of a logger below vacuum, of seconds, had made the speed suspect.
#[test]
fn a_pressure_below_vacuum_upsets_nothing_else() {
    let mut recording = steady(7200, 1.0);
    for pressure in &mut recording.pump_outlet_pressure_pa {
        // Where the pump runs fastest.
        for k in 0..12 {
            let at = 565 * k + 120;
            pressure[at..at + 30].fill(-313.0 * PSI);
        }
    }
    assert_eq!(suspect(&recording, 1.0, &well()), Ok(vec![]));
    // Where most is below vacuum, that is what is wrong.
    for value in &mut recording.pump_outlet_pressure_pa[0] {
        *value = -value.abs();
    }
    assert!(!suspect(&recording, 1.0, &well()).unwrap().is_empty());
}

/// What a historian makes of a recording: a value is kept until one is `least` away, and only every so many samples one is read.
fn kept(mut recording: Recording, channel: Channel, least: f64, every: usize) -> Recording {
    let values = recording.channel_mut(channel).unwrap();
    let mut last = f64::NAN;
    for (i, value) in values.iter_mut().enumerate() {
        let away = !((*value - last).abs() < least);
        if away && i.is_multiple_of(every) {
            last = *value;
        }
        *value = last;
    }
    recording
}

#[test]
fn what_a_historian_leaves_out_is_told_with_its_size_and_what_is_sound_is_not() {
    let (inlet, back, pumped) = (
        Channel::PumpInletPressure(1),
        Channel::ReturnFlow,
        Channel::MudPumpFlow,
    );
    for (channel, least, every, told) in [
        (inlet, 1.6e4, 1, Some("by 2")),
        (inlet, 1e3, 1, None),
        (back, 1.6e-3, 1, Some("gpm or more")),
        (back, 5e-4, 1, None),
        (back, 0.0, 30, Some("every 30 s and holds it")),
        (back, 0.0, 5, None),
        // Strokes are counted: what is pumped in rests as it likes.
        (pumped, 1.6e-3, 1, None),
        (pumped, 0.0, 60, Some("every 60 s and holds it")),
        (Channel::PumpSpeed, 0.3, 1, Some("by 0.3 % or more")),
        (Channel::PumpSpeed, 0.1, 1, None),
        (Channel::PumpSpeed, 1.0, 1, Some("by 1 % or more")),
    ] {
        let recording = kept(steady(7200, 1.0), channel, least, every);
        let found = coarse(&recording, 1.0, &well()).unwrap();
        match told {
            None => assert_eq!(found, [], "{channel} {least} {every}"),
            Some(part) => {
                let one = only(&found);
                assert_eq!(one.place.channel, Some(channel));
                assert!(one.message.contains(part), "{}", one.message);
            }
        }
    }
    let told = |recording: &Recording, step_s: f64| {
        coarse(&every(step_s, recording.clone()), step_s, &well()).unwrap()
    };
    assert_eq!(told(&Recording::default(), 1.0), []);
    // What counts is for how long a reading is held, not for how many samples.
    let held = kept(steady(7200, 1.0), back, 0.0, 30);
    assert_eq!(told(&held, 0.2), []);
    assert!(only(&told(&held, 0.5)).message.contains("every 15 s"));
}

/// What an archive exports that keeps a reading every so many samples, and draws lines in between.
fn on_lines(mut recording: Recording, channel: Channel, every: usize) -> Recording {
    let values = recording.channel_mut(channel).unwrap();
    let read = values.to_vec();
    for (i, value) in values.iter_mut().enumerate() {
        let from = i / every * every;
        let to = (from + every).min(read.len() - 1);
        *value = read[from] + (read[to] - read[from]) * (i - from) as f64 / every as f64;
    }
    recording
}

#[test]
fn readings_on_straight_lines_are_told_once_for_all_channels() {
    let (inlet, back) = (Channel::PumpInletPressure(1), Channel::ReturnFlow);
    let told = |recording: &Recording| coarse(recording, 1.0, &well()).unwrap();
    let one = on_lines(steady(7200, 1.0), inlet, 20);
    assert!(
        only(&told(&one))
            .message
            .contains("`PT2` moves on straight lines at "),
        "{:?}",
        told(&one)
    );
    let two = on_lines(one, back, 12);
    let both = told(&two);
    let said = &only(&both).message;
    assert!(
        said.contains("`FT4`, pump_inlet_pressure 2 `PT2` move on straight lines"),
        "{said}"
    );
    assert_eq!(told(&steady(7200, 1.0)), []);
    // A reading every two or five seconds with lines in between tells as much as those rows alone.
    for every in [2, 5] {
        assert_eq!(told(&on_lines(steady(7200, 1.0), back, every)), []);
    }
    // A dozen readings tell it where all lies between them.
    let few = on_lines(steady(7200, 1.0), inlet, 600);
    assert!(
        only(&told(&few))
            .message
            .contains("`PT2` moves on straight lines")
    );
    assert_eq!(told(&on_lines(steady(7200, 1.0), inlet, 1200)), []);
    // A rig that was simulated without noise: lags after steps, whose bends are small beside their corners.
    let mut simulated = steady(14_400, 1.0);
    let mut lags = 0.04;
    for (i, flow) in simulated.return_flow_m3_s.iter_mut().enumerate() {
        let to = if i / 450 % 2 == 0 { 0.04 } else { 0.05 };
        lags += (to - lags) / 60.0;
        *flow = lags;
    }
    assert_eq!(told(&simulated), []);
}

/// A speed that is set moves by as much as one with a deadband, but not as often.
#[test]
fn a_speed_that_is_set_is_no_deadband() {
    let set = |every: usize| {
        let mut recording = steady(7200, 1.0);
        for (i, value) in recording.pump_speed_pct.iter_mut().enumerate() {
            *value = 60.0 + (i / every % 4) as f64;
        }
        coarse(&recording, 1.0, &well()).unwrap()
    };
    assert_eq!(set(300), []);
    // Nor is one that is ramped from one set-point to the next.
    let mut ramped = steady(14_400, 1.0);
    for (i, value) in ramped.pump_speed_pct.iter_mut().enumerate() {
        let (k, within) = (i / 200, (i % 200) as f64);
        let low = if k.is_multiple_of(2) { 55.0 } else { 60.0 };
        let up = if k.is_multiple_of(2) { 0.5 } else { -0.5 };
        *value = low + up * within.min(10.0);
    }
    assert_eq!(coarse(&ramped, 1.0, &well()).unwrap(), []);
    assert!(
        only(&set(60)).message.contains("pump_speed"),
        "{:?}",
        set(60)
    );
}

/// A transmitter that leaps from sample to sample keeps all that it reads, and what rests while mud stands is no deadband.
#[test]
fn a_noisy_pressure_is_not_coarse_nor_is_one_that_rests_while_mud_stands() {
    let inlet = Channel::PumpInletPressure(1);
    let mut noisy = steady(7200, 1.0);
    for (i, value) in noisy.channel_mut(inlet).unwrap().iter_mut().enumerate() {
        // One sample of ten repeats the one before.
        *value += 2e4 * (i.min(i / 10 * 10 + 8) % 7) as f64;
    }
    assert_eq!(coarse(&noisy, 1.0, &well()), Ok(vec![]));
    // Of one reading a sample none is held, however seldom samples are.
    let seldom = every(30.0, noisy.clone());
    assert_eq!(coarse(&seldom, 30.0, &well()), Ok(vec![]));
    let mut stopped = noisy.clone();
    stopped.return_flow_m3_s[..5000].fill(0.0);
    stopped.channel_mut(inlet).unwrap()[..5000].fill(24e5);
    assert_eq!(coarse(&stopped, 1.0, &well()), Ok(vec![]));
}
