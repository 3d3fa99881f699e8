//! Preparation: what every room is given of a surface, however the file has it.
//!
//! | step | file | what happens |
//! |---|---|---|
//! | 1 | `super::weld` | vertices at one place become one |
//! | 2 | `super::repair` | faces without area are left out, the surface stays closed |
//! | 3 | `folds`, `doubles` | of several faces on the same vertices one stays, two as the wall between bodies, or none where fans fold |
//! | 4 | `sheets` | neighbours are turned until they agree; the majority of a part decides |
//! | 5 | `sheets`, `radial` | which sides of an edge of many faces are one body; 4 and 5 in turn, until nothing changes |
//! | 6 | `separate` | bodies that touch come apart, and the sheets of a vertex |
//! | 7 | `super::repair` | closed components look outward, cavities inward, each for itself |
//! | 8 | `bodies`, `pieces` | bodies with their names; small pieces are told or left out |
//!
//! `mend` has steps 2 to 7, for [`super::repair`] as well: that cuts what is left besides, drops vertices that no face uses, and
//! leaves steps out where it is asked to.
//!
//! A surface on which there is nothing to do is given back as it is, bit for bit; `scan` finds out, in a fraction of the time.
//! Else the result remembers what each of its vertices and faces was in the file: [`Prepared`] leads back. Borders, edges of
//! three faces and one-sided surfaces are not mended: [`PrepareReport::left`] names them in the words of `info`.
//!
//! Nothing is cut, no vertex is dropped that does not lie on another, and what was done can be traced.

mod bodies;
mod doubles;
mod folds;
mod ids;
mod mend;
mod options;
mod pieces;
mod radial;
mod report;
mod scan;
mod seams;
mod separate;
mod sheets;
mod sides;
#[cfg(test)]
mod tests;
mod trace;

use super::surface::SurfaceMesh;
use crate::context::Context;
use crate::error::{Error, Result};
use scan::Scan;
use trace::Trace;

pub(super) use bodies::labels as body_labels;
pub use bodies::{Bodies, Body};
pub(super) use mend::{Mended, Steps, mend};
pub use options::{Keep, PrepareOptions, Takes};
pub use report::{PreparePlaces, PrepareReport};
pub(super) use scan::leaders;
pub use trace::Prepared;

/// Prepares a surface; see the module's head for the steps.
///
/// ```
/// use carreau::mesh::{PrepareOptions, SurfaceMesh, Takes, prepare};
/// use carreau::{Context, sample};
/// let context = Context::new();
/// let clean = sample::make("bracket", None, &context)?;
/// // Every triangle with vertices of its own.
/// let points = clean.faces().corners().iter().map(|&v| clean.points()[v as usize]).collect();
/// let faces: Vec<[u32; 3]> = (0..clean.face_count() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
/// let soup = SurfaceMesh::from_triangles(points, &faces)?;
/// let prepared = prepare(soup, &PrepareOptions::default(), Takes::Bodies, &context)?;
/// assert_eq!(prepared.mesh.vertex_count(), clean.vertex_count());
/// assert!(prepared.report.line().is_some_and(|line| line.contains("welded")));
/// # Ok::<(), carreau::Error>(())
/// ```
///
/// # Errors
/// [`Error::Options`] for a length that is none, [`Error::Cancelled`] and [`Error::Deadline`].
pub fn prepare(mesh: SurfaceMesh, options: &PrepareOptions, takes: Takes, context: &Context) -> Result<Prepared> {
    prepare_parts(mesh, None, options, takes, context)
}

/// Cuts all polygons into fans from their first corners, as [`SurfaceMesh::fanned`], and prepares the triangles. Where fans fold
/// onto each other the triangles that do go, both of each pair.
///
/// # Errors
/// As [`prepare`] and [`SurfaceMesh::fanned`].
pub fn prepare_fans(mesh: SurfaceMesh, options: &PrepareOptions, takes: Takes, context: &Context) -> Result<Prepared> {
    let polygon = (!mesh.is_triangular()).then(|| mesh.faces().fan().1);
    prepare_parts(mesh.fanned()?, polygon.as_deref(), options, takes, context)
}

/// `polygon`: that of every face, where faces are parts of such.
fn prepare_parts(
    mesh: SurfaceMesh,
    polygon: Option<&[u32]>,
    options: &PrepareOptions,
    takes: Takes,
    context: &Context,
) -> Result<Prepared> {
    if options.as_is {
        return Ok(Prepared::as_is(mesh));
    }
    let _stage = context.stage("prepare");
    let tolerance = options.weld.resolve(mesh.diagonal());
    if !(tolerance >= 0.0 && tolerance.is_finite()) {
        return Err(Error::Options(format!("weld: {} is not a length such as 0.01 or 0.001%", options.weld)));
    }
    let scan = context.install(|| Scan::of(&mesh, tolerance));
    context.check()?;
    if scan.is_sound() {
        let bodies = Bodies::of(&mesh, &scan.component, scan.components, &scan.shells);
        return pieces::keep(Prepared::unchanged(mesh, bodies), options.keep, takes);
    }
    let mended = context.install(|| mend(&mesh, scan.leader.as_deref(), polygon, Steps::PREPARE, context))?;
    pieces::keep(into_prepared(mended, mesh)?, options.keep, takes)
}

/// Leaves out pieces of a surface, and does nothing else.
///
/// # Errors
/// None that the mesh itself did not have.
pub fn keep_pieces(mesh: SurfaceMesh, keep: Keep) -> Result<Prepared> {
    let (component, components, shells) = scan::parts(&mesh);
    let bodies = Bodies::of(&mesh, &component, components, &shells);
    pieces::keep(Prepared::unchanged(mesh, bodies), Some(keep), Takes::Bodies)
}

/// The surface with its trace, or as it was where nothing came of it.
fn into_prepared(mended: Mended, input: SurfaceMesh) -> Result<Prepared> {
    let mut report = PrepareReport::of(&mended, &input);
    let Mended { soup, doubles, .. } = mended;
    if soup.points == input.points() && soup.faces == *input.faces() {
        let (component, components, shells) = scan::parts(&input);
        let bodies = Bodies::of(&input, &component, components, &shells);
        report.count_left(&input, |v| v);
        return Ok(Prepared {
            report: PrepareReport { bodies: bodies.list.len(), ..report },
            ..Prepared::unchanged(input, bodies)
        });
    }
    let trace = Trace::of(&soup, &input, &doubles);
    let corners = soup.corner_source.clone();
    let mut mesh = soup.into_mesh(&input)?;
    trace::split_columns(&mut mesh, &input, &trace.vertex_source, &corners);
    let (component, components, shells) = scan::parts(&mesh);
    let bodies = Bodies::of(&mesh, &component, components, &shells);
    report.count_left(&mesh, |v| trace.vertex_source[v as usize]);
    report.bodies = bodies.list.len();
    Ok(Prepared { mesh, bodies, report, trace: Some(Box::new(trace.with(input))) })
}
