//! Planes of a picture as `exr` writes them, without a copy: all together they weigh more than the film.

use super::types::{Channel, Samples};
use exr::block::lines::LineRefMut;
use exr::image::write::samples::{SamplesWriter, WritableSamples};
use exr::math::RoundingMode;
use exr::meta::attribute::{LevelMode, SampleType, Text};
use exr::meta::header::Header;
use exr::prelude::AnyChannel;

/// The samples of a channel that belongs to a picture.
pub(super) struct Lent<'p>(&'p Samples);

impl<'p> Lent<'p> {
    pub(super) fn channel(channel: &'p Channel) -> AnyChannel<Self> {
        AnyChannel::new(Text::from_slice_unchecked(channel.name.as_bytes()), Self(&channel.data))
    }
}

impl<'p> WritableSamples<'_> for Lent<'p> {
    type Writer = LentWriter<'p>;

    fn sample_type(&self) -> SampleType {
        match self.0 {
            Samples::F32(_) => SampleType::F32,
            Samples::U32(_) => SampleType::U32,
        }
    }

    fn infer_level_modes(&self) -> (LevelMode, RoundingMode) {
        (LevelMode::Singular, RoundingMode::Down)
    }

    fn create_samples_writer(&self, header: &Header) -> LentWriter<'p> {
        LentWriter { samples: self.0, width: header.layer_size.x() }
    }
}

pub(super) struct LentWriter<'p> {
    samples: &'p Samples,
    /// Pixels per row.
    width: usize,
}

impl SamplesWriter for LentWriter<'_> {
    fn extract_line(&self, line: LineRefMut<'_>) {
        let start = line.location.position.y() * self.width + line.location.position.x();
        let range = start..start + line.location.sample_count;
        let written = match self.samples {
            Samples::F32(values) => line.write_samples_from_slice(&values[range]),
            Samples::U32(values) => line.write_samples_from_slice(&values[range]),
        };
        // The line is a buffer of that many samples of the type that the header names.
        written.expect("a line as long as its header says");
    }
}
