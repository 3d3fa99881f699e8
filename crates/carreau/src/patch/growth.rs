//! Direct growth: rectangles of quads grown on the triangles themselves (the paper's perspective "décomposer
//! directement", worked out; the default strategy).
//!
//! A rectangle starts from one quad and adds whole rows to its sides. Above each border edge lies a triangle T, which
//! can join its left or its right neighbour; each choice fixes the two top vertices and the two vertical sides:
//!
//! ```text
//!        x ───── p                 p ───── x
//!        │ P  ╱  │                 │  ╲  P │
//!   left │  ╱  T │ right      left │ T  ╲  │ right
//!        │╱      │                 │      ╲│
//!  v(i+1)·──────·  …            choice Right: diagonal p – v(i+1)
//!        v(i)    v(i+1)
//!    choice Left: diagonal v(i) – p
//! ```
//!
//! Neighbouring cells must share their vertical side as one mesh edge. A two-state dynamic programme along the side
//! finds the row of least total cost, or that there is none. All inner vertices of the result are regular.
//!
//! A side that cannot grow once can never grow: later attempts contain the failed one. So the growth of a rectangle
//! costs its area plus four failed rows.

mod partial;

use super::grid::{Grid, Patch};
use super::quality::Candidates;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::{FaceId, NONE, VertexId};
use partial::{Above, Base, IMPOSSIBLE, JOINS_LEFT, JOINS_RIGHT, Layer, Node, Partial};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

/// Grows one rectangle at a time; reusable, so that nothing is allocated per rectangle.
pub(super) struct Grower<'a> {
    candidates: &'a Candidates<'a>,
    nodes: Vec<Node>,
    epoch: u32,
    base: Base,
    /// Inside half-edges of the border: bottom, right, top, left, counter-clockwise.
    sides: [VecDeque<u32>; 4],
    blocked: [bool; 4],
    layers: Vec<Layer>,
    spare: Vec<Layer>,
    /// For each cell of the row in work and each of its two states: the state of the cell before.
    before: Vec<[u8; 2]>,
    row: Vec<Above>,
}

/// Mark of triangles in finished patches; epochs stay below.
const USED: u32 = u32::MAX;

impl<'a> Grower<'a> {
    /// No triangle is used yet. Rows do not cross the half-edges in `walls`; the candidates' own barriers hold anyway.
    pub fn new(candidates: &'a Candidates<'a>, walls: &[bool]) -> Self {
        let across = |h: u32| if walls[h as usize] { NONE } else { candidates.across(h) };
        let cost = |h: u32| if across(h) == NONE { f64::INFINITY } else { candidates.cost[h as usize] };
        let node = |t: u32| {
            let half_edges = [3 * t, 3 * t + 1, 3 * t + 2];
            Node { across: half_edges.map(across), mark: 0, cost: half_edges.map(cost) }
        };
        Grower {
            candidates,
            nodes: (0..candidates.triangles.len() as u32).map(node).collect(),
            epoch: 0,
            base: Base::Pair(NONE),
            sides: Default::default(),
            blocked: [false; 4],
            layers: Vec::new(),
            spare: Vec::new(),
            before: Vec::new(),
            row: Vec::new(),
        }
    }

    /// Whether no triangle of a patch belongs to another, finished one.
    pub fn is_free(&self, patch: &Patch) -> bool {
        patch.triangles.iter().all(|t| self.nodes[t.index()].mark != USED)
    }

    /// The half-edge across `h`, or [`NONE`].
    #[inline]
    fn across(&self, h: u32) -> u32 {
        self.nodes[h as usize / 3].across[h as usize % 3]
    }

    /// Cost of the pair across `h`; infinite if it is no candidate.
    #[inline]
    fn cost(&self, h: u32) -> f64 {
        self.nodes[h as usize / 3].cost[h as usize % 3]
    }

