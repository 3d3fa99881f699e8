//! The surfaces of a part, from the most exact tolerance to the loosest: curved ones are recognised, planes are facets
//! that are no strips, and free triangles that lie on a neighbour's surface join it.

use super::facets::Facets;
use super::precision;
use super::probe::has_surfaces;
use super::recognise::{Accuracy, MOST_SOFT, recognise, softness};
use super::regions::{Groups, count, fit_region};
use super::strips::{fragments, rows};
use super::surface::{Lies, Surface, quantile};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::normals::angle_between;
use crate::geometry::primitive::{Kind, Primitive, refine};
use crate::mesh::NONE;
use glam::DVec3;
use rustc_hash::FxHashMap;
use std::collections::VecDeque;

/// Shares of the extent: tolerances after the first, because CAD kernels agree with themselves to the first of these,
/// careless ones to the second.
const TOLERANCE_RUNGS: [f64; 2] = [2e-6, 2e-5];
/// Radians, 1°: noise of normals, because triangles of one surface agree with it to this angle.
pub const NORMAL_NOISE: f64 = 0.0175;
/// Radians: largest bend of an edge inside a curved surface, because regular polygons of eight sides and fewer are to
/// stay polygons.
const SURFACE_BEND: f64 = 0.8;
/// A count: vertices of the first neighbourhood, one more than a torus has parameters.
const SEED_VERTICES: usize = 8;
/// A factor: a facet this many times as large as those around it is a plane, because facets of one surface are about
/// alike.
const PLANE_FACTOR: f64 = 8.0;
/// Radians, 30°: free triangles join a surface whose normals they miss by no more, because chords of a coarse
/// tessellation turn by half of that at their ends.
const JOIN_TURN: f64 = 0.52;
/// Radians, 60°: freeform surfaces bend between triangles by no more, however coarse they are, because sharper ones are
/// edges.
const COARSEST_BEND: f64 = 1.05;
/// A share of the edges inside a freeform surface that bend by less than its sharp angle, because the rest may be edges
/// of the part.
const USUAL_SHARE: f64 = 0.9;
/// A factor: the sharp angle of a freeform surface over that bend, because some of its edges bend by a little more.
const BEND_FACTOR: f64 = 1.3;
/// A count: half-edges of a free surface below which that says nothing, because a quantile of fewer is chance.
const FEW_EDGES: usize = 40;
/// Multiple of the tolerance from which stray triangles join a surface, because their vertices were put anywhere near
/// it.
const STRAY_FACTOR: f64 = 20.0;
/// Radians, 6°: strips of a curved surface bend by no more, because planes that bend more are the sides of a prism.
const STRIP_BEND: f64 = 0.105;
/// A count: rounds of freeing fragments of strips, because what is freed makes fragments of planes beside it.
const FRAGMENT_ROUNDS: usize = 4;
/// A count: triangles that a plane is fitted to, because more would not change it.
const PLANE_SAMPLES: usize = 300;
/// A count: steps of that fit, few because it starts near.
const PLANE_STEPS: usize = 8;
/// A share of the area: surfaces with less do not make a part, because a few triangles are on some surface by chance.
pub const WORTH_AREA: f64 = 2e-4;
/// A count: free pieces of no more directions are planes that meet, because the coarsest freeform surface has more.
const WEDGE_SIDES: usize = 3;
/// A count: free pieces of no more triangles are none of their own, because they say nothing about a surface.
const FREE_CRUMB: u32 = 4;

/// The surfaces that were found.
pub struct Surfaces {
    /// Surface of every triangle; [`NONE`] where none was found.
    pub label: Vec<u32>,
    pub primitives: Vec<Primitive>,
    /// Which of them may be pieces of freeform surfaces.
    weak: Vec<u32>,
    /// The loosest tolerance.
    pub tolerance: f64,
    /// The distance that the vertices of careful files are within.
    pub close: f64,
}

