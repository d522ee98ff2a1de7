//! The pump reaches its speed late.

use super::follower::Follower;
use crate::effect::{About, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) static THIS: Follower = Follower::lag(&ABOUT);

static ABOUT: About = About {
    id: "speed_lag",
    title: "the pump reaches its speed late",
    kinds: &[Kind::CentrifugalPump],
    equation: "τ dw/dt = w_set − w",
    source: "Smith, C. A. and Corripio, A. B., Principles and Practice of Automatic Process Control (2006), on first-order systems",
    excited_by: "changes of the set-point",
    confusable: &[
        ("line_inertia", "speed is late even at no flow"),
        ("reading_lag", "a late meter leaves the tank on time"),
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
