//! Tests of the formats of elements with reference numbers (Medit, GMF, Gmsh): what is written is read back bit by bit,
//! and no damage of a file makes a reader panic.

use super::formats::FORMATS;
use super::source::{Source, WriteOptions};
use crate::error::Result;
use crate::mesh::{Cells, Column, Columns, Polygons, RawMesh};
use glam::DVec3;
use proptest::collection::vec;
use proptest::prelude::*;
use std::path::Path;

/// Format and whether text is asked for.
const ENCODINGS: [(&str, bool); 4] = [("mesh", true), ("meshb", false), ("msh", true), ("msh", false)];

pub(super) fn read(extension: &str, bytes: &[u8]) -> Result<RawMesh> {
    let format = FORMATS.iter().find(|f| f.extensions.contains(&extension)).unwrap();
    let mesh = (format.read)(&Source { path: Path::new("test"), bytes })?;
    mesh.check()?;
    Ok(mesh)
}

pub(super) fn written(mesh: &RawMesh, extension: &str, ascii: bool) -> (Vec<u8>, Vec<String>) {
    let format = FORMATS.iter().find(|f| f.extensions.contains(&extension)).unwrap();
    let mut bytes = Vec::new();
    let warnings = (format.write)(mesh, &WriteOptions { ascii }, &mut bytes).unwrap();
    (bytes, warnings)
}

/// Everything that a mesh holds, comparable, down to the sign of a zero.
pub(super) fn content(mesh: &RawMesh) -> impl PartialEq + std::fmt::Debug + use<> {
    let points: Vec<[u64; 3]> = mesh.points.iter().map(|p| p.to_array().map(f64::to_bits)).collect();
    (
        points,
        mesh.faces.clone(),
        mesh.edges.clone(),
        mesh.edge_tags.clone(),
        mesh.cells.clone(),
        mesh.attributes.clone(),
    )
}

