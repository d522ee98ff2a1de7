//! Counts what the process allocates, so that each user of it is a test binary of its own.

use dgd_ingest::{Format, IngestError, ReadOptions, read};
use dgd_recording::Table;
use peak_alloc::PeakAlloc;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

#[allow(dead_code, reason = "not every user counts in it")]
pub(crate) const MIB: usize = 1 << 20;

/// What reading says, and bytes allocated at the same time meanwhile.
pub(crate) fn peak(bytes: &[u8]) -> (Result<(Format, Table), IngestError>, usize) {
    let before = MEMORY.current_usage();
    MEMORY.reset_peak_usage();
    let said = read(bytes, &ReadOptions::default());
    (said, MEMORY.peak_usage() - before)
}
