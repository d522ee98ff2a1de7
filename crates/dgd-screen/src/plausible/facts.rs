//! A recording in block means, with what the well description says of each channel.

use super::filler::{Filler, Highest};
use crate::channel::is_pressure;
use dgd_recording::{Channel, ChannelSource, Rank, Recording, TimeSource, Well};
use dgd_units::{Dimension, Unit};
use rayon::prelude::*;

/// Seconds of a block: several delays of a flow meter, few enough that the level moves on.
const BLOCK_S: f64 = 60.0;
/// Fewest samples of a block, so that a wrong clock does not make blocks of noise.
const BLOCK_SAMPLES: usize = 30;

/// A channel as described and as recorded.
pub(super) struct Told {
    pub(super) channel: Channel,
    /// `None` for a channel without a transmitter.
    pub(super) tag: Option<String>,
    pub(super) unit: Unit,
    /// Block means, SI; NaN where a block has no value, or a number that stands for none, as a pressure below vacuum does.
    pub(super) blocks: Vec<f64>,
    /// That number.
    pub(super) filler: Option<Filler>,
    /// Share of samples with a value.
    pub(super) present: f64,
    /// The one value that it has throughout, SI.
    pub(super) constant: Option<f64>,
}

/// What the checks look at.
pub(super) struct Facts {
    pub(super) told: Vec<Told>,
    /// Seconds of a block.
    pub(super) block_s: f64,
    pub(super) step_s: f64,
    /// Unit of the clock.
    pub(super) clock: Unit,
}

impl Facts {
    pub(super) fn of(recording: &Recording, step_s: f64, well: &Well) -> Self {
        let block = block_samples(step_s);
        let told = recording
            .series()
            .into_par_iter()
            .filter_map(|(channel, values)| {
                let (mut found, mut blocks) = (0, Vec::with_capacity(values.len() / block + 1));
                let mut ends = Ends::default();
                for parts in values.chunks(BESIDE * block) {
                    for (mean, present) in means(parts, block) {
                        found += present;
                        blocks.push(mean);
                    }
                    if is_pressure(channel) {
                        parts.chunks(block).for_each(|part| ends.add(part));
                    }
                }
                let filler = ends.blank(channel, &mut blocks);
                let present = found as f64 / values.len().max(1) as f64;
                Told::of(well, channel, (blocks, filler), present, constant(values))
            });
        Self::with(told.collect(), step_s, well)
    }

    /// The same of channels that came in blocks.
    pub(super) fn gathered(passes: Vec<(Channel, FactPass)>, step_s: f64, well: &Well) -> Self {
        let told = passes.into_iter().filter_map(|(channel, pass)| {
            let (blocks, present, constant) = pass.finish(channel);
            Told::of(well, channel, blocks, present, constant)
        });
        Self::with(told.collect(), step_s, well)
    }

    fn with(told: Vec<Told>, step_s: f64, well: &Well) -> Self {
        let block = block_samples(step_s);
        Self {
            told,
            block_s: block as f64 * step_s,
            step_s,
            clock: match &well.channels.time {
                TimeSource::Column { unit, .. } => *unit,
                TimeSource::Interval { .. } => Unit::si(Dimension::Time),
            },
        }
    }

    /// Place of a channel in `told`.
    pub(super) fn find(&self, channel: Channel) -> Option<usize> {
        self.told.iter().position(|t| t.channel == channel)
    }
}

impl Told {
    fn of(
        well: &Well,
        channel: Channel,
        (mut blocks, filler): (Vec<f64>, Option<Filler>),
        present: f64,
        constant: Option<f64>,
    ) -> Option<Self> {
        let (tag, unit) = match source_of(well, channel)? {
            ChannelSource::Column { tag, unit, .. } => (Some(tag.clone()), *unit),
            ChannelSource::Constant { .. } => (None, Unit::si(channel.dimension())),
        };
        // What never changes is told as such; it has nothing to say on its unit.
        if tag.is_some() && constant.is_some() && !feeds(channel) {
            blocks.fill(f64::NAN);
        }
        Some(Self {
            channel,
            tag,
            unit,
            blocks,
            filler,
            present,
            constant,
        })
    }
}

