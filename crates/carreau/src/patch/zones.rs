//! Stage 2: zones of quads (paper §3.2), and quads chosen in another way.
//!
//! A zone starts with the best free pair of triangles and takes, again and again, the best pair among those that
//! contain a free triangle on its contour. When none is left, the next zone starts.

use super::quality::Candidates;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A choice of disjoint pairs.
pub(super) struct Quads {
    /// Half-edge of the diagonal of every quad: the one that [`Candidates::order`] names.
    pub diagonal: Vec<u32>,
    /// The quad of every triangle, or [`NONE`].
    pub of_triangle: Vec<u32>,
}

impl Quads {
    /// No quad yet.
    pub fn new(triangles: usize) -> Self {
        Quads { diagonal: Vec::new(), of_triangle: vec![NONE; triangles] }
    }

    /// Adds the pair across `h`, both of whose triangles must be free.
    pub fn push(&mut self, h: u32, opposite: u32) {
        let quad = self.diagonal.len() as u32;
        self.diagonal.push(h);
        self.of_triangle[h as usize / 3] = quad;
        self.of_triangle[opposite as usize / 3] = quad;
    }

    fn is_free(&self, triangle: u32) -> bool {
        self.of_triangle[triangle as usize] == NONE
    }
}

/// Greedy zones of the paper.
pub(super) fn grow_zones(candidates: &Candidates, context: &Context) -> Result<Quads> {
    let stage = context.stage("zones");
    let triangles = candidates.triangles;
    let mut quads = Quads::new(triangles.len());
    // Places in `order`, best first; pairs that are no longer free are skipped when they come up.
    let mut front = BinaryHeap::new();
    for (k, &seed) in candidates.order.iter().enumerate() {
        front.push(Reverse(k as u32));
        while let Some(Reverse(rank)) = front.pop() {
            let h = candidates.order[rank as usize];
            let o = triangles.opposite(h);
            if !quads.is_free(h / 3) || !quads.is_free(o / 3) {
                continue;
            }
            quads.push(h, o);
            if quads.diagonal.len().is_multiple_of(4096) {
                stage.step(quads.diagonal.len(), triangles.len() / 2)?;
            }
            for contour in candidates.sides(h).map(|s| candidates.across(s)).into_iter().filter(|&c| c != NONE) {
                if quads.is_free(contour / 3) {
                    // Across the contour edge itself lies a quad of the zone: only the two other edges count.
                    let others = [triangles.next(contour), triangles.previous(contour)];
                    let ranks = others.map(|e| candidates.rank[e as usize]);
                    front.extend(ranks.into_iter().filter(|&r| r != NONE).map(Reverse));
                }
            }
        }
        debug_assert!(!quads.is_free(seed / 3) || !quads.is_free(triangles.opposite(seed) / 3));
    }
    Ok(quads)
}
