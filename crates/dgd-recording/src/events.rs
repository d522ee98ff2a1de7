//! Channels of which a historian filed a reading when it had changed, and none in between.

use crate::{Channel, Recording};
use rayon::prelude::*;
use std::ops::Range;

/// A channel that has a reading at fewer of the samples that hold any is filed by events, if it comes unevenly.
const FEW: f64 = 0.5;
/// An archive keeps of each channel what that one does. Where none has this many times the readings of another, they are lost, not filed.
const ALIKE: usize = 2;
/// Fewest readings that tell how they come.
const FEWEST: usize = 20;
/// Where no channel has a reading for so long, s, nothing was recorded. Set by hand.
const SILENT_S: f64 = 600.0;
/// Longest straight line between two readings, s: beyond it a transmitter may have failed. Set by hand.
const LONGEST_LINE_S: f64 = 3600.0;
/// What is set, and has not been filed anew for so long, s, stood until it was; at most for as long as archives wait. Set by hand.
const STOOD_S: f64 = 60.0;
const LONGEST_STOOD_S: f64 = 8.0 * 3600.0;

/// What [`Recording::join_events`] has joined.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Events {
    /// Channels with values between their readings now.
    pub channels: usize,
    /// Share of the samples at which the channel with fewest readings had one, and that with most.
    pub shares: (f64, f64),
}

/// What is filed by events.
struct Filed {
    /// Channels that lack readings, each with how many it has.
    channels: Vec<(Channel, usize)>,
    /// Samples at which one of them has a reading.
    any: Vec<usize>,
}

impl Recording {
    /// Draws what lies between readings, if most channels have theirs by events: at times of their own, unevenly.
    ///
    /// Pressures and the return flow, which are measured, get straight lines of at most an hour; so do inflows and the pump's speed, which are set, for a
    /// minute, and beyond that their last reading, for at most 8 h. Nothing is drawn where no channel has a reading for ten minutes. Rows that come unevenly
    /// with a reading of each channel are no events, nor are channels that all have as many.
    ///
    /// - `step_s`: step of the even clock on which the recording lies, s.
    ///
    /// ```
    /// # use dgd_recording::Recording;
    /// let mut nothing = Recording::default();
    /// assert_eq!(nothing.join_events(1.0), None);
    /// ```
    pub fn join_events(&mut self, step_s: f64) -> Option<Events> {
        let samples = self.len();
        let filed = self.filed_by_events()?;
        let silent = silent(&filed.any, step_s);
        let shares = filed
            .channels
            .iter()
            .map(|(_, read)| *read as f64 / samples as f64);
        let told = Events {
            channels: filed.channels.len(),
            shares: (
                shares.clone().fold(1.0, f64::min),
                shares.fold(0.0, f64::max),
            ),
        };
        for (channel, _) in filed.channels {
            if let Some(values) = self.channel_mut(channel) {
                join(values, is_set(channel), &silent, step_s);
            }
        }
        Some(told)
    }

    /// What is filed by events; `None` if nothing is.
    fn filed_by_events(&self) -> Option<Filed> {
        let samples = self.len();
        let is_few = |read: usize, of: usize| (read as f64) < FEW * of as f64;
        // Without a branch, so that the compiler can vectorise it.
        let read = |values: &[f64]| values.iter().map(|v| usize::from(v.is_finite())).sum();
        // A constant in the description was not read.
        let is_constant = |values: &[f64]| values.windows(2).all(|pair| pair[0] == pair[1]);
        let (filed, whole): (Vec<_>, Vec<_>) = (self.series().into_par_iter())
            .map(|(channel, values)| (channel, values, read(values)))
            .filter(|(_, values, read)| *read < samples || !is_constant(values))
            .partition(|(_, _, read)| *read < samples);
        if !filed.iter().any(|(_, _, read)| is_few(*read, samples)) {
            return None;
        }
        let is_read = |i: &usize| filed.iter().any(|(_, values, _)| values[*i].is_finite());
        let any: Vec<usize> = (0..samples).filter(is_read).collect();
        // Of what was set a few times, nobody can tell how it comes.
        let told = || filed.iter().filter(|(_, _, read)| *read >= FEWEST);
        let by_events = told()
            .filter(|(_, values, read)| is_few(*read, any.len()) && comes_unevenly(values))
            .count();
        let reads = || filed.iter().map(|(_, _, read)| *read);
        let alike = reads().min()? * ALIKE > reads().max()?;
        if 2 * by_events <= told().count() + whole.len() || alike {
            return None;
        }
        let channels = filed.iter().map(|(channel, _, read)| (*channel, *read));
        Some(Filed {
            channels: channels.collect(),
            any,
        })
    }
}

/// Whether a channel is set rather than measured.
fn is_set(channel: Channel) -> bool {
    matches!(
        channel,
        Channel::MudPumpFlow | Channel::BoosterFlow | Channel::TopfillFlow | Channel::PumpSpeed
    )
}

/// Whether fewer than four in five readings come at the usual distance, give or take a half.
fn comes_unevenly(values: &[f64]) -> bool {
    let at = (0..values.len()).filter(|i| values[*i].is_finite());
    let at: Vec<usize> = at.collect();
    let mut apart: Vec<usize> = at.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if apart.is_empty() {
        return false;
    }
    let middle = apart.len() / 2;
    let usual = *apart.select_nth_unstable(middle).1;
    let even = apart
        .iter()
        .filter(|apart| 2 * apart.abs_diff(usual) <= usual);
    5 * even.count() < 4 * apart.len()
}

