//! Steady states and linear models around an operating point.

use crate::assembly::Assembly;
use crate::error::AssemblyError;
use crate::simulate::Model;
use dgd_dynamics::integrate::{self, Method, Plan, System};
use nalgebra::{DMatrix, Schur};

/// A state in which nothing changes.
#[derive(Debug, Clone, PartialEq)]
pub struct Steady {
    /// State, in the order of [`Assembly::states`].
    pub state: Vec<f64>,
    /// Readings, in the order of [`Assembly::outputs`].
    pub outputs: Vec<f64>,
    /// Rates that are left, in usual sizes a usual time: how steady it is.
    pub residual: f64,
    /// Whether it is one; a tank that nothing regulates has none but by chance.
    pub found: bool,
}

/// Below this many usual sizes a usual time a state counts as steady.
const STEADY: f64 = 1e-8;

/// Finds the steady state at constant inputs that the system comes to from `guess`: a long implicit run, then Newton's
/// method. Time-dependent effects are held at the window's start.
///
/// - `inputs`: one value an input, in the order of [`Assembly::inputs`].
/// - `guess`: one value a state.
///
/// # Errors
/// [`AssemblyError::Length`] on wrong lengths, [`AssemblyError::Value`] on numbers that are not finite.
pub fn steady_state(
    assembly: &Assembly,
    theta: &[f64],
    inputs: &[f64],
    guess: &[f64],
) -> Result<Steady, AssemblyError> {
    check(assembly, theta, inputs, guess)?;
    let net = &assembly.net;
    let n = net.states.len();
    let mut model = Model::still(net, theta, inputs);
    let mut x = guess.to_vec();
    let time = net.parts.first().map_or(1.0, |p| p.scale.time_s);
    let sizes: Vec<f64> = net.states.iter().map(|s| s.size).collect();
    if n > 0 {
        let end = 1e5 * time;
        let settings = integrate::Options {
            max_steps: 20_000,
            ..integrate::Options::new(1e-6, sizes.iter().map(|s| 1e-8 * s).collect())
        };
        let plan = Plan {
            start: 0.0,
            end,
            outputs: &[],
            breaks: &[],
        };
        let run = integrate::integrate(Method::Rodasp, &mut model, &x, &plan, &settings)?;
        if run.end_state.iter().all(|v| v.is_finite()) {
            x = run.end_state;
        }
    }
    // The run remembers that a tank spills at its brim, where it holds the level: that is no steady state.
    let model = Model::still(net, theta, inputs);
    model.shut_valves(&x);
    let mut residual = size_of_rates(&model, &x, &sizes, time);
    for _ in 0..30 {
        if n == 0 || residual < 1e-13 {
            break;
        }
        let (a, rate) = jacobian(&model, &x, &sizes);
        // Minus: A dx = −f.
        let Some(step) = a.lu().solve(&nalgebra::DVector::from_column_slice(&rate)) else {
            break;
        };
        // Where a flow comes to rest under a square law the full step lands as far off on the other side.
        let mut better = None;
        for halvings in 0..12 {
            let share = 0.5_f64.powi(halvings);
            let next: Vec<f64> = x
                .iter()
                .zip(step.iter())
                .map(|(x, s)| x - share * s)
                .collect();
            let now = size_of_rates(&model, &next, &sizes, time);
            if now < residual {
                better = Some((next, now));
                break;
            }
        }
        let Some((next, now)) = better else {
            break;
        };
        (x, residual) = (next, now);
    }
    // Between its bounds alone does a tank rest by itself.
    let within = {
        let work = model.work.borrow();
        let rests = |k: usize| x[k] >= 0.0 && x[k] <= work.brim(net, k, &x);
        (0..net.tanks.len()).all(rests)
    };
    let mut outputs = vec![vec![f64::NAN]; net.meters.len()];
    model.read(&x, 0, &mut outputs);
    Ok(Steady {
        outputs: outputs.into_iter().map(|o| o[0]).collect(),
        found: residual < STEADY && within,
        state: x,
        residual,
    })
}

fn size_of_rates(model: &Model<'_>, x: &[f64], sizes: &[f64], time: f64) -> f64 {
    let mut rate = vec![0.0; x.len()];
    model.rhs(0.0, x, &mut rate);
    rate.iter()
        .zip(sizes)
        .map(|(r, s)| (r / s * time).abs())
        // `max` drops a NaN on either side.
        .fold(0.0, |m: f64, r| {
            if m.is_nan() || r.is_nan() {
                f64::NAN
            } else {
                m.max(r)
            }
        })
}

