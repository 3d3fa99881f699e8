//! Gauss–Legendre quadrature.

use std::f64::consts::PI;

/// A rule with n points: exact for polynomials of degree 2 n − 1.
#[derive(Debug, Clone)]
pub struct GaussRule {
    /// Nodes in [0, 1] with their weights, which add up to 1.
    nodes: Vec<(f64, f64)>,
}

impl GaussRule {
    /// The rule with `n` points, 1 at least. Its nodes are the roots of the Legendre polynomial, by Newton's method from
    /// cos(π (k + ¾) / (n + ½)) (Abramowitz and Stegun 22.16.6).
    pub fn new(n: usize) -> Self {
        let n = n.max(1);
        let node = |k: usize| {
            let mut x = (PI * (k as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..100 {
                let (mut before, mut p) = (1.0, x);
                for j in 1..n {
                    let j = j as f64;
                    (before, p) = (p, ((2.0 * j + 1.0) * x * p - j * before) / (j + 1.0));
                }
                slope = n as f64 * (x * p - before) / (x * x - 1.0);
                let step = p / slope;
                x -= step;
                if step.abs() < 1e-16 {
                    break;
                }
            }
            (0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope))
        };
        GaussRule { nodes: (0..n).map(node).collect() }
    }

    /// Nodes and weights for the interval from `a` to `b`.
    pub fn over(&self, a: f64, b: f64) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.nodes.iter().map(move |&(x, w)| (a + x * (b - a), w * (b - a)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_up_to_twice_the_points_are_exact() {
        for n in 1..=16 {
            let rule = GaussRule::new(n);
            for degree in 0..2 * n as i32 {
                let sum: f64 = rule.over(-1.0, 2.0).map(|(x, w)| w * x.powi(degree)).sum();
                let exact = (2f64.powi(degree + 1) - (-1f64).powi(degree + 1)) / f64::from(degree + 1);
                assert!((sum - exact).abs() < 1e-13 * exact.abs().max(1.0), "{n} {degree} {sum} {exact}");
            }
        }
    }
}
