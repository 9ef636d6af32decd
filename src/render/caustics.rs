//! Caustics: pictures of surfaces and of the light that mirrors and glass bring together. The kernel is
//! `cl/render/caustics.cl`; photons are in [`crate::caustics`].

use super::caustics_notes::{details, notes};
use super::lights::DeviceLight;
use super::local::LocalFrame;
use super::method::{DeviceFrame, HostBuffer, MethodInput, MethodSetup};
use crate::caustics::{
    Emitter, MOST_PHOTONS, MapSettings, Photon, PhotonTracer, Receiver, diffuse_light_returns, emitters,
    map_settings, mean_color, medium_setup, photon_settings, reach, receiver, specialise_medium,
};
use crate::device::{MemoryPlan, ProgramSpec};
use crate::scene::{CameraKind, Caustics, CausticsDirect, Light, Scene, Surface};
use crate::sort::CellRanges;
use crate::surfaces::{self, Bounds, DeviceNode, DeviceShape, Meshes, SurfaceArrays};
use crate::{Error, Result, device_struct};
use bytemuck::Zeroable;
use glam::DVec3;

/// A ray that carries less than this part of the picture's light takes one way at glass, not both.
const SPLIT: f32 = 0.02;
/// The radius of gathering over the extent of what makes caustics, where the scene does not say.
const RADIUS: f64 = 0.01;
/// That of gathering light between diffuse surfaces, over the former. This light varies over the size of things, not over
/// the width of caustics' lines: noise falls up to there and no bias shows in `configs/glass_sphere.toml`.
const BOUNCE_FACTOR: f64 = 16.0;
/// Its least and largest part of the scene's size, so that rooms are smooth about small things of glass, and shadows stay.
const BOUNCE_PARTS: [f64; 2] = [0.08, 0.2];
/// Tables of the scattering methods that the medium is read from: majorants, extinction, albedo.
pub const MEDIUM_TABLES: usize = 3;
/// Cells with a range of their own, over photons, at most: nearly all would be empty.
const CELLS_PER_PHOTON: usize = 256;

device_struct! {
    "types/caustics.cl",
    /// Parameters of pictures of surfaces; see `cl/types/caustics.cl`.
    pub struct DeviceCaustics {
        /// One over the mean colour of all wavelengths.
        pub white: [f32; 4],
        /// Factor of what photons give.
        pub photon_scale: f32,
        /// Below this weight rays do not divide.
        pub split: f32,
        /// Number of planes.
        pub plane_count: u32,
        /// Number of boxes of the hierarchy.
        pub node_count: u32,
        /// Most reflections and refractions.
        pub depth: u32,
        /// Padding.
        pub pad_0: u32,
        /// Padding.
        pub pad_1: u32,
        /// Padding.
        pub pad_2: u32,
    }
}

/// What traces and gathers photons, made ready on the host.
pub struct CausticsSetup {
    /// The settings.
    pub settings: Caustics,
    /// The surfaces.
    pub surfaces: SurfaceArrays,
    /// What gathering knows of each.
    pub receivers: Vec<Receiver>,
    /// How photons are gathered.
    pub map: MapSettings,
    /// The radius of the first pass, local units.
    pub radius: f64,
    /// How photons are gathered that diffuse surfaces reflect, if there are any.
    pub bounced: Option<BouncedSetup>,
    /// The medium between the surfaces as single scattering reads it, where the scene has a volume.
    pub medium: Option<MethodSetup>,
}

/// How photons are gathered that diffuse surfaces reflect.
pub struct BouncedSetup {
    /// How many there are.
    pub photons: u32,
    /// Their map.
    pub map: MapSettings,
    /// What gathering knows of each surface.
    pub receivers: Vec<Receiver>,
    /// The radius of the first pass, local units.
    pub radius: f64,
}

