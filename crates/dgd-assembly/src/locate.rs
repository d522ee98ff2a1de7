//! Finds the line of a path in the text of a system.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Line and column, from 1, of a byte offset.
pub(crate) fn line_and_column(text: &str, offset: usize) -> (usize, usize) {
    let mut end = offset.min(text.len());
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    let before = &text[..end];
    let start = before.rfind('\n').map_or(0, |i| i + 1);
    (
        before.matches('\n').count() + 1,
        before[start..].chars().count() + 1,
    )
}

/// Line of the nearest thing in the text that `path` names.
pub(crate) fn line_of(text: &str, path: &str) -> Option<usize> {
    let document = DeTable::parse(text).ok()?;
    let table = document.get_ref();
    let line = |offset: usize| Some(line_and_column(text, offset).0);
    for section in ["free", "inputs", "initial"] {
        if let Some(found) = get(table, section).and_then(|v| get(v.get_ref().as_table()?, path)) {
            return line(found.span().start);
        }
    }
    if let Some(rest) = path.strip_prefix("connections") {
        let list = get(table, "connections")?;
        let index: Option<usize> = rest.trim_matches(['[', ']']).parse().ok();
        let item = index.and_then(|i| list.get_ref().as_array()?.get(i));
        return line(item.map_or(list.span().start, |i| i.span().start));
    }
    let mut keys = path.split('.');
    let first = keys.next()?;
    let mut here = match get(table, "components").and_then(|v| get(v.get_ref().as_table()?, first))
    {
        Some(found) => found,
        None => get(table, first)?,
    };
    for key in keys {
        match here.get_ref().as_table().and_then(|t| get(t, key)) {
            Some(next) => here = next,
            None => break,
        }
    }
    line(here.span().start)
}

fn get<'a, 'i>(table: &'a DeTable<'i>, key: &str) -> Option<&'a Spanned<DeValue<'i>>> {
    table
        .iter()
        .find(|(k, _)| k.get_ref() == key)
        .map(|(_, v)| v)
}
