//! Time stamps: what is wrong with them, and the even clock behind them.

mod passes;

use passes::Even;
pub(crate) use passes::{ClockPasses, most_steps};

use crate::{Issue, IssueKind};

/// What a column of time stamps looks like.
#[derive(Debug, Clone, PartialEq)]
pub struct ClockSurvey {
    /// Step of the even clock, s: the median step between stamps in order, or where
    /// stamps jitter the mean of the steps near it.
    pub step_s: f64,
    /// First and last stamp, s.
    pub span_s: (f64, f64),
    /// Stamps that are missing or not finite.
    pub missing: usize,
    /// Stamps equal to their predecessor (after ordering), to a millionth of a step, and on the same step of the even clock;
    /// those samples are dropped.
    pub duplicates: usize,
    /// Stamps whose step of the even clock belongs to an earlier sample, duplicates apart; those samples are dropped.
    pub crowded: usize,
    /// Stamps earlier than their predecessor.
    pub backward: usize,
    /// The stamp, s, behind which the clock goes back furthest, and how far, s.
    pub furthest_back_s: Option<(f64, f64)>,
    /// Largest distance of a stamp from the even clock, s.
    pub jitter_s: f64,
    /// Where samples are missing.
    pub gaps: Vec<Gap>,
    /// Whether every stamp already sits on the even clock, without a gap.
    pub even: bool,
}

/// A stretch of the even clock without samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// Last stamp before it, s.
    pub from_s: f64,
    /// First stamp after it, s.
    pub to_s: f64,
}

/// Why there is no even clock.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ClockError {
    /// Fewer than two different finite stamps.
    #[error("{samples} samples with {found} different time stamps; at least 2 are needed")]
    TooFew {
        /// Different finite stamps.
        found: usize,
        /// Samples in the file.
        samples: usize,
    },
    /// A jump so long that an even clock over it would be mostly empty.
    #[error(
        "the time stamps span {span_s} s at {step_s} s a step, which is {steps:.0} steps for {samples} samples; the largest jump is at {jump_s} s: \
         split the file there, or correct its clock"
    )]
    Jump {
        /// First to last stamp, s.
        span_s: f64,
        /// Median step, s.
        step_s: f64,
        /// Steps an even clock would have.
        steps: f64,
        /// Samples in the file.
        samples: usize,
        /// Stamp before the longest gap, s.
        jump_s: f64,
    },
    /// Many samples in a row share each stamp, as where a spreadsheet has dropped the seconds.
    #[error(
        "some {shared} consecutive samples share each time stamp, and the stamps are {step_s:.0} s apart: they have lost their seconds, or each \
         row appears several times; export again, or give the sample interval instead of the clock, time = {{ interval = \"{} s\" }}",
        shown(step_s / *shared as f64, 6)
    )]
    Coarse {
        /// Samples to a stamp.
        shared: usize,
        /// From stamp to stamp, s.
        step_s: f64,
    },
    /// The clock was set back, so that two stretches of the recording bear the same stamps.
    #[error(
        "the clock jumps back by {back_s} s after {jump_s} s, and {samples} samples repeat stamps with other values: two stretches share the same \
         times; split the file there, or correct its clock"
    )]
    SetBack {
        /// Stamp before the jump, s.
        jump_s: f64,
        /// How far it jumps, s.
        back_s: f64,
        /// Samples whose step of the clock was taken by another one of other values.
        samples: usize,
    },
}

/// Samples in a row that share their step with others of other values, from which they are another
/// stretch of time and not stamps that were rounded or sent twice.
pub(crate) const STRETCH: usize = 10;

/// A stamp within this share of a step counts as on the clock.
const ON_CLOCK: f64 = 1e-6;

/// Looks at time stamps, s, in the order of the file.
///
/// # Errors
/// [`ClockError::TooFew`], or [`ClockError::Jump`] when a gap is implausibly long.
pub fn survey_clock(time_s: &[f64]) -> Result<ClockSurvey, ClockError> {
    let mut even = Even::default();
    even.add(time_s);
    if let Some(sound) = even.sound() {
        return Ok(sound);
    }
    let mut clock = ClockPasses::new(time_s.len());
    loop {
        clock.add(time_s);
        if !clock.next_pass() {
            return clock.finish();
        }
    }
}

