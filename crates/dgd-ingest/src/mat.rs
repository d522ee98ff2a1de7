//! What MAT v5 and MAT v7.3 have in common: how arrays become columns, how
//! texts become units, and how much a file may ask for.

mod array;
mod units;

use std::collections::HashMap;

use dgd_recording::{Column, Issue, IssueKind, Table};

use crate::error::IngestError;
use crate::nulls::Nulls;
pub(crate) use array::{Layout, Number, NumberKind, Sink};
use units::Texts;

/// Most values that one file may decode to: 2 GiB of doubles, eleven channels
/// at 1 Hz for nine months.
const MAX_VALUES: u64 = 1 << 28;
/// Deflate cannot expand more than 1032 times; the rest is for small files.
const MAX_EXPANSION: u64 = 1040;
const SMALL_FILE_VALUES: u64 = 1 << 16;
/// Beyond 64 MiB of doubles, most values for each byte of the file: 200 times its size. Rig
/// data reach about 20; what expands more is a bomb.
const MAX_VALUES_A_BYTE: u64 = 25;
const SPARE_VALUES: u64 = 1 << 23;
pub(crate) const MAX_COLUMNS: usize = 16_384;
/// Most fields, cells, groups and data sets of one file.
const MAX_PARTS: u64 = 1 << 20;
const MAX_ISSUES: usize = 200;
const MAX_TEXTS: usize = 16_384;
/// Deepest nesting of structs, cells and groups.
pub(crate) const MAX_DEPTH: usize = 24;
/// Longest joined name in bytes.
const MAX_NAME: usize = 1024;
/// Longest text that is looked at.
pub(crate) const MAX_TEXT: u64 = 4096;
/// Longest unit in bytes; every column of an array gets its own copy.
const MAX_UNIT: usize = 64;

/// Trouble at one place of the file, before it is known whether anything is usable.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Fault {
    pub(crate) kind: FaultKind,
    pub(crate) place: String,
    pub(crate) reason: String,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FaultKind {
    Truncated,
    Damaged,
    TooLarge { claimed: u64, limit: u64 },
}

impl Fault {
    pub(crate) fn damaged(place: impl Into<String>, reason: impl Into<String>) -> Self {
        Self {
            kind: FaultKind::Damaged,
            place: place.into(),
            reason: reason.into(),
        }
    }

    pub(crate) fn truncated(place: impl Into<String>, reason: impl Into<String>) -> Self {
        Self {
            kind: FaultKind::Truncated,
            place: place.into(),
            reason: reason.into(),
        }
    }

    pub(crate) fn too_large(what: impl Into<String>, claimed: u64, limit: u64) -> Self {
        Self {
            kind: FaultKind::TooLarge { claimed, limit },
            place: what.into(),
            reason: format!("it claims {claimed}, the limit is {limit}"),
        }
    }

    pub(crate) fn into_error(self, format: &'static str) -> IngestError {
        match self.kind {
            FaultKind::TooLarge { claimed, limit } => IngestError::TooLarge {
                what: self.place,
                claimed,
                limit,
            },
            FaultKind::Truncated => IngestError::Damaged {
                format,
                place: self.place,
                reason: self.reason,
                mend: "the file ends early: copy it again from its source".into(),
            },
            FaultKind::Damaged => IngestError::Damaged {
                format,
                place: self.place,
                reason: self.reason,
                mend: "copy it again from its source, or save it again in MATLAB".into(),
            },
        }
    }
}

/// Gathers the columns, texts and issues of one MAT file.
#[derive(Debug)]
pub(crate) struct Collector {
    format: &'static str,
    columns: Vec<Column>,
    /// What stood for no value in each column.
    nulls: Vec<Nulls>,
    issues: Vec<Issue>,
    more_issues: usize,
    texts: Vec<(String, String)>,
    /// Units that the file ties to a column itself, by tag of the whole array.
    units: HashMap<String, String>,
    values_left: u64,
    limit: u64,
    parts: u64,
    first_fault: Option<Fault>,
    passed_over: Vec<String>,
}

/// How much had been gathered at some moment; see [`Collector::roll_back`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mark {
    columns: usize,
    texts: usize,
}

