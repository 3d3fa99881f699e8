//! Curves of edges beside a spline surface: they are made before the surface, which then has to follow them.
//!
//! Two surfaces that touch meet nowhere exactly, and a fitted one is as far from its neighbour as it is from the mesh. So the
//! curve comes first, on the neighbour's surface through the vertices of the mesh, and its samples count as points of the fit.

use super::curves::{Track, straight};
use super::trace::upon;
use super::tuning::{NAMED_DISTANCE, TRACED_DISTANCE};
use crate::brep::{Curve, Frame, Surface};
use crate::numeric::eigen3::{Eigen3, outer};
use glam::{DMat3, DVec2, DVec3};

/// A count: fewest vertices that say circle, because three always lie on one, and four do by chance.
const CIRCLE_VERTICES: usize = 5;

/// The curve through a polyline, on a surface if there is one; a closed one repeats its first point.
pub fn border(on: Option<&Surface>, polyline: &[DVec3], closed: bool, diagonal: f64) -> Option<Track> {
    let named = NAMED_DISTANCE * diagonal;
    let is_on = |track: &Track| {
        let at = |k: i32| track.curve.point(track.range[0] + (track.range[1] - track.range[0]) * f64::from(k) / 16.0);
        on.is_none_or(|s| (0..=16).all(|k| s.distance(at(k)) <= named))
    };
    let named = [straight(polyline, named), circle(polyline, closed, named)];
    if let Some(track) = named.into_iter().flatten().find(is_on) {
        return Some(track);
    }
    let (spline, gap) = upon(on, polyline, TRACED_DISTANCE * diagonal)?;
    let range = spline.knots().domain();
    Some(Track { curve: Curve::Spline(spline), range, gap, away: 0.0 })
}

/// The circle that all vertices of a polyline lie on.
pub fn circle(polyline: &[DVec3], closed: bool, room: f64) -> Option<Track> {
    let distinct = polyline.len() - usize::from(closed);
    if distinct < CIRCLE_VERTICES {
        return None;
    }
    let mean = polyline.iter().sum::<DVec3>() / polyline.len() as f64;
    let spread = polyline.iter().map(|&p| outer(p - mean)).fold(DMat3::ZERO, |a, b| a + b);
    let frame = Frame::along(mean, Eigen3::new(spread).vectors[0]);
    let flat = |p: &DVec3| {
        let l = frame.local(*p);
        DVec2::new(l.x, l.y)
    };
    let (center, radius) = crate::geometry::primitive::circle(polyline.iter().map(flat))?;
    let origin = frame.global(center.extend(0.0));
    let curve = Curve::Circle { frame: Frame { origin, ..frame }, radius };
    let near = curve.is_sound() && polyline.iter().all(|&p| curve.distance(p) <= room);
    near.then(|| super::curves::follow(curve, polyline, closed)).flatten()
}
