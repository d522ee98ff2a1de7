//! The numbers of a JSON message, without building a tree.
//!
//! Scanned by hand for three reasons: numbers must come out rounded exactly (the same
//! recording in CSV and in MCAP has the same digits), `NaN` and `Infinity`, which
//! Python writes, must be read, and it is done for every sample.

use crate::csv::number;

/// Elements of an array that become columns; the rest is a picture or a cloud.
pub(super) const MAX_ELEMENTS: usize = 64;
const MAX_DEPTH: usize = 24;
/// Bytes of a member's path.
pub(super) const MAX_PATH: usize = 1024;

/// Gives every number in `message` to `sink`, with its path: names joined by points,
/// array elements as `name[0]`. Booleans are 0 and 1, `null` is NaN, strings are passed over.
///
/// Returns whether an array was cut at [`MAX_ELEMENTS`].
///
/// # Errors
/// The byte at which the message stops being JSON.
pub(super) fn numbers(message: &[u8], sink: &mut impl FnMut(&[u8], f64)) -> Result<bool, usize> {
    let mut scanner = Scanner {
        bytes: message,
        at: 0,
        path: Vec::new(),
        depth: 0,
        cut: false,
    };
    let whole = scanner.value(sink).and_then(|()| {
        scanner.blanks();
        (scanner.at == message.len()).then_some(())
    });
    whole.map(|()| scanner.cut).ok_or(scanner.at)
}

struct Scanner<'a> {
    bytes: &'a [u8],
    at: usize,
    path: Vec<u8>,
    depth: usize,
    cut: bool,
}

impl Scanner<'_> {
    fn blanks(&mut self) {
        while let Some(b' ' | b'\t' | b'\n' | b'\r') = self.bytes.get(self.at) {
            self.at += 1;
        }
    }

    fn eat(&mut self, byte: u8) -> Option<()> {
        (self.bytes.get(self.at) == Some(&byte)).then(|| self.at += 1)
    }

    fn value(&mut self, sink: &mut impl FnMut(&[u8], f64)) -> Option<()> {
        self.blanks();
        match self.bytes.get(self.at)? {
            b'{' => self.nested(|s| s.members(sink)),
            b'[' => self.nested(|s| s.elements(sink)),
            b'"' => self.string().map(|_| ()),
            _ => {
                let value = self.scalar()?;
                sink(&self.path, value);
                Some(())
            }
        }
    }

    fn nested(&mut self, inside: impl FnOnce(&mut Self) -> Option<()>) -> Option<()> {
        self.at += 1;
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return None;
        }
        let kept = self.path.len();
        inside(self)?;
        self.path.truncate(kept);
        self.depth -= 1;
        Some(())
    }

    fn members(&mut self, sink: &mut impl FnMut(&[u8], f64)) -> Option<()> {
        let kept = self.path.len();
        self.blanks();
        if self.eat(b'}').is_some() {
            return Some(());
        }
        loop {
            self.blanks();
            let (start, end, escaped) = self.string()?;
            self.path.truncate(kept);
            if kept > 0 {
                self.path.push(b'.');
            }
            let bytes = self.bytes;
            if escaped {
                let name: String = serde_json::from_slice(&bytes[start - 1..=end]).ok()?;
                self.path.extend_from_slice(name.as_bytes());
            } else {
                self.path.extend_from_slice(&bytes[start..end]);
            }
            if self.path.len() > MAX_PATH {
                return None;
            }
            self.blanks();
            self.eat(b':')?;
            self.value(sink)?;
            self.blanks();
            if self.eat(b'}').is_some() {
                return Some(());
            }
            self.eat(b',')?;
        }
    }

    fn elements(&mut self, sink: &mut impl FnMut(&[u8], f64)) -> Option<()> {
        let kept = self.path.len();
        self.blanks();
        if self.eat(b']').is_some() {
            return Some(());
        }
        for index in 0.. {
            self.path.truncate(kept);
            if index < MAX_ELEMENTS {
                self.path.extend_from_slice(format!("[{index}]").as_bytes());
                self.value(sink)?;
            } else {
                self.cut = true;
                self.value(&mut ignore)?;
            }
            self.blanks();
            if self.eat(b']').is_some() {
                return Some(());
            }
            self.eat(b',')?;
        }
        None
    }

    /// Start and end of the text between the quotes, and whether it has escapes.
    fn string(&mut self) -> Option<(usize, usize, bool)> {
        self.eat(b'"')?;
        let start = self.at;
        let mut escaped = false;
        loop {
            match self.bytes.get(self.at)? {
                b'"' => break,
                b'\\' => {
                    escaped = true;
                    self.at += 1;
                }
                _ => {}
            }
            self.at += 1;
        }
        let end = self.at;
        self.at += 1;
        Some((start, end, escaped))
    }

    fn scalar(&mut self) -> Option<f64> {
        let rest = &self.bytes[self.at..];
        if let Some((value, length)) = number::plain(rest)
            && !matches!(rest.get(length), Some(b'e' | b'E' | b'.' | b'0'..=b'9'))
        {
            self.at += length;
            return Some(value);
        }
        let inside = |b: &&u8| b.is_ascii_alphanumeric() || matches!(**b, b'+' | b'-' | b'.');
        let length = rest.iter().take_while(inside).count();
        let value = match &rest[..length] {
            b"true" => 1.0,
            b"false" => 0.0,
            b"null" => f64::NAN,
            token => std::str::from_utf8(token).ok()?.parse().ok()?,
        };
        self.at += length;
        Some(value)
    }
}

