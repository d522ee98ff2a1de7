//! Text for people: aligned tables, numbers at a readable length, JSON for machines.

use serde_json::Value;
use std::io::IsTerminal;

/// Whether standard error takes colours: a terminal, unless `NO_COLOR` says otherwise (no-color.org).
pub(crate) fn in_colour() -> bool {
    let refused = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    !refused && std::io::stderr().is_terminal()
}

/// Columns of text, aligned; numbers to the right.
#[derive(Default)]
pub(crate) struct TextTable {
    rows: Vec<Vec<String>>,
}

impl TextTable {
    /// A table with these headings.
    pub(crate) fn new<const N: usize>(headings: [&str; N]) -> Self {
        Self {
            rows: vec![headings.iter().map(|h| (*h).to_owned()).collect()],
        }
    }

    /// Adds a row.
    pub(crate) fn row<const N: usize>(&mut self, cells: [String; N]) {
        self.rows.push(cells.to_vec());
    }

    /// The table, indented by two spaces.
    pub(crate) fn render(&self) -> String {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let width = |column: usize| {
            self.rows
                .iter()
                .filter_map(|r| r.get(column))
                .map(|c| c.chars().count())
                .max()
                .unwrap_or(0)
        };
        let widths: Vec<usize> = (0..columns).map(width).collect();
        let numeric = |column: usize| {
            let cells = self.rows.iter().skip(1).filter_map(|r| r.get(column));
            cells.clone().count() > 0
                && cells
                    .filter(|c| !c.is_empty())
                    .all(|c| c.starts_with(|c: char| c.is_ascii_digit() || "-+.".contains(c)))
        };
        let right: Vec<bool> = (0..columns).map(numeric).collect();
        let mut text = String::new();
        for row in &self.rows {
            let mut line = String::from("  ");
            for (index, cell) in row.iter().enumerate() {
                let pad = " ".repeat(widths[index] - cell.chars().count());
                let (before, after) = if right[index] {
                    (pad, String::new())
                } else {
                    (String::new(), pad)
                };
                line.push_str(&format!("{before}{cell}{after}  "));
            }
            text.push_str(line.trim_end());
            text.push('\n');
        }
        text
    }
}

/// A number with about five significant figures, for tables.
pub(crate) fn number(value: f64) -> String {
    rounded(value, 5)
}

/// A number with about three significant figures, for sentences.
pub(crate) fn brief(value: f64) -> String {
    rounded(value, 3)
}

fn rounded(value: f64, figures: i32) -> String {
    let size = value.abs();
    if value == 0.0 || !value.is_finite() {
        format!("{value}")
    } else if !(0.999_999e-3..1e6).contains(&size) {
        format!("{value:.3e}")
    } else {
        // Bounded by the range above: -3 to 6.
        #[expect(clippy::cast_possible_truncation, reason = "between -3 and 6")]
        let digits = figures - 1 - size.log10().floor() as i32;
        let text = format!("{value:.*}", usize::try_from(digits).unwrap_or(0));
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text
        }
    }
}

/// A value and the ends of its interval, with two figures of the interval's half.
pub(crate) fn with_interval(value: f64, (low, high): (f64, f64)) -> [String; 3] {
    let half = 0.5 * (high - low);
    if !(half > 0.0 && half.is_finite()) {
        return [value, low, high].map(number);
    }
    let largest = value.abs().max(low.abs()).max(high.abs());
    // Decimals of the number as it is written: after its first figure if it has a power of ten.
    let powers = !(1e-3..1e6).contains(&largest);
    let lead = if powers { largest.log10().floor() } else { 0.0 };
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped"
    )]
    let decimals = (lead + 1.0 - half.log10().floor()).clamp(0.0, 12.0) as usize;
    [value, low, high].map(|v| {
        if powers {
            let scaled = v / 10f64.powf(lead);
            format!("{scaled:.decimals$}e{lead}")
        } else {
            format!("{v:.decimals$}")
        }
    })
}

