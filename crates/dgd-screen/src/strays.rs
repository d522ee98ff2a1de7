//! Single readings far off those before and after, in recordings whose channels are read apart.

use crate::screening::{Rules, twins};
use crate::{Faults, ScreenError, ScreenOptions, error, scan, spike};
use dgd_recording::{Channel, Recording, draw_line};
use rayon::prelude::*;

/// Longest time from the reading before to that after, s: what lasts may be real. Set by hand.
const LONGEST_S: f64 = 15.0;

/// Removes readings of pressures and the return flow that neither the one before nor the one after, no more than 15 s apart, confirms: so that no lines are
/// drawn from them. Of channels that are [read apart](Recording::read_apart). Gives how many of each channel went.
///
/// [`screen`](crate::screen) finds spikes among samples that follow each other, of which such channels have hardly any. The rule is the same, from
/// reading to reading; a twin that shows it too, as its own readings go on, confirms it.
///
/// - `step_s`: step of the even clock on which the recording lies, s.
///
/// # Errors
/// Those of [`screen`](crate::screen).
///
/// ```
/// # use dgd_screen::{Recording, ScreenOptions, blank_strays};
/// let taken = blank_strays(&mut Recording::default(), 1.0, &ScreenOptions::default())?;
/// assert!(taken.is_empty());
/// # Ok::<(), dgd_screen::ScreenError>(())
/// ```
pub fn blank_strays(
    recording: &mut Recording,
    step_s: f64,
    options: &ScreenOptions,
) -> Result<Vec<(Channel, usize)>, ScreenError> {
    error::check(recording, step_s)?;
    let rules = Rules::new(step_s, options)?;
    let found: Vec<(Channel, Vec<usize>)> = (recording.read_apart())
        .into_par_iter()
        // What is set may be set for one reading.
        .filter(|(channel, _)| !channel.is_set())
        .map(|(channel, values)| (channel, strays(recording, channel, values, rules)))
        .filter(|(_, strays)| !strays.is_empty())
        .collect();
    for (channel, strays) in &found {
        if let Some(values) = recording.channel_mut(*channel) {
            strays.iter().for_each(|i| values[*i] = f64::NAN);
        }
    }
    let counts = found
        .into_iter()
        .map(|(channel, strays)| (channel, strays.len()));
    Ok(counts.collect())
}

/// Samples of a channel at which a reading stands alone.
fn strays(recording: &Recording, channel: Channel, values: &[f64], rules: Rules<'_>) -> Vec<usize> {
    let at: Vec<usize> = (0..values.len())
        .filter(|i| values[*i].is_finite())
        .collect();
    let own: Vec<f64> = at.iter().map(|i| values[*i]).collect();
    let twins = twins(recording, channel);
    let twins: Vec<Vec<f64>> = twins.into_iter().map(|twin| along(twin, &at)).collect();
    let twins: Vec<&[f64]> = twins.iter().map(Vec::as_slice).collect();
    let rule = rules.spike_of_readings(channel);
    let steps = scan::steps(&own);
    let mut faults = vec![Faults::NONE; own.len()];
    let limits = rules.limits(channel);
    let scan = scan::scan(&own, limits, spike::least(steps, rule), &mut faults);
    let spikes = spike::find(&own, &faults, &scan.jumps, steps, rule, &twins);
    let near = |k: &usize| {
        let ends = at.get(k.wrapping_sub(1)).zip(at.get(k + 1));
        ends.is_some_and(|(before, after)| (after - before) as f64 * rules.step_s <= LONGEST_S)
    };
    let alone = spikes.into_iter().flat_map(|spike| spike.range);
    alone.filter(near).map(|k| at[k]).collect()
}

