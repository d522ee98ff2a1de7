//! The simulations of chapter 4 over a window of a recording.

use crate::Replay;
use crate::blocks::{BlockReplay, check_lengths};
use dgd_dynamics::DynamicsError;
use dgd_dynamics::return_line::{ReturnLine, SimulationOptions};
use dgd_recording::{Recording, odd_step};
use std::ops::Range;

/// Which simulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Kind {
    /// Level and flow together (section 4.3).
    #[default]
    Coupled,
    /// The level, driven by the measured flow (section 4.1).
    Riser,
    /// The flow, driven by the measured level (section 4.2).
    Flow,
    /// The flow at which all pressures balance at each sample (Eq. 4.2).
    Steady,
}

/// Where the states start; what is `None` is taken from the recording at the
/// window's first sample that has it, and brought within the riser and, with the non-return valve, to a flow of at least 0. What is given
/// must be there.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Start {
    /// Riser level, m.
    pub level_m: Option<f64>,
    /// Flow through the pump, m³/s.
    pub flow_m3_s: Option<f64>,
}

/// Settings of a replay.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ReplayOptions {
    /// Which simulation.
    pub kind: Kind,
    /// First and last second of the window, clipped to the recording; all of it if `None`.
    pub window_s: Option<(f64, f64)>,
    /// Initial states.
    pub start: Start,
    /// How late the flow meter is, s (Eq. 3.21).
    pub delay_s: f64,
    /// Solver and tolerances.
    pub solver: SimulationOptions,
}

/// Why there is nothing to simulate.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ReplayError {
    /// The window holds no samples.
    #[error(
        "the window {from_s} to {to_s} s holds {samples} samples, expected at least 2; the recording spans {start_s} to {end_s} s"
    )]
    Window {
        /// Asked for.
        from_s: f64,
        /// Asked for.
        to_s: f64,
        /// Found in it.
        samples: usize,
        /// First second of the recording.
        start_s: f64,
        /// Last second of the recording.
        end_s: f64,
    },
    /// An input has no value in the window.
    #[error("`{name}` has no trusted value between {from_s} and {to_s} s; choose another window")]
    NoInput {
        /// Which.
        name: &'static str,
        /// First second of the window.
        from_s: f64,
        /// Last second of the window.
        to_s: f64,
    },
    /// A series is not as long as the clock.
    #[error("`{channel}` has {found} samples, expected {expected} to match the time")]
    Length {
        /// The odd series.
        channel: String,
        /// Length of the time.
        expected: usize,
        /// Its length.
        found: usize,
    },
    /// The meter is so late, or early, that the recording shows no flow of the window.
    #[error(
        "a meter that is {delay_s} s late shows no flow of {from_s} to {to_s} s in a recording of {start_s} to {end_s} s; choose another delay or window"
    )]
    DelayBeyond {
        /// The delay, s.
        delay_s: f64,
        /// First second of the window.
        from_s: f64,
        /// Last second of the window.
        to_s: f64,
        /// First second of the recording.
        start_s: f64,
        /// Last second of the recording.
        end_s: f64,
    },
    /// The clock of the window is not that of the recording, by which blocks read the meter ahead.
    #[error(
        "the clock steps by {found_s} s in the window and by {step_s} s in the recording, by which the delay is another number of samples: put the recording on an even clock"
    )]
    Drift {
        /// Mean step in the window, s.
        found_s: f64,
        /// Mean step in the recording, s.
        step_s: f64,
    },
    /// The flow meter shows what is to come, which blocks do not hold yet.
    #[error("the delay is {delay_s} s, expected at least 0 s of a recording in blocks")]
    Delay {
        /// The delay, s.
        delay_s: f64,
    },
    /// The clock is not even.
    #[error(
        "the clock steps by {found_s} s after sample {sample}, mostly by {step_s} s: put the recording on an even clock"
    )]
    Uneven {
        /// The sample before the odd step, from 1.
        sample: usize,
        /// That step, s.
        found_s: f64,
        /// Median step, s.
        step_s: f64,
    },
    /// Blocks that are not the recording that was announced.
    #[error("blocks of {found} samples in all, expected {expected}")]
    Blocks {
        /// Samples that came.
        found: usize,
        /// Samples announced.
        expected: usize,
    },
    /// The model or its inputs were refused.
    #[error(transparent)]
    Dynamics(#[from] DynamicsError),
}

fn step_s(time_s: &[f64]) -> f64 {
    (time_s[time_s.len() - 1] - time_s[0]) / (time_s.len() - 1) as f64
}

