//! How outputs move with parameters and initial states: by differences of whole runs, and by the variational equations.

use crate::assembly::Assembly;
use crate::error::AssemblyError;
use crate::network::Flow;
use crate::record::Window;
use crate::simulate::{Model, RunStatus, SimulationOptions, Simulator, set_theta};
use dgd_dynamics::integrate::{self, Plan, Status, System, Tolerances};

/// Derivatives of the outputs along a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensitivities {
    /// Paths of the parameters.
    pub parameters: Vec<String>,
    /// Names of the instruments.
    pub outputs: Vec<String>,
    /// Times.
    pub time: Vec<f64>,
    /// `∂y_m(t_i)/∂θ_p` at `[p][m][i]`, in the units of reading and parameter.
    pub values: Vec<Vec<Vec<f64>>>,
    /// `high − low` of each parameter: what one unit of a scaled parameter is.
    pub range: Vec<f64>,
    /// Usual size of each instrument's reading.
    pub size: Vec<f64>,
    /// How the runs ended: all finished, or as one did that did not.
    pub status: RunStatus,
}

/// Difference in scaled parameters. At a relative tolerance of 1e-8 truncation and noise both stay near 1e-5.
const STEP: f64 = 1e-4;
/// Difference along a direction in the right-hand side, which has no noise of an integrator.
const DIRECTION: f64 = 1e-5;

fn frame(assembly: &Assembly, window: &Window) -> Sensitivities {
    let parameters = assembly.parameters();
    let net = &assembly.net;
    Sensitivities {
        outputs: assembly.outputs(),
        time: window.time.clone(),
        values: Vec::new(),
        range: parameters.iter().map(|p| p.high - p.low).collect(),
        size: net
            .meters
            .iter()
            .map(|m| net.parts[m.part].scale.reading)
            .collect(),
        status: RunStatus::Finished,
        parameters: parameters.into_iter().map(|p| p.path).collect(),
    }
}

/// Sensitivities by central differences of whole runs, one-sided at a bound; right across a brim's overflow as well, and for every
/// effect.
///
/// The relative tolerance is tightened to 1e-8 if `options` ask for less, so that the integrator's steps leave no trace.
///
/// # Errors
/// As [`Assembly::simulate`].
pub fn sensitivities(
    assembly: &Assembly,
    theta: &[f64],
    window: &Window,
    number: usize,
    options: &SimulationOptions,
) -> Result<Sensitivities, AssemblyError> {
    assembly.check_theta(theta)?;
    let options = SimulationOptions {
        relative: options.relative.min(1e-8),
        ..*options
    };
    let mut simulator = Simulator::new(assembly, window, number, &options)?;
    let mut found = frame(assembly, window);
    let parameters = assembly.parameters();
    for p in 0..theta.len() {
        let h = STEP * found.range[p];
        // Beyond its bounds a parameter may mean nothing.
        let over = (theta[p] + h).min(parameters[p].high).max(theta[p]);
        let under = (theta[p] - h).max(parameters[p].low).min(theta[p]);
        let mut at = |value: f64| {
            let mut moved = theta.to_vec();
            moved[p] = value;
            simulator.run(&moved)
        };
        let (above, below) = (at(over)?, at(under)?);
        for run in [&above, &below] {
            if run.status != RunStatus::Finished {
                found.status = run.status;
            }
        }
        let difference = |(a, b): (&Vec<f64>, &Vec<f64>)| {
            a.iter()
                .zip(b)
                .map(|(a, b)| (a - b) / (over - under))
                .collect()
        };
        found.values.push(
            above
                .outputs
                .iter()
                .zip(&below.outputs)
                .map(difference)
                .collect(),
        );
    }
    Ok(found)
}

/// State and its derivatives by all scaled parameters, integrated together: `dS/dt = ∂f/∂x S + ∂f/∂θ`, each right-hand
/// side one central difference of `f` along `(S, e_p)`.
struct Variational<'a> {
    model: Model<'a>,
    theta: Vec<f64>,
    range: Vec<f64>,
    n: usize,
}

