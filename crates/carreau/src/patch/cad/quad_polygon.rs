//! Rectilinear polygons of quads.

use crate::mesh::VertexId;

/// A rectilinear polygon of quads. Cells that lie side by side are joined only where `next` says so; else there is a
/// wall between them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct QuadPolygon {
    /// The cells, at most one per place.
    pub cells: Vec<QuadCell>,
}

/// A quad of a [`QuadPolygon`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct QuadCell {
    /// Row, counted upwards.
    pub row: i32,
    /// Column, counted to the right.
    pub col: i32,
    /// The mesh vertices at (row, col), (row, col + 1), (row + 1, col + 1), (row + 1, col).
    pub corners: [VertexId; 4],
    /// The cells across the bottom, right, top and left side; `u32::MAX` where there is a border or a wall.
    pub next: [u32; 4],
}
