//! The driver of surfaces: skeleton, coarse cells, boundary on the surface.

mod coarse;
mod fallbacks;
mod joining;
mod prepared;
mod tuning;

use super::target::Target;
use super::{HexOptions, HexResult, Stage, deliver, ends, judge};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::mesh::{CurveNet, SurfaceMesh, UnitScale};
use coarse::Coarse;
use joining::JOININGS;
use prepared::{Known, Ready, is_of_shape, skeletons_of};
use tuning::{MANY_TRIED, NARROW, WELL};

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
    let (closed, nets) = skeletons_of(mesh, skeleton, context)?;
    let Some((first, _)) = nets.first() else { return Err(Error::Numeric("no skeleton was found".into())) };
    let closed = ends::told_apart(closed, first)?;
    let target = Target::new(&closed);
    let tried = coarse_cells(&nets, &target, options, context)?;
    let coarse = fallbacks::best(tried, &closed, &target, context)?;
    let left = coarse.left;
    let Ready { net, options, lid_of, .. } = coarse.ready;
    let mut tube = coarse.tube;
    let mut warnings: Vec<String> = coarse.ready.warnings.into_iter().chain(coarse.warnings).collect();
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

/// The coarsest cells about every skeleton, the nearest first.
fn coarse_cells(nets: &[Known], target: &Target, options: &HexOptions, context: &Context) -> Result<Vec<Coarse>> {
    let mut tried: Vec<Coarse> = Vec::new();
    for (net, said) in nets {
        match about(net, said, target, options, &mut tried, context) {
            Err(e) if tried.is_empty() || !is_of_shape(&e) => return Err(e),
            _ => {}
        }
    }
    tried.sort_by(|a, b| a.score().total_cmp(&b.score()));
    Ok(tried)
}

/// The coarsest cells about one skeleton, of which `said` is to be said, in one way after the other until they fit.
fn about(
    net: &CurveNet,
    said: &[String],
    target: &Target,
    options: &HexOptions,
    tried: &mut Vec<Coarse>,
    context: &Context,
) -> Result<()> {
    let (mut known, mut made): (Vec<CurveNet>, usize) = (Vec::new(), 0);
    for (joining, narrow) in JOININGS.into_iter().flat_map(|joining| NARROW.map(|narrow| (joining, narrow))) {
        let mut ready = Ready::new(net, joining, narrow, target, options, context)?;
        if known.contains(&ready.net) {
            continue;
        }
        known.push(ready.net.clone());
        ready.warnings.splice(0..0, said.iter().cloned());
        let Some(cells) = Coarse::found(ready, target, tried.iter().any(Coarse::is_valid), context)? else {
            continue;
        };
        let segments = cells.ready.net.edges.len();
        tracing::debug!(?joining, narrow, cells.left, cells.off, cells.mean, segments, "coarse cells");
        let fits = cells.left == 0 && cells.off < WELL * target.surface().diagonal();
        made += cells.tube.hexes.len();
        tried.push(cells);
        if fits || options.stage == Stage::Base || made > MANY_TRIED {
            break;
        }
    }
    Ok(())
}
