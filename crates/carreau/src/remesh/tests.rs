//! The whole room on models whose surface is known.

use super::search::CLOSE_LOOK;
use super::*;
use crate::error::Error;
use crate::geometry::distance::compare;
use crate::geometry::features::{FeatureOptions, feature_edges};
use crate::geometry::intersections::Intersections;
use crate::geometry::search_tree::TriangleTree;
use crate::mesh::test_models::{grid, moved, sphere, together, turned, without};
use crate::mesh::{Column, CornerId, Topology, area_vector};
use crate::sample;
use glam::DVec3;
use rustc_hash::FxHashMap;

fn model(name: &str) -> SurfaceMesh {
    let mesh = sample::make(name, None, &Context::new()).unwrap();
    mesh.triangulated().unwrap()
}

fn at(deviation: f64) -> RemeshOptions {
    RemeshOptions { deviation, ..RemeshOptions::default() }
}

#[test]
fn topology_stays_and_shapes_are_good() {
    let context = Context::new();
    for name in ["torus", "bracket", "cube-cylinders"] {
        let mesh = model(name);
        let out = simplify(&mesh, &at(20.0), &context).unwrap();
        let (before, after) = (Topology::of(&mesh), Topology::of(&out.mesh));
        assert_eq!((after.euler, after.components, after.genus), (before.euler, before.components, before.genus));
        assert!(after.manifold && after.consistently_oriented && after.degenerate_faces == 0, "{name}");
        assert!(out.quality.shape_min > 0.1 && out.quality.shape_mean > 0.8, "{name}: {:?}", out.quality);
    }
}

/// Vertices where a border turns.
fn border_corners(mesh: &SurfaceMesh) -> usize {
    let borders = (0..mesh.corner_count()).map(CornerId::new).filter(|&c| mesh.opposite(c).is_none());
    let next: FxHashMap<_, _> = borders.map(|c| (mesh.vertex(c), mesh.vertex(mesh.next(c)))).collect();
    let along = |v| mesh.point(next[&v]) - mesh.point(v);
    next.iter().filter(|&(&v, &w)| along(v).angle_between(along(w)) > 1.0).count()
}

fn area(mesh: &SurfaceMesh) -> f64 {
    mesh.faces().iter().map(|f| area_vector(mesh.points(), f).length() / 2.0).sum()
}

#[test]
fn corners_of_borders_stay() {
    // A hole of a thousandth of its plate.
    let graded = moved(&grid(13), |p| (2.0 / 13.0 * p - DVec3::new(1.0, 1.0, 0.0)).powf(3.0));
    let pierced = without(&graded, &[168, 169]);
    for (mesh, corners) in [(grid(1), 4), (pierced, 8)] {
        for ragged_borders in [true, false] {
            for max_size in [0.04, 0.2] {
                let options = RemeshOptions { max_size, ragged_borders, ..RemeshOptions::default() };
                for run in [simplify, enrich] {
                    let out = run(&mesh, &options, &Context::new()).unwrap().mesh;
                    assert_eq!(border_corners(&out), corners, "{max_size} {ragged_borders}");
                    assert!((area(&out) - area(&mesh)).abs() < 1e-9 * area(&mesh));
                }
            }
        }
    }
}

#[test]
fn the_same_for_any_number_of_threads() {
    let mesh = model("torus");
    let run = |threads| {
        let context = Context::new().with_threads(threads).unwrap();
        context.install(|| simplify(&mesh, &at(20.0), &context)).unwrap().mesh
    };
    let (a, b) = (run(1), run(2));
    assert_eq!(a.points(), b.points());
    assert_eq!(a.faces(), b.faces());
}

#[test]
fn a_wanted_number_of_triangles_is_met() {
    let mesh = model("torus");
    let wanted = mesh.face_count() / 3;
    let options = RemeshOptions { triangles: Some(wanted), ..at(20.0) };
    let out = simplify(&mesh, &options, &Context::new()).unwrap();
    assert!(out.mesh.face_count().abs_diff(wanted) as f64 <= 0.01 * wanted as f64, "{}", out.mesh.face_count());
}

