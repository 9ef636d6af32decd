//! EXR files: float32 written losslessly, any flat layout read.
//!
//! Writes one part in ZIP16 scan lines, which every EXR reader knows. Reads scan lines or tiles,
//! the largest level of mip maps, half, float and uint samples, and every compression the `exr`
//! crate decodes (DWAA and DWAB among them). A file is untrusted: what its header claims is
//! checked against its length before anything is allocated.

use std::{
    collections::{BTreeMap, HashSet},
    io::{self, BufReader, Read, Seek},
    panic::{AssertUnwindSafe, catch_unwind},
    path::Path,
};

use exr::block::reader::ChunksReader;
use exr::prelude::{self as openexr, ReadChannels, ReadLayers, Text, WritableImage};
use openexr::{
    AnyChannel, AnyChannels, AttributeValue, FlatSamples, Image, ImageAttributes, Layer, LayerAttributes,
};

use super::{
    atomic::write_atomically,
    exr_lent::Lent,
    types::{Channel, Picture, Samples, colour_names},
    unreadable,
};
use crate::error::{Error, Result};
use crate::input;

/// The most pixels a picture may have: 2²⁸, or 16384×16384.
pub const MAX_PIXELS: usize = 1 << 28;
/// The most bytes the samples of one EXR part may take in memory: 64 GiB, for [`MAX_PIXELS`] with 64 channels.
pub const MAX_BYTES: u64 = 1 << 36;

/// Writes a picture as EXR (float32 and uint32, ZIP16), atomically.
///
/// Metadata become text attributes in UTF-8. The channels are stored sorted by name.
///
/// # Errors
/// [`Error::Failed`] where the picture is not writable ([`Picture::validate`]), a metadata name
/// is one that EXR reserves, or the disk refuses; an old file at `path` is then untouched.
pub fn write_exr(path: &Path, picture: &Picture) -> Result<()> {
    let fail = |what: String| Error::Failed(format!("{}: cannot be written as EXR: {what}", path.display()));
    picture.validate().map_err(fail)?;
    let image = to_image(picture).map_err(fail)?;
    write_atomically(path, |file| image.write().to_buffered(file).map_err(to_io))
}

/// Reads an EXR file: the first part with colour (`R G B` or `Y`), else the first flat part.
///
/// Half floats are widened; text and numeric attributes become metadata. The data window is the
/// picture; its offset in the display window is dropped.
///
/// # Errors
/// [`Error::Input`] where the file cannot be opened, is damaged, has only deep data, or claims
/// more than [`MAX_PIXELS`] or [`MAX_BYTES`].
pub fn read_exr(path: &Path) -> Result<Picture> {
    let (file, length) = input::open(path).map_err(|cause| unreadable(path, &cause))?;
    decode_guarded(BufReader::new(file), length)
        .map_err(|what| Error::Input(format!("{}: {what}", path.display())))
}

/// [`decode`], with a panic of the decoder turned into an error.
///
/// `exr` means to answer damage with errors, and random damage has not made it panic, but its
/// decoders hold `expect`s and index by values from the file; a damaged file must not end the
/// program. All its state is local to the call and is dropped by the unwinding, so nothing broken
/// is seen afterwards. Decoding stays on this thread: a panic on a worker thread is not caught.
fn decode_guarded(reader: impl Read + Seek, length: u64) -> Result<Picture, String> {
    catch_unwind(AssertUnwindSafe(|| decode(reader, length)))
        .unwrap_or_else(|_| Err("a damaged EXR file (its decoder gave up); write it again".into()))
}

/// Reads what [`read_exr`] would read, but for the samples: a picture without channels, only its size and metadata.
///
/// # Errors
/// As [`read_exr`], as far as the header shows it.
pub fn read_exr_header(path: &Path) -> Result<Picture> {
    let (file, length) = input::open(path).map_err(|cause| unreadable(path, &cause))?;
    let header = AssertUnwindSafe(|| decode_header(BufReader::new(file), length));
    catch_unwind(header)
        .unwrap_or_else(|_| Err("a damaged EXR file (its decoder gave up); write it again".into()))
        .map_err(|what| Error::Input(format!("{}: {what}", path.display())))
}

fn decode_header(reader: impl Read + Seek, length: u64) -> Result<Picture, String> {
    let chunks = exr::block::read(reader, false).map_err(describe)?;
    let headers = chunks.headers();
    for header in headers {
        check_claims(header, length)?;
    }
    let header = Part::choose(headers)?.1;
    let metadata = metadata_of(&header.shared_attributes, &header.own_attributes);
    Ok(Picture { metadata, ..Picture::new(header.layer_size.x(), header.layer_size.y()) })
}

