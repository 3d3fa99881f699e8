//! Moves vertices to where the mesh as a whole is nearest to the surface.
//!
//! With its vertices on the surface a mesh lies on one side of it wherever that is convex: inside by half of the largest
//! sag in the mean. Free vertices therefore move along their normals by the piecewise linear function t that is nearest
//! to the gap g between mesh and surface, ∫ (t − g)² → min, which halves the largest distance, too.
//!
//! ```text
//!        _.-•-._                _.---._
//!     .•'  │  '•.      →     •'   •   '•        the arc is the surface, seen from the side
//! ```
//!
//! M t = ∫ g φ with the mass matrix M of linear elements, by conjugate gradients preconditioned with its diagonal: the
//! condition number does not depend on the mesh (Wathen, "Realistic eigenvalue bounds for the Galerkin mass matrix",
//! 1987), and a few steps do. Vertices on curves stay.

use super::curves::Rank;
use super::relocate::Move;
use super::work::{Work, shape_and_normal};
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;
use glam::DVec3;
use rayon::prelude::*;

/// Quadrature of degree 4 on a triangle: barycentric coordinates of the first of three symmetric points, and its weight
/// (Dunavant, "High degree efficient symmetrical Gaussian quadrature rules for the triangle", 1985).
const QUADRATURE: [([f64; 3], f64); 2] = [
    ([0.108_103_018_168_070, 0.445_948_490_915_965, 0.445_948_490_915_965], 0.223_381_589_678_011),
    ([0.816_847_572_980_459, 0.091_576_213_509_771, 0.091_576_213_509_771], 0.109_951_743_655_322),
];
/// Steps of conjugate gradients; each gains about half a digit.
const STEPS: usize = 8;
/// No vertex moves farther than this share of its size.
const FARTHEST: f64 = 0.15;
/// Share of their shape that triangles keep when vertices are fitted.
const SHAPE_KEPT: f32 = 0.99;
/// Shape that is enough when vertices are fitted, whatever it was before.
const SHAPE_ENOUGH: f32 = 0.75;
/// Edges may grow to this length.
const LONGEST_FITTED: f64 = 1.6;

/// A number no larger than a limit, either way; zero where the limit is no number, as on meshes too small for their squares.
fn within(x: f64, limit: f64) -> f64 {
    if limit >= 0.0 { x.clamp(-limit, limit) } else { 0.0 }
}

