//! A partition of the sphere, and what it is worth.

use glam::DVec3;

/// The eight ways a vertex may go.
pub const ROUND: [[f64; 2]; 8] = {
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
    pub(super) valences: Vec<u32>,
}

/// The quads at every vertex.
#[derive(Debug, Default)]
pub struct QuadsAtVertices {
    pub(super) starts: Vec<u32>,
    pub(super) quads: Vec<u32>,
}

impl Connection {
    pub(super) fn new(vertices: Vec<DVec3>, quads: Vec<[u32; 4]>, sides: Vec<[u32; 4]>) -> Connection {
        let mut valences = vec![0; vertices.len()];
        quads.as_flattened().iter().for_each(|&v| valences[v as usize] += 1);
        Connection { vertices, quads, sides, valences }
    }

    /// The least determinant of inclusion and convexity, less a little for every vertex of high valence. What is not
    /// valid comes after all that is.
    pub(super) fn score(&self, directions: &[DVec3]) -> f64 {
        let highest = self.valences.iter().copied().max().unwrap_or(0);
        valid_first(self.least_determinant(directions), -0.01 * f64::from(highest))
    }

    /// The determinant of a quad: see [`quad_determinant`].
    pub(super) fn determinant(&self, quad: usize, direction: DVec3) -> f64 {
        let q = self.quads[quad];
        quad_determinant(q.map(|v| self.vertices[v as usize]), q.map(|v| self.valences[v as usize] > 2), direction)
    }

    /// The least determinant of inclusion and convexity: positive for a valid partition.
    pub fn least_determinant(&self, directions: &[DVec3]) -> f64 {
        directions.iter().enumerate().map(|(q, &d)| self.determinant(q, d)).fold(f64::INFINITY, f64::min)
    }

    /// Moves vertices about the sphere to enlarge the least determinant of the quads at each: a pattern search with
    /// shrinking steps. `around` is working memory.
    pub(super) fn relax(&mut self, directions: &[DVec3], around: &mut QuadsAtVertices) {
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
    pub(super) fn value_about(&self, quads: &[u32], directions: &[DVec3], known: f64) -> f64 {
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
    pub(super) fn fill(&mut self, c: &Connection) {
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

    pub(super) fn of(&self, v: usize) -> &[u32] {
        &self.quads[self.starts[v] as usize..self.starts[v + 1] as usize]
    }
}

/// A least determinant with a bonus that decides among valid partitions and among others, never between the two.
pub fn valid_first(least: f64, bonus: f64) -> f64 {
    const APART: f64 = 10.0;
    least + bonus - if least > 0.0 { 0.0 } else { APART }
}

/// The least of inclusion and convexity of a quad about a direction; `turns` says at which corners convexity is asked for.
pub fn quad_determinant(p: [DVec3; 4], turns: [bool; 4], d: DVec3) -> f64 {
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
