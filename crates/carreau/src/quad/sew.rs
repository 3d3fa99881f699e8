//! Borders that lie on each other, as in a part that was exported face by face: sewn, so that the quads of both sides agree, and
//! cut apart again when these are made.
//!
//! ```text
//!    ╲  │  ╱             ╲  │  ╱  quads        ╲  │  ╱
//!   ══•═•═•══   →sewn   ──•──•──•──     →cut  ══•══•══•══
//!    ╱  │  ╲             ╱  │  ╲               ╱  │  ╲
//! ```

use super::junction::{EdgePlace, edge_place, shared_borders};
use super::source::ends;
use super::work::Work;
use crate::error::Result;
use crate::mesh::connectivity::{copies_of_edge, umbrellas, vertices_of_umbrellas};
use crate::mesh::topology::irregular_vertices;
use crate::mesh::{CornerId, DisjointSets, HalfEdges, Side, SurfaceMesh, TaggedEdge, VertexId};
use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

/// A count: rounds in which what would not be manifold is left open, because each may leave others that are not.
const SEW_ROUNDS: usize = 8;

/// The mesh with every border edge sewn to the one that lies on it, where there is just one and it runs the other way, and where
/// the surface stays manifold; with the places of these edges. `None` where there are none.
pub fn sewn(mesh: &SurfaceMesh) -> Result<Option<(SurfaceMesh, FxHashSet<EdgePlace>)>> {
    let mut pairs = pairs(mesh);
    for _ in 0..SEW_ROUNDS {
        if pairs.is_empty() {
            break;
        }
        let (next, number) = joined(mesh, &pairs)?;
        let open = irregular_vertices(&next);
        if !open.contains(&true) {
            // Where the ends of two others came together, they are sewn, too.
            let corners = (0..mesh.corner_count()).map(CornerId::new);
            let closed = corners.filter(|&c| mesh.side(c) == Side::Border && next.side(c) != Side::Border);
            let places = closed.map(|c| edge_place(mesh, c)).collect();
            return Ok(Some((next, places)));
        }
        pairs.retain(|pair| ends(mesh, pair[0]).iter().all(|&v| !open[number[v as usize] as usize]));
    }
    Ok(None)
}

/// The border edges, two by two, that lie on each other and run against each other.
fn pairs(mesh: &SurfaceMesh) -> Vec<[CornerId; 2]> {
    let mut at: FxHashMap<EdgePlace, Vec<CornerId>> = FxHashMap::default();
    let shared = shared_borders(mesh);
    shared.iter().for_each(|&c| at.entry(edge_place(mesh, c)).or_default().push(c));
    let start = |c: CornerId| mesh.point(mesh.vertex(c));
    let of = |&c: &CornerId| match at[&edge_place(mesh, c)][..] {
        [a, b] if a == c && start(a) != start(b) => Some([a, b]),
        _ => None,
    };
    shared.iter().filter_map(of).collect()
}

/// The mesh with these edges in one, and the number of every vertex in it.
fn joined(mesh: &SurfaceMesh, pairs: &[[CornerId; 2]]) -> Result<(SurfaceMesh, Vec<u32>)> {
    let mut sets = DisjointSets::new(mesh.vertex_count());
    for [[a, b], [c, d]] in pairs.iter().map(|pair| pair.map(|c| ends(mesh, c))) {
        sets.union(a, d);
        sets.union(b, c);
    }
    let (number, count) = sets.labels();
    let mut points = vec![DVec3::ZERO; count];
    number.iter().zip(mesh.points()).for_each(|(&n, &p)| points[n as usize] = p);
    let mut faces = mesh.faces().clone();
    faces.corners_mut().iter_mut().for_each(|v| *v = number[*v as usize]);
    let mut next = SurfaceMesh::new(points, faces)?;
    let mut known = FxHashSet::default();
    let renamed = |edge: &TaggedEdge| TaggedEdge { ends: edge.ends.map(|v| VertexId(number[v.index()])), ..*edge };
    let is_new = |edge: &TaggedEdge| known.insert([edge.ends[0].min(edge.ends[1]), edge.ends[0].max(edge.ends[1])]);
    next.tagged_edges = mesh.tagged_edges.iter().map(renamed).filter(is_new).collect();
    Ok((next, number))
}

/// Cuts quads open along features.
pub fn cut_open(work: &mut Work, is_cut: impl Fn(u32) -> bool) {
    let half_edges = HalfEdges::new(&work.faces, work.points.len());
    let cut: FxHashSet<[u32; 2]> = work.features.iter().filter(|f| is_cut(f.1)).map(|f| in_order(f.0)).collect();
    let whole = vec![false; work.faces.len()];
    let umbrella = umbrellas(&work.faces, &half_edges, &whole, |edge, _| !cut.contains(&edge.ends));
    let (number, copied) = vertices_of_umbrellas(&work.faces, &umbrella, &whole, work.points.len());
    for &v in &copied {
        work.points.push(work.points[v as usize]);
        work.place.push(work.place[v as usize]);
    }
    let next = work.faces.next_corners();
    let copies = |ends: [u32; 2]| copies_of_edge(ends, &half_edges, &number, &next).unwrap_or_default();
    let of_feature = |&(ends, curve): &([u32; 2], u32)| copies(ends).into_iter().map(move |ends| (ends, curve));
    work.features = work.features.iter().flat_map(of_feature).collect();
    work.faces.corners_mut().copy_from_slice(&number);
}

