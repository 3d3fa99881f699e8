//! Quadrics: sums of squared distances to planes (Garland and Heckbert, "Surface simplification using quadric error metrics",
//! SIGGRAPH 1997).

use crate::numeric::eigen3::outer;
use glam::{DMat3, DVec3};

/// Sum of squared distances to planes: pᵀ A p + 2 bᵀ p + c, and of their weights.
#[derive(Debug, Clone, Copy)]
pub struct Quadric {
    a: DMat3,
    b: DVec3,
    c: f64,
    /// Sum of the weights.
    pub weight: f64,
}

impl Quadric {
    /// No plane.
    pub const ZERO: Quadric = Quadric { a: DMat3::ZERO, b: DVec3::ZERO, c: 0.0, weight: 0.0 };

    /// The plane through `p` with unit normal `n`.
    pub fn plane(p: DVec3, n: DVec3, weight: f64) -> Self {
        let d = -n.dot(p);
        Quadric { a: outer(n) * weight, b: n * (d * weight), c: d * d * weight, weight }
    }

    /// Takes in another sum.
    pub fn add(&mut self, other: &Quadric) {
        self.a += other.a;
        self.b += other.b;
        self.c += other.c;
        self.weight += other.weight;
    }

    /// The sum at a point.
    pub fn at(&self, p: DVec3) -> f64 {
        (p.dot(self.a * p) + 2.0 * self.b.dot(p) + self.c).max(0.0)
    }

    /// The point of least error, held at `near` where directions have less than this share of the planes.
    pub fn optimum(&self, near: DVec3, steady: f64) -> DVec3 {
        let steady = steady * (self.a.x_axis.x + self.a.y_axis.y + self.a.z_axis.z);
        let matrix = self.a + DMat3::from_diagonal(DVec3::splat(steady));
        let p = matrix.inverse() * (near * steady - self.b);
        if p.is_finite() { p } else { near }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_optimum_is_where_planes_meet_and_stays_along_them() {
        let corner = DVec3::new(1.0, -2.0, 3.0);
        let planes = [DVec3::X, DVec3::Y, DVec3::new(0.6, 0.0, 0.8)].map(|n| Quadric::plane(corner, n, 2.0));
        let mut sum = Quadric::ZERO;
        planes[..2].iter().for_each(|p| sum.add(p));
        let near = DVec3::new(0.0, 0.0, 7.0);
        assert!(sum.optimum(near, 1e-9).distance(DVec3::new(1.0, -2.0, 7.0)) < 1e-6);
        assert!((sum.at(near) - 2.0 * (1.0 + 4.0)).abs() < 1e-9);
        sum.add(&planes[2]);
        assert!(sum.optimum(near, 1e-9).distance(corner) < 1e-6 && sum.at(corner) < 1e-9);
        assert_eq!((sum.weight, Quadric::ZERO.optimum(near, 1e-9)), (6.0, near));
    }
}
