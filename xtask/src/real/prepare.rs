//! From the files as they are published to the tables that the descriptions name.

use anyhow::{Context, Result, bail};
use std::fmt::Write as _;
use std::path::Path;

/// Named columns of one length.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Columns {
    pub(crate) names: Vec<String>,
    /// Unit by column; empty if none is written.
    pub(crate) units: Vec<String>,
    /// By column; NaN where a cell is no number.
    pub(crate) values: Vec<Vec<f64>>,
}

impl Columns {
    /// A column by name.
    pub(crate) fn named(&self, name: &str) -> Result<&[f64]> {
        let place = self.names.iter().position(|n| n == name);
        let known = || format!("no column `{name}`; there are {}", self.names.join(", "));
        Ok(&self.values[place.with_context(known)?])
    }

    /// Comma-separated, with a row of units if there are any; numbers as short as they read back the same.
    pub(crate) fn text(&self) -> String {
        let mut text = self.names.join(",") + "\n";
        if self.units.iter().any(|u| !u.is_empty()) {
            text += &(self.units.join(",") + "\n");
        }
        let rows = self.values.first().map_or(0, Vec::len);
        for row in 0..rows {
            let cells = self.values.iter().map(|column| {
                let value = column[row];
                if value.is_finite() {
                    value.to_string()
                } else {
                    String::new()
                }
            });
            // Writing into a string cannot fail.
            let _ = writeln!(text, "{}", cells.collect::<Vec<_>>().join(","));
        }
        text
    }
}

/// Reads a plain comma-separated table without quotes: its header is the first line that holds `key` as a cell.
pub(crate) fn read(path: &Path, key: &str) -> Result<Columns> {
    let bytes = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    // Degree signs of another encoding stand in names that are not used.
    let text = String::from_utf8_lossy(&bytes);
    let mut lines = text.lines();
    let cells =
        |line: &str| -> Vec<String> { line.split(',').map(|c| c.trim().to_owned()).collect() };
    let Some(names) = lines
        .by_ref()
        .map(cells)
        .find(|c| c.iter().any(|c| c == key))
    else {
        bail!("{}: no line with a column `{key}`", path.display());
    };
    let mut values = vec![Vec::new(); names.len()];
    for line in lines.filter(|line| line.split(',').any(|c| !c.trim().is_empty())) {
        let mut cells = line.split(',');
        for column in &mut values {
            let cell = cells.next().unwrap_or_default();
            column.push(cell.trim().parse().unwrap_or(f64::NAN));
        }
    }
    Ok(Columns {
        units: vec![String::new(); names.len()],
        names,
        values,
    })
}

/// Depth, flow and standpipe pressure of the drilling log, without the rows that its source calls instrument errors: a flow
/// of 0 or of more than 1200 gpm. Says how many were left out.
pub(crate) fn drilling(log: &Columns) -> Result<(Columns, usize)> {
    let depth = log.named("Depth")?;
    let flow = log.named("Flow In (gpm)")?;
    let pressure = log.named("Pump Press (psi)")?;
    let kept: Vec<usize> = (0..depth.len())
        .filter(|&i| {
            let all = depth[i].is_finite() && pressure[i].is_finite();
            all && flow[i] > 0.0 && flow[i] <= 1200.0
        })
        .collect();
    let column = |of: &[f64]| kept.iter().map(|&i| of[i]).collect::<Vec<_>>();
    let columns = Columns {
        names: ["depth", "flow_in", "standpipe"].map(String::from).into(),
        units: ["ft", "gpm", "psi"].map(String::from).into(),
        values: vec![column(depth), column(flow), column(pressure)],
    };
    Ok((columns, depth.len() - kept.len()))
}

/// Samples of the bench in a median: ten seconds at 10 Hz.
const MEDIAN: usize = 100;

/// Ten-second medians of the bench's files, one after the other; what is left at the end of each file is left out.
pub(crate) fn bench(files: &[Columns]) -> Result<Columns> {
    let names = ["pre1", "pre2", "flow1", "flow2"];
    let mut values = vec![Vec::new(); names.len() + 1];
    for file in files {
        let columns = names
            .iter()
            .map(|n| file.named(n))
            .collect::<Result<Vec<_>>>()?;
        let samples = columns[0].len();
        for block in 0..samples / MEDIAN {
            let number = values[0].len();
            #[expect(clippy::cast_precision_loss, reason = "a few hundred")]
            values[0].push(number as f64);
            for (out, column) in values[1..].iter_mut().zip(&columns) {
                out.push(median(&column[block * MEDIAN..(block + 1) * MEDIAN]));
            }
        }
    }
    let mut all = vec!["sample".to_owned()];
    all.extend(names.map(String::from));
    Ok(Columns {
        units: vec![String::new(); all.len()],
        names: all,
        values,
    })
}

/// Of the finite ones, the middle one or the mean of the two; NaN without any.
fn median(values: &[f64]) -> f64 {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    match sorted.len() {
        0 => f64::NAN,
        n if n % 2 == 1 => sorted[n / 2],
        n => f64::midpoint(sorted[n / 2 - 1], sorted[n / 2]),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may")]
    use super::*;

    fn written(text: &str) -> tempfile::NamedTempFile {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        file
    }

    #[test]
    fn title_lines_empty_columns_and_spikes_are_left_behind() {
        let file = written(
            "U,of,U,,\nMU,,,,\nDepth,Pump Press (psi),Flow In (gpm),,\n85.1,460,1109.5,,\n86.1,459,0,,\n87.1,458,1300,,\n88.1,,900,,\n,,,,\n",
        );
        let log = read(file.path(), "Depth").unwrap();
        let (clean, left_out) = drilling(&log).unwrap();
        assert_eq!(left_out, 3);
        assert_eq!(
            clean.text(),
            "depth,flow_in,standpipe\nft,gpm,psi\n85.1,1109.5,460\n"
        );
        assert!(
            log.named("Flow Out %")
                .unwrap_err()
                .to_string()
                .contains("Depth, Pump Press")
        );
        assert!(read(file.path(), "time").is_err());
    }

    #[test]
    fn medians_pass_over_a_spike_and_stay_within_their_file() {
        let mut text = String::from("time,pre1,pre2,vib1,flow2,flow1,\n");
        for i in 0..150 {
            let flow = if i == 7 { 1e9 } else { 2.0 };
            text += &format!("14:11.{i},0.5 ,0.4,x,1.5,{flow},\n");
        }
        let file = written(&text);
        let one = read(file.path(), "time").unwrap();
        let both = bench(&[one.clone(), one]).unwrap();
        assert_eq!(
            both.text(),
            "sample,pre1,pre2,flow1,flow2\n0,0.5,0.4,2,1.5\n1,0.5,0.4,2,1.5\n"
        );
    }
}
