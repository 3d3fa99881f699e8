//! The writer: a node with one mesh for each body, triangles in one primitive for each material, and lines, where there
//! are any, in one more.

use super::super::limits::{moved_by_single_precision, words_left_out};
use super::super::small_faces::{fan_corners, label};
use super::super::source::WriteOptions;
use super::super::vtk_cells::check_writable;
use super::srgb::linear_of_srgb;
use super::vertices::{Color, FACE_COLORS, Part, Vertices, are_normals, face_colors, parts};
use crate::error::{Error, Result};
use crate::mesh::{BODIES, Column, RawMesh};
use crate::words::counted;
use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use rustc_hash::FxHashMap;
use serde_json::{Value, json};

/// Component type of 32-bit floats.
const FLOAT: u32 = 5126;
/// Component type of 32-bit unsigned integers.
const UNSIGNED_INT: u32 = 5125;
/// Component type of 16-bit unsigned integers.
const UNSIGNED_SHORT: u32 = 5123;
/// Target of buffer views with vertex attributes.
const ARRAY_BUFFER: u32 = 34962;
/// Target of buffer views with indices.
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
    meshes: Vec<Value>,
    nodes: Vec<Value>,
    materials: Vec<Value>,
    /// The material of a label.
    material_of: FxHashMap<i32, usize>,
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
        let corners = fan_corners(&mesh.faces);
        let mut warnings = left_out(mesh);
        if !mesh.faces.all_triangles() {
            warnings.push("polygons are cut into triangles, from their first corner".to_string());
        }
        let mut asset = Asset::default();
        if mesh.points.is_empty() {
            return Ok((asset, warnings));
        }
        if let Some(at) = mesh.points.iter().position(|p| !p.as_vec3().is_finite()) {
            return Err(Error::input(
                "a coordinate is too large for the single precision of glTF",
                format!("vertex {at}"),
                "scale the mesh down, or write another format",
            ));
        }
        if let Some(moved) = moved_by_single_precision(mesh) {
            warnings.push(format!("glTF has single precision, which moves vertices by up to {moved:.1e}"));
        }
        asset.add_materials(mesh);
        let (column, parts) = parts(mesh, &parents);
        let (mut copies, mut reordered, mut written) = (0, false, 0);
        for part in &parts {
            let vertices = Vertices::new(mesh, part, &triangles, &corners, &parents);
            copies += vertices.copies;
            written += vertices.source.len();
            reordered |= asset.add_part(mesh, column, part, &vertices, &parents);
        }
        if copies > 0 {
            warnings.push(format!(
                "{} written again, where colours, texture coordinates or normals of corners differ",
                counted(copies, "vertex is", "vertices are")
            ));
        }
        if column.is_some() {
            asset.add_lines(mesh);
            warnings.extend(told_of_bodies(mesh, written - copies));
        }
        if reordered || parts.iter().any(|p| p.triangles.windows(2).any(|w| w[1] != w[0] + 1)) {
            warnings.push("faces are in the order of their bodies and materials".to_string());
        }
        Ok((asset, warnings))
    }

    /// The materials that faces use.
    fn add_materials(&mut self, mesh: &RawMesh) {
        let Some(labels) = material_labels(mesh) else { return };
        for &label in labels {
            if label < 0 || self.material_of.contains_key(&label) {
                continue;
            }
            self.material_of.insert(label, self.materials.len());
            let name = mesh.attributes.name("material", label).map_or_else(|| label.to_string(), str::to_string);
            let mut material = json!({ "name": name });
            if let Some([r, g, b, a]) = mesh.attributes.color("material", label) {
                let factor = [linear_of_srgb(r), linear_of_srgb(g), linear_of_srgb(b), f64::from(a) / 255.0];
                material["pbrMetallicRoughness"] = json!({ "baseColorFactor": factor, "metallicFactor": 0.0 });
                if a < u8::MAX {
                    material["alphaMode"] = "BLEND".into();
                }
            }
            self.materials.push(material);
        }
    }

    /// Adds the node of a part; returns whether its triangles had to be put in the order of materials.
    fn add_part(&mut self, mesh: &RawMesh, column: Option<&str>, part: &Part, v: &Vertices, parents: &[u32]) -> bool {
        let attributes = self.attributes(mesh, v);
        let labels = material_labels(mesh);
        let of = |t: u32| labels.map(|l| l[parents[t as usize] as usize]);
        let mut groups: Vec<(Option<i32>, Vec<[u32; 3]>)> = Vec::new();
        let mut place: FxHashMap<Option<i32>, usize> = FxHashMap::default();
        let mut reordered = false;
        for (&t, &triangle) in part.triangles.iter().zip(&v.triangles) {
            let k = *place.entry(of(t)).or_insert(groups.len());
            if k == groups.len() {
                groups.push((of(t), Vec::new()));
            }
            reordered |= k + 1 < groups.len();
            groups[k].1.push(triangle);
        }
        let mut primitives = Vec::new();
        for (label, triangles) in &groups {
            let indices = self.indices(triangles.as_flattened());
            let mut primitive = json!({ "attributes": attributes, "indices": indices, "mode": 4 });
            if let Some(material) = label.and_then(|label| self.material_of.get(&label)) {
                primitive["material"] = json!(material);
            }
            primitives.push(primitive);
        }
        if column.is_none() && !mesh.edges.is_empty() {
            let indices = self.indices(mesh.edges.as_flattened());
            primitives.push(json!({ "attributes": attributes, "indices": indices, "mode": 1 }));
        }
        let name = match (column, part.label) {
            (Some(column), Some(label)) => {
                Some(mesh.attributes.name(column, label).map_or_else(|| label.to_string(), str::to_string))
            }
            _ => mesh.attributes.only_body().map(str::to_string),
        };
        self.add_node(primitives, name);
        reordered
    }

    /// The lines of a mesh with bodies, on vertices of their own.
    fn add_lines(&mut self, mesh: &RawMesh) {
        if mesh.edges.is_empty() {
            return;
        }
        let mut ends: Vec<u32> = mesh.edges.as_flattened().to_vec();
        ends.sort_unstable();
        ends.dedup();
        let place = |v: &u32| ends.binary_search(v).unwrap_or_default() as u32;
        let corners: Vec<u32> = mesh.edges.as_flattened().iter().map(place).collect();
        let attributes = json!({ "POSITION": self.positions(mesh, &ends) });
        let indices = self.indices(&corners);
        self.add_node(vec![json!({ "attributes": attributes, "indices": indices, "mode": 1 })], Some("lines".into()));
    }

    fn add_node(&mut self, primitives: Vec<Value>, name: Option<String>) {
        if primitives.is_empty() {
            return;
        }
        let mut node = json!({ "mesh": self.meshes.len() });
        if let Some(name) = name {
            node["name"] = name.into();
        }
        self.nodes.push(node);
        self.meshes.push(json!({ "primitives": primitives }));
    }

    /// The vertex attributes of a part.
    fn attributes(&mut self, mesh: &RawMesh, vertices: &Vertices) -> Value {
        let mut attributes = json!({ "POSITION": self.positions(mesh, &vertices.source) });
        if let Some(normals) = &vertices.normals {
            let normals: Vec<f32> = normals.as_flattened().iter().map(|&x| x as f32).collect();
            attributes["NORMAL"] = self.floats("VEC3", 3, &normals).into();
        }
        if let Some(uvs) = &vertices.uvs {
            let uvs: Vec<f32> = uvs.as_flattened().iter().map(|&x| x as f32).collect();
            attributes["TEXCOORD_0"] = self.floats("VEC2", 2, &uvs).into();
        }
        if let Some(colors) = &vertices.colors {
            attributes["COLOR_0"] = self.colors(colors).into();
        }
        attributes
    }

    /// Positions, in single precision, and their extent.
    fn positions(&mut self, mesh: &RawMesh, source: &[u32]) -> usize {
        let positions: Vec<f32> =
            source.iter().flat_map(|&v| mesh.points[v as usize].to_array().map(|x| x as f32)).collect();
        let (corners, _) = positions.as_chunks::<3>();
        let fold = |pick: fn(f32, f32) -> f32, start: f32| {
            corners.iter().fold([start; 3], |a, b| std::array::from_fn(|k| pick(a[k], b[k])))
        };
        let (low, high) = (fold(f32::min, f32::INFINITY), fold(f32::max, f32::NEG_INFINITY));
        let accessor = self.floats("VEC3", 3, &positions);
        // The specification asks for the extent of positions.
        self.accessors[accessor]["min"] = json!(low.map(f64::from));
        self.accessors[accessor]["max"] = json!(high.map(f64::from));
        accessor
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
        if !self.meshes.is_empty() {
            let mut buffer = json!({ "byteLength": self.binary.len() });
            if let Some(uri) = uri {
                buffer["uri"] = uri.into();
            }
            document["scenes"] = json!([{ "nodes": (0..self.nodes.len()).collect::<Vec<_>>() }]);
            document["nodes"] = std::mem::take(&mut self.nodes).into();
            document["meshes"] = std::mem::take(&mut self.meshes).into();
            if !self.materials.is_empty() {
                document["materials"] = std::mem::take(&mut self.materials).into();
            }
            document["accessors"] = std::mem::take(&mut self.accessors).into();
            document["bufferViews"] = std::mem::take(&mut self.views).into();
            document["buffers"] = json!([buffer]);
        }
        document
    }
}

