//! The writer: one node with one mesh, triangles in one primitive and lines, where there are any, in a second one.
//!
//! Colours of faces have no place in glTF: where they differ around a vertex, it is written once for each of them.
//!
//! ```text
//!    red ╱│╲ blue         red ╱│ │╲ blue
//!       ╱ │ ╲       →        ╱ │ │ ╲        one vertex more for each end of the border
//! ```

use super::super::WriteOptions;
use super::super::vtk_cells::check_writable;
use super::linear_of_srgb;
use crate::error::{Error, Result};
use crate::mesh::{Column, RawMesh};
use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use rustc_hash::FxHashMap;
use serde_json::{Value, json};

type Color = [u8; 4];
const WHITE: Color = [255; 4];
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const UNSIGNED_SHORT: u32 = 5123;
/// Targets of buffer views: vertex attributes and indices.
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// Writes a `.gltf` file with an embedded buffer; returns warnings about what it cannot hold.
pub fn write_gltf(mesh: &RawMesh, _: &WriteOptions, out: &mut Vec<u8>) -> Result<Vec<String>> {
    let (mut asset, warnings) = Asset::of(mesh)?;
    let data = (!asset.binary.is_empty())
        .then(|| format!("data:application/octet-stream;base64,{}", BASE64.encode(&asset.binary)));
    let document = asset.document(data);
    out.extend_from_slice(document.to_string().as_bytes());
    out.push(b'\n');
    Ok(warnings)
}

/// Writes a `.glb` file; returns warnings about what it cannot hold.
pub fn write_glb(mesh: &RawMesh, _: &WriteOptions, out: &mut Vec<u8>) -> Result<Vec<String>> {
    let (mut asset, warnings) = Asset::of(mesh)?;
    let mut json = asset.document(None).to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    asset.binary.resize(asset.binary.len().next_multiple_of(4), 0);
    let binary_chunk = if asset.binary.is_empty() { 0 } else { 8 + asset.binary.len() };
    let total = 12 + 8 + json.len() + binary_chunk;
    let size = |n: usize| u32::try_from(n).map(u32::to_le_bytes);
    let (Ok(total), Ok(json_size), Ok(binary_size)) = (size(total), size(json.len()), size(asset.binary.len())) else {
        return Err(Error::input("the mesh is too large for a GLB file", "", "write .vtu instead"));
    };
    let head: [&[u8]; 5] = [b"glTF", &2u32.to_le_bytes(), &total, &json_size, b"JSON"];
    head.iter().for_each(|part| out.extend_from_slice(part));
    out.extend_from_slice(&json);
    if !asset.binary.is_empty() {
        out.extend_from_slice(&binary_size);
        out.extend_from_slice(b"BIN\0");
        out.extend_from_slice(&asset.binary);
    }
    Ok(warnings)
}

/// The buffer of a file and what describes it.
#[derive(Default)]
struct Asset {
    binary: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    primitives: Vec<Value>,
}

impl Asset {
    fn of(mesh: &RawMesh) -> Result<(Self, Vec<String>)> {
        if !mesh.cells.is_empty() {
            return Err(Error::input(
                format!("glTF cannot hold the {} volume cells", mesh.cells.len()),
                "",
                "extract the boundary first with `carreau convert --boundary`",
            ));
        }
        check_writable(mesh)?;
        let (triangles, parents) = mesh.faces.fan();
        let mut warnings = left_out(mesh);
        if !mesh.faces.all_triangles() {
            warnings.push("polygons are cut into triangles, from their first corner".to_string());
        }
        let Vertices { source, colors, triangles } = Vertices::new(mesh, &triangles, &parents);
        if source.len() > mesh.points.len() {
            let more = source.len() - mesh.points.len();
            warnings.push(format!("{more} vertices are written again, for the colours of faces to end at edges"));
        }
        let mut asset = Asset::default();
        if source.is_empty() {
            return Ok((asset, warnings));
        }
        let mut attributes = json!({ "POSITION": asset.positions(mesh, &source, &mut warnings)? });
        if let Some(Column::Vector3(normals)) = mesh.attributes.vertex.get("normal").filter(|c| are_normals(c)) {
            let normals: Vec<f32> = source.iter().flat_map(|&v| normals[v as usize].map(|x| x as f32)).collect();
            attributes["NORMAL"] = asset.floats("VEC3", 3, &normals).into();
        }
        if let Some(Column::Vector2(uvs)) = mesh.attributes.vertex.get("uv") {
            let uvs: Vec<f32> = source.iter().flat_map(|&v| uvs[v as usize].map(|x| x as f32)).collect();
            attributes["TEXCOORD_0"] = asset.floats("VEC2", 2, &uvs).into();
        }
        if let Some(colors) = colors {
            attributes["COLOR_0"] = asset.colors(&colors).into();
        }
        let edges = mesh.edges.as_flattened();
        for (mode, corners) in [(4, triangles.as_flattened()), (1, edges)] {
            if !corners.is_empty() {
                let indices = asset.indices(corners);
                asset.primitives.push(json!({ "attributes": attributes, "indices": indices, "mode": mode }));
            }
        }
        Ok((asset, warnings))
    }

