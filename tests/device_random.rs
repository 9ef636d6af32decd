//! Random numbers on the device are those of the twins, bit for bit.

mod common;

use svetlo::device::{Buffer, Program, ProgramSpec};
use svetlo::reference::random::{KNOWN_ANSWERS, exponential, path_block, philox4x32, uniform};
use svetlo::reference::sobol;

/// Runs a probe kernel that maps each `[u32; 8]` to four words.
fn words(entry: &'static str, body: &str, inputs: &[[u32; 8]]) -> Vec<[u32; 4]> {
    let device = common::device();
    let kernel = format!(
        "__kernel void probe(__global const uint8 *in, __global uint4 *out, uint count) {{\n\
         size_t i = get_global_id(0);\nif (i >= count) return;\nuint8 x = in[i];\n{body}\n}}\n"
    );
    let program = Program::build_probe(&device, &ProgramSpec::new(entry), &kernel).unwrap();
    let input = Buffer::from_slice(&device, inputs).unwrap();
    let output = Buffer::<[u32; 4]>::zeroed(&device, inputs.len()).unwrap();
    let arguments = [(&input).into(), (&output).into(), (inputs.len() as u32).into()];
    program.kernel(&device, "probe").unwrap().run(&device, &arguments, inputs.len()).unwrap();
    output.read(&device).unwrap()
}

fn joined(counter: [u32; 4], key: [u32; 2]) -> [u32; 8] {
    let [a, b, c, d] = counter;
    [a, b, c, d, key[0], key[1], 0, 0]
}

#[test]
fn philox_gives_the_published_answers_and_those_of_the_twin() {
    let mut inputs: Vec<_> = KNOWN_ANSWERS.iter().map(|(counter, key, _)| joined(*counter, *key)).collect();
    let mut expected: Vec<_> = KNOWN_ANSWERS.iter().map(|(.., output)| *output).collect();
    for i in 0..1000_u32 {
        let (counter, key) = ([i, i.wrapping_mul(77_777_777), !i, i ^ 5], [i << 7, 1]);
        inputs.push(joined(counter, key));
        expected.push(philox4x32(counter, key));
    }
    assert_eq!(words("common/rng.cl", "out[i] = philox4x32(x.lo, x.hi.lo);", &inputs), expected);
}

#[test]
fn uniform_numbers_keep_24_bits_and_stay_below_one() {
    let inputs: Vec<_> = [0, 255, 256, 0x8000_0000, 0xffff_ff00, u32::MAX].map(|w| [w; 8]).to_vec();
    let found =
        words("common/rng.cl", "out[i] = (uint4)(as_uint(uniform_float(x.s0)), 0u, 0u, 0u);", &inputs);
    for (input, output) in inputs.iter().zip(found) {
        assert_eq!(f64::from(f32::from_bits(output[0])), uniform(input[0]));
        assert!(f32::from_bits(output[0]) < 1.0);
    }
}

#[test]
fn scrambled_sobol_points_are_those_of_the_twin() {
    let samples = (0..300).chain([1 << 16, (1 << 24) + 1, 999_999_999, u32::MAX]);
    let inputs: Vec<[u32; 8]> = samples
        .map(|sample| {
            let [a, b, c, d] = philox4x32([sample % 7, 0, 0, 0], [11, 0]);
            [sample, a, b, c, d, 0, 0, 0]
        })
        .collect();
    for first in [0, 2, 4, 6] {
        let body = format!(
            "float2 a = sobol_pair(x.s0, (uint4)(x.s1, x.s2, x.s3, x.s4), {first});\n\
             out[i] = (uint4)(as_uint(a.x), as_uint(a.y), 0u, 0u);"
        );
        for (input, output) in inputs.iter().zip(words("common/sobol.cl", &body, &inputs)) {
            let twin = sobol::pair(input[0], [input[1], input[2], input[3], input[4]], first);
            for (bits, word) in output.into_iter().zip(twin) {
                let found = f64::from(f32::from_bits(bits));
                assert_eq!(found, uniform(word), "sample {}, dimension {first}", input[0]);
            }
        }
    }
}

#[test]
fn a_path_has_its_own_words_block_by_block() {
    let inputs: Vec<[u32; 8]> =
        (0..500_u32).map(|i| [i << 20, i % 7, i, i % 64, i * 12_345, i % 5, 0, 0]).collect();
    let body = "struct Stream stream = stream_start(x.s45, x.s1, x.s2, x.s3);\nuint4 words;\n\
        for (uint n = 0u; n <= x.s5; ++n) {\nwords = stream_block(&stream);\n}\nout[i] = words;";
    for (input, output) in inputs.iter().zip(words("common/stream.cl", body, &inputs)) {
        let [_, pixel, sample, path, seed, block, ..] = *input;
        // The key is (x.s4, x.s5).
        assert_eq!(output, path_block([seed, block], pixel, sample, path, block));
    }
}

/// The device's exponential numbers of these words.
fn exponentials(bits: &[u32]) -> Vec<f64> {
    let inputs: Vec<[u32; 8]> = bits.iter().map(|bits| [*bits; 8]).collect();
    let body = "out[i] = (uint4)(as_uint(exponential_lanes(x.s0)), 0u, 0u, 0u);";
    let found = words("common/exponential.cl", body, &inputs);
    found.iter().map(|words| f32::from_bits(words[0]).into()).collect()
}

#[test]
fn exponential_numbers_are_those_of_the_twin_for_all_magnitudes() {
    let mut bits: Vec<u32> = (0..1_000_000).map(|i| philox4x32([i, 0, 0, 0], [23, 0])[0]).collect();
    for exponent in 0..32 {
        // Around powers of two, around the ends of the reduced interval, and the same distances from 1.
        for centre in [1_u32 << exponent, (f64::sqrt(0.5) * f64::from(1_u32 << exponent)) as u32] {
            for offset in 0..5 {
                let near = centre.wrapping_add(offset).wrapping_sub(3);
                bits.extend([near, !near]);
            }
        }
    }
    // At most 5 roundings of the result's size, of 6e-8 each: those of f, of its polynomial (less, times f), of ln(1 + f), of
    // k ln 2 and of the result. The polynomial's own error is 3e-8.
    let mut worst: f64 = 0.0;
    for (bits, found) in bits.iter().zip(exponentials(&bits)) {
        let expected = exponential(*bits);
        // Relative to nothing where the number is 0.
        let error = (found - expected).abs() / expected.max(f64::MIN_POSITIVE);
        assert!(error < 3e-7, "{bits:#x}: {found}, expected {expected}");
        worst = worst.max(error);
    }
    common::report("exponential", worst, 3e-7);
}

#[test]
fn exponential_numbers_have_mean_and_variance_1() {
    const COUNT: u32 = 1 << 22;
    let count = f64::from(COUNT);
    // The midpoints w = (i + 1/2) / COUNT.
    let bits: Vec<u32> = (0..COUNT).map(|i| (i << 10) + 511).collect();
    let found = exponentials(&bits);
    let mean = found.iter().sum::<f64>() / count;
    let square = found.iter().map(|e| e * e).sum::<f64>() / count;
    // Of the exact numbers the mean is 1 - ln(2) / (2 COUNT), by Stirling's formula for the Gamma function of COUNT + 1/2;
    // the rule for the square misses less than its first cell, (ln(COUNT)^2 + 2 ln(COUNT) + 2) / COUNT.
    common::close("mean", mean, 1.0 - std::f64::consts::LN_2 / (2.0 * count), 3e-7);
    common::close("square", square, 2.0, 12e-7 + (count.ln().powi(2) + 2.0 * count.ln() + 2.0) / count);
}
