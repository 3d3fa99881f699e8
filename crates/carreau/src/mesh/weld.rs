//! Finds vertices at the same place: exactly, or within a tolerance.

use super::triangles::NONE;
use glam::DVec3;
use rustc_hash::FxHashMap;
use std::collections::hash_map::Entry;

/// For every point the first one at exactly the same position (-0 and 0 are the same), itself included.
pub fn first_at_same_position(points: &[DVec3]) -> Vec<u32> {
    // Adding +0 turns -0 into +0 and leaves everything else as it is.
    let bits = |p: &DVec3| p.to_array().map(|x| (x + 0.0).to_bits());
    // A table of ids alone, half of it empty: it is a fraction of the size of one of positions, and every vertex of every mesh
    // comes here.
    let mut table = vec![NONE; (2 * points.len()).next_power_of_two().max(2)];
    let (mask, shift) = (table.len() - 1, u64::BITS - table.len().trailing_zeros());
    let find = |(p, k): (&DVec3, u32)| {
        let own = bits(p);
        // The last round brings the high bits of the last coordinate, in which round numbers differ, down and up again.
        let mixed = own.iter().chain([&0]).fold(0u64, |h, &x| (h.rotate_left(23) ^ x).wrapping_mul(GOLDEN));
        let mut at = (mixed >> shift) as usize;
        loop {
            match table[at] {
                NONE => {
                    table[at] = k;
                    return k;
                }
                other if bits(&points[other as usize]) == own => return other,
                _ => at = (at + 1) & mask,
            }
        }
    };
    points.iter().zip(0u32..).map(find).collect()
}

/// 2⁶⁴ through the golden ratio, odd: its product spreads neighbouring numbers over the high bits (Fibonacci hashing, Knuth).
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// For every point the leader it joins: the nearest leader within `tolerance`, or itself.
///
/// Points come in order, and one that finds no leader near becomes a leader. Leaders are thus farther apart than the
/// tolerance and no point moves by more than it: a chain of close points never collapses as a whole, as it would if
/// closeness were taken to be transitive. Leaders live in a grid with cells of that size, so 27 cells tell.
pub fn leaders_within(points: &[DVec3], tolerance: f64) -> Vec<u32> {
    let (low, high) = points.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)));
    // Below the resolution of the coordinates only equal positions are near, and cells would overflow their numbers.
    let extent = (high - low).max_element();
    if !(tolerance > extent * f64::EPSILON && extent.is_finite()) {
        return first_at_same_position(points);
    }
    let cell_of = |p: DVec3| ((p - low) / tolerance).floor().to_array().map(|x| x as i64);
    let mut grid = LeaderGrid { newest: FxHashMap::default(), older: vec![NONE; points.len()] };
    let mut leader = Vec::with_capacity(points.len());
    for (k, &p) in points.iter().enumerate() {
        let cell = cell_of(p);
        let near = grid.nearest(points, cell, p).filter(|&(distance, _)| distance <= tolerance);
        leader.push(near.map_or(k as u32, |(_, other)| other));
        if near.is_none() {
            grid.insert(cell, k as u32);
        }
    }
    leader
}

/// Leaders by grid cell, as linked lists.
struct LeaderGrid {
    newest: FxHashMap<[i64; 3], u32>,
    older: Vec<u32>,
}

impl LeaderGrid {
    fn insert(&mut self, cell: [i64; 3], k: u32) {
        match self.newest.entry(cell) {
            Entry::Occupied(mut e) => self.older[k as usize] = e.insert(k),
            Entry::Vacant(e) => {
                e.insert(k);
            }
        }
    }

    /// The nearest leader in this cell and those around it; the first of equally near ones.
    fn nearest(&self, points: &[DVec3], [x, y, z]: [i64; 3], p: DVec3) -> Option<(f64, u32)> {
        let mut best = None;
        for cell in (0..27).map(|k| [x + k % 3 - 1, y + k / 3 % 3 - 1, z + k / 9 - 1]) {
            let mut k = self.newest.get(&cell).copied().unwrap_or(NONE);
            while k != NONE {
                let candidate = (p.distance(points[k as usize]), k);
                if best.is_none_or(|b| candidate < b) {
                    best = Some(candidate);
                }
                k = self.older[k as usize];
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn negative_zero_is_zero() {
        let points = [DVec3::X, DVec3::new(0.0, -0.0, 1.0), DVec3::new(-0.0, 0.0, 1.0), DVec3::X];
        assert_eq!(first_at_same_position(&points), [0, 1, 1, 0]);
        assert_eq!(leaders_within(&points, 0.0), [0, 1, 1, 0]);
    }

    #[test]
    fn a_chain_does_not_collapse() {
        let chain: Vec<DVec3> = (0..1000).map(|k| DVec3::X * f64::from(k) * 0.9).collect();
        let leaders = leaders_within(&chain, 1.0);
        assert!(leaders.iter().enumerate().all(|(k, &l)| chain[k].distance(chain[l as usize]) <= 1.0));
        assert!(leaders.iter().enumerate().filter(|&(k, &l)| k == l as usize).count() >= 400);
    }

    proptest! {
        #[test]
        fn leaders_are_apart_and_followers_near(
            points in prop::collection::vec(prop::array::uniform3(-1.0f64..1.0), 1..60),
            tolerance in 0.01f64..1.0,
        ) {
            let points: Vec<DVec3> = points.into_iter().map(DVec3::from_array).collect();
            let leader = leaders_within(&points, tolerance);
            for (k, &l) in leader.iter().enumerate() {
                prop_assert_eq!(leader[l as usize], l);
                prop_assert!(points[k].distance(points[l as usize]) <= tolerance);
                for (other, _) in leader.iter().enumerate().filter(|&(o, &m)| o == m as usize && o != k) {
                    prop_assert!(l as usize != k || points[k].distance(points[other]) > tolerance);
                }
            }
        }
    }
}
