use super::super::source::WriteOptions;
use super::super::surface_tests::{error_of, faces_of, read_as};
use crate::mesh::{Column, RawMesh};
use glam::DVec3;
use proptest::prelude::*;

const TRIANGLE: &str = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                        element face 1\nproperty list uchar int vertex_indices\nend_header\n";
const VALUES: &str = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

fn read(text: impl AsRef<[u8]>) -> RawMesh {
    read_as("a.ply", text).unwrap()
}

fn ascii(declarations: &str, values: &str) -> String {
    format!("ply\nformat ascii 1.0\n{declarations}end_header\n{values}")
}

const XYZ: &str = "property double x\nproperty double y\nproperty double z\n";

/// One value of every scalar type, in the byte order asked for.
fn all_types(big: bool) -> Vec<u8> {
    let name = if big { "binary_big_endian" } else { "binary_little_endian" };
    let mut file = format!("ply\nformat {name} 1.0\nelement vertex 1\n").into_bytes();
    let mut values = Vec::new();
    macro_rules! value {
        ($($kind:literal $name:literal: $value:expr),*) => {$(
            file.extend_from_slice(concat!("property ", $kind, " ", $name, "\n").as_bytes());
            values.extend(if big { $value.to_be_bytes().to_vec() } else { $value.to_le_bytes().to_vec() });
        )*};
    }
    value!(
        "char" "a": -1i8, "uint8" "b": 200u8, "short" "c": -300i16, "ushort" "d": 60000u16, "double" "z": 0.1f64,
        "int" "e": -70000i32, "uint32" "f": 4000000000u32, "int64" "g": -5i64, "uint64" "h": u64::MAX,
        "float" "y": 0.1f32, "float64" "i": 1e300f64, "int16" "x": 7i16
    );
    file.extend_from_slice(b"end_header\n");
    file.extend_from_slice(&values);
    file
}

#[test]
fn all_types_in_both_byte_orders() {
    for big in [false, true] {
        let mesh = read(all_types(big));
        assert_eq!(mesh.points, [DVec3::new(7.0, f64::from(0.1f32), 0.1)]);
        let columns = &mesh.attributes.vertex;
        for (name, label) in [("a", -1), ("b", 200), ("c", -300), ("d", 60000), ("e", -70000), ("g", -5)] {
            assert_eq!(columns[name], Column::Label(vec![label]), "{name}");
        }
        assert_eq!(columns["f"], Column::Scalar(vec![4e9]));
        assert_eq!(columns["h"], Column::Scalar(vec![i64::MAX as f64]));
        assert_eq!(columns["i"], Column::Scalar(vec![1e300]));
        assert!(mesh.notes.is_empty());
    }
}

#[test]
fn line_ends_and_comments_do_not_matter() {
    let plain = format!("ply\nformat ascii 1.0\ncomment x\nobj_info y\n{TRIANGLE}{VALUES}");
    for text in [
        plain.clone(),
        plain.replace('\n', "\r\n"),
        plain.replace('\n', "\r"),
        plain.replace('\n', "  \n"),
        format!("ply\nformat ascii 1.0\n{TRIANGLE}\ncomment among values\n0 0 0 1 0 0\n0 1\ncomment\n0 3 0 1 2"),
    ] {
        let mesh = read(&text);
        assert_eq!((mesh.points.len(), faces_of(&mesh)), (3, vec![vec![0, 1, 2]]), "{text:?}");
        assert!(mesh.notes.is_empty(), "{:?}", mesh.notes);
    }
}

#[test]
fn binary_values_begin_right_after_the_header() {
    // The first byte of the values is a line feed: it must not be taken for the end of the header's line.
    for end in ["\n", "\r\n", "\r"] {
        let header = "ply\nformat binary_big_endian 1.0\nelement vertex 1\n\
                      property uchar x\nproperty uchar y\nproperty uchar z\nend_header\n";
        let mut file = header.replace('\n', end).into_bytes();
        file.extend_from_slice(b"\n\r\x05");
        assert_eq!(read(&file).points, [DVec3::new(10.0, 13.0, 5.0)], "{end:?}");
    }
}

#[test]
fn elements_in_any_order_and_unknown_ones() {
    let declarations = format!(
        "element camera 2\nproperty float focal\nproperty list uchar float params\n\
         element face 1\nproperty uchar flags\nproperty list char uint vertex_index\nproperty list uchar float texcoord\n\
         element edge 1\nproperty int vertex2\nproperty int vertex1\n\
         element vertex 3\nproperty int quality\n{XYZ}element nothing 99999999999\n"
    );
    let mesh = read(ascii(&declarations, "1 2 5 6\n1 0\n8 3 2 1 0 2 .5 .5\n1 0\n4 0 0 0\n5 1 0 0\n6 0 1 0\n"));
    assert_eq!(faces_of(&mesh), [[2, 1, 0]]);
    assert_eq!((mesh.edges, mesh.edge_tags), (vec![[0, 1]], vec![0]));
    assert_eq!(mesh.attributes.face["flags"], Column::Label(vec![8]));
    assert_eq!(mesh.attributes.vertex["quality"], Column::Label(vec![4, 5, 6]));
    assert_eq!(mesh.points[1], DVec3::X);
    assert_eq!(mesh.notes.len(), 3, "{:?}", mesh.notes);
}

