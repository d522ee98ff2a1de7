//! The simulations of chapter 4 with inputs that come in parts.

use super::model::{COUPLED, FLOW, Line, RISER};
use super::simulate::{check_speed, check_start, refused, sample, settings};
use super::{LineState, ReturnLine, RiserBounds, Simulation, SimulationOptions};
use crate::DynamicsError;
use crate::inputs::{Signal, Straight};
use crate::integrate::{Options, Parts, Plan, Statistics, Status, Trajectory, Vector, check};
use std::fmt;

/// A simulation whose inputs come in parts, written at the times of their samples: what [`super::simulate_coupled`],
/// [`super::simulate_riser_alone`] or [`super::simulate_flow_alone`] give at once, to the last bit.
///
/// A part ends where an input has its last kink: up to there the integrator goes as it would, for it stops at every kink
/// anyway. From part to part it carries its states and its next step.
pub struct LineParts(Kind);

enum Kind {
    Coupled(Going<COUPLED, [f64; 2]>),
    Riser(Going<RISER, [f64; 1]>),
    Flow(Going<FLOW, [f64; 1]>),
}

impl fmt::Debug for LineParts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LineParts").finish_non_exhaustive()
    }
}

impl LineParts {
    /// Level and flow; inputs are the inflow, m³/s, and the pump's speed, %.
    ///
    /// # Errors
    /// [`DynamicsError`] on parameters, a start or options out of range.
    pub fn coupled(
        line: &ReturnLine,
        start: LineState,
        options: &SimulationOptions,
    ) -> Result<Self, DynamicsError> {
        let x = [start.level_m, start.flow_m3_s];
        let absolute = vec![options.level_tolerance_m, options.flow_tolerance_m3_s];
        Ok(Self(Kind::Coupled(Going::new(
            line, &x, absolute, options,
        )?)))
    }

    /// The level, m; inputs are the inflow and the pump's flow, m³/s.
    ///
    /// # Errors
    /// As [`Self::coupled`].
    pub fn riser_alone(
        line: &ReturnLine,
        start_level_m: f64,
        options: &SimulationOptions,
    ) -> Result<Self, DynamicsError> {
        let absolute = vec![options.level_tolerance_m];
        Ok(Self(Kind::Riser(Going::new(
            line,
            &[start_level_m],
            absolute,
            options,
        )?)))
    }

    /// The pump's flow, m³/s; inputs are the level, m, and the pump's speed, %.
    ///
    /// # Errors
    /// As [`Self::coupled`].
    pub fn flow_alone(
        line: &ReturnLine,
        start_flow_m3_s: f64,
        options: &SimulationOptions,
    ) -> Result<Self, DynamicsError> {
        let absolute = vec![options.flow_tolerance_m3_s];
        Ok(Self(Kind::Flow(Going::new(
            line,
            &[start_flow_m3_s],
            absolute,
            options,
        )?)))
    }

    /// Goes on as far as the inputs tell.
    ///
    /// - `time_s`: sample times, s, shape `(n,)`: at first from the start on, later again from the last sample on that was written.
    /// - `first`, `second`: the inputs at them, shape `(n,)`.
    /// - `last`: whether no more will come; only then it goes beyond the last kink.
    ///
    /// Gives the states at the samples that were not written yet, as many as there are by now; bounds, status and
    /// statistics are those of the whole so far. Once the status is not [`Status::Finished`] nothing more is written.
    ///
    /// # Errors
    /// [`DynamicsError`] on inputs that are not finite or of unequal length, times that do not ascend or do not go on from the last sample
    /// that was written, a part behind the last one, a negative speed.
    pub fn add(
        &mut self,
        time_s: &[f64],
        first: &[f64],
        second: &[f64],
        last: bool,
    ) -> Result<Simulation, DynamicsError> {
        let names = match &self.0 {
            Kind::Coupled(_) => ["inflow", "pump_speed"],
            Kind::Riser(_) => ["inflow", "return_flow"],
            Kind::Flow(_) => ["riser_level", "pump_speed"],
        };
        if names[1] == "pump_speed" {
            check_speed(names[1], second)?;
        }
        let signal = |name, values| Signal::new(name, time_s, values, Default::default());
        let inputs = [signal(names[0], first)?, signal(names[1], second)?];
        let (run, bounds) = match &mut self.0 {
            Kind::Coupled(going) => going.go(inputs, last)?,
            Kind::Riser(going) => going.go(inputs, last)?,
            Kind::Flow(going) => going.go(inputs, last)?,
        };
        let (level_m, flow_m3_s) = match &self.0 {
            Kind::Coupled(_) => (run.column(0), run.column(1)),
            Kind::Riser(_) => (run.column(0), sample(&inputs[1], &run.times)),
            Kind::Flow(_) => (sample(&inputs[0], &run.times), run.column(0)),
        };
        Ok(Simulation {
            time_s: run.times,
            level_m,
            flow_m3_s,
            bounds,
            status: run.status,
            statistics: run.statistics,
        })
    }
}

