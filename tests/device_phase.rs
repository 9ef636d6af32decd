//! Phase functions on the device: their values are those of the twins, their samples follow them, and directions keep
//! their length.

mod common;

use common::EPS;
use glam::DVec3;
use std::f64::consts::{PI, TAU};
use svetlo::device::{Buffer, Program, ProgramSpec};
use svetlo::reference::phase::*;
use svetlo::reference::random::{philox4x32, uniform};

/// Mean cosines, all exact in float32 once rounded.
const PARAMETERS: [f32; 11] = [0.0, 1e-9, -1e-9, 1e-5, -1e-5, 0.5, -0.5, 0.9, -0.9, 0.999, -0.999];

/// Rounding of a Henyey-Greenstein lobe from an exact cosine: 3/2 of the bracket's 4 errors, square root 6 (3 ulp), division
/// 5 (2.5 ulp), and 7 products and sums.
const LOBE: f64 = 24.0 * EPS;

/// Runs `body` for each input `x`; it puts a float4 into `out[i]`.
fn probe(define: &'static str, body: &str, inputs: &[[f32; 4]]) -> Vec<[f32; 4]> {
    let device = common::device();
    let kernel = format!(
        "__kernel void probe(__global const float4 *in, __global float4 *out, uint count) {{\n\
         size_t i = get_global_id(0);\nif (i >= count) return;\nfloat4 x = in[i];\n{body}\n}}\n"
    );
    let spec = ProgramSpec::new("common/phase.cl").define(define, 1);
    let program = Program::build_probe(&device, &spec, &kernel).unwrap();
    let input = Buffer::from_slice(&device, inputs).unwrap();
    let output = Buffer::<[f32; 4]>::zeroed(&device, inputs.len()).unwrap();
    let arguments = [(&input).into(), (&output).into(), (inputs.len() as u32).into()];
    program.kernel(&device, "probe").unwrap().run(&device, &arguments, inputs.len()).unwrap();
    output.read(&device).unwrap()
}

fn vector(v: [f32; 4]) -> DVec3 {
    DVec3::new(v[0].into(), v[1].into(), v[2].into())
}

/// A float32 vector of unit length to rounding.
fn unit(v: DVec3) -> [f32; 4] {
    let v = v.normalize();
    [v.x as f32, v.y as f32, v.z as f32, 0.0]
}

/// The cosine between unit vectors, as exact near `sign` as float32 directions are.
fn cosine(a: DVec3, b: DVec3, sign: f64) -> f64 {
    sign * (1.0 - 0.5 * (a - sign * b).length_squared())
}

#[test]
fn values_are_those_of_the_twins() {
    let mut cosines = vec![-1.0, -1.0 + 2.0 * EPS as f32, -0.999, 0.0, 0.5, 0.999, 1.0 - EPS as f32, 1.0];
    cosines.extend(common::noise(56, 1).iter().map(|u| (2.0 * u - 1.0) as f32));
    // g0, g1, weight, mu
    let inputs: Vec<[f32; 4]> =
        PARAMETERS.iter().flat_map(|g| cosines.iter().map(move |mu| [*g, 0.1 - 0.8 * g, 0.7, *mu])).collect();
    let body = "struct Phase p = {x.x, x.y, x.z, 0.0f};\nout[i] = (float4)(phase_at(p, cosines(1.0f - x.w, 1.0f + x.w)), 0.0f, 0.0f, 0.0f);";
    type Twin = fn([f64; 4]) -> f64;
    let twins: [(&str, Twin); 4] = [
        ("PHASE_ISOTROPIC", |_| isotropic()),
        ("PHASE_HG", |[g, _, _, mu]| henyey_greenstein(g, mu)),
        ("PHASE_RAYLEIGH", |[.., mu]| rayleigh(mu)),
        ("PHASE_TWO_LOBE", |[g0, g1, weight, mu]| two_lobe([g0, g1], weight, mu)),
    ];
    for (define, twin) in twins {
        for (input, found) in inputs.iter().zip(probe(define, body, &inputs)) {
            let expected = twin(input.map(f64::from));
            // 4: the mixture's.
            let bound = expected * (LOBE + 4.0 * EPS);
            common::close(&format!("{define} {input:?}"), found[0].into(), expected, bound);
        }
    }
}

#[test]
fn values_between_directions_are_exact_at_any_angle() {
    let body = "struct Phase p = {x.w, 0.0f, 0.0f, 0.0f};\nfloat4 a = (float4)(0.48f, -0.6f, 0.64f, 0.0f);\n\
        out[i] = (float4)(phase_between(p, points(a.x, a.y, a.z), points(x.x, x.y, x.z)), 0.0f, 0.0f, 0.0f);";
    let from = DVec3::new(0.48_f32.into(), (-0.6_f32).into(), 0.64_f32.into());
    let aside = DVec3::new(0.8, 0.0, -0.6);
    let mut inputs = Vec::new();
    for g in PARAMETERS {
        for angle in [0.0, 1e-7, 3e-5, 4e-4, 1e-3, 0.03, 0.5, 1.5] {
            for angle in [angle, PI - angle] {
                let mut direction = unit(from * f64::cos(angle) + aside * f64::sin(angle));
                direction[3] = g;
                inputs.push(direction);
            }
        }
    }
    for (input, found) in inputs.iter().zip(probe("PHASE_HG", body, &inputs)) {
        let g = f64::from(input[3]);
        let mu = cosine(from, vector(*input), if g < 0.0 { -1.0 } else { 1.0 });
        let expected = henyey_greenstein(g, mu);
        // 1.5 times the 4 of the squared length.
        common::close(&format!("{input:?}"), found[0].into(), expected, expected * (LOBE + 6.0 * EPS));
    }
}

