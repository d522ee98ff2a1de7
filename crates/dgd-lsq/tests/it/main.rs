//! Public behaviour of `dgd-lsq`, as claims.
#![allow(
    clippy::unwrap_used,
    clippy::cast_precision_loss,
    reason = "a test may panic"
)]

mod fit;
mod refusals;
mod robust;

/// Deterministic noise of mean 0 in -1..1.
pub(crate) fn noise(i: u32) -> f64 {
    let mut z = u64::from(i).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    f64::from(u32::try_from((z ^ (z >> 31)) >> 32).unwrap()) / 2f64.powi(31) - 1.0
}
