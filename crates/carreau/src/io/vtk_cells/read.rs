//! From cells and their data to a mesh.

use super::numbers::{TAGS, kind};
use crate::io::limits::note_higher_order;
use crate::io::text::shown;
use crate::io::vtk_arrays::Array;
use crate::mesh::{Cells, Column, Columns, Polygons, RawMesh, gather_columns};
use glam::DVec3;
use std::collections::BTreeMap;

/// What the cells that are not kept are called.
pub fn name(kind: u8) -> String {
    let name = match kind {
        15 => "pentagonal prisms",
        16 => "hexagonal prisms",
        41 => "convex point sets",
        42 => "polyhedra",
        _ => "cells",
    };
    format!("{name} (VTK cell type {kind})")
}

/// The linear cell with the same corners, which come first, and these; `None` for cells of first order and those that have
/// too few nodes.
pub fn corners_of_higher_order(kind: u8, nodes: &[u32]) -> Option<(u8, &[u32])> {
    let (linear, corners, least) = match kind {
        21 => (kind::LINE, 2, 3),
        35 | 68 | 75 => (kind::LINE, 2, 2),
        22 | 34 => (kind::TRIANGLE, 3, 6),
        69 | 76 => (kind::TRIANGLE, 3, 3),
        23 | 28 | 30 => (kind::QUAD, 4, 6),
        70 | 77 => (kind::QUAD, 4, 4),
        24 => (kind::TETRA, 4, 10),
        71 | 78 => (kind::TETRA, 4, 4),
        25 | 29 | 33 => (kind::HEXAHEDRON, 8, 20),
        72 | 79 => (kind::HEXAHEDRON, 8, 8),
        26 | 31 | 32 => (kind::WEDGE, 6, 12),
        73 | 80 => (kind::WEDGE, 6, 6),
        27 | 37 => (kind::PYRAMID, 5, 13),
        74 | 81 => (kind::PYRAMID, 5, 5),
        // As many nodes between the corners as corners.
        36 if nodes.len().is_multiple_of(2) => (kind::POLYGON, nodes.len() / 2, 6),
        _ => return None,
    };
    (nodes.len() >= least).then(|| nodes.get(..corners)).flatten().map(|corners| (linear, corners))
}

/// The triangles of a strip, all of the sense of the first; those with a repeated corner, which only lead from one part
/// of a strip to the next, are left out.
///
/// ```text
///   1───3───5
///  ╱ ╲ ╱ ╲ ╱     →   (0,1,2) (2,1,3) (2,3,4) (4,3,5)
/// 0───2───4
/// ```
pub fn strip_triangles(strip: &[u32]) -> impl Iterator<Item = [u32; 3]> {
    strip.windows(3).enumerate().filter_map(|(k, w)| match *w {
        [a, b, c] if a == b || b == c || a == c => None,
        [a, b, c] => Some(if k % 2 == 0 { [a, b, c] } else { [b, a, c] }),
        _ => None,
    })
}

/// Elements of one kind and the cell of the file that each came from.
#[derive(Default)]
pub struct Elements<const N: usize> {
    pub(super) corners: Vec<[u32; N]>,
    pub(super) cell: Vec<u32>,
}

impl<const N: usize> Elements<N> {
    pub(super) fn push(&mut self, corners: [u32; N], cell: u32) {
        self.corners.push(corners);
        self.cell.push(cell);
    }
}

/// Collects the cells of a file in the order of its cell data.
#[derive(Default)]
pub struct CellReader {
    pub(super) count: u32,
    pub(super) faces: Polygons,
    pub(super) face_cell: Vec<u32>,
    pub(super) edges: Elements<2>,
    pub(super) tets: Elements<4>,
    pub(super) hexes: Elements<8>,
    pub(super) wedges: Elements<6>,
    pub(super) pyramids: Elements<5>,
    pub(super) left_out: BTreeMap<u8, usize>,
    pub(super) higher_order: usize,
}

impl CellReader {
    /// Adds cells: `ends[k]` is where the corners of cell `k` end; the corners count from the first of `points` points,
    /// of which `shift` others come before. The error says which cell is wrong.
    pub fn add(
        &mut self,
        kinds: &[u8],
        ends: &[usize],
        corners: &[u32],
        shift: usize,
        points: usize,
    ) -> Result<(), String> {
        if kinds.len() != ends.len() {
            return Err(format!("{} cells have {} cell types", ends.len(), kinds.len()));
        }
        let mut start = 0;
        let mut shifted = Vec::new();
        for (&kind, &end) in kinds.iter().zip(ends) {
            let of_cell = corners.get(start..end).ok_or_else(|| {
                format!("the corners of cell {} are {start}..{end} of a list of {}", self.count, corners.len())
            })?;
            start = end;
            shifted.clear();
            for &v in of_cell {
                let place = u32::try_from(v as usize + shift).ok().filter(|_| (v as usize) < points);
                shifted.push(place.ok_or_else(|| {
                    format!("cell {} (0-based) uses point {v} (0-based), there are {points}", self.count)
                })?);
            }
            self.push(kind, &shifted)?;
        }
        if start != corners.len() {
            return Err(format!("{} corners are listed, the cells have {start}", corners.len()));
        }
        Ok(())
    }

