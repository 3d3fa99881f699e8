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
//!
//! Cells are taken four at a time, with the processor's vector instructions.

use super::simd::{LANES, Numbers, Vectors};
use crate::geometry::hexes::{Corners, along_axes as change_rows, determinants};
use crate::mesh::HEX_EDGES;
use faer::traits::pulp::{Arch, Simd, WithSimd};
use glam::DVec3;

/// Weight θ of the volume term against the shape term.
const THETA: f64 = 1.0 / 128.0;
/// Regularised determinants below this count as zero.
const LEAST_CHI: f64 = 1e-280;
/// Four thirds of the upper bits of one, less what makes the guess of [`inverse_cube_root`] best.
const GUESS: u64 = 0x553e_f1a9;

/// Weights of the two ends of an edge grid at the three places of an axis.
const AT: [[f64; 2]; 3] = [[1.0, 0.0], [0.5, 0.5], [0.0, 1.0]];

/// Of each of the 27 points, its place in the grids of the derivatives along the three axes, 3 × 3 each.
const PLACES: [[usize; 3]; 27] = {
    let mut places = [[0; 3]; 27];
    let mut n = 0;
    while n < 27 {
        let (i, j, k) = (n / 9, n / 3 % 3, n % 3);
        places[n] = [3 * j + k, 3 * i + k, 3 * i + j];
        n += 1;
    }
    places
};

/// Energy of one cell, its gradient at the corners, and the least of the 27 coefficients.
#[derive(Clone, Copy)]
pub struct CellEnergy {
    /// Mean of φᵖ; infinite where ε is zero and a coefficient is not positive.
    pub value: f64,
    /// By the positions of the corners; of no meaning where the value is infinite.
    pub gradient: [DVec3; 8],
    /// Over the target volume.
    pub least: f64,
}

impl CellEnergy {
    pub const ZERO: CellEnergy = CellEnergy { value: 0.0, gradient: [DVec3::ZERO; 8], least: f64::INFINITY };
}

/// The energies of cells, into `out`. `cell` gives the corners of each, and one over the target lengths of its axes.
pub fn energies(cell: impl Fn(usize) -> (Corners, [f64; 3]), epsilon: f64, power: i32, out: &mut [CellEnergy]) {
    Arch::new().dispatch(Energies { cell, epsilon, power, out });
}

/// What [`energies`] does, in terms of the vector instructions at hand.
struct Energies<'a, F> {
    cell: F,
    epsilon: f64,
    power: i32,
    out: &'a mut [CellEnergy],
}

impl<F: Fn(usize) -> (Corners, [f64; 3])> WithSimd for Energies<'_, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let last = self.out.len().saturating_sub(1);
        for start in (0..self.out.len()).step_by(LANES) {
            let (mut corners, mut inverse) = ([Vectors::ZERO; 8], [Numbers::all(1.0); 3]);
            for lane in 0..LANES {
                let (p, one_over) = (self.cell)((start + lane).min(last));
                for k in 0..8 {
                    corners[k].set(lane, p[k]);
                }
                for axis in 0..3 {
                    inverse[axis].0[lane] = one_over[axis];
                }
            }
            let (value, gradient, least) = four_energies(&corners, inverse, self.epsilon, self.power);
            for (lane, out) in self.out[start..].iter_mut().take(LANES).enumerate() {
                (out.value, out.least) = (value.0[lane], least.0[lane]);
                for k in 0..8 {
                    out.gradient[k] = gradient[k].get(lane);
                }
            }
        }
    }
}

/// The least of the 27 coefficients of a cell, over the target volume.
pub fn least_bound(p: &Corners, inverse: [f64; 3]) -> f64 {
    let mut bounds = determinants(p);
    change_rows(&mut bounds, |[a, b, d]| [a, 2.0 * b - 0.5 * (a + d), d]);
    let volume: f64 = inverse.iter().product();
    bounds.iter().fold(f64::INFINITY, |least, d| least.min(d * volume))
}