/// Finds planes and curved surfaces. `order` lists the triangles independently of their numbers, `extent` is that of the
/// surface; its vertices are rounded to `rounding`. `most` is the loosest tolerance, where one is given.
pub fn find(
    surface: &Surface<'_>,
    order: &[u32],
    [extent, rounding]: [f64; 2],
    sharp_angle: f64,
    most: Option<f64>,
    context: &Context,
) -> Result<Surfaces> {
    // Below what the file is rounded to there are only pieces of surfaces, by chance.
    let floor = precision::floor(surface, extent).max(rounding).min(most.unwrap_or(f64::INFINITY));
    let close = floor.max(TOLERANCE_RUNGS[0] * extent);
    let (label, primitives, weak) = (vec![NONE; surface.len()], Vec::new(), Vec::new());
    let mut found = Surfaces { label, primitives, weak, tolerance: floor, close };
    let rungs = rungs(extent, floor, most);
    let accuracy =
        |distance| Accuracy { distance, turn: NORMAL_NOISE, bend: SURFACE_BEND, seed_vertices: SEED_VERTICES };
    let (tightest, loosest) = (accuracy(floor), accuracy(rungs[rungs.len() - 1]));
    if !has_surfaces(surface, order, sharp_angle, [&tightest, &loosest], context)? {
        return Ok(found);
    }
    let by_area = surface.by_area(order);
    for (k, &distance) in rungs.iter().enumerate() {
        found.climb(surface, &by_area, sharp_angle, &accuracy(distance), k + 1 == rungs.len(), context)?;
        found.tolerance = distance;
    }
    found.absorb(surface, &joining(found.tolerance), |_| true);
    found.unite(surface);
    found.free_strips(surface, sharp_angle);
    Ok(found)
}

/// The tolerances, increasing: what the file is rounded to, and those of kernels. `most` ends them.
fn rungs(extent: f64, floor: f64, most: Option<f64>) -> Vec<f64> {
    let mut all: Vec<f64> = TOLERANCE_RUNGS.iter().map(|r| r * extent).collect();
    if let Some(most) = most {
        all.push(most);
        all.retain(|&r| r <= most);
    }
    all.retain(|&r| r > floor);
    all.push(floor);
    all.sort_unstable_by(f64::total_cmp);
    all
}

/// What a free triangle must do to join a surface beside it. Flats that are cut into a shaft have their corners on it, too.
fn joining(distance: f64) -> Lies {
    Lies { distance, turn: JOIN_TURN, spread: COARSEST_BEND }
}

impl Surfaces {
    /// One rung: the surfaces among the triangles that are still free.
    fn climb(
        &mut self,
        surface: &Surface<'_>,
        by_area: &[u32],
        sharp_angle: f64,
        accuracy: &Accuracy,
        last: bool,
        context: &Context,
    ) -> Result<()> {
        // What a tighter rung refused for a vertex that is off is no surface of its own.
        let close = Lies { distance: accuracy.distance, turn: NORMAL_NOISE, spread: SURFACE_BEND + NORMAL_NOISE };
        self.absorb(surface, &close, |_| true);
        let free: Vec<bool> = self.label.iter().map(|&l| l == NONE).collect();
        let facets = Facets::new(surface, &free, by_area, accuracy.distance, accuracy.turn, context)?;
        let (owner, curved) = recognise(surface, &facets, accuracy, context)?;
        let base = self.primitives.len() as u32;
        self.primitives.extend(curved.iter().map(|found| found.primitive));
        self.weak.extend((base..).zip(&curved).filter(|(_, found)| found.is_weak).map(|(l, _)| l));
        if last {
            self.assign(&facets, &owner, base);
            self.absorb(surface, &joining(STRAY_FACTOR * accuracy.distance), |t| {
                facets.of[t as usize] == NONE || facets.triangles(facets.of[t as usize]).len() <= 2
            });
        }
        let planes = Planes { surface, facets: &facets, owner: &owner, sharp_angle, accuracy, last };
        let mut strips = Vec::new();
        for f in 0..facets.len() as u32 {
            if facets.triangles(f).iter().all(|&t| self.label[t as usize] == NONE) && planes.contains(f) {
                let label = self.primitives.len() as u32;
                self.primitives.push(planes.plane(f));
                facets.triangles(f).iter().for_each(|&t| self.label[t as usize] = label);
                if planes.is_strip(f) {
                    strips.push(f);
                }
            }
        }
        self.assign(&facets, &owner, base);
        if last {
            self.release(surface, &facets, strips, sharp_angle);
        }
        Ok(())
    }

