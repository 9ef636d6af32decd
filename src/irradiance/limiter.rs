//! Flux limiters: where light would flow faster than it can, diffusivity is lower (Levermore & Pomraning 1981). The
//! kernels are `cl/irradiance/limiter.cl`.
//!
//! The limited diffusivity depends on the solution, so the equation is solved again and again with the diffusivity that
//! the last solution wants (Picard). Where light streams, that alone would take hundreds of solves: Anderson's iteration
//! (1965) goes on from the combination of the last few diffusivities that would have had to change least. It is done in
//! the logarithm, because only factors matter.

use super::channel::ChannelFields;
use super::kernels::Grids;
use crate::Result;
use crate::device::{Arg, Buffer, Device, Kernel, MemoryPlan, Program};

/// λ(R) of the diffusivity λ(R) / σ_tr, where R = |∇φ| / (σ_tr φ): 1/3 where light hardly flows, 1/R where it streams,
/// so that the vector flux is never beyond the fluence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limiter {
    /// 1/3 everywhere: the classical diffusion equation, which is linear.
    None,
    /// 1 / (3 + R).
    Sum,
    /// 1 / max(3, R).
    Max,
    /// 2 / (3 + √(9 + 4R²)) (Kershaw 1976).
    Kershaw,
    /// (coth R − 1/R) / R.
    LevermorePomraning,
    /// (2 + R) / (6 + 3R + R²): nearly the same without exponentials.
    Rational,
}

impl Limiter {
    /// Every limiter.
    pub const ALL: [Self; 6] =
        [Self::None, Self::Sum, Self::Max, Self::Kershaw, Self::LevermorePomraning, Self::Rational];

    /// Its word in scenes and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Sum => "sum",
            Self::Max => "max",
            Self::Kershaw => "kershaw",
            Self::LevermorePomraning => "levermore-pomraning",
            Self::Rational => "rational",
        }
    }
}

/// Differences that are kept, as in `cl/irradiance/limiter.cl`.
const MIXED: usize = 3;
/// Fields of the memory: differences of diffusivities and of steps, and the last of both.
const MEMORY: usize = 2 * MIXED + 2;
/// Work-items of a reduction, each of which gives shares.
const SHARES: usize = 4096;
/// Relative to the squares of the differences: what keeps nearly equal ones from having huge parts.
const REGULARISATION: f64 = 1e-6;

/// What is known of a fluence and its flux.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measured {
    /// Mean fluence.
    pub mean: f64,
    /// Largest flux over fluence.
    pub flux: f64,
    /// Cells below the floor of σ_tr.
    pub below: u64,
}

/// The kernels that limit, and what they keep from update to update.
pub(super) struct LimiterKernels {
    flux: Kernel,
    limit: Kernel,
    products: Kernel,
    mix: Kernel,
    measure: Kernel,
    cut: Kernel,
    limiter: Limiter,
    /// The floor of σ_tr.
    least: f32,
    memory: Buffer<f32>,
    shares: Buffer<f32>,
    /// Updates of the equation at hand.
    updates: usize,
}

impl LimiterKernels {
    pub fn build(
        device: &Device,
        program: &Program,
        limiter: Limiter,
        least: f64,
        cells: usize,
    ) -> Result<Self> {
        let kernel = |name| program.kernel(device, name);
        Ok(Self {
            flux: kernel("irradiance_flux")?,
            limit: kernel("irradiance_limit")?,
            products: kernel("irradiance_products")?,
            mix: kernel("irradiance_mix")?,
            measure: kernel("irradiance_measure")?,
            cut: kernel("irradiance_cut")?,
            limiter,
            least: least as f32,
            memory: Buffer::uninitialised(device, memory(limiter, cells))?,
            shares: Buffer::uninitialised(device, SHARES * MIXED * (MIXED + 1))?,
            updates: 0,
        })
    }

    /// What [`LimiterKernels::build`] would allocate.
    pub fn memory(limiter: Limiter, cells: usize) -> MemoryPlan {
        let mut plan = MemoryPlan::default();
        plan.add("diffusivities of the last updates", memory(limiter, cells) as u64, size_of::<f32>());
        plan
    }

    /// Forgets the updates of another equation.
    pub fn restart(&mut self) {
        self.updates = 0;
    }

    /// The flux of a fluence.
    pub fn flux(
        &mut self,
        device: &Device,
        grids: &Grids,
        phi: &Buffer<f32>,
        fields: &ChannelFields,
    ) -> Result<()> {
        let arguments = [
            (&grids.grid).into(),
            (&grids.limits).into(),
            phi.into(),
            (&fields.diffusivity).into(),
            (&fields.flux).into(),
        ];
        self.flux.enqueue(device, &arguments, [phi.len(), 1, 1])
    }

    /// Moves the diffusivity towards what the limiter wants for a fluence and its flux; below the fluence `faint` it lets
    /// go.
    pub fn update(
        &mut self,
        device: &Device,
        grids: &Grids,
        phi: &Buffer<f32>,
        fields: &ChannelFields,
        faint: f64,
    ) -> Result<()> {
        let count = Arg::from(phi.len() as u32);
        // Negative numbers have the same bits as signed and unsigned.
        let slot = self.updates.checked_sub(1).map_or(u32::MAX, |before| (before % MIXED) as u32);
        let arguments = [
            phi.into(),
            (&fields.flux).into(),
            (&fields.transport).into(),
            (&fields.diffusivity).into(),
            (&self.memory).into(),
            (&grids.limits).into(),
            self.least.into(),
            (faint as f32).into(),
            (self.limiter as u32).into(),
            slot.into(),
            count,
        ];
        self.limit.enqueue(device, &arguments, [phi.len(), 1, 1])?;
        let parts = self.parts(device, self.updates.min(MIXED), phi.len())?;
        self.updates += 1;
        let mut arguments = vec![(&self.memory).into(), (&fields.diffusivity).into(), (&grids.limits).into()];
        arguments.extend(parts.map(|part| Arg::from(part as f32)));
        arguments.push((phi.len() as u32).into());
        self.mix.enqueue(device, &arguments, [phi.len(), 1, 1])
    }

