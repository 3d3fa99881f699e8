//! Ridges that fade out: where one ends in the middle of a face because its angle falls below the limit, the crease goes on.
//!
//! ```text
//!     ═══════•───────•───────•- - - -•        ═ ridge, above the limit
//!           40°     30°     20°     10°       ─ crease, followed to FADED of it
//! ```
//!
//! An edge across such a crease is off by as much as one across a ridge. The crease is therefore a curve, too, though no
//! dihedral angle on it is held.

use super::curves::{Kind, Marks};
use crate::error::Result;
use crate::geometry::features::{FeatureOptions, feature_edges};
use crate::geometry::normals::angle_between;
use crate::mesh::{CornerId, SurfaceMesh};

/// A crease is followed as long as its angle is above this share of the limit.
const FADED: f64 = 0.3;
/// It turns by less than this from edge to edge, in degrees.
const TURN_DEG: f64 = 40.0;

/// Marks the creases that continue ridges above `angle_deg` from their loose ends, but for half-edges that may bend.
pub fn follow(
    mesh: &SurfaceMesh,
    marks: &mut Marks,
    angle_deg: f64,
    may_bend: impl Fn(CornerId) -> bool,
) -> Result<()> {
    let bent =
        FeatureOptions { angle_deg: Some(FADED * angle_deg), borders: false, tags: false, ..FeatureOptions::default() };
    let bent = feature_edges(mesh, &bent)?;
    let ends = |c: CornerId| [mesh.vertex(c), mesh.vertex(mesh.next(c))].map(|v| v.index());
    // Curve edges and those that may become some, by vertex.
    let mut at_vertex: Vec<(usize, CornerId)> = Vec::new();
    let mut degree = vec![0u32; mesh.vertex_count()];
    for c in (0..mesh.corner_count()).map(CornerId::new).filter(|&c| mesh.opposite(c).is_none_or(|o| c < o)) {
        let marked = marks[c.index()].is_some();
        if marked || (bent.contains(c) && !may_bend(c)) {
            at_vertex.extend(ends(c).map(|v| (v, c)));
            ends(c).iter().for_each(|&v| degree[v] += u32::from(marked));
        }
    }
    at_vertex.sort_unstable();
    let around = |v: usize| {
        let first = at_vertex.partition_point(|e| e.0 < v);
        at_vertex[first..].iter().take_while(move |e| e.0 == v).map(|e| e.1)
    };
    let other = |c: CornerId, v: usize| ends(c).into_iter().find(|&w| w != v).unwrap_or(v);
    let p = |v: usize| mesh.points()[v];
    let loose: Vec<usize> = (0..degree.len()).filter(|&v| degree[v] == 1).collect();
    for end in loose {
        let Some(ridge) = around(end).find(|c| marks[c.index()].is_some()) else { continue };
        let (mut before, mut at) = (other(ridge, end), end);
        while degree[at] == 1 {
            let turn = |c: &CornerId| angle_between(p(at) - p(before), p(other(*c, at)) - p(at));
            let onward = around(at).filter(|c| marks[c.index()].is_none());
            let straightest = onward.min_by(|a, b| turn(a).total_cmp(&turn(b)));
            let Some(c) = straightest.filter(|c| turn(c) < TURN_DEG.to_radians()) else { break };
            for side in [Some(c), mesh.opposite(c)].into_iter().flatten() {
                marks[side.index()] = Some(Kind::Crease);
            }
            ends(c).iter().for_each(|&v| degree[v] += 1);
            (before, at) = (at, other(c, at));
        }
    }
    Ok(())
}
