//! What a diagnosis says.

use crate::ablation::Step;
use crate::cost::Work;
use crate::free_run::{self, Part};
use dgd_effects::{AugmentedModel, Relation, Setting};
use dgd_recording::{Channel, Moment};
use dgd_screen::{Coarse, Kept};
use dgd_units::Dimension;

/// The whole answer.
#[derive(Debug, Clone, PartialEq)]
pub struct Diagnosis {
    /// The answer in a word.
    pub verdict: Verdict,
    /// What was found, most certain first; empty when consistent.
    pub findings: Vec<Finding>,
    /// Ids of the effects of the model to start from ([`Options::start`]) that the recording does not speak against.
    pub started_from: Vec<&'static str>,
    /// Ids of all that was fitted ([`Options::suspects`]); empty where that might be anything.
    pub suspected: Vec<String>,
    /// Every effect of the catalogue that the model does not hold: seen, not seen and down to which size, or not testable here.
    pub tested: Vec<Tested>,
    /// What makes the answer doubtful before it is read: not the rig but its description, or what is logged, may be at fault. The caller may add
    /// its own, such as units that are implausible; reports tell all of them first.
    pub warnings: Vec<String>,
    /// Checks on the findings, passed and failed.
    pub checks: Vec<Check>,
    /// The model without the findings, fitted on the training samples.
    pub before: AugmentedModel,
    /// The model with them, fitted on the training samples.
    pub after: AugmentedModel,
    /// What both models know of well and recording.
    pub setting: Setting,
    /// Measured and simulated series, one row a sample of the recording.
    pub simulation: Simulation,
    /// Residuals of each relation in blocks, before and after.
    pub traces: Vec<Trace>,
    /// The windows that the fits of `before` and `after` have not seen, s of the recording's clock.
    pub held_out_s: Vec<(f64, f64)>,
    /// When the recording's clock was at 0, where the caller knows ([`Options::began`]): what times become dates by.
    pub began: Option<Moment>,
    /// Settings and facts of the run, name and value.
    pub settings: Vec<(String, String)>,
    /// What it cost.
    pub work: Work,
}

/// The answer in a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Nothing is left out that this recording could show; of [`Options::suspects`], where those were given, none is likelier than not,
    /// and nothing else stands out.
    Consistent,
    /// What was left out is named.
    Explained,
    /// Something is named, something else is not: it is told as unknown, or an output runs worse with what is named on the held-out windows.
    PartlyExplained,
    /// Something is left out that the catalogue does not hold, or of which no cause could be identified (without a finding), or none of
    /// [`Options::suspects`] explains.
    Unexplained,
}

impl Verdict {
    /// Its name in machine-readable output.
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
    /// Id of the effect that an `unknown` looks like, and that stands for it in the model: where no correction tells it.
    pub resembles: Option<&'static str>,
    /// A few words for people.
    pub title: String,
    /// Probability that this effect was left out, by evidence above the hurdle that sound recordings do not reach.
    pub probability: f64,
    /// Other causes and their probabilities, likeliest first.
    pub alternatives: Vec<(String, f64)>,
    /// Where in the model it sits.
    pub relation: Relation,
    /// The relation it sits in; of a reading at fault, the relations whose residuals it enters.
    pub shows_in: Vec<Relation>,
    /// The comparison of two transmitters that a reading at fault enters, as [`Trace::pair`] has it.
    pub pair: Option<&'static str>,
    /// When it acts, s of the recording's clock.
    pub intervals_s: Vec<(f64, f64)>,
    /// Where in the operating space, in words with numbers.
    pub region: String,
    /// Estimates.
    pub parameters: Vec<ParameterEstimate>,
    /// The curve of an empirical correction, which has no parameters. An `unknown` has it, or [`Self::resembles`].
    pub curve: Option<CorrectionCurve>,
    /// Gain on the held-out windows, on the signal that gains most; where none gains, on the one that loses most.
    pub held_out: Option<HeldOut>,
    /// The relation as the base model has it, in plain notation.
    pub equation_before: String,
    /// The relation with the effect.
    pub equation_after: String,
    /// Where the equation comes from.
    pub source: String,
    /// Natural logarithm of the Bayes factor against the model without it.
    pub evidence: f64,
    /// Evidence that sound recordings, and what else was named, do not reach: that from which it is likely, and the least that it had to show to
    /// be named. Beside an `unknown` it had to show three times as much; a suspect, and what remains once the search has ended, nothing.
    pub hurdle: f64,
    /// A test that would tell it from its likeliest serious alternative, of those for which the catalogue knows one.
    pub separating_test: Option<String>,
    /// What would show the same if not the rig were at fault but the description of its well, or what is logged ([`dgd_effects::Effect::same_as`]).
    pub same_as: Option<String>,
}

