//! What is zero where a relation holds, with its derivatives by the unknowns of the surfaces.

use super::contact::contact;
use crate::cad::adjust::{Body, Condition, direction};
use crate::cad::tuning::NEWTON_STEPS;
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
