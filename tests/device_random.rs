//! Random numbers on the device are those of the twins, bit for bit.

mod common;

use svetlo::device::{Buffer, Program, ProgramSpec};
use svetlo::reference::random::{KNOWN_ANSWERS, philox4x32, uniform};
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
    let body = "uint4 keys = (uint4)(x.s1, x.s2, x.s3, x.s4);\n\
        float2 a = sobol_pair(x.s0, keys, 0);\nfloat2 b = sobol_pair(x.s0, keys, 2);\n\
        out[i] = (uint4)(as_uint(a.x), as_uint(a.y), as_uint(b.x), as_uint(b.y));";
    for (input, output) in inputs.iter().zip(words("common/sobol.cl", body, &inputs)) {
        let keys = [input[1], input[2], input[3], input[4]];
        let twin = [sobol::pair(input[0], keys, 0), sobol::pair(input[0], keys, 2)].concat();
        for (bits, word) in output.into_iter().zip(twin) {
            assert_eq!(f64::from(f32::from_bits(bits)), uniform(word), "sample {}", input[0]);
        }
    }
}
