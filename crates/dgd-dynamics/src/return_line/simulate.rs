//! The simulations of chapter 4.

use super::model::{COUPLED, FLOW, Line, RISER};
use super::power::Following;
use super::{ATMOSPHERE_PA, GRAVITY_M_S2, ReturnLine};
use crate::DynamicsError;
use crate::inputs::{Cursor, Signal, merged_kinks};
use crate::integrate::{
    IntegrateError, Method, Options, Plan, Statistics, Status, Tolerances, Trajectory, integrate,
};

/// Settings of a simulation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SimulationOptions {
    /// Integration method; [`Method::Rodas3`] by default, as inputs bend at every sample.
    pub method: Method,
    /// Relative tolerance of a step; 1e-4 by default.
    pub relative: f64,
    /// Absolute tolerance of the level, m; 1e-4 by default.
    pub level_tolerance_m: f64,
    /// Absolute tolerance of the flow, m³/s; 1e-5 by default.
    pub flow_tolerance_m3_s: f64,
    /// Steps after which to give up, beyond one for each kink of an input; 10 million by default.
    pub max_steps: usize,
}

impl Default for SimulationOptions {
    fn default() -> Self {
        Self {
            method: Method::Rodas3,
            relative: 1e-4,
            level_tolerance_m: 1e-4,
            flow_tolerance_m3_s: 1e-5,
            max_steps: 10_000_000,
        }
    }
}

/// The two states. As a start, the level is within the riser, 0 to the depth of the pump inlet, and the flow, with a non-return valve, at
/// least 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineState {
    /// Riser level h_r, m below the riser's top.
    pub level_m: f64,
    /// Flow through the pump, m³/s.
    pub flow_m3_s: f64,
}

/// When the model first left its usual range; `None` if it never did.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RiserBounds {
    /// The riser was full (`h_r = 0`): the surplus overflows and the level stays until outflow
    /// exceeds inflow.
    pub full_s: Option<f64>,
    /// The riser was empty to the pump inlet (`h_r = h_in`): the pump would draw air, which the
    /// model does not hold; the level stays until inflow exceeds outflow.
    pub empty_s: Option<f64>,
    /// The non-return valve shut.
    pub valve_shut_s: Option<f64>,
}

/// A simulated recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulation {
    /// Times written, s: all the requested ones if `status` is [`Status::Finished`].
    pub time_s: Vec<f64>,
    /// Riser level h_r, m, same shape (the input, if the flow was simulated alone).
    pub level_m: Vec<f64>,
    /// Pump flow, m³/s, same shape (the input, if the riser was simulated alone).
    pub flow_m3_s: Vec<f64>,
    /// First times at which a bound was met.
    pub bounds: RiserBounds,
    /// How it ended.
    pub status: Status,
    /// What it cost.
    pub statistics: Statistics,
}

/// Simulates level and flow together (section 4.3, Eq. 3.45-3.46).
///
/// - `start`: states at `output_s[0]`.
/// - `inflow_m3_s`: flow into the riser `q_p + q_bp + q_tf`, m³/s.
/// - `speed_pct`: pump speed, %, at least 0.
/// - `output_s`: ascending times to write, s; the first is the start, the last the end.
///
/// # Errors
/// [`DynamicsError`] on parameters or a start out of range, a negative speed, an input that does not cover
/// the span, times that do not ascend.
///
/// ```
/// use dgd_dynamics::inputs::{Interpolation, Signal};
/// use dgd_dynamics::return_line::*;
///
/// let line = ReturnLine {
///     density_kg_m3: 1080.0, riser_area_m2: 0.1704, line_area_m2: 0.01824,
///     inlet_depth_m: 350.3, outlet_depth_m: 350.3,
///     friction: Friction { d_pa_s2_m6: 1.2e8, ..Friction::default() },
///     pump: PumpHead { c0: 0.0688, c1: 0.0, c2: 2.4e3, n0: 1.95, n2: 1.62 },
///     non_return_valve: true, b_is_offset: false,
/// };
/// let t = [0.0, 600.0];
/// let inflow = Signal::new("inflow", &t, &[0.05, 0.05], Interpolation::Linear)?;
/// let speed = Signal::new("speed", &t, &[60.0, 60.0], Interpolation::Linear)?;
/// let start = LineState { level_m: 140.0, flow_m3_s: 0.05 };
/// let run = simulate_coupled(&line, start, &inflow, &speed, &t, &SimulationOptions::default())?;
/// assert_eq!(run.level_m.len(), 2);
/// # Ok::<(), dgd_dynamics::DynamicsError>(())
/// ```
pub fn simulate_coupled(
    line: &ReturnLine,
    start: LineState,
    inflow_m3_s: &Signal<'_>,
    speed_pct: &Signal<'_>,
    output_s: &[f64],
    options: &SimulationOptions,
) -> Result<Simulation, DynamicsError> {
    check_speed(speed_pct.name(), speed_pct.values())?;
    let mut system = Line::<COUPLED>::new(line, *inflow_m3_s, *speed_pct);
    let x = [start.level_m, start.flow_m3_s];
    let absolute = vec![options.level_tolerance_m, options.flow_tolerance_m3_s];
    let inputs = [inflow_m3_s, speed_pct];
    let run = simulate(line, &mut system, &x, absolute, &inputs, output_s, options)?;
    Ok(Simulation {
        level_m: run.column(0),
        flow_m3_s: run.column(1),
        ..finish(&system, run)
    })
}

