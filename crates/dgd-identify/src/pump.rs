//! The pump's rungs: the head curve at fixed and at free exponents.

use crate::correlation::correlation_samples;
use crate::{Estimate, IdentifyOptions, PumpModel};
use dgd_pump::{
    ConstrainedFit, ConstrainedOptions, CurveFit, ExponentSearch, HeadCurve, Limit, PumpError,
    Samples, SearchStatus, ShapeCheck, SolverStatus, check_shape, fit_free_and_constrained,
    search_exponents,
};
use std::ops::RangeInclusive;

/// Above this the sums of the search are not to be trusted (see [`ExponentSearch::table_error`]).
const TABLE_ERROR: f64 = 1e-6;

/// Sum of squares, in units of the noise, that exponents other than 2 and 2 must gain: by noise
/// alone it exceeds 20 once in twenty thousand recordings (χ² of two degrees of freedom), of as many samples as are independent.
const GAIN: f64 = 20.0;

/// Share of the head's variance below which speed and flow do not explain it.
const EXPLAINED: f64 = 0.5;

/// The pump's rungs of the ladder.
#[derive(Debug, Clone, PartialEq)]
pub struct PumpRungs {
    /// Exponents 2 and 2, signs as they come (Eq. 3.31).
    pub plain: Result<CurveFit, PumpError>,
    /// Exponents 2 and 2, c1, c2 > 0.
    pub constrained: Result<ConstrainedFit, PumpError>,
    /// Exponents searched for (Eqs. 3.39-3.44); `None` if not asked for.
    pub search: Option<Result<ExponentSearch, PumpError>>,
    /// Whether the final curve falls and is concave over the speeds and flows recorded.
    pub shape: Result<ShapeCheck, PumpError>,
}

/// Fits the head curve rung by rung, and takes the highest that the samples bear.
pub(crate) fn fit_pump(
    samples: &Samples<'_>,
    options: &IdentifyOptions,
    warnings: &mut Vec<String>,
) -> Result<(PumpModel, PumpRungs), PumpError> {
    let fixed = || fit_free_and_constrained(samples, 2.0, 2.0, &ConstrainedOptions::default());
    let search = || search_exponents(samples, &options.search);
    let ranges = || {
        let of = |values| range_of(values, samples.keep);
        (of(samples.speed_pct), of(samples.flow_m3_s))
    };
    // The search is the longest: it begins at once.
    let (search, ((plain, constrained), (speeds, flows))) = rayon::join(
        || options.free_exponents.then(search),
        || rayon::join(fixed, ranges),
    );
    let found = search.as_ref().and_then(|search| {
        let search = search.as_ref().ok()?;
        let together = together(samples, &search.fit.curve);
        gains(samples, search, &constrained, together).then_some((search, together))
    });
    let chosen = if let Some((search, together)) = found {
        at_found(search, together, warnings)
    } else {
        warn_of_no_exponents(search.as_ref(), warnings);
        at_two_and_two(samples, &constrained, warnings)?
    };
    let shape = check_shape(&chosen.fit.curve, speeds, flows);
    warn_of_curve(&chosen.fit, &shape, warnings);
    let rungs = PumpRungs {
        plain,
        constrained,
        search,
        shape,
    };
    Ok((chosen.model(), rungs))
}

/// The curve of the rung that is taken.
struct Chosen {
    fit: CurveFit,
    /// Constraints on whose bounds it lies.
    active: Vec<String>,
    /// Standard errors of c0, c1 and c2, of as many samples as were fitted.
    errors: [Option<f64>; 3],
    /// How many samples tell as much as one that is independent.
    together: f64,
}

impl Chosen {
    fn model(self) -> PumpModel {
        let fit = self.fit;
        let widening = self.together.sqrt();
        let estimate = |value, index: usize| Estimate {
            value,
            standard_error: self.errors[index].map(|error| error * widening),
        };
        PumpModel {
            c0: estimate(fit.curve.c0, 0),
            c1: estimate(fit.curve.c1, 1),
            c2: estimate(fit.curve.c2, 2),
            n0: fit.curve.n0,
            n2: fit.curve.n2,
            mse_m2: fit.mse_m2,
            r2: fit.r2,
            samples: fit.n,
            condition: fit.condition,
            active_constraints: self.active,
        }
    }
}

