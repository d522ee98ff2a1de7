//! Windows, gaps and refusals.

use super::rig::{line, options, recording, run};
use dgd_dynamics::DynamicsError;
use dgd_recording::Recording;
use dgd_replay::{Kind, Pair, ReplayError, ReplayOptions, replay};

const KINDS: [Kind; 4] = [Kind::Coupled, Kind::Riser, Kind::Flow, Kind::Steady];

fn over(kind: Kind, from_s: f64, to_s: f64) -> ReplayOptions {
    ReplayOptions {
        window_s: Some((from_s, to_s)),
        ..options(kind)
    }
}

fn refused(recording: &Recording, options: &ReplayOptions) -> ReplayError {
    replay(&line(), recording, options).unwrap_err()
}

#[test]
fn a_window_is_clipped_to_the_recording_with_both_ends() {
    let recording = recording(600);
    for kind in KINDS {
        let run = run(&recording, &over(kind, 100.0, 200.0));
        assert_eq!((run.time_s[0], run.time_s[100]), (100.0, 200.0));
        assert_eq!(run.time_s.len(), 101);
        assert_eq!(
            run.return_flow_m3_s.measured,
            recording.return_flow_m3_s[100..=200]
        );
    }
    let late = run(&recording, &over(Kind::Coupled, 550.5, 1e9));
    assert_eq!((late.time_s[0], late.time_s.len()), (551.0, 49));
    let early = run(&recording, &over(Kind::Coupled, f64::NEG_INFINITY, 9.9));
    assert_eq!((early.time_s[0], early.time_s.len()), (0.0, 10));
}

#[test]
fn a_clock_that_jumps_is_refused_with_the_place() {
    let mut jumped = recording(600);
    jumped.time_s[300..].iter_mut().for_each(|t| *t += 1000.0);
    let mut holed = recording(600);
    holed.time_s[300] = f64::NAN;
    for odd in [&jumped, &holed] {
        let error = refused(odd, &options(Kind::Riser));
        let ReplayError::Uneven { sample, .. } = error else {
            panic!("{error}");
        };
        assert_eq!(sample, 300, "{error}");
    }
}

#[test]
fn a_hole_in_the_clock_is_named_or_does_no_harm() {
    let whole = recording(600);
    let step_s = whole.time_s[1] - whole.time_s[0];
    let window = over(Kind::Riser, 200.0 * step_s, 300.0 * step_s);
    let expected = run(&whole, &window);
    let mut named = 0;
    for hole in 0..600 {
        let mut holed = whole.clone();
        holed.time_s[hole] = f64::NAN;
        match replay(&line(), &holed, &window) {
            Ok(found) => assert_eq!(found, expected, "hole at {hole}"),
            Err(ReplayError::Uneven { sample, .. }) => {
                assert_eq!(sample, hole.max(1));
                named += 1;
            }
            Err(other) => panic!("hole at {hole}: {other}"),
        }
    }
    assert!((101..200).contains(&named), "{named}");
}

#[test]
fn a_clock_is_asked_for_as_far_as_the_delay_looks_ahead() {
    let mut jumped = recording(600);
    jumped.time_s[300..].iter_mut().for_each(|t| *t += 1000.0);
    let until = |to_s: f64, delay_s: f64| ReplayOptions {
        delay_s,
        ..over(Kind::Riser, 0.0, to_s)
    };
    let step_s = jumped.time_s[1] - jumped.time_s[0];
    let end_s = 290.0 * step_s;
    assert!(replay(&line(), &jumped, &until(end_s, 5.0 * step_s)).is_ok());
    let error = refused(&jumped, &until(end_s, 20.0 * step_s));
    assert!(
        matches!(error, ReplayError::Uneven { sample: 300, .. }),
        "{error}"
    );
}

#[test]
fn a_window_gives_what_its_part_of_the_recording_would() {
    let whole = recording(600);
    let windowed = run(&whole, &over(Kind::Steady, 100.0, 200.0));
    let all = run(&whole, &options(Kind::Steady));
    assert_eq!(
        windowed.pump_flow_m3_s.measured,
        all.pump_flow_m3_s.measured[100..=200],
        "the meter is read ahead beyond the window"
    );
    assert_eq!(windowed.filled, 0);
    for (part, whole) in windowed
        .pump_flow_m3_s
        .simulated
        .iter()
        .zip(&all.pump_flow_m3_s.simulated[100..])
    {
        assert!((part - whole).abs() < 1e-9);
    }
}

