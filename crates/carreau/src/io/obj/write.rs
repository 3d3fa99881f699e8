//! The writer.

use super::super::limits::{columns_left_out, require_surface, words_left_out};
use super::super::names::{labels, written_name};
use super::super::source::WriteOptions;
use super::super::text::{push_float, push_integer};
use super::words::NAMES;
use crate::error::Result;
use crate::mesh::{Column, RawMesh};
use rustc_hash::FxHashMap;

pub fn write(mesh: &RawMesh, _: &WriteOptions, out: &mut Vec<u8>) -> Result<Vec<String>> {
    require_surface(mesh, "OBJ")?;
    out.extend_from_slice(b"# carreau\n");
    write_vertices(mesh, out);
    let uvs = CornerIndices::write(mesh, "uv", 2, "vt", out);
    let normals = CornerIndices::write(mesh, "normal", 3, "vn", out);
    write_faces(mesh, &uvs, &normals, out);
    for edge in &mesh.edges {
        push_line(out, "l", &edge.map(|v| u64::from(v) + 1), push_integer);
    }
    Ok(warnings(mesh))
}

fn push_line<T: Copy>(out: &mut Vec<u8>, keyword: &str, values: &[T], push: fn(&mut Vec<u8>, T)) {
    out.extend_from_slice(keyword.as_bytes());
    for &value in values {
        out.push(b' ');
        push(out, value);
    }
    out.push(b'\n');
}

fn write_vertices(mesh: &RawMesh, out: &mut Vec<u8>) {
    match mesh.attributes.vertex.get("color") {
        Some(Column::Color(colors)) => {
            for (p, color) in mesh.points.iter().zip(colors) {
                let [r, g, b, _] = color.map(|c| f64::from(c) / 255.0);
                push_line(out, "v", &[p.x, p.y, p.z, r, g, b], push_float);
            }
        }
        _ => mesh.points.iter().for_each(|p| push_line(out, "v", &p.to_array(), push_float)),
    }
}

/// Which `vt` or `vn` each corner uses.
enum CornerIndices {
    None,
    /// That of its vertex.
    Vertex,
    /// Its own.
    Corner(Vec<u32>),
}

impl CornerIndices {
    /// Writes the statements of a column: those of the corners, or in their absence those of the vertices.
    fn write(mesh: &RawMesh, column: &str, size: usize, keyword: &str, out: &mut Vec<u8>) -> Self {
        if let Some(values) = vectors(mesh.attributes.corner.get(column), size) {
            let mut known: FxHashMap<[u64; 3], u32> = FxHashMap::default();
            let index_of = |value: &[f64]| {
                let mut bits = [0; 3];
                bits.iter_mut().zip(value).for_each(|(b, x)| *b = x.to_bits());
                let next = known.len() as u32;
                *known.entry(bits).or_insert_with(|| {
                    push_line(out, keyword, value, push_float);
                    next
                })
            };
            return CornerIndices::Corner(values.chunks_exact(size).map(index_of).collect());
        }
        match vectors(mesh.attributes.vertex.get(column), size) {
            Some(values) => {
                values.chunks_exact(size).for_each(|value| push_line(out, keyword, value, push_float));
                CornerIndices::Vertex
            }
            None => CornerIndices::None,
        }
    }

    fn of(&self, corner: usize, vertex: u32) -> Option<u64> {
        match self {
            CornerIndices::None => None,
            CornerIndices::Vertex => Some(u64::from(vertex) + 1),
            CornerIndices::Corner(indices) => indices.get(corner).map(|&i| u64::from(i) + 1),
        }
    }
}

/// The numbers of a column of vectors of this size, one vector after the other.
fn vectors(column: Option<&Column>, size: usize) -> Option<&[f64]> {
    match column {
        Some(Column::Vector2(values)) if size == 2 => Some(values.as_flattened()),
        Some(Column::Vector3(values)) if size == 3 => Some(values.as_flattened()),
        _ => None,
    }
}

