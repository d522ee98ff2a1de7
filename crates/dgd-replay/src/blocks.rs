//! A replay of a recording that is longer than memory.

mod waiting;

use crate::fill::{Filling, join};
use crate::run::{check_delay, samples_late};
use crate::{Kind, Pair, Replay, ReplayError, ReplayOptions};
use dgd_dynamics::integrate::{Statistics, Status};
use dgd_dynamics::return_line::{
    GRAVITY_M_S2, LateParts, LineParts, LineState, OutputParts, ReturnLine, RiserBounds,
    Simulation, SteadyParts, SteadyStatus,
};
use dgd_recording::Recording;
use std::ops::Range;
use waiting::{Waiting, take};

/// [`crate::replay`] of a recording that comes in blocks: the same rows, to the last bit, whatever the blocks, or at the end
/// [`ReplayError::Drift`].
///
/// Rows are given when they are known, or, while many wait, when there are a quarter more of them. Held are rows that wait: for the next value of an input that has none, for the next
/// kink of one (the integrator must know where a straight stretch of its inputs ends), for the meter's delay, for
/// the first measured state. Memory grows with the longest such wait, not with the recording.
///
/// ```
/// use dgd_replay::{BlockReplay, Recording, ReplayError, ReplayOptions, ReturnLine};
/// # fn rows(line: &ReturnLine, blocks: Vec<Recording>) -> Result<usize, ReplayError> {
/// let mut replay = BlockReplay::new(line, &ReplayOptions::default(), 86_400, (0.0, 86_399.0))?;
/// let mut rows = 0;
/// for block in blocks {
///     rows += replay.add(block)?.time_s.len();
/// }
/// rows += replay.finish()?.time_s.len();
/// # Ok(rows)
/// # }
/// ```
#[derive(Debug)]
pub struct BlockReplay {
    line: ReturnLine,
    options: ReplayOptions,
    /// Samples of the recording, and so many of them have come.
    announced: usize,
    taken: usize,
    span_s: (f64, f64),
    /// Mean step of the recording, s.
    step_s: f64,
    /// Whether the meter shows no flow of the window in the recording.
    unseen: bool,
    /// Samples until the meter shows the flow of the window's first.
    until_shown: usize,
    waiting: Waiting,
    /// So many rows must be known before it is worth looking again.
    again: usize,
    running: Option<Running>,
    /// First and last second of the window so far, and its samples.
    window: Option<(f64, f64)>,
    samples: usize,
    /// First measured states of the window.
    start: LineStart,
    /// What was found of the run so far.
    bounds: RiserBounds,
    status: Option<Status>,
    statistics: Statistics,
    unsolved: usize,
}

/// States that a run can start from.
#[derive(Debug, Clone, Copy, Default)]
struct LineStart {
    level_m: Option<f64>,
    flow_m3_s: Option<f64>,
}

/// The run itself.
#[derive(Debug)]
struct Running {
    states: States,
    outputs: OutputParts,
    late: LateParts,
}

#[derive(Debug)]
enum States {
    Integrated(Box<LineParts>),
    Steady(Box<SteadyParts>),
}

impl BlockReplay {
    /// For a recording on an even clock.
    ///
    /// - `samples`: of the whole recording.
    /// - `span_s`: its first and last second.
    /// - `options`: as for [`crate::replay`].
    ///
    /// # Errors
    /// [`ReplayError::Delay`] on a negative one: the rows of a block would need readings of the blocks after it;
    /// [`ReplayError::Dynamics`] on one that is infinite, or if the model's parameters are refused.
    pub fn new(
        line: &ReturnLine,
        options: &ReplayOptions,
        samples: usize,
        span_s: (f64, f64),
    ) -> Result<Self, ReplayError> {
        let delay_s = options.delay_s;
        if delay_s.is_nan() || delay_s < 0.0 {
            return Err(ReplayError::Delay { delay_s });
        }
        check_delay(delay_s)?;
        line.check()?;
        Ok(Self::with_any_delay(line, options, samples, span_s))
    }

