//! The patches between walls, their sides, and the arcs that these are made of.
//!
//! The corners of a patch are counted in quarter turns of the frames, not by geometry. A patch that is a disc with four
//! corners is regular. Walls between nodes are arcs.

use super::chords::fewest;
use super::gaps::Tight;
use super::graft::Strand;
use super::sheet::{Sheet, Wall};
use super::source::Source;
use super::ticks::Bends;
use crate::geometry::normals::unit;
use crate::geometry::search_tree::TriangleTree;
use crate::mesh::{DisjointSets, NONE};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::FRAC_PI_2;

/// Features turn no more than this along a quad of the wanted length, in radians.
const TURN: f64 = 0.4;

/// The same for any length: with more an edge would not run along its feature.
const MOST_TURN: f64 = 0.45;

/// A place is near an arc within this share of the length of quads.
const NEAR: f64 = 0.3;

/// Cosine of the angle up to which an arc leads along a way.
const ALONG: f64 = 0.6;

/// No place asks for edges shorter than this share of the wanted length.
const SHORTEST: f64 = 0.25;

/// Features ask for so many times more quads than a length does, no more.
const MANY: f64 = 1.2;

/// Discs with more corners take no pattern.
const MOST_CORNERS: usize = 8;

/// A whole number of quads along an arc: no more than there can be vertices, however long an arc without measure would have it.
pub fn whole(quads: f64) -> i64 {
    quads.min(f64::from(u32::MAX)) as i64
}

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
    /// Where its feature bends: vertices go there.
    pub bends: Bends,
    /// The number of quads that it should have whatever their length: beside a region that takes those of rung 3.
    pub given: Option<f64>,
    /// Quads that it has at least.
    pub least: i64,
    /// Quads that patches beside it need, as long as these have no grid.
    pub room: i64,
    /// The quads along it.
    pub count: i64,
}

impl Arc {
    /// How many quads it would have for itself.
    pub fn ideal(&self, length: f64) -> f64 {
        self.given.unwrap_or(self.length / length)
    }
}

/// An arc as a patch sees it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Side {
    pub arc: u32,
    pub reversed: bool,
    /// The half-edges along it inside the patch, in the patch's sense.
    pub halves: Vec<u32>,
}

/// What a patch is filled with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A grid: its opposite sides agree.
    Grid,
    /// A pattern: it is a disc with few corners.
    Pattern,
    /// Triangles, paired and halved.
    Triangles,
    /// The quads of rung 3.
    Grafted,
}

/// What walls enclose.
#[derive(Debug, Clone)]
pub struct Patch {
    pub kind: Kind,
    pub triangles: Vec<u32>,
    /// What runs around it, with the patch on the left.
    pub loops: Vec<Vec<Side>>,
    /// The sides of a disc from corner to corner, counter-clockwise; one that closes where there is no corner.
    pub sides: Vec<Vec<Side>>,
    pub corners: usize,
    /// Its Euler number, as if it were cut out.
    pub euler: i64,
    pub area: f64,
}

