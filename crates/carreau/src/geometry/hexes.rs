//! Shape of hexahedra: scaled Jacobian, volume, and the proof that a cell is not folded anywhere.
//!
//! The trilinear map of a cell has a Jacobian determinant that is quadratic in each parameter. Its 27 Bernstein
//! coefficients bound it: all positive, and it is positive in the whole cell (Johnen, Weill, Remacle, "Robust and
//! efficient validation of the linear hexahedral element", IMR 2017). Where they are not, the cell is halved along its
//! three axes and each part looked at again.

use crate::mesh::HEX_EDGES;
use glam::DVec3;
use rayon::prelude::*;

/// The corners of a cell.
pub type Corners = [DVec3; 8];

/// Every corner's neighbours along the three axes, in the order that gives a cube the value +1.
pub const CORNERS: [[usize; 3]; 8] =
    [[1, 3, 4], [2, 0, 5], [3, 1, 6], [0, 2, 7], [7, 5, 0], [4, 6, 1], [5, 7, 2], [6, 4, 3]];
/// A determinant counts as positive above this share of the cubed longest edge.
const LEAST_DETERMINANT: f64 = 1e-12;
/// Levels of halving.
const HALVINGS: usize = 6;

/// Smallest scaled Jacobian of the eight corners.
pub fn scaled_jacobian(p: &Corners) -> f64 {
    let at = |c: usize| {
        let [a, b, d] = CORNERS[c].map(|n| p[n] - p[c]);
        let size = a.length() * b.length() * d.length();
        if size > 0.0 { a.dot(b.cross(d)) / size } else { 0.0 }
    };
    (0..8).map(at).fold(f64::INFINITY, f64::min)
}

/// Values of the Jacobian determinant at 3 × 3 × 3 points: corners, middles of edges and faces, centre; index
/// `9 i + 3 j + k` at the parameters (i, j, k) / 2.
pub fn determinants(p: &Corners) -> [f64; 27] {
    let e = HEX_EDGES.map(|[a, b]| p[b] - p[a]);
    // Derivatives are bilinear in the two other parameters: rows along the first of them.
    let grid = |q: &[DVec3]| -> [DVec3; 9] {
        std::array::from_fn(|k| {
            let (s, t) = ((k / 3) as f64 / 2.0, (k % 3) as f64 / 2.0);
            (q[0] * (1.0 - s) + q[1] * s) * (1.0 - t) + (q[2] * (1.0 - s) + q[3] * s) * t
        })
    };
    let (u, v, w) = (grid(&e[0..4]), grid(&e[4..8]), grid(&e[8..12]));
    std::array::from_fn(|n| {
        let (i, j, k) = (n / 9, n / 3 % 3, n % 3);
        u[3 * j + k].dot(v[3 * i + k].cross(w[3 * i + j]))
    })
}

/// Exact volume: Simpson's rule integrates the quadratic determinant exactly.
pub fn volume(p: &Corners) -> f64 {
    const RULE: [f64; 3] = [1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0];
    determinants(p).iter().enumerate().map(|(n, d)| d * RULE[n / 9] * RULE[n / 3 % 3] * RULE[n % 3]).sum()
}

/// Whether the Jacobian determinant is proven positive in the whole cell.
pub fn is_certified(p: &Corners) -> bool {
    let longest = HEX_EDGES.iter().map(|&[a, b]| p[a].distance(p[b])).fold(0.0, f64::max);
    let mut c = determinants(p);
    along_axes(&mut c, |[a, b, d]| [a, 2.0 * b - 0.5 * (a + d), d]);
    positive(&c, LEAST_DETERMINANT * longest.powi(3), HALVINGS)
}

/// The cells of a mesh without that proof.
pub fn uncertified(points: &[DVec3], hexes: &[[u32; 8]]) -> Vec<u32> {
    let is_open = |h: &u32| !is_certified(&hexes[*h as usize].map(|v| points[v as usize]));
    (0..hexes.len() as u32).into_par_iter().filter(is_open).collect()
}

fn positive(c: &[f64; 27], tiny: f64, depth: usize) -> bool {
    if c.iter().all(|&x| x > tiny) {
        return true;
    }
    // The coefficients at the corners are values: no halving can help there.
    let corners = [0, 2, 6, 8, 18, 20, 24, 26];
    if depth == 0 || corners.iter().any(|&k| !(c[k] > tiny)) {
        return false;
    }
    (0..8).all(|part| positive(&half(c, part), tiny, depth - 1))
}