    /// Frees strips beside a free surface that bends as much in itself as it does towards them: they are a part of it. A
    /// single triangle is on a plane of its own anyway, which says nothing.
    fn release(&mut self, surface: &Surface<'_>, facets: &Facets, mut strips: Vec<u32>, sharp_angle: f64) {
        let t = surface.triangles;
        let limit = self.free_sharp_angle(surface, sharp_angle);
        loop {
            let belongs = |f: &u32| {
                let limit = if facets.triangles(*f).len() == 1 { limit.max(COARSEST_BEND) } else { limit };
                facets.triangles(*f).iter().flat_map(|&k| 3 * k..3 * k + 3).any(|c| {
                    let o = t.opposite(c);
                    o != NONE && self.label[o as usize / 3] == NONE && f64::from(surface.bend[c as usize]) <= limit
                })
            };
            let (freed, kept): (Vec<u32>, Vec<u32>) = strips.into_iter().partition(belongs);
            if freed.is_empty() {
                return;
            }
            freed.iter().flat_map(|&f| facets.triangles(f)).for_each(|&k| self.label[k as usize] = NONE);
            strips = kept;
        }
    }

    /// Labels the triangles of facets with an owner.
    fn assign(&mut self, facets: &Facets, owner: &[u32], base: u32) {
        for (f, &owner) in owner.iter().enumerate().filter(|(_, o)| **o != NONE) {
            facets.triangles(f as u32).iter().for_each(|&t| self.label[t as usize] = base + owner);
        }
    }

    /// Gives free triangles to a neighbouring surface that all their vertices lie on and whose normals they follow: slivers,
    /// and triangles that bend more than the rest.
    fn absorb(&mut self, surface: &Surface<'_>, demand: &Lies, may: impl Fn(u32) -> bool) {
        let t = surface.triangles;
        let mut queue: VecDeque<u32> = (0..surface.len() as u32).filter(|&k| self.label[k as usize] != NONE).collect();
        while let Some(k) = queue.pop_front() {
            let label = self.label[k as usize];
            let p = self.primitives[label as usize];
            let sign = surface.side(k, &p);
            for o in (3 * k..3 * k + 3).map(|c| t.opposite(c)).filter(|&o| o != NONE) {
                let n = o / 3;
                if self.label[n as usize] == NONE && may(n) && surface.lies_on(n, &p, sign, demand) {
                    self.label[n as usize] = label;
                    queue.push_back(n);
                }
            }
        }
    }

    /// Makes one surface of neighbours that lie on the same one: hypotheses that started from different strips stop at
    /// each other.
    fn unite(&mut self, surface: &Surface<'_>) {
        let t = surface.triangles;
        let crossing =
            |c: &u32| t.opposite(*c) != NONE && self.label[*c as usize / 3] < self.label[t.opposite(*c) as usize / 3];
        let pair = |c: u32| [self.label[c as usize / 3], self.label[t.opposite(c) as usize / 3]];
        let mut pairs: Vec<[u32; 2]> = (0..3 * surface.len() as u32).filter(crossing).map(pair).collect();
        pairs.retain(|p| p[1] != NONE && self.kind(p[0]) == self.kind(p[1]));
        pairs.sort_unstable();
        pairs.dedup();
        if pairs.is_empty() {
            return;
        }
        let groups = Groups::new(&self.label, self.primitives.len());
        let area: Vec<f64> =
            (0..groups.len() as u32).map(|l| groups.of(l).iter().map(|&k| surface.areas[k as usize]).sum()).collect();
        let mut home: Vec<u32> = (0..self.primitives.len() as u32).collect();
        let root = |home: &[u32], mut l: u32| {
            while home[l as usize] != l {
                l = home[l as usize];
            }
            l
        };
        for [a, b] in pairs {
            let (a, b) = (root(&home, a), root(&home, b));
            let (large, small) = if area[a as usize] >= area[b as usize] { (a, b) } else { (b, a) };
            if a != b && self.lies_on(surface, groups.of(small), groups.of(large)[0], large) {
                home[small as usize] = large;
            }
        }
        self.label.iter_mut().filter(|l| **l != NONE).for_each(|l| *l = root(&home, *l));
    }

