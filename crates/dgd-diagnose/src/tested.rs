//! What was looked for: each effect of the catalogue with its detection limit.

use crate::diagnosis::{Finding, Outcome, Tested};
use crate::heave::{Swell, Unseen};
use crate::record::Record;
use crate::relations::Applied;
use crate::selection::{First, Selection};
use dgd_effects::{About, Excitation, Method, Parameter, catalogue};
use dgd_recording::STANDING_M3_S;

/// How each effect of the catalogue fared, and the smallest strength that would have passed its hurdle.
pub(crate) fn tested(
    record: &Record,
    selection: &Selection,
    findings: &[Finding],
    start: &[Applied],
    swell: Result<Swell, Unseen>,
) -> Vec<Tested> {
    // What the model to start from holds is not looked for.
    let held = |id: &str| start.iter().any(|a| a.id() == id);
    catalogue()
        .iter()
        .filter(|effect| !held(effect.about().id))
        .map(|effect| {
            let about = effect.about();
            let first = selection.first.iter().find(|f| f.id == about.id);
            let missing = missing(record, swell, about.search.needs);
            // What was only suspected need not be likely.
            let found = findings
                .iter()
                .any(|f| f.effect == about.id && f.is_likely());
            let seen = limit(record, about, first, swell);
            let resembled = (findings.iter()).any(|f| f.resembles == Some(about.id));
            let outcome = if found {
                Outcome::Found
            } else if resembled {
                Outcome::Resembled
            } else if let Some(why) = missing {
                Outcome::NotTestable(why.to_owned())
            } else if first.is_none() && about.search.method == Method::Relations {
                Outcome::NotTestable("nothing in the recording excites it".to_owned())
            } else if seen.is_none() && first.is_some_and(hardly_shows) {
                Outcome::NotTestable(
                    "at no plausible strength could it be identified here".to_owned(),
                )
            } else {
                Outcome::NotSeen
            };
            let energy = first.map_or(0.0, |f| f.energy);
            let (_, factor) = about.parameters[0].shown.scale(&record.setting);
            let standard_error = (energy > 0.0)
                .then(|| factor / energy.sqrt())
                .filter(|e| e.is_finite());
            let spectral = (about.search.method == Method::Spectrum).then_some(swell.ok());
            let (evidence, hurdle) = match (first, spectral.flatten()) {
                (Some(f), _) => (f.evidence, f.hurdle),
                (None, Some(s)) => (s.evidence, s.hurdle),
                (None, None) => (0.0, about.search.belief.hurdle),
            };
            Tested {
                effect: about.id,
                title: about.title,
                outcome,
                evidence,
                admissible: first.is_some_and(|f| f.admissible),
                strength: strength(about).name,
                hurdle,
                standard_error,
                limit: seen,
            }
        })
        .collect()
}

/// The parameter that tells how strong an effect is: of swell its amplitude, which comes after the period.
fn strength(about: &About) -> &'static Parameter {
    let at = usize::from(about.search.method == Method::Spectrum);
    &about.parameters[at]
}

/// The smallest strength that would have been seen, as it is reported.
fn limit(
    record: &Record,
    about: &About,
    first: Option<&First>,
    swell: Result<Swell, Unseen>,
) -> Option<f64> {
    if about.search.method == Method::Spectrum {
        return (swell.ok().map(|s| s.limit_m)).filter(|limit_m| *limit_m < strength(about).high);
    }
    let carried = first?.showing.as_ref()?.limit(about)?;
    let (_, factor) = about.parameters[0].shown.scale(&record.setting);
    Some(factor * carried)
}

/// Whether an effect might be named beside what was, and had nothing to show when it was first weighed.
fn hardly_shows(first: &First) -> bool {
    let showing = first.showing.as_ref();
    showing.is_some_and(|showing| first.evidence < showing.hurdle)
}

/// Why a recording cannot show an effect with these needs.
fn missing(
    record: &Record,
    swell: Result<Swell, Unseen>,
    needs: &[Excitation],
) -> Option<&'static str> {
    let runs = || record.filled.pumping.contains(&true);
    // What begins at rest and starts tells of the rest as well as a stop does.
    let rests = || record.filled.pumping.contains(&false);
    let pumps = || (record.filled.mud_pump.iter()).any(|q| *q > STANDING_M3_S);
    let booster_steps = || {
        let (low, high) = record
            .filled
            .booster
            .iter()
            .fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(*x), b.max(*x)));
        high - low > 1e-3
    };
    needs.iter().find_map(|need| match need {
        Excitation::PumpStops if !runs() => Some("the subsea pump never runs"),
        Excitation::PumpStops => (!rests()).then_some("the subsea pump never stops"),
        Excitation::Connections if !pumps() => Some("the mud pump never runs"),
        Excitation::Connections => {
            let none = record.setting.connections.is_empty();
            none.then_some("the mud pump never stops")
        }
        Excitation::BoosterSteps => {
            (!booster_steps()).then_some("the booster flow does not change")
        }
        Excitation::FastSampling => swell.err().map(Unseen::reason),
    })
}

#[cfg(test)]
mod tests;
