//! What a command works on: recordings, and a well or a system.

use super::Window;
use clap::Args;
use std::path::{Path, PathBuf};

/// The recordings and the well they were taken on.
#[derive(Debug, Args)]
pub(crate) struct Source {
    /// Recordings in time order: MAT v5 or v7.3, CSV or MCAP
    #[arg(required = true)]
    pub(crate) recordings: Vec<PathBuf>,
    /// The well description
    #[arg(long, value_name = "FILE")]
    pub(crate) well: PathBuf,
    /// Screen as in the thesis: reject long runs at one speed, keep pump restarts
    #[arg(long)]
    pub(crate) thesis_screening: bool,
    /// Only these seconds of the recording clock (3h:5h and 90min:2h too), or only between two dates
    /// (2024-10-26T03:00/05:00); all if absent
    #[arg(long, value_name = "FROM:TO", value_parser = Window::parse, allow_hyphen_values = true)]
    pub(crate) window: Option<Window>,
}

/// What the recordings were taken on.
#[derive(Debug, Clone, Args)]
#[group(required = true, multiple = false)]
pub(crate) struct Described {
    /// Well description, for the return-line model
    #[arg(long, value_name = "FILE")]
    pub(crate) well: Option<PathBuf>,
    /// The description of any system by its components, or the file written by a fit
    #[arg(long, value_name = "FILE")]
    pub(crate) system: Option<PathBuf>,
}

/// Recordings, and a well or a system.
#[derive(Debug, Clone, Args)]
pub(crate) struct AnySource {
    /// Recordings in time order: MAT v5 or v7.3, CSV or MCAP; one with --system
    #[arg(required = true)]
    pub(crate) recordings: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) described: Described,
    /// Screen as in the thesis: reject long runs at one speed, keep pump restarts
    #[arg(long, conflicts_with = "system")]
    pub(crate) thesis_screening: bool,
    /// Only these seconds of the recording clock (3h:5h and 90min:2h too), or only between two dates
    /// (2024-10-26T03:00/05:00); default: all. A system names its windows in its file
    #[arg(long, value_name = "FROM:TO", value_parser = Window::parse, allow_hyphen_values = true, conflicts_with = "system")]
    pub(crate) window: Option<Window>,
}

/// What a command works on.
pub(crate) enum Subject<'a> {
    /// The built-in return line.
    Well(Source),
    /// A system of any components: its description and the recordings.
    System(&'a Path, &'a [PathBuf]),
}

impl AnySource {
    pub(crate) fn subject(&self) -> Subject<'_> {
        match &self.described {
            Described {
                system: Some(system),
                ..
            } => Subject::System(system, &self.recordings),
            Described { well, .. } => Subject::Well(Source {
                recordings: self.recordings.clone(),
                // One of the two is required.
                well: well.clone().unwrap_or_default(),
                thesis_screening: self.thesis_screening,
                window: self.window.clone(),
            }),
        }
    }
}
