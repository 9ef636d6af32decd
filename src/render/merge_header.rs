//! What headers of parts say: what must be the same in all of them, and what adds up.

use super::kept::Units;
use super::ledger::{PathLedger, number};
use super::parts::Parts;
use super::state::FORMAT;
use crate::caustics::PassLedger;
use crate::film::{Double, FilmSummary};
use crate::picture::{Picture, Tonemap};
use crate::{Error, Result};
use std::collections::{BTreeMap, BTreeSet};

/// What the header of a part says.
pub(super) struct Header {
    pub parts: Parts,
    /// Whether a merge wrote it.
    pub is_merged: bool,
    pub size: (usize, usize),
    pub units: Units,
    pub has_auxiliary: bool,
    pub tonemap: Tonemap,
    pub metadata: BTreeMap<String, String>,
}

/// What must be the same, and how the message calls it.
const SAME: [(&str, &str); 6] = [
    ("version", "were rendered by different versions of svetlo"),
    ("method", "were rendered by different methods"),
    ("seed", "have different seeds"),
    ("scene_hash", "are of different scenes: their hashes are"),
    ("data_hash", "are of the same scene, but the files that it reads held different data: their hashes are"),
    (
        "light_hash",
        "have different light volumes, which devices of different kinds may compute; --load-light gives all parts the \
         same: their hashes are",
    ),
];

impl Header {
    /// Reads the header of an image.
    ///
    /// # Errors
    /// Why the image is no part of a picture.
    pub fn read(picture: &Picture) -> Result<Self, String> {
        let metadata = &picture.metadata;
        let text = |key: &str| metadata.get(&format!("svetlo.{key}")).map(String::as_str);
        let Some(format) = text("state") else {
            return Err("it holds no state of a render (svetlo.state)".into());
        };
        if format != FORMAT.to_string() {
            return Err(format!("its state has the format {format}, this svetlo reads {FORMAT}"));
        }
        let Some(parts) = text("part") else {
            return Err(
                "it is a whole picture; parts of one are rendered by `svetlo render --part I/N`".into()
            );
        };
        let unit: f64 = number(metadata, "unit")?;
        let preview = text("preview").unwrap_or_default();
        Ok(Self {
            is_merged: parts.contains(':'),
            parts: Parts::read(parts, number(metadata, "samples")?)?,
            size: (picture.width, picture.height),
            units: Units { unit, has_depth: text("depth").is_some() },
            has_auxiliary: text("auxiliary").is_some(),
            tonemap: preview.parse().map_err(|what| format!("svetlo.preview in its header: {what}"))?,
            metadata: metadata.clone(),
        })
    }

    /// Why two images are not parts of one picture: what is to be said of both.
    pub fn difference(&self, other: &Self) -> Option<String> {
        let text = |header: &Self, key: &str| {
            header.metadata.get(&format!("svetlo.{key}")).cloned().unwrap_or_else(|| "none".into())
        };
        let differs = |keys: &[(&str, &str)]| {
            keys.iter().find_map(|&(key, what)| {
                let (a, b) = (text(self, key), text(other, key));
                (a != b).then(|| format!("{what} ({b} and {a})"))
            })
        };
        if let Some(what) = differs(&SAME[..3]) {
            return Some(what);
        }
        if self.size != other.size {
            let [(w, h), (x, y)] = [other.size, self.size];
            return Some(format!("have different sizes ({w}×{h} and {x}×{y} pixels)"));
        }
        if let Some(what) = differs(&SAME[3..]) {
            return Some(what);
        }
        if self.has_auxiliary != other.has_auxiliary {
            let [a, b] = [other.has_auxiliary, self.has_auxiliary];
            return Some(format!("were rendered with different film.auxiliary ({a} and {b})"));
        }
        let (a, b) = (other.parts.of(), self.parts.of());
        (a != b).then(|| format!("are of pictures in different numbers of parts ({a} and {b})"))
    }
}

/// Numbers of headers that add up.
pub(super) struct Ledgers {
    sums: BTreeMap<String, Sum>,
    /// Microseconds.
    seconds: BTreeMap<&'static str, u128>,
    longest: u128,
    /// Devices, platforms and drivers.
    origins: [BTreeSet<String>; 3],
    from_files: bool,
}

/// A sum of whole numbers, or of any.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Sum {
    Count(u64),
    Weight(Double),
}

