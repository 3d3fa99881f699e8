//! The flow (equations 1 and 2 of the paper): in every step the positions minimise
//!
//! ‖W_L L x‖² + ‖W_H (x − xᵗ)‖² + ‖W_M (x − p)‖²
//!
//! with the cotangent Laplacian L of the surface as it is, xᵗ the positions of before and p the poles. Then edges that have
//! become short are collapsed (the one that stays takes the middle, and the nearer pole), edges between two obtuse angles are
//! split at the foot of an altitude, and vertices whose short edges cannot be collapsed without a change of topology are
//! frozen: the surface is a line there already.
//!
//! The Laplacian of a vertex shrinks with its triangles, the pull of its pole does not: the finer a surface is, the less it is
//! smoothed. Where there are very many vertices, edges that are short beside the ball that touches there are collapsed first.
//!
//! ```text
//!       c                c
//!      ╱ ╲              ╱│╲         both angles, at c and at d, above 110°
//!     a───b      →     a─m─b
//!      ╲ ╱              ╲│╱
//!       d                d
//! ```

use super::options::SkeletonOptions;
use super::tuning::MANY;
use crate::context::Context;
use crate::error::{Error, Result};
use crate::mesh::{EditMesh, Keep, NONE, SurfaceMesh, next, previous};
use crate::numeric::sparse::Matrix;
use glam::DVec3;

/// Most steps.
const STEPS: usize = 500;
/// Change of the area in a step, as a share of the source's, below which the flow stands still.
const STILL: f64 = 1e-4;
/// Steps in a row that stand still before the flow stops.
const PATIENCE: usize = 3;
/// Edges between two angles above this are split.
const OBTUSE: f64 = 110.0;
/// A vertex is frozen when two edges shorter than this share of the shortest length cannot be collapsed.
const STUCK: f64 = 0.1;
/// Length of edges, in radii of the inner ball there, up to which large surfaces are thinned before the flow, at
/// first.
const FIRST_SHORT: f64 = 0.25;
/// Factor by which that length grows until the surface is small enough.
const SHORT_GROWTH: f64 = 1.3;
/// Largest cotangent.
const STEEPEST: f64 = 100.0;
/// Weight that holds a frozen vertex.
const FROZEN: f64 = 1e4;

/// A surface that has become thin.
pub struct Thin {
    /// The surface.
    pub mesh: EditMesh,
    /// The vertex that every vertex of the source was drawn to.
    pub drawn_to: Vec<u32>,
    /// Steps taken.
    pub steps: usize,
}

struct Flow<'a> {
    mesh: EditMesh,
    /// Poles, by vertex; none for those that the flow has made.
    pole: Vec<DVec3>,
    has_pole: Vec<bool>,
    frozen: Vec<bool>,
    /// For a vertex that went, the one that it went into.
    into: Vec<u32>,
    shortest: f64,
    options: &'a SkeletonOptions,
}

/// Lets the surface flow until it hardly changes.
pub fn contract(surface: &SurfaceMesh, poles: &[DVec3], options: &SkeletonOptions, context: &Context) -> Result<Thin> {
    let stage = context.stage("flow");
    let Some(mesh) = EditMesh::new(surface) else {
        return Err(Error::input("a face is not a triangle", "", "cut polygons into triangles"));
    };
    let vertices = mesh.vertex_slots() as usize;
    let mut flow = Flow {
        pole: poles.to_vec(),
        has_pole: vec![true; vertices],
        frozen: vec![false; vertices],
        into: (0..vertices as u32).collect(),
        shortest: options.detail * surface.diagonal(),
        mesh,
        options,
    };
    let original = flow.area();
    flow.thin_out(surface.diagonal());
    let mut area = original;
    let (mut steps, mut still) = (0, 0);
    while steps < STEPS {
        flow.move_vertices()?;
        flow.collapse_short_edges();
        flow.split_obtuse();
        flow.freeze();
        steps += 1;
        let now = flow.area();
        tracing::debug!(steps, vertices = flow.mesh.vertex_count(), share = now / original, "flow");
        still = if (area - now).abs() < STILL * original { still + 1 } else { 0 };
        if still == PATIENCE {
            break;
        }
        area = now;
        stage.step(steps, STEPS)?;
    }
    let drawn_to = (0..vertices as u32).map(|v| flow.find(v)).collect();
    Ok(Thin { mesh: flow.mesh, drawn_to, steps })
}

