//! The ground truth of a model: the exact surface behind every label, and area and volume of the smooth model.

use glam::DVec3;

/// The exact surface that the vertices of the faces with one `truth` label lie on.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Shape {
    /// A plane; the normal points out of the material.
    Plane {
        /// A point of the plane.
        origin: DVec3,
        /// Unit normal.
        normal: DVec3,
    },
    /// A circular cylinder.
    Cylinder {
        /// A point of the axis.
        origin: DVec3,
        /// Unit direction of the axis.
        axis: DVec3,
        /// Radius.
        radius: f64,
    },
    /// A sphere.
    Sphere {
        /// Centre.
        center: DVec3,
        /// Radius.
        radius: f64,
    },
    /// A ring torus.
    Torus {
        /// Centre.
        center: DVec3,
        /// Unit direction of the axis of revolution.
        axis: DVec3,
        /// Radius of the circle that the tube's centre runs along.
        major_radius: f64,
        /// Radius of the tube.
        minor_radius: f64,
    },
    /// None of the above; nothing is claimed.
    Freeform,
}

impl Shape {
    /// Distance of a point from the surface; zero for [`Shape::Freeform`].
    pub fn distance(&self, p: DVec3) -> f64 {
        match *self {
            Shape::Plane { origin, normal } => (p - origin).dot(normal).abs(),
            Shape::Cylinder { origin, axis, radius } => (from_axis(p - origin, axis) - radius).abs(),
            Shape::Sphere { center, radius } => (p.distance(center) - radius).abs(),
            Shape::Torus { center, axis, major_radius, minor_radius } => {
                let across = from_axis(p - center, axis) - major_radius;
                (across.hypot((p - center).dot(axis)) - minor_radius).abs()
            }
            Shape::Freeform => 0.0,
        }
    }
}

/// Distance of `d` from the line through the origin along `axis`.
fn from_axis(d: DVec3, axis: DVec3) -> f64 {
    (d - axis * d.dot(axis)).length()
}

/// Measures of the smooth model, which the mesh approaches as its resolution grows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measure {
    /// Surface area.
    pub area: f64,
    /// Enclosed volume; `None` for an open surface.
    pub volume: Option<f64>,
}

impl Measure {
    /// Measures of a closed surface.
    pub(super) fn closed(area: f64, volume: f64) -> Option<Self> {
        Some(Measure { area, volume: Some(volume) })
    }

    /// Measures of an open surface.
    pub(super) fn open(area: f64) -> Option<Self> {
        Some(Measure { area, volume: None })
    }
}
