//! The boundary score (§5.2): how well an edge follows the lines of minimum curvature.

use super::surface::{Sharp, Surface};
use crate::geometry::curvature::Curvature;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};

/// w_c of equation 5, which has no unit: 1, because both terms have about the same range.
const CURVATURE_WEIGHT: f64 = 1.0;
/// Curvatures times the length scale below which a vertex has no direction, because rounding alone gives it one.
const FLAT_CURVATURE: f64 = 1e-9;

/// Scores edges.
pub struct Scores<'a> {
    pub surface: &'a Surface<'a>,
    pub sharp: &'a Sharp,
    pub curvature: &'a Curvature,
    /// Length scale L.
    pub scale: f64,
}

impl Scores<'_> {
    /// S of the edge that leaves corner `c`, equation 5: 0 for the best boundary, 0 on creases; at most 2.
    pub fn score(&self, c: u32) -> f64 {
        if self.sharp.edge[c as usize] {
            return 0.0;
        }
        let t = self.surface.triangles;
        let ends = [t.vertex(c), t.vertex(t.next(c))];
        let along = t.point(t.next(c)) - t.point(c);
        let angle = ends.iter().map(|&v| self.angle(v, along)).sum::<f64>() / PI;
        angle + CURVATURE_WEIGHT * self.difference(ends)
    }

    /// (|k|_max, |k|_min, direction of |k|_min, direction of |k|_max) of a vertex, times L.
    fn tensor(&self, v: u32) -> (f64, f64, DVec3, DVec3) {
        let (k, v) = (self.curvature, v as usize);
        let (low, high) = (k.kmin[v].abs() * self.scale, k.kmax[v].abs() * self.scale);
        if high >= low { (high, low, k.dmin[v], k.dmax[v]) } else { (low, high, k.dmax[v], k.dmin[v]) }
    }

    /// One of the two summands of equation 6, in 0..=π/2; halfway where the vertex has no direction.
    fn angle(&self, v: u32, along: DVec3) -> f64 {
        let (high, low, d_low, d_high) = self.tensor(v);
        if high + low <= FLAT_CURVATURE || d_low == DVec3::ZERO {
            return FRAC_PI_2 / 2.0;
        }
        let unsigned = |d: DVec3| along.cross(d).length().atan2(along.dot(d).abs());
        (unsigned(d_low) * high + unsigned(d_high) * low) / (high + low)
    }

    /// S_c of equation 7, in 0..=1.
    fn difference(&self, [a, b]: [u32; 2]) -> f64 {
        let ((a_high, a_low, ..), (b_high, b_low, ..)) = (self.tensor(a), self.tensor(b));
        let size = a_low.max(b_low) + a_high.max(b_high);
        if size > 0.0 { ((a_low - b_low).abs() + (a_high - b_high).abs()) / size } else { 0.0 }
    }
}
