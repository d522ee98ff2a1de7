//! Every effect of the catalogue against what is left over, and the conditions on those that stand out.

mod late;

pub(crate) use late::put_on_one_scale;

use crate::ablation::Step;
use crate::bayes::{evidence_at, ln_mean_exp};
use crate::cores::apiece;
use crate::empirical::excess;
use crate::numbers::whole;
use crate::record::Record;
use crate::refine::refine;
use crate::relations::{Applied, joined, on_grid};
use crate::scan::{Candidate, likeliest, more_places, scan, searched, sharpen, weigh};
use crate::tangent::{Bend, Tangent};
use dgd_effects::{About, Effect, Method, Relation, catalogue};
use dgd_lsq::dot;
use dgd_recording::{Rank, quantile};
use late::{retime, take_off_what_noise_brings};
use rayon::prelude::*;
use std::sync::OnceLock;

/// One effect in one round.
#[derive(Clone)]
pub(crate) struct Contender {
    pub effect: &'static dyn Effect,
    pub best: Candidate,
    /// Logarithm of the Bayes factor against nothing.
    pub evidence: f64,
    /// Evidence when the effect's form may bend within its error as well; only the likeliest few are weighed so, of others it is `evidence`.
    pub formed: f64,
    /// Evidence that a late meter loses because its lag is undone by a slope over many seconds, which blurs the flow; 0 for others.
    pub lost: f64,
    /// What is added to the claim of a late meter so that it compares with another one's (see [`put_on_one_scale`]); otherwise 0.
    pub evened: f64,
    /// Evidence that was taken off because ten minutes showed far more than the effect would.
    pub once: f64,
    /// Strengths and the energies of what they change, where they are on a grid.
    pub strengths: Vec<(f64, f64)>,
    /// The shape that changes the rows most per unit of strength, without its signature.
    pub plainest: Candidate,
}

impl Contender {
    /// Which of the catalogue it is.
    pub(crate) fn id(&self) -> &'static str {
        self.effect.about().id
    }

    /// Evidence that it may claim as its own. A form that must bend by much more than its error is another cause's, so what bending gains
    /// counts up to a limit; a lower one where the strength may differ in each stand, which bends at will.
    pub(crate) fn claim(&self) -> f64 {
        /// How many errors of its form an effect may claim by, and how many where its strength differs by stands. Set by hand.
        const ERRORS: f64 = 4.0;
        const ERRORS_BY_STANDS: f64 = 1.0;
        /// E-folds that any form may gain by bending. Set by hand.
        const FREE: f64 = 5.0;
        let search = &self.effect.about().search;
        let errors = if search.stand_error.is_some() {
            ERRORS_BY_STANDS
        } else {
            ERRORS
        };
        let most = (1.0 + errors * search.form_error) * self.evidence + FREE;
        self.formed.min(most) + self.evened
    }

    /// Evidence as it would be if nothing were lost by undoing a lag (see [`Self::lost`]).
    pub(crate) fn unblurred(&self) -> f64 {
        self.evidence + self.lost
    }

    /// The same with what happened once put back: a suspect is weighed alone, whatever else there is.
    pub(crate) fn alone(&self) -> Self {
        Self {
            evidence: self.evidence + self.once,
            formed: self.formed + self.once,
            once: 0.0,
            ..self.clone()
        }
    }

    /// By how many e-folds less another effect must claim to be less likely by a factor e. Near the noise a Bayes factor counts nearly in
    /// full; far above it the errors of forms decide, and those grow with the evidence.
    pub(crate) fn temperature(&self) -> f64 {
        /// Far above the noise, as a share of the claim. Set by hand.
        const SHARE: f64 = 0.06;
        /// Near the noise, e-folds. Set by hand.
        const LEAST: f64 = 1.5;
        (SHARE * self.claim()).hypot(LEAST)
    }
}

/// Contenders whose form is freed.
const LIKELIEST: usize = 6;

