//! What is screened block by block is what is screened at once.

use crate::robust::recording;
use crate::synthetic::{Noise, counted, every, with_speed};
use dgd_recording::Recording;
use dgd_screen::{
    BlockScreen, Faults, ScreenError, ScreenOptions, ScreenedBlock, Screening, screen,
};
use proptest::prelude::*;

/// The parts of a screening in blocks whose lengths are taken in turn.
fn in_blocks(
    recording: &Recording,
    step_s: f64,
    options: &ScreenOptions,
    lengths: &[usize],
) -> Vec<ScreenedBlock> {
    let n = recording.len();
    let mut screening = BlockScreen::new(n, step_s, options).unwrap();
    let mut parts = Vec::new();
    loop {
        let (mut at, mut lengths) = (0, lengths.iter().cycle());
        while at < n {
            let to = (at + lengths.next().unwrap()).min(n);
            let part = screening.add(&recording.slice(at..to)).unwrap();
            assert!(part.recording.len() <= n);
            parts.extend((!part.recording.is_empty()).then_some(part));
            at = to;
        }
        if !screening.next_pass().unwrap() {
            return parts;
        }
        assert!(parts.is_empty(), "only the last pass gives parts");
    }
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|v| v.to_bits()).collect()
}

fn compare(recording: &Recording, whole: &Screening, parts: &[ScreenedBlock]) {
    let join = |of: &dyn Fn(&ScreenedBlock) -> Vec<f64>| -> Vec<f64> {
        parts.iter().flat_map(of).collect()
    };
    assert_eq!(
        bits(&join(&|p| p.recording.time_s.clone())),
        bits(&recording.time_s)
    );
    for (n, channel) in whole.channels.iter().enumerate() {
        let faults: Vec<Faults> = parts.iter().flat_map(|p| p.faults[n].1.clone()).collect();
        let first = faults.iter().zip(&channel.faults).position(|(a, b)| a != b);
        let at = first.map(|i| (i, faults[i], channel.faults[i]));
        assert_eq!(
            at,
            None,
            "{} of {} samples",
            channel.channel,
            recording.len()
        );
        assert_eq!(faults.len(), channel.faults.len());
        let values = join(&|p| p.recording.series()[n].1.to_vec());
        assert_eq!(bits(&values), bits(recording.series()[n].1));
    }
    let inlets = join(&|p| p.inlet_pressure_pa.clone());
    let outlets = join(&|p| p.outlet_pressure_pa.clone());
    assert!(bits(&inlets) == bits(&whole.inlet_pressure_pa), "inlets");
    assert!(bits(&outlets) == bits(&whole.outlet_pressure_pa), "outlets");
}

/// A rig with everything that a screening finds: gaps, spikes, stuck and frozen readings, disagreement, impossible values.
fn faulty(n: usize, step_s: f64, seed: u64, transmitters: usize) -> Recording {
    let mut recording = with_speed(n, step_s, |t| {
        if (t / 1500.0).fract() > 0.9 {
            0.0
        } else {
            60.0 + 4.0 * (t / 90.0).sin() + 2.0 * (t / 37.0).sin()
        }
    });
    let third = recording.pump_inlet_pressure_pa[0]
        .iter()
        .map(|p| p + 700.0);
    let third = third.collect();
    recording.pump_inlet_pressure_pa.push(third);
    recording.pump_inlet_pressure_pa.truncate(transmitters);
    recording
        .pump_outlet_pressure_pa
        .truncate(transmitters.min(2));
    let mut noise = Noise::new(seed);
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a share of a small count"
    )]
    let mut at = |most: usize| ((noise.next() + 1.0) * 0.4999 * most as f64) as usize % most.max(1);
    for _ in 0..n / 40 {
        let (which, what, start) = (at(12), at(6), at(n));
        let length = [1, 2, 3, 7, 20, 45, 130, 700][at(8)];
        let channels: Vec<_> = recording.series().iter().map(|(c, _)| *c).collect();
        let channel = channels[which % channels.len()];
        let values = recording.channel_mut(channel).unwrap();
        let range = start..(start + length).min(n);
        let here = values[start];
        for v in &mut values[range] {
            match what {
                0 => *v = f64::NAN,
                1 => *v += 0.3 * here.abs() + 1e-3,
                2 | 3 => *v = here,
                4 => *v = 1e9,
                _ => *v += 0.02 * here,
            }
        }
    }
    recording
}

#[test]
fn whatever_the_blocks_a_faulty_rig_is_screened_alike() {
    let mut all = Faults::NONE;
    for (seed, transmitters) in [(1, 1), (2, 2), (3, 2), (4, 3)] {
        for step_s in [1.0, 0.2, 5.0] {
            let recording = faulty(9000, step_s, seed, transmitters);
            for options in [ScreenOptions::default(), ScreenOptions::thesis()] {
                let whole = screen(&recording, step_s, &options).unwrap();
                let faults = whole.channels.iter().flat_map(|c| &c.faults);
                faults.for_each(|f| all |= *f);
                for lengths in [&[9000][..], &[977], &[64, 1, 300, 7, 0, 2500]] {
                    let parts = in_blocks(&recording, step_s, &options, lengths);
                    compare(&recording, &whole, &parts);
                }
            }
        }
    }
    // Transmitters that are never read at one sample.
    let mut recording = faulty(9000, 1.0, 2, 2);
    for (n, inlet) in recording.pump_inlet_pressure_pa.iter_mut().enumerate() {
        let lost = (0..9000).filter(|i| i % 4 != 2 * n);
        lost.for_each(|i| inlet[i] = f64::NAN);
    }
    let options = ScreenOptions::default();
    let whole = screen(&recording, 1.0, &options).unwrap();
    compare(
        &recording,
        &whole,
        &in_blocks(&recording, 1.0, &options, &[977]),
    );
    for fault in [
        Faults::MISSING,
        Faults::OUT_OF_RANGE,
        Faults::SPIKE,
        Faults::STUCK,
        Faults::DISAGREES,
        Faults::CONSTANT,
    ] {
        assert!(all.contains(fault), "{fault:?}");
    }
}

