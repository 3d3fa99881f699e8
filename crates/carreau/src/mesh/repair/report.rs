//! What was repaired.

use crate::mesh::topology::Topology;
use serde::Serialize;

/// What was done, in numbers, and what was found before and after.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RepairReport {
    /// Vertices merged into another one at the same place.
    pub welded_vertices: usize,
    /// Faces that used a vertex twice: shortened, divided or dropped.
    pub collapsed_faces: usize,
    /// Longest edges of flat triangles that were flipped.
    pub flipped_edges: usize,
    /// Vertices merged into the other end of a shortest edge.
    pub merged_vertices: usize,
    /// Faces without area that could only be dropped.
    pub dropped_faces: usize,
    /// Faces on the same vertices as an earlier one: dropped.
    pub dropped_duplicates: usize,
    /// Faces turned to agree with their neighbours.
    pub turned_faces: usize,
    /// New vertices made by cutting.
    pub split_vertices: usize,
    /// Closed components turned as a whole.
    pub turned_components: usize,
    /// Vertices that no face used: dropped.
    pub dropped_vertices: usize,
    /// The mesh as it was.
    pub before: Topology,
    /// The mesh as it is now.
    pub after: Topology,
}

impl RepairReport {
    /// One sentence for everything that was done, and for every defect that is left.
    pub fn sentences(&self) -> Vec<String> {
        let done = [
            (self.welded_vertices, "vertex welded", "vertices welded"),
            (self.collapsed_faces, "face with a repeated vertex shortened", "faces with repeated vertices shortened"),
            (self.flipped_edges, "edge of a flat triangle flipped", "edges of flat triangles flipped"),
            (self.merged_vertices, "sliver edge collapsed", "sliver edges collapsed"),
            (self.dropped_faces, "face without area dropped", "faces without area dropped"),
            (self.dropped_duplicates, "duplicate face dropped", "duplicate faces dropped"),
            (
                self.turned_faces,
                "face turned to agree with its neighbours",
                "faces turned to agree with their neighbours",
            ),
            (self.split_vertices, "vertex duplicated to cut the surface", "vertices duplicated to cut the surface"),
            (self.turned_components, "closed component turned inside out", "closed components turned inside out"),
            (self.dropped_vertices, "unreferenced vertex dropped", "unreferenced vertices dropped"),
        ];
        let left = [
            (self.after.boundary_loops, "boundary loop is left", "boundary loops are left"),
            (self.after.nonmanifold_edges, "non-manifold edge is left", "non-manifold edges are left"),
            (self.after.nonmanifold_vertices, "non-manifold vertex is left", "non-manifold vertices are left"),
            (self.after.degenerate_faces, "degenerate face is left", "degenerate faces are left"),
            (self.after.duplicate_faces, "duplicate face is left", "duplicate faces are left"),
            (self.after.unreferenced_vertices, "unreferenced vertex is left", "unreferenced vertices are left"),
            (self.after.inverted_components, "component is inside out", "components are inside out"),
        ];
        let sentence = |&(n, one, many): &(usize, &str, &str)| format!("{n} {}", if n == 1 { one } else { many });
        let mut out: Vec<String> = done.iter().chain(&left).filter(|s| s.0 > 0).map(sentence).collect();
        if !self.after.orientable {
            out.push(format!(
                "the surface has only one side (as a Möbius strip): {} edges stay inconsistent",
                self.after.inconsistent_edges
            ));
        } else if !self.after.consistently_oriented {
            out.push(format!("{} inconsistent edges are left", self.after.inconsistent_edges));
        }
        out
    }
}
