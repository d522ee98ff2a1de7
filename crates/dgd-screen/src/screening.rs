//! The screening of a whole recording.

use crate::channel::is_pressure;
use crate::options::samples;
use crate::redundant::{self, DisagreeRule};
use crate::scan::Steps;
use crate::speed::{self, Readings};
use crate::spike::{self, SpikeRule};
use crate::stuck::{self, Beside, Rest, StuckRule};
use crate::{
    ChannelScreen, Faults, Limits, Reasons, ScreenError, ScreenOptions, Tally, reasons, scan,
};
use dgd_recording::{Channel, Recording, Run};
use rayon::prelude::*;
use std::ops::Range;

/// What may be used of a recording, and why the rest may not.
#[derive(Debug, Clone, PartialEq)]
pub struct Screening {
    /// Why each sample may not be used for identification; empty if it may. Shape `(n,)`.
    pub reasons: Vec<Reasons>,
    /// Every transmitter, in the order of [`Recording::series`].
    pub channels: Vec<ChannelScreen>,
    /// Mean of the inlet transmitters that may be trusted, Pa absolute; NaN where none
    /// may. Shape `(n,)`.
    ///
    /// Where one of two is left out, the other has half their slow difference (a running
    /// median over some five minutes) taken off, so that the mean does not step. With
    /// three or more it is their plain mean.
    pub inlet_pressure_pa: Vec<f64>,
    /// The same of the outlet transmitters.
    pub outlet_pressure_pa: Vec<f64>,
}

impl Screening {
    /// Mask of the samples that may be used for identification of friction and pump.
    pub fn keep(&self) -> Vec<bool> {
        self.reasons.iter().map(|r| r.is_empty()).collect()
    }

    /// Mask of the samples against which nothing but `tolerated` speaks: for a purpose of one's own, which some of the reasons do not hinder.
    ///
    /// ```
    /// # use dgd_screen::{Reasons, Screening};
    /// /// Where the pump runs steadily or has only just started, for a study of its starts.
    /// fn with_starts(screening: &Screening) -> Vec<bool> {
    ///     screening.keep_despite(Reasons::SETTLING)
    /// }
    /// ```
    pub fn keep_despite(&self, tolerated: Reasons) -> Vec<bool> {
        let usable = |r: &Reasons| r.without(tolerated).is_empty();
        self.reasons.iter().map(usable).collect()
    }

    /// Counts by reason, for a report's table; the column `first` adds up.
    pub fn tally(&self) -> Vec<Tally> {
        reasons::tally(&self.reasons)
    }

    /// The screening of one transmitter; `None` if the recording has no such.
    pub fn channel(&self, channel: Channel) -> Option<&ChannelScreen> {
        self.channels.iter().find(|c| c.channel == channel)
    }
}

/// Screens a recording that lies on an even clock (see [`Recording::onto_grid`]).
///
/// - `recording`: every series SI, NaN where nothing was recorded; shape `(n,)`, which
///   may be 0. Transmitters may be missing: without any at the inlet or the outlet
///   every sample is a gap.
/// - `step_s`: step of the clock, s.
///
/// A sample is rejected when the return flow, the pump speed, or every transmitter of a
/// pump side is missing or at fault, and by the rules of the thesis. One faulty
/// transmitter of two rejects nothing. Faults of the inflows and of the riser pressure
/// are told by [`Screening::channel`] and reject nothing either.
///
/// Stuck runs: see [`ScreenOptions::stuck_chance`]; a return flow that rests while the
/// pump is off, an inflow that rests at zero and an inflow that never changes are
/// not stuck. The time is linear in the samples.
///
/// # Errors
/// [`ScreenError::Unequal`] on unequal series, [`ScreenError::Uneven`] on a clock that is
/// not even or of another step, [`ScreenError::Step`] and [`ScreenError::Option`] on
/// numbers that cannot be.
///
/// # Source
/// Thesis, section 3.3.1 (rules of usable data, stuck runs).
pub fn screen(
    recording: &Recording,
    step_s: f64,
    options: &ScreenOptions,
) -> Result<Screening, ScreenError> {
    let rules = Rules::new(step_s, options)?;
    crate::error::check(recording, step_s)?;
    let job = Job { recording, rules };
    let mut channels: Vec<ChannelScreen> = recording
        .series()
        .into_par_iter()
        .map(|(channel, values)| job.channel(channel, values))
        .collect();
    let (inlet_pressure_pa, outlet_pressure_pa) = job.sides(&mut channels);
    let reasons = job.judged(&mut channels, &inlet_pressure_pa, &outlet_pressure_pa);
    Ok(Screening {
        reasons,
        channels,
        inlet_pressure_pa,
        outlet_pressure_pa,
    })
}

