//! MAT v5 files, as MATLAB (`-v6`, `-v7`), Octave and SciPy write them.
//!
//! Compressed variables are inflated straight into their columns: beside the
//! columns, reading needs three buffers of 256 KiB. Structs, struct arrays and cells are
//! walked; every numeric class in every stored type becomes columns of doubles.
//! A checksum covers each compressed variable as a whole, so that a damaged one is
//! left out as a whole; of a truncated one the complete fields are kept.

mod inflate;
mod matrix;
mod source;

use std::thread;

use dgd_recording::{IssueKind, Table};

use crate::error::IngestError;
use crate::mat::{Collector, Fault, FaultKind, Mark};
use matrix::{Walk, element_tag};
use source::Source;

const FORMAT: &str = "MAT v5";
const HEADER: usize = 128;
const MI_MATRIX: u32 = 14;
const MI_COMPRESSED: u32 = 15;

/// Whether this may be a MAT v4 file, which has no header text.
///
/// It opens with a four-digit type number (byte order, 0, number type, array type),
/// then the rows, the columns, an imaginary flag and the length of the name.
pub(crate) fn is_mat4(bytes: &[u8]) -> bool {
    let Some((words, _)) = bytes.get(..20).map(<[u8]>::as_chunks::<4>) else {
        return false;
    };
    [u32::from_le_bytes, u32::from_be_bytes]
        .into_iter()
        .any(|read| {
            let [kind, rows, columns, imaginary, name] = [0, 1, 2, 3, 4].map(|i| read(words[i]));
            let digits = [kind / 1000, kind / 100 % 10, kind / 10 % 10, kind % 10];
            digits[0] <= 4
                && digits[1] == 0
                && digits[2] <= 5
                && digits[3] <= 2
                && imaginary <= 1
                && (2..=64).contains(&name)
                && rows.max(columns) > 0
                && rows.max(columns) < 1 << 28
        })
}

/// Reads every numeric variable of a MAT v5 file.
///
/// # Errors
/// [`IngestError::Empty`], else what kept the file from giving a single column.
pub(crate) fn read(bytes: &[u8]) -> Result<Table, IngestError> {
    if bytes.is_empty() {
        return Err(IngestError::Empty);
    }
    let header = bytes.get(..HEADER);
    let big_endian = match header.map(|h| &h[126..]) {
        Some(b"IM") => false,
        Some(b"MI") => true,
        None => {
            return Err(Fault::truncated(
                format!("byte {}", bytes.len()),
                "the header needs 128 bytes",
            )
            .into_error(FORMAT));
        }
        Some(found) => {
            return Err(Fault::damaged(
                "byte 126",
                format!(
                    "the byte order mark is {:02x} {:02x}, expected `IM` or `MI`",
                    found[0], found[1]
                ),
            )
            .into_error(FORMAT));
        }
    };
    let version: &[u8] = if big_endian { &[2, 0] } else { &[0, 2] };
    if &bytes[124..126] == version {
        return Err(Fault::damaged(
            "byte 512",
            "the header says MAT v7.3, but no HDF5 signature follows",
        )
        .into_error("MAT v7.3"));
    }
    let mut collector = Collector::new(FORMAT, bytes.len());
    elements(bytes, big_endian, &mut collector);
    collector.finish()
}

/// Walks the top-level elements.
fn elements(bytes: &[u8], big_endian: bool, collector: &mut Collector) {
    let mut at = HEADER;
    while at < bytes.len() {
        let Some(tag) = bytes.get(at..at + 8) else {
            collector.fault(
                Fault::truncated(format!("byte {at}"), "half an element tag is left"),
                "nothing else was lost",
            );
            return;
        };
        if tag == [0; 8] {
            // Padding that some writers leave at the end.
            at += 8;
            continue;
        }
        let (kind, length) = element_tag(tag, big_endian);
        let start = at + 8;
        let left = &bytes[start..];
        let length = usize::try_from(length).unwrap_or(usize::MAX);
        let cut_short = length > left.len();
        let data = &left[..length.min(left.len())];
        let mark = collector.mark();
        match kind {
            MI_MATRIX | MI_COMPRESSED => {}
            1..=13 | 16..=18 => {
                collector.skip(
                    &format!("element at byte {at}"),
                    "it stands outside a variable",
                );
                at = next(start, length, kind);
                continue;
            }
            _ => {
                collector.fault(
                    Fault::damaged(
                        format!("byte {at}"),
                        format!("element type {kind} is unknown, expected 14 or 15"),
                    ),
                    "the rest of the file was left out",
                );
                return;
            }
        }
        let (result, reached, complete) = thread::scope(|scope| {
            let mut source = match kind {
                MI_MATRIX => Source::plain(data, start),
                _ => Source::deflated(data, start, cut_short, scope),
            };
            let mut walk = Walk {
                collector: &mut *collector,
                source: &mut source,
                big_endian,
                reached: String::new(),
                cut_short,
                complete: false,
            };
            let result = match kind {
                MI_MATRIX => walk.variable(length as u64),
                _ => walk.compressed(),
            };
            (result, walk.reached, walk.complete)
        });
        match result {
            Err(fault) if complete && fault.kind == FaultKind::Truncated => collector.issue(
                IssueKind::Truncated,
                fault.place,
                "the file ends within the checksum; all values were kept, unchecked",
            ),
            Err(fault) => left_out(collector, fault, &reached, mark, kind),
            Ok(()) if cut_short => collector.issue(
                IssueKind::Truncated,
                format!("byte {}", bytes.len()),
                "the last element claims more bytes than the file has; its values are complete",
            ),
            Ok(()) => {}
        }
        at = next(start, length, kind);
    }
}

/// Tells of trouble inside a variable, and drops what can no longer be trusted.
fn left_out(collector: &mut Collector, mut fault: Fault, reached: &str, mark: Mark, kind: u32) {
    let name = if reached.is_empty() {
        "the variable".to_owned()
    } else {
        format!("`{reached}`")
    };
    fault.place = format!("{} ({name})", fault.place);
    let consequence = if fault.kind == FaultKind::Damaged && kind == MI_COMPRESSED {
        let dropped = collector.roll_back(mark);
        let others = match dropped {
            0 => String::new(),
            n => format!(", with {n} columns before it that no checksum covers"),
        };
        format!("the whole variable was left out{others}")
    } else {
        let kept = collector.columns_since(mark);
        format!("it was left out, with the rest of its variable; {kept} columns before it kept")
    };
    collector.fault(fault, &consequence);
}

/// Where the element after this one begins: all but compressed ones are padded to 8 bytes.
fn next(start: usize, length: usize, kind: u32) -> usize {
    let end = start.saturating_add(length);
    if kind == MI_COMPRESSED {
        end
    } else {
        end.checked_next_multiple_of(8).unwrap_or(usize::MAX)
    }
}
