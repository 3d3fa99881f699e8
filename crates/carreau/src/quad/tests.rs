//! Properties of whole quad meshes on made models, rung by rung.

use super::work::Place;
use super::*;
use crate::error::Error;
use crate::geometry::distance::{DistanceOptions, compare};
use crate::mesh::test_models::{cube, cubes_sharing_an_edge, grid, moved, together, triangles, turned, without};
use crate::mesh::{Polygons, Topology};
use crate::sample;
use glam::{DVec2, DVec3};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;

fn part(name: &str) -> SurfaceMesh {
    sample::make(name, None, &Context::new()).unwrap()
}

/// What every quad mesh promises.
fn check(mesh: &SurfaceMesh, result: &Quads) {
    let out = &result.mesh;
    assert!(out.faces().iter().all(|f| f.len() == 4));
    let (had, has) = (Topology::of(mesh), Topology::of(out));
    assert_eq!((had.components, had.euler, had.boundary_loops), (has.components, has.euler, has.boundary_loops));
    assert_eq!(
        has.nonmanifold_edges + has.nonmanifold_vertices + has.inconsistent_edges + has.unreferenced_vertices,
        0
    );
    assert!(result.quality.inverted == 0 && result.quality.scaled_jacobian_min > 0.0);
    assert!(result.quality.feature_recall > 0.9995);
    assert_eq!(result.rungs.iter().map(|r| r.quads).sum::<usize>(), out.face_count());
    // Tagged edges are edges.
    let half_edges = out.half_edges();
    assert!(out.tagged_edges.iter().all(|e| half_edges.find(e.ends[0].0, e.ends[1].0).is_some()));
}

#[test]
fn every_rung_gives_quads_that_keep_the_features() {
    for (name, rungs) in
        [("bracket", &[1, 3][..]), ("wedge", &[1, 3, 4]), ("open-cylinder", &[1, 3, 4]), ("torus", &[1, 3])]
    {
        let mesh = part(name);
        for &rung in rungs {
            let options = QuadOptions { quads: 900, rung, ..QuadOptions::default() };
            let result = quads(&mesh, &options, &Context::new()).unwrap();
            check(&mesh, &result);
            assert!(result.rung() >= rung, "{name}");
            match result.rung() {
                4 => assert_eq!(result.mesh.face_count(), 3 * mesh.face_count()),
                _ => assert!(
                    off(result.mesh.face_count(), 900) <= NUMBER_WITHIN || !result.warnings.is_empty(),
                    "{name}"
                ),
            }
        }
    }
}

#[test]
fn the_last_rung_keeps_the_input_to_the_bit() {
    let mesh = part("wedge");
    let context = Context::new();
    let result = quads(&mesh, &QuadOptions { rung: 4, ..QuadOptions::default() }, &context).unwrap();
    assert_eq!(&result.mesh.points()[..mesh.vertex_count()], mesh.points());
    // The record holds a bound of the distance, which is not as sharp as the distance found.
    let found = compare(&mesh, &result.mesh.triangulated().unwrap(), &DistanceOptions::default(), &context).unwrap();
    assert!(found.distance.max < 1e-9 && result.quality.distance_max.unwrap() < 0.01, "{:?}", found.distance);
}

#[test]
fn edges_have_the_length_that_was_asked_for() {
    let mesh = part("torus");
    let options = QuadOptions { edge_length: Some(0.12), ..QuadOptions::default() };
    let result = quads(&mesh, &options, &Context::new()).unwrap();
    check(&mesh, &result);
    let out = &result.mesh;
    let lengths: Vec<f64> = out
        .half_edges()
        .groups()
        .map(|e| e.ends.map(|v| out.points()[v as usize]))
        .map(|[a, b]| a.distance(b))
        .collect();
    let mean = lengths.iter().sum::<f64>() / lengths.len() as f64;
    assert!((0.6..1.5).contains(&(mean / 0.12)), "{mean}");
}

