//! Triangles of files.

mod obj;
mod ply;
mod topology;

use super::bounds::Bounds;
use crate::input;
use crate::scene::{Surface, SurfaceMaterial, SurfaceShape};
use crate::{Error, Result};
use glam::DVec3;
use std::path::Path;

/// Triangles with less than this as the sine of an angle have no area that float64 is sure of.
const LEAST_SINE: f64 = 1e-14;

/// Triangles in scene units.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// The places of the corners.
    pub points: Vec<DVec3>,
    /// The corners of each triangle, counterclockwise as seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Unit normals at the corners of each triangle, where the mesh is smooth.
    pub normals: Option<Vec<[DVec3; 3]>>,
}

impl Mesh {
    /// Corners of each triangle, and the normals there.
    pub fn faces(&self) -> impl Iterator<Item = ([DVec3; 3], Option<[DVec3; 3]>)> + '_ {
        let normals = |index| self.normals.as_ref().map(|normals| normals[index]);
        (0..self.triangles.len()).map(move |index| (self.corners(index), normals(index)))
    }

    /// The box around it.
    pub fn bounds(&self) -> Option<Bounds> {
        Bounds::of(self.faces().flat_map(|(corners, _)| corners))
    }

    fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|corner| self.points[corner as usize])
    }
}

/// The meshes of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Meshes {
    /// By surface; `None` for those that are no meshes.
    by_surface: Vec<Option<Mesh>>,
    /// What the user should know, one sentence each.
    pub notes: Vec<String>,
}

impl Meshes {
    /// Those of a scene without surfaces.
    pub const NONE: &'static Self = &Self { by_surface: Vec::new(), notes: Vec::new() };

    /// The mesh of a surface, if it is one.
    pub fn of(&self, surface: usize) -> Option<&Mesh> {
        self.by_surface.get(surface)?.as_ref()
    }
}

/// Reads the meshes among the surfaces.
///
/// # Errors
/// [`Error::Input`] naming the file and what is wrong with it.
pub fn load(surfaces: &[Surface], materials: &[SurfaceMaterial]) -> Result<Meshes> {
    let mut meshes = Meshes::default();
    for surface in surfaces {
        let mesh = match &surface.shape {
            SurfaceShape::Mesh { path, scale, translate, smooth } => {
                let place = |point| *scale * point + *translate;
                let mesh = read(path, place, *smooth, &mut meshes.notes)?;
                if matches!(materials[surface.material], SurfaceMaterial::Dielectric { .. }) {
                    meshes.notes.extend(topology::doubts(&mesh).map(|doubt| named(path, &doubt)));
                }
                Some(mesh)
            }
            _ => None,
        };
        meshes.by_surface.push(mesh);
    }
    Ok(meshes)
}

/// What a file says: polygons as triangles.
#[derive(Debug, Default)]
struct Raw {
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    /// At the corners of each triangle, of any length.
    normals: Option<Vec<[DVec3; 3]>>,
    /// Faces of fewer than three vertices, of which there is no triangle.
    too_short: usize,
}

fn read(path: &Path, place: impl Fn(DVec3) -> DVec3, smooth: bool, notes: &mut Vec<String>) -> Result<Mesh> {
    let wrong = |problem: String| Error::Input(named(path, &problem));
    let bytes = input::bytes(path).map_err(|error| wrong(format!("it cannot be read: {error}")))?;
    let is_ply = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("ply"));
    let raw = if is_ply { ply::read(&bytes) } else { obj::read(&bytes) }.map_err(wrong)?;
    let points: Vec<DVec3> = raw.points.into_iter().map(place).collect();
    if let Some(index) = points.iter().position(|point| !point.is_finite()) {
        return Err(wrong(format!("vertex {} is not finite; every coordinate must be a number", index + 1)));
    }
    let found = raw.triangles.len();
    let mut mesh = Mesh { points, triangles: raw.triangles, normals: None };
    let flat: Vec<bool> = mesh.faces().map(|(corners, _)| is_flat(corners)).collect();
    let mut with_area = flat.iter().map(|flat| !flat);
    mesh.triangles.retain(|_| with_area.next() == Some(true));
    if mesh.triangles.is_empty() {
        let problem = if found == 0 { "it has no faces" } else { "none of its triangles has an area" };
        return Err(wrong(format!("{problem}; a mesh needs at least one triangle")));
    }
    if raw.too_short > 0 {
        let what = if raw.too_short == 1 { "1 face" } else { &format!("{} faces", raw.too_short) };
        notes.push(named(path, &format!("{what} of fewer than three vertices left out")));
    }
    if mesh.triangles.len() < found {
        let count = found - mesh.triangles.len();
        let what = if count == 1 { "1 triangle" } else { &format!("{count} triangles") };
        notes.push(named(path, &format!("{what} without area left out")));
    }
    if smooth {
        let mut flat = flat.into_iter();
        let of_file = raw.normals.map(|mut normals| {
            normals.retain(|_| flat.next() == Some(false));
            normals
        });
        if of_file.iter().flatten().flatten().any(|normal| !normal.is_finite()) {
            return Err(wrong("a normal is not finite; every component must be a number".into()));
        }
        let normals = of_file.unwrap_or_else(|| topology::mean_normals(&mesh));
        mesh.normals = Some(unit_normals(&mesh, normals));
    }
    Ok(mesh)
}

fn named(path: &Path, text: &str) -> String {
    format!("{}: {text}", path.display())
}

fn is_flat([a, b, c]: [DVec3; 3]) -> bool {
    match ((b - a).try_normalize(), (c - a).try_normalize(), (c - b).try_normalize()) {
        (Some(u), Some(v), Some(_)) => u.cross(v).length() < LEAST_SINE,
        _ => true,
    }
}

/// The normals with unit length; that of the triangle where one has none.
fn unit_normals(mesh: &Mesh, normals: Vec<[DVec3; 3]>) -> Vec<[DVec3; 3]> {
    let unit = |(index, normals): (usize, [DVec3; 3])| {
        let face = area_normal(mesh.corners(index)).normalize_or(DVec3::Z);
        normals.map(|normal| normal.normalize_or(face))
    };
    normals.into_iter().enumerate().map(unit).collect()
}

/// The normal of a triangle, as long as twice its area.
fn area_normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}
