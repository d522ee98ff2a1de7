//! From residuals to named effects: one a round, refined together.

use crate::contest::Contender;
use crate::record::Record;
use crate::refine::refine;
use crate::relations::Applied;
use crate::round::{Round, Ruling};
use crate::scan::{allowances_with, joined, on_grid};
use crate::tangent::Bend;
use crate::timing::allowed_beside;
use tracing::debug;

/// A named effect.
#[derive(Clone)]
pub(crate) struct Named {
    pub applied: Applied,
    pub evidence: f64,
    /// What its form gained within its error, where its strength differs along stands; else 0.
    pub bent: f64,
    /// Evidence that sound recordings, and what was named before, do not reach.
    pub hurdle: f64,
    pub probability: f64,
    pub alternatives: Vec<(String, f64)>,
    /// Place and quantity, where it is an empirical correction.
    pub correction: Option<(usize, usize)>,
}

/// An effect in the first round.
pub(crate) struct First {
    pub id: &'static str,
    pub evidence: f64,
    /// Energy of a unit of strength, 0 where the strength is on a grid.
    pub energy: f64,
    /// Whether it might be named but for its evidence.
    pub admissible: bool,
}

/// The outcome of the search.
pub(crate) struct Selection {
    /// How many effects the search starts from; they stand first among the allowances.
    pub held: usize,
    /// What the search starts from, and what is allowed for beside it.
    pub allowances: Vec<Applied>,
    pub named: Vec<Named>,
    /// How each effect fared before anything was named.
    pub first: Vec<First>,
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

    /// Takes a finding in and refines all of them together.
    fn accept(&mut self, record: &Record, start: &[Applied], found: Named) -> Option<()> {
        self.named.push(found);
        // What a named effect hid, or stood in for it, is allowed for anew: a lag of the pump for a late meter.
        let mut applied: Vec<Applied> = self.named.iter().map(|n| n.applied.clone()).collect();
        self.allowances = allowed_beside(record, start, &mut applied, &[])?;
        for (named, applied) in self.named.iter_mut().zip(applied) {
            named.applied = applied;
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
    };
    let most = match sought {
        Sought::Any(most) => most,
        Sought::Given(ids) => ids.len(),
    };
    for number in 1..=most {
        round_begins(number);
        for one in selection.state() {
            let kind = if one.allowance { "allowed" } else { "named" };
            debug!("{kind} {} {:?}", one.effect.about().id, one.parameters);
        }
        let round = Round::about(record, &selection)?;
        if number == 1 {
            selection.first = first(&round);
        }
        let ruling = match sought {
            Sought::Any(_) => round.ruling(),
            Sought::Given(ids) => round.given(ids).map_or(Ruling::Nothing, Ruling::Named),
        };
        match ruling {
            Ruling::Nothing => break,
            Ruling::Unnamed(correction) => {
                selection.named.push(correction);
                break;
            }
            Ruling::Named(named) => selection.accept(record, start, named)?,
        }
    }
    Some(selection)
}

/// What each effect showed before anything was named.
fn first(round: &Round) -> Vec<First> {
    let of = |c: &Contender| {
        let about = c.effect.about();
        let energy = if on_grid(about) { 0.0 } else { c.best.energy };
        First {
            id: about.id,
            evidence: c.evidence,
            energy,
            admissible: round.admissible(c),
        }
    };
    round.contenders.iter().map(of).collect()
}
