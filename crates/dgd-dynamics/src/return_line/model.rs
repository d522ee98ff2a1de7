//! The right-hand sides of Eq. 3.45-3.46 in the forms the integrators want.

use super::power::{Power, Reference};
use super::{GRAVITY_M_S2, ReturnLine};
use crate::inputs::{Cursor, Piece, Signal};
use crate::integrate::{Linearised, System};

/// Constants of the momentum balance, worked out once a simulation.
#[derive(Debug, Clone, Copy)]
pub(super) struct Momentum {
    line: ReturnLine,
    rho_g: f64,
    /// ρ·g·c2
    sweep: f64,
    /// ρ/A_a
    column: f64,
    /// ρ·h_out/A_MRL
    discharge: f64,
    /// h_out − h_in
    rise_m: f64,
    speed_power: Power,
    flow_power: Power,
    speed_reference: Reference,
    flow_reference: Reference,
}

/// Flow acceleration `a` at a point, with its derivatives.
pub(super) struct Acceleration {
    pub rate: f64,
    pub by_level: f64,
    pub by_flow: f64,
    pub by_speed: f64,
}

impl Momentum {
    pub(super) fn new(line: &ReturnLine) -> Self {
        let mut line = *line;
        if line.b_is_offset {
            line.friction.b_pa = 0.0; // seen by the transmitter only
        }
        let rho = line.density_kg_m3;
        Self {
            rho_g: rho * GRAVITY_M_S2,
            sweep: rho * GRAVITY_M_S2 * line.pump.c2,
            column: rho / line.riser_area_m2,
            discharge: rho * line.outlet_depth_m / line.line_area_m2,
            rise_m: line.outlet_depth_m - line.inlet_depth_m,
            speed_power: Power::new(line.pump.n0),
            flow_power: Power::new(line.pump.n2),
            speed_reference: Reference::default(),
            flow_reference: Reference::default(),
            line,
        }
    }

    /// Moves the power references to the start of a segment.
    #[inline(always)]
    pub(super) fn refer(&mut self, speed: f64, flow: f64) {
        self.speed_power.refer(speed, &mut self.speed_reference);
        self.flow_power.refer(flow.abs(), &mut self.flow_reference);
    }

    #[inline(always)]
    fn inertia(&self, level: f64) -> f64 {
        self.discharge + self.column * (self.line.inlet_depth_m - level).max(0.0)
    }

    /// Drive in Pa, with the two powers it used.
    #[inline(always)]
    pub(super) fn drive(&self, level: f64, speed: f64, flow: f64) -> (f64, f64, f64) {
        let pump = &self.line.pump;
        let spun = self.speed_power.at(speed, &self.speed_reference);
        let swept = self.flow_power.at(flow.abs(), &self.flow_reference);
        // All that does not wait for the power of the flow comes first: the stages of a step
        // depend on each other, so latency is what a simulation pays for.
        let known = self.rho_g * (pump.c0 * spun - pump.c1 * speed * flow - level - self.rise_m)
            - self.line.friction.loss_pa(flow);
        let drive = known - self.sweep * swept.copysign(flow);
        (drive, spun, swept)
    }

    #[inline(always)]
    pub(super) fn rate(&self, level: f64, speed: f64, flow: f64) -> f64 {
        // The division runs beside the drive instead of after it.
        let inverse = 1.0 / self.inertia(level);
        self.drive(level, speed, flow).0 * inverse
    }

    /// `∂drive/∂q`, Pa·s/m³, given `|q|^n2`.
    #[inline(always)]
    pub(super) fn drive_by_flow(&self, speed: f64, flow: f64, swept: f64) -> f64 {
        let pump = &self.line.pump;
        let size = flow.abs();
        let power = slope(swept, size, pump.n2);
        -(self.rho_g * pump.c1 * speed + self.sweep * power)
            - self.line.friction.slope_pa_s_m3(flow)
    }

    #[inline(always)]
    pub(super) fn linearise(&self, level: f64, speed: f64, flow: f64) -> Acceleration {
        let pump = &self.line.pump;
        let (drive, spun, swept) = self.drive(level, speed, flow);
        let inverse = 1.0 / self.inertia(level);
        let rate = drive * inverse;
        let column = if level < self.line.inlet_depth_m {
            self.column
        } else {
            0.0
        };
        Acceleration {
            rate,
            by_level: (rate * column - self.rho_g) * inverse,
            by_flow: self.drive_by_flow(speed, flow, swept) * inverse,
            by_speed: self.rho_g
                * (pump.c0 * slope(spun, speed, pump.n0) - pump.c1 * flow)
                * inverse,
        }
    }
}

/// `d(x^n)/dx` for `x ≥ 0`, `n ≥ 1`, given `x^n`.
#[inline(always)]
fn slope(power: f64, x: f64, n: f64) -> f64 {
    if x > 0.0 {
        n * power / x
    } else if n == 1.0 {
        1.0
    } else {
        0.0
    }
}

/// Which of the two states are simulated, and where the others come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// `x = [h_r]`, the flow is an input.
    Riser,
    /// `x = [q]`, the level is an input.
    Flow,
    /// `x = [h_r, q]`.
    Coupled,
}

/// Where the level is held by the riser's ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Riser {
    Free,
    Full,
    Empty,
}

/// The model of one simulation: momentum, inputs, and the state of valve and riser.
///
/// `KIND` is a constant so that the two-state model carries no branches of the others.
pub(super) struct Line<'a, const KIND: u8> {
    momentum: Momentum,
    /// Inflow (riser), or level (flow alone).
    first: Signal<'a>,
    /// Measured flow (riser alone), or speed.
    second: Signal<'a>,
    first_cursor: Cursor,
    second_cursor: Cursor,
    first_piece: Piece,
    second_piece: Piece,
    inverse_area: f64,
    shut: bool,
    riser: Riser,
    pub(super) first_full_s: Option<f64>,
    pub(super) first_empty_s: Option<f64>,
    pub(super) first_shut_s: Option<f64>,
}

