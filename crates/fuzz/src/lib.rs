//! What the fuzz targets run: a user's call on bytes that nobody vouches for.
//!
//! [`recording`] and [`documents`] say what must hold; the targets in `fuzz_targets/` are named after the
//! formats. Memory is counted by the allocator, so that every execution is held to the documented limit.

pub mod documents;
pub mod recording;

use dgd_ingest::Format;
use libfuzzer_sys::Corpus;
use peak_alloc::PeakAlloc;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Reads a recording to the product's structure, within its memory.
///
/// # Panics
/// If something of [`recording`] does not hold.
pub fn run_recording(bytes: &[u8], format: Format) -> Corpus {
    let before = MEMORY.current_usage();
    MEMORY.reset_peak_usage();
    let table = recording::table(bytes, format);
    let taken = MEMORY.peak_usage().saturating_sub(before);
    let most = recording::most_memory(format, bytes.len());
    assert!(
        taken <= most,
        "{taken} bytes were taken for {}, at most {most} may be",
        bytes.len()
    );
    if let Some(whole) = &table {
        recording::in_blocks(bytes, whole);
    }
    match table {
        None => return Corpus::Reject,
        Some(Ok(table)) => recording::structure(table),
        Some(Err(_)) => {}
    }
    Corpus::Keep
}

/// Reads a document, writes it and reads it again.
///
/// # Panics
/// If `holds` panics, or takes more than 32 MiB and 2000 bytes for each of the text.
pub fn run_document(bytes: &[u8], holds: fn(&str) -> bool) -> Corpus {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return Corpus::Reject;
    };
    let before = MEMORY.current_usage();
    MEMORY.reset_peak_usage();
    holds(text);
    let taken = MEMORY.peak_usage().saturating_sub(before);
    let most = (32 << 20) + 2000 * bytes.len();
    assert!(
        taken <= most,
        "{taken} bytes were taken for {}, at most {most} may be",
        bytes.len()
    );
    Corpus::Keep
}