/// The coefficients over one of the eight parts of the cell (de Casteljau).
fn half(c: &[f64; 27], part: usize) -> [f64; 27] {
    let mut out = *c;
    let lower = |[a, b, d]: [f64; 3]| [a, 0.5 * (a + b), 0.25 * (a + 2.0 * b + d)];
    let upper = |[a, b, d]: [f64; 3]| [0.25 * (a + 2.0 * b + d), 0.5 * (b + d), d];
    for axis in 0..3 {
        let is_upper = part >> axis & 1 == 1;
        along_axis(&mut out, axis, |row| if is_upper { upper(row) } else { lower(row) });
    }
    out
}

/// Changes every row of three values along each axis in turn.
pub(crate) fn along_axes(c: &mut [f64; 27], change: impl Fn([f64; 3]) -> [f64; 3]) {
    (0..3).for_each(|axis| along_axis(c, axis, &change));
}

fn along_axis(c: &mut [f64; 27], axis: usize, change: impl Fn([f64; 3]) -> [f64; 3]) {
    let step = [9, 3, 1][axis];
    for start in (0..27).filter(|k| k / step % 3 == 0) {
        let row = change([c[start], c[start + step], c[start + 2 * step]]);
        (0..3).for_each(|k| c[start + k * step] = row[k]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn cube() -> Corners {
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
            .map(|c| DVec3::from(c.map(f64::from)))
    }

    /// The trilinear map's determinant, straight from its definition.
    fn jacobian(p: &Corners, t: DVec3) -> f64 {
        let derivative = |axis: usize| {
            cube().iter().zip(p).fold(DVec3::ZERO, |sum, (c, q)| {
                let factor = |k: usize| match (k == axis, c[k] > 0.5) {
                    (true, up) => {
                        if up {
                            1.0
                        } else {
                            -1.0
                        }
                    }
                    (false, up) => {
                        if up {
                            t[k]
                        } else {
                            1.0 - t[k]
                        }
                    }
                };
                sum + *q * (factor(0) * factor(1) * factor(2))
            })
        };
        derivative(0).dot(derivative(1).cross(derivative(2)))
    }

    proptest! {
        #[test]
        fn the_certificate_is_sound_and_sharp(moves in prop::collection::vec(-0.45f64..0.45, 24)) {
            let mut p = cube();
            p.iter_mut().enumerate().for_each(|(k, q)| *q += DVec3::from_slice(&moves[3 * k..3 * k + 3]));
            let samples: Vec<f64> = (0..1331)
                .map(|n| jacobian(&p, DVec3::new(f64::from(n / 121), f64::from(n / 11 % 11), f64::from(n % 11)) / 10.0))
                .collect();
            let least = samples.iter().copied().fold(f64::INFINITY, f64::min);
            let certified = is_certified(&p);
            prop_assert!(!certified || least > 0.0, "certified with {}", least);
            prop_assert!(certified || least < 0.02, "not certified with {}", least);
            let d = determinants(&p);
            prop_assert!((d[13] - jacobian(&p, DVec3::splat(0.5))).abs() < 1e-12);
            prop_assert!((d[9 * 2 + 3] - jacobian(&p, DVec3::new(1.0, 0.5, 0.0))).abs() < 1e-12);
            let mean = samples.iter().sum::<f64>() / samples.len() as f64;
            prop_assert!((volume(&p) - mean).abs() < 0.1);
        }
    }

    #[test]
    fn a_cube_and_its_mirror() {
        let p = cube();
        assert!((scaled_jacobian(&p) - 1.0).abs() < 1e-15 && (volume(&p) - 1.0).abs() < 1e-15 && is_certified(&p));
        let mirrored = p.map(|q| DVec3::new(-q.x, q.y, q.z));
        assert!(
            scaled_jacobian(&mirrored) < 0.0 && !is_certified(&mirrored) && (volume(&mirrored) + 1.0).abs() < 1e-15
        );
    }

    /// A cell whose upper face is turned by half and stretched has positive corners and a folded centre: the maps of both
    /// faces have positive determinants, that of their mean has not.
    #[test]
    fn positive_corners_prove_nothing() {
        let mut p = cube().map(|q| q - DVec3::new(0.5, 0.5, 0.0));
        p[4..].iter_mut().for_each(|q| *q = DVec3::new(-3.0 * q.x, -0.2 * q.y, q.z));
        let d = determinants(&p);
        assert!([0, 2, 6, 8, 18, 20, 24, 26].iter().all(|&k| d[k] > 0.5) && d[13] < -0.3, "{d:?}");
        assert!(scaled_jacobian(&p) > 0.0 && !is_certified(&p));
    }
}
