//! The curve of every edge: with a name where the pair of surfaces has one, else a spline traced along the intersection.

use super::conics::candidates;
use super::regions::Piece;
use super::trace::{gap, signed, touch, trace};
use super::tuning::{BRANCH_DISTANCE, NAMED_DISTANCE, SAME_POINT, TRACED_DISTANCE};
use crate::brep::{Curve, Surface};
use crate::geometry::bspline::BSplineCurve;
use glam::DVec3;

/// A count: samples of a candidate between two points of the polyline, because it is to follow the border there and not
/// only at its points.
const SAMPLES_A_SIDE: usize = 3;
/// Sine of the smallest angle between surfaces that cross for which the border is looked for farther away, because at
/// flatter ones it could be anywhere.
const LEAST_CROSSING: f64 = 0.1;

/// A curve between two surfaces along a polyline of the mesh.
#[derive(Debug, Clone)]
pub struct Track {
    /// The curve, run in the sense of the polyline.
    pub curve: Curve,
    /// Parameters at both ends, increasing.
    pub range: [f64; 2],
    /// Largest distance from the surfaces.
    pub gap: f64,
    /// Largest distance of the polyline's vertices from it.
    pub away: f64,
}

/// How far the vertices of a polyline may be from their curve.
#[derive(Debug, Clone, Copy)]
pub struct Room {
    /// Where the surfaces cross.
    pub crossing: f64,
    /// Where they touch: the border of the regions is anywhere near the contact then.
    pub touching: f64,
}

/// The curve where two pieces meet along a polyline; a closed one repeats its first point.
pub fn between(a: &Piece, b: &Piece, polyline: &[DVec3], closed: bool, diagonal: f64, room: Room) -> Option<Track> {
    let named = NAMED_DISTANCE * diagonal;
    let mut best: Option<Track> = None;
    // The border of two regions is uncertain by the noise through the sine of the angle between their surfaces.
    let most = |track: &Track, crossing: f64| {
        let [low, high] = track.range;
        let samples: Vec<DVec3> = (0..=8).map(|k| track.curve.point(low + (high - low) * f64::from(k) / 8.0)).collect();
        let sine = |&p: &DVec3| signed(&a.surface, p).0.cross(signed(&b.surface, p).0).length();
        let least = samples.iter().map(sine).fold(1.0, f64::min).max(LEAST_CROSSING);
        let touching = if touch(&a.surface, &b.surface, &samples) { room.touching } else { 0.0 };
        (crossing / least).max(touching)
    };
    if let (Some(p), Some(q)) = (&a.primitive, &b.primitive) {
        for curve in candidates(p, q, polyline) {
            let Some(track) = follow(curve, polyline, closed) else { continue };
            let track = measured(track, &a.surface, &b.surface, polyline.len());
            // Surfaces that touch but for rounding also cross far from there: of exact curves, the one along the vertices.
            let is_better = |than: &Track| {
                let [own, other] = [track.gap, than.gap].map(|g| g.max(named));
                2.0 * own < other || (own == other && track.away < than.away)
            };
            if track.away <= most(&track, room.crossing) && best.as_ref().is_none_or(is_better) {
                best = Some(track);
            }
        }
        if best.as_ref().is_some_and(|b| b.gap <= named) {
            return best;
        }
    }
    let cut = cut_profile(&a.surface, &b.surface).or_else(|| cut_profile(&b.surface, &a.surface));
    if let Some(track) = cut.and_then(|curve| follow(curve, polyline, closed)).and_then(clipped) {
        let track = measured(track, &a.surface, &b.surface, polyline.len());
        if track.gap <= named && track.away <= most(&track, room.crossing) {
            return Some(track);
        }
    }
    // A generator of a swept surface.
    if let Some(line) = straight(polyline, named) {
        let line = measured(line, &a.surface, &b.surface, polyline.len());
        if line.gap <= named {
            return Some(line);
        }
    }
    let (spline, gap) = trace(&a.surface, &b.surface, polyline, TRACED_DISTANCE * diagonal)?;
    let range = spline.knots().domain();
    let curve = Curve::Spline(spline);
    let away = polyline.iter().map(|&p| curve.distance(p)).fold(0.0, f64::max);
    let traced = Track { curve, range, gap, away };
    let good = traced.away <= most(&traced, room.crossing.max(BRANCH_DISTANCE * diagonal));
    match best {
        Some(best) if best.gap <= traced.gap || !good => Some(best),
        _ => good.then_some(traced),
    }
}

/// The straight segment between the ends of a polyline, where that is what it is.
pub fn straight(polyline: &[DVec3], room: f64) -> Option<Track> {
    let (a, b) = (polyline[0], polyline[polyline.len() - 1]);
    if a == b {
        return None;
    }
    let (curve, range) = Curve::segment(a, b);
    let away = polyline.iter().map(|&p| curve.distance(p)).fold(0.0, f64::max);
    (away <= room).then_some(Track { curve, range, gap: 0.0, away })
}

