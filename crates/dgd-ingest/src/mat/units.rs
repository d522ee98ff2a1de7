//! Texts of a file, looked up as the units of its columns.

use std::collections::HashMap;

use super::MAX_UNIT;
use dgd_recording::Table;

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

/// Bytes of a time to the second.
const SECONDS: usize = "2024-10-22T15:27:49".len();
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

    /// A text named `origin` as an RFC 3339 time, `-00:00` behind it where it tells no zone; the tag of the text and itself if it is none.
    pub(super) fn origin(&mut self) -> Option<Result<String, (&'a str, &'a str)>> {
        let texts = self.texts.iter().enumerate();
        let named = texts.filter(|(_, (tag, _))| tag.rsplit('.').next() == Some("origin"));
        let mut read = named.map(|(index, (tag, text))| {
            let text = text.trim();
            (index, rfc3339(text).ok_or((tag.as_str(), text)))
        });
        let first = read.next()?;
        let (index, origin) = match first.1 {
            Ok(_) => first,
            Err(_) => read.find(|(_, origin)| origin.is_ok()).unwrap_or(first),
        };
        self.used[index] = true;
        Some(origin)
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

/// A time as RFC 3339 has it, `-00:00` where it tells no zone; `None` where it is none.
fn rfc3339(text: &str) -> Option<String> {
    let zoned = |behind: &str| behind.contains(['Z', 'z', '+', '-']);
    let zone = match text.get(SECONDS..) {
        Some(behind) if !zoned(behind) => "-00:00",
        _ => "",
    };
    let time = Table {
        origin: Some(format!("{text}{zone}")),
        ..Table::default()
    };
    time.origin_ns().and(time.origin)
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
    fn an_origin_without_a_zone_says_so_and_what_is_no_time_is_none() {
        for (text, expected) in [
            ("2024-10-22T15:27:49", Ok("2024-10-22T15:27:49-00:00")),
            (" 2024-10-22T15:27:49.5 ", Ok("2024-10-22T15:27:49.5-00:00")),
            ("2024-10-22T15:27:49+02:00", Ok("2024-10-22T15:27:49+02:00")),
            ("2024-10-22T15:27:49Z", Ok("2024-10-22T15:27:49Z")),
            (
                "2024-13-22T15:27:49",
                Err(("gom.origin", "2024-13-22T15:27:49")),
            ),
            ("Stavanger", Err(("gom.origin", "Stavanger"))),
        ] {
            let texts = [("gom.origin".to_owned(), text.to_owned())];
            let found = Texts::new(&texts).origin().expect("a text of that name");
            assert_eq!(found.as_deref().map_err(|e| *e), expected);
        }
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
