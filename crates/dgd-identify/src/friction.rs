//! The friction's rungs: the sweep, the final law and the poorer ones.

use crate::correlation::correlation_samples;
use crate::{Estimate, FrictionModel, FrictionTerm, IdentifyOptions};
use dgd_friction::{
    DelayScan, DelaySweep, FrictionError, Loss, Minimum, PolynomialFit, Samples, SweepOptions,
    Terms, delay_scan,
};
use dgd_lsq::RobustStatus;

/// Share of the friction's variance that a law with an offset must explain.
///
/// Noise of the flow meter draws such a law towards a constant `B`, its other terms by about the
/// share it does not explain: below one half more of it is noise than flow.
const EXPLAINED: f64 = 0.5;

/// The errors of a law at every delay asked for.
pub(crate) fn scan(
    samples: &Samples<'_>,
    terms: &Terms,
    step_s: f64,
    options: &IdentifyOptions,
) -> Result<DelayScan, FrictionError> {
    let settings = SweepOptions {
        delays: options.delays.clone(),
        dt_s: step_s,
        loss: options.loss,
    };
    delay_scan(samples, terms, &settings)
}

pub(crate) fn warn_of_sweep(sweep: &DelaySweep, warnings: &mut Vec<String>) {
    if sweep.delays_s.len() == 1 {
        return; // the caller knows the delay
    }
    let best = sweep.delays_s[sweep.best];
    let finite = sweep.mse_pa2.iter().copied().filter(|m| m.is_finite());
    let worst = finite.fold(0.0, f64::max);
    // Noise alone moves a mean square by about √(2/n) of itself.
    let n = sweep.n[sweep.best].max(1) as f64;
    if worst - sweep.mse_pa2[sweep.best] < 3.0 * (2.0 / n).sqrt() * worst {
        warnings.push(format!(
            "the delay of {best} s cannot be determined: the flow hardly changes"
        ));
        return; // where the least lies then means nothing
    }
    match sweep.minimum {
        // A delay of 0 at the start of the range is an answer, not an edge.
        Minimum::AtFirst if best != 0.0 => {
            warnings.push(format!(
                "the best delay, {best} s, is the first of the range: sweep further down"
            ));
        }
        Minimum::AtLast => {
            warnings.push(format!(
                "the best delay, {best} s, is the last of the range: sweep further up"
            ));
        }
        _ => {}
    }
}

/// B below which a full line of the mud described does not stand on the outlet, Pa: beyond what transmitters are usually off by.
const LIGHTEST_PA: f64 = -2e5;
/// B above which the yield stress of few muds keeps the outlet up, Pa: 20 Pa in 350 m of a line 6 in wide make 1.8 bar. Set by hand.
const HEAVIEST_PA: f64 = 2e5;

/// Eq. 3.26, or the richest poorer law that the recording excites.
pub(crate) fn final_friction(
    samples: &Samples<'_>,
    delay: i64,
    cubic: &Result<PolynomialFit, FrictionError>,
    loss: Loss,
    warnings: &mut Vec<String>,
) -> Result<FrictionModel, FrictionError> {
    let refused = match cubic {
        Ok(fit) if explained(fit) >= EXPLAINED => None,
        Ok(fit) => Some(format!(
            "explains only {:.0} % of the friction's variance",
            100.0 * explained(fit).max(0.0)
        )),
        Err(FrictionError::Fit(reason)) => Some(format!("was refused ({reason})")),
        Err(other) => return Err(other.clone()),
    };
    let fit = match (cubic, refused) {
        (Ok(fit), None) => fit.clone(),
        (_, reason) => {
            let (fit, law) = poorer_law(samples, delay, loss)?;
            let reason = reason.unwrap_or_default();
            warnings.push(format!("B + D q^2 + E q^3 {reason}; {law} was fitted"));
            fit
        }
    };
    if let Some(robust) = &fit.robust
        && robust.status != RobustStatus::Converged
    {
        warnings.push(format!(
            "the robust friction fit did not converge ({:?} after {} rounds)",
            robust.status, robust.iterations
        ));
    }
    for (power, letter) in [(2.0, "D"), (3.0, "E")] {
        if fit.law.coefficient(power).is_some_and(|c| c < 0.0) {
            warnings.push(format!(
                "{letter} is negative: do not use the friction law outside the recorded flows"
            ));
        }
    }
    let at_rest_pa = fit.law.coefficient(0.0).unwrap_or(0.0);
    if at_rest_pa < LIGHTEST_PA {
        warnings.push(format!(
            "B is {:.1} bar, but friction at rest cannot be negative: is the density too high, the outlet less deep, or an outlet transmitter wrong?",
            1e-5 * at_rest_pa
        ));
    }
    if at_rest_pa > HEAVIEST_PA {
        warnings.push(format!(
            "B is {:.1} bar, more friction at rest than the yield stress of a mud makes as a rule: is the density too low, the outlet deeper, or an outlet \
             transmitter wrong?",
            1e-5 * at_rest_pa
        ));
    }
    let ahead = |t: usize| {
        let at = i64::try_from(t).ok()?.checked_add(delay)?;
        samples.flow_m3_s.get(usize::try_from(at).ok()?).copied()
    };
    let together = correlation_samples(samples.keep.len(), |t| {
        let used = samples.keep[t].then(|| ahead(t)).flatten();
        used.map(|q| samples.friction_pa[t] - fit.law.eval(q))
    });
    let widening = together.sqrt();
    let terms = fit
        .law
        .powers
        .iter()
        .zip(fit.law.coefficients.iter().zip(&fit.standard_errors));
    let power_of = |power: f64| [0_u8, 1, 2, 3].into_iter().find(|p| f64::from(*p) == power);
    let terms = terms
        .filter_map(|(power, (value, error))| {
            let coefficient = Estimate {
                value: *value,
                standard_error: Some(widening * error),
            };
            power_of(*power).map(|power| FrictionTerm { power, coefficient })
        })
        .collect();
    Ok(FrictionModel {
        terms,
        mse_pa2: fit.mse_pa2,
        r2: fit.r2,
        samples: fit.n,
        condition: fit.condition,
    })
}

/// `B + D q²` if it explains enough, else the textbook's `D q²`.
fn poorer_law(
    samples: &Samples<'_>,
    delay: i64,
    loss: Loss,
) -> Result<(PolynomialFit, &'static str), FrictionError> {
    let law = |powers| dgd_friction::fit(samples, delay, &Terms::Powers(powers), loss);
    match law(vec![0.0, 2.0]) {
        Ok(fit) if explained(&fit) >= EXPLAINED => Ok((fit, "B + D q^2")),
        _ => Ok((law(vec![2.0])?, "D q^2")),
    }
}

/// Share of the variance explained; of a robust fit, without what outliers add to its residuals.
fn explained(fit: &PolynomialFit) -> f64 {
    let left = fit
        .robust
        .map_or(1.0, |r| (r.scale_pa.powi(2) / fit.mse_pa2).min(1.0));
    1.0 - (1.0 - fit.r2) * left
}