#[test]
fn the_same_for_any_number_of_threads() {
    let mesh = part("bracket");
    let of = |threads: usize| {
        let context = Context::new().with_threads(threads).unwrap();
        let options = QuadOptions { quads: 800, ..QuadOptions::default() };
        context.install(|| quads(&mesh, &options, &context)).unwrap().mesh
    };
    let (one, two) = (of(1), of(2));
    assert!(one.points() == two.points() && one.faces() == two.faces());
}

#[test]
fn polygons_soups_and_pieces_are_taken_as_they_come() {
    let options = QuadOptions { quads: 200, ..QuadOptions::default() };
    for mesh in [cube(DVec3::ZERO, 1.0), grid(3)] {
        check(&mesh, &quads(&mesh, &options, &Context::new()).unwrap());
    }
    let result = quads(&cubes_sharing_an_edge(), &options, &Context::new()).unwrap();
    assert!(!result.warnings.is_empty() && result.mesh.faces().iter().all(|f| f.len() == 4));
    let one = triangles(&[DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ONE], &[[0, 1, 2]]);
    let result = quads(&one, &QuadOptions { quads: 3, ..options }, &Context::new()).unwrap();
    assert_eq!(Topology::of(&result.mesh).unreferenced_vertices, 0);
}

#[test]
fn wrong_options_are_refused() {
    let mesh = part("torus");
    let wrong = |options: QuadOptions| matches!(quads(&mesh, &options, &Context::new()), Err(Error::Options(_)));
    assert!(wrong(QuadOptions { quads: 0, ..QuadOptions::default() }));
    assert!(wrong(QuadOptions { rung: 5, ..QuadOptions::default() }));
    assert!(wrong(QuadOptions { edge_length: Some(f64::NAN), ..QuadOptions::default() }));
    assert!(wrong(QuadOptions { guides: vec![[DVec3::splat(9.0), DVec3::splat(10.0)]], ..QuadOptions::default() }));
    assert!(wrong(QuadOptions { adaptive: true, sizes: Some("size".into()), ..QuadOptions::default() }));
    let few = QuadOptions { quads: 200, max_quads: Some(10), ..QuadOptions::default() };
    assert!(matches!(quads(&mesh, &few, &Context::new()), Err(Error::Numeric(why)) if why.contains("at most 10")));
    let empty = triangles(&[DVec3::ZERO], &[]);
    assert!(matches!(quads(&empty, &QuadOptions::default(), &Context::new()), Err(Error::Input { .. })));
}

#[test]
fn sheets_that_meet_in_an_edge_have_the_same_vertices_there() {
    // Three triangles, of which each has the edge from 0 to X as its own.
    let apexes = [DVec3::new(0.2, 1.0, 0.0), DVec3::new(0.9, -0.7, 0.3), DVec3::new(0.5, 0.1, 1.5)];
    let points: Vec<DVec3> = apexes.iter().flat_map(|&apex| [DVec3::ZERO, DVec3::X, apex]).collect();
    let mesh = triangles(&points, &[[0, 1, 2], [3, 4, 5], [6, 7, 8]]);
    for rung in [1, 3] {
        let options = QuadOptions { quads: 600, rung, ..QuadOptions::default() };
        let result = quads(&mesh, &options, &Context::new()).unwrap();
        check(&mesh, &result);
        assert!(result.rung() <= 3, "{:?}", result.warnings);
        let on_edge = |p: &&DVec3| p.y.abs() + p.z.abs() < 1e-9 && p.x > -1e-9 && p.x < 1.0 + 1e-9;
        let mut along: Vec<f64> = result.mesh.points().iter().filter(on_edge).map(|p| p.x).collect();
        along.sort_by(f64::total_cmp);
        assert!(along.len() > 12 && along.chunks(3).all(|same| same.len() == 3 && same[2] - same[0] < 1e-9));
    }
}