impl Variational<'_> {
    /// `f` at `x + e S_p`, `theta + e e_p`.
    fn moved(&self, t: f64, full: &[f64], p: usize, e: f64, rate: &mut [f64]) {
        let n = self.n;
        let x: Vec<f64> = (0..n)
            .map(|i| full[i] + e * full[n * (p + 1) + i])
            .collect();
        self.with(p, e, || self.model.rhs(t, &x, rate));
    }

    /// Runs `f` with one parameter moved.
    fn with<T>(&self, p: usize, e: f64, f: impl FnOnce() -> T) -> T {
        let mut theta = self.theta.clone();
        theta[p] += e * self.range[p];
        set_theta(self.model.net, &mut self.model.work.borrow_mut(), &theta);
        let result = f();
        set_theta(
            self.model.net,
            &mut self.model.work.borrow_mut(),
            &self.theta,
        );
        result
    }
}

impl System for Variational<'_> {
    fn dimension(&self) -> usize {
        self.n * (1 + self.theta.len())
    }

    fn rhs(&self, t: f64, full: &[f64], rate: &mut [f64]) {
        let n = self.n;
        self.model.rhs(t, &full[..n], &mut rate[..n]);
        let mut above = vec![0.0; n];
        let mut below = vec![0.0; n];
        for p in 0..self.theta.len() {
            self.moved(t, full, p, DIRECTION, &mut above);
            self.moved(t, full, p, -DIRECTION, &mut below);
            for i in 0..n {
                rate[n * (p + 1) + i] = (above[i] - below[i]) / (2.0 * DIRECTION);
            }
        }
    }

    fn begin_segment(&mut self, start: f64, end: f64, full: &[f64]) {
        self.model.begin_segment(start, end, &full[..self.n]);
    }

    fn guards(&self) -> usize {
        self.model.guards()
    }

    fn guard(&self, index: usize, t: f64, full: &[f64]) -> f64 {
        self.model.guard(index, t, &full[..self.n])
    }

    /// At a switch the derivatives jump by `(f₋ − f₊) dτ/dθ` with `τ` the time of the switch (Rozenvasser, E. N., Autom.
    /// Remote Control 28, 1967).
    fn cross(&mut self, index: usize, t: f64, full: &mut [f64]) {
        let n = self.n;
        let net = self.model.net;
        let state = match index.checked_sub(net.tanks.len()) {
            None => index,
            Some(valve) => match net.chains[net.valves[valve]].flow {
                Flow::State(state) => state,
                _ => return,
            },
        };
        let mut before = vec![0.0; n];
        self.model.rhs(t, &full[..n], &mut before);
        let mut x = full[..n].to_vec();
        self.model.cross(index, t, &mut x);
        let mut after = vec![0.0; n];
        self.model.rhs(t, &x, &mut after);
        // Where it stops it is held at a bound that may move with a parameter; where it starts again nothing jumps.
        let stops = after[state] == 0.0 && before[state] != 0.0;
        if stops {
            let bound = |model: &Model<'_>| {
                let work = model.work.borrow();
                if index < net.tanks.len() && x[state] > 0.0 {
                    work.brim(net, index, &x)
                } else {
                    0.0
                }
            };
            for p in 0..self.theta.len() {
                let bound_slope = (self.with(p, DIRECTION, || bound(&self.model))
                    - self.with(p, -DIRECTION, || bound(&self.model)))
                    / (2.0 * DIRECTION);
                let later = -(full[n * (p + 1) + state] - bound_slope) / before[state];
                for i in 0..n {
                    full[n * (p + 1) + i] += (before[i] - after[i]) * later;
                }
            }
        }
        full[..n].copy_from_slice(&x);
    }
}

