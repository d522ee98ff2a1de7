//! What a revision says.

use dgd_assembly::{Assembly, SimulationOptions};

/// The whole answer.
#[derive(Debug, Clone)]
pub struct Revision {
    /// The answer in a word.
    pub verdict: Verdict,
    /// Why the answer is [`Verdict::Consistent`] although more than chance is left of the re-fitted base; `None` where nothing is, and of any
    /// other answer.
    pub excused: Option<Excuse>,
    /// What was left out, greatest gain first; empty when consistent.
    pub findings: Vec<Finding>,
    /// What is part of the model because it pays on left-out blocks, and has with its alternatives a weight of less than a half once
    /// chance and what stays unexplained are counted: too little for a finding.
    pub also_possible: Vec<Finding>,
    /// What the record cannot tell apart.
    pub classes: Vec<Class>,
    /// Every effect on every component: found, not seen and down to which size, taken up by a re-fit, or not testable.
    pub tested: Vec<Tested>,
    /// Checks, passed and failed.
    pub checks: Vec<Check>,
    /// The sets of effects that were fitted to the end, best on left-out blocks first.
    pub contenders: Vec<Contender>,
    /// The assembly as described, fitted again.
    pub before: Model,
    /// The assembly with the findings, fitted; without a correction, see [`Self::unwritten`].
    pub after: Model,
    /// Root mean squares of each instrument, before and after; a correction is part of it only where nothing is named.
    pub outputs: Vec<OutputGain>,
    /// Measured and simulated readings, training windows first.
    pub traces: Vec<Trace>,
    /// Stretches of the independent variable in which the same cause holds with the same parameters; one if it holds
    /// throughout, empty for what moves in time.
    pub sections: Vec<Section>,
    /// Settings and facts of the run, name and value.
    pub settings: Vec<(String, String)>,
}

impl Revision {
    /// The finding whose correction is part of [`Self::outputs`] and [`Self::traces`] after, and not of [`Self::after`]: no component of an
    /// assembly holds a curve without physics, so the model after simulates as [`Self::before`]. `None` where the model after gives the
    /// readings after; beside names a correction is told and not run.
    #[must_use]
    pub fn unwritten(&self) -> Option<&Finding> {
        let alone = self.verdict == Verdict::Unexplained;
        self.findings.iter().find(|f| alone && f.shape.is_some())
    }
}

/// Why what is left of the re-fitted base is nothing that these instruments could show, be it ever so systematic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Excuse {
    /// Each recorded instrument says how accurate it is, and is met within that.
    Accuracy,
    /// Each recorded instrument is met within the accuracy that it states, or to no more than its noise.
    Noise,
    /// Each is met within the accuracy that it states, or to a tenth more than its noise, in which an effect may still be seen.
    Small,
}

/// The answer in a word: one of the four that `dgd-diagnose` has for a return line, which `dgd-cli`'s tests hold alike.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Nothing is left out that this record could show.
    Consistent,
    /// What was left out is named.
    Explained,
    /// Something is named, something else is not.
    PartlyExplained,
    /// Something is left out that the catalogue does not hold, or that does not stand on held-out data.
    Unexplained,
}

impl Verdict {
    /// Its name in machine-readable output.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Consistent => "consistent",
            Self::Explained => "explained",
            Self::PartlyExplained => "partly_explained",
            Self::Unexplained => "unexplained",
        }
    }
}

