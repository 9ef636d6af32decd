//! The plan of a render: everything the device will get, made on the host and shown by `svetlo check`.

use super::auxiliary::Auxiliary;
use super::camera::DeviceCamera;
use super::caustics;
use super::ledger::Ledger;
use super::light_volume::LightSetup;
use super::load::DataRef;
use super::local::LocalFrame;
use super::method::{self, DeviceFrame, HostBuffer, MethodInput, MethodSetup};
use super::planned_volume::PlannedVolume;
use super::share::Share;
use super::tiles::TILE;
use crate::device::{MemoryPlan, ProgramSpec};
use crate::film::FilmPixel;
use crate::irradiance;
use crate::picture::Environment;
use crate::scene::{Background, CameraKind, DirectLight, Filter, Method, Scene};
use crate::{Error, Result};
use bytemuck::Zeroable;

/// log2 of the cells per brick edge, by measurement: 8³ cells skip nearly as finely as 4³ at an eighth of the tests.
pub const BRICK_SHIFT: u32 = 3;

/// A render made ready on the host.
pub struct Plan<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The volume, where the scene has one.
    pub volume: Option<PlannedVolume<'a>>,
    /// Local units.
    pub local: LocalFrame,
    /// The program to build.
    pub spec: ProgramSpec,
    /// The method's part.
    pub method: MethodSetup,
    /// The environment map as texels for the device; a single unused one without a map.
    pub environment: HostBuffer,
    /// Remarks for the user, one sentence each.
    pub notes: Vec<String>,
    /// The share of the picture's samples that is rendered, where it is not the whole.
    pub part: Option<Share>,
    pub(crate) frame: DeviceFrame,
    pub(crate) camera: DeviceCamera,
}

impl<'a> Plan<'a> {
    /// Plans a render of `scene` with its `data`, a volume in bricks of 2^`brick_shift` cells.
    ///
    /// # Errors
    /// [`Error::Input`] when the window is empty, the grid is beyond what kernels index, or a table or map
    /// cannot be read.
    pub fn new(scene: &'a Scene, data: impl Into<DataRef<'a>>, brick_shift: u32) -> Result<Self> {
        let mut notes = Vec::new();
        let data = data.into();
        let mut volume = match (&scene.volume, data.volume) {
            (Some(settings), Some(volume)) => {
                Some(PlannedVolume::new(settings, volume, brick_shift, &mut notes)?)
            }
            _ => None,
        };
        let mut frame = DeviceFrame {
            seed_low: scene.seed as u32,
            seed_high: (scene.seed >> 32) as u32,
            table_rows: 1,
            sample_stride: 1,
            ..DeviceFrame::zeroed()
        };
        let map = environment_map(scene, &mut notes)?;
        let environment = background(scene, map.as_ref(), &mut frame);
        let local = match &volume {
            Some(volume) => volume.local,
            None => caustics::frame(scene, data.meshes),
        };
        let input = volume.as_ref().map(|PlannedVolume { grid, bricks, local, window, .. }| MethodInput {
            scene,
            grid,
            bricks,
            local,
            window: *window,
            environment: map.as_ref(),
        });
        let mut method = match (&scene.method, &input) {
            (&Method::Caustics(settings), input) => {
                caustics::prepare(scene, settings, data.meshes, &local, input.as_ref(), &mut frame)?
            }
            (_, Some(input)) => method::prepare(input, &mut frame)?,
            (_, None) => return Err(no_volume()),
        };
        notes.append(&mut method.notes);
        let lens = matches!(scene.camera.kind, CameraKind::Perspective { aperture, .. } if aperture > 0.0);
        let mut spec = method
            .spec
            .clone()
            .feature("FILTER_BOX", scene.image.filter == Filter::Box)
            .feature("THIN_LENS", lens)
            .feature("ENVIRONMENT", frame.environment_width > 0);
        if let Some(volume) = &mut volume {
            spec = spec.define("VOXEL", volume.grid.device_type());
            volume.device = volume.grid.describe(&volume.bricks, method.value_units);
        }
        let camera = DeviceCamera::new(&scene.camera, &scene.image, &local);
        camera.check()?;
        Ok(Self { scene, volume, local, spec, method, environment, notes, part: None, frame, camera })
    }

