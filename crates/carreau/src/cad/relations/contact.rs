//! Where two surfaces touch.

use crate::cad::regions::Piece;
use crate::cad::tuning::{FILE_PRECISION, NEWTON_STEPS};
use crate::geometry::primitive::Primitive;
use glam::DVec3;
use std::f64::consts::FRAC_PI_2;

/// A share of the diagonal: distance of the points whose normals give how surfaces bend, because differences over less
/// lose their digits.
const DIFFERENCE_WIDTH: f64 = 1e-5;
/// A share of the largest: squared bends below are none, because a step along them would go far away.
const FLAT_BEND: f64 = 1e-2;

/// How far from their contact two surfaces are nearer to each other than `off`, twice over: x² / 2R there.
pub fn reach(a: &Primitive, b: &Primitive, off: f64) -> f64 {
    let radius = |p: &Primitive| match *p {
        Primitive::Plane { .. } | Primitive::Cone { .. } => f64::INFINITY,
        Primitive::Sphere { radius, .. } | Primitive::Cylinder { radius, .. } => radius,
        Primitive::Torus { minor_radius, .. } => minor_radius,
    };
    let smallest = radius(a).min(radius(b));
    2.0 * (2.0 * off * if smallest.is_finite() { smallest } else { 1.0 }).sqrt()
}

/// How far a border may be from the curve along which its two pieces touch.
pub fn room(a: &Piece, b: &Piece, diagonal: f64) -> f64 {
    let (Some(p), Some(q)) = (a.primitive, b.primitive) else { return 0.0 };
    reach(&p, &q, a.max.max(b.max).max(FILE_PRECISION * diagonal))
}

/// The point near `p` between two surfaces at which their normals agree: sought in the directions in which they bend against each
/// other, so that it is anywhere on a curve of contact.
pub fn contact(a: &Primitive, b: &Primitive, p: DVec3) -> Option<DVec3> {
    let sign = a.normal(p).dot(b.normal(p)).signum();
    let between = |p: DVec3| p - 0.5 * (a.normal(p) * a.distance(p) + b.normal(p) * b.distance(p));
    let apart = |p: DVec3| b.normal(p) * sign - a.normal(p);
    let mut p = (0..3).fold(p, |p, _| between(p));
    for _ in 0..NEWTON_STEPS {
        let (x, y) = a.normal(p).try_normalize()?.any_orthonormal_pair();
        let [u, v] = [x, y]
            .map(|d| (apart(p + d * DIFFERENCE_WIDTH) - apart(p - d * DIFFERENCE_WIDTH)) / (2.0 * DIFFERENCE_WIDTH));
        // The step of least length to equal normals, along the eigenvectors of the bend against each other.
        let (uu, uv, vv) = (u.dot(u), u.dot(v), v.dot(v));
        let angle = 0.5 * (2.0 * uv).atan2(uu - vv);
        let mut step = DVec3::ZERO;
        let mut bends = [angle, angle + FRAC_PI_2].map(|t| (x * t.cos() + y * t.sin(), u * t.cos() + v * t.sin()));
        bends.sort_by(|a, b| b.1.length_squared().total_cmp(&a.1.length_squared()));
        let most = bends[0].1.length_squared();
        for (along, bend) in bends.into_iter().filter(|b| b.1.length_squared() > FLAT_BEND * most) {
            step -= along * (bend.dot(apart(p)) / bend.length_squared());
        }
        if !(step.length() < 1.0) {
            return None;
        }
        p = between(p + step);
        if step.length() < 1e-14 {
            break;
        }
    }
    p.is_finite().then_some(p)
}
