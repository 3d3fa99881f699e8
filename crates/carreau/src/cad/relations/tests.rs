//! Surfaces that miss each other by the noise of their fits, and what they are after the adjustment.

use super::conditions::{Radius, apart, coaxial, concurring, parallel, perpendicular, radius, same_radius, touching};
use super::values::round_values;
use super::*;
use crate::geometry::primitive::Primitive;
use glam::DVec3;
use proptest::prelude::*;

/// Points of a patch, a number of them along both parameters.
fn patch(at: impl Fn(f64, f64) -> DVec3) -> Vec<DVec3> {
    (0..60).map(|k| at(f64::from(k % 10) / 9.0, f64::from(k / 10) / 5.0)).collect()
}

/// A fillet of radius .1 along z between the planes y = 0 and x = 0, and a lid z = 0, each off by something.
fn corner(off: [f64; 6]) -> Vec<Body> {
    let unit = |v: DVec3| v.normalize();
    let arc = |a: f64| DVec3::new(0.1 - 0.1 * a.cos(), 0.1 - 0.1 * a.sin(), 0.0);
    let quarter = std::f64::consts::FRAC_PI_2;
    vec![
        Body::new(
            Primitive::Plane { origin: DVec3::Y * off[0], normal: unit(DVec3::new(off[1], -1.0, 0.0)) },
            patch(|u, v| DVec3::new(0.1 + 0.5 * u, 0.0, 0.5 * v)),
            1e-4,
        ),
        Body::new(
            Primitive::Plane { origin: DVec3::X * off[2], normal: unit(DVec3::new(-1.0, 0.0, off[3])) },
            patch(|u, v| DVec3::new(0.0, 0.1 + 0.5 * u, 0.5 * v)),
            1e-4,
        ),
        Body::new(
            Primitive::Cylinder {
                origin: DVec3::new(0.1, 0.1 + off[4], 0.0),
                axis: unit(DVec3::new(off[3], off[1], 1.0)),
                radius: 0.1 + off[5],
            },
            patch(|u, v| arc(quarter * u) + DVec3::Z * 0.5 * v),
            1e-3,
        ),
        Body::new(
            Primitive::Plane { origin: DVec3::ZERO, normal: unit(DVec3::new(off[5], off[4], -1.0)) },
            patch(|u, v| DVec3::new(0.1 + 0.5 * u, 0.1 + 0.5 * v, 0.0)),
            1e-4,
        ),
        // The fillet goes on behind a gap, and the first plane has another one opposite.
        Body::new(
            Primitive::Cylinder {
                origin: DVec3::new(0.1 + off[0], 0.1, 0.8),
                axis: unit(DVec3::new(off[1], -off[3], 1.0)),
                radius: 0.1 + off[2],
            },
            patch(|u, v| arc(quarter * u) + DVec3::Z * (0.8 + 0.5 * v)),
            1e-3,
        ),
        Body::new(
            Primitive::Plane { origin: DVec3::Y * (0.7 + off[4]), normal: unit(DVec3::new(off[5], 1.0, off[0])) },
            patch(|u, v| DVec3::new(0.1 + 0.5 * u, 0.7, 0.5 * v)),
            1e-4,
        ),
    ]
}

fn relations() -> Vec<Relation> {
    let places = |x: f64, y: f64| (0..8).map(|k| DVec3::new(x, y, 0.06 * f64::from(k))).collect();
    vec![
        Relation::Touch { bodies: [0, 2], places: places(0.1, 0.0) },
        Relation::Touch { bodies: [1, 2], places: places(0.0, 0.1) },
        Relation::Parallel([2, 3]),
        Relation::Perpendicular([0, 1]),
        Relation::Perpendicular([0, 3]),
        Relation::Coaxial([2, 4]),
        Relation::Parallel([2, 4]),
        Relation::SameRadius([2, 4]),
        Relation::Radius { body: [4], which: Radius::Only, value: 0.1 },
        Relation::Parallel([0, 5]),
        Relation::Apart { bodies: [0, 5], value: -0.7 },
    ]
}

