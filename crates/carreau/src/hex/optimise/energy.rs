//! The energy of a cell (Garanzha, Kaporin, Kudryavtseva, Protais, Ray, Sokolov, "Foldover-free maps in 50 lines of
//! code", TOG 2021), at 27 points instead of one Jacobian per simplex.
//!
//! With J the Jacobian of the trilinear map over the target lengths of the three axes, D = det J and the regularised
//! determinant χ = (D + √(ε² + D²)) / 2:
//!
//! f = tr(JᵀJ) / χ^⅔ (shape), g = (D² + 1) / χ (volume), φ = (1 − θ) f / 3 + θ g / 2, θ = 1/128, E = mean of φᵖ.
//!
//! φ is 1 for the target and grows without limit as the cell folds. At corners alone the energy does not see cells that
//! are twisted with positive corners, hence the middles of edges and faces and the centre. Between 27 positive values a
//! long twisted cell may still fold: D stands for the Bernstein coefficients of the determinant, which are its values at the
//! corners and bound it from below everywhere. A power p above 1 makes the worst places count more.

use crate::geometry::hexes::along_axes;
use crate::mesh::HEX_EDGES;
use glam::DVec3;

const THETA: f64 = 1.0 / 128.0;
/// Regularised determinants below this count as zero.
const LEAST_CHI: f64 = 1e-280;
/// Four thirds of the bits of one, less what makes the guess of [`inverse_cube_root`] best.
const GUESS: u64 = 0x553e_f1a9_fbe7_6c8c;

/// Weights of the two ends of an edge grid at the three places of an axis.
const AT: [[f64; 2]; 3] = [[1.0, 0.0], [0.5, 0.5], [0.0, 1.0]];

/// Energy of one cell, its gradient at the corners, and the least of the 27 coefficients.
pub struct CellEnergy {
    /// Mean of φᵖ; infinite where ε is zero and a coefficient is not positive.
    pub value: f64,
    /// By the positions of the corners.
    pub gradient: [DVec3; 8],
    /// Over the target volume.
    pub least: f64,
}

/// The energy of a cell. `inverse` are one over the target lengths of the axes.
pub fn cell_energy(p: &[DVec3; 8], inverse: [f64; 3], epsilon: f64, power: i32) -> CellEnergy {
    let mut columns = [[DVec3::ZERO; 9]; 3];
    for (axis, column) in columns.iter_mut().enumerate() {
        let e: [DVec3; 4] = std::array::from_fn(|k| {
            let [a, b] = HEX_EDGES[4 * axis + k];
            (p[b] - p[a]) * inverse[axis]
        });
        let (low, high) = ([e[0], 0.5 * (e[0] + e[1]), e[1]], [e[2], 0.5 * (e[2] + e[3]), e[3]]);
        for s in 0..3 {
            column[3 * s] = low[s];
            column[3 * s + 1] = 0.5 * (low[s] + high[s]);
            column[3 * s + 2] = high[s];
        }
    }
    let place = |n: usize| {
        let (i, j, k) = (n / 9, n / 3 % 3, n % 3);
        [3 * j + k, 3 * i + k, 3 * i + j]
    };
    let vectors = |n: usize| {
        let at = place(n);
        [columns[0][at[0]], columns[1][at[1]], columns[2][at[2]]]
    };
    let mut bounds: [f64; 27] = std::array::from_fn(|n| {
        let [a, b, c] = vectors(n);
        a.dot(b.cross(c))
    });
    along_axes(&mut bounds, |[a, b, d]| [a, 2.0 * b - 0.5 * (a + d), d]);
    let mut slopes = [[DVec3::ZERO; 9]; 3];
    let mut by_bound = [0.0; 27];
    let (mut value, mut least) = (0.0, f64::INFINITY);
    for (n, &d) in bounds.iter().enumerate() {
        least = least.min(d);
        let root = (epsilon * epsilon + d * d).sqrt();
        let chi = if d > 0.0 { 0.5 * (d + root) } else { 0.5 * epsilon * epsilon / (root - d) };
        if !(chi > LEAST_CHI) {
            value = f64::INFINITY;
            continue;
        }
        let [a, b, c] = vectors(n);
        let trace = a.length_squared() + b.length_squared() + c.length_squared();
        let third = inverse_cube_root(chi);
        let shape = (1.0 - THETA) / 3.0 * (third * third);
        let volume = 0.5 * THETA * (d * d + 1.0) / chi;
        let phi = shape * trace + volume;
        let (energy, factor) = raise(phi, power);
        value += energy;
        // dχ/dD = χ / √(ε² + D²).
        by_bound[n] = factor * ((-2.0 / 3.0 * shape * trace - volume) / root + THETA * d / chi);
        let at = place(n);
        for (axis, vector) in [a, b, c].into_iter().enumerate() {
            slopes[axis][at[axis]] += vector * (2.0 * shape * factor);
        }
    }
    // From the slopes by the coefficients to those by the values: the transpose of the change above.
    along_axes(&mut by_bound, |[a, b, d]| [a - 0.5 * b, 2.0 * b, d - 0.5 * b]);
    for (n, &slope) in by_bound.iter().enumerate() {
        let (at, [a, b, c]) = (place(n), vectors(n));
        slopes[0][at[0]] += b.cross(c) * slope;
        slopes[1][at[1]] += c.cross(a) * slope;
        slopes[2][at[2]] += a.cross(b) * slope;
    }
    let mut gradient = [DVec3::ZERO; 8];
    for axis in 0..3 {
        let mut e = [DVec3::ZERO; 4];
        for s in 0..3 {
            for t in 0..3 {
                let slope = slopes[axis][3 * s + t];
                for k in 0..4 {
                    e[k] += slope * (AT[s][k % 2] * AT[t][k / 2]);
                }
            }
        }
        for k in 0..4 {
            let [a, b] = HEX_EDGES[4 * axis + k];
            let pull = e[k] * (inverse[axis] / 27.0);
            gradient[b] += pull;
            gradient[a] -= pull;
        }
    }
    CellEnergy { value: value / 27.0, gradient, least }
}

