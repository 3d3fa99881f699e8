//! Borders that lie on each other: those of a surface that was cut where it is not manifold, or never sewn.
//!
//! With different vertices (T-junctions, as in careless exports) border vertices that all but coincide take the same place, and
//! every border edge is divided where vertices of another one are inside of it, so that whatever is made of both sides can
//! meet. Divided alike into edges that stay, it does.

use crate::error::Result;
use crate::geometry::search_tree::TriangleTree;
use crate::mesh::{CornerId, Polygons, Side, SurfaceMesh, VertexId};
use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

/// A share of the diagonal: vertices and edges touch at so small a distance, because files round their places.
pub const TOUCH_DISTANCE: f64 = 1e-6;
/// A count: rounds, as many as a triangle has edges because each of them divides one.
const DIVISION_ROUNDS: usize = 3;
/// A count: parts of an edge at most, because it may be longer than the quads that are wanted by any factor.
const MOST_EDGE_PARTS: f64 = 1e4;

/// The mesh with borders that meet in vertices, and what was done, one sentence each; `None` where there was nothing to do.
pub fn meeting_borders(mesh: &SurfaceMesh) -> Result<Option<(SurfaceMesh, Vec<String>)>> {
    let (mut met, mut what, mut count) = (None, Vec::new(), 0);
    if let Some((points, moved)) = coinciding(mesh) {
        what.push(format!("{moved} border vertices moved to others that they all but coincide with"));
        let mut moved = SurfaceMesh::new(points, mesh.faces().clone())?;
        moved.tagged_edges = mesh.tagged_edges.clone();
        met = Some(moved);
    }
    for _ in 0..DIVISION_ROUNDS {
        let Some((next, edges)) = round(met.as_ref().unwrap_or(mesh))? else { break };
        (met, count) = (Some(next), count + edges);
    }
    if count > 0 {
        what.push(format!("{count} border edges divided at vertices of other borders that lie on them"));
    }
    Ok(met.map(|mesh| (mesh, what)))
}

/// All points, with every border vertex where the first one is that it all but coincides with, and how many were elsewhere.
fn coinciding(mesh: &SurfaceMesh) -> Option<(Vec<DVec3>, usize)> {
    let borders = border_edges(mesh);
    let flat: Vec<[u32; 3]> = borders.iter().map(|&c| ends(mesh, c)).map(|[a, b]| [a.0, b.0, b.0]).collect();
    let tree = TriangleTree::new(mesh.points(), &flat);
    let touch = TOUCH_DISTANCE * mesh.diagonal();
    let (mut points, mut moved) = (mesh.points().to_vec(), 0);
    let mut vertices: Vec<u32> = flat.iter().flat_map(|e| [e[0], e[1]]).collect();
    vertices.sort_unstable();
    vertices.dedup();
    for v in vertices {
        let (p, mut first) = (mesh.points()[v as usize], v);
        tree.within(p, touch, |found| {
            let edge = flat[found.triangle as usize];
            for w in edge.into_iter().filter(|_| !edge.contains(&v)) {
                if mesh.points()[w as usize].distance(p) <= touch {
                    first = first.min(w);
                }
            }
        });
        let to = points[first as usize];
        moved += usize::from(to != p);
        points[v as usize] = to;
    }
    (moved > 0).then_some((points, moved))
}

fn border_edges(mesh: &SurfaceMesh) -> Vec<CornerId> {
    (0..mesh.corner_count()).map(CornerId::new).filter(|&c| mesh.side(c) == Side::Border).collect()
}

fn ends(mesh: &SurfaceMesh, c: CornerId) -> [VertexId; 2] {
    [mesh.vertex(c), mesh.vertex(mesh.next(c))]
}

fn round(mesh: &SurfaceMesh) -> Result<Option<(SurfaceMesh, usize)>> {
    let borders = border_edges(mesh);
    let inside = inside(mesh, &borders.iter().map(|&c| ends(mesh, c)).collect::<Vec<_>>());
    // One edge of a triangle at a time: the corner that it leaves, and the vertices on it.
    let mut of_face: FxHashMap<usize, (CornerId, Vec<DVec3>)> = FxHashMap::default();
    for (&c, places) in borders.iter().zip(inside) {
        if !places.is_empty() {
            of_face.entry(mesh.face_of(c).index()).or_insert((c, places));
        }
    }
    if of_face.is_empty() {
        return Ok(None);
    }
    Ok(Some((divided(mesh, &of_face)?, of_face.len())))
}

