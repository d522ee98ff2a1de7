//! The table of units and their conversion to SI.

use crate::{STANDARD_ATMOSPHERE_PA, UnitError};
use std::collections::HashMap;
use std::fmt;
use std::str::FromStr;
use std::sync::LazyLock;

/// What a unit measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Dimension {
    /// s
    Time,
    /// m
    Length,
    /// m²
    Area,
    /// m³
    Volume,
    /// m³/s
    FlowRate,
    /// Pa
    Pressure,
    /// kg/m³
    Density,
    /// %, held in percent and not as a fraction, as pump speeds are (Table 2.1)
    Percent,
    /// m/s
    Velocity,
    /// 1/min, held per minute: revolutions and pump strokes
    RotationalSpeed,
    /// N
    Force,
    /// K
    Temperature,
    /// V
    Voltage,
    /// Pa·s
    Viscosity,
    /// A bare number.
    Number,
}

impl Dimension {
    /// Symbol of the unit that values of this dimension are held in.
    pub fn si_symbol(self) -> &'static str {
        match self {
            Self::Time => "s",
            Self::Length => "m",
            Self::Area => "m2",
            Self::Volume => "m3",
            Self::FlowRate => "m3/s",
            Self::Pressure => "Pa",
            Self::Density => "kg/m3",
            Self::Percent => "%",
            Self::Velocity => "m/s",
            Self::RotationalSpeed => "rpm",
            Self::Force => "N",
            Self::Temperature => "K",
            Self::Voltage => "V",
            Self::Viscosity => "Pa.s",
            Self::Number => "1",
        }
    }

    /// A unit of this dimension as the rig floor writes it, for messages.
    pub fn example(self) -> &'static str {
        match self {
            Self::FlowRate => "gpm",
            Self::Pressure => "psia",
            Self::Density => "sg",
            other => other.si_symbol(),
        }
    }
}

impl fmt::Display for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Time => "time",
            Self::Length => "length",
            Self::Area => "area",
            Self::Volume => "volume",
            Self::FlowRate => "flow rate",
            Self::Pressure => "pressure",
            Self::Density => "density",
            Self::Percent => "percent",
            Self::Velocity => "velocity",
            Self::RotationalSpeed => "rotational speed",
            Self::Force => "force",
            Self::Temperature => "temperature",
            Self::Voltage => "voltage",
            Self::Viscosity => "viscosity",
            Self::Number => "number",
        })
    }
}

/// Whether a pressure unit says what its zero is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PressureReference {
    /// Zero is vacuum (`psia`, `bara`).
    Absolute,
    /// Zero is the standard atmosphere (`psig`, `barg`).
    Gauge,
    /// Not said (`psi`, `bar`): taken as absolute, as the thesis's psi are (section 2.6).
    Unstated,
}

/// A unit with its affine map to SI: `si = value * factor + offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Preferred spelling.
    pub symbol: &'static str,
    /// What it measures.
    pub dimension: Dimension,
    /// SI units in one of this unit.
    pub factor: f64,
    /// SI value of this unit's zero.
    pub offset: f64,
    /// For pressures, what the zero is.
    pub pressure_reference: Option<PressureReference>,
}

/// US gallon a minute, m³/s, in the five figures of Table 2.3.
const GPM: f64 = 6.3090e-5;
/// Pound-force a square inch, Pa (Table 2.3).
const PSI: f64 = 6894.75729;
/// Inch, m (Table 2.3; exact).
const INCH: f64 = 0.0254;
/// International foot, m (exact).
const FOOT: f64 = 0.3048;
/// US gallon, m³ (231 in³, exact).
const GALLON: f64 = 3.785_411_784e-3;
/// Imperial gallon, m³ (exact).
const IMPERIAL_GALLON: f64 = 4.546_09e-3;
/// Oil barrel, m³ (42 US gallons, exact).
const BARREL: f64 = 0.158_987_294_928;
/// Avoirdupois pound, kg (exact).
const POUND: f64 = 0.453_592_37;
/// Pound-force, N (exact).
const POUND_FORCE: f64 = 4.448_221_615_260_5;
/// Standard gravity on a kilogram, N.
const KILOGRAM_FORCE: f64 = crate::STANDARD_GRAVITY_M_S2;

const fn unit(symbol: &'static str, dimension: Dimension, factor: f64) -> Unit {
    Unit {
        symbol,
        dimension,
        factor,
        offset: 0.0,
        pressure_reference: None,
    }
}

