//! Where the flux of photons went.

use crate::device_struct;
use bytemuck::{Pod, Zeroable};

device_struct! {
    "types/photon.cl",
    /// Where the flux of some photons went: means over channels, over the square of the local unit.
    pub struct PhotonAccount {
        /// Emitted, stored, met diffuse surfaces directly (of reflected ones: is of another role), absorbed.
        pub met: [f32; 4],
        /// What `met` cannot hold.
        pub met_low: [f32; 4],
        /// Escaped, cut by the limit on depth, absorbed by the medium (of bounced photons: cut by the limit on bounces);
        /// scattered by the medium, of what is stored.
        pub lost: [f32; 4],
        /// What `lost` cannot hold.
        pub lost_low: [f32; 4],
        /// Photons.
        pub photons: u32,
        /// Those that are stored.
        pub stored: u32,
        /// Padding.
        pub pad_0: u32,
        /// Padding.
        pub pad_1: u32,
    }
}

/// Where the flux of all photons went, over all passes: means over channels, W for each pass's worth of light.
///
/// With dispersion, channels of photons may be negative, and so may be a part of a few photons.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct PhotonLedger {
    /// What left the lights.
    pub emitted: f64,
    /// Stored on diffuse surfaces.
    pub stored: f64,
    /// Met a diffuse surface before anything else, or was scattered by the medium, and is not stored: direct light has it.
    pub direct: f64,
    /// Absorbed by mirrors and inside glass.
    pub absorbed: f64,
    /// Left the scene.
    pub escaped: f64,
    /// Lost to the limit on reflections and refractions.
    pub truncated: f64,
    /// Absorbed by the medium.
    pub medium_absorbed: f64,
    /// Scattered by the medium and stored there, each time anew: no end, it goes on.
    pub medium_scattered: f64,
    /// Photons emitted.
    pub photons: u64,
    /// Photons stored.
    pub stored_photons: u64,
}

impl PhotonLedger {
    /// Sums up what the device entered; `unit`: scene units per local unit.
    pub fn of(accounts: &[PhotonAccount], unit: f64) -> Self {
        let area = unit * unit;
        accounts.iter().fold(Self::default(), |all, account| {
            let met = |i: usize| area * (f64::from(account.met[i]) + f64::from(account.met_low[i]));
            let lost = |i: usize| area * (f64::from(account.lost[i]) + f64::from(account.lost_low[i]));
            all.plus(&Self {
                emitted: met(0),
                stored: met(1),
                direct: met(2),
                absorbed: met(3),
                escaped: lost(0),
                truncated: lost(1),
                medium_absorbed: lost(2),
                medium_scattered: lost(3),
                photons: account.photons.into(),
                stored_photons: account.stored.into(),
            })
        })
    }

    /// Both together.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            emitted: self.emitted + other.emitted,
            stored: self.stored + other.stored,
            direct: self.direct + other.direct,
            absorbed: self.absorbed + other.absorbed,
            escaped: self.escaped + other.escaped,
            truncated: self.truncated + other.truncated,
            medium_absorbed: self.medium_absorbed + other.medium_absorbed,
            medium_scattered: self.medium_scattered + other.medium_scattered,
            photons: self.photons + other.photons,
            stored_photons: self.stored_photons + other.stored_photons,
        }
    }

    /// What the first has beyond the second.
    #[must_use]
    pub fn minus(&self, other: &Self) -> Self {
        Self {
            emitted: self.emitted - other.emitted,
            stored: self.stored - other.stored,
            direct: self.direct - other.direct,
            absorbed: self.absorbed - other.absorbed,
            escaped: self.escaped - other.escaped,
            truncated: self.truncated - other.truncated,
            medium_absorbed: self.medium_absorbed - other.medium_absorbed,
            medium_scattered: self.medium_scattered - other.medium_scattered,
            photons: self.photons - other.photons,
            stored_photons: self.stored_photons - other.stored_photons,
        }
    }

    /// What is missing in stored + direct + absorbed (by the medium, too) + escaped + truncated = emitted, as a share of
    /// what was emitted; 0 without any.
    pub fn imbalance(&self) -> f64 {
        let absorbed = self.absorbed + self.medium_absorbed;
        let ends = self.stored + self.direct + absorbed + self.escaped + self.truncated;
        if self.emitted == 0.0 { 0.0 } else { (ends - self.emitted) / self.emitted }
    }
}

