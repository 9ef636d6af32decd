//! Pictures of the results as small data URIs.

use std::{
    io::BufReader,
    path::{Component, Path},
};

use base64::{Engine, engine::general_purpose::STANDARD};
use image::{ExtendedColorType, ImageEncoder, ImageFormat, ImageReader, codecs::png::PngEncoder, imageops};

/// Pixels of a thumbnail's longer side, at most.
const LONGEST: u32 = 320;

/// A PNG of the results, small enough for a page, as a data URI; `None` where it is missing or damaged: a report of
/// what there is says more than none.
pub fn thumbnail(folder: &Path, name: &str) -> Option<String> {
    // The names come from a file: none leads out of the folder.
    let inside = Path::new(name).components().all(|part| matches!(part, Component::Normal(_)));
    let file = std::fs::File::open(folder.join(name)).ok().filter(|_| inside)?;
    let mut reader = ImageReader::with_format(BufReader::new(file), ImageFormat::Png);
    reader.limits(image::Limits::default());
    let picture = reader.decode().ok()?.to_rgb8();
    let (width, height) = picture.dimensions();
    let factor = f64::from(LONGEST) / f64::from(width.max(height));
    let small = if factor < 1.0 {
        let side = |length: u32| ((f64::from(length) * factor).round() as u32).max(1);
        imageops::resize(&picture, side(width), side(height), imageops::FilterType::Triangle)
    } else {
        picture
    };
    let mut png = Vec::new();
    let (width, height) = small.dimensions();
    PngEncoder::new(&mut png).write_image(&small, width, height, ExtendedColorType::Rgb8).ok()?;
    Some(format!("data:image/png;base64,{}", STANDARD.encode(png)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn size(uri: &str) -> (u32, u32) {
        let png = STANDARD.decode(uri.strip_prefix("data:image/png;base64,").unwrap()).unwrap();
        let picture = image::load_from_memory_with_format(&png, ImageFormat::Png).unwrap();
        (picture.width(), picture.height())
    }

    #[test]
    fn large_pictures_become_small_and_small_ones_stay() {
        let folder = tempfile::tempdir().unwrap();
        for (width, height, expected) in [(1000, 250, (320, 80)), (64, 32, (64, 32)), (2, 5000, (1, 320))] {
            image::RgbImage::new(width, height).save(folder.path().join("a.png")).unwrap();
            assert_eq!(size(&thumbnail(folder.path(), "a.png").unwrap()), expected);
        }
    }

    #[test]
    fn what_is_missing_damaged_or_elsewhere_is_left_out() {
        let folder = tempfile::tempdir().unwrap();
        let inner = folder.path().join("inner");
        std::fs::create_dir(&inner).unwrap();
        let outside = folder.path().join("a.png");
        image::RgbImage::new(2, 2).save(&outside).unwrap();
        std::fs::write(inner.join("bad.png"), b"\x89PNG\r\n\x1a\n").unwrap();
        assert!(thumbnail(folder.path(), "a.png").is_some());
        for name in ["b.png", "bad.png", "", "../a.png", outside.to_str().unwrap()] {
            assert_eq!(thumbnail(&inner, name), None, "{name}");
        }
    }
}
