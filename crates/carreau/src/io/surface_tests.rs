//! What holds for all surface formats: what is written is read back exactly, and no file makes a reader panic.

use super::formats::format_of;
use super::source::{Source, WriteOptions};
use crate::error::{Error, Result};
use crate::mesh::{Attributes, Cells, Column, Polygons, RawMesh};
use glam::DVec3;
use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;
use std::collections::BTreeMap;
use std::path::Path;

/// Reads bytes as the format that the name's extension says, as [`super::files::read`] does.
pub(super) fn read_as(name: &str, bytes: impl AsRef<[u8]>) -> Result<RawMesh> {
    let path = Path::new(name);
    let mesh = (format_of(path).unwrap().read)(&Source { path, bytes: bytes.as_ref() })?;
    mesh.check()?;
    Ok(mesh)
}

/// The message of the error that reading gives.
pub(super) fn error_of(name: &str, bytes: impl AsRef<[u8]>) -> String {
    match read_as(name, bytes) {
        Ok(mesh) => panic!("read {} vertices and {} faces", mesh.points.len(), mesh.faces.len()),
        Err(e) => e.to_string(),
    }
}

/// The faces as lists.
pub(super) fn faces_of(mesh: &RawMesh) -> Vec<Vec<u32>> {
    mesh.faces.iter().map(<[u32]>::to_vec).collect()
}

fn write_as(name: &str, mesh: &RawMesh, ascii: bool) -> (Vec<u8>, Vec<String>) {
    let mut bytes = Vec::new();
    let warnings = (format_of(Path::new(name)).unwrap().write)(mesh, &WriteOptions { ascii }, &mut bytes).unwrap();
    (bytes, warnings)
}

/// Everything a mesh holds, as text that tells -0 from 0.
fn all_of(mesh: &RawMesh) -> String {
    format!("{:?}\n{:?}\n{:?} {:?}\n{:?}", mesh.points, mesh.faces, mesh.edges, mesh.edge_tags, mesh.attributes)
}

fn assert_survives(name: &str, mesh: &RawMesh, ascii: bool) {
    let (bytes, warnings) = write_as(name, mesh, ascii);
    assert_eq!(warnings, Vec::<String>::new());
    let back = read_as(name, &bytes).unwrap();
    assert_eq!(all_of(&back), all_of(mesh), "{}", String::from_utf8_lossy(&bytes));
    assert_eq!(back.notes, Vec::<String>::new());
}

fn number() -> impl Strategy<Value = f64> {
    let extremes = [0.0, -0.0, 5e-324, -2.2e-308, 1e308, -1e308, f64::MAX, 0.1, 1.0, -1.0, 255.0];
    let any_finite = any::<f64>().prop_filter("finite", |x| x.is_finite());
    prop_oneof![prop::sample::select(extremes.to_vec()), any_finite, -10.0..10.0]
}

fn columns(count: usize) -> impl Strategy<Value = Column> {
    prop_oneof![
        vec(number(), count).prop_map(Column::Scalar),
        vec([number(), number()], count).prop_map(Column::Vector2),
        vec([number(), number(), number()], count).prop_map(Column::Vector3),
        vec(any::<i32>(), count).prop_map(Column::Label),
        vec(any::<[u8; 4]>(), count).prop_map(Column::Color),
    ]
}

fn vectors(count: usize) -> impl Strategy<Value = Column> {
    vec([number(), number(), number()], count).prop_map(Column::Vector3)
}

fn pairs(count: usize) -> impl Strategy<Value = Column> {
    vec([number(), number()], count).prop_map(Column::Vector2)
}

/// Points and polygons; corners may repeat.
fn bare_mesh() -> impl Strategy<Value = RawMesh> {
    vec([number(), number(), number()], 0..12).prop_flat_map(|points| {
        let faces = if points.is_empty() { 0..1 } else { 0..7 };
        let corner = 0..points.len().max(1) as u32;
        vec(vec(corner, 3..6), faces).prop_map(move |faces| RawMesh {
            points: points.iter().map(|&p| DVec3::from_array(p)).collect(),
            faces: faces.iter().map(Vec::as_slice).collect(),
            ..RawMesh::default()
        })
    })
}

