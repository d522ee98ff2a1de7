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

/// RMSE before and after on held-out samples by signal; with a signal, its bootstrap interval too.
pub(crate) fn gains(simulation: &Simulation, held_out: bool) -> Vec<(f64, f64, (f64, f64))> {
    simulation
        .signals
        .iter()
        .map(|s| {
            // Sums by stretches of five minutes, for a bootstrap that keeps what hangs together.
            let mut blocks: Vec<(f64, f64, f64)> = Vec::new();
            let mut last = f64::NEG_INFINITY;
            for i in 0..simulation.t_s.len() {
                let (m, b, a) = (s.measured[i], s.before[i], s.after[i]);
                let chosen = simulation.held_out[i] == held_out && simulation.valid[i];
                if !(chosen && (m + b + a).is_finite()) {
                    continue;
                }
                if simulation.t_s[i] - last > 300.0 {
                    blocks.push((0.0, 0.0, 0.0));
                    last = simulation.t_s[i];
                }
                if let Some(block) = blocks.last_mut() {
                    block.0 += (m - b).powi(2);
                    block.1 += (m - a).powi(2);
                    block.2 += 1.0;
                }
            }
            let rmse = |pick: &dyn Fn(usize) -> usize| -> (f64, f64) {
                let (mut b, mut a, mut n) = (0.0, 0.0, 0.0);
                for k in 0..blocks.len() {
                    let block = blocks[pick(k)];
                    b += block.0;
                    a += block.1;
                    n += block.2;
                }
                ((b / f64::max(n, 1.0)).sqrt(), (a / f64::max(n, 1.0)).sqrt())
            };
            if blocks.is_empty() {
                return (f64::NAN, f64::NAN, (f64::NAN, f64::NAN));
            }
            let (before, after) = rmse(&|k| k);
            // A xorshift: the draws need no more, and are the same on every run.
            let mut seed = 88_172_645_463_325_252_u64;
            let draws: Vec<f64> = (0..400)
                .map(|_| {
                    let picks: Vec<usize> = (0..blocks.len())
                        .map(|_| {
                            seed ^= seed << 13;
                            seed ^= seed >> 7;
                            seed ^= seed << 17;
                            usize::try_from(seed % blocks.len() as u64).unwrap_or(0)
                        })
                        .collect();
                    let (b, a) = rmse(&|k| picks[k]);
                    1.0 - a / b.max(1e-12)
                })
                .collect();
            // One in forty on either side leaves 95 %.
            (
                before,
                after,
                tails(&draws, 40).unwrap_or((f64::NAN, f64::NAN)),
            )
        })
        .collect()
}

/// The signal that gains most on the held-out windows.
pub(crate) fn best_gain(simulation: &Simulation) -> Option<HeldOut> {
    gains(simulation, true)
        .into_iter()
        .zip(&simulation.signals)
        .filter(|(g, _)| g.0.is_finite() && g.1.is_finite())
        .min_by(|(a, _), (b, _)| (a.1 / a.0.max(1e-12)).total_cmp(&(b.1 / b.0.max(1e-12))))
        .map(|((before, after, ci), signal)| HeldOut {
            signal: signal.name.to_owned(),
            rmse_before: before,
            rmse_after: after,
            improvement_ci95: ci,
        })
}

#[cfg(test)]
mod tests;
