//! The proof that a hexahedron of second order is folded nowhere.
//!
//! The map of a cell with 27 nodes is quadratic in each parameter, its Jacobian determinant is of degree 5 in each. In the Bernstein
//! basis the derivatives of the map are differences of its coefficients, and products of polynomials are sums of products of
//! coefficients with binomial weights (Johnen, Remacle, Geuzaine, "Geometrical validity of curvilinear finite elements",
//! Journal of Computational Physics 2013). Where all 216 coefficients are positive so is the determinant; where they are not,
//! the cell is halved along its three axes and each part looked at again.

use glam::DVec3;

/// The nodes of a cell in the order of VTK's triquadratic hexahedron.
pub type Nodes = [DVec3; 27];

/// Where the nodes are: in a lattice of 3 × 3 × 3.
pub const LATTICE: [[usize; 3]; 27] = [
    [0, 0, 0],
    [2, 0, 0],
    [2, 2, 0],
    [0, 2, 0],
    [0, 0, 2],
    [2, 0, 2],
    [2, 2, 2],
    [0, 2, 2], // corners
    [1, 0, 0],
    [2, 1, 0],
    [1, 2, 0],
    [0, 1, 0],
    [1, 0, 2],
    [2, 1, 2],
    [1, 2, 2],
    [0, 1, 2], // edges
    [0, 0, 1],
    [2, 0, 1],
    [2, 2, 1],
    [0, 2, 1], // edges along the third axis
    [0, 1, 1],
    [2, 1, 1],
    [1, 0, 1],
    [1, 2, 1],
    [1, 1, 0],
    [1, 1, 2], // faces
    [1, 1, 1],
];
/// A determinant counts as positive above this share of the cubed extent.
const LEAST_COEFFICIENT: f64 = 1e-12;
/// Levels of halving.
const CURVED_HALVINGS: usize = 3;
/// Coefficients of the determinant along an axis.
const N: usize = 6;

/// Coefficients of a polynomial in three variables in the Bernstein basis, the third one fastest.
#[derive(Clone)]
struct Bernstein<T> {
    degrees: [usize; 3],
    coefficients: Vec<T>,
}

impl<T: Copy> Bernstein<T> {
    fn from_fn(degrees: [usize; 3], f: impl Fn([usize; 3]) -> T) -> Self {
        let [a, b, c] = degrees.map(|d| d + 1);
        let coefficients = (0..a * b * c).map(|n| f([n / (b * c), n / c % b, n % c])).collect();
        Bernstein { degrees, coefficients }
    }

    fn places(&self) -> impl Iterator<Item = ([usize; 3], T)> + '_ {
        let [_, b, c] = self.degrees.map(|d| d + 1);
        self.coefficients.iter().enumerate().map(move |(n, &value)| ([n / (b * c), n / c % b, n % c], value))
    }

    /// The product by some bilinear product of the coefficients.
    fn times<U: Copy, V: Copy + std::ops::AddAssign + std::ops::Mul<f64, Output = V>>(
        &self,
        other: &Bernstein<U>,
        zero: V,
        product: impl Fn(T, U) -> V,
    ) -> Bernstein<V> {
        let degrees: [usize; 3] = std::array::from_fn(|k| self.degrees[k] + other.degrees[k]);
        let mut all = Bernstein::from_fn(degrees, |_| zero);
        let [_, b, c] = degrees.map(|d| d + 1);
        for (i, x) in self.places() {
            for (j, y) in other.places() {
                let weight: f64 = (0..3)
                    .map(|k| {
                        let (m, n) = (self.degrees[k], other.degrees[k]);
                        binomial(m, i[k]) * binomial(n, j[k]) / binomial(m + n, i[k] + j[k])
                    })
                    .product();
                let at = (i[0] + j[0]) * b * c + (i[1] + j[1]) * c + i[2] + j[2];
                all.coefficients[at] += product(x, y) * weight;
            }
        }
        all
    }
}

