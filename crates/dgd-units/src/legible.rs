//! How people read a value whose name ends in its SI unit.

/// Suffix of a name, factor from the SI unit, and the unit that is read; none stands after one that it ends in.
const SUFFIXES: [(&str, f64, &str); 12] = [
    ("_m3_s_pa", 6e9, "L/min/bar"),
    ("_m3_s2", 6e4, "L/min/s"),
    ("_kg_m3", 1.0, "kg/m3"),
    ("_m3_s", 6e4, "L/min"),
    ("_m_s", 1e3, "mm/s"),
    ("_pct", 1.0, "%"),
    ("_pa", 1e-5, "bar"),
    ("_m3", 1.0, "m3"),
    ("_m2", 1.0, "m2"),
    ("_m", 1.0, "m"),
    ("_s", 1.0, "s"),
    ("_fraction", 100.0, "%"),
];

/// What a name calls, and how its value is read.
///
/// Names in the code, in `model.toml` and in machine-readable answers end in their SI unit (`rate_m3_s`); people read litres a minute
/// and bar.
///
/// ```
/// use dgd_units::Legible;
/// let rate = Legible::of("rate_m3_s");
/// assert_eq!((rate.stem, rate.unit), ("rate", "L/min"));
/// assert!((0.005 * rate.factor - 300.0).abs() < 1e-9);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Legible<'a> {
    /// The name without its unit.
    pub stem: &'a str,
    /// Value to read for a value of one SI unit.
    pub factor: f64,
    /// Unit to read in ASCII; empty for what has none.
    pub unit: &'static str,
}

impl<'a> Legible<'a> {
    /// Splits a name. One that ends in no unit is a plain number, one that begins with `relative_` a share.
    #[must_use]
    pub fn of(name: &'a str) -> Self {
        let found = (SUFFIXES.iter())
            .find_map(|(suffix, factor, unit)| Some((name.strip_suffix(suffix)?, *factor, *unit)))
            .filter(|(stem, ..)| !stem.is_empty());
        let (stem, factor, unit) = match found {
            // Stresses at a wall are a few pascals.
            Some((stem, _, "bar")) if stem.split('_').next() == Some("tau") => (stem, 1.0, "Pa"),
            Some(found) => found,
            None if name.starts_with("relative_") => (name, 100.0, "%"),
            None => (name, 1.0, ""),
        };
        Self { stem, factor, unit }
    }

    /// What it calls, as words.
    #[must_use]
    pub fn words(&self) -> String {
        self.stem.replace('_', " ")
    }
}

#[cfg(test)]
mod tests {
    use super::{Legible, SUFFIXES};

    #[test]
    fn a_name_is_split_into_what_it_calls_and_its_unit() {
        for (name, stem, factor, unit) in [
            ("J_m3_s_pa", "J", 6e9, "L/min/bar"),
            ("volume_m3", "volume", 1.0, "m3"),
            ("rate_m_s", "rate", 1e3, "mm/s"),
            ("drop_pa", "drop", 1e-5, "bar"),
            ("tau_y_pa", "tau_y", 1.0, "Pa"),
            ("tau_pa", "tau", 1.0, "Pa"),
            ("tau_s", "tau", 1.0, "s"),
            ("head_loss_fraction", "head_loss", 100.0, "%"),
            ("relative_mu_change", "relative_mu_change", 100.0, "%"),
            ("K", "K", 1.0, ""),
            // A unit alone is no unit of anything.
            ("_s", "_s", 1.0, ""),
        ] {
            assert_eq!(Legible::of(name), Legible { stem, factor, unit }, "{name}");
        }
    }

    #[test]
    fn a_name_is_told_in_words_without_its_unit() {
        assert_eq!(Legible::of("return_flow_m3_s").words(), "return flow");
    }

    #[test]
    fn no_suffix_hides_a_longer_one() {
        for (k, (long, ..)) in SUFFIXES.iter().enumerate() {
            let hidden = SUFFIXES[..k]
                .iter()
                .any(|(short, ..)| long.ends_with(short));
            assert!(!hidden, "{long}");
        }
    }
}
