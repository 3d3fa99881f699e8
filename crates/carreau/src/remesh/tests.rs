//! The whole room on models whose surface is known.

use super::search::CLOSE_LOOK;
use super::*;
use crate::geometry::distance::compare;
use crate::geometry::features::{FeatureOptions, feature_edges};
use crate::mesh::Topology;
use crate::sample;

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
    let (mesh, context) = (model("bracket"), Context::new());
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
        let options = FeatureOptions { angle_deg: Some(angle), borders: false, tags: false, edges: Vec::new() };
        feature_edges(m, &options).unwrap().corners
    };
    let marks = sharp(&out, 35.0);
    let half = sharp(&mesh, 17.5);
    let ridge: Vec<[glam::DVec3; 2]> = (0..mesh.corner_count())
        .filter(|&c| half[c])
        .map(CornerId::new)
        .map(|c| [mesh.vertex(c), mesh.vertex(mesh.next(c))].map(|v| mesh.points()[v.index()]))
        .collect();
    let far = |p: glam::DVec3| {
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

#[test]
fn options_out_of_range_are_refused() {
    let mesh = model("torus");
    for deviation in [0.0, -1.0, 90.0, f64::NAN] {
        assert!(matches!(simplify(&mesh, &at(deviation), &Context::new()), Err(Error::Options(_))));
    }
    let options = RemeshOptions { gradation: Some(1.0), ..at(20.0) };
    assert!(matches!(enrich(&mesh, &options, &Context::new()), Err(Error::Options(_))));
}
