//! Which properties a component of each kind has.

use crate::network::ATMOSPHERE_PA;
use crate::spec::Kind;
use dgd_units::{Dimension, Unit, UnitError};

/// A property of a kind of component.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Property {
    /// Name in `system.toml`.
    pub name: &'static str,
    /// Dimension, if a unit of the rig floor exists for it.
    pub dimension: Option<Dimension>,
    /// Symbol of its SI unit.
    pub unit: &'static str,
    /// Value if absent; `None`: must be given, be free or be an input.
    pub default: Option<f64>,
    /// Least value accepted.
    pub low: f64,
    /// Greatest value accepted.
    pub high: f64,
    /// Meaning.
    pub meaning: &'static str,
}

impl Property {
    /// The unit that its values are `written` in, to what it is held in: a bare number may be written in per cent, which are hundredths of it.
    ///
    /// # Errors
    /// [`UnitError`] if there is no such unit, or it measures something else.
    pub fn unit_of(&self, written: &str) -> Result<Unit, UnitError> {
        let unit = Unit::parse(written);
        match (self.dimension, unit) {
            (Some(Dimension::Number), Ok(unit)) if unit.dimension == Dimension::Percent => {
                Ok(Unit {
                    factor: 0.01 * unit.factor,
                    ..unit
                })
            }
            (Some(dimension), _) => Unit::parse_as(written, dimension),
            (None, unit) => unit,
        }
    }

    /// Why it cannot be `value`, in SI, if that lies outside its range; NaN lies outside.
    #[must_use]
    pub fn refusal(&self, value: f64) -> Option<String> {
        let unit = if self.unit == "1" { "" } else { self.unit };
        let gap = if unit.is_empty() { "" } else { " " };
        (!(self.low..=self.high).contains(&value))
            .then(|| format!("is {value}{gap}{unit}, expected {}", self.range()))
    }

    /// What it may be, in words.
    #[must_use]
    pub fn range(&self) -> String {
        let (low, high) = (self.low, self.high);
        match (low == f64::MIN_POSITIVE, high.is_finite()) {
            (false, false) if low.is_infinite() => "a number".to_owned(),
            (true, false) => "a number above 0".to_owned(),
            (true, true) => format!("above 0, up to {high}"),
            (false, false) => format!("a number of at least {low}"),
            (false, true) => format!("{low} to {high}"),
        }
    }
}

const INF: f64 = f64::INFINITY;

const fn p(
    name: &'static str,
    dimension: Option<Dimension>,
    unit: &'static str,
    default: Option<f64>,
    range: (f64, f64),
    meaning: &'static str,
) -> Property {
    Property {
        name,
        dimension,
        unit,
        default,
        low: range.0,
        high: range.1,
        meaning,
    }
}

const ANY: (f64, f64) = (-INF, INF);
const POSITIVE: (f64, f64) = (f64::MIN_POSITIVE, INF);
const NOT_NEGATIVE: (f64, f64) = (0.0, INF);

use Dimension as D;

/// Slots of the fluid.
pub(crate) mod fluid {
    pub(crate) const DENSITY: usize = 0;
    pub(crate) const VISCOSITY: usize = 1;
    pub(crate) const GRAVITY: usize = 2;
}
pub(crate) static FLUID: &[Property] = &[
    p(
        "density",
        Some(D::Density),
        "kg/m3",
        Some(1000.0),
        POSITIVE,
        "density",
    ),
    p(
        "viscosity",
        Some(D::Viscosity),
        "Pa.s",
        Some(1e-3),
        NOT_NEGATIVE,
        "dynamic viscosity",
    ),
    p(
        "gravity",
        None,
        "m/s2",
        Some(9.80665),
        NOT_NEGATIVE,
        "gravity",
    ),
];

