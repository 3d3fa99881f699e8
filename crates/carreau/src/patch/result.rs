//! What is found.

use super::cad::QuadPolygon;
use super::grid::Patch;
use super::statistics::Figures;
use crate::mesh::FaceId;

/// A decomposition into patches.
#[derive(Debug, Clone)]
pub struct PatchResult {
    /// The patches, largest first.
    pub patches: Vec<Patch>,
    /// Triangles that belong to no patch, in order.
    pub leftover: Vec<FaceId>,
    /// The polygons that the patches were cut from, for trimmed surfaces; `None` for [`Strategy::Grow`](super::Strategy::Grow), which has none.
    pub polygons: Option<PolygonLayout>,
    /// The figures of the layout.
    pub figures: Figures,
}

/// Rectilinear polygons of at least the smallest number of cells, and the triangles in none of them.
#[derive(Debug, Clone, Default)]
pub struct PolygonLayout {
    /// The polygons.
    pub polygons: Vec<QuadPolygon>,
    /// Triangles that belong to no polygon, in order.
    pub leftover: Vec<FaceId>,
}
