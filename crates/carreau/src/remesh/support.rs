//! The surface that the mesh has to stay on: the source, with normals, radii of curvature and sizes.
//!
//! Everything is one-sided: a vertex on a curve has one normal per wedge, and no step of a walk crosses a curve.

use super::curves::Rank;
use super::rings::Rings;
use super::size::Metric;
use crate::geometry::normals::{angle_between, unit};
use crate::geometry::search_tree::TriangleTree;
use crate::mesh::{EditMesh, NONE, next, previous, triangle_area_vector};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

/// Steps of a walk before it stops where it is.
const WALK: usize = 256;
/// Points of a curvature fit; rings of needles can be larger.
const FIT_POINTS: usize = 96;

/// Radii are made steady where one ring of edges is within this share of the size.
const STEADY_SHARE: f64 = 0.21;
/// The quantile of the curvatures around a vertex that its own may have.
const STEADY_QUANTILE: f64 = 0.68;

/// The source surface.
#[derive(Clone)]
pub struct Support {
    /// The source, with curves and wedges.
    pub mesh: EditMesh,
    pub rings: Rings,
    /// Unit normal of every wedge.
    pub normal: Vec<DVec3>,
    /// The same before they are fitted to sizes.
    raw_normal: Vec<DVec3>,
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
    normal: Option<Vec<DVec3>>,
}

/// Smallest principal radius at a vertex, near by and farther away.
#[derive(Debug, Clone, Copy)]
pub struct Radius {
    /// With weights that fall with the fourth power of the distance.
    near: f64,
    /// With weights that rise with the fourth power of the distance.
    far: f64,
    /// Mean length of the edges.
    pub spacing: f64,
}

impl Radius {
    /// The radius at the scale of the size α r: near where sizes are up to twice as long as edges, far where they are more
    /// than three times as long.
    pub fn at_scale(&self, alpha: f64) -> f64 {
        if !(self.near.is_finite() && self.far.is_finite()) {
            return self.near.min(self.far);
        }
        let t = (alpha * self.far / self.spacing - 2.0).clamp(0.0, 1.0);
        match t {
            0.0 => self.near,
            1.0 => self.far,
            _ => self.near.powf(1.0 - t) * self.far.powf(t),
        }
    }
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

    /// Smooths the normals at the scale of the sizes: a wedge takes part in as many rounds of averaging over its
    /// triangles as it needs for a kernel of about `share` sizes.
    pub fn fit_normals(&mut self, share: f64, most: usize) {
        let mesh = &self.mesh;
        self.normal.clone_from(&self.raw_normal);
        let at_vertex = rounds(&self.rings, &self.size, share, most);
        let mut rounds = vec![0u8; self.normal.len()];
        for h in 0..mesh.half_edge_slots() {
            rounds[mesh.wedge(h) as usize] = at_vertex[mesh.vertex(h) as usize];
        }
        let longest = at_vertex.iter().copied().max().unwrap_or(0);
        let areas: Vec<f64> = (0..mesh.triangle_slots())
            .into_par_iter()
            .map(|t| {
                let [a, b, c] = mesh.positions(t);
                triangle_area_vector(a, b, c).length()
            })
            .collect();
        for round in 0..longest {
            let mean = |t: u32| {
                let sum: DVec3 = (3 * t..3 * t + 3).map(|h| self.normal[mesh.wedge(h) as usize]).sum();
                areas[t as usize] * unit(sum)
            };
            let of_triangle: Vec<DVec3> = (0..mesh.triangle_slots()).into_par_iter().map(mean).collect();
            let mut sum = vec![DVec3::ZERO; self.normal.len()];
            for h in 0..mesh.half_edge_slots() {
                sum[mesh.wedge(h) as usize] += of_triangle[h as usize / 3];
            }
            for (k, n) in self.normal.iter_mut().enumerate().filter(|(k, _)| rounds[*k] > round) {
                let smooth = unit(sum[k]);
                if smooth != DVec3::ZERO {
                    *n = smooth;
                }
            }
        }
    }

