//! Evidence: Bayes factors and their means.

/// ln of the standard normal distribution function, by its tail for the far left.
pub(crate) fn ln_phi(x: f64) -> f64 {
    if x < -5.0 {
        return -0.5 * x * x - (-x * (2.0 * std::f64::consts::PI).sqrt()).ln();
    }
    // Abramowitz and Stegun 26.2.17.
    let t = 1.0 / (1.0 + 0.231_641_9 * x.abs());
    let poly = t
        * (0.319_381_530
            + t * (-0.356_563_782
                + t * (1.781_477_937 + t * (-1.821_255_978 + t * 1.330_274_429))));
    let tail = poly * (-0.5 * x * x).exp() / (2.0 * std::f64::consts::PI).sqrt();
    (if x >= 0.0 { 1.0 - tail } else { tail }).max(1e-300).ln()
}

/// Evidence of a strength with a normal prior of the given width, cut at 0 for effects of one sign.
pub(crate) fn evidence(energy: f64, score: f64, width: f64, one_sided: bool) -> f64 {
    let v = 1.0 / (energy + 1.0 / (width * width));
    let ln = 0.5 * score * score * v - 0.5 * (1.0 + width * width * energy).ln();
    if one_sided {
        ln + std::f64::consts::LN_2 + ln_phi(score * v.sqrt())
    } else {
        ln
    }
}

/// Evidence of a strength at which the curves were fitted again, so many widths of its prior away from nothing.
///
/// - `saved`: by what the misfit is less.
/// - `energy`: of the signature of one width, as if it were straight that far.
pub(crate) fn evidence_at(widths: f64, energy: f64, saved: f64) -> f64 {
    saved - 0.5 * (widths * widths + (1.0 + energy).ln())
}

/// ln of the mean of exponentials.
pub(crate) fn ln_mean_exp(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let top = values.clone().fold(f64::NEG_INFINITY, f64::max);
    if !top.is_finite() {
        return top;
    }
    let (mut sum, mut count) = (0.0, 0.0);
    for v in values {
        sum += (v - top).exp();
        count += 1.0;
    }
    top + (sum / f64::max(count, 1.0)).ln()
}

#[cfg(test)]
mod tests;