/// What is gathered of a channel that comes in blocks.
#[derive(Debug, Clone)]
pub(super) struct FactPass {
    /// Samples of a block mean.
    block: usize,
    samples: usize,
    present: usize,
    /// The first finite value, and whether all others are that.
    first: Option<f64>,
    changed: bool,
    /// Sum and number of the finite values of the block that goes on.
    sum: f64,
    count: usize,
    /// Its lowest and highest value.
    bottom: f64,
    top: f64,
    blocks: Vec<f64>,
    ends: Ends,
}

impl FactPass {
    pub(super) fn new(step_s: f64) -> Self {
        Self {
            block: block_samples(step_s),
            samples: 0,
            present: 0,
            first: None,
            changed: false,
            sum: 0.0,
            count: 0,
            bottom: f64::INFINITY,
            top: f64::NEG_INFINITY,
            blocks: Vec::new(),
            ends: Ends::default(),
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.samples == 0
    }

    pub(super) fn add(&mut self, values: &[f64]) {
        for v in values {
            if v.is_finite() {
                self.bottom = self.bottom.min(*v);
                self.top = self.top.max(*v);
                self.ends.highest.add(*v);
                self.sum += v;
                self.count += 1;
                self.changed |= *v != *self.first.get_or_insert(*v);
            }
            self.samples += 1;
            if self.samples.is_multiple_of(self.block) {
                self.end_block();
            }
        }
    }

    fn end_block(&mut self) {
        // In their order, so that the sum is that of `means` to the last bit.
        self.blocks.push(self.sum / self.count as f64);
        self.ends.of_blocks.push((self.bottom, self.top));
        self.present += self.count;
        (self.sum, self.count) = (0.0, 0);
        (self.bottom, self.top) = (f64::INFINITY, f64::NEG_INFINITY);
    }

    /// Block means with the number that stands for no value, share of samples with one, the one value.
    fn finish(mut self, channel: Channel) -> ((Vec<f64>, Option<Filler>), f64, Option<f64>) {
        if !self.samples.is_multiple_of(self.block) {
            self.end_block();
        }
        let filler = self.ends.blank(channel, &mut self.blocks);
        let constant = self.first.filter(|_| !self.changed);
        (
            (self.blocks, filler),
            self.present as f64 / self.samples.max(1) as f64,
            constant.filter(|_| self.present >= FEWEST),
        )
    }
}

/// The ends of a pressure.
#[derive(Debug, Clone, Default)]
struct Ends {
    /// The lowest and highest value of each block.
    of_blocks: Vec<(f64, f64)>,
    /// The highest of all.
    highest: Highest,
}

impl Ends {
    /// Takes in the next block.
    fn add(&mut self, block: &[f64]) {
        // In lanes: none waits for the one before.
        const LANES: usize = 4;
        let (mut low, mut high) = ([f64::INFINITY; LANES], [f64::NEG_INFINITY; LANES]);
        let (lanes, rest) = block.as_chunks::<LANES>();
        let mut last = [f64::NAN; LANES];
        last[..rest.len()].copy_from_slice(rest);
        for values in lanes.iter().chain([&last]) {
            for (k, v) in values.iter().copied().enumerate() {
                low[k] = if (v < low[k]) & (v >= f64::MIN) {
                    v
                } else {
                    low[k]
                };
                high[k] = if (v > high[k]) & (v <= f64::MAX) {
                    v
                } else {
                    high[k]
                };
            }
        }
        let bottom = low.into_iter().fold(f64::INFINITY, f64::min);
        let top = high.into_iter().fold(f64::NEG_INFINITY, f64::max);
        self.of_blocks.push((bottom, top));
        self.highest.add_all(block, top);
    }

