//! Latitude-longitude maps: ω = (sin θ cos φ, cos θ, sin θ sin φ), θ = πv, φ = 2πu + rotation.

use crate::Result;
use crate::picture::Environment;
use glam::DVec3;
use std::f64::consts::{PI, TAU};
use std::path::Path;

/// A map of radiance by direction, bilinear between the centres of its texels.
pub struct EnvironmentMap {
    map: Environment,
    intensity: f64,
    rotation: f64,
}

impl EnvironmentMap {
    /// Reads a map; `rotation` about +y in radians.
    ///
    /// # Errors
    /// [`crate::Error::Input`] when the file cannot be read.
    pub fn read(path: &Path, intensity: f64, rotation: f64) -> Result<Self> {
        Ok(Self { map: Environment::read(path)?, intensity, rotation })
    }

    /// Radiance from a direction (of the ray that looks there), a unit vector.
    pub fn radiance(&self, direction: DVec3) -> [f64; 3] {
        let (width, height) = (self.map.width as i64, self.map.height as i64);
        let phi = direction.z.atan2(direction.x) - self.rotation;
        let x = (phi / TAU).rem_euclid(1.0) * width as f64 - 0.5;
        let y = direction.y.clamp(-1.0, 1.0).acos() / PI * height as f64 - 0.5;
        let texel = |i: i64, j: i64| {
            let index = j.clamp(0, height - 1) * width + i.rem_euclid(width);
            self.map.rgb[index as usize].map(f64::from)
        };
        let (i, j) = (x.floor(), y.floor());
        let mut sum = [0.0; 3];
        for (di, wx) in [(0, 1.0 - (x - i)), (1, x - i)] {
            for (dj, wy) in [(0, 1.0 - (y - j)), (1, y - j)] {
                let rgb = texel(i as i64 + di, j as i64 + dj);
                for c in 0..3 {
                    sum[c] += self.intensity * wx * wy * rgb[c];
                }
            }
        }
        sum
    }
}
