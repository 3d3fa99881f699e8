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

/// √3 / 2: the height of an equilateral triangle over its side.
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
pub struct Move {
    pub point: DVec3,
    metric: Metric,
    parameter: f64,
    /// What changes at one wedge or two.
    wedges: [Option<WedgeMove>; 2],
}

/// A wedge with its new normal and seat.
#[derive(Clone, Copy)]
struct WedgeMove {
    wedge: u32,
    normal: DVec3,
    seat: u32,
}

impl WedgeMove {
    fn new(wedge: u32, spot: &Spot) -> Self {
        WedgeMove { wedge, normal: spot.normal, seat: spot.seat }
    }
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
        self.sweep(context, |work, v| work.relocation(v, accept))
    }

    /// Moves every vertex to where the triangles around it are best shaped, if that makes their mean better.
    pub fn reshape(&mut self, context: &Context) -> Result<usize> {
        self.sweep(context, |work, v| match work.rank[v as usize] {
            Rank::Free => work.slide(v, work.way_to_tips(v), &[1.0, 0.5], Accept::Better),
            Rank::Curve => work.reshape_curve(v),
            Rank::Corner => None,
        })
    }

    /// Where a vertex goes so that its edges have length one.
    pub fn relocation(&self, v: u32, accept: Accept) -> Option<Move> {
        match self.rank[v as usize] {
            Rank::Free => self.slide(v, self.way_to_length_one(v), &[1.0, 0.5, 0.25], accept),
            Rank::Curve => self.relocate_curve(v, accept),
            Rank::Corner => None,
        }
    }

    /// The mean of the ways to length one of the edges.
    fn way_to_length_one(&self, v: u32) -> DVec3 {
        let p = self.point(v);
        let (mut sum, mut count) = (DVec3::ZERO, 0.0);
        self.mesh.for_neighbours(v, |w| {
            let q = self.point(w);
            let l = length_between(q - p, self.metric(v), self.metric(w));
            sum += (p - q) * (l.recip() - 1.0);
            count += 1.0;
        });
        sum / count
    }

    /// The part of a step along the surface that a free vertex goes, or the first share of it that is accepted.
    fn slide(&self, v: u32, step: DVec3, shares: &[f64], accept: Accept) -> Option<Move> {
        let wedge = self.mesh.wedge(self.mesh.around(v).next()?);
        let (p, n) = (self.point(v), self.normal[wedge as usize]);
        let step = step - n * n.dot(step);
        if !step.is_finite() || step.length() < LEAST_STEP * self.size[v as usize] {
            return None;
        }
        let before = self.ball(v);
        shares.iter().find_map(|share| self.try_free(v, wedge, p + step * *share, &before, accept))
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
    fn reshape_curve(&self, v: u32) -> Option<Move> {
        let site = self.curve_site(v)?;
        let step = self.way_to_tips(v);
        let s = self.parameter[v as usize];
        let [a, b] = site.ways.map(|w| site.chain.at(s + w).0);
        let along = unit(b - a) * (site.ways[1] - site.ways[0]).signum();
        self.slide_along(v, &site, along.dot(step), &[1.0, 0.5], Accept::Better)
    }

    /// A curve vertex goes to where the edges on both sides have equal lengths, were the size constant.
    fn relocate_curve(&self, v: u32, accept: Accept) -> Option<Move> {
        let site = self.curve_site(v)?;
        let lengths = site.neighbours.map(|w| self.length(v, w));
        let [before, behind] = site.ways;
        let step = (lengths[1] - lengths[0]) / (lengths[0] / before.abs() + lengths[1] / behind.abs());
        self.slide_along(v, &site, step * behind.signum(), &[1.0, 0.5, 0.25], accept)
    }

    /// A step of a curve vertex along its chain, or the first share of it that spoils nothing.
    pub fn step_along(&self, v: u32, step: f64) -> Option<Move> {
        self.slide_along(v, &self.curve_site(v)?, step, &[1.0, 0.5, 0.25], Accept::Harmless)
    }

    /// A step of a curve vertex along its chain, or the first share of it that is accepted.
    fn slide_along(&self, v: u32, site: &CurveSite, step: f64, shares: &[f64], accept: Accept) -> Option<Move> {
        if !(step.is_finite() && step.abs() >= LEAST_STEP * self.size[v as usize]) {
            return None;
        }
        let ball = self.ball(v);
        shares.iter().find_map(|share| self.try_curve(v, site, share * step, &ball, accept))
    }

    /// A free vertex goes to the place on the surface closest to a point, if its ball gets better.
    pub fn try_free(&self, v: u32, wedge: u32, p: DVec3, before: &Ball, accept: Accept) -> Option<Move> {
        let spot = self.spot(self.seat[wedge as usize], p);
        let wedges = [Some(WedgeMove::new(wedge, &spot)), None];
        let to = Move { point: spot.point, metric: spot.metric, parameter: 0.0, wedges };
        self.accepted(v, to, before, accept)
    }

    /// A vertex with a bad ball tries places around it, nearer and nearer, and goes to those that are better.
    pub fn search_vertex(&mut self, v: u32) -> bool {
        match self.rank[v as usize] {
            Rank::Free => self.search_free(v),
            Rank::Curve => self.search_curve(v),
            Rank::Corner => false,
        }
    }

    /// A free vertex tries a pattern of places around it; the scale shrinks until one is better.
    fn search_free(&mut self, v: u32) -> bool {
        let Some(first) = self.mesh.around(v).next() else { return false };
        let wedge = self.mesh.wedge(first);
        let (x, y) = self.normal[wedge as usize].any_orthonormal_pair();
        let mut any = false;
        let mut scale = 0.3 * self.size[v as usize];
        for _ in 0..5 {
            let mut better = false;
            for k in 0..8 {
                let angle = f64::from(k) * std::f64::consts::FRAC_PI_4;
                let to = self.point(v) + scale * (x * angle.cos() + y * angle.sin());
                let found = self.try_free(v, wedge, to, &self.ball(v), Accept::Better);
                better |= self.go(v, found);
            }
            any |= better;
            if !better {
                scale *= 0.5;
            }
        }
        any
    }

    /// A curve vertex tries places on both sides; the step shrinks.
    fn search_curve(&mut self, v: u32) -> bool {
        let mut any = false;
        for share in [0.3, 0.15, 0.07] {
            for sign in [1.0, -1.0] {
                let Some(site) = self.curve_site(v) else { return any };
                let step = sign * share * self.size[v as usize];
                let found = self.try_curve(v, &site, step, &self.ball(v), Accept::Better);
                any |= self.go(v, found);
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

    /// A curve vertex goes along its chain, if that is accepted and the curve holds.
    fn try_curve(&self, v: u32, site: &CurveSite, step: f64, before: &Ball, accept: Accept) -> Option<Move> {
        let (s, chain) = (self.parameter[v as usize], site.chain);
        let to = s + step;
        let [a, b] = site.ways;
        if !((step - a) * (step - b) < 0.0) {
            return None;
        }
        let worst = chain.sag([s, s + a]).max(chain.sag([s, s + b]));
        if !site.ways.iter().all(|w| self.curve_allows(chain, [to, s + w], worst)) {
            return None;
        }
        let [left, right] = self.chain_spots(chain, to);
        let mut wedges = [None; 2];
        let mut size = f64::INFINITY;
        for (k, &h) in site.edges.iter().enumerate() {
            let spot = if site.ways[k] > 0.0 { left } else { right };
            if self.mesh.vertex(h) == v
                && let Some(spot) = spot
            {
                wedges[k] = Some(WedgeMove::new(self.mesh.wedge(h), &spot));
                size = size.min(spot.metric.size);
            }
        }
        if !size.is_finite() {
            return None;
        }
        let metric = Metric { size, stretch: DVec3::ZERO };
        let to = Move { point: chain.at(to).0, metric, parameter: chain.wrapped(to), wedges };
        self.accepted(v, to, before, accept)
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

    /// A move, if it is accepted.
    fn accepted(&self, v: u32, to: Move, before: &Ball, accept: Accept) -> Option<Move> {
        let mesh = &self.mesh;
        let mut after = Ball { shape: f32::INFINITY, cosine: f32::INFINITY, mean: 0.0, length: f64::INFINITY };
        let mut count = 0.0;
        let good = if accept == Accept::Better { GOOD } else { TOLERABLE };
        let least = before.shape.min(good);
        for h in mesh.around(v) {
            let wedge = mesh.wedge(h);
            let moved = to.wedges.iter().flatten().find(|m| m.wedge == wedge);
            let normal = moved.map_or(self.normal[wedge as usize], |m| m.normal);
            let (b, c) = (next(h), previous(h));
            let corners = [to.point, self.point(mesh.vertex(b)), self.point(mesh.vertex(c))];
            let normals = [normal, self.normal[mesh.wedge(b) as usize], self.normal[mesh.wedge(c) as usize]];
            let [_, wb, wc] = self.stretches([v, mesh.vertex(b), mesh.vertex(c)]);
            let face = self.judge(corners, normals, [to.metric.stretch, wb, wc]);
            if face.shape < least {
                return None;
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
            return None;
        }
        self.strain_allows(v, to.point, NONE).then_some(to)
    }

    /// A step off the surface that leaves a vertex everything but its point.
    pub fn lifted(&self, v: u32, point: DVec3) -> Move {
        let parameter = self.parameter[v as usize];
        Move { point, metric: self.metric(v), parameter, wedges: [None; 2] }
    }

    /// Makes a move if there is one.
    pub fn go(&mut self, v: u32, found: Option<Move>) -> bool {
        if let Some(to) = &found {
            self.make(v, to);
        }
        found.is_some()
    }

    /// Makes a move.
    pub fn make(&mut self, v: u32, to: &Move) {
        self.mesh.points[v as usize] = to.point;
        self.set_metric(v, to.metric);
        self.parameter[v as usize] = to.parameter;
        for moved in to.wedges.iter().flatten() {
            self.normal[moved.wedge as usize] = moved.normal;
            self.seat[moved.wedge as usize] = moved.seat;
        }
        self.refresh_around(v);
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