/// Samples by which a meter is late on a clock, in whole numbers; halves go away from 0, whatever rounding makes of the step.
pub(crate) fn samples_late(delay_s: f64, step_s: f64) -> f64 {
    let exact = delay_s / step_s;
    (exact * (1.0 + 1e-9)).round()
}

/// Refuses a window, whose first sample has the number `first`, of which a step is off by more than half of one.
fn check_clock(time_s: &[f64], first: usize) -> Result<(), ReplayError> {
    if time_s.len() < 2 {
        return Ok(());
    }
    let off = |w: &[f64], step_s: f64| (w[1] - w[0] - step_s).abs();
    // All within a fifth of their mean are within half of their median, which takes a copy to find.
    let mean_s = step_s(time_s);
    let even = |all: bool, w: &[f64]| all & (off(w, mean_s) <= 0.2 * mean_s);
    if time_s.windows(2).fold(true, even) {
        return Ok(());
    }
    let mut steps: Vec<f64> = time_s.windows(2).map(|w| w[1] - w[0]).collect();
    let middle = steps.len() / 2;
    let step_s = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
    let Some(sample) = odd_step(time_s, step_s) else {
        return Ok(());
    };
    Err(ReplayError::Uneven {
        sample: first + sample + 1,
        found_s: time_s[sample + 1] - time_s[sample],
        step_s,
    })
}

/// The meter's value `steps` samples after `index` (Eq. 3.22).
fn ahead(flow: &[f64], index: usize, steps: f64) -> f64 {
    let at = index as f64 + steps;
    if !(0.0..flow.len() as f64).contains(&at) {
        return f64::NAN;
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "checked against the length"
    )]
    let at = at as usize;
    flow[at]
}

/// The samples of a window and those that [`ahead`] looks up for them, of a recording of `len`.
fn reach(window: Range<usize>, steps: f64, len: usize) -> Range<usize> {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a float beyond the integers becomes the nearest one"
    )]
    let (before, after) = ((-steps).max(0.0) as usize, steps.max(0.0) as usize);
    window.start.saturating_sub(before)..window.end.saturating_add(after).min(len)
}

pub(crate) fn check_delay(delay_s: f64) -> Result<(), ReplayError> {
    if delay_s.is_finite() {
        return Ok(());
    }
    Err(ReplayError::Dynamics(DynamicsError::Parameter {
        name: "delay_s",
        found: delay_s,
        expected: "a finite number",
    }))
}

/// Runs the model over a window of a recording that is on an even clock.
///
/// # Errors
/// [`ReplayError`] if the window or an input is empty, a series is not as long as the clock, the clock is not even, the delay is
/// no number, or the model's parameters are refused.
///
/// # Source
/// Chapter 4 of the thesis; riser alone Eq. 3.45, flow alone Eq. 3.46, steady Eq. 4.2.
pub fn replay(
    line: &ReturnLine,
    recording: &Recording,
    options: &ReplayOptions,
) -> Result<Replay, ReplayError> {
    check_lengths(recording)?;
    let time = &recording.time_s;
    check_delay(options.delay_s)?;
    let span_s = (
        time.first().copied().unwrap_or(0.0),
        time.last().copied().unwrap_or(0.0),
    );
    let (from_s, to_s) = options.window_s.unwrap_or(span_s);
    let Range {
        start: first,
        end: last,
    } = recording.between(from_s, to_s);
    // Where the clock has holes or jumps bisection goes astray. Days are not looked through for a window of minutes.
    let astray = first == last
        || time[..first].last().is_some_and(|t| !(*t < from_s))
        || time[last..].first().is_some_and(|t| !(*t > to_s));
    if astray {
        check_clock(time, 0)?;
    }
    let steps = match last - first {
        0 | 1 => 0.0,
        _ => samples_late(options.delay_s, step_s(&time[first..last])),
    };
    let reached = reach(first..last, steps, time.len());
    check_clock(&time[reached.clone()], reached.start)?;
    let pump_flow_m3_s = (first..last)
        .map(|i| ahead(&recording.return_flow_m3_s, i, steps))
        .collect();
    // Of the samples that the meter is read at, none is in the recording.
    let unseen = first as f64 + steps >= time.len() as f64 || last as f64 + steps <= 0.0;
    let window = recording.slice(first..last);
    BlockReplay::with_any_delay(line, options, time.len(), span_s).whole(
        window,
        pump_flow_m3_s,
        unseen,
    )
}
