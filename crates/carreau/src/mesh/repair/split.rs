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
use crate::mesh::connectivity::umbrellas;
use crate::mesh::half_edges::HalfEdges;
use crate::mesh::id::VertexId;
use crate::mesh::surface::TaggedEdge;

/// Duplicates vertices until no edge has more than two faces and no vertex more than one umbrella. Returns the number of
/// new vertices. Faces that use a vertex twice are left alone.
pub fn into_sheets(soup: &mut Soup) -> usize {
    let half_edges = soup.half_edges();
    let repeats = soup.faces_with_repeats();
    let umbrella = umbrellas(&soup.faces, &half_edges, &repeats, |_, sides| sides <= 2);
    let face_of = soup.faces.face_of_corners();
    let old = soup.faces.corners().to_vec();
    let mut new_id = old.clone();
    // The first umbrella of a vertex keeps it, the others follow in the order of vertices, then faces: an order that does
    // not depend on where a face begins or which way it turns.
    let named = |c: &u32| umbrella[*c as usize] == *c && !repeats[face_of[*c as usize] as usize];
    let mut firsts: Vec<u32> = (0..old.len() as u32).filter(named).collect();
    firsts.sort_by_key(|&c| (old[c as usize], c));
    let before = soup.points.len();
    for of_vertex in firsts.chunk_by(|&a, &b| old[a as usize] == old[b as usize]) {
        for &c in &of_vertex[1..] {
            let v = old[c as usize] as usize;
            new_id[c as usize] = soup.points.len() as u32;
            soup.points.push(soup.points[v]);
            soup.vertex_source.push(soup.vertex_source[v]);
        }
    }
    for c in 0..old.len() {
        new_id[c] = new_id[umbrella[c] as usize];
    }
    let added = soup.points.len() - before;
    if added > 0 {
        let next = soup.faces.next_corners();
        soup.tagged = copies_of_tagged(&soup.tagged, &half_edges, &new_id, &next);
        soup.faces.corners_mut().copy_from_slice(&new_id);
    }
    added
}

/// Every tagged edge once for each of the edges it was cut into; free lines as they were.
fn copies_of_tagged(tagged: &[TaggedEdge], half_edges: &HalfEdges, new_id: &[u32], next: &[u32]) -> Vec<TaggedEdge> {
    let mut out = Vec::with_capacity(tagged.len());
    for edge in tagged {
        let [a, b] = edge.ends;
        let Some(group) = half_edges.find(a.0, b.0) else {
            out.push(*edge);
            continue;
        };
        let mut copies: Vec<[u32; 2]> = group
            .corners()
            .map(|c| [new_id[c as usize], new_id[next[c as usize] as usize]])
            .map(|[p, q]| [p.min(q), p.max(q)])
            .collect();
        copies.sort_unstable();
        copies.dedup();
        out.extend(copies.into_iter().map(|ends| TaggedEdge { ends: ends.map(VertexId), tag: edge.tag }));
    }
    out
}