#[test]
fn a_frozen_speed_is_found_in_blocks() {
    let mut recording = with_speed(4000, 1.0, |t| {
        60.0 + 6.0 * (t / 200.0).sin() + 2.0 * (t / 37.0).sin()
    });
    for start in [500, 1700, 2900] {
        let frozen = recording.pump_speed_pct[start];
        recording.pump_speed_pct[start..start + 240].fill(frozen);
    }
    let options = ScreenOptions::default();
    // Every value in its place, and one in eleven dropped, with half a minute at a time here and there.
    for dropped in [false, true] {
        if dropped {
            let speed = recording.pump_speed_pct.iter_mut().enumerate();
            let drop = speed.filter(|(i, _)| i % 11 == 0 || i % 97 < 25);
            drop.for_each(|(_, v)| *v = f64::NAN);
            let outlet = recording.pump_outlet_pressure_pa[0].iter_mut().enumerate();
            outlet
                .filter(|(i, _)| i % 7 == 0)
                .for_each(|(_, v)| *v = f64::NAN);
        }
        let whole = screen(&recording, 1.0, &options).unwrap();
        let frozen = whole.channels.last().unwrap();
        assert!(!frozen.stuck.is_empty());
        for length in [1, 53, 1000] {
            compare(
                &recording,
                &whole,
                &in_blocks(&recording, 1.0, &options, &[length]),
            );
        }
    }
}

/// What lies beside a run of one count tells whether it held or froze, also where a block ends there.
#[test]
fn a_counter_is_judged_alike_in_blocks() {
    let (mut recording, stroke) = counted();
    for (from, leap) in [(1000, 4.0), (2500, 1.0), (4000, f64::NAN)] {
        let at = recording.mud_pump_flow_m3_s[from];
        recording.mud_pump_flow_m3_s[from..from + 400].fill(at);
        recording.mud_pump_flow_m3_s[from + 400] = at + leap * stroke;
    }
    // A signal that is lost over the edge of two blocks.
    recording.mud_pump_flow_m3_s[1990..2015].fill(0.0);
    let options = ScreenOptions::default();
    let whole = screen(&recording, 1.0, &options).unwrap();
    for lengths in [&[1000][..], &[1401], &[977], &[1, 3, 64, 2]] {
        compare(
            &recording,
            &whole,
            &in_blocks(&recording, 1.0, &options, lengths),
        );
    }
}

#[test]
fn what_is_held_does_not_grow_with_the_recording() {
    let lag = |n: usize| {
        let recording = faulty(n, 1.0, 2, 2);
        let parts = in_blocks(&recording, 1.0, &ScreenOptions::default(), &[100]);
        let longest = parts.iter().map(|p| p.recording.len()).max();
        longest.unwrap()
    };
    assert!(lag(20_000) < 500, "{}", lag(20_000));
}

#[test]
fn blocks_that_are_not_those_announced_are_refused() {
    let recording = with_speed(60, 1.0, |_| 60.0);
    let options = ScreenOptions::default();
    let mut screening = BlockScreen::new(50, 1.0, &options).unwrap();
    let error = screening.add(&recording).unwrap_err();
    assert!(matches!(
        error,
        ScreenError::Blocks {
            found: 60,
            expected: 50
        }
    ));
    let mut screening = BlockScreen::new(50, 1.0, &options).unwrap();
    screening.add(&recording.slice(0..20)).unwrap();
    assert!(screening.next_pass().is_err());
    let mut other = recording.slice(20..50);
    other.pump_inlet_pressure_pa.pop();
    let mut screening = BlockScreen::new(50, 1.0, &options).unwrap();
    screening.add(&recording.slice(0..20)).unwrap();
    assert!(screening.add(&other).is_err());
    other.pump_speed_pct.pop();
    let error = screening.add(&other).unwrap_err();
    assert!(matches!(error, ScreenError::Unequal(_)), "{error}");
    assert!(BlockScreen::new(50, f64::NAN, &options).is_err());
    let mut screening = BlockScreen::new(0, 1.0, &options).unwrap();
    while screening.next_pass().unwrap() {}
}

#[test]
fn blocks_whose_clock_jumps_are_refused_within_and_between_them() {
    let mut recording = with_speed(60, 1.0, |_| 60.0);
    recording.time_s[30..].iter_mut().for_each(|t| *t += 10.0);
    for cut in [20, 30, 40] {
        let mut screening = BlockScreen::new(60, 1.0, &ScreenOptions::default()).unwrap();
        let first = screening.add(&recording.slice(0..cut));
        let error = first
            .and_then(|_| screening.add(&recording.slice(cut..60)))
            .unwrap_err();
        assert!(matches!(error, ScreenError::Uneven(_)), "{cut}: {error}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn any_recording_in_any_blocks(
        recording in recording(),
        step_s in prop_oneof![Just(0.1), Just(1.0), Just(10.0), Just(1e-300), Just(1e300)],
        lengths in proptest::collection::vec(1..50_usize, 1..5),
    ) {
        let options = ScreenOptions::default();
        let recording = every(step_s, recording);
        let whole = screen(&recording, step_s, &options).unwrap();
        if !recording.is_empty() {
            compare(&recording, &whole, &in_blocks(&recording, step_s, &options, &lengths));
        }
    }
}
