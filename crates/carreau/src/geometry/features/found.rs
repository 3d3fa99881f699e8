//! What was found of features, for records and pictures.

use super::Noise;
use super::dropped::DroppedStrand;
use super::marked::Features;
use crate::mesh::{CornerId, SurfaceMesh, UnitScale};
use glam::DVec3;

/// The features of a model as it is, and what was no feature at the size of the elements.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FoundFeatures {
    /// Feature edges, by their ends.
    pub kept: Vec<[DVec3; 2]>,
    /// Edges above the angle that are none.
    pub dropped: Vec<[DVec3; 2]>,
    /// The longest strand of these.
    pub longest_dropped: Option<DroppedStrand>,
    /// How noisy the edges above the angle are; nothing where all of them count.
    pub noise: Noise,
}

impl FoundFeatures {
    /// What was found of a mesh.
    pub fn new(mesh: &SurfaceMesh, features: &Features) -> Self {
        let ends = |c: CornerId| [c, mesh.next(c)].map(|c| mesh.point(mesh.vertex(c)));
        FoundFeatures {
            kept: features.edges(mesh).map(ends).collect(),
            dropped: features.dropped.iter().map(|&c| ends(c)).collect(),
            longest_dropped: features.longest_dropped,
            noise: features.noise,
        }
    }

    /// The same in another unit.
    pub(crate) fn moved(mut self, scale: UnitScale) -> Self {
        let edges = self.kept.iter_mut().chain(&mut self.dropped);
        edges.flatten().for_each(|p| *p = scale.point(*p));
        self.longest_dropped = self
            .longest_dropped
            .map(|strand| DroppedStrand { length: scale.length(strand.length), place: scale.point(strand.place) });
        self
    }
}
