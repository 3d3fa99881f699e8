//! Numbers and vectors of four cells at once, for loops that a compiler turns into vector instructions. Each lane is computed
//! as if it were alone: results do not depend on which cells are neighbours, nor on the processor.

use glam::DVec3;
use std::ops::{Add, Mul, Sub};

/// As many numbers as the vector registers of most processors hold.
pub const LANES: usize = 4;

/// A number of each cell.
#[derive(Clone, Copy)]
pub struct Numbers(pub [f64; LANES]);

/// A vector of each cell.
#[derive(Clone, Copy)]
pub struct Vectors([Numbers; 3]);

// Whatever is not inlined into the function that has the vector instructions does without them: hence the attributes, and
// loops in place of closures over arrays.
impl Numbers {
    #[inline(always)]
    pub fn all(x: f64) -> Self {
        Numbers([x; LANES])
    }

    #[inline(always)]
    pub fn map(mut self, f: impl Fn(f64) -> f64) -> Self {
        for k in 0..LANES {
            self.0[k] = f(self.0[k]);
        }
        self
    }

    #[inline(always)]
    pub fn with(mut self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        for k in 0..LANES {
            self.0[k] = f(self.0[k], other.0[k]);
        }
        self
    }
}

impl Vectors {
    pub const ZERO: Vectors = Vectors([Numbers([0.0; LANES]); 3]);

    #[inline(always)]
    pub fn set(&mut self, lane: usize, v: DVec3) {
        for axis in 0..3 {
            self.0[axis].0[lane] = v[axis];
        }
    }

    #[inline(always)]
    pub fn get(&self, lane: usize) -> DVec3 {
        DVec3::new(self.0[0].0[lane], self.0[1].0[lane], self.0[2].0[lane])
    }

    #[inline(always)]
    pub fn dot(self, other: Self) -> Numbers {
        let (a, b) = (self.0, other.0);
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    }

    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        let (a, b) = (self.0, other.0);
        Vectors([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
    }
}

impl Add for Numbers {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.with(other, |a, b| a + b)
    }
}

impl Sub for Numbers {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.with(other, |a, b| a - b)
    }
}

impl Mul for Numbers {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.with(other, |a, b| a * b)
    }
}

impl Mul<f64> for Numbers {
    type Output = Self;

    #[inline(always)]
    fn mul(self, by: f64) -> Self {
        self.map(|a| a * by)
    }
}

impl Add for Vectors {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let (a, b) = (self.0, other.0);
        Vectors([a[0] + b[0], a[1] + b[1], a[2] + b[2]])
    }
}

impl Sub for Vectors {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let (a, b) = (self.0, other.0);
        Vectors([a[0] - b[0], a[1] - b[1], a[2] - b[2]])
    }
}

impl Mul<Numbers> for Vectors {
    type Output = Self;

    #[inline(always)]
    fn mul(self, by: Numbers) -> Self {
        let a = self.0;
        Vectors([a[0] * by, a[1] * by, a[2] * by])
    }
}

impl Mul<f64> for Vectors {
    type Output = Self;

    #[inline(always)]
    fn mul(self, by: f64) -> Self {
        self * Numbers::all(by)
    }
}
