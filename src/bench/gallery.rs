//! The pictures of the cases: all repeats as one, previews, differences; and what the pooled pictures say.

use super::files::Folder;
use super::measure::measure;
use super::piece::picture_name;
use super::pool::pool_equal;
use super::results::{Case, Images, Results};
use super::suite::CaseSpec;
use super::truth::judge;
use crate::Result;
use crate::metrics::write_difference;
use crate::picture::{read_exr, write_exr, write_png};
use crate::render::preview_tonemap;
use crate::scene::Method;

/// Writes the pictures.
pub struct Gallery<'a> {
    /// Where.
    pub folder: &'a Folder,
}

impl Gallery<'_> {
    /// Fills in pictures and pooled metrics: `pieces` are the specification and keys of every case, in their order.
    ///
    /// # Errors
    /// [`crate::Error::Failed`] when the disk fails.
    pub fn fill(&self, results: &mut Results, pieces: &[(&CaseSpec, Vec<&str>)]) -> Result<()> {
        for (index, (case, (spec, keys))) in results.cases.iter_mut().zip(pieces).enumerate() {
            if !keys.is_empty() {
                self.case(case, spec, keys, &format!("{:02}-{}", index + 1, slug(&case.name)))?;
            }
        }
        Ok(())
    }

    fn case(&self, case: &mut Case, spec: &CaseSpec, keys: &[&str], name: &str) -> Result<()> {
        let Some(reference_name) = &case.reference.image else { return Ok(()) };
        let reference = read_exr(&self.folder.path(reference_name))?;
        let pictures = keys
            .iter()
            .map(|key| read_exr(&self.folder.path(&picture_name(key))))
            .collect::<Result<Vec<_>>>()?;
        let Some(pooled) = pool_equal(&pictures) else { return Ok(()) };
        let tonemap = preview_tonemap(&spec.scene.film);
        let file = |end: &str| format!("images/{name}{end}");
        write_exr(&self.folder.path(&file(".exr")), &pooled)?;
        write_png(&self.folder.path(&file(".png")), &pooled, &tonemap)?;
        case.pooled = Some(measure(&pooled, &reference)?);
        // Light volumes and photons light many pixels.
        let shared = matches!(spec.scene.method, Method::LightVolume(_) | Method::Caustics(_));
        case.truth = spec.truth.as_ref().map(|truth| judge(&pooled, truth, shared)).transpose()?;
        case.images = Images { image: Some(file(".exr")), preview: Some(file(".png")), ..Images::default() };
        if case.is_only_truth() {
            return Ok(());
        }
        write_png(&self.folder.path(&file(".reference.png")), &reference, &tonemap)?;
        let scale = write_difference(&self.folder.path(&file(".difference.png")), &pooled, &reference)?;
        case.images.reference_preview = Some(file(".reference.png"));
        case.images.difference = Some(file(".difference.png"));
        case.images.difference_scale = scale;
        Ok(())
    }
}

/// A name as part of a file's.
fn slug(name: &str) -> String {
    let plain = |c: char| match c {
        '²' => '2',
        '³' => '3',
        '×' => 'x',
        c if c.is_ascii_alphanumeric() || c == '.' => c.to_ascii_lowercase(),
        _ => '-',
    };
    let mut text: String = name.chars().map(plain).collect();
    while text.contains("--") {
        text = text.replace("--", "-");
    }
    text.trim_matches(['-', '.']).chars().take(60).collect()
}

#[cfg(test)]
mod tests {
    use super::slug;

    #[test]
    fn names_of_files_are_plain() {
        assert_eq!(slug("Mip, 64³, 256×256"), "mip-64-256x256".replace("64", "643"));
        assert_eq!(slug("../Größe"), "gr-e");
        assert_eq!(slug("é"), "");
    }
}
