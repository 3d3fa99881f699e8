//! Geometry: untangling and smoothing.
//!
//! 1. While a determinant is not positive: minimise the regularised energy, ε following the worst one (energy.rs); first for
//!    the folded cells of a large mesh and their surroundings alone (untangle.rs), then for all, or the other way round.
//! 2. Then ε = 0: the energy is infinite outside the valid set, which no step leaves. The power p rises, so that the
//!    worst cells count more and more; target lengths follow the cells, so that only angles are asked for.
//! 3. Bernstein certificate of every cell; where some have none, the springs are loosened, those cells get more weight,
//!    and step 2 is repeated.
//!
//! 4. The worst cells once more, with their surroundings alone; there the least scaled Jacobian itself is raised (corners.rs), and
//!    before and after that the mean of all (mean.rs).
//!
//! Wall vertices are tied to where they belong by springs, stiff along the normal and weak along the surface.

mod corners;
mod energy;
mod mean;
mod onto_surface;
mod patches;
mod simd;
#[cfg(test)]
mod slopes;
mod untangle;
mod worst_cells;

pub use onto_surface::seat;
pub use patches::Ties;
pub use worst_cells::{polish, relieve};

use crate::context::Context;
use crate::error::Result;
use crate::geometry::hexes::{Corners, scaled_jacobian, uncertified};
use crate::mesh::HEX_EDGES;
use crate::numeric::lbfgs::{Stop, minimise};
use corners::corner_energy;
use energy::{CellEnergy, energies, least_bound};
use glam::DVec3;
use rayon::prelude::*;

/// Where a vertex is to be.
#[derive(Debug, Clone, Copy)]
pub struct Spring {
    /// The vertex.
    pub vertex: u32,
    /// Its place.
    pub to: DVec3,
    /// Unit normal of the surface there; zero for none, then the spring pulls alike in all directions.
    pub normal: DVec3,
    /// Strength along the normal: the energy of being off by the vertex's own scale.
    pub along: f64,
    /// Strength across it.
    pub across: f64,
}

/// Most rounds of untangling.
const UNTANGLE_ROUNDS: usize = 30;
/// Most rounds of new targets and weights.
const WEIGHT_ROUNDS: usize = 4;
/// Least number of cells per task: enough work to pay for one.
const MIN_CELLS: usize = 512;
/// Least number of vertices per task.
const MIN_VERTICES: usize = 4096;
/// More cells than this are unfolded by patches first, fewer all together.
const FEW_CELLS: usize = 4000;
/// Cells from which on iterations are saved.
const MANY_CELLS: f64 = 20_000.0;

/// How much work is put into a mesh.
pub struct Effort {
    /// Powers of the energy in turn, with the iterations of each.
    powers: &'static [(i32, usize)],
    /// Settings tried while cells are folded: least σ, and the share of the springs' strength.
    attempts: &'static [(f64, f64)],
}

/// For the coarsest mesh, where iterations cost little.
pub const COARSE: Effort = Effort {
    powers: &[(1, 150), (2, 100), (4, 150), (8, 150)],
    attempts: &[(0.15, 0.02), (0.4, 1e-4), (0.05, 0.02), (0.25, 0.2)],
};
/// For a mesh that others are made from.
pub const PASSING: Effort = Effort { powers: &[(1, 60), (2, 40), (4, 40)], attempts: COARSE.attempts };
/// For the refined mesh, which starts nearly valid.
pub const FINE: Effort = Effort { powers: &[(4, 60), (8, 80)], attempts: &[(0.15, 0.02), (0.4, 1e-4)] };

/// Targets stay within this factor of the first ones.
const DRIFT: f64 = 2.0;

/// For the inside of a mesh whose boundary stays.
pub const INNER: Effort = Effort { powers: &[(4, 40), (8, 60)], attempts: &[] };

/// The power of the energy that a mesh is delivered with; what comes before it need not converge as well.
const LAST_POWER: i32 = 8;
/// Share of the energy that ten iterations must gain before the last power.
const PASSED: f64 = 1e-3;
/// The same at the last power.
const CONVERGED: f64 = 3e-4;

/// The share of the energy beside the least scaled Jacobian.
const BARRIER_SHARE: f64 = 0.1;

/// Determinants above this share of the target count as positive.
const VALID: f64 = 1e-6;

/// The regularised determinant χ.
fn regularised(d: f64, epsilon: f64) -> f64 {
    let root = (epsilon * epsilon + d * d).sqrt();
    if d > 0.0 { 0.5 * (d + root) } else { 0.5 * epsilon * epsilon / (root - d).max(1e-300) }
}

/// Corners (8 × cell + corner) by vertex, and where those of each vertex begin.
fn corners_at(vertices: usize, hexes: &[[u32; 8]]) -> (Vec<u32>, Vec<u32>) {
    let mut offsets = vec![0u32; vertices + 1];
    hexes.as_flattened().iter().for_each(|&v| offsets[v as usize + 1] += 1);
    for v in 0..vertices {
        offsets[v + 1] += offsets[v];
    }
    let mut next = offsets.clone();
    let mut corners = vec![0; 8 * hexes.len()];
    for (&v, k) in hexes.as_flattened().iter().zip(0..) {
        corners[next[v as usize] as usize] = k;
        next[v as usize] += 1;
    }
    (offsets, corners)
}

