//! The working mesh with a frame in every triangle: frames continue across all inner edges, those on features too, where the
//! frames of both sides have an axis along the edge.

use super::super::coarse::Coarse;
use super::super::guidance::Guidance;
use super::super::work::Place;
use super::tuning::GUIDED_WEIGHT;
use crate::field::{Field, below_guides};
use crate::mesh::{NONE, Triangles};
use glam::{DMat2, DVec2, DVec3};
use rustc_hash::{FxHashMap, FxHashSet};

/// Half-edge 3t + k runs from corner k of triangle t to the next.
pub struct Framed {
    pub points: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
    /// The half-edge on the other side; [`NONE`] on borders.
    pub opposite: Vec<u32>,
    /// Directions are turned by so many right angles from the frame of a half-edge's triangle to that across it.
    pub turn: Vec<i32>,
    /// Curve of half-edges on features; [`NONE`] elsewhere.
    pub curve: Vec<u32>,
    /// Corners in the plane of every triangle, and the branches of its frame there, as columns.
    pub local: Vec<[DVec2; 3]>,
    pub frame: Vec<DMat2>,
    pub area: Vec<f64>,
    /// How long edges are to be in every triangle, relative to even ones.
    pub size: Vec<f64>,
    /// How much the frame of every triangle counts beside its area.
    pub weight: Vec<f64>,
    pub region: Vec<u32>,
    /// Quads that the field gives every vertex.
    pub quads: Vec<i32>,
    /// Singularities, and vertices on features where these bend, branch or end.
    pub is_kept: Vec<bool>,
    /// Where vertices on features belong.
    pub place: Vec<Option<Place>>,
}

/// The next half-edge of a triangle.
#[inline]
pub fn next(h: u32) -> u32 {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}

/// The one before.
#[inline]
pub fn previous(h: u32) -> u32 {
    if h.is_multiple_of(3) { h + 2 } else { h - 1 }
}

/// A vector turned by right angles.
#[inline]
pub fn turned(v: DVec2, turn: i32) -> DVec2 {
    match turn.rem_euclid(4) {
        0 => v,
        1 => DVec2::new(-v.y, v.x),
        2 => -v,
        _ => DVec2::new(v.y, -v.x),
    }
}

impl Framed {
    /// Why there is none, else.
    pub fn new(coarse: &Coarse, field: &Field) -> Result<Self, String> {
        let Some(t) = Triangles::of(&field.mesh) else { return Err("the working mesh is not triangular".into()) };
        let curves: FxHashMap<[u32; 2], u32> = coarse.features.iter().map(|&(ends, c)| (sorted(ends), c)).collect();
        let features: FxHashSet<[u32; 2]> = field.features.iter().map(|&ends| sorted(ends)).collect();
        let half_edges = 3 * t.len() as u32;
        let ends = |h: u32| sorted([t.vertex(h), t.vertex(t.next(h))]);
        let mut curve = vec![NONE; half_edges as usize];
        for h in (0..half_edges).filter(|&h| features.contains(&ends(h))) {
            let Some(&found) = curves.get(&ends(h)) else {
                return Err("the features of the working mesh and of its field differ".into());
            };
            curve[h as usize] = found;
        }
        let flat = |i: u32| flattened([0, 1, 2].map(|k| t.point(3 * i + k)));
        let axes: Vec<([DVec3; 2], [DVec2; 3])> = (0..t.len() as u32).map(flat).collect();
        let frame = |i: usize| {
            let in_plane = |d: DVec3| DVec2::new(d.dot(axes[i].0[0]), d.dot(axes[i].0[1]));
            DMat2::from_cols(in_plane(field.u[i]), in_plane(field.v[i]))
        };
        let local: Vec<[DVec2; 3]> = axes.iter().map(|a| a.1).collect();
        let mut framed = Framed {
            points: t.points().to_vec(),
            triangles: (0..t.len() as u32).map(|i| t.triangle(i)).collect(),
            opposite: (0..half_edges).map(|h| t.opposite(h)).collect(),
            turn: vec![0; half_edges as usize],
            curve,
            area: local.iter().map(|p| 0.5 * (p[1] - p[0]).perp_dot(p[2] - p[0])).collect(),
            local,
            frame: (0..t.len()).map(frame).collect(),
            size: vec![1.0; t.len()],
            weight: vec![1.0; t.len()],
            region: field.source.iter().map(|&s| coarse.region[s as usize]).collect(),
            quads: vec![0; t.points().len()],
            is_kept: vec![false; t.points().len()],
            place: vec![None; t.points().len()],
        };
        if framed.area.iter().any(|a| !(*a > 0.0)) || framed.frame.iter().any(|f| !(f.determinant() > 0.05)) {
            return Err("the working mesh has a triangle without area".into());
        }
        framed.add_turns(field)?;
        framed.add_vertices(coarse, field);
        if framed.has_several_fans() {
            return Err("the surface touches itself in a vertex".into());
        }
        Ok(framed)
    }

