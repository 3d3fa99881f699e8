//! Tables of small surfaces.

use super::*;

/// Two triangles and a quad in a row, the second triangle shared by both.
///
/// ```text
/// 3───2───5
/// │ ╱ │   │
/// 0───1───4
/// ```
fn strip() -> SurfaceMesh {
    let points = [(0, 0), (1, 0), (1, 1), (0, 1), (2, 0), (2, 1)];
    let points = points.iter().map(|&(x, y)| DVec3::new(f64::from(x), f64::from(y), 0.0)).collect();
    let faces: Polygons = [&[0, 1, 2][..], &[0, 2, 3], &[1, 4, 5, 2]].into_iter().collect();
    SurfaceMesh::new(points, faces).unwrap()
}

#[test]
fn opposite_is_an_involution_between_reversed_half_edges() {
    let mesh = strip();
    let mut inner = 0;
    for c in (0..mesh.corner_count()).map(CornerId::new) {
        assert_eq!(mesh.next(mesh.previous(c)), c);
        if let Some(o) = mesh.opposite(c) {
            inner += 1;
            assert_eq!(mesh.opposite(o), Some(c));
            assert_eq!(mesh.vertex(c), mesh.vertex(mesh.next(o)));
            assert_eq!(mesh.vertex(o), mesh.vertex(mesh.next(c)));
            assert_ne!(mesh.face_of(c), mesh.face_of(o));
        }
    }
    assert_eq!(inner, 4);
}

#[test]
fn cut_polygons_keep_order_and_parents() {
    let mut mesh = strip();
    mesh.attributes.face.insert("id".into(), crate::mesh::Column::Label(vec![7, 8, 9]));
    let mesh = mesh.triangulated().unwrap();
    assert_eq!(mesh.face_count(), 4);
    assert_eq!(mesh.face(FaceId(3)), [1, 5, 2]);
    assert_eq!(mesh.attributes.face["id"], crate::mesh::Column::Label(vec![7, 8, 9, 9]));
}

#[test]
fn irregular_edges_have_no_opposite() {
    let points = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, -DVec3::Y];
    let fan = SurfaceMesh::from_triangles(points.clone(), &[[0, 1, 2], [1, 0, 3], [0, 1, 4]]).unwrap();
    assert_eq!(fan.side(CornerId(0)), Side::NonManifold);
    let same = SurfaceMesh::from_triangles(points, &[[0, 1, 2], [0, 1, 3]]).unwrap();
    assert_eq!(same.side(CornerId(0)), Side::Inconsistent);
    assert_eq!(same.side(CornerId(1)), Side::Border);
}

#[test]
fn bad_input_is_refused_with_its_place() {
    let points = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
    let message = |r: Result<SurfaceMesh>| r.err().map(|e| e.to_string()).unwrap_or_default();
    assert!(message(SurfaceMesh::from_triangles(points.clone(), &[[0, 1, 3]])).contains("face 0"));
    let nan = vec![DVec3::ZERO, DVec3::NAN, DVec3::Y];
    assert!(message(SurfaceMesh::from_triangles(nan, &[[0, 1, 2]])).contains("vertex 1"));
    assert!(message(SurfaceMesh::new(points, [&[0u32, 1][..]].into_iter().collect())).contains("2 corners"));
}
