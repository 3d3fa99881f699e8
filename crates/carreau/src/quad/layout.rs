//! The patches between walls, and how many quads go along each of their sides.
//!
//! The corners of a patch are counted in quarter turns of the frames, not by geometry. A patch that is a disc with four
//! corners is regular. Walls between nodes are arcs; the quads along opposite sides of a patch have to add up to the same
//! number. Every arc starts with its length over the wanted one; a side that has too few or too many gets its due along the
//! cheapest chain of arcs that ends where another patch is off by as much, or at an open border.

use super::sheet::{Sheet, Wall};
use crate::mesh::{DisjointSets, NONE};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Walls between two nodes, one after the other.
#[derive(Debug, Clone)]
pub struct Arc {
    /// From node to node.
    pub vertices: Vec<u32>,
    pub length: f64,
    /// The curve, on a feature.
    pub curve: Option<u32>,
    /// The quads along it.
    pub count: i64,
}

/// An arc as a patch sees it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Side {
    pub arc: u32,
    pub reversed: bool,
}

/// A disc with four sides, counter-clockwise.
#[derive(Debug, Clone)]
pub struct Patch {
    pub triangles: Vec<u32>,
    pub sides: [Vec<Side>; 4],
}

/// What the walls divide a sheet into.
pub struct Layout {
    pub arcs: Vec<Arc>,
    pub patches: Vec<Patch>,
}

/// What is wrong with a patch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// It is no disc: a cut from where this half-edge begins may help.
    NeedsCut(u32),
    /// Its corners are not four.
    Irregular,
}

/// The patch of every triangle.
pub fn patch_of(sheet: &Sheet) -> (Vec<u32>, usize) {
    let mut sets = DisjointSets::new(sheet.triangles.len());
    for h in (0..3 * sheet.triangles.len() as u32).filter(|&h| !sheet.is_wall(h)) {
        if sheet.opposite[h as usize] != NONE {
            sets.union(h / 3, sheet.opposite[h as usize] / 3);
        }
    }
    sets.labels()
}

/// A loop around a patch: its half-edges, and the quads in the corner at the head of each.
type Loop = Vec<(u32, i32)>;

fn loops(sheet: &Sheet, patch: &[u32], patches: usize) -> Option<Vec<Vec<Loop>>> {
    let mut all = vec![Vec::new(); patches];
    let mut seen = vec![false; 3 * sheet.triangles.len()];
    for start in 0..seen.len() as u32 {
        if seen[start as usize] || !sheet.is_wall(start) {
            continue;
        }
        let (mut h, mut list) = (start, Vec::new());
        loop {
            seen[h as usize] = true;
            // The wall that goes on: clockwise from the way back.
            let mut g = Sheet::next(h);
            while !sheet.is_wall(g) {
                g = Sheet::next(sheet.opposite[g as usize]);
            }
            let (k, back) = sheet.sector(g)?;
            if back != h {
                return None;
            }
            list.push((h, k));
            h = g;
            if h == start {
                break;
            }
            if seen[h as usize] {
                return None;
            }
        }
        all[patch[start as usize / 3] as usize].push(list);
    }
    Some(all)
}

/// Looks for patches that are not regular.
pub fn audit(sheet: &Sheet) -> Vec<Fault> {
    let (patch, count) = patch_of(sheet);
    let Some(loops) = loops(sheet, &patch, count) else { return vec![Fault::Irregular] };
    let characteristic = characteristic(sheet, &patch, count);
    let fault = |p: usize| {
        let corners = |list: &Loop| list.iter().filter(|c| c.1 != 2).count();
        let is_bad = loops[p].iter().flatten().any(|c| !(1..=2).contains(&c.1));
        let ones = loops[p].iter().map(corners).sum::<usize>();
        match loops[p].iter().find(|list| corners(list) == 0).or(loops[p].first()) {
            _ if is_bad => Some(Fault::Irregular),
            Some(list) if loops[p].len() > 1 || characteristic[p] != 1 => {
                let straight = list.iter().position(|c| c.1 == 2).map_or(0, |j| j + 1);
                Some(Fault::NeedsCut(list[straight % list.len()].0))
            }
            Some(_) if ones == 4 => None,
            _ => Some(Fault::Irregular),
        }
    };
    (0..count).filter_map(fault).collect()
}

