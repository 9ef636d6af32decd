//! Reflection and refraction on the device: Snell's law and Fresnel's equations against the twin and published values,
//! and the angles and indices where numbers could break.

mod common;
#[path = "common/probe.rs"]
mod probe;

use common::{EPS, close, largest, noise, report};
use glam::DVec3;
use probe::probe;
use serde_json::Value;
use svetlo::reference::optics::{boundary, cauchy, fresnel};

const FILE: &str = "surfaces/optics.cl";
const INDICES: [f32; 11] =
    [1.5, 1.33, 2.42, 4.0, 1.001, 1.00001, 0.99999, 0.75, 0.4, 1.0 + EPS as f32 * 2.0, 1.25];

fn truths() -> Value {
    serde_json::from_str(include_str!("truths.json")).unwrap()
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("truths.json lacks {key}"))
}

fn vector(v: [f32; 4]) -> DVec3 {
    DVec3::new(v[0].into(), v[1].into(), v[2].into())
}

/// Reflectances for (index, inside, cosine).
fn reflectances(inputs: &[(f32, bool, f32)]) -> Vec<f64> {
    let inputs: Vec<_> = inputs.iter().map(|&(n, inside, c)| [[n, f32::from(inside), c, 0.0]]).collect();
    let body =
        "struct Boundary b = boundary(x[0].x, x[0].y > 0.5f, x[0].z);\ny[0] = (float4)(b.reflectance);";
    probe::<1, 1>(FILE, body, &inputs).iter().map(|[y]| f64::from(y[0])).collect()
}

fn exact(index: f32, inside: bool, cosine: f64) -> f64 {
    let n = f64::from(index);
    if inside { fresnel(n, 1.0, cosine) } else { fresnel(1.0, n, cosine) }
}

#[test]
fn reflectances_are_those_of_the_twin() {
    let mut cosines = vec![0.0, 1e-30, 1e-7, 1e-4, 0.6, 0.745_356, 1.0 - EPS as f32, 1.0];
    cosines.extend(noise(200, 1).iter().map(|u| *u as f32));
    cosines.extend(noise(50, 2).iter().map(|u| (1e-3 * u) as f32));
    let each = |n: &f32| cosines.iter().flat_map(|c| [(*n, false, *c), (*n, true, *c)]).collect::<Vec<_>>();
    let inputs: Vec<_> = INDICES.iter().flat_map(each).collect();
    let mut errors = Vec::new();
    for (&(n, inside, c), found) in inputs.iter().zip(reflectances(&inputs)) {
        // n - 1 is exact. Its product with n + 1 and the square beside it err by 3 roundings, which is as if the cosine
        // did by 2; the rest are some 16 operations, none of which cancels, and a square root (3 ulp), squared.
        let c = f64::from(c);
        let expected = exact(n, inside, c);
        let near =
            [1.0 - 4.0 * EPS, 1.0 + 4.0 * EPS].map(|f| (exact(n, inside, (c * f).min(1.0)) - expected).abs());
        let bound = 48.0 * EPS * expected + near[0].max(near[1]);
        close(&format!("n = {n}, inside: {inside}, cosine {c}"), found, expected, bound);
        errors.push((found - expected).abs() / bound.max(1e-30));
    }
    report("reflectances, of their bound", largest(errors), 1.0);
}

#[test]
fn edges_of_the_range() {
    let found = reflectances(&[
        (1.0, false, 0.3),
        (1.0, true, 0.3),
        (1.0, true, 0.0),
        (1.0, false, 0.0),
        (1.5, false, 0.0),
        (1.5, true, 0.0),
        (0.5, false, 0.0),
        (0.5, true, 0.0),
    ]);
    assert_eq!(found, [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]);
    // The critical angle of 1.25 has the cosine 0.6, and so does that of 0.8 from outside. There dR/dc is infinite: the
    // root of 2 n^2 c EPS, times 4 n for the slope of the reflectance in the cosine of what passes, squared amplitudes.
    for (index, inside) in [(1.25, true), (0.8, false)] {
        let [at, below, above] = [0.6_f32, 0.6 * (1.0 - 8.0 * EPS as f32), 0.6 * (1.0 + 1e-3)]
            .map(|c| reflectances(&[(index, inside, c)])[0]);
        close("at the critical angle", at, 1.0, 8.0 * (4.0 * EPS).sqrt());
        assert_eq!(below, 1.0, "totally reflected");
        assert!(above < 0.9, "{above}");
    }
}

