//! How lights emit photons: a grid of cells each, one photon per cell, through a target or in all directions.

use super::roles::{
    Aim, GROUPS, Group, diffuse_light_returns, far_along, focus, has_elsewhere, is_specular, near,
    near_along, role, shares, split,
};
use super::target::{Parts, Target};
use crate::device_struct;
use crate::render::local::LocalFrame;
use crate::scene::Light;
use crate::surfaces::SurfaceArrays;
use crate::{Error, Result};
use bytemuck::Zeroable;
use glam::DVec3;
use std::f64::consts::PI;

device_struct! {
    "types/emission.cl",
    /// A light's share of the photons; see `cl/types/emission.cl`.
    pub struct Emitter {
        /// Position or direction of travel.
        pub place: [f32; 4],
        /// Of each photon, before what depends on its cell; w: whether nothing does.
        pub power: [f32; 4],
        /// Of the target.
        pub corner: [f32; 4],
        /// Of the target.
        pub edge_u: [f32; 4],
        /// Of the target.
        pub edge_v: [f32; 4],
        /// Of the target.
        pub normal: [f32; 4],
        /// An edge of a rectangular light.
        pub light_u: [f32; 4],
        /// The other one.
        pub light_v: [f32; 4],
        /// The normal of its front.
        pub light_normal: [f32; 4],
        /// Which way photons leave.
        pub way: u32,
        /// Its first photon.
        pub first: u32,
        /// Its photons.
        pub count: u32,
        /// Rows of its cells.
        pub rows: u32,
        /// Which paths are its photons'.
        pub role: u32,
        /// Whether photons through the target are another emitter's.
        pub except: u32,
        /// Padding.
        pub pad_0: u32,
        /// Padding.
        pub pad_1: u32,
    }
}

impl Emitter {
    /// Whether its photons go on where diffuse surfaces reflect them.
    pub fn is_bounced(&self) -> bool {
        self.role != role::CAUSTIC
    }

    /// Whether its light is parallel.
    pub(super) fn is_parallel(&self) -> bool {
        self.way == way::DIRECTIONAL
    }
}

/// What `way` says.
mod way {
    pub const POINT: u32 = 0;
    pub const SPHERE: u32 = 1;
    pub const DIRECTIONAL: u32 = 2;
    pub const RECTANGLE: u32 = 3;
    pub const HEMISPHERE: u32 = 4;
}

/// The flux of photons of the same light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Emission {
    /// What the light sends through each photon's cell.
    #[default]
    Radiometric,
    /// The same for all, as Bogolepov, Sopin and Turlapov have it: a point then sends more to what is farther on the
    /// target and seen at an angle than it does.
    Equal,
}

/// A rectangle through which all photons of all lights are sent, scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetRectangle {
    /// Its middle.
    pub centre: DVec3,
    /// One edge from end to end.
    pub edge_u: DVec3,
    /// The other edge, at a right angle.
    pub edge_v: DVec3,
}

/// How many photons leave the lights, and where to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmissionSettings {
    /// Photons of all lights in a pass.
    pub photons: u32,
    /// Their flux.
    pub emission: Emission,
    /// Where to; otherwise to all that reflects or refracts.
    pub target: Option<TargetRectangle>,
    /// Whether some are for light that diffuse surfaces reflect.
    pub bounces: bool,
}

/// A point nearer to the plane of its target than this (times the edges) sends nothing there.
const LEAST_HEIGHT: f64 = 1e-6;

/// What a light sends, before photons are counted out.
struct Source {
    emitter: Emitter,
    /// All of it per channel, over the square of the local unit.
    flux: [f64; 3],
    /// Width over height of the grid of cells.
    aspect: f64,
}

