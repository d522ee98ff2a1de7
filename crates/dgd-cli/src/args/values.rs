//! Values of options.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use dgd_diagnose::Step;
use dgd_effects::catalogue;

pub(super) fn parse_pair(text: &str) -> Result<(String, String), String> {
    let (key, value) = text
        .split_once('=')
        .ok_or("write a path and its value, such as pump.speed=72 or 'tank.level=1.2 m'")?;
    Ok((key.trim().to_owned(), value.trim().to_owned()))
}

/// The effects of the catalogue by their ids, which errors list.
pub(super) fn effects() -> PossibleValuesParser {
    PossibleValuesParser::new(catalogue().iter().map(|effect| effect.about().id))
}

/// The steps by their names, which help and errors list.
pub(super) fn steps() -> impl TypedValueParser<Value = Step> {
    PossibleValuesParser::new(Step::ALL.map(Step::name)).try_map(|name| {
        let found = Step::ALL.into_iter().find(|s| s.name() == name);
        found.ok_or("not a step")
    })
}

pub(super) fn parse_range(text: &str) -> Result<(f64, f64), String> {
    let (from, to) = text
        .split_once(':')
        .ok_or("write two numbers with a colon, such as 14000:20000")?;
    let number = |part: &str| {
        let part = part.trim();
        let units = [("min", 60.0), ("h", 3600.0), ("s", 1.0)];
        let suffixed = units
            .iter()
            .find_map(|(unit, s)| Some((part.strip_suffix(unit)?, *s)));
        let (figures, factor) = suffixed.unwrap_or((part, 1.0));
        let parsed = figures.trim().parse::<f64>().ok().map(|x| factor * x);
        let parsed = parsed.filter(|x| x.is_finite());
        parsed.ok_or(format!("`{part}` is not a number in s, min or h"))
    };
    let (from, to) = (number(from)?, number(to)?);
    if from > to {
        Err(format!("{from} is after {to}"))
    } else {
        Ok((from, to))
    }
}

#[cfg(test)]
mod tests {
    use super::parse_range;

    #[test]
    fn a_range_is_in_seconds_hours_or_minutes() {
        for (text, range) in [
            ("14000:20000", Ok((14_000.0, 20_000.0))),
            ("3h:5.5 h", Ok((10_800.0, 19_800.0))),
            ("90min:7200 s", Ok((5400.0, 7200.0))),
            ("-60:0", Ok((-60.0, 0.0))),
            ("5h:3h", Err("18000 is after 10800".to_owned())),
        ] {
            assert_eq!(parse_range(text), range, "{text}");
        }
        for text in ["3d:5d", "h:2h", "inf:2", "nan:1", "3h"] {
            assert!(parse_range(text).is_err(), "{text}");
        }
    }
}