    /// Takes the noise out of the positions of free vertices, at the scale of the sizes: rounds of Taubin's λ|μ smoothing,
    /// which keep the shape (Taubin 1995). No vertex moves farther than `most` sizes.
    pub fn fit_points(&mut self, rank: &[Rank], share: f64, most: f64) {
        let mesh = &self.mesh;
        let rounds = rounds(&self.rings, &self.size, share, 4);
        let longest = rounds.iter().copied().max().unwrap_or(0);
        let mut points = mesh.points.clone();
        for round in 0..longest {
            for factor in [0.5, -0.53] {
                let moved = |v: u32| {
                    let p = points[v as usize];
                    if rounds[v as usize] <= round || rank[v as usize] != Rank::Free || !mesh.is_vertex(v) {
                        return p;
                    }
                    let ring = self.rings.of(v);
                    let sum: DVec3 = ring.iter().map(|&w| points[w as usize] - p).sum();
                    p + sum * (factor / ring.len() as f64)
                };
                points = (0..mesh.vertex_slots()).into_par_iter().map(moved).collect();
            }
        }
        for (v, p) in points.into_iter().enumerate() {
            let way = p - mesh.points[v];
            // Along the normal only: sliding would change triangles, not the surface.
            let n = self.normal[v];
            let way = n * n.dot(way);
            self.fitted[v] = mesh.points[v] + way.clamp_length_max(most * self.size[v]);
        }
    }

    /// Smallest principal radius at every vertex, the smallest over its sides; infinite where the surface is flat.
    ///
    /// In the tangent frame z = ½ (a x² + 2 b x y + c y²) is fitted to the two rings around the vertex that are reached
    /// without crossing a curve; the radius is the inverse of the larger eigenvalue.
    pub fn radii(&self, rank: &[Rank]) -> Vec<Radius> {
        let mesh = &self.mesh;
        let of = |points: &mut Vec<u32>, v: u32| {
            let mut radius = Radius { near: f64::INFINITY, far: f64::INFINITY, spacing: 1.0 };
            self.for_sides(v, rank, points, |[near, far], _| {
                (radius.near, radius.far) = (radius.near.min(near), radius.far.min(far));
            });
            let (mut sum, mut count) = (0.0, 0.0);
            for h in mesh.around(v) {
                sum += mesh.points[v as usize].distance(mesh.points[mesh.head(h) as usize]);
                count += 1.0;
            }
            radius.spacing = if count > 0.0 { sum / count } else { 1.0 };
            radius
        };
        (0..mesh.vertex_slots()).into_par_iter().with_min_len(256).map_init(Vec::new, of).collect()
    }

    /// The direction in which the surface bends less at every vertex, as long as the root of one minus the ratio of the
    /// curvatures.
    pub fn bends(&self, rank: &[Rank]) -> Vec<DVec3> {
        let of = |points: &mut Vec<u32>, v: u32| {
            let mut bend = DVec3::ZERO;
            self.for_sides(v, rank, points, |_, found| bend = found);
            bend
        };
        (0..self.mesh.vertex_slots()).into_par_iter().with_min_len(256).map_init(Vec::new, of).collect()
    }

    /// Visits the fits on all sides of a vertex: the radii near by and farther away, and the bend.
    fn for_sides(&self, v: u32, rank: &[Rank], points: &mut Vec<u32>, mut visit: impl FnMut([f64; 2], DVec3)) {
        let mut done = NONE;
        for wedge in self.mesh.around(v).map(|h| self.mesh.wedge(h)) {
            if wedge != done {
                done = wedge;
                self.two_rings(v, wedge, rank, points);
                let (radii, bend) = self.fitted_radii(v, wedge, points);
                visit(radii, bend);
            }
        }
    }

    /// Radii without those that are small at single vertices, where sizes are many edges long: there they are noise, and
    /// gradation would spread them. The curvature of a vertex comes down to an upper quantile of those around it.
    pub fn steady_radii(&self, radius: Vec<f64>, rank: &[Rank], alpha: f64) -> Vec<f64> {
        let size: Vec<f64> = radius.iter().map(|r| (alpha * r).min(f64::MAX)).collect();
        let coarse = rounds(&self.rings, &size, STEADY_SHARE, 1);
        let of = |ring: &mut Vec<f64>, v: u32| {
            let own = radius[v as usize];
            if coarse[v as usize] == 0 || rank[v as usize] != Rank::Free {
                return own;
            }
            ring.clear();
            ring.push(own.recip());
            let free = self.rings.of(v).iter().filter(|&&w| rank[w as usize] == Rank::Free);
            ring.extend(free.map(|&w| radius[w as usize].recip()));
            ring.sort_unstable_by(f64::total_cmp);
            quantile(ring, STEADY_QUANTILE).recip().max(own)
        };
        (0..self.rings.len()).into_par_iter().with_min_len(256).map_init(Vec::new, of).collect()
    }

    /// Vertices of the two rings around one wedge.
    fn two_rings(&self, v: u32, wedge: u32, rank: &[Rank], out: &mut Vec<u32>) {
        let mesh = &self.mesh;
        out.clear();
        let add = |out: &mut Vec<u32>, w: u32| {
            if w != v && out.len() < FIT_POINTS && !out.contains(&w) {
                out.push(w);
            }
        };
        for h in mesh.around(v).filter(|&h| mesh.wedge(h) == wedge) {
            add(out, mesh.head(h));
            add(out, mesh.apex(h));
        }
        for k in 0..out.len() {
            if rank[out[k] as usize] == Rank::Free {
                self.rings.of(out[k]).iter().for_each(|&w| add(out, w));
            }
        }
    }

