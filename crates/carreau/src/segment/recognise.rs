//! Recognition of the surfaces a part is made of (beyond the paper; its constant-curvature regions fail where a torus
//! meets a cylinder, and where a coarse tessellation has no vertex inside a face).
//!
//! The vertices of a tessellated part lie on its surfaces. A hypothesis is fitted to a facet and its neighbours, grown
//! over all facets whose vertices lie on it and whose normals agree with it, fitted again, and kept when it explains
//! more than it has parameters. Facets that no curved surface takes are planes or stay free.

use super::facets::Facets;
use super::reach::{Around, Patch, Reach};
use super::regions::{Corners, sagitta};
use super::surface::{Lies, Surface};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::normals::angle_between;
use crate::geometry::primitive::{Kind, Primitive, Scratch, fit_within, refine};
use crate::mesh::NONE;
use crate::numeric::eigen3::{Eigen3, outer};
use glam::{DMat3, DVec3};
use rustc_hash::FxHashSet;

/// What counts as lying on a surface.
#[derive(Debug, Clone, Copy)]
pub struct Accuracy {
    /// Largest distance of a vertex.
    pub distance: f64,
    /// Noise of normals in radians.
    pub turn: f64,
    /// Largest bend of an edge inside a surface, in radians.
    pub bend: f64,
    /// Vertices of the first neighbourhood.
    pub seed_vertices: usize,
}

/// A surface that was found.
pub struct Found {
    pub primitive: Primitive,
    /// A torus through few vertices: it follows any smooth surface for a few triangles.
    pub is_weak: bool,
}

/// A count: vertices beyond the number of parameters that a surface must explain, because fewer are on some surface by
/// chance.
const LEAST_SURPLUS: usize = 4;
/// Multiple of the tolerance: a border is hard where the next vertices are farther away, because a freeform surface
/// leaves its piece slowly.
const HARD_BORDER: f64 = 30.0;
/// A share of the border of a surface that may be soft, because a piece of a freeform one has a soft border nearly all
/// around.
pub const MOST_SOFT: f64 = 0.3;
/// A share of the tolerance: a surface that uses up less is not one that the tolerance made possible, because a tenth
/// of it would have been enough.
const USED_TOLERANCE: f64 = 0.1;
/// A count: vertices beyond the number of parameters that a first neighbourhood has, because a fit through fewer would
/// lead anywhere.
const SEED_SURPLUS: usize = 3;
/// A count: a surface with so many vertices more than parameters is beyond doubt, because that is no chance.
const CERTAIN_SURPLUS: usize = 12;
/// A count: most rings of a neighbourhood, because a larger one reaches into other surfaces.
const MOST_RINGS: usize = 5;
/// Radians: angles that differ by less are one position of a profile, because rounding turns them.
const SAME_ANGLE: f64 = 1e-3;
/// A factor: the widest facet of a surface turns by no more than this many times the median facet, because a
/// tessellation divides a surface evenly.
const UNEVEN_TURN: f64 = 3.0;
/// A factor: the same for areas, more because strips are as long as the face is there.
const UNEVEN_AREA: f64 = 20.0;
/// A count: surfaces of more facets need not be even, because they are no coincidence.
const FEW_FACETS: usize = 40;
/// A count: a facet that was in so many neighbourhoods without a surface is no seed, because its own would be nearly
/// the same.
const SEED_FAILURES: u8 = 2;
/// A count: with more facets a few seeds are asked first, because a scan takes long and has no surface.
const PROBED_FACETS: usize = 20_000;
/// A count: seeds that are asked first, because among so many there is one of a surface in any part.
const PROBE_FACETS: usize = 200;
/// A count: most points given to a refit, because more would not change it.
const REFIT_SAMPLES: usize = 400;
/// Curved kinds, simplest first, because of equally good surfaces the first is taken.
const CURVED_KINDS: [Kind; 4] = [Kind::Sphere, Kind::Cylinder, Kind::Cone, Kind::Torus];

