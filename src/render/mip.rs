//! Maximum intensity projection: the kernel is `cl/render/mip.cl`.

use super::method::{HostBuffer, MethodInput, MethodSetup};
use crate::device::ProgramSpec;
use crate::device_struct;
use crate::scene::MipColor;
use crate::transfer::map_color;

/// Entries of the colour map on the device.
const COLORMAP_SIZE: usize = 1024;

device_struct! {
    "types/method.cl",
    /// Parameters of maximum intensity projection.
    pub struct Mip {
        /// Factor of the displayed value.
        pub color: [f32; 4],
        /// Entries of the colour map; 0 is grey.
        pub table_size: u32,
        /// Padding.
        pub pad_0: u32,
        /// Padding.
        pub pad_1: u32,
        /// Padding.
        pub pad_2: u32,
    }
}

/// Makes the method ready.
pub fn prepare(input: &MethodInput<'_>, color: &MipColor) -> MethodSetup {
    // Where the file's slope is negative, the kernel works on negated stored values.
    let turned = input.grid.device_window().one < input.grid.device_window().zero;
    let upper = |&[low, high]: &[f32; 2]| if turned { -low } else { high };
    let upper: Vec<f32> = input.bricks.ranges.iter().map(upper).collect();
    let (factor, colormap) = match color {
        MipColor::Scaled(color) => (*color, vec![[0.0_f32; 4]]),
        MipColor::Map(map) => {
            let entry = |k: usize| {
                let [r, g, b] = map_color(*map, k as f64 / (COLORMAP_SIZE - 1) as f64);
                [r as f32, g as f32, b as f32, 1.0]
            };
            ([1.0; 3], (0..COLORMAP_SIZE).map(entry).collect())
        }
    };
    let parameters = Mip {
        color: [factor[0] as f32, factor[1] as f32, factor[2] as f32, 1.0],
        table_size: if matches!(color, MipColor::Map(_)) { COLORMAP_SIZE as u32 } else { 0 },
        pad_0: 0,
        pad_1: 0,
        pad_2: 0,
    };
    MethodSetup {
        spec: ProgramSpec::new("render/mip.cl"),
        kernel: "render_mip",
        parameters: HostBuffer::new("method parameters", &[parameters]),
        tables: vec![HostBuffer::new("brick maxima", &upper), HostBuffer::new("colour map", &colormap)],
        value_units: 1.0,
        random: false,
        lanes: false,
        paths: false,
        has_depth: true,
        notes: Vec::new(),
        details: Vec::new(),
        light: None,
        caustics: None,
    }
}
