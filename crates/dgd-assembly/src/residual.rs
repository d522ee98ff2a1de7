//! Simulated less measured, as a function of scaled parameters.

use crate::assembly::Assembly;
use crate::error::AssemblyError;
use crate::fit::{FitOptions, Loss};
use crate::record::Window;
use crate::simulate::{RunStatus, Simulator};
use dgd_lsq::lm::{Bounds, Residuals};
use nalgebra::DMatrix;

/// The residuals of all windows as a function of the scaled parameters.
pub(crate) struct Residual<'a> {
    simulators: Vec<Simulator<'a>>,
    windows: &'a [Window],
    /// Scale of each meter; `None` if it is not fitted.
    pub scale: Vec<Option<f64>>,
    low: Vec<f64>,
    pub span: Vec<f64>,
    pub start: Vec<f64>,
    /// Which entries of theta are moved.
    pub moving: Vec<usize>,
    loss: Loss,
    pub runs: usize,
}

/// Step of the forward differences in scaled parameters: truncation and the integrator's noise meet there.
const STEP: f64 = 1e-5;

impl<'a> Residual<'a> {
    pub(crate) fn new(
        assembly: &'a Assembly,
        windows: &'a [Window],
        options: &FitOptions,
    ) -> Result<Self, AssemblyError> {
        options.check()?;
        let parameters = assembly.parameters();
        let start = options.start.clone().unwrap_or_else(|| assembly.start());
        assembly.check_theta(&start)?;
        for name in &options.held {
            if !parameters.iter().any(|p| p.path == *name) {
                return Err(AssemblyError::Column {
                    name: name.clone(),
                    use_: "held parameters".into(),
                    known: crate::build::listed(parameters.iter().map(|p| p.path.as_str())),
                });
            }
        }
        let moving = (0..parameters.len())
            .filter(|&i| !options.held.contains(&parameters[i].path))
            .collect();
        let mut simulators = Vec::new();
        for (number, window) in windows.iter().enumerate() {
            simulators.push(Simulator::new(
                assembly,
                window,
                number,
                &options.simulation,
            )?);
        }
        let names = assembly.outputs();
        if let Some(unknown) = options.outputs.iter().find(|o| !names.contains(o)) {
            return Err(AssemblyError::Column {
                name: unknown.clone(),
                use_: "fitted outputs".into(),
                known: names.join(", "),
            });
        }
        for window in windows {
            for (name, readings) in names.iter().zip(&window.readings) {
                if !readings.is_empty() && readings.len() != window.time.len() {
                    return Err(AssemblyError::Length {
                        name: (*name).to_owned(),
                        expected: window.time.len(),
                        found: readings.len(),
                    });
                }
            }
        }
        let accuracies = assembly.accuracies();
        let mut scale = Vec::new();
        for (m, name) in names.iter().enumerate() {
            let wanted = options.outputs.is_empty() || options.outputs.contains(name);
            let read: Vec<f64> = windows
                .iter()
                .filter_map(|w| w.readings.get(m))
                .flatten()
                .copied()
                .filter(|v| v.is_finite())
                .collect();
            let part = &assembly.net.parts[assembly.net.meters[m].part];
            let sigma = accuracies[m].unwrap_or_else(|| deviation(&read));
            scale.push((wanted && !read.is_empty()).then_some(if sigma > 0.0 {
                sigma
            } else {
                part.scale.reading
            }));
        }
        if scale.iter().all(Option::is_none) {
            return Err(AssemblyError::NoReadings {
                names: names.join("`, `"),
            });
        }
        Ok(Self {
            simulators,
            windows,
            scale,
            low: parameters.iter().map(|p| p.low).collect(),
            span: parameters.iter().map(|p| p.high - p.low).collect(),
            start,
            moving,
            loss: options.loss,
            runs: 0,
        })
    }

    pub(crate) fn scaled(&self, theta: &[f64]) -> Vec<f64> {
        self.moving
            .iter()
            .map(|&i| ((theta[i] - self.low[i]) / self.span[i]).clamp(0.0, 1.0))
            .collect()
    }

    pub(crate) fn theta(&self, z: &[f64]) -> Vec<f64> {
        let mut theta = self.start.clone();
        for (&i, &z) in self.moving.iter().zip(z) {
            theta[i] = self.low[i] + z * self.span[i];
        }
        theta
    }

