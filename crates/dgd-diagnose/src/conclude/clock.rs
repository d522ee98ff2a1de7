//! Whether flows or pressures on a clock of their own explain the mass balance better than what was named there.
//!
//! A historian that gathers its channels from several systems may have each on its own clock. Mud that is logged late, or a level that
//! is, leaves at every change of flow what an area, moving pipe or a draining string leave there.

use super::residue::ONE_CLOCK;
use crate::cores::each;
use crate::diagnosis::{Check, Finding};
use crate::numbers::{bridged, whole};
use crate::record::Record;
use crate::relations::joined;
use crate::selection::{Named, Selection};
use crate::tangent::Tangent;
use crate::timing::EARLY;
use dgd_effects::Relation;
use dgd_lsq::dot;
use tracing::debug;

/// Channels that are logged together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Channels {
    MudPump,
    Inflows,
    Level,
}

impl Channels {
    const ALL: [Self; 3] = [Self::MudPump, Self::Inflows, Self::Level];

    fn name(self) -> &'static str {
        match self {
            Self::MudPump => "the mud pump's flow is",
            Self::Inflows => "the flows pumped in are",
            Self::Level => "the pressures of the pump inlet and the riser are",
        }
    }
}

/// A clock of their own.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct OwnClock {
    channels: Channels,
    /// What was logged so late is read so much earlier, s; early where it is below 0.
    late_s: f64,
    /// E-folds by which that explains more than what was named in the balance.
    saves: f64,
    /// Causes in the balance that are seen with it too.
    beside: Vec<&'static str>,
}

/// Seconds that are tried, to either side.
const TRIED_S: [f64; 5] = [6.0, 14.0, 24.0, 40.0, 70.0];
/// The most that a finer look may come to, s.
const MOST_S: f64 = 180.0;

/// The clock that explains more in place of all that was named in the mass balance; `None` where none does.
///
/// It must save as much beyond them as an allowance that makes something early.
///
/// - `full`: the tangent about all that was found, whose noise and rows all are judged by.
pub(super) fn own_clock_of(
    record: &Record,
    full: &Tangent,
    selection: &Selection,
) -> Option<OwnClock> {
    if !selection.named.iter().any(in_balance) {
        return None;
    }
    let others = selection.named.iter().filter(|n| !in_balance(n));
    let without = others.fold(selection.allowances.clone(), |state, n| {
        joined(&state, &n.applied)
    });
    let misfit = |off: &[f64]| 0.5 * dot(off, off);
    let now = misfit(&full.off);
    let saves = |channels: Channels, late_s: f64| {
        let steps = whole(late_s.abs() / record.dt_s);
        let late_s = (steps as f64 * record.dt_s).copysign(late_s);
        let other = read_earlier(record, channels, late_s);
        OwnClock {
            channels,
            late_s,
            saves: now - misfit(&full.left_over_of(&other, &without)) - EARLY,
            beside: Vec::new(),
        }
    };
    let most = |of: Vec<OwnClock>| of.into_iter().max_by(|a, b| a.saves.total_cmp(&b.saves));
    let tried = Channels::ALL.into_iter().flat_map(|channels| {
        let both = TRIED_S.into_iter().flat_map(|late_s| [late_s, -late_s]);
        both.map(move |late_s| (channels, late_s))
    });
    let mut best = most(each(tried.collect(), |(of, late_s)| saves(of, late_s)))?;
    // Finer about the best, half as far where neither side is better.
    let mut reach_s = 0.5 * best.late_s.abs();
    while reach_s >= 0.5 * record.dt_s {
        let near = [best.late_s - reach_s, best.late_s + reach_s];
        let near = near.into_iter().filter(|late_s| late_s.abs() <= MOST_S);
        let near = near.collect();
        match most(each(near, |late_s| saves(best.channels, late_s))) {
            Some(nearer) if nearer.saves > best.saves => best = nearer,
            _ => reach_s *= 0.5,
        }
    }
    debug!("{best:?}");
    if !(best.saves > 0.0 && best.late_s.abs() > 0.0) {
        return None;
    }
    let other = read_earlier(record, best.channels, best.late_s);
    let left = now - best.saves - EARLY;
    let is_seen = |n: &&Named| {
        let with = misfit(&full.left_over_of(&other, &joined(&without, &n.applied)));
        left - with > n.hurdle
    };
    let named = selection.named.iter();
    let causes = named.filter(|n| in_balance(n) && !n.applied.is_correction());
    best.beside = causes
        .filter(is_seen)
        .map(|n| n.applied.effect.about().id)
        .collect();
    Some(best)
}

/// Whether it shows in the mass balance.
pub(super) fn in_balance(named: &Named) -> bool {
    named.shows_in(Relation::RiserMassBalance)
}

/// The recording with some channels read so much earlier, s, and without gaps in them.
fn read_earlier(record: &Record, channels: Channels, late_s: f64) -> Record {
    let mut other = record.clone();
    let steps = whole(late_s.abs() / record.dt_s);
    let moved = |values: &mut Vec<f64>| {
        let steps = steps.min(values.len());
        let ends = (values.first().copied(), values.last().copied());
        // What is beyond an end is as at the end.
        if late_s > 0.0 {
            values.rotate_left(steps);
            let beyond = values.len() - steps;
            values[beyond..].fill(ends.1.unwrap_or_default());
        } else {
            values.rotate_right(steps);
            values[..steps].fill(ends.0.unwrap_or_default());
        }
    };
    let Record { inlet, filled, .. } = &mut other;
    match channels {
        Channels::MudPump => moved(&mut filled.mud_pump),
        Channels::Inflows => {
            for flow in [
                &mut filled.mud_pump,
                &mut filled.booster,
                &mut filled.topfill,
            ] {
                moved(flow);
            }
        }
        Channels::Level => {
            *inlet = bridged(inlet);
            moved(inlet);
            moved(&mut filled.inlet);
        }
    }
    other
}

