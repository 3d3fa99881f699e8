//! The driver of surfaces: skeleton, coarse cells, boundary on the surface.

mod coarse;
mod fallbacks;
mod prepared;

use super::target::Target;
use super::{HexOptions, HexResult, Stage, deliver, ends, fork_trunks, judge};
use crate::context::Context;
use crate::error::Result;
use crate::mesh::{CurveNet, SurfaceMesh, UnitScale};
use coarse::Coarse;
use prepared::{Ready, skeleton_of};

/// Number of cells, in all attempts together, after which no other skeleton is tried.
const MANY_TRIED: usize = 150_000;
/// Branchings closer than this share of the sum of their radii become one: shares tried in turn, until the coarsest cells
/// can be put onto the surface. Tubes that leave a ball side by side part far from its centre, and branchings on the way
/// have no room for cells; but those of a tree do.
const MERGES: [f64; 4] = [1.0, 0.6, 1.4, 0.3];
/// Directions closer than this get a trunk, in degrees: both are tried with every share. Cells in wider forks have better
/// shapes, but limbs beside each other on a body are none.
const NARROW: [f64; 2] = [fork_trunks::CLOSE_DEGREES, fork_trunks::NARROW_DEGREES];
/// A boundary this near to the surface, as a share of the diagonal, needs no second try.
const WELL: f64 = 0.02;

/// Meshes a surface; its skeleton is extracted where none is given.
///
/// # Errors
/// Those of [`skeleton::extract`](crate::skeleton::extract) and [`super::from_net`]; [`Error::Input`](crate::Error::Input) for a skeleton that lies outside; [`Error::Numeric`](crate::Error::Numeric)
/// for cells that are farther from the surface than allowed, or lie where others are, unless `allow_far` is set.
pub fn from_surface(
    mesh: &SurfaceMesh,
    skeleton: Option<&CurveNet>,
    options: &HexOptions,
    context: &Context,
) -> Result<HexResult> {
    let mut result = meshed(mesh, skeleton, options, context)?;
    judge::accept(&mut result, options, mesh.diagonal())?;
    judge::tell(&mut result);
    Ok(result)
}

/// The mesh, not yet judged.
fn meshed(
    mesh: &SurfaceMesh,
    skeleton: Option<&CurveNet>,
    options: &HexOptions,
    context: &Context,
) -> Result<HexResult> {
    options.validate()?;
    let scale = UnitScale::of_mesh(mesh);
    if let Some(mesh) = scale.mesh(mesh, &[]) {
        let skeleton = skeleton.map(|net| scale.moved_net(net.clone()));
        let made = meshed(&mesh, skeleton.as_ref(), &options.in_scale(scale), context)?;
        return Ok(made.in_scale(scale.back()));
    }
    let (closed, net, mut warnings) = skeleton_of(mesh, skeleton, context)?;
    let closed = ends::told_apart(closed, &net)?;
    let target = Target::new(&closed);
    let mut tried: Vec<Coarse> = Vec::new();
    let (mut known, mut made): (Vec<CurveNet>, usize) = (Vec::new(), 0);
    for (merge, narrow) in MERGES.into_iter().flat_map(|merge| NARROW.map(|narrow| (merge, narrow))) {
        let ready = Ready::new(&net, [merge, narrow], &target, options, context)?;
        if known.contains(&ready.net) {
            continue;
        }
        known.push(ready.net.clone());
        let Some(cells) = Coarse::found(ready, &target, tried.iter().any(Coarse::is_valid), context)? else {
            continue;
        };
        tracing::debug!(
            merge,
            narrow,
            left = cells.left,
            off = cells.off,
            mean = cells.mean,
            segments = cells.ready.net.edges.len(),
            "coarse cells"
        );
        let fits = cells.left == 0 && cells.off < WELL * closed.mesh.diagonal();
        made += cells.tube.hexes.len();
        tried.push(cells);
        if fits || options.stage == Stage::Base || made > MANY_TRIED {
            break;
        }
    }
    tried.sort_by(|a, b| a.score().total_cmp(&b.score()));
    let coarse = fallbacks::best(tried, &closed, &target, context)?;
    let left = coarse.left;
    let Ready { net, options, lid_of, .. } = coarse.ready;
    let mut tube = coarse.tube;
    warnings.extend(coarse.ready.warnings.into_iter().chain(coarse.warnings));
    if left > 0 {
        warnings.push(format!("{left} boundary vertices could not be put onto the surface without folding a cell"));
    }
    if coarse.is_hopeless {
        warnings.push("the surface is not tubular: part of it cannot be reached by tubes around its skeleton".into());
    }
    tube.caps.iter_mut().filter(|c| **c > 0).for_each(|c| *c = lid_of[*c as usize - 1]);
    let mut result = deliver::with_boundary(tube, net, warnings, &options, context)?;
    deliver::certify(&mut result, &options)?;
    judge::measure(&mut result, &closed.mesh, &options, context)?;
    let numbered = (2..).zip(target.lids());
    result.flat_caps = numbered.filter(|(_, lid)| !lid.is_open).map(|(tag, _)| tag).collect();
    deliver::finish(&mut result, &options, Some(&target), context)?;
    Ok(result)
}