/// The options on a clock of this step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rules<'a> {
    pub(crate) step_s: f64,
    pub(crate) options: &'a ScreenOptions,
}

impl<'a> Rules<'a> {
    pub(crate) fn new(step_s: f64, options: &'a ScreenOptions) -> Result<Self, ScreenError> {
        options.check()?;
        crate::error::check_step(step_s)?;
        Ok(Self { step_s, options })
    }

    pub(crate) fn limits(self, channel: Channel) -> Limits {
        match channel {
            Channel::PumpSpeed => self.options.speed_pct,
            _ if is_pressure(channel) => self.options.pressure_pa,
            Channel::ReturnFlow => self.options.flow_m3_s,
            _ => self.options.inflow_m3_s,
        }
    }

    pub(crate) fn spike(self, channel: Channel) -> SpikeRule {
        let may_be_set = matches!(channel, Channel::BoosterFlow | Channel::TopfillFlow);
        let is_inflow = may_be_set || channel == Channel::MudPumpFlow;
        let dropout_s = if is_inflow {
            self.options.dropout_longest_s
        } else {
            0.0
        };
        SpikeRule {
            sigmas: self.options.spike_sigmas,
            longest: samples(self.options.spike_longest_s, self.step_s, 1).min(spike::LONGEST),
            dropout: samples(dropout_s, self.step_s, 0).min(spike::LONGEST_DROPOUT),
            may_be_set,
        }
    }

    /// The same from reading to reading of a channel that is read now and then: one alone is a spike.
    pub(crate) fn spike_of_readings(self, channel: Channel) -> SpikeRule {
        SpikeRule {
            longest: 1,
            dropout: 0,
            ..self.spike(channel)
        }
    }

    pub(crate) fn stuck(self, channel: Channel) -> StuckRule {
        let options = self.options;
        let (floor, chance) = match channel {
            Channel::ReturnFlow => (options.stuck_flow_samples, options.stuck_chance),
            // Rest is no fault, so chance has no say in it.
            Channel::PumpSpeed => (samples(options.constant_speed_s, self.step_s, 3), 1.0),
            _ if is_pressure(channel) => (
                samples(options.stuck_pressure_s, self.step_s, 3),
                options.stuck_chance,
            ),
            _ => (
                samples(options.stuck_inflow_s, self.step_s, 3),
                options.stuck_chance,
            ),
        };
        StuckRule {
            floor,
            chance,
            gap: self.gap(),
        }
    }

    /// So many missing samples in a row do not end a run of one value.
    pub(crate) fn gap(self) -> usize {
        const GAP_S: f64 = 30.0;
        // A run is judged by what follows it.
        samples(GAP_S, self.step_s, 0).min(stuck::NEIGHBOURHOOD / 2)
    }

    /// Whether a run of one value may well be honest; at so many of its samples the pump is `turning`.
    pub(crate) fn is_honest(
        self,
        channel: Channel,
        steps: Steps,
        rest: Rest,
        turning: impl FnOnce() -> usize,
    ) -> bool {
        let at_zero = rest.value.abs() <= steps.quantum;
        match channel {
            // Nothing need move while the pump is off throughout the run but for fewer samples than a stuck
            // run has. A meter that froze while the pump still turned is not at rest.
            Channel::ReturnFlow => at_zero || turning() < rest.shortest,
            Channel::PumpSpeed => rest.value <= self.options.pump_on_above_pct,
            _ if is_pressure(channel) => false,
            _ => rest.whole || at_zero,
        }
    }