    /// The radii near by and farther away, and the bend of the latter.
    fn fitted_radii(&self, v: u32, wedge: u32, points: &[u32]) -> ([f64; 2], DVec3) {
        let n = self.normal[wedge as usize];
        let p = self.mesh.points[v as usize];
        let (x, y) = n.any_orthonormal_pair();
        let mut systems = [[[0.0; 4]; 3]; 2];
        let (mut scale, mut sharpest) = (0.0f64, 0.0f64);
        for &w in points {
            let d = self.mesh.points[w as usize] - p;
            let squared = d.length_squared();
            scale = scale.max(squared);
            sharpest = sharpest.max(2.0 * d.dot(n).abs() / squared.max(f64::MIN_POSITIVE));
        }
        if points.is_empty() || !(scale > 0.0) {
            return ([f64::INFINITY; 2], DVec3::ZERO);
        }
        let unit_length = scale.sqrt().recip();
        for &w in points {
            let d = (self.mesh.points[w as usize] - p) * unit_length;
            let (u, v, z) = (d.dot(x), d.dot(y), d.dot(n));
            let row = [0.5 * u * u, u * v, 0.5 * v * v];
            let squared = (u * u + v * v + z * z).max(1e-9);
            let far = squared * squared;
            for (m, weight) in systems.iter_mut().zip([far.recip(), far]) {
                for i in 0..3 {
                    for j in 0..3 {
                        m[i][j] += weight * row[i] * row[j];
                    }
                    m[i][3] += weight * row[i] * z;
                }
            }
        }
        let mut bend = DVec3::ZERO;
        let radii = systems.map(|m| {
            let trace = m[0][0] + m[1][1] + m[2][2];
            match solve3(m, 1e-7 * trace).filter(|_| points.len() >= 5) {
                Some([a, b, c]) => {
                    let (mean, half) = (0.5 * (a + c), 0.5 * (a - c));
                    let spread = (half * half + b * b).sqrt();
                    let largest = mean.abs() + spread;
                    // The eigenvector of the smaller curvature stands across that of the larger one.
                    let angle = 0.5 * b.atan2(half) + if mean >= 0.0 { FRAC_PI_2 } else { 0.0 };
                    let ratio = (mean.abs() - spread).abs() / largest.max(f64::MIN_POSITIVE);
                    bend = (x * angle.cos() + y * angle.sin()) * (1.0 - ratio).max(0.0).sqrt();
                    (largest * unit_length).recip()
                }
                // Too few points, or all on one conic: the sharpest circle through a neighbour.
                None => sharpest.recip(),
            }
        });
        (radii, bend)
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

/// A quantile of sorted values, interpolated.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let at = share * (sorted.len() - 1) as f64;
    let (low, high) = (at.floor() as usize, at.ceil() as usize);
    sorted[low] + at.fract() * (sorted[high] - sorted[low])
}

/// Rounds of averaging over neighbours that make a kernel of about `share` sizes at every vertex, up to a limit.
pub fn rounds(rings: &Rings, size: &[f64], share: f64, most: usize) -> Vec<u8> {
    let at = |v: u32| {
        let lengths = rings.lengths(v);
        let (sum, count) = (lengths.iter().map(|l| l * l).sum::<f64>(), lengths.len() as f64);
        // One round has a variance of about half the squared edge length.
        let scale = share * size[v as usize];
        let wanted = scale * scale * count / (0.5 * sum).max(f64::MIN_POSITIVE);
        wanted.round().min(most as f64) as u8
    };
    (0..rings.len()).into_par_iter().map(at).collect()
}

/// Gaussian elimination with pivoting of three equations; `None` where a pivot is below `least`.
fn solve3(mut m: [[f64; 4]; 3], least: f64) -> Option<[f64; 3]> {
    for k in 0..3 {
        let pivot = (k..3).max_by(|&a, &b| m[a][k].abs().total_cmp(&m[b][k].abs()))?;
        m.swap(k, pivot);
        if !(m[k][k].abs() > least) {
            return None;
        }
        for i in k + 1..3 {
            let factor = m[i][k] / m[k][k];
            for j in k..4 {
                m[i][j] -= factor * m[k][j];
            }
        }
    }
    let z = m[2][3] / m[2][2];
    let y = (m[1][3] - m[1][2] * z) / m[1][1];
    let x = (m[0][3] - m[0][1] * y - m[0][2] * z) / m[0][0];
    Some([x, y, z])
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
