//! Vertices move to where their edges have length one.
//!
//! Every neighbour Pⱼ proposes the point at distance one from it on the way to P; the mean of the proposals, pulled back
//! onto the surface, is tried in steps of 1, ½, ¼. Curve vertices move along their curve.
//!
//! ```text
//!      ╲ │ ╱            ╲  │ ╱
//!     ──•P──     →     ──── •P ──
//!      ╱ │ ╲            ╱  │ ╲
//! ```

use super::curves::{Chain, Kind, Rank};
use super::size::{Metric, length_between, length_quality};
use super::work::{Face, Spot, Work};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::normals::unit;
use crate::mesh::{NONE, next, previous};
use glam::DVec3;

/// A ball whose worst shape is above this may lose some of it for a better mean.
const GOOD: f32 = 0.75;
/// Shapes and length qualities that a smoothing move must not fall below.
const TOLERABLE: f32 = 0.6;

/// Shorter steps, as shares of the size, are not worth their tests.
const LEAST_STEP: f64 = 0.01;

const HALF_SQRT_3: f64 = 0.866_025_403_784_438_6;

/// When a move is accepted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Accept {
    /// Unless it spoils something: between flips and collapses, where a strict test would stick in a local optimum.
    Harmless,
    /// If the ball gets better.
    Better,
}

/// Where a vertex would go.
struct Move {
    point: DVec3,
    metric: Metric,
    parameter: f64,
    /// Wedges with their new places.
    wedges: [(u32, Option<Spot>); 2],
}

/// A curve vertex between its neighbours on the chain.
struct CurveSite<'a> {
    chain: &'a Chain,
    edges: [u32; 2],
    neighbours: [u32; 2],
    /// Signed ways to the neighbours along the chain.
    ways: [f64; 2],
}

/// What a ball is worth.
#[derive(Clone, Copy)]
pub struct Ball {
    shape: f32,
    cosine: f32,
    mean: f32,
    length: f64,
}

impl<'a> Work<'a> {
    /// Moves every vertex once. Returns how many moved.
    pub fn relocate(&mut self, accept: Accept, context: &Context) -> Result<usize> {
        let mut done = 0;
        for v in 0..self.mesh.vertex_slots() {
            context.check_every(v as usize)?;
            if !self.mesh.is_vertex(v) || self.rank[v as usize] == Rank::Corner {
                continue;
            }
            done += usize::from(self.relocate_vertex(v, accept));
        }
        Ok(done)
    }

    /// Moves one vertex if its ball gets better.
    pub fn relocate_vertex(&mut self, v: u32, accept: Accept) -> bool {
        match self.rank[v as usize] {
            Rank::Free => self.relocate_free(v, accept),
            Rank::Curve => self.relocate_curve(v, accept),
            Rank::Corner => false,
        }
    }

    fn relocate_free(&mut self, v: u32, accept: Accept) -> bool {
        let p = self.point(v);
        let (mut sum, mut count) = (DVec3::ZERO, 0.0);
        self.mesh.for_neighbours(v, |w| {
            let q = self.point(w);
            let l = length_between(q - p, self.metric(v), self.metric(w));
            sum += (p - q) * (l.recip() - 1.0);
            count += 1.0;
        });
        let Some(first) = self.mesh.around(v).next() else { return false };
        self.slide(v, self.mesh.wedge(first), sum / count, &[1.0, 0.5, 0.25], accept)
    }

    /// Moves a free vertex by the part of a step along the surface, or by the first share of it that is accepted.
    fn slide(&mut self, v: u32, wedge: u32, step: DVec3, shares: &[f64], accept: Accept) -> bool {
        let (p, n) = (self.point(v), self.normal[wedge as usize]);
        let step = step - n * n.dot(step);
        if !step.is_finite() || step.length() < LEAST_STEP * self.size[v as usize] {
            return false;
        }
        let before = self.ball(v);
        shares.iter().any(|share| self.try_free(v, wedge, p + step * *share, &before, accept))
    }

