//! Surfaces as arrays for the device.

use super::bounds::Bounds;
use super::bvh;
use super::mesh::Meshes;
use super::types::{DeviceBall, DeviceMaterial, DeviceNode, DeviceShape};
use crate::device::ProgramSpec;
use crate::render::local::LocalFrame;
use crate::scene::{Surface, SurfaceMaterial, SurfaceShape};
use crate::{Error, Result};
use glam::DVec3;

/// What `kind` of a shape says: `cl/types/surface.cl`.
pub(super) mod kind {
    pub const PLANE: u32 = 0;
    pub const SPHERE: u32 = 1;
    pub const RECTANGLE: u32 = 2;
    pub const DISK: u32 = 3;
    pub const BOX: u32 = 4;
    pub const METABALLS: u32 = 5;
    pub const TRIANGLE: u32 = 6;
}
/// The features of programs, by `kind`.
const FEATURES: [&str; 7] = [
    "SHAPE_PLANE",
    "SHAPE_SPHERE",
    "SHAPE_RECTANGLE",
    "SHAPE_DISK",
    "SHAPE_BOX",
    "SHAPE_METABALLS",
    "SHAPE_TRIANGLE",
];
const NO_NORMALS: u32 = u32::MAX;
/// The wavelength at which an index is quoted, in micrometres: helium's d line.
const D_LINE: f64 = 0.587_561_8;

/// All surfaces of a scene, in local units, as the device reads them.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceArrays {
    /// Planes, then the shapes with bounds in the order of the leaves.
    pub shapes: Vec<DeviceShape>,
    /// The hierarchy over the shapes with bounds, root first; empty if there are none.
    pub nodes: Vec<DeviceNode>,
    /// The balls of all metaballs.
    pub balls: Vec<DeviceBall>,
    /// Normals at the corners of smooth triangles, three each.
    pub normals: Vec<[f32; 4]>,
    /// The materials of the scene.
    pub materials: Vec<DeviceMaterial>,
    /// The material of each surface of the scene.
    pub materials_of: Vec<u32>,
    /// Number of planes.
    pub plane_count: usize,
    /// Around all shapes with bounds, scene units.
    pub bounds: Option<Bounds>,
    /// Around those of them that reflect or refract into single directions, scene units.
    pub specular_bounds: Option<Bounds>,
}

impl SurfaceArrays {
    /// The arrays of surfaces whose meshes have been read.
    ///
    /// # Errors
    /// [`Error::Input`] where float32 cannot hold what a surface is, naming the surface.
    pub fn new(
        surfaces: &[Surface],
        materials: &[SurfaceMaterial],
        meshes: &Meshes,
        frame: &LocalFrame,
    ) -> Result<Self> {
        let mut maker = Maker { frame, planes: vec![], bounded: vec![], balls: vec![], normals: vec![] };
        for (index, surface) in surfaces.iter().enumerate() {
            maker.add(index, &surface.shape, meshes)?;
        }
        let Maker { planes, mut bounded, balls, normals, .. } = maker;
        // In a leaf, too, they are asked last: they cost most, and not at all behind what is nearer.
        bounded.sort_by_key(|(shape, _)| shape.kind == kind::METABALLS);
        let plane_count = planes.len();
        let boxes: Vec<Bounds> = bounded.iter().map(|(_, bounds)| *bounds).collect();
        let (mut nodes, order) = bvh::build(&boxes);
        for node in nodes.iter_mut().filter(|node| node.high[3].to_bits() > 0) {
            node.low[3] = f32::from_bits(node.low[3].to_bits() + plane_count as u32);
        }
        let specular = |surface: &Surface| materials[surface.material].is_specular();
        Ok(Self {
            shapes: planes.into_iter().chain(order.into_iter().map(|i| bounded[i].0)).collect(),
            nodes,
            balls,
            normals,
            materials: materials.iter().map(|material| device_material(material, frame.unit)).collect(),
            materials_of: surfaces.iter().map(|surface| surface.material as u32).collect(),
            plane_count,
            bounds: super::bounds_of(surfaces, meshes, |_| true),
            specular_bounds: super::bounds_of(surfaces, meshes, specular),
        })
    }

    /// Whether a shape is of glass whose index depends on the wavelength.
    pub fn disperses(&self) -> bool {
        self.materials_of.iter().any(|&material| self.materials[material as usize].disperses())
    }

