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
pub(crate) struct Answer {
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
    /// [`mean`] over a range; `None` also if it holds a value that is there and not to be trusted.
    fn mean(&self, range: Range<usize>) -> Option<f64> {
        let faults = self.faults.get(range.clone())?;
        let sound = |f: &Faults| f.trusted() | (*f == Faults::MISSING);
        let trusted = faults.iter().fold(true, |all, f| all & sound(f));
        mean(self.speed_pct, range).filter(|_| trusted)
    }

    /// The first value of a range that is there; `None` if it is not to be trusted.
    fn first(&self, range: Range<usize>) -> Option<f64> {
        let mut there = range.filter_map(|i| Some((*self.speed_pct.get(i)?, self.faults.get(i)?)));
        let (first, faults) = there.find(|(value, _)| !value.is_nan())?;
        faults.trusted().then_some(first)
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
    let least = least(steps);
    let Some(answer) = learn(speed, outlet_pa, least, window) else {
        return Vec::new();
    };
    let tells = |run: &&Run| {
        let at_start = || at_start(outlet_pa, run.start, run.length, window);
        Release::of(speed, outlet_pa, run, window, least, at_start)?.tells(answer)
    };
    runs.iter()
        .filter(|run| tells(run).is_some())
        .copied()
        .collect()
}

/// Smallest jump out of a frozen run, %.
pub(crate) fn least(steps: Steps) -> f64 {
    (QUANTA * steps.quantum).max(2.0 * steps.typical)
}

/// Mean outlet pressure at the start of a run; in the first half of a short one.
pub(crate) fn at_start(
    outlet_pa: &[f64],
    start: usize,
    length: usize,
    window: usize,
) -> Option<f64> {
    let half_run = window.min(length / 2).max(1);
    mean(outlet_pa, start..start + half_run)
}

/// What a run of one speed was followed by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Release {
    /// Change of the speed from the run's last sample to the next, %.
    jump: f64,
    /// The same to the second window after it.
    change: f64,
    /// Change of the outlet pressure meanwhile, Pa.
    pressure: f64,
    /// Change of the outlet pressure during the run, Pa; `None` where it is not known.
    inside: Option<f64>,
}

impl Release {
    /// `None` where the readings after the run do not tell, or it ends with less than a jump.
    pub(crate) fn of(
        speed: Readings<'_>,
        outlet_pa: &[f64],
        run: &Run,
        window: usize,
        least: f64,
        at_start: impl FnOnce() -> Option<f64>,
    ) -> Option<Self> {
        let end = run.start + run.length;
        let jump = speed.first(end..end + window)? - run.value;
        if jump.abs() < least {
            return None;
        }
        let later = end + window..end + 2 * window;
        let change = speed.mean(later.clone())? - run.value;
        let at_end = mean(outlet_pa, end.saturating_sub(window)..end)?;
        Some(Self {
            jump,
            change,
            pressure: mean(outlet_pa, later)? - at_end,
            inside: at_start().map(|at_start| at_end - at_start),
        })
    }

    /// Whether the run was frozen.
    pub(crate) fn tells(self, answer: Answer) -> Option<()> {
        let Self {
            jump,
            change,
            pressure,
            inside,
        } = self;
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
        let inside = inside? / owed;
        (sigmas > TELLS_WITH_WITNESS && (HALF..2.0 - HALF).contains(&inside)).then_some(())
    }
}

/// Median ratio of the pressure's change to the speed's, over pairs of windows two apart.
fn learn(speed: Readings<'_>, outlet_pa: &[f64], least: f64, window: usize) -> Option<Answer> {
    let blocks: Vec<(f64, f64)> = (0..speed.speed_pct.len() / window)
        .map(|k| means(speed, outlet_pa, k * window..(k + 1) * window))
        .collect();
    let pairs = blocks.iter().zip(blocks.iter().skip(2));
    let changes: Vec<(f64, f64)> = pairs.filter_map(|(a, b)| change(*a, *b, least)).collect();
    answer(&changes)
}

/// Mean speed, %, and mean outlet pressure, Pa, of a window; NaN where they do not tell.
pub(crate) fn means(speed: Readings<'_>, outlet_pa: &[f64], range: Range<usize>) -> (f64, f64) {
    let both = speed.mean(range.clone()).zip(mean(outlet_pa, range));
    both.unwrap_or((f64::NAN, f64::NAN))
}

/// The change from one window to another of a pump that turns, if the speed's says something.
pub(crate) fn change(a: (f64, f64), b: (f64, f64), least: f64) -> Option<(f64, f64)> {
    let change = (b.0 - a.0, b.1 - a.1);
    (a.0 > 0.0 && b.0 > 0.0 && change.0.abs() >= least).then_some(change)
}

/// The pressure's answer, from changes of the speed and of the pressure.
pub(crate) fn answer(changes: &[(f64, f64)]) -> Option<Answer> {
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

/// Mean of what is there in a range; `None` if it leaves the series or nothing is there.
fn mean(values: &[f64], range: Range<usize>) -> Option<f64> {
    let part = values.get(range)?;
    let whole = part.iter().sum::<f64>() / part.len() as f64;
    if whole.is_finite() {
        return Some(whole);
    }
    let there = || part.iter().filter(|v| v.is_finite());
    let mean = there().sum::<f64>() / there().count() as f64;
    mean.is_finite().then_some(mean)
}

/// Samples in a window at this step.
pub(crate) fn window(step_s: f64) -> usize {
    crate::options::samples(WINDOW_S, step_s, 2)
}
