//! The map that the model is made from: every triangle belongs to a piece, every piece lies on a surface.
//!
//! Regions come from [`crate::segment`]. Before any topology, neighbours on one surface become one piece, and crumbs go to
//! the neighbour that they lie on.

use super::tuning::{CERTAIN, COARSEST, COPLANAR, COPLANAR_DISTANCE, FILE};
use crate::brep::Surface;
use crate::geometry::normals::{angle_between, unit};
use crate::geometry::primitive::{Kind, Primitive, Scratch, fit, refine};
use crate::mesh::{NONE, Triangles};
use crate::segment::Segmentation;
use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

/// Steps of a fit that starts from the result of another.
const REFINE_STEPS: usize = 30;
/// Most vertices that a surface is fitted to; evenly thinned beyond.
const MOST_SAMPLES: usize = 2000;
/// Triangles of a crumb.
const CRUMB: usize = 2;

/// How a piece of the mesh is described, the best first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Rung {
    /// A plane, cylinder, cone, sphere or torus.
    Analytic,
    /// A surface of extrusion or revolution.
    Swept,
    /// A spline surface.
    Spline,
    /// Plane faces, one for each set of coplanar triangles.
    Planes,
    /// A plane face for each triangle.
    Triangles,
}

/// A part of the mesh that becomes a face.
#[derive(Debug, Clone)]
pub struct Piece {
    /// Another number for every piece, and for a piece that is described in another way.
    pub id: u64,
    /// What it lies on.
    pub surface: Surface,
    /// The same where it is analytic.
    pub primitive: Option<Primitive>,
    /// How it is described.
    pub rung: Rung,
    /// The region of the segmentation that it is, or is a part of.
    pub region: u32,
    /// Whether the surface's normal points out of the body.
    pub same_sense: bool,
    /// Largest distance of its vertices from the surface.
    pub max: f64,
    /// How often it was cut.
    pub cuts: u8,
    /// Mean square of these distances.
    pub square: f64,
    /// Its triangles, ascending.
    pub triangles: Vec<u32>,
}

/// Pieces and the piece of every triangle.
#[derive(Clone)]
pub struct Map<'a> {
    /// The mesh.
    pub t: Triangles<'a>,
    /// The length that tolerances are shares of.
    pub diagonal: f64,
    /// Largest distance of a vertex from its surface.
    pub tolerance: f64,
    /// Piece of every triangle.
    pub label: Vec<u32>,
    /// All pieces.
    pub pieces: Vec<Piece>,
    /// Regions that had no surface from the beginning.
    pub free: Vec<u32>,
    /// What was spent on spline surfaces so far: see [`super::spline::MOST_EFFORT`].
    pub effort: u64,
    /// The number of the next piece.
    next: u64,
}

impl<'a> Map<'a> {
    /// The map of a segmentation. Regions without a surface are left as pieces with an empty list of triangles for the ladder.
    pub fn new(t: Triangles<'a>, diagonal: f64, found: &Segmentation) -> Self {
        let tolerance = found.chosen.tolerance;
        let mut label = found.labels.clone();
        let mut primitives: Vec<Option<Primitive>> = found.regions.iter().map(|r| r.primitive).collect();
        let mut shared = Shared { t, tolerance, label: &mut label, primitives: &mut primitives };
        shared.absorb_crumbs();
        let neighbours: Vec<(u32, u32)> = (0u32..)
            .zip(&found.regions)
            .flat_map(|(a, r)| r.neighbours.iter().map(move |&b| (a, b)))
            .filter(|(a, b)| a < b)
            .collect();
        shared.unify(&neighbours);
        let mut map =
            Map { t, diagonal, tolerance, label: Vec::new(), pieces: Vec::new(), free: Vec::new(), effort: 0, next: 0 };
        map.collect(&label, &primitives);
        map
    }

