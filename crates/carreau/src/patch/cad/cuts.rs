//! Polygons cut into parts whose borders do not touch themselves.

use super::{QuadCell, QuadPolygon};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::mesh::VertexId;
use rustc_hash::{FxHashMap, FxHashSet};

/// Largest area of the bounding rectangle for each cell.
pub const SPREAD: u64 = 16;
/// Most lines that are tried in each direction for a cut.
pub const TRIALS: usize = 12;

/// A line between rows (axis 0) or columns (axis 1): cells at `at` and above are on one side.
#[derive(Clone, Copy)]
pub struct Cut {
    pub(super) axis: usize,
    pub(super) at: i32,
}

/// Cuts a polygon into sets of cells that can be faces.
pub fn parts(polygon: &QuadPolygon, ctx: &Context) -> Result<Vec<Vec<u32>>> {
    let cells = &polygon.cells;
    let mut open = connected(cells, (0..cells.len() as u32).collect());
    open.reverse();
    let mut out = Vec::new();
    while let Some(part) = open.pop() {
        ctx.check()?;
        let defects = defects(cells, &part);
        if defects.is_empty() {
            out.push(part);
            continue;
        }
        let mut best: Option<(usize, Vec<Vec<u32>>)> = None;
        for cut in cuts(cells, &part, &defects) {
            let halves = split(cells, &part, cut);
            // Every part will be a face, and every defect will need another cut.
            let cost = halves.iter().map(|h| 1 + self::defects(cells, h).len()).sum();
            if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                best = Some((cost, halves));
            }
        }
        // There is always a cut: a single cell has no defect.
        let Some((_, mut halves)) = best else {
            return Err(Error::Bug("a polygon that touches itself has no line to cut it along".into()));
        };
        halves.reverse();
        open.extend(halves);
    }
    Ok(out)
}

/// Nodes at which the part touches itself, or its middle where its bounding rectangle is too large.
pub fn defects(cells: &[QuadCell], part: &[u32]) -> Vec<[i32; 2]> {
    let inside: FxHashSet<u32> = part.iter().copied().collect();
    let mut vertex_at: FxHashMap<[i32; 2], VertexId> = FxHashMap::default();
    let (mut starts, mut passed, mut sides) = (FxHashSet::default(), FxHashSet::default(), FxHashSet::default());
    let mut out = Vec::new();
    for &k in part {
        let cell = &cells[k as usize];
        for side in 0..4 {
            let [from, to] = ends(cell, side);
            if *vertex_at.entry(from).or_insert(cell.corners[side]) != cell.corners[side] {
                out.push(from);
            }
            if inside.contains(&cell.next[side]) {
                continue;
            }
            // A pinch, a vertex that is passed again, a wall between two cells of the part.
            let again = !starts.insert(from) | !passed.insert(cell.corners[side]) | sides.contains(&[to, from]);
            sides.insert([from, to]);
            if again {
                out.push(from);
            }
        }
    }
    let [low, high] = bounds(cells, part);
    let size = [0, 1].map(|x| (i64::from(high[x]) - i64::from(low[x])) as u64);
    if size[0].saturating_mul(size[1]) > SPREAD * part.len() as u64 {
        out.push([0, 1].map(|x| low[x].midpoint(high[x])));
    }
    out
}

/// The nodes (row, column) at the beginning and the end of a side, counter-clockwise.
pub fn ends(cell: &QuadCell, side: usize) -> [[i32; 2]; 2] {
    let (r, c) = (cell.row, cell.col);
    let nodes = [[r, c], [r, c + 1], [r + 1, c + 1], [r + 1, c]];
    [nodes[side], nodes[(side + 1) % 4]]
}

/// First node and last node of the bounding rectangle.
pub fn bounds(cells: &[QuadCell], part: &[u32]) -> [[i32; 2]; 2] {
    let mut out = [[i32::MAX; 2], [i32::MIN; 2]];
    for &k in part {
        let at = [cells[k as usize].row, cells[k as usize].col];
        for x in 0..2 {
            out[0][x] = out[0][x].min(at[x]);
            out[1][x] = out[1][x].max(at[x] + 1);
        }
    }
    out
}

/// Lines through the defects, the middle of the part, and as a last resort any line: those that really cut.
pub fn cuts(cells: &[QuadCell], part: &[u32], defects: &[[i32; 2]]) -> Vec<Cut> {
    let [low, high] = bounds(cells, part);
    let mut out = Vec::new();
    for axis in 0..2 {
        let mut lines: Vec<i32> = defects.iter().map(|d| d[axis]).chain([low[axis].midpoint(high[axis])]).collect();
        lines.retain(|&at| low[axis] < at && at < high[axis]);
        lines.sort_unstable();
        lines.dedup();
        let step = lines.len().div_ceil(TRIALS).max(1);
        out.extend(lines.into_iter().step_by(step).map(|at| Cut { axis, at }));
    }
    out
}

/// The connected parts on both sides of a line.
pub fn split(cells: &[QuadCell], part: &[u32], cut: Cut) -> Vec<Vec<u32>> {
    let above = |k: &u32| [cells[*k as usize].row, cells[*k as usize].col][cut.axis] >= cut.at;
    let (high, low) = part.iter().copied().partition(above);
    let mut out = connected(cells, low);
    out.extend(connected(cells, high));
    out
}

/// Sets of cells connected through `next`, by their first cell.
pub fn connected(cells: &[QuadCell], part: Vec<u32>) -> Vec<Vec<u32>> {
    let mut left: FxHashSet<u32> = part.iter().copied().collect();
    let mut out = Vec::new();
    for k in part {
        if !left.remove(&k) {
            continue;
        }
        let mut set = vec![k];
        let mut next = 0;
        while next < set.len() {
            for &across in &cells[set[next] as usize].next {
                if left.remove(&across) {
                    set.push(across);
                }
            }
            next += 1;
        }
        set.sort_unstable();
        out.push(set);
    }
    out
}