/// Where a clock does not run in steps of the length that it should.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Uneven {
    /// A step that is off by more than half of one.
    #[error(
        "the clock steps by {found_s} s after sample {sample}, expected {step_s} s: put the recording on an even clock"
    )]
    Step {
        /// The sample before the odd step, from 1.
        sample: usize,
        /// That step, s.
        found_s: f64,
        /// The step expected, s.
        step_s: f64,
    },
    /// Steps that are off together.
    #[error("the clock steps by {found_s} s on average, expected {step_s} s")]
    Mean {
        /// The mean step, s.
        found_s: f64,
        /// The step expected, s.
        step_s: f64,
    },
}

/// A step may be off by this share of one.
const OFF: f64 = 0.5;
/// The mean step may be off by this share of one, which jitter is not in many samples.
const MEAN_OFF: f64 = 0.01;

/// The first sample, from 0, after which the clock steps by anything that is off by more than half of `step_s`.
///
/// One pass, no memory. What [`Recording::onto_grid`](crate::Recording::onto_grid) gives has none, however few digits the
/// stamps leave to the step.
///
/// ```
/// # use dgd_recording::odd_step;
/// assert_eq!(odd_step(&[0.0, 1.0, 2.2, 3.0], 1.0), None);
/// assert_eq!(odd_step(&[0.0, 1.0, 3.0, 4.0], 1.0), Some(1));
/// ```
pub fn odd_step(time_s: &[f64], step_s: f64) -> Option<usize> {
    let most_s = (OFF * step_s + rounding(time_s)).min(step_s);
    // Nothing is within an infinite step, and a time that is no number is not within anything.
    let most_s = most_s.min(f64::MAX);
    let on = |w: &[f64]| (w[1] - w[0] - step_s).abs() <= most_s;
    // Without an early exit the compiler can vectorise it.
    if time_s.windows(2).fold(true, |all, w| all & on(w)) {
        return None;
    }
    time_s.windows(2).position(|w| !on(w))
}

/// Checks that stamps, s, in order, lie on an even clock of this step: no step is off by more than half of one
/// ([`odd_step`]), and the last stamp is where the step puts it, to half a step or, of many, to 1 %.
///
/// Fewer than two stamps are even.
///
/// # Errors
/// [`Uneven`], with the first place where they do not.
pub fn check_even(time_s: &[f64], step_s: f64) -> Result<(), Uneven> {
    if let Some(sample) = odd_step(time_s, step_s) {
        return Err(Uneven::Step {
            sample: sample + 1,
            found_s: time_s[sample + 1] - time_s[sample],
            step_s,
        });
    }
    let [first_s, .., last_s] = time_s else {
        return Ok(());
    };
    let steps = (time_s.len() - 1) as f64;
    let off_s = (last_s - first_s - steps * step_s).abs();
    if off_s <= (OFF * step_s).max(MEAN_OFF * steps * step_s) + rounding(time_s) {
        return Ok(());
    }
    Err(Uneven::Mean {
        found_s: (last_s - first_s) / steps,
        step_s,
    })
}

/// By how much the difference of two stamps may be off because they have so few digits: each is rounded, and so is what a
/// grid adds to its first.
fn rounding(time_s: &[f64]) -> f64 {
    let ends = time_s.first().into_iter().chain(time_s.last());
    let largest = ends.fold(0.0f64, |largest, t| largest.max(t.abs()));
    4.0 * f64::EPSILON * largest.min(f64::MAX)
}

/// A number above 0 to so many significant figures, without zeros at its end.
fn shown(value: f64, figures: usize) -> String {
    let rounded = format!("{value:.*e}", figures.saturating_sub(1));
    rounded
        .parse()
        .map_or(rounded, |value: f64| value.to_string())
}