#[test]
fn flat_grids_are_straight_however_their_triangles_are_graded() {
    // The triangles of a thin plate are small along its rim.
    let mesh = moved(&cube(DVec3::ZERO, 1.0), |p| p * DVec3::new(10.0, 6.0, 0.15));
    let result = quads(&mesh, &QuadOptions::default(), &Context::new()).unwrap();
    check(&mesh, &result);
    let quality = &result.quality;
    assert!(quality.scaled_jacobian_min > 0.99 && quality.irregular == 8, "{quality:?}");
}

#[test]
fn loose_faces_that_are_divided_differently_meet_on_the_first_rung() {
    // The faces of a box, each by itself; one is divided at the middles of its sides.
    let faces = |mesh: &SurfaceMesh, keep: &[usize]| {
        let rest: Vec<usize> = (0..mesh.face_count()).filter(|f| !keep.contains(f)).collect();
        without(mesh, &rest)
    };
    let whole = cube(DVec3::ZERO, 2.0);
    let mut parts: Vec<SurfaceMesh> = (1..6).map(|f| faces(&whole, &[f])).collect();
    // The bottom looks down.
    parts.push(turned(&grid(2), |_| true));
    let mesh = together(&parts);
    let result = quads(&mesh, &QuadOptions { quads: 600, ..QuadOptions::default() }, &Context::new()).unwrap();
    assert!(result.rung() == 1 && result.quality.irregular == 0, "{:?} {:?}", result.rungs, result.warnings);
    check(&mesh, &result);
    let out = &result.mesh;
    assert_eq!(Topology::of(out).components, 6);
    // Every vertex on a border lies on one of another face, to the bit.
    let half_edges = out.half_edges();
    let on_border: BTreeSet<u32> = half_edges.groups().filter(|e| e.len() == 1).flat_map(|e| e.ends).collect();
    let mut at: BTreeMap<[u64; 3], usize> = BTreeMap::new();
    for v in on_border {
        *at.entry(out.points()[v as usize].to_array().map(f64::to_bits)).or_default() += 1;
    }
    assert!(at.len() > 60 && at.values().all(|&n| n == 2 || n == 3), "two at edges, three at corners");
}

#[test]
fn a_box_of_loose_faces_is_one_of_grids() {
    let mesh = cube(DVec3::ZERO, 1.0);
    let corners = mesh.faces().corners().iter().map(|&v| mesh.points()[v as usize]).collect();
    let faces = (0..6u32).map(|f| [0, 1, 2, 3].map(|k| 4 * f + k)).collect::<Vec<_>>();
    let loose = SurfaceMesh::new(corners, faces.iter().map(|f| &f[..]).collect()).unwrap();
    let result = quads(&loose, &QuadOptions { quads: 600, ..QuadOptions::default() }, &Context::new()).unwrap();
    check(&loose, &result);
    assert_eq!((result.rung(), result.quality.irregular), (1, 0));
    let corners = mesh.points().iter().filter(|&&p| result.mesh.points().iter().filter(|&&q| q == p).count() == 3);
    assert_eq!(corners.count(), 8);
}

#[test]
fn a_box_has_eight_irregular_vertices_and_grids() {
    let mesh = cube(DVec3::ZERO, 2.0);
    let result = quads(&mesh, &QuadOptions { quads: 600, ..QuadOptions::default() }, &Context::new()).unwrap();
    check(&mesh, &result);
    assert_eq!((result.rung(), result.quality.irregular), (1, 8));
    assert!(result.quality.scaled_jacobian_mean > 0.999 && result.mesh.face_count().is_multiple_of(2));
}

/// A prism over a regular polygon: a coarse cylinder, whose rims are chains of straight edges.
fn prism(sides: u32) -> SurfaceMesh {
    let ring = |z: f64| {
        (0..sides).map(move |k| {
            let (sin, cos) = (TAU * f64::from(k) / f64::from(sides)).sin_cos();
            DVec3::new(cos, sin, z)
        })
    };
    let points: Vec<DVec3> = ring(0.0).chain(ring(2.0)).chain([DVec3::ZERO, DVec3::new(0.0, 0.0, 2.0)]).collect();
    let [low, high] = [2 * sides, 2 * sides + 1];
    let faces: Vec<[u32; 3]> = (0..sides)
        .map(|k| [k, (k + 1) % sides])
        .flat_map(|[a, b]| {
            let [c, d] = [a, b].map(|v| v + sides);
            [[a, b, d], [a, d, c], [low, b, a], [high, c, d]]
        })
        .collect();
    SurfaceMesh::from_triangles(points, &faces).unwrap()
}