/// A phase function, what its samples must be like, and how steep it is.
struct Sampled {
    define: &'static str,
    parameters: [f32; 3],
    value: Box<dyn Fn(f64) -> f64>,
    below: Box<dyn Fn(f64) -> f64>,
    mean: f64,
    mean_square: f64,
    /// Largest d ln f / dθ.
    steepness: f64,
}

fn lobe(g: f32) -> Sampled {
    let g64 = f64::from(g);
    Sampled {
        define: "PHASE_HG",
        parameters: [g, 0.0, 0.0],
        value: Box::new(move |mu| henyey_greenstein(g64, mu)),
        below: Box::new(move |mu| henyey_greenstein_below(g64, mu)),
        mean: g64,
        mean_square: (1.0 + 2.0 * g64 * g64) / 3.0,
        steepness: 1.5 / (1.0 - g64.abs()),
    }
}

fn two_lobes(g: [f32; 2], weight: f32) -> Sampled {
    let ([a, b], w) = (g.map(f64::from), f64::from(weight));
    Sampled {
        define: "PHASE_TWO_LOBE",
        parameters: [g[0], g[1], weight],
        value: Box::new(move |mu| two_lobe([a, b], w, mu)),
        below: Box::new(move |mu| {
            w * henyey_greenstein_below(a, mu) + (1.0 - w) * henyey_greenstein_below(b, mu)
        }),
        mean: w * a + (1.0 - w) * b,
        mean_square: (1.0 + 2.0 * (w * a * a + (1.0 - w) * b * b)) / 3.0,
        steepness: 1.5 / (1.0 - a.abs().max(b.abs())),
    }
}

fn phases() -> Vec<Sampled> {
    let mut phases: Vec<_> = PARAMETERS.into_iter().map(lobe).collect();
    phases.push(two_lobes([0.9, -0.6], 0.7));
    phases.push(two_lobes([0.5, 0.99], 0.0));
    phases.push(two_lobes([-0.9, 0.2], 1.0));
    phases.push(Sampled {
        define: "PHASE_RAYLEIGH",
        value: Box::new(rayleigh),
        below: Box::new(rayleigh_below),
        mean_square: 0.4,
        // |sin 2θ| / (1 + cos²θ)
        steepness: 1.0,
        ..lobe(0.0)
    });
    phases.push(Sampled { define: "PHASE_ISOTROPIC", ..lobe(0.0) });
    phases
}

/// Poles, a negative zero, axes and others.
const DIRECTIONS: [[f64; 3]; 8] = [
    [0.0, 0.0, 1.0],
    [0.0, 0.0, -1.0],
    [1.0, 0.0, -0.0],
    [0.0, -1.0, 0.0],
    [0.3, -0.5, 0.7],
    [-0.3, 0.5, -0.7],
    [1e-4, 1e-5, -1.0],
    [0.6, 0.7, 1e-6],
];

/// Samples as many that the bins of the tests hold 16384 each.
const SAMPLES: u32 = 1 << 20;

/// How far the counts of 64 equally likely bins are from their mean: the chi-square with 63 degrees of freedom must be
/// within k = 5 of its sigma.
fn assert_uniform(what: &str, counts: &[u32; 64]) {
    let expected = f64::from(SAMPLES) / 64.0;
    let chi_square: f64 = counts.iter().map(|n| (f64::from(*n) - expected).powi(2) / expected).sum();
    assert!((chi_square - 63.0).abs() < 5.0 * f64::sqrt(126.0), "{what}: chi-square {chi_square}");
}

#[test]
fn samples_follow_their_functions() {
    let words: Vec<[u32; 4]> = (0..SAMPLES).map(|i| philox4x32([i, 0, 0, 0], [17, 0])).collect();
    let points = words.iter().map(|w| [uniform(w[0]) as f32, uniform(w[1]) as f32, 0.0, 0.0]);
    // Of the ends of the unit square, too.
    let last = 1.0 - EPS as f32;
    let ends =
        [[0.0, 0.0], [0.0, last], [last, 0.0], [last, last], [0.5, 0.5]].map(|[x, y]| [x, y, 0.0, 0.0]);
    let points: Vec<[f32; 4]> = points.chain(ends).collect();
    let body = "struct Phase p = {in[1].x, in[1].y, in[1].z, 0.0f};\nfloat pdf;\n\
        struct Points d = phase_sample(p, points(in[0].x, in[0].y, in[0].z), x.x, x.y, &pdf);\n\
        out[i] = (float4)(d.x, d.y, d.z, pdf);";
    for (number, phase) in phases().iter().enumerate() {
        let from = unit(DVec3::from(DIRECTIONS[number % DIRECTIONS.len()]));
        let [g0, g1, weight] = phase.parameters;
        let inputs = [&[from, [g0, g1, weight, 0.0]], points.as_slice()].concat();
        let found = probe(phase.define, body, &inputs);
        check(&format!("{} {:?}", phase.define, phase.parameters), phase, vector(from), &found[2..]);
    }
}

