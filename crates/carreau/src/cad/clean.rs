//! The map of the regions, cleaned before any topology: neighbours on one surface become one, and crumbs go to the neighbour that they
//! lie on.

use super::regions::{Map, Piece, Rung, area_vector, connected, inner_vertices, vertex_ids, vertices};
use super::tuning::{EXACT_TOLERANCE, FILE_PRECISION, REFINE_STEPS};
use crate::brep::Surface;
use crate::geometry::primitive::{Kind, Primitive, Scratch, fit, refine};
use crate::mesh::{NONE, Triangles};
use crate::numeric::eigen3::{Eigen3, outer};
use crate::segment::Segmentation;
use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// A count: most vertices that a surface is fitted to; more are thinned evenly, because they would not change it.
const CLEAN_SAMPLES: usize = 2000;
/// A count: fewest triangles of a lid, because two in one plane are a facet of a curved surface.
const LID_TRIANGLES: usize = 3;
/// A count: fewest triangles of a flat part of a free piece, because two in one plane are a facet of a curved surface, and two
/// facets may follow each other on something straight.
const FLAT_TRIANGLES: usize = 5;
/// Sine of the largest angle between triangles of one plane, because normals of float precision are no surer.
const LID_SINE: f64 = 1e-5;
/// A factor: lids are so many times deeper in the surface than its facets, because facets of one surface are about as
/// deep.
const LID_DEPTH: f64 = 3.0;
/// A count: a piece of so many triangles lies on its surface by no chance, because they have more vertices than a
/// surface has numbers.
pub const CERTAIN_TRIANGLES: usize = 6;
/// A count: most triangles of a crumb, because a triangle or two lie on many surfaces.
const CRUMB_TRIANGLES: usize = 2;
/// A count: a surface is fitted to inner vertices alone if there are so many for each of its numbers, because noise
/// would decide otherwise.
const INNER_VERTICES_A_NUMBER: usize = 4;
/// A share of the breadth of all vertices: inner ones of less say nothing about the direction across, because a surface
/// can turn around a single row of them.
const LEAST_BREADTH: f64 = 0.4;

impl<'a> Map<'a> {
    /// The map of a segmentation. Regions without a surface are pieces on the spline rung.
    pub fn new(t: Triangles<'a>, diagonal: f64, found: &Segmentation) -> Self {
        let tolerance = tolerance(found, diagonal);
        let mut label = found.labels.clone();
        let mut primitives: Vec<Option<Primitive>> = found.regions.iter().map(|r| r.primitive).collect();
        let mut shared = Shared { t, tolerance, label: &mut label, primitives: &mut primitives };
        shared.absorb_crumbs();
        let precision = FILE_PRECISION * diagonal;
        let mut map = Map { t, diagonal, tolerance, precision, label: Vec::new(), pieces: Vec::new(), next: 0 };
        map.collect(&label, &primitives);
        map
    }

    /// Makes one of neighbours that lie on one surface.
    pub fn unify(&mut self) {
        let mut pairs: Vec<[u32; 2]> = (0..3 * self.t.len() as u32)
            .filter(|&c| self.t.opposite(c) != NONE)
            .map(|c| [self.label[c as usize / 3], self.label[self.t.opposite(c) as usize / 3]])
            .filter(|[a, b]| a < b)
            .collect();
        pairs.sort_unstable();
        pairs.dedup();
        let mut home: Vec<u32> = (0..self.pieces.len() as u32).collect();
        let root = |home: &[u32], mut l: u32| {
            while home[l as usize] != l {
                l = home[l as usize];
            }
            l
        };
        let extent = |p: &Piece| -> f64 { p.triangles.iter().map(|&k| area_vector(self.t, k).length()).sum() };
        let area: Vec<f64> = self.pieces.iter().map(extent).collect();
        for [a, b] in pairs {
            let (a, b) = (root(&home, a), root(&home, b));
            let (large, small) = if area[a as usize] >= area[b as usize] { (a, b) } else { (b, a) };
            if a != b && self.is_continued(large, small) {
                home[small as usize] = large;
            }
        }
        let mut groups: Vec<(u32, u32)> = (0u32..).zip(&home).map(|(p, _)| (root(&home, p), p)).collect();
        groups.sort_unstable();
        for group in groups.chunk_by(|a, b| a.0 == b.0).filter(|g| g.len() > 1) {
            let Some(primitive) = self.pieces[group[0].0 as usize].primitive else { continue };
            let which: Vec<u32> = group.iter().map(|g| g.1).collect();
            let mut triangles: Vec<u32> =
                which.iter().flat_map(|&p| self.pieces[p as usize].triangles.iter().copied()).collect();
            triangles.sort_unstable();
            let primitive = fitted_again(self.t, primitive, &triangles, &[], self.diagonal);
            self.replace(&which, vec![(triangles, Some((Surface::of_primitive(&primitive), Some(primitive))))]);
        }
        self.compact();
    }

