//! What must be true: the numbers that the proof is held against.

/// Single effects named exactly, level one.
pub(crate) const NAMED_LEVEL_ONE: f64 = 0.99;
/// Single effects named exactly, level two, by severity.
pub(crate) const NAMED_LEVEL_TWO: [(&str, f64); 3] =
    [("moderate", 0.95), ("subtle", 0.90), ("faint", 0.60)];
/// Pairs that meet in one relation: both named and nothing else.
pub(crate) const PAIRS_EXACT: f64 = 0.70;
/// Pairs that meet in one relation: both named or among the stated alternatives.
pub(crate) const PAIRS_WITHIN: f64 = 0.90;
/// Clean recordings with a finding, at most.
pub(crate) const FALSE_ALARMS: f64 = 0.02;
/// Findings of probability 0.9 or more that are wrong, at most.
pub(crate) const CONFIDENTLY_WRONG: f64 = 0.03;
/// Effects outside the catalogue called `unknown`.
pub(crate) const FOREIGN_UNKNOWN: f64 = 0.90;
/// Overlap of the interval found with the true one, median.
pub(crate) const OVERLAP: f64 = 0.85;
/// Relative error of the scored parameters, median, at most.
pub(crate) const PARAMETER_ERROR: f64 = 0.05;
/// Share of the 95 % intervals that hold the truth.
pub(crate) const COVERAGE: (f64, f64) = (0.90, 0.98);
/// Smallest effect named over the Neyman-Pearson limit of its recording, at most.
pub(crate) const LIMIT_FACTOR: f64 = 2.0;
/// Share of the held-out gain of a fit that knows the truth.
pub(crate) const TRUTH_SHARE: f64 = 0.95;
/// Seconds for 6 h at 1 Hz on two cores, at most.
pub(crate) const SECONDS_SIX_HOURS: f64 = 5.0;

/// Effects of the catalogue, each of which may raise a false alarm.
pub(crate) const CATALOGUE: f64 = 24.0;
/// From this probability on a finding counts as claimed.
pub(crate) const CLAIMED: f64 = 0.5;
/// From this probability on an alternative counts as stated.
pub(crate) const STATED: f64 = 0.1;
/// From this probability on a wrong finding is confidently wrong.
pub(crate) const CONFIDENT: f64 = 0.9;
/// A signal whose held-out error grows by more than this factor is made worse.
pub(crate) const WORSE: f64 = 1.02;
/// Held-out windows are at least this long; ten seconds less is rounding to samples.
pub(crate) const HELD_WINDOW_S: f64 = 1190.0;
/// Held-out windows are at least this share of the recording; a thousandth less is rounding.
pub(crate) const HELD_SHARE: f64 = 0.199;
/// A signal is compared when it has more held-out samples than this.
pub(crate) const HELD_SAMPLES: usize = 50;
/// A run that takes longer is stopped and counts as broken.
pub(crate) const PATIENCE_S: u64 = 120;
