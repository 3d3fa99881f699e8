//! Counts, topology and defects of a surface, with their places.
//!
//! Everything is counted on the mesh as it is; nothing is repaired or assumed. Faces that use a vertex twice have no
//! place in a surface: they are reported as degenerate and left out of all counts of edges, loops and components.

use super::area::{area_vector, safe_length};
use super::connectivity::{Connectivity, faces_with_repeats, umbrellas};
use super::disjoint_sets::DisjointSets;
use super::duplicates::first_on_same_vertices;
use super::id::{CornerId, FaceId, VertexId};
use super::nesting::Shells;
use super::surface::SurfaceMesh;
use super::weld::first_at_same_position;
use crate::error::{Error, Result};
use serde::Serialize;

/// How many places of a defect are kept.
const PLACES: usize = 10;
/// A face is degenerate below this share of the squared bounding-box diagonal.
pub(crate) const DEGENERATE_AREA: f64 = 1e-12;

/// What [`Topology::of`] found out about a surface.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Topology {
    /// Number of vertices, unreferenced ones included.
    pub vertices: usize,
    /// Number of faces.
    pub faces: usize,
    /// Faces with three corners.
    pub triangles: usize,
    /// Faces with four corners.
    pub quads: usize,
    /// Faces with more corners.
    pub polygons: usize,
    /// Number of undirected edges.
    pub edges: usize,
    /// Sets of faces linked through edges; bodies that only share a vertex are two.
    pub components: usize,
    /// Euler number: referenced vertices − edges + faces.
    pub euler: i64,
    /// Number of handles, summed over the components; only where every edge and vertex is manifold and the surface orientable.
    pub genus: Option<usize>,
    /// Signed volume, positive where the faces look outward; only for a closed, consistently oriented surface.
    pub volume: Option<f64>,
    /// Every edge has exactly two faces.
    pub closed: bool,
    /// No edge has more than two faces, every vertex has one umbrella, no face uses a vertex twice.
    pub manifold: bool,
    /// The faces can be turned so that neighbours agree.
    pub orientable: bool,
    /// Neighbours agree as they are.
    pub consistently_oriented: bool,
    /// Number of closed curves that the boundary edges form.
    pub boundary_loops: usize,
    /// Edges with one face.
    pub boundary_edges: usize,
    /// Edges with more than two faces.
    pub nonmanifold_edges: usize,
    /// Vertices on such an edge or with more than one umbrella (bow-ties).
    pub nonmanifold_vertices: usize,
    /// Edges that their two faces run along in the same direction.
    pub inconsistent_edges: usize,
    /// Faces that use a vertex twice, or whose area is zero or below 1e-12 × diagonal².
    pub degenerate_faces: usize,
    /// Faces on the same vertices as an earlier face, in whatever sense.
    pub duplicate_faces: usize,
    /// Vertices at exactly the same position as an earlier one.
    pub coincident_vertices: usize,
    /// Vertices that no face uses.
    pub unreferenced_vertices: usize,
    /// Closed components that look inward, or outward though they are cavities.
    pub inverted_components: usize,
    /// Where to look: the first places of every kind that there is.
    pub places: Places,
}

/// The first places of every defect, under the name of its count.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Places {
    /// The longest boundary loops.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub boundary_loops: Vec<BoundaryLoop>,
    /// End points.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub boundary_edges: Vec<[VertexId; 2]>,
    /// End points.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub nonmanifold_edges: Vec<[VertexId; 2]>,
    /// Ids.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub nonmanifold_vertices: Vec<VertexId>,
    /// End points.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub inconsistent_edges: Vec<[VertexId; 2]>,
    /// Ids.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub degenerate_faces: Vec<FaceId>,
    /// A duplicate and the face that it repeats.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub duplicate_faces: Vec<[FaceId; 2]>,
    /// A vertex and the one at whose position it is.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub coincident_vertices: Vec<[VertexId; 2]>,
    /// Ids.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub unreferenced_vertices: Vec<VertexId>,
    /// A face of each.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub inverted_components: Vec<FaceId>,
}