/// Cells, and what is asked of them.
pub struct Optimiser<'a> {
    hexes: &'a [[u32; 8]],
    /// Corners (8 × cell + corner) at every vertex.
    offsets: Vec<u32>,
    corners: Vec<u32>,
    inverse: Vec<[f64; 3]>,
    /// The first targets.
    first: Vec<[f64; 3]>,
    weight: Vec<f64>,
    scale: Vec<f64>,
    /// In the order of their vertices.
    springs: Vec<Spring>,
    /// Vertices that stay; empty for none.
    fixed: Vec<bool>,
}

impl<'a> Optimiser<'a> {
    /// Targets are taken from the positions.
    pub fn new(points: &[DVec3], hexes: &'a [[u32; 8]]) -> Self {
        let (offsets, corners) = corners_at(points.len(), hexes);
        let weight = vec![1.0; hexes.len()];
        let mut all = Optimiser {
            hexes,
            offsets,
            corners,
            inverse: Vec::new(),
            first: Vec::new(),
            weight,
            scale: Vec::new(),
            springs: Vec::new(),
            fixed: Vec::new(),
        };
        all.retarget(points);
        all.first.clone_from(&all.inverse);
        all
    }

    /// Ties vertices; replaces the springs of before.
    pub fn tie(&mut self, mut springs: Vec<Spring>) {
        springs.sort_by_key(|s| s.vertex);
        self.springs = springs;
    }

    /// Holds vertices where they are.
    pub fn fix(&mut self, fixed: Vec<bool>) {
        self.fixed = fixed;
        self.rescale();
    }

    /// The corners of a cell.
    pub fn corners_of(&self, h: u32) -> &[u32; 8] {
        &self.hexes[h as usize]
    }

    /// Target lengths: the mean length of the four edges along each axis, lengths far below that of the other axes
    /// raised to a share of them; within a factor of the first targets, or cells would shrink from round to round.
    pub fn retarget(&mut self, points: &[DVec3]) {
        let length = |h: &[u32; 8], k: usize| {
            let [a, b] = HEX_EDGES[k].map(|c| points[h[c] as usize]);
            a.distance(b)
        };
        let targets = |(k, h): (usize, &[u32; 8])| {
            let mean: [f64; 3] = std::array::from_fn(|axis| (0..4).map(|k| length(h, 4 * axis + k)).sum::<f64>() / 4.0);
            let longest = mean.iter().copied().fold(1e-300, f64::max);
            let inverse = mean.map(|l| 1.0 / l.max(0.02 * longest));
            match self.first.get(k) {
                Some(f) => std::array::from_fn(|axis| inverse[axis].clamp(f[axis] / DRIFT, f[axis] * DRIFT)),
                None => inverse,
            }
        };
        self.inverse = self.hexes.par_iter().enumerate().map(targets).collect();
        self.rescale();
    }

    /// The length over which the energy changes at each vertex; zero holds it.
    fn rescale(&mut self) {
        let inverse = &self.inverse;
        let fixed = &self.fixed;
        let scale = |v: usize| {
            if fixed.get(v) == Some(&true) {
                return 0.0;
            }
            let at = &self.corners[self.offsets[v] as usize..self.offsets[v + 1] as usize];
            let least = |c: &u32| 1.0 / inverse[*c as usize / 8].iter().copied().fold(0.0, f64::max);
            at.iter().map(least).fold(f64::INFINITY, f64::min)
        };
        self.scale = (0..self.offsets.len() - 1)
            .into_par_iter()
            .map(scale)
            .map(|s| if s.is_finite() { s } else { 0.0 })
            .collect();
    }

    fn cell(&self, points: &[DVec3], h: usize) -> Corners {
        self.hexes[h].map(|v| points[v as usize])
    }

    /// The least determinant of all cells, over their target volumes.
    pub fn least(&self, points: &[DVec3]) -> f64 {
        let of = |h: usize| least_bound(&self.cell(points, h), self.inverse[h]);
        (0..self.hexes.len()).into_par_iter().with_min_len(MIN_CELLS).map(of).reduce(|| f64::INFINITY, f64::min)
    }

    /// Whether all determinants are positive.
    pub fn is_valid(&self, points: &[DVec3]) -> bool {
        self.least(points) > VALID
    }

    /// Energy of cells and springs, with its gradient; also the least determinant. `cells` is room for what each has.
    fn evaluate(
        &self,
        points: &[DVec3],
        gradient: &mut [DVec3],
        cells: &mut Vec<CellEnergy>,
        epsilon: f64,
        power: i32,
    ) -> (f64, f64) {
        self.cell_energies(points, cells, epsilon, power);
        self.summed(points, gradient, cells)
    }

    /// What every cell has.
    fn cell_energies(&self, points: &[DVec3], cells: &mut Vec<CellEnergy>, epsilon: f64, power: i32) {
        cells.resize(self.hexes.len(), CellEnergy::ZERO);
        cells.par_chunks_mut(MIN_CELLS).enumerate().for_each(|(chunk, cells)| {
            let first = chunk * MIN_CELLS;
            energies(|k| (self.cell(points, first + k), self.inverse[first + k]), epsilon, power, cells);
        });
    }