    pub(super) fn push(&mut self, kind: u8, corners: &[u32]) -> Result<(), String> {
        if let Some((linear, corners)) = corners_of_higher_order(kind, corners) {
            self.higher_order += 1;
            return self.push(linear, corners);
        }
        let cell = self.count;
        self.count = cell.checked_add(1).ok_or("there are more than 2³² cells")?;
        if self.faces.corners().len() + 3 * corners.len() > u32::MAX as usize {
            return Err("the faces have more than 2³² corners".to_string());
        }
        match (kind, corners) {
            (kind::EMPTY | kind::VERTEX | kind::POLY_VERTEX, _) => {}
            (kind::LINE, &[_, _]) | (kind::POLY_LINE, _) => {
                corners.array_windows().for_each(|&line| self.edges.push(line, cell));
            }
            (kind::TRIANGLE, [_, _, _]) | (kind::QUAD, [_, _, _, _]) | (kind::POLYGON, _) => {
                self.push_face(corners, cell)
            }
            (kind::PIXEL, &[a, b, d, c]) => self.push_face(&[a, b, c, d], cell),
            (kind::TRIANGLE_STRIP, _) => strip_triangles(corners).for_each(|t| self.push_face(&t, cell)),
            (kind::TETRA, &[a, b, c, d]) => self.tets.push([a, b, c, d], cell),
            (kind::VOXEL, &[a, b, d, c, e, f, h, g]) | (kind::HEXAHEDRON, &[a, b, c, d, e, f, g, h]) => {
                self.hexes.push([a, b, c, d, e, f, g, h], cell);
            }
            (kind::WEDGE, &[a, b, c, d, e, f]) => self.wedges.push([a, b, c, d, e, f], cell),
            (kind::PYRAMID, &[a, b, c, d, e]) => self.pyramids.push([a, b, c, d, e], cell),
            (kind::LINE..=kind::PYRAMID, _) => {
                return Err(format!("cell {cell} (0-based) of VTK type {kind} has {} corners", corners.len()));
            }
            _ => *self.left_out.entry(kind).or_default() += 1,
        }
        Ok(())
    }

    pub(super) fn push_face(&mut self, corners: &[u32], cell: u32) {
        self.faces.push(corners);
        self.face_cell.push(cell);
    }

    /// The mesh of these cells on these points, with the arrays that can be columns. `notes` are the reader's own.
    pub fn finish(
        self,
        points: Vec<DVec3>,
        point_data: impl IntoIterator<Item = (String, Array)>,
        cell_data: impl IntoIterator<Item = (String, Array)>,
        notes: Vec<String>,
    ) -> RawMesh {
        let mut mesh = RawMesh { points, notes, ..RawMesh::default() };
        for (&kind, n) in &self.left_out {
            mesh.notes.push(format!("{n} {} are left out", name(kind)));
        }
        mesh.attributes.vertex = columns(point_data, mesh.points.len(), "points", &mut mesh.notes);
        let mut on_cells = columns(cell_data, self.count as usize, "cells", &mut mesh.notes);
        let beside_faces: Vec<u32> = self.edges.cell.iter().copied().chain(self.volume_cells()).collect();
        if let Some(Column::Label(tags)) = on_cells.get(TAGS) {
            let pick = |&cell: &u32| tags[cell as usize];
            mesh.edge_tags = self.edges.cell.iter().map(pick).collect();
            mesh.cells.tags = self.volume_cells().map(|cell| pick(&cell)).collect();
            if !beside_faces.is_empty() && self.face_cell.iter().all(|&cell| tags[cell as usize] == 0) {
                on_cells.remove(TAGS);
            }
        }
        mesh.edge_tags.resize(self.edges.cell.len(), 0);
        let lost = on_cells.iter().filter(|(name, column)| *name != TAGS && has_values(&column.gather(&beside_faces)));
        let lost: Vec<String> = lost.map(|(name, _)| shown(name.as_bytes())).collect();
        if !lost.is_empty() {
            let lost = lost.join(", ");
            mesh.notes.push(format!("cell data are kept on faces only, not on lines and volume cells: {lost}"));
        }
        if !self.face_cell.is_empty() {
            mesh.attributes.face = gather_columns(&on_cells, &self.face_cell);
        }
        mesh.faces = self.faces;
        mesh.edges = self.edges.corners;
        mesh.cells = Cells {
            tets: self.tets.corners,
            hexes: self.hexes.corners,
            wedges: self.wedges.corners,
            pyramids: self.pyramids.corners,
            tags: mesh.cells.tags,
        };
        note_higher_order(&mut mesh, self.higher_order);
        mesh
    }

    /// The file's cells that became volume cells, in the order of [`Cells`].
    pub(super) fn volume_cells(&self) -> impl Iterator<Item = u32> {
        [&self.tets.cell, &self.hexes.cell, &self.wedges.cell, &self.pyramids.cell].into_iter().flatten().copied()
    }
}

/// The arrays that can be columns of `count` elements; what is left out is noted.
pub fn columns(
    arrays: impl IntoIterator<Item = (String, Array)>,
    count: usize,
    of: &str,
    notes: &mut Vec<String>,
) -> Columns {
    let mut columns = Columns::new();
    for (name, array) in arrays {
        let rows = array.rows();
        let shown_name = shown(name.as_bytes());
        if rows != Some(count) {
            let rows = rows.map_or("an incomplete number of".to_string(), |n| n.to_string());
            notes.push(format!("the array '{shown_name}' on {of} is left out: it has {rows} entries for {count} {of}"));
            continue;
        }
        match array.into_column() {
            Ok(column) => {
                columns.insert(name, column);
            }
            Err(why) => notes.push(format!("the array '{shown_name}' on {of} is left out: {why}")),
        }
    }
    columns
}

/// Whether any value differs from the writer's padding.
pub fn has_values(column: &Column) -> bool {
    match column {
        Column::Scalar(v) => v.iter().any(|&x| x != 0.0),
        Column::Vector2(v) => v.as_flattened().iter().any(|&x| x != 0.0),
        Column::Vector3(v) => v.as_flattened().iter().any(|&x| x != 0.0),
        Column::Label(v) => v.iter().any(|&x| x != 0),
        Column::Color(v) => v.as_flattened().iter().any(|&x| x != 0),
    }
}