/// Values, gradients and least coefficients of four cells.
#[inline(always)]
fn four_energies(
    p: &[Vectors; 8],
    inverse: [Numbers; 3],
    epsilon: f64,
    power: i32,
) -> (Numbers, [Vectors; 8], Numbers) {
    let columns = derivatives(p, inverse);
    let mut squares = [[Numbers::all(0.0); 9]; 3];
    for axis in 0..3 {
        for k in 0..9 {
            squares[axis][k] = columns[axis][k].dot(columns[axis][k]);
        }
    }
    let mut bounds = [Numbers::all(0.0); 27];
    for n in 0..27 {
        let [a, b, c] = PLACES[n];
        bounds[n] = columns[0][a].dot(columns[1][b].cross(columns[2][c]));
    }
    along_axes(&mut bounds, |[a, b, d]| [a, b * 2.0 - (a + d) * 0.5, d]);
    // Slopes by the derivatives are these times the derivatives, and what comes from the coefficients.
    let mut stretch = [[Numbers::all(0.0); 9]; 3];
    let mut by_bound = [Numbers::all(0.0); 27];
    let (mut value, mut least) = (Numbers::all(0.0), Numbers::all(f64::INFINITY));
    for n in 0..27 {
        let (d, at) = (bounds[n], PLACES[n]);
        least = least.with(d, |a, b| if b < a { b } else { a });
        let (chi, over_chi, over_root) = regularised(d, epsilon);
        let third = inverse_cube_root(chi);
        let shape = third * third * ((1.0 - THETA) / 3.0);
        let shaped = shape * (squares[0][at[0]] + squares[1][at[1]] + squares[2][at[2]]);
        let volume = (d * d + Numbers::all(1.0)) * over_chi * (0.5 * THETA);
        let (energy, factor) = raise(shaped + volume, power);
        value = value + energy.with(chi, |e, chi| if chi > LEAST_CHI { e } else { f64::INFINITY });
        // dχ/dD = χ / √(ε² + D²).
        by_bound[n] = factor * ((shaped * (-2.0 / 3.0) - volume) * over_root + d * over_chi * THETA);
        for axis in 0..3 {
            stretch[axis][at[axis]] = stretch[axis][at[axis]] + shape * factor * 2.0;
        }
    }
    // From the slopes by the coefficients to those by the values: the transpose of the change above.
    along_axes(&mut by_bound, |[a, b, d]| [a - b * 0.5, b * 2.0, d - b * 0.5]);
    let mut slopes = [[Vectors::ZERO; 9]; 3];
    for axis in 0..3 {
        for k in 0..9 {
            slopes[axis][k] = columns[axis][k] * stretch[axis][k];
        }
    }
    for n in 0..27 {
        let (at, slope) = (PLACES[n], by_bound[n]);
        let [a, b, c] = [columns[0][at[0]], columns[1][at[1]], columns[2][at[2]]];
        slopes[0][at[0]] = slopes[0][at[0]] + b.cross(c) * slope;
        slopes[1][at[1]] = slopes[1][at[1]] + c.cross(a) * slope;
        slopes[2][at[2]] = slopes[2][at[2]] + a.cross(b) * slope;
    }
    (value * (1.0 / 27.0), to_corners(&slopes, inverse), least)
}

/// The derivatives along the three axes over the target lengths: bilinear between the four edges of each axis.
#[inline(always)]
fn derivatives(p: &[Vectors; 8], inverse: [Numbers; 3]) -> [[Vectors; 9]; 3] {
    let mut columns = [[Vectors::ZERO; 9]; 3];
    for axis in 0..3 {
        let mut e = [Vectors::ZERO; 4];
        for k in 0..4 {
            let [a, b] = HEX_EDGES[4 * axis + k];
            e[k] = (p[b] - p[a]) * inverse[axis];
        }
        let (low, high) = ([e[0], (e[0] + e[1]) * 0.5, e[1]], [e[2], (e[2] + e[3]) * 0.5, e[3]]);
        for s in 0..3 {
            columns[axis][3 * s] = low[s];
            columns[axis][3 * s + 1] = (low[s] + high[s]) * 0.5;
            columns[axis][3 * s + 2] = high[s];
        }
    }
    columns
}

/// The gradient by the corners of a mean over the 27 points, from the slopes by the derivatives there.
#[inline(always)]
fn to_corners(slopes: &[[Vectors; 9]; 3], inverse: [Numbers; 3]) -> [Vectors; 8] {
    let mut gradient = [Vectors::ZERO; 8];
    for axis in 0..3 {
        for k in 0..4 {
            let mut e = Vectors::ZERO;
            for s in 0..3 {
                for t in 0..3 {
                    e = e + slopes[axis][3 * s + t] * (AT[s][k % 2] * AT[t][k / 2]);
                }
            }
            let [a, b] = HEX_EDGES[4 * axis + k];
            let pull = e * (inverse[axis] * (1.0 / 27.0));
            gradient[b] = gradient[b] + pull;
            gradient[a] = gradient[a] - pull;
        }
    }
    gradient
}

