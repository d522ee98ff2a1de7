//! Channels of which a historian keeps too little: a deadband, few digits, a value every half minute, or lines between a few.

use super::facts::{quantile, source_of};
use super::{Suspicion, WellLine, words};
use crate::channel::is_pressure;
use crate::{ScreenError, error};
use dgd_recording::{Channel, ChannelSource, Recording, STANDING_M3_S, Well, held_for};
use dgd_units::Unit;

/// Share of the samples of flowing mud at which a meter must rest to be coarse.
const RESTS: f64 = 0.5;
/// Fewest movements that tell their size.
const FEWEST: usize = 20;
/// Least movement of a pressure that is too coarse, Pa, and of the return flow, m³/s: set by hand.
const PRESSURE_PA: f64 = 1.5e4;
const FLOW_M3_S: f64 = 1e-3;
/// The same of the pump's speed, %, where it moves again within so long in the mean, s: a set-point that is set rests longer.
const SPEED_PCT: f64 = 0.2;
const SET_S: f64 = 240.0;
/// Share of the samples of flowing mud at which a channel must move along straight lines to be interpolated. Set by hand.
const STRAIGHT: f64 = 0.3;
/// The same where few corners tell it, and the fewest that do. Set by hand.
const MOSTLY_STRAIGHT: f64 = 0.5;
const FEW_CORNERS: usize = 8;
/// Time between two readings that is too long for causes of seconds to minutes, s: set by hand.
pub const TOO_SELDOM_S: f64 = 10.0;

/// A channel of which a historian keeps too little.
#[derive(Debug, Clone, PartialEq)]
pub struct Coarse {
    /// Which it is.
    pub channel: Channel,
    /// What is kept of it.
    pub kept: Kept,
    /// Channel and tag.
    name: String,
    /// What the description says it is in.
    unit: Unit,
}

/// What a historian keeps of a channel.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Kept {
    /// A reading every so many seconds, held in between.
    Seldom(f64),
    /// Movements of so much and more, SI (% of a speed), as by a deadband or few digits.
    Moves(f64),
    /// A few readings, with straight lines drawn between them; this share of the samples of flowing mud lies on those that move.
    OnLines(f64),
}

/// Channels in which causes are made up by what a historian leaves out: pressures, the return flow and a speed that rest while mud flows and then move
/// by much, any flow or pressure whose readings are held for [`TOO_SELDOM_S`] or more, and any channel but the speed that lies on straight lines.
///
/// - `recording`: as read, before any screening, on an even clock; any length.
/// - `step_s`: step of that clock, s.
///
/// ```
/// # use dgd_recording::{Recording, Well};
/// # fn told(recording: &Recording, well: &Well) -> Result<(), dgd_screen::ScreenError> {
/// let coarse = dgd_screen::coarse(recording, 1.0, well)?;
/// for suspicion in dgd_screen::Coarse::suspicions(&coarse) {
///     eprintln!("{suspicion}");
/// }
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// [`ScreenError::Step`], [`ScreenError::Unequal`], [`ScreenError::Uneven`], as [`crate::suspect`].
pub fn coarse(recording: &Recording, step_s: f64, well: &Well) -> Result<Vec<Coarse>, ScreenError> {
    error::check(recording, step_s)?;
    let flowing: Vec<bool> = (recording.return_flow_m3_s.iter())
        .map(|q| *q > STANDING_M3_S)
        .collect();
    let all = (recording.series().into_iter())
        .filter_map(|(channel, values)| Coarse::of(channel, values, &flowing, step_s, well));
    Ok(all.collect())
}

impl Coarse {
    fn of(
        channel: Channel,
        values: &[f64],
        flowing: &[bool],
        step_s: f64,
        well: &Well,
    ) -> Option<Self> {
        let ChannelSource::Column { tag, unit, .. } = source_of(well, channel)? else {
            return None;
        };
        // Of one reading a sample nothing is held: that the recorder is slow is told once, of all channels.
        let held = held_for(values);
        let held_s = held as f64 * step_s;
        // A booster or top-fill that was set a few times rests in between.
        let set = matches!(channel, Channel::BoosterFlow | Channel::TopfillFlow)
            && values.len() < FEWEST * held;
        let is_slow = held > 1 && held_s >= TOO_SELDOM_S;
        let kept = if is_slow && !set && channel != Channel::PumpSpeed {
            Kept::Seldom(held_s)
        } else if channel != Channel::PumpSpeed
            && let Some(share) = straight(values, flowing, step_s)
        {
            // A speed is ramped.
            Kept::OnLines(share)
        } else {
            Kept::Moves(least_movement(channel, values, flowing, step_s)?)
        };
        Some(Self {
            channel,
            kept,
            name: format!("{channel} `{tag}`"),
            unit: *unit,
        })
    }

    /// What is to be asked aloud: of channels on straight lines once, with the first of them.
    pub fn suspicions(all: &[Self]) -> Vec<Suspicion> {
        let own = all.iter().filter_map(|one| Some((one, one.of_its_own()?)));
        let suspicions = on_lines(all).into_iter().chain(own).map(|(one, what)| Suspicion {
            place: WellLine::of(one.channel),
            message: format!(
                "{what}: this can produce false causes; confirm any finding on an export with all readings"
            ),
        });
        suspicions.collect()
    }

