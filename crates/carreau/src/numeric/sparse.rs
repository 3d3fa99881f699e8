//! Sparse positive definite systems, real and complex, by Cholesky factors of the crate faer. No other file solves with it;
//! `hex::optimise` uses its vector instructions.
//!
//! On one thread: the same bytes for any number of them. Every solution is checked by its residual, and no panic escapes.

use crate::error::{Error, Result};
use faer::prelude::Solve;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};
use std::ops::{AddAssign, Mul, SubAssign};
use std::panic::{AssertUnwindSafe, catch_unwind};

pub use faer::c64 as Complex;

/// What a matrix may hold.
pub trait Number: faer::traits::ComplexField + Copy + AddAssign + SubAssign + Mul<Output = Self> {
    /// Zero.
    const ZERO: Self;
    /// The conjugate.
    fn conjugate(self) -> Self;
    /// The absolute value.
    fn size(self) -> f64;
}

impl Number for f64 {
    const ZERO: f64 = 0.0;
    fn conjugate(self) -> f64 {
        self
    }
    fn size(self) -> f64 {
        self.abs()
    }
}

impl Number for Complex {
    const ZERO: Complex = Complex { re: 0.0, im: 0.0 };
    fn conjugate(self) -> Complex {
        Complex::new(self.re, -self.im)
    }
    fn size(self) -> f64 {
        self.re.hypot(self.im)
    }
}

/// Entries of a symmetric or Hermitian matrix, of its lower triangle; equal places add up.
#[derive(Debug, Clone)]
pub struct Matrix<T> {
    n: usize,
    entries: Vec<Triplet<u32, u32, T>>,
}

/// The order of elimination and the fill that it brings: the same for all matrices with entries in the same places.
#[derive(Clone)]
pub struct Plan(SymbolicLlt<u32>);

/// The factor of a matrix.
pub struct Factor<T> {
    matrix: SparseColMat<u32, T>,
    factor: Llt<u32, T>,
    /// Largest sum of absolute values of a row.
    norm: f64,
}

/// Largest residual of a solution, relative to what the system is made of.
const RESIDUAL: f64 = 1e-8;

impl<T: Number> Matrix<T> {
    /// A matrix of zeros.
    pub fn new(n: usize) -> Self {
        Matrix { n, entries: Vec::new() }
    }

    /// Adds to a place of the lower triangle, column ≤ row.
    pub fn add(&mut self, row: u32, column: u32, value: T) {
        self.entries.push(Triplet::new(row, column, value));
    }

    /// Factorises the matrix. The plan is made with the first matrix and taken for the others.
    ///
    /// # Errors
    /// [`Error::Numeric`] where it is not positive definite.
    pub fn factor(&self, plan: &mut Option<Plan>) -> Result<Factor<T>> {
        faer::set_global_parallelism(faer::Par::Seq);
        let matrix = guarded(|| SparseColMat::<u32, T>::try_new_from_triplets(self.n, self.n, &self.entries))?;
        let symbolic = match plan {
            Some(plan) => plan.0.clone(),
            None => guarded(|| SymbolicLlt::try_new(matrix.symbolic(), Side::Lower))?,
        };
        let factor = guarded(|| Llt::try_new_with_symbolic(symbolic.clone(), matrix.as_ref(), Side::Lower))?;
        plan.get_or_insert(Plan(symbolic));
        let mut rows = vec![0.0; self.n];
        for e in &self.entries {
            rows[e.row as usize] += e.val.size();
            if e.row != e.col {
                rows[e.col as usize] += e.val.size();
            }
        }
        Ok(Factor { matrix, factor, norm: rows.into_iter().fold(0.0, f64::max) })
    }
}

/// What faer does, its failures and panics as errors.
fn guarded<R, E: std::fmt::Debug>(work: impl FnOnce() -> std::result::Result<R, E>) -> Result<R> {
    let failed = |what: String| Error::Numeric(format!("a linear system could not be solved: {what}"));
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(done) => done.map_err(|e| failed(format!("{e:?}"))),
        Err(_) => Err(failed("the factorisation broke off".into())),
    }
}

impl<T: Number> Factor<T> {
    /// Solves for one right side.
    ///
    /// # Errors
    /// [`Error::Numeric`] where the residual is not small even after a step of refinement.
    pub fn solve(&self, rhs: &[T]) -> Result<Vec<T>> {
        let mut x = self.solve_once(rhs)?;
        for attempt in 0..2 {
            let residual = self.residual(&x, rhs);
            let largest = |v: &[T]| v.iter().fold(0.0, |most: f64, x| most.max(x.size()));
            let limit = RESIDUAL * (self.norm * largest(&x) + largest(rhs));
            // Not a number is not small.
            if largest(&residual) <= limit && residual.iter().all(|r| r.size().is_finite()) {
                return Ok(x);
            }
            if attempt == 0 {
                let correction = self.solve_once(&residual)?;
                x.iter_mut().zip(correction).for_each(|(x, c)| *x += c);
            }
        }
        Err(Error::Numeric("a linear system could not be solved: its matrix is nearly singular".into()))
    }