    /// Simulated less measured by window and meter; `None` if a run did not finish.
    pub(crate) fn differences(&mut self, theta: &[f64]) -> Option<Vec<Vec<Vec<f64>>>> {
        let mut all = Vec::new();
        for (simulator, window) in self.simulators.iter_mut().zip(self.windows) {
            self.runs += 1;
            let mut run = simulator.run(theta).ok()?;
            if run.status != RunStatus::Finished {
                return None;
            }
            for (output, reading) in run.outputs.iter_mut().zip(&window.readings) {
                if reading.is_empty() {
                    output.fill(f64::NAN);
                }
                for (o, r) in output.iter_mut().zip(reading) {
                    *o -= r;
                }
            }
            all.push(run.outputs);
        }
        Some(all)
    }

    /// The differences that count, scaled, in one row.
    fn flat(&self, differences: &[Vec<Vec<f64>>]) -> Option<Vec<f64>> {
        let mut flat = Vec::new();
        for (window, read) in differences.iter().zip(self.windows) {
            for ((column, reading), scale) in window.iter().zip(&read.readings).zip(&self.scale) {
                if let Some(scale) = scale {
                    flat.extend(
                        column
                            .iter()
                            .zip(reading)
                            .filter(|(_, r)| r.is_finite())
                            .map(|(d, _)| d / scale),
                    );
                }
            }
        }
        flat.iter().all(|v| v.is_finite()).then_some(flat)
    }
}

impl Residuals for Residual<'_> {
    fn at(&mut self, z: &[f64]) -> Option<Vec<f64>> {
        let theta = self.theta(z);
        let differences = self.differences(&theta)?;
        self.flat(&differences)
    }

    fn jacobian(&mut self, z: &[f64], r: &[f64], _: &Bounds) -> Option<DMatrix<f64>> {
        let mut jacobian = DMatrix::zeros(r.len(), z.len());
        let mut moved = z.to_vec();
        for (j, mut column) in jacobian.column_iter_mut().enumerate() {
            // Inwards from the upper bound; where the system cannot be run on one side, on the other.
            let inwards = if z[j] > 0.5 { -STEP } else { STEP };
            moved[j] = z[j] + inwards;
            let mut there = self.at(&moved);
            if there.is_none() {
                moved[j] = z[j] - inwards;
                there = self.at(&moved);
            }
            let (there, step) = (there?, moved[j] - z[j]);
            for ((c, a), b) in column.iter_mut().zip(&there).zip(r) {
                *c = (a - b) / step;
            }
            moved[j] = z[j];
        }
        Some(jacobian)
    }

    fn weights(&self, r: &[f64]) -> Option<Vec<f64>> {
        let Loss::Huber(k) = self.loss else {
            return None;
        };
        let limit = k * 1.4826 * median_size(r);
        Some(
            r.iter()
                .map(|r| {
                    if r.abs() <= limit {
                        1.0
                    } else {
                        limit / r.abs()
                    }
                })
                .collect(),
        )
    }
}

/// Median size of the residuals; of those that are not 0 where most are, as of a system at rest, for then that of all weighs every
/// other one with nothing.
fn median_size(r: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = r.iter().map(|r| r.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let median = |sizes: &[f64]| sizes.get(sizes.len() / 2).copied().unwrap_or(0.0);
    let zeros = sizes.partition_point(|size| *size <= 0.0);
    match median(&sizes) {
        0.0 => median(&sizes[zeros..]),
        all => all,
    }
}

fn deviation(values: &[f64]) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "sample counts")]
    let n = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt()
}

#[cfg(test)]
mod tests {
    use super::median_size;

    #[test]
    fn residuals_that_are_mostly_0_have_a_size() {
        assert_eq!(median_size(&[1.0, -3.0, 2.0]), 2.0);
        assert_eq!(median_size(&[0.0, -3.0, 2.0]), 2.0);
        assert_eq!(median_size(&[0.0, 0.0, 0.0, -0.0, -3.0, 2.0, 4.0]), 3.0);
        assert_eq!(median_size(&[0.0, 0.0]), 0.0);
        assert_eq!(median_size(&[]), 0.0);
    }
}
