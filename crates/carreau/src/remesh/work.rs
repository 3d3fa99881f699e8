//! The mesh at work: an [`EditMesh`] with the size of every vertex, the normal of every wedge, and the worst of every
//! triangle, so that a cavity is judged without computing what was there before.

use super::curves::{Chain, Curves, Kind, Rank};
use super::dihedral::Dihedral;
use super::size::{Metric, length_between, length_quality, metric_length};
use super::support::{Seat, Support};
use crate::mesh::{EditMesh, NONE};
use glam::DVec3;

/// 2 √3: makes the shape of an equilateral triangle one.
const SHAPE_SCALE: f64 = 2.0 * 1.732_050_807_568_877_2;

/// Splits, collapses and relocation settle at a mean length a little below one: the mesh at work has sizes larger by this
/// factor, so that the mean is one in those asked for.
pub const BALANCE: f64 = 1.028;

/// What new triangles and edges must respect.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// Cosine of the angle that a face may always make with the normals at its corners: constraint (1).
    pub cos_allowed: f64,
    /// Cosine of the angle that it may make where the cavity had a face as bad: the hard cap.
    pub cos_cap: f64,
    /// Sag of a curve edge over its length.
    pub curve_sag_share: f64,
    /// Sag of a ridge edge, absolute.
    pub ridge_sag: f64,
    /// Sag of a border edge, absolute.
    pub border_sag: f64,
    /// A model without noise: its ridges are spaced evenly, its gaps closed, and there is time for more rounds.
    pub clean: bool,
    /// Shape and length quality from which on a ball is good: there the mean counts, below the worst.
    pub good: [f64; 2],
    /// Weight of the tilt of edges against that of the gap where vertices are fitted.
    pub tilt_weight: f64,
    /// Dihedral angles, on models without noise.
    pub dihedral: Option<Dihedral>,
}

/// Shape and worst cosine with a corner normal of a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Face {
    /// q = 4 √3 A / Σ l².
    pub shape: f32,
    /// Smallest cosine between the face normal and a corner normal.
    pub cosine: f32,
}

impl Face {
    /// The worst of both.
    pub fn worse(self, other: Face) -> Face {
        Face { shape: self.shape.min(other.shape), cosine: self.cosine.min(other.cosine) }
    }
}

/// The mesh at work.
pub struct Work<'a> {
    pub mesh: EditMesh,
    pub support: &'a Support,
    pub curves: &'a Curves,
    pub limits: Limits,
    /// Size at every vertex.
    pub size: Vec<f64>,
    /// Stretch at every vertex; empty where sizes are isotropic.
    pub stretch: Vec<DVec3>,
    pub rank: Vec<Rank>,
    /// Parameter on its chain of every vertex of rank [`Rank::Curve`].
    pub parameter: Vec<f64>,
    /// Unit normal of every wedge; zero at tips, which have none.
    pub normal: Vec<DVec3>,
    /// A source triangle near every wedge, on its side of all curves.
    pub seat: Vec<u32>,
    /// Of every triangle.
    pub face: Vec<Face>,
    /// Factor on the sizes of the support.
    pub scale: f64,
    /// New points lie on the curved patches of the support instead of its triangles.
    pub curved: bool,
}

/// A place for a vertex on the surface.
#[derive(Debug, Clone, Copy)]
pub struct Spot {
    pub point: DVec3,
    pub normal: DVec3,
    pub metric: Metric,
    pub seat: u32,
}

/// Shape and face normal, unnormalised, of a triangle.
#[inline]
pub fn shape_and_normal(a: DVec3, b: DVec3, c: DVec3) -> (f64, DVec3, f64) {
    let (u, v, w) = (b - a, c - a, c - b);
    let n = u.cross(v);
    let area = n.length();
    let squares = u.length_squared() + v.length_squared() + w.length_squared();
    (SHAPE_SCALE * area / squares.max(f64::MIN_POSITIVE), n, area)
}

/// Shape of a triangle of twice the given area in the mean metric of its corners: 4 √3 √det(M) A / Σ l²_M. With
/// M = I − S, S = ⅓ Σ w wᵀ in the tangent plane, det(M) = 1 − tr S + det S and 2 det S = (tr S)² − tr S².
fn stretched_shape([a, b, c]: [DVec3; 3], area: f64, w: [DVec3; 3]) -> f64 {
    let squared = |u: DVec3| u.length_squared() - w.iter().map(|w| w.dot(u).powi(2)).sum::<f64>() / 3.0;
    let trace = w.iter().map(|w| w.length_squared()).sum::<f64>() / 3.0;
    let of_square = w.iter().flat_map(|v| w.iter().map(|u| u.dot(*v).powi(2))).sum::<f64>() / 9.0;
    let determinant = (1.0 - trace + 0.5 * (trace * trace - of_square)).max(0.0);
    let squares = squared(b - a) + squared(c - b) + squared(a - c);
    SHAPE_SCALE * area * determinant.sqrt() / squares.max(f64::MIN_POSITIVE)
}

