//! Effects that end, and effects that come again.

use crate::ablation::Step;
use crate::contest::{Contender, contenders, ending, solved, sustained};
use crate::empirical::{Correction, hurdle};
use crate::record::Record;
use crate::relations::{Applied, joined};
use crate::scan::{Candidate, gap, onsets_that_stay, sharpen, weigh};
use crate::tangent::{Bend, Tangent};
use dgd_effects::About;
use tracing::debug;

/// What an end, or a second time, must tell to be believed: so many e-folds, and a share of what the effect tells without. Set by hand.
const ENDS: f64 = 4.0;
const ENDS_SHARE: f64 = 0.1;

/// Share of what the best effect claims from which an effect stands out. Set by hand.
const OF_LEADER: f64 = 0.3;

/// Share of what the best effect tells from which one is asked whether it comes again. Set by hand.
const OF_BEST: f64 = 0.7;

/// What is over for less than this, s, is not over. Set by hand.
const OVER_S: f64 = 1200.0;

/// What effects are weighed on.
type Weighing<'a> = (&'a Record, &'a Tangent, &'a [Applied]);

/// Weighs what sets in as what ends as well: effects that stand out, those that have ended once, and those of relations of which corrections tell more
/// than any effect does; and what passes as what comes again. What tells more so takes the place of what it was.
pub(super) fn weigh_ends(on: Weighing<'_>, contenders: &mut Vec<Contender>, rivals: &[Correction]) {
    let (record, gate, state) = on;
    if !record.takes(Step::Ends) {
        return;
    }
    let most = contenders.first().map_or(0.0, Contender::claim);
    // What passes may be short: an episode counts with all that it tells.
    let tells = |r: &Correction| r.evidence.max(r.borne);
    let untold = rivals.iter().filter(|r| tells(r) > hurdle(r).max(most));
    let asked = |about: &About| {
        let least = about.search.belief.hurdle.max(OF_LEADER * most);
        let ended = |held: &Applied| held.id() == about.id && held.effect.lasting().is_some();
        state.iter().any(ended)
            || (contenders.iter()).any(|c| c.id() == about.id && c.evidence > least)
            || (untold.clone()).any(|r| r.curve.place.shows_in().contains(&about.relation))
    };
    let forms = ending(record, gate, state, asked);
    let passing = (contenders.iter())
        .filter(|c| c.effect.about().duration().is_some())
        .cloned();
    let passing: Vec<Contender> = passing.chain(forms).collect();
    let most = (passing.iter()).fold(most, |most, c| most.max(c.claim()));
    for one in passing {
        let about = one.effect.about();
        let form = one.effect.lasting().is_some();
        if form && !has_both_ends(on, &one.best) {
            debug!(
                "{} has one end: {:.1}, {:?}",
                one.id(),
                one.evidence,
                solved(&one.best).parameters
            );
            continue;
        }
        let told = one.claim() > about.search.belief.hurdle.max(OF_BEST * most);
        let left = |r: &Correction| {
            r.borne > hurdle(r).max(ENDS_SHARE * one.evidence)
                && r.curve.place.shows_in().contains(&about.relation)
        };
        let again = told && rivals.iter().any(left);
        let twice = again.then(|| twice(on, &one)).flatten();
        // Where its ends tell more than what it is in between, nothing may be left of it.
        let apart = (again || told && form).then(|| apart(on, &one)).flatten();
        for again in [twice, apart].into_iter().flatten() {
            if !form || has_both_ends(on, &again.best) {
                offer(contenders, again);
            }
        }
        if form {
            offer(contenders, one);
        }
    }
    contenders.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
}

/// Puts a contender in the place of one of the same effect, if it tells so much more that it is to be believed.
fn offer(contenders: &mut Vec<Contender>, mut other: Contender) {
    debug!(
        "{} that ends or recurs: {:.1}, {:?}",
        other.id(),
        other.evidence,
        solved(&other.best).parameters
    );
    other.evidence -= ENDS;
    other.formed -= ENDS;
    match contenders.iter_mut().find(|c| c.id() == other.id()) {
        Some(held) if other.evidence > (1.0 + ENDS_SHARE) * held.evidence => *held = other,
        Some(_) => {}
        None => contenders.push(other),
    }
}

/// Whether it tells more than if it had been there from the start, or stayed: what was there and ends looks like the opposite of what sets in, and with
/// what is always there the curves are fitted.
fn has_both_ends((record, gate, state): Weighing<'_>, c: &Candidate) -> bool {
    /// How far beyond the recording, s. Set by hand.
    const BEYOND_S: f64 = 1e6;
    let about = c.applied.effect.about();
    let (Some(onset), Some(duration)) = (about.onset(), about.duration()) else {
        return true;
    };
    let (first, last) = record.setting.span_s;
    let from = c.applied.parameters[onset];
    let to = from + c.applied.parameters[duration];
    let (earliest, latest) = onsets_that_stay(record);
    if from < earliest || to > latest {
        return false;
    }
    let open = [(first - BEYOND_S, to), (from, last + BEYOND_S)];
    open.into_iter().all(|(from, to)| {
        let mut open = c.applied.clone();
        (open.parameters[onset], open.parameters[duration]) = (from, to - from);
        let open = weigh(record, gate, state, open).evidence;
        c.evidence > (1.0 + ENDS_SHARE) * open.max(0.0) + ENDS
    })
}

