//! How small an effect a recording would have shown.

use crate::contest::SEEN;
use dgd_effects::About;

/// Evidence above its hurdle that an effect shows at its limit: about what it pays for its strength and for the places where it
/// could have been.
const BEYOND: f64 = 3.0;

/// How an effect would show, were it there, about a hypothesis.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Showing {
    /// Energy of a unit of strength, 0 where the strength is on a grid.
    pub energy: f64,
    /// Evidence that it must show to be named.
    pub hurdle: f64,
    /// Share of its evidence that it would have as well, were it there from the start; 0 where it is so or need not set in.
    pub before: f64,
}

impl Showing {
    /// The smallest strength, as it is carried, that would be named; `None` where no plausible one would.
    pub(crate) fn limit(&self, about: &About) -> Option<f64> {
        let strength = (2.0 * self.needed()? / self.energy).sqrt();
        let named = strength.max(about.search.least.unwrap_or(0.0));
        (named < about.parameters[0].high).then_some(named)
    }

    /// Evidence, by its energy alone, from which on it would be named.
    fn needed(&self) -> Option<f64> {
        // What sets in must explain more than if it were always there (`contest::sets_in`).
        let own = 1.0 - SEEN - self.before;
        (own > 0.0).then(|| (self.hurdle + BEYOND).max(BEYOND / own))
    }
}

#[cfg(test)]
mod tests;
