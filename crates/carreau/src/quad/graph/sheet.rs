//! Triangles with frames that tracks are drawn into: an edge can be divided anywhere, so that every track is a path of edges,
//! and whatever runs into it meets it in a vertex.
//!
//! ```text
//!        c                  c
//!       ╱ ╲                ╱│╲
//!      ╱   ╲              ╱ │ ╲         half-edge 3t+k runs from corner k of triangle t to the next;
//!     a──h→─b     →      a──m──b        the parts of a triangle keep its frame
//!      ╲   ╱              ╲ │ ╱
//!       ╲ ╱                ╲│╱
//!        d                  d
//! ```

use crate::field::Field;
use crate::mesh::{NONE, Triangles};
use glam::DVec3;
use rustc_hash::FxHashMap;

/// What a half-edge is part of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wall {
    None,
    /// A feature, with its curve.
    Feature(u32),
    /// Of the motorcycle graph.
    Track,
    /// Through a patch that has holes.
    Cut,
}

/// The triangles.
#[derive(Clone)]
pub struct Sheet {
    pub points: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
    /// The half-edge on the other side, or [`NONE`].
    pub opposite: Vec<u32>,
    /// Branch s continues as s + turn on the other side.
    pub turn: Vec<i32>,
    pub wall: Vec<Wall>,
    /// Where there is a wall: the branch that runs along the half-edge.
    pub branch: Vec<i32>,
    pub frame: Vec<[DVec3; 2]>,
    pub region: Vec<u32>,
    /// A half-edge that leaves every vertex.
    pub out: Vec<u32>,
    /// Wanted length of quads.
    pub length: f64,
    /// Walls that have been divided, by their ends in ascending order, with the vertex between.
    pub divided: FxHashMap<[u32; 2], u32>,
}

impl Sheet {
    /// `curve`: of every feature edge, by its ends in ascending order. `region`: of every triangle.
    pub fn new(
        field: &Field,
        curve: &FxHashMap<[u32; 2], u32>,
        region: impl Fn(u32) -> u32,
        length: f64,
    ) -> Option<Self> {
        let t = Triangles::of(&field.mesh)?;
        let n = t.len() as u32;
        let mut p: FxHashMap<(u32, u32), i32> = FxHashMap::default();
        for m in &field.matchings {
            let [i, j] = m.triangles;
            p.insert((i, j), m.p);
            p.insert((j, i), -m.p);
        }
        let mut sheet = Sheet {
            points: t.points().to_vec(),
            triangles: (0..n).map(|i| t.triangle(i)).collect(),
            opposite: (0..3 * n).map(|c| t.opposite(c)).collect(),
            turn: vec![0; 3 * n as usize],
            wall: vec![Wall::None; 3 * n as usize],
            branch: vec![0; 3 * n as usize],
            frame: field.u.iter().zip(&field.v).map(|(&u, &v)| [u, v]).collect(),
            region: (0..n).map(|i| region(field.source[i as usize])).collect(),
            out: vec![NONE; t.points().len()],
            length,
            divided: FxHashMap::default(),
        };
        for h in 0..3 * n {
            let (a, b) = (t.vertex(h), t.vertex(t.next(h)));
            sheet.out[a as usize] = h;
            if let Some(&curve) = curve.get(&[a.min(b), a.max(b)]) {
                sheet.wall[h as usize] = Wall::Feature(curve);
                sheet.branch[h as usize] = sheet.nearest_branch(h / 3, t.points()[b as usize] - t.points()[a as usize]);
            } else if sheet.opposite[h as usize] == NONE {
                return None;
            } else {
                sheet.turn[h as usize] = *p.get(&(h / 3, sheet.opposite[h as usize] / 3))?;
            }
        }
        Some(sheet)
    }

    pub fn next(h: u32) -> u32 {
        if h % 3 == 2 { h - 2 } else { h + 1 }
    }

    pub fn previous(h: u32) -> u32 {
        if h.is_multiple_of(3) { h + 2 } else { h - 1 }
    }

    /// The vertex that a half-edge leaves.
    pub fn tail(&self, h: u32) -> u32 {
        self.triangles[h as usize / 3][h as usize % 3]
    }

    pub fn head(&self, h: u32) -> u32 {
        self.tail(Self::next(h))
    }

    pub fn along(&self, h: u32) -> DVec3 {
        self.points[self.head(h) as usize] - self.points[self.tail(h) as usize]
    }

    pub fn is_wall(&self, h: u32) -> bool {
        self.wall[h as usize] != Wall::None
    }

    pub fn is_feature(&self, h: u32) -> bool {
        matches!(self.wall[h as usize], Wall::Feature(_))
    }

    /// The feature curve of a half-edge.
    pub fn curve(&self, h: u32) -> Option<u32> {
        match self.wall[h as usize] {
            Wall::Feature(curve) => Some(curve),
            _ => None,
        }
    }

    /// Direction of a branch in a triangle.
    pub fn direction(&self, t: u32, branch: i32) -> DVec3 {
        let d = self.frame[t as usize][branch.rem_euclid(2) as usize];
        if branch.rem_euclid(4) < 2 { d } else { -d }
    }