/// Name of the check that no output runs worse with the findings where no fit has looked.
pub(crate) const NOT_WORSE: &str = "no output is made worse on held-out windows";

/// How many times as much as noise and wander explain the pump's head keeps of a sound rig at the most (root mean square), with a margin.
pub(crate) const MOST_OF_HEAD: f64 = 2.4;

/// Name of the check that no relation keeps more than noise with them.
pub(crate) const NOISE_IS_LEFT: &str = "what is left is noise";

impl Diagnosis {
    /// Whether anything that was found acts in a held-out window: elsewhere these windows can neither support it nor contradict it.
    pub fn acts_held_out(&self) -> bool {
        let mut acts = self.findings.iter().flat_map(|f| &f.intervals_s);
        acts.any(|(from, to)| self.held_out_s.iter().any(|(a, b)| from < b && to > a))
    }

    /// Why findings that are all named explain only part: what they leave, and what they make worse; nothing of any other verdict, nor
    /// where one of them is `unknown` and says it itself.
    pub fn shortfalls(&self) -> Vec<&'static str> {
        let unknown = self.findings.iter().any(Finding::is_unknown);
        if self.verdict != Verdict::PartlyExplained || unknown {
            return Vec::new();
        }
        let failed = |name: &str| self.checks.iter().any(|c| c.name == name && !c.passed);
        [
            (NOISE_IS_LEFT, "residual above noise"),
            (
                NOT_WORSE,
                "an output runs worse with it on the held-out windows",
            ),
        ]
        .into_iter()
        .filter_map(|(name, says)| failed(name).then_some(says))
        .collect()
    }

    /// What was not suspected and stands out by itself, where nothing that was suspected is likely: most evidence first, three at the most.
    pub fn unsuspected(&self) -> Vec<&Tested> {
        let explained = self.findings.iter().any(Finding::is_likely);
        if self.suspected.is_empty() || explained {
            return Vec::new();
        }
        let mut out: Vec<&Tested> = beside(&self.tested, &self.suspected).collect();
        out.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
        out.truncate(3);
        out
    }
}

/// What stands out and was not suspected.
pub(crate) fn beside<'t>(
    tested: &'t [Tested],
    suspected: &[String],
) -> impl Iterator<Item = &'t Tested> {
    let asked = |t: &Tested| suspected.iter().any(|id| id == t.effect);
    tested.iter().filter(move |t| t.stands_out() && !asked(t))
}

impl Finding {
    /// Probability from which on an alternative is a serious one.
    pub const SERIOUS: f64 = 0.05;

    /// Whether it is something that the catalogue does not hold.
    pub fn is_unknown(&self) -> bool {
        self.effect == dgd_effects::unknown().about().id
    }

    /// Whether it, or one of what it is not told from, is likelier there than not: what was only suspected
    /// ([`Options::suspects`]) need not be.
    pub fn is_likely(&self) -> bool {
        let others: f64 = self.alternatives.iter().map(|a| a.1).sum();
        self.probability + others >= 0.5
    }

    /// Says what else would show the same.
    pub(crate) fn also_same_as(&mut self, told: String) {
        self.same_as = Some(match self.same_as.take() {
            Some(known) => format!("{known}; or {told}"),
            None => told,
        });
    }

    /// Alternatives that deserve to be named, likeliest first.
    pub fn serious(&self) -> impl Iterator<Item = &(String, f64)> {
        (self.alternatives.iter()).filter(|(_, probability)| *probability >= Self::SERIOUS)
    }
}