fn with_edges(mesh: RawMesh, tags: impl Strategy<Value = i32>) -> impl Strategy<Value = RawMesh> {
    let n = mesh.points.len() as u32;
    let ends = 0..n.max(1);
    vec(([ends.clone(), ends], tags), 0..if n == 0 { 1 } else { 4 }).prop_map(move |edges| RawMesh {
        edges: edges.iter().map(|e| e.0).collect(),
        edge_tags: edges.iter().map(|e| e.1).collect(),
        ..mesh.clone()
    })
}

/// A face column of labels numbered in the order of first use, with words.
fn add_names(attributes: &mut Attributes, column: &str, words: &[String]) {
    let mut seen: Vec<&String> = Vec::new();
    let mut labels = Vec::new();
    for word in words {
        let label = seen.iter().position(|w| *w == word).unwrap_or_else(|| {
            seen.push(word);
            attributes.names.insert((column.into(), seen.len() as i32 - 1), word.clone());
            seen.len() - 1
        });
        labels.push(label as i32);
    }
    attributes.face.insert(column.into(), Column::Label(labels));
}

fn insert(columns: &mut BTreeMap<String, Column>, name: &str, column: Option<Column>) {
    if let Some(column) = column.filter(|c| !c.is_empty()) {
        columns.insert(name.into(), column);
    }
}

fn obj_mesh() -> impl Strategy<Value = RawMesh> {
    let mesh = bare_mesh().prop_flat_map(|mesh| with_edges(mesh, Just(0)));
    mesh.prop_flat_map(|mesh| {
        let (vertices, faces, corners) = (mesh.points.len(), mesh.faces.len(), mesh.faces.corners().len());
        let words = || option::of(vec("[a-zA-Z_][a-z0-9_#.]{0,4}( [a-z0-9]{1,3})?", faces));
        let colors = vec(any::<[u8; 3]>(), vertices)
            .prop_map(|c| Column::Color(c.iter().map(|&[r, g, b]| [r, g, b, 255]).collect()));
        (
            Just(mesh),
            option::of(colors),
            option::of(pairs(corners)),
            option::of(vectors(corners)),
            [words(), words(), words()],
        )
            .prop_map(|(mut mesh, colors, uvs, normals, words)| {
                insert(&mut mesh.attributes.vertex, "color", colors);
                insert(&mut mesh.attributes.corner, "uv", uvs);
                insert(&mut mesh.attributes.corner, "normal", normals);
                for (column, words) in ["group", "object", "material"].iter().zip(words) {
                    if let Some(words) = words.filter(|w| !w.is_empty()) {
                        add_names(&mut mesh.attributes, column, &words);
                    }
                }
                mesh
            })
    })
}

fn off_mesh() -> impl Strategy<Value = RawMesh> {
    bare_mesh().prop_flat_map(|mesh| {
        let (vertices, faces) = (mesh.points.len(), mesh.faces.len());
        let colors = |count| option::of(vec(any::<[u8; 4]>(), count).prop_map(Column::Color));
        (Just(mesh), option::of(vectors(vertices)), colors(vertices), option::of(pairs(vertices)), colors(faces))
            .prop_map(|(mut mesh, normals, colors, uvs, face_colors)| {
                insert(&mut mesh.attributes.vertex, "normal", normals);
                insert(&mut mesh.attributes.vertex, "color", colors);
                insert(&mut mesh.attributes.vertex, "uv", uvs);
                insert(&mut mesh.attributes.face, "color", face_colors);
                mesh
            })
    })
}

fn ply_mesh() -> impl Strategy<Value = RawMesh> {
    let name = || prop::sample::select(vec!["normal", "color", "uv", "region", "u", "v", "kmin", "dmin", "größe"]);
    let mesh = bare_mesh().prop_flat_map(|mesh| with_edges(mesh, any::<i32>()));
    mesh.prop_flat_map(move |mesh| {
        let (vertices, faces) = (mesh.points.len(), mesh.faces.len());
        let some = |count| vec((name(), columns(count)), 0..4);
        (Just(mesh), some(vertices), some(faces)).prop_map(|(mut mesh, vertex, face)| {
            mesh.attributes.vertex = vertex.into_iter().map(|(n, c)| (n.to_string(), c)).collect();
            mesh.attributes.face = face.into_iter().map(|(n, c)| (n.to_string(), c)).collect();
            mesh
        })
    })
}

