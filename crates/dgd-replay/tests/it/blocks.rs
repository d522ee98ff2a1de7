//! A recording that comes in blocks is replayed as one that is there at once.

use crate::rig::{line, options, recording};
use dgd_recording::Channel;
use dgd_replay::{
    BlockReplay, DynamicsError, Kind, Pair, Recording, Replay, ReplayError, ReplayOptions,
    ReturnLine, replay,
};
use proptest::prelude::*;

fn in_blocks(
    recording: &Recording,
    options: &ReplayOptions,
    length: usize,
) -> Result<Replay, ReplayError> {
    let n = recording.len();
    let span_s = (recording.time_s[0], recording.time_s[n - 1]);
    let mut run = BlockReplay::new(&line(), options, n, span_s)?;
    let mut parts = Vec::new();
    for from in (0..n).step_by(length) {
        parts.push(run.add(recording.slice(from..n.min(from + length)))?);
    }
    let last = run.finish()?;
    let mut all = Replay {
        time_s: Vec::new(),
        inflow_m3_s: Vec::new(),
        speed_pct: Vec::new(),
        level_m: Pair::default(),
        return_flow_m3_s: Pair::default(),
        pump_flow_m3_s: Pair::default(),
        inlet_pressure_pa: Pair::default(),
        outlet_pressure_pa: Pair::default(),
        head_m: Pair::default(),
        ..last.clone()
    };
    parts.push(last);
    for part in parts {
        all.time_s.extend(part.time_s);
        all.inflow_m3_s.extend(part.inflow_m3_s);
        all.speed_pct.extend(part.speed_pct);
        for (mine, theirs) in [
            (&mut all.level_m, part.level_m),
            (&mut all.return_flow_m3_s, part.return_flow_m3_s),
            (&mut all.pump_flow_m3_s, part.pump_flow_m3_s),
            (&mut all.inlet_pressure_pa, part.inlet_pressure_pa),
            (&mut all.outlet_pressure_pa, part.outlet_pressure_pa),
            (&mut all.head_m, part.head_m),
        ] {
            mine.measured.extend(theirs.measured);
            mine.simulated.extend(theirs.simulated);
        }
    }
    Ok(all)
}

/// As text, in which NaN is itself and no bit is lost.
fn text(found: Result<Replay, ReplayError>) -> String {
    match found {
        Ok(replay) => format!("{replay:?}"),
        Err(error) => format!("{error:?}"),
    }
}

