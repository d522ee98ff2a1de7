//! The windows of a recording simulated: tables, errors and JSON of them.

use super::columns::Recorded;
use super::{Gauge, clock, column, failed, gauges, trouble};
use crate::failure::Failure;
use crate::say;
use dgd_assembly::{Assembly, Simulation, SimulationOptions, Window};
use dgd_recording::Table;
use serde_json::{Value, json};
use std::path::Path;

/// One window, measured and simulated.
pub(crate) struct Run {
    pub(crate) held_out: bool,
    /// From 1, training windows first.
    pub(crate) number: usize,
    pub(crate) window: Window,
    pub(crate) simulation: Simulation,
}

/// Simulates every window with the parameters `theta`.
pub(crate) fn simulate(
    assembly: &Assembly,
    theta: &[f64],
    recorded: &Recorded,
    options: &SimulationOptions,
    (system, recording): (&Path, &Path),
) -> Result<Vec<Run>, Failure> {
    let mut runs: Vec<Run> = Vec::new();
    let train = recorded.train.iter().enumerate();
    let train = train.map(|(k, window)| (false, k, window, window));
    let test = recorded.test.iter().map(|held| {
        let (start, run) = held.run(assembly);
        (true, start, run, &held.window)
    });
    for (held_out, start, run, window) in train.chain(test) {
        let mut simulation = assembly
            .simulate(theta, run, start, options)
            .map_err(|e| failed(system, recording, &e))?;
        keep_tail(&mut simulation, window.time.len());
        let number = runs.len() + 1;
        if let Some(trouble) = trouble(simulation.status) {
            tracing::warn!("window {number} could not be simulated to its end: {trouble}");
        }
        for (state, values) in assembly.states().iter().zip(&simulation.states) {
            let torn = values.iter().position(|v| *v < 0.0);
            if let Some(at) = torn.filter(|_| state.ends_with(".pressure")) {
                tracing::warn!(
                    "window {number}: {state} falls below vacuum at {} {}, where no line stays full; what follows is not physics",
                    say::brief(simulation.time[at]),
                    clock(assembly).1.unwrap_or_default()
                );
            }
        }
        for (tank, at, full) in &simulation.held {
            let what = if *full {
                "reaches its brim, from where on what is too much spills,"
            } else {
                "reaches its floor, from where on what flows out comes from nowhere,"
            };
            tracing::warn!(
                "window {number}: {tank} {what} at {} {}",
                say::brief(*at),
                clock(assembly).1.unwrap_or_default()
            );
        }
        runs.push(Run {
            held_out,
            number,
            window: window.clone(),
            simulation,
        });
    }
    Ok(runs)
}

/// Leaves the last samples of a run.
fn keep_tail(run: &mut Simulation, samples: usize) {
    let first = run.time.len().saturating_sub(samples);
    let all = run.outputs.iter_mut().chain(&mut run.states);
    for values in all.chain([&mut run.time]) {
        values.drain(..first.min(values.len()));
    }
    let from = run.time.first().copied().unwrap_or(f64::INFINITY);
    run.held.retain(|(_, time, _)| *time >= from);
}

/// Simulated less measured of one instrument, NaN where either is missing.
pub(crate) fn residual(run: &Run, output: usize) -> Vec<f64> {
    let simulated = &run.simulation.outputs[output];
    match run.window.readings.get(output) {
        Some(measured) if !measured.is_empty() => {
            simulated.iter().zip(measured).map(|(s, m)| s - m).collect()
        }
        _ => vec![f64::NAN; simulated.len()],
    }
}

/// Root mean square of the residuals of one instrument and the readings it is of.
pub(crate) fn rms(runs: &[Run], held_out: bool, output: usize) -> (f64, usize) {
    let part = runs.iter().filter(|r| r.held_out == held_out);
    let squares: Vec<f64> = part
        .flat_map(|r| residual(r, output))
        .filter(|r| r.is_finite())
        .map(|r| r * r)
        .collect();
    #[expect(clippy::cast_precision_loss, reason = "sample counts")]
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    (mean.sqrt(), squares.len())
}

/// Instruments whose training readings a run is further off than their own mean would be, each in a sentence.
pub(crate) fn worse_than_the_mean(assembly: &Assembly, runs: &[Run]) -> Vec<String> {
    let fitted = || runs.iter().filter(|r| !r.held_out);
    let readings = |o: usize| {
        let pairs = fitted().filter_map(move |r| {
            let measured = r.window.readings.get(o)?;
            Some(
                measured
                    .iter()
                    .copied()
                    .zip(r.simulation.outputs[o].iter().copied()),
            )
        });
        pairs.flatten()
    };
    doubted(assembly, readings)
}

