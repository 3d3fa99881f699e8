//! Vertices inside regions go to where the surface comes to a point: the tips of cones.
//!
//! No quad can have one inside without cutting it off:
//!
//! ```text
//!      ╱╲            v
//!    v────v    →    ╱ ╲
//!   ╱      ╲       ╱   v
//! ```

use super::around::Around;
use super::source::Source;
use super::work::{Place, Work};
use crate::geometry::normals::corner_angle;
use crate::geometry::search_tree::TriangleTree;
use crate::mesh::{CornerId, SurfaceMesh};
use glam::DVec3;
use std::f64::consts::TAU;

/// Degrees: the angles around a tip add up to less than a full turn by more than this, because flatter ones are hardly
/// cut off; a drill's tip has 50.
const POINTED_DEG: f64 = 40.0;
/// Degrees: the angles around a tip add up to more than this, because quads would be too narrow at a sharper one.
const SHARP_DEG: f64 = 25.0;
/// Degrees: where they add up to less only a vertex of three quads goes there, as the field wants it, because others
/// would have narrower quads still.
const NARROW_DEG: f64 = 120.0;
/// A share of the mean edge: a vertex goes no farther, more than half the diagonal of a quad because a tip may be in
/// the middle of one.
const TIP_REACH: f64 = 1.0;

/// Where the surface comes to a point.
#[derive(Debug, Clone, Copy)]
pub struct Tip {
    point: DVec3,
    is_narrow: bool,
}

/// The vertices where the surface comes to a point, off features.
pub fn tips(mesh: &SurfaceMesh, features: &[[u32; 2]]) -> Vec<Tip> {
    let mut angle = vec![0.0; mesh.vertex_count()];
    for c in (0..mesh.corner_count()).map(CornerId::new) {
        angle[mesh.vertex(c).index()] += corner_angle(mesh, c);
    }
    features.iter().flatten().for_each(|&v| angle[v as usize] = TAU);
    let range = SHARP_DEG.to_radians()..TAU - POINTED_DEG.to_radians();
    let is_tip = |v: &usize| range.contains(&angle[*v]);
    let tip = |v: usize| Tip { point: mesh.points()[v], is_narrow: angle[v] < NARROW_DEG.to_radians() };
    (0..angle.len()).filter(is_tip).map(tip).collect()
}

/// Moves the vertex nearest to each tip there, where it stays.
pub fn follow(work: &mut Work, around: &mut Around, source: &Source) {
    let tips = &source.tips;
    let points: Vec<DVec3> = tips.iter().map(|tip| tip.point).collect();
    let tree = TriangleTree::of_segments(&points, (0..tips.len() as u32).map(|t| [t, t]));
    let mut near = Vec::new();
    for (v, place) in (0u32..).zip(&work.place) {
        let from = work.points[v as usize];
        if let Place::Region(_) = place
            && let Some(found) = tree.closest_within(from, TIP_REACH * around.mean_edge(work, v))
            && (!tips[found.triangle as usize].is_narrow || around.quads[v as usize].len() == 3)
        {
            near.push((found.distance_squared, v, found.triangle));
        }
    }
    near.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut taken = vec![false; tips.len()];
    for (_, v, tip) in near {
        if !std::mem::replace(&mut taken[tip as usize], true) {
            work.points[v as usize] = points[tip as usize];
            work.place[v as usize] = Place::Fixed;
        }
    }
    if taken.contains(&true) {
        around.set_ceilings(work);
    }
}