/// Slots of a tank; its ports' heights follow.
pub(crate) mod tank {
    pub(crate) const AREA: usize = 0;
    pub(crate) const BRIM: usize = 1;
    pub(crate) const OUTLET_HEIGHT: usize = 2;
    pub(crate) const GAS_PRESSURE: usize = 3;
    pub(crate) const GAS_VOLUME: usize = 4;
}
static TANK: &[Property] = &[
    p(
        "area",
        Some(D::Area),
        "m2",
        None,
        POSITIVE,
        "cross-section; or `area_profile = [[height, area], ..]` instead",
    ),
    p(
        "brim",
        Some(D::Length),
        "m",
        Some(INF),
        POSITIVE,
        "height of the brim, beyond which it overflows",
    ),
    p(
        "outlet_height",
        Some(D::Length),
        "m",
        Some(0.0),
        ANY,
        "height of the port `outlet`",
    ),
    p(
        "gas_pressure",
        Some(D::Pressure),
        "Pa",
        Some(ATMOSPHERE_PA),
        ANY,
        "pressure above the surface, at level 0 if closed",
    ),
    p(
        "gas_volume",
        Some(D::Volume),
        "m3",
        Some(INF),
        POSITIVE,
        "gas above level 0 of a closed tank; infinite: open",
    ),
];

/// Height of a tank's further port.
pub(crate) static PORT_HEIGHT: Property = p(
    "height",
    Some(D::Length),
    "m",
    None,
    ANY,
    "height above the floor",
);

/// Slots of a volume.
pub(crate) mod volume {
    pub(crate) const VOLUME: usize = 0;
    pub(crate) const BULK_MODULUS: usize = 1;
}
static VOLUME: &[Property] = &[
    p("volume", Some(D::Volume), "m3", None, POSITIVE, "volume"),
    p(
        "bulk_modulus",
        Some(D::Pressure),
        "Pa",
        Some(2e9),
        POSITIVE,
        "effective bulk modulus, walls included",
    ),
];

/// Slots of a line.
pub(crate) mod line {
    pub(crate) const LENGTH: usize = 0;
    pub(crate) const BORE: usize = 1;
    pub(crate) const INNER: usize = 2;
    pub(crate) const ELEVATION: usize = 3;
    pub(crate) const ROUGHNESS: usize = 4;
    pub(crate) const MINOR: usize = 5;
    pub(crate) const CONSTANT: usize = 6;
    pub(crate) const LINEAR: usize = 7;
    pub(crate) const QUADRATIC: usize = 8;
    pub(crate) const CUBIC: usize = 9;
    pub(crate) const POWER: usize = 10;
    pub(crate) const EXPONENT: usize = 11;
    pub(crate) const AREA: usize = 12;
}
static LINE: &[Property] = &[
    p(
        "length",
        Some(D::Length),
        "m",
        Some(0.0),
        NOT_NEGATIVE,
        "length; needed for `friction = \"darcy\"` and inertia",
    ),
    p(
        "bore",
        Some(D::Length),
        "m",
        Some(INF),
        POSITIVE,
        "inner diameter (of the outer pipe, in an annulus)",
    ),
    p(
        "inner_diameter",
        Some(D::Length),
        "m",
        Some(0.0),
        NOT_NEGATIVE,
        "outer diameter of the pipe inside an annulus",
    ),
    p(
        "elevation",
        Some(D::Length),
        "m",
        Some(0.0),
        ANY,
        "rise from inlet to outlet",
    ),
    p(
        "roughness",
        Some(D::Length),
        "m",
        Some(0.0),
        NOT_NEGATIVE,
        "wall roughness of the Darcy law",
    ),
    p(
        "minor_loss",
        Some(D::Number),
        "1",
        Some(0.0),
        NOT_NEGATIVE,
        "sum of loss coefficients K of bends and fittings",
    ),
    p(
        "constant",
        Some(D::Pressure),
        "Pa",
        Some(0.0),
        ANY,
        "B of B + C q + D q|q| + E q^3, at any flow",
    ),
    p("linear", None, "Pa.s/m3", Some(0.0), ANY, "C"),
    p("quadratic", None, "Pa.s2/m6", Some(0.0), ANY, "D"),
    p("cubic", None, "Pa.s3/m9", Some(0.0), ANY, "E"),
    p(
        "power_coefficient",
        None,
        "Pa/(m3/s)^n",
        Some(0.0),
        NOT_NEGATIVE,
        "k of k |q|^n",
    ),
    p(
        "exponent",
        Some(D::Number),
        "1",
        Some(1.75),
        (0.2, 4.0),
        "n of k |q|^n",
    ),
    p(
        "flow_area",
        Some(D::Area),
        "m2",
        Some(INF),
        POSITIVE,
        "cross-section for inertia; from the bore if absent",
    ),
];

