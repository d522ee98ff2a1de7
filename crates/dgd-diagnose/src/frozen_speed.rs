//! A pump speed that rests: an operator's set-point, or a reading that froze?

use crate::numbers::{Means, bridged, mean, whole};
use dgd_effects::{STANDING_M3_S, STANDING_PCT};
use std::ops::Range;

/// Shortest and longest rest that is looked at, s: below the first a reading repeats by chance, beyond the second
/// somebody holds it.
const REST_S: Range<f64> = 20.0..600.0;
/// Samples on either side of a rest that tell how often the reading repeats there.
const AROUND: usize = 300;
/// Chance of an honest rest, at a given sample, below which nothing is taken from it.
const CHANCE: f64 = 1e-6;
/// What the outlet loses at least as the flow dies, Pa, from mean to mean of so long, s: four times what transmitters wander by. Set by hand.
const FELL_PA: f64 = 2e4;
const FELL_S: f64 = 15.0;

/// A speed without the rests that are too long for its jitter and too short for an operator's.
///
/// Under a share p of samples that repeat their predecessor, m equal ones begin at a given sample with chance p^(m-1). A
/// set-point under automatic control jitters with the level's noise, and one that has frozen while the pump
/// overshoots looks like gas or wear. A set-point that hardly ever moves repeats so often that it keeps all its rests.
pub(crate) fn without_seldom_rest(speed_pct: &[f64], step_s: f64) -> Vec<f64> {
    let n = speed_pct.len();
    let rests: Vec<Range<usize>> = runs(speed_pct)
        .filter(|r| r.len() as f64 * step_s >= REST_S.start)
        .collect();
    // Running counts of samples outside long rests, and of those that repeat their predecessor.
    let mut counted = vec![true; n];
    for rest in &rests {
        counted[rest.clone()].fill(false);
    }
    let (mut samples, mut repeats) = (vec![0.0; n + 1], vec![0.0; n + 1]);
    for i in 0..n {
        let counts = counted[i] && speed_pct[i] > STANDING_PCT;
        let repeat = counts && i > 0 && speed_pct[i - 1] == speed_pct[i];
        samples[i + 1] = samples[i] + f64::from(counts);
        repeats[i + 1] = repeats[i] + f64::from(repeat);
    }
    let mut out = speed_pct.to_vec();
    for rest in rests {
        let held = rest.len() as f64 * step_s > REST_S.end;
        if held || speed_pct[rest.start] <= STANDING_PCT {
            continue;
        }
        let (from, to) = (
            rest.start.saturating_sub(AROUND),
            (rest.end + AROUND).min(n),
        );
        let share = (repeats[to] - repeats[from] + 1.0) / (samples[to] - samples[from] + 1.0);
        if (rest.len() - 1) as f64 * share.ln() < CHANCE.ln() {
            out[rest].fill(f64::NAN);
        }
    }
    out
}

/// A speed without gaps in which a stop begins where the return flow tells it, if the speed tells it late.
///
/// A set-point that jumps to standstill from a rest or a gap, while no mud has flowed for a while and the outlet lost its friction as the flow
/// died, had frozen. A meter that drops out leaves the outlet where it was.
///
/// - `speed_pct`: with its gaps; flow, m³/s, and outlet pressure, Pa, without. Shape `(n,)` each.
pub(crate) fn stopping_with_the_flow(
    speed_pct: &[f64],
    flow_m3_s: &[f64],
    outlet_pa: &[f64],
    dt_s: f64,
) -> Vec<f64> {
    let window = whole(FELL_S / dt_s).max(1);
    let level = |from: usize| mean(&outlet_pa[from..from + window]);
    let mut out = bridged(speed_pct);
    for stop in 1..speed_pct.len() {
        let stands = |w: f64| w <= STANDING_PCT;
        if !stands(speed_pct[stop]) || stands(speed_pct[stop - 1]) {
            continue;
        }
        // The sample of the jump may be a mean of both.
        let mut rests_at = f64::NAN;
        let rests = |i: &usize| {
            let w = speed_pct[*i];
            let rests = w.is_nan() || rests_at.is_nan() || w == rests_at;
            if *i + 1 < stop && !w.is_nan() {
                rests_at = w;
            }
            rests && flow_m3_s[*i] < STANDING_M3_S
        };
        let late = (0..stop).rev().take_while(rests).count();
        let died = stop - late;
        if late as f64 * dt_s < REST_S.start || late < 2 * window || died < 2 * window {
            continue;
        }
        if level(died - 2 * window) - level(died + window) > FELL_PA {
            out[died..stop].fill(speed_pct[stop]);
        }
    }
    out
}

