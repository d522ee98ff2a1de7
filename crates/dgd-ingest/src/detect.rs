//! What a file is, by its first bytes.

use crate::{Format, IngestError};

/// Bytes from the start of a file that are enough for [`detect`].
pub(crate) const BYTES: u64 = (512 << USER_BLOCKS) + 8;
/// An HDF5 file may have a foreign block before it, of 512 bytes doubled so often.
const USER_BLOCKS: usize = 11;

/// Tells the format from the content; names and extensions do not count.
///
/// Text of any sort is taken for CSV; whether it is a table shows when it is read.
///
/// # Errors
/// [`IngestError::Empty`], [`IngestError::Unsupported`] for a known format that is not
/// read, [`IngestError::Unrecognised`] for other binary content.
pub fn detect(bytes: &[u8]) -> Result<Format, IngestError> {
    const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";
    if bytes.is_empty() {
        return Err(IngestError::Empty);
    }
    if bytes.starts_with(b"\x89MCAP0\r\n") {
        return Ok(Format::Mcap);
    }
    let mut starts = (0..=USER_BLOCKS).map(|doublings| 512_usize << doublings);
    let at = |start: usize| bytes.get(start..).is_some_and(|b| b.starts_with(HDF5));
    if at(0) || starts.any(at) {
        return Ok(Format::Mat73);
    }
    let version = bytes.get(124..128);
    if matches!(version, Some([0, 1, b'I', b'M'] | [1, 0, b'M', b'I'])) {
        return Ok(Format::Mat5);
    }
    if bytes.starts_with(b"MATLAB 5.0 MAT-file") {
        return Ok(Format::Mat5); // damaged header; the reader says where
    }
    if let Some((format, mend)) = known_but_unread(bytes) {
        return Err(IngestError::Unsupported { format, mend });
    }
    let head = &bytes[..bytes.len().min(4096)];
    let zeros_end = head.iter().rposition(|b| *b != 0).map_or(0, |n| n + 1);
    let head = &head[..zeros_end];
    let utf16 = bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]);
    let control = |b: &&u8| b.is_ascii_control() && !b.is_ascii_whitespace();
    let odd = head.iter().filter(control).count();
    let nulls = head.iter().filter(|b| **b == 0).count();
    // UTF-16 without its mark is text of which every other byte is zero.
    let like_utf16 = nulls * 3 > head.len() && odd == nulls && head.iter().any(u8::is_ascii_digit);
    if utf16 || like_utf16 || odd * 20 <= head.len() {
        return Ok(Format::Csv);
    }
    Err(unrecognised(bytes))
}

pub(crate) fn unrecognised(bytes: &[u8]) -> IngestError {
    let shown: Vec<String> = bytes.iter().take(16).map(|b| format!("{b:02x}")).collect();
    IngestError::Unrecognised {
        first_bytes: shown.join(" "),
    }
}

fn known_but_unread(bytes: &[u8]) -> Option<(&'static str, &'static str)> {
    const KNOWN: [(&[u8], &str, &str); 11] = [
        (
            b"PK\x03\x04",
            "a ZIP archive or a spreadsheet",
            "unpack it, or save the sheet as CSV",
        ),
        (b"\x1f\x8b", "gzip", "unpack it first"),
        (b"\x28\xb5\x2f\xfd", "zstd", "unpack it first"),
        (b"BZh", "bzip2", "unpack it first"),
        (b"\xfd7zXZ\0", "xz", "unpack it first"),
        (
            b"\xd0\xcf\x11\xe0",
            "an old spreadsheet (XLS)",
            "save the sheet as CSV",
        ),
        (b"PAR1", "Parquet", "export it to CSV"),
        (b"TDSm", "TDMS", "export it to CSV or MAT"),
        (
            b"#ROSBAG",
            "a ROS bag",
            "convert it to MCAP with JSON messages",
        ),
        (b"MDF     ", "MDF", "export it to MAT"),
        (b"%PDF", "PDF", "export the data as CSV"),
    ];
    let known = KNOWN.iter().find(|(magic, ..)| bytes.starts_with(magic));
    if let Some((_, format, mend)) = known {
        return Some((format, mend));
    }
    crate::mat5::is_mat4(bytes).then_some(("MAT v4", "save it again with `-v7` or `-v7.3`"))
}
