//! Texts of a file, looked up as the units of its columns.

use std::collections::HashMap;

use super::MAX_UNIT;

/// The texts of a file, looked up as units.
pub(super) struct Texts<'a> {
    by_tag: HashMap<String, usize>,
    texts: &'a [(String, String)],
    used: Vec<bool>,
}

const UNIT_WORDS: [&str; 2] = ["units", "unit"];
const VALUE_WORDS: [&str; 4] = ["value", "values", "data", "signal"];

impl<'a> Texts<'a> {
    pub(super) fn new(texts: &'a [(String, String)]) -> Self {
        let by_tag = texts
            .iter()
            .enumerate()
            .map(|(i, (tag, _))| (tag.to_ascii_lowercase(), i))
            .collect();
        Self {
            by_tag,
            texts,
            used: vec![false; texts.len()],
        }
    }

    fn take(&mut self, tag: &str) -> Option<String> {
        let index = *self.by_tag.get(tag)?;
        self.used[index] = true;
        let text = self.texts[index].1.trim();
        (!text.is_empty() && text.len() <= MAX_UNIT).then(|| text.to_owned())
    }

    /// `gom.units.FT1`, `units.gom.FT1`, `units.FT1`, `gom.FT1_unit`, or `gom.FT1.unit` beside
    /// `gom.FT1.data`; upper and lower case alike.
    pub(super) fn unit_of(&mut self, tag: &str) -> Option<String> {
        if self.texts.is_empty() {
            return None;
        }
        let tag = tag.to_ascii_lowercase();
        let (head, name) = tag.rsplit_once('.').unwrap_or(("", &tag));
        for word in UNIT_WORDS {
            let mut candidates = vec![
                format!("{word}.{tag}"),
                format!("{word}.{name}"),
                format!("{tag}_{word}"),
            ];
            if !head.is_empty() {
                candidates.insert(0, format!("{head}.{word}.{name}"));
                if VALUE_WORDS.contains(&name) {
                    candidates.push(format!("{head}.{word}"));
                }
            }
            if let Some(unit) = candidates.iter().find_map(|c| self.take(c)) {
                return Some(unit);
            }
        }
        None
    }

    /// A text named `origin` that looks like an RFC 3339 time.
    pub(super) fn origin(&mut self) -> Option<String> {
        let looks_like_time = |text: &str| {
            let b = text.as_bytes();
            b.len() >= 19
                && b[..19].iter().zip(b"0000-00-00T00:00:00").all(|(b, like)| {
                    if *like == b'0' {
                        b.is_ascii_digit()
                    } else {
                        b == like
                    }
                })
        };
        let index = self.texts.iter().position(|(tag, text)| {
            tag.rsplit('.').next() == Some("origin") && looks_like_time(text.trim())
        })?;
        self.used[index] = true;
        Some(self.texts[index].1.trim().to_owned())
    }

    /// The first text that nothing asked for, and how many there are.
    pub(super) fn unused(&self) -> Option<(&'a str, usize)> {
        let mut unused = self
            .texts
            .iter()
            .zip(&self.used)
            .filter(|(_, used)| !**used);
        let ((first, _), _) = unused.next()?;
        Some((first, 1 + unused.count()))
    }
}

#[cfg(test)]
mod tests {
    use super::Texts;

    #[test]
    fn a_unit_is_found_wherever_people_write_it() {
        for tag in [
            "gom.units.FT1",
            "gom.Unit.ft1",
            "units.FT1",
            "units.gom.FT1",
            "gom.FT1_unit",
        ] {
            let texts = [(tag.to_owned(), " gpm ".to_owned())];
            let mut shelf = Texts::new(&texts);
            assert_eq!(shelf.unit_of("gom.FT1").as_deref(), Some("gpm"), "{tag}");
            assert_eq!(shelf.unused(), None);
        }
        let texts = [("gom.FT1.unit".to_owned(), "gpm".to_owned())];
        assert!(Texts::new(&texts).unit_of("gom.FT1.data").is_some());
        assert!(Texts::new(&texts).unit_of("gom.FT1.offset").is_none());
    }
}
