//! What must not matter: units, place, axes and distance of a scene; bricks and launches.

mod common;

use bytemuck::bytes_of;
use common::{Case, EPS, close, device, largest, report, smooth, stretches, volume_f32};
use glam::DVec3;
use serde_json::Value;
use svetlo::film::FilmPixel;
use svetlo::reference::camera::Ray;
use svetlo::render::{Plan, Session};
use svetlo::volume::{Volume, Voxels};

const DIMS: [usize; 3] = [7, 9, 8];

/// How a scene is written down: lengths times `scale`, moved by `shift`, axes turned `turns` times x → y → z → x.
#[derive(Clone, Copy)]
struct Frame {
    scale: f64,
    shift: f64,
    turns: usize,
}

const PLAIN: Frame = Frame { scale: 1.0, shift: 0.0, turns: 0 };

impl Frame {
    fn turned<T: Copy>(&self, v: [T; 3]) -> [T; 3] {
        [0, 1, 2].map(|axis| v[(axis + 3 - self.turns) % 3])
    }

    fn point(&self, p: [f64; 3]) -> String {
        format!("{:?}", self.turned(p).map(|x| x * self.scale + self.shift))
    }

    fn direction(&self, p: [f64; 3]) -> String {
        format!("{:?}", self.turned(p))
    }

    /// A scene of the method in this frame.
    fn case(&self, method: &str, filter: &str) -> Case {
        let spacing = [1.0, 1.25, 1.5];
        let text = format!(
            "[image]\nwidth = 24\nheight = 20\nfilter = \"{filter}\"\n[camera]\nposition = {}\ntarget = {}\nup = {}\nfov = 30\n\
             [volume]\norigin = {}\nspacing = {}\nwindow = {{ lo = 0, hi = 1 }}\n[medium]\nsigma_max = {}\n\
             [transfer]\npoints = [{{ value = 0.3, opacity = 0, color = [0, 0, 1] }}, {{ value = 0.8, opacity = 1, color = [1, 0.5, 0] }}]\n\
             [background]\ncolor = [0.1, 0.2, 0.3]\n[[light]]\nkind = \"point\"\nposition = {}\nintensity = {}\n\
             [[light]]\nkind = \"directional\"\ndirection = {}\nirradiance = [0, 1, 2]\n{method}",
            self.point([20.0, 26.0, -15.0]),
            self.point([3.5, 5.625, 6.0]),
            self.direction([0.1, 1.0, 0.2]),
            self.point([0.0; 3]),
            self.direction(spacing.map(|h| h * self.scale)),
            0.7 / self.scale,
            self.point([25.0, 5.0, -30.0]),
            1500.0 * self.scale * self.scale,
            self.direction([-1.0, -2.0, 0.5]),
        );
        Case::new(&text, self.volume())
    }

    fn volume(&self) -> Volume {
        let plain = smooth(DIMS, 6);
        let dims = self.turned(DIMS);
        let voxels = (0..DIMS.iter().product()).map(|i: usize| {
            let place = [i % dims[0], i / dims[0] % dims[1], i / (dims[0] * dims[1])];
            let back = Self { turns: (3 - self.turns) % 3, ..*self };
            let [x, y, z] = back.turned(place);
            plain.value(x, y, z) as f32
        });
        Volume::new(dims, DVec3::ONE, Voxels::F32(voxels.collect::<Vec<f32>>())).unwrap()
    }
}

const METHODS: [&str; 4] = [
    "[method]\nkind = \"emission-absorption\"\ntermination = 0\n",
    "[method]\nkind = \"emission-absorption\"\ntermination = 0\nquadrature = \"step\"\nstep = 0.5\njitter = false\n",
    "[method]\nkind = \"mip\"\n",
    "[method]\nkind = \"isosurface\"\nvalue = 0.55\nspecular = 0\n",
];

/// A method's first words.
fn name(method: &str) -> String {
    method.lines().skip(1).filter(|line| !line.starts_with("term")).collect::<Vec<_>>().join(", ")
}