    #[inline]
    fn mark(&mut self, h: u32, mark: u32) {
        self.nodes[h as usize / 3].mark = mark;
    }

    /// Whether a pair may be a seed: its triangles are free and no wall runs between them.
    fn is_seed(&self, h: u32) -> bool {
        self.cost(h).is_finite() && [h, self.across(h)].iter().all(|&h| self.nodes[h as usize / 3].mark != USED)
    }

    /// Number of cells of the current rectangle.
    pub fn cells(&self) -> usize {
        self.sides[0].len() * self.sides[1].len()
    }

    /// Grows the largest rectangle reachable from a seed pair; returns its number of cells. Nothing is taken yet.
    pub fn grow(&mut self, seed: u32) -> usize {
        self.start(Base::Pair(seed), std::iter::once, self.candidates.sides(seed));
        self.mark(seed, self.epoch);
        self.mark(self.across(seed), self.epoch);
        while self.add_row() {}
        self.cells()
    }

    /// Marks the triangles of finished patches.
    pub fn occupy(&mut self, patches: &[Patch]) {
        patches.iter().flat_map(|p| &p.triangles).for_each(|t| self.nodes[t.index()].mark = USED);
    }

    /// Extends a finished patch by whole rows over free triangles; `None` when no side can grow.
    pub fn extend(&mut self, patch: &Patch) -> Option<Patch> {
        let sides = std::array::from_fn(|s| patch.side(s, self.candidates.triangles));
        self.start(Base::Patch(patch.clone()), |side: Vec<u32>| side.into_iter(), sides);
        while self.add_row() {}
        (!self.layers.is_empty()).then(|| self.take())
    }

    fn start<S, I: Iterator<Item = u32>>(&mut self, base: Base, edges: impl Fn(S) -> I, sides: [S; 4]) {
        self.epoch += 1;
        self.base = base;
        self.spare.append(&mut self.layers);
        for (side, from) in self.sides.iter_mut().zip(sides) {
            side.clear();
            side.extend(edges(from));
        }
        self.blocked = [false; 4];
    }

