//! Adding whole samples to a film: `cl/film/fold.cl` on a device.

use crate::Result;
use crate::device::{Arg, Buffer, Device, Kernel, Program, ProgramSpec};
use crate::film::FilmPixel;
use std::time::Duration;

/// Adds samples to films as the kernels that render do.
pub(super) struct Folder {
    kernel: Kernel,
    film: Buffer<FilmPixel>,
    sample: Buffer<FilmPixel>,
    /// Time to build the kernel, or to load it.
    pub build_time: Duration,
}

impl Folder {
    /// For films of so many pixels.
    ///
    /// # Errors
    /// [`crate::Error::Failed`] when the device lacks memory or does not build the kernel.
    pub fn new(device: &Device, pixels: usize) -> Result<Self> {
        let program = Program::build(device, &ProgramSpec::new("film/fold.cl"))?;
        Ok(Self {
            kernel: program.kernel(device, "film_fold")?,
            film: Buffer::uninitialised(device, pixels)?,
            sample: Buffer::uninitialised(device, pixels)?,
            build_time: program.build_time,
        })
    }

    /// The film with the sample of this number, in those pixels that have not had it.
    ///
    /// # Errors
    /// [`crate::Error::Failed`] when the device fails.
    pub fn add(
        &mut self,
        device: &Device,
        film: &[FilmPixel],
        number: u32,
        sample: &[FilmPixel],
    ) -> Result<Vec<FilmPixel>> {
        self.film.write(device, 0, film)?;
        self.sample.write(device, 0, sample)?;
        let arguments: [Arg<'_>; 4] =
            [(&self.film).into(), (&self.sample).into(), number.into(), (film.len() as u32).into()];
        self.kernel.run(device, &arguments, film.len())?;
        self.film.read(device)
    }
}
