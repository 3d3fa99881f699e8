//! Orange slices: two poles that all quads share, one vertex on the meridian between every two directions.
//!
//! ```text
//!        pole 0
//!       ╱  │  ╲
//!    m₋ │ d │ m₊      the quad of d: pole 0, m₋, pole 1, m₊
//!       ╲  │  ╱
//!        pole 1
//! ```

use super::partition::Connection;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Axes to try: a spiral over half the sphere.
pub fn axes(count: usize) -> impl Iterator<Item = DVec3> {
    let golden = PI * (3.0 - 5f64.sqrt());
    (0..count).map(move |k| {
        let z = (k as f64 + 0.5) / count as f64;
        let (sin, cos) = (golden * k as f64).sin_cos();
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * cos, r * sin, z)
    })
}

/// The normal of the plane that fits the directions best.
pub fn normal(directions: &[DVec3]) -> Option<DVec3> {
    let mut covariance = glam::DMat3::ZERO;
    directions.iter().for_each(|d| covariance += crate::numeric::eigen3::outer(*d));
    flattest(directions, covariance)
}

/// The direction of least covariance: the inverse, with a small shift, to the power of 64 has it in all columns.
fn flattest(directions: &[DVec3], covariance: glam::DMat3) -> Option<DVec3> {
    let shifted = covariance + glam::DMat3::IDENTITY * (1e-9 * directions.len() as f64);
    let mut power = shifted.inverse();
    let trace = |m: &glam::DMat3| m.x_axis.x + m.y_axis.y + m.z_axis.z;
    for _ in 0..6 {
        power *= 1.0 / trace(&power);
        power = power * power;
    }
    let columns = [power.x_axis, power.y_axis, power.z_axis];
    columns.into_iter().max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))?.try_normalize()
}

impl Connection {
    /// Becomes the slices about an axis; false where the azimuths of two directions differ by less than `least_gap`.
    /// `order` is working memory.
    pub fn slice(&mut self, directions: &[DVec3], axis: DVec3, least_gap: f64, order: &mut Vec<(f64, usize)>) -> bool {
        let (u, v) = axis.any_orthonormal_pair();
        // Right-handed: u × v = axis.
        let v = if u.cross(v).dot(axis) < 0.0 { -v } else { v };
        order.clear();
        order.extend(directions.iter().enumerate().map(|(k, d)| (d.dot(v).atan2(d.dot(u)), k)));
        order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let n = order.len();
        self.vertices.clear();
        self.vertices.extend([axis, -axis]);
        self.valences.clear();
        self.valences.extend([n as u32; 2]);
        self.quads.resize(n, [0; 4]);
        self.sides.resize(n, [0; 4]);
        for k in 0..n {
            let (from, direction) = order[k];
            let to = if k + 1 < n { order[k + 1].0 } else { order[0].0 + TAU };
            if to - from < least_gap {
                return false;
            }
            let (sin, cos) = (0.5 * (from + to)).sin_cos();
            self.vertices.push(u * cos + v * sin);
            self.valences.push(2);
            let (before, here) = (((k + n - 1) % n) as u32, k as u32);
            self.quads[direction] = [0, 2 + before, 1, 2 + here];
            self.sides[direction] = [2 * before, 2 * before + 1, 2 * here + 1, 2 * here];
        }
        true
    }
}