impl OwnClock {
    /// Whether it makes a cause less likely.
    pub(super) fn speaks_against(&self, named: &Named) -> bool {
        let id = named.applied.effect.about().id;
        in_balance(named) && !self.beside.contains(&id)
    }

    /// What the mass balance would look like with one clock.
    fn told(&self) -> String {
        let Self {
            channels, late_s, ..
        } = self;
        let (by, how) = (late_s.abs(), if *late_s > 0.0 { "late" } else { "early" });
        format!("{} logged {by:.0} s {how}", channels.name())
    }

    /// Says of a finding in the mass balance what would look the same.
    pub(super) fn tell(&self, finding: &mut Finding) {
        let cause = finding.resembles.unwrap_or(&finding.effect);
        let beside = self.beside.contains(&cause);
        if finding.shows_in.contains(&Relation::RiserMassBalance) && !beside {
            let told = self.told();
            let as_set = if self.late_s > 0.0 { "" } else { "-" };
            let told = format!(
                "a clock of their own: {told} (`late = \"{as_set}{:.0} s\"` beside their tags in the well description)",
                self.late_s.abs()
            );
            finding.also_same_as(told);
        }
    }

    /// That the channels do not share one clock.
    pub(super) fn check(&self) -> Check {
        Check {
            name: ONE_CLOCK.into(),
            passed: false,
            detail: format!(
                "that {} explains the mass balance better than what was named in it, by {:.0} e-folds; mend the description and diagnose again",
                self.told(),
                self.saves
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::{Channels, OwnClock, own_clock_of, read_earlier};
    use crate::ablation::Step;
    use crate::record::Record;
    use crate::select::{Sought, select};
    use crate::selection::Selection;
    use crate::tangent::{Bend, Tangent};
    use crate::test_rig::{Hidden, drilled, found, named, steady};
    use dgd_effects::Relation;

    fn searched(record: &Record) -> (Selection, Option<OwnClock>) {
        let found = select(record, &[], Sought::Any(3), |_| {}).unwrap();
        let full = Tangent::at(record, &found.state(), &[], Bend::Stiff).unwrap();
        let clock = own_clock_of(record, &full, &found);
        (found, clock)
    }

    #[test]
    fn what_is_read_earlier_comes_earlier_and_ends_as_it_ended() {
        let mut record = steady(10);
        let n = record.t_s.len();
        record.filled.mud_pump = (0..n).map(|i| i as f64).collect();
        record.inlet = record.filled.mud_pump.clone();
        record.inlet[7] = f64::NAN;
        let late = read_earlier(&record, Channels::MudPump, 3.0 * record.dt_s);
        assert_eq!(late.filled.mud_pump[..3], [3.0, 4.0, 5.0]);
        let end = (n - 1) as f64;
        assert_eq!(
            late.filled.mud_pump[n - 5..],
            [end - 1.0, end, end, end, end]
        );
        assert_eq!(late.filled.booster, record.filled.booster);
        let early = read_earlier(&record, Channels::Level, -2.0 * record.dt_s);
        assert_eq!(early.inlet[..4], [0.0, 0.0, 0.0, 1.0]);
        assert_eq!(early.inlet[9], 7.0);
        assert_eq!(early.filled.mud_pump, record.filled.mud_pump);
        let far = read_earlier(&record, Channels::Inflows, 1e6);
        assert!(far.filled.mud_pump.iter().all(|v| *v == end));
    }

    #[test]
    fn a_late_flow_is_told_with_its_seconds_and_what_is_no_clock_is_not() {
        let mut kick = drilled(Hidden {
            influx_m3_s: 3e-3,
            ..Hidden::default()
        });
        // The flows of this drilling move all the time, by which flows that may be late would be allowed anything.
        kick.without = vec![Step::LateFlows];
        let (found, clock) = searched(&kick);
        assert!(
            found
                .named
                .iter()
                .any(|n| n.applied.effect.about().id == "influx")
        );
        assert_eq!(clock, None);
        let late = read_earlier(&kick, Channels::Inflows, -30.0);
        let clock = searched(&late).1.unwrap();
        assert!((clock.late_s - 30.0).abs() <= 4.0, "{clock:?}");
        assert_ne!(clock.channels, Channels::Level);
        assert!(clock.saves > 0.0, "{clock:?}");
    }

    #[test]
    fn causes_of_the_balance_that_are_seen_with_the_clock_too_are_not_doubted() {
        let clock = OwnClock {
            channels: Channels::Level,
            late_s: -14.0,
            saves: 40.0,
            beside: vec!["influx"],
        };
        let doubted = |id: &str| clock.speaks_against(&named(id, &[]));
        let all = ["influx", "annulus_area", "u_tube", "pump_wear"].map(doubted);
        assert_eq!(all, [false, true, true, false]);
        let told = |id: &str| {
            let mut finding = found(id, 0.9);
            finding.shows_in = vec![Relation::RiserMassBalance];
            clock.tell(&mut finding);
            finding.same_as
        };
        assert_eq!(told("influx"), None);
        let of_area = told("annulus_area").unwrap();
        assert!(
            of_area.contains("logged 14 s early (`late = \"-14 s\"`"),
            "{of_area}"
        );
    }
}