/// What effects are weighed on: residuals of curves that were fitted beside a state.
struct Tangents<'a> {
    record: &'a Record,
    state: &'a [Applied],
    /// The head may lean on the inlet pressure.
    lean: &'a Tangent,
    /// It may not; fitted when it is first asked for.
    stiff: OnceLock<Option<Tangent>>,
}

impl Tangents<'_> {
    fn stiff(&self) -> Option<&Tangent> {
        let fitted = || Tangent::beside(self.record, self.state, &[], Bend::Stiff);
        self.stiff.get_or_init(fitted).as_ref()
    }
}

/// Evidence of every effect that a state does not hold, best first.
pub(crate) fn contest(record: &Record, gate: &Tangent, state: &[Applied]) -> Vec<Contender> {
    held_against_all(record, gate, state, catalogue())
}

/// Evidence of some effects, in the form that [ends](Effect::passing), best first.
pub(crate) fn ending(
    record: &Record,
    gate: &Tangent,
    state: &[Applied],
    asked: impl Fn(&About) -> bool,
) -> Vec<Contender> {
    let forms: Vec<&'static dyn Effect> = (catalogue().iter())
        .filter_map(|effect| effect.passing())
        .filter(|form| asked(form.about()))
        .collect();
    held_against_all(record, gate, state, &forms)
}