/// A value and its standard error, with two figures of the error.
pub(crate) fn with_error(value: f64, error: f64) -> [String; 2] {
    let [shown, ..] = with_interval(value, (value - error, value + error));
    // Below ten, figures are decimals; above, the rest becomes zeros.
    let tens = 10f64.powf((error.log10().floor() - 1.0).max(0.0));
    let whole = (error / tens).round() * tens;
    [shown, rounded(if tens > 1.0 { whole } else { error }, 2)]
}

/// A count with thousands apart.
pub(crate) fn count(n: usize) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// `1 state`, `2 states`.
pub(crate) fn counted(n: usize, noun: &str) -> String {
    let plural = if n == 1 { "" } else { "s" };
    format!("{} {noun}{plural}", count(n))
}

/// Pretty JSON with a closing line break.
pub(crate) fn json(value: &Value) -> String {
    format!("{value:#}\n")
}

/// Paths for JSON, which knows no others than text.
pub(crate) fn paths(paths: &[std::path::PathBuf]) -> Vec<String> {
    paths.iter().map(|p| p.display().to_string()).collect()
}

/// Warns at once of what the answer tells [`again`].
pub(crate) fn warn(warnings: &mut Vec<String>, doubts: impl IntoIterator<Item = String>) {
    for doubt in doubts {
        tracing::warn!("{doubt}");
        warnings.push(doubt);
    }
}

/// Warnings before an answer, though they were told as they were met: but not to somebody who sees both.
pub(crate) fn again(warnings: &[String]) -> String {
    if std::io::stdout().is_terminal() && std::io::stderr().is_terminal() {
        return String::new();
    }
    warnings.iter().map(|w| format!("warning: {w}\n")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_grouped_by_thousands() {
        assert_eq!(count(7), "7");
        assert_eq!(count(305_820), "305,820");
        assert_eq!(count(1_000_000), "1,000,000");
    }

    #[test]
    fn numbers_keep_five_figures_whatever_their_size() {
        assert_eq!(number(0.0688), "0.0688");
        assert_eq!(number(264_740.26), "264740");
        assert_eq!(number(1.6243), "1.6243");
        assert_eq!(number(1.2e8), "1.200e8");
        assert_eq!(number(0.000_999_999_999_9), "0.001");
        assert_eq!(number(-0.000_012_345), "-1.234e-5");
    }

    #[test]
    fn a_sentence_has_three_figures() {
        assert_eq!(brief(0.079_66), "0.0797");
        assert_eq!(brief(2.541), "2.54");
        assert_eq!(brief(13.0), "13");
    }

    #[test]
    fn an_interval_decides_how_many_figures_are_written() {
        let written = with_interval(1.500_03e-5, (1.4995e-5, 1.5005e-5));
        assert_eq!(written, ["1.50003e-5", "1.49950e-5", "1.50050e-5"]);
        let written = with_interval(210.458, (210.34, 210.58));
        assert_eq!(written, ["210.46", "210.34", "210.58"]);
        let written = with_interval(2.0, (f64::NEG_INFINITY, f64::INFINITY));
        assert_eq!(written, ["2", "-inf", "inf"]);
    }

    #[test]
    fn a_standard_error_has_two_figures_and_leaves_its_value_as_many() {
        assert_eq!(with_error(1.567_12e8, 743_114.0), ["1.5671e8", "740000"]);
        assert_eq!(with_error(-15_867.3, 217.4), ["-15867", "220"]);
        assert_eq!(with_error(10.1412, 0.055_321), ["10.141", "0.055"]);
        assert_eq!(with_error(3.0, f64::NAN), ["3", "NaN"]);
    }

    #[test]
    fn columns_of_numbers_are_set_to_the_right() {
        let mut table = TextTable::new(["name", "n"]);
        table.row(["a".into(), "1".into()]);
        table.row(["bb".into(), "10".into()]);
        assert_eq!(table.render(), "  name   n\n  a      1\n  bb    10\n");
    }
}
