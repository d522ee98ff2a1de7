//! The chain, step by step.

use crate::baseline::{self, Baseline};
use crate::belief;
use crate::blocks::{Blocks, null_probability};
use crate::choice;
use crate::conclude::{self, Evidence};
use crate::confirm::TestPart;
use crate::context::{Context, Trial};
use crate::empirical::{self, Corrected};
use crate::error::ReviseError;
use crate::floor;
use crate::noise;
use crate::parallel::Threads;
use crate::revision::{Excuse, Options, Revision, Stage};
use crate::screen::{Screened, screen, screen_inside};
use crate::sets::{self, Scored, Width};
use crate::stack::Data;
use crate::validate::{Folds, LeftOut};
use dgd_assembly::{Assembly, Portion, Record, effects_for};
use std::collections::BTreeSet;

/// What is claimed before the test part is seen.
#[derive(Default)]
pub(crate) struct Claim {
    /// Number of the chosen set among those scored.
    pub set: Option<usize>,
    /// A correction, on top of that set, or of the base.
    pub correction: Option<Corrected>,
    /// Why it is withdrawn after all, if it is.
    pub withdrawn: Option<Withdrawn>,
}

/// Why something that was chosen is not claimed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Withdrawn {
    /// It cannot be simulated on the test part.
    NotRun,
    /// The squares of all instruments on the test part together are no fewer with it.
    Worse,
    /// They are fewer, but those of no instrument by more than chance.
    Chance,
    /// No member has a weight of a half, chance and what stays unexplained counted.
    Outweighed,
}

/// Fewest readings of the training part.
const FEWEST: usize = 40;
/// Rounds in which members are exchanged. Set by hand.
const EXCHANGES: usize = 3;
/// Sets that are given up for their placebo before nothing is claimed.
const REFUSED: usize = 60;
/// Significance below which the scores of the gate never open it, whatever is left out.
const LEAST_GATE: f64 = 0.005;
/// Corrections that are fitted, of all that were weighed.
const CORRECTIONS: usize = 8;

/// Says what `assembly` leaves out of `record`.
///
/// - `record`: the columns, of which the description names the training and the test part.
/// - `watch`: told each [`Stage`] as it begins.
///
/// The test part is simulated once, after everything was chosen. The answer depends on its input alone, not on
/// [`Options::threads`].
///
/// # Errors
/// [`ReviseError::Assembly`] if record and assembly do not fit, [`ReviseError::TooShort`], [`ReviseError::NotRun`] if no
/// parameters within the bounds can be simulated, [`ReviseError::Option`].
///
/// ```
/// use dgd_assembly::{Assembly, Record};
/// use dgd_revise::{Options, Verdict, revise};
/// let text = r#"
/// connections = ["tank -> valve -> atmosphere"]
/// [components]
/// tank = { kind = "tank", area = 1.0 }
/// valve = { kind = "valve" }
/// gauge = { kind = "instrument", measures = "level", of = "tank", channel = "h" }
/// [initial]
/// "tank.level" = 1.0
/// [free]
/// "valve.flow_coefficient" = { start = 3e-5, low = 1e-6, high = 1e-3 }
/// "#;
/// // A tank that empties evenly in its root, as the textbook says; a millimetre of jitter.
/// let fall = 0.5e-4 * (1000.0f64 * 9.80665).sqrt();
/// let h: Vec<f64> = (0..120u32)
///     .map(|t| (1.0 - fall * f64::from(t)).powi(2) + 1e-3 * (f64::from(t * t % 97) / 48.0 - 1.0))
///     .collect();
/// let found = revise(
///     &Assembly::parse(text)?,
///     &Record { columns: vec![("h", &h)] },
///     &Options::default(),
///     &mut |_stage| {},
/// )?;
/// assert_eq!(found.verdict, Verdict::Consistent);
/// # Ok::<(), dgd_revise::ReviseError>(())
/// ```
pub fn revise(
    assembly: &Assembly,
    record: &Record<'_>,
    options: &Options,
    watch: &mut dyn FnMut(Stage),
) -> Result<Revision, ReviseError> {
    check(options)?;
    let train = assembly.windows(record, Portion::Train)?;
    // Where no tank says what is usual, the record does.
    let assembly = &assembly.sized_by(&train)?;
    let train = Data::training(train);
    let test = TestPart::new(assembly.held_out(record)?);
    if train.rows.len() < FEWEST {
        return Err(ReviseError::TooShort {
            expected: FEWEST,
            found: train.rows.len(),
        });
    }
    let loose = &assembly.with_loose_starts(&train.windows)?;
    let threads = &Threads::new(options.threads);
    let mut context = Context {
        assembly: loose,
        asked: assembly,
        data: &train,
        scale: vec![1.0; assembly.outputs().len()],
        simulation: options.simulation,
        threads,
        hypotheses: effects_for(assembly),
    };
    watch(Stage::Baseline);
    let base_trial = baseline::fit_base(&mut context, options.more_starts)?;
    let context = context;
    let base = Baseline::of(&context, &base_trial).ok_or(ReviseError::NotRun)?;

    watch(Stage::Screening);
    let memory = base.noise.memory();
    let blocks = Blocks::new(&train, memory);
    let corrections = empirical::survey(&context, &base, &base_trial, &blocks);
    let (screened, gate) = screening(&context, &base, &base_trial, &blocks, &corrections);
    let levels = floor::levels(&context, &base_trial, &base.noise, &base.residual);
    let excuse = excuse(&context, &levels);
    tracing::debug!(?gate, memory, ?excuse, ?levels, "gate");
    let in_time = assembly.system().independent == "time";
    let folds = Folds::new(&train, in_time, memory);
    let base_left = folds
        .of_trial(&context, &base_trial)
        .ok_or(ReviseError::NotRun)?;
    let mut evidence = Evidence {
        context: &context,
        options,
        test: &test,
        in_time,
        memory,
        base: &base,
        base_trial: &base_trial,
        base_left,
        screened: &screened,
        gate,
        levels,
        excuse,
        unlikely: Vec::new(),
        scored: Vec::new(),
        refused: BTreeSet::new(),
        claim: Claim::default(),
    };
    if evidence.open(&gate) && evidence.excuse.is_none_or(|e| e == Excuse::Small) {
        let chosen = search(&mut evidence, &folds, &blocks, watch);
        evidence.claim = claim(&evidence, &folds, &blocks, &corrections, chosen);
    }
    conclude::conclude(evidence, &folds, watch)
}