/// Euler number of every patch, as if it were cut out.
fn characteristic(sheet: &Sheet, patch: &[u32], count: usize) -> Vec<i64> {
    let mut number = vec![0i64; count];
    let mut seen = vec![false; 3 * sheet.triangles.len()];
    for h in 0..seen.len() as u32 {
        let own = patch[h as usize / 3] as usize;
        number[own] += i64::from(h % 3 == 0);
        let o = sheet.opposite[h as usize];
        number[own] -= i64::from(sheet.is_wall(h) || o > h);
        if seen[h as usize] {
            continue;
        }
        // A vertex of the patch: a fan between walls.
        number[own] += 1;
        let mut g = h;
        while !sheet.is_wall(g) {
            g = Sheet::next(sheet.opposite[g as usize]);
            if g == h {
                break;
            }
        }
        let first = g;
        loop {
            seen[g as usize] = true;
            let back = Sheet::previous(g);
            if sheet.is_wall(back) {
                break;
            }
            g = sheet.opposite[back as usize];
            if g == first {
                break;
            }
        }
    }
    number
}

impl Layout {
    /// The patches, all of which have to be regular. `is_fixed`: vertices that are nodes in any case.
    pub fn new(sheet: &Sheet, is_fixed: impl Fn(u32) -> bool) -> Option<Self> {
        let (patch, count) = patch_of(sheet);
        let loops = loops(sheet, &patch, count)?;
        let mut is_node: Vec<bool> = (0..sheet.points.len() as u32).map(is_fixed).collect();
        let mut degree = vec![0u32; sheet.points.len()];
        for h in (0..3 * sheet.triangles.len() as u32).filter(|&h| sheet.is_wall(h)) {
            if sheet.opposite[h as usize] == NONE || h < sheet.opposite[h as usize] {
                degree[sheet.tail(h) as usize] += 1;
                degree[sheet.head(h) as usize] += 1;
            }
        }
        is_node.iter_mut().zip(&degree).for_each(|(node, &d)| *node |= d > 2);
        loops.iter().flatten().flatten().filter(|c| c.1 != 2).for_each(|c| is_node[sheet.head(c.0) as usize] = true);
        let mut layout = Layout { arcs: Vec::new(), patches: Vec::new() };
        let mut arc_of = vec![NONE; 3 * sheet.triangles.len()];
        let mut triangles = vec![Vec::new(); count];
        patch.iter().zip(0u32..).for_each(|(&p, t)| triangles[p as usize].push(t));
        for (loops, triangles) in loops.iter().zip(triangles) {
            let [list] = &loops[..] else { return None };
            // From behind a corner.
            let corner = list.iter().position(|c| c.1 == 1)?;
            let turned: Loop = list[corner + 1..].iter().chain(&list[..=corner]).copied().collect();
            let mut sides: [Vec<Side>; 4] = Default::default();
            let (mut side, mut run) = (0, Vec::new());
            for &(h, k) in &turned {
                run.push(h);
                if is_node[sheet.head(h) as usize] {
                    sides.get_mut(side)?.push(layout.arc(sheet, &mut arc_of, &run));
                    run.clear();
                }
                side += usize::from(k == 1);
            }
            layout.patches.push(Patch { triangles, sides });
        }
        layout.patches.iter().all(|p| p.sides.iter().all(|s| !s.is_empty())).then_some(layout)
    }

    /// The arc of a run of half-edges from node to node, from whichever side it was met first.
    fn arc(&mut self, sheet: &Sheet, arc_of: &mut [u32], run: &[u32]) -> Side {
        let known = arc_of[run[0] as usize];
        if known != NONE {
            return Side { arc: known, reversed: true };
        }
        let arc = self.arcs.len() as u32;
        for &h in run {
            let o = sheet.opposite[h as usize];
            if o != NONE {
                arc_of[o as usize] = arc;
            }
        }
        let mut vertices = vec![sheet.tail(run[0])];
        vertices.extend(run.iter().map(|&h| sheet.head(h)));
        let curve = match sheet.wall[run[0] as usize] {
            Wall::Feature(curve) => Some(curve),
            _ => None,
        };
        let length = run.iter().map(|&h| sheet.along(h).length()).sum();
        self.arcs.push(Arc { vertices, length, curve, count: 1 });
        Side { arc, reversed: false }
    }

    /// The number of quads.
    pub fn quads(&self) -> i64 {
        self.patches.iter().map(|p| self.sum(&p.sides[0]) * self.sum(&p.sides[1])).sum()
    }

    fn sum(&self, side: &[Side]) -> i64 {
        side.iter().map(|s| self.arcs[s.arc as usize].count).sum()
    }