#[test]
fn ridges_get_as_few_edges_as_their_sag_allows() {
    let mesh = model("cylinder");
    // At such an angle the tolerance decides on the rims.
    let options = at(40.0);
    let out = simplify(&mesh, &options, &Context::new()).unwrap().mesh;
    let ridges = feature_edges(&out, &FeatureOptions::default()).unwrap();
    let inner = |c: &CornerId| ridges.contains(*c) && out.opposite(*c).is_none_or(|o| *c < o);
    let rims: Vec<CornerId> = (0..out.corner_count()).map(CornerId::new).filter(inner).collect();
    let ends = |c: CornerId| [c, out.next(c)].map(|c| out.points()[out.vertex(c).index()]);
    let radius = rims.iter().flat_map(|&c| ends(c)).map(|p| p.truncate().length()).fold(0.0, f64::max);
    let tolerance = options.ridge_tolerance * mesh.diagonal();
    let sag = |c: &CornerId| radius - ends(*c).into_iter().sum::<DVec3>().truncate().length() / 2.0;
    // The tolerance is that from the edges of the source, which sag themselves.
    assert!(rims.iter().map(sag).fold(0.0, f64::max) <= 1.4 * tolerance);
    // Of a circle edges that sag by all they may make so many.
    let fewest = 2.0 * std::f64::consts::PI / (1.0 - tolerance / radius).acos();
    assert!((rims.len() as f64) < 1.35 * fewest, "{} edges, {fewest} would do", rims.len());
}

/// A vertex far away makes the other edges as short as one likes: no size is so small that dividing does not end.
#[test]
fn sizes_that_ask_for_too_many_edges_are_refused() {
    for max_size in [1e-10, 1e-200, f64::MIN_POSITIVE] {
        let options = RemeshOptions { min_size: 0.0, max_size, ..RemeshOptions::default() };
        let refused = simplify(&model("bracket"), &options, &Context::new()).unwrap_err();
        assert!(refused.exit_code() == 4 && refused.to_string().contains("edges"), "{max_size}: {refused}");
    }
}

#[test]
fn least_error_is_nearer_than_good_shapes_and_stops_at_the_count() {
    let (mesh, context) = (model("torus"), Context::new());
    let wanted = mesh.face_count() / 4;
    let run = |geometric| {
        let options = RemeshOptions { triangles: Some(wanted), geometric, ..at(20.0) };
        let out = simplify(&mesh, &options, &context).unwrap();
        let quality = out.quality.with_distance(&mesh, &out.mesh, &context).unwrap();
        (out.mesh, quality)
    };
    let ((light, near), (_, graded)) = (run(true), run(false));
    assert!(light.face_count() <= wanted && light.face_count() + 2 >= wanted, "{}", light.face_count());
    assert!(near.distance_rms < graded.distance_rms && near.shape_min > 0.1 && graded.shape_min > near.shape_min);
    assert_eq!(Topology::of(&light).euler, Topology::of(&mesh).euler);
}

#[test]
fn a_distance_is_a_promise() {
    let context = Context::new();
    let mesh = sample::make("bracket", Some(30), &context).unwrap();
    for geometric in [false, true] {
        let limit = 4e-3 * mesh.diagonal();
        let options = RemeshOptions { distance: Some(limit), geometric, ..at(20.0) };
        let out = simplify(&mesh, &options, &context).unwrap();
        let found = compare(&mesh, &out.mesh, &CLOSE_LOOK, &context).unwrap().distance;
        assert!(found.max_upper <= limit && out.mesh.face_count() < 2 * mesh.face_count());
    }
}

#[test]
fn no_smooth_edge_becomes_a_crease() {
    let (mesh, context) = (model("bracket"), Context::new());
    let out = simplify(&mesh, &at(30.0), &context).unwrap().mesh;
    let sharp = |m: &SurfaceMesh, angle| {
        let options =
            FeatureOptions { angle_deg: Some(angle), borders: false, tags: false, ..FeatureOptions::default() };
        feature_edges(m, &options).unwrap().corners
    };
    let marks = sharp(&out, 35.0);
    let half = sharp(&mesh, 17.5);
    let ridge: Vec<[DVec3; 2]> = (0..mesh.corner_count())
        .filter(|&c| half[c])
        .map(CornerId::new)
        .map(|c| [mesh.vertex(c), mesh.vertex(mesh.next(c))].map(|v| mesh.points()[v.index()]))
        .collect();
    let far = |p: DVec3| {
        ridge
            .iter()
            .map(|&[a, b]| {
                let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
                p.distance(a.lerp(b, t))
            })
            .fold(f64::INFINITY, f64::min)
    };
    for c in (0..out.corner_count()).filter(|&c| marks[c]).map(CornerId::new) {
        let [p, q] = [out.vertex(c), out.vertex(out.next(c))].map(|v| out.points()[v.index()]);
        assert!(far(0.5 * (p + q)) < 1e-3 * mesh.diagonal());
    }
}

