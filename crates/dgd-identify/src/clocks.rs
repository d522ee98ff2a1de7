//! Whether the channels share one clock, by the delay between flow and pressure.

use crate::{IdentifyOptions, Prepared};
use dgd_friction::{DelaySweep, Minimum, Samples, SweepOptions, Terms, delay_sweep};
use dgd_pump::Samples as PumpSamples;
use std::ops::{Range, RangeInclusive};

/// Kept samples of each half that are looked at; they are spread over it in runs.
const LOOKED_AT: usize = 20_000;
/// Rows that speed and inflow are looked at in, over the whole recording.
const ROWS: usize = LOOKED_AT / 4;
/// Seconds by which the delays of two halves may differ: delays vary with the flow.
const APART_S: f64 = 15.0;
/// Seconds below 0 in which a flow that is ahead of its pressure is looked for.
const AHEAD_S: f64 = 60.0;

/// Warns where the delay found is no delay of a meter: where it is another one in the second half of
/// the recording, or less than nothing.
pub(crate) fn warn_of_clocks(
    samples: &Samples<'_>,
    step_s: f64,
    best_s: f64,
    options: &IdentifyOptions,
    warnings: &mut Vec<String>,
) {
    if options.delays.start() == options.delays.end() {
        return; // the caller knows the delay
    }
    if best_s == 0.0
        && *options.delays.start() == 0
        && let Some(ahead_s) = ahead(samples, step_s)
    {
        warnings.push(format!(
            "the return flow is {ahead} s ahead of the pressures, which is impossible for a meter: do the channels share one clock? If not, set \
             `late` beside their tags in the well description: {ahead} s or more for the pressures, -{ahead} s or less for the return flow",
            ahead = -ahead_s
        ));
        return;
    }
    let of = |half| in_half(samples, half, step_s, options);
    if let (Some(early), Some(late)) = &rayon::join(|| of(0), || of(1)) {
        let (a, b) = (early.refined_delay_s, late.refined_delay_s);
        let apart_s = APART_S.max(2.0 * step_s);
        if (a - b).abs() > apart_s && told_apart(early, late.best) && told_apart(late, early.best) {
            warnings.push(format!(
                "the delay is {a:.0} s in the first half of the recording and {b:.0} s in the second: does the clock of the return flow run at the \
                 same rate as the others?"
            ));
        }
    }
}

/// Whether a half's own delay fits its samples better than the other half's by more than noise.
fn told_apart(sweep: &DelaySweep, other: usize) -> bool {
    const BETTER: f64 = 1.5;
    let n = sweep.n[sweep.best].max(1) as f64;
    let own = sweep.mse_pa2[sweep.best];
    let others = sweep.mse_pa2.get(other).copied().unwrap_or(f64::NAN);
    others > own * BETTER.max(1.0 + 6.0 * (2.0 / n).sqrt())
}

/// A delay below 0 that fits better than 0 by more than noise, s.
fn ahead(samples: &Samples<'_>, step_s: f64) -> Option<f64> {
    #[expect(clippy::cast_possible_truncation, reason = "clamped")]
    let most = (AHEAD_S / step_s).round().clamp(2.0, 600.0) as i64;
    let settings = SweepOptions {
        delays: -most..=0,
        dt_s: step_s,
        ..SweepOptions::default()
    };
    let thin = thinned(samples, 0..samples.keep.len(), &settings.delays);
    let sweep = delay_sweep(&thin.samples(), &Terms::Quadratic, &settings).ok()?;
    let zero = sweep.delays_s.len() - 1;
    let clear = sweep.delays_s[sweep.best] < -1.5 * step_s && told_apart(&sweep, zero);
    clear.then_some(sweep.delays_s[sweep.best])
}

fn in_half(
    samples: &Samples<'_>,
    half: usize,
    step_s: f64,
    options: &IdentifyOptions,
) -> Option<DelaySweep> {
    let middle = samples.keep.len() / 2;
    let range = if half == 0 {
        0..middle
    } else {
        middle..samples.keep.len()
    };
    let settings = SweepOptions {
        delays: options.delays.clone(),
        dt_s: step_s,
        loss: dgd_friction::Loss::Squared,
    };
    let thin = thinned(samples, range, &settings.delays);
    let sweep = delay_sweep(&thin.samples(), &Terms::Quadratic, &settings).ok()?;
    // Where nothing moves the least error lies anywhere.
    let worst = sweep.mse_pa2.iter().copied().filter(|m| m.is_finite());
    let worst = worst.fold(0.0, f64::max);
    let flat = worst < 1.3 * sweep.mse_pa2[sweep.best];
    (!flat && sweep.minimum != Minimum::AtFirst).then_some(sweep)
}