    /// Pieces of labels: connected parts of each, fitted again.
    fn collect(&mut self, label: &[u32], primitives: &[Option<Primitive>]) {
        let t = self.t;
        let (part, regions) = connected(t, label);
        let mut triangles = vec![Vec::new(); regions.len()];
        part.iter().zip(0u32..).for_each(|(&p, k)| triangles[p as usize].push(k));
        let pieces: Vec<Piece> = triangles
            .into_par_iter()
            .zip(regions)
            .map(|(triangles, region)| {
                let start = primitives[region as usize];
                let fit = start.map(|p| {
                    let points = vertices(t, &triangles);
                    let step = points.len().div_ceil(MOST_SAMPLES).max(1);
                    let some: Vec<DVec3> = points.iter().copied().step_by(step).collect();
                    let far = |p: &Primitive| points.iter().map(|&q| p.distance(q).abs()).fold(0.0, f64::max);
                    let again = refine(p, &some, None, REFINE_STEPS).map(|f| f.primitive);
                    again.filter(|q| far(q) <= 2.0 * far(&p)).map_or((p, far(&p)), |q| (q, far(&q)))
                });
                let fit = fit.map(|(p, far)| (straighter(t, &triangles, p, far, self.diagonal), far));
                let (primitive, max) = (fit.map(|f| f.0), fit.map_or(0.0, |f| f.1));
                let square = primitive.map_or(0.0, |p| mean_square(t, &triangles, |q| p.distance(q)));
                let surface = primitive.map_or(
                    Surface::Plane { frame: crate::brep::Frame::along(t.point(3 * triangles[0]), DVec3::Z) },
                    |p| Surface::of_primitive(&p),
                );
                let rung = if primitive.is_some() { Rung::Analytic } else { Rung::Spline };
                let mut piece = Piece {
                    id: 0,
                    surface,
                    primitive,
                    rung,
                    region,
                    same_sense: true,
                    max,
                    cuts: 0,
                    square,
                    triangles,
                };
                piece.same_sense = looks_along(t, &piece);
                piece
            })
            .collect();
        self.label = part;
        let mut pieces: Vec<Piece> = pieces;
        pieces.iter_mut().zip(0u64..).for_each(|(piece, id)| piece.id = id);
        self.next = pieces.len() as u64;
        self.free = (0..pieces.len() as u32).filter(|&p| pieces[p as usize].primitive.is_none()).collect();
        self.pieces = pieces;
    }

    /// Pieces on surfaces that a few flat sides lie on by chance: facets cut off a lot, and there are few vertices. Two flat sides
    /// have corners on some cylinder, but many vertices on one surface that bends both ways are no chance.
    pub fn coarse(&self) -> Vec<u32> {
        let is_coarse = |piece: &Piece| {
            let both_ways = matches!(piece.surface, Surface::Sphere { .. } | Surface::Torus { .. });
            let certain = both_ways && vertices(self.t, &piece.triangles).len() >= CERTAIN || self.is_fillet(piece);
            let swept = piece.rung < Rung::Spline && !certain;
            swept && sagitta(self.t, &piece.triangles, &piece.surface) > COARSEST * self.diagonal
        };
        (0u32..).zip(&self.pieces).filter(|(_, piece)| is_coarse(piece)).map(|(p, _)| p).collect()
    }

    /// Whether a piece is a cylinder that touches two planes beside it.
    fn is_fillet(&self, piece: &Piece) -> bool {
        let Some(Primitive::Cylinder { origin, axis, radius }) = piece.primitive else { return false };
        let corners = piece.triangles.iter().flat_map(|&k| 3 * k..3 * k + 3);
        let beyond = corners.map(|c| self.t.opposite(c)).filter(|&o| o != NONE).map(|o| self.label[o as usize / 3]);
        let mut around: Vec<u32> = beyond.collect();
        around.sort_unstable();
        around.dedup();
        let touches = |&p: &u32| match self.pieces[p as usize].primitive {
            Some(Primitive::Plane { origin: o, normal }) => {
                let off = (normal.dot(origin - o).abs() - radius).abs();
                normal.dot(axis).abs() < FILE && off <= FILE * self.diagonal
            }
            _ => false,
        };
        around.iter().filter(|p| touches(p)).count() >= 2
    }

