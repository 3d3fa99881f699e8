//! The paper's general case (section 3.2, figures 6 to 9): spherical Delaunay triangulation of the directions, edges
//! taken out and put in until every vertex has four, dual.
//!
//! 1. Edges with both ends above four are removed, then those with one end above four and the other at four; smallest
//!    created angle first.
//! 2. Pairs of vertices with three edges that share a face are joined across it, non-adjacent ones first, largest of
//!    the least created angles first.
//! 3. Other pairs, longest of the shortest paths first: on a path of odd length the edges 0, 2, 4 … are doubled and the
//!    edges 1, 3, 5 … removed; on an even one an end is first moved a step along the path by way of a side vertex.
//!
//! ```text
//!   3 ═══ 4 ─ ─ 4 ═══ 3        doubled, removed, doubled: all have four
//! ```

use super::hull::convex_hull;
use super::map::Map;
use super::partition::Connection;
use glam::DVec3;
use std::f64::consts::TAU;

/// Rounds of pair removal before giving up.
const REMOVAL_ROUNDS: usize = 64;

/// The dual partition; `None` where the directions lie in a plane or the heuristic finds no four-valent graph.
pub fn partition(directions: &[DVec3]) -> Option<Connection> {
    let triangles = convex_hull(directions)?;
    let map = Map::of_triangles(directions.len(), &triangles)?;
    let mut graph = Graph { map, directions };
    graph.reduce();
    graph.pair_up()?;
    graph.dual()
}

struct Graph<'a> {
    map: Map,
    directions: &'a [DVec3],
}

