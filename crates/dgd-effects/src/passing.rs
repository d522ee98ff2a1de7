//! What sets in and ends again: a leak that is mended, losses that are cured, a transmitter that is put right.

use crate::{About, Action, Effect, MeterPath, Moment, Setting};

/// An effect that sets in and stays, as one that ends: its last parameter is how long it lasts.
///
/// What ends is what sets in once more with the opposite strength, so that mud of another weight mixes out as it has mixed in.
pub(crate) struct Passing {
    /// The effect that stays; what it changes is added up, and is proportional to its strength.
    pub lasting: &'static dyn Effect,
    /// Its description with a duration as one parameter more.
    pub about: &'static About,
}

impl Passing {
    /// The parameters of the effect that stays.
    fn own<'p>(&self, parameters: &'p [f64]) -> &'p [f64] {
        let own = self.lasting.about().parameters.len();
        &parameters[..own.min(parameters.len())]
    }
}

impl Effect for Passing {
    fn about(&self) -> &'static About {
        self.about
    }

    fn lasting(&self) -> Option<&'static dyn Effect> {
        Some(self.lasting)
    }

    fn begin(&self, parameters: &[f64], setting: &Setting) -> Action {
        let (_, end_s) = self
            .about
            .interval_s(parameters, (f64::NEG_INFINITY, f64::INFINITY));
        let own = self.own(parameters);
        let mut sets_in = self.lasting.begin(own, setting);
        if self.is_switch() {
            return Box::new(move |at: &Moment, changes| {
                if at.t_s < end_s {
                    sets_in(at, changes);
                }
            });
        }
        let mut opposite = own.to_vec();
        opposite[0] = -opposite[0];
        if let Some(onset) = self.about.onset() {
            opposite[onset] = end_s;
        }
        let mut ends = self.lasting.begin(&opposite, setting);
        Box::new(move |at: &Moment, changes| {
            sets_in(at, changes);
            ends(at, changes);
        })
    }

    fn is_switch(&self) -> bool {
        self.lasting.is_switch()
    }

    fn acts_s(&self, parameters: &[f64], span_s: (f64, f64)) -> (f64, f64) {
        let (from, to) = self.about.interval_s(parameters, span_s);
        // What mixes in is there for a while after its end.
        (from, if self.is_switch() { to } else { span_s.1 })
    }

    fn memory_s(&self, parameters: &[f64]) -> f64 {
        self.lasting.memory_s(self.own(parameters))
    }

    fn ranged(&self, parameters: &[f64], from: (f64, f64), to: (f64, f64)) -> Option<Vec<f64>> {
        let own = self.lasting.ranged(self.own(parameters), from, to)?;
        Some([own.as_slice(), &parameters[own.len()..]].concat())
    }

    fn same_as(&self, parameters: &[f64], setting: &Setting) -> Option<String> {
        self.lasting.same_as(self.own(parameters), setting)
    }

    fn meter_path(&self, parameters: &[f64]) -> MeterPath {
        self.lasting.meter_path(self.own(parameters))
    }
}
