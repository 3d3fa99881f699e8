//! Rectilinear polygons: unit cells on the integer grid, with walls between some of them.
//!
//! Section 3.3 of Bénière et al. (REFIG 5(1), 2011) lays the quads of a zone out on a regular grid and cuts the
//! "rectilinear polygon" that appears into rectangles. Their polygon is a set of cells. Two quads that come to lie side
//! by side need not share a mesh edge, however: the layout may close around an irregular vertex or a leftover triangle.
//! Here the polygon therefore also has *walls* (slits), drawn thick:
//!
//! ```text
//!   ┌───┬───┬───┐        A wall is an edge between neighbouring places that cannot be crossed: `next` is NONE
//!   │   ┃   │   │        on both sides of it. Walls may be free, hang on the border, branch, or close around a
//!   ├───╂───┼───┤        hole; they need no case of their own, because everything below asks `next` and never
//!   │   ┃   │   │        compares positions.
//!   ├───┼───┼───┘
//!   │   │   │            Rows count upwards, columns to the right.
//!   └───┴───┘
//! ```
//!
//! Storage is sparse, for the bounding box of a spiral strip is the square of its number of cells.

use crate::{Error, Result};
use std::iter::successors;

/// No cell: what lies across a border or a wall.
pub const NONE: u32 = u32::MAX;

/// The first side of a cell, counter-clockwise, and the direction that leads across it.
pub(super) const BOTTOM: usize = 0;
/// The second side.
pub(super) const RIGHT: usize = 1;
/// The third side.
pub(super) const TOP: usize = 2;
/// The fourth side.
pub(super) const LEFT: usize = 3;

/// The side that faces this one; the direction that leads back.
#[inline]
pub(super) const fn opposite(side: usize) -> usize {
    (side + 2) % 4
}

/// The direction to the left of this one (a quarter turn counter-clockwise).
#[inline]
pub(super) const fn turn_left(direction: usize) -> usize {
    (direction + 1) % 4
}

/// The direction to the right of this one (a quarter turn clockwise).
#[inline]
pub(super) const fn turn_right(direction: usize) -> usize {
    (direction + 3) % 4
}

/// A connected rectilinear polygon with walls (slits) between some neighbouring places.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Polygon {
    /// The cells, in any order. Positions are unique and `next` is symmetric; see [`Polygon::check`].
    pub cells: Vec<Cell>,
}

/// A unit square of a [`Polygon`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cell {
    /// Row, counted upwards from an arbitrary origin.
    pub row: i32,
    /// Column, counted to the right from an arbitrary origin.
    pub col: i32,
    /// The quad that lies here; the polygon itself never looks at it.
    pub quad: u32,
    /// The neighbouring cell across side 0 bottom, 1 right, 2 top, 3 left; `u32::MAX` where there is a border or a wall.
    pub next: [u32; 4],
}

/// A rectangle of cells of a polygon with no wall inside.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rectangle {
    /// The lowest row.
    pub row: i32,
    /// The leftmost column.
    pub col: i32,
    /// Number of cells in a column, at least 1.
    pub rows: u32,
    /// Number of cells in a row, at least 1.
    pub cols: u32,
    /// The cell in the lowest row and leftmost column; with `next` it leads to all the others.
    pub corner: u32,
}

impl Rectangle {
    /// Number of cells.
    pub fn area(&self) -> usize {
        self.rows as usize * self.cols as usize
    }
}

