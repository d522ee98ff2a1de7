//! Pipe moved at connections, which displaces mud.

use crate::{
    About, Action, Belief, Component, Connection, Effect, Excitation, Parameter, Relation, Role,
    Search, Setting,
};

/// See the module.
pub(super) struct PipeDisplacement;

static ABOUT: About = About {
    id: "pipe_displacement",
    title: "pipe moved at connections displaces mud",
    component: Component::Boundary,
    relation: Relation::RiserMassBalance,
    equation_without: None,
    equation: "A dh/dt = q_in + V/T - q for T s at each connection",
    source: "closed-end displacement: Bourgoyne et al. 1986, on surge and swab",
    excited_by: "connections",
    confusable: &[("u_tube", "make a connection without moving pipe")],
    parameters: &[
        Parameter {
            name: "volume_m3",
            meaning: "mud displaced at each connection",
            role: Role::Amplitude,
            low: -3.0,
            high: 3.0,
            usual: 0.2,
            ..Parameter::BASE
        },
        Parameter {
            name: "after_s",
            meaning: "wait between the mud pump's stop (or start) and the movement",
            role: Role::Shape(&[0.0, 30.0, 60.0, 90.0]),
            low: -60.0,
            high: 600.0,
            usual: 45.0,
            ..Parameter::BASE
        },
        Parameter {
            name: "lasts_s",
            meaning: "duration of the movement",
            role: Role::Shape(&[30.0, 60.0, 120.0]),
            low: 10.0,
            high: 600.0,
            usual: 60.0,
            ..Parameter::BASE
        },
        // Pipe is picked up as a connection begins and lowered before the next stand is drilled: connections differ in length.
        Parameter {
            name: "toward_end",
            meaning: "0: the wait follows the mud pump's stop; 1: it precedes its start",
            role: Role::Choice(&[0.0, 1.0]),
            low: 0.0,
            high: 1.0,
            usual: 0.0,
            ..Parameter::BASE
        },
    ],
    search: Search {
        belief: Belief {
            hurdle: 8.0,
            scale: 5.0,
        },
        // Sound simulated rigs whose suction's loss is known show evidence of 3 at the most, whatever the volume.
        least: Some(0.03),
        needs: &[Excitation::Connections],
        form_error: 0.15,
        ..Search::BASE
    },
};

impl Effect for PipeDisplacement {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn begin(&self, p: &[f64], setting: &Setting) -> Action {
        let (volume, after, lasts, toward_end) = (p[0], p[1], p[2].max(1.0), p[3] >= 0.5);
        let begins = |c: &Connection| {
            if toward_end {
                c.to_s - after - lasts
            } else {
                c.from_s + after
            }
        };
        let mut starts: Vec<f64> = setting.connections.iter().map(begins).collect();
        // Of connections shorter than the wait, the later may have the earlier move.
        starts.sort_by(f64::total_cmp);
        let mut next = 0;
        Box::new(move |at, changes| {
            while starts.get(next).is_some_and(|s| at.t_s >= s + lasts) {
                next += 1;
            }
            // A sample stands for its step: a short move brings its whole volume however the clock falls.
            let step_s = at.dt_s.max(1e-3);
            let within = |start: &f64| {
                let (from, to) = (start.max(at.t_s), (start + lasts).min(at.t_s + step_s));
                (to - from).max(0.0)
            };
            let begun = starts
                .iter()
                .skip(next)
                .take_while(|start| **start < at.t_s + step_s);
            let moves_s: f64 = begun.map(within).sum();
            changes.inflow_m3_s += volume / lasts * moves_s / step_s;
        })
    }

    fn memory_s(&self, _: &[f64]) -> f64 {
        0.0
    }
}
