//! The valve moves late.

use crate::effect::{About, Drive, Effect, Now, ParameterAbout, Place, Size};
use crate::spec::Kind;

pub(crate) struct This;

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

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn fits(&self, place: &Place<'_>) -> bool {
        place.driven && place.in_time
    }

    fn states(&self) -> usize {
        1
    }

    fn start(&self, _: &Now<'_>, drive: &Drive, x: &mut [f64]) {
        x[0] = drive.input;
    }

    fn rates(&self, now: &Now<'_>, drive: &Drive, rate: &mut [f64]) {
        rate[0] = super::lag(now.p[0], now.x[0], drive.input, now.scale.time_s);
    }

    fn input(&self, now: &Now<'_>, value: f64) -> f64 {
        let state = now.x.first().copied().unwrap_or(value);
        super::lagged(now.p[0], state, value, now.scale.time_s)
    }
}