    /// Adds the features of the shapes that occur to a program.
    pub fn specialise(&self, spec: ProgramSpec) -> ProgramSpec {
        let occurs = |kind: usize| self.shapes.iter().any(|shape| shape.kind == kind as u32);
        let spec = FEATURES
            .into_iter()
            .enumerate()
            .fold(spec, |spec, (kind, name)| spec.feature(name, occurs(kind)));
        spec.feature("SHAPE_SMOOTH", !self.normals.is_empty())
    }
}

/// A sphere's point nearest to `near`, all in the same units, and the normal there.
fn nearest_point(centre: DVec3, radius: f64, near: DVec3) -> (DVec3, DVec3) {
    let normal = (near - centre).try_normalize().unwrap_or(DVec3::Z);
    (centre + radius * normal, normal)
}

struct Maker<'f> {
    frame: &'f LocalFrame,
    planes: Vec<DeviceShape>,
    bounded: Vec<(DeviceShape, Bounds)>,
    balls: Vec<DeviceBall>,
    normals: Vec<[f32; 4]>,
}

impl Maker<'_> {
    fn add(&mut self, index: usize, shape: &SurfaceShape, meshes: &Meshes) -> Result<()> {
        let place = |p: DVec3| self.frame.point(p);
        let length = |l: f64| l / self.frame.unit;
        let blank = DeviceShape {
            a: [0.0; 4],
            b: [0.0; 4],
            c: [0.0; 4],
            d: [0.0; 4],
            kind: 0,
            surface: index as u32,
            first: NO_NORMALS,
            count: 0,
        };
        let local = shape_bounds(shape).map(|b| Bounds { low: place(b.low), high: place(b.high) });
        let made = match *shape {
            SurfaceShape::Plane { point, normal } => {
                DeviceShape { b: plane(place(point), normal), kind: kind::PLANE, ..blank }
            }
            SurfaceShape::Sphere { centre, radius } => {
                let (centre, radius) = (place(centre), length(radius));
                let (point, normal) = nearest_point(centre, radius, 0.5 * self.frame.size());
                let (a, b, c) = (float4(centre, radius), float4(point, 1.0 / radius), float4(normal, 0.0));
                DeviceShape { a, b, c, kind: kind::SPHERE, ..blank }
            }
            SurfaceShape::Rectangle { centre, edge_u, edge_v } => {
                let (u, v) = (edge_u / self.frame.unit, edge_v / self.frame.unit);
                let corner = place(centre) - 0.5 * u - 0.5 * v;
                let normal = unit_normal(u, v);
                let area = u.cross(v).dot(normal);
                let (b, c) = (v.cross(normal) / area, normal.cross(u) / area);
                DeviceShape {
                    a: float4(corner, 0.0),
                    b: float4(b, 0.0),
                    c: float4(c, 0.0),
                    d: plane(corner, normal),
                    kind: kind::RECTANGLE,
                    ..blank
                }
            }
            SurfaceShape::Disk { centre, normal, radius } => {
                let (a, b) = (float4(place(centre), length(radius)), plane(place(centre), normal));
                DeviceShape { a, b, kind: kind::DISK, ..blank }
            }
            SurfaceShape::Box { low, high } => {
                let (a, b) = (float4(place(low), 0.0), float4(place(high), 0.0));
                DeviceShape { a, b, kind: kind::BOX, ..blank }
            }
            SurfaceShape::Metaballs { ref balls, threshold } => {
                let Bounds { low, high } = local.expect("metaballs have bounds");
                let first = self.balls.len() as u32;
                for ball in balls {
                    let place = float4(place(ball.centre), length(ball.radius));
                    finite(&[place], index)?;
                    // Over the threshold: any scale of the field will do.
                    let weight = (ball.weight / threshold) as f32;
                    self.balls.push(DeviceBall::new(place, weight));
                }
                DeviceShape {
                    a: float4(low, 0.0),
                    b: float4(high, 0.0),
                    c: [1.0, 0.0, 0.0, 0.0],
                    kind: kind::METABALLS,
                    first,
                    count: balls.len() as u32,
                    ..blank
                }
            }
            SurfaceShape::Mesh { .. } => return self.add_mesh(index, blank, meshes),
        };
        finite(&[made.a, made.b, made.c, made.d], index)?;
        match local {
            Some(local) => self.bounded.push((made, local)),
            None => self.planes.push(made),
        }
        Ok(())
    }

    fn add_mesh(&mut self, index: usize, blank: DeviceShape, meshes: &Meshes) -> Result<()> {
        let mesh = meshes.of(index).expect("the meshes of these surfaces have been read");
        for (face, normals) in mesh.faces() {
            let corners = face.map(|corner| self.frame.point(corner));
            let normal = unit_normal(corners[1] - corners[0], corners[2] - corners[0]);
            let [a, b, c] = corners.map(|corner| float4(corner, 0.0));
            let mut shape =
                DeviceShape { a, b, c, d: plane(corners[0], normal), kind: kind::TRIANGLE, ..blank };
            finite(&[a, b, c, shape.d], index)?;
            if let Some(normals) = normals {
                shape.first = self.normals.len() as u32;
                self.normals.extend(normals.map(|normal| float4(normal, 0.0)));
            }
            let bounds = Bounds::of(corners).expect("three corners");
            self.bounded.push((shape, bounds));
        }
        Ok(())
    }
}

