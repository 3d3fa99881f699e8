//! What is zero where a relation holds, with its derivatives by the unknowns of the surfaces.

use super::contact::contact;
use crate::cad::adjust::{Body, Condition, Row, direction};
use crate::cad::tuning::NEWTON_STEPS;
use crate::geometry::primitive::Primitive;
use glam::{DMat3, DVec3};

/// At a place of a border: both surfaces are equally far from the point of contact.
pub fn touching(all: &[Body], bodies: [u32; 2], at: DVec3) -> Condition {
    let [a, b] = bodies.map(|k| &all[k as usize]);
    let at = contact(&a.primitive, &b.primitive, at).unwrap_or(at);
    let sign = a.primitive.normal(at).dot(b.primitive.normal(at)).signum();
    let ((x, by_a), (y, by_b)) = (a.distance(at), b.distance(at));
    Condition { value: x - sign * y, by: vec![(bodies[0], by_a), (bodies[1], by_b.map(|d| -sign * d))] }
}

/// The distance of the fourth surface from the point where the first three meet, which moves with them.
pub fn concurring(all: &[Body], bodies: [u32; 4], place: DVec3) -> Condition {
    let of = |k: usize| &all[bodies[k] as usize];
    let base =
        |p: DVec3| DMat3::from_cols_array_2d(&[0, 1, 2].map(|k| of(k).primitive.normal(p).to_array())).transpose();
    let mut p = place;
    for _ in 0..NEWTON_STEPS {
        let far = DVec3::from([0, 1, 2].map(|k| of(k).primitive.distance(p)));
        let step = base(p).inverse() * far;
        if !(step.length() < 1.0) {
            break;
        }
        p -= step;
        if step.length() < 1e-15 {
            break;
        }
    }
    let (value, row) = of(3).distance(p);
    // n₃ · dp, where the other three distances stay zero.
    let by = base(p).transpose().inverse() * of(3).primitive.normal(p);
    let others = (0..3).map(|k| (bodies[k], of(k).distance(p).1.map(|x| -by[k] * x)));
    Condition { value, by: others.chain([(bodies[3], row)]).collect() }
}

/// Two directions are parallel: the second has no part across the first.
pub fn parallel(all: &[Body], bodies: [u32; 2]) -> Vec<Condition> {
    let [a, b] = bodies.map(|k| &all[k as usize]);
    let (Some(d), Some(e)) = (direction(&a.primitive), direction(&b.primitive)) else { return Vec::new() };
    let (x, y) = d.any_orthonormal_pair();
    let one = |across: DVec3| Condition {
        value: e.dot(across),
        by: vec![(bodies[0], a.turned(across.cross(e))), (bodies[1], b.turned(e.cross(across)))],
    };
    vec![one(x), one(y)]
}

/// Two directions are perpendicular.
pub fn perpendicular(all: &[Body], bodies: [u32; 2]) -> Vec<Condition> {
    let [a, b] = bodies.map(|k| &all[k as usize]);
    let (Some(d), Some(e)) = (direction(&a.primitive), direction(&b.primitive)) else { return Vec::new() };
    let by = vec![(bodies[0], a.turned(d.cross(e))), (bodies[1], b.turned(e.cross(d)))];
    vec![Condition { value: d.dot(e), by }]
}

/// Two axes are on one line: no part of what is between them is across the first.
pub fn coaxial(all: &[Body], bodies: [u32; 2]) -> Vec<Condition> {
    let [a, b] = bodies.map(|k| &all[k as usize]);
    let (Some((o, d)), Some((p, e))) = (axis(&a.primitive), axis(&b.primitive)) else { return Vec::new() };
    let far = p + e * e.dot(b.middle() - p);
    let near = o + d * d.dot(far - o);
    let (x, y) = d.any_orthonormal_pair();
    let one = |across: DVec3| Condition {
        value: across.dot(far - near),
        by: vec![(bodies[0], a.carried(near, -across)), (bodies[1], b.carried(far, across))],
    };
    vec![one(x), one(y)]
}

/// A radius has a value; or it is that of another surface.
pub fn radius(all: &[Body], (body, which): (u32, Radius), value: f64) -> Condition {
    let of = which.of(&all[body as usize].primitive).unwrap_or(value);
    Condition { value: of - value, by: vec![(body, which.row(1.0))] }
}

/// Two surfaces have the same radius.
pub fn same_radius(all: &[Body], bodies: [u32; 2]) -> Vec<Condition> {
    let of = |k: usize| Radius::Only.of(&all[bodies[k] as usize].primitive);
    let (Some(a), Some(b)) = (of(0), of(1)) else { return Vec::new() };
    vec![Condition { value: a - b, by: vec![(bodies[0], Radius::Only.row(1.0)), (bodies[1], Radius::Only.row(-1.0))] }]
}

/// Two parallel planes are so far apart, along the normal of the first.
pub fn apart(all: &[Body], bodies: [u32; 2], value: f64) -> Vec<Condition> {
    let [a, b] = bodies.map(|k| &all[k as usize]);
    let (Primitive::Plane { origin: o, normal: n }, Primitive::Plane { origin: p, normal: m }) =
        (a.primitive, b.primitive)
    else {
        return Vec::new();
    };
    let [foot, far] = [(o, n, a), (p, m, b)].map(|(o, n, body)| body.middle() + n * n.dot(o - body.middle()));
    let turned = a.turned(n.cross(far - foot));
    let [x, y, z, ..] = a.carried(foot, -n);
    let [.., u, v, w, _, _] = turned;
    vec![Condition {
        value: n.dot(far - foot) - value,
        by: vec![(bodies[0], [x, y, z, u, v, w, 0.0, 0.0]), (bodies[1], b.carried(far, n))],
    }]
}

/// A point and the direction of the axis of what is round.
pub fn axis(primitive: &Primitive) -> Option<(DVec3, DVec3)> {
    match *primitive {
        Primitive::Cylinder { origin, axis, .. } => Some((origin, axis)),
        Primitive::Cone { apex, axis, .. } => Some((apex, axis)),
        Primitive::Torus { center, axis, .. } => Some((center, axis)),
        Primitive::Plane { .. } | Primitive::Sphere { .. } => None,
    }
}

/// One of the radii of a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Radius {
    /// Of a sphere or a cylinder.
    Only,
    /// Around the axis of a torus.
    Major,
    /// Of the tube of a torus.
    Minor,
}

impl Radius {
    pub const ALL: [Radius; 3] = [Radius::Only, Radius::Major, Radius::Minor];

    /// What it is.
    pub fn of(self, primitive: &Primitive) -> Option<f64> {
        match (self, *primitive) {
            (Radius::Only, Primitive::Sphere { radius, .. } | Primitive::Cylinder { radius, .. }) => Some(radius),
            (Radius::Major, Primitive::Torus { major_radius, .. }) => Some(major_radius),
            (Radius::Minor, Primitive::Torus { minor_radius, .. }) => Some(minor_radius),
            _ => None,
        }
    }

    /// Derivatives of so many times it.
    pub fn row(self, times: f64) -> Row {
        match self {
            Radius::Only | Radius::Major => [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, times, 0.0],
            Radius::Minor => [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, times],
        }
    }
}
