//! Walks a parsed document, noting every problem with its place instead of
//! stopping at the first.

use crate::{DocumentError, Problem};
use dgd_units::{Dimension, Unit, UnitError, split_number};
use std::cell::RefCell;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A value with its place.
pub(crate) type Value<'i> = Spanned<DeValue<'i>>;

/// Problems met so far, and warnings beside them.
#[derive(Default)]
pub(crate) struct Notes {
    /// Whether messages must not show values.
    confidential: bool,
    problems: RefCell<Vec<Problem>>,
    /// Keys that are needed and not there: told together, section by section.
    absent: RefCell<Vec<Absent>>,
    warnings: RefCell<Vec<Problem>>,
}

/// The keys that one section lacks.
struct Absent {
    span: Range<usize>,
    title: String,
    keys: Vec<String>,
    /// The line to add for each.
    lines: Vec<String>,
}

impl Absent {
    fn told(self) -> Problem {
        let help = match self.lines.as_slice() {
            [only] => format!("add a line such as `{only}`"),
            several => format!("add lines such as\n  {}", several.join("\n  ")),
        };
        Problem {
            span: self.span,
            message: format!("{} has no {}", self.title, listed(&self.keys)),
            help: Some(help),
        }
    }
}

/// "`a`, `b` and `c`".
fn listed(keys: &[String]) -> String {
    match keys {
        [] => String::new(),
        [only] => format!("`{only}`"),
        [others @ .., last] => format!("`{}` and `{last}`", others.join("`, `")),
    }
}

impl Notes {
    /// Notes of a document whose values must not appear in a message.
    pub(crate) fn confidential() -> Self {
        Self {
            confidential: true,
            ..Self::default()
        }
    }

    pub(crate) fn problem(&self, span: Range<usize>, message: String, help: Option<String>) {
        self.problems.borrow_mut().push(Problem {
            span,
            message,
            help,
        });
    }

    /// Notes that a section lacks a key.
    fn absent(&self, span: Range<usize>, title: String, key: &str, example: &str) {
        let mut absent = self.absent.borrow_mut();
        let known = absent
            .iter()
            .position(|a| a.span == span && a.title == title);
        let at = known.unwrap_or(absent.len());
        if known.is_none() {
            absent.push(Absent {
                span,
                title,
                keys: Vec::new(),
                lines: Vec::new(),
            });
        }
        absent[at].keys.push(key.to_owned());
        absent[at].lines.push(format!("{key} = {example}"));
    }

    fn warning(&self, span: Range<usize>, message: String, help: Option<String>) {
        self.warnings.borrow_mut().push(Problem {
            span,
            message,
            help,
        });
    }

    /// The result, if nothing was wrong, with the warnings.
    pub(crate) fn conclude<T>(
        self,
        source: &str,
        value: Option<T>,
    ) -> Result<(T, Vec<Problem>), DocumentError> {
        let mut problems = self.problems.into_inner();
        if !self.absent.borrow().is_empty() {
            // What is missing may stand there under another name.
            problems.extend(self.warnings.borrow_mut().drain(..));
        }
        problems.extend(self.absent.into_inner().into_iter().map(Absent::told));
        match value {
            Some(value) if problems.is_empty() => Ok((value, self.warnings.into_inner())),
            _ => Err(DocumentError::new(source, problems)),
        }
    }
}

/// Parses TOML; its syntax errors become a [`DocumentError`].
pub(crate) fn parse(source: &str) -> Result<Spanned<DeTable<'_>>, DocumentError> {
    DeTable::parse(source).map_err(|error| {
        let span = error.span().unwrap_or(0..source.len().min(1));
        let message = format!("this is not TOML: {}", error.message());
        DocumentError::new(
            source,
            vec![Problem {
                span,
                message,
                help: None,
            }],
        )
    })
}

/// A table of the document, and which of its keys have been asked for.
pub(crate) struct Section<'a, 'i> {
    name: String,
    span: Range<usize>,
    table: &'a DeTable<'i>,
    asked: RefCell<Vec<&'static str>>,
    notes: &'a Notes,
}

impl<'a, 'i> Section<'a, 'i> {
    pub(crate) fn new(
        name: &str,
        span: Range<usize>,
        table: &'a DeTable<'i>,
        notes: &'a Notes,
    ) -> Self {
        Self {
            name: name.to_owned(),
            span,
            table,
            asked: RefCell::default(),
            notes,
        }
    }

    /// The value of a key, if it is there.
    pub(crate) fn get(&self, key: &'static str) -> Option<&'a Value<'i>> {
        self.asked.borrow_mut().push(key);
        self.table
            .iter()
            .find(|(k, _)| k.get_ref() == key)
            .map(|(_, v)| v)
    }