fn unit_normal(u: DVec3, v: DVec3) -> DVec3 {
    // Of unit vectors, so that the product of tiny edges is no zero.
    u.normalize_or_zero().cross(v.normalize_or_zero()).normalize_or(DVec3::Z)
}

/// A unit normal and the distance of its plane from the origin.
fn plane(point: DVec3, normal: DVec3) -> [f32; 4] {
    float4(normal, normal.dot(point))
}

fn float4(v: DVec3, w: f64) -> [f32; 4] {
    [v.x as f32, v.y as f32, v.z as f32, w as f32]
}

fn finite(values: &[[f32; 4]], index: usize) -> Result<()> {
    if values.as_flattened().iter().all(|value| value.is_finite()) {
        return Ok(());
    }
    Err(Error::Input(format!(
        "`surface.{index}` is too large, too small or too far away for float32; bring it closer in size to the rest \
         of the scene"
    )))
}

/// The box around a shape that needs no file, in scene units; `None` for planes and meshes.
pub(super) fn shape_bounds(shape: &SurfaceShape) -> Option<Bounds> {
    match *shape {
        SurfaceShape::Plane { .. } | SurfaceShape::Mesh { .. } => None,
        SurfaceShape::Sphere { centre, radius } => {
            Some(Bounds { low: centre - radius, high: centre + radius })
        }
        SurfaceShape::Rectangle { centre, edge_u, edge_v } => {
            let half = 0.5 * (edge_u.abs() + edge_v.abs());
            Some(Bounds { low: centre - half, high: centre + half })
        }
        SurfaceShape::Disk { centre, normal, radius } => {
            let half = radius * (1.0 - normal * normal).max(DVec3::ZERO).map(f64::sqrt);
            Some(Bounds { low: centre - half, high: centre + half })
        }
        SurfaceShape::Box { low, high } => Some(Bounds { low, high }),
        SurfaceShape::Metaballs { ref balls, .. } => {
            let positive = balls.iter().filter(|ball| ball.weight > 0.0);
            Bounds::around(positive.map(|b| Bounds { low: b.centre - b.radius, high: b.centre + b.radius }))
        }
    }
}

