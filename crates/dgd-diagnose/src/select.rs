//! From residuals to named effects: one a round, refined together.

mod parts;

use crate::contest::Contender;
use crate::record::Record;
use crate::refine::refine;
use crate::relations::{Applied, on_grid};
use crate::round::{Round, Ruling};
use crate::selection::{First, Named, Selection};
use crate::tangent::{Bend, Tangent};
use crate::timing::{allowances_with, allowed_beside};
use dgd_lsq::dot;
use parts::{is_whole, without_parts};
use rayon::prelude::*;
use tracing::debug;

impl Selection {
    /// Takes a finding in and refines all of them together.
    fn accept(&mut self, record: &Record, start: &[Applied], found: Named) -> Option<()> {
        self.named.push(found);
        // What a named effect hid, or stood in for it, is allowed for anew: a lag of the pump for a late meter.
        let mut applied: Vec<Applied> = self.named.iter().map(|n| n.applied.clone()).collect();
        self.allowances = allowed_beside(record, start, &mut applied, &[])?;
        for (named, applied) in self.named.iter_mut().zip(applied) {
            named.applied = applied;
        }
        self.refine(record);
        Some(())
    }

    /// Moves every effect to where all findings together explain most.
    fn refine(&mut self, record: &Record) {
        let mut joint = self.state();
        let fixed = joint.len() - self.named.len();
        refine(record, &mut joint, fixed, &[], 2);
        for (named, refined) in self.named.iter_mut().zip(&joint[fixed..]) {
            named.applied = refined.clone();
        }
    }
}

/// Share of a correction's probability from which on an effect beside it is not much less likely.
const NOT_MUCH_LESS: f64 = 0.5;

/// What was named on the promise of a second effect.
struct Promised {
    second: &'static str,
    /// Before it was.
    before: Selection,
    /// The correction that stands in its place if the second does not come.
    otherwise: Named,
}

/// What a search may find.
#[derive(Clone, Copy)]
pub(crate) enum Sought<'a> {
    /// Whatever stands out, this many effects at the most.
    Any(usize),
    /// These effects, whatever their evidence.
    Given(&'a [String]),
}

/// The search: rounds until nothing more stands out.
pub(crate) fn select(
    record: &Record,
    start: &[Applied],
    sought: Sought,
    mut round_begins: impl FnMut(usize),
) -> Option<Selection> {
    let mut selection = Selection {
        held: start.len(),
        allowances: allowances_with(record, start, &[], Bend::Lean, None)?,
        named: Vec::new(),
        first: Vec::new(),
        stays: false,
    };
    let most = match sought {
        Sought::Any(most) => most,
        Sought::Given(ids) => ids.len(),
    };
    let mut promises = Vec::new();
    // Whether an effect was named in the round before, beside which another may be better than one that was named earlier.
    let mut joined_others = false;
    let mut last = None;
    let mut number = 0;
    while number < most {
        number += 1;
        round_begins(number);
        // Two at a time would be held for nothing.
        drop(last.take());
        if std::mem::take(&mut joined_others)
            && let Some(revised) = revised(record, start, &selection)
        {
            selection = revised;
        }
        for one in selection.state() {
            let kind = if one.allowance { "allowed" } else { "named" };
            debug!("{kind} {} {:?}", one.id(), one.parameters);
        }
        let round = last.insert(Round::about(record, &selection)?);
        if number == 1 {
            selection.first = first(round);
        }
        let ruling = match sought {
            Sought::Any(_) => round.ruling(),
            Sought::Given(ids) => round.given(ids).map_or(Ruling::Nothing, Ruling::Named),
        };
        // A faulty transmitter neither keeps nor breaks a pending promise.
        let aside = matches!(ruling, Ruling::Seen(_));
        if !aside && broken_promises(&mut selection, &mut promises, &ruling) {
            continue;
        }
        if let Ruling::Named(named) | Ruling::Promised { named, .. } = &ruling {
            // No later round weighs it.
            let id = named.applied.id();
            shown_beside(&mut selection.first, round, Some(id));
        }
        match ruling {
            Ruling::Nothing => break,
            Ruling::Unnamed(correction) if is_whole(&selection, &correction) => {
                debug!("what ended is part of what the catalogue does not hold");
                selection.named.clear();
                selection.allowances = allowances_with(record, start, &[], Bend::Lean, None)?;
                selection.stays = true;
                promises.clear();
                number = 0;
            }
            Ruling::Unnamed(correction) => {
                selection.named.push(correction);
                // Its curve was drawn with the strengths of the named effects free.
                selection.refine(record);
                if let Some(rest) = without_parts(record, &selection) {
                    selection = rest;
                }
            }
            Ruling::Named(named) => {
                selection.accept(record, start, named)?;
                joined_others = matches!(sought, Sought::Any(_));
            }
            Ruling::Seen(named) => selection.accept(record, start, named)?,
            Ruling::Promised {
                named,
                second,
                otherwise,
            } => {
                let before = selection.clone();
                selection.accept(record, start, named)?;
                promises.push(Promised {
                    second,
                    before,
                    otherwise: *otherwise,
                });
            }
        }
    }
    // The last round that may name an effect has none behind it.
    if joined_others && let Some(revised) = revised(record, start, &selection) {
        selection = revised;
    }
    // No round is left in which a second effect might come.
    broken_promises(&mut selection, &mut promises, &Ruling::Nothing);
    // Beside what was found later nothing of it may be left; what is searched for by name keeps its answer.
    if matches!(sought, Sought::Any(_)) {
        selection.named.retain(|n| !n.has_no_size());
    }
    if let Some(round) = last {
        shown_beside(&mut selection.first, &round, None);
    }
    for named in &mut selection.named {
        if let Some(held) = named.held.take() {
            named.applied = Applied::from(&held.curve);
        }
    }
    Some(selection)
}