/// The mesh with vertices on edges of triangles: for every triangle the corner that the edge leaves, and its vertices.
fn divided(mesh: &SurfaceMesh, of_face: &FxHashMap<usize, (CornerId, Vec<DVec3>)>) -> Result<SurfaceMesh> {
    let (mut points, mut faces) = (mesh.points().to_vec(), Polygons::new());
    let mut tagged = mesh.tagged_edges.clone();
    for (f, face) in mesh.faces().iter().enumerate() {
        let Some((c, places)) = of_face.get(&f) else {
            faces.push(face);
            continue;
        };
        let [a, b] = ends(mesh, *c).map(|v| v.0);
        let apex = mesh.vertex(mesh.next(mesh.next(*c))).0;
        let mut chain = vec![a];
        for &p in places {
            chain.push(points.len() as u32);
            points.push(p);
        }
        chain.push(b);
        chain.windows(2).for_each(|w| faces.push(&[w[0], w[1], apex]));
        let is_own = |ends: [VertexId; 2]| ends == [VertexId(a), VertexId(b)] || ends == [VertexId(b), VertexId(a)];
        if let Some(k) = tagged.iter().position(|e| is_own(e.ends)) {
            let edge = tagged.swap_remove(k);
            let part = |w: &[u32]| crate::mesh::TaggedEdge { ends: [VertexId(w[0]), VertexId(w[1])], ..edge };
            tagged.extend(chain.windows(2).map(part));
        }
    }
    let mut next = SurfaceMesh::new(points, faces)?;
    next.tagged_edges = tagged;
    Ok(next)
}

/// The border edges that lie on others with the same ends.
pub fn shared_borders(mesh: &SurfaceMesh) -> Vec<CornerId> {
    let borders = border_edges(mesh);
    let mut count: FxHashMap<_, u32> = FxHashMap::default();
    borders.iter().for_each(|&c| *count.entry(edge_place(mesh, c)).or_default() += 1);
    borders.into_iter().filter(|&c| count[&edge_place(mesh, c)] > 1).collect()
}

/// What tells where an edge is, whichever way it runs.
pub type EdgePlace = [[u64; 3]; 2];

pub fn edge_place(mesh: &SurfaceMesh, c: CornerId) -> EdgePlace {
    in_order(ends(mesh, c).map(|v| mesh.point(v))).map(|p| p.to_array().map(f64::to_bits))
}

/// Two points, the same one first whichever way an edge runs.
fn in_order([a, b]: [DVec3; 2]) -> [DVec3; 2] {
    let order = |k: usize| a[k].total_cmp(&b[k]);
    if order(0).then(order(1)).then(order(2)).is_le() { [a, b] } else { [b, a] }
}

/// The mesh with those edges in parts up to a length, the same on all sides.
pub fn with_shared_borders_divided(mesh: &SurfaceMesh, length: f64) -> Result<SurfaceMesh> {
    let mut mesh = mesh.clone();
    // A triangle's turn comes for one edge after the other: what they shared at first counts.
    let shared: FxHashSet<_> = shared_borders(&mesh).into_iter().map(|c| edge_place(&mesh, c)).collect();
    for _ in 0..DIVISION_ROUNDS {
        let mut of_face = FxHashMap::default();
        for c in border_edges(&mesh).into_iter().filter(|&c| shared.contains(&edge_place(&mesh, c))) {
            let [a, b] = ends(&mesh, c).map(|v| mesh.point(v));
            let [from, to] = in_order([a, b]);
            let parts = (from.distance(to) / length).ceil().min(MOST_EDGE_PARTS);
            let mut places: Vec<DVec3> = (1..parts as u32).map(|k| from.lerp(to, f64::from(k) / parts)).collect();
            if from != a {
                places.reverse();
            }
            if !places.is_empty() {
                of_face.entry(mesh.face_of(c).index()).or_insert((c, places));
            }
        }
        if of_face.is_empty() {
            break;
        }
        mesh = divided(&mesh, &of_face)?;
    }
    Ok(mesh)
}

