use super::super::source::{Source, WriteOptions};
use super::super::vtk_cells::samples::{mangle, one_of_everything};
use super::srgb::{linear_of_srgb, srgb_of_linear};
use super::{read, write_glb, write_gltf};
use crate::error::{Error, Result};
use crate::mesh::{Cells, Column, Polygons, RawMesh};
use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use glam::DVec3;
use proptest::prelude::*;
use serde_json::{Value, json};
use std::path::Path;

fn parse(bytes: &[u8]) -> Result<RawMesh> {
    let mesh = read(&Source { path: Path::new("a.gltf"), bytes })?;
    mesh.check()?;
    Ok(mesh)
}

fn written(mesh: &RawMesh, glb: bool) -> (Vec<u8>, Vec<String>) {
    let mut out = Vec::new();
    let write = if glb { write_glb } else { write_gltf };
    let warnings = write(mesh, &WriteOptions::default(), &mut out).unwrap();
    (out, warnings)
}

/// Triangles, lines and the columns that glTF has, in single precision.
fn any_mesh() -> impl Strategy<Value = RawMesh> {
    (1u32..20, 0usize..20, 0usize..4)
        .prop_flat_map(|(n, triangles, edges)| {
            let single = || (-1e30f32..1e30).prop_map(f64::from);
            let points = proptest::collection::vec([single(), single(), single()], n as usize);
            let triangles = proptest::collection::vec([0..n, 0..n, 0..n], triangles);
            let edges = proptest::collection::vec([0..n, 0..n], edges);
            let normals = proptest::collection::vec(
                (0usize..3).prop_map(|k| [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.6f32.into(), 0.8f32.into()]][k]),
                n as usize,
            );
            let uvs = proptest::collection::vec([single(), single()], n as usize);
            let colors = proptest::collection::vec(any::<[u8; 4]>(), n as usize);
            (points, triangles, edges, normals, uvs, colors, any::<[bool; 3]>())
        })
        .prop_map(|(points, triangles, edges, normals, uvs, colors, has)| {
            let mut mesh = RawMesh {
                points: points.into_iter().map(DVec3::from).collect(),
                faces: Polygons::from_triangles(&triangles),
                edge_tags: vec![0; edges.len()],
                edges,
                ..RawMesh::default()
            };
            let columns =
                [("normal", Column::Vector3(normals)), ("uv", Column::Vector2(uvs)), ("color", Column::Color(colors))];
            let kept = columns.into_iter().zip(has).filter(|(_, has)| *has);
            mesh.attributes.vertex = kept.map(|((name, column), _)| (name.to_string(), column)).collect();
            mesh
        })
}

proptest! {
    #[test]
    fn single_precision_comes_back_to_the_last_bit(mesh in any_mesh(), glb in any::<bool>()) {
        let (bytes, warnings) = written(&mesh, glb);
        prop_assert!(warnings.is_empty(), "{:?}", warnings);
        let back = parse(&bytes).unwrap();
        if mesh.faces.is_empty() && mesh.edges.is_empty() {
            // Without primitives there is no mesh, and points alone are not read.
            prop_assert!(back.points.is_empty());
        } else {
            prop_assert_eq!(&back.points, &mesh.points);
            prop_assert_eq!(&back.attributes, &mesh.attributes);
        }
        prop_assert_eq!(back.faces, mesh.faces);
        prop_assert_eq!((back.edges, back.edge_tags), (mesh.edges, mesh.edge_tags));
    }

    /// Colours of faces: same triangles at the same places, every corner in the colour of its face.
    #[test]
    fn faces_keep_their_colors(mesh in any_mesh(), labels in proptest::collection::vec(-3i32..3, 20)) {
        let mut mesh = mesh;
        let labels = labels[..mesh.faces.len()].to_vec();
        mesh.attributes.face.insert("region".into(), Column::Label(labels.clone()));
        let back = parse(&written(&mesh, true).0).unwrap();
        prop_assert_eq!(back.faces.len(), mesh.faces.len());
        let mut color_of = std::collections::BTreeMap::new();
        for (f, (a, b)) in mesh.faces.iter().zip(back.faces.iter()).enumerate() {
            for (&a, &b) in a.iter().zip(b) {
                prop_assert_eq!(mesh.points[a as usize], back.points[b as usize]);
                let Column::Color(colors) = &back.attributes.vertex["color"] else { panic!("colours are expected") };
                prop_assert_eq!(*color_of.entry(labels[f]).or_insert(colors[b as usize]), colors[b as usize]);
            }
        }
        let distinct: std::collections::BTreeSet<_> = color_of.values().collect();
        prop_assert_eq!(distinct.len(), color_of.len());
    }

    #[test]
    fn mangled_files_never_panic(which in 0usize..3, edits in proptest::collection::vec(any::<(u16, u16, u8)>(), 1..6)) {
        let mesh = RawMesh { cells: Cells::default(), ..one_of_everything() };
        let valid = match which {
            0 => written(&mesh, true).0,
            1 => written(&mesh, false).0,
            _ => everything().to_string().into_bytes(),
        };
        let _ = parse(&mangle(valid, &edits));
    }

    /// Numbers of the JSON replaced by others: what mangled bytes seldom reach.
    #[test]
    fn wrong_numbers_never_panic(at in 0usize..120, to in prop_oneof![0u64..20, Just(u64::from(u32::MAX)), Just(u64::MAX)]) {
        fn replace(value: &mut Value, left: &mut usize, to: u64) {
            match value {
                Value::Number(_) if *left == 0 => *value = to.into(),
                Value::Number(_) => {}
                Value::Array(list) => return list.iter_mut().for_each(|v| replace(v, left, to)),
                Value::Object(map) => return map.values_mut().for_each(|v| replace(v, left, to)),
                _ => return,
            }
            *left = left.wrapping_sub(1);
        }
        let mut document = everything();
        replace(&mut document, &mut { at }, to);
        let _ = parse(document.to_string().as_bytes());
    }
}