/// How many samples of what a curve leaves over tell as much as one that is independent.
fn together(samples: &Samples<'_>, curve: &HeadCurve) -> f64 {
    correlation_samples(samples.keep.len(), |i| {
        let head = || samples.head_m[i] - curve.head_m(samples.speed_pct[i], samples.flow_m3_s[i]);
        samples.keep[i].then(head)
    })
}

/// Whether the exponents found fit better than 2 and 2 by more than two numbers fitted to noise
/// would: where speed and flow rest, any exponents fit alike.
fn gains(
    samples: &Samples<'_>,
    search: &ExponentSearch,
    constrained: &Result<ConstrainedFit, PumpError>,
    together: f64,
) -> bool {
    let fit = &search.fit;
    let poorer = match constrained {
        Ok(constrained) => Some(constrained.fit.mse_m2),
        Err(_) => fit_speed_alone(samples).map(|fit| fit.mse_m2),
    };
    let independent = fit.n as f64 / together;
    poorer.is_none_or(|mse_m2| (mse_m2 / fit.mse_m2 - 1.0) * independent > GAIN)
}

/// The curve at the exponents that were found.
fn at_found(search: &ExponentSearch, together: f64, warnings: &mut Vec<String>) -> Chosen {
    if search.joint.is_none() {
        warnings.push(
            "speed and flow do not separate the pump exponents from the coefficients: the standard errors assume known exponents"
                .into(),
        );
    }
    warn_of_search(search, warnings);
    let limits = search.limits.iter().map(|limit| name_of(*limit).to_owned());
    let active: Vec<String> = limits.collect();
    warn_of_bounds(&active, warnings);
    let fit = search.fit.clone();
    Chosen {
        active,
        errors: (search.joint).map_or(fit.standard_errors, |joint| joint.coefficients),
        together,
        fit,
    }
}

/// Says why exponents that were searched for are not used.
fn warn_of_no_exponents(
    search: Option<&Result<ExponentSearch, PumpError>>,
    warnings: &mut Vec<String>,
) {
    match search {
        Some(Err(reason)) => warnings.push(format!(
            "the exponents were not found ({reason}); 2 and 2 are used"
        )),
        Some(Ok(_)) => warnings.push(
            "the exponents were not found (no others fit better than 2 and 2 by more than noise); 2 and 2 are used"
                .into(),
        ),
        None => {}
    }
}

/// Says where the curve explains little, or is no pump's.
fn warn_of_curve(
    fit: &CurveFit,
    shape: &Result<ShapeCheck, PumpError>,
    warnings: &mut Vec<String>,
) {
    if fit.r2 < EXPLAINED {
        warnings.push(format!(
            "the head curve explains only {:.0} % of the head variance: speed and flow hardly change, or are not those of the pump",
            100.0 * fit.r2.max(0.0)
        ));
    }
    if shape
        .as_ref()
        .is_ok_and(|s| !(s.falls_with_flow && s.concave))
    {
        warnings.push(
            "the head curve does not fall and curve downwards over the whole recorded range".into(),
        );
    }
}

fn warn_of_search(search: &ExponentSearch, warnings: &mut Vec<String>) {
    match search.status {
        SearchStatus::Converged => {}
        SearchStatus::RestartLimit => {
            warnings.push(
                "the search for exponents was still improving when its restarts ended".into(),
            );
        }
        SearchStatus::IterationLimit => {
            warnings.push("the search for exponents ran into its iteration limit".into());
        }
        _ => warnings.push("the search for exponents stopped early".into()),
    }
    if search.table_error > TABLE_ERROR {
        warnings.push(format!(
            "the search for exponents resolved its errors only to {:.0e} of their size",
            search.table_error
        ));
    }
}

fn warn_of_bounds(active: &[String], warnings: &mut Vec<String>) {
    if !active.is_empty() {
        warnings.push(format!(
            "the head curve lies on the bound {}",
            active.join(", ")
        ));
    }
}

