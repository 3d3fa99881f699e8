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

/// Features turn no more than this along a quad of the wanted length, in radians.
const TURN: f64 = 0.4;

/// Numbers of quads stay between these shares of what their length asks for.
const FEWEST: f64 = 0.75;
const MOST: f64 = 1.4;

/// Walls between two nodes, one after the other.
#[derive(Debug, Clone)]
pub struct Arc {
    /// From node to node.
    pub vertices: Vec<u32>,
    /// On features that turn a lot, the length for which they turn as little as they should from quad to quad.
    pub length: f64,
    /// The curve, on a feature.
    pub curve: Option<u32>,
    /// Where its vertices are, in shares of that length.
    pub stations: Vec<f64>,
    /// The quads along it.
    pub count: i64,
}

impl Arc {
    /// The fewest quads along it: one that closes is a loop of its own.
    fn least(&self) -> i64 {
        if self.vertices.first() == self.vertices.last() { 4 } else { 1 }
    }
}

/// An arc as a patch sees it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Side {
    pub arc: u32,
    pub reversed: bool,
}

/// What walls enclose.
#[derive(Debug, Clone)]
pub struct Patch {
    pub triangles: Vec<u32>,
    /// What runs around it, with the patch on the left.
    pub loops: Vec<Vec<Side>>,
    /// The four sides of a disc with four corners, counter-clockwise, as long as they add up.
    pub sides: Option<[Vec<Side>; 4]>,
    pub area: f64,
}

/// What the walls divide a sheet into.
pub struct Layout {
    pub arcs: Vec<Arc>,
    pub patches: Vec<Patch>,
}