    /// The stuck runs of a channel without those of an inflow that are rates: all of a booster or top-fill that goes from one value to another and
    /// repeats each for most of the recording, as these were set; and those of a counter.
    ///
    /// - `pairs`: neighbours that both have a value.
    /// - `beside`: the samples on either side of a run.
    pub(crate) fn unless_rates(
        self,
        channel: Channel,
        mut stuck: Vec<Run>,
        pairs: usize,
        steps: Steps,
        beside: impl Fn(&Run) -> Beside,
    ) -> Vec<Run> {
        let repeated: usize = stuck.iter().map(|run| run.length).sum();
        let differ = stuck.windows(2).any(|two| two[0].value != two[1].value);
        match channel {
            Channel::BoosterFlow | Channel::TopfillFlow if differ && 2 * repeated > pairs => {
                stuck.clear();
            }
            Channel::MudPumpFlow | Channel::BoosterFlow | Channel::TopfillFlow => {
                stuck.retain(|run| !beside(run).is_counted(run.value, steps));
            }
            _ => {}
        }
        stuck
    }

    /// What runs of one value mean: at their first sample, and from the next on.
    ///
    /// What a flow meter repeats it once read; a pressure has a twin to tell it.
    pub(crate) fn faults_of_runs(channel: Channel) -> [Faults; 2] {
        match channel {
            Channel::PumpSpeed => [Faults::CONSTANT; 2],
            _ if is_pressure(channel) => [Faults::STUCK; 2],
            _ => [Faults::HELD, Faults::STUCK],
        }
    }

    /// - `quantum`: largest quantisation step of the transmitters.
    pub(crate) fn disagree(self, quantum: f64) -> DisagreeRule {
        DisagreeRule {
            sigmas: self.options.disagree_sigmas,
            longest: samples(self.options.disagree_longest_s, self.step_s, 1),
            block: samples(60.0, self.step_s, 5),
            least: 4.0 * quantum,
        }
    }

    /// Fewest equal speeds that are examined for being frozen.
    pub(crate) fn frozen_floor(self) -> usize {
        samples(self.options.frozen_speed_s, self.step_s, 3)
    }
}

struct Job<'a> {
    recording: &'a Recording,
    rules: Rules<'a>,
}

