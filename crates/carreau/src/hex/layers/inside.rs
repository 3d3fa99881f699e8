//! Moves the inside of a mesh along with its wall.

use super::wall::{Wall, within};
use crate::context::Context;
use crate::error::Result;
use crate::mesh::{HEX_EDGES, HexMesh};
use glam::DVec3;

/// Sweeps of the harmonic displacement.
const SWEEPS: usize = 120;
/// Over-relaxation of each sweep, between 1 and 2.
const RELAXATION: f64 = 1.6;

/// The edges of a mesh around each vertex, and how its inside follows the wall.
pub(super) struct Inside {
    pub(super) offsets: Vec<u32>,
    /// Neighbours with their weights.
    pub(super) around: Vec<(u32, f64)>,
    pub(super) is_wall: Vec<bool>,
}

impl Inside {
    pub(super) fn of(mesh: &HexMesh, wall: &Wall) -> Inside {
        let mut edges: Vec<[u32; 2]> =
            mesh.hexes.iter().flat_map(|h| HEX_EDGES.iter().flat_map(|&[a, b]| [[h[a], h[b]], [h[b], h[a]]])).collect();
        edges.sort_unstable();
        edges.dedup();
        let mut offsets = vec![0u32; mesh.points.len() + 1];
        edges.iter().for_each(|e| offsets[e[0] as usize + 1] += 1);
        (0..mesh.points.len()).for_each(|v| offsets[v + 1] += offsets[v]);
        let weight = |&[a, b]: &[u32; 2]| {
            let length = mesh.points[a as usize].distance(mesh.points[b as usize]);
            (b, 1.0 / length.max(f64::MIN_POSITIVE))
        };
        let mut is_wall = vec![false; mesh.points.len()];
        wall.vertices.iter().for_each(|&v| is_wall[v as usize] = true);
        Inside { offsets, around: edges.iter().map(weight).collect(), is_wall }
    }

    pub(super) fn around(&self, v: usize) -> &[(u32, f64)] {
        &self.around[self.offsets[v] as usize..self.offsets[v + 1] as usize]
    }

    /// The displacement of all vertices: that of the wall as it is, inside the mean of those around.
    pub(super) fn follow(&self, wall: &Wall, moves: &mut [DVec3], context: &Context) -> Result<()> {
        for (k, &v) in wall.vertices.iter().enumerate() {
            moves[v as usize] = wall.inward[k] * wall.thickness[k];
        }
        for _ in 0..SWEEPS {
            context.check()?;
            for v in (0..moves.len()).filter(|&v| !self.is_wall[v]) {
                let (sum, weight) = self.around(v).iter().fold((DVec3::ZERO, 0.0), |(sum, all), &(w, weight)| {
                    (sum + moves[w as usize] * weight, all + weight)
                });
                let mean = sum / f64::max(weight, f64::MIN_POSITIVE);
                let next = moves[v] + RELAXATION * (mean - moves[v]);
                moves[v] = within(wall.planes.get(&(v as u32)), next);
            }
        }
        Ok(())
    }

    /// The wall vertices of cells and of those some rings around them, or as many rings as it takes to reach the wall; as places.
    pub(super) fn wall_near(&self, mesh: &HexMesh, wall: &Wall, cells: &[u32], rings: usize) -> Vec<usize> {
        let mut seen = vec![false; mesh.points.len()];
        let mut front: Vec<u32> = cells.iter().flat_map(|&h| mesh.hexes[h as usize]).collect();
        let mut found = Vec::new();
        for ring in 0.. {
            front.retain(|&v| !std::mem::replace(&mut seen[v as usize], true));
            found.extend(front.iter().filter_map(|&v| wall.place(v)));
            if front.is_empty() || (ring >= rings && !found.is_empty()) {
                break;
            }
            front = front.iter().flat_map(|&v| self.around(v as usize).iter().map(|a| a.0)).collect();
        }
        found.sort_unstable();
        found
    }
}
