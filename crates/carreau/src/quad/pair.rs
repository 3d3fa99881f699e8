//! Rung 3: triangles of twice the size, paired to quads along a frame field, and halved.

use super::source::Source;
use super::work::{Place, Work};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::field::{self, Field, FieldOptions};
use crate::geometry::features::FeatureOptions;
use crate::geometry::quality::scaled_jacobian;
use crate::mesh::{Column, CornerId, DisjointSets, NONE, Polygons, SurfaceMesh, TaggedEdge, Triangles, VertexId};
use crate::numeric::matching::{Edge, minimum_cost_matching};
use crate::remesh::{RemeshOptions, simplify};
use glam::DVec3;
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

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
/// A price: what every pair costs, less than two single triangles because quads are wanted.
const PAIR_PRICE: f64 = 6.0;
/// A price: what a single triangle costs, because it becomes three quads around an irregular vertex.
const SINGLE_PRICE: f64 = 5.0;
/// A price: a corner that is a right angle off one costs so much, because quads are to be rectangles.
const CORNER_PRICE: f64 = 1.5;
/// A price: edges that are all 45° off the frames cost so much, because quads are to follow the field.
const ALIGNMENT_PRICE: f64 = 1.0;
/// A count: steps of a price of 1, because the matching takes whole numbers.
const PRICE_STEPS: f64 = 1e6;
/// A scaled Jacobian: pairs with a worse one make no quad, because it would be turned over or all but.
const LEAST_JACOBIAN: f64 = 0.15;
/// Radians: pairs with more of a fold make no quad, because it would cut off the edge between them.
const MOST_FOLD: f64 = 0.6;

/// Triangles with sides up to a length that keep the features, paired; `loose` as in [`Follow::loose`]. `None` where features could
/// not be found again.
pub fn paired(source: &Source, length: f64, loose: f64, feature_deg: f64, context: &Context) -> Result<Option<Work>> {
    let Some(coarse) = coarse(source, length, Follow::loose(loose), feature_deg, context)? else { return Ok(None) };
    let frames = frames(&coarse, context)?;
    let _stage = context.stage("pairs");
    let Some(t) = Triangles::of(&coarse.mesh) else { return Ok(None) };
    let faces = pairs(t, |c| coarse.is_feature[c as usize], &frames, context)?;
    let mut region = FxHashMap::default();
    (0..t.len() as u32).for_each(|i| {
        region.insert(sorted(t.triangle(i)), coarse.region[i as usize]);
    });
    let of = |f: &[u32]| {
        let parts = (0..f.len()).map(|k| sorted([f[k], f[(k + 1) % f.len()], f[(k + 2) % f.len()]]));
        parts.into_iter().find_map(|part| region.get(&part).copied()).unwrap_or(0)
    };
    let mut work = Work {
        points: coarse.mesh.points().to_vec(),
        place: coarse.place,
        features: coarse.features,
        ..Work::default()
    };
    work.region = faces.iter().map(of).collect();
    work.faces = faces;
    Ok(Some(work))
}

fn sorted(mut t: [u32; 3]) -> [u32; 3] {
    t.sort_unstable();
    t
}

/// The best pairs.
fn pairs(
    t: Triangles<'_>,
    is_feature: impl Fn(u32) -> bool,
    frames: &[[DVec3; 2]],
    context: &Context,
) -> Result<Polygons> {
    let mut edges = Vec::new();
    let mut halves = Vec::new();
    for c in 0..3 * t.len() as u32 {
        let o = t.opposite(c);
        if o == NONE || o < c || is_feature(c) {
            continue;
        }
        if let Some(cost) = cost(t, c, frames) {
            edges.push(Edge { ends: [c / 3, o / 3], cost: (PRICE_STEPS * (PAIR_PRICE + cost)).round() as i64 });
            halves.push(c);
        }
    }
    let single = vec![(PRICE_STEPS * SINGLE_PRICE).round() as i64; t.len()];
    let matching = minimum_cost_matching(&edges, &single, context)?;
    let mut faces = Polygons::new();
    for i in 0..t.len() as u32 {
        let mate = matching.mate[i as usize];
        if mate >= t.len() as u32 {
            faces.push(&t.triangle(i));
        } else if i < mate {
            faces.push(&quad(t, halves[matching.matched_edge[i as usize] as usize]));
        }
    }
    Ok(faces)
}

/// The quad of the two triangles at a half-edge.
fn quad(t: Triangles<'_>, c: u32) -> [u32; 4] {
    [t.vertex(c), t.apex(t.opposite(c)), t.vertex(t.next(c)), t.apex(c)]
}

