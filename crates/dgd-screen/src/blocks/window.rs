//! The samples that are at hand, with what is wrong with them.

use super::ScreenedBlock;
use super::series::Known;
use crate::scan::scan;
use crate::screening::{Rules, mark, mark_runs};
use crate::speed::Readings;
use crate::spike::{self, LONGEST, LONGEST_DROPOUT};
use crate::{Faults, ScreenOptions};
use dgd_recording::{Channel, Recording, Run};
use rayon::prelude::*;
use std::ops::Range;

/// Samples that a jump is judged by on either side: the longest dropout, its way out and its neighbours.
pub(super) const LOOKED_BACK_AT: usize = 2 * (LONGEST_DROPOUT + spike::LOOKED_AT + 2);

/// Consecutive samples of all channels.
#[derive(Debug, Default)]
pub(super) struct Window {
    /// Index of the first sample in the recording.
    start: usize,
    time_s: Vec<f64>,
    series: Vec<Series>,
    /// Jumps before this sample have been looked at.
    searched: usize,
    /// Mean of the outlet transmitters, as far as it is settled.
    outlet_pa: Vec<f64>,
}

#[derive(Debug, Default)]
struct Series {
    values: Vec<f64>,
    /// Missing and impossible values.
    scanned: Vec<Faults>,
    /// These, spikes and stuck runs.
    faults: Vec<Faults>,
    /// These and disagreement.
    settled: Vec<Faults>,
    jumps: Vec<usize>,
    spike_end: usize,
}

impl Window {
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    pub(super) fn push(&mut self, block: &Recording, known: &[Known], rules: Rules<'_>) {
        let all = block.series();
        self.series.resize_with(all.len(), Series::default);
        let start = self.start;
        let both = self.series.par_iter_mut().zip(all).zip(known);
        both.for_each(|((series, (_, values)), known)| series.push(start, values, known, rules));
        self.time_s.extend_from_slice(&block.time_s);
    }

    fn end(&self) -> usize {
        self.start + self.time_s.len()
    }

    /// Looks at jumps that enough has come behind; says up to which sample no spike is left to be found.
    pub(super) fn mark_spikes(
        &mut self,
        all: &[Known],
        options: &ScreenOptions,
        step_s: f64,
        at_end: bool,
    ) -> usize {
        let rules = Rules { step_s, options };
        let end = self.end();
        let to = if at_end {
            end
        } else {
            end.saturating_sub(LOOKED_BACK_AT).max(self.searched)
        };
        let start = self.start;
        let spikes: Vec<Vec<Range<usize>>> = (all.par_iter().enumerate())
            .map(|(n, known)| {
                let series = &self.series[n];
                let ready = series.jumps.iter().filter(|at| **at < to);
                let jumps: Vec<usize> = ready
                    .filter(|at| **at >= series.spike_end)
                    .map(|at| at - start)
                    .collect();
                let (values, faults) = (&series.values, &series.scanned);
                let twins = self.twins(all, n);
                let rule = rules.spike(known.channel);
                let found = spike::find(values, faults, &jumps, known.steps, rule, &twins);
                found.into_iter().map(|spike| spike.range).collect()
            })
            .collect();
        for (series, spikes) in self.series.iter_mut().zip(spikes) {
            series.jumps.retain(|at| *at >= to);
            for range in spikes {
                series.spike_end = start + range.end;
                mark(&mut series.faults, range, Faults::SPIKE);
            }
        }
        self.searched = to;
        // A later jump may be the way out of a spike that began at a gap.
        if at_end {
            end
        } else {
            to.saturating_sub(LONGEST)
        }
    }

    /// The other transmitters of the same pump side.
    fn twins(&self, known: &[Known], n: usize) -> Vec<&[f64]> {
        let kind = |known: &Known| std::mem::discriminant(&known.channel);
        let others = known.iter().zip(&self.series).enumerate();
        others
            .filter(|(m, (other, _))| *m != n && kind(other) == kind(&known[n]))
            .map(|(_, (_, series))| series.values.as_slice())
            .collect()
    }

    /// Index of the first sample, and values and faults of transmitters, without disagreement.
    pub(super) fn of(&self, members: &[usize]) -> (usize, Vec<&[f64]>, Vec<&[Faults]>) {
        let series = members.iter().map(|n| &self.series[*n]);
        (
            self.start,
            series.clone().map(|s| s.values.as_slice()).collect(),
            series.map(|s| s.faults.as_slice()).collect(),
        )
    }

    /// The sample up to which the faults are settled.
    pub(super) fn settled(&self) -> usize {
        self.start + self.series.first().map_or(0, |s| s.settled.len())
    }

