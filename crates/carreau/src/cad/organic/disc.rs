//! The control points around an irregular vertex, and their subdivision.
//!
//! ```text
//!        spoke s+1 (i = 0)
//!          ▲  │  │  │
//!        3 ●──●──●──●        sector s between two spokes: (i, j) counts along spoke s and along spoke s + 1
//!        2 ●──●──●──●
//!        1 ●──●──●──●
//!          ●──●──●──●──►  spoke s (j = 0)
//!          0  1  2  3
//! ```

use super::net::{Fan, Net, Role, next, previous};
use super::refine::{Refined, Value};

/// A count: rings of points around the vertex, because those of three have all control points of the pieces around it.
pub const DISC_RINGS: usize = 3;

/// The points within three rings of a vertex, or two on the first level.
#[derive(Clone)]
pub struct Disc<V> {
    closed: bool,
    role: Role,
    center: V,
    /// Of every spoke the points 1, 2, 3; an open disc has one spoke more than sectors.
    spokes: Vec<Vec<V>>,
    /// Of every sector the points (i, j) with i and j from 1 on, i fastest.
    inner: Vec<Vec<V>>,
    rings: usize,
}

impl<V: Value> Disc<V> {
    /// The disc of a fan after one step of subdivision.
    pub fn new(net: &Net, refined: &Refined<V>, fan: &Fan) -> Self {
        let edge = |h: u32| refined.edge[net.edge[h as usize] as usize].clone();
        let vertex = |v: u32| refined.vertex[v as usize].clone();
        let mut spokes: Vec<Vec<V>> = fan.spokes.iter().map(|&h| vec![edge(h), vertex(net.end(h))]).collect();
        if let (false, Some(&h)) = (fan.closed, fan.spokes.last()) {
            spokes.push(vec![edge(previous(h)), vertex(net.start(previous(h)))]);
        }
        let sector = |&h: &u32| {
            let far = next(next(h));
            vec![refined.face[h as usize / 4].clone(), edge(next(h)), edge(far), vertex(net.start(far))]
        };
        Disc {
            closed: fan.closed,
            role: net.role[fan.vertex as usize],
            center: vertex(fan.vertex),
            spokes,
            inner: fan.spokes.iter().map(sector).collect(),
            rings: 2,
        }
    }

    /// Number of sectors.
    pub fn sectors(&self) -> usize {
        self.inner.len()
    }

    /// The point (i, j) of a sector; −1 is beyond a spoke, mirrored at borders.
    pub fn at(&self, s: usize, i: i32, j: i32) -> V {
        let n = self.sectors();
        let get = |s: usize, i: i32, j: i32| match (i as usize, j as usize) {
            (0, 0) => self.center.clone(),
            (i, 0) => self.spokes[s][i - 1].clone(),
            (0, j) => self.spokes[(s + 1) % self.spokes.len()][j - 1].clone(),
            (i, j) => self.inner[s][(j - 1) * self.rings + i - 1].clone(),
        };
        match (i, j) {
            (_, -1) if s == 0 && !self.closed => V::mix(&[(2.0, &get(s, i, 0)), (-1.0, &get(s, i, 1))]),
            (_, -1) => get((s + n - 1) % n, 1, i),
            (-1, _) if s + 1 == n && !self.closed => V::mix(&[(2.0, &get(s, 0, j)), (-1.0, &get(s, 1, j))]),
            (-1, _) => get((s + 1) % n, j, 1),
            _ => get(s, i, j),
        }
    }

    /// The first points of the spokes, that of a crease which ends here once.
    fn around(&self) -> impl Iterator<Item = &V> {
        self.spokes.iter().take(self.sectors()).map(|s| &s[0])
    }

    /// Whether a spoke is a border.
    fn is_border(&self, spoke: usize) -> bool {
        !self.closed && (spoke == 0 || spoke + 1 == self.spokes.len())
    }

