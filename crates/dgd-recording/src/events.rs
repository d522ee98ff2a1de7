//! Channels of which a historian filed a reading when it had changed, and none in between.

use crate::few::{FEWEST_CHANNELS, REPEATS, are_few, count};
use crate::{Channel, Recording, draw_line};
use rayon::prelude::*;
use std::ops::Range;

/// An archive keeps of each channel what that one does. Where none has this many times the readings of another, they are lost, not filed.
const ALIKE: usize = 2;
/// Fewest readings that tell how they come.
const FEWEST: usize = 20;
/// Where no channel has a reading for so long, s, nothing was recorded; the latter where all changes are filed. Set by hand.
const SILENT_S: f64 = 600.0;
const SILENT_OF_CHANGES_S: f64 = 60.0;
/// Longest straight line between two readings, s: beyond it a transmitter may have failed. Set by hand.
const LONGEST_LINE_S: f64 = 3600.0;
/// What is set, and has not been filed anew for so long, s, stood until it was; at most for as long as archives wait. Set by hand.
const STOOD_S: f64 = 60.0;
const LONGEST_STOOD_S: f64 = 8.0 * 3600.0;
/// So many readings to a value make it likely that some would repeat. Set by hand.
const COARSE: usize = 4;

/// What [`Recording::join_events`] has joined.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Events {
    /// Channels with values between their readings now.
    pub channels: usize,
    /// Share of the samples at which the channel with fewest readings had one, and that with most.
    pub shares: (f64, f64),
    /// Whether a reading was filed whenever there was another one: then nothing was left out, and what was filed stands until the next.
    pub of_all_changes: bool,
}

/// What is filed by events.
struct Filed {
    of_all_changes: bool,
    /// Channels that lack readings, each with how many it has.
    channels: Vec<(Channel, usize)>,
    /// Samples at which one of them has a reading.
    any: Vec<usize>,
}

impl Recording {
    /// Draws what lies between readings of channels that were filed by events, at times of their own.
    ///
    /// Where most channels come so, unevenly, with few readings, an archive left some out: pressures and the return flow, which are measured, get straight
    /// lines of at most an hour; so do inflows and the pump's speed, which are set, for a minute, and beyond that their last reading, for at most 8 h.
    /// Nothing is drawn where no channel has a reading for ten minutes. Rows that come unevenly with a reading of each channel are no events, nor are
    /// channels that all have as many.
    ///
    /// Where few readings of a channel that is set stand beside many of another, hardly one is equal to that a sample before though the values are few, and
    /// none come at even steps, each was filed whenever it changed: it stands until the next or the end, for as long as above, but where no channel has
    /// a reading for a minute.
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
        let of_all_changes = filed.of_all_changes;
        let silent_s = if of_all_changes {
            SILENT_OF_CHANGES_S
        } else {
            SILENT_S
        };
        let mut silent = silent(&filed.any, step_s, silent_s);
        let last = filed.any.last().copied().unwrap_or(0);
        if (samples - last) as f64 * step_s > silent_s {
            silent.push(last..samples);
        }
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
            of_all_changes,
        };
        for (channel, _) in filed.channels {
            if let Some(values) = self.channel_mut(channel) {
                let lines = Lines::of(channel, of_all_changes);
                lines.join(values, &silent, step_s);
            }
        }
        Some(told)
    }

    /// What is filed by events; `None` if nothing is.
    fn filed_by_events(&self) -> Option<Filed> {
        if !self.has_few_readings() {
            return None;
        }
        let samples = self.len();
        // A constant in the description was not read.
        let is_constant = |values: &[f64]| values.windows(2).all(|pair| pair[0] == pair[1]);
        let (filed, whole): (Vec<_>, Vec<_>) = (self.series().into_par_iter())
            .map(Read::of)
            .filter(|read| read.count < samples || !is_constant(read.values))
            .partition(|read| read.count < samples);
        let is_read = |i: &usize| filed.iter().any(|read| read.values[*i].is_finite());
        let any: Vec<usize> = (0..samples).filter(is_read).collect();
        // Of what was set a few times, nobody can tell how it comes.
        let told: Vec<&Read<'_>> = filed.iter().filter(|read| read.count >= FEWEST).collect();
        let uneven = |read: &&&Read<'_>| {
            are_few(read.count, any.len()) && !read.rhythm().is_some_and(|rhythm| rhythm.even)
        };
        let mostly = 2 * told.iter().filter(uneven).count() > told.len() + whole.len();
        let counts = || filed.iter().map(|read| read.count);
        let (least, most) = counts().min().zip(counts().max())?;
        let by_events = mostly && least * ALIKE <= most;
        let recorded = if whole.is_empty() { any.len() } else { samples };
        let of_all_changes =
            !by_events && is_few_set(&filed, most, recorded) && are_all_changes(&told);
        if !by_events && !of_all_changes {
            return None;
        }
        let channels = filed.iter().map(|read| (read.channel, read.count));
        Some(Filed {
            of_all_changes,
            channels: channels.collect(),
            any,
        })
    }
}

