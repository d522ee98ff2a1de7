//! Readings that have gone dead: for many minutes they say that nothing flows or turns, and the others say otherwise.
//!
//! A reading of 0 may be true. Taken for true where it is not, a mud pump whose strokes are lost looks like a kick of just its flow, and a
//! return meter that has failed like a loss; and where pump and flow contradict each other no row can be used, so that nothing is said of them.

use crate::diagnosis::Check;
use crate::numbers::{mean_of, whole};
use dgd_effects::{STANDING_M3_S, STANDING_PCT};
use dgd_identify::Prepared;
use dgd_recording::{Channel, Well};
use std::borrow::Cow;
use std::ops::Range;

/// How long a reading is 0 at the least, s: shorter ones are stops, and signals that come back. Set by hand.
const LONG_S: f64 = 600.0;
/// Time over which what came before is averaged, s. Set by hand.
const BEFORE_S: f64 = 120.0;
/// Before its end, and after its beginning, so much of it is not judged, s: mud and instruments come to rest. Set by hand.
const SETTLES_S: f64 = 30.0;
/// How many times what counts as standing there was before. Set by hand.
const MOVED: f64 = 5.0;
/// Share by which the jump of the riser's balance may differ from the flow that a pump had: a kick is so like it only by chance. Set by hand.
const ALIKE: f64 = 0.15;
/// What is judged at a time, s, and the share of a stretch in which readings must contradict each other: pumps do stop within an hour. Set by hand.
const PART_S: f64 = 60.0;
const MOSTLY: f64 = 0.6;
/// The same of a pump that lifts nothing: one that is stopped does not. Set by hand.
const NEARLY_ALL: f64 = 0.9;
/// Share of what was there before from which on the line flows, by the weight of a column that stops tell and by that of the description; and up to
/// which it rests. Set by hand.
const FLOWS: f64 = 0.5;
const FLOWS_AS_DESCRIBED: f64 = 0.75;
const RESTS: f64 = 0.25;
/// Friction that can be told from an error of the column's weight, Pa. Set by hand.
const FRICTION_PA: f64 = 5e4;
/// A pump that turns no slower than before, by this share, and has this share less to lift must lift mud: heads fall with the flow, or fold by less. Set
/// by hand.
const SPARE: f64 = 0.05;

/// What readings of 0 contradict.
#[derive(Debug, Clone, Copy, PartialEq)]
enum What {
    /// The reading itself is lost: the others go on.
    Lost(Channel),
    /// The pump turns as before, at this speed, %, and does not lift.
    LiftsNothing { speed_pct: f64 },
}

/// A stretch in which readings contradict each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Dead {
    what: What,
    from_s: f64,
    to_s: f64,
    /// What was read until then, m³/s or %; of a pump that lifts nothing, the flow.
    before: f64,
}

/// The stretches of a recording, and the recording without the readings that are lost in them.
pub(crate) fn without_dead<'a>(
    well: &Well,
    prepared: &'a Prepared,
) -> (Vec<Dead>, Cow<'a, Prepared>) {
    let found = stretches(well, prepared);
    let mut alive = Cow::Borrowed(prepared);
    for (dead, at) in &found {
        let What::Lost(channel) = dead.what else {
            continue;
        };
        let alive = alive.to_mut();
        if let Some(values) = alive.recording.channel_mut(channel) {
            values[at.clone()].fill(f64::NAN);
            alive.keep[at.clone()].fill(false);
        }
    }
    (found.into_iter().map(|(dead, _)| dead).collect(), alive)
}

