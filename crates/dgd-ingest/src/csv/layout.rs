//! Delimiter, header, units and the sort of each column, from a sample of the lines.

use super::pairs::Pairs;
use super::readings::Places;
use super::rows::Reading;
use super::text::{Line, lines, words};
use super::{MAX_COLUMNS, number, stamp};
use crate::IngestError;
use crate::tags::tell_apart;
use dgd_recording::is_clock_name;
use dgd_units::Unit;

/// Lines looked at from the start and again from the middle of the file.
const SAMPLED: usize = 200;
/// Bytes in which those lines must begin.
const SAMPLED_BYTES: usize = 1 << 20;

/// What may stand between cells; of equals the first counts.
const DELIMITERS: [u8; 4] = *b",;\t|";

/// How a file is laid out.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    pub(super) delimiter: u8,
    pub(super) columns: Vec<Head>,
    /// Byte and line of the first row of values.
    pub(super) start: usize,
    pub(super) line: u64,
    /// Where each line has its reading, if it has but one.
    pub(super) readings: Option<Places>,
    /// Where each value has its own time beside it, if all have.
    pub(super) pairs: Option<Pairs>,
}

/// What is known of a column before its values are read.
#[derive(Debug, Default, Clone)]
pub(super) struct Head {
    pub(super) tag: String,
    pub(super) unit: Option<String>,
    /// Whether the file names it.
    pub(super) named: bool,
    /// Whether the header ends before it.
    pub(super) beyond: bool,
    /// Its name as written, which others may share.
    pub(super) written: String,
    /// The unit behind its name, where another may stand below.
    beside: Option<String>,
    pub(super) stamps: bool,
    /// A clock whose date stands in another column.
    pub(super) dated: bool,
    /// Its dates are written with midnight behind them, beside a clock.
    midnights: bool,
    /// Cells such as `14:11` are hours and minutes.
    pub(super) two_are_hours: bool,
    /// What comes first in its dates of which the year is last.
    pub(super) first: Option<stamp::First>,
    /// What its cells are that are digits alone.
    pub(super) digits: Option<stamp::Digits>,
}

impl Layout {
    /// Takes two fields for minutes and seconds in columns whose rows say so, which the sampled ones did not; `false` if there is none.
    pub(super) fn take_for_minutes(&mut self, columns: &[Reading]) -> bool {
        let mut any = false;
        for (head, reading) in self.columns.iter_mut().zip(columns) {
            if head.two_are_hours && reading.clock.met_minutes() {
                head.two_are_hours = false;
                any = true;
            }
        }
        any
    }
}

impl Head {
    /// Reads a trimmed cell of a column of stamps.
    pub(super) fn stamp(&self, cell: &[u8]) -> Option<stamp::Stamp> {
        match self.digits {
            Some(digits) => digits.parse(cell),
            None if self.midnights => stamp::parse(cell, self.first)?.as_date(),
            None => stamp::parse(cell, self.first),
        }
    }

    /// Whether a unit that stands above further rows is another one than its own.
    pub(super) fn is_in_another(&self, unit: &str) -> bool {
        let same = |own: &str| match (Unit::parse(own), Unit::parse(unit)) {
            (Ok(own), Ok(unit)) => own == unit,
            _ => own.eq_ignore_ascii_case(unit),
        };
        let mut own = self.unit.iter().chain(&self.beside).peekable();
        own.peek().is_some() && !own.any(|own| same(own))
    }