    /// Moves every vertex to where the triangles around it are best shaped, if that makes their mean better.
    pub fn reshape(&mut self, context: &Context) -> Result<usize> {
        let mut done = 0;
        for v in 0..self.mesh.vertex_slots() {
            context.check_every(v as usize)?;
            if !self.mesh.is_vertex(v) {
                continue;
            }
            done += usize::from(match self.rank[v as usize] {
                Rank::Free => self.reshape_vertex(v),
                Rank::Curve => self.reshape_curve(v),
                Rank::Corner => false,
            });
        }
        Ok(done)
    }

    fn reshape_vertex(&mut self, v: u32) -> bool {
        let Some(first) = self.mesh.around(v).next() else { return false };
        self.slide(v, self.mesh.wedge(first), self.way_to_tips(v), &[1.0, 0.5], Accept::Better)
    }

    /// The way to the mean of the tips of equilateral triangles on the sides opposite to the vertex.
    fn way_to_tips(&self, v: u32) -> DVec3 {
        let (mut sum, mut count) = (DVec3::ZERO, 0.0);
        for h in self.mesh.around(v) {
            let n = self.normal[self.mesh.wedge(h) as usize];
            let [b, c] = [next(h), previous(h)].map(|x| self.point(self.mesh.vertex(x)));
            // Seen from outside the triangle lies on the left of b → c.
            sum += 0.5 * (b + c) + HALF_SQRT_3 * n.cross(c - b);
            count += 1.0;
        }
        sum / count - self.point(v)
    }

    /// The same, as far as the curve leads there.
    fn reshape_curve(&mut self, v: u32) -> bool {
        let Some(site) = self.curve_site(v) else { return false };
        let step = self.way_to_tips(v);
        let s = self.parameter[v as usize];
        let [a, b] = site.ways.map(|w| site.chain.at(s + w).0);
        let along = unit(b - a) * (site.ways[1] - site.ways[0]).signum();
        let step = along.dot(step);
        if !(step.abs() > LEAST_STEP * self.size[v as usize]) {
            return false;
        }
        let ball = self.ball(v);
        [1.0, 0.5].iter().any(|share| self.try_curve(v, &site, share * step, &ball, Accept::Better))
    }

    /// Moves a free vertex to the place on the surface closest to a point, if its ball gets better.
    pub fn try_free(&mut self, v: u32, wedge: u32, p: DVec3, before: &Ball, accept: Accept) -> bool {
        let spot = self.spot(self.seat[wedge as usize], p);
        let to = Move {
            point: spot.point,
            metric: spot.metric,
            parameter: 0.0,
            wedges: [(wedge, Some(spot)), (NONE, None)],
        };
        self.try_move(v, &to, before, accept)
    }

    /// A free vertex with a bad ball tries a pattern of places around it; the scale shrinks until one is better.
    pub fn search_vertex(&mut self, v: u32) -> bool {
        match self.rank[v as usize] {
            Rank::Free => {}
            Rank::Curve => return self.search_curve(v),
            Rank::Corner => return false,
        }
        let Some(first) = self.mesh.around(v).next() else { return false };
        let wedge = self.mesh.wedge(first);
        let (x, y) = self.normal[wedge as usize].any_orthonormal_pair();
        let mut any = false;
        let mut scale = 0.3 * self.size[v as usize];
        for _ in 0..5 {
            let mut better = false;
            for k in 0..8 {
                let angle = f64::from(k) * std::f64::consts::FRAC_PI_4;
                let before = self.ball(v);
                let to = self.point(v) + scale * (x * angle.cos() + y * angle.sin());
                better |= self.try_free(v, wedge, to, &before, Accept::Better);
            }
            any |= better;
            if !better {
                scale *= 0.5;
            }
        }
        any
    }