/// What the walls divide a sheet into.
pub struct Layout {
    pub arcs: Vec<Arc>,
    pub patches: Vec<Patch>,
    /// The length that numbers of quads were chosen for.
    pub length: f64,
    /// Steps of the searches for them so far.
    pub steps: u64,
    /// Curves beside grafted patches, whose arcs have to have the right number of quads together.
    pub strands: Vec<Strand>,
    /// The quads of grafted patches.
    pub grafted: usize,
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
    /// The patches. `sag`: how far edges may be from the features that they are on; `is_fixed`: vertices that are nodes in
    /// any case.
    pub fn new(sheet: &Sheet, sag: f64, is_fixed: impl Fn(u32) -> bool) -> Option<Self> {
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
        let mut layout = Layout {
            arcs: Vec::new(),
            patches: Vec::new(),
            length: sheet.length,
            steps: 0,
            strands: Vec::new(),
            grafted: 0,
        };
        let mut arc_of = vec![NONE; 3 * sheet.triangles.len()];
        let mut triangles = vec![Vec::new(); count];
        patch.iter().zip(0u32..).for_each(|(&p, t)| triangles[p as usize].push(t));
        for ((loops, triangles), characteristic) in loops.iter().zip(triangles).zip(characteristic) {
            let corners = loops.iter().flatten().filter(|c| c.1 == 1).count();
            let is_disc = loops.len() == 1 && characteristic == 1;
            let is_regular = is_disc && corners == 4 && loops[0].iter().all(|c| matches!(c.1, 1 | 2));
            let kind = match is_disc && corners <= MOST_CORNERS {
                true if is_regular => Kind::Grid,
                true => Kind::Pattern,
                false => Kind::Triangles,
            };
            let (mut around, mut sides) = (Vec::new(), vec![Vec::new(); corners.max(1)]);
            for list in loops {
                // From behind a corner, or a node.
                let start = list.iter().position(|c| c.1 == 1);
                let start = start.or_else(|| list.iter().position(|c| is_node[sheet.head(c.0) as usize]))?;
                let turned: Loop = list[start + 1..].iter().chain(&list[..=start]).copied().collect();
                let (mut side, mut run, mut all) = (0, Vec::new(), Vec::new());
                for &(h, k) in &turned {
                    run.push(h);
                    if is_node[sheet.head(h) as usize] {
                        let arc = layout.arc(sheet, sag, &mut arc_of, &run);
                        if is_disc {
                            sides.get_mut(side)?.push(arc.clone());
                        }
                        all.push(arc);
                        run.clear();
                    }
                    side += usize::from(k == 1);
                }
                around.push(all);
            }
            let area = triangles.iter().map(|&t| sheet.area(t)).sum();
            layout.patches.push(Patch { kind, triangles, loops: around, sides, corners, euler: characteristic, area });
        }
        Some(layout)
    }

    /// The arc of a run of half-edges from node to node, from whichever side it was met first.
    fn arc(&mut self, sheet: &Sheet, sag: f64, arc_of: &mut [u32], run: &[u32]) -> Side {
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
        let turn = |k: usize| match curve {
            Some(_) if k > 0 && k < run.len() => sheet.along(run[k - 1]).angle_between(sheet.along(run[k])),
            _ => 0.0,
        };
        // One that closes is a loop of its own.
        let closed: i64 = if vertices.first() == vertices.last() { 4 } else { 1 };
        let turns: f64 = (1..run.len()).map(turn).sum();
        // A chord of length l that turns by a is a l / 8 away from its arc.
        let way: f64 = run.iter().map(|&h| sheet.along(h).length()).sum();
        let by_sag = (turns * way / (8.0 * sag)).sqrt();
        let least = closed.max(whole((turns / MOST_TURN).max(by_sag).ceil()));
        let mut stations = vec![0.0];
        for (k, &h) in run.iter().enumerate() {
            // Half of a turn belongs to the edge before it.
            let turns = 0.5 * (turn(k) + turn(k + 1)) / TURN;
            stations.push(stations[k] + (turns * sheet.length).max(sheet.along(h).length()));
        }
        let length = stations[run.len()].max(f64::MIN_POSITIVE);
        stations.iter_mut().for_each(|s| *s /= length);
        let bends = Bends::default();
        self.arcs.push(Arc { vertices, length, curve, stations, bends, given: None, least, room: 0, count: least });
        Side { arc, reversed: false, halves: run.to_vec() }
    }

    /// The number of quads: of grids, and where there are none about as many as fit.
    pub fn quads(&self) -> f64 {
        let of = |p: &Patch| match p.kind {
            Kind::Grid => self.sum(&p.sides[0]) as f64 * self.sum(&p.sides[1]) as f64,
            Kind::Grafted => 0.0,
            _ => p.area / (self.length * self.length),
        };
        self.grafted as f64 + self.patches.iter().map(of).sum::<f64>()
    }

    /// The edges along all arcs.
    pub fn edges(&self) -> f64 {
        self.arcs.iter().map(|arc| arc.count as f64).sum()
    }

    /// The arcs that have grafted patches beside them only: nothing is needed along these.
    pub fn inside(&self) -> Vec<bool> {
        let mut inside = vec![true; self.arcs.len()];
        let others = self.patches.iter().filter(|p| p.kind != Kind::Grafted);
        others.flat_map(|p| p.loops.iter().flatten()).for_each(|side| inside[side.arc as usize] = false);
        inside
    }