    /// Puts plane facets in the place of pieces: sets of coplanar triangles, or single ones.
    pub fn divide(&mut self, which: &[u32], rung: Rung) {
        let t = self.t;
        let (angle, distance) = match rung {
            Rung::Triangles => (-1.0, -1.0),
            _ => (COPLANAR, COPLANAR_DISTANCE * self.diagonal),
        };
        for &p in which {
            let mut free: Vec<u32> = std::mem::take(&mut self.pieces[p as usize].triangles);
            let region = self.pieces[p as usize].region;
            let area = |k: u32| area_vector(t, k).length();
            // The largest triangles know their planes best.
            free.sort_by(|&a, &b| area(b).total_cmp(&area(a)).then(a.cmp(&b)));
            for &seed in &free {
                if self.label[seed as usize] != p {
                    continue;
                }
                let (origin, normal) = (t.point(3 * seed), unit(area_vector(t, seed)));
                let own = u32::MAX - 1;
                let mut group = vec![seed];
                self.label[seed as usize] = own;
                let mut at = 0;
                while at < group.len() {
                    for o in (3 * group[at]..3 * group[at] + 3).map(|c| t.opposite(c)).filter(|&o| o != NONE) {
                        let k = o / 3;
                        let flat = || {
                            let turn = angle_between(normal, unit(area_vector(t, k)));
                            turn <= angle && (t.point(t.previous(o)) - origin).dot(normal).abs() <= distance
                        };
                        if self.label[k as usize] == p && flat() {
                            self.label[k as usize] = own;
                            group.push(k);
                        }
                    }
                    at += 1;
                }
                group.sort_unstable();
                let frame = crate::brep::Frame::along(origin, normal);
                let piece = Piece {
                    id: self.new_id(),
                    surface: Surface::Plane { frame },
                    primitive: Some(Primitive::Plane { origin, normal }),
                    rung,
                    region,
                    same_sense: true,
                    max: 0.0,
                    cuts: 0,
                    square: 0.0,
                    triangles: group,
                };
                let id = self.pieces.len() as u32;
                piece.triangles.iter().for_each(|&k| self.label[k as usize] = id);
                self.pieces.push(piece);
            }
        }
    }

    /// A number that no piece has.
    pub fn new_id(&mut self) -> u64 {
        self.next += 1;
        self.next - 1
    }

    /// Makes splines of pieces, whose surfaces are still to be found.
    pub fn loosen(&mut self, which: &[u32]) {
        for &p in which {
            let id = self.new_id();
            let piece = &mut self.pieces[p as usize];
            (piece.id, piece.rung) = (id, Rung::Spline);
        }
    }

    /// Drops pieces without triangles and numbers the others in order.
    pub fn compact(&mut self) {
        let mut number = vec![NONE; self.pieces.len()];
        let mut kept = 0;
        for (n, piece) in number.iter_mut().zip(&self.pieces) {
            if !piece.triangles.is_empty() {
                *n = kept;
                kept += 1;
            }
        }
        self.pieces.retain(|p| !p.triangles.is_empty());
        self.label.iter_mut().for_each(|l| *l = number[*l as usize]);
    }
}

/// Twice the area times the normal of a triangle.
pub fn area_vector(t: Triangles<'_>, k: u32) -> DVec3 {
    let [a, b, c] = t.triangle(k).map(|v| t.points()[v as usize]);
    (b - a).cross(c - a)
}

/// Whether most of the area looks along the surface's normal.
pub fn looks_along(t: Triangles<'_>, piece: &Piece) -> bool {
    let along = |&k: &u32| {
        let center = t.triangle(k).map(|v| t.points()[v as usize]).iter().sum::<DVec3>() / 3.0;
        let [u, v] = piece.surface.project(center);
        piece.surface.normal(u, v).dot(area_vector(t, k))
    };
    piece.triangles.iter().map(along).sum::<f64>() >= 0.0
}

