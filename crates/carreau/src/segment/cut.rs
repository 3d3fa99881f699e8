//! Rectification by minimum cuts: along the common boundary of every two regions the band of triangles around it is
//! divided anew, by the shortest line where an edge is the longer the worse it follows the lines of curvature, and where
//! every triangle has a price in each of the two regions.
//!
//! A move is rejected when it removes a region or divides one, and, where regions lie on surfaces, when it raises the price of
//! the triangles by themselves: contours get straight, never at the cost of the fit. (The paper's contour following is
//! excellent on parts of revolution and loses faces where tangent contours meet in threes.)

use super::score::Scores;
use super::surface::Surface;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;
use crate::numeric::flow::{CutGraph, Edge};
use rustc_hash::FxHashMap;

/// Rings of triangles on each side of a boundary.
const BAND: usize = 4;
/// Price of an edge of the best score, per length.
const BASE: f64 = 0.05;
/// Capacities are integers: this many steps for the dearest node or edge.
const STEPS: f64 = 1e9;
const ENDLESS: i64 = i64::MAX / 1024;

/// Straightens the boundaries of all pairs of regions, `rounds` times over. `price` says what a triangle costs in a region; with
/// the guard no move may raise the prices by themselves.
pub fn cut(
    surface: &Surface<'_>,
    scores: &Scores<'_>,
    barrier: &[bool],
    label: &mut [u32],
    price: &(dyn Fn(u32, u32) -> f64 + Sync),
    rounds: usize,
    guard: bool,
    context: &Context,
) -> Result<usize> {
    let mut moved = 0;
    for _ in 0..rounds {
        let mut size = vec![0usize; label.iter().filter(|&&l| l != NONE).max().map_or(0, |&m| m as usize + 1)];
        label.iter().filter(|&&l| l != NONE).for_each(|&l| size[l as usize] += 1);
        let mut changed = 0;
        for (pair, boundary) in boundaries(surface, barrier, label) {
            context.check()?;
            let band = Band::new(surface, barrier, label, pair, &boundary);
            let sides = band.divide(scores, price);
            changed += band.apply(label, &mut size, &sides, guard.then_some(price));
        }
        moved += changed;
        if changed == 0 {
            break;
        }
    }
    Ok(moved)
}

/// The smooth edges between every two regions, in order of the pairs.
fn boundaries(surface: &Surface<'_>, barrier: &[bool], label: &[u32]) -> Vec<((u32, u32), Vec<u32>)> {
    let mut edges: FxHashMap<(u32, u32), Vec<u32>> = FxHashMap::default();
    for c in 0..barrier.len() as u32 {
        let Some(n) = surface.across(c, barrier) else { continue };
        let (a, b) = (label[c as usize / 3], label[n as usize]);
        if a < b && b != NONE {
            edges.entry((a, b)).or_default().push(c);
        }
    }
    let mut all: Vec<_> = edges.into_iter().collect();
    all.sort_unstable();
    all
}

/// The triangles of two regions around their common boundary.
struct Band<'a> {
    surface: &'a Surface<'a>,
    barrier: &'a [bool],
    pair: (u32, u32),
    members: Vec<u32>,
    index: FxHashMap<u32, u32>,
    /// Whether a member has a neighbour of its own region outside.
    anchored: Vec<bool>,
    old: Vec<bool>,
}

impl<'a> Band<'a> {
    fn new(surface: &'a Surface<'a>, barrier: &'a [bool], label: &[u32], pair: (u32, u32), boundary: &[u32]) -> Self {
        let t = surface.triangles;
        let (mut members, mut index) = (Vec::new(), FxHashMap::default());
        let enter = |triangle: u32, members: &mut Vec<u32>, index: &mut FxHashMap<u32, u32>| {
            index.entry(triangle).or_insert_with(|| {
                members.push(triangle);
                members.len() as u32 - 1
            });
        };
        // An earlier pair may have moved the boundary since the edges were listed.
        let own = |triangle: u32| label[triangle as usize] == pair.0 || label[triangle as usize] == pair.1;
        for &c in boundary {
            let o = t.opposite(c);
            if own(c / 3) && own(o / 3) {
                enter(c / 3, &mut members, &mut index);
                enter(o / 3, &mut members, &mut index);
            }
        }
        let mut from = 0;
        for _ in 1..BAND * 2 {
            let to = members.len();
            for k in from..to {
                let m: u32 = members[k];
                for n in (3 * m..3 * m + 3).filter_map(|c| surface.across(c, barrier)).filter(|&n| own(n)) {
                    enter(n, &mut members, &mut index);
                }
            }
            from = to;
        }
        let outside = |&m: &u32| {
            (3 * m..3 * m + 3).filter_map(|c| surface.across(c, barrier)).any(|n| own(n) && !index.contains_key(&n))
        };
        let anchored = members.iter().map(outside).collect();
        let old = members.iter().map(|&m| label[m as usize] == pair.0).collect();
        Band { surface, barrier, pair, members, index, anchored, old }
    }