/// Some stretches of a recording, one after the other.
struct Thinned {
    flow_m3_s: Vec<f64>,
    friction_pa: Vec<f64>,
    keep: Vec<bool>,
}

impl Thinned {
    fn samples(&self) -> Samples<'_> {
        Samples {
            flow_m3_s: &self.flow_m3_s,
            friction_pa: &self.friction_pa,
            keep: &self.keep,
            keep_delayed: false,
        }
    }
}

/// The kept samples of a range, in every so many runs of a minute's samples, with what the delays reach beside
/// each run: what is looked at does not grow with the recording.
fn thinned(samples: &Samples<'_>, range: Range<usize>, delays: &RangeInclusive<i64>) -> Thinned {
    const RUN: usize = 64;
    let every = range.len().div_ceil(LOOKED_AT).max(1);
    // All runs are one.
    let run = if every == 1 { range.end.max(1) } else { RUN };
    let (front, back) = (
        usize::try_from(delays.start().saturating_neg()).unwrap_or(0),
        usize::try_from(*delays.end()).unwrap_or(0),
    );
    let n = samples.keep.len();
    let mut out = Thinned {
        flow_m3_s: Vec::new(),
        friction_pa: Vec::new(),
        keep: Vec::new(),
    };
    for k in (range.start / run..range.end.div_ceil(run)).filter(|k| k.is_multiple_of(every)) {
        let here = (k * run).max(range.start)..((k + 1) * run).min(range.end);
        if !samples.keep[here.clone()].contains(&true) {
            continue;
        }
        let with_reach = here.start.saturating_sub(front)..(here.end + back).min(n);
        out.flow_m3_s
            .extend_from_slice(&samples.flow_m3_s[with_reach.clone()]);
        out.friction_pa
            .extend_from_slice(&samples.friction_pa[with_reach.clone()]);
        out.keep
            .extend(with_reach.map(|t| here.contains(&t) && samples.keep[t]));
    }
    out
}

/// Warns where the head moves before the pump speed does: a pump may be late, its speed cannot be.
pub(crate) fn warn_of_speed(samples: &PumpSamples<'_>, step_s: f64, warnings: &mut Vec<String>) {
    /// Seconds that are tried: enough to tell, few enough to cost nothing.
    const LATE_S: [f64; 7] = [5.0, 10.0, 15.0, 20.0, 30.0, 45.0, 60.0];
    /// Mean square that a late speed must leave at the most, of the one now.
    const LEFT: f64 = 0.125;
    let n = samples.keep.len();
    let every = n.div_ceil(ROWS).max(1);
    let left = |late: usize| {
        let rows = n.checked_sub(late)?;
        // Gathered, so that a fit passes over these few alone.
        let looked_at = (0..rows).step_by(every);
        let kept = looked_at.filter(|t| samples.keep[*t] && samples.keep[t + late]);
        let kept: Vec<usize> = kept.collect();
        let of = |values: &[f64], late: usize| kept.iter().map(|t| values[t + late]).collect();
        let (speed_pct, flow_m3_s, head_m): (Vec<f64>, Vec<f64>, Vec<f64>) = (
            of(samples.speed_pct, late),
            of(samples.flow_m3_s, 0),
            of(samples.head_m, 0),
        );
        let shifted = PumpSamples {
            speed_pct: &speed_pct,
            flow_m3_s: &flow_m3_s,
            head_m: &head_m,
            keep: &vec![true; kept.len()],
        };
        let fit = dgd_pump::fit_unconstrained(&shifted, 2.0, 2.0).ok()?;
        (fit.n >= 100).then_some(fit.mse_m2)
    };
    let Some(now) = left(0) else {
        return;
    };
    if let Some((mse, late_s)) = latest(&LATE_S, step_s, left).filter(|(mse, _)| *mse < LEFT * now)
    {
        warnings.push(format!(
            "the head moves {late_s:.0} s before the recorded pump speed (aligned, the head curve fits {} times \
             better): {}",
            (now / mse).round(),
            one_clock(late_s, "its tag")
        ));
    }
}