impl CausticsSetup {
    /// What the passes allocate on a device, at most.
    pub fn memory(&self) -> MemoryPlan {
        let mut plan = MemoryPlan::default();
        PhotonTracer::memory(&mut plan, self.settings.photons);
        let photons = u64::from(self.settings.photons);
        plan.add("photons in order", photons, 32);
        // Keys and numbers, before and after, whatever sorts them.
        plan.add("keys of photons", photons, 20);
        for table in self.medium.iter().flat_map(|medium| &medium.tables) {
            // For photons once more.
            plan.add(table.name, table.bytes.len() as u64, 1);
        }
        if self.map.has_cells() {
            // A table for each map; together they have all photons.
            let of_bounced = self.bounced.as_ref().map_or(0, |bounced| bounced.map.table_cells);
            let cells = self.map.table_cells + of_bounced;
            plan.items.extend(CellRanges::memory(cells, self.settings.photons as usize).items);
        }
        plan.add("shapes", self.surfaces.shapes.len() as u64, size_of::<DeviceShape>());
        plan.add("boxes of shapes", self.surfaces.nodes.len() as u64, size_of::<DeviceNode>());
        plan
    }
}

/// The frame in which the surfaces are computed: that of what reflects and refracts, where float32 is needed most.
pub fn frame(scene: &Scene, meshes: &Meshes) -> LocalFrame {
    let bounds = |specular: bool| {
        let wanted =
            |surface: &crate::scene::Surface| !specular || scene.materials[surface.material].is_specular();
        surfaces::bounds_of(&scene.surfaces, meshes, wanted)
    };
    let whole = bounds(true).or_else(|| bounds(false)).unwrap_or_else(|| {
        let camera = &scene.camera;
        let half = DVec3::splat(0.5 * camera.position.distance(camera.target));
        Bounds { low: camera.target - half, high: camera.target + half }
    });
    let size = whole.size();
    LocalFrame {
        origin: whole.low,
        unit: size.max_element(),
        dims: [1; 3],
        spacing: size / size.max_element(),
    }
}

