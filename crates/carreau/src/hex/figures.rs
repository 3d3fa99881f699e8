//! Counts and quality of a hex mesh.

use super::Padding;
use super::layers::LayerFigures;
use super::middle_nodes::StraightEdges;
use super::overlap::{Uncovered, overlapping};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::hexes::{Corners, scaled_jacobian, uncertified, volume};
use crate::mesh::{HexMesh, UnitScale, irregular_hex_edges};
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
    /// Thickness of the boundary layers, if asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub layers: Option<LayerFigures>,
    /// Edges of second-order cells that stay straight, if such cells were asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub straight_edges: Option<StraightEdges>,
    /// Quality of the cells.
    #[serde(flatten)]
    pub quality: HexQuality,
    /// Largest distance between the boundary and the surface, either way, as a share of the surface's diagonal; only where
    /// there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance_max: Option<f64>,
    /// The place of that distance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance_max_at: Option<[f64; 3]>,
    /// The parts of the surface that are farther from the cells than allowed, the farthest first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub uncovered: Vec<Uncovered>,
    /// Mean distance from the surface to the boundary, as a share of the diagonal.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance_mean: Option<f64>,
    /// Volume of the cells over that of the surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub volume_ratio: Option<f64>,
}

impl Figures {
    /// The places, lengths and volumes in another scale.
    pub(super) fn in_scale(&mut self, scale: UnitScale) {
        let moved = |p: [f64; 3]| scale.point(DVec3::from(p)).to_array();
        self.quality.volume = scale.back().volume(self.quality.volume);
        self.distance_max_at = self.distance_max_at.map(moved);
        self.layers = self.layers.take().map(|l| l.in_scale(scale));
        self.straight_edges = self.straight_edges.take().map(|s| s.in_scale(scale));
        self.uncovered.iter_mut().for_each(|part| part.at = moved(part.at));
    }

    /// The figures of a mesh with its boundary.
    ///
    /// # Errors
    /// [`Error::Cancelled`](crate::Error::Cancelled), [`Error::Deadline`](crate::Error::Deadline).
    pub fn of(mesh: &HexMesh, segments: usize, padding: Padding, context: &Context) -> Result<Figures> {
        Ok(Figures {
            cubic_junctions: 0,
            hexes: mesh.hexes.len(),
            vertices: mesh.points.len(),
            boundary_quads: mesh.quads.len(),
            segments,
            padding,
            layers: None,
            straight_edges: None,
            quality: HexQuality::of(&mesh.points, &mesh.hexes, &mesh.quads, context)?,
            distance_max: None,
            distance_max_at: None,
            uncovered: Vec::new(),
            distance_mean: None,
            volume_ratio: None,
        })
    }
}

impl Figures {
    /// One line on distances, volume and overlap.
    pub fn verdict(&self) -> String {
        let overlap = match self.quality.overlap {
            share if share > 0.0 => format!("{:.2}% of the volume is covered twice", 100.0 * share),
            _ => "nothing is covered twice".into(),
        };
        let distance =
            self.distance_max.map(|d| format!("at most {:.2}% of the diagonal from the surface, ", 100.0 * d));
        let volume = self.volume_ratio.map(|v| format!("{:.1}% of its volume, ", 100.0 * v));
        [distance.unwrap_or_default(), volume.unwrap_or_default(), overlap].concat()
    }
}

/// Quality of the cells of a hexahedral mesh.
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
    /// Number of cells with a scaled Jacobian of zero or less at a corner.
    pub inverted: usize,
    /// Sum of the volumes of the cells.
    pub volume: f64,
    /// Cells that lie where others are: the boundary winds around their centre more than once.
    pub overlapping: Vec<u32>,
    /// Their share of the volume.
    pub overlap: f64,
    /// Interior edges without four cells: the number of edges for each number of cells.
    pub irregular_edges: BTreeMap<u32, usize>,
}

impl HexQuality {
    /// The quality of cells with their boundary faces.
    pub(super) fn of(points: &[DVec3], hexes: &[[u32; 8]], quads: &[[u32; 4]], context: &Context) -> Result<Self> {
        let uncertified = uncertified(points, hexes);
        let overlapping = overlapping(points, hexes, quads, context)?;
        let corners = |h: &[u32; 8]| -> Corners { h.map(|v| points[v as usize]) };
        let of_cell = |h| [scaled_jacobian(&corners(h)), volume(&corners(h))];
        let shapes: Vec<[f64; 2]> = hexes.par_iter().map(of_cell).collect();
        let jacobians = || shapes.iter().map(|s| s[0]);
        let volume: f64 = shapes.iter().map(|s| s[1]).sum();
        let covered_twice: f64 = overlapping.iter().map(|&h| shapes[h as usize][1]).sum();
        Ok(HexQuality {
            certified: uncertified.is_empty(),
            uncertified,
            scaled_jacobian_min: jacobians().fold(f64::INFINITY, f64::min),
            scaled_jacobian_mean: jacobians().sum::<f64>() / hexes.len().max(1) as f64,
            inverted: jacobians().filter(|j| *j <= 0.0).count(),
            volume,
            overlap: if volume > 0.0 { covered_twice / volume } else { 0.0 },
            overlapping,
            irregular_edges: irregular_edges(hexes, quads),
        })
    }
}

/// Interior edges by their number of cells, four left out.
fn irregular_edges(hexes: &[[u32; 8]], quads: &[[u32; 4]]) -> BTreeMap<u32, usize> {
    let mut found = BTreeMap::new();
    irregular_hex_edges(hexes, quads).into_iter().for_each(|(_, cells)| *found.entry(cells).or_default() += 1);
    found
}