fn decode(mut reader: impl Read + Seek, length: u64) -> Result<Picture, String> {
    let chunks = exr::block::read(&mut reader, false).map_err(describe)?;
    let mut claimed = 0_u64;
    for header in chunks.headers() {
        claimed = claimed.saturating_add(check_claims(header, length)?);
    }
    if claimed > input::credible(length) {
        unpack(chunks)?;
    }
    reader.rewind().map_err(|cause| describe(cause.into()))?;
    let chunks = exr::block::read(reader, false).map_err(describe)?;
    let part = Part::choose(chunks.headers())?.0;
    let image = openexr::read().no_deep_data().largest_resolution_level().all_channels();
    let image = ReadPart { part, channels: image }
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_chunks(chunks)
        .map_err(describe)?;
    let metadata = metadata_of(&image.attributes, &image.layer_data.attributes);
    let Layer { channel_data, size, .. } = image.layer_data;
    let channels = channel_data.list.into_iter().map(to_channel).collect();
    let picture = Picture { width: size.x(), height: size.y(), channels, metadata };
    picture.validate().map_err(|what| format!("a damaged EXR file: {what}"))?;
    Ok(picture)
}

/// Unpacks all blocks and keeps none: that they hold what the headers claim, before there is room made for it.
fn unpack(chunks: exr::block::reader::Reader<impl Read + Seek>) -> Result<(), String> {
    let flat = |meta: &exr::meta::MetaData, _, block: exr::block::BlockIndex| !meta.headers[block.layer].deep;
    let blocks = chunks.filter_chunks(false, flat).map_err(describe)?;
    let mut found = HashSet::new();
    for block in blocks.sequential_decompressor(false) {
        if !found.insert(block.map_err(describe)?.index) {
            return Err("a damaged EXR file: it has the same block twice; write it again".into());
        }
    }
    Ok(())
}

/// Compares what a header claims with the limits and with what `length` bytes can hold; how many bytes its samples take.
fn check_claims(header: &exr::meta::header::Header, length: u64) -> Result<u64, String> {
    let (width, height) = (header.layer_size.x(), header.layer_size.y());
    let pixels = width.checked_mul(height).filter(|&pixels| pixels <= MAX_PIXELS);
    let pixels = pixels.ok_or_else(|| {
        format!("claims {width}×{height} pixels; at most {MAX_PIXELS} are read, so scale it down")
    })?;
    let bytes = (pixels as u64).saturating_mul(header.channels.bytes_per_pixel as u64);
    if bytes > MAX_BYTES {
        return Err(format!(
            "claims {bytes} bytes of samples; at most {MAX_BYTES} are read, so drop channels"
        ));
    }
    // Each chunk takes 8 bytes in the offset table and 8 or more of its own.
    let chunks = (header.chunk_count as u64).saturating_mul(16);
    let block = header.max_block_pixel_size();
    let block = (block.area() as u64).saturating_mul(header.channels.bytes_per_pixel as u64);
    if block > input::credible(length) {
        return Err(format!(
            "a damaged EXR file: it claims blocks of {block} bytes and has only {length}; write it again in smaller ones"
        ));
    }
    if chunks > length || bytes > length.saturating_mul(max_ratio(header.compression)) {
        return Err(format!(
            "a damaged EXR file: it claims {width}×{height} pixels and has only {length} bytes; write it again"
        ));
    }
    Ok(bytes)
}

/// The most that a compression can shrink a picture, rounded up; a file that claims more lies.
///
/// Deflate reaches 1032, the others without a transform less. DWA keeps 4 of the 128 bytes of a
/// constant 8×8 half block and deflates those: 33 024.
fn max_ratio(compression: exr::compression::Compression) -> u64 {
    use exr::compression::Compression;
    match compression {
        Compression::DWAA(_) | Compression::DWAB(_) => 1 << 16,
        _ => 1 << 11,
    }
}

/// Which part of a file is read: enough of its header to know it again.
struct Part {
    name: Option<Text>,
    channels: exr::meta::attribute::ChannelList,
}

impl Part {
    /// The part to read, and its header.
    fn choose(headers: &[exr::meta::header::Header]) -> Result<(Self, &exr::meta::header::Header), String> {
        let flat = || headers.iter().filter(|header| !header.deep);
        let has_colour = |header: &&exr::meta::header::Header| {
            let names: Vec<String> = header.channels.list.iter().map(|c| c.name.to_string()).collect();
            colour_names(names.iter().map(String::as_str)).is_some()
        };
        let header = flat().find(has_colour).or_else(|| flat().next());
        header
            .map(|header| {
                let name = header.own_attributes.layer_name.clone();
                (Self { name, channels: header.channels.clone() }, header)
            })
            .ok_or_else(|| "an EXR file with deep data only; flatten it first".into())
    }
}

