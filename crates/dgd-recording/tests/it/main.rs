//! Claims about recordings, clocks and tables nobody has described.
#![allow(clippy::unwrap_used, reason = "a test may fail by panic")]
mod blocks;
mod few;
mod grid;
mod grid_blocks;
mod mapping;
mod propose;
mod robust;
mod survey;
mod wells;