/// Recognises curved surfaces; returns the surface of every facet ([`NONE`]: none) and the surfaces.
pub fn recognise(
    surface: &Surface<'_>,
    facets: &Facets,
    accuracy: &Accuracy,
    context: &Context,
) -> Result<(Vec<u32>, Vec<Found>)> {
    let mut search = Search::new(surface, facets, *accuracy);
    let mut order: Vec<u32> = (0..facets.len() as u32).collect();
    // Large strips first: they say most about the surface.
    order.sort_by(|&a, &b| facets.area[b as usize].total_cmp(&facets.area[a as usize]));
    let probes = (0..PROBE_FACETS).map(|k| order[k * order.len() / PROBE_FACETS]);
    if facets.len() > PROBED_FACETS && !search.finds_any(probes, context)? {
        return Ok((search.owner, search.found));
    }
    let mut weak = Vec::new();
    for (step, &seed) in order.iter().enumerate() {
        if step.is_multiple_of(16) {
            context.check()?;
        }
        if search.owner[seed as usize] != NONE
            || search.tried[seed as usize]
            || search.failures[seed as usize] >= SEED_FAILURES
        {
            continue;
        }
        if let Some(found) = search.best_from(seed) {
            if search.is_soft(&found) {
                // No surface of its own but a piece of a freeform one, and so are the facets around.
                found.facets.iter().for_each(|&f| search.tried[f as usize] = true);
            } else if found.surplus >= CERTAIN_SURPLUS {
                search.claim(found);
            } else {
                weak.push(seed);
            }
        }
    }
    for seed in weak {
        if search.owner[seed as usize] == NONE
            && !search.tried[seed as usize]
            && let Some(found) = search.best_from(seed).filter(|f| !search.is_soft(f))
        {
            search.claim(found);
        }
    }
    Ok((search.owner, search.found))
}

/// Whether some of these facets lie on a curved surface beyond doubt.
pub fn finds_any(
    surface: &Surface<'_>,
    facets: &Facets,
    accuracy: &Accuracy,
    seeds: impl Iterator<Item = u32>,
    context: &Context,
) -> Result<bool> {
    Search::new(surface, facets, *accuracy).finds_any(seeds, context)
}

struct Candidate {
    primitive: Primitive,
    facets: Vec<u32>,
    surplus: usize,
    area: f64,
    sagitta: f64,
    max: f64,
}

struct Search<'a> {
    surface: &'a Surface<'a>,
    facets: &'a Facets,
    accuracy: Accuracy,
    owner: Vec<u32>,
    tried: Vec<bool>,
    failures: Vec<u8>,
    found: Vec<Found>,
    // Marks by stamp, so that nothing is cleared between hypotheses.
    facet_stamp: Vec<u32>,
    vertex_stamp: Vec<u32>,
    stamp: u32,
    scratch: Scratch,
    corners: Corners,
    points: Vec<DVec3>,
    normals: Vec<DVec3>,
}

impl<'a> Search<'a> {
    fn new(surface: &'a Surface<'a>, facets: &'a Facets, accuracy: Accuracy) -> Self {
        Search {
            surface,
            facets,
            accuracy,
            owner: vec![NONE; facets.len()],
            tried: vec![false; facets.len()],
            failures: vec![0; facets.len()],
            found: Vec::new(),
            facet_stamp: vec![0; facets.len()],
            vertex_stamp: vec![0; surface.triangles.points().len()],
            stamp: 0,
            scratch: Scratch::default(),
            corners: Corners::default(),
            points: Vec::new(),
            normals: Vec::new(),
        }
    }

