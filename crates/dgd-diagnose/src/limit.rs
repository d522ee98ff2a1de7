//! How small an effect a recording would have shown.

use crate::contest::{Contender, SEEN, SEEN_BESIDES};
use crate::relations::Applied;
use dgd_effects::{About, Search, catalogue};

/// Evidence above its hurdle that an effect shows at its limit: about what it pays for its strength and for the places where it
/// could have been.
const BEYOND: f64 = 3.0;

/// How an effect would show, were it there, about a hypothesis.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Showing {
    /// How much it would change.
    pub energy: Energy,
    /// Evidence that it must show to be named.
    pub hurdle: f64,
    /// Share of its evidence that it would have as well, were it there from the start; 0 where it is so or need not set in.
    pub before: f64,
}

/// Energy of what an effect changes, by its strength: its evidence, were it there, would be half of that.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Energy {
    /// Of a unit of strength: it grows with the square.
    Unit(f64),
    /// On a grid.
    Grid {
        /// Strength, and energy about what is allowed for; ascending, from the strength that changes nothing.
        points: Vec<(f64, f64)>,
        /// How much more than what is allowed for a sound rig may have.
        hidden: f64,
    },
}

impl Energy {
    /// On a grid, as the contest beside a hypothesis has weighed it.
    pub(crate) fn on_grid(c: &Contender, state: &[Applied]) -> Self {
        let about = c.effect.about();
        let allowed = |like: &dyn Fn(&About) -> bool| -> f64 {
            let kind = state.iter().filter(|a| a.allowance);
            let kind = kind.filter(|a| like(a.effect.about()));
            kind.map(|a| a.parameters[0]).sum()
        };
        let own = allowed(&|other| other.id == about.id);
        let mut points = vec![(own, 0.0)];
        points.extend(c.strengths.iter().filter(|(strength, _)| *strength > own));
        Self::Grid {
            points,
            hidden: (most_allowed(&about.search)
                - allowed(&|other| of_a_kind(about, other)).max(0.0))
            .max(0.0),
        }
    }

    /// The smallest strength from which on the energy is enough, if there is one.
    fn enough(&self, energy: f64) -> Option<f64> {
        match self {
            Self::Unit(unit) => Some((energy / unit).sqrt()),
            Self::Grid { points, hidden } => {
                let short = points.iter().rposition(|(_, e)| *e < energy)?;
                let [(from, low), (to, high)] = *points.get(short..short + 2)? else {
                    return None;
                };
                // Between the points of the grid it goes with the square of what is beyond the strength that changes nothing, as a
                // small one does.
                let none = points.first()?.0;
                let square = |strength: f64| (strength - none).powi(2);
                let share = (energy - low) / (high - low);
                let beyond = square(from) + share * (square(to) - square(from));
                Some(none + beyond.sqrt() + hidden)
            }
        }
    }
}

/// Whether a sound rig's other effect stands in for an effect: each is late by itself, but the two of a meter are of a kind.
fn of_a_kind(about: &About, other: &About) -> bool {
    let timing = about.search.timing;
    other.id == about.id || (timing.is_some() && other.search.timing == timing)
}

/// The most that is allowed for in a sound rig of what this is.
fn most_allowed(search: &Search) -> f64 {
    let likes = catalogue().iter().map(|effect| &effect.about().search);
    let likes = likes.filter(|other| search.timing.is_some() && other.timing == search.timing);
    (likes.chain([search]))
        .flat_map(|other| other.allowance)
        .fold(0.0, |most, allowed| allowed.max(most))
}

impl Showing {
    /// The smallest strength, as it is carried, that would be named; `None` where no plausible one would.
    pub(crate) fn limit(&self, about: &About) -> Option<f64> {
        let strength = self.energy.enough(2.0 * self.needed()?)?;
        let named = strength.max(about.search.least.unwrap_or(0.0));
        (named < about.parameters[0].high).then_some(named)
    }

    /// Evidence, by its energy alone, from which on it would be named.
    fn needed(&self) -> Option<f64> {
        // What sets in must explain more than if it were always there (`contest::sets_in`, which asks this much at most).
        let own = 1.0 - SEEN - self.before;
        (own > 0.0).then(|| (self.hurdle + BEYOND).max(SEEN_BESIDES / own))
    }
}

#[cfg(test)]
mod tests;
