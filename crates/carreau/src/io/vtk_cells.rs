//! VTK's cell types to and from [`RawMesh`], with the data on points and cells; shared by the legacy and XML formats.
//!
//! VTK numbers all cells of a dataset in one list and its cell data follows that list. [`RawMesh`] keeps faces, lines and
//! volume cells apart, with columns on faces only. So the reader notes for every element which cell it came from, and
//! gathers the columns of the faces; the writer pads them with zeros for the lines before and the volume cells behind.
//! The column [`TAGS`] is the exception: it carries the reference numbers of lines and volume cells too.
//!
//! Corner orders are VTK's (M. Schroeder et al., *The Visualization Toolkit*, figure "linear cell types"), except for the
//! two cells of image data, whose corners come in grid order:
//!
//! ```text
//! pixel (8)   2───3        quad   3───2        voxel (11): two such layers, one above the other
//!             │   │    →          │   │
//!             0───1               0───1
//! ```

use super::limits::{note_higher_order, words_left_out};
use super::text::shown;
use super::vtk_arrays::Array;
use crate::error::{Error, Result};
use crate::mesh::{Cells, Column, Columns, Polygons, RawMesh, gather_columns};
use glam::DVec3;
use std::collections::BTreeMap;

/// The cell data array with the reference numbers of lines, faces and volume cells.
pub(super) const TAGS: &str = "ref";

/// Numbers of the cell types, as in `vtkCellType.h`.
pub(super) mod kind {
    pub const EMPTY: u8 = 0;
    pub const VERTEX: u8 = 1;
    pub const POLY_VERTEX: u8 = 2;
    pub const LINE: u8 = 3;
    pub const POLY_LINE: u8 = 4;
    pub const TRIANGLE: u8 = 5;
    pub const TRIANGLE_STRIP: u8 = 6;
    pub const POLYGON: u8 = 7;
    pub const PIXEL: u8 = 8;
    pub const QUAD: u8 = 9;
    pub const TETRA: u8 = 10;
    pub const VOXEL: u8 = 11;
    pub const HEXAHEDRON: u8 = 12;
    pub const WEDGE: u8 = 13;
    pub const PYRAMID: u8 = 14;
    pub const BIQUADRATIC_QUAD: u8 = 28;
    pub const TRIQUADRATIC_HEXAHEDRON: u8 = 29;
}

