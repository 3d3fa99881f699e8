//! The methods in their order: what one gives is taken if it is of use, or else the next one is tried.

use super::halve::{Middle, halve};
use super::judged::Judged;
use super::mapped::{self, OfMap};
use super::source::Source;
use super::work::{Place, Work};
use super::{QuadOptions, paired, sew, validate};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::geometry::features::{Creases, FeatureOptions};
use crate::mesh::SurfaceMesh;

/// How quads were made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// By global parametrisation.
    Map,
    /// Triangles of twice the size, paired and halved.
    Pairs,
    /// Every triangle of the input became three quads.
    Thirds,
}

impl Method {
    /// Its rung in the record; the second one is none any more.
    pub fn rung(self) -> u32 {
        match self {
            Method::Map => 1,
            Method::Pairs => 3,
            Method::Thirds => 4,
        }
    }
}

/// Quads, with how they were made, and what was repaired before or could not be reached, one sentence each.
pub struct Made {
    pub work: Work,
    pub method: Method,
    pub warnings: Vec<String>,
}

/// The best quads, with the surface whose features they keep.
pub fn best(source: Source, mesh: &SurfaceMesh, options: &QuadOptions, context: &Context) -> Result<(Source, Made)> {
    if let Some(made) = sewn_and_cut(&source, options, context)? {
        return Ok((source, made));
    }
    let map = of_map(&source, options, context)?;
    let may_leave_out = options.rung == 1 && source.is_noisy && options.features.creases == Creases::Auto;
    if may_leave_out
        && !map.will_do()
        && let Some(found) = without_creases(&source, mesh, options, context)?
    {
        return Ok(found);
    }
    let made = or_next(&source, map, options, context)?;
    Ok((source, made))
}

fn of_map(source: &Source, options: &QuadOptions, context: &Context) -> Result<OfMap> {
    if options.rung > 1 {
        return Ok(OfMap::default());
    }
    mapped::quads(source, options, context)
}

/// Creases that fade out may leave no room for so few quads: those of the map without any, if it has as many as were asked
/// for.
fn without_creases(
    with: &Source,
    mesh: &SurfaceMesh,
    options: &QuadOptions,
    context: &Context,
) -> Result<Option<(Source, Made)>> {
    let features = FeatureOptions { angle_deg: None, ..options.features.clone() };
    let source = Source::new(mesh, &features, context)?.guided(with.guidance.clone());
    let Some(found) = of_map(&source, options, context)?.best.filter(|b| b.meets_number && !b.is_flat) else {
        return Ok(None);
    };
    let mut warnings = source.surface.repaired.clone();
    warnings.push(
        "the creases of the surface, which fade out, leave no room for so few quads and are not kept; more quads keep them, or an angle \
         from which on edges are features"
            .into(),
    );
    Ok(Some((source, Made { work: found.work, method: Method::Map, warnings })))
}

/// What came of the map if it is of use, or what comes of the next methods.
fn or_next(source: &Source, map: OfMap, options: &QuadOptions, context: &Context) -> Result<Made> {
    let mut warnings = source.surface.repaired.clone();
    let pairs = if map.will_do() || options.last_rung < 3 {
        None
    } else {
        paired::quads(source, options, &mut warnings, context)?
    };
    let candidates = map.best.map(|b| (b, Method::Map)).into_iter().chain(pairs.map(|b| (b, Method::Pairs)));
    // What keeps all features of a part goes before what loses some, however many quads that takes.
    let best = candidates.min_by_key(|of| of.0.worth());
    if options.rung == 1 && best.as_ref().is_none_or(|b| b.1 != Method::Map) {
        warnings.push(format!("no map of the surface gave quads: {}", map.refused));
    }
    if let Some((Judged { work, .. }, method)) = best {
        return Ok(Made { work, method, warnings });
    }
    if options.last_rung < 4 {
        return Err(Error::Numeric(format!("no quads were found: {}", map.refused)));
    }
    warnings.push("every triangle becomes three quads".into());
    Ok(Made { work: thirds(source), method: Method::Thirds, warnings })
}

/// The same for a surface whose borders lie on each other, with these sewn while quads are made: both sides agree there. `None`
/// where there is nothing to sew, or the quads are not those of the surface after it.
fn sewn_and_cut(source: &Source, options: &QuadOptions, context: &Context) -> Result<Option<Made>> {
    let Some(sewn) = source.sewn(context)? else { return Ok(None) };
    let mut made = or_next(&sewn, of_map(&sewn, options, context)?, options, context)?;
    sew::cut_open(&mut made.work, |curve| sewn.is_sewn[curve as usize]);
    let refusal = validate::topology_refusal(&made.work.to_mesh()?, source);
    tracing::debug!(target: "carreau::quad", refusal, "cut open");
    made.warnings.splice(0..0, source.surface.repaired.iter().cloned());
    Ok(refusal.is_none().then_some(made))
}

/// Every triangle becomes three quads: always possible.
fn thirds(source: &Source) -> Work {
    let mesh = &source.surface.mesh;
    let mut place = vec![Place::Fixed; mesh.vertex_count()];
    for (c, &v) in mesh.faces().corners().iter().enumerate() {
        place[v as usize] = Place::Region(source.region[c / 3]);
    }
    let features: Vec<([u32; 2], u32)> = source.edges.iter().copied().zip(source.curve.iter().copied()).collect();
    features.iter().flat_map(|f| f.0).for_each(|v| place[v as usize] = Place::Fixed);
    let coarse = Work {
        points: mesh.points().to_vec(),
        place,
        faces: mesh.faces().clone(),
        region: source.region.clone(),
        features,
    };
    halve(&coarse, source, Middle::Straight)
}
