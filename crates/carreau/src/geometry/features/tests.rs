//! Features of solids and roofs.

use super::*;
use crate::mesh::test_models::*;
use glam::DVec3;
use proptest::prelude::*;

fn with_angle(angle: f64) -> FeatureOptions {
    FeatureOptions { angle_deg: Some(angle), ..FeatureOptions::default() }
}

fn count(mesh: &SurfaceMesh, options: &FeatureOptions) -> usize {
    let features = feature_edges(mesh, options).unwrap();
    for c in (0..mesh.corner_count()).map(CornerId::new) {
        assert!(mesh.opposite(c).is_none_or(|o| features.contains(o) == features.contains(c)));
    }
    features.edges(mesh).count()
}

/// A roof: two rectangles that meet at the angle.
fn roof(turn_deg: f64) -> SurfaceMesh {
    let (sin, cos) = turn_deg.to_radians().sin_cos();
    let p = [DVec3::ZERO, DVec3::Y, DVec3::NEG_X, DVec3::new(-1., 1., 0.), DVec3::new(cos, 0., -sin)];
    let far = DVec3::new(cos, 1.0, -sin);
    triangles(&[&p[..], &[far]].concat(), &[[2, 0, 1], [2, 1, 3], [0, 4, 5], [0, 5, 1]])
}

#[test]
fn a_cube_has_twelve_sharp_edges_and_no_sharp_diagonal() {
    let mesh = cube(DVec3::ZERO, 3.0).triangulated().unwrap();
    assert_eq!(count(&mesh, &with_angle(35.0)), 12);
    assert_eq!(count(&mesh, &with_angle(90.0)), 0);
    assert_eq!(count(&mesh, &with_angle(89.9)), 12);
    assert_eq!(count(&mesh, &FeatureOptions { angle_deg: None, ..FeatureOptions::default() }), 0);
}

#[test]
fn borders_tags_lists_and_irregular_edges_count_as_asked() {
    let mut mesh = grid(3);
    let none = FeatureOptions { angle_deg: None, borders: false, tags: false, ..FeatureOptions::default() };
    assert_eq!(count(&mesh, &none), 0);
    assert_eq!(count(&mesh, &FeatureOptions { borders: true, ..none.clone() }), 12);
    let inner = [VertexId(5), VertexId(6)];
    mesh.tagged_edges = vec![TaggedEdge { ends: inner, tag: 1 }];
    assert_eq!(count(&mesh, &none), 0);
    assert_eq!(count(&mesh, &FeatureOptions { tags: true, ..none.clone() }), 1);
    let listed = FeatureOptions { edges: vec![[inner[1], inner[0]], [VertexId(0), VertexId(900)]], ..none.clone() };
    assert_eq!(count(&mesh, &listed), 1);
    assert_eq!(feature_edges(&mesh, &listed).unwrap().missing, [[VertexId(0), VertexId(900)]]);
    assert_eq!(count(&cubes_sharing_an_edge(), &none), 1);
    assert_eq!(count(&strip(9, 1), &none), 1);
}

#[test]
fn angles_out_of_range_are_refused() {
    for wrong in [-1.0, 181.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(feature_edges(&grid(1), &with_angle(wrong)), Err(crate::Error::Options(_))));
    }
}

proptest! {
    #[test]
    fn the_turn_is_measured_with_its_sign(angle in -179.9f64..179.9) {
        let mesh = roof(angle);
        let normals = face_normals(&mesh);
        for (c, _) in mesh.faces().corners().iter().enumerate() {
            let Some(found) = dihedral_turn(&mesh, &normals, CornerId::new(c)) else { continue };
            let ridge = [c, mesh.next(CornerId::new(c)).index()].iter().all(|&c| mesh.faces().corners()[c] < 2);
            let expected = if ridge { angle } else { 0.0 };
            prop_assert!((found.to_degrees() - expected).abs() < 1e-9, "{} {}", found.to_degrees(), expected);
        }
    }

    #[test]
    fn tiny_turns_are_measured_exactly(exponent in -12.0f64..0.0) {
        let angle = 10f64.powf(exponent);
        let mesh = roof(angle);
        let ridge = (0..12).map(CornerId).find(|&c| mesh.vertex(c).0 == 0 && mesh.vertex(mesh.next(c)).0 == 1);
        let found = dihedral_turn(&mesh, &face_normals(&mesh), ridge.unwrap()).unwrap().to_degrees();
        prop_assert!((found / angle - 1.0).abs() < 1e-3, "{} {}", found, angle);
    }
}