/// The same of photons that diffuse surfaces reflect. Where they are stored is not where they end: what surfaces receive
/// stands beside what became of the flux.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct BouncedLedger {
    /// What left the lights for these photons.
    pub emitted: f64,
    /// Went the way of other photons.
    pub others: f64,
    /// Absorbed by diffuse surfaces, by mirrors and inside glass. What Russian roulette takes and adds is here, too.
    pub absorbed: f64,
    /// Left the scene.
    pub escaped: f64,
    /// Lost to the limit on reflections and refractions.
    pub truncated: f64,
    /// Would have been reflected by diffuse surfaces once more than `bounces`.
    pub beyond: f64,
    /// Stored: what diffuse surfaces receive of diffuse ones.
    pub received: f64,
    /// Photons emitted.
    pub photons: u64,
    /// Photons stored.
    pub stored_photons: u64,
}

impl BouncedLedger {
    /// Sums up what the device entered; `unit`: scene units per local unit.
    pub fn of(accounts: &[PhotonAccount], unit: f64) -> Self {
        let area = unit * unit;
        accounts.iter().fold(Self::default(), |all, account| {
            let met = |i: usize| area * (f64::from(account.met[i]) + f64::from(account.met_low[i]));
            let lost = |i: usize| area * (f64::from(account.lost[i]) + f64::from(account.lost_low[i]));
            all.plus(&Self {
                emitted: met(0),
                others: met(2),
                absorbed: met(3),
                escaped: lost(0),
                truncated: lost(1),
                beyond: lost(2),
                received: met(1),
                photons: account.photons.into(),
                stored_photons: account.stored.into(),
            })
        })
    }

    /// Both together.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        self.with(other, 1.0, u64::wrapping_add)
    }

    /// What the first has beyond the second.
    #[must_use]
    pub fn minus(&self, other: &Self) -> Self {
        self.with(other, -1.0, u64::wrapping_sub)
    }

    fn with(&self, other: &Self, sign: f64, count: impl Fn(u64, u64) -> u64) -> Self {
        Self {
            emitted: self.emitted + sign * other.emitted,
            others: self.others + sign * other.others,
            absorbed: self.absorbed + sign * other.absorbed,
            escaped: self.escaped + sign * other.escaped,
            truncated: self.truncated + sign * other.truncated,
            beyond: self.beyond + sign * other.beyond,
            received: self.received + sign * other.received,
            photons: count(self.photons, other.photons),
            stored_photons: count(self.stored_photons, other.stored_photons),
        }
    }

    /// What is missing in others + absorbed + escaped + truncated + beyond = emitted, as a share of what was emitted; 0
    /// without any.
    pub fn imbalance(&self) -> f64 {
        let ends = self.others + self.absorbed + self.escaped + self.truncated + self.beyond;
        if self.emitted == 0.0 { 0.0 } else { (ends - self.emitted) / self.emitted }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn accounts_add_up_in_double_precision_and_scene_units() {
        let account = PhotonAccount {
            met: [8.0, 4.0, 2.0, 1.0],
            met_low: [1e-9, 0.0, 0.0, 0.0],
            lost: [0.5, 0.25, 0.0, 0.0],
            lost_low: [0.0, 1e-9, 0.0, 0.0],
            photons: 5,
            stored: 3,
            pad_0: 0,
            pad_1: 0,
        };
        let all = PhotonLedger::of(&[account, account], 0.5);
        assert_eq!((all.photons, all.stored_photons), (10, 6));
        assert_eq!((all.stored, all.direct, all.absorbed, all.escaped), (2.0, 1.0, 0.5, 0.25));
        assert!((all.emitted - 4.0 - 0.5e-9).abs() < 2e-15, "what float32 cannot hold beside 8 is there");
        assert!((all.imbalance() + 0.25 / 8.0).abs() < 1e-9, "a quarter of 8 is missing");
        assert_eq!(PhotonLedger::default().imbalance(), 0.0);
    }
}