const fn pressure(symbol: &'static str, factor: f64, reference: PressureReference) -> Unit {
    let offset = match reference {
        PressureReference::Gauge => STANDARD_ATMOSPHERE_PA,
        PressureReference::Absolute | PressureReference::Unstated => 0.0,
    };
    Unit {
        symbol,
        dimension: Dimension::Pressure,
        factor,
        offset,
        pressure_reference: Some(reference),
    }
}

use PressureReference::{Absolute, Gauge, Unstated};

/// Every known unit with its further spellings, compared without case, spaces and `³`-style signs.
const TABLE: &[(Unit, &[&str])] = &[
    (
        unit("s", Dimension::Time, 1.0),
        &["sec", "second", "seconds"],
    ),
    (
        unit("ms", Dimension::Time, 1e-3),
        &["millisecond", "milliseconds"],
    ),
    (unit("min", Dimension::Time, 60.0), &["minute", "minutes"]),
    (unit("h", Dimension::Time, 3600.0), &["hr", "hour", "hours"]),
    (unit("d", Dimension::Time, 86_400.0), &["day", "days"]),
    (
        unit("m", Dimension::Length, 1.0),
        &["metre", "meter", "metres", "meters", "mrkb"],
    ),
    (unit("mm", Dimension::Length, 1e-3), &[]),
    (unit("cm", Dimension::Length, 1e-2), &[]),
    (unit("km", Dimension::Length, 1e3), &[]),
    (
        unit("in", Dimension::Length, INCH),
        &["inch", "inches", "\""],
    ),
    (unit("ft", Dimension::Length, FOOT), &["foot", "feet", "'"]),
    (unit("m2", Dimension::Area, 1.0), &["m^2"]),
    (unit("in2", Dimension::Area, INCH * INCH), &["in^2", "sqin"]),
    (unit("ft2", Dimension::Area, FOOT * FOOT), &["ft^2", "sqft"]),
    (unit("m3", Dimension::Volume, 1.0), &["m^3", "cum"]),
    (
        unit("l", Dimension::Volume, 1e-3),
        &["litre", "liter", "litres", "liters"],
    ),
    (
        unit("gal", Dimension::Volume, GALLON),
        &["usgal", "gallon", "gallons"],
    ),
    (
        unit("bbl", Dimension::Volume, BARREL),
        &["barrel", "barrels"],
    ),
    (
        unit("m3/s", Dimension::FlowRate, 1.0),
        &["m^3/s", "m3s-1", "cumec"],
    ),
    (
        unit("m3/h", Dimension::FlowRate, 1.0 / 3600.0),
        &["m^3/h", "m3/hr"],
    ),
    (
        unit("m3/min", Dimension::FlowRate, 1.0 / 60.0),
        &["m^3/min"],
    ),
    (unit("l/s", Dimension::FlowRate, 1e-3), &["lps"]),
    (
        unit("l/min", Dimension::FlowRate, 1e-3 / 60.0),
        &["lpm", "lmin", "ltr/min", "litre/min", "liter/min"],
    ),
    (
        unit("gpm", Dimension::FlowRate, GPM),
        &["gal/min", "usgpm", "galpermin", "usgal/min", "gal/min(us)"],
    ),
    (
        unit("impgpm", Dimension::FlowRate, IMPERIAL_GALLON / 60.0),
        &["igpm", "ukgpm", "impgal/min"],
    ),
    (
        unit("bbl/min", Dimension::FlowRate, BARREL / 60.0),
        &["bpm"],
    ),
    (
        unit("bbl/h", Dimension::FlowRate, BARREL / 3600.0),
        &["bbl/hr", "bph"],
    ),
    (pressure("Pa", 1.0, Unstated), &["pascal"]),
    (pressure("kPa", 1e3, Unstated), &[]),
    (pressure("MPa", 1e6, Unstated), &[]),
    (pressure("bar", 1e5, Unstated), &["bars"]),
    (pressure("mbar", 1e2, Unstated), &["hpa"]),
    (pressure("psi", PSI, Unstated), &["lbf/in2", "lb/in2"]),
    (pressure("ksi", 1e3 * PSI, Unstated), &["kpsi"]),
    (pressure("atm", STANDARD_ATMOSPHERE_PA, Unstated), &[]),
    (
        pressure("kgf/cm2", KILOGRAM_FORCE / 1e-4, Unstated),
        &["kgf/cm^2", "kg/cm2", "kg/cm^2", "ksc"],
    ),
    (
        pressure("Paa", 1.0, Absolute),
        &["pa(a)", "paabs", "pa(abs)"],
    ),
    (
        pressure("kPaa", 1e3, Absolute),
        &["kpa(a)", "kpaabs", "kpa(abs)"],
    ),
    (
        pressure("MPaa", 1e6, Absolute),
        &["mpa(a)", "mpaabs", "mpa(abs)"],
    ),
    (
        pressure("bara", 1e5, Absolute),
        &["bar(a)", "barabs", "bar(abs)"],
    ),
    (
        pressure("mbara", 1e2, Absolute),
        &["mbar(a)", "mbarabs", "mbar(abs)"],
    ),
    (
        pressure("psia", PSI, Absolute),
        &["psi(a)", "psiabs", "psi(abs)"],
    ),
    (pressure("Pag", 1.0, Gauge), &["pa(g)", "pagauge"]),
    (pressure("kPag", 1e3, Gauge), &["kpa(g)", "kpagauge"]),
    (pressure("MPag", 1e6, Gauge), &["mpa(g)", "mpagauge"]),
    (pressure("barg", 1e5, Gauge), &["bar(g)", "bargauge"]),
    (pressure("mbarg", 1e2, Gauge), &["mbar(g)", "mbargauge"]),
    (pressure("psig", PSI, Gauge), &["psi(g)", "psigauge"]),
    (unit("kg/m3", Dimension::Density, 1.0), &["kg/m^3", "kgm-3"]),
    (
        unit("g/cm3", Dimension::Density, 1e3),
        &["g/cm^3", "g/cc", "g/ml", "kg/l"],
    ),
    (
        unit("sg", Dimension::Density, crate::WATER_DENSITY_KG_M3),
        &["specificgravity"],
    ),
    (
        unit("ppg", Dimension::Density, POUND / GALLON),
        &["lb/gal", "lbm/gal"],
    ),
    (
        unit("lb/ft3", Dimension::Density, POUND / (FOOT * FOOT * FOOT)),
        &["pcf", "lb/ft^3"],
    ),
    (
        unit("%", Dimension::Percent, 1.0),
        &["percent", "pct", "%(0-100)", "%(0–100)"],
    ),
    (unit("m/s", Dimension::Velocity, 1.0), &["ms-1"]),
    (unit("m/h", Dimension::Velocity, 1.0 / 3600.0), &["m/hr"]),
    (unit("ft/s", Dimension::Velocity, FOOT), &[]),
    (unit("ft/min", Dimension::Velocity, FOOT / 60.0), &[]),
    (unit("ft/h", Dimension::Velocity, FOOT / 3600.0), &["ft/hr"]),
    (
        unit("rpm", Dimension::RotationalSpeed, 1.0),
        &["1/min", "rev/min"],
    ),
    (
        unit("spm", Dimension::RotationalSpeed, 1.0),
        &["strokes/min"],
    ),
    (unit("Hz", Dimension::RotationalSpeed, 60.0), &["1/s"]),
    (unit("N", Dimension::Force, 1.0), &[]),
    (unit("kN", Dimension::Force, 1e3), &[]),
    (unit("lbf", Dimension::Force, POUND_FORCE), &["lb"]),
    (
        unit("klbf", Dimension::Force, 1e3 * POUND_FORCE),
        &["klb", "klbs", "kip"],
    ),
    (unit("tonf", Dimension::Force, 9_806.65), &["tonne", "t"]),
    (unit("K", Dimension::Temperature, 1.0), &["kelvin"]),
    (
        Unit {
            offset: 273.15,
            ..unit("degC", Dimension::Temperature, 1.0)
        },
        &["°c", "celsius"],
    ),
    (
        Unit {
            offset: 459.67 / 1.8,
            ..unit("degF", Dimension::Temperature, 1.0 / 1.8)
        },
        &["°f", "fahrenheit"],
    ),
    (unit("V", Dimension::Voltage, 1.0), &["volt", "volts"]),
    (unit("mV", Dimension::Voltage, 1e-3), &[]),
    (unit("Pa.s", Dimension::Viscosity, 1.0), &["pas", "pa*s"]),
    (
        unit("cP", Dimension::Viscosity, 1e-3),
        &["mpa.s", "centipoise"],
    ),
    (
        unit("1", Dimension::Number, 1.0),
        &["-", "none", "unitless"],
    ),
];