impl Dead {
    /// What is contradicted, and what to look at.
    pub(crate) fn warning(&self) -> String {
        let (from, to) = (self.from_s, self.to_s);
        let l_min = 6e4 * self.before;
        match self.what {
            What::Lost(channel @ Channel::PumpSpeed) => format!(
                "`{channel}` reads 0 from {from:.0} to {to:.0} s while the outlet keeps the friction of a flow, and is not used there; is its signal lost, or does another pump lift?"
            ),
            What::Lost(channel @ Channel::ReturnFlow) => format!(
                "`{channel}` reads 0 from {from:.0} to {to:.0} s after {l_min:.0} L/min, while the outlet keeps the friction of a flow and the riser does not fill, and is \
                 not used there; has the meter failed?"
            ),
            What::Lost(channel) => format!(
                "`{channel}` reads 0 from {from:.0} to {to:.0} s after {l_min:.0} L/min, while just as much more comes back than is read to be pumped in, and is not used there; is its \
                 signal lost?"
            ),
            What::LiftsNothing { speed_pct } => format!(
                "the subsea pump turns at {speed_pct:.0} % from {from:.0} to {to:.0} s and lifts nothing, though it lifted {l_min:.0} L/min at no higher speed, and higher, until then: did it trip (is the \
                 speed a set-point?), lose its prime, or was a valve shut? The model has no such thing"
            ),
        }
    }

    /// That readings contradict each other, if any do.
    pub(crate) fn check(all: &[Self]) -> Option<Check> {
        let told: Vec<String> = all
            .iter()
            .map(|dead| {
                let what = match dead.what {
                    What::Lost(channel) => format!("`{channel}` is lost"),
                    What::LiftsNothing { .. } => "the subsea pump lifts nothing".to_owned(),
                };
                format!("{what} from {:.0} to {:.0} s", dead.from_s, dead.to_s)
            })
            .collect();
        (!told.is_empty()).then(|| Check {
            name: "readings of 0 agree with the others".into(),
            passed: false,
            detail: told.join("; "),
        })
    }
}

/// Series that are looked at together.
struct Readings<'a> {
    prepared: &'a Prepared,
    inflows: [&'a [f64]; 3],
    flow: &'a [f64],
    speed: &'a [f64],
    inlet: &'a [f64],
    outlet: &'a [f64],
    /// What a pascal at the pump inlet is worth in the riser, m³.
    riser_m3_per_pa: f64,
    /// Pressure of the standing line at the outlet, Pa, and whether stops tell it, not the description.
    column_pa: f64,
    is_read: bool,
}

fn stretches(well: &Well, prepared: &Prepared) -> Vec<(Dead, Range<usize>)> {
    let recording = &prepared.recording;
    let mut readings = Readings {
        prepared,
        inflows: [
            &recording.mud_pump_flow_m3_s,
            &recording.booster_flow_m3_s,
            &recording.topfill_flow_m3_s,
        ],
        flow: &recording.return_flow_m3_s,
        speed: &recording.pump_speed_pct,
        inlet: &prepared.inlet_pressure_pa,
        outlet: &prepared.outlet_pressure_pa,
        riser_m3_per_pa: well.geometry.riser_area_m2() / well.weight_pa_m(),
        column_pa: -well.line_friction_pa(0.0),
        is_read: false,
    };
    if let Some(column_pa) = readings.column_at_stops() {
        (readings.column_pa, readings.is_read) = (column_pa, true);
    }
    let channels = [
        (Channel::MudPumpFlow, readings.inflows[0], STANDING_M3_S),
        (Channel::BoosterFlow, readings.inflows[1], STANDING_M3_S),
        (Channel::ReturnFlow, readings.flow, STANDING_M3_S),
        (Channel::PumpSpeed, readings.speed, STANDING_PCT),
    ];
    let mut found = Vec::new();
    for (channel, values, standing) in channels {
        for at in readings.at_rest(values, standing) {
            let before = told(values, &readings.until(&at));
            // What never moved before has not stopped; a speed that never changed may not have been trusted then.
            let moved =
                before > MOVED * standing || channel == Channel::PumpSpeed && before.is_nan();
            if moved && let Some(what) = readings.judged((channel, values), &at, before) {
                let time = |i: usize| recording.time_s[i];
                let dead = Dead {
                    what,
                    from_s: time(at.start),
                    to_s: time(at.end - 1),
                    before,
                };
                found.push((dead, at));
            }
        }
    }
    found
}

