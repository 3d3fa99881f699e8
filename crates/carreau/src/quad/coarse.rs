//! Coarse triangles that keep the features: the working mesh of the map, and what is paired on rung 3. Their feature edges know the
//! curves of the source that they are on.

use super::sizes::Sizes;
use super::source::{Source, bits};
use super::work::Place;
use crate::context::Context;
use crate::error::{Error, Result};
use crate::field::{self, Field, FieldOptions};
use crate::geometry::features::FeatureOptions;
use crate::mesh::{Column, CornerId, DisjointSets, NONE, SurfaceMesh, TaggedEdge, VertexId};
use crate::remesh::{RemeshOptions, simplify};
use glam::DVec3;
use std::collections::BTreeMap;

/// A share of the largest size: the smallest triangles where the surface bends, because smaller ones would be far too
/// many.
const SMALLEST_SIZE: f64 = 0.12;
/// Degrees: edges deviate from the surface by so much at most, because halving puts the vertices between onto it.
const DEVIATION_DEG: f64 = 16.0;
/// A share of the diagonal: features may move by so much before their new vertices go back to them, well below
/// [`FOUND_NEAR`] because they have to be found again.
const RIDGE_TOLERANCE: f64 = 8e-4;
/// A share of the diagonal: a feature is found again where an edge is so near, because new edges are chords of it.
const FOUND_NEAR: f64 = 1.5e-3;
/// Degrees: that edge is so parallel to it, because chords turn where a feature bends.
const FOUND_ALONG_DEG: f64 = 20.0;
/// A share of its length: a path is on the curve that so much of it is said to be on, because an edge near a corner may
/// be as near to the next curve.
const PATH_SHARE: f64 = 0.8;
/// A tag: edges that stay as they are have it, because others have another one and may change.
const HELD_TAG: i32 = 2;
/// A share of the diagonal: vertices on features are so near, because they are put back to them but for rounding.
const ON_FEATURE: f64 = 1e-5;
/// The name of a vertex property: how long edges are to be.
const SIZE: &str = "size";

/// Coarse triangles that know the source.
pub struct Coarse {
    pub mesh: SurfaceMesh,
    /// Whether a half-edge is on a feature.
    pub is_feature: Vec<bool>,
    /// The edges on features, with the curve of each.
    pub features: Vec<([u32; 2], u32)>,
    pub place: Vec<Place>,
    /// Region of every triangle.
    pub region: Vec<u32>,
}

/// How closely triangles follow a surface.
#[derive(Debug, Clone, Copy)]
pub struct Follow {
    /// Angle between the surface and edges, in degrees.
    pub deviation: f64,
    /// Sizes where the surface bends, as a share of the largest.
    pub smallest: f64,
    /// How far features may move before their new vertices go back to them, as a share of the diagonal.
    pub ridge_tolerance: f64,
}

impl Follow {
    /// So many times less closely than they should: where a surface bends a lot they would be too many.
    pub fn loose(loose: f64) -> Self {
        Follow { deviation: loose * DEVIATION_DEG, smallest: SMALLEST_SIZE, ridge_tolerance: loose * RIDGE_TOLERANCE }
    }

    /// Triangles of about one size, that keep the features.
    pub fn even(smallest: f64) -> Self {
        Follow { deviation: 3.0 * DEVIATION_DEG, smallest, ridge_tolerance: RIDGE_TOLERANCE }
    }
}

