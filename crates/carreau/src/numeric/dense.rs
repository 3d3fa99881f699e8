//! Dense symmetric matrices, row by row: Cholesky factors and inverses.

/// The lower factor of a positive definite matrix, with zeros above; `None` where it is not positive definite.
pub fn cholesky(matrix: &[f64], n: usize) -> Option<Vec<f64>> {
    let mut l = vec![0.0; n * n];
    for i in 0..n {
        for j in 0..=i {
            let (a, b) = (&l[i * n..i * n + j], &l[j * n..j * n + j]);
            let value = matrix[i * n + j] - a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            if i == j {
                if !(value > 0.0 && value.is_finite()) {
                    return None;
                }
                l[i * n + i] = value.sqrt();
            } else {
                l[i * n + j] = value / l[j * n + j];
            }
        }
    }
    Some(l)
}

/// Solves for one right side with a lower factor.
pub fn solve(l: &[f64], n: usize, rhs: &[f64]) -> Vec<f64> {
    let mut x = rhs.to_vec();
    for i in 0..n {
        let sum: f64 = (0..i).map(|j| l[i * n + j] * x[j]).sum();
        x[i] = (x[i] - sum) / l[i * n + i];
    }
    for i in (0..n).rev() {
        x[i] /= l[i * n + i];
        let value = x[i];
        (0..i).for_each(|j| x[j] -= l[i * n + j] * value);
    }
    x
}

/// The inverse from a lower factor.
pub fn inverse(l: &[f64], n: usize) -> Vec<f64> {
    // Columns of the inverse of the factor, as rows.
    let mut m = vec![0.0; n * n];
    for k in 0..n {
        m[k * n + k] = 1.0 / l[k * n + k];
        for i in k + 1..n {
            let sum: f64 = (k..i).map(|j| l[i * n + j] * m[k * n + j]).sum();
            m[k * n + i] = -sum / l[i * n + i];
        }
    }
    let mut inverse = vec![0.0; n * n];
    for i in 0..n {
        for j in 0..=i {
            let (a, b) = (&m[i * n + i..i * n + n], &m[j * n + i..j * n + n]);
            let value = a.iter().zip(b).map(|(a, b)| a * b).sum();
            (inverse[i * n + j], inverse[j * n + i]) = (value, value);
        }
    }
    inverse
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn factors_and_inverses_give_the_matrix_back(n in 1usize..12, seed in prop::collection::vec(-1.0f64..1.0, 144)) {
            let b = |i: usize, j: usize| seed[i * 12 + j];
            let entry = |i: usize, j: usize| (0..n).map(|k| b(i, k) * b(j, k)).sum::<f64>() + f64::from(u8::from(i == j));
            let matrix: Vec<f64> = (0..n * n).map(|k| entry(k / n, k % n)).collect();
            let l = cholesky(&matrix, n).unwrap();
            let inverse = inverse(&l, n);
            for i in 0..n {
                for j in 0..n {
                    let product: f64 = (0..n).map(|k| matrix[i * n + k] * inverse[k * n + j]).sum();
                    prop_assert!((product - f64::from(u8::from(i == j))).abs() < 1e-9);
                }
            }
            let x = solve(&l, n, &seed[..n]);
            for i in 0..n {
                let sum: f64 = (0..n).map(|k| matrix[i * n + k] * x[k]).sum();
                prop_assert!((sum - seed[i]).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn what_is_not_definite_has_no_factor() {
        assert!(cholesky(&[1.0, 2.0, 2.0, 1.0], 2).is_none());
        assert!(cholesky(&[f64::NAN], 1).is_none());
    }
}
