//! Constants of nature and of the thesis's Table 2.3.

/// Gravity, m/s².
pub(crate) const GRAVITY_M_S2: f64 = 9.80665;
/// Standard atmosphere, Pa.
pub(crate) const ATMOSPHERE_PA: f64 = 101_325.0;
/// One inch, m.
pub(crate) const INCH_M: f64 = 0.0254;
/// One US gallon per minute, m³/s (Table 2.3).
pub(crate) const GPM_M3_S: f64 = 6.3090e-5;
/// One psi, Pa (Table 2.3).
pub(crate) const PSI_PA: f64 = 6_894.757_29;

/// A non-negative number as an index, clamped to `max`.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped to 0..=max before the cast; NaN casts to 0"
)]
pub(crate) fn index(x: f64, max: usize) -> usize {
    (x.clamp(0.0, max as f64) as usize).min(max)
}
