//! Gives every sheet at a vertex a vertex of its own: that of the file, if it had one.

use super::super::connectivity::copies_of_edge;
use super::super::half_edges::HalfEdges;
use super::super::id::VertexId;
use super::super::repair::Soup;
use super::super::surface::{SurfaceMesh, TaggedEdge};
use super::super::triangles::NONE;
use rustc_hash::FxHashMap;

/// A corner that stands for all of its sheet at its vertex, for every corner: the first.
pub(super) fn first_of_sheet(soup: &Soup, sheet: &[u32]) -> Vec<u32> {
    let mut first: FxHashMap<[u32; 2], u32> = FxHashMap::default();
    let corners = (0u32..).zip(soup.faces.corners().iter().zip(sheet));
    corners.map(|(c, (&v, &s))| *first.entry([v, s]).or_insert(c)).collect()
}

/// Divides vertices by the sheets of their corners. Returns how many vertices are copies.
pub(super) fn separate(soup: &mut Soup, original: &SurfaceMesh, sheet: &[u32]) -> usize {
    let old: Vec<u32> = soup.faces.corners().to_vec();
    // Where every vertex has one sheet there is nothing to do.
    let mut of_vertex = vec![NONE; soup.points.len()];
    let is_divided = |(&v, &s): (&u32, &u32)| {
        let known = &mut of_vertex[v as usize];
        *known = if *known == NONE { s } else { *known };
        *known != s
    };
    if !old.iter().zip(sheet).any(is_divided) {
        return 0;
    }
    let first = first_of_sheet(soup, sheet);
    let own: Vec<u32> = soup.corner_source.iter().map(|&c| original.faces().corners()[c as usize]).collect();
    // The file's vertex of every sheet: the first of those that its corners had.
    let mut source = vec![NONE; old.len()];
    first.iter().zip(&own).for_each(|(&u, &v)| source[u as usize] = source[u as usize].min(v));
    let mut firsts: Vec<u32> = (0..old.len() as u32).filter(|&c| first[c as usize] == c).collect();
    firsts.sort_by_key(|&c| (old[c as usize], source[c as usize], sheet[c as usize]));
    let mut number = old.clone();
    for sheets in firsts.chunk_by(|&a, &b| old[a as usize] == old[b as usize]).filter(|list| list.len() > 1) {
        for (k, &c) in sheets.iter().enumerate() {
            let (v, source) = (old[c as usize] as usize, source[c as usize]);
            let point = original.points()[source as usize];
            if k > 0 {
                number[c as usize] = soup.points.len() as u32;
                soup.points.push(point);
                soup.vertex_source.push(source);
            } else {
                (soup.points[v], soup.vertex_source[v]) = (point, source);
            }
        }
    }
    let new: Vec<u32> = first.iter().map(|&c| number[c as usize]).collect();
    let next = soup.faces.next_corners();
    soup.tagged = copies_of_tagged(&soup.tagged, &soup.half_edges(), &new, &next);
    soup.faces.corners_mut().copy_from_slice(&new);
    for (c, &v) in own.iter().enumerate().rev() {
        soup.vertex_image[v as usize] = new[c];
    }
    soup.in_order_of_source().len()
}

/// Every tagged edge once for each of the edges that it was divided into; free lines as they were.
fn copies_of_tagged(tagged: &[TaggedEdge], half_edges: &HalfEdges, new: &[u32], next: &[u32]) -> Vec<TaggedEdge> {
    let mut out = Vec::with_capacity(tagged.len());
    for edge in tagged {
        match copies_of_edge(edge.ends.map(|v| v.0), half_edges, new, next) {
            Some(copies) => {
                out.extend(copies.into_iter().map(|ends| TaggedEdge { ends: ends.map(VertexId), tag: edge.tag }));
            }
            None => out.push(*edge),
        }
    }
    out
}
