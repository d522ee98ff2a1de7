//! The rows of a text, straight into columns of numbers, a block at a time.

use super::layout::{Head, Layout, bare, is_known_unit, split_unit};
use super::number;
use super::stamp::{Clock, Joined};
use super::text::{cell, is_whole, words};
use crate::{IngestError, count, nulls};
use dgd_recording::{Issue, IssueKind};
use std::collections::HashSet;

/// Cells that a file may have beyond one for each of its bytes: short rows of a wide
/// table are filled with NaN, and that must not cost more memory than a full table.
pub(super) const SPARE_CELLS: u64 = 1 << 20;

/// A column being read.
pub(super) struct Reading {
    pub(super) head: Head,
    pub(super) values: Vec<f64>,
    pub(super) clock: Clock,
    /// Of a clock whose date stands in another column.
    pub(super) joined: Joined,
    /// Cells that gave a number or a time.
    pub(super) readable: u64,
    /// Cells that are neither number, nor time, nor empty, nor a word that may stand for 0.
    unreadable: Tally,
    /// Cells with such a word.
    resting: Tally,
    log_nulls: Tally,
    /// Cells with a number to the right of the header's last.
    beyond: Tally,
    commas: Commas,
}

/// What the cells of a column tell of a comma in them, where commas separate no cells.
#[derive(Default)]
struct Commas {
    /// Cells whose comma may separate thousands.
    doubtful: Tally,
    /// Whether another cell shows that it is a decimal sign.
    decimal: bool,
    /// Whether whole numbers go up to the thousands.
    hundreds: bool,
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

/// The rows of a text that comes in windows, read into blocks.
pub(super) struct Rows {
    delimiter: u8,
    pub(super) columns: Vec<Reading>,
    /// What the columns are called in the text.
    names: HashSet<String>,
    /// Rows that make a block.
    block: usize,
    /// Columns up to the last one with a name: fewer cells than this is a short row.
    needed: usize,
    /// Line of the text that is read next.
    line: u64,
    /// Rows of the block so far.
    rows: usize,
    /// Rows of delimiters since the last row with values.
    empty_rows: usize,
    /// The row behind them, while they are filled in.
    held: Option<Vec<f64>>,
    row: Row,
    short: Tally,
    long: Tally,
    wordy: Tally,
    /// Rows with a word in each column, which stand for a sample.
    worded: Tally,
    /// Lines that name the columns anew, and otherwise.
    renamed: Tally,
    /// Lines that state other units than the first header.
    remeasured: Tally,
    commas: Tally,
    /// Whether a cell has a decimal point; only asked where commas are free.
    pub(super) points: bool,
    cut: Option<(u64, usize)>,
    last_cells: LastCells,
    /// The last cell of the text, if it is a part of a number: its line and what is left of it.
    part: Option<(u64, String)>,
}

/// Digits behind the decimal point in the last column with a name.
#[derive(Default)]
struct LastCells {
    rows: usize,
    /// As many in each of them; `None` once two differ.
    decimals: Option<usize>,
}

impl LastCells {
    /// Rows that show that a column is written with a fixed number of decimals: of numbers in their shortest form every tenth has fewer.
    const ENOUGH: usize = 100;

    fn add(&mut self, decimals: usize) {
        let same = self.rows == 0 || self.decimals == Some(decimals);
        self.decimals = same.then_some(decimals);
        self.rows += 1;
    }

    /// Whether a number with so many decimals has lost some.
    fn are_more_than(&self, decimals: usize) -> bool {
        self.rows >= Self::ENOUGH && self.decimals.is_some_and(|fixed| decimals < fixed)
    }
}

/// One row while it is read.
#[derive(Default)]
struct Row {
    line: u64,
    cells: usize,
    /// Where the text of the last column with a name is.
    last_at: Option<usize>,
    readable: usize,
    texts: usize,
    /// Cells that count only if the row does: column and where its text is.
    unreadable: Vec<(usize, usize)>,
    extra: bool,
    /// Whether a cell might be another one with more text behind it.
    open: bool,
}

/// What a row without a number says of the columns.
#[derive(Default)]
struct Again {
    /// Cells that are the name of a column.
    named: usize,
    /// Those of them that stand in other places.
    moved: usize,
    /// Whether all of them are units.
    units: bool,
    /// A unit that is another one than the column's.
    other_unit: Option<String>,
}

/// A stretch of a text.
#[derive(Clone, Copy)]
pub(super) struct Window<'a> {
    pub(super) text: &'a [u8],
    /// Whether the text ends with it. If not, rows that begin in its last [`Window::MARGIN`]th
    /// are left for the next one unless they are whole.
    pub(super) last: bool,
}