/// Sensitivities by the variational equations: `n (1 + p)` states in one run. They are the reference for
/// [`sensitivities`], which is faster for stiff systems.
///
/// # Errors
/// As [`Assembly::simulate`].
///
/// # Source
/// Hairer, E., Nørsett, S. P. and Wanner, G., *Solving Ordinary Differential Equations I* (1993), I.14.
pub fn sensitivities_variational(
    assembly: &Assembly,
    theta: &[f64],
    window: &Window,
    number: usize,
    options: &SimulationOptions,
) -> Result<Sensitivities, AssemblyError> {
    assembly.check_theta(theta)?;
    let mut found = frame(assembly, window);
    let simulator = Simulator::new(assembly, window, number, options)?;
    let (n, p) = (assembly.net.states.len(), theta.len());
    let start_at = |theta: &[f64]| -> Result<Vec<f64>, AssemblyError> {
        set_theta(&assembly.net, &mut simulator.model.work.borrow_mut(), theta);
        simulator.initial(theta)
    };
    let mut full = start_at(theta)?;
    for k in 0..p {
        let h = DIRECTION * found.range[k];
        let mut moved = theta.to_vec();
        moved[k] = theta[k] + h;
        let above = start_at(&moved)?;
        moved[k] = theta[k] - h;
        let below = start_at(&moved)?;
        full.extend(
            above
                .iter()
                .zip(&below)
                .map(|(a, b)| (a - b) / (2.0 * DIRECTION)),
        );
    }
    start_at(theta)?;
    let mut simulator = simulator;
    simulator.model.command();
    let absolute = simulator.absolute.repeat(1 + p);
    let breaks = simulator.breaks.clone();
    let mut system = Variational {
        model: simulator.model,
        theta: theta.to_vec(),
        range: found.range.clone(),
        n,
    };
    let mut states = full.clone();
    let samples = window.time.len();
    if n > 0 {
        let plan = Plan {
            start: window.time[0],
            end: window.time[samples - 1],
            outputs: &window.time,
            breaks: &breaks,
        };
        let settings = integrate::Options {
            tolerances: Tolerances {
                relative: options.relative,
                absolute,
            },
            max_steps: options.max_steps,
            ..integrate::Options::new(0.0, Vec::new())
        };
        let run = integrate::integrate(options.method, &mut system, &full, &plan, &settings)?;
        if run.status != Status::Finished {
            found.status = RunStatus::Stopped(run.status);
        }
        states = run.states;
    }
    for k in 0..p {
        let at = |e: f64| {
            let mut outputs = vec![vec![f64::NAN; samples]; found.outputs.len()];
            system.with(k, e, || {
                for i in 0..samples {
                    let full: &[f64] = if n == 0 {
                        &[]
                    } else {
                        states
                            .get(i * n * (1 + p)..(i + 1) * n * (1 + p))
                            .unwrap_or(&[])
                    };
                    if full.len() < n {
                        break;
                    }
                    let x: Vec<f64> = (0..n)
                        .map(|j| full[j] + e * full[n * (k + 1) + j])
                        .collect();
                    system.model.feed_sample(i);
                    system.model.read(&x, i, &mut outputs);
                }
                system.model.instruments(&window.time, &mut outputs);
            });
            outputs
        };
        let (above, below) = (at(DIRECTION), at(-DIRECTION));
        let h = 2.0 * DIRECTION * found.range[k];
        let difference =
            |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().zip(b).map(|(a, b)| (a - b) / h).collect();
        found
            .values
            .push(above.iter().zip(&below).map(difference).collect());
    }
    if found.status == RunStatus::Finished && system.model.work.borrow().failed {
        found.status = RunStatus::NotSolved;
    }
    Ok(found)
}

impl Sensitivities {
    /// Root mean square of each parameter's scaled sensitivity (`∂y/∂θ` times range over size), by parameter: what matters
    /// most (δ_msqr of Brun, Reichert and Künsch 2001).
    #[must_use]
    pub fn importance(&self) -> Vec<f64> {
        self.columns()
            .iter()
            .map(|c| crate::fit::root_mean_square(c))
            .collect()
    }

    /// Scaled sensitivities of each parameter in one row, all outputs and samples; not finite ones left out in all.
    pub(crate) fn columns(&self) -> Vec<Vec<f64>> {
        let scaled = |p: usize| -> Vec<f64> {
            let rows = self.values[p].iter().zip(&self.size);
            rows.flat_map(|(column, size)| {
                column
                    .iter()
                    .map(|v| v * self.range[p] / size)
                    .collect::<Vec<_>>()
            })
            .collect()
        };
        let all: Vec<Vec<f64>> = (0..self.values.len()).map(scaled).collect();
        let length = all.first().map_or(0, Vec::len);
        let keep: Vec<bool> = (0..length)
            .map(|i| all.iter().all(|c| c[i].is_finite()))
            .collect();
        all.into_iter()
            .map(|c| {
                c.into_iter()
                    .zip(&keep)
                    .filter(|(_, k)| **k)
                    .map(|(v, _)| v)
                    .collect()
            })
            .collect()
    }
}
