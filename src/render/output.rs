//! From the film to a picture with its metadata.

use super::auxiliary::{self, Auxiliary};
use super::kept::{self, Units};
use super::ledger::PathLedger;
use super::plan::Plan;
use super::rendering::{Rendering, of_devices};
use super::state;
use crate::Result;
use crate::caustics::{PassLedger, pass_ledger};
use crate::film::{FilmPixel, FilmSummary};
use crate::picture::{Curve, Encoding, Picture, Tonemap};
use crate::scene::{
    DirectLight, FilmSettings, LightVolume, Method, Orders, Scattering, Tonemap as SceneTonemap,
};
use std::time::Duration;

/// A film read back, with what the metadata says about how it came to be.
pub struct Snapshot {
    /// The picture, with metadata.
    pub picture: Picture,
    /// The film as a whole, with the look-ups of its paths and of its light volume.
    pub summary: FilmSummary,
    /// What the paths did, when the method follows paths.
    pub paths: Option<PathLedger>,
    /// Where the flux of photons went, for caustics.
    pub photons: Option<PassLedger>,
}

impl Snapshot {
    /// Reads the session's film; `data_hash` is that of [`data_hash`](super::data_hash), and `wall` the time that the
    /// render has taken, earlier runs included.
    ///
    /// # Errors
    /// [`crate::Error::Failed`] when the device fails.
    pub fn take(session: &dyn Rendering, plan: &Plan<'_>, data_hash: &str, wall: Duration) -> Result<Self> {
        let film = session.film()?;
        let extra = session.auxiliary()?;
        let paths = session.ledger()?;
        let mut summary = FilmSummary::of(&film);
        let facts = session.facts();
        let light = facts.light.and_then(|facts| facts.cost);
        summary.lookups += paths.map_or(0, |paths| paths.lookups) + light.map_or(0, |cost| cost.lookups);
        let image = &plan.scene.image;
        let mut picture = planes(&film, image.width as usize, image.height as usize, units(plan));
        if let Some(extra) = &extra {
            auxiliary::add_channels(&mut picture, extra, plan.local.unit);
        }
        describe(&mut picture, session, plan, &summary, wall);
        let photons = facts.photons;
        let of_paths = paths.iter().flat_map(PathLedger::entries);
        for (key, value) in of_paths.chain(photons.iter().flat_map(PassLedger::entries)) {
            picture.metadata.insert(format!("svetlo.{key}"), value);
        }
        keep_state(&mut picture, &film, extra.as_deref(), plan, data_hash);
        Ok(Self { picture, summary, paths, photons })
    }
}

/// Adds what a later run needs to continue: the rest of the film, and what tells that the run is of the same render.
fn keep_state(
    picture: &mut Picture,
    film: &[FilmPixel],
    extra: Option<&[Auxiliary]>,
    plan: &Plan<'_>,
    data_hash: &str,
) {
    let hash = kept::add(picture, film, extra, None, units(plan));
    for (key, value) in
        [("state", state::FORMAT.to_string()), ("state_hash", hash), ("data_hash", data_hash.into())]
    {
        picture.metadata.insert(format!("svetlo.{key}"), value);
    }
}

/// What the distances in images of this plan are.
pub(super) fn units(plan: &Plan<'_>) -> Units {
    Units { unit: plan.local.unit, has_depth: plan.method.has_depth }
}

/// The planes of the EXR: R G B A, Z where the method measures a depth (scene units, 0 = nothing hit), the variance
/// of one sample, and the number of samples.
pub(super) fn planes(film: &[FilmPixel], width: usize, height: usize, units: Units) -> Picture {
    // Plane by plane from the film: arrays of all means and variances would be as large as the film.
    let plane = |value: &dyn Fn(&FilmPixel) -> f64| film.iter().map(|pixel| value(pixel) as f32).collect();
    let mut picture = Picture::new(width, height);
    for (channel, name) in ["R", "G", "B", "A"].into_iter().enumerate() {
        picture = picture.with_channel(name, plane(&|pixel| pixel.mean()[channel]));
    }
    for (channel, name) in ["variance.R", "variance.G", "variance.B", "variance.A"].into_iter().enumerate() {
        picture = picture.with_channel(name, plane(&|pixel| pixel.variance().unwrap_or_default()[channel]));
    }
    if units.has_depth {
        let depth = |pixel: &FilmPixel| {
            if pixel.hits > 0 { (f64::from(pixel.depth) * units.unit) as f32 } else { 0.0 }
        };
        picture = picture.with_channel("Z", film.iter().map(depth).collect());
    }
    picture.with_counts("samples", film.iter().map(|pixel| pixel.count).collect())
}