/// Makes the method ready, with a volume between the surfaces if there is one.
///
/// # Errors
/// [`crate::Error::Input`] where float32 cannot hold the scene, or the volume does what this method does not know.
pub fn prepare(
    scene: &Scene,
    settings: Caustics,
    meshes: &Meshes,
    local: &LocalFrame,
    volume: Option<&MethodInput<'_>>,
    frame: &mut DeviceFrame,
) -> Result<MethodSetup> {
    // In a volume light ends where diffuse surfaces reflect it.
    let settings = Caustics { bounces: if volume.is_some() { 0 } else { settings.bounces }, ..settings };
    // Before the lights: those of the medium have no say.
    let medium = volume.map(|input| medium_setup(input, &settings, frame)).transpose()?;
    if scene.surfaces.len() > Photon::MOST_SURFACES {
        return Err(Error::Input(format!(
            "the scene has {} surfaces, and photons can tell {} apart: make meshes of some of them",
            scene.surfaces.len(),
            Photon::MOST_SURFACES
        )));
    }
    let surfaces = SurfaceArrays::new(&scene.surfaces, &scene.materials, meshes, local)?;
    let lights = device_lights(&scene.lights, local, frame);
    let map = map_settings(&settings.gather);
    let extent = surfaces.specular_bounds.or(surfaces.bounds).map_or(local.unit, |b| b.size().max_element());
    let radius = gather_radius(settings.radius.unwrap_or(RADIUS * extent), local.unit)?;
    let photons = photons_wanted(scene, &settings, &surfaces);
    let settings = Caustics { photons: if photons { settings.photons } else { 0 }, ..settings };
    // What no photon can do is found here, not on the device.
    let emission = photon_settings(&settings, scene.seed).emission;
    let emitters = emitters(&scene.lights, &surfaces, local, &emission)?;
    let bounced = bounced(scene, &settings, meshes, local, (&surfaces, &emitters, radius));
    let others = bounced.as_ref().map_or(0, |bounced| bounced.photons);
    if let Some(most) = [others, settings.photons - others].into_iter().find(|&n| n as usize > MOST_PHOTONS) {
        return Err(Error::Input(format!(
            "`method.photons` = {} is too large: a map would have {most} of them, and can have up to {MOST_PHOTONS}; more \
             samples bring more photons, in as little memory",
            settings.photons
        )));
    }
    let map = tabled(map, settings.photons - others);
    let [r, g, b] = mean_color().map(|mean| (1.0 / mean) as f32);
    let parameters = DeviceCaustics {
        white: [r, g, b, 0.0],
        photon_scale: photon_scale(&emitters, settings.gather.paper_intensity),
        split: SPLIT,
        plane_count: surfaces.plane_count as u32,
        node_count: surfaces.nodes.len() as u32,
        depth: settings.depth,
        ..DeviceCaustics::zeroed()
    };
    let mut spec = map
        .define_gather(surfaces.specialise(ProgramSpec::new("render/caustics.cl")))
        .feature("DISPERSION", surfaces.disperses())
        .feature("RECTANGLES", frame.rectangle_count > 0)
        .feature("DIRECT_RAYS", settings.direct == CausticsDirect::Rays)
        .feature("BOUNCED", bounced.is_some())
        .feature("BEGINS_WITHIN", surfaces.may_begin_within(&camera_places(scene, local), medium.is_some()));
    let mut tables = Vec::new();
    if let Some(medium) = &medium {
        spec = specialise_medium(spec, medium);
        tables.push(HostBuffer { name: "medium", bytes: medium.parameters.bytes.clone() });
        let of_medium = medium.tables.iter().take(MEDIUM_TABLES);
        tables.extend(of_medium.map(|table| HostBuffer { name: table.name, bytes: table.bytes.clone() }));
    }
    tables.push(lights_buffer(&lights));
    Ok(MethodSetup {
        spec,
        kernel: "render_caustics",
        parameters: HostBuffer::new("method parameters", &[parameters]),
        tables,
        value_units: medium.as_ref().map_or(1.0, |medium| medium.value_units),
        random: true,
        lanes: false,
        paths: false,
        has_depth: true,
        notes: notes(scene, meshes, local, photons),
        details: details(&surfaces, [Some(radius), bounced.as_ref().map(|b| b.radius)], local.unit),
        light: None,
        caustics: Some(Box::new(CausticsSetup {
            settings,
            receivers: scene.surfaces.iter().map(|surface| receiver(&surface.shape, local)).collect(),
            surfaces,
            map,
            radius,
            bounced,
            medium,
        })),
    })
}

/// Where rays of the camera begin: a box around these places, local units.
fn camera_places(scene: &Scene, local: &LocalFrame) -> Bounds {
    let (camera, image) = (&scene.camera, &scene.image);
    let half = match camera.kind {
        CameraKind::Perspective { aperture, .. } => aperture,
        CameraKind::Orthographic { height } => {
            0.5 * height * f64::hypot(1.0, f64::from(image.width) / f64::from(image.height))
        }
    };
    Bounds { low: local.point(camera.position - half), high: local.point(camera.position + half) }
}

/// No larger table of cells than so many photons need.
fn tabled(map: MapSettings, photons: u32) -> MapSettings {
    let table_cells = map.table_cells.min(CELLS_PER_PHOTON * photons as usize).max(1);
    MapSettings { table_cells, ..map }
}

/// How photons are gathered that diffuse surfaces reflect, where there are such emitters.
fn bounced(
    scene: &Scene,
    settings: &Caustics,
    meshes: &Meshes,
    local: &LocalFrame,
    (surfaces, emitters, radius): (&SurfaceArrays, &[Emitter], f64),
) -> Option<BouncedSetup> {
    let photons: u32 = emitters.iter().filter(|emitter| emitter.is_bounced()).map(|e| e.count).sum();
    if photons == 0 {
        return None;
    }
    let chosen = settings.bounce_radius.map(|radius| radius / local.unit);
    let radius = chosen.unwrap_or_else(|| bounce_radius(scene, surfaces, local, radius));
    let receiver_of = |(index, surface): (usize, &Surface)| {
        let own = surfaces::bounds_of_one(index, surface, meshes);
        let extent = own.map_or(0.0, |bounds| bounds.size().max_element());
        let reach = reach(&surface.shape, extent) / local.unit;
        // Squares of the ratio stay finite.
        Receiver { reach: reach.max(1e-6 * radius) as f32, ..receiver(&surface.shape, local) }
    };
    Some(BouncedSetup {
        photons,
        map: tabled(map_settings(&settings.gather), photons),
        receivers: scene.surfaces.iter().enumerate().map(receiver_of).collect(),
        radius,
    })
}

