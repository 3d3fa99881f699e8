//! Stage 3: rows and columns for quads, and the rectilinear polygons that follow (paper §3.3, figures 5 to 7).
//!
//! The best quad of what is left gets the place (0, 0); places spread to the neighbours across the sides. Global sides
//! are 0 bottom, 1 right, 2 top, 3 left; a quad turned by `turn` shows its own side `i` on global side
//! `(i + turn) mod 4`. Crossing global side `g` into the neighbour's own side `j`, the neighbour's turn is
//! `(g + 2 − j) mod 4`.
//!
//! Around vertices of other than four quads the places contradict each other: a place is taken, or a quad would get
//! two. [`Policy`] says what happens then. Two quads may also come to lie side by side without sharing a mesh edge.
//! So a polygon is a set of cells with walls.

use super::polygon::{Cell, Polygon};
use super::quality::Candidates;
use super::zones::Quads;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// What happens where places contradict each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Policy {
    /// The paper: the quad in conflict leaves the polygon, which goes on without it; the next polygon starts there.
    Paper,
    /// The quad keeps its first place, and the edge of the conflict becomes a wall.
    #[default]
    KeepFirst,
}

/// Where a quad lies.
#[derive(Clone, Copy)]
struct GridPlace {
    /// Polygon number, [`NONE`] before the quad has a place.
    polygon: u32,
    row: i32,
    col: i32,
    turn: u32,
}

/// The place of a cell that has none yet.
const NOWHERE: GridPlace = GridPlace { polygon: NONE, row: 0, col: 0, turn: 0 };

/// One step across a global side: change of row and column.
const STEP: [(i32, i32); 4] = [(-1, 0), (0, 1), (1, 0), (0, -1)];

struct Layout<'a> {
    candidates: &'a Candidates<'a>,
    quads: &'a Quads,
    places: Vec<GridPlace>,
    /// Quad at each place of the current polygon.
    taken: FxHashMap<(i32, i32), u32>,
    /// Quads that lost their place: they start the next polygons.
    seeds: VecDeque<u32>,
    /// Of every quad: the last polygon that it had to leave.
    banned_from: Vec<u32>,
    policy: Policy,
}

/// Gives every quad a place and returns the polygons, each connected, with the turn of every quad.
pub(super) fn lay_out(
    candidates: &Candidates,
    quads: &Quads,
    policy: Policy,
    context: &Context,
) -> Result<(Vec<Polygon>, Vec<u32>)> {
    let _stage = context.stage("positions");
    let mut by_quality: Vec<u32> = (0..quads.diagonal.len() as u32).collect();
    by_quality.sort_unstable_by_key(|&q| candidates.rank[quads.diagonal[q as usize] as usize]);
    let n = quads.diagonal.len();
    let mut layout = Layout {
        candidates,
        quads,
        places: vec![NOWHERE; n],
        taken: FxHashMap::default(),
        seeds: VecDeque::new(),
        banned_from: vec![NONE; n],
        policy,
    };
    let mut polygons = 0;
    for best in by_quality {
        layout.seeds.push_back(best);
        while let Some(seed) = layout.seeds.pop_front() {
            context.check_every(polygons as usize)?;
            if layout.places[seed as usize].polygon == NONE {
                layout.spread(seed, polygons);
                polygons += 1;
            }
        }
    }
    let turns = layout.places.iter().map(|p| p.turn).collect();
    Ok((layout.polygons(polygons), turns))
}

