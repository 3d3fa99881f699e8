//! The patch: a grid of quads on the vertices of the input mesh.

use crate::mesh::{FaceId, VertexId};
use serde::Serialize;

/// A grid of `rows × cols` quads, each the union of two triangles of the input.
///
/// Vertices are stored row by row. Cell (r, c) has the corners (r, c), (r, c+1), (r+1, c+1), (r+1, c), counter-clockwise
/// in the sense of its triangles:
///
/// ```text
///  (r+1,c) ──── (r+1,c+1)
///     │            │
///   (r,c) ───── (r,c+1)
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Patch {
    /// Number of cells in a column.
    pub rows: u32,
    /// Number of cells in a row.
    pub cols: u32,
    /// `(rows + 1)(cols + 1)` vertices, row by row.
    pub vertices: Vec<VertexId>,
    /// `2 · rows · cols` triangles, two per cell, row by row.
    pub triangles: Vec<FaceId>,
}

impl Patch {
    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.rows as usize * self.cols as usize
    }

    /// The vertex at a grid node.
    #[inline]
    pub fn vertex(&self, row: u32, col: u32) -> VertexId {
        self.vertices[(row * (self.cols + 1) + col) as usize]
    }

    /// The corners of a cell, counter-clockwise.
    #[inline]
    pub fn cell(&self, row: u32, col: u32) -> [VertexId; 4] {
        [self.vertex(row, col), self.vertex(row, col + 1), self.vertex(row + 1, col + 1), self.vertex(row + 1, col)]
    }

    /// The two triangles of a cell.
    #[inline]
    pub fn cell_triangles(&self, row: u32, col: u32) -> [FaceId; 2] {
        let k = 2 * (row * self.cols + col) as usize;
        [self.triangles[k], self.triangles[k + 1]]
    }

    /// The corners of all cells, row by row.
    pub fn cell_corners(&self) -> impl Iterator<Item = [VertexId; 4]> + '_ {
        (0..self.rows).flat_map(move |r| (0..self.cols).map(move |c| self.cell(r, c)))
    }

    /// The border as a closed loop of vertices, counter-clockwise from node (0, 0); the first is not repeated.
    pub fn border(&self) -> Vec<VertexId> {
        let (m, n) = (self.rows, self.cols);
        let bottom = (0..n).map(|c| (0, c));
        let right = (0..m).map(|r| (r, n));
        let top = (1..=n).rev().map(|c| (m, c));
        let left = (1..=m).rev().map(|r| (r, 0));
        bottom.chain(right).chain(top).chain(left).map(|(r, c)| self.vertex(r, c)).collect()
    }
}