impl Job<'_> {
    /// Gaps, impossible values, spikes and stuck runs of one transmitter.
    fn channel(&self, channel: Channel, values: &[f64]) -> ChannelScreen {
        let rules = self.rules;
        let limits = rules.limits(channel);
        let mut faults = vec![Faults::NONE; values.len()];
        let steps = scan::steps(values);
        let rule = rules.spike(channel);
        let scan = scan::scan(values, limits, spike::least(steps, rule), &mut faults);
        let twins = twins(self.recording, channel);
        let spikes = spike::find(values, &faults, &scan.jumps, steps, rule, &twins);
        for spike in &spikes {
            mark(&mut faults, spike.range.clone(), Faults::SPIKE);
        }
        let dropouts = spikes.into_iter().filter(|spike| spike.dropout);
        let found = stuck::find(values, &scan, rules.stuck(channel), |run, shortest| {
            let rest = Rest {
                value: run.value,
                whole: run.length == values.len(),
                shortest,
            };
            rules.is_honest(channel, steps, rest, || self.turning(run))
        });
        let runs = rules.unless_rates(channel, found.runs, scan.pairs, steps, |run| {
            Beside::of(run, values)
        });
        mark_runs(&mut faults, 0, &runs, Rules::faults_of_runs(channel));
        let (stuck, constant) = if channel == Channel::PumpSpeed {
            (Vec::new(), runs)
        } else {
            (runs, Vec::new())
        };
        ChannelScreen {
            channel,
            faults,
            stuck,
            constant,
            dropouts: dropouts.map(|spike| spike.run(values)).collect(),
            shortest_stuck: found.shortest,
            quantum: steps.quantum,
            noise: steps.noise,
            repeat_share: found.repeat_share,
        }
    }

    /// Samples of a run at which the pump turns.
    fn turning(&self, run: &Run) -> usize {
        let speed = &self.recording.pump_speed_pct[run.start..run.start + run.length];
        let turning = |w: &&f64| **w > self.rules.options.pump_on_above_pct;
        speed.iter().filter(turning).count()
    }

    /// Both pump sides, one beside the other: neither looks at the other's transmitters.
    fn sides(&self, channels: &mut [ChannelScreen]) -> (Vec<f64>, Vec<f64>) {
        let (mut inlets, mut outlets) = (Vec::new(), Vec::new());
        for channel in channels {
            match channel.channel {
                Channel::PumpInletPressure(_) => inlets.push(channel),
                Channel::PumpOutletPressure(_) => outlets.push(channel),
                _ => {}
            }
        }
        rayon::join(
            || self.side(inlets, &self.recording.pump_inlet_pressure_pa),
            || self.side(outlets, &self.recording.pump_outlet_pressure_pa),
        )
    }

    /// Short disagreement of the transmitters of one pump side, and the mean of the trusted.
    fn side(&self, mut here: Vec<&mut ChannelScreen>, side: &[Vec<f64>]) -> Vec<f64> {
        let series: Vec<&[f64]> = side.iter().map(Vec::as_slice).collect();
        let mut faults: Vec<Vec<Faults>> = here
            .iter_mut()
            .map(|c| std::mem::take(&mut c.faults))
            .collect();
        let quantum = here.iter().map(|c| c.quantum).fold(0.0, f64::max);
        let rule = self.rules.disagree(quantum);
        let slow = redundant::mark(&series, &mut faults, rule);
        for (channel, faults) in here.iter_mut().zip(faults) {
            channel.faults = faults;
        }
        let faults: Vec<&[Faults]> = here.iter().map(|c| c.faults.as_slice()).collect();
        redundant::trusted_mean(&series, &faults, slow.as_ref(), 0..self.recording.len())
    }

    /// Tells frozen runs of speed from honest rest, and why each sample may not be used.
    fn judged(
        &self,
        channels: &mut [ChannelScreen],
        inlet_pa: &[f64],
        outlet_pa: &[f64],
    ) -> Vec<Reasons> {
        let (mut speed, mut others) = (None, Vec::new());
        for channel in channels {
            if channel.channel == Channel::PumpSpeed {
                speed = Some(channel);
            } else {
                others.push(&*channel);
            }
        }
        // What speaks against a sample beside its speed does not wait for the speed.
        let (speed, mut reasons) = rayon::join(
            || speed.map(|speed| self.resting_speed(speed, outlet_pa)),
            || self.reasons(&others, inlet_pa, outlet_pa),
        );
        if let Some(speed) = speed {
            self.blame(&mut reasons, &speed.faults, Reasons::STUCK_PUMP_SPEED);
            self.settling(&mut reasons, &speed.faults);
            self.stopping(&mut reasons, &speed.faults);
        }
        reasons
    }

    /// Tells the frozen runs of speed from honest rest, and gives the channel back.
    fn resting_speed<'c>(
        &self,
        channel: &'c mut ChannelScreen,
        outlet_pa: &[f64],
    ) -> &'c ChannelScreen {
        let speed_pct = &self.recording.pump_speed_pct;
        let on = self.rules.options.pump_on_above_pct;
        let (least, gap) = (self.rules.frozen_floor(), self.rules.gap());
        let complete = !speed_pct.iter().any(|v| v.is_nan());
        let runs: Vec<Run> = (stuck::long_runs(speed_pct, complete, least, gap).iter())
            .map(|held| held.run)
            .filter(|run| run.value > on)
            .collect();
        let steps = scan::steps(speed_pct);
        let window = speed::window(self.rules.step_s);
        let readings = Readings {
            speed_pct,
            faults: &channel.faults,
        };
        channel.stuck = speed::frozen(readings, outlet_pa, steps, &runs, window);
        mark_runs(&mut channel.faults, 0, &channel.stuck, [Faults::STUCK; 2]);
        channel
    }

    /// Why each sample may not be used, but for the pump speed's faults.
    fn reasons(
        &self,
        channels: &[&ChannelScreen],
        inlet_pa: &[f64],
        outlet_pa: &[f64],
    ) -> Vec<Reasons> {
        /// Samples judged at a time, on whichever core is free.
        const PART: usize = 1 << 14;
        let mut reasons = vec![Reasons::NONE; self.recording.len()];
        let parts = reasons.par_chunks_mut(PART).enumerate();
        parts.for_each(|(k, part)| {
            let here = k * PART..k * PART + part.len();
            self.judge(part, here, channels, inlet_pa, outlet_pa);
        });
        reasons
    }

    /// [`Self::reasons`] of a range of samples, but for the seconds after a start.
    fn judge(
        &self,
        reasons: &mut [Reasons],
        here: Range<usize>,
        channels: &[&ChannelScreen],
        inlet_pa: &[f64],
        outlet_pa: &[f64],
    ) {
        let on = self.rules.options.pump_on_above_pct;
        let (inlet_pa, outlet_pa) = (&inlet_pa[here.clone()], &outlet_pa[here.clone()]);
        let flows = &self.recording.return_flow_m3_s[here.clone()];
        let speeds = &self.recording.pump_speed_pct[here.clone()];
        let pump = flows.iter().zip(speeds).zip(inlet_pa.iter().zip(outlet_pa));
        for (reason, ((q, w), (inlet, outlet))) in reasons.iter_mut().zip(pump) {
            *reason = Reasons::PUMP_OFF.when(*w <= on)
                | Reasons::NO_PRESSURE_RISE.when(outlet <= inlet)
                | Reasons::NO_FLOW.when(*q <= 0.0);
        }
        let returns = |c: &&&ChannelScreen| c.channel == Channel::ReturnFlow;
        for channel in channels.iter().filter(returns) {
            let faults = &channel.faults[here.clone()];
            self.blame(reasons, faults, Reasons::STUCK_RETURN_FLOW);
        }
        let side = |ours: fn(Channel) -> bool| -> Vec<&[Faults]> {
            (channels.iter().filter(|c| ours(c.channel)))
                .map(|c| &c.faults[here.clone()])
                .collect()
        };
        let inlets = side(|c| matches!(c, Channel::PumpInletPressure(_)));
        let outlets = side(|c| matches!(c, Channel::PumpOutletPressure(_)));
        for (faults, mean, stuck, disagree) in [
            (
                inlets,
                inlet_pa,
                Reasons::STUCK_INLET_PRESSURE,
                Reasons::INLETS_DISAGREE,
            ),
            (
                outlets,
                outlet_pa,
                Reasons::STUCK_OUTLET_PRESSURE,
                Reasons::OUTLETS_DISAGREE,
            ),
        ] {
            for (i, reason) in reasons
                .iter_mut()
                .enumerate()
                .filter(|(i, _)| mean[*i].is_nan())
            {
                let mut why = Reasons::GAP.when(faults.is_empty());
                for faults in &faults {
                    why |= of_faults(faults[i], stuck, disagree);
                }
                *reason |= why;
            }
        }
    }

    /// Rejects the samples at which a needed channel is at fault.
    fn blame(&self, reasons: &mut [Reasons], faults: &[Faults], stuck: Reasons) {
        let constant = Reasons::CONSTANT_PUMP_SPEED.when(self.rules.options.reject_constant_speed);
        for (reason, faults) in reasons.iter_mut().zip(faults) {
            if *faults != Faults::NONE {
                *reason |= of_faults(*faults, stuck, Reasons::NONE)
                    | constant.when(faults.contains(Faults::CONSTANT));
            }
        }
    }

    /// Whether a reading of the speed tells if the pump runs: a gap, a spike and an impossible one do not.
    fn tells(speed_pct: f64, faults: Faults) -> bool {
        speed_pct.is_finite()
            && !faults.contains(Faults::SPIKE)
            && !faults.contains(Faults::OUT_OF_RANGE)
    }

    /// Marks the seconds after each start of the pump.
    fn settling(&self, reasons: &mut [Reasons], faults: &[Faults]) {
        let settle = samples(self.rules.options.settle_s, self.rules.step_s, 0);
        if settle == 0 {
            return;
        }
        let mut left = 0usize;
        let mut was_off = false;
        let speeds = self.recording.pump_speed_pct.iter().zip(faults);
        for (reason, (w, faults)) in reasons.iter_mut().zip(speeds) {
            if Self::tells(*w, *faults) {
                let off = *w <= self.rules.options.pump_on_above_pct;
                if was_off && !off {
                    left = settle;
                }
                was_off = off;
            }
            if left > 0 {
                left -= 1;
                *reason |= Reasons::SETTLING.when(!was_off);
            }
        }
    }

    /// Marks the samples before each stop of the pump at which it runs down already.
    fn stopping(&self, reasons: &mut [Reasons], faults: &[Faults]) {
        /// Share of the speed before below which it lifts less than half of what it did, which holds no column: what is above tells of the
        /// meter's delay.
        const RUNNING: f64 = 0.7;
        let longest = samples(self.rules.options.run_down_s, self.rules.step_s, 0);
        let speeds = &self.recording.pump_speed_pct;
        let tells = |i: usize| Self::tells(speeds[i], faults[i]);
        // From the last sample at which it was on.
        let mut began = None;
        for (i, w) in speeds.iter().enumerate().filter(|(i, _)| tells(*i)) {
            if *w > self.rules.options.pump_on_above_pct {
                began.get_or_insert(i);
                continue;
            }
            let Some(start) = began.take() else {
                continue;
            };
            let before = start.max(i.saturating_sub(longest))..i;
            let told = before.filter(|k| tells(*k));
            let highest = told.clone().map(|k| speeds[k]).fold(0.0, f64::max);
            for k in told {
                reasons[k] |= Reasons::STOPPING.when(speeds[k] < RUNNING * highest);
            }
        }
    }
}