/// Takes off what people add or vary but for case: spaces, brackets, superscripts, a middle dot.
fn plain(text: &str) -> String {
    let inner = text.trim().trim_matches(|c| c == '[' || c == ']').chars();
    let kept = inner.filter(|c| !matches!(c, ' ' | '\t' | '_' | '\u{a0}'));
    kept.map(|c| match c {
        '²' => '2',
        '³' => '3',
        '·' | '⋅' => '.',
        c => c,
    })
    .collect()
}

/// The same, and case.
fn fold(text: &str) -> String {
    plain(text).to_lowercase()
}

/// Units by each of their spellings, folded. Headers of wide files ask for hundreds.
static SPELLINGS: LazyLock<HashMap<String, Unit>> = LazyLock::new(|| {
    let each = TABLE.iter().flat_map(|(unit, spellings)| {
        let all = std::iter::once(unit.symbol).chain(spellings.iter().copied());
        all.map(|spelling| (fold(spelling), *unit))
    });
    each.collect()
});

impl Unit {
    /// The unit that `text` names, in any of its spellings.
    ///
    /// Case, spaces and square brackets do not count, so `[L/min]` is `l/min`.
    /// The one exception is `mPa`, with or without its zero (`mPag`), which is refused: milli- and
    /// megapascal differ by case alone, and a factor 10⁹ is no guess to make.
    ///
    /// # Errors
    /// [`UnitError::UnknownUnit`], with the nearest known spelling where one is near.
    pub fn parse(text: &str) -> Result<Self, UnitError> {
        let plain = plain(text);
        let wanted = plain.to_lowercase();
        let found = SPELLINGS.get(&wanted);
        // Not `mPa.s`, which no letter in capitals makes a pressure.
        let ambiguous =
            |unit: &Unit| plain.starts_with("mPa") && unit.dimension == Dimension::Pressure;
        match found {
            Some(unit) if !ambiguous(unit) => Ok(*unit),
            _ => Err(UnitError::UnknownUnit {
                found: text.chars().take(40).collect(),
                suggestion: (found.map(|unit| unit.symbol)).or_else(|| nearest(&wanted, None)),
            }),
        }
    }

