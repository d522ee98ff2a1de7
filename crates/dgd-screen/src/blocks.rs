//! The screening of a recording that is longer than memory.

mod resting;
mod series;
mod side;
mod window;

use crate::screening::Rules;
use crate::{Faults, ScreenError, ScreenOptions};
use dgd_recording::{Channel, Recording, Run};
use rayon::prelude::*;
use resting::Resting;
use series::{Known, RunPass, StepPass};
use side::Side;
use window::Window;

/// The screening of a recording that comes in blocks, which are gone through as often as it asks for: four times, or five
/// where there are redundant transmitters.
///
/// What it finds is what [`crate::screen`] finds in the whole recording, to the last bit, whatever the blocks: the faults of
/// every transmitter and the means of the trusted ones. Why a sample may not be used for identification, it does not tell.
///
/// Parts of the result come on the last pass, each as soon as what follows can no longer change it; they lag some
/// minutes behind the blocks. From one block to the next are carried: runs of one value that have not ended, jumps that may yet
/// be spikes, disagreement that may yet return, and as many samples as those look back at, which is as
/// long as the options allow, not as long as the recording. What rests on the whole recording is gathered in the earlier passes: a few
/// thousand steps of each channel, how often a value repeats, the stuck runs, and of redundant transmitters and of changes
/// of the pump's speed one or two numbers a minute or ten seconds. These lists grow with the recording, to
/// some hundredths of what it takes itself.
///
/// ```
/// use dgd_recording::Recording;
/// use dgd_screen::{BlockScreen, ScreenOptions};
/// let block = |from: u32| {
///     let noisy = |level: f64, step: f64| -> Vec<f64> {
///         (from..from + 50).map(|i| level + step * f64::from(i * 37 % 11)).collect()
///     };
///     let mut block = Recording {
///         time_s: (from..from + 50).map(f64::from).collect(),
///         mud_pump_flow_m3_s: noisy(0.03, 1e-5),
///         booster_flow_m3_s: noisy(0.01, 1e-5),
///         topfill_flow_m3_s: noisy(0.002, 1e-5),
///         return_flow_m3_s: noisy(0.042, 1e-5),
///         pump_inlet_pressure_pa: vec![noisy(24e5, 500.0)],
///         pump_outlet_pressure_pa: vec![noisy(40e5, 500.0)],
///         riser_pressure_pa: None,
///         pump_speed_pct: noisy(60.0, 0.1),
///     };
///     block.return_flow_m3_s[20..40].fill(0.0421); // the meter froze
///     block
/// };
/// let mut screen = BlockScreen::new(100, 1.0, &ScreenOptions::default())?;
/// let mut flows = Vec::new();
/// loop {
///     for from in [0, 50] {
///         flows.extend(screen.add(&block(from))?.trusted().return_flow_m3_s);
///     }
///     if !screen.next_pass()? {
///         break;
///     }
/// }
/// assert_eq!(flows.len(), 100);
/// // Each time it froze it had read the first value.
/// assert_eq!(flows.iter().filter(|q| q.is_nan()).count(), 38);
/// # Ok::<(), dgd_screen::ScreenError>(())
/// ```
#[derive(Debug)]
pub struct BlockScreen {
    options: ScreenOptions,
    step_s: f64,
    samples: usize,
    pass: Pass,
    /// Samples of this pass so far, and the second of the last.
    taken: usize,
    last_s: Option<f64>,
    channels: Vec<Channel>,
    steps: Vec<StepPass>,
    runs: Vec<RunPass>,
    known: Vec<Known>,
    window: Window,
    inlets: Side,
    outlets: Side,
    resting: Resting,
}

/// What is looked for in a pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Pass {
    /// Steps and repeats of every channel.
    Steps,
    /// Runs of one value that are stuck.
    Runs,
    /// How redundant transmitters differ slowly.
    Slow,
    /// How the outlet pressure answers the speed, and after which runs of speed it does not.
    Answer,
    /// Everything is known.
    Last,
}