    /// Moves a curve vertex to where the edges on both sides have equal lengths, were the size constant.
    fn relocate_curve(&mut self, v: u32, accept: Accept) -> bool {
        let Some(site) = self.curve_site(v) else { return false };
        let lengths = site.neighbours.map(|w| self.length(v, w));
        let [before, behind] = site.ways;
        let step = (lengths[1] - lengths[0]) / (lengths[0] / before.abs() + lengths[1] / behind.abs());
        let step = step * behind.signum();
        if !step.is_finite() || step.abs() < LEAST_STEP * self.size[v as usize] {
            return false;
        }
        let ball = self.ball(v);
        [1.0, 0.5, 0.25].iter().any(|share| self.try_curve(v, &site, share * step, &ball, accept))
    }

    /// Moves a curve vertex along its chain by a step, or by the first share of it that spoils nothing.
    pub fn move_along(&mut self, v: u32, step: f64) -> bool {
        if !(step.abs() >= LEAST_STEP * self.size[v as usize]) {
            return false;
        }
        let Some(site) = self.curve_site(v) else { return false };
        let ball = self.ball(v);
        [1.0, 0.5, 0.25].iter().any(|share| self.try_curve(v, &site, share * step, &ball, Accept::Harmless))
    }

    /// A curve vertex with a bad ball tries places on both sides; the step shrinks until one is better.
    fn search_curve(&mut self, v: u32) -> bool {
        let mut any = false;
        for share in [0.3, 0.15, 0.07] {
            for sign in [1.0, -1.0] {
                let Some(site) = self.curve_site(v) else { return any };
                let ball = self.ball(v);
                any |= self.try_curve(v, &site, sign * share * self.size[v as usize], &ball, Accept::Better);
            }
        }
        any
    }

