//! The quads as a net: half-edges, fans around vertices, straight lines.
//!
//! ```text
//!     v(k+3) ◄───e(k+2)─── v(k+2)        half-edge 4 q + k runs from corner k of quad q to the next
//!       │                    ▲
//!     e(k+3)       q       e(k+1)
//!       ▼                    │
//!     v(k) ──────e(k)────► v(k+1)
//! ```

use crate::error::{Error, Result};
use crate::mesh::NONE;
use glam::DVec3;

/// The role of a vertex, which decides how the surface goes through it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Inside of the smooth surface.
    Smooth,
    /// On a border or crease that runs on.
    Border,
    /// Where a crease ends inside: the surface is smooth there.
    Dart,
    /// Where borders or creases meet or bend: the surface goes through the control point.
    Corner,
}

/// The quads between the creases and borders that end at a vertex, counter-clockwise.
#[derive(Debug, Clone)]
pub struct Fan {
    /// The vertex.
    pub vertex: u32,
    /// Half-edges that leave the vertex, each the first side of a quad of the fan.
    pub spokes: Vec<u32>,
    /// Whether it goes all the way round.
    pub closed: bool,
}

/// A mesh of quads that meet at edges, but not across borders and creases.
#[derive(Debug, Clone)]
pub struct Net {
    /// Corners of the quads.
    pub quads: Vec<[u32; 4]>,
    /// The half-edge that runs the other way; [`NONE`] on borders and creases.
    pub opposite: Vec<u32>,
    /// The edge of a half-edge: the same on both sides of a crease.
    pub edge: Vec<u32>,
    /// Its ends.
    pub ends: Vec<[u32; 2]>,
    /// Roles of the vertices.
    pub role: Vec<Role>,
    /// All fans, by vertex.
    pub fans: Vec<Fan>,
    /// The fan of the corner that a half-edge leaves from.
    pub fan_of: Vec<u32>,
}

/// The next side of a quad.
pub fn next(h: u32) -> u32 {
    h & !3 | (h + 1) & 3
}

/// The side before.
pub fn previous(h: u32) -> u32 {
    h & !3 | (h + 3) & 3
}

/// Cosine of 60°, the bend at which a border or crease has a corner, because a border that is ragged at the size of the
/// quads bends by less.
const CORNER_COSINE: f64 = 0.5;

impl Net {
    /// The net of quads; edges in `creases` (by their ends, smaller first, sorted) part them.
    ///
    /// # Errors
    /// [`Error::Numeric`] where edges have more than two quads, or two that are turned against each other.
    pub fn new(points: &[DVec3], quads: Vec<[u32; 4]>, creases: &[[u32; 2]]) -> Result<Self> {
        let mut net = Net::joined(points.len(), quads, creases)?;
        net.find_roles(points);
        Ok(net)
    }

    /// The net after every quad was divided in four (vertices, then one for every edge, then one for every quad). Roles stay: walls
    /// run from the corners there were, and what the fit has bent since is no other one.
    ///
    /// # Errors
    /// As [`Net::new`].
    pub fn divided(&self, quads: Vec<[u32; 4]>, creases: &[[u32; 2]]) -> Result<Self> {
        let mut role = self.role.clone();
        let first = role.len();
        role.resize(first + self.ends.len() + self.quads.len(), Role::Smooth);
        let borders = self.edge.iter().zip(&self.opposite).filter(|e| *e.1 == NONE);
        borders.for_each(|(&edge, _)| role[first + edge as usize] = Role::Border);
        let net = Net::joined(role.len(), quads, creases)?;
        Ok(Net { role, ..net })
    }