/// What STL makes of a mesh, by comparing every corner with every vertex so far.
fn welded(mesh: &RawMesh) -> RawMesh {
    let mut out = RawMesh::default();
    for triangle in mesh.faces.fan().0 {
        let ids = triangle.map(|v| {
            let p = mesh.points[v as usize];
            out.points.iter().position(|q| *q == p).unwrap_or_else(|| {
                out.points.push(p);
                out.points.len() - 1
            }) as u32
        });
        out.faces.push(&ids);
    }
    out
}

proptest! {
    #[test]
    fn obj_keeps_everything(mesh in obj_mesh()) {
        assert_survives("a.obj", &mesh, false);
    }

    #[test]
    fn off_keeps_everything(mesh in off_mesh()) {
        assert_survives("a.off", &mesh, false);
    }

    #[test]
    fn ply_keeps_everything(mesh in ply_mesh(), ascii in any::<bool>()) {
        assert_survives("a.ply", &mesh, ascii);
    }

    #[test]
    fn text_stl_keeps_welded_triangles(mesh in bare_mesh(), words in vec("[a-z]{1,2}( #?[a-z]{1,2})?", 40)) {
        let mut mesh = welded(&mesh);
        let words = &words[..mesh.faces.len().min(words.len())];
        if words.len() == mesh.faces.len() && words.iter().any(|w| *w != words[0]) {
            let words: Vec<String> = words.iter().map(|w| w.replace('#', "_")).collect();
            add_names(&mut mesh.attributes, "solid", &words);
            if mesh.attributes.names.len() < 2 {
                mesh.attributes = Attributes::default();
            }
        }
        assert_survives("a.stl", &mesh, true);
    }

    #[test]
    fn binary_stl_keeps_welded_triangles(mesh in bare_mesh()) {
        let single = |p: &DVec3| p.clamp(DVec3::splat(-1e38), DVec3::splat(1e38)).as_vec3().as_dvec3();
        let mesh = RawMesh { points: mesh.points.iter().map(single).collect(), ..mesh };
        assert_survives("a.stl", &welded(&mesh), false);
    }
}

/// A small valid file of every kind that the readers know.
fn samples() -> Vec<(&'static str, Vec<u8>)> {
    let mut mesh = RawMesh {
        points: [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.25], [0.0, 1.0, 0.0]].map(DVec3::from_array).to_vec(),
        faces: [&[0u32, 1, 2][..], &[0, 2, 3], &[0, 1, 2, 3]].into_iter().collect::<Polygons>(),
        edges: vec![[0, 1], [2, 3]],
        edge_tags: vec![3, 4],
        ..RawMesh::default()
    };
    let attributes = &mut mesh.attributes;
    attributes.vertex.insert("color".into(), Column::Color(vec![[1, 2, 3, 255]; 4]));
    attributes.vertex.insert("uv".into(), Column::Vector2(vec![[0.5, 0.25]; 4]));
    attributes.vertex.insert("normal".into(), Column::Vector3(vec![[0.0, 0.0, 1.0]; 4]));
    attributes.face.insert("color".into(), Column::Color(vec![[1, 2, 3, 4]; 3]));
    attributes.face.insert("group".into(), Column::Label(vec![0, 1, 0]));
    attributes.face.insert("solid".into(), Column::Label(vec![0, 1, 0]));
    let mut files = Vec::new();
    for (name, ascii) in
        [("a.obj", true), ("a.off", true), ("a.ply", true), ("a.ply", false), ("a.stl", true), ("a.stl", false)]
    {
        files.push((name, write_as(name, &mesh, ascii).0));
    }
    let mut binary_off = b"OFF BINARY\n".to_vec();
    [3, 1, 0].iter().for_each(|k: &i32| binary_off.extend(k.to_be_bytes()));
    [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().for_each(|x: &f32| binary_off.extend(x.to_be_bytes()));
    [3, 0, 1, 2, 0].iter().for_each(|k: &i32| binary_off.extend(k.to_be_bytes()));
    files.push(("a.off", binary_off));
    let strips = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty int z\n\
                  element tristrips 1\nproperty list int int vertex_indices\nend_header\n\
                  0 0 0\n1 0 0\n0 1 0\n1 1 0\n9 0 1 2 3 -1 1 2 3 0\n";
    files.push(("a.ply", strips.into()));
    files
}