    /// Whether this is its name, without a unit.
    pub(super) fn is_named(&self, name: &str) -> bool {
        self.named && name == self.written
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Sort {
    Empty,
    Number,
    Stamp(stamp::Stamp),
    Text,
}

impl Sort {
    fn readable(self) -> bool {
        matches!(self, Self::Number | Self::Stamp(_))
    }
}

fn sort(cell: &[u8], delimiter: u8, first: Option<stamp::First>) -> Sort {
    if cell.is_empty() {
        return Sort::Empty;
    }
    let as_number = match delimiter {
        b',' => number::parse(cell).is_some() || number::parse_quoted(cell).is_some(),
        _ => number::parse_with_comma(cell).is_some(),
    };
    if as_number || number::is_missing(cell) {
        return Sort::Number;
    }
    stamp::parse(cell, first).map_or(Sort::Text, Sort::Stamp)
}

/// What the sampled values tell of the columns, to judge a line by.
struct Known<'a> {
    delimiter: u8,
    heads: &'a [Head],
    numeric: &'a [bool],
}

impl Known<'_> {
    /// Index of the first row of values, none of which is above `from`.
    fn first_row(&self, lines: &[Line<'_>], from: usize) -> Option<usize> {
        let sure = (from..lines.len()).find(|index| self.is_mostly_values(&lines[*index]));
        let sure =
            sure.or_else(|| (from..lines.len()).rfind(|index| self.holds_a_value(&lines[*index])))?;
        let is_row = |index: usize| {
            let above = (index > from).then(|| &lines[index - 1]);
            self.holds_a_value(&lines[index])
                || is_placeholder(&lines[index], above, &lines[index + 1])
        };
        let mut first = sure;
        while first > from && is_row(first - 1) {
            first -= 1;
        }
        if self.is_below_header(&lines[..first], from) {
            return Some(first);
        }
        // Names and titles may be numbers, but where no names stand above them they begin with words.
        let worded = lines[first..sure].iter();
        let worded = worded.take_while(|line| !self.leads_with_value(line));
        Some(first + worded.count())
    }

    /// The cells of columns of numbers or times, and what they are.
    fn sorts<'l>(&'l self, line: &'l Line<'_>) -> impl Iterator<Item = (usize, &'l [u8], Sort)> {
        let cells = line.cells.iter().zip(self.numeric).enumerate();
        let cells = cells.filter(|(_, (_, numeric))| **numeric);
        cells.map(|(index, (cell, _))| {
            let sort = sort(cell, self.delimiter, self.heads[index].first);
            (index, *cell, sort)
        })
    }

    fn is_mostly_values(&self, line: &Line<'_>) -> bool {
        let count = |test: fn(Sort) -> bool| self.sorts(line).filter(|(.., s)| test(*s)).count();
        count(Sort::readable) > count(|s| s == Sort::Text)
    }

    /// Whether a cell is a number or a time as its column has below; among units `1` is one of them, and a time beside nothing but units
    /// is that of whoever wrote them.
    fn holds_a_value(&self, line: &Line<'_>) -> bool {
        let words = || self.sorts(line).filter(|(.., s)| *s == Sort::Text);
        if words().count() > 1
            && words().count() + 1 == self.sorts(line).count()
            && words().all(|(_, cell, _)| is_known_unit(cell))
        {
            return false;
        }
        let mut values =
            (self.sorts(line)).filter(|(index, cell, s)| self.is_value(*index, cell, *s));
        let among_units = || line.cells.iter().any(|c| *c != b"1" && is_known_unit(c));
        values.any(|(_, cell, _)| cell != b"1" || !among_units())
    }

    fn is_value(&self, index: usize, cell: &[u8], sort: Sort) -> bool {
        match sort {
            Sort::Number => !self.heads[index].stamps && !number::is_missing(cell),
            Sort::Stamp(_) => self.heads[index].stamps,
            Sort::Empty | Sort::Text => false,
        }
    }

    fn leads_with_value(&self, line: &Line<'_>) -> bool {
        let first = self.sorts(line).next();
        first.is_some_and(|(index, cell, s)| self.is_value(index, cell, s))
    }

