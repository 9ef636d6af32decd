//! Surfaces and what they are made of.

use std::path::PathBuf;

use glam::DVec3;

use super::camera::direction;
use super::context::Context;
use crate::config::types::{DispersionConfig, MaterialConfig, MetaballConfig, MethodConfig, SurfaceConfig};
use crate::config::{nearest, quote};

/// Edges closer to each other than this (sine of the angle) span no rectangle.
const LEAST_SINE: f64 = 1e-6;
/// Wavelengths at which a refractive index must make sense, in micrometres: what eyes see, and a little more.
const WAVELENGTHS: [f64; 2] = [0.36, 0.83];
/// A threshold less than this part of the weights lies where the field of float32 is rounding alone.
const LEAST_THRESHOLD: f64 = 1e-9;
/// The largest refractive index; that of `ior` in the schema.
const LARGEST_INDEX: f64 = 100.0;

/// What a surface is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SurfaceMaterial {
    /// Reflects equally into all directions of a side.
    Diffuse {
        /// Reflected share per channel, 0..=1.
        color: [f64; 3],
    },
    /// Reflects like polished metal.
    Mirror {
        /// Reflected share per channel, 0..=1.
        color: [f64; 3],
    },
    /// Reflects and refracts like glass.
    Dielectric {
        /// Coefficients of the refractive index relative to the surroundings, by powers of λ⁻², λ in μm.
        cauchy: [f64; 3],
        /// Absorption inside per channel and scene unit, ≥ 0.
        absorption: [f64; 3],
    },
}

impl SurfaceMaterial {
    /// Whether it reflects or refracts into single directions.
    pub fn is_specular(&self) -> bool {
        !matches!(self, Self::Diffuse { .. })
    }

    /// The refractive index at a wavelength in micrometres; 1 of what does not refract.
    pub fn index(&self, wavelength: f64) -> f64 {
        let Self::Dielectric { cauchy: [a, b, c], .. } = self else { return 1.0 };
        let x = wavelength.powi(-2);
        a + x * (b + x * c)
    }
}

/// A surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// Its shape.
    pub shape: SurfaceShape,
    /// Its material: an index into those of the scene.
    pub material: usize,
}

/// The shape of a surface, in scene units. What is inside lies behind the normals.
#[derive(Debug, Clone, PartialEq)]
pub enum SurfaceShape {
    /// An infinite plane.
    Plane {
        /// A point of it.
        point: DVec3,
        /// Unit length.
        normal: DVec3,
    },
    /// A sphere.
    Sphere {
        /// Its centre.
        centre: DVec3,
        /// > 0.
        radius: f64,
    },
    /// A parallelogram.
    Rectangle {
        /// Its middle.
        centre: DVec3,
        /// One edge from end to end.
        edge_u: DVec3,
        /// The other edge, not parallel to `edge_u`. The normal is along `edge_u` × `edge_v`.
        edge_v: DVec3,
    },
    /// A flat disk.
    Disk {
        /// Its centre.
        centre: DVec3,
        /// Unit length.
        normal: DVec3,
        /// > 0.
        radius: f64,
    },
    /// A box along the axes.
    Box {
        /// Its low corner.
        low: DVec3,
        /// Its high corner, higher on every axis.
        high: DVec3,
    },
    /// Where the fields of balls add up to a threshold.
    Metaballs {
        /// The balls, at least one.
        balls: Vec<Metaball>,
        /// > 0 and less than the sum of the positive weights.
        threshold: f64,
    },
    /// Triangles of a file.
    Mesh {
        /// An existing file.
        path: PathBuf,
        /// Factor on its coordinates, > 0.
        scale: f64,
        /// What is added to them after that.
        translate: DVec3,
        /// Whether normals vary over the triangles.
        smooth: bool,
    },
}

/// A ball with the field weight · (1 − (distance / radius)²)² within its radius.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Metaball {
    /// Its centre, scene units.
    pub centre: DVec3,
    /// Scene units, > 0.
    pub radius: f64,
    /// The field at its centre.
    pub weight: f64,
}

/// Whether a method renders surfaces.
fn renders_surfaces(method: &MethodConfig) -> bool {
    matches!(method, MethodConfig::Caustics { .. })
}

/// Reports surfaces that the method would leave out, or misses.
pub(super) fn refuse_surfaces(configs: &[SurfaceConfig], method: &MethodConfig, cx: &mut Context<'_>) {
    if configs.is_empty() && renders_surfaces(method) {
        cx.wrong("method.kind", "caustics needs at least one `[[surface]]`", "there is nothing to render");
    }
    if !configs.is_empty() && !renders_surfaces(method) {
        let message = "`[[surface]]` needs `method.kind = \"caustics\"`";
        cx.wrong("surface.0", message, "only caustics renders surfaces");
    }
}