    /// The sums of what the cells have and of the springs; also the least determinant.
    fn summed(&self, points: &[DVec3], gradient: &mut [DVec3], cells: &[CellEnergy]) -> (f64, f64) {
        gradient.par_iter_mut().enumerate().with_min_len(MIN_VERTICES).for_each(|(v, g)| {
            let at = &self.corners[self.offsets[v] as usize..self.offsets[v + 1] as usize];
            let pull = |c: usize| cells[c / 8].gradient[c % 8] * self.weight[c / 8];
            *g = at.iter().map(|&c| pull(c as usize)).sum();
        });
        let mut value: f64 = cells.iter().zip(&self.weight).map(|(c, w)| w * c.value).sum();
        for s in &self.springs {
            let v = s.vertex as usize;
            let size = self.scale[v];
            if size > 0.0 {
                let off = (points[v] - s.to) / size;
                let normal = s.normal * s.normal.dot(off);
                value += s.along * normal.length_squared() + s.across * (off - normal).length_squared();
                gradient[v] += (normal * s.along + (off - normal) * s.across) * (2.0 / size);
            }
        }
        (value, cells.iter().map(|c| c.least).fold(f64::INFINITY, f64::min))
    }

    /// Minimises the energy; with ε = 0 within the valid set.
    pub fn descend(
        &self,
        points: &mut Vec<DVec3>,
        epsilon: f64,
        power: i32,
        iterations: usize,
        context: &Context,
    ) -> Result<()> {
        let stop = Stop { iterations, decrease: if power < LAST_POWER { PASSED } else { CONVERGED } };
        let (mut evaluations, mut cells) = (0, Vec::new());
        let value = |x: &[DVec3], g: &mut [DVec3]| {
            context.check()?;
            evaluations += 1;
            let (value, least) = self.evaluate(x, g, &mut cells, epsilon, power);
            Ok(if epsilon > 0.0 || least > 0.0 { value } else { f64::INFINITY })
        };
        let least = minimise(points, &self.scale, stop, value)?;
        tracing::debug!(cells = self.hexes.len(), epsilon, power, evaluations, value = least, "descent");
        Ok(())
    }

    /// Raises the least scaled Jacobian, which is about `usual`, within the valid set. A share of the energy keeps away from the
    /// end of that set: the corners of a cell do not tell that its inside is about to fold, and a descent that ran into the end
    /// would go no farther, nor would those of other patches with the cell.
    fn sharpen(
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

    /// Minimises what `of` makes of the cells and their energies, within the valid set.
    fn minimise_cells(
        &self,
        points: &mut Vec<DVec3>,
        stop: Stop,
        context: &Context,
        of: impl Fn(&Corners, &CellEnergy) -> CellEnergy + Sync,
    ) -> Result<()> {
        let mut cells = Vec::new();
        let value = |x: &[DVec3], g: &mut [DVec3]| {
            context.check()?;
            self.cell_energies(x, &mut cells, 0.0, 1);
            let cells_at_work = cells.par_iter_mut().with_min_len(MIN_CELLS).enumerate();
            cells_at_work.for_each(|(h, cell)| *cell = of(&self.cell(x, h), cell));
            let (value, least) = self.summed(x, g, &cells);
            Ok(if least > 0.0 { value } else { f64::INFINITY })
        };
        minimise(points, &self.scale, stop, value)?;
        Ok(())
    }

    /// Step 1, from the same start with other settings where the first ones fail; whether it succeeded.
    fn untangle(&mut self, points: &mut Vec<DVec3>, effort: &Effort, context: &Context) -> Result<bool> {
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
    fn unfold(&self, points: &mut Vec<DVec3>, floor: f64, context: &Context) -> Result<bool> {
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
    fn folded(&self, points: &[DVec3]) -> Vec<u32> {
        let is_folded = |&h: &u32| !(least_bound(&self.cell(points, h as usize), self.inverse[h as usize]) > VALID);
        (0..self.hexes.len() as u32).into_par_iter().with_min_len(MIN_CELLS).filter(is_folded).collect()
    }

    /// Step 2; large meshes get fewer iterations.
    fn improve(&mut self, points: &mut Vec<DVec3>, powers: &[(i32, usize)], context: &Context) -> Result<()> {
        let share = (MANY_CELLS / self.hexes.len() as f64).clamp(0.3, 1.0);
        for &(power, iterations) in powers {
            self.descend(points, 0.0, power, (share * iterations as f64) as usize, context)?;
            self.retarget(points);
        }
        Ok(())
    }

    /// Step 3: the cells without a certificate.
    fn uncertified(&self, points: &[DVec3]) -> Vec<u32> {
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

    /// The cells at a vertex.
    pub fn cells_at(&self, v: u32) -> impl Iterator<Item = u32> {
        let [first, end] = [0, 1].map(|k| self.offsets[v as usize + k] as usize);
        self.corners[first..end].iter().map(|c| c / 8)
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
