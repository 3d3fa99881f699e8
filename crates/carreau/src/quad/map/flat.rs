//! The flat metric of the map as an intrinsic triangulation: every face keeps its edges as vectors in its own frame, how frames
//! turn across edges, and at every corner the direction of its edge in the star of the working mesh (signposts; Sharp, Soliman,
//! Crane: *Navigating intrinsic triangulations*, 2019). Once numbers are chosen, every edge has an integer vector, too.

use super::cell::Cell;
use super::framed::{Framed, next, previous, turned};
use super::seamless::Map;
use crate::mesh::NONE;
use glam::DVec2;

/// A half-edge with what belongs to it.
#[derive(Debug, Clone, Copy)]
pub struct Side {
    /// The vertex that it leaves.
    pub vertex: u32,
    /// In the frame of its face.
    pub vector: DVec2,
    /// The same as a number of cells.
    pub cells: Cell,
    /// Its angle at the vertex, in the star of the working mesh.
    pub post: f64,
    /// Curve of features, or [`NONE`].
    pub curve: u32,
    /// The half-edge across, or [`NONE`], and the turn of frames on the way there.
    pub opposite: u32,
    pub turn: i32,
}

/// The triangulation.
#[derive(Debug, Clone)]
pub struct Flat {
    /// Half-edge 3f + k.
    pub sides: Vec<Side>,
    pub region: Vec<u32>,
    pub is_alive: Vec<bool>,
    /// A half-edge that leaves every vertex; [`NONE`] where it was removed.
    pub at: Vec<u32>,
}

impl Side {
    /// The same in another frame.
    pub fn turned(self, by: i32) -> Self {
        Side { vector: turned(self.vector, by), cells: self.cells.turned(by), ..self }
    }
}

/// Where an edge of a face has gone: half-edge, and the turn from its old frame to the new one.
pub type Moved = (u32, u32, i32);

impl Flat {
    /// The triangles of the working mesh in the metric of its map.
    pub fn new(framed: &Framed, map: &Map) -> Self {
        let side = |h: u32| Side {
            vertex: framed.tail(h),
            vector: map.along(h),
            cells: Cell::ZERO,
            post: 0.0,
            curve: framed.curve[h as usize],
            opposite: framed.opposite[h as usize],
            turn: map.turn[h as usize],
        };
        let mut flat = Flat {
            sides: (0..map.uv.len() as u32).map(side).collect(),
            region: framed.region.clone(),
            is_alive: vec![true; framed.triangles.len()],
            at: vec![NONE; framed.points.len()],
        };
        for h in 0..flat.sides.len() as u32 {
            if flat.at[framed.tail(h) as usize] != NONE {
                continue;
            }
            let (fan, _) = framed.fan(h);
            flat.at[framed.tail(h) as usize] = fan[0];
            let mut post = 0.0;
            for h in fan {
                flat.sides[h as usize].post = post;
                post += flat.corner_angle(h);
            }
        }
        flat
    }

    /// The angle between a half-edge and the one before it.
    pub fn corner_angle(&self, h: u32) -> f64 {
        self.side(h).vector.angle_to(-self.side(previous(h)).vector)
    }

    #[inline]
    pub fn side(&self, h: u32) -> &Side {
        &self.sides[h as usize]
    }

