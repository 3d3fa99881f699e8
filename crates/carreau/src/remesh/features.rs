//! Which edges stay: borders, ridges by angle, tagged edges, edges between labels, seams of what is not manifold.

use super::RemeshOptions;
use super::curves::{Kind, Marks};
use crate::error::{Error, Result};
use crate::geometry::features::{FeatureOptions, feature_edges};
use crate::mesh::{Column, CornerId, Side, SurfaceMesh};

/// The kind of curve that every half-edge of a triangular mesh lies on.
pub fn mark(mesh: &SurfaceMesh, options: &RemeshOptions) -> Result<Marks> {
    let wanted = FeatureOptions {
        angle_deg: (options.feature_angle < 180.0).then_some(options.feature_angle),
        borders: true,
        tags: options.tags,
        edges: Vec::new(),
    };
    let features = feature_edges(mesh, &wanted)?;
    let labels = match &options.labels {
        None => None,
        Some(name) => match mesh.attributes.face.get(name) {
            Some(Column::Label(labels)) => Some(labels),
            _ => return Err(Error::Options(format!("the mesh has no face property '{name}' of integers"))),
        },
    };
    let kind = |c: usize| {
        let c = CornerId::new(c);
        match mesh.side(c) {
            Side::Border => Some(Kind::Border),
            Side::Inconsistent | Side::NonManifold => Some(Kind::Seam),
            Side::Inner(o) => {
                let label = |c: CornerId| labels.map(|l| l[mesh.face_of(c).index()]);
                (features.contains(c) || label(c) != label(o)).then_some(Kind::Ridge)
            }
        }
    };
    Ok((0..mesh.corner_count()).map(kind).collect())
}
