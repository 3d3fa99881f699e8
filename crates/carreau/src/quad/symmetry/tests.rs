//! Properties of symmetric quads on made models.

use super::*;
use crate::mesh::test_models::{moved, sphere};
use crate::mesh::{Column, Topology};
use crate::quad::quads;
use crate::sample;
use glam::DQuat;
use std::collections::BTreeSet;

fn part(name: &str) -> SurfaceMesh {
    sample::make(name, None, &Context::new()).unwrap()
}

/// Quads that are the same as their mirror images: every quad has one.
fn check(mesh: &SurfaceMesh, symmetry: Symmetry, planes: usize) {
    let options = QuadOptions { quads: 800, symmetry, ..QuadOptions::default() };
    let result = quads(mesh, &options, &Context::new()).unwrap();
    assert_eq!(result.symmetry.len(), planes, "{:?}", result.warnings);
    let out = &result.mesh;
    let (had, has) = (Topology::of(mesh), Topology::of(out));
    assert_eq!((had.components, had.euler, had.boundary_loops), (has.components, has.euler, has.boundary_loops));
    assert_eq!(has.nonmanifold_edges + has.inconsistent_edges + has.unreferenced_vertices, 0);
    assert!(result.quality.inverted == 0 && result.quality.feature_recall > 0.9995);
    let unit = 1e-9 * mesh.diagonal();
    let key = |p: DVec3| (p / unit / 16.0).round().to_array().map(|x| x as i64);
    let near = |p: DVec3, of: &BTreeSet<[i64; 3]>| {
        let [x, y, z] = key(p);
        (-1..=1).any(|i| (-1..=1).any(|j| (-1..=1).any(|k| of.contains(&[x + i, y + j, z + k]))))
    };
    let centre = |f: &[u32]| f.iter().map(|&v| out.points()[v as usize]).sum::<DVec3>() / 4.0;
    let vertices: BTreeSet<[i64; 3]> = out.points().iter().map(|&p| key(p)).collect();
    let centres: BTreeSet<[i64; 3]> = out.faces().iter().map(|f| key(centre(f))).collect();
    for plane in &result.symmetry {
        assert!(out.points().iter().all(|&p| near(plane.image(p), &vertices)));
        assert!(out.faces().iter().all(|f| near(plane.image(centre(f)), &centres)));
    }
}

#[test]
fn quads_are_the_same_as_their_mirror_images() {
    check(&part("torus"), Symmetry::X, 1);
    check(&part("rounded-box"), Symmetry::Auto, 3);
    check(&part("open-cylinder"), Symmetry::Auto, 3);
}

#[test]
fn symmetry_is_found_however_a_surface_lies() {
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 1.0);
    let box_ = part("rounded-box");
    check(&moved(&box_, |p| turn * p + DVec3::new(5.0, -3.0, 2.0)), Symmetry::Auto, 3);
}

/// A sphere with a bump on one side of x.
fn lopsided() -> SurfaceMesh {
    moved(&sphere(4), |p| if p.x > 0.5 { p * (1.0 + 8.0 * (p.x - 0.5).powi(2)) } else { p })
}

#[test]
fn what_a_surface_does_not_have_is_refused() {
    let options = QuadOptions { quads: 20_000, symmetry: Symmetry::X, ..QuadOptions::default() };
    let found = quads(&lopsided(), &options, &Context::new());
    assert!(matches!(found, Err(Error::Numeric(why)) if why.contains("not symmetric across x")));
    let options = QuadOptions { quads: 800, symmetry: Symmetry::Auto, ..QuadOptions::default() };
    let found = quads(&lopsided(), &options, &Context::new()).unwrap();
    assert!(!found.symmetry.is_empty() && found.symmetry.iter().all(|plane| plane.normal.x.abs() < 0.1));
}

#[test]
fn features_in_a_plane_of_symmetry_are_kept_and_its_cut_is_none() {
    // The ridge of a roof is in the plane across x; its front is flat there.
    let p = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let points = vec![
        p(-1.0, 0.0, 0.0),
        p(1.0, 0.0, 0.0),
        p(0.0, 0.0, 1.0),
        p(-1.0, 3.0, 0.0),
        p(1.0, 3.0, 0.0),
        p(0.0, 3.0, 1.0),
    ];
    let faces = [[0, 1, 2], [3, 5, 4], [0, 2, 5], [0, 5, 3], [1, 4, 5], [1, 5, 2], [0, 3, 4], [0, 4, 1]];
    let mesh = SurfaceMesh::from_triangles(points, &faces).unwrap();
    check(&mesh, Symmetry::X, 1);
    let options = QuadOptions { quads: 800, symmetry: Symmetry::X, ..QuadOptions::default() };
    let found = quads(&mesh, &options, &Context::new()).unwrap().mesh;
    let in_plane = |e: &TaggedEdge| e.ends.iter().all(|&v| found.point(v).x == 0.0);
    let ridge = found.tagged_edges.iter().filter(|e| in_plane(e));
    assert!(ridge.clone().count() > 5 && ridge.clone().all(|e| e.ends.iter().all(|&v| found.point(v).z == 1.0)));
    let Some(Column::Label(regions)) = found.attributes.face.get("region") else { panic!("no regions") };
    assert_eq!(regions.iter().collect::<BTreeSet<_>>().len(), 5);
}
