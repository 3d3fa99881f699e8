//! Merging of patches (paper §5: "une dernière étape de fusion de carreaux pourrait être ajoutée").
//!
//! Two patches become one when a complete side of each is the same path of mesh edges:
//!
//! ```text
//!  ┌──┬──┐┌──┬──┬──┐      ┌──┬──┬──┬──┬──┐
//!  ├──┼──┤├──┼──┼──┤  →   ├──┼──┼──┼──┼──┤
//!  └──┴──┘└──┴──┴──┘      └──┴──┴──┴──┴──┘
//! ```
//!
//! Longest sides first. The grids are turned by quarters so that the common side is right of the one and left of the
//! other.

use super::grid::{Grid, Patch};
use super::growth::Grower;
use super::quality::Candidates;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Where a side begins: its patch and its number there.
#[derive(Clone, Copy)]
struct SideOf {
    patch: u32,
    side: u8,
}

/// Merges patches, lets them grow over the triangles that are left ("en intégrant éventuellement des quadrangles
/// isolés"), and goes on as long as either changes something. Patches of fewer than `min_cells` cells, which the result
/// would not have, are no obstacle; nothing grows across `walls`, but complete sides may meet there.
pub(super) fn merge_and_absorb(
    mut patches: Vec<Patch>,
    candidates: &Candidates,
    walls: &[bool],
    min_cells: usize,
    context: &Context,
) -> Result<Vec<Patch>> {
    loop {
        patches = merge(patches, candidates, context)?;
        patches.sort_by_key(|p| Reverse(p.cells()));
        let small = patches.split_off(patches.partition_point(|p| p.cells() >= min_cells));
        let mut grower = Grower::new(candidates, walls);
        grower.occupy(&patches);
        let mut grown = false;
        for (k, patch) in patches.iter_mut().enumerate() {
            context.check_every(k)?;
            if let Some(larger) = grower.extend(patch) {
                *patch = larger;
                grown = true;
            }
        }
        patches.extend(small.into_iter().filter(|p| grower.is_free(p)));
        if !grown {
            return Ok(patches);
        }
    }
}

struct Merger<'a> {
    candidates: &'a Candidates<'a>,
    patches: Vec<Option<Patch>>,
    /// Of every half-edge: the side that begins with it.
    first: Vec<Option<SideOf>>,
    /// Sides to be tried: (length, cells of the patch, newest last).
    queue: BinaryHeap<(usize, usize, Reverse<u32>, Reverse<u8>)>,
}

/// Merges patches until no two complete sides coincide.
pub(super) fn merge(patches: Vec<Patch>, candidates: &Candidates, context: &Context) -> Result<Vec<Patch>> {
    let _stage = context.stage("merging");
    let first = vec![None; 3 * candidates.triangles.len()];
    let mut merger = Merger { candidates, patches: Vec::new(), first, queue: BinaryHeap::new() };
    patches.into_iter().for_each(|p| merger.add(p));
    let mut step = 0;
    while let Some((_, _, Reverse(patch), Reverse(side))) = merger.queue.pop() {
        step += 1;
        context.check_every(step)?;
        if let Some((other, its_side)) = merger.partner(patch as usize, side as usize) {
            merger.join(patch as usize, side as usize, other, its_side);
        }
    }
    Ok(merger.patches.into_iter().flatten().collect())
}

impl Merger<'_> {
    fn add(&mut self, patch: Patch) {
        let id = self.patches.len() as u32;
        for side in 0..4u8 {
            let edges = patch.side(side.into(), self.candidates.triangles);
            if let Some(&h) = edges.first() {
                self.first[h as usize] = Some(SideOf { patch: id, side });
                self.queue.push((edges.len(), patch.cells(), Reverse(id), Reverse(side)));
            }
        }
        self.patches.push(Some(patch));
    }

    /// The patch and side whose complete path is this side's, reversed.
    fn partner(&self, patch: usize, side: usize) -> Option<(usize, usize)> {
        let edges = self.patches[patch].as_ref()?.side(side, self.candidates.triangles);
        let across = |h: u32| Some(self.candidates.across(h)).filter(|&o| o != NONE);
        let candidate = self.first[across(*edges.last()?)? as usize]?;
        let (other, its_side) = (candidate.patch as usize, candidate.side as usize);
        if other == patch {
            return None;
        }
        let theirs = self.patches[other].as_ref()?.side(its_side, self.candidates.triangles);
        let same =
            theirs.len() == edges.len() && edges.iter().zip(theirs.iter().rev()).all(|(&h, &o)| across(h) == Some(o));
        same.then_some((other, its_side))
    }

    fn join(&mut self, a: usize, side_a: usize, b: usize, side_b: usize) {
        let (Some(left), Some(right)) = (self.patches[a].take(), self.patches[b].take()) else { return };
        for patch in [&left, &right] {
            for side in 0..4 {
                if let Some(&h) = patch.side(side, self.candidates.triangles).first() {
                    self.first[h as usize] = None;
                }
            }
        }
        let (left, right) = (left.turned(5 - side_a), right.turned(7 - side_b));
        let mut grid = Grid::new(left.rows, left.cols + right.cols);
        for (part, offset) in [(&left, 0), (&right, left.cols)] {
            for (r, c) in part.cell_places() {
                grid.set(r, offset + c, part.cell(r, c), part.cell_triangles(r, c));
            }
        }
        self.add(grid.finish());
    }
}