#[test]
fn properties_become_columns() {
    let names = "nx ny nz s t d_x d_y d_z e_x e_y w_u w_v spot_red spot_green spot_blue";
    let floats: String = names.split(' ').map(|n| format!("property float {n}\n")).collect();
    let declarations =
        format!("element vertex 1\n{XYZ}{floats}property uchar red\nproperty uchar green\nproperty uchar blue\n");
    let mesh = read(ascii(&declarations, "0 0 0 1 2 3 4 5 6 7 8 9 10 11 12 0 0.2 1 9 8 7\n"));
    let columns = &mesh.attributes.vertex;
    assert_eq!(columns["normal"], Column::Vector3(vec![[1.0, 2.0, 3.0]]));
    assert_eq!(columns["uv"], Column::Vector2(vec![[4.0, 5.0]]));
    assert_eq!(columns["d"], Column::Vector3(vec![[6.0, 7.0, 8.0]]));
    assert_eq!(columns["e_x"], Column::Scalar(vec![9.0]));
    assert_eq!(columns["w"], Column::Vector2(vec![[11.0, 12.0]]));
    assert_eq!(columns["spot"], Column::Color(vec![[0, 51, 255, 255]]));
    assert_eq!(columns["color"], Column::Color(vec![[9, 8, 7, 255]]));
    assert_eq!(columns.len(), 8);
    // Integers above 255 are no colours, and columns with one name are both kept.
    let ints = ["red", "green", "blue", "normal"].map(|n| format!("property int {n}\n")).concat();
    let floats = ["nx", "ny", "nz"].map(|n| format!("property float {n}\n")).concat();
    let declarations = format!("element vertex 1\n{XYZ}{ints}{floats}");
    let mesh = read(ascii(&declarations, "0 0 0 256 0 0 5 1 1 1"));
    assert_eq!(mesh.attributes.vertex.keys().collect::<Vec<_>>(), ["blue", "green", "normal", "normal_", "red"]);
}

#[test]
fn the_contract_of_names() {
    let mut mesh = RawMesh { points: vec![DVec3::ZERO; 3], ..RawMesh::default() };
    mesh.faces.push(&[0, 1, 2]);
    mesh.attributes.vertex.insert("dmin".into(), Column::Vector3(vec![[1.0, 2.0, 3.0]; 3]));
    mesh.attributes.face.insert("region".into(), Column::Label(vec![5]));
    mesh.attributes.face.insert("u".into(), Column::Vector3(vec![[1.0, 2.0, 3.0]]));
    let mut bytes = Vec::new();
    super::write(&mesh, &WriteOptions { ascii: true }, &mut bytes).unwrap();
    let header = String::from_utf8(bytes).unwrap();
    for line in [
        "property double dmin_x",
        "property int region",
        "property double u_x",
        "property list uchar int vertex_indices",
    ] {
        assert!(header.contains(&format!("{line}\n")), "{header}");
    }
}

#[test]
fn names_that_are_taken_are_left_out_with_a_warning() {
    let mut mesh = RawMesh { points: vec![DVec3::ZERO], ..RawMesh::default() };
    mesh.attributes.vertex.insert("x".into(), Column::Scalar(vec![1.0]));
    mesh.attributes.vertex.insert("two words".into(), Column::Scalar(vec![1.0]));
    let mut bytes = Vec::new();
    assert_eq!(super::write(&mesh, &WriteOptions::default(), &mut bytes).unwrap().len(), 1);
    let back = read(&bytes);
    assert_eq!(back.points, mesh.points);
    assert_eq!(back.attributes.vertex.keys().collect::<Vec<_>>(), ["two_words"]);
}

#[test]
fn polygons_with_more_corners_than_a_byte_counts() {
    let mut mesh = RawMesh { points: vec![DVec3::ONE; 300], ..RawMesh::default() };
    mesh.faces.push(&Vec::from_iter(0..300));
    mesh.faces.push(&[0, 1, 2]);
    for ascii in [false, true] {
        let mut bytes = Vec::new();
        super::write(&mesh, &WriteOptions { ascii }, &mut bytes).unwrap();
        assert_eq!(read(&bytes).faces, mesh.faces);
    }
}

#[test]
fn short_faces_are_left_out_with_their_properties() {
    let declarations =
        format!("element vertex 3\n{XYZ}element face 3\nproperty list uchar int vertex_indices\nproperty int id\n");
    let mesh = read(ascii(&declarations, "0 0 0 1 0 0 0 1 0\n2 0 1 7\n3 0 1 2 8\n0 9\n"));
    assert_eq!(mesh.attributes.face["id"], Column::Label(vec![8]));
    assert_eq!((mesh.faces.len(), mesh.notes.len()), (1, 1));
}