    /// Takes the means of a pressure that are none: those with the number that stands for no value, which is given back, and those with a value below
    /// vacuum, a logger's code, if they are not most: a wrong sign or zero is to be told.
    fn blank(&self, channel: Channel, blocks: &mut [f64]) -> Option<Filler> {
        if !is_pressure(channel) {
            return None;
        }
        let filler = self.highest.filler(channel);
        let coded = self.of_blocks.iter().filter(|(bottom, _)| *bottom < 0.0);
        let some = 2 * coded.count() <= blocks.len();
        for (mean, (bottom, top)) in blocks.iter_mut().zip(&self.of_blocks) {
            if filler.is_some_and(|filler| *top == filler.value) || (some && *bottom < 0.0) {
                *mean = f64::NAN;
            }
        }
        filler
    }
}

fn block_samples(step_s: f64) -> usize {
    crate::options::samples(BLOCK_S, step_s, BLOCK_SAMPLES)
}

/// Blocks that are summed at once: a sum in its own order waits for itself, several do not wait for each other.
const BESIDE: usize = 8;

/// [`mean`] of each block of up to [`BESIDE`].
fn means(values: &[f64], block: usize) -> impl Iterator<Item = (f64, usize)> {
    let mut sums = [0.0; BESIDE];
    if values.len() == BESIDE * block {
        for i in 0..block {
            for (k, sum) in sums.iter_mut().enumerate() {
                *sum += values[k * block + i];
            }
        }
    } else {
        for (part, sum) in values.chunks(block).zip(&mut sums) {
            *sum = part.iter().fold(0.0, |sum, v| sum + v);
        }
    }
    let parts = values.chunks(block).zip(sums);
    parts.map(|(part, sum)| mean(part, sum))
}

/// Mean of the finite values, and how many they are; `sum` is that of all.
fn mean(values: &[f64], sum: f64) -> (f64, usize) {
    // Most blocks are whole, which their sum tells without a look at each value.
    if sum.is_finite() {
        return (sum / values.len() as f64, values.len());
    }
    let finite = values.iter().filter(|v| v.is_finite());
    let (sum, count) = finite.fold((0.0, 0), |(sum, count), v| (sum + v, count + 1));
    (sum / count as f64, count)
}

/// Fewer samples are no evidence of one value throughout.
const FEWEST: usize = 10;

/// The value that every finite sample has; `None` for fewer than ten.
fn constant(values: &[f64]) -> Option<f64> {
    let mut finite = values.iter().filter(|v| v.is_finite());
    let first = *finite.next()?;
    let mut count = 1;
    for value in finite {
        if *value != first {
            return None;
        }
        count += 1;
    }
    (count >= FEWEST).then_some(first)
}

/// Median of the finite values; NaN if there are none.
pub(super) fn median(values: impl Iterator<Item = f64>) -> f64 {
    dgd_recording::quantile(values, Rank::MEDIAN).unwrap_or(f64::NAN)
}

/// Quantile of the finite values; NaN if there are none.
pub(super) fn quantile(values: impl Iterator<Item = f64>, share: f64) -> f64 {
    dgd_recording::quantile(values, Rank::Nearest(share)).unwrap_or(f64::NAN)
}

pub(super) fn source_of(well: &Well, channel: Channel) -> Option<&ChannelSource> {
    let map = &well.channels;
    match channel {
        Channel::MudPumpFlow => Some(&map.mud_pump_flow),
        Channel::BoosterFlow => Some(&map.booster_flow),
        Channel::TopfillFlow => Some(&map.topfill_flow),
        Channel::ReturnFlow => Some(&map.return_flow),
        Channel::PumpInletPressure(n) => map.pump_inlet_pressure.get(n),
        Channel::PumpOutletPressure(n) => map.pump_outlet_pressure.get(n),
        Channel::RiserPressure => map.riser_pressure.as_ref(),
        Channel::PumpSpeed => Some(&map.pump_speed),
    }
}

/// Flows into the riser, which may be steady for days.
pub(super) fn feeds(channel: Channel) -> bool {
    is_flow(channel) && channel != Channel::ReturnFlow
}

pub(super) fn is_flow(channel: Channel) -> bool {
    channel.dimension() == Dimension::FlowRate
}
