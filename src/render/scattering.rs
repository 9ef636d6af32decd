//! Single and multiple scattering: the kernel is `cl/render/scattering.cl`.

use super::lights::Lights;
use super::majorants::Majorants;
use super::medium::MediumTable;
use super::method::{DeviceFrame, HostBuffer, MethodInput, MethodSetup};
use super::silhouette::tiles_that_see;
use super::tiles::TILE;
use crate::device::ProgramSpec;
use crate::scene::{Background, Light, Orders, Phase, Scattering as Settings, Transfer, Transmittance};
use crate::transfer::{TransferFunction1d, TransferFunction2d};
use crate::{Error, Result, device_struct};
use glam::DVec3;

device_struct! {
    "types/path.cl",
    /// Parameters of the scattering methods; see `cl/types/path.cl`.
    pub struct Scattering {
        /// Low corner of what can hold extinction, grid coordinates.
        pub low: [f32; 4],
        /// Its high corner.
        pub high: [f32; 4],
        /// Radiance that light is counted from.
        pub control: [f32; 4],
        /// Constant single-scattering albedo.
        pub albedo: [f32; 4],
        /// Mean cosines of the phase function's lobes and the share of the first.
        pub phase: [f32; 4],
        /// Extinction per channel relative to sigma_t, the largest 1.
        pub extinction: [f32; 4],
        /// Factor of the majorants.
        pub majorant_scale: f32,
        /// Transmittance of a camera ray above which tentative collisions take parts of it, below all or nothing.
        pub camera_threshold: f32,
        /// The same for shadow rays.
        pub shadow_threshold: f32,
        /// The same for rays between collisions.
        pub flight_threshold: f32,
        /// A path goes on from a camera ray with this times the probability of a collision.
        pub split: f32,
        /// Constant extinction per local unit.
        pub sigma: f32,
        /// Extinction is offset + slope · value.
        pub ramp_offset: f32,
        /// The slope, per entry of the table.
        pub ramp_slope: f32,
        /// Throughput below which paths play Russian roulette.
        pub roulette_start: f32,
        /// The largest number of scatterings, 2^31 − 1 for no limit.
        pub max_order: i32,
        /// Paths per sample and pixel.
        pub paths: u32,
        /// Mean extinction of the box per local unit, roughly.
        pub mean_sigma: f32,
        /// Flights from each collision.
        pub flights: i32,
        /// Padding.
        pub pad_0: u32,
        /// Padding.
        pub pad_1: u32,
        /// Padding.
        pub pad_2: u32,
    }
}

/// What `check` says of a medium without scattering and emission.
const ABSORBER: &str = "the medium only absorbs: the method emission-absorption with black colours makes the same \
    picture without noise";

/// Below this transmittance rays that take parts switch to all or nothing, by measurement on the cloud.
const SWITCH: f32 = 0.1;

/// The same for shadow rays. Measured on the cloud: a tenth of the look-ups less than with [`SWITCH`], for as little noise.
const SHADOW_SWITCH: f32 = 0.3;

/// Rays of this threshold look for all or nothing: 1 would not do, as rounding lifts what is left above it.
const ANALOG: f32 = 2.0;