/// How every effect fares beside the base, and the [`gate`].
fn screening(
    context: &Context<'_>,
    base: &Baseline,
    base_trial: &Trial,
    blocks: &Blocks,
    corrections: &[empirical::Candidate],
) -> (Vec<Screened>, [f64; 5]) {
    let numbers: Vec<usize> = (0..context.hypotheses.len()).collect();
    let mut screened = screen(context, base, blocks, &numbers);
    let gate = gate(context, base, &screened, corrections);
    if let Some(inside) = baseline::inside(context, base_trial) {
        screen_inside(context, &inside, blocks, &mut screened);
    }
    (screened, gate)
}

/// Scores sets of effects, and chooses the one to be claimed, if any is worth it.
fn search(
    e: &mut Evidence<'_, '_>,
    folds: &Folds,
    blocks: &Blocks,
    watch: &mut dyn FnMut(Stage),
) -> Option<usize> {
    let (context, options) = (e.context, e.options);
    let width = Width {
        pool: options.pool,
        scored: options.scored,
        most: options.most_effects,
    };
    let base = Scored {
        trial: e.base_trial.clone(),
        left: e.base_left.clone(),
    };
    e.scored = sets::search(
        context,
        folds,
        blocks,
        (e.base, base),
        e.screened,
        width,
        &mut |size| watch(Stage::Fitting(size)),
    );
    watch(Stage::Exchanging);
    let exchanged = exchanged(e, folds);
    let chosen = exchanged.and_then(|k| likely(e, folds, k))?;
    if let Some(trial) = context.refine(&e.scored[chosen].trial, baseline::FULL)
        && let Some(left) = folds.of_trial(context, &trial)
    {
        e.scored[chosen] = Scored { trial, left };
    }
    let set = &e.scored[chosen];
    let gain = 1.0 - (set.left.mean() / e.scored[0].left.mean()).sqrt();
    (!set.trial.members.is_empty() && gain >= options.least_gain).then_some(chosen)
}

