//! Reads a two-dimensional transfer function from a picture: PNG (sRGB colour, linear alpha) or EXR (linear).

use std::path::Path;

use exr::prelude as exr;
use image::{ImageFormat, ImageReader};

use super::TransferFunction2d;
use crate::config::formats::srgb_to_linear;
use crate::error::{Error, Result};

/// Entries of a table per axis. A table is looked up, not looked at: more has no use.
const SIDE: std::ops::RangeInclusive<usize> = 2..=4096;

/// Reads the picture by the ending of its name; its bottom row becomes row 0.
///
/// # Errors
/// [`Error::Input`] if it cannot be read, is neither PNG nor EXR, has a side outside 2..=4096, or has values
/// outside 0..=1.
pub(super) fn read(path: &Path) -> Result<TransferFunction2d> {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    let (width, height, rows) = match ending.as_deref() {
        Some("png") => read_png(path)?,
        Some("exr") => read_exr(path)?,
        _ => return Err(fail(path, "its name must end in .png or .exr")),
    };
    if let Some(index) = rows.iter().position(|entry| !entry.iter().all(|c| (0.0..=1.0).contains(c))) {
        let (x, y) = (index % width, index / width);
        let [r, g, b, a] = rows[index];
        let message =
            format!("pixel ({x}, {y}) from the top left is ({r}, {g}, {b}, {a}), but all must be in 0..1");
        return Err(fail(path, &message));
    }
    let rgba = rows.chunks(width).rev().flatten().copied().collect();
    Ok(TransferFunction2d { width, height, rgba, emission: None })
}

type Rows = (usize, usize, Vec<[f64; 4]>);

fn read_png(path: &Path) -> Result<Rows> {
    let reader = || {
        ImageReader::open(path).map(|mut reader| {
            reader.set_format(ImageFormat::Png);
            reader
        })
    };
    let opened = reader().map_err(|error| fail(path, &error.to_string()))?;
    let (width, height) = opened.into_dimensions().map_err(|error| fail(path, &error.to_string()))?;
    check_size(path, width as usize, height as usize)?;
    let opened = reader().map_err(|error| fail(path, &error.to_string()))?;
    let pixels = opened.decode().map_err(|error| fail(path, &error.to_string()))?.into_rgba16();
    let entry = |pixel: &image::Rgba<u16>| {
        let [r, g, b, a] = pixel.0.map(|component| f64::from(component) / 65535.0);
        [srgb_to_linear(r), srgb_to_linear(g), srgb_to_linear(b), a]
    };
    Ok((width as usize, height as usize, pixels.pixels().map(entry).collect()))
}

fn read_exr(path: &Path) -> Result<Rows> {
    let fail_exr = |error: exr::Error| fail(path, &error.to_string());
    // The size is checked before anything is allocated for it.
    let meta = exr::MetaData::read_from_file(path, false).map_err(fail_exr)?;
    for header in &meta.headers {
        check_size(path, header.layer_size.width(), header.layer_size.height())?;
    }
    let image = exr::read_first_rgba_layer_from_file(
        path,
        |size, _| (size.width(), vec![[0.0; 4]; size.area()]),
        |(width, rows), at, (r, g, b, a): (f32, f32, f32, f32)| {
            if let Some(entry) = rows.get_mut(at.y() * *width + at.x()) {
                *entry = [r, g, b, a].map(f64::from);
            }
        },
    );
    let layer = image.map_err(fail_exr)?.layer_data;
    let (width, rows) = layer.channel_data.pixels;
    Ok((width, layer.size.height(), rows))
}

fn check_size(path: &Path, width: usize, height: usize) -> Result<()> {
    if SIDE.contains(&width) && SIDE.contains(&height) {
        return Ok(());
    }
    let range = format!("{} to {}", SIDE.start(), SIDE.end());
    Err(fail(path, &format!("it has {width} × {height} entries, but each side must be {range}")))
}

fn fail(path: &Path, reason: &str) -> Error {
    Error::Input(format!("cannot read the transfer function {}: {reason}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn png_colours_are_srgb_and_rows_start_at_the_bottom() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("t.PNG");
        let mut picture = image::RgbaImage::new(2, 2);
        picture.put_pixel(0, 0, image::Rgba([255, 0, 0, 51]));
        picture.put_pixel(1, 1, image::Rgba([0, 188, 0, 255]));
        picture.save_with_format(&path, ImageFormat::Png).expect("written");
        let table = read(&path).expect("read");
        assert_eq!((table.width, table.height), (2, 2));
        // Top left is the highest gradient: the second row, first entry.
        assert_eq!(table.rgba[2], [1.0, 0.0, 0.0, 0.2]);
        let [r, g, b, a] = table.rgba[1];
        assert!(r == 0.0 && (g - 0.502_886_458_032_568_8).abs() < 1e-12 && b == 0.0 && a == 1.0);
    }

    #[test]
    fn exr_is_linear_and_checked() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("t.exr");
        exr::write_rgba_file(&path, 3, 2, |x, y| (0.25_f32, x as f32 / 2.0, 0.0_f32, y as f32))
            .expect("written");
        let table = read(&path).expect("read");
        assert_eq!((table.width, table.height), (3, 2));
        assert_eq!(table.rgba[0], [0.25, 0.0, 0.0, 1.0]);
        assert_eq!(table.rgba[5], [0.25, 1.0, 0.0, 0.0]);
        exr::write_rgba_file(&path, 3, 2, |x, y| (0.5_f32, 0.0_f32, 0.0_f32, (x + y) as f32))
            .expect("written");
        let error = read(&path).expect_err("opacity 2").to_string();
        assert!(
            error.ends_with("pixel (2, 0) from the top left is (0.5, 0, 0, 2), but all must be in 0..1"),
            "{error}"
        );
    }

    #[test]
    fn what_is_no_picture_is_an_error() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for name in ["a.png", "a.exr", "a.txt", "a"] {
            let path = folder.path().join(name);
            assert!(read(&path).is_err());
            std::fs::write(&path, b"not a picture").expect("written");
            assert!(read(&path).is_err());
        }
    }

    #[test]
    fn a_picture_of_one_pixel_has_no_ends() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("t.png");
        image::RgbaImage::new(1, 5).save(&path).expect("written");
        let error = read(&path).expect_err("too small").to_string();
        assert!(error.ends_with("it has 1 × 5 entries, but each side must be 2 to 4096"), "{error}");
    }
}
