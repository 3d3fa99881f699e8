//! Dissection of a polygon into rectangles, largest first (Bénière et al., REFIG 5(1), 2011, section 3.3).
//!
//! **The paper.** Extract the rectangle with the most cells, remove its cells from the polygon, and repeat until no
//! cell is left. To find that rectangle, look at each cell as the upper left corner: take the *longest* row that starts
//! there, then as many rows below as can be that long; of all these candidates take the one with the most cells. A wall
//! ends a row, and two rows of which some cells have a wall between them do not lie in one rectangle. This is
//! [`CornerRule::LongestRow`], to the letter. The paper does not say which of several equally large candidates to take.
//!
//! **A better rule.** The longest row need not give the largest rectangle: in the drawing the paper's candidate at `a`
//! is the row of 4 cells, although 4 rows of 2 cells start there as well. [`CornerRule::AnyWidth`] considers every width
//! and so really finds "le carreau ayant le plus de quadrangles".
//!
//! ```text
//!   ┌───┬───┬───┬───┐
//!   │ a │   │   │   │
//!   ├───┼───┼───┴───┘
//!   │   │   │
//!   ├───┼───┤
//!   │   │   │
//!   ├───┼───┤
//!   │   │   │
//!   └───┴───┘
//! ```
//!
//! **Ties** are broken by geometry alone, never by the numbering of cells or quads: of several rectangles with the most
//! cells comes first the longer one (more rows plus columns; on random polygons with walls this gives 1 to 3 % fewer
//! rectangles than the squarer one), then the one with more columns, then the lower, then the more leftward.
//!
//! **Speed.** Candidates are kept for whole *stacks* (cells connected upwards and downwards without interruption) and
//! not for cells, since one pass over a stack finds its best candidate: the upper left corner lies in some stack, and so
//! does all the left side. For every cell we keep
//!
//! - `run`: how many cells the row has from here to the right;
//! - `link`: how many cells, from here to the right, are joined to each other, to the cell below, and below as well;
//!
//! so that the width of a rectangle is bounded by the runs of its left cells and by the links between them. The best of
//! every stack waits in a heap. Removing a rectangle changes runs and links only to its left, and splits the stacks that
//! it crosses. With `AnyWidth` the value of a stack can only shrink, so it is evaluated again only when it comes up and
//! its rectangle is no longer intact: a lazy heap gives exactly what a new search after each removal would. With
//! `LongestRow` it can also *grow*, when the longest row becomes shorter and more rows below can be that long; so the
//! stacks to the left of a removed rectangle are evaluated again at once.

#[cfg(test)]
mod tests;

use super::polygon::{BOTTOM, LEFT, Links, NONE, Polygon, RIGHT, Rectangle, TOP};
use crate::{Context, Result};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Which rectangles with a given cell in the upper left corner are candidates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CornerRule {
    /// The paper: as wide as possible, then as high as possible.
    LongestRow,
    /// All of them.
    AnyWidth,
}

/// Dissects a polygon into rectangles, largest first; ties are broken as the module says.
///
/// # Errors
/// Only cancellation and deadline of the context.
pub fn greedy(polygon: &Polygon, rule: CornerRule, context: &Context) -> Result<Vec<Rectangle>> {
    debug_assert!(polygon.check().is_ok());
    let mut remainder = Remainder::new(polygon, rule);
    let mut rectangles = Vec::new();
    while let Some(best) = remainder.take_largest() {
        context.check()?;
        rectangles.push(best);
    }
    debug_assert!(polygon.check_dissection(&rectangles).is_ok());
    Ok(rectangles)
}

/// A rectangle that may be extracted. The order is that of extraction: the greatest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    area: u32,
    half_perimeter: u32,
    cols: u32,
    bottom: Reverse<i32>,
    left: Reverse<i32>,
    rows: u32,
    /// The cell at the upper left.
    corner: u32,
    /// The highest cell of the stack that holds the left side.
    stack: u32,
    /// The stamp of the stack when this was its best rectangle.
    stamp: u32,
}

/// What is left of the polygon.
struct Remainder<'a> {
    polygon: &'a Polygon,
    rule: CornerRule,
    links: Links,
    /// Number of cells in the row from this cell to the right.
    run: Vec<u32>,
    /// Number of columns, from this cell to the right, that this row and the row below share without a wall.
    link: Vec<u32>,
    /// Best rectangles of stacks, some of them outdated.
    heap: BinaryHeap<Candidate>,
    /// How often the stack below its highest cell was evaluated; a candidate with another stamp is outdated.
    stamp: Vec<u32>,
    /// The number of the removal after which the stack of this cell was evaluated.
    evaluated: Vec<u32>,
    removals: u32,
    /// The stack under evaluation, from the top; used again and again.
    stack: Vec<u32>,
    /// The staircase of an evaluation; used again and again.
    steps: Vec<(usize, u32)>,
    /// The cells in and around the rectangle under removal; used again and again.
    around: Surroundings,
}