fn coordinate() -> impl Strategy<Value = f64> {
    use prop::num::f64::{NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
    prop_oneof![
        NORMAL | SUBNORMAL | ZERO | POSITIVE | NEGATIVE,
        -9.0..9.0,
        prop::sample::select(vec![f64::MAX, f64::MIN, f64::MIN_POSITIVE, 5e-324, -0.0, 0.1, 1e15, 1e16, 123456789.0]),
    ]
}

fn reference() -> impl Strategy<Value = i32> {
    prop_oneof![0..4, any::<i32>(), prop::sample::select(vec![i32::MIN, i32::MAX])]
}

fn referenced<S: Strategy>(elements: S, most: usize) -> impl Strategy<Value = (Vec<S::Value>, Vec<i32>)> {
    vec((elements, reference()), 0..most).prop_map(|rows| rows.into_iter().unzip())
}

/// Labels, kept as the readers do: not where all are zero.
fn columns(labels: &[(&str, Vec<i32>)]) -> Columns {
    let kept = labels.iter().filter(|(_, values)| values.iter().any(|&v| v != 0));
    kept.map(|(name, values)| (name.to_string(), Column::Label(values.clone()))).collect()
}

fn cells(n: u32) -> impl Strategy<Value = Cells> {
    fn cell<const N: usize>(n: u32) -> impl Strategy<Value = (Vec<[u32; N]>, Vec<i32>)> {
        referenced(prop::array::uniform(0..n), 4)
    }
    (cell::<4>(n), cell::<8>(n), cell::<6>(n), cell::<5>(n)).prop_map(|(tets, hexes, wedges, pyramids)| {
        let mut tags = [tets.1, hexes.1, wedges.1, pyramids.1].concat();
        if tags.iter().all(|&t| t == 0) {
            tags.clear();
        }
        Cells { tets: tets.0, hexes: hexes.0, wedges: wedges.0, pyramids: pyramids.0, tags }
    })
}

/// Any mesh that Medit can hold, faces of both sizes mixed.
fn mesh() -> impl Strategy<Value = RawMesh> {
    vec((prop::array::uniform3(coordinate()), reference(), 0..2, 0..2), 1..9).prop_flat_map(|vertices| {
        let n = vertices.len() as u32;
        let face = prop_oneof![vec(0..n, 3), vec(0..n, 4)];
        let edges = referenced(prop::array::uniform2(0..n), 6);
        (referenced(face, 9), edges, cells(n), Just(vertices)).prop_map(|(faces, edges, cells, vertices)| {
            let mut mesh = RawMesh {
                points: vertices.iter().map(|v| DVec3::from(v.0)).collect(),
                faces: faces.0.iter().map(Vec::as_slice).collect(),
                edges: edges.0,
                edge_tags: edges.1,
                cells,
                ..RawMesh::default()
            };
            mesh.attributes.vertex = columns(&[
                ("ref", vertices.iter().map(|v| v.1).collect()),
                ("corner", vertices.iter().map(|v| v.2).collect()),
                ("required", vertices.iter().map(|v| v.3).collect()),
            ]);
            mesh.attributes.face = columns(&[("ref", faces.1)]);
            mesh
        })
    })
}

/// The mesh with its faces as Medit lists them: all of the first face's size, then the others.
fn by_size(mut mesh: RawMesh) -> RawMesh {
    let first = mesh.faces.iter().next().map_or(3, <[u32]>::len);
    let mut order: Vec<u32> = (0..mesh.faces.len() as u32).collect();
    order.sort_by_key(|&f| mesh.faces.face(f as usize).len() != first);
    mesh.faces = order.iter().map(|&f| mesh.faces.face(f as usize)).collect::<Polygons>();
    mesh.attributes.face = crate::mesh::gather_columns(&mesh.attributes.face, &order);
    mesh
}

proptest! {
    #[test]
    fn medit_and_gmf_give_back_what_they_got(mesh in mesh()) {
        let expected = by_size(mesh.clone());
        for extension in ["mesh", "meshb"] {
            let (bytes, warnings) = written(&mesh, extension, false);
            prop_assert_eq!(warnings.is_empty(), expected.faces == mesh.faces, "{:?}", warnings);
            let back = read(extension, &bytes).unwrap();
            prop_assert_eq!(content(&back), content(&expected));
            prop_assert_eq!(back.notes, Vec::<String>::new());
        }
    }

    #[test]
    fn gmsh_gives_back_what_it_got(mut mesh in mesh(), entities in vec(1..9, 9)) {
        mesh.attributes.vertex.retain(|name, _| name == "ref");
        let finer = entities[..mesh.faces.len()].to_vec();
        for ascii in [false, true] {
            let back = read("msh", &written(&mesh, "msh", ascii).0).unwrap();
            prop_assert_eq!(content(&back), content(&mesh));
            prop_assert_eq!(back.notes, Vec::<String>::new());
        }
        // The entity numbers themselves are kept where each belongs to one reference, and say more than it.
        mesh.attributes.face = columns(&[("ref", vec![7; finer.len()]), ("entity", finer.clone())]);
        if finer.windows(2).all(|w| w[0] == w[1]) {
            mesh.attributes.face.remove("entity");
        }
        let back = read("msh", &written(&mesh, "msh", false).0).unwrap();
        prop_assert_eq!(content(&back), content(&mesh));
    }

    /// A file cut anywhere before its last keyword is refused, or what is missing is said.
    #[test]
    fn cut_files_are_noticed(mesh in mesh(), encoding in 0..ENCODINGS.len(), cut: prop::sample::Index) {
        let (extension, ascii) = ENCODINGS[encoding];
        let bytes = written(&mesh, extension, ascii).0;
        let end = if extension == "meshb" { bytes.len() - 4 } else { bytes.trim_ascii_end().len() };
        if let Ok(mesh) = read(extension, &bytes[..cut.index(end)]) {
            prop_assert!(mesh.notes.iter().any(|note| note.contains("may be cut")), "{:?}", mesh.notes);
        }
    }

    /// Whatever happens to a file: an error or a mesh whose indices exist, never a panic.
    #[test]
    fn damaged_files_do_no_harm(mesh in mesh(), encoding in 0..ENCODINGS.len(), damage in vec(damage(), 1..4)) {
        let (extension, ascii) = ENCODINGS[encoding];
        let mut bytes = written(&mesh, extension, ascii).0;
        damage.iter().for_each(|d| d.apply(&mut bytes));
        let _ = read(extension, &bytes);
    }
}

/// One way to spoil a file.
#[derive(Debug, Clone)]
pub(super) enum Damage {
    Flip(prop::sample::Index, u8),
    Truncate(prop::sample::Index),
    Duplicate(prop::sample::Index, prop::sample::Index, usize),
    Number(prop::sample::Index, i64, usize),
}

pub(super) fn damage() -> impl Strategy<Value = Damage> {
    let place = any::<prop::sample::Index>;
    let number = prop::sample::select(vec![0, -1, i64::MAX, i64::MIN, i64::from(i32::MAX), 1 << 31, 1 << 40, 1000]);
    prop_oneof![
        (place(), any::<u8>()).prop_map(|(p, b)| Damage::Flip(p, b)),
        place().prop_map(Damage::Truncate),
        (place(), place(), 1..40usize).prop_map(|(p, q, n)| Damage::Duplicate(p, q, n)),
        (place(), number, prop::sample::select(vec![4, 8])).prop_map(|(p, k, n)| Damage::Number(p, k, n)),
    ]
}

impl Damage {
    pub(super) fn apply(&self, bytes: &mut Vec<u8>) {
        if bytes.is_empty() {
            return;
        }
        let length = bytes.len();
        match self {
            Damage::Flip(at, byte) => bytes[at.index(length)] = *byte,
            Damage::Truncate(at) => bytes.truncate(at.index(length)),
            Damage::Duplicate(from, to, count) => {
                let from = from.index(length);
                let block = bytes[from..(from + count).min(length)].to_vec();
                let to = to.index(length);
                bytes.splice(to..to, block);
            }
            Damage::Number(at, number, size) => {
                let at = at.index(length);
                bytes[at..].iter_mut().zip(&number.to_le_bytes()[..*size]).for_each(|(byte, new)| *byte = *new);
            }
        }
    }
}