impl Readings<'_> {
    fn samples(&self, seconds: f64) -> usize {
        whole(seconds / self.prepared.step_s)
    }

    /// What the outlet reads where neither anything flows nor the pump turns; `None` of less than a minute of that.
    fn column_at_stops(&self) -> Option<f64> {
        let stops = |i: &usize| {
            self.flow[*i] <= STANDING_M3_S
                && self.speed[*i] <= STANDING_PCT
                && self.outlet[*i].is_finite()
        };
        let read = || (0..self.flow.len()).filter(stops).map(|i| self.outlet[i]);
        (read().count() >= self.samples(PART_S).max(1)).then(|| mean_of(read()))
    }

    /// Stretches in which a reading tells of no more than standing, from the first to the last that does; less than a minute that is missing among
    /// it is no end of one.
    fn at_rest(&self, values: &[f64], standing: f64) -> Vec<Range<usize>> {
        let (least, missing) = (self.samples(LONG_S).max(3), self.samples(PART_S).max(1));
        let mut found = Vec::new();
        let mut rest: Option<Range<usize>> = None;
        for (i, value) in values.iter().chain([&f64::INFINITY]).enumerate() {
            let rests = *value <= standing;
            let ends = !rests && !value.is_nan();
            if let Some(at) = rest.take_if(|at| ends || i - at.end >= missing)
                && at.len() >= least
            {
                found.push(at);
            }
            if rests {
                rest.get_or_insert(i..i).end = i + 1;
            }
        }
        found
    }

    /// What comes before a stretch.
    fn until(&self, at: &Range<usize>) -> Range<usize> {
        at.start.saturating_sub(self.samples(BEFORE_S))..at.start
    }

    /// What comes after it.
    fn after(&self, at: &Range<usize>) -> Range<usize> {
        let settled = (at.end + self.samples(SETTLES_S)).min(self.flow.len());
        settled..(settled + self.samples(BEFORE_S)).min(self.flow.len())
    }

    /// Share of the parts of a stretch, its ends left out, of which something is true.
    fn share(&self, at: &Range<usize>, is: impl Fn(&Range<usize>) -> bool) -> f64 {
        let settles = self.samples(SETTLES_S);
        let part = self.part();
        let parts = (at.start + settles..at.end.saturating_sub(settles) + 1 - part)
            .step_by(part)
            .map(|from| from..from + part);
        mean_of(parts.map(|part| f64::from(u8::from(is(&part)))))
    }

    /// Samples of what is judged at a time: a rate needs two.
    fn part(&self) -> usize {
        self.samples(PART_S).max(2)
    }

    fn friction_pa(&self, at: &Range<usize>) -> f64 {
        told(self.outlet, at) - self.column_pa
    }

    /// Whether the line flows, by what its friction was before a stretch.
    fn rubs(&self, part: &Range<usize>, rubbed_pa: f64) -> bool {
        let flows = if self.is_read {
            FLOWS
        } else {
            FLOWS_AS_DESCRIBED
        };
        rubbed_pa > FRICTION_PA && self.friction_pa(part) > flows * rubbed_pa
    }

    /// Whether mud is lifted while the speed says that nothing turns.
    fn speed_is_lost(&self, at: &Range<usize>) -> bool {
        let rubbed_pa = self.friction_pa(&self.until(at));
        let lifts = |part: &Range<usize>| {
            // Less may flow than before.
            let rubs_read = self.is_read && self.friction_pa(part) > FRICTION_PA;
            told(self.flow, part) > MOVED * STANDING_M3_S
                && (rubs_read || self.rubs(part, rubbed_pa))
        };
        self.share(at, lifts) >= MOSTLY
    }

    /// Whether mud leaves through the line while its meter says that nothing flows, as `before` did, m³/s.
    fn meter_is_lost(&self, at: &Range<usize>, before: f64) -> bool {
        let rubbed_pa = self.friction_pa(&self.until(at));
        let leaves = |part: &Range<usize>| {
            self.rubs(part, rubbed_pa) && self.imbalance(part) > FLOWS * before
        };
        self.share(at, leaves) >= MOSTLY
    }

    /// Whether the pump turns as before, with less to lift, and the line stands.
    fn lifts_nothing(&self, at: &Range<usize>) -> bool {
        let lift_pa = |at: &Range<usize>| told(self.outlet, at) - told(self.inlet, at);
        let until = self.until(at);
        let (rubbed_pa, lifted_pa) = (self.friction_pa(&until), lift_pa(&until));
        let turned_pct = told(self.speed, &until);
        let rests = |part: &Range<usize>| {
            rubbed_pa > FRICTION_PA
                && self.friction_pa(part) < RESTS * rubbed_pa
                && told(self.speed, part) > (1.0 - SPARE) * turned_pct
                && lift_pa(part) < (1.0 - SPARE) * lifted_pa
        };
        self.share(at, rests) >= NEARLY_ALL
    }

    /// Whether as much comes back while a pump says that nothing flows as did `before`, m³/s, or as it goes and as it comes again.
    fn inflow_is_lost(&self, values: &[f64], at: &Range<usize>, before: f64) -> bool {
        // What is missing as well where the pump was read is another matter: one that is not logged, a kick before.
        let missing = |part: &Range<usize>, beside: &Range<usize>, of: f64| {
            let jump = self.imbalance(beside) - self.imbalance(part);
            (jump / of - 1.0).abs() < ALIKE
        };
        let until = self.until(at);
        if self.share(at, |part| missing(part, &until, before)) >= MOSTLY {
            return true;
        }
        // A pump may change its rate meanwhile: as it is lost and as it comes back, the balance jumps by just what it reads.
        let (settles, part) = (self.samples(SETTLES_S), self.part());
        let (first, last) = (at.start + settles, at.end - settles);
        let after = self.after(at);
        missing(&(first..first + part), &until, before)
            && missing(&(last - part..last), &after, told(values, &after))
    }

    /// What contradicts the `values` of a channel in a stretch.
    fn judged(
        &self,
        (channel, values): (Channel, &[f64]),
        at: &Range<usize>,
        before: f64,
    ) -> Option<What> {
        let is_lost = match channel {
            Channel::PumpSpeed => self.speed_is_lost(at),
            Channel::ReturnFlow => self.meter_is_lost(at, before),
            _ => self.inflow_is_lost(values, at, before),
        };
        if is_lost {
            return Some(What::Lost(channel));
        }
        let speed_pct = told(self.speed, at);
        (channel == Channel::ReturnFlow && self.lifts_nothing(at))
            .then_some(What::LiftsNothing { speed_pct })
    }

    /// What is read to flow in less what is read to flow out and what the riser stores, over a stretch, m³/s: Eq. 3.45. NaN where something is not
    /// read.
    fn imbalance(&self, at: &Range<usize>) -> f64 {
        if at.len() < 2 {
            return f64::NAN;
        }
        let edge = at.len().div_ceil(6);
        let level = |from: usize| told(self.inlet, &(from..from + edge));
        let rises_pa = level(at.end.saturating_sub(edge)) - level(at.start);
        let seconds = self.prepared.step_s * (at.len() - edge) as f64;
        let inflow: f64 = self.inflows.iter().map(|values| told(values, at)).sum();
        inflow - told(self.flow, at) - self.riser_m3_per_pa * rises_pa / seconds
    }
}

