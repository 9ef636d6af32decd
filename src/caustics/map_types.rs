//! How photons are gathered, and mirrors of `cl/types/photon_map.cl`.

use crate::device::{DeviceInfo, DeviceKind, ProgramSpec};
use crate::device_struct;
use crate::sort::{Fill, SortKind};
use std::f64::consts::PI;

/// How the photons near a point are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Acceleration {
    /// Not at all: each point looks at all photons.
    BruteForce,
    /// Photons sorted by x: each point looks at those within the radius along x.
    Lexicographic,
    /// Cells at least as wide as the radius: each point looks at those of 27.
    Voxels,
    /// Cells in the planes of flat surfaces: each point looks at those of 9.
    Planar,
}

/// How a photon counts by its distance t from a point, over the radius.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weighting {
    /// 1.
    Constant,
    /// 1 − t.
    Cone,
    /// 1 − 3 t² + 2 t³.
    Smoothstep,
}

impl Weighting {
    /// What it is divided by to weigh 1 on a plane, over the radius squared: its integral over the unit disk.
    pub fn area(self) -> f64 {
        PI * match self {
            Self::Constant => 1.0,
            Self::Cone => 1.0 / 3.0,
            Self::Smoothstep => 3.0 / 10.0,
        }
    }

    /// What it is divided by to weigh 1 in space, over the radius cubed: its integral over the unit ball.
    pub fn volume(self) -> f64 {
        PI * match self {
            Self::Constant => 4.0 / 3.0,
            Self::Cone => 1.0 / 3.0,
            Self::Smoothstep => 4.0 / 15.0,
        }
    }
}

/// How photons are gathered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MapSettings {
    /// How the photons near a point are found.
    pub acceleration: Acceleration,
    /// How they are sorted.
    pub sort: SortKind,
    /// How the ranges of cells are found.
    pub fill: Fill,
    /// How they count.
    pub weighting: Weighting,
    /// Sums of flux times weight, as in the paper of Bogolepov, Sopin and Turlapov, in place of irradiance: they have the
    /// unit of flux over the square of the local unit, and grow with the square of the radius ([`Weighting::area`]).
    pub paper_weights: bool,
    /// Whether estimates are divided by what of the kernel lies on the surface.
    pub edge_correction: bool,
    /// Most cells of which each has its range in a table; where there are more, cells are searched for.
    pub table_cells: usize,
}

impl Default for MapSettings {
    fn default() -> Self {
        Self {
            acceleration: Acceleration::Voxels,
            sort: SortKind::Radix,
            fill: Fill::OnePass,
            weighting: Weighting::Cone,
            paper_weights: false,
            edge_correction: true,
            table_cells: 1 << 24,
        }
    }
}

impl MapSettings {
    /// Adds the definitions with which kernels gather (`cl/caustics/gather.cl`) on a device.
    pub fn define(&self, spec: ProgramSpec, info: &DeviceInfo) -> ProgramSpec {
        Self::define_lanes(self.define_gather(spec), info)
    }

    /// Adds what depends on the device alone.
    pub fn define_lanes(spec: ProgramSpec, info: &DeviceInfo) -> ProgramSpec {
        spec.feature("GATHER_LANES", info.kind == DeviceKind::Cpu)
    }

    /// Adds what does not depend on the device.
    pub fn define_gather(&self, spec: ProgramSpec) -> ProgramSpec {
        let weighting = match self.weighting {
            Weighting::Constant => "KERNEL_CONSTANT",
            Weighting::Cone => "KERNEL_CONE",
            Weighting::Smoothstep => "KERNEL_SMOOTHSTEP",
        };
        self.define_cells(spec).feature(weighting, true).feature("EDGE_CORRECTION", self.edge_correction)
    }

    pub(super) fn define_cells(&self, spec: ProgramSpec) -> ProgramSpec {
        let name = match self.acceleration {
            Acceleration::BruteForce => "MAP_BRUTE_FORCE",
            Acceleration::Lexicographic => "MAP_LEXICOGRAPHIC",
            Acceleration::Voxels => "MAP_VOXELS",
            Acceleration::Planar => "MAP_PLANAR",
        };
        spec.feature(name, true)
    }

    pub(super) fn sorts(&self) -> bool {
        self.acceleration != Acceleration::BruteForce
    }

    pub(crate) fn has_cells(&self) -> bool {
        matches!(self.acceleration, Acceleration::Voxels | Acceleration::Planar)
    }
}

device_struct! {
    "types/photon_map.cl",
    /// The map's cells, and what estimates need of the radius; local units.
    pub struct MapFrame {
        /// Low corner of the cells, and cells per local unit.
        pub low: [f32; 4],
        /// Sums of weighted flux to flux per area, per volume; one over the radius; its square.
        pub scale: [f32; 4],
        /// Cells along x.
        pub nx: u32,
        /// Cells along y.
        pub ny: u32,
        /// Cells along z, or planes.
        pub nz: u32,
        /// Photons in the map.
        pub count: u32,
        /// Elements of each of the map's arrays of photons.
        pub stride: u32,
        /// Whether each cell has its range in the table.
        pub tabled: u32,
        /// The radius.
        pub radius: f32,
        /// How many cells beyond the box places are told apart.
        pub margin: f32,
    }
}
