//! What the estimators of transmittance have in common, their means, and what tells them apart, their variances; light
//! that is sampled along rays: rectangles in and around the medium, point lights near it.

mod common;

use common::scattering::{Measured, Twin, all_finite, blocks, family, of_film, of_values, over_pixels};
use common::{Case, EPS, noisy, smooth, volume_f32};
use glam::DVec3;
use std::f64::consts::PI;
use svetlo::film::FilmPixel;
use svetlo::reference::camera::Ray;
use svetlo::reference::quadrature::{adaptive, gauss_legendre};
use svetlo::reference::scattering::HomogeneousBox;
use svetlo::render::BRICK_SHIFT;
use svetlo::scene::{Light, Phase};

const ESTIMATORS: [&str; 5] = ["auto", "analog", "ratio", "residual-ratio", "ray-marching"];

const SIDE: usize = 12;

/// A black medium before a white background.
fn black(transfer: &str, medium: &str, method: &str, estimator: &str) -> String {
    format!(
        "[image]\nwidth = {SIDE}\nheight = {SIDE}\nfilter = \"point\"\n[camera]\nposition = [19, 23, -14]\n\
         target = [4, 5, 4.5]\nfov = 12\n[volume]\nwindow = {{ lo = 0, hi = 1 }}\n{transfer}\n\
         [medium]\nalbedo = 0\n{medium}\n[background]\ncolor = 1\n\
         [method]\nkind = \"{method}\"\ntransmittance = \"{estimator}\"\n"
    )
}

const TWO_D: &str = "[transfer]\nkind = \"2d\"\nresolution = [9, 7]\ngradient_max = 0.6\nshapes = [\n\
    { shape = \"ellipse\", centre = [0.5, 0.4], size = [0.9, 0.9], opacity = 0.9, softness = 0.7 }]\n";

const BENT: &str = "[transfer]\nresolution = 6\npoints = [{ value = 0.2, opacity = 0 }, { value = 0.6, opacity = 1 }, \
    { value = 0.8, opacity = 0.2 }]\n";

#[test]
fn estimators_have_the_same_means() {
    let scenes = [
        ("noisy ramp", noisy([8, 9, 10], 3), "", "sigma_max = 0.4", [1.0; 3]),
        ("noisy, bent", noisy([8, 9, 10], 4), BENT, "sigma_max = 0.6", [1.0; 3]),
        ("smooth, 2-D", smooth([8, 9, 10], 5), TWO_D, "sigma_max = 0.5", [1.0; 3]),
        (
            "coloured",
            noisy([8, 9, 10], 6),
            BENT,
            "sigma_max = 0.5\nextinction_color = [0.3, 1.2, 0]",
            [0.3, 1.2, 0.0],
        ),
    ];
    let n = 3;
    let k = family(scenes.len() * ESTIMATORS.len() * n * n * 3);
    for (name, volume, transfer, medium, color) in scenes {
        for estimator in ESTIMATORS {
            for method in ["single-scattering", "multiple-scattering"] {
                let text = black(transfer, medium, method, estimator);
                let volume = volume_f32(volume.dims, (0..720).map(|i| volume.voxels.get(i).unwrap()));
                let case = Case::new(&text, volume);
                let film = case.film_of(64);
                all_finite(&film);
                let depths: Vec<f64> = case.stretches().iter().map(|stretch| stretch.depth).collect();
                let mut worst: f64 = 0.0;
                for block in blocks(SIDE, n) {
                    for (channel, factor) in color.into_iter().enumerate() {
                        let found = of_film(block.iter().map(|&i| &film[i]), channel);
                        let exact = block.iter().map(|&i| (-factor * depths[i]).exp()).sum::<f64>();
                        let exact = Measured { value: exact / block.len() as f64, error: 0.0 };
                        // Float32 depths of up to 20 cells.
                        let z = found.deviation(exact, 64.0 * EPS);
                        worst = worst.max(z);
                        assert!(z <= k, "{name}, {estimator}, {method}: {found:?} {exact:?}: {z} σ > {k} σ");
                    }
                }
                println!("{name}, {estimator}, {method}: worst {worst:.2} σ of {k:.2}");
            }
        }
    }
}