/// The distinct vertices of triangles.
pub fn vertices(t: Triangles<'_>, triangles: &[u32]) -> Vec<DVec3> {
    let mut ids: Vec<u32> = triangles.iter().flat_map(|&k| t.triangle(k)).collect();
    ids.sort_unstable();
    ids.dedup();
    ids.into_iter().map(|v| t.points()[v as usize]).collect()
}

/// The mean square of a distance of the vertices of triangles.
pub fn mean_square(t: Triangles<'_>, triangles: &[u32], distance: impl Fn(DVec3) -> f64) -> f64 {
    let points = vertices(t, triangles);
    points.iter().map(|&p| distance(p).powi(2)).sum::<f64>() / points.len().max(1) as f64
}

/// Mean normals of the distinct vertices of triangles, in the order of [`vertices`].
fn normals(t: Triangles<'_>, triangles: &[u32]) -> Vec<DVec3> {
    let mut at: Vec<(u32, u32)> = triangles.iter().flat_map(|&k| t.triangle(k).map(|v| (v, k))).collect();
    at.sort_unstable();
    let sum = |corners: &[(u32, u32)]| corners.iter().map(|c| area_vector(t, c.1)).sum::<DVec3>().normalize_or_zero();
    at.chunk_by(|a, b| a.0 == b.0).map(sum).collect()
}

/// Connected parts of labels, and the label of each, in the order of their first triangles.
fn connected(t: Triangles<'_>, label: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let mut part = vec![NONE; label.len()];
    let mut of = Vec::new();
    for seed in 0..t.len() as u32 {
        if part[seed as usize] != NONE {
            continue;
        }
        let id = of.len() as u32;
        of.push(label[seed as usize]);
        part[seed as usize] = id;
        let mut stack = vec![seed];
        while let Some(k) = stack.pop() {
            for o in (3 * k..3 * k + 3).map(|c| t.opposite(c)).filter(|&o| o != NONE) {
                let n = o / 3;
                if part[n as usize] == NONE && label[n as usize] == label[k as usize] {
                    part[n as usize] = id;
                    stack.push(n);
                }
            }
        }
    }
    (part, of)
}

/// The cone or cylinder through the vertices of what was taken for a sphere, where its facets follow that better: two rings of
/// vertices, as of a chamfer, lie on a sphere as well, but a sphere's triangles do not have straight generators.
fn straighter(t: Triangles<'_>, triangles: &[u32], p: Primitive, far: f64, diagonal: f64) -> Primitive {
    if p.kind() != Kind::Sphere {
        return p;
    }
    let points = vertices(t, triangles);
    let normals = normals(t, triangles);
    let mut scratch = Scratch::default();
    let room = (2.0 * far).max(1e-2 * FILE * diagonal);
    let of = |p: &Primitive| -> f64 {
        let side = |c: u32| p.distance(0.5 * (t.point(c) + t.point(t.next(c)))).powi(2);
        triangles.iter().flat_map(|&k| 3 * k..3 * k + 3).map(side).sum()
    };
    let mut best = (p, of(&p));
    for kind in [Kind::Cylinder, Kind::Cone] {
        if points.len() > kind.parameters() + 1
            && let Some(found) = fit(kind, &points, &normals, &mut scratch).filter(|f| f.max <= room)
            && of(&found.primitive) < best.1
        {
            best = (found.primitive, of(&found.primitive));
        }
    }
    if best.0 == p { p } else { refine(best.0, &points, None, REFINE_STEPS).map_or(best.0, |f| f.primitive) }
}

struct Shared<'a, 'b> {
    t: Triangles<'a>,
    tolerance: f64,
    label: &'b mut Vec<u32>,
    primitives: &'b mut Vec<Option<Primitive>>,
}

