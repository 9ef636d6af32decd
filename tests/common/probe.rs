//! Kernels made of a few lines that call the functions of a file below `cl/`.
//!
//! Each test file uses a part of this.
#![allow(dead_code)]

use bytemuck::Pod;
use svetlo::device::{Buffer, Program, ProgramSpec};

/// Runs `body` for each `N` inputs `x[0]`, `x[1]`, …; it fills the `M` outputs `y[0]`, `y[1]`, ….
pub fn probe<const N: usize, const M: usize>(
    file: &'static str,
    body: &str,
    inputs: &[[[f32; 4]; N]],
) -> Vec<[[f32; 4]; M]> {
    probe_with(file, "float", &[0.0_f32], body, inputs)
}

/// The same with a `table` of elements that are called `kind` on the device.
pub fn probe_with<T: Pod, const N: usize, const M: usize>(
    file: &'static str,
    kind: &str,
    table: &[T],
    body: &str,
    inputs: &[[[f32; 4]; N]],
) -> Vec<[[f32; 4]; M]> {
    let device = crate::common::device();
    let kernel = format!(
        "__kernel void probe(__global const float4 *in, __global float4 *out, __global const {kind} *table,\n\
         uint count) {{\nsize_t i = get_global_id(0);\nif (i >= count) return;\n\
         __global const float4 *x = in + i * {N};\n__global float4 *y = out + i * {M};\n{body}\n}}\n"
    );
    let program = Program::build_probe(&device, &ProgramSpec::new(file), &kernel).unwrap();
    let input = Buffer::from_slice(&device, inputs.as_flattened()).unwrap();
    let output = Buffer::<[f32; 4]>::zeroed(&device, inputs.len() * M).unwrap();
    let table = Buffer::from_slice(&device, table).unwrap();
    let arguments = [(&input).into(), (&output).into(), (&table).into(), (inputs.len() as u32).into()];
    program.kernel(&device, "probe").unwrap().run(&device, &arguments, inputs.len()).unwrap();
    let flat = output.read(&device).unwrap();
    flat.chunks_exact(M).map(|chunk| chunk.try_into().unwrap()).collect()
}
