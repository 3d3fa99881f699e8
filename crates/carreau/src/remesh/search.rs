//! Sizes that give what is wanted: a number of triangles, or a distance.

use super::geometric::{Geometric, Goal};
use super::options::RemeshOptions;
use super::output::{self, Made};
use super::predicted::predicted;
use super::source::Source;
use super::target;
use crate::context::Context;
use crate::error::{Error, Result};
use crate::geometry::distance::{DistanceOptions, compare};
use crate::mesh::SurfaceMesh;

/// Runs with a corrected scale before the nearest count is good enough. One does, as a rule: a run steers its own sizes.
const COUNT_RUNS: usize = 3;
/// Factors on the tolerance of the ridges, one after the other, where the tolerance needs more triangles than are wanted: at
/// the last the ridges of a part of a thousand triangles are within 3 % of the diagonal.
const LOOSER: [f64; 4] = [1.0, 4.0, 16.0, 64.0];

/// A mesh with a wanted number of triangles, and the tolerance of the ridges that it took, as a share of the diagonal.
pub(super) fn to_count(
    mesh: &SurfaceMesh,
    source: &mut Source,
    options: &RemeshOptions,
    wanted: usize,
    context: &Context,
) -> Result<(SurfaceMesh, f64)> {
    let mut best: Option<(SurfaceMesh, f64)> = None;
    let miss = |m: &SurfaceMesh| m.face_count().abs_diff(wanted);
    for looser in LOOSER {
        let ridge_tolerance = looser * options.ridge_tolerance;
        let options = RemeshOptions { ridge_tolerance, ..options.clone() };
        let mut aim = wanted as f64;
        for _ in 0..COUNT_RUNS {
            let scale = target::find_scale(source, &options, aim, context)?;
            let options = RemeshOptions { scale, ..options.clone() };
            source.set_sizes(&options, context)?;
            let out = source.adapted(mesh, &options, false, context)?;
            let (count, is_nearer) = (out.face_count(), best.as_ref().is_none_or(|b| miss(&out) < miss(&b.0)));
            aim *= wanted as f64 / count.max(1) as f64;
            if is_nearer {
                best = Some((out, ridge_tolerance));
            }
            let is_met = count.abs_diff(wanted) as f64 <= target::MET * wanted as f64;
            // Sizes that change nothing are not what is in the way.
            if is_met || !is_nearer || count as f64 > BOUND_BY_RIDGES * wanted as f64 {
                break;
            }
        }
        if best.as_ref().is_some_and(|b| b.0.face_count() as f64 <= (1.0 + target::MET) * wanted as f64) {
            break;
        }
    }
    best.ok_or_else(|| Error::Bug("no run".into()))
}

/// If this many times the wanted triangles are left, larger sizes alone will not do.
const BOUND_BY_RIDGES: f64 = 1.1;

/// How closely a distance is looked at where it is a promise: what counts is the upper bound.
pub(super) const CLOSE_LOOK: DistanceOptions =
    DistanceOptions { samples: 20_000, refinements: 200_000, normals: false };
/// Runs of [`within_distance`] before it gives up.
const DISTANCE_RUNS: usize = 8;
/// A distance that takes this many times the triangles of the input is out of reach.
const MOST_GROWTH: f64 = 8.0;

/// The coarsest mesh of a few whose two-sided distance from the input is certainly below a limit.
pub(super) fn within_distance(
    input: &SurfaceMesh,
    mesh: &SurfaceMesh,
    source: &mut Source,
    options: &RemeshOptions,
    limit: f64,
    context: &Context,
) -> Result<SurfaceMesh> {
    let mut scale = options.scale;
    let mut best: Option<(f64, SurfaceMesh)> = None;
    let mut too_large = f64::INFINITY;
    for _ in 0..DISTANCE_RUNS {
        let options = RemeshOptions { scale, triangles: None, ..options.clone() };
        source.set_sizes(&options, context)?;
        if predicted(&source.support) > MOST_GROWTH * mesh.face_count() as f64 + 1e4 {
            break;
        }
        let out = source.adapted(mesh, &options, false, context)?;
        let distance = compare(input, &out, &CLOSE_LOOK, context)?.distance.max_upper;
        if distance <= limit {
            let reached = distance > 0.8 * limit || too_large < 1.15 * scale;
            best = Some((scale, out));
            if reached {
                break;
            }
        } else {
            too_large = too_large.min(scale);
        }
        // The sag grows with the square of the size.
        let wanted = scale * (0.9 * limit / distance.max(f64::MIN_POSITIVE)).sqrt().clamp(0.2, 4.0);
        let low = best.as_ref().map_or(0.0, |b| b.0);
        let between = if low > 0.0 { (low * too_large).sqrt() } else { 0.7 * too_large };
        scale = if wanted < too_large && wanted > low { wanted } else { between };
        if !scale.is_finite() || scale > 1e3 {
            break;
        }
    }
    best.map(|b| b.1).ok_or_else(|| out_of_reach(limit))
}

/// Halvings of the error in [`least_error`] in search of a distance.
const ERROR_RUNS: usize = 10;

/// The purely geometric mode. With a distance the error to stop at is found by halving: the order of the collapses does not
/// depend on it, so that every run is the beginning of the next coarser one.
pub(super) fn least_error(
    input: &SurfaceMesh,
    mesh: &SurfaceMesh,
    source: &mut Source,
    options: &RemeshOptions,
    context: &Context,
) -> Result<SurfaceMesh> {
    source.set_sizes(options, context)?;
    let _stage = context.stage("decimate");
    let theta = options.deviation.to_radians();
    let with_target = options.triangles.is_some() || options.distance.is_some();
    let mut goal = Goal {
        triangles: options.triangles.unwrap_or(0),
        error: f64::INFINITY,
        cosine: if with_target { -1.0 } else { theta.cos() },
    };
    let run = |goal: &Goal| {
        let mut work = Geometric::new(&source.support, &source.curves);
        work.run(goal, context)?;
        let seat = |corner: u32| work.mesh.source[corner as usize / 3];
        let size = |v: u32| source.support.size[v as usize];
        output::assemble(mesh, &source.support, &Made { mesh: &work.mesh, seat: &seat, size: &size, stretch: &[] })
    };
    let Some(limit) = options.distance else { return run(&goal) };
    let (mut low, mut high) = (0.0, 2.0 * limit);
    let mut best = None;
    for _ in 0..ERROR_RUNS {
        goal.error = if low == 0.0 { 0.5 * high } else { 0.5 * (low + high) };
        let out = run(&goal)?;
        let distance = compare(input, &out, &CLOSE_LOOK, context)?.distance.max_upper;
        if distance <= limit {
            best = Some(out);
            low = goal.error;
            if distance > 0.95 * limit {
                break;
            }
        } else {
            high = goal.error;
        }
    }
    best.ok_or_else(|| out_of_reach(limit))
}

fn out_of_reach(limit: f64) -> Error {
    Error::Numeric(format!("no mesh within the distance {limit} was found; enrich first, or allow more"))
}