fn check(what: &str, phase: &Sampled, from: DVec3, found: &[[f32; 4]]) {
    let from = from.normalize();
    let (a, b) = from.any_orthonormal_pair();
    let (mut by_probability, mut by_azimuth, mut sum) = ([0_u32; 64], [0_u32; 64], 0.0);
    for (number, sample) in found.iter().enumerate() {
        let direction = vector(*sample);
        // 4 units in the last place of 1.
        common::close(what, direction.length(), 1.0, 8.0 * EPS);
        assert_eq!(sample[3].to_bits() >> 31, 0, "{what}: a negative density");
        let mu = cosine(from, direction.normalize(), from.dot(direction).signum());
        let value = (phase.value)(mu);
        // The direction is right to 6 roundings; LOBE, and 3/2 of the 8 of the pair (1 - mu, 1 + mu).
        let bound = value * (LOBE + EPS * (12.0 + 6.0 * phase.steepness))
            + value * (6.0 * EPS * phase.steepness).powi(2);
        common::close(what, sample[3].into(), value, bound);
        if number < SAMPLES as usize {
            by_probability[((phase.below)(mu) * 64.0).min(63.0) as usize] += 1;
            let turns = direction.dot(a).atan2(direction.dot(b)) / TAU + 0.5;
            by_azimuth[(turns * 64.0).min(63.0) as usize] += 1;
            sum += mu;
        }
    }
    assert_uniform(&format!("{what}: cosine"), &by_probability);
    assert_uniform(&format!("{what}: azimuth"), &by_azimuth);
    let count = f64::from(SAMPLES);
    let sigma = f64::sqrt((phase.mean_square - phase.mean.powi(2)) / count);
    // k = 4; numbers u of 24 bits are 2^-25 too low on average, which moves the mean by no more than twice that.
    common::close(&format!("{what}: mean"), sum / count, phase.mean, 4.0 * sigma + EPS);
}

#[test]
fn directions_keep_their_length_over_many_turns() {
    // Inputs are a direction and g; each goes through 100 rounds of 1000 scatterings.
    let mut paths: Vec<[f32; 4]> = PARAMETERS.iter().map(|g| [0.36, -0.48, 0.8, *g]).collect();
    let body = "struct Phase p = {x.w, 0.0f, 0.0f, 0.0f};\nstruct Points d = points(x.x, x.y, x.z);\nfloat pdf;\n\
        uint a = as_uint(x.x) * 3u + as_uint(x.y) * 5u + as_uint(x.z);\n\
        for (int n = 0; n < 1000; ++n) {\n\
        a = a * 1664525u + 1013904223u;\nuint b = a * 1664525u + 1013904223u;\n\
        d = phase_sample(p, d, (float)(a >> 8) * 0x1p-24f, (float)(b >> 8) * 0x1p-24f, &pdf);\na = b;\n}\n\
        out[i] = (float4)(d.x, d.y, d.z, x.w);";
    for round in 0..100 {
        paths = probe("PHASE_HG", body, &paths);
        for path in &paths {
            common::close(&format!("round {round}, g = {}", path[3]), vector(*path).length(), 1.0, 8.0 * EPS);
        }
    }
}

#[test]
fn the_unit_circle_is_that_of_the_angle() {
    let mut numbers: Vec<u32> =
        (0..1 << 20).map(|i| i << 4 | philox4x32([i, 0, 0, 0], [1, 0])[0] & 15).collect();
    for eighth in 1..=8_u32 {
        numbers.extend([(eighth << 21) - 1, ((eighth << 21) + 1).min((1 << 24) - 1), (eighth - 1) << 21]);
    }
    let inputs: Vec<[f32; 4]> = numbers.iter().map(|n| [*n as f32 * EPS as f32, 0.0, 0.0, 0.0]).collect();
    let body = "float cosine, sine;\nunit_circle(x.x, &cosine, &sine);\nout[i] = (float4)(cosine, sine, 0.0f, 0.0f);";
    // Half an ulp below 1, EPS / 2, of the result, and less for each of two coefficients and two sums before it, which
    // count a half to a quarter: 1.5 EPS = 9e-8 in all.
    let mut worst: f64 = 0.0;
    for (input, [c, s, ..]) in inputs.iter().zip(probe("PHASE_ISOTROPIC", body, &inputs)) {
        let (sine, cosine) = (TAU * f64::from(input[0])).sin_cos();
        for (found, expected) in [(c, cosine), (s, sine)] {
            let error = (f64::from(found) - expected).abs();
            assert!(error < 1e-7, "u = {}: {found}, expected {expected}", input[0]);
            worst = worst.max(error);
        }
    }
    common::report("cosine and sine", worst, 1e-7);
}
