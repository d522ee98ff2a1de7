//! The textbook laws: pressure drops of lines, valves and centrifugal pumps.

use crate::Dual;
use crate::kinds::{centrifugal, line, valve};
use std::f64::consts::PI;

/// Pressure drop below which a square law goes over into a linear one, Pa: a micrometre of water. Without it the
/// slope of √dp at rest is infinite.
pub(crate) const LINEAR_BELOW_PA: f64 = 0.01;

/// Friction law of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Friction {
    #[default]
    Polynomial,
    Darcy,
    Power,
    None,
}

/// `k·q·sqrt(q² + q0²)`, that is `k·q|q|` but for drops near [`LINEAR_BELOW_PA`].
#[inline(always)]
pub(crate) fn square(k: f64, q: Dual) -> Dual {
    if k == 0.0 {
        return Dual::constant(0.0);
    }
    let soft = LINEAR_BELOW_PA / k.abs();
    let root = (q.v * q.v + soft).sqrt();
    Dual {
        v: k * q.v * root,
        d: k * q.d * (root + q.v * q.v / root),
    }
}

/// The flow at which [`square`] gives `drop`, with its derivative by the drop.
#[inline(always)]
pub(crate) fn square_inverse(k: f64, drop: f64) -> Dual {
    let soft = LINEAR_BELOW_PA / k;
    let y = drop / k;
    let y2 = 2.0 * y * y;
    let inner = (soft * soft + 2.0 * y2).sqrt();
    let q2 = y2 / (soft + inner);
    let q = q2.sqrt();
    let root = (q2 + soft).sqrt();
    Dual {
        v: if drop < 0.0 { -q } else { q },
        d: 1.0 / (k * (root + q2 / root)),
    }
}

/// `k` of `dp = k q|q|` of a valve or orifice; a shut one has a huge one, and so has one whose opening is read as below 0.
#[inline(always)]
pub(crate) fn valve_square(own: &[f64], density: f64) -> f64 {
    let conductance = if own[valve::FLOW_COEFFICIENT].is_finite() {
        own[valve::FLOW_COEFFICIENT]
    } else if own[valve::DISCHARGE].is_finite() {
        own[valve::DISCHARGE] * own[valve::AREA] * (2.0 / density).sqrt()
    } else {
        own[valve::AREA] * (2.0 / (density * own[valve::LOSS])).sqrt()
    };
    let open = own[valve::OPENING].max(0.0) * conductance;
    // A shut valve keeps a millionth of a millionth: neighbours' pressures stay determined.
    1.0 / (open * open).max(1e-24)
}

/// Head of a centrifugal pump as a negative drop, Pa (Eq. 3.39; Eq. 2.28 with exponents 2).
#[inline(always)]
pub(crate) fn centrifugal_drop(own: &[f64], weight: f64, q: Dual) -> Dual {
    let w = own[centrifugal::SPEED].max(0.0);
    let swept = q.signed_pow(own[centrifugal::N2]);
    let head = own[centrifugal::C0] * w.powf(own[centrifugal::N0])
        - own[centrifugal::C1] * w * q
        - own[centrifugal::C2] * swept;
    -weight * head
}

/// Free cross-section of a line, m².
#[inline(always)]
pub(crate) fn line_area(own: &[f64]) -> f64 {
    if own[line::AREA].is_finite() {
        own[line::AREA]
    } else {
        0.25 * PI * (own[line::BORE] * own[line::BORE] - own[line::INNER] * own[line::INNER])
    }
}

/// Drop of a line: friction, fittings and rise, Pa.
#[inline(always)]
pub(crate) fn line_drop(
    law: Friction,
    own: &[f64],
    density: f64,
    viscosity: f64,
    gravity: f64,
    q: Dual,
) -> Dual {
    let mut drop = match law {
        Friction::None => Dual::constant(0.0),
        Friction::Polynomial => {
            let size = q.abs();
            own[line::CONSTANT]
                + own[line::LINEAR] * q
                + square(own[line::QUADRATIC], q)
                + own[line::CUBIC] * q * size * size
        }
        Friction::Power => power(own[line::POWER], own[line::EXPONENT], q),
        Friction::Darcy => darcy(own, density, viscosity, q),
    };
    if own[line::MINOR] > 0.0 {
        let area = line_area(own);
        drop = drop + square(0.5 * own[line::MINOR] * density / (area * area), q);
    }
    drop + density * gravity * own[line::ELEVATION]
}