/// The regularised determinant χ, one over it, and one over √(ε² + D²).
#[inline(always)]
fn regularised(d: Numbers, epsilon: f64) -> (Numbers, Numbers, Numbers) {
    if epsilon == 0.0 {
        let over = d.map(|d| 1.0 / d);
        return (d, over, over);
    }
    let root = d.map(|d| (epsilon * epsilon + d * d).sqrt());
    let chi = d.with(root, |d, root| {
        let (above, below) = (0.5 * (d + root), 0.5 * epsilon * epsilon / (root - d));
        if d > 0.0 { above } else { below }
    });
    (chi, chi.map(|chi| 1.0 / chi), root.map(|root| 1.0 / root))
}

/// x to the power −⅓, of positive normal numbers: a guess from the exponent, 4 % off at most, and two steps that raise
/// the error to its fourth power. Several times faster than the standard library's cube root, which rounds correctly.
#[inline(always)]
fn inverse_cube_root(x: Numbers) -> Numbers {
    // A third of a 32-bit number is its product with two thirds of 2³².
    let third = |bits: u64| (bits * 0xaaaa_aaab) >> 33;
    let mut y = x.map(|x| f64::from_bits(GUESS.wrapping_sub(third(x.to_bits() >> 32)) << 32));
    for _ in 0..2 {
        // With e = 1 − x y³, x^(−⅓) = y (1 − e)^(−⅓).
        let e = Numbers::all(1.0) - x * (y * y * y);
        let series = e * (e * (14.0 / 81.0) + Numbers::all(2.0 / 9.0)) + Numbers::all(1.0 / 3.0);
        y = y + y * e * series;
    }
    y
}

/// φᵖ and its derivative.
#[inline(always)]
fn raise(phi: Numbers, power: i32) -> (Numbers, Numbers) {
    let mut less = Numbers::all(1.0);
    let (mut square, mut left) = (phi, power - 1);
    while left > 0 {
        if left & 1 == 1 {
            less = less * square;
        }
        square = square * square;
        left >>= 1;
    }
    (less * phi, less * f64::from(power))
}

/// Changes every row of three numbers along each axis in turn.
#[inline(always)]
fn along_axes(c: &mut [Numbers; 27], change: impl Fn([Numbers; 3]) -> [Numbers; 3]) {
    for step in [9, 3, 1] {
        for row in 0..9 {
            let start = row % step + row / step * 3 * step;
            let changed = change([c[start], c[start + step], c[start + 2 * step]]);
            for k in 0..3 {
                c[start + k * step] = changed[k];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::slopes::{is_slope, unit_cube};
    use super::*;
    use proptest::prelude::*;

    fn cell_energy(p: &Corners, inverse: [f64; 3], epsilon: f64, power: i32) -> CellEnergy {
        let mut out = [CellEnergy::ZERO];
        energies(|_| (*p, inverse), epsilon, power, &mut out);
        out[0]
    }

    proptest! {
        #[test]
        fn the_gradient_is_the_slope(
            moves in prop::collection::vec(-0.6f64..0.6, 24), epsilon in 0.2f64..1.0, power in 1i32..5,
        ) {
            is_slope(&moves, |p| {
                let e = cell_energy(p, [1.0, 0.7, 1.4], epsilon, power);
                (e.value, e.gradient)
            })?;
        }
    }

    #[test]
    fn the_cube_root_is_as_good_as_the_standard_one() {
        for k in -2800..2800 {
            let x = 10f64.powf(0.1 * f64::from(k) + 0.013);
            let off = inverse_cube_root(Numbers::all(x)).0[0] * x.cbrt() - 1.0;
            assert!(off.abs() < 2e-15, "{x:e} {off:e}");
        }
    }

    #[test]
    fn a_cell_has_the_same_energy_beside_any_others() {
        let cell = |k: usize| {
            let moved = |c: DVec3| c.map(|x| x + 0.2 * (k as f64 + x).sin());
            (unit_cube().map(moved), [1.0, 0.8, 1.1])
        };
        let mut together = [CellEnergy::ZERO; 7];
        energies(cell, 0.0, 4, &mut together);
        for (k, e) in together.iter().enumerate() {
            let (p, inverse) = cell(k);
            let alone = cell_energy(&p, inverse, 0.0, 4);
            assert!((e.value, e.least, e.gradient) == (alone.value, alone.least, alone.gradient));
            assert!((least_bound(&p, inverse) - e.least).abs() < 1e-14);
        }
        energies(cell, 0.0, 4, &mut []);
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