impl Window<'_> {
    const MARGIN: usize = 8;
}

/// Why reading stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stop {
    /// The block is full; the window goes on at this byte.
    Full(usize),
    /// What is left of the window, from this byte on, wants more text.
    More(usize),
    /// A row is too long for the window.
    Long,
}

/// Most lines of so many columns that a text of so many bytes may have.
///
/// # Errors
/// [`IngestError::TooLarge`] if they make far more cells than the bytes can say.
pub(super) fn check_size(lines: u64, columns: usize, bytes: u64) -> Result<(), IngestError> {
    let claimed = lines.saturating_mul(columns as u64);
    let limit = bytes + SPARE_CELLS;
    if claimed <= limit {
        return Ok(());
    }
    Err(IngestError::TooLarge {
        what: format!("a table of {lines} lines by {columns} columns"),
        claimed,
        limit,
    })
}

/// Reads every row of a text from the layout's start on as one block.
///
/// # Errors
/// [`IngestError::TooLarge`] of [`check_size`].
pub(super) fn read(text: &[u8], layout: &Layout) -> Result<Rows, IngestError> {
    let text = &text[layout.start..];
    let lines = text.iter().filter(|b| **b == b'\n').count() + 1;
    let bytes = (layout.start + text.len()) as u64;
    check_size(lines as u64, layout.columns.len(), bytes)?;
    let mut rows = Rows::new(layout, usize::MAX);
    for column in &mut rows.columns {
        column.values.reserve_exact(lines);
    }
    let stop = rows.read(Window { text, last: true }, 0);
    debug_assert_eq!(stop, Stop::More(text.len()), "the last window is read out");
    Ok(rows)
}

impl Reading {
    fn new(head: Head) -> Self {
        let clock = Clock::new(head.two_are_hours, head.dated);
        Self {
            values: Vec::new(),
            head,
            clock,
            joined: Joined::default(),
            readable: 0,
            unreadable: Tally::default(),
            resting: Tally::default(),
            log_nulls: Tally::default(),
            beyond: Tally::default(),
            commas: Commas::default(),
        }
    }

    fn push(&mut self, value: f64, line: u64) {
        self.readable += 1;
        if self.head.beyond {
            self.beyond.add(line, || format!("{value}"));
        }
        if !self.head.stamps && nulls::is_log_null(value) {
            self.log_nulls.add(line, || format!("{value}"));
            self.values.push(f64::NAN);
        } else {
            self.values.push(value);
        }
    }

    /// Looks at the comma of a cell that was read as a decimal one.
    fn add_comma(&mut self, cell: &[u8], line: u64) {
        if number::may_be_thousands(cell) {
            self.commas.doubtful.add(line, || words(cell));
        } else {
            self.commas.decimal = true;
        }
    }

    /// How many commas may separate thousands: all of them, if numbers without one or decimal points elsewhere say so.
    fn doubtful_commas(&self, points: bool) -> u64 {
        let Commas {
            doubtful,
            decimal,
            hundreds,
        } = &self.commas;
        if !decimal && (points || *hundreds) {
            doubtful.count
        } else {
            0
        }
    }

    /// Cells that are neither number, nor time, nor empty.
    pub(super) fn texts(&self) -> u64 {
        self.unreadable.count + self.resting.count
    }

    /// Where the first of these is.
    pub(super) fn first_text(&self) -> &Tally {
        let (one, other) = (&self.unreadable, &self.resting);
        if one.count == 0 || (other.count > 0 && other.line < one.line) {
            other
        } else {
            one
        }
    }

