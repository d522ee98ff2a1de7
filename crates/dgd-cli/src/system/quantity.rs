//! Quantities of a system as people read them: the independent variable, an input, a state, an instrument.

use super::{clock, dimension_of_state, gauges, unit_of, word};
use crate::say;
use dgd_assembly::Assembly;
use dgd_revise::Region;
use dgd_units::{Dimension, Unit};

/// The unit that a quantity is read in.
#[derive(Debug, Clone)]
pub(crate) struct Quantity {
    unit: Option<Unit>,
    /// Empty for a bare number.
    pub(crate) symbol: String,
}

impl Quantity {
    /// That of an instrument, of the channel of an input, of the instrument that reads a state; SI where there is none.
    pub(crate) fn of(assembly: &Assembly, name: &str) -> Self {
        let system = assembly.system();
        let plain = |symbol: &str| Self {
            unit: None,
            symbol: symbol.to_owned(),
        };
        if name == system.independent {
            return plain(clock(assembly).1.as_deref().unwrap_or_default());
        }
        let all = gauges(assembly);
        if let Some(gauge) = all.iter().find(|g| g.name == name) {
            return Self {
                unit: gauge.unit,
                symbol: gauge.symbol.clone(),
            };
        }
        if let Some(written) = system.inputs.get(name).and_then(|i| i.unit.clone()) {
            return Self {
                // As the assembly reads it: of what is carried as a share, per cent are hundredths.
                unit: assembly
                    .input_unit(name)
                    .filter(|u| u.dimension != Dimension::Number),
                symbol: if written == "1" {
                    String::new()
                } else {
                    written
                },
            };
        }
        let reads = |g: &&super::Gauge| {
            let of = system.components.get(&g.name).and_then(|c| word(c, "of"));
            of.is_some_and(|of| format!("{of}.{}", g.measures) == name)
        };
        // A level in volts stays in metres: a volt may be any.
        let dimension = name.rsplit('.').next().and_then(dimension_of_state);
        let same = |g: &&super::Gauge| g.unit.is_some_and(|u| Some(u.dimension) == dimension);
        match all.iter().filter(reads).find(same) {
            Some(gauge) => Self {
                unit: gauge.unit,
                symbol: gauge.symbol.clone(),
            },
            None => plain(&unit_of(system, name)),
        }
    }

    pub(crate) fn shown(&self, si: f64) -> f64 {
        self.unit.map_or(si, |u| u.from_si(si))
    }

    /// `3.1 to 4.2 cm`; `5 cm` where that is one value.
    pub(crate) fn range(&self, (from, to): (f64, f64)) -> String {
        let (from, to) = (self.shown(from), self.shown(to));
        let said = if from == to {
            say::number(from)
        } else {
            let [_, from, to] = say::with_interval(from, (from, to));
            format!("{from} to {to}")
        };
        format!("{said} {}", self.symbol).trim_end().to_owned()
    }
}

/// `74 % of the squares lie where the simulated lower.level is 3.1 to 4.2 cm (20 % of the samples)`
pub(crate) fn place(assembly: &Assembly, region: &Region) -> String {
    let Region {
        along,
        range,
        share,
        of_samples,
    } = region;
    let system = assembly.system();
    let given = *along == system.independent || system.inputs.contains_key(along);
    let run = if given { "" } else { "the simulated " };
    format!(
        "{:.0} % of the squares lie where {run}{along} is {} ({:.0} % of the samples)",
        100.0 * share,
        Quantity::of(assembly, along).range(*range),
        100.0 * of_samples
    )
}

