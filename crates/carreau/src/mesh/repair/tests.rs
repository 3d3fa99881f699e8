use super::*;
use crate::context::Context;
use crate::error::Error;
use crate::length::Length;
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::test_models::*;
use crate::mesh::topology::Topology;
use crate::mesh::{Column, FaceId, Polygons, TaggedEdge, VertexId, area_vector};
use glam::DVec3;
use proptest::prelude::*;

fn repaired(mesh: &SurfaceMesh) -> Repaired {
    repair(mesh, &RepairOptions::default(), &Context::new()).unwrap()
}

fn off() -> RepairOptions {
    RepairOptions {
        weld: None,
        degenerate: false,
        duplicates: false,
        orient: false,
        split: false,
        outward: false,
        unreferenced: false,
    }
}

fn same(a: &SurfaceMesh, b: &SurfaceMesh) -> bool {
    a.points() == b.points()
        && a.faces() == b.faces()
        && a.tagged_edges == b.tagged_edges
        && a.attributes == b.attributes
}

fn is_clean(t: &Topology) -> bool {
    let defects = [t.degenerate_faces, t.duplicate_faces, t.unreferenced_vertices, t.inverted_components];
    t.manifold && defects == [0; 4] && (t.consistently_oriented || !t.orientable)
}

/// Every triangle with corners of its own.
fn soup_of(mesh: &SurfaceMesh) -> SurfaceMesh {
    let points: Vec<DVec3> = mesh.faces().corners().iter().map(|&v| mesh.points()[v as usize]).collect();
    let faces: Vec<[u32; 3]> = (0..points.len() as u32 / 3).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
    triangles(&points, &faces)
}

#[test]
fn a_sound_mesh_stays_as_it_is() {
    for mesh in [tetrahedron(), cube(DVec3::ZERO, 2.0), torus(9, 7), grid(4), strip(12, 0), sphere(2)] {
        let result = repaired(&mesh);
        assert!(same(&result.mesh, &mesh));
        assert_eq!(result.report.before, result.report.after);
    }
}

#[test]
fn welding_everything_into_one_vertex_is_refused() {
    let mesh = cube(DVec3::ZERO, 1.0);
    let options = RepairOptions { weld: Some(Length::OfDiagonal(1.0)), ..RepairOptions::default() };
    let found = repair(&mesh, &options, &Context::new());
    assert!(matches!(found, Err(Error::Input { .. })));
}

#[test]
fn nothing_is_done_with_every_step_off() {
    let mesh = together(&[soup_of(&torus(5, 4)), cubes_sharing_an_edge(), turned(&tetrahedron(), |_| true)]);
    assert!(same(&repair(&mesh, &off(), &Context::new()).unwrap().mesh, &mesh));
}

#[test]
fn a_triangle_soup_becomes_a_closed_surface() {
    let mesh = torus(16, 9);
    let result = repaired(&soup_of(&mesh));
    assert_eq!(result.report.after.genus, Some(1));
    assert!(result.report.after.closed && is_clean(&result.report.after));
    assert_eq!(result.report.welded_vertices, mesh.corner_count() - mesh.vertex_count());
}

#[test]
fn noise_is_welded_with_a_tolerance() {
    let mut k = 0.0;
    let noisy = moved(&soup_of(&torus(16, 9)), |p| {
        k += 1.0;
        p + 1e-7 * DVec3::new(f64::sin(k), f64::cos(3.0 * k), f64::sin(5.0 * k))
    });
    assert!(!repaired(&noisy).report.after.closed);
    let with = |tolerance| RepairOptions { weld: Some(tolerance), ..RepairOptions::default() };
    for tolerance in [Length::Absolute(1e-5), Length::OfDiagonal(1e-6)] {
        let result = repair(&noisy, &with(tolerance), &Context::new()).unwrap();
        assert_eq!((result.report.after.closed, result.report.after.genus), (true, Some(1)));
    }
    for wrong in [-1.0, f64::NAN, f64::INFINITY] {
        let result = repair(&noisy, &with(Length::Absolute(wrong)), &Context::new());
        assert!(matches!(result, Err(Error::Options(_))));
    }
}

#[test]
fn repeated_corners_go_and_the_rest_of_the_face_stays() {
    let points: Vec<DVec3> = (0..6).map(|k| DVec3::new(f64::from(k), f64::from(k * k), 0.0)).collect();
    let cases: [(&[u32], &[&[u32]]); 6] = [
        (&[0, 1, 1, 2], &[&[0, 1, 2]]),
        (&[0, 1, 2, 0], &[&[0, 1, 2]]),
        (&[0, 1, 0], &[]),
        (&[3, 3, 3, 3], &[]),
        (&[0, 1, 2, 0, 3, 4], &[&[0, 1, 2], &[0, 3, 4]]),
        (&[0, 1, 2, 3, 2, 1], &[]),
    ];
    for (face, expected) in cases {
        let mesh = SurfaceMesh::new(points.clone(), [face].into_iter().collect()).unwrap();
        let options = RepairOptions { degenerate: true, ..off() };
        let result = repair(&mesh, &options, &Context::new()).unwrap();
        assert_eq!(result.mesh.faces(), &expected.iter().copied().collect::<Polygons>(), "{face:?}");
        assert_eq!(result.report.collapsed_faces, 1);
    }
}

