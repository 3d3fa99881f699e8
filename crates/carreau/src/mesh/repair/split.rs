//! Step 5: the surface is cut into manifold sheets.
//!
//! Guéziec, Taubin, Lazarus, Horn, "Cutting and Stitching: Converting Sets of Polygons to Manifold Surfaces", IEEE TVCG
//! 2001, global cutting: corners of a vertex stay together only where a chain of regular edges links their faces; every
//! further chain gets a vertex of its own.
//!
//! ```text
//!   ╲ │ ╱            ╲ │ ╱
//!    ╲│╱              ╲│╱
//!     •       →        •        two umbrellas, two vertices at one place
//!    ╱│╲               •
//!   ╱ │ ╲             ╱│╲
//! ```
//!
//! A chain has at most two ends, so an edge between two new vertices has at most two faces: no stitching is needed for
//! the result to be manifold, and two bodies that touch along an edge come apart as two closed bodies.

use super::soup::Soup;
use crate::mesh::connectivity::{copies_of_edge, umbrellas, vertices_of_umbrellas};
use crate::mesh::half_edges::HalfEdges;
use crate::mesh::id::VertexId;
use crate::mesh::surface::TaggedEdge;

/// Duplicates vertices until no edge has more than two faces and no vertex more than one umbrella. Returns the number of
/// new vertices. Faces that use a vertex twice are left alone.
pub fn into_sheets(soup: &mut Soup) -> usize {
    let half_edges = soup.half_edges();
    let repeats = soup.faces_with_repeats();
    let umbrella = umbrellas(&soup.faces, &half_edges, &repeats, |_, sides| sides <= 2);
    let (new_id, copied) = vertices_of_umbrellas(&soup.faces, &umbrella, &repeats, soup.points.len());
    for &v in &copied {
        soup.points.push(soup.points[v as usize]);
        soup.vertex_source.push(soup.vertex_source[v as usize]);
    }
    if !copied.is_empty() {
        let next = soup.faces.next_corners();
        soup.tagged = copies_of_tagged(&soup.tagged, &half_edges, &new_id, &next);
        soup.faces.corners_mut().copy_from_slice(&new_id);
    }
    copied.len()
}

/// Every tagged edge once for each of the edges it was cut into; free lines as they were.
pub fn copies_of_tagged(
    tagged: &[TaggedEdge],
    half_edges: &HalfEdges,
    new_id: &[u32],
    next: &[u32],
) -> Vec<TaggedEdge> {
    let mut out = Vec::with_capacity(tagged.len());
    for edge in tagged {
        match copies_of_edge(edge.ends.map(|v| v.0), half_edges, new_id, next) {
            Some(copies) => {
                out.extend(copies.into_iter().map(|ends| TaggedEdge { ends: ends.map(VertexId), tag: edge.tag }));
            }
            None => out.push(*edge),
        }
    }
    out
}
