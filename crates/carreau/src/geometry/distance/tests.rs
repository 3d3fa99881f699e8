//! Distances of surfaces that are known.

use super::*;
use crate::mesh::test_models::*;
use glam::DVec3;
use proptest::prelude::*;

fn options() -> DistanceOptions {
    DistanceOptions { samples: 5000, refinements: 20_000, normals: true }
}

fn compared(a: &SurfaceMesh, b: &SurfaceMesh) -> Comparison {
    compare(a, b, &options(), &Context::new()).unwrap()
}

fn brackets(d: &Distance, truth: f64, tolerance: f64) -> bool {
    d.max <= truth + 1e-12 && truth <= d.max_upper + 1e-12 && d.max_upper - d.max <= tolerance
}

#[test]
fn a_surface_is_at_no_distance_from_itself_however_it_is_cut() {
    let mesh = torus(40, 20);
    let c = compared(&mesh, &mesh);
    assert!(c.distance.max_upper < 1e-9 && c.normal_deg.unwrap().max < 1e-6, "{c:?}");
    let quads = cube(DVec3::ZERO, 2.0);
    let fine = together(&[quads.clone().triangulated().unwrap()]);
    let c = compared(&quads, &fine);
    assert!(c.distance.max_upper < 1e-9 && c.normal_deg.unwrap().max < 1e-6, "{c:?}");
}

#[test]
fn concentric_spheres_are_as_far_apart_as_their_radii() {
    let (inner, outer) = (sphere(4), moved(&sphere(4), |p| 1.25 * p));
    let c = compared(&inner, &outer);
    assert!((c.distance.mean - 0.25).abs() < 0.002 && (c.distance.rms - 0.25).abs() < 0.002);
    assert!((c.distance.rms..0.2525).contains(&c.distance.rms_upper), "{c:?}");
    assert!(c.distance.max <= 0.2501 && c.distance.max_upper - c.distance.max < 1e-4);
    assert!((c.relative.mean - c.distance.mean / c.diagonal).abs() < 1e-15);
    assert!(c.normal_deg.unwrap().p95 < 5.0);
}

#[test]
fn the_maximum_is_found_between_the_vertices() {
    // A square of two triangles and a pyramid over its diagonal's middle, which is a vertex of neither.
    let flat = grid(1);
    let p = [(0., 0., 0.), (1., 0., 0.), (1., 1., 0.), (0., 1., 0.), (0.5, 0.5, 0.3)].map(DVec3::from);
    let roof = triangles(&p, &[[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]);
    let coarse = DistanceOptions { samples: 10, ..options() };
    let c = compare(&flat, &roof, &coarse, &Context::new()).unwrap();
    // From the middle of the square to the faces of the pyramid.
    let to_roof = 0.3 * 0.5 / f64::hypot(0.3, 0.5);
    assert!(brackets(&c.a_to_b.distance, to_roof, 1e-4), "{c:?}");
    assert!(brackets(&c.b_to_a.distance, 0.3, 1e-4), "{c:?}");
    let at = DVec3::from_array(c.a_to_b.max_at);
    assert!(at.distance(DVec3::new(0.5, 0.5, 0.0)) < 0.02, "{at}");
}

#[test]
fn without_refinement_the_bounds_still_hold() {
    let (a, b) = (sphere(1), sphere(3));
    let exact = compared(&a, &b).distance;
    let rough = compare(&a, &b, &DistanceOptions { samples: 50, refinements: 0, ..options() }, &Context::new())
        .unwrap()
        .distance;
    assert!(rough.max <= exact.max_upper && rough.max_upper >= exact.max);
    assert!(rough.max_upper - rough.max > exact.max_upper - exact.max);
}

#[test]
fn a_missing_part_shows_in_one_direction_only() {
    let whole = grid(8);
    let half = without(&whole, &(64..128).collect::<Vec<_>>());
    let c = compared(&whole, &half);
    assert!(brackets(&c.a_to_b.distance, 4.0, 1e-3), "{c:?}");
    assert!(c.b_to_a.distance.max_upper < 1e-9);
    assert!((c.a_to_b.distance.mean - 1.0).abs() < 0.01);
}

#[test]
fn samples_follow_the_area() {
    let mesh = together(&[moved(&grid(1), |p| p * 3.0), grid(4)]);
    let (samples, _) = spread_samples(&Target::new(&mesh), 10_000);
    let on_first = samples.iter().filter(|s| s.triangle < 2).count();
    assert_eq!(samples.len(), 10_000);
    assert!((on_first as f64 / 10_000.0 - 9.0 / 25.0).abs() < 1e-3);
    let mean = samples.iter().filter(|s| s.triangle < 2).map(|s| s.point).sum::<DVec3>() / on_first as f64;
    assert!(mean.distance(DVec3::new(1.5, 1.5, 0.0)) < 0.02);
}

#[test]
fn inverted_normals_differ_by_a_half_turn() {
    let c = compared(&sphere(2), &turned(&sphere(2), |_| true));
    assert!(c.distance.max < 1e-9 && c.normal_deg.unwrap().p50 > 179.0);
}

#[test]
fn the_result_does_not_depend_on_the_number_of_threads() {
    let (a, b) = (torus(30, 17), moved(&torus(33, 15), |p| p * 1.01));
    let with = |threads| compare(&a, &b, &options(), &Context::new().with_threads(threads).unwrap()).unwrap();
    assert_eq!(with(1), with(3));
}

#[test]
fn surfaces_without_faces_or_area_are_no_trouble() {
    let empty = triangles(&[DVec3::ZERO], &[]);
    assert!(matches!(compare(&empty, &grid(1), &options(), &Context::new()), Err(Error::Input { .. })));
    let point = triangles(&[DVec3::Z; 3], &[[0, 1, 2]]);
    let c = compared(&point, &point);
    assert_eq!((c.distance.max_upper, c.relative.max, c.normal_deg), (0.0, 0.0, None));
    let far = compared(&point, &grid(1));
    assert!(brackets(&far.a_to_b.distance, 1.0, 1e-9));
    assert!(brackets(&far.b_to_a.distance, 3f64.sqrt(), 1e-4));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]
    #[test]
    fn motions_do_not_change_distances(axis in prop::array::uniform3(-1.0f64..1.0), angle in 0.0f64..6.0, shift in -9.0f64..9.0) {
        let axis = DVec3::from_array(axis);
        prop_assume!(axis.length() > 0.1);
        let turn = glam::DQuat::from_axis_angle(axis.normalize(), angle);
        let motion = |p: DVec3| turn * p + DVec3::splat(shift);
        let (a, b) = (torus(24, 12), moved(&torus(20, 10), |p| p * 1.02 + DVec3::X * 0.1));
        let before = compared(&a, &b);
        let after = compared(&moved(&a, motion), &moved(&b, motion));
        for (x, y) in [(before.a_to_b.distance, after.a_to_b.distance), (before.b_to_a.distance, after.b_to_a.distance)] {
            // A sample on the border of two shares of the area may change sides.
            prop_assert!((x.mean - y.mean).abs() < 1e-5 && (x.rms - y.rms).abs() < 1e-5);
            // Rounding may change which triangles are divided, but both brackets hold the same number.
            prop_assert!(x.max <= y.max_upper + 1e-9 && y.max <= x.max_upper + 1e-9);
        }
    }
}
