//! The solver's kernels and how each kind of them is launched.

use super::fields::Level;
use crate::Result;
use crate::device::{Arg, Buffer, Device, Kernel, Program, ProgramSpec};
use std::collections::HashMap;

/// Every kernel of the solver.
const KERNELS: [&str; 21] = [
    "diffusion_balance",
    "diffusion_begin",
    "diffusion_overrelax",
    "diffusion_explicit",
    "diffusion_apply",
    "diffusion_imbalance",
    "diffusion_residual",
    "diffusion_step",
    "diffusion_turn",
    "diffusion_correct",
    "diffusion_clamp",
    "diffusion_multiply",
    "diffusion_zero",
    "diffusion_dots",
    "diffusion_sums",
    "diffusion_assemble",
    "diffusion_invert",
    "diffusion_coarsen",
    "diffusion_restrict",
    "diffusion_prolong",
    "diffusion_coarsest",
];
/// Kernels between boxes and fields.
const TRANSFERS: [&str; 3] = ["diffusion_load", "diffusion_store", "diffusion_inspect"];
/// Work-items of a sum, each of which gives a share: enough to fill a device.
const SHARES: usize = 4096;

/// The built kernels.
pub(super) struct Kernels {
    kernels: HashMap<&'static str, Kernel>,
    shares: Buffer<f32>,
    counts: Buffer<u32>,
}

impl Kernels {
    pub fn build(device: &Device, alter: fn(ProgramSpec) -> ProgramSpec) -> Result<Self> {
        let spec = alter(ProgramSpec::new("diffusion/solver.cl").uncontracted());
        let program = Program::build(device, &spec)?;
        let names = KERNELS.into_iter().chain(TRANSFERS);
        let kernels = names.map(|name| Ok((name, program.kernel(device, name)?))).collect::<Result<_>>()?;
        let shares = Buffer::zeroed(device, 2 * SHARES)?;
        Ok(Self { kernels, shares, counts: Buffer::zeroed(device, 4 * SHARES)? })
    }
}

/// What a box holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Contents {
    pub largest: f32,
    /// Numbers that are below 0 or none.
    pub wrong: u64,
    pub zero: u64,
    /// Numbers above the limit that was asked about.
    pub above: u64,
}

/// Launches on one device. Nothing waits but what reads.
pub(super) struct Queue<'a> {
    pub device: &'a Device,
    pub kernels: &'a mut Kernels,
}

impl Queue<'_> {
    fn enqueue(&mut self, name: &'static str, arguments: &[Arg<'_>], items: [usize; 3]) -> Result<()> {
        let kernel = self.kernels.kernels.get_mut(name);
        kernel.expect("every kernel is in the list").enqueue(self.device, arguments, items)
    }

    /// A kernel over the cells of one colour: fields, numbers, then the shape.
    pub fn sweep(
        &mut self,
        name: &'static str,
        level: &Level,
        colour: u32,
        fields: &[&Buffer<f32>],
        numbers: &[f32],
    ) -> Result<()> {
        let grid = &level.grid;
        let [row, slice] = grid.strides();
        let shape = [grid.half_count(), grid.guard(), row / 2, slice / 2];
        let arguments: Vec<Arg<'_>> = (fields.iter().map(|&field| field.into()))
            .chain(numbers.iter().map(|&number| number.into()))
            .chain(shape.map(|number| (number as u32).into()))
            .chain([colour.into()])
            .collect();
        self.enqueue(name, &arguments, [grid.half_count(), 1, 1])
    }

    /// [`Queue::sweep`] over both colours.
    pub fn sweep_both(&mut self, name: &'static str, level: &Level, fields: &[&Buffer<f32>]) -> Result<()> {
        (0..2).try_for_each(|colour| self.sweep(name, level, colour, fields, &[]))
    }

    /// A kernel over the cells of a level.
    pub fn cells(&mut self, name: &'static str, level: &Level, arguments: &[Arg<'_>]) -> Result<()> {
        self.enqueue(name, arguments, level.grid.dims)
    }

    /// A kernel over `count` elements: fields, numbers, then the count.
    pub fn vector(
        &mut self,
        name: &'static str,
        fields: &[&Buffer<f32>],
        numbers: &[f32],
        count: usize,
    ) -> Result<()> {
        let arguments: Vec<Arg<'_>> = (fields.iter().map(|&field| field.into()))
            .chain(numbers.iter().map(|&number| number.into()))
            .chain([(count as u32).into()])
            .collect();
        self.enqueue(name, &arguments, [count, 1, 1])
    }

    /// Solves the coarsest level.
    pub fn coarsest(&mut self, level: &Level, inverse: &Buffer<f32>, elements: &Buffer<u32>) -> Result<()> {
        let order = elements.len();
        let arguments = [
            (&level.phi).into(),
            (&level.source).into(),
            inverse.into(),
            elements.into(),
            (order as u32).into(),
        ];
        self.enqueue("diffusion_coarsest", &arguments, [order, 1, 1])
    }

    /// The sums of a·b and b·c; waits.
    pub fn dots(&mut self, a: &Buffer<f32>, b: &Buffer<f32>, c: &Buffer<f32>) -> Result<[f64; 2]> {
        self.shares("diffusion_dots", &[a, b, c])
    }

    /// Norm and sum of a field; waits.
    pub fn sums(&mut self, field: &Buffer<f32>) -> Result<[f64; 2]> {
        let [squares, sum] = self.shares("diffusion_sums", &[field])?;
        Ok([squares.sqrt(), sum])
    }

    fn shares(&mut self, name: &'static str, fields: &[&Buffer<f32>]) -> Result<[f64; 2]> {
        let Kernels { kernels, shares, .. } = &mut *self.kernels;
        let mut arguments = vec![Arg::from(&*shares)];
        arguments.extend(fields.iter().map(|&field| Arg::from(field)));
        arguments.extend([fields[0].len() as u32 / 8, SHARES as u32].map(Arg::from));
        let kernel = kernels.get_mut(name).expect("every kernel is in the list");
        kernel.enqueue(self.device, &arguments, [SHARES, 1, 1])?;
        let shares = shares.read(self.device)?;
        Ok(std::array::from_fn(|k| {
            shares[k * SHARES..][..SHARES].iter().map(|&share| f64::from(share)).sum()
        }))
    }

    /// What a box holds, and how much of it is above `limit`; waits.
    pub fn inspect(&mut self, values: &Buffer<f32>, limit: f32) -> Result<Contents> {
        let kernel = self.kernels.kernels.get_mut("diffusion_inspect").expect("every kernel is in the list");
        let counts = &self.kernels.counts;
        let arguments = [
            values.into(),
            counts.into(),
            limit.into(),
            (values.len() as u32).into(),
            (SHARES as u32).into(),
        ];
        kernel.enqueue(self.device, &arguments, [SHARES, 1, 1])?;
        let counts = counts.read(self.device)?;
        let sum = |k: usize| counts[k * SHARES..][..SHARES].iter().map(|&count| u64::from(count)).sum();
        let largest = counts[..SHARES].iter().map(|&bits| f32::from_bits(bits)).fold(0.0, f32::max);
        Ok(Contents { largest, wrong: sum(1), zero: sum(2), above: sum(3) })
    }
}