fn device_material(material: &SurfaceMaterial, unit: f64) -> DeviceMaterial {
    let float3 = |v: [f64; 3]| float4(DVec3::from_array(v), 0.0);
    let blank = DeviceMaterial {
        color: [1.0, 1.0, 1.0, 0.0],
        absorption: [0.0; 4],
        cauchy: [0.0; 4],
        kind: 0,
        pad_0: 0,
        pad_1: 0,
        pad_2: 0,
    };
    match *material {
        SurfaceMaterial::Diffuse { color } => {
            DeviceMaterial { color: float3(color), kind: DeviceMaterial::DIFFUSE, ..blank }
        }
        SurfaceMaterial::Mirror { color } => {
            DeviceMaterial { color: float3(color), kind: DeviceMaterial::MIRROR, ..blank }
        }
        SurfaceMaterial::Dielectric { cauchy, absorption } => {
            let at_d_line = material.index(D_LINE);
            DeviceMaterial {
                absorption: float3(absorption.map(|per_unit| per_unit * unit)),
                cauchy: float4(DVec3::from_array(cauchy), at_d_line),
                kind: DeviceMaterial::DIELECTRIC,
                ..blank
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: LocalFrame =
        LocalFrame { origin: DVec3::new(10.0, 0.0, 0.0), unit: 0.5, dims: [8; 3], spacing: DVec3::ONE };
    const CHALK: SurfaceMaterial = SurfaceMaterial::Diffuse { color: [0.8, 0.7, 0.6] };
    const SILVER: SurfaceMaterial = SurfaceMaterial::Mirror { color: [0.9; 3] };
    const GLASS: SurfaceMaterial =
        SurfaceMaterial::Dielectric { cauchy: [1.5, 0.004, 0.0001], absorption: [2.0, 0.0, 4.0] };

    fn sphere(x: f64, radius: f64, material: usize) -> Surface {
        Surface { shape: SurfaceShape::Sphere { centre: DVec3::X * x, radius }, material }
    }

    fn arrays(surfaces: &[Surface]) -> Result<SurfaceArrays> {
        let materials = [CHALK, SILVER, GLASS];
        SurfaceArrays::new(surfaces, &materials, &crate::surfaces::load(surfaces, &materials)?, &FRAME)
    }

    #[test]
    fn planes_come_first_and_materials_by_surface() {
        let shape = SurfaceShape::Plane { point: DVec3::new(10.0, 3.0, 0.0), normal: DVec3::Y };
        let floor = Surface { shape, material: 0 };
        let found =
            arrays(&[sphere(12.0, 1.0, 2), floor, sphere(20.0, 2.0, 0), sphere(30.0, 2.0, 1)]).unwrap();
        assert_eq!((found.plane_count, found.shapes[0].kind, found.shapes[0].surface), (1, kind::PLANE, 1));
        assert_eq!(found.shapes[0].b, [0.0, 1.0, 0.0, 6.0]);
        assert_eq!(found.materials_of, [2, 0, 0, 1]);
        // One leaf, after the plane.
        assert_eq!(
            (found.nodes.len(), found.nodes[0].low[3].to_bits(), found.nodes[0].high[3].to_bits()),
            (1, 1, 3)
        );
        let bounds = |low: f64, high: f64, r: f64| {
            Some(Bounds { low: DVec3::new(low, -r, -r), high: DVec3::new(high, r, r) })
        };
        assert_eq!((found.bounds, found.specular_bounds), (bounds(11.0, 32.0, 2.0), bounds(11.0, 32.0, 2.0)));
        let diffuse = arrays(&[sphere(20.0, 2.0, 0)]).unwrap();
        assert_eq!((diffuse.bounds, diffuse.specular_bounds), (bounds(18.0, 22.0, 2.0), None));
        // The glass that nothing is made of does not count.
        assert!(found.disperses() && !diffuse.disperses());
        let spec = found.specialise(ProgramSpec::new("surfaces/intersect.cl"));
        let names: Vec<_> = spec.defines.iter().map(|(name, _)| *name).collect();
        assert_eq!(names, ["SHAPE_PLANE", "SHAPE_SPHERE"]);
    }

    #[test]
    fn materials_in_local_units() {
        let [chalk, silver, glass] = arrays(&[]).unwrap().materials[..] else { panic!("three") };
        assert_eq!((chalk.kind, chalk.color), (0, [0.8, 0.7, 0.6, 0.0]));
        assert_eq!((silver.kind, silver.color), (1, [0.9, 0.9, 0.9, 0.0]));
        assert_eq!((glass.kind, glass.absorption), (2, [1.0, 0.0, 2.0, 0.0]));
        // 1.5 + 0.004 / 0.34523 + 0.0001 / 0.11918.
        assert_eq!(glass.cauchy[..3], [1.5, 0.004, 0.0001]);
        assert!((glass.cauchy[3] - 1.512_425_5).abs() < 1e-6, "{}", glass.cauchy[3]);
    }

    #[test]
    fn what_float32_cannot_hold_is_an_error() {
        for (x, radius) in [(1e39, 1.0), (12.0, 1e-39), (12.0, 1e39)] {
            let error = arrays(&[sphere(12.0, 1.0, 0), sphere(x, radius, 0)]).unwrap_err();
            assert_eq!(error.exit_code(), 2);
            assert!(
                error.to_string().starts_with("`surface.1` is too large, too small or too far"),
                "{error}"
            );
        }
    }
}
