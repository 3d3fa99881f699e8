//! Rectification by minimum cuts: along the common boundary of every two regions the band of triangles around it is
//! divided anew, by the shortest line where an edge is the longer the worse it follows the lines of curvature, and where
//! every triangle has a price in each of the two regions.
//!
//! The bands of pairs without a common region are independent of each other. Pairs are taken in order, as many at a time as are
//! independent; the result is that of one after the other.
//!
//! A move is rejected when it removes a region or divides one, and, where regions lie on surfaces, when it raises the price of
//! the triangles by themselves: contours get straight, never at the cost of the fit. (The paper's contour following is
//! excellent on parts of revolution and loses faces where tangent contours meet in threes.)

use super::regions::count;
use super::score::Scores;
use super::surface::Surface;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;
use crate::numeric::flow::{CutGraph, Edge};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU32, Ordering};

/// A count: rings of triangles on each side of the old boundary within which a new one stays, because curvature is
/// blurred over about as many.
pub const BAND_RINGS: usize = 3;
/// Price of an edge of the best score, per length: above zero, because of equally good boundaries the shortest is to
/// win.
const BASE_PRICE: f64 = 0.05;
/// A count of steps for the dearest node or edge, because capacities are integers.
const CUT_STEPS: f64 = 1e9;
/// Capacity, in those steps, of what must not be cut: so far below the largest integer, because capacities are added.
const ENDLESS_CAPACITY: i64 = i64::MAX / 1024;

/// What a triangle costs in a region.
type Price<'a> = &'a (dyn Fn(u32, u32) -> f64 + Sync);

/// The smooth edges between two regions.
struct Contact {
    pair: (u32, u32),
    /// Corners on the side of the first.
    edges: Vec<u32>,
}

/// Straightens the boundaries of all pairs of regions, `rounds` times over. `price` says what a triangle costs in a region; with
/// the guard no move may raise the prices by themselves. Returns the number of moves.
pub fn cut(
    surface: &Surface<'_>,
    scores: &Scores<'_>,
    barrier: &[bool],
    label: &mut [u32],
    price: Price<'_>,
    rounds: usize,
    guard: bool,
    context: &Context,
) -> Result<usize> {
    let mut moved = 0;
    // Bands of one wave have no triangle in common: they share the index.
    let index: Vec<AtomicU32> = (0..surface.len()).map(|_| AtomicU32::new(NONE)).collect();
    for _ in 0..rounds {
        let mut size = vec![0usize; count(label)];
        label.iter().filter(|&&l| l != NONE).for_each(|&l| size[l as usize] += 1);
        let mut changed = 0;
        for wave in waves(contacts(surface, barrier, label), size.len()) {
            context.check()?;
            let divide = |contact: &Contact| {
                let band = Band::new(surface, barrier, label, contact, &index);
                band.moves(&band.divide(scores, price), &size, guard.then_some(price))
            };
            let moves: Vec<Vec<(u32, u32)>> = wave.par_iter().map(divide).collect();
            for &(triangle, to) in moves.iter().flatten() {
                size[std::mem::replace(&mut label[triangle as usize], to) as usize] -= 1;
                size[to as usize] += 1;
                changed += 1;
            }
        }
        moved += changed;
        if changed == 0 {
            break;
        }
    }
    Ok(moved)
}

/// The contacts of every two regions, in order of the pairs.
fn contacts(surface: &Surface<'_>, barrier: &[bool], label: &[u32]) -> Vec<Contact> {
    let between = |c: u32| {
        let (a, b) = (label[c as usize / 3], label[surface.across(c, barrier)? as usize]);
        (a < b && b != NONE).then_some(((a, b), c))
    };
    let mut edges: Vec<_> = (0..barrier.len() as u32).into_par_iter().filter_map(between).collect();
    edges.par_sort_unstable();
    let contact =
        |group: &[((u32, u32), u32)]| Contact { pair: group[0].0, edges: group.iter().map(|e| e.1).collect() };
    edges.chunk_by(|x, y| x.0 == y.0).map(contact).collect()
}