/// The curve in which a plane cuts the extrusion of a spline: its profile, every point moved along the direction.
fn cut_profile(swept: &Surface, plane: &Surface) -> Option<Curve> {
    let (Surface::Extrusion { profile: Curve::Spline(profile), direction }, Surface::Plane { frame }) = (swept, plane)
    else {
        return None;
    };
    let across = frame.z.dot(*direction);
    if across.abs() < LEAST_CROSSING {
        return None;
    }
    let moved = |&p: &DVec3| p + frame.z.dot(frame.origin - p) / across * *direction;
    let points = profile.points().iter().map(moved).collect();
    BSplineCurve::new(profile.knots().clone(), points).ok().map(Curve::Spline)
}

/// A track on a spline with no more of it than the track needs; `None` where it goes on beyond its ends.
fn clipped(track: Track) -> Option<Track> {
    let [low, high] = track.curve.domain();
    let [from, to] = track.range;
    // A ring begins where the spline does.
    if to - from > (1.0 - SAME_POINT) * (high - low) {
        return Some(Track { range: [low, high], ..track });
    }
    let curve = part(&track.curve, track.range)?;
    Some(Track { curve, ..track })
}

/// The part of a curve in a range: of a spline no more than that. `None` where the range goes on beyond the ends.
pub fn part(curve: &Curve, [from, to]: [f64; 2]) -> Option<Curve> {
    let Curve::Spline(whole) = curve else { return Some(curve.clone()) };
    let [low, high] = whole.knots().domain();
    if from < low || to > high {
        return None;
    }
    let mut part = whole.clone();
    if to < high {
        [part, _] = part.split(to).ok()?;
    }
    if from > low {
        [_, part] = part.split(from).ok()?;
    }
    Some(Curve::Spline(part))
}

/// A curve in the sense of a polyline, with the range between its ends; `None` where the polyline does not run along it.
pub fn follow(curve: Curve, polyline: &[DVec3], closed: bool) -> Option<Track> {
    let start = curve.project(polyline[0]);
    let (mut t, mut away) = (start, 0.0f64);
    for &p in &polyline[1..] {
        t = curve.project_near(p, t);
        away = away.max(curve.point(t).distance(p));
    }
    away = away.max(curve.point(start).distance(polyline[0]));
    if !away.is_finite() {
        return None;
    }
    let (curve, mut range) = if t < start { curve.reversed([t, start]) } else { (curve, [start, t]) };
    if closed {
        let period = curve.period()?;
        if ((range[1] - range[0]) / period - 1.0).abs() > 0.01 {
            return None;
        }
        range[1] = range[0] + period;
    } else if curve.period().is_some_and(|p| range[1] - range[0] > p) || !(range[1] > range[0]) {
        return None;
    }
    Some(Track { curve, range, gap: 0.0, away })
}

fn measured(mut track: Track, a: &Surface, b: &Surface, points: usize) -> Track {
    let count = (SAMPLES_A_SIDE * points).clamp(8, 64);
    let [low, high] = track.range;
    let at = |k: usize| track.curve.point(low + (high - low) * k as f64 / count as f64);
    track.gap = (0..=count).map(|k| gap(a, b, at(k))).fold(0.0, f64::max);
    track
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::primitive::Primitive;
    use crate::mesh::{SurfaceMesh, Triangles};

    /// The end of a fillet: a sphere of the radius of its cylinder but for rounding touches it along a circle, and crosses it, if it
    /// is larger, in two circles far from there.
    #[test]
    fn surfaces_that_touch_but_for_rounding_meet_where_the_vertices_are() {
        let corners = vec![DVec3::X, DVec3::new(0.0, 1.0, 0.0), DVec3::Z];
        let mesh = SurfaceMesh::from_triangles(corners, &[[0, 1, 2]]).unwrap();
        let t = Triangles::of(&mesh).unwrap();
        let piece = |p: Primitive| Piece::on(t, vec![0], Surface::of_primitive(&p), Some(p), 0);
        let cylinder = piece(Primitive::Cylinder { origin: DVec3::ZERO, axis: DVec3::Z, radius: 1.0 });
        let polyline: Vec<DVec3> =
            (0..=6).map(|k| DVec3::new((0.2 * f64::from(k)).cos(), (0.2 * f64::from(k)).sin(), 0.0)).collect();
        for radius in [1.0 - 3e-8, 1.0 + 3e-8] {
            let sphere = piece(Primitive::Sphere { center: DVec3::ZERO, radius });
            let room = Room { crossing: 1e-3, touching: 1e-3 };
            let track = between(&cylinder, &sphere, &polyline, false, 2.0, room).unwrap();
            assert!(track.gap < 1e-7 && track.away < 1e-6, "{} {} for {radius}", track.gap, track.away);
        }
    }
}
