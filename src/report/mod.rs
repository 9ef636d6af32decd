//! The report of a bench: plots and one HTML page, from [`Results`] and the pictures beside them.
//!
//! | file | what |
//! | --- | --- |
//! | `view` | cases in groups; which of them can stand in for each other |
//! | `advice` | for an error that one can live with, what gets there first |
//! | `figures` | which plots a group gets |
//! | `ladder` | the picture of a model ladder |
//! | `plot` | drawing them, as SVG and PNG |
//! | `page` | `report.html` |
//! | `numbers` | numbers as people read them |

mod advice;
mod figures;
mod ladder;
mod numbers;
mod page;
mod plot;
mod view;

pub use self::ladder::write_ladder;

use std::{io::Write, path::Path};

use self::{figures::figures, page::Plots, view::View};
use crate::{
    bench::results::Results,
    error::{Error, Result},
    picture::write_atomically,
};

/// Writes `report.html` and `plots/*.svg` and `*.png` into the folder of the results, each file whole or not at all.
///
/// The folder's pictures are read; those that are missing are left out.
///
/// # Errors
/// [`Error::Failed`] where the disk refuses.
pub fn write(results: &Results, folder: &Path) -> Result<()> {
    let view = View::new(results, folder);
    let plots: Vec<Plots> =
        view.groups.iter().enumerate().map(|(index, group)| plots_of(index, group)).collect();
    let place = folder.join("plots");
    std::fs::create_dir_all(&place)
        .map_err(|cause| Error::Failed(format!("{}: cannot be made ({cause})", place.display())))?;
    for group in &plots {
        for (name, drawing) in &group.drawings {
            plot::write(drawing, &place, &format!("{}-{name}", group.name))?;
        }
    }
    let page = page::page(&view, &plots);
    write_atomically(&folder.join("report.html"), |file| file.write_all(page.as_bytes()))
}

fn plots_of(index: usize, group: &view::Group<'_>) -> Plots {
    let drawings = figures(group).into_iter().map(|figure| (figure.name, figure.plot.drawing()));
    Plots { name: format!("{:02}-{}", index + 1, slug(group.name)), drawings: drawings.collect() }
}

/// A name as part of a file's.
fn slug(name: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' };
    let words: String = name.chars().map(plain).collect();
    let words: Vec<&str> = words.split('-').filter(|word| !word.is_empty()).collect();
    words.join("-").chars().take(60).collect()
}

#[cfg(test)]
mod tests;