#[test]
fn surfaces_of_glass_let_pass_what_is_published() {
    let truths = truths();
    for row in truths["glass_slab"]["oblique"].as_array().unwrap() {
        let cosine = number(row, "deg").to_radians().cos();
        let inner = (1.0 - (1.0 - cosine * cosine) / 2.25).sqrt();
        let found = reflectances(&[(1.5, false, cosine as f32), (1.5, true, inner as f32)]);
        // Cosines are rounded: dT/dc is 2.2 at 75 degrees, 4.8 inside; the rest as above.
        for reflected in &found {
            close("T_surf", 1.0 - reflected, number(row, "T_surf"), 8.0 * EPS);
        }
        close("T2_unpol", (1.0 - found[0]) * (1.0 - found[1]), number(row, "T2_unpol"), 12.0 * EPS);
    }
}

/// Directions as (refracted and reflectance, reflected and whether the ray is inside).
const TURN: &str = "float3 d = x[0].xyz;\nfloat3 n = x[1].xyz;\nbool inside = dot(d, n) > 0.0f;\n\
    float3 facing = inside ? -n : n;\nstruct Boundary b = boundary(x[0].w, inside, -dot(d, facing));\n\
    float3 passed = b.reflectance < 1.0f ? refracted(b, d, facing) : (float3)(0.0f);\n\
    y[0] = (float4)(passed, b.reflectance);\ny[1] = (float4)(mirrored(d, n), inside ? 1.0f : 0.0f);";

#[test]
fn directions_are_those_of_the_twin_and_keep_the_energy() {
    let u = noise(8 * 400, 3);
    let direction = |i: usize| {
        let (z, phi) = (2.0 * u[i] - 1.0, std::f64::consts::TAU * u[i + 1]);
        DVec3::new((1.0 - z * z).sqrt() * phi.cos(), (1.0 - z * z).sqrt() * phi.sin(), z)
    };
    let mut pairs: Vec<(DVec3, DVec3)> = (0..400).map(|i| (direction(8 * i), direction(8 * i + 2))).collect();
    // Upright, from both sides; grazing.
    pairs.extend(pairs.clone().iter().take(20).flat_map(|(d, _)| [(*d, *d), (*d, -*d)]));
    let grazing = |(d, n): &(DVec3, DVec3)| ((*d - d.dot(*n) * *n + 1e-4 * *n).normalize(), *n);
    pairs.extend(pairs.clone().iter().take(100).map(grazing));
    let single = |v: DVec3, w: f32| [v.x as f32, v.y as f32, v.z as f32, w];
    let inputs: Vec<[[f32; 4]; 2]> =
        INDICES.iter().flat_map(|n| pairs.iter().map(|(d, m)| [single(*d, *n), single(*m, 0.0)])).collect();
    let (mut worst, mut energy): (f64, f64) = (0.0, 0.0);
    for (&[ray, normal], [passed, back]) in inputs.iter().zip(probe::<2, 2>(FILE, TURN, &inputs)) {
        let (d, m, n) = (vector(ray).normalize(), vector(normal).normalize(), f64::from(ray[3]));
        let exact = boundary(n, d, m);
        let what = format!("n = {n}, direction {d}, normal {m}");
        // Directions are of unit length within 2 EPS, their product errs by 6 EPS more; it turns what is reflected twice.
        close(&what, vector(back).distance(exact.reflected), 0.0, 24.0 * EPS);
        let cosine = d.dot(m).abs();
        let eta = if d.dot(m) > 0.0 { n } else { 1.0 / n };
        let beyond = |c: f64| (1.0 - eta * eta * (1.0 - c * c)).max(0.0).sqrt();
        let spread = beyond((cosine + 8.0 * EPS).min(1.0)) - beyond((cosine - 8.0 * EPS).max(0.0));
        match exact.refracted {
            Some(refracted) if passed[3] < 1.0 => {
                let bound = spread + 32.0 * EPS * eta.max(1.0);
                close(&what, vector(passed).distance(refracted), 0.0, bound);
                worst = worst.max(vector(passed).distance(refracted) / bound);
                // What passes by Fresnel's amplitudes t, for the direction that was found.
                let outgoing = vector(passed).dot(m).abs();
                let [ts, tp] =
                    [2.0 * cosine / (cosine + outgoing / eta), 2.0 * cosine / (cosine / eta + outgoing)];
                let through = 0.5 * outgoing * (ts * ts + tp * tp) / (eta * cosine);
                let slack =
                    4.0 * (spread + 40.0 * EPS) / (cosine + outgoing / eta).min(cosine / eta + outgoing);
                close(&format!("energy, {what}"), f64::from(passed[3]) + through, 1.0, slack);
                energy = energy.max((f64::from(passed[3]) + through - 1.0).abs() / slack);
            }
            // Which it is may turn within rounding of the critical angle.
            _ => assert!(passed[3] == 1.0 && (exact.refracted.is_none() || spread > 1e-4), "{what}"),
        }
    }
    report("refracted directions, of their bound", worst, 1.0);
    report("R + T, of its bound", energy, 1.0);
}