/// `k·q·|q|^(n−1)`, linear below [`LINEAR_BELOW_PA`].
#[inline(always)]
fn power(k: f64, n: f64, q: Dual) -> Dual {
    if k <= 0.0 {
        return Dual::constant(0.0);
    }
    let soft = (LINEAR_BELOW_PA / k).powf(2.0 / n);
    k * q * (q * q + soft).powf(0.5 * (n - 1.0))
}

/// Reynolds numbers between which laminar goes over into turbulent flow.
const LAMINAR_BELOW: f64 = 2300.0;
const TURBULENT_ABOVE: f64 = 4000.0;

/// Darcy-Weisbach (Eq. 2.22) with 64/Re (2.23) and Haaland (2.24), blended in between so that the drop stays smooth.
fn darcy(own: &[f64], density: f64, viscosity: f64, q: Dual) -> Dual {
    let area = line_area(own);
    let diameter = own[line::BORE] - own[line::INNER];
    let v = q * (1.0 / area);
    let reynolds = v.abs() * (density * diameter / viscosity.max(1e-12));
    let laminar = 32.0 * viscosity * own[line::LENGTH] / (diameter * diameter) * v;
    if reynolds.v <= LAMINAR_BELOW {
        return laminar;
    }
    let rough = (own[line::ROUGHNESS] / (3.7 * diameter)).powf(1.11);
    let log = (6.9 / reynolds + rough).ln() * (-1.8 / std::f64::consts::LN_10);
    let factor = 1.0 / (log * log);
    let turbulent = factor * v * v.abs() * (0.5 * density * own[line::LENGTH] / diameter);
    if reynolds.v >= TURBULENT_ABOVE {
        return turbulent;
    }
    let s = (reynolds - LAMINAR_BELOW) * (1.0 / (TURBULENT_ABOVE - LAMINAR_BELOW));
    let weight = s * s * (3.0 - 2.0 * s);
    laminar + weight * (turbulent - laminar)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_of_the_square_law_gives_the_flow_back() {
        for k in [1e-3, 1.0, 1e8] {
            for q in [-0.3, -1e-5, 0.0, 1e-9, 0.02, 4.0] {
                let drop = square(k, Dual::variable(q));
                let back = square_inverse(k, drop.v);
                assert!(
                    (back.v - q).abs() <= 1e-12 * (1.0 + q.abs()),
                    "{k} {q} {}",
                    back.v
                );
                assert!((back.d * drop.d - 1.0).abs() < 1e-9, "{k} {q}");
            }
        }
    }

    #[test]
    fn a_valve_that_is_read_as_less_than_shut_is_shut() {
        let mut own = vec![f64::NAN; valve::COUNT];
        own[valve::FLOW_COEFFICIENT] = 1e-3;
        let mut at = |opening: f64| {
            own[valve::OPENING] = opening;
            valve_square(&own, 1000.0)
        };
        assert_eq!(at(-0.03), at(0.0));
        assert!(at(0.03) < 1e-6 * at(0.0));
    }

    #[test]
    fn darcy_rises_with_flow_through_the_transition_and_matches_eq_2_24_in_turbulence() {
        let mut own = vec![0.0; 13];
        own[line::LENGTH] = 100.0;
        own[line::BORE] = 0.1;
        own[line::ROUGHNESS] = 1e-4;
        own[line::AREA] = f64::INFINITY;
        let mut before = 0.0;
        for i in 1..2000 {
            let q = f64::from(i) * 1e-6;
            let now = darcy(&own, 1000.0, 1e-3, Dual::variable(q));
            assert!(now.v > before && now.d > 0.0, "{q}");
            before = now.v;
        }
        let q = 0.02;
        let re = 4.0 * 1000.0 / (PI * 0.1 * 1e-3) * q;
        let f = (-1.8 * (6.9 / re + (1e-4_f64 / 0.37).powf(1.11)).log10()).powi(-2);
        let expected = f * 8.0 * 1000.0 / (PI * PI * 0.1_f64.powi(5)) * q * q * 100.0;
        let found = darcy(&own, 1000.0, 1e-3, Dual::variable(q)).v;
        assert!((found / expected - 1.0).abs() < 1e-12);
    }
}