/// All pixels look along one ray through a black medium; every sample is one estimate of its transmittance.
fn one_ray(volume: svetlo::volume::Volume, estimator: &str, scale: f64) -> Case {
    let text = format!(
        "[image]\nwidth = 128\nheight = 128\nfilter = \"point\"\n[camera]\nkind = \"orthographic\"\n\
         position = [-5, 3.2, 1.1]\ntarget = [40, 6.5, 7.4]\nheight = 1e-6\n[volume]\nwindow = {{ lo = 0, hi = 1 }}\n\
         {BENT}[medium]\nsigma_max = 0.25\nalbedo = 0\n[background]\ncolor = 1\n[method]\n\
         kind = \"single-scattering\"\npaths = 1\ntransmittance = \"{estimator}\"\nmajorant_scale = {scale}\n"
    );
    Case::new(&text, volume)
}

/// ∫σ along the ray of [`one_ray`], and ∫ of a function of the extinction and the bounds of its brick.
fn along(case: &Case, f: impl Fn(f64, [f64; 2]) -> f64) -> [f64; 2] {
    let plan = case.plan();
    let table = plan.method.tables.iter().find(|table| table.name == "majorants").unwrap();
    let bounds: Vec<[f32; 2]> = bytemuck::pod_collect_to_vec(&table.bytes);
    let counts = plan.volume().unwrap().bricks.counts;
    let (field, medium) = (case.field(), case.medium());
    let ray = Ray::towards(DVec3::new(-5.0, 3.2, 1.1), DVec3::new(40.0, 6.5, 7.4));
    let (from, to) = field.clip(&ray).unwrap();
    let steps = 400_000;
    let step = (to - from) / f64::from(steps);
    let mut sums = [0.0; 2];
    for i in 0..steps {
        let point = ray.at(from + (f64::from(i) + 0.5) * step);
        let sigma = medium.at(field.value(point), 0.0)[3];
        // Grid coordinates: voxels of spacing 1, the first centred at 2.
        let brick = ((point + 1.5) / f64::from(1 << BRICK_SHIFT)).floor().to_array().map(|b| b as usize);
        let bound = bounds[(brick[2] * counts[1] + brick[1]) * counts[0] + brick[0]].map(f64::from);
        sums[0] += step * sigma;
        sums[1] += step * f(sigma, bound);
    }
    sums
}

/// Variance of single samples over a film, and its standard error.
fn sample_variance(film: &[FilmPixel]) -> Measured {
    of_values(&film.iter().map(|pixel| pixel.variance().unwrap()[1]).collect::<Vec<_>>())
}

#[test]
fn variances_follow_from_the_bounds() {
    let volume = || noisy([40, 9, 10], 8);
    let samples = 32;
    let mut variances = Vec::new();
    for scale in [1.0, 2.5] {
        // A factor 1 − x/r at each of the tentative collisions, at a rate r: E[Π²] = exp(∫ r ((1 − x/r)² − 1)).
        let relative = |square: f64| f64::exp_m1(square);
        let ratio = |sigma: f64, [majorant, _]: [f64; 2]| {
            if majorant > 0.0 { sigma * sigma / (scale * majorant) } else { 0.0 }
        };
        let residual = |sigma: f64, [majorant, minorant]: [f64; 2]| {
            // The control lies a quarter of the way up from the minorant.
            let span = majorant - minorant;
            let deviation = sigma - (minorant + 0.25 * span);
            if majorant > 0.0 { deviation * deviation / (scale * 0.75 * span) } else { 0.0 }
        };
        for estimator in ["ratio", "residual-ratio", "analog", "ray-marching"] {
            let case = one_ray(volume(), estimator, scale);
            let [depth, square] =
                if estimator == "ratio" { along(&case, ratio) } else { along(&case, residual) };
            let t = (-depth).exp();
            let film = case.film_of(samples);
            over_pixels(&film, 1).agrees(&format!("{estimator}, {scale}: mean"), t, family(8), 64.0 * EPS);
            let found = sample_variance(&film);
            variances.push((estimator, scale, found.value));
            let exact = match estimator {
                "ratio" | "residual-ratio" => t * t * relative(square),
                "analog" => t * (1.0 - t),
                _ => {
                    println!("{estimator}, {scale}: variance {found:?}");
                    continue;
                }
            };
            // Midpoints across the bends of table and field, and the residual's least rate: below 10⁻⁴.
            found.agrees(&format!("{estimator}, {scale}: variance"), exact, family(6), 1e-4 * exact);
        }
    }
    let of = |wanted: &str| variances.iter().find(|(name, ..)| *name == wanted).unwrap().2;
    assert!(of("ray-marching") < 0.1 * of("ratio"), "{variances:?}");
    assert!(of("residual-ratio") < of("ratio") && of("ratio") < of("analog"), "{variances:?}");
}

