//! A survey of a table that is longer than memory.

use super::{ColumnPass, Selection, TableSurvey, find_time, summary, time_factor};
use crate::clock::ClockPasses;
use crate::{Column, Table};

/// Values that all columns together may hold for their medians.
const HELD: usize = 1 << 21;
/// Those of one column.
const HELD_OF_ONE: usize = 1 << 17;

/// The survey of a table that comes in blocks, which are gone through as often as it asks for: two or three times
/// where the stamps are whole seconds one step apart, as a rule some six where they are not.
///
/// What it finds is what [`crate::survey`] finds in the whole table. Its memory does not grow with the
/// recording, but for the stamps of a clock that runs backwards, which must be put in order, and the list of
/// a clock's gaps.
///
/// ```
/// use dgd_recording::{BlockSurvey, Column, Table};
/// let block = |values: &[f64]| Table {
///     columns: vec![Column { tag: "t".into(), unit: Some("s".into()), values: values.to_vec() }],
///     ..Table::default()
/// };
/// let mut survey = BlockSurvey::new(&block(&[]));
/// loop {
///     survey.add(&block(&[0.0, 1.0]));
///     survey.add(&block(&[2.0, 4.0]));
///     if !survey.next_pass() {
///         break;
///     }
/// }
/// let found = survey.finish();
/// assert_eq!(found.columns[0].range, Some((0.0, 2.0, 4.0)));
/// assert_eq!(found.clock.unwrap().unwrap().gaps.len(), 1);
/// ```
#[derive(Debug)]
pub struct BlockSurvey {
    heads: Vec<Column>,
    passes: Vec<ColumnPass>,
    medians: Vec<Selection>,
    /// Columns whose median is not known yet.
    open: Vec<usize>,
    first: bool,
    time: Option<Time>,
}

#[derive(Debug)]
struct Time {
    index: usize,
    factor: f64,
    clock: ClockPasses,
    more: bool,
}

impl BlockSurvey {
    /// For blocks with the columns of `head`, whose values are left out.
    pub fn new(head: &Table) -> Self {
        let columns = head.columns.len();
        let room = HELD_OF_ONE.min(HELD / columns.max(1));
        Self {
            heads: (head.columns.iter())
                .map(|c| Column {
                    tag: c.tag.clone(),
                    unit: c.unit.clone(),
                    values: Vec::new(),
                })
                .collect(),
            passes: vec![ColumnPass::default(); columns],
            medians: vec![Selection::new(room); columns],
            open: (0..columns).collect(),
            first: true,
            time: None,
        }
    }

    /// Takes the next rows.
    pub fn add(&mut self, block: &Table) {
        if self.first {
            for (pass, column) in self.passes.iter_mut().zip(&block.columns) {
                pass.add(&column.values);
            }
        }
        for index in &self.open {
            if let Some(column) = block.columns.get(*index) {
                let finite = column.values.iter().filter(|v| v.is_finite());
                finite.for_each(|v| self.medians[*index].add(*v));
            }
        }
        if let Some(time) = self.time.as_mut().filter(|time| time.more)
            && let Some(column) = block.columns.get(time.index)
        {
            let time_s: Vec<f64> = column.values.iter().map(|t| t * time.factor).collect();
            time.clock.add(&time_s);
        }
    }

    /// Ends a pass over the blocks; says whether they must come again.
    pub fn next_pass(&mut self) -> bool {
        let Self { open, medians, .. } = self;
        open.retain(|index| medians[*index].next_pass());
        if let Some(time) = &mut self.time {
            time.more = time.more && time.clock.next_pass();
        }
        if self.first {
            self.first = false;
            self.time = self.find_time();
        }
        !self.open.is_empty() || self.time.as_ref().is_some_and(|time| time.more)
    }

    /// The clock is looked at from the second pass on, for the first one may be what finds it.
    fn find_time(&self) -> Option<Time> {
        let columns = self.summaries();
        let index = find_time(&columns, |index| self.passes[index].increases())?;
        Some(Time {
            index,
            factor: time_factor(&columns[index]),
            clock: ClockPasses::new(self.passes[index].samples),
            more: true,
        })
    }

    fn summaries(&self) -> Vec<super::ColumnSurvey> {
        let parts = self.heads.iter().zip(&self.passes).zip(&self.medians);
        parts
            .map(|((head, pass), median)| summary(head, pass, median.found()))
            .collect()
    }

    /// The column taken for the clock, known from the first pass on.
    pub fn time_column(&self) -> Option<usize> {
        self.time.as_ref().map(|time| time.index)
    }

    /// What was found, once [`BlockSurvey::next_pass`] has said that no other pass is needed.
    pub fn finish(self) -> TableSurvey {
        TableSurvey {
            columns: self.summaries(),
            time_column: self.time_column(),
            clock: self.time.map(|time| time.clock.finish()),
        }
    }
}
