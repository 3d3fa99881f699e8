use super::super::formats::format_of;
use super::super::source::WriteOptions;
use super::super::surface_tests::{error_of, read_as};
use super::package::pack;
use crate::mesh::{Column, LengthUnit, Polygons, RawMesh};
use glam::DVec3;
use std::path::Path;

fn written(mesh: &RawMesh) -> (Vec<u8>, Vec<String>) {
    let mut bytes = Vec::new();
    let format = format_of(Path::new("a.3mf")).unwrap();
    let warnings = (format.write)(mesh, &WriteOptions::default(), &mut bytes).unwrap();
    (bytes, warnings)
}

/// Two bodies with no vertex in common.
fn bodies() -> RawMesh {
    let points = (0..8).map(|k| DVec3::new(f64::from(k % 2) + 0.1, f64::from(k / 2 % 2), f64::from(k / 4))).collect();
    let faces = Polygons::from_triangles(&[[0, 1, 2], [1, 3, 2], [4, 5, 6], [5, 7, 6]]);
    let mut mesh = RawMesh { points, faces, ..RawMesh::default() };
    let a = &mut mesh.attributes;
    a.face.insert("object".into(), Column::Label(vec![0, 0, 1, 1]));
    a.names.insert(("object".into(), 0), "Body <1> & \"co\"".into());
    a.names.insert(("object".into(), 1), "lid".into());
    a.unit = Some(LengthUnit::Inch);
    mesh
}

fn content(mesh: &RawMesh) -> String {
    format!("{:?}\n{:?}\n{:?}", mesh.points, mesh.faces, mesh.attributes)
}

#[test]
fn bodies_materials_and_unit_come_back() {
    let mut mesh = bodies();
    let a = &mut mesh.attributes;
    a.face.insert("material".into(), Column::Label(vec![0, 1, 0, -1]));
    for (label, name, color) in [(0, "red paint", [200, 0, 0, 255]), (1, "glass", [1, 2, 3, 77])] {
        a.names.insert(("material".into(), label), name.into());
        a.colors.insert(("material".into(), label), color);
    }
    let (bytes, warnings) = written(&mesh);
    assert_eq!(warnings, Vec::<String>::new());
    assert_eq!(bytes, written(&mesh).0, "equal meshes give equal bytes");
    let back = read_as("a.3mf", &bytes).unwrap();
    assert_eq!(content(&back), content(&mesh));
    assert!(back.notes.iter().any(|note| note.contains("inch")), "{:?}", back.notes);
}

#[test]
fn colours_of_faces_and_corners_come_back() {
    let mut mesh = bodies();
    mesh.attributes.face.insert("color".into(), Column::Color(vec![[1, 2, 3, 255], [9, 8, 7, 6], [0; 4], [255; 4]]));
    let (bytes, warnings) = written(&mesh);
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!(content(&read_as("a.3mf", &bytes).unwrap()), content(&mesh));
    mesh.attributes.face.remove("color");
    mesh.attributes.corner.insert("color".into(), Column::Color((0..12).map(|k| [k, 2, 3, 255]).collect()));
    let (bytes, warnings) = written(&mesh);
    assert!(warnings.is_empty(), "{warnings:?}");
    assert_eq!(content(&read_as("a.3mf", &bytes).unwrap()), content(&mesh));
}

fn packed(resources: &str, build: &str) -> Vec<u8> {
    let mut out = Vec::new();
    let model = format!(
        "<model unit=\"millimeter\" xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\">\
         <resources>{resources}</resources><build>{build}</build></model>"
    );
    pack(model.as_bytes(), &mut out).unwrap();
    out
}

const MESH: &str = "<mesh><vertices><vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"1\" y=\"0\" z=\"0\"/>\
                    <vertex x=\"0\" y=\"1\" z=\"0\"/></vertices><triangles><triangle v1=\"0\" v2=\"1\" v3=\"2\"/></triangles></mesh>";

#[test]
fn components_stand_at_their_places() {
    let objects = format!(
        "<object id=\"1\" name=\"foot\">{MESH}</object><object id=\"2\"><components>\
         <component objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 1 5 0 0\"/>\
         <component objectid=\"1\" transform=\"-1 0 0 0 1 0 0 0 1 0 0 0\"/></components></object>"
    );
    let file = packed(&objects, "<item objectid=\"2\" transform=\"1 0 0 0 1 0 0 0 1 0 0 7\"/>");
    let mesh = read_as("a.3mf", file).unwrap();
    assert_eq!(mesh.points[1], DVec3::new(6.0, 0.0, 7.0));
    // The mirrored one is turned over, so that it stays right side out.
    assert_eq!(mesh.faces.iter().collect::<Vec<_>>(), [[0, 1, 2], [3, 5, 4]]);
    assert_eq!(mesh.attributes.only_body(), Some("foot"));
}

#[test]
fn what_is_wrong_is_told() {
    let object = format!("<object id=\"1\">{MESH}</object>");
    let itself = "<object id=\"1\"><components><component objectid=\"1\"/></components></object>";
    for (file, what) in [
        (b"solid".to_vec(), "not a 3MF package"),
        (packed(&object, "<item objectid=\"4\"/>"), "object 4 does not exist"),
        (packed(&object.replace("v3=\"2\"", "v3=\"3\""), "<item objectid=\"1\"/>"), "a vertex that does not exist"),
        (
            packed(&object.replace("x=\"1\"", "x=\"1,0\""), "<item objectid=\"1\"/>"),
            "'x' must be a coordinate, found '1,0'",
        ),
        (packed(itself, "<item objectid=\"1\"/>"), "nested more than"),
        (packed(&object.replace("</object>", ""), "<item objectid=\"1\"/>"), "not well-formed XML"),
    ] {
        let message = error_of("a.3mf", &file);
        assert!(message.contains(what), "{message}");
    }
}

/// A model that unpacks to a thousand times its size, and one that doubles itself thirty times.
#[test]
fn bombs_are_refused() {
    let zeros = format!("<object id=\"1\">{}{MESH}</object>", " ".repeat(64 << 20));
    assert!(error_of("a.3mf", packed(&zeros, "<item objectid=\"1\"/>")).contains("unpacks to more"));
    let mut objects = format!("<object id=\"1\">{MESH}</object>");
    for id in 2..31 {
        let of = id - 1;
        objects += &format!(
            "<object id=\"{id}\"><components><component objectid=\"{of}\"/><component objectid=\"{of}\"/></components></object>"
        );
    }
    assert!(error_of("a.3mf", packed(&objects, "<item objectid=\"30\"/>")).contains("used many times"));
}
