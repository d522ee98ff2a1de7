//! A recording on its even clock that is longer than memory.

use super::mapping::Origin;
use super::{Recording, RecordingError};
use crate::clock::ClockPasses;
use crate::{ClockSurvey, Column, Issue, Table, TimeSource, Well};

/// The channels of a table that comes in blocks, on their even clock: what [`Recording::from_table`] and
/// [`Recording::onto_grid`] make of the table at once, to the last bit.
///
/// The blocks are gone through once where the stamps are whole seconds one step apart, as a rule some five times where they are
/// not, to find the clock; then as often as the caller wants. Memory does not grow with the recording, but
/// for the list of the clock's gaps. Samples that must be put in order are not: see [`Self::is_in_order`].
///
/// ```
/// use dgd_recording::{BlockGrid, Table, Well};
/// # use dgd_recording::{Recording, RecordingError};
/// fn samples(head: &Table, rows: usize, blocks: &[Table], well: &Well) -> Result<usize, RecordingError> {
///     let mut grid = BlockGrid::new(head, rows, well)?;
///     loop {
///         blocks.iter().for_each(|block| grid.add(block));
///         if !grid.next_pass()? {
///             break;
///         }
///     }
///     let mut samples = 0;
///     for block in blocks {
///         grid.each(block, |part| Ok::<(), RecordingError>(samples += part.len()))?;
///     }
///     assert_eq!(samples, grid.samples());
///     Ok(samples)
/// }
/// ```
#[derive(Debug)]
pub struct BlockGrid<'w> {
    well: &'w Well,
    origin: Origin,
    mapping: Vec<Issue>,
    /// The columns that the well names.
    named: Vec<usize>,
    passes: Option<ClockPasses>,
    clock: Option<ClockSurvey>,
    /// Steps of the clock that samples have been given for.
    given: usize,
}

/// Most samples without values that are given at a time.
const GAP: usize = 1 << 16;

impl<'w> BlockGrid<'w> {
    /// For blocks with the columns of `head`, whose values are left out, and so many rows in all.
    ///
    /// # Errors
    /// [`RecordingError::OffClock`] for a channel with late stamps, and those of [`Recording::from_table`].
    pub fn new(head: &Table, rows: usize, well: &'w Well) -> Result<Self, RecordingError> {
        if let Some(channel) = well.channels.off_clock() {
            return Err(RecordingError::OffClock { channel });
        }
        let row = |column: &Column| Column {
            values: vec![f64::NAN],
            ..column.clone()
        };
        let one = Table {
            columns: head.columns.iter().map(row).collect(),
            clock: head.clock,
            ..Table::default()
        };
        let (_, mapping) = Recording::from_table(one, well)?;
        if rows == 0 {
            return Err(RecordingError::Empty);
        }
        Ok(Self {
            well,
            origin: Origin::default(),
            mapping,
            named: named(head, well),
            passes: Some(ClockPasses::new(rows)),
            clock: None,
            given: 0,
        })
    }

    /// Takes the next rows' stamps.
    pub fn add(&mut self, block: &Table) {
        let stamps = match &self.well.channels.time {
            TimeSource::Column { tag, unit } => {
                let column = block.find(tag);
                let mut stamps =
                    column.map_or_else(Vec::new, |at| block.columns[at].values.clone());
                let unit = column.map_or(*unit, |at| block.time_unit(at, *unit));
                self.origin.shift(&mut stamps, unit);
                stamps
            }
            TimeSource::Interval { step_s } => self.origin.even(block.rows(), *step_s),
        };
        if let Some(passes) = &mut self.passes {
            passes.add(&stamps);
        }
    }

    /// Ends a pass over the stamps; says whether they must come again.
    ///
    /// # Errors
    /// [`RecordingError::Clock`] if there is no clock to be found.
    pub fn next_pass(&mut self) -> Result<bool, RecordingError> {
        self.rewind();
        if self.passes.as_mut().is_some_and(ClockPasses::next_pass) {
            return Ok(true);
        }
        if let Some(passes) = self.passes.take() {
            self.clock = Some(passes.finish()?);
        }
        Ok(false)
    }

    /// Goes back to the first row.
    pub fn rewind(&mut self) {
        self.origin = Origin::default();
        self.given = 0;
    }