    /// The faces that are left.
    pub fn faces(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.is_alive.len() as u32).filter(|&f| self.is_alive[f as usize])
    }

    /// A half-edge of every edge on a feature curve.
    pub fn on_curves(&self) -> impl Iterator<Item = u32> + '_ {
        let is_first = |h: &u32| {
            let side = self.side(*h);
            side.curve != NONE && (side.opposite == NONE || *h < side.opposite)
        };
        self.faces().flat_map(|f| 3 * f..3 * f + 3).filter(is_first)
    }

    /// The edges of quads along each of the first so many feature curves.
    pub fn edges_of_curves(&self, curves: usize) -> Vec<i64> {
        let mut edges = vec![0; curves];
        for side in self.on_curves().map(|h| self.side(h)) {
            if let Some(edges) = edges.get_mut(side.curve as usize) {
                *edges += side.cells.steps();
            }
        }
        edges
    }

    /// Twice the area of a face.
    pub fn area(&self, f: u32) -> f64 {
        self.side(3 * f).vector.perp_dot(self.side(3 * f + 1).vector)
    }

    /// Twice its number of cells.
    pub fn cells(&self, f: u32) -> i64 {
        self.side(3 * f).cells.cross(self.side(3 * f + 1).cells)
    }

    /// The half-edges that leave a vertex, counter-clockwise, and whether they go all around; from border to border else.
    pub fn star(&self, v: u32) -> Option<(Vec<u32>, bool)> {
        let start = self.at[v as usize];
        if start == NONE {
            return None;
        }
        let mut first = start;
        let is_closed = loop {
            let o = self.side(first).opposite;
            if o == NONE {
                break false;
            }
            first = next(o);
            if first == start {
                break true;
            }
        };
        let (mut all, mut at) = (vec![first], first);
        loop {
            at = self.side(previous(at)).opposite;
            if at == NONE || at == first {
                return Some((all, is_closed));
            }
            all.push(at);
        }
    }

    /// The two faces after a flip, in the frame of the first, if it may be done at all.
    ///
    /// ```text
    ///     c               c
    ///    ╱ ╲             ╱│╲
    ///   ╱ h ╲           ╱ │ ╲
    ///  a─────b    →    a  │  b
    ///   ╲ o ╱           ╲ │ ╱
    ///    ╲ ╱             ╲│╱
    ///     d               d
    /// ```
    pub fn flipped(&self, h: u32) -> Option<[[Side; 3]; 2]> {
        let o = self.side(h).opposite;
        if o == NONE || o / 3 == h / 3 || self.side(h).curve != NONE {
            return None;
        }
        let back = -self.side(h).turn;
        let (bc, ca) = (*self.side(next(h)), *self.side(previous(h)));
        let (ad, db) = (self.side(next(o)).turned(back), self.side(previous(o)).turned(back));
        let (vector, cells) = (db.vector + bc.vector, db.cells + bc.cells);
        let (f, g) = (h / 3 * 3, o / 3 * 3);
        let dc = Side {
            vertex: db.vertex,
            vector,
            cells,
            post: db.post + db.vector.angle_to(vector),
            curve: NONE,
            opposite: g + 2,
            turn: 0,
        };
        let cd = Side {
            vertex: ca.vertex,
            vector: -vector,
            cells: -cells,
            post: ca.post + ca.vector.angle_to(-vector),
            opposite: f + 1,
            ..dc
        };
        Some([[ad, dc, ca], [db, bc, cd]])
    }

    /// Flips an edge if both faces have more than an area then.
    pub fn flip(&mut self, h: u32, least: f64) -> bool {
        let Some([a, b]) = self.flipped(h) else { return false };
        let area = |s: &[Side; 3]| s[0].vector.perp_dot(s[1].vector);
        if area(&a) <= least || area(&b) <= least {
            return false;
        }
        let (o, turn) = (self.side(h).opposite, self.side(h).turn);
        let (f, g) = (h / 3 * 3, o / 3 * 3);
        let moved = [(next(h), g + 1, 0), (previous(h), f + 2, 0), (next(o), f, -turn), (previous(o), g, -turn)];
        for k in 0..3 {
            (self.sides[f as usize + k], self.sides[g as usize + k]) = (a[k], b[k]);
        }
        self.relink(&moved);
        for h in [f, f + 1, f + 2, g, g + 1, g + 2] {
            let v = self.side(h).vertex;
            self.at[v as usize] = h;
        }
        true
    }

    /// Tells the neighbours of edges that have gone elsewhere; what they hold themselves is of before.
    pub fn relink(&mut self, moved: &[Moved]) {
        let before: Vec<(u32, i32)> = moved.iter().map(|m| (self.side(m.1).opposite, self.side(m.1).turn)).collect();
        for (&(_, h, by), (o, turn)) in moved.iter().zip(before) {
            let to = moved.iter().find(|m| m.0 == o);
            let (opposite, turn) = match to {
                Some(&(_, other, other_by)) => (other, turn - by + other_by),
                None => (o, turn - by),
            };
            let turn = turn.rem_euclid(4);
            self.sides[h as usize].opposite = opposite;
            self.sides[h as usize].turn = turn;
            if opposite != NONE && to.is_none() {
                self.sides[opposite as usize].opposite = h;
                self.sides[opposite as usize].turn = (-turn).rem_euclid(4);
            }
        }
    }
}
