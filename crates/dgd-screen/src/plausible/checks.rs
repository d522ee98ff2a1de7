//! What must hold between the channels of a rig, however it is run.

use super::facts::{median, quantile};
use super::state::State;
use dgd_recording::Channel;
use dgd_units::STANDARD_ATMOSPHERE_PA;

/// Offset of a transmitter that is a fault to diagnose and not a wrong unit, Pa.
const BIAS_PA: f64 = 5e5;
/// Mud may be lighter or heavier than described, by gas, cuttings or another fill.
const LIGHTER: f64 = 0.7;
const HEAVIER: f64 = 1.2;
/// Darcy's friction factor of a line that is rough beyond reason, with its fittings.
const MOST_FRICTION: f64 = 0.18;
/// Friction factors that a line can show.
const FRICTION_FACTOR: (f64, f64) = (0.003, 0.25);
/// What comes back of what is pumped in, with losses, influx and gains of meters.
pub(super) const RETURNED: (f64, f64) = (0.6, 1.67);
/// How far the level moves for the volume that the flows leave in the riser.
const MOVES: (f64, f64) = (0.3, 4.0);
/// Correlation from which a slope says anything.
const SLOPE_CORRELATION: f64 = 0.7;
/// Highest flow that a rig pumps, m³/s: 30,000 L/min.
const FLOW_M3_S: f64 = 0.5;
/// How far a pump's outlet may lie from its inlet, m, and as a share of the deeper one.
const APART_M: f64 = 50.0;
const APART: f64 = 0.2;
/// Densities of mud, kg/m³.
const DENSITY_KG_M3: (f64, f64) = (700.0, 2600.0);
/// Highest speed of a pump in percent, and the highest that must be a share of one.
const SPEED_PCT: f64 = 125.0;
const SPEED_SHARE: f64 = 1.2;
/// Correlation of head and squared speed below which the speed is another channel's.
const LIFTS_CORRELATION: f64 = 0.4;
/// Variation of the head that a pump must have shown before that, Pa.
const LIFTS_PA: f64 = 3e5;
/// Steps of a rig's recorder, s.
const STEP_S: (f64, f64) = (0.005, 300.0);

/// What is checked; the numbers are places in [`super::facts::Facts::told`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Check {
    /// A pressure against the column of mud above it.
    Column(usize),
    /// Two transmitters of one side.
    Twins(usize, usize),
    /// The riser's transmitter against the inlet's.
    Riser(usize),
    /// Median of a flow.
    Flow(usize),
    /// Depth of the pump's outlet below that of its inlet.
    Apart,
    /// The pump raises the pressure.
    Rise,
    /// Return flow over inflow.
    Returned,
    /// Movement of the level over that of the flows.
    Moves,
    /// Darcy's friction factor of the return line.
    Friction,
    /// Correlation of the head with the square of the pump's speed.
    Lifts,
    /// Pump speed.
    Speed,
    /// Step of the clock.
    Step,
    /// Density of the mud.
    Density,
}

impl Check {
    /// Whether it is one of pressures beside each other and the mud, whatever flows.
    pub(super) fn is_of_pressures(self) -> bool {
        matches!(
            self,
            Self::Column(_) | Self::Twins(..) | Self::Riser(_) | Self::Rise
        )
    }
}

/// A check that does not hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fault {
    pub(super) check: Check,
    pub(super) found: f64,
    pub(super) low: f64,
    pub(super) high: f64,
}

/// Every check that does not hold.
pub(super) fn faults(state: &State<'_>) -> Vec<Fault> {
    let mut faults = Vec::new();
    let mut range = |check, found: f64, (low, high): (f64, f64)| {
        if found < low || found > high {
            faults.push(Fault {
                check,
                found,
                low,
                high,
            });
        }
    };
    range(Check::Step, state.step_s(), STEP_S);
    range(Check::Density, state.density_kg_m3, DENSITY_KG_M3);
    let geometry = &state.geometry;
    let (inlet_m, outlet_m) = (geometry.pump_inlet_depth_m, geometry.pump_outlet_depth_m);
    let far = APART_M.max(APART * inlet_m.max(outlet_m));
    range(Check::Apart, outlet_m - inlet_m, (-far, far));
    let flowing = state.flowing();
    let (inlets, outlets) = (state.inlets(), state.outlets());
    let over = |told: &[usize]| median(flowing.iter().map(|k| state.mean_of(told, *k)));
    let (inlet_pa, outlet_pa) = (over(&inlets), over(&outlets));
    range(Check::Rise, outlet_pa - inlet_pa, (0.0, f64::INFINITY));
    for i in state.pressures() {
        range(
            Check::Column(i),
            state.median(i, &flowing),
            column(state, i, &flowing),
        );
    }
    for side in [&inlets, &outlets] {
        for (n, a) in side.iter().enumerate() {
            for b in &side[n + 1..] {
                let (one, other) = (state.median(*a, &flowing), state.median(*b, &flowing));
                let far = BIAS_PA.max(0.2 * one.max(other));
                range(Check::Twins(*a, *b), one - other, (-far, far));
            }
        }
    }
    if let Some(i) = state.facts.find(Channel::RiserPressure) {
        let depth_m = geometry.riser_pressure_sensor_depth_m;
        let deeper_m = depth_m.map_or(0.0, |d| d - geometry.pump_inlet_depth_m);
        let apart = state.median(i, &flowing) - state.weight_pa_m() * deeper_m - inlet_pa;
        let far = BIAS_PA.max(0.2 * inlet_pa);
        range(Check::Riser(i), apart, (-far, far));
    }
    range(Check::Returned, returned(state, &inlets), RETURNED);
    range(Check::Moves, moves(state, &inlets), MOVES);
    range(
        Check::Friction,
        friction_factor(state, &outlets, &flowing),
        FRICTION_FACTOR,
    );
    if let Some(i) = state.facts.find(Channel::PumpSpeed) {
        let high = quantile(state.values(i), 0.95);
        let expected = if high > 0.02 && high <= SPEED_SHARE {
            (SPEED_SHARE, SPEED_PCT)
        } else {
            (f64::NEG_INFINITY, SPEED_PCT)
        };
        range(Check::Speed, high, expected);
        let lifts = lifts(state, i, (&inlets, &outlets), &flowing);
        range(Check::Lifts, lifts, (LIFTS_CORRELATION, 1.0));
    }
    // What comes back of it tells more, where it is at fault as well.
    for i in state.flows() {
        range(
            Check::Flow(i),
            state.median(i, &flowing),
            (f64::NEG_INFINITY, FLOW_M3_S),
        );
    }
    faults
}

