//! The instrument is slow.

use crate::effect::{About, Effect, Now, ParameterAbout, Place, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "reading_lag",
    title: "the instrument is slow",
    kinds: &[Kind::Instrument],
    equation: "τ dy/dt = y_true − y",
    source: "IEC 61298-2 (2008), dynamic response; Lipták, B. G. (ed.), Instrument Engineers' Handbook, vol. 1 (2003), on errors of instruments",
    excited_by: "fast changes",
    confusable: &[
        (
            "reading_delay",
            "a step: a late reading stays, then jumps; a slow one sets off at once",
        ),
        ("pump_lag", "a late reading delays draining as well"),
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

    fn fits(&self, place: &Place) -> bool {
        place.in_time
    }

    fn reading(&self, now: &Now<'_>, t_s: &[f64], values: &mut [f64]) {
        let tau = now.p[0];
        let (Some(&first), true) = (values.first(), tau > 1e-9 * now.scale.time_s) else {
            return;
        };
        let (mut state, mut before) = (first, first);
        for i in 1..values.len().min(t_s.len()) {
            // Exact for a quantity that goes straight between samples.
            let r = (t_s[i] - t_s[i - 1]) / tau;
            let (decay, slope) = ((-r).exp(), (values[i] - before) / r);
            state = values[i] - slope + (state - before + slope) * decay;
            before = values[i];
            values[i] = state;
        }
    }
}
