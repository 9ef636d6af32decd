//! What the user should know of a scene of surfaces.

use super::local::LocalFrame;
use crate::scene::{Background, Caustics, CausticsDirect, Method, Scene, SurfaceMaterial, SurfaceShape};
use crate::surfaces::{self, Meshes, SurfaceArrays};
use glam::DVec3;

/// One sentence each; `photons`: whether there are any.
pub(super) fn notes(scene: &Scene, meshes: &Meshes, local: &LocalFrame, photons: bool) -> Vec<String> {
    let mut notes = meshes.notes.clone();
    notes.extend(too_small(scene, meshes, local));
    notes.extend(touching(scene, meshes, local));
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

/// How far rays start off surfaces at most, over the largest coordinate of the place and of what is hit: SURFACE_MARGIN of
/// `cl/surfaces/intersect.cl` for both.
const MARGIN: f64 = 2.0 * 32.0 / 16_777_216.0;

/// Surfaces that are small beside how far rays start off surfaces there.
fn too_small(scene: &Scene, meshes: &Meshes, local: &LocalFrame) -> Option<String> {
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

/// Flat faces along the axes, one of a body of glass, of which a ray that leaves the one starts beyond the other: the first such
/// pair among so many surfaces.
fn touching(scene: &Scene, meshes: &Meshes, local: &LocalFrame) -> Option<String> {
    const MOST: usize = 2000;
    let glass = |index: usize| {
        matches!(scene.materials[scene.surfaces[index].material], SurfaceMaterial::Dielectric { .. })
    };
    let bodies = scene.surfaces.iter().enumerate().filter_map(|(index, surface)| {
        let corners = match &surface.shape {
            SurfaceShape::Plane { point, normal } if normal.abs().max_element() == 1.0 => {
                let along = DVec3::select(normal.abs().cmpeq(DVec3::ONE), DVec3::ZERO, DVec3::INFINITY);
                [local.point(*point) - along, local.point(*point) + along]
            }
            SurfaceShape::Box { .. } | SurfaceShape::Rectangle { .. } => {
                let bounds = surfaces::bounds_of_one(index, surface, meshes)?;
                let flat = bounds.size().min_element() == 0.0;
                let along_axes = flat || matches!(surface.shape, SurfaceShape::Box { .. });
                along_axes.then(|| [bounds.low, bounds.high].map(|corner| local.point(corner)))?
            }
            _ => return None,
        };
        Some((index, corners))
    });
    let bodies: Vec<(usize, [DVec3; 2])> = bodies.take(MOST).collect();
    let (first, second, margin) = bodies.iter().enumerate().find_map(|(place, (first, one))| {
        let mut others = bodies[place + 1..].iter().filter(|(second, _)| glass(*first) || glass(*second));
        others.find_map(|(second, other)| Some((first, second, nearer_than(*one, *other)?)))
    })?;
    Some(format!(
        "`surface.{first}` and `surface.{second}` have faces that touch: rays that leave glass start up to {:.1e} off its face, \
         and some miss the other; leave a gap of a ten-thousandth of their size",
        margin * local.unit
    ))
}

/// How far rays start off two bodies, low and high corners each, if they have faces that are as near to each other.
fn nearer_than([low, high]: [DVec3; 2], [other_low, other_high]: [DVec3; 2]) -> Option<f64> {
    let corners = [low, high, other_low, other_high].map(|corner| corner.to_array());
    let places = corners.as_flattened().iter().filter(|place| place.is_finite());
    let margin = MARGIN * places.fold(0.0, |largest, place| f64::max(largest, place.abs()));
    let overlap = high.min(other_high) - low.max(other_low);
    let meet = |axis: usize| {
        let beside = (0..3).all(|other| other == axis || overlap[other] > 0.0);
        let gaps =
            [low[axis], high[axis]].map(|a| [other_low[axis], other_high[axis]].map(|b| (a - b).abs()));
        beside && gaps.as_flattened().iter().any(|&gap| gap <= margin)
    };
    (0..3).any(meet).then_some(margin)
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

    fn parsed(surfaces: &str) -> Scene {
        let text = format!(
            "[camera]\nposition = [0, 0, 5]\ntarget = [0, 0, 0]\nup = [0, 1, 0]\n\
             [[material]]\nname = \"white\"\nkind = \"diffuse\"\ncolor = 1\n\
             [[material]]\nname = \"glass\"\nkind = \"dielectric\"\nior = 1.5\n{surfaces}[method]\nkind = \"caustics\"\n"
        );
        let loaded = crate::config::parse("test.toml", &text, &[]).unwrap_or_else(|e| panic!("{e}"));
        Scene::from_loaded(&loaded, Path::new("/")).unwrap_or_else(|e| panic!("{e}"))
    }

    #[test]
    fn faces_that_touch_are_noted() {
        let note = |shape: &str, material: &str| {
            let unit =
                "[[surface]]\nkind = \"box\"\nlow = [0, 0, 0]\nhigh = [1, 1, 1]\nmaterial = \"glass\"\n";
            let scene = parsed(&format!("{unit}[[surface]]\nmaterial = \"{material}\"\n{shape}\n"));
            touching(&scene, Meshes::NONE, &crate::render::caustics::frame(&scene, Meshes::NONE))
        };
        let cuboid =
            |low: [f64; 3], high: [f64; 3]| format!("kind = \"box\"\nlow = {low:?}\nhigh = {high:?}");
        let above = |gap: f64| cuboid([0.0, 0.0, 1.0 + gap], [1.0, 1.0, 2.0]);
        let floor = |z: f64| format!("kind = \"plane\"\npoint = [0, 0, {z}]\nnormal = [0, 0, 1]");
        let table = |z: f64, slant: f64| {
            format!(
                "kind = \"rectangle\"\ncentre = [0, 0, {z}]\nedge_u = [3, 0, {slant}]\nedge_v = [0, 3, 0]"
            )
        };
        for apart in [
            above(1e-3),
            floor(-1e-3),
            table(-1e-3, 0.0),
            table(0.0, 0.5),
            // In each other, and edge to edge.
            cuboid([0.1; 3], [0.9; 3]),
            cuboid([1.0, 1.0, 0.25], [2.0, 2.0, 0.75]),
        ] {
            assert_eq!(note(&apart, "glass"), None, "{apart}");
        }
        for touching in
            [above(0.0), above(1e-7), floor(0.0), table(0.0, 0.0), cuboid([0.1, 0.1, 0.0], [0.9; 3])]
        {
            for material in ["glass", "white"] {
                let note = note(&touching, material).unwrap_or_else(|| panic!("{touching}"));
                assert!(
                    note.starts_with("`surface.0` and `surface.1` have faces that touch: rays"),
                    "{note}"
                );
            }
        }
    }

    #[test]
    fn what_is_too_small_beside_glass_is_noted() {
        let note = |large: f64| {
            let scene = parsed(&format!(
                "[[surface]]\nkind = \"sphere\"\ncentre = [0, 0, 1]\nradius = 0.25\nmaterial = \"white\"\n\
                 [[surface]]\nkind = \"sphere\"\ncentre = [0, 0, 0]\nradius = {large}\nmaterial = \"glass\"\n"
            ));
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
