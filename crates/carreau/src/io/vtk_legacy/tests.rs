use super::super::source::{Source, WriteOptions};
use super::super::vtk_cells::samples::{any_mesh, assert_same, mangle, one_of_everything};
use super::{read, write};
use crate::error::Result;
use crate::mesh::{Column, RawMesh};
use proptest::prelude::*;
use std::path::Path;

fn parse(bytes: &[u8]) -> Result<RawMesh> {
    let mesh = read(&Source { path: Path::new("a.vtk"), bytes })?;
    mesh.check()?;
    Ok(mesh)
}

fn written(mesh: &RawMesh, ascii: bool) -> Vec<u8> {
    let mut out = Vec::new();
    write(mesh, &WriteOptions { ascii }, &mut out).unwrap();
    out
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn every_mesh_comes_back_to_the_last_bit(mesh in any_mesh(true), ascii in any::<bool>()) {
        assert_same(&parse(&written(&mesh, ascii)).unwrap(), &mesh);
    }

    #[test]
    fn surfaces_come_back_through_polydata(mesh in any_mesh(false), ascii in any::<bool>()) {
        let bytes = written(&mesh, ascii);
        prop_assert!(String::from_utf8_lossy(&bytes).contains("DATASET POLYDATA"));
        assert_same(&parse(&bytes).unwrap(), &mesh);
    }

    #[test]
    fn mangled_files_never_panic(
        which in 0usize..4,
        edits in proptest::collection::vec(any::<(u16, u16, u8)>(), 1..6),
    ) {
        let valid = match which {
            0 => written(&one_of_everything(), false),
            1 => written(&one_of_everything(), true),
            2 => SECTIONS.as_bytes().to_vec(),
            _ => version_51(),
        };
        let _ = parse(&mangle(valid, &edits));
    }
}

/// Text polydata with every kind of section.
const SECTIONS: &str = "# vtk DataFile Version 3.0
a title, of any words: POINTS 5 float

ascii
DATASET POLYDATA
FIELD FieldData 1
time 1 1 double
0.5
points 6 float
0 0 0  1 0 0  1 1 0
0 1 0  2 0 0  2 1 0
METADATA
INFORMATION 1
NAME L2_NORM_RANGE LOCATION vtkDataArray
DATA 2 0 1

VERTICES 1 2
1 0
LINES 1 4
3 0 1 2
POLYGONS 1 5
4 0 1 2 3
TRIANGLE_STRIPS 1 5
4 1 4 2 5
POINT_DATA 6
SCALARS my%20size float 1
LOOKUP_TABLE default
0 1 2 3 4 5
SCALARS plain int
LOOKUP_TABLE colours
0 1 2 3 4 5
LOOKUP_TABLE colours 1
0 0 0 1
NORMALS normal double
0 0 1 0 0 1 0 0 1 0 0 1 0 0 1 0 0 1
TEXTURE_COORDINATES uv 2 float
0 0 1 0 1 1 0 1 2 0 2 1
CELL_DATA 4
COLOR_SCALARS color 3
0 0 0 0 0 0 1 .5 0 0 0 1
FIELD more 2
label 1 4 vtkIdType
0 0 8 9
words 1 4 string
one
two%20and
three
four
TENSORS stress float
0 0 0 0 0 0 0 0 0  0 0 0 0 0 0 0 0 0  0 0 0 0 0 0 0 0 0  0 0 0 0 0 0 0 0 0
";

#[test]
fn every_kind_of_section() {
    let mesh = parse(SECTIONS.as_bytes()).unwrap();
    assert_eq!(mesh.faces.iter().collect::<Vec<_>>(), [&[0, 1, 2, 3][..], &[1, 4, 2], &[2, 4, 5]]);
    assert_eq!(mesh.edges, [[0, 1], [1, 2]]);
    let vertex = &mesh.attributes.vertex;
    assert_eq!(vertex["my size"], Column::Scalar((0..6).map(f64::from).collect()));
    assert_eq!(vertex["plain"], Column::Label((0..6).collect()));
    assert_eq!(vertex["normal"], Column::Vector3(vec![[0.0, 0.0, 1.0]; 6]));
    assert!(matches!(&vertex["uv"], Column::Vector2(uv) if uv[5] == [2.0, 1.0]));
    let face = &mesh.attributes.face;
    assert_eq!(face["label"], Column::Label(vec![8, 9, 9]));
    assert_eq!(face["color"], Column::Color(vec![[255, 128, 0, 255], [0, 0, 255, 255], [0, 0, 255, 255]]));
    for left_out in ["time", "words", "stress", "colours"] {
        assert_eq!(mesh.notes.iter().filter(|n| n.contains(left_out)).count(), 1, "{left_out}: {:?}", mesh.notes);
    }
}

