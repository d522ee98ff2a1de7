//! Whether a curve falls with flow and is concave: thesis Eqs. 3.40-3.44 over a range.

use crate::{HeadCurve, PumpError};
use std::ops::RangeInclusive;

/// A place in the operating range and the value there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Speed, percent.
    pub speed_pct: f64,
    /// Flow, m³/s.
    pub flow_m3_s: f64,
    /// The derivative asked about, in its units.
    pub value: f64,
}

/// Answers of [`check_shape`], each with the worst place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShapeCheck {
    /// Head nowhere rises with flow: ∂H/∂q <= 0.
    pub falls_with_flow: bool,
    /// Where ∂H/∂q is largest, m/(m³/s).
    pub worst_slope: Place,
    /// The curve is nowhere convex in flow: ∂²H/∂q² <= 0.
    pub concave: bool,
    /// Where ∂²H/∂q² is largest, m/(m³/s)².
    pub worst_bend: Place,
    /// Head nowhere falls with speed: ∂H/∂w >= 0.
    pub rises_with_speed: bool,
    /// Where ∂H/∂w is smallest, m/%.
    pub worst_gain: Place,
}

/// Checks monotonicity and concavity of a curve over an operating range.
///
/// - `speed_pct`, `flow_m3_s`: closed ranges, at least 0 and not empty.
///
/// Exact, not sampled: each derivative is monotone in speed and in flow for flow of at least 0, so its
/// extremes are at corners of the range.
///
/// # Errors
/// [`PumpError::Domain`] on an empty, negative or non-finite range, or a curve that is not finite.
///
/// # Source
/// Thesis Eqs. 3.40-3.44; against a grid: `tests/it/shape.rs`.
///
/// ```
/// use dgd_pump::{HeadCurve, check_shape};
/// let convex = HeadCurve { c0: 0.05, c1: 20.0, c2: -1e4, n0: 2.0, n2: 2.0 };
/// let shape = check_shape(&convex, 30.0..=70.0, 0.0..=0.05)?;
/// assert!(!shape.concave && !shape.falls_with_flow);
/// assert_eq!(shape.worst_slope.flow_m3_s, 0.05);
/// # Ok::<(), dgd_pump::PumpError>(())
/// ```
pub fn check_shape(
    curve: &HeadCurve,
    speed_pct: RangeInclusive<f64>,
    flow_m3_s: RangeInclusive<f64>,
) -> Result<ShapeCheck, PumpError> {
    for (name, range) in [("speed_pct", &speed_pct), ("flow_m3_s", &flow_m3_s)] {
        let (from, to) = (*range.start(), *range.end());
        if !(from >= 0.0 && from <= to && to.is_finite()) {
            return Err(PumpError::Domain {
                name,
                found: if from >= 0.0 { to } else { from },
                expected: "a rising finite range from 0 or above",
            });
        }
    }
    let HeadCurve { c0, c1, c2, n0, n2 } = *curve;
    for (name, found) in [("c0", c0), ("c1", c1), ("c2", c2), ("n0", n0), ("n2", n2)] {
        if !found.is_finite() {
            return Err(PumpError::Domain {
                name,
                found,
                expected: "a finite number",
            });
        }
    }
    let largest = |value: &dyn Fn(f64, f64) -> f64| {
        let mut worst: Option<Place> = None;
        for w in [*speed_pct.start(), *speed_pct.end()] {
            for q in [*flow_m3_s.start(), *flow_m3_s.end()] {
                let place = Place {
                    speed_pct: w,
                    flow_m3_s: q,
                    value: value(w, q),
                };
                if worst.is_none_or(|worst| place.value > worst.value) {
                    worst = Some(place);
                }
            }
        }
        worst.unwrap_or(Place {
            speed_pct: f64::NAN,
            flow_m3_s: f64::NAN,
            value: f64::NAN,
        })
    };
    let worst_slope = largest(&|w, q| curve.slope_flow(w, q));
    let worst_bend = largest(&|_, q| curve.bend_flow(q));
    let mut worst_gain = largest(&|w, q| -curve.slope_speed(w, q));
    worst_gain.value = -worst_gain.value;
    Ok(ShapeCheck {
        falls_with_flow: worst_slope.value <= 0.0,
        worst_slope,
        concave: worst_bend.value <= 0.0,
        worst_bend,
        rises_with_speed: worst_gain.value >= 0.0,
        worst_gain,
    })
}
