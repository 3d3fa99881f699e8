//! The limit surface: a bicubic piece for every place of every quad.
//!
//! Each quad is divided once, so that every part has at most one irregular vertex: its corner. Parts with a regular corner are one
//! piece; others are divided towards it:
//!
//! ```text
//!     ┌────────┬────────┐
//!     │        │        │
//!     │        │        │      a part: pieces of 1/2, 1/4, … of its side
//!     ├───┬────┤        │
//!     ├─┬─┤    │        │
//!     ●─┴─┴────┴────────┘
//! ```

use super::disc::Disc;
use super::net::{Net, next, previous};
use super::refine::{Refined, Value, refine};
use crate::mesh::NONE;
use glam::DVec3;

/// A bicubic piece: uniform B-spline control points and where it lies in its part.
pub struct Piece<V> {
    /// `points[j][i]`, i along u.
    pub points: [[V; 4]; 4],
    /// The corner of the piece.
    pub origin: [f64; 2],
    /// Its side.
    pub size: f64,
}

/// The limit surface of control points.
pub struct Limit<'a, V> {
    net: &'a Net,
    refined: Refined<V>,
    /// Of every irregular fan its discs, from the second level on.
    discs: Vec<Vec<Disc<V>>>,
    /// Where the surface goes through the vertices of irregular fans.
    apex: Vec<Option<V>>,
    /// The sector of a corner in its fan.
    sector: Vec<u32>,
}

impl<'a, V: Value> Limit<'a, V> {
    /// The surface, with so many divisions towards irregular vertices.
    pub fn new(net: &'a Net, values: &[V], levels: usize) -> Self {
        let refined = refine(net, values);
        let mut sector = vec![0; net.fan_of.len()];
        let (mut discs, mut apex) = (Vec::with_capacity(net.fans.len()), Vec::with_capacity(net.fans.len()));
        for fan in &net.fans {
            (0u32..).zip(&fan.spokes).for_each(|(s, &h)| sector[h as usize] = s);
            let mut own: Vec<Disc<V>> = Vec::new();
            let mut limit = None;
            if !net.is_regular(fan) {
                let first = Disc::new(net, &refined, fan);
                limit = Some(first.limit());
                let mut disc = first;
                for _ in 0..levels {
                    disc = disc.refined();
                    own.push(disc.clone());
                }
            }
            discs.push(own);
            apex.push(limit);
        }
        Limit { net, refined, discs, apex, sector }
    }

    /// Where the surface goes through the corner of a part, where that is irregular.
    pub fn apex(&self, part: u32) -> Option<&V> {
        self.apex[self.net.fan_of[part as usize] as usize].as_ref()
    }

    /// The piece of a part (a half-edge: the corner that it leaves) at a place. Too near to an irregular vertex it is the last one
    /// in the same direction.
    pub fn piece(&self, part: u32, at: [f64; 2]) -> Piece<V> {
        let fan = self.net.fan_of[part as usize] as usize;
        if self.apex[fan].is_none() {
            return Piece { points: self.regular(part), origin: [0.0; 2], size: 1.0 };
        }
        let mut size = 0.5;
        let mut level = 0;
        while at[0].max(at[1]) <= size && level + 1 < self.discs[fan].len() {
            (size, level) = (0.5 * size, level + 1);
        }
        let [x, y] = at.map(|x| i32::from(x > size));
        let (x, y) = if (x, y) == (0, 0) { if at[0] >= at[1] { (1, 0) } else { (0, 1) } } else { (x, y) };
        let disc = &self.discs[fan][level];
        let s = self.sector[part as usize] as usize;
        let points = [-1, 0, 1, 2].map(|j| [-1, 0, 1, 2].map(|i| disc.at(s, x + i, y + j)));
        Piece { points, origin: [f64::from(x) * size, f64::from(y) * size], size }
    }

