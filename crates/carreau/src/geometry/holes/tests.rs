use super::*;
use crate::mesh::test_models::*;
use crate::mesh::{FaceId, Topology, area_vector};

fn filled(mesh: &SurfaceMesh) -> Filled {
    fill(mesh, None, &Context::new()).unwrap()
}

/// The faces around a vertex.
fn around(mesh: &SurfaceMesh, v: u32) -> Vec<usize> {
    (0..mesh.face_count()).filter(|&f| mesh.face(FaceId::new(f)).contains(&v)).collect()
}

fn is_closed(mesh: &SurfaceMesh) -> bool {
    let t = Topology::of(mesh);
    t.closed && t.manifold && t.consistently_oriented
}

#[test]
fn a_plane_hole_is_filled_in_its_plane() {
    for turn in [0.0, 0.3] {
        let grid = grid(12);
        let inside = |f: usize| {
            grid.face(FaceId::new(f)).iter().all(|&v| (4..=9).contains(&(v / 13)) && (4..=9).contains(&(v % 13)))
        };
        let holed = without(&grid, &(0..grid.face_count()).filter(|&f| inside(f)).collect::<Vec<_>>());
        let holed = moved(&holed, |p| DVec3::new(p.x, p.y, 5.0 + turn * p.x));
        let done = fill(&holed, Some(40), &Context::new()).unwrap();
        assert_eq!((done.holes.len(), done.left), (1, 1));
        let t = Topology::of(&done.mesh);
        assert!(t.manifold && t.consistently_oriented && t.boundary_loops == 1);
        let new = done.holes[0].vertices[0]..done.holes[0].vertices[1];
        assert!(new.len() > 5);
        for v in new {
            let p = done.mesh.points()[v as usize];
            assert!((p.z - 5.0 - turn * p.x).abs() <= if turn == 0.0 { 0.0 } else { 1e-14 });
        }
        let area =
            |mesh: &SurfaceMesh| mesh.faces().iter().map(|f| area_vector(mesh.points(), f).length()).sum::<f64>();
        assert!((area(&done.mesh) - area(&moved(&grid, |p| DVec3::new(p.x, p.y, turn * p.x)))).abs() < 1e-9);
    }
}

#[test]
fn a_hole_in_a_ball_bulges() {
    let ball = sphere(4);
    let gone: Vec<usize> = (0..ball.face_count())
        .filter(|&f| ball.face(FaceId::new(f)).iter().all(|&v| ball.points()[v as usize].z > 0.7))
        .collect();
    let holed = without(&ball, &gone);
    let done = filled(&holed);
    assert!(is_closed(&done.mesh) && done.holes.len() == 1);
    let [from, to] = done.holes[0].vertices;
    let radii = (from..to).map(|v| done.mesh.points()[v as usize].length());
    let (low, high) = radii.fold((f64::INFINITY, 0.0f64), |(l, h), r| (l.min(r), h.max(r)));
    assert!(low > 0.93 && high < 1.07, "{low} to {high}");
    assert_eq!(Topology::of(&done.mesh).genus, Some(0));
    // Triangles are as large as those around.
    let share = (done.holes[0].faces[1] - done.holes[0].faces[0]) as f64 / gone.len() as f64;
    assert!((0.5..2.0).contains(&share), "{share}");
}

#[test]
fn every_hole_of_a_surface_is_filled_and_told() {
    let mesh = torus(24, 12);
    let (a, b) = (around(&mesh, 0), around(&mesh, 100));
    let done = filled(&without(&mesh, &[a, b].concat()));
    assert!(is_closed(&done.mesh));
    assert_eq!(done.holes.iter().map(|h| h.edges).collect::<Vec<_>>(), [6, 6]);
    assert_eq!(done.holes[1].faces[1] as usize, done.mesh.face_count());
    assert_eq!(Topology::of(&done.mesh).genus, Some(1));
    let few = fill(&without(&mesh, &around(&mesh, 0)), Some(5), &Context::new()).unwrap();
    assert_eq!((few.holes.len(), few.left), (0, 1));
}

#[test]
fn tubes_get_lids_and_open_triangles_are_closed_or_left() {
    let tube = without(&torus(40, 16), &(0..400).collect::<Vec<_>>());
    let done = filled(&tube);
    assert!(is_closed(&done.mesh) && done.holes.len() == 2);
    let one = triangles(&[DVec3::ZERO, DVec3::X, DVec3::Y], &[[0, 1, 2]]);
    let done = filled(&one);
    // Its other side is the only way to close it, on edges that are there.
    assert_eq!(done.mesh.face_count(), 2);
}

#[test]
fn no_unit_changes_the_result() {
    let holed = without(&sphere(2), &around(&sphere(2), 3));
    let one = filled(&holed);
    let scaled = filled(&moved(&holed, |p| p * 2f64.powi(400)));
    assert_eq!(one.mesh.faces(), scaled.mesh.faces());
    assert!(one.mesh.points().iter().zip(scaled.mesh.points()).all(|(a, b)| *a * 2f64.powi(400) == *b));
}

#[test]
fn columns_follow() {
    let mut holed = without(&torus(24, 12), &around(&torus(24, 12), 0));
    let labels = (0..holed.face_count() as i32).map(|f| f % 3).collect();
    holed.attributes.face.insert("group".into(), crate::mesh::Column::Label(labels));
    holed
        .attributes
        .vertex
        .insert("height".into(), crate::mesh::Column::Scalar(holed.points().iter().map(|p| p.z).collect()));
    let done = filled(&holed).mesh;
    assert_eq!(done.attributes.face["group"].len(), done.face_count());
    assert_eq!(done.attributes.vertex["height"].len(), done.vertex_count());
}