#[test]
fn line_ends_do_not_matter() {
    let want = parse(SECTIONS.as_bytes()).unwrap();
    for end in ["\r\n", "\r"] {
        assert_same(&parse(SECTIONS.replace('\n', end).as_bytes()).unwrap(), &want);
    }
}

/// Version 5.1 in binary, as VTK writes it.
fn version_51() -> Vec<u8> {
    let mut out = b"# vtk DataFile Version 5.1\nt\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 float\n".to_vec();
    for x in [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0] {
        out.extend(x.to_be_bytes());
    }
    out.extend(b"\nMETADATA\nINFORMATION 0\n\nCELLS 3 7\nOFFSETS vtktypeint64\n");
    [0i64, 3, 7].iter().for_each(|k| out.extend(k.to_be_bytes()));
    out.extend(b"\nCONNECTIVITY vtktypeint64\n");
    [0i64, 2, 1, 0, 1, 2, 3].iter().for_each(|k| out.extend(k.to_be_bytes()));
    out.extend(b"\nCELL_TYPES 2\n");
    [5i32, 10].iter().for_each(|k| out.extend(k.to_be_bytes()));
    out.extend(b"\nCELL_DATA 2\nSCALARS flag bit\nLOOKUP_TABLE default\n\x80\nFIELD f 2\ns 1 2 string\n\xc1a");
    out.extend([0x80, 2]);
    out.extend(b"bc\nafter 1 2 unsigned_char\n\x07\x00\n");
    out
}

#[test]
fn version_51_with_bits_and_texts() {
    let mesh = parse(&version_51()).unwrap();
    assert_eq!((mesh.faces.face(0), mesh.cells.tets.as_slice()), (&[0, 2, 1][..], &[[0, 1, 2, 3]][..]));
    assert_eq!(mesh.attributes.face["flag"], Column::Label(vec![1]));
    assert_eq!(mesh.attributes.face["after"], Column::Label(vec![7]));
    assert!(mesh.notes.len() == 1 && mesh.notes[0].contains("texts"));
}

#[test]
fn errors_say_where() {
    let place = |from: &str, to: &str| parse(SECTIONS.replacen(from, to, 1).as_bytes()).unwrap_err().to_string();
    assert!(place("points 6", "points 6000000000").contains("line 9: "));
    assert!(place("0 1 0  2", "0 x 0  2").contains("line 11: 'x'"));
    assert!(place("4 0 1 2 3", "4 0 1 2 6").contains("point 6"));
    assert!(place("4 0 1 2 3", "5 0 1 2 3").contains("beyond"));
    assert!(place("DATASET POLYDATA", "DATASET RECTILINEAR_GRID").contains("RECTILINEAR_GRID"));
    assert!(place("NORMALS", "ABNORMALS").contains("'ABNORMALS'"));
    assert!(place("POLYGONS", "LINES").contains("twice"));
}

#[test]
fn huge_counts_are_refused_before_they_cost_memory() {
    let binary = b"# vtk DataFile Version 3.0\nt\nBINARY\nDATASET POLYDATA\nPOINTS 9000000000000000000 double\n";
    assert!(parse(binary).is_err());
    assert!(parse(&binary.map(|b| if b == b'9' { b'1' } else { b })).is_err());
}

#[test]
fn what_does_not_fit_is_said() {
    let mut mesh = one_of_everything();
    mesh.attributes.corner.insert("uv".into(), Column::Vector2(vec![[0.0; 2]; 12]));
    let warnings = write(&mesh, &WriteOptions::default(), &mut Vec::new()).unwrap();
    assert!(warnings.len() == 1 && warnings[0].contains("uv"));
    mesh.attributes.corner.clear();
    mesh.attributes.vertex.insert("size".into(), Column::Scalar(vec![f64::NAN; 8]));
    let warnings = |ascii| write(&mesh, &WriteOptions { ascii }, &mut Vec::new()).unwrap();
    assert!(warnings(false).is_empty());
    assert!(warnings(true)[0].contains("not finite"));
}
