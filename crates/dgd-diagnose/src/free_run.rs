//! Free runs of both models, and what the findings gain on held-out windows.

use crate::diagnosis::{DiagnoseError, HeldOut, Signal, Simulation};
use crate::held_out::ends_after;
use crate::numbers::{bridged, mean, tails};
use crate::record::Record;
use dgd_effects::{AugmentedModel, FreeRun, Inputs, START_S, Setting, UnknownEffect};
use dgd_identify::Prepared;
use dgd_recording::Well;
use std::ops::Range;

/// Samples that are run in one go, and the state that they start from: inlet pressure, Pa absolute, and line flow, m³/s.
type Run = (Range<usize>, (f64, f64));

/// Free runs of both models over the whole recording, window by window.
pub(crate) fn simulate(
    well: &Well,
    record: &Record,
    prepared: &Prepared,
    windows: &[(f64, f64)],
    before: &AugmentedModel,
    after: &AugmentedModel,
) -> Result<Simulation, DiagnoseError> {
    let recording = &prepared.recording;
    let held_out = samples_within(&recording.time_s, windows);
    let runs = runs(prepared, &held_out);
    let [mud, booster, topfill, speed] = [
        &recording.mud_pump_flow_m3_s,
        &recording.booster_flow_m3_s,
        &recording.topfill_flow_m3_s,
        &recording.pump_speed_pct,
    ]
    .map(|v| bridged(v));
    let inputs = Inputs {
        time_s: &recording.time_s,
        step_s: prepared.step_s,
        mud_pump_m3_s: &mud,
        booster_m3_s: &booster,
        topfill_m3_s: &topfill,
        speed_pct: &speed,
    };
    // Each model goes through the recording once; both at a time.
    let run = |model| free_run(model, &record.setting, inputs, &runs);
    let (before, after) = rayon::join(|| run(before), || run(after));
    let measured = FreeRun {
        return_flow_m3_s: recording.return_flow_m3_s.clone(),
        inlet_pa: prepared.inlet_pressure_pa.clone(),
        outlet_pa: prepared.outlet_pressure_pa.clone(),
    };
    Ok(Simulation {
        signals: signals(well, &measured, &before?, &after?),
        t_s: recording.time_s.clone(),
        held_out,
        valid: prepared.keep.clone(),
    })
}

/// Which samples lie in any of some windows, s, which ascend.
fn samples_within(t_s: &[f64], windows: &[(f64, f64)]) -> Vec<bool> {
    let within = |t: &f64| ends_after(windows, *t).is_some_and(|w| *t >= w.0);
    t_s.iter().map(within).collect()
}

/// What is run in one go: within a held-out window or between two, from the first sample with a measured state.
fn runs(prepared: &Prepared, held_out: &[bool]) -> Vec<Run> {
    /// Length of a run, s, at the most; the next starts from a measured state again. Set by hand.
    const LONGEST_S: f64 = 3600.0;
    let t_s = &prepared.recording.time_s;
    let (inlet, flow) = (
        &prepared.inlet_pressure_pa,
        &prepared.recording.return_flow_m3_s,
    );
    let mut out = Vec::new();
    let mut from = 0;
    while from < t_s.len() {
        let mut to = from + 1;
        while to < t_s.len() && held_out[to] == held_out[from] && t_s[to] - t_s[from] < LONGEST_S {
            to += 1;
        }
        let first = (from..to).find(|k| inlet[*k].is_finite() && flow[*k].is_finite());
        if let Some(first) = first {
            let few = t_s[first..to].iter();
            let few = few.take_while(|t| **t - t_s[first] < START_S).count();
            let few = first..first + few;
            let state = (mean(&inlet[few.clone()]), mean(&flow[few]).max(0.0));
            out.push((first..to, state));
        }
        from = to;
    }
    out
}

/// A model's free runs one after the other; NaN where none runs.
fn free_run(
    model: &AugmentedModel,
    setting: &Setting,
    inputs: Inputs<'_>,
    runs: &[Run],
) -> Result<FreeRun, UnknownEffect> {
    let nan = || vec![f64::NAN; inputs.time_s.len()];
    let mut all = FreeRun {
        return_flow_m3_s: nan(),
        inlet_pa: nan(),
        outlet_pa: nan(),
    };
    let simulated = model.free_runs(setting, inputs, runs)?;
    for ((samples, _), one) in runs.iter().zip(simulated) {
        let at = samples.clone();
        all.return_flow_m3_s[at.clone()].copy_from_slice(&one.return_flow_m3_s);
        all.inlet_pa[at.clone()].copy_from_slice(&one.inlet_pa);
        all.outlet_pa[at].copy_from_slice(&one.outlet_pa);
    }
    Ok(all)
}