/// Evidence of some effects, of those that a state does not hold, best first.
fn held_against_all(
    record: &Record,
    gate: &Tangent,
    state: &[Applied],
    effects: &[&'static dyn Effect],
) -> Vec<Contender> {
    let mut out = contenders(record, gate, state, effects);
    likeliest_first(&mut out);
    hold_without_doubtful(record, gate, state, &mut out);
    take_off_what_happened_once(record, gate, &mut out);
    for c in &mut out {
        if c.evidence > c.effect.about().search.belief.hurdle {
            keep_within_bounds(record, gate, state, &mut c.best);
        }
    }
    retime(record, gate, state, &mut out);
    take_off_what_noise_brings(record, gate, state, &mut out);
    likeliest_first(&mut out);
    free_forms(record, gate, state, &mut out);
    put_on_one_scale(record, &mut out);
    out
}

fn likeliest_first(contenders: &mut [Contender]) {
    contenders.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
}

/// Those of some effects that a state does not hold, and those of them that come and go, at other times, weighed.
pub(crate) fn contenders(
    record: &Record,
    gate: &Tangent,
    state: &[Applied],
    effects: &[&'static dyn Effect],
) -> Vec<Contender> {
    let taken: Vec<&str> = state
        .iter()
        .filter(|a| !a.allowance && a.effect.about().duration().is_none())
        .map(|a| a.id())
        .collect();
    let tangents = Tangents {
        record,
        state,
        lean: gate,
        stiff: OnceLock::new(),
    };
    let effects: Vec<&'static dyn Effect> = (effects.iter().copied())
        .filter(|effect| {
            let about = effect.about();
            about.search.method == Method::Relations && !taken.contains(&about.id)
        })
        .collect();
    let found = searched(record, gate, state, &effects);
    let of = |(effect, found)| contender(&tangents, effect, found);
    (apiece(effects.into_iter().zip(found).collect(), of).into_iter())
        .flatten()
        .collect()
}

/// An effect in all the shapes and places that were tried of it; `None` where it changes nothing.
fn contender(
    tangents: &Tangents<'_>,
    effect: &'static dyn Effect,
    mut found: Vec<Candidate>,
) -> Option<Contender> {
    /// Evidence of a shape that cannot be weighed, e-folds: so little that it does not count in the mean over the shapes.
    const NONE: f64 = -1e3;
    /// Evidence, e-folds, from which an effect of the pump is weighed without the lean too. Set by hand.
    const LEAST: f64 = 1.0;
    /// E-folds that a switch of the pump pays for the places of a sharp peak. Set by hand.
    const SHARP: f64 = 4.0;
    let Tangents { record, state, .. } = *tangents;
    let span_s = record.setting.span_s;
    found.retain(|c| !again(state, &c.applied, span_s));
    let mut best = likeliest(record, tangents.lean, state, &found)?;
    let plainest = (found.iter().filter(|c| c.energy.is_finite()))
        .max_by(|a, b| a.energy.total_cmp(&b.energy))?
        .clone();
    let strengths = if on_grid(effect.about()) {
        let alike = |c: &&Candidate| c.applied.parameters[1..] == best.applied.parameters[1..];
        (found.iter().filter(alike))
            .map(|c| (c.applied.parameters[0], c.energy))
            .collect()
    } else {
        Vec::new()
    };
    // Candidates between grid points pay for how many were tried; a switch of the pump for the places of a sharp peak too.
    let more = more_places(effect, record);
    let sharp = if effect.is_switch() { SHARP } else { 0.0 };
    let places = (found.len() as f64).ln() + more + sharp;
    let weighed = |c: &Candidate| {
        if c.evidence.is_finite() {
            c.evidence
        } else {
            NONE
        }
    };
    let mut evidence = ln_mean_exp(found.iter().map(weighed)) - more;
    if is_pump(effect)
        && evidence > LEAST
        && let Some(apart) =
            (tangents.stiff()).and_then(|stiff| without_lean(record, stiff, state, &best))
    {
        evidence = evidence.min(apart.evidence - places);
        best = apart;
    }
    if let Some(far) = far(tangents, &best)
        && far.evidence - places > evidence
    {
        evidence = far.evidence - places;
        best = far;
    }
    Some(Contender {
        effect,
        best,
        evidence,
        formed: evidence,
        lost: 0.0,
        evened: 0.0,
        once: 0.0,
        strengths,
        plainest,
    })
}

/// Whether an effect acts while a state has it act already.
fn again(state: &[Applied], one: &Applied, span_s: (f64, f64)) -> bool {
    let about = one.effect.about();
    let (from, to) = about.interval_s(&one.parameters, span_s);
    let same = (state.iter()).filter(|held| !held.allowance && held.id() == about.id);
    same.map(|held| about.interval_s(&held.parameters, span_s))
        .any(|(begins, ends)| from < ends && to > begins)
}

/// Takes from contenders what they owe to blocks that may only look like them (see [`sustained`]).
fn hold_without_doubtful(
    record: &Record,
    gate: &Tangent,
    state: &[Applied],
    contenders: &mut [Contender],
) {
    /// Share of its hurdle, and of the leader's evidence, from which a contender is looked at: what the leader dwarfs is looked at again in
    /// the next round, beside it. Set by hand.
    const OF_HURDLE: f64 = 0.5;
    const OF_LEADER: f64 = 0.02;
    let most = contenders.first().map_or(0.0, |c| c.evidence);
    contenders.par_iter_mut().with_max_len(1).for_each(|c| {
        let hurdle = c.effect.about().search.belief.hurdle;
        if c.evidence > (OF_HURDLE * hurdle).max(OF_LEADER * most)
            && let Some(sustained) = sustained(record, state, &c.best, &gate.rows.still)
        {
            c.evidence = c.evidence.min(sustained);
            c.formed = c.evidence;
        }
    });
}

/// Takes from contenders what they owe to ten minutes that show far more of them than they would themselves: a loss of a quarter of an hour
/// is no error of a meter.
fn take_off_what_happened_once(record: &Record, gate: &Tangent, contenders: &mut [Contender]) {
    if !record.takes(Step::Busiest) {
        return;
    }
    // What passes may be short, and its edges are not quite its form's.
    let stays = |c: &&mut Contender| c.effect.about().duration().is_none();
    for c in (contenders.iter_mut())
        .filter(|c| c.evidence > 0.0)
        .filter(stays)
    {
        let best = &c.best;
        let strength = if on_grid(best.applied.effect.about()) {
            1.0
        } else {
            best.score / best.energy
        };
        c.once = excess(record, gate, &best.signature, strength);
        c.evidence -= c.once;
        c.formed = c.evidence;
    }
}

/// Weighs the likeliest, which come first, with their forms within their errors.
fn free_forms(record: &Record, gate: &Tangent, state: &[Applied], contenders: &mut [Contender]) {
    /// Share of the leader's evidence below which a form is not freed. Set by hand.
    const OF_LEADER: f64 = 0.3;
    let most = contenders.first().map_or(0.0, |c| c.evidence);
    let likeliest = contenders.par_iter_mut().take(LIKELIEST);
    likeliest.with_max_len(1).for_each(|c| {
        if record.takes(Step::Form) && c.evidence > OF_LEADER * most {
            // It pays for its form and the places it could have been, as the evidence does.
            let paid = (c.best.evidence - c.evidence).max(0.0);
            let formed = gate.formed(record, state, &solved(&c.best)) - paid;
            c.formed = formed.max(c.evidence);
        }
    });
}

/// The best of a pump's effect where the head may not lean on the inlet pressure.
///
/// That lean absorbs most of a real effect of the pump, and all of what the curves merely fit badly. An effect must stand out without
/// the lean, and must not vanish with it.
fn without_lean(
    record: &Record,
    stiff: &Tangent,
    state: &[Applied],
    best: &Candidate,
) -> Option<Candidate> {
    let effect = best.applied.effect;
    if on_grid(effect.about()) {
        return scan(record, stiff, state, effect);
    }
    let start = weigh(record, stiff, state, best.applied.clone());
    Some(if effect.is_switch() {
        sharpen(record, stiff, state, start)
    } else {
        start
    })
}

/// Strong wear that was always there, weighed with a head that may lean on the inlet pressure and without; `None` of any other effect, and
/// where the two do not agree on a strength.
///
/// If a pump loses a third of its flow, curves that were fitted without the loss are so distorted that a small loss about them may
/// appear with the wrong sign.
fn far(tangents: &Tangents<'_>, near: &Candidate) -> Option<Candidate> {
    /// Two strengths further apart than this are not one.
    const APART: f64 = 2.0;
    let about = near.applied.effect.about();
    if !is_pump(near.applied.effect)
        || about.parameters[0].low < 0.0
        || about.onset().is_some()
        || on_grid(about)
        || about.search.timing.is_some()
    {
        return None;
    }
    let Tangents { record, state, .. } = *tangents;
    let lean = strong(record, tangents.lean, state, &near.applied)?;
    let apart = strong(record, tangents.stiff()?, state, &near.applied)?;
    let ratio = lean.applied.parameters[0] / apart.applied.parameters[0];
    (1.0 / APART..=APART).contains(&ratio).then(|| Candidate {
        evidence: lean.evidence.min(apart.evidence),
        ..apart
    })
}

/// The best of some strengths of an effect of one sign, from the usual one up, with the curves fitted again beside each; `None` if it
/// explains nothing, or if its opposite explains half as much.
fn strong(
    record: &Record,
    tangent: &Tangent,
    state: &[Applied],
    one: &Applied,
) -> Option<Candidate> {
    /// Strengths that are tried, over the usual one. Set by hand.
    const TIMES: [f64; 5] = [1.0, 1.5, 2.0, 3.0, 4.5];
    /// How many times more an effect must explain than its opposite. Set by hand.
    const OPPOSITE: f64 = 2.0;
    let strength = &one.effect.about().parameters[0];
    let usual = strength.usual;
    let misfit = |off: &[f64]| 0.5 * dot(off, off);
    let refitted = |strength: f64| {
        let mut applied = one.clone();
        applied.parameters[0] = strength;
        record.tally.weighed();
        let off = tangent.left_over(record, &joined(state, &applied));
        (applied, misfit(&tangent.off) - misfit(&off), off)
    };
    let plausible: Vec<f64> = (TIMES.into_iter())
        .filter(|times| times * usual <= strength.high)
        .collect();
    let tried = apiece(plausible, |times| {
        let strength = times * usual;
        let (applied, saved, off) = refitted(strength);
        let changes = tangent.off.iter().zip(&off);
        let signature: Vec<f64> = changes.map(|(a, b)| (a - b) / strength).collect();
        let energy = dot(&signature, &signature);
        Candidate {
            applied,
            evidence: evidence_at(times, usual * usual * energy, saved),
            // As if it were straight that far: its best strength is the one that was tried.
            score: strength * energy,
            signature,
            energy,
        }
    });
    let most = (tried.into_iter()).max_by(|a, b| a.evidence.total_cmp(&b.evidence))?;
    // What the opposite explains as well is a curve of another form, which either bends.
    let opposite = || refitted(-most.applied.parameters[0]).1;
    let stands = most.evidence > 0.0 && most.evidence > OPPOSITE * opposite();
    stands.then_some(most)
}

/// Evidence without the blocks that may merely look like the effect: those around the ends of its interval and, for effects of flowing
/// mud, the stops. `None` if nothing is left out; 0 if too few blocks are left.
///
/// A reading that freezes or jumps makes two edges with nothing between them; a real effect still shows without its edges. And a valve
/// that closes late leaves the line lower at a stop: that changes the standing column, not the friction.
pub(crate) fn sustained(
    record: &Record,
    state: &[Applied],
    c: &Candidate,
    still: &[bool],
) -> Option<f64> {
    let search = &c.applied.effect.about().search;
    let stops = search.flowing && record.takes(Step::Flowing);
    let mut excluded = doubtful(record, c).unwrap_or_else(|| vec![false; record.blocks]);
    for (out, still) in excluded.iter_mut().zip(still) {
        *out |= stops && *still;
    }
    if !excluded.contains(&true) {
        return None;
    }
    let Some(mut tangent) = Tangent::beside(record, state, &excluded, Bend::Lean) else {
        return Some(0.0);
    };
    if search.timing.is_some() {
        // What is weighed by a second fit needs nothing more of the first.
        tangent.release_columns();
    }
    Some(weigh(record, &tangent, state, c.applied.clone()).evidence)
}

/// Share of its evidence, and e-folds besides, that an effect which sets in owes to the time before. Set by hand.
pub(crate) const SEEN: f64 = 0.03;
pub(crate) const SEEN_BESIDES: f64 = 3.0;

/// Whether what is there from some time on was not there before: always there, it would explain less. It owes no more than half of what
/// it would have done before, which may be little or nothing: mud is lost only above the fracture pressure.
pub(crate) fn sets_in(record: &Record, gate: &Tangent, state: &[Applied], c: &Candidate) -> bool {
    always(record, gate, state, c).is_none_or(|always| {
        let before = apart(&always, c) / always.energy;
        let owed = SEEN.min(0.5 * before) * c.evidence + SEEN_BESIDES;
        c.evidence > always.evidence + owed || quiet_at_first(record, gate, state, &always)
    })
}

/// Share of what an effect that sets in half-way through the recording explains that it would explain without an onset as well; 0 for
/// effects that do not set in, or pass.
pub(crate) fn before(record: &Record, gate: &Tangent, state: &[Applied], c: &Candidate) -> f64 {
    let share = always(record, gate, state, c)
        .filter(|always| !quiet_at_first(record, gate, state, always))
        .map_or(0.0, |always| {
            let middle = weigh(record, gate, state, setting_in(record, &always, 0.5));
            let both = dot(&always.signature, &middle.signature);
            both * both / (always.energy * middle.energy)
        });
    // From the start it may do nothing at all.
    if share.is_finite() { share } else { 0.0 }
}

/// The same effect, set in after a share of the recording.
fn setting_in(record: &Record, c: &Candidate, share: f64) -> Applied {
    let (from, to) = record.setting.span_s;
    let mut later = c.applied.clone();
    if let Some(onset) = later.effect.about().onset() {
        later.parameters[onset] = from + share * (to - from);
    }
    later
}

/// Whether what is always there does nothing over a good part of the recording, at its start.
fn quiet_at_first(record: &Record, gate: &Tangent, state: &[Applied], always: &Candidate) -> bool {
    /// Share of the recording that must pass, and of what is explained that it may then cost. Set by hand.
    const QUIET: f64 = 0.2;
    const NOTHING: f64 = 1e-6;
    let later = weigh(record, gate, state, setting_in(record, always, QUIET));
    apart(always, &later) <= NOTHING * always.energy
}

/// Square of what two candidates' signatures differ by.
fn apart(a: &Candidate, b: &Candidate) -> f64 {
    let pairs = a.signature.iter().zip(&b.signature);
    pairs.map(|(a, b)| (a - b).powi(2)).sum()
}

/// A candidate that sets in and stays, weighed as if it had been there from the start; `None` for others.
fn always(record: &Record, gate: &Tangent, state: &[Applied], c: &Candidate) -> Option<Candidate> {
    /// How long before the recording what was always there set in, s. Set by hand.
    const BEFORE_S: f64 = 1e6;
    let about = c.applied.effect.about();
    let (Some(onset), None) = (about.onset(), about.duration()) else {
        return None;
    };
    let mut always = c.applied.clone();
    always.parameters[onset] = record.setting.span_s.0 - BEFORE_S;
    Some(weigh(record, gate, state, always))
}

/// The blocks around the beginning and the end of a candidate; `None` if it has neither.
fn doubtful(record: &Record, c: &Candidate) -> Option<Vec<bool>> {
    /// Time on either side of an edge, s, and share of a short interval, that is left out. Set by hand.
    const HOLE_S: f64 = 300.0;
    const HOLE_SHARE: f64 = 0.2;
    let about = c.applied.effect.about();
    if about.onset().is_none() || !record.takes(Step::Edges) {
        return None;
    }
    let span = record.setting.span_s;
    let (from, to) = about.interval_s(&c.applied.parameters, span);
    let seconds = record.block_s();
    let hole = HOLE_S.min(HOLE_SHARE * (to - from));
    let middles = (0..record.blocks).map(|b| span.0 + (b as f64 + 0.5) * seconds);
    let beside = |at: f64| (at - from).abs() < hole || (at - to).abs() < hole;
    Some(middles.map(beside).collect())
}

/// Whether an effect sits in the pump's head.
pub(crate) fn is_pump(effect: &dyn Effect) -> bool {
    effect.about().relation == Relation::PumpHead
}

/// Looks within the bounds for the strength of a candidate that was solved for on a straight line and lies beyond them: the friction does
/// not grow in proportion to a large change of viscosity. Where the bound still seems best, another shape is tried.
fn keep_within_bounds(record: &Record, gate: &Tangent, state: &[Applied], c: &mut Candidate) {
    /// Strengths that are tried, over the bound. Set by hand.
    const TRIED: [f64; 7] = [0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 1.0];
    /// The strength, over the bound, from which another shape is looked for. Set by hand.
    const START: f64 = 0.8;
    let about = c.applied.effect.about();
    if on_grid(about) || about.search.timing.is_some() || c.energy <= 0.0 {
        return;
    }
    let p = &about.parameters[0];
    let straight = c.score / c.energy;
    if straight > p.low && straight < p.high {
        return;
    }
    let bound = straight.clamp(p.low, p.high);
    let of = |one: Applied| {
        let signature = gate.signature(record, &joined(state, &one));
        let apart = |(off, s): (&f64, &f64)| (off - s).powi(2);
        let misfit: f64 = gate.off.iter().zip(&signature).map(apart).sum();
        (misfit, one, signature)
    };
    let with = |strength: f64| {
        let mut one = c.applied.clone();
        one.parameters[0] = strength;
        one
    };
    let tries = TRIED.map(|share| of(with(share * bound)));
    let Some(mut best) = tries.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)) else {
        return;
    };
    if at_bound(&best.1) {
        let mut all = joined(state, &with(START * bound));
        let last = all.len() - 1;
        refine(record, &mut all, last, &[], 2);
        let reshaped = of(all.remove(last));
        if reshaped.0 < best.0 {
            best = reshaped;
        }
    }
    let (_, one, mut signature) = best;
    let strength = one.parameters[0];
    if at_bound(&one) || strength == 0.0 {
        return;
    }
    signature.iter_mut().for_each(|v| *v /= strength);
    c.energy = dot(&signature, &signature);
    c.score = strength * c.energy;
    c.signature = signature;
    c.applied.parameters[1..].copy_from_slice(&one.parameters[1..]);
}