    fn nearest_branch(&self, t: u32, along: DVec3) -> i32 {
        let fit = |s: &i32| self.direction(t, *s).dot(along);
        (0..4).max_by(|a, b| fit(a).total_cmp(&fit(b))).unwrap_or(0)
    }

    pub fn normal(&self, t: u32) -> DVec3 {
        let [a, b, c] = self.triangles[t as usize].map(|v| self.points[v as usize]);
        (b - a).cross(c - a).normalize_or_zero()
    }

    pub fn area(&self, t: u32) -> f64 {
        let [a, b, c] = self.triangles[t as usize].map(|v| self.points[v as usize]);
        (b - a).cross(c - a).length() / 2.0
    }

    /// Signed angle from one direction to another in the plane of a triangle.
    pub fn angle(&self, t: u32, from: DVec3, to: DVec3) -> f64 {
        from.cross(to).dot(self.normal(t)).atan2(from.dot(to))
    }

    /// The half-edges that leave a vertex, counter-clockwise; from the border, where there is one.
    pub fn around(&self, v: u32) -> Vec<u32> {
        let mut first = self.out[v as usize];
        let start = first;
        while self.opposite[first as usize] != NONE {
            first = Self::next(self.opposite[first as usize]);
            if first == start {
                break;
            }
        }
        let mut all = vec![first];
        let mut h = first;
        loop {
            h = self.opposite[Self::previous(h) as usize];
            if h == NONE || h == first {
                return all;
            }
            all.push(h);
        }
    }

    /// The half-edge between two vertices, if there is one that leaves the first.
    pub fn between(&self, a: u32, b: u32) -> Option<u32> {
        self.around(a).into_iter().find(|&h| self.head(h) == b)
    }

    /// Whether walls other than the given edge meet at a vertex, and whether features do.
    pub fn walls_at(&self, v: u32, but: u32) -> (usize, bool) {
        let (mut count, mut feature) = (0, false);
        for h in self.around(v) {
            if self.is_wall(h) && self.head(h) != but {
                count += 1;
                feature |= self.is_feature(h);
            }
            // The last edge before a border is entered from the other side only.
            let back = Self::previous(h);
            if self.opposite[back as usize] == NONE && self.tail(back) != but {
                (count, feature) = (count + 1, true);
            }
        }
        (count, feature)
    }

    /// Marks an edge on both sides; the branch is that of the half-edge.
    pub fn set_wall(&mut self, h: u32, wall: Wall, branch: i32) {
        (self.wall[h as usize], self.branch[h as usize]) = (wall, branch.rem_euclid(4));
        let o = self.opposite[h as usize];
        if o != NONE {
            self.wall[o as usize] = wall;
            self.branch[o as usize] = (branch + self.turn[h as usize] + 2).rem_euclid(4);
        }
    }

    /// Divides the edge of a half-edge; returns the new vertex.
    pub fn divide(&mut self, h: u32, at: DVec3) -> u32 {
        let m = self.points.len() as u32;
        let (a, b) = (self.tail(h), self.head(h));
        self.points.push(at);
        if self.is_wall(h) {
            self.divided.insert([a.min(b), a.max(b)], m);
        }
        let o = self.opposite[h as usize];
        let first = self.divide_side(h, m);
        self.out.push(first);
        self.out[a as usize] = h;
        self.out[b as usize] = Self::next(first);
        if o != NONE {
            let second = self.divide_side(o, m);
            self.join(h, second);
            self.join(first, o);
        }
        m
    }

    /// One triangle in two; returns the half-edge from the middle to the old head.
    fn divide_side(&mut self, h: u32, m: u32) -> u32 {
        let t = h / 3;
        let (next, apex) = (Self::next(h), self.tail(Self::previous(h)));
        let b = self.tail(next);
        let first = 3 * self.triangles.len() as u32;
        self.triangles.push([m, b, apex]);
        self.triangles[t as usize][next as usize % 3] = m;
        let pick = |list: &[i32]| [list[h as usize], list[next as usize], 0];
        let (turns, branches) = (pick(&self.turn), pick(&self.branch));
        let walls = [self.wall[h as usize], self.wall[next as usize], Wall::None];
        self.turn.extend(turns);
        self.branch.extend(branches);
        self.wall.extend(walls);
        self.opposite.extend([NONE, self.opposite[next as usize], next]);
        self.frame.push(self.frame[t as usize]);
        self.region.push(self.region[t as usize]);
        let far = self.opposite[next as usize];
        if far != NONE {
            self.opposite[far as usize] = first + 1;
        }
        (self.opposite[next as usize], self.turn[next as usize]) = (first + 2, 0);
        (self.wall[next as usize], self.branch[next as usize]) = (Wall::None, 0);
        first
    }

    fn join(&mut self, h: u32, o: u32) {
        (self.opposite[h as usize], self.opposite[o as usize]) = (o, h);
    }
}