/// Simulates the riser level with the pump flow given (section 4.1, Eq. 3.45).
///
/// - `start_level_m`: level at `output_s[0]`, m.
/// - `flow_m3_s`: pump flow, m³/s; the others as in [`simulate_coupled`].
///
/// # Errors
/// As [`simulate_coupled`].
pub fn simulate_riser_alone(
    line: &ReturnLine,
    start_level_m: f64,
    inflow_m3_s: &Signal<'_>,
    flow_m3_s: &Signal<'_>,
    output_s: &[f64],
    options: &SimulationOptions,
) -> Result<Simulation, DynamicsError> {
    let mut system = Line::<RISER>::new(line, *inflow_m3_s, *flow_m3_s);
    let inputs = [inflow_m3_s, flow_m3_s];
    let absolute = vec![options.level_tolerance_m];
    let run = simulate(
        line,
        &mut system,
        &[start_level_m],
        absolute,
        &inputs,
        output_s,
        options,
    )?;
    let flow = sample(flow_m3_s, &run.times);
    Ok(Simulation {
        level_m: run.states.clone(),
        flow_m3_s: flow,
        ..finish(&system, run)
    })
}

/// Simulates the pump flow with the riser level given (section 4.2, Eq. 3.46).
///
/// - `start_flow_m3_s`: flow at `output_s[0]`, m³/s.
/// - `level_m`: riser level, m; the others as in [`simulate_coupled`].
///
/// # Errors
/// As [`simulate_coupled`].
pub fn simulate_flow_alone(
    line: &ReturnLine,
    start_flow_m3_s: f64,
    level_m: &Signal<'_>,
    speed_pct: &Signal<'_>,
    output_s: &[f64],
    options: &SimulationOptions,
) -> Result<Simulation, DynamicsError> {
    check_speed(speed_pct.name(), speed_pct.values())?;
    let mut system = Line::<FLOW>::new(line, *level_m, *speed_pct);
    let inputs = [level_m, speed_pct];
    let absolute = vec![options.flow_tolerance_m3_s];
    let run = simulate(
        line,
        &mut system,
        &[start_flow_m3_s],
        absolute,
        &inputs,
        output_s,
        options,
    )?;
    let level = sample(level_m, &run.times);
    Ok(Simulation {
        level_m: level,
        flow_m3_s: run.states.clone(),
        ..finish(&system, run)
    })
}

