//! What a hex mesh achieves.

use super::Padding;
use crate::geometry::hexes::{Corners, scaled_jacobian, volume};
use crate::mesh::{HexMesh, irregular_hex_edges};
use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeMap;

/// Counts and quality of a hex mesh; the result record's own part.
#[derive(Debug, Clone, Serialize)]
pub struct Figures {
    /// Number of cells.
    pub hexes: usize,
    /// Number of vertices.
    pub vertices: usize,
    /// Number of boundary faces.
    pub boundary_quads: usize,
    /// Segments of the skeleton that was meshed.
    pub segments: usize,
    /// Branchings that are cubic junctions.
    pub cubic_junctions: usize,
    /// Where a layer was put.
    pub padding: Padding,
    /// What the cells are worth.
    #[serde(flatten)]
    pub quality: HexQuality,
    /// Largest distance between the boundary and the surface, either way, as a share of the surface's diagonal; only where
    /// there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance_max: Option<f64>,
    /// Mean distance from the surface to the boundary, as a share of the diagonal.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance_mean: Option<f64>,
    /// Volume of the cells over that of the surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub volume_ratio: Option<f64>,
}

impl Figures {
    /// The figures of a mesh with its boundary.
    pub fn of(mesh: &HexMesh, segments: usize, padding: Padding, uncertified: Vec<u32>) -> Figures {
        Figures {
            cubic_junctions: 0,
            hexes: mesh.hexes.len(),
            vertices: mesh.points.len(),
            boundary_quads: mesh.quads.len(),
            segments,
            padding,
            quality: HexQuality::of(&mesh.points, &mesh.hexes, &mesh.quads, uncertified),
            distance_max: None,
            distance_mean: None,
            volume_ratio: None,
        }
    }
}

/// What the cells of a hexahedral mesh are worth.
#[derive(Debug, Clone, Serialize)]
pub struct HexQuality {
    /// Whether the Jacobian of every cell is proven positive.
    pub certified: bool,
    /// The cells without that proof.
    pub uncertified: Vec<u32>,
    /// Smallest scaled Jacobian of all corners of all cells.
    pub scaled_jacobian_min: f64,
    /// Mean over the cells of the smallest of their corners.
    pub scaled_jacobian_mean: f64,
    /// Cells with a corner that is not positive.
    pub inverted: usize,
    /// Sum of the volumes of the cells.
    pub volume: f64,
    /// Edges off the boundary with other than four cells, by that number.
    pub irregular_edges: BTreeMap<u32, usize>,
}

impl HexQuality {
    /// The quality of cells with their boundary faces, and the cells without a certificate.
    pub(super) fn of(points: &[DVec3], hexes: &[[u32; 8]], quads: &[[u32; 4]], uncertified: Vec<u32>) -> Self {
        let corners = |h: &[u32; 8]| -> Corners { h.map(|v| points[v as usize]) };
        let of_cell = |h| [scaled_jacobian(&corners(h)), volume(&corners(h))];
        let shapes: Vec<[f64; 2]> = hexes.par_iter().map(of_cell).collect();
        let jacobians = || shapes.iter().map(|s| s[0]);
        HexQuality {
            certified: uncertified.is_empty(),
            uncertified,
            scaled_jacobian_min: jacobians().fold(f64::INFINITY, f64::min),
            scaled_jacobian_mean: jacobians().sum::<f64>() / hexes.len().max(1) as f64,
            inverted: jacobians().filter(|j| *j <= 0.0).count(),
            volume: shapes.iter().map(|s| s[1]).sum(),
            irregular_edges: irregular_edges(hexes, quads),
        }
    }
}

/// Interior edges by their number of cells, four left out.
fn irregular_edges(hexes: &[[u32; 8]], quads: &[[u32; 4]]) -> BTreeMap<u32, usize> {
    let mut found = BTreeMap::new();
    irregular_hex_edges(hexes, quads).into_iter().for_each(|(_, cells)| *found.entry(cells).or_default() += 1);
    found
}