/// The round side of a long block: two large faces and narrow strips between them, of one triangle pair each.
fn half_round(strips: usize, thickness: f64) -> SurfaceMesh {
    let turn = |k: usize| std::f64::consts::PI * k as f64 / strips as f64;
    let arc = (0..=strips).map(|k| DVec3::new(turn(k).sin(), 0.0, turn(k).cos()) * 0.5 * thickness);
    let ends = [DVec3::new(-3.0, 0.0, 0.5 * thickness), DVec3::new(-3.0, 0.0, -0.5 * thickness)];
    let profile: Vec<DVec3> = [ends[0]].into_iter().chain(arc).chain([ends[1]]).collect();
    let points = profile.iter().flat_map(|&p| [p, p + 2.0 * DVec3::Y]).collect();
    let pair = |k: u32| [[2 * k, 2 * k + 3, 2 * k + 1], [2 * k, 2 * k + 2, 2 * k + 3]];
    let faces: Vec<[u32; 3]> = (0..profile.len() as u32 - 1).flat_map(pair).collect();
    SurfaceMesh::from_triangles(points, &faces).unwrap()
}

#[test]
fn flat_faces_beside_fillets_stay_flat() {
    let thickness = 1.0;
    let made = enrich(&half_round(20, thickness), &at(8.0), &Context::new()).unwrap().mesh;
    assert!(made.face_count() > 500);
    let off = |p: &DVec3| if p.x < 0.0 { p.z.abs() } else { p.x.hypot(p.z) } - 0.5 * thickness;
    let worst = made.points().iter().map(|p| off(p).abs()).fold(0.0, f64::max);
    // The normals of faces and strips weighted alike would tilt those of the faces by two degrees: .02 in their middle.
    assert!(worst < 0.004 * thickness, "{worst}");
}

/// Two spheres, one in the other, nearer to each other than chords at the usual angle sag.
#[test]
fn sheets_close_to_each_other_do_not_meet() {
    let inner = turned(&moved(&sphere(5), |p| 0.99 * p), |_| true);
    let both = together(&[sphere(5), inner]);
    let made = simplify(&both, &RemeshOptions::default(), &Context::new()).unwrap().mesh;
    assert!(made.face_count() < both.face_count() / 2, "{}", made.face_count());
    let crossing = Intersections::of(&made, &Context::new()).unwrap();
    assert_eq!(crossing.pairs, 0);
}

#[test]
fn patches_do_not_pierce_thin_walls() {
    // Two coarse tubes, one in the other, nearer to each other than the patches of their facets are high.
    let ring = |r: f64, z: f64| (0..10).map(move |k| (r, std::f64::consts::TAU * k as f64 / 10.0, z));
    let points: Vec<DVec3> = [(1.0, 0.0), (1.0, 2.0), (0.98, 0.0), (0.98, 2.0)]
        .into_iter()
        .flat_map(|(r, z)| ring(r, z).map(|(r, a, z)| DVec3::new(r * a.cos(), r * a.sin(), z)))
        .collect();
    let wall = |first: u32, turned: bool| {
        (0..10).flat_map(move |k| {
            let [a, b] = [first + k, first + (k + 1) % 10];
            [[a, b, b + 10], [a, b + 10, a + 10]].map(|[a, b, c]| if turned { [a, c, b] } else { [a, b, c] })
        })
    };
    let faces: Vec<[u32; 3]> = wall(0, false).chain(wall(20, true)).collect();
    let walls = SurfaceMesh::from_triangles(points, &faces).unwrap();
    let options = RemeshOptions { feature_angle: 60.0, ..at(8.0) };
    let made = enrich(&walls, &options, &Context::new()).unwrap().mesh;
    // No face of the inner wall looks outwards, and none lies beyond the facets of the outer one.
    let apothem = (std::f64::consts::PI / 10.0).cos();
    for face in made.faces().iter() {
        let area = area_vector(made.points(), face);
        let middle = face.iter().map(|&v| made.points()[v as usize]).sum::<DVec3>() / 3.0;
        let radius = middle.x.hypot(middle.y);
        if area.dot(middle.with_z(0.0)) < 0.0 {
            let turn = middle.y.atan2(middle.x).rem_euclid(std::f64::consts::TAU / 10.0) - std::f64::consts::PI / 10.0;
            assert!(radius * turn.cos() < apothem, "an inner face {radius} from the axis");
        }
    }
}

