//! Edges that noise has made: where four surfaces meet in a point, a noisy map has two corners of three with a short edge between.
//!
//! ```text
//!        B                      B
//!     ───●───            ────╲ ╱────       the triangles of A around the upper corner are given to B, so that all four
//!     A  │  C     →       A   ●   C        meet in the lower one
//!     ───●───            ────╱ ╲────
//!        D                      D
//! ```

use super::regions::{Map, Rung};
use super::topology::{Chain, Graph};
use super::trace::meet;
use crate::brep::Surface;
use crate::error::Result;
use crate::mesh::NONE;

/// A count: most sides of an edge that noise may have made, because noise moves a border by a triangle or two.
const NOISY_SIDES: usize = 3;
/// A count: rounds, one more than the sides of the longest such edge, because each takes a side from every edge.
const CONTRACT_ROUNDS: usize = 4;

impl Map<'_> {
    /// Shortens edges whose corners are one point of their surfaces but for the noise, until there are none.
    pub fn contract(&mut self) -> Result<()> {
        if !self.is_noisy() {
            return Ok(());
        }
        for _ in 0..CONTRACT_ROUNDS {
            let graph = Graph::of(self.t, &self.label, self.pieces.len(), &[])?;
            let around = Around::of(&graph);
            let short: Vec<&Chain> = graph.chains.iter().filter(|c| self.is_noise(c, &around)).collect();
            let mut any = false;
            for chain in short {
                any |= self.shorten(chain);
            }
            if !any {
                break;
            }
            self.gather();
        }
        Ok(())
    }

    /// Whether an edge is short, and all surfaces around its two corners pass through one point there, within the noise.
    fn is_noise(&self, chain: &Chain, around: &Around) -> bool {
        let ends = [chain.vertices[0], chain.vertices[chain.vertices.len() - 1]];
        if chain.closed || chain.half_edges.len() > NOISY_SIDES || chain.sides[1] == NONE || ends[0] == ends[1] {
            return false;
        }
        let [at, to] = ends.map(|v| around.at(v));
        if at.len() != 3 || to.len() != 3 {
            return false;
        }
        let all: Vec<u32> = at.iter().chain(to.iter().filter(|p| !at.contains(p))).copied().collect();
        if all.iter().any(|&p| p == NONE || self.pieces[p as usize].rung != Rung::Analytic) {
            return false;
        }
        let surfaces: Vec<&Surface> = all.iter().map(|&p| &self.pieces[p as usize].surface).collect();
        let [a, b] = ends.map(|v| self.t.points()[v as usize]);
        let p = meet(&surfaces, 0.5 * (a + b));
        p.distance(0.5 * (a + b)) <= a.distance(b) && surfaces.iter().all(|s| s.distance(p) <= self.tolerance)
    }

    /// Gives the triangles of the left piece around the first corner to the third piece there; whether there were any.
    fn shorten(&mut self, chain: &Chain) -> bool {
        let [own, right] = chain.sides;
        // Around the corner from the edge to the left, until another piece begins.
        let mut c = chain.half_edges[0];
        let mut fan = Vec::new();
        loop {
            if self.label[c as usize / 3] != own {
                break;
            }
            fan.push(c / 3);
            let o = self.t.opposite(self.t.next(self.t.next(c)));
            if o == NONE || fan.len() > self.label.len() {
                return false;
            }
            c = o;
        }
        let third = self.label[c as usize / 3];
        if third == right || fan.is_empty() || fan.len() >= self.pieces[own as usize].triangles.len() {
            return false;
        }
        fan.iter().for_each(|&k| self.label[k as usize] = third);
        true
    }

    /// Lists the triangles of all pieces anew.
    fn gather(&mut self) {
        self.pieces.iter_mut().for_each(|p| p.triangles.clear());
        for (k, &l) in (0u32..).zip(&self.label) {
            self.pieces[l as usize].triangles.push(k);
        }
        self.compact();
    }
}

/// The pieces around corners.
struct Around {
    /// Vertices and pieces, ascending.
    pairs: Vec<(u32, u32)>,
}

impl Around {
    fn of(graph: &Graph) -> Self {
        let mut pairs: Vec<(u32, u32)> = Vec::new();
        for chain in graph.chains.iter().filter(|c| !c.closed) {
            for v in [chain.vertices[0], chain.vertices[chain.vertices.len() - 1]] {
                pairs.extend(chain.sides.map(|s| (v, s)));
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        Around { pairs }
    }

    fn at(&self, v: u32) -> Vec<u32> {
        let first = self.pairs.partition_point(|p| p.0 < v);
        self.pairs[first..].iter().take_while(|p| p.0 == v).map(|p| p.1).collect()
    }
}