/// What is wrong with a patch.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Fault {
    /// It is no disc: a cut from where one of these half-edges begins may help.
    NeedsCut(Vec<u32>),
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
            Some(list) if loops[p].len() > 1 || characteristic[p] != 1 => {
                let after = |j: usize| list[(j + 1) % list.len()].0;
                Some(Fault::NeedsCut((0..list.len()).filter(|&j| list[j].1 == 2).map(after).collect()))
            }
            Some(_) if ones == 4 && !is_bad => None,
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
    /// The patches. `is_fixed`: vertices that are nodes in any case.
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
        // A loop without a node gets one.
        for list in loops.iter().flatten() {
            if !list.iter().any(|c| is_node[sheet.head(c.0) as usize]) {
                is_node[sheet.head(list[0].0) as usize] = true;
            }
        }
        let characteristic = characteristic(sheet, &patch, count);
        let mut layout = Layout { arcs: Vec::new(), patches: Vec::new() };
        let mut arc_of = vec![NONE; 3 * sheet.triangles.len()];
        let mut triangles = vec![Vec::new(); count];
        patch.iter().zip(0u32..).for_each(|(&p, t)| triangles[p as usize].push(t));
        for ((loops, triangles), characteristic) in loops.iter().zip(triangles).zip(characteristic) {
            let corners = loops.iter().flatten().filter(|c| c.1 == 1).count();
            let is_regular = loops.len() == 1
                && characteristic == 1
                && corners == 4
                && loops[0].iter().all(|c| matches!(c.1, 1 | 2));
            let mut around = Vec::new();
            let mut sides: [Vec<Side>; 4] = Default::default();
            for list in loops {
                // From behind a node, or a corner where all sides begin in one.
                let is_start = |c: &(u32, i32)| if is_regular { c.1 == 1 } else { is_node[sheet.head(c.0) as usize] };
                let start = list.iter().position(is_start)?;
                let turned: Loop = list[start + 1..].iter().chain(&list[..=start]).copied().collect();
                let (mut side, mut run, mut all) = (0, Vec::new(), Vec::new());
                for &(h, k) in &turned {
                    run.push(h);
                    if is_node[sheet.head(h) as usize] {
                        let arc = layout.arc(sheet, &mut arc_of, &run);
                        all.push(arc);
                        if is_regular {
                            sides.get_mut(side)?.push(arc);
                        }
                        run.clear();
                    }
                    side += usize::from(k == 1);
                }
                around.push(all);
            }
            let area = triangles.iter().map(|&t| sheet.area(t)).sum();
            let sides = is_regular.then_some(sides).filter(|sides| sides.iter().all(|s| !s.is_empty()));
            layout.patches.push(Patch { triangles, loops: around, sides, area });
        }
        Some(layout)
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
        let turn = |k: usize| match curve {
            Some(_) if k > 0 && k < run.len() => sheet.along(run[k - 1]).angle_between(sheet.along(run[k])),
            _ => 0.0,
        };
        let mut stations = vec![0.0];
        for (k, &h) in run.iter().enumerate() {
            // Half of a turn belongs to the edge before it.
            let turns = 0.5 * (turn(k) + turn(k + 1)) / TURN;
            stations.push(stations[k] + (turns * sheet.length).max(sheet.along(h).length()));
        }
        let length = stations[run.len()].max(f64::MIN_POSITIVE);
        stations.iter_mut().for_each(|s| *s /= length);
        self.arcs.push(Arc { vertices, length, curve, stations, count: 1 });
        Side { arc, reversed: false }
    }

    /// The number of quads: of grids, and where there are none about as many as fit.
    pub fn quads(&self, length: f64) -> f64 {
        let of = |p: &Patch| match &p.sides {
            Some(s) => (self.sum(&s[0]) * self.sum(&s[1])) as f64,
            None => p.area / (length * length),
        };
        self.patches.iter().map(of).sum()
    }

    /// Whether all patches have grids.
    pub fn is_regular(&self) -> bool {
        self.patches.iter().all(|p| p.sides.is_some())
    }

    fn sum(&self, side: &[Side]) -> i64 {
        side.iter().map(|s| self.arcs[s.arc as usize].count).sum()
    }

    /// Sides 0 and 1 less their opposites.
    fn surplus(&self, patch: usize) -> [i64; 2] {
        match &self.patches[patch].sides {
            Some(s) => [self.sum(&s[0]) - self.sum(&s[2]), self.sum(&s[1]) - self.sum(&s[3])],
            None => [0, 0],
        }
    }

    /// Chooses the numbers of quads. Patches that cannot add up lose their sides.
    pub fn quantise_leniently(&mut self, length: f64) {
        while let Err(patch) = self.quantise(length) {
            self.patches[patch].sides = None;
        }
    }

    /// Chooses the numbers of quads, of about a length.
    ///
    /// # Errors
    /// A patch that does not add up.
    pub fn quantise(&mut self, length: f64) -> Result<(), usize> {
        for arc in &mut self.arcs {
            arc.count = ((arc.length / length).round() as i64).max(arc.least());
        }
        // Where an arc is part of a patch: the patch and axis, and whether it counts against the surplus.
        let mut uses: Vec<Vec<(u32, i64)>> = vec![Vec::new(); self.arcs.len()];
        for (p, patch) in self.patches.iter().enumerate() {
            for (k, side) in patch.sides.iter().flatten().enumerate() {
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
            let Some(start) = (0..nodes).find(|&n| surplus[n] != 0) else { return Ok(()) };
            let Some(chain) = self.chain(start as u32, &surplus, &uses, &members, length) else {
                return Err(start / 2);
            };
            for (arc, change) in chain {
                self.arcs[arc as usize].count += change;
                uses[arc as usize].iter().for_each(|&(node, sign)| surplus[node as usize] += sign * change);
            }
        }
        Err(surplus.iter().position(|&s| s != 0).unwrap_or(0) / 2)
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
                let ideal = (own.length / length).max(0.5);
                let count = (own.count + change) as f64;
                let is_far = count < (FEWEST * ideal).floor() || count > (MOST * ideal).ceil() + 1.0;
                if is_far
                    || own.count + change < own.least()
                    || uses[arc as usize].iter().filter(|u| u.0 == node).count() != 1
                {
                    continue;
                }
                // What the square of the difference from the ideal number grows by, over that number; never negative.
                let off = own.count as f64 - ideal;
                let price = (1.0 + (2.0 * off * change as f64 + 1.0).max(0.0)) / ideal;
                let next = uses[arc as usize].iter().find(|u| u.0 != node);
                let done = match next {
                    None => true,
                    // The change goes the right way there, too.
                    Some(&(other, sign)) => {
                        let least = if other == start { 2 } else { 1 };
                        -surplus[other as usize] * sign * change >= least
                    }
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