#[test]
fn vertices_lie_where_coarse_rims_bend_and_the_number_is_met() {
    let mesh = prism(16);
    let wanted = 900;
    let options = QuadOptions { quads: wanted, ..QuadOptions::default() };
    let result = quads(&mesh, &options, &Context::new()).unwrap();
    check(&mesh, &result);
    assert!(
        result.rung() == 1 && off(result.mesh.face_count(), wanted) <= NUMBER_WITHIN,
        "{}",
        result.mesh.face_count()
    );
    let is_met = |p: &&DVec3| result.mesh.points().iter().any(|q| q.distance(**p) < 1e-9);
    let met = mesh.points()[..32].iter().filter(is_met).count();
    assert!(met >= 28, "{met} of 32 bends");
    // The upright edges are no features: without the fit the mean is at 0.06 % of the diagonal.
    let found = compare(&mesh, &result.mesh, &DistanceOptions::default(), &Context::new()).unwrap();
    assert!(found.relative.mean < 1e-4, "{:?}", found.relative);
}

/// A flat stadium: two half circles, and straight sides ten times as long as their radius, in a fan of triangles.
fn stadium(segments: u32) -> SurfaceMesh {
    let half = |x: f64, from: f64| {
        (0..=segments).map(move |k| {
            let angle = from + 0.5 * TAU * f64::from(k) / f64::from(segments);
            DVec3::new(x + 0.1 * angle.cos(), 0.1 * angle.sin(), 0.0)
        })
    };
    let rim: Vec<DVec3> = half(0.5, -0.25 * TAU).chain(half(-0.5, 0.25 * TAU)).collect();
    let mut faces = Polygons::new();
    let n = rim.len() as u32;
    (0..n).for_each(|k| faces.push(&[0, k + 1, (k + 1) % n + 1]));
    SurfaceMesh::new([DVec3::ZERO].into_iter().chain(rim).collect(), faces).unwrap()
}

#[test]
fn rims_that_turn_evenly_in_parts_get_their_edges_there() {
    for segments in [32, 64] {
        let mesh = stadium(segments);
        let options = QuadOptions { quads: 150, ..QuadOptions::default() };
        let result = quads(&mesh, &options, &Context::new()).unwrap();
        check(&mesh, &result);
        assert_eq!(result.rung(), 1);
    }
}

#[test]
fn only_the_corners_at_an_acute_edge_are_acute() {
    let angle: f64 = 14.0;
    let mesh = sample::wedge(angle, 2.0, 3.0, 0.5, &Context::new()).unwrap().mesh;
    let result = quads(&mesh, &QuadOptions { quads: 1500, ..QuadOptions::default() }, &Context::new()).unwrap();
    check(&mesh, &result);
    let out = &result.mesh;
    for face in out.faces().iter() {
        let p = [0, 1, 2, 3].map(|k| out.points()[face[k] as usize]);
        for k in 0..4 {
            let sin = (p[(k + 1) % 4] - p[k]).angle_between(p[(k + 3) % 4] - p[k]).sin();
            let is_at_edge = p[k].x.abs() + p[k].z.abs() < 1e-9;
            assert!(sin > 0.4 || is_at_edge && sin > 0.99 * angle.to_radians().sin(), "{sin} at {}", p[k]);
        }
    }
}

/// A cone of height 1 with 24 sides.
fn cone(radius: f64) -> SurfaceMesh {
    let sides = 24;
    let (base, tip) = (sides, sides + 1);
    let at = |k: u32| DVec2::from_angle(TAU * f64::from(k) / f64::from(sides)).extend(0.0);
    let points: Vec<DVec3> = (0..sides).map(|k| radius * at(k)).chain([DVec3::ZERO, DVec3::Z]).collect();
    let sector = |k: u32| [[base, (k + 1) % sides, k], [tip, k, (k + 1) % sides]];
    triangles(&points, &(0..sides).flat_map(sector).collect::<Vec<_>>())
}