fn ignore(_: &[u8], _: f64) {}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(message: &str) -> Result<Vec<(String, f64)>, usize> {
        let mut found = Vec::new();
        let mut sink = |path: &[u8], value| {
            found.push((String::from_utf8_lossy(path).into_owned(), value));
        };
        numbers(message.as_bytes(), &mut sink)?;
        Ok(found)
    }

    #[test]
    fn nested_members_and_elements_have_paths() {
        let message =
            r#" {"a": 1, "b": {"c": [2.5, -3e2, {"d": true}]}, "s": "x,\"}", "n": null} "#;
        let found = read(message).expect("valid");
        let paths: Vec<&str> = found.iter().map(|(p, _)| p.as_str()).collect();
        assert_eq!(paths, ["a", "b.c[0]", "b.c[1]", "b.c[2].d", "n"]);
        let values: Vec<f64> = found.iter().take(4).map(|(_, v)| *v).collect();
        assert_eq!(values, [1.0, 2.5, -300.0, 1.0]);
        assert!(found[4].1.is_nan());
    }

    #[test]
    fn python_constants_and_escaped_names_are_read() {
        let found = read(r#"{"\u0050T1\n": NaN, "b": -Infinity, "c": 0.1234567890123456789}"#)
            .expect("valid");
        assert_eq!(found[0].0, "PT1\n");
        assert!(found[0].1.is_nan());
        assert_eq!(found[1].1, f64::NEG_INFINITY);
        assert_eq!(found[2].1, 0.123_456_789_012_345_68);
    }

    #[test]
    fn what_is_no_json_says_where() {
        assert_eq!(read(r#"{"a": 1"#), Err(7));
        assert_eq!(read(r#"{"a" 1}"#), Err(5));
        assert_eq!(read("{\"a\": 1} x"), Err(9));
        assert_eq!(read("").map(|_| ()), Err(0));
        assert!(read(&"[".repeat(1000)).is_err());
        assert!(read(r#"{"\ud800": 1}"#).is_err());
        assert!(read(r#"{"a\"#).is_err());
    }

    #[test]
    fn long_arrays_are_cut_and_say_so() {
        let message = format!("[{}1]", "1,".repeat(99));
        let mut count = 0;
        assert_eq!(
            numbers(message.as_bytes(), &mut |_, _| count += 1),
            Ok(true)
        );
        assert_eq!(count, MAX_ELEMENTS);
    }
}
