//! U-tubing: the drill string gives its mud late.

use crate::moment::{Lag, lagging};
use crate::shrunk;
use crate::{
    About, Action, Belief, Component, Effect, Excitation, Parameter, Relation, Role, Search,
    Setting,
};

/// See the module.
pub(super) struct UTube;

static ABOUT: About = About {
    id: "u_tube",
    title: "the drill string drains after the mud pump slows and fills when it starts",
    component: Component::Line,
    relation: Relation::RiserMassBalance,
    equation_without: Some("q_string = q_mud_pump"),
    equation: "tau dq_string/dt = q_mud_pump - q_string; draining s tau dq_string/dt = (1 - e) (q_mud_pump - q_string) - e q_0/2",
    source: "Slettebø 2015, Eqs. 2.29 and 2.34, reduced to one time constant; evenly as by Torricelli's law, through nozzles",
    excited_by: "starts and stops of the mud pump",
    confusable: &[
        ("booster_line_storage", "step the booster flow alone"),
        ("pipe_displacement", "make a connection without moving pipe"),
    ],
    parameters: &[
        Parameter {
            name: "tau_s",
            meaning: "time constant of the string",
            role: Role::Grid(&[
                3.0, 5.0, 8.0, 12.0, 18.0, 24.0, 32.0, 42.0, 55.0, 70.0, 90.0, 120.0,
            ]),
            low: 0.0,
            high: 600.0,
            usual: 40.0,
            ..Parameter::BASE
        },
        Parameter {
            name: "drains",
            meaning: "share of the string volume that drains when the pump stops",
            // A valve in the string may shut; what it holds back fills the stand that is added.
            role: Role::Shape(&[0.2, 0.5, 1.0]),
            low: 0.02,
            high: 2.0,
            usual: 1.0,
            ..Parameter::BASE
        },
        Parameter {
            name: "evenly",
            meaning: "how evenly it drains: 0 in proportion to its flow, 1 at a constant rate",
            role: Role::Shape(&[0.0, 1.0]),
            low: 0.0,
            high: 1.0,
            usual: 0.0,
            ..Parameter::BASE
        },
    ],
    search: Search {
        least: Some(7.5),
        form_error: 0.1,
        size_error: 0.1,
        needs: &[Excitation::Connections],
        allowance: &[1.0, 2.0, 3.0, 4.0],
        belief: Belief {
            hurdle: 6.0,
            scale: 4.0,
        },
        ..Search::BASE
    },
};

/// Flow of the mud pump, m³/s, at which a string that drains evenly gives as much as one that drains in proportion.
const USUAL_M3_S: f64 = 0.03;

/// What flows out of the drill string.
struct DrillString {
    /// Its outflow, and what was pumped in, at the last sample, m³/s.
    last_m3_s: Option<(f64, f64)>,
    fills_s: f64,
    /// Rates at which the outflow beyond the pump's falls: in proportion to it, 1/s, and evenly, m³/s².
    falls: (f64, f64),
}

impl DrillString {
    fn new(p: &[f64]) -> Self {
        let fills_s = p[0].max(0.0);
        let drains_s = (p[0] * p[1]).max(1e-12);
        Self {
            last_m3_s: None,
            fills_s,
            falls: (
                (1.0 - p[2]) / drains_s,
                p[2] * USUAL_M3_S / (2.0 * drains_s),
            ),
        }
    }

    /// Its outflow after a step, m³/s, over which what is pumped in runs straight.
    fn step(&mut self, pumped: f64, dt_s: f64) -> f64 {
        let outflow = match self.last_m3_s {
            Some((outflow, _)) if !pumped.is_finite() => return outflow,
            Some((outflow, before)) if pumped >= outflow => {
                let (share, ramp) = lagging(self.fills_s, dt_s);
                outflow + share * (before - outflow) + ramp * (pumped - before)
            }
            Some((outflow, before)) => {
                let (share, even) = self.falls;
                // Of dx/dt = -(a x + b) for what flows beyond the pump's, which is as much more as the pump's falls.
                let falls = even + (pumped - before) / dt_s;
                let gone = -(-share * dt_s).exp_m1();
                let over = if share > 0.0 { gone / share } else { dt_s };
                pumped + ((outflow - before) * (1.0 - gone) - falls * over).max(0.0)
            }
            None if pumped.is_finite() => pumped,
            None => return 0.0,
        };
        self.last_m3_s = Some((outflow, pumped));
        outflow
    }
}

impl Effect for UTube {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn begin(&self, p: &[f64], setting: &Setting) -> Action {
        let mut string = DrillString::new(p);
        let noise = setting.noise.mud_pump_m3_s;
        Box::new(move |at, changes| {
            let behind = string.step(at.mud_pump_m3_s, at.dt_s) - at.mud_pump_m3_s;
            changes.inflow_m3_s += shrunk(behind, noise);
        })
    }

    fn memory_s(&self, p: &[f64]) -> f64 {
        Lag::memory_s(p[0] * p[1].max(1.0))
    }
}
