//! The steps of the optimisation, one after the other.

use super::corners::corner_energy;
use super::effort::Effort;
use super::energy::{CellEnergy, least_bound};
use super::optimiser::{Optimiser, Spring};
use super::tuning::{BARRIER_SHARE, FEW_CELLS, MANY_CELLS, MIN_CELLS, PASSED, UNTANGLE_ROUNDS, VALID, WEIGHT_ROUNDS};
use super::untangle;
use crate::context::Context;
use crate::error::Result;
use crate::geometry::hexes::{scaled_jacobian, uncertified};
use crate::numeric::lbfgs::Stop;
use glam::DVec3;
use rayon::prelude::*;

/// The regularised determinant χ.
pub fn regularised(d: f64, epsilon: f64) -> f64 {
    let root = (epsilon * epsilon + d * d).sqrt();
    if d > 0.0 { 0.5 * (d + root) } else { 0.5 * epsilon * epsilon / (root - d).max(1e-300) }
}

impl<'a> Optimiser<'a> {
    /// Raises the least scaled Jacobian, which is about `usual`, within the valid set. A share of the energy keeps away from the
    /// end of that set: the corners of a cell do not tell that its inside is about to fold, and a descent that ran into the end
    /// would go no farther, nor would those of other patches with the cell.
    pub(super) fn sharpen(
        &self,
        points: &mut Vec<DVec3>,
        beta: f64,
        usual: f64,
        iterations: usize,
        context: &Context,
    ) -> Result<()> {
        let stop = Stop { iterations, decrease: PASSED };
        self.minimise_cells(points, stop, context, |p, energy| {
            let (value, gradient) = corner_energy(p, beta, usual);
            CellEnergy {
                value: value + BARRIER_SHARE * energy.value,
                gradient: std::array::from_fn(|c| gradient[c] + BARRIER_SHARE * energy.gradient[c]),
                least: energy.least,
            }
        })
    }

    /// Step 1, from the same start with other settings where the first ones fail; whether it succeeded.
    pub(super) fn untangle(&mut self, points: &mut Vec<DVec3>, effort: &Effort, context: &Context) -> Result<bool> {
        let springs = std::mem::take(&mut self.springs);
        let start = points.clone();
        for &(floor, share) in effort.attempts {
            // Springs to places that belong to folded cells would hold them folded.
            let loose = |s: &Spring| Spring { along: share * s.along, across: share * s.across, ..*s };
            self.springs = springs.iter().map(loose).collect();
            points.clone_from(&start);
            if self.unfold(points, floor, context)? {
                self.springs = springs;
                return Ok(true);
            }
        }
        self.springs = springs;
        Ok(false)
    }

    /// One attempt of step 1.
    ///
    /// The first ε follows from the least determinant, the next ones from how much the energy went down (equation 6 of
    /// the paper): σ is that share, at least `floor`, μ = (1 − σ) χ(ε, D_min), ε = 2 √(μ (μ − D_min)).
    pub(super) fn unfold(&self, points: &mut Vec<DVec3>, floor: f64, context: &Context) -> Result<bool> {
        let mut least = self.least(points);
        let mut epsilon = (1e-6 + 0.04 * least.min(0.0).powi(2)).sqrt();
        let (mut gradient, mut cells) = (vec![DVec3::ZERO; points.len()], Vec::new());
        for round in 0..UNTANGLE_ROUNDS {
            if least > VALID {
                return Ok(true);
            }
            let before = self.evaluate(points, &mut gradient, &mut cells, epsilon, 1).0;
            self.descend(points, epsilon, 1, 60, context)?;
            let (after, lowest) = self.evaluate(points, &mut gradient, &mut cells, epsilon, 1);
            least = lowest;
            let sigma = (1.0 - after / before).max(floor);
            let mu = (1.0 - sigma) * regularised(least, epsilon);
            epsilon = if least < mu { 2.0 * (mu * (mu - least)).sqrt() } else { 1e-9 };
            tracing::debug!(round, least, epsilon, "untangling");
        }
        Ok(least > VALID)
    }

    /// The folded cells.
    pub(super) fn folded(&self, points: &[DVec3]) -> Vec<u32> {
        let is_folded = |&h: &u32| !(least_bound(&self.cell(points, h as usize), self.inverse[h as usize]) > VALID);
        (0..self.hexes.len() as u32).into_par_iter().with_min_len(MIN_CELLS).filter(is_folded).collect()
    }

    /// Step 2; large meshes get fewer iterations.
    pub(super) fn improve(
        &mut self,
        points: &mut Vec<DVec3>,
        powers: &[(i32, usize)],
        context: &Context,
    ) -> Result<()> {
        let share = (MANY_CELLS / self.hexes.len() as f64).clamp(0.3, 1.0);
        for &(power, iterations) in powers {
            self.descend(points, 0.0, power, (share * iterations as f64) as usize, context)?;
            self.retarget(points);
        }
        Ok(())
    }

    /// Step 3: the cells without a certificate.
    pub(super) fn uncertified(&self, points: &[DVec3]) -> Vec<u32> {
        uncertified(points, self.hexes)
    }

    /// The scaled Jacobian of every cell.
    pub fn qualities(&self, points: &[DVec3]) -> Vec<f64> {
        (0..self.hexes.len()).into_par_iter().map(|h| scaled_jacobian(&self.cell(points, h))).collect()
    }

    /// The cells that leave the valid set, and those whose scaled Jacobian is below a floor. A cell with a certificate by
    /// parts is not in the valid set: from there no descent would go on.
    pub fn weak(&self, points: &[DVec3], floors: &[f64]) -> Vec<u32> {
        let is_weak = |&h: &u32| self.is_weak(h, points, floors[h as usize]);
        (0..self.hexes.len() as u32).into_par_iter().filter(is_weak).collect()
    }

    /// Whether a cell is such a one.
    pub fn is_weak(&self, h: u32, points: &[DVec3], floor: f64) -> bool {
        let cell = self.cell(points, h as usize);
        scaled_jacobian(&cell) < floor || !(least_bound(&cell, self.inverse[h as usize]) > VALID)
    }

    /// All steps, until every cell has a certificate or nothing helps.
    pub fn run(&mut self, points: &mut Vec<DVec3>, effort: &Effort, context: &Context) -> Result<()> {
        let mut valid = self.is_valid(points);
        // All cells together find better places, which costs little where they are few.
        if !valid && self.hexes.len() > FEW_CELLS {
            valid = untangle::unfold(self, points, effort, context)?;
        }
        if !valid {
            valid = self.untangle(points, effort, context)?;
            valid = valid || untangle::unfold(self, points, effort, context)?;
            self.retarget(points);
        }
        if valid {
            self.improve(points, effort.powers, context)?;
        }
        let mut uncertified = self.uncertified(points);
        let mut best = points.clone();
        for _ in 0..WEIGHT_ROUNDS {
            if uncertified.is_empty() || !valid {
                break;
            }
            // Where cells have no room the wall gives way.
            self.springs.iter_mut().for_each(|s| (s.along, s.across) = (0.1 * s.along, 0.1 * s.across));
            uncertified.iter().for_each(|&h| self.weight[h as usize] *= 8.0);
            self.improve(points, &[(2, 60), (8, 150)], context)?;
            let left = self.uncertified(points);
            if left.len() < uncertified.len() {
                uncertified = left;
                best.clone_from(points);
            }
        }
        *points = best;
        Ok(())
    }
}