    fn add_turns(&mut self, field: &Field) -> Result<(), String> {
        let mut matchings = field.matchings.iter();
        for h in 0..self.opposite.len() as u32 {
            let o = self.opposite[h as usize];
            if o == NONE || o < h {
                continue;
            }
            let turn = if self.curve[h as usize] == NONE {
                let matching = matchings.next().filter(|m| m.triangles == [h / 3, o / 3]);
                matching.ok_or("the field and its mesh differ")?.p
            } else {
                // The direction of h is that branch on both sides.
                self.branch_along(o) + 2 - self.branch_along(h)
            };
            (self.turn[h as usize], self.turn[o as usize]) = (turn, -turn);
        }
        Ok(())
    }

    fn add_vertices(&mut self, coarse: &Coarse, field: &Field) {
        let mut sectors: Vec<Vec<i32>> = vec![Vec::new(); self.points.len()];
        for corner in &field.corners {
            self.quads[corner.vertex as usize] += corner.quads;
            match corner.closed {
                true => self.is_kept[corner.vertex as usize] |= corner.quads != 4,
                false => sectors[corner.vertex as usize].push(corner.quads),
            }
        }
        let mut on_border = vec![false; self.points.len()];
        for h in (0..self.opposite.len() as u32).filter(|&h| self.opposite[h as usize] == NONE) {
            on_border[self.tail(h) as usize] = true;
        }
        for h in (0..self.opposite.len() as u32).filter(|&h| self.curve[h as usize] != NONE) {
            for v in [self.tail(h), self.tail(next(h))] {
                self.place[v as usize] = coarse.place.get(v as usize).copied();
            }
        }
        for (v, sectors) in sectors.iter().enumerate().filter(|(_, s)| !s.is_empty()) {
            let is_straight = if on_border[v] { sectors[..] == [2] } else { sectors[..] == [2, 2] };
            self.is_kept[v] |= !is_straight || self.place[v] == Some(Place::Fixed);
        }
    }

    /// Says how long edges are to be, and where they are to keep to their frames.
    pub fn led(mut self, guidance: &Guidance) -> Self {
        if let Some(sizes) = &guidance.sizes {
            let middle = |t: &[u32; 3]| t.iter().map(|&v| self.points[v as usize]).sum::<DVec3>() / 3.0;
            self.size = self.triangles.iter().map(|t| sizes.at(middle(t))).collect();
        }
        let edge = (2.0 * self.area.iter().sum::<f64>() / self.area.len().max(1) as f64).sqrt();
        for (t, _) in below_guides(&self.points, &self.triangles, &guidance.guides, edge) {
            self.weight[t as usize] = GUIDED_WEIGHT;
        }
        self
    }

    /// Whether the corners of a vertex are not all in one fan.
    fn has_several_fans(&self) -> bool {
        let mut corners = vec![0u32; self.points.len()];
        let mut last = vec![NONE; self.points.len()];
        for h in 0..self.opposite.len() as u32 {
            corners[self.tail(h) as usize] += 1;
            last[self.tail(h) as usize] = h;
        }
        (0..self.points.len()).any(|v| last[v] != NONE && self.fan(last[v]).0.len() as u32 != corners[v])
    }

    /// The vertex that a half-edge leaves.
    #[inline]
    pub fn tail(&self, h: u32) -> u32 {
        self.triangles[h as usize / 3][h as usize % 3]
    }

    /// A half-edge in the plane of its triangle.
    pub fn along(&self, h: u32) -> DVec2 {
        let p = &self.local[h as usize / 3];
        p[next(h) as usize % 3] - p[h as usize % 3]
    }

    /// The branch of its triangle's frame that runs along a half-edge, most nearly.
    pub fn branch_along(&self, h: u32) -> i32 {
        let z = self.frame[h as usize / 3].inverse() * self.along(h);
        match z.x.abs() >= z.y.abs() {
            true => i32::from(z.x < 0.0) * 2,
            false => 1 + i32::from(z.y < 0.0) * 2,
        }
    }

    /// The half-edges that leave the vertex of one, counter-clockwise, and whether they go all around; else from border to border.
    pub fn fan(&self, h: u32) -> (Vec<u32>, bool) {
        let mut first = h;
        let is_closed = loop {
            let o = self.opposite[first as usize];
            if o == NONE {
                break false;
            }
            first = next(o);
            if first == h {
                break true;
            }
        };
        let (mut all, mut at) = (vec![first], first);
        loop {
            at = self.opposite[previous(at) as usize];
            if at == NONE || at == first {
                return (all, is_closed);
            }
            all.push(at);
        }
    }
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Axes of a triangle's plane, and its corners there.
fn flattened([a, b, c]: [DVec3; 3]) -> ([DVec3; 2], [DVec2; 3]) {
    let x = (b - a).normalize_or_zero();
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let y = normal.cross(x);
    let flat = |p: DVec3| DVec2::new((p - a).dot(x), (p - a).dot(y));
    ([x, y], [DVec2::ZERO, flat(b), flat(c)])
}