/// The emitters of the lights that send anything, their photons one after the other. Without any, no photon is emitted.
///
/// # Errors
/// [`Error::Input`] where parallel light has no target, where the target is no rectangle, and where there are fewer
/// photons than lights.
pub fn emitters(
    lights: &[Light],
    surfaces: &SurfaceArrays,
    frame: &LocalFrame,
    settings: &EmissionSettings,
) -> Result<Vec<Emitter>> {
    let target = settings.target.map(|target| local_target(&target, frame)).transpose()?;
    let scene = Scene {
        specular: Parts::of(surfaces, |shape| is_specular(surfaces, shape)),
        all: Parts::of(surfaces, |_| true),
        focus: focus(surfaces),
        target,
        frame,
    };
    if settings.photons == 0 {
        return Ok(Vec::new());
    }
    let specular = target.is_some() || !scene.specular.parts.is_empty() || scene.specular.unbounded;
    let bounces = settings.bounces && diffuse_light_returns(surfaces);
    let wanted =
        |group: &Group| (specular || group.aim != Aim::Specular) && (bounces || group.role == role::CAUSTIC);
    let mut groups = Vec::new();
    for group in GROUPS.into_iter().filter(wanted) {
        let sources = scene.sources(lights, group.aim)?;
        let anything = group.aim != Aim::Elsewhere || has_elsewhere(&scene.focus, &scene.all);
        if anything && !sources.is_empty() {
            groups.push((group, sources));
        }
    }
    let sizes: Vec<(Group, u32)> =
        groups.iter().map(|(group, sources)| (*group, sources.len() as u32)).collect();
    let mut emitters = Vec::new();
    let mut first = 0;
    for ((group, sources), photons) in groups.iter().zip(split(settings.photons, &sizes)?) {
        let fluxes: Vec<f64> = sources.iter().map(|source| mean(source.flux)).collect();
        for (source, count) in sources.iter().zip(shares(&fluxes, photons)) {
            // As published, photons that are all alike end at the first diffuse surface.
            let alike = if group.role == role::CAUSTIC { settings.emission } else { Emission::Radiometric };
            let emitter = counted(source, first, count, alike);
            emitters.push(Emitter { role: group.role, ..emitter });
            first += count;
        }
    }
    Ok(emitters)
}

fn mean(color: [f64; 3]) -> f64 {
    color.iter().sum::<f64>() / 3.0
}

fn local_target(target: &TargetRectangle, frame: &LocalFrame) -> Result<Target> {
    const LARGEST_COSINE: f64 = 1e-6;
    let [u, v] = [target.edge_u, target.edge_v].map(DVec3::try_normalize);
    match (u, v) {
        (Some(u), Some(v)) if u.dot(v).abs() < LARGEST_COSINE => {
            let edge_u = target.edge_u / frame.unit;
            // A right angle to the last bit.
            let edge_v = (target.edge_v - target.edge_v.dot(u) * u) / frame.unit;
            Ok(Target { centre: frame.point(target.centre), edge_u, edge_v })
        }
        _ => Err(Error::Input(
            "the edges of the photons' target must be at a right angle, and not zero".into(),
        )),
    }
}

/// What lights send their photons to, local units.
struct Scene<'f> {
    specular: Parts,
    all: Parts,
    /// What diffuse light goes to and comes back from.
    focus: Parts,
    target: Option<Target>,
    frame: &'f LocalFrame,
}