    /// What is said of this channel alone.
    fn of_its_own(&self) -> Option<String> {
        let Self { name, unit, .. } = self;
        match self.kept {
            Kept::Seldom(every_s) => Some(format!(
                "{name} gives a reading every {} s and holds it in between",
                words::number(every_s)
            )),
            Kept::Moves(least) => Some(format!(
                "{name} is constant at most samples while mud flows and then moves by {} {unit} or more, as with a deadband or few digits",
                words::number(least / unit.factor)
            )),
            Kept::OnLines(_) => None,
        }
    }
}

/// What is said of channels on straight lines, with the first of them: whoever made the export did the same to all.
fn on_lines(all: &[Coarse]) -> Option<(&Coarse, String)> {
    let share = |one: &Coarse| match one.kept {
        Kept::OnLines(share) => Some(100.0 * share),
        _ => None,
    };
    let told: Vec<&Coarse> = all.iter().filter(|one| share(one).is_some()).collect();
    let names: Vec<&str> = told.iter().map(|one| one.name.as_str()).collect();
    let shares = || told.iter().filter_map(|one| share(one));
    let most = shares().fold(0.0, f64::max);
    let least = shares().fold(most, f64::min);
    let verb = if names.len() == 1 { "moves" } else { "move" };
    let range = if (most - least).abs() < 1.0 {
        format!("{most:.0}")
    } else {
        format!("{least:.0} to {most:.0}")
    };
    let what = format!(
        "{} {verb} on straight lines at {range} % of the samples while mud flows, as an archive draws them between the few readings it kept",
        names.join(", ")
    );
    Some((told.first()?, what))
}

/// Share of the samples of flowing mud at which a channel moves along a straight line, if that is an archive's doing.
///
/// Where lines meet, the second difference is large and those beside it are nothing; noise has no such corners, and a curve leaves the chord
/// between two of them.
fn straight(values: &[f64], flowing: &[bool], step_s: f64) -> Option<f64> {
    /// By how much a corner stands out over the samples beside it, and over what lies on the lines.
    const STANDS_OUT: f64 = 20.0;
    let bend = |i: usize| (values[i + 1] - 2.0 * values[i] + values[i - 1]).abs();
    let inside = || (2..values.len().saturating_sub(2)).filter(|i| flowing[*i]);
    let is_corner = |i: &usize| bend(*i) > STANDS_OUT * bend(i - 1).max(bend(i + 1));
    let corners: Vec<usize> = inside().filter(is_corner).collect();
    let enough = match corners.len() {
        0..FEW_CORNERS => return None,
        FEW_CORNERS..FEWEST => MOSTLY_STRAIGHT,
        FEWEST.. => STRAIGHT,
    };
    let least = quantile(corners.iter().map(|i| bend(*i)), 0.5) / STANDS_OUT;
    let on_chord = |from: usize, to: usize| {
        let along = |i: usize| {
            let share = (i - from) as f64 / (to - from) as f64;
            values[from] + share * (values[to] - values[from])
        };
        [1, 2, 3]
            .map(|quarter| from + quarter * (to - from) / 4)
            .iter()
            .all(|i| (values[*i] - along(*i)).abs() < least)
    };
    let lines = corners.windows(2).map(|ends| (ends[0], ends[1]));
    let moving = lines.filter(|(from, to)| values[*from] != values[*to] && on_chord(*from, *to));
    let lengths: Vec<usize> = moving.map(|(from, to)| to - from).collect();
    // Rows that come seldom, and were filled in evenly, leave nothing out.
    let usual = quantile(lengths.iter().map(|length| *length as f64), 0.5);
    let even = lengths
        .iter()
        .filter(|length| **length as f64 == usual)
        .count();
    if 2 * even > lengths.len() && usual * step_s < TOO_SELDOM_S {
        return None;
    }
    let share = lengths.iter().sum::<usize>() as f64 / inside().count() as f64;
    (share > enough).then_some(share.min(1.0))
}

/// The least movement of a meter that rests while mud flows, but for the rarest tenth, where it is too much.
fn least_movement(channel: Channel, values: &[f64], flowing: &[bool], step_s: f64) -> Option<f64> {
    let most = match channel {
        Channel::ReturnFlow => FLOW_M3_S,
        Channel::PumpSpeed => SPEED_PCT,
        other if is_pressure(other) => PRESSURE_PA,
        // Strokes are counted, and boosters are set.
        _ => return None,
    };
    // A speed is ramped: of it those movements alone count that begin and end at rest.
    let alone = channel == Channel::PumpSpeed;
    let mut last = f64::NAN;
    let (mut two_ago, mut before) = (f64::NAN, f64::NAN);
    let (mut rests, mut moves) = (0, Vec::new());
    for (value, flows) in values.iter().zip(flowing).filter(|(v, _)| v.is_finite()) {
        let step = (value - last).abs();
        last = *value;
        if *flows && step == 0.0 {
            rests += 1;
            moves.extend((alone && two_ago == 0.0 && before > 0.0).then_some(before));
        } else if *flows && step > 0.0 && !alone {
            moves.push(step);
        }
        (two_ago, before) = (before, step);
    }
    let seldom = moves.len() >= FEWEST && rests as f64 > RESTS * (rests + moves.len()) as f64;
    let is_set =
        channel == Channel::PumpSpeed && rests as f64 * step_s > SET_S * moves.len() as f64;
    let least = (seldom && !is_set).then(|| quantile(moves.into_iter(), 0.1))?;
    (least >= most).then_some(least)
}
