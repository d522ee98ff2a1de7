//! Pump wear: internal leakage grows and head is lost slowly.

use crate::{About, Action, Belief, Component, Effect, Parameter, Relation, Role, Search, Setting};

/// See the module.
pub(super) struct PumpWear;

static ABOUT: About = About {
    id: "pump_wear",
    title: "internal leakage of the pump grows and lowers its head",
    component: Component::Pump,
    relation: Relation::PumpHead,
    equation_without: None,
    equation: "p_out - p_in = H(w, q + k t sqrt(p_out - p_in))",
    source: "leakage through wear rings: Gülich 2010, on leakage losses",
    excited_by: "hours at speed",
    confusable: &[
        ("gas_in_pump", "wait: gas passes, wear grows"),
        (
            "viscosity_drift",
            "plot outlet pressure against flow: viscosity changes it, wear does not",
        ),
    ],
    parameters: &[Parameter {
        name: "leak_m3_s",
        meaning: "internal leakage at the end of the recording, at 10 bar",
        role: Role::Amplitude,
        low: 0.0,
        high: 0.05,
        usual: 0.004,
        ..Parameter::BASE
    }],
    search: Search {
        belief: Belief {
            hurdle: 4.0,
            scale: 3.0,
        },
        form_error: 0.4,
        size_error: 0.4,
        ..Search::BASE
    },
};

impl Effect for PumpWear {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn begin(&self, p: &[f64], setting: &Setting) -> Action {
        let leak = p[0];
        let (from, to) = setting.span_s;
        Box::new(move |at, changes| {
            // What was worn before it was identified is in the head's curve.
            let worn = ((at.t_s - from) / (to - from).max(1.0)).max(0.0);
            let lift = (at.outlet_pa - at.inlet_pa).max(0.0) / 1e6;
            if at.pumping {
                changes.recirculation_m3_s += leak * worn * lift.sqrt();
            }
        })
    }

    fn grown(&self, p: &[f64], times: f64) -> Option<Vec<f64>> {
        Some(vec![p[0] * times])
    }

    fn memory_s(&self, _: &[f64]) -> f64 {
        0.0
    }
}
