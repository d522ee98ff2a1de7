//! One window of a free run, sample by sample.

use super::{AugmentedModel, FreeRun, Held, Inputs, MOST_M3_S, STANDING_PCT};
use crate::moment::{Lag, leaking_m3_s};
use crate::{Action, Changes, MeterPath, Moment, Setting};
use dgd_recording::STANDING_M3_S;
use dgd_units::{STANDARD_ATMOSPHERE_PA, STANDARD_GRAVITY_M_S2};
use std::ops::Range;

/// Least and greatest true inlet pressure of a run, Pa absolute.
const INLET_PA: (f64, f64) = (5e4, 1e8);
/// Least share of the riser's area, and of the line that is filled: a run divides by both. Set by hand.
const LEAST_AREA: f64 = 0.05;
const LEAST_FILLED: f64 = 0.02;
/// Flow above which the further pressure drop along the line acts, m³/s. Set by hand.
const DRAGGED_M3_S: f64 = 1e-6;
/// Longest step of a run, s, and the most of them in one step of the clock.
const LONGEST_STEP_S: f64 = 1.0;
const MOST_STEPS: f64 = 20.0;

/// A window that runs from a measured state, and the sample from which its effects see what came before.
pub(super) struct Stretch {
    pub(super) from: usize,
    pub(super) window: Range<usize>,
    /// Inlet pressure, Pa absolute, and line flow, m³/s.
    pub(super) start: (f64, f64),
}

/// The effects of a model as they live through a recording.
pub(super) struct Acting {
    actions: Vec<Action>,
    path: MeterPath,
    /// Whether the line was full at the last sample.
    full: bool,
}

impl Acting {
    pub(super) fn new(actions: Vec<Action>, path: MeterPath) -> Self {
        Self {
            actions,
            path,
            full: true,
        }
    }

    fn changes(&mut self, moment: &Moment) -> Changes {
        let mut changes = Changes::default();
        for action in &mut self.actions {
            action(moment, &mut changes);
        }
        self.full = changes.line_fall_m <= 0.0;
        changes
    }
}

/// The rig at a sample of a run: true pressures, Pa absolute, and the true flow, m³/s.
struct State {
    inlet_pa: f64,
    outlet_pa: f64,
    flow_m3_s: f64,
}

impl State {
    /// What effects see at sample `i` of a stretch.
    fn moment(&self, inputs: Inputs<'_>, i: usize, stretch: &Stretch, full: bool) -> Moment {
        let flow = self.flow_m3_s;
        let first = stretch.window.start;
        let speed_pct = inputs.speed_pct[i];
        let pumping = speed_pct > STANDING_PCT;
        let flow_m3_s = match (i >= first, pumping) {
            (true, _) => flow,
            (false, true) if flow > STANDING_M3_S => flow,
            // A window that starts at rest tells nothing of what was pumped before it.
            (false, true) => inputs.inflow_m3_s(i).max(0.0),
            (false, false) => 0.0,
        };
        // What flows at the window's start was measured at the line's top.
        let returns = full || i == first || (i < first && flow > STANDING_M3_S);
        Moment {
            index: i,
            t_s: inputs.time_s[i],
            dt_s: inputs.step_s,
            mud_pump_m3_s: inputs.mud_pump_m3_s[i],
            booster_m3_s: inputs.booster_m3_s[i],
            topfill_m3_s: inputs.topfill_m3_s[i],
            flow_m3_s,
            outflow_m3_s: if returns { flow_m3_s } else { 0.0 },
            speed_pct,
            inlet_pa: self.inlet_pa,
            outlet_pa: self.outlet_pa,
            pumping,
        }
    }

    /// Takes the errors of the readings that a run starts from out of them.
    fn correct(&mut self, c: &Changes) {
        self.inlet_pa -= c.read_inlet_bias_pa();
        if self.flow_m3_s > STANDING_M3_S && c.meter_gain > 0.0 {
            let outflow = self.flow_m3_s / c.meter_gain;
            self.flow_m3_s = outflow + leaking_m3_s(c.leak_m3_s, outflow);
        }
    }
}

/// The return line of a model, as no effect changes it.
pub(super) struct Line<'a> {
    model: &'a AugmentedModel,
    setting: &'a Setting,
    held: Held,
    /// Pressure of the full, unmixed line, Pa absolute.
    column_pa: f64,
}

