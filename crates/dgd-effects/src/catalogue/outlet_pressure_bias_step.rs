//! One of the outlet transmitters shifts at some time and stays.

use crate::passing::Passing;
use crate::{About, Action, Belief, Component, Effect, Parameter, Relation, Role, Search, Setting};

/// See the module.
pub(super) struct OutletPressureBiasStep;

const PARAMETERS: [Parameter; 3] = [
    Parameter {
        name: "bias_pa",
        meaning: "reading minus true value",
        role: Role::Amplitude,
        low: -5e6,
        high: 5e6,
        usual: 4e4,
        ..Parameter::BASE
    },
    Parameter::ONSET,
    Parameter {
        name: "sensor",
        meaning: "transmitter number, from 1",
        role: Role::Sensor(&[1.0, 2.0]),
        low: 1.0,
        high: 2.0,
        usual: 1.0,
        ..Parameter::BASE
    },
];

static ABOUT: About = About {
    id: "outlet_pressure_bias_step",
    title: "one outlet transmitter shifts at some time",
    component: Component::Instrument,
    relation: Relation::ReturnLineFriction,
    equation_without: Some("p_meter,i = p_out"),
    equation: "p_meter,i = p_out + bias for t ≥ onset",
    source: "zero error and drift of a transmitter: IEC 61298-2; the step is the simplest onset",
    excited_by: "two outlet transmitters, or a calm stretch on both sides of the shift",
    confusable: &[
        (
            "mud_density_change",
            "check the redundant transmitter: a density change affects both",
        ),
        (
            "line_restriction",
            "stop the pump: a shift stays, a restriction vanishes",
        ),
    ],
    parameters: &PARAMETERS,
    search: Search {
        belief: Belief {
            hurdle: 9.0,
            scale: 4.0,
        },
        // The other transmitter tells a step better than what both are off by from the start.
        least: Some(7e3),
        size_error: 0.04,
        ..Search::BASE
    },
};

static PASSING: Passing = Passing {
    lasting: &OutletPressureBiasStep,
    about: &About {
        title: "one outlet transmitter shifts, and comes back",
        equation: "p_meter,i = p_out + bias for onset ≤ t < onset + duration",
        parameters: &[
            PARAMETERS[0],
            PARAMETERS[1],
            PARAMETERS[2],
            Parameter::LASTS,
        ],
        ..ABOUT
    },
};

impl Effect for OutletPressureBiasStep {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn passing(&self) -> Option<&'static dyn Effect> {
        Some(&PASSING)
    }

    fn begin(&self, p: &[f64], _: &Setting) -> Action {
        let (bias, onset, sensor) = (p[0], p[1], usize::from(p[2] > 1.5));
        Box::new(move |at, changes| {
            if at.t_s >= onset {
                changes.outlet_bias_pa[sensor] += bias;
            }
        })
    }

    fn is_switch(&self) -> bool {
        true
    }
}