fn in_order([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

#[cfg(test)]
mod tests {
    use super::super::work::Place;
    use super::*;
    use crate::mesh::test_models::{cube, strip, triangles};
    use crate::mesh::{Polygons, Topology};

    /// Every face by itself.
    fn exploded(mesh: &SurfaceMesh) -> SurfaceMesh {
        let points = mesh.faces().corners().iter().map(|&v| mesh.points()[v as usize]).collect();
        let mut faces = Polygons::new();
        let mut corners = 0..;
        mesh.faces().iter().for_each(|face| faces.push_iter(corners.by_ref().take(face.len())));
        SurfaceMesh::new(points, faces).unwrap()
    }

    /// The quads of a mesh with features where it was sewn.
    fn work_of(mesh: &SurfaceMesh, places: &FxHashSet<EdgePlace>) -> Work {
        let corners = (0..mesh.corner_count()).map(CornerId::new);
        let sewn = corners.filter(|&c| places.contains(&edge_place(mesh, c)));
        let mut features: Vec<([u32; 2], u32)> = sewn.map(|c| (in_order(ends(mesh, c)), 7)).collect();
        features.sort_unstable();
        features.dedup();
        Work {
            points: mesh.points().to_vec(),
            place: vec![Place::Fixed; mesh.vertex_count()],
            faces: mesh.faces().clone(),
            region: vec![0; mesh.face_count()],
            features,
        }
    }

    fn counts(mesh: &SurfaceMesh) -> (usize, i64, usize, usize) {
        let t = Topology::of(mesh);
        (t.components, t.euler, t.boundary_loops, t.vertices)
    }

    #[test]
    fn what_is_sewn_and_cut_is_as_it_was() {
        for (whole, edges) in [(cube(DVec3::ZERO, 2.0), 12), (strip(9, 2), 9)] {
            let loose = exploded(&whole);
            let (mesh, places) = sewn(&loose).unwrap().unwrap();
            assert_eq!((counts(&mesh), places.len()), (counts(&whole), edges));
            let mut work = work_of(&mesh, &places);
            cut_open(&mut work, |curve| curve == 7);
            let cut = work.to_mesh().unwrap();
            assert_eq!(counts(&cut), counts(&loose));
            assert_eq!(work.place.len(), work.points.len());
            // Both sides of every edge, and all are edges of a quad.
            assert_eq!(work.features.len(), 2 * edges);
            let half_edges = HalfEdges::new(&work.faces, work.points.len());
            assert!(work.features.iter().all(|&([a, b], _)| half_edges.find(a, b).is_some()));
            // Nothing is where it was not.
            let at = |mesh: &SurfaceMesh| {
                let corners = mesh.faces().corners().iter();
                corners.map(|&v| mesh.points()[v as usize]).collect::<Vec<_>>()
            };
            assert_eq!(at(&cut), at(&loose));
        }
    }

    #[test]
    fn a_slit_is_cut_from_tip_to_tip() {
        // Four quads around a vertex, cut from the middle to one side, and from the middle of two sides.
        let grid = crate::mesh::test_models::grid(2);
        for (slit, loops) in [(vec![[1, 4]], 1), (vec![[1, 4], [4, 7]], 2)] {
            let mut work = work_of(&grid, &FxHashSet::default());
            work.features = slit.iter().map(|&ends| (ends, 0)).chain([([0, 1], 1), ([1, 2], 1)]).collect();
            cut_open(&mut work, |curve| curve == 0);
            let mesh = work.to_mesh().unwrap();
            let topology = Topology::of(&mesh);
            assert_eq!((topology.boundary_loops, topology.components), (loops, loops), "one piece has one loop");
            assert!(topology.manifold && work.features.len() == 2 * slit.len() + 2);
        }
    }

    #[test]
    fn what_meets_in_threes_or_runs_along_is_left_open() {
        let apexes = [DVec3::new(0.2, 1.0, 0.0), DVec3::new(0.9, -0.7, 0.3), DVec3::new(0.5, 0.1, 1.5)];
        let points: Vec<DVec3> = apexes.iter().flat_map(|&apex| [DVec3::ZERO, DVec3::X, apex]).collect();
        assert!(sewn(&triangles(&points, &[[0, 1, 2], [3, 4, 5], [6, 7, 8]])).unwrap().is_none());
        assert!(sewn(&triangles(&points[..6], &[[0, 1, 2], [3, 4, 5]])).unwrap().is_none(), "both run the same way");
        assert!(sewn(&triangles(&points[..6], &[[0, 1, 2], [4, 3, 5]])).unwrap().is_some());
    }

    #[test]
    fn edges_whose_ends_came_together_are_sewn_too() {
        // Two tetrahedra, loose, that touch in an edge: four sides lie on each other there.
        let p = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, -DVec3::Y, -DVec3::Z];
        let faces: [[u32; 3]; 8] =
            [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2], [0, 4, 1], [0, 1, 5], [1, 4, 5], [0, 5, 4]];
        let loose = exploded(&triangles(&p, &faces));
        let (mesh, places) = sewn(&loose).unwrap().unwrap();
        let topology = Topology::of(&mesh);
        assert!(topology.manifold && topology.closed && topology.consistently_oriented, "{topology:?}");
        assert_eq!((topology.components, places.len()), (2, 11));
        let mut work = work_of(&mesh, &places);
        cut_open(&mut work, |_| true);
        assert_eq!(counts(&work.to_mesh().unwrap()), counts(&loose));
    }

    #[test]
    fn a_band_with_half_a_turn_is_left_open_where_its_sides_do_not_agree() {
        let (mesh, places) = sewn(&exploded(&strip(9, 1))).unwrap().unwrap();
        let topology = Topology::of(&mesh);
        assert!(topology.manifold && topology.consistently_oriented && topology.boundary_loops == 1);
        assert_eq!((topology.components, topology.euler, places.len()), (1, 1, 8));
    }
}