impl Sum {
    fn read(metadata: &BTreeMap<String, String>, key: &str) -> Result<Self, String> {
        let rest = format!("rest.{key}");
        if metadata.contains_key(&format!("svetlo.{rest}")) {
            return Ok(Self::Weight(Double::sum(number(metadata, key)?, number(metadata, &rest)?)));
        }
        // Weights without a fraction look like counts, and add up like them.
        match number(metadata, key) {
            Ok(count) => Ok(Self::Count(count)),
            Err(_) => Ok(Self::Weight(Double::from(number::<f64>(metadata, key)?))),
        }
    }

    fn weight(self) -> Double {
        match self {
            Self::Count(count) => Double::of_count(count),
            Self::Weight(weight) => weight,
        }
    }

    fn plus(self, other: Self) -> Self {
        match (self, other) {
            (Self::Count(a), Self::Count(b)) => Self::Count(a.saturating_add(b)),
            _ => Self::Weight(self.weight() + other.weight()),
        }
    }
}

const ORIGINS: [&str; 3] = ["device", "platform", "driver"];
const SECONDS: [&str; 3] = ["seconds_wall", "seconds_device", "seconds_build"];
/// Joins the names of devices.
const AND: &str = "; ";

impl Ledgers {
    /// Those of one image.
    ///
    /// # Errors
    /// What is missing in its header, or no number.
    pub fn read(metadata: &BTreeMap<String, String>) -> Result<Self, String> {
        let text = |key: &str| metadata.get(&format!("svetlo.{key}"));
        let mut keys = vec!["lookups", "launches"];
        if text("paths").is_some() {
            keys.extend(PathLedger::default().entries().map(|(key, _)| key));
        }
        if text("photon_passes").is_some() {
            keys.extend(PassLedger::default().entries().map(|(key, _)| key));
        }
        let sums: Result<_, String> =
            keys.into_iter().map(|key| Ok((key.to_owned(), Sum::read(metadata, key)?))).collect();
        let mut seconds = BTreeMap::new();
        for key in SECONDS {
            seconds.insert(key, microseconds(metadata, key)?);
        }
        let longest = if text("seconds_longest").is_some() { "seconds_longest" } else { "seconds_wall" };
        Ok(Self {
            sums: sums?,
            seconds,
            longest: microseconds(metadata, longest)?,
            origins: ORIGINS
                .map(|key| text(key).into_iter().flat_map(|t| t.split(AND)).map(str::to_owned).collect()),
            from_files: text("light_source").is_some_and(|source| source == "file"),
        })
    }

    /// Adds another image's.
    pub fn add(&mut self, other: &Self) {
        for (key, sum) in &mut self.sums {
            if let Some(more) = other.sums.get(key) {
                *sum = sum.plus(*more);
            }
        }
        for (key, time) in &mut self.seconds {
            *time += other.seconds.get(key).copied().unwrap_or(0);
        }
        self.longest = self.longest.max(other.longest);
        for (names, more) in self.origins.iter_mut().zip(&other.origins) {
            names.extend(more.iter().cloned());
        }
        self.from_files &= other.from_files;
    }

    /// Writes the sums into a header; returns those of paths and photons.
    ///
    /// # Errors
    /// [`Error::Input`] when the numbers of a header cannot be.
    pub fn describe(
        &self,
        metadata: &mut BTreeMap<String, String>,
        parts: &Parts,
        summary: &mut FilmSummary,
    ) -> Result<(Option<PathLedger>, Option<PassLedger>)> {
        metadata.retain(|key, _| !key.starts_with("svetlo.rest."));
        let mut put = |key: &str, value: String| {
            metadata.insert(format!("svetlo.{key}"), value);
        };
        for (key, sum) in &self.sums {
            match sum {
                Sum::Count(count) => put(key, count.to_string()),
                Sum::Weight(weight) => {
                    put(key, weight.value().to_string());
                    if !parts.missing().is_empty() && weight.rest() != 0.0 {
                        put(&format!("rest.{key}"), weight.rest().to_string());
                    }
                }
            }
        }
        if let Some(Sum::Count(lookups)) = self.sums.get("lookups") {
            summary.lookups = *lookups;
        }
        for (key, names) in ORIGINS.iter().zip(&self.origins) {
            put(key, names.iter().cloned().collect::<Vec<_>>().join(AND));
        }
        for (key, &time) in &self.seconds {
            put(key, in_seconds(time));
        }
        put("seconds_longest", in_seconds(self.longest));
        put("part", parts.to_string());
        put("samples", parts.samples().to_string());
        put("rejected_samples", summary.rejected.to_string());
        let error = summary.relative_error();
        put("estimated_error", error.map_or("unknown".into(), |error| format!("{error:.6e}")));
        if metadata.contains_key("svetlo.light_source") && !self.from_files {
            metadata.insert("svetlo.light_source".into(), "computed".into());
        }
        let wrong = |what| Error::Input(format!("the parts' headers do not agree: {what}"));
        let paths = self.sums.contains_key("paths").then(|| PathLedger::read(metadata));
        let photons = self.sums.contains_key("photon_passes").then(|| PassLedger::read(metadata));
        Ok((paths.transpose().map_err(wrong)?, photons.transpose().map_err(wrong)?))
    }

