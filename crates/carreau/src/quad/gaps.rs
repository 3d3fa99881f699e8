//! How far quads and the surface are from each other, and where smaller quads would be nearer.

use super::quality::halves;
use super::source::Source;
use super::work::Work;
use crate::geometry::closest::closest_on_triangle;
use crate::geometry::search_tree::TriangleTree;
use crate::mesh::NONE;
use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

/// A count: parts of an edge of half a quad between places that are looked at, and rows of them, because one triangle
/// of the surface may stick out between the middles.
const FINE_PARTS: usize = 5;
/// A share of what is allowed: where the middles of half a quad and of its edges are farther off more places are looked
/// at, because one between may be off by more than what is allowed.
const ROUGH_GAP: f64 = 0.5;
/// A share of the edges of quads: places of the source that are looked at are so far apart, because each quad is to
/// have some above it.
const SOURCE_SPACING: f64 = 0.5;
/// A count: parts of an edge of the source between such places at most, because their number grows with its square.
const MOST_SOURCE_PARTS: f64 = 100.0;

/// How far quads are from the surface at most.
pub fn largest(gaps: &[DVec3]) -> f64 {
    gaps.iter().map(|gap| gap.length()).fold(0.0, f64::max)
}

/// The way from a point to a region.
fn to_surface(source: &Source, region: u32, p: DVec3) -> DVec3 {
    source.on_region(region, p).map_or(DVec3::ZERO, |found| found.0 - p)
}

/// Between quads and the surface.
pub struct Gaps<'a> {
    pub source: &'a Source,
    /// How much is allowed.
    pub far: f64,
    /// What every quad found beneath itself.
    below: Vec<DVec3>,
    /// Places of the source, with the half of a quad that was nearest to each.
    above: Vec<(DVec3, u32)>,
}

impl<'a> Gaps<'a> {
    pub fn new(work: &Work, source: &'a Source, far: f64) -> Self {
        let apart = SOURCE_SPACING * (source.area / work.faces.len().max(1) as f64).sqrt();
        let faces = 0..source.surface.mesh.face_count();
        let above = faces.into_par_iter().flat_map_iter(|f| places(source, f, apart)).map(|p| (p, NONE)).collect();
        Gaps { source, far, below: vec![DVec3::ZERO; work.faces.len()], above }
    }

    /// From each quad to the surface where they are farthest from each other. Quads with a vertex that has moved look beneath
    /// themselves again; places of the source look for another half of a quad where theirs is no longer near enough.
    pub fn of(&mut self, work: &Work, has_moved: &[bool]) -> Vec<DVec3> {
        let Gaps { source, far, below, above } = self;
        let (source, far) = (*source, *far);
        let triangles = halves(work);
        let corners = |t: u32| triangles[t as usize].map(|v| work.points[v as usize]);
        let look = |(q, gap): (usize, &mut DVec3)| {
            *gap = beneath(source, work.region[q], [2 * q as u32, 2 * q as u32 + 1].map(corners), far);
        };
        let has_moved = |q: usize| work.faces.face(q).iter().any(|&v| has_moved[v as usize]);
        below.par_iter_mut().enumerate().filter(|(q, _)| has_moved(*q)).for_each(look);
        let tree = TriangleTree::new(&work.points, &triangles);
        let beyond = |(p, nearest): &mut (DVec3, u32)| {
            if *nearest != NONE && closest_on_triangle(*p, corners(*nearest)).distance(*p) <= far {
                return None;
            }
            let found = tree.closest(*p)?;
            *nearest = found.triangle;
            (found.distance() > far).then_some((found.triangle / 2, *p - found.point))
        };
        let above: Vec<(u32, DVec3)> = above.par_iter_mut().filter_map(beyond).collect();
        let mut gaps = below.clone();
        for (q, gap) in above {
            gaps[q as usize] = longer(gaps[q as usize], gap);
        }
        gaps
    }

    /// The places of the source above each of some quads.
    pub fn above(&self, quads: &FxHashSet<u32>) -> FxHashMap<u32, Vec<DVec3>> {
        let mut found: FxHashMap<u32, Vec<DVec3>> = FxHashMap::default();
        let known = self.above.iter().filter(|(_, half)| *half != NONE && quads.contains(&(half / 2)));
        known.for_each(|(p, half)| found.entry(half / 2).or_default().push(*p));
        found
    }
}

/// From the halves of a quad to a region where they are farthest from it.
pub fn beneath(source: &Source, region: u32, halves: [[DVec3; 3]; 2], far: f64) -> DVec3 {
    let of = |p: DVec3| to_surface(source, region, p);
    let mut gap = DVec3::ZERO;
    for [a, b, c] in halves {
        let rough = [a.midpoint(b), b.midpoint(c), c.midpoint(a), (a + b + c) / 3.0].map(of);
        gap = rough.into_iter().fold(gap, longer);
        if gap.length() > ROUGH_GAP * far {
            for (i, j) in (0..=FINE_PARTS).flat_map(|i| (0..=FINE_PARTS - i).map(move |j| (i, j))) {
                let p = a + (b - a) * (i as f64 / FINE_PARTS as f64) + (c - a) * (j as f64 / FINE_PARTS as f64);
                gap = longer(gap, of(p));
            }
        }
    }
    gap
}

/// The middle of a triangle of the source; on a larger one and its edges places about so far apart.
fn places(source: &Source, face: usize, apart: f64) -> Vec<DVec3> {
    let mesh = &source.surface.mesh;
    let steps = |length: f64| (length / apart).ceil().clamp(1.0, MOST_SOURCE_PARTS) as usize;
    let p = [0, 1, 2].map(|k| mesh.points()[mesh.faces().face(face)[k] as usize]);
    let length = |k: &usize| p[*k].distance(p[(k + 1) % 3]);
    if (0..3).all(|k| length(&k) <= apart) {
        return vec![p.iter().sum::<DVec3>() / 3.0];
    }
    // Rows along the shortest side.
    let first = (0..3).min_by(|j, k| length(j).total_cmp(&length(k))).unwrap_or(0);
    let [a, b, c] = [0, 1, 2].map(|k| p[(first + k) % 3]);
    let rows = steps(c.distance(a.midpoint(b)));
    let mut places = vec![c];
    for row in 0..rows {
        let [from, to] = [a, b].map(|p| p.lerp(c, row as f64 / rows as f64));
        let count = steps(from.distance(to));
        places.extend((0..=count).map(|k| from.lerp(to, k as f64 / count as f64)));
    }
    places
}

fn longer(a: DVec3, b: DVec3) -> DVec3 {
    if b.length_squared() > a.length_squared() { b } else { a }
}
