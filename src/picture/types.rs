//! The picture in memory: named planes of samples and text metadata.

use std::{borrow::Cow, collections::BTreeMap};

use super::exr::MAX_PIXELS;

/// The samples of one channel, row by row from the top left, `width · height` of them.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// Linear values, 32-bit float. Half floats are widened to this when read.
    F32(Vec<f32>),
    /// Counts, such as samples per pixel.
    U32(Vec<u32>),
}

impl Samples {
    /// How many samples there are.
    pub fn len(&self) -> usize {
        match self {
            Self::F32(values) => values.len(),
            Self::U32(values) => values.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The samples as floats; counts are rounded to the nearest float.
    pub fn to_f32(&self) -> Cow<'_, [f32]> {
        match self {
            Self::F32(values) => Cow::Borrowed(values),
            Self::U32(values) => values.iter().map(|&count| count as f32).collect(),
        }
    }
}

/// One named plane of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Such as `R`, `Z` or `variance.G`.
    pub name: String,
    /// `width · height` samples.
    pub data: Samples,
}

/// A picture: planes of equal size, and text about them.
///
/// Channels that this crate gives a meaning: `R` `G` `B` (linear, Rec. 709 primaries) or `Y`;
/// `A`; `Z`; `variance.R` and so on, the variance **of one sample** of that channel; `samples`,
/// how many samples the mean in `R` `G` `B` was taken over.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The planes, in any order; EXR files hold and return them sorted by name.
    pub channels: Vec<Channel>,
    /// Text attributes by name.
    pub metadata: BTreeMap<String, String>,
}

/// One colour plane of a picture, see [`Picture::colour`].
#[derive(Clone, Debug)]
pub struct Plane<'a> {
    /// `R`, `G`, `B` or `Y`, without the prefix of its layer.
    pub name: &'static str,
    /// `width · height` linear values.
    pub data: Cow<'a, [f32]>,
}

impl Picture {
    /// A picture of this size without channels.
    pub fn new(width: usize, height: usize) -> Self {
        Self { width, height, ..Self::default() }
    }

    /// The same picture with one more float channel, `width · height` values.
    #[must_use]
    pub fn with_channel(self, name: &str, values: Vec<f32>) -> Self {
        self.with_samples(name, Samples::F32(values))
    }

    /// The same picture with one more channel of counts, `width · height` values.
    #[must_use]
    pub fn with_counts(self, name: &str, values: Vec<u32>) -> Self {
        self.with_samples(name, Samples::U32(values))
    }

    fn with_samples(mut self, name: &str, data: Samples) -> Self {
        self.channels.push(Channel { name: name.to_owned(), data });
        self
    }

    /// The samples of the channel with exactly this name.
    pub fn channel(&self, name: &str) -> Option<&Samples> {
        self.channels.iter().find(|channel| channel.name == name).map(|channel| &channel.data)
    }

    /// The colour planes: `R`, `G`, `B`; else `Y` alone; else the same behind a layer prefix
    /// (`combined.R`). `None` where the picture has no colour.
    pub fn colour(&self) -> Option<Vec<Plane<'_>>> {
        let found = colour_names(self.channels.iter().map(|channel| channel.name.as_str()))?;
        found
            .into_iter()
            .map(|(name, full)| Some(Plane { name, data: self.channel(&full)?.to_f32() }))
            .collect()
    }

    /// Checks that the picture can be written: a size, at least one channel, lengths and names.
    ///
    /// # Errors
    /// What is wrong, as a clause without the path.
    pub fn validate(&self) -> Result<(), String> {
        let (width, height) = (self.width, self.height);
        let pixels = width.checked_mul(height).filter(|&n| n > 0 && n <= MAX_PIXELS);
        let pixels = pixels.ok_or_else(|| {
            format!("a size of {width}×{height}; it must be at least 1×1 and at most {MAX_PIXELS} pixels")
        })?;
        if self.channels.is_empty() {
            return Err("no channels; a picture needs at least one".into());
        }
        let mut seen = std::collections::BTreeSet::new();
        for Channel { name, data } in &self.channels {
            if data.len() != pixels {
                return Err(format!("channel `{name}` has {} samples; it must have {pixels}", data.len()));
            }
            if name.is_empty() || name.len() > 255 || !name.bytes().all(|byte| byte.is_ascii_graphic()) {
                return Err(format!("channel name `{name}`; it must be 1 to 255 visible ASCII characters"));
            }
            if !seen.insert(name) {
                return Err(format!("two channels named `{name}`; names must differ"));
            }
        }
        Ok(())
    }
}

/// Which of `names` are the colour channels: (short name, full name) for `R G B` or `Y`.
///
/// A prefix is tried last, and `variance.` never: it is not colour but its noise.
pub(super) fn colour_names<'a>(
    names: impl Iterator<Item = &'a str> + Clone,
) -> Option<Vec<(&'static str, String)>> {
    const SETS: [&[&str]; 2] = [&["R", "G", "B"], &["Y"]];
    let prefixes = names.clone().filter_map(|name| Some(&name[..=name.rfind('.')?]));
    let prefixes = std::iter::once("").chain(prefixes.filter(|&prefix| prefix != "variance."));
    for prefix in prefixes {
        for set in SETS {
            let full = set.iter().map(|&short| (short, format!("{prefix}{short}")));
            if full.clone().all(|(_, full)| names.clone().any(|name| name == full)) {
                return Some(full.collect());
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(list: &[&str]) -> Option<Vec<String>> {
        colour_names(list.iter().copied()).map(|found| found.into_iter().map(|(_, full)| full).collect())
    }

    #[test]
    fn colour_prefers_plain_rgb_then_grey_then_a_layer() {
        assert_eq!(names(&["B", "G", "R", "Y"]), Some(vec!["R".into(), "G".into(), "B".into()]));
        assert_eq!(names(&["Y", "l.B", "l.G", "l.R"]), Some(vec!["Y".into()]));
        assert_eq!(names(&["l.x.B", "l.x.G", "l.x.R"]).map(|found| found[0].clone()), Some("l.x.R".into()));
        assert_eq!(names(&["variance.R", "variance.G", "variance.B", "samples"]), None);
        assert_eq!(names(&["R", "G"]), None);
    }

    #[test]
    fn validate_names_each_fault() {
        let good = Picture::new(2, 1).with_channel("R", vec![0.0; 2]);
        assert_eq!(good.validate(), Ok(()));
        let fault = |picture: Picture| picture.validate().unwrap_err();
        assert!(fault(Picture::new(0, 3)).contains("0×3"));
        assert!(fault(Picture::new(usize::MAX, 2)).contains("pixels"));
        assert!(fault(Picture::new(1, 1)).contains("no channels"));
        assert!(fault(good.clone().with_counts("n", vec![1])).contains("1 samples; it must have 2"));
        assert!(fault(good.clone().with_channel("R", vec![0.0; 2])).contains("two channels"));
        assert!(fault(good.with_channel("ä b", vec![0.0; 2])).contains("ASCII"));
    }
}