    /// What was wrong with its cells; `points` if a cell of the text has a decimal point.
    pub(super) fn issues(&self, points: bool) -> impl Iterator<Item = Issue> {
        let issue = |kind: IssueKind, tally: &Tally, message: String| {
            (tally.count > 0).then(|| Issue {
                kind,
                place: format!("line {}, column `{}`", tally.line, self.head.tag),
                message,
            })
        };
        let what = if self.head.stamps {
            "time stamps"
        } else {
            "numbers"
        };
        let separated = self.unreadable.shown.contains([',', '.'])
            && self
                .unreadable
                .shown
                .bytes()
                .all(|b| !b.is_ascii_alphabetic());
        let mend = if separated && !self.head.stamps {
            " (a thousands separator or a decimal sign? write them without the former)"
        } else {
            ""
        };
        let texts = format!(
            "{} cannot be read as {what}, the first is `{}`{mend}; read as NaN",
            count(self.unreadable.count, "cell"),
            self.unreadable.shown
        );
        let nulls = nulls::message(self.log_nulls.count, &self.log_nulls.shown);
        let beyond = format!(
            "{} to the right of the header's last name, the first is `{}` (a decimal comma where commas separate the cells?); read as a column without a name",
            count(self.beyond.count, "cell"),
            self.beyond.shown
        );
        let doubtful = self.doubtful_commas(points);
        let first = &self.commas.doubtful;
        let commas = (doubtful > 0).then(|| Issue {
            kind: IssueKind::UnreadableValue,
            place: format!("line {}, column `{}`", first.line, self.head.tag),
            message: format!(
                "{} with a comma that may separate thousands, the first is `{}`; read as {}, not as {} (write them without a thousands separator)",
                count(doubtful, "cell"),
                first.shown,
                first.shown.replace(',', "."),
                first.shown.replace(',', "")
            ),
        });
        let resting = format!(
            "{} with a word that may stand for 0, the first is `{}`; read as NaN (if it does, write 0)",
            count(self.resting.count, "cell"),
            self.resting.shown
        );
        [
            issue(IssueKind::WordForZero, &self.resting, resting),
            issue(IssueKind::UnreadableValue, &self.unreadable, texts),
            issue(IssueKind::UnreadableValue, &self.log_nulls, nulls),
            issue(IssueKind::Damaged, &self.beyond, beyond),
            commas,
        ]
        .into_iter()
        .flatten()
    }
}

/// Whether a cell has a word by which a pump or valve is said to rest.
fn may_stand_for_zero(cell: &[u8]) -> bool {
    const WORDS: [&[u8]; 7] = [
        b"off", b"stop", b"stopped", b"closed", b"idle", b"standby", b"no flow",
    ];
    let word = cell.trim_ascii();
    let word = word.strip_prefix(b"\"").unwrap_or(word);
    let word = word.strip_suffix(b"\"").unwrap_or(word);
    WORDS.iter().any(|rests| word.eq_ignore_ascii_case(rests))
}

impl Row {
    fn begin(&mut self, line: u64) {
        let mut unreadable = std::mem::take(&mut self.unreadable);
        unreadable.clear();
        *self = Self {
            line,
            unreadable,
            ..Self::default()
        };
    }
}

impl Rows {
    /// `block` rows, at least 1, make a block.
    pub(super) fn new(layout: &Layout, block: usize) -> Self {
        let heads = &layout.columns;
        let named = heads.iter().rposition(|c| c.named);
        Self {
            delimiter: layout.delimiter,
            columns: heads.iter().cloned().map(Reading::new).collect(),
            names: (heads.iter().filter(|c| c.named))
                .map(|c| c.written.clone())
                .collect(),
            block,
            needed: named.map_or(heads.len(), |n| n + 1),
            line: layout.line,
            rows: 0,
            empty_rows: 0,
            held: None,
            row: Row::default(),
            short: Tally::default(),
            long: Tally::default(),
            wordy: Tally::default(),
            worded: Tally::default(),
            renamed: Tally::default(),
            remeasured: Tally::default(),
            commas: Tally::default(),
            points: false,
            cut: None,
            last_cells: LastCells::default(),
            part: None,
        }
    }

    /// Rows that the block has so far.
    pub(super) fn in_block(&self) -> usize {
        self.rows
    }

    /// Makes room for the next block; what was read before stays counted.
    pub(super) fn next_block(&mut self) {
        for column in &mut self.columns {
            column.values.clear();
        }
        self.rows = 0;
    }

    /// Reads rows from byte `at` of a window on, until the block is full or the window is not enough.
    pub(super) fn read(&mut self, window: Window<'_>, mut at: usize) -> Stop {
        let Window { text, last } = window;
        let sure = match last {
            true => text.len(),
            false => text.len() - text.len() / Window::MARGIN,
        };
        loop {
            self.fill_empty_rows();
            if self.rows >= self.block {
                return Stop::Full(at);
            }
            if at >= text.len() || at >= sure && !is_whole(text, at, self.delimiter) {
                return Stop::More(at);
            }
            self.row.begin(self.line);
            loop {
                if self.row.cells + 1 == self.needed {
                    self.row.last_at = Some(at);
                }
                let (end, newlines) = self.take(text, at);
                self.line += u64::from(newlines);
                self.row.cells += 1;
                at = end;
                if text.get(at) != Some(&self.delimiter) {
                    break;
                }
                at += 1;
            }
            if self.row.open && !last {
                return Stop::Long;
            }
            // At a line end now, or at the end of the text.
            let ended = at < text.len();
            at = (at + 1).min(text.len());
            self.line += 1;
            self.finish(text, ended);
        }
    }

