//! The rows of a text, straight into columns of numbers.

use super::layout::{Head, Layout};
use super::number;
use super::stamp::{self, Clock};
use super::text::{cell, words};
use crate::{IngestError, count};
use dgd_recording::{Column, Issue, IssueKind};

/// Cells that a file may have beyond one for each of its bytes: short rows of a wide
/// table are filled with NaN, and that must not cost more memory than a full table.
const SPARE_CELLS: u64 = 1 << 20;

/// A column being read.
pub(super) struct Reading {
    pub(super) head: Head,
    pub(super) values: Vec<f64>,
    pub(super) clock: Clock,
    /// Cells that gave a number or a time.
    pub(super) readable: u64,
    /// Cells that are neither number, nor time, nor empty.
    pub(super) unreadable: Tally,
    log_nulls: Tally,
}

/// How often, and where first.
#[derive(Default)]
pub(super) struct Tally {
    pub(super) count: u64,
    pub(super) line: u64,
    pub(super) shown: String,
}

impl Tally {
    fn add(&mut self, line: u64, shown: impl FnOnce() -> String) {
        if self.count == 0 {
            self.line = line;
            self.shown = shown();
        }
        self.count += 1;
    }
}

/// Everything the rows gave.
pub(super) struct Rows {
    pub(super) columns: Vec<Reading>,
    pub(super) issues: Vec<Issue>,
}

struct Reader<'a> {
    text: &'a [u8],
    delimiter: u8,
    columns: Vec<Reading>,
    /// Columns up to the last one with a name: fewer cells than this is a short row.
    needed: usize,
    rows: usize,
    empty_rows: usize,
    short: Tally,
    long: Tally,
    wordy: Tally,
    commas: Tally,
    /// Whether a cell has a decimal point; only asked where commas are free.
    points: bool,
    cut: Option<(u64, usize)>,
}

/// One row while it is read.
struct Row {
    line: u64,
    cells: usize,
    readable: usize,
    texts: usize,
    /// Cells that count only if the row does: column and where its text is.
    unreadable: Vec<(usize, usize, usize)>,
    extra: bool,
}

/// Reads every row from the layout's start on.
///
/// # Errors
/// [`IngestError::TooLarge`] if rows times columns is far more than the bytes can say.
pub(super) fn read(text: &[u8], layout: Layout) -> Result<Rows, IngestError> {
    let lines = text[layout.start..].iter().filter(|b| **b == b'\n').count() + 1;
    let width = layout.columns.len();
    let claimed = lines as u64 * width as u64;
    let limit = text.len() as u64 + SPARE_CELLS;
    if claimed > limit {
        return Err(IngestError::TooLarge {
            what: format!("a table of {lines} lines by {width} columns"),
            claimed,
            limit,
        });
    }
    let named = layout
        .columns
        .iter()
        .rposition(|c| c.named)
        .map_or(width, |n| n + 1);
    let mut reader = Reader {
        text,
        delimiter: layout.delimiter,
        needed: named,
        columns: layout
            .columns
            .into_iter()
            .map(|head| Reading::new(head, lines))
            .collect(),
        rows: 0,
        empty_rows: 0,
        short: Tally::default(),
        long: Tally::default(),
        wordy: Tally::default(),
        commas: Tally::default(),
        points: false,
        cut: None,
    };
    reader.run(layout.start, layout.line);
    let issues = reader.issues();
    Ok(Rows {
        columns: reader.columns,
        issues,
    })
}

impl Reading {
    fn new(head: Head, lines: usize) -> Self {
        let clock = Clock::new(head.two_are_hours, head.dated);
        Self {
            values: Vec::with_capacity(lines),
            head,
            clock,
            readable: 0,
            unreadable: Tally::default(),
            log_nulls: Tally::default(),
        }
    }

    fn push(&mut self, value: f64, line: u64) {
        self.readable += 1;
        if number::is_log_null(value) {
            self.log_nulls.add(line, || format!("{value}"));
            self.values.push(f64::NAN);
        } else {
            self.values.push(value);
        }
    }

    /// The column as a table has it.
    pub(super) fn column(self) -> Column {
        Column {
            tag: self.head.tag,
            unit: self.head.unit,
            values: self.values,
        }
    }

    pub(super) fn issues(&self) -> impl Iterator<Item = Issue> {
        let issue = |tally: &Tally, message: String| {
            (tally.count > 0).then(|| Issue {
                kind: IssueKind::UnreadableValue,
                place: format!("line {}, column `{}`", tally.line, self.head.tag),
                message,
            })
        };
        let what = if self.head.stamps {
            "time stamps"
        } else {
            "numbers"
        };
        let texts = format!(
            "{} cannot be read as {what}, the first is `{}`; NaN stands there",
            count(self.unreadable.count, "cell"),
            self.unreadable.shown
        );
        let nulls = format!(
            "{} with {}, which well logs write for no value; NaN stands there",
            count(self.log_nulls.count, "cell"),
            self.log_nulls.shown
        );
        [
            issue(&self.unreadable, texts),
            issue(&self.log_nulls, nulls),
        ]
        .into_iter()
        .flatten()
    }
}