/// A unit square with a vertex on its diagonal's middle, hanging in one cap triangle.
///
/// ```text
/// 3───────2
/// │  ╲4 ╱ │     the cap (0, 2, 4) lies on the diagonal 0-2; 4 is its apex
/// │   ╳   │
/// 0───────1
/// ```
fn square_with_cap() -> SurfaceMesh {
    let p = [(0., 0., 0.), (1., 0., 0.), (1., 1., 0.), (0., 1., 0.), (0.5, 0.5, 0.)].map(DVec3::from);
    triangles(&p, &[[0, 1, 2], [0, 2, 4], [0, 4, 3], [4, 2, 3]])
}

#[test]
fn caps_are_flipped_and_leave_no_crack() {
    let mesh = square_with_cap();
    assert_eq!(Topology::of(&mesh).places.degenerate_faces, [FaceId(1)]);
    let result = repaired(&mesh);
    assert_eq!((result.report.flipped_edges, result.report.dropped_faces), (1, 0));
    let after = &result.report.after;
    assert_eq!((after.faces, after.boundary_edges, after.boundary_loops, after.degenerate_faces), (4, 4, 1, 0));
    let area: f64 = result.mesh.faces().iter().map(|f| area_vector(result.mesh.points(), f).z).sum();
    assert!((area - 1.0).abs() < 1e-12);
}

#[test]
fn a_row_of_caps_is_flipped_one_after_the_other() {
    // A fan from vertex 1 to many collinear points on the edge 0-2: each cap hangs on the one before.
    let n = 12u32;
    let on_edge = (1..n).map(|k| DVec3::new(f64::from(k) / f64::from(n), 0.0, 0.0));
    let points: Vec<DVec3> = [DVec3::ZERO, DVec3::Y, DVec3::X].into_iter().chain(on_edge).collect();
    let mut faces = vec![[0, 2, 1]];
    let last = n + 1;
    faces.push([0, last, 2]);
    faces.extend((4..=last).map(|k| [0, k - 1, k]));
    // Below, a proper fan to the points, so that the whole is one disc.
    let below = points.len() as u32;
    let points = [&points[..], &[DVec3::NEG_Y]].concat();
    faces.push([0, below, 3]);
    faces.extend((4..=last).map(|k| [k - 1, below, k]));
    faces.push([last, below, 2]);
    let mesh = triangles(&points, &faces);
    assert_eq!(Topology::of(&mesh).degenerate_faces, n as usize - 1);
    let after = repaired(&mesh).report.after;
    assert_eq!((after.degenerate_faces, after.boundary_edges, after.faces), (0, 4, mesh.face_count()));
    assert!(is_clean(&after));
}

#[test]
fn needles_are_collapsed_and_leave_no_crack() {
    // Vertex 0 of a sphere is doubled, and the two needles between the copies are there.
    let mesh = sphere(1);
    let ring: Vec<usize> = (0..mesh.face_count()).filter(|&f| mesh.face(FaceId::new(f)).contains(&0)).collect();
    let copy = mesh.vertex_count() as u32;
    let mut points = mesh.points().to_vec();
    points.push(points[0] + DVec3::splat(1e-14));
    let mut faces: Vec<[u32; 3]> = mesh.faces().iter().map(|f| [f[0], f[1], f[2]]).collect();
    let after_0 = |f: usize| faces[f][(faces[f].iter().position(|&v| v == 0).unwrap() + 1) % 3];
    let before_0 = |f: usize| faces[f][(faces[f].iter().position(|&v| v == 0).unwrap() + 2) % 3];
    let first = ring[0];
    let second = *ring.iter().find(|&&f| after_0(f) == before_0(first)).unwrap();
    let (a, b) = (after_0(first), before_0(second));
    for f in [first, second] {
        faces[f].iter_mut().filter(|v| **v == 0).for_each(|v| *v = copy);
    }
    faces.extend([[0, a, copy], [0, copy, b]]);
    let cracked = triangles(&points, &faces);
    let before = Topology::of(&cracked);
    assert_eq!((before.closed, before.degenerate_faces), (true, 2));
    let result = repaired(&cracked);
    assert_eq!((result.report.merged_vertices, result.report.dropped_faces), (1, 0));
    assert!(result.report.after.closed && is_clean(&result.report.after));
    assert_eq!(result.mesh.vertex_count(), mesh.vertex_count());
    assert_eq!(result.mesh.face_count(), mesh.face_count());
}