impl Collector {
    pub(crate) fn new(format: &'static str, file_bytes: usize) -> Self {
        let limit = (file_bytes as u64)
            .saturating_mul(MAX_EXPANSION)
            .saturating_add(SMALL_FILE_VALUES)
            .min(SPARE_VALUES + MAX_VALUES_A_BYTE.saturating_mul(file_bytes as u64))
            .min(MAX_VALUES);
        Self {
            format,
            columns: Vec::new(),
            nulls: Vec::new(),
            issues: Vec::new(),
            more_issues: 0,
            texts: Vec::new(),
            units: HashMap::new(),
            values_left: limit,
            limit,
            parts: 0,
            first_fault: None,
            passed_over: Vec::new(),
        }
    }

    /// Takes `values` from what this file may still ask for.
    pub(crate) fn charge(&mut self, tag: &str, values: u64) -> Result<(), Fault> {
        if values > self.values_left {
            return Err(Fault::too_large(
                format!("`{tag}` (values)"),
                values,
                self.limit,
            ));
        }
        self.values_left -= values;
        Ok(())
    }

    /// Counts a field, cell, group or data set.
    pub(crate) fn count_part(&mut self, tag: &str) -> Result<(), Fault> {
        self.parts += 1;
        if self.parts > MAX_PARTS {
            return Err(Fault::too_large(
                format!("the number of parts up to `{tag}`"),
                self.parts,
                MAX_PARTS,
            ));
        }
        Ok(())
    }

    /// Whether there are more parts than are read.
    pub(crate) fn is_full(&self) -> bool {
        self.parts > MAX_PARTS
    }

    pub(crate) fn issue(
        &mut self,
        kind: IssueKind,
        place: impl Into<String>,
        message: impl Into<String>,
    ) {
        if self.issues.len() < MAX_ISSUES {
            self.issues.push(Issue {
                kind,
                place: place.into(),
                message: message.into(),
            });
        } else {
            self.more_issues += 1;
        }
    }

    /// A variable that holds no channels.
    pub(crate) fn skip(&mut self, tag: &str, reason: impl AsRef<str>) {
        let reason = reason.as_ref();
        if self.passed_over.len() < 4 {
            self.passed_over.push(format!("`{tag}`: {reason}"));
        }
        self.issue(
            IssueKind::Skipped,
            format!("`{tag}`"),
            format!("{reason}; it was passed over"),
        );
    }

    /// Trouble that ended (a part of) the reading; it becomes the error if nothing is usable.
    pub(crate) fn fault(&mut self, fault: Fault, left_out: &str) {
        let kind = match fault.kind {
            FaultKind::Truncated => IssueKind::Truncated,
            FaultKind::Damaged | FaultKind::TooLarge { .. } => IssueKind::Damaged,
        };
        self.issue(
            kind,
            fault.place.clone(),
            format!("{}; {left_out}", fault.reason),
        );
        self.first_fault.get_or_insert(fault);
    }

    pub(crate) fn text(&mut self, tag: &str, text: String) {
        // A text deflates as well as values do, and takes room as they do.
        let room = (tag.len() + text.len()) as u64 / 8 + 8;
        if self.texts.len() < MAX_TEXTS && self.charge(tag, room).is_ok() {
            self.texts.push((tag.to_owned(), text));
        }
    }

    /// A unit that the file ties to the array `tag` itself.
    pub(crate) fn unit(&mut self, tag: &str, unit: String) {
        if self.units.len() < MAX_COLUMNS && unit.len() <= MAX_UNIT {
            self.units.insert(tag.to_owned(), unit);
        }
    }

    pub(crate) fn mark(&self) -> Mark {
        Mark {
            columns: self.columns.len(),
            texts: self.texts.len(),
        }
    }

    /// Forgets the columns and texts gathered since; returns how many columns that were.
    pub(crate) fn roll_back(&mut self, mark: Mark) -> usize {
        let dropped = self.columns.len() - mark.columns;
        self.columns.truncate(mark.columns);
        self.nulls.truncate(mark.columns);
        self.texts.truncate(mark.texts);
        dropped
    }

    pub(crate) fn columns_since(&self, mark: Mark) -> usize {
        self.columns.len() - mark.columns
    }

    /// Whether another array of this layout may come under this name.
    pub(crate) fn has_room(&mut self, tag: &str, layout: Layout) -> bool {
        let room = self.columns.len() + layout.columns <= MAX_COLUMNS;
        if !room {
            self.skip(tag, format!("the file has more than {MAX_COLUMNS} columns"));
        }
        room
    }