fn kinds() -> impl Strategy<Value = Kind> {
    prop_oneof![
        Just(Kind::Coupled),
        Just(Kind::Riser),
        Just(Kind::Flow),
        Just(Kind::Steady)
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn any_gaps_and_rests_in_any_blocks(
        samples in 1..300_u32,
        gaps in prop::collection::vec((0..7_usize, 0..300_usize, 1..150_usize, 0..3_u8), 0..12),
        length in 1..90_usize,
        kind in kinds(),
        window in prop_oneof![2 => Just(None), 1 => (-20.0..300.0_f64, -20.0..400.0_f64).prop_map(Some)],
        delay_s in prop_oneof![Just(0.0), Just(12.0), Just(4.4), Just(900.0)],
        given in any::<bool>(),
        max_steps in prop_oneof![3 => Just(10_000_000), 1 => 1..300_usize],
    ) {
        let mut recording = recording(samples.max(2));
        recording = recording.slice(0..samples as usize);
        let channels: Vec<Channel> = recording.series().iter().map(|(c, _)| *c).collect();
        for (which, from, many, what) in gaps {
            let values = recording.channel_mut(channels[which % channels.len()]).unwrap();
            let from = from.min(values.len() - 1);
            let here = values[from];
            let to = (from + many).min(values.len());
            values[from..to].fill(match what { 0 => f64::NAN, 1 => here, _ => -0.0 });
        }
        let mut options = options(kind);
        options.solver.relative = 1e-4;
        options.solver.max_steps = max_steps;
        options.delay_s = delay_s;
        options.window_s = window;
        if given {
            options.start.level_m = Some(140.0);
            options.start.flow_m3_s = Some(0.04);
        }
        let whole = replay(&line(), &recording, &options);
        prop_assert_eq!(text(in_blocks(&recording, &options, length)), text(whole));
    }
}

#[test]
fn what_waits_does_not_grow_with_the_recording() {
    let recording = recording(4000);
    let mut options = options(Kind::Coupled);
    options.solver.relative = 1e-4;
    let mut run = BlockReplay::new(&line(), &options, 4000, (0.0, 3999.0)).unwrap();
    let mut rows = 0;
    for from in (0..4000).step_by(100) {
        rows += run
            .add(recording.slice(from..from + 100))
            .unwrap()
            .time_s
            .len();
        assert!(rows + 20 > from + 80, "{rows} of {from}");
    }
}

#[test]
fn inputs_that_rest_for_long_give_the_same_rows() {
    let mut recording = recording(1500);
    for (channel, _) in recording.clone().series() {
        let values = recording.channel_mut(channel).unwrap();
        for rest in [100..1300, 1320..1500] {
            let here = values[rest.start];
            values[rest].fill(here);
        }
    }
    for kind in [Kind::Coupled, Kind::Riser, Kind::Flow, Kind::Steady] {
        let options = options(kind);
        let whole = text(replay(&line(), &recording, &options));
        for length in [1, 60, 1000] {
            assert_eq!(text(in_blocks(&recording, &options, length)), whole);
        }
    }
}

#[test]
fn a_meter_that_shows_what_is_to_come_is_refused_in_blocks() {
    for delay_s in [-1e-9, -12.0, f64::NAN] {
        let options = ReplayOptions {
            delay_s,
            ..options(Kind::Coupled)
        };
        let error = BlockReplay::new(&line(), &options, 100, (0.0, 99.0)).unwrap_err();
        let told = format!("the delay is {delay_s} s, expected at least 0 s");
        assert!(error.to_string().starts_with(&told), "{error}");
    }
}

#[test]
fn blocks_that_are_not_the_recording_announced_are_refused() {
    let recording = recording(100);
    let run = || BlockReplay::new(&line(), &options(Kind::Coupled), 90, (0.0, 89.0)).unwrap();
    let told = |error: ReplayError| error.to_string();
    let mut more = run();
    more.add(recording.slice(0..50)).unwrap();
    assert_eq!(
        told(more.add(recording.slice(50..100)).unwrap_err()),
        "blocks of 100 samples in all, expected 90"
    );
    let mut fewer = run();
    fewer.add(recording.slice(0..50)).unwrap();
    assert_eq!(
        told(fewer.finish().unwrap_err()),
        "blocks of 50 samples in all, expected 90"
    );
    let mut all = run();
    all.add(recording.slice(0..90)).unwrap();
    all.finish().unwrap();
}

#[test]
fn an_infinite_delay_and_a_line_that_cannot_be_are_refused_before_any_block() {
    let refused = |line: &ReturnLine, delay_s| {
        let options = ReplayOptions {
            delay_s,
            ..options(Kind::Coupled)
        };
        match BlockReplay::new(line, &options, 100, (0.0, 99.0)) {
            Err(ReplayError::Dynamics(DynamicsError::Parameter { name, .. })) => Some(name),
            Err(other) => panic!("{other}"),
            Ok(_) => None,
        }
    };
    assert_eq!(refused(&line(), f64::INFINITY), Some("delay_s"));
    let floating = ReturnLine {
        density_kg_m3: -1.0,
        ..line()
    };
    assert_eq!(refused(&floating, 12.0), Some("density_kg_m3"));
    assert_eq!(refused(&line(), 12.0), None);
}

/// A clock of 1.0 s a step at first and of 1.1 s later: 20 s are 20 samples there and 19 of the mean.
#[test]
fn a_window_on_another_clock_than_the_whole_has_the_same_rows_or_says_why_not() {
    let mut recording = recording(3000);
    for (i, t) in (0..).zip(recording.time_s.iter_mut().skip(1500)) {
        *t = 1500.0 + 1.1 * f64::from(i);
    }
    let options = |window_s, delay_s| ReplayOptions {
        window_s,
        delay_s,
        ..options(Kind::Riser)
    };
    let early = Some((0.0, 1000.0));
    for (window_s, delay_s) in [(None, 20.0), (early, 4.0), (early, 0.0)] {
        let options = options(window_s, delay_s);
        let whole = text(replay(&line(), &recording, &options));
        assert_eq!(text(in_blocks(&recording, &options, 70)), whole);
    }
    let options = options(early, 20.0);
    assert!(replay(&line(), &recording, &options).is_ok());
    let drift = in_blocks(&recording, &options, 70).unwrap_err();
    assert!(
        matches!(drift, ReplayError::Drift { found_s: 1.0, .. }),
        "{drift}"
    );
}

#[test]
fn a_delay_beyond_the_recording_is_to_blame() {
    let recording = recording(300);
    let options = ReplayOptions {
        delay_s: 900.0,
        ..options(Kind::Coupled)
    };
    for refused in [
        replay(&line(), &recording, &options).unwrap_err(),
        in_blocks(&recording, &options, 70).unwrap_err(),
    ] {
        assert!(
            matches!(refused, ReplayError::DelayBeyond { delay_s: 900.0, .. }),
            "{refused}"
        );
    }
}