impl Work<'_> {
    /// Moves free vertices along their normals to where the mesh is nearest to the source.
    pub fn fit(&mut self, context: &Context) -> Result<()> {
        let moments = self.gap_moments();
        context.check()?;
        let way = self.solve_mass(&moments);
        self.sweep(context, |work, v| {
            let most = FARTHEST * work.size[v as usize];
            if work.fits(v) { work.shifted(v, within(way[v as usize], most)) } else { None }
        })?;
        Ok(())
    }

    fn fits(&self, v: u32) -> bool {
        self.mesh.is_vertex(v) && self.rank[v as usize] == Rank::Free
    }

    fn area(&self, t: u32) -> f64 {
        let [a, b, c] = self.mesh.positions(t);
        0.5 * shape_and_normal(a, b, c).2
    }

    /// ∫ g φ over every triangle, for each of its corners.
    fn gap_moments(&self) -> Vec<[f64; 3]> {
        let of_triangle = |t: u32| {
            let mut moment = [0.0; 3];
            if !self.mesh.is_triangle(t) {
                return moment;
            }
            let p = self.mesh.positions(t);
            let wedges = [3 * t, 3 * t + 1, 3 * t + 2].map(|h| self.mesh.wedge(h) as usize);
            let n = wedges.map(|w| self.normal[w]);
            let limit = self.mesh.triangle(t).map(|v| self.size[v as usize]).into_iter().fold(f64::INFINITY, f64::min);
            let area = self.area(t);
            for (first, weight) in QUADRATURE {
                for k in 0..3 {
                    let b = [first[k], first[(k + 1) % 3], first[(k + 2) % 3]];
                    let heaviest = (0..3).fold(0, |best, i| if b[i] > b[best] { i } else { best });
                    let x = p[0] * b[0] + p[1] * b[1] + p[2] * b[2];
                    let normal = n[0] * b[0] + n[1] * b[1] + n[2] * b[2];
                    let (_, q) = self.support.locate(self.seat[wedges[heaviest]], x);
                    let gap = within((q - x).dot(normal), limit);
                    (0..3).for_each(|i| moment[i] += area * weight * b[i] * gap);
                }
            }
            moment
        };
        (0..self.mesh.triangle_slots()).into_par_iter().map(of_triangle).collect()
    }

    /// The function with given moments, at every vertex; 0 where vertices do not move.
    fn solve_mass(&self, moments: &[[f64; 3]]) -> Vec<f64> {
        let mesh = &self.mesh;
        let n = mesh.vertex_slots() as usize;
        let triangles: Vec<([u32; 3], f64)> = (0..mesh.triangle_slots())
            .filter(|&t| mesh.is_triangle(t))
            .map(|t| (mesh.triangle(t), self.area(t) / 12.0))
            .collect();
        let moves: Vec<bool> = (0..mesh.vertex_slots()).map(|v| self.fits(v)).collect();
        let stiff = self.limits.tilt_weight;
        let (mut diagonal, mut residual) = (vec![0.0; n], vec![0.0; n]);
        for t in (0..mesh.triangle_slots()).filter(|&t| mesh.is_triangle(t)) {
            let p = mesh.positions(t);
            let n = [3 * t, 3 * t + 1, 3 * t + 2].map(|h| self.normal[mesh.wedge(h) as usize]);
            let tilt = |i: usize, k: usize| 0.5 * (n[i] + n[k]).dot(p[k] - p[i]);
            let a = stiff * self.area(t) / 12.0;
            for (i, v) in mesh.triangle(t).into_iter().enumerate() {
                if moves[v as usize] {
                    residual[v as usize] += moments[t as usize][i] + a * (tilt(i, (i + 1) % 3) + tilt(i, (i + 2) % 3));
                }
            }
        }
        for (vertices, a) in &triangles {
            vertices.iter().for_each(|&v| diagonal[v as usize] += (2.0 + 2.0 * stiff) * a);
        }
        let dot = |x: &[f64], y: &[f64]| -> f64 { x.iter().zip(y).map(|(a, b)| a * b).sum() };
        let scaled = |r: &[f64]| -> Vec<f64> {
            r.iter().zip(&diagonal).map(|(r, d)| if *d > 0.0 { r / d } else { 0.0 }).collect()
        };
        let mut way = vec![0.0; n];
        let mut z = scaled(&residual);
        let mut direction = z.clone();
        let mut product = vec![0.0; n];
        let mut energy = dot(&residual, &z);
        for _ in 0..STEPS {
            if !(energy > 0.0) {
                break;
            }
            product.fill(0.0);
            for (vertices, a) in &triangles {
                let x = vertices.map(|v| direction[v as usize]);
                let sum = x[0] + x[1] + x[2];
                for (v, x) in vertices.iter().zip(x) {
                    product[*v as usize] += a * (sum + x + stiff * (3.0 * x - sum));
                }
            }
            product.iter_mut().zip(&moves).filter(|(_, moves)| !**moves).for_each(|(p, _)| *p = 0.0);
            let step = energy / dot(&direction, &product);
            for k in 0..n {
                way[k] += step * direction[k];
                residual[k] -= step * product[k];
            }
            z = scaled(&residual);
            let next = dot(&residual, &z);
            let share = next / energy;
            energy = next;
            direction.iter_mut().zip(&z).for_each(|(d, z)| *d = z + share * *d);
        }
        way
    }

    /// A step of a vertex along its normal, half of it where shapes, angles or creases forbid it.
    fn shifted(&self, v: u32, way: f64) -> Option<Move> {
        let normal = self.normal[self.mesh.wedge(self.mesh.around(v).next()?) as usize];
        let places = [1.0, 0.5].map(|share| self.point(v) + normal * (share * way));
        let holds = |to: &DVec3| to.is_finite() && self.shift_holds(v, *to);
        places.into_iter().find(holds).map(|to| self.lifted(v, to))
    }

    fn shift_holds(&self, v: u32, to: DVec3) -> bool {
        let mesh = &self.mesh;
        let faces_hold = mesh.around(v).all(|h| {
            let t = h / 3;
            let before = self.face[t as usize];
            let corners = mesh.triangle(t).map(|w| if w == v { to } else { self.point(w) });
            let normals = [3 * t, 3 * t + 1, 3 * t + 2].map(|h| self.normal[mesh.wedge(h) as usize]);
            let after = self.judge(corners, normals, self.stretches(mesh.triangle(t)));
            after.shape >= (SHAPE_KEPT * before.shape).min(SHAPE_ENOUGH)
                && self.allows_cosine(after.cosine, before.cosine)
        });
        let lengths_hold = mesh.around(v).all(|h| {
            let q = self.point(mesh.head(h));
            let longer = q.distance(to) / q.distance(self.point(v));
            longer <= 1.0 || longer * self.edge_length(h) <= LONGEST_FITTED
        });
        faces_hold && lengths_hold && self.strain_allows(v, to, NONE)
    }
}
