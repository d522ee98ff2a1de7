//! What is wrong with a document, and where.

use std::fmt;
use std::ops::Range;

/// One thing wrong, at one place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// Byte range in the source.
    pub span: Range<usize>,
    /// What is wrong.
    pub message: String,
    /// How to mend it, where that is known.
    pub help: Option<String>,
}

/// Everything wrong with a document.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DocumentError {
    /// In the order of the document; never empty.
    pub problems: Vec<Problem>,
    /// Line and column of each problem, from 1.
    pub places: Vec<(usize, usize)>,
}

impl DocumentError {
    pub(crate) fn new(source: &str, mut problems: Vec<Problem>) -> Self {
        problems.sort_by_key(|p| (p.span.start, p.span.end));
        let places = places(source, &problems);
        Self { problems, places }
    }
}

/// Places of problems in order, in one walk over the source: a damaged list may have many.
fn places(source: &str, problems: &[Problem]) -> Vec<(usize, usize)> {
    let (mut line, mut line_start, mut seen) = (1, 0, 0);
    let mut place = |offset: usize| {
        let offset = floor_char_boundary(source, offset);
        let passed = &source[seen..offset];
        if let Some(newline) = passed.rfind('\n') {
            line += passed.matches('\n').count();
            line_start = seen + newline + 1;
        }
        seen = offset;
        (line, source[line_start..offset].chars().count() + 1)
    };
    problems.iter().map(|p| place(p.span.start)).collect()
}

fn floor_char_boundary(source: &str, offset: usize) -> usize {
    let mut end = offset.min(source.len());
    while !source.is_char_boundary(end) {
        end -= 1;
    }
    end
}

impl fmt::Display for DocumentError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, (problem, (line, column))) in self.problems.iter().zip(&self.places).enumerate()
        {
            let separator = if index == 0 { "" } else { "\n" };
            write!(
                f,
                "{separator}line {line}, column {column}: {}",
                problem.message
            )?;
            if let Some(help) = &problem.help {
                write!(f, " ({help})")?;
            }
        }
        Ok(())
    }
}

impl std::error::Error for DocumentError {}

/// Line and column, from 1, of a byte offset; columns count characters.
pub fn line_and_column(source: &str, offset: usize) -> (usize, usize) {
    let before = &source[..floor_char_boundary(source, offset)];
    let line_start = before.rfind('\n').map_or(0, |i| i + 1);
    (
        before.matches('\n').count() + 1,
        before[line_start..].chars().count() + 1,
    )
}
