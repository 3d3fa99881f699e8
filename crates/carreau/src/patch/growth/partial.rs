//! What is known of a patch while it grows.

use crate::mesh::NONE;
use crate::patch::grid::Patch;

/// State of a triangle that joins its left neighbour.
pub const JOINS_LEFT: usize = 0;
/// State of a triangle that joins its right neighbour.
pub const JOINS_RIGHT: usize = 1;

/// One cell above a border edge.
#[derive(Clone, Copy)]
pub struct Above {
    /// Half-edge of T on the border edge, running against the side.
    pub(super) base: u32,
    /// Half-edge of the diagonal, in T, and its opposite in P.
    pub(super) diagonal: u32,
    pub(super) partner: u32,
    pub(super) left: u32,
    pub(super) right: u32,
    pub(super) top: u32,
}

/// What the inner loop reads of a triangle: all of it in one cache line, for rectangles are grown all over the mesh.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub struct Node {
    /// For each half-edge the one across, unless a border or a barrier is in the way.
    pub(super) across: [u32; 3],
    /// [`USED`] in a finished patch, the current epoch in the rectangle being grown.
    pub(super) mark: u32,
    /// For each half-edge the cost of the pair; infinite if the pair is no candidate.
    pub(super) cost: [f64; 3],
}

/// One way to build the row so far: what the next cell's left side must be, and the total cost.
#[derive(Clone, Copy)]
pub struct Partial {
    pub(super) joint: u32,
    pub(super) total: f64,
}

/// A partial row that cannot be.
pub const IMPOSSIBLE: Partial = Partial { joint: NONE, total: f64::INFINITY };

/// A row or column added to a side.
pub struct Layer {
    pub(super) side: usize,
    /// `base` and `diagonal` of every cell, along the side.
    pub(super) cells: Vec<(u32, u32)>,
}

/// What a rectangle starts from.
pub enum Base {
    /// The pair of triangles across a half-edge.
    Pair(u32),
    /// A finished patch.
    Patch(Patch),
}
