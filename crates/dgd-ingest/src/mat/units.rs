//! Texts of a file, looked up as the units of its columns.

use std::collections::HashMap;

use super::MAX_UNIT;

/// The texts of a file, looked up as units.
pub(super) struct Texts<'a> {
    by_tag: HashMap<&'a str, usize>,
    /// Of each tag in lower case the text, unless several tags differ in nothing else.
    by_folded: HashMap<String, Option<usize>>,
    texts: &'a [(String, String)],
    used: Vec<bool>,
    /// Texts that are the unit of a column spelt as they are.
    spelt: Vec<bool>,
}

const UNIT_WORDS: [&str; 4] = ["units", "unit", "Units", "Unit"];
const VALUE_WORDS: [&str; 4] = ["value", "values", "data", "signal"];

impl<'a> Texts<'a> {
    pub(super) fn new(texts: &'a [(String, String)]) -> Self {
        let by_tag = texts.iter().enumerate();
        let by_tag = by_tag.map(|(i, (tag, _))| (tag.as_str(), i)).collect();
        let mut by_folded = HashMap::new();
        for (i, (tag, _)) in texts.iter().enumerate() {
            let folded = by_folded.entry(tag.to_ascii_lowercase());
            folded.and_modify(|text| *text = None).or_insert(Some(i));
        }
        Self {
            by_tag,
            by_folded,
            texts,
            used: vec![false; texts.len()],
            spelt: vec![false; texts.len()],
        }
    }

    /// `gom.units.FT1`, `units.gom.FT1`, `units.FT1`, `gom.FT1_unit`, or `gom.FT1.unit` beside `gom.FT1.data`.
    pub(super) fn unit_as_spelt(&mut self, tag: &str) -> Option<String> {
        candidates(tag).iter().find_map(|candidate| {
            let index = *self.by_tag.get(candidate.as_str())?;
            self.spelt[index] = true;
            self.take(index)
        })
    }

    /// The same in upper or lower case, if it is the unit of no column that is spelt like it; to be asked when those have theirs.
    pub(super) fn unit_in_any_case(&mut self, tag: &str) -> Option<String> {
        let candidates = candidates(&tag.to_ascii_lowercase());
        candidates.iter().find_map(|candidate| {
            let index = (*self.by_folded.get(candidate)?)?;
            (!self.spelt[index]).then(|| self.take(index)).flatten()
        })
    }

    fn take(&mut self, index: usize) -> Option<String> {
        self.used[index] = true;
        let text = self.texts[index].1.trim();
        (!text.is_empty() && text.len() <= MAX_UNIT).then(|| text.to_owned())
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

/// Where people write the unit of a column.
fn candidates(tag: &str) -> Vec<String> {
    let (head, name) = tag.rsplit_once('.').unwrap_or(("", tag));
    let of_word = |word: &str| {
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
        candidates
    };
    UNIT_WORDS.into_iter().flat_map(of_word).collect()
}

#[cfg(test)]
mod tests {
    use super::Texts;

    fn unit_of(shelf: &mut Texts<'_>, tag: &str) -> Option<String> {
        let spelt = shelf.unit_as_spelt(tag);
        spelt.or_else(|| shelf.unit_in_any_case(tag))
    }

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
            let found = unit_of(&mut shelf, "gom.FT1");
            assert_eq!(found.as_deref(), Some("gpm"), "{tag}");
            assert_eq!(shelf.unused(), None);
        }
        let texts = [("gom.FT1.unit".to_owned(), "gpm".to_owned())];
        assert!(unit_of(&mut Texts::new(&texts), "gom.FT1.data").is_some());
        assert!(unit_of(&mut Texts::new(&texts), "gom.FT1.offset").is_none());
    }
}
