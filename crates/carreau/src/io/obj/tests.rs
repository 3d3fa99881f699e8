use super::super::surface_tests::{error_of, faces_of, read_as};
use crate::mesh::{Column, RawMesh};
use glam::DVec3;

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn read(text: impl AsRef<[u8]>) -> RawMesh {
    read_as("a.obj", text).unwrap()
}

/// Reads faces over four vertices.
fn read_square(faces: &str) -> RawMesh {
    read(format!("{SQUARE}{faces}"))
}

#[test]
fn all_styles_of_indices() {
    for faces in [
        "f 1 2 3 4",
        "f 1/1 2/1 3/1 4/1",
        "f 1//1 2//1 3//1 4//1",
        "f 1/1/1 2/1/1 3/1/1 4/1/1",
        "f -4 -3 -2 -1",
        "f 1 2// 3/1 -1",
    ] {
        let mesh = read_square(&format!("vt 0 1\nvn 0 0 1\n{faces}\n"));
        assert_eq!(faces_of(&mesh), [[0, 1, 2, 3]], "{faces}");
    }
}

#[test]
fn relative_indices_count_from_where_they_stand() {
    let mesh = read("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 2 0 0\nf -3 -2 -1\n");
    assert_eq!(faces_of(&mesh), [[0, 1, 2], [1, 2, 3]]);
}

#[test]
fn faces_may_come_before_their_vertices() {
    assert_eq!(faces_of(&read(format!("f 1 2 3\n{SQUARE}"))), [[0, 1, 2]]);
    assert!(error_of("a.obj", format!("f 1 2 3\nf 1 2 9\n{SQUARE}f 1 2 4\n")).contains("line 2: there is no vertex 9"));
}

#[test]
fn layout_does_not_matter() {
    let plain = read_square("f 1 2 3\nf 1 3 4\n");
    for text in [
        "\u{feff}v 0 0 0\r\nv 1 0 0\r\nv 1 1 0\r\nv 0 1 0\r\nf 1 2 3\r\nf 1 3 4\r\n",
        "v 0 0 0\rv 1 0 0\rv 1 1 0\rv 0 1 0\rf 1 2 3\rf 1 3 4",
        "\tv\t0 0\t0 \n\n  v +1.0E+00 0 .0#c\nv 1.e0 1 -0e5\n v 0 1 0 # x\nf 1 2 3#c\nf 1\t3 4",
        "v 0 0 0\nv 1 0 \\\n0\nv 1 1 0\nv 0 1 0\nf \\\r\n 1 2\\\n 3\nf 1 3 4\n",
        "mtllib no such.mtl\nv 0 0 0 1.0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n\
         p 1\ns off\ncurv 0 1\nnonsense 5\nf 1 2 3\nf 1 3 4\n",
    ] {
        let mesh = read(text);
        assert_eq!((&mesh.points, &mesh.faces), (&plain.points, &plain.faces), "{text:?}");
    }
}

#[test]
fn short_faces_are_left_out_and_noted() {
    let mesh = read_square("f 1 2 3\nf\nf 1\nf 1 2\nf 1 1 1\ng a\n");
    assert_eq!(faces_of(&mesh), [[0, 1, 2], [0, 0, 0]]);
    assert_eq!(mesh.notes.len(), 1);
    assert!(mesh.notes[0].contains("3 of 5 faces") && mesh.notes[0].contains("line 6"), "{:?}", mesh.notes);
}

#[test]
fn lines_become_edges() {
    assert_eq!(read_square("l 1 2 -1\nl 3/1 1\nl 2\n").edges, [[0, 1], [1, 3], [2, 0]]);
}

#[test]
fn attributes_of_corners_need_all_corners() {
    let mesh = read_square("vt 0\nvt 1 1 9\nvn 0 0 1\nf 1/1/1 2/2/1 3/-2/-1\n");
    assert_eq!(mesh.points.len(), 4);
    assert_eq!(mesh.attributes.corner["uv"], Column::Vector2(vec![[0.0, 0.0], [1.0, 1.0], [0.0, 0.0]]));
    assert_eq!(mesh.attributes.corner["normal"], Column::Vector3(vec![[0.0, 0.0, 1.0]; 3]));
    for faces in ["f 1/1 2/1 3\n", "f 1/1 2/1 3/2\n", "f 1/0 2/1 3/1\n", "f 1/-2 2/1 3/1\n"] {
        let mesh = read_square(&format!("vt 0 0\n{faces}"));
        assert!(mesh.attributes.corner.is_empty() && mesh.notes.len() == 1 && mesh.faces.len() == 1, "{faces}");
    }
}