/// The constrained fit at exponents 2 and 2, or `c0 w²` where even that is not excited.
fn at_two_and_two(
    samples: &Samples<'_>,
    constrained: &Result<ConstrainedFit, PumpError>,
    warnings: &mut Vec<String>,
) -> Result<Chosen, PumpError> {
    let (fit, active) = match constrained {
        Ok(constrained) => {
            match constrained.status {
                SolverStatus::Solved | SolverStatus::AlmostSolved => {}
                status => warnings.push(format!(
                    "the constrained head curve was not solved ({status:?})"
                )),
            }
            let names = ["c0 > 0", "c1 > 0", "c2 > 0"].into_iter();
            let held = names.zip(constrained.active).filter(|(_, active)| *active);
            let held: Vec<String> = held.map(|(name, _)| name.to_owned()).collect();
            warn_of_bounds(&held, warnings);
            (constrained.fit.clone(), held)
        }
        Err(refusal @ PumpError::Fit(_)) => {
            let fit = fit_speed_alone(samples).ok_or_else(|| refusal.clone())?;
            warnings.push(format!(
                "c0 w^2 - c1 w q - c2 q^2 was rejected ({refusal}); c0 w^2 alone was fitted"
            ));
            (fit, vec!["c1 > 0".to_owned(), "c2 > 0".to_owned()])
        }
        Err(refusal) => return Err(refusal.clone()),
    };
    Ok(Chosen {
        active,
        errors: fit.standard_errors,
        together: together(samples, &fit.curve),
        fit,
    })
}

/// `H = c0 w²` by least squares; `None` with fewer than two samples or a pump at rest.
fn fit_speed_alone(samples: &Samples<'_>) -> Option<CurveFit> {
    let kept = || {
        let rows = samples.speed_pct.iter().zip(samples.head_m);
        let kept = rows.zip(samples.keep).filter(|(_, keep)| **keep);
        kept.map(|((w, head), _)| (w * w, *head))
    };
    let (mut n, mut xx, mut xh, mut sum) = (0_u64, 0.0, 0.0, 0.0);
    for (x, head) in kept() {
        n += 1;
        xx += x * x;
        xh += x * head;
        sum += head;
    }
    if n < 2 || xx <= 0.0 {
        return None;
    }
    let (c0, mean) = (xh / xx, sum / n as f64);
    let (mut rss, mut total) = (0.0, 0.0);
    for (x, head) in kept() {
        rss += (head - c0 * x).powi(2);
        total += (head - mean).powi(2);
    }
    let mse_m2 = rss / (n - 1) as f64;
    Some(CurveFit {
        curve: HeadCurve {
            c0,
            c1: 0.0,
            c2: 0.0,
            n0: 2.0,
            n2: 2.0,
        },
        standard_errors: [Some((mse_m2 / xx).sqrt()), None, None],
        mse_m2,
        r2: if total > 0.0 {
            1.0 - rss / total
        } else {
            f64::NAN
        },
        n,
        condition: 1.0,
    })
}

/// The constraint that a limit of the search stands for.
fn name_of(limit: Limit) -> &'static str {
    match limit {
        Limit::C1Zero => "c1 > 0",
        Limit::C2Zero => "c2 > 0",
        Limit::N2Lower => "n2 > 1",
        Limit::N2Upper => "n2 at the top of its range",
        Limit::N0Lower => "n0 at the bottom of its range",
        Limit::N0Upper => "n0 at the top of its range",
        _ => "another limit of the search",
    }
}

fn range_of(values: &[f64], keep: &[bool]) -> RangeInclusive<f64> {
    // In lanes: none waits for the one before.
    const LANES: usize = 8;
    let (mut low, mut high) = ([f64::INFINITY; LANES], [0.0_f64; LANES]);
    for (values, keep) in values.chunks(LANES).zip(keep.chunks(LANES)) {
        let lanes = low.iter_mut().zip(&mut high);
        for ((value, keep), (low, high)) in values.iter().zip(keep).zip(lanes) {
            // A NaN compares false.
            let value = if *keep { *value } else { f64::NAN };
            *low = if value < *low { value } else { *low };
            *high = if value > *high { value } else { *high };
        }
    }
    let low = low.into_iter().fold(f64::INFINITY, f64::min);
    let high = high.into_iter().fold(0.0, f64::max);
    low.max(0.0).min(high)..=high
}
