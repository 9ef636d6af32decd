//! Checks of caustics: sorts and ranges of cells, photons through glass, and what is gathered of them.

use super::workbench::{EPS, Measurement, Workbench, noise};
use crate::caustics::{PhotonLedger, PhotonTracer, photon_settings};
use crate::device::{Buffer, Device};
use crate::reference::sort::{cell_ranges, order};
use crate::render::{BRICK_SHIFT, Plan, SceneData, Session};
use crate::scene::Scene;
use crate::sort::{CellRanges, Fill, SortKind, Sorter};
use crate::surfaces::SurfaceBuffers;
use crate::{Error, Result};
use std::f64::consts::PI;
use std::path::Path;
use std::sync::Arc;

/// Items that are sorted.
const ITEMS: usize = 1 << 14;
/// Cells that they lie in.
const CELLS: u32 = 4095;
/// Photons of a pass: a square, for a square grid of cells.
const PHOTONS: u32 = 1 << 16;

/// Keys in order, equal ones in the order of their numbers, and the ranges of the cells: what the twins say.
pub fn sort(bench: &Workbench) -> Result<Vec<Measurement>> {
    let device = Device::open(&bench.info)?.altering(bench.alter);
    // An eighth has no key.
    let key = |u: f64| Some((u * f64::from(CELLS) * 8.0 / 7.0) as u32).filter(|key| *key < CELLS);
    let keys: Vec<u32> = noise(ITEMS, 17).into_iter().map(|u| key(u).unwrap_or(u32::MAX)).collect();
    let expected = order(&keys);
    let in_order: Vec<u32> = expected.iter().map(|&i| keys[i as usize]).collect();
    let buffer = Buffer::from_slice(&device, &keys)?;
    let mut rows = Vec::new();
    for (name, kind, fill) in
        [("radix", SortKind::Radix, Fill::OnePass), ("bitonic", SortKind::Bitonic, Fill::TwoPass)]
    {
        let mut sorter = Sorter::<u32>::new(&device, kind, ITEMS)?;
        let sorted = sorter.sort(&device, &buffer, ITEMS, u32::BITS - CELLS.leading_zeros())?;
        let (numbers, found) = (sorted.indices.read(&device)?, sorted.keys.read(&device)?);
        let wrong = (0..ITEMS).filter(|&i| numbers[i] != expected[i] || found[i] != in_order[i]).count();
        rows.push(Measurement::exact(format!("{name} sort: items out of place"), wrong as f64, 0.0));
        let mut ranges = CellRanges::new(&device, CELLS as usize, fill, ITEMS)?;
        ranges.fill(&device, &sorted)?;
        let wrong = ranges.ranges().read(&device)?.into_iter().zip(cell_ranges(&in_order, CELLS as usize));
        let wrong = wrong.filter(|(found, exact)| found != exact).count();
        rows.push(Measurement::exact(format!("{name} sort: wrong ranges of cells"), wrong as f64, 0.0));
    }
    Ok(rows)
}

/// Light through a sphere of glass, and from a lamp onto a plane.
pub fn caustics(bench: &Workbench) -> Result<Vec<Measurement>> {
    let mut measurements = sphere(bench)?;
    measurements.extend(lamp(bench)?);
    Ok(measurements)
}

/// A scene of surfaces, and what it reads.
fn case(text: &str) -> Result<(Scene, SceneData)> {
    let scene = Scene::from_loaded(&crate::config::parse("self-test", text, &[])?, Path::new("/"))?;
    let data = SceneData::load(&scene)?;
    Ok((scene, data))
}

const WHITE: &str = "[[material]]\nname = \"white\"\nkind = \"diffuse\"\ncolor = 1\n";

/// Parallel light that meets a sphere of radius 1 and index 1.5: what is refracted twice is published.
fn sphere(bench: &Workbench) -> Result<Vec<Measurement>> {
    const TRANSMITTED: f64 = 0.835_544_400_143_583;
    // What ends after as many turns as `depth` allows, over the sphere's section; and the ledger.
    let ended = |depth: u32| -> Result<(f64, PhotonLedger)> {
        let ledger = trace(bench, depth)?;
        Ok(((ledger.emitted - ledger.truncated) / PI, ledger))
    };
    let ((once, _), (twice, ledger)) = (ended(1)?, ended(2)?);
    let side = 2.2 / f64::from(PHOTONS).sqrt();
    // Photons that meet the sphere, and cells on its rim, which do or do not.
    let (met, rim) = (PI / (side * side), 8.0 / side);
    let sigma = (TRANSMITTED * (1.0 - TRANSMITTED) / met + 0.25 * rim / (met * met)).sqrt();
    Ok(vec![
        Measurement::mean(
            format!("flux through a glass sphere, {met:.0} photons"),
            twice - once,
            TRANSMITTED,
            sigma,
            0.0,
            "binomial, and cells on the rim",
        ),
        Measurement::within(
            "photons' flux that went nowhere",
            ledger.imbalance(),
            0.0,
            1e-5,
            "rounding of a photon's terms",
        ),
    ])
}