/// A closed curve of boundary edges.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BoundaryLoop {
    /// Its smallest vertex id.
    pub start: VertexId,
    /// Number of edges.
    pub edges: usize,
    /// In the unit of the file.
    pub length: f64,
}

impl Topology {
    /// Examines a surface.
    pub fn of(mesh: &SurfaceMesh) -> Self {
        let (points, faces) = (mesh.points(), mesh.faces());
        let repeats = faces_with_repeats(faces, points.len());
        // Two independent halves of about the same size.
        let ((parts, umbrella), (same_face, same_place, flat)) = rayon::join(
            || {
                let half_edges = mesh.half_edges();
                rayon::join(
                    || Connectivity::of(faces, &half_edges, &repeats),
                    || umbrellas(faces, &half_edges, &repeats, |_, _| true),
                )
            },
            || {
                (
                    first_on_same_vertices(faces, &repeats),
                    first_at_same_position(points),
                    degenerate_faces(mesh, &repeats),
                )
            },
        );
        let shells = Shells::of(points, faces, &parts, &repeats);
        let loops = boundary_loops(mesh, &parts.boundary, &umbrella);
        let used = used_vertices(mesh, &vec![false; faces.len()]);
        let ends = |c: u32| [faces.corners()[c as usize], corner_end(mesh, c)];

        let mut places = Places::default();
        let boundary_edges = note(&mut places.boundary_edges, parts.boundary.iter().map(|&c| ends(c).map(VertexId)));
        let nonmanifold_edges = note(&mut places.nonmanifold_edges, ids(&parts.nonmanifold));
        let nonmanifold_vertices =
            note(&mut places.nonmanifold_vertices, nonmanifold_vertices(mesh, &umbrella, &parts.nonmanifold, &repeats));
        let inconsistent_edges = note(&mut places.inconsistent_edges, ids(&parts.inconsistent));
        let degenerate_faces = note(&mut places.degenerate_faces, flat.into_iter());
        let duplicate_faces = note(&mut places.duplicate_faces, repeaters(&same_face).map(|pair| pair.map(FaceId)));
        let coincident_vertices =
            note(&mut places.coincident_vertices, repeaters(&same_place).map(|pair| pair.map(VertexId)));
        let unreferenced_vertices =
            note(&mut places.unreferenced_vertices, (0..points.len()).filter(|&v| !used[v]).map(VertexId::new));
        let inverted_components =
            note(&mut places.inverted_components, inverted_components(&parts, &shells).map(FaceId::new));
        places.boundary_loops = longest(&loops);

        let no_surface = repeats.iter().filter(|&&r| r).count();
        let whole = no_surface == 0;
        let closed = faces.len() > no_surface && boundary_edges == 0 && nonmanifold_edges == 0;
        let sheets = nonmanifold_edges == 0 && nonmanifold_vertices == 0;
        let orientable = parts.orientable.iter().all(|&o| o);
        let consistently_oriented = inconsistent_edges == 0;
        let surface_vertices = used_vertices(mesh, &repeats).iter().filter(|&&u| u).count();
        let components = parts.components - no_surface;
        let euler = surface_vertices as i64 - parts.edges as i64 + (faces.len() - no_surface) as i64;
        let [triangles, quads] = [3, 4].map(|size| faces.iter().filter(|f| f.len() == size).count());
        Topology {
            vertices: points.len(),
            faces: faces.len(),
            triangles,
            quads,
            polygons: faces.len() - triangles - quads,
            edges: parts.edges,
            components,
            euler,
            genus: (sheets && orientable).then(|| genus(components, loops.len(), euler)),
            volume: (closed && whole && consistently_oriented).then(|| shells.volume.iter().sum()),
            closed,
            manifold: sheets && whole,
            orientable,
            consistently_oriented,
            boundary_loops: loops.len(),
            boundary_edges,
            nonmanifold_edges,
            nonmanifold_vertices,
            inconsistent_edges,
            degenerate_faces,
            duplicate_faces,
            coincident_vertices,
            unreferenced_vertices,
            inverted_components,
            places,
        }
    }

