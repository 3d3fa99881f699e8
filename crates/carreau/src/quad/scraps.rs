//! Creases of a scan that leave no room: where they enclose a piece of the surface that is smaller than a quad, those between it
//! and the neighbour with which it shares most of them are no features of quads.
//!
//! ```text
//!      ╲   ╱‾‾╲   ╱            ╲   ╱‾‾╲   ╱
//!   A   ╲_╱ p  ╲_╱      →       ╲_╱    ╲_╱       p is a part of B then
//!         ╲____╱   B                      B
//! ```
//!
//! On parts every feature stays, however little room there is.

use crate::geometry::features::FeaturedSurface;
use crate::mesh::{CornerId, DisjointSets, SurfaceMesh, VertexId, area_vector};
use rustc_hash::FxHashSet;
use std::collections::BTreeMap;

/// A share of the area of a quad: pieces that are smaller leave no room for one.
const LEAST_PIECE: f64 = 0.5;

/// Drops creases around pieces of the surface that are too small for quads with edges of a length, until there are none.
pub fn drop_around_scraps(surface: &mut FeaturedSurface, length: f64) {
    let least = LEAST_PIECE * length * length;
    loop {
        let dropped = around_scraps(&surface.mesh, &surface.features.corners, least);
        if dropped.is_empty() {
            return;
        }
        let ends = |c: CornerId| [c, surface.mesh.next(c)].map(|c| surface.mesh.vertex(c));
        let gone: FxHashSet<[VertexId; 2]> = dropped.iter().map(|&c| ends(c)).collect();
        surface.mesh.tagged_edges.retain(|e| !gone.contains(&e.ends) && !gone.contains(&[e.ends[1], e.ends[0]]));
        dropped.into_iter().for_each(|c| surface.features.corners[c.index()] = false);
    }
}

/// The half-edges of features between scraps and the neighbours with which they share most.
fn around_scraps(mesh: &SurfaceMesh, is_feature: &[bool], least: f64) -> Vec<CornerId> {
    let corners = || (0..mesh.corner_count()).map(CornerId::new);
    let mut sets = DisjointSets::new(mesh.face_count());
    for c in corners().filter(|c| !is_feature[c.index()]) {
        if let Some(o) = mesh.opposite(c) {
            sets.union(mesh.face_of(c).0, mesh.face_of(o).0);
        }
    }
    let (piece, count) = sets.labels();
    let mut area = vec![0.0; count];
    for (face, &piece) in mesh.faces().iter().zip(&piece) {
        area[piece as usize] += area_vector(mesh.points(), face).length();
    }
    let across = |c: CornerId| {
        let of = |c: CornerId| piece[mesh.face_of(c).index()];
        mesh.opposite(c).map(|o| [of(c), of(o)]).filter(|[own, other]| own != other)
    };
    let mut shared: BTreeMap<[u32; 2], f64> = BTreeMap::new();
    for c in corners().filter(|c| is_feature[c.index()]) {
        let Some(pair) = across(c).filter(|pair| area[pair[0] as usize] < least) else { continue };
        let ends = [c, mesh.next(c)].map(|c| mesh.point(mesh.vertex(c)));
        *shared.entry(pair).or_default() += ends[0].distance(ends[1]);
    }
    let mut most: BTreeMap<u32, (f64, u32)> = BTreeMap::new();
    for ([scrap, other], length) in shared {
        let best = most.entry(scrap).or_insert((length, other));
        if length > best.0 {
            *best = (length, other);
        }
    }
    let goes = |[own, other]: [u32; 2]| most.get(&own).is_some_and(|best| best.1 == other);
    let is_dropped = |c: &CornerId| {
        is_feature[c.index()] && across(*c).is_some_and(|[own, other]| goes([own, other]) || goes([other, own]))
    };
    corners().filter(is_dropped).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::context::Context;
    use crate::geometry::features::FeatureOptions;
    use crate::mesh::{Polygons, TaggedEdge};
    use glam::DVec3;

    /// A flat grid of four by four squares; the edges around one of them are tagged, and a row across the grid.
    fn plate() -> FeaturedSurface {
        let points = (0..5).flat_map(|j| (0..5).map(move |i| DVec3::new(f64::from(i), f64::from(j), 0.0))).collect();
        let mut faces = Polygons::new();
        for v in (0..4).flat_map(|j| (0..4).map(move |i| 5 * j + i)) {
            faces.push(&[v, v + 1, v + 6]);
            faces.push(&[v, v + 6, v + 5]);
        }
        let mut mesh = SurfaceMesh::new(points, faces).unwrap();
        let edges = [[6, 7], [7, 12], [12, 11], [11, 6], [15, 16], [16, 17], [17, 18], [18, 19]];
        mesh.tagged_edges = edges.iter().map(|e| TaggedEdge { ends: e.map(VertexId), tag: 1 }).collect();
        FeaturedSurface::new(&mesh, &FeatureOptions::default(), &Context::new()).unwrap()
    }

    #[test]
    fn pieces_without_room_for_a_quad_go_and_no_others() {
        let inner = |surface: &FeaturedSurface| surface.mesh.tagged_edges.len();
        let (mut small, mut large) = (plate(), plate());
        let all = inner(&small);
        // A square is half a quad of this length, and a little more, or less.
        drop_around_scraps(&mut small, 1.4);
        assert_eq!(inner(&small), all);
        drop_around_scraps(&mut large, 1.5);
        assert_eq!(inner(&large), all - 4);
        let kept = large.features.edges(&large.mesh).count();
        assert_eq!(kept, small.features.edges(&small.mesh).count() - 4);
    }
}