/// Triangles with sides up to a length that keep the features; `None` where these could not be found again.
pub fn coarse(
    source: &Source,
    length: f64,
    follow: Follow,
    feature_deg: f64,
    context: &Context,
) -> Result<Option<Coarse>> {
    let mut mesh = source.surface.mesh.clone();
    mesh.attributes = Default::default();
    mesh.attributes.face.insert("region".into(), Column::Label(source.region.iter().map(|&r| r as i32).collect()));
    let held = source.held_edges().map(|ends| TaggedEdge { ends: ends.map(VertexId), tag: HELD_TAG });
    mesh.tagged_edges.extend(held);
    let sizes = source.guidance.sizes.as_deref();
    if let Some(sizes) = sizes {
        let of = |&p: &DVec3| length * sizes.at(p);
        mesh.attributes.vertex.insert(SIZE.into(), Column::Scalar(mesh.points().iter().map(of).collect()));
    }
    // A share beneath the doubles stands as the least of them.
    let largest = (length * sizes.map_or(1.0, Sizes::largest) / source.diagonal).max(f64::MIN_POSITIVE);
    let options = RemeshOptions {
        deviation: follow.deviation,
        feature_angle: feature_deg,
        labels: Some("region".into()),
        min_size: follow.smallest
            * (length / source.diagonal).max(f64::MIN_POSITIVE)
            * sizes.map_or(1.0, Sizes::smallest),
        max_size: largest,
        ridge_tolerance: follow.ridge_tolerance,
        ragged_borders: false,
        held_tag: Some(HELD_TAG),
        sizes: sizes.map(|_| SIZE.into()),
        ..RemeshOptions::default()
    };
    let made = match simplify(&mesh, &options, context) {
        Ok(made) => made.mesh,
        Err(Error::Numeric(_)) => return Ok(None),
        Err(other) => return Err(other),
    };
    let Some(Column::Label(labels)) = made.attributes.face.get("region") else { return Ok(None) };
    let region: Vec<u32> = labels.iter().map(|&r| r as u32).collect();
    Ok(features(source, made, region, feature_deg))
}

/// Finds the features again.
fn features(source: &Source, mesh: SurfaceMesh, region: Vec<u32>, feature_deg: f64) -> Option<Coarse> {
    let cos_along = FOUND_ALONG_DEG.to_radians().cos();
    let cos_fold = (0.5 * feature_deg).to_radians().cos();
    let normal = |t: usize| {
        let [a, b, c] = [0, 1, 2].map(|k| mesh.point(mesh.vertex(CornerId::new(3 * t + k))));
        (b - a).cross(c - a).normalize_or_zero()
    };
    let (mut found, mut sides, mut corners) = (Vec::new(), Vec::new(), Vec::new());
    for c in (0..mesh.corner_count()).map(CornerId::new) {
        let o = mesh.opposite(c);
        if o.is_some_and(|o| o < c) {
            continue;
        }
        let (a, b) = (mesh.point(mesh.vertex(c)), mesh.point(mesh.vertex(mesh.next(c))));
        let along = (b - a).normalize_or_zero();
        let near = || source.feature_along((a + b) / 2.0, along, FOUND_NEAR * source.diagonal, cos_along);
        let [f, g] = [Some(c), o].map(|c| c.map(|c| mesh.face_of(c).index()));
        let must = match (f, g) {
            (Some(f), Some(g)) => region[f] != region[g],
            _ => true,
        };
        let folded = || f.zip(g).is_some_and(|(f, g)| normal(f).dot(normal(g)) < cos_fold);
        let on = |p: DVec3| source.feature_along(p, along, ON_FEATURE * source.diagonal, -1.0).is_some();
        // Between triangles of the same region only a seam is a feature: other folds are where thin regions were folded over.
        let seam = || near().filter(|&e| source.is_seam(source.curve[e as usize]));
        let edge = match must {
            true => Some(near().or_else(|| source.feature_along((a + b) / 2.0, along, source.diagonal, -1.0))?),
            false if folded() || on(a) && on(b) => seam(),
            false => None,
        };
        if let Some(edge) = edge {
            corners.push(c);
            found.push(([mesh.vertex(c).0, mesh.vertex(mesh.next(c)).0], source.curve[edge as usize]));
            let [own, other] = [f, g].map(|f| f.map_or(NONE, |f| region[f]));
            sides.push([own.min(other), own.max(other)]);
        }
    }
    let curves = from_corner_to_corner(&found, &sides, mesh.points(), source);
    let mut is_feature = vec![false; mesh.corner_count()];
    for (&c, _) in corners.iter().zip(&curves).filter(|(_, curve)| curve.is_some()) {
        [Some(c), mesh.opposite(c)].into_iter().flatten().for_each(|c| is_feature[c.index()] = true);
    }
    let found: Vec<([u32; 2], u32)> =
        found.iter().zip(curves).filter_map(|(&(ends, _), curve)| Some((ends, curve?))).collect();
    let mut place: Vec<Option<Place>> = vec![None; mesh.vertex_count()];
    let mut degree = vec![0u32; mesh.vertex_count()];
    for (ends, curve) in &found {
        for &v in ends {
            degree[v as usize] += 1;
            place[v as usize] = match place[v as usize] {
                None => Some(Place::Curve(*curve)),
                Some(Place::Curve(other)) if other == *curve => Some(Place::Curve(other)),
                _ => Some(Place::Fixed),
            };
        }
    }
    for (c, &v) in mesh.faces().corners().iter().enumerate() {
        place[v as usize].get_or_insert(Place::Region(region[c / 3]));
    }
    let settle = |(place, degree): (Option<Place>, u32)| match place {
        Some(Place::Curve(curve)) if degree == 2 => Place::Curve(curve),
        Some(Place::Region(region)) => Place::Region(region),
        _ => Place::Fixed,
    };
    let place = place.into_iter().zip(degree).map(settle).collect();
    Some(Coarse { mesh, is_feature, features: found, place, region })
}

