//! Meshes for the tests of the VTK formats.

use super::numbers::TAGS;
use crate::mesh::{Cells, Column, Columns, RawMesh};
use glam::DVec3;
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
            let coordinate = || proptest::num::f64::NORMAL | proptest::num::f64::SUBNORMAL | proptest::num::f64::ZERO;
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