    /// Sides 0 and 1 less their opposites.
    fn surplus(&self, patch: usize) -> [i64; 2] {
        let s = &self.patches[patch].sides;
        [self.sum(&s[0]) - self.sum(&s[2]), self.sum(&s[1]) - self.sum(&s[3])]
    }

    /// Chooses the numbers of quads; returns whether all patches add up.
    pub fn quantise(&mut self, length: f64) -> bool {
        for arc in &mut self.arcs {
            arc.count = ((arc.length / length).round() as i64).max(1);
        }
        // Where an arc is part of a patch: the patch and axis, and whether it counts against the surplus.
        let mut uses: Vec<Vec<(u32, i64)>> = vec![Vec::new(); self.arcs.len()];
        for (p, patch) in self.patches.iter().enumerate() {
            for (k, side) in patch.sides.iter().enumerate() {
                let sign = if k < 2 { 1 } else { -1 };
                side.iter().for_each(|s| uses[s.arc as usize].push(((2 * p + k % 2) as u32, sign)));
            }
        }
        let nodes = 2 * self.patches.len();
        let mut surplus: Vec<i64> = (0..nodes).map(|n| self.surplus(n / 2)[n % 2]).collect();
        let mut members: Vec<Vec<(u32, i64)>> = vec![Vec::new(); nodes];
        for (arc, list) in (0u32..).zip(&uses) {
            list.iter().for_each(|&(node, sign)| members[node as usize].push((arc, sign)));
        }
        let budget = 40 * nodes + 1000;
        for _ in 0..budget {
            let Some(start) = (0..nodes).find(|&n| surplus[n] != 0) else { return true };
            let Some(chain) = self.chain(start as u32, &surplus, &uses, &members, length) else { return false };
            for (arc, change) in chain {
                self.arcs[arc as usize].count += change;
                uses[arc as usize].iter().for_each(|&(node, sign)| surplus[node as usize] += sign * change);
            }
        }
        false
    }

    /// The cheapest chain of changes by one that takes one off the surplus of a node and leaves no other one worse.
    ///
    /// A state is a node and the change of its surplus that is still owed.
    fn chain(
        &self,
        start: u32,
        surplus: &[i64],
        uses: &[Vec<(u32, i64)>],
        members: &[Vec<(u32, i64)>],
        length: f64,
    ) -> Option<Vec<(u32, i64)>> {
        let owed = if surplus[start as usize] > 0 { -1 } else { 1 };
        let state = |node: u32, owed: i64| 2 * node as usize + usize::from(owed > 0);
        let mut cost = vec![f64::INFINITY; 2 * surplus.len()];
        let mut from: Vec<Option<(usize, u32, i64)>> = vec![None; 2 * surplus.len()];
        let mut queue = BinaryHeap::new();
        cost[state(start, owed)] = 0.0;
        queue.push(Reverse((0u64, start, owed)));
        while let Some(Reverse((bits, node, owed))) = queue.pop() {
            let so_far = f64::from_bits(bits);
            if so_far > cost[state(node, owed)] {
                continue;
            }
            for &(arc, sign) in &members[node as usize] {
                let change = owed * sign;
                let own = &self.arcs[arc as usize];
                if own.count + change < 1 || uses[arc as usize].iter().filter(|u| u.0 == node).count() != 1 {
                    continue;
                }
                // What the square of the difference from the ideal number grows by, over that number; never negative.
                let ideal = (own.length / length).max(0.5);
                let off = own.count as f64 - ideal;
                let price = (1.0 + (2.0 * off * change as f64 + 1.0).max(0.0)) / ideal;
                let next = uses[arc as usize].iter().find(|u| u.0 != node);
                let done = match next {
                    None => true,
                    // The change goes the right way there, too.
                    Some(&(other, sign)) => surplus[other as usize] * sign * change < 0,
                };
                if done {
                    let mut chain = vec![(arc, change)];
                    let mut at = state(node, owed);
                    while let Some((before, arc, change)) = from[at] {
                        chain.push((arc, change));
                        at = before;
                    }
                    return Some(chain);
                }
                if let Some(&(other, sign)) = next {
                    let debt = -sign * change;
                    let to = state(other, debt);
                    let total = so_far + price;
                    if total < cost[to] {
                        cost[to] = total;
                        from[to] = Some((state(node, owed), arc, change));
                        queue.push(Reverse((total.to_bits(), other, debt)));
                    }
                }
            }
        }
        None
    }
}