    /// The combination of the differences of steps that comes nearest to the last step.
    fn parts(&mut self, device: &Device, kept: usize, cells: usize) -> Result<[f64; MIXED]> {
        if kept == 0 {
            return Ok([0.0; MIXED]);
        }
        let counts = [kept, cells, SHARES].map(|count| Arg::from(count as u32));
        let arguments: Vec<Arg<'_>> =
            [&self.memory, &self.shares].into_iter().map(Arg::from).chain(counts).collect();
        self.products.enqueue(device, &arguments, [SHARES, 1, 1])?;
        let shares = self.shares.read(device)?;
        let sum =
            |k: usize| shares[k * SHARES..][..SHARES].iter().map(|&share| f64::from(share)).sum::<f64>();
        let products = std::array::from_fn(|j| std::array::from_fn(|k| sum(j * (MIXED + 1) + k)));
        Ok(least_squares(products))
    }

    /// Shortens fluxes that are beyond their fluence.
    pub fn cut(&mut self, device: &Device, phi: &Buffer<f32>, fields: &ChannelFields) -> Result<()> {
        let arguments = [phi.into(), (&fields.flux).into(), (phi.len() as u32).into()];
        self.cut.enqueue(device, &arguments, [phi.len(), 1, 1])
    }

    /// What is known of a fluence and its flux.
    pub fn measure(
        &mut self,
        device: &Device,
        phi: &Buffer<f32>,
        fields: &ChannelFields,
        faint: f64,
    ) -> Result<Measured> {
        let arguments = [
            phi.into(),
            (&fields.flux).into(),
            (&fields.transport).into(),
            (&self.shares).into(),
            (faint as f32).into(),
            self.least.into(),
            (phi.len() as u32).into(),
            (SHARES as u32).into(),
        ];
        self.measure.enqueue(device, &arguments, [SHARES, 1, 1])?;
        let shares = self.shares.read(device)?;
        let part = |k: usize| shares[k * SHARES..][..SHARES].iter();
        let sum = |k: usize| part(k).map(|&share| f64::from(share)).sum::<f64>();
        Ok(Measured {
            mean: sum(0) / phi.len() as f64,
            flux: part(1).copied().fold(0.0, f32::max).into(),
            below: sum(2) as u64,
        })
    }
}

/// Numbers that the updates keep.
fn memory(limiter: Limiter, cells: usize) -> usize {
    if limiter == Limiter::None { 1 } else { MEMORY * cells }
}

/// The parts of a least-squares combination from products of its vectors with each other (and last with the target);
/// those of vectors that are 0 are 0.
fn least_squares(products: [[f64; MIXED + 1]; MIXED]) -> [f64; MIXED] {
    let size: [f64; MIXED] = std::array::from_fn(|j| products[j][j].sqrt());
    let scaled = |j: usize, k: usize| match (j == k, size[j] * size[k]) {
        (true, _) => 1.0 + REGULARISATION,
        (false, 0.0) => 0.0,
        (false, scale) => products[j][k] / scale,
    };
    let mut rows: [[f64; MIXED + 1]; MIXED] = std::array::from_fn(|j| {
        let target = if size[j] > 0.0 { products[j][MIXED] / size[j] } else { 0.0 };
        std::array::from_fn(|k| if k == MIXED { target } else { scaled(j, k) })
    });
    // Elimination without pivots: the matrix is positive definite.
    for j in 0..MIXED {
        let pivot = rows[j];
        for row in &mut rows[j + 1..] {
            let factor = row[j] / pivot[j];
            row.iter_mut().zip(pivot).for_each(|(x, p)| *x -= factor * p);
        }
    }
    let mut parts = [0.0; MIXED];
    for j in (0..MIXED).rev() {
        let known: f64 = (j + 1..MIXED).map(|k| rows[j][k] * parts[k]).sum();
        parts[j] = (rows[j][MIXED] - known) / rows[j][j];
    }
    std::array::from_fn(|j| if size[j] > 0.0 { parts[j] / size[j] } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn combinations_come_nearest() {
        let vectors = [[1.0, 2.0, 0.0, -1.0], [0.5, -3.0, 1.0, 0.0], [1e3, 0.0, 2e3, 4e3]];
        let exact = [0.25, -2.0, 3e-4];
        let target: [f64; 4] = std::array::from_fn(|i| (0..3).map(|j| exact[j] * vectors[j][i]).sum());
        let dot = |a: [f64; 4], b: [f64; 4]| (0..4).map(|i| a[i] * b[i]).sum::<f64>();
        let products = |n: usize| {
            std::array::from_fn(|j| {
                std::array::from_fn(|k| match (j < n, k) {
                    (true, MIXED) => dot(vectors[j], target),
                    (true, k) if k < n => dot(vectors[j], vectors[k]),
                    _ => 0.0,
                })
            })
        };
        for (part, exact) in least_squares(products(3)).into_iter().zip(exact) {
            // The regularisation is 10⁻⁶ of a diagonal of up to 21 beside eigenvalues from 0.5 on.
            assert!((part / exact - 1.0).abs() < 42e-6, "{part} {exact}");
        }
        let [first, second, third] = least_squares(products(1));
        assert!((first - dot(vectors[0], target) / dot(vectors[0], vectors[0])).abs() < 1e-5);
        assert_eq!([second, third], [0.0; 2]);
    }
}