/// The cells of a rectangle and those that border on it.
#[derive(Default)]
struct Surroundings {
    inside: Vec<u32>,
    left: Vec<u32>,
    above: Vec<u32>,
    below: Vec<u32>,
}

impl<'a> Remainder<'a> {
    fn new(polygon: &'a Polygon, rule: CornerRule) -> Self {
        let count = polygon.cells.len();
        let mut all = Self {
            polygon,
            rule,
            links: Links::of(polygon),
            run: vec![0; count],
            link: vec![0; count],
            heap: BinaryHeap::new(),
            stamp: vec![0; count],
            evaluated: vec![NONE; count],
            removals: 0,
            stack: Vec::new(),
            steps: Vec::new(),
            around: Surroundings::default(),
        };
        for cell in 0..count as u32 {
            if !all.links.joined(cell, RIGHT) {
                all.measure_leftwards(cell);
            }
        }
        for cell in 0..count as u32 {
            if !all.links.joined(cell, TOP) {
                all.evaluate_stack(cell);
            }
        }
        all
    }

    /// Removes and returns the largest rectangle; nothing when no cell is left.
    fn take_largest(&mut self) -> Option<Rectangle> {
        while let Some(best) = self.heap.pop() {
            if self.stamp[best.stack as usize] != best.stamp {
                continue;
            }
            if self.is_intact(&best) {
                return Some(self.remove(&best));
            }
            self.evaluate_stack(best.stack);
        }
        None
    }

    fn is_intact(&self, candidate: &Candidate) -> bool {
        let mut cell = candidate.corner;
        for _ in 1..candidate.rows {
            if self.link[cell as usize] < candidate.cols {
                return false;
            }
            cell = self.links.next(cell, BOTTOM);
        }
        self.run[cell as usize] >= candidate.cols
    }

    /// Sets runs and links of the row from this cell to the left. Those to its right must be up to date.
    ///
    /// ```text
    ///   ┌───┬───┬───┐      run  of a is 3
    ///   │ a │   │   │      link of a is 2: the wall ends it
    ///   ├───┼───┼───┤
    ///   │   │   ┃   │
    ///   └───┴───┴───┘
    /// ```
    fn measure_leftwards(&mut self, mut cell: u32) {
        while cell != NONE {
            let right = self.links.next(cell, RIGHT);
            self.run[cell as usize] = if right == NONE { 1 } else { self.run[right as usize] + 1 };
            self.measure_link(cell);
            let above = self.links.next(cell, TOP);
            if above != NONE {
                self.measure_link(above);
            }
            cell = self.links.next(cell, LEFT);
        }
    }

    fn measure_link(&mut self, cell: u32) {
        let (below, right) = (self.links.next(cell, BOTTOM), self.links.next(cell, RIGHT));
        self.link[cell as usize] = if below == NONE {
            0
        } else if right != NONE && self.links.joined(below, RIGHT) {
            self.link[right as usize] + 1
        } else {
            1
        };
    }

    /// Finds the best rectangle whose left side lies in the stack of this cell, unless it is known already.
    fn evaluate_stack(&mut self, cell: u32) {
        if self.evaluated[cell as usize] == self.removals {
            return;
        }
        let mut top = cell;
        while self.links.joined(top, TOP) {
            top = self.links.next(top, TOP);
        }
        let mut stack = std::mem::take(&mut self.stack);
        stack.clear();
        let mut next = top;
        while next != NONE {
            self.evaluated[next as usize] = self.removals;
            stack.push(next);
            next = self.links.next(next, BOTTOM);
        }
        self.stamp[top as usize] += 1;
        let best = match self.rule {
            CornerRule::LongestRow => self.best_of_longest_rows(&stack),
            CornerRule::AnyWidth => self.best_of_any_width(&stack),
        };
        self.heap.extend(best);
        self.stack = stack;
    }

    fn candidate(&self, stack: &[u32], first: usize, last: usize, cols: u32) -> Candidate {
        let rows = (last - first + 1) as u32;
        let corner = stack[first];
        Candidate {
            area: rows * cols,
            half_perimeter: rows + cols,
            cols,
            bottom: Reverse(self.polygon.cells[stack[last] as usize].row),
            left: Reverse(self.polygon.cells[corner as usize].col),
            rows,
            corner,
            stack: stack[0],
            stamp: self.stamp[stack[0] as usize],
        }
    }