/// A series at samples at which it need not be read: on the line between its readings before and after, NaN beyond them.
fn along(values: &[f64], at: &[usize]) -> Vec<f64> {
    let mut lines = values.to_vec();
    let read: Vec<usize> = (0..values.len())
        .filter(|i| values[*i].is_finite())
        .collect();
    for pair in read.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        draw_line(&mut lines[from + 1..to], values[from], values[to]);
    }
    at.iter().map(|i| lines[*i]).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::blank_strays;
    use crate::{Channel, Recording, ScreenOptions};

    /// Both outlets read every five seconds, one three seconds behind the other; the rest at each second.
    fn read_apart() -> Recording {
        let samples = 3000_u32;
        let noisy = |level: f64, step: f64| -> Vec<f64> {
            let noise = |i: u32| level + step * f64::from(i * 37 % 11);
            (0..samples).map(noise).collect()
        };
        let every = |values: Vec<f64>, phase: usize| -> Vec<f64> {
            let read = |(i, v)| if i % 5 == phase { v } else { f64::NAN };
            values.into_iter().enumerate().map(read).collect()
        };
        Recording {
            time_s: (0..samples).map(f64::from).collect(),
            mud_pump_flow_m3_s: every(noisy(0.03, 1e-5), 1),
            booster_flow_m3_s: noisy(0.01, 1e-5),
            topfill_flow_m3_s: vec![0.0; samples as usize],
            return_flow_m3_s: noisy(0.042, 1e-5),
            pump_inlet_pressure_pa: vec![noisy(24e5, 500.0)],
            pump_outlet_pressure_pa: vec![
                every(noisy(40e5, 500.0), 0),
                every(noisy(40e5, 500.0), 3),
            ],
            riser_pressure_pa: None,
            pump_speed_pct: noisy(60.0, 0.1),
        }
    }

    #[test]
    fn a_reading_that_stands_alone_goes_and_one_that_the_twin_confirms_stays() {
        let mut recording = read_apart();
        let outlets = &mut recording.pump_outlet_pressure_pa;
        outlets[0][1000] = 30e5;
        // Both move.
        outlets[0][2000] = 30e5;
        outlets[1][1998] = 30e5;
        outlets[1][2003] = 30e5;
        let taken = blank_strays(&mut recording, 1.0, &ScreenOptions::default()).unwrap();
        assert_eq!(taken, [(Channel::PumpOutletPressure(0), 1)]);
        let outlets = &recording.pump_outlet_pressure_pa;
        assert!(outlets[0][1000].is_nan());
        assert_eq!(outlets[0][2000], 30e5);
    }

    #[test]
    fn a_long_gap_and_rows_now_and_then_are_no_channels_read_apart() {
        let spiked = || {
            let mut recording = read_apart();
            let outlets = &mut recording.pump_outlet_pressure_pa;
            recording.mud_pump_flow_m3_s = recording.booster_flow_m3_s.clone();
            *outlets = vec![recording.pump_inlet_pressure_pa[0].clone(); 2];
            outlets[0][300] = 30e5;
            recording
        };
        let lost: [fn(usize) -> bool; 2] = [|i| i > 900, |i| i % 3 > 0];
        for lost in lost {
            let mut recording = spiked();
            let channels: Vec<Channel> = recording.series().iter().map(|(c, _)| *c).collect();
            for channel in channels {
                let values = recording.channel_mut(channel).unwrap();
                (0..values.len())
                    .filter(|i| lost(*i))
                    .for_each(|i| values[i] = f64::NAN);
            }
            let taken = blank_strays(&mut recording, 1.0, &ScreenOptions::default()).unwrap();
            assert_eq!(taken, []);
            assert_eq!(recording.pump_outlet_pressure_pa[0][300], 30e5);
        }
    }

    #[test]
    fn what_stands_until_the_next_reading_and_what_is_read_at_each_sample_is_left() {
        let mut recording = read_apart();
        // The mud pump is set to another rate, which is read once, and both outlets fall for a minute, in which one is read once.
        recording.mud_pump_flow_m3_s[1061] = 0.0;
        recording.pump_outlet_pressure_pa[0][2000..2060].fill(f64::NAN);
        recording.pump_outlet_pressure_pa[0][2030] = 30e5;
        recording.return_flow_m3_s[1500] = 0.5;
        let taken = blank_strays(&mut recording, 1.0, &ScreenOptions::default()).unwrap();
        assert_eq!(taken, []);
        // One channel of seven is none of those that are read apart.
        recording = read_apart();
        recording.pump_outlet_pressure_pa[0][1000] = 30e5;
        recording.mud_pump_flow_m3_s = recording.booster_flow_m3_s.clone();
        recording.pump_outlet_pressure_pa.truncate(1);
        let taken = blank_strays(&mut recording, 1.0, &ScreenOptions::default()).unwrap();
        assert_eq!(taken, []);
    }
}
