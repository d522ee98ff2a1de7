//! Channels are found by name, so no two columns may share one.

use dgd_recording::{Column, Issue, IssueKind};
use std::collections::BTreeMap;

/// Gives each name that stands before another one; returns the indices of those that changed, and what they were.
pub(crate) fn tell_apart<'a>(tags: impl Iterator<Item = &'a mut String>) -> Vec<(usize, String)> {
    let mut seen = BTreeMap::<String, u32>::new();
    let mut changed = Vec::new();
    for (index, tag) in tags.enumerate() {
        let count = seen.entry(tag.clone()).or_default();
        *count += 1;
        if *count > 1 {
            let mut next = *count;
            while seen.contains_key(&format!("{tag}_{next}")) {
                next += 1;
            }
            let other = format!("{tag}_{next}");
            seen.insert(other.clone(), 1);
            changed.push((index, std::mem::replace(tag, other)));
        }
    }
    changed
}

/// [`tell_apart`] for the columns of a table, with what to say of it.
pub(crate) fn tell_columns_apart(columns: &mut [Column]) -> Vec<Issue> {
    let changed = tell_apart(columns.iter_mut().map(|c| &mut c.tag));
    let told = changed.iter();
    told.map(|(index, written)| renamed(*index, written, &columns[*index].tag))
        .collect()
}

/// What to say of a column that has another name than the file gives it.
pub(crate) fn renamed(index: usize, written: &str, tag: &str) -> Issue {
    Issue {
        kind: IssueKind::Renamed,
        place: format!("column {}", index + 1),
        message: format!("`{written}` is the name of a column before it; it is `{tag}` here"),
    }
}