    /// Settles the faults up to a sample; `marks` are the stretches in which transmitters disagree.
    pub(super) fn settle(&mut self, to: usize, marks: impl Iterator<Item = (usize, Range<usize>)>) {
        let (start, from) = (self.start, self.settled());
        for series in &mut self.series {
            let new = from - start..to - start;
            series.settled.extend_from_slice(&series.faults[new]);
        }
        for (n, range) in marks {
            let inside = range.start.max(from)..range.end.min(to);
            if !inside.is_empty() {
                let inside = inside.start - start..inside.end - start;
                mark(&mut self.series[n].settled, inside, Faults::DISAGREES);
            }
        }
    }

    /// Settled samples of transmitters: values and faults.
    pub(super) fn stretch(
        &self,
        members: &[usize],
        range: &Range<usize>,
    ) -> (Vec<&[f64]>, Vec<&[Faults]>) {
        let range = range.start - self.start..range.end - self.start;
        let series = members.iter().map(|n| &self.series[*n]);
        (
            series.clone().map(|s| &s.values[range.clone()]).collect(),
            series.map(|s| &s.settled[range.clone()]).collect(),
        )
    }

    pub(super) fn add_outlet(&mut self, outlet_pa: &[f64]) {
        self.outlet_pa.extend_from_slice(outlet_pa);
    }

    /// Index of the first sample; the pump's speed, its faults and the outlet pressure of the settled samples.
    pub(super) fn speed(&self) -> Option<(usize, Readings<'_>, &[f64])> {
        let speed = self.series.last()?;
        let settled = speed.settled.len();
        let readings = Readings {
            speed_pct: &speed.values[..settled],
            faults: &speed.settled,
        };
        Some((self.start, readings, &self.outlet_pa))
    }

    /// Settled samples, with those in frozen runs of the speed marked.
    pub(super) fn part(
        &self,
        range: Range<usize>,
        channels: &[Channel],
        frozen: &[Run],
    ) -> ScreenedBlock {
        let here = range.start - self.start..range.end - self.start;
        let mut recording = Recording {
            time_s: self.time_s[here.clone()].to_vec(),
            ..Recording::default()
        };
        let mut faults = Vec::with_capacity(channels.len());
        for (channel, series) in channels.iter().zip(&self.series) {
            let values = series.values[here.clone()].to_vec();
            match channel {
                Channel::MudPumpFlow => recording.mud_pump_flow_m3_s = values,
                Channel::BoosterFlow => recording.booster_flow_m3_s = values,
                Channel::TopfillFlow => recording.topfill_flow_m3_s = values,
                Channel::ReturnFlow => recording.return_flow_m3_s = values,
                Channel::PumpInletPressure(_) => recording.pump_inlet_pressure_pa.push(values),
                Channel::PumpOutletPressure(_) => recording.pump_outlet_pressure_pa.push(values),
                Channel::RiserPressure => recording.riser_pressure_pa = Some(values),
                Channel::PumpSpeed => recording.pump_speed_pct = values,
            }
            let mut found = series.settled[here.clone()].to_vec();
            if *channel == Channel::PumpSpeed {
                mark_runs(&mut found, range.start, frozen, [Faults::STUCK; 2]);
            }
            faults.push((*channel, found));
        }
        ScreenedBlock {
            recording,
            faults,
            ..ScreenedBlock::default()
        }
    }

    /// Forgets what lies before a sample.
    pub(super) fn keep_from(&mut self, sample: usize) {
        let gone = sample.saturating_sub(self.start);
        if gone == 0 {
            return;
        }
        self.start += gone;
        self.time_s.drain(..gone);
        self.outlet_pa.drain(..gone.min(self.outlet_pa.len()));
        for series in &mut self.series {
            series.values.drain(..gone);
            series.scanned.drain(..gone);
            series.faults.drain(..gone);
            series.settled.drain(..gone.min(series.settled.len()));
        }
    }
}

impl Series {
    fn push(&mut self, start: usize, values: &[f64], known: &Known, rules: Rules<'_>) {
        let old = self.values.len();
        self.values.extend_from_slice(values);
        self.scanned.resize(self.values.len(), Faults::NONE);
        // The last sample before is looked at again, for the jump from it.
        let from = old.saturating_sub(1);
        let least = spike::least(known.steps, rules.spike(known.channel));
        let limits = rules.limits(known.channel);
        let found = scan(
            &self.values[from..],
            limits,
            least,
            &mut self.scanned[from..],
        );
        self.jumps
            .extend(found.jumps.iter().map(|at| start + from + at));
        self.faults.extend_from_slice(&self.scanned[old..]);
        let faults = Rules::faults_of_runs(known.channel);
        mark_runs(&mut self.faults[old..], start + old, &known.runs, faults);
    }
}
