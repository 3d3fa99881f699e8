//! Vectors of whole numbers: edges in cells, and places in half cells. Their products are exact.

use std::ops::{Add, AddAssign, Mul, Neg, Sub};

/// A whole vector of the plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Cell {
    pub x: i64,
    pub y: i64,
}

impl Cell {
    pub const ZERO: Cell = Cell { x: 0, y: 0 };

    pub fn new(x: i64, y: i64) -> Self {
        Cell { x, y }
    }

    /// Twice the area between two vectors, positive where the other is to the left.
    pub fn cross(self, other: Cell) -> i64 {
        self.x * other.y - self.y * other.x
    }

    /// Turned by right angles.
    pub fn turned(self, turn: i32) -> Self {
        match turn.rem_euclid(4) {
            0 => self,
            1 => Cell::new(-self.y, self.x),
            2 => -self,
            _ => Cell::new(self.y, -self.x),
        }
    }

    /// Steps from one whole point to the next along the vector.
    pub fn steps(self) -> i64 {
        let (mut a, mut b) = (self.x.abs(), self.y.abs());
        while b != 0 {
            (a, b) = (b, a % b);
        }
        a
    }
}

impl Add for Cell {
    type Output = Cell;
    fn add(self, other: Cell) -> Cell {
        Cell::new(self.x + other.x, self.y + other.y)
    }
}

impl AddAssign for Cell {
    fn add_assign(&mut self, other: Cell) {
        *self = *self + other;
    }
}

impl Sub for Cell {
    type Output = Cell;
    fn sub(self, other: Cell) -> Cell {
        Cell::new(self.x - other.x, self.y - other.y)
    }
}

impl Neg for Cell {
    type Output = Cell;
    fn neg(self) -> Cell {
        Cell::new(-self.x, -self.y)
    }
}

impl Mul<Cell> for i64 {
    type Output = Cell;
    fn mul(self, v: Cell) -> Cell {
        Cell::new(self * v.x, self * v.y)
    }
}