/// What an empirical correction adds to its relation or reading, and along what: straight lines between knots.
#[derive(Debug, Clone, PartialEq)]
pub struct CorrectionCurve {
    /// The quantity that it runs along, with its SI unit.
    pub along: &'static str,
    /// What it adds, with its SI unit; of the return flow meter's factor, a share of the flow.
    pub adds: &'static str,
    /// The quantity at each knot, and what is added there.
    pub knots: Vec<(f64, f64)>,
    /// The one value that an episode adds as long as it acts ([`Finding::intervals_s`]); it adds nothing else.
    pub level: Option<f64>,
}

impl CorrectionCurve {
    /// Least and greatest of what it adds; `None` of no number.
    pub fn range(&self) -> Option<(f64, f64)> {
        let added = self.knots.iter().map(|k| k.1).filter(|v| v.is_finite());
        added.fold(None, |range, v| {
            let (low, high) = range.unwrap_or((v, v));
            Some((v.min(low), v.max(high)))
        })
    }
}

/// An estimated parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterEstimate {
    /// Name with its SI unit.
    pub name: String,
    /// What it is.
    pub meaning: String,
    /// Estimate.
    pub estimate: f64,
    /// 95 % interval.
    pub ci95: (f64, f64),
}

/// Gain of one signal on the held-out windows.
#[derive(Debug, Clone, PartialEq)]
pub struct HeldOut {
    /// Name of the signal with its SI unit.
    pub signal: String,
    /// Free-run RMSE without any of the findings: the same value in each.
    pub rmse_before: f64,
    /// Free-run RMSE with them.
    pub rmse_after: f64,
    /// 95 % interval of 1 - after/before, by a paired bootstrap over blocks.
    pub improvement_ci95: (f64, f64),
}

/// How an effect of the catalogue fared.
#[derive(Debug, Clone, PartialEq)]
pub struct Tested {
    /// Its id.
    pub effect: &'static str,
    /// A few words.
    pub title: &'static str,
    /// Outcome.
    pub outcome: Outcome,
    /// Natural logarithm of its Bayes factor against nothing, when it was first weighed.
    pub evidence: f64,
    /// Name of its strength, with the unit.
    pub strength: &'static str,
    /// Whether it might be named but for its evidence: its strength material, within bounds, and there to see.
    pub admissible: bool,
    /// Evidence that it must show to be named first.
    pub hurdle: f64,
    /// Standard error that a fit of its strength has on this recording beside the base model (Cramér-Rao), if it has one.
    pub standard_error: Option<f64>,
    /// The smallest strength that would have been named on this recording, as weighed in the last round of the search, beside what was
    /// named by then; a departure from what the model holds, never below an instrument's accuracy. `None` where nothing excites the effect,
    /// where it may not be named beside what was, where it could not be told from one that was there from the start, where only a
    /// strength beyond what is plausible or weighed would do (what was named may hide it), and of swell where the sampling is too slow or too much is missing.
    pub limit: Option<f64>,
}

impl Tested {
    /// Whether a finding gives its strength whole, as a gain or an area: then [`Self::limit`] is a departure from that of the model, to either side.
    pub fn is_departure(&self) -> bool {
        let strength = dgd_effects::find(self.effect).and_then(|e| e.about().parameters.first());
        strength.is_some_and(|p| p.shown != dgd_effects::Shown::AsCarried)
    }

    /// Whether it was not found, and explained enough when it was first weighed: beside the findings it is not needed.
    pub fn exceeded_its_hurdle(&self) -> bool {
        self.outcome == Outcome::NotSeen && self.evidence > self.hurdle
    }

    /// Whether it exceeded its hurdle and might have been named: where only some effects were looked for, it may be what is there.
    pub fn stands_out(&self) -> bool {
        self.admissible && self.exceeded_its_hurdle()
    }
}

/// Outcome of a test.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// It is among the findings.
    Found,
    /// Among the findings is an `unknown` that looks like it, and that it stands for in the model.
    Resembled,
    /// It was looked for and not seen.
    NotSeen,
    /// The recording does not excite it, or would have it named at no plausible strength; why.
    NotTestable(String),
}

