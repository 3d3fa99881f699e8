//! The border of a face in the parameter plane of its surface, unrolled.
//!
//! Loops are followed along samples of their edges: each sample is projected onto the surface from the one before, which
//! keeps angles in one piece. A loop that turns round at a pole, where u has no value, gets the piece of the line v = const
//! that stands for the pole:
//!
//! ```text
//!   v    u_out ◄─────── u_in        both ends are the pole
//!   ▲      │             ▲
//!   │      ▼ seam        │ seam     the material lies to the left
//!   │      └─────►───────┘ ring
//!   └────────► u
//! ```

use super::surface::Surface;
use super::{Brep, Edge, EdgeUse, Face};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Steps longer than this share of a period are divided, so that the sense of a turn is certain.
const LARGEST_STEP: f64 = 0.2;
/// Most divisions of a step.
const MAX_DIVISIONS: u32 = 10;
/// Where the angle of an edge at a pole is taken: this share of its first piece away from the pole.
const BESIDE_POLE: f64 = 1e-3;
/// Angles in radians that are none at a pole: the face then goes all the way round.
const NO_ANGLE: f64 = 1e-6;

/// Parameters of an edge at which it is sampled, with the points there; the first and the last are its ends.
#[derive(Debug, Clone, Default)]
pub(crate) struct EdgeSamples {
    pub parameters: Vec<f64>,
    pub points: Vec<DVec3>,
    /// What the samples are called: the same for all edges that end in a vertex.
    pub ids: Vec<u32>,
}

/// A sample of a loop.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sample {
    /// In the parameter plane.
    pub uv: DVec2,
    /// As in [`EdgeSamples::ids`].
    pub id: u32,
    /// The edge that leads here; `u32::MAX` along a pole.
    pub edge: u32,
    /// Its parameters at the sample before and here.
    pub span: [f64; 2],
}

/// A loop in the parameter plane. The last sample is that of the vertex where the loop began: it has the parameters of
/// the first one if the loop is closed there, and is a period away if the loop winds round the surface.
#[derive(Debug, Clone, Default)]
pub(crate) struct Ring {
    pub samples: Vec<Sample>,
}

impl Ring {
    /// How far the end is from the beginning.
    pub fn gap(&self) -> DVec2 {
        match (self.samples.first(), self.samples.last()) {
            (Some(a), Some(b)) => b.uv - a.uv,
            _ => DVec2::ZERO,
        }
    }

    /// Twice the signed area.
    pub fn area(&self) -> f64 {
        let Some(first) = self.samples.first() else { return 0.0 };
        self.samples.windows(2).map(|w| (w[0].uv - first.uv).perp_dot(w[1].uv - first.uv)).sum()
    }
}

/// Unrolls all loops of a face; those of a surface that is periodic in u are moved by whole periods next to the first. `samples`
/// are those of all edges.
pub(crate) fn unroll(brep: &Brep, face: &Face, samples: &[EdgeSamples]) -> Vec<Ring> {
    let surface = brep.surface(face);
    let mut rings: Vec<Ring> = face
        .loops
        .iter()
        .map(|uses| Walk { brep, face, surface, ring: Ring::default() }.along(uses, samples))
        .collect();
    gather(&mut rings, surface.periods());
    rings
}

/// Moves holes by whole periods into the outer loop's box.
fn gather(rings: &mut [Ring], periods: [Option<f64>; 2]) {
    let range = |ring: &Ring, k: usize| {
        let values = ring.samples.iter().map(|s| s.uv[k]);
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], x| [l.min(x), h.max(x)])
    };
    for (k, period) in periods.into_iter().enumerate() {
        let (Some(period), Some((outer, holes))) = (period, rings.split_first_mut()) else { continue };
        let [low, high] = range(outer, k);
        for hole in holes {
            let [a, b] = range(hole, k);
            let (middle, size) = (0.5 * (a + b), 0.5 * (b - a));
            // The period in which the hole sticks out of the outer loop's box least.
            let turns = ((0.5 * (low + high) - middle) / period).round();
            let sticks_out = |t: f64| {
                let at = middle + t * period;
                (low - (at - size)).max(at + size - high)
            };
            let best =
                [turns, turns - 1.0, turns + 1.0].into_iter().min_by(|a, b| sticks_out(*a).total_cmp(&sticks_out(*b)));
            let shift = best.unwrap_or(turns) * period;
            hole.samples.iter_mut().for_each(|s| s.uv[k] += shift);
        }
    }
}

/// Follows a loop from sample to sample.
struct Walk<'a> {
    brep: &'a Brep,
    face: &'a Face,
    surface: &'a Surface,
    ring: Ring,
}