fn binomial(n: usize, k: usize) -> f64 {
    const ROWS: [[f64; 6]; 6] = [
        [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [1.0, 1.0, 0.0, 0.0, 0.0, 0.0],
        [1.0, 2.0, 1.0, 0.0, 0.0, 0.0],
        [1.0, 3.0, 3.0, 1.0, 0.0, 0.0],
        [1.0, 4.0, 6.0, 4.0, 1.0, 0.0],
        [1.0, 5.0, 10.0, 10.0, 5.0, 1.0],
    ];
    ROWS[n][k]
}

/// The coefficients of the map: from values at 0, 1/2, 1 along each axis.
fn coefficients(nodes: &Nodes) -> [DVec3; 27] {
    let mut c = [DVec3::ZERO; 27];
    for (p, [i, j, k]) in nodes.iter().zip(LATTICE) {
        c[9 * i + 3 * j + k] = *p;
    }
    for step in [9, 3, 1] {
        for start in (0..27).filter(|n| n / step % 3 == 0) {
            let [a, m, b] = [0, 1, 2].map(|k| c[start + k * step]);
            c[start + step] = 2.0 * m - 0.5 * (a + b);
        }
    }
    c
}

/// The 216 coefficients of the Jacobian determinant.
fn determinant(nodes: &Nodes) -> Vec<f64> {
    let c = coefficients(nodes);
    let derivative = |axis: usize| {
        let mut degrees = [2; 3];
        degrees[axis] = 1;
        let step = [9, 3, 1][axis];
        Bernstein::from_fn(degrees, |[i, j, k]| {
            let n = 9 * i + 3 * j + k;
            2.0 * (c[n + step] - c[n])
        })
    };
    let across = derivative(0).times(&derivative(1), DVec3::ZERO, DVec3::cross);
    across.times(&derivative(2), 0.0, DVec3::dot).coefficients
}

/// Whether the Jacobian determinant is proven positive in the whole cell.
pub fn is_certified(nodes: &Nodes) -> bool {
    let low = nodes.iter().fold(DVec3::INFINITY, |a, &p| a.min(p));
    let high = nodes.iter().fold(DVec3::NEG_INFINITY, |a, &p| a.max(p));
    let extent = (high - low).max_element();
    if !extent.is_finite() {
        return false;
    }
    positive(&determinant(nodes), LEAST_COEFFICIENT * extent.powi(3), CURVED_HALVINGS)
}

fn positive(c: &[f64], tiny: f64, depth: usize) -> bool {
    if c.iter().all(|&x| x > tiny) {
        return true;
    }
    // The coefficients at the corners are values: no halving can help there.
    let corners = (0..8).map(|n| (n >> 2 & 1) * 5 * N * N + (n >> 1 & 1) * 5 * N + (n & 1) * 5);
    if depth == 0 || corners.into_iter().any(|n| !(c[n] > tiny)) {
        return false;
    }
    (0..8).all(|part| positive(&half(c, part), tiny, depth - 1))
}

/// The coefficients over one of the eight parts of the cell (de Casteljau).
fn half(c: &[f64], part: usize) -> Vec<f64> {
    let mut out = c.to_vec();
    for (axis, step) in [N * N, N, 1].into_iter().enumerate() {
        let is_upper = part >> axis & 1 == 1;
        for start in (0..N * N * N).filter(|n| n / step % N == 0) {
            let mut row: [f64; N] = std::array::from_fn(|k| out[start + k * step]);
            let mut ends = row;
            for round in 1..N {
                for k in 0..N - round {
                    row[k] = 0.5 * (row[k] + row[k + 1]);
                }
                let end = if is_upper { N - 1 - round } else { round };
                ends[end] = if is_upper { row[N - 1 - round] } else { row[0] };
            }
            (0..N).for_each(|k| out[start + k * step] = ends[k]);
        }
    }
    out
}

/// The nodes on faces and in the middle that make a cell of 27 nodes the one of 20: its serendipity map.
pub fn serendipity(nodes: &Nodes) -> Nodes {
    let mut all = *nodes;
    for n in 20..27 {
        let place = LATTICE[n];
        let is_near = |m: &usize| (0..3).all(|a| place[a] == 1 || LATTICE[*m][a] == place[a]);
        let corners: Vec<usize> = (0..8).filter(is_near).collect();
        let edges: Vec<usize> = (8..20).filter(is_near).collect();
        let sum = |list: &[usize]| list.iter().map(|&m| nodes[m]).sum::<DVec3>();
        // Weights by which a straight cell has them in the middle.
        all[n] = match n {
            26 => 0.25 * sum(&edges) - 0.25 * sum(&corners),
            _ => 0.5 * sum(&edges) - 0.25 * sum(&corners),
        };
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn cube() -> Nodes {
        LATTICE.map(|c| DVec3::from(c.map(|x| x as f64 / 2.0)))
    }

    /// The determinant straight from its definition.
    fn jacobian(nodes: &Nodes, t: [f64; 3]) -> f64 {
        let shape = |k: usize, t: f64| [(2.0 * t - 1.0) * (t - 1.0), 4.0 * t * (1.0 - t), t * (2.0 * t - 1.0)][k];
        let slope = |k: usize, t: f64| [4.0 * t - 3.0, 4.0 - 8.0 * t, 4.0 * t - 1.0][k];
        let derivative = |axis: usize| {
            nodes.iter().zip(LATTICE).fold(DVec3::ZERO, |sum, (p, place)| {
                let factor = |a: usize| if a == axis { slope(place[a], t[a]) } else { shape(place[a], t[a]) };
                sum + *p * (factor(0) * factor(1) * factor(2))
            })
        };
        derivative(0).dot(derivative(1).cross(derivative(2)))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]
        #[test]
        fn the_certificate_is_sound(moves in prop::collection::vec(-0.22f64..0.22, 81)) {
            let mut p = cube();
            p.iter_mut().enumerate().for_each(|(k, q)| *q += DVec3::from_slice(&moves[3 * k..3 * k + 3]));
            let at = |n: u32| [n / 81, n / 9 % 9, n % 9].map(|k| f64::from(k) / 8.0);
            let least = (0..729).map(|n| jacobian(&p, at(n))).fold(f64::INFINITY, f64::min);
            let certified = is_certified(&p);
            prop_assert!(!certified || least > 0.0, "certified with {}", least);
            prop_assert!(certified || least < 0.15, "not certified with {}", least);
            // The coefficients at the corners are values there, and halving changes no value.
            let all = determinant(&p);
            prop_assert!((all[0] - jacobian(&p, [0.0; 3])).abs() < 1e-9);
            prop_assert!((all[215] - jacobian(&p, [1.0; 3])).abs() < 1e-9);
            let part = half(&all, 0b001);
            prop_assert!((part[0] - jacobian(&p, [0.5, 0.0, 0.0])).abs() < 1e-9);
            prop_assert!((part[215] - jacobian(&p, [1.0, 0.5, 0.5])).abs() < 1e-9);
        }
    }

    #[test]
    fn a_cube_its_mirror_and_a_cell_with_an_edge_bent_too_far() {
        let p = cube();
        assert!(is_certified(&p) && determinant(&p).iter().all(|d| (d - 1.0).abs() < 1e-12));
        assert!(!is_certified(&p.map(|q| DVec3::new(-q.x, q.y, q.z))));
        assert!(serendipity(&p).iter().zip(&p).all(|(a, b)| a.distance(*b) < 1e-15));
        let bent = |by: f64| {
            let mut p = cube();
            p[8].y += by;
            serendipity(&p)
        };
        assert!(is_certified(&bent(0.1)) && is_certified(&bent(-0.3)) && !is_certified(&bent(1.2)));
    }
}
