//! The writer: coordinates and columns of numbers in double precision, since that is what the mesh has.

use super::super::limits::{columns_left_out, require_surface, words_left_out};
use super::super::source::WriteOptions;
use super::super::text::{push_float, push_integer};
use super::columns::{Written, properties};
use crate::error::Result;
use crate::mesh::{Column, Columns, RawMesh};
use std::fmt::Write;

pub fn write(mesh: &RawMesh, options: &WriteOptions, out: &mut Vec<u8>) -> Result<Vec<String>> {
    require_surface(mesh, "PLY")?;
    let mut warnings = Vec::new();
    let vertex = RowColumns::new(&mesh.attributes.vertex, &["x", "y", "z"], &mut warnings);
    let face = RowColumns::new(&mesh.attributes.face, &["vertex_indices"], &mut warnings);
    let layout = Layout {
        vertex,
        face,
        long_faces: mesh.faces.iter().any(|f| f.len() > usize::from(u8::MAX)),
        tagged_edges: mesh.edge_tags.iter().any(|&tag| tag != 0),
    };
    out.extend_from_slice(layout.header(mesh, options.ascii).as_bytes());
    if options.ascii {
        layout.write_rows(mesh, &mut Text(out));
    } else {
        layout.write_rows(mesh, &mut Binary(out));
    }
    warnings.extend(columns_left_out("PLY", "corner", &mesh.attributes.corner, |_, _| false));
    warnings.extend(words_left_out("PLY", mesh, |_| false, |_| false));
    Ok(warnings)
}

/// What each row of the file has.
struct Layout<'a> {
    vertex: RowColumns<'a>,
    face: RowColumns<'a>,
    /// Whether some face has more corners than a byte can count.
    long_faces: bool,
    tagged_edges: bool,
}

impl Layout<'_> {
    fn header(&self, mesh: &RawMesh, ascii: bool) -> String {
        let format = if ascii { "ascii" } else { "binary_little_endian" };
        let mut header = format!("ply\nformat {format} 1.0\nelement vertex {}\n", mesh.points.len());
        header += "property double x\nproperty double y\nproperty double z\n";
        self.vertex.declare(&mut header);
        let length = if self.long_faces { "uint" } else { "uchar" };
        let index = if i32::try_from(mesh.points.len()).is_ok() { "int" } else { "uint" };
        // Writing to a string cannot fail.
        let _ = writeln!(header, "element face {}\nproperty list {length} {index} vertex_indices", mesh.faces.len());
        self.face.declare(&mut header);
        if !mesh.edges.is_empty() {
            let _ = writeln!(
                header,
                "element edge {}\nproperty {index} vertex1\nproperty {index} vertex2",
                mesh.edges.len()
            );
            header += if self.tagged_edges { "property int tag\n" } else { "" };
        }
        header + "end_header\n"
    }

    fn write_rows(&self, mesh: &RawMesh, sink: &mut impl Sink) {
        for (k, point) in mesh.points.iter().enumerate() {
            point.to_array().iter().for_each(|&x| sink.double(x));
            self.vertex.write(k, sink);
            sink.end_row();
        }
        for (k, face) in mesh.faces.iter().enumerate() {
            if self.long_faces {
                sink.uint(face.len() as u32);
            } else {
                sink.byte(face.len() as u8);
            }
            face.iter().for_each(|&v| sink.uint(v));
            self.face.write(k, sink);
            sink.end_row();
        }
        let tags = mesh.edge_tags.iter().copied().chain(std::iter::repeat(0));
        for (edge, tag) in mesh.edges.iter().zip(tags) {
            edge.iter().for_each(|&v| sink.uint(v));
            if self.tagged_edges {
                sink.int(tag);
            }
            sink.end_row();
        }
    }
}

/// The columns of an element, with the properties that they are written as.
struct RowColumns<'a>(Vec<(&'a Column, Vec<(String, Written)>)>);

impl<'a> RowColumns<'a> {
    /// `taken` are the names of the other properties.
    fn new(columns: &'a Columns, taken: &[&str], warnings: &mut Vec<String>) -> Self {
        let mut taken: Vec<String> = taken.iter().map(|t| t.to_string()).collect();
        let mut out = Vec::new();
        for (name, column) in columns {
            // Blanks separate words in the header.
            let plain: String =
                name.chars().map(|c| if c.is_whitespace() || c.is_control() { '_' } else { c }).collect();
            let properties = properties(&plain, column);
            if properties.iter().any(|(p, _)| p.is_empty() || taken.contains(p)) {
                warnings.push(format!("left out '{name}': another property of the PLY file has its name"));
                continue;
            }
            taken.extend(properties.iter().map(|(p, _)| p.clone()));
            out.push((column, properties));
        }
        RowColumns(out)
    }

    fn declare(&self, header: &mut String) {
        for (name, written) in self.0.iter().flat_map(|(_, properties)| properties) {
            let _ = writeln!(header, "property {} {name}", written.name());
        }
    }

    #[inline]
    fn write(&self, k: usize, sink: &mut impl Sink) {
        for (column, _) in &self.0 {
            match column {
                Column::Scalar(v) => sink.double(v[k]),
                Column::Vector2(v) => v[k].iter().for_each(|&x| sink.double(x)),
                Column::Vector3(v) => v[k].iter().for_each(|&x| sink.double(x)),
                Column::Label(v) => sink.int(v[k]),
                Column::Color(v) => v[k].iter().for_each(|&c| sink.byte(c)),
            }
        }
    }
}

/// Where values go.
trait Sink {
    fn double(&mut self, x: f64);
    fn int(&mut self, k: i32);
    fn uint(&mut self, k: u32);
    fn byte(&mut self, b: u8);
    fn end_row(&mut self);
}

struct Binary<'a>(&'a mut Vec<u8>);

impl Sink for Binary<'_> {
    fn double(&mut self, x: f64) {
        self.0.extend_from_slice(&x.to_le_bytes());
    }
    fn int(&mut self, k: i32) {
        self.0.extend_from_slice(&k.to_le_bytes());
    }
    fn uint(&mut self, k: u32) {
        self.0.extend_from_slice(&k.to_le_bytes());
    }
    fn byte(&mut self, b: u8) {
        self.0.push(b);
    }
    fn end_row(&mut self) {}
}

/// A blank behind each value; the last of a row becomes the line end.
struct Text<'a>(&'a mut Vec<u8>);

impl Sink for Text<'_> {
    fn double(&mut self, x: f64) {
        push_float(self.0, x);
        self.0.push(b' ');
    }
    fn int(&mut self, k: i32) {
        push_integer(self.0, k);
        self.0.push(b' ');
    }
    fn uint(&mut self, k: u32) {
        push_integer(self.0, k);
        self.0.push(b' ');
    }
    fn byte(&mut self, b: u8) {
        push_integer(self.0, b);
        self.0.push(b' ');
    }
    fn end_row(&mut self) {
        if let Some(last) = self.0.last_mut() {
            *last = b'\n';
        }
    }
}