/// Makes `exr` read just the chosen part.
struct ReadPart<C> {
    part: Part,
    channels: C,
}

impl<'s, C: ReadChannels<'s>> ReadChannels<'s> for ReadPart<C> {
    type Reader = C::Reader;

    fn create_channels_reader(
        &'s self,
        header: &exr::meta::header::Header,
    ) -> exr::error::Result<Self::Reader> {
        let Part { name, channels } = &self.part;
        if header.deep || header.own_attributes.layer_name != *name || header.channels != *channels {
            return Err(exr::error::Error::NotSupported("another part".into()));
        }
        self.channels.create_channels_reader(header)
    }
}

fn to_channel(channel: AnyChannel<FlatSamples>) -> Channel {
    let data = match channel.sample_data {
        FlatSamples::F16(values) => Samples::F32(values.into_iter().map(half::f16::to_f32).collect()),
        FlatSamples::F32(values) => Samples::F32(values),
        FlatSamples::U32(values) => Samples::U32(values),
    };
    Channel { name: channel.name.to_string(), data }
}

/// The text and number attributes of a file, as text.
fn metadata_of(image: &ImageAttributes, layer: &LayerAttributes) -> BTreeMap<String, String> {
    let custom = image.other.iter().chain(&layer.other);
    let custom = custom.filter_map(|(name, value)| Some((utf8(name), as_text(value)?)));
    let standard = STANDARD_TEXTS
        .iter()
        .filter_map(|(name, field)| Some(((*name).to_owned(), utf8(field(&mut layer.clone()).as_ref()?))));
    custom.chain(standard).collect()
}

fn as_text(value: &AttributeValue) -> Option<String> {
    match value {
        AttributeValue::Text(text) => Some(utf8(text)),
        AttributeValue::F64(number) => Some(number.to_string()),
        AttributeValue::F32(number) => Some(number.to_string()),
        AttributeValue::I32(number) => Some(number.to_string()),
        _ => None,
    }
}

/// EXR texts are bytes; today's writers mean UTF-8, old ones Latin-1.
fn utf8(text: &Text) -> String {
    String::from_utf8(text.bytes().to_vec()).unwrap_or_else(|_| text.to_string())
}

type TextField = fn(&mut LayerAttributes) -> &mut Option<Text>;

/// Standard attributes that `exr` keeps in fields of their own instead of among the custom ones.
const STANDARD_TEXTS: [(&str, TextField); 4] = [
    ("owner", |layer| &mut layer.owner),
    ("comments", |layer| &mut layer.comments),
    ("capDate", |layer| &mut layer.capture_date),
    ("software", |layer| &mut layer.software_name),
];

fn to_image(picture: &Picture) -> Result<Image<Layer<AnyChannels<Lent<'_>>>>, String> {
    let mut attributes = LayerAttributes::default();
    for (name, value) in &picture.metadata {
        if name.is_empty() || name.len() > 255 || !name.bytes().all(|byte| byte.is_ascii_graphic()) {
            return Err(format!("metadata name `{name}`; it must be 1 to 255 visible ASCII characters"));
        }
        let value = Text::from_slice_unchecked(value.as_bytes());
        match STANDARD_TEXTS.iter().find(|(standard, _)| standard == name) {
            Some((_, field)) => *field(&mut attributes) = Some(value),
            None => {
                let name = Text::from_slice_unchecked(name.as_bytes());
                attributes.other.insert(name, AttributeValue::Text(value));
            }
        }
    }
    let channels = picture.channels.iter().map(Lent::channel).collect();
    let encoding = openexr::Encoding {
        compression: openexr::Compression::ZIP16,
        blocks: openexr::Blocks::ScanLines,
        line_order: openexr::LineOrder::Increasing,
    };
    let size = (picture.width, picture.height);
    Ok(Image::from_layer(Layer::new(size, attributes, encoding, AnyChannels::sort(channels))))
}

fn to_io(error: exr::error::Error) -> io::Error {
    match error {
        exr::error::Error::Io(cause) => cause,
        other => io::Error::other(other.to_string()),
    }
}

fn describe(error: exr::error::Error) -> String {
    match error {
        exr::error::Error::NotSupported(what) => {
            format!("an EXR file of an unsupported kind ({what}); save it as flat scan lines")
        }
        exr::error::Error::Io(cause) => format!("cannot be read ({cause}); check the disk"),
        exr::error::Error::Invalid(what) if what == "file identifier missing" => {
            "not an EXR file; save it as EXR".into()
        }
        other => format!("a damaged EXR file ({other}); write it again"),
    }
}

#[cfg(test)]
#[path = "exr_tests.rs"]
mod tests;