fn nearest_to_tip(result: &Quads) -> f64 {
    result.mesh.points().iter().map(|p| p.distance(DVec3::Z)).fold(f64::INFINITY, f64::min)
}

#[test]
fn the_tip_of_a_cone_is_a_vertex() {
    for quads_wanted in [600, 1000, 2000] {
        let (mesh, options) = (cone(1.0), QuadOptions { quads: quads_wanted, ..QuadOptions::default() });
        let result = quads(&mesh, &options, &Context::new()).unwrap();
        check(&mesh, &result);
        assert!(nearest_to_tip(&result) < 1e-9, "{quads_wanted}: {}", nearest_to_tip(&result));
    }
}

#[test]
fn needles_keep_their_points() {
    let half_angle = 12f64.to_radians();
    let mesh = cone(half_angle.tan());
    let result = quads(&mesh, &QuadOptions { quads: 800, ..QuadOptions::default() }, &Context::new()).unwrap();
    check(&mesh, &result);
    assert!(nearest_to_tip(&result) < 1e-9, "{}", nearest_to_tip(&result));
    // Sharper ones that were cut off were left to rung 3, with a hundred irregular vertices.
    assert!(result.rung() <= 2 && result.quality.irregular <= 20, "{:?}", result.quality);
    // Three quads share the angle around the tip: all corners there are near to what that leaves them.
    let third = TAU * half_angle.sin() / 3.0;
    assert!(result.quality.scaled_jacobian_min > 0.7 * third.sin(), "{:?}", result.quality);
}

#[test]
fn quads_that_are_no_good_are_taken_back_and_no_others() {
    let (mesh, context) = (grid(4), Context::new());
    let source = Source::new(&mesh, &FeatureOptions::default(), &context).unwrap();
    let at = |k: u32| DVec3::new(f64::from(k % 5), f64::from(k / 5), 0.0);
    let mut work = Work {
        points: (0..25).map(at).collect(),
        place: vec![Place::Region(0); 25],
        faces: Polygons::new(),
        region: vec![0; 16],
        features: Vec::new(),
    };
    (0..16u32).map(|q| q / 4 * 5 + q % 4).for_each(|v| work.faces.push(&[v, v + 1, v + 6, v + 5]));
    let before = work.points.clone();
    // One vertex across its quad, another one a little.
    work.points[6] = DVec3::new(2.5, 2.5, 0.0);
    work.points[18] += DVec3::new(0.1, 0.0, 0.0);
    let little = work.points[18];
    assert!(validate::faults(&work, &source).next().is_some());
    take_back(&mut work, &before, &source);
    assert!(validate::faults(&work, &source).next().is_none());
    assert_eq!((work.points[6], work.points[18]), (before[6], little));
}

#[test]
fn a_ribbon_is_divided_across_alone() {
    // As many squares as are asked for would be thousands of times shorter than it is.
    let n = 12;
    let points: Vec<DVec3> = (0..=n).flat_map(|k| [0.0, 1e-4].map(|y| DVec3::new(f64::from(k), y, 0.0))).collect();
    let faces: Vec<[u32; 3]> =
        (0..n).flat_map(|k| [[2 * k, 2 * k + 2, 2 * k + 3], [2 * k, 2 * k + 3, 2 * k + 1]]).collect();
    let ribbon = SurfaceMesh::from_triangles(points, &faces).unwrap();
    let result = quads(&ribbon, &QuadOptions { quads: 50, ..QuadOptions::default() }, &Context::new()).unwrap();
    check(&ribbon, &result);
    assert!(result.rung() == 1 && off(result.mesh.face_count(), 50) < NUMBER_WITHIN, "{:?}", result.rungs);
}

