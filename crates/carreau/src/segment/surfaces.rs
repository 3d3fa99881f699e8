//! The surfaces of a part, from the most exact tolerance to the loosest: curved ones are recognised, planes are facets
//! that are no strips, and free triangles that lie on a neighbour's surface join it.

use super::facets::Facets;
use super::precision;
use super::probe::has_surfaces;
use super::recognise::{Accuracy, MOST_SOFT, recognise, softness};
use super::regions::Groups;
use super::surface::{Lies, Surface};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::primitive::{Kind, Primitive, refine};
use crate::mesh::NONE;
use glam::DVec3;
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
pub const COARSEST_BEND: f64 = 1.05;
/// Multiple of the tolerance from which stray triangles join a surface, because their vertices were put anywhere near
/// it.
const STRAY_FACTOR: f64 = 20.0;
/// A count: triangles that a plane is fitted to, because more would not change it.
const PLANE_SAMPLES: usize = 300;
/// A count: steps of that fit, few because it starts near.
const PLANE_STEPS: usize = 8;
/// A share of the area that must lie on recognised surfaces for the mesh to be a part, because less may be chance.
pub const PART_SHARE: f64 = 0.02;
/// A share of the area: surfaces with less do not make a part, because a few triangles are on some surface by chance.
pub const WORTH_AREA: f64 = 2e-4;

/// The surfaces that were found.
pub struct Surfaces {
    /// Surface of every triangle; [`NONE`] where none was found.
    pub label: Vec<u32>,
    pub primitives: Vec<Primitive>,
    /// Which of them may be pieces of freeform surfaces.
    pub weak: Vec<u32>,
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

    /// Share of the area that lies on surfaces worth the name: the facets of a polyhedron without end are none.
    pub fn share(&self, surface: &Surface<'_>) -> f64 {
        let mut area = vec![0.0; self.primitives.len()];
        for (&l, &a) in self.label.iter().zip(&surface.areas).filter(|(l, _)| **l != NONE) {
            area[l as usize] += a;
        }
        let total = surface.total_area.max(f64::MIN_POSITIVE);
        area.into_iter().filter(|&a| a > WORTH_AREA * total).sum::<f64>() / total
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
