//! `model.toml`: an identified model with its doubt and its provenance, and what a diagnosis added to it.

mod read;
mod write;

pub use read::{read_model, read_model_document};
pub(crate) use write::float;
pub use write::{write_model, write_model_document};

use dgd_effects::AugmentedModel;
use dgd_identify::Model;
use dgd_recording::Geometry;

/// Schema of the document that [`write_model`] writes and [`read_model`] reads.
pub const MODEL_SCHEMA: &str = "dgd.model/1";

/// A whole `model.toml`.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelDocument {
    /// The model of Eqs. 3.45-3.46, or the well alone where it could not be identified.
    pub base: Base,
    /// The model of a diagnosis: curves of free shape, and effects.
    pub augmented: Option<AugmentedModel>,
}

/// What an augmented model stands on.
#[derive(Debug, Clone, PartialEq)]
pub enum Base {
    /// An identified two-state model.
    Identified(Box<Model>),
    /// Mud and geometry only; there must be an augmented model then.
    WellOnly {
        /// Mud density, kg/m³.
        density_kg_m3: f64,
        /// Diameters and depths.
        geometry: Geometry,
    },
}

impl ModelDocument {
    /// The two-state model, if there is one.
    pub fn model(&self) -> Option<&Model> {
        match &self.base {
            Base::Identified(model) => Some(model),
            Base::WellOnly { .. } => None,
        }
    }

    /// Mud density, kg/m³, and geometry of the well that the model was identified on.
    pub fn well(&self) -> (f64, &Geometry) {
        match &self.base {
            Base::Identified(model) => (model.density_kg_m3, &model.geometry),
            Base::WellOnly {
                density_kg_m3,
                geometry,
            } => (*density_kg_m3, geometry),
        }
    }
}
