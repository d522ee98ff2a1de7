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
    // A logger that lost power leaves blocks of zeros at the end.
    let zeros = bytes.iter().rev().take_while(|b| **b == 0).count();
    let text = &bytes[..bytes.len() - zeros];
    let text = &text[mark(text)..];
    check(bytes, text)?;
    if text.iter().all(u8::is_ascii_whitespace) {
        return Err(IngestError::Empty);
    }
    issues.extend(cut_off(bytes.len() as u64, zeros as u64));
    // Line ends of old Macs.
    if !text.contains(&b'\n') && text.contains(&b'\r') {
        let lines = text.iter().map(|b| if *b == b'\r' { b'\n' } else { *b });
        return Ok(Cow::Owned(lines.collect()));
    }
    Ok(Cow::Borrowed(text))
}

/// Bytes of the mark that says how the text is encoded.
pub(super) fn mark(bytes: &[u8]) -> usize {
    const MARKS: [&[u8]; 3] = [b"\xef\xbb\xbf", b"\xff\xfe", b"\xfe\xff"];
    let mark = MARKS.iter().find(|mark| bytes.starts_with(mark));
    mark.map_or(0, |mark| mark.len())
}

/// Looks at the first bytes of a file, and of the text in it.
///
/// # Errors
/// [`IngestError`] for UTF-16 and bytes that are no text.
pub(super) fn check(bytes: &[u8], text: &[u8]) -> Result<(), IngestError> {
    let utf16 = IngestError::Unsupported {
        format: "UTF-16 text",
        mend: "save it as UTF-8 (in a spreadsheet: `CSV UTF-8`)",
    };
    if mark(bytes) == 2 {
        return Err(utf16);
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
    Ok(())
}

/// What the zeros at the end of a file of so many bytes mean, if there are any.
pub(super) fn cut_off(length: u64, zeros: u64) -> Option<Issue> {
    (zeros > 0).then(|| Issue {
        kind: IssueKind::Truncated,
        place: format!("byte {}", length - zeros),
        message: format!(
            "the last {zeros} bytes are zero, as after a power loss; they were left out"
        ),
    })
}

/// One cell, trimmed and without its quotes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell<'a> {
    pub(super) bytes: &'a [u8],
    /// Where the delimiter, the line end or the end of the text is.
    pub(super) end: usize,
    /// Line ends inside the quotes.
    pub(super) newlines: u32,
    /// Whether the end of the text was met on the way: with more text it might be another cell.
    pub(super) open: bool,
}

/// The cell that starts at `at`.
pub(super) fn cell(text: &[u8], at: usize, delimiter: u8) -> Cell<'_> {
    let ends = |b: &u8| *b == delimiter || *b == b'\n';
    let rest = &text[at..];
    let blanks = rest.iter().take_while(|b| **b == b' ').count();
    let mut open = false;
    if rest.get(blanks) == Some(&b'"') {
        match quoted(text, at + blanks + 1, delimiter) {
            Ok(cell) => return cell,
            Err(not) => open = not.open,
        }
    }
    let length = rest.iter().position(ends).unwrap_or(rest.len());
    Cell {
        bytes: rest[..length].trim_ascii(),
        end: at + length,
        newlines: 0,
        open: open || length == rest.len(),
    }
}

/// A quote that opens no quoted cell, as far as the text says.
struct Unclosed {
    open: bool,
}

/// From behind an opening quote; [`Unclosed`] if it is not closed, or closed inside the cell.
fn quoted(text: &[u8], start: usize, delimiter: u8) -> Result<Cell<'_>, Unclosed> {
    let mut newlines = 0;
    let mut at = start;
    loop {
        match text.get(at) {
            None => return Err(Unclosed { open: true }),
            Some(b'"') if text.get(at + 1) == Some(&b'"') => at += 1,
            Some(b'"') => break,
            Some(b'\n') => {
                newlines += 1;
                if newlines > QUOTED_LINES {
                    return Err(Unclosed { open: false });
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
    let open = end == text.len();
    if open || text[end] == delimiter || text[end] == b'\n' {
        let bytes = text[start..at].trim_ascii();
        Ok(Cell {
            bytes,
            end,
            newlines,
            open,
        })
    } else {
        Err(Unclosed { open: false })
    }
}

/// Whether the line at `at` would be cut into the same cells if the text went on.
pub(super) fn is_whole(text: &[u8], mut at: usize, delimiter: u8) -> bool {
    loop {
        let cell = cell(text, at, delimiter);
        if cell.open {
            return false;
        }
        if text[cell.end] != delimiter {
            return true;
        }
        at = cell.end + 1;
    }
}

/// A line cut into cells.
#[derive(Debug, Clone)]
pub(super) struct Line<'a> {
    /// Counted from 1.
    pub(super) number: u64,
    pub(super) start: usize,
    pub(super) cells: Vec<&'a [u8]>,
    /// Whether it might go on behind the end of the text.
    pub(super) open: bool,
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
                open: false,
            };
            loop {
                let cell = cell(text, at, delimiter);
                line.open |= cell.open;
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
