//! The writer.

use super::super::limits::{columns_left_out, edges_left_out, require_surface, words_left_out};
use super::super::source::WriteOptions;
use super::super::text::{push_float, push_integer};
use crate::error::Result;
use crate::mesh::{Column, RawMesh};

pub fn write(mesh: &RawMesh, _: &WriteOptions, out: &mut Vec<u8>) -> Result<Vec<String>> {
    require_surface(mesh, "OFF")?;
    let columns = VertexColumns::of(mesh);
    for (part, there) in
        [("ST", columns.uvs.is_some()), ("C", columns.colors.is_some()), ("N", columns.normals.is_some())]
    {
        out.extend_from_slice(if there { part.as_bytes() } else { b"" });
    }
    out.extend_from_slice(b"OFF\n");
    push_integer(out, mesh.points.len());
    out.push(b' ');
    push_integer(out, mesh.faces.len());
    out.extend_from_slice(b" 0\n");
    for (k, point) in mesh.points.iter().enumerate() {
        let [x, y, z] = point.to_array();
        push_float(out, x);
        push_floats(out, &[y, z]);
        columns.push(k, out);
        out.push(b'\n');
    }
    let colors = color_column(mesh.attributes.face.get("color"));
    for (f, face) in mesh.faces.iter().enumerate() {
        push_integer(out, face.len());
        for &v in face {
            out.push(b' ');
            push_integer(out, v);
        }
        if let Some(colors) = colors {
            push_color(out, colors[f]);
        }
        out.push(b'\n');
    }
    Ok(warnings(mesh))
}

/// The columns that OFF holds.
struct VertexColumns<'a> {
    normals: Option<&'a [[f64; 3]]>,
    colors: Option<&'a [[u8; 4]]>,
    uvs: Option<&'a [[f64; 2]]>,
}

impl<'a> VertexColumns<'a> {
    fn of(mesh: &'a RawMesh) -> Self {
        let columns = &mesh.attributes.vertex;
        VertexColumns {
            normals: match columns.get("normal") {
                Some(Column::Vector3(normals)) => Some(normals),
                _ => None,
            },
            colors: color_column(columns.get("color")),
            uvs: match columns.get("uv") {
                Some(Column::Vector2(uvs)) => Some(uvs),
                _ => None,
            },
        }
    }

    /// Appends what vertex `k` has.
    fn push(&self, k: usize, out: &mut Vec<u8>) {
        if let Some(normals) = self.normals {
            push_floats(out, &normals[k]);
        }
        if let Some(colors) = self.colors {
            push_color(out, colors[k]);
        }
        if let Some(uvs) = self.uvs {
            push_floats(out, &uvs[k]);
        }
    }
}

fn color_column(column: Option<&Column>) -> Option<&[[u8; 4]]> {
    match column {
        Some(Column::Color(colors)) => Some(colors),
        _ => None,
    }
}

fn push_floats(out: &mut Vec<u8>, values: &[f64]) {
    for &x in values {
        out.push(b' ');
        push_float(out, x);
    }
}

/// Shares of 1, always with a point: readers take integers for shares of 255.
fn push_color(out: &mut Vec<u8>, color: [u8; 4]) {
    for c in color {
        out.push(b' ');
        out.extend_from_slice(ryu::Buffer::new().format_finite(f64::from(c) / 255.0).as_bytes());
    }
}

fn warnings(mesh: &RawMesh) -> Vec<String> {
    let columns = &mesh.attributes;
    let vertex = columns_left_out("OFF", "vertex", &columns.vertex, |name, column| {
        matches!(
            (name, column),
            ("normal", Column::Vector3(_)) | ("color", Column::Color(_)) | ("uv", Column::Vector2(_))
        )
    });
    let face = columns_left_out("OFF", "face", &columns.face, |name, column| {
        matches!((name, column), ("color", Column::Color(_)))
    });
    let corner = columns_left_out("OFF", "corner", &columns.corner, |_, _| false);
    let words = words_left_out("OFF", mesh, |_| false, |_| false);
    [vertex, face, corner, edges_left_out("OFF", mesh)].into_iter().flatten().chain(words).collect()
}
