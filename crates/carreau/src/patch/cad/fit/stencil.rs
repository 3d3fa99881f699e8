//! Normal equations of a tensor-product spline: every control point is coupled with those at most three rows and columns
//! away. Solved by conjugate gradients with diagonal preconditioning, from a good first guess.

use glam::DVec3;

/// Reach of the coupling: the largest degree.
const REACH: usize = 3;
/// Entries of a row of the coupling.
const WIDTH: usize = 2 * REACH + 1;
type Row = [f64; WIDTH * WIDTH];

/// A symmetric matrix over a net of control points of which the border is given.
pub struct Stencil {
    columns: usize,
    rows: usize,
    entries: Vec<Row>,
}

impl Stencil {
    /// A zero matrix over a net of columns and rows, border included.
    pub fn new(columns: usize, rows: usize) -> Self {
        Stencil { columns, rows, entries: vec![[0.0; WIDTH * WIDTH]; columns * rows] }
    }

    /// Adds to the entry of the control points (i, j) and (k, l).
    #[inline]
    pub fn add(&mut self, [i, j]: [usize; 2], [k, l]: [usize; 2], x: f64) {
        self.entries[j * self.columns + i][(l + REACH - j) * WIDTH + k + REACH - i] += x;
    }

    fn is_inner(&self, i: usize, j: usize) -> bool {
        (1..self.columns - 1).contains(&i) && (1..self.rows - 1).contains(&j)
    }

    /// The product with a vector, in rows of inner points only; elsewhere zero.
    fn times(&self, x: &[DVec3], out: &mut [DVec3]) {
        for j in 1..self.rows - 1 {
            let (low, high) = (j.saturating_sub(REACH), (j + REACH).min(self.rows - 1));
            for i in 1..self.columns - 1 {
                let (first, last) = (i.saturating_sub(REACH), (i + REACH).min(self.columns - 1));
                let entries = &self.entries[j * self.columns + i];
                let mut sum = DVec3::ZERO;
                for l in low..=high {
                    let weights = &entries[(l + REACH - j) * WIDTH + first + REACH - i..];
                    let values = &x[l * self.columns + first..=l * self.columns + last];
                    sum += values.iter().zip(weights).map(|(&v, &w)| w * v).sum::<DVec3>();
                }
                out[j * self.columns + i] = sum;
            }
        }
    }

    /// Improves the inner points of `x` until the equations `self · x = rhs` hold there; border points stay.
    pub fn solve(&self, rhs: &[DVec3], x: &mut [DVec3]) {
        if self.columns < 3 || self.rows < 3 {
            return;
        }
        let n = x.len();
        let inverse: Vec<f64> = (0..n)
            .map(|k| {
                let diagonal = self.entries[k][REACH * WIDTH + REACH];
                if self.is_inner(k % self.columns, k / self.columns) && diagonal > 0.0 { 1.0 / diagonal } else { 0.0 }
            })
            .collect();
        let dot = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum::<f64>();
        let scaled = |r: &[DVec3]| -> Vec<DVec3> { r.iter().zip(&inverse).map(|(&r, &w)| w * r).collect() };
        let mut product = vec![DVec3::ZERO; n];
        self.times(x, &mut product);
        let mut r: Vec<DVec3> = rhs
            .iter()
            .zip(&product)
            .zip(&inverse)
            .map(|((b, p), &w)| if w > 0.0 { b - p } else { DVec3::ZERO })
            .collect();
        let mut z = scaled(&r);
        let mut direction = z.clone();
        let mut size = dot(&r, &z);
        let enough = 1e-20 * dot(rhs, &scaled(rhs));
        for _ in 0..1000 {
            if size <= enough {
                return;
            }
            self.times(&direction, &mut product);
            let step = size / dot(&direction, &product);
            if !step.is_finite() {
                return;
            }
            for k in 0..n {
                x[k] += step * direction[k];
                r[k] -= step * product[k];
            }
            z = scaled(&r);
            let next = dot(&r, &z);
            let keep = next / size;
            size = next;
            direction.iter_mut().zip(&z).for_each(|(d, &z)| *d = z + keep * *d);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_with_the_border_given() {
        let (m, n) = (9, 7);
        let mut a = Stencil::new(m, n);
        for j in 0..n {
            for i in 0..m {
                // The five-point Laplacian plus a little identity.
                a.add([i, j], [i, j], 4.1);
                for (k, l) in [(i.wrapping_sub(1), j), (i + 1, j), (i, j.wrapping_sub(1)), (i, j + 1)] {
                    if k < m && l < n {
                        a.add([i, j], [k, l], -1.0);
                    }
                }
            }
        }
        let rhs: Vec<DVec3> = (0..m * n).map(|k| DVec3::new((k as f64).sin(), 1.0, k as f64)).collect();
        let start: Vec<DVec3> = (0..m * n).map(|k| DVec3::new(1.0, (k as f64).cos(), 0.0)).collect();
        let mut x = start.clone();
        a.solve(&rhs, &mut x);
        let mut product = vec![DVec3::ZERO; m * n];
        a.times(&x, &mut product);
        for k in 0..m * n {
            if a.is_inner(k % m, k / m) {
                assert!(product[k].distance(rhs[k]) < 1e-7);
            } else {
                assert_eq!(x[k], start[k]);
            }
        }
    }
}
