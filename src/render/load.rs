//! From a scene's description of its volume to the volume itself.

use super::light_volume::modelled;
use super::local::LocalFrame;
use crate::device::MemoryPlan;
use crate::film::FilmPixel;
use crate::host_memory;
use crate::irradiance::{LightGrid, memory_of};
use crate::scene::{
    self, Endian as SceneEndian, FieldKind, Method, Scene, SheppLoganRotation, VolumeSource, VoxelKind,
};
use crate::surfaces::{self, Meshes};
use crate::volume::field::{
    AnyField, Axis, Cloud, Constant, Hydrogen, MarschnerLobb, Ramp, Rotation, SheppLogan, Sphere, sample,
};
use crate::volume::{Endian, RawOptions, StoredType, Volume, read};
use crate::{Error, Result};
use glam::DVec3;

/// What a scene works on: read from its files, or sampled.
pub struct SceneData {
    /// The volume, where the scene has one.
    pub volume: Option<Volume>,
    /// The meshes among its surfaces.
    pub meshes: Meshes,
}

impl SceneData {
    /// Reads the scene's files.
    ///
    /// # Errors
    /// [`Error::Input`] when a file is wrong or a field's parameters are, [`Error::Failed`] when this machine cannot
    /// hold the field.
    pub fn load(scene: &Scene) -> Result<Self> {
        Ok(Self {
            volume: scene.volume.as_ref().map(load_volume).transpose()?,
            meshes: surfaces::load(&scene.surfaces, &scene.materials)?,
        })
    }
}

/// The data of a scene, wherever they are kept.
#[derive(Clone, Copy)]
pub struct DataRef<'a> {
    /// The volume, where the scene has one.
    pub volume: Option<&'a Volume>,
    /// The meshes among its surfaces.
    pub meshes: &'a Meshes,
}

impl<'a> From<&'a SceneData> for DataRef<'a> {
    fn from(data: &'a SceneData) -> Self {
        Self { volume: data.volume.as_ref(), meshes: &data.meshes }
    }
}

impl<'a> From<&'a Volume> for DataRef<'a> {
    fn from(volume: &'a Volume) -> Self {
        Self { volume: Some(volume), meshes: Meshes::NONE }
    }
}

/// What a render of `scene` allocates on a device at least, as far as that is known before the volume is loaded.
pub fn announced_memory(scene: &Scene) -> MemoryPlan {
    let mut plan = MemoryPlan::default();
    if let Some(scene::Volume { source: VolumeSource::Field { dims, .. }, spacing, .. }) = &scene.volume {
        plan.add("voxels", voxel_count(*dims), size_of::<f32>());
        // Beyond this no grid is made anyway.
        if let (Method::LightVolume(light), true) = (&scene.method, voxel_count(*dims) < 1 << 40) {
            let local = LocalFrame::new(DVec3::ZERO, spacing.unwrap_or(DVec3::ONE), *dims);
            let [direct, scattered] =
                [light.direct_coarsening, light.coarsening].map(|voxels| LightGrid::new(&local, voxels));
            let phase = modelled(scene.phase, light);
            plan.items.extend(memory_of(light, &phase, [&direct, &scattered], scene.lights.len()).items);
        }
    }
    let image = &scene.image;
    plan.add("film", u64::from(image.width) * u64::from(image.height), size_of::<FilmPixel>());
    plan
}

fn voxel_count(dims: [usize; 3]) -> u64 {
    dims.iter().fold(1, |product, &n| product.saturating_mul(n as u64))
}

/// Reads the file, or samples the field at voxel centres.
///
/// # Errors
/// [`Error::Input`] when the file is wrong or the field's parameters are, [`Error::Failed`] when this machine
/// cannot hold the field.
pub fn load_volume(settings: &scene::Volume) -> Result<Volume> {
    match &settings.source {
        VolumeSource::File { path, dims, voxel_type, endian, offset } => {
            let options = RawOptions {
                dims: *dims,
                kind: voxel_type.map(stored_type),
                // Little is the default, and files with a header say their own.
                endian: (*endian == SceneEndian::Big).then_some(Endian::Big),
                offset: *offset,
            };
            Ok(read(path, &options)?)
        }
        VolumeSource::Field { kind, dims } => {
            let extent = DVec3::from_array(dims.map(|n| n as f64)) * settings.spacing.unwrap_or(DVec3::ONE);
            host_memory::check("the procedural field", voxel_count(*dims).saturating_mul(4))?;
            let field = field(kind, extent / extent.max_element())?;
            sample(&field, *dims).map_err(|error| Error::Input(format!("[volume] field: {error}")))
        }
    }
}

fn stored_type(kind: VoxelKind) -> StoredType {
    match kind {
        VoxelKind::Uint8 => StoredType::U8,
        VoxelKind::Int8 => StoredType::I8,
        VoxelKind::Uint16 => StoredType::U16,
        VoxelKind::Int16 => StoredType::I16,
        VoxelKind::Float32 => StoredType::F32,
        VoxelKind::Float64 => StoredType::F64,
    }
}

/// `aspect`: extents of the box over the largest one.
fn field(kind: &FieldKind, aspect: DVec3) -> Result<AnyField> {
    Ok(match *kind {
        FieldKind::Constant { value } => AnyField::Constant(Constant::new(value)?),
        FieldKind::Ramp { from, to, axis } => {
            let axis = match axis {
                scene::Axis::X => Axis::X,
                scene::Axis::Y => Axis::Y,
                scene::Axis::Z => Axis::Z,
            };
            AnyField::Ramp(Ramp::new(from, to, axis)?)
        }
        FieldKind::Sphere { centre, radius } => AnyField::Sphere(Sphere::new(centre, radius, aspect)?),
        FieldKind::MarschnerLobb { frequency, alpha } => {
            AnyField::MarschnerLobb(MarschnerLobb::new(frequency, alpha)?)
        }
        FieldKind::SheppLogan { rotation } => AnyField::SheppLogan(SheppLogan::new(match rotation {
            SheppLoganRotation::Schabel => Rotation::Schabel,
            SheppLoganRotation::OwnAxis => Rotation::OwnAxis,
        })),
        FieldKind::Hydrogen { n, l, m, extent } => {
            AnyField::Hydrogen(Hydrogen::new(n, l, m, extent, aspect)?)
        }
        FieldKind::Cloud => AnyField::Cloud(Cloud),
    })
}