/// One thing that was left out.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// Id of the effect in the catalogue, or `unknown`.
    pub effect: String,
    /// Component it sits on; of an `unknown` the instrument or state that is corrected, or the only instrument that shows it; empty if
    /// none is or several are.
    pub component: String,
    /// A few words for people.
    pub title: String,
    /// Governing equation of the effect; of an `unknown`, which correction along which quantity.
    pub equation: String,
    /// Where the equation comes from.
    pub source: String,
    /// Estimates of the effect's parameters.
    pub parameters: Vec<Estimate>,
    /// Where `[from, to]` of the training part most of the residual went with it.
    pub intervals: Vec<(f64, f64)>,
    /// Where in the operating space, if it is crowded anywhere.
    pub region: Option<Region>,
    /// Square of the left-out error that comes back when this alone is taken away again, as a share of the final one's.
    pub left_out_loss: f64,
    /// The same in standard errors.
    pub standard_errors: f64,
    /// How often what has such a weight was right on recordings for building (the README has the command). The weight: that of the sets
    /// that hold it among those that were fitted and are no larger than the claimed one, by their scores on left-out blocks
    /// (pseudo-Bayesian model averaging), times the probability that its gain is not chance, times the share of the squares that it takes among
    /// those that it takes and those that stay unexplained. `None` for an `unknown`.
    pub probability: Option<f64>,
    /// The same line for the weight of it and its alternatives together: that one of them is what was left out.
    pub probability_with_alternatives: Option<f64>,
    /// Effects (`component.effect`) that do as well in its place, likeliest first, with the share by which the left-out
    /// mean square is greater (negative: smaller); each is worth more than half of what it is worth.
    pub alternatives: Vec<(String, f64)>,
    /// A test that would tell it from the likeliest of its alternatives for which the catalogue names one; where it names one for none of them,
    /// what shows the effect best. `None` without alternatives.
    pub separating_test: Option<String>,
    /// Whether its strength lies within two standard errors of the value that changes nothing.
    pub slight: bool,
    /// Shape of an `unknown`: quantity and correction at its knots.
    pub shape: Option<Shape>,
}

/// The range of one quantity in which the squares of a residual are most crowded.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// The independent variable, or the path of an input, a state or an instrument; as simulated by the re-fitted base.
    pub along: String,
    /// Its range, in the units of the assembly: SI where a unit is given; both ends the same where that is one value.
    pub range: (f64, f64),
    /// Share of the squares that lies there, of all where they fall.
    pub share: f64,
    /// Share of the samples that lies there.
    pub of_samples: f64,
}

/// A correction with no physics: piecewise linear along one quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// Reading (`instrument`) or state (`tank.level`) that is corrected.
    pub of: String,
    /// Quantity along which: a state, an input, an instrument, or the independent variable; as simulated without it.
    pub along: String,
    /// Knots, ascending.
    pub knots: Vec<f64>,
    /// Correction at the knots: added to the reading, or inflow (m³/s) added to the state's tank or volume.
    pub values: Vec<f64>,
}

/// An estimate.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// Path in `theta`.
    pub path: String,
    /// Meaning, of an effect's parameter.
    pub meaning: String,
    /// Estimate.
    pub value: f64,
    /// From the curvature with the residual's memory, or from what the folds of the validation differ, whichever is wider.
    pub standard_error: f64,
    /// 95 % interval: 1.96 standard errors to either side, as far as the bounds.
    pub ci95: (f64, f64),
    /// Whether it sits on a bound.
    pub at_bound: bool,
}

/// Effects that this record cannot tell apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Class {
    /// Sets (`component.effect`) that predict left-out blocks alike, the claimed one first.
    pub members: Vec<Vec<String>>,
    /// Root mean square between the readings simulated by the first and by each, as a share of the residual's.
    pub apart: Vec<f64>,
    /// A test that would separate the first from another, the first for which the catalogue names one; where it names one for none,
    /// what shows the claimed effect best.
    pub separating_test: Option<String>,
}

/// How an effect fared.
#[derive(Debug, Clone, PartialEq)]
pub struct Tested {
    /// Component.
    pub component: String,
    /// Id of the effect.
    pub effect: &'static str,
    /// A few words.
    pub title: &'static str,
    /// Outcome.
    pub outcome: Outcome,
    /// Share of the residual's square that it takes away at its best, by the linear model.
    pub gain: f64,
    /// Its score in standard deviations, whitened.
    pub score: f64,
    /// Distance from neutral of its first parameter that would have shown at five standard deviations.
    pub limit: Option<f64>,
}

/// Outcome of a test.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Among the findings.
    Found,
    /// Part of the model, with too little weight for a finding.
    Possible,
    /// As good as one of the findings.
    Alternative,
    /// It explains much alone, and adds nothing to the findings or does not stand beside them.
    NotNeeded,
    /// Looked for and not seen, or with too little weight to be claimed; the checks name those.
    NotSeen,
    /// A re-fit of the free parameters does the same: it cannot be seen here, and it does not matter here.
    Absorbed,
    /// The record does not excite it.
    NotTestable,
}