/// A check on the findings.
#[derive(Debug, Clone, PartialEq)]
pub struct Check {
    /// What was checked.
    pub name: String,
    /// Whether it passed.
    pub passed: bool,
    /// Numbers.
    pub detail: String,
}

/// Measured beside simulated.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulation {
    /// Time, s of the recording's clock.
    pub t_s: Vec<f64>,
    /// Whether a sample is held out from every fit.
    pub held_out: Vec<bool>,
    /// Whether the screening trusts the sample.
    pub valid: Vec<bool>,
    /// `return_flow_m3_s`, `riser_level_m`, `pump_outlet_pressure_pa`, `pump_head_m`.
    pub signals: Vec<Signal>,
}

impl Simulation {
    /// Root mean square errors of a signal before and after, on the samples that are held out and trusted and of which both models tell something; `None`
    /// where there are none.
    pub fn held_out_rmse(&self, signal: &Signal) -> Option<(f64, f64)> {
        let errors = free_run::errors_of(self, signal, Part::HeldOut)?;
        Some((errors.before, errors.after))
    }
}

/// One signal; NaN where there is nothing to compare.
#[derive(Debug, Clone, PartialEq)]
pub struct Signal {
    /// Name with its SI unit.
    pub name: &'static str,
    /// As recorded.
    pub measured: Vec<f64>,
    /// By the model without the findings.
    pub before: Vec<f64>,
    /// By the model with them.
    pub after: Vec<f64>,
}

/// Residual of one relation over time.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// The relation.
    pub relation: Relation,
    /// Which two transmitters are held against each other, in words; `None` for a relation.
    pub pair: Option<&'static str>,
    /// Unit of the residual: `Pa` or `m3/s`.
    pub unit: &'static str,
    /// Middle of each block, s of the recording's clock.
    pub t_s: Vec<f64>,
    /// Residual of the model without the findings; NaN where the block is not used.
    pub before: Vec<f64>,
    /// Residual with them.
    pub after: Vec<f64>,
    /// By how much the first of two transmitters reads more than the second throughout, which the residual is less by; 0 of a relation.
    pub offset: f64,
    /// Standard deviation of a block's residual when nothing is left out, wander aside.
    pub noise: f64,
    /// Standard deviation, over minutes and hours, of what instruments within their accuracy may wander by on top of it.
    pub wander: f64,
}

impl Trace {
    /// Standard deviation of a block's residual when nothing is left out: noise, and wander on top of it.
    #[must_use]
    pub fn expected_sd(&self) -> f64 {
        self.noise.hypot(self.wander)
    }

    /// Whether more is left with the findings than noise and wander make: in the pump's head, whose curve may have a hump, 2.4 times as much
    /// (root mean square), and elsewhere twice. Of 300 simulated sound recordings the most that was left is 2.14 times as much, in the head, and 1.4
    /// elsewhere; of 363 with the right name the head kept 1.98.
    #[must_use]
    pub fn exceeds_noise(&self) -> bool {
        let most = match (self.pair, self.relation) {
            (None, Relation::PumpHead) => MOST_OF_HEAD,
            _ => 2.0,
        };
        self.excess() > most
    }

    /// How many times as much is left with the findings (root mean square) as may be; NaN where nothing is.
    #[must_use]
    pub fn excess(&self) -> f64 {
        times(&self.after, self.expected_sd())
    }
}

/// Root mean square of the values that are finite, in standard deviations; NaN of none.
pub(crate) fn times(values: &[f64], sd: f64) -> f64 {
    let finite = values.iter().filter(|v| v.is_finite());
    let (sum, count) = finite.fold((0.0, 0.0), |(sum, n), v| (sum + v * v, n + 1.0));
    (sum / count).sqrt() / sd
}

/// Where the diagnosis stands, for progress bars.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Base parameters are re-fitted and the noise is measured.
    Baseline,
    /// The catalogue is held against the residuals; the round, from 1.
    Screening(usize),
    /// The best hypotheses are fitted together.
    Fitting,
    /// Free runs on the held-out windows.
    Confirming,
}

