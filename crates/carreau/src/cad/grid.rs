//! Bicubic surfaces of least squares on one grid, with a penalty on their second differences.
//!
//! All fits on a grid have their equations in the same places, so that these are summed up control point by control point, and the
//! order of elimination is found once.
//!
//! ```text
//!            ┌─────────────┐
//!            │ · · · · · · ·        ●  a control point
//!            │ · · · ● + + +        +  those after it that share a span with it
//!      j ↑   │ + + + + + + +
//!            └─ i → ───────
//! ```

use crate::geometry::bspline::{BSplineSurface, Knots};
use crate::numeric::sparse::{Matrix, Plan};
use glam::{DVec2, DVec3};

/// Weight of a second difference, for a strong point of weight 1: small, because it is to decide only where no points
/// do.
const SMOOTH_WEIGHT: f64 = 1e-6;
/// A count: control points of a direction that share a span with a given one on each side, three because splines are
/// cubic.
const SHARED_SPANS: usize = 3;
/// A count: pairs that a control point has with itself and those after it, in its own row and in the next ones.
const CONTROL_PAIRS: usize = (SHARED_SPANS + 1) + SHARED_SPANS * (2 * SHARED_SPANS + 1);

/// A point of the fit with its parameters and weight.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    /// Its parameters.
    pub uv: DVec2,
    /// Its place.
    pub point: DVec3,
    /// Its weight in the sum of squares.
    pub weight: f64,
}

/// The knots of both directions.
pub struct Grid {
    u: Knots,
    v: Knots,
    plan: Option<Plan>,
}

/// Normal equations, by control point.
struct Equations {
    /// Number of control points in the direction of u.
    m: usize,
    pairs: Vec<[f64; CONTROL_PAIRS]>,
    rhs: [Vec<f64>; 3],
}

impl Equations {
    /// Adds the square of Σ terms − value; terms by their places (i, j), none more than [`SHARED_SPANS`] from another.
    fn add(&mut self, terms: &[([usize; 2], f64)], weight: f64, value: DVec3) {
        for &([i, j], a) in terms {
            let own = j * self.m + i;
            (0..3).for_each(|k| self.rhs[k][own] += weight * a * value[k]);
            for &([p, q], b) in terms.iter().filter(|t| (t.0[1], t.0[0]) >= (j, i)) {
                let slot = if q == j { p - i } else { (q - j) * (2 * SHARED_SPANS + 1) + p - i };
                self.pairs[own][slot] += weight * a * b;
            }
        }
    }
}

impl Grid {
    /// Even spans over a rectangle.
    pub fn new(low: DVec2, size: DVec2, spans: [usize; 2]) -> Option<Self> {
        let knots = |k: usize| {
            let at = |j: usize| low[k] + size[k] * j as f64 / spans[k] as f64;
            Knots::from_breaks(3, &(0..=spans[k]).map(at).collect::<Vec<f64>>(), 1).ok()
        };
        Some(Grid { u: knots(0)?, v: knots(1)?, plan: None })
    }

    /// Number of control points.
    pub fn count(&self) -> usize {
        self.u.count() * self.v.count()
    }

    /// The surface with the least sum of squares.
    pub fn fit(&mut self, samples: impl Iterator<Item = Sample> + Clone) -> Option<BSplineSurface> {
        let [m, n] = [self.u.count(), self.v.count()];
        let (sum, count) = samples.clone().fold((DVec3::ZERO, 0.0), |(s, c), x| (s + x.point, c + 1.0));
        let middle = sum / f64::max(count, 1.0);
        let rhs = [vec![0.0; m * n], vec![0.0; m * n], vec![0.0; m * n]];
        let mut equations = Equations { m, pairs: vec![[0.0; CONTROL_PAIRS]; m * n], rhs };
        for s in samples {
            let ((i, a), (j, b)) = (self.u.basis(s.uv.x), self.v.basis(s.uv.y));
            let terms: [([usize; 2], f64); 16] = std::array::from_fn(|k| ([i + k % 4, j + k / 4], a[k % 4] * b[k / 4]));
            equations.add(&terms, s.weight, s.point - middle);
        }
        smooth(&mut equations, n);
        let mut matrix = Matrix::new(m * n);
        for own in 0..m * n {
            let (i, j) = (own % m, own / m);
            for (slot, &value) in equations.pairs[own].iter().enumerate() {
                let (q, p) = if slot <= SHARED_SPANS {
                    (j, i + slot)
                } else {
                    let back = slot + SHARED_SPANS;
                    let (down, right) = (back / (2 * SHARED_SPANS + 1), back % (2 * SHARED_SPANS + 1));
                    if i + right < SHARED_SPANS {
                        continue;
                    }
                    (j + down, i + right - SHARED_SPANS)
                };
                if p < m && q < n {
                    matrix.add((q * m + p) as u32, own as u32, value);
                }
            }
        }
        let factor = matrix.factor(&mut self.plan).ok()?;
        let [x, y, z] = [0, 1, 2].map(|k| factor.solve(&equations.rhs[k]).ok());
        let (x, y, z) = (x?, y?, z?);
        let points = (0..m * n).map(|k| middle + DVec3::new(x[k], y[k], z[k])).collect();
        BSplineSurface::new(self.u.clone(), self.v.clone(), points).ok()
    }
}

/// Adds the penalty.
fn smooth(equations: &mut Equations, n: usize) {
    let m = equations.m;
    for (i, j) in (0..n).flat_map(|j| (0..m).map(move |i| (i, j))) {
        if i + 2 < m {
            equations.add(&[([i, j], 1.0), ([i + 1, j], -2.0), ([i + 2, j], 1.0)], SMOOTH_WEIGHT, DVec3::ZERO);
        }
        if j + 2 < n {
            equations.add(&[([i, j], 1.0), ([i, j + 1], -2.0), ([i, j + 2], 1.0)], SMOOTH_WEIGHT, DVec3::ZERO);
        }
        if i + 1 < m && j + 1 < n {
            let twist = [([i, j], 1.0), ([i + 1, j], -1.0), ([i, j + 1], -1.0), ([i + 1, j + 1], 1.0)];
            equations.add(&twist, 2.0 * SMOOTH_WEIGHT, DVec3::ZERO);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cubics are in the space of the surfaces, and their second differences are small.
    #[test]
    fn a_cubic_is_found_again() {
        let of = |p: DVec2| DVec3::new(p.x, p.y, 0.3 * p.x * p.x * p.y - 0.2 * p.y * p.y * p.y);
        let places = (0..400).map(|k| DVec2::new(f64::from(k % 20), f64::from(k / 20)) / 19.0);
        let samples = places.clone().map(|uv| Sample { uv, point: of(uv), weight: 1.0 });
        let mut grid = Grid::new(DVec2::ZERO, DVec2::ONE, [3, 5]).unwrap();
        assert_eq!(grid.count(), 6 * 8);
        for _ in 0..2 {
            let surface = grid.fit(samples.clone()).unwrap();
            for uv in places.clone() {
                assert!(surface.point(uv.x, uv.y).distance(of(uv)) < 1e-5, "{uv}");
            }
        }
    }
}