    /// [`Unit::parse`], and the unit must measure `dimension`; so does what an error suggests.
    ///
    /// # Errors
    /// [`UnitError::UnknownUnit`] or [`UnitError::WrongDimension`].
    pub fn parse_as(text: &str, dimension: Dimension) -> Result<Self, UnitError> {
        match Self::parse(text) {
            Ok(unit) => unit.written(text, dimension),
            Err(UnitError::UnknownUnit { found, .. }) => Err(UnitError::UnknownUnit {
                found,
                suggestion: nearest(&plain(text).to_lowercase(), Some(dimension)),
            }),
            Err(other) => Err(other),
        }
    }

    /// The unit itself, if it measures `dimension`.
    ///
    /// # Errors
    /// [`UnitError::WrongDimension`].
    pub(crate) fn of(self, dimension: Dimension) -> Result<Self, UnitError> {
        self.written(self.symbol, dimension)
    }

    /// The same of a unit that was written in its own way.
    fn written(self, text: &str, dimension: Dimension) -> Result<Self, UnitError> {
        if self.dimension == dimension {
            return Ok(self);
        }
        Err(UnitError::WrongDimension {
            found: text.chars().take(40).collect(),
            is: self.dimension,
            expected: dimension,
            example: dimension.example(),
        })
    }

    /// This unit where `full` of it is 100 %: the tachometer of a pump whose speed is told in percent.
    ///
    /// # Errors
    /// [`UnitError::Full`] unless `full` is above 0, and neither so small nor so large that no percentage comes of it.
    ///
    /// ```
    /// # use dgd_units::Unit;
    /// let rpm = Unit::parse("rpm")?;
    /// assert_eq!(rpm.in_percent_of(1800.0)?.to_si(900.0), 50.0);
    /// # Ok::<(), dgd_units::UnitError>(())
    /// ```
    pub fn in_percent_of(self, full: f64) -> Result<Self, UnitError> {
        let factor = 100.0 / full;
        if factor > 0.0 && factor.is_finite() {
            return Ok(unit(self.symbol, Dimension::Percent, factor));
        }
        Err(UnitError::Full { found: full })
    }

    /// This unit as one of flow: the strokes of a mud pump, each of which displaces `stroke_m3` (its efficiency included), m³.
    ///
    /// # Errors
    /// [`UnitError::WrongDimension`] unless this is a unit of rotational speed, [`UnitError::Stroke`] unless the volume is above 0, and neither
    /// so small nor so large that no flow comes of it.
    ///
    /// ```
    /// # use dgd_units::{Dimension, Unit};
    /// let spm = Unit::parse_as("spm", Dimension::RotationalSpeed)?;
    /// assert_eq!(spm.in_flow_of(0.015)?.to_si(120.0), 0.03);
    /// # Ok::<(), dgd_units::UnitError>(())
    /// ```
    pub fn in_flow_of(self, stroke_m3: f64) -> Result<Self, UnitError> {
        const MINUTE_S: f64 = 60.0;
        let per_minute = self.written(self.symbol, Dimension::RotationalSpeed)?;
        let factor = per_minute.factor * stroke_m3 / MINUTE_S;
        if factor > 0.0 && factor.is_finite() {
            return Ok(unit(self.symbol, Dimension::FlowRate, factor));
        }
        Err(UnitError::Stroke {
            found_m3: stroke_m3,
        })
    }

