//! Maps of photons: all of them find the photons that brute force finds, and both sum what their twin sums.

mod common;
#[path = "common/photon_maps.rs"]
mod photon_maps;

use common::EPS;
use glam::{DVec3, dvec3};
use photon_maps::{Found, Gathering, Query, empty, photon, sided, stored};
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
        let random = common::noise(7 * count, seed);
        let one = |u: &[f64]| {
            if u[0] < 1.0 / 3.0 {
                return (empty(), stored(&empty(), DVec3::X));
            }
            let surface = u32::from(u[1] < 0.4);
            let (point, normal) = self.point(surface, u[2], u[3]);
            let inside = u[4] < 0.3;
            let facing = if inside { -normal } else { normal };
            let slot = sided(point, facing, inside, [u[6], 1.0, 0.5 + u[5]], surface);
            (slot, stored(&slot, facing))
        };
        random.chunks_exact(7).map(one).unzip()
    }

    /// Points on both sides of both surfaces, some of them beyond all photons.
    fn queries(&self, count: usize, seed: u32) -> Vec<Query> {
        let random = common::noise(4 * count, seed);
        let one = |u: &[f64]| {
            let surface = u32::from(u[0] < 0.5);
            let (point, normal) = self.point(surface, 1.4 * u[1] - 0.2, 1.4 * u[2] - 0.2);
            let front = Query::new(point, normal, surface);
            if u[3] < 0.5 { front } else { front.behind() }
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
    Place { point, normal, inside: query.inside, surface: query.surface, thickness }
}

/// What a point should get, and what it would if all photons within the radius counted alike.
struct Expected {
    sums: [f64; 3],
    unweighted: [f64; 3],
}

/// Sums of n photons in any order: n roundings, and of each photon 16 of weight, norm and flux. Its weight is off by so much
/// of 1, not of itself; norms are at most 5 times those of the constant kernel.
fn agree(what: &str, found: &[Found], expected: &[Expected], photons: usize) {
    for (i, (found, expected)) in found.iter().zip(expected).enumerate() {
        for channel in 0..3 {
            let [sum, unweighted] = [expected.sums[channel], expected.unweighted[channel]];
            let bound = (photons as f64 * sum + 16.0 * 5.0 * unweighted) * EPS;
            common::close(&format!("{what}, point {i}"), found.sums[channel].into(), sum, bound);
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
            let of = |query, weight| irradiance(&twin, &place(query, radius), radius, weight);
            let expect = |query| Expected { sums: of(query, weight), unweighted: of(query, constant) };
            let expected: Vec<_> = queries.iter().map(expect).collect();
            assert!(count < 1000 || expected.iter().filter(|expected| expected.sums[1] > 0.0).count() > 50);
            let kept = if weighting == Weighting::Cone { usize::MAX } else { 1 };
            let brute = ("brute force", plain(Acceleration::BruteForce, weighting));
            for (name, settings) in [brute].into_iter().chain(structures(weighting).into_iter().take(kept)) {
                let what = format!("{weighting:?}, {count} photons within {radius}, {name}");
                let found = scene.gathering.irradiance(settings, &slots, radius as f32, &queries);
                agree(&what, &found, &expected, count);
            }
        }
    }
}

/// On a curved surface, which has photons on both sides that face anywhere; on meshes, either side is as good.
#[test]
fn photons_that_face_elsewhere_do_not_count() {
    let random = common::noise(7 * 2000, 22);
    let radius = 0.4;
    for receiver in [Receiver::curved(), Receiver::mesh()] {
        let gathering = Gathering::new(vec![receiver]);
        let either = receiver == Receiver::mesh();
        let photons = random.chunks_exact(7).map(|u| {
            let place = dvec3(u[0] - 0.5, u[1] - 0.5, 0.2 * (u[2] - 0.5));
            // Up to 61 degrees off the normal, or 80 and more: steps of the packed normals do not change what counts.
            let off = if u[3] < 0.5 { 2.0 * u[3] * 61.0 } else { 80.0 + 200.0 * (u[3] - 0.5) };
            let ((sin, cos), turn) = (off.to_radians().sin_cos(), std::f64::consts::TAU * u[4]);
            let facing = dvec3(sin * turn.cos(), sin * turn.sin(), cos);
            let slot = sided(place, facing, u[5] < 0.5, [u[6], 1.0, 0.5], 0);
            (slot, StoredPhoton { inside: slot.is_inside() && !either, ..stored(&slot, facing) })
        });
        let (slots, twin): (Vec<_>, Vec<_>) = photons.unzip();
        let front = (0..50).map(|i| Query::new(dvec3(0.01 * f64::from(i) - 0.2, 0.1, 0.0), DVec3::Z, 0));
        let queries: Vec<Query> = front.flat_map(|front| [front, Query { inside: true, ..front }]).collect();
        let of = |query: &Query, weight| {
            let inside = query.inside && !either;
            let place = Place { inside, thickness: 0.25 * radius, ..place(query, radius) };
            irradiance(&twin, &place, radius, weight)
        };
        let expect = |query| Expected { sums: of(query, cone), unweighted: of(query, constant) };
        let expected: Vec<_> = queries.iter().map(expect).collect();
        for acceleration in [Acceleration::BruteForce, Acceleration::Lexicographic, Acceleration::Voxels] {
            let settings = plain(acceleration, Weighting::Cone);
            let found = gathering.irradiance(settings, &slots, radius as f32, &queries);
            agree(&format!("{receiver:?}, {acceleration:?}"), &found, &expected, 2000);
        }
    }
}

#[test]
fn photons_in_a_medium_need_no_surface() {
    let scene = Scene::new();
    let (slots, twin) = scene.photons(1000, 9);
    let queries = scene.queries(100, 10);
    for (weighting, weight) in WEIGHTINGS {
        let of = |query: &Query, weight| density(&twin, vector(query.point), 0.125, weight);
        let expect = |query| Expected { sums: of(query, weight), unweighted: of(query, constant) };
        let expected: Vec<_> = queries.iter().map(expect).collect();
        for acceleration in [Acceleration::BruteForce, Acceleration::Voxels] {
            let found = scene.gathering.density(plain(acceleration, weighting), &slots, 0.125, &queries);
            agree(&format!("{weighting:?}, {acceleration:?}"), &found, &expected, 1000);
        }
    }
}

#[test]
fn weights_of_the_paper_are_not_normalised() {
    let scene = Scene::new();
    let (slots, twin) = scene.photons(1000, 11);
    let queries = scene.queries(100, 12);
    let radius = 0.2_f64;
    let settings = MapSettings { paper_weights: true, ..plain(Acceleration::Voxels, Weighting::Cone) };
    let area = std::f64::consts::PI * radius.powi(2) / 3.0;
    let raw = |query, weight| irradiance(&twin, &place(query, radius), radius, weight).map(|sum| area * sum);
    let expect = |query| Expected { sums: raw(query, cone), unweighted: raw(query, constant) };
    let expected: Vec<_> = queries.iter().map(expect).collect();
    agree("paper", &scene.gathering.irradiance(settings, &slots, radius as f32, &queries), &expected, 1000);
}

/// Neighbours at the radius, but for an ulp, on the faces of cells: counts tell whether any of them is missed.
#[test]
fn neighbours_across_faces_of_cells_are_found() {
    let step = 0.1_f32;
    let lattice = |origin: f32, layers: usize| -> Vec<[f32; 3]> {
        let at = |k: usize| origin + step * k as f32;
        (0..layers * 21 * 21).map(|i| [at(i % 21), at(i / 21 % 21), at(i / 441)]).collect()
    };
    let gathering = Gathering::new(vec![Receiver::plane(DVec3::ZERO, DVec3::Z), Receiver::curved()]);
    for (origin, farther) in [(0.0_f32, 1.0), (-1.05, 1.0), (-7.3, 1e-6), (1000.0, 1e-3)] {
        let radius = step * (1.0 + farther * 1e-3) + f32::EPSILON * origin.abs();
        for planar in [false, true] {
            let places = lattice(origin, if planar { 1 } else { 6 });
            let surface = u32::from(!planar);
            let places: Vec<DVec3> =
                places.into_iter().map(|p| vector(p) * dvec3(1.0, 1.0, surface.into())).collect();
            let slots: Vec<Photon> =
                places.iter().map(|&place| photon(place, DVec3::Z, [1.0; 3], surface)).collect();
            let queries: Vec<Query> =
                places.iter().map(|&place| Query::new(place, DVec3::Z, surface)).collect();
            let gather = |settings| {
                if planar {
                    gathering.irradiance(settings, &slots, radius, &queries)
                } else {
                    gathering.density(settings, &slots, radius, &queries)
                }
            };
            let brute = gather(plain(Acceleration::BruteForce, Weighting::Constant));
            for (name, settings) in structures(Weighting::Constant) {
                if !planar && settings.acceleration == Acceleration::Planar {
                    continue;
                }
                for (i, (found, expected)) in gather(settings).iter().zip(&brute).enumerate() {
                    assert_eq!(found.sums, expected.sums, "{name} from {origin}, {:?}", queries[i]);
                    assert_eq!(expected.looked_at as usize, slots.len());
                }
            }
        }
    }
}

#[test]
fn photons_in_one_cell_and_slots_without_any_are_mapped() {
    let gathering = Gathering::new(vec![Receiver::plane(DVec3::ZERO, DVec3::Z)]);
    let query = [Query::new(dvec3(0.25, 0.0, 0.0), DVec3::Z, 0)];
    for (name, settings) in structures(Weighting::Constant) {
        let slots = [photon(DVec3::ZERO, DVec3::Z, [1.0; 3], 0); 1000];
        let (map, facts) = gathering.map(settings, &slots, 0.5);
        assert_eq!(facts.valid, 1000);
        let found = gathering.gather("probe_irradiance", &map, &query)[0];
        let expected = 1000.0 / (std::f64::consts::PI * 0.25);
        common::close(name, found.sums[0].into(), expected, 3.0 * EPS * expected);
        assert_eq!(found.looked_at, 1000.0);

        for slots in [vec![empty(); 1000], vec![]] {
            let (map, facts) = gathering.map(settings, &slots, 0.5);
            assert_eq!(facts.valid, 0, "{name}");
            let found = gathering.gather("probe_irradiance", &map, &query)[0];
            assert_eq!(found, Found { sums: [0.0; 3], looked_at: 0.0 }, "{name}");
        }
    }
}

#[test]
fn maps_are_the_same_bit_for_bit_whatever_was_there() {
    let scene = Scene::new();
    let device = &scene.gathering.device;
    let (slots, _) = scene.photons(3000, 13);
    let (others, _) = scene.photons(5000, 14);
    let queries = scene.queries(200, 15);
    let [slots_, others_] = [&slots, &others].map(|slots| Buffer::from_slice(device, slots).unwrap());
    for (name, settings) in structures(Weighting::Smoothstep) {
        let fresh = scene.gathering.irradiance(settings, &slots, 0.08, &queries);
        let mut map = PhotonMap::new(device, settings, &scene.gathering.receivers, 7777).unwrap();
        map.build(device, &others_, 0..5000, 0.02).unwrap();
        map.build(device, &others_, 0..0, 0.3).unwrap();
        let facts = map.build(device, &slots_, 0..3000, 0.08).unwrap();
        assert_eq!(facts.valid, slots.iter().filter(|slot| slot.flux[3].to_bits() > 0).count());
        assert_eq!(facts.tabled, facts.cells != [0; 3] && settings.table_cells > 0, "{name}");
        assert_eq!(scene.gathering.gather("probe_irradiance", &map, &queries), fresh, "{name}");
    }
}

#[test]
fn maps_of_some_slots_hold_these_alone() {
    let scene = Scene::new();
    let device = &scene.gathering.device;
    let (slots, twin) = scene.photons(3000, 18);
    let slots_ = Buffer::from_slice(device, &slots).unwrap();
    let queries = scene.queries(200, 19);
    let weighting = Weighting::Cone;
    let brute = ("brute force", plain(Acceleration::BruteForce, weighting));
    for (name, settings) in [brute].into_iter().chain(structures(weighting)) {
        let mut map = PhotonMap::new(device, settings, &scene.gathering.receivers, 2000).unwrap();
        // As roles have them: the first slots, and the others within a larger radius.
        for (range, radius) in [(0..1001, 0.05), (1001..3000, 0.25)] {
            let facts = map.build(device, &slots_, range.clone(), radius).unwrap();
            let held = slots[range.clone()].iter().filter(|slot| slot.flux[3].to_bits() > 0).count();
            assert_eq!(facts.valid, held, "{name}, {range:?}");
            let found = scene.gathering.gather("probe_irradiance", &map, &queries);
            let alone = scene.gathering.irradiance(settings, &slots[range.clone()], radius, &queries);
            assert_eq!(found, alone, "{name}, {range:?}");
            let of = |query, weight| {
                irradiance(&twin[range.clone()], &place(query, radius.into()), radius.into(), weight)
            };
            let expect = |query| Expected { sums: of(query, cone), unweighted: of(query, constant) };
            let expected: Vec<_> = queries.iter().map(expect).collect();
            agree(&format!("{name}, {range:?}"), &found, &expected, range.len());
        }
    }
}

#[test]
fn surfaces_that_reach_less_far_are_gathered_within_that() {
    let scene = Scene::new();
    let (slots, _) = scene.photons(2000, 20);
    let queries = scene.queries(200, 21);
    let receivers = &scene.gathering.receivers;
    let limited = receivers.iter().map(|receiver| Receiver { reach: 0.06, ..*receiver }).collect();
    let limited = Gathering::new(limited);
    for weighting in [Weighting::Constant, Weighting::Smoothstep] {
        let brute = plain(Acceleration::BruteForce, weighting);
        // Masses at edges are those of the smaller radius, too.
        for (name, settings) in structures(weighting).into_iter().chain([("brute force", brute)]) {
            let settings = MapSettings { edge_correction: true, ..settings };
            let found = limited.irradiance(settings, &slots, 0.21, &queries);
            let expected = scene.gathering.irradiance(settings, &slots, 0.06, &queries);
            for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
                for (found, expected) in found.sums.into_iter().zip(expected.sums) {
                    // Sums of some 20 photons in another order; 16 roundings of weight and norm. Masses of 1e-4 to 1 have
                    // the rounding of 1 in them.
                    let bound = 40.0 * EPS * f64::from(expected) + 1e-3 * f64::from(expected);
                    common::close(&format!("{name}, point {i}"), found.into(), expected.into(), bound);
                }
            }
            assert!(expected.iter().filter(|expected| expected.sums[1] > 0.0).count() > 50);
            // No farther than the radius, if that is less.
            let found = limited.irradiance(settings, &slots, 0.05, &queries);
            assert_eq!(found, scene.gathering.irradiance(settings, &slots, 0.05, &queries), "{name}");
        }
    }
}

