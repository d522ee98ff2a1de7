//! The curve of an empirical correction: what it is made to, along what, and how its parameters are laid out.

use crate::Relation;

/// What is corrected: relations, readings, which enter several, and what lies between readings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// Friction of the return line.
    Friction,
    /// Head of the subsea pump.
    Head,
    /// Mass balance of the riser.
    Balance,
    /// Reading of both pump inlet transmitters.
    InletReading,
    /// Reading of both pump outlet transmitters.
    OutletReading,
    /// Factor of the return flow meter, true over indicated flow.
    MeterFactor,
    /// What is lost between the riser and the pump's inlet.
    Suction,
    /// Reading of the riser's transmitter.
    RiserReading,
    /// Reading of the first of two pump inlet transmitters.
    FirstInlet,
    /// Reading of the second of two pump inlet transmitters.
    SecondInlet,
    /// Reading of the first of two pump outlet transmitters.
    FirstOutlet,
    /// Reading of the second of two pump outlet transmitters.
    SecondOutlet,
}

impl Place {
    /// All of them, in the order of their codes.
    pub const ALL: [Self; 12] = [
        Self::Friction,
        Self::Head,
        Self::Balance,
        Self::InletReading,
        Self::OutletReading,
        Self::MeterFactor,
        Self::Suction,
        Self::RiserReading,
        Self::FirstInlet,
        Self::SecondInlet,
        Self::FirstOutlet,
        Self::SecondOutlet,
    ];

    /// Its name, for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Friction => "return line friction",
            Self::Head => "pump head",
            Self::Balance => "riser mass balance",
            Self::InletReading => "the reading of the pump inlet transmitters",
            Self::OutletReading => "the reading of the pump outlet transmitters",
            Self::MeterFactor => "the factor of the return flow meter",
            Self::Suction => "the pressure between riser and pump inlet",
            Self::RiserReading => "the reading of the riser transmitter",
            Self::FirstInlet => "the reading of the first pump inlet transmitter",
            Self::SecondInlet => "the reading of the second pump inlet transmitter",
            Self::FirstOutlet => "the reading of the first pump outlet transmitter",
            Self::SecondOutlet => "the reading of the second pump outlet transmitter",
        }
    }

    /// Where it sits.
    pub fn relation(self) -> Relation {
        match self {
            Self::Friction => Relation::ReturnLineFriction,
            Self::Head => Relation::PumpHead,
            Self::Balance => Relation::RiserMassBalance,
            _ => Relation::Instrument,
        }
    }

    /// The relations whose residuals it enters; none, where only its neighbour tells of it.
    pub fn shows_in(self) -> &'static [Relation] {
        use Relation::{Instrument, PumpHead, ReturnLineFriction, RiserMassBalance};
        match self {
            Self::Friction => &[ReturnLineFriction],
            Self::Head => &[PumpHead],
            // Two transmitters tell of the suction, and that they do not wander is asked for by itself.
            Self::Balance | Self::Suction => &[RiserMassBalance],
            // The relations hold the mean of two inlets.
            Self::InletReading | Self::FirstInlet | Self::SecondInlet => {
                &[PumpHead, RiserMassBalance]
            }
            Self::OutletReading => &[ReturnLineFriction, PumpHead],
            Self::MeterFactor => &[RiserMassBalance, ReturnLineFriction, PumpHead],
            Self::RiserReading => &[],
            // The difference of two outlets is a relation of its own.
            Self::FirstOutlet | Self::SecondOutlet => &[ReturnLineFriction, PumpHead, Instrument],
        }
    }

    /// A reading and what it should be; `None` of a relation, which has its own equation.
    pub fn reading(self) -> Option<&'static str> {
        match self {
            Self::Friction | Self::Head | Self::Balance => None,
            Self::InletReading | Self::FirstInlet | Self::SecondInlet => Some("p_meter = p_in"),
            Self::OutletReading | Self::FirstOutlet | Self::SecondOutlet => Some("p_meter = p_out"),
            Self::MeterFactor => Some("q / q_meter = 1"),
            Self::Suction => Some("p_riser - p_in - k rho v^2 / 2 = constant"),
            Self::RiserReading => Some("p_meter = p_riser"),
        }
    }

    /// Prior width of a knot, in its unit: Pa, m³/s, or a share of the flow.
    pub fn width(self) -> f64 {
        match self {
            Self::Head => 2.0e4,
            Self::Balance => 8e-4,
            Self::MeterFactor => 0.02,
            _ => 1.5e4,
        }
    }

    /// Size up to which it is within the accuracy of instruments, in the same unit.
    pub fn least(self) -> f64 {
        match self {
            Self::Friction => 3e3,
            Self::Head | Self::InletReading | Self::OutletReading => 6e3,
            Self::Balance => 1.5e-4,
            Self::MeterFactor => 4e-3,
            _ => 2.5e3,
        }
    }
}

