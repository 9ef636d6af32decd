//! Photons on a few surfaces, maps of them, and what is gathered there.
//!
//! Each test file uses a part of this.
#![allow(dead_code)]

use glam::{DVec3, dvec3};
use svetlo::caustics::{MapFacts, MapSettings, Photon, PhotonMap, Receiver};
use svetlo::device::{Buffer, Device, Program, ProgramSpec};
use svetlo::reference::photons::StoredPhoton;

const PROBE: &str = "
__kernel void probe_irradiance(PHOTON_MAP_ARGUMENTS(map), __global const float4 *points, __global const float4 *normals,
    __global float4 *out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    struct PhotonMap map = PHOTON_MAP(map);
    uint looked_at = 0;
    float3 found = gathered_irradiance(&map, points[i].xyz, normals[i].xyz,
        as_uint(points[i].w), normals[i].w != 0.0f, &looked_at);
    out[i] = (float4)(found, (float)looked_at);
}
#ifndef MAP_PLANAR
__kernel void probe_density(PHOTON_MAP_ARGUMENTS(map), __global const float4 *points, __global const float4 *normals,
    __global float4 *out, uint count) {
    uint i = (uint)get_global_id(0);
    if (i >= count) return;
    struct PhotonMap map = PHOTON_MAP(map);
    uint looked_at = 0;
    float3 found = photon_density(&map, points[i].xyz, &looked_at);
    out[i] = (float4)(found, (float)looked_at);
}
#endif
";

/// A point of a surface and the normal on the side that is looked at.
#[derive(Clone, Copy, Debug)]
pub struct Query {
    pub point: [f32; 3],
    pub normal: [f32; 3],
    pub surface: u32,
    pub inside: bool,
}

impl Query {
    pub fn new(point: DVec3, normal: DVec3, surface: u32) -> Self {
        Self {
            point: point.as_vec3().to_array(),
            normal: normal.as_vec3().to_array(),
            surface,
            inside: false,
        }
    }

    /// On the other side, which is not the outward one.
    pub fn behind(self) -> Self {
        Self { normal: self.normal.map(|x| -x), inside: !self.inside, ..self }
    }
}

/// What was gathered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    pub sums: [f32; 3],
    pub looked_at: f32,
}

/// Surfaces and a device to gather on.
pub struct Gathering {
    pub device: Device,
    pub receivers: Vec<Receiver>,
}

impl Gathering {
    pub fn new(receivers: Vec<Receiver>) -> Self {
        Self { device: crate::common::device(), receivers }
    }

    pub fn map(&self, settings: MapSettings, photons: &[Photon], radius: f32) -> (PhotonMap, MapFacts) {
        let mut map = PhotonMap::new(&self.device, settings, &self.receivers, photons.len()).unwrap();
        let slots = Buffer::from_slice(&self.device, photons).unwrap();
        let facts = map.build(&self.device, &slots, 0..photons.len(), radius).unwrap();
        (map, facts)
    }

    /// Irradiance at points.
    pub fn irradiance(
        &self,
        settings: MapSettings,
        photons: &[Photon],
        radius: f32,
        at: &[Query],
    ) -> Vec<Found> {
        self.gather("probe_irradiance", &self.map(settings, photons, radius).0, at)
    }

    /// Density at points, where all photons are in the medium.
    pub fn density(
        &self,
        settings: MapSettings,
        photons: &[Photon],
        radius: f32,
        at: &[Query],
    ) -> Vec<Found> {
        let mark = |photon: &Photon| match *photon {
            Photon { position, flux: [r, g, b, surface] } if surface.to_bits() != 0 => {
                Photon { position, flux: [r, g, b, f32::from_bits(Photon::IN_MEDIUM)] }
            }
            none => none,
        };
        let photons: Vec<Photon> = photons.iter().map(mark).collect();
        self.gather("probe_density", &self.map(settings, &photons, radius).0, at)
    }

