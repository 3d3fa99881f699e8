//! Loops in the parameters of their surface: which is the outer one, whether there is a seam, which way a
//! sphere is turned.
//!
//! ```text
//!      v │   ──────◄──────────── ring b          A loop that goes round in u is a ring: the face lies above
//!        │       │   ╭─►─╮                       a ring that runs to larger u (seen with the face's normal to
//!        │  seam │   ╰─◄─╯ hole                  the reader), and below one that runs back.
//!        │   ────┴─►──────────── ring a
//!        └──────────────────────────── u
//! ```

use super::conics::seam;
use super::draft::{Draft, DraftFace, Merge};
use super::regions::Piece;
use super::seams::{ALONG_SEAM, Seams, Unrolled, extent, points, spline_period, unroll};
use super::tuning::CAP_ANGLE;
use crate::brep::{Curve, Frame, Surface};
use crate::geometry::bspline::BSplineCurve;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, TAU};

/// What is wrong with a face.
pub type Reason = &'static str;

/// Turns a sphere so that its poles are out of the way of the loops: outside of a small face, on the axis of a zone.
pub fn turn_sphere(piece: &mut Piece, draft: &Draft, loops: &[Vec<(u32, bool)>], middle: DVec3) {
    let Surface::Sphere { frame, .. } = &mut piece.surface else { return };
    let center = frame.origin;
    let towards = (middle - center).normalize_or(DVec3::X);
    let samples = |uses: &Vec<(u32, bool)>| -> Vec<DVec3> {
        uses.iter().flat_map(|&(e, r)| points(draft, e, r)).map(|(p, _)| (p - center).normalize_or_zero()).collect()
    };
    let rims: Vec<Vec<DVec3>> = loops.iter().map(samples).collect();
    let widest = rims.iter().flatten().map(|p| p.dot(towards).clamp(-1.0, 1.0).acos()).fold(0.0, f64::max);
    if !rims.is_empty() && widest < CAP_ANGLE {
        // Among the directions across, the one that boundaries lean to: corners of boxes have their axes.
        let area = rims.iter().map(|r| area_vector(r)).sum::<DVec3>();
        let aside = rims.iter().flatten().copied().fold(DVec3::ZERO, |a, p| if a == DVec3::ZERO { p } else { a });
        let z =
            towards.cross(if aside.cross(towards).length() > 1e-3 { aside } else { towards.any_orthonormal_vector() });
        let _ = area;
        *frame = Frame::new(center, z, towards);
        return;
    }
    let largest = rims.iter().map(|r| area_vector(r)).max_by(|a, b| a.length().total_cmp(&b.length()));
    if let Some(z) = largest.and_then(DVec3::try_normalize) {
        *frame = Frame::new(center, z, towards);
    }
}

fn area_vector(rim: &[DVec3]) -> DVec3 {
    (0..rim.len()).map(|k| rim[k].cross(rim[(k + 1) % rim.len()])).sum()
}

