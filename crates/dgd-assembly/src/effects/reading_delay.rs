//! The reading comes late: transport to the instrument, filters, the network.

use crate::effect::{About, Effect, Now, ParameterAbout, Place, Size};
use crate::spec::Kind;

pub(crate) struct This;

static ABOUT: About = About {
    id: "reading_delay",
    title: "the reading comes late: transport to the instrument, filters, the network",
    kinds: &[Kind::Instrument],
    equation: "y(t) = y_true(t − delay)",
    source: "Lipták, B. G. (ed.), Instrument Engineers' Handbook, vol. 1 (2003), on dead time",
    excited_by: "changes of any kind",
    confusable: &[
        (
            "reading_lag",
            "a step: a late reading stays, then jumps; a slow one sets off at once",
        ),
        ("gas_pocket", "the mass balance separates"),
    ],
    parameters: &[ParameterAbout {
        name: "delay",
        meaning: "delay",
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
        let delay = now.p[0];
        if !(delay > 0.0) {
            return;
        }
        let n = values.len().min(t_s.len());
        // From the end: what is read has not been overwritten yet.
        let mut k = n;
        for i in (0..n).rev() {
            let then = t_s[i] - delay;
            k = k.min(i);
            while k > 0 && t_s[k] > then {
                k -= 1;
            }
            let past = if t_s[k] > then || k + 1 >= n {
                values[k]
            } else {
                let share = (then - t_s[k]) / (t_s[k + 1] - t_s[k]);
                values[k] + share * (values[k + 1] - values[k])
            };
            values[i] = past;
        }
    }
}