/// Four points of a unit square, interleaved with other data; four indices in one byte each; one sparse correction.
fn buffer() -> Vec<u8> {
    let mut bytes = Vec::new();
    for [x, y] in [[0.0f32, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]] {
        [x, y, 0.0, 99.0].iter().for_each(|x| bytes.extend(x.to_le_bytes()));
    }
    bytes.extend([0, 1, 2, 3]);
    bytes.extend(3u16.to_le_bytes());
    bytes.extend([0, 0]);
    [1.0f32, 1.0, 0.5].iter().for_each(|x| bytes.extend(x.to_le_bytes()));
    bytes
}

/// A document on [`buffer`] with one primitive of every mode and many features.
fn everything() -> Value {
    let bytes = buffer();
    let primitive = |mode: u32| json!({ "attributes": { "POSITION": 0 }, "indices": 1, "mode": mode });
    json!({
        "asset": { "version": "2.0" },
        "buffers": [{
            "byteLength": bytes.len(),
            "uri": format!("data:application/octet-stream;base64,{}", BASE64.encode(&bytes)),
        }],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 64, "byteStride": 16 },
            { "buffer": 0, "byteOffset": 64, "byteLength": 20 },
        ],
        "accessors": [
            {
                "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
                "sparse": {
                    "count": 1,
                    "indices": { "bufferView": 1, "byteOffset": 4, "componentType": 5123 },
                    "values": { "bufferView": 1, "byteOffset": 8 },
                },
            },
            { "bufferView": 1, "componentType": 5121, "count": 4, "type": "SCALAR" },
            { "bufferView": 1, "componentType": 5121, "count": 3, "type": "SCALAR" },
        ],
        "meshes": [{ "primitives": [
            primitive(0), primitive(1), primitive(2), primitive(3), primitive(5), primitive(6),
            { "attributes": { "POSITION": 0 }, "indices": 2 },
        ] }],
        "nodes": [
            { "children": [1, 2], "translation": [10.0, 0.0, 0.0] },
            { "mesh": 0 },
            { "mesh": 0, "matrix": [-2.0,0.0,0.0,0.0, 0.0,2.0,0.0,0.0, 0.0,0.0,2.0,0.0, 0.0,0.0,1.0,1.0] },
            { "mesh": 0, "scale": [0.0, 0.0, 0.0] },
        ],
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
    })
}

#[test]
fn every_mode_and_nested_transforms() {
    let mesh = parse(everything().to_string().as_bytes()).unwrap();
    // All primitives of an instance share its four vertices.
    assert_eq!(mesh.points.len(), 8);
    assert_eq!(mesh.points[3], DVec3::new(11.0, 1.0, 0.5), "the sparse value, moved");
    assert_eq!(mesh.points[7], DVec3::new(8.0, 2.0, 2.0), "scaled and mirrored, then moved");
    let faces: Vec<&[u32]> = mesh.faces.iter().collect();
    assert_eq!(faces[..5], [[0, 1, 2], [2, 1, 3], [0, 1, 2], [0, 2, 3], [0, 1, 2]]);
    let lines = [[0, 1], [2, 3], [0, 1], [1, 2], [2, 3], [3, 0], [0, 1], [1, 2], [2, 3]];
    assert_eq!(mesh.edges[..9], lines);
    // The mirrored copy shows the same side: signed areas seen from above agree.
    let area = |f: &[u32]| {
        let [a, b, c] = [0, 1, 2].map(|k| mesh.points[f[k] as usize]);
        (b - a).cross(c - a).z
    };
    assert!(faces.iter().take(5).zip(&faces[5..]).all(|(a, b)| area(a) * area(b) > 0.0));
    assert!(mesh.notes.iter().any(|note| note.contains("points")));
}