    /// The same, negative delays too, of which [`Self::whole`] asks nothing.
    pub(crate) fn with_any_delay(
        line: &ReturnLine,
        options: &ReplayOptions,
        samples: usize,
        span_s: (f64, f64),
    ) -> Self {
        let step_s = (span_s.1 - span_s.0) / samples.saturating_sub(1) as f64;
        let steps = samples_late(options.delay_s, step_s);
        // Beyond the end of the recording all delays are alike.
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a cast ends at the smallest and largest number"
        )]
        let until_shown = (steps as usize).min(samples);
        let (reads_inflow, reads_speed) = match options.kind {
            Kind::Coupled => (true, true),
            Kind::Riser => (true, false),
            Kind::Flow | Kind::Steady => (false, true),
        };
        // What a simulation does not read may be missing, and is left as it is.
        let waiting = Waiting {
            inflows: [(); 3].map(|()| Filling::new(reads_inflow)),
            speed_pct: Filling::new(reads_speed),
            level_input: Filling::new(matches!(options.kind, Kind::Flow | Kind::Steady)),
            flow_input: Filling::new(options.kind == Kind::Riser),
            ..Waiting::default()
        };
        Self {
            line: *line,
            options: options.clone(),
            announced: samples,
            taken: 0,
            span_s,
            step_s,
            unseen: false,
            until_shown,
            waiting,
            again: 0,
            running: None,
            window: None,
            samples: 0,
            start: LineStart {
                level_m: options.start.level_m,
                flow_m3_s: options.start.flow_m3_s,
            },
            bounds: RiserBounds::default(),
            status: (options.kind != Kind::Steady).then_some(Status::Finished),
            statistics: Statistics::default(),
            unsolved: 0,
        }
    }

    /// Takes the next samples; gives rows that are known by now, maybe none.
    ///
    /// Bounds, status and counts of what is given are those of the run so far.
    ///
    /// # Errors
    /// [`ReplayError::Length`] on unequal series, [`ReplayError::Blocks`] on more samples than were announced,
    /// [`ReplayError::Dynamics`] if the model is refused.
    pub fn add(&mut self, mut block: Recording) -> Result<Replay, ReplayError> {
        check_lengths(&block)?;
        let found = self.taken + block.len();
        if found > self.announced {
            return Err(self.uneven(found));
        }
        self.taken = found;
        let (from_s, to_s) = self.options.window_s.unwrap_or(self.span_s);
        let Range {
            start: first,
            end: last,
        } = block.between(from_s, to_s);
        // The meter shows flows of the window before and after its end.
        let shown = block.return_flow_m3_s.get(first..).unwrap_or_default();
        let skipped = self.until_shown.min(shown.len());
        self.until_shown -= skipped;
        let missing = self.samples + (last - first) - self.shown();
        let shown = shown[skipped..].iter().take(missing).copied().collect();
        if first > 0 || last < block.len() {
            block = block.slice(first..last);
        }
        self.take(block, shown);
        self.go(false)
    }

    /// Gives the rows that are left.
    ///
    /// # Errors
    /// Those of [`crate::replay`]; a window without two samples, or an input without a value, is told only here.
    /// [`ReplayError::Blocks`] on fewer samples than were announced; [`ReplayError::Drift`] if the clock of the window is so much slower or
    /// faster than the recording's that the rows given are not those of [`crate::replay`], for which the delay is another number of samples.
    pub fn finish(mut self) -> Result<Replay, ReplayError> {
        if self.taken < self.announced {
            return Err(self.uneven(self.taken));
        }
        self.check_drift()?;
        self.unseen = self.shown() == 0;
        let rows = self.waiting.time_s.len();
        let missing = rows - self.waiting.pump_flow_m3_s.len();
        self.show(vec![f64::NAN; missing]);
        self.end()
    }

    /// The window at once, with the flow that the meter will show.
    pub(crate) fn whole(
        mut self,
        window: Recording,
        pump_flow_m3_s: Vec<f64>,
        unseen: bool,
    ) -> Result<Replay, ReplayError> {
        self.unseen = unseen;
        self.take(window, pump_flow_m3_s);
        self.end()
    }

    /// The window's step is known at its end alone, when its rows are given by the step of the whole.
    fn check_drift(&self) -> Result<(), ReplayError> {
        let (Some((from_s, to_s)), true) = (self.window, self.samples >= 2) else {
            return Ok(());
        };
        let (delay_s, step_s) = (self.options.delay_s, self.step_s);
        let found_s = (to_s - from_s) / (self.samples - 1) as f64;
        if samples_late(delay_s, found_s) == samples_late(delay_s, step_s) {
            return Ok(());
        }
        Err(ReplayError::Drift { found_s, step_s })
    }

    fn uneven(&self, found: usize) -> ReplayError {
        ReplayError::Blocks {
            found,
            expected: self.announced,
        }
    }

    /// Rows of the window of which the pump's flow is known.
    fn shown(&self) -> usize {
        let waiting = &self.waiting;
        self.samples - (waiting.time_s.len() - waiting.pump_flow_m3_s.len())
    }

    /// Takes rows of the window, and pump flows of rows that lack them.
    fn take(&mut self, mut rows: Recording, pump_flow_m3_s: Vec<f64>) {
        if let (Some(first), Some(last)) = (rows.time_s.first(), rows.time_s.last()) {
            self.window = Some((self.window.map_or(*first, |w| w.0), *last));
        }
        self.samples += rows.len();
        // One transmitter is its own mean.
        let inlet_pa = match rows.pump_inlet_pressure_pa.len() {
            1 => rows.pump_inlet_pressure_pa.remove(0),
            _ => rows.mean_inlet_pressure_pa(),
        };
        let outlet_pa = match rows.pump_outlet_pressure_pa.len() {
            1 => rows.pump_outlet_pressure_pa.remove(0),
            _ => rows.mean_outlet_pressure_pa(),
        };
        let level = |p: &f64| self.line.level_from_inlet_pressure(*p);
        let level_m: Vec<f64> = inlet_pa.iter().map(level).collect();
        let first = level_m.iter().copied().find(|v| v.is_finite());
        self.start.level_m = self.start.level_m.or(first);
        let waiting = &mut self.waiting;
        if waiting.level_input.is_read() {
            waiting.level_input.extend(level_m.clone());
        }
        let flows = [
            rows.mud_pump_flow_m3_s,
            rows.booster_flow_m3_s,
            rows.topfill_flow_m3_s,
        ];
        for (filling, flow) in waiting.inflows.iter_mut().zip(flows) {
            filling.extend(flow);
        }
        waiting.speed_pct.extend(rows.pump_speed_pct);
        join(&mut waiting.time_s, rows.time_s);
        join(&mut waiting.inlet_pa, inlet_pa);
        join(&mut waiting.outlet_pa, outlet_pa);
        join(&mut waiting.level_m, level_m);
        join(&mut waiting.return_flow_m3_s, rows.return_flow_m3_s);
        self.show(pump_flow_m3_s);
    }

    fn show(&mut self, pump_flow_m3_s: Vec<f64>) {
        let first = pump_flow_m3_s.iter().copied().find(|v| v.is_finite());
        self.start.flow_m3_s = self.start.flow_m3_s.or(first);
        let waiting = &mut self.waiting;
        if waiting.flow_input.is_read() {
            waiting.flow_input.extend(pump_flow_m3_s.clone());
        }
        join(&mut waiting.pump_flow_m3_s, pump_flow_m3_s);
    }

    fn end(&mut self) -> Result<Replay, ReplayError> {
        let (start_s, end_s) = self.span_s;
        let (from_s, to_s) = self.options.window_s.unwrap_or(self.span_s);
        if self.samples < 2 {
            return Err(ReplayError::Window {
                from_s,
                to_s,
                samples: self.samples,
                start_s,
                end_s,
            });
        }
        let (from_s, to_s) = self.window.unwrap_or(self.span_s);
        let (delay_s, unseen) = (self.options.delay_s, self.unseen);
        let missing = |name| match name {
            "return_flow" if unseen => ReplayError::DelayBeyond {
                delay_s,
                from_s,
                to_s,
                start_s,
                end_s,
            },
            _ => ReplayError::NoInput { name, from_s, to_s },
        };
        let waiting = &mut self.waiting;
        let [mud_pump, booster, topfill] = &mut waiting.inflows;
        for (name, input) in [
            ("mud_pump_flow", mud_pump),
            ("booster_flow", booster),
            ("topfill_flow", topfill),
            ("pump_speed", &mut waiting.speed_pct),
            ("pump_inlet_pressure", &mut waiting.level_input),
            ("return_flow", &mut waiting.flow_input),
        ] {
            input.end().ok_or_else(|| missing(name))?;
        }
        if !self.can_start() {
            let level = matches!(self.options.kind, Kind::Coupled | Kind::Riser);
            return Err(missing(if level && self.start.level_m.is_none() {
                "pump_inlet_pressure"
            } else {
                "return_flow"
            }));
        }
        self.go(true)
    }

    fn can_start(&self) -> bool {
        let LineStart { level_m, flow_m3_s } = self.start;
        match self.options.kind {
            Kind::Coupled => level_m.is_some() && flow_m3_s.is_some(),
            Kind::Riser => level_m.is_some(),
            Kind::Flow => flow_m3_s.is_some(),
            Kind::Steady => true,
        }
    }

    /// States to start from: measured ones may be off by their noise, where the model has an end.
    fn first_state(&self) -> LineState {
        let (line, given) = (&self.line, &self.options.start);
        let mut level_m = self.start.level_m.unwrap_or(f64::NAN);
        if given.level_m.is_none() {
            level_m = level_m.clamp(0.0, line.inlet_depth_m.max(0.0));
        }
        let mut flow_m3_s = self.start.flow_m3_s.unwrap_or(f64::NAN);
        if given.flow_m3_s.is_none() && line.non_return_valve && flow_m3_s < 0.0 {
            flow_m3_s = 0.0;
        }
        LineState { level_m, flow_m3_s }
    }

    fn begin(&self) -> Result<Running, ReplayError> {
        let (line, solver) = (&self.line, &self.options.solver);
        let LineState { level_m, flow_m3_s } = self.first_state();
        let states = match self.options.kind {
            Kind::Coupled => {
                let start = LineState { level_m, flow_m3_s };
                States::Integrated(Box::new(LineParts::coupled(line, start, solver)?))
            }
            Kind::Riser => {
                States::Integrated(Box::new(LineParts::riser_alone(line, level_m, solver)?))
            }
            Kind::Flow => {
                States::Integrated(Box::new(LineParts::flow_alone(line, flow_m3_s, solver)?))
            }
            Kind::Steady => States::Steady(Box::new(SteadyParts::new(line)?)),
        };
        Ok(Running {
            states,
            outputs: OutputParts::new(line, true)?,
            late: LateParts::new(self.options.delay_s)?,
        })
    }

    /// Runs as far as the rows that wait allow.
    fn go(&mut self, last: bool) -> Result<Replay, ReplayError> {
        let known = self.waiting.known();
        let enough =
            self.samples >= 2 && known > self.waiting.given && (last || known >= self.again);
        if !enough || !self.can_start() {
            return Ok(self.rows(0, Rows::default()));
        }
        let mut running = match self.running.take() {
            Some(running) => running,
            None => self.begin()?,
        };
        let waiting = &self.waiting;
        let inflow_m3_s = waiting.inflow(known);
        let speed_pct = waiting.speed(known);
        let kind = self.options.kind;
        let simulated = match &mut running.states {
            States::Steady(steady) => {
                let level_m = waiting.level_input.values[..known].to_vec();
                let found = steady.add(&level_m, &speed_pct)?;
                let met =
                    |s: &&SteadyStatus| !matches!(s, SteadyStatus::Solved | SteadyStatus::Shut);
                self.unsolved += found.status.iter().filter(met).count();
                Simulation {
                    time_s: waiting.time_s[..known].to_vec(),
                    level_m,
                    flow_m3_s: found.flow_m3_s,
                    bounds: RiserBounds::default(),
                    status: Status::Finished,
                    statistics: Statistics::default(),
                }
            }
            States::Integrated(parts) => {
                let (first, second) = match kind {
                    Kind::Riser => (&inflow_m3_s[..], &waiting.flow_input.values[..known]),
                    Kind::Flow => (&waiting.level_input.values[..known], &speed_pct[..]),
                    _ => (&inflow_m3_s[..], &speed_pct[..]),
                };
                let found = parts.add(&waiting.time_s[..known], first, second, last)?;
                (self.bounds, self.statistics) = (found.bounds, found.statistics);
                self.status = Some(found.status);
                found
            }
        };
        let rows = simulated.time_s.len();
        let from = waiting.given;
        // Without the pump only the inlet pressure is taken from these, and it asks for no speed.
        let standstill = match kind {
            Kind::Riser => vec![0.0; rows],
            _ => Vec::new(),
        };
        let mut outputs = running.outputs.add(
            &simulated.level_m,
            &simulated.flow_m3_s,
            match kind {
                Kind::Riser => &standstill,
                _ => &speed_pct[from..from + rows],
            },
        )?;
        let late = running.late.add(&simulated.time_s, &simulated.flow_m3_s)?;
        let weight = self.line.density_kg_m3 * GRAVITY_M_S2;
        // Across a shut valve stands the difference of the columns, whatever the pump's curve says.
        for (i, flow) in simulated.flow_m3_s.iter().enumerate() {
            if self.line.non_return_valve && *flow <= 0.0 {
                outputs.head_m[i] = (outputs.outlet_pa[i] - outputs.inlet_pa[i]) / weight;
            }
        }
        self.running = Some(running);
        // An integration that gave up wrote a part; the rest stays empty, and the status tells.
        let stopped = self.status.is_some_and(|status| status != Status::Finished);
        let to = if stopped { known } else { from + rows };
        // While all inputs rest no row is given; to look again at every block would cost the square of the rest.
        self.again = if to > from { 0 } else { known + known / 4 };
        Ok(self.rows(
            to - from,
            Rows {
                simulated: Some(simulated),
                late,
                inlet_pa: outputs.inlet_pa,
                outlet_pa: outputs.outlet_pa,
                head_m: outputs.head_m,
                inflow_m3_s,
                speed_pct,
            },
        ))
    }

    /// Gives so many rows that waited, with what was simulated of them.
    fn rows(&mut self, rows: usize, found: Rows) -> Replay {
        let kind = self.options.kind;
        let waiting = &mut self.waiting;
        let here = waiting.given..waiting.given + rows;
        // The integrator asks again for the last sample that it wrote.
        let gone = match kind {
            Kind::Steady => here.end,
            _ => here.end.saturating_sub(1),
        };
        let measured = |values: &mut Vec<f64>| take(values, here.clone(), gone);
        let weight = self.line.density_kg_m3 * GRAVITY_M_S2;
        // A driven signal is no simulation: only what the run gives is set beside the measurement.
        let given = |yes: bool, mut values: Vec<f64>| {
            if !yes {
                return Vec::new();
            }
            values.resize(rows, f64::NAN);
            values
        };
        let level = matches!(kind, Kind::Coupled | Kind::Riser);
        let flow = kind != Kind::Riser;
        let (level_m, flow_m3_s) = found
            .simulated
            .map_or_else(Default::default, |s| (s.level_m, s.flow_m3_s));
        let pair = |measured, simulated| Pair {
            measured,
            simulated,
        };
        let inlet_pa = measured(&mut waiting.inlet_pa);
        let outlet_pa = measured(&mut waiting.outlet_pa);
        let sides = inlet_pa.iter().zip(&outlet_pa);
        let head_m = sides.map(|(i, o)| (o - i) / weight).collect();
        let of = |mut values: Vec<f64>| {
            values.truncate(here.end);
            values.drain(..here.start.min(values.len()));
            values
        };
        let replay = Replay {
            level_m: pair(measured(&mut waiting.level_m), given(level, level_m)),
            pump_flow_m3_s: pair(
                measured(&mut waiting.pump_flow_m3_s),
                given(flow, flow_m3_s),
            ),
            return_flow_m3_s: pair(
                measured(&mut waiting.return_flow_m3_s),
                given(flow, found.late),
            ),
            inlet_pressure_pa: pair(inlet_pa, given(level, found.inlet_pa)),
            outlet_pressure_pa: pair(outlet_pa, given(flow, found.outlet_pa)),
            head_m: pair(head_m, given(flow, found.head_m)),
            inflow_m3_s: of(found.inflow_m3_s),
            speed_pct: of(found.speed_pct),
            filled: waiting.filled(),
            bounds: self.bounds,
            status: self.status,
            statistics: self.statistics,
            unsolved: self.unsolved,
            time_s: measured(&mut waiting.time_s),
        };
        waiting.given = here.end - gone;
        waiting.forget(gone);
        replay
    }
}

/// What was found of rows.
#[derive(Default)]
struct Rows {
    simulated: Option<Simulation>,
    late: Vec<f64>,
    inlet_pa: Vec<f64>,
    outlet_pa: Vec<f64>,
    head_m: Vec<f64>,
    /// From the first row that waits on, as the speed.
    inflow_m3_s: Vec<f64>,
    speed_pct: Vec<f64>,
}

pub(crate) fn check_lengths(recording: &Recording) -> Result<(), ReplayError> {
    let expected = recording.len();
    let all = recording.series();
    match all.iter().find(|(_, values)| values.len() != expected) {
        None => Ok(()),
        Some((channel, values)) => Err(ReplayError::Length {
            channel: channel.to_string(),
            expected,
            found: values.len(),
        }),
    }
}
