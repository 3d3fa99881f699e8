//! Properties of whole fields on made models.

use super::*;
use crate::geometry::features::FeatureOptions;
use crate::mesh::test_models::{moved, sphere, strip, triangles};
use crate::sample;
use glam::DQuat;
use proptest::prelude::*;

fn of(mesh: &SurfaceMesh, options: &FieldOptions) -> Field {
    let field = field(mesh, options, &Context::new()).unwrap();
    check(&field);
    field
}

fn part(name: &str) -> SurfaceMesh {
    sample::make(name, None, &Context::new()).unwrap()
}

/// What every field promises; the sums of the indices per region are those of its Euler number.
fn check(field: &Field) {
    let conditioned = Conditioned {
        mesh: field.mesh.clone(),
        feature: {
            let is_feature = |c: usize| {
                let c = CornerId::new(c);
                let (a, b) = (field.mesh.vertex(c).0, field.mesh.vertex(field.mesh.next(c)).0);
                field.features.binary_search(&[a.min(b), a.max(b)]).is_ok()
            };
            (0..field.mesh.corner_count()).map(is_feature).collect()
        },
        source: field.source.clone(),
    };
    let dual = Dual::new(&conditioned).unwrap();
    let t = dual.triangles;
    // One constraint per triangle, which its frame follows; one end on features per free edge.
    let mut on_feature = vec![false; t.points().len()];
    field.features.iter().flatten().for_each(|&v| on_feature[v as usize] = true);
    for i in 0..t.len() as u32 {
        let own: Vec<u32> = (3 * i..3 * i + 3).filter(|&c| conditioned.feature[c as usize]).collect();
        assert!(own.len() < 2);
        let (u, v) = (field.u[i as usize], field.v[i as usize]);
        for c in own {
            let along = (t.point(t.next(c)) - t.point(c)).normalize();
            assert!(along.cross(u).length().min(along.cross(v).length()) < 1e-9);
        }
    }
    assert!(
        dual.edges.iter().all(|&c| !(on_feature[t.vertex(c) as usize] && on_feature[t.vertex(t.next(c)) as usize]))
    );
    // Quads as the matchings and the frames say; a turn is known up to whole ones only, so none may reach half a one.
    let p: Vec<i32> = field.matchings.iter().map(|m| m.p).collect();
    let alpha: Vec<f64> = (0..t.len()).map(|i| field.u[i].dot(dual.y[i]).atan2(field.u[i].dot(dual.x[i]))).collect();
    for (fan, corner) in dual.fans.iter().zip(&field.corners) {
        let turn = |e| (matching::rotation(&dual, &alpha, &p, e) + PI).rem_euclid(2.0 * PI) - PI;
        let k = (fan.angle - dual.around(fan, turn)) / FRAC_PI_2;
        assert!((k - f64::from(corner.quads)).abs() < 1e-9, "{k} {corner:?}");
    }
    // Four times the index of every fan, summed over the regions that features divide.
    let mut region: Vec<u32> = (0..t.len() as u32).collect();
    let root = |region: &[u32], mut i: u32| {
        while region[i as usize] != i {
            i = region[i as usize];
        }
        i
    };
    for m in &field.matchings {
        let [a, b] = m.triangles.map(|i| root(&region, i));
        region[a.max(b) as usize] = a.min(b);
    }
    let mut sum = vec![0; t.len()];
    for (fan, corner) in dual.fans.iter().zip(&field.corners) {
        let own = root(&region, dual.corners(fan)[0] / 3) as usize;
        // A vertex counts for the Euler number, a quarter turn for the index.
        sum[own] += 4 - if corner.closed { 4 } else { 2 } + corner.quads;
    }
    for m in &field.matchings {
        sum[root(&region, m.triangles[0]) as usize] -= 4;
    }
    (0..3 * t.len() as u32)
        .filter(|&c| conditioned.feature[c as usize])
        .for_each(|c| sum[root(&region, c / 3) as usize] -= 4);
    (0..t.len() as u32).for_each(|i| sum[root(&region, i) as usize] += 4);
    assert!(sum.iter().all(|&s| s == 0), "index sums: {:?}", sum.iter().filter(|&&s| s != 0).collect::<Vec<_>>());
}