#[test]
fn all_samples_are_valid() {
    for (name, bytes) in samples() {
        assert!(!read_as(name, &bytes).unwrap().faces.is_empty(), "{}", String::from_utf8_lossy(&bytes));
    }
}

/// A change of a file: what, where (as a share of the length), how much.
type Damage = (u8, f64, u8);

fn damage(mut bytes: Vec<u8>, (what, place, amount): Damage) -> Vec<u8> {
    let at = (place * bytes.len() as f64) as usize;
    let end = bytes.len().min(at + 1 + usize::from(amount) % 40);
    match what {
        0 if at < bytes.len() => bytes[at] ^= amount.max(1),
        1 => bytes.truncate(at),
        2 => {
            let block = bytes[at..end].to_vec();
            bytes.splice(at..at, block);
        }
        3 => drop(bytes.drain(at..end)),
        _ => {
            const NUMBERS: [&str; 8] =
                ["4294967295", "-1", "99999999999999999999", "1e400", "nan", "2147483648", "/", "0,5"];
            let digits = bytes[at..].iter().take_while(|b| b.is_ascii_digit()).count();
            bytes.splice(at..at + digits, NUMBERS[usize::from(amount) % 8].bytes());
        }
    }
    bytes
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]
    #[test]
    fn damaged_files_never_panic(
        sample in any::<prop::sample::Index>(),
        damages in vec((0u8..5, 0.0..1.0, any::<u8>()), 1..4),
    ) {
        let samples = samples();
        let (name, bytes) = samples[sample.index(samples.len())].clone();
        let bytes = damages.into_iter().fold(bytes, damage);
        if let Ok(mesh) = read_as(name, &bytes) {
            for other in ["a.obj", "a.off", "a.ply", "a.stl"] {
                write_as(other, &mesh, true);
            }
        }
    }
}

#[test]
fn volume_meshes_are_refused_with_the_remedy() {
    let cells = Cells { tets: vec![[0, 1, 2, 3]], ..Cells::default() };
    let mesh = RawMesh { points: vec![DVec3::ZERO; 4], cells, ..RawMesh::default() };
    for name in ["a.obj", "a.off", "a.ply", "a.stl"] {
        let written = (format_of(Path::new(name)).unwrap().write)(&mesh, &WriteOptions::default(), &mut Vec::new());
        assert!(matches!(written, Err(Error::Input { remedy, .. }) if remedy.contains("convert --boundary")));
    }
}

#[test]
fn warnings_name_what_is_left_out() {
    let mut mesh = RawMesh { points: vec![DVec3::ZERO; 3], ..RawMesh::default() };
    mesh.faces.push(&[0, 1, 2]);
    mesh.edges.push([0, 1]);
    mesh.edge_tags.push(7);
    mesh.attributes.vertex.insert("curvature".into(), Column::Scalar(vec![1.0; 3]));
    mesh.attributes.face.insert("area".into(), Column::Scalar(vec![1.0]));
    mesh.attributes.corner.insert("angle".into(), Column::Scalar(vec![1.0; 3]));
    for (name, words) in [
        ("a.obj", &["'curvature'", "'area'", "'angle'", "tags"][..]),
        ("a.off", &["'curvature'", "'area'", "'angle'", "lines"]),
        ("a.ply", &["'angle'"]),
        ("a.stl", &["'curvature'", "'area'", "'angle'", "lines"]),
    ] {
        let warnings = write_as(name, &mesh, true).1;
        assert_eq!(warnings.len(), words.len(), "{warnings:?}");
        for word in words {
            assert!(warnings.iter().any(|w| w.contains(word)), "{name}: {word} is not in {warnings:?}");
        }
    }
}
