//! The surface that the mesh has to stay on: the source, with normals, radii of curvature and sizes.
//!
//! Everything is one-sided: a vertex on a curve has one normal per wedge, and no step of a walk crosses a curve.

use super::rings::Rings;
use super::size::Metric;
use crate::geometry::normals::{angle_between, unit};
use crate::geometry::search_tree::TriangleTree;
use crate::mesh::{EditMesh, NONE, next, previous, triangle_area_vector};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::Arc;

/// Steps of a walk before it stops where it is.
const WALK: usize = 256;

/// The source surface.
#[derive(Clone)]
pub struct Support {
    /// The source, with curves and wedges.
    pub mesh: EditMesh,
    pub rings: Rings,
    /// Unit normal of every wedge.
    pub normal: Vec<DVec3>,
    /// The same before they are fitted to sizes.
    pub(super) raw_normal: Vec<DVec3>,
    /// Size at every vertex.
    pub size: Vec<f64>,
    /// Stretch at every vertex; empty where sizes are isotropic.
    pub stretch: Vec<DVec3>,
    /// Position of every vertex with the noise taken out.
    pub fitted: Vec<DVec3>,
    patches: Option<Arc<Patches>>,
}

/// What points on curved patches need.
struct Patches {
    /// All triangles: a patch may come near other parts of the surface.
    sheets: TriangleTree,
    /// Unit normal of every wedge, where it is not the usual one.
    pub(super) normal: Option<Vec<DVec3>>,
}

/// A place on the source.
#[derive(Debug, Clone, Copy)]
pub struct Seat {
    /// The triangle.
    pub triangle: u32,
    /// Barycentric coordinates in it.
    pub weights: [f64; 3],
}

impl Support {
    /// Numbers the wedges of a mesh whose curves are set; a vertex on no curve has the wedge of its own number. Computes
    /// the normals of the wedges.
    pub fn new(mut mesh: EditMesh) -> Self {
        let mut wedges = mesh.vertex_slots();
        let mut around = Vec::new();
        for v in 0..mesh.vertex_slots() {
            around.clear();
            around.extend(mesh.around(v));
            // Begin behind a curve where there is one.
            if let Some(k) = around.iter().position(|&h| mesh.curve(h) != NONE) {
                around.rotate_left(k);
            }
            let mut wedge = v;
            for (k, &h) in around.iter().enumerate() {
                if k > 0 && mesh.curve(h) != NONE {
                    wedge = wedges;
                    wedges += 1;
                }
                mesh.set_wedge(h, wedge);
            }
        }
        let mut out = Support {
            normal: Vec::new(),
            raw_normal: Vec::new(),
            size: Vec::new(),
            stretch: Vec::new(),
            fitted: mesh.points.clone(),
            rings: Rings::new(&mesh),
            patches: None,
            mesh,
        };
        out.raw_normal = out.fan_normals(wedges as usize, unit);
        out.normal.clone_from(&out.raw_normal);
        out
    }

    /// Makes ready for points on patches. On clean models these have normals weighted by areas as well: where a face meets
    /// the narrow strips of a fillet, or these the small triangles of a ball, the normal is that of the larger triangles,
    /// whose patches would bulge otherwise. The strips of a cylinder have equal areas, and equal say.
    pub fn ready_for_patches(&mut self, noisy: bool) {
        let normal = (!noisy).then(|| self.fan_normals(self.normal.len(), |area| area));
        let triangles: Vec<[u32; 3]> = (0..self.mesh.triangle_slots()).map(|t| self.mesh.triangle(t)).collect();
        let sheets = TriangleTree::new(&self.mesh.points, &triangles);
        self.patches = Some(Arc::new(Patches { sheets, normal }));
    }

    /// Mean of the face normals of every wedge, weighted by the angles and by what is made of the area vectors.
    fn fan_normals(&self, wedges: usize, weighted: impl Fn(DVec3) -> DVec3 + Sync) -> Vec<DVec3> {
        let mesh = &self.mesh;
        let corner = |t: u32| {
            let [a, b, c] = mesh.positions(t);
            let n = weighted(triangle_area_vector(a, b, c));
            [angle_between(b - a, c - a), angle_between(c - b, a - b), angle_between(a - c, b - c)].map(|w| w * n)
        };
        let corners: Vec<[DVec3; 3]> = (0..mesh.triangle_slots()).into_par_iter().map(corner).collect();
        let mut normal = vec![DVec3::ZERO; wedges];
        for (h, n) in (0u32..).zip(corners.as_flattened()) {
            normal[mesh.wedge(h) as usize] += *n;
        }
        normal.par_iter_mut().for_each(|n| *n = unit(*n));
        normal
    }

