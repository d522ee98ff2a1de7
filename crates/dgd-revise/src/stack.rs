//! The samples of all windows in one column: what is compared, and what a run leaves over.

use dgd_assembly::{Assembly, AssemblyError, RunStatus, SimulationOptions, Simulator, Window};

/// Where a row comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Row {
    pub window: usize,
    pub output: usize,
    pub sample: usize,
}

/// Windows with their readings in rows: by window, then output, then sample.
#[derive(Debug, Clone)]
pub(crate) struct Data {
    pub windows: Vec<Window>,
    pub rows: Vec<Row>,
    pub measured: Vec<f64>,
    /// Samples before each window, and all at the end.
    pub offsets: Vec<usize>,
    /// Whether window k is training window k, with its own free initial states; held-out windows use those of the first.
    pub training: bool,
}

impl Data {
    pub(crate) fn new(windows: Vec<Window>, training: bool) -> Self {
        let mut data = Self {
            windows: Vec::new(),
            rows: Vec::new(),
            measured: Vec::new(),
            offsets: vec![0],
            training,
        };
        for (w, window) in windows.iter().enumerate() {
            for (output, reading) in window.readings.iter().enumerate() {
                for (sample, value) in reading.iter().enumerate().filter(|(_, v)| v.is_finite()) {
                    data.rows.push(Row {
                        window: w,
                        output,
                        sample,
                    });
                    data.measured.push(*value);
                }
            }
            data.offsets.push(data.offsets[w] + window.time.len());
        }
        data.windows = windows;
        data
    }

    /// Samples of all windows.
    pub(crate) fn samples(&self) -> usize {
        self.offsets.last().copied().unwrap_or(0)
    }

    /// Number of a row's sample over all windows.
    pub(crate) fn position(&self, row: &Row) -> usize {
        self.offsets[row.window] + row.sample
    }

    /// Independent variable of a row.
    pub(crate) fn time(&self, row: &Row) -> f64 {
        self.windows[row.window].time[row.sample]
    }

    /// Rows of an output.
    pub(crate) fn of_output(&self, output: usize) -> Vec<usize> {
        (0..self.rows.len())
            .filter(|&i| self.rows[i].output == output)
            .collect()
    }

    /// Root mean square over the rows of an output; NaN if it was not recorded.
    pub(crate) fn rms(&self, values: &[f64], output: usize) -> f64 {
        let (mut sum, mut n) = (0.0, 0.0);
        for (row, v) in self.rows.iter().zip(values) {
            if row.output == output {
                sum += v * v;
                n += 1.0;
            }
        }
        f64::sqrt(sum / n)
    }
}

/// Runs an assembly over all windows.
pub(crate) struct Runner<'a> {
    simulators: Vec<Simulator<'a>>,
    data: &'a Data,
}

impl<'a> Runner<'a> {
    pub(crate) fn new(
        assembly: &'a Assembly,
        data: &'a Data,
        options: &SimulationOptions,
    ) -> Result<Self, AssemblyError> {
        let simulators = data
            .windows
            .iter()
            .enumerate()
            .map(|(number, window)| {
                Simulator::new(
                    assembly,
                    window,
                    if data.training { number } else { 0 },
                    options,
                )
            })
            .collect::<Result<_, _>>()?;
        Ok(Self { simulators, data })
    }

    /// Simulated readings of each row; `None` if a run did not finish.
    pub(crate) fn run(&mut self, theta: &[f64]) -> Option<Vec<f64>> {
        let mut outputs = Vec::with_capacity(self.simulators.len());
        for simulator in &mut self.simulators {
            let run = simulator.run(theta).ok()?;
            if run.status != RunStatus::Finished {
                return None;
            }
            outputs.push(run.outputs);
        }
        let all: Vec<f64> = self
            .data
            .rows
            .iter()
            .map(|row| outputs[row.window][row.output][row.sample])
            .collect();
        all.iter().all(|v| v.is_finite()).then_some(all)
    }

    /// States by window, state and sample; `None` if a run did not finish.
    pub(crate) fn states(&mut self, theta: &[f64]) -> Option<Vec<Vec<Vec<f64>>>> {
        let mut all = Vec::new();
        for simulator in &mut self.simulators {
            let run = simulator.run(theta).ok()?;
            if run.status != RunStatus::Finished {
                return None;
            }
            all.push(run.states);
        }
        Some(all)
    }

    /// Outputs by window, output and sample; `None` if a run did not finish.
    pub(crate) fn outputs(&mut self, theta: &[f64]) -> Option<Vec<Vec<Vec<f64>>>> {
        let mut all = Vec::new();
        for simulator in &mut self.simulators {
            let run = simulator.run(theta).ok()?;
            if run.status != RunStatus::Finished {
                return None;
            }
            all.push(run.outputs);
        }
        Some(all)
    }
}
