//! What an effect is: physics beside its description.

use crate::{Changes, Moment, Search, Setting, Shown};

/// The component of an assembly that an effect alters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Component {
    /// A vessel with a free surface: the riser annulus.
    Tank,
    /// A pipe: the return line, the drill string, the booster line.
    Line,
    /// The subsea pump.
    Pump,
    /// A transmitter or meter.
    Instrument,
    /// What crosses the border of the model: formation, rig motion, pipe.
    Boundary,
}

/// The equation of the model in which an effect sits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Relation {
    /// Outlet pressure against return flow (Eq. 3.13).
    ReturnLineFriction,
    /// Pump head against speed and flow (Eq. 2.27).
    PumpHead,
    /// Riser level against flows in and out (Eq. 3.45).
    RiserMassBalance,
    /// Acceleration of the mud (Eq. 3.46).
    Momentum,
    /// One transmitter against its neighbours.
    Instrument,
}

impl Relation {
    /// Its name in machine-readable output.
    pub fn name(self) -> &'static str {
        match self {
            Self::ReturnLineFriction => "return_line_friction",
            Self::PumpHead => "pump_head",
            Self::RiserMassBalance => "riser_mass_balance",
            Self::Momentum => "momentum",
            Self::Instrument => "instrument",
        }
    }
}

/// How a search goes about a parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Role {
    /// The effect's strength: the changes are near enough proportional to it, and 0 is no effect.
    Amplitude,
    /// A strength that is no proportion; it is tried on a grid, and the effect is absent at 0.
    Grid(&'static [f64]),
    /// Shape, tried on a grid.
    Shape(&'static [f64]),
    /// One of a few ways in which the effect acts: each is tried, and there is nothing between them.
    Choice(&'static [f64]),
    /// The outlet transmitter in which the effect sits, 1 or 2: each is tried, and the two must differ by the strength.
    Sensor(&'static [f64]),
    /// The time at which the effect sets in, s of the recording's clock.
    Onset,
    /// How long it lasts, s: these are tried, and refined from there.
    Duration(&'static [f64]),
    /// How long it takes to set in, and to pass, s: tried where its interval has been found.
    Edge(&'static [f64]),
}

/// A parameter of an effect; [`Parameter::BASE`] fills in what is usual.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Name with its SI unit, such as `rate_m3_s`; without unit where it is a share.
    pub name: &'static str,
    /// What it is, as it is reported.
    pub meaning: &'static str,
    /// How it is searched.
    pub role: Role,
    /// Least plausible value, the lower bound of a search.
    pub low: f64,
    /// Greatest plausible value, the upper bound of a search.
    pub high: f64,
    /// A usual magnitude, the width of the prior on an amplitude.
    pub usual: f64,
    /// How it is reported.
    pub shown: Shown,
    /// Standard error of a time for what the form lacks, s, beside what a recording tells of it: found on simulated recordings
    /// (seeds below 1000).
    pub time_error_s: f64,
    /// The end of its range at which the form is no longer the effect's: an estimate there tells of another cause.
    pub strange: Option<End>,
}

/// An end of a parameter's range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// [`Parameter::low`].
    Low,
    /// [`Parameter::high`].
    High,
    /// Both.
    Either,
}

impl Parameter {
    /// Whether a value stands at the strange end of the range, or within a hundredth of the range of it.
    ///
    /// ```
    /// let gel = dgd_effects::find("gel_strength").expect("an effect of the catalogue").about();
    /// let broken = &gel.parameters[1];
    /// assert!(broken.is_strange(3.0) && !broken.is_strange(0.2) && !broken.is_strange(0.01));
    /// ```
    #[must_use]
    pub fn is_strange(&self, value: f64) -> bool {
        let near = 0.01 * (self.high - self.low);
        let (low, high) = (value <= self.low + near, value >= self.high - near);
        match self.strange {
            None => false,
            Some(End::Low) => low,
            Some(End::High) => high,
            Some(End::Either) => low || high,
        }
    }

    /// What is usual: any value from 0, reported as it is carried. Name, meaning and role are for each to say.
    pub const BASE: Self = Self {
        name: "",
        meaning: "",
        role: Role::Shape(&[]),
        low: 0.0,
        high: f64::INFINITY,
        usual: 0.0,
        shown: Shown::AsCarried,
        time_error_s: 0.0,
        strange: None,
    };

    /// The onset, as every effect that sets in has it.
    pub const ONSET: Self = Self {
        name: "onset_s",
        meaning: "when it sets in",
        role: Role::Onset,
        ..Self::BASE
    };

    /// How long what usually stays lasts where it ends.
    pub const LASTS: Self = Self {
        name: "duration_s",
        meaning: "how long it lasts",
        role: Role::Duration(&[1800.0, 6000.0, 16_000.0]),
        low: 1200.0,
        usual: 3600.0,
        time_error_s: 20.0,
        ..Self::BASE
    };
}

/// What is known of an effect before any data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct About {
    /// Its id in the catalogue.
    pub id: &'static str,
    /// A few words for people.
    pub title: &'static str,
    /// The component it alters.
    pub component: Component,
    /// The relation it sits in.
    pub relation: Relation,
    /// What stands in the base model in place of the governing equation, in the same notation; `None` where that is the relation itself.
    pub equation_without: Option<&'static str>,
    /// Governing equation, in plain notation: `A dh/dt = q_in`, a slash between spaces divides the whole product before it.
    pub equation: &'static str,
    /// Where the equation comes from.
    pub source: &'static str,
    /// What a recording must contain to show it.
    pub excited_by: &'static str,
    /// Ids of effects that look alike, and the test that tells them apart.
    pub confusable: &'static [(&'static str, &'static str)],
    /// Its parameters: the strength first.
    pub parameters: &'static [Parameter],
    /// How a diagnosis looks for it, and what it must show to be believed.
    pub search: Search,
}

/// When an effect acts: its action changes nothing, and keeps nothing in mind, before its onset, and changes nothing once it is over
/// ([`Effect::acts_s`]).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// The whole recording.
    Always,
    /// From its onset to the end.
    FromOnset,
    /// From its onset for its duration.
    Passing,
}

/// How the flow meter sees the line's flow, when an effect puts something between them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MeterPath {
    /// Pure delay, s.
    pub delay_s: f64,
    /// First-order lag, s.
    pub lag_s: f64,
}

