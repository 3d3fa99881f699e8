//! Rung 3: triangles of twice the size, paired to quads along a frame field, and halved.

use super::coarse::{Coarse, Follow, coarse, field_of};
use super::source::Source;
use super::work::Work;
use crate::context::Context;
use crate::error::Result;
use crate::geometry::quality::scaled_jacobian;
use crate::mesh::{NONE, Polygons, Triangles};
use crate::numeric::matching::{Edge, minimum_cost_matching};
use glam::DVec3;
use rustc_hash::FxHashMap;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

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
    let frames = frames(&coarse, source, context)?;
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

/// The frames of the coarse triangles.
fn frames(coarse: &Coarse, source: &Source, context: &Context) -> Result<Vec<[DVec3; 2]>> {
    let field = field_of(coarse, source, source.guidance.curvature, context)?;
    let mut frames = vec![[DVec3::ZERO; 2]; coarse.mesh.face_count()];
    // Parts of a triangle come in any order: the last one decides.
    for (k, &t) in field.source.iter().enumerate() {
        if let Some(frame) = frames.get_mut(t as usize) {
            *frame = [field.u[k], field.v[k]];
        }
    }
    Ok(frames)
}