#[test]
fn what_lies_outside_the_window_is_never_read() {
    let sound = recording(600);
    let mut damaged = sound.clone();
    let outside = (0..100).chain(213..600);
    for i in outside {
        damaged.mud_pump_flow_m3_s[i] = f64::NAN;
        damaged.return_flow_m3_s[i] = f64::NAN;
        damaged.pump_speed_pct[i] = -1e9;
        for side in [
            &mut damaged.pump_inlet_pressure_pa,
            &mut damaged.pump_outlet_pressure_pa,
        ] {
            side.iter_mut().for_each(|series| series[i] = f64::NAN);
        }
    }
    for kind in KINDS {
        let options = over(kind, 100.0, 200.0);
        assert_eq!(run(&damaged, &options), run(&sound, &options));
    }
}

#[test]
fn an_empty_window_is_refused_with_the_span_of_the_recording() {
    let recording = recording(600);
    assert_eq!(
        refused(&recording, &over(Kind::Coupled, 700.0, 800.0)).to_string(),
        "the window 700 to 800 s holds 0 samples, expected at least 2; the recording spans 0 to 599 s"
    );
    for (from_s, to_s) in [
        (10.2, 10.8),
        (10.0, 10.0),
        (20.0, 10.0),
        (f64::NAN, 10.0),
        (0.0, f64::NAN),
    ] {
        let error = refused(&recording, &over(Kind::Flow, from_s, to_s));
        assert!(
            matches!(error, ReplayError::Window { samples: 0..=1, .. }),
            "{error}"
        );
    }
    let error = refused(&Recording::default(), &options(Kind::Coupled));
    assert!(
        matches!(error, ReplayError::Window { samples: 0, .. }),
        "{error}"
    );
}

#[test]
fn an_input_without_a_trusted_value_is_named() {
    let sound = recording(600);
    let blank = |which: fn(&mut Recording) -> &mut [f64]| {
        let mut recording = sound.clone();
        which(&mut recording)[50..=120].fill(f64::NAN);
        recording
    };
    let told =
        |recording: &Recording, kind| refused(recording, &over(kind, 60.0, 100.0)).to_string();
    let rest = "has no trusted value between 60 and 100 s; choose another window";
    let no_booster = blank(|r| &mut r.booster_flow_m3_s);
    assert_eq!(
        told(&no_booster, Kind::Coupled),
        format!("`booster_flow` {rest}")
    );
    let no_speed = blank(|r| &mut r.pump_speed_pct);
    assert_eq!(told(&no_speed, Kind::Flow), format!("`pump_speed` {rest}"));
    let no_meter = blank(|r| &mut r.return_flow_m3_s);
    assert_eq!(
        told(&no_meter, Kind::Riser),
        format!("`return_flow` {rest}")
    );
    assert_eq!(
        told(&no_meter, Kind::Coupled),
        format!("`return_flow` {rest}")
    );
    let mut no_inlet = blank(|r| &mut r.pump_inlet_pressure_pa[0]);
    no_inlet.pump_inlet_pressure_pa.pop();
    assert_eq!(
        told(&no_inlet, Kind::Steady),
        format!("`pump_inlet_pressure` {rest}")
    );
    // A state that is given needs no measurement.
    let mut given = over(Kind::Coupled, 60.0, 100.0);
    given.start.flow_m3_s = Some(0.05);
    assert!(replay(&line(), &no_meter, &given).is_ok());
}

#[test]
fn an_input_that_a_simulation_does_not_read_may_be_missing() {
    let sound = recording(600);
    let mut no_inflow = sound.clone();
    no_inflow.mud_pump_flow_m3_s.fill(f64::NAN);
    let mut no_speed = sound.clone();
    no_speed.pump_speed_pct.fill(f64::NAN);
    for (kind, fewer) in [
        (Kind::Flow, &no_inflow),
        (Kind::Steady, &no_inflow),
        (Kind::Riser, &no_speed),
    ] {
        let options = over(kind, 0.0, 500.0);
        let (fewer, all) = (run(fewer, &options), run(&sound, &options));
        assert_eq!(fewer.pump_flow_m3_s, all.pump_flow_m3_s, "{kind:?}");
        assert_eq!(fewer.level_m, all.level_m, "{kind:?}");
        assert_eq!(fewer.filled, all.filled, "{kind:?}");
    }
}