    pub(crate) fn array(&mut self, tag: &str, sink: Sink) {
        let layout = sink.layout();
        for (k, mut values) in sink.into_columns().into_iter().enumerate() {
            if values.capacity() > values.len() + values.len() / 8 {
                values.shrink_to_fit();
            }
            let tag = match (layout.columns, layout.interleaved) {
                (1, _) => tag.to_owned(),
                (_, false) => format!("{tag}(:,{})", k + 1),
                (_, true) => format!("{tag}({},:)", k + 1),
            };
            self.nulls.push(Nulls::blanked(&mut values));
            self.columns.push(Column {
                tag,
                unit: None,
                values,
            });
        }
    }

    /// The table, with units found among the texts.
    ///
    /// # Errors
    /// The first fault if there is no column, else [`IngestError::NothingNumeric`].
    pub(crate) fn finish(mut self) -> Result<Table, IngestError> {
        if self.columns.is_empty() {
            return Err(match self.first_fault {
                Some(fault) => fault.into_error(self.format),
                None => IngestError::NothingNumeric {
                    format: self.format,
                    found: self.found(),
                },
            });
        }
        self.tell_of_log_nulls();
        let mut shelf = Texts::new(&self.texts);
        for column in &mut self.columns {
            let base = base_of(&column.tag);
            column.unit = self
                .units
                .get(base)
                .cloned()
                .or_else(|| shelf.unit_as_spelt(base));
        }
        for column in self.columns.iter_mut().filter(|c| c.unit.is_none()) {
            column.unit = shelf.unit_in_any_case(base_of(&column.tag));
        }
        let origin = shelf.origin();
        let unused = shelf.unused();
        let origin = match origin {
            Some(Err((tag, text))) => {
                let shown: String = text.chars().take(40).collect();
                let place = format!("`{tag}`");
                let message = format!(
                    "`{shown}` is no time such as 2024-10-22T15:27:49Z; the start is left unknown"
                );
                self.issues.push(Issue {
                    kind: IssueKind::Skipped,
                    place,
                    message,
                });
                None
            }
            Some(Ok(origin)) => Some(origin),
            None => None,
        };
        if let Some((first, count)) = unused {
            let message = match count {
                1 => "it is text; it was passed over".to_owned(),
                _ => format!(
                    "it and {} others are text; they were passed over",
                    count - 1
                ),
            };
            self.issue(IssueKind::Skipped, format!("`{first}`"), message);
        }
        if self.more_issues > 0 {
            self.issues.push(Issue {
                kind: IssueKind::Skipped,
                place: "file".into(),
                message: format!(
                    "{} more issues like these were not listed",
                    self.more_issues
                ),
            });
        }
        Ok(Table {
            columns: self.columns,
            issues: self.issues,
            origin,
            clock: None,
        })
    }

    /// Tells which columns held numbers that stand for no value.
    fn tell_of_log_nulls(&mut self) {
        let columns = self.columns.iter().zip(&self.nulls);
        let told = columns.filter_map(|(column, nulls)| {
            let (number, said) = nulls.told()?;
            Some((format!("`{}`, value {number}", column.tag), said))
        });
        for (place, message) in told.collect::<Vec<_>>() {
            self.issue(IssueKind::UnreadableValue, place, message);
        }
    }

    fn found(&self) -> String {
        match (self.passed_over.is_empty(), self.texts.first()) {
            (false, _) => self.passed_over.join(", "),
            (true, Some((tag, _))) => format!("only text, as in `{tag}`"),
            (true, None) => "it holds no variable".into(),
        }
    }
}

/// The name of the array that a column `name(:,3)` or `name(3,:)` belongs to.
fn base_of(tag: &str) -> &str {
    tag.strip_suffix(')')
        .and_then(|t| t.rsplit_once('('))
        .filter(|(_, index)| index.contains(':'))
        .map_or(tag, |(base, _)| base)
}

/// `head.name`, or `None` where that grows too long.
pub(crate) fn join(head: &str, name: &str) -> Option<String> {
    if head.len() + name.len() + 1 > MAX_NAME {
        return None;
    }
    Some(if head.is_empty() {
        name.to_owned()
    } else {
        format!("{head}.{name}")
    })
}
