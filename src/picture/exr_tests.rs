//! Round trips, foreign layouts and damaged files.

use std::io::Cursor;

use exr::meta::{
    BlockDescription,
    attribute::{ChannelDescription, SampleType},
    header::Header,
};
use half::f16;
use openexr::{Blocks, Compression, Encoding, Layers, LineOrder, SmallVec, Vec2};
use proptest::prelude::*;

use super::*;

fn sample_picture() -> Picture {
    let (width, height) = (37, 21);
    let n = width * height;
    let ramp = |k: f32| (0..n).map(|i| i as f32 * k - 3.0).collect::<Vec<_>>();
    let mut odd = ramp(0.1);
    odd[..6].copy_from_slice(&[f32::NAN, f32::INFINITY, -0.0, f32::MIN_POSITIVE / 4.0, f32::MAX, 1e5]);
    let mut picture = Picture::new(width, height)
        .with_channel("R", odd)
        .with_channel("G", ramp(1e-9))
        .with_channel("B", ramp(1e9))
        .with_channel("variance.R", ramp(2.0))
        .with_counts("samples", (0..n as u32).map(|i| u32::MAX - i).collect());
    for (name, value) in
        [("svetlo.seed", "7"), ("svetlo.note", "σ_t, 3 mm⁻¹"), ("comments", "c"), ("owner", "")]
    {
        picture.metadata.insert(name.into(), value.into());
    }
    picture
}

fn bits(samples: &Samples) -> Vec<u32> {
    match samples {
        Samples::F32(values) => values.iter().map(|value| value.to_bits()).collect(),
        Samples::U32(values) => values.clone(),
    }
}

fn encoded(picture: &Picture) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    to_image(picture).unwrap().write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

fn read_bytes(bytes: &[u8]) -> Result<Picture, String> {
    decode_guarded(Cursor::new(bytes), bytes.len() as u64)
}

#[test]
fn round_trip_keeps_every_bit_and_all_text() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.exr");
    let written = sample_picture();
    write_exr(&path, &written).unwrap();
    let read = read_exr(&path).unwrap();
    assert_eq!((read.width, read.height), (written.width, written.height));
    assert_eq!(read.metadata, written.metadata);
    let names: Vec<_> = read.channels.iter().map(|channel| channel.name.as_str()).collect();
    assert_eq!(names, ["B", "G", "R", "samples", "variance.R"]);
    for channel in &written.channels {
        assert_eq!(bits(read.channel(&channel.name).unwrap()), bits(&channel.data), "{}", channel.name);
    }
}

#[test]
fn headers_are_those_of_whole_files_or_none() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.exr");
    let written = sample_picture();
    write_exr(&path, &written).unwrap();
    let header = read_exr_header(&path).unwrap();
    assert_eq!(header, Picture { channels: Vec::new(), ..read_exr(&path).unwrap() });
    assert_eq!(header.metadata, written.metadata);
    let bytes = std::fs::read(&path).unwrap();
    for length in [0, 3, 100] {
        std::fs::write(&path, &bytes[..length]).unwrap();
        let [header, whole] =
            [read_exr_header(&path), read_exr(&path)].map(|read| read.unwrap_err().to_string());
        assert_eq!(header, whole, "of {length} bytes");
    }
    assert!(read_exr_header(&folder.path().join("none.exr")).is_err());
}

#[test]
fn reserved_metadata_names_are_refused_and_the_old_file_stays() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.exr");
    std::fs::write(&path, b"old").unwrap();
    for name in ["dataWindow", "channels", "", "a b"] {
        let mut picture = sample_picture();
        picture.metadata.insert(name.into(), "x".into());
        assert_eq!(write_exr(&path, &picture).unwrap_err().exit_code(), 1, "{name}");
    }
    assert_eq!(std::fs::read(&path).unwrap(), b"old");
}

fn layer(
    name: &str,
    channels: &[(&str, FlatSamples)],
    encoding: Encoding,
) -> Layer<AnyChannels<FlatSamples>> {
    let list: SmallVec<_> =
        channels.iter().map(|(name, samples)| AnyChannel::new(*name, samples.clone())).collect();
    Layer::new((40, 30), LayerAttributes::named(name), encoding, AnyChannels::sort(list))
}

