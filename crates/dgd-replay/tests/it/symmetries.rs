//! What must not matter to a replay, and truths drawn at random that it must meet.

use super::rig::{line, options, recording, run, tight};
use dgd_dynamics::inputs::{Interpolation, Signal};
use dgd_dynamics::integrate::Status;
use dgd_dynamics::return_line::{
    Friction, LineState, PumpHead, ReturnLine, derive_outputs, measured_flow, simulate_coupled,
    steady_flow,
};
use dgd_recording::Recording;
use dgd_replay::{Kind, Pair, Replay, ReplayOptions, replay};
use dgd_units::Unit;

const KINDS: [Kind; 4] = [Kind::Coupled, Kind::Riser, Kind::Flow, Kind::Steady];

/// Numbers drawn the same on every machine.
struct Draws(u64);

impl Draws {
    fn bits(&mut self) -> u32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        u32::try_from(self.0 >> 32).unwrap()
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * f64::from(self.bits()) / f64::from(u32::MAX)
    }

    fn below(&mut self, end: u32) -> u32 {
        self.bits() % end
    }
}

/// Largest difference of two series that are NaN at the same samples.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).fold(0.0, |most: f64, (a, b)| {
        assert_eq!(a.is_nan(), b.is_nan());
        if a.is_nan() {
            most
        } else {
            most.max((a - b).abs())
        }
    })
}

/// Largest differences of level, m, and flows, m³/s, of two replays.
fn states_apart(a: &Replay, b: &Replay) -> (f64, f64) {
    let flow = apart(&a.pump_flow_m3_s.simulated, &b.pump_flow_m3_s.simulated);
    let late = apart(&a.return_flow_m3_s.simulated, &b.return_flow_m3_s.simulated);
    (
        apart(&a.level_m.simulated, &b.level_m.simulated),
        flow.max(late),
    )
}

#[test]
fn seconds_added_to_the_clock_and_the_window_change_nothing() {
    let plain = recording(400);
    for kind in KINDS {
        let within = |from_s: f64, to_s: f64| ReplayOptions {
            window_s: Some((from_s, to_s)),
            ..options(kind)
        };
        let expected = run(&plain, &within(50.0, 350.0));
        for seconds in [-3600.0, 0.5, 1e5, 1.7e9] {
            let later = Recording {
                time_s: plain.time_s.iter().map(|t| t + seconds).collect(),
                ..plain.clone()
            };
            let found = run(&later, &within(50.0 + seconds, 350.0 + seconds));
            assert_eq!(found.time_s[0], 50.0 + seconds);
            assert_eq!(found.level_m.measured, expected.level_m.measured);
            assert_eq!(
                found.pump_flow_m3_s.measured,
                expected.pump_flow_m3_s.measured
            );
            // Where a second holds more than one step the time between is rounded, to 2e-7 s in
            // 2026; no state moves faster than 0.1 a second here.
            let rounded_s = f64::EPSILON * seconds.abs().max(400.0);
            let (level, flow) = states_apart(&found, &expected);
            assert!(level < rounded_s, "{kind:?}, {seconds} s: {level} m");
            assert!(flow < rounded_s, "{kind:?}, {seconds} s: {flow} m3/s");
        }
    }
}

#[test]
fn values_that_went_through_other_units_give_the_same_replay() {
    let plain = recording(400);
    let through = |text: &str, values: &mut [f64]| {
        let unit = Unit::parse(text).unwrap();
        values
            .iter_mut()
            .for_each(|v| *v = unit.to_si(unit.from_si(*v)));
    };
    for (flow, pressure) in [("gpm", "psig"), ("bbl/h", "bara")] {
        let mut other = plain.clone();
        through(flow, &mut other.mud_pump_flow_m3_s);
        through(flow, &mut other.booster_flow_m3_s);
        through(flow, &mut other.topfill_flow_m3_s);
        through(flow, &mut other.return_flow_m3_s);
        for transmitter in other
            .pump_inlet_pressure_pa
            .iter_mut()
            .chain(&mut other.pump_outlet_pressure_pa)
        {
            through(pressure, transmitter);
        }
        for kind in KINDS {
            let (there, here) = (run(&other, &options(kind)), run(&plain, &options(kind)));
            // Levels are rounded to 1e-13 m, and nothing in the line enlarges that; an integrator
            // may take another step for it, which costs no more than its tolerance of 1e-9.
            let (level, flow) = states_apart(&there, &here);
            assert!(level < 1e-8, "{kind:?} in {flow}: {level} m");
            assert!(flow < 1e-10, "{kind:?} in {flow}: {flow} m3/s");
        }
    }
}

