//! A number that stands for no value: far beyond every reading, and the same again and again.

use crate::channel::is_pressure;
use dgd_recording::Channel;

/// The highest of some values, how often it comes, and the highest of the others.
#[derive(Debug, Clone, Copy)]
pub(super) struct Highest {
    value: f64,
    times: usize,
    next: f64,
}

/// What a recorder writes where it has no value, SI, and how often.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Filler {
    pub(super) value: f64,
    pub(super) times: usize,
    /// The highest value besides.
    pub(super) next: f64,
}

impl Default for Highest {
    fn default() -> Self {
        Self {
            value: f64::NEG_INFINITY,
            times: 0,
            next: f64::NEG_INFINITY,
        }
    }
}

impl Highest {
    /// More values, of which `top` is the highest.
    pub(super) fn add_all(&mut self, values: &[f64], top: f64) {
        if top > self.next {
            values.iter().for_each(|value| self.add(*value));
        }
    }

    /// One value more, which may be none.
    pub(super) fn add(&mut self, value: f64) {
        // Neither of most values nor of one that is missing.
        if value > self.next && value < f64::INFINITY {
            if value > self.value {
                *self = Self {
                    value,
                    times: 1,
                    next: self.value,
                };
            } else if value == self.value {
                self.times += 1;
            } else {
                self.next = value;
            }
        }
    }

    /// The number that stands for no value in a channel, if it has one. Flows and speeds may go from
    /// next to nothing to a full rate.
    pub(super) fn filler(&self, channel: Channel) -> Option<Filler> {
        /// How far beyond all readings it lies: a pressure has never been seen to do that three times over.
        const BEYOND: f64 = 4.0;
        const FEWEST: usize = 3;
        let is_one = is_pressure(channel)
            && self.times >= FEWEST
            && self.next > 0.0
            && self.value > BEYOND * self.next;
        is_one.then_some(Filler {
            value: self.value,
            times: self.times,
            next: self.next,
        })
    }
}
