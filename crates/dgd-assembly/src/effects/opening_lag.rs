//! The valve moves late.

use super::follower::Follower;
use crate::effect::{About, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) static THIS: Follower = Follower::lag(&ABOUT);

static ABOUT: About = About {
    id: "opening_lag",
    title: "the valve moves late",
    kinds: &[Kind::Valve, Kind::Orifice],
    equation: "τ dz/dt = z_set − z",
    source: "Smith, C. A. and Corripio, A. B., Principles and Practice of Automatic Process Control (2006), on control valves",
    excited_by: "steps of the opening",
    confusable: &[("reading_lag", "a late reading is late for other causes too")],
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