/// The running effect: reads the moment, writes its changes. Called once a sample, in order.
pub type Action = Box<dyn FnMut(&Moment, &mut Changes) + Send>;

/// One effect of the catalogue.
pub trait Effect: Send + Sync {
    /// Its description.
    fn about(&self) -> &'static About;

    /// Starts the effect with parameters in the order of [`About::parameters`].
    ///
    /// The action is causal, so that the same code serves the relations (driven by what was
    /// measured) and the simulation (driven by what was simulated). A moment that is not finite must leave no trace in
    /// its state.
    ///
    /// # Panics
    /// May panic if there are fewer parameters than described; [`AugmentedModel::free_run`](crate::AugmentedModel::free_run)
    /// refuses those before. Their values, whatever they are, never panic.
    fn begin(&self, parameters: &[f64], setting: &Setting) -> Action;

    /// Whether it takes so many parameters: as many as described, unless its last ones are knots of a curve.
    fn takes(&self, parameters: usize) -> bool {
        parameters == self.about().parameters.len()
    }

    /// Whether the action keeps no state and is in force at once, but for an edge, so that a search can move its onset like a switch.
    fn is_switch(&self) -> bool {
        false
    }

    /// The same effect as one that ends, with how long it lasts as the last parameter; `None` of what has no such form. A search asks for it
    /// where the form that stays does not tell what shows.
    fn passing(&self) -> Option<&'static dyn Effect> {
        None
    }

    /// The effect that stays, of which this is the form that ends; `None` of any other.
    fn lasting(&self) -> Option<&'static dyn Effect> {
        None
    }

    /// From when to when it may change something, s, in a recording that spans from, to, s.
    ///
    /// # Panics
    /// If there are fewer parameters than described.
    fn acts_s(&self, parameters: &[f64], span_s: (f64, f64)) -> (f64, f64) {
        self.about().interval_s(parameters, span_s)
    }

    /// How long, s, an action with these parameters remembers: what it saw before moves what it does by rounding alone.
    ///
    /// Infinite where nothing is promised, which is so by default but for switches. A free run from the middle of a recording begins so
    /// much earlier.
    fn memory_s(&self, _parameters: &[f64]) -> f64 {
        if self.is_switch() { 0.0 } else { f64::INFINITY }
    }

    /// Parameters with which it grows as fast over a recording so many times as long; `None` of what does not grow from a recording's start to
    /// its end.
    fn grown(&self, _parameters: &[f64], _times: f64) -> Option<Vec<f64>> {
        None
    }

    /// Parameters that say the same on a recording whose inlet pressure has the range `to`, Pa absolute, instead of `from`; `None` where that
    /// range does not enter.
    fn ranged(&self, _parameters: &[f64], _from: (f64, f64), _to: (f64, f64)) -> Option<Vec<f64>> {
        None
    }

    /// What would show the same if not the rig were at fault but the description of its well, or what is logged, where there is such a thing:
    /// in words with numbers.
    fn same_as(&self, _parameters: &[f64], _setting: &Setting) -> Option<String> {
        None
    }

    /// What the effect puts between the line and its flow meter; delays and lags of several effects add up.
    fn meter_path(&self, _parameters: &[f64]) -> MeterPath {
        MeterPath::default()
    }
}

