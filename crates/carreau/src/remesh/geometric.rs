//! Purely geometric simplification: as close to the source as a number of triangles allows, without regard to their
//! shape.
//!
//! Edges are collapsed in the order of the error they cause, into the point that causes the least (Garland, Heckbert,
//! "Surface simplification using quadric error metrics", SIGGRAPH 1997). Every vertex carries the sum of squared distances
//! to the planes of the source triangles that it has taken the place of, weighted by area; edges on curves add planes
//! across. Errors are divided by the worst shape a collapse leaves, where that is poor: a needle touches planes at a few
//! points and is far from the surface in between, which no sum over planes tells, and it is what later folds over. (Without
//! this the largest distance was found to be two and a half times larger, the mean a tenth.)
//!
//! Of the constraints of the paper (2) and (4) are dropped; what is left: (1), the ranks of vertices, the link condition, no
//! turned triangle, no needle.

use super::curves::{Curves, Kind, Rank};
use super::support::Support;
use super::work::shape_and_normal;
use crate::context::Context;
use crate::error::Result;
use crate::geometry::normals::unit;
use crate::geometry::quadric::Quadric;
use crate::mesh::{EditMesh, Keep, NONE, previous, triangle_area_vector};
use glam::DVec3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Shapes below this are refused, unless they were there before.
const LEAST_SHAPE: f64 = 0.055;
/// Errors count in full from this shape on, below they are divided by its share.
const FULL_SHAPE: f64 = 0.3;
/// Cosine of the largest turn of a triangle.
const LEAST_TURN: f64 = 0.3;
/// Weight of the planes across curves, beside those of faces.
const CURVE_WEIGHT: f64 = 10.0;
/// What holds a vertex on its way along flat directions: slides end between the two.
const STEADY: f64 = 1e-6;

/// When to stop.
#[derive(Debug, Clone, Copy)]
pub struct Goal {
    /// The largest number of triangles.
    pub triangles: usize,
    /// No collapse with a larger error than this, as a distance.
    pub error: f64,
    /// Cosine of the largest angle between a face and the normals at its corners: constraint (1).
    pub cosine: f64,
}

/// A collapse with its place and error.
struct Plan {
    keep: Keep,
    point: DVec3,
    /// Weighted sum of squared distances: the order of collapses, as far as shapes are good.
    cost: f64,
    /// Root mean square of the distances.
    error: f64,
}

/// The mesh at work.
pub struct Geometric<'a> {
    /// The mesh; vertices keep the ids of the source.
    pub mesh: EditMesh,
    support: &'a Support,
    rank: &'a [Rank],
    quadric: Vec<Quadric>,
    /// Positions relative to this: far from the origin quadrics would lose their digits.
    origin: DVec3,
}

impl<'a> Geometric<'a> {
    /// The source with the quadrics of its planes.
    pub fn new(support: &'a Support, curves: &'a Curves) -> Self {
        let mesh = support.mesh.clone();
        let origin = mesh.points.first().copied().unwrap_or(DVec3::ZERO);
        let mut quadric = vec![Quadric::ZERO; mesh.vertex_slots() as usize];
        for t in 0..mesh.triangle_slots() {
            let [a, b, c] = mesh.positions(t).map(|p| p - origin);
            let normal = triangle_area_vector(a, b, c);
            let plane = Quadric::plane(a, unit(normal), normal.length() / 3.0);
            mesh.triangle(t).iter().for_each(|&v| quadric[v as usize].add(&plane));
            for h in 3 * t..3 * t + 3 {
                let on_curve = curves.chains.get(mesh.curve(h) as usize).is_some_and(|c| c.kind != Kind::Seam);
                if on_curve {
                    let [p, q] = [mesh.vertex(h), mesh.head(h)].map(|v| mesh.points[v as usize] - origin);
                    let across = unit((q - p).cross(normal));
                    let plane = Quadric::plane(p, across, CURVE_WEIGHT * p.distance_squared(q));
                    [mesh.vertex(h), mesh.head(h)].iter().for_each(|&v| quadric[v as usize].add(&plane));
                }
            }
        }
        Geometric { mesh, support, rank: &curves.rank, quadric, origin }
    }