    /// The disc after one more step: all of its three rings.
    pub fn refined(&self) -> Self {
        let n = self.sectors();
        let mean = |points: [V; 4]| V::mix(&points.each_ref().map(|p| (0.25, p)));
        let face = |s: usize, i: i32, j: i32| {
            mean([self.at(s, i, j), self.at(s, i + 1, j), self.at(s, i, j + 1), self.at(s, i + 1, j + 1)])
        };
        let first: Vec<V> = (0..n).map(|s| face(s, 0, 0)).collect();
        let spokes = (0..self.spokes.len()).map(|a| self.refined_spoke(a, &first)).collect();
        let sector = |s: usize| {
            let p = |i: i32, j: i32| self.at(s, i, j);
            // An edge between two points, with the four beside it.
            let edge = |ends: [V; 2], beside: [V; 4]| {
                let ends = ends.each_ref().map(|p| (0.375, p));
                let beside = beside.each_ref().map(|p| (0.0625, p));
                V::mix(&[ends[0], ends[1], beside[0], beside[1], beside[2], beside[3]])
            };
            let e21 = edge([p(1, 0), p(1, 1)], [p(0, 0), p(0, 1), p(2, 0), p(2, 1)]);
            let e12 = edge([p(0, 1), p(1, 1)], [p(0, 0), p(1, 0), p(0, 2), p(1, 2)]);
            let e23 = edge([p(1, 1), p(1, 2)], [p(0, 1), p(0, 2), p(2, 1), p(2, 2)]);
            let e32 = edge([p(1, 1), p(2, 1)], [p(1, 0), p(2, 0), p(1, 2), p(2, 2)]);
            vec![
                first[s].clone(),
                e21,
                face(s, 1, 0),
                e12,
                self.vertex_rule(|di, dj| p(1 + di, 1 + dj)),
                e32,
                face(s, 0, 1),
                e23,
                face(s, 1, 1),
            ]
        };
        let inner = (0..n).map(sector).collect();
        Disc { center: self.refined_center(&first), spokes, inner, rings: DISC_RINGS, ..*self }
    }

    /// The rule for a regular vertex from the nine points around it.
    fn vertex_rule(&self, at: impl Fn(i32, i32) -> V) -> V {
        let weight = |d: i32| if d == 0 { 6.0 / 8.0 } else { 1.0 / 8.0 };
        let all: Vec<(f64, V)> = (-1..=1)
            .flat_map(|i| (-1..=1).map(move |j| (i, j)))
            .map(|(i, j)| (weight(i) * weight(j), at(i, j)))
            .collect();
        V::mix(&all.iter().map(|(w, p)| (*w, p)).collect::<Vec<_>>())
    }

    fn refined_spoke(&self, a: usize, first: &[V]) -> Vec<V> {
        let n = self.sectors();
        let [p1, p2] = [&self.spokes[a][0], &self.spokes[a][1]];
        let c = &self.center;
        if self.is_border(a) {
            let vertex = V::mix(&[(0.75, p1), (0.125, c), (0.125, p2)]);
            return vec![V::mix(&[(0.5, c), (0.5, p1)]), vertex, V::mix(&[(0.5, p1), (0.5, p2)])];
        }
        let before = (a + n - 1) % n;
        let edge = V::mix(&[(0.25, c), (0.25, p1), (0.25, &first[a]), (0.25, &first[before])]);
        let vertex = self.vertex_rule(|di, dj| self.at(a, 1 + di, dj));
        let beside = [(1, 1), (2, 1), (1, -1), (2, -1)].map(|(i, j)| self.at(a, i, j));
        let [b0, b1, b2, b3] = beside.each_ref().map(|p| (0.0625, p));
        vec![edge, vertex, V::mix(&[(0.375, p1), (0.375, p2), b0, b1, b2, b3])]
    }

    fn refined_center(&self, first: &[V]) -> V {
        let c = &self.center;
        match self.role {
            Role::Corner => c.clone(),
            Role::Border => {
                let ends = [&self.spokes[0][0], &self.spokes[self.spokes.len() - 1][0]];
                V::mix(&[(0.75, c), (0.125, ends[0]), (0.125, ends[1])])
            }
            Role::Smooth | Role::Dart => {
                let n = self.sectors() as f64;
                let mut terms = vec![((n - 2.0) / n, c)];
                terms.extend(self.around().map(|p| (1.0 / (n * n), p)));
                terms.extend(first.iter().map(|f| (1.0 / (n * n), f)));
                V::mix(&terms)
            }
        }
    }

    /// Where the surface goes through the vertex.
    pub fn limit(&self) -> V {
        let c = &self.center;
        match self.role {
            Role::Corner => c.clone(),
            Role::Border => {
                let ends = [&self.spokes[0][0], &self.spokes[self.spokes.len() - 1][0]];
                V::mix(&[(4.0 / 6.0, c), (1.0 / 6.0, ends[0]), (1.0 / 6.0, ends[1])])
            }
            Role::Smooth | Role::Dart => {
                let n = self.sectors() as f64;
                let all = n * (n + 5.0);
                let mut terms = vec![(n * n / all, c)];
                terms.extend(self.around().map(|p| (4.0 / all, p)));
                terms.extend(self.inner.iter().map(|s| (1.0 / all, &s[0])));
                V::mix(&terms)
            }
        }
    }
}