/// The loops of a face, its seam, and which of its loops is the outer one. The parameters of the surface begin at the seam from
/// then on.
pub fn face(
    piece: &mut Piece,
    draft: &mut Draft,
    loops: Vec<Vec<(u32, bool)>>,
    diagonal: f64,
) -> Result<DraftFace, Reason> {
    let surface = &piece.surface;
    let unrolled: Vec<Unrolled> = loops.iter().map(|l| unroll(surface, draft, l)).collect();
    let mut face = DraftFace { loops, ..DraftFace::default() };
    if face.loops.is_empty() {
        return whole(piece, draft).ok_or("a closed region lies on an open surface");
    }
    let rings: Vec<usize> = (0..unrolled.len()).filter(|&k| unrolled[k].winding != [0, 0]).collect();
    let sense = if piece.same_sense { 1.0 } else { -1.0 };
    if rings.is_empty() {
        if matches!(surface, Surface::Torus { .. }) && unrolled.iter().all(|u| sense * u.area() < 0.0) {
            return Err("a torus with holes has no border");
        }
        face.outer = outer(&unrolled, sense).ok_or("its loops run the wrong way round")?;
        begin_profile_outside(&mut piece.surface, &unrolled[face.outer]);
        return Ok(face);
    }
    let k = usize::from(unrolled[rings[0]].winding[0] == 0);
    if rings.iter().any(|&r| unrolled[r].winding[k].abs() != 1 || unrolled[r].winding[1 - k] != 0) || rings.len() > 2 {
        return Err("its loops wind around the surface in more than one way");
    }
    // The material is on the left of every loop: above a ring that runs to larger u, and left of one that runs to larger v.
    let upward = |r: usize| f64::from(unrolled[r].winding[k]) * sense * if k == 0 { 1.0 } else { -1.0 } > 0.0;
    let seams = Seams { piece: &*piece, unrolled: &unrolled, k };
    if rings.len() == 1 {
        let end = point_of(surface, upward(rings[0])).ok_or("one ring alone bounds no face of its surface")?;
        let (crossing, x) = seams.best(draft, &face, rings[0], None, upward(rings[0])).ok_or("no seam is free")?;
        let edge = face.loops[rings[0]][crossing.use_].0;
        let t = seams.refined(draft, edge, crossing.t, x);
        let a = draft.vertex_on(edge, t, diagonal);
        let b = draft.vertex(end.0, 0.0);
        let seam = seams.edge(draft, x, [(a, crossing.at), (b, end.1)]).ok_or("its surface has no seam")?;
        face.merge = Some(Merge { first: (rings[0], a), second: (None, b), seam });
        begin_at_seam(&mut piece.surface, k, x);
        return Ok(face);
    }
    let [a, b] = if upward(rings[0]) { [rings[0], rings[1]] } else { [rings[1], rings[0]] };
    if !upward(a) || upward(b) {
        return Err("its rings run the same way");
    }
    let (low, x) = seams.best(draft, &face, a, Some(b), true).ok_or("no seam is free")?;
    let high = seams.beyond(&low, x).ok_or("no seam is free")?;
    let mut ends = [(0, 0.0); 2];
    for (end, c) in ends.iter_mut().zip([low, high]) {
        let edge = face.loops[c.of][c.use_].0;
        let t = seams.refined(draft, edge, c.t, x);
        *end = (draft.vertex_on(edge, t, diagonal), c.at);
    }
    let seam = seams.edge(draft, x, ends).ok_or("its surface has no seam")?;
    face.merge = Some(Merge { first: (a, ends[0].0), second: (Some(b), ends[1].0), seam });
    begin_at_seam(&mut piece.surface, k, x);
    Ok(face)
}

/// The loop around all others; `None` where one runs the wrong way round.
fn outer(unrolled: &[Unrolled], sense: f64) -> Option<usize> {
    let area = |k: usize| unrolled[k].area() * sense;
    let outer = (0..unrolled.len()).max_by(|&a, &b| area(a).total_cmp(&area(b)).then(b.cmp(&a)))?;
    (0..unrolled.len()).all(|k| (area(k) > 0.0) == (k == outer)).then_some(outer)
}

/// Puts the circle that a cone is described by in the middle of its face, because other programs lose faces of cones that are
/// described by their apex.
pub fn center_cone(piece: &mut Piece, draft: &Draft, loops: &[Vec<(u32, bool)>]) {
    let Surface::Cone { frame, radius, half_angle } = &mut piece.surface else { return };
    let [low, high] = extent(draft, loops, |p| (p - frame.origin).dot(frame.z));
    let middle = 0.5 * (low + high);
    let wider = *radius + middle * half_angle.tan();
    if middle.is_finite() && wider > 0.0 {
        frame.origin += middle * frame.z;
        *radius = wider;
    }
}

/// Lets a closed profile begin outside of a face that does not go round it.
fn begin_profile_outside(surface: &mut Surface, outer: &Unrolled) {
    let Some(k) = spline_period(surface) else { return };
    let [low, high] = outer.reach(k);
    let [start, end] = surface.domain()[k];
    let period = end - start;
    if low + (start - low).rem_euclid(period) < high {
        begin_profile(surface, k, 0.5 * (low + high + period));
    }
}

