//! The simulations of chapter 4 over a window of a recording.

use crate::{Pair, Replay, fill_gaps};
use dgd_dynamics::DynamicsError;
use dgd_dynamics::inputs::{Interpolation, Signal};
use dgd_dynamics::integrate::{Statistics, Status};
use dgd_dynamics::return_line::{
    GRAVITY_M_S2, LineState, ReturnLine, RiserBounds, Simulation, SimulationOptions, SteadyStatus,
    derive_outputs, measured_flow, simulate_coupled, simulate_flow_alone, simulate_riser_alone,
    steady_state,
};
use dgd_recording::Recording;
use std::ops::Range;

/// Which simulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Kind {
    /// Level and flow together (section 4.3).
    #[default]
    Coupled,
    /// The level, driven by the measured flow (section 4.1).
    Riser,
    /// The flow, driven by the measured level (section 4.2).
    Flow,
    /// The flow at which all pressures balance at each sample (Eq. 4.2).
    Steady,
}

/// Where the states start; what is `None` is taken from the recording at the
/// window's first sample that has it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Start {
    /// Riser level, m.
    pub level_m: Option<f64>,
    /// Flow through the pump, m³/s.
    pub flow_m3_s: Option<f64>,
}

/// Settings of a replay.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ReplayOptions {
    /// Which simulation.
    pub kind: Kind,
    /// First and last second of the window, clipped to the recording; all of it if `None`.
    pub window_s: Option<(f64, f64)>,
    /// Initial states.
    pub start: Start,
    /// How late the flow meter is, s (Eq. 3.21).
    pub delay_s: f64,
    /// Solver and tolerances.
    pub solver: SimulationOptions,
}

/// Why there is nothing to simulate.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ReplayError {
    /// The window holds no samples.
    #[error(
        "the window {from_s} to {to_s} s holds {samples} samples, expected at least 2; the recording spans {start_s} to {end_s} s"
    )]
    Window {
        /// Asked for.
        from_s: f64,
        /// Asked for.
        to_s: f64,
        /// Found in it.
        samples: usize,
        /// First second of the recording.
        start_s: f64,
        /// Last second of the recording.
        end_s: f64,
    },
    /// An input has no value in the window.
    #[error("`{name}` has no trusted value between {from_s} and {to_s} s; choose another window")]
    NoInput {
        /// Which.
        name: &'static str,
        /// First second of the window.
        from_s: f64,
        /// Last second of the window.
        to_s: f64,
    },
    /// A series is not as long as the clock.
    #[error("`{channel}` has {found} samples, expected {expected} as the time has")]
    Length {
        /// The odd series.
        channel: String,
        /// Length of the time.
        expected: usize,
        /// Its length.
        found: usize,
    },
    /// The model or its inputs were refused.
    #[error(transparent)]
    Dynamics(#[from] DynamicsError),
}

/// The window's measured series, and the inputs made of them.
struct Window {
    time_s: Vec<f64>,
    level_m: Vec<f64>,
    pump_flow_m3_s: Vec<f64>,
    return_flow_m3_s: Vec<f64>,
    inlet_pa: Vec<f64>,
    outlet_pa: Vec<f64>,
    inflow_m3_s: Vec<f64>,
    speed_pct: Vec<f64>,
    filled: usize,
}