/// Slots of a centrifugal pump.
pub(crate) mod centrifugal {
    pub(crate) const SPEED: usize = 0;
    pub(crate) const C0: usize = 1;
    pub(crate) const C1: usize = 2;
    pub(crate) const C2: usize = 3;
    pub(crate) const N0: usize = 4;
    pub(crate) const N2: usize = 5;
}
static CENTRIFUGAL: &[Property] = &[
    p(
        "speed",
        Some(D::Percent),
        "%",
        None,
        NOT_NEGATIVE,
        "speed, in the unit of the coefficients",
    ),
    p(
        "c0",
        None,
        "m/%^n0",
        None,
        ANY,
        "c0 of H = c0 w^n0 - c1 w q - c2 q|q|^(n2-1), m of fluid",
    ),
    p("c1", None, "m.s/(%.m3)", Some(0.0), ANY, "c1"),
    p("c2", None, "m/(m3/s)^n2", None, ANY, "c2"),
    p(
        "n0",
        Some(D::Number),
        "1",
        Some(2.0),
        (0.2, 4.0),
        "exponent of the speed",
    ),
    p(
        "n2",
        Some(D::Number),
        "1",
        Some(2.0),
        (1.0, 4.0),
        "exponent of the flow",
    ),
];

/// Slots of a displacement pump.
pub(crate) mod displacement {
    pub(crate) const INPUT: usize = 0;
    pub(crate) const COEFFICIENT: usize = 1;
}
static DISPLACEMENT: &[Property] = &[
    p(
        "input",
        None,
        "any",
        None,
        ANY,
        "input: strokes, voltage, set-point",
    ),
    p(
        "coefficient",
        None,
        "m3/s per input",
        Some(1.0),
        ANY,
        "flow per unit of input",
    ),
];

/// Slots of a valve or orifice.
pub(crate) mod valve {
    pub(crate) const OPENING: usize = 0;
    pub(crate) const FLOW_COEFFICIENT: usize = 1;
    pub(crate) const DISCHARGE: usize = 2;
    pub(crate) const AREA: usize = 3;
    pub(crate) const LOSS: usize = 4;
    /// Of them.
    pub(crate) const COUNT: usize = 5;
}
static VALVE: &[Property] = &[
    p(
        "opening",
        Some(D::Number),
        "1",
        Some(1.0),
        (0.0, 1.0),
        "share of the full flow coefficient",
    ),
    p(
        "flow_coefficient",
        None,
        "m3/s/Pa^0.5",
        Some(f64::NAN),
        NOT_NEGATIVE,
        "Cv of q = Cv opening sqrt(dp)",
    ),
    p(
        "discharge_coefficient",
        Some(D::Number),
        "1",
        Some(f64::NAN),
        NOT_NEGATIVE,
        "C of q = C A sqrt(2 dp / rho)",
    ),
    p(
        "area",
        Some(D::Area),
        "m2",
        Some(f64::NAN),
        NOT_NEGATIVE,
        "A, with discharge or loss coefficient",
    ),
    p(
        "loss_coefficient",
        Some(D::Number),
        "1",
        Some(f64::NAN),
        NOT_NEGATIVE,
        "K of dp = K rho (q/A)^2 / 2",
    ),
];

/// Slot of a boundary.
pub(crate) mod boundary {
    pub(crate) const PRESSURE: usize = 0;
    pub(crate) const FLOW: usize = 1;
}
static BOUNDARY: &[Property] = &[
    p(
        "pressure",
        Some(D::Pressure),
        "Pa",
        Some(f64::NAN),
        ANY,
        "pressure, absolute; or `flow`",
    ),
    p(
        "flow",
        Some(D::FlowRate),
        "m3/s",
        Some(f64::NAN),
        ANY,
        "flow into the system; or `pressure`",
    ),
];