#[test]
fn ridges_that_nearly_touch_stay_where_they_are() {
    // The round end of a boss below the straight edge of a plate, and the wall between them, of next to no height.
    let (strips, gap) = (32, 1e-4);
    let turn = |k: u32| 2.0 * f64::from(k) / f64::from(strips) - 1.0;
    let arc = |y: f64| (0..=strips).map(move |k| DVec3::new(turn(k).sin(), y, turn(k).cos() - 1.0 - gap));
    let plate = [(-1.4, 0.0), (1.4, 0.0), (1.4, -1.0), (-1.4, -1.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
    let points: Vec<DVec3> = arc(0.0).chain(arc(1.0)).chain(plate).collect();
    let (back, corner, half) = (strips + 1, 2 * strips + 2, strips / 2);
    let boss = (0..strips).flat_map(|k| [[k, k + 1, back + k + 1], [k, back + k + 1, back + k]]);
    let wall = (0..strips).map(|k| [k + 1, k, corner + u32::from(k >= half)]);
    let flat = [[corner + 3, corner + 2, corner + 1], [corner + 3, corner + 1, corner], [half, corner, corner + 1]];
    let faces: Vec<[u32; 3]> = boss.chain(wall).chain(flat).collect();
    let rim = TriangleTree::of_segments(&points, (0..strips).map(|k| [k, k + 1]));
    let touching = SurfaceMesh::from_triangles(points, &faces).unwrap();
    let made = simplify(&touching, &at(20.0), &Context::new()).unwrap().mesh;
    let ends = |c: CornerId| [c, made.next(c)].map(|c| made.point(made.vertex(c)));
    let is_on_rim = |c: &CornerId| ends(*c).iter().all(|p| rim.distance(*p) < 1e-9);
    let ridges = feature_edges(&made, &FeatureOptions::default()).unwrap();
    let rims: Vec<CornerId> = ridges.edges(&made).filter(is_on_rim).collect();
    let places = |&c: &CornerId| {
        let [a, b] = ends(c);
        (1..10).map(move |k| a.lerp(b, 0.1 * f64::from(k)))
    };
    let sag = rims.iter().flat_map(places).map(|p| rim.distance(p)).fold(0.0, f64::max);
    assert!(
        rims.len() > 5 && sag < 1.02 * at(20.0).ridge_tolerance * touching.diagonal(),
        "{} edges, {sag}",
        rims.len()
    );
}

#[test]
fn vertices_are_fitted_so_that_the_volume_stays() {
    let context = Context::new();
    let mesh = model("icosphere");
    let volume = |m: &SurfaceMesh| {
        let p = |v: u32| m.points()[v as usize];
        m.faces().iter().map(|f| p(f[0]).dot(p(f[1]).cross(p(f[2])))).sum::<f64>() / 6.0
    };
    let out = simplify(&mesh, &at(20.0), &context).unwrap().mesh;
    // A mesh with its vertices on the sphere would lose what all its sags hold.
    let radius = mesh.points()[0].length();
    let inscribed: Vec<DVec3> = out.points().iter().map(|p| p.normalize() * radius).collect();
    let faces: Vec<[u32; 3]> = out.faces().iter().map(|f| [f[0], f[1], f[2]]).collect();
    let inscribed = SurfaceMesh::from_triangles(inscribed, &faces).unwrap();
    let [lost, kept] = [&inscribed, &out].map(|m| (volume(m) / volume(&mesh) - 1.0).abs());
    assert!(out.face_count() < mesh.face_count() / 2 && kept < 0.3 * lost, "{kept} against {lost}");
}

#[test]
fn stretched_edges_follow_the_axis_of_a_tube() {
    let (mesh, context) = (model("torus"), Context::new());
    let wanted = mesh.face_count() / 4;
    let run = |anisotropic| {
        let options = RemeshOptions { triangles: Some(wanted), anisotropic, ..at(20.0) };
        let out = simplify(&mesh, &options, &context).unwrap();
        out.quality.with_distance(&mesh, &out.mesh, &context).unwrap()
    };
    let (round, long) = (run(false), run(true));
    assert!(long.distance_rms < round.distance_rms, "{long:?} {round:?}");
    assert!(long.length_in_half_two > 0.99 && long.shape_mean < round.shape_mean);
}

#[test]
fn faces_turned_over_change_nothing() {
    let (mesh, context) = (model("torus"), Context::new());
    // Every third face: not the majority, so that it is them that are turned back.
    let spoiled: Vec<[u32; 3]> = (0u32..)
        .zip(mesh.faces().iter())
        .map(|(k, f)| if k % 10 < 3 { [f[0], f[2], f[1]] } else { [f[0], f[1], f[2]] })
        .collect();
    let spoiled = SurfaceMesh::from_triangles(mesh.points().to_vec(), &spoiled).unwrap();
    let [clean, mended] = [&mesh, &spoiled].map(|m| simplify(m, &at(20.0), &context).unwrap());
    assert!(!mended.repaired.is_empty() && Topology::of(&mended.mesh).consistently_oriented);
    let [a, b] = [clean.mesh, mended.mesh].map(|m| m.face_count());
    assert!(a.abs_diff(b) * 20 < a, "{a} {b}");
    assert!((clean.quality.shape_mean - mended.quality.shape_mean).abs() < 0.01);
}

#[test]
fn a_strip_with_one_side_stays_one() {
    let context = Context::new();
    let strip = crate::mesh::test_models::strip(40, 1);
    for deviation in [10.0, 40.0] {
        for run in [simplify, enrich] {
            let out = run(&strip, &at(deviation), &context).unwrap().mesh;
            let (before, after) = (Topology::of(&strip), Topology::of(&out));
            assert!(!after.orientable && after.manifold);
            assert_eq!((after.euler, after.boundary_loops), (before.euler, before.boundary_loops));
        }
    }
}

#[test]
fn sizes_that_are_given_are_kept() {
    let (mut mesh, context) = (model("torus"), Context::new());
    let fine = 0.03 * mesh.diagonal();
    let size = |p: &DVec3| if p.x > 0.0 { fine } else { 1e9 };
    let given = mesh.points().iter().map(size).collect();
    mesh.attributes.vertex.insert("wanted".into(), Column::Scalar(given));
    let options = RemeshOptions { sizes: Some("wanted".into()), ..at(40.0) };
    let out = simplify(&mesh, &options, &context).unwrap().mesh;
    for e in out.half_edges().groups() {
        let [a, b] = e.ends.map(|v| out.points()[v as usize]);
        assert!(a.x.min(b.x) <= 0.0 || a.distance(b) < 1.8 * fine);
    }
    mesh.attributes.vertex.insert("wanted".into(), Column::Scalar(vec![-1.0; mesh.vertex_count()]));
    assert!(matches!(simplify(&mesh, &options, &context), Err(Error::Options(_))));
}

#[test]
fn ridges_that_fade_are_followed() {
    // A roof whose angle falls from 80° to nothing: z = −|y| (1 − x).
    let n = 40u32;
    let point = |k: u32| {
        let [x, y] = [f64::from(k % (n + 1)) / f64::from(n), f64::from(k / (n + 1)) / f64::from(n) - 0.5];
        DVec3::new(x, y, -0.8 * y.abs() * (1.0 - x))
    };
    let quad = |k: u32| {
        let a = k / n * (n + 1) + k % n;
        [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]
    };
    let faces: Vec<[u32; 3]> = (0..n * n).flat_map(quad).collect();
    let mesh = SurfaceMesh::from_triangles((0..(n + 1) * (n + 1)).map(point).collect(), &faces).unwrap();
    let out = simplify(&mesh, &at(30.0), &Context::new()).unwrap().mesh;
    // To well below the feature angle of 35° no edge runs across.
    for e in out.half_edges().groups() {
        let [a, b] = e.ends.map(|v| out.points()[v as usize]);
        assert!(!(a.y * b.y < -1e-9 && a.x.max(b.x) < 0.7), "{a} {b}");
    }
}

#[test]
fn options_out_of_range_are_refused() {
    let mesh = model("torus");
    for deviation in [0.0, -1.0, 90.0, f64::NAN] {
        assert!(matches!(simplify(&mesh, &at(deviation), &Context::new()), Err(Error::Options(_))));
    }
    let options = RemeshOptions { gradation: Some(1.0), ..at(20.0) };
    assert!(matches!(enrich(&mesh, &options, &Context::new()), Err(Error::Options(_))));
}
