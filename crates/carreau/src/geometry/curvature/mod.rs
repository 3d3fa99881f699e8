//! Principal curvatures and directions at the vertices of a triangle mesh.
//!
//! Every estimator is one-sided: it looks at the surface cut along its features (`sectors`), so that a plane next to a
//! crease is as flat as any other. At a vertex on a crease each side has its own curvature; the result is their mean
//! weighted by area, after both tangent planes were turned into a common one.
//!
//! | file | holds |
//! |---|---|
//! | `sectors` | the surface cut along its features; normals |
//! | `tensor` | tensors, tangent planes, eigenvectors |
//! | `corrected` | interpolated corrected curvature measures over the faces around a vertex |
//! | `normal_cycle` | normal cycles on the faces around a vertex, with and without MEPP's bias |
//! | `ball`, `clip` | normal cycles in a ball |

mod ball;
mod clip;
mod corrected;
mod normal_cycle;
mod per_vertex;
mod sectors;
mod tensor;
#[cfg(test)]
mod tests;
mod tuning;

use crate::bounds::positive;
use crate::context::Context;
use crate::error::{Error, Result};
use crate::geometry::normals::unit;
use crate::geometry::summary::sum;
use crate::mesh::{NONE, Triangles, UnitScale};
use ball::{Ball, Visits};
use corrected::Corrected;
use glam::DVec3;
use normal_cycle::{MEPP_SHARE, Ring, turn, turns};
use per_vertex::{map, map_with};
use sectors::Sectors;
use serde::{Deserialize, Serialize};
use tensor::{Form, Frame};
use tuning::{DEFAULT_RADIUS, NO_AREA};

/// How curvatures are estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Estimator {
    /// Interpolated corrected curvature measures over the faces around a vertex (Lachaud et al. 2020).
    #[default]
    Corrected,
    /// Normal cycles on a third of the faces around a vertex: the noisiest.
    #[serde(rename = "normal-cycle-1ring")]
    NormalCycle1Ring,
    /// Normal cycles in a ball: smooths noise over its radius, and takes longest.
    NormalCycleBall,
    /// Normal cycles as MEPP takes them, a third too small and across features: for comparison only.
    Mepp,
}

impl Estimator {
    /// All of them.
    pub const ALL: [Estimator; 4] =
        [Estimator::Corrected, Estimator::NormalCycle1Ring, Estimator::NormalCycleBall, Estimator::Mepp];
}

/// How curvatures are computed.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CurvatureOptions {
    /// The method.
    pub estimator: Estimator,
    /// Radius of the ball, in the unit of the mesh; `None`: three mean edge lengths. Other estimators have none.
    pub radius: Option<f64>,
}

impl CurvatureOptions {
    /// Refuses a radius that is not above zero.
    ///
    /// # Errors
    /// [`Error::Options`].
    pub fn validate(&self) -> Result<()> {
        self.radius.map_or(Ok(()), |radius| positive("radius", radius))
    }
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
/// [`Error::Options`] where `feature` has not one entry per corner, or the radius is not a positive number;
/// [`Error::Cancelled`], [`Error::Deadline`].
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
    options.validate()?;
    let scale = UnitScale::of(triangles);
    let scaled = scale.points(triangles.points());
    let triangles = scaled.as_deref().map_or(triangles, |points| triangles.with_points(points));
    let none = if options.estimator == Estimator::Mepp { vec![false; feature.len()] } else { Vec::new() };
    let feature = if options.estimator == Estimator::Mepp { &none } else { feature };
    let sectors = Sectors::new(triangles, feature, context)?;
    let found = match options.estimator {
        Estimator::Corrected => {
            let corrected = Corrected::new(&sectors, context)?;
            principal(&sectors, context, || (), |(), s, plane| corrected.at(&sectors, s, plane))?
        }
        Estimator::NormalCycle1Ring => ring(&sectors, 1.0, context)?,
        Estimator::Mepp => ring(&sectors, MEPP_SHARE, context)?,
        Estimator::NormalCycleBall => {
            let radius = options.radius.map_or_else(|| default_radius(triangles, context), |r| Ok(scale.length(r)))?;
            in_ball(&sectors, radius, context)?
        }
    };
    Ok(collect(found, border_vertices(triangles), scale))
}

/// Magnitudes of the principal curvatures, (larger, smaller), of the whole normal-cycle tensor on the faces around each
/// vertex: creases count like all other edges. What separates two regions at a sharp edge.
///
/// Entries of vertices that `wanted` leaves out are zero; an empty `wanted` means all.
///
/// # Errors
/// [`Error::Cancelled`], [`Error::Deadline`].
pub fn full_magnitudes(triangles: Triangles<'_>, wanted: &[bool], context: &Context) -> Result<Vec<[f64; 2]>> {
    if !wanted.is_empty() && !wanted.contains(&true) {
        return Ok(vec![[0.0; 2]; triangles.points().len()]);
    }
    let scale = UnitScale::of(triangles);
    let scaled = scale.points(triangles.points());
    let triangles = scaled.as_deref().map_or(triangles, |points| triangles.with_points(points));
    let none = vec![false; 3 * triangles.len()];
    let wanted = |v: u32| wanted.get(v as usize).copied().unwrap_or(wanted.is_empty());
    let sectors = Sectors::around(triangles, &none, wanted, context)?;
    // A vertex asks only for the half-edges that leave it.
    let needed = |c: u32| if wanted(triangles.vertex(c)) { turn(&sectors, c) } else { 0.0 };
    let ring = Ring { turns: map(3 * triangles.len(), context, needed)?, share: 1.0 };
    map(triangles.points().len(), context, |v| {
        if !wanted(v) {
            return [0.0; 2];
        }
        let found = at_vertex(&sectors, v, |s, plane| ring.at(&sectors, s, plane));
        let [a, b] = found.values.map(|k| scale.curvature(k).abs());
        [a.max(b), a.min(b)]
    })
}

