//! How strongly a surface bends at its vertices.

use super::curves::Rank;
use super::smoothed::rounds;
use super::support::Support;
use crate::mesh::NONE;
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::FRAC_PI_2;

/// Points of a curvature fit; rings of needles can be larger.
pub const FIT_POINTS: usize = 96;

/// Radii are made steady where one ring of edges is within this share of the size.
pub const STEADY_SHARE: f64 = 0.21;
/// The quantile of the curvatures around a vertex that its own may have.
pub const STEADY_QUANTILE: f64 = 0.68;

/// Smallest principal radius at a vertex, near by and farther away.
#[derive(Debug, Clone, Copy)]
pub struct Radius {
    /// With weights that fall with the fourth power of the distance.
    near: f64,
    /// With weights that rise with the fourth power of the distance.
    far: f64,
    /// Mean length of the edges.
    pub spacing: f64,
}

impl Radius {
    /// The radius at the scale of the size α r: near where sizes are up to twice as long as edges, far where they are more
    /// than three times as long.
    pub fn at_scale(&self, alpha: f64) -> f64 {
        if !(self.near.is_finite() && self.far.is_finite()) {
            return self.near.min(self.far);
        }
        let t = (alpha * self.far / self.spacing - 2.0).clamp(0.0, 1.0);
        match t {
            0.0 => self.near,
            1.0 => self.far,
            _ => self.near.powf(1.0 - t) * self.far.powf(t),
        }
    }
}

/// A quantile of sorted values, interpolated.
pub fn quantile(sorted: &[f64], share: f64) -> f64 {
    let at = share * (sorted.len() - 1) as f64;
    let (low, high) = (at.floor() as usize, at.ceil() as usize);
    sorted[low] + at.fract() * (sorted[high] - sorted[low])
}

/// Gaussian elimination with pivoting of three equations; `None` where a pivot is below `least`.
pub fn solve3(mut m: [[f64; 4]; 3], least: f64) -> Option<[f64; 3]> {
    for k in 0..3 {
        let pivot = (k..3).max_by(|&a, &b| m[a][k].abs().total_cmp(&m[b][k].abs()))?;
        m.swap(k, pivot);
        if !(m[k][k].abs() > least) {
            return None;
        }
        for i in k + 1..3 {
            let factor = m[i][k] / m[k][k];
            for j in k..4 {
                m[i][j] -= factor * m[k][j];
            }
        }
    }
    let z = m[2][3] / m[2][2];
    let y = (m[1][3] - m[1][2] * z) / m[1][1];
    let x = (m[0][3] - m[0][1] * y - m[0][2] * z) / m[0][0];
    Some([x, y, z])
}

impl Support {
    /// Smallest principal radius at every vertex, the smallest over its sides; infinite where the surface is flat.
    ///
    /// In the tangent frame z = ½ (a x² + 2 b x y + c y²) is fitted to the two rings around the vertex that are reached
    /// without crossing a curve; the radius is the inverse of the larger eigenvalue.
    pub fn radii(&self, rank: &[Rank]) -> Vec<Radius> {
        let mesh = &self.mesh;
        let of = |points: &mut Vec<u32>, v: u32| {
            let mut radius = Radius { near: f64::INFINITY, far: f64::INFINITY, spacing: 1.0 };
            self.for_sides(v, rank, points, |[near, far], _| {
                (radius.near, radius.far) = (radius.near.min(near), radius.far.min(far));
            });
            let (mut sum, mut count) = (0.0, 0.0);
            for h in mesh.around(v) {
                sum += mesh.points[v as usize].distance(mesh.points[mesh.head(h) as usize]);
                count += 1.0;
            }
            radius.spacing = if count > 0.0 { sum / count } else { 1.0 };
            radius
        };
        (0..mesh.vertex_slots()).into_par_iter().with_min_len(256).map_init(Vec::new, of).collect()
    }

    /// The direction in which the surface bends less at every vertex, as long as the root of one minus the ratio of the
    /// curvatures.
    pub fn bends(&self, rank: &[Rank]) -> Vec<DVec3> {
        let of = |points: &mut Vec<u32>, v: u32| {
            let mut bend = DVec3::ZERO;
            self.for_sides(v, rank, points, |_, found| bend = found);
            bend
        };
        (0..self.mesh.vertex_slots()).into_par_iter().with_min_len(256).map_init(Vec::new, of).collect()
    }

    /// Visits the fits on all sides of a vertex: the radii near by and farther away, and the bend.
    fn for_sides(&self, v: u32, rank: &[Rank], points: &mut Vec<u32>, mut visit: impl FnMut([f64; 2], DVec3)) {
        let mut done = NONE;
        for wedge in self.mesh.around(v).map(|h| self.mesh.wedge(h)) {
            if wedge != done {
                done = wedge;
                self.two_rings(v, wedge, rank, points);
                let (radii, bend) = self.fitted_radii(v, wedge, points);
                visit(radii, bend);
            }
        }
    }