#[test]
fn the_steady_flow_has_no_memory_of_the_samples_before() {
    let plain = recording(400);
    let no_delay = ReplayOptions {
        delay_s: 0.0,
        ..options(Kind::Steady)
    };
    let mut draws = Draws(3);
    let mut order: Vec<usize> = (0..400).collect();
    for i in (1..400).rev() {
        order.swap(i as usize, draws.below(i + 1) as usize);
    }
    let one = |values: &[f64]| -> Vec<f64> { order.iter().map(|&i| values[i]).collect() };
    let shuffled = plain.map_channels(plain.time_s.clone(), one);
    let expected = run(&plain, &no_delay);
    let found = run(&shuffled, &no_delay);
    assert_eq!(found.level_m.measured, one(&expected.level_m.measured));
    let (flow, known) = (&found.pump_flow_m3_s, &expected.pump_flow_m3_s);
    // Newton's method ends within two units of rounding of a flow, from wherever it starts.
    assert!(apart(&flow.simulated, &one(&known.simulated)) < 1e-15);
    assert_eq!(flow.deviation().unwrap().samples, 400);
}

/// A line drawn at random, and a recording that it made.
struct Drawn {
    line: ReturnLine,
    recording: Recording,
    delay: u32,
}

const SAMPLES: u32 = 500;

fn drawn(seed: u64) -> Drawn {
    let mut draws = Draws(seed);
    draws.bits();
    let plain = line();
    let line = ReturnLine {
        density_kg_m3: draws.between(1000.0, 1500.0),
        outlet_depth_m: draws.between(330.0, 360.0),
        friction: Friction {
            b_pa: draws.between(-2e4, 4e4),
            c_pa_s_m3: draws.between(0.0, 2e6),
            d_pa_s2_m6: draws.between(8e7, 2e8),
            e_pa_s3_m9: draws.between(0.0, 6e8),
        },
        pump: PumpHead {
            c0: draws.between(0.06, 0.08),
            c1: draws.between(1.0, 4.0),
            c2: draws.between(1e3, 6e3),
            n0: draws.between(1.9, 2.0),
            n2: draws.between(1.4, 2.4),
        },
        ..plain
    };
    let (level_m, speed) = (draws.between(120.0, 160.0), draws.between(60.0, 70.0));
    let (steady, _) = steady_flow(&line, level_m, speed).unwrap();
    assert!(steady > 0.01, "seed {seed}: the line drawn does not flow");
    let time_s: Vec<f64> = (0..SAMPLES).map(f64::from).collect();
    let (period, swing) = (draws.between(40.0, 150.0), draws.between(0.5, 2.0));
    let speed: Vec<f64> = time_s
        .iter()
        .map(|t| speed + swing * (t / period).sin())
        .collect();
    let mud: Vec<f64> = time_s
        .iter()
        .map(|t| 0.8 * steady + 0.002 * (t / 31.0).cos())
        .collect();
    let (booster, topfill) = (
        vec![0.15 * steady; time_s.len()],
        vec![0.05 * steady; time_s.len()],
    );
    let inflow: Vec<f64> = mud.iter().map(|q| q + 0.2 * steady).collect();
    let signal = |name, values| Signal::new(name, &time_s, values, Interpolation::Linear).unwrap();
    let (q_in, w) = (signal("inflow", &inflow), signal("speed", &speed));
    let start = LineState {
        level_m,
        flow_m3_s: steady,
    };
    let made = simulate_coupled(&line, start, &q_in, &w, &time_s, &tight()).unwrap();
    let seen = derive_outputs(&line, &made.level_m, &made.flow_m3_s, &speed, true).unwrap();
    let delay = draws.below(20);
    let recording = Recording {
        return_flow_m3_s: measured_flow(&time_s, &made.flow_m3_s, f64::from(delay)).unwrap(),
        pump_inlet_pressure_pa: vec![seen.inlet_pa],
        pump_outlet_pressure_pa: vec![seen.outlet_pa],
        riser_pressure_pa: None,
        mud_pump_flow_m3_s: mud,
        booster_flow_m3_s: booster,
        topfill_flow_m3_s: topfill,
        pump_speed_pct: speed.clone(),
        time_s: time_s.clone(),
    };
    Drawn {
        line,
        recording,
        delay,
    }
}