/// Makes the method ready.
///
/// # Errors
/// [`crate::Error::Input`] when a 2-D table cannot be read.
pub fn prepare(input: &MethodInput<'_>, settings: Settings, frame: &mut DeviceFrame) -> Result<MethodSetup> {
    let scene = input.scene;
    let table = MediumTable::new(&scene.transfer, &scene.medium, input.window, input.local.unit)?;
    let two_d = matches!(scene.transfer, Transfer::TwoD(_));
    frame.table_size = table.size as u32;
    frame.table_rows = table.rows as u32;
    frame.gradient_scale = table.gradient_scale;
    let gradients = two_d.then(|| input.grid.brick_gradients(input.bricks));
    let majorants = Majorants::new(input.grid, input.bricks, gradients.as_deref(), &table);
    check_extinction(&majorants, scene.scattering.extinction_color, input)?;
    let coarse = coarse(&majorants, scene.scattering.extinction_color, input).into_iter().collect();
    let lights = Lights::new(&scene.lights, &scene.background, input.environment, input.local);
    lights.describe(frame);

    let albedo = scene.scattering.albedo;
    let chromatic = scene.scattering.extinction_color;
    let largest = chromatic.map_or(1.0, |color| color.into_iter().fold(0.0, f64::max));
    let extinction = chromatic.unwrap_or([1.0; 3]).map(|e| e / largest);
    let emission = emission(&scene.transfer, input.window)?;
    let constant_albedo = majorants.constant_color.or((majorants.largest == 0.0).then_some([0.0; 3]));
    // Where only the extinction is the same everywhere, collisions still look colours up by their values.
    let constant_sigma = majorants.constant.is_some() && constant_albedo.is_some() && emission.is_none();
    let estimates =
        matches!(settings.transmittance, Transmittance::ResidualRatio | Transmittance::RayMarching);
    // Estimates that know the bounds of a constant medium know all.
    let auto = settings.transmittance == Transmittance::Auto && settings.majorant_scale == 1.0;
    let closed_form = constant_sigma && (auto || estimates);
    let estimated = |by: Transmittance| settings.transmittance == by && !constant_sigma;
    let (max_order, single) = match settings.orders {
        Orders::Single => (1, true),
        Orders::Multiple { max } => {
            (max.map_or(i32::MAX, |max| i32::try_from(max).unwrap_or(i32::MAX)), false)
        }
    };
    let ramp = (!two_d && !constant_sigma).then(|| table.linear_ramp()).flatten();
    let grey = is_grey(input, &table, emission.as_deref(), chromatic);
    let thresholds = thresholds(settings.transmittance, single, closed_form);
    let [low, high] = occupied(input, &majorants);
    let float4 = |[x, y, z]: [f64; 3], w: f64| [x, y, z, w].map(|v| v as f32);
    let occupied_sigma = majorants.statistics.sigma / (1.0 - majorants.statistics.empty).max(1e-3);
    let parameters = Scattering {
        low,
        high,
        control: if estimates && !constant_sigma { [0.0; 4] } else { control(input, &lights) },
        albedo: float4(std::array::from_fn(|c| albedo[c] * constant_albedo.unwrap_or([1.0; 3])[c]), 0.0),
        phase: phase_parameters(scene.phase),
        extinction: float4(extinction, 0.0),
        majorant_scale: settings.majorant_scale as f32,
        camera_threshold: thresholds[0],
        shadow_threshold: thresholds[1],
        flight_threshold: thresholds[2],
        split: SPLIT,
        sigma: (majorants.constant.unwrap_or(0.0) * largest) as f32,
        ramp_offset: (ramp.map_or(0.0, |(offset, _)| offset) * largest) as f32,
        ramp_slope: (ramp.map_or(0.0, |(_, slope)| slope) * largest) as f32,
        roulette_start: ROULETTE_START,
        max_order,
        paths: settings.paths.unwrap_or(DEFAULT_PATHS),
        mean_sigma: (occupied_sigma * largest) as f32,
        flights: flights(input, &lights, single, emission.is_some()),
        pad_0: 0,
        pad_1: 0,
        pad_2: 0,
    };
    let spec = ProgramSpec::new("render/scattering.cl")
        .define(phase_define(scene.phase), "1")
        .feature("TF_2D", two_d)
        .feature("CONSTANT_SIGMA", constant_sigma)
        .feature("CLOSED_FORM", closed_form)
        .feature("TRANSMITTANCE_RESIDUAL", estimated(Transmittance::ResidualRatio))
        .feature("TRANSMITTANCE_MARCHING", estimated(Transmittance::RayMarching))
        .feature("SIGMA_RAMP", ramp.is_some())
        .feature("CONSTANT_ALBEDO", constant_albedo.is_some())
        .feature("CHROMATIC", chromatic.is_some())
        .feature("EMISSION", emission.is_some())
        .feature("GREY", grey)
        .feature("SAMPLE_LIGHTS", lights.sampled())
        .feature("EQUIANGULAR", near_points(input))
        .feature("RECTANGLES", lights.has_rectangles())
        .feature("AUXILIARY", scene.film.auxiliary);
    let sigmas: Vec<f32> = table.sigmas().into_iter().map(|sigma| sigma * largest as f32).collect();
    let [light_buffer, sums] = lights.buffers();
    let tiles = tiles(input, &lights, &majorants);
    let cost = cost(&majorants, &settings, closed_form, input.local.unit);
    let looks = (majorants.largest > 0.0 && !closed_form).then(|| estimator(settings.transmittance));
    let absorber = (constant_albedo == Some([0.0; 3]) || albedo == [0.0; 3]) && majorants.largest > 0.0;
    let dark = (absorber && emission.is_none()).then(|| ABSORBER.to_owned());
    let details = [cost].into_iter().chain(looks).chain(dark).chain(lights.details);
    let emission = emission.unwrap_or_else(|| vec![[0.0; 4]]);
    Ok(MethodSetup {
        spec,
        kernel: "render_scattering",
        parameters: HostBuffer::new("method parameters", &[parameters]),
        tables: vec![
            HostBuffer::new("majorants", &majorants.scaled(largest, largest)),
            HostBuffer::new("extinction table", &sigmas),
            HostBuffer { name: "albedo table", bytes: table.device_colors(albedo) },
            HostBuffer::new("emission table", &emission),
            light_buffer,
            sums,
            HostBuffer::new("tiles that see the medium", &tiles),
        ],
        value_units: table.intervals(),
        random: true,
        lanes: false,
        paths: true,
        has_depth: false,
        notes: coarse,
        details: details.collect(),
        light: None,
        caustics: None,
    })
}

