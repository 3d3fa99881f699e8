//! Directions that a field is drawn to beside its features: guides, and the directions of curvature.
//!
//! ```text
//!      ·  guide  ·              the edges of triangles around say how the surface bends: across an edge by its angle β,
//!    ──┼─────────┼──  e^{4iα}   T = Σ β |e| (ê × n)(ê × n)ᵀ / Σ area; its axes are the directions of curvature, and
//!      ·         ·              ((T₁₁ − T₂₂) / 2 + i T₁₂)² is e^{4iα} (κ₁ − κ₂)² / 4
//! ```
//!
//! A direction weighs as much as the smoothness across an edge of weight 1, times its own weight (Knöppel, Crane, Pinkall,
//! Schröder: *Globally optimal direction fields*, 2013, section 3.4; the tensor: Cohen-Steiner, Morvan, 2003).

use super::dual::Dual;
use crate::geometry::search_tree::TriangleTree;
use crate::numeric::eigen3::outer;
use crate::numeric::sparse::Complex;
use glam::{DMat3, DVec3};

/// Weight of a guide: well above that of the smoothness, because a guide is what somebody has drawn.
const GUIDE_WEIGHT: f64 = 20.0;
/// A share of an edge: two places of a guide are no farther apart, so that no triangle below is left out.
const GUIDE_STEP: f64 = 0.3;
/// A count of edges: a guide says nothing of a surface that is farther from it.
const GUIDE_REACH: f64 = 2.0;
/// A count: rings of triangles whose edges say how the surface bends, because a single one is as rough as the triangles.
const CURVATURE_RINGS: usize = 2;
/// Weight of directions of curvature at most: that of the smoothness, because folds of a scan are as bent as they are rough.
const MOST_CURVATURE: f64 = 1.0;

/// The triangles below guides, segments near a surface, with where these lead there; one comes as often as a place is above it.
/// `edge`: how long an edge is on which guides are to tell.
pub fn below_guides(points: &[DVec3], triangles: &[[u32; 3]], guides: &[[DVec3; 2]], edge: f64) -> Vec<(u32, DVec3)> {
    if guides.is_empty() {
        return Vec::new();
    }
    let tree = TriangleTree::new(points, triangles);
    let mut found = Vec::new();
    for ends in guides {
        let along = ends[1] - ends[0];
        let steps = (along.length() / (GUIDE_STEP * edge)).ceil().max(1.0);
        let at = (0..steps as usize).map(|k| ends[0] + along * ((k as f64 + 0.5) / steps));
        let below = at.filter_map(|at| tree.closest_within(at, GUIDE_REACH * edge));
        found.extend(below.map(|found| (found.triangle, along)));
    }
    found
}

/// Adds what guides ask for.
pub fn to_guides(dual: &mut Dual<'_>, guides: &[[DVec3; 2]]) {
    let t = dual.triangles;
    let corners: Vec<[u32; 3]> = (0..t.len() as u32).map(|i| t.triangle(i)).collect();
    let mut asked = vec![Complex::new(0.0, 0.0); t.len()];
    let edge = (2.0 * dual.areas.iter().sum::<f64>() / t.len().max(1) as f64).sqrt();
    for (i, along) in below_guides(t.points(), &corners, guides, edge) {
        let i = i as usize;
        asked[i] += of_angle(along.dot(dual.y[i]).atan2(along.dot(dual.x[i])), along.length());
    }
    for (wanted, asked) in dual.wanted.iter_mut().zip(asked) {
        let size = asked.re.hypot(asked.im);
        if size > 0.0 {
            *wanted = asked * (GUIDE_WEIGHT / size);
        }
    }
}

/// Adds the directions of curvature, with a weight.
pub fn to_curvature(dual: &mut Dual<'_>, weight: f64) {
    let count = dual.triangles.len();
    let (mut tensors, mut areas) = (vec![DMat3::ZERO; count], dual.areas.clone());
    for e in 0..dual.edges.len() {
        let bend = bend(dual, e);
        dual.ends(e).iter().for_each(|&i| tensors[i as usize] += bend * 0.5);
    }
    for _ in 0..CURVATURE_RINGS {
        let (inner, inner_areas) = (tensors.clone(), areas.clone());
        for e in 0..dual.edges.len() {
            let [i, j] = dual.ends(e).map(|t| t as usize);
            tensors[i] += inner[j];
            tensors[j] += inner[i];
            areas[i] += inner_areas[j];
            areas[j] += inner_areas[i];
        }
    }
    for i in 0..count {
        let (x, y) = (dual.x[i], dual.y[i]);
        let of = |a: DVec3, b: DVec3| a.dot(tensors[i] * b) / areas[i].max(f64::MIN_POSITIVE);
        let (re, im) = (of(x, x) - of(y, y), 2.0 * of(x, y));
        // |z| = (κ₁ − κ₂)²
        let z = Complex::new(re * re - im * im, 2.0 * re * im);
        let (size, scale) = (z.re.hypot(z.im), weight * dual.areas[i]);
        if size > 0.0 && (size * scale).is_finite() {
            dual.wanted[i] += z * (scale.min(MOST_CURVATURE / size));
        }
    }
}

/// What an edge says of how the surface bends.
fn bend(dual: &Dual<'_>, e: usize) -> DMat3 {
    let [i, j] = dual.ends(e).map(|t| dual.x[t as usize].cross(dual.y[t as usize]));
    let t = dual.triangles;
    let along = t.point(t.next(dual.edges[e])) - t.point(dual.edges[e]);
    let Some(way) = along.try_normalize() else { return DMat3::ZERO };
    let angle = i.cross(j).dot(way).atan2(i.dot(j));
    let across = way.cross(i + j).normalize_or_zero();
    outer(across) * (angle * along.length())
}

fn of_angle(angle: f64, weight: f64) -> Complex {
    let (sin, cos) = (4.0 * angle).sin_cos();
    Complex::new(weight * cos, weight * sin)
}