/// Whether a channel that is set has few readings beside the busiest of those that lack some, which has one at more than half of the `recorded` samples.
fn is_few_set(filed: &[Read<'_>], most: usize, recorded: usize) -> bool {
    let few = |read: &Read<'_>| read.channel.is_set() && read.count * ALIKE <= most;
    !are_few(most, recorded) && filed.iter().any(few)
}

/// Whether no channel is polled, and in enough of those that would repeat, as their values are few, hardly a reading is equal to that a sample before.
fn are_all_changes(told: &[&Read<'_>]) -> bool {
    let coarse: Vec<&&Read<'_>> = told.iter().filter(|read| read.is_coarse()).collect();
    let repeats: usize = coarse.iter().map(|read| read.repeats()).sum();
    let readings: usize = coarse.iter().map(|read| read.count).sum();
    let polled = |read: &&Read<'_>| read.rhythm().is_some_and(|rhythm| rhythm.is_polled());
    coarse.len() >= FEWEST_CHANNELS && repeats * REPEATS < readings && !told.iter().any(polled)
}

/// A channel and its readings.
struct Read<'a> {
    channel: Channel,
    values: &'a [f64],
    /// How many are there.
    count: usize,
}

impl<'a> Read<'a> {
    fn of((channel, values): (Channel, &'a [f64])) -> Self {
        Self {
            channel,
            values,
            count: count(values),
        }
    }

    /// Readings that are equal to that a sample before.
    fn repeats(&self) -> usize {
        let pairs = self.values.windows(2);
        pairs.filter(|pair| pair[0] == pair[1]).count()
    }

    /// Whether its values are few beside its readings: it would repeat some of them.
    fn is_coarse(&self) -> bool {
        let finite = self.values.iter().filter(|v| v.is_finite());
        let mut values: Vec<u64> = finite.map(|v| v.to_bits()).collect();
        values.sort_unstable();
        values.dedup();
        COARSE * values.len() < self.count
    }

    /// How they come; `None` of fewer than two.
    fn rhythm(&self) -> Option<Rhythm> {
        let at = (0..self.values.len()).filter(|i| self.values[*i].is_finite());
        let at: Vec<usize> = at.collect();
        let mut apart: Vec<usize> = at.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let middle = apart.len() / 2;
        if apart.is_empty() {
            return None;
        }
        let usual = *apart.select_nth_unstable(middle).1;
        let even = apart
            .iter()
            .filter(|apart| 2 * apart.abs_diff(usual) <= usual);
        let even = 5 * even.count() >= 4 * apart.len();
        Some(Rhythm { usual, even })
    }
}

/// How the readings of a channel come.
struct Rhythm {
    /// Usual distance from one to the next, samples.
    usual: usize,
    /// Whether four in five come at it, give or take a half.
    even: bool,
}

impl Rhythm {
    /// Whether it is read now and then, at even times.
    fn is_polled(&self) -> bool {
        self.even && self.usual > 1
    }
}

/// Stretches without any reading for more than so many seconds, by the samples that have one.
fn silent(any: &[usize], step_s: f64, silent_s: f64) -> Vec<Range<usize>> {
    let long = any
        .windows(2)
        .filter(|pair| (pair[1] - pair[0]) as f64 * step_s > silent_s);
    long.map(|pair| pair[0]..pair[1]).collect()
}

/// What lies between two readings of a channel.
struct Lines {
    /// Nothing if they are farther apart, s.
    longest_s: f64,
    /// A straight line, or the former of them if they are farther apart, s.
    stood_s: f64,
    /// Whether the last stands as well.
    last_stands: bool,
}

impl Lines {
    fn of(channel: Channel, of_all_changes: bool) -> Self {
        let (longest_s, stood_s) = match channel.is_set() {
            true => (LONGEST_STOOD_S, STOOD_S),
            false => (LONGEST_LINE_S, f64::INFINITY),
        };
        Self {
            longest_s,
            stood_s: if of_all_changes { 0.0 } else { stood_s },
            last_stands: of_all_changes,
        }
    }

    /// Draws between the readings of a channel.
    fn join(&self, values: &mut [f64], silent: &[Range<usize>], step_s: f64) {
        let read = (0..values.len()).filter(|i| values[*i].is_finite());
        let end = self.last_stands.then_some(values.len());
        let at: Vec<usize> = read.chain(end).collect();
        let mut gaps = silent.iter().peekable();
        for pair in at.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            while gaps.next_if(|gap| gap.end <= from).is_some() {}
            let apart_s = (to - from) as f64 * step_s;
            if apart_s > self.longest_s {
                continue;
            }
            let begin = values[from];
            if let Some(gap) = gaps.peek().filter(|gap| gap.start < to) {
                // What stands does so for as long as anything is recorded.
                if self.last_stands {
                    values[from..=gap.start].fill(begin);
                }
                continue;
            }
            if apart_s > self.stood_s {
                values[from + 1..to].fill(begin);
                continue;
            }
            let end = values[to];
            draw_line(&mut values[from + 1..to], begin, end);
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
    fn where_all_changes_are_filed_each_stands_until_the_next_and_at_the_end() {
        // Pressures change at nine samples of ten, the mud pump now and then; the booster was set once.
        let mut recording = filed(8000, |k, i| match k {
            0 => i == 0 || event(0, i),
            1 => i == 0,
            _ => event(k, i) || (i + k) % 10 > 0,
        });
        // Their values are few.
        let channels: Vec<_> = recording.series().iter().map(|(c, _)| *c).collect();
        for channel in channels {
            let values = recording.channel_mut(channel).unwrap();
            values.iter_mut().for_each(|v| *v = v.rem_euclid(101.0));
        }
        let all = recording.clone();
        let joined = recording.join_events(1.0).unwrap();
        assert!(joined.of_all_changes);
        assert_eq!(joined.channels, 6);
        let stands = |values: &[f64], read: &[f64]| {
            let mut last = f64::NAN;
            values.iter().zip(read).all(|(value, read)| {
                last = if read.is_finite() { *read } else { last };
                last.is_nan() || *value == last
            })
        };
        assert!(recording.booster_flow_m3_s.iter().all(|v| *v == 0.0));
        for (joined, read) in [
            (&recording.mud_pump_flow_m3_s, &all.mud_pump_flow_m3_s),
            (
                &recording.pump_inlet_pressure_pa[0],
                &all.pump_inlet_pressure_pa[0],
            ),
        ] {
            assert!(stands(joined, read));
        }
        let change = |change: &dyn Fn(&mut Recording)| {
            let mut changed = all.clone();
            change(&mut changed);
            changed
        };
        // Readings that are equal to those before were not filed for a change, nor are those of a channel that is polled.
        let repeated = change(&|r| {
            let inlet = &mut r.pump_inlet_pressure_pa[0];
            inlet.iter_mut().for_each(|v| *v = (*v / 4.0).floor());
        });
        let polled = change(&|r| {
            let outlet = r.pump_outlet_pressure_pa[0].iter_mut().enumerate();
            outlet.for_each(|(i, v)| *v = if i % 5 == 0 { i as f64 } else { f64::NAN });
        });
        let none_is_set = change(&|r| {
            r.mud_pump_flow_m3_s = r.return_flow_m3_s.clone();
            r.booster_flow_m3_s.fill(0.0);
        });
        // Where no value comes twice, nothing tells that it would have been filed again.
        let fine = change(&|r| {
            let pressures = [
                &mut r.pump_inlet_pressure_pa[0],
                &mut r.pump_outlet_pressure_pa[0],
            ];
            let rest = [&mut r.return_flow_m3_s, &mut r.pump_speed_pct];
            for values in pressures.into_iter().chain(rest) {
                values
                    .iter_mut()
                    .enumerate()
                    .for_each(|(i, v)| *v += i as f64);
            }
        });
        for mut other in [repeated, polled, none_is_set, fine] {
            assert_eq!(other.join_events(1.0), None);
        }
        // Nothing was recorded for over a minute, nor for the last two.
        let mut silent = change(&|r| {
            let pressures = [
                &mut r.pump_inlet_pressure_pa[0],
                &mut r.pump_outlet_pressure_pa[0],
            ];
            let rest = [
                &mut r.mud_pump_flow_m3_s,
                &mut r.return_flow_m3_s,
                &mut r.pump_speed_pct,
            ];
            pressures
                .into_iter()
                .chain(rest)
                .for_each(|v| v[4000..4070].fill(f64::NAN));
        });
        silent.join_events(1.0).unwrap();
        assert!(
            silent.pump_inlet_pressure_pa[0][4000..4070]
                .iter()
                .all(|v| v.is_nan())
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
