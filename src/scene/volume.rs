//! The volume: where its data come from and where it lies.

use std::path::PathBuf;

use glam::DVec3;

use super::context::Context;
use crate::config::types::{
    Axis, Endian, FieldConfig, MethodConfig, SheppLoganRotation, VolumeConfig, VoxelKind, WindowConfig,
};
use crate::config::values;

/// Most voxels of a procedural field: 16 GiB of float32.
const MOST_FIELD_VOXELS: u64 = 1 << 32;
/// Ends of the names of files that say themselves what a raw file leaves open.
const WITH_HEADER: [&str; 6] = [".nrrd", ".nhdr", ".nii", ".nii.gz", ".mhd", ".mha"];

/// A volume and where it lies.
#[derive(Debug, Clone, PartialEq)]
pub struct Volume {
    /// Where its data come from.
    pub source: VolumeSource,
    /// Size of a voxel in scene units, each > 0; the file's, else 1, if `None`.
    pub spacing: Option<DVec3>,
    /// Where its box lies.
    pub origin: Origin,
    /// The data values that map to 0 and 1, the second larger; by the voxel type if `None`.
    pub window: Option<(f64, f64)>,
}

/// Where the data of a volume come from.
#[derive(Debug, Clone, PartialEq)]
pub enum VolumeSource {
    /// A file.
    File {
        /// An existing file.
        path: PathBuf,
        /// Voxels [x, y, z] of a raw file, each 1..=65536.
        dims: Option<[usize; 3]>,
        /// Voxel type of a raw file.
        voxel_type: Option<VoxelKind>,
        /// Byte order of a raw file.
        endian: Endian,
        /// Bytes to skip at the start of a raw file.
        offset: Option<u64>,
    },
    /// A procedural field, sampled at the voxel centres.
    Field {
        /// Which field.
        kind: FieldKind,
        /// Voxels [x, y, z], each 1..=65536, at most 2³² together.
        dims: [usize; 3],
    },
}

/// Where the box of a volume lies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Origin {
    /// Its low corner, scene units.
    Corner(DVec3),
    /// Centred on the origin of the scene.
    Centre,
}

/// A procedural field on p ∈ [0, 1]³ of the box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FieldKind {
    /// The same value everywhere.
    Constant {
        /// The value.
        value: f64,
    },
    /// from + (to − from)·p along one axis.
    Ramp {
        /// Value at the low face.
        from: f64,
        /// Value at the high face.
        to: f64,
        /// The axis.
        axis: Axis,
    },
    /// radius − |p − centre|, in fractions of the box's largest extent.
    Sphere {
        /// A point of [0, 1]³.
        centre: DVec3,
        /// Fractions of the largest extent, > 0.
        radius: f64,
    },
    /// Marschner and Lobb's test signal on [−1, 1]³.
    MarschnerLobb {
        /// f_M.
        frequency: f64,
        /// α, ≥ 0.
        alpha: f64,
    },
    /// The Shepp–Logan phantom on [−1, 1]³.
    SheppLogan {
        /// How its ellipsoids are rotated.
        rotation: SheppLoganRotation,
    },
    /// |ψ|² of hydrogen, scaled to a maximum of 1.
    Hydrogen {
        /// Principal quantum number, 1..=10.
        n: u32,
        /// Orbital quantum number, < n.
        l: u32,
        /// Magnetic quantum number, |m| ≤ l.
        m: i32,
        /// Half the largest extent of the box in Bohr radii, > 0.
        extent: f64,
    },
    /// A smooth ball with sinusoidal structure, 0..1.
    Cloud,
}

pub(super) fn volume(
    config: Option<&VolumeConfig>,
    method: &MethodConfig,
    cx: &mut Context<'_>,
) -> Option<Volume> {
    let Some(config) = config else {
        if !matches!(method, MethodConfig::Caustics { .. }) {
            cx.wrong_with_help(
                "volume",
                "missing key `volume`",
                "this method renders a volume",
                "a [volume] table, or `method.kind = \"caustics\"` for surfaces alone",
            );
        }
        for key in ["medium", "phase", "transfer"] {
            cx.useless(key, "needs a `[volume]`", "there is no volume that it would be of");
        }
        return None;
    };
    let source = source(config, cx);
    let window = config.window.map(|window| ends(window, cx));
    Some(Volume {
        source: source?,
        spacing: config.spacing.map(|spacing| DVec3::from_array(spacing.0)),
        origin: match config.origin {
            values::Origin::Corner(corner) => Origin::Corner(DVec3::from_array(corner)),
            values::Origin::Word(values::OriginWord::Centre) => Origin::Centre,
        },
        window,
    })
}