/// The largest difference between two films' means, leaving out pixels where one film hits a surface and the other
/// does not, or another sheet of it (depths apart by more than a tenth of a voxel): returns both it and their number.
fn difference(a: &[FilmPixel], b: &[FilmPixel]) -> (f64, usize) {
    let elsewhere = |p: &FilmPixel, q: &FilmPixel| p.hits != q.hits || (p.depth - q.depth).abs() > 0.1;
    let left_out = a.iter().zip(b).filter(|(p, q)| elsewhere(p, q)).count();
    let kept = a.iter().zip(b).filter(|(p, q)| !elsewhere(p, q));
    let error = largest(kept.flat_map(|(p, q)| {
        let (p, q) = (p.mean(), q.mean());
        (0..4).map(move |c| (p[c] - q[c]).abs()).collect::<Vec<_>>()
    }));
    (error, left_out)
}

#[test]
fn units_place_and_axes_do_not_matter() {
    let frames = [
        ("a thousandth", Frame { scale: 1e-3, ..PLAIN }),
        ("a thousandfold", Frame { scale: 1e3, ..PLAIN }),
        ("moved by 10⁴ sizes", Frame { shift: 1.2e5, ..PLAIN }),
        ("small and moved", Frame { scale: 1e-3, shift: 1.2e2, ..PLAIN }),
        ("axes turned once", Frame { turns: 1, ..PLAIN }),
        ("axes turned twice", Frame { turns: 2, ..PLAIN }),
    ];
    for method in METHODS {
        let plain = PLAIN.case(method, "point").film();
        for (what, frame) in frames {
            let (error, left_out) = difference(&plain, &frame.case(method, "point").film());
            // The device gets the same local numbers but for their last bit, so positions differ by about the rounding
            // of coordinates up to 16, 16·2^-24, at each end of a ray. Radiance changes by less than 1 per unit of
            // length for the medium (σ ≤ 0.7, L ≤ 1), 0.5 for the value; shading turns with the gradient, by
            // its second derivatives (below 1) over its length (above 0.1), times irradiances up to 3.
            let slope = if method.contains("isosurface") { 30.0 } else { 2.0 };
            let bound = 8.0 * 16.0 * EPS * slope;
            report(&format!("{what}, {}", name(method)), error, bound);
            assert!(error <= bound, "{what}: {error} > {bound}\n{method}");
            // The maximum may jump between equal ones; silhouettes may fall on either side.
            assert!(left_out <= 2, "{what}: {left_out} pixels elsewhere\n{method}");
        }
    }
}

#[test]
fn a_telescope_sees_what_a_parallel_camera_sees() {
    let far = 1e5 * 12.0;
    let direction = DVec3::new(0.6, 0.5, -0.62).normalize();
    let target = DVec3::new(3.5, 4.5, 4.0);
    let height = 9.0;
    for method in METHODS {
        let text = |camera: String, distance: f64| {
            format!(
                "[image]\nwidth = 16\nheight = 16\nfilter = \"point\"\n[camera]\nposition = {:?}\ntarget = {:?}\n{camera}\n\
                 [volume]\nwindow = {{ lo = 0, hi = 1 }}\n[medium]\nsigma_max = 0.3\n{method}",
                (target + distance * direction).to_array(),
                target.to_array()
            )
        };
        let fov = (2.0 * f64::atan(0.5 * height / far)).to_degrees();
        let telescope = Case::new(&text(format!("fov = {fov:?}"), far), smooth(DIMS, 6)).film();
        let parallel =
            Case::new(&text(format!("kind = \"orthographic\"\nheight = {height}"), 100.0), smooth(DIMS, 6))
                .film();
        let same_depth = |film: Vec<FilmPixel>| {
            film.into_iter().map(|p| FilmPixel { depth: 0.0, ..p }).collect::<Vec<_>>()
        };
        let (error, left_out) = difference(&same_depth(telescope), &same_depth(parallel));
        // Rays converge by height/2 over 10⁵ sizes: over the box's length they drift by 4.5e-5 at most, 40 times more
        // than rounding moves them.
        let slope = if method.contains("isosurface") { 30.0 } else { 2.0 };
        let bound = (4.5e-5 + 8.0 * 16.0 * EPS) * slope;
        report(&format!("telescope, {}", name(method)), error, bound);
        assert!(error <= bound && left_out <= 2, "{error} > {bound}, {left_out}\n{method}");
    }
}

/// All bytes of a film but the count of look-ups, which bricks are meant to change.
fn bits(film: &[FilmPixel]) -> Vec<u8> {
    let same = |pixel: &FilmPixel| FilmPixel { lookups_low: 0, lookups_high: 0, ..*pixel };
    film.iter().flat_map(|pixel| bytes_of(&same(pixel)).to_vec()).collect()
}