/// The selection reconsidered after its last effect was named: without an earlier effect of the same relation that no longer stands out
/// beside it, or with another one in that effect's place if the two explain more (the best one need not be one of the best two). `None` if
/// it stays as it is.
fn revised(record: &Record, start: &[Applied], selection: &Selection) -> Option<Selection> {
    /// Misfit that the other must save.
    const SAVES: f64 = 5.0;
    let (last, before) = selection.named.split_last()?;
    let relation = last.applied.effect.about().relation;
    let rivals = (0..before.len()).filter(|k| {
        !before[*k].applied.is_correction()
            && before[*k].applied.effect.about().relation == relation
    });
    if last.applied.is_correction() {
        return None;
    }
    let mut tangent = None;
    let misfit = |off: &[f64]| 0.5 * dot(off, off);
    let mut best = None;
    let mut most = SAVES;
    for k in rivals {
        let mut other = selection.clone();
        let gone = other.named.remove(k).applied.id();
        let Some(round) = Round::about(record, &other) else {
            continue;
        };
        if !round.shows(gone) {
            debug!("{gone} does not show beside {}", last.applied.id());
            other.named.pop();
            let last = anew(record, &other, last, gone);
            other.accept(record, start, last)?;
            return Some(other);
        }
        let Ruling::Named(named) = round.ruling() else {
            continue;
        };
        let id = named.applied.id();
        if id == gone || other.accept(record, start, named).is_none() {
            continue;
        }
        // Both are judged by the same noise and on the same rows.
        if tangent.is_none() {
            tangent = Some(Tangent::at(record, &selection.state(), &[], Bend::Stiff)?);
        }
        let tangent = tangent.as_ref()?;
        let saved = misfit(&tangent.off) - misfit(&tangent.left_over(record, &other.state()));
        debug!("{id} in the place of {gone} saves {saved:.1}");
        if saved > most {
            (best, most) = (Some(other), saved);
        }
    }
    best
}

/// A named effect as it stands out without one that does not show beside it: it was weighed beside that, which had taken most of what it explains,
/// and is no alternative to it any more.
fn anew(record: &Record, before: &Selection, named: &Named, gone: &str) -> Named {
    let weighed = Round::about(record, before).and_then(|round| round.without_rival(named, gone));
    weighed
        .filter(|weighed| weighed.evidence > named.evidence)
        .unwrap_or_else(|| named.clone())
}

impl Promised {
    /// Whether the round behind it names an effect, or holds the one that was promised for not much less likely than a correction.
    fn is_kept(&self, ruling: &Ruling) -> bool {
        match ruling {
            Ruling::Named(_) | Ruling::Promised { .. } => true,
            Ruling::Unnamed(correction) | Ruling::Seen(correction) => {
                let of = |(id, p): &(String, f64)| {
                    id == self.second && *p > NOT_MUCH_LESS * correction.probability
                };
                correction.alternatives.iter().any(of)
            }
            Ruling::Nothing => false,
        }
    }
}