/// Something along which a place is corrected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quantity {
    /// The time, s.
    Time,
    /// The pump inlet pressure, Pa.
    InletPressure,
    /// The mud pump flow, m³/s.
    MudPumpFlow,
    /// The booster flow, m³/s.
    BoosterFlow,
    /// The return flow, m³/s.
    ReturnFlow,
    /// The pump's speed, %.
    PumpSpeed,
    /// The time since the pump started: knots lie evenly along `ln(1 + minutes)`.
    SinceStart,
    /// The rate of the return flow, m³/s².
    FlowRate,
    /// The time within its period, s: knots go from the beginning of the first one to its end, and round again.
    Period,
    /// The time within an episode, s: knots go from its beginning to its end, and before and after it nothing is corrected.
    Episode,
}

impl Quantity {
    /// All of them, in the order of their codes.
    pub const ALL: [Self; 10] = [
        Self::Time,
        Self::InletPressure,
        Self::MudPumpFlow,
        Self::BoosterFlow,
        Self::ReturnFlow,
        Self::PumpSpeed,
        Self::SinceStart,
        Self::FlowRate,
        Self::Period,
        Self::Episode,
    ];

    /// Whether its curve has times of its own, which nothing but the recording tells.
    pub fn is_timed(self) -> bool {
        matches!(self, Self::Period | Self::Episode)
    }

    /// Its name, for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::InletPressure => "inlet pressure",
            Self::MudPumpFlow => "mud pump flow",
            Self::BoosterFlow => "booster flow",
            Self::ReturnFlow => "return flow",
            Self::PumpSpeed => "pump speed",
            Self::SinceStart => "time since the pump started",
            Self::FlowRate => "rate of the return flow",
            Self::Period => "time within its period",
            Self::Episode => "time within an episode",
        }
    }

    /// Its name with the SI unit, in machine-readable output.
    pub fn si_name(self) -> &'static str {
        match self {
            Self::Time => "time_s",
            Self::InletPressure => "inlet_pressure_pa",
            Self::MudPumpFlow => "mud_pump_flow_m3_s",
            Self::BoosterFlow => "booster_flow_m3_s",
            Self::ReturnFlow => "return_flow_m3_s",
            Self::PumpSpeed => "pump_speed_pct",
            Self::SinceStart => "time_since_start_s",
            Self::FlowRate => "return_flow_rate_m3_s2",
            Self::Period => "time_within_period_s",
            Self::Episode => "time_within_episode_s",
        }
    }
}

/// How long an episode lasts that is not over, s: longer than any recording.
const LASTING_S: f64 = 1e9;

/// Knots of a correction, at the least: a finer curve has more.
pub const KNOTS: usize = 12;

