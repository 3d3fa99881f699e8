//! The sides of an edge in the order of their angles about it, and which of them bound one wedge of material.
//!
//! ```text
//!        2 ╲   ╱ 1
//!    B      ╲ ╱      A      the edge is seen along its direction; material lies behind a face, so that
//!            •              every face begins or ends a wedge of it: 0 begins A, 1 ends it; 2 begins B, 3 ends it
//!           ╱ ╲
//!        3 ╱   ╲ 0
//! ```

use super::super::area::area_vector;
use super::super::repair::Soup;
use std::f64::consts::TAU;

/// Faces at angles that differ by less lie on each other, in radians.
const SAME_ANGLE: f64 = 1e-7;

/// A side of the edge.
#[derive(Clone, Copy)]
struct Spoke {
    corner: u32,
    angle: f64,
    /// Material follows in the sense of growing angles.
    begins: bool,
}

/// Pairs the sides of an edge between two vertices; none where their number is odd.
pub(super) fn pairs_around(soup: &Soup, ends: [u32; 2], sides: &[u32], next: &[u32], face_of: &[u32]) -> Vec<[u32; 2]> {
    if sides.len() < 2 || sides.len() % 2 == 1 {
        return Vec::new();
    }
    let mut spokes = spokes(soup, ends, sides, next, face_of);
    spokes.sort_by(|a, b| a.angle.total_cmp(&b.angle).then(a.corner.cmp(&b.corner)));
    level(&mut spokes);
    // What ends at an angle comes before what begins there; of several that end, the last first, as they will be asked for.
    let order = |s: &Spoke| if s.begins { (true, s.corner) } else { (false, u32::MAX - s.corner) };
    spokes.sort_by(|a, b| a.angle.total_cmp(&b.angle).then_with(|| order(a).cmp(&order(b))));
    let begun = spokes.iter().filter(|s| s.begins).count();
    if 2 * begun == spokes.len() { by_sense(&spokes) } else { by_angle(&spokes) }
}

fn spokes(soup: &Soup, ends: [u32; 2], sides: &[u32], next: &[u32], face_of: &[u32]) -> Vec<Spoke> {
    let [a, b] = ends.map(|v| soup.points[v as usize]);
    let along = (b - a).normalize_or_zero();
    let (x, y) = along.any_orthonormal_pair();
    let spoke = |&corner: &u32| {
        let face = soup.faces.face(face_of[corner as usize] as usize);
        let normal = area_vector(&soup.points, face).normalize_or_zero();
        let is_forward = soup.faces.corners()[corner as usize] == ends[0]
            && soup.faces.corners()[next[corner as usize] as usize] == ends[1];
        // The inside of a face is to the left of its half-edges.
        let inward = if is_forward { normal.cross(along) } else { along.cross(normal) };
        Spoke { corner, angle: inward.dot(y).atan2(inward.dot(x)).rem_euclid(TAU), begins: !is_forward }
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
    spokes.sort_by(|a, b| a.angle.total_cmp(&b.angle).then(a.corner.cmp(&b.corner)));
    for k in 1..n {
        if spokes[k].angle - spokes[k - 1].angle < SAME_ANGLE {
            spokes[k].angle = spokes[k - 1].angle;
        }
    }
}

/// As brackets: what ends closes what began last.
fn by_sense(spokes: &[Spoke]) -> Vec<[u32; 2]> {
    let n = spokes.len();
    // From where on never more has ended than begun.
    let (mut sum, mut least, mut start) = (0i64, 0i64, 0);
    for (k, spoke) in spokes.iter().enumerate() {
        sum += if spoke.begins { 1 } else { -1 };
        if sum < least {
            (least, start) = (sum, k + 1);
        }
    }
    let (mut open, mut pairs) = (Vec::new(), Vec::new());
    for spoke in (0..n).map(|k| &spokes[(start + k) % n]) {
        if spoke.begins {
            open.push(spoke.corner);
        } else if let Some(first) = open.pop() {
            pairs.push([first.min(spoke.corner), first.max(spoke.corner)]);
        }
    }
    pairs
}

/// Neighbours, in the one of the two ways that has the smaller wedges; faces on each other make none.
fn by_angle(spokes: &[Spoke]) -> Vec<[u32; 2]> {
    let n = spokes.len();
    let wedge = |k: usize| {
        let angle = (spokes[(k + 1) % n].angle - spokes[k % n].angle).rem_euclid(TAU);
        if angle < SAME_ANGLE { TAU } else { angle }
    };
    let sum = |first: usize| (0..n / 2).map(|k| wedge(first + 2 * k)).sum::<f64>();
    let first = usize::from(sum(1) < sum(0) - SAME_ANGLE);
    (0..n / 2).map(|k| [spokes[(first + 2 * k) % n].corner, spokes[(first + 2 * k + 1) % n].corner]).collect()
}