    /// The paper's candidates: for each cell the longest row, down to the first link that is shorter.
    ///
    /// Upwards through the stack, `steps` holds the links that are shorter than all links above them so far, the
    /// nearest and longest last, so that the first link below that is shorter than a run is found by bisection.
    fn best_of_longest_rows(&mut self, stack: &[u32]) -> Option<Candidate> {
        let mut steps = std::mem::take(&mut self.steps);
        steps.clear();
        let mut best = None;
        for (i, &cell) in stack.iter().enumerate().rev() {
            let (run, link) = (self.run[cell as usize], self.link[cell as usize]);
            while steps.last().is_some_and(|&(_, shorter)| shorter >= link) {
                steps.pop();
            }
            steps.push((i, link));
            // The lowest link is 0, so there always is a shorter one.
            let nearest = steps.partition_point(|&(_, step)| step < run) - 1;
            best = best.max(Some(self.candidate(stack, i, steps[nearest].0, run)));
        }
        self.steps = steps;
        best
    }

    /// The largest rectangle under a histogram that lies on its side, with a bar for each run and each link.
    ///
    /// Downwards through the stack, `steps` holds the rectangles that still go on, as (first row, width), the widths
    /// growing. A link ends those that are wider than it.
    fn best_of_any_width(&mut self, stack: &[u32]) -> Option<Candidate> {
        let mut steps = std::mem::take(&mut self.steps);
        steps.clear();
        let mut best = None;
        for (i, &cell) in stack.iter().enumerate() {
            let (run, link) = (self.run[cell as usize], self.link[cell as usize]);
            if steps.last().is_none_or(|&(_, width)| width < run) {
                steps.push((i, run));
            }
            let mut first = i;
            while let Some((start, width)) = steps.pop_if(|&mut (_, width)| width > link) {
                best = best.max(Some(self.candidate(stack, start, i, width)));
                first = start;
            }
            if link > 0 && steps.last().is_none_or(|&(_, width)| width < link) {
                steps.push((first, link));
            }
        }
        self.steps = steps;
        best
    }

    /// Removes the cells of a candidate and brings runs, links and stacks up to date.
    fn remove(&mut self, candidate: &Candidate) -> Rectangle {
        let mut around = std::mem::take(&mut self.around);
        let corner = self.list_surroundings(candidate, &mut around);
        self.removals += 1;
        for &cell in &around.inside {
            self.stamp[cell as usize] = NONE;
            for side in [BOTTOM, RIGHT, TOP, LEFT] {
                self.links.cut(cell, side);
            }
        }
        for &cell in &around.above {
            self.link[cell as usize] = 0;
        }
        for &cell in &around.left {
            self.measure_leftwards(cell);
        }
        for &cell in around.above.iter().chain(&around.below) {
            self.evaluate_stack(cell);
        }
        if self.rule == CornerRule::LongestRow {
            around.left.iter().for_each(|&cell| self.evaluate_leftwards(cell));
        }
        self.around = around;
        let (Reverse(row), Reverse(col)) = (candidate.bottom, candidate.left);
        Rectangle { row, col, rows: candidate.rows, cols: candidate.cols, corner }
    }

    /// Evaluates the stacks of this cell and of all cells to its left.
    fn evaluate_leftwards(&mut self, mut cell: u32) {
        while cell != NONE {
            self.evaluate_stack(cell);
            cell = self.links.next(cell, LEFT);
        }
    }

    /// Lists the cells of a candidate and those around it; returns the lower left cell.
    fn list_surroundings(&self, candidate: &Candidate, around: &mut Surroundings) -> u32 {
        let Surroundings { inside, left, above, below } = around;
        for list in [&mut *inside, left, above, below] {
            list.clear();
        }
        let mut first = candidate.corner;
        for row in 1..=candidate.rows {
            left.extend(Some(self.links.next(first, LEFT)).filter(|&cell| cell != NONE));
            let mut cell = first;
            for _ in 0..candidate.cols {
                inside.push(cell);
                if row == 1 {
                    above.extend(Some(self.links.next(cell, TOP)).filter(|&cell| cell != NONE));
                }
                if row == candidate.rows {
                    below.extend(Some(self.links.next(cell, BOTTOM)).filter(|&cell| cell != NONE));
                }
                cell = self.links.next(cell, RIGHT);
            }
            if row < candidate.rows {
                first = self.links.next(first, BOTTOM);
            }
        }
        first
    }
}
