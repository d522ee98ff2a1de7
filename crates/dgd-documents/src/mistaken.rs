//! A document of one kind given for another: told once, not section by section.

use crate::{DocumentError, Problem};
use toml::de::DeTable;

/// The documents that are easily taken for each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Well,
    Model,
    System,
}

impl Kind {
    const ALL: [Self; 3] = [Self::Well, Self::Model, Self::System];

    /// Keys that no other kind has.
    fn marks(self) -> &'static [&'static str] {
        match self {
            Self::Well => &["mud", "geometry", "channels"],
            Self::Model => &["well", "friction", "return_flow_meter", "augmented"],
            Self::System => &["components", "connections"],
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Well => "a well description",
            Self::Model => "a model of the return line",
            Self::System => "the description of a system",
        }
    }

    fn holds(self) -> &'static str {
        match self {
            Self::Well => "a well description has [mud], [geometry] and [channels]",
            Self::Model => {
                "a model has [well], [friction], [return_flow_meter] and [pump]; `dgd fit` writes one"
            }
            Self::System => "the description of a system has `connections` and [components]",
        }
    }
}

/// The error, if the document is not of the expected kind and plainly of another.
pub(crate) fn mistaken(
    source: &str,
    table: &DeTable<'_>,
    expected: Kind,
) -> Result<(), DocumentError> {
    let mark = |kind: Kind| {
        let keys = table.iter().map(|(key, _)| key);
        keys.filter(|key| kind.marks().contains(&key.get_ref().as_ref()))
            .min_by_key(|key| key.span().start)
    };
    if mark(expected).is_some() {
        return Ok(());
    }
    let others = Kind::ALL.into_iter().filter(|kind| *kind != expected);
    let mut found = others.filter_map(|kind| Some((kind, mark(kind)?.span())));
    match (found.next(), found.next()) {
        (Some((kind, span)), None) => Err(DocumentError::new(
            source,
            vec![Problem {
                span,
                message: format!("this is {}, expected {}", kind.name(), expected.name()),
                help: Some(expected.holds().to_owned()),
            }],
        )),
        _ => Ok(()),
    }
}
