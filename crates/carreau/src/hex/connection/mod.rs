//! Connection surfaces: a branching of n segments gets a partition of the sphere into n quads, each with the direction
//! of one segment in it; n + 2 vertices, 2 n sides (Viville et al., section 3.2).
//!
//! Two ways to make one: orange slices about an axis, and the dual of a spherical Delaunay triangulation changed until
//! every vertex has four edges. Two conditions decide whether a partition is any good:
//!
//! * inclusion: det(d, Vₖ, Vₖ₊₁) > 0 for the four sides of the quad of direction d, which is the sign of the Jacobian of
//!   the four hexes at the branching;
//! * convexity: det(Vₖ₋₁, Vₖ, Vₖ₊₁) > 0; not asked for at a vertex of two quads, whose two angles make a round, so that
//!   straight is the best it can be.
//!
//! Departure: the paper takes the first partition that its heuristic gives. Here all candidates (the heuristic's, and
//! orange slices on many axes) have their vertices moved to enlarge the least of those determinants, and the best wins:
//! orange slices on some axis always include and are convex, so that a valid partition always exists.

mod dual;
mod hull;
mod map;
mod orange;
mod search;

pub use search::PartitionSearch;

use glam::DVec3;

/// The eight ways a vertex may go.
const ROUND: [[f64; 2]; 8] = {
    const D: f64 = std::f64::consts::FRAC_1_SQRT_2;
    [[1.0, 0.0], [D, D], [0.0, 1.0], [-D, D], [-1.0, 0.0], [-D, -D], [0.0, -1.0], [D, -D]]
};

/// A partition of the unit sphere into quads, one per direction.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Connection {
    /// Vertices on the unit sphere, n + 2 of them.
    pub vertices: Vec<DVec3>,
    /// Corners of every quad, counter-clockwise seen from outside.
    pub quads: Vec<[u32; 4]>,
    /// Sides of every quad, in 0..2n: side k runs from corner k to corner k + 1; each belongs to two quads.
    pub sides: Vec<[u32; 4]>,
    /// Number of quads at every vertex.
    valences: Vec<u32>,
}

/// The quads at every vertex.
#[derive(Debug, Default)]
struct QuadsAtVertices {
    starts: Vec<u32>,
    quads: Vec<u32>,
}

impl Connection {
    fn new(vertices: Vec<DVec3>, quads: Vec<[u32; 4]>, sides: Vec<[u32; 4]>) -> Connection {
        let mut valences = vec![0; vertices.len()];
        quads.as_flattened().iter().for_each(|&v| valences[v as usize] += 1);
        Connection { vertices, quads, sides, valences }
    }

    /// The least determinant of inclusion and convexity, less a little for every vertex of high valence. What is not
    /// valid comes after all that is.
    fn score(&self, directions: &[DVec3]) -> f64 {
        let highest = self.valences.iter().copied().max().unwrap_or(0);
        valid_first(self.least_determinant(directions), -0.01 * f64::from(highest))
    }

    /// The determinant of a quad: see [`quad_determinant`].
    fn determinant(&self, quad: usize, direction: DVec3) -> f64 {
        let q = self.quads[quad];
        quad_determinant(q.map(|v| self.vertices[v as usize]), q.map(|v| self.valences[v as usize] > 2), direction)
    }

    /// The least determinant of inclusion and convexity: positive for a valid partition.
    pub fn least_determinant(&self, directions: &[DVec3]) -> f64 {
        directions.iter().enumerate().map(|(q, &d)| self.determinant(q, d)).fold(f64::INFINITY, f64::min)
    }

