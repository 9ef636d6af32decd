//! Light sampling on the device: densities that integrate to 1 and are those of the samples, means that are closed
//! forms, techniques that share one integral.

mod common;
#[path = "common/lights.rs"]
mod lights;

use common::{EPS, close, report};
use glam::DVec3;
use lights::{
    Extend4, Found, Lit, directions, every_light, float4, hdr, maps, numbers, points, spot, studio, vector,
    within_sigmas,
};
use std::f64::consts::PI;
use svetlo::reference::lights::rectangle_solid_angle;
use svetlo::scene::{Background, EnvironmentSampling, Light};

#[test]
fn densities_of_the_environment_integrate_to_one() {
    let mut maps = maps();
    maps.push(("studio".into(), studio()));
    for (name, map) in maps {
        let lit = Lit::new(Vec::new(), Some(map));
        let (table, sky) = (lit.table(), lit.sky().unwrap());
        assert_eq!(table.environment_pick, 1.0);
        let (width, height) = (sky.map.width, sky.map.height);
        // The density is constant in each texel: two points in each show it.
        let places: Vec<[f64; 2]> = (0..width * height)
            .flat_map(|i| {
                let corner = [(i % width) as f64, (i / width) as f64];
                [[0.3, 0.7], [0.9, 0.2]].map(|d| [corner[0] + d[0], corner[1] + d[1]])
            })
            .collect();
        let pairs: Vec<_> = places.iter().map(|&place| (lit.local.origin, sky.direction(place))).collect();
        let mut sum = 0.0;
        // The table keeps multiples of 2^-24: each texel gives up to one to each that is possible, in its row and
        // among the rows.
        let probabilities = sky.probabilities();
        let of_rows: Vec<f64> = probabilities.chunks(width).map(|row| row.iter().sum()).collect();
        for (i, found) in lit.rays(&pairs, "INFINITY", "1.0f").into_iter().enumerate() {
            let (texel, row) = (i / 2, i / 2 / width);
            let share = f64::from(found.pdf) * sky.solid_angle(row);
            sum += 0.5 * share;
            let units = |n: usize| (n as f64 + 2.0) * EPS;
            let bound = units(width) * of_rows[row] + units(height) + 32.0 * EPS * probabilities[texel];
            close(&name, share, probabilities[texel], bound);
            assert_eq!(share > 0.0, probabilities[texel] > 0.0, "{name}: {texel}");
        }
        close(&name, sum, 1.0, 32.0 * EPS);
    }
}

#[test]
fn directions_fall_where_the_density_says() {
    const COUNT: u32 = 1 << 17;
    for (name, map) in maps() {
        let lit = Lit::new(Vec::new(), Some(map));
        let (table, sky) = (lit.table(), lit.sky().unwrap());
        let (width, height) = (sky.map.width, sky.map.height);
        let pairs: Vec<_> = numbers(COUNT, 4).map(|u| (lit.local.origin, u)).collect();
        // Texels in four parts of equal solid angle.
        let mut counts = vec![0.0; 4 * width * height];
        for found in lit.samples(&pairs) {
            let [x, y] = sky.place(vector(found.direction));
            let (column, row) = ((x as usize).min(width - 1), (y as usize).min(height - 1));
            let middle = sky.place_in_texel([column, row], [0.5, 0.5]);
            let part = 2 * usize::from(y > middle[1]) + usize::from(x > middle[0]);
            counts[4 * (row * width + column) + part] += 1.0;
        }
        let share = |sums: &[f32], i: usize| sums[i] - if i == 0 { 0.0 } else { sums[i - 1] };
        let (mut chi2, mut bins) = (0.0, 0);
        let (mut rare, mut rare_expected) = (0.0, 0.0);
        for (i, count) in counts.into_iter().enumerate() {
            let (x, y) = (i / 4 % width, i / 4 / width);
            let in_row = &table.environment_sums[height + y * width..][..width];
            let probability = f64::from(share(&table.environment_sums[..height], y) * share(in_row, x));
            let expected = 0.25 * probability * f64::from(COUNT);
            if expected < 8.0 {
                rare += count;
                rare_expected += expected;
            } else {
                chi2 += (count - expected).powi(2) / expected;
                bins += 1;
            }
        }
        if rare_expected >= 8.0 {
            chi2 += (rare - rare_expected).powi(2) / rare_expected;
            bins += 1;
        } else {
            // Poisson: five standard deviations and one count.
            assert!(
                rare <= rare_expected + 5.0 * rare_expected.sqrt() + 1.0,
                "{name}: {rare} {rare_expected}"
            );
        }
        // Wilson and Hilferty: the cube root is normal. Five standard deviations.
        let dof = f64::from(bins - 1);
        let spread = 2.0 / (9.0 * dof);
        let z = ((chi2 / dof).cbrt() - (1.0 - spread)) / spread.sqrt();
        report(&format!("{name}: chi² of {dof} degrees, z"), z, 5.0);
        assert!(z.abs() < 5.0, "{name}: {chi2} of {dof}");
    }
}

#[test]
fn means_of_the_weights_are_the_closed_forms() {
    const COUNT: u32 = 1 << 17;
    for (name, map) in maps().into_iter().skip(3).chain([("studio".to_string(), studio())]) {
        let lit = Lit::new(every_light(), Some(map));
        let sky = lit.sky().unwrap().fluence();
        for point in points(&lit.local, 2, 5) {
            let pairs: Vec<_> = numbers(COUNT, 6).map(|u| (point, u)).collect();
            let found = lit.samples(&pairs);
            for c in 0..3 {
                let of_light = |light: &Light| match *light {
                    Light::Point { position, intensity } => intensity[c] / position.distance_squared(point),
                    Light::Directional { irradiance, .. } => irradiance[c],
                    Light::Rectangle { centre, edge_u, edge_v, radiance } => {
                        radiance[c] * rectangle_solid_angle(centre, edge_u, edge_v, point).max(0.0)
                    }
                };
                let exact = sky[c] + lit.lights.iter().map(of_light).sum::<f64>();
                let weights = found.iter().map(|found| f64::from(found.weight[c]));
                within_sigmas(&format!("{name}, channel {c}"), weights, exact);
            }
        }
    }
}

