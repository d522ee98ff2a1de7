//! Effects of one's own beside those of the catalogue.

use crate::{About, Effect, Method, Parameter, Role};
use std::sync::{Mutex, OnceLock, PoisonError};

static OWN: Mutex<Vec<&'static dyn Effect>> = Mutex::new(Vec::new());
static ALL: OnceLock<Vec<&'static dyn Effect>> = OnceLock::new();

/// Adds an effect of one's own to the catalogue of this process, so that everything that looks there knows it: diagnoses, models that are
/// read or run, reports. It is weighed like the others, and stands behind them in the order.
///
/// Before the catalogue is first looked at: from then on it stays as it is, so that a search and the report of it know the same effects.
///
/// # Errors
/// [`RegisterError::TooLate`] after that; [`RegisterError::Taken`] where the id is known; [`RegisterError::Unsound`] where its description
/// contradicts itself, so that a diagnosis could make nothing of it.
pub fn register(effect: &'static dyn Effect) -> Result<(), RegisterError> {
    let about = effect.about();
    let unsound = |what| RegisterError::Unsound { id: about.id, what };
    sound(about).map_err(unsound)?;
    if about.search.method == Method::Spectrum {
        return Err(unsound(
            "the spectrum shows swell alone, expected `Method::Relations`",
        ));
    }
    // What panicked while it held the list has pushed whole effects or none.
    let mut own = OWN.lock().unwrap_or_else(PoisonError::into_inner);
    if ALL.get().is_some() {
        return Err(RegisterError::TooLate { id: about.id });
    }
    let known = crate::catalogue::BUILT_IN.iter().chain(own.iter());
    let mut ids = known.map(|e| e.about().id).chain(["unknown"]);
    if ids.any(|id| id == about.id) {
        return Err(RegisterError::Taken { id: about.id });
    }
    own.push(effect);
    Ok(())
}

/// The built-in effects and those that were registered, from now on for good.
pub(crate) fn all() -> &'static [&'static dyn Effect] {
    ALL.get_or_init(|| {
        let own = OWN.lock().unwrap_or_else(PoisonError::into_inner);
        let built_in = crate::catalogue::BUILT_IN.iter().copied();
        built_in.chain(own.iter().copied()).collect()
    })
}

/// Why an effect is not added to the catalogue.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RegisterError {
    /// The catalogue has been looked at.
    #[error(
        "effect `{id}` is registered too late: register it before anything reads the catalogue"
    )]
    TooLate {
        /// Its id.
        id: &'static str,
    },
    /// There is one of this id.
    #[error("the catalogue already has an effect `{id}`: choose another id")]
    Taken {
        /// Its id.
        id: &'static str,
    },
    /// What it says of itself cannot be.
    #[error("effect `{id}`: {what}")]
    Unsound {
        /// Its id.
        id: &'static str,
        /// What is wrong, and what it should be.
        what: &'static str,
    },
}

/// Whether a description agrees with itself in what a search relies on.
///
/// # Errors
/// What does not.
pub(crate) fn sound(about: &About) -> Result<(), &'static str> {
    let Some(strength) = about.parameters.first() else {
        return Err("it has no parameter, expected its strength first");
    };
    let mut faults = of_strength(about, strength)
        .into_iter()
        .chain(of_ranges(about))
        .chain(of_onset(about, strength))
        .chain(of_weights(about, strength))
        .chain(of_other_parameters(about, strength))
        .chain(of_search(about, strength));
    let first = faults.find(|(is, _)| *is);
    first.map_or(Ok(()), |(_, what)| Err(what))
}