    /// Reads the cell at `at`; returns where it ends.
    #[inline]
    fn take(&mut self, text: &[u8], at: usize) -> (usize, u32) {
        if let Some(column) = self.columns.get_mut(self.row.cells)
            && !column.head.stamps
            && let Some((value, length)) = number::plain(&text[at..])
        {
            let mut end = at + length;
            if text.get(end) == Some(&b'\r') {
                end += 1;
            }
            let next = text.get(end);
            if next.is_none_or(|b| *b == self.delimiter || *b == b'\n') {
                column.push(value, self.row.line);
                self.row.readable += 1;
                self.row.open |= next.is_none();
                if self.delimiter != b',' {
                    let cell = &text[at..at + length];
                    self.points |= cell.contains(&b'.');
                    column.commas.hundreds |= number::is_hundreds(cell);
                }
                return (end, 0);
            }
        }
        self.take_slowly(text, at)
    }

    fn take_slowly(&mut self, text: &[u8], at: usize) -> (usize, u32) {
        let found = cell(text, at, self.delimiter);
        let (bytes, done) = (found.bytes, (found.end, found.newlines));
        let row = &mut self.row;
        row.open |= found.open;
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
            let stamp = column.head.stamp(bytes);
            stamp.map(|stamp| column.clock.seconds(stamp))
        } else if self.delimiter == b',' {
            // A comma within quotes is none of the delimiters.
            number::parse(bytes).or_else(|| number::parse_quoted(bytes))
        } else {
            number::parse_with_comma(bytes).map(|(value, comma)| {
                if comma {
                    self.commas.add(row.line, || words(bytes));
                    column.add_comma(bytes, row.line);
                } else {
                    self.points |= bytes.contains(&b'.');
                    column.commas.hundreds |= number::is_hundreds(bytes);
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
                row.unreadable.push((index, at));
            }
        }
        done
    }

    fn finish(&mut self, text: &[u8], ended: bool) {
        self.look_at_last_cell(text, ended);
        let (row, delimiter) = (&self.row, self.delimiter);
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
                let first = row.unreadable.first().map_or(0, |u| u.1);
                let begins = || words(cell(text, first, delimiter).bytes);
                let again = self.named_again(text);
                if again.named > 1 && again.moved > 0 {
                    self.renamed.add(row.line, begins);
                } else if let Some(unit) = again.other_unit.filter(|_| again.named != 1) {
                    self.remeasured.add(row.line, || unit);
                } else if again.named == 0 && !again.units && self.is_filled(text) {
                    // In a table without a clock the rows below must stay where they are.
                    self.empty_rows += 1;
                    self.worded.add(row.line, begins);
                } else {
                    self.wordy.add(row.line, begins);
                }
            }
            for column in &mut self.columns {
                column.values.truncate(self.rows);
            }
            return;
        }
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
        for (index, start) in &row.unreadable {
            let bytes = cell(text, *start, delimiter).bytes;
            let shown = || words(bytes).chars().take(24).collect();
            let column = &mut self.columns[*index];
            if !column.head.stamps && may_stand_for_zero(bytes) {
                column.resting.add(row.line, shown);
            } else {
                column.unreadable.add(row.line, shown);
            }
        }
        if self.empty_rows > 0 {
            let values = self.columns.iter_mut().map(|c| c.values.pop());
            self.held = Some(values.map(|v| v.unwrap_or(f64::NAN)).collect());
        } else {
            self.rows += 1;
        }
    }

    /// Blanks the last number of a text without a line end, if it has fewer decimals than all above it: it is cut off within.
    fn look_at_last_cell(&mut self, text: &[u8], ended: bool) {
        let (Some(at), Some(column)) = (
            self.row.last_at,
            self.columns.get_mut(self.needed.saturating_sub(1)),
        ) else {
            return;
        };
        if column.head.stamps || column.values.last().is_none_or(|v| v.is_nan()) {
            return;
        }
        let bytes = cell(text, at, self.delimiter).bytes;
        let point = bytes.iter().rposition(|b| matches!(b, b'.' | b','));
        let decimals = point.map_or(0, |point| bytes.len() - point - 1);
        let is_end = !ended && self.row.cells == self.needed;
        if is_end && self.last_cells.are_more_than(decimals) {
            if let Some(value) = column.values.last_mut() {
                *value = f64::NAN;
            }
            self.part = Some((self.row.line, words(bytes)));
        } else {
            self.last_cells.add(decimals);
        }
    }

    /// Whether a row without a number has a word in each column that has a name, and is no comment.
    fn is_filled(&self, text: &[u8]) -> bool {
        let first = self.row.unreadable.first().map_or(0, |u| u.1);
        let comment = cell(text, first, self.delimiter).bytes.starts_with(b"#");
        self.row.texts >= self.needed && !comment
    }

    /// What the words of a row without a number say of the columns.
    fn named_again(&self, text: &[u8]) -> Again {
        let mut again = Again::default();
        let is_unit =
            |(_, start): &(usize, usize)| is_known_unit(cell(text, *start, self.delimiter).bytes);
        again.units = self.row.texts > 1 && self.row.unreadable.iter().all(is_unit);
        for (index, start) in &self.row.unreadable {
            let written = words(cell(text, *start, self.delimiter).bytes);
            let (name, beside) = split_unit(&written);
            let head = self.columns.get(*index).map(|c| &c.head);
            let in_place = head.is_some_and(|head| head.is_named(name));
            let unit = beside
                .filter(|_| in_place)
                .or(again.units.then(|| bare(&written)));
            let other = unit.filter(|u| head.is_some_and(|head| head.is_in_another(u)));
            if let (Some(unit), None) = (other, &again.other_unit) {
                again.other_unit = Some(unit.to_owned());
            }
            if in_place || self.names.contains(name) {
                again.named += 1;
                again.moved += usize::from(!in_place);
            }
        }
        again
    }

    /// Puts rows without values, and then the row behind them, into what room the block has.
    fn fill_empty_rows(&mut self) {
        let Some(held) = &self.held else {
            return;
        };
        let filled = self.empty_rows.min(self.block - self.rows);
        self.empty_rows -= filled;
        self.rows += filled;
        for column in &mut self.columns {
            column.values.resize(self.rows, f64::NAN);
        }
        if self.rows < self.block {
            for (column, value) in self.columns.iter_mut().zip(held) {
                column.values.push(*value);
            }
            self.rows += 1;
            self.held = None;
        }
    }

    /// Refuses columns that change places or units on the way.
    ///
    /// # Errors
    /// [`IngestError::NotTabular`] with the line that names them anew.
    pub(super) fn check_names(&self) -> Result<(), IngestError> {
        let (line, reason) = if self.renamed.count > 0 {
            let reason = format!(
                "a second header, which begins with `{}`, has its column names in other places than the first",
                self.renamed.shown
            );
            (self.renamed.line, reason)
        } else if self.remeasured.count > 0 {
            let reason = format!(
                "a second header has the unit `{}` where the first has another",
                self.remeasured.shown
            );
            (self.remeasured.line, reason)
        } else {
            return Ok(());
        };
        Err(IngestError::NotTabular {
            place: format!("line {line}"),
            reason,
            mend:
                "split the file there: a column must hold the same quantity, in one unit, from its first line to its last"
                    .into(),
        })
    }

    /// What was wrong with rows and cells.
    pub(super) fn issues(&self) -> Vec<Issue> {
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
                "{} too short, the first has {} cells, expected {needed}; the missing cells became NaN",
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
        let shown: String = self.worded.shown.chars().take(24).collect();
        tell(
            &self.worded,
            IssueKind::Skipped,
            format!(
                "{} with words in all columns, the first begins with `{shown}`; read as NaN where values follow",
                count(self.worded.count, "row")
            ),
        );
        let doubtful = self.columns.iter().map(|c| c.doubtful_commas(self.points));
        // Those are told column by column.
        if self.points && self.commas.count > doubtful.sum() {
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
        if let Some((line, part)) = &self.part {
            issues.push(Issue {
                kind: IssueKind::Truncated,
                place: format!("line {line}"),
                message: format!(
                    "the text ends within a number: `{part}` has fewer decimals than all above it; read as NaN"
                ),
            });
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