/// The likeliest set that stands; those that do not are refused, and sets in which another effect takes a member's place are scored too.
fn exchanged(e: &mut Evidence<'_, '_>, folds: &Folds) -> Option<usize> {
    let context = e.context;
    let (mut chosen, mut stood) = (None, BTreeSet::new());
    let mut rounds = 0;
    // What does as well in a member's place may do better, and have others of its own.
    while rounds < EXCHANGES {
        let Some(best) = choice::choose(&e.scored, context.hypotheses.len(), &e.refused) else {
            break;
        };
        let now = choice::prune(context, folds, &mut e.scored, best);
        if !e.scored[now].trial.members.is_empty() && !stood.contains(&now) {
            if !choice::stand(context, e.memory, folds, &mut e.scored, now) {
                // What it was pruned from stands no better.
                e.refused.extend([best, now]);
                if e.refused.len() > REFUSED {
                    break;
                }
                continue;
            }
            stood.insert(now);
        }
        rounds += 1;
        if chosen == Some(now) || e.scored[now].trial.members.is_empty() {
            chosen = Some(now);
            break;
        }
        chosen = Some(now);
        let most = e.options.scored;
        let swaps = sets::swaps(context, folds, &e.scored[now], &e.scored, e.screened, most);
        e.scored.extend(swaps);
    }
    chosen
}

fn check(options: &Options) -> Result<(), ReviseError> {
    let refuse = |name, found, expected| {
        Err(ReviseError::Option {
            name,
            found,
            expected,
        })
    };
    if !(options.gate >= LEAST_GATE && options.gate < 1.0) {
        return refuse(
            "gate",
            options.gate,
            "at least 0.005 (five tests, of which 999 draws tell no probability below 0.001) and less than 1",
        );
    }
    if !(options.least_gain >= 0.0 && options.least_gain < 1.0) {
        return refuse(
            "least_gain",
            options.least_gain,
            "at least 0 and less than 1",
        );
    }
    for (name, n) in [
        ("most_effects", options.most_effects),
        ("scored", options.scored),
    ] {
        if n == 0 {
            return refuse(name, 0.0, "at least 1");
        }
    }
    if options.pool < 2 {
        return refuse("pool", options.pool as f64, "at least 2");
    }
    Ok(())
}

/// Probabilities of what is seen if nothing but noise is left: of the greatest scores, catalogue whitened and plain,
/// corrections whitened and plain; and of the residual's memory, if the noise is white.
fn gate(
    context: &Context<'_>,
    base: &Baseline,
    screened: &[Screened],
    corrections: &[empirical::Candidate],
) -> [f64; 5] {
    let sums = || {
        screened
            .iter()
            .filter(|s| s.usable())
            .flat_map(|s| s.sums.iter())
    };
    let fine = sums().map(|s| vec![s.0.as_slice()]);
    let coarse = sums().map(|s| vec![s.1.as_slice()]);
    let free_fine = corrections
        .iter()
        .map(|c| c.sums.0.iter().map(Vec::as_slice).collect::<Vec<_>>());
    let free_coarse = corrections
        .iter()
        .map(|c| c.sums.1.iter().map(Vec::as_slice).collect::<Vec<_>>());
    [
        null_probability(fine, 1),
        null_probability(coarse, 2),
        null_probability(free_fine, 3),
        null_probability(free_coarse, 4),
        memory_probability(context, base),
    ]
}

fn excuse(context: &Context<'_>, levels: &[floor::Level]) -> Option<Excuse> {
    let accuracies = context.assembly.accuracies();
    let within = |l: &&floor::Level| {
        let off = l.rms * context.scale[l.output];
        accuracies[l.output].is_some_and(|a| off <= a)
    };
    let others: Vec<&floor::Level> = levels.iter().filter(|l| !within(l)).collect();
    if others.is_empty() {
        return Some(Excuse::Accuracy);
    }
    [
        (floor::NOTHING, Excuse::Noise),
        (floor::SMALL, Excuse::Small),
    ]
    .into_iter()
    .find(|(share, _)| floor::too_small(&others, *share))
    .map(|(_, excuse)| excuse)
}