/// A check.
#[derive(Debug, Clone, PartialEq)]
pub struct Check {
    /// What was checked.
    pub name: String,
    /// Whether it passed.
    pub passed: bool,
    /// Numbers.
    pub detail: String,
}

/// A set of effects that was fitted to the end.
#[derive(Debug, Clone, PartialEq)]
pub struct Contender {
    /// `component.effect`; empty for the base.
    pub members: Vec<String>,
    /// Root mean square of the training residual, as a share of the base's.
    pub training: f64,
    /// Root mean square on left-out blocks, as a share of the base's.
    pub left_out: f64,
    /// Standard error of the left-out mean square against the best set's, as a share of the base's mean square.
    pub standard_error: f64,
}

/// A fitted assembly.
#[derive(Debug, Clone)]
pub struct Model {
    /// With the fitted values as starts; [`Assembly::to_toml`] writes it down.
    pub assembly: Assembly,
    /// Parameters in the order of [`Assembly::parameters`].
    pub theta: Vec<f64>,
    /// The same with their doubt.
    pub parameters: Vec<Estimate>,
}

/// How one instrument's reading is met, in SI.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputGain {
    /// Instrument.
    pub output: String,
    /// Training residual, root mean square, before and after.
    pub training: (f64, f64),
    /// The same on left-out blocks.
    pub left_out: (f64, f64),
    /// The same on the test part; NaN without one.
    pub test: (f64, f64),
    /// 95 % interval of 1 − after/before on the test part, by a moving-block bootstrap; NaN without one.
    pub test_gain_ci95: (f64, f64),
}

/// One window, measured beside simulated.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// Whether it is of the test part.
    pub test: bool,
    /// Independent variable.
    pub time: Vec<f64>,
    /// Each instrument's name, readings (empty if not recorded), simulated before, simulated after.
    pub outputs: Vec<Signal>,
}

/// One instrument in a window.
#[derive(Debug, Clone, PartialEq)]
pub struct Signal {
    /// Instrument.
    pub output: String,
    /// As recorded; NaN where nothing was.
    pub measured: Vec<f64>,
    /// By the model without the findings.
    pub before: Vec<f64>,
    /// By the model with them.
    pub after: Vec<f64>,
}

/// A stretch of the independent variable with parameters of its own.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// Start.
    pub from: f64,
    /// End.
    pub to: f64,
    /// Parameters fitted in it alone, by path.
    pub parameters: Vec<(String, f64)>,
    /// Root mean square of the residual there by output, with common parameters.
    pub common: Vec<f64>,
    /// The same with its own.
    pub own: Vec<f64>,
    /// Effects (`component.effect`) of the model that is fitted there; not the findings if fewer do better in sections.
    pub cause: Vec<String>,
}

/// Where the revision stands, for progress bars.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// The base is fitted again.
    Baseline,
    /// The catalogue is held against the residual.
    Screening,
    /// Sets of this size are fitted.
    Fitting(usize),
    /// Others are exchanged for what was found.
    Exchanging,
    /// The test part is looked at, once.
    Confirming,
}

/// Settings of a revision.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Further starts of the base's fit; 4 by default.
    pub more_starts: usize,
    /// Most effects that are fitted together; 4 by default.
    pub most_effects: usize,
    /// Effects of which all pairs are fitted; 14 by default.
    pub pool: usize,
    /// Sets of each size that are fitted to the end; 8 by default.
    pub scored: usize,
    /// Significance of the gate; 0.01 by default, at least 0.005, as 999 draws tell no less of five tests.
    pub gate: f64,
    /// Least share of the left-out root mean square that must go; 0.01 by default.
    pub least_gain: f64,
    /// Threads; all of the machine if 0. The answer does not depend on it.
    pub threads: usize,
    /// Settings of the simulations.
    pub simulation: SimulationOptions,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            more_starts: 4,
            most_effects: 4,
            pool: 14,
            scored: 8,
            gate: 0.01,
            least_gain: 0.01,
            threads: 0,
            simulation: SimulationOptions::default(),
        }
    }
}
