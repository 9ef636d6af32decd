//! Checks of how kernels are launched: nothing depends on it, and long loops are not cut short.

use super::workbench::{Case, EPS, Measurement, Rendered, Workbench, finish, noise, volume};
use crate::Result;
use crate::device::DeviceInfo;

const VIEW: &str = "[image]\nwidth = 20\nheight = 20\n[camera]\nposition = [31, 25, -19]\ntarget = [6, 6, 6]\n\
                    fov = 25\n[volume]\nwindow = { lo = 0, hi = 1 }\n[transfer]\nresolution = 2\n\
                    [medium]\nsigma_max = 0.8\nalbedo = 0.8\n[background]\ncolor = [0.2, 0.4, 0.9]\n\
                    [[light]]\nkind = \"directional\"\ndirection = [1, -2, 0.5]\nirradiance = 3\n";

/// The same picture in launches of one tile, of a few, of many samples; in work-groups of 1 and of 16.
pub fn launches(bench: &Workbench) -> Result<Vec<Measurement>> {
    let groups = |most: usize| {
        let mut info = bench.info.clone();
        info.max_work_group = info.max_work_group.min(most);
        info
    };
    let mut measurements = Vec::new();
    for method in ["emission-absorption", "multiple-scattering"] {
        let text = format!("{VIEW}[method]\nkind = \"{method}\"\n");
        let case = Case::new(&text, volume([12; 3], noise(1728, 7))?)?;
        let render = |info: &DeviceInfo, limit: Option<u64>| -> Result<Rendered> {
            let mut session = bench.session_on(info, &case)?;
            // The first launch may be slow, which makes the next ones small.
            session.render(1)?;
            session.reset()?;
            if let Some(units) = limit {
                session.limit_launches(units);
            }
            finish(session, 3)
        };
        let whole = render(&bench.info, None)?;
        let others = [(None, 1), (None, 16), (Some(1), 64), (Some(4), 64)];
        let mut differing = 0;
        for (limit, group) in others {
            let other = render(&groups(group), limit)?;
            differing += whole.film.iter().zip(&other.film).filter(|(a, b)| bits(a) != bits(b)).count();
        }
        measurements.push(Measurement::exact(
            format!("{method}: pixels that differ, in {} other ways to launch", others.len()),
            differing as f64,
            0.0,
        ));
    }
    Ok(measurements)
}

fn bits(pixel: &crate::film::FilmPixel) -> &[u8] {
    bytemuck::bytes_of(pixel)
}

/// A ray through 70000 cells, and paths of thousands of collisions.
pub fn loops(bench: &Workbench) -> Result<Vec<Measurement>> {
    Ok(vec![long_ray(bench)?, long_paths(bench)?])
}

const LONG: usize = 70_000;

fn long_ray(bench: &Workbench) -> Result<Measurement> {
    let text = format!(
        "[image]\nwidth = 2\nheight = 2\nfilter = \"point\"\n[camera]\nkind = \"orthographic\"\n\
         position = [0.5, 0.5, -1]\ntarget = [0.5, 0.5, 0]\nheight = 0.5\n[volume]\nwindow = {{ lo = 0, hi = 1 }}\n\
         [medium]\nsigma_max = {}\n[method]\nkind = \"emission-absorption\"\ntermination = 0\n",
        1.0 / LONG as f64
    );
    let rendered = bench.render(&Case::new(&text, volume([1, 1, LONG], vec![1.0; LONG])?)?, 1)?;
    let limit = bench.info.ends_long_loops().then(|| {
        "this device ends loops after 65535 turns without a word: emission-absorption, mip and isosurface are right \
         up to as many cells or steps per ray"
            .into()
    });
    // The lengths of the cells add up exactly, but for the rounding of the ray's place.
    let measured = Measurement::within(
        format!("opacity of {LONG} cells"),
        rendered.mean(3),
        -f64::exp_m1(-1.0),
        LONG as f64 * EPS,
        "a rounding per cell",
    );
    Ok(measured.limited(limit))
}

fn long_paths(bench: &Workbench) -> Result<Measurement> {
    // Light of radiance 1 through optical depth 1000: every path is followed through 2000 collisions in the mean, and
    // brings back 1.
    let text = "[image]\nwidth = 5\nheight = 5\n[camera]\nkind = \"orthographic\"\nposition = [3, 3, 20]\n\
                target = [3, 3, 0]\nheight = 1\n[volume]\nwindow = { lo = 0, hi = 1 }\n[transfer]\nresolution = 2\n\
                [medium]\nsigma_max = 200\n[background]\ncolor = 1\n\
                [method]\nkind = \"multiple-scattering\"\npaths = 64\n";
    let values = noise(6 * 6 * 6, 12).into_iter().map(|v| 0.75 + 0.25 * v);
    let rendered = bench.render(&Case::new(text, volume([6; 3], values)?)?, 1)?;
    let limit = (rendered.paths.unfinished > 0).then(|| {
        "this device ends loops early; the renderer notices, and ends such a render with exit code 1".into()
    });
    let lookups = rendered.paths.lookups / 25;
    let measured = Measurement::within(
        format!("furnace of depth 1000, {lookups} look-ups a pixel: largest error"),
        rendered.largest_error(0..3, 1.0),
        0.0,
        1e-6,
        "rounding of 64 weights",
    );
    Ok(measured.limited(limit))
}
