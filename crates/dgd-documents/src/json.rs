//! JSON with its members in the order they are given, and no number that JSON has not.

use std::fmt::Write as _;

/// A value to write.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Json {
    Bool(bool),
    Number(f64),
    Text(String),
    List(Vec<Json>),
    /// Members in order.
    Object(Vec<(String, Json)>),
}

/// Longer lists and objects are broken into lines.
const INLINE: usize = 100;

impl Json {
    pub(crate) fn text(text: impl Into<String>) -> Self {
        Self::Text(text.into())
    }

    /// A number, if it is one.
    pub(crate) fn finite(value: f64) -> Option<Self> {
        value.is_finite().then_some(Self::Number(value))
    }

    /// Two numbers, if both are.
    pub(crate) fn pair((a, b): (f64, f64)) -> Option<Self> {
        Some(Self::List(vec![Self::finite(a)?, Self::finite(b)?]))
    }

    /// The document, with a line break at its end.
    pub(crate) fn document(&self) -> String {
        let mut out = String::new();
        self.write(&mut out, 0);
        out.push('\n');
        out
    }

    fn write(&self, out: &mut String, depth: usize) {
        if let Some(short) = self.inline(INLINE.saturating_sub(2 * depth)) {
            out.push_str(&short);
            return;
        }
        let line = |out: &mut String, depth: usize| {
            out.push('\n');
            out.extend(std::iter::repeat_n("  ", depth));
        };
        match self {
            Self::List(items) => {
                out.push('[');
                for (index, item) in items.iter().enumerate() {
                    out.push_str(if index > 0 { "," } else { "" });
                    line(out, depth + 1);
                    item.write(out, depth + 1);
                }
                line(out, depth);
                out.push(']');
            }
            Self::Object(members) => {
                out.push('{');
                for (index, (name, value)) in members.iter().enumerate() {
                    out.push_str(if index > 0 { "," } else { "" });
                    line(out, depth + 1);
                    quote(out, name);
                    out.push_str(": ");
                    value.write(out, depth + 1);
                }
                line(out, depth);
                out.push('}');
            }
            simple => simple.write_simple(out),
        }
    }

    fn write_simple(&self, out: &mut String) {
        match self {
            Self::Bool(value) => out.push_str(if *value { "true" } else { "false" }),
            // Debug writes the shortest digits that read back, with an exponent where that is shorter.
            Self::Number(value) if value.is_finite() => {
                let _ = write!(out, "{value:?}");
            }
            Self::Number(_) => out.push_str("null"),
            Self::Text(text) => quote(out, text),
            Self::List(_) | Self::Object(_) => {}
        }
    }

    /// The value on one line, if it has room there.
    fn inline(&self, room: usize) -> Option<String> {
        let mut out = String::new();
        match self {
            Self::List(items) => {
                out.push('[');
                for (index, item) in items.iter().enumerate() {
                    out.push_str(if index > 0 { ", " } else { "" });
                    out.push_str(&item.inline(room.checked_sub(out.len())?)?);
                }
                out.push(']');
            }
            Self::Object(members) => {
                out.push('{');
                for (index, (name, value)) in members.iter().enumerate() {
                    out.push_str(if index > 0 { ", " } else { " " });
                    quote(&mut out, name);
                    out.push_str(": ");
                    out.push_str(&value.inline(room.checked_sub(out.len())?)?);
                }
                out.push_str(if members.is_empty() { "}" } else { " }" });
            }
            simple => simple.write_simple(&mut out),
        }
        (out.len() <= room).then_some(out)
    }
}

fn quote(out: &mut String, text: &str) {
    out.push('"');
    for c in text.chars() {
        match c {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            '\n' => out.push_str("\\n"),
            '\r' => out.push_str("\\r"),
            '\t' => out.push_str("\\t"),
            c if c.is_control() => {
                let _ = write!(out, "\\u{:04x}", u32::from(c));
            }
            c => out.push(c),
        }
    }
    out.push('"');
}
