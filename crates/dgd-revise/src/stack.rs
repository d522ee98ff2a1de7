//! The samples of all windows in one column: what is compared, and what a run leaves over.

use crate::held;
use dgd_assembly::{
    Assembly, AssemblyError, Method, RunStatus, Simulation, SimulationOptions, Simulator, Window,
};

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
    /// By window, the training window whose free initial states it starts from.
    pub numbers: Vec<usize>,
    /// By output, samples over which the log repeats a reading; such a reading is one row. 1 if it does not.
    pub held: Vec<usize>,
}

impl Data {
    /// The training windows, each with its own free initial states.
    pub(crate) fn training(windows: Vec<Window>) -> Self {
        let numbers = (0..windows.len()).collect();
        Self::new(windows, numbers)
    }

    pub(crate) fn new(windows: Vec<Window>, numbers: Vec<usize>) -> Self {
        let outputs = windows.first().map_or(0, |w| w.readings.len());
        let held = |output: usize| {
            let readings = windows.iter().map(|w| w.readings[output].as_slice());
            held::usual(&readings.collect::<Vec<_>>())
        };
        let mut data = Self {
            held: (0..outputs).map(held).collect(),
            windows: Vec::new(),
            rows: Vec::new(),
            measured: Vec::new(),
            offsets: vec![0],
            numbers,
        };
        for (w, window) in windows.iter().enumerate() {
            for (output, reading) in window.readings.iter().enumerate() {
                for sample in held::new(reading, data.held[output]) {
                    data.rows.push(Row {
                        window: w,
                        output,
                        sample,
                    });
                    data.measured.push(reading[sample]);
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

/// Runs one assembly over one window, again and again.
///
/// Explicit steps (Dormand and Prince) take half the time where nothing is stiff; what needs more of them than there are
/// samples is run by the method asked for from then on.
struct Pace<'a> {
    explicit: Option<Simulator<'a>>,
    asked: Simulator<'a>,
}

/// Steps a sample that explicit runs may take, besides a hundred.
const STEPS: usize = 2;

/// Settings of explicit runs; `None` if nothing else was asked for.
fn explicit(asked: &SimulationOptions, window: &Window) -> Option<SimulationOptions> {
    (asked.method != Method::DormandPrince).then(|| SimulationOptions {
        method: Method::DormandPrince,
        max_steps: (STEPS * window.time.len() + 100).min(asked.max_steps),
        ..*asked
    })
}

fn finished(run: Simulation) -> Option<Simulation> {
    (run.status == RunStatus::Finished).then_some(run)
}

impl<'a> Pace<'a> {
    fn new(
        assembly: &'a Assembly,
        window: &'a Window,
        number: usize,
        options: &SimulationOptions,
    ) -> Result<Self, AssemblyError> {
        Ok(Self {
            explicit: explicit(options, window)
                .map(|o| Simulator::new(assembly, window, number, &o))
                .transpose()?,
            asked: Simulator::new(assembly, window, number, options)?,
        })
    }

    /// A run that finished.
    fn run(&mut self, theta: &[f64]) -> Option<Simulation> {
        if let Some(explicit) = &mut self.explicit
            && let Some(run) = explicit.run(theta).ok().and_then(finished)
        {
            return Some(run);
        }
        let run = self.asked.run(theta).ok().and_then(finished)?;
        self.explicit = None;
        Some(run)
    }
}

/// One run of one window as [`Runner`] makes it; `stiff` is set once explicit steps have not sufficed.
pub(crate) fn run_once(
    assembly: &Assembly,
    window: &Window,
    number: usize,
    theta: &[f64],
    options: &SimulationOptions,
    stiff: &mut bool,
) -> Option<Simulation> {
    let one = |o: &SimulationOptions| {
        let run = assembly.simulate(theta, window, number, o).ok()?;
        finished(run)
    };
    if !*stiff && let Some(run) = explicit(options, window).and_then(|o| one(&o)) {
        return Some(run);
    }
    let run = one(options)?;
    *stiff = true;
    Some(run)
}

/// Runs an assembly over all windows.
pub(crate) struct Runner<'a> {
    simulators: Vec<Pace<'a>>,
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
            .zip(&data.numbers)
            .map(|(window, &number)| Pace::new(assembly, window, number, options))
            .collect::<Result<_, _>>()?;
        Ok(Self { simulators, data })
    }

    /// All windows; `None` if a run did not finish.
    fn windows(&mut self, theta: &[f64]) -> Option<Vec<Simulation>> {
        self.simulators.iter_mut().map(|s| s.run(theta)).collect()
    }

    /// Simulated readings of each row; `None` if a run did not finish.
    pub(crate) fn run(&mut self, theta: &[f64]) -> Option<Vec<f64>> {
        let runs = self.windows(theta)?;
        let all: Vec<f64> = self
            .data
            .rows
            .iter()
            .map(|row| runs[row.window].outputs[row.output][row.sample])
            .collect();
        all.iter().all(|v| v.is_finite()).then_some(all)
    }

    /// States by window, state and sample; `None` if a run did not finish.
    pub(crate) fn states(&mut self, theta: &[f64]) -> Option<Vec<Vec<Vec<f64>>>> {
        let runs = self.windows(theta)?;
        Some(runs.into_iter().map(|r| r.states).collect())
    }

    /// Outputs by window, output and sample; `None` if a run did not finish.
    pub(crate) fn outputs(&mut self, theta: &[f64]) -> Option<Vec<Vec<Vec<f64>>>> {
        let runs = self.windows(theta)?;
        Some(runs.into_iter().map(|r| r.outputs).collect())
    }
}