fn source(config: &VolumeConfig, cx: &mut Context<'_>) -> Option<VolumeSource> {
    match (&config.file, &config.field) {
        (Some(name), None) => Some(file(name, config, cx)),
        (None, Some(kind)) => field(kind, config, cx),
        (Some(_), Some(_)) => {
            cx.useless("volume.field", "does not go with `volume.file`", "give one of the two");
            None
        }
        (None, None) => {
            cx.wrong("volume", "the volume needs `file` or `field`", "neither is given");
            None
        }
    }
}

fn file(name: &str, config: &VolumeConfig, cx: &mut Context<'_>) -> VolumeSource {
    let lower = name.to_lowercase();
    if WITH_HEADER.iter().any(|end| lower.ends_with(end)) {
        for key in ["volume.dims", "volume.type", "volume.endian", "volume.offset"] {
            cx.useless(key, "is for raw files only", "the header of this file says it");
        }
    }
    VolumeSource::File {
        path: cx.file("volume.file", name),
        dims: config.dims.map(|dims| dims.map(|n| n as usize)),
        voxel_type: config.voxel_type,
        endian: config.endian.unwrap_or_default(),
        offset: config.offset,
    }
}

fn field(kind: &FieldConfig, config: &VolumeConfig, cx: &mut Context<'_>) -> Option<VolumeSource> {
    for key in ["volume.type", "volume.endian", "volume.offset"] {
        cx.useless(key, "is for raw files only", "a procedural field has none");
    }
    let kind = field_kind(kind, cx);
    let Some(dims) = config.dims else {
        cx.wrong("volume.field", "a procedural field needs `volume.dims`", "sampled at how many voxels?");
        return None;
    };
    if dims.iter().map(|&n| u64::from(n)).product::<u64>() > MOST_FIELD_VOXELS {
        let label = format!("at most {MOST_FIELD_VOXELS} voxels");
        cx.wrong("volume.dims", "the procedural field is too large", label);
    }
    Some(VolumeSource::Field { kind, dims: dims.map(|n| n as usize) })
}

fn field_kind(config: &FieldConfig, cx: &mut Context<'_>) -> FieldKind {
    match *config {
        FieldConfig::Constant { value } => FieldKind::Constant { value },
        FieldConfig::Ramp { from, to, axis } => FieldKind::Ramp { from, to, axis },
        FieldConfig::Sphere { centre, radius } => {
            FieldKind::Sphere { centre: DVec3::from_array(centre), radius }
        }
        FieldConfig::MarschnerLobb { frequency, alpha } => FieldKind::MarschnerLobb { frequency, alpha },
        FieldConfig::SheppLogan { rotation } => FieldKind::SheppLogan { rotation },
        FieldConfig::Hydrogen { n, l, m, extent } => {
            if l >= n {
                cx.wrong("volume.field.l", "`l` must be less than `n`", format!("n is {n}"));
            } else if m.unsigned_abs() > l {
                cx.wrong("volume.field.m", "`m` must lie between -l and l", format!("l is {l}"));
            }
            // Holds all but a few thousandths of the electron.
            let extent = extent.unwrap_or(f64::from(2 * n * (n + 2)));
            FieldKind::Hydrogen { n, l, m, extent }
        }
        FieldConfig::Cloud {} => FieldKind::Cloud,
    }
}

fn ends(window: WindowConfig, cx: &mut Context<'_>) -> (f64, f64) {
    let (lo, hi, key) = match window {
        WindowConfig::Ends { lo, hi } => (lo, hi, "volume.window.hi"),
        WindowConfig::Level { centre, width } => {
            (centre - width / 2.0, centre + width / 2.0, "volume.window.width")
        }
    };
    if hi <= lo {
        let what = if key.ends_with("hi") { "`hi` must be more than `lo`" } else { "the window is empty" };
        cx.wrong(key, format!("{what} in `volume.window`"), format!("the window starts at {lo}"));
    } else if !(hi - lo).is_finite() {
        cx.wrong(key, "`volume.window` is too wide", "its width overflows");
    }
    (lo, hi)
}
