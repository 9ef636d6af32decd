//! A volume made ready on the host: where it lies, its window, and its bricks.

use super::grid::{BrickRanges, DeviceVolume, Grid, StoredWindow};
use super::local::LocalFrame;
use crate::scene::{self, Origin};
use crate::volume::Volume;
use crate::{Error, Result};
use bytemuck::Zeroable;
use glam::DVec3;

/// A volume made ready on the host.
pub struct PlannedVolume<'a> {
    /// The voxels and their window.
    pub grid: Grid<'a>,
    /// Bounds of the field.
    pub bricks: BrickRanges,
    /// Local units.
    pub local: LocalFrame,
    /// The window in data units.
    pub window: (f64, f64),
    pub(crate) device: DeviceVolume,
}

impl<'a> PlannedVolume<'a> {
    /// The volume in bricks of 2^`brick_shift` cells; adds to `notes` what the user should know.
    ///
    /// # Errors
    /// [`Error::Input`] when the window is empty or the grid is beyond what kernels index.
    pub fn new(
        settings: &scene::Volume,
        volume: &'a Volume,
        brick_shift: u32,
        notes: &mut Vec<String>,
    ) -> Result<Self> {
        check_extent(volume.dims)?;
        notes.extend(volume.notes.iter().cloned());
        notes.extend(non_finite_note(volume));
        let window = resolve_window(settings, volume, notes)?;
        let spacing = settings.spacing.unwrap_or(volume.spacing);
        let size = spacing * DVec3::from_array(volume.dims.map(|n| n as f64));
        let origin = match settings.origin {
            Origin::Corner(corner) => corner,
            Origin::Centre => size * -0.5,
        };
        let local = LocalFrame::new(origin, spacing, volume.dims);
        let grid = Grid::new(volume, StoredWindow::new(volume, window), local);
        let bricks = grid.brick_ranges(brick_shift);
        Ok(Self { grid, bricks, local, window, device: DeviceVolume::zeroed() })
    }
}

/// Kernels count voxels per axis in 32-bit integers and slices in 32-bit unsigned ones.
fn check_extent(dims: [usize; 3]) -> Result<()> {
    let slice = (dims[0] as u64 + 4).saturating_mul(dims[1] as u64 + 4);
    if dims.iter().any(|&n| n > (1 << 24)) || slice > u64::from(u32::MAX) {
        return Err(Error::Input(format!(
            "a volume of {}×{}×{} voxels is too large: an axis may have at most 2^24 voxels and an x-y slice 2^32",
            dims[0], dims[1], dims[2]
        )));
    }
    Ok(())
}

fn non_finite_note(volume: &Volume) -> Option<String> {
    (volume.nan + volume.infinite > 0).then(|| {
        format!(
            "{} NaN and {} infinite voxels: NaN and -inf count as the window's low end, +inf as its high end",
            volume.nan, volume.infinite
        )
    })
}

/// The scene's window, or the type's range for 8-bit data, or the range of the data.
fn resolve_window(settings: &scene::Volume, volume: &Volume, notes: &mut Vec<String>) -> Result<(f64, f64)> {
    use crate::volume::Voxels;
    if let Some(window) = settings.window {
        return Ok(window);
    }
    let eight_bit = |lo: f64, hi: f64| {
        let (a, b) = (volume.slope * lo + volume.intercept, volume.slope * hi + volume.intercept);
        (a.min(b), a.max(b))
    };
    let window = match volume.voxels {
        Voxels::U8(_) => eight_bit(0.0, 255.0),
        Voxels::I8(_) => eight_bit(-128.0, 127.0),
        _ => match volume.data_range() {
            Some((lo, hi)) if lo < hi => (lo, hi),
            Some((value, _)) => {
                notes
                    .push(format!("every voxel is {value}: the window runs from {value} to {}", value + 1.0));
                (value, value + 1.0)
            }
            None => {
                return Err(Error::Input(
                    "the volume holds no finite voxel; give `[volume] window = { lo = …, hi = … }` to draw it anyway"
                        .into(),
                ));
            }
        },
    };
    notes.push(format!("window {} to {} (default)", window.0 as f32, window.1 as f32));
    Ok(window)
}
