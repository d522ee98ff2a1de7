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
        let (pump, friction) = (&self.line.pump, &self.line.friction);
        let size = flow.abs();
        let faster = self.speed_power.off(speed, &self.speed_reference);
        if !self.speed_power.is_near(faster) {
            return self.drive_far(level, speed, flow);
        }
        let spun = self.speed_power.parts(faster, &self.speed_reference).sum();
        // Asked for apart: taken together, the compiler packs the two powers in pairs, and the flow's, which
        // everything waits for, is slower for it.
        let more = self.flow_power.off(size, &self.flow_reference);
        if !self.flow_power.is_near(more) {
            return self.drive_far(level, speed, flow);
        }
        let swept = self.flow_power.parts(more, &self.flow_reference);
        let sweep = self.sweep * 1.0_f64.copysign(flow);
        // What waits for no state comes first, then what waits for flow and level, then the terms of the series as they
        // come: the stages of a step depend on each other, so latency is what a simulation pays for.
        let standing = self.rho_g * (pump.c0 * spun - self.rise_m) - friction.b_pa;
        let lifting = (standing - sweep * swept.value) - self.rho_g * level;
        let turning = lifting - (friction.c_pa_s_m3 + self.rho_g * pump.c1 * speed) * flow;
        let known = turning - (flow * size) * (friction.d_pa_s2_m6 + size * friction.e_pa_s3_m9);
        let first = sweep * swept.first;
        let near = (known - first * swept.low) - (first * swept.square) * swept.middle;
        let drive = near - ((first * swept.square) * swept.square) * swept.high;
        (drive, spun, swept.sum())
    }

    /// The same where a power is not near its reference; out of the way, as no usual step but at a shut valve comes here.
    #[cold]
    #[inline(never)]
    fn drive_far(&self, level: f64, speed: f64, flow: f64) -> (f64, f64, f64) {
        let pump = &self.line.pump;
        let spun = self.speed_power.at(speed, &self.speed_reference);
        let swept = self.flow_power.at(flow.abs(), &self.flow_reference);
        let lift = pump.c0 * spun - pump.c1 * speed * flow - level - self.rise_m;
        let known = self.rho_g * lift - self.line.friction.loss_pa(flow);
        (known - self.sweep * swept.copysign(flow), spun, swept)
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
    if x >= f64::MIN_POSITIVE {
        // The division does not wait for the power; below, it would be beyond all numbers.
        (n / x) * power
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

    /// The model as it stands, on other inputs.
    pub(super) fn on<'b>(self, first: Signal<'b>, second: Signal<'b>) -> Line<'b, KIND> {
        Line {
            momentum: self.momentum,
            first,
            second,
            first_cursor: Cursor::default(),
            second_cursor: Cursor::default(),
            first_piece: self.first_piece,
            second_piece: self.second_piece,
            inverse_area: self.inverse_area,
            shut: self.shut,
            riser: self.riser,
            first_full_s: self.first_full_s,
            first_empty_s: self.first_empty_s,
            first_shut_s: self.first_shut_s,
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

    /// Pump speed, %: at the end of a ramp down to 0 rounding makes it less, of which a power is no number.
    #[inline(always)]
    fn speed(&self, t: f64) -> f64 {
        let speed = self.second_piece.at(t);
        // Not `max`, which would hide a NaN.
        if speed < 0.0 { 0.0 } else { speed }
    }

    /// Drive of mud at rest, Pa: the valve opens as soon as the pump overcomes the standing columns.
    ///
    /// Never part of the loop over the steps, which it would swell.
    #[cold]
    #[inline(never)]
    fn standing(&self, t: f64, level: f64) -> f64 {
        self.momentum.drive(level, self.speed(t), 0.0).0
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
                self.momentum.rate(level, self.speed(t), flow)
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
            self.momentum.linearise(level, self.speed(t), flow)
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
                -self.standing(t, level)
            } else {
                flow
            }
        } else if KIND == FLOW {
            0.0
        } else {
            let net = flow - self.first_piece.at(t);
            match self.riser {
                // A nanometre beyond, or rounding alone would cross it there and back without end.
                Riser::Free => level.min(self.momentum.line.inlet_depth_m - level) + 1e-9,
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "test")]
    use super::*;
    use crate::return_line::{Friction, PumpHead};

    fn line() -> ReturnLine {
        ReturnLine {
            density_kg_m3: 1080.0,
            riser_area_m2: 0.17,
            line_area_m2: 0.018,
            inlet_depth_m: 350.0,
            outlet_depth_m: 340.0,
            friction: Friction {
                b_pa: 1e4,
                c_pa_s_m3: 2e5,
                d_pa_s2_m6: 1.3e8,
                e_pa_s3_m9: 2e8,
            },
            pump: PumpHead {
                c0: 0.07,
                c1: 1.5,
                c2: 9e3,
                n0: 1.95,
                n2: 1.6,
            },
            non_return_valve: true,
            b_is_offset: false,
        }
    }

    /// Rate, Jacobian and drift as given, and by differences of the right-hand side.
    fn both<const KIND: u8>(x: &[f64], shut: bool, riser: Riser) -> [Vec<f64>; 2] {
        let n = x.len();
        let (t, level, flow, speed) = ([0.0, 1.0], [150.0, 149.0], [0.05, 0.06], [60.0, 63.0]);
        let (first, second) = match KIND {
            RISER => (&flow, &[0.04, 0.045]),
            FLOW => (&level, &speed),
            _ => (&flow, &speed),
        };
        let signal = |values| Signal::new("u", &t, values, Default::default()).unwrap();
        let mut system = Line::<KIND>::new(&line(), signal(first), signal(second));
        (system.shut, system.riser) = (shut, riser);
        system.begin_segment(0.0, 1.0, x);
        let at = 0.4;
        let (mut rate, mut drift) = (vec![0.0; n], vec![0.0; n]);
        let mut jacobian = vec![0.0; n * n];
        let out = Linearised {
            rate: &mut rate,
            jacobian: &mut jacobian,
            drift: &mut drift,
        };
        assert_eq!(system.linearise(at, x, 1.0, out), 1);
        let of = |t: f64, x: &[f64]| {
            let mut rate = vec![0.0; n];
            system.rhs(t, x, &mut rate);
            rate
        };
        let mut differences = of(at, x);
        let slope = |above: Vec<f64>, below: Vec<f64>, step: f64| -> Vec<f64> {
            let pairs = above.iter().zip(&below);
            pairs.map(|(a, b)| (a - b) / (2.0 * step)).collect()
        };
        let mut columns = vec![0.0; n * n];
        for j in 0..n {
            let step = 1e-5 * x[j].abs();
            let moved = |by: f64| {
                let mut x = x.to_vec();
                x[j] += by;
                of(at, &x)
            };
            for (i, d) in slope(moved(step), moved(-step), step).iter().enumerate() {
                columns[i * n + j] = *d;
            }
        }
        differences.extend(columns);
        differences.extend(slope(of(at + 1e-4, x), of(at - 1e-4, x), 1e-4));
        let given = [rate, jacobian, drift].concat();
        [given, differences]
    }

    fn agree([given, differences]: [Vec<f64>; 2], moves: bool) {
        for (a, b) in given.iter().zip(&differences) {
            // Central differences of 1e-5 leave 1e-10 of the slope and 1e-11 of the rate over 1e-5.
            assert!(
                (a - b).abs() < 1e-6 * b.abs() + 1e-9,
                "{given:?} {differences:?}"
            );
        }
        assert_eq!(given.iter().any(|v| *v != 0.0), moves);
    }

    #[test]
    fn the_derivatives_given_are_those_of_the_right_hand_side() {
        for riser in [Riser::Free, Riser::Full, Riser::Empty] {
            let held = riser != Riser::Free;
            for shut in [false, true] {
                agree(
                    both::<COUPLED>(&[150.0, 0.05], shut, riser),
                    !(shut && held),
                );
                agree(both::<FLOW>(&[0.05], shut, riser), !shut);
                agree(both::<RISER>(&[150.0], shut, riser), !held);
            }
        }
    }

    #[test]
    fn a_drive_far_from_its_references_is_the_same_drive() {
        let mut momentum = Momentum::new(&line());
        assert!(momentum.rise_m != 0.0);
        for (level, speed, flow) in [
            (150.0, 60.0, 0.05),
            (20.0, 35.0, -0.02),
            (300.0, 90.0, 0.08),
        ] {
            momentum.refer(speed, flow);
            let near = momentum.drive(level, speed, flow);
            let far = momentum.drive_far(level, speed, flow);
            assert!(
                (near.0 - far.0).abs() < 1e-9 * far.0.abs(),
                "{near:?} {far:?}"
            );
            assert_eq!((near.1, near.2), (far.1, far.2));
        }
    }

    #[test]
    fn a_power_has_its_slope_at_rest_too() {
        assert_eq!(slope(8.0, 2.0, 3.0), 12.0);
        assert_eq!((slope(0.0, 0.0, 1.0), slope(0.0, 0.0, 1.6)), (1.0, 0.0));
    }
}