    /// Fails where a method that needs a manifold would go wrong; names the places and the remedy.
    ///
    /// # Errors
    /// [`Error::Input`] with the first places at which the surface is not manifold.
    pub fn require_manifold(&self) -> Result<()> {
        let remedy = "cut the surface into manifold sheets first with `carreau repair`";
        if self.nonmanifold_edges > 0 {
            let what = format!("{} edges have more than two faces", self.nonmanifold_edges);
            return Err(Error::input(what, list("edge", &self.places.nonmanifold_edges, edge_name), remedy));
        }
        if self.nonmanifold_vertices > 0 {
            let what = format!("the faces around {} vertices form more than one fan", self.nonmanifold_vertices);
            return Err(Error::input(
                what,
                list("vertex", &self.places.nonmanifold_vertices, |v| v.to_string()),
                remedy,
            ));
        }
        match self.places.degenerate_faces.first() {
            Some(f) if !self.manifold => Err(Error::input("a face uses a vertex twice", format!("face {f}"), remedy)),
            _ => Ok(()),
        }
    }

    /// Fails where neighbouring faces disagree about the outside; names the places and the remedy.
    ///
    /// # Errors
    /// [`Error::Input`] with the first edges whose faces are oriented against each other.
    pub fn require_consistent_orientation(&self) -> Result<()> {
        if self.consistently_oriented {
            return Ok(());
        }
        let what = format!("the two faces of {} edges are oriented against each other", self.inconsistent_edges);
        let remedy = match self.orientable {
            true => "orient the faces first with `carreau repair`",
            false => "the surface has only one side (as a Möbius strip): cut it open",
        };
        Err(Error::input(what, list("edge", &self.places.inconsistent_edges, edge_name), remedy))
    }
}

/// Keeps the first places and returns the number of all.
fn note<T>(places: &mut Vec<T>, found: impl Iterator<Item = T>) -> usize {
    let mut count = 0;
    for place in found {
        count += 1;
        if places.len() < PLACES {
            places.push(place);
        }
    }
    count
}

fn ids(edges: &[[u32; 2]]) -> impl Iterator<Item = [VertexId; 2]> + '_ {
    edges.iter().map(|e| e.map(VertexId))
}

/// (id, leader) of all that are not their own leader.
fn repeaters(leaders: &[u32]) -> impl Iterator<Item = [u32; 2]> + '_ {
    (0u32..).zip(leaders).filter(|&(k, &leader)| k != leader).map(|(k, &leader)| [k, leader])
}

fn corner_end(mesh: &SurfaceMesh, c: u32) -> u32 {
    mesh.vertex(mesh.next(CornerId(c))).0
}

/// The vertices of all faces but the ignored ones.
fn used_vertices(mesh: &SurfaceMesh, ignore: &[bool]) -> Vec<bool> {
    let mut used = vec![false; mesh.vertex_count()];
    for (face, _) in mesh.faces().iter().zip(ignore).filter(|&(_, &ignored)| !ignored) {
        face.iter().for_each(|&v| used[v as usize] = true);
    }
    used
}

/// The vertices of an edge or a face with a defect: more than two sides, sides that do not agree, a vertex used twice; and those
/// with more than one umbrella.
pub(crate) fn irregular_vertices(mesh: &SurfaceMesh) -> Vec<bool> {
    let (faces, half_edges) = (mesh.faces(), mesh.half_edges());
    let repeats = faces_with_repeats(faces, mesh.vertex_count());
    let parts = Connectivity::of(faces, &half_edges, &repeats);
    let umbrella = umbrellas(faces, &half_edges, &repeats, |_, _| true);
    let mut irregular = vec![false; mesh.vertex_count()];
    nonmanifold_vertices(mesh, &umbrella, &parts.nonmanifold, &repeats).for_each(|v| irregular[v.index()] = true);
    let in_repeats = faces.iter().zip(&repeats).filter(|(_, repeats)| **repeats).flat_map(|(face, _)| face);
    parts.inconsistent.as_flattened().iter().chain(in_repeats).for_each(|&v| irregular[v as usize] = true);
    irregular
}