impl Shared<'_, '_> {
    /// Gives regions of a triangle or two to the neighbour whose surface all their vertices lie on.
    fn absorb_crumbs(&mut self) {
        let mut members = vec![Vec::new(); self.primitives.len()];
        self.label.iter().zip(0u32..).for_each(|(&l, k)| members[l as usize].push(k));
        for own in 0..members.len() as u32 {
            let triangles = &members[own as usize];
            if triangles.is_empty() || triangles.len() > CRUMB {
                continue;
            }
            let mut around: Vec<u32> = triangles
                .iter()
                .flat_map(|&k| 3 * k..3 * k + 3)
                .map(|c| self.t.opposite(c))
                .filter(|&o| o != NONE)
                .map(|o| self.label[o as usize / 3])
                .filter(|&l| l != own)
                .collect();
            around.sort_unstable();
            around.dedup();
            let points = vertices(self.t, triangles);
            let far = |l: u32| {
                let p = self.primitives[l as usize]?;
                let d = points.iter().map(|&q| p.distance(q).abs()).fold(0.0, f64::max);
                // A plane face of its own may have its corners on a curved neighbour; then it is farther inside than the
                // neighbour's facets.
                let own_plane = self.primitives[own as usize].is_some();
                let allowed = if own_plane { 1.2 * self.sagitta(&members[l as usize], &p) } else { f64::INFINITY };
                let curved = !own_plane || p.kind() != Kind::Plane;
                (d <= self.tolerance && curved && self.sagitta(triangles, &p) <= allowed).then_some((d, l))
            };
            let best = around.iter().filter_map(|&l| far(l)).min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            if let Some((_, home)) = best {
                triangles.iter().for_each(|&k| self.label[k as usize] = home);
            }
        }
    }

    /// Largest distance of the middles of triangles' sides from a surface.
    fn sagitta(&self, triangles: &[u32], p: &Primitive) -> f64 {
        let middle = |c: u32| 0.5 * (self.t.point(c) + self.t.point(self.t.next(c)));
        triangles.iter().flat_map(|&k| 3 * k..3 * k + 3).map(|c| p.distance(middle(c)).abs()).fold(0.0, f64::max)
    }

    /// Makes one of neighbours that lie on one surface.
    fn unify(&mut self, neighbours: &[(u32, u32)]) {
        let mut members = vec![Vec::new(); self.primitives.len()];
        self.label.iter().zip(0u32..).for_each(|(&l, k)| members[l as usize].push(k));
        let mut home: Vec<u32> = (0..members.len() as u32).collect();
        let root = |home: &[u32], mut l: u32| {
            while home[l as usize] != l {
                l = home[l as usize];
            }
            l
        };
        let extent = |triangles: &[u32]| -> f64 { triangles.iter().map(|&k| area_vector(self.t, k).length()).sum() };
        let area: Vec<f64> = members.iter().map(|m| extent(m)).collect();
        for &(a, b) in neighbours {
            let (a, b) = (root(&home, a), root(&home, b));
            let (large, small) = if area[a as usize] >= area[b as usize] { (a, b) } else { (b, a) };
            let (Some(p), Some(q)) = (self.primitives[large as usize], self.primitives[small as usize]) else {
                continue;
            };
            if a == b || p.kind() != q.kind() {
                continue;
            }
            let triangles = &members[small as usize];
            let near = vertices(self.t, triangles).iter().all(|&x| p.distance(x).abs() <= self.tolerance);
            // Both surfaces look the same way at the small one, within the angle of its facets.
            let alike = triangles.iter().all(|&k| {
                let c = self.t.triangle(k).map(|v| self.t.points()[v as usize]).iter().sum::<DVec3>() / 3.0;
                p.normal(c).dot(q.normal(c)).abs() > 0.9
            });
            if near && alike {
                home[small as usize] = large;
            }
        }
        self.label.iter_mut().for_each(|l| *l = root(&home, *l));
    }
}

/// How far facets cut off their surface: the largest distance of the middles of triangles and edges.
fn sagitta(t: Triangles<'_>, triangles: &[u32], surface: &Surface) -> f64 {
    let middles = triangles.iter().flat_map(|&k| {
        let [a, b, c] = [0, 1, 2].map(|i| t.point(3 * k + i));
        [(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0, (a + b + c) / 3.0]
    });
    middles.map(|p| surface.distance(p).abs()).fold(0.0, f64::max)
}