    /// Whether the samples are in the order of their stamps. Only then they can be given block by block.
    pub fn is_in_order(&self) -> bool {
        self.clock.as_ref().is_some_and(|clock| clock.backward == 0)
    }

    /// Step of the even clock, s; NaN before it is known.
    pub fn step_s(&self) -> f64 {
        self.clock.as_ref().map_or(f64::NAN, |clock| clock.step_s)
    }

    /// Samples on the even clock; 0 before it is known.
    pub fn samples(&self) -> usize {
        self.clock.as_ref().map_or(0, ClockSurvey::steps)
    }

    /// First and last second on the even clock.
    pub fn span_s(&self) -> (f64, f64) {
        match &self.clock {
            None => (f64::NAN, f64::NAN),
            Some(clock) if clock.even => clock.span_s,
            Some(clock) => (clock.span_s.0, at(clock, clock.steps().saturating_sub(1))),
        }
    }

    /// What was wrong with the columns, then with the clock.
    pub fn issues(&self) -> Vec<Issue> {
        let clock = self.clock.iter().filter(|clock| !clock.even);
        let clock = clock.flat_map(ClockSurvey::issues);
        self.mapping.iter().cloned().chain(clock).collect()
    }

    /// Gives the samples of the next rows, in one part or, around gaps, in several.
    ///
    /// # Errors
    /// [`RecordingError::NoClockYet`] while [`Self::next_pass`] still asks for the stamps, [`RecordingError::OutOfOrder`] unless
    /// [`Self::is_in_order`]; what `take` returns, and those of [`Recording::from_table`].
    pub fn each<E: From<RecordingError>>(
        &mut self,
        block: &Table,
        mut take: impl FnMut(Recording) -> Result<(), E>,
    ) -> Result<(), E> {
        let clock = self.clock.as_ref().ok_or(RecordingError::NoClockYet)?;
        if clock.backward > 0 {
            return Err(RecordingError::OutOfOrder.into());
        }
        if block.rows() == 0 {
            return Ok(());
        }
        let named = self.named.iter().filter_map(|n| block.columns.get(*n));
        let named = Table {
            columns: named.cloned().collect(),
            clock: (block.clock).and_then(|clock| self.named.iter().position(|n| *n == clock)),
            ..Table::default()
        };
        let (rows, _) = Recording::from_rows(named, self.well, &mut self.origin)?;
        if clock.even {
            self.given += rows.len();
            return take(rows);
        }
        let steps = clock.steps();
        let mut sources = Vec::with_capacity(rows.len());
        for (row, stamp) in rows.time_s.iter().enumerate() {
            let step = clock.step_of(*stamp).filter(|_| stamp.is_finite());
            // Of samples of one step the first is taken.
            let Some(step) = step.filter(|step| *step >= self.given && *step < steps) else {
                continue;
            };
            while self.given < step {
                sources.push(None);
                self.given += 1;
                if sources.len() >= GAP {
                    take(rows.picked(&sources, clock, self.given))?;
                    sources.clear();
                }
            }
            sources.push(Some(row));
            self.given += 1;
        }
        if sources.is_empty() {
            return Ok(());
        }
        take(rows.picked(&sources, clock, self.given))
    }
}

/// Indices of the columns that a well names, in their order, and of the first, which tells the rows where it names none.
fn named(head: &Table, well: &Well) -> Vec<usize> {
    let map = &well.channels;
    let stamps = match &map.time {
        TimeSource::Column { tag, .. } => Some(tag.as_str()),
        TimeSource::Interval { .. } => None,
    };
    let tags = map.tags().into_iter().map(|(_, tag)| tag);
    let found = tags.chain(stamps).filter_map(|tag| head.find(tag));
    let mut named: Vec<usize> = found.chain([0]).collect();
    named.sort_unstable();
    named.dedup();
    named
}

/// Second of a step of the even clock.
fn at(clock: &ClockSurvey, step: usize) -> f64 {
    clock.span_s.0 + step as f64 * clock.step_s
}

impl Recording {
    /// These rows, or NaN, on the steps of the clock before `end`.
    fn picked(&self, sources: &[Option<usize>], clock: &ClockSurvey, end: usize) -> Self {
        let time_s = (end - sources.len()..end).map(|i| at(clock, i)).collect();
        self.map_channels(time_s, |values| {
            let row = |s: &Option<usize>| s.map_or(f64::NAN, |row| values[row]);
            sources.iter().map(row).collect()
        })
    }
}
