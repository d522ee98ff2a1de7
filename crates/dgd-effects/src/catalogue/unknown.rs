//! What no effect of the catalogue explains: an empirical correction of one relation, or of one reading, along one quantity.

use crate::{
    About, Action, Component, Effect, Method, Parameter, Relation, Role, STANDING_M3_S, Search,
    Setting,
};

/// See the module.
pub(super) struct Unknown;

/// Knots of a correction, at the least: a finer curve has more.
pub const KNOTS: usize = 12;

/// What a correction is made to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Where it sits.
    pub relation: Relation,
    /// Its name, for people.
    pub name: &'static str,
    /// The relations whose residuals it enters; none, where only its neighbour tells of it.
    pub shows_in: &'static [Relation],
    /// A reading and what it should be; empty for a relation, which has its own equation.
    pub reading: &'static str,
    /// Prior width of a knot, in its unit: Pa, m³/s, or a share of the flow.
    pub width: f64,
    /// Size up to which it is within the accuracy of instruments, in the same unit.
    pub least: f64,
}

/// What can be corrected, in the order of the codes: relations, readings, which enter several, and what lies between readings.
pub const PLACES: [Place; 12] = [
    Place {
        relation: Relation::ReturnLineFriction,
        name: "return line friction",
        shows_in: &[Relation::ReturnLineFriction],
        reading: "",
        width: 1.5e4,
        least: 3e3,
    },
    Place {
        relation: Relation::PumpHead,
        name: "pump head",
        shows_in: &[Relation::PumpHead],
        reading: "",
        width: 2.0e4,
        least: 6e3,
    },
    Place {
        relation: Relation::RiserMassBalance,
        name: "riser mass balance",
        shows_in: &[Relation::RiserMassBalance],
        reading: "",
        width: 8e-4,
        least: 1.5e-4,
    },
    Place {
        relation: Relation::Instrument,
        name: "the reading of the pump inlet transmitters",
        shows_in: &[Relation::PumpHead, Relation::RiserMassBalance],
        reading: "p_meter = p_in",
        width: 1.5e4,
        least: 6e3,
    },
    Place {
        relation: Relation::Instrument,
        name: "the reading of the pump outlet transmitters",
        shows_in: &[Relation::ReturnLineFriction, Relation::PumpHead],
        reading: "p_meter = p_out",
        width: 1.5e4,
        least: 6e3,
    },
    Place {
        relation: Relation::Instrument,
        name: "the factor of the return flow meter",
        shows_in: &[
            Relation::RiserMassBalance,
            Relation::ReturnLineFriction,
            Relation::PumpHead,
        ],
        reading: "q / q_meter = 1",
        width: 0.02,
        least: 4e-3,
    },
    // Two transmitters tell of it, and that they do not wander is asked for by itself.
    Place {
        relation: Relation::Instrument,
        name: "the pressure between riser and pump inlet",
        shows_in: &[Relation::RiserMassBalance],
        reading: "p_riser - p_in - k rho v^2 / 2 = constant",
        width: 1.5e4,
        least: 2.5e3,
    },
    Place {
        relation: Relation::Instrument,
        name: "the reading of the riser transmitter",
        shows_in: &[],
        reading: "p_meter = p_riser",
        width: 1.5e4,
        least: 2.5e3,
    },
    Place {
        name: "the reading of the first pump inlet transmitter",
        ..ONE_INLET
    },
    Place {
        name: "the reading of the second pump inlet transmitter",
        ..ONE_INLET
    },
    Place {
        name: "the reading of the first pump outlet transmitter",
        ..ONE_OUTLET
    },
    Place {
        name: "the reading of the second pump outlet transmitter",
        ..ONE_OUTLET
    },
];

/// One of two at the pump inlet, whose mean the relations hold.
const ONE_INLET: Place = Place {
    relation: Relation::Instrument,
    name: "",
    shows_in: &[Relation::PumpHead, Relation::RiserMassBalance],
    reading: "p_meter = p_in",
    width: 1.5e4,
    least: 2.5e3,
};

/// One of two at the pump outlet, whose difference is a relation of its own.
const ONE_OUTLET: Place = Place {
    relation: Relation::Instrument,
    name: "",
    shows_in: &[
        Relation::ReturnLineFriction,
        Relation::PumpHead,
        Relation::Instrument,
    ],
    reading: "p_meter = p_out",
    width: 1.5e4,
    least: 2.5e3,
};

