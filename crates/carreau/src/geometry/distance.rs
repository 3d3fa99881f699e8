//! Two-sided distance and normal deviation of two surfaces.
//!
//! From each surface to the other: the mean and the root mean square over samples spread evenly by area, and the maximum
//! between two bounds. The lower bound is the largest distance of any sampled point, vertices included, and of what the
//! farthest samples find uphill. The upper bound follows from convexity: the distance to one triangle of the other surface
//! is a convex function, so over a whole triangle it is largest at a corner, and the smallest of these maxima, over a few
//! candidate triangles, bounds the distance of the whole triangle (the culling of Tang, Lee, Kim, "Interactive Hausdorff
//! Distance Computation for General Polygonal Models", SIGGRAPH 2009). Triangles whose bound exceeds the lower bound are
//! divided in four, best first in rounds of fixed size, until the two bounds meet or the budget is spent.

mod chunks;
mod maximum;
mod result;
mod samples;
mod target;
#[cfg(test)]
mod tests;

use super::summary::{Summary, sum};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::mesh::{SurfaceMesh, UnitScale};
use chunks::map_chunks;
use maximum::{Bracket, climb, narrow};
use samples::spread_samples;
use target::Target;

pub use result::{Comparison, Distance, DistanceOptions, OneSided};

/// Compares two surfaces. Polygons are taken as fans from their first corner.
///
/// The same for any number of threads; the samples do not depend on the seed.
///
/// # Errors
/// [`Error::Input`] where a surface has no face; [`Error::Cancelled`], [`Error::Deadline`].
pub fn compare(a: &SurfaceMesh, b: &SurfaceMesh, options: &DistanceOptions, context: &Context) -> Result<Comparison> {
    options.validate()?;
    for (mesh, which) in [(a, "first"), (b, "second")] {
        if mesh.faces().is_empty() {
            return Err(Error::input(format!("the {which} surface has no faces: there is no distance to it"), "", ""));
        }
    }
    let scale = UnitScale::of_mesh(a).with(UnitScale::of_mesh(b));
    if let (Some(a), Some(b)) = (scale.mesh(a, &[]), scale.mesh(b, &[])) {
        return Ok(compare(&a, &b, options, context)?.in_scale(scale.back()));
    }
    let _stage = context.stage("compare");
    context.install(|| {
        let (a, b) = (Target::new(a), Target::new(b));
        let (to_b, angles_to_b) = one_sided(&a, &b, options, context)?;
        let (to_a, angles_to_a) = one_sided(&b, &a, options, context)?;
        let distance = to_b.distance.with(to_a.distance);
        Ok(Comparison {
            diagonal: a.diagonal,
            distance,
            relative: distance.over(a.diagonal),
            normal_deg: Summary::of([angles_to_b, angles_to_a].concat()),
            a_to_b: to_b,
            b_to_a: to_a,
        })
    })
}

/// Everything about one direction; the angles in degrees for the summary of both.
fn one_sided(from: &Target, to: &Target, options: &DistanceOptions, context: &Context) -> Result<(OneSided, Vec<f64>)> {
    let at_vertices = map_chunks(&from.used, context, |&v, last| to.closest_near(from.points[v as usize], last))?;
    let (samples, apart) = spread_samples(from, options.samples);
    let found = map_chunks(&samples, context, |s, last| {
        let closest = to.closest_near(s.point, last);
        let angle = || to.angle_to(from.normals[s.triangle as usize], s.point, &closest);
        (closest.distance(), options.normals.then(angle).flatten())
    })?;

    let mut bracket = Bracket::default();
    at_vertices.iter().zip(&from.used).for_each(|(c, &v)| bracket.see(from.points[v as usize], c.distance()));
    found.iter().zip(&samples).for_each(|(f, s)| bracket.see(s.point, f.0));
    let distances: Vec<f64> = found.iter().map(|f| f.0).collect();
    climb(&mut bracket, &samples, &distances, apart, from, to);
    narrow(&mut bracket, from, to, &at_vertices, options.refinements, context)?;

    let squares: Vec<f64> = distances.iter().map(|d| d * d).collect();
    let count = distances.len().max(1) as f64;
    let square = sum(&squares) / count;
    let deviations: Vec<f64> = squares.iter().map(|s| (s - square).powi(2)).collect();
    let error = sum(&deviations).sqrt() / count;
    let angles: Vec<f64> = found.iter().filter_map(|f| f.1).map(f64::to_degrees).collect();
    let side = OneSided {
        distance: Distance {
            mean: sum(&distances) / count,
            rms: square.sqrt(),
            rms_upper: (square + 2.0 * error).sqrt(),
            max: bracket.lower,
            max_upper: bracket.upper,
        },
        max_at: bracket.at.to_array(),
        normal_deg: Summary::of(angles.clone()),
        points: bracket.points,
    };
    Ok((side, angles))
}