/// Mean of what is read in a stretch; NaN if that is less than half of it.
fn told(values: &[f64], at: &Range<usize>) -> f64 {
    let read = || values[at.clone()].iter().copied().filter(|v| v.is_finite());
    if 2 * read().count() > at.len() {
        mean_of(read())
    } else {
        f64::NAN
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may fail by panic")]

    use super::{Dead, LONG_S, What, without_dead};
    use crate::numbers::whole;
    use crate::record::Record;
    use crate::test_rig::{DT_S, FLOW_M3_S, MUD_PUMP_M3_S, SPEED_PCT, recorded, steady};
    use dgd_recording::Channel;
    use std::ops::Range;

    const FRICTION_PA: f64 = 8e5;

    /// An hour of steady drilling, with something done to a stretch of it.
    fn told(seconds: f64, does: impl Fn(&mut Record, Range<usize>)) -> Vec<Dead> {
        let (record, at) = drilled(seconds, does);
        let (well, prepared) = recorded(&record, 0.0);
        let (dead, alive) = without_dead(&well, &prepared);
        for one in &dead {
            let times_s = (DT_S * at.start as f64, DT_S * (at.end - 1) as f64);
            assert_eq!((one.from_s, one.to_s), times_s);
            if let What::Lost(channel) = one.what {
                let mut recording = alive.recording.clone();
                let values = recording.channel_mut(channel).unwrap();
                let gone: Vec<usize> = (0..values.len()).filter(|i| values[*i].is_nan()).collect();
                assert_eq!(gone, at.clone().collect::<Vec<usize>>());
                assert!(at.clone().all(|i| !alive.keep[i]));
            }
        }
        dead
    }

    fn drilled(seconds: f64, does: impl Fn(&mut Record, Range<usize>)) -> (Record, Range<usize>) {
        let mut record = steady(360);
        let outlet = record.column_pa() + FRICTION_PA;
        record.outlet.fill(outlet);
        record.booster.fill(FLOW_M3_S - MUD_PUMP_M3_S);
        let at = 600..600 + whole(seconds / DT_S);
        does(&mut record, at.clone());
        (record, at)
    }

    fn is_lost(dead: &[Dead], channel: Channel) -> bool {
        matches!(dead, [one] if one.what == What::Lost(channel))
    }

    #[test]
    fn a_reading_of_0_that_the_others_contradict_is_lost() {
        for seconds in [LONG_S, 1500.0] {
            assert!(is_lost(
                &told(seconds, |r, at| r.mud_pump[at].fill(0.0)),
                Channel::MudPumpFlow
            ));
            assert!(is_lost(
                &told(seconds, |r, at| r.booster[at].fill(0.0)),
                Channel::BoosterFlow
            ));
            assert!(is_lost(
                &told(seconds, |r, at| r.flow[at].fill(0.0)),
                Channel::ReturnFlow
            ));
            assert!(is_lost(
                &told(seconds, |r, at| r.speed[at].fill(0.0)),
                Channel::PumpSpeed
            ));
        }
        assert!(told(LONG_S - 10.0, |r, at| r.mud_pump[at].fill(0.0)).is_empty());
        assert!(told(1500.0, |_, _| {}).is_empty());
    }

    #[test]
    fn pumps_do_stop_within_a_reading_that_is_lost() {
        // Two connections of three minutes: nothing flows, and the line stands.
        let dead = told(1500.0, |r, at| {
            r.mud_pump[at.clone()].fill(0.0);
            for stop in [
                at.start + 100..at.start + 190,
                at.start + 400..at.start + 490,
            ] {
                let column = r.column_pa();
                r.flow[stop.clone()].fill(0.0);
                r.booster[stop.clone()].fill(0.0);
                r.outlet[stop].fill(column);
            }
        });
        assert!(is_lost(&dead, Channel::MudPumpFlow), "{dead:?}");
    }

    #[test]
    fn a_pump_may_change_its_rate_while_its_reading_is_lost() {
        // Twice as fast soon; at the end as fast still, or not.
        let faster = |at_the_end: f64| {
            told(1500.0, |r, at| {
                for values in [&mut r.flow, &mut r.mud_pump] {
                    let sooner = at.start + 60..values.len();
                    values[sooner].iter_mut().for_each(|q| *q += MUD_PUMP_M3_S);
                }
                let last = at.end - 120..at.end;
                let more = (at_the_end - 1.0) * 2.0 * MUD_PUMP_M3_S;
                r.flow[last].iter_mut().for_each(|q| *q += more);
                r.mud_pump[at].fill(0.0);
            })
        };
        assert!(is_lost(&faster(1.0), Channel::MudPumpFlow));
        assert!(faster(0.8).is_empty() && faster(1.25).is_empty());
    }

    #[test]
    fn what_is_missing_before_as_well_is_no_lost_reading() {
        // A booster that is not logged pumps as much as the mud pump, which stops; a kick that comes on does not stop with it.
        let unlogged = told(1500.0, |r, at| {
            r.flow.iter_mut().for_each(|q| *q += MUD_PUMP_M3_S);
            r.flow[at.clone()]
                .iter_mut()
                .for_each(|q| *q -= MUD_PUMP_M3_S);
            r.mud_pump[at].fill(0.0);
        });
        assert!(unlogged.is_empty(), "{unlogged:?}");
    }

    #[test]
    fn a_flow_without_friction_tells_of_no_pump_and_a_speed_that_is_missing_of_no_rest() {
        // Trip tank through the meter: the line stands.
        let trips = told(1500.0, |r, at| {
            let column = r.column_pa();
            r.speed[at.clone()].fill(0.0);
            r.outlet[at].fill(column);
        });
        assert!(trips.is_empty(), "{trips:?}");
        // Three minutes of rest, and then nothing read.
        let gap = told(1500.0, |r, at| {
            r.speed[at.start..at.start + 90].fill(0.0);
            r.speed[at.start + 90..at.end].fill(f64::NAN);
        });
        assert!(gap.is_empty(), "{gap:?}");
    }

    #[test]
    fn a_loss_is_no_dead_meter_where_the_description_weighs_the_mud_too_light() {
        // By 5 %: what is lost takes 8 bar of friction with it, of 16.8 as described.
        let lost = |back: f64| {
            let (record, _) = drilled(1500.0, |r, at| {
                let heavier = 0.05 * (r.column_pa() - 1e5);
                r.outlet.iter_mut().for_each(|p| *p += heavier);
                r.outlet[at.clone()]
                    .iter_mut()
                    .for_each(|p| *p -= back * FRICTION_PA);
                r.flow[at.clone()].fill(0.0);
                r.speed[at].fill(0.5 * SPEED_PCT);
            });
            let (well, prepared) = recorded(&record, 0.0);
            without_dead(&well, &prepared).0
        };
        assert!(lost(1.0).is_empty());
        assert!(is_lost(&lost(0.0), Channel::ReturnFlow));
    }

    #[test]
    fn a_stop_a_kick_and_a_loss_are_none() {
        let rests = |r: &mut Record, at: Range<usize>| {
            let column = r.column_pa();
            r.outlet[at.clone()].fill(column);
            r.flow[at].fill(0.0);
        };
        // All pumps stop.
        let stop = told(1500.0, |r, at| {
            rests(r, at.clone());
            r.mud_pump[at.clone()].fill(0.0);
            r.booster[at.clone()].fill(0.0);
            r.speed[at].fill(0.0);
        });
        assert!(stop.is_empty(), "{stop:?}");
        // The mud pump stops, and four fifths as much flow in.
        let kick = told(1500.0, |r, at| {
            r.mud_pump[at.clone()].fill(0.0);
            r.flow[at]
                .iter_mut()
                .for_each(|q| *q -= 0.2 * MUD_PUMP_M3_S);
        });
        assert!(kick.is_empty(), "{kick:?}");
        // All mud is lost, the level falls, and the controller slows the pump.
        let loss = told(1500.0, |r, at| {
            rests(r, at.clone());
            r.speed[at].fill(0.5 * SPEED_PCT);
        });
        assert!(loss.is_empty(), "{loss:?}");
    }

    #[test]
    fn a_pump_that_turns_as_before_and_lifts_nothing_is_told_of() {
        let trips = |slower: f64, inlet_pa: f64| {
            told(1500.0, |r, at| {
                let column = r.column_pa();
                // Static: friction is gone, and the pump has less to lift.
                r.inlet.fill(column + FRICTION_PA - 50e5);
                r.inlet[at.clone()].fill(column + FRICTION_PA - 50e5 - inlet_pa);
                r.outlet[at.clone()].fill(column);
                r.flow[at.clone()].fill(0.0);
                r.speed[at].fill(slower * SPEED_PCT);
            })
        };
        let found = trips(1.0, 0.0);
        assert!(
            matches!(found.as_slice(), [one] if matches!(one.what, What::LiftsNothing { .. })),
            "{found:?}"
        );
        assert!(
            found[0]
                .warning()
                .contains("lifts nothing, though it lifted 2"),
            "{}",
            found[0].warning()
        );
        // Slower, or with a level that has fallen as far, it need not lift.
        assert!(trips(0.9, 0.0).is_empty());
        assert!(trips(1.0, 6e5).is_empty());
        let check = Dead::check(&found).map(|check| (check.passed, check.detail));
        assert_eq!(
            check,
            Some((
                false,
                "the subsea pump lifts nothing from 1200 to 2698 s".to_owned()
            ))
        );
        assert!(Dead::check(&[]).is_none());
    }
}