impl Scene<'_> {
    /// What the lights send there that send anything.
    fn sources(&self, lights: &[Light], aim: Aim) -> Result<Vec<Source>> {
        let sources = lights.iter().enumerate().map(|(index, light)| self.source(index, light, aim));
        let sources: Vec<Option<Source>> = sources.collect::<Result<_>>()?;
        Ok(sources.into_iter().flatten().filter(|source| mean(source.flux) > 0.0).collect())
    }

    fn source(&self, light: usize, of: &Light, aim: Aim) -> Result<Option<Source>> {
        let unit2 = self.frame.unit * self.frame.unit;
        Ok(match of {
            Light::Point { position, intensity } => {
                let place = self.frame.point(*position);
                let intensity = intensity.map(|i| i / unit2);
                let target = self.target_from(&[place], aim);
                let through = target.map(|target| point(light, place, intensity, &target)).transpose()?;
                point_around(place, intensity).or_through(through, aim)
            }
            Light::Directional { direction, irradiance } => {
                self.directional(light, direction.normalize(), *irradiance, aim)?
            }
            Light::Rectangle { centre, edge_u, edge_v, radiance } => {
                let [u, v] = [*edge_u / self.frame.unit, *edge_v / self.frame.unit];
                let from = RectangleLight { centre: self.frame.point(*centre), u, v };
                let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].map(|[u, v]| from.at(u, v));
                let target = self.target_from(&corners, aim);
                let through = target.map(|target| from.through(&target, *radiance));
                from.around(*radiance).or_through(through, aim)
            }
        })
    }

    /// The rectangle for light from these places, unless it is everything.
    fn target_from(&self, places: &[DVec3], aim: Aim) -> Option<Target> {
        if aim != Aim::Specular {
            return near(&self.focus, &self.all, places);
        }
        let covering = || if self.specular.unbounded { None } else { self.specular.seen_from(places) };
        self.target.or_else(covering)
    }

    fn directional(
        &self,
        light: usize,
        direction: DVec3,
        irradiance: [f64; 3],
        aim: Aim,
    ) -> Result<Option<Source>> {
        let covering = if self.specular.unbounded { &self.all } else { &self.specular };
        let covered = || (!covering.parts.is_empty()).then(|| covering.seen_along(direction));
        let target = match aim {
            Aim::Specular => Some(self.target.or_else(covered).ok_or_else(|| {
                Error::Input(format!(
                    "photons of `light.{light}`, which is directional, need a target: nothing in the scene has bounds"
                ))
            })?),
            Aim::Near => near_along(&self.all, direction).or(self.target),
            Aim::Elsewhere => far_along(&self.all, direction),
        };
        Ok(target.map(|target| {
            let area = target.area() * target.normal().dot(direction).abs();
            let emitter = Emitter {
                place: float4(direction, self.all.begins_along(direction)),
                corner: float4(target.corner(), 0.0),
                edge_u: float4(target.edge_u, 0.0),
                edge_v: float4(target.edge_v, 0.0),
                normal: float4(target.normal(), 0.0),
                way: way::DIRECTIONAL,
                except: u32::from(aim == Aim::Elsewhere),
                ..Emitter::zeroed()
            };
            let aspect = target.edge_u.length() / target.edge_v.length();
            Source { emitter, flux: irradiance.map(|e| e * area), aspect }
        }))
    }
}

impl Source {
    /// All around, or through a target if there is one; or all around but for that, if there is anything elsewhere.
    fn or_through(self, through: Option<Source>, aim: Aim) -> Option<Source> {
        match (aim, through) {
            (Aim::Elsewhere, through) => through.map(|through| {
                let emitter = Emitter { way: self.emitter.way, except: 1, ..through.emitter };
                Source { emitter, ..self }
            }),
            (_, through) => Some(through.unwrap_or(self)),
        }
    }
}

fn point_around(place: DVec3, intensity: [f64; 3]) -> Source {
    let emitter = Emitter { place: float4(place, 0.0), way: way::SPHERE, ..Emitter::zeroed() };
    // The whole sphere is a square; see `sphere_direction` of the kernel.
    Source { emitter, flux: intensity.map(|i| 4.0 * PI * i), aspect: 1.0 }
}

fn point(light: usize, place: DVec3, intensity: [f64; 3], target: &Target) -> Result<Source> {
    let [u, v] = [target.edge_u, target.edge_v].map(DVec3::normalize);
    let corner = target.corner() - place;
    let corner = DVec3::new(corner.dot(u), corner.dot(v), corner.dot(target.normal()));
    let size = [target.edge_u.length(), target.edge_v.length()];
    if corner.z.abs() <= LEAST_HEIGHT * (size[0] + size[1]) {
        return Err(Error::Input(format!(
            "the target of the photons is seen edge-on from `light.{light}`; it must not lie in one plane with a light"
        )));
    }
    let angle = solid_angle(corner, size);
    let emitter = Emitter {
        place: float4(place, 0.0),
        power: float4(DVec3::from_array(intensity), 0.0),
        corner: float4(corner, 0.0),
        edge_u: float4(u, size[0]),
        edge_v: float4(v, size[1]),
        normal: float4(target.normal(), 0.0),
        way: way::POINT,
        ..Emitter::zeroed()
    };
    Ok(Source { emitter, flux: intensity.map(|i| i * angle), aspect: size[0] / size[1] })
}

