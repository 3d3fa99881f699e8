//! What is found.

use glam::DVec3;

/// The point of the triangles that is closest to a given one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Closest {
    /// Id of the triangle; the smallest of several at the same distance.
    pub triangle: u32,
    /// Where.
    pub point: DVec3,
    /// Squared distance.
    pub distance_squared: f64,
}

impl Closest {
    /// The distance.
    pub fn distance(&self) -> f64 {
        self.distance_squared.sqrt()
    }
}

/// Where a ray meets a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Id of the triangle.
    pub triangle: u32,
    /// Distance along the ray, in lengths of its direction.
    pub t: f64,
    /// The ray meets the front, against the normal.
    pub front: bool,
}