/// Separate triangles, each divided into n² ones, with a corner of each angle.
fn corners(angles: &[f64], n: u32, skew: f64) -> SurfaceMesh {
    let mut points = Vec::new();
    let mut faces = Vec::new();
    for (k, angle) in angles.iter().enumerate() {
        let origin = DVec3::new(3.0 * k as f64, 0.0, 0.0);
        let arm = DVec3::new(angle.to_radians().cos(), angle.to_radians().sin(), 0.0) * (1.0 + skew);
        let base = points.len() as u32;
        let row = |i: u32| base + i * (2 * n + 3 - i) / 2;
        for i in 0..=n {
            for j in 0..=n - i {
                points.push(origin + (DVec3::X * f64::from(j) + arm * f64::from(i)) / f64::from(n));
            }
        }
        for i in 0..n {
            for j in 0..n - i {
                faces.push([row(i) + j, row(i) + j + 1, row(i + 1) + j]);
                if j + 1 < n - i {
                    faces.push([row(i) + j + 1, row(i + 1) + j + 1, row(i + 1) + j]);
                }
            }
        }
    }
    triangles(&points, &faces)
}

#[test]
fn turns_by_more_than_half_a_turn_are_shared_with_other_edges() {
    let context = Context::new();
    let mesh = corners(&[60.0], 8, 0.0);
    let FeaturedSurface { mesh, features, .. } =
        FeaturedSurface::new(&mesh, &FeatureOptions::default(), &context).unwrap();
    let conditioned = condition::condition(&mesh, &features).unwrap();
    let dual = Dual::new(&conditioned).unwrap();
    let Topology { alpha, mut p, .. } = topology(&dual, &FieldOptions::default(), &context).unwrap();
    let far = |e: &usize| dual.ends(*e).iter().all(|&i| !dual.constrained[i as usize]);
    let e = (0..dual.edges.len()).filter(far).nth(20).unwrap();
    p[e] += 3;
    let turn =
        |alpha: &[f64]| (0..p.len() as u32).map(|e| matching::rotation(&dual, alpha, &p, e).abs()).fold(0.0, f64::max);
    assert!(turn(&alpha) > PI);
    let quads = matching::quads(&dual, &alpha, &p);
    let evened = relax::evened(&dual, alpha, &p, &context).unwrap();
    assert!(turn(&evened) < PI);
    assert_eq!(matching::quads(&dual, &evened, &p), quads);
    let relaxed = relax::relax(&dual, &evened, &p, 1.0, &context).unwrap();
    assert!(turn(&relaxed.alpha) < PI);
}

#[test]
fn ten_thousand_corners_from_half_a_degree_have_room_for_a_quad() {
    let mut classic_poles = 0;
    for round in 0..50u32 {
        let angle = |k: u32| 0.5 + 89.0 * f64::from(200 * (k % 50) + 4 * (k / 50) + round) / 9999.0;
        let angles: Vec<f64> = (0..200).map(angle).collect();
        let mesh = corners(&angles, 2 + round % 4, f64::from(round % 7) / 6.0);
        let options = FieldOptions::default();
        let found = field(&mesh, &options, &Context::new()).unwrap();
        assert_eq!(found.poles(), [0, 0]);
        assert!(found.energy[1] <= found.energy[0]);
        if round == 0 {
            check(&found);
            classic_poles = of(&mesh, &options.classic()).poles()[0];
        }
    }
    // That is what the pins are for.
    assert!(classic_poles >= 50, "{classic_poles}");
}

#[test]
fn parts_have_fields_without_poles() {
    for name in ["bracket", "cube-cylinders", "rounded-box", "open-cylinder", "wedge", "torus"] {
        let mesh = part(name);
        for propagation in [Propagation::None, Propagation::Local, Propagation::Global] {
            let found = of(&mesh, &FieldOptions { propagation, ..FieldOptions::default() });
            assert_eq!(found.poles(), [0, 0], "{name}");
            assert!(found.energy[1] <= found.energy[0], "{name}");
            assert!(found.lean_deg() <= 60.0 + 1e-9);
        }
        let options = FieldOptions { orthogonal: true, ..FieldOptions::default() };
        let orthogonal = of(&mesh, &options);
        assert!(orthogonal.lean_deg() < 1e-9 && orthogonal.energy[0] == orthogonal.energy[1]);
    }
}