/// A rectangular light (or a parallelogram), local units.
struct RectangleLight {
    centre: DVec3,
    u: DVec3,
    v: DVec3,
}

impl RectangleLight {
    fn normal(&self) -> DVec3 {
        self.u.cross(self.v).normalize()
    }

    fn area(&self) -> f64 {
        self.u.cross(self.v).length()
    }

    fn emitter(&self) -> Emitter {
        Emitter {
            place: float4(self.centre, 0.0),
            light_u: float4(self.u, 0.0),
            light_v: float4(self.v, 0.0),
            light_normal: float4(self.normal(), 0.0),
            ..Emitter::zeroed()
        }
    }

    fn around(&self, radiance: [f64; 3]) -> Source {
        let flux = radiance.map(|l| PI * l * self.area());
        let aspect = self.u.length() / self.v.length();
        Source { emitter: Emitter { way: way::HEMISPHERE, ..self.emitter() }, flux, aspect }
    }

    fn through(&self, target: &Target, radiance: [f64; 3]) -> Source {
        let seen = self.seen_by(target);
        let areas = self.area() * target.area();
        let emitter = Emitter {
            power: float4(DVec3::from_array(radiance) * areas, 0.0),
            corner: float4(target.corner(), 0.0),
            edge_u: float4(target.edge_u, 0.0),
            edge_v: float4(target.edge_v, 0.0),
            normal: float4(target.normal(), 0.0),
            way: way::RECTANGLE,
            ..self.emitter()
        };
        let aspect = target.edge_u.length() / target.edge_v.length();
        Source { emitter, flux: radiance.map(|l| l * seen), aspect }
    }

    fn at(&self, u: f64, v: f64) -> DVec3 {
        self.centre + (u - 0.5) * self.u + (v - 0.5) * self.v
    }

    /// The integral of both cosines over the squared distance, over both areas: by the midpoints of 32 cells per edge.
    /// Photons are counted out by it, and for [`Emission::Equal`] alone it is their flux.
    fn seen_by(&self, target: &Target) -> f64 {
        const CELLS: u32 = 32;
        let middles = || (0..CELLS).map(|i| (f64::from(i) + 0.5) / f64::from(CELLS));
        let squares = || middles().flat_map(|u| middles().map(move |v| [u, v]));
        let [front, across] = [self.normal(), target.normal()];
        let mut sum = 0.0;
        for [u, v] in squares() {
            let from = self.at(u, v);
            for [u, v] in squares() {
                let to = target.at(u, v) - from;
                sum += to.dot(front).max(0.0) * to.dot(across).abs() / to.length_squared().powi(2);
            }
        }
        sum * self.area() * target.area() / f64::from(CELLS).powi(4)
    }
}

/// Solid angle of a rectangle from the origin: `corner` along its edges and across, and its `size`.
fn solid_angle(corner: DVec3, size: [f64; 2]) -> f64 {
    let part = |x: f64, y: f64| (x * y).atan2(corner.z.abs() * (x * x + y * y + corner.z * corner.z).sqrt());
    let [x, y] = [corner.x, corner.y];
    part(x + size[0], y + size[1]) - part(x + size[0], y) - part(x, y + size[1]) + part(x, y)
}

/// The emitter with its photons and their flux.
fn counted(source: &Source, first: u32, count: u32, emission: Emission) -> Emitter {
    let number = f64::from(count);
    let rows = (number / source.aspect).sqrt().round().clamp(1.0, number) as u32;
    let emitter = Emitter { first, count, rows, ..source.emitter };
    let each = float4(DVec3::from_array(source.flux.map(|flux| flux / number)), 1.0);
    match (emitter.way, emission) {
        (way::POINT, Emission::Radiometric) => emitter,
        (way::RECTANGLE, Emission::Radiometric) => {
            let [r, g, b, _] = emitter.power.map(|power| (f64::from(power) / number) as f32);
            Emitter { power: [r, g, b, 0.0], ..emitter }
        }
        _ => Emitter { power: each, ..emitter },
    }
}

fn float4(v: DVec3, w: f64) -> [f32; 4] {
    [v.x as f32, v.y as f32, v.z as f32, w as f32]
}