#[test]
fn rays_and_samples_share_a_rectangle() {
    const COUNT: u32 = 1 << 18;
    // With isotropic rays as the second technique, balanced: both together are radiance times solid angle.
    let lit = Lit::new(every_light().split_off(2).into_iter().step_by(3).collect(), None);
    let table = lit.table();
    let is_rectangle = |light: &Light| matches!(light, Light::Rectangle { .. });
    assert!(table.has_rectangles() && lit.lights.iter().all(is_rectangle), "{:?}", lit.lights);
    let phase_pdf = 1.0 / (4.0 * PI);
    for point in points(&lit.local, 3, 7) {
        let solid_angle = |light: &Light| {
            let Light::Rectangle { centre, edge_u, edge_v, .. } = *light else { unreachable!() };
            rectangle_solid_angle(centre, edge_u, edge_v, point).max(0.0)
        };
        let rays: Vec<_> = directions(COUNT, 8).map(|direction| (point, direction)).collect();
        let pairs: Vec<_> = numbers(COUNT, 9).map(|u| (point, u)).collect();
        let seen: f64 = lit.lights.iter().map(solid_angle).sum();
        let whole = lit.rays(&rays, "INFINITY", "-1.0f");
        let hit = |found: &Found| 4.0 * PI * f64::from(u8::from(found.weight[0] > 0.0));
        // No direction meets both of them.
        within_sigmas("solid angle", whole.iter().map(hit), seen);
        let exact: f64 = lit
            .lights
            .iter()
            .map(|light| {
                let Light::Rectangle { radiance, .. } = *light else { unreachable!() };
                radiance[2] * solid_angle(light)
            })
            .sum();
        let radiance = |found: &Found| 4.0 * PI * f64::from(found.weight[2]);
        within_sigmas("rays alone", whole.iter().map(radiance), exact);
        let by_rays = lit.rays(&rays, "INFINITY", &format!("{phase_pdf:.9}f"));
        let by_samples = lit.samples(&pairs).into_iter().map(|found| {
            let pdf = f64::from(found.pdf);
            f64::from(found.weight[2]) * if pdf > 0.0 { pdf / (pdf + phase_pdf) } else { 1.0 }
        });
        let both = by_rays.iter().map(radiance).zip(by_samples).map(|(a, b)| a + b);
        within_sigmas("rays and samples", both, exact);
    }
}

#[test]
fn the_density_of_a_rectangle_integrates_to_one() {
    const COUNT: u32 = 1 << 18;
    let rectangle = every_light()[2];
    let lit = Lit::new(vec![rectangle], None);
    let body = "found.distance = rectangle_distance(lights, a, b, 0.0f);\n\
        found.pdf = isinf(found.distance) ? 0.0f : rectangle_pdf(lights, b, found.distance);";
    for point in points(&lit.local, 4, 10) {
        let pairs: Vec<_> = directions(COUNT, 11)
            .map(|direction| [float4(lit.local.point(point), 0.0), float4(direction, 0.0)])
            .collect();
        let found = lit.probe(body, &pairs);
        within_sigmas("∫ pdf", found.iter().map(|found| 4.0 * PI * f64::from(found.pdf)), 1.0);
    }
}

#[test]
fn rays_and_samples_share_the_sky() {
    const COUNT: u32 = 1 << 17;
    for (name, map) in [("random", hdr(32, 16, 1)), ("spot", spot(16, 8, [5, 3])), ("studio", studio())] {
        let lit = Lit::new(every_light().split_off(4), Some(map));
        let sky = lit.sky().unwrap().fluence();
        let phase_pdf = 1.0 / (4.0 * PI);
        let by_rays = format!(
            "found.weight.xyz = balance({phase_pdf:.9}f, environment_pdf(frame, sums, b))\n\
             * background_radiance(frame, map, b.xyz) / {phase_pdf:.9}f;"
        );
        let rays: Vec<_> =
            directions(COUNT, 14).map(|direction| [[0.0; 4], float4(direction, 0.0)]).collect();
        let by_samples = format!(
            "found = light_sample(frame, lights, sums, map, a, b);\n\
             found.weight *= isinf(found.distance) ? balance(found.pdf, {phase_pdf:.9}f) : 0.0f;"
        );
        let samples: Vec<_> =
            numbers(COUNT, 15).map(|u| [[0.0; 4], u.map(|u| u as f32).extend(0.0)]).collect();
        let (rays, samples) = (lit.probe(&by_rays, &rays), lit.probe(&by_samples, &samples));
        for (c, exact) in sky.into_iter().enumerate() {
            let both =
                rays.iter().zip(&samples).map(|(a, b)| f64::from(a.weight[c]) + f64::from(b.weight[c]));
            within_sigmas(&format!("{name}, channel {c}"), both, exact);
        }
    }
}

#[test]
fn a_sky_that_is_not_sampled_has_no_density() {
    let mut lit = Lit::new(Vec::new(), Some(studio()));
    if let Background::Environment { sampling, .. } = &mut lit.background {
        *sampling = EnvironmentSampling::Escape;
    }
    let rays: Vec<_> = directions(100, 16).map(|direction| (DVec3::ZERO, direction)).collect();
    assert!(lit.rays(&rays, "INFINITY", "1.0f").iter().all(|found| found.pdf == 0.0));
}
