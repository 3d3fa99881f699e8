//! The patch: a grid of quads on the vertices of the input mesh.

use crate::mesh::{FaceId, NONE, Triangles, VertexId};
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

    /// Row and column of all cells, row by row.
    pub fn cell_places(&self) -> impl Iterator<Item = (u32, u32)> + use<> {
        let (rows, cols) = (self.rows, self.cols);
        (0..rows).flat_map(move |r| (0..cols).map(move |c| (r, c)))
    }

    /// The corners of all cells, row by row.
    pub fn cell_corners(&self) -> impl Iterator<Item = [VertexId; 4]> + '_ {
        self.cell_places().map(|(r, c)| self.cell(r, c))
    }

    /// The vertices along a side, counter-clockwise: 0 bottom, 1 right, 2 top, 3 left.
    pub fn side_vertices(&self, side: usize) -> Vec<VertexId> {
        let (m, n) = (self.rows, self.cols);
        match side % 4 {
            0 => (0..=n).map(|c| self.vertex(0, c)).collect(),
            1 => (0..=m).map(|r| self.vertex(r, n)).collect(),
            2 => (0..=n).rev().map(|c| self.vertex(m, c)).collect(),
            _ => (0..=m).rev().map(|r| self.vertex(r, 0)).collect(),
        }
    }

    /// The patch seen from behind: rows and columns exchanged.
    pub fn transposed(&self) -> Patch {
        let (rows, cols) = (self.cols, self.rows);
        let nodes = (0..=rows).flat_map(|r| (0..=cols).map(move |c| (c, r)));
        let cells = (0..rows).flat_map(|r| (0..cols).map(move |c| (c, r)));
        Patch {
            rows,
            cols,
            vertices: nodes.map(|(r, c)| self.vertex(r, c)).collect(),
            triangles: cells.flat_map(|(r, c)| self.cell_triangles(r, c)).collect(),
        }
    }

    /// The border as a closed loop of vertices, counter-clockwise from node (0, 0); the first is not repeated.
    pub fn border(&self) -> Vec<VertexId> {
        let mut border: Vec<VertexId> = Vec::new();
        for side in 0..4 {
            border.extend(self.side_vertices(side));
            border.pop();
        }
        border
    }

    /// The half-edges along a side, inside the patch, counter-clockwise.
    pub(super) fn side(&self, side: usize, triangles: Triangles) -> Vec<u32> {
        let (m, n) = (self.rows, self.cols);
        let cells: Vec<(u32, u32)> = match side % 4 {
            0 => (0..n).map(|c| (0, c)).collect(),
            1 => (0..m).map(|r| (r, n - 1)).collect(),
            2 => (0..n).rev().map(|c| (m - 1, c)).collect(),
            _ => (0..m).rev().map(|r| (r, 0)).collect(),
        };
        let half_edge = |(r, c): (u32, u32)| {
            let corners = self.cell(r, c);
            let (from, to) = (corners[side % 4].0, corners[(side + 1) % 4].0);
            let inside = self.cell_triangles(r, c).into_iter().flat_map(|t| [3 * t.0, 3 * t.0 + 1, 3 * t.0 + 2]);
            inside.into_iter().find(|&h| triangles.vertex(h) == from && triangles.vertex(triangles.next(h)) == to)
        };
        cells.into_iter().filter_map(half_edge).collect()
    }

    /// The same patch turned by a quarter, `turns` times: what was side `s` becomes side `s + turns`.
    ///
    /// ```text
    ///  d ── c          a ── d
    ///  │    │   → 1 →  │    │
    ///  a ── b          b ── c      (a at (0, 0) goes to (0, 1))
    /// ```
    pub fn turned(&self, turns: usize) -> Patch {
        let mut patch = self.clone();
        for _ in 0..turns % 4 {
            let old = patch;
            let mut grid = Grid::new(old.cols, old.rows);
            for (r, c) in old.cell_places() {
                let [bl, br, tr, tl] = old.cell(r, c);
                grid.set(c, old.rows - 1 - r, [tl, bl, br, tr], old.cell_triangles(r, c));
            }
            patch = grid.finish();
        }
        patch
    }
}

/// Fills a patch cell by cell.
pub(super) struct Grid(Patch);

impl Grid {
    /// A grid with all cells to be set.
    pub fn new(rows: u32, cols: u32) -> Self {
        let (m, n) = (rows as usize, cols as usize);
        let (vertices, triangles) = (vec![VertexId(NONE); (m + 1) * (n + 1)], vec![FaceId(NONE); 2 * m * n]);
        Grid(Patch { rows, cols, vertices, triangles })
    }

    /// Sets a cell: corners counter-clockwise from the bottom left, and its two triangles.
    pub fn set(&mut self, row: u32, col: u32, corners: [VertexId; 4], triangles: [FaceId; 2]) {
        let width = self.0.cols + 1;
        for ([r, c], v) in [[0, 0], [0, 1], [1, 1], [1, 0]].into_iter().zip(corners) {
            self.0.vertices[((row + r) * width + col + c) as usize] = v;
        }
        let cell = 2 * (row * self.0.cols + col) as usize;
        self.0.triangles[cell..cell + 2].copy_from_slice(&triangles);
    }

    /// The patch.
    pub fn finish(self) -> Patch {
        self.0
    }
}