/// What vertices go through where bodies are written one by one, `written` of them in all.
fn told_of_bodies(mesh: &RawMesh, written: usize) -> Vec<String> {
    let mut used = vec![false; mesh.points.len()];
    mesh.faces.corners().iter().for_each(|&v| used[v as usize] = true);
    let used = used.iter().filter(|&&u| u).count();
    let mut warnings = Vec::new();
    if used < mesh.points.len() {
        let lost = counted(mesh.points.len() - used, "vertex that no face uses is", "vertices that no face uses are");
        warnings.push(format!("{lost} left out, bodies have none"));
    }
    if written > used {
        let shared = counted(written - used, "vertex is", "vertices are");
        warnings.push(format!("{shared} written again, because bodies share them"));
    }
    warnings
}

/// The labels of materials.
fn material_labels(mesh: &RawMesh) -> Option<&[i32]> {
    label(&mesh.attributes.face, "material")
}

/// What the file will lack.
fn left_out(mesh: &RawMesh) -> Vec<String> {
    let mut warnings = Vec::new();
    let columns = &mesh.attributes;
    let is_look = |name: &str, column: &Column| match (name, column) {
        ("normal", column) => are_normals(column),
        ("uv", Column::Vector2(_)) => true,
        _ => false,
    };
    let by_corner = |name: &str| columns.corner.get(name).is_some_and(|column| is_look(name, column));
    let on_vertex = |(name, column): &(&String, &Column)| match (name.as_str(), column) {
        ("color", Column::Color(_)) => face_colors(mesh).is_none(),
        (name, column) => is_look(name, column) && !by_corner(name),
    };
    let body = BODIES.into_iter().find(|name| label(&columns.face, name).is_some());
    let color = FACE_COLORS.into_iter().find(|name| columns.face.contains_key(*name));
    let on_face = |(name, column): &(&String, &Column)| {
        let name = Some(name.as_str());
        name == color || (matches!(column, Column::Label(_)) && (name == body || name == Some("material")))
    };
    let mut names: Vec<&str> = columns.vertex.iter().filter(|c| !on_vertex(c)).map(|c| c.0.as_str()).collect();
    names.extend(columns.face.iter().filter(|c| !on_face(c)).map(|c| c.0.as_str()));
    names.extend(columns.corner.iter().filter(|(n, c)| !is_look(n, c)).map(|c| c.0.as_str()));
    if !names.is_empty() {
        warnings.push(format!("these values are left out, glTF has no place for them: {}", names.join(", ")));
    }
    let held = |column: &str| Some(column) == body || column == "material";
    warnings.extend(words_left_out("glTF", mesh, held, |column| column == "material"));
    if columns.libraries.iter().any(|library| !library.bytes.is_empty()) {
        warnings.push(
            "of materials, glTF files get name, colour and opacity: textures and further values are left out"
                .to_string(),
        );
    }
    if mesh.edge_tags.iter().any(|&tag| tag != 0) {
        warnings.push("the tags of lines are left out, glTF has none".to_string());
    }
    warnings
}