fn jacobian(model: &Model<'_>, x: &[f64], sizes: &[f64]) -> (DMatrix<f64>, Vec<f64>) {
    let n = x.len();
    let mut rate = vec![0.0; n];
    let mut a = DMatrix::zeros(n, n);
    let (mut above, mut below) = (vec![0.0; n], vec![0.0; n]);
    for j in 0..n {
        let h = 1e-6 * x[j].abs().max(1e-2 * sizes[j]);
        let mut moved = x.to_vec();
        moved[j] = x[j] + h;
        model.rhs(0.0, &moved, &mut above);
        moved[j] = x[j] - h;
        model.rhs(0.0, &moved, &mut below);
        for i in 0..n {
            a[(i, j)] = (above[i] - below[i]) / (2.0 * h);
        }
    }
    model.rhs(0.0, x, &mut rate);
    // What a shut valve holds has no rate, and no step to make.
    for j in 0..n {
        if rate[j] == 0.0 && a.row(j).iter().all(|slope| *slope == 0.0) {
            a[(j, j)] = 1.0;
        }
    }
    (a, rate)
}

/// A linear model `dx/dt = A x + B u`, `y = C x + D u` of deviations, or its discrete form `x⁺ = A x + B u`.
///
/// Matrices are row-major; rows and columns go by the names.
#[derive(Debug, Clone, PartialEq)]
pub struct Linear {
    /// States.
    pub states: Vec<String>,
    /// Inputs.
    pub inputs: Vec<String>,
    /// Outputs.
    pub outputs: Vec<String>,
    /// `A`, `n × n`.
    pub a: Vec<f64>,
    /// `B`, `n × m`.
    pub b: Vec<f64>,
    /// `C`, `k × n`.
    pub c: Vec<f64>,
    /// `D`, `k × m`.
    pub d: Vec<f64>,
    /// Step of a discrete model, s; `None`: continuous.
    pub step_s: Option<f64>,
    /// Rates (or zero, if discrete) at the operating point: not zero away from a steady state.
    pub rates: Vec<f64>,
}

/// Linearises around `state` and `inputs` by central differences.
///
/// # Errors
/// As [`steady_state`].
pub fn linearise(
    assembly: &Assembly,
    theta: &[f64],
    state: &[f64],
    inputs: &[f64],
) -> Result<Linear, AssemblyError> {
    check(assembly, theta, inputs, state)?;
    let net = &assembly.net;
    let (n, m, k) = (net.states.len(), net.driven.len(), net.meters.len());
    let sizes: Vec<f64> = net.states.iter().map(|s| s.size).collect();
    let at = |x: &[f64], u: &[f64]| {
        let model = Model::still(net, theta, u);
        model.shut_valves(state);
        let mut rate = vec![0.0; n];
        model.rhs(0.0, x, &mut rate);
        let mut outputs = vec![vec![f64::NAN]; k];
        model.read(x, 0, &mut outputs);
        rate.extend(outputs.into_iter().map(|o| o[0]));
        rate
    };
    let mut linear = Linear {
        states: assembly.states(),
        inputs: assembly.inputs(),
        outputs: assembly.outputs(),
        a: vec![0.0; n * n],
        b: vec![0.0; n * m],
        c: vec![0.0; k * n],
        d: vec![0.0; k * m],
        step_s: None,
        rates: at(state, inputs)[..n].to_vec(),
    };
    for j in 0..n + m {
        let (mut x, mut u) = (state.to_vec(), inputs.to_vec());
        let place = if j < n { &mut x[j] } else { &mut u[j - n] };
        let h = if j < n {
            1e-6 * place.abs().max(1e-2 * sizes[j])
        } else {
            1e-6 * place.abs().max(1e-3)
        };
        let middle = *place;
        let mut column = Vec::new();
        for sign in [1.0, -1.0] {
            let (mut x, mut u) = (state.to_vec(), inputs.to_vec());
            *(if j < n { &mut x[j] } else { &mut u[j - n] }) = middle + sign * h;
            column.push(at(&x, &u));
        }
        for i in 0..n + k {
            let slope = (column[0][i] - column[1][i]) / (2.0 * h);
            match (i < n, j < n) {
                (true, true) => linear.a[i * n + j] = slope,
                (true, false) => linear.b[i * m + j - n] = slope,
                (false, true) => linear.c[(i - n) * n + j] = slope,
                (false, false) => linear.d[(i - n) * m + j - n] = slope,
            }
        }
    }
    Ok(linear)
}