    /// Whether the last of these lines are a header; the first `codes` of them are items of WITS.
    fn is_below_header(&self, above: &[Line<'_>], codes: usize) -> bool {
        let Some((last, before)) = above.split_last() else {
            return false;
        };
        let units = || {
            let names = before.last();
            names.is_some_and(|names| is_unit_row(&last.cells, names, self.numeric))
        };
        above.len() == codes || self.are_names(last) || units()
    }

    /// Whether words of its own stand above every column of numbers or times.
    fn are_names(&self, line: &Line<'_>) -> bool {
        fills_with_names(line, self.numeric) && self.sorts(line).all(|(.., s)| s == Sort::Text)
    }
}

/// Whether a line says one word over and over where values are missing: `No Data,No Data`. Units may be of one word too, but they stand
/// there once.
fn is_placeholder(line: &Line<'_>, above: Option<&Line<'_>>, below: &Line<'_>) -> bool {
    let mut filled = line.cells.iter().filter(|c| !c.is_empty());
    let Some(word) = filled.next() else {
        return false;
    };
    let again = below.cells.contains(word) || above.is_some_and(|above| above.cells == line.cells);
    again && filled.all(|c| c == word) && !is_known_unit(word)
}

pub(super) fn is_known_unit(cell: &[u8]) -> bool {
    Unit::parse(bare(&words(cell))).is_ok()
}

/// The parts of a text from which the samples are taken.
#[derive(Debug, Clone, Copy)]
pub(super) struct Glimpse<'a> {
    pub(super) head: &'a [u8],
    pub(super) middle: &'a [u8],
    /// Byte of the text at which `middle` begins.
    pub(super) middle_at: usize,
}

impl<'a> Glimpse<'a> {
    /// Bytes of either part that are enough, unless a line is longer than half of it.
    pub(super) const ENOUGH: usize = 2 * SAMPLED_BYTES;

    pub(super) fn of(text: &'a [u8]) -> Self {
        let middle_at = text.len() / 2;
        Self {
            head: text,
            middle: &text[middle_at..],
            middle_at,
        }
    }