impl ClockSurvey {
    /// The survey of a clock whose stamps were read as seconds and are `seconds` long each.
    pub(crate) fn in_units_of(&self, seconds: f64) -> Self {
        let gap = |gap: &Gap| Gap {
            from_s: gap.from_s * seconds,
            to_s: gap.to_s * seconds,
        };
        Self {
            step_s: self.step_s * seconds,
            span_s: (self.span_s.0 * seconds, self.span_s.1 * seconds),
            jitter_s: self.jitter_s * seconds,
            furthest_back_s: (self.furthest_back_s).map(|(at, by)| (at * seconds, by * seconds)),
            gaps: self.gaps.iter().map(gap).collect(),
            ..self.clone()
        }
    }

    /// What is wrong with the clock, in words, one issue a kind.
    pub fn issues(&self) -> Vec<Issue> {
        let mut issues = Vec::new();
        let mut tell = |wrong: bool, kind, message: String| {
            if wrong {
                issues.push(Issue {
                    kind,
                    place: "time".into(),
                    message,
                });
            }
        };
        tell(
            self.missing > 0,
            IssueKind::MissingTime,
            format!(
                "{} samples have no time stamp and were dropped",
                self.missing
            ),
        );
        tell(
            self.backward > 0,
            IssueKind::BackwardTime,
            format!(
                "time runs backwards {}{}; the samples were put in order",
                counted(self.backward, "time"),
                self.furthest_back_s
                    .map_or_else(String::new, |(at_s, by_s)| {
                        format!(
                            ", furthest by {} s after {} s",
                            shown(by_s, 6),
                            shown(at_s, 9)
                        )
                    })
            ),
        );
        // Rows in another order repeat no stamps.
        let set_back = self.backward > 0 && self.duplicates >= STRETCH * self.backward;
        tell(
            self.duplicates > 0,
            IssueKind::DuplicateTime,
            format!(
                "{} samples repeat a time stamp; the first of each was kept{}",
                self.duplicates,
                if set_back {
                    ": was the clock set back?"
                } else {
                    ""
                }
            ),
        );
        let missing: f64 = self
            .gaps
            .iter()
            .map(|g| (g.to_s - g.from_s) / self.step_s - 1.0)
            .sum();
        tell(
            !self.gaps.is_empty(),
            IssueKind::Gap,
            format!(
                "{}, {missing:.0} samples missing; filled with NaN",
                counted(self.gaps.len(), "gap")
            ),
        );
        tell(
            self.jitter_s > ON_CLOCK * self.step_s,
            IssueKind::Jitter,
            format!(
                "steps vary by up to {} s around {} s; samples moved to the nearest step",
                shown(self.jitter_s, 2),
                shown(self.step_s, 6)
            ),
        );
        tell(
            self.crowded > 0,
            IssueKind::Crowded,
            format!(
                "{} on a step of {} s that an earlier sample has: dropped (if the samples are evenly spaced, give their interval instead of the \
                 clock)",
                match self.crowded {
                    1 => "1 sample lies".to_owned(),
                    crowded => format!("{crowded} samples lie"),
                },
                shown(self.step_s, 6)
            ),
        );
        issues
    }

    /// Steps of the even clock from the first to the last stamp, both included.
    pub fn steps(&self) -> usize {
        // Bounded by `survey_clock`, so the cast cannot lose anything.
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "bounded and non-negative"
        )]
        let steps = ((self.span_s.1 - self.span_s.0) / self.step_s).round() as usize;
        steps + 1
    }

    /// Step of the even clock that a stamp is nearest to; `None` for none.
    pub(crate) fn step_of(&self, stamp_s: f64) -> Option<usize> {
        let step = ((stamp_s - self.span_s.0) / self.step_s).round();
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "bounded and non-negative"
        )]
        (step >= 0.0 && step < self.steps() as f64).then_some(step as usize)
    }

    /// Source sample for each step of the even clock; `None` in gaps.
    pub(crate) fn sources(&self, time_s: &[f64]) -> Vec<Option<u32>> {
        let mut sources = vec![None; self.steps()];
        for (index, t) in time_s.iter().enumerate() {
            let slot = self.step_of(*t).and_then(|step| sources.get_mut(step));
            if let Some(slot @ None) = slot {
                *slot = u32::try_from(index).ok();
            }
        }
        sources
    }
}

/// `1 gap`, `2 gaps`.
fn counted(n: usize, noun: &str) -> String {
    format!("{n} {noun}{}", if n == 1 { "" } else { "s" })
}