impl Window {
    /// The work is proportional to the window, but for finding it.
    fn cut(
        line: &ReturnLine,
        recording: &Recording,
        options: &ReplayOptions,
    ) -> Result<Self, ReplayError> {
        let expected = recording.len();
        if let Some((channel, values)) = recording
            .series()
            .into_iter()
            .find(|(_, values)| values.len() != expected)
        {
            return Err(ReplayError::Length {
                channel: channel.to_string(),
                expected,
                found: values.len(),
            });
        }
        let time = &recording.time_s;
        let (start_s, end_s) = (
            time.first().copied().unwrap_or(0.0),
            time.last().copied().unwrap_or(0.0),
        );
        let (from_s, to_s) = options.window_s.unwrap_or((start_s, end_s));
        // Negated, so that a window from NaN is empty.
        let first = time.partition_point(|t| !(*t >= from_s));
        let last = time.partition_point(|t| *t <= to_s);
        let samples = last.saturating_sub(first);
        if samples < 2 {
            return Err(ReplayError::Window {
                from_s,
                to_s,
                samples,
                start_s,
                end_s,
            });
        }
        let steps = (options.delay_s / step_s(time)).round();
        let pump_flow_m3_s = (first..last)
            .map(|i| ahead(&recording.return_flow_m3_s, i, steps))
            .collect();
        let mut cut = cut(recording, first..last);
        // One transmitter is its own mean, and needs no copy.
        let inlet_pa = match cut.pump_inlet_pressure_pa.len() {
            1 => cut.pump_inlet_pressure_pa.remove(0),
            _ => cut.mean_inlet_pressure_pa(),
        };
        let outlet_pa = match cut.pump_outlet_pressure_pa.len() {
            1 => cut.pump_outlet_pressure_pa.remove(0),
            _ => cut.mean_outlet_pressure_pa(),
        };
        let mut window = Self {
            level_m: inlet_pa
                .iter()
                .map(|p| line.level_from_inlet_pressure(*p))
                .collect(),
            pump_flow_m3_s,
            outlet_pa,
            inlet_pa,
            inflow_m3_s: Vec::new(),
            speed_pct: Vec::new(),
            filled: 0,
            return_flow_m3_s: cut.return_flow_m3_s,
            time_s: cut.time_s,
        };
        // What a simulation does not read may be missing, and is left as it is.
        let (reads_inflow, reads_speed) = match options.kind {
            Kind::Coupled => (true, true),
            Kind::Riser => (true, false),
            Kind::Flow | Kind::Steady => (false, true),
        };
        let mut input = |name, values, read| {
            if read {
                window.filled(name, values)
            } else {
                Ok(values)
            }
        };
        // The sum is filled flow by flow: a gap in one must not take the others with it.
        let mut inflow_m3_s = input("mud_pump_flow", cut.mud_pump_flow_m3_s, reads_inflow)?;
        for (name, flow) in [
            ("booster_flow", cut.booster_flow_m3_s),
            ("topfill_flow", cut.topfill_flow_m3_s),
        ] {
            let flow = input(name, flow, reads_inflow)?;
            inflow_m3_s
                .iter_mut()
                .zip(flow)
                .for_each(|(sum, q)| *sum += q);
        }
        let mut speed_pct = input("pump_speed", cut.pump_speed_pct, reads_speed)?;
        speed_pct
            .iter_mut()
            .filter(|w| **w < 0.0)
            .for_each(|w| *w = 0.0);
        window.inflow_m3_s = inflow_m3_s;
        window.speed_pct = speed_pct;
        Ok(window)
    }

    /// A series as an input, without holes.
    fn filled(
        &mut self,
        name: &'static str,
        mut values: Vec<f64>,
    ) -> Result<Vec<f64>, ReplayError> {
        match fill_gaps(&mut values) {
            Some(filled) => {
                self.filled += filled;
                Ok(values)
            }
            None => Err(self.no_input(name)),
        }
    }

    fn first_of(&self, name: &'static str, values: &[f64]) -> Result<f64, ReplayError> {
        let first = values.iter().copied().find(|v| v.is_finite());
        first.ok_or_else(|| self.no_input(name))
    }

    fn no_input(&self, name: &'static str) -> ReplayError {
        ReplayError::NoInput {
            name,
            from_s: self.time_s[0],
            to_s: self.time_s[self.time_s.len() - 1],
        }
    }
}

/// The samples of a range; the riser pressure, which no simulation reads, is left out.
fn cut(recording: &Recording, range: Range<usize>) -> Recording {
    let one = |values: &[f64]| values[range.clone()].to_vec();
    let side = |series: &[Vec<f64>]| series.iter().map(|values| one(values)).collect();
    Recording {
        time_s: one(&recording.time_s),
        mud_pump_flow_m3_s: one(&recording.mud_pump_flow_m3_s),
        booster_flow_m3_s: one(&recording.booster_flow_m3_s),
        topfill_flow_m3_s: one(&recording.topfill_flow_m3_s),
        return_flow_m3_s: one(&recording.return_flow_m3_s),
        pump_inlet_pressure_pa: side(&recording.pump_inlet_pressure_pa),
        pump_outlet_pressure_pa: side(&recording.pump_outlet_pressure_pa),
        riser_pressure_pa: None,
        pump_speed_pct: one(&recording.pump_speed_pct),
    }
}

fn step_s(time_s: &[f64]) -> f64 {
    (time_s[time_s.len() - 1] - time_s[0]) / (time_s.len() - 1) as f64
}

/// The meter's value `steps` samples after `index` (Eq. 3.22).
fn ahead(flow: &[f64], index: usize, steps: f64) -> f64 {
    let at = index as f64 + steps;
    if !(0.0..flow.len() as f64).contains(&at) {
        return f64::NAN;
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "checked against the length"
    )]
    let at = at as usize;
    flow[at]
}