impl<'a> Line<'a> {
    pub(super) fn of(model: &'a AugmentedModel, setting: &'a Setting) -> Self {
        let weight = setting.density_kg_m3 * STANDARD_GRAVITY_M_S2;
        Self {
            model,
            setting,
            held: Held::of(model),
            column_pa: STANDARD_ATMOSPHERE_PA + weight * setting.line_length_m,
        }
    }

    fn friction_pa(&self, flow_m3_s: f64) -> f64 {
        self.held.friction_pa(&self.model.curves, flow_m3_s)
    }

    /// One window, and before it what the effects remember of the time up to it.
    pub(super) fn run(
        &self,
        inputs: Inputs<'_>,
        stretch: &Stretch,
        acting: &mut Acting,
    ) -> FreeRun {
        let (inlet_pa, flow_m3_s) = stretch.start;
        let mut state = State {
            inlet_pa,
            outlet_pa: self.column_pa + self.friction_pa(flow_m3_s),
            flow_m3_s,
        };
        let first = stretch.window.start;
        let end = stretch.window.end.min(inputs.samples());
        let mut meter = Meter {
            path: acting.path,
            step_s: inputs.step_s,
            lag: (acting.path.lag_s > 0.0).then(|| Lag::at(flow_m3_s, acting.path.lag_s)),
            past: Vec::with_capacity(end.saturating_sub(first)),
        };
        let mut run = FreeRun::default();
        for i in stretch.from..end {
            let moment = state.moment(inputs, i, stretch, acting.full);
            let changes = acting.changes(&moment);
            if i < first {
                continue;
            }
            let altered = Altered::of(self, &changes);
            let mut acceleration = 0.0;
            if i == first {
                state.correct(&changes);
            } else {
                let before = state.flow_m3_s;
                altered.advance(&mut state, &moment, inputs.inflow_m3_s(i));
                acceleration = (state.flow_m3_s - before) / inputs.step_s;
            }
            state.outlet_pa = if state.flow_m3_s > 0.0 {
                altered.outlet_pa(state.flow_m3_s, acceleration)
            } else {
                altered.still_pa
            };
            let outflow = if acting.full { state.flow_m3_s } else { 0.0 };
            let metered = (outflow - changes.leak_m3_s).max(0.0) * changes.meter_gain;
            run.return_flow_m3_s.push(meter.reads(metered));
            run.inlet_pa
                .push(state.inlet_pa + changes.read_inlet_bias_pa());
            run.outlet_pa
                .push(state.outlet_pa + changes.read_outlet_bias_pa(self.setting.outlets));
        }
        run
    }
}

/// The terms of the model's equations at a sample, as the effects alter them.
struct Altered<'a> {
    line: &'a Line<'a>,
    changes: &'a Changes,
    /// Outlet pressure with the mud at rest, Pa absolute.
    still_pa: f64,
    /// Factors on friction and head.
    friction: f64,
    lift: f64,
    /// Inertia of the mud in the line, Pa/(m³/s²).
    inertia: f64,
    /// Inlet pressure that a cubic metre in the riser adds, Pa/m³.
    rise: f64,
}

impl<'a> Altered<'a> {
    fn of(line: &'a Line<'a>, c: &'a Changes) -> Self {
        let s = line.setting;
        let (g, rho) = (STANDARD_GRAVITY_M_S2, s.density_kg_m3);
        // Only where there is mud does it rub, and is it to be moved.
        let wet = (1.0 - c.line_fall_m / s.line_length_m).clamp(LEAST_FILLED, 1.0);
        Self {
            line,
            changes: c,
            still_pa: line.column_pa + c.line_kg_m3 * g * s.line_length_m - rho * g * c.line_fall_m,
            friction: wet * c.friction_factor * (1.0 + c.line_kg_m3 / rho),
            lift: c.head_factor * (1.0 + c.riser_kg_m3 / rho),
            inertia: wet * (rho * s.line_length_m / s.line_area_m2),
            rise: g * rho / (s.riser_area_m2 * c.area_factor.max(LEAST_AREA)),
        }
    }