fn simulate<const KIND: u8>(
    line: &ReturnLine,
    system: &mut Line<'_, KIND>,
    initial: &[f64],
    absolute: Vec<f64>,
    inputs: &[&Signal<'_>; 2],
    output_s: &[f64],
    options: &SimulationOptions,
) -> Result<Trajectory, DynamicsError> {
    line.check()?;
    check_start::<KIND>(line, initial)?;
    check_times(output_s)?;
    let (&start, &end) = output_s
        .first()
        .zip(output_s.last())
        .ok_or(DynamicsError::Length {
            name: "output_s",
            expected: 1,
            found: 0,
        })?;
    for signal in inputs {
        let (first, last) = (
            signal.time_s()[0],
            signal.time_s()[signal.time_s().len() - 1],
        );
        if !(first <= start && end <= last) {
            let name = signal.name().to_owned();
            return Err(DynamicsError::Span {
                name,
                first,
                last,
                start,
                end,
            });
        }
    }
    let breaks = merged_kinks(inputs, start, end);
    let plan = Plan {
        start,
        end,
        outputs: output_s,
        breaks: &breaks,
    };
    let settings = settings(absolute, options);
    integrate(options.method, system, initial, &plan, &settings).map_err(refused::<KIND>)
}

/// Names of start and tolerance of each state.
fn names<const KIND: u8>() -> &'static [[&'static str; 2]] {
    match KIND {
        RISER => &[["start_level_m", "level_tolerance_m"]],
        FLOW => &[["start_flow_m3_s", "flow_tolerance_m3_s"]],
        _ => &[
            ["start.level_m", "level_tolerance_m"],
            ["start.flow_m3_s", "flow_tolerance_m3_s"],
        ],
    }
}

/// Refuses a start outside the riser or against the valve, which the run could not write; one that is no number is the integrator's affair.
pub(super) fn check_start<const KIND: u8>(
    line: &ReturnLine,
    initial: &[f64],
) -> Result<(), DynamicsError> {
    let refuse = |state: usize, expected| {
        Err(DynamicsError::Parameter {
            name: names::<KIND>()[state][0],
            found: initial[state],
            expected,
        })
    };
    let level = if KIND == FLOW { 0.0 } else { initial[0] };
    if level < 0.0 || level > line.inlet_depth_m {
        return refuse(0, "a level from 0 to the depth of the pump inlet");
    }
    let last = initial.len() - 1;
    if KIND != RISER && line.non_return_valve && initial[last] < 0.0 {
        return refuse(last, "a flow of at least 0, with the non-return valve");
    }
    Ok(())
}

/// Refuses times to write that do not ascend, before an end of them is held against anything else.
fn check_times(output_s: &[f64]) -> Result<(), DynamicsError> {
    let mut before = f64::NEG_INFINITY;
    for (index, &found) in output_s.iter().enumerate() {
        if !(found >= before && found.is_finite()) {
            return Err(DynamicsError::Sample {
                name: "output_s".to_owned(),
                index,
                found,
                expected: "ascending finite times",
            });
        }
        before = found;
    }
    Ok(())
}

/// What the integrator refuses, by the names it has here.
pub(super) fn refused<const KIND: u8>(error: IntegrateError) -> DynamicsError {
    let names = names::<KIND>();
    let IntegrateError::Value {
        name,
        index,
        found,
        expected,
    } = error
    else {
        return error.into();
    };
    let column = ["initial", "absolute"].iter().position(|n| *n == name);
    match (names.get(index), column) {
        (Some(row), Some(column)) => DynamicsError::Parameter {
            name: row[column],
            found,
            expected,
        },
        _ => error.into(),
    }
}

pub(super) fn settings(absolute: Vec<f64>, options: &SimulationOptions) -> Options {
    Options {
        tolerances: Tolerances {
            relative: options.relative,
            absolute,
        },
        max_steps: options.max_steps,
        ..Options::new(0.0, Vec::new())
    }
}

fn finish<const KIND: u8>(system: &Line<'_, KIND>, run: Trajectory) -> Simulation {
    Simulation {
        time_s: run.times,
        level_m: Vec::new(),
        flow_m3_s: Vec::new(),
        bounds: RiserBounds {
            full_s: system.first_full_s,
            empty_s: system.first_empty_s,
            valve_shut_s: system.first_shut_s,
        },
        status: run.status,
        statistics: run.statistics,
    }
}

pub(super) fn sample(signal: &Signal<'_>, times: &[f64]) -> Vec<f64> {
    let mut cursor = Cursor::default();
    times
        .iter()
        .map(|&t| signal.piece(&mut cursor, t, t).value)
        .collect()
}