#[test]
fn which_nodes_are_shown() {
    let count = |change: fn(&mut Value)| {
        let mut document = everything();
        change(&mut document);
        parse(document.to_string().as_bytes()).map(|mesh| mesh.points.len())
    };
    let remove = |document: &mut Value, key: &str| drop(document.as_object_mut().unwrap().remove(key));
    // Without a scene all nodes are shown, without nodes all meshes.
    assert_eq!(count(|_| ()).unwrap(), 8);
    let mut document = everything();
    remove(&mut document, "scene");
    assert_eq!(parse(document.to_string().as_bytes()).unwrap().points.len(), 8);
    remove(&mut document, "scenes");
    assert_eq!(parse(document.to_string().as_bytes()).unwrap().points.len(), 12);
    remove(&mut document, "nodes");
    assert_eq!(parse(document.to_string().as_bytes()).unwrap().points.len(), 4);
    // Nodes must be trees.
    for child in [0, 1, 2] {
        let mut document = everything();
        document["nodes"][1]["children"] = json!([child]);
        assert!(parse(document.to_string().as_bytes()).unwrap_err().to_string().contains("ancestor"), "{child}");
        remove(&mut document, "scenes");
        remove(&mut document, "scene");
        assert!(parse(document.to_string().as_bytes()).is_err(), "{child}");
    }
    assert!(count(|d| d["scene"] = 1.into()).is_err());
    assert!(count(|d| d["nodes"][1]["mesh"] = 1.into()).is_err());
}

#[test]
fn values_that_not_all_primitives_have_are_zero_elsewhere() {
    let mut document = everything();
    document["accessors"][0]["normalized"] = false.into();
    document["meshes"][0]["primitives"][4]["attributes"]["NORMAL"] = 0.into();
    let mesh = parse(document.to_string().as_bytes()).unwrap();
    let Column::Vector3(normals) = &mesh.attributes.vertex["normal"] else { panic!("normals") };
    assert_eq!(normals.len(), mesh.points.len());
    let with = normals.iter().filter(|n| **n != [0.0; 3]).count();
    assert!(with > 0 && with < normals.len(), "{with}");
    assert!(mesh.notes.iter().any(|note| note.contains("'normal' is 0 0 0")), "{:?}", mesh.notes);
    assert!(!mesh.attributes.vertex.contains_key("uv"));
}

#[test]
fn errors_say_what() {
    let error = |pointer: &str, to: Value| {
        let mut document = everything();
        *document.pointer_mut(pointer).unwrap() = to;
        parse(document.to_string().as_bytes()).unwrap_err().to_string()
    };
    assert!(error("/asset/version", "1.0".into()).contains("version 1.0"));
    assert!(error("/accessors/0/count", 5.into()).contains("accessor 0: 5 elements"));
    assert!(error("/accessors/0/count", u64::MAX.into()).contains("accessor 0"));
    assert!(error("/accessors/0/bufferView", 7.into()).contains("buffer view 7 does not exist"));
    assert!(error("/accessors/0/type", "VEC2".into()).contains("VEC3 is expected"));
    assert!(error("/accessors/0/componentType", 5124.into()).contains("5124"));
    assert!(error("/accessors/0/sparse/count", 9.into()).contains("accessor 0"));
    assert!(error("/bufferViews/0/byteStride", 4.into()).contains("4 bytes apart"));
    assert!(error("/bufferViews/0/byteStride", 0.into()).contains("0 bytes apart"));
    assert!(error("/buffers/0/byteLength", 1000.into()).contains("1000 are announced"));
    assert!(error("/buffers/0/uri", "data:text/plain,abc".into()).contains("base64"));
    assert!(error("/buffers/0/uri", "data:;base64,!".into()).contains("base64"));
    assert!(error("/meshes/0/primitives/6/indices", 1.into()).contains("whole elements"));
    assert!(error("/meshes/0/primitives/1/mode", 8.into()).contains("mode 8"));
    assert!(error("/nodes/0/children/0", 9.into()).contains("node 9"));
    assert!(parse(b"{\n\"asset\": 1").unwrap_err().to_string().contains("line 2"));
    let mut document = everything();
    document["extensionsRequired"] = json!(["KHR_texture_transform", "KHR_draco_mesh_compression"]);
    let error = parse(document.to_string().as_bytes()).unwrap_err().to_string();
    assert!(error.contains("KHR_draco_mesh_compression"));
}