/// Share of a matrix's size within which its eigenvalues are rounding: differences give it to ten digits at most.
const ROUNDING: f64 = 1e-12;
/// The same of a discrete matrix, whose eigenvalues are told from 1: a few dozen units in the last place.
const ROUNDING_AT_ONE: f64 = 1e-14;

impl Linear {
    /// The discrete model with inputs held over steps of `step_s` (zero-order hold): `exp([A B; 0 0] h)`.
    ///
    /// # Errors
    /// [`AssemblyError::Value`] if the step is not positive and finite, the model is not finite or discrete already.
    pub fn discrete(&self, step_s: f64) -> Result<Self, AssemblyError> {
        let finite = self
            .a
            .iter()
            .chain(&self.b)
            .all(|v| (v * step_s).is_finite());
        if !(step_s > 0.0 && step_s.is_finite() && finite) || self.step_s.is_some() {
            return Err(AssemblyError::Value {
                name: "step_s".into(),
                found: step_s,
                expected: "a positive finite step for a finite continuous model",
            });
        }
        let (n, m) = (self.states.len(), self.inputs.len());
        let mut block = DMatrix::zeros(n + m, n + m);
        for i in 0..n {
            for j in 0..n {
                block[(i, j)] = self.a[i * n + j] * step_s;
            }
            for j in 0..m {
                block[(i, n + j)] = self.b[i * m + j] * step_s;
            }
        }
        let e = if n + m > 0 { block.exp() } else { block };
        let mut discrete = self.clone();
        discrete.step_s = Some(step_s);
        discrete.rates = vec![0.0; n];
        for i in 0..n {
            for j in 0..n {
                discrete.a[i * n + j] = e[(i, j)];
            }
            for j in 0..m {
                discrete.b[i * m + j] = e[(i, n + j)];
            }
        }
        Ok(discrete)
    }

    /// Eigenvalues of `A` as (real, imaginary), by falling real part: 1/s if continuous. Empty if `A` is not finite. What is no more than the
    /// rounding of a continuous `A` is 0.
    #[must_use]
    pub fn poles(&self) -> Vec<(f64, f64)> {
        let n = self.states.len();
        if n == 0 || self.a.iter().any(|v| !v.is_finite()) {
            return Vec::new();
        }
        let a = DMatrix::from_row_slice(n, n, &self.a);
        let least = match self.step_s {
            None => ROUNDING * a.norm(),
            Some(_) => 0.0,
        };
        let Some(schur) = Schur::try_new(a, f64::EPSILON, 100_000) else {
            return Vec::new();
        };
        let values = schur.complex_eigenvalues();
        let mut poles: Vec<(f64, f64)> = (values.iter())
            .map(|v| (v.re, v.im))
            .map(|(re, im)| {
                if re.hypot(im) <= least {
                    (0.0, 0.0)
                } else {
                    (re, im)
                }
            })
            .collect();
        poles.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.total_cmp(&b.1)));
        poles
    }

    /// Time constants, s, in the order of [`poles`](Self::poles): `−1/Re`, infinite for an integrator, negative if unstable.
    #[must_use]
    pub fn time_constants(&self) -> Vec<f64> {
        let constant = |(re, im): (f64, f64)| {
            let (real, step) = match self.step_s {
                Some(h) => (re.hypot(im).ln(), h),
                None => (re, 1.0),
            };
            let still = real == 0.0 || (self.step_s.is_some() && real.abs() <= ROUNDING_AT_ONE);
            if still { f64::INFINITY } else { -step / real }
        };
        self.poles().into_iter().map(constant).collect()
    }
}

fn check(
    assembly: &Assembly,
    theta: &[f64],
    inputs: &[f64],
    state: &[f64],
) -> Result<(), AssemblyError> {
    assembly.check_theta(theta)?;
    let pairs = [
        ("inputs", inputs, assembly.net.driven.len()),
        ("state", state, assembly.net.states.len()),
    ];
    for (name, slice, expected) in pairs {
        if slice.len() != expected {
            return Err(AssemblyError::Length {
                name: name.into(),
                expected,
                found: slice.len(),
            });
        }
        if let Some(&found) = slice.iter().find(|v| !v.is_finite()) {
            return Err(AssemblyError::Value {
                name: name.into(),
                found,
                expected: "finite numbers",
            });
        }
    }
    Ok(())
}
