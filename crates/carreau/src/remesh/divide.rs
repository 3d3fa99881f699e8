//! Splits edges that are too long at the point where both halves have the same length, on the surface or on their
//! curve.

use super::curves::{Kind, Rank};
use super::size::Metric;
use super::work::{Face, Work};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::normals::unit;
use crate::mesh::{NONE, next, previous};
use glam::DVec3;

/// Splits make no shapes below this, unless the triangle was as bad before.
const NEEDLE: f32 = 0.01;
/// And none below this where a ridge would leave its place: two ridges may nearly touch.
const THIN: f32 = 1e-3;

impl Work<'_> {
    /// Splits edges longer than `limit`, longest first within each sweep. Returns how many.
    pub fn divide(&mut self, limit: f64, sweeps: usize, context: &Context) -> Result<usize> {
        self.divide_while(limit, sweeps, usize::MAX, context)
    }

    /// One sweep, which ends at a number of triangles.
    pub fn divide_to(&mut self, limit: f64, wanted: usize, context: &Context) -> Result<usize> {
        self.divide_while(limit, 1, wanted, context)
    }

    fn divide_while(&mut self, limit: f64, sweeps: usize, wanted: usize, context: &Context) -> Result<usize> {
        let mut done = 0;
        for _ in 0..sweeps {
            let mut long: Vec<(u64, u32)> = self
                .mesh
                .edges()
                .map(|h| (self.edge_length(h), h))
                .filter(|&(l, _)| l > limit)
                .map(|(l, h)| (l.to_bits(), h))
                .collect();
            long.sort_unstable_by(|a, b| b.cmp(a));
            let before = done;
            for (step, &(bits, h)) in long.iter().enumerate() {
                context.check_every(step)?;
                if self.mesh.triangle_count() >= wanted {
                    return Ok(done);
                }
                if self.mesh.is_half_edge(h) && self.edge_length(h).to_bits() == bits && self.split(h).is_some() {
                    done += 1;
                }
            }
            if done == before {
                break;
            }
        }
        Ok(done)
    }

    /// Splits an edge in two of equal length; `None` where that is not allowed or would fold the surface.
    pub fn split(&mut self, h: u32) -> Option<u32> {
        let (a, b) = (self.mesh.vertex(h), self.mesh.head(h));
        let (root_a, root_b) = (self.size[a as usize].sqrt(), self.size[b as usize].sqrt());
        let t = root_a / (root_a + root_b);
        if self.mesh.curve(h) != NONE {
            return self.split_curve(h, t, false);
        }
        let p = self.point(a).lerp(self.point(b), t);
        let mut spot = self.spot(self.seat[self.mesh.wedge(h) as usize], p);
        // Where the surface folds, half way to it will do, or the edge itself with the normals of its ends.
        let [m, n] = [h, next(h)].map(|c| self.normal[self.mesh.wedge(c) as usize]);
        let ways = [(spot.point, spot.normal), (0.5 * (p + spot.point), spot.normal), (p, unit(m + n))];
        let held = ways.into_iter().find(|&(at, normal)| self.split_follows(h, at, [normal; 2]));
        // Beyond the cap: with the normal of the two faces, which stay as they are, nothing gets worse.
        let flat = || self.normal_across(h).filter(|&n| self.flat_split_holds(h, p, n)).map(|n| (p, n));
        (spot.point, spot.normal) = held.or_else(flat)?;
        let wedge = self.add_wedge(&spot);
        let m = self.mesh.split(h, spot.point, [wedge; 2]);
        self.add_vertex(Rank::Free, spot.metric, 0.0);
        self.refresh_around(m);
        Some(m)
    }

    /// Whether a vertex on an edge itself, with this normal, leaves the worst angles and no needles.
    fn flat_split_holds(&self, h: u32, p: DVec3, n: DVec3) -> bool {
        self.halves_hold(h, p, [n; 2], no_needle, |new, before| new >= before - 1e-6)
    }

    /// Whether a split makes triangles of the least shape that goes with the shape before, and with worst cosines that, after and
    /// before, are as they must be.
    fn halves_hold(
        &self,
        h: u32,
        p: DVec3,
        normals: [DVec3; 2],
        least: fn(f32) -> f32,
        may_follow: impl Fn(f32, f32) -> bool,
    ) -> bool {
        let sides = [h, self.mesh.opposite(h)].into_iter().zip(normals).filter(|s| s.0 != NONE);
        sides.into_iter().all(|(side, n)| {
            let before = self.face[side as usize / 3];
            let halves = self.halves(side, p, n);
            halves.iter().all(|new| new.shape >= least(before.shape) && may_follow(new.cosine, before.cosine))
        })
    }

    /// The two triangles that a split leaves on one side of an edge.
    fn halves(&self, side: u32, p: DVec3, n: DVec3) -> [Face; 2] {
        let mesh = &self.mesh;
        let corners = [side, next(side), previous(side)];
        let [a, b, c] = corners.map(|x| self.point(mesh.vertex(x)));
        let [na, nb, nc] = corners.map(|x| self.normal[mesh.wedge(x) as usize]);
        let [wa, wb, wc] = self.stretches(corners.map(|x| mesh.vertex(x)));
        [self.judge([a, p, c], [na, n, nc], [wa, wa, wc]), self.judge([p, b, c], [n, nb, nc], [wb, wb, wc])]
    }

    /// The mean of the normals of the two faces of an edge.
    fn normal_across(&self, h: u32) -> Option<DVec3> {
        let o = self.mesh.opposite(h);
        (o != NONE).then(|| unit(self.face_normal(h / 3) + self.face_normal(o / 3)))
    }

    /// Splits an edge of a curve at a share of its way; `urgent`: needles are no obstacle, nor is constraint (1) but for its cap.
    pub fn split_curve(&mut self, h: u32, t: f64, urgent: bool) -> Option<u32> {
        let (chain, [s0, s1]) = self.on_chain(h)?;
        if chain.kind == Kind::Seam {
            return None;
        }
        let s = s0 + t * (s1 - s0);
        let [mut left, mut right] = self.chain_spots(chain, s);
        if s1 < s0 {
            (left, right) = (right, left);
        }
        // On a border one side is missing on the source and on the mesh alike.
        let left = left?;
        let normals = [left.normal, right.map_or(left.normal, |r| r.normal)];
        if right.is_some() != (self.mesh.opposite(h) != NONE) {
            return None;
        }
        let cap = self.limits.cos_cap as f32;
        let holds = if urgent {
            self.split_holds(h, left.point, normals, |_| THIN, |new, before| new >= cap.min(before))
        } else {
            self.split_follows(h, left.point, normals)
        };
        if !holds {
            return None;
        }
        let wedge_left = self.add_wedge(&left);
        let wedge_right = right.map_or(NONE, |r| self.add_wedge(&r));
        let size = right.map_or(left.metric.size, |r| r.metric.size.min(left.metric.size));
        let m = self.mesh.split(h, left.point, [wedge_left, wedge_right]);
        self.add_vertex(Rank::Curve, Metric { size, stretch: DVec3::ZERO }, chain.wrapped(s));
        self.refresh_around(m);
        Some(m)
    }

    /// Whether the new triangles keep constraint (1), or are no worse than the old ones, and none degenerates or folds.
    fn split_follows(&self, h: u32, p: DVec3, normals: [DVec3; 2]) -> bool {
        self.split_holds(h, p, normals, no_needle, |new, before| self.allows_cosine(new, before))
    }

    /// As [`Self::halves_hold`], and no edge loses its nature.
    fn split_holds(
        &self,
        h: u32,
        p: DVec3,
        normals: [DVec3; 2],
        least: fn(f32) -> f32,
        may_follow: impl Fn(f32, f32) -> bool,
    ) -> bool {
        self.halves_hold(h, p, normals, least, may_follow) && {
            let (before, after) = self.strain_of_split(h, p);
            after.may_follow(before)
        }
    }
}

/// The least shape of the halves of a triangle of this shape.
fn no_needle(before: f32) -> f32 {
    (0.2 * before).max(before.min(NEEDLE))
}