/// A pump that turns backwards has no head curve, and `w^n0` no value.
pub(super) fn check_speed(name: &str, speed_pct: &[f64]) -> Result<(), DynamicsError> {
    match speed_pct.iter().position(|w| !(*w >= 0.0 && w.is_finite())) {
        None => Ok(()),
        Some(index) => Err(DynamicsError::Sample {
            name: name.to_owned(),
            index,
            found: speed_pct[index],
            expected: "a finite speed of at least 0 %",
        }),
    }
}

/// Pressures and head that belong to simulated states.
#[derive(Debug, Clone, PartialEq)]
pub struct LineOutputs {
    /// Pressure at the pump inlet, Pa (Eq. 2.49).
    pub inlet_pa: Vec<f64>,
    /// Pressure at the pump outlet, Pa (Eq. 3.13 solved for it).
    pub outlet_pa: Vec<f64>,
    /// Head of the pump by its curve, m of mud.
    pub head_m: Vec<f64>,
}

/// Works out pressures and head at given states.
///
/// - `level_m`, `flow_m3_s`, `speed_pct`: shape `(n,)` each.
/// - `with_inertia`: add the pressure that accelerates the discharge line,
///   `ρ·h_out/A_MRL·dq/dt`, to the outlet pressure (zero while the valve is shut).
///
/// # Errors
/// [`DynamicsError::Parameter`], [`DynamicsError::Length`], and [`DynamicsError::Sample`] on a
/// negative speed.
pub fn derive_outputs(
    line: &ReturnLine,
    level_m: &[f64],
    flow_m3_s: &[f64],
    speed_pct: &[f64],
    with_inertia: bool,
) -> Result<LineOutputs, DynamicsError> {
    OutputParts::new(line, with_inertia)?.add(level_m, flow_m3_s, speed_pct)
}

/// [`derive_outputs`] of states that come in parts.
pub struct OutputParts {
    line: ReturnLine,
    with_inertia: bool,
    speed_power: Following,
    flow_power: Following,
}

impl std::fmt::Debug for OutputParts {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("OutputParts").finish_non_exhaustive()
    }
}

impl OutputParts {
    /// For a line; `with_inertia` as in [`derive_outputs`].
    ///
    /// # Errors
    /// [`DynamicsError::Parameter`].
    pub fn new(line: &ReturnLine, with_inertia: bool) -> Result<Self, DynamicsError> {
        line.check()?;
        Ok(Self {
            line: *line,
            with_inertia,
            speed_power: Following::new(line.pump.n0),
            flow_power: Following::new(line.pump.n2),
        })
    }

    /// Works out pressures and head of the next states, as [`derive_outputs`].
    ///
    /// # Errors
    /// [`DynamicsError::Length`], [`DynamicsError::Sample`].
    pub fn add(
        &mut self,
        level_m: &[f64],
        flow_m3_s: &[f64],
        speed_pct: &[f64],
    ) -> Result<LineOutputs, DynamicsError> {
        let Self {
            line,
            with_inertia,
            speed_power,
            flow_power,
        } = self;
        let n = level_m.len();
        for (name, found) in [
            ("flow_m3_s", flow_m3_s.len()),
            ("speed_pct", speed_pct.len()),
        ] {
            if found != n {
                return Err(DynamicsError::Length {
                    name,
                    expected: n,
                    found,
                });
            }
        }
        check_speed("speed_pct", speed_pct)?;
        let mut out = LineOutputs {
            inlet_pa: Vec::with_capacity(n),
            outlet_pa: Vec::with_capacity(n),
            head_m: Vec::with_capacity(n),
        };
        let discharge = line.density_kg_m3 * line.outlet_depth_m / line.line_area_m2;
        let static_pa = ATMOSPHERE_PA + line.density_kg_m3 * GRAVITY_M_S2 * line.outlet_depth_m;
        for ((&h, &q), &w) in level_m.iter().zip(flow_m3_s).zip(speed_pct) {
            let mut outlet = static_pa + line.friction.loss_pa(q);
            let powers = (speed_power.at(w), flow_power.at(q.abs()));
            let head = line.pump.head_of(powers, w, q);
            if *with_inertia {
                let drive = line.drive_under(h, q, head);
                if !(line.non_return_valve && q <= 0.0 && drive < 0.0) {
                    outlet += discharge * drive / line.inertia_kg_m4(h);
                }
            }
            out.inlet_pa.push(line.inlet_pressure_pa(h));
            out.outlet_pa.push(outlet);
            out.head_m.push(head);
        }
        Ok(out)
    }
}

