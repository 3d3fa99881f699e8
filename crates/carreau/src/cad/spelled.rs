//! Extrusions of splines written as spline surfaces, with their borders in the parameter plane.
//!
//! Programs integrate over a face by one set of Gauss points across u, eight at least, and for volumes by as many as v has spans
//! for, without regard to the profile of an extrusion: a cylinder over an ellipse weighs 6 % wrong. As a spline surface whose
//! profile runs along v, with borders that have its knots, it weighs right.
//!
//! ```text
//!     v │ ·────────·
//!       │ ┼        ┼      a border along the profile has the knots of the profile,
//!       │ ┼        ┼      one across is a generator
//!       │ ·────────·
//!       └──────────── u
//! ```

use super::draft::Draft;
use super::seams::extent;
use super::tuning::NAMED_DISTANCE;
use crate::brep::{Brep, Curve, Edge, EdgeUse, Surface};
use crate::geometry::bspline::{BSplineSurface, Knots};

/// An extrusion that was written as a spline surface.
pub struct Spelled {
    extrusion: Surface,
    /// The height along the extrusion for a u of 1: 1, or -1 where the normal would be the opposite one.
    rise: f64,
}

/// Writes the extrusion of a spline as a spline surface with the normal of the face with these loops; all else stays.
pub fn spell_out(
    surface: &mut Surface,
    same_sense: bool,
    draft: &Draft,
    loops: &[Vec<(u32, bool)>],
) -> Option<Spelled> {
    let Surface::Extrusion { profile: Curve::Spline(profile), direction } = &*surface else { return None };
    let [low, high] = extent(draft, loops, |p| surface.project(p)[1]);
    let (rise, heights) = if same_sense { (-1.0, [high, low]) } else { (1.0, [low, high]) };
    let [first, last] = heights.map(|h| rise * h);
    let u = Knots::new(1, vec![first, first, last, last]).ok()?;
    let control = profile.points().iter().flat_map(|&p| heights.map(|h| p + h * *direction)).collect();
    let spelled = BSplineSurface::new(u, profile.knots().clone(), control).ok()?;
    Some(Spelled { extrusion: std::mem::replace(surface, Surface::Spline(spelled)), rise })
}

/// Gives the borders of such a face their parameters: those along the profile, and the generators between them.
pub fn lay_borders(brep: &mut Brep, face: usize, spelled: &Spelled, diagonal: f64) {
    let room = NAMED_DISTANCE * diagonal;
    let mut loops = std::mem::take(&mut brep.faces[face].loops);
    loops.iter_mut().for_each(|uses| lay(uses, &brep.edges, spelled, room));
    brep.faces[face].loops = loops;
}

/// One loop, from a border along the profile on, because only that tells at which end of a closed profile a seam is.
fn lay(uses: &mut [EdgeUse], edges: &[Edge], Spelled { extrusion, rise }: &Spelled, room: f64) {
    let level = |of: &EdgeUse| along_profile(&edges[of.edge as usize], extrusion, room);
    let mut levels: Vec<_> = uses.iter().map(level).collect();
    let Some(first) = levels.iter().position(Option::is_some) else { return };
    let (mut u, count) = (0.0, uses.len());
    for k in 0..count {
        let k = (first + k) % count;
        let of = &mut uses[k];
        let edge = &edges[of.edge as usize];
        let generator = || {
            let ends = edge.range.map(|t| extrusion.project_near(edge.curve.point(t), [u, 0.0])[1]).map(|v| [u, v]);
            let is_one =
                (0..2).all(|i| extrusion.point(u, ends[i][1]).distance(edge.curve.point(edge.range[i])) <= room);
            (matches!(edge.curve, Curve::Line { .. }) && is_one).then(|| ends.to_vec())
        };
        let Some(laid) = levels[k].take().or_else(generator) else { return };
        u = if of.reversed { laid[0][0] } else { laid[laid.len() - 1][0] };
        of.parameters = laid.into_iter().map(|[along, height]| [rise * height, along]).collect();
    }
}

/// The parameters of a border that is the profile, moved: one pair for each of its knots.
fn along_profile(edge: &Edge, extrusion: &Surface, room: f64) -> Option<Vec<[f64; 2]>> {
    let (Curve::Spline(curve), Surface::Extrusion { profile, .. }) = (&edge.curve, extrusion) else { return None };
    let breaks = curve.knots().breaks();
    let t = 0.5 * (breaks[0] + breaks[1]);
    let [u, v] = extrusion.project(curve.point(t));
    let sense = curve.derivatives(t)[1].dot(profile.derivatives(u)[1]).signum();
    let [low, high] = profile.domain();
    let laid: Vec<[f64; 2]> = breaks.iter().map(|&b| [(u + sense * (b - t)).clamp(low, high), v]).collect();
    let is_on = |(&b, &[u, v]): (&f64, &[f64; 2])| extrusion.point(u, v).distance(curve.point(b)) <= room;
    breaks.iter().zip(&laid).all(is_on).then_some(laid)
}
