//! Abaqus and CalculiX input (`.inp`).
//!
//! Of a surface every face is a shell element (S3, S4), its labels are element sets. Of a volume mesh the faces are no
//! elements, which would be shells around the solid: their labels are surfaces (`*SURFACE`, by the faces of cells) and node
//! sets. Hexahedra of second order are C3D20. Labels of vertices and tags of edges are node sets.

use super::sets::{Names, Set, left_out, of_columns, of_edges, of_labels};
use crate::error::Result;
use crate::io::small_faces::SmallFaces;
use crate::io::source::WriteOptions;
use crate::io::text::{push_float, push_integer};
use crate::io::vtk_cells::check_writable;
use crate::mesh::{Column, RawMesh};
use rustc_hash::FxHashMap;

/// The name of the format in warnings.
const ABAQUS: &str = "Abaqus";
/// Characters of the longest label.
const LONGEST_LABEL: usize = 80;
/// Numbers on a line of a set.
const PER_LINE: usize = 16;

/// Faces of tetrahedra in the order of their numbers S1, S2 …, as places in VTK's corner order.
const TET: &[&[usize]] = &[&[0, 1, 2], &[0, 3, 1], &[1, 3, 2], &[2, 3, 0]];
/// The same for hexahedra.
const HEX: &[&[usize]] = &[&[0, 1, 2, 3], &[4, 7, 6, 5], &[0, 4, 5, 1], &[1, 5, 6, 2], &[2, 6, 7, 3], &[3, 7, 4, 0]];
/// The same for wedges.
const WEDGE: &[&[usize]] = &[&[0, 1, 2], &[3, 5, 4], &[0, 3, 4, 1], &[1, 4, 5, 2], &[2, 5, 3, 0]];
/// The same for pyramids.
const PYRAMID: &[&[usize]] = &[&[0, 1, 2, 3], &[0, 4, 1], &[1, 4, 2], &[2, 4, 3], &[3, 4, 0]];

