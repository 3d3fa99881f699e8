//! One curve: a chain of points with what is known of its ends.

use glam::DVec3;

/// How freely a vertex moves; ordered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Rank {
    /// On the surface.
    Free,
    /// Along its curve.
    Curve,
    /// Not at all.
    Corner,
}

/// What a curve is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// An inner edge that is sharp, tagged, or between two labels.
    Ridge,
    /// Where a ridge goes on below the feature angle.
    Crease,
    /// An open border.
    Border,
    /// An edge where the source was cut because it is not manifold: nothing on it changes.
    Seam,
}

/// A curve of the source between two corners, or closed.
#[derive(Debug, Clone)]
pub struct Chain {
    pub kind: Kind,
    pub closed: bool,
    /// A ridge all of whose edges are sharp.
    pub sharp: bool,
    /// A ridge or crease none of whose edges is: tagged, between labels, or fading out.
    pub smooth: bool,
    pub points: Vec<DVec3>,
    /// Source vertices; in a closed chain the first is repeated at the end.
    pub vertices: Vec<u32>,
    /// Arc length at every point.
    pub arc: Vec<f64>,
    /// Source half-edges of every segment, along it and back, where they exist.
    pub sides: Vec<[u32; 2]>,
}

impl Chain {
    /// Arc length of the whole chain.
    pub fn length(&self) -> f64 {
        self.arc.last().copied().unwrap_or(0.0)
    }

    /// The segment that holds a parameter.
    pub(super) fn segment(&self, s: f64) -> usize {
        self.arc.partition_point(|&a| a <= s).clamp(1, self.arc.len() - 1) - 1
    }

    /// The point at a parameter, which is wrapped into a closed chain, and its segment.
    pub fn at(&self, s: f64) -> (DVec3, usize) {
        let s = self.wrapped(s);
        let k = self.segment(s);
        let width = self.arc[k + 1] - self.arc[k];
        let t = if width > 0.0 { ((s - self.arc[k]) / width).clamp(0.0, 1.0) } else { 0.0 };
        (self.points[k].lerp(self.points[k + 1], t), k)
    }

    /// The parameter in 0..=length.
    pub fn wrapped(&self, s: f64) -> f64 {
        if self.closed { s.rem_euclid(self.length()) } else { s.clamp(0.0, self.length()) }
    }

    /// Parameters of the ends of a piece, unwrapped so that it runs between them the shorter way.
    pub fn span(&self, a: f64, b: f64) -> [f64; 2] {
        let length = self.length();
        if self.closed {
            let turn = (b - a) - length * ((b - a) / length).round();
            return [a, a + turn];
        }
        [a, b]
    }

    /// Radius of the circle through a vertex and the points at a distance along the chain; `None` where it ends before.
    pub(super) fn radius_at(&self, k: usize, reach: f64) -> Option<f64> {
        let (s, length) = (self.arc[k], self.length());
        let fits = if self.closed { 2.0 * reach < length } else { reach < s && reach < length - s };
        fits.then(|| circumradius(self.at(s - reach).0, self.points[k], self.at(s + reach).0))
    }

    /// The largest distance between the chord of a piece and the source vertices on the piece.
    pub fn sag(&self, [a, b]: [f64; 2]) -> f64 {
        let (from, to) = (a.min(b), a.max(b));
        let (p, q) = (self.at(from).0, self.at(to).0);
        let mut worst: f64 = 0.0;
        let mut look = |from: f64, to: f64| {
            let first = self.arc.partition_point(|&s| s <= from);
            for k in first..self.arc.len() {
                if self.arc[k] >= to {
                    break;
                }
                worst = worst.max(distance_to_segment(self.points[k], p, q));
            }
        };
        let length = self.length();
        if self.closed && to > length {
            look(from, length + 1.0);
            look(-1.0, to - length);
        } else if self.closed && from < 0.0 {
            look(from + length, length + 1.0);
            look(-1.0, to);
        } else {
            look(from, to);
        }
        worst
    }
}

/// Radius of the circle through three points.
pub fn circumradius(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let sine = (b - a).cross(c - b).length();
    a.distance(b) * b.distance(c) * a.distance(c) / (2.0 * sine).max(f64::MIN_POSITIVE)
}

pub fn distance_to_segment(x: DVec3, p: DVec3, q: DVec3) -> f64 {
    let along = q - p;
    let t = ((x - p).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    x.distance(p + t * along)
}
