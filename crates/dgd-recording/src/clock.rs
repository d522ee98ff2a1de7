//! Time stamps: what is wrong with them, and the even clock behind them.

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
    /// Stamps equal to their predecessor (after ordering).
    pub duplicates: usize,
    /// Stamps earlier than their predecessor.
    pub backward: usize,
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
    #[error(
        "found {found} different finite time stamps among {samples} samples, expected at least 2"
    )]
    TooFew {
        /// Different finite stamps.
        found: usize,
        /// Samples in the file.
        samples: usize,
    },
    /// A jump so long that an even clock over it would be mostly empty.
    #[error(
        "the time stamps span {span_s} s at {step_s} s a step, which is {steps:.0} steps for {samples} samples; \
         the largest jump is at {jump_s} s: split the file there, or mend its clock"
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
    /// The clock was set back, so that two stretches of the recording bear the same stamps.
    #[error(
        "the clock jumps back by {back_s} s after {jump_s} s, and {samples} samples repeat stamps with other values: \
         two stretches share one time; split the file there, or mend its clock"
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

/// An even clock longer than this many times the samples is a broken clock, not a gap.
const MOST_STEPS_A_SAMPLE: f64 = 20.0;
/// Short recordings may have proportionally longer gaps.
const STEPS_ALWAYS_ALLOWED: f64 = 100_000.0;
/// One odd step in so many is no jitter.
const ODD_STEPS: usize = 1000;
/// A stamp within this share of a step counts as on the clock.
const ON_CLOCK: f64 = 1e-6;

/// Looks at time stamps, s, in the order of the file.
///
/// # Errors
/// [`ClockError::TooFew`], or [`ClockError::Jump`] when a gap is implausibly long.
pub fn survey_clock(time_s: &[f64]) -> Result<ClockSurvey, ClockError> {
    if let Some(sound) = whole_seconds(time_s) {
        return Ok(sound);
    }
    let missing = time_s.iter().filter(|t| !t.is_finite()).count();
    let mut ordered: Vec<f64> = time_s.iter().copied().filter(|t| t.is_finite()).collect();
    let backward = ordered.windows(2).filter(|w| w[1] < w[0]).count();
    if backward > 0 {
        ordered.sort_by(f64::total_cmp);
    }
    let mut steps: Vec<f64> = ordered.windows(2).map(|w| w[1] - w[0]).collect();
    let duplicates = steps.iter().filter(|d| **d == 0.0).count();
    steps.retain(|d| *d > 0.0);
    if steps.is_empty() {
        let found = usize::from(!ordered.is_empty());
        return Err(ClockError::TooFew {
            found,
            samples: time_s.len(),
        });
    }
    let middle = steps.len() / 2;
    let median_s = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
    let step_s = refined_step(&ordered, &steps, median_s);
    let (first, last) = (ordered[0], ordered[ordered.len() - 1]);
    let jump = ordered
        .windows(2)
        .max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])));
    let wanted = (last - first) / step_s;
    let most = STEPS_ALWAYS_ALLOWED.max(MOST_STEPS_A_SAMPLE * time_s.len() as f64);
    // Stamps near the ends of f64 overflow the span: then there is no count at all.
    if wanted.is_nan() || wanted > most {
        return Err(ClockError::Jump {
            span_s: last - first,
            step_s,
            steps: wanted,
            samples: time_s.len(),
            jump_s: jump.map_or(first, |w| w[0]),
        });
    }
    let offset = |t: f64| {
        let steps = (t - first) / step_s;
        (steps - steps.round()).abs() * step_s
    };
    let jitter_s = ordered.iter().map(|t| offset(*t)).fold(0.0, f64::max);
    // A missing sample makes a step of two; half a step of slack leaves jitter alone.
    let gaps: Vec<Gap> = ordered
        .windows(2)
        .filter(|w| w[1] - w[0] > 1.5 * step_s)
        .map(|w| Gap {
            from_s: w[0],
            to_s: w[1],
        })
        .collect();
    let even =
        missing + duplicates + backward == 0 && gaps.is_empty() && jitter_s <= ON_CLOCK * step_s;
    Ok(ClockSurvey {
        step_s,
        span_s: (first, last),
        missing,
        duplicates,
        backward,
        jitter_s,
        gaps,
        even,
    })
}

/// The survey of stamps that are whole seconds and all one step apart, as most are: nothing is left to look for.
fn whole_seconds(time_s: &[f64]) -> Option<ClockSurvey> {
    /// Beyond 2^53 not every whole number is a float.
    const MOST: f64 = 9e15;
    let (first, last) = (*time_s.first()?, *time_s.last()?);
    let step_s = time_s.get(1)? - first;
    let whole = |t: f64| t.fract() == 0.0 && t.abs() < MOST;
    let sound = whole(first)
        && whole(last)
        && whole(step_s)
        && step_s > 0.0
        && time_s.windows(2).all(|w| w[1] - w[0] == step_s);
    sound.then(|| ClockSurvey {
        step_s,
        span_s: (first, last),
        missing: 0,
        duplicates: 0,
        backward: 0,
        jitter_s: 0.0,
        gaps: Vec::new(),
        even: true,
    })
}

/// The median step, unless the stamps jitter: its error would then add up over the
/// recording, so the mean of the steps around it is taken, in which jitter cancels.
fn refined_step(ordered: &[f64], steps: &[f64], median_s: f64) -> f64 {
    let off = |step: &f64| (step / median_s - (step / median_s).round()).abs();
    // A clock that was set once or twice has an odd step there and runs evenly besides.
    let odd = steps.iter().filter(|step| off(step) > ON_CLOCK).count();
    if ordered.len() < 3 || odd * ODD_STEPS <= steps.len() {
        return median_s;
    }
    let near = steps
        .iter()
        .filter(|step| (0.5 * median_s..1.5 * median_s).contains(*step));
    let (sum, count) = near.fold((0.0, 0.0), |(sum, count), step| (sum + step, count + 1.0));
    let mean = sum / count;
    if mean.is_normal() { mean } else { median_s }
}

impl ClockSurvey {
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
                "time runs backwards {}; the samples were put in order",
                counted(self.backward, "time")
            ),
        );
        tell(
            self.duplicates > 0,
            IssueKind::DuplicateTime,
            format!(
                "{} samples repeat a time stamp; the first of each was kept",
                self.duplicates
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
                "steps vary by up to {:.3} s around {} s; samples moved to the nearest step",
                self.jitter_s, self.step_s
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
        for (index, t) in time_s.iter().enumerate().filter(|(_, t)| t.is_finite()) {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "bounded and non-negative"
            )]
            let step = ((t - self.span_s.0) / self.step_s).round() as usize;
            if let Some(slot @ None) = sources.get_mut(step) {
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
