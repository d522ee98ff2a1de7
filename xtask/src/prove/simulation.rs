//! The held-out gain, recomputed from `simulation.csv`, and the rules of that file.

use super::answer::SIGNALS;
use super::targets::{HELD_SAMPLES, HELD_SHARE, HELD_WINDOW_S, WORSE};
use anyhow::{Context, Result, bail};

#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Simulation {
    pub(crate) held_share: f64,
    pub(crate) shortest_window_s: f64,
    /// By [`SIGNALS`]; `None` where there is too little to compare.
    pub(crate) gains: [Option<Gain>; 4],
}

/// Held-out errors of one signal, in its unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Gain {
    pub(crate) rmse_before: f64,
    pub(crate) rmse_after: f64,
    pub(crate) samples: usize,
}

impl Gain {
    pub(crate) fn ratio(self) -> f64 {
        // An exact model would divide zero by zero.
        self.rmse_after / self.rmse_before.max(1e-12)
    }

    pub(crate) fn worse(self) -> bool {
        self.ratio() > WORSE
    }
}

impl Simulation {
    /// Whether held-out windows are long enough, and enough of them.
    pub(crate) fn keeps_rules(&self) -> bool {
        self.held_share >= HELD_SHARE && self.shortest_window_s >= HELD_WINDOW_S
    }

    /// Whether the model after is the model before, in all that can be compared.
    pub(crate) fn unmodelled(&self) -> bool {
        let mut gains = self.gains.iter().flatten().peekable();
        gains.peek().is_some() && gains.all(|g| (g.ratio() - 1.0).abs() < 1e-9)
    }

    /// # Errors
    /// When a column is missing or a row cannot be read.
    pub(crate) fn read(text: &str) -> Result<Simulation> {
        let mut lines = text.lines().enumerate();
        let header = lines.next().context("simulation.csv: empty")?.1;
        let names: Vec<&str> = header.split(',').map(str::trim).collect();
        let column = |name: &str| {
            let at = names.iter().position(|n| *n == name);
            at.with_context(|| format!("simulation.csv: no column `{name}`"))
        };
        let (t, held, valid) = (column("t_s")?, column("held_out")?, column("valid")?);
        let mut wanted = [[0; 3]; 4];
        for (signal, at) in SIGNALS.iter().zip(&mut wanted) {
            for (suffix, at) in ["measured", "before", "after"].iter().zip(at) {
                *at = column(&format!("{signal}_{suffix}"))?;
            }
        }
        let mut windows = Windows::default();
        let mut sums = [(0.0, 0.0, 0_usize); 4];
        let mut fields = Vec::with_capacity(names.len());
        for (number, line) in lines {
            fields.clear();
            for field in line.split(',') {
                fields.push(number_of(field).with_context(|| {
                    format!("simulation.csv line {}: `{field}` is no number", number + 1)
                })?);
            }
            if fields.len() != names.len() {
                bail!(
                    "simulation.csv line {}: {} fields, expected {}",
                    number + 1,
                    fields.len(),
                    names.len()
                );
            }
            if [fields[held], fields[valid]]
                .iter()
                .any(|f| *f != 0.0 && *f != 1.0)
            {
                bail!(
                    "simulation.csv line {}: `held_out` and `valid` are 0 or 1",
                    number + 1
                );
            }
            windows.row(fields[t], fields[held] != 0.0)?;
            if fields[held] == 0.0 || fields[valid] == 0.0 {
                continue;
            }
            for (sum, at) in sums.iter_mut().zip(&wanted) {
                let [measured, before, after] = at.map(|i| fields[i]);
                if (measured + before + after).is_finite() {
                    sum.0 += (measured - before).powi(2);
                    sum.1 += (measured - after).powi(2);
                    sum.2 += 1;
                }
            }
        }
        let gain = |(before, after, n): (f64, f64, usize)| {
            (n > HELD_SAMPLES).then(|| Gain {
                rmse_before: (before / n as f64).sqrt(),
                rmse_after: (after / n as f64).sqrt(),
                samples: n,
            })
        };
        Ok(Simulation {
            held_share: windows.held as f64 / windows.rows.max(1) as f64,
            shortest_window_s: windows.shortest(),
            gains: sums.map(gain),
        })
    }
}

fn number_of(field: &str) -> Option<f64> {
    match field.trim() {
        "" => Some(f64::NAN),
        text => text.parse().ok(),
    }
}

/// Held-out windows as they pass by.
#[derive(Default)]
struct Windows {
    rows: usize,
    held: usize,
    last_s: Option<f64>,
    open_since_s: Option<f64>,
    shortest_s: Option<f64>,
}

