//! Patches with holes are cut open, along the shortest path of edges between two of their loops, where the frames have not
//! led a track across.

use super::layout::{loops, patch_of};
use super::sheet::{Sheet, Wall};
use crate::mesh::NONE;
use rustc_hash::{FxHashMap, FxHashSet};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A count: cuts that open the holes of one surface at most, because each goes over all of it.
const MOST_HOLE_CUTS: usize = 500;

/// Cuts patches until each has one loop, where there is a way from one to another. Returns the vertices of the cuts.
pub fn open_holes(sheet: &mut Sheet) -> Vec<Vec<u32>> {
    let (mut cuts, mut given_up) = (Vec::new(), FxHashSet::default());
    for _ in 0..MOST_HOLE_CUTS {
        let (patch, count) = patch_of(sheet);
        let Some(loops) = loops(sheet, &patch, count) else { break };
        let closed = |p: &usize| loops[*p].len() > 1 && !given_up.contains(&loops[*p][0][0].0);
        let Some(p) = (0..count).find(closed) else { break };
        let around: Vec<Vec<u32>> =
            loops[p].iter().map(|list| list.iter().map(|&(h, _)| sheet.head(h)).collect()).collect();
        let triangles: Vec<u32> = (0..patch.len() as u32).filter(|&t| patch[t as usize] as usize == p).collect();
        match path(sheet, &triangles, &around) {
            Some(path) => {
                let vertices =
                    path.first().map(|&h| sheet.head(h)).into_iter().chain(path.iter().map(|&h| sheet.tail(h)));
                cuts.push(vertices.collect());
                path.into_iter().for_each(|h| sheet.set_wall(h, Wall::Cut, 0));
            }
            None => {
                given_up.insert(loops[p][0][0].0);
            }
        }
    }
    cuts
}

/// The shortest path of half-edges inside a patch from its first loop to another one.
fn path(sheet: &Sheet, triangles: &[u32], loops: &[Vec<u32>]) -> Option<Vec<u32>> {
    let mut leaving: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
    for h in triangles.iter().flat_map(|t| 3 * t..3 * t + 3).filter(|&h| !sheet.is_wall(h)) {
        leaving.entry(sheet.tail(h)).or_default().push(h);
    }
    let first: FxHashSet<u32> = loops.first()?.iter().copied().collect();
    let others: FxHashSet<u32> = loops[1..].iter().flatten().copied().filter(|v| !first.contains(v)).collect();
    // Of every vertex the distance and the half-edge that leads to it.
    let mut reached: FxHashMap<u32, (f64, u32)> = FxHashMap::default();
    let mut queue = BinaryHeap::new();
    for &v in &loops[0] {
        reached.insert(v, (0.0, NONE));
        queue.push(Reverse((0u64, v)));
    }
    while let Some(Reverse((bits, v))) = queue.pop() {
        // Lengths are not negative: their bits are ordered as they are.
        let so_far = f64::from_bits(bits);
        if reached.get(&v).is_none_or(|r| so_far > r.0) {
            continue;
        }
        if others.contains(&v) {
            let mut path = Vec::new();
            let mut at = v;
            while let Some(&(_, h)) = reached.get(&at).filter(|r| r.1 != NONE) {
                path.push(h);
                at = sheet.tail(h);
            }
            return Some(path);
        }
        for &h in leaving.get(&v).into_iter().flatten() {
            let w = sheet.head(h);
            let to = so_far + sheet.along(h).length();
            if !first.contains(&w) && reached.get(&w).is_none_or(|r| to < r.0) {
                reached.insert(w, (to, h));
                queue.push(Reverse((to.to_bits(), w)));
            }
        }
    }
    None
}