/// Mean free paths across the box that float32 coordinates resolve well: with many more, steps between collisions round to
/// nothing, and a path that nothing absorbs never ends.
const MOST_FREE_PATHS: f64 = 1e7;

fn check_extinction(majorants: &Majorants, color: Option<[f64; 3]>, input: &MethodInput<'_>) -> Result<()> {
    let largest = color.map_or(1.0, |color| color.into_iter().fold(0.0, f64::max));
    // Paths leave across the shortest side.
    let across = f64::from(majorants.largest) * largest * input.local.size().min_element();
    if across <= MOST_FREE_PATHS {
        return Ok(());
    }
    Err(Error::Input(format!(
        "the extinction is too large to follow paths: {:.3e} per scene unit, {across:.1e} mean free paths across the box, \
         of which {MOST_FREE_PATHS:.0e} can be told apart; lower `medium.sigma_max` (nothing shines through from some \
         hundred on)",
        f64::from(majorants.largest) * largest / input.local.unit
    )))
}

/// What is said of media in which a rounding of coordinates is more than this part of a free path.
const COARSE: f64 = 1e-2;
/// The distance between neighbouring float32 numbers from 1 to 2.
const ULP: f64 = 1.0 / (1 << 23) as f64;
/// Where the low corner of the box is in grid coordinates (`occupied`).
const GRID_LOW: f64 = 1.5;

/// Collisions within half a rounding of a face count as on it, and so on below it.
fn coarse(majorants: &Majorants, color: Option<[f64; 3]>, input: &MethodInput<'_>) -> Option<String> {
    let largest = color.map_or(1.0, |color| color.into_iter().fold(0.0, f64::max));
    let size = input.local.size().to_array();
    // Paths leave across the shortest side.
    let shortest = (0..3).min_by(|&a, &b| size[a].total_cmp(&size[b]))?;
    let voxels = input.local.dims[shortest] as f64;
    let rounding = ULP * (voxels + GRID_LOW).log2().floor().exp2() * size[shortest] / voxels;
    let share = f64::from(majorants.largest) * largest * rounding;
    (share > COARSE).then(|| {
        format!(
            "coordinates round to {:.1} % of a free path: light that comes back from near the faces may be off by some \
             of that; lower `medium.sigma_max` (nothing shines through from some hundred free paths on)",
            100.0 * share
        )
    })
}

