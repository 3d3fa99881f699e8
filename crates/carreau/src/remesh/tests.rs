//! The whole room on models whose surface is known.

use super::*;
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
fn options_out_of_range_are_refused() {
    let mesh = model("torus");
    for deviation in [0.0, -1.0, 90.0, f64::NAN] {
        assert!(matches!(simplify(&mesh, &at(deviation), &Context::new()), Err(Error::Options(_))));
    }
    let options = RemeshOptions { gradation: Some(1.0), ..at(20.0) };
    assert!(matches!(enrich(&mesh, &options, &Context::new()), Err(Error::Options(_))));
}