    /// Collapses edges, the least error first, until the goal is reached or nothing is allowed any more.
    pub fn run(&mut self, goal: &Goal, context: &Context) -> Result<()> {
        let mut queue: BinaryHeap<Reverse<(u64, u32, u32)>> = BinaryHeap::new();
        let mut stamp = vec![0u32; self.mesh.vertex_slots() as usize];
        let age = |stamp: &[u32], mesh: &EditMesh, h: u32| {
            stamp[mesh.vertex(h) as usize].wrapping_add(stamp[mesh.head(h) as usize])
        };
        for h in self.mesh.edges() {
            if let Some(plan) = self.plan(h) {
                queue.push(Reverse((plan.cost.to_bits(), h, 0)));
            }
        }
        let mut step = 0;
        while self.mesh.triangle_count() > goal.triangles
            && let Some(Reverse((key, h, then))) = queue.pop()
        {
            step += 1;
            context.check_every(step)?;
            if !self.mesh.is_edge(h) || age(&stamp, &self.mesh, h) != then {
                continue;
            }
            let Some(plan) = self.plan(h).filter(|plan| plan.error <= goal.error) else { continue };
            let Some(shape) = self.shape_after(h, &plan, goal) else { continue };
            let cost = plan.cost * (FULL_SHAPE / shape).max(1.0);
            // Shapes are looked at only when an edge's turn comes: entries in the queue are lower bounds.
            if cost > f64::from_bits(key) {
                queue.push(Reverse((cost.to_bits(), h, then)));
                continue;
            }
            let kept = self.collapse(h, &plan);
            stamp[kept as usize] = stamp[kept as usize].wrapping_add(1);
            let mesh = &self.mesh;
            for spoke in mesh.around(kept) {
                // On a border the last edge has no half-edge that leaves the vertex.
                let last = Some(previous(spoke)).filter(|&p| mesh.opposite(p) == NONE);
                for h in [Some(spoke), last].into_iter().flatten() {
                    let edge = mesh.opposite(h).min(h);
                    if let Some(plan) = self.plan(edge) {
                        queue.push(Reverse((plan.cost.to_bits(), edge, age(&stamp, mesh, edge))));
                    }
                }
            }
        }
        Ok(())
    }

    /// How an edge would be collapsed; `None` where the ranks of its ends forbid it.
    fn plan(&self, h: u32) -> Option<Plan> {
        let mesh = &self.mesh;
        let (a, b) = (mesh.vertex(h), mesh.head(h));
        let [rank_a, rank_b] = [a, b].map(|v| self.rank[v as usize]);
        let keep = if rank_a > rank_b { Keep::Tail } else { Keep::Head };
        let gone = rank_a.min(rank_b);
        if gone == Rank::Corner || (gone == Rank::Curve && mesh.curve(h) == NONE) {
            return None;
        }
        let mut quadric = self.quadric[a as usize];
        quadric.add(&self.quadric[b as usize]);
        let [p, q] = [a, b].map(|v| mesh.points[v as usize] - self.origin);
        let point = match keep {
            _ if rank_a.max(rank_b) < Rank::Corner => quadric.optimum(0.5 * (p + q), STEADY),
            Keep::Tail => p,
            Keep::Head => q,
        };
        let cost = quadric.at(point);
        let error = (cost / quadric.weight.max(f64::MIN_POSITIVE)).sqrt();
        error.is_finite().then_some(Plan { keep, point: point + self.origin, cost, error })
    }

    /// The worst shape after a collapse; `None` where it does not keep the topology, the sense of all triangles, their
    /// shapes, and constraint (1).
    fn shape_after(&self, h: u32, plan: &Plan, goal: &Goal) -> Option<f64> {
        let mesh = &self.mesh;
        if mesh.check_collapse(h).is_err() || mesh.joins_copies(h, plan.keep) {
            return None;
        }
        let (a, b) = (mesh.vertex(h), mesh.head(h));
        let (mut before, mut after) = (1.0f64, 1.0f64);
        for v in [a, b] {
            for corner in mesh.around(v) {
                let old = mesh.positions(corner / 3);
                let (shape, old_normal, old_area) = shape_and_normal(old[0], old[1], old[2]);
                before = before.min(shape);
                let vertices = mesh.triangle(corner / 3);
                if vertices.contains(&a) && vertices.contains(&b) {
                    continue;
                }
                let [p, q, r] = vertices.map(|w| if w == v { plan.point } else { mesh.points[w as usize] });
                let (shape, normal, area) = shape_and_normal(p, q, r);
                after = after.min(shape);
                if !(normal.dot(old_normal) > LEAST_TURN * area * old_area) && old_area > 0.0 {
                    return None;
                }
                let t = corner / 3;
                let fits = |c: u32| self.support.normal[mesh.wedge(c) as usize].dot(normal) >= goal.cosine * area;
                if !(3 * t..3 * t + 3).all(fits) && old_area > 0.0 {
                    return None;
                }
            }
        }
        (after >= LEAST_SHAPE.min(before)).then_some(after)
    }

    fn collapse(&mut self, h: u32, plan: &Plan) -> u32 {
        let (gone, kept) = self.mesh.gone_and_kept(h, plan.keep);
        self.mesh.collapse(h, plan.keep);
        self.mesh.points[kept as usize] = plan.point;
        let quadric = self.quadric[gone as usize];
        self.quadric[kept as usize].add(&quadric);
        kept
    }
}
