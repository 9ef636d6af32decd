//! Fingerprints of data: they tell whether two runs worked on the same bytes.

use super::load::DataRef;
use super::plan::Plan;
use crate::scene::{Background, Table2d, Transfer, VolumeSource};
use crate::{Error, Result};
use glam::DVec3;
use rayon::prelude::*;
use sha2::{Digest, Sha256};
use std::fmt::Write as _;

/// Bytes that one checksum covers: large enough for the list of checksums to be short.
const BLOCK: usize = 1 << 20;
/// Bytes of the SHA-256 that are kept, as of the scene's hash.
const KEPT: usize = 16;

/// A fingerprint of named byte strings: SHA-256 over the CRC-32 of their blocks.
///
/// It guards against mistakes, not against forgery, and costs little more than the bytes' way through memory.
pub(crate) struct Fingerprint(Sha256);

impl Fingerprint {
    /// Of nothing yet.
    pub fn new() -> Self {
        Self(Sha256::new())
    }

    /// Adds a byte string.
    pub fn add(&mut self, name: &str, bytes: &[u8]) {
        let sums: Vec<u32> = bytes.par_chunks(BLOCK).map(crc32fast::hash).collect();
        self.0.update(format!("{name} {}\n", bytes.len()));
        sums.iter().for_each(|sum| self.0.update(sum.to_le_bytes()));
    }

    /// Its hexadecimal digits.
    pub fn finish(self) -> String {
        self.0.finalize().iter().take(KEPT).fold(String::new(), |mut hex, byte| {
            let _ = write!(hex, "{byte:02x}");
            hex
        })
    }
}

/// What the files that the scene reads held: voxels, environment map, table of the transfer function.
///
/// The scene's hash covers files by name alone. `none` where there are no files: what the scene says then is all.
///
/// # Errors
/// [`Error::Input`] when the table's file can no longer be read.
pub fn data_hash<'a>(plan: &Plan<'_>, data: impl Into<DataRef<'a>>) -> Result<String> {
    let scene = plan.scene;
    let mut fingerprint = Fingerprint::new();
    let mut files = false;
    let source = scene.volume.as_ref().map(|volume| &volume.source);
    let data = data.into();
    if let (Some(VolumeSource::File { .. }), Some(volume)) = (source, data.volume) {
        let geometry = [volume.spacing.x, volume.spacing.y, volume.spacing.z, volume.slope, volume.intercept];
        let what = format!("{:?} {} {geometry:?}", volume.dims, volume.voxel_type().name());
        fingerprint.add(&what, volume.voxels.as_bytes());
        files = true;
    }
    for (index, _) in scene.surfaces.iter().enumerate() {
        if let Some(mesh) = data.meshes.of(index) {
            fingerprint.add("points of a mesh", bytemuck::cast_slice(&flat(&mesh.points)));
            fingerprint.add("triangles of a mesh", bytemuck::cast_slice(&mesh.triangles));
            let normals = mesh.normals.iter().flatten().flatten().copied().collect::<Vec<_>>();
            fingerprint.add("normals of a mesh", bytemuck::cast_slice(&flat(&normals)));
            files = true;
        }
    }
    if let Background::Environment { .. } = scene.background {
        fingerprint.add("environment", &plan.environment.bytes);
        files = true;
    }
    if let Transfer::TwoD(transfer) = &scene.transfer
        && let Table2d::File(path) = &transfer.table
    {
        let bytes = crate::input::bytes(path)
            .map_err(|cause| Error::Input(format!("{}: cannot be read ({cause})", path.display())))?;
        fingerprint.add("transfer function", &bytes);
        files = true;
    }
    Ok(if files { fingerprint.finish() } else { "none".into() })
}

fn flat(vectors: &[DVec3]) -> Vec<[f64; 3]> {
    vectors.iter().map(|vector| vector.to_array()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(parts: &[(&str, &[u8])]) -> String {
        let mut fingerprint = Fingerprint::new();
        parts.iter().for_each(|(name, bytes)| fingerprint.add(name, bytes));
        fingerprint.finish()
    }

    #[test]
    fn every_bit_name_and_length_counts() {
        let bytes: Vec<u8> =
            (0..BLOCK as u32 * 2 + 5).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
        let whole = of(&[("a", &bytes)]);
        assert_eq!(whole.len(), 2 * KEPT);
        assert_eq!(whole, of(&[("a", &bytes)]));
        for position in [0, BLOCK - 1, BLOCK, 2 * BLOCK + 4] {
            let mut other = bytes.clone();
            other[position] ^= 1;
            assert_ne!(whole, of(&[("a", &other)]), "{position}");
        }
        let mut swapped = bytes.clone();
        swapped[..2 * BLOCK].rotate_left(BLOCK);
        assert_ne!(whole, of(&[("a", &swapped)]));
        assert_ne!(whole, of(&[("b", &bytes)]));
        assert_ne!(whole, of(&[("a", &bytes[..BLOCK]), ("a", &bytes[BLOCK..])]));
        assert_ne!(of(&[("a", b"")]), of(&[]));
    }
}
