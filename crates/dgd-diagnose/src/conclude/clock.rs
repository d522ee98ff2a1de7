//! Whether flows or pressures on a clock of their own explain the mass balance better than what was named there.
//!
//! A historian that gathers its channels from several systems may have each on its own clock. Mud that is logged late, or a level that
//! is, leaves at every change of flow what an area, moving pipe or a draining string leave there.

use super::residue::{ONE_CLOCK, is_early};
use crate::cores::each;
use crate::diagnosis::{Check, Finding};
use crate::numbers::{bridged, whole};
use crate::record::Record;
use crate::relations::{Applied, joined};
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

/// Channels on a clock of their own.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Late {
    channels: Channels,
    /// What was logged so late is read so much earlier, s; early where it is below 0.
    by_s: f64,
}

/// A clock of their own that explains more than what was named in the mass balance.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct OwnClock {
    late: Late,
    /// E-folds by which it does.
    saves: f64,
    /// Causes in the balance that are seen with it too.
    beside: Vec<&'static str>,
}

/// Seconds that are tried, to either side.
const TRIED_S: [f64; 5] = [6.0, 14.0, 24.0, 40.0, 70.0];
/// The most that a finer look may come to, s.
const MOST_S: f64 = 180.0;

/// The clock that explains more than what was named in the mass balance, in place of it, or of all but the causes that explain most;
/// `None` where none does. As few causes are kept as may be.
///
/// It must save as much beyond them as an allowance that makes something early.
///
/// - `full`: the tangent about all that was found, whose noise and rows all are judged by.
pub(super) fn own_clock_of(
    record: &Record,
    full: &Tangent,
    selection: &Selection,
) -> Option<OwnClock> {
    let (balance, others): (Vec<&Named>, Vec<&Named>) =
        selection.named.iter().partition(|n| in_balance(n));
    let with = |state: &[Applied], n: &Named| joined(state, &n.applied);
    let misfit = |off: &[f64]| 0.5 * dot(off, off);
    let given =
        |allowances: Vec<Applied>| (others.iter()).fold(allowances, |state, n| with(&state, n));
    let all = given(selection.allowances.clone());
    let causes = balance.iter().filter(|n| !n.applied.is_correction());
    let mut causes: Vec<(f64, &Named)> = causes
        .map(|n| (misfit(&full.left_over(record, &with(&all, n))), *n))
        .collect();
    causes.sort_by(|a, b| a.0.total_cmp(&b.0));
    // In place of what was allowed to be early too: that comes of a clock, and was paid for as one.
    let mut starts = vec![(EARLY, all)];
    if selection.allowances.iter().any(is_early) {
        let none_early = (selection.allowances.iter()).filter(|a| !is_early(a));
        starts.push((0.0, given(none_early.cloned().collect())));
    }
    let now = misfit(&full.off);
    let left = |other: &Record, state: &[Applied]| misfit(&full.left_over_of(other, state));
    for kept in 0..balance.len() {
        if kept > 0 {
            let (_, cause) = causes.get(kept - 1)?;
            for (_, state) in &mut starts {
                *state = with(state, cause);
            }
        }
        let clocks = starts.iter().filter_map(|(price, state)| {
            let (late, least) = best(record, |other| left(other, state))?;
            Some((now - least - price, late, least, state))
        });
        let (saves, late, least, state) = clocks.max_by(|a, b| a.0.total_cmp(&b.0))?;
        debug!("{late:?} saves {saves} beside {kept} causes");
        if saves > 0.0 && late.by_s.abs() > 0.0 {
            let other = read_earlier(record, late);
            let seen = |n: &Named| least - left(&other, &with(state, n)) > n.hurdle;
            let ranked = causes.iter().map(|(_, n)| n).enumerate();
            let beside = ranked.filter(|(rank, n)| *rank < kept || seen(n));
            return Some(OwnClock {
                late,
                saves,
                beside: beside.map(|(_, n)| n.applied.id()).collect(),
            });
        }
    }
    None
}

/// What leaves least of the recording that is read earlier by it, and that.
fn best(record: &Record, left: impl Fn(&Record) -> f64 + Sync) -> Option<(Late, f64)> {
    let tried = |late: Late| {
        let steps = whole(late.by_s.abs() / record.dt_s);
        let by_s = (steps as f64 * record.dt_s).copysign(late.by_s);
        let late = Late { by_s, ..late };
        (late, left(&read_earlier(record, late)))
    };
    let least = |of: Vec<(Late, f64)>| of.into_iter().min_by(|a, b| a.1.total_cmp(&b.1));
    let coarse = Channels::ALL.into_iter().flat_map(|channels| {
        let both = TRIED_S.into_iter().flat_map(|by_s| [by_s, -by_s]);
        both.map(move |by_s| Late { channels, by_s })
    });
    let mut best = least(each(coarse.collect(), tried))?;
    // Finer about the best, half as far where neither side is better.
    let mut reach_s = 0.5 * best.0.by_s.abs();
    while reach_s >= 0.5 * record.dt_s {
        let Late { channels, by_s } = best.0;
        let near = [by_s - reach_s, by_s + reach_s].map(|by_s| Late { channels, by_s });
        let near = near.into_iter().filter(|late| late.by_s.abs() <= MOST_S);
        match least(each(near.collect(), tried)) {
            Some(nearer) if nearer.1 < best.1 => best = nearer,
            _ => reach_s *= 0.5,
        }
    }
    Some(best)
}