impl Reader<'_> {
    fn run(&mut self, mut at: usize, mut line: u64) {
        let mut row = Row {
            line,
            cells: 0,
            readable: 0,
            texts: 0,
            unreadable: Vec::new(),
            extra: false,
        };
        while at < self.text.len() {
            row.line = line;
            (row.cells, row.readable, row.texts, row.extra) = (0, 0, 0, false);
            row.unreadable.clear();
            loop {
                let (end, newlines) = self.take(at, &mut row);
                line += u64::from(newlines);
                row.cells += 1;
                at = end;
                if self.text.get(at) != Some(&self.delimiter) {
                    break;
                }
                at += 1;
            }
            // At a line end now, or at the end of the text.
            let ended = at < self.text.len();
            at += 1;
            line += 1;
            self.finish(&row, ended);
        }
    }

    /// Reads the cell at `at`; returns where it ends.
    #[inline]
    fn take(&mut self, at: usize, row: &mut Row) -> (usize, u32) {
        if let Some(column) = self.columns.get_mut(row.cells)
            && !column.head.stamps
            && let Some((value, length)) = number::plain(&self.text[at..])
        {
            let mut end = at + length;
            if self.text.get(end) == Some(&b'\r') {
                end += 1;
            }
            if self
                .text
                .get(end)
                .is_none_or(|b| *b == self.delimiter || *b == b'\n')
            {
                column.push(value, row.line);
                row.readable += 1;
                self.points |= self.delimiter != b',' && self.text[at..end].contains(&b'.');
                return (end, 0);
            }
        }
        self.take_slowly(at, row)
    }

    fn take_slowly(&mut self, at: usize, row: &mut Row) -> (usize, u32) {
        let found = cell(self.text, at, self.delimiter);
        let (bytes, done) = (found.bytes, (found.end, found.newlines));
        let index = row.cells;
        let Some(column) = self.columns.get_mut(index) else {
            row.extra |= !bytes.is_empty();
            return done;
        };
        if bytes.is_empty() || number::is_missing(bytes) {
            // `NaN` says that there is a row, a blank does not.
            row.readable += usize::from(!bytes.is_empty());
            column.values.push(f64::NAN);
            return done;
        }
        let value = if column.head.stamps {
            stamp::parse(bytes).map(|stamp| column.clock.seconds(stamp))
        } else if self.delimiter == b',' {
            number::parse(bytes)
        } else {
            number::parse_with_comma(bytes).map(|(value, comma)| {
                if comma {
                    self.commas.add(row.line, || words(bytes));
                } else {
                    self.points |= bytes.contains(&b'.');
                }
                value
            })
        };
        match value {
            Some(value) => {
                column.push(value, row.line);
                row.readable += 1;
            }
            None => {
                column.values.push(f64::NAN);
                row.texts += 1;
                row.unreadable.push((index, at, found.end));
            }
        }
        done
    }

    fn finish(&mut self, row: &Row, ended: bool) {
        let is_blank = row.readable == 0 && row.texts == 0;
        let cut = !ended && row.cells < self.needed && !is_blank;
        if cut {
            self.cut = Some((row.line, row.cells));
        }
        if row.readable == 0 || cut {
            if is_blank {
                // A line of delimiters is a row without values, but not at the end of the file.
                self.empty_rows += usize::from(row.cells > 1);
            } else if !cut {
                let text = self.text;
                let first = row.unreadable.first().map_or(0, |u| u.1);
                let delimiter = self.delimiter;
                self.wordy
                    .add(row.line, || words(cell(text, first, delimiter).bytes));
            }
            for column in &mut self.columns {
                column.values.truncate(self.rows);
            }
            return;
        }
        if self.empty_rows > 0 {
            let (from, to) = (self.rows, self.rows + self.empty_rows);
            for column in &mut self.columns {
                let last = column.values.get(from).copied();
                column.values.truncate(from);
                column.values.resize(to, f64::NAN);
                column.values.extend(last);
            }
            self.rows = to;
            self.empty_rows = 0;
        }
        self.rows += 1;
        if row.cells < self.columns.len() {
            for column in &mut self.columns[row.cells..] {
                column.values.push(f64::NAN);
            }
        }
        if row.cells < self.needed {
            self.short.add(row.line, || row.cells.to_string());
        }
        if row.extra {
            self.long.add(row.line, || row.cells.to_string());
        }
        for (index, start, _) in &row.unreadable {
            let (text, delimiter) = (self.text, self.delimiter);
            let shown = || {
                words(cell(text, *start, delimiter).bytes)
                    .chars()
                    .take(24)
                    .collect()
            };
            self.columns[*index].unreadable.add(row.line, shown);
        }
    }

    fn issues(&self) -> Vec<Issue> {
        let (needed, width) = (self.needed, self.columns.len());
        let mut issues = Vec::new();
        let mut tell = |tally: &Tally, kind, message: String| {
            if tally.count > 0 {
                issues.push(Issue {
                    kind,
                    place: format!("line {}", tally.line),
                    message,
                });
            }
        };
        tell(
            &self.short,
            IssueKind::Damaged,
            format!(
                "{} too short, the first has {} cells, expected {needed}; what is missing became NaN",
                count(self.short.count, "line"),
                self.short.shown
            ),
        );
        tell(
            &self.long,
            IssueKind::Damaged,
            format!(
                "{} too long, the first has {} cells, expected {width}; the surplus was left out",
                count(self.long.count, "line"),
                self.long.shown
            ),
        );
        let shown: String = self.wordy.shown.chars().take(24).collect();
        tell(
            &self.wordy,
            IssueKind::Skipped,
            format!(
                "{} without a number among the values, the first begins with `{shown}`; left out",
                count(self.wordy.count, "line")
            ),
        );
        if self.points {
            tell(
                &self.commas,
                IssueKind::UnreadableValue,
                format!(
                    "{} with a decimal comma (the first is `{}`) beside others with a decimal point; both were read as such",
                    count(self.commas.count, "cell"),
                    self.commas.shown
                ),
            );
        }
        if let Some((line, cells)) = self.cut {
            issues.push(Issue {
                kind: IssueKind::Truncated,
                place: format!("line {line}"),
                message: format!(
                    "the last line is cut off after {cells} of {needed} cells; it was left out"
                ),
            });
        }
        issues
    }
}
