//! Nodes in the middle of edges and faces, and edges that had to stay straight.

use crate::mesh::{SecondOrder, UnitScale};
use crate::words::counted;
use glam::DVec3;
use serde::Serialize;

/// The nodes of a mesh of second order beyond its corners.
#[derive(Debug, Clone, PartialEq)]
pub struct MiddleOf {
    /// Which nodes cells and boundary faces have.
    pub nodes: SecondOrder,
    /// Where they are: edges, faces, cells; they are numbered after the vertices of the mesh.
    pub places: Vec<DVec3>,
}

/// Edges of cells of second order that stay straight, because a cell with a curved one would fold.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StraightEdges {
    /// Their number.
    pub count: usize,
    /// The middle of the first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at: Option<[f64; 3]>,
}

impl StraightEdges {
    pub(super) fn in_scale(mut self, scale: UnitScale) -> StraightEdges {
        self.at = self.at.map(|p| scale.point(DVec3::from(p)).to_array());
        self
    }

    /// What is to be said of them.
    pub(super) fn warning(&self) -> Option<String> {
        let [x, y, z] = self.at?;
        let edges = counted(self.count, "edge stays", "edges stay");
        Some(format!("{edges} straight, because a cell with a curved one would fold, first near {x:.6} {y:.6} {z:.6}"))
    }
}

impl MiddleOf {
    pub(super) fn in_scale(mut self, scale: UnitScale) -> MiddleOf {
        self.places.iter_mut().for_each(|p| *p = scale.point(*p));
        self
    }
}
