//! Boundary polylines: every edge between two regions, and every open border, exactly once.

use super::surface::Surface;
use crate::mesh::{NONE, VertexId};
use rustc_hash::FxHashMap;

/// A polyline between two regions, or on the open border of one.
#[derive(Debug, Clone, PartialEq)]
pub struct Boundary {
    /// The two regions, smaller first; `None` on an open border.
    pub regions: (u32, Option<u32>),
    /// The vertices in order; a closed polyline does not repeat the first.
    pub vertices: Vec<VertexId>,
    /// Whether the last vertex is joined to the first.
    pub closed: bool,
    /// Share of the length on sharp edges.
    pub sharp: f64,
}

/// An edge of a boundary.
#[derive(Clone, Copy)]
struct Piece {
    regions: (u32, u32),
    ends: [u32; 2],
    sharp: bool,
}

/// Chains the edges between regions into polylines that end where three or more meet.
pub fn boundaries(surface: &Surface<'_>, label: &[u32], sharp: &[bool]) -> Vec<Boundary> {
    let pieces = pieces(surface, label, sharp);
    // Vertices where a polyline ends: other than two pieces, or two of different regions.
    let mut at: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
    for (k, piece) in pieces.iter().enumerate() {
        piece.ends.iter().for_each(|&v| at.entry(v).or_default().push(k as u32));
    }
    let through = |v: u32, k: u32| -> Option<u32> {
        match at[&v][..] {
            [a, b] if a != b => {
                let other = if a == k { b } else { a };
                (pieces[other as usize].regions == pieces[k as usize].regions).then_some(other)
            }
            _ => None,
        }
    };
    let mut used = vec![false; pieces.len()];
    let mut out = Vec::new();
    let chain = |start: u32, from: u32, used: &mut [bool]| {
        let (mut k, mut v) = (start, from);
        let mut vertices = vec![from];
        let (mut length, mut sharp_length) = (0.0, 0.0);
        loop {
            used[k as usize] = true;
            let piece = pieces[k as usize];
            let l = surface.triangles.points()[piece.ends[0] as usize]
                .distance(surface.triangles.points()[piece.ends[1] as usize]);
            length += l;
            sharp_length += if piece.sharp { l } else { 0.0 };
            v = piece.ends[0] + piece.ends[1] - v;
            vertices.push(v);
            match through(v, k) {
                Some(next) if !used[next as usize] => k = next,
                _ => break,
            }
        }
        let closed = vertices.len() > 3 && vertices[0] == v && through(v, k) == Some(start);
        if closed {
            vertices.pop();
        }
        let (a, b) = pieces[start as usize].regions;
        Boundary {
            regions: (a, (b != NONE).then_some(b)),
            vertices: vertices.into_iter().map(VertexId).collect(),
            closed,
            sharp: if length > 0.0 { sharp_length / length } else { 0.0 },
        }
    };
    // Open polylines first, from their ends; what is left is closed.
    for k in 0..pieces.len() as u32 {
        for v in pieces[k as usize].ends {
            if !used[k as usize] && through(v, k).is_none() {
                out.push(chain(k, v, &mut used));
            }
        }
    }
    for k in 0..pieces.len() as u32 {
        if !used[k as usize] {
            out.push(chain(k, pieces[k as usize].ends[0], &mut used));
        }
    }
    out.sort_by_key(|a| (a.regions.0, a.regions.1.unwrap_or(NONE)));
    out
}

/// The edges with two faces of different regions (whatever their sense), and those with one face.
fn pieces(surface: &Surface<'_>, label: &[u32], sharp: &[bool]) -> Vec<Piece> {
    use crate::mesh::{CornerId, Side};
    let t = surface.triangles;
    let mut pieces = Vec::new();
    let mut irregular = false;
    for c in 0..3 * t.len() as u32 {
        let ends = [t.vertex(c), t.vertex(t.next(c))];
        let own = label[c as usize / 3];
        match surface.mesh.side(CornerId(c)) {
            Side::Inner(o) => {
                let other = label[o.index() / 3];
                if c < o.0 && own != other {
                    pieces.push(Piece { regions: (own.min(other), own.max(other)), ends, sharp: sharp[c as usize] });
                }
            }
            Side::Border => pieces.push(Piece { regions: (own, NONE), ends, sharp: true }),
            Side::Inconsistent | Side::NonManifold => irregular = true,
        }
    }
    if irregular {
        for edge in surface.mesh.half_edges().groups().filter(|e| e.len() == 2 && e.ends[0] != e.ends[1]) {
            let [a, b] = [edge.corners().next(), edge.corners().nth(1)].map(Option::unwrap_or_default);
            let (own, other) = (label[a as usize / 3], label[b as usize / 3]);
            if surface.mesh.side(CornerId(a)) == Side::Inconsistent && own != other {
                pieces.push(Piece { regions: (own.min(other), own.max(other)), ends: edge.ends, sharp: true });
            }
        }
    }
    pieces
}