/// Takes back what was named on promises that the round behind them does not keep, for no second effect came to do with the
/// first what a correction does by itself: tells whether that correction stands in their place.
fn broken_promises(
    selection: &mut Selection,
    promises: &mut Vec<Promised>,
    ruling: &Ruling,
) -> bool {
    let mut instead = None;
    while let Some(promise) = promises.pop() {
        let behind = instead.as_ref().unwrap_or(ruling);
        if promise.is_kept(behind) {
            match behind {
                // Which may be taken back itself.
                Ruling::Promised { .. } => promises.push(promise),
                _ => promises.clear(),
            }
            break;
        }
        *selection = promise.before;
        selection.named.push(promise.otherwise.clone());
        instead = Some(Ruling::Unnamed(promise.otherwise));
    }
    instead.is_some()
}

/// What each effect showed before anything was named.
fn first(round: &Round) -> Vec<First> {
    let of = |c: &Contender| {
        let about = c.effect.about();
        let energy = if on_grid(about) { 0.0 } else { c.best.energy };
        First {
            id: about.id,
            evidence: c.evidence,
            hurdle: round.hurdle(c),
            energy,
            admissible: round.admissible(c),
            showing: None,
        }
    };
    round.contenders.iter().map(of).collect()
}

/// Tells how small an effect would have been seen beside what was named before a round: that asks more of it, and hides some. Of all
/// effects that the round weighs, or of one.
fn shown_beside(first: &mut [First], round: &Round, only: Option<&str>) {
    first.par_iter_mut().for_each(|of| {
        let weighed = round.contenders.iter().find(|c| c.id() == of.id);
        if let Some(c) = weighed.filter(|_| only.is_none_or(|id| id == of.id)) {
            of.showing = round.showing(c);
        }
    });
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::{Promised, Sought, broken_promises, revised, select};
    use crate::record::Record;
    use crate::relations::Applied;
    use crate::round::Ruling;
    use crate::selection::Named;
    use crate::test_rig::{self, Hidden, INFLUX_S, drilled, selection};
    use dgd_effects::{find, unknown};

    fn named(applied: Applied, probability: f64) -> Named {
        Named {
            applied,
            evidence: 100.0,
            bent: 0.0,
            hurdle: 10.0,
            probability,
            alternatives: vec![("unknown".to_owned(), 0.99 - probability)],
            held: None,
            most: None,
        }
    }

    /// Drilling into which mud flows for a while.
    fn kick() -> Record {
        drilled(Hidden {
            influx_m3_s: 3e-3,
            ..Hidden::default()
        })
    }

    fn gain(probability: f64) -> Named {
        let gain = find("return_flow_gain").unwrap();
        named(Applied::new(gain, vec![0.02]), probability)
    }

    fn promise() -> Promised {
        Promised {
            second: "influx",
            before: selection(Vec::new()),
            otherwise: correction(("influx", 0.1)),
        }
    }

    fn correction(alternative: (&str, f64)) -> Named {
        let (id, p) = alternative;
        Named {
            alternatives: vec![(id.to_owned(), p)],
            ..named(Applied::new(unknown(), vec![0.0; 4]), 0.8)
        }
    }

    #[test]
    fn named_effects_move_beside_the_curve_of_what_is_not_named() {
        let rate = 3e-3;
        let record = drilled(Hidden {
            influx_m3_s: rate,
            ..Hidden::default()
        });
        let (from, lasts, rise) = INFLUX_S;
        let weak = Applied::new(find("influx").unwrap(), vec![0.5 * rate, from, lasts, rise]);
        // A curve of the balance along the return flow that adds nothing.
        let mut flat = vec![2.0, 4.0, 0.02, 0.05];
        flat.resize(16, 0.0);
        let mut found = selection(vec![
            named(weak, 0.9),
            named(Applied::new(unknown(), flat.clone()), 0.8),
        ]);
        found.refine(&record);
        let found: Vec<&[f64]> = (found.named.iter())
            .map(|n| n.applied.parameters.as_slice())
            .collect();
        assert!((found[0][0] - rate).abs() < 0.1 * rate, "{found:?}");
        assert_eq!(found[1], flat);
    }

    #[test]
    fn a_promise_is_kept_by_a_name_or_by_what_may_be_the_one_that_was_promised() {
        let kept = |ruling: Ruling| promise().is_kept(&ruling);
        assert!(kept(Ruling::Named(gain(0.6))));
        assert!(!kept(Ruling::Nothing));
        assert!(kept(Ruling::Unnamed(correction(("influx", 0.41)))));
        assert!(!kept(Ruling::Unnamed(correction(("influx", 0.39)))));
        assert!(!kept(Ruling::Unnamed(correction(("line_leak", 0.41)))));
    }

    #[test]
    fn a_promise_that_is_not_kept_gives_way_to_the_correction() {
        let mut found = selection(vec![gain(0.9)]);
        assert!(broken_promises(
            &mut found,
            &mut vec![promise()],
            &Ruling::Nothing
        ));
        let ids = found.named.iter().map(|n| n.applied.id());
        assert_eq!(ids.collect::<Vec<_>>(), ["unknown"]);
    }

    #[test]
    fn a_promise_kept_by_another_one_falls_with_it() {
        let second = Promised {
            before: selection(vec![gain(0.9)]),
            ..promise()
        };
        let mut promises = vec![promise()];
        let mut found = selection(vec![gain(0.9)]);
        let next = Ruling::Promised {
            named: gain(0.8),
            second: "influx",
            otherwise: Box::new(correction(("influx", 0.1))),
        };
        assert!(!broken_promises(&mut found, &mut promises, &next));
        assert_eq!(promises.len(), 1);
        promises.push(second);
        found.named.push(gain(0.8));
        assert!(broken_promises(&mut found, &mut promises, &Ruling::Nothing));
        let ids = found.named.iter().map(|n| n.applied.id());
        assert_eq!(ids.collect::<Vec<_>>(), ["unknown"]);
    }

    #[test]
    fn an_effect_of_size_zero_is_none_but_a_correction_has_no_size() {
        let influx = |rate: f64| test_rig::named("influx", &[rate, 4e3, 1e3, 60.0]);
        assert!(influx(0.0).has_no_size() && influx(-0.0).has_no_size());
        assert!(!influx(1e-9).has_no_size());
        assert!(!correction(("influx", 0.4)).has_no_size());
    }

    #[test]
    fn each_suspect_is_fitted_once_though_one_of_them_may_come_again() {
        let record = kick();
        let suspects = ["influx", "pump_wear"].map(str::to_owned);
        let found = select(&record, &[], Sought::Given(&suspects), |_| {}).unwrap();
        let ids = found.named.iter().map(|n| n.applied.id());
        assert_eq!(ids.collect::<Vec<_>>(), ["influx", "pump_wear"]);
    }

    #[test]
    fn a_suspect_that_the_model_to_start_from_holds_is_asked_about_at_another_time() {
        let record = kick();
        let (from, lasts, rise) = INFLUX_S;
        let held = test_rig::one("influx", &[3e-3, from, lasts, rise]);
        let suspects = ["influx".to_owned()];
        let found = select(&record, &[held], Sought::Given(&suspects), |_| {}).unwrap();
        let ids = found.named.iter().map(|n| n.applied.id());
        assert_eq!(ids.collect::<Vec<_>>(), ["influx"]);
    }

    /// A gain of the inflow may be what an influx looks like until that is found.
    #[test]
    fn what_does_not_show_beside_a_later_one_is_let_go_and_what_does_stays() {
        let (from, lasts, rise) = INFLUX_S;
        let of = |gain: f64| {
            let mut record = kick();
            for read in &mut record.filled.mud_pump {
                *read *= 1.0 + gain;
            }
            let found = selection(vec![
                test_rig::named("inflow_gain", &[gain.max(0.01)]),
                test_rig::named("influx", &[3e-3, from, lasts, rise]),
            ]);
            revised(&record, &[], &found)
        };
        let left = of(0.0).unwrap();
        let ids = left.named.iter().map(|n| n.applied.id());
        assert_eq!(ids.collect::<Vec<_>>(), ["influx"]);
        // It is weighed anew without what had its part of the evidence, and has that for no alternative.
        let beside = test_rig::named("influx", &[3e-3, from, lasts, rise]).evidence;
        let alone = &left.named[0];
        assert!(alone.evidence > 1.5 * beside, "{}", alone.evidence);
        assert!(alone.alternatives.iter().all(|a| a.0 != "inflow_gain"));
        assert!(of(0.05).is_none());
    }
}
