//! Checks of the smallest parts: shared structs, random numbers, the film's sums.

use super::workbench::{EPS, Measurement, Workbench, maximum};
use crate::Result;
use crate::device::{Buffer, Device, ProgramSpec, layout};
use crate::film::FilmPixel;
use crate::reference::film::mean_and_variance;
use crate::reference::random::{KNOWN_ANSWERS, KNOWN_ANSWERS_2X32, exponential, philox4x32};
use crate::render::LAYOUTS;
use bytemuck::Zeroable;

/// Structs, each with its size and the offsets of its fields.
pub fn layout(bench: &Workbench) -> Result<Vec<Measurement>> {
    // The first number that differs is an error that names it.
    layout::probe(&Device::open(&bench.info)?, LAYOUTS)?;
    let numbers: usize = LAYOUTS.iter().map(|layout| 1 + layout.fields.len()).sum();
    Ok(vec![Measurement::exact(format!("sizes and offsets that differ, of {numbers}"), 0.0, 0.0)])
}

/// Both counter-based generators, for one path and for many side by side, and the exponential numbers made of them.
pub fn random(bench: &Workbench) -> Result<Vec<Measurement>> {
    let scalar = bench.map(
        ProgramSpec::new("common/rng.cl"),
        "out[i] = philox4x32(x.lo, x.hi.lo);",
        &philox_inputs(),
    )?;
    let width = bench.info.vector_width.clamp(1, 16);
    let width = if width < 4 { 1 } else { 1 << width.ilog2() };
    let lanes = |entry| ProgramSpec::new(entry).define("WIDTH", width);
    let four = bench.map(
        lanes("common/random_lanes.cl"),
        "Words w[4] = {(Words)(x.s0), (Words)(x.s1), (Words)(x.s2), (Words)(x.s3)};\nphilox_lanes(w, x.s45);\n\
         WordLanes a, b, c, d;\na.all = w[0]; b.all = w[1]; c.all = w[2]; d.all = w[3];\n\
         int k = (int)(i % WIDTH);\nout[i] = (uint4)(a.lane[k], b.lane[k], c.lane[k], d.lane[k]);",
        &philox_inputs(),
    )?;
    let two = bench.map(
        lanes("common/random_lanes.cl"),
        "Words w[2] = {(Words)(x.s0), (Words)(x.s1)};\nphilox2_lanes(w, (Words)(x.s2));\n\
         WordLanes a, b;\na.all = w[0]; b.all = w[1];\nint k = (int)(i % WIDTH);\n\
         out[i] = (uint4)(a.lane[k], b.lane[k], 0u, 0u);",
        &KNOWN_ANSWERS_2X32.map(|([a, b], key, _)| [a, b, key, 0, 0, 0, 0, 0]),
    )?;
    let two_wrong =
        two.iter().zip(&KNOWN_ANSWERS_2X32).filter(|(found, (.., right))| found[..2] != right[..]);
    Ok(vec![
        wrong_blocks("Philox4x32-7: blocks that are wrong", &scalar),
        wrong_blocks(&format!("the same on {width} lanes"), &four),
        Measurement::exact(
            format!("Philox2x32-7 on {width} lanes: wrong, of 3 published"),
            two_wrong.count() as f64,
            0.0,
        ),
        exponentials(bench, lanes("common/exponential.cl"))?,
    ])
}

/// The published counters and keys, then others whose answers the twin knows.
fn philox_inputs() -> Vec<[u32; 8]> {
    let published = KNOWN_ANSWERS.into_iter().map(|(counter, key, _)| (counter, key));
    let others = (0..1021_u32).map(|i| ([i, i.wrapping_mul(77_777_777), !i, i ^ 5], [i << 7, 1]));
    published.chain(others).map(|([a, b, c, d], [e, f])| [a, b, c, d, e, f, 0, 0]).collect()
}

