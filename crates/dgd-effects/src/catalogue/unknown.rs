//! What no effect of the catalogue explains: an empirical correction of one relation, or of one reading, along one quantity.

use crate::{
    About, Action, Component, Effect, Extent, Method, Parameter, Relation, Role, Search, Setting,
};

/// See the module.
pub(super) struct Unknown;

/// Knots of the correction.
pub const KNOTS: usize = 12;

/// What a correction is made to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    /// Where it sits.
    pub relation: Relation,
    /// Its name, for people.
    pub name: &'static str,
    /// The relations whose residuals it enters.
    pub shows_in: &'static [Relation],
    /// A reading and what it should be; empty for a relation, which has its own equation.
    pub reading: &'static str,
}

/// What can be corrected, in the order of the codes: relations, then readings, which enter several.
pub const PLACES: [Place; 5] = [
    Place {
        relation: Relation::ReturnLineFriction,
        name: "return line friction",
        shows_in: &[Relation::ReturnLineFriction],
        reading: "",
    },
    Place {
        relation: Relation::PumpHead,
        name: "pump head",
        shows_in: &[Relation::PumpHead],
        reading: "",
    },
    Place {
        relation: Relation::RiserMassBalance,
        name: "riser mass balance",
        shows_in: &[Relation::RiserMassBalance],
        reading: "",
    },
    Place {
        relation: Relation::Instrument,
        name: "the reading of the pump inlet transmitters",
        shows_in: &[Relation::PumpHead, Relation::RiserMassBalance],
        reading: "p_meter = p_in",
    },
    Place {
        relation: Relation::Instrument,
        name: "the reading of the pump outlet transmitters",
        shows_in: &[Relation::ReturnLineFriction, Relation::PumpHead],
        reading: "p_meter = p_out",
    },
];

/// Place of the reading of the pump inlet transmitters in [`PLACES`].
pub const INLET_READING: usize = 3;

/// Quantities along which a relation or reading is corrected, in the order of their codes.
pub const QUANTITIES: [&str; 8] = [
    "time",
    "inlet pressure",
    "mud pump flow",
    "booster flow",
    "return flow",
    "pump speed",
    "time since the pump started",
    "rate of the return flow",
];

const fn knot(name: &'static str) -> Parameter {
    Parameter {
        name,
        meaning: "correction at a knot, Pa or m3/s",
        role: Role::Shape(&[]),
        low: f64::NEG_INFINITY,
        high: f64::INFINITY,
        usual: 0.0,
        ..Parameter::BASE
    }
}

static ABOUT: About = About {
    id: "unknown",
    title: "none of the catalogue's effects",
    component: Component::Boundary,
    relation: Relation::Momentum,
    equation: "relation + sum c_k hat_k(x)",
    source: "discrepancy beside the model: Kennedy and O'Hagan 2001, there a Gaussian process; here piecewise linear along the quantity that explains most",
    excited_by: "any recording",
    confusable: &[],
    parameters: &[
        Parameter {
            name: "relation",
            meaning: "0 line friction, 1 pump head, 2 riser mass balance, 3 inlet reading, 4 outlet reading",
            role: Role::Shape(&[]),
            low: 0.0,
            high: 4.0,
            usual: 0.0,
            ..Parameter::BASE
        },
        Parameter {
            name: "quantity",
            meaning: "code of the quantity",
            role: Role::Shape(&[]),
            low: 0.0,
            high: 7.0,
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
    extent: Extent::Always,
    search: Search {
        method: Method::Correction,
        ..Search::BASE
    },
};

impl Effect for Unknown {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn begin(&self, p: &[f64], _: &Setting) -> Action {
        let mut values = [0.0; KNOTS];
        values.copy_from_slice(&p[4..4 + KNOTS]);
        let (relation, quantity, from, to) = (p[0], p[1], p[2], p[3]);
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
            #[allow(clippy::cast_possible_truncation, reason = "a small code")]
            let x = match quantity as i64 {
                0 => at.t_s,
                1 => at.inlet_pa,
                2 => at.mud_pump_m3_s,
                3 => at.booster_m3_s,
                4 => at.flow_m3_s,
                5 => at.speed_pct,
                6 => (since / 60.0).ln_1p(),
                _ => (at.flow_m3_s - now) / 20.0,
            };
            let position =
                ((x - from) / (to - from) * (KNOTS - 1) as f64).clamp(0.0, (KNOTS - 1) as f64);
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "clamped; a NaN becomes 0"
            )]
            let low = (position.floor() as usize).min(KNOTS - 2);
            let share = position - low as f64;
            let value = values[low] + share * (values[low + 1] - values[low]);
            if !value.is_finite() {
                return;
            }
            #[allow(clippy::cast_possible_truncation, reason = "a small code")]
            match relation as i64 {
                0 => {
                    if at.flow_m3_s > 1e-3 {
                        changes.line_drop_pa += value;
                    }
                }
                1 => changes.head_pa += value,
                2 => changes.inflow_m3_s += value,
                3 => changes.inlet_bias_pa += value,
                _ => {
                    changes.outlet_bias_pa[0] += value;
                    changes.outlet_bias_pa[1] += value;
                }
            }
        })
    }

    fn memory_s(&self, _: &[f64]) -> f64 {
        // An hour and a half after a start the knots of its time have ended; the mean of the flow forgets sooner.
        5400.0
    }
}
