//! Sections across a limb.

use super::body::Body;
use crate::geometry::search_tree::TriangleTree;
use glam::DVec3;

/// Number of rays across a branch.
pub const MIDDLE_RAYS: usize = 24;
/// Rounds of moving to the middle of what the rays meet.
pub const MIDDLES: usize = 4;
/// Longest ray over the shortest in a round section: more than in one with eight sides, less than in a square.
pub const ROUND_SECTION: f64 = 1.2;

/// Points at which each segment of a new branch must be inside.
pub const SAMPLES: usize = 8;

/// Number of directions in which a section is measured.
pub const SECTION_RAYS: usize = 16;

/// Least room along the way to that node, as a share of the room at its ends.
pub const ROOM: f64 = 0.35;

/// The radius of a circle as large as the section of the body across a direction, as far as it is seen from a point.
pub fn section(p: DVec3, direction: DVec3, body: &Body) -> f64 {
    let Some(tangent) = direction.try_normalize() else { return f64::INFINITY };
    let (u, v) = tangent.any_orthonormal_pair();
    let square = |k: usize| {
        let (sin, cos) = (k as f64 * std::f64::consts::TAU / SECTION_RAYS as f64).sin_cos();
        body.tree.first_hit(p, u * cos + v * sin).map_or(f64::INFINITY, |hit| hit.t * hit.t)
    };
    ((0..SECTION_RAYS).map(square).sum::<f64>() / SECTION_RAYS as f64).sqrt()
}

/// The least room on the way between two points; zero where it leaves the body.
pub fn room(from: DVec3, to: DVec3, body: &Body) -> f64 {
    let at = |k: usize| from.lerp(to, k as f64 / SAMPLES as f64);
    let room = |p: DVec3| if body.inside.contains(p) { body.tree.distance(p) } else { 0.0 };
    (0..=SAMPLES).map(|k| room(at(k))).fold(f64::INFINITY, f64::min)
}

/// The middle of the section across a direction, where that is round: seen from beside the middle of a circle, by d, rays in a
/// direction e are about e · d shorter. Elsewhere the point itself.
pub fn middle_of_section(p: DVec3, along: DVec3, tree: &TriangleTree) -> DVec3 {
    let (u, v) = along.any_orthonormal_pair();
    let mut middle = p;
    for round in 0..=MIDDLES {
        let (mut sum, mut least, mut most) = (DVec3::ZERO, f64::INFINITY, 0f64);
        for k in 0..MIDDLE_RAYS {
            let (sin, cos) = (k as f64 * std::f64::consts::TAU / MIDDLE_RAYS as f64).sin_cos();
            let ray = u * cos + v * sin;
            let Some(hit) = tree.first_hit(middle, ray) else { return p };
            sum += ray * hit.t;
            (least, most) = (least.min(hit.t), most.max(hit.t));
        }
        if round == MIDDLES {
            return if most < ROUND_SECTION * least { middle } else { p };
        }
        middle += sum * (2.0 / MIDDLE_RAYS as f64);
    }
    p
}

/// Whether the section across a direction is round about a point.
pub fn is_round(p: DVec3, along: DVec3, tree: &TriangleTree) -> bool {
    let (u, v) = along.any_orthonormal_pair();
    let (mut least, mut most) = (f64::INFINITY, 0f64);
    for k in 0..MIDDLE_RAYS {
        let (sin, cos) = (k as f64 * std::f64::consts::TAU / MIDDLE_RAYS as f64).sin_cos();
        let far = tree.first_hit(p, u * cos + v * sin).map_or(f64::INFINITY, |hit| hit.t);
        (least, most) = (least.min(far), most.max(far));
    }
    most < ROUND_SECTION * least
}
