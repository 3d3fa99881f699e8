//! Figures of a layout: what is covered, and by how many patches.

use super::grid::Patch;
use super::validate::CellShape;
use crate::mesh::SurfaceMesh;
use serde::Serialize;
use std::collections::BTreeMap;

/// Number of patches, largest first, that together hold at least `share` of all triangles; `None` when all of them do
/// not.
pub fn patches_needed(patches: &[Patch], triangles: usize, share: f64) -> Option<usize> {
    let mut sizes: Vec<usize> = patches.iter().map(|p| 2 * p.cells()).collect();
    sizes.sort_unstable_by(|a, b| b.cmp(a));
    // A share such as 0.9 of 10 triangles is meant exactly.
    let wanted = (share * triangles as f64 - 1e-9).ceil().max(0.0) as usize;
    if triangles == 0 {
        return Some(0);
    }
    let mut held = 0;
    sizes
        .iter()
        .position(|s| {
            held += s;
            held >= wanted
        })
        .map(|k| k + 1)
}

/// Share of all triangles that lie in patches.
pub fn coverage(patches: &[Patch], triangles: usize) -> f64 {
    if triangles == 0 { 0.0 } else { patches.iter().map(|p| 2 * p.cells()).sum::<usize>() as f64 / triangles as f64 }
}

/// The figures of a layout, as the paper's table 1 and the checkers count them.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figures {
    /// Number of patches.
    pub patches: usize,
    /// Number of cells of all patches.
    pub cells: usize,
    /// Share of all triangles that lie in patches.
    pub coverage: f64,
    /// For some shares: the number of patches, largest first, that hold that share of all triangles.
    pub patches_for: BTreeMap<String, Option<usize>>,
    /// Mean of Q (equation 1) over all cells, in degrees.
    pub q_mean_deg: f64,
    /// Largest Q, in degrees.
    pub q_max_deg: f64,
    /// Largest angle between the normals of the triangles of a cell, in degrees.
    pub dihedral_max_deg: f64,
    /// Cells with a corner above 150°.
    pub bad_cells: usize,
    /// Cells with a corner above 180°.
    pub not_convex: usize,
}

/// The shares for which [`Figures`] counts patches; two are what the paper covers of the bunny and of its own model.
const SHARES: [f64; 6] = [0.5, 0.8, 0.8998, 0.9, 0.95, 0.9547];

impl Figures {
    /// Counts and measures a layout.
    pub fn of(mesh: &SurfaceMesh, patches: &[Patch]) -> Self {
        let triangles = mesh.face_count();
        let cells: usize = patches.iter().map(Patch::cells).sum();
        let mut figures = Figures {
            patches: patches.len(),
            cells,
            coverage: coverage(patches, triangles),
            patches_for: SHARES.map(|s| (s.to_string(), patches_needed(patches, triangles, s))).into(),
            q_mean_deg: 0.0,
            q_max_deg: 0.0,
            dihedral_max_deg: 0.0,
            bad_cells: 0,
            not_convex: 0,
        };
        for patch in patches {
            for (r, c) in patch.cell_places() {
                let shape = CellShape::of(mesh, patch, r, c);
                let q = shape.q().to_degrees();
                let corner = shape.angles.iter().copied().fold(0.0, f64::max).to_degrees();
                figures.q_mean_deg += q / cells as f64;
                figures.q_max_deg = figures.q_max_deg.max(q);
                figures.dihedral_max_deg = figures.dihedral_max_deg.max(shape.bend.to_degrees());
                figures.bad_cells += usize::from(corner > 150.0);
                figures.not_convex += usize::from(corner > 180.0 + 1e-4);
            }
        }
        figures
    }
}
