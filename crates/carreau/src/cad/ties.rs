//! Triangles with all corners where two surfaces meet, which lie on both: each goes to the one that its middle is nearer to.
//!
//! ```text
//!      A  ╲   ╱  A          A and B are cylinders of one radius that cross: the corners of S are on both, its middle is not, and
//!     ─────╲S╱─────         with S in the wrong one two faces of A hang together
//!      B   ╱ ╲   B
//! ```

use super::regions::{Map, area_vector};
use super::tuning::NAMED_DISTANCE;
use crate::geometry::primitive::Primitive;
use crate::mesh::NONE;

/// A factor: nearer means by this, because less is a matter of rounding, and of where a coarse facet of a smooth border
/// lies.
const TIE_FACTOR: f64 = 0.5;
/// A count: rounds, because triangles beside those that changed sides may follow.
const TIE_ROUNDS: usize = 4;

impl Map<'_> {
    /// Settles where the triangles of exact pieces belong that lie on two of them.
    pub fn settle_ties(&mut self) {
        for _ in 0..TIE_ROUNDS {
            let moves: Vec<(u32, u32, u32)> =
                (0..self.t.len() as u32).filter_map(|k| Some((self.label[k as usize], k, self.nearer(k)?))).collect();
            if moves.is_empty() {
                return;
            }
            for &(from, k, to) in &moves {
                self.give(from, &[k], to);
            }
            let mut changed: Vec<u32> = moves.iter().flat_map(|m| [m.0, m.2]).collect();
            changed.sort_unstable();
            changed.dedup();
            for p in changed {
                let piece = &self.pieces[p as usize];
                let (triangles, described) = (piece.triangles.clone(), (piece.surface.clone(), piece.primitive));
                if !triangles.is_empty() {
                    self.replace(&[p], vec![(triangles, Some(described))]);
                }
            }
            self.compact();
        }
    }

    /// The neighbour whose surface a triangle is nearer to than to its own, with all corners on it and facing the same way.
    fn nearer(&self, k: u32) -> Option<u32> {
        let own = self.label[k as usize];
        let beside = (3 * k..3 * k + 3).map(|c| self.t.opposite(c)).filter(|&o| o != NONE);
        let mut around: Vec<u32> = beside.map(|o| self.label[o as usize / 3]).filter(|&l| l != own).collect();
        around.sort_unstable();
        around.dedup();
        if around.is_empty() {
            return None;
        }
        let corners = [0, 1, 2].map(|i| self.t.point(3 * k + i));
        let middle = corners.iter().sum::<glam::DVec3>() / 3.0;
        let primitive = |p: u32| self.pieces[p as usize].primitive;
        let home = primitive(own)?;
        let bound = TIE_FACTOR * home.distance(middle).abs();
        let normal = area_vector(self.t, k).normalize_or_zero();
        // As near as the other vertices of a piece are, or as curves with a name are.
        let lies_on = |p: u32, q: &Primitive| {
            let near = f64::max(2.0 * self.pieces[p as usize].max, NAMED_DISTANCE * self.diagonal);
            corners.iter().all(|&c| q.distance(c).abs() <= near)
        };
        let better = |p: &u32| {
            let q = primitive(*p)?;
            let turned = |s: &Primitive| s.normal(middle).dot(normal).abs();
            let off = q.distance(middle).abs();
            (lies_on(own, &home) && lies_on(*p, &q) && off < bound && turned(&q) >= turned(&home)).then_some((off, *p))
        };
        let best = around.iter().filter_map(better).min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        best.filter(|_| bound > self.precision).map(|b| b.1)
    }
}