#[test]
fn colours_need_all_vertices() {
    let mesh = read("v 0 0 0 1 0 0.2\nv 1 0 0 0 0 0\n");
    assert_eq!(mesh.attributes.vertex["color"], Column::Color(vec![[255, 0, 51, 255], [0, 0, 0, 255]]));
    let mesh = read("v 0 0 0 255 0 51\nv 1 0 0 1 0 0\n");
    assert_eq!(mesh.attributes.vertex["color"], Column::Color(vec![[255, 0, 51, 255], [1, 0, 0, 255]]));
    for text in ["v 0 0 0 1 0 0\nv 1 0 0\n", "v 0 0 0 1 0 0\nv 1 0 0 nan nan nan\n", "v 1 0 0 1\nv 0 0 0 1 0 0\n"] {
        let mesh = read(text);
        assert!(mesh.attributes.vertex.is_empty() && mesh.notes.len() == 1, "{text}");
    }
}

#[test]
fn names_are_numbered_in_the_order_of_use() {
    let mesh = read_square(
        "f 1 2 3\ng unused\ng b c\nusemtl Mat#2 # not this\nf 1 2 3\no face_7\ng\nf 1 2 3\ng b c\nf 1 2 3\n",
    );
    let face = &mesh.attributes.face;
    assert_eq!(face["group"], Column::Label(vec![0, 1, 0, 1]));
    assert_eq!(face["material"], Column::Label(vec![0, 1, 1, 1]));
    assert_eq!(face["object"], Column::Label(vec![0, 0, 1, 1]));
    let name = |column: &str, label| mesh.attributes.names[&(column.to_string(), label)].as_str();
    assert_eq!(
        [name("group", 0), name("group", 1), name("material", 1), name("object", 1)],
        ["default", "b c", "Mat#2", "face_7"]
    );
    assert!(read_square("f 1 2 3\n").attributes.face.is_empty());
}

#[test]
fn other_labels_are_written_as_groups() {
    let mut mesh = read_square("f 1 2 3\nf 1 3 4\n");
    mesh.attributes.face.insert("region".into(), Column::Label(vec![7, -1]));
    let mut bytes = Vec::new();
    let warnings = super::write(&mesh, &Default::default(), &mut bytes).unwrap();
    assert_eq!(warnings.len(), 1);
    let back = read(&bytes);
    assert_eq!(back.attributes.face["group"], Column::Label(vec![0, 1]));
    assert_eq!(back.attributes.names.values().collect::<Vec<_>>(), ["region_7", "region_-1"]);
}

#[test]
fn normals_of_vertices_are_written_for_their_corners() {
    let mut mesh = read_square("f 1 2 3\nf 1 3 4\n");
    let normals = [1.0, 2.0, 3.0, 4.0].map(|x| [x, 0.0, 0.0]);
    mesh.attributes.vertex.insert("normal".into(), Column::Vector3(normals.to_vec()));
    let mut bytes = Vec::new();
    assert!(super::write(&mesh, &Default::default(), &mut bytes).unwrap().is_empty());
    let corners = mesh.faces.corners().iter().map(|&v| normals[v as usize]).collect();
    assert_eq!(read(&bytes).attributes.corner["normal"], Column::Vector3(corners));
}

#[test]
fn what_is_wrong_is_told_with_its_line() {
    for (faces, what) in [
        ("f 1 2 0\n", "line 5: there is no vertex '0'"),
        ("f 1 2 5\n", "line 5: there is no vertex 5"),
        ("f 1 2 -5\n", "line 5: there is no vertex '-5'"),
        ("f 1 2 2.5\n", "line 5: a corner"),
        ("f 1 2 two\n", "found 'two'"),
        ("f 1 2 99999999999999999999\n", "line 5: a corner"),
        ("f 1 2 -9223372036854775808\n", "line 5: there is no vertex"),
        ("f 1 2 4294967296\n", "line 5: there is no vertex"),
        ("f 1 2 /1\n", "line 5: a corner"),
        ("f 1 2 3/1/1/1\n", "line 5: a corner"),
        ("l 1 9\n", "line 5: there is no vertex 9"),
        ("\nv 0,5 0 0\n", "line 6: a coordinate is expected, found '0,5'"),
        ("v 1 2\n", "line 5: a vertex has only 2 of 3"),
        ("v ", "line 5: a vertex has only 0 of 3"),
        ("vn 1 2\n", "line 5: a normal has only 2 of 3"),
        ("v 1e400 0 0\n", "not finite"),
        ("v nan 0 0\n", "not finite"),
    ] {
        let message = error_of("a.obj", format!("{SQUARE}{faces}"));
        assert!(message.contains(what), "{faces}: {message}");
    }
}

#[test]
fn other_files_are_refused() {
    for text in
        ["solid a\nfacet normal 0 0 1\nvertex 0 0 0\n", "OFF\n3 1 0\n0 0 0\n", "hello", "\0\0v 0 0 0\n", "v 0 0 0\n\0"]
    {
        assert!(error_of("a.obj", text).contains("does not look like OBJ"), "{text:?}");
    }
    let empty = read("# only a comment\n");
    assert!(empty.points.is_empty() && empty.faces.is_empty());
    assert_eq!(read("v 1 2 3\n").points, [DVec3::new(1.0, 2.0, 3.0)]);
}
