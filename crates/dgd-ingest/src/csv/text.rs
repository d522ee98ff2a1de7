//! Bytes to lines and cells.

use crate::IngestError;
use crate::csv::MAX_COLUMNS;
use dgd_recording::{Issue, IssueKind};
use std::borrow::Cow;

/// A quoted cell may run over this many lines; a quote that is never closed then costs
/// one line, not the rest of the file.
const QUOTED_LINES: u32 = 8;

/// The text of a file, without byte order mark and without zeros at its end.
///
/// # Errors
/// [`IngestError`] for an empty file, UTF-16 and bytes that are no text.
pub(super) fn decode<'a>(
    bytes: &'a [u8],
    issues: &mut Vec<Issue>,
) -> Result<Cow<'a, [u8]>, IngestError> {
    let utf16 = IngestError::Unsupported {
        format: "UTF-16 text",
        mend: "save it as UTF-8 (in a spreadsheet: `CSV UTF-8`)",
    };
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err(utf16);
    }
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    // A logger that lost power leaves blocks of zeros at the end.
    let zeros = text.iter().rev().take_while(|b| **b == 0).count();
    let text = &text[..text.len() - zeros];
    if text.iter().all(u8::is_ascii_whitespace) {
        return Err(IngestError::Empty);
    }
    let head = &text[..text.len().min(4096)];
    let nulls = head.iter().filter(|b| **b == 0).count();
    if nulls * 3 > head.len() && head.iter().any(u8::is_ascii_digit) {
        return Err(utf16);
    }
    let odd = head
        .iter()
        .filter(|b| b.is_ascii_control() && !b.is_ascii_whitespace())
        .count();
    if odd * 20 > head.len() {
        return Err(crate::detect::unrecognised(bytes));
    }
    if zeros > 0 {
        issues.push(Issue {
            kind: IssueKind::Truncated,
            place: format!("byte {}", bytes.len() - zeros),
            message: format!(
                "the last {zeros} bytes are zero, as after a power loss; they were left out"
            ),
        });
    }
    // Line ends of old Macs.
    if !text.contains(&b'\n') && text.contains(&b'\r') {
        let lines = text.iter().map(|b| if *b == b'\r' { b'\n' } else { *b });
        return Ok(Cow::Owned(lines.collect()));
    }
    Ok(Cow::Borrowed(text))
}

/// One cell, trimmed and without its quotes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell<'a> {
    pub(super) bytes: &'a [u8],
    /// Where the delimiter, the line end or the end of the text is.
    pub(super) end: usize,
    /// Line ends inside the quotes.
    pub(super) newlines: u32,
}

/// The cell that starts at `at`.
pub(super) fn cell(text: &[u8], at: usize, delimiter: u8) -> Cell<'_> {
    let ends = |b: &u8| *b == delimiter || *b == b'\n';
    let rest = &text[at..];
    let blanks = rest.iter().take_while(|b| **b == b' ').count();
    if rest.get(blanks) == Some(&b'"')
        && let Some(quoted) = quoted(text, at + blanks + 1, delimiter)
    {
        return quoted;
    }
    let length = rest.iter().position(ends).unwrap_or(rest.len());
    Cell {
        bytes: rest[..length].trim_ascii(),
        end: at + length,
        newlines: 0,
    }
}

/// From behind an opening quote; `None` if it is not closed, or closed inside the cell.
fn quoted(text: &[u8], start: usize, delimiter: u8) -> Option<Cell<'_>> {
    let mut newlines = 0;
    let mut at = start;
    loop {
        match text.get(at)? {
            b'"' if text.get(at + 1) == Some(&b'"') => at += 1,
            b'"' => break,
            b'\n' => {
                newlines += 1;
                if newlines > QUOTED_LINES {
                    return None;
                }
            }
            _ => {}
        }
        at += 1;
    }
    let blanks = text[at + 1..]
        .iter()
        .take_while(|b| matches!(**b, b' ' | b'\r'))
        .count();
    let end = at + 1 + blanks;
    let closed = text.get(end).is_none_or(|b| *b == delimiter || *b == b'\n');
    closed.then(|| Cell {
        bytes: text[start..at].trim_ascii(),
        end,
        newlines,
    })
}

/// A line cut into cells.
#[derive(Debug, Clone)]
pub(super) struct Line<'a> {
    /// Counted from 1.
    pub(super) number: u64,
    pub(super) start: usize,
    pub(super) cells: Vec<&'a [u8]>,
}

/// Non-blank lines from `at` on, cut into cells; `number` is the line at `at`.
pub(super) fn lines(
    text: &[u8],
    at: usize,
    number: u64,
    delimiter: u8,
) -> impl Iterator<Item = Line<'_>> {
    let (mut at, mut number) = (at, number);
    std::iter::from_fn(move || {
        while at < text.len() {
            let mut line = Line {
                number,
                start: at,
                cells: Vec::new(),
            };
            loop {
                let cell = cell(text, at, delimiter);
                number += u64::from(cell.newlines);
                // One more than allowed, so that the caller sees it; not a billion.
                if line.cells.len() <= MAX_COLUMNS {
                    line.cells.push(cell.bytes);
                }
                at = (cell.end + 1).min(text.len());
                if text.get(cell.end) != Some(&delimiter) {
                    break;
                }
            }
            number += 1;
            if line.cells.iter().any(|c| !c.is_empty()) {
                return Some(line);
            }
        }
        None
    })
}

/// A cell as text: doubled quotes undone, line ends to blanks; bytes that are no UTF-8 are
/// taken for Latin-1, where spreadsheets put the degree sign.
pub(super) fn words(cell: &[u8]) -> String {
    const MOST: usize = 200;
    let text: String = match std::str::from_utf8(cell) {
        Ok(text) => text.chars().take(MOST).collect(),
        Err(_) => cell.iter().take(MOST).map(|b| char::from(*b)).collect(),
    };
    let text = text.replace("\"\"", "\"");
    text.split(|c: char| c.is_whitespace() || c.is_control())
        .filter(|w| !w.is_empty())
        .collect::<Vec<_>>()
        .join(" ")
}
