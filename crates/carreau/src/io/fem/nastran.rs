//! Nastran bulk data (`.bdf`).
//!
//! Nodes are `GRID*`, with fields of sixteen characters; elements are CTRIA3, CQUAD4, CTETRA, CHEXA, CPENTA, CPYRAM with fields
//! of eight. The property of an element stands for its reference number (of cells: the tag); its name is a comment, in the
//! two ways that pre-processors read. Further labels are sets of the case control section.

use super::sets::{Names, Set, left_out, of_columns, of_edges};
use crate::error::{Error, Result};
use crate::io::small_faces::{SmallFaces, face_references};
use crate::io::source::WriteOptions;
use crate::io::vtk_cells::check_writable;
use crate::mesh::{Column, RawMesh};
use crate::words::counted;
use std::collections::BTreeMap;
use std::io::Write;

/// The name of the format in warnings.
const NASTRAN: &str = "Nastran";
/// Characters of a name in a comment.
const LONGEST_COMMENT_NAME: usize = 80;
/// The largest number in a field of eight characters.
const MOST: usize = 99_999_999;
/// Characters of a long field.
const WIDE: usize = 16;

/// An element's card, property and corners.
struct Element<'a> {
    card: &'static str,
    property: usize,
    corners: &'a [u32],
}

/// Properties by kind of element and label, numbered from 1, with their names.
#[derive(Default)]
struct Properties {
    of: BTreeMap<(bool, i32), usize>,
    names: Vec<(&'static str, String)>,
}

impl Properties {
    fn add(&mut self, mesh: &RawMesh, column: &str, label: i32, solid: bool, names: &mut Names) -> usize {
        let next = self.of.len() + 1;
        let number = *self.of.entry((solid, label)).or_insert(next);
        if number == next {
            let fallback = || if solid { format!("cells_{label}") } else { format!("{column}_{label}") };
            let word = mesh.attributes.name(column, label).map_or_else(fallback, str::to_string);
            self.names.push((if solid { "PSOLID" } else { "PSHELL" }, names.take(&word, LONGEST_COMMENT_NAME)));
        }
        number
    }
}

pub fn write(mesh: &RawMesh, _: &WriteOptions, out: &mut Vec<u8>) -> Result<Vec<String>> {
    check_writable(mesh)?;
    let mut warnings = Vec::new();
    let faces = SmallFaces::of(mesh, NASTRAN, &mut warnings);
    if mesh.points.len().max(faces.faces.len() + mesh.cells.len()) > MOST {
        return Err(Error::input("Nastran's fields cannot count beyond 99,999,999", "", "write another format"));
    }
    let mut names = Names::default();
    let mut properties = Properties::default();
    let (column, labels) = face_references(mesh).unwrap_or(("ref", &[]));
    let labels = faces.values(labels);
    let mut elements = Vec::new();
    for (f, corners) in faces.faces.iter().enumerate() {
        let property = properties.add(mesh, column, labels.get(f).copied().unwrap_or(0), false, &mut names);
        elements.push(Element { card: if corners.len() == 3 { "CTRIA3" } else { "CQUAD4" }, property, corners });
    }
    let cells = &mesh.cells;
    let kinds = [
        ("CTETRA", cells.tets.as_flattened(), 4),
        ("CHEXA", cells.hexes.as_flattened(), 8),
        ("CPENTA", cells.wedges.as_flattened(), 6),
        ("CPYRAM", cells.pyramids.as_flattened(), 5),
    ];
    let mut tags = cells.tags.iter().copied().chain(std::iter::repeat(0));
    for (card, corners, size) in kinds {
        for corners in corners.chunks_exact(size) {
            let property = properties.add(mesh, "cell", tags.next().unwrap_or(0), true, &mut names);
            elements.push(Element { card, property, corners });
        }
    }
    let sets = sets(mesh, &faces, column, &mut names);
    write_deck(mesh, &elements, &properties, &sets, out);
    let rounded = mesh.points.iter().flat_map(|p| p.to_array()).filter(|&x| parsed(&field(x)) != Some(x)).count();
    if rounded > 0 {
        warnings.push(format!(
            "{NASTRAN}'s fields have {WIDE} characters: {}",
            counted(rounded, "coordinate is rounded", "coordinates are rounded")
        ));
    }
    if !mesh.cells.is_empty() && !mesh.faces.is_empty() {
        warnings.push(format!(
            "{NASTRAN}: the faces are shells with properties of their own, leave these out of the analysis"
        ));
    }
    warnings.extend(left_out(mesh, NASTRAN));
    Ok(warnings)
}

/// The labels that are no property: sets of elements, then of nodes.
fn sets(mesh: &RawMesh, faces: &SmallFaces, reference: &str, names: &mut Names) -> [Vec<Set>; 2] {
    let mut columns = mesh.attributes.face.clone();
    columns.retain(|name, column| name != reference && matches!(column, Column::Label(_)));
    for column in columns.values_mut() {
        if let Column::Label(labels) = column {
            *labels = faces.values(labels).into_owned();
        }
    }
    let of_elements = of_columns(mesh, &columns, names, LONGEST_COMMENT_NAME);
    let mut of_nodes = of_columns(mesh, &mesh.attributes.vertex, names, LONGEST_COMMENT_NAME);
    of_nodes.extend(of_edges(mesh, names, LONGEST_COMMENT_NAME));
    [of_elements, of_nodes]
}

/// Writing to memory cannot fail.
fn write_deck(mesh: &RawMesh, elements: &[Element], properties: &Properties, sets: &[Vec<Set>; 2], out: &mut Vec<u8>) {
    let _ = writeln!(out, "$ written by carreau\nSOL 101\nCEND");
    for (k, set) in sets.iter().flatten().enumerate() {
        let what = if k < sets[0].len() { "elements" } else { "nodes" };
        let _ = write!(out, "$ set of {what}: {}\nSET {} = ", set.name, k + 1);
        for (i, member) in set.members.iter().enumerate() {
            let separator = match i {
                0 => "",
                _ if i % 8 == 0 => ",\n",
                _ => ",",
            };
            let _ = write!(out, "{separator}{}", member + 1);
        }
        out.push(b'\n');
    }
    let _ = writeln!(out, "BEGIN BULK");
    for (k, (kind, name)) in properties.names.iter().enumerate() {
        let _ = writeln!(out, "$HMNAME PROP {:>23}\"{name}\"\n$ANSA_NAME_COMMENT;{};{kind};{name};;", k + 1, k + 1);
    }
    for (k, p) in mesh.points.iter().enumerate() {
        let [x, y, z] = p.to_array().map(field);
        let _ = writeln!(out, "GRID*   {:<16}{:16}{x:<16}{y:<16}*\n*       {z:<16}", k + 1, "");
    }
    for (k, element) in elements.iter().enumerate() {
        let _ = write!(out, "{:<8}{:<8}{:<8}", element.card, k + 1, element.property);
        for (i, &v) in element.corners.iter().enumerate() {
            if i == 6 {
                let _ = write!(out, "+\n+       ");
            }
            let _ = write!(out, "{:<8}", u64::from(v) + 1);
        }
        out.push(b'\n');
    }
    let _ = writeln!(out, "ENDDATA");
}

/// A number in sixteen characters, as near as they allow; with a point, as Nastran asks.
fn field(x: f64) -> String {
    let with_point = |mut text: String| {
        if !text.contains('.') {
            let exponent = text.find('e').unwrap_or(text.len());
            text.insert(exponent, '.');
        }
        text.replace('e', "E")
    };
    let short = with_point(ryu::Buffer::new().format(x).to_string());
    if short.len() <= WIDE {
        return short;
    }
    let plain = (0..WIDE).rev().map(|digits| format!("{x:.digits$}")).find(|text| text.len() <= WIDE);
    let scientific = (0..WIDE).rev().map(|digits| with_point(format!("{x:.digits$e}"))).find(|text| text.len() <= WIDE);
    let error = |text: &String| parsed(text).map_or(f64::INFINITY, |y| (y - x).abs());
    let plain = plain.map(with_point).filter(|text| text.len() <= WIDE);
    let candidates = [scientific, plain];
    let best = candidates.into_iter().flatten().min_by(|a, b| error(a).total_cmp(&error(b)));
    best.unwrap_or(short)
}

fn parsed(text: &str) -> Option<f64> {
    text.parse().ok()
}