    pub fn gather(&self, kernel: &'static str, map: &PhotonMap, at: &[Query]) -> Vec<Found> {
        let device = &self.device;
        let spec = map.settings().define(ProgramSpec::new("caustics/gather.cl"), device.info());
        let program = Program::build_probe(device, &spec, PROBE).unwrap();
        let points: Vec<[f32; 4]> =
            at.iter().map(|q| [q.point[0], q.point[1], q.point[2], f32::from_bits(q.surface)]).collect();
        let normals: Vec<[f32; 4]> =
            at.iter().map(|q| [q.normal[0], q.normal[1], q.normal[2], f32::from(q.inside)]).collect();
        let [points, normals] = [points, normals].map(|values| Buffer::from_slice(device, &values).unwrap());
        let out = Buffer::<[f32; 4]>::zeroed(device, at.len()).unwrap();
        let rest = [(&points).into(), (&normals).into(), (&out).into(), (at.len() as u32).into()];
        let arguments: Vec<_> = map.arguments().into_iter().chain(rest).collect();
        program.kernel(device, kernel).unwrap().run(device, &arguments, at.len()).unwrap();
        let found = out.read(device).unwrap().into_iter();
        found.map(|[r, g, b, looked_at]| Found { sums: [r, g, b], looked_at }).collect()
    }
}

/// A direction unfolded onto the square [-1, 1]², as `cl/common/octahedron.cl` does it.
fn unfolded(direction: DVec3) -> [f64; 2] {
    let p = direction / (direction.x.abs() + direction.y.abs() + direction.z.abs());
    let signed = |x: f64| if x < 0.0 { -1.0 } else { 1.0 };
    let folded = [(1.0 - p.y.abs()) * signed(p.x), (1.0 - p.x.abs()) * signed(p.y)];
    if p.z < 0.0 { folded } else { [p.x, p.y] }
}

/// A direction in 32 bits.
pub fn pack(direction: DVec3) -> u32 {
    let [x, y] = unfolded(direction).map(|x| ((32767.0 * x).round() + 32768.0) as u32);
    x | y << 16
}

/// A mark, as `mark_of` of `cl/caustics/marks.cl`.
pub fn mark(surface: u32, inside: bool, facing: DVec3) -> u32 {
    let [x, y] = unfolded(facing).map(|x| ((31.0 * x).round() + 32.0) as u32);
    (x | y << 6) << 19 | u32::from(inside) << 18 | (surface + 1)
}

/// A photon in a slot, that came from outside onto a surface with this normal.
pub fn photon(position: DVec3, normal: DVec3, flux: [f64; 3], surface: u32) -> Photon {
    sided(position, normal, false, flux, surface)
}

/// The same from either side, where the normal is `facing`.
pub fn sided(position: DVec3, facing: DVec3, inside: bool, flux: [f64; 3], surface: u32) -> Photon {
    let [x, y, z] = position.as_vec3().to_array();
    let [r, g, b] = flux.map(|flux| flux as f32);
    Photon {
        position: [x, y, z, f32::from_bits(pack(-facing))],
        flux: [r, g, b, f32::from_bits(mark(surface, inside, facing))],
    }
}

/// A slot that holds nothing; its numbers must not matter.
pub fn empty() -> Photon {
    Photon { position: [f32::NAN, 1e30, 0.0, 0.0], flux: [f32::NAN, 1.0, 1.0, 0.0] }
}

/// The photon of a slot, for the twin, where the normal is `facing` on the side that it came from.
pub fn stored(slot: &Photon, facing: DVec3) -> StoredPhoton {
    let [x, y, z, _] = slot.position.map(f64::from);
    let [r, g, b, _] = slot.flux.map(f64::from);
    let (surface, inside) = (slot.surface(), slot.is_inside());
    StoredPhoton { position: dvec3(x, y, z), facing, inside, flux: [r, g, b], surface }
}