    /// Moves vertices about the sphere to enlarge the least determinant of the quads at each: a pattern search with
    /// shrinking steps. `around` is working memory.
    fn relax(&mut self, directions: &[DVec3], around: &mut QuadsAtVertices) {
        around.fill(self);
        let mut step = 0.25;
        for _ in 0..24 {
            let mut moved = false;
            for v in 0..self.vertices.len() {
                let quads = around.of(v);
                let here = self.vertices[v];
                let (across, up) = here.any_orthonormal_pair();
                let mut best = (self.value_about(quads, directions, f64::NEG_INFINITY), here);
                for [cos, sin] in ROUND {
                    self.vertices[v] = (here + (across * cos + up * sin) * step).normalize();
                    let value = self.value_about(quads, directions, best.0);
                    if value > best.0 + 1e-9 {
                        best = (value, self.vertices[v]);
                    }
                }
                moved |= best.1 != here;
                self.vertices[v] = best.1;
            }
            if !moved {
                step *= 0.6;
            }
        }
    }

    /// The least determinant of some quads, with a little of their sum to break ties; anything lower where it is clear that
    /// `known` is not exceeded.
    fn value_about(&self, quads: &[u32], directions: &[DVec3], known: f64) -> f64 {
        const SHARE: f64 = 1e-3;
        let (mut least, mut sum) = (f64::INFINITY, 0.0);
        for &q in quads {
            let d = self.determinant(q as usize, directions[q as usize]);
            least = least.min(d);
            sum += d;
            // No determinant of unit vectors is above one.
            if valid_first(least, SHARE * quads.len() as f64) <= known {
                return f64::NEG_INFINITY;
            }
        }
        valid_first(least, SHARE * sum)
    }

    /// The middle of every side on the unit sphere, all zero before.
    pub fn side_middles(&self, directions: &[DVec3], middles: &mut [DVec3]) {
        for ((quad, sides), &d) in self.quads.iter().zip(&self.sides).zip(directions) {
            for k in 0..4 {
                let [a, b] = [quad[k], quad[(k + 1) % 4]].map(|v| self.vertices[v as usize]);
                // Both quads of a side add to it: half of the ends' sum each, and a little of their directions, which
                // decides where the ends are opposite.
                middles[sides[k] as usize] += 0.5 * (a + b) + 0.02 * d;
            }
        }
        middles.iter_mut().for_each(|m| *m = m.normalize_or(DVec3::X));
    }
}

impl QuadsAtVertices {
    fn fill(&mut self, c: &Connection) {
        self.starts.clear();
        self.starts.push(0);
        let mut sum = 0;
        // Each start is moved on while its list is filled, and is then where the next list starts.
        self.starts.extend(c.valences.iter().map(|n| {
            sum += n;
            sum - n
        }));
        self.quads.resize(sum as usize, 0);
        for (&v, k) in c.quads.as_flattened().iter().zip(0u32..) {
            let next = &mut self.starts[v as usize + 1];
            self.quads[*next as usize] = k / 4;
            *next += 1;
        }
    }

    fn of(&self, v: usize) -> &[u32] {
        &self.quads[self.starts[v] as usize..self.starts[v + 1] as usize]
    }
}

/// A least determinant with a bonus that decides among valid partitions and among others, never between the two.
fn valid_first(least: f64, bonus: f64) -> f64 {
    const APART: f64 = 10.0;
    least + bonus - if least > 0.0 { 0.0 } else { APART }
}