impl Flow<'_> {
    fn area(&self) -> f64 {
        let mesh = &self.mesh;
        let live = (0..mesh.triangle_slots()).filter(|&t| mesh.is_triangle(t));
        live.map(|t| {
            let [a, b, c] = mesh.positions(t);
            0.5 * (b - a).cross(c - a).length()
        })
        .sum()
    }

    /// The cotangents of the two angles opposite to an edge, none below zero.
    fn weight(&self, h: u32) -> f64 {
        let cotangent = |h: u32| {
            let [a, b, c] =
                [self.mesh.vertex(h), self.mesh.head(h), self.mesh.apex(h)].map(|v| self.mesh.points[v as usize]);
            let (p, q) = (a - c, b - c);
            let area = p.cross(q).length();
            // Needles would spoil the condition of the system: their angles count as larger than they are.
            if area > 0.0 { (p.dot(q).max(0.0) / area).min(STEEPEST) } else { 0.0 }
        };
        cotangent(h) + cotangent(self.mesh.opposite(h))
    }

    /// One implicit step.
    fn move_vertices(&mut self) -> Result<()> {
        let mesh = &self.mesh;
        let live: Vec<u32> = (0..mesh.vertex_slots()).filter(|&v| mesh.is_vertex(v)).collect();
        let mut number = vec![NONE; mesh.vertex_slots() as usize];
        (0..).zip(&live).for_each(|(k, &v)| number[v as usize] = k);
        let mut matrix = Matrix::new(live.len());
        let mut rhs = [vec![0.0; live.len()], vec![0.0; live.len()], vec![0.0; live.len()]];
        let mut row: Vec<(u32, f64)> = Vec::new();
        for (k, &v) in (0..).zip(&live) {
            let slot = v as usize;
            let frozen = self.frozen[slot];
            let hold = if frozen { FROZEN } else { self.options.speed }.powi(2);
            let draw = if frozen || !self.has_pole[slot] { 0.0 } else { self.options.medial.powi(2) };
            matrix.add(k, k, hold + draw);
            let pull = hold * mesh.points[slot] + draw * self.pole[slot];
            (0..3).for_each(|axis| rhs[axis][k as usize] = pull[axis]);
            if frozen {
                continue;
            }
            row.clear();
            row.push((k, 0.0));
            for h in mesh.around(v) {
                let w = self.weight(h);
                row.push((number[mesh.head(h) as usize], w));
                row[0].1 -= w;
            }
            for (i, &(a, x)) in row.iter().enumerate() {
                for &(b, y) in &row[..=i] {
                    matrix.add(a.max(b), a.min(b), x * y);
                }
            }
        }
        let factor = matrix.factor(&mut None)?;
        let [x, y, z] = rhs;
        let (x, y, z) = (factor.solve(&x)?, factor.solve(&y)?, factor.solve(&z)?);
        for (k, &v) in live.iter().enumerate() {
            self.mesh.points[v as usize] = DVec3::new(x[k], y[k], z[k]);
        }
        Ok(())
    }

    fn length(&self, h: u32) -> f64 {
        let [a, b] = [self.mesh.vertex(h), self.mesh.head(h)].map(|v| self.mesh.points[v as usize]);
        a.distance(b)
    }

    fn collapse_short_edges(&mut self) {
        let shortest = self.shortest;
        while self.collapse_edges(|flow, h| flow.length(h) < shortest) {}
    }

    /// Leaves about [`MANY`] vertices, more of them where the inner balls are small.
    fn thin_out(&mut self, longest: f64) {
        let radius = |flow: &Self, v: u32| flow.mesh.points[v as usize].distance(flow.pole[v as usize]);
        let mut limit = self.shortest;
        while self.mesh.vertex_count() > MANY && limit < longest {
            self.collapse_edges(|flow, h| {
                let [a, b] = [flow.mesh.vertex(h), flow.mesh.head(h)];
                flow.length(h) < limit.min(FIRST_SHORT * radius(flow, a).min(radius(flow, b)))
            });
            limit *= SHORT_GROWTH;
        }
    }

    /// Collapses edges that are short, each once; whether there was one.
    fn collapse_edges(&mut self, is_short: impl Fn(&Self, u32) -> bool) -> bool {
        let before = self.mesh.vertex_count();
        for h in 0..self.mesh.half_edge_slots() {
            if self.mesh.is_edge(h) && is_short(self, h) && self.mesh.check_collapse(h).is_ok() {
                self.collapse(h);
            }
        }
        self.mesh.vertex_count() != before
    }

    /// The head stays, in the middle, with the nearer of the two poles.
    fn collapse(&mut self, h: u32) {
        let [gone, kept] = [self.mesh.vertex(h), self.mesh.head(h)].map(|v| v as usize);
        let middle = 0.5 * (self.mesh.points[gone] + self.mesh.points[kept]);
        let is_nearer =
            !self.has_pole[kept] || self.pole[gone].distance_squared(middle) < self.pole[kept].distance_squared(middle);
        if self.has_pole[gone] && is_nearer {
            (self.pole[kept], self.has_pole[kept]) = (self.pole[gone], true);
        }
        if self.frozen[gone] || self.frozen[kept] {
            let at = if self.frozen[kept] { kept } else { gone };
            self.mesh.points[kept] = self.mesh.points[at];
            self.frozen[kept] = true;
        } else {
            self.mesh.points[kept] = middle;
        }
        self.into[gone] = kept as u32;
        self.mesh.collapse(h, Keep::Head);
    }

    fn split_obtuse(&mut self) {
        let limit = OBTUSE.to_radians().cos();
        for h in 0..self.mesh.half_edge_slots() {
            if !self.mesh.is_edge(h) || self.length(h) < self.shortest {
                continue;
            }
            let o = self.mesh.opposite(h);
            let cosine = |h: u32| {
                let p = |v: u32| self.mesh.points[v as usize];
                let (a, b, c) = (p(self.mesh.vertex(h)), p(self.mesh.head(h)), p(self.mesh.apex(h)));
                (a - c).normalize_or_zero().dot((b - c).normalize_or_zero())
            };
            let (left, right) = (cosine(h), cosine(o));
            if left < limit && right < limit {
                let apex = self.mesh.apex(if left < right { h } else { o });
                self.split(h, apex);
            }
        }
    }

    fn split(&mut self, h: u32, apex: u32) {
        let [a, b] = [self.mesh.vertex(h), self.mesh.head(h)];
        let [p, q, c] = [a, b, apex].map(|v| self.mesh.points[v as usize]);
        let along = q - p;
        let t = ((c - p).dot(along) / along.length_squared()).clamp(0.05, 0.95);
        let wedges = [self.mesh.wedge(next(h)), self.mesh.wedge(previous(h))];
        let new = self.mesh.split(h, p.lerp(q, t), wedges);
        debug_assert_eq!(new as usize, self.pole.len());
        self.pole.push(self.pole[a as usize].lerp(self.pole[b as usize], t));
        self.has_pole.push(false);
        self.frozen.push(false);
        self.into.push(new);
    }

    fn freeze(&mut self) {
        let limit = STUCK * self.shortest;
        for v in 0..self.mesh.vertex_slots() {
            if !self.mesh.is_vertex(v) || self.frozen[v as usize] {
                continue;
            }
            let stuck = |h: &u32| self.length(*h) < limit && self.mesh.check_collapse(*h).is_err();
            self.frozen[v as usize] = self.mesh.around(v).filter(stuck).take(2).count() == 2;
        }
    }

    /// The vertex that is left of one.
    fn find(&mut self, v: u32) -> u32 {
        let mut root = v;
        while self.into[root as usize] != root {
            root = self.into[root as usize];
        }
        let mut at = v;
        while self.into[at as usize] != root {
            at = std::mem::replace(&mut self.into[at as usize], root);
        }
        root
    }
}