fn nonmanifold_vertices(
    mesh: &SurfaceMesh,
    umbrella: &[u32],
    nonmanifold_edges: &[[u32; 2]],
    repeats: &[bool],
) -> impl Iterator<Item = VertexId> + use<> {
    let mut count = vec![0u8; mesh.vertex_count()];
    for (f, face) in mesh.faces().iter().enumerate().filter(|&(f, _)| !repeats[f]) {
        let first = mesh.faces().offsets()[f] as usize;
        for (_, &v) in face.iter().enumerate().filter(|&(k, _)| umbrella[first + k] as usize == first + k) {
            count[v as usize] = count[v as usize].saturating_add(1);
        }
    }
    nonmanifold_edges.as_flattened().iter().for_each(|&v| count[v as usize] = 2);
    count.into_iter().enumerate().filter(|&(_, n)| n > 1).map(|(v, _)| VertexId::new(v))
}

/// Faces with a repeated vertex, or without area: zero as a double, or below the share of the squared diagonal.
fn degenerate_faces(mesh: &SurfaceMesh, repeats: &[bool]) -> Vec<FaceId> {
    let diagonal = mesh.diagonal();
    let tiny = |face: &[u32]| {
        let area = safe_length(area_vector(mesh.points(), face));
        // Divided one after the other: the square of the diagonal may leave the range of a double.
        area == 0.0 || area / diagonal / diagonal <= DEGENERATE_AREA
    };
    let found = mesh.faces().iter().enumerate().filter(|&(f, face)| repeats[f] || tiny(face));
    found.map(|(f, _)| FaceId::new(f)).collect()
}

/// A face of every inverted component.
fn inverted_components(parts: &Connectivity, shells: &Shells) -> impl Iterator<Item = usize> {
    let mut next = 0;
    // Components are numbered by first appearance.
    let firsts = parts.component.iter().enumerate().filter(move |&(_, &c)| {
        let first = c == next;
        next += u32::from(first);
        first
    });
    firsts.filter(|&(_, &c)| shells.is_inverted(c)).map(|(f, _)| f)
}

/// Euler's formula over all components: V − E + F = Σ (2 − 2g − b).
fn genus(components: usize, loops: usize, euler: i64) -> usize {
    let doubled = 2 * components as i64 - loops as i64 - euler;
    usize::try_from(doubled / 2).unwrap_or(0)
}

/// The curves of boundary edges. Their nodes are umbrellas, so that two holes that touch at a vertex are told apart
/// where the surface between them is.
fn boundary_loops(mesh: &SurfaceMesh, boundary: &[u32], umbrella: &[u32]) -> Vec<BoundaryLoop> {
    let nodes_of = |&c: &u32| [c, mesh.next(CornerId(c)).0].map(|c| umbrella[c as usize]);
    let mut nodes: Vec<u32> = boundary.iter().flat_map(nodes_of).collect();
    nodes.sort_unstable();
    nodes.dedup();
    let compact = |node: u32| nodes.partition_point(|&n| n < node) as u32;
    let mut sets = DisjointSets::new(nodes.len());
    for c in boundary {
        let [a, b] = nodes_of(c).map(compact);
        sets.union(a, b);
    }
    let (label, count) = sets.labels();
    let mut loops = vec![BoundaryLoop { start: VertexId(u32::MAX), edges: 0, length: 0.0 }; count];
    for c in boundary {
        let ends = [mesh.vertex(CornerId(*c)), VertexId(corner_end(mesh, *c))];
        let own = &mut loops[label[compact(nodes_of(c)[0]) as usize] as usize];
        own.start = own.start.min(ends[0]).min(ends[1]);
        own.edges += 1;
        own.length += mesh.point(ends[0]).distance(mesh.point(ends[1]));
    }
    loops
}

fn longest(loops: &[BoundaryLoop]) -> Vec<BoundaryLoop> {
    let mut sorted = loops.to_vec();
    sorted.sort_by(|a, b| b.length.total_cmp(&a.length).then(a.start.cmp(&b.start)));
    sorted.truncate(PLACES);
    sorted
}

