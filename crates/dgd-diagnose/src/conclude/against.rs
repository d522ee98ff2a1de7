//! What speaks against causes, beside their own scores: what else could look like them, and how the recording is told with them.

use super::clock::{OwnClock, in_balance, own_clock_of};
use super::unlogged::Unlogged;
use super::untrained::is_untrained;
use super::worse::{is_worse, runs_away};
use super::{residue, untrained};
use crate::belief::{self, is_unnamed, left_over, made_worse, own_clock, run_away, unlogged};
use crate::diagnosis::{Archived, Check, Finding, Trace};
use crate::free_run::Errors;
use crate::record::Record;
use crate::select::Sought;
use crate::selection::{Named, Selection};
use crate::tangent::Tangent;
use dgd_effects::AppliedEffect;
use dgd_recording::ChannelMap;

/// How the recording is told with all that was found.
pub(super) struct Told<'a> {
    /// The tangent about it.
    pub full: &'a Tangent,
    pub traces: &'a [Trace],
    /// Errors of each signal's free runs on the held-out windows.
    pub errors: &'a [Option<Errors>],
    /// Effects of the model that was trained without those windows.
    pub trained: &'a [AppliedEffect],
    /// Whether names were doubted already because something unnamed stands beside them.
    pub doubted: bool,
}

/// What was weighed against the causes that were found.
pub(super) struct Against {
    clock: Option<OwnClock>,
    idle: Option<Unlogged>,
    /// Whether the pump that is idle may be what causes are taken for.
    upset: bool,
    archived: Archived,
    nothing_left: Check,
    untrained: Option<Check>,
}

impl Against {
    /// Weighs it, which makes causes less likely.
    pub(super) fn weigh(
        record: &Record,
        channels: &ChannelMap,
        archived: Archived,
        told: &Told<'_>,
        selection: &mut Selection,
        sought: Sought<'_>,
    ) -> Self {
        // Of what was suspected alone it would stand for what was not asked for.
        let clock = match sought {
            Sought::Any(_) => own_clock_of(record, told.full, selection),
            Sought::Given(_) => None,
        };
        let named = &mut selection.named;
        if let Some(clock) = &clock {
            doubt(named, sought, |n| clock.speaks_against(n), own_clock);
        }
        let idle = Unlogged::in_record(record, channels);
        let upset = idle.is_some() && Unlogged::may_be_any(record, named);
        if upset {
            doubt(named, sought, in_balance, unlogged);
        }
        let made_up = |n: &Named| archived.speaks_against(n);
        doubt(named, sought, made_up, belief::archived);
        doubt_what_is_left(told.traces, named, told.doubted, sought);
        if runs_away(told.errors) {
            doubt(named, sought, |_| true, run_away);
        } else if is_worse(told.errors) {
            doubt(named, sought, |_| true, made_worse);
        }
        let unseen = |n: &Named| is_untrained(n, told.trained);
        doubt(named, sought, unseen, belief::untrained);
        Self {
            clock,
            idle,
            upset,
            archived,
            nothing_left: residue::left(told.traces),
            untrained: untrained::check(named, told.trained),
        }
    }

    /// Whether no relation keeps more than noise.
    pub(super) fn leaves_nothing(&self) -> bool {
        self.nothing_left.passed
    }

    /// Says of the finding of a cause what else would look the same.
    pub(super) fn tell(&self, named: &Named, finding: &mut Finding) {
        if let Some(idle) = self.idle {
            idle.tell(named, self.upset, finding);
        }
        self.archived.tell(named, finding);
        if let Some(clock) = &self.clock {
            clock.tell(finding);
        }
    }

    pub(super) fn checks(&self) -> impl Iterator<Item = Check> {
        [self.nothing_left.clone()]
            .into_iter()
            .chain(self.untrained.clone())
            .chain(self.clock.as_ref().map(OwnClock::check))
    }

    pub(super) fn warnings(&self) -> impl Iterator<Item = String> {
        let idle = self.idle.filter(|_| self.upset);
        (self.clock.iter().map(OwnClock::warning)).chain(idle.map(Unlogged::warning))
    }
}

/// Doubts causes whose relation keeps more than noise with all that was found; less, where something unnamed had them `doubted` already.
pub(super) fn doubt_what_is_left(
    traces: &[Trace],
    named: &mut [Named],
    doubted: bool,
    sought: Sought<'_>,
) {
    let left = |n: &Named| residue::is_left_in(traces, n.applied.effect.about().relation);
    // What is likelier unnamed itself was not.
    doubt(named, sought, left, |n| {
        left_over(n, doubted && !is_unnamed(n))
    });
}

/// Makes those causes less likely of which something `speaks` against them.
fn doubt(
    named: &mut [Named],
    sought: Sought<'_>,
    speaks: impl Fn(&Named) -> bool,
    lower: impl Fn(&mut Named),
) {
    for one in named.iter_mut().filter(|one| speaks(one)) {
        lower(one);
        if let Sought::Given(suspects) = sought {
            unless_outweighed(one, suspects);
        }
    }
}

/// Drops the alternatives to a suspect that were not suspected, if one of them is likelier than it: the suspect does not stand for that.
pub(super) fn unless_outweighed(one: &mut Named, suspects: &[String]) {
    let beside = |a: &(String, f64)| !suspects.contains(&a.0);
    let own = one.probability;
    if (one.alternatives.iter()).any(|a| beside(a) && a.1 > own) {
        one.alternatives.retain(|a| !beside(a));
    }
}