#[test]
fn the_same_for_any_number_of_threads_and_in_any_position() {
    let mesh = part("bracket");
    let options = FieldOptions::default();
    let found = of(&mesh, &options);
    for threads in [1, 2] {
        let context = Context::new().with_threads(threads).unwrap();
        let again = context.install(|| field(&mesh, &options, &context)).unwrap();
        assert!(again.layout() == found.layout());
    }
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 1.1);
    let elsewhere = of(&moved(&mesh, |p| turn * p * 20.0 + DVec3::new(5.0, -3.0, 9.0)), &options);
    let quads = |f: &Field| f.corners.iter().map(|c| (c.vertex, c.quads)).collect::<Vec<_>>();
    assert_eq!(quads(&elsewhere), quads(&found));
    assert!((elsewhere.energy[1] / found.energy[1] - 1.0).abs() < 1e-3);
}

#[test]
fn layouts_hold_the_whole_field() {
    let found = of(&part("wedge"), &FieldOptions::default());
    let json: serde_json::Value = serde_json::from_slice(&found.layout()).unwrap();
    let count = |name: &str| json[name].as_array().unwrap().len();
    assert_eq!(count("vertices"), found.mesh.vertex_count());
    assert_eq!([count("triangles"), count("u"), count("v")], [found.mesh.face_count(); 3]);
    assert_eq!((count("features"), count("edges")), (found.features.len(), found.matchings.len()));
    assert_eq!(count("singularities"), found.singularities());
    assert_eq!(json["vertices"][1][2].as_f64(), Some(found.mesh.points()[1].z));
}

#[test]
fn what_cannot_carry_a_field_is_refused_or_repaired() {
    let (options, context) = (FieldOptions::default(), Context::new());
    let refused = |mesh: &SurfaceMesh| matches!(field(mesh, &options, &context), Err(Error::Input { .. }));
    assert!(refused(&triangles(&[DVec3::ZERO], &[])));
    assert!(refused(&strip(9, 1)));
    for lean_deg in [-1.0, 90.0, f64::NAN] {
        let wrong = FieldOptions { lean_deg, ..FieldOptions::default() };
        assert!(matches!(field(&part("torus"), &wrong, &context), Err(Error::Options(_))));
    }
    let flag = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(true));
    assert!(matches!(field(&part("torus"), &options, &Context::new().with_cancel(flag)), Err(Error::Cancelled)));
    let repaired = of(&crate::mesh::test_models::cubes_sharing_an_edge(), &options);
    assert!(!repaired.repaired.is_empty());
    // A single triangle, all of whose sides are features.
    let one = of(&triangles(&[DVec3::ZERO, DVec3::X, DVec3::Y], &[[0, 1, 2]]), &options);
    assert_eq!(one.poles(), [0, 0]);
}

#[test]
fn diagonals_of_polygons_are_no_features() {
    let cube = crate::mesh::test_models::cube(DVec3::ZERO, 1.0);
    let found = of(&cube, &FieldOptions::default());
    assert_eq!(found.features.len(), 12);
    assert!(found.corners.iter().all(|c| if c.closed { c.quads == 4 } else { c.quads == 1 }));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn any_triangles_have_a_field(coordinates in prop::collection::vec(-1.0f64..1.0, 24), limit in 10.0f64..180.0) {
        // An octahedron's connectivity on any eight places, two of them between others.
        let p: Vec<DVec3> = coordinates.chunks(3).map(DVec3::from_slice).collect();
        let faces = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1], [5, 2, 1], [5, 3, 2], [5, 4, 3], [5, 1, 4]];
        let mesh = triangles(&p[..6], &faces);
        let mut options = FieldOptions::default();
        options.features.angle_deg = Some(limit);
        let found = of(&mesh, &options);
        prop_assert_eq!(found.poles()[0], 0);
        prop_assert!(found.energy[1] <= found.energy[0]);
    }
}

