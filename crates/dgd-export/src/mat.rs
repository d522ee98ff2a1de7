//! What both MAT formats share: the names of the struct's fields, and its texts.

use std::collections::HashSet;

use dgd_recording::Table;

use crate::error::ExportError;

/// Longest name that MATLAB takes.
pub(crate) const MAX_NAME: usize = 63;
pub(crate) const UNITS: &str = "units";
pub(crate) const ORIGIN: &str = "origin";

/// The field that each column of `table` is written to in the struct `root`.
///
/// A leading `root.` goes; what MATLAB does not take in a name becomes `_`; a name that
/// begins otherwise than with a letter, and a word of the language such as `end`, gets an `x`; a second column of the same name gets
/// `_2`. The fields `units` and `origin` are kept for the units and the start time.
///
/// ```
/// use dgd_export::field_names;
/// use dgd_recording::{Column, Table};
/// let column = |tag: &str| Column { tag: tag.into(), ..Column::default() };
/// let columns = ["gom.FT1", "Hook load", "2nd", "gom.FT1"].map(column).to_vec();
/// let table = Table { columns, ..Table::default() };
/// assert_eq!(field_names(&table, "gom"), ["FT1", "Hook_load", "x2nd", "FT1_2"]);
/// ```
pub fn field_names(table: &Table, root: &str) -> Vec<String> {
    let mut taken: HashSet<String> = [UNITS, ORIGIN].map(String::from).into();
    table
        .columns
        .iter()
        .map(|column| {
            let tag = column
                .tag
                .strip_prefix(root)
                .and_then(|t| t.strip_prefix('.'))
                .unwrap_or(&column.tag);
            let mut plain = plain_name(tag);
            if KEYWORDS.contains(&plain.as_str()) {
                plain.insert(0, 'x');
            }
            let mut name = plain.clone();
            let mut count = 1_usize;
            while !taken.insert(name.clone()) {
                count += 1;
                let ending = format!("_{count}");
                let room = MAX_NAME - ending.len();
                name = plain[..plain.len().min(room)].to_owned() + &ending;
            }
            name
        })
        .collect()
}

/// The struct that the columns of `table` were fields of: what every tag begins with up to a dot, but for one (a clock that stands
/// by itself). `None` where they have nothing in common, or no name that MATLAB takes.
///
/// ```
/// use dgd_export::struct_of;
/// use dgd_recording::{Column, Table};
/// let table = |tags: &[&str]| Table {
///     columns: tags.iter().map(|tag| Column { tag: (*tag).into(), ..Column::default() }).collect(),
///     ..Table::default()
/// };
/// assert_eq!(struct_of(&table(&["t", "rig_data.FT1", "rig_data.FT2"])), Some("rig_data"));
/// assert_eq!(struct_of(&table(&["t", "FT1.raw", "FT2"])), None);
/// ```
pub fn struct_of(table: &Table) -> Option<&str> {
    let heads = || {
        table
            .columns
            .iter()
            .map(|column| column.tag.split_once('.'))
    };
    let (root, _) = heads().flatten().next()?;
    let fields = heads().filter(|head| head.is_some_and(|(head, _)| head == root));
    let (fields, columns) = (fields.count(), table.columns.len());
    let alone = heads().filter(Option::is_none).count();
    let whole = fields == columns || (fields > 1 && alone == 1 && fields + 1 == columns);
    (whole && is_name(root)).then_some(root)
}

/// Words of the language, which no name may be: what `iskeyword` lists, MATLAB R2024b.
const KEYWORDS: [&str; 20] = [
    "break",
    "case",
    "catch",
    "classdef",
    "continue",
    "else",
    "elseif",
    "end",
    "for",
    "function",
    "global",
    "if",
    "otherwise",
    "parfor",
    "persistent",
    "return",
    "spmd",
    "switch",
    "try",
    "while",
];

/// Whether MATLAB takes a name as it is.
pub(crate) fn is_name(name: &str) -> bool {
    name.len() <= MAX_NAME && plain_name(name) == name && !KEYWORDS.contains(&name)
}

pub(crate) fn plain_name(tag: &str) -> String {
    let mut name = String::new();
    for c in tag.chars().take(MAX_NAME) {
        if name.is_empty() && !c.is_ascii_alphabetic() {
            name.push('x');
        }
        name.push(if c.is_ascii_alphanumeric() { c } else { '_' });
    }
    if name.is_empty() {
        name.push('x');
    }
    name.truncate(MAX_NAME);
    name
}

/// A table that can become a MATLAB struct.
pub(crate) struct Struct<'t> {
    pub(crate) fields: Vec<(String, &'t [f64])>,
    /// Field and unit of each column that has one.
    pub(crate) units: Vec<(String, &'t str)>,
    pub(crate) origin: Option<&'t str>,
}

impl<'t> Struct<'t> {
    pub(crate) fn new(table: &'t Table, root: &str) -> Result<Self, ExportError> {
        if table.columns.is_empty() {
            return Err(ExportError::NoColumns);
        }
        if !is_name(root) {
            return Err(ExportError::Name { name: root.into() });
        }
        let names = field_names(table, root);
        let units = names
            .iter()
            .zip(&table.columns)
            .filter_map(|(name, column)| Some((name.clone(), column.unit.as_deref()?)))
            .filter(|(_, unit)| !unit.is_empty())
            .collect();
        let fields = names
            .into_iter()
            .zip(&table.columns)
            .map(|(name, column)| (name, column.values.as_slice()))
            .collect();
        Ok(Self {
            fields,
            units,
            origin: table.origin.as_deref(),
        })
    }
}