/// `520 to 728 s, 3328 to 3536 s and 2 more stretches`; empty if there is none.
pub(crate) fn stretches(assembly: &Assembly, intervals: &[(f64, f64)]) -> String {
    const SHOWN: usize = 3;
    let clock = Quantity::of(assembly, &assembly.system().independent);
    let shown = intervals.iter().take(SHOWN);
    let mut told: Vec<String> = shown.map(|i| clock.range(*i)).collect();
    let more = intervals.len().saturating_sub(SHOWN);
    if more > 0 {
        let plural = if more == 1 { "" } else { "es" };
        told.push(format!("{more} more stretch{plural}"));
    }
    match told.split_last() {
        None => String::new(),
        Some((one, [])) => one.clone(),
        Some((last, rest)) => format!("{} and {last}", rest.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may")]
    use super::*;

    const TANKS: &str = r#"
connections = ["feed -> tank -> outlet -> other -> drain -> atmosphere"]
[components]
feed = { kind = "boundary" }
tank = { kind = "tank", area = 0.02 }
other = { kind = "tank", area = 0.02 }
outlet = { kind = "orifice", discharge_coefficient = 0.6, area = 1e-4 }
drain = { kind = "orifice", discharge_coefficient = 0.6, area = 1e-4 }
level = { kind = "instrument", measures = "level", of = "tank", channel = "h", unit = "cm" }
[inputs]
"feed.flow" = { channel = "q", unit = "l/min" }
[initial]
"tank.level" = 0.1
"other.level" = 0.1
"#;

    fn assembly() -> Assembly {
        Assembly::parse(TANKS).unwrap()
    }

    #[test]
    fn a_quantity_is_told_in_the_unit_that_its_channel_is_read_in() {
        let assembly = assembly();
        let range = |name: &str, range| Quantity::of(&assembly, name).range(range);
        assert_eq!(range("level", (0.031, 0.042)), "3.10 to 4.20 cm");
        assert_eq!(range("tank.level", (0.031, 0.042)), "3.10 to 4.20 cm");
        // Read by no instrument.
        assert_eq!(range("other.level", (0.031, 0.042)), "0.0310 to 0.0420 m");
        assert_eq!(range("feed.flow", (0.001, 0.002)), "60 to 120 l/min");
        assert_eq!(range("time", (520.0, 728.0)), "520 to 728 s");
    }

    #[test]
    fn an_opening_is_told_in_per_cent_where_its_channel_is() {
        let opened = |unit: &str| {
            let input = format!("[inputs]\n\"outlet.opening\" = {{ channel = \"z\"{unit} }}");
            let text = TANKS.replace("[inputs]", &input).replacen(
                r#"{ kind = "orifice", discharge_coefficient = 0.6, area = 1e-4 }"#,
                r#"{ kind = "valve", flow_coefficient = 1e-5 }"#,
                1,
            );
            let assembly = Assembly::parse(&text).unwrap();
            Quantity::of(&assembly, "outlet.opening").range((0.55, 0.8))
        };
        assert_eq!(opened(r#", unit = "%""#), "55 to 80 %");
        assert_eq!(opened(r#", unit = "1""#), "0.55 to 0.80");
        assert_eq!(opened(""), "0.55 to 0.80");
    }

    #[test]
    fn depths_are_told_in_the_unit_of_the_record_and_times_in_seconds() {
        let told = |record: &str| {
            let text = TANKS.replace("[initial]", &format!("[record]\n{record}\n[initial]"));
            let relation = r#"
independent = "depth"
connections = ["mud -> string -> atmosphere"]
[components]
mud = { kind = "boundary", flow = 0.03 }
string = { kind = "line", length = 1.0, bore = 0.1, friction = "polynomial", quadratic = 1e8 }
[record]
"#;
            [("time", text), ("depth", format!("{relation}{record}"))].map(|(name, text)| {
                let assembly = Assembly::parse(&text).unwrap();
                Quantity::of(&assembly, name).range((520.0, 728.0))
            })
        };
        assert_eq!(told(""), ["520 to 728 s", "520 to 728"]);
        assert_eq!(told("unit = \"min\""), ["520 to 728 s", "520 to 728 min"]);
    }

    #[test]
    fn a_place_has_its_unit_and_stretches_beyond_three_are_counted() {
        let assembly = assembly();
        let region = Region {
            along: "feed.flow".into(),
            range: (0.001, 0.002),
            share: 0.74,
            of_samples: 0.2,
        };
        assert_eq!(
            place(&assembly, &region),
            "74 % of the squares lie where feed.flow is 60 to 120 l/min (20 % of the samples)"
        );
        let full = Region {
            along: "tank.level".into(),
            range: (0.4, 0.4),
            ..region
        };
        assert_eq!(
            place(&assembly, &full),
            "74 % of the squares lie where the simulated tank.level is 40 cm (20 % of the samples)"
        );
        let all: Vec<(f64, f64)> = (0..5u32)
            .map(|i| (100.0 * f64::from(i), 100.0 * f64::from(i) + 40.0))
            .collect();
        assert_eq!(stretches(&assembly, &all[..1]), "0 to 40 s");
        assert_eq!(
            stretches(&assembly, &all),
            "0 to 40 s, 100 to 140 s, 200 to 240 s and 2 more stretches"
        );
        assert_eq!(
            stretches(&assembly, &all[..2]),
            "0 to 40 s and 100 to 140 s"
        );
        assert_eq!(stretches(&assembly, &[]), "");
    }
}