fn edge_name(ends: &[VertexId; 2]) -> String {
    format!("{}-{}", ends[0], ends[1])
}

/// `edge 3-4, 4-9, …`: the places of an error message.
fn list<T>(kind: &str, places: &[T], name: impl Fn(&T) -> String) -> String {
    let names: Vec<String> = places.iter().map(name).collect();
    format!("{kind} {}{}", names.join(", "), if places.len() == PLACES { ", …" } else { "" })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Polygons;
    use crate::mesh::test_models::*;
    use glam::DVec3;
    use proptest::prelude::*;

    /// All numbers of defects, in the order of the struct.
    fn defects(t: &Topology) -> [usize; 10] {
        [
            t.boundary_loops,
            t.boundary_edges,
            t.nonmanifold_edges,
            t.nonmanifold_vertices,
            t.inconsistent_edges,
            t.degenerate_faces,
            t.duplicate_faces,
            t.coincident_vertices,
            t.unreferenced_vertices,
            t.inverted_components,
        ]
    }

    fn is_clean_and_closed(t: &Topology) -> bool {
        t.closed && t.manifold && t.orientable && t.consistently_oriented && defects(t) == [0; 10]
    }

    #[test]
    fn closed_surfaces_have_their_genus_and_volume() {
        for (mesh, genus, volume) in [
            (tetrahedron(), 0, 8.0 / 3.0),
            (cube(DVec3::splat(1e6), 2.0), 0, 8.0),
            (torus(60, 30), 1, 2.0 * 0.25 * std::f64::consts::PI.powi(2) * 2.0),
        ] {
            let t = Topology::of(&mesh);
            assert!(is_clean_and_closed(&t), "{t:?}");
            assert_eq!((t.components, t.genus), (1, Some(genus)));
            assert_eq!(t.euler, 2 - 2 * genus as i64);
            assert!((t.volume.unwrap() / volume - 1.0).abs() < 0.02, "{:?} {volume}", t.volume);
            assert_eq!(t.places, Places::default());
        }
    }

    #[test]
    fn faces_are_counted_by_size() {
        let pentagon: Polygons = [&[0u32, 1, 2, 3, 4][..], &[0, 1, 5], &[1, 2, 6, 5]].into_iter().collect();
        let points = (0..7).map(|k| DVec3::new(f64::from(k), f64::from(k * k), f64::from(k % 2))).collect();
        let t = Topology::of(&SurfaceMesh::new(points, pentagon).unwrap());
        assert_eq!((t.faces, t.triangles, t.quads, t.polygons, t.edges), (3, 1, 1, 1, 5 + 2 + 2));
    }

    #[test]
    fn holes_are_loops_with_their_length() {
        let n = 6;
        let cell = |i: usize, j: usize| [2 * (i * n + j), 2 * (i * n + j) + 1];
        let apart = without(&grid(n as u32), &[cell(1, 1), cell(3, 4)].concat());
        let t = Topology::of(&apart);
        assert_eq!((t.boundary_loops, t.boundary_edges, t.genus), (3, 4 * n + 8, Some(0)));
        assert!(t.manifold && !t.closed);
        assert_eq!(
            t.places.boundary_loops[0],
            BoundaryLoop { start: VertexId(0), edges: 4 * n, length: 4.0 * n as f64 }
        );
        assert_eq!(t.places.boundary_loops[1].length, 4.0);
        assert_eq!(t.places.boundary_edges.len(), PLACES);

        let touching = Topology::of(&without(&grid(n as u32), &[cell(1, 1), cell(2, 2)].concat()));
        assert_eq!(touching.nonmanifold_vertices, 1);
        assert_eq!(touching.places.nonmanifold_vertices, [VertexId(2 * (n as u32 + 1) + 2)]);
    }

    #[test]
    fn one_sided_surfaces_are_not_orientable() {
        for half_turns in 0..4 {
            let t = Topology::of(&strip(12, half_turns));
            let one_sided = half_turns % 2 == 1;
            assert_eq!((t.orientable, t.consistently_oriented), (!one_sided, !one_sided));
            assert_eq!(t.boundary_loops, if one_sided { 1 } else { 2 });
            assert_eq!(t.genus, (!one_sided).then_some(0));
            assert_eq!((t.components, t.euler, t.manifold), (1, 0, true));
            assert_eq!(t.require_consistent_orientation().is_err(), one_sided);
        }
    }

    #[test]
    fn bodies_that_touch_are_not_manifold() {
        let edge = Topology::of(&cubes_sharing_an_edge());
        assert_eq!((edge.components, edge.nonmanifold_edges, edge.nonmanifold_vertices), (1, 1, 2));
        assert!(!edge.manifold && !edge.closed && edge.genus.is_none());
        let message = edge.require_manifold().unwrap_err().to_string();
        let [a, b] = edge.places.nonmanifold_edges[0];
        assert!(message.contains(&format!("edge {a}-{b}")) && message.contains("repair"), "{message}");

        let vertex = Topology::of(&cubes_sharing_a_vertex());
        assert_eq!((vertex.components, vertex.nonmanifold_edges, vertex.nonmanifold_vertices), (2, 0, 1));
        assert!(!vertex.manifold && vertex.closed && vertex.require_manifold().is_err());
    }

    #[test]
    fn inconsistent_faces_show_at_their_edges() {
        let mesh = turned(&torus(12, 8), |f| f == 40);
        let t = Topology::of(&mesh);
        assert_eq!((t.inconsistent_edges, t.orientable, t.consistently_oriented), (3, true, false));
        assert_eq!(t.genus, Some(1));
        assert!(t.volume.is_none());
        let of_face = |[a, b]: &[VertexId; 2]| [a, b].iter().all(|v| mesh.face(FaceId(40)).contains(&v.0));
        assert!(t.places.inconsistent_edges.iter().all(of_face));
    }

    #[test]
    fn degenerate_and_duplicate_faces_have_their_place() {
        let mut points = tetrahedron().points().to_vec();
        points.extend([DVec3::X * 9.0, points[1], (points[0] + points[1]) / 2.0, DVec3::new(1.0, 1.0, 1.0 + 1e-13)]);
        let mut faces: Vec<[u32; 3]> = vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]];
        faces.extend([[1, 0, 0], [2, 1, 0], [1, 2, 0], [0, 1, 6], [7, 0, 3]]);
        let t = Topology::of(&triangles(&points, &faces));
        assert_eq!(t.places.degenerate_faces, [4, 7, 8].map(FaceId));
        assert_eq!(t.places.duplicate_faces, [[5, 0], [6, 0]].map(|p| p.map(FaceId)));
        assert_eq!(t.places.coincident_vertices, [[VertexId(5), VertexId(1)]]);
        assert_eq!(t.places.unreferenced_vertices, [4, 5].map(VertexId));
        assert!(!t.manifold);
    }

    #[test]
    fn a_repeated_vertex_does_not_disturb_its_neighbours() {
        let clean = Topology::of(&tetrahedron());
        let mut faces = tetrahedron().faces().clone();
        [[0, 1, 1], [2, 2, 2], [3, 0, 3]].iter().for_each(|f| faces.push(f));
        let t = Topology::of(&SurfaceMesh::new(tetrahedron().points().to_vec(), faces).unwrap());
        assert_eq!((t.degenerate_faces, t.nonmanifold_edges, t.closed, t.manifold), (3, 0, true, false));
        assert_eq!((t.edges, t.components, t.euler, t.genus), (clean.edges, 1, 2, Some(0)));
        assert!(t.require_manifold().unwrap_err().to_string().contains("face 4"));
    }

    #[test]
    fn scale_and_place_do_not_matter() {
        for scale in [1e-150, 1e-30, 1e30, 1e150, 1e200] {
            let t = Topology::of(&moved(&torus(12, 8), |p| p * scale));
            assert_eq!((t.degenerate_faces, t.genus, t.closed), (0, Some(1), true), "{scale}");
        }
        // Areas that a double cannot hold are reported: nothing can be computed on such a mesh.
        for scale in [1e-170, 1e-310] {
            let lost = Topology::of(&moved(&torus(12, 8), |p| p * scale));
            assert_eq!(lost.degenerate_faces, lost.faces, "{scale}");
        }
    }

    #[test]
    fn nesting_tells_cavities_from_inverted_bodies() {
        let ball = |radius: f64, outward: bool| turned(&moved(&sphere(1), |p| p * radius), |_| !outward);
        let inverted = |parts: &[SurfaceMesh]| Topology::of(&together(parts)).inverted_components;
        assert_eq!(inverted(&[ball(1.0, true)]), 0);
        assert_eq!(inverted(&[ball(1.0, false)]), 1);
        assert_eq!(inverted(&[ball(2.0, true), ball(1.0, false)]), 0);
        assert_eq!(inverted(&[ball(1.0, true), ball(2.0, true)]), 1);
        assert_eq!(inverted(&[ball(3.0, true), ball(2.0, false), ball(1.0, true)]), 0);
        assert_eq!(inverted(&[ball(3.0, false), ball(2.0, true), ball(1.0, false)]), 3);
        let beside = moved(&ball(1.0, true), |p| p + DVec3::X * 1.5);
        assert_eq!(inverted(&[ball(1.0, true), beside]), 0);
        // A ball in the hole of a ring is inside the ring's box, but not inside the ring.
        let in_hole = moved(&sphere(1), |p| p * 0.4);
        assert_eq!(inverted(&[torus(24, 12), in_hole.clone()]), 0);
        let in_tube = moved(&in_hole, |p| p + DVec3::X * 2.0);
        assert_eq!(inverted(&[torus(24, 12), in_tube.clone()]), 1);
        assert_eq!(inverted(&[in_tube, turned(&torus(24, 12), |_| true)]), 2);
    }

    #[test]
    fn an_empty_mesh_is_not_closed() {
        let t = Topology::of(&triangles(&[DVec3::ZERO], &[]));
        assert!(!t.closed && t.components == 0 && t.unreferenced_vertices == 1);
    }

    #[test]
    fn the_record_has_numbers_and_places_under_the_same_names() {
        let t = Topology::of(&cubes_sharing_an_edge());
        let json = serde_json::to_value(&t).unwrap();
        for (name, places) in json["places"].as_object().unwrap() {
            assert!(json[name].as_u64().unwrap() >= places.as_array().unwrap().len() as u64, "{name}");
        }
        assert_eq!(json["nonmanifold_edges"], 1);
        assert_eq!(json["closed"], false);
    }

    /// A soup of faces on few vertices: every kind of defect appears.
    fn any_mesh() -> impl Strategy<Value = (Vec<[u32; 3]>, Vec<usize>, Vec<usize>)> {
        let faces = prop::collection::vec(prop::array::uniform3(0u32..9), 1..24);
        faces.prop_flat_map(|f| {
            let order: Vec<usize> = (0..f.len()).collect();
            (Just(f), Just(order).prop_shuffle(), Just((0..9).collect::<Vec<_>>()).prop_shuffle())
        })
    }

    proptest! {
        #[test]
        fn renumbering_changes_no_count((faces, order, names) in any_mesh()) {
            let points: Vec<DVec3> =
                (0..9).map(|k| DVec3::new(f64::from(k % 3), f64::from(k * k % 7), f64::from(k * k * k % 5))).collect();
            let mut renamed = points.clone();
            names.iter().zip(&points).for_each(|(&n, &p)| renamed[n] = p);
            let permuted: Vec<_> = order.iter().map(|&f| faces[f].map(|v| names[v as usize] as u32)).collect();
            let mut a = Topology::of(&triangles(&points, &faces));
            let mut b = Topology::of(&triangles(&renamed, &permuted));
            a.places = Places::default();
            b.places = Places::default();
            prop_assert!(a.volume.unwrap_or(0.0) - b.volume.unwrap_or(0.0) < 1e-9);
            (a.volume, b.volume) = (None, None);
            prop_assert_eq!(a, b);
        }
    }
}