    /// Moves the flow and the inlet pressure on by a step of the clock: implicit in the flow, trapezoidal in the level.
    fn advance(&self, state: &mut State, moment: &Moment, inflow_m3_s: f64) {
        let c = self.changes;
        let rho = self.line.setting.density_kg_m3;
        // A pump that coasts still pumps when its set-point has stopped.
        let speed_pct = moment.speed_pct + c.speed_pct;
        let turns = moment.pumping || speed_pct > STANDING_PCT;
        let steps = (moment.dt_s / LONGEST_STEP_S).ceil().clamp(1.0, MOST_STEPS);
        let dt = moment.dt_s / steps;
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "1 to 20; a NaN becomes 0"
        )]
        let steps = steps as usize;
        for _ in 0..steps {
            let old = state.flow_m3_s;
            let inlet_pa = state.inlet_pa;
            let balance = |q: f64| {
                let head_pa = (self.line.model).head_pa(speed_pct, q + c.recirculation_m3_s);
                inlet_pa + c.head_pa + self.lift * head_pa
                    - self.still_pa
                    - self.friction * self.line.friction_pa(q)
                    - if q > DRAGGED_M3_S {
                        c.line_drop_pa
                    } else {
                        0.0
                    }
            };
            state.flow_m3_s = if turns {
                implicit(old, dt, self.inertia, balance)
            } else {
                0.0
            };
            let out = 0.5 * (old + state.flow_m3_s);
            let net = inflow_m3_s * (1.0 + c.entering_kg_m3 / rho) + c.inflow_m3_s
                - out * (1.0 + c.riser_kg_m3 / rho);
            state.inlet_pa = (inlet_pa + self.rise * net * dt).clamp(INLET_PA.0, INLET_PA.1);
        }
    }

    /// Outlet pressure of mud that flows, Pa absolute, at its acceleration, m³/s².
    fn outlet_pa(&self, flow_m3_s: f64, acceleration: f64) -> f64 {
        self.still_pa
            + self.friction * self.line.friction_pa(flow_m3_s)
            + self.changes.line_drop_pa
            + self.inertia * acceleration
    }
}

/// A flow meter that lags and delays what it reads.
struct Meter {
    path: MeterPath,
    step_s: f64,
    lag: Option<Lag>,
    past: Vec<f64>,
}

impl Meter {
    /// Its next reading; before the window it is taken to have shown what it shows at its start.
    fn reads(&mut self, flow_m3_s: f64) -> f64 {
        let lagged = match &mut self.lag {
            Some(lag) => lag.step(flow_m3_s, self.step_s),
            None => flow_m3_s,
        };
        self.past.push(lagged);
        delayed(&self.past, self.path.delay_s / self.step_s)
    }
}

/// The value some samples back, the first one before that; a meter cannot show what is to come.
fn delayed(past: &[f64], samples: f64) -> f64 {
    let position = (past.len() - 1) as f64 - samples.max(0.0);
    if position <= 0.0 {
        return past[0];
    }
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "0 < position < len"
    )]
    let low = position.floor() as usize;
    let share = position - low as f64;
    match past.get(low + 1) {
        Some(next) => past[low] + share * (next - past[low]),
        None => past[low],
    }
}

/// One step of implicit Euler for `inertia dq/dt = balance(q)`, q >= 0: false position on a bracket, the end that stays halved, as the balance
/// falls with q.
fn implicit(old: f64, dt: f64, inertia: f64, balance: impl Fn(f64) -> f64) -> f64 {
    let f = |q: f64| q - old - dt / inertia * balance(q);
    let (mut low, mut high) = (0.0, MOST_M3_S);
    let (mut f_low, mut f_high) = (f(low), f(high));
    if f_low >= 0.0 {
        return 0.0;
    }
    if f_high <= 0.0 {
        return high;
    }
    for _ in 0..30 {
        let secant = low - f_low * (high - low) / (f_high - f_low);
        let middle = 0.5 * (low + high);
        let q = if secant > low && secant < high {
            secant
        } else {
            middle
        };
        let fq = f(q);
        if fq.abs() < 1e-9 || high - low < 1e-9 {
            return q;
        }
        if fq < 0.0 {
            low = q;
            f_low = fq;
            f_high *= 0.5;
        } else {
            high = q;
            f_high = fq;
            f_low *= 0.5;
        }
    }
    0.5 * (low + high)
}