/// The chosen set without the members of low weight, which are noted, unless what is left does not stand.
fn likely(e: &mut Evidence<'_, '_>, folds: &Folds, chosen: usize) -> Option<usize> {
    let context = e.context;
    let unexplained = {
        let residuals = &e.scored[chosen].trial.minimum.residuals;
        let outputs = context.scale.len();
        let levels = floor::plain(context.data, residuals, outputs, &context.scale, &[]);
        floor::unexplained(&levels)
    };
    // What stands alone is withdrawn or not when all has been counted.
    let several = e.scored[chosen].trial.members.len() > 1;
    for (member, weight) in belief::of_members(&e.scored, chosen, &e.refused) {
        let mut loss = (f64::INFINITY, 0.0);
        if several
            && let Some(k) =
                choice::find_or_fit_reduced(context, folds, &mut e.scored, chosen, member)
        {
            let mean = e.scored[chosen].left.mean().max(1e-300);
            let (more, error) = e.scored[k].left.less(&e.scored[chosen].left);
            loss = (more / mean, error / mean);
        }
        if let Some(weight) = belief::unlikely(weight, loss, unexplained) {
            e.unlikely.push((member, weight));
        }
    }
    let mut now = chosen;
    for &(member, _) in &e.unlikely {
        now = choice::find_or_fit_reduced(context, folds, &mut e.scored, now, member)?;
    }
    // The others must stand without what was taken away.
    let stands = e.unlikely.is_empty()
        || e.scored[now].trial.members.is_empty()
        || choice::stand(context, e.memory, folds, &mut e.scored, now);
    stands.then_some(now)
}

/// The least of the instruments' probabilities by Ljung and Box, times their number.
fn memory_probability(context: &Context<'_>, base: &Baseline) -> f64 {
    let outputs = context.scale.len();
    (0..outputs)
        .map(|o| {
            let rows = context.data.of_output(o);
            let values: Vec<f64> = rows.iter().map(|&i| base.residual[i]).collect();
            let (_, deviate) = noise::portmanteau(&values, noise::lags(values.len()));
            outputs as f64 * noise::upper_tail(deviate)
        })
        .fold(1.0, f64::min)
}

/// Mean square that must go for a correction to be preferred to a name, or claimed beside it.
const CLEAR: f64 = 0.75;
/// The same where there is no name to prefer.
const ENOUGH: f64 = 0.5;

/// The chosen set, unless a correction without physics clearly beats it; and a correction beside it that still takes much
/// away.
fn claim(
    e: &Evidence<'_, '_>,
    folds: &Folds,
    blocks: &Blocks,
    corrections: &[empirical::Candidate],
    chosen: Option<usize>,
) -> Claim {
    let (context, scored) = (e.context, &e.scored);
    let best =
        |trial: &Trial, candidates: &[empirical::Candidate], enough: f64| -> Option<Corrected> {
            let few: Vec<&empirical::Candidate> = candidates.iter().take(CORRECTIONS).collect();
            context
                .threads
                .map(&few, |c| empirical::fit(context, folds, trial, c, enough))
                .into_iter()
                .flatten()
                .min_by(|a, b| a.left.mean().total_cmp(&b.left.mean()))
        };
    let clearly = |c: &Corrected, than: &LeftOut, share: f64| {
        let (more, error) = c.left.less(than);
        tracing::debug!(
            place = ?c.candidate.place, along = c.candidate.along,
            ratio = (c.left.mean() / than.mean()).sqrt(), "correction"
        );
        c.left.mean() < share * than.mean() && more < -2.0 * error
    };
    let mut claim = Claim {
        set: chosen,
        ..Claim::default()
    };
    let enough = match chosen {
        Some(k) => CLEAR * scored[k].left.mean(),
        None => ENOUGH * scored[0].left.mean(),
    };
    let alone = best(e.base_trial, corrections, enough);
    let Some(set) = chosen.map(|k| &scored[k]) else {
        claim.correction = alone.filter(|c| clearly(c, &scored[0].left, ENOUGH));
        return claim;
    };
    if let Some(c) = alone
        && clearly(&c, &set.left, CLEAR)
    {
        return Claim {
            correction: Some(c),
            ..Claim::default()
        };
    }
    if let Some(beside) = Baseline::of(context, &set.trial) {
        let candidates = empirical::survey(context, &beside, &set.trial, blocks);
        claim.correction = best(&set.trial, &candidates, CLEAR * set.left.mean())
            .filter(|c| clearly(c, &set.left, CLEAR));
    }
    claim
}
