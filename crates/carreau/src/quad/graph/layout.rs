//! The patches between walls, their sides, and the arcs that these are made of.
//!
//! The corners of a patch are counted in quarter turns of the frames, not by geometry. A patch that is a disc with four
//! corners is regular. Walls between nodes are arcs.

use super::sheet::{Sheet, Wall};
use crate::mesh::{DisjointSets, NONE};
use std::f64::consts::FRAC_PI_2;

/// Walls between two nodes, one after the other.
#[derive(Debug, Clone)]
pub struct Arc {
    /// From node to node.
    pub vertices: Vec<u32>,
    /// The curve, on a feature.
    pub curve: Option<u32>,
}

/// An arc as a patch sees it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Side {
    pub arc: u32,
    pub reversed: bool,
    /// The half-edges along it inside the patch, in the patch's sense.
    pub halves: Vec<u32>,
}

/// What walls enclose.
#[derive(Debug, Clone)]
pub struct Patch {
    pub triangles: Vec<u32>,
    /// What runs around it, with the patch on the left.
    pub loops: Vec<Vec<Side>>,
    pub corners: usize,
    /// Its Euler number, as if it were cut out.
    pub euler: i64,
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

/// The loops around every patch.
pub fn loops(sheet: &Sheet, patch: &[u32], patches: usize) -> Option<Vec<Vec<Loop>>> {
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
            let sector = sheet.sector(g)?;
            if sector.back != h {
                return None;
            }
            // Cuts have no part in the frames.
            let is_cut = [h, g].iter().any(|&x| sheet.wall[x as usize] == Wall::Cut);
            list.push((h, if is_cut { (sector.angle / FRAC_PI_2).round().max(1.0) as i32 } else { sector.quads }));
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
    /// The patches; `is_fixed`: vertices that are nodes in any case.
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
        for ((loops, triangles), euler) in loops.iter().zip(triangles).zip(characteristic) {
            let corners = loops.iter().flatten().filter(|c| c.1 == 1).count();
            let mut around = Vec::new();
            for list in loops {
                // From behind a corner, or a node.
                let start = list.iter().position(|c| c.1 == 1);
                let start = start.or_else(|| list.iter().position(|c| is_node[sheet.head(c.0) as usize]))?;
                let (mut run, mut all) = (Vec::new(), Vec::new());
                for &(h, _) in list[start + 1..].iter().chain(&list[..=start]) {
                    run.push(h);
                    if is_node[sheet.head(h) as usize] {
                        all.push(layout.side(sheet, &mut arc_of, &run));
                        run.clear();
                    }
                }
                around.push(all);
            }
            let area = triangles.iter().map(|&t| sheet.area(t)).sum();
            layout.patches.push(Patch { triangles, loops: around, corners, euler, area });
        }
        Some(layout)
    }

    /// A run of half-edges from node to node, and its arc, from whichever side that was met first.
    fn side(&mut self, sheet: &Sheet, arc_of: &mut [u32], run: &[u32]) -> Side {
        let known = arc_of[run[0] as usize];
        if known != NONE {
            return Side { arc: known, reversed: true, halves: run.to_vec() };
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
        self.arcs.push(Arc { vertices, curve });
        Side { arc, reversed: false, halves: run.to_vec() }
    }
}