    /// Frees the flat strips of curved surfaces that were subdivided.
    fn free_strips(&mut self, surface: &Surface<'_>, sharp_angle: f64) {
        let is_plane: Vec<bool> = self.primitives.iter().map(|p| p.kind() == Kind::Plane).collect();
        let bends = NORMAL_NOISE..STRIP_BEND.min(sharp_angle);
        let free = |label: &mut [u32], gone: Vec<bool>| {
            let old = label.iter_mut().filter(|l| **l != NONE && gone[**l as usize]);
            old.map(|l| *l = NONE).count() > 0
        };
        let found = rows(surface, &self.label, &is_plane, &bends);
        free(&mut self.label, found);
        // Fragments that are free make others free.
        for _ in 0..FRAGMENT_ROUNDS {
            let found = fragments(surface, &self.label, &is_plane, &bends);
            if !free(&mut self.label, found) {
                return;
            }
        }
    }

    /// Frees weak surfaces with more than half of their border towards free ones, one after the other: those between the faces of a
    /// part are blends, the others are pieces of what is around them.
    pub fn free_weak(&mut self, surface: &Surface<'_>) {
        let t = surface.triangles;
        let groups = Groups::new(&self.label, self.primitives.len());
        let mut weak = std::mem::take(&mut self.weak);
        loop {
            let is_piece = |l: &u32| {
                let (mut free, mut all) = (0.0, 0.0);
                for c in groups.of(*l).iter().flat_map(|&k| 3 * k..3 * k + 3) {
                    let beyond = if t.opposite(c) == NONE { *l } else { self.label[t.opposite(c) as usize / 3] };
                    let length = if beyond == *l { 0.0 } else { surface.edge_length(c) };
                    all += length;
                    free += if beyond == NONE { length } else { 0.0 };
                }
                free > 0.5 * all
            };
            let (pieces, kept): (Vec<u32>, Vec<u32>) = weak.iter().partition(|l| is_piece(l));
            if pieces.is_empty() {
                return;
            }
            pieces.iter().flat_map(|&l| groups.of(l)).for_each(|&k| self.label[k as usize] = NONE);
            weak = kept;
        }
    }

    fn kind(&self, label: u32) -> Kind {
        self.primitives[label as usize].kind()
    }

    /// Whether triangles lie on a surface and look along it as its own triangle `model` does.
    fn lies_on(&self, surface: &Surface<'_>, triangles: &[u32], model: u32, label: u32) -> bool {
        let p = &self.primitives[label as usize];
        let sign = surface.side(model, p);
        let demand = Lies { distance: self.tolerance, turn: NORMAL_NOISE, spread: SURFACE_BEND + NORMAL_NOISE };
        triangles.iter().all(|&k| surface.lies_on(k, p, sign, &demand))
    }

    /// Bends above this are sharp on the free surface, in radians: the sharp angle adapts to how much it bends between its
    /// triangles.
    fn free_sharp_angle(&self, surface: &Surface<'_>, sharp_angle: f64) -> f64 {
        let t = surface.triangles;
        let free = |k: u32| self.label[k as usize] == NONE;
        let inner = |c: &u32| t.opposite(*c) != NONE && free(*c / 3) && free(t.opposite(*c) / 3);
        let mut bends: Vec<f32> =
            (0..3 * surface.len() as u32).filter(inner).map(|c| surface.bend[c as usize]).collect();
        let typical = 3.0 * quantile(&mut bends, 0.5, f32::total_cmp).map_or(0.0, f64::from);
        let most = BEND_FACTOR * quantile(&mut bends, USUAL_SHARE, f32::total_cmp).map_or(0.0, f64::from);
        // A few edges have no distribution.
        let limit = if bends.len() < FEW_EDGES { typical } else { typical.max(most) };
        limit.max(sharp_angle).min(COARSEST_BEND.max(sharp_angle))
    }