/// What the cells that are not kept are called.
fn name(kind: u8) -> String {
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
fn corners_of_higher_order(kind: u8, nodes: &[u32]) -> Option<(u8, &[u32])> {
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
pub(super) fn strip_triangles(strip: &[u32]) -> impl Iterator<Item = [u32; 3]> {
    strip.windows(3).enumerate().filter_map(|(k, w)| match *w {
        [a, b, c] if a == b || b == c || a == c => None,
        [a, b, c] => Some(if k % 2 == 0 { [a, b, c] } else { [b, a, c] }),
        _ => None,
    })
}

/// Elements of one kind and the cell of the file that each came from.
#[derive(Default)]
struct Elements<const N: usize> {
    corners: Vec<[u32; N]>,
    cell: Vec<u32>,
}

impl<const N: usize> Elements<N> {
    fn push(&mut self, corners: [u32; N], cell: u32) {
        self.corners.push(corners);
        self.cell.push(cell);
    }
}

/// Collects the cells of a file in the order of its cell data.
#[derive(Default)]
pub(super) struct CellReader {
    count: u32,
    faces: Polygons,
    face_cell: Vec<u32>,
    edges: Elements<2>,
    tets: Elements<4>,
    hexes: Elements<8>,
    wedges: Elements<6>,
    pyramids: Elements<5>,
    left_out: BTreeMap<u8, usize>,
    higher_order: usize,
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
    ) -> std::result::Result<(), String> {
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

    fn push(&mut self, kind: u8, corners: &[u32]) -> std::result::Result<(), String> {
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

    fn push_face(&mut self, corners: &[u32], cell: u32) {
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
    fn volume_cells(&self) -> impl Iterator<Item = u32> {
        [&self.tets.cell, &self.hexes.cell, &self.wedges.cell, &self.pyramids.cell].into_iter().flatten().copied()
    }
}

/// The arrays that can be columns of `count` elements; what is left out is noted.
fn columns(
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
fn has_values(column: &Column) -> bool {
    match column {
        Column::Scalar(v) => v.iter().any(|&x| x != 0.0),
        Column::Vector2(v) => v.as_flattened().iter().any(|&x| x != 0.0),
        Column::Vector3(v) => v.as_flattened().iter().any(|&x| x != 0.0),
        Column::Label(v) => v.iter().any(|&x| x != 0),
        Column::Color(v) => v.as_flattened().iter().any(|&x| x != 0),
    }
}

/// Visits all cells in the order in which they are written: lines, faces, tetrahedra, hexahedra, wedges, pyramids.
pub(super) fn for_each_cell(mesh: &RawMesh, mut visit: impl FnMut(u8, &[u32])) {
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
pub(super) struct CellTable {
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
pub(super) fn check_writable(mesh: &RawMesh) -> Result<()> {
    mesh.check()?;
    check_columns(&mesh.attributes.vertex, mesh.points.len(), "vertices")?;
    check_columns(&mesh.attributes.face, mesh.faces.len(), "faces")?;
    check_columns(&mesh.attributes.corner, mesh.faces.corners().len(), "corners")
}

fn check_columns(columns: &Columns, count: usize, of: &str) -> Result<()> {
    match columns.iter().find(|(_, column)| column.len() != count) {
        Some((name, column)) => {
            Err(Error::input(format!("the attribute '{name}' has {} values for {count} {of}", column.len()), "", ""))
        }
        None => Ok(()),
    }
}

/// The columns of the faces, padded for all cells, and [`TAGS`] where there are any.
fn cell_columns(mesh: &RawMesh) -> Columns {
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
pub(super) fn warnings(mesh: &RawMesh) -> Vec<String> {
    let mut warnings = Vec::new();
    if !mesh.attributes.corner.is_empty() {
        let names: Vec<&str> = mesh.attributes.corner.keys().map(String::as_str).collect();
        warnings.push(format!("values on face corners are left out, VTK has none: {}", names.join(", ")));
    }
    warnings.extend(words_left_out("VTK", mesh, |_| false, |_| false));
    warnings
}

/// Meshes for the tests of the VTK formats.
#[cfg(test)]
pub(super) mod samples {
    use super::*;
    use proptest::prelude::*;

    fn column(n: usize) -> impl Strategy<Value = Column> {
        // A NaN has many bit patterns in binary and one in text.
        let real = || any::<f64>().prop_map(|x| if x.is_nan() { f64::NAN } else { x });
        prop_oneof![
            proptest::collection::vec(real(), n).prop_map(Column::Scalar),
            proptest::collection::vec([real(), real()], n).prop_map(Column::Vector2),
            proptest::collection::vec([real(), real(), real()], n).prop_map(Column::Vector3),
            proptest::collection::vec(any::<i32>(), n).prop_map(Column::Label),
            proptest::collection::vec(any::<[u8; 4]>(), n).prop_map(Column::Color),
        ]
    }

    fn columns(n: usize) -> impl Strategy<Value = Columns> {
        proptest::collection::btree_map("[a-z]{1,3}[ -~é]{0,4}", column(n), 0..4)
            .prop_map(|mut columns| {
                columns.remove(TAGS);
                columns
            })
            .no_shrink()
    }

    /// Any mesh that a file can hold; `volume` says whether it may have volume cells.
    pub fn any_mesh(volume: bool) -> impl Strategy<Value = RawMesh> {
        let sizes = (1u32..20, 0usize..12, 0usize..4, 0usize..if volume { 3 } else { 1 });
        sizes
            .prop_flat_map(move |(points, faces, edges, cells)| {
                let vertex = 0..points;
                let coordinate =
                    || proptest::num::f64::NORMAL | proptest::num::f64::SUBNORMAL | proptest::num::f64::ZERO;
                let corners = proptest::collection::vec(vertex.clone(), 3..6);
                let tags = |n| proptest::collection::vec(-3i32..4, n);
                fn of<const N: usize>(vertex: std::ops::Range<u32>, n: usize) -> impl Strategy<Value = Vec<[u32; N]>> {
                    proptest::collection::vec(std::array::from_fn::<_, N, _>(|_| vertex.clone()), n)
                }
                (
                    proptest::collection::vec([coordinate(), coordinate(), coordinate()], points as usize),
                    proptest::collection::vec(corners, faces),
                    (of::<2>(vertex.clone(), edges), tags(edges)),
                    (
                        of::<4>(vertex.clone(), cells),
                        of::<8>(vertex.clone(), cells),
                        of::<6>(vertex.clone(), cells),
                        of::<5>(vertex, cells),
                        tags(4 * cells),
                    ),
                    (columns(points as usize), columns(faces)),
                )
            })
            .prop_map(|(points, faces, (edges, edge_tags), (tets, hexes, wedges, pyramids, tags), (vertex, face))| {
                let mut mesh = RawMesh {
                    points: points.into_iter().map(DVec3::from).collect(),
                    faces: faces.iter().map(Vec::as_slice).collect(),
                    edges,
                    edge_tags,
                    cells: Cells { tets, hexes, wedges, pyramids, tags },
                    ..RawMesh::default()
                };
                mesh.attributes.vertex = vertex;
                // VTK has no cell data without cells.
                mesh.attributes.face = if mesh.faces.is_empty() { Columns::new() } else { face };
                mesh
            })
    }

    fn bits(column: &Column) -> Vec<u64> {
        match column {
            Column::Scalar(v) => v.iter().map(|x| x.to_bits()).collect(),
            Column::Vector2(v) => v.as_flattened().iter().map(|x| x.to_bits()).collect(),
            Column::Vector3(v) => v.as_flattened().iter().map(|x| x.to_bits()).collect(),
            Column::Label(v) => v.iter().map(|&x| x as u64).collect(),
            Column::Color(v) => v.iter().map(|&x| u64::from(u32::from_le_bytes(x))).collect(),
        }
    }

    fn assert_same_columns(a: &Columns, b: &Columns) {
        assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>());
        for (name, column) in a {
            assert_eq!(std::mem::discriminant(column), std::mem::discriminant(&b[name]), "{name}");
            assert_eq!(bits(column), bits(&b[name]), "{name}");
        }
    }

    /// That two meshes are the same to the last bit.
    pub fn assert_same(a: &RawMesh, b: &RawMesh) {
        let bits = |m: &RawMesh| m.points.iter().map(|p| p.to_array().map(f64::to_bits)).collect::<Vec<_>>();
        assert_eq!(bits(a), bits(b));
        assert_eq!(a.faces, b.faces);
        assert_eq!((&a.edges, &a.edge_tags), (&b.edges, &b.edge_tags));
        let tags = |m: &RawMesh| if m.cells.tags.iter().all(|&t| t == 0) { Vec::new() } else { m.cells.tags.clone() };
        assert_eq!(tags(a), tags(b));
        assert_eq!(Cells { tags: vec![], ..a.cells.clone() }, Cells { tags: vec![], ..b.cells.clone() });
        assert_same_columns(&a.attributes.vertex, &b.attributes.vertex);
        assert_same_columns(&a.attributes.face, &b.attributes.face);
    }

    /// A small mesh with one of everything.
    pub fn one_of_everything() -> RawMesh {
        let mut mesh = RawMesh {
            points: (0..8).map(|k| DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2))).collect(),
            faces: [&[0u32, 1, 3][..], &[0, 1, 3, 2], &[0, 1, 5, 7, 4]].into_iter().collect(),
            edges: vec![[0, 1], [6, 7]],
            edge_tags: vec![5, 0],
            cells: Cells {
                tets: vec![[0, 1, 2, 4]],
                hexes: vec![[0, 1, 3, 2, 4, 5, 7, 6]],
                wedges: vec![[0, 1, 2, 4, 5, 6]],
                pyramids: vec![[0, 1, 3, 2, 4]],
                tags: vec![1, 2, 3, 4],
            },
            ..RawMesh::default()
        };
        mesh.attributes.vertex.insert("size".into(), Column::Scalar((0..8).map(|k| 0.1 * f64::from(k)).collect()));
        mesh.attributes.face.insert("region".into(), Column::Label(vec![7, -8, 9]));
        mesh.attributes.face.insert("u".into(), Column::Vector3(vec![[0.1, 0.2, 0.3]; 3]));
        mesh
    }

    /// Flips, cuts out and repeats bytes; `edits` are (place, other place, byte) as shares of the length.
    pub fn mangle(mut bytes: Vec<u8>, edits: &[(u16, u16, u8)]) -> Vec<u8> {
        for &(at, to, byte) in edits {
            let place = |share: u16| (bytes.len() * usize::from(share)) >> 16;
            let (at, to) = (place(at), place(to));
            match byte % 5 {
                0 => bytes.truncate(at.max(to)),
                1 => drop(bytes.drain(at.min(to)..at.max(to))),
                2 => {
                    let copy = bytes[at.min(to)..at.max(to)].to_vec();
                    bytes.splice(at..at, copy);
                }
                _ if at < bytes.len() => bytes[at] = byte,
                _ => {}
            }
        }
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::super::vtk_arrays::Values;
    use super::*;

    fn read(cells: &[(u8, &[u32])], data: Vec<(String, Array)>) -> RawMesh {
        let mut reader = CellReader::default();
        let points: Vec<DVec3> = (0..12).map(|k| DVec3::splat(f64::from(k))).collect();
        for (kind, corners) in cells {
            reader.add(&[*kind], &[corners.len()], corners, 0, points.len()).unwrap();
        }
        let mesh = reader.finish(points, Vec::new(), data, Vec::new());
        mesh.check().unwrap();
        mesh
    }

    fn labels(values: Vec<i64>) -> Array {
        Array { values: Values::Integers(values), width: 1 }
    }

    #[test]
    fn data_follow_faces_through_strips_and_other_cells() {
        let cells: [(u8, &[u32]); 5] =
            [(1, &[0]), (6, &[0, 1, 2, 3]), (4, &[0, 1, 2]), (9, &[4, 5, 6, 7]), (10, &[0, 1, 2, 4])];
        let mesh = read(&cells, vec![("region".into(), labels(vec![10, 11, 12, 13, 14]))]);
        assert_eq!(mesh.faces.iter().collect::<Vec<_>>(), [&[0, 1, 2][..], &[2, 1, 3], &[4, 5, 6, 7]]);
        assert_eq!(mesh.attributes.face["region"], Column::Label(vec![11, 11, 13]));
        assert_eq!(mesh.edges, [[0, 1], [1, 2]]);
        assert_eq!(mesh.notes.len(), 1, "the values on the line and the tetrahedron: {:?}", mesh.notes);
    }

    #[test]
    fn tags_are_kept_on_every_kind_of_cell() {
        let cells: [(u8, &[u32]); 4] =
            [(12, &[0, 1, 2, 3, 4, 5, 6, 7]), (3, &[0, 1]), (5, &[0, 1, 2]), (10, &[0, 1, 2, 4])];
        let mesh = read(&cells, vec![(TAGS.into(), labels(vec![1, 2, 3, 4]))]);
        assert_eq!((mesh.edge_tags, mesh.cells.tags), (vec![2], vec![4, 1]));
        assert_eq!(mesh.attributes.face[TAGS], Column::Label(vec![3]));
        assert!(mesh.notes.is_empty());
    }

    #[test]
    fn voxel_and_hexahedron_of_one_box_are_the_same() {
        let (voxel, hex): (Vec<u32>, [u32; 8]) = ((0..8).collect(), [0, 1, 3, 2, 4, 5, 7, 6]);
        let mesh = read(&[(11, &voxel), (12, &hex), (8, &[0, 1, 2, 3]), (9, &[0, 1, 3, 2])], Vec::new());
        assert_eq!(mesh.cells.hexes[0], mesh.cells.hexes[1]);
        assert_eq!(mesh.faces.face(0), mesh.faces.face(1));
    }

    #[test]
    fn strips_keep_their_sense() {
        let edges = |t: [u32; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
        let directed: Vec<[u32; 2]> = strip_triangles(&[0, 1, 2, 3, 4, 5]).flat_map(edges).collect();
        assert_eq!(directed.len(), 12);
        // Neighbours of one sense pass their common edge in opposite directions.
        let inner = directed.iter().filter(|[a, b]| directed.contains(&[*b, *a])).count();
        assert_eq!(inner, 6);
        assert_eq!(strip_triangles(&[0, 1, 2, 2, 5, 5, 6, 7]).count(), 2);
    }

    #[test]
    fn of_higher_order_cells_the_corners_are_kept() {
        let mesh = read(&[(22, &[0, 1, 2, 3, 4, 5]), (21, &[0, 1, 3]), (69, &[2, 1, 0])], Vec::new());
        let faces: Vec<&[u32]> = mesh.faces.iter().collect();
        assert_eq!((faces, mesh.edges), (vec![&[0u32, 1, 2][..], &[2, 1, 0]], vec![[0, 1]]));
        assert!(
            mesh.notes[0].starts_with("3 elements of higher order: only their corners are kept"),
            "{:?}",
            mesh.notes
        );
        assert_eq!(mesh.notes.len(), 1);
    }

    #[test]
    fn cells_of_second_order_are_written_with_all_nodes() {
        use crate::mesh::test_models::bricks;
        use crate::mesh::{HexMesh, SecondOrder, boundary_faces};
        let (points, hexes) = bricks([2, 1, 1]);
        let quads: Vec<[u32; 4]> = boundary_faces(&hexes).into_iter().map(|f| f.0).collect();
        let mesh = HexMesh { points, hexes, tags: vec![1; quads.len()], quads };
        let (nodes, middles) = SecondOrder::of(&mesh).unwrap();
        let places = vec![DVec3::ZERO; middles.edges.len() + middles.faces.len() + 2];
        let raw = RawMesh::from(mesh).with_second_order(nodes, &places);
        let table = CellTable::new(&raw).unwrap();
        assert_eq!(table.kinds, [vec![28; 10], vec![29; 2]].concat());
        assert_eq!(table.ends.last(), Some(&(10 * 9 + 2 * 27)));
        assert!(table.corners.iter().all(|&v| (0..raw.points.len() as i64).contains(&v)));
        let mut broken = raw.clone();
        broken.second_order.as_mut().unwrap().quads.pop();
        assert!(CellTable::new(&broken).is_err());
    }

    #[test]
    fn unknown_cells_are_counted_in_the_notes() {
        let mesh =
            read(&[(16, &[0, 1, 2, 3, 4, 5]), (16, &[0, 1, 2, 3, 4, 5]), (42, &[0]), (5, &[0, 1, 2])], Vec::new());
        assert_eq!(mesh.faces.len(), 1);
        assert!(mesh.notes[0].starts_with("2 hexagonal prisms"), "{:?}", mesh.notes);
        assert_eq!(mesh.notes.len(), 2);
    }

    #[test]
    fn impossible_cells_are_refused() {
        let add = |kinds: &[u8], ends: &[usize], corners: &[u32]| CellReader::default().add(kinds, ends, corners, 0, 4);
        assert!(add(&[5], &[3], &[0, 1, 3]).is_ok());
        assert!(add(&[5], &[3], &[0, 1, 4]).is_err_and(|e| e.contains("point 4")));
        assert!(add(&[5], &[4], &[0, 1, 2, 3]).is_err_and(|e| e.contains("4 corners")));
        assert!(add(&[5], &[3], &[0, 1, 2, 3]).is_err());
        assert!(add(&[5], &[4], &[0, 1, 2]).is_err());
        assert!(add(&[7, 7], &[3, 2], &[0, 1, 2]).is_err());
        assert!(add(&[5], &[], &[]).is_err());
    }

    #[test]
    fn columns_of_a_wrong_length_are_not_written() {
        let mut mesh = samples::one_of_everything();
        mesh.attributes.face.insert("short".into(), Column::Scalar(vec![1.0]));
        assert!(CellTable::new(&mesh).is_err());
    }
}
