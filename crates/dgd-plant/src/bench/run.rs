//! Runs a case and reads its instruments.

use super::case::{Bed, Case};
use super::circuit::{self, Circuit};
use super::hidden::Hidden;
use super::integrate::rk4;
use super::schedule::Programme;
use super::surge::{self, Surge};
use super::{SAMPLES, SAMPLING_S};
use crate::noise::Noise;

/// A recording of a bench, with the truth behind it.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    /// Inputs as filed, one a channel of [`super::Bench::inputs`], each of shape `(n,)`.
    pub inputs: Vec<Vec<f64>>,
    /// Outputs as filed, one a channel of [`super::Bench::outputs`], each of shape `(n,)`.
    pub outputs: Vec<Vec<f64>>,
    /// What the outputs would be without noise and steps, in SI: concealed things of the instruments included.
    pub quiet_si: Vec<Vec<f64>>,
}

impl Record {
    /// Root mean square of what noise and steps alone add to an output over some samples, in its unit: no model is off by less, but by luck.
    pub fn floor(&self, case: &Case, output: usize, samples: std::ops::Range<usize>) -> f64 {
        let unit = case.bench.outputs()[output].si;
        let count = samples.len().max(1) as f64;
        let pairs = samples.map(|i| self.outputs[output][i] - self.quiet_si[output][i] / unit);
        (pairs.map(|e| e * e).sum::<f64>() / count).sqrt()
    }
}

/// Seconds that the bench runs at its first inputs before the recording begins.
const RUN_UP_S: f64 = 900.0;

/// Runs a case for its whole length.
pub fn simulate(case: &Case) -> Record {
    simulate_for(case, SAMPLES)
}

/// Runs a case for some samples.
pub fn simulate_for(case: &Case, samples: usize) -> Record {
    let quiet = match &case.bed {
        Bed::Surge(bench) => surge_run(bench, &case.programmes, samples),
        Bed::Circuit(bench) => circuit_run(bench, &case.programmes, samples),
    };
    let read = |gauge: &super::Gauge, values: &[f64], stream: u64| {
        let mut noise = Noise::new(case.noise_seed, stream);
        values.iter().map(|v| gauge.read(*v, &mut noise)).collect()
    };
    let inputs = case.bench.inputs().iter().zip(&case.programmes).zip(0..);
    let inputs = inputs.map(|((gauge, programme), stream)| {
        let values: Vec<f64> = (0..samples)
            .map(|i| programme.at(i as f64 * SAMPLING_S))
            .collect();
        read(gauge, &values, 100 + stream)
    });
    let outputs = case.bench.outputs().iter().zip(&quiet).zip(0..);
    Record {
        inputs: inputs.collect(),
        outputs: outputs
            .map(|((gauge, values), stream)| read(gauge, values, 200 + stream))
            .collect(),
        quiet_si: quiet,
    }
}

/// The opening of a plug that follows its command as it can.
struct Plug {
    hidden: Option<Hidden>,
    opening: f64,
}

impl Plug {
    fn follow(&mut self, command: f64) -> f64 {
        match self.hidden {
            Some(Hidden::ValveBacklash { half_band }) => {
                self.opening = self.opening.clamp(command - half_band, command + half_band);
            }
            Some(Hidden::NeedleStiction { band }) => {
                let away = command - self.opening;
                if away.abs() > band {
                    // It stops short by what it did not slip.
                    self.opening = command - 0.4 * band * away.signum();
                }
            }
            _ => self.opening = command,
        }
        self.opening
    }
}

/// How many steps make a span of time.
fn steps(span_s: f64, step_s: f64) -> usize {
    crate::constants::index((span_s / step_s).round(), 10_000_000)
}

fn surge_run(bench: &Surge, programmes: &[Programme], samples: usize) -> Vec<Vec<f64>> {
    let (inlet, valve) = (&programmes[0], &programmes[1]);
    let mut plug = Plug {
        hidden: bench.hidden,
        opening: valve.at(0.0),
    };
    let drive = |time_s: f64, opening: f64| surge::Drive {
        time_s: time_s.max(0.0),
        inlet_pa: inlet.at(time_s.max(0.0)),
        opening,
    };
    let per_sample = steps(SAMPLING_S, Surge::STEP_S);
    let mut y = bench.start();
    for _ in 0..steps(RUN_UP_S, Surge::STEP_S) {
        let opening = plug.follow(valve.at(0.0));
        y = rk4(&y, 0.0, Surge::STEP_S, |_, y| {
            bench.rates(&drive(0.0, opening), y)
        });
    }
    let mut out = vec![Vec::new(); 4];
    for i in 0..samples {
        let time_s = i as f64 * SAMPLING_S;
        let mut now = bench.outputs(&drive(time_s, plug.follow(valve.at(time_s))), &y);
        match bench.hidden {
            Some(Hidden::LevelDrift { per_hour_m }) => now[0] += per_hour_m * time_s / 3600.0,
            Some(Hidden::EchoOfTheValve { level_m, delay_s }) => {
                let away = (valve.at(time_s - delay_s) - 0.55) / 0.3;
                now[0] += level_m * away * away;
            }
            _ => {}
        }
        for (column, value) in out.iter_mut().zip(now) {
            column.push(value);
        }
        for k in 0..per_sample {
            let at = time_s + k as f64 * Surge::STEP_S;
            // Where the plug follows at once, it moves within a step too.
            let lag = plug.follow(valve.at(at)) - valve.at(at);
            y = rk4(&y, at, Surge::STEP_S, |t, y| {
                bench.rates(&drive(t, valve.at(t) + lag), y)
            });
        }
    }
    out
}

fn circuit_run(bench: &Circuit, programmes: &[Programme], samples: usize) -> Vec<Vec<f64>> {
    let (speed, needle) = (&programmes[0], &programmes[1]);
    let mut plug = Plug {
        hidden: bench.hidden,
        opening: needle.at(0.0),
    };
    let per_sample = steps(SAMPLING_S, Circuit::STEP_S);
    let mut y = bench.start();
    // Nothing has warmed up, steamed away or gone round before time zero.
    let still = circuit::Drive {
        time_s: -1.0,
        speed_rpm: speed.at(0.0),
        opening: needle.at(0.0),
    };
    for _ in 0..steps(RUN_UP_S, Circuit::STEP_S) {
        y = rk4(&y, 0.0, Circuit::STEP_S, |_, y| bench.rates(&still, y));
    }
    y[4] = 0.0;
    let mut metered = y[1];
    let mut out = vec![Vec::new(); 4];
    for i in 0..samples {
        let time_s = i as f64 * SAMPLING_S;
        let mut now = Circuit::outputs(&y);
        if let Some(Hidden::MeterLag { .. }) = bench.hidden {
            now[1] = metered;
        }
        for (column, value) in out.iter_mut().zip(now) {
            column.push(value);
        }
        for k in 0..per_sample {
            let at = time_s + k as f64 * Circuit::STEP_S;
            let lag = plug.follow(needle.at(at)) - needle.at(at);
            let past = y[1];
            y = rk4(&y, at, Circuit::STEP_S, |t, y| {
                let drive = circuit::Drive {
                    time_s: t,
                    speed_rpm: speed.at(t),
                    opening: needle.at(t) + lag,
                };
                bench.rates(&drive, y)
            });
            if let Some(Hidden::MeterLag { time_constant_s }) = bench.hidden {
                let keep = (-Circuit::STEP_S / time_constant_s).exp();
                metered = keep * metered + (1.0 - keep) * 0.5 * (past + y[1]);
            }
        }
    }
    out
}