    /// Share of the area that lies on surfaces worth the name: the facets of a polyhedron without end are none.
    pub fn share(&self, surface: &Surface<'_>) -> f64 {
        let mut area = vec![0.0; self.primitives.len()];
        for (&l, &a) in self.label.iter().zip(&surface.areas).filter(|(l, _)| **l != NONE) {
            area[l as usize] += a;
        }
        let total = surface.total_area.max(f64::MIN_POSITIVE);
        area.into_iter().filter(|&a| a > WORTH_AREA * total).sum::<f64>() / total
    }

    /// Labels for what is left: connected free triangles between sharp edges, where the sharp angle adapts to how much the
    /// free surface bends between its triangles. Single crumbs go to the free region beside them.
    pub fn complete(&self, surface: &Surface<'_>, order: &[u32], sharp_angle: f64) -> Vec<u32> {
        let limit = self.free_sharp_angle(surface, sharp_angle);
        let mut label = self.label.clone();
        let open = |c: u32| f64::from(surface.bend[c as usize]) <= limit;
        surface.flood(order, &mut label, self.primitives.len() as u32, open, |_, _| ());
        dissolve_crumbs(surface, &mut label, self.primitives.len() as u32);
        divide_wedges(surface, &mut label, self.primitives.len() as u32, self.tolerance);
        label
    }
}

/// Gives free pieces of a few triangles to the larger free piece that they have the longest boundary with, where the mesh
/// bends no more than a coarse surface does. Labels from `first_free` on are free.
fn dissolve_crumbs(surface: &Surface<'_>, label: &mut [u32], first_free: u32) {
    const ROUNDS: usize = 8;
    let t = surface.triangles;
    for _ in 0..ROUNDS {
        let count = count(label);
        let mut size = vec![0u32; count];
        label.iter().for_each(|&l| size[l as usize] += 1);
        let crumb = |l: u32| l >= first_free && size[l as usize] <= FREE_CRUMB;
        let larger = |a: u32, b: u32| b >= first_free && (size[b as usize], b) > (size[a as usize], a);
        let mut common: FxHashMap<(u32, u32), f64> = FxHashMap::default();
        for c in 0..3 * surface.len() as u32 {
            let o = t.opposite(c);
            if o == NONE || f64::from(surface.bend[c as usize]) > COARSEST_BEND {
                continue;
            }
            let (a, b) = (label[c as usize / 3], label[o as usize / 3]);
            if a != b && crumb(a) && larger(a, b) {
                *common.entry((a, b)).or_default() += surface.edge_length(c);
            }
        }
        if common.is_empty() {
            return;
        }
        let mut pairs: Vec<((u32, u32), f64)> = common.into_iter().collect();
        pairs.sort_by(|x, y| x.0.0.cmp(&y.0.0).then(y.1.total_cmp(&x.1)).then(x.0.1.cmp(&y.0.1)));
        let mut into: Vec<u32> = (0..count as u32).collect();
        for group in pairs.chunk_by(|x, y| x.0.0 == y.0.0) {
            let ((crumb, home), _) = group[0];
            into[crumb as usize] = home;
        }
        label.iter_mut().for_each(|l| *l = into[*l as usize]);
    }
}

/// Divides free pieces of a few flat facets: planes that meet, unless three are strips of a curved surface.
fn divide_wedges(surface: &Surface<'_>, label: &mut [u32], first_free: u32, tolerance: f64) {
    let groups = Groups::new(label, count(label));
    let count = groups.len() as u32;
    let flat = |a: u32, b: u32| angle_between(surface.normals[a as usize], surface.normals[b as usize]) <= NORMAL_NOISE;
    let mut next = count;
    for l in first_free..count {
        let mut sides: Vec<Vec<u32>> = Vec::new();
        for &k in groups.of(l) {
            match sides.iter_mut().find(|side| flat(side[0], k)) {
                Some(side) => side.push(k),
                None => sides.push(vec![k]),
            }
            if sides.len() > WEDGE_SIDES {
                break;
            }
        }
        // A single triangle is a crumb.
        if sides.len() > WEDGE_SIDES || sides.iter().any(|side| side.len() < 2) {
            continue;
        }
        // Two strips are on a cylinder in any case.
        if sides.len() > 2 && fit_region(surface, groups.of(l), tolerance, &Kind::ALL).is_some() {
            continue;
        }
        for side in sides.iter().skip(1) {
            side.iter().for_each(|&k| label[k as usize] = next);
            next += 1;
        }
    }
}

