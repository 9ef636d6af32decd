//! Volumes on the host: readers for files, and procedural fields.
//!
//! A [`Volume`] is a grid of scalar voxels, x fastest, in the type of its file. Voxel `(i, j, k)` is
//! centred at `((i + ½)·hx, (j + ½)·hy, (k + ½)·hz)` with spacing `h`, so the box is `[0, n·h]`.
//! [`read()`] fills one from NRRD, NIfTI-1, MetaImage or headerless raw files; [`field::sample`] from a formula.

mod error;
pub mod field;
mod metaimage;
mod nifti;
mod nrrd;
mod payload;
mod raw;
mod read;
mod source;
mod stored;
mod text;
mod voxels;

use glam::DVec3;

pub use error::{GridError, VolumeError, VolumeErrorKind};
pub use nrrd::Components;
pub use raw::RawOptions;
pub use read::read;
pub use stored::{Endian, StoredType};
pub use voxels::{VoxelType, Voxels};

/// A grid of scalar voxels with the remarks its reader made.
#[derive(Debug)]
pub struct Volume {
    /// Voxels along x, y and z; each at least 1.
    pub dims: [usize; 3],
    /// Distance between voxel centres along x, y and z, in the file's unit; each finite and positive.
    pub spacing: DVec3,
    /// The voxels as stored, x fastest.
    pub voxels: Voxels,
    /// Data value = `slope` · stored value + `intercept`; finite and not 0. It is 1 unless the file says so.
    pub slope: f64,
    /// See [`slope`](Self::slope); finite. It is 0 unless the file says so.
    pub intercept: f64,
    /// What a user should know about how the file was understood, one sentence each.
    pub notes: Vec<String>,
    /// How many stored voxels are NaN. They stay in the data.
    pub nan: u64,
    /// How many stored voxels are infinite, finite `float64` beyond the range of `float32` included.
    pub infinite: u64,
}

impl Volume {
    /// A volume whose data values are the stored values.
    ///
    /// # Errors
    /// When an extent is 0, the voxels are not as many as `dims` says, or a spacing is not finite and positive.
    pub fn new(dims: [usize; 3], spacing: DVec3, voxels: Voxels) -> Result<Self, GridError> {
        let count = voxel_count(dims)?;
        if voxels.len() != count {
            return Err(GridError::Count { dims, expected: count, found: voxels.len() });
        }
        if !spacing.to_array().iter().all(|h| h.is_finite() && *h > 0.0) {
            return Err(GridError::Spacing(spacing.to_array()));
        }
        let (nan, infinite) = voxels.count_non_finite();
        let notes = Vec::new();
        Ok(Self { dims, spacing, voxels, slope: 1.0, intercept: 0.0, notes, nan, infinite })
    }

    /// The data value at a voxel; coordinates beyond the grid are clamped to its border.
    pub fn value(&self, x: usize, y: usize, z: usize) -> f64 {
        let [nx, ny, nz] = self.dims;
        let clamp = |i: usize, n: usize| i.min(n.saturating_sub(1));
        let index = (clamp(z, nz) * ny + clamp(y, ny)) * nx + clamp(x, nx);
        // Only a volume whose public fields were made inconsistent has no such voxel.
        self.slope * self.voxels.get(index).unwrap_or(f64::NAN) + self.intercept
    }

    /// The smallest and largest finite data value; `None` when no voxel is finite.
    pub fn data_range(&self) -> Option<(f64, f64)> {
        let (low, high) = self.voxels.finite_range()?;
        let (a, b) = (self.slope * low + self.intercept, self.slope * high + self.intercept);
        (a.is_finite() && b.is_finite()).then(|| (a.min(b), a.max(b)))
    }

    /// The type the voxels are held in.
    pub fn voxel_type(&self) -> VoxelType {
        self.voxels.voxel_type()
    }

    /// Bytes the voxels occupy.
    pub fn memory_bytes(&self) -> u64 {
        self.voxels.as_bytes().len() as u64
    }

    /// The [`notes`](Self::notes), and one sentence more when voxels are not finite.
    pub fn remarks(&self) -> Vec<String> {
        let mut remarks = self.notes.clone();
        if self.nan > 0 || self.infinite > 0 {
            let (nan, infinite, all) = (self.nan, self.infinite, self.voxels.len());
            remarks.push(format!("{nan} of {all} voxels are NaN and {infinite} are infinite"));
        }
        remarks
    }
}

/// The product of the extents, refused when a `float64` grid of that size has no address range.
fn voxel_count(dims: [usize; 3]) -> Result<usize, GridError> {
    if dims.contains(&0) {
        return Err(GridError::Empty(dims));
    }
    let [nx, ny, nz] = dims;
    nx.checked_mul(ny)
        .and_then(|area| area.checked_mul(nz))
        .filter(|count| count.checked_mul(size_of::<f64>()).is_some_and(|b| isize::try_from(b).is_ok()))
        .ok_or(GridError::TooLarge(dims))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn volume(values: Vec<f32>) -> Volume {
        Volume::new([values.len(), 1, 1], DVec3::ONE, Voxels::F32(values)).unwrap()
    }

    #[test]
    fn x_is_fastest_and_coordinates_clamp() {
        let voxels = Voxels::U8((0..24).collect::<Vec<u8>>());
        let volume = Volume::new([2, 3, 4], DVec3::ONE, voxels).unwrap();
        assert_eq!(volume.value(1, 0, 0), 1.0);
        assert_eq!(volume.value(0, 1, 0), 2.0);
        assert_eq!(volume.value(0, 0, 1), 6.0);
        assert_eq!(volume.value(9, 9, usize::MAX), 23.0);
        assert_eq!(volume.memory_bytes(), 24);
    }

    #[test]
    fn range_skips_what_is_not_finite_and_applies_a_negative_slope() {
        let mut volume = volume(vec![f32::NAN, 2.0, f32::INFINITY, -1.0, f32::NEG_INFINITY]);
        assert_eq!((volume.nan, volume.infinite), (1, 2));
        assert_eq!(volume.data_range(), Some((-1.0, 2.0)));
        (volume.slope, volume.intercept) = (-2.0, 10.0);
        assert_eq!(volume.data_range(), Some((6.0, 12.0)));
        assert_eq!(volume.remarks(), ["1 of 5 voxels are NaN and 2 are infinite"]);
    }

    #[test]
    fn no_finite_voxel_has_no_range() {
        assert_eq!(volume(vec![f32::NAN, f32::INFINITY]).data_range(), None);
    }

    #[test]
    fn impossible_grids_are_refused() {
        let one = || Voxels::U8(vec![1]);
        let make = |dims, spacing| Volume::new(dims, spacing, one()).unwrap_err().to_string();
        assert_eq!(
            make([1, 0, 1], DVec3::ONE),
            "a grid of 1x0x1 voxels is empty; each extent must be at least 1"
        );
        assert!(make([usize::MAX, 2, 1], DVec3::ONE).contains("more than memory can address"));
        assert!(make([2, 1, 1], DVec3::ONE).contains("needs 2 voxels"));
        assert!(make([1, 1, 1], DVec3::new(1.0, f64::NAN, 1.0)).contains("finite and greater than 0"));
    }
}