/// What tracking costs in this medium. `unit`: scene units per local unit.
fn cost(majorants: &Majorants, settings: &Settings, closed_form: bool, unit: f64) -> String {
    let statistics = &majorants.statistics;
    let mean = (statistics.sigma / unit) as f32;
    if majorants.largest == 0.0 {
        return "nothing has extinction: rays pass".into();
    }
    if closed_form {
        return format!("the extinction is {mean} per scene unit everywhere: rays take no look-ups");
    }
    let empty = match statistics.empty {
        0.0 => "no brick is empty".into(),
        share => format!("{:.1} % of the box is in empty bricks", share * 100.0),
    };
    let lookups = statistics.lookups() * settings.majorant_scale;
    if lookups.is_finite() {
        format!(
            "{empty}; mean extinction {mean} per scene unit; {lookups:.2} look-ups per unit of optical depth"
        )
    } else {
        format!("{empty}; the others hold next to no extinction")
    }
}

/// How rays lose light where they look the medium up.
fn estimator(transmittance: Transmittance) -> String {
    match transmittance {
        Transmittance::Auto => format!(
            "transmittance auto: rays lose a part of their light at each look-up, which is smooth, and from {:.0} % on \
             all or nothing ({:.0} % of shadow rays), which ends them soon: of all estimators the least error for its \
             time, on smooth and steep media, thin and thick",
            SWITCH * 100.0,
            SHADOW_SWITCH * 100.0
        ),
        Transmittance::Analog => "transmittance analog: all or nothing at each look-up".into(),
        Transmittance::Ratio => "transmittance ratio: rays lose a part of their light at each look-up".into(),
        Transmittance::ResidualRatio => {
            "transmittance residual-ratio: the mean of a brick's bounds in closed form, the rest by look-ups"
                .into()
        }
        Transmittance::RayMarching => {
            "transmittance ray-marching: evenly spaced look-ups, and a power series of their differences: the least \
             noise where a smooth medium only absorbs, by far the most where extinction rises steeply"
                .into()
        }
    }
}

/// Paths per sample: on the cloud, 8 stratified paths have 7 % less noise than two times 4, and more gain little.
const DEFAULT_PATHS: u32 = 8;

/// Camera rays that lose a part of their light scatter with this times that probability: thin parts are cheap then, and
/// on the cloud more brings no less noise.
const SPLIT: f32 = 2.0;

/// Flights from each collision of single scattering: they are what brings the background's light, and cost less than
/// the way to the collision. Measured on the cloud: 4 are 1.6 times as efficient as 1; 3 and 6 come near.
const FLIGHTS: i32 = 4;

/// Paths end at random from this throughput on.
const ROULETTE_START: f32 = 0.3;

/// Whether a point light lies in the volume's box, or nearer to it than a sixteenth of its diagonal: farther away,
/// places along rays at equal angles cost more than they save, by measurement.
fn near_points(input: &MethodInput<'_>) -> bool {
    let size = input.local.size();
    let near = |light: &Light| match light {
        Light::Point { position, intensity } if intensity.iter().any(|&i| i > 0.0) => {
            let point = input.local.point(*position);
            point.distance(point.clamp(DVec3::ZERO, size)) < size.length() / 16.0
        }
        _ => false,
    };
    input.scene.lights.iter().any(near)
}

pub(super) fn phase_parameters(phase: Phase) -> [f32; 4] {
    match phase {
        Phase::Isotropic | Phase::Rayleigh => [0.0; 4],
        Phase::HenyeyGreenstein { g } => [g as f32, 0.0, 1.0, 0.0],
        Phase::TwoLobe { g, weight } => [g[0] as f32, g[1] as f32, weight as f32, 0.0],
    }
}

pub(super) fn phase_define(phase: Phase) -> &'static str {
    match phase {
        Phase::Isotropic => "PHASE_ISOTROPIC",
        Phase::HenyeyGreenstein { .. } => "PHASE_HG",
        Phase::Rayleigh => "PHASE_RAYLEIGH",
        Phase::TwoLobe { .. } => "PHASE_TWO_LOBE",
    }
}

/// Above which transmittance camera rays, shadow rays and flights take parts.
fn thresholds(transmittance: Transmittance, single: bool, closed_form: bool) -> [f32; 3] {
    let flight = |threshold: f32| if single { threshold } else { ANALOG };
    match transmittance {
        Transmittance::Analog => [ANALOG; 3],
        Transmittance::Ratio => [0.0, 0.0, flight(0.0)],
        _ if closed_form => [0.0, 0.0, flight(0.0)],
        // The others' estimates are made apart from the collisions.
        _ => [SWITCH, SHADOW_SWITCH, flight(SWITCH)],
    }
}