#[test]
fn estimates_do_not_depend_on_launches() {
    for estimator in ["residual-ratio", "ray-marching"] {
        let text =
            black(BENT, "sigma_max = 1", "single-scattering", estimator).replace("width = 12", "width = 23");
        let light = "[[light]]\nkind = \"point\"\nposition = [4, 4, 6]\nintensity = 1\n[background]";
        let text = text.replace("[background]", light).replace("albedo = 0", "albedo = 0.8");
        let case = Case::new(&text, noisy([8, 9, 10], 4));
        let whole = case.film_of(5);
        let mut session = case.session();
        session.limit_launches(1);
        session.render(5).unwrap();
        let parts = session.film().unwrap();
        let bits = |film: &[FilmPixel]| film.iter().map(|p| (p.mean, p.m2).map_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&whole), bits(&parts), "{estimator}");
        let ledger = session.ledger().unwrap().unwrap();
        assert_eq!((ledger.above_majorant, ledger.unfinished), (0, 0), "{estimator}");
        assert!(ledger.lookups > ledger.paths, "{ledger:?}");
    }
}

trait MapBits {
    fn map_bits(self) -> [[u32; 4]; 2];
}

impl MapBits for ([f32; 4], [f32; 4]) {
    fn map_bits(self) -> [[u32; 4]; 2] {
        [self.0.map(f32::to_bits), self.1.map(f32::to_bits)]
    }
}

/// A rectangle across the middle of the view of a box of 8³, facing the camera at −z, at a height z.
fn shining(z: f64, sigma: f64, albedo: f64, method: &str) -> String {
    format!(
        "[image]\nwidth = 32\nheight = 32\nfilter = \"point\"\n[camera]\nkind = \"orthographic\"\nposition = [4, 4, -20]\n\
         target = [4, 4, 0]\nheight = 1e-5\n[volume]\nwindow = {{ lo = 0, hi = 1 }}\n[medium]\nsigma_max = {sigma}\n\
         albedo = {albedo}\n[[light]]\nkind = \"rectangle\"\ncentre = [4.2, 4.1, {z}]\nedge_u = [0, 3, 0]\n\
         edge_v = [3, 0, 0]\nradiance = [1, 2, 3]\n[method]\n{method}\n"
    )
}

#[test]
fn rectangles_shine_through_what_is_before_them() {
    let k = family(6 * 2 * 5 * 2);
    for z in [-19.5, -3.0, 0.0, 3.3, 8.0, 11.0] {
        for homogeneous in [true, false] {
            for estimator in ESTIMATORS {
                for order in ["single", "multiple"] {
                    let method = format!("kind = \"{order}-scattering\"\ntransmittance = \"{estimator}\"");
                    let text = shining(z, 0.4, 0.0, &method);
                    let volume =
                        if homogeneous { volume_f32([8; 3], vec![0.6; 512]) } else { noisy([8; 3], 21) };
                    let case = Case::new(&text, volume);
                    let origin = DVec3::new(4.0, 4.0, -20.0);
                    let twin = Twin::new(&case);
                    let beyond =
                        |start: f64| twin.tracer().depth(&Ray { origin, direction: DVec3::Z, start });
                    let depth = beyond(0.0) - beyond(z + 20.0);
                    let what = format!("rectangle at {z}, {estimator}, {order}, homogeneous {homogeneous}");
                    let found = over_pixels(&case.film_of(32), 1);
                    found.agrees(&what, 2.0 * (-depth).exp(), k, 2.0 * (64.0 * EPS + 1e-5));
                }
            }
        }
    }
}