/// Place of the return line's friction in [`PLACES`].
pub const FRICTION: usize = 0;
/// Place of the pump's head in [`PLACES`].
pub const HEAD: usize = 1;
/// Place of the riser's mass balance in [`PLACES`].
pub const BALANCE: usize = 2;
/// Place of the reading of the pump inlet transmitters in [`PLACES`].
pub const INLET_READING: usize = 3;
/// Place of the reading of the pump outlet transmitters in [`PLACES`].
pub const OUTLET_READING: usize = 4;
/// Place of the factor of the return flow meter, true over indicated flow, in [`PLACES`].
pub const METER_FACTOR: usize = 5;
/// Place of what is lost between the riser and the pump's inlet in [`PLACES`].
pub const SUCTION: usize = 6;
/// Place of the reading of the riser's transmitter in [`PLACES`].
pub const RISER_READING: usize = 7;
/// Places of the readings of the first and the second pump inlet transmitter in [`PLACES`].
pub const INLETS: [usize; 2] = [8, 9];
/// Places of the readings of the first and the second pump outlet transmitter in [`PLACES`].
pub const OUTLETS: [usize; 2] = [10, 11];

/// A meter that reads by half too much or too little is no longer one: knots end there.
const MOST_OFF: f64 = 0.5;

/// Something along which a relation or reading is corrected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Quantity {
    /// Its name.
    pub name: &'static str,
    /// Its name with the SI unit.
    pub si_name: &'static str,
}

/// Place of the time in [`QUANTITIES`].
pub const TIME: usize = 0;
/// Place of the pump inlet pressure in [`QUANTITIES`].
pub const INLET_PRESSURE: usize = 1;
/// Place of the mud pump flow in [`QUANTITIES`].
pub const MUD_PUMP_FLOW: usize = 2;
/// Place of the booster flow in [`QUANTITIES`].
pub const BOOSTER_FLOW: usize = 3;
/// Place of the return flow in [`QUANTITIES`].
pub const RETURN_FLOW: usize = 4;
/// Place of the pump's speed in [`QUANTITIES`].
pub const PUMP_SPEED: usize = 5;
/// Place of the time since the pump started in [`QUANTITIES`]: knots lie evenly along `ln(1 + minutes)`.
pub const SINCE_START: usize = 6;
/// Place of the rate of the return flow in [`QUANTITIES`].
pub const FLOW_RATE: usize = 7;
/// Place of the time within its period in [`QUANTITIES`]: knots go from the beginning of the first one to its end, and round again.
pub const PERIOD: usize = 8;

/// Quantities along which a relation or reading is corrected, in the order of their codes.
pub const QUANTITIES: [Quantity; 9] = {
    const fn of(name: &'static str, si_name: &'static str) -> Quantity {
        Quantity { name, si_name }
    }
    let mut all = [of("", ""); 9];
    all[TIME] = of("time", "time_s");
    all[INLET_PRESSURE] = of("inlet pressure", "inlet_pressure_pa");
    all[MUD_PUMP_FLOW] = of("mud pump flow", "mud_pump_flow_m3_s");
    all[BOOSTER_FLOW] = of("booster flow", "booster_flow_m3_s");
    all[RETURN_FLOW] = of("return flow", "return_flow_m3_s");
    all[PUMP_SPEED] = of("pump speed", "pump_speed_pct");
    all[SINCE_START] = of("time since the pump started", "time_since_start_s");
    all[FLOW_RATE] = of("rate of the return flow", "return_flow_rate_m3_s2");
    all[PERIOD] = of("time within its period", "time_within_period_s");
    all
};

const fn knot(name: &'static str) -> Parameter {
    Parameter {
        name,
        meaning: "correction at a knot, Pa, m3/s or share of the flow",
        role: Role::Shape(&[]),
        low: f64::NEG_INFINITY,
        high: f64::INFINITY,
        usual: 0.0,
        ..Parameter::BASE
    }
}

