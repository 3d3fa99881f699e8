//! Orange slices: two poles that all quads share, one vertex on the meridian between every two directions.
//!
//! ```text
//!        pole 0
//!       ╱  │  ╲
//!    m₋ │ d │ m₊      the quad of d: pole 0, m₋, pole 1, m₊
//!       ╲  │  ╱
//!        pole 1
//! ```

use super::Connection;
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

/// The direction of least covariance: inverse iteration with a small shift.
fn flattest(directions: &[DVec3], covariance: glam::DMat3) -> Option<DVec3> {
    let shifted = covariance + glam::DMat3::IDENTITY * (1e-9 * directions.len() as f64);
    let inverse = shifted.inverse();
    let mut axis = DVec3::new(0.48, 0.6, 0.64);
    for _ in 0..40 {
        axis = (inverse * axis).try_normalize()?;
    }
    Some(axis)
}

/// Slices about an axis; `None` where the azimuths of two directions differ by less than `least_gap`.
pub fn slices(directions: &[DVec3], axis: DVec3, least_gap: f64) -> Option<Connection> {
    let (u, v) = axis.any_orthonormal_pair();
    // Right-handed: u × v = axis.
    let v = if u.cross(v).dot(axis) < 0.0 { -v } else { v };
    let azimuth = |d: &DVec3| d.dot(v).atan2(d.dot(u));
    let mut order: Vec<(f64, usize)> = directions.iter().enumerate().map(|(k, d)| (azimuth(d), k)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let n = order.len();
    let mut vertices = vec![axis, -axis];
    let (mut quads, mut sides) = (vec![[0; 4]; n], vec![[0; 4]; n]);
    for (k, &(from, direction)) in order.iter().enumerate() {
        let to = if k + 1 < n { order[k + 1].0 } else { order[0].0 + TAU };
        if to - from < least_gap {
            return None;
        }
        let (sin, cos) = (0.5 * (from + to)).sin_cos();
        vertices.push(u * cos + v * sin);
        let (before, here) = (((k + n - 1) % n) as u32, k as u32);
        quads[direction] = [0, 2 + before, 1, 2 + here];
        sides[direction] = [2 * before, 2 * before + 1, 2 * here + 1, 2 * here];
    }
    Some(Connection { vertices, quads, sides })
}