    /// Gives arcs the quads whose edges keep their features within a distance, unless these are many more than a length
    /// asks for, or than `most`.
    pub fn keep_features(&mut self, sheet: &Sheet, source: &Source, length: f64, near: f64, most: f64, deals: bool) {
        // Where vertices go to bends afterwards, nobody knows yet which chords there will be.
        let is_known = |arc: &Arc| deals || arc.curve.is_none_or(|curve| !source.bends.contains_key(&curve));
        let arcs = self.arcs.par_iter_mut().filter(|arc| arc.given.is_none() && is_known(arc));
        arcs.for_each(|arc| {
            let most = whole((MANY * arc.length / length).min(most).ceil());
            arc.least = fewest(sheet, source, arc, most, near).unwrap_or(arc.least);
        });
    }

    /// Gives arcs more quads than a length asks for where their feature was lost near them: one, then three, seven. `lost`
    /// holds curves and places, round by round.
    pub fn refine(&mut self, sheet: &Sheet, lost: &[Vec<(u32, DVec3)>], length: f64) {
        for arc in &mut self.arcs {
            let Some(curve) = arc.curve.filter(|_| arc.given.is_none()) else { continue };
            let is_near = |&(c, p): &(u32, DVec3)| {
                c == curve && arc.vertices.windows(2).any(|w| sheet.distance(w[0], w[1], p) < NEAR * length)
            };
            let times = lost.iter().filter(|round| round.iter().any(is_near)).count() as i64;
            if times > 0 {
                let (least, before) = (arc.least, arc.length / length);
                tracing::debug!(target: "carreau::quad", curve, times, least, before, "feature lost");
                arc.least = arc.least.max(whole((arc.length / length).round()) + (1 << times.min(6)) - 1);
            }
        }
    }

    /// Gives patches the quads that places in them want, along the sides that lead where the surface bends.
    pub fn tighten(&mut self, sheet: &Sheet, tight: &[Tight]) {
        if tight.is_empty() {
            return;
        }
        let (patch_of, _) = patch_of(sheet);
        let tree = TriangleTree::new(&sheet.points, &sheet.triangles);
        for tight in tight {
            let Some(below) = tree.closest(tight.place) else { continue };
            for side in self.patches[patch_of[below.triangle as usize] as usize].loops.iter().flatten() {
                let arc = &mut self.arcs[side.arc as usize];
                let ends = [arc.vertices[0], arc.vertices[arc.vertices.len() - 1]].map(|v| sheet.points[v as usize]);
                // A loop leads everywhere.
                let is_along = ends[0] == ends[1] || unit(ends[1] - ends[0]).dot(tight.way).abs() > ALONG;
                if is_along && arc.given.is_none() {
                    let length = tight.length.max(SHORTEST * self.length);
                    arc.least = arc.least.max(whole((arc.length / length).ceil()));
                }
            }
        }
    }

    /// What a patch without a grid has along each side at least. One quad in a patch of fewer than four sides would have a
    /// corner in the middle of a side; so would one in a strip one quad wide whose long sides differ.
    pub fn make_room(&mut self, patch: usize) {
        let sides = &self.patches[patch].sides;
        let least = match sides.len() {
            1..4 => 6usize.div_ceil(sides.len()),
            4 => 2,
            _ => 1,
        };
        for side in sides {
            for s in side {
                let arc = &mut self.arcs[s.arc as usize];
                // What rung 3 has along an arc cannot be changed.
                if arc.given.is_some() {
                    continue;
                }
                arc.room = arc.room.max(least.div_ceil(side.len()) as i64);
                arc.count = arc.count.max(arc.room);
            }
        }
    }

    /// Mean length of the quads around a patch.
    pub fn length_around(&self, patch: &Patch) -> f64 {
        let arcs = || patch.loops.iter().flatten().map(|s| &self.arcs[s.arc as usize]);
        arcs().map(|a| a.length).sum::<f64>() / arcs().map(|a| a.count).sum::<i64>().max(1) as f64
    }

    /// Edges along a side.
    pub fn sum(&self, side: &[Side]) -> i64 {
        side.iter().map(|s| self.arcs[s.arc as usize].count).sum()
    }
}
