//! The name that a misspelling most likely meant.

use dgd_units::edit_distance;

/// The name within two edits, or a third of its letters, of what was written.
pub(crate) fn nearest<'a>(
    written: &str,
    names: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
    // Compared at a bounded length: a document may hold anything.
    let written: String = written.chars().take(64).collect();
    let each = names
        .into_iter()
        .map(|name| (edit_distance(&written, name), name));
    let (distance, name) = each.min_by_key(|(distance, _)| *distance)?;
    // Of a name of two letters anything is two edits away.
    let most = 2.max(name.len() / 3).min(name.len() / 2);
    (distance <= most).then_some(name)
}

/// `did you mean `string`? `, or nothing.
pub(crate) fn meant<'a>(written: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    nearest(written, names).map_or_else(String::new, |name| format!("did you mean `{name}`? "))
}

/// A message that quotes what was written and then what there is, with the likeliest of it.
pub(crate) fn with_meant(message: &str) -> String {
    let mut quoted = message.split('`').skip(1).step_by(2);
    let Some(written) = quoted.next().filter(|_| message.starts_with("unknown ")) else {
        return message.to_owned();
    };
    match nearest(written, quoted) {
        Some(name) => format!("{message}; did you mean `{name}`?"),
        None => message.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_a_few_letters_away_is_meant_and_a_short_one_is_not_anything() {
        let names = ["string", "standpipe", "bit", "pump"];
        assert_eq!(nearest("strng", names), Some("string"));
        assert_eq!(nearest("standpip", names), Some("standpipe"));
        assert_eq!(nearest("whp", names), None);
        assert_eq!(nearest("", names), None);
    }

    #[test]
    fn of_what_a_reader_expected_the_likeliest_is_meant() {
        let found = with_meant("unknown variant `volum`, expected one of `tank`, `volume`");
        assert!(found.ends_with("did you mean `volume`?"), "{found}");
        let plain = "invalid type: map, expected a sequence";
        assert_eq!(with_meant(plain), plain);
    }
}