    /// The control points around a part with a regular corner.
    fn regular(&self, part: u32) -> [[V; 4]; 4] {
        let (net, r) = (self.net, &self.refined);
        let vertex = |v: u32| r.vertex[v as usize].clone();
        let edge = |h: u32| r.edge[net.edge[h as usize] as usize].clone();
        let face = |h: u32| r.face[h as usize / 4].clone();
        let mirrored = |a: &V, b: &V| V::mix(&[(2.0, a), (-1.0, b)]);
        let (right, far, left) = (next(part), next(next(part)), previous(part));
        // The part itself and beyond: rows of (0, 1, 2).
        let rows = [
            [vertex(net.start(part)), edge(part), vertex(net.start(right))],
            [edge(left), face(part), edge(right)],
            [vertex(net.start(left)), edge(far), vertex(net.start(far))],
        ];
        let (below, beside) = (net.opposite[part as usize], net.opposite[left as usize]);
        let row = match below {
            NONE => [0, 1, 2].map(|i| mirrored(&rows[0][i], &rows[1][i])),
            o => [edge(next(o)), face(o), edge(previous(o))],
        };
        let column = match beside {
            NONE => [0, 1, 2].map(|j| mirrored(&rows[j][0], &rows[j][1])),
            o => [edge(previous(o)), face(o), edge(next(o))],
        };
        let diagonal = match (below, beside) {
            (NONE, _) => mirrored(&column[0], &column[1]),
            (_, NONE) => mirrored(&row[0], &row[1]),
            (o, _) => match net.opposite[next(o) as usize] {
                NONE => mirrored(&column[0], &column[1]),
                beyond => face(beyond),
            },
        };
        let with = |first: &V, rest: &[V; 3]| [first.clone(), rest[0].clone(), rest[1].clone(), rest[2].clone()];
        [with(&diagonal, &row), with(&column[0], &rows[0]), with(&column[1], &rows[1]), with(&column[2], &rows[2])]
    }
}

/// Values of the blossom's basis: the weights of four uniform control points for the cubic's polar form at three parameters, where
/// [0, 1] is the piece.
pub fn polar(t: [f64; 3]) -> [f64; 4] {
    let mut weights = [0.0; 4];
    for (k, weight) in weights.iter_mut().enumerate() {
        let mut d = [0.0; 4];
        d[k] = 1.0;
        // De Boor's algorithm on the knots −2, …, 3, each level at a parameter of its own.
        for (r, &x) in (1..=3usize).zip(&t) {
            for i in (r..=3).rev() {
                let low = i as f64 - 3.0;
                let span = 4.0 - r as f64;
                let share = (x - low) / span;
                d[i] = (1.0 - share) * d[i - 1] + share * d[i];
            }
        }
        *weight = d[3];
    }
    weights
}

/// Values, first and second derivatives of the four uniform cubic B-splines on a piece.
pub fn basis(t: f64) -> [[f64; 4]; 3] {
    let s = 1.0 - t;
    [
        [
            s * s * s / 6.0,
            (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0,
            (3.0 * s * s * s - 6.0 * s * s + 4.0) / 6.0,
            t * t * t / 6.0,
        ],
        [-s * s / 2.0, (3.0 * t * t - 4.0 * t) / 2.0, (4.0 * s - 3.0 * s * s) / 2.0, t * t / 2.0],
        [s, 3.0 * t - 2.0, 3.0 * s - 2.0, t],
    ]
}

impl<V: Value> Piece<V> {
    /// The weighted sum of the control points.
    pub fn mix(&self, u: &[f64; 4], v: &[f64; 4]) -> V {
        let mut terms = Vec::with_capacity(16);
        for (row, &b) in self.points.iter().zip(v) {
            terms.extend(row.iter().zip(u).map(|(p, &a)| (a * b, p)));
        }
        V::mix(&terms)
    }

    /// Parameters of a place of the part in the piece.
    pub fn local(&self, at: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|k| (at[k] - self.origin[k]) / self.size)
    }

    /// The point at a place of the part.
    pub fn point(&self, at: [f64; 2]) -> V {
        let [u, v] = self.local(at).map(basis);
        self.mix(&u[0], &v[0])
    }
}

impl Piece<DVec3> {
    /// The point at a place of the part, and the derivatives there by the parameters of the piece.
    pub fn tangents(&self, at: [f64; 2]) -> [DVec3; 3] {
        let [u, v] = self.local(at).map(basis);
        [self.mix(&u[0], &v[0]), self.mix(&u[1], &v[0]), self.mix(&u[0], &v[1])]
    }
}
