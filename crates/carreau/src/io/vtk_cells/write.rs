//! From a mesh to cells and their data.

use super::numbers::{TAGS, kind};
use crate::error::{Error, Result};
use crate::io::limits::words_left_out;
use crate::mesh::{Column, Columns, RawMesh};

/// Visits all cells in the order in which they are written: lines, faces, tetrahedra, hexahedra, wedges, pyramids.
pub fn for_each_cell(mesh: &RawMesh, mut visit: impl FnMut(u8, &[u32])) {
    mesh.edges.iter().for_each(|e| visit(kind::LINE, e));
    if let Some(nodes) = &mesh.second_order {
        let faces = mesh.faces.iter().zip(&nodes.quads);
        faces.for_each(|(face, middles)| visit(kind::BIQUADRATIC_QUAD, &[face, &middles[..]].concat()));
        let cells = mesh.cells.hexes.iter().zip(&nodes.hexes);
        cells.for_each(|(cell, middles)| visit(kind::TRIQUADRATIC_HEXAHEDRON, &[&cell[..], &middles[..]].concat()));
        return;
    }
    for face in mesh.faces.iter() {
        let kind = match face.len() {
            3 => kind::TRIANGLE,
            4 => kind::QUAD,
            _ => kind::POLYGON,
        };
        visit(kind, face);
    }
    mesh.cells.tets.iter().for_each(|c| visit(kind::TETRA, c));
    mesh.cells.hexes.iter().for_each(|c| visit(kind::HEXAHEDRON, c));
    mesh.cells.wedges.iter().for_each(|c| visit(kind::WEDGE, c));
    mesh.cells.pyramids.iter().for_each(|c| visit(kind::PYRAMID, c));
}

/// Cells and their data as VTK lists them.
pub struct CellTable {
    pub kinds: Vec<u8>,
    /// Where the corners of every cell end.
    pub ends: Vec<i64>,
    pub corners: Vec<i64>,
    /// Columns as long as `kinds`.
    pub data: Columns,
}

impl CellTable {
    /// The cells of a mesh that [`check_writable`] accepts.
    pub fn new(mesh: &RawMesh) -> Result<Self> {
        check_writable(mesh)?;
        let mut table =
            CellTable { kinds: Vec::new(), ends: Vec::new(), corners: Vec::new(), data: cell_columns(mesh) };
        for_each_cell(mesh, |kind, corners| {
            table.kinds.push(kind);
            table.corners.extend(corners.iter().map(|&v| i64::from(v)));
            table.ends.push(table.corners.len() as i64);
        });
        Ok(table)
    }
}

/// Checks what a writer relies on: valid indices, and columns as long as what they are on.
pub fn check_writable(mesh: &RawMesh) -> Result<()> {
    mesh.check()?;
    check_columns(&mesh.attributes.vertex, mesh.points.len(), "vertices")?;
    check_columns(&mesh.attributes.face, mesh.faces.len(), "faces")?;
    check_columns(&mesh.attributes.corner, mesh.faces.corners().len(), "corners")
}

pub fn check_columns(columns: &Columns, count: usize, of: &str) -> Result<()> {
    match columns.iter().find(|(_, column)| column.len() != count) {
        Some((name, column)) => {
            Err(Error::input(format!("the attribute '{name}' has {} values for {count} {of}", column.len()), "", ""))
        }
        None => Ok(()),
    }
}

/// The columns of the faces, padded for all cells, and [`TAGS`] where there are any.
pub fn cell_columns(mesh: &RawMesh) -> Columns {
    fn pad<T: Copy>(values: &[T], before: usize, after: usize, zero: T) -> Vec<T> {
        let (before, after) = (std::iter::repeat_n(zero, before), std::iter::repeat_n(zero, after));
        before.chain(values.iter().copied()).chain(after).collect()
    }
    let (before, after) = (mesh.edges.len(), mesh.cells.len());
    let mut columns = Columns::new();
    for (name, column) in &mesh.attributes.face {
        let padded = match column {
            Column::Scalar(v) => Column::Scalar(pad(v, before, after, 0.0)),
            Column::Vector2(v) => Column::Vector2(pad(v, before, after, [0.0; 2])),
            Column::Vector3(v) => Column::Vector3(pad(v, before, after, [0.0; 3])),
            Column::Label(v) => Column::Label(pad(v, before, after, 0)),
            Column::Color(v) => Column::Color(pad(v, before, after, [0; 4])),
        };
        columns.insert(name.clone(), padded);
    }
    let tagged = mesh.edge_tags.iter().take(before).chain(&mesh.cells.tags).any(|&tag| tag != 0);
    let of_faces = columns.remove(TAGS);
    let labels = match &of_faces {
        Some(Column::Label(labels)) => Some(labels.clone()),
        None if tagged => Some(vec![0; before + mesh.faces.len() + after]),
        _ => None,
    };
    if let Some(mut labels) = labels {
        labels.iter_mut().zip(mesh.edge_tags.iter().take(before)).for_each(|(to, &tag)| *to = tag);
        let volume = labels.iter_mut().skip(before + mesh.faces.len());
        volume.zip(&mesh.cells.tags).for_each(|(to, &tag)| *to = tag);
        columns.insert(TAGS.to_string(), Column::Label(labels));
    } else if let Some(column) = of_faces {
        columns.insert(TAGS.to_string(), column);
    }
    columns
}

/// What VTK's formats cannot hold of a mesh.
pub fn warnings(mesh: &RawMesh) -> Vec<String> {
    let mut warnings = Vec::new();
    if !mesh.attributes.corner.is_empty() {
        let names: Vec<&str> = mesh.attributes.corner.keys().map(String::as_str).collect();
        warnings.push(format!("values on face corners are left out, VTK has none: {}", names.join(", ")));
    }
    warnings.extend(words_left_out("VTK", mesh, |_| false, |_| false));
    warnings
}
