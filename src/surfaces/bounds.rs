//! Boxes along the axes.

use glam::DVec3;

/// A box along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The corner with the lowest coordinates.
    pub low: DVec3,
    /// The corner with the highest coordinates.
    pub high: DVec3,
}

impl Bounds {
    /// The smallest box around points, if there is any.
    pub fn of(points: impl IntoIterator<Item = DVec3>) -> Option<Self> {
        Self::around(points.into_iter().map(|point| Self { low: point, high: point }))
    }

    /// The smallest box around boxes, if there is any.
    pub fn around(boxes: impl IntoIterator<Item = Self>) -> Option<Self> {
        boxes.into_iter().reduce(|a, b| a.with(&b))
    }

    /// The smallest box around this one and another.
    pub fn with(&self, other: &Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// Its middle.
    pub fn centre(&self) -> DVec3 {
        0.5 * self.low + 0.5 * self.high
    }

    /// Its extents.
    pub fn size(&self) -> DVec3 {
        self.high - self.low
    }

    /// Half the area of its faces.
    pub(super) fn half_area(&self) -> f64 {
        let size = self.size();
        size.x * size.y + size.y * size.z + size.z * size.x
    }
}