/// Options of a diagnosis.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Effects already in the model that the diagnosis starts from; they are fitted again where the recording shows them.
    pub start: Vec<dgd_effects::AppliedEffect>,
    /// Most effects that are fitted together.
    pub most_effects: usize,
    /// Ids of the only effects that are fitted, whatever their evidence; the probability of each says whether it is there, and is low where
    /// a search of the whole catalogue does not name it and leaves nothing of it to be seen. Empty for the whole catalogue.
    pub suspects: Vec<String>,
    /// Steps of the chain that are left out; for measuring what each contributes.
    pub without: Vec<Step>,
    /// When the recording's clock was at 0, if that is known; it changes no finding, and stands in the answer.
    pub began: Option<Moment>,
    /// What an archive has left out of the recording; causes that this can make up are likelier something else then.
    pub archived: Archived,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            start: Vec::new(),
            most_effects: 6,
            suspects: Vec::new(),
            without: Vec::new(),
            began: None,
            archived: Archived::default(),
        }
    }
}

/// What an archive has left out of a recording, as `dgd_screen::coarse` tells it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Archived {
    /// Pressures lie on straight lines between a few readings.
    pub pressures: bool,
    /// So does the return flow or the mud pump's.
    pub flows: bool,
    /// The pump's speed moves by a deadband.
    pub speed: bool,
}

impl Archived {
    /// By the channels of which too little is kept.
    ///
    /// ```
    /// # use dgd_diagnose::Archived;
    /// assert_eq!(Archived::of(&[]), Archived::default());
    /// ```
    pub fn of(coarse: &[Coarse]) -> Self {
        let mut told = Self::default();
        for one in coarse {
            match (one.kept, one.channel) {
                (Kept::OnLines(_), Channel::ReturnFlow | Channel::MudPumpFlow) => told.flows = true,
                (Kept::OnLines(_), channel) => {
                    told.pressures |= channel.dimension() == Dimension::Pressure;
                }
                (Kept::Moves(_), Channel::PumpSpeed) => told.speed = true,
                _ => {}
            }
        }
        told
    }
}

/// Longest step of a clock on which causes are told apart, s: drilling acts in minutes.
pub(crate) const MOST_STEP_S: f64 = 60.0;

/// Why there is no diagnosis.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DiagnoseError {
    /// What was screened does not belong together.
    #[error(transparent)]
    Prepared(#[from] dgd_screen::ScreenError),
    /// The well cannot be.
    #[error(transparent)]
    Well(#[from] dgd_recording::WellError),
    /// Samples too far apart.
    #[error(
        "the samples are {step_s} s apart, a diagnosis needs {MOST_STEP_S} s or less: sample more often, or correct the unit of the time"
    )]
    Step {
        /// Step of the clock, s.
        step_s: f64,
    },
    /// No effect may be named.
    #[error("option `most_effects` is 0, expected at least 1")]
    NoEffects,
    /// The recording is too short.
    #[error(
        "the recording holds {blocks} blocks of {block_s} s, a diagnosis needs {needed} ({:.0} min): record for longer",
        *needed as f64 * block_s / 60.0
    )]
    TooShort {
        /// Length of a block, s.
        block_s: f64,
        /// Blocks of the recording.
        blocks: usize,
        /// Blocks needed.
        needed: usize,
    },
    /// Too little of the recording can be used.
    #[error(
        "flow and pressures can be used in {usable} of {blocks} blocks of {block_s} s, a diagnosis needs {needed} besides its held-out windows: \
         check what the screening rejects, or record for longer"
    )]
    TooFew {
        /// Length of a block, s.
        block_s: f64,
        /// Blocks in which both line and pump can be judged, held out or not.
        usable: usize,
        /// Blocks of the recording.
        blocks: usize,
        /// Blocks needed outside the held-out windows, of the line and of the pump.
        needed: usize,
    },
    /// A suspect is no effect of the catalogue.
    #[error(
        "the catalogue has no effect `{id}`; it has {}",
        dgd_effects::catalogue().iter().map(|e| e.about().id).collect::<Vec<_>>().join(", ")
    )]
    NotInCatalogue {
        /// As given.
        id: String,
    },
    /// The model to start from holds an effect that the catalogue does not.
    #[error(transparent)]
    UnknownEffect(#[from] dgd_effects::UnknownEffect),
}

#[cfg(test)]
mod tests;