impl Polygon {
    /// The cells of a rectangle, row by row from the lower left.
    pub fn cells_of(&self, rectangle: &Rectangle) -> impl Iterator<Item = u32> + '_ {
        let Rectangle { rows, cols, corner, .. } = *rectangle;
        self.line(corner, TOP, rows).flat_map(move |first| self.line(first, RIGHT, cols))
    }

    /// Up to `length` cells from `first` in one direction.
    fn line(&self, first: u32, direction: usize, length: u32) -> impl Iterator<Item = u32> + '_ {
        let step = move |&cell: &u32| Some(self.cells[cell as usize].next[direction]).filter(|&next| next != NONE);
        successors(Some(first), step).take(length as usize)
    }

    /// Checks that positions are unique, `next` is symmetric and joins neighbours on the grid, and all cells connect.
    ///
    /// # Errors
    /// [`Error::Bug`] names the first cell that breaks a rule.
    pub fn check(&self) -> Result<()> {
        self.check_positions()?;
        self.check_links()?;
        self.check_connected()
    }

    fn check_positions(&self) -> Result<()> {
        let mut places: Vec<(i32, i32)> = self.cells.iter().map(|c| (c.row, c.col)).collect();
        places.sort_unstable();
        match places.array_windows().find(|[a, b]| a == b) {
            Some([place, _]) => Err(Error::Bug(format!("two cells of a polygon lie at (row, column) {place:?}"))),
            None => Ok(()),
        }
    }

    fn check_links(&self) -> Result<()> {
        const STEP: [(i64, i64); 4] = [(-1, 0), (0, 1), (1, 0), (0, -1)];
        for (id, cell) in self.cells.iter().enumerate() {
            for side in [BOTTOM, RIGHT, TOP, LEFT] {
                let next = cell.next[side];
                if next == NONE {
                    continue;
                }
                let sound = self.cells.get(next as usize).is_some_and(|other| {
                    let step = (i64::from(other.row) - i64::from(cell.row), i64::from(other.col) - i64::from(cell.col));
                    step == STEP[side] && other.next[opposite(side)] as usize == id
                });
                if !sound {
                    return Err(Error::Bug(format!("side {side} of cell {id} of a polygon leads to {next} wrongly")));
                }
            }
        }
        Ok(())
    }

    fn check_connected(&self) -> Result<()> {
        let mut reached = vec![false; self.cells.len()];
        let mut stack: Vec<u32> = (0..self.cells.len().min(1) as u32).collect();
        while let Some(cell) = stack.pop() {
            if !std::mem::replace(&mut reached[cell as usize], true) {
                stack.extend(self.cells[cell as usize].next.iter().filter(|&&next| next != NONE));
            }
        }
        match reached.iter().position(|&r| !r) {
            Some(cell) => Err(Error::Bug(format!("cell {cell} of a polygon cannot be reached from cell 0"))),
            None => Ok(()),
        }
    }

    /// Checks that the rectangles cover every cell exactly once and have no wall inside.
    ///
    /// # Errors
    /// [`Error::Bug`] names the first rectangle or cell that breaks a rule.
    pub fn check_dissection(&self, rectangles: &[Rectangle]) -> Result<()> {
        let mut covered = vec![false; self.cells.len()];
        for rectangle in rectangles {
            self.check_rectangle(rectangle, &mut covered)?;
        }
        match covered.iter().position(|&c| !c) {
            Some(cell) => Err(Error::Bug(format!("cell {cell} of a polygon is in no rectangle"))),
            None => Ok(()),
        }
    }

    fn check_rectangle(&self, rectangle: &Rectangle, covered: &mut [bool]) -> Result<()> {
        let bug = |what| Err(Error::Bug(format!("{rectangle:?} of a polygon {what}")));
        let at_corner = |corner: &Cell| (corner.row, corner.col) == (rectangle.row, rectangle.col);
        if !self.cells.get(rectangle.corner as usize).is_some_and(at_corner) {
            return bug("does not lie at its corner");
        }
        let mut count = 0;
        for id in self.cells_of(rectangle) {
            count += 1;
            if std::mem::replace(&mut covered[id as usize], true) {
                return bug("overlaps another one");
            }
            let cell = &self.cells[id as usize];
            let (up, right) = (cell.row.abs_diff(rectangle.row) + 1, cell.col.abs_diff(rectangle.col) + 1);
            if (up < rectangle.rows && cell.next[TOP] == NONE) || (right < rectangle.cols && cell.next[RIGHT] == NONE) {
                return bug("has a border or a wall inside");
            }
        }
        if count == rectangle.area() { Ok(()) } else { bug("is not full") }
    }
}

/// The neighbours of every cell, as a copy that an algorithm may cut apart.
pub(super) struct Links(Vec<[u32; 4]>);

impl Links {
    pub fn of(polygon: &Polygon) -> Self {
        Self(polygon.cells.iter().map(|cell| cell.next).collect())
    }

    /// Number of cells.
    pub fn len(&self) -> u32 {
        self.0.len() as u32
    }