    fn solve_once(&self, rhs: &[T]) -> Result<Vec<T>> {
        let column = Mat::from_fn(rhs.len(), 1, |i, _| rhs[i]);
        let x = guarded(|| Ok::<_, Error>(self.factor.solve(&column)))?;
        Ok((0..rhs.len()).map(|i| x[(i, 0)]).collect())
    }

    fn residual(&self, x: &[T], rhs: &[T]) -> Vec<T> {
        let mut residual = rhs.to_vec();
        let a = self.matrix.as_ref();
        for column in 0..a.ncols() {
            for (row, &value) in a.row_idx_of_col(column).zip(a.val_of_col(column)) {
                residual[row] -= value * x[column];
                if row != column {
                    residual[column] -= value.conjugate() * x[row];
                }
            }
        }
        residual
    }
}

/// A sum of squares of affine forms: Σ w (Σ a x + b)².
#[derive(Debug, Clone)]
pub struct LeastSquares {
    matrix: Matrix<f64>,
    rhs: Vec<f64>,
}

impl LeastSquares {
    /// No square yet.
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

    /// The minimum; the plan as in [`Matrix::factor`].
    ///
    /// # Errors
    /// [`Error::Numeric`] where it is not unique.
    pub fn solve(&self, plan: &mut Option<Plan>) -> Result<Vec<f64>> {
        if self.rhs.is_empty() {
            return Ok(Vec::new());
        }
        self.matrix.factor(plan)?.solve(&self.rhs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn solutions_solve(n in 1usize..40, shift in 0.01f64..3.0, twist in -3.0f64..3.0) {
            // A chain with a twisted connection, and one link around.
            let mut matrix = Matrix::new(n);
            let turn = Complex::new(twist.cos(), twist.sin());
            for i in 0..n as u32 {
                matrix.add(i, i, Complex::new(2.0 + shift, 0.0));
                if i > 0 {
                    matrix.add(i, i - 1, turn * Complex::new(-1.0, 0.0));
                }
            }
            let rhs: Vec<Complex> = (0..n).map(|i| Complex::new(i as f64, 1.0)).collect();
            let mut plan = None;
            let x = matrix.factor(&mut plan).unwrap().solve(&rhs).unwrap();
            for i in 0..n {
                let mut sum = x[i] * (2.0 + shift);
                if i > 0 {
                    sum -= turn * x[i - 1];
                }
                if i + 1 < n {
                    sum -= turn.conj() * x[i + 1];
                }
                prop_assert!((sum - rhs[i]).norm() < 1e-9);
            }
            let again = matrix.factor(&mut plan).unwrap().solve(&rhs).unwrap();
            prop_assert_eq!(x, again);
        }

        #[test]
        fn the_minimum_of_squares_has_no_slope(values in prop::collection::vec(-5.0f64..5.0, 3..20)) {
            let n = values.len() - 1;
            let mut system = LeastSquares::new(n);
            for k in 0..n as u32 {
                system.add(1.0, &[(k, 1.0), ((k + 1) % n as u32, -2.0)][..if n > 1 { 2 } else { 1 }], values[k as usize]);
                system.add(0.5, &[(k, 1.0)], values[n]);
            }
            let x = system.solve(&mut None).unwrap();
            let cost = |x: &[f64]| {
                let of = |k: usize| {
                    let next = if n > 1 { -2.0 * x[(k + 1) % n] } else { 0.0 };
                    (x[k] + next + values[k]).powi(2) + 0.5 * (x[k] + values[n]).powi(2)
                };
                (0..n).map(of).sum::<f64>()
            };
            let least = cost(&x);
            for k in 0..n {
                for step in [-1e-3, 1e-3] {
                    let mut moved = x.clone();
                    moved[k] += step;
                    prop_assert!(cost(&moved) > least);
                }
            }
        }
    }

    #[test]
    fn what_is_not_definite_is_refused() {
        let mut matrix = Matrix::new(2);
        matrix.add(0, 0, 1.0);
        matrix.add(1, 1, -1.0);
        assert!(matches!(matrix.factor(&mut None), Err(Error::Numeric(_))));
        let mut broken = Matrix::new(1);
        broken.add(0, 0, f64::NAN);
        assert!(broken.factor(&mut None).and_then(|f| f.solve(&[1.0])).is_err());
    }
}
