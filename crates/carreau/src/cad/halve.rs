//! Regions that are too much for one spline surface: cut at sharp edges, else in two halves.
//!
//! ```text
//!     ┌───────────┐        ┌─────┬─────┐
//!     │ s0 · · s1 │   ▷    │  s0 │ s1  │     every triangle goes to the nearer of the two that are farthest apart
//!     └───────────┘        └─────┴─────┘
//! ```

use super::regions::{Map, Piece, Rung, area_vector};
use super::unions::UNION_BEND;
use crate::geometry::normals::{angle_between, unit};
use crate::mesh::{DisjointSets, NONE, Triangles};
use glam::DVec3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A count: pieces with fewer triangles are not cut, because their halves would say nothing.
const LEAST_CUT: usize = 12;
/// A count: most cuts of a piece, one after the other, because what 32 parts do not describe is left to facets.
const MOST_CUTS: u8 = 5;
/// A count: rounds in which triangles with both other neighbours beyond the cut change sides, few because only the
/// teeth of a cut do.
const EVEN_ROUNDS: usize = 3;

impl Map<'_> {
    /// Divides the pieces without a surface at sharp edges.
    pub fn part_at_edges(&mut self) {
        for p in 0..self.pieces.len() {
            let piece = &self.pieces[p];
            if piece.rung != Rung::Spline {
                continue;
            }
            let part = Part { t: self.t, label: &self.label, p: p as u32, triangles: &piece.triangles };
            let parts = listed(&part.smooth(), &piece.triangles);
            if parts.len() > 1 {
                self.replace(&[p as u32], parts.into_iter().map(|own| (own, None)).collect());
            }
        }
        self.compact();
    }

    /// Cuts a piece; false where it is not worth it.
    pub fn cut(&mut self, p: u32) -> bool {
        let piece = &self.pieces[p as usize];
        if piece.triangles.len() < LEAST_CUT || piece.cuts >= MOST_CUTS {
            return false;
        }
        let part = Part { t: self.t, label: &self.label, p, triangles: &piece.triangles };
        let mut of = part.smooth();
        if of.iter().all(|&o| o == 0) {
            of = part.halves();
        }
        if of.iter().all(|&o| o == 0) {
            return false;
        }
        let triangles = listed(&of, &piece.triangles);
        let kept = Piece { triangles: Vec::new(), cuts: piece.cuts + 1, rung: Rung::Spline, ..piece.clone() };
        self.pieces[p as usize].triangles.clear();
        for triangles in triangles {
            let id = self.pieces.len() as u32;
            triangles.iter().for_each(|&k| self.label[k as usize] = id);
            let own = self.new_id();
            self.pieces.push(Piece { id: own, triangles, ..kept.clone() });
        }
        true
    }
}

/// The triangles of every part.
fn listed(of: &[u32], triangles: &[u32]) -> Vec<Vec<u32>> {
    let mut parts = vec![Vec::new(); of.iter().copied().max().map_or(0, |m| m as usize + 1)];
    of.iter().zip(triangles).for_each(|(&o, &k)| parts[o as usize].push(k));
    parts
}

struct Part<'a> {
    t: Triangles<'a>,
    label: &'a [u32],
    p: u32,
    /// Ascending.
    triangles: &'a [u32],
}

impl Part<'_> {
    /// The neighbours of a triangle of the part, by their places in the list.
    fn neighbours(&self, at: usize) -> impl Iterator<Item = usize> + '_ {
        let k = self.triangles[at];
        let inside = move |c: u32| {
            let o = self.t.opposite(c);
            (o != NONE && self.label[o as usize / 3] == self.p).then_some(o / 3)
        };
        (3 * k..3 * k + 3).filter_map(inside).filter_map(|n| self.triangles.binary_search(&n).ok())
    }

    /// Parts between sharp edges.
    fn smooth(&self) -> Vec<u32> {
        let normal = |at: usize| unit(area_vector(self.t, self.triangles[at]));
        let mut sets = DisjointSets::new(self.triangles.len());
        for at in 0..self.triangles.len() {
            for n in self.neighbours(at).filter(|&n| n > at) {
                if angle_between(normal(at), normal(n)) < UNION_BEND {
                    sets.union(at as u32, n as u32);
                }
            }
        }
        sets.labels().0
    }

    /// Two halves about the triangles that are farthest apart, connected each.
    fn halves(&self) -> Vec<u32> {
        let far = |seeds: &[usize]| {
            let (distance, _) = self.spread(seeds);
            let best = (0..distance.len()).max_by(|&a, &b| distance[a].total_cmp(&distance[b]).then(b.cmp(&a)));
            best.unwrap_or(0)
        };
        let first = far(&[0]);
        let second = far(&[first]);
        let (_, of) = self.spread(&[first, second]);
        let mut even = of.clone();
        for _ in 0..EVEN_ROUNDS {
            for at in (0..even.len()).filter(|&at| at != first && at != second) {
                let others = self.neighbours(at).filter(|&n| even[n] != even[at]).count();
                if others >= 2 {
                    even[at] = 1 - even[at];
                }
            }
        }
        if self.is_connected(&even) { even } else { of }
    }

    /// Distances from the nearest of some triangles, from middle to middle, and which one it is.
    fn spread(&self, seeds: &[usize]) -> (Vec<f64>, Vec<u32>) {
        let middle = |at: usize| -> DVec3 {
            self.t.triangle(self.triangles[at]).map(|v| self.t.points()[v as usize]).iter().sum::<DVec3>() / 3.0
        };
        let mut distance = vec![f64::INFINITY; self.triangles.len()];
        let mut of = vec![0; self.triangles.len()];
        let mut heap = BinaryHeap::new();
        for (&s, k) in seeds.iter().zip(0u32..) {
            (distance[s], of[s]) = (0.0, k);
            heap.push(Reverse((0u64, s)));
        }
        // Bits of positive doubles sort as they do.
        while let Some(Reverse((bits, at))) = heap.pop() {
            if f64::from_bits(bits) > distance[at] {
                continue;
            }
            for n in self.neighbours(at) {
                let next = distance[at] + middle(at).distance(middle(n));
                if next < distance[n] {
                    (distance[n], of[n]) = (next, of[at]);
                    heap.push(Reverse((next.to_bits(), n)));
                }
            }
        }
        distance.iter_mut().filter(|d| d.is_infinite()).for_each(|d| *d = 0.0);
        (distance, of)
    }

    fn is_connected(&self, of: &[u32]) -> bool {
        let mut sets = DisjointSets::new(of.len());
        for at in 0..of.len() {
            for n in self.neighbours(at).filter(|&n| of[n] == of[at]) {
                sets.union(at as u32, n as u32);
            }
        }
        sets.labels().1 == 2
    }
}
