//! Which rays may begin in glass.

use super::arrays::kind;
use super::bounds::Bounds;
use super::{DeviceMaterial, DeviceShape, SurfaceArrays};
use glam::DVec3;
use std::collections::BTreeMap;

impl SurfaceArrays {
    /// Whether something that begins in a box (local units) may begin in glass that absorbs, or with `any` in any glass. By
    /// boxes around bodies; panes are taken for half-spaces.
    pub fn may_begin_within(&self, places: &Bounds, any: bool) -> bool {
        let counts = |material: &DeviceMaterial| {
            material.kind == DeviceMaterial::DIELECTRIC
                && (any || material.absorption[..3].iter().any(|&sigma| sigma != 0.0))
        };
        let mut bodies: BTreeMap<u32, Bounds> = BTreeMap::new();
        for shape in &self.shapes {
            if !counts(&self.materials[self.materials_of[shape.surface as usize] as usize]) {
                continue;
            }
            match bounds(shape) {
                Ok(own) => {
                    bodies.entry(shape.surface).and_modify(|all| *all = all.with(&own)).or_insert(own);
                }
                Err((normal, offset)) if is_behind(places, normal, offset) => return true,
                Err(_) => {}
            }
        }
        bodies.values().any(|body| body.low.cmple(places.high).all() && body.high.cmpge(places.low).all())
    }
}

/// The box around a shape; or of a flat one, its normal and how far its plane is from the origin along that.
fn bounds(shape: &DeviceShape) -> Result<Bounds, (DVec3, f64)> {
    let vector = |[x, y, z, _]: [f32; 4]| DVec3::new(x.into(), y.into(), z.into());
    let [a, b, c] = [shape.a, shape.b, shape.c].map(vector);
    let flat = |plane: [f32; 4]| Err((vector(plane), plane[3].into()));
    match shape.kind {
        kind::SPHERE => {
            let radius = f64::from(shape.a[3]);
            Ok(Bounds { low: a - radius, high: a + radius })
        }
        kind::BOX | kind::METABALLS => Ok(Bounds { low: a, high: b }),
        kind::TRIANGLE => Ok(Bounds { low: a.min(b).min(c), high: a.max(b).max(c) }),
        kind::RECTANGLE => flat(shape.d),
        _ => flat(shape.b),
    }
}

/// Whether a corner of a box is behind a plane.
fn is_behind(places: &Bounds, normal: DVec3, offset: f64) -> bool {
    let nearest = DVec3::select(normal.cmpgt(DVec3::ZERO), places.low, places.high);
    normal.dot(nearest) < offset
}
