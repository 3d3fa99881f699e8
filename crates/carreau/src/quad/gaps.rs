//! How far quads and the surface are from each other, and where smaller quads would be nearer.

use super::quality::halves;
use super::source::Source;
use super::work::Work;
use crate::geometry::closest::closest_on_triangle;
use crate::geometry::normals::unit;
use crate::geometry::search_tree::TriangleTree;
use crate::mesh::NONE;
use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

/// Places along an edge of half a quad that are looked at, and as many rows of them, where the middles of its edges and its
/// own are off by more than this share of what is allowed.
const FINE: usize = 5;
const ROUGH: f64 = 0.5;
/// Places of the source that are looked at are as far from each other as this share of the edges of quads; the most in a row.
const APART: f64 = 0.5;
const FINEST: f64 = 100.0;

/// A place that wants smaller quads.
#[derive(Debug, Clone, Copy)]
pub struct Tight {
    pub place: DVec3,
    /// The direction in which the surface bends.
    pub way: DVec3,
    /// How long edges along it may be.
    pub length: f64,
}

/// How far quads are from the surface.
pub struct Gap {
    pub largest: f64,
    /// Where it is more than allowed.
    pub tight: Vec<Tight>,
}

impl Gap {
    pub fn new(work: &Work, source: &Source, gaps: &[DVec3], far: f64) -> Self {
        let largest = gaps.iter().map(|gap| gap.length()).fold(0.0, f64::max);
        let beyond = (0..gaps.len()).filter(|&q| gaps[q].length() > far);
        Gap { largest, tight: beyond.flat_map(|q| tight(work, source, q, far / gaps[q].length())).collect() }
    }
}

/// Directions of a quad that bend less than this share of the other are not to blame.
const STRAIGHT: f64 = 0.4;

/// In which directions a quad is too long, where what is allowed is a share of what it is off by.
fn tight(work: &Work, source: &Source, q: usize, share: f64) -> impl Iterator<Item = Tight> + use<> {
    let face = work.faces.face(q);
    let p = [0, 1, 2, 3].map(|k| work.points[face[k] as usize]);
    let gap = |p: DVec3| to_surface(source, work.region[q], p);
    let sag = |a: DVec3, b: DVec3| (gap(a.midpoint(b)) - gap(a).midpoint(gap(b))).length();
    let place = p.iter().sum::<DVec3>() / 4.0;
    let found = [[[p[0], p[1]], [p[3], p[2]]], [[p[0], p[3]], [p[1], p[2]]]].map(|pair: [[DVec3; 2]; 2]| {
        let ways = pair.map(|[a, b]| b - a);
        let longest = ways[0].length().max(ways[1].length());
        let sags = pair.map(|[a, b]| sag(a, b));
        // The sag of an arc grows with the square of its chord.
        (Tight { place, way: unit(ways[0] + ways[1]), length: longest * share.sqrt() }, sags[0].max(sags[1]))
    });
    let most = found[0].1.max(found[1].1);
    found.into_iter().filter(move |f| f.1 >= STRAIGHT * most).map(|f| f.0)
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
        let apart = APART * (source.area / work.faces.len().max(1) as f64).sqrt();
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
        if gap.length() > ROUGH * far {
            for (i, j) in (0..=FINE).flat_map(|i| (0..=FINE - i).map(move |j| (i, j))) {
                let p = a + (b - a) * (i as f64 / FINE as f64) + (c - a) * (j as f64 / FINE as f64);
                gap = longer(gap, of(p));
            }
        }
    }
    gap
}

/// The middle of a triangle of the source; on a larger one and its edges places about so far apart.
fn places(source: &Source, face: usize, apart: f64) -> Vec<DVec3> {
    let mesh = &source.surface.mesh;
    let steps = |length: f64| (length / apart).ceil().clamp(1.0, FINEST) as usize;
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

#[cfg(test)]
mod tests {
    use super::super::work::Place;
    use super::*;
    use crate::context::Context;
    use crate::geometry::features::FeatureOptions;

    #[test]
    fn a_quad_on_a_cylinder_is_too_long_around_it_only() {
        let context = Context::new();
        let mesh = crate::sample::make("open-cylinder", None, &context).unwrap();
        let options = FeatureOptions { angle_deg: None, ..FeatureOptions::default() };
        let source = Source::new(&mesh, &options, &context).unwrap();
        let (low, high) = source.surface.mesh.bounds();
        let (middle, radius) = (low.midpoint(high), 0.5 * (high.x - low.x));
        let at = |angle: f64, z: f64| middle + DVec3::new(radius * angle.cos(), radius * angle.sin(), z);
        let work = Work {
            points: vec![at(-0.4, -0.3), at(0.4, -0.3), at(0.4, 0.3), at(-0.4, 0.3)],
            place: vec![Place::Region(0); 4],
            faces: std::iter::once(&[0u32, 1, 2, 3][..]).collect(),
            region: vec![0],
            features: Vec::new(),
        };
        let found: Vec<Tight> = tight(&work, &source, 0, 0.25).collect();
        let [only] = found[..] else { panic!("{found:?}") };
        assert!(only.way.y.abs() > 0.99, "{:?}", only.way);
        let chord = 2.0 * radius * 0.4f64.sin();
        assert!((only.length - 0.5 * chord).abs() < 1e-9 * chord, "a quarter of the sag is half of the chord");
    }
}
