//! The result of the room.

use super::figures::Figures;
use super::middle_nodes::MiddleOf;
use crate::mesh::{CurveNet, HexMesh, RawMesh, UnitScale};

/// A hex mesh of a skeleton.
#[derive(Debug, Clone)]
pub struct HexResult {
    /// The mesh: boundary quads tagged 1 on the wall, 2, 3 … on the ends.
    pub mesh: HexMesh,
    /// The skeleton that was meshed, after clean-up.
    pub skeleton: CurveNet,
    /// Counts, quality and distance of the mesh.
    pub figures: Figures,
    /// Warnings for the user, one sentence each.
    pub warnings: Vec<String>,
    /// For every boundary face the face of the surface's own boundary that it continues: itself, except on pieces added at
    /// ends.
    pub origins: Vec<u32>,
    /// Tags of the ends that are flat pieces of a closed surface, not open ends.
    pub flat_caps: Vec<i32>,
    /// The nodes of second order, if asked for.
    pub second_order: Option<MiddleOf>,
    /// For every vertex in a boundary layer the wall vertex above it, for every vertex of an added piece the end vertex that
    /// it was drawn from; for all others themselves.
    pub(super) bases: Vec<u32>,
}

impl HexResult {
    /// What is written into a file: the mesh, with its nodes of second order where it has some.
    pub fn raw(&self) -> RawMesh {
        let raw = RawMesh::from(self.mesh.clone());
        match &self.second_order {
            Some(middle) => raw.with_second_order(middle.nodes.clone(), &middle.places),
            None => raw,
        }
    }

    /// The result in another scale.
    pub(super) fn in_scale(mut self, scale: UnitScale) -> HexResult {
        self.mesh.points.iter_mut().for_each(|p| *p = scale.point(*p));
        self.figures.in_scale(scale);
        self.second_order = self.second_order.take().map(|s| s.in_scale(scale));
        HexResult { skeleton: scale.moved_net(self.skeleton), ..self }
    }
}
