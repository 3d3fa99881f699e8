//! Counts, topology and defects of a surface, with their places.
//!
//! Everything is counted on the mesh as it is; nothing is repaired or assumed. Faces that use a vertex twice have no
//! place in a surface: they are reported as degenerate and left out of all counts of edges, loops and components.

mod places;
#[cfg(test)]
mod tests;

use super::area::{area_vector, safe_length};
use super::connectivity::{Connectivity, faces_with_repeats, umbrellas};
use super::disjoint_sets::DisjointSets;
use super::duplicates::first_on_same_vertices;
use super::id::{CornerId, FaceId, VertexId};
use super::nesting::Shells;
use super::surface::SurfaceMesh;
use super::weld::first_at_same_position;
use crate::error::{Error, Result};
use places::{PLACES, longest, note};
use serde::Serialize;

pub use places::{BoundaryLoop, Places};

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

impl Topology {
    /// Examines a surface.
    pub fn of(mesh: &SurfaceMesh) -> Self {
        let (points, faces) = (mesh.points(), mesh.faces());
        let repeats = faces_with_repeats(faces, points.len());
        // Two independent halves of about the same size.
        let ((parts, umbrella), (same_face, same_place, flat)) =
            rayon::join(|| connected(mesh, &repeats), || coincident(mesh, &repeats));
        let shells = Shells::of(points, faces, &parts, &repeats);
        let loops = boundary_loops(mesh, &parts.boundary, &umbrella);

        let mut places = Places::default();
        let boundary_edges = note(&mut places.boundary_edges, parts.boundary.iter().map(|&c| edge_at(mesh, c)));
        let nonmanifold_edges = note(&mut places.nonmanifold_edges, ids(&parts.nonmanifold));
        let nonmanifold_vertices =
            note(&mut places.nonmanifold_vertices, nonmanifold_vertices(mesh, &umbrella, &parts.nonmanifold, &repeats));
        let inconsistent_edges = note(&mut places.inconsistent_edges, ids(&parts.inconsistent));
        let degenerate_faces = note(&mut places.degenerate_faces, flat.into_iter());
        let duplicate_faces = note(&mut places.duplicate_faces, repeaters(&same_face).map(|pair| pair.map(FaceId)));
        let coincident_vertices =
            note(&mut places.coincident_vertices, repeaters(&same_place).map(|pair| pair.map(VertexId)));
        let unreferenced_vertices = note(&mut places.unreferenced_vertices, unreferenced(mesh).into_iter());
        let inverted_components =
            note(&mut places.inverted_components, inverted_components(&parts, &shells).map(FaceId::new));

        let no_surface = repeats.iter().filter(|&&r| r).count();
        let whole = no_surface == 0;
        let closed = faces.len() > no_surface && boundary_edges == 0 && nonmanifold_edges == 0;
        let sheets = nonmanifold_edges == 0 && nonmanifold_vertices == 0;
        let orientable = parts.orientable.iter().all(|&o| o);
        let consistently_oriented = inconsistent_edges == 0;
        let components = parts.components - no_surface;
        let euler = euler(mesh, &repeats, &parts, no_surface);
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
            places: Places { boundary_loops: longest(&loops), ..places },
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

/// Edges and components, and for every corner the fan of its vertex that it belongs to.
fn connected(mesh: &SurfaceMesh, repeats: &[bool]) -> (Connectivity, Vec<u32>) {
    let (faces, half_edges) = (mesh.faces(), mesh.half_edges());
    rayon::join(
        || Connectivity::of(faces, &half_edges, repeats),
        || umbrellas(faces, &half_edges, repeats, |_, _| true),
    )
}

/// The first face on the same vertices as every face, the first vertex at the same place as every vertex, and the faces without
/// area.
fn coincident(mesh: &SurfaceMesh, repeats: &[bool]) -> (Vec<u32>, Vec<u32>, Vec<FaceId>) {
    (
        first_on_same_vertices(mesh.faces(), repeats),
        first_at_same_position(mesh.points()),
        degenerate_faces(mesh, repeats),
    )
}

/// The vertices that no face uses.
fn unreferenced(mesh: &SurfaceMesh) -> Vec<VertexId> {
    let used = used_vertices(mesh, &vec![false; mesh.faces().len()]);
    (0..used.len()).filter(|&v| !used[v]).map(VertexId::new).collect()
}

/// The ends of the edge that leaves a corner.
fn edge_at(mesh: &SurfaceMesh, c: u32) -> [VertexId; 2] {
    [mesh.faces().corners()[c as usize], corner_end(mesh, c)].map(VertexId)
}

/// The Euler characteristic of the faces that are some.
fn euler(mesh: &SurfaceMesh, repeats: &[bool], parts: &Connectivity, no_surface: usize) -> i64 {
    let vertices = used_vertices(mesh, repeats).iter().filter(|&&u| u).count();
    vertices as i64 - parts.edges as i64 + (mesh.faces().len() - no_surface) as i64
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

fn edge_name(ends: &[VertexId; 2]) -> String {
    format!("{}-{}", ends[0], ends[1])
}

/// `edge 3-4, 4-9, …`: the places of an error message.
fn list<T>(kind: &str, places: &[T], name: impl Fn(&T) -> String) -> String {
    let names: Vec<String> = places.iter().map(name).collect();
    format!("{kind} {}{}", names.join(", "), if places.len() == PLACES { ", …" } else { "" })
}