/// A simulation on its way.
struct Going<const KIND: u8, V: Vector> {
    system: Option<(Line<'static, KIND>, Parts<V>)>,
    settings: Options,
    initial: V,
    dimension: usize,
    lines: Option<[Straight; 2]>,
    /// So many samples from the last one written on are known to be kinks or none.
    decided: usize,
    started: bool,
    /// Time of the last sample that was written, s.
    reached_s: Option<f64>,
    /// Whether the last part has come.
    ended: bool,
    status: Status,
    statistics: Statistics,
    bounds: RiserBounds,
}

impl<const KIND: u8, V: Vector> Going<KIND, V> {
    fn new(
        line: &ReturnLine,
        initial: &[f64],
        absolute: Vec<f64>,
        options: &SimulationOptions,
    ) -> Result<Self, DynamicsError> {
        line.check()?;
        let settings = settings(absolute, options);
        let nowhere = Plan {
            start: 0.0,
            end: 0.0,
            outputs: &[],
            breaks: &[],
        };
        check_start::<KIND>(line, initial)?;
        check(initial.len(), initial, &nowhere, &settings).map_err(refused::<KIND>)?;
        let mut x = V::zeros(initial.len());
        x.get_mut().copy_from_slice(initial);
        let system = Line::new(line, Signal::rest(), Signal::rest());
        Ok(Self {
            system: Some((system, Parts::new(options.method, initial))),
            settings,
            initial: x,
            dimension: initial.len(),
            lines: None,
            decided: 0,
            started: false,
            reached_s: None,
            ended: false,
            status: Status::Finished,
            statistics: Statistics::default(),
            bounds: RiserBounds::default(),
        })
    }

    fn go(
        &mut self,
        [first, second]: [Signal<'_>; 2],
        last: bool,
    ) -> Result<(Trajectory, RiserBounds), DynamicsError> {
        let time = first.time_s();
        let refuse = |expected| DynamicsError::Sample {
            name: "time_s".into(),
            index: 0,
            found: time[0],
            expected,
        };
        if self.ended {
            return Err(refuse("no part behind the last one"));
        }
        if self.reached_s.is_some_and(|reached| reached != time[0]) {
            return Err(refuse("the time of the last sample that was written"));
        }
        self.ended = last;
        let (breaks, latest) = self.kinks(&first, &second);
        let to = if last { time.len() - 1 } else { latest };
        self.decided -= to.min(self.decided);
        let from = usize::from(self.started);
        let running = self.status == Status::Finished && (to > 0 || (last && !self.started));
        let taken = if running { self.system.take() } else { None };
        let Some((system, parts)) = taken else {
            if self.status == Status::Finished && !self.started {
                // The whole of it comes again, and more.
                self.reached_s = Some(time[0]);
            }
            let nothing = Trajectory {
                dimension: self.dimension,
                times: Vec::new(),
                states: Vec::new(),
                end: time[0],
                end_state: self.initial.get().to_vec(),
                status: self.status,
                statistics: self.statistics,
            };
            return Ok((nothing, self.bounds));
        };
        let plan = Plan {
            start: time[0],
            end: time[to],
            outputs: &time[from..=to],
            breaks: &breaks,
        };
        let mut system = system.on(first, second);
        let (run, parts) = parts.go(&mut system, &plan, &self.settings);
        (self.status, self.statistics, self.started) = (run.status, run.statistics, true);
        // One that stopped writes nothing more, wherever the inputs go on.
        self.reached_s = (run.status == Status::Finished).then_some(plan.end);
        self.bounds = RiserBounds {
            full_s: system.first_full_s,
            empty_s: system.first_empty_s,
            valve_shut_s: system.first_shut_s,
        };
        self.system = Some((system.on(Signal::rest(), Signal::rest()), parts));
        Ok((run, self.bounds))
    }

    /// Times at which an input bends, as far as the next sample tells, and the sample of the latest, 0 if there is none;
    /// those before were told before.
    fn kinks(&mut self, first: &Signal<'_>, second: &Signal<'_>) -> (Vec<f64>, usize) {
        let time = first.time_s();
        let start = |signal: &Signal<'_>| Straight::from(time[0], signal.values()[0]);
        let [a, b] = self
            .lines
            .get_or_insert_with(|| [start(first), start(second)]);
        let (va, vb) = (first.values(), second.values());
        // Of a recording most samples are kinks.
        let mut found = Vec::with_capacity(time.len().saturating_sub(self.decided));
        let mut latest = 0;
        for i in self.decided..time.len() - 1 {
            let (t, due) = (time[i], time[i + 1]);
            let bends =
                a.bends_at((t, va[i]), (due, va[i + 1])) | b.bends_at((t, vb[i]), (due, vb[i + 1]));
            if bends {
                found.push(t);
                latest = i;
            }
        }
        self.decided = self.decided.max(time.len() - 1);
        (found, latest)
    }
}