#[test]
fn bricks_do_not_matter_to_the_last_bit() {
    let jitter = "[method]\nkind = \"emission-absorption\"\nquadrature = \"step\"\nstep = 0.7\n";
    for method in METHODS.into_iter().chain([jitter]) {
        let case = PLAIN.case(method, "box");
        let film = |shift: u32| {
            let plan = Plan::new(&case.scene, &case.volume, shift).unwrap();
            let mut session = Session::new(device(), &plan).unwrap();
            session.render(3).unwrap();
            session.film().unwrap()
        };
        let first = film(2);
        for shift in [1, 3, 4, 5] {
            let other = film(shift);
            let places: Vec<usize> =
                (0..first.len()).filter(|&i| bits(&first[i..=i]) != bits(&other[i..=i])).collect();
            assert!(places.is_empty(), "bricks of 2^{shift} change pixels {places:?}\n{method}");
        }
        let empty = case.plan();
        assert!(empty.memory().total() > 0);
    }
}

#[test]
fn launches_do_not_matter_to_the_last_bit() {
    let jitter = "[method]\nkind = \"emission-absorption\"\nquadrature = \"step\"\nstep = 0.7\n";
    for method in [METHODS[0], METHODS[2], METHODS[3], jitter] {
        let case = PLAIN.case(method, "box");
        let whole = case.film_of(7);
        // 24×20 pixels are 9 tiles.
        for units in [1, 2, 5, 9, 10, 18, 1000] {
            let mut session = case.session();
            session.limit_launches(units);
            session.render(7).unwrap();
            assert_eq!(bits(&session.film().unwrap()), bits(&whole), "{units} tiles a launch\n{method}");
            assert!(session.progress().launches >= 63 / units.max(1));
        }
        let mut session = case.session();
        for sample in 1..=7 {
            session.render(sample).unwrap();
        }
        assert_eq!(bits(&session.film().unwrap()), bits(&whole), "sample by sample\n{method}");
        session.reset().unwrap();
        session.render(7).unwrap();
        assert_eq!(bits(&session.film().unwrap()), bits(&whole), "after a reset\n{method}");
    }
}

#[test]
fn anisotropic_voxels_are_as_long_as_they_say() {
    // The oblique ramp row of the unit cube, stretched by (1, 1, 2): densities along the ray are the same, so the
    // optical depth grows as the ray's length.
    let truths: Value = serde_json::from_str(include_str!("truths.json")).unwrap();
    let row = &truths["ramp_transmittance"]["rows"][3];
    assert!(row["ray"].as_str().unwrap().starts_with("oblique"));
    for n in [4, 16] {
        let (from, to) = (DVec3::new(0.0, 0.5, 0.2), DVec3::new(1.0, 0.5, 1.4));
        let stretch = (to - from).length() / row["length"].as_f64().unwrap();
        let tau = stretch * row[format!("tau_N{n}")].as_f64().unwrap();
        let h = 1.0 / n as f64;
        for quadrature in ["", "quadrature = \"step\"\njitter = false\nstep = 0.01"] {
            let text = format!(
                "[image]\nwidth = 1\nheight = 1\nfilter = \"point\"\n[camera]\nposition = {:?}\ntarget = {:?}\n\
                 [volume]\nspacing = [{h}, {h}, {}]\nwindow = {{ lo = 0, hi = 1 }}\n[medium]\nsigma_max = 5\n\
                 [transfer]\npoints = [{{ value = 0, opacity = 0.2 }}, {{ value = 1, opacity = 1 }}]\n\
                 [method]\nkind = \"emission-absorption\"\ntermination = 0\n{quadrature}\n",
                (2.0 * from - to).to_array(),
                to.to_array(),
                2.0 * h
            );
            let ramp = volume_f32([n; 3], (0..n * n * n).map(|i| ((i / (n * n)) as f64 + 0.5) * h));
            let case = Case::new(&text, ramp);
            // Sums of up to 2·116·n/4 parts of an optical depth of 4.6, seen through T τ ≤ 1/e; steps add less than
            // their own square times the kinks' slope, 1e-4·h.
            close(&format!("N{n} {quadrature}"), case.film()[0].mean()[3], -f64::exp_m1(-tau), 1e-5);
            // The twin agrees with the published row to its 12 digits.
            let twin = stretches(&case.field(), &case.medium(), &[Ray::towards(2.0 * from - to, to)]);
            close("twin", twin[0].depth, tau, 1e-9 * tau + 2e-7);
        }
    }
}
