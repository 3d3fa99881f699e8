//! The sides of an edge in the order of their angles about it, and which of them bound one wedge of material.
//!
//! ```text
//!        2 ╲   ╱ 1
//!    B      ╲ ╱      A      the edge is seen along its direction; material lies behind a face, so that
//!            •              every face begins or ends a wedge of it: 0 begins A, 1 ends it; 2 begins B, 3 ends it
//!           ╱ ╲
//!        3 ╱   ╲ 0
//! ```
//!
//! Bodies do not overlap: what begins is ended by the next one. Where that does not hold, for bodies that are inside out it holds
//! with beginnings and ends exchanged; else the smaller wedges tell.

use super::super::area::area_vector;
use super::sides::Sides;
use std::f64::consts::TAU;

/// Faces at angles that differ by less lie on each other, in radians.
const SAME_ANGLE: f64 = 1e-7;

/// A side of the edge.
#[derive(Clone, Copy)]
struct Spoke {
    corner: u32,
    face: u32,
    angle: f64,
    /// Material follows in the sense of growing angles.
    begins: bool,
}

/// Pairs the sides of an edge, given from its lower end to the other; none where their number is odd.
pub(super) fn pairs_around(at: &Sides, ends: [u32; 2], sides: &[u32]) -> Vec<[u32; 2]> {
    if sides.len() < 2 || sides.len() % 2 == 1 {
        return Vec::new();
    }
    let mut spokes = spokes(at, ends, sides);
    spokes.sort_by(|a, b| a.angle.total_cmp(&b.angle).then(a.face.cmp(&b.face)));
    level(&mut spokes);
    by_sense(&spokes, false).or_else(|| by_sense(&spokes, true)).unwrap_or_else(|| by_angle(&spokes))
}

fn spokes(at: &Sides, ends: [u32; 2], sides: &[u32]) -> Vec<Spoke> {
    let soup = at.soup;
    let [a, b] = ends.map(|v| soup.points[v as usize]);
    let along = (b - a).normalize_or_zero();
    let (x, y) = along.any_orthonormal_pair();
    let spoke = |&corner: &u32| {
        let face = at.face_of[corner as usize];
        let normal = area_vector(&soup.points, soup.faces.face(face as usize)).normalize_or_zero();
        let is_along = soup.faces.corners()[corner as usize] == ends[0];
        // The inside of a face is to the left of its half-edges.
        let inward = if is_along { normal.cross(along) } else { along.cross(normal) };
        Spoke { corner, face, angle: inward.dot(y).atan2(inward.dot(x)).rem_euclid(TAU), begins: !is_along }
    };
    sides.iter().map(spoke).collect()
}

/// Angles that are the same but for rounding become the same; the circle begins after a gap.
fn level(spokes: &mut [Spoke]) {
    let n = spokes.len();
    let gap = |k: usize| (spokes[k].angle - spokes[(k + n - 1) % n].angle).rem_euclid(TAU);
    let widest = (0..n).fold(0, |best, k| if gap(k) > gap(best) + SAME_ANGLE { k } else { best });
    let start = spokes[widest].angle - SAME_ANGLE;
    for spoke in spokes.iter_mut() {
        spoke.angle = (spoke.angle - start).rem_euclid(TAU);
    }
    spokes.sort_by(|a, b| a.angle.total_cmp(&b.angle).then(a.face.cmp(&b.face)));
    for k in 1..n {
        if spokes[k].angle - spokes[k - 1].angle < SAME_ANGLE {
            spokes[k].angle = spokes[k - 1].angle;
        }
    }
    spokes.sort_by(|a, b| a.angle.total_cmp(&b.angle).then(a.face.cmp(&b.face)));
}

/// What begins with what ends it, where both alternate; at one angle ends come before beginnings.
fn by_sense(spokes: &[Spoke], inside_out: bool) -> Option<Vec<[u32; 2]>> {
    let n = spokes.len();
    let begins = |s: &Spoke| s.begins != inside_out;
    let mut sorted = spokes.to_vec();
    // Of several at one angle those that end alternate with those that begin.
    sorted.sort_by(|a, b| a.angle.total_cmp(&b.angle).then((begins(a), a.face).cmp(&(begins(b), b.face))));
    let alternate = (0..n).all(|k| begins(&sorted[k]) != begins(&sorted[(k + 1) % n]));
    let first = usize::from(!begins(&sorted[0]));
    alternate.then(|| pairs_from(&sorted, first))
}

/// Neighbours, in the one of the two ways that has the smaller wedges; faces on each other make none.
fn by_angle(spokes: &[Spoke]) -> Vec<[u32; 2]> {
    let n = spokes.len();
    let wedge = |k: usize| {
        let angle = (spokes[(k + 1) % n].angle - spokes[k % n].angle).rem_euclid(TAU);
        if angle < SAME_ANGLE { TAU } else { angle }
    };
    let sum = |first: usize| (0..n / 2).map(|k| wedge(first + 2 * k)).sum::<f64>();
    pairs_from(spokes, usize::from(sum(1) < sum(0) - SAME_ANGLE))
}

/// Every second side with the one after it.
fn pairs_from(spokes: &[Spoke], first: usize) -> Vec<[u32; 2]> {
    let n = spokes.len();
    (0..n / 2).map(|k| [spokes[(first + 2 * k) % n].corner, spokes[(first + 2 * k + 1) % n].corner]).collect()
}
