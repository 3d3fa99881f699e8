//! Where patches end: edges that none may cross, and creases that rectangles do not grow across.

use super::options::PatchOptions;
use crate::error::{Error, Result};
use crate::geometry::features::{FeatureOptions, feature_edges};
use crate::mesh::{CornerId, DisjointSets, SurfaceMesh};

/// A crease of fewer edges is noise: single sharp edges are scattered all over a scan.
const SHORTEST_CREASE: u32 = 5;

/// Whether each half-edge lies on an edge that no patch may cross: sharper than the feature angle, tagged or listed.
pub(super) fn barriers(mesh: &SurfaceMesh, options: &PatchOptions) -> Result<Vec<bool>> {
    let limits = FeatureOptions {
        angle_deg: options.feature_angle,
        creases: options.creases,
        borders: false,
        tags: options.tagged_edges,
        edges: options.feature_edges.clone(),
    };
    let tagged = limits.tags && !mesh.tagged_edges.is_empty();
    if limits.angle_deg.is_none() && limits.edges.is_empty() && !tagged {
        return Ok(vec![false; mesh.corner_count()]);
    }
    let features = feature_edges(mesh, &limits)?;
    let wanted = &options.feature_edges;
    match features.missing.iter().find(|edge| wanted.contains(edge) || wanted.contains(&[edge[1], edge[0]])) {
        Some([a, b]) => {
            Err(Error::input("the mesh has no such feature edge", format!("vertices {a} {b}"), "ids are 0-based"))
        }
        None => Ok(features.corners),
    }
}

/// The barriers, and the half-edges of creases: edges sharper than `angle` that hang together.
pub(super) fn creases(mesh: &SurfaceMesh, angle: f64, barriers: &[bool]) -> Result<Vec<bool>> {
    if angle >= 180.0 {
        return Ok(barriers.to_vec());
    }
    let limits = FeatureOptions { angle_deg: Some(angle), borders: false, tags: false, ..FeatureOptions::default() };
    let sharp = feature_edges(mesh, &limits)?.corners;
    let ends = |c: usize| [CornerId::new(c), mesh.next(CornerId::new(c))].map(|c| mesh.vertex(c).0);
    let mut sets = DisjointSets::new(mesh.vertex_count());
    let marked = || (0..sharp.len()).filter(|&c| sharp[c]);
    marked().for_each(|c| sets.union(ends(c)[0], ends(c)[1]));
    let crease = sets.leaders();
    // Both half-edges of an inner edge are marked: every edge counts twice.
    let mut half_edges = vec![0u32; mesh.vertex_count()];
    marked().for_each(|c| half_edges[crease[ends(c)[0] as usize] as usize] += 1);
    let long = |c: usize| half_edges[crease[ends(c)[0] as usize] as usize] >= 2 * SHORTEST_CREASE;
    Ok((0..sharp.len()).map(|c| barriers[c] || (sharp[c] && long(c))).collect())
}
