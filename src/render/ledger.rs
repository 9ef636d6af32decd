//! What the paths of a scattering render did: where their weight went, and what they cost.

use crate::device_struct;
use bytemuck::{Pod, Zeroable};
use std::collections::BTreeMap;

device_struct! {
    "types/path.cl",
    /// What the paths of a tile did; see `cl/types/path.cl`.
    pub struct Ledger {
        /// Escaped, absorbed, cut, gained by roulette.
        pub energy: [f32; 4],
        /// What `energy` cannot hold.
        pub energy_low: [f32; 4],
        /// Paths, low half.
        pub paths_low: u32,
        /// High half.
        pub paths_high: u32,
        /// Tentative collisions, low half.
        pub lookups_low: u32,
        /// High half.
        pub lookups_high: u32,
        /// Those that took something, low half.
        pub collisions_low: u32,
        /// High half.
        pub collisions_high: u32,
        /// Those with extinction above the majorant, low half.
        pub above_low: u32,
        /// High half.
        pub above_high: u32,
        /// Samples whose paths the device did not follow to their ends.
        pub unfinished: u32,
        /// Padding.
        pub pad_0: u32,
        /// Padding.
        pub pad_1: u32,
        /// Padding.
        pub pad_2: u32,
    }
}

/// What all paths of a render did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct PathLedger {
    /// Paths started.
    pub paths: u64,
    /// Tentative collisions: look-ups of the medium.
    pub lookups: u64,
    /// Of these, the ones that scattered or absorbed.
    pub collisions: u64,
    /// Look-ups that found more extinction than the majorant. Anything but 0 is a mistake of this program.
    pub above_majorant: u64,
    /// How often paths that the device followed together did not come to their ends.
    pub unfinished: u64,
    /// Weight that left the volume; weights are those of paths that start with 1, the mean over channels.
    pub escaped: f64,
    /// Weight absorbed.
    pub absorbed: f64,
    /// Weight lost to the limit on scatterings.
    pub cut: f64,
    /// Weight that Russian roulette added, less what it removed: 0 in the mean.
    pub gained: f64,
}

impl PathLedger {
    /// Sums up what the device counted.
    pub fn of(accounts: &[Ledger]) -> Self {
        let join = |low: u32, high: u32| u64::from(high) << 32 | u64::from(low);
        let mut all = Self::default();
        for account in accounts {
            let energy = |i: usize| f64::from(account.energy[i]) + f64::from(account.energy_low[i]);
            all = all.plus(&Self {
                paths: join(account.paths_low, account.paths_high),
                lookups: join(account.lookups_low, account.lookups_high),
                collisions: join(account.collisions_low, account.collisions_high),
                above_majorant: join(account.above_low, account.above_high),
                unfinished: u64::from(account.unfinished),
                escaped: energy(0),
                absorbed: energy(1),
                cut: energy(2),
                gained: energy(3),
            });
        }
        all
    }