/// Whether it shows in the mass balance.
pub(super) fn in_balance(named: &Named) -> bool {
    named.shows_in(Relation::RiserMassBalance)
}

/// The recording with those channels read earlier, and without gaps in them.
fn read_earlier(record: &Record, late: Late) -> Record {
    let mut other = record.clone();
    let steps = whole(late.by_s.abs() / record.dt_s);
    let moved = |values: &mut Vec<f64>| {
        let steps = steps.min(values.len());
        let ends = (values.first().copied(), values.last().copied());
        // What is beyond an end is as at the end.
        if late.by_s > 0.0 {
            values.rotate_left(steps);
            let beyond = values.len() - steps;
            values[beyond..].fill(ends.1.unwrap_or_default());
        } else {
            values.rotate_right(steps);
            values[..steps].fill(ends.0.unwrap_or_default());
        }
    };
    let Record { inlet, filled, .. } = &mut other;
    match late.channels {
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

impl Late {
    fn told(self) -> String {
        let (by_s, how) = if self.by_s > 0.0 {
            (self.by_s, "late")
        } else {
            (-self.by_s, "early")
        };
        format!("{} logged {by_s:.0} s {how}", self.channels.name())
    }

    /// What mends it in the well description.
    fn mend(self) -> String {
        format!(
            "`late = \"{:.0} s\"` beside their tags in the well description",
            self.by_s
        )
    }
}

impl OwnClock {
    /// Whether it makes a cause less likely.
    pub(super) fn speaks_against(&self, named: &Named) -> bool {
        let id = named.applied.id();
        in_balance(named) && !self.beside.contains(&id)
    }

    /// Says of a finding in the mass balance what would look the same.
    pub(super) fn tell(&self, finding: &mut Finding) {
        let cause = finding.resembles.unwrap_or(&finding.effect);
        let beside = self.beside.contains(&cause);
        if finding.shows_in.contains(&Relation::RiserMassBalance) && !beside {
            let (told, mend) = (self.late.told(), self.late.mend());
            finding.also_same_as(format!("a clock of their own: {told} ({mend})"));
        }
    }

    /// That it may be so, and what to do then.
    pub(super) fn warning(&self) -> String {
        format!(
            "do the channels share one clock? That {} explains the mass balance better than what was named in it. If they do not, set {}",
            self.late.told(),
            self.late.mend()
        )
    }

    /// That the channels do not share one clock.
    pub(super) fn check(&self) -> Check {
        Check {
            name: ONE_CLOCK.into(),
            passed: false,
            detail: format!(
                "that {} explains the mass balance better than what was named in it, by {:.0} e-folds; mend the description and diagnose again",
                self.late.told(),
                self.saves
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::{Channels, Late, OwnClock, own_clock_of, read_earlier as read};
    use crate::ablation::Step;
    use crate::record::Record;
    use crate::select::{Sought, select};
    use crate::selection::{Named, Selection};
    use crate::tangent::{Bend, Tangent};
    use crate::test_rig::{Hidden, drilled, found, named, steady};
    use dgd_effects::Relation;

    fn read_earlier(record: &Record, channels: Channels, by_s: f64) -> Record {
        read(record, Late { channels, by_s })
    }

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
        assert!(found.named.iter().any(|n| n.applied.id() == "influx"));
        assert_eq!(clock, None);
        let late = read_earlier(&kick, Channels::Inflows, -30.0);
        let clock = searched(&late).1.unwrap();
        assert!((clock.late.by_s - 30.0).abs() <= 4.0, "{clock:?}");
        assert_ne!(clock.late.channels, Channels::Level);
        assert!(clock.saves > 0.0, "{clock:?}");
    }

    #[test]
    fn a_clock_is_told_beside_a_cause_that_it_cannot_replace() {
        let mut kick = drilled(Hidden {
            influx_m3_s: 2e-2,
            ..Hidden::default()
        });
        kick.without = vec![Step::LateFlows];
        let late = read_earlier(&kick, Channels::Inflows, -60.0);
        let (found, clock) = searched(&late);
        let ids = |named: &[Named]| -> Vec<&str> { named.iter().map(|n| n.applied.id()).collect() };
        assert_eq!(ids(&found.named), ["influx", "unknown"]);
        let clock = clock.unwrap();
        assert!((clock.late.by_s - 60.0).abs() <= 4.0, "{clock:?}");
        assert_eq!(clock.beside, ["influx"]);
    }

    #[test]
    fn causes_of_the_balance_that_are_seen_with_the_clock_too_are_not_doubted() {
        let clock = OwnClock {
            late: Late {
                channels: Channels::Level,
                by_s: -14.0,
            },
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
