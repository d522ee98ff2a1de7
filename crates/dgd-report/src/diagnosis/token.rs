//! Plain notation cut into numbers, names and signs.

#[derive(Debug, Clone, PartialEq)]
pub(super) enum What {
    Number(String),
    Name(String),
    Sign(&'static str),
}

#[derive(Debug, Clone)]
pub(super) struct Token {
    pub what: What,
    /// Space before it.
    pub apart: bool,
}

/// Signs as written and as set; longer ones first.
const SIGNS: [(&str, &str); 29] = [
    ("<=", "≤"),
    (">=", "≥"),
    ("+-", "±"),
    ("->", "→"),
    ("<", "<"),
    (">", ">"),
    ("=", "="),
    ("≤", "≤"),
    ("≥", "≥"),
    ("≈", "≈"),
    ("~", "≈"),
    ("+", "+"),
    ("-", "−"),
    ("−", "−"),
    ("±", "±"),
    ("*", "·"),
    ("·", "·"),
    ("×", "×"),
    ("/", "/"),
    ("^", "^"),
    ("(", "("),
    (")", ")"),
    ("[", "["),
    ("]", "]"),
    ("|", "|"),
    (",", ","),
    (";", ";"),
    (":", ":"),
    ("→", "→"),
];

pub(super) fn tokens(text: &str) -> Option<Vec<Token>> {
    let mut out = Vec::new();
    let mut rest = text;
    let mut apart = false;
    while let Some(first) = rest.chars().next() {
        if first.is_whitespace() {
            apart = true;
            rest = &rest[first.len_utf8()..];
            continue;
        }
        let (what, taken) = if first.is_ascii_digit() {
            let end = number_end(rest);
            (What::Number(rest[..end].to_owned()), end)
        } else if first.is_alphabetic() {
            let end = name_end(rest);
            (What::Name(rest[..end].to_owned()), end)
        } else if let Some(power) = superscript(first) {
            out.push(Token {
                what: What::Sign("^"),
                apart: false,
            });
            (What::Number(power.to_string()), first.len_utf8())
        } else {
            let (written, set) = SIGNS.iter().find(|(sign, _)| rest.starts_with(sign))?;
            (What::Sign(set), written.len())
        };
        out.push(Token { what, apart });
        apart = false;
        rest = &rest[taken..];
    }
    Some(out)
}

fn superscript(letter: char) -> Option<char> {
    "⁰¹²³⁴⁵⁶⁷⁸⁹"
        .chars()
        .zip('0'..='9')
        .find_map(|(raised, digit)| (raised == letter).then_some(digit))
}

fn number_end(text: &str) -> usize {
    let digits = |from: usize| {
        text[from..]
            .find(|c: char| !c.is_ascii_digit())
            .map_or(text.len(), |n| from + n)
    };
    let mut end = digits(0);
    if text[end..].starts_with('.') && digits(end + 1) > end + 1 {
        end = digits(end + 1);
    }
    let exponent = ["e-", "e+", "e", "E-", "E+", "E"]
        .into_iter()
        .find(|e| text[end..].starts_with(e));
    if let Some(e) = exponent
        && digits(end + e.len()) > end + e.len()
    {
        end = digits(end + e.len());
    }
    end
}

/// Letters, digits and underscores; `q_meter,i` goes on over its comma.
fn name_end(text: &str) -> usize {
    let part = |from: usize| {
        text[from..]
            .find(|c: char| !(c.is_alphanumeric() || c == '_') || superscript(c).is_some())
            .map_or(text.len(), |n| from + n)
    };
    let end = part(0);
    let index = text[end..].strip_prefix(',').is_some_and(|after| {
        let mut letters = after.chars();
        letters.next().is_some_and(|c| matches!(c, 'i' | 'j' | 'k'))
            && letters.next().is_none_or(|c| !c.is_alphanumeric())
    });
    if index && text[..end].contains('_') {
        end + 2
    } else {
        end
    }
}