/// Where the scene does not say, from that of caustics; local units. A scene is as large as what has bounds, or as its target
/// is away: floors may go on for ever.
fn bounce_radius(scene: &Scene, surfaces: &SurfaceArrays, local: &LocalFrame, radius: f64) -> f64 {
    let away = scene.camera.position.distance(scene.camera.target);
    let size = surfaces.bounds.map_or(away, |bounds| away.min(bounds.size().max_element())) / local.unit;
    let [least, largest] = BOUNCE_PARTS.map(|part| part * size);
    (BOUNCE_FACTOR * radius).clamp(least, largest).max(radius)
}

/// The radius of gathering in local units.
fn gather_radius(radius: f64, unit: f64) -> Result<f64> {
    // Float32 holds its square and that of its inverse, though it shrinks to a hundred-thousandth in 2^32 passes.
    const LARGEST: f64 = 1e13;
    const SMALLEST: f64 = 1e-13;
    let local = radius / unit;
    if (SMALLEST..=LARGEST).contains(&local) {
        return Ok(local);
    }
    Err(Error::Input(format!(
        "`method.radius` = {radius:e} is out of range: it must be from {:.0e} to {:.0e} in this scene, {SMALLEST:e} to \
         {LARGEST:e} times how far mirrors and glass extend (with a volume, its voxels' spacing)",
        SMALLEST * unit,
        LARGEST * unit
    )))
}

/// A buffer is not empty.
fn lights_buffer(lights: &[DeviceLight]) -> HostBuffer {
    let none = [DeviceLight::zeroed()];
    HostBuffer::new("lights", if lights.is_empty() { &none } else { lights })
}

/// All lights, rectangles first.
fn device_lights(lights: &[Light], local: &LocalFrame, frame: &mut DeviceFrame) -> Vec<DeviceLight> {
    let (rectangles, others): (Vec<_>, Vec<_>) =
        lights.iter().partition(|light| matches!(light, Light::Rectangle { .. }));
    frame.rectangle_count = rectangles.len() as u32;
    frame.light_count = lights.len() as u32;
    rectangles.into_iter().chain(others).map(|light| DeviceLight::new(light, local)).collect()
}

/// Factor of what is gathered: 1, or what makes photons that are all alike bring the paper's intensity each.
fn photon_scale(emitters: &[Emitter], paper_intensity: Option<f64>) -> f32 {
    let photons: f64 = emitters.iter().map(|emitter| f64::from(emitter.count)).sum();
    let mean_channel =
        |emitter: &Emitter| emitter.power[..3].iter().map(|&c| f64::from(c)).sum::<f64>() / 3.0;
    let flux: f64 = emitters.iter().map(|emitter| f64::from(emitter.count) * mean_channel(emitter)).sum();
    match paper_intensity {
        _ if photons == 0.0 => 0.0,
        Some(intensity) => (intensity * photons / flux) as f32,
        None => 1.0,
    }
}

/// Whether there is anything that photons would bring.
fn photons_wanted(scene: &Scene, settings: &Caustics, surfaces: &SurfaceArrays) -> bool {
    let any = |specular: bool| {
        surfaces.materials_of.iter().any(|&of| scene.materials[of as usize].is_specular() == specular)
    };
    let (receives, turns) = (any(false) || scene.volume.is_some(), any(true));
    let sends = turns
        || settings.direct == CausticsDirect::Photons
        || settings.bounces > 0 && diffuse_light_returns(surfaces);
    settings.photons > 0 && receives && sends && !scene.lights.is_empty()
}
