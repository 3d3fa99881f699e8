use super::*;
use crate::mesh::test_models::*;
use crate::mesh::{Column, Polygons, Topology};
use glam::DVec3;
use proptest::prelude::*;

fn prepared(mesh: &SurfaceMesh) -> Prepared {
    prepare(mesh.clone(), &PrepareOptions::default(), Takes::Bodies, &Context::new()).unwrap()
}

/// Every face with corners of its own.
fn soup_of(mesh: &SurfaceMesh) -> SurfaceMesh {
    let points = mesh.faces().corners().iter().map(|&v| mesh.points()[v as usize]).collect();
    let mut faces = Polygons::new();
    for w in mesh.faces().offsets().windows(2) {
        faces.push_iter(w[0]..w[1]);
    }
    SurfaceMesh::new(points, faces).unwrap()
}

fn volume(mesh: &SurfaceMesh) -> f64 {
    Topology::of(mesh).volume.unwrap()
}

/// The faces by the places of their corners, each from its first: what does not depend on numbers.
fn places(mesh: &SurfaceMesh) -> Vec<Vec<[u64; 3]>> {
    let face = |f: &[u32]| {
        let at: Vec<[u64; 3]> = f.iter().map(|&v| mesh.points()[v as usize].to_array().map(f64::to_bits)).collect();
        let first = (0..at.len()).min_by_key(|&k| at[k]).unwrap();
        (0..at.len()).map(|k| at[(first + k) % at.len()]).collect()
    };
    let mut all: Vec<_> = mesh.faces().iter().map(face).collect();
    all.sort();
    all
}

fn models() -> Vec<SurfaceMesh> {
    vec![tetrahedron(), cube(DVec3::ZERO, 2.0), torus(9, 7), grid(4), strip(12, 0), sphere(2)]
}

#[test]
fn a_sound_surface_comes_back_as_it_is() {
    let touching = together(&[cube(DVec3::ZERO, 1.0), cube(DVec3::new(1.0, 1.0, 0.0), 1.0)]);
    let beside = together(&[cube(DVec3::ZERO, 1.0), cube(DVec3::X, 1.0)]);
    for mesh in models().into_iter().chain([touching, beside]) {
        let done = prepared(&mesh);
        assert!(
            !done.is_changed() && done.report.line().is_none() && done.report.left().is_empty(),
            "{:?}",
            done.report
        );
        assert_eq!((done.mesh.points(), done.mesh.faces()), (mesh.points(), mesh.faces()));
    }
}

#[test]
fn unshared_faces_become_the_surface() {
    for mesh in models() {
        let soup = soup_of(&mesh);
        let done = prepared(&soup);
        assert_eq!(done.mesh.vertex_count(), mesh.vertex_count());
        assert_eq!(places(&done.mesh), places(&mesh));
        assert_eq!(done.report.welded_vertices, mesh.corner_count() - mesh.vertex_count());
        assert!(done.report.line().unwrap().contains("welded"));
        // The way back, and there.
        for v in 0..done.mesh.vertex_count() as u32 {
            assert_eq!(done.mesh.points()[v as usize], soup.points()[done.vertex(v) as usize]);
            assert_eq!(done.vertex_image(done.vertex(v)), Some(v));
        }
        assert!((0..done.mesh.face_count() as u32).all(|f| done.face(f) == f && !done.is_turned(f)));
        let numbers: Vec<u32> = (0..done.mesh.face_count() as u32).collect();
        assert_eq!(done.labels_of_faces(&numbers), numbers);
        assert!(done.left_out().is_empty());
    }
}

#[test]
fn what_is_in_the_file_twice_is_there_once() {
    for mesh in models() {
        for second in [mesh.clone(), turned(&mesh, |_| true), soup_of(&mesh)] {
            let done = prepared(&together(&[mesh.clone(), second]));
            assert_eq!(places(&done.mesh), places(&mesh));
            assert_eq!(done.report.duplicate_faces, mesh.face_count());
            let labels = done.labels_of_faces(&(0..mesh.face_count() as u32).collect::<Vec<_>>());
            assert_eq!(labels[..mesh.face_count()], labels[mesh.face_count()..]);
        }
    }
}

#[test]
fn each_body_is_turned_for_itself_and_cavities_look_inward() {
    let ball = |r: f64, x: f64| moved(&sphere(1), |p| p * r + x * DVec3::X);
    let (outer, inner, far) = (ball(3.0, 0.0), ball(1.0, 0.0), ball(1.0, 9.0));
    let want = volume(&outer) - volume(&inner) + volume(&far);
    for turns in 0..8 {
        let parts = [&outer, &inner, &far].into_iter().enumerate();
        let parts: Vec<SurfaceMesh> = parts.map(|(k, part)| turned(part, |_| turns >> k & 1 == 1)).collect();
        let done = prepared(&together(&parts));
        assert!((volume(&done.mesh) - want).abs() < 1e-9);
        assert_eq!(done.report.turned_components, (turns as u32 ^ 2).count_ones() as usize);
        assert_eq!(done.bodies.list.len(), 2);
        assert!((0..done.mesh.face_count() as u32).all(|f| done.is_turned(f) == ((turns ^ 2) >> (f / 80) & 1 == 1)));
    }
}

