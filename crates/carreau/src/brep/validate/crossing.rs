//! Faces that cross: edges of one tessellation that pass through triangles of another.
//!
//! The triangles are only near the faces, so that a crossing counts where it is deeper than they can be wrong, and not beside
//! an edge that both faces share.

use super::{Fault, Finding};
use crate::brep::Brep;
use crate::brep::tessellate::Tessellation;
use crate::context::Context;
use crate::error::Result;
use crate::geometry::search_tree::TriangleTree;
use glam::DVec3;
use rayon::prelude::*;

/// Depths and distances that count, as multiples of the chord tolerance.
const DEPTH: f64 = 3.0;

/// The deepest crossing of every pair of faces.
pub(super) fn crossings(
    brep: &Brep,
    tessellation: &Tessellation,
    chord: f64,
    context: &Context,
) -> Result<Vec<Finding>> {
    let (points, triangles) = (&tessellation.points, &tessellation.triangles);
    let tree = TriangleTree::new(points, triangles);
    let mut edges: Vec<(u32, u32, u32)> = Vec::new();
    for (t, &face) in triangles.iter().zip(&tessellation.face_of) {
        edges.extend((0..3).map(|k| (face, t[k].min(t[(k + 1) % 3]), t[k].max(t[(k + 1) % 3]))));
    }
    edges.sort_unstable();
    edges.dedup();
    let shared = Shared::new(brep, tessellation);
    let boxes = Boxes::new(brep, tessellation);
    let found: Vec<Vec<Crossing>> = context.install(|| {
        let of_chunk = |chunk: &[(u32, u32, u32)]| {
            context.check()?;
            let mut out = Vec::new();
            for &(face, a, b) in chunk {
                let [p, q] = [a, b].map(|v| points[v as usize]);
                if !boxes.may_cross(face, [a, b], [p, q]) {
                    continue;
                }
                tree.along_ray(p, q - p, 1.0, |hit| {
                    let other = tessellation.face_of[hit.triangle as usize];
                    let corners = triangles[hit.triangle as usize];
                    if other == face || corners.contains(&a) || corners.contains(&b) {
                        return;
                    }
                    let at = p.lerp(q, hit.t);
                    let depth = depth([p, q], corners.map(|v| points[v as usize]));
                    if depth > DEPTH * chord && !shared.is_near(face, other, at, DEPTH * chord) {
                        out.push(Crossing { faces: [face.min(other), face.max(other)], depth, at });
                    }
                });
            }
            Ok(out)
        };
        edges.par_chunks(256).map(of_chunk).collect::<Result<_>>()
    })?;
    let mut all: Vec<Crossing> = found.into_iter().flatten().collect();
    all.sort_by(|a, b| a.faces.cmp(&b.faces).then(b.depth.total_cmp(&a.depth)));
    let worst = all.chunk_by(|a, b| a.faces == b.faces).map(|of_pair| {
        let Crossing { faces: [a, b], depth, at } = of_pair[0];
        Finding { other: Some(b), ..Finding::new(Fault::CrossingFaces, depth, DEPTH * chord, at).of_face(a) }
    });
    Ok(worst.collect())
}

/// Boxes of the faces, and the faces at every point: most segments are nowhere near a face that they do not end at.
struct Boxes {
    /// Empty for a face without triangles.
    of_face: Vec<[DVec3; 2]>,
    /// Pairs of point and face, sorted.
    at_point: Vec<(u32, u32)>,
}

impl Boxes {
    fn new(brep: &Brep, tessellation: &Tessellation) -> Self {
        let mut of_face = vec![[DVec3::INFINITY, DVec3::NEG_INFINITY]; brep.faces.len()];
        let mut at_point = Vec::with_capacity(3 * tessellation.triangles.len());
        for (t, &face) in tessellation.triangles.iter().zip(&tessellation.face_of) {
            for &v in t {
                let p = tessellation.points[v as usize];
                let [low, high] = &mut of_face[face as usize];
                (*low, *high) = (low.min(p), high.max(p));
                at_point.push((v, face));
            }
        }
        at_point.sort_unstable();
        at_point.dedup();
        Boxes { of_face, at_point }
    }

    fn ends_at(&self, face: u32, v: u32) -> bool {
        self.at_point.binary_search(&(v, face)).is_ok()
    }

    /// Whether a segment of a face runs into the box of a face that neither of its ends is on.
    fn may_cross(&self, face: u32, ends: [u32; 2], [p, q]: [DVec3; 2]) -> bool {
        let (low, high) = (p.min(q), p.max(q));
        self.of_face.iter().enumerate().any(|(g, [from, to])| {
            let g = g as u32;
            g != face && low.cmple(*to).all() && high.cmpge(*from).all() && !ends.iter().any(|&v| self.ends_at(g, v))
        })
    }
}

struct Crossing {
    faces: [u32; 2],
    depth: f64,
    at: DVec3,
}

/// How far the nearer end of a segment is from the plane of a triangle that it passes through.
fn depth(ends: [DVec3; 2], [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a).normalize_or_zero();
    ends.map(|p| (p - a).dot(normal).abs()).into_iter().fold(f64::INFINITY, f64::min)
}

/// Segments of the edges and vertices that pairs of faces share.
struct Shared<'a> {
    points: &'a [DVec3],
    /// Border segments of each face's triangles, sorted by face.
    borders: Vec<Vec<[u32; 2]>>,
}

impl<'a> Shared<'a> {
    fn new(brep: &Brep, tessellation: &'a Tessellation) -> Self {
        let mut sides: Vec<(u32, [u32; 2])> = Vec::new();
        for (t, &face) in tessellation.triangles.iter().zip(&tessellation.face_of) {
            sides.extend((0..3).map(|k| (face, [t[k].min(t[(k + 1) % 3]), t[k].max(t[(k + 1) % 3])])));
        }
        sides.sort_unstable();
        let mut borders = vec![Vec::new(); brep.faces.len()];
        for of_side in sides.chunk_by(|a, b| a == b).filter(|c| c.len() == 1) {
            borders[of_side[0].0 as usize].push(of_side[0].1);
        }
        Shared { points: &tessellation.points, borders }
    }

    /// Whether a point is near a piece of border, or a corner, that both faces have.
    fn is_near(&self, a: u32, b: u32, p: DVec3, distance: f64) -> bool {
        let [mine, other] = [a, b].map(|f| &self.borders[f as usize]);
        let near_segment = |s: &&[u32; 2]| {
            let [x, y] = s.map(|v| self.points[v as usize]);
            let along = (p - x).dot(y - x) / (y - x).length_squared();
            let along = if along.is_finite() { along.clamp(0.0, 1.0) } else { 0.0 };
            x.lerp(y, along).distance(p) <= distance
        };
        // Few segments are near, so whose they are is asked last.
        let close: Vec<&[u32; 2]> = mine.iter().filter(near_segment).collect();
        let corners = || close.iter().flat_map(|s| s.iter());
        close.iter().any(|s| other.binary_search(s).is_ok())
            || other.iter().filter(near_segment).flatten().any(|v| corners().any(|w| w == v))
    }
}