/// The rule of strips, spelled out: split at negative numbers, turn every second triangle, drop degenerate ones.
fn triangles_of_strip(values: &[i32]) -> Vec<Vec<u32>> {
    let mut out = Vec::new();
    for run in values.split(|v| *v < 0) {
        for (k, w) in run.windows(3).enumerate() {
            let [a, b, c] = [w[0] as u32, w[1] as u32, w[2] as u32];
            if a != b && b != c && a != c {
                out.push(if k % 2 == 0 { vec![a, b, c] } else { vec![b, a, c] });
            }
        }
    }
    out
}

proptest! {
    #[test]
    fn strips_become_triangles(values in prop::collection::vec(-1i32..5, 0..30)) {
        let strips = "element tristrips 1\nproperty list int int vertex_indices\n";
        let declarations = format!("element vertex 5\n{XYZ}{strips}");
        let words: String = values.iter().map(|v| format!(" {v}")).collect();
        let mesh = read(ascii(&declarations, &format!("{}{}{words}\n", "0 0 0\n".repeat(5), values.len())));
        prop_assert_eq!(faces_of(&mesh), triangles_of_strip(&values));
    }
}

#[test]
fn text_may_write_integers_with_a_fraction_of_zero() {
    let mesh = read(format!("ply\nformat ascii 1.0\n{TRIANGLE}{}", "0 0 0 1 0 0 0 1 0 3.0 0.0 1.0 2.0"));
    assert_eq!(faces_of(&mesh), [[0, 1, 2]]);
}

#[test]
fn what_follows_the_last_element_is_noted() {
    assert_eq!(read(format!("ply\nformat ascii 1.0\n{TRIANGLE}{VALUES}3 0 1 2\n")).notes.len(), 1);
}

#[test]
fn what_is_wrong_is_told_with_its_place() {
    let file = |declarations: &str, values: &str| format!("ply\nformat ascii 1.0\n{declarations}{values}");
    let binary = "format binary_little_endian 1.0";
    for (text, what) in [
        ("ply2\n".into(), "line 1: this does not look like PLY"),
        ("ply\nformat ascii 1.0\nelement vertex 3\n".into(), "no line 'end_header'"),
        (file(TRIANGLE, VALUES).replace("format ascii 1.0\n", ""), "no line 'format'"),
        (file(TRIANGLE, VALUES).replace("ascii", "gzip"), "'gzip' is not a PLY format"),
        (file(TRIANGLE, VALUES).replace("uchar", "byte"), "line 8: 'byte' is not a PLY type"),
        (file(TRIANGLE, VALUES).replace("list uchar", "list float"), "must be an integer"),
        (file(TRIANGLE, VALUES).replace("face 1", "face -1"), "'face' has the count '-1'"),
        (file(TRIANGLE, VALUES).replace("face 1", "face 1e3"), "has the count '1e3'"),
        (file(TRIANGLE, VALUES).replace("float z", "float y"), "line 6: property 'y' is declared twice"),
        (file(TRIANGLE, VALUES).replace("face 1", "vertex 1"), "element 'vertex' is declared twice"),
        (file(TRIANGLE, VALUES).replace("float z", "float w"), "no property 'z'"),
        (file(TRIANGLE, VALUES).replace("element vertex", "element knot"), "no element 'vertex'"),
        (file(TRIANGLE, VALUES).replace("element vertex 3\n", ""), "before the first element"),
        (file(TRIANGLE, VALUES).replace("vertex 3", "vertex 1000000000000"), "1000000000000 rows of element 'vertex'"),
        (file(TRIANGLE, "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"), "line 13: there is no vertex 3"),
        (file(TRIANGLE, "0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n"), "there is no vertex -1"),
        (file(TRIANGLE, "0 0 0\n1 0 0\n0 1 0\n-3 0 1 2\n"), "has -3 values"),
        (file(TRIANGLE, "0 0 0\n1 0 0\n0 1 0\n4000000000 0 1 2\n"), "4000000000 values"),
        (file(TRIANGLE, "0 0 0\n1 0 0\n0 one 0\n3 0 1 2\n"), "line 12: a number is expected, found 'one'"),
        (file(TRIANGLE, "0 0 0\n1 0 0\n0 1 0\n3 0 1.5 2\n"), "an integer is expected"),
        (file(TRIANGLE, "0 0 0\n1 0 0\n0 1 0\n3 0 1\n"), "the file ends"),
        (file(TRIANGLE, "0 0 0\n1 inf 0\n0 1 0\n3 0 1 2\n"), "not finite"),
        (file(TRIANGLE, "").replace("format ascii 1.0", binary), "3 rows of element 'vertex' are announced"),
        (
            file(TRIANGLE, &("\0".repeat(36) + "\x03")).replace("format ascii 1.0", binary),
            "3 values of 'vertex_indices'",
        ),
    ] {
        let message = error_of("a.ply", &text);
        assert!(message.contains(what), "{text}: {message}");
    }
}