/// Lowest and highest pressure that the mud above a transmitter can give it, Pa.
fn column(state: &State<'_>, told: usize, flowing: &[usize]) -> (f64, f64) {
    let geometry = &state.geometry;
    let full = |depth_m| {
        let column_pa = state.column_pa(depth_m) - STANDARD_ATMOSPHERE_PA;
        (column_pa, STANDARD_ATMOSPHERE_PA + HEAVIER * column_pa)
    };
    match state.facts.told[told].channel {
        Channel::PumpOutletPressure(_) => {
            let (column_pa, highest) = full(geometry.pump_outlet_depth_m);
            let friction_pa = friction(state, flowing);
            (
                STANDARD_ATMOSPHERE_PA + LIGHTER * column_pa - 1e5,
                highest + friction_pa + 2.0 * BIAS_PA,
            )
        }
        Channel::RiserPressure => {
            let depth_m = geometry.riser_pressure_sensor_depth_m;
            let (_, highest) = full(depth_m.unwrap_or(geometry.pump_inlet_depth_m));
            (0.9 * STANDARD_ATMOSPHERE_PA, highest + 0.6 * BIAS_PA)
        }
        _ => {
            let (_, highest) = full(geometry.pump_inlet_depth_m);
            (0.9 * STANDARD_ATMOSPHERE_PA, highest + 0.6 * BIAS_PA)
        }
    }
}

/// Friction that the line can have at most, Pa, by the flow that more than one meter tells of.
fn friction(state: &State<'_>, flowing: &[usize]) -> f64 {
    let back = median(flowing.iter().map(|k| state.return_flow(*k)));
    let pumped = median(flowing.iter().map(|k| state.inflow(*k)));
    let velocity = back.min(pumped) / state.geometry.line_area_m2();
    let geometry = &state.geometry;
    let lengths = geometry.pump_outlet_depth_m / geometry.return_line_id_m;
    let found = MOST_FRICTION * lengths * 0.5 * state.density_kg_m3 * velocity * velocity;
    // A diameter or a flow in another unit must not excuse a pressure in another unit.
    let most = 2.0 * state.weight_pa_m() * geometry.pump_outlet_depth_m + 4.0 * BIAS_PA;
    if found.is_finite() {
        found.min(most)
    } else {
        0.0
    }
}

/// Volume that came back over the volume pumped in, less what the level made of it.
fn returned(state: &State<'_>, inlets: &[usize]) -> f64 {
    let blocks = (0..state.blocks())
        .filter(|k| state.inflow(*k).is_finite() && state.return_flow(*k).is_finite());
    let (mut pumped_m3, mut back_m3) = (0.0, 0.0);
    for k in blocks {
        pumped_m3 += state.inflow(k) * state.block_s();
        back_m3 += state.return_flow(k) * state.block_s();
    }
    let mut levels = (0..state.blocks())
        .map(|k| state.mean_of(inlets, k))
        .filter(|p| p.is_finite());
    let first = levels.next().unwrap_or(f64::NAN);
    let drawn_m3 = match levels.next_back() {
        Some(last) => state.geometry.riser_area_m2() * (first - last) / state.weight_pa_m(),
        None => 0.0,
    };
    // A level that says more than the flows is in another unit itself.
    let most_m3 = 0.3 * pumped_m3.abs();
    let drawn_m3 = drawn_m3.min(most_m3).max(-most_m3);
    let expected_m3 = pumped_m3 + drawn_m3;
    if expected_m3 > 0.0 && back_m3 > 0.0 {
        back_m3 / expected_m3
    } else {
        f64::NAN
    }
}