/// Lets the parameters of a surface begin at its seam, because in OpenCASCADE a face that is wider than the period by a rounding
/// cannot be tessellated.
fn begin_at_seam(surface: &mut Surface, k: usize, x: f64) {
    match surface {
        Surface::Cylinder { frame, .. }
        | Surface::Cone { frame, .. }
        | Surface::Sphere { frame, .. }
        | Surface::Torus { frame, .. }
            if k == 0 =>
        {
            *frame = Frame::new(frame.origin, frame.z, frame.radial(x));
        }
        _ => begin_profile(surface, k, x),
    }
}

/// Lets a closed profile begin at a parameter, because other programs do not go on beyond the ends of a spline.
fn begin_profile(surface: &mut Surface, k: usize, x: f64) {
    if spline_period(surface) != Some(k) {
        return;
    }
    if let Surface::Extrusion { profile, .. } | Surface::Revolution { profile, .. } = surface
        && let Curve::Spline(spline) = profile
    {
        let [low, high] = spline.knots().domain();
        let at = low + (x - low).rem_euclid(high - low);
        // At its end it begins already.
        if (at - low).min(high - at) > ALONG_SEAM * (high - low)
            && let Ok([before, behind]) = spline.split(at)
            && let Ok(begun) = BSplineCurve::joined(&[behind, before.rescaled([high, high + (at - low)])])
        {
            *spline = begun;
        }
    }
}

/// The apex or the pole beyond a ring, with its v.
fn point_of(surface: &Surface, upward: bool) -> Option<(DVec3, f64)> {
    match surface {
        Surface::Cone { radius, half_angle, .. } if !upward => {
            let v = -radius / half_angle.tan();
            Some((surface.point(0.0, v), v))
        }
        Surface::Sphere { .. } => {
            let v = if upward { FRAC_PI_2 } else { -FRAC_PI_2 };
            Some((surface.point(0.0, v), v))
        }
        Surface::Revolution { profile, .. } => {
            let v = profile.domain()[usize::from(upward)];
            let p = surface.point(0.0, v);
            (profile.period().is_none() && surface.is_on_axis(p)).then_some((p, v))
        }
        _ => None,
    }
}

/// Faces without a border: a whole sphere, a whole torus.
fn whole(piece: &Piece, draft: &mut Draft) -> Option<DraftFace> {
    match &piece.surface {
        Surface::Sphere { .. } => {
            let pole = draft.vertex(piece.surface.point(0.0, FRAC_PI_2), 0.0);
            Some(DraftFace { pole: Some(pole), ..DraftFace::default() })
        }
        Surface::Revolution { profile, .. } if profile.period().is_none() => {
            let range = profile.domain();
            let ends = range.map(|v| piece.surface.point(0.0, v));
            if !ends.iter().all(|&p| piece.surface.is_on_axis(p)) {
                return None;
            }
            let ends = ends.map(|p| draft.vertex(p, 0.0));
            let meridian = draft.seam(seam(&piece.surface, 0, 0.0)?, range, ends);
            Some(DraftFace { loops: vec![vec![(meridian, false), (meridian, true)]], ..DraftFace::default() })
        }
        Surface::Torus { .. } | Surface::Revolution { .. } => {
            let [_, profile] = piece.surface.domain();
            let v = draft.vertex(piece.surface.point(0.0, profile[0]), 0.0);
            let a = draft.seam(seam(&piece.surface, 1, profile[0])?, [0.0, TAU], [v, v]);
            let b = draft.seam(seam(&piece.surface, 0, 0.0)?, profile, [v, v]);
            let mut uses = vec![(a, false), (b, false), (a, true), (b, true)];
            if !piece.same_sense {
                uses = uses.into_iter().rev().map(|(e, r)| (e, !r)).collect();
            }
            Some(DraftFace { loops: vec![uses], ..DraftFace::default() })
        }
        _ => None,
    }
}
