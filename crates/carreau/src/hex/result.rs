//! What the room gives back.

use super::figures::Figures;
use super::judge;
use super::second_order::MiddleOf;
use crate::mesh::{CurveNet, HexMesh, RawMesh, UnitScale};

/// A hex mesh of a skeleton.
#[derive(Debug, Clone)]
pub struct HexResult {
    /// The mesh: boundary quads tagged 1 on the wall, 2, 3 … on the ends.
    pub mesh: HexMesh,
    /// The skeleton that was meshed, after clean-up.
    pub skeleton: CurveNet,
    /// What the mesh achieves.
    pub figures: Figures,
    /// What the user should know.
    pub warnings: Vec<String>,
    /// For every boundary face the one that it continues: itself, but for those that lengthen an end.
    pub origins: Vec<u32>,
    /// The tags of ends that are flat pieces of the surface itself, and no open ends.
    pub flat_caps: Vec<i32>,
    /// The nodes of second order, where they were asked for.
    pub second_order: Option<MiddleOf>,
    /// For every vertex the one of the wall that it lies under in a layer, or of an end that it was drawn from; else itself.
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
        self.figures.quality.volume = scale.back().volume(self.figures.quality.volume);
        judge::in_scale(&mut self, scale);
        self.second_order = self.second_order.take().map(|s| s.in_scale(scale));
        HexResult { skeleton: scale.moved_net(self.skeleton), ..self }
    }
}