#[test]
fn a_replay_from_any_sample_of_any_line_meets_the_rest_of_its_recording() {
    let largest = |pair: &Pair| pair.deviation().unwrap().largest;
    let mut moved = 0.0_f64;
    for seed in 1..=10 {
        let Drawn {
            line,
            recording,
            delay,
        } = drawn(seed);
        let from = Draws(seed).below(150);
        let of = |kind| {
            let options = ReplayOptions {
                delay_s: f64::from(delay),
                window_s: Some((f64::from(from), 470.0)),
                ..options(kind)
            };
            let run = replay(&line, &recording, &options).unwrap();
            assert_eq!(run.filled, 0);
            assert_eq!(run.time_s.len(), 471 - from as usize);
            run
        };
        let coupled = of(Kind::Coupled);
        assert_eq!(coupled.status, Some(Status::Finished));
        // Both runs are good to their tolerance of 1e-9 a step, in some thousand steps.
        assert!(largest(&coupled.level_m) < 1e-6, "seed {seed}");
        assert!(largest(&coupled.pump_flow_m3_s) < 1e-8, "seed {seed}");
        let levels = &coupled.level_m.simulated;
        let (low, high) = levels.iter().fold((f64::MAX, f64::MIN), |(low, high), h| {
            (low.min(*h), high.max(*h))
        });
        moved = moved.max(high - low);
        // The meter shows what flowed a delay ago; before the window the simulation knows nothing.
        let late = delay as usize;
        let meter = Pair {
            measured: coupled.return_flow_m3_s.measured[late..].to_vec(),
            simulated: coupled.return_flow_m3_s.simulated[late..].to_vec(),
        };
        assert!(largest(&meter) < 1e-8, "seed {seed}");
        // Between samples the measured state is a straight line: it leaves out the bend of a
        // second, an eighth of its second derivative, which the other state sees.
        let bend = |values: &[f64]| {
            let bends = values.windows(3).map(|v| (v[0] - 2.0 * v[1] + v[2]).abs());
            bends.fold(0.0, f64::max) / 8.0
        };
        let riser = of(Kind::Riser);
        let lost = bend(&riser.pump_flow_m3_s.measured) * riser.time_s.len() as f64;
        let allowed = lost / line.riser_area_m2 + 1e-6;
        assert!(largest(&riser.level_m) < allowed, "seed {seed}");
        let flow = of(Kind::Flow);
        assert!(largest(&flow.pump_flow_m3_s) < 1e-6, "seed {seed}");
    }
    assert!(moved > 1.0, "the levels must move to be a test: {moved} m");
}

#[test]
fn the_delay_of_the_model_is_the_delay_between_the_two_flows() {
    let recording = recording(600);
    for shift in [0_u8, 1, 7, 25] {
        let options = ReplayOptions {
            delay_s: f64::from(shift),
            ..options(Kind::Coupled)
        };
        let run = run(&recording, &options);
        let shift = usize::from(shift);
        let (meter, pump) = (&run.return_flow_m3_s, &run.pump_flow_m3_s);
        assert!(apart(&meter.simulated[shift..], &pump.simulated[..600 - shift]) < 1e-15);
        assert_eq!(meter.measured[shift..], pump.measured[..600 - shift]);
        assert!(pump.measured[600 - shift..].iter().all(|q| q.is_nan()));
    }
}
