//! The plan of a render: everything the device will get, made on the host and shown by `svetlo check`.

use super::auxiliary::Auxiliary;
use super::camera::DeviceCamera;
use super::grid::{BrickRanges, DeviceVolume, Grid, StoredWindow};
use super::ledger::Ledger;
use super::light_volume::LightSetup;
use super::local::LocalFrame;
use super::method::{self, DeviceFrame, HostBuffer, MethodInput, MethodSetup};
use super::session::TILE;
use crate::device::{MemoryPlan, ProgramSpec};
use crate::film::FilmPixel;
use crate::irradiance;
use crate::picture::Environment;
use crate::scene::{Background, CameraKind, DirectLight, Filter, Origin, Scene};
use crate::volume::Volume;
use crate::{Error, Result};
use bytemuck::Zeroable;
use glam::DVec3;

/// log2 of the cells per brick edge, by measurement: 8³ cells skip nearly as finely as 4³ at an eighth of the tests.
pub const BRICK_SHIFT: u32 = 3;

/// A render made ready on the host.
pub struct Plan<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The voxels and their window.
    pub grid: Grid<'a>,
    /// Local units.
    pub local: LocalFrame,
    /// The window in data units.
    pub window: (f64, f64),
    /// The program to build.
    pub spec: ProgramSpec,
    /// The method's part.
    pub method: MethodSetup,
    /// The environment map as texels for the device; a single unused one without a map.
    pub environment: HostBuffer,
    /// Remarks for the user, one sentence each.
    pub notes: Vec<String>,
    pub(crate) frame: DeviceFrame,
    pub(crate) camera: DeviceCamera,
    pub(crate) volume: DeviceVolume,
}

impl<'a> Plan<'a> {
    /// Plans a render of `scene` with its `volume`, in bricks of 2^`brick_shift` cells.
    ///
    /// # Errors
    /// [`Error::Input`] when the window is empty, the grid is beyond what kernels index, or a table or map
    /// cannot be read.
    pub fn new(scene: &'a Scene, volume: &'a Volume, brick_shift: u32) -> Result<Self> {
        check_extent(volume.dims)?;
        let mut notes = volume.notes.clone();
        notes.extend(non_finite_note(volume));
        let window = resolve_window(scene, volume, &mut notes)?;
        let spacing = scene.volume.spacing.unwrap_or(volume.spacing);
        let size = spacing * DVec3::from_array(volume.dims.map(|n| n as f64));
        let origin = match scene.volume.origin {
            Origin::Corner(corner) => corner,
            Origin::Centre => size * -0.5,
        };
        let local = LocalFrame::new(origin, spacing, volume.dims);
        let grid = Grid::new(volume, StoredWindow::new(volume, window), local);
        let bricks: BrickRanges = grid.brick_ranges(brick_shift);
        let mut frame = DeviceFrame {
            seed_low: scene.seed as u32,
            seed_high: (scene.seed >> 32) as u32,
            table_rows: 1,
            ..DeviceFrame::zeroed()
        };
        let map = environment_map(scene, &mut notes)?;
        let environment = background(scene, map.as_ref(), &mut frame);
        let input = MethodInput {
            scene,
            grid: &grid,
            bricks: &bricks,
            local: &local,
            window,
            environment: map.as_ref(),
        };
        let mut method = method::prepare(&input, &mut frame)?;
        notes.append(&mut method.notes);
        let lens = matches!(scene.camera.kind, CameraKind::Perspective { aperture, .. } if aperture > 0.0);
        let spec = method
            .spec
            .clone()
            .define("VOXEL", grid.device_type())
            .feature("FILTER_BOX", scene.image.filter == Filter::Box)
            .feature("THIN_LENS", lens)
            .feature("ENVIRONMENT", frame.environment_width > 0);
        let camera = DeviceCamera::new(&scene.camera, &scene.image, &local);
        camera.check()?;
        let volume = grid.describe(&bricks, method.value_units);
        Ok(Self { scene, grid, local, window, spec, method, environment, notes, frame, camera, volume })
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
        let (voxels, bytes) = self.grid.device_voxels();
        plan.add("voxels", voxels, bytes);
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
        for buffer in self.method.tables.iter().chain([&self.environment, &self.method.parameters]) {
            plan.add(buffer.name, buffer.bytes.len() as u64, 1);
        }
        plan
    }
}

/// Kernels count voxels per axis in 32-bit integers and slices in 32-bit unsigned ones.
fn check_extent(dims: [usize; 3]) -> Result<()> {
    let slice = (dims[0] as u64 + 4).saturating_mul(dims[1] as u64 + 4);
    if dims.iter().any(|&n| n > (1 << 24)) || slice > u64::from(u32::MAX) {
        return Err(Error::Input(format!(
            "a volume of {}×{}×{} voxels is too large: an axis may have at most 2^24 voxels and an x-y slice 2^32",
            dims[0], dims[1], dims[2]
        )));
    }
    Ok(())
}

fn non_finite_note(volume: &Volume) -> Option<String> {
    (volume.nan + volume.infinite > 0).then(|| {
        format!(
            "{} NaN and {} infinite voxels: NaN and -inf count as the window's low end, +inf as its high end",
            volume.nan, volume.infinite
        )
    })
}

/// The scene's window, or the type's range for 8-bit data, or the range of the data.
fn resolve_window(scene: &Scene, volume: &Volume, notes: &mut Vec<String>) -> Result<(f64, f64)> {
    use crate::volume::Voxels;
    if let Some(window) = scene.volume.window {
        return Ok(window);
    }
    let eight_bit = |lo: f64, hi: f64| {
        let (a, b) = (volume.slope * lo + volume.intercept, volume.slope * hi + volume.intercept);
        (a.min(b), a.max(b))
    };
    let window = match volume.voxels {
        Voxels::U8(_) => eight_bit(0.0, 255.0),
        Voxels::I8(_) => eight_bit(-128.0, 127.0),
        _ => match volume.data_range() {
            Some((lo, hi)) if lo < hi => (lo, hi),
            Some((value, _)) => {
                notes
                    .push(format!("every voxel is {value}: the window runs from {value} to {}", value + 1.0));
                (value, value + 1.0)
            }
            None => {
                return Err(Error::Input(
                    "the volume holds no finite voxel; give `[volume] window = { lo = …, hi = … }` to draw it anyway"
                        .into(),
                ));
            }
        },
    };
    notes.push(format!("window {} to {} (default)", window.0 as f32, window.1 as f32));
    Ok(window)
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
