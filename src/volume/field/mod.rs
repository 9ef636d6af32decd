//! Procedural fields with exact gradients: test bodies whose pictures can be computed by hand.
//!
//! A field is defined on the unit box, `p ∈ [0, 1]³`, and each documents its own coordinates.

mod hydrogen;
mod marschner_lobb;
mod shepp_logan;
mod simple;

use super::voxels::Voxels;
use super::{GridError, Volume, voxel_count};
use glam::DVec3;
use rayon::prelude::*;

pub use hydrogen::Hydrogen;
pub use marschner_lobb::MarschnerLobb;
pub use shepp_logan::{Rotation, SheppLogan};
pub use simple::{Axis, Cloud, Constant, Ramp, Sphere};

/// A scalar function on the unit box with its gradient.
pub trait Field: Sync {
    /// The value at `p ∈ [0, 1]³`.
    fn value(&self, p: DVec3) -> f64;

    /// The gradient at `p ∈ [0, 1]³` with respect to the field's own coordinates; 0 where it does not exist.
    fn gradient(&self, p: DVec3) -> DVec3;

    /// The extent of the unit box in the field's own coordinates: ∂value/∂p = gradient · extent per axis.
    fn extent(&self) -> DVec3 {
        DVec3::ONE
    }
}

/// A parameter of a field is out of its range. The text is `what is wrong; what would be right`.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{problem}; {remedy}")]
pub struct FieldError {
    /// The parameter, as scene files spell it.
    pub parameter: &'static str,
    problem: String,
    remedy: String,
}

impl FieldError {
    fn new(parameter: &'static str, given: impl std::fmt::Display, remedy: impl Into<String>) -> Self {
        Self { parameter, problem: format!("`{parameter}` is {given}"), remedy: remedy.into() }
    }
}

impl From<FieldError> for crate::Error {
    fn from(error: FieldError) -> Self {
        Self::Input(error.to_string())
    }
}

/// Any of the procedural fields.
#[derive(Debug, Clone, PartialEq)]
pub enum AnyField {
    /// The same everywhere.
    Constant(Constant),
    /// Linear along an axis.
    Ramp(Ramp),
    /// Signed distance to a sphere.
    Sphere(Sphere),
    /// The reconstruction test signal.
    MarschnerLobb(MarschnerLobb),
    /// The head phantom of tomography.
    SheppLogan(SheppLogan),
    /// An electron density of the hydrogen atom.
    Hydrogen(Hydrogen),
    /// A smooth cloud.
    Cloud(Cloud),
}

impl AnyField {
    fn inner(&self) -> &dyn Field {
        match self {
            Self::Constant(field) => field,
            Self::Ramp(field) => field,
            Self::Sphere(field) => field,
            Self::MarschnerLobb(field) => field,
            Self::SheppLogan(field) => field,
            Self::Hydrogen(field) => field,
            Self::Cloud(field) => field,
        }
    }
}

impl Field for AnyField {
    fn value(&self, p: DVec3) -> f64 {
        self.inner().value(p)
    }

    fn gradient(&self, p: DVec3) -> DVec3 {
        self.inner().gradient(p)
    }

    fn extent(&self) -> DVec3 {
        self.inner().extent()
    }
}

/// Samples a field at voxel centres `p = (i + ½)/n` into `float32` voxels of spacing 1.
///
/// # Errors
/// When an extent is 0 or the voxels do not fit into memory.
pub fn sample(field: &impl Field, dims: [usize; 3]) -> Result<Volume, GridError> {
    let count = voxel_count(dims)?;
    let mut values: Vec<f32> = Vec::new();
    values.try_reserve_exact(count).map_err(|_| GridError::Memory(dims))?;
    values.resize(count, 0.0);
    let [nx, ny, nz] = dims;
    values.par_chunks_mut(nx).enumerate().for_each(|(row, voxels)| {
        let y = centre(row % ny, ny);
        let z = centre(row / ny, nz);
        for (i, voxel) in voxels.iter_mut().enumerate() {
            *voxel = field.value(DVec3::new(centre(i, nx), y, z)) as f32;
        }
    });
    Volume::new(dims, DVec3::ONE, Voxels::F32(values))
}

fn centre(index: usize, count: usize) -> f64 {
    (index as f64 + 0.5) / count as f64
}

#[cfg(test)]
mod tests;
