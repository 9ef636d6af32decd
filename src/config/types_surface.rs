//! Raw types of `[[material]]` and `[[surface]]`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::values::{Albedo, Color, Radiance};

/// What surfaces are made of: `kind = "diffuse"`, `"mirror"` or `"dielectric"`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
pub enum MaterialConfig {
    /// Scatters light equally into all directions of its side; casts and receives caustics.
    Diffuse {
        /// What surfaces call it; no two materials share a name.
        name: String,
        /// The share of the light that it reflects.
        color: Albedo,
    },
    /// Reflects like polished metal.
    Mirror {
        /// What surfaces call it; no two materials share a name.
        name: String,
        /// The share of the light that it reflects.
        #[serde(default = "white")]
        color: Albedo,
    },
    /// Reflects and refracts like glass or water (Fresnel's equations).
    Dielectric {
        /// What surfaces call it; no two materials share a name.
        name: String,
        /// Refractive index relative to what is around it: 1.5 is glass. Not together with `dispersion`.
        #[schemars(range(max = 100.0), extend("exclusiveMinimum" = 0.0))]
        ior: Option<f64>,
        /// Refractive index by wavelength. Not together with `ior`.
        dispersion: Option<DispersionConfig>,
        /// What it absorbs of light inside it, per scene unit.
        #[serde(default = "black")]
        absorption: Radiance,
    },
}

/// Cauchy's equation: the refractive index is a + b/λ² + c/λ⁴, with the wavelength λ in micrometres.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DispersionConfig {
    /// The index at long wavelengths.
    pub a: f64,
    /// Per μm⁻².
    pub b: f64,
    /// Per μm⁻⁴.
    #[serde(default)]
    pub c: f64,
}

/// A surface: `kind = "plane"`, `"sphere"`, `"rectangle"`, `"disk"`, `"box"`, `"metaballs"` or `"mesh"`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
pub enum SurfaceConfig {
    /// An infinite plane; behind it is the inside of a dielectric.
    Plane {
        /// A point of it, [x, y, z] in scene units.
        point: [f64; 3],
        /// The direction perpendicular to it, any length; not zero.
        normal: [f64; 3],
        /// The name of its material.
        material: String,
    },
    /// A sphere.
    Sphere {
        /// Its centre, [x, y, z] in scene units.
        centre: [f64; 3],
        /// Its radius in scene units.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        radius: f64,
        /// The name of its material.
        material: String,
    },
    /// A parallelogram; a rectangle where the edges are perpendicular.
    Rectangle {
        /// Its middle, [x, y, z] in scene units.
        centre: [f64; 3],
        /// One edge from end to end, [x, y, z] in scene units; not zero.
        edge_u: [f64; 3],
        /// The other edge from end to end, [x, y, z] in scene units; neither zero nor parallel to `edge_u`.
        edge_v: [f64; 3],
        /// The name of its material.
        material: String,
    },
    /// A flat disk.
    Disk {
        /// Its centre, [x, y, z] in scene units.
        centre: [f64; 3],
        /// The direction perpendicular to it, any length; not zero.
        normal: [f64; 3],
        /// Its radius in scene units.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        radius: f64,
        /// The name of its material.
        material: String,
    },
    /// A box along the axes.
    Box {
        /// The corner with the lowest coordinates, [x, y, z] in scene units.
        low: [f64; 3],
        /// The corner with the highest coordinates, each more than that of `low`.
        high: [f64; 3],
        /// The name of its material.
        material: String,
    },
    /// Balls that flow into each other: the surface where the sum of their fields is `threshold`.
    Metaballs {
        /// The balls.
        #[schemars(length(min = 1, max = 4096))]
        balls: Vec<MetaballConfig>,
        /// The value of the field at the surface; it is more inside.
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        threshold: f64,
        /// The name of its material.
        material: String,
    },
    /// Triangles of a file.
    Mesh {
        /// Path of an OBJ or PLY file, relative to the scene file.
        path: String,
        /// Factor on its coordinates.
        #[serde(default = "one")]
        #[schemars(extend("exclusiveMinimum" = 0.0))]
        scale: f64,
        /// What is added to them after that, [x, y, z] in scene units.
        #[serde(default)]
        translate: [f64; 3],
        /// Shades with normals that vary over the triangles: the file's, else the mean of the faces around a vertex.
        #[serde(default)]
        smooth: bool,
        /// The name of its material.
        material: String,
    },
}

/// A ball of metaballs: its field is weight · (1 - (distance / radius)²)² within its radius, else 0.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MetaballConfig {
    /// Its centre, [x, y, z] in scene units.
    pub centre: [f64; 3],
    /// How far its field reaches, in scene units.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub radius: f64,
    /// The field at its centre; a negative one takes away from the others.
    #[serde(default = "one")]
    pub weight: f64,
}

fn one() -> f64 {
    1.0
}

fn white() -> Albedo {
    Color([1.0; 3])
}

fn black() -> Radiance {
    Color([0.0; 3])
}
