//! A recording with its untrusted values blanked and its usable samples marked.

use dgd_recording::{Channel, Recording, Run, Settle};
use dgd_screen::{ChannelScreen, Faults, ScreenError, ScreenOptions, Tally, screen};

/// A screened recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Prepared {
    /// The recording, NaN wherever a transmitter cannot be trusted; of a stuck run a flow meter keeps the first value, which was read.
    pub recording: Recording,
    /// Step of its even clock, s.
    pub step_s: f64,
    /// Samples that identification may use, shape of the recording.
    pub keep: Vec<bool>,
    /// Mean of the trusted inlet transmitters, Pa absolute; it does not step where one is left out.
    pub inlet_pressure_pa: Vec<f64>,
    /// The same at the outlet.
    pub outlet_pressure_pa: Vec<f64>,
    /// Samples rejected, by reason.
    pub tally: Vec<Tally>,
    /// Stretches in which a transmitter repeats one value for longer than by chance, by transmitter.
    pub stuck: Vec<(Channel, Run)>,
    /// Stretches in which the signal of an inflow was lost, by transmitter.
    pub dropouts: Vec<(Channel, Run)>,
}

impl Prepared {
    /// Checks that what was screened belongs together; [`prepare`] makes nothing else.
    ///
    /// # Errors
    /// [`ScreenError::Unequal`] or [`ScreenError::Length`] if something is not as long as the clock, [`ScreenError::Step`] if
    /// the step is no positive number, [`ScreenError::Uneven`] if the clock is not even by that step.
    pub fn check(&self) -> Result<(), ScreenError> {
        self.recording.check()?;
        let expected = self.recording.len();
        for (channel, found) in [
            ("keep", self.keep.len()),
            ("inlet_pressure_pa", self.inlet_pressure_pa.len()),
            ("outlet_pressure_pa", self.outlet_pressure_pa.len()),
        ] {
            if found != expected {
                return Err(ScreenError::Length {
                    channel,
                    found,
                    expected,
                });
            }
        }
        if !(self.step_s.is_finite() && self.step_s > 0.0) {
            return Err(ScreenError::Step { found: self.step_s });
        }
        Ok(self.recording.check_even(self.step_s)?)
    }
}

/// Screens a recording on an even clock and blanks what cannot be trusted.
///
/// One transmitter's fault costs only that transmitter: the mean of redundant ones
/// is then taken over the rest. Readings are [settled](Settle) first. Of channels that are read apart, at samples of their own, lines are to be drawn before
/// (`dgd_screen::blank_strays`, then [`Recording::join_events`]): a sample without one of them is not used.
///
/// # Errors
/// [`ScreenError`] if a series is not as long as the clock, the clock is not even by `step_s`, or an option is off.
pub fn prepare(
    mut recording: Recording,
    step_s: f64,
    options: &ScreenOptions,
) -> Result<Prepared, ScreenError> {
    Settle::default().add(&mut recording);
    let screening = screen(&recording, step_s, options)?;
    let blank = || {
        for channel in &screening.channels {
            let Some(values) = recording.channel_mut(channel.channel) else {
                continue;
            };
            // Most stretches have no fault at all.
            let stretches = values
                .chunks_mut(STRETCH)
                .zip(channel.faults.chunks(STRETCH));
            for (values, faults) in stretches.filter(|(_, faults)| !sound(faults)) {
                let faulty = values
                    .iter_mut()
                    .zip(faults)
                    .filter(|(_, faults)| !faults.trusted());
                faulty.for_each(|(value, _)| *value = f64::NAN);
            }
        }
    };
    let ((), (keep, tally)) = rayon::join(blank, || (screening.keep(), screening.tally()));
    let runs_of = |pick: fn(&ChannelScreen) -> &[Run]| -> Vec<(Channel, Run)> {
        let of_one = |one| pick(one).iter().map(move |run| (one.channel, *run));
        screening.channels.iter().flat_map(of_one).collect()
    };
    Ok(Prepared {
        keep,
        tally,
        stuck: runs_of(|one| &one.stuck),
        dropouts: runs_of(|one| &one.dropouts),
        inlet_pressure_pa: screening.inlet_pressure_pa,
        outlet_pressure_pa: screening.outlet_pressure_pa,
        recording,
        step_s,
    })
}

/// Samples looked at together.
const STRETCH: usize = 64;

/// Whether no sample has a fault, without an early exit: the compiler can vectorise it.
fn sound(faults: &[Faults]) -> bool {
    faults
        .iter()
        .fold(true, |all, f| all & (*f == Faults::NONE))
}

impl Prepared {
    /// The recording with one series a pump side: the trusted mean.
    pub fn averaged(self) -> Recording {
        Recording {
            pump_inlet_pressure_pa: vec![self.inlet_pressure_pa],
            pump_outlet_pressure_pa: vec![self.outlet_pressure_pa],
            ..self.recording
        }
    }

    /// What is to be said of what is not used: one message a transmitter that repeated one value for many minutes, or whose signal was lost
    /// again and again, and where.
    ///
    /// Short stretches of one value are part of every recording, and a channel that never changes is suspected as such.
    pub fn not_used(&self) -> Vec<String> {
        let mut said = self.stuck_for_long();
        said.extend(self.lost());
        said
    }

    fn stuck_for_long(&self) -> Vec<String> {
        /// Seconds from which on a stretch is told.
        const LONG_S: f64 = 600.0;
        let time_s = &self.recording.time_s;
        #[expect(clippy::cast_precision_loss, reason = "samples of a run")]
        let seconds = |run: &Run| run.length as f64 * self.step_s;
        let whole = |run: &Run| 10 * run.length >= 9 * time_s.len();
        self.stuck
            .chunk_by(|(channel, _), (next, _)| channel == next)
            .filter_map(|of_one| {
                let channel = of_one.first()?.0;
                let runs = || of_one.iter().map(|(_, run)| run);
                let long = || runs().filter(|run| seconds(run) >= LONG_S && !whole(run));
                let longest = long().max_by_key(|run| run.length)?;
                let from = time_s.get(longest.start)?;
                let to = from + seconds(longest);
                let times = long().count();
                Some(if times == 1 {
                    format!("`{channel}` repeats one value from {from:.0} to {to:.0} s and is not used there; is it frozen?")
                } else {
                    format!(
                        "`{channel}` repeats one value for {:.0} min or more {times} times, {:.1} h in all and longest from {from:.0} to {to:.0} s, and is not used there; is it frozen, or logged only when it changes?",
                        LONG_S / 60.0,
                        long().map(seconds).sum::<f64>() / 3600.0
                    )
                })
            })
            .collect()
    }

    fn lost(&self) -> Vec<String> {
        /// So many are told.
        const MANY: usize = 3;
        let of_one = self.dropouts.chunk_by(|(one, _), (next, _)| one == next);
        of_one
            .filter(|runs| runs.len() >= MANY)
            .filter_map(|runs| {
                let (channel, first) = runs.first()?;
                let from = self.recording.time_s.get(first.start)?;
                let samples: usize = runs.iter().map(|(_, run)| run.length).sum();
                #[expect(clippy::cast_precision_loss, reason = "samples of a recording")]
                let seconds = samples as f64 * self.step_s;
                Some(format!(
                    "`{channel}` jumps to one value for seconds and back {} times, {seconds:.0} s in all and first at {from:.0} s, and is not used there; is its signal lost?",
                    runs.len()
                ))
            })
            .collect()
    }

    /// Samples that identification may use.
    pub fn kept(&self) -> usize {
        self.keep.iter().filter(|k| **k).count()
    }
}