    /// That parts are of different devices, if they are.
    pub fn note(&self) -> Option<String> {
        let several = |(key, names): (&&str, &BTreeSet<String>)| {
            (names.len() > 1)
                .then(|| format!("{key}s {}", names.iter().cloned().collect::<Vec<_>>().join(" and ")))
        };
        let differences: Vec<String> = ORIGINS.iter().zip(&self.origins).filter_map(several).collect();
        (!differences.is_empty()).then(|| {
            format!(
                "the parts were rendered by different {}: each is rounded as its device rounds",
                differences.join("; ")
            )
        })
    }
}

fn microseconds(metadata: &BTreeMap<String, String>, key: &str) -> Result<u128, String> {
    let seconds: f64 = number(metadata, key)?;
    // 10^12 seconds, or thirty thousand years.
    if (0.0..1e12).contains(&seconds) {
        Ok((seconds * 1e6).round() as u128)
    } else {
        Err(format!("svetlo.{key} in its header is {seconds}, not a time"))
    }
}

fn in_seconds(microseconds: u128) -> String {
    format!("{}.{:06}", microseconds / 1_000_000, microseconds % 1_000_000)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sum of these texts under `key`, as a header of parts has it.
    fn sum(texts: &[(&str, Option<&str>)]) -> (String, Option<String>) {
        let read = |&(text, rest): &(&str, Option<&str>)| {
            let mut header = BTreeMap::from([("svetlo.a".to_owned(), text.to_owned())]);
            header.extend(rest.map(|rest| ("svetlo.rest.a".to_owned(), rest.to_owned())));
            Sum::read(&header, "a").unwrap()
        };
        match texts.iter().map(read).reduce(Sum::plus).unwrap() {
            Sum::Count(count) => (count.to_string(), None),
            Sum::Weight(w) => (w.value().to_string(), (w.rest() != 0.0).then(|| w.rest().to_string())),
        }
    }

    #[test]
    fn counts_and_weights_add_up_exactly() {
        let most = u64::MAX.to_string();
        assert_eq!(sum(&[("3", None), ("4", None)]), ("7".into(), None));
        assert_eq!(sum(&[(&most, None), ("0", None)]).0, most);
        assert_eq!(sum(&[("0.5", None), ("4", None)]), ("4.5".into(), None));
        // 0.1 is 2^-55 · 3602879701896397: beside 2^53 + 2 the sum's rest is what float64 cannot hold.
        let (value, rest) = sum(&[("9007199254740994", None), ("0.1", None)]);
        assert_eq!((value.as_str(), rest.as_deref()), ("9007199254740994", Some("0.1")));
        // It comes back, and goes again.
        assert_eq!(sum(&[(&value, rest.as_deref()), ("-9007199254740994", None)]), ("0.1".into(), None));
    }

    #[test]
    fn times_are_whole_microseconds() {
        let header = |text: &str| BTreeMap::from([("svetlo.t".to_owned(), text.to_owned())]);
        assert_eq!(microseconds(&header("12.000345"), "t"), Ok(12_000_345));
        assert_eq!(in_seconds(12_000_345), "12.000345");
        for text in ["-1", "1e13", "NaN", "inf"] {
            assert!(microseconds(&header(text), "t").unwrap_err().contains("not a time"), "{text}");
        }
    }
}