    /// Whether it counts strokes or turns: a unit of rotational speed, or what [`Unit::in_flow_of`] and [`Unit::in_percent_of`] make of it.
    pub fn counts_turns(self) -> bool {
        Self::known().any(|known| {
            known.dimension == Dimension::RotationalSpeed && known.symbol == self.symbol
        })
    }

    /// The SI unit of a dimension: what [`Unit::parse`] makes of its [symbol](Dimension::si_symbol).
    ///
    /// A `Pa` therefore does not say what its zero is ([`PressureReference::Unstated`]) and is absolute.
    ///
    /// ```
    /// # use dgd_units::{Dimension, Unit};
    /// assert_eq!(Unit::parse("Pa"), Ok(Unit::si(Dimension::Pressure)));
    /// ```
    pub fn si(dimension: Dimension) -> Self {
        match dimension {
            Dimension::Pressure => pressure(dimension.si_symbol(), 1.0, Unstated),
            _ => unit(dimension.si_symbol(), dimension, 1.0),
        }
    }

    /// Every known unit, by dimension.
    pub fn known() -> impl Iterator<Item = Self> {
        TABLE.iter().map(|(unit, _)| *unit)
    }

    /// `value` in this unit, as SI.
    pub fn to_si(self, value: f64) -> f64 {
        value * self.factor + self.offset
    }

    /// An SI value in this unit.
    pub fn from_si(self, si: f64) -> f64 {
        (si - self.offset) / self.factor
    }

    /// Converts a column to SI in place.
    pub fn column_to_si(self, values: &mut [f64]) {
        for value in values {
            *value = self.to_si(*value);
        }
    }
}

impl FromStr for Unit {
    type Err = UnitError;

    fn from_str(text: &str) -> Result<Self, UnitError> {
        Self::parse(text)
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.symbol)
    }
}

/// The known spelling at an edit distance of one, or two for longer words; of a unit of that dimension, if one is given.
fn nearest(wanted: &str, dimension: Option<Dimension>) -> Option<&'static str> {
    if wanted.len() > 16 {
        return None;
    }
    // No fewer edits than the lengths differ by, and symbols are ASCII.
    let length = wanted.chars().count();
    TABLE
        .iter()
        .filter(|(unit, _)| dimension.is_none_or(|d| unit.dimension == d))
        .map(|(unit, _)| unit.symbol)
        .filter(|symbol| symbol.len().abs_diff(length) <= 2)
        .map(|symbol| (edit_distance(&fold(symbol), wanted), symbol))
        .min_by_key(|(distance, _)| *distance)
        .filter(|(distance, symbol)| *distance <= if symbol.len() > 3 { 2 } else { 1 })
        .map(|(_, symbol)| symbol)
}

/// Insertions, deletions, substitutions and swaps of neighbours from `a` to `b`. For the crates beside this one alone.
#[doc(hidden)]
#[must_use]
pub fn edit_distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let mut rows = vec![vec![0; b.len() + 1]; a.len() + 1];
    rows[0] = (0..=b.len()).collect();
    for i in 1..=a.len() {
        rows[i][0] = i;
        for j in 1..=b.len() {
            let substituted = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            rows[i][j] = substituted.min(rows[i - 1][j] + 1).min(rows[i][j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                rows[i][j] = rows[i][j].min(rows[i - 2][j - 2] + 1);
            }
        }
    }
    rows[a.len()][b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_spelling_in_the_table_names_one_unit_only() {
        let mut seen = std::collections::BTreeMap::new();
        for (unit, spellings) in TABLE {
            for spelling in std::iter::once(&unit.symbol).chain(*spellings) {
                let before = seen.insert(fold(spelling), unit.symbol);
                assert!(
                    before.is_none(),
                    "`{spelling}` names both {before:?} and {unit}"
                );
            }
        }
    }

    #[test]
    fn edit_distance_counts_single_letters() {
        assert_eq!(edit_distance("gpm", "gpm"), 0);
        assert_eq!(edit_distance("psia", "psi"), 1);
        assert_eq!(edit_distance("", "bar"), 3);
        assert_eq!(edit_distance("gmp", "gpm"), 1);
    }
}