/// A correction of a place along a quantity: straight between knots, the same beyond the first and the last, but nothing before and after an
/// [episode](Quantity::Episode).
///
/// As parameters of [`unknown`](crate::unknown()) it is a list of numbers, place and quantity by their codes: the positions in
/// [`Place::ALL`] and [`Quantity::ALL`].
///
/// ```
/// use dgd_effects::{Curve, Place, Quantity};
/// let curve = Curve::new(Place::Head, Quantity::Time, (0.0, 60.0), vec![0.0, 1e4, 3e4]);
/// assert_eq!(curve.at(45.0), 2e4);
/// assert_eq!(curve.parameters(), [1.0, 0.0, 0.0, 60.0, 0.0, 1e4, 3e4]);
/// assert_eq!(Curve::read(&curve.parameters()), Some(curve));
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// What is corrected.
    pub place: Place,
    /// Along what.
    pub quantity: Quantity,
    /// Where the first knot lies, in the unit of the quantity.
    pub from: f64,
    /// Where the last one lies.
    pub to: f64,
    /// Evenly spaced from the one to the other, in the unit of the place: Pa, m³/s, or a share of the flow.
    pub knots: Vec<f64>,
}

impl Curve {
    /// The curve of a place along a quantity, with its first knot and its last where the quantity is `from` and `to`.
    pub fn new(place: Place, quantity: Quantity, (from, to): (f64, f64), knots: Vec<f64>) -> Self {
        Self {
            place,
            quantity,
            from,
            to,
            knots,
        }
    }

    /// What is off by the same all the time from `from_s` to `to_s`, or from `from_s` on if it does not end.
    ///
    /// ```
    /// use dgd_effects::{Curve, Place};
    /// let span_s = (0.0, 3600.0);
    /// let once = Curve::episode(Place::Balance, (600.0, Some(900.0)), -2e-3);
    /// assert_eq!(once.episode_s(span_s), Some((600.0, 900.0)));
    /// assert_eq!([599.0, 600.0, 899.0, 901.0].map(|t| once.at(t)), [0.0, -2e-3, -2e-3, 0.0]);
    /// let on = Curve::episode(Place::Head, (600.0, None), 4e4);
    /// assert_eq!(on.episode_s(span_s), Some((600.0, 3600.0)));
    /// ```
    pub fn episode(place: Place, (from_s, to_s): (f64, Option<f64>), value: f64) -> Self {
        let range = (from_s, to_s.unwrap_or(from_s + LASTING_S));
        Self::new(place, Quantity::Episode, range, vec![value; KNOTS])
    }

    /// The curve that parameters stand for; `None` where there are too few for its head, or a code is none.
    pub fn read(parameters: &[f64]) -> Option<Self> {
        let [place, quantity, from, to, knots @ ..] = parameters else {
            return None;
        };
        Some(Self {
            place: of_code(&Place::ALL, *place)?,
            quantity: of_code(&Quantity::ALL, *quantity)?,
            from: *from,
            to: *to,
            knots: knots.to_vec(),
        })
    }

    /// Its parameters, as [`Curve::read`] takes them.
    pub fn parameters(&self) -> Vec<f64> {
        let codes = [f64::from(self.place as u8), f64::from(self.quantity as u8)];
        [&codes, &[self.from, self.to], &self.knots[..]].concat()
    }