    /// Radii without those that are small at single vertices, where sizes are many edges long: there they are noise, and
    /// gradation would spread them. The curvature of a vertex comes down to an upper quantile of those around it.
    pub fn steady_radii(&self, radius: Vec<f64>, rank: &[Rank], alpha: f64) -> Vec<f64> {
        let size: Vec<f64> = radius.iter().map(|r| (alpha * r).min(f64::MAX)).collect();
        let coarse = rounds(&self.rings, &size, STEADY_SHARE, 1);
        let of = |ring: &mut Vec<f64>, v: u32| {
            let own = radius[v as usize];
            if coarse[v as usize] == 0 || rank[v as usize] != Rank::Free {
                return own;
            }
            ring.clear();
            ring.push(own.recip());
            let free = self.rings.of(v).iter().filter(|&&w| rank[w as usize] == Rank::Free);
            ring.extend(free.map(|&w| radius[w as usize].recip()));
            ring.sort_unstable_by(f64::total_cmp);
            quantile(ring, STEADY_QUANTILE).recip().max(own)
        };
        (0..self.rings.len()).into_par_iter().with_min_len(256).map_init(Vec::new, of).collect()
    }

    /// Vertices of the two rings around one wedge.
    fn two_rings(&self, v: u32, wedge: u32, rank: &[Rank], out: &mut Vec<u32>) {
        let mesh = &self.mesh;
        out.clear();
        let add = |out: &mut Vec<u32>, w: u32| {
            if w != v && out.len() < FIT_POINTS && !out.contains(&w) {
                out.push(w);
            }
        };
        for h in mesh.around(v).filter(|&h| mesh.wedge(h) == wedge) {
            add(out, mesh.head(h));
            add(out, mesh.apex(h));
        }
        for k in 0..out.len() {
            if rank[out[k] as usize] == Rank::Free {
                self.rings.of(out[k]).iter().for_each(|&w| add(out, w));
            }
        }
    }

    /// The radii near by and farther away, and the bend of the latter.
    fn fitted_radii(&self, v: u32, wedge: u32, points: &[u32]) -> ([f64; 2], DVec3) {
        let n = self.normal[wedge as usize];
        let p = self.mesh.points[v as usize];
        let (x, y) = n.any_orthonormal_pair();
        let mut systems = [[[0.0; 4]; 3]; 2];
        let (mut scale, mut sharpest) = (0.0f64, 0.0f64);
        for &w in points {
            let d = self.mesh.points[w as usize] - p;
            let squared = d.length_squared();
            scale = scale.max(squared);
            sharpest = sharpest.max(2.0 * d.dot(n).abs() / squared.max(f64::MIN_POSITIVE));
        }
        if points.is_empty() || !(scale > 0.0) {
            return ([f64::INFINITY; 2], DVec3::ZERO);
        }
        let unit_length = scale.sqrt().recip();
        for &w in points {
            let d = (self.mesh.points[w as usize] - p) * unit_length;
            let (u, v, z) = (d.dot(x), d.dot(y), d.dot(n));
            let row = [0.5 * u * u, u * v, 0.5 * v * v];
            let squared = (u * u + v * v + z * z).max(1e-9);
            let far = squared * squared;
            for (m, weight) in systems.iter_mut().zip([far.recip(), far]) {
                for i in 0..3 {
                    for j in 0..3 {
                        m[i][j] += weight * row[i] * row[j];
                    }
                    m[i][3] += weight * row[i] * z;
                }
            }
        }
        let mut bend = DVec3::ZERO;
        let radii = systems.map(|m| {
            let trace = m[0][0] + m[1][1] + m[2][2];
            match solve3(m, 1e-7 * trace).filter(|_| points.len() >= 5) {
                Some([a, b, c]) => {
                    let (mean, half) = (0.5 * (a + c), 0.5 * (a - c));
                    let spread = (half * half + b * b).sqrt();
                    let largest = mean.abs() + spread;
                    // The eigenvector of the smaller curvature stands across that of the larger one.
                    let angle = 0.5 * b.atan2(half) + if mean >= 0.0 { FRAC_PI_2 } else { 0.0 };
                    let ratio = (mean.abs() - spread).abs() / largest.max(f64::MIN_POSITIVE);
                    bend = (x * angle.cos() + y * angle.sin()) * (1.0 - ratio).max(0.0).sqrt();
                    (largest * unit_length).recip()
                }
                // Too few points, or all on one conic: the sharpest circle through a neighbour.
                None => sharpest.recip(),
            }
        });
        (radii, bend)
    }
}
