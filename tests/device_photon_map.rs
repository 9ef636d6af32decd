//! Maps of photons: all of them find the photons that brute force finds, and both sum what their twin sums.

mod common;
#[path = "common/photon_maps.rs"]
mod photon_maps;

use common::EPS;
use glam::{DVec3, dvec3};
use photon_maps::{Found, Gathering, Query, empty, onto, photon, stored};
use svetlo::caustics::{Acceleration, MapSettings, Photon, PhotonMap, Receiver, Weighting};
use svetlo::device::Buffer;
use svetlo::reference::photons::{
    Place, StoredPhoton, Weight, cone, constant, density, irradiance, smoothstep,
};
use svetlo::sort::{Fill, SortKind};

const WEIGHTINGS: [(Weighting, Weight); 3] =
    [(Weighting::Constant, constant), (Weighting::Cone, cone), (Weighting::Smoothstep, smoothstep)];

fn plain(acceleration: Acceleration, weighting: Weighting) -> MapSettings {
    MapSettings {
        acceleration,
        weighting,
        edge_correction: false,
        table_cells: 1 << 16,
        ..MapSettings::default()
    }
}

/// Every way to find photons but brute force, by name.
fn structures(weighting: Weighting) -> Vec<(&'static str, MapSettings)> {
    let of = |acceleration| plain(acceleration, weighting);
    let bitonic = MapSettings { sort: SortKind::Bitonic, fill: Fill::TwoPass, ..of(Acceleration::Voxels) };
    vec![
        ("lexicographic", of(Acceleration::Lexicographic)),
        ("voxels", of(Acceleration::Voxels)),
        ("voxels, bitonic", bitonic),
        ("voxels, searched", MapSettings { table_cells: 0, ..of(Acceleration::Voxels) }),
        ("planar", of(Acceleration::Planar)),
        ("planar, searched", MapSettings { table_cells: 0, ..of(Acceleration::Planar) }),
    ]
}

/// A floor and a slanted disk above it.
struct Scene {
    gathering: Gathering,
    corner: DVec3,
    disk: DVec3,
    normal: DVec3,
}

impl Scene {
    fn new() -> Self {
        let corner = dvec3(-0.6, -0.4, 0.1);
        let (disk, normal) = (dvec3(0.1, 0.0, 0.3), dvec3(0.48, -0.6, 0.64));
        let floor = Receiver::parallelogram(corner, dvec3(1.2, 0.0, 0.0), dvec3(0.0, 1.0, 0.0));
        Self {
            gathering: Gathering::new(vec![floor, Receiver::disk(disk, normal, 0.5), Receiver::curved()]),
            corner,
            disk,
            normal,
        }
    }

    /// Point and normal of surface 0 or 1.
    fn point(&self, surface: u32, u: f64, v: f64) -> (DVec3, DVec3) {
        if surface == 0 {
            return (self.corner + dvec3(1.2 * u, v, 0.0), DVec3::Z);
        }
        let across = self.normal.any_orthonormal_vector();
        (self.disk + (u - 0.5) * across + (v - 0.5) * self.normal.cross(across), self.normal)
    }

    /// Slots of photons: two thirds of them hold one, on either side of either surface.
    fn photons(&self, count: usize, seed: u32) -> (Vec<Photon>, Vec<StoredPhoton>) {
        let random = common::noise(8 * count, seed);
        let one = |u: &[f64]| {
            if u[0] < 1.0 / 3.0 {
                return (empty(), stored(&empty(), DVec3::X));
            }
            let surface = u32::from(u[1] < 0.4);
            let (point, normal) = self.point(surface, u[2], u[3]);
            let direction = onto(if u[4] < 0.3 { -normal } else { normal }, u[5], u[6]);
            let slot = photon(point, direction, [u[7], 1.0, 0.5 + u[5]], surface);
            (slot, stored(&slot, direction))
        };
        random.chunks_exact(8).map(one).unzip()
    }

    /// Points on both sides of both surfaces, some of them beyond all photons.
    fn queries(&self, count: usize, seed: u32) -> Vec<Query> {
        let random = common::noise(4 * count, seed);
        let one = |u: &[f64]| {
            let surface = u32::from(u[0] < 0.5);
            let (point, normal) = self.point(surface, 1.4 * u[1] - 0.2, 1.4 * u[2] - 0.2);
            Query::new(point, if u[3] < 0.5 { normal } else { -normal }, surface)
        };
        random.chunks_exact(4).map(one).collect()
    }
}

fn vector(v: [f32; 3]) -> DVec3 {
    dvec3(v[0].into(), v[1].into(), v[2].into())
}

/// As `query_thickness` for flat surfaces.
fn place(query: &Query, radius: f64) -> Place {
    let [point, normal] = [query.point, query.normal].map(vector);
    let thickness = (0.004 * radius + 4e-6 * point.abs().max_element()).min(0.25 * radius);
    Place { point, normal, surface: query.surface, thickness }
}

/// Sums of n photons in any order: n roundings of each, and 16 of weight, norm and flux.
fn agree(what: &str, found: &[Found], expected: &[[f64; 3]], photons: usize) {
    let bound = (photons as f64 + 16.0) * EPS;
    for (i, (found, expected)) in found.iter().zip(expected).enumerate() {
        for (found, expected) in found.sums.iter().zip(expected) {
            common::close(&format!("{what}, point {i}"), f64::from(*found), *expected, bound * expected);
        }
    }
}

#[test]
fn every_structure_finds_what_its_twin_finds() {
    let scene = Scene::new();
    for (weighting, weight) in WEIGHTINGS {
        for (count, radius) in [(0, 0.1), (1, 0.4), (2, 0.4), (3, 0.4), (1000, 0.11), (1000, 100.0)] {
            let (slots, twin) = scene.photons(count, 7);
            let queries = scene.queries(150, 8);
            let expected: Vec<_> = queries
                .iter()
                .map(|query| irradiance(&twin, &place(query, radius), radius, weight))
                .collect();
            assert!(count < 1000 || expected.iter().filter(|sums| sums[1] > 0.0).count() > 50);
            let brute = ("brute force", plain(Acceleration::BruteForce, weighting));
            for (name, settings) in [brute].into_iter().chain(structures(weighting)) {
                let what = format!("{weighting:?}, {count} photons within {radius}, {name}");
                let found = scene.gathering.irradiance(settings, &slots, radius as f32, &queries);
                agree(&what, &found, &expected, count);
            }
        }
    }
}