/// Contacts in groups that have no region twice; those of one region stay in order.
fn waves(contacts: Vec<Contact>, regions: usize) -> Vec<Vec<Contact>> {
    let mut waves: Vec<Vec<Contact>> = Vec::new();
    let mut next = vec![0usize; regions];
    for contact in contacts {
        let (a, b) = (contact.pair.0 as usize, contact.pair.1 as usize);
        let wave = next[a].max(next[b]);
        (next[a], next[b]) = (wave + 1, wave + 1);
        if wave == waves.len() {
            waves.push(Vec::new());
        }
        waves[wave].push(contact);
    }
    waves
}

/// The triangles of two regions around their common boundary.
struct Band<'a> {
    surface: &'a Surface<'a>,
    pair: (u32, u32),
    members: Vec<u32>,
    /// The members across the three edges of every member; [`NONE`] where there is none.
    adjacent: Vec<[u32; 3]>,
    /// Whether a member has a neighbour of its own region outside.
    anchored: Vec<bool>,
    old: Vec<bool>,
}

impl<'a> Band<'a> {
    fn new(surface: &'a Surface<'a>, barrier: &[bool], label: &[u32], contact: &Contact, index: &[AtomicU32]) -> Self {
        let (t, pair) = (surface.triangles, contact.pair);
        let mut members = Vec::new();
        let enter = |triangle: u32, members: &mut Vec<u32>| {
            if index[triangle as usize].load(Ordering::Relaxed) == NONE {
                index[triangle as usize].store(members.len() as u32, Ordering::Relaxed);
                members.push(triangle);
            }
        };
        // An earlier pair may have moved the boundary since the edges were listed.
        let own = |triangle: u32| label[triangle as usize] == pair.0 || label[triangle as usize] == pair.1;
        for &c in &contact.edges {
            let o = t.opposite(c);
            if own(c / 3) && own(o / 3) {
                enter(c / 3, &mut members);
                enter(o / 3, &mut members);
            }
        }
        let across = |m: u32, k: u32| surface.across(3 * m + k, barrier).filter(|&n| own(n));
        let mut from = 0;
        for _ in 1..BAND_RINGS * 2 {
            let to = members.len();
            for k in from..to {
                let m: u32 = members[k];
                (0..3).filter_map(|k| across(m, k)).for_each(|n| enter(n, &mut members));
            }
            from = to;
        }
        let mut anchored = vec![false; members.len()];
        let mut adjacent = vec![[NONE; 3]; members.len()];
        for (k, &m) in members.iter().enumerate() {
            for side in 0..3 {
                if let Some(n) = across(m, side) {
                    adjacent[k][side as usize] = index[n as usize].load(Ordering::Relaxed);
                    anchored[k] |= adjacent[k][side as usize] == NONE;
                }
            }
        }
        members.iter().for_each(|&m| index[m as usize].store(NONE, Ordering::Relaxed));
        let old = members.iter().map(|&m| label[m as usize] == pair.0).collect();
        Band { surface, pair, members, adjacent, anchored, old }
    }