    /// Whether every sampled line is there to its end, of a text of so many bytes.
    pub(super) fn is_whole(&self, length: usize) -> bool {
        let cut = |part: &[u8], at: usize| at + part.len() < length;
        let (head_cut, middle_cut) = (cut(self.head, 0), cut(self.middle, self.middle_at));
        if middle_cut && !self.middle.contains(&b'\n') {
            return false;
        }
        DELIMITERS.iter().chain(b"\0").all(|delimiter| {
            let Sample { head, middle } = sample(self, *delimiter);
            let open = |lines: &[Line<'_>]| lines.iter().any(|line| line.open);
            !(head_cut && open(&head) || middle_cut && open(&middle))
        })
    }
}

/// Looks at the lines of a text.
///
/// # Errors
/// [`IngestError::NotTabular`], [`IngestError::NothingNumeric`] or too many columns.
pub(super) fn layout(glimpse: &Glimpse<'_>) -> Result<Layout, IngestError> {
    let text = glimpse.head;
    let delimiter = sniff(glimpse).ok_or_else(|| nothing_numeric(text))?;
    let Sample { head, middle } = sample(glimpse, delimiter);
    // The sample's second half is values, whatever stands above it.
    let rows: Vec<&Line<'_>> = head[head.len() / 2..].iter().chain(&middle).collect();
    let mut columns = Columns::of(&rows, width(&head, &middle)?, delimiter);
    let codes = usize::from(head.len() > 1 && are_codes(&head[0]) && !are_codes(&head[1]));
    let first_row = columns
        .known(delimiter)
        .first_row(&head, codes)
        .ok_or_else(|| nothing_numeric(text))?;
    let (above, below) = head.split_at(first_row);
    let values: Vec<&Line<'_>> = below.iter().chain(&middle).collect();
    columns.look_again(&rows, &values, delimiter);
    if let Some(header) = above.last() {
        columns.end(header.cells.len(), &rows);
    }
    name(&mut columns.heads, above, &columns.numeric);
    columns.read_digits_as_times(&values);
    columns.date_the_clock(&values);
    Ok(Layout {
        delimiter,
        readings: Places::of(&columns.heads, &columns.numeric),
        pairs: Pairs::of(&columns.heads, &columns.kinds, &columns.numeric),
        columns: columns.heads,
        start: head[first_row].start,
        line: head[first_row].number,
    })
}

/// Cells of the widest line.
///
/// # Errors
/// Too many.
fn width(head: &[Line<'_>], middle: &[Line<'_>]) -> Result<usize, IngestError> {
    let widths = head.iter().chain(middle).map(|l| l.cells.len());
    let width = widths.max().unwrap_or(0);
    if width > MAX_COLUMNS {
        return Err(IngestError::TooLarge {
            what: format!(
                "the longest of the first lines ({} or more columns)",
                MAX_COLUMNS + 1
            ),
            claimed: width as u64,
            limit: MAX_COLUMNS as u64,
        });
    }
    Ok(width)
}

/// The columns as the sampled lines tell them.
struct Columns {
    heads: Vec<Head>,
    /// Whether they hold numbers or times.
    numeric: Vec<bool>,
    /// What their times are.
    kinds: Vec<Option<stamp::StampKind>>,
}

impl Columns {
    fn of(rows: &[&Line<'_>], width: usize, delimiter: u8) -> Self {
        let mut columns = Self {
            heads: vec![Head::default(); width],
            numeric: vec![false; width],
            kinds: vec![None; width],
        };
        (0..width).for_each(|index| columns.look(index, rows, delimiter));
        columns
    }

    /// Tells what a column is by its cells.
    fn look(&mut self, index: usize, rows: &[&Line<'_>], delimiter: u8) {
        let head = &mut self.heads[index];
        let cells = || rows.iter().filter_map(|l| l.cells.get(index));
        let first = stamp::first(cells().map(|c| c.as_ref()));
        head.first = first;
        let sorts = || cells().map(|c| sort(c, delimiter, first));
        let count = |test: fn(Sort) -> bool| sorts().filter(|s| test(*s)).count();
        let stamps = count(|s| matches!(s, Sort::Stamp(_)));
        let texts = count(|s| s == Sort::Text);
        let numbers = count(|s| s == Sort::Number);
        head.stamps = stamps > numbers;
        self.kinds[index] = sorts().find_map(|s| match s {
            Sort::Stamp(stamp) if head.stamps => Some(stamp.kind),
            _ => None,
        });
        head.two_are_hours = sorts().all(two_may_be_hours);
        self.numeric[index] = stamps + numbers > 0 && stamps + numbers >= texts;
    }

    /// Looks at columns that are empty in these rows in other ones: the shorter ones of several that stand side by side.
    fn look_again(&mut self, rows: &[&Line<'_>], others: &[&Line<'_>], delimiter: u8) {
        for index in 0..self.heads.len() {
            if filled(rows, index).is_empty() {
                self.look(index, others, delimiter);
            }
        }
    }

    fn known(&self, delimiter: u8) -> Known<'_> {
        Known {
            delimiter,
            heads: &self.heads,
            numeric: &self.numeric,
        }
    }

    /// Ends them where the header or the rows do.
    fn end(&mut self, header: usize, rows: &[&Line<'_>]) {
        // One long line makes no column, most of them do.
        let mut lengths: Vec<usize> = rows.iter().map(|l| l.cells.len()).collect();
        lengths.sort_unstable();
        let usual = lengths[lengths.len() / 2];
        self.heads.truncate(usual.max(header));
        for beyond in self.heads.iter_mut().skip(header) {
            beyond.beyond = true;
        }
    }

    /// Digits alone are a number, unless a column of times holds a date or a time of the day in each, or both.
    fn read_digits_as_times(&mut self, values: &[&Line<'_>]) {
        for (index, head) in self.heads.iter_mut().enumerate() {
            if head.stamps || !self.numeric[index] || !is_time_name(&head.tag) {
                continue;
            }
            let cells = filled(values, index);
            if stamp::is_dial(&cells) {
                head.stamps = true;
                head.digits = Some(stamp::Digits::Clock);
                self.kinds[index] = Some(stamp::StampKind::Clock);
            } else {
                head.stamps =
                    !cells.is_empty() && cells.iter().all(|c| stamp::compact(c).is_some());
            }
        }
    }

    /// Finds the dates of a clock in another column.
    fn date_the_clock(&mut self, values: &[&Line<'_>]) {
        let Some(clock) = self.at(stamp::StampKind::Clock) else {
            return;
        };
        let is_date = |index: &usize| {
            let (head, cells) = (&self.heads[*index], filled(values, *index));
            let named = self.numeric[*index] && !head.stamps && is_date_name(&head.tag);
            let digits = |cell: &&[u8]| stamp::Digits::Date.parse(cell).is_some();
            named && !cells.is_empty() && cells.iter().all(digits)
        };
        if self.at(stamp::StampKind::Date).is_some() {
            self.heads[clock].dated = true;
        } else if let Some(date) = (0..self.heads.len()).find(is_date) {
            self.heads[clock].dated = true;
            self.heads[date].stamps = true;
            self.heads[date].digits = Some(stamp::Digits::Date);
        } else if let Some(date) = self.midnights(values) {
            self.heads[clock].dated = true;
            self.heads[date].midnights = true;
        }
    }

    /// The first column of dates that are all written with midnight, as databases write a date.
    fn midnights(&self, values: &[&Line<'_>]) -> Option<usize> {
        (0..self.heads.len()).find(|index| {
            let head = &self.heads[*index];
            let is_one = |cell: &&[u8]| {
                let stamp = stamp::parse(cell, head.first);
                stamp.is_some_and(|stamp| stamp.as_date().is_some())
            };
            let cells = filled(values, *index);
            head.stamps && !cells.is_empty() && cells.iter().all(is_one)
        })
    }

    /// The first column of such times.
    fn at(&self, kind: stamp::StampKind) -> Option<usize> {
        let mut kinds = self.kinds.iter().take(self.heads.len());
        kinds.position(|k| *k == Some(kind))
    }
}

/// The cells of a column in which something stands.
fn filled<'a>(lines: &[&Line<'a>], index: usize) -> Vec<&'a [u8]> {
    let cells = lines.iter().filter_map(|l| l.cells.get(index).copied());
    cells
        .filter(|c| !c.is_empty() && !number::is_missing(c))
        .collect()
}

/// Whether a line names its columns by the four digits of WITS items: record, item.
fn are_codes(line: &Line<'_>) -> bool {
    let is_code = |c: &&[u8]| c.len() == 4 && c.iter().all(u8::is_ascii_digit);
    let distinct: std::collections::BTreeSet<_> = line.cells.iter().collect();
    line.cells.len() > 1
        && line.cells.iter().all(is_code)
        && line.cells.iter().any(|c| c[0] == b'0')
        && distinct.len() == line.cells.len()
}

/// The item of a column that is named as [`are_codes`] says.
fn item(tag: &str) -> Option<&str> {
    let is_code = tag.len() == 4 && tag.bytes().all(|b| b.is_ascii_digit());
    is_code.then(|| &tag[2..])
}

/// Whether a column is named like a date.
fn is_date_name(tag: &str) -> bool {
    tag.to_lowercase().contains("date") || item(tag) == Some("05")
}

/// Whether a column is named like time.
pub(super) fn is_time_name(tag: &str) -> bool {
    if let Some(item) = item(tag) {
        return item == "06";
    }
    is_clock_name(tag)
}

fn two_may_be_hours(sort: Sort) -> bool {
    match sort {
        Sort::Stamp(stamp) => !stamp.speaks_for_minutes(),
        _ => true,
    }
}

struct Sample<'a> {
    head: Vec<Line<'a>>,
    middle: Vec<Line<'a>>,
}

fn sample<'a>(glimpse: &Glimpse<'a>, delimiter: u8) -> Sample<'a> {
    let from = |text: &'a [u8], at: usize| {
        lines(text, at, 1, delimiter)
            .take_while(move |line| line.start < at + SAMPLED_BYTES)
            .take(SAMPLED)
            .collect::<Vec<_>>()
    };
    let head = from(glimpse.head, 0);
    let seen = head.last().map_or(0, |l| l.start);
    let next_line = glimpse.middle.iter().position(|b| *b == b'\n');
    let middle = next_line
        .map(|n| n + 1)
        .filter(|at| glimpse.middle_at + at > seen)
        .map_or_else(Vec::new, |at| from(glimpse.middle, at));
    Sample { head, middle }
}

