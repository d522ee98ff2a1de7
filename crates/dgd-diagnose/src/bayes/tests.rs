//! Claims about evidence.

use super::{evidence, ln_mean_exp, ln_phi};

/// ln of the integral of likelihood ratio times prior, by the trapezoidal rule.
fn integrated(energy: f64, score: f64, width: f64, one_sided: bool) -> f64 {
    let v = 1.0 / (energy + 1.0 / (width * width));
    let (mode, sd) = (score * v, v.sqrt());
    let n = 40_000;
    let (mut from, to) = (mode - 12.0 * sd, (mode + 12.0 * sd).max(12.0 * sd));
    if one_sided {
        from = from.max(0.0);
    }
    let step = (to - from) / f64::from(n);
    let prior = if one_sided { 2.0 } else { 1.0 } / (width * (2.0 * std::f64::consts::PI).sqrt());
    let ln = |a: f64| score * a - 0.5 * a * a / v;
    let top = ln(if one_sided { mode.max(0.0) } else { mode });
    let sum: f64 = (0..=n)
        .map(|i| {
            let share = if i == 0 || i == n { 0.5 } else { 1.0 };
            share * (ln(from + f64::from(i) * step) - top).exp()
        })
        .sum();
    top + (prior * sum * step).ln()
}

#[test]
fn evidence_is_the_integral_over_the_prior() {
    for (energy, score, width) in [
        (40.0, 25.0, 1.0),
        (40.0, 0.0, 1.0),
        (3.0, 12.0, 0.3),
        (900.0, 300.0, 2.0),
        (0.0, 0.0, 5.0),
    ] {
        for one_sided in [false, true] {
            let off = evidence(energy, score, width, one_sided)
                - integrated(energy, score, width, one_sided);
            assert!(
                off.abs() < 1e-5,
                "{energy} {score} {width} {one_sided}: {off}"
            );
        }
    }
}

#[test]
fn the_wrong_sign_counts_against_an_effect_of_one_sign() {
    let (energy, width) = (40.0, 1.0);
    let (wrong, right) = (
        evidence(energy, -15.0, width, true),
        evidence(energy, 15.0, width, true),
    );
    assert!(wrong < 0.0 && right > 0.0);
    assert!((wrong - integrated(energy, -15.0, width, true)).abs() < 1e-3);
    // A prior of both signs does not ask.
    let both = |score| evidence(energy, score, width, false);
    assert_eq!(both(-15.0), both(15.0));
}

#[test]
fn the_tail_of_the_normal_distribution_goes_on_below_five_deviations() {
    // Abramowitz and Stegun, table 26.1, and the asymptotic series.
    for (x, expected, within) in [
        (0.0, -std::f64::consts::LN_2, 1e-6),
        (1.0, 0.841_344_746_f64.ln(), 1e-6),
        (-2.0, 0.022_750_132_f64.ln(), 1e-4),
        (-6.0, 9.865_876e-10_f64.ln(), 0.03),
        (-20.0, -203.917_155, 0.003),
    ] {
        assert!((ln_phi(x) - expected).abs() < within, "{x}: {}", ln_phi(x));
    }
}

#[test]
fn a_mean_of_exponentials_stands_what_overflows() {
    let found = ln_mean_exp([1000.0, 1000.0, f64::NEG_INFINITY, f64::NEG_INFINITY].into_iter());
    assert!((found - (1000.0 - std::f64::consts::LN_2)).abs() < 1e-9);
    assert_eq!(ln_mean_exp(std::iter::empty()), f64::NEG_INFINITY);
}
