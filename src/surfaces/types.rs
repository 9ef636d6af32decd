//! Mirrors of `cl/types/surface.cl`, where the fields are explained.

use crate::device_struct;

device_struct! {
    "types/surface.cl",
    /// A geometric primitive.
    pub struct DeviceShape {
        /// By `kind`.
        pub a: [f32; 4],
        /// By `kind`.
        pub b: [f32; 4],
        /// By `kind`.
        pub c: [f32; 4],
        /// By `kind`.
        pub d: [f32; 4],
        /// Which kind of shape.
        pub kind: u32,
        /// The surface of the scene it is part of.
        pub surface: u32,
        /// The first of its balls, or of its normals.
        pub first: u32,
        /// Number of balls.
        pub count: u32,
    }
}

device_struct! {
    "types/surface.cl",
    /// A ball of metaballs.
    pub struct DeviceBall {
        /// Centre and radius.
        pub place: [f32; 4],
        /// What it adds to the field at its centre.
        pub weight: f32,
        /// 1 / radius².
        pub slope: f32,
        /// Padding.
        pub pad_0: u32,
        /// Padding.
        pub pad_1: u32,
    }
}

impl DeviceBall {
    /// A ball of `place` (centre and radius) that adds `weight` to the field at its centre.
    pub fn new(place: [f32; 4], weight: f32) -> Self {
        let radius = f64::from(place[3]);
        Self { place, weight, slope: (radius * radius).recip() as f32, pad_0: 0, pad_1: 0 }
    }
}

device_struct! {
    "types/surface.cl",
    /// A box of the hierarchy over the shapes with bounds.
    pub struct DeviceNode {
        /// Low corner; as bits: the left child or the first shape.
        pub low: [f32; 4],
        /// High corner; as bits: the number of shapes.
        pub high: [f32; 4],
    }
}

device_struct! {
    "types/surface.cl",
    /// What a surface is made of.
    pub struct DeviceMaterial {
        /// Albedo or reflectance per channel.
        pub color: [f32; 4],
        /// Absorption inside per channel and local unit.
        pub absorption: [f32; 4],
        /// Cauchy's coefficients, and the index at 587.6 nm.
        pub cauchy: [f32; 4],
        /// Which kind of material.
        pub kind: u32,
        /// Padding.
        pub pad_0: u32,
        /// Padding.
        pub pad_1: u32,
        /// Padding.
        pub pad_2: u32,
    }
}

impl DeviceMaterial {
    /// What `kind` says of diffuse surfaces.
    pub const DIFFUSE: u32 = 0;
    /// Of mirrors.
    pub const MIRROR: u32 = 1;
    /// Of glass.
    pub const DIELECTRIC: u32 = 2;

    /// Whether its index depends on the wavelength.
    pub fn disperses(&self) -> bool {
        self.kind == Self::DIELECTRIC && self.cauchy[1..3] != [0.0; 2]
    }
}