    /// Its value where the quantity is `x`, in the unit of the place; NaN where `x` is.
    pub fn at(&self, x: f64) -> f64 {
        if self.quantity == Quantity::Episode && (x < self.from || x > self.to) {
            return 0.0;
        }
        let last = self.knots.len().saturating_sub(1);
        let position =
            ((x - self.from) / (self.to - self.from) * last as f64).clamp(0.0, last as f64);
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "clamped; a NaN becomes 0"
        )]
        let low = (position.floor() as usize).min(last.saturating_sub(1));
        let share = position - low as f64;
        let [below, above] = [low, low + 1].map(|k| self.knots.get(k).copied().unwrap_or(0.0));
        below + share * (above - below)
    }

    /// From when to when its first period goes, or the episode, s, if it has either.
    pub fn timed_s(&self) -> Option<(f64, f64)> {
        (self.quantity.is_timed()).then_some((self.from, self.to))
    }

    /// The first time of its period, from and to, s, if it has one.
    pub fn period_s(&self) -> Option<(f64, f64)> {
        (self.quantity == Quantity::Period).then_some((self.from, self.to))
    }

    /// From when to when it acts within a recording from and to so many seconds, if it is an episode.
    pub fn episode_s(&self, span_s: (f64, f64)) -> Option<(f64, f64)> {
        let begins = self.from.max(span_s.0);
        (self.quantity == Quantity::Episode).then(|| (begins, self.to.min(span_s.1).max(begins)))
    }

    /// Whether both are episodes, which do not overlap.
    pub fn is_apart(&self, other: &Self) -> bool {
        let episodes = [self, other].map(|c| c.quantity == Quantity::Episode);
        episodes == [true; 2] && (self.to <= other.from || other.to <= self.from)
    }

    /// Whether it is an episode that is not over when the recording ends.
    pub fn goes_on(&self) -> bool {
        // Rounding of its ends on a clock that counts from 1970 is no end.
        self.quantity == Quantity::Episode && self.to - self.from >= 0.5 * LASTING_S
    }

    /// Whether it corrects the same place along the same quantity, by whatever.
    pub fn is_alike(&self, other: &Self) -> bool {
        (self.place, self.quantity) == (other.place, other.quantity)
    }

    /// Whether it corrects nothing.
    pub fn is_flat(&self) -> bool {
        self.knots.iter().all(|knot| *knot == 0.0)
    }

    /// The same curve, so many times as high.
    #[must_use]
    pub fn scaled(&self, times: f64) -> Self {
        let knots = self.knots.iter().map(|knot| times * knot).collect();
        Self::new(self.place, self.quantity, (self.from, self.to), knots)
    }

    /// The same curve, which corrects nothing.
    #[must_use]
    pub fn flattened(mut self) -> Self {
        self.knots.fill(0.0);
        self
    }
}

/// What a code stands for: its place among all, if it is one.
fn of_code<T: Copy>(all: &[T], code: f64) -> Option<T> {
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "not below 0, and what is too large is none"
    )]
    (code >= 0.0)
        .then(|| all.get(code.round() as usize).copied())
        .flatten()
}

#[cfg(test)]
mod tests {
    use super::{Curve, KNOTS, Place, Quantity};

    #[test]
    fn a_curve_is_read_as_it_was_written_and_codes_are_positions() {
        for (i, place) in Place::ALL.into_iter().enumerate() {
            for (j, quantity) in Quantity::ALL.into_iter().enumerate() {
                let curve = Curve::new(place, quantity, (-1.0, 2.0), vec![0.5; KNOTS]);
                let parameters = curve.parameters();
                assert_eq!(parameters[..2], [i as f64, j as f64]);
                assert_eq!(Curve::read(&parameters), Some(curve));
            }
        }
    }

    #[test]
    fn what_has_no_such_code_is_no_curve() {
        let places = Place::ALL.len() as f64;
        let quantities = Quantity::ALL.len() as f64;
        for codes in [
            [places, 0.0],
            [0.0, quantities],
            [-1.0, 0.0],
            [f64::NAN, 0.0],
            [0.0, f64::INFINITY],
        ] {
            let parameters = [&codes[..], &[0.0; 14]].concat();
            assert_eq!(Curve::read(&parameters), None, "{codes:?}");
        }
        assert_eq!(Curve::read(&[0.0; 3]), None);
    }

    #[test]
    fn a_curve_is_held_beyond_its_ends_and_is_flat_once_flattened() {
        let curve = Curve::new(
            Place::Head,
            Quantity::Period,
            (10.0, 20.0),
            vec![1.0, 3.0, -1.0],
        );
        let found = [0.0, 12.5, 15.0, 17.5, 99.0].map(|x| curve.at(x));
        assert_eq!(found, [1.0, 2.0, 3.0, 1.0, -1.0]);
        assert!(curve.at(f64::NAN).is_nan());
        assert_eq!(curve.period_s(), Some((10.0, 20.0)));
        assert!(!curve.is_flat() && curve.flattened().is_flat());
    }
}