/// The curve of every edge. Curves run from corner to corner: a path is on the one between the same corners and the same regions,
/// of several the nearest; inside a region, where there is none, it is no feature, however near to one it may be. Where corners
/// are not found again, it is on the curve that most of its edges are near.
fn from_corner_to_corner(
    found: &[([u32; 2], u32)],
    sides: &[[u32; 2]],
    points: &[DVec3],
    source: &Source,
) -> Vec<Option<u32>> {
    let mut edges_at: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (k, (ends, _)) in (0u32..).zip(found) {
        ends.iter().for_each(|&v| edges_at.entry(v).or_default().push(k));
    }
    let is_corner = |v: u32| source.is_corner(points[v as usize]);
    let is_inside = |v: u32| edges_at[&v].len() == 2 && !is_corner(v);
    let mut sets = DisjointSets::new(found.len());
    edges_at.iter().filter(|(v, _)| is_inside(**v)).for_each(|(_, edges)| sets.union(edges[0], edges[1]));
    let (path, count) = sets.labels();
    let mut paths: Vec<Path> = vec![Path::default(); count];
    for (k, (ends, _)) in found.iter().enumerate() {
        let path = &mut paths[path[k] as usize];
        path.edges.push(k as u32);
        path.ends.extend(ends.iter().filter(|v| !is_inside(**v)));
    }
    let mut curves: BTreeMap<Between, Vec<u32>> = BTreeMap::new();
    let sorted = |ends: Vec<DVec3>| {
        let mut ends: Vec<[u64; 3]> = ends.into_iter().map(bits).collect();
        ends.sort_unstable();
        ends
    };
    for (number, (curve, &sides)) in (0u32..).zip(source.paths.iter().zip(&source.sides)) {
        curves.entry((sorted(curve.ends()), sides)).or_default().push(number);
    }
    let mut of = vec![None; found.len()];
    for Path { edges, ends } in paths {
        let sides = sides[edges[0] as usize];
        let at = sorted(ends.iter().map(|&v| points[v as usize]).collect());
        let curve = match curves.get(&(at, sides)).map(Vec::as_slice) {
            Some([only]) => Some(*only),
            Some(several) => nearest(several, &edges, found, points, source),
            None if sides[0] == sides[1] && !ends.is_empty() && ends.iter().all(|&v| is_corner(v)) => continue,
            None => most(&edges, found, points),
        };
        edges.iter().for_each(|&e| of[e as usize] = curve.or(Some(found[e as usize].1)));
    }
    of
}

/// The corners and the regions that a curve is between, in order.
type Between = (Vec<[u64; 3]>, [u32; 2]);

/// Edges from corner to corner, and where they end.
#[derive(Clone, Default)]
struct Path {
    edges: Vec<u32>,
    ends: Vec<u32>,
}

/// The curve that the edges of a path are nearest to.
fn nearest(curves: &[u32], path: &[u32], found: &[([u32; 2], u32)], points: &[DVec3], source: &Source) -> Option<u32> {
    let middle = |e: u32| found[e as usize].0.map(|v| points[v as usize]).iter().sum::<DVec3>() / 2.0;
    let off = |curve: u32| -> f64 {
        path.iter().filter_map(|&e| Some(source.on_curve(curve, middle(e))?.distance(middle(e)))).sum()
    };
    curves.iter().copied().min_by(|&a, &b| off(a).total_cmp(&off(b)))
}

