//! Sparse positive definite systems, real and complex, by Cholesky factors (the crate faer, on one thread: the same bytes for
//! any number of them).

use crate::error::{Error, Result};
use faer::prelude::Solve;
use faer::sparse::linalg::solvers::Llt;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side, c64};

/// Entries of a symmetric or Hermitian matrix, of its lower triangle; equal places add up.
pub struct Matrix<T> {
    n: usize,
    entries: Vec<Triplet<u32, u32, T>>,
}

/// What a matrix may hold.
pub trait Number: faer::traits::ComplexField + Copy {}
impl Number for f64 {}
impl Number for c64 {}

/// The factor of a matrix.
pub struct Factor<T> {
    factor: Llt<u32, T>,
}

impl<T: Number> Matrix<T> {
    pub fn new(n: usize) -> Self {
        Matrix { n, entries: Vec::new() }
    }

    /// Adds to a place of the lower triangle, column ≤ row.
    pub fn add(&mut self, row: u32, column: u32, value: T) {
        self.entries.push(Triplet::new(row, column, value));
    }

    /// Factorises the matrix.
    ///
    /// # Errors
    /// [`Error::Numeric`] where it is not positive definite.
    pub fn factor(&self) -> Result<Factor<T>> {
        faer::set_global_parallelism(faer::Par::Seq);
        let failed = |what: String| Error::Numeric(format!("a linear system could not be solved: {what}"));
        let matrix = SparseColMat::<u32, T>::try_new_from_triplets(self.n, self.n, &self.entries)
            .map_err(|e| failed(format!("{e:?}")))?;
        let factor = matrix.sp_cholesky(Side::Lower).map_err(|e| failed(format!("{e:?}")))?;
        Ok(Factor { factor })
    }
}

impl<T: Number> Factor<T> {
    pub fn solve(&self, rhs: &[T]) -> Vec<T> {
        let column = Mat::from_fn(rhs.len(), 1, |i, _| rhs[i]);
        let x = self.factor.solve(&column);
        (0..rhs.len()).map(|i| x[(i, 0)]).collect()
    }
}

/// A sum of squares of affine forms: Σ w (Σ a x + b)².
pub struct LeastSquares {
    matrix: Matrix<f64>,
    rhs: Vec<f64>,
}

impl LeastSquares {
    pub fn new(unknowns: usize) -> Self {
        LeastSquares { matrix: Matrix::new(unknowns), rhs: vec![0.0; unknowns] }
    }

    /// Adds w (Σ a x + b)²; every unknown comes once.
    pub fn add(&mut self, w: f64, terms: &[(u32, f64)], b: f64) {
        for &(i, a) in terms {
            self.rhs[i as usize] -= w * a * b;
            for &(j, c) in terms.iter().filter(|t| t.0 <= i) {
                self.matrix.add(i, j, w * a * c);
            }
        }
    }

    /// The minimum.
    ///
    /// # Errors
    /// [`Error::Numeric`] where it is not unique.
    pub fn solve(&self) -> Result<Vec<f64>> {
        if self.rhs.is_empty() {
            return Ok(Vec::new());
        }
        Ok(self.matrix.factor()?.solve(&self.rhs))
    }
}