/// Which facets are planes of the part.
pub struct Planes<'a> {
    pub surface: &'a Surface<'a>,
    pub facets: &'a Facets,
    /// Curved surface of every facet, or [`NONE`].
    pub owner: &'a [u32],
    pub sharp_angle: f64,
    pub accuracy: &'a Accuracy,
    /// No looser tolerance follows: what may be a strip of a surface that was not found is decided now.
    pub last: bool,
}

impl Planes<'_> {
    fn plane(&self, f: u32) -> Primitive {
        let triangles = self.facets.triangles(f);
        let t = self.surface.triangles;
        let origin = t.point(3 * triangles[0]);
        let rough = Primitive::Plane { origin, normal: self.facets.normal[f as usize] };
        // The normals of the triangles say where it looks; its vertices, farther apart, where it lies.
        let step = triangles.len().div_ceil(PLANE_SAMPLES).max(1);
        let points: Vec<DVec3> =
            triangles.iter().step_by(step).flat_map(|&k| t.triangle(k)).map(|v| t.points()[v as usize]).collect();
        refine(rough, &points, None, PLANE_STEPS).map_or(rough, |fit| fit.primitive)
    }

    /// Whether a facet is a plane of the part.
    pub fn contains(&self, f: u32) -> bool {
        if self.owner[f as usize] != NONE {
            return false;
        }
        let strip = self.is_strip(f);
        let Some(around) = self.mean_area_around(f) else { return self.last || !strip };
        let large = self.last && self.facets.area[f as usize] > PLANE_FACTOR * around;
        (large || !strip) && softness(self.surface, self.facets, self.accuracy, &self.plane(f), &[f]) <= MOST_SOFT
    }

    /// Mean area of the free facets beyond smooth edges; `None` where there is none.
    fn mean_area_around(&self, f: u32) -> Option<f64> {
        let t = self.surface.triangles;
        let (mut area, mut count) = (0.0, 0.0);
        for c in self.facets.triangles(f).iter().flat_map(|&k| 3 * k..3 * k + 3) {
            let o = t.opposite(c);
            if o == NONE || f64::from(self.surface.bend[c as usize]) > self.sharp_angle {
                continue;
            }
            let g = self.facets.of[o as usize / 3];
            if g != NONE && g != f && self.owner[g as usize] == NONE {
                area += self.facets.area[g as usize];
                count += 1.0;
            }
        }
        (count > 0.0).then(|| area / count)
    }

    /// Whether a facet may be a strip of a curved surface: up to two triangles, or all vertices on two parallel lines.
    fn is_strip(&self, f: u32) -> bool {
        const MOST_DIRECTIONS: usize = 64;
        let t = self.surface.triangles;
        let triangles = self.facets.triangles(f);
        if triangles.len() <= 2 {
            return true;
        }
        let corners = || triangles.iter().flat_map(|&k| 3 * k..3 * k + 3);
        let size = corners().map(|c| self.surface.edge_length(c)).fold(0.0, f64::max);
        let (normal, origin) = (self.facets.normal[f as usize], t.point(3 * triangles[0]));
        let on_two_lines = |along: DVec3| {
            let across = normal.cross(along).normalize_or_zero();
            let offsets = || corners().map(|c| (t.point(c) - origin).dot(across));
            let (low, high) = offsets().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
            let slack = 1e-4 * size;
            offsets().all(|x| x < low + slack || x > high - slack)
        };
        corners().take(MOST_DIRECTIONS).map(|c| t.point(t.next(c)) - t.point(c)).any(on_two_lines)
    }
}
