//! Why a sample may not be used.

use std::fmt;
use std::ops::{BitOr, BitOrAssign};

/// A set of reasons why a sample may not be used for identification; empty if it may.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Reasons(u16);

impl Reasons {
    /// No reason: the sample may be used.
    pub const NONE: Self = Self(0);
    /// Return flow, pump speed, or every transmitter of a pump side has no value.
    pub const GAP: Self = Self(1);
    /// A needed value is impossible.
    pub const OUT_OF_RANGE: Self = Self(1 << 1);
    /// The pump is off.
    pub const PUMP_OFF: Self = Self(1 << 2);
    /// The pressure does not rise over the pump.
    pub const NO_PRESSURE_RISE: Self = Self(1 << 3);
    /// The return flow is not positive.
    pub const NO_FLOW: Self = Self(1 << 4);
    /// The pump started only just now.
    pub const SETTLING: Self = Self(1 << 5);
    /// The pump is running down to a stop.
    pub const STOPPING: Self = Self(1 << 6);
    /// The return flow meter is stuck.
    pub const STUCK_RETURN_FLOW: Self = Self(1 << 7);
    /// The reading of the pump speed is frozen.
    pub const STUCK_PUMP_SPEED: Self = Self(1 << 8);
    /// The pump speed does not change for long (only by
    /// [`crate::ScreenOptions::reject_constant_speed`]).
    pub const CONSTANT_PUMP_SPEED: Self = Self(1 << 9);
    /// No inlet transmitter can be trusted, one of them because it is stuck.
    pub const STUCK_INLET_PRESSURE: Self = Self(1 << 10);
    /// No outlet transmitter can be trusted, one of them because it is stuck.
    pub const STUCK_OUTLET_PRESSURE: Self = Self(1 << 11);
    /// A needed value is a spike.
    pub const SPIKE: Self = Self(1 << 12);
    /// The inlet transmitters disagree for a short while, and neither is the liar.
    pub const INLETS_DISAGREE: Self = Self(1 << 13);
    /// The outlet transmitters disagree for a short while, and neither is the liar.
    pub const OUTLETS_DISAGREE: Self = Self(1 << 14);

    /// Every reason with its name in reports, in the order in which [`Tally::first`] asks.
    pub const ALL: [(Self, &'static str); 15] = [
        (Self::GAP, "gap"),
        (Self::OUT_OF_RANGE, "out of range"),
        (Self::PUMP_OFF, "pump off"),
        (Self::NO_PRESSURE_RISE, "no pressure rise"),
        (Self::NO_FLOW, "no flow"),
        (Self::SETTLING, "settling"),
        (Self::STOPPING, "stopping"),
        (Self::STUCK_RETURN_FLOW, "stuck return flow"),
        (Self::STUCK_PUMP_SPEED, "stuck pump speed"),
        (Self::CONSTANT_PUMP_SPEED, "constant pump speed"),
        (Self::STUCK_INLET_PRESSURE, "stuck inlet pressure"),
        (Self::STUCK_OUTLET_PRESSURE, "stuck outlet pressure"),
        (Self::SPIKE, "spike"),
        (Self::INLETS_DISAGREE, "inlet transmitters disagree"),
        (Self::OUTLETS_DISAGREE, "outlet transmitters disagree"),
    ];

    /// Whether there is no reason against the sample.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Whether every reason in `other` is among these.
    pub fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// Whether any reason in `other` is among these.
    pub fn intersects(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    /// These without those in `other`.
    #[must_use]
    pub fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// `self` if `yes`, else nothing.
    pub(crate) fn when(self, yes: bool) -> Self {
        Self(self.0 * u16::from(yes))
    }
}

impl BitOr for Reasons {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl BitOrAssign for Reasons {
    fn bitor_assign(&mut self, other: Self) {
        self.0 |= other.0;
    }
}

/// The names, comma between; `usable` if there is none.
impl fmt::Display for Reasons {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut names = Self::ALL
            .iter()
            .filter(|(reason, _)| self.contains(*reason))
            .map(|(_, name)| *name);
        f.write_str(names.next().unwrap_or("usable"))?;
        names.try_for_each(|name| write!(f, ", {name}"))
    }
}

impl fmt::Debug for Reasons {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Reasons({self})")
    }
}

/// How many samples one reason speaks against: a row of a report's table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tally {
    /// The reason.
    pub reason: Reasons,
    /// Its name.
    pub name: &'static str,
    /// Samples with this reason.
    pub total: usize,
    /// Samples with this reason and none before it in [`Reasons::ALL`]: these add up
    /// to the samples rejected.
    pub first: usize,
    /// Samples with this reason alone: what would be won without it.
    pub alone: usize,
}

/// Counts every reason, those that never occur included.
pub(crate) fn tally(reasons: &[Reasons]) -> Vec<Tally> {
    let mut table: Vec<Tally> = Reasons::ALL
        .iter()
        .map(|&(reason, name)| Tally {
            reason,
            name,
            total: 0,
            first: 0,
            alone: 0,
        })
        .collect();
    for set in reasons.iter().filter(|set| !set.is_empty()) {
        let mut left = set.0;
        table[left.trailing_zeros() as usize].first += 1;
        if left.is_power_of_two() {
            table[left.trailing_zeros() as usize].alone += 1;
        }
        while left != 0 {
            table[left.trailing_zeros() as usize].total += 1;
            left &= left - 1;
        }
    }
    table
}

#[cfg(test)]
mod tests {
    use super::Reasons;

    #[test]
    fn the_bits_stand_in_the_order_of_the_table() {
        for (place, (reason, name)) in Reasons::ALL.iter().enumerate() {
            assert_eq!(reason.0, 1 << place, "{name}");
        }
    }
}