#[test]
fn zeros_without_data_are_bounded_by_the_file() {
    let mut document = everything();
    document["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    assert_eq!(parse(document.to_string().as_bytes()).unwrap().points[0], DVec3::new(10.0, 0.0, 0.0));
    document["accessors"][0]["count"] = 4_000_000_000u32.into();
    assert!(parse(document.to_string().as_bytes()).unwrap_err().to_string().contains("without data"));
}

#[test]
fn meshes_used_too_many_times_are_refused() {
    let mut document = everything();
    let primitive = json!({ "attributes": { "POSITION": 0 }, "indices": 1, "mode": 5 });
    let many = |n: usize, value: &Value| Value::Array(vec![value.clone(); n]);
    document["meshes"][0]["primitives"] = many(1000, &primitive);
    document["nodes"] = many(1000, &json!({ "mesh": 0 }));
    document["scenes"][0]["nodes"] = (0..1000).collect();
    assert!(parse(document.to_string().as_bytes()).unwrap_err().to_string().contains("used many times"));
}

#[test]
fn external_buffers_lie_beside_the_file() {
    let folder = std::env::temp_dir().join(format!("carreau-gltf-{}", std::process::id()));
    std::fs::create_dir_all(folder.join("a b")).unwrap();
    std::fs::write(folder.join("a b").join("é.bin"), buffer()).unwrap();
    let path = folder.join("a.gltf");
    let with = |uri: &str| {
        let mut document = everything();
        document["buffers"][0]["uri"] = uri.into();
        read(&Source { path: &path, bytes: document.to_string().as_bytes() })
    };
    let inside = with("a%20b/%C3%A9.bin");
    let missing = with("a%20b/missing.bin").unwrap_err().to_string();
    let outside =
        ["../x.bin", "a%20b/../../x.bin", "/etc/passwd", "%2Fetc/passwd", "file:///etc/passwd", "C:\\x.bin", ""];
    let refused = outside.map(|uri| with(uri).unwrap_err().to_string());
    let folder_named = with("a%20b").is_err();
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!(inside.unwrap().points.len(), 8);
    assert!(missing.contains("missing.bin") && missing.contains("a.gltf"), "{missing}");
    assert!(refused.iter().all(|error| error.contains("outside")), "{refused:?}");
    assert!(folder_named);
}

#[test]
fn glb_chunks_are_checked() {
    let mesh = RawMesh { cells: Cells::default(), ..one_of_everything() };
    let (valid, _) = written(&mesh, true);
    assert!(parse(&valid).is_ok());
    for end in [0, 11, 19, 30, valid.len() - 1] {
        assert!(parse(&valid[..end]).is_err(), "{end}");
    }
    let mut old = valid.clone();
    old[4] = 1;
    assert!(parse(&old).unwrap_err().to_string().contains("version 1"));
    // What follows the announced length is not part of the file.
    assert!(parse(&[valid, b"rest".to_vec()].concat()).is_ok());
}

#[test]
fn what_gltf_cannot_hold_is_said() {
    let refused = write_glb(&one_of_everything(), &WriteOptions::default(), &mut Vec::new());
    assert!(matches!(refused, Err(Error::Input { remedy, .. }) if remedy.contains("--boundary")));
    let mut mesh = RawMesh { cells: Cells::default(), ..one_of_everything() };
    mesh.points.iter_mut().for_each(|p| p.x += 1e7 + 0.1);
    let (bytes, warnings) = written(&mesh, true);
    for lost in ["single precision", "size", "tags", "cut into triangles", "written again"] {
        assert_eq!(warnings.iter().filter(|w| w.contains(lost)).count(), 1, "{lost}: {warnings:?}");
    }
    let (triangles, _) = mesh.faces.fan();
    assert_eq!(parse(&bytes).unwrap().faces.len(), triangles.len());
    mesh.points[1].y = 1e39;
    let refused = write_glb(&mesh, &WriteOptions::default(), &mut Vec::new());
    assert!(matches!(refused, Err(Error::Input { place, .. }) if place == "vertex 1"));
}

#[test]
fn a_mesh_without_elements_is_written_and_read() {
    for glb in [false, true] {
        let back = parse(&written(&RawMesh::default(), glb).0).unwrap();
        assert!(back.points.is_empty() && back.notes.len() == 1);
    }
}

#[test]
fn colors_survive_sixteen_bits() {
    for byte in 0..=255u8 {
        let stored = (65535.0 * linear_of_srgb(byte)).round() / 65535.0;
        assert_eq!(srgb_of_linear(stored), byte);
    }
}
