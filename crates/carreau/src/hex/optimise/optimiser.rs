//! The cells at work: targets, springs, energy, and one descent.

use super::energy::{CellEnergy, energies, least_bound};
use super::tuning::{CONVERGED, DRIFT, LAST_POWER, MIN_CELLS, MIN_VERTICES, PASSED, VALID};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::hexes::Corners;
use crate::mesh::HEX_EDGES;
use crate::numeric::lbfgs::{Stop, minimise};
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

/// Corners (8 × cell + corner) by vertex, and where those of each vertex begin.
pub fn corners_at(vertices: usize, hexes: &[[u32; 8]]) -> (Vec<u32>, Vec<u32>) {
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
    pub(super) hexes: &'a [[u32; 8]],
    /// Corners (8 × cell + corner) at every vertex.
    pub(super) offsets: Vec<u32>,
    pub(super) corners: Vec<u32>,
    pub(super) inverse: Vec<[f64; 3]>,
    /// The first targets.
    pub(super) first: Vec<[f64; 3]>,
    pub(super) weight: Vec<f64>,
    pub(super) scale: Vec<f64>,
    /// In the order of their vertices.
    pub(super) springs: Vec<Spring>,
    /// Vertices that stay; empty for none.
    pub(super) fixed: Vec<bool>,
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
    pub(super) fn rescale(&mut self) {
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

    pub(super) fn cell(&self, points: &[DVec3], h: usize) -> Corners {
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
    pub(super) fn evaluate(
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
    pub(super) fn cell_energies(&self, points: &[DVec3], cells: &mut Vec<CellEnergy>, epsilon: f64, power: i32) {
        cells.resize(self.hexes.len(), CellEnergy::ZERO);
        cells.par_chunks_mut(MIN_CELLS).enumerate().for_each(|(chunk, cells)| {
            let first = chunk * MIN_CELLS;
            energies(|k| (self.cell(points, first + k), self.inverse[first + k]), epsilon, power, cells);
        });
    }

    /// The sums of what the cells have and of the springs; also the least determinant.
    pub(super) fn summed(&self, points: &[DVec3], gradient: &mut [DVec3], cells: &[CellEnergy]) -> (f64, f64) {
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

    /// Minimises what `of` makes of the cells and their energies, within the valid set.
    pub(super) fn minimise_cells(
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

    /// The cells at a vertex.
    pub fn cells_at(&self, v: u32) -> impl Iterator<Item = u32> {
        let [first, end] = [0, 1].map(|k| self.offsets[v as usize + k] as usize);
        self.corners[first..end].iter().map(|c| c / 8)
    }
}
