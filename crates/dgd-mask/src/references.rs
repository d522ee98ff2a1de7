//! What stands for 100 %.

use dgd_identify::{Prepared, Series};
use dgd_recording::Recording;
use dgd_units::{FullScale, MaskReferences};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sha2::{Digest, Sha256};

/// Why a recording was not masked.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MaskingError {
    /// No positive value to take a percentage of.
    #[error(
        "the recording has no positive {quantity} among its kept samples to take a percentage of"
    )]
    NothingPositive {
        /// Which quantity.
        quantity: &'static str,
    },
    /// What was screened does not belong together.
    #[error(transparent)]
    Prepared(#[from] dgd_screen::ScreenError),
    /// Level, friction and head are of another recording.
    #[error("`{name}` has {found} samples, expected {expected} as in the recording")]
    Length {
        /// The odd series.
        name: &'static str,
        /// Its length.
        found: usize,
        /// Length of the recording.
        expected: usize,
    },
    /// A reference is none: percentages are taken of positive numbers.
    #[error(transparent)]
    Reference(#[from] dgd_units::MaskError),
}

/// Chooses references between 1.05 and 1.6 times the largest kept value of each quantity.
///
/// The factors are drawn from a generator seeded by the recording itself, so the same
/// recording always gets the same references, and nobody without it can repeat the draw.
///
/// # Errors
/// [`MaskingError::NothingPositive`] if a quantity is nowhere positive.
pub fn choose_references(
    prepared: &Prepared,
    series: &Series,
) -> Result<MaskReferences, MaskingError> {
    let mut random = secret_generator(&prepared.recording);
    let mut reference = |quantity, values: &[f64]| {
        let kept = values
            .iter()
            .zip(&prepared.keep)
            .filter(|(_, keep)| **keep)
            .map(|(v, _)| *v);
        let largest = kept.fold(0.0, f64::max);
        let factor = factor(&mut random);
        if largest > 0.0 {
            Ok(largest * factor)
        } else {
            Err(MaskingError::NothingPositive { quantity })
        }
    };
    let flow_m3_s = reference("return flow", &prepared.recording.return_flow_m3_s)?;
    let friction_pa = reference("friction", &series.friction_pa)?;
    let head_m = reference("pump head", &series.head_m)?;
    let level_m = reference("riser level", &series.level_m)?;
    Ok(MaskReferences::new(FullScale {
        flow_m3_s,
        friction_pa,
        head_m,
        level_m,
    })?)
}

/// From 1.05 to below 1.6, in 2^52 steps.
///
/// From the generator's bits, as they are specified: what `rand` makes of them may change from release to release, and then
/// the references of a rig.
fn factor(random: &mut ChaCha8Rng) -> f64 {
    const LEAST: f64 = 1.05;
    const MOST: f64 = 1.6;
    let share = (random.next_u64() >> 12) as f64 * f64::EPSILON;
    share * (MOST - LEAST) + LEAST
}

/// A generator that only the owner of the recording can seed.
fn secret_generator(recording: &Recording) -> ChaCha8Rng {
    let mut digest = Sha256::new_with_prefix(b"references");
    for (_, values) in recording.series() {
        for value in values {
            digest.update(value.to_le_bytes());
        }
    }
    ChaCha8Rng::from_seed(digest.finalize().into())
}
