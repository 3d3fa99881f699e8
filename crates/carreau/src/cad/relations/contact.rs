//! Where two surfaces touch.

use crate::cad::regions::Piece;
use crate::cad::tuning::FILE;
use crate::geometry::primitive::Primitive;
use glam::DVec3;

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
    reach(&p, &q, a.max.max(b.max).max(FILE * diagonal))
}

/// The point near `p` between two surfaces at which their normals agree across a direction.
pub fn contact(a: &Primitive, b: &Primitive, p: DVec3, along: DVec3) -> Option<DVec3> {
    let sign = a.normal(p).dot(b.normal(p)).signum();
    let between = |p: DVec3| p - 0.5 * (a.normal(p) * a.distance(p) + b.normal(p) * b.distance(p));
    let mut p = (0..3).fold(p, |p, _| between(p));
    let across = a.normal(p).cross(along).normalize_or_zero();
    if across == DVec3::ZERO {
        return None;
    }
    let turn = |q: DVec3| (b.normal(q) * sign - a.normal(q)).dot(across);
    let h = 1e-5;
    for _ in 0..20 {
        let f = turn(p);
        let slope = (turn(p + across * h) - turn(p - across * h)) / (2.0 * h);
        let step = -f / slope;
        if !(step.abs() < 1.0) {
            return None;
        }
        p = between(p + across * step);
        if step.abs() < 1e-14 {
            break;
        }
    }
    p.is_finite().then_some(p)
}