/// What is wrong with a quad; `None` where it is no good at all.
fn cost(t: Triangles<'_>, c: u32, frames: &[[DVec3; 2]]) -> Option<f64> {
    let p = quad(t, c).map(|v| t.points()[v as usize]);
    let normal = |a: DVec3, b: DVec3, c: DVec3| (b - a).cross(c - a).normalize_or_zero();
    let fold = normal(p[0], p[1], p[2]).dot(normal(p[0], p[2], p[3])).clamp(-1.0, 1.0).acos();
    if scaled_jacobian(p) < LEAST_JACOBIAN || fold > MOST_FOLD {
        return None;
    }
    let (mut shape, mut turn) = (0f64, 0.0);
    for k in 0..4 {
        let (next, before) = (p[(k + 1) % 4] - p[k], p[(k + 3) % 4] - p[k]);
        shape = shape.max((next.angle_between(before) - FRAC_PI_2).abs() / FRAC_PI_2);
        // The sides between corners 0 and 2 by way of 1 are those of the opposite triangle.
        let own = if k < 2 { t.opposite(c) / 3 } else { c / 3 };
        let off = frames[own as usize].map(|d| d.dot(next.normalize_or_zero()).abs().clamp(0.0, 1.0).acos());
        turn += off[0].min(off[1]) / FRAC_PI_4 / 4.0;
    }
    Some(CORNER_PRICE * shape + ALIGNMENT_PRICE * turn + 0.5 * fold)
}

/// Coarse triangles that know the source.
pub struct Coarse {
    pub mesh: SurfaceMesh,
    /// Whether a half-edge is on a feature.
    is_feature: Vec<bool>,
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
    // A share beneath the doubles stands as the least of them.
    let largest = (length / source.diagonal).max(f64::MIN_POSITIVE);
    let options = RemeshOptions {
        deviation: follow.deviation,
        feature_angle: feature_deg,
        labels: Some("region".into()),
        min_size: follow.smallest * largest,
        max_size: largest,
        ridge_tolerance: follow.ridge_tolerance,
        ragged_borders: false,
        held_tag: Some(HELD_TAG),
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
    let mut is_feature = vec![false; mesh.corner_count()];
    let mut found = Vec::new();
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
        let seam = || near().filter(|&e| source.is_seam[source.curve[e as usize] as usize]);
        let edge = match must {
            true => Some(near().or_else(|| source.feature_along((a + b) / 2.0, along, source.diagonal, -1.0))?),
            false if folded() || on(a) && on(b) => seam(),
            false => None,
        };
        if let Some(edge) = edge {
            is_feature[c.index()] = true;
            o.into_iter().for_each(|o| is_feature[o.index()] = true);
            found.push(([mesh.vertex(c).0, mesh.vertex(mesh.next(c)).0], source.curve[edge as usize]));
        }
    }
    from_corner_to_corner(&mut found, mesh.points(), source);
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

/// Curves run from corner to corner. An edge near one may be as near to the next curve: what counts is what most edges of a
/// path are on.
fn from_corner_to_corner(found: &mut [([u32; 2], u32)], points: &[DVec3], source: &Source) {
    let mut edges_at: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (k, (ends, _)) in (0u32..).zip(found.iter()) {
        ends.iter().for_each(|&v| edges_at.entry(v).or_default().push(k));
    }
    let mut paths = DisjointSets::new(found.len());
    for (&v, edges) in &edges_at {
        if let [a, b] = edges[..]
            && !source.is_corner(points[v as usize])
        {
            paths.union(a, b);
        }
    }
    let (path, count) = paths.labels();
    let mut lengths: Vec<BTreeMap<u32, f64>> = vec![BTreeMap::new(); count];
    for (&path, ([a, b], curve)) in path.iter().zip(found.iter()) {
        let length = points[*a as usize].distance(points[*b as usize]);
        *lengths[path as usize].entry(*curve).or_default() += length;
    }
    for (&path, (_, curve)) in path.iter().zip(found.iter_mut()) {
        let lengths = &lengths[path as usize];
        let most = lengths.iter().max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(a.0)));
        // Where corners are not found again there may be several curves.
        if let Some(most) = most.filter(|most| *most.1 >= PATH_SHARE * lengths.values().sum::<f64>()) {
            *curve = *most.0;
        }
    }
}

/// The frame field of the coarse triangles.
pub fn field_of(coarse: &Coarse, context: &Context) -> Result<Field> {
    let edges = coarse.features.iter().map(|(ends, _)| ends.map(VertexId)).collect();
    let features = FeatureOptions { angle_deg: None, tags: false, edges, ..FeatureOptions::default() };
    field::field(&coarse.mesh, &FieldOptions { features, ..FieldOptions::default() }, context)
}

/// The frames of the coarse triangles.
fn frames(coarse: &Coarse, context: &Context) -> Result<Vec<[DVec3; 2]>> {
    let field = field_of(coarse, context)?;
    let mut frames = vec![[DVec3::ZERO; 2]; coarse.mesh.face_count()];
    // Parts of a triangle come in any order: the last one decides.
    for (k, &t) in field.source.iter().enumerate() {
        if let Some(frame) = frames.get_mut(t as usize) {
            *frame = [field.u[k], field.v[k]];
        }
    }
    Ok(frames)
}