/// A candidate with its strength solved for.
pub(crate) fn solved(c: &Candidate) -> Applied {
    let about = c.applied.effect.about();
    let mut one = c.applied.clone();
    if !on_grid(about) && c.energy > 0.0 {
        let p = &about.parameters[0];
        one.parameters[0] = (c.score / c.energy).clamp(p.low, p.high);
    }
    one
}

/// Evidence that an effect reaches on sound recordings of this one's length.
pub(crate) fn hurdle(record: &Record, one: &Applied) -> f64 {
    one.effect.about().search.belief.hurdle * times(record, one)
}

/// By what the hurdle of an effect is multiplied: it may be there for longer than the recordings lasted that it was set on.
pub(crate) fn times(record: &Record, one: &Applied) -> f64 {
    let about = one.effect.about();
    record.times_usual(about.interval_s(&one.parameters, record.setting.span_s))
}

/// Whether the strength is more than an instrument's accuracy.
pub(crate) fn material(one: &Applied) -> bool {
    let least = one.effect.about().search.least;
    least.is_none_or(|least| one.parameters[0].abs() > least)
}

/// Whether the strength stands at a bound of what is plausible: then something else is the cause.
pub(crate) fn at_bound(one: &Applied) -> bool {
    let p = &one.effect.about().parameters[0];
    let v = one.parameters[0];
    (v <= p.low && p.low != 0.0) || v >= p.high
}

