//! Cells of every kind, with their data.

use super::super::vtk_arrays::{Array, Values};
use super::numbers::TAGS;
use super::*;
use crate::mesh::{Column, RawMesh};
use glam::DVec3;

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
    assert!(mesh.notes[0].starts_with("3 elements of higher order: only their corners are kept"), "{:?}", mesh.notes);
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
    let mesh = read(&[(16, &[0, 1, 2, 3, 4, 5]), (16, &[0, 1, 2, 3, 4, 5]), (42, &[0]), (5, &[0, 1, 2])], Vec::new());
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