fn write_faces(mesh: &RawMesh, uvs: &CornerIndices, normals: &CornerIndices, out: &mut Vec<u8>) {
    let columns = NAMES.map(|(keyword, name)| {
        let column = if keyword == "g" { group_column(mesh) } else { name };
        (keyword, column, labels(mesh, column))
    });
    let mut in_force = [None; NAMES.len()];
    let mut corner = 0;
    for (f, face) in mesh.faces.iter().enumerate() {
        for ((keyword, column, labels), last) in columns.iter().zip(&mut in_force) {
            let label = labels.and_then(|l| l.get(f)).copied();
            if let Some(label) = label.filter(|_| label != *last) {
                write_name(mesh, keyword, column, label, out);
                *last = Some(label);
            }
        }
        out.push(b'f');
        for &vertex in face {
            write_corner(vertex, uvs.of(corner, vertex), normals.of(corner, vertex), out);
            corner += 1;
        }
        out.push(b'\n');
    }
}

fn write_name(mesh: &RawMesh, keyword: &str, column: &str, label: i32, out: &mut Vec<u8>) {
    out.extend_from_slice(keyword.as_bytes());
    out.push(b' ');
    if keyword == "g" && column != "group" {
        out.extend_from_slice(column.as_bytes());
        out.push(b'_');
    }
    out.extend_from_slice(written_name(mesh, column, label).as_bytes());
    out.push(b'\n');
}

/// ` v`, ` v/vt`, ` v//vn` or ` v/vt/vn`.
#[inline]
fn write_corner(vertex: u32, uv: Option<u64>, normal: Option<u64>, out: &mut Vec<u8>) {
    out.push(b' ');
    push_integer(out, u64::from(vertex) + 1);
    if uv.is_some() || normal.is_some() {
        out.push(b'/');
    }
    if let Some(uv) = uv {
        push_integer(out, uv);
    }
    if let Some(normal) = normal {
        out.push(b'/');
        push_integer(out, normal);
    }
}

/// The column that becomes groups: `group`, or in its absence `region`, or the only other column of labels.
fn group_column(mesh: &RawMesh) -> &str {
    let columns = &mesh.attributes.face;
    let free = |name: &str| NAMES.iter().all(|&(_, taken)| taken != name);
    let mut labels =
        columns.iter().filter(|(name, c)| matches!(c, Column::Label(_)) && free(name)).map(|(name, _)| name);
    if !columns.contains_key("group") && matches!(columns.get("region"), Some(Column::Label(_))) {
        return "region";
    }
    match (columns.contains_key("group"), labels.next(), labels.next()) {
        (false, Some(only), None) => only,
        _ => "group",
    }
}

fn warnings(mesh: &RawMesh) -> Vec<String> {
    let columns = &mesh.attributes;
    let is_vector = |name: &str, column: &Column| {
        (name == "uv" && matches!(column, Column::Vector2(_)))
            || (name == "normal" && matches!(column, Column::Vector3(_)))
    };
    let vertex = columns_left_out("OBJ", "vertex", &columns.vertex, |name, column| {
        let at_corners = columns.corner.get(name).is_some_and(|c| is_vector(name, c));
        (is_vector(name, column) && !at_corners) || (name == "color" && matches!(column, Column::Color(_)))
    });
    let group = group_column(mesh);
    let face = columns_left_out("OBJ", "face", &columns.face, |name, column| {
        matches!(column, Column::Label(_)) && (name == group || NAMES.iter().any(|&(_, n)| n == name))
    });
    let corner = columns_left_out("OBJ", "corner", &columns.corner, is_vector);
    let regrouped =
        (group != "group").then(|| format!("OBJ: the face labels '{group}' are written as groups {group}_…"));
    let opaque = |c: &[u8; 4]| c[3] == 255;
    let clear = matches!(columns.vertex.get("color"), Some(Column::Color(c)) if !c.iter().all(opaque));
    let clear = clear.then(|| "OBJ has no place for opacity: left out".to_string());
    let tags =
        mesh.edge_tags.iter().any(|&t| t != 0).then(|| "OBJ has no place for the tags of edges: left out".to_string());
    let named = |column: &str| column == group || NAMES.iter().any(|&(_, name)| name == column);
    let words = words_left_out("OBJ", mesh, named, |column| column == "material");
    [vertex, face, corner, regrouped, clear, tags].into_iter().flatten().chain(words).collect()
}
