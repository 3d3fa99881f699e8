//! Topology of surfaces that are known.

use super::*;
use crate::mesh::Polygons;
use crate::mesh::test_models::*;
use glam::DVec3;
use proptest::prelude::*;

/// All numbers of defects, in the order of the struct.
fn defects(t: &Topology) -> [usize; 10] {
    [
        t.boundary_loops,
        t.boundary_edges,
        t.nonmanifold_edges,
        t.nonmanifold_vertices,
        t.inconsistent_edges,
        t.degenerate_faces,
        t.duplicate_faces,
        t.coincident_vertices,
        t.unreferenced_vertices,
        t.inverted_components,
    ]
}

fn is_clean_and_closed(t: &Topology) -> bool {
    t.closed && t.manifold && t.orientable && t.consistently_oriented && defects(t) == [0; 10]
}

#[test]
fn closed_surfaces_have_their_genus_and_volume() {
    for (mesh, genus, volume) in [
        (tetrahedron(), 0, 8.0 / 3.0),
        (cube(DVec3::splat(1e6), 2.0), 0, 8.0),
        (torus(60, 30), 1, 2.0 * 0.25 * std::f64::consts::PI.powi(2) * 2.0),
    ] {
        let t = Topology::of(&mesh);
        assert!(is_clean_and_closed(&t), "{t:?}");
        assert_eq!((t.components, t.genus), (1, Some(genus)));
        assert_eq!(t.euler, 2 - 2 * genus as i64);
        assert!((t.volume.unwrap() / volume - 1.0).abs() < 0.02, "{:?} {volume}", t.volume);
        assert_eq!(t.places, Places::default());
    }
}

#[test]
fn faces_are_counted_by_size() {
    let pentagon: Polygons = [&[0u32, 1, 2, 3, 4][..], &[0, 1, 5], &[1, 2, 6, 5]].into_iter().collect();
    let points = (0..7).map(|k| DVec3::new(f64::from(k), f64::from(k * k), f64::from(k % 2))).collect();
    let t = Topology::of(&SurfaceMesh::new(points, pentagon).unwrap());
    assert_eq!((t.faces, t.triangles, t.quads, t.polygons, t.edges), (3, 1, 1, 1, 5 + 2 + 2));
}

#[test]
fn holes_are_loops_with_their_length() {
    let n = 6;
    let cell = |i: usize, j: usize| [2 * (i * n + j), 2 * (i * n + j) + 1];
    let apart = without(&grid(n as u32), &[cell(1, 1), cell(3, 4)].concat());
    let t = Topology::of(&apart);
    assert_eq!((t.boundary_loops, t.boundary_edges, t.genus), (3, 4 * n + 8, Some(0)));
    assert!(t.manifold && !t.closed);
    assert_eq!(t.places.boundary_loops[0], BoundaryLoop { start: VertexId(0), edges: 4 * n, length: 4.0 * n as f64 });
    assert_eq!(t.places.boundary_loops[1].length, 4.0);
    assert_eq!(t.places.boundary_edges.len(), PLACES);

    let touching = Topology::of(&without(&grid(n as u32), &[cell(1, 1), cell(2, 2)].concat()));
    assert_eq!(touching.nonmanifold_vertices, 1);
    assert_eq!(touching.places.nonmanifold_vertices, [VertexId(2 * (n as u32 + 1) + 2)]);
}

#[test]
fn one_sided_surfaces_are_not_orientable() {
    for half_turns in 0..4 {
        let t = Topology::of(&strip(12, half_turns));
        let one_sided = half_turns % 2 == 1;
        assert_eq!((t.orientable, t.consistently_oriented), (!one_sided, !one_sided));
        assert_eq!(t.boundary_loops, if one_sided { 1 } else { 2 });
        assert_eq!(t.genus, (!one_sided).then_some(0));
        assert_eq!((t.components, t.euler, t.manifold), (1, 0, true));
        assert_eq!(t.require_consistent_orientation().is_err(), one_sided);
    }
}