/// A part of a screened recording.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ScreenedBlock {
    /// The samples as they came, SI, shape `(n,)`.
    pub recording: Recording,
    /// What is wrong with each transmitter, in the order of [`Recording::series`], shape `(n,)` each.
    pub faults: Vec<(Channel, Vec<Faults>)>,
    /// As [`crate::Screening::inlet_pressure_pa`], shape `(n,)`.
    pub inlet_pressure_pa: Vec<f64>,
    /// As [`crate::Screening::outlet_pressure_pa`], shape `(n,)`.
    pub outlet_pressure_pa: Vec<f64>,
}

impl ScreenedBlock {
    /// The recording with NaN for what is not to be trusted, and one series a pump side: the trusted mean.
    pub fn trusted(mut self) -> Recording {
        for (channel, faults) in &self.faults {
            let values = self.recording.channel_mut(*channel).unwrap_or_default();
            let faulty = values.iter_mut().zip(faults).filter(|(_, f)| !f.trusted());
            faulty.for_each(|(value, _)| *value = f64::NAN);
        }
        Recording {
            pump_inlet_pressure_pa: vec![self.inlet_pressure_pa],
            pump_outlet_pressure_pa: vec![self.outlet_pressure_pa],
            ..self.recording
        }
    }
}

impl BlockScreen {
    /// For a recording on an even clock.
    ///
    /// - `samples`: of the whole recording.
    /// - `step_s`: step of the clock, s.
    ///
    /// # Errors
    /// [`ScreenError::Step`] and [`ScreenError::Option`] on numbers that cannot be.
    pub fn new(samples: usize, step_s: f64, options: &ScreenOptions) -> Result<Self, ScreenError> {
        let rules = Rules::new(step_s, options)?;
        Ok(Self {
            options: options.clone(),
            step_s,
            samples,
            pass: Pass::Steps,
            taken: 0,
            last_s: None,
            channels: Vec::new(),
            steps: Vec::new(),
            runs: Vec::new(),
            known: Vec::new(),
            window: Window::default(),
            inlets: Side::default(),
            outlets: Side::default(),
            resting: Resting::new(rules),
        })
    }

    /// Takes the next samples; gives, on the last pass, those that are screened by now, and none before.
    ///
    /// - `block`: as [`crate::screen`] takes a recording; all blocks must have the same transmitters.
    ///
    /// # Errors
    /// [`ScreenError::Unequal`] on unequal series, [`ScreenError::Uneven`] on a clock that is not even, also from block to
    /// block, [`ScreenError::Blocks`] on more samples than were announced or on other transmitters.
    pub fn add(&mut self, block: &Recording) -> Result<ScreenedBlock, ScreenError> {
        crate::error::check_next(block, self.step_s, self.last_s)?;
        let all = block.series();
        let expected = block.len();
        let channels: Vec<Channel> = all.iter().map(|(channel, _)| *channel).collect();
        if self.channels.is_empty() {
            self.begin(&channels);
        }
        let found = self.taken + expected;
        if channels != self.channels || found > self.samples {
            return Err(self.uneven(found));
        }
        let from = std::mem::replace(&mut self.taken, found);
        self.last_s = block.time_s.last().copied().or(self.last_s);
        let rules = Rules {
            step_s: self.step_s,
            options: &self.options,
        };
        match self.pass {
            Pass::Steps => {
                let both = self.steps.par_iter_mut().zip(all);
                let gap = rules.gap();
                both.for_each(|(pass, (_, values))| pass.add(values, self.samples, gap));
                Ok(ScreenedBlock::default())
            }
            Pass::Runs => {
                let both = self.runs.par_iter_mut().zip(&self.known).zip(all);
                let speed = &block.pump_speed_pct;
                both.for_each(|((pass, known), (_, values))| {
                    pass.add(from, values, speed, known, rules);
                });
                Ok(ScreenedBlock::default())
            }
            Pass::Slow | Pass::Answer | Pass::Last => {
                self.window.push(block, &self.known, rules);
                Ok(self.advance())
            }
        }
    }

