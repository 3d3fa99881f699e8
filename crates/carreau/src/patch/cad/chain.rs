//! Edges to be: the borders of all pieces, cut at nodes into chains that two pieces share.
//!
//! A node is a corner of a piece, or a vertex where other than two border edges meet. Between nodes the same two pieces
//! lie on both sides of a border, so a chain of mesh edges there becomes one edge of the model:
//!
//! ```text
//!    ┌───────●────┐
//!    │   A   │ B  │        ● nodes in the middle of a side ("T-nodes");
//!    ●───────●────●        A ┆ C is one chain, B ┆ C another
//!    │       C    │
//!    └────────────┘
//! ```

use super::piece::Piece;
use crate::mesh::NONE;

/// All chains, and how the borders of the pieces are composed of them.
pub struct Chains {
    /// Mesh vertices of every chain, from node to node.
    pub paths: Vec<Vec<u32>>,
    /// For every piece and loop: its chains in order.
    pub loops: Vec<Vec<Vec<ChainUse>>>,
    /// The pieces on both sides of every chain; the second is `None` on borders and on irregular edges, where every
    /// piece has a chain of its own.
    pub sides: Vec<(u32, Option<u32>)>,
}

/// A chain as a part of a loop.
#[derive(Debug, Clone, Copy)]
pub struct ChainUse {
    /// The chain.
    pub chain: u32,
    /// Whether the loop runs against it.
    pub reversed: bool,
    /// Where in the outline the use begins.
    pub start: u32,
}

/// One side of a mesh edge on the border of a piece.
struct Segments {
    /// First segment of every outline, in the order of pieces and loops.
    first: Vec<u32>,
    /// The same mesh edge as the border of another piece, run the opposite way, if there is exactly one.
    partner: Vec<u32>,
    /// Per mesh vertex: whether chains end there.
    node: Vec<bool>,
}

impl Segments {
    fn new(pieces: &[Piece], vertices: usize) -> Self {
        let mut keys: Vec<(u64, u32)> = Vec::new();
        let mut forward = Vec::new();
        let mut first = Vec::new();
        let mut node = vec![false; vertices];
        for outline in pieces.iter().flat_map(|p| &p.loops) {
            first.push(keys.len() as u32);
            let n = outline.vertices.len();
            for (k, &a) in outline.vertices.iter().enumerate() {
                let b = outline.vertices[(k + 1) % n];
                keys.push((u64::from(a.min(b)) << 32 | u64::from(a.max(b)), keys.len() as u32));
                forward.push(a < b);
                node[a as usize] |= outline.corner[k];
            }
        }
        keys.sort_unstable();
        let mut partner = vec![NONE; keys.len()];
        let mut degree = vec![0u32; vertices];
        for edge in keys.chunk_by(|a, b| a.0 == b.0) {
            degree[(edge[0].0 >> 32) as usize] += 1;
            degree[(edge[0].0 & 0xffff_ffff) as usize] += 1;
            if let [(_, a), (_, b)] = *edge
                && forward[a as usize] != forward[b as usize]
            {
                partner[a as usize] = b;
                partner[b as usize] = a;
            }
        }
        for (node, degree) in node.iter_mut().zip(degree) {
            *node |= degree != 2;
        }
        Segments { first, partner, node }
    }
}

/// Cuts the borders of the pieces into chains.
pub fn chains(pieces: &[Piece], vertices: usize) -> Chains {
    let segments = Segments::new(pieces, vertices);
    let mut chain_of = vec![NONE; segments.partner.len()];
    let mut out = Chains { paths: Vec::new(), loops: Vec::with_capacity(pieces.len()), sides: Vec::new() };
    let mut firsts = segments.first.iter();
    for (piece, loops) in pieces.iter().map(|p| &p.loops).enumerate() {
        let mut uses = Vec::with_capacity(loops.len());
        for (outline, &first) in loops.iter().zip(&mut firsts) {
            let mut of_loop = Vec::new();
            for run in runs(&outline.vertices, &segments.node) {
                let start = run.start;
                let segment = |k: u32| (first + k % outline.vertices.len() as u32) as usize;
                let other = segments.partner[segment(start)];
                let path = run.clone().chain([run.end]).map(|k| outline.vertices[k as usize % outline.vertices.len()]);
                let known = if other == NONE { NONE } else { chain_of[other as usize] };
                let shared = out.paths.get(known as usize).is_some_and(|p| p.iter().rev().copied().eq(path.clone()));
                let chain = if shared { known } else { out.paths.len() as u32 };
                if shared {
                    out.sides[chain as usize].1 = Some(piece as u32);
                } else {
                    out.paths.push(path.collect());
                    out.sides.push((piece as u32, None));
                }
                run.for_each(|k| chain_of[segment(k)] = chain);
                of_loop.push(ChainUse { chain, reversed: shared, start });
            }
            uses.push(of_loop);
        }
        out.loops.push(uses);
    }
    out
}

/// The outline from node to node, as ranges of its segments; the last range may run past the end, round to the first
/// node.
fn runs(vertices: &[u32], node: &[bool]) -> Vec<std::ops::Range<u32>> {
    let n = vertices.len() as u32;
    let nodes: Vec<u32> = (0..n).filter(|&k| node[vertices[k as usize] as usize]).collect();
    let ends = nodes.iter().skip(1).copied().chain(nodes.first().map(|&k| k + n));
    nodes.iter().zip(ends).map(|(&a, b)| a..b).collect()
}
