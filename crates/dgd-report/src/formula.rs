//! Presentation MathML that may stand in a page: a closed list of elements, balanced, nothing that acts.

use crate::error::ReportError;

const ELEMENTS: [&str; 27] = [
    "math",
    "mrow",
    "mi",
    "mn",
    "mo",
    "mtext",
    "mspace",
    "msub",
    "msup",
    "msubsup",
    "mfrac",
    "msqrt",
    "mroot",
    "mover",
    "munder",
    "munderover",
    "mtable",
    "mtr",
    "mtd",
    "mstyle",
    "mpadded",
    "mphantom",
    "menclose",
    "mmultiscripts",
    "mprescripts",
    "none",
    "ms",
];

const ATTRIBUTES: [&str; 24] = [
    "xmlns",
    "display",
    "mathvariant",
    "stretchy",
    "fence",
    "separator",
    "form",
    "largeop",
    "movablelimits",
    "accent",
    "accentunder",
    "lspace",
    "rspace",
    "width",
    "height",
    "depth",
    "columnalign",
    "rowalign",
    "rowspacing",
    "columnspacing",
    "displaystyle",
    "scriptlevel",
    "linethickness",
    "alttext",
];

/// Deeper than any formula, shallow enough for every reader of the page.
const DEEPEST: usize = 64;

pub(crate) fn check(text: &str) -> Result<(), ReportError> {
    let refuse = |at: usize, reason: &'static str| Err(ReportError::Formula { at, reason });
    let text_end = text.trim_end().len();
    let mut open: Vec<&str> = Vec::new();
    let mut at = text.len() - text.trim_start().len();
    let mut seen = false;
    while at < text_end {
        let rest = &text[at..text_end];
        if let Some(tag) = rest.strip_prefix('<') {
            let Some(end) = tag.find('>') else {
                return refuse(at, "a tag without its end");
            };
            let tag = &tag[..end];
            if let Some(name) = tag.strip_prefix('/') {
                if open.pop() != Some(name.trim_end()) {
                    return refuse(at, "an end tag that closes nothing");
                }
            } else {
                let (tag, closed) = tag.strip_suffix('/').map_or((tag, false), |t| (t, true));
                let (name, attributes) = tag.split_once(char::is_whitespace).unwrap_or((tag, ""));
                if !ELEMENTS.contains(&name) {
                    return refuse(at, "not an element of presentation MathML");
                }
                if open.is_empty() && (seen || name != "math") {
                    return refuse(at, "not a single math element");
                }
                if !plain_attributes(attributes) {
                    return refuse(at, "an attribute that is not plain MathML");
                }
                seen = true;
                if !closed {
                    open.push(name);
                }
                if open.len() > DEEPEST {
                    return refuse(at, "nested too deeply");
                }
            }
            at += end + 2;
        } else {
            if open.is_empty() {
                return refuse(at, "text outside the math element");
            }
            let end = rest.find('<').unwrap_or(rest.len());
            if let Some(bad) = bad_text(&rest[..end]) {
                return refuse(at + bad, "a bare & or a control character");
            }
            at += end;
        }
    }
    if !seen || !open.is_empty() {
        return refuse(text_end, "the formula ends before its math element");
    }
    Ok(())
}

/// Each `name="value"`, the name known and given once.
fn plain_attributes(mut text: &str) -> bool {
    let mut names: Vec<&str> = Vec::new();
    loop {
        text = text.trim_start();
        if text.is_empty() {
            return true;
        }
        let Some((name, rest)) = text.split_once("=\"") else {
            return false;
        };
        let Some((value, rest)) = rest.split_once('"') else {
            return false;
        };
        let apart = rest.is_empty() || rest.starts_with(char::is_whitespace);
        let xmlns = name != "xmlns" || value == "http://www.w3.org/1998/Math/MathML";
        if !ATTRIBUTES.contains(&name) || names.contains(&name) || !apart || !xmlns {
            return false;
        }
        if value.contains('<') || bad_text(value).is_some() {
            return false;
        }
        names.push(name);
        text = rest;
    }
}

/// Byte of the first `&` that starts no reference, or of a character XML forbids.
fn bad_text(text: &str) -> Option<usize> {
    text.char_indices().find_map(|(at, letter)| {
        let bad = match letter {
            '&' => !is_reference(&text[at + 1..]),
            '\t' | '\n' | '\r' => false,
            c => c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}'),
        };
        bad.then_some(at)
    })
}

fn is_reference(text: &str) -> bool {
    let Some((name, _)) = text.split_once(';') else {
        return false;
    };
    let number = |digits: &str, base: u32| {
        u32::from_str_radix(digits, base)
            .ok()
            .filter(|_| digits.chars().all(|c| c.is_digit(base)))
            .and_then(char::from_u32)
            .is_some_and(|c| !c.is_control() && !matches!(c, '\u{fffe}' | '\u{ffff}'))
    };
    match name.strip_prefix('#') {
        Some(hex) if hex.starts_with('x') => number(&hex[1..], 16),
        Some(decimal) => number(decimal, 10),
        None => matches!(name, "amp" | "lt" | "gt" | "quot" | "apos"),
    }
}
