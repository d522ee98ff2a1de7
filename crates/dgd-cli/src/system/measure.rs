//! Parameters in the unit that people read them in.

use super::{gauge, unit_of};
use dgd_assembly::{Size, System};
use dgd_units::Unit;

/// The unit of a parameter: what an effect does to a reading is told as the instrument reads, all else as the assembly carries it.
pub(crate) struct Measure {
    unit: Option<Unit>,
    /// Empty for a bare number.
    pub(crate) symbol: String,
}

impl Measure {
    /// - `path`: of a free property, an initial state, or a parameter of an effect.
    pub(crate) fn of(system: &System, path: &str) -> Self {
        let mut keys = path.splitn(3, '.');
        let names = (keys.next(), keys.next(), keys.next());
        if let (Some(component), Some(effect), Some(name)) = names {
            let about = dgd_assembly::effects::find(effect).map(dgd_assembly::Effect::about);
            let known = about.and_then(|a| a.parameters.iter().find(|p| p.name == name));
            if known.is_some_and(|p| p.size == Size::Reading) {
                let read = gauge(system, component, system.components.get(component));
                return Self {
                    unit: read.unit,
                    symbol: read.symbol,
                };
            }
        }
        Self {
            unit: None,
            symbol: unit_of(system, path),
        }
    }

    /// A value of the assembly, or a distance between two; a reading's is counted from the zero of its unit.
    pub(crate) fn shown(&self, si: f64) -> f64 {
        self.unit.map_or(si, |unit| si / unit.factor)
    }

    /// Both ends of an interval.
    pub(crate) fn ends(&self, (low, high): (f64, f64)) -> (f64, f64) {
        (self.shown(low), self.shown(high))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may")]
    use super::*;

    #[test]
    fn what_an_effect_does_to_a_reading_is_in_the_unit_of_the_instrument() {
        let text = r#"
connections = ["feed -> pot -> valve -> atmosphere"]
[components]
feed = { kind = "boundary", flow = 0.01 }
pot = { kind = "volume", volume = 1.0 }
valve = { kind = "valve", flow_coefficient = 1e-5 }
gauge = { kind = "instrument", measures = "pressure", of = "pot", unit = "barg" }
[initial]
"pot.pressure" = 2e5
"#;
        let system = dgd_assembly::parse_system(text).unwrap();
        let of = |path: &str| Measure::of(&system, path);
        let drift = of("gauge.reading_drift.change");
        assert_eq!((drift.shown(5e4), drift.symbol.as_str()), (0.5, "barg"));
        // The greatest reading is counted from the zero of the gauge.
        let limit = of("gauge.reading_clipping.limit");
        assert!((limit.shown(2e5) - 2.0).abs() < 1e-12);
        let lag = of("gauge.reading_lag.tau");
        assert_eq!((lag.shown(3.0), lag.symbol.as_str()), (3.0, "s"));
        let offset = of("feed.inflow_offset.offset");
        assert_eq!((offset.shown(0.1), offset.symbol.as_str()), (0.1, "m3/s"));
    }
}