/// The materials of the scene, in the order of the file.
pub(super) fn materials(configs: &[MaterialConfig], cx: &mut Context<'_>) -> Vec<SurfaceMaterial> {
    let names: Vec<_> = configs.iter().map(name).collect();
    for (index, name) in names.iter().enumerate() {
        let path = format!("material.{index}.name");
        if name.is_empty() {
            cx.wrong(&path, format!("`{path}` must not be empty"), "surfaces could not name it");
        } else if let Some(first) = names[..index].iter().position(|other| other == name) {
            let message = format!("there are two materials {}", quote(name));
            cx.wrong(&path, message, format!("`material.{first}` has this name"));
        }
    }
    configs.iter().enumerate().map(|(index, config)| material(config, index, cx)).collect()
}

fn name(config: &MaterialConfig) -> &str {
    let (MaterialConfig::Diffuse { name, .. }
    | MaterialConfig::Mirror { name, .. }
    | MaterialConfig::Dielectric { name, .. }) = config;
    name
}

fn material(config: &MaterialConfig, index: usize, cx: &mut Context<'_>) -> SurfaceMaterial {
    match config {
        MaterialConfig::Diffuse { color, .. } => SurfaceMaterial::Diffuse { color: color.0 },
        MaterialConfig::Mirror { color, .. } => SurfaceMaterial::Mirror { color: color.0 },
        MaterialConfig::Dielectric { ior, dispersion, absorption, .. } => {
            let place = format!("material.{index}");
            let cauchy = match (ior, dispersion) {
                (&Some(ior), None) => [ior, 0.0, 0.0],
                (None, Some(dispersion)) => cauchy(dispersion, &place, cx),
                (Some(_), Some(_)) => {
                    let useless = format!("{place}.dispersion");
                    let reason = format!("does not go with `{place}.ior`");
                    cx.useless(&useless, &reason, "give one of the two");
                    [1.0, 0.0, 0.0]
                }
                (None, None) => {
                    let message = "a dielectric needs `ior` or `dispersion`";
                    cx.wrong(&place, message, "neither is given");
                    [1.0, 0.0, 0.0]
                }
            };
            SurfaceMaterial::Dielectric { cauchy, absorption: absorption.0 }
        }
    }
}

fn cauchy(config: &DispersionConfig, place: &str, cx: &mut Context<'_>) -> [f64; 3] {
    let &DispersionConfig { a, b, c } = config;
    let index = |x: f64| a + x * (b + x * c);
    // A parabola in λ⁻²: its extremes are at the ends or at the vertex.
    let [high, low] = WAVELENGTHS.map(|wavelength| wavelength.powi(-2));
    let vertex = Some(-b / (2.0 * c)).filter(|x| (low..=high).contains(x)).unwrap_or(low);
    if ![low, high, vertex].iter().all(|&x| index(x) > 0.0 && index(x) <= LARGEST_INDEX) {
        let path = format!("{place}.dispersion");
        let [shortest, longest] = [high, low].map(index);
        let message = format!("`{path}` gives a refractive index out of range");
        let help = format!(
            "a + b/λ² + c/λ⁴ must be more than 0 and at most {LARGEST_INDEX} for λ from {} to {} μm; here {} to {}",
            WAVELENGTHS[0],
            WAVELENGTHS[1],
            short(shortest),
            short(longest)
        );
        cx.wrong_with_help(&path, message, "no such light", &help);
    }
    [a, b, c]
}

/// A number for a message.
fn short(value: f64) -> String {
    if (1e-3..1e6).contains(&value.abs()) || value == 0.0 {
        format!("{}", (value * 1e4).round() / 1e4)
    } else {
        format!("{value:.3e}")
    }
}

/// The surfaces of the scene, in the order of the file.
pub(super) fn surfaces(
    configs: &[SurfaceConfig],
    materials: &[MaterialConfig],
    cx: &mut Context<'_>,
) -> Vec<Surface> {
    let names: Vec<_> = materials.iter().map(name).collect();
    let surface = |(index, config): (usize, &SurfaceConfig)| {
        let place = format!("surface.{index}");
        let (shape, material) = shape(config, &place, cx);
        Surface { shape, material: find(material, &names, &place, cx) }
    };
    configs.iter().enumerate().map(surface).collect()
}

/// The index of a material; any, once its absence is reported.
fn find(name: &str, names: &[&str], place: &str, cx: &mut Context<'_>) -> usize {
    if let Some(index) = names.iter().position(|known| *known == name) {
        return index;
    }
    let message = format!("there is no material {}", quote(name));
    let label = match nearest(name, names.iter().copied()) {
        Some(meant) => format!("did you mean {}?", quote(meant)),
        None => "no `[[material]]` has this name".into(),
    };
    let known = names.iter().take(20).map(|name| quote(name)).collect::<Vec<_>>().join(", ");
    let help = if names.is_empty() {
        "the scene has no materials: add a `[[material]]`".into()
    } else {
        format!("materials: {known}")
    };
    cx.wrong_with_help(&format!("{place}.material"), message, &label, &help);
    0
}

