//! What direct light asks for, and the numbers that its kernels read.

use super::LitMedium;
use crate::device::Device;
use crate::render::method::DeviceFrame;
use crate::render::scattering::Scattering;
use crate::scene::Phase;
use crate::{Result, device_struct};

device_struct! {
    "types/irradiance.cl",
    /// How the direct light of cells is computed; see `cl/types/irradiance.cl`.
    pub struct DirectParameters {
        /// Relative extinction that is known without look-ups, of the reduced light, per channel.
        pub control: [f32; 4],
        /// Mean cosine of the phase function.
        pub mean_cosine: f32,
        /// Rate of tentative collisions per majorant.
        pub over: f32,
        /// ... less this per minorant.
        pub under: f32,
        /// log2 of the cells along x of a block.
        pub block_x: u32,
        /// ... along y.
        pub block_y: u32,
        /// ... along z.
        pub block_z: u32,
        /// Padding.
        pub pad_0: u32,
        /// Padding.
        pub pad_1: u32,
    }
}

/// log2 of the cells of a block: the unit of a launch, and a work-item's share on CPUs. Mirrors `BLOCK_SHIFT` in
/// `cl/irradiance/direct.cl`.
pub(super) const BLOCK_SHIFT: u32 = 8;

/// What a phase function and a scene's lights ask for.
#[derive(Clone, Copy)]
pub(super) struct Wanted {
    /// A mean cosine other than 0 does.
    pub reduced: bool,
    /// Any phase function but the isotropic one does.
    pub flow: bool,
    /// There are lights to choose from.
    pub lights: bool,
    /// The background lights and is not among them.
    pub sky: bool,
    /// Every pass is the same.
    pub exact: bool,
}

impl Wanted {
    pub fn new(device: &Device, medium: &LitMedium, phase: &Phase) -> Result<Self> {
        let frame: DeviceFrame = first(&medium.frame.read(device)?);
        let lights = medium.has("SAMPLE_LIGHTS");
        let black = frame.background[..3].iter().all(|&radiance| radiance == 0.0);
        let sky = !black && frame.environment_pick == 0.0;
        // Passes differ by what they look up, by the light or its point that they choose, and by their directions.
        let single = frame.light_count == 1 && frame.rectangle_count == 0 && frame.environment_pick == 0.0;
        let method: Scattering = first(&medium.method.read(device)?);
        let flow = !phase.is_isotropic();
        let alike = method.sigma == 0.0 && frame.environment_width == 0 && !flow;
        let exact = medium.has("CONSTANT_SIGMA") && (!lights || single) && (!sky || alike);
        Ok(Self { reduced: phase.mean_cosine() != 0.0, flow, lights, sky, exact: exact || !lights && !sky })
    }
}

fn first<T: bytemuck::AnyBitPattern>(bytes: &[u8]) -> T {
    bytemuck::pod_read_unaligned(&bytes[..size_of::<T>()])
}

/// log2 of the cells per axis of a block: as near a cube as the grid allows, and no longer than it where another axis
/// has room.
pub(super) fn block_shifts(dims: [usize; 3]) -> [u32; 3] {
    let mut shifts = [0; 3];
    for _ in 0..BLOCK_SHIFT {
        let open = (0..3).filter(|&axis| 1 << shifts[axis] < dims[axis]);
        let axis = open.min_by_key(|&axis| shifts[axis]).unwrap_or(0);
        shifts[axis] += 1;
    }
    shifts
}

/// The smallest and the largest albedo of a medium per channel.
fn albedos(device: &Device, medium: &LitMedium, method: &Scattering) -> Result<[[f64; 2]; 3]> {
    if medium.has("CONSTANT_ALBEDO") {
        return Ok(std::array::from_fn(|c| [f64::from(method.albedo[c]); 2]));
    }
    let mut ranges = [[1.0_f64, 0.0]; 3];
    for entry in bytemuck::pod_collect_to_vec::<u8, [f32; 4]>(&medium.tables[2].read(device)?) {
        for (range, albedo) in ranges.iter_mut().zip(entry) {
            *range = [range[0].min(albedo.into()), range[1].max(albedo.into())];
        }
    }
    Ok(ranges)
}

/// The numbers of a grid in this medium, in blocks of this shape.
pub(super) fn parameters(
    device: &Device,
    medium: &LitMedium,
    phase: &Phase,
    shifts: [u32; 3],
) -> Result<DirectParameters> {
    let method: Scattering = first(&medium.method.read(device)?);
    let g = phase.mean_cosine();
    // With extinction s between the minorant m and the majorant M, and 1 - g albedo between k and K, the rate over M -
    // under m must be at least s - m, for the light itself, and s K - k m, for the reduced light.
    let ranges = albedos(device, medium, &method)?.map(|range| {
        let [a, b] = range.map(|albedo| 1.0 - g * albedo);
        [a.min(b), a.max(b)]
    });
    let over = ranges.iter().fold(1.0, |most, range| f64::max(most, range[1]));
    let under = ranges.iter().fold(over, |least, range| f64::min(least, range[0] + over - range[1]));
    let scale = f64::from(method.majorant_scale);
    let [red, green, blue] = ranges.map(|range| range[0] as f32);
    Ok(DirectParameters {
        control: [red, green, blue, 0.0],
        mean_cosine: g as f32,
        over: (scale * over) as f32,
        under: (scale * under) as f32,
        block_x: shifts[0],
        block_y: shifts[1],
        block_z: shifts[2],
        pad_0: 0,
        pad_1: 0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_fit_their_grids() {
        assert_eq!(block_shifts([64, 64, 64]), [3, 3, 2]);
        assert_eq!(block_shifts([64, 64, 1]), [4, 4, 0]);
        assert_eq!(block_shifts([300, 1, 3]), [6, 0, 2]);
        assert_eq!(block_shifts([1, 1, 1]), [8, 0, 0]);
    }
}