/// The delimiter that makes most of the cells numbers or times.
fn sniff(glimpse: &Glimpse<'_>) -> Option<u8> {
    let score = |delimiter: &u8| {
        let sampled = sample(glimpse, *delimiter);
        let rows = sampled.head[sampled.head.len() / 2..]
            .iter()
            .chain(&sampled.middle);
        // Lines of words alone, such as headers, speak for no delimiter.
        let line = |line: &Line<'_>| {
            let count = |test: &dyn Fn(&[u8]) -> bool| {
                let cells = line.cells.iter().filter(|c| test(c));
                i64::try_from(cells.count()).unwrap_or(i64::MAX / 1024)
            };
            // A date in slashes is one, whatever comes first in it.
            let is = |cell: &[u8], what: fn(Sort) -> bool| {
                let firsts = [None, Some(stamp::First::Day), Some(stamp::First::Month)];
                firsts.map(|first| what(sort(cell, *delimiter, first)))
            };
            let readable = count(&|c| is(c, Sort::readable).contains(&true));
            let texts = count(&|c| is(c, |s| s == Sort::Text) == [true; 3]);
            (readable > 0).then_some(2 * readable - 3 * texts)
        };
        rows.filter_map(line).reduce(|a, b| a.saturating_add(b))
    };
    // The first of equals wins, so a file of one column is comma separated.
    let scored = DELIMITERS.iter().filter_map(|d| Some((score(d)?, *d)));
    scored
        .rev()
        .max_by_key(|(score, _)| *score)
        .map(|(_, delimiter)| delimiter)
}