    /// Whether every member belongs to the first region now.
    fn divide(&self, scores: &Scores<'_>, price: Price<'_>) -> Vec<bool> {
        let mut edges = Vec::with_capacity(2 * self.members.len());
        for ((k, &m), adjacent) in (0u32..).zip(&self.members).zip(&self.adjacent) {
            for (c, &other) in (3 * m..).zip(adjacent) {
                if other != NONE && k < other {
                    edges.push(([k, other], self.surface.edge_length(c) * (BASE_PRICE + scores.score(c))));
                }
            }
        }
        let prices: Vec<[f64; 2]> =
            self.members.iter().map(|&m| [price(m, self.pair.0), price(m, self.pair.1)]).collect();
        let top = edges.iter().map(|e| e.1).chain(prices.iter().flatten().copied()).fold(0.0, f64::max);
        if top <= 0.0 {
            return self.old.clone();
        }
        let steps = |x: f64| (x / top * CUT_STEPS) as i64;
        let anchor =
            |k: usize, first: bool| if self.anchored[k] && self.old[k] == first { ENDLESS_CAPACITY } else { 0 };
        let graph = CutGraph {
            edges: edges.into_iter().map(|(ends, x)| Edge { ends, capacity: steps(x) }).collect(),
            // Cutting a node from the source puts it into the second region, at the price it has there.
            source: (0..prices.len()).map(|k| anchor(k, true) + steps(prices[k][1])).collect(),
            sink: (0..prices.len()).map(|k| anchor(k, false) + steps(prices[k][0])).collect(),
        };
        graph.min_cut()
    }

    /// The triangles that change sides and their new regions; none where the guard objects. `size` holds the number of
    /// triangles of every region.
    fn moves(&self, sides: &[bool], size: &[usize], guard: Option<Price<'_>>) -> Vec<(u32, u32)> {
        let (a, b) = self.pair;
        let changes: Vec<usize> = (0..sides.len()).filter(|&k| sides[k] != self.old[k]).collect();
        let gained = changes.iter().filter(|&&k| sides[k]).count();
        let lost = changes.len() - gained;
        let sizes = [size[a as usize] + gained - lost, size[b as usize] + lost - gained];
        let name = |first: bool| if first { a } else { b };
        let dearer = |price: Price<'_>| {
            let change = |&k: &usize| price(self.members[k], name(sides[k])) - price(self.members[k], name(!sides[k]));
            changes.iter().map(change).sum::<f64>() > 1e-12 * self.surface.total_area.sqrt()
        };
        let refused = sizes.contains(&0) || guard.is_some_and(dearer);
        if changes.is_empty() || refused || self.pieces(sides) > self.pieces(&self.old) {
            return Vec::new();
        }
        changes.iter().map(|&k| (self.members[k], name(sides[k]))).collect()
    }

    /// Number of connected pieces of both sides within the band, where all that is anchored to a region is one piece.
    fn pieces(&self, sides: &[bool]) -> usize {
        let mut seen = self.anchored.clone();
        let mut stack: Vec<u32> = (0..sides.len() as u32).filter(|&k| self.anchored[k as usize]).collect();
        let mut count = 0;
        let mut next = 0;
        loop {
            while let Some(k) = stack.pop() {
                for &n in self.adjacent[k as usize].iter().filter(|&&n| n != NONE) {
                    if !seen[n as usize] && sides[n as usize] == sides[k as usize] {
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn waves_have_no_region_twice_and_keep_the_order_of_each(mut pairs in prop::collection::vec((0u32..9, 0u32..9), 0..40)) {
            pairs.retain(|(a, b)| a < b);
            pairs.sort_unstable();
            pairs.dedup();
            let contact = |&pair: &(u32, u32)| Contact { pair, edges: Vec::new() };
            let waves = waves(pairs.iter().map(contact).collect(), 9);
            let mut seen: Vec<Vec<(u32, u32)>> = vec![Vec::new(); 9];
            for wave in &waves {
                let mut regions: Vec<u32> = wave.iter().flat_map(|c| [c.pair.0, c.pair.1]).collect();
                regions.sort_unstable();
                prop_assert!(regions.windows(2).all(|w| w[0] < w[1]));
                wave.iter().for_each(|c| [c.pair.0, c.pair.1].iter().for_each(|&r| seen[r as usize].push(c.pair)));
            }
            for (region, seen) in (0u32..).zip(seen) {
                let own = |&&(a, b): &&(u32, u32)| a == region || b == region;
                prop_assert_eq!(seen, pairs.iter().filter(own).copied().collect::<Vec<_>>());
            }
        }
    }
}