fn ring(sectors: &Sectors<'_>, share: f64, context: &Context) -> Result<Vec<Principal>> {
    let ring = Ring { turns: turns(sectors, context)?, share };
    principal(sectors, context, || (), |(), s, plane| ring.at(sectors, s, plane))
}

fn in_ball(sectors: &Sectors<'_>, radius: f64, context: &Context) -> Result<Vec<Principal>> {
    let ball = Ball::new(sectors, radius, context)?;
    let visits = || Visits::new(sectors.triangles.len());
    let found = principal(sectors, context, visits, |visits, s, plane| ball.at(sectors, visits, s, plane))?;
    context.check()?;
    Ok(found)
}

/// The radius of a ball that is not given; edges between two faces count twice.
fn default_radius(triangles: Triangles<'_>, context: &Context) -> Result<f64> {
    let lengths =
        map(3 * triangles.len(), context, |c| triangles.point(c).distance(triangles.point(triangles.next(c))))?;
    Ok(DEFAULT_RADIUS * sum(&lengths) / lengths.len().max(1) as f64)
}

/// What is found at a vertex.
#[derive(Clone, Copy, Default)]
struct Principal {
    values: [f64; 2],
    directions: [DVec3; 2],
    area: f64,
}

/// Eigenvalues and eigenvectors at every vertex of the second fundamental forms that `form` gives for its sectors, each
/// with the area that it is the mean over. `memory` makes what `form` works with on one thread.
fn principal<M>(
    sectors: &Sectors<'_>,
    context: &Context,
    memory: impl Fn() -> M + Send + Sync,
    form: impl Fn(&mut M, u32, &Frame) -> (Form, f64) + Send + Sync,
) -> Result<Vec<Principal>> {
    map_with(sectors.triangles.points().len(), context, memory, |memory, v| {
        at_vertex(sectors, v, |s, plane| form(memory, s, plane))
    })
}

/// [`principal`] at one vertex.
#[inline]
fn at_vertex(sectors: &Sectors<'_>, v: u32, mut form: impl FnMut(u32, &Frame) -> (Form, f64)) -> Principal {
    let (normal, ring_area) = vertex_normal(sectors, v);
    let mut found = Principal { area: ring_area / 3.0, ..Principal::default() };
    if normal != DVec3::ZERO {
        let plane = Frame::across(normal);
        let whole = sectors.further(v).is_empty();
        let form = if whole { form(v, &plane).0 } else { mean_form(sectors, v, normal, &plane, form) };
        (found.values, found.directions) = form.eigen(&plane);
    }
    found
}

/// Unit normal of a vertex, its sectors' weighted by their areas, and the area of the faces around it.
#[inline]
fn vertex_normal(sectors: &Sectors<'_>, v: u32) -> (DVec3, f64) {
    let further = sectors.further(v);
    if further.is_empty() {
        let fan = &sectors.fans[v as usize];
        return (fan.normal, fan.area);
    }
    let all = [v].into_iter().chain(further.iter().map(|&(_, s)| s));
    let (sum, area) = all.fold((DVec3::ZERO, 0.0), |(sum, total), s| {
        let fan = &sectors.fans[s as usize];
        (sum + fan.area * fan.normal, total + fan.area)
    });
    (unit(sum), area)
}

/// The mean over the sectors of a vertex on a crease, weighted by area, each turned from its own tangent plane.
fn mean_form(
    sectors: &Sectors<'_>,
    v: u32,
    normal: DVec3,
    plane: &Frame,
    mut form: impl FnMut(u32, &Frame) -> (Form, f64),
) -> Form {
    let (mut sum, mut total) = (Form::default(), 0.0);
    for s in [v].into_iter().chain(sectors.further(v).iter().map(|&(_, s)| s)) {
        let own = sectors.fans[s as usize].normal;
        if own != DVec3::ZERO {
            let (form, area) = form(s, &plane.carried(normal, own));
            sum = sum.plus(area, form);
            total += area;
        }
    }
    if total > NO_AREA { Form::default().plus(1.0 / total, sum) } else { Form::default() }
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
fn collect(found: Vec<Principal>, border: Vec<bool>, scale: UnitScale) -> Curvature {
    Curvature {
        kmin: found.iter().map(|p| scale.curvature(p.values[0])).collect(),
        kmax: found.iter().map(|p| scale.curvature(p.values[1])).collect(),
        dmin: found.iter().map(|p| p.directions[0]).collect(),
        dmax: found.iter().map(|p| p.directions[1]).collect(),
        border,
        area: found.iter().map(|p| scale.area(p.area)).collect(),
    }
}