    /// Positions, in single precision, and their extent.
    fn positions(&mut self, mesh: &RawMesh, source: &[u32], warnings: &mut Vec<String>) -> Result<usize> {
        let positions: Vec<f32> =
            source.iter().flat_map(|&v| mesh.points[v as usize].to_array().map(|x| x as f32)).collect();
        if let Some(at) = positions.iter().position(|x| !x.is_finite()) {
            let vertex = source[at / 3];
            return Err(Error::input(
                "a coordinate is too large for the single precision of glTF",
                format!("vertex {vertex}"),
                "scale the mesh down, or write another format",
            ));
        }
        let rounded = mesh.points.iter().any(|p| p.to_array().iter().any(|&x| f64::from(x as f32) != x));
        if rounded {
            warnings.push("coordinates are rounded to the single precision of glTF".to_string());
        }
        let (corners, _) = positions.as_chunks::<3>();
        let fold = |pick: fn(f32, f32) -> f32, start: f32| {
            corners.iter().fold([start; 3], |a, b| std::array::from_fn(|k| pick(a[k], b[k])))
        };
        let (low, high) = (fold(f32::min, f32::INFINITY), fold(f32::max, f32::NEG_INFINITY));
        let accessor = self.floats("VEC3", 3, &positions);
        // The specification asks for the extent of positions.
        self.accessors[accessor]["min"] = json!(low.map(f64::from));
        self.accessors[accessor]["max"] = json!(high.map(f64::from));
        Ok(accessor)
    }

    fn floats(&mut self, kind: &str, width: usize, values: &[f32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.accessor(
            &bytes,
            ARRAY_BUFFER,
            json!({ "componentType": FLOAT, "count": values.len() / width, "type": kind }),
        )
    }

    /// Linear intensities in 16 bits, so that all sRGB bytes stay distinct.
    fn colors(&mut self, colors: &[Color]) -> usize {
        let share = |x: f64| ((65535.0 * x).round() as u16).to_le_bytes();
        let of_color = |&[r, g, b, a]: &Color| {
            [linear_of_srgb(r), linear_of_srgb(g), linear_of_srgb(b), f64::from(a) / 255.0].map(share)
        };
        let bytes: Vec<u8> = colors.iter().flat_map(|color| of_color(color).into_iter().flatten()).collect();
        let description =
            json!({ "componentType": UNSIGNED_SHORT, "normalized": true, "count": colors.len(), "type": "VEC4" });
        self.accessor(&bytes, ARRAY_BUFFER, description)
    }

    fn indices(&mut self, corners: &[u32]) -> usize {
        let bytes: Vec<u8> = corners.iter().flat_map(|v| v.to_le_bytes()).collect();
        let description = json!({ "componentType": UNSIGNED_INT, "count": corners.len(), "type": "SCALAR" });
        self.accessor(&bytes, ELEMENT_ARRAY_BUFFER, description)
    }

    /// Adds data, whose length is a multiple of four bytes, as a buffer view with one accessor.
    fn accessor(&mut self, bytes: &[u8], target: u32, mut description: Value) -> usize {
        let offset = self.binary.len();
        self.views.push(json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len(), "target": target }));
        self.binary.extend_from_slice(bytes);
        description["bufferView"] = (self.views.len() - 1).into();
        self.accessors.push(description);
        self.accessors.len() - 1
    }

    fn document(&mut self, uri: Option<String>) -> Value {
        let mut document = json!({
            "asset": { "version": "2.0", "generator": "carreau" },
            "scene": 0,
            "scenes": [{}],
        });
        if !self.primitives.is_empty() {
            let mut buffer = json!({ "byteLength": self.binary.len() });
            if let Some(uri) = uri {
                buffer["uri"] = uri.into();
            }
            document["scenes"] = json!([{ "nodes": [0] }]);
            document["nodes"] = json!([{ "mesh": 0 }]);
            document["meshes"] = json!([{ "primitives": self.primitives }]);
            document["accessors"] = std::mem::take(&mut self.accessors).into();
            document["bufferViews"] = std::mem::take(&mut self.views).into();
            document["buffers"] = json!([buffer]);
        }
        document
    }
}