/// A speed without the part of a rest that follows the step it rests over: the reading froze, and told that step when it was released.
///
/// A pump answers its speed within seconds, and where its lift changes little by at least the same share of its flow (affinity). A step at the end of a rest that the
/// flow does not answer, while it took such a step within the rest and kept it, is told late.
///
/// - `speed_pct` and `flow_m3_s`: as they are read, `step_s` apart. Shape `(n,)` each.
/// - `noise_m3_s`: of one reading of the flow.
pub(crate) fn without_late_steps(
    speed_pct: &[f64],
    flow_m3_s: &[f64],
    noise_m3_s: f64,
    step_s: f64,
) -> Vec<f64> {
    /// Time over which the flow is averaged on either side of a step, and which it takes to answer, s. Set by hand.
    const OVER_S: f64 = 8.0;
    const ANSWERS_S: f64 = 3.0;
    /// Longest time by which a step is told late, s. Set by hand.
    const LATE_S: f64 = 600.0;
    /// Share of a step that the flow takes at the most where it does not answer, and at the least where it does. Set by hand.
    const UNANSWERED: f64 = 0.3;
    const ANSWERED: f64 = 0.8;
    /// Standard deviations of a difference of two means that a step must be worth. Set by hand.
    const TELLS: f64 = 5.0;
    let [over, answers, longest] = [OVER_S, ANSWERS_S, LATE_S].map(|s| whole(s / step_s).max(1));
    let flow = Means::of(flow_m3_s);
    let before = |i: usize| flow.between(i.saturating_sub(over), i);
    let after = |i: usize| flow.between(i + answers, i + answers + over);
    let noise = noise_m3_s * (2.0 / over as f64).sqrt();
    let mut out = speed_pct.to_vec();
    for rest in runs(speed_pct) {
        let end = rest.end;
        let (Some(next), rested) = (speed_pct.get(end), speed_pct[rest.start]) else {
            continue;
        };
        let turns = rested > STANDING_PCT && *next > STANDING_PCT;
        if rest.len() <= 2 * (over + answers) || !turns {
            continue;
        }
        let least = (next / rested - 1.0) * before(end);
        let share = |i: usize| (after(i) - before(i)) / least;
        // Written so that what is not known is passed over too.
        if !(least.abs() > TELLS * noise && share(end).abs() < UNANSWERED) {
            continue;
        }
        // Just after a step of its own the flow answers that.
        let came = (rest.start.checked_sub(1)).map_or(0.0, |i| rested - speed_pct[i]);
        let stepped = came.abs() > 0.5 * (next - rested).abs();
        let own = if stepped { over + answers } else { 0 };
        let first = (rest.start + own).max(end.saturating_sub(longest));
        let kept = |i: usize| (before(end) - before(i)) / least > ANSWERED;
        let told = (first..end - over - answers)
            .filter(|i| share(*i) > ANSWERED && kept(*i))
            .max_by(|a, b| share(*a).total_cmp(&share(*b)));
        if let Some(step) = told {
            out[step.saturating_sub(answers)..end].fill(f64::NAN);
        }
    }
    out
}

/// Runs of equal values.
fn runs(values: &[f64]) -> impl Iterator<Item = Range<usize>> {
    let mut start = 0;
    values.chunk_by(|a, b| a == b).map(move |run| {
        let range = start..start + run.len();
        start = range.end;
        range
    })
}

/// Quantisation step of a channel: the least by which its readings move, but for the rarest; 0 if they never do.
pub(crate) fn quantum(values: &[f64], step_s: f64) -> f64 {
    let read: Vec<f64> = dgd_recording::readings(values, step_s)
        .map(|i| values[i])
        .collect();
    let steps = read.windows(2).map(|w| (w[1] - w[0]).abs());
    dgd_recording::quantile(steps.filter(|s| *s > 1e-6), dgd_recording::Rank::Lower(10))
        .unwrap_or(0.0)
}

#[cfg(test)]
mod tests;