    /// Makes pieces of the flat lids of curved ones: all corners of a disc lie on the surface that its rim is on, but the disc is far
    /// inside of it.
    ///
    /// ```text
    ///       ____●════════════●____       ════  a lid
    ///     ●╱                      ╲●     ────  facets of a torus
    /// ```
    pub fn part_lids(&mut self) {
        for p in 0..self.pieces.len() {
            let piece = &self.pieces[p];
            let Some(primitive) = piece.primitive.filter(|q| q.kind() != Kind::Plane) else { continue };
            let sets = self.coplanar(&piece.triangles);
            let (flat, rest): (Vec<&Vec<u32>>, Vec<&Vec<u32>>) = sets.iter().partition(|s| s.len() >= LID_TRIANGLES);
            let deepest = rest.iter().map(|s| sagitta(self.t, s, &primitive)).fold(0.0, f64::max);
            let is_lid = |s: &&&Vec<u32>| sagitta(self.t, s, &primitive) > LID_DEPTH * deepest;
            let lids: Vec<Vec<u32>> = flat.iter().filter(is_lid).map(|s| s.to_vec()).collect();
            if rest.is_empty() || lids.is_empty() {
                continue;
            }
            let mut sides = piece.triangles.clone();
            sides.retain(|k| lids.iter().all(|l| l.binary_search(k).is_err()));
            let mut parts = vec![(sides, Some((piece.surface.clone(), Some(primitive))))];
            parts.extend(lids.into_iter().map(|lid| {
                let plane = self.plane_of(&lid);
                (lid, Some((Surface::of_primitive(&plane), Some(plane))))
            }));
            self.replace(&[p as u32], parts);
        }
        self.compact();
    }

    /// In exact data, makes planes of the flat parts of pieces without a surface; whether there were any.
    pub fn part_flats(&mut self) -> bool {
        let mut any = false;
        for p in 0..self.pieces.len() {
            let piece = &self.pieces[p];
            if piece.rung != Rung::Spline {
                continue;
            }
            let mut sets = self.coplanar(&piece.triangles);
            sets.retain(|s| s.len() >= FLAT_TRIANGLES);
            if sets.is_empty() {
                continue;
            }
            any = true;
            let parts = sets.into_iter().map(|flat| {
                let plane = self.plane_of(&flat);
                (flat, Some((Surface::of_primitive(&plane), Some(plane))))
            });
            self.replace(&[p as u32], parts.collect());
        }
        self.compact();
        any
    }

    /// Connected sets of triangles in one plane.
    fn coplanar(&self, triangles: &[u32]) -> Vec<Vec<u32>> {
        connected(self.t, triangles, |k, n| {
            let [a, b] = [k, n].map(|k| area_vector(self.t, k));
            a.cross(b).length() <= LID_SINE * a.length() * b.length() && a.dot(b) > 0.0
        })
    }

    /// The plane of triangles that are in one.
    fn plane_of(&self, triangles: &[u32]) -> Primitive {
        let normal = triangles.iter().map(|&k| area_vector(self.t, k)).sum::<DVec3>().normalize_or_zero();
        Primitive::Plane { origin: self.t.point(3 * triangles[0]), normal }
    }

    /// Whether no piece lies on a surface of a kind.
    pub fn is_free(&self) -> bool {
        self.pieces.iter().all(|p| p.rung == Rung::Spline)
    }

    /// Whether a piece lies on the surface of a larger one, and both look the same way there, within the angle of its facets.
    fn is_continued(&self, large: u32, small: u32) -> bool {
        let [large, small] = [large, small].map(|p| &self.pieces[p as usize]);
        let (Some(p), Some(q)) = (large.primitive, small.primitive) else { return false };
        let middle = |k: u32| self.t.triangle(k).map(|v| self.t.points()[v as usize]).iter().sum::<DVec3>() / 3.0;
        let alike = |&k: &u32| p.normal(middle(k)).dot(q.normal(middle(k))).abs() > 0.9;
        let near = |x: &DVec3| p.distance(*x).abs() <= self.tolerance;
        p.kind() == q.kind() && small.triangles.iter().all(alike) && vertices(self.t, &small.triangles).iter().all(near)
    }

    /// Pieces of labels: connected parts of each, fitted again.
    fn collect(&mut self, label: &[u32], primitives: &[Option<Primitive>]) {
        let t = self.t;
        let (part, regions) = parts_of(t, label);
        let inner = if self.is_noisy() { inner_vertices(t, &part) } else { Vec::new() };
        let mut triangles = vec![Vec::new(); regions.len()];
        part.iter().zip(0u32..).for_each(|(&p, k)| triangles[p as usize].push(k));
        self.pieces = triangles
            .into_par_iter()
            .zip(regions)
            .map(|(triangles, region)| match primitives[region as usize] {
                Some(p) => {
                    let p = fitted_again(t, p, &triangles, &inner, self.diagonal);
                    Piece::on(t, triangles, Surface::of_primitive(&p), Some(p), region)
                }
                None => Piece::free(t, triangles, region),
            })
            .collect();
        self.label = part;
        self.pieces.iter_mut().zip(0u64..).for_each(|(piece, id)| piece.id = id);
        self.next = self.pieces.len() as u64;
    }
}