/// Light of a rectangle in a homogeneous box of 8³ that a ray along z at (4, 4) sees scattered once, per radiance.
fn scattered_once(sigma: f64, albedo: f64, centre: DVec3, u: DVec3, v: DVec3) -> f64 {
    let nodes = gauss_legendre(24);
    let normal = u.cross(v);
    let exit = |p: DVec3, d: DVec3| {
        let leave = |a: usize| if d[a] > 0.0 { (8.0 - p[a]) / d[a] } else { -p[a] / d[a] };
        (0..3).filter(|&a| d[a] != 0.0).map(leave).fold(f64::INFINITY, f64::min)
    };
    let lit = |t: f64| {
        let p = DVec3::new(4.0, 4.0, t);
        let mut sum = 0.0;
        for &(a, wa) in &nodes {
            for &(b, wb) in &nodes {
                let to = centre + (a - 0.5) * u + (b - 0.5) * v - p;
                let (r, d) = (to.length(), to.normalize());
                let facing = (-normal.dot(d)).max(0.0) / (r * r);
                sum += wa * wb * facing * (-sigma * r.min(exit(p, d))).exp();
            }
        }
        sum
    };
    let integrand = |t: f64| sigma * albedo / (4.0 * PI) * (-sigma * t).exp() * lit(t);
    // Behind the plane of the rectangle it is dark.
    let plane = centre.z.clamp(0.0, 8.0);
    gauss_legendre(64).iter().map(|(x, w)| w * plane * integrand(x * plane)).sum()
}

#[test]
fn scattered_light_of_rectangles_agrees_with_the_quadrature() {
    let (sigma, albedo) = (0.24, 0.9);
    let k = family(3 * ESTIMATORS.len() * 2);
    for (name, centre) in
        [("inside", [6.5, 4.5, 6.0]), ("behind", [6.5, 4.0, 10.0]), ("beside", [10.5, 4.0, 6.0])]
    {
        for estimator in ESTIMATORS {
            for kind in ["kind = \"single-scattering\"", "kind = \"multiple-scattering\"\nmax_order = 1"] {
                let method = format!("{kind}\ntransmittance = \"{estimator}\"");
                let text = shining(0.0, 0.4, albedo, &method)
                    .replace("centre = [4.2, 4.1, 0]", &format!("centre = {centre:?}"));
                let film = Case::new(&text, volume_f32([8; 3], vec![0.6; 512])).film_of(100);
                let (u, v) = (DVec3::new(0.0, 3.0, 0.0), DVec3::new(3.0, 0.0, 0.0));
                let exact = 2.0 * scattered_once(sigma, albedo, DVec3::from_array(centre), u, v);
                // 24 nodes per edge at a distance of a third of it: below 10⁻⁶. Window values are 0.6 to a rounding.
                let what = format!("{name}, {estimator}, {}", &kind[8..14]);
                over_pixels(&film, 1).agrees(&what, exact, k, (1e-5 + 64.0 * EPS) * exact);
            }
        }
    }
}

/// A box of 8³ and a lamp in it, seen along z past the lamp at a distance.
struct Lamp {
    sigma: f64,
    height: f64,
}

impl Lamp {
    const POSITION: DVec3 = DVec3::new(4.0, 4.0, 4.0);

    fn case(&self, volume: svetlo::volume::Volume, method: &str) -> Case {
        let x = 4.0 + self.height;
        let text = format!(
            "[image]\nwidth = 64\nheight = 64\nfilter = \"point\"\n[camera]\nkind = \"orthographic\"\n\
             position = [{x}, 4, -20]\ntarget = [{x}, 4, 0]\nheight = 1e-6\n[volume]\nwindow = {{ lo = 0, hi = 1 }}\n\
             [medium]\nsigma_max = {}\nalbedo = 0.8\n[[light]]\nkind = \"point\"\nposition = [4, 4, 4]\nintensity = 1\n[method]\n{method}\n",
            self.sigma
        );
        Case::new(&text, volume)
    }
}

