//! The ledger of a picture's photons, and how it stands in the header of an image.

use super::{BouncedLedger, PhotonLedger};
use crate::render::number;
use std::collections::BTreeMap;

/// Where the flux of the photons of some passes went.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PassLedger {
    /// The passes: the first ones.
    pub passes: u32,
    /// Sums over the passes, each of which has the whole light.
    pub flux: PhotonLedger,
    /// The same of photons that diffuse surfaces reflect.
    pub bounced: BouncedLedger,
}

/// What the header says of the numbers.
pub(crate) const MEANING: &str = "photons_stored + direct + absorbed + escaped + truncated = emitted: flux in W, the mean \
     over channels, summed over photon_passes passes of photons; direct met a diffuse surface first, and is not stored; \
     of photons that diffuse surfaces reflect, bounced_others + absorbed + escaped + truncated + beyond = emitted: others \
     went the way of other photons, beyond is what the limit on bounces cuts, and received is what surfaces get";

impl PassLedger {
    /// The totals as they stand in the header of an image: key (after `svetlo.`) and value. Numbers come back from their
    /// text as they were.
    pub(crate) fn entries(&self) -> [(&'static str, String); 18] {
        let PhotonLedger { emitted, stored, direct, absorbed, escaped, truncated, photons, stored_photons } =
            self.flux;
        [
            ("photon_passes", self.passes.to_string()),
            ("photons", photons.to_string()),
            ("photons_in_maps", stored_photons.to_string()),
            ("photons_emitted", emitted.to_string()),
            ("photons_stored", stored.to_string()),
            ("photons_direct", direct.to_string()),
            ("photons_absorbed", absorbed.to_string()),
            ("photons_escaped", escaped.to_string()),
            ("photons_truncated", truncated.to_string()),
            ("bounced", self.bounced.photons.to_string()),
            ("bounced_in_maps", self.bounced.stored_photons.to_string()),
            ("bounced_emitted", self.bounced.emitted.to_string()),
            ("bounced_others", self.bounced.others.to_string()),
            ("bounced_absorbed", self.bounced.absorbed.to_string()),
            ("bounced_escaped", self.bounced.escaped.to_string()),
            ("bounced_truncated", self.bounced.truncated.to_string()),
            ("bounced_beyond", self.bounced.beyond.to_string()),
            ("bounced_received", self.bounced.received.to_string()),
        ]
    }

    /// The totals in the header of an image.
    ///
    /// # Errors
    /// What is missing, or no number.
    pub(crate) fn read(header: &BTreeMap<String, String>) -> Result<Self, String> {
        let flux = PhotonLedger {
            photons: number(header, "photons")?,
            stored_photons: number(header, "photons_in_maps")?,
            emitted: number(header, "photons_emitted")?,
            stored: number(header, "photons_stored")?,
            direct: number(header, "photons_direct")?,
            absorbed: number(header, "photons_absorbed")?,
            escaped: number(header, "photons_escaped")?,
            truncated: number(header, "photons_truncated")?,
        };
        let bounced = BouncedLedger {
            photons: number(header, "bounced")?,
            stored_photons: number(header, "bounced_in_maps")?,
            emitted: number(header, "bounced_emitted")?,
            others: number(header, "bounced_others")?,
            absorbed: number(header, "bounced_absorbed")?,
            escaped: number(header, "bounced_escaped")?,
            truncated: number(header, "bounced_truncated")?,
            beyond: number(header, "bounced_beyond")?,
            received: number(header, "bounced_received")?,
        };
        Ok(Self { passes: number(header, "photon_passes")?, flux, bounced })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn totals_come_back_from_a_header_as_they_were() {
        let flux = PhotonLedger {
            emitted: 0.1 + 0.2,
            stored: 1.0 / 3.0,
            direct: 1e-30,
            absorbed: 0.0,
            escaped: -1e-9,
            truncated: 7.25,
            photons: u64::MAX,
            stored_photons: 3,
        };
        let bounced = BouncedLedger {
            emitted: 1e300,
            others: 1.0 / 7.0,
            absorbed: -0.1,
            escaped: 0.7,
            truncated: 1e-300,
            beyond: 2.5,
            received: 4.0 / 3.0,
            photons: 5,
            stored_photons: 4,
        };
        let ledger = PassLedger { passes: 17, flux, bounced };
        let mut header: BTreeMap<String, String> =
            ledger.entries().into_iter().map(|(key, value)| (format!("svetlo.{key}"), value)).collect();
        assert_eq!(PassLedger::read(&header), Ok(ledger));
        header.remove("svetlo.photons_direct");
        assert_eq!(PassLedger::read(&header).unwrap_err(), "its header lacks svetlo.photons_direct");
    }
}
