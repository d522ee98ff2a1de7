//! Channels of which a historian keeps too little: a deadband, few digits, or a value every half minute.

use super::facts::{quantile, source_of};
use super::{Suspicion, WellLine, words};
use crate::channel::is_pressure;
use crate::{ScreenError, error};
use dgd_recording::{Channel, ChannelSource, Recording, STANDING_M3_S, Well, held_for};

/// Share of the samples of flowing mud at which a meter must rest to be coarse.
const RESTS: f64 = 0.5;
/// Fewest movements that tell their size.
const FEWEST: usize = 20;
/// Least movement of a pressure that is too coarse, Pa, and of the return flow, m³/s: set by hand.
const PRESSURE_PA: f64 = 1.5e4;
const FLOW_M3_S: f64 = 1e-3;
/// Time between two readings that is too long for causes of seconds to minutes, s: set by hand.
pub const TOO_SELDOM_S: f64 = 10.0;

/// Channels in which causes are made up by what a historian leaves out: pressures and the return flow that rest while mud flows and then move
/// by much, and any flow or pressure whose readings are held for [`TOO_SELDOM_S`] or more.
///
/// - `recording`: as read, before any screening, on an even clock; any length.
/// - `step_s`: step of that clock, s.
///
/// ```
/// # use dgd_recording::{Recording, Well};
/// # fn told(recording: &Recording, well: &Well) -> Result<(), dgd_screen::ScreenError> {
/// for suspicion in dgd_screen::coarse(recording, 1.0, well)? {
///     eprintln!("{suspicion}");
/// }
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// [`ScreenError::Step`], [`ScreenError::Unequal`], [`ScreenError::Uneven`], as [`crate::suspect`].
pub fn coarse(
    recording: &Recording,
    step_s: f64,
    well: &Well,
) -> Result<Vec<Suspicion>, ScreenError> {
    error::check(recording, step_s)?;
    let flowing: Vec<bool> = (recording.return_flow_m3_s.iter())
        .map(|q| *q > STANDING_M3_S)
        .collect();
    let told = |(channel, values): (Channel, &[f64])| {
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
        let how = if is_slow && !set && channel != Channel::PumpSpeed {
            format!(
                "gives a reading every {} s and holds it in between",
                words::number(held_s)
            )
        } else {
            let step = movement(channel, values, &flowing)?;
            format!(
                "is constant at most samples while mud flows and then moves by {} {unit} or more, as with a deadband or few digits",
                words::number(step / unit.factor)
            )
        };
        Some(Suspicion {
            place: WellLine::of(channel),
            message: format!(
                "{channel} `{tag}` {how}: this can produce false causes; confirm any finding on an export with all readings"
            ),
        })
    };
    Ok(recording.series().into_iter().filter_map(told).collect())
}

/// The least movement of a meter that rests while mud flows, but for the rarest tenth, where it is too much.
fn movement(channel: Channel, values: &[f64], flowing: &[bool]) -> Option<f64> {
    let most = match channel {
        Channel::ReturnFlow => FLOW_M3_S,
        other if is_pressure(other) => PRESSURE_PA,
        // Strokes are counted, and a set-point is set.
        _ => return None,
    };
    let mut last = f64::NAN;
    let (mut rests, mut moves) = (0, Vec::new());
    for (value, flows) in values.iter().zip(flowing).filter(|(v, _)| v.is_finite()) {
        let step = (value - last).abs();
        last = *value;
        if *flows && step > 0.0 {
            moves.push(step);
        } else if *flows && step == 0.0 {
            rests += 1;
        }
    }
    let seldom = moves.len() >= FEWEST && rests as f64 > RESTS * (rests + moves.len()) as f64;
    let least = seldom.then(|| quantile(moves.into_iter(), 0.1))?;
    (least >= most).then_some(least)
}