#[test]
fn a_body_of_its_own_name_is_no_cavity() {
    let mut mesh = together(&[moved(&sphere(1), |p| 3.0 * p), sphere(1)]);
    let labels = (0..mesh.face_count()).map(|f| i32::from(f >= 80)).collect();
    mesh.attributes.face.insert("solid".into(), Column::Label(labels));
    for (label, name) in [(0, "case"), (1, "ball")] {
        mesh.attributes.names.insert(("solid".into(), label), name.into());
    }
    let done = prepared(&mesh);
    assert!(!done.is_changed());
    let names: Vec<_> = done.bodies.list.iter().map(|b| b.name.clone().unwrap()).collect();
    assert_eq!(names, ["case", "ball"]);
}

/// All that is known of two bodies in contact: their vertices are the same ones.
#[test]
fn bodies_that_touch_come_apart() {
    let at = |x: f64, y: f64, z: f64| cube(DVec3::new(x, y, z), 1.0);
    for other in [at(1.0, 0.0, 0.0), at(1.0, 1.0, 0.0), at(1.0, 1.0, 1.0)] {
        for (a, b) in [(false, false), (true, false), (true, true)] {
            for cut in [false, true] {
                let parts = [turned(&at(0.0, 0.0, 0.0), |_| a), turned(&other, |_| b)];
                let parts = parts.map(|part| if cut { part.triangulated().unwrap() } else { part });
                let mesh = merged(&together(&parts));
                let done = prepared(&mesh);
                let t = Topology::of(&done.mesh);
                assert!(t.closed && t.manifold && t.consistently_oriented, "{t:?}");
                assert_eq!((t.components, done.bodies.list.len()), (2, 2));
                assert!((t.volume.unwrap() - 2.0).abs() < 1e-12);
            }
        }
    }
}

#[test]
fn plates_that_cross_and_sheets_of_three_stay_and_are_named() {
    let p = [DVec3::ZERO, DVec3::Z, DVec3::X, DVec3::Y, DVec3::NEG_X, DVec3::NEG_Y];
    for faces in [&[[0, 1, 2], [0, 1, 3], [0, 1, 4]][..], &[[0, 1, 2], [0, 1, 3], [0, 1, 4], [0, 1, 5]]] {
        let done = prepared(&triangles(&p, faces));
        assert_eq!((done.report.nonmanifold_edges, done.mesh.vertex_count()), (1, 6));
        assert_eq!(done.report.left(), ["1 non-manifold edge: [0,1]"]);
    }
    let done = prepared(&strip(12, 1));
    assert!(done.report.left()[0].contains("inconsistently oriented edge"));
}

#[test]
fn small_pieces_are_told_or_left_out() {
    let speck = |x: f64| moved(&tetrahedron(), |p| 0.01 * p + x * DVec3::X);
    let mesh = together(&[speck(5.0), sphere(3), speck(6.0)]);
    let told = prepared(&mesh);
    assert!(!told.is_changed() && told.report.small.count == 2);
    assert!(told.report.line().unwrap().contains("kept 2 small pieces of 8 faces (first at face 0"));
    let with = |keep: &str, takes| {
        let options = PrepareOptions { keep: Some(keep.parse().unwrap()), ..PrepareOptions::default() };
        prepare(mesh.clone(), &options, takes, &Context::new()).unwrap()
    };
    let one = prepare(mesh.clone(), &PrepareOptions::default(), Takes::OneBody, &Context::new()).unwrap();
    for done in [with("largest", Takes::Bodies), with("5%", Takes::Bodies), one] {
        assert_eq!((done.mesh.points(), done.mesh.faces()), (sphere(3).points(), sphere(3).faces()));
        assert_eq!((done.vertex(0), done.face(0), done.left_out().len()), (4, 4, 8));
        assert!(done.report.line().unwrap().contains("left out 2 pieces of 8 faces"));
    }
    for done in [with("all", Takes::OneBody), with("0", Takes::Bodies)] {
        assert!(!done.is_changed() && done.report.line().is_none());
    }
    for wrong in ["-1", "200%", "none", ""] {
        assert!(wrong.parse::<Keep>().is_err(), "{wrong}");
    }
}

#[test]
fn faces_without_area_go_and_labels_come_back() {
    let clean = grid(3);
    let mut points = clean.points().to_vec();
    points.push(points[5]);
    let mut faces = clean.faces().clone();
    faces.push(&[5, 6, points.len() as u32 - 1]);
    let done = prepared(&SurfaceMesh::new(points, faces).unwrap());
    assert_eq!(places(&done.mesh), places(&clean));
    assert_eq!((done.report.degenerate_faces, done.left_out()), (1, vec![18]));
    let labels: Vec<u32> = (0..18).map(|f| f + 100).collect();
    let back = done.labels_of_faces(&labels);
    assert_eq!(back[..18], labels);
    let beside = back[18] as usize - 100;
    assert!(clean.faces().face(beside).contains(&5));
}

