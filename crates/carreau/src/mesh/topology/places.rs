//! Where the defects of a surface are.

use crate::mesh::id::{FaceId, VertexId};
use serde::Serialize;

/// How many places of a defect are kept.
pub const PLACES: usize = 10;

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

/// Keeps the first places and returns the number of all.
pub fn note<T>(places: &mut Vec<T>, found: impl Iterator<Item = T>) -> usize {
    let mut count = 0;
    for place in found {
        count += 1;
        if places.len() < PLACES {
            places.push(place);
        }
    }
    count
}

pub fn longest(loops: &[BoundaryLoop]) -> Vec<BoundaryLoop> {
    let mut sorted = loops.to_vec();
    sorted.sort_by(|a, b| b.length.total_cmp(&a.length).then(a.start.cmp(&b.start)));
    sorted.truncate(PLACES);
    sorted
}
