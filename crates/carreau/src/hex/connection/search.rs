//! Chooses the best of many partitions for a branching. Memory is kept from one branching to the next.

use super::partition::{Connection, QuadsAtVertices};
use super::{dual, orange};
use glam::DVec3;

/// Axes that orange slices are tried on.
const AXES: usize = 200;
/// Azimuths closer than this, in radians, make no slice.
const LEAST_GAP: f64 = 1e-6;
/// Candidates whose vertices are moved.
const FINALISTS: usize = 4;
/// Least determinant, at three directions, from which on no more candidates are looked for.
const FAIR: f64 = 0.12;
/// The same at more than three directions.
const GOOD: f64 = 0.3;

/// How a partition can be made.
#[derive(Debug, Clone, Copy)]
enum Recipe {
    /// By the paper's heuristic.
    Dual,
    /// Slices about an axis.
    Slices(DVec3),
}

/// Looks for partitions; keeps its memory from one branching to the next.
#[derive(Debug, Default)]
pub struct PartitionSearch {
    best: Connection,
    tried: Connection,
    dual: Option<Connection>,
    candidates: Vec<(f64, Recipe)>,
    order: Vec<(f64, usize)>,
    around: QuadsAtVertices,
}

impl PartitionSearch {
    /// The best partition found for at least three unit directions, no two of them equal.
    pub fn partition(&mut self, directions: &[DVec3]) -> &Connection {
        self.dual = if directions.len() > 3 { dual::partition(directions) } else { None };
        self.candidates.clear();
        if let Some(dual) = &self.dual {
            self.candidates.push((dual.score(directions), Recipe::Dual));
        }
        if let Some(axis) = orange::normal(directions) {
            self.consider(directions, axis, LEAST_GAP);
        }
        // Most branchings are flat, or the heuristic does well: then no more is tried.
        let enough = if directions.len() == 3 { FAIR } else { GOOD };
        if let Some(&(score, recipe)) = self.candidates.iter().max_by(|a, b| a.0.total_cmp(&b.0))
            && score >= enough
        {
            // The slices were made last, and still are in their place.
            if matches!(recipe, Recipe::Dual) {
                self.make(recipe, directions);
            }
            std::mem::swap(&mut self.best, &mut self.tried);
            if directions.len() > 3 {
                self.best.relax(directions, &mut self.around);
            }
            return &self.best;
        }
        orange::axes(AXES).for_each(|axis| self.consider(directions, axis, LEAST_GAP));
        if self.candidates.is_empty() {
            // Two directions are equal: no partition tells them apart, but the cells are joined all the same.
            orange::axes(1).for_each(|axis| self.consider(directions, axis, 0.0));
        }
        // A stable sort: of equal candidates the first wins. The paper's heuristic is the first.
        let first = self.candidates.first().copied().filter(|_| directions.len() > 3);
        self.candidates.sort_by(|a, b| b.0.total_cmp(&a.0));
        self.candidates.truncate(FINALISTS);
        self.candidates.extend(first);
        let mut score = f64::NEG_INFINITY;
        for k in 0..self.candidates.len() {
            self.make(self.candidates[k].1, directions);
            self.tried.relax(directions, &mut self.around);
            let reached = self.tried.score(directions);
            if k == 0 || reached > score + 1e-9 {
                score = reached;
                std::mem::swap(&mut self.best, &mut self.tried);
            }
        }
        &self.best
    }

    /// Adds the slices about an axis to the candidates, where they can be made.
    fn consider(&mut self, directions: &[DVec3], axis: DVec3, least_gap: f64) {
        if self.tried.slice(directions, axis, least_gap, &mut self.order) {
            self.candidates.push((self.tried.score(directions), Recipe::Slices(axis)));
        }
    }

    /// Makes a candidate again.
    fn make(&mut self, recipe: Recipe, directions: &[DVec3]) {
        match (recipe, &self.dual) {
            (Recipe::Dual, Some(dual)) => self.tried.clone_from(dual),
            (Recipe::Dual, None) => {}
            (Recipe::Slices(axis), _) => {
                self.tried.slice(directions, axis, 0.0, &mut self.order);
            }
        }
    }
}