    /// The value of a key that must be there.
    pub(crate) fn need(&self, key: &'static str, example: &str) -> Option<&'a Value<'i>> {
        let found = self.get(key);
        if found.is_none() {
            self.notes
                .absent(self.span.clone(), self.title(), key, example);
        }
        found
    }

    /// A table inside this one.
    pub(crate) fn section(&self, key: &'static str) -> Option<Section<'a, 'i>> {
        self.get(key).and_then(|value| self.table_of(key, value))
    }

    /// A table inside this one that must be there.
    pub(crate) fn need_section(&self, key: &'static str) -> Option<Section<'a, 'i>> {
        let value = self.get(key);
        if value.is_none() {
            let name = self.path(key);
            self.notes.problem(
                self.span.start..self.span.start,
                format!("the section [{name}] is missing"),
                Some(format!("add `[{name}]`")),
            );
        }
        value.and_then(|value| self.table_of(key, value))
    }

    fn table_of(&self, key: &str, value: &'a Value<'i>) -> Option<Section<'a, 'i>> {
        let Some(table) = value.get_ref().as_table() else {
            self.wrong_type(key, value, "a table");
            return None;
        };
        Some(Section::new(
            &self.path(key),
            value.span(),
            table,
            self.notes,
        ))
    }

    fn path(&self, key: &str) -> String {
        if self.name.is_empty() {
            key.to_owned()
        } else {
            format!("{}.{key}", self.name)
        }
    }

    fn title(&self) -> String {
        if self.name.is_empty() {
            "the document".into()
        } else {
            format!("[{}]", self.name)
        }
    }

    /// Notes that a value is of the wrong type.
    pub(crate) fn wrong_type(&self, key: &str, value: &Value<'i>, expected: &str) {
        let found = value.get_ref().type_str();
        self.notes.problem(
            value.span(),
            format!("`{key}` is {} {found}, expected {expected}", article(found)),
            None,
        );
    }