/// The least of inclusion and convexity of a quad about a direction; `turns` says at which corners convexity is asked for.
fn quad_determinant(p: [DVec3; 4], turns: [bool; 4], d: DVec3) -> f64 {
    let mut least = f64::INFINITY;
    for k in 0..4 {
        let across = p[k].cross(p[(k + 1) % 4]);
        least = least.min(d.dot(across));
        if turns[k] {
            least = least.min(p[(k + 3) % 4].dot(across));
        }
    }
    least
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Unit directions, no two closer than an angle, from numbers of a generator.
    pub fn star(numbers: &[f64], valence: usize, least_degrees: f64) -> Option<Vec<DVec3>> {
        let mut directions: Vec<DVec3> = Vec::new();
        for n in numbers.chunks_exact(3) {
            let d = DVec3::from_slice(n);
            if d.length() < 1.0 && d.length() > 0.1 {
                let d = d.normalize();
                if directions.iter().all(|e| e.dot(d) < least_degrees.to_radians().cos()) {
                    directions.push(d);
                }
            }
            if directions.len() == valence {
                return Some(directions);
            }
        }
        None
    }

    /// Every side has two quads that run it in opposite senses, and the counts are Euler's.
    pub fn assert_partition(c: &Connection, n: usize) {
        assert_eq!((c.quads.len(), c.sides.len(), c.vertices.len()), (n, n, n + 2));
        let mut ends: Vec<Vec<[u32; 2]>> = vec![Vec::new(); 2 * n];
        for (q, s) in c.quads.iter().zip(&c.sides) {
            (0..4).for_each(|k| ends[s[k] as usize].push([q[k], q[(k + 1) % 4]]));
        }
        for side in ends {
            assert!(matches!(side[..], [[a, b], [c, d]] if a == d && b == c && a != b), "{side:?}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]
        #[test]
        fn every_star_is_included(n in 3usize..13, numbers in prop::collection::vec(-1.0f64..1.0, 600)) {
            if let Some(directions) = star(&numbers, n, 15.0) {
                let c = PartitionSearch::default().partition(&directions).clone();
                assert_partition(&c, n);
                prop_assert!(c.least_determinant(&directions) > 0.0, "{}", c.least_determinant(&directions));
            }
        }
    }

    /// Orange slices have poles of valence 12 here, and the paper's heuristic a lower one but an angle turned inside out.
    #[test]
    fn validity_comes_before_low_valence() {
        let directions = [
            [-0.25139499652668257, -0.9507992141637049, 0.18105637262198349],
            [-0.7938746973598434, -0.22410944367486077, -0.5652768544240615],
            [-0.33648721330708453, 0.9392822186255586, 0.06727012007333295],
            [-0.8296350774319953, 0.4937118387753117, 0.260680376222507],
            [-0.9120162525412233, -0.26223543728398846, 0.3153710997113381],
            [0.20327206109957807, 0.9452887180611844, -0.25516604139769816],
            [-0.1216635717337983, -0.44764690988122574, -0.8858951514636281],
            [-0.6879669557927146, 0.7244838870272006, -0.04271492918481336],
            [-0.6206261060471968, -0.4012663519340511, -0.673653138713264],
            [-0.41742023824379626, -0.6202199191519493, -0.6641442588712501],
            [0.03702360681389938, 0.1404769898836702, -0.9893914634014754],
            [-0.5093096254395499, -0.7720546701966934, -0.38017797366772865],
        ];
        let directions = directions.map(DVec3::from_array);
        let c = PartitionSearch::default().partition(&directions).clone();
        assert_partition(&c, 12);
        assert!(c.least_determinant(&directions) > 0.0);
    }

    #[test]
    fn six_axes_are_a_cube() {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z];
        let c = PartitionSearch::default().partition(&axes).clone();
        assert_partition(&c, 6);
        let mut valence = [0; 8];
        c.quads.as_flattened().iter().for_each(|&v| valence[v as usize] += 1);
        assert_eq!(valence, [3; 8]);
    }

    #[test]
    fn directions_in_one_plane_and_in_one_half_of_space() {
        let flat: Vec<DVec3> =
            (0..5).map(|k| DVec3::from((glam::DVec2::from_angle(1.2 * f64::from(k)), 0.0))).collect();
        let tilted: Vec<DVec3> = flat.iter().map(|d| (*d + DVec3::Z).normalize()).collect();
        for directions in [flat, tilted] {
            let c = PartitionSearch::default().partition(&directions).clone();
            assert_partition(&c, 5);
            assert!(c.least_determinant(&directions) > 0.0);
        }
    }
}
