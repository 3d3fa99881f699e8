//! Finds the flat ends of closed tubes among the plane pieces of the surface: those at which a branch of the skeleton
//! ends.
//!
//! ```text
//!   ┌─────────────┐
//!   │ ──•──•──•   │←  the branch heads for the middle of the plane piece, which is as wide as the branch, and the
//!   └─────────────┘   room behind it is as deep as it is wide: no side of a plate
//! ```

use super::target::Target;
use super::tips::heading;
use crate::error::Result;
use crate::mesh::CurveNet;
use crate::skeleton::{Closed, Lid, flat_ends};

/// Least cosine between the heading of a branch and the normal of an end.
const HEADS: f64 = 0.6;
/// Largest distance, in radii, by which a branch ends before a flat end: the flow draws tips in.
const BEFORE: f64 = 4.0;
/// Largest distance, in radii, by which a branch ends beside the axis of a flat end.
const BESIDE: f64 = 0.6;
/// An end is at least this wide, in radii of the branch.
const WIDE: f64 = 0.6;
/// The room behind an end is at least this deep, in its radii.
const DEEP: f64 = 1.0;

/// The surface with lids at those plane pieces where a branch of the skeleton ends.
pub fn told_apart(closed: Closed, net: &CurveNet) -> Result<Closed> {
    let candidates = flat_ends::candidates(&closed);
    if candidates.is_empty() {
        return Ok(closed);
    }
    let target = Target::new(&closed);
    let mut net = net.clone();
    net.radii = net.points.iter().map(|&p| target.distance(p)).collect();
    let around = net.incidence();
    let mut free: Vec<u32> = around.tips().collect();
    let mut ends = Vec::new();
    for (lid, triangles) in candidates {
        let inside = lid.centre - lid.normal * (1e-3 * lid.radius);
        if target.leaves(inside, -lid.normal).is_none_or(|depth| depth < DEEP * lid.radius) {
            continue;
        }
        let offset = |v: u32| net.points[v as usize].distance_squared(lid.centre);
        let meets = |&v: &u32| is_met(&lid, &net, v, heading(&net, &around, v));
        let tip = free.iter().copied().filter(meets).min_by(|&a, &b| offset(a).total_cmp(&offset(b)));
        if let Some(tip) = tip {
            free.retain(|&v| v != tip);
            ends.push((lid, triangles));
        }
    }
    drop(target);
    if ends.is_empty() { Ok(closed) } else { flat_ends::with_lids(closed, ends) }
}

fn is_met(lid: &Lid, net: &CurveNet, tip: u32, (direction, radius): (glam::DVec3, f64)) -> bool {
    let to = lid.centre - net.points[tip as usize];
    let ahead = to.dot(lid.normal);
    let beside = (to - lid.normal * ahead).length();
    direction.dot(lid.normal) > HEADS
        && (-0.1 * lid.radius..BEFORE * lid.radius).contains(&ahead)
        && beside < BESIDE * lid.radius
        && lid.radius > WIDE * radius
}
