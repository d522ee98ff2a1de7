//! A resting pump speed: an honest set-point, or a frozen reading?
//!
//! Run length cannot tell: controllers rest for minutes. A frozen reading gives
//! itself away when it is released: it catches up in a jump, and the pump's outlet
//! pressure, which follows every true change of speed, does not.

use crate::Faults;
use crate::scan::{SIGMA_OF_MAD, Steps, median};
use dgd_recording::Run;
use std::ops::Range;

/// Releases are judged on means over this long, s.
const WINDOW_S: f64 = 10.0;
/// Jumps below this many quanta are ordinary control.
const QUANTA: f64 = 3.5;
/// Standard deviations by which the pressure must be able to tell.
const TELLS: f64 = 3.0;
/// The same with the pressure's way during the run as a second witness.
const TELLS_WITH_WITNESS: f64 = 1.0;
/// Share of what a jump owes that decides.
const HALF: f64 = 0.5;
/// Fewest changes of speed to learn the pressure's answer from.
const FEWEST: usize = 10;

/// How the outlet pressure answers a change of speed, from window to window.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Answer {
    pa_per_pct: f64,
    spread_pa: f64,
}

/// A pump speed beside what is wrong with it, shape `(n,)` each.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Readings<'a> {
    pub(crate) speed_pct: &'a [f64],
    pub(crate) faults: &'a [Faults],
}

impl Readings<'_> {
    /// [`mean`] over a range; `None` also if it holds a value that is not to be trusted.
    fn mean(&self, range: Range<usize>) -> Option<f64> {
        let faults = self.faults.get(range.clone())?;
        let trusted = faults.iter().fold(true, |all, f| all & f.trusted());
        mean(self.speed_pct, range).filter(|_| trusted)
    }
}

/// Those of the runs that are frozen.
///
/// - `outlet_pa`: shape `(n,)`; NaN where not to be trusted.
/// - `window`: samples in a window.
pub(crate) fn frozen(
    speed: Readings<'_>,
    outlet_pa: &[f64],
    steps: Steps,
    runs: &[Run],
    window: usize,
) -> Vec<Run> {
    let least = (QUANTA * steps.quantum).max(2.0 * steps.typical);
    let Some(answer) = learn(speed, outlet_pa, least, window) else {
        return Vec::new();
    };
    let tells = |run: &&Run| {
        let end = run.start + run.length;
        let jump = speed.mean(end..end + 1)? - run.value;
        if jump.abs() < least {
            return None;
        }
        let later = end + window..end + 2 * window;
        let change = speed.mean(later.clone())? - run.value;
        let at_end = mean(outlet_pa, end.saturating_sub(window)..end)?;
        let pressure = mean(outlet_pa, later)? - at_end;
        let owed = answer.pa_per_pct * jump;
        // What is missing from the answer at the release is the jump: the pump had moved before.
        let missing = (answer.pa_per_pct * change - pressure) / owed;
        if missing.is_nan() || missing <= HALF {
            return None;
        }
        let sigmas = owed.abs() / answer.spread_pa;
        if sigmas > TELLS {
            return Some(());
        }
        // A smaller jump needs a second witness: the pressure moved as much during the run.
        let half_run = window.min(run.length / 2).max(1);
        let at_start = mean(outlet_pa, run.start..run.start + half_run)?;
        let inside = (at_end - at_start) / owed;
        (sigmas > TELLS_WITH_WITNESS && (HALF..2.0 - HALF).contains(&inside)).then_some(())
    };
    runs.iter()
        .filter(|run| tells(run).is_some())
        .copied()
        .collect()
}

/// Median ratio of the pressure's change to the speed's, over pairs of windows two apart.
fn learn(speed: Readings<'_>, outlet_pa: &[f64], least: f64, window: usize) -> Option<Answer> {
    let blocks: Vec<(f64, f64)> = (0..speed.speed_pct.len() / window)
        .map(|k| k * window..(k + 1) * window)
        .map(|r| {
            let both = speed.mean(r.clone()).zip(mean(outlet_pa, r));
            both.unwrap_or((f64::NAN, f64::NAN))
        })
        .collect();
    let changes: Vec<(f64, f64)> = blocks
        .iter()
        .zip(blocks.iter().skip(2))
        .filter(|(a, b)| a.0 > 0.0 && b.0 > 0.0)
        .map(|(a, b)| (b.0 - a.0, b.1 - a.1))
        .filter(|(speed, _)| speed.abs() >= least)
        .collect();
    if changes.len() < FEWEST {
        return None;
    }
    let pa_per_pct = median(&mut changes.iter().map(|(s, p)| p / s).collect::<Vec<_>>())?;
    let mut off: Vec<f64> = changes
        .iter()
        .map(|(s, p)| (p - pa_per_pct * s).abs())
        .collect();
    Some(Answer {
        pa_per_pct,
        spread_pa: SIGMA_OF_MAD * median(&mut off)?,
    })
}

/// Mean over a range; `None` if it leaves the series or holds a value that is not finite.
fn mean(values: &[f64], range: Range<usize>) -> Option<f64> {
    let part = values.get(range)?;
    let mean = part.iter().sum::<f64>() / part.len() as f64;
    mean.is_finite().then_some(mean)
}

/// Samples in a window at this step.
pub(crate) fn window(step_s: f64) -> usize {
    crate::options::samples(WINDOW_S, step_s, 2)
}