/// What a flow meter shows that reports `delay_s` late: `q(t − delay)`, linear between samples,
/// the first value before the first sample.
///
/// - `time_s`, `flow_m3_s`: shape `(n,)`; `time_s` strictly ascending.
///
/// # Errors
/// [`DynamicsError::Input`] on unusable series, [`DynamicsError::Parameter`] on a non-finite delay.
pub fn measured_flow(
    time_s: &[f64],
    flow_m3_s: &[f64],
    delay_s: f64,
) -> Result<Vec<f64>, DynamicsError> {
    check_delay(delay_s)?;
    late(time_s, flow_m3_s, time_s, delay_s)
}

fn check_delay(delay_s: f64) -> Result<(), DynamicsError> {
    if delay_s.is_finite() {
        return Ok(());
    }
    Err(DynamicsError::Parameter {
        name: "delay_s",
        found: delay_s,
        expected: "a finite number",
    })
}

fn late(
    time_s: &[f64],
    flow_m3_s: &[f64],
    at_s: &[f64],
    delay_s: f64,
) -> Result<Vec<f64>, DynamicsError> {
    let flow = Signal::new("flow_m3_s", time_s, flow_m3_s, Default::default())?;
    let mut cursor = Cursor::default();
    Ok(at_s
        .iter()
        .map(|t| flow.piece(&mut cursor, t - delay_s, t - delay_s).value)
        .collect())
}

/// [`measured_flow`] of a flow that comes in parts; holds as much of it as the delay is long.
///
/// A negative delay would ask for what has not come: there it shows the latest flow, while [`measured_flow`] knows better.
#[derive(Debug, Clone)]
pub struct LateParts {
    delay_s: f64,
    time_s: Vec<f64>,
    flow_m3_s: Vec<f64>,
}

impl LateParts {
    /// For a meter that is so late, s.
    ///
    /// # Errors
    /// [`DynamicsError::Parameter`] on a delay that is not finite.
    pub fn new(delay_s: f64) -> Result<Self, DynamicsError> {
        check_delay(delay_s)?;
        Ok(Self {
            delay_s,
            time_s: Vec::new(),
            flow_m3_s: Vec::new(),
        })
    }

    /// What the meter shows at the next samples.
    ///
    /// # Errors
    /// [`DynamicsError::Input`] on unusable series.
    pub fn add(&mut self, time_s: &[f64], flow_m3_s: &[f64]) -> Result<Vec<f64>, DynamicsError> {
        let Some(last) = time_s.last() else {
            return Ok(Vec::new());
        };
        // The next sample is later, and looks back no further than the one before where this one does.
        let gone = |time: &[f64]| {
            let passed = time.partition_point(|t| *t <= last - self.delay_s);
            passed.saturating_sub(1)
        };
        if self.time_s.is_empty() {
            let shown = late(time_s, flow_m3_s, time_s, self.delay_s)?;
            let gone = gone(time_s);
            self.time_s = time_s[gone..].to_vec();
            self.flow_m3_s = flow_m3_s[gone..].to_vec();
            return Ok(shown);
        }
        let held = self.time_s.len();
        self.time_s.extend_from_slice(time_s);
        self.flow_m3_s.extend_from_slice(flow_m3_s);
        let shown = match late(&self.time_s, &self.flow_m3_s, time_s, self.delay_s) {
            Ok(shown) => shown,
            Err(error) => {
                // A part that is refused leaves nothing behind.
                self.time_s.truncate(held);
                self.flow_m3_s.truncate(held);
                return Err(error);
            }
        };
        let gone = gone(&self.time_s);
        self.time_s.drain(..gone);
        self.flow_m3_s.drain(..gone);
        Ok(shown)
    }
}
