//! Fields of one line each: constant, ramp, sphere and cloud.

use super::{Field, FieldError};
use glam::DVec3;
use std::f64::consts::PI;

/// Voxels are `float32`: a parameter beyond that would turn them infinite.
fn representable(parameter: &'static str, value: f64) -> Result<f64, FieldError> {
    if value.abs() <= f64::from(f32::MAX) {
        return Ok(value);
    }
    Err(FieldError::new(
        parameter,
        format_args!("{value:e}"),
        "it must be finite and within the range of float32",
    ))
}

/// The same value everywhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Constant {
    value: f64,
}

impl Constant {
    /// # Errors
    /// When the value is not finite in `float32`.
    pub fn new(value: f64) -> Result<Self, FieldError> {
        Ok(Self { value: representable("value", value)? })
    }
}

impl Field for Constant {
    fn value(&self, _: DVec3) -> f64 {
        self.value
    }

    fn gradient(&self, _: DVec3) -> DVec3 {
        DVec3::ZERO
    }
}

/// An axis of the box.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// The fastest axis.
    X,
    /// The middle axis.
    Y,
    /// The slowest axis.
    Z,
}

impl Axis {
    fn unit(self) -> DVec3 {
        match self {
            Self::X => DVec3::X,
            Self::Y => DVec3::Y,
            Self::Z => DVec3::Z,
        }
    }
}

/// Linear from one face of the box to the opposite one: `from + (to − from)·p_axis`.
///
/// Sampled at voxel centres and clamped at the border, it is constant in the outer half voxels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ramp {
    from: f64,
    to: f64,
    axis: Axis,
}

impl Ramp {
    /// # Errors
    /// When an end is not finite in `float32`.
    pub fn new(from: f64, to: f64, axis: Axis) -> Result<Self, FieldError> {
        Ok(Self { from: representable("from", from)?, to: representable("to", to)?, axis })
    }
}

impl Field for Ramp {
    fn value(&self, p: DVec3) -> f64 {
        self.from + (self.to - self.from) * p.dot(self.axis.unit())
    }

    fn gradient(&self, _: DVec3) -> DVec3 {
        (self.to - self.from) * self.axis.unit()
    }
}

/// Signed distance to a sphere, positive inside: `radius − |p − centre|`.
///
/// Its own coordinates are fractions of the largest extent of the box, `p·aspect`, so that the sphere is round in
/// a box that is not a cube.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    centre: DVec3,
    radius: f64,
    aspect: DVec3,
}

impl Sphere {
    /// A sphere around `centre ∈ [0, 1]³` (per axis of the box, other places allowed). `aspect` is the extent of
    /// the box along each axis over the largest one.
    ///
    /// # Errors
    /// When a parameter is not finite, the radius is not positive, or the aspect is not in (0, 1].
    pub fn new(centre: DVec3, radius: f64, aspect: DVec3) -> Result<Self, FieldError> {
        if centre.abs().max_element() > 1e6 || centre.is_nan() {
            return Err(FieldError::new("centre", centre, "each part must be finite and at most 1e6"));
        }
        if !(radius > 0.0 && radius <= 1e6) {
            return Err(FieldError::new("radius", radius, "it must be greater than 0 and at most 1e6"));
        }
        Ok(Self { centre, radius, aspect: checked_aspect(aspect)? })
    }

    fn offset(&self, p: DVec3) -> DVec3 {
        (p - self.centre) * self.aspect
    }
}

impl Field for Sphere {
    fn value(&self, p: DVec3) -> f64 {
        self.radius - self.offset(p).length()
    }

    fn gradient(&self, p: DVec3) -> DVec3 {
        -self.offset(p).normalize_or_zero()
    }

    fn extent(&self) -> DVec3 {
        self.aspect
    }
}

/// Extents of a box over the largest one.
pub(super) fn checked_aspect(aspect: DVec3) -> Result<DVec3, FieldError> {
    if aspect.to_array().iter().all(|a| *a > 0.0 && *a <= 1.0) {
        return Ok(aspect);
    }
    Err(FieldError::new("aspect", aspect, "each part must be in (0, 1]"))
}

/// A ball that thins out linearly and is modulated by waves:
/// `max(0, 1 − |p − ½|/0.4)·(½ + ½ sin 12πx sin 9πy sin 7πz)`, in [0, 1].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cloud;

impl Cloud {
    const RADIUS: f64 = 0.4;
    /// Angular frequency of the waves along x, y, z.
    const WAVES: DVec3 = DVec3::new(12.0 * PI, 9.0 * PI, 7.0 * PI);
}

impl Field for Cloud {
    fn value(&self, p: DVec3) -> f64 {
        let ball = (1.0 - (p - 0.5).length() / Self::RADIUS).max(0.0);
        let wave = Self::WAVES * p;
        ball * (0.5 + 0.5 * wave.x.sin() * wave.y.sin() * wave.z.sin())
    }

    fn gradient(&self, p: DVec3) -> DVec3 {
        let from_centre = p - 0.5;
        let ball = 1.0 - from_centre.length() / Self::RADIUS;
        if ball <= 0.0 {
            return DVec3::ZERO;
        }
        let wave = Self::WAVES * p;
        let ((sx, cx), (sy, cy), (sz, cz)) = (wave.x.sin_cos(), wave.y.sin_cos(), wave.z.sin_cos());
        let slope = 0.5 * Self::WAVES * DVec3::new(cx * sy * sz, sx * cy * sz, sx * sy * cz);
        let ball_slope = -from_centre.normalize_or_zero() / Self::RADIUS;
        ball_slope * (0.5 + 0.5 * sx * sy * sz) + ball * slope
    }
}