impl Layout<'_> {
    /// The quad across global side `g` of a quad with this turn, and the side of its own that is met.
    fn neighbour(&self, quad: u32, turn: u32, g: usize) -> Option<(u32, u32)> {
        let h = self.candidates.sides(self.quads.diagonal[quad as usize])[(g + 4 - turn as usize) % 4];
        let o = self.candidates.across(h);
        if o == NONE {
            return None;
        }
        let other = self.quads.of_triangle[o as usize / 3];
        let sides = (other != NONE).then(|| self.candidates.sides(self.quads.diagonal[other as usize]))?;
        sides.iter().position(|&s| s == o).map(|j| (other, j as u32))
    }

    /// Fills one polygon from its seed.
    fn spread(&mut self, seed: u32, polygon: u32) {
        self.taken.clear();
        let mut queue = VecDeque::from([seed]);
        self.put(seed, GridPlace { polygon, ..NOWHERE });
        while let Some(quad) = queue.pop_front() {
            let here = self.places[quad as usize];
            if here.polygon != polygon {
                continue; // it has lost its place meanwhile
            }
            for g in 0..4 {
                let Some((other, j)) = self.neighbour(quad, here.turn, g) else { continue };
                let (row, col) = (here.row + STEP[g].0, here.col + STEP[g].1);
                let wanted = GridPlace { polygon, row, col, turn: (g as u32 + 6 - j) % 4 };
                let there = self.places[other as usize];
                let conflict = if there.polygon == NONE {
                    self.taken.contains_key(&(row, col))
                } else {
                    there.polygon == polygon && (there.row, there.col, there.turn) != (row, col, wanted.turn)
                };
                if conflict && self.policy == Policy::Paper {
                    self.ban(other, seed, polygon);
                } else if !conflict && there.polygon == NONE && self.banned_from[other as usize] != polygon {
                    self.put(other, wanted);
                    queue.push_back(other);
                }
            }
        }
    }

    fn put(&mut self, quad: u32, place: GridPlace) {
        self.places[quad as usize] = place;
        self.taken.insert((place.row, place.col), quad);
    }

    /// Takes a quad out of the current polygon for good; the seed always stays.
    fn ban(&mut self, quad: u32, seed: u32, polygon: u32) {
        if quad == seed || self.banned_from[quad as usize] == polygon {
            return;
        }
        let place = self.places[quad as usize];
        if place.polygon != NONE {
            self.taken.remove(&(place.row, place.col));
            self.places[quad as usize] = NOWHERE;
        }
        self.banned_from[quad as usize] = polygon;
        self.seeds.push_back(quad);
    }

    /// The polygons as cells with walls, split where quads that left have disconnected them.
    fn polygons(&self, count: u32) -> Vec<Polygon> {
        let mut members = vec![Vec::new(); count as usize];
        for (quad, place) in self.places.iter().enumerate() {
            members[place.polygon as usize].push(quad as u32);
        }
        let mut cell_of = vec![NONE; self.places.len()];
        let mut polygons = Vec::new();
        for quads in members.iter().filter(|m| !m.is_empty()) {
            for (k, &quad) in quads.iter().enumerate() {
                cell_of[quad as usize] = k as u32;
            }
            let cells = quads.iter().map(|&quad| self.cell(quad, &cell_of)).collect();
            polygons.extend(components(cells));
        }
        polygons
    }

    fn cell(&self, quad: u32, cell_of: &[u32]) -> Cell {
        let here = self.places[quad as usize];
        let next = std::array::from_fn(|g| match self.neighbour(quad, here.turn, g) {
            Some((other, j)) => {
                let there = self.places[other as usize];
                let fits = there.polygon == here.polygon
                    && (there.row, there.col) == (here.row + STEP[g].0, here.col + STEP[g].1)
                    && there.turn == (g as u32 + 6 - j) % 4;
                if fits { cell_of[other as usize] } else { NONE }
            }
            None => NONE,
        });
        Cell { row: here.row, col: here.col, quad, next }
    }
}

/// Connected sets of cells, with `next` renumbered.
fn components(mut cells: Vec<Cell>) -> Vec<Polygon> {
    let mut new_id = vec![NONE; cells.len()];
    let mut order = Vec::with_capacity(cells.len());
    let mut ends = Vec::new();
    for start in 0..cells.len() as u32 {
        if new_id[start as usize] != NONE {
            continue;
        }
        let first = order.len();
        new_id[start as usize] = 0;
        order.push(start);
        let mut k = first;
        while k < order.len() {
            for n in cells[order[k] as usize].next.into_iter().filter(|&n| n != NONE) {
                if new_id[n as usize] == NONE {
                    new_id[n as usize] = (order.len() - first) as u32;
                    order.push(n);
                }
            }
            k += 1;
        }
        ends.push(order.len());
    }
    for cell in &mut cells {
        cell.next.iter_mut().filter(|n| **n != NONE).for_each(|n| *n = new_id[*n as usize]);
    }
    let mut start = 0;
    let part = |end| {
        let cells = order[start..end].iter().map(|&k| cells[k as usize]).collect();
        start = end;
        Polygon { cells }
    };
    ends.into_iter().map(part).collect()
}