impl<'a> Work<'a> {
    /// The source itself, as the mesh to begin with.
    pub fn new(support: &'a Support, curves: &'a Curves, limits: Limits) -> Self {
        let mut mesh = support.mesh.clone();
        mesh.points.clone_from(&support.fitted);
        let mut seat = vec![NONE; support.normal.len()];
        for h in (0..mesh.half_edge_slots()).rev() {
            seat[mesh.wedge(h) as usize] = h / 3;
        }
        let mut work = Work {
            support,
            curves,
            limits,
            size: support.size.iter().map(|h| BALANCE * h).collect(),
            stretch: support.stretch.clone(),
            rank: curves.rank.clone(),
            parameter: curves.parameter.clone(),
            normal: support.normal.clone(),
            seat,
            scale: BALANCE,
            curved: false,
            face: vec![Face { shape: 0.0, cosine: -1.0 }; mesh.triangle_slots() as usize],
            mesh,
        };
        for &v in &curves.tips {
            work.mesh.around(v).for_each(|h| work.normal[work.mesh.wedge(h) as usize] = DVec3::ZERO);
        }
        (0..work.mesh.triangle_slots()).for_each(|t| work.refresh(t));
        work
    }

    #[inline]
    pub fn point(&self, v: u32) -> DVec3 {
        self.mesh.points[v as usize]
    }

    /// Length of an edge in the metric.
    #[inline]
    pub fn length(&self, a: u32, b: u32) -> f64 {
        let way = self.point(b) - self.point(a);
        if self.stretch.is_empty() {
            return metric_length(way.length(), self.size[a as usize], self.size[b as usize]);
        }
        length_between(way, self.metric(a), self.metric(b))
    }

    /// The metric at a vertex.
    #[inline]
    pub fn metric(&self, v: u32) -> Metric {
        let stretch = self.stretch.get(v as usize).copied().unwrap_or(DVec3::ZERO);
        Metric { size: self.size[v as usize], stretch }
    }

    /// Puts the metric of a place to a vertex.
    pub fn set_metric(&mut self, v: u32, metric: Metric) {
        self.size[v as usize] = metric.size;
        if let Some(stretch) = self.stretch.get_mut(v as usize) {
            *stretch = metric.stretch;
        }
    }

    /// Length of the edge of a half-edge.
    #[inline]
    pub fn edge_length(&self, h: u32) -> f64 {
        self.length(self.mesh.vertex(h), self.mesh.head(h))
    }

    /// A triangle with given corners, corner normals and stretches; a face without area has the worst of everything.
    #[inline]
    pub fn judge(&self, [a, b, c]: [DVec3; 3], normals: [DVec3; 3], stretches: [DVec3; 3]) -> Face {
        let (shape, n, area) = shape_and_normal(a, b, c);
        if !(area > 0.0) {
            return Face { shape: 0.0, cosine: -1.0 };
        }
        let shape = if self.stretch.is_empty() { shape } else { stretched_shape([a, b, c], area, stretches) };
        let given = normals.iter().filter(|m| **m != DVec3::ZERO);
        let cosine = given.map(|m| m.dot(n)).fold(f64::INFINITY, f64::min) / area;
        Face { shape: shape as f32, cosine: cosine as f32 }
    }

    /// Stretches of three vertices.
    #[inline]
    pub fn stretches(&self, vertices: [u32; 3]) -> [DVec3; 3] {
        if self.stretch.is_empty() { [DVec3::ZERO; 3] } else { vertices.map(|v| self.stretch[v as usize]) }
    }

    /// Computes what is known of a triangle anew.
    #[inline]
    pub fn refresh(&mut self, t: u32) {
        if !self.mesh.is_triangle(t) {
            return;
        }
        let normals = [3 * t, 3 * t + 1, 3 * t + 2].map(|h| self.normal[self.mesh.wedge(h) as usize]);
        let face = self.judge(self.mesh.positions(t), normals, self.stretches(self.mesh.triangle(t)));
        if self.face.len() <= t as usize {
            self.face.resize(t as usize + 1, Face { shape: 0.0, cosine: -1.0 });
        }
        self.face[t as usize] = face;
    }

    /// Computes the triangles around a vertex anew.
    pub fn refresh_around(&mut self, v: u32) {
        let mut ring = [0u32; 64];
        let mut count = 0;
        let mut rest = Vec::new();
        for h in self.mesh.around(v) {
            if count < ring.len() {
                ring[count] = h / 3;
                count += 1;
            } else {
                rest.push(h / 3);
            }
        }
        ring[..count].iter().for_each(|&t| self.refresh(t));
        rest.into_iter().for_each(|t| self.refresh(t));
    }

    /// Constraint (1): a new cosine is good where it is within the limit, or where the cavity had a worse one before and
    /// it is within the cap; what is beyond the cap may only get better.
    #[inline]
    pub fn allows_cosine(&self, new: f32, before: f32) -> bool {
        let limits = &self.limits;
        let new = f64::from(new);
        let before = f64::from(before);
        new >= limits.cos_allowed || (new >= before - 1e-7 && (new >= limits.cos_cap || new > before + 1e-6))
    }