/// The curve that most edges of a path are said to be on, by length.
fn most(path: &[u32], found: &[([u32; 2], u32)], points: &[DVec3]) -> Option<u32> {
    let mut lengths: BTreeMap<u32, f64> = BTreeMap::new();
    for &e in path {
        let ([a, b], curve) = found[e as usize];
        *lengths.entry(curve).or_default() += points[a as usize].distance(points[b as usize]);
    }
    let most = lengths.iter().max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(a.0)))?;
    // Where corners are not found again there may be several curves.
    (*most.1 >= PATH_SHARE * lengths.values().sum::<f64>()).then_some(*most.0)
}

/// The frame field of the coarse triangles, as quads are to run. `curvature`: the weight of its directions.
pub fn field_of(coarse: &Coarse, source: &Source, curvature: f64, context: &Context) -> Result<Field> {
    let guides = source.guidance.guides.clone();
    field_with(coarse, FieldOptions { curvature, guides, ..FieldOptions::default() }, context)
}

/// The smoothest frame field of the coarse triangles.
pub fn smoothest_field_of(coarse: &Coarse, context: &Context) -> Result<Field> {
    field_with(coarse, FieldOptions::default(), context)
}

fn field_with(coarse: &Coarse, options: FieldOptions, context: &Context) -> Result<Field> {
    let edges = coarse.features.iter().map(|(ends, _)| ends.map(VertexId)).collect();
    let features = FeatureOptions { angle_deg: None, tags: false, edges, ..FeatureOptions::default() };
    field::field(&coarse.mesh, &FieldOptions { features, ..options }, context)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Polygons;

    /// A flat grid with a tagged path around a corner: 0 to 2 along x, then 2 to 4 along y.
    fn plate() -> Source {
        let at = |i: u32, j: u32| DVec3::new(f64::from(i), f64::from(j), 0.0);
        let points = (0..5).flat_map(|j| (0..5).map(move |i| at(i, j))).collect();
        let mut faces = Polygons::new();
        for (i, j) in (0..4).flat_map(|j| (0..4).map(move |i| (i, j))) {
            let v = 5 * j + i;
            faces.push(&[v, v + 1, v + 6]);
            faces.push(&[v, v + 6, v + 5]);
        }
        let mut mesh = SurfaceMesh::new(points, faces).unwrap();
        let edges = [[6, 7], [7, 8], [8, 13], [13, 18]];
        mesh.tagged_edges = edges.iter().map(|e| TaggedEdge { ends: e.map(VertexId), tag: 1 }).collect();
        Source::new(&mesh, &FeatureOptions::default(), &Context::new()).unwrap()
    }

    #[test]
    fn an_edge_between_corners_near_a_feature_is_none() {
        let source = plate();
        // The working mesh has the ends and the corner alone, and an edge between the ends, too.
        let points = [6, 8, 18].map(|v| source.surface.mesh.points()[v]);
        let number = |a: usize, b: usize| {
            let middle = (points[a] + points[b]) / 2.0;
            source.curve[source.feature_along(middle, (points[b] - points[a]).normalize(), 5.0, -1.0).unwrap() as usize]
        };
        let found = [([0, 1], number(0, 1)), ([1, 2], number(1, 2)), ([0, 2], number(0, 1))];
        let curves = from_corner_to_corner(&found, &[[0, 0]; 3], &points, &source);
        assert_eq!(curves, [Some(number(0, 1)), Some(number(1, 2)), None]);
        assert_ne!(number(0, 1), number(1, 2));
    }

    #[test]
    fn a_path_is_on_the_curve_between_its_corners_whatever_is_nearer() {
        let source = plate();
        let points = [6, 8, 18].map(|v| source.surface.mesh.points()[v]);
        let along = |a: usize, b: usize| (points[b] - points[a]).normalize();
        let on = |a: usize, b: usize| {
            source.curve[source.feature_along(points[a].midpoint(points[b]), along(a, b), 0.1, 0.9).unwrap() as usize]
        };
        let (first, second) = (on(0, 1), on(1, 2));
        let curves = from_corner_to_corner(&[([0, 1], second), ([1, 2], first)], &[[0, 0]; 2], &points, &source);
        assert_eq!(curves, [Some(first), Some(second)]);
    }
}