#[test]
fn a_small_detail_of_a_large_model_is_not_degenerate() {
    let detail = moved(&sphere(2), |p| 1e-6 * p);
    let mesh = together(&[sphere(2), moved(&detail, |p| p + 3.0 * DVec3::X)]);
    assert!(Topology::of(&mesh).degenerate_faces > 0);
    assert!(same(&repaired(&mesh).mesh, &mesh));
}

#[test]
fn scale_does_not_make_faces_degenerate() {
    for scale in [1e-310, 1e-160, 1e160] {
        let mesh = moved(&torus(9, 7), |p| p * scale);
        assert_eq!(repaired(&mesh).mesh.faces(), mesh.faces(), "{scale}");
    }
}

#[test]
fn one_of_several_equal_faces_stays() {
    let mesh = sphere(1);
    let mut faces = mesh.faces().clone();
    for f in [3, 17, 17, 40] {
        let f = mesh.face(FaceId(f)).to_vec();
        faces.push(&[f[1], f[2], f[0]]);
        faces.push(&[f[2], f[1], f[0]]);
    }
    let result = repaired(&SurfaceMesh::new(mesh.points().to_vec(), faces).unwrap());
    assert!(same(&result.mesh, &mesh));
    assert_eq!(result.report.dropped_duplicates, 8);
}

#[test]
fn the_majority_decides_the_sense() {
    let mesh = grid(6);
    let result = repaired(&turned(&mesh, |f| f % 5 == 1));
    assert_eq!(result.report.turned_faces, (0..mesh.face_count()).filter(|f| f % 5 == 1).count());
    assert!(result.mesh.faces().iter().all(|f| area_vector(result.mesh.points(), f).z > 0.0));
}

#[test]
fn closed_components_look_outward_and_cavities_inward() {
    let ball = |r: f64| moved(&sphere(1), |p| p * r);
    let volume = |mesh: &SurfaceMesh| Topology::of(mesh).volume.unwrap();
    let (outer, inner) = (volume(&ball(3.0)), volume(&ball(1.0)));
    for (a, b) in [(true, true), (true, false), (false, true), (false, false)] {
        let result = repaired(&together(&[turned(&ball(1.0), |_| a), turned(&ball(3.0), |_| b)]));
        assert!((result.report.after.volume.unwrap() - (outer - inner)).abs() < 1e-9);
        assert_eq!(result.report.turned_components, usize::from(!a) + usize::from(b));
    }
}

#[test]
fn touching_bodies_come_apart() {
    for mesh in [cubes_sharing_an_edge(), cubes_sharing_a_vertex()] {
        let result = repaired(&mesh);
        let after = &result.report.after;
        assert!(is_clean(after) && after.closed, "{after:?}");
        assert_eq!((after.components, after.genus, result.mesh.vertex_count()), (2, Some(0), 16));
        assert!((after.volume.unwrap() - 2.0).abs() < 1e-12);
    }
}

/// Two bodies with a common face, every triangle with corners of its own, as an STL file has them.
#[test]
fn bodies_in_contact_are_closed_and_keep_their_names() {
    let boxes = together(&[cube(DVec3::ZERO, 1.0), cube(DVec3::X, 1.0)]).triangulated().unwrap();
    let half = boxes.face_count() / 2;
    for turn in [false, true] {
        let mut mesh = soup_of(&turned(&boxes, |f| turn && f < half));
        let labels = (0..2 * half).map(|f| i32::from(f >= half)).collect();
        mesh.attributes.face.insert("solid".into(), Column::Label(labels));
        let result = repaired(&mesh);
        let after = &result.report.after;
        assert!(is_clean(after) && after.closed && after.components == 2, "{after:?}");
        assert!((after.volume.unwrap() - 2.0).abs() < 1e-12);
        assert_eq!(result.mesh.vertex_count(), boxes.vertex_count());
        let Column::Label(labels) = &result.mesh.attributes.face["solid"] else { panic!("labels") };
        let of_body = |f: usize| result.mesh.face(FaceId::new(f)).iter().all(|&v| (v < 8) == (labels[f] == 0));
        assert!((0..2 * half).all(of_body));
    }
}

#[test]
fn three_sheets_on_an_edge_are_cut() {
    let p = [DVec3::ZERO, DVec3::Z, DVec3::X, DVec3::new(-1., 1., 0.), DVec3::new(-1., -1., 0.)];
    let result = repaired(&triangles(&p, &[[0, 1, 2], [0, 1, 3], [0, 1, 4]]));
    assert_eq!((result.report.after.components, result.report.split_vertices), (3, 4));
    assert!(is_clean(&result.report.after));
}