#[test]
fn cells_save_looking_at_photons() {
    let scene = Scene::new();
    let (slots, _) = scene.photons(3000, 16);
    let queries = scene.queries(200, 17);
    let looked_at = |settings| -> f32 {
        let found = scene.gathering.irradiance(settings, &slots, 0.05, &queries);
        found.iter().map(|found| found.looked_at).sum()
    };
    let of = |acceleration| looked_at(plain(acceleration, Weighting::Cone));
    let [brute, sorted, voxels, planar] =
        [Acceleration::BruteForce, Acceleration::Lexicographic, Acceleration::Voxels, Acceleration::Planar]
            .map(of);
    assert_eq!(brute, 200.0 * 3000.0);
    // Twice the radius of a side of 1.2, and a third of the slots are empty; then 3 sides of cells of 1.
    assert!(sorted < 0.15 * brute && voxels < 0.25 * sorted && planar < voxels, "{sorted} {voxels} {planar}");
}

#[test]
fn what_cannot_be_mapped_is_refused() {
    let scene = Scene::new();
    let device = &scene.gathering.device;
    let error = |settings, capacity, photons: &[Photon], radius| {
        let slots = Buffer::from_slice(device, photons).unwrap();
        PhotonMap::new(device, settings, &scene.gathering.receivers, capacity)
            .and_then(|mut map| map.build(device, &slots, 0..photons.len(), radius))
            .unwrap_err()
            .to_string()
    };
    let settings = plain(Acceleration::Planar, Weighting::Cone);
    let flat = [photon(DVec3::ZERO, DVec3::Z, [1.0; 3], 0); 2];
    let round = [photon(DVec3::ZERO, DVec3::Z, [1.0; 3], 2); 3];
    assert_eq!(
        error(settings, 3, &round, 0.1),
        "3 photons lie on surfaces that are no planes, parallelograms or disks: cells in planes cannot hold them, voxels can"
    );
    assert_eq!(error(settings, 1, &flat, 0.1), "cannot map 2 photons: there is room for 1");
    let slots = Buffer::from_slice(device, &flat).unwrap();
    let mut map = PhotonMap::new(device, settings, &scene.gathering.receivers, 9).unwrap();
    let beyond = map.build(device, &slots, 1..4, 0.1).unwrap_err().to_string();
    assert_eq!(beyond, "cannot map 3 photons: there is room for 1");
    for radius in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-30, 1e30] {
        let expected = format!(
            "photons cannot be gathered within a radius of {radius}: it must be positive, and float32 must hold its square"
        );
        assert_eq!(error(settings, 2, &flat, radius), expected);
    }
    assert_eq!(
        error(settings, 1_000_000_000, &flat, 0.1),
        "a map of 1000000000 photons is too large: it can have up to 536870904"
    );
}