#[test]
fn lamps_in_a_homogeneous_medium_make_little_noise() {
    for (sigma, height) in [(0.2, 0.3), (0.2, 0.01), (1.5, 0.05), (0.01, 0.1)] {
        let lamp = Lamp { sigma, height };
        let medium = HomogeneousBox {
            low: DVec3::ZERO,
            high: DVec3::splat(8.0),
            sigma_t: sigma,
            albedo: 0.8,
            phase: Phase::Isotropic,
        };
        let ray = Ray::towards(DVec3::new(4.0 + height, 4.0, -20.0), DVec3::new(4.0 + height, 4.0, 0.0));
        let light = Light::Point { position: Lamp::POSITION, intensity: [1.0; 3] };
        let exact = medium.single_scattering(&ray, &light)[1];
        // What collisions alone would do: their density is σ e^{−σt}, so E[X²] = ∫ f² / density.
        let f = |t: f64| {
            let to = Lamp::POSITION - ray.at(20.0 + t);
            0.8 / (4.0 * PI) * (-sigma * to.length()).exp() / to.length_squared()
        };
        let square = |t: f64| sigma * (-sigma * t).exp() * f(t).powi(2);
        let collisions = adaptive(0.0, 4.0, &square) + adaptive(4.0, 8.0, &square) - exact * exact;
        for method in [
            "kind = \"single-scattering\"\npaths = 1",
            "kind = \"multiple-scattering\"\nmax_order = 1\npaths = 1",
        ] {
            let film = lamp.case(volume_f32([8; 3], vec![1.0; 512]), method).film_of(16);
            let what = format!("sigma {sigma}, height {height}, {}", &method[8..14]);
            // The picture is 10⁻⁶ high: relatively as much of the height, twice.
            let slack = (2.0 * 1e-6 / height + 64.0 * EPS) * exact;
            over_pixels(&film, 1).agrees(&what, exact, family(8), slack);
            let variance = sample_variance(&film).value;
            println!("{what}: variance {variance:.3e}, of collisions {collisions:.3e}, mean {exact:.3e}");
            assert!(variance < 0.1 * collisions, "{what}: {variance} {collisions}");
        }
    }
}

#[test]
fn lamps_in_a_noisy_medium_agree_with_the_quadrature() {
    let lamp = Lamp { sigma: 0.6, height: 0.21 };
    for method in [
        "kind = \"single-scattering\"",
        "kind = \"single-scattering\"\ntransmittance = \"analog\"",
        "kind = \"single-scattering\"\ntransmittance = \"residual-ratio\"",
        "kind = \"multiple-scattering\"\nmax_order = 1\ntransmittance = \"ray-marching\"",
    ] {
        let phase = "[phase]\nkind = \"henyey-greenstein\"\ng = 0.5\n[method]";
        let case = lamp.case(noisy([8; 3], 31), &format!("{method}\n{}", phase.trim_end_matches("[method]")));
        let twin = Twin::new(&case);
        let tracer = twin.tracer();
        let (field, medium) = (case.field(), case.medium());
        let ray = Ray::towards(DVec3::new(4.21, 4.0, -20.0), DVec3::new(4.21, 4.0, 0.0));
        let integrand = |t: f64| {
            let point = ray.at(20.0 + t);
            let to = Lamp::POSITION - point;
            let phase = 0.75 / (4.0 * PI * (1.25 - to.normalize().z).powf(1.5));
            let before = tracer.depth(&ray) - tracer.depth(&Ray { start: 20.0 + t, ..ray });
            let shadow = Ray { origin: point, direction: to.normalize(), start: 0.0 };
            let after = tracer.depth(&shadow) - tracer.depth(&Ray { start: to.length(), ..shadow });
            let sigma = medium.at(field.value(point), 0.0)[3];
            0.8 * sigma * phase * (-before - after).exp() / to.length_squared()
        };
        // Between planes through voxel centres and the lamp the integrand is smooth, but for shadows' cells.
        let cuts: Vec<f64> = (0..=32).map(|i| f64::from(i) * 0.25).collect();
        let nodes = gauss_legendre(12);
        let piece =
            |a: f64, b: f64| nodes.iter().map(|(x, w)| w * (b - a) * integrand(a + x * (b - a))).sum::<f64>();
        let exact: f64 = cuts.windows(2).map(|pair| piece(pair[0], pair[1])).sum();
        let film = case.film_of(64);
        over_pixels(&film, 1).agrees(&method.replace('\n', ", "), exact, family(4), (1e-5 + 1e-4) * exact);
    }
}