    /// Half-edges and fans, without roles.
    fn joined(vertices: usize, quads: Vec<[u32; 4]>, creases: &[[u32; 2]]) -> Result<Self> {
        let mut sides: Vec<([u32; 2], u32)> = Vec::with_capacity(4 * quads.len());
        for (q, corners) in (0u32..).zip(&quads) {
            for k in 0..4 {
                let (a, b) = (corners[k], corners[(k + 1) % 4]);
                sides.push(([a.min(b), a.max(b)], 4 * q + k as u32));
            }
        }
        sides.sort_unstable();
        let mut net = Net {
            opposite: vec![NONE; sides.len()],
            edge: vec![NONE; sides.len()],
            ends: Vec::new(),
            role: vec![Role::Smooth; vertices],
            fans: Vec::new(),
            fan_of: vec![NONE; sides.len()],
            quads,
        };
        for group in sides.chunk_by(|a, b| a.0 == b.0) {
            group.iter().for_each(|s| net.edge[s.1 as usize] = net.ends.len() as u32);
            net.ends.push(group[0].0);
            match *group {
                [_] => {}
                [(ends, a), (_, b)] if net.start(a) != net.start(b) => {
                    if creases.binary_search(&ends).is_err() {
                        (net.opposite[a as usize], net.opposite[b as usize]) = (b, a);
                    }
                }
                _ => return Err(Error::Numeric("quads do not meet two by two at an edge".into())),
            }
        }
        net.find_fans();
        Ok(net)
    }

    /// The vertex that a half-edge leaves.
    pub fn start(&self, h: u32) -> u32 {
        self.quads[h as usize / 4][h as usize % 4]
    }

    /// The vertex that it leads to.
    pub fn end(&self, h: u32) -> u32 {
        self.start(next(h))
    }

    /// The half-edge straight ahead, on the same side; [`NONE`] at a border.
    pub fn ahead(&self, h: u32) -> u32 {
        match self.opposite[next(h) as usize] {
            NONE => NONE,
            o => next(o),
        }
    }

    /// Whether a fan has the quads that it has in a grid, so that the surface has the pieces of a grid there.
    pub fn is_regular(&self, fan: &Fan) -> bool {
        match (self.role[fan.vertex as usize], fan.closed) {
            (Role::Smooth, true) => fan.spokes.len() == 4,
            (Role::Border, false) => fan.spokes.len() == 2,
            (Role::Corner, false) => fan.spokes.len() == 1,
            _ => false,
        }
    }

    fn find_fans(&mut self) {
        let mut first: Vec<(u32, bool, u32)> = Vec::with_capacity(self.opposite.len());
        for h in 0..self.opposite.len() as u32 {
            first.push((self.start(h), self.opposite[h as usize] != NONE, h));
        }
        // Fans with a border begin there.
        first.sort_unstable();
        for (vertex, inside, h) in first {
            if self.fan_of[h as usize] != NONE {
                continue;
            }
            let mut fan = Fan { vertex, spokes: Vec::new(), closed: inside };
            let mut spoke = h;
            while spoke != NONE && self.fan_of[spoke as usize] == NONE {
                self.fan_of[spoke as usize] = self.fans.len() as u32;
                fan.spokes.push(spoke);
                spoke = self.opposite[previous(spoke) as usize];
            }
            self.fans.push(fan);
        }
    }

    fn find_roles(&mut self, points: &[DVec3]) {
        let mut borders: Vec<Vec<u32>> = vec![Vec::new(); points.len()];
        let mut seen = vec![false; self.ends.len()];
        for (h, &edge) in self.edge.iter().enumerate() {
            if self.opposite[h] == NONE && !std::mem::replace(&mut seen[edge as usize], true) {
                let [a, b] = self.ends[edge as usize];
                borders[a as usize].push(b);
                borders[b as usize].push(a);
            }
        }
        for (v, others) in borders.iter().enumerate() {
            let p = points[v];
            self.role[v] = match **others {
                [] => Role::Smooth,
                [_] => Role::Dart,
                [a, b] => {
                    let along = [p - points[a as usize], points[b as usize] - p].map(DVec3::normalize_or_zero);
                    if along[0].dot(along[1]) < CORNER_COSINE { Role::Corner } else { Role::Border }
                }
                _ => Role::Corner,
            };
        }
        // A quad with one corner on a border that runs on would have no angle there.
        for fan in &self.fans {
            if fan.spokes.len() == 1 && self.role[fan.vertex as usize] == Role::Border {
                self.role[fan.vertex as usize] = Role::Corner;
            }
        }
    }
}