#[test]
fn one_sided_surfaces_are_reported() {
    let result = repaired(&strip(12, 1));
    let after = &result.report.after;
    assert!(!after.orientable && after.manifold && after.inconsistent_edges > 0);
    assert_eq!(after.boundary_loops, 1);
    assert!(result.report.sentences().iter().any(|s| s.contains("only one side")));
}

#[test]
fn attributes_and_tagged_edges_follow() {
    let mut mesh = together(&[moved(&tetrahedron(), |p| p + 9.0 * DVec3::X), cubes_sharing_an_edge()]);
    let unused = mesh.vertex_count();
    let (points, mut faces, _, _) = mesh.into_parts();
    faces.push(&[1, 2, 0]);
    mesh = SurfaceMesh::new(points, faces).unwrap();
    let label = |n: usize| Column::Label((0..n as i32).collect());
    mesh.attributes.vertex.insert("id".into(), label(mesh.vertex_count()));
    mesh.attributes.face.insert("id".into(), label(mesh.face_count()));
    mesh.attributes.corner.insert("id".into(), label(mesh.corner_count()));
    let edge = Topology::of(&mesh).places.nonmanifold_edges.iter().find(|e| e[0].0 >= 4).copied().unwrap();
    mesh.tagged_edges =
        vec![TaggedEdge { ends: edge, tag: 7 }, TaggedEdge { ends: [VertexId(0), VertexId(1)], tag: 8 }];
    mesh = {
        let mut turned = turned(&mesh, |f| f == 5);
        turned.attributes = mesh.attributes.clone();
        turned.tagged_edges = mesh.tagged_edges.clone();
        turned
    };
    let out = repaired(&mesh).mesh;
    assert_eq!(out.face_count(), mesh.face_count() - 1);
    let ids = |columns: &crate::mesh::Columns| match &columns["id"] {
        Column::Label(ids) => ids.iter().map(|&k| k as usize).collect::<Vec<_>>(),
        other => panic!("{other:?}"),
    };
    let sources = ids(&out.attributes.vertex);
    assert!(sources.iter().zip(out.points()).all(|(&v, p)| mesh.points()[v] == *p && v < unused));
    for (c, source) in ids(&out.attributes.corner).into_iter().enumerate() {
        assert_eq!(sources[out.faces().corners()[c] as usize], mesh.faces().corners()[source] as usize);
    }
    for (face, source) in out.faces().iter().zip(ids(&out.attributes.face)) {
        let mut a: Vec<_> = face.iter().map(|&v| sources[v as usize] as u32).collect();
        let mut b = mesh.faces().face(source).to_vec();
        a.sort_unstable();
        b.sort_unstable();
        assert_eq!(a, b);
    }
    let half_edges = out.half_edges();
    assert_eq!(out.tagged_edges.iter().map(|e| e.tag).collect::<Vec<_>>(), [7, 7, 8]);
    assert!(out.tagged_edges.iter().all(|e| half_edges.find(e.ends[0].0, e.ends[1].0).is_some()));
}

#[test]
fn a_deadline_stops_the_repair() {
    let late = Context::new().with_deadline(std::time::Instant::now());
    assert!(matches!(repair(&torus(5, 5), &RepairOptions::default(), &late), Err(Error::Deadline)));
}

/// Faces of three or four corners on few points, some of them at one place.
fn any_mesh() -> impl Strategy<Value = SurfaceMesh> {
    let face = prop::collection::vec(0u32..12, 3..5);
    prop::collection::vec(face, 1..30).prop_map(|faces| {
        let coordinate = |k: u32, m: u32| f64::from(k * m % 7);
        let points =
            (0..12u32).map(|k| k.min(9)).map(|k| DVec3::new(coordinate(k, 1), coordinate(k, 3), coordinate(k * k, 2)));
        SurfaceMesh::new(points.collect(), faces.iter().map(|f| &f[..]).collect()).unwrap()
    })
}

proptest! {
    #[test]
    fn whatever_comes_leaves_as_manifold_sheets(mesh in any_mesh()) {
        let result = repaired(&mesh);
        prop_assert!(is_clean(&result.report.after), "{:?}", result.report);
        prop_assert!(result.report.after.nonmanifold_vertices == 0);
    }

    #[test]
    fn a_second_repair_changes_nothing(mesh in any_mesh()) {
        let once = repaired(&mesh).mesh;
        let twice = repaired(&once);
        prop_assert!(same(&once, &twice.mesh), "{:?}\n{:?}\n{:?}", once.faces(), twice.mesh.faces(), twice.report);
    }
}
