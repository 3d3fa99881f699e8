//! Principal curvatures and directions at the vertices of a triangle mesh.
//!
//! Every estimator is one-sided: it looks at the surface cut along its features ([`sectors`]), so that a plane next to a
//! crease is as flat as any other. At a vertex on a crease each side has its own curvature; the result is their mean
//! weighted by area, after both tangent planes were turned into a common one.
//!
//! | file | holds |
//! |---|---|
//! | `sectors` | the surface cut along its features; normals |
//! | `tensor` | tensors, tangent planes, eigenvectors |
//! | `scale` | models of any size |
//! | `corrected` | interpolated corrected curvature measures over the faces around a vertex |

mod corrected;
mod scale;
mod sectors;
mod tensor;
#[cfg(test)]
mod tests;

use crate::context::Context;
use crate::error::{Error, Result};
use crate::geometry::normals::unit;
use crate::mesh::{NONE, Triangles};
use corrected::Corrected;
use glam::DVec3;
use rayon::prelude::*;
use scale::Scale;
use sectors::Sectors;
use serde::{Deserialize, Serialize};
use tensor::{Form, Frame};

/// How curvatures are estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Estimator {
    /// Interpolated corrected curvature measures over the faces around a vertex (Lachaud et al. 2020).
    #[default]
    Corrected,
}

/// How curvatures are computed.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CurvatureOptions {
    /// The method.
    pub estimator: Estimator,
}

/// Principal curvatures, one entry per vertex, in 1/(unit of length); positive where a surface oriented outwards is
/// convex. Vertices without a face of positive area have zeros.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Curvature {
    /// The smaller curvature, by value.
    pub kmin: Vec<f64>,
    /// The larger curvature, by value.
    pub kmax: Vec<f64>,
    /// Unit direction of `kmin`; zero where both curvatures are equal.
    pub dmin: Vec<DVec3>,
    /// Unit direction of `kmax`; zero where both curvatures are equal.
    pub dmax: Vec<DVec3>,
    /// On a border or an irregular edge: the surface is seen on one side only.
    pub border: Vec<bool>,
    /// One third of the area of the faces around the vertex.
    pub area: Vec<f64>,
}

/// Estimates the principal curvatures at all vertices.
///
/// `feature[c]` tells whether the half-edge that leaves corner `c` lies on a feature, as
/// [`crate::geometry::features::feature_edges`] finds them; nothing is measured across features.
///
/// # Errors
/// [`Error::Options`] where `feature` has not one entry per corner; [`Error::Cancelled`], [`Error::Deadline`].
pub fn curvature(
    triangles: Triangles<'_>,
    feature: &[bool],
    options: &CurvatureOptions,
    context: &Context,
) -> Result<Curvature> {
    if feature.len() != 3 * triangles.len() {
        let corners = 3 * triangles.len();
        return Err(Error::Options(format!("{} feature marks were given for {corners} corners", feature.len())));
    }
    let scale = Scale::of(triangles);
    let scaled = scale.points(triangles.points());
    let triangles = scaled.as_deref().map_or(triangles, |points| triangles.with_points(points));
    let sectors = Sectors::new(triangles, feature, context)?;
    let found = match options.estimator {
        Estimator::Corrected => {
            let corrected = Corrected::new(&sectors, context)?;
            principal(&sectors, context, |s, plane| corrected.at(&sectors, s, plane))?
        }
    };
    Ok(collect(found, border_vertices(triangles), scale))
}

/// What is found at a vertex.
#[derive(Clone, Copy, Default)]
struct Principal {
    values: [f64; 2],
    directions: [DVec3; 2],
    area: f64,
}

/// Eigenvalues and eigenvectors at every vertex of the second fundamental forms that `form` gives for its sectors, each
/// with the area that it is the mean over.
fn principal(
    sectors: &Sectors<'_>,
    context: &Context,
    form: impl Fn(u32, &Frame) -> (Form, f64) + Sync,
) -> Result<Vec<Principal>> {
    map(sectors.triangles.points().len(), context, |v| {
        let (normal, ring_area) = vertex_normal(sectors, v);
        let mut found = Principal { area: ring_area / 3.0, ..Principal::default() };
        if normal != DVec3::ZERO {
            let plane = Frame::across(normal);
            let whole = sectors.further(v).is_empty();
            let form = if whole { form(v, &plane).0 } else { mean_form(sectors, v, normal, &plane, &form) };
            (found.values, found.directions) = form.eigen(&plane);
        }
        found
    })
}

/// Unit normal of a vertex, its sectors' weighted by their areas, and the area of the faces around it.
#[inline]
fn vertex_normal(sectors: &Sectors<'_>, v: u32) -> (DVec3, f64) {
    let further = sectors.further(v);
    if further.is_empty() {
        return (sectors.normals[v as usize], sectors.ring_area(v));
    }
    let all = [v].into_iter().chain(further.iter().map(|&(_, s)| s));
    let (sum, area) = all.fold((DVec3::ZERO, 0.0), |(sum, total), s| {
        let area = sectors.ring_area(s);
        (sum + area * sectors.normals[s as usize], total + area)
    });
    (unit(sum), area)
}

/// The mean over the sectors of a vertex on a crease, weighted by area, each turned from its own tangent plane.
fn mean_form(
    sectors: &Sectors<'_>,
    v: u32,
    normal: DVec3,
    plane: &Frame,
    form: impl Fn(u32, &Frame) -> (Form, f64),
) -> Form {
    let (mut sum, mut total) = (Form::default(), 0.0);
    for s in [v].into_iter().chain(sectors.further(v).iter().map(|&(_, s)| s)) {
        let own = sectors.normals[s as usize];
        if own != DVec3::ZERO {
            let (form, area) = form(s, &plane.carried(normal, own));
            sum = sum.plus(area, form);
            total += area;
        }
    }
    if total > 0.0 { Form::default().plus(1.0 / total, sum) } else { Form::default() }
}

/// Vertices with a half-edge that has no regular opposite.
fn border_vertices(triangles: Triangles<'_>) -> Vec<bool> {
    let mut border = vec![false; triangles.points().len()];
    for c in (0..3 * triangles.len() as u32).filter(|&c| triangles.opposite(c) == NONE) {
        border[triangles.vertex(c) as usize] = true;
        border[triangles.vertex(triangles.next(c)) as usize] = true;
    }
    border
}

/// The result in the unit of the model.
fn collect(found: Vec<Principal>, border: Vec<bool>, scale: Scale) -> Curvature {
    Curvature {
        kmin: found.iter().map(|p| scale.curvature(p.values[0])).collect(),
        kmax: found.iter().map(|p| scale.curvature(p.values[1])).collect(),
        dmin: found.iter().map(|p| p.directions[0]).collect(),
        dmax: found.iter().map(|p| p.directions[1]).collect(),
        border,
        area: found.iter().map(|p| scale.area(p.area)).collect(),
    }
}

/// `f` of 0..count, in parallel; the result does not depend on the number of threads.
fn map<T: Default + Clone + Send>(count: usize, context: &Context, f: impl Fn(u32) -> T + Sync) -> Result<Vec<T>> {
    const CHUNK: usize = 4096;
    let mut all = vec![T::default(); count];
    all.par_chunks_mut(CHUNK).enumerate().try_for_each(|(k, chunk)| {
        context.check()?;
        for (at, i) in chunk.iter_mut().zip((k * CHUNK) as u32..) {
            *at = f(i);
        }
        Ok::<(), Error>(())
    })?;
    Ok(all)
}