/// The same of readings, each with what a model makes of it.
pub(crate) fn doubted<I: Iterator<Item = (f64, f64)>>(
    assembly: &Assembly,
    readings: impl Fn(usize) -> I,
) -> Vec<String> {
    /// A fit can always come near the mean; well beyond it something is wrong.
    const WORSE: f64 = 1.5;
    let one = |(o, gauge): (usize, Gauge)| {
        let both: Vec<(f64, f64)> = readings(o)
            .filter(|(measured, simulated)| measured.is_finite() && simulated.is_finite())
            .collect();
        #[expect(clippy::cast_precision_loss, reason = "sample counts")]
        let n = both.len() as f64;
        let rms = |of: &dyn Fn(&(f64, f64)) -> f64| {
            (both.iter().map(|pair| of(pair).powi(2)).sum::<f64>() / n).sqrt()
        };
        let mean = both.iter().map(|(measured, _)| measured).sum::<f64>() / n;
        let spread = rms(&|(measured, _)| measured - mean);
        let off = rms(&|(measured, simulated)| simulated - measured);
        // What hardly moves has no mean to be worse than.
        let accuracy = assembly.accuracies()[o].unwrap_or(0.0);
        (spread > 0.0 && off > WORSE * spread && off > accuracy).then(|| {
            let told = |si: f64| gauge.with_unit(&say::number(gauge.difference(si)));
            format!(
                "`{}` has an error of {}, against {} for its own mean: the model does not explain it; are units and channels right?",
                gauge.name,
                told(off),
                told(spread)
            )
        })
    };
    gauges(assembly)
        .into_iter()
        .enumerate()
        .filter_map(one)
        .collect()
}

/// Whether an instrument was recorded at all.
pub(crate) fn recorded(runs: &[Run], output: usize) -> bool {
    let readings = runs.iter().filter_map(|r| r.window.readings.get(output));
    readings.flatten().any(|v| v.is_finite())
}

/// Columns `t` (or the independent variable), `window`, `held_out`, then measured and simulated of each instrument in its unit.
pub(crate) fn table(assembly: &Assembly, runs: &[Run]) -> Table {
    let (clock, unit) = clock(assembly);
    let of_windows = |value: fn(&Run) -> f64| -> Vec<f64> {
        let each = runs.iter();
        each.flat_map(|r| std::iter::repeat_n(value(r), r.window.time.len()))
            .collect()
    };
    #[expect(clippy::cast_precision_loss, reason = "a count of windows")]
    let mut columns = vec![
        column(
            clock,
            unit,
            runs.iter().flat_map(|r| r.window.time.clone()).collect(),
        ),
        column("window", None, of_windows(|r| r.number as f64)),
        column(
            "held_out",
            None,
            of_windows(|r| f64::from(u8::from(r.held_out))),
        ),
    ];
    for (output, gauge) in gauges(assembly).iter().enumerate() {
        let unit = (!gauge.symbol.is_empty()).then(|| gauge.symbol.clone());
        if recorded(runs, output) {
            let values = runs
                .iter()
                .flat_map(|r| measured(r, output, gauge))
                .collect();
            columns.push(column(
                &format!("{}_measured", gauge.name),
                unit.clone(),
                values,
            ));
        }
        let values = runs
            .iter()
            .flat_map(|r| simulated(r, output, gauge))
            .collect();
        columns.push(column(&format!("{}_simulated", gauge.name), unit, values));
    }
    Table {
        columns,
        ..Table::default()
    }
}

/// Readings of one instrument in its unit; NaN where there is none.
pub(crate) fn measured(run: &Run, output: usize, gauge: &Gauge) -> Vec<f64> {
    match run.window.readings.get(output) {
        Some(values) if !values.is_empty() => values.iter().map(|v| gauge.shown(*v)).collect(),
        _ => vec![f64::NAN; run.window.time.len()],
    }
}

/// The same, simulated.
pub(crate) fn simulated(run: &Run, output: usize, gauge: &Gauge) -> Vec<f64> {
    let values = run.simulation.outputs[output].iter();
    values.map(|v| gauge.shown(*v)).collect()
}

/// Errors of each instrument, in its unit.
pub(crate) fn errors_as_json(assembly: &Assembly, runs: &[Run]) -> Value {
    let part = |output: usize, gauge: &Gauge, held_out: bool| {
        let (rms, samples) = rms(runs, held_out, output);
        json!({ "rms": gauge.difference(rms), "samples": samples })
    };
    gauges(assembly)
        .iter()
        .enumerate()
        .map(|(output, gauge)| {
            json!({
                "name": gauge.name,
                "measures": gauge.measures,
                "unit": gauge.symbol,
                "train": part(output, gauge, false),
                "test": part(output, gauge, true),
            })
        })
        .collect()
}

/// Windows with their span, how they ended, and where tanks ran full or empty.
pub(crate) fn windows_as_json(runs: &[Run]) -> Value {
    let held = |run: &Run| -> Value {
        let held = run.simulation.held.iter();
        held.map(|(state, time, full)| {
            json!({ "state": state, "from": time, "at": if *full { "brim" } else { "floor" } })
        })
        .collect()
    };
    runs.iter()
        .map(|run| {
            let time = &run.window.time;
            json!({
                "window": run.number,
                "held_out": run.held_out,
                "from": time.first(),
                "to": time.last(),
                "samples": time.len(),
                "ended": trouble(run.simulation.status).unwrap_or_else(|| "finished".into()),
                "held": held(run),
            })
        })
        .collect()
}
