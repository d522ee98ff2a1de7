//! From residuals to named effects: one a round, refined together, and second thoughts.

use crate::contest::{Contender, is_pump, material};
use crate::record::Record;
use crate::refine::refine;
use crate::relations::Applied;
use crate::round::{Round, Ruling};
use crate::scan::{allowances_with, joined, on_grid, weigh};
use crate::tangent::{Bend, Tangent};

/// A named effect.
#[derive(Clone)]
pub(crate) struct Named {
    pub applied: Applied,
    pub evidence: f64,
    pub probability: f64,
    pub alternatives: Vec<(String, f64)>,
    /// Relation and quantity, where it is an empirical correction.
    pub correction: Option<(usize, usize)>,
}

/// The outcome of the search.
pub(crate) struct Selection {
    pub allowances: Vec<Applied>,
    pub named: Vec<Named>,
    /// First-round evidence and the energy of a unit of strength, by effect.
    pub first: Vec<(&'static str, f64, f64)>,
}

impl Selection {
    /// The full hypothesis.
    pub(crate) fn state(&self) -> Vec<Applied> {
        let mut out = self.allowances.clone();
        for n in &self.named {
            out = joined(&out, &n.applied);
        }
        out
    }

    /// Takes findings in and refines all of them together.
    fn accept(&mut self, record: &Record, start: &[Applied], found: Vec<Named>) -> Option<()> {
        // Without a late meter in the model, a late pump had to stand in for it: what is allowed for is chosen again.
        let late = |n: &Named| n.applied.effect.about().search.timing.is_some();
        let again = found.iter().any(late);
        self.named.extend(found);
        if again {
            self.allowances = allowed_beside(record, start, &self.named, &[])?;
        }
        let mut joint = self.state();
        let fixed = joint.len() - self.named.len();
        refine(record, &mut joint, fixed, &[], 2);
        for (named, refined) in self.named.iter_mut().zip(&joint[fixed..]) {
            named.applied = refined.clone();
        }
        Some(())
    }
}

/// The search: rounds until nothing more stands out, `most` of them at the most.
pub(crate) fn select(
    record: &Record,
    start: &[Applied],
    most: usize,
    mut round_begins: impl FnMut(usize),
) -> Option<Selection> {
    let mut selection = Selection {
        allowances: allowances_with(record, start, &[], Bend::Lean)?,
        named: Vec::new(),
        first: Vec::new(),
    };
    for number in 1..=most {
        round_begins(number);
        let round = Round::about(record, &selection)?;
        if number == 1 {
            selection.first = first(&round);
        }
        match round.ruling(&selection.named) {
            Ruling::Nothing => break,
            Ruling::Unnamed(correction) => {
                selection.named.push(correction);
                break;
            }
            Ruling::Named(named) => selection.accept(record, start, named)?,
        }
    }
    reconsider(record, &mut selection)?;
    Some(selection)
}

/// What each effect showed before anything was named.
fn first(round: &Round) -> Vec<(&'static str, f64, f64)> {
    let of = |c: &Contender| {
        let about = c.effect.about();
        let energy = if on_grid(about) { 0.0 } else { c.best.energy };
        (about.id, c.evidence, energy)
    };
    round.contenders.iter().map(of).collect()
}

/// What `start` holds, with the timing allowances that the named effects leave to be made.
pub(crate) fn allowed_beside(
    record: &Record,
    start: &[Applied],
    named: &[Named],
    excluded: &[bool],
) -> Option<Vec<Applied>> {
    let mut fixed = start.to_vec();
    fixed.extend(named.iter().map(|n| n.applied.clone()));
    let state = allowances_with(record, &fixed, excluded, Bend::Lean)?;
    let mut out = start.to_vec();
    out.extend(state.into_iter().filter(|a| a.allowance));
    Some(out)
}

/// Drops what the others made superfluous.
fn reconsider(record: &Record, selection: &mut Selection) -> Option<()> {
    if selection.named.len() < 2 {
        return Some(());
    }
    let mut k = 0;
    while k < selection.named.len() && selection.named.len() > 1 {
        if selection.named[k].correction.is_some() {
            k += 1;
            continue;
        }
        let one = selection.named[k].clone();
        let mut others = Selection {
            allowances: selection.allowances.clone(),
            named: selection.named.clone(),
            first: Vec::new(),
        };
        others.named.remove(k);
        let state = others.state();
        let tangent = Tangent::at(
            record,
            &state,
            &[],
            if is_pump(one.applied.effect) {
                Bend::Free
            } else {
                Bend::Lean
            },
        )?;
        let again = weigh(record, &tangent, &state, one.applied.clone());
        if again.evidence < 0.6 * one.applied.effect.about().search.belief.hurdle
            || !material(&one.applied)
        {
            selection.named.remove(k);
        } else {
            k += 1;
        }
    }
    Some(())
}