/// Warns where the riser rises and falls before the inflow does: a string or a line may make it late, its meter cannot be.
///
/// The return flow's meter is late by `delay` samples.
pub(crate) fn warn_of_inflow(prepared: &Prepared, delay: i64, warnings: &mut Vec<String>) {
    /// Seconds that are tried.
    const LATE_S: [f64; 8] = [5.0, 10.0, 15.0, 20.0, 30.0, 45.0, 60.0, 90.0];
    /// Seconds over which the pressure's change is taken: enough for it to stand out of its noise.
    const BASE_S: f64 = 30.0;
    /// Mean square that a late inflow must leave at the most, of the one now.
    const LEFT: f64 = 0.6;
    /// Rows that tell anything.
    const FEWEST: u64 = 100;
    let (recording, step_s) = (&prepared.recording, prepared.step_s);
    let inlet_pa = &prepared.inlet_pressure_pa;
    let n = inlet_pa.len();
    let base = samples_of(BASE_S, step_s).max(1);
    // Of a few stretches: the whole series need not be made.
    let inflow = |t: usize| {
        recording.mud_pump_flow_m3_s[t]
            + recording.booster_flow_m3_s[t]
            + recording.topfill_flow_m3_s[t]
    };
    let delay = isize::try_from(delay).unwrap_or_default();
    let every = (n / ROWS).max(base.div_ceil(2)).max(1);
    let most = samples_of(LATE_S[LATE_S.len() - 1], step_s);
    // The same rows for all, so that they can be compared; of each the inflow is summed up to each of its samples.
    let (mut rises, mut outflows, mut summed) = (Vec::new(), Vec::new(), Vec::new());
    let reach = base + most;
    for t in (0..n.saturating_sub(reach)).step_by(every) {
        let rise = inlet_pa[t + base] - inlet_pa[t];
        let late = t.checked_add_signed(delay).filter(|t| t + base <= n);
        let out = late.map_or(f64::NAN, |late| {
            recording.return_flow_m3_s[late..late + base].iter().sum()
        });
        let mut sum = 0.0;
        summed.push(sum);
        for t in t..t + reach {
            sum += inflow(t);
            summed.push(sum);
        }
        if (rise + out + sum).is_finite() {
            rises.push(rise);
            outflows.push(out);
        } else {
            summed.truncate(rises.len() * (reach + 1));
        }
    }
    let ones = vec![1.0; rises.len()];
    let left = |late: usize| {
        let rows = summed.chunks_exact(reach + 1);
        let inflows: Vec<f64> = rows.map(|row| row[late + base] - row[late]).collect();
        let mut sums = dgd_lsq::Accumulator::new(["inflow", "outflow", "rest"]).ok()?;
        sums.push_columns(&[&inflows, &outflows, &ones], &rises)
            .ok()?;
        let fit = sums.reduce().solve(1e6).ok()?;
        // More mud that flows in raises the pressure, or this is no balance.
        (fit.n >= FEWEST && fit.coefficients[0] > 0.0).then_some(fit.mse)
    };
    let Some(now) = left(0) else {
        return;
    };
    if let Some((mse, late_s)) = latest(&LATE_S, step_s, left).filter(|(mse, _)| *mse < LEFT * now)
    {
        warnings.push(format!(
            "the riser balance error is {:.0} % smaller with the inflow read {late_s:.0} s later than recorded, as if the level moved first: {}",
            100.0 * (1.0 - (mse / now).sqrt()),
            one_clock(late_s, "the tags of the inflows")
        ));
    }
}

/// Asks for the clock, and says what mends a channel that has one of its own.
fn one_clock(late_s: f64, tags: &str) -> String {
    format!(
        "do the channels share one clock? If not, set `late = \"{late_s:.0} s\"` beside {tags} in the well description"
    )
}

/// The seconds that leave least, with the mean square left: tried as they are given, then evenly, some 32 times at the most, between the neighbours of
/// the best.
///
/// - `left`: of so many samples.
fn latest(tried_s: &[f64], step_s: f64, left: impl Fn(usize) -> Option<f64>) -> Option<(f64, f64)> {
    /// Most that are tried around the best.
    const AROUND: usize = 32;
    let samples = |late_s: &f64| samples_of(*late_s, step_s);
    let best_of = |tried: &mut dyn Iterator<Item = usize>| {
        let tried = tried.filter(|late| *late > 0);
        let tried = tried.filter_map(|late| Some((left(late)?, late)));
        tried.min_by(|a, b| a.0.total_cmp(&b.0))
    };
    let (_, best) = best_of(&mut tried_s.iter().map(samples))?;
    let below = tried_s
        .iter()
        .map(samples)
        .filter(|late| *late < best)
        .max();
    let above = tried_s
        .iter()
        .map(samples)
        .filter(|late| *late > best)
        .min();
    let around = below.unwrap_or(0)..=above.unwrap_or(best);
    let stride = (around.end() - around.start()).div_ceil(AROUND).max(1);
    let (mse, late) = best_of(&mut around.step_by(stride).chain([best]))?;
    Some((mse, late as f64 * step_s))
}

/// Whole samples in so many seconds.
fn samples_of(seconds: f64, step_s: f64) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped"
    )]
    let samples = (seconds / step_s).round().clamp(0.0, 600.0) as usize;
    samples
}
