//! What no effect of the catalogue explains: an empirical correction of one relation, or of one reading, along one quantity.

use crate::{
    About, Action, Component, Curve, Effect, Method, Parameter, Place, Quantity, Relation, Role,
    STANDING_M3_S, Search, Setting,
};

/// See the module.
pub(super) struct Unknown;

/// More flows than a meter reads, as a share of that, at the least and the most: one that reads a third of the flow, or three times as much, is no
/// longer one, and knots end there.
const MOST_OFF: (f64, f64) = (-0.67, 2.0);

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
            high: (Place::ALL.len() - 1) as f64,
            usual: 0.0,
            ..Parameter::BASE
        },
        Parameter {
            name: "quantity",
            meaning: "code of the quantity",
            role: Role::Shape(&[]),
            low: 0.0,
            high: (Quantity::ALL.len() - 1) as f64,
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
        let Some(curve) = Curve::read(p) else {
            return Box::new(|_, _| {});
        };
        let (from, to) = (curve.from, curve.to);
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
            let value = curve.at(match curve.quantity {
                Quantity::Time | Quantity::Episode => at.t_s,
                Quantity::InletPressure => at.inlet_pa,
                Quantity::MudPumpFlow => at.mud_pump_m3_s,
                Quantity::BoosterFlow => at.booster_m3_s,
                Quantity::ReturnFlow => at.flow_m3_s,
                Quantity::PumpSpeed => at.speed_pct,
                Quantity::SinceStart => (since / 60.0).ln_1p(),
                // Of a steady ramp its slope, whatever the step.
                Quantity::FlowRate => (now - before) / at.dt_s.max(1e-3),
                Quantity::Period => from + (at.t_s - from).rem_euclid(to - from),
            });
            if !value.is_finite() {
                return;
            }
            let (inlet, outlet) = (&mut changes.inlet_bias_pa, &mut changes.outlet_bias_pa);
            match curve.place {
                Place::Friction if at.flow_m3_s > STANDING_M3_S => changes.line_drop_pa += value,
                Place::Friction => {}
                Place::Head => changes.head_pa += value,
                Place::Balance => changes.inflow_m3_s += value,
                Place::InletReading => *inlet = inlet.map(|p| p + value),
                Place::OutletReading => *outlet = outlet.map(|p| p + value),
                Place::MeterFactor => {
                    changes.meter_gain /= 1.0 + value.clamp(MOST_OFF.0, MOST_OFF.1);
                }
                // The pump lifts from the lower pressure, which its transmitters read.
                Place::Suction => {
                    *inlet = inlet.map(|p| p + value);
                    changes.head_pa += value;
                }
                Place::RiserReading => changes.riser_bias_pa += value,
                Place::FirstInlet => inlet[0] += value,
                Place::SecondInlet => inlet[1] += value,
                Place::FirstOutlet => outlet[0] += value,
                Place::SecondOutlet => outlet[1] += value,
            }
        })
    }

    fn memory_s(&self, _: &[f64]) -> f64 {
        // An hour and a half after a start the knots of its time have ended; the mean of the flow forgets sooner.
        5400.0
    }
}