#[test]
fn gaps_are_filled_and_counted_and_hardly_move_the_simulation() {
    let sound = recording(1500);
    let mut holes = sound.clone();
    holes.booster_flow_m3_s[100..110].fill(f64::NAN);
    holes.pump_speed_pct[700] = f64::INFINITY;
    for side in &mut holes.pump_inlet_pressure_pa {
        side[400..405].fill(f64::NAN);
    }
    let (whole, filled) = (
        run(&sound, &options(Kind::Coupled)),
        run(&holes, &options(Kind::Coupled)),
    );
    assert_eq!((whole.filled, filled.filled), (0, 11));
    let both = Pair {
        measured: whole.level_m.simulated,
        simulated: filled.level_m.simulated.clone(),
    };
    assert!(both.deviation().unwrap().largest < 1e-3);
    // The measurement keeps its holes: nothing is compared there.
    assert!(filled.level_m.measured[402].is_nan());
    assert_eq!(filled.level_m.deviation().unwrap().samples, 1495);
    // The flow alone reads the level: its holes are filled too.
    assert_eq!(run(&holes, &options(Kind::Flow)).filled, 6);
}

#[test]
fn one_transmitter_carries_the_side_when_the_other_is_silent() {
    let mut recording = recording(600);
    recording.pump_inlet_pressure_pa[0].fill(f64::NAN);
    let run = run(&recording, &options(Kind::Coupled));
    assert_eq!(
        run.inlet_pressure_pa.measured,
        recording.pump_inlet_pressure_pa[1]
    );
}

#[test]
fn a_series_of_another_length_is_refused() {
    let mut recording = recording(600);
    recording.pump_outlet_pressure_pa[1].pop();
    assert_eq!(
        refused(&recording, &options(Kind::Riser)).to_string(),
        "`pump_outlet_pressure 2` has 599 samples, expected 600 to match the time"
    );
}

#[test]
fn a_model_that_cannot_be_is_refused() {
    let mut odd = line();
    odd.pump.n2 = 0.5;
    let error = replay(&odd, &recording(60), &options(Kind::Coupled)).unwrap_err();
    assert!(
        matches!(
            error,
            ReplayError::Dynamics(DynamicsError::Parameter { name: "n2", .. })
        ),
        "{error}"
    );
    let delays = |kind| [f64::NAN, f64::INFINITY].map(|delay_s| (delay_s, kind));
    for (delay_s, kind) in KINDS.into_iter().flat_map(delays) {
        let options = ReplayOptions {
            delay_s,
            ..options(kind)
        };
        let error = refused(&recording(60), &options);
        assert!(
            matches!(
                error,
                ReplayError::Dynamics(DynamicsError::Parameter {
                    name: "delay_s",
                    ..
                })
            ),
            "{error}"
        );
    }
}

#[test]
fn deviation_is_simulated_less_measured() {
    let pair = Pair {
        measured: vec![1.0, f64::NAN, 3.0, 4.0],
        simulated: vec![2.0, 5.0, f64::NAN, 1.0],
    };
    let deviation = pair.deviation().unwrap();
    assert_eq!(deviation.samples, 2);
    assert_eq!((deviation.bias, deviation.largest), (-1.0, 3.0));
    assert_eq!(deviation.rmse, 5.0_f64.sqrt());
    assert_eq!(Pair::default().deviation(), None);
}

/// Noise may put a first reading where the model has an end; a start that is given is meant.
#[test]
fn a_measured_start_is_brought_within_the_model_and_a_given_one_is_refused() {
    let mut recording = recording(300);
    let most = recording.pump_inlet_pressure_pa[0][0] + 1e8;
    recording.return_flow_m3_s[0] = -0.01;
    for pressure in &mut recording.pump_inlet_pressure_pa {
        pressure[0] = most;
    }
    let mut options = options(Kind::Coupled);
    options.delay_s = 0.0;
    let run = replay(&line(), &recording, &options).unwrap();
    assert_eq!(run.level_m.simulated[0], 0.0);
    assert_eq!(run.pump_flow_m3_s.simulated[0], 0.0);
    let name = |options: &ReplayOptions| match refused(&recording, options) {
        ReplayError::Dynamics(DynamicsError::Parameter { name, .. }) => name,
        other => panic!("{other}"),
    };
    options.start.flow_m3_s = Some(-0.05);
    assert_eq!(name(&options), "start.flow_m3_s");
    options.start.flow_m3_s = Some(0.05);
    options.start.level_m = Some(-20.0);
    assert_eq!(name(&options), "start.level_m");
}