    /// Where a curve vertex is on its chain; `None` where it cannot move.
    fn curve_site(&self, v: u32) -> Option<CurveSite<'a>> {
        let mesh = &self.mesh;
        // The curve half-edges at the vertex, leaving it where they exist, else entering it.
        let mut edges = [NONE; 2];
        let mut count = 0;
        let mut last = NONE;
        for h in mesh.around(v) {
            if mesh.curve(h) != NONE && count < 2 {
                edges[count] = h;
                count += 1;
            }
            last = previous(h);
        }
        if last != NONE && mesh.opposite(last) == NONE && count < 2 {
            edges[count] = last;
            count += 1;
        }
        if count < 2 {
            return None;
        }
        let (chain, _) = self.on_chain(edges[0])?;
        let neighbours = edges.map(|h| if mesh.vertex(h) == v { mesh.head(h) } else { mesh.vertex(h) });
        let ways = neighbours.map(|w| {
            let [a, b] = self.span(chain, v, w);
            b - a
        });
        (chain.kind != Kind::Seam && ways[0] * ways[1] < 0.0).then_some(CurveSite { chain, edges, neighbours, ways })
    }

    /// Moves a curve vertex along its chain, if that is accepted and the curve holds.
    fn try_curve(&mut self, v: u32, site: &CurveSite, step: f64, before: &Ball, accept: Accept) -> bool {
        let (s, chain) = (self.parameter[v as usize], site.chain);
        let to = s + step;
        let [a, b] = site.ways;
        if !((step - a) * (step - b) < 0.0) {
            return false;
        }
        let worst = chain.sag([s, s + a]).max(chain.sag([s, s + b]));
        if !site.ways.iter().all(|w| self.curve_allows(chain, [to, s + w], worst)) {
            return false;
        }
        let [left, right] = self.chain_spots(chain, to);
        let mut wedges = [(NONE, None), (NONE, None)];
        let mut size = f64::INFINITY;
        for (k, &h) in site.edges.iter().enumerate() {
            let spot = if site.ways[k] > 0.0 { left } else { right };
            if self.mesh.vertex(h) == v
                && let Some(spot) = spot
            {
                wedges[k] = (self.mesh.wedge(h), Some(spot));
                size = size.min(spot.metric.size);
            }
        }
        if !size.is_finite() {
            return false;
        }
        let metric = Metric { size, stretch: DVec3::ZERO };
        let to = Move { point: chain.at(to).0, metric, parameter: chain.wrapped(to), wedges };
        self.try_move(v, &to, before, accept)
    }

    /// What the triangles and edges around a vertex are worth as they are.
    pub fn ball(&self, v: u32) -> Ball {
        let mut ball = Ball { shape: f32::INFINITY, cosine: f32::INFINITY, mean: 0.0, length: f64::INFINITY };
        let mut count = 0.0;
        for h in self.mesh.around(v) {
            let face = self.face[h as usize / 3];
            ball.add(face);
            count += 1.0;
        }
        ball.mean /= count;
        ball.length = self.worst_length(v);
        ball
    }

    fn try_move(&mut self, v: u32, to: &Move, before: &Ball, accept: Accept) -> bool {
        let mesh = &self.mesh;
        let mut after = Ball { shape: f32::INFINITY, cosine: f32::INFINITY, mean: 0.0, length: f64::INFINITY };
        let mut count = 0.0;
        let good = if accept == Accept::Better { GOOD } else { TOLERABLE };
        let least = before.shape.min(good);
        for h in mesh.around(v) {
            let wedge = mesh.wedge(h);
            let spot = to.wedges.iter().find(|(w, _)| *w == wedge).and_then(|(_, s)| s.as_ref());
            let normal = spot.map_or(self.normal[wedge as usize], |s| s.normal);
            let (b, c) = (next(h), previous(h));
            let corners = [to.point, self.point(mesh.vertex(b)), self.point(mesh.vertex(c))];
            let normals = [normal, self.normal[mesh.wedge(b) as usize], self.normal[mesh.wedge(c) as usize]];
            let [_, wb, wc] = self.stretches([v, mesh.vertex(b), mesh.vertex(c)]);
            let face = self.judge(corners, normals, [to.metric.stretch, wb, wc]);
            if face.shape < least {
                return false;
            }
            after.add(face);
            count += 1.0;
        }
        after.mean /= count;
        mesh.for_neighbours(v, |w| {
            let l = length_between(self.point(w) - to.point, to.metric, self.metric(w));
            after.length = after.length.min(length_quality(l));
        });
        let accepted = match accept {
            Accept::Better => after.is_better_than(before, self.limits.good),
            Accept::Harmless => after.length >= before.length.min(f64::from(TOLERABLE)),
        };
        if !accepted || !self.allows_cosine(after.cosine, before.cosine) {
            return false;
        }
        if !self.strain_allows(v, to.point, NONE) {
            return false;
        }
        self.mesh.points[v as usize] = to.point;
        self.set_metric(v, to.metric);
        self.parameter[v as usize] = to.parameter;
        for (wedge, spot) in &to.wedges {
            if let Some(spot) = spot {
                self.normal[*wedge as usize] = spot.normal;
                self.seat[*wedge as usize] = spot.seat;
            }
        }
        self.refresh_around(v);
        true
    }
}

impl Ball {
    fn add(&mut self, face: Face) {
        self.shape = self.shape.min(face.shape);
        self.cosine = self.cosine.min(face.cosine);
        self.mean += face.shape;
    }

    /// A bad ball must get a better worst, be it a shape or a length; a good one a better mean.
    fn is_better_than(&self, before: &Ball, good: [f64; 2]) -> bool {
        let worst = |b: &Ball| (f64::from(b.shape) / good[0]).min(b.length / good[1]).min(1.0);
        let (new, old) = (worst(self), worst(before));
        if new < 1.0 || old < 1.0 {
            return new > old + 1e-4;
        }
        self.mean > before.mean + 1e-3
    }
}
