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
        let parsed = part.trim().parse::<f64>().ok().filter(|x| x.is_finite());
        parsed.ok_or(format!("`{part}` is not a number"))
    };
    let (from, to) = (number(from)?, number(to)?);
    if from > to {
        Err(format!("{from} is after {to}"))
    } else {
        Ok((from, to))
    }
}
