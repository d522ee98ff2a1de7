//! Gas in the line stores fluid: what leaves lags what enters.

use crate::effect::{About, Drive, Effect, Now, ParameterAbout, Place, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "gas_pocket",
    title: "gas in the line stores fluid: what leaves lags what enters",
    kinds: &[Kind::Line],
    equation: "τ dq_out/dt = q_in − q_out",
    source: "Wylie, E. B. and Streeter, V. L., Fluid Transients in Systems (1993), on lumped capacitance and gas",
    excited_by: "changes of flow",
    confusable: &[
        ("line_inertia", "see there"),
        (
            "reading_lag",
            "a late meter leaves the tank behind it on time",
        ),
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

impl Effect for This {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn fits(&self, place: &Place<'_>) -> bool {
        place.in_time && place.outlet_stores
    }

    fn states(&self) -> usize {
        1
    }

    fn start(&self, _: &Now<'_>, drive: &Drive, x: &mut [f64]) {
        x[0] = drive.flow_m3_s;
    }

    fn rates(&self, now: &Now<'_>, drive: &Drive, rate: &mut [f64]) {
        rate[0] = super::lag(now.p[0], now.x[0], drive.flow_m3_s, now.scale.time_s);
    }

    fn outlet(&self, now: &Now<'_>, q: f64, _: f64) -> f64 {
        let state = now.x.first().copied().unwrap_or(q);
        super::lagged(now.p[0], state, q, now.scale.time_s)
    }
}