/// Cells of one kind.
type Block<'a> = (&'static str, &'a [u32], usize, &'static [&'static [usize]]);

fn blocks(mesh: &RawMesh) -> [Block<'_>; 4] {
    let cells = &mesh.cells;
    [
        ("C3D4", cells.tets.as_flattened(), 4, TET),
        ("C3D8", cells.hexes.as_flattened(), 8, HEX),
        ("C3D6", cells.wedges.as_flattened(), 6, WEDGE),
        ("C3D5", cells.pyramids.as_flattened(), 5, PYRAMID),
    ]
}

pub fn write(mesh: &RawMesh, _: &WriteOptions, out: &mut Vec<u8>) -> Result<Vec<String>> {
    check_writable(mesh)?;
    let mut warnings = Vec::new();
    let faces = SmallFaces::of(mesh, ABAQUS, &mut warnings);
    let solid = !mesh.cells.is_empty();
    out.extend_from_slice(b"*HEADING\nwritten by carreau\n*NODE\n");
    let unused = nodes_without_an_element(mesh);
    for (k, p) in mesh.points.iter().enumerate().filter(|(k, _)| !unused.get(*k).is_some_and(|u| *u)) {
        push_integer(out, k + 1);
        for x in p.to_array() {
            out.extend_from_slice(b", ");
            push_real(out, x);
        }
        out.push(b'\n');
    }
    let shells = if solid { Vec::new() } else { write_shells(&faces, out) };
    write_cells(mesh, out);
    let mut names = Names::default();
    let mut columns = mesh.attributes.face.clone();
    for column in columns.values_mut() {
        if let Column::Label(labels) = column {
            *labels = faces.values(labels).into_owned();
        }
    }
    columns.retain(|_, column| matches!(column, Column::Label(_)));
    let of_faces = of_columns(mesh, &columns, &mut names, LONGEST_LABEL);
    if solid {
        write_surfaces(mesh, &faces, &of_faces, out, &mut warnings);
    } else {
        of_faces.iter().for_each(|set| push_set(out, "*ELSET, ELSET", set, |face| shells[face as usize]));
    }
    let of_cells = of_labels(mesh, "cell", &mesh.cells.tags, &mut names, LONGEST_LABEL);
    of_cells.iter().for_each(|set| push_set(out, "*ELSET, ELSET", set, |cell| cell + 1));
    let mut of_nodes = of_columns(mesh, &mesh.attributes.vertex, &mut names, LONGEST_LABEL);
    of_nodes.extend(of_edges(mesh, &mut names, LONGEST_LABEL));
    of_nodes.iter().for_each(|set| push_set(out, "*NSET, NSET", set, |node| node + 1));
    if !mesh.cells.pyramids.is_empty() {
        warnings.push("the pyramids are elements C3D5, which Abaqus has and CalculiX has not".into());
    }
    warnings.extend(left_out(mesh, ABAQUS));
    Ok(warnings)
}

/// A number with a decimal point: an integer would be read as such by some programs.
fn push_real(out: &mut Vec<u8>, x: f64) {
    let start = out.len();
    push_float(out, x);
    let text = &out[start..];
    if !text.contains(&b'.') {
        let exponent = text.iter().position(|&b| b == b'e').unwrap_or(text.len());
        out.insert(start + exponent, b'.');
    }
}

/// The shells, triangles first; returns the element of every face.
fn write_shells(faces: &SmallFaces, out: &mut Vec<u8>) -> Vec<u32> {
    let mut element = vec![0; faces.faces.len()];
    let mut count = 0;
    for (kind, corners) in [("S3", 3), ("S4", 4)] {
        let mut first = true;
        for (f, face) in faces.faces.iter().enumerate().filter(|(_, face)| face.len() == corners) {
            if std::mem::take(&mut first) {
                out.extend_from_slice(format!("*ELEMENT, TYPE={kind}\n").as_bytes());
            }
            count += 1;
            element[f] = count;
            push_row(out, count, face);
        }
    }
    element
}

/// Of cells of second order the nodes on faces and in the middle, which C3D20 has not; empty for those of first order.
fn nodes_without_an_element(mesh: &RawMesh) -> Vec<bool> {
    let mut unused = Vec::new();
    if let Some(nodes) = &mesh.second_order {
        unused.resize(mesh.points.len(), false);
        nodes.hexes.iter().flat_map(|n| &n[12..]).for_each(|&v| unused[v as usize] = true);
    }
    unused
}

fn write_cells(mesh: &RawMesh, out: &mut Vec<u8>) {
    let mut count = 0;
    if let Some(nodes) = &mesh.second_order {
        out.extend_from_slice(b"*ELEMENT, TYPE=C3D20\n");
        for (cell, middles) in mesh.cells.hexes.iter().zip(&nodes.hexes) {
            count += 1;
            push_row(out, count, &[&cell[..], &middles[..12]].concat());
        }
        return;
    }
    for (kind, corners, size, _) in blocks(mesh) {
        if !corners.is_empty() {
            out.extend_from_slice(format!("*ELEMENT, TYPE={kind}\n").as_bytes());
        }
        for cell in corners.chunks_exact(size) {
            count += 1;
            push_row(out, count, cell);
        }
    }
}

fn push_row(out: &mut Vec<u8>, number: u32, corners: &[u32]) {
    push_integer(out, number);
    for (k, &v) in corners.iter().enumerate() {
        // A line has room for 16 numbers; one that ends with a comma is continued.
        out.extend_from_slice(if k == PER_LINE - 1 { b",\n" } else { b", " });
        push_integer(out, u64::from(v) + 1);
    }
    out.push(b'\n');
}

fn push_set(out: &mut Vec<u8>, keyword: &str, set: &Set, number: impl Fn(u32) -> u32) {
    out.extend_from_slice(format!("{keyword}={}\n", set.name).as_bytes());
    for row in set.members.chunks(PER_LINE) {
        for (k, &member) in row.iter().enumerate() {
            out.extend_from_slice(if k > 0 { b", " } else { b"" });
            push_integer(out, number(member));
        }
        out.push(b'\n');
    }
}

/// The sides of cells by their corners, ascending: cell and number of the side.
fn sides(mesh: &RawMesh) -> FxHashMap<Vec<u32>, (u32, usize)> {
    let mut sides = FxHashMap::default();
    let mut count = 0;
    for (_, corners, size, table) in blocks(mesh) {
        for cell in corners.chunks_exact(size) {
            count += 1;
            for (side, places) in table.iter().enumerate() {
                sides.entry(sorted(places.iter().map(|&k| cell[k]))).or_insert((count, side + 1));
            }
        }
    }
    sides
}

fn sorted(corners: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut all: Vec<u32> = corners.collect();
    all.sort_unstable();
    all
}

/// The sets of faces of a volume mesh, as surfaces and as node sets.
fn write_surfaces(mesh: &RawMesh, faces: &SmallFaces, sets: &[Set], out: &mut Vec<u8>, warnings: &mut Vec<String>) {
    let sides = sides(mesh);
    let corners = |face: u32| faces.faces.face(face as usize);
    let missing = faces.faces.iter().filter(|face| !sides.contains_key(&sorted(face.iter().copied()))).count();
    for set in sets {
        out.extend_from_slice(format!("*SURFACE, NAME={}_surface, TYPE=ELEMENT\n", set.name).as_bytes());
        for &face in &set.members {
            if let Some((cell, side)) = sides.get(&sorted(corners(face).iter().copied())) {
                out.extend_from_slice(format!("{cell}, S{side}\n").as_bytes());
            }
        }
        let mut nodes: Vec<u32> = set.members.iter().flat_map(|&face| corners(face)).copied().collect();
        if let Some(middles) = &mesh.second_order {
            nodes.extend(set.members.iter().flat_map(|&face| &middles.quads[face as usize][..4]));
        }
        nodes.sort_unstable();
        nodes.dedup();
        push_set(out, "*NSET, NSET", &Set { name: set.name.clone(), members: nodes }, |node| node + 1);
    }
    if missing > 0 {
        warnings.push(format!("{ABAQUS}: {missing} faces that are not sides of cells were left out"));
    } else if sets.is_empty() && !mesh.faces.is_empty() {
        warnings.push(format!("{ABAQUS}: the faces have no labels and were left out, they are sides of the cells"));
    }
}