fn wrong_blocks(what: &str, found: &[[u32; 4]]) -> Measurement {
    let published = KNOWN_ANSWERS.iter().map(|(.., answer)| *answer);
    let others = philox_inputs()
        .into_iter()
        .skip(KNOWN_ANSWERS.len())
        .map(|[a, b, c, d, e, f, ..]| philox4x32([a, b, c, d], [e, f]));
    let wrong = published.chain(others).zip(found).filter(|(right, found)| right != *found).count();
    Measurement::exact(format!("{what}, of 3 published and {}", found.len() - 3), wrong as f64, 0.0)
}

fn exponentials(bench: &Workbench, spec: ProgramSpec) -> Result<Measurement> {
    let words: Vec<u32> =
        (0..1 << 14).map(|i| philox4x32([i, 0, 0, 0], [23, 0])[0]).chain([0, u32::MAX]).collect();
    let inputs: Vec<[u32; 8]> = words.iter().map(|&word| [word; 8]).collect();
    let body = "RealLanes e = real_lanes(exponential_lanes((Words)(x.s0)));\n\
                out[i] = (uint4)(as_uint(e.lane[i % WIDTH]), 0u, 0u, 0u);";
    let found = bench.map(spec, body, &inputs)?;
    let error = |(word, found): (&u32, &[u32; 4])| {
        let exact = exponential(*word);
        (f64::from(f32::from_bits(found[0])) - exact).abs() / exact.max(f64::MIN_POSITIVE)
    };
    let worst = words.iter().zip(&found).map(error).fold(0.0, maximum);
    Ok(Measurement::within(
        "exponential numbers: largest relative error",
        worst,
        0.0,
        3e-7,
        "5 roundings of 6e-8",
    ))
}

/// Two values in turn, added one by one: a float32 sum stalls or drifts.
pub fn film(bench: &Workbench) -> Result<Vec<Measurement>> {
    const COUNT: usize = 1 << 14;
    const LAUNCHES: usize = 8;
    let samples: Vec<[f32; 4]> =
        (0..COUNT).map(|i| [if i % 2 == 0 { 0.1 } else { 0.3 }, 123.456, -1e-4, 1.0]).collect();
    let device = Device::open(&bench.info)?;
    let kernel = "__kernel void probe(__global const float4 *samples, __global struct FilmPixel *film, uint count) {\n\
         if (get_global_id(0) != 0) return;\nstruct FilmPixel pixel = film[0];\n\
         for (uint i = 0; i < count; ++i) film_add(&pixel, samples[i], -1.0f, 3u);\nfilm[0] = pixel;\n}\n";
    let program = bench.probe(&device, ProgramSpec::new("film/accumulate.cl"), kernel)?;
    let mut kernel = program.kernel(&device, "probe")?;
    let samples_buffer = Buffer::from_slice(&device, &samples)?;
    let film = Buffer::from_slice(&device, &[FilmPixel::zeroed()])?;
    for _ in 0..LAUNCHES {
        kernel.run(&device, &[(&samples_buffer).into(), (&film).into(), (COUNT as u32).into()], 1)?;
    }
    let pixel = film.read(&device)?[0];
    let values: Vec<f64> =
        (0..LAUNCHES).flat_map(|_| samples.iter().map(|sample| f64::from(sample[0]))).collect();
    let (mean, variance) = mean_and_variance(&values);
    let still = (1..4).map(|c| (pixel.mean()[c] - f64::from(samples[0][c])).abs()).fold(0.0, maximum);
    let found = pixel.variance().unwrap_or([f64::NAN; 4]);
    Ok(vec![
        Measurement::within(
            format!("mean of {} samples", values.len()),
            pixel.mean()[0],
            mean,
            8.0 * EPS * 0.1,
            "8 roundings of the samples' spread",
        ),
        Measurement::within("their variance", found[0], variance, 8.0 * EPS * variance, "8 roundings"),
        Measurement::within(
            "means of equal samples: largest error",
            still,
            0.0,
            8.0 * EPS * 123.456 / values.len() as f64,
            "8 roundings of the first, over their number",
        ),
    ])
}