/// Far from the origin corners may be rounded onto a line: the triangle has no normal, its frame is whole all the same.
#[test]
fn a_triangle_without_area_has_a_frame() {
    let points = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (1.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
    let mesh = triangles(&points, &[[0, 1, 2], [2, 3, 0]]);
    let source = vec![0, 1];
    let conditioned = Conditioned { feature: vec![false; mesh.corner_count()], mesh, source };
    let dual = Dual::new(&conditioned).unwrap();
    for (x, y) in dual.x.iter().zip(&dual.y) {
        assert!((x.length() - 1.0).abs() < 1e-12 && (y.length() - 1.0).abs() < 1e-12 && x.dot(*y).abs() < 1e-12);
    }
}

/// Triangles that are tiny beside others have frames of length one, too.
#[test]
fn a_vertex_far_away_leaves_frames_as_long_as_they_are() {
    let ball = sphere(0);
    let points: Vec<DVec3> = ball.points().iter().map(|p| p.with_y(0.01 * p.y)).collect();
    let mut solved = 0;
    for far in [1e50, 1e155, 1e157, 1e159, 1e200] {
        let mut points = points.clone();
        points[8] *= far;
        let mesh = SurfaceMesh::new(points, ball.faces().clone()).unwrap();
        match field(&mesh, &FieldOptions::default(), &Context::new()) {
            Ok(found) => {
                assert!(found.u.iter().chain(&found.v).all(|d| (d.length() - 1.0).abs() < 1e-9), "{far}");
                solved += 1;
            }
            Err(e) => assert!(matches!(e, Error::Numeric(_)), "{far}: {e}"),
        }
    }
    assert!(solved > 0);
}

/// Largest angle between a direction and the nearest branch, over the triangles for which there is one, in degrees.
fn off(field: &Field, wanted: impl Fn(DVec3, DVec3) -> Option<DVec3>) -> f64 {
    let angle = |t: usize| {
        let p = [0, 1, 2].map(|k| field.mesh.point(field.mesh.vertex(CornerId::new(3 * t + k))));
        let normal = (p[1] - p[0]).cross(p[2] - p[0]).normalize();
        let along = wanted((p[0] + p[1] + p[2]) / 3.0, normal)?.reject_from(normal).normalize();
        Some(field.u[t].dot(along).abs().max(field.v[t].dot(along).abs()).min(1.0).acos().to_degrees())
    };
    (0..field.mesh.face_count()).filter_map(angle).fold(0.0, f64::max)
}

fn smooth() -> FieldOptions {
    FieldOptions {
        features: FeatureOptions { angle_deg: None, ..FeatureOptions::default() },
        ..FieldOptions::default()
    }
}

#[test]
fn fields_follow_the_directions_of_curvature() {
    // Along a torus that lies askew; the smoothest field may lie anyhow.
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 1.0);
    let mesh = moved(&part("torus"), |p| turn * p);
    let around = |p: DVec3, _: DVec3| Some((turn * DVec3::Z).cross(p));
    let found = of(&mesh, &FieldOptions { curvature: 1.0, ..smooth() });
    assert!(off(&found, around) < 8.0 && found.singularities() == 0, "{}", off(&found, around));
}

#[test]
fn fields_follow_guides() {
    // Around a sphere, along a circle that no axis knows of.
    let mesh = sphere(4);
    let (x, y) = DVec3::new(1.0, 0.4, -0.3).normalize().any_orthonormal_pair();
    let at = |k: usize| {
        let (sin, cos) = (2.0 * PI * k as f64 / 100.0).sin_cos();
        x * cos + y * sin
    };
    let guides: Vec<[DVec3; 2]> = (0..100).map(|k| [at(k), at(k + 1)]).collect();
    let axis = x.cross(y);
    let along = |p: DVec3, _: DVec3| (p.normalize().dot(axis).abs() < 0.04).then(|| axis.cross(p));
    let [guided, free] =
        [guides, Vec::new()].map(|guides| off(&of(&mesh, &FieldOptions { guides, ..smooth() }), along));
    assert!(guided < 8.0 && free > 15.0, "{guided} {free}");
}