/// What passes as what comes again at another time.
fn twice(on: Weighing<'_>, c: &Contender) -> Option<Contender> {
    with_another(on, c, c.best.clone())
}

/// What seems to last long as what is over for a while in between: the longer part, and what comes again beside it.
fn apart((record, gate, state): Weighing<'_>, c: &Contender) -> Option<Contender> {
    let parts = gap(record, gate, state, &solved(&c.best), OVER_S)?;
    let first = (parts.into_iter())
        .map(|part| sharpen(record, gate, state, weigh(record, gate, state, part)))
        .max_by(|a, b| a.evidence.total_cmp(&b.evidence))?;
    with_another((record, gate, state), c, first)
}

/// An effect at one time, with what it tells beside that at another; or as one from the first to the last, where the two meet.
fn with_another(
    (record, gate, state): Weighing<'_>,
    c: &Contender,
    first: Candidate,
) -> Option<Contender> {
    /// E-folds that one of some three thousand places pays for the others. Set by hand.
    const PLACES: f64 = 8.0;
    let about = c.effect.about();
    let (onset, duration) = (about.onset()?, about.duration()?);
    let beside = joined(state, &solved(&first));
    let gate_beside = Tangent::beside(record, &beside, &[], Bend::Lean)?;
    let other = contenders(record, &gate_beside, &beside, &[c.effect]);
    let other = other.first()?;
    let form = c.effect.lasting().is_some();
    let seen = !form || has_both_ends((record, &gate_beside, &beside), &other.best);
    let told = |best: Candidate, beside: f64| {
        let held = sustained(record, state, &best, &gate.rows.still);
        let evidence = (best.evidence - PLACES).min(held.unwrap_or(f64::INFINITY)) + beside;
        Contender {
            best,
            evidence,
            formed: evidence,
            ..c.clone()
        }
    };
    let span_s = record.setting.span_s;
    let [(from, to), (begins, ends)] =
        [&first, &other.best].map(|one| about.interval_s(&one.applied.parameters, span_s));
    if begins - to < OVER_S && from - ends < OVER_S {
        let mut whole = first.applied;
        whole.parameters[onset] = from.min(begins);
        whole.parameters[duration] = to.max(ends) - from.min(begins);
        let whole = sharpen(record, gate, state, weigh(record, gate, state, whole));
        return Some(told(whole, 0.0));
    }
    (seen && other.evidence > about.search.belief.hurdle).then(|| told(first, other.evidence))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::weigh_ends;
    use crate::ablation::Step;
    use crate::contest::{Contender, contest, solved};
    use crate::record::Record;
    use crate::round::beside::rivals_beside;
    use crate::tangent::{Bend, Tangent};
    use crate::test_rig::{FLOW_M3_S, Hidden, drilled};

    /// A line that loses 0.6 bar more at the usual flow within some times, s.
    fn restricted(times: &[(f64, f64)]) -> Record {
        let mut record = drilled(Hidden::default());
        for i in 0..record.t_s.len() {
            let acts = |(from, to): &(f64, f64)| (*from..*to).contains(&record.t_s[i]);
            if times.iter().any(acts) {
                record.outlet[i] += 6e4 * (record.flow[i] / FLOW_M3_S).powi(2);
            }
        }
        record.filled.outlet.clone_from(&record.outlet);
        record.outlets = vec![record.outlet.clone()];
        record
    }

    /// The restriction among the contenders, where ends are weighed.
    fn weighed(record: &Record) -> Contender {
        let gate = Tangent::at(record, &[], &[], Bend::Lean).unwrap();
        let mut contenders = contest(record, &gate, &[]);
        let rivals = rivals_beside(record, &gate, &[], &[]);
        weigh_ends((record, &gate, &[]), &mut contenders, &rivals);
        let is_sorted = contenders.is_sorted_by(|a, b| a.evidence >= b.evidence);
        assert!(is_sorted);
        let mut found = contenders
            .into_iter()
            .filter(|c| c.id() == "line_restriction");
        let one = found.next().unwrap();
        // One of a kind.
        assert!(found.next().is_none());
        one
    }

    /// From when to when a restriction is, s.
    fn when(c: &Contender) -> (f64, f64) {
        let about = c.effect.about();
        about.interval_s(&solved(&c.best).parameters, (0.0, 5400.0))
    }

    #[track_caller]
    fn near((from, to): (f64, f64), expected: (f64, f64)) {
        let apart = (from - expected.0).abs().max((to - expected.1).abs());
        assert!(apart <= 60.0, "{from} to {to}");
    }

    #[test]
    fn what_ends_is_told_with_its_end_and_what_stays_without() {
        let ends = weighed(&restricted(&[(1500.0, 3300.0)]));
        assert!(ends.effect.lasting().is_some());
        near(when(&ends), (1500.0, 3300.0));
        let stays = weighed(&restricted(&[(2700.0, 9e9)]));
        assert!(stays.effect.lasting().is_none());
        near(when(&stays), (2700.0, 5400.0));
        // One that ends just before the recording does is not told from it.
        let late = weighed(&restricted(&[(2700.0, 5300.0)]));
        assert!(late.effect.lasting().is_none());
    }

    #[test]
    fn without_the_step_nothing_ends() {
        let mut record = restricted(&[(1500.0, 3300.0)]);
        record.without = vec![Step::Ends];
        assert!(weighed(&record).effect.lasting().is_none());
    }
}