    /// Ends a pass over the blocks; says whether they must come again.
    ///
    /// # Errors
    /// [`ScreenError::Blocks`] on fewer samples than were announced.
    pub fn next_pass(&mut self) -> Result<bool, ScreenError> {
        if self.taken != self.samples {
            return Err(self.uneven(self.taken));
        }
        let rules = Rules {
            step_s: self.step_s,
            options: &self.options,
        };
        (self.taken, self.last_s) = (0, None);
        self.window.clear();
        self.pass = match self.pass {
            Pass::Steps => {
                let passes = std::mem::take(&mut self.steps);
                self.known = (passes.into_iter().zip(&self.channels))
                    .map(|(pass, channel)| pass.known(*channel, rules))
                    .collect();
                Pass::Runs
            }
            Pass::Runs => {
                for (pass, known) in self.runs.drain(..).zip(&mut self.known) {
                    known.runs = pass.stuck(self.samples, known, rules);
                }
                for side in [&mut self.inlets, &mut self.outlets] {
                    side.begin(&self.known, rules);
                }
                if let Some(speed) = self.known.last() {
                    self.resting.begin(speed.steps);
                }
                if self.inlets.differs() || self.outlets.differs() {
                    Pass::Slow
                } else {
                    Pass::Answer
                }
            }
            Pass::Slow => {
                self.inlets.know_slow(self.samples);
                self.outlets.know_slow(self.samples);
                Pass::Answer
            }
            Pass::Answer => {
                self.resting.know_frozen();
                Pass::Last
            }
            Pass::Last => return Ok(false),
        };
        self.inlets.rewind();
        self.outlets.rewind();
        Ok(true)
    }

    /// Whether the last pass has come: from now on, [`Self::add`] gives what is screened.
    pub fn is_last_pass(&self) -> bool {
        self.pass == Pass::Last
    }

    /// Those of the runs of one speed that are frozen, known from the last pass on.
    pub fn frozen_speed(&self) -> &[Run] {
        self.resting.frozen()
    }

    fn begin(&mut self, channels: &[Channel]) {
        self.channels = channels.to_vec();
        self.steps = vec![StepPass::default(); channels.len()];
        self.runs = vec![RunPass::default(); channels.len()];
        let of = |ours: fn(&Channel) -> bool| -> Vec<usize> {
            let numbered = channels.iter().enumerate();
            numbered.filter(|(_, c)| ours(c)).map(|(i, _)| i).collect()
        };
        self.inlets = Side::of(of(|c| matches!(c, Channel::PumpInletPressure(_))));
        self.outlets = Side::of(of(|c| matches!(c, Channel::PumpOutletPressure(_))));
    }

    fn uneven(&self, found: usize) -> ScreenError {
        ScreenError::Blocks {
            found,
            expected: self.samples,
        }
    }

    /// Goes as far as what has come by now allows.
    fn advance(&mut self) -> ScreenedBlock {
        let at_end = self.taken == self.samples;
        let (window, sides) = (&mut self.window, [&mut self.inlets, &mut self.outlets]);
        let marked = window.mark_spikes(&self.known, &self.options, self.step_s, at_end);
        let mut needed = marked.saturating_sub(window::LOOKED_BACK_AT);
        if self.pass == Pass::Slow {
            for side in sides {
                side.add_slow(window, marked, self.samples, at_end);
                needed = needed.min(side.next_block());
            }
            window.keep_from(needed);
            return ScreenedBlock::default();
        }
        let mut settled = marked;
        for side in sides {
            side.find_disagreement(window, marked, self.samples, at_end);
            settled = settled.min(side.undecided(marked));
            needed = needed.min(side.needed(marked));
        }
        let from = window.settled();
        let marks = [&mut self.inlets, &mut self.outlets];
        window.settle(
            settled,
            marks.into_iter().flat_map(|side| side.marks(settled)),
        );
        let means = [&self.inlets, &self.outlets].map(|side| side.means(window, from..settled));
        let mut part = ScreenedBlock::default();
        if self.pass == Pass::Answer {
            window.add_outlet(&means[1]);
            self.resting.add(window, self.samples, at_end);
            needed = needed.min(self.resting.needed(settled));
        } else {
            part = window.part(from..settled, &self.channels, self.resting.frozen());
            [part.inlet_pressure_pa, part.outlet_pressure_pa] = means;
        }
        self.window.keep_from(needed.min(settled));
        part
    }
}