fn shape<'c>(config: &'c SurfaceConfig, place: &str, cx: &mut Context<'_>) -> (SurfaceShape, &'c str) {
    let mut unit = |vector: &[f64; 3], key: &str| {
        // A wrong direction has been reported: any stands in for it.
        direction(*vector, &format!("{place}.{key}"), cx).unwrap_or(DVec3::Z)
    };
    let vector = |vector: &[f64; 3]| DVec3::from_array(*vector);
    match config {
        SurfaceConfig::Plane { point, normal, material } => {
            (SurfaceShape::Plane { point: vector(point), normal: unit(normal, "normal") }, material)
        }
        SurfaceConfig::Sphere { centre, radius, material } => {
            (SurfaceShape::Sphere { centre: vector(centre), radius: *radius }, material)
        }
        SurfaceConfig::Rectangle { centre, edge_u, edge_v, material } => {
            edges(edge_u, edge_v, place, cx);
            let [centre, edge_u, edge_v] = [centre, edge_u, edge_v].map(vector);
            (SurfaceShape::Rectangle { centre, edge_u, edge_v }, material)
        }
        SurfaceConfig::Disk { centre, normal, radius, material } => {
            let (centre, normal) = (vector(centre), unit(normal, "normal"));
            (SurfaceShape::Disk { centre, normal, radius: *radius }, material)
        }
        SurfaceConfig::Box { low, high, material } => {
            let (low, high) = (vector(low), vector(high));
            if !low.cmplt(high).all() {
                let path = format!("{place}.high");
                let message = format!("`{path}` must be more than `{place}.low` on every axis");
                cx.wrong(&path, message, format!("the low corner is [{}, {}, {}]", low.x, low.y, low.z));
            }
            (SurfaceShape::Box { low, high }, material)
        }
        SurfaceConfig::Metaballs { balls, threshold, material } => {
            (metaballs(balls, *threshold, place, cx), material)
        }
        SurfaceConfig::Mesh { path, scale, translate, smooth, material } => {
            let path = mesh(path, place, cx);
            let (scale, translate, smooth) = (*scale, vector(translate), *smooth);
            (SurfaceShape::Mesh { path, scale, translate, smooth }, material)
        }
    }
}

/// Reports edges that span nothing.
fn edges(edge_u: &[f64; 3], edge_v: &[f64; 3], place: &str, cx: &mut Context<'_>) {
    let [u, v] = [("edge_u", edge_u), ("edge_v", edge_v)]
        .map(|(key, edge)| direction(*edge, &format!("{place}.{key}"), cx));
    if let (Some(u), Some(v)) = (u, v)
        && u.cross(v).length() < LEAST_SINE
    {
        let path = format!("{place}.edge_v");
        let message = format!("`{path}` must not be parallel to `{place}.edge_u`");
        cx.wrong(&path, message, "they span no rectangle");
    }
}

fn metaballs(configs: &[MetaballConfig], threshold: f64, place: &str, cx: &mut Context<'_>) -> SurfaceShape {
    let most: f64 = configs.iter().map(|ball| ball.weight.max(0.0)).sum();
    if threshold >= most {
        let path = format!("{place}.threshold");
        let message = format!("`{path}` is more than the field anywhere");
        cx.wrong(&path, message, format!("the positive weights add up to {}", short(most)));
    }
    let all: f64 = configs.iter().map(|ball| ball.weight.abs()).sum();
    if threshold < LEAST_THRESHOLD * all {
        let path = format!("{place}.threshold");
        let message = format!("`{path}` is too small beside the weights of the balls");
        let least = short(LEAST_THRESHOLD * all);
        cx.wrong(&path, message, format!("a billionth of their sum is the least: {least}"));
    }
    let ball = |&MetaballConfig { centre, radius, weight }: &MetaballConfig| Metaball {
        centre: DVec3::from_array(centre),
        radius,
        weight,
    };
    SurfaceShape::Metaballs { balls: configs.iter().map(ball).collect(), threshold }
}

fn mesh(name: &str, place: &str, cx: &mut Context<'_>) -> PathBuf {
    let path = format!("{place}.path");
    let lower = name.to_lowercase();
    if !lower.ends_with(".obj") && !lower.ends_with(".ply") {
        let message = format!("{} is not a mesh that can be read", quote(name));
        cx.wrong(&path, message, "meshes end in .obj or .ply");
    }
    cx.file(&path, name)
}
