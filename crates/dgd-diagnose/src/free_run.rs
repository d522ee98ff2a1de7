//! Free runs of both models, and what the findings gain on held-out windows.

use crate::diagnosis::{DiagnoseError, HeldOut, Signal, Simulation};
use crate::numbers::{bridged, mean, tails};
use crate::record::Record;
use dgd_effects::{AugmentedModel, Inputs, UnknownEffect};
use dgd_identify::Prepared;
use dgd_recording::Well;
use std::ops::Range;

/// Free runs over the whole recording, window by window.
pub(crate) fn simulate(
    well: &Well,
    record: &Record,
    prepared: &Prepared,
    windows: &[(f64, f64)],
    before: &AugmentedModel,
    after: &AugmentedModel,
) -> Result<Simulation, DiagnoseError> {
    let recording = &prepared.recording;
    let n = recording.time_s.len();
    let t_s = recording.time_s.clone();
    let held: Vec<bool> = t_s
        .iter()
        .map(|t| {
            // Windows ascend: of those that end later, the first begins first.
            let next = windows.partition_point(|w| w.1 <= *t);
            windows.get(next).is_some_and(|w| *t >= w.0)
        })
        .collect();
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
    let levels = |inlet: &[f64]| -> Vec<f64> { inlet.iter().map(|p| well.level_m(*p)).collect() };
    let heads = |outlet: &[f64], inlet: &[f64]| -> Vec<f64> {
        let pairs = outlet.iter().zip(inlet);
        pairs.map(|(o, i)| well.head_m(*i, *o)).collect()
    };
    let nan = || vec![f64::NAN; n];
    // Stretches with the states that they start from.
    let mut stretches: Vec<(Range<usize>, (f64, f64))> = Vec::new();
    let mut i = 0;
    while i < n {
        let mut end = i + 1;
        while end < n && held[end] == held[i] && t_s[end] - t_s[i] < 3600.0 {
            end += 1;
        }
        // From the first sample with a state to start from.
        let first = (i..end).find(|k| {
            prepared.inlet_pressure_pa[*k].is_finite() && recording.return_flow_m3_s[*k].is_finite()
        });
        if let Some(first) = first {
            let few = first..(first + 5).min(end);
            let state = (
                mean(&prepared.inlet_pressure_pa[few.clone()]),
                mean(&recording.return_flow_m3_s[few]).max(0.0),
            );
            stretches.push((first..end, state));
        }
        i = end;
    }
    let run = |model: &AugmentedModel| -> Result<[Vec<f64>; 3], UnknownEffect> {
        let mut out = [nan(), nan(), nan()];
        let runs = model.free_runs(&record.setting, inputs, &stretches)?;
        for ((stretch, _), run) in stretches.iter().zip(runs) {
            let signals = [run.return_flow_m3_s, run.inlet_pa, run.outlet_pa];
            for (all, one) in out.iter_mut().zip(&signals) {
                all[stretch.clone()].copy_from_slice(one);
            }
        }
        Ok(out)
    };
    // Each goes through the recording once; both at a time.
    let (before, after) = rayon::join(|| run(before), || run(after));
    let ([flow_before, inlet_before, outlet_before], [flow_after, inlet_after, outlet_after]) =
        (before?, after?);
    let inlet = &prepared.inlet_pressure_pa;
    let outlet = &prepared.outlet_pressure_pa;
    let (levels, heads) = (
        Signal {
            name: "riser_level_m",
            measured: levels(inlet),
            before: levels(&inlet_before),
            after: levels(&inlet_after),
        },
        Signal {
            name: "pump_head_m",
            measured: heads(outlet, inlet),
            before: heads(&outlet_before, &inlet_before),
            after: heads(&outlet_after, &inlet_after),
        },
    );
    let signals = vec![
        Signal {
            name: "return_flow_m3_s",
            measured: recording.return_flow_m3_s.clone(),
            before: flow_before,
            after: flow_after,
        },
        levels,
        Signal {
            name: "pump_outlet_pressure_pa",
            measured: outlet.clone(),
            before: outlet_before,
            after: outlet_after,
        },
        heads,
    ];
    Ok(Simulation {
        t_s,
        held_out: held,
        valid: prepared.keep.clone(),
        signals,
    })
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

/// Errors by signal; `None` of one that has no sample there.
pub(crate) fn errors(simulation: &Simulation, part: Part) -> Vec<Option<Errors>> {
    let of = |signal: &Signal| {
        let stretches = stretches(simulation, signal, part);
        (!stretches.is_empty()).then(|| Sums::errors(&stretches))
    };
    simulation.signals.iter().map(of).collect()
}

/// The signal that gains most on the held-out windows, with an interval by a bootstrap over stretches, which keeps what hangs together.
pub(crate) fn best_gain(simulation: &Simulation) -> Option<HeldOut> {
    let errors = errors(simulation, Part::HeldOut).into_iter();
    let judged = (errors.zip(&simulation.signals)).filter_map(|(e, signal)| Some((e?, signal)));
    let (best, signal) = judged.min_by(|(a, _), (b, _)| a.left().total_cmp(&b.left()))?;
    Some(HeldOut {
        signal: signal.name.to_owned(),
        rmse_before: best.before,
        rmse_after: best.after,
        improvement_ci95: interval(&stretches(simulation, signal, Part::HeldOut)),
    })
}

/// 95 % interval of the share of an error that was saved, by drawing some stretches again and again.
fn interval(stretches: &[Sums]) -> (f64, f64) {
    // A xorshift: the draws need no more, and are the same on every run.
    let mut seed = 88_172_645_463_325_252_u64;
    let mut pick = || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        &stretches[usize::try_from(seed % stretches.len() as u64).unwrap_or(0)]
    };
    let draws: Vec<f64> = (0..400)
        .map(|_| {
            let drawn: Vec<&Sums> = stretches.iter().map(|_| pick()).collect();
            1.0 - Sums::errors(drawn).left()
        })
        .collect();
    // One in forty on either side leaves 95 %.
    tails(&draws, 40).unwrap_or((f64::NAN, f64::NAN))
}

#[cfg(test)]
mod tests;
