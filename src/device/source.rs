//! The kernel sources, embedded at build time, and the resolver of their `#include` lines.

use crate::{Error, Result};
use sha2::{Digest, Sha256};

macro_rules! embed {
    ($($path:literal),* $(,)?) => {
        &[$(($path, include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/cl/", $path)))),*]
    };
}

/// Every file of `cl/`, by its path below that folder.
const FILES: &[(&str, &str)] = embed![
    "caustics/batch.cl",
    "caustics/bounces.cl",
    "caustics/cells.cl",
    "caustics/collisions.cl",
    "caustics/edges.cl",
    "caustics/emission.cl",
    "caustics/gather.cl",
    "caustics/map.cl",
    "caustics/marks.cl",
    "caustics/medium.cl",
    "caustics/photons.cl",
    "caustics/spectrum.cl",
    "caustics/weights.cl",
    "common/directions.cl",
    "common/exponential.cl",
    "common/inline.cl",
    "common/lanes.cl",
    "common/numeric.cl",
    "common/octahedron.cl",
    "common/phase.cl",
    "common/random_lanes.cl",
    "common/rng.cl",
    "common/sobol.cl",
    "common/stream.cl",
    "diffusion/cells.cl",
    "diffusion/grids.cl",
    "diffusion/relax.cl",
    "diffusion/residual.cl",
    "diffusion/solver.cl",
    "diffusion/vectors.cl",
    "film/accumulate.cl",
    "film/fold.cl",
    "irradiance/between.cl",
    "irradiance/cells.cl",
    "irradiance/combine.cl",
    "irradiance/convection.cl",
    "irradiance/direct.cl",
    "irradiance/direct_rays.cl",
    "irradiance/grid.cl",
    "irradiance/light.cl",
    "irradiance/limiter.cl",
    "irradiance/padded.cl",
    "irradiance/points.cl",
    "irradiance/scattered.cl",
    "irradiance/source.cl",
    "irradiance/spreading.cl",
    "irradiance/unlit.cl",
    "lights/environment.cl",
    "lights/rectangle.cl",
    "lights/sample.cl",
    "render/auxiliary.cl",
    "render/background.cl",
    "render/begin.cl",
    "render/camera.cl",
    "render/camera_lanes.cl",
    "render/caustics.cl",
    "render/caustics_medium.cl",
    "render/cells.cl",
    "render/colors.cl",
    "render/emission_absorption.cl",
    "render/equiangular.cl",
    "render/events.cl",
    "render/frame.cl",
    "render/gathered.cl",
    "render/isosurface.cl",
    "render/lattice.cl",
    "render/ledger.cl",
    "render/light_volume.cl",
    "render/mip.cl",
    "render/paths.cl",
    "render/scattering.cl",
    "render/seen.cl",
    "sort/bitonic_groups.cl",
    "sort/bitonic_items.cl",
    "sort/bitonic_words.cl",
    "sort/radix_groups.cl",
    "sort/radix_items.cl",
    "sort/radix_passes.cl",
    "sort/ranges.cl",
    "sort/search.cl",
    "sort/valid.cl",
    "sort/words.cl",
    "surfaces/box.cl",
    "surfaces/direct.cl",
    "surfaces/disk.cl",
    "surfaces/intersect.cl",
    "surfaces/metaballs.cl",
    "surfaces/nodes.cl",
    "surfaces/optics.cl",
    "surfaces/plane.cl",
    "surfaces/rectangle.cl",
    "surfaces/sphere.cl",
    "surfaces/triangle.cl",
    "surfaces/within.cl",
    "types/camera.cl",
    "types/caustics.cl",
    "types/convection.cl",
    "types/diffusion.cl",
    "types/emission.cl",
    "types/film.cl",
    "types/frame.cl",
    "types/irradiance.cl",
    "types/light.cl",
    "types/method.cl",
    "types/path.cl",
    "types/phase.cl",
    "types/photon.cl",
    "types/photon_map.cl",
    "types/surface.cl",
    "types/volume.cl",
    "volume/bricks.cl",
    "volume/cell.cl",
    "volume/closed_form.cl",
    "volume/cubic.cl",
    "volume/flight.cl",
    "volume/grid.cl",
    "volume/sampling.cl",
    "volume/tables.cl",
    "volume/tracking.cl",
    "volume/transfer.cl",
    "volume/transmittance.cl",
];

/// Identifies the sources of all kernels: 32 hexadecimal digits.
pub fn sources_hash() -> String {
    let mut hash = Sha256::new();
    for (name, text) in FILES {
        hash.update(format!("{name} {}\n", text.len()));
        hash.update(text);
    }
    hash.finalize().iter().take(16).map(|byte| format!("{byte:02x}")).collect()
}

/// The text of `entry` with every `#include "path"` replaced by that file, each file once.
///
/// `#line` directives make compilers name the real file and line.
///
/// # Errors
/// [`Error::Failed`] when a named file is not embedded: a mistake in a kernel source.
pub(super) fn resolve(entry: &str) -> Result<String> {
    let mut seen = Vec::new();
    let mut text = String::new();
    append(entry, &mut seen, &mut text)?;
    Ok(text)
}

fn append(path: &str, seen: &mut Vec<String>, text: &mut String) -> Result<()> {
    if seen.iter().any(|known| known == path) {
        return Ok(());
    }
    seen.push(path.into());
    let (_, source) = FILES
        .iter()
        .find(|(name, _)| *name == path)
        .ok_or_else(|| Error::Failed(format!("kernel source cl/{path} is not part of this program")))?;
    text.push_str(&format!("#line 1 \"cl/{path}\"\n"));
    for (number, line) in source.lines().enumerate() {
        match included(line) {
            Some(file) => {
                append(file, seen, text)?;
                text.push_str(&format!("#line {} \"cl/{path}\"\n", number + 2));
            }
            None => {
                text.push_str(line);
                text.push('\n');
            }
        }
    }
    Ok(())
}

fn included(line: &str) -> Option<&str> {
    line.trim().strip_prefix("#include \"")?.strip_suffix('"')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_of_cl_is_embedded_and_resolves() {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("cl");
        let mut folders = vec![root.clone()];
        let mut count = 0;
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    folders.push(path);
                    continue;
                }
                let name = path.strip_prefix(&root).unwrap().to_str().unwrap().replace('\\', "/");
                resolve(&name).unwrap();
                count += 1;
            }
        }
        assert_eq!(count, FILES.len());
    }

    #[test]
    fn each_file_is_included_once_and_lines_are_marked() {
        let text = resolve("render/mip.cl").unwrap();
        assert_eq!(text.matches("#line 1 \"cl/volume/grid.cl\"").count(), 1);
        assert!(!text.contains("#include"));
    }
}