/// Movement of the level over the one that the flows make (Eq. 3.45), as near to 1 as it may be; NaN where noise hides it.
pub(super) fn moves(state: &State<'_>, inlets: &[usize]) -> f64 {
    let net = |k| state.return_flow(k) - state.inflow(k);
    let metres_a_flow = state.block_s() / state.geometry.riser_area_m2();
    let pairs = (1..state.blocks()).map(|k| {
        let expected_m = 0.5 * (net(k - 1) + net(k)) * metres_a_flow;
        let drop_pa = state.mean_of(inlets, k - 1) - state.mean_of(inlets, k);
        (expected_m, drop_pa / state.weight_pa_m())
    });
    Line::through(pairs).map_or(f64::NAN, |line| line.slope_from(1.0))
}

/// Darcy's friction factor by the slope of outlet pressure over q², as near to what a line can show as it may be; NaN where flow does not
/// explain it.
fn friction_factor(state: &State<'_>, outlets: &[usize], flowing: &[usize]) -> f64 {
    let pairs = flowing.iter().map(|k| {
        let flow = state.return_flow(*k);
        (flow * flow.abs(), state.mean_of(outlets, *k))
    });
    let geometry = &state.geometry;
    let slope_of_one = state.density_kg_m3 * geometry.pump_outlet_depth_m
        / (2.0 * geometry.line_area_m2().powi(2) * geometry.return_line_id_m);
    Line::through(pairs).map_or(f64::NAN, |line| {
        let slope = line.slope / slope_of_one;
        Line { slope, ..line }.slope_from(FRICTION_FACTOR.0)
    })
}

/// How much closer the outlet pressure follows an inflow than the return flow, where it follows
/// that one as only the flow through the line can be followed.
pub(super) fn through(state: &State<'_>) -> Option<(usize, f64)> {
    const CLOSER: f64 = 4.0;
    const CORRELATION: f64 = 0.98;
    let (outlets, flowing) = (state.outlets(), state.flowing());
    let left = |told: usize| {
        let square = |k: &usize| {
            let flow = state.value(told, *k);
            (flow * flow.abs(), state.mean_of(&outlets, *k))
        };
        let line = Line::through(flowing.iter().map(square))?;
        let residual = |k: &usize| {
            let (x, y) = square(k);
            (y - line.middle.1 - line.slope * (x - line.middle.0)).abs()
        };
        Some((line.correlation, median(flowing.iter().map(residual))))
    };
    let (_, own) = left(state.facts.find(Channel::ReturnFlow)?)?;
    let others = state.inflows().into_iter().filter_map(|i| {
        let (correlation, other) = left(i)?;
        (correlation > CORRELATION && own > CLOSER * other).then_some((i, own / other))
    });
    others.max_by(|a, b| a.1.total_cmp(&b.1))
}

/// Correlation of the pump's head with the square of its speed; NaN where the head hardly moves.
fn lifts(
    state: &State<'_>,
    speed: usize,
    (inlets, outlets): (&[usize], &[usize]),
    flowing: &[usize],
) -> f64 {
    let head = |k: &usize| state.mean_of(outlets, *k) - state.mean_of(inlets, *k);
    let heads = || flowing.iter().map(head);
    if quantile(heads(), 0.95) - quantile(heads(), 0.05) < LIFTS_PA {
        return f64::NAN;
    }
    let pairs = flowing
        .iter()
        .map(|k| (state.value(speed, *k).powi(2), head(k)));
    Line::through(pairs).map_or(f64::NAN, |line| line.correlation)
}

/// A straight line through points.
struct Line {
    slope: f64,
    correlation: f64,
    middle: (f64, f64),
}

impl Line {
    /// `None` for fewer than twelve finite points or none that differ.
    fn through(points: impl Iterator<Item = (f64, f64)>) -> Option<Self> {
        const FEWEST: usize = 12;
        let points: Vec<(f64, f64)> = points
            .filter(|(x, y)| x.is_finite() && y.is_finite())
            .collect();
        if points.len() < FEWEST {
            return None;
        }
        let n = points.len() as f64;
        let (x, y) = points
            .iter()
            .fold((0.0, 0.0), |(x, y), p| (x + p.0, y + p.1));
        let middle = (x / n, y / n);
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for (x, y) in &points {
            let (x, y) = (x - middle.0, y - middle.1);
            xx += x * x;
            xy += x * y;
            yy += y * y;
        }
        (xx > 0.0 && yy > 0.0).then(|| Self {
            slope: xy / xx,
            correlation: xy / (xx * yy).sqrt(),
            middle,
        })
    }

    /// The least slope from `expected` on that it may have, or else the most; NaN where noise hides it.
    ///
    /// Noise of x makes the slope of y upon x too small, and noise of y that of x upon y too large: the true one lies between the two.
    fn slope_from(&self, expected: f64) -> f64 {
        if self.correlation < SLOPE_CORRELATION {
            return f64::NAN;
        }
        let (least, most) = (self.slope, self.slope / self.correlation.powi(2));
        least.max(expected).min(most)
    }
}
