//! Quads and their mirror images, which share the vertices in the plane.

use super::super::source::Source;
use super::super::validate::{FEATURE_ALONG_DEG, FEATURE_NEAR};
use super::super::work::{Place, Work};
use super::{AT_PLANE, MirrorPlane};
use crate::geometry::search_tree::TriangleTree;
use crate::mesh::{DisjointSets, HalfEdges, NONE};
use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::BTreeMap;

/// Quads above a plane together with their mirror images.
pub fn mirrored(work: &Work, plane: &MirrorPlane, diagonal: f64) -> Work {
    let count = work.points.len();
    let half_edges = HalfEdges::new(&work.faces, count);
    let is_near = |v: u32| plane.height(work.points[v as usize]).abs() <= AT_PLANE * diagonal;
    let mut in_plane = vec![false; count];
    let mut seam = FxHashSet::default();
    for edge in half_edges.groups().filter(|e| e.len() == 1 && e.ends.iter().all(|&v| is_near(v))) {
        edge.ends.iter().for_each(|&v| in_plane[v as usize] = true);
        seam.insert(sorted(edge.ends));
    }
    let mut both = work.clone();
    let mut image = vec![NONE; count];
    for v in 0..count {
        if in_plane[v] {
            both.points[v] = plane.foot(both.points[v]);
            image[v] = v as u32;
        } else {
            image[v] = both.points.len() as u32;
            both.points.push(plane.image(work.points[v]));
            both.place.push(work.place[v]);
        }
    }
    for face in work.faces.iter() {
        both.faces.push_iter(face.iter().rev().map(|&v| image[v as usize]));
    }
    both.region.extend_from_slice(&work.region);
    let images = work.features.iter().filter(|(ends, _)| !seam.contains(&sorted(*ends)));
    both.features.extend(images.map(|&(ends, curve)| (ends.map(|v| image[v as usize]), curve)));
    both
}

/// Gives the quads the features and regions of the whole surface: edges in a plane of symmetry are features only if the surface has
/// one there.
pub fn on_source(work: &mut Work, source: &Source) {
    let (near, cos) = (FEATURE_NEAR * source.diagonal, FEATURE_ALONG_DEG.to_radians().cos());
    let points = &work.points;
    let curve_of = |ends: [u32; 2]| {
        let [a, b] = ends.map(|v| points[v as usize]);
        let edge = source.feature_along((a + b) / 2.0, (b - a).normalize_or_zero(), near, cos)?;
        Some(source.curve[edge as usize])
    };
    work.features = work.features.iter().filter_map(|&(ends, _)| Some((ends, curve_of(ends)?))).collect();
    work.place.iter_mut().for_each(|place| *place = Place::Fixed);
    work.region = regions(work, source);
}

/// The region of every quad: that of most quads between the same features.
fn regions(work: &Work, source: &Source) -> Vec<u32> {
    let is_feature: FxHashSet<[u32; 2]> = work.features.iter().map(|(ends, _)| sorted(*ends)).collect();
    let mut sets = DisjointSets::new(work.faces.len());
    let mut first: FxHashMap<[u32; 2], u32> = FxHashMap::default();
    for (q, face) in (0u32..).zip(work.faces.iter()) {
        for ends in (0..4).map(|k| sorted([face[k], face[(k + 1) % 4]])).filter(|ends| !is_feature.contains(ends)) {
            let other = *first.entry(ends).or_insert(q);
            sets.union(other, q);
        }
    }
    let (piece, count) = sets.labels();
    let mesh = &source.surface.mesh;
    let tree = TriangleTree::new(mesh.points(), &mesh.faces().fan().0);
    let region_at = |p: DVec3| tree.closest(p).map_or(0, |found| source.region[found.triangle as usize]);
    let mut votes = vec![BTreeMap::<u32, usize>::new(); count];
    for (face, &piece) in work.faces.iter().zip(&piece) {
        let centre = face.iter().map(|&v| work.points[v as usize]).sum::<DVec3>() / 4.0;
        *votes[piece as usize].entry(region_at(centre)).or_default() += 1;
    }
    let most =
        |votes: &BTreeMap<u32, usize>| votes.iter().max_by_key(|(r, n)| (**n, u32::MAX - **r)).map_or(0, |m| *m.0);
    let of: Vec<u32> = votes.iter().map(most).collect();
    piece.iter().map(|&p| of[p as usize]).collect()
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}