    /// Both together.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            paths: self.paths + other.paths,
            lookups: self.lookups + other.lookups,
            collisions: self.collisions + other.collisions,
            above_majorant: self.above_majorant + other.above_majorant,
            unfinished: self.unfinished + other.unfinished,
            escaped: self.escaped + other.escaped,
            absorbed: self.absorbed + other.absorbed,
            cut: self.cut + other.cut,
            gained: self.gained + other.gained,
        }
    }

    /// Tentative collisions that were none.
    pub fn null_collisions(&self) -> u64 {
        self.lookups - self.collisions
    }

    /// The share of the look-ups that were no collisions; 0 without any.
    pub fn null_share(&self) -> f64 {
        self.null_collisions() as f64 / self.lookups.max(1) as f64
    }

    /// A weight as a share of what all paths start with.
    pub fn share(&self, weight: f64) -> f64 {
        weight / self.paths.max(1) as f64
    }

    /// What is missing in escaped + absorbed + cut = paths + gained, per path.
    pub fn imbalance(&self) -> f64 {
        self.share(self.escaped + self.absorbed + self.cut - self.gained - self.paths as f64)
    }

    /// The totals as they stand in the header of an image beside `lookups`, which are all the paths': key (after
    /// `svetlo.`) and value. Numbers come back from their text as they were.
    pub(super) fn entries(&self) -> [(&'static str, String); 8] {
        [
            ("paths", self.paths.to_string()),
            ("null_collisions", self.null_collisions().to_string()),
            ("above_majorant", self.above_majorant.to_string()),
            ("unfinished", self.unfinished.to_string()),
            ("escaped", self.escaped.to_string()),
            ("absorbed", self.absorbed.to_string()),
            ("cut", self.cut.to_string()),
            ("gained", self.gained.to_string()),
        ]
    }

    /// The totals in the header of an image.
    ///
    /// # Errors
    /// What is missing, or no number.
    pub(super) fn read(header: &BTreeMap<String, String>) -> Result<Self, String> {
        let lookups: u64 = number(header, "lookups")?;
        let null: u64 = number(header, "null_collisions")?;
        let collisions = lookups.checked_sub(null);
        Ok(Self {
            paths: number(header, "paths")?,
            lookups,
            collisions: collisions.ok_or("svetlo.null_collisions in its header is above svetlo.lookups")?,
            above_majorant: number(header, "above_majorant")?,
            unfinished: number(header, "unfinished")?,
            escaped: number(header, "escaped")?,
            absorbed: number(header, "absorbed")?,
            cut: number(header, "cut")?,
            gained: number(header, "gained")?,
        })
    }
}

/// A number in the header of an image, by its key after `svetlo.`.
pub(crate) fn number<T: std::str::FromStr>(
    header: &BTreeMap<String, String>,
    key: &str,
) -> Result<T, String> {
    let text =
        header.get(&format!("svetlo.{key}")).ok_or_else(|| format!("its header lacks svetlo.{key}"))?;
    text.parse().map_err(|_| format!("svetlo.{key} in its header is `{text}`, not a number"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    fn account() -> Ledger {
        Ledger {
            energy: [5.0, 2.0, 0.5, -0.5],
            energy_low: [1e-9, -1e-10, 0.0, 1e-9],
            paths_low: 8,
            lookups_low: 3,
            lookups_high: 2,
            collisions_low: 5,
            above_low: 1,
            unfinished: 1,
            ..Ledger::zeroed()
        }
    }

    #[test]
    fn accounts_add_up_in_double_precision() {
        let all = PathLedger::of(&[account(), account()]);
        assert_eq!((all.paths, all.lookups, all.collisions), (16, 2 * (3 + (2 << 32)), 10));
        assert_eq!((all.above_majorant, all.unfinished), (2, 2));
        assert_eq!(all.null_collisions(), all.lookups - 10);
        // What float32 cannot hold beside 5 is there.
        assert!((all.escaped - 10.0 - 2e-9).abs() < 1e-15);
        assert_eq!(all.share(4.0), 0.25);
        // Escaped 10, absorbed 4, cut 1 of 16 paths of which roulette took 1.
        assert!(all.imbalance().abs() < 1e-9, "{}", all.imbalance());
    }

    #[test]
    fn nothing_is_no_share() {
        let none = PathLedger::of(&[]);
        assert_eq!((none.null_share(), none.share(0.0), none.imbalance()), (0.0, 0.0, 0.0));
    }

    #[test]
    fn totals_come_back_from_a_header_as_they_were() {
        let all = PathLedger::of(&[account(), Ledger { energy: [0.1; 4], ..account() }]);
        let mut header: BTreeMap<String, String> =
            all.entries().into_iter().map(|(key, value)| (format!("svetlo.{key}"), value)).collect();
        header.insert("svetlo.lookups".into(), all.lookups.to_string());
        assert_eq!(PathLedger::read(&header), Ok(all));
        header.insert("svetlo.cut".into(), "much".into());
        assert_eq!(
            PathLedger::read(&header).unwrap_err(),
            "svetlo.cut in its header is `much`, not a number"
        );
        header.insert("svetlo.lookups".into(), "1".into());
        assert!(PathLedger::read(&header).unwrap_err().contains("above svetlo.lookups"));
        header.remove("svetlo.paths");
        header.insert("svetlo.null_collisions".into(), "1".into());
        assert_eq!(PathLedger::read(&header).unwrap_err(), "its header lacks svetlo.paths");
    }
}
