//! What the user should know of a scene of surfaces.

use super::local::LocalFrame;
use crate::scene::{Background, Caustics, CausticsDirect, Method, Scene};
use crate::surfaces::{self, Meshes, SurfaceArrays};

/// One sentence each; `photons`: whether there are any.
pub(super) fn notes(scene: &Scene, meshes: &Meshes, local: &LocalFrame, photons: bool) -> Vec<String> {
    let mut notes = meshes.notes.clone();
    notes.extend(too_small(scene, meshes, local));
    if scene.lights.is_empty() {
        notes.push("no [[light]]: surfaces show the background alone".into());
    } else if !photons {
        notes.push(
            "no photons: none are asked for, there is nothing that makes caustics, or nothing that shows them"
                .into(),
        );
    } else if let Method::Caustics(Caustics { direct: CausticsDirect::Photons, target: None, .. }) =
        scene.method
    {
        notes.push(
            "direct light by photons comes where they are sent alone: to mirrors and glass, unless \
             method.emission.target says otherwise"
                .into(),
        );
    }
    if let (Some(_), Method::Caustics(Caustics { bounces: 1.., .. })) = (&scene.volume, &scene.method) {
        notes.push(
            "in a volume, light between diffuse surfaces is left out: method.bounces is not used".into(),
        );
    }
    let black = matches!(scene.background, Background::Constant(color) if color == [0.0; 3]);
    if !black {
        let lit = if scene.volume.is_some() { "neither surfaces nor the volume" } else { "no surface" };
        notes.push(format!("the background is seen, directly and in mirrors and glass, but lights {lit}"));
    }
    notes
}

/// Surfaces that are small beside how far rays start off surfaces there: SURFACE_MARGIN of `cl/surfaces/intersect.cl` times the
/// coordinates, of places and of what is hit.
fn too_small(scene: &Scene, meshes: &Meshes, local: &LocalFrame) -> Option<String> {
    const MARGIN: f64 = 2.0 * 32.0 / 16_777_216.0;
    const PART: f64 = 0.01;
    let mut few = scene.surfaces.iter().enumerate().filter_map(|(index, surface)| {
        let bounds = surfaces::bounds_of_one(index, surface, meshes)?;
        let [low, high] = [bounds.low, bounds.high].map(|corner| local.point(corner).abs().max_element());
        let (margin, extent) = (MARGIN * low.max(high) * local.unit, bounds.size().max_element());
        (margin > PART * extent).then_some((index, margin, extent))
    });
    let (index, margin, extent) = few.next()?;
    let others = match few.count() {
        0 => String::new(),
        count => format!(" (and {count} more)"),
    };
    Some(format!(
        "`surface.{index}`{others} is {extent:.2e} wide, and rays start {margin:.1e} off surfaces there, by float32's rounding: \
         make mirrors and glass no more than a thousand times as large as what is to be seen beside them"
    ))
}

/// What the settings came to, in words.
pub(super) fn details(
    surfaces: &SurfaceArrays,
    [radius, bounced]: [Option<f64>; 2],
    unit: f64,
) -> Vec<String> {
    let shapes = format!("{} shapes in {} boxes", surfaces.shapes.len(), surfaces.nodes.len());
    let within = |what: &str, radius: Option<f64>| {
        let radius = radius? * unit;
        Some(format!("{what} are gathered within {radius:.6} scene units in the first pass"))
    };
    let bounced = within("photons that diffuse surfaces reflect", bounced);
    [Some(shapes), within("photons", radius), bounced].into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn what_is_too_small_beside_glass_is_noted() {
        let note = |large: f64| {
            let text = format!(
                "[camera]\nposition = [0, 0, 5]\ntarget = [0, 0, 0]\nup = [0, 1, 0]\n\
                 [[material]]\nname = \"white\"\nkind = \"diffuse\"\ncolor = 1\n\
                 [[material]]\nname = \"glass\"\nkind = \"dielectric\"\nior = 1.5\n\
                 [[surface]]\nkind = \"sphere\"\ncentre = [0, 0, 1]\nradius = 0.25\nmaterial = \"white\"\n\
                 [[surface]]\nkind = \"sphere\"\ncentre = [0, 0, 0]\nradius = {large}\nmaterial = \"glass\"\n\
                 [method]\nkind = \"caustics\"\n"
            );
            let loaded = crate::config::parse("test.toml", &text, &[]).unwrap_or_else(|e| panic!("{e}"));
            let scene = Scene::from_loaded(&loaded, Path::new("/")).unwrap_or_else(|e| panic!("{e}"));
            too_small(&scene, Meshes::NONE, &crate::render::caustics::frame(&scene, Meshes::NONE))
        };
        assert_eq!(note(1e2), None);
        let note = note(1e6).unwrap();
        assert!(
            note.starts_with("`surface.0` is 5.00e-1 wide, and rays start 3.8e0 off surfaces there"),
            "{note}"
        );
    }
}
