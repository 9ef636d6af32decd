//! PNG files: 8-bit previews written through a tone mapping, any PNG read back to linear light.

use std::{
    fs::File,
    io::{self, BufReader, Read, Seek, Write},
    path::Path,
};

use flate2::read::ZlibDecoder;
use image::{DynamicImage, ExtendedColorType, ImageEncoder, ImageFormat, ImageReader};

use super::{
    atomic::write_atomically,
    tonemap::{Tonemap, srgb_decode},
    types::Picture,
    unreadable,
};
use crate::error::{Error, Result};
use crate::input;

/// Writes the colour of a picture as an opaque 8-bit PNG, atomically. Alpha is not applied:
/// EXR colour is premultiplied, so the preview shows it over black.
///
/// # Errors
/// [`Error::Failed`] where the picture has no `R G B` or `Y`, or the disk refuses.
pub fn write_png(path: &Path, picture: &Picture, tonemap: &Tonemap) -> Result<()> {
    let fail = |what: String| Error::Failed(format!("{}: cannot be written as PNG: {what}", path.display()));
    picture.validate().map_err(fail)?;
    let planes = picture.colour().ok_or_else(|| fail("no channels R, G, B or Y; add them".into()))?;
    let plane = |c: usize| &planes[c.min(planes.len() - 1)].data;
    let (r, g, b) = (plane(0), plane(1), plane(2));
    let codes = (0..r.len()).flat_map(|i| tonemap.pixel([r[i], g[i], b[i]])).collect::<Vec<u8>>();
    write_png_rgb8(path, picture.width, picture.height, &codes)
}

/// Writes 8-bit RGB code values, `3 · width · height` of them, as PNG, atomically.
///
/// # Errors
/// [`Error::Failed`] where the length is wrong or the disk refuses.
pub fn write_png_rgb8(path: &Path, width: usize, height: usize, codes: &[u8]) -> Result<()> {
    let size = u32::try_from(width).ok().zip(u32::try_from(height).ok());
    let wanted = width.checked_mul(height).and_then(|pixels| pixels.checked_mul(3));
    let Some((w, h)) = size.filter(|_| wanted == Some(codes.len()) && !codes.is_empty()) else {
        let bytes = codes.len();
        let path = path.display();
        return Err(Error::Failed(format!("{path}: {bytes} bytes do not make {width}×{height} RGB pixels")));
    };
    // Encoded in memory first: the encoder hides the kind of a disk error, and so what to advise.
    let mut encoded = Vec::new();
    image::codecs::png::PngEncoder::new(&mut encoded)
        .write_image(codes, w, h, ExtendedColorType::Rgb8)
        .map_err(|cause| Error::Failed(format!("{}: cannot be encoded as PNG: {cause}", path.display())))?;
    write_atomically(path, |file| file.write_all(&encoded))
}

/// Reads a PNG of any depth as `R G B` or `Y`, and `A` where it has one.
///
/// The code values are taken as sRGB and decoded to display-linear light in [0, 1]. Colour
/// profiles and `gAMA` are not applied, and colour is not multiplied by alpha.
///
/// # Errors
/// [`Error::Input`] where the file cannot be opened, is damaged, or would take more than 512 MiB.
pub fn read_png(path: &Path) -> Result<Picture> {
    let (mut file, length) = input::open(path).map_err(|cause| unreadable(path, &cause))?;
    if !holds_its_claims(&mut file, length).unwrap_or(false) {
        let problem = "its data are fewer than its header claims, or damaged; write it again";
        return Err(Error::Input(format!("{}: cannot be read as PNG ({problem})", path.display())));
    }
    file.rewind().map_err(|cause| unreadable(path, &cause))?;
    let mut reader = ImageReader::with_format(BufReader::new(file), ImageFormat::Png);
    reader.limits(image::Limits::default());
    let image = reader.decode().map_err(|error| {
        Error::Input(format!("{}: cannot be read as PNG ({error}); write it again", path.display()))
    })?;
    Ok(to_picture(&image))
}

/// Whether there are as many pixels as the header claims: where those are more than the length of the file justifies, by
/// unpacking all and keeping none.
fn holds_its_claims(file: &mut File, length: u64) -> io::Result<bool> {
    // The signature; the length and the name of the chunk IHDR, its content and checksum.
    let mut head = [0; 33];
    file.read_exact(&mut head)?;
    let number = |at: usize| head[at..at + 4].iter().fold(0, |number, byte| number << 8 | u64::from(*byte));
    let pixels = number(16).saturating_mul(number(20));
    // Four channels of 16 bits are what it is decoded to.
    if pixels.saturating_mul(8) <= input::credible(length) {
        return Ok(true);
    }
    let channels = match head[25] {
        2 => 3,
        4 => 2,
        6 => 4,
        _ => 1,
    };
    let needed = pixels.saturating_mul(channels * u64::from(head[24])) / 8;
    let data = ImageData { file: BufReader::new(file), left: 0, begun: false };
    let found = io::copy(&mut ZlibDecoder::new(data).take(needed), &mut io::sink())?;
    Ok(found == needed)
}