static ABOUT: About = About {
    id: "unknown",
    title: "a cause outside the catalogue",
    component: Component::Boundary,
    relation: Relation::Momentum,
    equation_without: None,
    equation: "relation + sum c_k hat_k(x)",
    source: "discrepancy beside the model: Kennedy and O'Hagan 2001, there a Gaussian process; here piecewise linear along the quantity that explains most",
    excited_by: "any recording",
    confusable: &[],
    parameters: &[
        Parameter {
            name: "relation",
            meaning: "0 line friction, 1 pump head, 2 riser mass balance, 3 inlet reading, 4 outlet reading, 5 return meter factor, 6 suction, 7 \
                      riser reading, 8 and 9 single inlets, 10 and 11 single outlets",
            role: Role::Shape(&[]),
            low: 0.0,
            high: 11.0,
            usual: 0.0,
            ..Parameter::BASE
        },
        Parameter {
            name: "quantity",
            meaning: "code of the quantity",
            role: Role::Shape(&[]),
            low: 0.0,
            high: 8.0,
            usual: 0.0,
            ..Parameter::BASE
        },
        Parameter {
            name: "from",
            meaning: "first knot",
            role: Role::Shape(&[]),
            low: f64::NEG_INFINITY,
            high: f64::INFINITY,
            usual: 0.0,
            ..Parameter::BASE
        },
        Parameter {
            name: "to",
            meaning: "last knot",
            role: Role::Shape(&[]),
            low: f64::NEG_INFINITY,
            high: f64::INFINITY,
            usual: 0.0,
            ..Parameter::BASE
        },
        knot("c0"),
        knot("c1"),
        knot("c2"),
        knot("c3"),
        knot("c4"),
        knot("c5"),
        knot("c6"),
        knot("c7"),
        knot("c8"),
        knot("c9"),
        knot("c10"),
        knot("c11"),
    ],
    search: Search {
        method: Method::Correction,
        ..Search::BASE
    },
};

impl Effect for Unknown {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn takes(&self, parameters: usize) -> bool {
        parameters >= ABOUT.parameters.len()
    }

    fn begin(&self, p: &[f64], _: &Setting) -> Action {
        let values = p[4..].to_vec();
        let last = values.len().saturating_sub(1);
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "small codes; what is none becomes too large a one"
        )]
        let [place, quantity] = [p[0], p[1]].map(|code| {
            if code >= 0.0 {
                code.round() as usize
            } else {
                usize::MAX
            }
        });
        let (from, to) = (p[2], p[3]);
        let mut since = 3600.0_f64;
        let mut slow: Option<f64> = None;
        Box::new(move |at, changes| {
            since = if at.pumping { since + at.dt_s } else { 0.0 };
            let before = slow.unwrap_or(at.flow_m3_s);
            let now = before + (at.dt_s / 20.0).min(1.0) * (at.flow_m3_s - before);
            // A gap in the flow must not stay in the memory.
            if now.is_finite() {
                slow = Some(now);
            }
            let x = match quantity {
                TIME => at.t_s,
                INLET_PRESSURE => at.inlet_pa,
                MUD_PUMP_FLOW => at.mud_pump_m3_s,
                BOOSTER_FLOW => at.booster_m3_s,
                RETURN_FLOW => at.flow_m3_s,
                PUMP_SPEED => at.speed_pct,
                SINCE_START => (since / 60.0).ln_1p(),
                FLOW_RATE => (at.flow_m3_s - now) / 20.0,
                PERIOD => from + (at.t_s - from).rem_euclid(to - from),
                _ => return,
            };
            let position = ((x - from) / (to - from) * last as f64).clamp(0.0, last as f64);
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "clamped; a NaN becomes 0"
            )]
            let low = (position.floor() as usize).min(last.saturating_sub(1));
            let share = position - low as f64;
            let [below, above] = [low, low + 1].map(|k| values.get(k).copied().unwrap_or(0.0));
            let value = below + share * (above - below);
            if !value.is_finite() {
                return;
            }
            match place {
                FRICTION if at.flow_m3_s > STANDING_M3_S => changes.line_drop_pa += value,
                HEAD => changes.head_pa += value,
                BALANCE => changes.inflow_m3_s += value,
                INLET_READING => changes.inlet_bias_pa = changes.inlet_bias_pa.map(|p| p + value),
                OUTLET_READING => {
                    changes.outlet_bias_pa = changes.outlet_bias_pa.map(|p| p + value)
                }
                METER_FACTOR => changes.meter_gain /= 1.0 + value.clamp(-MOST_OFF, MOST_OFF),
                // The pump lifts from the lower pressure, which its transmitters read.
                SUCTION => {
                    changes.inlet_bias_pa = changes.inlet_bias_pa.map(|p| p + value);
                    changes.head_pa += value;
                }
                RISER_READING => changes.riser_bias_pa += value,
                place if INLETS.contains(&place) => {
                    changes.inlet_bias_pa[place - INLETS[0]] += value
                }
                place if OUTLETS.contains(&place) => {
                    changes.outlet_bias_pa[place - OUTLETS[0]] += value
                }
                _ => {}
            }
        })
    }

    fn memory_s(&self, _: &[f64]) -> f64 {
        // An hour and a half after a start the knots of its time have ended; the mean of the flow forgets sooner.
        5400.0
    }
}