/// Whether something is wrong, and what.
type Fault = (bool, &'static str);

fn of_strength(about: &About, strength: &Parameter) -> [Fault; 3] {
    [
        (
            about.id.is_empty() || about.title.trim().is_empty(),
            "its id or title is empty",
        ),
        (
            !matches!(strength.role, Role::Amplitude | Role::Grid(_)),
            "its first parameter is not its strength, expected `Role::Amplitude` or `Role::Grid`",
        ),
        (
            strength.role == Role::Amplitude && strength.usual <= 0.0,
            "its strength has no usual size, expected one above 0",
        ),
    ]
}

/// Of the bounds of all parameters, the values listed for them, and their names.
fn of_ranges(about: &About) -> [Fault; 4] {
    let listed = |role: &Role| match role {
        Role::Grid(values)
        | Role::Shape(values)
        | Role::Choice(values)
        | Role::Sensor(values)
        | Role::Duration(values)
        | Role::Edge(values) => Some(*values),
        Role::Amplitude | Role::Onset => None,
    };
    let within = |p: &Parameter| {
        let values = listed(&p.role).unwrap_or(&[]);
        p.low < p.high
            && (p.low..=p.high).contains(&p.usual)
            && values.iter().all(|v| (p.low..=p.high).contains(v))
    };
    let names = about.parameters.iter().enumerate();
    [
        (
            about.search.method == Method::Relations
                && about
                    .parameters
                    .iter()
                    .any(|p| listed(&p.role).is_some_and(<[f64]>::is_empty)),
            "a parameter that is tried on a grid has no grid values",
        ),
        (
            !about.parameters.iter().all(within),
            "the usual or a tried value of a parameter is beyond its bounds, or the bounds are not a range",
        ),
        (
            about
                .parameters
                .iter()
                .any(|p| p.strange.is_some() && !(p.low.is_finite() && p.high.is_finite())),
            "a parameter is marked strange at an end that its range does not have",
        ),
        (
            { names }.any(|(k, p)| about.position(p.name) != Some(k)),
            "two parameters have the same name",
        ),
    ]
}

fn of_onset(about: &About, strength: &Parameter) -> [Fault; 3] {
    [
        (
            about.duration().is_some() && about.onset().is_none(),
            "it has a duration but no onset",
        ),
        (
            matches!(strength.role, Role::Grid(_)) && about.onset().is_some(),
            "a strength on a grid has no onset: expected `Role::Amplitude`",
        ),
        (
            about.sensor().is_some() && about.onset().is_none(),
            "an effect in one transmitter needs an onset",
        ),
    ]
}

/// Of the numbers that it is weighed by.
fn of_weights(about: &About, strength: &Parameter) -> [Fault; 3] {
    let search = &about.search;
    [
        (
            ![search.belief.hurdle, search.belief.scale]
                .iter()
                .all(|v| *v > 0.0 && v.is_finite()),
            "its hurdle and the scale of belief must be numbers above 0",
        ),
        (
            ![search.form_error, search.size_error]
                .iter()
                .all(|e| (0.0..1.0).contains(e)),
            "its form and size errors are shares, from 0 to below 1",
        ),
        (
            search
                .least
                .is_some_and(|least| !(least > 0.0 && least < strength.high)),
            "the least strength to be named must lie between 0 and the highest",
        ),
    ]
}

/// Of parameters that an effect searched in this way cannot have beside its strength.
fn of_other_parameters(about: &About, strength: &Parameter) -> [Fault; 3] {
    let search = &about.search;
    let others = &about.parameters[1..];
    [
        (
            !search.allowance.is_empty() && (about.onset().is_some() || about.sensor().is_some()),
            "an allowance is always present, but this effect has an onset or a transmitter",
        ),
        (
            others.iter().any(|p| p.role == Role::Amplitude),
            "two parameters are strengths, expected only the first",
        ),
        (
            search.timing.is_some()
                && (strength.high < 1.0
                    || others.iter().any(|p| !matches!(p.role, Role::Shape(_)))),
            "the parameters of a delay or lag must be its time, of up to 1 s or more, and shapes",
        ),
    ]
}

fn of_search(about: &About, strength: &Parameter) -> [Fault; 4] {
    let search = &about.search;
    // What is late may seem early, by a clock of its own.
    let allowed = |value: &f64| {
        (*value > 0.0 || *value < 0.0 && search.timing.is_some()) && *value <= strength.high
    };
    [
        (
            !(search.allowance.is_sorted() && search.allowance.iter().all(allowed)),
            "allowance values must rise, above 0 (for times also below it) and up to the bound of the strength",
        ),
        (
            search
                .stand_error
                .is_some_and(|error| !(0.0..=1.0).contains(&error)),
            "the error from stand to stand must be a share, from 0 to 1",
        ),
        (
            search.method == Method::Spectrum && about.parameters.len() != 2,
            "an effect found in the spectrum must have two parameters, period and amplitude",
        ),
        (
            search.method == Method::Correction,
            "there can be only one empirical correction, expected `Method::Relations`",
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::{RegisterError, register, sound};
    use crate::{
        About, Action, Component, Effect, Method, Parameter, Relation, Role, Search, Setting,
        Timing, catalogue,
    };

    const SOUND: About = About {
        id: "topfill_offset",
        title: "the topfill meter is off",
        component: Component::Instrument,
        relation: Relation::RiserMassBalance,
        equation_without: Some("q_meter = q"),
        equation: "q_meter = q + q_0",
        source: "a meter's zero",
        excited_by: "any recording",
        confusable: &[],
        parameters: &[Parameter {
            name: "offset_m3_s",
            meaning: "reading minus true value",
            role: Role::Amplitude,
            low: -0.01,
            high: 0.01,
            usual: 1e-3,
            ..Parameter::BASE
        }],
        search: Search::BASE,
    };

    struct Own(About);

    impl Effect for Own {
        fn about(&self) -> &'static About {
            // Leaked by the tests, which are few.
            Box::leak(Box::new(self.0))
        }

        fn begin(&self, _: &[f64], _: &Setting) -> Action {
            Box::new(|_, _| {})
        }
    }

    #[test]
    fn what_the_catalogue_says_of_its_effects_agrees_with_itself() {
        for effect in crate::catalogue::BUILT_IN {
            assert_eq!(sound(effect.about()), Ok(()), "{}", effect.about().id);
        }
        assert_eq!(sound(&SOUND), Ok(()));
    }

    #[test]
    fn what_does_not_is_told() {
        const STRENGTH: Parameter = SOUND.parameters[0];
        const SEARCH: Search = Search::BASE;
        let with = |parameters: &'static [Parameter]| About {
            parameters,
            ..SOUND
        };
        let sought = |search: Search| About { search, ..SOUND };
        let cases = [
            (About { id: "", ..SOUND }, "id or title"),
            (with(&[]), "no parameter"),
            (with(&[Parameter::ONSET]), "is not its strength"),
            (
                with(&[Parameter {
                    usual: 0.0,
                    ..STRENGTH
                }]),
                "no usual size",
            ),
            (
                with(&[Parameter {
                    role: Role::Grid(&[]),
                    ..STRENGTH
                }]),
                "no grid values",
            ),
            (
                with(&[Parameter {
                    role: Role::Grid(&[0.02]),
                    ..STRENGTH
                }]),
                "beyond its bounds",
            ),
            (
                with(&[Parameter {
                    high: -0.01,
                    ..STRENGTH
                }]),
                "beyond its bounds",
            ),
            (with(&[STRENGTH, STRENGTH]), "the same name"),
            (
                with(&[
                    STRENGTH,
                    Parameter {
                        name: "duration_s",
                        role: Role::Duration(&[3600.0]),
                        ..Parameter::ONSET
                    },
                ]),
                "a duration but no onset",
            ),
            (
                with(&[
                    Parameter {
                        role: Role::Grid(&[1e-3]),
                        ..STRENGTH
                    },
                    Parameter::ONSET,
                ]),
                "a strength on a grid has no onset",
            ),
            (
                with(&[
                    STRENGTH,
                    Parameter {
                        name: "sensor",
                        role: Role::Sensor(&[0.0]),
                        ..STRENGTH
                    },
                ]),
                "needs an onset",
            ),
            (
                sought(Search {
                    belief: crate::Belief {
                        hurdle: 0.0,
                        scale: 1.0,
                    },
                    ..SEARCH
                }),
                "hurdle",
            ),
            (
                sought(Search {
                    form_error: 1.0,
                    ..SEARCH
                }),
                "are shares",
            ),
            (
                sought(Search {
                    size_error: f64::NAN,
                    ..SEARCH
                }),
                "are shares",
            ),
            (
                sought(Search {
                    least: Some(0.01),
                    ..SEARCH
                }),
                "least strength",
            ),
            (
                sought(Search {
                    method: Method::Spectrum,
                    ..SEARCH
                }),
                "in the spectrum",
            ),
            (
                sought(Search {
                    method: Method::Correction,
                    ..SEARCH
                }),
                "one empirical correction",
            ),
            (
                with(&[
                    STRENGTH,
                    Parameter {
                        name: "other",
                        ..STRENGTH
                    },
                ]),
                "two parameters are strengths",
            ),
            (
                sought(Search {
                    timing: Some(Timing::Pump),
                    ..SEARCH
                }),
                "a delay or lag",
            ),
            (
                sought(Search {
                    allowance: &[2e-3, 1e-3],
                    ..SEARCH
                }),
                "must rise",
            ),
            (
                sought(Search {
                    allowance: &[0.02],
                    ..SEARCH
                }),
                "must rise",
            ),
            (
                sought(Search {
                    stand_error: Some(1.5),
                    ..SEARCH
                }),
                "from stand to stand",
            ),
            (
                About {
                    search: Search {
                        allowance: &[1e-4],
                        ..SEARCH
                    },
                    ..with(&[STRENGTH, Parameter::ONSET])
                },
                "always present",
            ),
            (
                with(&[
                    STRENGTH,
                    Parameter {
                        name: "shape",
                        role: Role::Shape(&[1.0]),
                        low: 0.0,
                        high: f64::INFINITY,
                        usual: 1.0,
                        strange: Some(crate::End::Low),
                        ..STRENGTH
                    },
                ]),
                "strange at an end",
            ),
        ];
        for (about, said) in cases {
            let wrong = sound(&about).err().unwrap_or_default();
            assert!(wrong.contains(said), "{wrong:?} for {said}");
        }
        let about = About { id: "", ..SOUND };
        let refused = register(Box::leak(Box::new(Own(about))));
        let expected = RegisterError::Unsound {
            id: "",
            what: "its id or title is empty",
        };
        assert_eq!(refused, Err(expected));
    }

    #[test]
    fn the_catalogue_does_not_grow_while_it_is_in_use() {
        let before = catalogue().len();
        let late: &'static Own = Box::leak(Box::new(Own(SOUND)));
        let refused = register(late);
        assert_eq!(
            refused,
            Err(RegisterError::TooLate {
                id: "topfill_offset"
            })
        );
        assert_eq!(catalogue().len(), before);
    }
}