/// Runs the model over a window of a recording that is on an even clock.
///
/// # Errors
/// [`ReplayError`] if the window or an input is empty, a series is not as long as the clock, or
/// the model's parameters are refused.
///
/// # Source
/// Chapter 4 of the thesis; riser alone Eq. 3.45, flow alone Eq. 3.46, steady Eq. 4.2.
pub fn replay(
    line: &ReturnLine,
    recording: &Recording,
    options: &ReplayOptions,
) -> Result<Replay, ReplayError> {
    let mut window = Window::cut(line, recording, options)?;
    let measured_level = std::mem::take(&mut window.level_m);
    let measured_flow_at_pump = std::mem::take(&mut window.pump_flow_m3_s);
    let start_level = |w: &Window| {
        options
            .start
            .level_m
            .map_or_else(|| w.first_of("pump_inlet_pressure", &measured_level), Ok)
    };
    let start_flow = |w: &Window| {
        options
            .start
            .flow_m3_s
            .map_or_else(|| w.first_of("return_flow", &measured_flow_at_pump), Ok)
    };
    let level_input = match options.kind {
        Kind::Flow | Kind::Steady => {
            window.filled("pump_inlet_pressure", measured_level.clone())?
        }
        Kind::Coupled | Kind::Riser => Vec::new(),
    };
    let flow_input = match options.kind {
        Kind::Riser => window.filled("return_flow", measured_flow_at_pump.clone())?,
        _ => Vec::new(),
    };
    let time = &window.time_s;
    let signal = |name, values| {
        Signal::new(name, time, values, Interpolation::Linear).map_err(DynamicsError::from)
    };
    let inflow = || signal("inflow", &window.inflow_m3_s);
    let speed = || signal("pump_speed", &window.speed_pct);
    let mut unsolved = 0;
    let simulated = match options.kind {
        Kind::Coupled => {
            let start = LineState {
                level_m: start_level(&window)?,
                flow_m3_s: start_flow(&window)?,
            };
            simulate_coupled(line, start, &inflow()?, &speed()?, time, &options.solver)?
        }
        Kind::Riser => {
            let flow = signal("return_flow", &flow_input)?;
            simulate_riser_alone(
                line,
                start_level(&window)?,
                &inflow()?,
                &flow,
                time,
                &options.solver,
            )?
        }
        Kind::Flow => {
            let level = signal("riser_level", &level_input)?;
            simulate_flow_alone(
                line,
                start_flow(&window)?,
                &level,
                &speed()?,
                time,
                &options.solver,
            )?
        }
        Kind::Steady => {
            let steady = steady_state(line, &level_input, &window.speed_pct)?;
            let found = |s: &&SteadyStatus| !matches!(s, SteadyStatus::Solved | SteadyStatus::Shut);
            unsolved = steady.status.iter().filter(found).count();
            Simulation {
                time_s: time.clone(),
                level_m: level_input.clone(),
                flow_m3_s: steady.flow_m3_s,
                bounds: RiserBounds::default(),
                status: Status::Finished,
                statistics: Statistics::default(),
            }
        }
    };
    // An integration that gave up wrote a part; the rest stays empty, and the status tells.
    let rows = simulated.time_s.len();
    // Without the pump only the inlet pressure is taken from these, and it asks for no speed.
    let standstill = match options.kind {
        Kind::Riser => vec![0.0; rows],
        _ => Vec::new(),
    };
    let mut outputs = derive_outputs(
        line,
        &simulated.level_m,
        &simulated.flow_m3_s,
        match options.kind {
            Kind::Riser => &standstill,
            _ => &window.speed_pct[..rows],
        },
        true,
    )?;
    let late = measured_flow(&simulated.time_s, &simulated.flow_m3_s, options.delay_s)?;
    let whole = |mut values: Vec<f64>| {
        values.resize(time.len(), f64::NAN);
        values
    };
    let weight = line.density_kg_m3 * GRAVITY_M_S2;
    // Across a shut valve stands the difference of the columns, whatever the pump's curve says.
    for (i, flow) in simulated.flow_m3_s.iter().enumerate() {
        if line.non_return_valve && *flow <= 0.0 {
            outputs.head_m[i] = (outputs.outlet_pa[i] - outputs.inlet_pa[i]) / weight;
        }
    }
    let measured_head = window
        .inlet_pa
        .iter()
        .zip(&window.outlet_pa)
        .map(|(i, o)| (o - i) / weight)
        .collect();
    // A driven signal is no simulation: only what the run gives is set beside the measurement.
    let given = |yes: bool, values: Vec<f64>| if yes { whole(values) } else { Vec::new() };
    let level = matches!(options.kind, Kind::Coupled | Kind::Riser);
    let flow = options.kind != Kind::Riser;
    Ok(Replay {
        level_m: Pair {
            measured: measured_level,
            simulated: given(level, simulated.level_m),
        },
        pump_flow_m3_s: Pair {
            measured: measured_flow_at_pump,
            simulated: given(flow, simulated.flow_m3_s),
        },
        return_flow_m3_s: Pair {
            measured: window.return_flow_m3_s,
            simulated: given(flow, late),
        },
        inlet_pressure_pa: Pair {
            measured: window.inlet_pa,
            simulated: given(level, outputs.inlet_pa),
        },
        outlet_pressure_pa: Pair {
            measured: window.outlet_pa,
            simulated: given(flow, outputs.outlet_pa),
        },
        head_m: Pair {
            measured: measured_head,
            simulated: given(flow, outputs.head_m),
        },
        inflow_m3_s: window.inflow_m3_s,
        speed_pct: window.speed_pct,
        filled: window.filled,
        bounds: simulated.bounds,
        status: (options.kind != Kind::Steady).then_some(simulated.status),
        statistics: simulated.statistics,
        unsolved,
        time_s: window.time_s,
    })
}