impl Walk<'_> {
    fn along(mut self, uses: &[EdgeUse], samples: &[EdgeSamples]) -> Ring {
        // A loop does not begin at a pole where it can begin elsewhere.
        let off_pole = |of: &EdgeUse| !self.surface.is_pole(self.brep.point(self.brep.start(of)));
        let first = uses.iter().position(off_pole).unwrap_or(0);
        for k in 0..uses.len() {
            let of = &uses[(first + k) % uses.len()];
            self.follow(of, &samples[of.edge as usize]);
        }
        self.close();
        self.ring
    }

    /// Appends the samples of one use.
    fn follow(&mut self, of: &EdgeUse, along: &EdgeSamples) {
        let edge = &self.brep.edges[of.edge as usize];
        let n = along.points.len();
        for j in 0..n {
            let s = if of.reversed { n - 1 - j } else { j };
            let t = along.parameters[s];
            let before = along.parameters[if j == 0 {
                s
            } else if of.reversed {
                s + 1
            } else {
                s - 1
            }];
            let last = self.ring.samples.last().map(|l| l.uv);
            let uv = match (last, j) {
                _ if !of.parameters.is_empty() => given(edge, of, t),
                (Some(at), 1..) => self.step(edge, at, before, t, 0),
                (None, _) | (Some(_), 0) => {
                    let next = along.parameters[if of.reversed { n - 2 } else { 1 }];
                    self.begin(edge, last, t, next)
                }
            };
            // Edges end next to their vertices only: a walk from one end to the other would be a spike across the loop.
            let end = [0, n - 1].iter().position(|&e| e == s).map(|e| self.brep.point(edge.ends[e]));
            let uv = match end {
                Some(p) if of.parameters.is_empty() && !self.surface.is_pole(p) => {
                    DVec2::from(self.surface.project_near(p, uv.into()))
                }
                _ => uv,
            };
            // The first sample of a use is the last of the one before, except at a pole and where parameters are given.
            let moved = last.is_none_or(|l| {
                let size = uv.abs().max(l.abs()).max_element();
                l.distance(uv) > 1e-9 * size.max(1e-3)
            });
            if j > 0 || moved {
                let edge = if j > 0 { of.edge } else { u32::MAX };
                self.ring.samples.push(Sample { uv, id: along.ids[s], edge, span: [before, t] });
            }
        }
    }

    /// The parameters with which an edge leaves its first point.
    fn begin(&self, edge: &Edge, last: Option<DVec2>, t: f64, next: f64) -> DVec2 {
        let p = edge.curve.point(t);
        if self.surface.is_pole(p) {
            let beside = edge.curve.point(t + BESIDE_POLE * (next - t));
            let [u, _] = self.surface.project(beside);
            let v = last.map_or_else(|| self.surface.project(p)[1], |l| l.y);
            return DVec2::new(last.map_or(u, |l| self.jump(l, u)), v);
        }
        match last {
            Some(at) => DVec2::from(self.surface.project_near(p, at.into())),
            None => DVec2::from(self.surface.project(p)),
        }
    }

    /// The parameters of the next sample, in steps that are short against the periods.
    fn step(&self, edge: &Edge, at: DVec2, from: f64, to: f64, depth: u32) -> DVec2 {
        let p = edge.curve.point(to);
        let mut uv = DVec2::from(self.surface.project_near(p, at.into()));
        if let Surface::Spline(s) = self.surface {
            // A search that did not get there begins anew; an edge is as far from its surface as its tolerance says.
            let off = s.point(uv.x, uv.y).distance(p);
            if off > edge.tolerance + 1e-6 * p.distance(edge.curve.point(from)) {
                let other = DVec2::from(self.surface.project(p));
                if s.point(other.x, other.y).distance(p) < 0.1 * off {
                    uv = other;
                }
            }
            return uv;
        }
        let far = (0..2).any(|k| self.surface.periods()[k].is_some_and(|p| (uv[k] - at[k]).abs() > LARGEST_STEP * p));
        if far && depth < MAX_DIVISIONS {
            let middle = 0.5 * (from + to);
            let half = self.step(edge, at, from, middle, depth + 1);
            return self.step(edge, half, middle, to, depth + 1);
        }
        uv
    }

    /// The angle at which a loop that came to a pole at `at` leaves it in the direction `u`: on the side where the material
    /// is not. At the upper end of v, material to the left of a walk towards −u is below.
    fn jump(&self, at: DVec2, u: f64) -> f64 {
        let samples = &self.ring.samples;
        let before = samples.iter().rev().map(|s| s.uv.y).find(|&v| v != at.y).unwrap_or(at.y - 1.0);
        let sense = if (before < at.y) == self.face.same_sense { -1.0 } else { 1.0 };
        let turn = (sense * (u - at.x)).rem_euclid(TAU);
        at.x + sense * if (NO_ANGLE..=TAU - NO_ANGLE).contains(&turn) { turn } else { TAU }
    }

    /// A loop that begins at a pole ends there, too: a piece of the pole closes it.
    fn close(&mut self) {
        let (Some(first), Some(last)) = (self.ring.samples.first().copied(), self.ring.samples.last().copied()) else {
            return;
        };
        let off = first.id == last.id && (last.uv.x - first.uv.x).abs() > NO_ANGLE;
        if off && self.surface.is_pole(self.surface.point(first.uv.x, first.uv.y)) {
            let uv = DVec2::new(self.jump(last.uv, first.uv.x), first.uv.y);
            self.ring.samples.push(Sample { uv, id: first.id, edge: u32::MAX, span: [0.0; 2] });
        }
    }
}

/// The parameters of a use at a parameter of its edge, where they are given.
fn given(edge: &Edge, of: &EdgeUse, t: f64) -> DVec2 {
    let points = &of.parameters;
    let last = points.len() - 1;
    let between = |k: usize, s: f64| DVec2::from(points[k]).lerp(DVec2::from(points[(k + 1).min(last)]), s);
    if let (super::Curve::Spline(c), true) = (&edge.curve, last > 1) {
        // One for each control point of an edge of degree 1.
        let breaks = c.knots().breaks();
        let k = breaks.partition_point(|&b| b <= t).clamp(1, last.min(breaks.len() - 1)) - 1;
        return between(k, (t - breaks[k]) / (breaks[k + 1] - breaks[k]));
    }
    let [a, b] = edge.range;
    between(0, if b > a { (t - a) / (b - a) } else { 0.0 })
}
