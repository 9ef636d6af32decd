//! Pictures with known noise for the tests of the metrics.

use crate::picture::Picture;

/// Standard normal deviates: SplitMix64 and Box–Muller, chosen for being short.
pub struct Normal(u64);

impl Normal {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn next(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

/// Means of `samples` draws around `truth + offset` with the per-sample deviation `sigma`, in
/// three independent channels; the file carries the exact variance.
pub fn noisy(seed: u64, size: usize, truth: f64, sigma: f64, samples: u32) -> Picture {
    let mut normal = Normal::new(seed);
    let pixels = size * size;
    let deviation = sigma / f64::from(samples).sqrt();
    let mut picture = Picture::new(size, size);
    for name in ["R", "G", "B"] {
        let values = (0..pixels).map(|_| (truth + deviation * normal.next()) as f32).collect();
        picture = picture
            .with_channel(name, values)
            .with_channel(&format!("variance.{name}"), vec![(sigma * sigma) as f32; pixels]);
    }
    picture.with_counts("samples", vec![samples; pixels])
}

/// A grey row.
pub fn row(values: &[f32]) -> Picture {
    Picture::new(values.len(), 1).with_channel("Y", values.to_vec())
}