/// How many flights to send from each collision.
fn flights(input: &MethodInput<'_>, lights: &Lights, single: bool, emission: bool) -> i32 {
    let black = matches!(input.scene.background, Background::Constant(color) if color == [0.0; 3]);
    match (single, black && !lights.has_rectangles() && !emission) {
        (false, _) => 1,
        (true, true) => 0,
        // A sampled map is seen by shadow rays, too.
        (true, false) => {
            if lights.environment_pick > 0.0 {
                1
            } else {
                FLIGHTS
            }
        }
    }
}

/// The radiance that light is counted from: what the medium is bathed in on average. A sampled map is not: its samples
/// follow its brightness, and a difference does not.
fn control(input: &MethodInput<'_>, lights: &Lights) -> [f32; 4] {
    let [r, g, b] = match (&input.scene.background, input.environment) {
        (Background::Constant(color), _) => *color,
        (Background::Environment { intensity, .. }, Some(map)) if lights.environment_pick == 0.0 => {
            map.mean_radiance().map(|mean| intensity * mean)
        }
        _ => [0.0; 3],
    };
    [r as f32, g as f32, b as f32, 0.0]
}

/// 1 for every tile of the image whose camera rays may meet anything but a constant background, else 0.
fn tiles(input: &MethodInput<'_>, lights: &Lights, majorants: &Majorants) -> Vec<u8> {
    let image = &input.scene.image;
    let plain = matches!(input.scene.background, Background::Constant(_)) && !lights.has_rectangles();
    if !plain {
        return vec![1; (image.width.div_ceil(TILE) * image.height.div_ceil(TILE)) as usize];
    }
    tiles_that_see(&input.scene.camera, image, input.local, &majorants.boxes(input.bricks, input.local))
}

/// The box of what can hold extinction, in grid coordinates; empty without any.
fn occupied(input: &MethodInput<'_>, majorants: &Majorants) -> [[f32; 4]; 2] {
    let dims = input.local.dims;
    let Some((low, high)) = majorants.occupied else { return [[1.0; 4], [0.0; 4]] };
    // The volume's box ends half a voxel beyond the outermost voxels.
    let (first, pad) = (1.5_f32, 1.5_f32);
    let corner =
        |plane: [i32; 3]| {
            std::array::from_fn(|a| {
                if a == 3 { 0.0 } else { (plane[a] as f32).clamp(first, dims[a] as f32 + pad) }
            })
        };
    [corner(low), corner(high)]
}

/// The emitted radiance of every entry of the table; `None` where nothing glows.
pub(crate) fn emission(transfer: &Transfer, window: (f64, f64)) -> Result<Option<Vec<[f32; 4]>>> {
    let emission = match transfer {
        Transfer::OneD(settings) => TransferFunction1d::from_settings(settings, window).emission,
        Transfer::TwoD(settings) => TransferFunction2d::from_settings(settings)?.emission,
    };
    let float4 = |[r, g, b]: [f64; 3]| [r as f32, g as f32, b as f32, 0.0];
    Ok(emission.map(|entries| entries.into_iter().map(float4).collect()))
}

/// Whether nothing in the scene has a colour: then one channel is enough.
fn is_grey(
    input: &MethodInput<'_>,
    table: &MediumTable,
    emission: Option<&[[f32; 4]]>,
    chromatic: Option<[f64; 3]>,
) -> bool {
    let grey = |c: [f64; 3]| c[0] == c[1] && c[1] == c[2];
    let scene = input.scene;
    let lights = scene.lights.iter().all(|light| grey(light.color()));
    let background = matches!(scene.background, Background::Constant(color) if grey(color));
    let glow = emission.is_none_or(|entries| entries.iter().all(|e| e[0] == e[1] && e[1] == e[2]));
    lights && background && glow && chromatic.is_none() && grey(scene.scattering.albedo) && table.is_grey()
}