pub(super) const RISER: u8 = Kind::Riser as u8;
pub(super) const FLOW: u8 = Kind::Flow as u8;
pub(super) const COUPLED: u8 = Kind::Coupled as u8;

/// Guard 0 watches the valve, guard 1 the level.
const VALVE: usize = 0;

impl<'a, const KIND: u8> Line<'a, KIND> {
    pub(super) fn new(line: &ReturnLine, first: Signal<'a>, second: Signal<'a>) -> Self {
        Self {
            momentum: Momentum::new(line),
            first,
            second,
            first_cursor: Cursor::default(),
            second_cursor: Cursor::default(),
            first_piece: Piece::default(),
            second_piece: Piece::default(),
            inverse_area: 1.0 / line.riser_area_m2,
            shut: false,
            riser: Riser::Free,
            first_full_s: None,
            first_empty_s: None,
            first_shut_s: None,
        }
    }

    /// Level, flow at `(t, x)`.
    #[inline(always)]
    fn point(&self, t: f64, x: &[f64]) -> (f64, f64) {
        match KIND {
            RISER => (x[0], self.second_piece.at(t)),
            FLOW => (self.first_piece.at(t), x[0]),
            _ => (x[0], x[1]),
        }
    }

    #[inline(always)]
    fn filling(&self, t: f64, flow: f64) -> f64 {
        if self.riser == Riser::Free {
            (flow - self.first_piece.at(t)) * self.inverse_area
        } else {
            0.0
        }
    }
}

impl<const KIND: u8> System for Line<'_, KIND> {
    #[inline(always)]
    fn dimension(&self) -> usize {
        if KIND == COUPLED { 2 } else { 1 }
    }

    #[inline(always)]
    fn rhs(&self, t: f64, x: &[f64], rate: &mut [f64]) {
        let (level, flow) = self.point(t, x);
        if KIND != FLOW {
            rate[0] = self.filling(t, flow);
        }
        if KIND != RISER {
            let last = rate.len() - 1;
            rate[last] = if self.shut {
                0.0
            } else {
                self.momentum.rate(level, self.second_piece.at(t), flow)
            };
        }
    }

    #[inline(always)]
    fn linearise(&self, t: f64, x: &[f64], _step: f64, out: Linearised<'_>) -> usize {
        let (level, flow) = self.point(t, x);
        let held = self.riser != Riser::Free;
        let area = if held { 0.0 } else { self.inverse_area };
        if KIND == RISER {
            out.rate[0] = self.filling(t, flow);
            out.jacobian[0] = 0.0;
            out.drift[0] = (self.second_piece.slope - self.first_piece.slope) * area;
            return 1;
        }
        let a = if self.shut {
            Acceleration {
                rate: 0.0,
                by_level: 0.0,
                by_flow: 0.0,
                by_speed: 0.0,
            }
        } else {
            self.momentum
                .linearise(level, self.second_piece.at(t), flow)
        };
        if KIND == FLOW {
            out.rate[0] = a.rate;
            out.jacobian[0] = a.by_flow;
            out.drift[0] =
                a.by_speed * self.second_piece.slope + a.by_level * self.first_piece.slope;
        } else {
            out.rate[0] = self.filling(t, flow);
            out.rate[1] = a.rate;
            out.jacobian[0] = 0.0;
            out.jacobian[1] = area;
            out.jacobian[2] = a.by_level;
            out.jacobian[3] = a.by_flow;
            out.drift[0] = -self.first_piece.slope * area;
            out.drift[1] = a.by_speed * self.second_piece.slope;
        }
        1
    }

    #[inline(always)]
    fn begin_segment(&mut self, start: f64, end: f64, x: &[f64]) {
        self.first_piece = self.first.piece(&mut self.first_cursor, start, end);
        self.second_piece = self.second.piece(&mut self.second_cursor, start, end);
        if KIND != RISER {
            self.momentum.refer(self.second_piece.value, x[x.len() - 1]);
        }
    }

    #[inline(always)]
    fn guards(&self) -> usize {
        2
    }

    #[inline(always)]
    fn guard(&self, index: usize, t: f64, x: &[f64]) -> f64 {
        let (level, flow) = self.point(t, x);
        if index == VALVE {
            if KIND == RISER || !self.momentum.line.non_return_valve {
                0.0
            } else if self.shut {
                // Opens as soon as the pump overcomes the standing columns.
                -self.momentum.drive(level, self.second_piece.at(t), 0.0).0
            } else {
                flow
            }
        } else if KIND == FLOW {
            0.0
        } else {
            let net = flow - self.first_piece.at(t);
            match self.riser {
                Riser::Free => level.min(self.momentum.line.inlet_depth_m - level),
                Riser::Full => -net,
                Riser::Empty => net,
            }
        }
    }

    fn cross(&mut self, index: usize, t: f64, x: &mut [f64]) {
        if index == VALVE {
            self.shut = !self.shut;
            let last = x.len() - 1;
            x[last] = 0.0;
            if self.shut {
                self.first_shut_s.get_or_insert(t);
            }
        } else {
            let depth = self.momentum.line.inlet_depth_m;
            self.riser = match self.riser {
                Riser::Free if x[0] < 0.5 * depth => {
                    x[0] = 0.0;
                    self.first_full_s.get_or_insert(t);
                    Riser::Full
                }
                Riser::Free => {
                    x[0] = depth;
                    self.first_empty_s.get_or_insert(t);
                    Riser::Empty
                }
                Riser::Full | Riser::Empty => Riser::Free,
            };
        }
    }
}