fn nothing_numeric(text: &[u8]) -> IngestError {
    let Some(line) = lines(text, 0, 1, 0).next() else {
        return IngestError::Empty;
    };
    let shown = words(line.cells[0]);
    let shown: String = shown.chars().take(60).collect();
    let by_blanks = |line: &Line<'_>| {
        let fields = line.cells[0]
            .split(u8::is_ascii_whitespace)
            .filter(|f| !f.is_empty());
        fields.filter(|f| number::parse(f).is_some()).count() > 1
    };
    if lines(text, 0, 1, 0).take(SAMPLED).any(|l| by_blanks(&l)) {
        return IngestError::NotTabular {
            place: format!("line {}", line.number),
            reason: format!("`{shown}` has numbers between blanks"),
            mend: "separate the cells by comma, semicolon, tab or bar".into(),
        };
    }
    IngestError::NothingNumeric {
        format: "CSV",
        found: format!("it begins with `{shown}`, and no row of numbers follows"),
    }
}

/// Names and units from the lines above the values.
fn name(heads: &mut [Head], above: &[Line<'_>], numeric: &[bool]) {
    let is_units = above.len() > 1
        && is_unit_row(
            above[above.len() - 1].cells.as_slice(),
            &above[above.len() - 2],
            numeric,
        );
    let named = &above[..above.len() - usize::from(is_units)];
    let names = names_of(named, numeric);
    let units = above.last().filter(|_| is_units);
    for (index, head) in heads.iter_mut().enumerate() {
        let text = |line: &Line<'_>| line.cells.get(index).map(|c| words(c)).unwrap_or_default();
        let mut written = names.get(index).cloned().unwrap_or_default();
        if index == 0 && written.starts_with('#') {
            // A header behind a comment sign.
            written = written.trim_start_matches(['#', ' ']).to_owned();
        }
        let (tag, unit) = split_unit(&written);
        head.named = !tag.is_empty();
        head.written = tag.to_owned();
        head.beside = unit.map(str::to_owned);
        head.tag = if head.named {
            tag.to_owned()
        } else {
            format!("c{}", index + 1)
        };
        let below = units
            .map(text)
            .map(|u| bare(&u).to_owned())
            .filter(|u| !u.is_empty() && !is_no_unit(u));
        head.unit = below.or(unit.map(str::to_owned));
    }
    tell_apart(heads.iter_mut().map(|head| &mut head.tag));
}

/// The names of the columns by the last of these lines; where it has one name for several, by the line above it, or by both.
fn names_of(lines: &[Line<'_>], numeric: &[bool]) -> Vec<String> {
    let Some((last, above)) = lines.split_last() else {
        return Vec::new();
    };
    let texts = |line: &Line<'_>| line.cells.iter().map(|c| words(c)).collect::<Vec<_>>();
    let own = texts(last);
    let Some(group) = above.last().filter(|_| repeats(&own, numeric)) else {
        return own;
    };
    if fills_with_names(group, numeric) {
        return texts(group);
    }
    // The name of a group may stand over its first column alone.
    let mut group = texts(group);
    for index in 1..group.len() {
        if group[index].is_empty() {
            group[index] = group[index - 1].clone();
        }
    }
    group.resize(own.len(), String::new());
    let both = group.iter().zip(&own);
    let both = both.map(|(group, own)| format!("{group} {own}").trim().to_owned());
    let both: Vec<String> = both.collect();
    if repeats(&both, numeric) { own } else { both }
}

/// Whether two columns of numbers have one name.
fn repeats(names: &[String], numeric: &[bool]) -> bool {
    let names = names.iter().zip(numeric);
    let names = names.filter(|(name, numeric)| **numeric && !name.is_empty());
    let mut known = std::collections::BTreeSet::new();
    names.into_iter().any(|(name, _)| !known.insert(name))
}

fn is_unit_row(cells: &[&[u8]], names: &Line<'_>, numeric: &[bool]) -> bool {
    let filled: Vec<String> = cells
        .iter()
        .map(|c| words(c))
        .filter(|c| !c.is_empty())
        .collect();
    let known = filled
        .iter()
        .filter(|c| Unit::parse(bare(c)).is_ok())
        .count();
    let bracketed = filled.iter().filter(|c| bare(c).len() < c.len()).count();
    let named = names.cells.iter().filter(|c| !c.is_empty()).count();
    let units_of_their_own = filled.iter().any(|c| split_unit(c).1.is_some());
    if units_of_their_own {
        return false;
    }
    if named < filled.len() {
        // A column without a name, not a title above names that are units.
        let as_wide = names.cells.len() == cells.len();
        return as_wide && 2 * named > filled.len() && known == filled.len();
    }
    // Titles rarely fill every column with words of their own; names do.
    2 * known.max(bracketed) >= filled.len() || fills_with_names(names, numeric)
}

/// Whether every column of numbers has a cell of its own in a line.
fn fills_with_names(line: &Line<'_>, numeric: &[bool]) -> bool {
    let named: Vec<String> = (line.cells.iter())
        .map(|c| words(c))
        .filter(|c| !c.is_empty())
        .collect();
    let distinct: std::collections::BTreeSet<_> = named.iter().collect();
    let filled = |index: usize| line.cells.get(index).is_some_and(|c| !c.is_empty());
    named.len() > 1
        && distinct.len() == named.len()
        && (numeric.iter().enumerate()).all(|(index, numeric)| !numeric || filled(index))
}

/// Whether what stands below a name is a number or a time, which are no units but for `1`.
fn is_no_unit(text: &str) -> bool {
    let cell = text.as_bytes();
    let is_value = number::parse_with_comma(cell).is_some() || stamp::parse(cell, None).is_some();
    is_value && Unit::parse(text).is_err()
}

/// Without the brackets around it.
pub(super) fn bare(unit: &str) -> &str {
    let unit = unit.trim();
    let inner = unit.strip_prefix('[').and_then(|u| u.strip_suffix(']'));
    inner
        .or_else(|| unit.strip_prefix('(').and_then(|u| u.strip_suffix(')')))
        .unwrap_or(unit)
        .trim()
}

/// `FT1 [gpm]` or `FT1 (gpm)` to name and unit.
///
/// Square brackets always hold a unit. Round ones must hold a known unit or a word that
/// starts as one, since names have them too: `ROP (1 ft)`, `Flow (in)`.
pub(super) fn split_unit(written: &str) -> (&str, Option<&str>) {
    let split = |open: char, close: char| {
        let (name, unit) = written.strip_suffix(close)?.rsplit_once(open)?;
        let (name, unit) = (name.trim(), unit.trim());
        (!name.is_empty() && !unit.is_empty()).then_some((name, unit))
    };
    if let Some((name, unit)) = split('[', ']') {
        return (name, Some(unit));
    }
    // The longest opening first: `PT1 (psi(g))`.
    let nested = written.strip_suffix(')').and_then(|w| w.split_once('('));
    let nested = nested
        .map(|(n, u)| (n.trim(), u.trim()))
        .filter(|(n, u)| !n.is_empty() && Unit::parse(u).is_ok());
    match nested.or_else(|| split('(', ')')) {
        Some((name, unit)) if is_unit_word(unit) || is_minutes_of(name, unit) => (name, Some(unit)),
        _ => (written, None),
    }
}

/// Whether `min` behind a name is minutes: `Time (min)`, `Elapsed Time (min)`; `T (min)` is the least temperature.
fn is_minutes_of(name: &str, unit: &str) -> bool {
    let is_time = name != "T" && is_time_name(name) || name.to_lowercase().ends_with("time");
    is_time && unit.eq_ignore_ascii_case("min")
}

fn is_unit_word(text: &str) -> bool {
    const NAME_WORDS: [&str; 12] = [
        "in", "out", "1", "-", "a", "b", "raw", "abs", "avg", "min", "max", "none",
    ];
    if NAME_WORDS.iter().any(|w| text.eq_ignore_ascii_case(w)) {
        return false;
    }
    Unit::parse(text).is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn brackets_hold_units_and_parentheses_hold_them_when_known() {
        assert_eq!(split_unit("FT1 [gpm]"), ("FT1", Some("gpm")));
        assert_eq!(split_unit("FT1 (gpm)"), ("FT1", Some("gpm")));
        assert_eq!(split_unit("PT1 (psi(g))"), ("PT1", Some("psi(g)")));
        assert_eq!(split_unit("Temp Out( degF)"), ("Temp Out", Some("degF")));
        assert_eq!(split_unit("WOB [k-lbs]"), ("WOB", Some("k-lbs")));
        assert_eq!(split_unit("ROP(1 ft)"), ("ROP(1 ft)", None));
        assert_eq!(split_unit("Flow (in)"), ("Flow (in)", None));
        assert_eq!(split_unit("[gpm]"), ("[gpm]", None));
        assert_eq!(split_unit("Time (min)"), ("Time", Some("min")));
        assert_eq!(split_unit("t (min)"), ("t", Some("min")));
        assert_eq!(split_unit("Run Time (min)"), ("Run Time", Some("min")));
        assert_eq!(split_unit("T (min)"), ("T (min)", None));
        assert_eq!(split_unit("Flow (min)"), ("Flow (min)", None));
        assert_eq!(split_unit("Time (max)"), ("Time (max)", None));
        assert_eq!(split_unit(""), ("", None));
    }
}
