//! The linear model along a window: what control design sees, beside the run of the equations themselves.

use super::{RunStatus, Simulation, Simulator};
use crate::error::AssemblyError;
use crate::linear::{linearise, steady_state};
use crate::simulate::Model;
use crate::spec::Between;
use nalgebra::{DMatrix, DVector};

impl Simulator<'_> {
    /// Deviations from the steady state at the mean of the window's inputs; from the window's start where there is none.
    ///
    /// Exact for inputs that are held; one that is interpolated counts by its mean over each step.
    pub(super) fn run_linear(&mut self, theta: &[f64]) -> Result<Simulation, AssemblyError> {
        let net = self.model.net;
        let (n, m, k) = (net.states.len(), net.driven.len(), net.meters.len());
        let samples = self.window.time.len();
        let first = if n == 0 {
            Vec::new()
        } else {
            self.initial(theta)?
        };
        #[expect(clippy::cast_precision_loss, reason = "sample counts")]
        let mean = |values: &Vec<f64>| values.iter().sum::<f64>() / samples as f64;
        let middle: Vec<f64> = self.window.inputs.iter().map(mean).collect();
        let steady = steady_state(self.assembly, theta, &middle, &first)?;
        let at = if steady.found {
            steady.state
        } else {
            first.clone()
        };
        let linear = linearise(self.assembly, theta, &at, &middle)?;
        let mut there = vec![vec![f64::NAN]; k];
        Model::still(net, theta, &middle).read(&at, 0, &mut there);
        let mut simulation = Simulation {
            time: self.window.time.clone(),
            outputs: vec![vec![f64::NAN; samples]; k],
            states: vec![vec![f64::NAN; samples]; n],
            held: Vec::new(),
            status: RunStatus::Finished,
        };
        let finite = [&linear.a, &linear.b, &linear.c, &linear.d, &linear.rates]
            .iter()
            .all(|matrix| matrix.iter().all(|v| v.is_finite()));
        if !finite {
            simulation.status = RunStatus::NotSolved;
            return Ok(simulation);
        }
        let c = DMatrix::from_row_slice(k, n, &linear.c);
        let d = DMatrix::from_row_slice(k, m, &linear.d);
        let off = |i: usize| {
            let inputs = self.window.inputs.iter().zip(&middle);
            DVector::from_iterator(m, inputs.map(|(values, middle)| values[i] - middle))
        };
        let mut x = DVector::from_iterator(n, first.iter().zip(&at).map(|(x, a)| x - a));
        let mut step: Option<(f64, Step)> = None;
        for i in 0..samples {
            let u = off(i);
            let y = &c * &x + &d * &u;
            for (o, column) in simulation.outputs.iter_mut().enumerate() {
                column[i] = there[o][0] + y[o];
            }
            for (s, column) in simulation.states.iter_mut().enumerate() {
                column[i] = at[s] + x[s];
            }
            if i + 1 == samples || n == 0 {
                continue;
            }
            let length = self.window.time[i + 1] - self.window.time[i];
            if step.as_ref().is_none_or(|(h, _)| *h != length) {
                step = Some((length, Step::of(&linear, length)));
            }
            let next = off(i + 1);
            let driven = net.driven.iter().enumerate();
            let over = driven.map(|(j, input)| match input.between {
                Between::Held => u[j],
                Between::Interpolated => 0.5 * (u[j] + next[j]),
            });
            let over = DVector::from_iterator(m, over);
            if let Some((_, step)) = &step {
                x = &step.a * &x + &step.b * over + &step.drift;
            }
        }
        let whole = simulation.outputs.iter().flatten().all(|v| v.is_finite());
        if !whole {
            simulation.status = RunStatus::NotSolved;
        }
        Ok(simulation)
    }
}

/// Over one step: `exp([A B r; 0] h)`, with the rates `r` at the operating point.
struct Step {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    drift: DVector<f64>,
}

impl Step {
    fn of(linear: &crate::linear::Linear, h: f64) -> Self {
        let (n, m) = (linear.states.len(), linear.inputs.len());
        let mut block = DMatrix::zeros(n + m + 1, n + m + 1);
        for i in 0..n {
            for j in 0..n {
                block[(i, j)] = linear.a[i * n + j] * h;
            }
            for j in 0..m {
                block[(i, n + j)] = linear.b[i * m + j] * h;
            }
            block[(i, n + m)] = linear.rates[i] * h;
        }
        let e = block.exp();
        Self {
            a: e.view((0, 0), (n, n)).into_owned(),
            b: e.view((0, n), (n, m)).into_owned(),
            drift: e.view((0, n + m), (n, 1)).column(0).into_owned(),
        }
    }
}
