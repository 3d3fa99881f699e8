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

/// The angles around a tip add up to less than a full turn by more than this, in degrees: a drill's tip has 50.
const POINTED_DEG: f64 = 40.0;
/// A vertex goes no farther than this share of the mean of its edges, about half the diagonal of a quad.
const REACH: f64 = 0.75;

/// The vertices where the surface comes to a point, off features.
pub fn tips(mesh: &SurfaceMesh, features: &[[u32; 2]]) -> Vec<DVec3> {
    let mut angle = vec![0.0; mesh.vertex_count()];
    for c in (0..mesh.corner_count()).map(CornerId::new) {
        angle[mesh.vertex(c).index()] += corner_angle(mesh, c);
    }
    features.iter().flatten().for_each(|&v| angle[v as usize] = TAU);
    let is_tip = |&v: &usize| angle[v] > 0.0 && angle[v] < TAU - POINTED_DEG.to_radians();
    (0..angle.len()).filter(is_tip).map(|v| mesh.points()[v]).collect()
}

/// Moves the vertex nearest to each tip there. Returns those moved, and where they were free to move.
pub fn follow(work: &mut Work, around: &Around, source: &Source) -> Vec<(u32, Place)> {
    let tips = &source.tips;
    let tree = TriangleTree::of_segments(tips, (0..tips.len() as u32).map(|t| [t, t]));
    let mut near = Vec::new();
    for (v, place) in (0u32..).zip(&work.place) {
        let from = work.points[v as usize];
        if let Place::Region(_) = place
            && let Some(found) = tree.closest_within(from, REACH * around.mean_edge(work, v))
        {
            near.push((found.distance_squared, v, found.triangle));
        }
    }
    near.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut taken = vec![false; tips.len()];
    let mut held = Vec::new();
    for (_, v, tip) in near {
        if !std::mem::replace(&mut taken[tip as usize], true) {
            held.push((v, work.place[v as usize]));
            work.points[v as usize] = tips[tip as usize];
            work.place[v as usize] = Place::Fixed;
        }
    }
    held
}
