//! The triangles of a conditioned mesh with their reference directions, the edges between them, and the fans around
//! vertices.

use super::condition::Conditioned;
use crate::error::{Error, Result};
use crate::geometry::normals::unit;
use crate::mesh::{NONE, Triangles, unit_sized};
use crate::numeric::sparse::Complex;
use glam::DVec3;
use std::f64::consts::PI;

/// Least and largest weight of an edge, as |e| over the length of its dual edge, which has no unit: slivers would get
/// weights near zero or without bound, and solves would lose their digits.
const WEIGHT_RANGE: [f64; 2] = [0.1, 10.0];

/// The triangles around a vertex, or between two consecutive features there, counter-clockwise.
pub struct Fan {
    pub vertex: u32,
    /// All around: the vertex is on no feature.
    pub closed: bool,
    /// Sum of the angles, in radians.
    pub angle: f64,
    /// The corners: `corners[range]` of [`Dual`].
    range: std::ops::Range<usize>,
}

/// An edge that a fan crosses.
#[derive(Debug, Clone, Copy)]
pub struct Spoke {
    /// Number of the edge.
    pub edge: u32,
    /// 1 where the fan crosses it as it is listed, −1 else.
    pub sign: f64,
    /// The vertex at its other end, and the fan there that crosses it, too.
    pub far: u32,
    pub far_fan: u32,
}

/// The dual graph.
pub struct Dual<'a> {
    pub triangles: Triangles<'a>,
    pub feature: &'a [bool],
    /// Unit reference direction b of every triangle, along its feature edge where it has one; and n × b.
    pub x: Vec<DVec3>,
    pub y: Vec<DVec3>,
    /// Whether a triangle has a feature edge.
    pub constrained: Vec<bool>,
    /// Angle of the half-edge that leaves a corner, from the reference.
    pub angle: Vec<f64>,
    /// Inner edges that are no features, as the half-edge with the smaller number.
    pub edges: Vec<u32>,
    /// Edge of every half-edge, or [`NONE`].
    pub edge_of: Vec<u32>,
    /// c of every edge, from the triangle of its half-edge to the other: equation 1.
    pub turn: Vec<f64>,
    pub weight: Vec<f64>,
    pub areas: Vec<f64>,
    /// What every triangle is drawn to: e^{4iα}, times the weight that it has.
    pub wanted: Vec<Complex>,
    pub fans: Vec<Fan>,
    /// Fan of every corner.
    pub fan_of: Vec<u32>,
    corners: Vec<u32>,
}

/// An angle in (−π, π].
pub fn wrap(angle: f64) -> f64 {
    angle - 2.0 * PI * ((angle - PI) / (2.0 * PI)).ceil()
}

impl<'a> Dual<'a> {
    pub fn new(conditioned: &'a Conditioned) -> Result<Self> {
        let Some(t) = Triangles::of(&conditioned.mesh) else {
            return Err(Error::Bug("a conditioned mesh has a polygon".into()));
        };
        let feature = &conditioned.feature;
        let count = t.len() as u32;
        let mut dual = Dual {
            triangles: t,
            feature,
            x: Vec::with_capacity(t.len()),
            y: Vec::with_capacity(t.len()),
            constrained: Vec::with_capacity(t.len()),
            angle: Vec::with_capacity(3 * t.len()),
            edges: Vec::new(),
            edge_of: vec![NONE; 3 * t.len()],
            turn: Vec::new(),
            weight: Vec::new(),
            areas: Vec::with_capacity(t.len()),
            wanted: vec![Complex::new(0.0, 0.0); t.len()],
            fans: Vec::new(),
            fan_of: vec![NONE; 3 * t.len()],
            corners: Vec::with_capacity(3 * t.len()),
        };
        (0..count).for_each(|i| dual.add_triangle(i));
        (0..3 * count).for_each(|c| dual.add_edge(c));
        (0..3 * count).for_each(|c| dual.add_fan(c));
        Ok(dual)
    }

    fn along(&self, c: u32) -> DVec3 {
        self.triangles.point(self.triangles.next(c)) - self.triangles.point(c)
    }

