//! The jet that enters adds to (or takes from) the head at the outlet.

use crate::effect::{About, Drive, Effect, Now, ParameterAbout, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "entrance_jet",
    title: "the jet that enters adds to (or takes from) the head at the outlet",
    kinds: &[Kind::Tank],
    equation: "p_outlet = ρ g (h + head (q_in/Q)²)",
    source: "Rajaratnam, N., Turbulent Jets (1976), on turbulent jets; the head with the square of the inflow is a stand-in",
    excited_by: "changes of inflow faster than the level follows",
    confusable: &[(
        "pump_nonlinear_gain",
        "a jet acts at once on the outflow, a gain only by the level",
    )],
    parameters: &[ParameterAbout {
        name: "head",
        meaning: "head at the outlet at the usual inflow",
        size: Size::Level,
        low: -0.3,
        high: 0.3,
        neutral: 0.0,
        usual: 0.03,
    }],
};

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn states(&self) -> usize {
        1
    }

    fn start(&self, _: &Now<'_>, drive: &Drive, x: &mut [f64]) {
        x[0] = drive.flow_m3_s;
    }

    // The jet needs a little to cross the tank; without it inflow and outflow would have to be solved together.
    fn rates(&self, now: &Now<'_>, drive: &Drive, rate: &mut [f64]) {
        rate[0] = (drive.flow_m3_s - now.x[0]) / (0.1 * now.scale.time_s);
    }

    fn head(&self, now: &Now<'_>, level: f64) -> f64 {
        let share = now.x[0] / now.scale.flow_m3_s;
        level + now.p[0] * share * share.abs()
    }
}