/// Whether a shift of one outlet transmitter is seen in the difference of the two, after its onset against before.
pub(crate) fn stands(record: &Record, one: &Applied) -> bool {
    /// Time before and after the onset in which the two are compared, s. Set by hand.
    const REACH_S: f64 = 1200.0;
    /// Samples on either side, at the least. Set by hand.
    const LEAST: usize = 20;
    /// The step that is seen over the one that was found. Set by hand.
    const SHARES: std::ops::Range<f64> = 0.5..1.6;
    let about = one.effect.about();
    let (Some(onset), Some(sensor), [first, second]) =
        (about.onset(), about.sensor(), record.outlets.as_slice())
    else {
        return true;
    };
    let at = record.t_s.partition_point(|t| *t < one.parameters[onset]);
    let reach = whole(REACH_S / record.dt_s);
    let middle = |range: std::ops::Range<usize>| -> f64 {
        let apart = range
            .map(|i| first[i] - second[i])
            .filter(|v| v.is_finite());
        if apart.clone().count() < LEAST {
            return f64::NAN;
        }
        quantile(apart, Rank::MEDIAN).unwrap_or(f64::NAN)
    };
    let step = middle(at..(at + reach).min(first.len())) - middle(at.saturating_sub(reach)..at);
    // Transmitters are numbered 1 and 2.
    let sign = if one.parameters[sensor] > 1.5 {
        -1.0
    } else {
        1.0
    };
    let share = sign * step / one.parameters[0];
    SHARES.contains(&share)
}

/// Whether two effects explain the same residuals: the cosine between their signatures.
pub(crate) fn alike(a: &Candidate, b: &Candidate) -> bool {
    /// Cosine above which two are alike. Set by hand.
    const ALIKE: f64 = 0.35;
    let size = (a.energy * b.energy).sqrt();
    size > 0.0 && (dot(&a.signature, &b.signature) / size).abs() > ALIKE
}

#[cfg(test)]
mod tests;
