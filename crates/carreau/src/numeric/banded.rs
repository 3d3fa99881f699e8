//! Symmetric positive definite systems with a narrow band, solved by Cholesky factorisation.

use glam::DVec3;

/// The lower half of a symmetric band matrix.
pub struct Banded {
    size: usize,
    /// Number of diagonals below the main one.
    half: usize,
    /// Row by row: the entries of columns `row − half ..= row`.
    rows: Vec<f64>,
}

impl Banded {
    /// A zero matrix.
    pub fn new(size: usize, half: usize) -> Self {
        Banded { size, half, rows: vec![0.0; size * (half + 1)] }
    }

    /// Adds to the entries (i, j) and (j, i); needs `|i − j| ≤ half`.
    #[inline]
    pub fn add(&mut self, i: usize, j: usize, x: f64) {
        let (row, column) = (i.max(j), i.min(j));
        debug_assert!(row - column <= self.half);
        self.rows[row * (self.half + 1) + column + self.half - row] += x;
    }

    /// Replaces the right-hand sides by the solution; `false` where the matrix is not positive definite.
    pub fn solve(mut self, rhs: &mut [DVec3]) -> bool {
        self.factorise() && {
            self.substitute(rhs);
            true
        }
    }

    #[inline]
    fn at(&self, row: usize, column: usize) -> f64 {
        self.rows[row * (self.half + 1) + column + self.half - row]
    }

    /// A = L Lᵀ, L in place of A.
    fn factorise(&mut self) -> bool {
        for row in 0..self.size {
            let first = row.saturating_sub(self.half);
            for column in first..=row {
                let from = first.max(column.saturating_sub(self.half));
                let known: f64 = (from..column).map(|k| self.at(row, k) * self.at(column, k)).sum();
                let rest = self.at(row, column) - known;
                let value = if column < row { rest / self.at(column, column) } else { rest.sqrt() };
                if !(value.is_finite() && (column < row || value > 0.0)) {
                    return false;
                }
                self.rows[row * (self.half + 1) + column + self.half - row] = value;
            }
        }
        true
    }

    fn substitute(&self, x: &mut [DVec3]) {
        for row in 0..self.size {
            let known: DVec3 = (row.saturating_sub(self.half)..row).map(|k| self.at(row, k) * x[k]).sum();
            x[row] = (x[row] - known) / self.at(row, row);
        }
        for row in (0..self.size).rev() {
            let known: DVec3 = (row + 1..self.size.min(row + self.half + 1)).map(|k| self.at(k, row) * x[k]).sum();
            x[row] = (x[row] - known) / self.at(row, row);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn solution_satisfies_the_system(n in 1usize..12, half in 0usize..4, seed in prop::collection::vec(-1.0f64..1.0, 60)) {
            let entry = |i: usize, j: usize| {
                let (i, j) = (i.max(j), i.min(j));
                let x = seed[(7 * i + 3 * j) % seed.len()];
                // Diagonally dominant, hence positive definite.
                if i == j { 8.0 + x } else if i - j <= half { x } else { 0.0 }
            };
            let mut a = Banded::new(n, half);
            for i in 0..n {
                for j in i.saturating_sub(half)..=i {
                    a.add(j, i, entry(i, j));
                }
            }
            let rhs: Vec<DVec3> = (0..n).map(|k| DVec3::new(seed[k], seed[k + 1], seed[k + 2])).collect();
            let mut x = rhs.clone();
            prop_assert!(a.solve(&mut x));
            for (i, rhs) in rhs.iter().enumerate() {
                let product: DVec3 = (0..n).map(|j| entry(i, j) * x[j]).sum();
                prop_assert!(product.distance(*rhs) < 1e-12);
            }
        }
    }

    #[test]
    fn indefinite_matrices_are_refused() {
        let mut a = Banded::new(2, 1);
        a.add(0, 0, 1.0);
        a.add(0, 1, 2.0);
        a.add(1, 1, 1.0);
        assert!(!a.solve(&mut [DVec3::X, DVec3::Y]));
    }
}