/// The other transmitters of the same pump side.
pub(crate) fn twins(recording: &Recording, channel: Channel) -> Vec<&[f64]> {
    let (side, n) = match channel {
        Channel::PumpInletPressure(n) => (&recording.pump_inlet_pressure_pa, n),
        Channel::PumpOutletPressure(n) => (&recording.pump_outlet_pressure_pa, n),
        _ => return Vec::new(),
    };
    let others = side.iter().enumerate().filter(|(m, _)| *m != n);
    others.map(|(_, v)| v.as_slice()).collect()
}

fn of_faults(faults: Faults, stuck: Reasons, disagree: Reasons) -> Reasons {
    Reasons::GAP.when(faults.contains(Faults::MISSING))
        | Reasons::OUT_OF_RANGE.when(faults.contains(Faults::OUT_OF_RANGE))
        | Reasons::SPIKE.when(faults.contains(Faults::SPIKE))
        | stuck.when(faults.contains(Faults::STUCK) || faults.contains(Faults::HELD))
        | disagree.when(faults.contains(Faults::DISAGREES))
}

/// Marks the samples, of which the first is `start`, that lie in runs: the first of each, and the rest.
pub(crate) fn mark_runs(faults: &mut [Faults], start: usize, runs: &[Run], of: [Faults; 2]) {
    let end = start + faults.len();
    let first = runs.partition_point(|r| r.start + r.length <= start);
    for run in runs[first..].iter().take_while(|r| r.start < end) {
        let range = run.start.max(start)..(run.start + run.length).min(end);
        for i in range {
            faults[i - start] |= of[usize::from(i > run.start)];
        }
    }
}

pub(crate) fn mark(faults: &mut [Faults], range: Range<usize>, fault: Faults) {
    for f in &mut faults[range] {
        *f |= fault;
    }
}