proptest! {
    #[test]
    fn surfaces_that_touch_do_so_exactly_after_the_adjustment(off in prop::array::uniform6(-2e-3f64..2e-3)) {
        let mut bodies = corner(off);
        let held = relations();
        let all = |b: &[Body]| held.iter().flat_map(|r| r.conditions(b)).collect::<Vec<_>>();
        prop_assert!(adjust(&mut bodies, all, &Context::new()).unwrap().is_some());
        let (Primitive::Plane { origin, normal }, Primitive::Cylinder { origin: o, axis, radius }) =
            (bodies[0].primitive, bodies[2].primitive) else { unreachable!() };
        // The axis is parallel to the plane and its radius away from it.
        prop_assert!(axis.dot(normal).abs() < 1e-9);
        prop_assert!((normal.dot(o - origin).abs() - radius).abs() < 1e-11);
        // The points say where the surfaces are: nothing else is known of them.
        prop_assert!((radius - 0.1).abs() < 1e-6, "{radius}");
        prop_assert!(bodies.iter().all(|b| b.residuals()[1] < 1e-6));
        prop_assert!(held.iter().all(|r| r.off(&bodies) < 1e-9));
        // One line, one radius, a round distance.
        let (Primitive::Cylinder { origin: p, radius: other, .. }, Primitive::Plane { origin: q, .. }) =
            (bodies[4].primitive, bodies[5].primitive) else { unreachable!() };
        prop_assert!((p - o).reject_from(axis).length() < 1e-9 && (other - 0.1).abs() < 1e-11);
        prop_assert!((normal.dot(q - origin).abs() - 0.7).abs() < 1e-11);
    }

    #[test]
    fn values_that_are_round_are_found_in_noise(off in prop::array::uniform6(-2e-4f64..2e-4)) {
        // A length of one is 10 in the file: the radius is 1, the planes are 7 apart.
        let mut bodies = corner(off);
        bodies[2].sigma = 1e-3;
        let parallel = Claim { relation: Relation::Parallel([0, 5]), bound: 1e-2 };
        let values = round_values(&bodies, &[parallel], 10.0);
        for claim in values {
            match claim.relation {
                Relation::Radius { value, .. } => prop_assert!((value - 0.1).abs() < 1e-12),
                Relation::Apart { value, .. } => prop_assert!((value + 0.7).abs() < 1e-12),
                other => prop_assert!(false, "{other:?}"),
            }
        }
    }

    #[test]
    fn derivatives_of_conditions_are_those_of_their_values(off in prop::array::uniform6(-2e-3f64..2e-3), k in 0usize..8) {
        let bodies = corner(off);
        let place = DVec3::new(0.0, 0.0, 0.0);
        let all = |b: &[Body]| {
            let mut out = vec![
                touching(b, [0, 2], DVec3::new(0.1, 0.0, 0.2)),
                concurring(b, [0, 1, 3, 2], place),
            ];
            out.extend(parallel(b, [2, 3]));
            out.extend(perpendicular(b, [0, 1]));
            out.extend(coaxial(b, [2, 4]));
            out.extend(same_radius(b, [2, 4]));
            out.push(radius(b, (4, Radius::Only), 0.1));
            out.extend(apart(b, [0, 5], -0.7));
            out
        };
        let before = all(&bodies);
        let h = 1e-6;
        for body in 0..bodies.len() {
            let mut step = [0.0; 8];
            step[k] = h;
            let moved = |sign: f64| {
                let mut other = bodies.clone();
                other[body].primitive = bodies[body].moved(&step.map(|x| sign * x)).unwrap();
                all(&other)
            };
            let (ahead, behind) = (moved(1.0), moved(-1.0));
            for ((c, x), y) in before.iter().zip(&ahead).zip(&behind) {
                let told: f64 = c.by.iter().filter(|t| t.0 as usize == body).map(|t| t.1[k]).sum();
                let measured = (x.value - y.value) / (2.0 * h);
                // Directions across another one turn with it, which changes nothing where both are parallel.
                prop_assert!((told - measured).abs() < 2e-2, "body {body} unknown {k}: {told} {measured}");
            }
        }
    }
}
