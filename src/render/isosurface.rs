//! Isosurface: the kernel is `cl/render/isosurface.cl`.

use super::grid::BrickRanges;
use super::lights::DeviceLight;
use super::local::float4;
use super::method::{DeviceFrame, HostBuffer, MethodInput, MethodSetup};
use crate::device::ProgramSpec;
use crate::device_struct;
use crate::scene::{Domain, Material};
use glam::DVec3;

device_struct! {
    "types/method.cl",
    /// Parameters of the isosurface.
    pub struct Isosurface {
        /// Colour of the surface.
        pub albedo: [f32; 4],
        /// Value of the surface on the device.
        pub iso: f32,
        /// Factor of the constant term.
        pub ambient: f32,
        /// Factor of the Lambertian term.
        pub diffuse: f32,
        /// Factor of the Blinn-Phong term.
        pub specular: f32,
        /// Exponent of the Blinn-Phong term.
        pub shininess: f32,
        /// Padding.
        pub pad_0: u32,
        /// Padding.
        pub pad_1: u32,
        /// Padding.
        pub pad_2: u32,
    }
}

/// Makes the method ready for the surface `value` (in `domain`).
pub fn prepare(
    input: &MethodInput<'_>,
    value: f64,
    domain: Domain,
    material: &Material,
    frame: &mut DeviceFrame,
) -> MethodSetup {
    let (lo, hi) = input.window;
    let value = match domain {
        Domain::Normalized => value,
        Domain::Data => (value - lo) / (hi - lo),
    };
    let iso = input.grid.device_window().stored(value) as f32;
    let mut notes = Vec::new();
    let mut lights: Vec<DeviceLight> =
        input.scene.lights.iter().map(|light| DeviceLight::new(light, input.local)).collect();
    if lights.is_empty() {
        notes.push("no [[light]]: a headlight shines along each view ray (irradiance pi)".into());
        lights.push(DeviceLight::headlight(std::f32::consts::PI));
    }
    frame.light_count = lights.len() as u32;
    let crossed = input.bricks.ranges.iter().filter(|[low, high]| *low < iso && iso <= *high).count();
    let details = vec![format!("{crossed} of {} bricks contain the surface", input.bricks.ranges.len())];
    if crossed == 0 {
        notes.push(format!(
            "the value {value:.6} (window units) is reached nowhere: the picture is the background"
        ));
    }
    let parameters = Isosurface {
        albedo: float4(DVec3::from_array(material.color), 1.0),
        iso,
        ambient: material.ambient as f32,
        diffuse: material.diffuse as f32,
        specular: material.specular as f32,
        shininess: material.shininess as f32,
        pad_0: 0,
        pad_1: 0,
        pad_2: 0,
    };
    MethodSetup {
        spec: ProgramSpec::new("render/isosurface.cl"),
        kernel: "render_isosurface",
        parameters: HostBuffer::new("method parameters", &[parameters]),
        tables: vec![
            HostBuffer { name: "brick strides", bytes: strides(input.bricks, iso) },
            HostBuffer::new("lights", &lights),
        ],
        value_units: 1.0,
        random: false,
        lanes: false,
        paths: false,
        has_depth: true,
        notes,
        details,
        light: None,
        caustics: None,
    }
}

/// Per octant and brick: 0 where the surface is, else the stride over free bricks, with the top bit set inside.
fn strides(bricks: &BrickRanges, iso: f32) -> Vec<u8> {
    const INSIDE: u8 = 0x80;
    let mut strides = bricks.strides(INSIDE - 1, |[low, high]| *low < iso && iso <= *high);
    for (stride, [low, _]) in strides.iter_mut().zip(bricks.ranges.iter().cycle()) {
        if *stride > 0 && *low >= iso {
            *stride |= INSIDE;
        }
    }
    strides
}
