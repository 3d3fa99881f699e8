//! Curvatures of surfaces whose curvatures are known, and what must hold for any surface.

use super::*;
use crate::geometry::features::{FeatureOptions, feature_edges};
use crate::mesh::SurfaceMesh;
use crate::mesh::test_models::*;
use glam::DMat3;
use proptest::prelude::*;
use std::f64::consts::TAU;

fn of(mesh: &SurfaceMesh, options: &CurvatureOptions, context: &Context) -> Curvature {
    let features = feature_edges(mesh, &FeatureOptions { angle_deg: Some(40.0), ..FeatureOptions::default() }).unwrap();
    curvature(Triangles::of(mesh).unwrap(), &features.corners, options, context).unwrap()
}

fn with(mesh: &SurfaceMesh, estimator: Estimator) -> Curvature {
    of(mesh, &CurvatureOptions { estimator, radius: None }, &Context::new())
}

/// The estimators that are meant to be right.
const UNBIASED: [Estimator; 3] = [Estimator::Corrected, Estimator::NormalCycle1Ring, Estimator::NormalCycleBall];

/// A number in −1..1 that depends on two counters only.
fn noise(i: u32, j: u32) -> f64 {
    let bits = (u64::from(i) << 32 | u64::from(j)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let bits = (bits ^ (bits >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    ((bits >> 11) as f64) / (1u64 << 52) as f64 - 1.0
}

/// `n × m` cells over u, v in 0..1, closed in u, and in v where `closed`; vertices are moved at random by a quarter of a
/// cell, diagonals chosen at random. `at` maps to the surface.
fn irregular(n: u32, m: u32, closed: bool, at: impl Fn(f64, f64) -> DVec3) -> SurfaceMesh {
    let rows = if closed { m } else { m + 1 };
    let id = |i: u32, j: u32| (i % n) * rows + if closed { j % m } else { j };
    let mut points = Vec::new();
    for i in 0..n {
        for j in 0..rows {
            let shift = if closed || (j > 0 && j < m) { 0.25 * noise(i, 3 * j + 1) } else { 0.0 };
            points.push(at(
                (f64::from(i) + 0.25 * noise(i, 3 * j)) / f64::from(n),
                (f64::from(j) + shift) / f64::from(m),
            ));
        }
    }
    let mut faces = Vec::new();
    for i in 0..n {
        for j in 0..m {
            let (a, b, c, d) = (id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1));
            faces.extend(if noise(i, 3 * j + 2) > 0.0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
        }
    }
    triangles(&points, &faces)
}

fn on_torus(u: f64, v: f64) -> DVec3 {
    let (a, b) = (TAU * u, TAU * v);
    let r = 1.0 + 0.4 * b.cos();
    DVec3::new(r * a.cos(), r * a.sin(), 0.4 * b.sin())
}

fn on_cylinder(u: f64, v: f64) -> DVec3 {
    let a = TAU * u;
    DVec3::new(a.cos(), a.sin(), 2.0 * v)
}

fn percentile(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values[((values.len() - 1) as f64 * share) as usize]
}

/// Angle between two lines in degrees; 90 for a null vector.
fn line_angle(a: DVec3, b: DVec3) -> f64 {
    if a == DVec3::ZERO { 90.0 } else { a.cross(b).length().atan2(a.dot(b).abs()).to_degrees() }
}

#[test]
fn spheres_curve_alike_everywhere() {
    let mesh = moved(&sphere(4), |p| 2.0 * p + DVec3::new(10.0, 20.0, -5.0));
    for estimator in UNBIASED {
        for (surface, truth) in [(mesh.clone(), 0.5), (turned(&mesh, |_| true), -0.5)] {
            let k = with(&surface, estimator);
            for v in 0..surface.vertex_count() {
                let error = (k.kmin[v] / truth - 1.0).abs().max((k.kmax[v] / truth - 1.0).abs());
                assert!(
                    error < if estimator == Estimator::NormalCycle1Ring { 0.15 } else { 0.03 },
                    "{estimator:?}: {error}"
                );
                assert!(k.kmin[v] <= k.kmax[v] && !k.border[v]);
            }
            let area: f64 = k.area.iter().sum();
            assert!((area / (4.0 * TAU * 2.0) - 1.0).abs() < 0.01);
        }
    }
}

#[test]
fn irregular_tori_and_cylinders_have_their_curvatures_and_directions() {
    let torus = irregular(120, 48, true, on_torus);
    let cylinder = irregular(100, 40, false, on_cylinder);
    // Largest median and 95th percentile of the relative error of kmax, and 95th percentile of the angle.
    for (estimator, bounds) in
        [(Estimator::Corrected, [0.015, 0.055, 2.5]), (Estimator::NormalCycleBall, [0.012, 0.035, 1.2])]
    {
        for (mesh, radius) in [(&torus, 0.4), (&cylinder, 1.0)] {
            let k = with(mesh, estimator);
            let is_torus = radius == 0.4;
            let inner: Vec<usize> =
                (0..mesh.vertex_count()).filter(|&v| is_torus || (0.4..1.6).contains(&mesh.points()[v].z)).collect();
            let along = |v: usize| {
                let p = mesh.points()[v];
                if is_torus { DVec3::new(-p.y, p.x, 0.0).normalize() } else { DVec3::Z }
            };
            let error: Vec<f64> = inner.iter().map(|&v| (k.kmax[v] * radius - 1.0).abs()).collect();
            let angle: Vec<f64> = inner.iter().map(|&v| line_angle(k.dmin[v], along(v))).collect();
            assert!(percentile(error.clone(), 0.5) < bounds[0], "{estimator:?} {}", percentile(error, 0.5));
            assert!(percentile(error.clone(), 0.95) < bounds[1], "{estimator:?} {}", percentile(error, 0.95));
            assert!(percentile(angle.clone(), 0.95) < bounds[2], "{estimator:?} {}", percentile(angle, 0.95));
            for &v in &inner {
                assert!(k.dmin[v].dot(k.dmax[v]).abs() < 1e-12 && (k.dmax[v].length() - 1.0).abs() < 1e-12);
            }
        }
    }
}

#[test]
fn mepp_is_a_third_too_small() {
    let mesh = irregular(120, 48, true, on_torus);
    let (mepp, ring) = (with(&mesh, Estimator::Mepp), with(&mesh, Estimator::NormalCycle1Ring));
    assert!((0..mesh.vertex_count()).all(|v| (1.5 * mepp.kmax[v] - ring.kmax[v]).abs() < 1e-9 * ring.kmax[v].abs()));
    let median = percentile(mepp.kmax.iter().map(|k| 0.4 * k - 1.0).collect(), 0.5);
    assert!((-0.35..-0.31).contains(&median), "{median}");
}

#[test]
fn saddles_have_curvatures_of_both_signs() {
    // z = (x² − y²) / 2 at the origin: −1 along x (concave seen from above), 1 along y.
    let mesh = moved(&grid(40), |p| {
        let (x, y) = (0.02 * (p.x - 20.0), 0.02 * (p.y - 20.0));
        DVec3::new(x, y, 0.5 * (x * x - y * y))
    });
    let centre = mesh.points().iter().position(|p| p.length() < 1e-9).unwrap();
    for estimator in [Estimator::Corrected, Estimator::NormalCycleBall] {
        let k = with(&mesh, estimator);
        assert!((k.kmin[centre] + 1.0).abs() < 0.03 && (k.kmax[centre] - 1.0).abs() < 0.03, "{estimator:?}");
        assert!(line_angle(k.dmin[centre], DVec3::X) < 2.0 && line_angle(k.dmax[centre], DVec3::Y) < 2.0);
    }
}

#[test]
fn nothing_leaks_over_creases() {
    let cubes = cube(DVec3::ZERO, 1.0).triangulated().unwrap();
    for estimator in UNBIASED {
        let k = with(&cubes, estimator);
        assert!(k.kmin.iter().chain(&k.kmax).all(|k| k.abs() < 1e-12), "{estimator:?}");
    }
    // But MEPP's tensor, and the full one, see the creases.
    assert!(with(&cubes, Estimator::Mepp).kmax.iter().all(|&k| k > 0.1));
}

#[test]
fn full_tensors_see_creases() {
    // A roof of right angle: the crease runs along y; its tensor is β l / area.
    let points: Vec<DVec3> =
        (0..15).map(|k| [f64::from(k % 3) - 1.0, f64::from(k / 3)]).map(|[x, y]| DVec3::new(x, y, -x.abs())).collect();
    let cell = |k: u32| [[k, k + 1, k + 4], [k, k + 4, k + 3]];
    let faces: Vec<[u32; 3]> = (0..12).filter(|k| k % 3 < 2).flat_map(cell).collect();
    let mesh = triangles(&points, &faces);
    let full = full_magnitudes(Triangles::of(&mesh).unwrap(), &[], &Context::new()).unwrap();
    // Vertex 7 is inside the crease: two edges of length 1, six faces of area √2/2.
    let expected = (TAU / 4.0) / (6.0 * 0.5f64.sqrt() / 3.0);
    assert!((full[7][0] - expected).abs() < 1e-12 && full[7][1].abs() < 1e-12, "{:?}", full[7]);
    let mut wanted = vec![false; 15];
    wanted[7] = true;
    let some = full_magnitudes(Triangles::of(&mesh).unwrap(), &wanted, &Context::new()).unwrap();
    assert_eq!((some[7], some[4]), (full[7], [0.0; 2]));
}

#[test]
fn each_side_of_a_crease_has_its_own_curvature() {
    // A closed cylinder: its rim is the mean of wall and lid, the rest of the lid is flat, of the wall 1.
    let mut wall = irregular(64, 12, false, on_cylinder);
    let (mut points, mut faces) = (wall.points().to_vec(), wall.faces().clone());
    points.push(DVec3::ZERO);
    (0..64u32).for_each(|i| faces.push(&[points.len() as u32 - 1, (i + 1) % 64 * 13, i * 13]));
    wall = SurfaceMesh::new(points, faces).unwrap();
    let k = with(&wall, Estimator::Corrected);
    let lid = wall.vertex_count() - 1;
    assert!(k.kmax[lid].abs() < 1e-9 && k.kmin[lid].abs() < 1e-9);
    for i in 0..64 {
        let rim = 13 * i;
        assert!(!k.border[rim] && k.border[rim + 12]);
        assert!(k.kmax[rim] > 0.01 && k.kmax[rim] < 1.0 && k.kmin[rim].abs() < 0.05);
        assert!((k.kmax[rim + 5] - 1.0).abs() < 0.15);
    }
}

#[test]
fn borders_are_one_sided_and_isolated_vertices_zero() {
    let mesh = irregular(100, 40, false, on_cylinder);
    let mut points = mesh.points().to_vec();
    points.push(DVec3::splat(1e9));
    let mesh = SurfaceMesh::new(points, mesh.faces().clone()).unwrap();
    for estimator in Estimator::ALL {
        let k = with(&mesh, estimator);
        let last = mesh.vertex_count() - 1;
        assert_eq!((k.kmin[last], k.kmax[last], k.dmin[last], k.area[last]), (0.0, 0.0, DVec3::ZERO, 0.0));
        for v in 0..last {
            assert_eq!(k.border[v], v % 41 == 0 || v % 41 == 40);
            if k.border[v] && matches!(estimator, Estimator::Corrected | Estimator::NormalCycleBall) {
                assert!((k.kmax[v] - 1.0).abs() < 0.25, "{estimator:?} {}", k.kmax[v]);
            }
        }
    }
}

#[test]
fn motion_changes_directions_only() {
    let mesh = irregular(40, 16, true, on_torus);
    let rotation = DMat3::from_euler(glam::EulerRot::XYZ, 0.4, 1.1, -2.0);
    let turned = moved(&mesh, |p| rotation * p + DVec3::new(3.0, -1.0, 2.0));
    for estimator in Estimator::ALL {
        let (a, b) = (with(&mesh, estimator), with(&turned, estimator));
        for v in 0..mesh.vertex_count() {
            assert!((a.kmin[v] - b.kmin[v]).abs() < 1e-9 && (a.kmax[v] - b.kmax[v]).abs() < 1e-9);
            if a.kmax[v] - a.kmin[v] > 1e-3 {
                assert!(line_angle(rotation * a.dmin[v], b.dmin[v]) < 1e-6);
            }
        }
    }
}

#[test]
fn powers_of_two_scale_exactly() {
    let mesh = irregular(40, 16, true, on_torus);
    for estimator in Estimator::ALL {
        let unit = with(&mesh, estimator);
        for power in [-900, -70, -3, 1, 65, 200, 900] {
            let scaled = with(&moved(&mesh, |p| p * 2f64.powi(power)), estimator);
            let exact = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| *a == *b * 2f64.powi(power));
            assert!(exact(&unit.kmin, &scaled.kmin) && exact(&unit.kmax, &scaled.kmax), "{estimator:?} {power}");
            assert!(unit.dmin == scaled.dmin && unit.dmax == scaled.dmax);
        }
    }
}

#[test]
fn results_do_not_depend_on_threads() {
    let mesh = irregular(90, 40, true, on_torus);
    for estimator in Estimator::ALL {
        let run = |threads| {
            let context = Context::new().with_threads(threads).unwrap();
            context.install(|| of(&mesh, &CurvatureOptions { estimator, radius: None }, &context))
        };
        let one = run(1);
        assert_eq!(one, run(2));
        assert_eq!(one, run(5));
    }
}

#[test]
fn wrong_options_are_refused() {
    let mesh = sphere(1);
    let t = Triangles::of(&mesh).unwrap();
    let context = Context::new();
    assert!(curvature(t, &[], &CurvatureOptions::default(), &context).is_err());
    for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let options = CurvatureOptions { estimator: Estimator::NormalCycleBall, radius: Some(radius) };
        assert!(curvature(t, &[false; 240], &options, &context).is_err());
    }
    let late = Context::new().with_deadline(std::time::Instant::now());
    assert!(matches!(curvature(t, &[false; 240], &CurvatureOptions::default(), &late), Err(Error::Deadline)));
}

#[test]
fn names_are_those_of_the_command() {
    let names = Estimator::ALL.map(|e| serde_json::to_string(&e).unwrap());
    assert_eq!(names, ["\"corrected\"", "\"normal-cycle-1ring\"", "\"normal-cycle-ball\"", "\"mepp\""]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    /// Triangles at random on few points, many of them equal or far apart: every number is finite.
    #[test]
    fn soups_give_numbers(
        places in prop::collection::vec(prop::array::uniform3(-2i8..3), 3..9),
        corners in prop::collection::vec(prop::array::uniform3(0usize..100), 1..14),
        power in prop::sample::select(vec![-1060i32, -1000, -500, -80, 0, 80, 500, 1000, 1022]),
        far in any::<bool>(),
    ) {
        let scale = 2f64.powi(power.max(-1022)) * 2f64.powi((power + 1022).min(0));
        let mut points: Vec<DVec3> =
            places.iter().map(|p| 0.5 * DVec3::from_array(p.map(f64::from)) * scale).collect();
        if far {
            points[0] = DVec3::splat(1.0);
        }
        let n = points.len();
        let faces: Vec<[u32; 3]> = corners.iter().map(|c| c.map(|k| (k % n) as u32)).collect();
        let mesh = triangles(&points, &faces);
        for estimator in Estimator::ALL {
            let k = with(&mesh, estimator);
            let numbers = k.kmin.iter().chain(&k.kmax).chain(&k.area);
            prop_assert!(numbers.into_iter().all(|x| x.is_finite()), "{estimator:?} {k:?}");
            for (a, b) in k.dmin.iter().zip(&k.dmax) {
                prop_assert!(a.is_finite() && b.is_finite());
                prop_assert!([a, b].iter().all(|d| d.length() < 1e-12 || (d.length() - 1.0).abs() < 1e-6), "{a} {b}");
            }
            prop_assert!(k.kmin.iter().zip(&k.kmax).all(|(a, b)| a <= b));
        }
        let full = full_magnitudes(Triangles::of(&mesh).unwrap(), &[], &Context::new()).unwrap();
        prop_assert!(full.iter().all(|[a, b]| a.is_finite() && b.is_finite() && a >= b));
    }
}