    /// The closest point that a walk from a triangle finds without crossing a curve.
    pub fn locate(&self, from: u32, p: DVec3) -> (Seat, DVec3) {
        let mesh = &self.mesh;
        let place = |t: u32| {
            let corners = mesh.positions(t);
            let weights = closest_weights(p, corners);
            let q = corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2];
            (Seat { triangle: t, weights }, q, p.distance_squared(q))
        };
        let mut best = place(from);
        for _ in 0..WALK {
            let mut better = best;
            let weights = best.0.weights;
            let zeros = weights.iter().filter(|&&w| w == 0.0).count();
            let first = 3 * best.0.triangle;
            // The edge opposite to corner k leaves corner k + 1.
            for k in (0..3).filter(|&k| weights[k as usize] == 0.0) {
                let h = first + (k + 1) % 3;
                let o = mesh.opposite(h);
                if o != NONE && mesh.curve(h) == NONE {
                    let there = place(o / 3);
                    if there.2 < better.2 {
                        better = there;
                    }
                }
            }
            if better.2 >= best.2 && zeros == 2 {
                let corner = (0..3).find(|&k| weights[k as usize] > 0.0).unwrap_or(0);
                self.for_wedge(first + corner, |h| {
                    let there = place(h / 3);
                    if there.2 < better.2 {
                        better = there;
                    }
                });
            }
            if better.2 >= best.2 {
                break;
            }
            best = better;
        }
        (best.0, best.1)
    }

    /// Visits the corners around a vertex from `h` in both senses, up to the next curves.
    fn for_wedge(&self, h: u32, mut visit: impl FnMut(u32)) {
        let mesh = &self.mesh;
        let mut at = h;
        loop {
            let entering = previous(at);
            let o = mesh.opposite(entering);
            if o == NONE || mesh.curve(entering) != NONE {
                break;
            }
            at = o;
            if at == h {
                return;
            }
            visit(at);
        }
        at = h;
        loop {
            let o = mesh.opposite(at);
            if o == NONE || mesh.curve(at) != NONE {
                return;
            }
            at = next(o);
            visit(at);
        }
    }

    /// Where a point of a triangle lies in it.
    pub fn seat_in(&self, triangle: u32, p: DVec3) -> Seat {
        Seat { triangle, weights: closest_weights(p, self.mesh.positions(triangle)) }
    }

    /// Interpolated unit normal.
    pub fn normal_at(&self, seat: Seat) -> DVec3 {
        let n = |k: u32| self.normal[self.mesh.wedge(3 * seat.triangle + k) as usize];
        let [a, b, c] = seat.weights;
        let sum = n(0) * a + n(1) * b + n(2) * c;
        if sum.length_squared() > 1e-12 { sum.normalize() } else { n(0) }
    }

    /// The point on the curved patch, or half way to it or the point of the triangle itself where another sheet of the
    /// surface, which looks the other way, would be nearer: thin walls are not pierced.
    ///
    /// ```text
    ///      ╭──·──╮  ← patch: beyond the outer wall
    ///    ─────────  outer wall
    ///    ────·────  inner wall; its own point stays
    /// ```
    pub fn clear_at(&self, seat: Seat) -> DVec3 {
        let flat = self.fitted_at(seat);
        let Some(patches) = &self.patches else { return flat };
        let curved = self.curved_at(seat, patches.normal.as_ref().unwrap_or(&self.normal));
        let normal = self.normal_at(seat);
        let is_clear = |p: &DVec3| {
            let way = p.distance(flat);
            let nearest = if way > 0.0 { patches.sheets.closest_within(*p, way) } else { None };
            nearest.is_none_or(|found| {
                let [a, b, c] = self.mesh.positions(found.triangle);
                triangle_area_vector(a, b, c).dot(normal) >= 0.0
            })
        };
        [curved, flat.midpoint(curved)].into_iter().find(is_clear).unwrap_or(flat)
    }

    /// The point on the curved patch of the triangle: the mean of its projections into the tangent planes at the corners
    /// (Boubekeur, Alexa, "Phong tessellation", 2008), which is tangent-continuous at the corners and needs no more than
    /// the normals.
    fn curved_at(&self, seat: Seat, normal: &[DVec3]) -> DVec3 {
        let p = self.fitted_at(seat);
        let mut way = DVec3::ZERO;
        for (k, v) in (0u32..).zip(self.mesh.triangle(seat.triangle)) {
            let n = normal[self.mesh.wedge(3 * seat.triangle + k) as usize];
            way -= n * (seat.weights[k as usize] * n.dot(p - self.fitted[v as usize]));
        }
        p + 0.75 * way
    }

    /// The point itself with the noise taken out.
    pub fn fitted_at(&self, seat: Seat) -> DVec3 {
        let [a, b, c] = self.mesh.triangle(seat.triangle).map(|v| self.fitted[v as usize]);
        a * seat.weights[0] + b * seat.weights[1] + c * seat.weights[2]
    }

    /// Interpolated size.
    pub fn size_at(&self, seat: Seat) -> f64 {
        let [a, b, c] = self.mesh.triangle(seat.triangle).map(|v| self.size[v as usize]);
        seat.weights[0] * a + seat.weights[1] * b + seat.weights[2] * c
    }
}

impl Support {
    /// Interpolated metric.
    pub fn metric_at(&self, seat: Seat) -> Metric {
        let size = self.size_at(seat);
        if self.stretch.is_empty() {
            return Metric { size, stretch: DVec3::ZERO };
        }
        let w = self.mesh.triangle(seat.triangle).map(|v| self.stretch[v as usize]);
        // A stretch has no sense: all three look to the side of the longest.
        let longest = w.into_iter().fold(w[0], |a, b| if b.length_squared() > a.length_squared() { b } else { a });
        let sum = (0..3).map(|k| w[k] * seat.weights[k] * if w[k].dot(longest) < 0.0 { -1.0 } else { 1.0 }).sum();
        Metric { size, stretch: sum }
    }
}

/// Barycentric coordinates of the point of a triangle that is closest to `p`; exact zeros tell the edge or the corner
/// (Ericson, Real-Time Collision Detection, 5.1.5).
fn closest_weights(p: DVec3, [a, b, c]: [DVec3; 3]) -> [f64; 3] {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let t = d1 / (d1 - d3);
        return [1.0 - t, t, 0.0];
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let t = d2 / (d2 - d6);
        return [1.0 - t, 0.0, t];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - t, t];
    }
    let scale = (va + vb + vc).recip();
    if !scale.is_finite() {
        return [1.0, 0.0, 0.0];
    }
    [1.0 - (vb + vc) * scale, vb * scale, vc * scale]
}