    /// The triangles of the current rectangle beyond those it started from.
    pub fn added_triangles(&self) -> impl Iterator<Item = u32> + '_ {
        let cells = self.layers.iter().flat_map(|l| &l.cells);
        cells.flat_map(|&(base, diagonal)| [base / 3, self.across(diagonal) / 3])
    }

    /// Adds a row to the longest side that still can grow.
    fn add_row(&mut self) -> bool {
        while let Some(side) = (0..4).filter(|&s| !self.blocked[s]).max_by_key(|&s| (self.sides[s].len(), 4 - s)) {
            if self.row_above(side) {
                self.attach(side);
                return true;
            }
            self.blocked[side] = true;
        }
        false
    }

    #[inline]
    fn is_open(&self, half_edge: u32) -> bool {
        let mark = self.nodes[half_edge as usize / 3].mark;
        mark != USED && mark != self.epoch
    }

    /// The cell above the border edge `base` in one of its two states, if there is one.
    #[inline]
    fn cell_above(&self, base: u32, state: usize) -> Option<Above> {
        let t = self.candidates.triangles;
        let (next, previous) = (t.next(base), t.previous(base));
        let diagonal = if state == JOINS_LEFT { next } else { previous };
        if !self.cost(diagonal).is_finite() {
            return None;
        }
        let partner = self.across(diagonal);
        if !self.is_open(partner) {
            return None;
        }
        let (after, back) = (t.next(partner), t.previous(partner));
        Some(if state == JOINS_LEFT {
            Above { base, diagonal, partner, left: after, right: previous, top: back }
        } else {
            Above { base, diagonal, partner, left: next, right: back, top: after }
        })
    }

    /// Finds the best row above a side; it is left in `row`, its triangles marked.
    fn row_above(&mut self, side: usize) -> bool {
        self.before.clear();
        let mut partial = [IMPOSSIBLE; 2];
        for k in 0..self.sides[side].len() {
            let base = self.across(self.sides[side][k]);
            if base == NONE || !self.is_open(base) {
                return false;
            }
            let (mut best, mut from) = ([IMPOSSIBLE; 2], [0; 2]);
            for state in [JOINS_LEFT, JOINS_RIGHT] {
                let Some(cell) = self.cell_above(base, state) else { continue };
                // Of the states before that share their right side with this cell's left side, the cheaper one.
                let reach = |s: usize| if partial[s].joint == cell.left { partial[s].total } else { f64::INFINITY };
                let s = usize::from(reach(JOINS_RIGHT) < reach(JOINS_LEFT));
                let so_far = if k == 0 { 0.0 } else { reach(s) };
                if so_far.is_finite() {
                    let total = so_far + self.cost(cell.diagonal);
                    best[state] = Partial { joint: self.across(cell.right), total };
                    from[state] = s as u8;
                }
            }
            if best.iter().all(|p| p.total.is_infinite()) {
                return false;
            }
            self.before.push(from);
            partial = best;
        }
        self.trace_back(side, usize::from(partial[JOINS_RIGHT].total < partial[JOINS_LEFT].total)) && self.claim_row()
    }

    /// Follows the choices back from the last cell's state.
    fn trace_back(&mut self, side: usize, last: usize) -> bool {
        self.row.clear();
        let mut state = last;
        for k in (0..self.before.len()).rev() {
            let base = self.across(self.sides[side][k]);
            let Some(cell) = self.cell_above(base, state) else { return false };
            self.row.push(cell);
            state = self.before[k][state].into();
        }
        self.row.reverse();
        true
    }

    /// Marks the row's triangles; undone when one would be used twice (a side that runs around a thin neck).
    fn claim_row(&mut self) -> bool {
        for k in 0..2 * self.row.len() {
            let half_edge = |k: usize| if k.is_multiple_of(2) { self.row[k / 2].base } else { self.row[k / 2].partner };
            if !self.is_open(half_edge(k)) {
                (0..k).map(half_edge).for_each(|h| self.nodes[h as usize / 3].mark = 0);
                return false;
            }
            self.nodes[half_edge(k) as usize / 3].mark = self.epoch;
        }
        true
    }

    /// Makes the row part of the rectangle.
    fn attach(&mut self, side: usize) {
        let mut layer = self.spare.pop().unwrap_or(Layer { side, cells: Vec::new() });
        layer.side = side;
        layer.cells.clear();
        layer.cells.extend(self.row.iter().map(|c| (c.base, c.diagonal)));
        self.layers.push(layer);
        if let (Some(first), Some(last)) = (self.row.first(), self.row.last()) {
            self.sides[(side + 3) % 4].push_back(first.left);
            self.sides[(side + 1) % 4].push_front(last.right);
        }
        for (h, cell) in self.sides[side].iter_mut().zip(&self.row) {
            *h = cell.top;
        }
    }

    /// Takes the current rectangle: its triangles are used from now on.
    pub fn take(&mut self) -> Patch {
        let t = self.candidates.triangles;
        let added = |side: usize| self.layers.iter().filter(|l| l.side == side).count() as u32;
        let (below, before) = (added(0), added(3));
        let mut grid = Grid::new(self.sides[1].len() as u32, self.sides[0].len() as u32);
        let (mut low, mut high) = ([below, before], [below, before]);
        match &self.base {
            Base::Pair(seed) => {
                let o = t.opposite(*seed);
                let corners = [*seed, t.previous(o), o, t.previous(*seed)].map(|c| VertexId(t.vertex(c)));
                grid.set(below, before, corners, [FaceId(*seed / 3), FaceId(o / 3)]);
            }
            Base::Patch(patch) => {
                for (r, c) in patch.cell_places() {
                    grid.set(below + r, before + c, patch.cell(r, c), patch.cell_triangles(r, c));
                }
                high = [below + patch.rows - 1, before + patch.cols - 1];
            }
        }
        // Rows and columns grow outwards from the seed's.
        for layer in &self.layers {
            let (axis, up) = (layer.side % 2, matches!(layer.side, 1 | 2));
            if up {
                high[axis] += 1
            } else {
                low[axis] -= 1
            }
            let line = if up { high[axis] } else { low[axis] };
            let other = 1 - axis;
            for (k, &(base, diagonal)) in layer.cells.iter().enumerate() {
                let k = k as u32;
                // Bottom and right sides run with the axis, top and left against it.
                let along = if layer.side < 2 { low[other] + k } else { high[other] - k };
                let (row, col) = if axis == 0 { (line, along) } else { (along, line) };
                let g = t.opposite(diagonal);
                let quad = if diagonal == t.next(base) {
                    [base, t.next(base), t.previous(g), t.previous(base)]
                } else {
                    [base, t.next(base), t.previous(base), t.previous(g)]
                };
                // The quad starts at v(i+1); its bottom left corner depends on the side it was added to.
                let start = (6 - layer.side) % 4;
                let corners = std::array::from_fn(|i| VertexId(t.vertex(quad[(start + i) % 4])));
                grid.set(row, col, corners, [FaceId(base / 3), FaceId(g / 3)]);
            }
        }
        let patch = grid.finish();
        patch.triangles.iter().for_each(|t| self.nodes[t.index()].mark = USED);
        patch
    }
}

