//! Coordinates brought into a range where products of lengths neither overflow nor vanish.

use crate::mesh::Triangles;
use glam::DVec3;
use rayon::prelude::*;

/// Lengths stay as they are between these powers of two: fourth powers are far from the ends of the range.
const FREE: std::ops::RangeInclusive<i32> = -64..=64;

/// The power of two that lengths are divided by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Scale(i32);

impl Scale {
    /// The scale of the vertices that faces use. A power of two rounds nothing: a mesh and its double give the same digits.
    pub fn of(triangles: Triangles<'_>) -> Self {
        let all =
            triangles.points().par_iter().with_min_len(4096).map(|p| p.abs().max_element()).reduce(|| 0.0, f64::max);
        let some = if triangles.is_empty() { 0.0 } else { triangles.point(0).abs().max_element() };
        // The largest is between these two: most often there is no need to look which vertices are used.
        if [some, all].iter().all(|&x| x > 0.0 && FREE.contains(&exponent(x))) {
            return Scale(0);
        }
        let largest = |c: u32| triangles.point(c).abs().max_element();
        let corners = (0..3 * triangles.len() as u32).into_par_iter().with_min_len(4096);
        let largest = exponent(corners.map(largest).reduce(|| 0.0, f64::max));
        Scale(if FREE.contains(&largest) { 0 } else { largest })
    }

    /// The points to work on, where they are not the mesh's own.
    pub fn points(self, points: &[DVec3]) -> Option<Vec<DVec3>> {
        // Vertices without faces may lie anywhere; nothing depends on them.
        (self.0 != 0)
            .then(|| points.iter().map(|p| DVec3::from_array(p.to_array().map(|x| times(x, -self.0)))).collect())
    }

    /// A length of the model as one to work with.
    pub fn length(self, x: f64) -> f64 {
        times(x, -self.0)
    }

    /// A curvature as one of the model.
    pub fn curvature(self, k: f64) -> f64 {
        times(k, -self.0)
    }

    /// An area as one of the model.
    pub fn area(self, area: f64) -> f64 {
        times(times(area, self.0), self.0)
    }
}

/// Of the power of two just below a length; zero of none.
fn exponent(length: f64) -> i32 {
    if length > 0.0 { length.log2().floor() as i32 } else { 0 }
}

/// x · 2ⁿ; the largest number where that is beyond the range.
fn times(x: f64, n: i32) -> f64 {
    if n == 0 {
        return x;
    }
    let halves = [n / 2, n - n / 2].map(|half| 2f64.powi(half));
    (x * halves[0] * halves[1]).clamp(f64::MIN, f64::MAX)
}