#[test]
fn bodies_that_touch_are_not_manifold() {
    let edge = Topology::of(&cubes_sharing_an_edge());
    assert_eq!((edge.components, edge.nonmanifold_edges, edge.nonmanifold_vertices), (1, 1, 2));
    assert!(!edge.manifold && !edge.closed && edge.genus.is_none());
    let message = edge.require_manifold().unwrap_err().to_string();
    let [a, b] = edge.places.nonmanifold_edges[0];
    assert!(message.contains(&format!("edge {a}-{b}")) && message.contains("repair"), "{message}");

    let vertex = Topology::of(&cubes_sharing_a_vertex());
    assert_eq!((vertex.components, vertex.nonmanifold_edges, vertex.nonmanifold_vertices), (2, 0, 1));
    assert!(!vertex.manifold && vertex.closed && vertex.require_manifold().is_err());
}

#[test]
fn inconsistent_faces_show_at_their_edges() {
    let mesh = turned(&torus(12, 8), |f| f == 40);
    let t = Topology::of(&mesh);
    assert_eq!((t.inconsistent_edges, t.orientable, t.consistently_oriented), (3, true, false));
    assert_eq!(t.genus, Some(1));
    assert!(t.volume.is_none());
    let of_face = |[a, b]: &[VertexId; 2]| [a, b].iter().all(|v| mesh.face(FaceId(40)).contains(&v.0));
    assert!(t.places.inconsistent_edges.iter().all(of_face));
}

#[test]
fn degenerate_and_duplicate_faces_have_their_place() {
    let mut points = tetrahedron().points().to_vec();
    points.extend([DVec3::X * 9.0, points[1], (points[0] + points[1]) / 2.0, DVec3::new(1.0, 1.0, 1.0 + 1e-13)]);
    let mut faces: Vec<[u32; 3]> = vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]];
    faces.extend([[1, 0, 0], [2, 1, 0], [1, 2, 0], [0, 1, 6], [7, 0, 3]]);
    let t = Topology::of(&triangles(&points, &faces));
    assert_eq!(t.places.degenerate_faces, [4, 7, 8].map(FaceId));
    assert_eq!(t.places.duplicate_faces, [[5, 0], [6, 0]].map(|p| p.map(FaceId)));
    assert_eq!(t.places.coincident_vertices, [[VertexId(5), VertexId(1)]]);
    assert_eq!(t.places.unreferenced_vertices, [4, 5].map(VertexId));
    assert!(!t.manifold);
}

#[test]
fn a_repeated_vertex_does_not_disturb_its_neighbours() {
    let clean = Topology::of(&tetrahedron());
    let mut faces = tetrahedron().faces().clone();
    [[0, 1, 1], [2, 2, 2], [3, 0, 3]].iter().for_each(|f| faces.push(f));
    let t = Topology::of(&SurfaceMesh::new(tetrahedron().points().to_vec(), faces).unwrap());
    assert_eq!((t.degenerate_faces, t.nonmanifold_edges, t.closed, t.manifold), (3, 0, true, false));
    assert_eq!((t.edges, t.components, t.euler, t.genus), (clean.edges, 1, 2, Some(0)));
    assert!(t.require_manifold().unwrap_err().to_string().contains("face 4"));
}

#[test]
fn scale_and_place_do_not_matter() {
    for scale in [1e-150, 1e-30, 1e30, 1e150, 1e200] {
        let t = Topology::of(&moved(&torus(12, 8), |p| p * scale));
        assert_eq!((t.degenerate_faces, t.genus, t.closed), (0, Some(1), true), "{scale}");
    }
    // Areas that a double cannot hold are reported: nothing can be computed on such a mesh.
    for scale in [1e-170, 1e-310] {
        let lost = Topology::of(&moved(&torus(12, 8), |p| p * scale));
        assert_eq!(lost.degenerate_faces, lost.faces, "{scale}");
    }
}