/// For every border edge the places of border vertices inside of it, in order.
fn inside(mesh: &SurfaceMesh, edges: &[[VertexId; 2]]) -> Vec<Vec<DVec3>> {
    let touch = TOUCH_DISTANCE * mesh.diagonal();
    let flat: Vec<[u32; 3]> = edges.iter().map(|[a, b]| [a.0, b.0, b.0]).collect();
    let tree = TriangleTree::new(mesh.points(), &flat);
    let mut places: Vec<Vec<(f64, DVec3)>> = vec![Vec::new(); edges.len()];
    for &[v, _] in edges {
        let p = mesh.point(v);
        tree.within(p, touch, |found| {
            let [a, b] = edges[found.triangle as usize].map(|v| mesh.point(v));
            let share = (p - a).dot(b - a) / (b - a).length_squared();
            if p.distance(a) > touch && p.distance(b) > touch && share > 0.0 && share < 1.0 {
                places[found.triangle as usize].push((share, p));
            }
        });
    }
    let sorted = |mut list: Vec<(f64, DVec3)>| {
        list.sort_by(|a, b| a.0.total_cmp(&b.0));
        list.dedup_by(|next, before| next.1.distance(before.1) <= touch);
        list.into_iter().map(|found| found.1).collect()
    };
    places.into_iter().map(sorted).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::test_models::triangles;

    #[test]
    fn shared_borders_are_divided_alike() {
        // Three sheets at an edge, which two of them run along the other way, and one beside.
        let points = [DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0), DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X];
        let soup: Vec<DVec3> =
            [[0, 1, 2], [1, 0, 3], [1, 0, 4], [2, 3, 5]].as_flattened().iter().map(|&v| points[v as usize]).collect();
        let mesh = triangles(&soup, &[[0, 1, 2], [3, 4, 5], [6, 7, 8], [9, 10, 11]]);
        assert_eq!(shared_borders(&mesh).len(), 3);
        let fine = with_shared_borders_divided(&mesh, 0.5).unwrap();
        let shared = shared_borders(&fine);
        assert_eq!((shared.len(), fine.face_count()), (3 * 8, 3 * 8 + 1));
        let longest = shared.iter().map(|&c| ends(&fine, c).map(|v| fine.point(v))).map(|[a, b]| a.distance(b));
        assert!(longest.fold(0.0, f64::max) <= 0.5);
        assert_eq!(with_shared_borders_divided(&fine, 0.5).unwrap().faces(), fine.faces());
        // However long the edges are beside the quads that are wanted.
        assert_eq!(with_shared_borders_divided(&mesh, 1e-100).unwrap().face_count(), 3 * MOST_EDGE_PARTS as usize + 1);
    }

    #[test]
    fn all_shared_borders_of_a_triangle_are_divided() {
        // Sheets that meet at all three edges of a triangle, one edge of each.
        let corners = [DVec3::X, DVec3::Y, DVec3::Z];
        let sheets = [[0, 1], [1, 2], [2, 0]].map(|[a, b]| [corners[b], corners[a], DVec3::ONE]);
        let soup: Vec<DVec3> = corners.into_iter().chain(sheets.into_iter().flatten()).collect();
        let faces: Vec<[u32; 3]> = (0..4).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        let fine = with_shared_borders_divided(&triangles(&soup, &faces), 0.5).unwrap();
        // The sheets share their sides with each other, too.
        assert_eq!(shared_borders(&fine).len(), 2 * 6 * 3);
    }

    #[test]
    fn border_edges_are_divided_and_vertices_meet() {
        // A large triangle below the line, three above: their middle is on the edge of the large one, their ends all but
        // coincide with its ends.
        let mut points =
            [[0.0, 0.0], [2.0, 0.0], [1.0, -1.0], [0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [0.0, 1.0], [2.0, 1.0]]
                .map(|[x, y]| DVec3::new(x, y, 0.0));
        points[3].y = 1e-9;
        let mesh = triangles(&points, &[[1, 0, 2], [3, 4, 6], [4, 5, 7], [4, 7, 6]]);
        let (met, what) = meeting_borders(&mesh).unwrap().unwrap();
        assert_eq!((what.len(), met.face_count()), (2, 5));
        let at = |p: DVec3| met.points().iter().filter(|&&q| q == p).count();
        assert_eq!([at(points[0]), at(points[4]), at(points[5])], [2, 2, 2]);
        assert!(meeting_borders(&met).unwrap().is_none());
    }
}
