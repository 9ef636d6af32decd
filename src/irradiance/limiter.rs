//! Flux limiters: where light would flow faster than it can, diffusivity is lower (Levermore & Pomraning 1981).

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

    /// As kernels know it; see `cl/irradiance/scattered.cl`.
    pub(super) fn number(self) -> u32 {
        self as u32
    }

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