#[test]
fn nesting_tells_cavities_from_inverted_bodies() {
    let ball = |radius: f64, outward: bool| turned(&moved(&sphere(1), |p| p * radius), |_| !outward);
    let inverted = |parts: &[SurfaceMesh]| Topology::of(&together(parts)).inverted_components;
    assert_eq!(inverted(&[ball(1.0, true)]), 0);
    assert_eq!(inverted(&[ball(1.0, false)]), 1);
    assert_eq!(inverted(&[ball(2.0, true), ball(1.0, false)]), 0);
    assert_eq!(inverted(&[ball(1.0, true), ball(2.0, true)]), 1);
    assert_eq!(inverted(&[ball(3.0, true), ball(2.0, false), ball(1.0, true)]), 0);
    assert_eq!(inverted(&[ball(3.0, false), ball(2.0, true), ball(1.0, false)]), 3);
    let beside = moved(&ball(1.0, true), |p| p + DVec3::X * 1.5);
    assert_eq!(inverted(&[ball(1.0, true), beside]), 0);
    // A ball in the hole of a ring is inside the ring's box, but not inside the ring.
    let in_hole = moved(&sphere(1), |p| p * 0.4);
    assert_eq!(inverted(&[torus(24, 12), in_hole.clone()]), 0);
    let in_tube = moved(&in_hole, |p| p + DVec3::X * 2.0);
    assert_eq!(inverted(&[torus(24, 12), in_tube.clone()]), 1);
    assert_eq!(inverted(&[in_tube, turned(&torus(24, 12), |_| true)]), 2);
}

#[test]
fn an_empty_mesh_is_not_closed() {
    let t = Topology::of(&triangles(&[DVec3::ZERO], &[]));
    assert!(!t.closed && t.components == 0 && t.unreferenced_vertices == 1);
}

#[test]
fn the_record_has_numbers_and_places_under_the_same_names() {
    let t = Topology::of(&cubes_sharing_an_edge());
    let json = serde_json::to_value(&t).unwrap();
    for (name, places) in json["places"].as_object().unwrap() {
        assert!(json[name].as_u64().unwrap() >= places.as_array().unwrap().len() as u64, "{name}");
    }
    assert_eq!(json["nonmanifold_edges"], 1);
    assert_eq!(json["closed"], false);
}

/// A soup of faces on few vertices: every kind of defect appears.
fn any_mesh() -> impl Strategy<Value = (Vec<[u32; 3]>, Vec<usize>, Vec<usize>)> {
    let faces = prop::collection::vec(prop::array::uniform3(0u32..9), 1..24);
    faces.prop_flat_map(|f| {
        let order: Vec<usize> = (0..f.len()).collect();
        (Just(f), Just(order).prop_shuffle(), Just((0..9).collect::<Vec<_>>()).prop_shuffle())
    })
}

proptest! {
    #[test]
    fn renumbering_changes_no_count((faces, order, names) in any_mesh()) {
        let points: Vec<DVec3> =
            (0..9).map(|k| DVec3::new(f64::from(k % 3), f64::from(k * k % 7), f64::from(k * k * k % 5))).collect();
        let mut renamed = points.clone();
        names.iter().zip(&points).for_each(|(&n, &p)| renamed[n] = p);
        let permuted: Vec<_> = order.iter().map(|&f| faces[f].map(|v| names[v as usize] as u32)).collect();
        let mut a = Topology::of(&triangles(&points, &faces));
        let mut b = Topology::of(&triangles(&renamed, &permuted));
        a.places = Places::default();
        b.places = Places::default();
        prop_assert!(a.volume.unwrap_or(0.0) - b.volume.unwrap_or(0.0) < 1e-9);
        (a.volume, b.volume) = (None, None);
        prop_assert_eq!(a, b);
    }
}
