//! A rig recording in SI units on one clock, the raw table it came from, and
//! the well it was taken on.
//!
//! Readers produce a [`Table`]: columns as the file has them. A [`Well`] says
//! which column is which channel, in which unit. [`Recording::from_table`] joins
//! the two, and [`Recording::onto_grid`] puts the samples on an even clock.
//! [`survey`] and [`propose_channels`] look at a table that nobody has described yet.
//! This crate opens no file and prints nothing.
#![deny(missing_docs)]

mod clock;
mod events;
mod few;
mod moment;
mod order;
mod origin;
mod propose;
mod readings;
mod recording;
mod settle;
mod survey;
mod table;
mod well;

pub use clock::{ClockError, ClockSurvey, Gap, Uneven, check_even, odd_step, survey_clock};
pub use events::Events;
pub use few::ReadingSurvey;
pub use moment::Moment;
pub use order::{Rank, quantile};
pub use origin::{days_from_1970, rfc3339, zone_offset_s};
pub use propose::{Proposal, ProposedChannel, propose_channels};
pub use readings::{SLOWEST_S, draw_line, held_for, readings};
pub use recording::{
    Absent, BlockGrid, Channel, Recording, RecordingError, STANDING_M3_S, Unequal,
};
pub use settle::Settle;
pub use survey::{BlockSurvey, ColumnSurvey, Run, TableSurvey, is_clock_name, quantum, survey};
pub use table::{Column, Issue, IssueKind, Table};
pub use well::{
    Added, ChannelError, ChannelMap, ChannelSource, Geometry, TimeSource, Well, WellError,
};

/// The example of the README compiles.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