#[test]
fn a_sphere_of_glass_bends_rays_as_published() {
    // Through a unit sphere around the origin, at height x[0].x along z.
    let body = "float h = x[0].x;\nfloat3 d = (float3)(0.0f, 0.0f, 1.0f);\n\
        float3 n = (float3)(h, 0.0f, -sqrt((1.0f - h) * (1.0f + h)));\n\
        struct Boundary b = boundary(1.5f, false, -dot(d, n));\nfloat through = 1.0f - b.reflectance;\n\
        d = refracted(b, d, n);\nn -= 2.0f * dot(d, n) * d;\n\
        b = boundary(1.5f, true, dot(d, n));\nthrough *= 1.0f - b.reflectance;\n\
        d = refracted(b, d, -n);\ny[0] = (float4)(d, through);\ny[1] = (float4)(n, 0.0f);";
    let truths = truths();
    let rows = truths["glass_sphere"]["rays"].as_array().unwrap();
    let inputs: Vec<[[f32; 4]; 1]> =
        rows.iter().map(|row| [[number(row, "h") as f32, 0.0, 0.0, 0.0]]).collect();
    for (row, [direction, point]) in rows.iter().zip(probe::<1, 2>(FILE, body, &inputs)) {
        let (d, p) = (vector(direction), vector(point));
        // Two refractions, each with a cosine within 8 EPS and a slope of the angle in it below 3.
        let bound = 64.0 * EPS;
        close("deviation", (-d.x).atan2(d.z), number(row, "deviation_deg").to_radians(), bound);
        // Over the slope of the ray, 0.07 at least.
        close("crossing", p.z - p.x * d.z / d.x, number(row, "crossing"), bound / d.x.abs() * 2.0);
        close("through", direction[3].into(), number(row, "T2_unpol"), bound);
    }
}

#[test]
fn indices_follow_cauchy() {
    let coefficients = [1.5046_f32, 0.0042, 1e-4];
    let inputs: Vec<[[f32; 4]; 2]> = (0..=35)
        .map(|i| {
            [
                [coefficients[0], coefficients[1], coefficients[2], 0.0],
                [0.38 + 0.01 * i as f32, 0.0, 0.0, 0.0],
            ]
        })
        .collect();
    for ([_, wavelength], [found]) in
        inputs.iter().zip(probe::<2, 1>(FILE, "y[0] = (float4)(index_at(x[0], x[1].x));", &inputs))
    {
        let expected = cauchy(coefficients.map(f64::from), wavelength[0].into());
        close("index", found[0].into(), expected, 3.0 * EPS * expected);
    }
}

#[test]
fn directions_survive_packing() {
    let mut directions: Vec<DVec3> = noise(3 * 20_000, 5)
        .chunks(3)
        .map(|u| (2.0 * DVec3::new(u[0], u[1], u[2]) - DVec3::ONE).normalize())
        .collect();
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    directions.extend(axes.iter().flat_map(|a| [*a, -*a]));
    directions.extend(axes.iter().flat_map(|a| axes.map(|b| (*a - b).normalize_or(*a))));
    let inputs: Vec<[[f32; 4]; 1]> =
        directions.iter().map(|d| [[d.x as f32, d.y as f32, d.z as f32, 0.0]]).collect();
    let body = "y[0] = (float4)(unpack_direction(pack_direction(x[0].xyz)), 0.0f);";
    let found = probe::<1, 1>("common/octahedron.cl", body, &inputs);
    // Half a step of 1 / 32767 per side, a diagonal of 2.2e-5 on the octahedron, of which the sphere sees up to 3 times.
    let errors: Vec<f64> = directions.iter().zip(&found).map(|(d, [f])| vector(*f).distance(*d)).collect();
    report("packed directions", largest(errors.iter().copied()), 7e-5);
    assert!(largest(errors) < 7e-5);
    for (axis, [found]) in directions[20_000..20_006].iter().zip(&found[20_000..]) {
        assert_eq!(vector(*found), *axis, "axes are exact");
    }
}