/// Covers the free part of the mesh with patches of at least `min_cells` cells, largest first.
///
/// Every rectangle is worth its number of cells. Growing one from each seed would tell which is largest, but costs the
/// sum of all rectangles; yet most seeds inside a rectangle lead to that same rectangle. So seeds are tried best quality
/// first, and a triangle that lies in `probes` rectangles already is not tried again. A rectangle can only shrink when
/// others are taken, so it is grown anew when it comes to the top of the heap, and taken when it is still as large.
/// Rounds follow until nothing is left.
pub(super) fn cover(grower: &mut Grower, probes: u32, min_cells: usize, context: &Context) -> Result<Vec<Patch>> {
    let stage = context.stage("growth");
    let candidates = grower.candidates;
    let (order, triangles) = (&candidates.order, candidates.triangles);
    let mut patches = Vec::new();
    let mut heap = BinaryHeap::new();
    let mut covered = 0;
    // Places in `order` whose triangles are still free.
    let mut ranks: Vec<u32> = (0..order.len() as u32).collect();
    loop {
        let mut probed = vec![0u32; triangles.len()];
        for (k, &rank) in ranks.iter().enumerate() {
            context.check_every(k)?;
            let seed = order[rank as usize];
            // The first test spares most seeds a look at their triangles; only seeds have a half-edge across.
            let is_probed = |h: u32| probed[h as usize / 3] >= probes;
            if is_probed(seed) || !grower.is_seed(seed) || is_probed(grower.across(seed)) {
                continue;
            }
            let pair = [seed / 3, grower.across(seed) / 3];
            let cells = grower.grow(seed);
            if cells >= min_cells {
                heap.push((cells, Reverse(rank)));
                grower.added_triangles().chain(pair).for_each(|t| probed[t as usize] += 1);
            }
        }
        if heap.is_empty() {
            return Ok(patches);
        }
        while let Some((cells, Reverse(rank))) = heap.pop() {
            let seed = order[rank as usize];
            if !grower.is_seed(seed) {
                continue;
            }
            let now = grower.grow(seed);
            if now == cells {
                patches.push(grower.take());
                covered += 2 * cells;
                stage.step(covered, triangles.len())?;
            } else if now >= min_cells {
                heap.push((now, Reverse(rank)));
            }
        }
        ranks.retain(|&rank| grower.is_seed(order[rank as usize]));
    }
}