    /// Whether some of these seeds find a surface beyond doubt: on a scan none does, and to ask all would take long.
    fn finds_any(&mut self, seeds: impl Iterator<Item = u32>, context: &Context) -> Result<bool> {
        for seed in seeds {
            context.check()?;
            if self.best_from(seed).is_some_and(|found| found.surplus >= CERTAIN_SURPLUS && !self.is_soft(&found)) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn around(&self) -> Around<'_> {
        Around { surface: self.surface, facets: self.facets, owner: &self.owner, bend: self.accuracy.bend }
    }

    /// The best surface through a facet and its surroundings.
    fn best_from(&mut self, seed: u32) -> Option<Candidate> {
        let (mut best, all) = self.best_within(seed, Reach::All, &[]);
        // Rows are those of strips with two pairs of sides. Any row of a turned part is on some surface; that of a face ends at
        // creases.
        let strip = self.facets.triangles(seed).len() == 2;
        let reaches = [Reach::Sideways, Reach::Row, Reach::Column];
        for reach in reaches.into_iter().take(if strip { 3 } else { 1 }) {
            let row = !matches!(reach, Reach::Sideways);
            if best.as_ref().is_none_or(|b| b.surplus < CERTAIN_SURPLUS)
                && let Some(other) = self.best_within(seed, reach, &all).0
                && best.as_ref().is_none_or(|b| better(&other, b))
                && (!row || self.ends_at_creases(&other.facets))
            {
                best = Some(other);
            }
        }
        if best.is_none() {
            self.blame(&all, seed);
        }
        best
    }

    /// Counts a failure of a seed against facets. Neighbouring seeds of the same size see nearly the same points; after a
    /// few failures a facet is no seed any more. The strips beside a large facet are another matter.
    fn blame(&mut self, facets: &[u32], seed: u32) {
        for &f in facets.iter().filter(|&&f| 2.0 * self.facets.area[f as usize] > self.facets.area[seed as usize]) {
            self.failures[f as usize] = self.failures[f as usize].saturating_add(1);
        }
    }

    /// The best surface through the neighbourhood of a facet that is just large enough, and the neighbourhood. One that
    /// was tried before is not tried again.
    fn best_within(&mut self, seed: u32, reach: Reach, before: &[u32]) -> (Option<Candidate>, Vec<u32>) {
        let mut patch = Patch::new(&self.around(), seed, reach);
        for level in 0..MOST_RINGS {
            let grew = self.around().grow(&mut patch);
            if !grew && level > 0 || patch.facets == before {
                break;
            }
            let vertices = self.gather(&patch.facets);
            if vertices < self.accuracy.seed_vertices && level + 1 < MOST_RINGS {
                continue;
            }
            let best = self.best_through(&patch.facets, seed);
            if best.is_some() || vertices >= Kind::Torus.parameters() + SEED_SURPLUS {
                return (best, patch.facets);
            }
        }
        (None, patch.facets)
    }

    /// The best surface through the gathered points of a patch.
    fn best_through(&mut self, patch: &[u32], seed: u32) -> Option<Candidate> {
        let mut best: Option<Candidate> = None;
        for kind in CURVED_KINDS {
            if self.points.len() < kind.parameters() + SEED_SURPLUS {
                continue;
            }
            let start = fit_within(kind, &self.points, &self.normals, self.accuracy.distance, &mut self.scratch);
            let Some(start) = start else { continue };
            if let Some(candidate) = self.grow(start.primitive, seed)
                && best.as_ref().is_none_or(|b| better(&candidate, b))
            {
                best = Some(candidate);
            }
            self.gather(patch);
        }
        best
    }

    /// Collects the distinct vertices of facets, with mean normals; returns their number.
    fn gather(&mut self, patch: &[u32]) -> usize {
        let triangles = patch.iter().flat_map(|&f| self.facets.triangles(f)).copied();
        self.corners.collect(self.surface, triangles);
        let all = 0..self.corners.len();
        self.points.clear();
        self.points.extend(all.clone().map(|k| self.corners.point(self.surface, k)));
        self.normals.clear();
        self.normals.extend(all.map(|k| self.corners.normal(self.surface, k)));
        self.points.len()
    }

    /// All facets on a surface that are connected to the seed, after refits.
    fn grow(&mut self, start: Primitive, seed: u32) -> Option<Candidate> {
        let mut primitive = start;
        let mut facets = self.closure(&primitive, seed)?;
        for _ in 0..3 {
            let before = facets.len();
            self.gather_samples(&facets);
            let Some(better) = refine(primitive, &self.points, None, 20) else { break };
            let Some(more) = self.closure(&better.primitive, seed) else { break };
            if more.len() < before {
                break;
            }
            (primitive, facets) = (better.primitive, more);
            if facets.len() == before {
                break;
            }
        }
        let candidate = self.judge(primitive, &facets);
        if candidate.is_none() {
            self.blame(&facets, seed);
        }
        candidate
    }

    /// Vertices of facets, evenly thinned.
    fn gather_samples(&mut self, facets: &[u32]) {
        self.stamp += 1;
        self.points.clear();
        let t = self.surface.triangles;
        for &f in facets {
            for &triangle in self.facets.triangles(f) {
                for v in t.triangle(triangle) {
                    if self.vertex_stamp[v as usize] != self.stamp {
                        self.vertex_stamp[v as usize] = self.stamp;
                        self.points.push(t.points()[v as usize]);
                    }
                }
            }
        }
        if self.points.len() > REFIT_SAMPLES {
            let n = self.points.len();
            (0..REFIT_SAMPLES).for_each(|k| self.points[k] = self.points[k * n / REFIT_SAMPLES]);
            self.points.truncate(REFIT_SAMPLES);
        }
    }

    fn closure(&mut self, primitive: &Primitive, seed: u32) -> Option<Vec<u32>> {
        let sign = self.sign(primitive, seed)?;
        self.stamp += 1;
        let stamp = self.stamp;
        let mut facets = vec![seed];
        self.facet_stamp[seed as usize] = stamp;
        let mut ring = Vec::new();
        let mut k = 0;
        while k < facets.len() {
            self.around().all(facets[k], &mut ring);
            for &g in &ring {
                if self.facet_stamp[g as usize] != stamp {
                    self.facet_stamp[g as usize] = stamp;
                    if self.lies_on(primitive, sign, g) {
                        facets.push(g);
                    }
                }
            }
            k += 1;
        }
        Some(facets)
    }

    /// Whether the faces look along the natural normal (1) or against it (−1); `None` if the seed does neither.
    fn sign(&self, primitive: &Primitive, seed: u32) -> Option<f64> {
        [1.0, -1.0].into_iter().find(|&sign| self.lies_on(primitive, sign, seed))
    }

    /// Whether all triangles of a facet lie on the surface.
    fn lies_on(&self, primitive: &Primitive, sign: f64, f: u32) -> bool {
        let a = &self.accuracy;
        let demand = Lies { distance: a.distance, turn: a.turn, spread: a.bend + a.turn };
        self.facets.triangles(f).iter().all(|&t| self.surface.lies_on(t, primitive, sign, &demand))
    }

    /// Number of planes across an axis that the gathered points lie on, up to 4.
    fn rings(&self, axis: DVec3) -> usize {
        let heights = self.points.iter().map(|p| p.dot(axis));
        let (low, high) = heights.clone().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        let slack = 1e-3 * (high - low);
        let mut levels: [f64; 4] = [f64::NAN; 4];
        let mut count = 0;
        for x in heights {
            if !levels[..count].iter().any(|l| (l - x).abs() <= slack) {
                levels[count] = x;
                count += 1;
                if count == levels.len() {
                    break;
                }
            }
        }
        count
    }

    /// Whether a surface ends where the mesh bends clearly more than it does inside.
    fn ends_at_creases(&self, facets: &[u32]) -> bool {
        let t = self.surface.triangles;
        let inside: FxHashSet<u32> = facets.iter().copied().collect();
        let corners = facets.iter().flat_map(|&f| self.facets.triangles(f)).flat_map(|&k| 3 * k..3 * k + 3);
        let mut worst = 0f32;
        let mut least = f32::INFINITY;
        for c in corners.filter(|&c| t.opposite(c) != NONE) {
            let bend = self.surface.bend[c as usize];
            if inside.contains(&self.facets.of[t.opposite(c) as usize / 3]) {
                worst = worst.max(bend);
            } else {
                least = least.min(bend);
            }
        }
        least > 1.5 * worst + 0.1
    }

    /// Whether no facet is out of proportion to the others: a plane between two rounded edges may lie on their circle.
    fn even(&self, primitive: &Primitive, facets: &[u32]) -> bool {
        let turn = |f: &u32| {
            let mut normals = self.facets.triangles(*f).iter().flat_map(|&k| self.surface.normals_on(k, primitive));
            let first = normals.next().unwrap_or_default();
            normals.map(|n| angle_between(first, n)).fold(0.0, f64::max)
        };
        let mut turns: Vec<f64> = facets.iter().map(turn).collect();
        turns.sort_unstable_by(f64::total_cmp);
        let mut areas: Vec<f64> = facets.iter().map(|&f| self.facets.area[f as usize]).collect();
        areas.sort_unstable_by(f64::total_cmp);
        let out_of_proportion = |sorted: &[f64], factor: f64, slack: f64| {
            sorted[sorted.len() - 1] > factor * sorted[sorted.len() / 2] + slack
        };
        !out_of_proportion(&turns, UNEVEN_TURN, 0.02) && !out_of_proportion(&areas, UNEVEN_AREA, 0.0)
    }

    /// Whether the profile of the gathered points has more positions than parameters. The generators of a strip, the rings
    /// of a turned part repeat: any three rings are on a torus, any two chamfers beside a plane are on a cylinder.
    fn determined(&self, primitive: &Primitive, facets: &[u32]) -> bool {
        let angles = |angle: &dyn Fn(DVec3) -> Option<f64>| -> Vec<f64> {
            let mut all: Vec<f64> = self.points.iter().filter_map(|&p| angle(p)).collect();
            all.sort_unstable_by(f64::total_cmp);
            all.dedup_by(|b, a| *b - *a < SAME_ANGLE);
            // The circle closes.
            if all.len() > 1 && all[0] + std::f64::consts::TAU - all[all.len() - 1] < SAME_ANGLE {
                all.pop();
            }
            all
        };
        let around = |axis: DVec3, center: DVec3| {
            let x = axis.any_orthonormal_vector();
            let y = axis.cross(x);
            move |p: DVec3| Some((p - center).dot(y).atan2((p - center).dot(x)))
        };
        let enough =
            |angles: &[f64], least: usize| angles.len() > least || (angles.len() == least && evenly_spaced(angles));
        match *primitive {
            Primitive::Cylinder { origin, axis, .. } => enough(&angles(&around(axis, origin)), 4),
            Primitive::Cone { apex, axis, .. } => {
                enough(&angles(&around(axis, apex)), 4) && (self.rings(axis) > 2 || self.ends_at_creases(facets))
            }
            Primitive::Torus { center, axis, major_radius, .. } => {
                let profile = |p: DVec3| {
                    let d = p - center;
                    let z = d.dot(axis);
                    Some(z.atan2((d - z * axis).length() - major_radius))
                };
                enough(&angles(&profile), 4) && enough(&angles(&around(axis, center)), 3)
            }
            Primitive::Sphere { .. } => {
                let mean = self.points.iter().sum::<DVec3>() / self.points.len() as f64;
                let spread = self.points.iter().map(|&p| outer(p - mean)).fold(DMat3::ZERO, |s, m| s + m);
                Eigen3::new(spread).vectors.into_iter().all(|axis| self.rings(axis) > 3)
            }
            Primitive::Plane { .. } => true,
        }
    }

    fn judge(&mut self, primitive: Primitive, facets: &[u32]) -> Option<Candidate> {
        self.gather_samples(facets);
        let vertices = self.points.len();
        let needed = primitive.kind().parameters() + LEAST_SURPLUS;
        if facets.len() < 3 || vertices < needed {
            return None;
        }
        if !self.determined(&primitive, facets) {
            return None;
        }
        if facets.len() < FEW_FACETS && !self.even(&primitive, facets) {
            return None;
        }
        let area: f64 = facets.iter().map(|&f| self.facets.area[f as usize]).sum();
        let max = self.points.iter().map(|&p| primitive.distance(p).abs()).fold(0.0, f64::max);
        let triangles = facets.iter().flat_map(|&f| self.facets.triangles(f)).copied();
        let sagitta = sagitta(self.surface, triangles, &primitive);
        let surplus = vertices - primitive.kind().parameters();
        Some(Candidate { primitive, surplus, area, sagitta, max, facets: facets.to_vec() })
    }

    /// Whether a surface is one that only the tolerance made possible: a piece of a freeform one.
    fn is_soft(&self, c: &Candidate) -> bool {
        c.max > USED_TOLERANCE * self.accuracy.distance && self.softness(c) > MOST_SOFT
    }

    fn softness(&self, c: &Candidate) -> f64 {
        softness(self.surface, self.facets, &self.accuracy, &c.primitive, &c.facets)
    }

    fn claim(&mut self, c: Candidate) {
        let id = self.found.len() as u32;
        c.facets.iter().for_each(|&f| self.owner[f as usize] = id);
        let is_weak = c.primitive.kind() == Kind::Torus && c.surplus < CERTAIN_SURPLUS;
        self.found.push(Found { primitive: c.primitive, is_weak });
    }
}

/// See [`MOST_SOFT`].
pub fn softness(
    surface: &Surface<'_>,
    facets: &Facets,
    accuracy: &Accuracy,
    primitive: &Primitive,
    members: &[u32],
) -> f64 {
    let t = surface.triangles;
    let inside: FxHashSet<u32> = members.iter().copied().collect();
    let (mut soft, mut all) = (0.0, 0.0);
    for &triangle in members.iter().flat_map(|&f| facets.triangles(f)) {
        for k in 3 * triangle..3 * triangle + 3 {
            let o = t.opposite(k);
            if o == NONE || facets.of[o as usize / 3] != NONE && inside.contains(&facets.of[o as usize / 3]) {
                continue;
            }
            let length = surface.edge_length(k);
            all += length;
            if f64::from(surface.bend[k as usize]) > accuracy.bend {
                continue;
            }
            let apex = t.points()[t.apex(o) as usize];
            let d = primitive.distance(apex).abs();
            if d > accuracy.distance && d < HARD_BORDER * accuracy.distance {
                soft += length;
            }
        }
    }
    if all > 0.0 { soft / all } else { 0.0 }
}

/// Whether the gaps between sorted angles are about equal; the gap that closes the circle does not count.
fn evenly_spaced(angles: &[f64]) -> bool {
    let tau = std::f64::consts::TAU;
    let n = angles.len();
    let mut gaps: Vec<f64> =
        (0..n).map(|k| if k + 1 < n { angles[k + 1] - angles[k] } else { angles[0] + tau - angles[k] }).collect();
    gaps.sort_unstable_by(f64::total_cmp);
    n >= 3 && gaps[n - 2] < 1.25 * gaps[0]
}

/// More area wins; of about equal ones that which the triangles follow much better, else the simpler one (first).
fn better(new: &Candidate, old: &Candidate) -> bool {
    if new.area > 1.05 * old.area {
        return true;
    }
    new.area > 0.95 * old.area && new.sagitta < 0.5 * old.sagitta
}
