//! What `prepare` blanks and what it leaves.

use super::rig::Rig;
use dgd_identify::{Prepared, ScreenOptions, prepare};
use dgd_recording::{Channel, Recording};

fn prepared(recording: Recording) -> Prepared {
    prepare(recording, 1.0, &ScreenOptions::default()).unwrap()
}

/// Samples at which two recordings differ, by channel.
fn blanked(before: &Recording, after: &Recording) -> Vec<(Channel, Vec<usize>)> {
    let pairs = before.series().into_iter().zip(after.series());
    pairs
        .map(|((channel, old), (_, new))| {
            let gone = (0..old.len()).filter(|&i| new[i].to_bits() != old[i].to_bits());
            let gone: Vec<usize> = gone.collect();
            assert!(gone.iter().all(|&i| new[i].is_nan()), "{channel}");
            (channel, gone)
        })
        .filter(|(_, gone)| !gone.is_empty())
        .collect()
}

#[test]
fn a_stuck_transmitter_is_blanked_alone_and_its_twin_carries_on() {
    let mut recording = Rig::default().recording();
    let stuck = recording.pump_outlet_pressure_pa[1][3000];
    recording.pump_outlet_pressure_pa[1][3000..3300].fill(stuck);
    let prepared = prepared(recording.clone());
    let gone = blanked(&recording, &prepared.recording);
    assert_eq!(
        gone,
        [(Channel::PumpOutletPressure(1), (3000..3300).collect())]
    );
    assert!(prepared.keep[3000..3300].iter().all(|keep| *keep));
    let rest = &prepared.outlet_pressure_pa[3000..3300];
    let twin = &prepared.recording.pump_outlet_pressure_pa[0][3000..3300];
    // The two read the same but for 1.4 kPa of noise: so do the mean and the twin left.
    assert!(
        rest.iter()
            .zip(twin)
            .all(|(mean, twin)| (mean - twin).abs() < 1e3)
    );
}

#[test]
fn a_reading_that_is_frozen_for_many_minutes_is_told_and_a_short_one_is_not() {
    for (samples, told) in [(900, true), (300, false)] {
        let mut recording = Rig::default().recording();
        let frozen = recording.pump_inlet_pressure_pa[0][3000];
        recording.pump_inlet_pressure_pa[0][3000..3000 + samples].fill(frozen);
        let said = prepared(recording).not_used();
        let expected = "`pump_inlet_pressure 1` repeats one value from 3000 to 3900 s and is not used there; is it frozen?";
        assert_eq!(said, if told { vec![expected] } else { vec![] });
    }
}

#[test]
fn a_reading_that_freezes_again_and_again_is_told_once() {
    let mut recording = Rig::default().recording();
    let read = &mut recording.pump_inlet_pressure_pa[0];
    for (from, samples) in [(1000, 700), (2000, 300), (3000, 900)] {
        let frozen = read[from];
        read[from..from + samples].fill(frozen);
    }
    let said = prepared(recording).not_used();
    let expected = "`pump_inlet_pressure 1` repeats one value for 10 min or more 2 times, 0.4 h in all and longest from 3000 to 3900 s, and is not used there; is it frozen, or logged only when it changes?";
    assert_eq!(said, [expected]);
}

#[test]
fn a_meter_that_is_logged_now_and_then_is_known_where_it_is_read() {
    let mut recording = Rig::default().recording();
    let read = recording.return_flow_m3_s.clone();
    // For half an hour of the recording the logger holds each reading for five minutes.
    for from in (3000..4800).step_by(300) {
        recording.return_flow_m3_s[from..from + 300].fill(read[from]);
    }
    let prepared = prepared(recording);
    for (i, known) in prepared.recording.return_flow_m3_s[3000..4800]
        .iter()
        .enumerate()
    {
        assert_eq!(known.is_finite(), i % 300 == 0, "{i}");
    }
    // A fit takes none of them.
    assert!(prepared.keep[3000..4800].iter().all(|keep| !keep));
}

#[test]
fn a_sound_recording_is_left_as_it_is() {
    let recording = Rig::default().recording();
    let prepared = prepared(recording.clone());
    assert_eq!(blanked(&recording, &prepared.recording), []);
    assert_eq!(prepared.kept(), recording.len());
    assert_eq!(
        prepared.inlet_pressure_pa,
        recording.mean_inlet_pressure_pa()
    );
}

#[test]
fn a_faulty_meter_rejects_its_samples() {
    let mut recording = Rig::default().recording();
    recording.return_flow_m3_s[4000] = 0.2;
    recording.return_flow_m3_s[5000..5010].fill(f64::NAN);
    let prepared = prepared(recording);
    assert!(prepared.recording.return_flow_m3_s[4000].is_nan());
    assert!(!prepared.keep[4000] && !prepared.keep[5005]);
    assert_eq!(prepared.kept(), 9000 - 11);
    let told: Vec<(&str, usize)> = prepared
        .tally
        .iter()
        .filter(|t| t.total > 0)
        .map(|t| (t.name, t.total))
        .collect();
    assert_eq!(told, [("gap", 10), ("spike", 1)]);
}

#[test]
fn averaging_leaves_one_series_a_side() {
    let recording = Rig::default().recording();
    let mut fewer = recording.clone();
    fewer.pump_inlet_pressure_pa[0][100..200].fill(f64::NAN);
    let prepared = prepared(fewer);
    let (inlet, outlet) = (
        prepared.inlet_pressure_pa.clone(),
        prepared.outlet_pressure_pa.clone(),
    );
    let averaged = prepared.averaged();
    assert_eq!(averaged.pump_inlet_pressure_pa, [inlet]);
    assert_eq!(averaged.pump_outlet_pressure_pa, [outlet]);
    assert_eq!(averaged.pump_speed_pct, recording.pump_speed_pct);
    assert!(
        averaged.pump_inlet_pressure_pa[0]
            .iter()
            .all(|p| p.is_finite())
    );
}

#[test]
fn an_option_that_cannot_be_is_refused() {
    let options = ScreenOptions {
        stuck_chance: 0.0,
        ..ScreenOptions::default()
    };
    assert!(prepare(Rig::default().recording(), 1.0, &options).is_err());
    let recording = Rig::default().recording();
    assert!(prepare(recording, 0.0, &ScreenOptions::default()).is_err());
}