/// The contents of the chunks IDAT, one behind the other.
struct ImageData<'a> {
    file: BufReader<&'a mut File>,
    /// Bytes of the present chunk.
    left: u64,
    begun: bool,
}

impl Read for ImageData<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        while self.left == 0 {
            // A chunk is its length, its name, its content and four bytes of checksum.
            if self.begun {
                self.file.seek_relative(4)?;
            }
            let mut head = [0; 8];
            self.file.read_exact(&mut head)?;
            let length = head[..4].iter().fold(0, |number, byte| number << 8 | u64::from(*byte));
            match &head[4..] {
                b"IEND" => {
                    // Whoever asks again is told the same.
                    self.file.seek_relative(-8)?;
                    self.begun = false;
                    return Ok(0);
                }
                b"IDAT" => (self.left, self.begun) = (length, true),
                _ => {
                    self.file.seek_relative(length as i64)?;
                    self.begun = true;
                }
            }
        }
        let most = buffer.len().min(usize::try_from(self.left).unwrap_or(usize::MAX));
        let read = self.file.read(&mut buffer[..most])?;
        self.left -= read as u64;
        Ok(read)
    }
}

fn to_picture(image: &DynamicImage) -> Picture {
    let colour = image.color();
    let rgba = image.to_rgba16();
    let scaled = |c: usize| rgba.pixels().map(move |pixel| f64::from(pixel.0[c]) / 65535.0);
    let linear = |c: usize| scaled(c).map(|code| srgb_decode(code) as f32).collect();
    let mut picture = Picture::new(rgba.width() as usize, rgba.height() as usize);
    let names: &[&str] = if colour.has_color() { &["R", "G", "B"] } else { &["Y"] };
    for (c, name) in names.iter().enumerate() {
        picture = picture.with_channel(name, linear(c));
    }
    if colour.has_alpha() {
        picture = picture.with_channel("A", scaled(3).map(|alpha| alpha as f32).collect());
    }
    picture
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::picture::{BAD_PIXEL, srgb_encode};

    #[test]
    fn all_codes_survive_a_round_trip() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.png");
        let linear: Vec<f32> = (0..256).map(|code| srgb_decode(f64::from(code) / 255.0) as f32).collect();
        let picture = Picture::new(16, 16).with_channel("Y", linear.clone());
        write_png(&path, &picture, &Tonemap::default()).unwrap();
        let read = read_png(&path).unwrap();
        assert_eq!((read.width, read.height), (16, 16));
        for plane in read.colour().unwrap() {
            for (i, (read, written)) in plane.data.iter().zip(&linear).enumerate() {
                assert!((read - written).abs() < 1e-6, "code {i}");
            }
        }
    }

    #[test]
    fn bad_pixels_are_magenta_in_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.png");
        write_png(&path, &Picture::new(1, 1).with_channel("Y", vec![f32::NAN]), &Tonemap::default()).unwrap();
        let read = read_png(&path).unwrap();
        let codes: Vec<u8> = read
            .colour()
            .unwrap()
            .iter()
            .map(|p| (srgb_encode(f64::from(p.data[0])) * 255.0).round() as u8)
            .collect();
        assert_eq!(codes, BAD_PIXEL);
    }

    #[test]
    fn sixteen_bits_grey_and_alpha_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("in.png");
        image::ImageBuffer::from_pixel(2, 1, image::LumaA([65535_u16, 32768])).save(&path).unwrap();
        let read = read_png(&path).unwrap();
        let names: Vec<_> = read.channels.iter().map(|channel| channel.name.as_str()).collect();
        assert_eq!(names, ["Y", "A"]);
        assert_eq!(read.channel("Y").unwrap().to_f32()[0], 1.0);
        assert!((read.channel("A").unwrap().to_f32()[1] - 0.5).abs() < 1e-4);
    }

    #[test]
    fn wrong_lengths_and_colourless_pictures_are_errors() {
        let path = Path::new("unused.png");
        assert!(write_png_rgb8(path, 2, 2, &[0; 11]).is_err());
        assert!(write_png_rgb8(path, 0, 0, &[]).is_err());
        assert!(write_png_rgb8(path, usize::MAX, 2, &[0; 6]).is_err());
        let depth = Picture::new(1, 1).with_channel("Z", vec![1.0]);
        assert!(write_png(path, &depth, &Tonemap::default()).unwrap_err().to_string().contains("R, G, B"));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(100))]

        #[test]
        fn damaged_files_never_panic(
            flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..5),
            keep in prop::option::of(any::<prop::sample::Index>()),
        ) {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("out.png");
            write_png_rgb8(&path, 9, 7, &[77; 189]).unwrap();
            let mut bytes = std::fs::read(&path).unwrap();
            for (index, value) in flips {
                let at = index.index(bytes.len());
                bytes[at] = value;
            }
            if let Some(keep) = keep {
                bytes.truncate(keep.index(bytes.len()));
            }
            std::fs::write(&path, bytes).unwrap();
            let _ = read_png(&path);
        }
    }
}