#[test]
fn reads_tiles_halves_and_the_part_with_colour() {
    let n = 40 * 30;
    let half: Vec<f16> = (0..n).map(|i| f16::from_f32(i as f32 / 8.0)).collect();
    let depth = FlatSamples::F32(vec![1.0; n]);
    let colour = FlatSamples::F16(half.clone());
    for compression in [Compression::Uncompressed, Compression::RLE, Compression::ZIP1, Compression::PIZ] {
        for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(16, 8))] {
            let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
            let rgb = [("R", colour.clone()), ("G", colour.clone()), ("B", colour.clone())];
            let layers: Layers<_> =
                [layer("depth", &[("Z", depth.clone())], encoding), layer("beauty", &rgb, encoding)]
                    .into_iter()
                    .collect();
            let image = Image::from_layers(openexr::ImageAttributes::with_size((40, 30)), layers);
            let mut bytes = Cursor::new(Vec::new());
            image.write().to_buffered(&mut bytes).unwrap();
            let read = read_bytes(bytes.get_ref()).unwrap();
            let planes = read.colour().unwrap();
            assert_eq!(planes.len(), 3);
            assert!(planes[1].data.iter().zip(&half).all(|(read, half)| *read == half.to_f32()));
        }
    }
}

#[test]
fn a_claim_of_a_billion_rows_is_refused_at_once() {
    let mut bytes = encoded(&Picture::new(8, 8).with_channel("Y", vec![0.5; 64]));
    let at = bytes.windows(11).position(|window| window == b"dataWindow\0").unwrap();
    let corner = at + "dataWindow\0box2i\0".len() + 4 + 8;
    for (x, y) in [(999_999_999_i32, 999_999_999_i32), (16_383, 16_383), (0, 100_000_000)] {
        bytes[corner..corner + 4].copy_from_slice(&x.to_le_bytes());
        bytes[corner + 4..corner + 8].copy_from_slice(&y.to_le_bytes());
        let started = std::time::Instant::now();
        let error = read_bytes(&bytes).unwrap_err();
        assert!(error.contains(';'), "{error}");
        assert!(started.elapsed().as_secs() < 5, "{error}");
    }
}

/// `exr` refuses most false sizes itself, so the check is tested on headers of its own.
#[test]
fn claims_are_held_against_the_length_of_the_file() {
    let header = |side: usize, channels: usize, compression| {
        let channels = (0..channels)
            .map(|c| ChannelDescription::named(c.to_string().as_str(), SampleType::F32))
            .collect();
        Header::new("part".into(), (side, side), channels).with_encoding(
            compression,
            BlockDescription::ScanLines,
            LineOrder::Increasing,
        )
    };
    let zip = |side, channels| header(side, channels, Compression::ZIP16);
    let fault = |header: &Header, length| check_claims(header, length).unwrap_err();
    // 16384² floats are 2³⁰ bytes, and deflate shrinks no further than 2¹¹-fold.
    assert_eq!(check_claims(&zip(1 << 14, 1), 1 << 19), Ok(1 << 30));
    assert!(fault(&zip(1 << 14, 1), (1 << 19) - 1).contains("has only 524287 bytes"));
    assert_eq!(check_claims(&header(1 << 14, 1, Compression::DWAB(None)), 1 << 14), Ok(1 << 30));
    // 100 lines of one chunk each need 1600 bytes for their tables alone.
    assert_eq!(check_claims(&header(100, 1, Compression::ZIP1), 1600), Ok(40_000));
    assert!(fault(&header(100, 1, Compression::ZIP1), 1599).contains("damaged"));
    assert!(fault(&zip((1 << 14) + 1, 1), u64::MAX).contains("pixels"));
    assert!(fault(&zip(1 << 14, 65), u64::MAX).contains("bytes of samples"));
}

#[test]
fn errors_name_the_path_and_the_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("no.exr");
    for content in [None, Some(&b""[..]), Some(b"text, not a picture at all")] {
        if let Some(content) = content {
            std::fs::write(&path, content).unwrap();
        }
        let error = read_exr(&path).unwrap_err();
        assert_eq!(error.exit_code(), 2);
        let text = error.to_string();
        assert!(text.starts_with(&path.display().to_string()) && text.contains(';'), "{text}");
    }
    assert_eq!(read_exr(folder.path()).unwrap_err().exit_code(), 2);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn damaged_files_never_panic(
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        in_header in any::<bool>(),
        keep in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let mut bytes = encoded(&sample_picture());
        let range = if in_header { 400.min(bytes.len()) } else { bytes.len() };
        for (index, value) in flips {
            bytes[index.index(range)] = value;
        }
        if let Some(keep) = keep {
            bytes.truncate(keep.index(bytes.len()));
        }
        if let Ok(picture) = read_bytes(&bytes) {
            prop_assert_eq!(picture.validate(), Ok(()));
        }
    }
}
