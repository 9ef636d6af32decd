//! Triangles of files.

use super::bounds::Bounds;
use crate::scene::{Surface, SurfaceMaterial, SurfaceShape};
use crate::{Error, Result};
use glam::DVec3;

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
        let place = |corners: &[u32; 3]| corners.map(|corner| self.points[corner as usize]);
        let normals = |index| self.normals.as_ref().map(|normals| normals[index]);
        self.triangles.iter().enumerate().map(move |(index, corners)| (place(corners), normals(index)))
    }

    /// The box around it.
    pub fn bounds(&self) -> Option<Bounds> {
        Bounds::of(self.faces().flat_map(|(corners, _)| corners))
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
    /// The mesh of a surface, if it is one.
    pub fn of(&self, surface: usize) -> Option<&Mesh> {
        self.by_surface.get(surface)?.as_ref()
    }
}

/// Reads the meshes among the surfaces.
///
/// # Errors
/// [`Error::Input`] naming the file and what is wrong with it.
pub fn load(surfaces: &[Surface], _: &[SurfaceMaterial]) -> Result<Meshes> {
    let mut meshes = Meshes::default();
    for surface in surfaces {
        if let SurfaceShape::Mesh { path, .. } = &surface.shape {
            return Err(Error::Input(format!("{}: meshes cannot be read yet", path.display())));
        }
        meshes.by_surface.push(None);
    }
    Ok(meshes)
}