    /// The plan of a part of the picture, if `part` is one.
    ///
    /// # Errors
    /// [`Error::Input`] where one sample is the whole picture.
    pub fn of_part(mut self, part: Option<Share>) -> Result<Self> {
        let Some(share) = part else { return Ok(self) };
        if self.is_deterministic() {
            return Err(Error::Input(format!(
                "--part {share}: nothing in this scene is random, so one sample is the whole picture and there is \
                 nothing to share; render it without --part (or with image.filter = \"box\", to smooth edges)"
            )));
        }
        if self.method.light.is_some() {
            self.notes.push(
                "every part computes the light in the whole volume for itself unless --load-light gives it: --save-light \
                 keeps that of one part for the others, which saves time and, between devices, makes parts fit together"
                    .into(),
            );
        }
        (self.frame.sample_first, self.frame.sample_stride) = (share.first(), share.of());
        self.part = part;
        Ok(self)
    }

    /// The share of the picture's samples that is rendered.
    pub fn share(&self) -> Share {
        self.part.unwrap_or(Share::WHOLE)
    }

    /// The volume.
    ///
    /// # Errors
    /// [`Error::Input`] where the scene has none.
    pub fn volume(&self) -> Result<&PlannedVolume<'a>> {
        self.volume.as_ref().ok_or_else(no_volume)
    }

    /// Voxels on the device.
    pub fn voxels(&self) -> u64 {
        self.volume.as_ref().map_or(0, |volume| volume.grid.device_voxels().0)
    }

    /// Whether every sample of a pixel is the same: then one is enough.
    pub fn is_deterministic(&self) -> bool {
        let lens =
            matches!(self.scene.camera.kind, CameraKind::Perspective { aperture, .. } if aperture > 0.0);
        self.scene.image.filter == Filter::Point && !lens && !self.method.random
    }

    /// Whether another seed gives another picture.
    pub fn depends_on_seed(&self) -> bool {
        let tracked = |light: &LightSetup| matches!(light.settings.direct, DirectLight::Tracking { .. });
        !self.is_deterministic() || self.method.light.as_deref().is_some_and(tracked)
    }

    /// Whether there are auxiliary images: the scene asks for them and the method makes them.
    pub fn has_auxiliary(&self) -> bool {
        self.scene.film.auxiliary && self.method.paths
    }

    /// What a session allocates on the device, at most.
    pub fn memory(&self) -> MemoryPlan {
        let mut plan = MemoryPlan::default();
        if let Some(volume) = &self.volume {
            let (voxels, bytes) = volume.grid.device_voxels();
            plan.add("voxels", voxels, bytes);
        }
        let image = &self.scene.image;
        let pixels = u64::from(image.width) * u64::from(image.height);
        plan.add("film", pixels, size_of::<FilmPixel>());
        if self.method.paths {
            // One ledger per tile where a work-item renders a tile, else one per pixel of every tile.
            let in_tiles = |n: u32| u64::from(n.div_ceil(TILE) * TILE);
            plan.add("ledgers", in_tiles(image.width) * in_tiles(image.height), size_of::<Ledger>());
        }
        if self.has_auxiliary() {
            plan.add("auxiliary images", pixels, size_of::<Auxiliary>());
        }
        if let Some(light) = &self.method.light {
            plan.items.extend(irradiance::memory(light, self.scene.lights.len()).items);
        }
        if let Some(setup) = &self.method.caustics {
            plan.items.extend(setup.memory().items);
        }
        for buffer in self.method.tables.iter().chain([&self.environment, &self.method.parameters]) {
            plan.add(buffer.name, buffer.bytes.len() as u64, 1);
        }
        plan
    }
}

fn no_volume() -> Error {
    Error::Input("the scene has no [volume], which its method renders".into())
}

/// Reads the scene's environment map.
fn environment_map(scene: &Scene, notes: &mut Vec<String>) -> Result<Option<Environment>> {
    let Background::Environment { path, .. } = &scene.background else { return Ok(None) };
    let map = Environment::read(path)?;
    notes.extend(map.notes.iter().cloned());
    Ok(Some(map))
}

/// Fills the background of `frame`; returns the environment map's texels.
fn background(scene: &Scene, map: Option<&Environment>, frame: &mut DeviceFrame) -> HostBuffer {
    let rgb = |c: [f64; 3]| [c[0] as f32, c[1] as f32, c[2] as f32, 0.0];
    match (&scene.background, map) {
        (Background::Environment { intensity, rotation, .. }, Some(map)) => {
            frame.background = rgb([*intensity; 3]);
            frame.environment_width = map.width as u32;
            frame.environment_height = map.height as u32;
            frame.environment_turn = (rotation / std::f64::consts::TAU) as f32;
            let texels: Vec<[f32; 4]> = map.rgb.iter().map(|c| [c[0], c[1], c[2], 0.0]).collect();
            HostBuffer::new("environment map", &texels)
        }
        (background, _) => {
            if let Background::Constant(color) = background {
                frame.background = rgb(*color);
            }
            HostBuffer::new("environment map (none)", &[[0.0_f32; 4]])
        }
    }
}
