//! The mean scaled Jacobian of a whole mesh.
//!
//! The energy (energy.rs) asks for boxes, and the power that it is raised to for worst cells that are as good as the others:
//! neither is the mean of what the quality of a cell is, the least scaled Jacobian of its corners. At last that mean itself is
//! raised, by the soft maximum of what the corners lack of one:
//!
//! E = Σ ln Σ exp(β (1 − s)) / β over the cells, and the corners of each.
//!
//! What the least of the mesh is made of (corners.rs) is added, so that it does not fall, and a share of the energy, which
//! keeps away from the end of the valid set.

use super::corners::corner_energy;
use super::energy::CellEnergy;
use super::optimiser::Optimiser;
use super::tuning::{CONVERGED, MANY_CELLS};
use crate::context::Context;
use crate::error::Result;
use crate::numeric::lbfgs::Stop;
use glam::DVec3;

/// How nearly the soft maximum is the largest.
const SOFT: f64 = 20.0;
/// Inverse width, in scaled Jacobians, of the band of corners near to the least of the mesh.
const BAND: f64 = 40.0;
/// Weight of the corners in that band.
const GUARD: f64 = 10.0;
/// Weight of the energy, which keeps cells from folding inside.
const ENERGY_SHARE: f64 = 0.01;
/// Iterations of the minimisation on meshes of up to [`MANY_CELLS`] cells; larger ones get fewer in proportion.
const ITERATIONS: f64 = 300.0;

impl Optimiser<'_> {
    /// Raises the mean scaled Jacobian within the valid set, where none is below `least`.
    pub(super) fn straighten(&self, points: &mut Vec<DVec3>, least: f64, context: &Context) -> Result<()> {
        // Large meshes get fewer.
        let share = (MANY_CELLS / self.hexes.len() as f64).min(1.0);
        let stop = Stop { iterations: (share * ITERATIONS) as usize, decrease: CONVERGED };
        self.minimise_cells(points, stop, context, |p, energy| {
            let (sum, by_sum) = corner_energy(p, SOFT, 1.0);
            let (near, by_near) = corner_energy(p, BAND, least);
            CellEnergy {
                value: sum.ln() / SOFT + near * GUARD + ENERGY_SHARE * energy.value,
                gradient: std::array::from_fn(|c| {
                    by_sum[c] / (SOFT * sum) + by_near[c] * GUARD + energy.gradient[c] * ENERGY_SHARE
                }),
                least: energy.least,
            }
        })
    }
}
