use super::super::round_trips::written;
use super::super::source::Source;
use crate::mesh::{Cells, Column, Polygons, RawMesh};
use glam::DVec3;
use std::path::Path;

fn cube() -> RawMesh {
    let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let points = [0.0, 0.1].iter().flat_map(|&z| square.map(|(x, y)| DVec3::new(x, y, z))).collect();
    let cells = Cells { hexes: vec![[0, 1, 2, 3, 4, 5, 6, 7]], ..Cells::default() };
    let faces: Polygons = [&[0u32, 3, 2, 1][..], &[4, 5, 6, 7]].into_iter().collect();
    let mut mesh = RawMesh { points, cells, faces, ..RawMesh::default() };
    mesh.attributes.face.insert("ref".into(), Column::Label(vec![1, 2]));
    mesh.attributes.names.insert(("ref".into(), 2), "outlet 1".into());
    mesh
}

fn text(mesh: &RawMesh, extension: &str) -> (String, Vec<String>) {
    let (bytes, warnings) = written(mesh, extension, true);
    (String::from_utf8(bytes).unwrap(), warnings)
}

#[test]
fn sides_of_cells_are_surfaces_with_names() {
    let (deck, warnings) = text(&cube(), "inp");
    assert!(deck.contains("*ELEMENT, TYPE=C3D8\n1, 1, 2, 3, 4, 5, 6, 7, 8\n"), "{deck}");
    assert!(deck.contains("*SURFACE, NAME=ref_1_surface, TYPE=ELEMENT\n1, S1\n"), "{deck}");
    assert!(deck.contains("*SURFACE, NAME=outlet_1_surface, TYPE=ELEMENT\n1, S2\n"), "{deck}");
    assert!(deck.contains("*NSET, NSET=outlet_1\n5, 6, 7, 8\n"), "{deck}");
    assert!(!deck.contains("S4") && warnings.is_empty(), "{deck} {warnings:?}");
}

/// Cells of second order have 20 nodes; those on faces and in the middle, which no element has, are left out. Other formats get the
/// corners, with a word.
#[test]
fn cells_of_second_order_have_twenty_nodes() {
    use crate::mesh::{HexMesh, SecondOrder};
    let first = cube();
    let quads: Vec<[u32; 4]> = first.faces.iter().map(|f| [f[0], f[1], f[2], f[3]]).collect();
    let mesh = HexMesh { points: first.points, hexes: first.cells.hexes, tags: vec![1, 2], quads };
    let (nodes, middles) = SecondOrder::of(&mesh).unwrap();
    let places = vec![DVec3::ZERO; middles.edges.len() + middles.faces.len() + 1];
    let raw = RawMesh::from(mesh).with_second_order(nodes, &places);
    let (deck, warnings) = text(&raw, "inp");
    let element = deck.split("TYPE=C3D20\n").nth(1).unwrap();
    let numbers: Vec<u32> =
        element.split([',', '\n', '*']).map_while(|n| n.trim().parse().ok().or(n.is_empty().then_some(0))).collect();
    let numbers: Vec<u32> = numbers.into_iter().filter(|n| *n > 0).take(21).collect();
    assert_eq!(numbers[..9], [1, 1, 2, 3, 4, 5, 6, 7, 8]);
    let mut of_edges = numbers[9..].to_vec();
    of_edges.sort_unstable();
    assert_eq!(of_edges, (9..=20).collect::<Vec<u32>>());
    assert!(deck.contains("\n20, ") && !deck.contains("\n21, ") && warnings.is_empty(), "{deck} {warnings:?}");
    // The side below has its four corners and the four nodes between them.
    let below = deck.split("*NSET, NSET=ref_1\n").nth(1).unwrap().lines().next().unwrap();
    assert_eq!(below.split(", ").count(), 8, "{below}");
    assert!(raw.first_order().points.len() == 8 && raw.first_order().second_order.is_none());
}

#[test]
fn faces_of_a_surface_are_shells_in_sets() {
    let mut mesh = cube();
    mesh.cells = Cells::default();
    mesh.faces.push(&[0, 1, 5]);
    mesh.attributes.face.insert("ref".into(), Column::Label(vec![1, 2, 2]));
    let (deck, _) = text(&mesh, "inp");
    assert!(
        deck.contains("*ELEMENT, TYPE=S3\n1, 1, 2, 6\n*ELEMENT, TYPE=S4\n2, 1, 4, 3, 2\n3, 5, 6, 7, 8\n"),
        "{deck}"
    );
    assert!(deck.contains("*ELSET, ELSET=outlet_1\n3, 1\n"), "{deck}");
    let (deck, _) = text(&mesh, "bdf");
    assert!(deck.contains("CTRIA3  3       2       1       2       6       \n"), "{deck}");
    assert!(deck.contains("$ANSA_NAME_COMMENT;2;PSHELL;outlet_1;;"), "{deck}");
}

#[test]
fn nastran_lines_fit_their_fields() {
    let mut mesh = cube();
    mesh.points[1] = DVec3::new(-1.234_567_890_123_456_7e-105, 1.0 / 3.0, -123_456.789_012_345_67);
    let (deck, warnings) = text(&mesh, "bdf");
    assert!(warnings.iter().any(|w| w.contains("3 coordinates are rounded")), "{warnings:?}");
    assert!(deck.lines().all(|line| line.starts_with('$') || line.len() <= 73), "{deck}");
    let lines: Vec<&str> = deck.lines().collect();
    let at = lines.iter().position(|line| line.starts_with("GRID*   2 ")).unwrap();
    let x: f64 = lines[at][40..56].trim().parse().unwrap();
    let z: f64 = lines[at + 1][8..24].trim().parse().unwrap();
    assert!((x / mesh.points[1].x - 1.0).abs() < 1e-7, "{x}");
    assert!((z - mesh.points[1].z).abs() < 1e-7, "{z}");
    assert!(
        deck.contains("CHEXA   3       3       1       2       3       4       5       6       +\n+       7       8"),
        "{deck}"
    );
}

#[test]
fn decks_are_not_read_and_say_what_to_do() {
    for extension in ["inp", "bdf"] {
        let name = format!("a.{extension}");
        let source = Source { path: Path::new(&name), bytes: b"*NODE\n" };
        let message = super::read(&source).unwrap_err().to_string();
        assert!(message.contains("meshio"), "{message}");
    }
}
