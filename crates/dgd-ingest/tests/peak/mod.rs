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
    peak_of(|| read(bytes, &ReadOptions::default()))
}

/// What the work gives, and bytes allocated at the same time meanwhile.
pub(crate) fn peak_of<T>(work: impl FnOnce() -> T) -> (T, usize) {
    let before = MEMORY.current_usage();
    MEMORY.reset_peak_usage();
    let given = work();
    (given, MEMORY.peak_usage() - before)
}