impl Windows {
    fn row(&mut self, t_s: f64, held: bool) -> Result<()> {
        if self.last_s.is_some_and(|last| t_s <= last) || !t_s.is_finite() {
            bail!("simulation.csv: `t_s` does not grow at {t_s}");
        }
        self.last_s = Some(t_s);
        self.rows += 1;
        self.held += usize::from(held);
        match (held, self.open_since_s) {
            (true, None) => self.open_since_s = Some(t_s),
            (false, Some(since)) => self.close(since, t_s),
            _ => {}
        }
        Ok(())
    }

    fn close(&mut self, since_s: f64, until_s: f64) {
        let length = until_s - since_s;
        self.shortest_s = Some(self.shortest_s.map_or(length, |s| s.min(length)));
        self.open_since_s = None;
    }

    /// Zero where nothing was held out.
    fn shortest(&mut self) -> f64 {
        if let (Some(since), Some(last)) = (self.open_since_s, self.last_s) {
            self.close(since, last);
        }
        self.shortest_s.unwrap_or(0.0)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may")]
    use super::*;
    use std::fmt::Write;

    /// 6,000 s with 1,500 s held out; before is off by two in the level, after by one half.
    fn file(held: std::ops::Range<usize>, rows: usize) -> String {
        let mut text = "t_s,held_out,valid".to_owned();
        for signal in SIGNALS {
            write!(text, ",{signal}_measured,{signal}_before,{signal}_after").unwrap();
        }
        text.push('\n');
        for t in 0..rows {
            let h = u8::from(held.contains(&t));
            // Outside held-out and valid rows nothing may count.
            let wild = if h == 1 && t % 10 != 0 { 0.0 } else { 1e9 };
            let valid = u8::from(t % 10 != 0);
            writeln!(
                text,
                "{t},{h},{valid},0.03,0.03,0.03,100,{},{},,,,5,5,5",
                102.0 + wild,
                100.5 + wild
            )
            .unwrap();
        }
        text
    }

    #[test]
    fn only_held_out_and_valid_rows_count() {
        let simulation = Simulation::read(&file(2000..3500, 6000)).unwrap();
        let level = simulation.gains[1].unwrap();
        assert!((level.rmse_before - 2.0).abs() < 1e-12);
        assert!((level.rmse_after - 0.5).abs() < 1e-12);
        assert!((level.ratio() - 0.25).abs() < 1e-12);
        assert_eq!(level.samples, 1350);
        assert_eq!(simulation.gains[2], None, "empty columns compare nothing");
        assert_eq!(simulation.held_share, 0.25);
        assert_eq!(simulation.shortest_window_s, 1500.0);
        assert!(simulation.keeps_rules());
    }

    #[test]
    fn short_windows_and_too_few_of_them_break_the_rules() {
        assert!(
            !Simulation::read(&file(2000..3100, 5000))
                .unwrap()
                .keeps_rules()
        );
        assert!(
            !Simulation::read(&file(2000..3300, 9000))
                .unwrap()
                .keeps_rules()
        );
        assert!(!Simulation::read(&file(0..0, 5000)).unwrap().keeps_rules());
        assert!(
            Simulation::read(&file(4000..5400, 5400))
                .unwrap()
                .keeps_rules()
        );
    }

    #[test]
    fn a_model_that_changes_nothing_is_seen() {
        let mut simulation = Simulation::read(&file(2000..3500, 6000)).unwrap();
        assert!(!simulation.unmodelled());
        simulation.gains[1] = simulation.gains[1].map(|g| Gain {
            rmse_after: g.rmse_before,
            ..g
        });
        // Flow and head are exact before and after: nothing to gain, nothing to lose.
        simulation.gains[0] = None;
        simulation.gains[3] = None;
        assert!(simulation.unmodelled());
        assert!(!Simulation::default().unmodelled());
    }

    #[test]
    fn a_damaged_file_is_refused_with_its_place() {
        let good = file(2000..3500, 6000);
        let refused = |text: &str| Simulation::read(text).unwrap_err().to_string();
        assert!(refused(&good.replacen("pump_head_m_after", "x", 1)).contains("pump_head_m_after"));
        assert!(refused(&good.replacen("\n7,", "\nseven,", 1)).contains("line 9: `seven`"));
        assert!(refused(&good.replacen("\n7,0,", "\n7,2,", 1)).contains("line 9"));
        assert!(refused(&good.replacen("\n7,", "\n6,", 1)).contains("does not grow"));
        assert!(refused(&good.replacen("\n7,0,1,", "\n7,0,1,1,", 1)).contains("16 fields"));
        assert!(refused("").contains("empty"));
    }
}
