//! The pump follows its input late.

use super::follower::Follower;
use crate::effect::{About, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) static THIS: Follower = Follower::lag(&ABOUT);

static ABOUT: About = About {
    id: "pump_lag",
    title: "the pump follows its input late",
    kinds: &[Kind::DisplacementPump],
    equation: "τ dv/dt = u − v; q = c v",
    source: "Smith, C. A. and Corripio, A. B., Principles and Practice of Automatic Process Control (2006), on first-order systems",
    excited_by: "changes of input",
    confusable: &[
        (
            "inflow_lag",
            "the same order and place: only a flow meter between them separates",
        ),
        ("reading_lag", "a late reading delays draining as well"),
    ],
    parameters: &[ParameterAbout {
        name: "tau",
        meaning: "time constant",
        size: Size::Time,
        low: 0.0,
        high: 20.0,
        neutral: 0.0,
        usual: 1.0,
    }],
};