    /// The chain of a curve edge and the parameters of the two ends of the half-edge, unwrapped.
    pub fn on_chain(&self, h: u32) -> Option<(&'a Chain, [f64; 2])> {
        let chain = self.curves.chains.get(self.mesh.curve(h) as usize)?;
        let (a, b) = (self.mesh.vertex(h), self.mesh.head(h));
        Some((chain, self.span(chain, a, b)))
    }

    /// Parameters of two vertices on a chain, unwrapped. A corner is the end of the chain that is nearer, or the start and
    /// the end where both are corners.
    pub fn span(&self, chain: &Chain, a: u32, b: u32) -> [f64; 2] {
        let parameter = |v: u32| (self.rank[v as usize] == Rank::Curve).then(|| self.parameter[v as usize]);
        let length = chain.length();
        let is_start = |v: u32| {
            self.mesh.origin[v as usize] == self.support.mesh.origin[chain.vertices[0] as usize]
                && v == chain.vertices[0]
        };
        let ends_meet = chain.vertices.first() == chain.vertices.last();
        let end = |v: u32, other: f64| match (ends_meet, is_start(v)) {
            (true, _) => {
                if other < 0.5 * length {
                    0.0
                } else {
                    length
                }
            }
            (false, true) => 0.0,
            (false, false) => length,
        };
        match (parameter(a), parameter(b)) {
            (Some(s), Some(t)) => chain.span(s, t),
            (Some(s), None) => [s, end(b, s)],
            (None, Some(t)) => [end(a, t), t],
            (None, None) => {
                if is_start(a) {
                    [0.0, length]
                } else {
                    [length, 0.0]
                }
            }
        }
    }

    /// Whether a curve edge may run between two vertices: its sag is within the tolerance, and it does not take a closed
    /// chain by half.
    pub fn curve_allows(&self, chain: &Chain, span: [f64; 2], before: f64) -> bool {
        let way = (span[1] - span[0]).abs();
        if chain.kind == Kind::Seam || (chain.closed && way > 0.45 * chain.length()) {
            return false;
        }
        let chord = chain.at(span[0]).0.distance(chain.at(span[1]).0);
        let absolute = match chain.kind {
            Kind::Ridge | Kind::Crease => self.limits.ridge_sag,
            Kind::Border | Kind::Seam => self.limits.border_sag,
        };
        let allowed = (self.limits.curve_sag_share * chord).min(absolute).max(before);
        chain.sag(span) <= allowed
    }

    /// Whether a border may run between two points of its chain, were it as short as it likes.
    pub fn border_allows(&self, chain: &Chain, span: [f64; 2]) -> bool {
        chain.kind == Kind::Border
            && (!chain.closed || (span[1] - span[0]).abs() <= 0.45 * chain.length())
            && chain.sag(span) <= self.limits.border_sag
    }

    /// The place on the surface that is closest to a point, seen from a source triangle.
    #[inline]
    pub fn spot(&self, from: u32, p: DVec3) -> Spot {
        let (seat, _) = self.support.locate(from, p);
        let point = if self.curved { self.support.clear_at(seat) } else { self.support.fitted_at(seat) };
        self.spot_at(seat, point)
    }

    #[inline]
    pub fn spot_at(&self, seat: Seat, point: DVec3) -> Spot {
        let normal = self.support.normal_at(seat);
        let Metric { size, stretch } = self.support.metric_at(seat);
        Spot { point, normal, metric: Metric { size: self.scale * size, stretch }, seat: seat.triangle }
    }

    /// The places on both sides of a chain at a parameter: on the left of its direction and on the right.
    pub fn chain_spots(&self, chain: &Chain, s: f64) -> [Option<Spot>; 2] {
        let (p, k) = chain.at(s);
        chain.sides[k].map(|h| (h != NONE).then(|| self.spot_at(self.support.seat_in(h / 3, p), p)))
    }

    /// Lowest size quality of the edges at a vertex.
    pub fn worst_length(&self, v: u32) -> f64 {
        let mut worst = f64::INFINITY;
        self.mesh.for_neighbours(v, |w| worst = worst.min(length_quality(self.length(v, w))));
        worst
    }

    /// A new vertex at a place; its wedges are added by the caller.
    pub fn add_vertex(&mut self, rank: Rank, metric: Metric, parameter: f64) {
        self.rank.push(rank);
        self.size.push(metric.size);
        if !self.support.stretch.is_empty() {
            self.stretch.push(metric.stretch);
        }
        self.parameter.push(parameter);
    }

    /// A new wedge at a place.
    pub fn add_wedge(&mut self, spot: &Spot) -> u32 {
        self.normal.push(spot.normal);
        self.seat.push(spot.seat);
        self.normal.len() as u32 - 1
    }

    /// Collapses an edge and refreshes what is known.
    pub fn collapse(&mut self, h: u32, keep: crate::mesh::Keep) -> u32 {
        let (_, kept) = self.mesh.gone_and_kept(h, keep);
        self.mesh.collapse(h, keep);
        self.refresh_around(kept);
        kept
    }
}
