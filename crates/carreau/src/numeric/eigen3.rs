//! Eigenvalues and eigenvectors of symmetric 3 × 3 matrices by Jacobi rotations.
//!
//! Jacobi's method (Golub and Van Loan, Matrix Computations, §8.5) needs a few more operations than a closed formula but
//! keeps the eigenvectors orthonormal to rounding, also where eigenvalues coincide.

use glam::{DMat3, DVec3};

/// Convergence is quadratic: three or four sweeps are usual.
const MOST_SWEEPS: usize = 30;

/// Eigenvalues in ascending order with their unit eigenvectors.
#[derive(Debug, Clone, Copy)]
pub struct Eigen3 {
    /// Ascending.
    pub values: [f64; 3],
    /// Orthonormal, in the order of the values; their signs have no meaning.
    pub vectors: [DVec3; 3],
}

impl Eigen3 {
    /// Decomposes a symmetric matrix of finite entries.
    pub fn new(matrix: DMat3) -> Self {
        let (mut a, mut v) = (matrix.to_cols_array_2d(), DMat3::IDENTITY.to_cols_array_2d());
        for _ in 0..MOST_SWEEPS {
            let off = a[0][1].abs() + a[0][2].abs() + a[1][2].abs();
            if !(off > 0.0) {
                break;
            }
            for (p, q) in [(0, 1), (0, 2), (1, 2)] {
                rotate(&mut a, &mut v, p, q);
            }
        }
        let mut order = [0, 1, 2];
        order.sort_by(|&i: &usize, &j| a[i][i].total_cmp(&a[j][j]));
        Eigen3 { values: order.map(|k| a[k][k]), vectors: order.map(|k| DVec3::from_array(v[k])) }
    }

    /// x with A x = b, as far as the eigenvalues above a share of the largest allow (pseudo-inverse).
    pub fn solve(&self, b: DVec3, share: f64) -> DVec3 {
        let least = share * self.values[2];
        let terms = self.values.iter().zip(self.vectors).filter(|(value, _)| **value > least);
        terms.map(|(value, vector)| vector * (vector.dot(b) / value)).sum()
    }
}

/// The rotation in the plane of p and q that makes the entry (p, q) vanish; `v` holds the eigenvectors as rows.
fn rotate(a: &mut [[f64; 3]; 3], v: &mut [[f64; 3]; 3], p: usize, q: usize) {
    let entry = a[p][q];
    // Smaller entries no longer change the diagonal.
    if entry.abs() <= f64::EPSILON * 0.25 * (a[p][p].abs().min(a[q][q].abs())) || entry == 0.0 {
        (a[p][q], a[q][p]) = (0.0, 0.0);
        return;
    }
    let theta = (a[q][q] - a[p][p]) / (2.0 * entry);
    let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
    let c = t.hypot(1.0).recip();
    let s = t * c;
    a[p][p] -= t * entry;
    a[q][q] += t * entry;
    (a[p][q], a[q][p]) = (0.0, 0.0);
    let r = 3 - p - q;
    let (rp, rq) = (a[r][p], a[r][q]);
    (a[r][p], a[r][q]) = (c * rp - s * rq, s * rp + c * rq);
    (a[p][r], a[q][r]) = (a[r][p], a[r][q]);
    for k in 0..3 {
        (v[p][k], v[q][k]) = (c * v[p][k] - s * v[q][k], s * v[p][k] + c * v[q][k]);
    }
}

/// v vᵀ
pub fn outer(v: DVec3) -> DMat3 {
    DMat3::from_cols(v * v.x, v * v.y, v * v.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn assert_decomposes(matrix: DMat3) {
        let Eigen3 { values, vectors } = Eigen3::new(matrix);
        let size = matrix.to_cols_array().iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        assert!(values[0] <= values[1] && values[1] <= values[2]);
        for (value, vector) in values.iter().zip(vectors) {
            assert!((matrix * vector - vector * *value).length() <= 1e-14 * size, "{matrix}");
        }
        let frame = DMat3::from_cols_array_2d(&vectors.map(|v| v.to_array()));
        assert!((frame.transpose() * frame).abs_diff_eq(DMat3::IDENTITY, 1e-14));
    }

    proptest! {
        #[test]
        fn vectors_are_scaled_by_their_values(x in prop::array::uniform6(-1f64..1.0), exponent in -100i32..100) {
            let [a, b, c, d, e, f] = x.map(|v| v * 2f64.powi(exponent));
            assert_decomposes(DMat3::from_cols_array(&[a, b, c, b, d, e, c, e, f]));
        }

        #[test]
        fn flat_spreads_are_no_exception(p in prop::array::uniform3(-1f64..1.0), q in prop::array::uniform3(-1f64..1.0)) {
            let (p, q) = (DVec3::from_array(p), DVec3::from_array(q));
            assert_decomposes(outer(p));
            assert_decomposes(outer(p) + outer(q) * 1e-9);
            assert_decomposes(outer(p) + DMat3::IDENTITY);
        }

        #[test]
        fn the_pseudo_inverse_solves_what_can_be_solved(p in prop::array::uniform3(0.1f64..1.0), x in -1f64..1.0) {
            let p = DVec3::from_array(p);
            let solution = Eigen3::new(outer(p)).solve(outer(p) * (p * x), 1e-12);
            prop_assert!(solution.distance(p * x) < 1e-13);
        }
    }

    #[test]
    fn special_matrices() {
        assert_decomposes(DMat3::ZERO);
        assert_decomposes(DMat3::IDENTITY);
        assert_decomposes(DMat3::from_diagonal(DVec3::new(3.0, -1.0, 2.0)));
    }
}
