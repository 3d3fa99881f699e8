//! A cube with a cylinder on two opposite faces, after the test model "CubeCylindres" of Bénière et al., REFIG 5(1), 2011.
//!
//! The paper's own file is not public; with the default parameters this model has its counts: 1,306 vertices and 2,608
//! triangles. It is regular (grids on the cube's sides and on the cylinders) except where the cylinders stand on the
//! cube and on their ends:
//!
//! ```text
//!   ┌──────────┐   The square's loop of 4·13 = 52 edges is joined to the foot's 34 by angle, without inner points.
//!   │╲ ╱──╲ ╱ ╱│
//!   │─│    │ ──│   The ends of the cylinders are strips that zigzag across.
//!   │╱ ╲──╱ ╲ ╲│
//!   └──────────┘
//! ```

use super::builder::{Builder, circle};
use super::limits::{affordable, at_least, positive, within};
use super::model::Model;
use super::shape::{Measure, Shape};
use crate::error::Result;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Parameters of [`cube_cylinders`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CubeCylinders {
    /// Quads along an edge of the cube `[−1, 1]³`.
    pub quads: u32,
    /// Segments around a cylinder.
    pub segments: u32,
    /// Rings of quads along the upper (z > 1) and the lower cylinder.
    pub rings: [u32; 2],
    /// Radius of the cylinders, less than 1.
    pub radius: f64,
    /// Lengths of the upper and the lower cylinder.
    pub lengths: [f64; 2],
}

impl Default for CubeCylinders {
    fn default() -> Self {
        CubeCylinders { quads: 13, segments: 34, rings: [8, 7], radius: 0.6, lengths: [0.8, 0.7] }
    }
}

/// The cube with two cylinders. Labels: 0–3 the free sides, 4–6 platform, cylinder and end above, 7–9 those below.
///
/// # Errors
/// [`Error::Options`](crate::Error::Options) for sizes that make no such model, or one of too many triangles.
pub fn cube_cylinders(p: &CubeCylinders) -> Result<Model> {
    check(p)?;
    let mut b = Builder::default();
    let levels = cube_sides(&mut b, p.quads);
    if let (Some(bottom), Some(top)) = (levels.first(), levels.last()) {
        pillar(&mut b, p, top, 0);
        pillar(&mut b, p, bottom, 1);
    }
    let length: f64 = p.lengths.iter().sum();
    b.finish(Measure::closed(24.0 + TAU * p.radius * length, 8.0 + PI * p.radius.powi(2) * length))
}

fn check(p: &CubeCylinders) -> Result<()> {
    at_least("quads", p.quads, 1)?;
    at_least("segments", p.segments, 3)?;
    p.rings.iter().try_for_each(|&r| at_least("rings", r, 1))?;
    p.lengths.iter().try_for_each(|&l| positive("length", l))?;
    positive("radius", p.radius)?;
    // A circle that nearly touches the square would make needles.
    within("radius", p.radius, 0.0, 0.99)?;
    let [quads, segments] = [p.quads, p.segments].map(f64::from);
    affordable(8.0 * quads * (quads + 1.0) + 2.0 * segments * (2.0 + f64::from(p.rings[0]) + f64::from(p.rings[1])))
}

/// The four free sides of the cube; returns the loops of vertices around the z axis, lowest first.
fn cube_sides(b: &mut Builder, quads: u32) -> Vec<Vec<u32>> {
    let place = |k: u32| 2.0 * f64::from(k) / f64::from(quads) - 1.0;
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
    let side = |k: usize, i: u32| {
        (corners[k] + corners[(k + 1) % 4]) / 2.0 + (corners[(k + 1) % 4] - corners[k]) / 2.0 * place(i)
    };
    let levels: Vec<Vec<u32>> = (0..=quads)
        .map(|j| b.points((0..4).flat_map(|k| (0..quads).map(move |i| side(k, i) + DVec3::Z * place(j)))))
        .collect();
    for (k, (name, normal)) in
        [("side -y", DVec3::NEG_Y), ("side +x", DVec3::X), ("side +y", DVec3::Y), ("side -x", DVec3::NEG_X)]
            .into_iter()
            .enumerate()
    {
        let label = b.shape(name, Shape::Plane { origin: normal, normal });
        let columns = |level: &[u32]| -> Vec<u32> {
            (0..=quads as usize).map(|i| level[(k * quads as usize + i) % level.len()]).collect()
        };
        for pair in levels.windows(2) {
            b.band(label, &columns(&pair[0]), &columns(&pair[1]));
        }
    }
    levels
}

/// Platform, cylinder and end on the upper (0) or the lower (1) side of the cube.
fn pillar(b: &mut Builder, p: &CubeCylinders, square: &[u32], which: usize) {
    let (place, up) = if which == 0 { ("upper", DVec3::Z) } else { ("lower", DVec3::NEG_Z) };
    let y = up.cross(DVec3::X) * p.radius;
    let rings: Vec<Vec<u32>> = (0..=p.rings[which])
        .map(|k| up * (1.0 + p.lengths[which] * f64::from(k) / f64::from(p.rings[which])))
        .map(|centre| b.points(circle(centre, DVec3::X * p.radius, y, p.segments)))
        .collect();
    let platform = b.shape(format!("{place} platform"), Shape::Plane { origin: up, normal: up });
    let wall =
        b.shape(format!("{place} cylinder"), Shape::Cylinder { origin: DVec3::ZERO, axis: DVec3::Z, radius: p.radius });
    let end = b.shape(format!("{place} end"), Shape::Plane { origin: up * (1.0 + p.lengths[which]), normal: up });
    if let (Some(foot), Some(rim)) = (rings.first(), rings.last()) {
        bridge(b, platform, square, foot, y);
        b.rings(wall, &rings);
        zigzag(b, end, rim);
    }
}

/// Joins two loops around the z axis by a strip of triangles: the loop whose next vertex comes first by angle advances.
fn bridge(b: &mut Builder, label: i32, outer: &[u32], inner: &[u32], y: DVec3) {
    let angle = |b: &Builder, v: u32| b.at(v).dot(y).atan2(b.at(v).x * y.length()).rem_euclid(TAU);
    // Both loops from their vertex at the smallest angle, each with its angle.
    let sorted = |loop_: &[u32]| -> Vec<(f64, u32)> {
        let mut out: Vec<(f64, u32)> = loop_.iter().map(|&v| (angle(b, v), v)).collect();
        out.sort_by(|p, q| p.0.total_cmp(&q.0));
        out
    };
    let (outer, inner) = (sorted(outer), sorted(inner));
    let (mut i, mut j) = (0, 0);
    // The angle at step k, counting on past the full turn.
    let reach = |l: &[(f64, u32)], k: usize| l[k % l.len()].0 + TAU * (k / l.len()) as f64;
    while i < outer.len() || j < inner.len() {
        let (o, n) = (outer[i % outer.len()].1, inner[j % inner.len()].1);
        let outer_first = reach(&outer, i + 1) <= reach(&inner, j + 1);
        if j == inner.len() || (i < outer.len() && outer_first) {
            i += 1;
            b.triangle(label, [o, outer[i % outer.len()].1, n]);
        } else {
            j += 1;
            b.triangle(label, [o, inner[j % inner.len()].1, n]);
        }
    }
}

/// Fills a convex ring by one strip across:
///
/// ```text
///    5─4
///   ╱│╲│╲       (0,1,5) (1,4,5) (1,2,4) (2,3,4)
///  0 │ ╲│ 3
///   ╲1──2╱
/// ```
fn zigzag(b: &mut Builder, label: i32, ring: &[u32]) {
    let (mut low, mut high) = (0, ring.len() - 1);
    while high - low > 1 {
        b.triangle(label, [ring[low], ring[low + 1], ring[high]]);
        low += 1;
        if high - low > 1 {
            b.triangle(label, [ring[low], ring[high - 1], ring[high]]);
            high -= 1;
        }
    }
}