    /// The cell across this side; [`NONE`] at a border, a wall or a cut.
    #[inline]
    pub fn next(&self, cell: u32, side: usize) -> u32 {
        self.0[cell as usize][side]
    }

    /// Whether there is a cell across this side.
    #[inline]
    pub fn joined(&self, cell: u32, side: usize) -> bool {
        self.next(cell, side) != NONE
    }

    /// Makes this side of a cell a wall.
    pub fn cut(&mut self, cell: u32, side: usize) {
        let other = std::mem::replace(&mut self.0[cell as usize][side], NONE);
        if other != NONE {
            self.0[other as usize][opposite(side)] = NONE;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::{block, drawing};
    use super::*;

    #[test]
    fn sound_polygons_pass_and_each_broken_rule_is_found() {
        let sound = drawing(&["##.", "#|#", "###"]);
        sound.check().unwrap();
        assert_eq!(Polygon::default().check().ok(), Some(()));

        let doubled = {
            let mut p = sound.clone();
            p.cells[1].col = p.cells[0].col;
            p
        };
        let far_link = {
            let mut p = sound.clone();
            p.cells[0].row += 10;
            p
        };
        let one_way = {
            let mut p = sound.clone();
            let side = p.cells[0].next.iter().position(|&n| n != NONE).unwrap();
            p.cells[0].next[side] = NONE;
            p
        };
        let out_of_range = {
            let mut p = sound.clone();
            p.cells[0].next[LEFT] = 1000;
            p
        };
        let apart = {
            let mut p = block(1, 2);
            p.cells[0].next = [NONE; 4];
            p.cells[1].next = [NONE; 4];
            p
        };
        for broken in [doubled, far_link, one_way, out_of_range, apart] {
            assert!(matches!(broken.check(), Err(Error::Bug(_))), "{broken:?}");
        }
    }

    #[test]
    fn extreme_positions_do_not_overflow() {
        let mut p = block(1, 2);
        (p.cells[0].row, p.cells[1].row) = (i32::MIN, i32::MAX);
        assert!(p.check().is_err());
    }

    #[test]
    fn cells_of_a_rectangle_come_row_by_row() {
        let p = block(3, 4);
        let corner = p.cells.iter().position(|c| (c.row, c.col) == (1, 1)).unwrap() as u32;
        let rectangle = Rectangle { row: 1, col: 1, rows: 2, cols: 3, corner };
        let places: Vec<_> = p.cells_of(&rectangle).map(|c| &p.cells[c as usize]).map(|c| (c.row, c.col)).collect();
        assert_eq!(places, [(1, 1), (1, 2), (1, 3), (2, 1), (2, 2), (2, 3)]);
    }

    #[test]
    fn bad_dissections_are_found() {
        let p = drawing(&["#|#", "##"]);
        let find = |row, col| p.cells.iter().position(|c| (c.row, c.col) == (row, col)).unwrap() as u32;
        let at = |row, col, rows, cols| Rectangle { row, col, rows, cols, corner: find(row, col) };
        p.check_dissection(&[at(0, 0, 1, 2), at(1, 0, 1, 1), at(1, 1, 1, 1)]).unwrap();
        p.check_dissection(&[at(0, 0, 2, 1), at(0, 1, 2, 1)]).unwrap();
        let wall_inside = [at(0, 0, 2, 2)];
        let missing = [at(0, 0, 2, 1), at(0, 1, 1, 1)];
        let twice = [at(0, 0, 2, 1), at(0, 0, 1, 2), at(1, 1, 1, 1)];
        let too_big = [at(0, 0, 2, 1), at(0, 1, 2, 2)];
        let misplaced = [at(0, 0, 2, 1), Rectangle { row: 1, ..at(0, 1, 2, 1) }];
        for bad in [&wall_inside[..], &missing, &twice, &too_big, &misplaced] {
            assert!(matches!(p.check_dissection(bad), Err(Error::Bug(_))), "{bad:?}");
        }
    }

    #[test]
    fn cutting_a_link_cuts_both_ways() {
        let p = block(2, 2);
        let mut links = Links::of(&p);
        let right = links.next(0, RIGHT);
        links.cut(right, LEFT);
        assert!(!links.joined(0, RIGHT) && !links.joined(right, LEFT) && links.joined(0, TOP));
        assert_eq!(links.len(), 4);
    }
}