#[test]
fn folded_polygons_are_told_as_far_as_the_farther_of_their_surfaces() {
    assert!(other_triangles(&grid(3)).unwrap().is_none());
    // The first triangle of the fan is flat, so that ears are taken; its last one is turned over: a surface of its own.
    let hook = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.5, 0.2]].map(|[x, y]| DVec3::new(x, y, 0.0));
    let mut faces = Polygons::new();
    faces.push(&[0, 1, 2, 3, 4]);
    let hook = SurfaceMesh::new(hook.to_vec(), faces).unwrap();
    let fans = other_triangles(&hook).unwrap().unwrap();
    let options = QuadOptions { quads: 60, ..QuadOptions::default() };
    let made = quads(&hook, &options, &Context::new()).unwrap();
    let own = compare(&fans, &made.mesh.triangulated().unwrap(), &DistanceOptions::default(), &Context::new()).unwrap();
    assert!(made.quality.distance_max.unwrap() >= own.relative.max, "{:?}", own.relative);
    assert!(made.quality.distance_found.unwrap() >= 0.99 * own.relative.max, "{:?}", own.relative);
    assert!(own.relative.max > 0.1);
}

/// Over its area a surface is as long as it likes: numbers of quads along it stay within bounds.
#[test]
fn a_vertex_far_away_leaves_no_number_out_of_range() {
    let at = |k: u32| DVec3::new(f64::from(k % 4) / 1.5 - 1.0, f64::from(k / 4) / 1.5 - 1.0, 0.0);
    let saddle = |p: DVec3| p.with_z(0.6 * (p.x * p.x - p.y * p.y));
    let cells = (0..9u32).map(|k| 4 * (k / 3) + k % 3);
    let faces: Vec<[u32; 3]> = cells.flat_map(|k| [[k, k + 1, k + 5], [k, k + 5, k + 4]]).collect();
    for far in [1e20, 1e100, 1e290] {
        let mut points: Vec<DVec3> = (0..16).map(at).map(saddle).collect();
        points[8] *= far;
        let mesh = SurfaceMesh::from_triangles(points, &faces).unwrap();
        for count in [10, 38, 1000] {
            let options = QuadOptions { quads: count, ..QuadOptions::default() };
            match quads(&mesh, &options, &Context::new()) {
                Ok(result) => assert!(result.mesh.faces().iter().all(|f| f.len() == 4)),
                Err(e) => assert!([3, 4].contains(&e.exit_code()), "{far}: {e}"),
            }
        }
    }
}

/// A ball with a rough skin bends everywhere: following it closely would take many times the quads that were asked for.
#[test]
fn a_rough_skin_is_followed_less_closely_on_rung_3() {
    let ball = sample::make("icosphere", Some(40), &Context::new()).unwrap();
    let mut random = sample::random::Random::new(5);
    let rough = ball.points().iter().map(|p| *p * (1.0 + 0.01 * random.symmetric())).collect();
    let mesh = SurfaceMesh::new(rough, ball.faces().clone()).unwrap();
    let options = QuadOptions {
        features: FeatureOptions { angle_deg: None, ..FeatureOptions::default() },
        quads: 400,
        rung: 3,
        ..QuadOptions::default()
    };
    let result = quads(&mesh, &options, &Context::new()).unwrap();
    check(&mesh, &result);
    assert!(result.rung() == 3 && (360..=600).contains(&result.mesh.face_count()), "{}", result.mesh.face_count());
}

#[test]
fn no_rung_after_the_last_one_is_tried() {
    let context = Context::new();
    let mesh = sample::make("bracket", None, &context).unwrap();
    let made = |rung, last_rung| {
        quads(&mesh, &QuadOptions { quads: 900, rung, last_rung, ..QuadOptions::default() }, &context)
    };
    assert_eq!(made(1, 1).unwrap().rung(), 1);
    // The second rung is none any more.
    assert!(matches!(made(2, 2), Err(Error::Numeric(_))));
    assert!(matches!(made(3, 2), Err(Error::Options(_))));
}
