//! The boundary follows its channel late.

use super::follower::Follower;
use crate::effect::{About, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) static THIS: Follower = Follower::lag(&ABOUT);

static ABOUT: About = About {
    id: "boundary_lag",
    title: "the boundary follows its channel late",
    kinds: &[Kind::Boundary],
    equation: "τ dv/dt = u − v",
    source: "Smith, C. A. and Corripio, A. B., Principles and Practice of Automatic Process Control (2006), on first-order systems",
    excited_by: "changes of the channel",
    confusable: &[
        ("inflow_lag", "the same in the tank it feeds: not separable"),
        ("reading_lag", "other causes of change separate"),
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