impl About {
    /// Position of a parameter, by name: for who sets one of several, as in a model of one's own.
    ///
    /// ```
    /// let about = dgd_effects::find("influx").expect("an effect of the catalogue").about();
    /// let mut parameters = about.of_strength(0.002);
    /// parameters[about.position("onset_s").expect("its onset")] = 3600.0;
    /// assert_eq!(about.interval_s(&parameters, (0.0, 1e5)).0, 3600.0);
    /// ```
    pub fn position(&self, name: &str) -> Option<usize> {
        self.parameters.iter().position(|p| p.name == name)
    }

    /// Position of the onset, if the effect has one.
    pub fn onset(&self) -> Option<usize> {
        self.parameters.iter().position(|p| p.role == Role::Onset)
    }

    /// Position of the duration, if the effect has one.
    pub fn duration(&self) -> Option<usize> {
        self.parameters
            .iter()
            .position(|p| matches!(p.role, Role::Duration(_)))
    }

    /// Whether it begins at an onset and stays, passes, or is always there: as its parameters tell.
    ///
    /// ```
    /// use dgd_effects::{Extent, find};
    /// let extent = |id| find(id).map(|effect| effect.about().extent());
    /// assert_eq!(extent("pump_wear"), Some(Extent::Always));
    /// assert_eq!(extent("line_leak"), Some(Extent::FromOnset));
    /// assert_eq!(extent("influx"), Some(Extent::Passing));
    /// ```
    pub fn extent(&self) -> Extent {
        match (self.onset(), self.duration()) {
            (None, _) => Extent::Always,
            (Some(_), None) => Extent::FromOnset,
            (Some(_), Some(_)) => Extent::Passing,
        }
    }

    /// Position of the outlet transmitter, if the effect sits in one of them.
    pub fn sensor(&self) -> Option<usize> {
        self.parameters
            .iter()
            .position(|p| matches!(p.role, Role::Sensor(_)))
    }

    /// Parameters of an effect of this strength, as its other parameters usually are.
    pub fn of_strength(&self, strength: f64) -> Vec<f64> {
        let others = self.parameters.iter().skip(1).map(|p| p.usual);
        std::iter::once(strength).chain(others).collect()
    }

    /// The interval in which the effect acts, s, in a recording that spans from, to, s; of no length where it ended before that.
    ///
    /// # Panics
    /// If there are fewer parameters than described.
    pub fn interval_s(&self, parameters: &[f64], span_s: (f64, f64)) -> (f64, f64) {
        let begins = self.onset().map_or(span_s.0, |k| parameters[k]);
        let passes = self.duration().map(|k| begins + parameters[k]);
        let end = passes.map_or(span_s.1, |end| end.min(span_s.1));
        let begins = begins.max(span_s.0);
        (begins, end.max(begins))
    }
}