fn describe(
    picture: &mut Picture,
    session: &dyn Rendering,
    plan: &Plan<'_>,
    summary: &FilmSummary,
    wall: Duration,
) {
    let (progress, facts) = (session.progress(), session.facts());
    let mut put = |key: &str, value: String| {
        picture.metadata.insert(format!("svetlo.{key}"), value);
    };
    put("version", env!("CARGO_PKG_VERSION").into());
    put("scene_hash", plan.scene.hash.clone());
    put("method", method_name(&plan.scene.method).into());
    put("seed", plan.scene.seed.to_string());
    put("samples", progress.samples.to_string());
    if let Some(share) = plan.part {
        // What `merge`, which sees no scene, needs besides.
        put("part", share.to_string());
        put("unit", plan.local.unit.to_string());
        put("preview", preview_tonemap(&plan.scene.film).to_string());
    }
    put("seconds_wall", format!("{:.6}", wall.as_secs_f64()));
    put("seconds_device", format!("{:.6}", progress.device_time.as_secs_f64()));
    put("seconds_build", format!("{:.6}", facts.build_time.as_secs_f64()));
    put("device", of_devices(&facts.devices, |device| &device.name));
    put("platform", of_devices(&facts.devices, |device| &device.platform));
    put("driver", of_devices(&facts.devices, |device| &device.driver));
    put("estimated_error", summary.relative_error().map_or("unknown".into(), |error| format!("{error:.6e}")));
    put("rejected_samples", summary.rejected.to_string());
    put("lookups", summary.lookups.to_string());
    put("launches", progress.launches.to_string());
    if let Some(hash) = facts.light_hash {
        put("light_hash", hash.into());
        put("light_source", if facts.light_from_file { "file" } else { "computed" }.into());
    }
    put("variance", "variance.* is the variance of one sample; over `samples` it is that of the mean".into());
    if plan.method.has_depth {
        put("depth", "Z is the mean distance to the camera in scene units, 0 where nothing was hit".into());
    }
    if plan.method.paths {
        put(
            "energy",
            "escaped + absorbed + cut = paths + gained: sums of the paths' weights, the mean over channels; each path \
             starts with 1, cut is what the limit on scatterings loses, gained what Russian roulette adds, net"
                .into(),
        );
    }
    if plan.method.caustics.is_some() {
        put("photon_energy", pass_ledger::MEANING.into());
    }
    if plan.has_auxiliary() {
        put("auxiliary", auxiliary::MEANING.into());
    }
}

/// The name of a method in scene files.
pub fn method_name(method: &Method) -> &'static str {
    match method {
        Method::Mip { .. } => "mip",
        Method::Isosurface { .. } => "isosurface",
        Method::EmissionAbsorption { .. } => "emission-absorption",
        Method::Scattering(Scattering { orders: Orders::Single, .. }) => "single-scattering",
        Method::Scattering(Scattering { orders: Orders::Multiple { .. }, .. }) => "multiple-scattering",
        Method::Caustics(_) => "caustics",
        Method::LightVolume(LightVolume { direct: DirectLight::Convection, .. }) => "convection-diffusion",
        Method::LightVolume(LightVolume { direct: DirectLight::Tracking { .. }, .. }) => "hybrid-diffusion",
    }
}

/// The curve of previews, as the scene asks for it.
pub fn preview_tonemap(film: &FilmSettings) -> Tonemap {
    Tonemap {
        curve: match film.tonemap {
            SceneTonemap::Linear => Curve::Linear,
            SceneTonemap::Reinhard => Curve::Reinhard,
            SceneTonemap::Filmic => Curve::Filmic,
        },
        exposure: film.exposure,
        encoding: film.gamma.map_or(Encoding::Srgb, Encoding::Gamma),
    }
}