/// x to the power −⅓, of a positive normal number: a guess from the exponent, 4 % off at most, and two steps that raise
/// the error to its fourth power. Several times faster than the standard library's cube root, which rounds correctly.
fn inverse_cube_root(x: f64) -> f64 {
    let mut y = f64::from_bits(GUESS - x.to_bits() / 3);
    for _ in 0..2 {
        // With e = 1 − x y³, x^(−⅓) = y (1 − e)^(−⅓).
        let e = 1.0 - x * (y * y * y);
        y += y * e * (1.0 / 3.0 + e * (2.0 / 9.0 + e * (14.0 / 81.0)));
    }
    y
}

/// φᵖ and its derivative.
fn raise(phi: f64, power: i32) -> (f64, f64) {
    let less = phi.powi(power - 1);
    (less * phi, f64::from(power) * less)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_gradient_is_the_slope(
            moves in prop::collection::vec(-0.6f64..0.6, 24), epsilon in 0.2f64..1.0, power in 1i32..5,
        ) {
            let unit = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];
            let mut p = unit.map(|c: [i32; 3]| DVec3::from(c.map(f64::from)));
            p.iter_mut().enumerate().for_each(|(k, q)| *q += DVec3::from_slice(&moves[3 * k..3 * k + 3]));
            let inverse = [1.0, 0.7, 1.4];
            let here = cell_energy(&p, inverse, epsilon, power);
            let step = 1e-6;
            for corner in 0..8 {
                for axis in 0..3 {
                    let value = |by: f64| {
                        let mut q = p;
                        q[corner][axis] += by;
                        cell_energy(&q, inverse, epsilon, power).value
                    };
                    let slope = (value(step) - value(-step)) / (2.0 * step);
                    let given = here.gradient[corner][axis];
                    prop_assert!((slope - given).abs() < 1e-5 * (1.0 + here.value + slope.abs()), "{} {}", slope, given);
                }
            }
        }
    }

    #[test]
    fn the_cube_root_is_as_good_as_the_standard_one() {
        for k in -2800..2800 {
            let x = 10f64.powf(0.1 * f64::from(k) + 0.013);
            let off = inverse_cube_root(x) * x.cbrt() - 1.0;
            assert!(off.abs() < 2e-15, "{x:e} {off:e}");
        }
    }

    #[test]
    fn the_target_has_energy_one_and_no_slope() {
        let box3 = [[0, 0, 0], [2, 0, 0], [2, 3, 0], [0, 3, 0], [0, 0, 5], [2, 0, 5], [2, 3, 5], [0, 3, 5]];
        let p = box3.map(|c: [i32; 3]| DVec3::from(c.map(f64::from)));
        let e = cell_energy(&p, [0.5, 1.0 / 3.0, 0.2], 0.0, 3);
        assert!((e.value - 1.0).abs() < 1e-14 && (e.least - 1.0).abs() < 1e-14);
        assert!(e.gradient.iter().all(|g| g.length() < 1e-14));
    }
}