/// The signals in which both models are held against the recording.
fn signals(well: &Well, measured: &FreeRun, before: &FreeRun, after: &FreeRun) -> Vec<Signal> {
    let signal = |name, of: &dyn Fn(&FreeRun) -> Vec<f64>| Signal {
        name,
        measured: of(measured),
        before: of(before),
        after: of(after),
    };
    let level = |run: &FreeRun| run.inlet_pa.iter().map(|p| well.level_m(*p)).collect();
    let head = |run: &FreeRun| {
        let pressures = run.inlet_pa.iter().zip(&run.outlet_pa);
        pressures.map(|(i, o)| well.head_m(*i, *o)).collect()
    };
    vec![
        signal("return_flow_m3_s", &|run| run.return_flow_m3_s.clone()),
        signal("riser_level_m", &level),
        signal("pump_outlet_pressure_pa", &|run| run.outlet_pa.clone()),
        signal("pump_head_m", &head),
    ]
}

/// Errors of a free run of one signal (RMSE) without the findings and with them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Errors {
    pub before: f64,
    pub after: f64,
}

impl Errors {
    /// Share of the error that is left.
    pub(crate) fn left(self) -> f64 {
        self.after / self.before.max(1e-12)
    }
}

/// Which samples of a free run are judged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Part {
    HeldOut,
    Training,
}

/// Sums of squared errors before and after over what hangs together, and its samples.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    before: f64,
    after: f64,
    samples: f64,
}

impl Sums {
    /// RMSE over all of some stretches.
    fn errors<'a>(stretches: impl IntoIterator<Item = &'a Self>) -> Errors {
        let mut all = Self::default();
        for one in stretches {
            all.before += one.before;
            all.after += one.after;
            all.samples += one.samples;
        }
        let rmse = |sum: f64| (sum / all.samples.max(1.0)).sqrt();
        Errors {
            before: rmse(all.before),
            after: rmse(all.after),
        }
    }
}

/// Stretches of five minutes of the samples that are judged.
fn stretches(simulation: &Simulation, signal: &Signal, part: Part) -> Vec<Sums> {
    const LENGTH_S: f64 = 300.0;
    let mut out: Vec<Sums> = Vec::new();
    let mut begun = f64::NEG_INFINITY;
    for i in 0..simulation.t_s.len() {
        let (m, b, a) = (signal.measured[i], signal.before[i], signal.after[i]);
        let chosen = simulation.held_out[i] == (part == Part::HeldOut) && simulation.valid[i];
        if !(chosen && (m + b + a).is_finite()) {
            continue;
        }
        if simulation.t_s[i] - begun > LENGTH_S {
            out.push(Sums::default());
            begun = simulation.t_s[i];
        }
        if let Some(stretch) = out.last_mut() {
            stretch.before += (m - b).powi(2);
            stretch.after += (m - a).powi(2);
            stretch.samples += 1.0;
        }
    }
    out
}

/// Errors of a signal; `None` of one that has no sample there.
pub(crate) fn errors_of(simulation: &Simulation, signal: &Signal, part: Part) -> Option<Errors> {
    let stretches = stretches(simulation, signal, part);
    (!stretches.is_empty()).then(|| Sums::errors(&stretches))
}

/// Errors by signal.
pub(crate) fn errors(simulation: &Simulation, part: Part) -> Vec<Option<Errors>> {
    let of = |signal: &Signal| errors_of(simulation, signal, part);
    simulation.signals.iter().map(of).collect()
}

/// The signal that gains most on the held-out windows, or where none gains the one that loses most, with an interval by a bootstrap
/// over stretches, which keeps what hangs together.
pub(crate) fn headline_gain(simulation: &Simulation) -> Option<HeldOut> {
    let errors = errors(simulation, Part::HeldOut).into_iter();
    let judged: Vec<(Errors, &Signal)> = (errors.zip(&simulation.signals))
        .filter_map(|(e, signal)| Some((e?, signal)))
        .collect();
    let by_share =
        |a: &&(Errors, &Signal), b: &&(Errors, &Signal)| a.0.left().total_cmp(&b.0.left());
    let best = judged.iter().min_by(by_share)?;
    let (best, signal) = if best.0.left() < 1.0 {
        best
    } else {
        judged.iter().max_by(by_share)?
    };
    Some(HeldOut {
        signal: signal.name.to_owned(),
        rmse_before: best.before,
        rmse_after: best.after,
        improvement_ci95: interval(&stretches(simulation, signal, Part::HeldOut)),
    })
}

/// 95 % interval of the share of an error that was saved, by drawing some stretches again and again.
fn interval(stretches: &[Sums]) -> (f64, f64) {
    /// Draws of the bootstrap. Set by hand.
    const DRAWS: usize = 400;
    /// One in forty on either side leaves 95 %.
    const TAIL: usize = 40;
    // A xorshift: the draws need no more, and are the same on every run.
    let mut seed = 88_172_645_463_325_252_u64;
    let mut pick = || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        &stretches[usize::try_from(seed % stretches.len() as u64).unwrap_or(0)]
    };
    let draws: Vec<f64> = (0..DRAWS)
        .map(|_| {
            let drawn: Vec<&Sums> = stretches.iter().map(|_| pick()).collect();
            1.0 - Sums::errors(drawn).left()
        })
        .collect();
    tails(&draws, TAIL).unwrap_or((f64::NAN, f64::NAN))
}

#[cfg(test)]
mod tests;