/// Stretches without any reading, by the samples that have one.
fn silent(any: &[usize], step_s: f64) -> Vec<Range<usize>> {
    let long = any
        .windows(2)
        .filter(|pair| (pair[1] - pair[0]) as f64 * step_s > SILENT_S);
    long.map(|pair| pair[0]..pair[1]).collect()
}

/// Draws between the readings of a channel.
fn join(values: &mut [f64], is_set: bool, silent: &[Range<usize>], step_s: f64) {
    let (longest_s, stood_s) = match is_set {
        true => (LONGEST_STOOD_S, STOOD_S),
        false => (LONGEST_LINE_S, f64::INFINITY),
    };
    let mut last: Option<usize> = None;
    let mut gaps = silent.iter().peekable();
    for i in 0..values.len() {
        if !values[i].is_finite() {
            continue;
        }
        let Some(from) = last.replace(i) else {
            continue;
        };
        while gaps.next_if(|gap| gap.end <= from).is_some() {}
        let apart_s = (i - from) as f64 * step_s;
        if apart_s > longest_s || gaps.peek().is_some_and(|gap| gap.start < i) {
            continue;
        }
        let (begin, rise) = (values[from], (values[i] - values[from]) / (i - from) as f64);
        for (k, value) in values[from..i].iter_mut().enumerate().skip(1) {
            *value = if apart_s > stood_s {
                begin
            } else {
                begin + rise * k as f64
            };
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::Events;
    use crate::Recording;

    /// A recording in which channel `k` has a reading at sample `i` if `filed(k, i)`: the number of the sample.
    fn filed(samples: usize, filed: impl Fn(usize, usize) -> bool) -> Recording {
        let channel = |k: usize| -> Vec<f64> {
            let value = |i: usize| if filed(k, i) { i as f64 } else { f64::NAN };
            (0..samples).map(value).collect()
        };
        Recording {
            time_s: (0..samples).map(|i| i as f64).collect(),
            mud_pump_flow_m3_s: channel(0),
            booster_flow_m3_s: channel(1),
            topfill_flow_m3_s: vec![0.0; samples],
            return_flow_m3_s: channel(2),
            pump_inlet_pressure_pa: vec![channel(3)],
            pump_outlet_pressure_pa: vec![channel(4)],
            riser_pressure_pa: None,
            pump_speed_pct: channel(5),
        }
    }

    /// Whether a channel has an event there, at random (Vigna's splitmix64): odd ones three times as many.
    fn event(k: usize, i: usize) -> bool {
        let mut x = (i as u64 + 1_000_000 * k as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (x ^ (x >> 31)) % 64 < 4 + 8 * (k as u64 % 2)
    }

    #[test]
    fn readings_by_events_are_joined_with_what_is_measured_on_lines_and_what_is_set_as_it_stood() {
        let mut recording = filed(8000, |k, i| match (k, i) {
            (0 | 3, 2001..2200) => false,
            (0 | 3, 2000 | 2200) => true,
            _ => event(k, i),
        });
        let joined = recording.join_events(1.0).unwrap();
        assert_eq!(joined.channels, 6);
        assert!(
            joined.shares.0 > 0.02 && joined.shares.1 < 0.2,
            "{joined:?}"
        );
        // The values are those of the clock, so a straight line is it again.
        let inlet = &recording.pump_inlet_pressure_pa[0];
        let between = inlet.iter().enumerate().skip(100).take(7800);
        for (i, v) in between {
            assert!((v - i as f64).abs() < 1e-6, "{i}: {v}");
        }
        let mud = &recording.mud_pump_flow_m3_s;
        assert!(mud[2001..2200].iter().all(|v| *v == 2000.0));
        assert!(
            mud[2200..2300]
                .iter()
                .enumerate()
                .all(|(k, v)| (v - (2200 + k) as f64).abs() < 1e-6)
        );
    }

    #[test]
    fn nothing_is_drawn_where_nothing_was_recorded_or_for_too_long() {
        let mut recording = filed(20_000, |k, i| match i {
            5000..5700 => false,
            // The inlet fails for two hours, and two minutes.
            9000..16_500 if k == 3 => false,
            _ => event(k, i),
        });
        recording.join_events(1.0).unwrap();
        assert!(
            recording.mud_pump_flow_m3_s[5100..5600]
                .iter()
                .all(|v| v.is_nan())
        );
        assert!(
            recording.pump_inlet_pressure_pa[0][9100..16_400]
                .iter()
                .all(|v| v.is_nan())
        );
        assert!(
            recording.pump_outlet_pressure_pa[0][9100..16_400]
                .iter()
                .all(|v| v.is_finite())
        );
    }

    #[test]
    fn slow_channels_uneven_rows_and_whole_recordings_are_left_as_they_are() {
        for (what, mut recording) in [
            ("whole", filed(2000, |_, _| true)),
            (
                "every ten and one",
                filed(2000, |k, i| k < 3 || i % 10 == k),
            ),
            ("each every ten", filed(2000, |k, i| i % 10 == k)),
            ("uneven rows", filed(2000, |_, i| event(0, i))),
            // Each at random at a tenth of the samples, as in a storm of missing values.
            ("storm", filed(4000, |k, i| event(2 * k, i))),
            ("a few by events", filed(2000, |k, i| k > 2 || event(k, i))),
        ] {
            let before = recording.clone();
            assert_eq!(recording.join_events(1.0), None::<Events>, "{what}");
            let same = |(a, b): (&f64, &f64)| a.to_bits() == b.to_bits();
            for ((_, a), (_, b)) in before.series().into_iter().zip(recording.series()) {
                assert!(a.iter().zip(b).all(same), "{what}");
            }
        }
    }
}