    fn add_triangle(&mut self, i: u32) {
        let own = [3 * i, 3 * i + 1, 3 * i + 2];
        let constraint = own.into_iter().find(|&c| self.feature[c as usize]);
        let area = self.along(own[0]).cross(self.along(own[1]));
        // However small a triangle is beside the others, its frame has the length one.
        let normal = unit_sized(own.map(|c| self.triangles.point(c))).map_or(DVec3::ZERO, |[_, b, c]| b.cross(c));
        let x = unit(self.along(constraint.unwrap_or(own[0]))).normalize_or(DVec3::X);
        // Far from the origin the corners of a small triangle may be rounded onto a line: any frame along it will do.
        let y = unit(normal.cross(x)).try_normalize().unwrap_or_else(|| x.any_orthonormal_vector());
        self.angle.extend(own.map(|c| self.along(c).dot(y).atan2(self.along(c).dot(x))));
        self.constrained.push(constraint.is_some());
        self.areas.push(area.length() / 2.0);
        self.x.push(x);
        self.y.push(y);
    }

    fn add_edge(&mut self, c: u32) {
        let o = self.triangles.opposite(c);
        if o == NONE || o < c || self.feature[c as usize] {
            return;
        }
        let edge = self.edges.len() as u32;
        (self.edge_of[c as usize], self.edge_of[o as usize]) = (edge, edge);
        self.edges.push(c);
        self.turn.push(wrap(self.angle[c as usize] - self.angle[o as usize] - PI));
        let length = self.along(c).length();
        let heights = 2.0 * (self.areas[c as usize / 3] + self.areas[o as usize / 3]);
        let weight = 3.0 * length * length / heights;
        self.weight.push(if weight.is_finite() {
            weight.clamp(WEIGHT_RANGE[0], WEIGHT_RANGE[1])
        } else {
            WEIGHT_RANGE[1]
        });
    }

    /// The fan that a corner belongs to, if it is new.
    fn add_fan(&mut self, corner: u32) {
        if self.fan_of[corner as usize] != NONE {
            return;
        }
        let t = self.triangles;
        // Back to the first feature, or all around.
        let mut first = corner;
        let closed = loop {
            if self.edge_of[first as usize] == NONE {
                break false;
            }
            first = t.next(t.opposite(first));
            if first == corner {
                break true;
            }
        };
        let (from, mut c, mut angle) = (self.corners.len(), first, 0.0);
        loop {
            self.fan_of[c as usize] = self.fans.len() as u32;
            self.corners.push(c);
            angle += self.corner_angle(c);
            let last = t.previous(c);
            if self.edge_of[last as usize] == NONE {
                break;
            }
            c = t.opposite(last);
            if c == first {
                break;
            }
        }
        self.fans.push(Fan { vertex: t.vertex(corner), closed, angle, range: from..self.corners.len() });
    }

    /// From the reference angles, so that what goes around a vertex adds up to rounding.
    fn corner_angle(&self, c: u32) -> f64 {
        let in_edge = self.angle[self.triangles.previous(c) as usize] + PI;
        let angle = wrap(in_edge - self.angle[c as usize]);
        if angle < 0.0 { angle + 2.0 * PI } else { angle }
    }

    /// The direction that a triangle is drawn to, nearest to an angle, and its weight; `None`: there is none.
    pub fn wanted_near(&self, i: usize, alpha: f64) -> Option<(f64, f64)> {
        let wanted = self.wanted[i];
        let weight = wanted.re.hypot(wanted.im);
        (weight > 0.0).then(|| (alpha + wrap(wanted.im.atan2(wanted.re) - 4.0 * alpha) / 4.0, weight))
    }

    /// The corners of a fan, counter-clockwise.
    pub fn corners(&self, fan: &Fan) -> &[u32] {
        &self.corners[fan.range.clone()]
    }

    /// The edges that a fan crosses, counter-clockwise; a closed one ends where it began.
    pub fn spokes<'b>(&'b self, fan: &'b Fan) -> impl Iterator<Item = Spoke> + 'b {
        let t = self.triangles;
        let crossed = self.corners(fan).iter().map(move |&c| t.previous(c));
        crossed.filter(|&h| self.edge_of[h as usize] != NONE).map(move |h| {
            let edge = self.edge_of[h as usize];
            Spoke {
                edge,
                sign: if self.edges[edge as usize] == h { 1.0 } else { -1.0 },
                far: t.vertex(h),
                far_fan: self.fan_of[h as usize],
            }
        })
    }

    /// The two triangles of an edge, in its order.
    pub fn ends(&self, edge: usize) -> [u32; 2] {
        let c = self.edges[edge];
        [c / 3, self.triangles.opposite(c) / 3]
    }

    /// Sum of a value of the edges around a fan.
    pub fn around(&self, fan: &Fan, value: impl Fn(u32) -> f64) -> f64 {
        self.spokes(fan).map(|s| s.sign * value(s.edge)).sum()
    }
}