    /// A text.
    pub(crate) fn text(&self, key: &str, value: &'a Value<'i>) -> Option<&'a str> {
        let text = value.get_ref().as_str();
        if text.is_none() {
            self.wrong_type(key, value, "a string in quotes");
        }
        text
    }

    /// A finite number.
    pub(crate) fn number(&self, key: &str, value: &Value<'i>) -> Option<f64> {
        let parsed = match value.get_ref() {
            DeValue::Float(float) => float.as_str().replace('_', "").parse().ok(),
            DeValue::Integer(integer) => {
                i64::from_str_radix(&integer.as_str().replace('_', ""), integer.radix())
                    .ok()
                    .map(|i| i as f64)
            }
            _ => None,
        };
        let finite = parsed.filter(|x: &f64| x.is_finite());
        if finite.is_none() {
            self.wrong_type(key, value, "a finite number");
        }
        finite
    }

    /// A number that may also be `nan` or `inf`: a statistic of a fit.
    fn number_or_nan(&self, key: &str, value: &Value<'i>) -> Option<f64> {
        match value.get_ref() {
            DeValue::Float(float) => match float.as_str().trim_start_matches(['+', '-']) {
                "nan" => Some(f64::NAN),
                "inf" if float.as_str().starts_with('-') => Some(f64::NEG_INFINITY),
                "inf" => Some(f64::INFINITY),
                _ => self.number(key, value),
            },
            _ => self.number(key, value),
        }
    }

    /// A whole number of at least 0 that may be absent.
    pub(crate) fn optional_count(&self, key: &'static str) -> Option<u64> {
        self.get(key).and_then(|value| self.count(key, value))
    }

    fn count(&self, key: &str, value: &Value<'i>) -> Option<u64> {
        let parsed = match value.get_ref() {
            DeValue::Integer(integer) => {
                u64::from_str_radix(&integer.as_str().replace('_', ""), integer.radix()).ok()
            }
            _ => None,
        };
        if parsed.is_none() {
            self.wrong_type(key, value, "a whole number of at least 0");
        }
        parsed
    }

    /// Every key of the section with its count, in the order of the document.
    pub(crate) fn counts(&self) -> Vec<(String, u64)> {
        // The parser's table is sorted by key.
        let mut entries: Vec<_> = self.table.iter().collect();
        entries.sort_by_key(|(k, _)| k.span().start);
        entries
            .into_iter()
            .filter_map(|(k, v)| Some((k.get_ref().to_string(), self.count(k.get_ref(), v)?)))
            .collect()
    }

    /// Every key with its place, in the order of the document.
    pub(crate) fn keys(&self) -> Vec<(&'a str, Range<usize>)> {
        let mut keys: Vec<_> = self.table.iter().collect();
        keys.sort_by_key(|(k, _)| k.span().start);
        keys.into_iter()
            .map(|(k, _)| (k.get_ref().as_ref(), k.span()))
            .collect()
    }

    /// A needed finite number.
    pub(crate) fn need_number(&self, key: &'static str) -> Option<f64> {
        self.need(key, "<number>")
            .and_then(|value| self.number(key, value))
    }

    /// A number that may be absent, `nan` or `inf`: a statistic of a fit.
    pub(crate) fn optional_statistic(&self, key: &'static str) -> Option<f64> {
        self.get(key)
            .and_then(|value| self.number_or_nan(key, value))
    }

    /// A written value such as `"19.5 in"`, as SI, positive.
    pub(crate) fn quantity(
        &self,
        key: &str,
        value: &'a Value<'i>,
        dimension: Dimension,
        example: &str,
    ) -> Option<f64> {
        let written = match value.get_ref() {
            DeValue::Float(_) | DeValue::Integer(_) => {
                self.notes.problem(
                    value.span(),
                    format!("`{key}` is a number without a unit"),
                    Some(format!(
                        "write it with its unit, such as `{key} = \"{example}\"`"
                    )),
                );
                return None;
            }
            _ => self.text(key, value)?,
        };
        if written.trim_start().starts_with('?') {
            self.notes.problem(
                value.span(),
                format!("`{key}` is not filled in"),
                Some(format!("write its value, such as `{key} = \"{example}\"`")),
            );
            return None;
        }
        let si = split_number(written).and_then(|(number, unit)| {
            if unit.is_empty() {
                return Err(UnitError::NoUnit {
                    found: written.to_owned(),
                    example: dimension.example(),
                });
            }
            Ok(Unit::parse_as(unit, dimension)?.to_si(number))
        });
        match si {
            Ok(si) if si.is_finite() => Some(si),
            Ok(_) => {
                self.notes
                    .problem(value.span(), format!("`{key}` is out of range"), None);
                None
            }
            Err(error) => {
                let message = match &error {
                    _ if self.notes.confidential => {
                        format!("`{key}` is not a {dimension} with a unit")
                    }
                    // Its example is a length, the help's is of this key.
                    UnitError::NoNumber { found } => {
                        format!("`{key}`: `{found}` does not begin with a number")
                    }
                    _ => format!("`{key}`: {error}"),
                };
                self.notes.problem(
                    value.span(),
                    message,
                    Some(format!("such as \"{example}\"")),
                );
                None
            }
        }
    }

    /// A needed quantity above zero.
    pub(crate) fn need_positive(
        &self,
        key: &'static str,
        dimension: Dimension,
        example: &str,
    ) -> Option<f64> {
        let value = self.need(key, &format!("\"{example}\""))?;
        self.positive(key, value, dimension, example)
    }

    /// A quantity above zero that may be absent.
    pub(crate) fn optional_positive(
        &self,
        key: &'static str,
        dimension: Dimension,
        example: &str,
    ) -> Option<f64> {
        self.get(key)
            .and_then(|value| self.positive(key, value, dimension, example))
    }

    /// A quantity above zero.
    pub(crate) fn positive(
        &self,
        key: &str,
        value: &'a Value<'i>,
        dimension: Dimension,
        example: &str,
    ) -> Option<f64> {
        let si = self.quantity(key, value, dimension, example)?;
        if si > 0.0 {
            return Some(si);
        }
        let message = if self.notes.confidential {
            format!("`{key}` is not more than 0")
        } else {
            format!(
                "`{key}` is {si} {}, expected more than 0",
                dimension.si_symbol()
            )
        };
        self.notes.problem(value.span(), message, None);
        None
    }

    /// Warns of keys that nobody asked for, with the nearest one that would be read.
    pub(crate) fn warn_of_unread(&self) {
        let asked = self.asked.borrow();
        for (key, _) in self
            .table
            .iter()
            .filter(|(k, _)| !asked.iter().any(|a| a == k.get_ref()))
        {
            let known = asked.join("`, `");
            self.notes.warning(
                key.span(),
                format!("`{}` in {} is not read", key.get_ref(), self.title()),
                Some(format!("known here: `{known}`")),
            );
        }
    }

    /// Notes a problem at a value.
    pub(crate) fn problem(&self, value: &Value<'i>, message: String, help: Option<String>) {
        self.notes.problem(value.span(), message, help);
    }

    /// Place of the section.
    pub(crate) fn span(&self) -> Range<usize> {
        self.span.clone()
    }

    /// Where problems are noted.
    pub(crate) fn notes(&self) -> &'a Notes {
        self.notes
    }
}

fn article(noun: &str) -> &'static str {
    if noun.starts_with(['a', 'e', 'i', 'o', 'u']) {
        "an"
    } else {
        "a"
    }
}