#[test]
fn seams_are_where_faces_have_other_vertices_or_senses_in_the_file() {
    // Two grids side by side, the second with vertices of its own; one face of the first turned.
    let beside = together(&[grid(3), moved(&grid(3), |p| p + 3.0 * DVec3::X)]);
    let done = prepared(&turned(&beside, |f| f == 8));
    let ends: Vec<[u32; 2]> = done.seams().into_iter().map(|ends| ends.map(|v| v.0)).collect();
    let at = |v: u32| done.mesh.points()[v as usize];
    let on_border = ends.iter().filter(|ends| ends.iter().all(|&v| at(v).x == 3.0)).count();
    assert!(on_border == 3 && ends.len() >= 5 && ends.len() <= 6, "{ends:?}");
    for f in 0..done.mesh.face_count() as u32 {
        let mut own = done.corners(f);
        let mut before = done.input().faces().face(done.face(f) as usize).to_vec();
        own.sort_unstable();
        before.sort_unstable();
        assert_eq!(own, before);
    }
    assert!(prepared(&grid(3)).seams().is_empty());
    assert_eq!(prepared(&soup_of(&torus(5, 4))).seams().len(), Topology::of(&torus(5, 4)).edges);
}

/// Two quads that share two sides have fans that fold onto each other.
#[test]
fn fans_that_fold_leave_the_surface_as_closed_as_its_polygons() {
    let mesh = folded_box();
    assert!(Topology::of(&mesh).closed && Topology::of(&mesh).manifold);
    let context = Context::new();
    let done = prepare_fans(mesh.clone(), &PrepareOptions::default(), Takes::Bodies, &context).unwrap();
    let t = Topology::of(&done.mesh);
    assert!(t.closed && t.manifold && t.consistently_oriented && t.components == 1, "{t:?}");
    assert!((t.volume.unwrap() - 1.0).abs() < 1e-12);
    assert_eq!((done.report.folded_faces, done.report.duplicate_faces, done.mesh.face_count()), (2, 0, 12));
    assert!(done.report.line().unwrap().contains("left out 2 faces folded onto each other (first "));
    // What is gone is told by what is beside it.
    assert_eq!(done.left_out().len(), 2);
    let labels = vec![7; done.mesh.face_count()];
    assert_eq!(done.labels_of_faces(&labels), [7; 14]);
    // Quads that are there twice as a whole are doubles.
    let twice = together(&[cube(DVec3::ZERO, 1.0), cube(DVec3::ZERO, 1.0)]);
    let done = prepare_fans(twice, &PrepareOptions::default(), Takes::Bodies, &context).unwrap();
    assert_eq!((done.report.folded_faces, done.report.duplicate_faces, done.mesh.face_count()), (0, 12, 12));
}

#[test]
fn nothing_is_done_where_nothing_shall_be() {
    let mesh = soup_of(&turned(&torus(5, 4), |f| f == 3));
    let options = PrepareOptions { as_is: true, ..PrepareOptions::default() };
    let done = prepare(mesh.clone(), &options, Takes::OneBody, &Context::new()).unwrap();
    assert_eq!((done.mesh.points(), done.mesh.faces()), (mesh.points(), mesh.faces()));
}

#[test]
fn columns_along_seams_become_columns_of_corners() {
    let mut mesh = soup_of(&grid(2));
    let uv: Vec<[f64; 2]> = (0..mesh.vertex_count()).map(|v| [v as f64, 0.0]).collect();
    mesh.attributes.vertex.insert("uv".into(), Column::Vector2(uv.clone()));
    mesh.attributes.vertex.insert("height".into(), Column::Scalar(vec![2.0; mesh.vertex_count()]));
    let done = prepared(&mesh).mesh;
    assert_eq!(done.attributes.corner["uv"], Column::Vector2(uv));
    assert!(!done.attributes.vertex.contains_key("uv") && done.attributes.vertex["height"].len() == 9);
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
    fn whatever_comes_can_be_traced(mesh in any_mesh()) {
        let done = prepared(&mesh);
        for v in 0..done.mesh.vertex_count() as u32 {
            prop_assert_eq!(done.mesh.points()[v as usize], mesh.points()[done.vertex(v) as usize]);
        }
        prop_assert!((0..done.mesh.face_count() as u32).all(|f| (done.face(f) as usize) < mesh.face_count()));
        let labels: Vec<u32> = (0..done.mesh.face_count() as u32).collect();
        if !labels.is_empty() {
            prop_assert_eq!(done.labels_of_faces(&labels).len(), mesh.face_count());
        }
    }

    #[test]
    fn a_second_preparation_finds_nothing_to_do(mesh in any_mesh()) {
        let once = prepared(&mesh).mesh;
        let twice = prepared(&once);
        prop_assert!(!twice.is_changed(), "{:?}\n{:?}\n{:?}", once.faces(), twice.mesh.faces(), twice.report);
        prop_assert_eq!(twice.report.turned_components, 0);
    }
}