/// How far vertices may be from their surfaces. That of exact data is a share of the diagonal here; the segmentation has axes of its
/// own, in which this is up to √3 times as long.
fn tolerance(found: &Segmentation, diagonal: f64) -> f64 {
    let (exact, tolerance) = (EXACT_TOLERANCE * diagonal, found.chosen.tolerance);
    let is_exact = found.chosen.noise == 0.0 && tolerance <= 3f64.sqrt() * exact;
    if is_exact { tolerance.min(exact) } else { tolerance }
}

/// The surface of a region, fitted to all of it, or to its inner vertices where these are known and enough.
fn fitted_again(t: Triangles<'_>, p: Primitive, triangles: &[u32], inner: &[bool], diagonal: f64) -> Primitive {
    let points = fitting_points(t, triangles, inner, p.kind());
    let step = points.len().div_ceil(CLEAN_SAMPLES).max(1);
    let some: Vec<DVec3> = points.iter().copied().step_by(step).collect();
    let far = |p: &Primitive| points.iter().map(|&q| p.distance(q).abs()).fold(0.0, f64::max);
    let again = refine(p, &some, None, REFINE_STEPS).map(|f| f.primitive).filter(|q| far(q) <= 2.0 * far(&p));
    let p = again.unwrap_or(p);
    straighter(t, triangles, p, far(&p), diagonal)
}

/// The vertices that the surface of a piece is fitted to: the inner ones where these are known, many enough, and spread like all; a
/// strip with one row of inner vertices could turn around them.
pub fn fitting_points(t: Triangles<'_>, triangles: &[u32], inner: &[bool], kind: Kind) -> Vec<DVec3> {
    let is_inner = |v: &u32| inner.get(*v as usize).is_some_and(|&x| x);
    let some: Vec<DVec3> =
        vertex_ids(t, triangles).into_iter().filter(is_inner).map(|v| t.points()[v as usize]).collect();
    if some.len() < INNER_VERTICES_A_NUMBER * kind.parameters() {
        return vertices(t, triangles);
    }
    let all = vertices(t, triangles);
    if breadth(&some) >= LEAST_BREADTH * breadth(&all) { some } else { all }
}

/// The standard deviation of points along the second of their principal axes.
fn breadth(points: &[DVec3]) -> f64 {
    let middle = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
    let spread = points.iter().fold(DMat3::ZERO, |sum, &p| sum + outer(p - middle));
    (Eigen3::new(spread).values[1].max(0.0) / points.len().max(1) as f64).sqrt()
}

/// Connected parts of labels, and the label of each, in the order of their first triangles.
fn parts_of(t: Triangles<'_>, label: &[u32]) -> (Vec<u32>, Vec<u32>) {
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

/// Mean normals of the distinct vertices of triangles, in the order of [`vertices`].
pub fn normals(t: Triangles<'_>, triangles: &[u32]) -> Vec<DVec3> {
    let mut at: Vec<(u32, u32)> = triangles.iter().flat_map(|&k| t.triangle(k).map(|v| (v, k))).collect();
    at.sort_unstable();
    let sum = |corners: &[(u32, u32)]| corners.iter().map(|c| area_vector(t, c.1)).sum::<DVec3>().normalize_or_zero();
    at.chunk_by(|a, b| a.0 == b.0).map(sum).collect()
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
    let room = (2.0 * far).max(1e-2 * FILE_PRECISION * diagonal);
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
            if triangles.is_empty() || triangles.len() > CRUMB_TRIANGLES {
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
                let allowed = if own_plane { 1.2 * sagitta(self.t, &members[l as usize], &p) } else { f64::INFINITY };
                let curved = !own_plane || p.kind() != Kind::Plane;
                (d <= self.tolerance && curved && sagitta(self.t, triangles, &p) <= allowed).then_some((d, l))
            };
            let best = around.iter().filter_map(|&l| far(l)).min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            if let Some((_, home)) = best {
                triangles.iter().for_each(|&k| self.label[k as usize] = home);
            }
        }
    }
}

/// Largest distance of the middles of triangles' sides from a surface.
fn sagitta(t: Triangles<'_>, triangles: &[u32], p: &Primitive) -> f64 {
    let middle = |c: u32| 0.5 * (t.point(c) + t.point(t.next(c)));
    triangles.iter().flat_map(|&k| 3 * k..3 * k + 3).map(|c| p.distance(middle(c)).abs()).fold(0.0, f64::max)
}
