//! From the columns of a recording to windows of inputs and readings.

use crate::assembly::Assembly;
use crate::build::listed;
use crate::error::AssemblyError;
use dgd_units::{Dimension, Unit};
use std::collections::BTreeMap;

/// Columns of a recording by name, all of one length; borrowed.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Record<'a> {
    /// Name and values; NaN where there is none.
    pub columns: Vec<(&'a str, &'a [f64])>,
}

impl<'a> Record<'a> {
    fn find(&self, name: &str) -> Option<&'a [f64]> {
        self.columns.iter().find(|c| c.0 == name).map(|c| c.1)
    }

    fn column(&self, name: &str, use_: &str) -> Result<&'a [f64], AssemblyError> {
        self.find(name).ok_or_else(|| AssemblyError::Column {
            name: name.into(),
            use_: use_.into(),
            known: listed(self.columns.iter().map(|c| c.0)),
        })
    }
}

/// Which part of the record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Portion {
    /// The training windows.
    #[default]
    Train,
    /// The held-out windows.
    Test,
    /// All samples, with the training part's channels.
    All,
}

/// One stretch of samples, in the units of the assembly.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Window {
    /// Times (or the independent variable), ascending, shape `(n,)`.
    pub time: Vec<f64>,
    /// Values of each input, in the order of [`Assembly::inputs`], each of shape `(n,)`.
    pub inputs: Vec<Vec<f64>>,
    /// Readings of each instrument, in the order of [`Assembly::outputs`]: shape `(n,)`, NaN where there is none; empty if
    /// the record has no such column.
    pub readings: Vec<Vec<f64>>,
    /// Where drifts and whatever else goes by the clock count from; the first of `time` if absent. [`Assembly::windows`] gives
    /// the start of the first training window to all windows of the same record, so that a drift goes on in a held-out
    /// one, and nothing to a part with channels of its own, which is another run.
    pub origin: Option<f64>,
}

impl Window {
    /// Where drifts count from.
    #[must_use]
    pub fn origin(&self) -> f64 {
        let first = self.time.first().copied().unwrap_or_default();
        self.origin.unwrap_or(first)
    }
}

impl Assembly {
    /// Takes the samples of a part out of a record, in SI units where a unit is given.
    ///
    /// An instrument without a column is taken as not recorded. A sample without a value of an input keeps the last one;
    /// samples before the first are left out.
    ///
    /// # Errors
    /// [`AssemblyError::Column`] on a missing input, [`AssemblyError::Length`] on unequal columns,
    /// [`AssemblyError::Times`] on times that do not ascend, [`AssemblyError::Window`] on a window with fewer than 2 samples.
    pub fn windows(
        &self,
        record: &Record<'_>,
        portion: Portion,
    ) -> Result<Vec<Window>, AssemblyError> {
        let layout = &self.system.record;
        let (part, name) = match (portion, &layout.test) {
            (Portion::Test, Some(test)) => (test, "record.test"),
            (Portion::Test, None) => return Ok(Vec::new()),
            (Portion::Train | Portion::All, _) => (&layout.train, "record.train"),
        };
        let samples = self.samples(record, layout.channels(portion))?;
        let spans: &[[f64; 2]] = if portion == Portion::All || part.windows.is_empty() {
            &[[f64::NEG_INFINITY, f64::INFINITY]]
        } else {
            &part.windows
        };
        let mut windows = Vec::new();
        for span in spans {
            let window = samples.within(span.map(|at| at * self.net.tick));
            if window.time.len() < 2 {
                return Err(AssemblyError::Window {
                    part: name.into(),
                    from: span[0],
                    to: span[1],
                    found: window.time.len(),
                    expected: 2,
                    why: samples.why_few(*span, self.net.tick),
                });
            }
            windows.push(window);
        }
        if layout.channels(portion) == layout.channels(Portion::Train) {
            let train = layout.train.windows.first();
            let origin = samples.origin(train.map_or(f64::NEG_INFINITY, |w| w[0] * self.net.tick));
            for window in &mut windows {
                window.origin = origin;
            }
        }
        Ok(windows)
    }

    /// All samples of a record, under the channels of a part; those of a relation in the order of its independent variable.
    fn samples(
        &self,
        record: &Record<'_>,
        channels: &BTreeMap<String, String>,
    ) -> Result<Samples, AssemblyError> {
        let length = record.columns.first().map_or(0, |c| c.1.len());
        if let Some((name, column)) = record.columns.iter().find(|c| c.1.len() != length) {
            return Err(AssemblyError::Length {
                name: (*name).into(),
                expected: length,
                found: column.len(),
            });
        }
        let time = self.times(record, length)?;
        let wanted = |channel| channels.get(channel).unwrap_or(channel);
        let mut inputs = Vec::new();
        for driven in &self.net.driven {
            let raw = record.column(wanted(&driven.channel), &driven.path)?;
            inputs.push(convert(raw, driven.unit));
        }
        let readings = self.net.meters.iter().map(|m| {
            let raw = record.find(wanted(&m.channel));
            raw.map_or_else(Vec::new, |raw| convert(raw, m.unit))
        });
        let mut samples = Samples {
            time,
            inputs,
            readings: readings.collect(),
        };
        if !samples.time.is_sorted() {
            samples.sort();
        }
        Ok(samples)
    }