/// Slots of an instrument.
pub(crate) mod instrument {
    pub(crate) const GAIN: usize = 0;
    pub(crate) const OFFSET: usize = 1;
    pub(crate) const ACCURACY: usize = 2;
}
static INSTRUMENT: &[Property] = &[
    p(
        "gain",
        None,
        "reading per true",
        Some(1.0),
        ANY,
        "reading = gain * quantity + offset, all three in the instrument's unit (SI without one)",
    ),
    p(
        "offset",
        None,
        "as the reading",
        Some(0.0),
        ANY,
        "offset of the reading, in the instrument's unit",
    ),
    p(
        "accuracy",
        None,
        "as the reading",
        Some(f64::NAN),
        POSITIVE,
        "standard deviation of its error, in the instrument's unit: its weight in a fit (from the record if absent); a smaller model error is not \
         a mismatch",
    ),
    p(
        "low",
        None,
        "as the reading",
        Some(f64::NEG_INFINITY),
        ANY,
        "lower end of its range, in the instrument's unit; for information only",
    ),
    p(
        "high",
        None,
        "as the reading",
        Some(INF),
        ANY,
        "upper end of its range, in the instrument's unit; for information only",
    ),
];

impl Kind {
    /// Every kind.
    pub const ALL: [Self; 10] = [
        Self::Tank,
        Self::Volume,
        Self::Line,
        Self::CentrifugalPump,
        Self::DisplacementPump,
        Self::Valve,
        Self::Orifice,
        Self::Boundary,
        Self::Junction,
        Self::Instrument,
    ];

    /// Numeric properties of this kind.
    #[must_use]
    pub fn properties(self) -> &'static [Property] {
        match self {
            Self::Tank => TANK,
            Self::Volume => VOLUME,
            Self::Line => LINE,
            Self::CentrifugalPump => CENTRIFUGAL,
            Self::DisplacementPump => DISPLACEMENT,
            Self::Valve | Self::Orifice => VALVE,
            Self::Boundary => BOUNDARY,
            Self::Junction => &[],
            Self::Instrument => INSTRUMENT,
        }
    }

    /// Properties that are words, flags or lists, with what they accept.
    #[must_use]
    pub fn choices(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Self::Tank => &[
                ("area_profile", "[[height, area], ..]"),
                ("ports", "{ name = height, name = \"top\" }"),
            ],
            Self::Line => &[
                (
                    "friction",
                    "\"darcy\", \"polynomial\", \"power\" or \"none\"",
                ),
                ("inertia", "true or false"),
                ("column", "the tank whose column moves with the line's flow"),
            ],
            Self::CentrifugalPump => &[("check_valve", "true or false")],
            Self::Instrument => &[
                (
                    "measures",
                    "\"level\", \"pressure\", \"drop\", \"flow\", \"head\" or \"speed\"",
                ),
                ("of", "a component, or one of its ports as `line.outlet`"),
                ("channel", "the record's column"),
                ("unit", "unit of the column"),
            ],
            _ => &[],
        }
    }

    /// What it is, in a few words.
    #[must_use]
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Tank => "open or gas-blanketed tank with a free surface; owns the state `level`",
            Self::Volume => "full, compressible volume; owns the state `pressure`",
            Self::Line => {
                "pipe, hose, drill string, annulus; owns the state `flow` with `inertia = true`"
            }
            Self::CentrifugalPump => "pump whose head falls with flow",
            Self::DisplacementPump => {
                "pump that delivers coefficient x input, whatever the pressure"
            }
            Self::Valve => "resistance with an opening",
            Self::Orifice => "orifice or bit: a resistance",
            Self::Boundary => "given pressure or given flow",
            Self::Junction => "where lines meet; no storage",
            Self::Instrument => "what is measured",
        }
    }

    /// Name in `system.toml`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Tank => "tank",
            Self::Volume => "volume",
            Self::Line => "line",
            Self::CentrifugalPump => "centrifugal_pump",
            Self::DisplacementPump => "displacement_pump",
            Self::Valve => "valve",
            Self::Orifice => "orifice",
            Self::Boundary => "boundary",
            Self::Junction => "junction",
            Self::Instrument => "instrument",
        }
    }

    /// Whether fluid passes through it from an inlet to an outlet.
    #[must_use]
    pub fn is_branch(self) -> bool {
        matches!(
            self,
            Self::Line
                | Self::CentrifugalPump
                | Self::DisplacementPump
                | Self::Valve
                | Self::Orifice
        )
    }

    /// Slot of the property that effects on the input alter, if the kind has one.
    #[must_use]
    pub(crate) fn drive(self) -> Option<usize> {
        match self {
            Self::CentrifugalPump => Some(centrifugal::SPEED),
            Self::DisplacementPump => Some(displacement::INPUT),
            Self::Valve | Self::Orifice => Some(valve::OPENING),
            _ => None,
        }
    }
}
