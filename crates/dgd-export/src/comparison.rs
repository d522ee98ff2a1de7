//! Measured beside two simulations, as CSV.

use crate::ExportError;
use crate::csv::push_quoted;
use crate::number::push_fixed;
use std::io::Write;

/// Measured and simulated series on one clock, all of the length of `time_s`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison<'a> {
    /// Time from the recording's start, s.
    pub time_s: &'a [f64],
    /// Whether a sample was held out of every fit.
    pub held_out: &'a [bool],
    /// Whether the screening trusts the sample.
    pub valid: &'a [bool],
    /// The signals, in order.
    pub signals: &'a [ComparedSignal<'a>],
}

/// One signal: NaN where there is nothing to compare.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ComparedSignal<'a> {
    /// Name with its SI unit, such as `riser_level_m`.
    pub name: &'a str,
    /// As recorded.
    pub measured: &'a [f64],
    /// By the model before.
    pub before: &'a [f64],
    /// By the model after.
    pub after: &'a [f64],
}

/// Writes `t_s,held_out,valid` and, for each signal, `<name>_measured,<name>_before,<name>_after`; a row a sample.
///
/// There is no row of units: the names have them. A name with a comma, a quote or a line end stands within quotes. Flags are 0 or 1. A value that is not finite is an empty cell.
/// Values are rounded to 1e-9 m³/s, 1e-6 m, 1e-2 Pa (by the name's ending; 1e-9 of anything else), which is a
/// thousandth of what a transmitter resolves or less, and halves the file.
///
/// # Errors
/// [`ExportError::Length`] if a series is not as long as the clock, [`ExportError::NameTaken`] or
/// [`ExportError::Io`].
///
/// ```
/// use dgd_export::{ComparedSignal, Comparison, write_comparison_csv};
///
/// let level = ComparedSignal {
///     name: "riser_level_m", measured: &[140.0, f64::NAN], before: &[139.5, 139.0], after: &[140.25, 140.0],
/// };
/// let comparison = Comparison {
///     time_s: &[0.0, 1.0], held_out: &[false, true], valid: &[true, false], signals: &[level],
/// };
/// let mut text = Vec::new();
/// write_comparison_csv(&comparison, &mut text)?;
/// let text = String::from_utf8(text).expect("text");
/// assert!(text.starts_with("t_s,held_out,valid,riser_level_m_measured,riser_level_m_before,riser_level_m_after\n"));
/// assert!(text.ends_with("0,0,1,140,139.5,140.25\n1,1,0,,139,140\n"));
/// # Ok::<(), dgd_export::ExportError>(())
/// ```
pub fn write_comparison_csv(
    comparison: &Comparison<'_>,
    mut writer: impl Write,
) -> Result<(), ExportError> {
    const FLUSHED_AT: usize = 1 << 16;
    check(comparison)?;
    let mut text = Vec::with_capacity(FLUSHED_AT + 4096);
    text.extend_from_slice(b"t_s,held_out,valid");
    for signal in comparison.signals {
        for what in ["measured", "before", "after"] {
            text.push(b',');
            push_quoted(&mut text, &format!("{}_{what}", signal.name));
        }
    }
    text.push(b'\n');
    let columns: Vec<(&[f64], u32)> = comparison
        .signals
        .iter()
        .flat_map(|s| [s.measured, s.before, s.after].map(|values| (values, decimals(s.name))))
        .collect();
    let flag = |yes: bool| if yes { b'1' } else { b'0' };
    for (row, time_s) in comparison.time_s.iter().enumerate() {
        push_fixed(&mut text, *time_s, 6);
        text.extend_from_slice(&[
            b',',
            flag(comparison.held_out[row]),
            b',',
            flag(comparison.valid[row]),
        ]);
        for (values, decimals) in &columns {
            text.push(b',');
            push_fixed(&mut text, values[row], *decimals);
        }
        text.push(b'\n');
        if text.len() >= FLUSHED_AT {
            writer.write_all(&text)?;
            text.clear();
        }
    }
    writer.write_all(&text)?;
    writer.flush()?;
    Ok(())
}

/// Decimals that leave every digit an instrument could mean.
fn decimals(name: &str) -> u32 {
    if name.ends_with("_m3_s") {
        9
    } else if name.ends_with("_pa") {
        2
    } else if name.ends_with("_m") {
        6
    } else {
        9
    }
}

fn check(comparison: &Comparison<'_>) -> Result<(), ExportError> {
    let expected = comparison.time_s.len();
    let flags = [
        ("held_out", comparison.held_out.len()),
        ("valid", comparison.valid.len()),
    ];
    let series = comparison
        .signals
        .iter()
        .flat_map(|s| [s.measured, s.before, s.after].map(|values| (s.name, values.len())));
    if let Some((name, found)) = flags
        .into_iter()
        .chain(series)
        .find(|(_, n)| *n != expected)
    {
        return Err(ExportError::Length {
            name: name.to_owned(),
            expected,
            found,
        });
    }
    let mut names: Vec<&str> = comparison.signals.iter().map(|s| s.name).collect();
    names.sort_unstable();
    match names.windows(2).find(|two| two[0] == two[1]) {
        Some(two) => Err(ExportError::NameTaken {
            tag: two[0].to_owned(),
        }),
        None => Ok(()),
    }
}