    fn times(&self, record: &Record<'_>, length: usize) -> Result<Vec<f64>, AssemblyError> {
        let layout = &self.system.record;
        let Some(name) = &layout.time else {
            let step = self.net.tick * layout.step.unwrap_or(1.0);
            #[expect(clippy::cast_precision_loss, reason = "sample numbers")]
            return Ok((0..length).map(|i| i as f64 * step).collect());
        };
        let found = record.column(name, &self.system.independent)?;
        let mut before = f64::NEG_INFINITY;
        for (i, &t) in found.iter().enumerate() {
            // A relation between samples needs no order.
            if !t.is_finite() || (self.net.in_time && t <= before) {
                return Err(AssemblyError::Times {
                    name: name.clone(),
                    index: i + 1,
                    found: t,
                    before,
                });
            }
            before = t;
        }
        Ok(found.iter().map(|t| t * self.net.tick).collect())
    }
}

/// All samples of a record, in SI units.
struct Samples {
    time: Vec<f64>,
    inputs: Vec<Vec<f64>>,
    /// Empty where there is no such column.
    readings: Vec<Vec<f64>>,
}

impl Samples {
    /// Along the independent variable: neighbours are what lies side by side, in whatever order it was written down.
    fn sort(&mut self) {
        let mut order: Vec<usize> = (0..self.time.len()).collect();
        order.sort_by(|&a, &b| self.time[a].total_cmp(&self.time[b]));
        let columns = self.inputs.iter_mut().chain(&mut self.readings);
        for column in columns.chain([&mut self.time]) {
            if !column.is_empty() {
                *column = order.iter().map(|&i| column[i]).collect();
            }
        }
    }

    /// Those of a span, each with the last value of every input.
    fn within(&self, [from, to]: [f64; 2]) -> Window {
        let mut window = Window {
            inputs: vec![Vec::new(); self.inputs.len()],
            readings: vec![Vec::new(); self.readings.len()],
            ..Window::default()
        };
        let mut last = vec![f64::NAN; self.inputs.len()];
        for (i, &time) in self.time.iter().enumerate() {
            for (value, column) in last.iter_mut().zip(&self.inputs) {
                if column[i].is_finite() {
                    *value = column[i];
                }
            }
            if !(time >= from && time <= to) || last.iter().any(|v| v.is_nan()) {
                continue;
            }
            window.time.push(time);
            for (out, &value) in window.inputs.iter_mut().zip(&last) {
                out.push(value);
            }
            for (out, column) in window.readings.iter_mut().zip(&self.readings) {
                out.extend(column.get(i));
            }
        }
        window
    }

    /// Why a span, in units of `tick`, holds too few.
    fn why_few(&self, span: [f64; 2], tick: f64) -> String {
        let [from, to] = span.map(|at| at * tick);
        let within = self
            .time
            .iter()
            .filter(|t| **t >= from && **t <= to)
            .count();
        match (self.time.first(), self.time.last()) {
            _ if from > to => "it ends before it begins".to_owned(),
            (Some(first), Some(last)) if within < 2 => {
                format!("the record runs from {} to {}", first / tick, last / tick)
            }
            (Some(_), Some(_)) => {
                format!("{within} lie there, before every input has its first value")
            }
            _ => "the record is empty".to_owned(),
        }
    }

    /// The first sample from `start` on that may be in a window.
    fn origin(&self, start: f64) -> Option<f64> {
        // Samples before the first value of an input are in no window.
        let first = self
            .inputs
            .iter()
            .map(|column| column.iter().position(|v| v.is_finite()))
            .try_fold(0, |latest, first| first.map(|f| latest.max(f)))?;
        self.time[first..].iter().copied().find(|t| *t >= start)
    }
}

/// A difference of readings in SI units: no zero counts.
pub(crate) fn difference(raw: f64, unit: Option<Unit>) -> f64 {
    match unit {
        Some(unit) if unit.dimension != Dimension::Number => raw * unit.factor,
        _ => raw,
    }
}

/// A column in SI units. Voltages and bare numbers stay as they are.
fn convert(raw: &[f64], unit: Option<Unit>) -> Vec<f64> {
    match unit {
        Some(unit) if unit.dimension != Dimension::Number => {
            raw.iter().map(|&v| unit.to_si(v)).collect()
        }
        _ => raw.to_vec(),
    }
}