impl Graph<'_> {
    fn valence(&self, v: u32) -> usize {
        self.map.valence(v)
    }

    /// Angle in the tangent plane from one direction to another, counter-clockwise, in (0, 2π].
    fn angle(&self, at: u32, from: u32, to: u32) -> f64 {
        let [n, a, b] = [at, from, to].map(|v| self.directions[v as usize]);
        let (a, b) = (a - n * n.dot(a), b - n * n.dot(b));
        let angle = n.dot(a.cross(b)).atan2(a.dot(b));
        if angle <= 1e-12 { angle + TAU } else { angle }
    }

    /// The angle that taking out a half-edge leaves at its origin.
    fn angle_without(&self, h: u32) -> f64 {
        let (before, after) = (self.map.turned(h, -1), self.map.turned(h, 1));
        self.angle(self.map.origin[h as usize], self.map.head(before), self.map.head(after))
    }

    /// Step 1.
    fn reduce(&mut self) {
        for least_other in [5, 4] {
            loop {
                let fits = |h: &u32| {
                    let ends = [self.map.origin[*h as usize], self.map.head(*h)].map(|v| self.valence(v));
                    let (low, high) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
                    high > 4 && low >= least_other
                };
                let created = |h: u32| self.angle_without(h).max(self.angle_without(h ^ 1));
                let best = self.map.edges().into_iter().filter(fits).min_by(|a, b| created(*a).total_cmp(&created(*b)));
                match best {
                    Some(h) => self.map.remove(h),
                    None => break,
                }
            }
        }
    }

    fn threes(&self) -> Vec<u32> {
        (0..self.directions.len() as u32).filter(|&v| self.valence(v) == 3).collect()
    }

    /// Steps 2 and 3.
    fn pair_up(&mut self) -> Option<()> {
        for _ in 0..REMOVAL_ROUNDS {
            let threes = self.threes();
            if threes.is_empty() {
                return (0..self.directions.len() as u32).all(|v| self.valence(v) == 4).then_some(());
            }
            if !self.cut_between_threes() {
                self.follow_longest_path(&threes)?;
            }
        }
        None
    }

    /// Joins two vertices of valence 3 across a face they share.
    fn cut_between_threes(&mut self) -> bool {
        let mut best: Option<((bool, f64), u32, u32)> = None;
        for h in self.map.half_edges() {
            let face = self.map.face(h);
            for (k, &g) in face.iter().enumerate().skip(1) {
                let [a, b] = [h, g].map(|x| self.map.origin[x as usize]);
                if a >= b || self.valence(a) != 3 || self.valence(b) != 3 {
                    continue;
                }
                let apart = k > 1 && k + 1 < face.len();
                let key = (apart, self.least_created_angle(h, g));
                if best.is_none_or(|(known, _, _)| (key.0, key.1) > known) {
                    best = Some((key, h, g));
                }
            }
        }
        best.map(|(_, h, g)| self.map.cut(h, g)).is_some()
    }

    /// The least of the four angles that an edge between two corners of a face makes.
    fn least_created_angle(&self, a: u32, b: u32) -> f64 {
        let at = |h: u32, to: u32| {
            let (v, behind) = (self.map.origin[h as usize], self.map.turned(h, 1));
            let first = self.angle(v, self.map.head(h), to);
            let second = self.angle(v, to, self.map.head(behind));
            first.min(second)
        };
        at(a, self.map.origin[b as usize]).min(at(b, self.map.origin[a as usize]))
    }

    /// Step 3 for one pair.
    fn follow_longest_path(&mut self, threes: &[u32]) -> Option<()> {
        let mut path: Vec<u32> = Vec::new();
        for (k, &a) in threes.iter().enumerate() {
            for &b in &threes[k + 1..] {
                let found = self.shortest_path(a, b)?;
                if found.len() > path.len() {
                    path = found;
                }
            }
        }
        if path.len().is_multiple_of(2) {
            return self.shift_end(&path);
        }
        for (k, &h) in path.iter().enumerate() {
            if k % 2 == 0 {
                self.map.double(h);
            } else {
                self.map.remove(h);
            }
        }
        Some(())
    }

    /// Half-edges of a shortest path.
    fn shortest_path(&self, from: u32, to: u32) -> Option<Vec<u32>> {
        let mut came_by: Vec<Option<u32>> = vec![None; self.directions.len()];
        let mut queue = std::collections::VecDeque::from([from]);
        while let Some(v) = queue.pop_front() {
            for &h in &self.map.around[v as usize] {
                let w = self.map.head(h);
                if w != from && came_by[w as usize].is_none() {
                    came_by[w as usize] = Some(h);
                    queue.push_back(w);
                }
            }
        }
        let mut path = Vec::new();
        let mut v = to;
        while v != from {
            let h = came_by[v as usize]?;
            path.push(h);
            v = self.map.origin[h as usize];
        }
        path.reverse();
        Some(path)
    }

    /// Moves the lack of an edge from an end of the path to its next vertex p: a new edge from the end to a vertex s
    /// beside, whose edge to p goes.
    ///
    /// ```text
    ///      s                 s
    ///    ╱ │               ╱╱
    ///   a──p──…     →     a──p──…     a gains an edge, p loses one
    /// ```
    fn shift_end(&mut self, path: &[u32]) -> Option<()> {
        let ends = [*path.first()?, path.last()? ^ 1];
        let mut best: Option<(f64, u32, u32)> = None;
        for along in ends {
            // The edge from p to s on the left of the path, and on its right.
            let (left, right) = (self.map.next(along), self.map.turned(along ^ 1, 1));
            for edge in [left, right] {
                let s = self.map.head(edge);
                if s == self.map.origin[along as usize] || self.valence(s) < 4 {
                    continue;
                }
                let created = self.angle_without(edge).max(self.angle_without(edge ^ 1));
                if best.is_none_or(|b| created < b.0) {
                    best = Some((created, along, edge));
                }
            }
        }
        let (_, along, edge) = best?;
        let on_left = self.map.next(along) == edge;
        // The face between: on the left of `along`, or on the left of its opposite.
        let face = self.map.face(if on_left { along } else { along ^ 1 });
        let (a, s) = (self.map.origin[along as usize], self.map.head(edge));
        let corner = |v: u32| face.iter().copied().find(|&h| self.map.origin[h as usize] == v);
        let (from, to) = (corner(a)?, corner(s)?);
        self.map.cut(from, to);
        self.map.remove(edge);
        Some(())
    }

    /// Faces become vertices at their spherical barycentres, vertices become quads.
    fn dual(&self) -> Option<Connection> {
        let mut face_of = vec![u32::MAX; self.map.origin.len()];
        let mut vertices = Vec::new();
        for h in self.map.edges().into_iter().flat_map(|h| [h, h ^ 1]) {
            if face_of[h as usize] == u32::MAX {
                let face = self.map.face(h);
                face.iter().for_each(|&g| face_of[g as usize] = vertices.len() as u32);
                vertices.push(self.barycentre(&face));
            }
        }
        if vertices.len() != self.directions.len() + 2 {
            return None;
        }
        let mut number = vec![0u32; self.map.origin.len()];
        self.map.edges().into_iter().zip(0..).for_each(|(h, k)| {
            number[h as usize] = k;
            number[(h ^ 1) as usize] = k;
        });
        let (mut quads, mut sides) = (Vec::new(), Vec::new());
        for around in &self.map.around {
            // The face on the left of a half-edge lies between it and the next one counter-clockwise.
            let list: [u32; 4] = around.as_slice().try_into().ok()?;
            quads.push(list.map(|h| face_of[h as usize]));
            // From the face before the next half-edge to the one behind it: the side crosses that half-edge.
            sides.push(std::array::from_fn(|k| number[list[(k + 1) % 4] as usize]));
        }
        Some(Connection::new(vertices, quads, sides))
    }

    /// On the side of the sphere that the face's normal points to.
    fn barycentre(&self, face: &[u32]) -> DVec3 {
        let corner = |k: usize| self.directions[self.map.origin[face[k % face.len()] as usize] as usize];
        let mean: DVec3 = (0..face.len()).map(corner).sum();
        let normal: DVec3 = (0..face.len()).map(|k| corner(k).cross(corner(k + 1))).sum();
        let inner = if face.len() == 2 { mean } else { mean.normalize_or_zero() * 0.5 + normal.normalize_or_zero() };
        let inner = if face.len() > 2 && mean.dot(normal) < 0.0 { normal } else { inner };
        inner.normalize_or(DVec3::X)
    }
}