fn trace(bench: &Workbench, depth: u32) -> Result<PhotonLedger> {
    let (scene, data) = case(&format!(
        "[camera]\nposition = [0, -9, 0]\ntarget = [0, 0, 0]\nup = [0, 0, 1]\n{WHITE}\
         [[material]]\nname = \"glass\"\nkind = \"dielectric\"\nior = 1.5\n\
         [[surface]]\nkind = \"sphere\"\ncentre = [0, 0, 0]\nradius = 1\nmaterial = \"glass\"\n\
         [[surface]]\nkind = \"plane\"\npoint = [0, 0, -2]\nnormal = [0, 0, 1]\nmaterial = \"white\"\n\
         [[light]]\nkind = \"directional\"\ndirection = [0, 0, -1]\nirradiance = 1\n\
         [method]\nkind = \"caustics\"\nphotons = {PHOTONS}\ndepth = {depth}\nbounces = 0\n\
         emission.target = {{ centre = [0, 0, 0], edge_u = [2.2, 0, 0], edge_v = [0, 2.2, 0] }}\n"
    ))?;
    let plan = Plan::new(&scene, &data, BRICK_SHIFT)?;
    let setup =
        plan.method.caustics.as_ref().ok_or_else(|| Error::Failed("no photons are planned".into()))?;
    let device = Device::open(&bench.info)?.altering(bench.alter);
    let buffers = Arc::new(SurfaceBuffers::new(&device, &setup.surfaces)?);
    let settings = photon_settings(&setup.settings, scene.seed);
    let mut tracer =
        PhotonTracer::new(&device, &scene.lights, &setup.surfaces, buffers, &plan.local, &settings)?;
    tracer.trace(&device, 0, 0, tracer.capacity())?;
    tracer.ledger(&device)
}

/// A lamp at height 1 over a plane, all of whose light photons bring: I cos θ / r².
fn lamp(bench: &Workbench) -> Result<Vec<Measurement>> {
    let (pixels, extent, radius, samples) = (8, 0.8, 0.1, 8);
    let (scene, data) = case(&format!(
        "[image]\nwidth = {pixels}\nheight = {pixels}\nfilter = \"point\"\n\
         [camera]\nkind = \"orthographic\"\nposition = [0, 0, 0.5]\ntarget = [0, 0, 0]\nup = [0, 1, 0]\n\
         height = {extent}\n{WHITE}\
         [[surface]]\nkind = \"plane\"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nmaterial = \"white\"\n\
         [[light]]\nkind = \"point\"\nposition = [0, 0, 1]\nintensity = 1\n\
         [method]\nkind = \"caustics\"\nphotons = {PHOTONS}\nradius = {radius}\nalpha = 1\nbounces = 0\n\
         direct = \"photons\"\n\
         emission.target = {{ centre = [0, 0, 0], edge_u = [2, 0, 0], edge_v = [0, 2, 0] }}\n"
    ))?;
    let plan = Plan::new(&scene, &data, BRICK_SHIFT)?;
    let mut session = Session::new(Device::open(&bench.info)?.altering(bench.alter), &plan)?;
    session.render(samples)?;
    let film = session.film()?;
    let place = |i: usize| extent * ((i as f64 + 0.5) / f64::from(pixels) - 0.5);
    let exact = |index: usize| {
        let (x, y) = (place(index % pixels as usize), place(index / pixels as usize));
        (1.0 + x * x + y * y).powf(-1.5)
    };
    let count = film.len() as f64;
    let found = film.iter().map(|pixel| PI * pixel.mean()[0]).sum::<f64>() / count;
    let expected = (0..film.len()).map(exact).sum::<f64>() / count;
    // Photons over the region that is seen; the cone's squares weigh 3/2, and its mean sees a curvature of at most 12 E
    // by 3/40 of the squared radius.
    let seen = f64::from(PHOTONS) * f64::from(samples) * extent * extent / 4.0;
    let sigma = expected * (1.5 / seen).sqrt();
    let bias = 3.0 / 40.0 * radius * radius * 12.0 * expected;
    let emitted = session.photons().map_or(f64::NAN, |photons| photons.flux.emitted) / f64::from(samples);
    Ok(vec![
        Measurement::mean(
            format!("irradiance by a lamp, {seen:.0} photons"),
            found,
            expected,
            sigma,
            bias,
            "Poisson's, and the kernel's bias",
        ),
        Measurement::within(
            "flux of a lamp through a face of the cube around it, of 4 π",
            emitted,
            4.0 * PI / 6.0,
            64.0 * EPS,
            "float32 solid angles of cells",
        ),
    ])
}