    /// Whether every member belongs to the first region now.
    fn divide(&self, scores: &Scores<'_>, price: &(dyn Fn(u32, u32) -> f64 + Sync)) -> Vec<bool> {
        let mut edges = Vec::new();
        for (k, &m) in self.members.iter().enumerate() {
            for c in 3 * m..3 * m + 3 {
                let Some(other) = self.surface.across(c, self.barrier).and_then(|n| self.index.get(&n)) else {
                    continue;
                };
                if (k as u32) < *other {
                    edges.push(([k as u32, *other], self.surface.edge_length(c) * (BASE + scores.score(c))));
                }
            }
        }
        let prices: Vec<[f64; 2]> =
            self.members.iter().map(|&m| [price(m, self.pair.0), price(m, self.pair.1)]).collect();
        let top = edges.iter().map(|e| e.1).chain(prices.iter().flatten().copied()).fold(0.0, f64::max);
        if top <= 0.0 {
            return self.old.clone();
        }
        let steps = |x: f64| (x / top * STEPS) as i64;
        let anchor = |k: usize, first: bool| if self.anchored[k] && self.old[k] == first { ENDLESS } else { 0 };
        let graph = CutGraph {
            edges: edges.into_iter().map(|(ends, x)| Edge { ends, capacity: steps(x) }).collect(),
            // Cutting a node from the source puts it into the second region, at the price it has there.
            source: (0..prices.len()).map(|k| anchor(k, true) + steps(prices[k][1])).collect(),
            sink: (0..prices.len()).map(|k| anchor(k, false) + steps(prices[k][0])).collect(),
        };
        graph.min_cut()
    }

    /// Takes the new sides over unless the guard objects; returns the number of triangles that changed.
    fn apply(
        &self,
        label: &mut [u32],
        size: &mut [usize],
        sides: &[bool],
        guard: Option<&(dyn Fn(u32, u32) -> f64 + Sync)>,
    ) -> usize {
        let (a, b) = self.pair;
        let changes: Vec<usize> = (0..sides.len()).filter(|&k| sides[k] != self.old[k]).collect();
        if changes.is_empty() {
            return 0;
        }
        let gained = changes.iter().filter(|&&k| sides[k]).count();
        let lost = changes.len() - gained;
        let sizes = [size[a as usize] + gained - lost, size[b as usize] + lost - gained];
        let name = |first: bool| if first { a } else { b };
        let dearer = |price: &(dyn Fn(u32, u32) -> f64 + Sync)| {
            let change = |&k: &usize| price(self.members[k], name(sides[k])) - price(self.members[k], name(!sides[k]));
            changes.iter().map(change).sum::<f64>() > 1e-12 * self.surface.total_area.sqrt()
        };
        if sizes.contains(&0) || guard.is_some_and(dearer) {
            return 0;
        }
        changes.iter().for_each(|&k| label[self.members[k] as usize] = name(sides[k]));
        if self.pieces(sides) > self.pieces(&self.old) {
            changes.iter().for_each(|&k| label[self.members[k] as usize] = name(!sides[k]));
            return 0;
        }
        (size[a as usize], size[b as usize]) = (sizes[0], sizes[1]);
        changes.len()
    }

    /// Number of connected pieces of both sides within the band, where all that is anchored to a region is one piece.
    fn pieces(&self, sides: &[bool]) -> usize {
        let mut seen = vec![false; sides.len()];
        let mut stack: Vec<u32> = (0..sides.len() as u32).filter(|&k| self.anchored[k as usize]).collect();
        stack.iter().for_each(|&k| seen[k as usize] = true);
        let mut count = 0;
        let mut next = 0;
        loop {
            while let Some(k) = stack.pop() {
                let m = self.members[k as usize];
                for n in (3 * m..3 * m + 3).filter_map(|c| self.surface.across(c, self.barrier)) {
                    if let Some(&n) = self.index.get(&n)
                        && !seen[n as usize]
                        && sides[n as usize] == sides[k as usize]
                    {
                        seen[n as usize] = true;
                        stack.push(n);
                    }
                }
            }
            match seen[next..].iter().position(|s| !s) {
                Some(k) => {
                    next += k;
                    seen[next] = true;
                    count += 1;
                    stack.push(next as u32);
                }
                None => return count,
            }
        }
    }
}
