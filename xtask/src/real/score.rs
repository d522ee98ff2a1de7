//! What the diagnosis reached on the held-out part, computed again from its table against the recording.

use super::prepare::Columns;
use anyhow::{Result, bail};

/// Root mean squares on the held-out part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Score {
    pub(crate) samples: usize,
    pub(crate) before: f64,
    pub(crate) after: f64,
}

/// The rows of a table of `dgd` that are held out, one column.
pub(crate) fn held_out(table: &Columns, column: &str) -> Result<Vec<f64>> {
    let held = table.named("held_out")?;
    let values = table.named(column)?;
    // A row of units has no number in it.
    let rows = held.iter().zip(values).filter(|(h, _)| **h == 1.0);
    Ok(rows.map(|(_, v)| *v).collect())
}

fn rms(simulated: &[f64], measured: &[f64]) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "sample counts")]
    let n = measured.len() as f64;
    let square = simulated.iter().zip(measured).map(|(s, m)| (s - m).powi(2));
    (square.sum::<f64>() / n).sqrt()
}

/// The free run's error in a column against `measured`, the held-out readings in order as they were recorded.
pub(crate) fn of(table: &Columns, column: &str, measured: &[f64]) -> Result<f64> {
    let simulated = held_out(table, column)?;
    if simulated.len() != measured.len() || measured.is_empty() {
        bail!(
            "`{column}` has {} held-out samples, the recording {}",
            simulated.len(),
            measured.len()
        );
    }
    let off = rms(&simulated, measured);
    if !off.is_finite() {
        bail!("`{column}` is not a number somewhere in the held-out part");
    }
    Ok(off)
}

/// Before and after; fails where the table's own readings are not those of the recording.
pub(crate) fn score(table: &Columns, output: &str, measured: &[f64]) -> Result<Score> {
    let copy = held_out(table, &format!("{output}_measured"))?;
    let same = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-9 * b.abs().max(1e-9);
    if copy.len() == measured.len() && !copy.iter().zip(measured).all(same) {
        bail!("`{output}_measured` of the simulation is not what was recorded");
    }
    Ok(Score {
        samples: measured.len(),
        before: of(table, &format!("{output}_before"), measured)?,
        after: of(table, &format!("{output}_after"), measured)?,
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may")]
    use super::*;

    fn table(measured: [f64; 4]) -> Columns {
        let names = ["t", "held_out", "y_measured", "y_before", "y_after"];
        Columns {
            names: names.map(String::from).into(),
            units: vec![String::new(); 5],
            values: vec![
                vec![f64::NAN, 0.0, 1.0, 2.0],
                vec![f64::NAN, 0.0, 1.0, 1.0],
                measured.into(),
                vec![f64::NAN, 9.0, 5.0, 2.0],
                vec![f64::NAN, 9.0, 3.0, 3.0],
            ],
        }
    }

    #[test]
    fn only_held_out_rows_count_and_they_count_against_the_recording() {
        let table = table([f64::NAN, 0.0, 2.0, 2.0]);
        let found = score(&table, "y", &[2.0, 2.0]).unwrap();
        assert_eq!(found.samples, 2);
        assert!((found.before - f64::sqrt(4.5)).abs() < 1e-12);
        assert!((found.after - 1.0).abs() < 1e-12);
    }

    #[test]
    fn readings_that_were_not_recorded_are_refused() {
        let table = table([f64::NAN, 0.0, 2.0, 2.5]);
        assert!(score(&table, "y", &[2.0, 2.0]).is_err());
        assert!(score(&table, "y", &[2.0]).is_err());
        assert!(score(&table, "z", &[2.0, 2.5]).is_err());
    }
}
