//! Recordings and models in percent of undisclosed references.
//!
//! [`choose_references`] picks what stands for 100 %, [`mask_recording`] and
//! [`mask_model`] express a screened recording and its model in it (Eqs. 3.9-3.12).
//! What they return holds no geometry, density, absolute pressure, tag or time of
//! day, and no quantisation step that would give a reference away. This crate opens
//! no file.
//!
//! # What a reader of the masked data can and cannot find
//! Ratios of references are in the data and cannot be hidden: the mass balance
//! (Eq. 3.45) fixes q₁₀₀/(A_a h₁₀₀), the pressure balance (Eq. 4.2) fixes h₁₀₀/H₁₀₀,
//! F₁₀₀/(ρ g H₁₀₀) and, in percent of H₁₀₀, by how much the pump's outlet is deeper than its
//! inlet. The scale itself is in none of them. It would be in the
//! transmitters' quantisation (0.5 gpm is a fixed share of q₁₀₀), so every flow and every
//! pressure gets noise before anything is worked out of it: a share of the reference, on all
//! time scales, and always the same for the same samples. The README has the whole threat model.
#![deny(missing_docs)]

mod dither;
mod model;
mod recording;
mod references;

// What the functions here take, so that their user need not name the crates below.
pub use dgd_identify::{Model, Prepared, Series};
pub use dgd_units::MaskReferences;
pub use model::{MaskedEstimate, MaskedModel, MaskedTerm, mask_model};
pub use recording::{MaskedRecording, mask_recording};
pub use references::{MaskingError, choose_references};

/// The README's examples are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