/// What the file will lack.
fn left_out(mesh: &RawMesh) -> Vec<String> {
    let mut warnings = Vec::new();
    let vertex = &mesh.attributes.vertex;
    let lost = |(name, column): (&String, &Column)| match (name.as_str(), column) {
        ("normal", column) if are_normals(column) => None,
        ("uv", Column::Vector2(_)) => None,
        ("color", Column::Color(_)) if face_colors(mesh).is_none() => None,
        _ => Some(name.clone()),
    };
    let mut names: Vec<String> = vertex.iter().filter_map(lost).collect();
    names.extend(mesh.attributes.face.keys().filter(|name| !FACE_COLORS.contains(&name.as_str())).cloned());
    names.extend(mesh.attributes.corner.keys().cloned());
    if !names.is_empty() {
        warnings.push(format!("these values are left out, glTF has no place for them: {}", names.join(", ")));
    }
    if mesh.edge_tags.iter().any(|&tag| tag != 0) {
        warnings.push("the tags of lines are left out, glTF has none".to_string());
    }
    warnings
}

/// Whether these are the unit normals that glTF asks for.
fn are_normals(column: &Column) -> bool {
    let unit = |n: &[f64; 3]| (n.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-3;
    matches!(column, Column::Vector3(normals) if normals.iter().all(unit))
}

/// Columns of faces that are shown as colours; the first that exists wins.
const FACE_COLORS: [&str; 3] = ["color", "region", "patch"];

/// Colours of the faces: their own, or one for each label.
fn face_colors(mesh: &RawMesh) -> Option<Vec<Color>> {
    FACE_COLORS.iter().find_map(|&name| match mesh.attributes.face.get(name)? {
        Column::Color(colors) => Some(colors.clone()),
        Column::Label(labels) if name != "color" => Some(labels.iter().map(|&label| label_color(label)).collect()),
        _ => None,
    })
}

/// A colour for a label: hues a golden section of the circle apart, so that near labels have distant hues, in three
/// shades.
fn label_color(label: i32) -> Color {
    let turn = f64::from(label) * 0.618_033_988_749_895;
    let hue = 6.0 * (turn - turn.floor());
    let value = [0.95, 0.75, 0.85][label.rem_euclid(3) as usize];
    // A component is full over a third of the circle, and fades out to both sides.
    let component = |center: f64| {
        let distance = (hue - center).abs().min(6.0 - (hue - center).abs());
        let share = (2.0 - distance).clamp(0.0, 1.0);
        (255.0 * value * (0.35 + 0.65 * share)).round() as u8
    };
    [component(0.0), component(2.0), component(4.0), u8::MAX]
}

/// Vertices as they are written.
struct Vertices {
    /// The vertex of the mesh that each is; the first ones are the mesh's own, in order.
    source: Vec<u32>,
    colors: Option<Vec<Color>>,
    triangles: Vec<[u32; 3]>,
}

impl Vertices {
    /// The vertices of the mesh, and copies where faces of different colours meet.
    fn new(mesh: &RawMesh, triangles: &[[u32; 3]], parents: &[u32]) -> Self {
        let count = mesh.points.len();
        let mut source: Vec<u32> = (0..count as u32).collect();
        let Some(of_faces) = face_colors(mesh) else {
            let colors = match mesh.attributes.vertex.get("color") {
                Some(Column::Color(colors)) => Some(colors.clone()),
                _ => None,
            };
            return Vertices { source, colors, triangles: triangles.to_vec() };
        };
        let mut colors: Vec<Option<Color>> = vec![None; count];
        let mut copies: FxHashMap<(u32, Color), u32> = FxHashMap::default();
        let mut colored = |vertex: u32, color: Color| -> u32 {
            match colors[vertex as usize] {
                None => colors[vertex as usize] = Some(color),
                Some(own) if own == color => {}
                Some(_) => {
                    return *copies.entry((vertex, color)).or_insert_with(|| {
                        source.push(vertex);
                        colors.push(Some(color));
                        source.len() as u32 - 1
                    });
                }
            }
            vertex
        };
        let corners = triangles.iter().zip(parents);
        let triangles = corners.map(|(t, &face)| t.map(|v| colored(v, of_faces[face as usize]))).collect();
        let colors = colors.into_iter().map(|color| color.unwrap_or(WHITE)).collect();
        Vertices { source, colors: Some(colors), triangles }
    }
}
