//! Files made by hand, as Gmsh would write them and worse.

use crate::io::round_trips::{Damage, content, damage, read, written};
use crate::mesh::{Column, Polygons, RawMesh};
use glam::DVec3;
use proptest::collection::vec;
use proptest::prelude::*;

const HEAD_2: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
const HEAD_4: &str = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
/// Four nodes with gaps between their numbers, in no order.
const NODES_2: &str = "$Nodes\n4\n7 0 0 0\n3 1 0 0\n900 1 1 0\n12 0 1 0\n$EndNodes\n";
const NODES_4: &str = "$Nodes\n2 4 1 900000000000\n2 5 0 1\n7\n0 0 0\n2 6 1 3\n3\n900000000000\n12\n\
                       1 0 0 .5 .5\n1 1 0 .5 .5\n0 1 0 .5 .5\n$EndNodes\n";

fn square() -> Vec<DVec3> {
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]].map(DVec3::from).to_vec()
}

fn error_of(text: &str) -> String {
    read("msh", text.as_bytes()).unwrap_err().to_string()
}

fn faces(mesh: &RawMesh) -> Vec<&[u32]> {
    mesh.faces.iter().collect()
}

#[test]
fn version_2_with_gaps_names_and_unknown_sections() {
    let text = format!(
        "$Comments\nfree text $EndComments?\n$EndComments\n{HEAD_2}$PhysicalNames\n3\n1 3 \"the rim\"\n2 1 \"wall\"\n\
         3 1 \"fluid\"\n$EndPhysicalNames\n{NODES_2}$Elements\n5\n1 15 2 6 1 3\n2 1 2 3 1 7 3\n3 3 3 1 9 0 7 3 900 12\n\
         10 2 0 7 3 900\n5 4 1 1 7 3 900 12\n$EndElements\n$NodeData\n1\n\"x\"\n$EndNodeData\n"
    );
    let mesh = read("msh", text.as_bytes()).unwrap();
    assert_eq!(mesh.points, square());
    assert_eq!(faces(&mesh), [&[0, 1, 2, 3][..], &[0, 1, 2]]);
    assert_eq!(mesh.attributes.face["ref"], Column::Label(vec![1, 0]));
    assert_eq!(mesh.attributes.vertex["ref"], Column::Label(vec![0, 6, 0, 0]));
    assert_eq!((&mesh.edges[..], &mesh.edge_tags[..]), (&[[0, 1]][..], &[3][..]));
    assert_eq!((&mesh.cells.tets[..], &mesh.cells.tags[..]), (&[[0, 1, 2, 3]][..], &[1][..]));
    let names: Vec<_> = mesh.attributes.names.iter().map(|((c, k), n)| (c.as_str(), *k, n.as_str())).collect();
    assert_eq!(names, [("cell", 1, "fluid"), ("edge", 3, "the rim"), ("ref", 1, "wall")]);
    assert_eq!(mesh.notes, ["sections left out: $NodeData"]);
}

#[test]
fn version_4_with_entities_and_parametric_nodes() {
    let text = format!(
        "{HEAD_4}$Entities\n1 1 2 0\n1 0 0 0 0\n4 0 0 0 1 1 0 1 3 2 1 -1\n5 0 0 0 1 1 0 2 7 8 0\n6 0 0 0 1 1 0 1 7 1 4\n\
         $EndEntities\n{NODES_4}$Elements\n4 4 1 4\n1 4 1 1\n1 7 3\n2 5 3 1\n2 7 3 900000000000 12\n2 6 2 1\n3 7 3 12\n\
         0 1 15 1\n4 7\n$EndElements\n"
    );
    let mesh = read("msh", text.as_bytes()).unwrap();
    assert_eq!(mesh.points, square());
    assert_eq!(faces(&mesh), [&[0, 1, 2, 3][..], &[0, 1, 3]]);
    assert_eq!(mesh.attributes.face["ref"], Column::Label(vec![7, 7]));
    assert_eq!(mesh.attributes.face["entity"], Column::Label(vec![5, 6]));
    assert_eq!(mesh.edge_tags, [3]);
    assert_eq!(
        mesh.notes,
        ["1 entities have several physical tags: the first is kept", "1 point element without a physical tag left out"]
    );
}

#[test]
fn only_the_corners_of_higher_orders_are_kept() {
    for (head, element) in [
        (HEAD_2, "$Elements\n1\n1 9 0 7 3 900 12 12 12\n$EndElements\n"),
        (HEAD_4, "$Elements\n1 1 1 1\n2 1 9 1\n1 7 3 900000000000 12 12 12\n$EndElements\n"),
    ] {
        let nodes = if head == HEAD_2 { NODES_2 } else { NODES_4 };
        let mesh = read("msh", format!("{head}{nodes}{element}").as_bytes()).unwrap();
        assert_eq!(faces(&mesh), [&[0, 1, 2]]);
        assert_eq!(mesh.points.len(), 4);
        assert_eq!(mesh.notes.len(), 1);
        assert!(mesh.notes[0].starts_with("1 element of higher order: only its corners are kept"), "{:?}", mesh.notes);
    }
}

#[test]
fn errors_name_the_line() {
    let at_2 = |tail: &str| error_of(&format!("{HEAD_2}{NODES_2}{tail}"));
    let at_4 = |tail: &str| error_of(&format!("{HEAD_4}{NODES_4}{tail}"));
    let nodes_only = |nodes: &str| error_of(&format!("{HEAD_2}{nodes}"));
    let elements = "$Elements\n1\n";
    for (error, message) in [
        (at_2(&format!("{elements}1 2 0 7 3 8\n")), "line 13: node 8 of an element does not exist"),
        (at_2(&format!("{elements}1 2 0 7 3 -1\n")), "line 13: the number of a node is -1, it cannot be negative"),
        (at_2(&format!("{elements}1 34 0 7 3 12\n")), "line 13: elements of type 34 are not known"),
        (at_2(&format!("{elements}1 2 0 7 3")), "line 13: the file ends where the number of a node is expected"),
        (at_2(&format!("{elements}1 2 0 7 3 12\n2 2")), "line 14: $EndElements is expected, found '2'"),
        (
            at_2("$Elements\n99999999\n"),
            "line 12: 99999999 elements are announced, the rest of the file is too short for them",
        ),
        (at_2("$Elements\n-1\n"), "line 12: -1 elements are announced, the rest of the file is too short for them"),
        (at_2(NODES_2), "line 11: this is a second section $Nodes"),
        (at_2("Elements"), "line 11: the heading of a section ($…) is expected, found 'Elements'"),
        (at_2("$Other\nx\n"), "line 13: the section $Other has no end"),
        (at_2(""), "there is no section $Elements; the file may be cut"),
        (nodes_only(""), "there is no section $Nodes; the file may be cut"),
        (nodes_only("$Elements\n0\n"), "line 4: $Elements comes before $Nodes"),
        (nodes_only("$Nodes\n2\n1 0 0 0\n1 0 0 0\n$EndNodes\n"), "line 7: the node 1 is defined twice"),
        (
            nodes_only("$PhysicalNames\n1\n4 1 \"x\"\n"),
            "line 6: dimension, tag and name are expected, found '4 1 \"x\"'",
        ),
        (at_4("$Elements\n1 1 1 1\n2 5 2 1\n1 7 3 8"), "line 20: node 8 of an element does not exist"),
        (
            at_4("$Elements\n1 1 1 1\n2 5 2 77777777777"),
            "line 19: 77777777777 elements are announced, the rest of the file is too short for them",
        ),
        (error_of("ply"), "line 1: the heading of a section ($…) is expected, found 'ply'"),
        (error_of("$Nodes\n"), "line 1: $MeshFormat is expected at the start of a .msh file"),
        (error_of("$MeshFormat\n2.2 7 8\n"), "line 2: the type of the file is 7, neither 0 (text) nor 1 (binary)"),
        (
            error_of("$MeshFormat\n2.2 1 8\nxxxx"),
            "byte 20: the binary number 1 is expected, which tells the byte order",
        ),
    ] {
        assert_eq!(error, format!("test: {message}"));
    }
    for version in ["1", "4", "4.0", "3.5"] {
        let error = error_of(&format!("$MeshFormat\n{version} 0 8\n$EndMeshFormat\n"));
        assert!(error.contains(&format!("version {version} of the MSH format is not read")), "{error}");
    }
}

/// Appends binary numbers.
struct Builder {
    big: bool,
    /// Bytes of a size_t.
    size: usize,
    out: Vec<u8>,
}

impl Builder {
    fn new(version: &str, big: bool, size: usize) -> Self {
        let mut b = Builder { big, size, out: Vec::new() };
        b.text(&format!("$MeshFormat\n{version} 1 {size}\n")).ints(&[1]).text("\n$EndMeshFormat\n");
        b
    }

    fn text(&mut self, text: &str) -> &mut Self {
        self.out.extend(text.as_bytes());
        self
    }

    fn push(&mut self, mut big_endian: Vec<u8>) {
        if !self.big {
            big_endian.reverse();
        }
        self.out.extend(big_endian);
    }

    fn ints(&mut self, numbers: &[i32]) -> &mut Self {
        numbers.iter().for_each(|k| self.push(k.to_be_bytes().to_vec()));
        self
    }

    fn sizes(&mut self, numbers: &[u64]) -> &mut Self {
        numbers.iter().for_each(|k| self.push(k.to_be_bytes()[8 - self.size..].to_vec()));
        self
    }

    fn doubles(&mut self, numbers: &[f64]) -> &mut Self {
        numbers.iter().for_each(|x| self.push(x.to_be_bytes().to_vec()));
        self
    }
}

fn binary_2(big: bool) -> Vec<u8> {
    let mut b = Builder::new("2.2", big, 8);
    b.text("$PhysicalNames\n1\n2 10 \"a b\"\n$EndPhysicalNames\n$Nodes\n4\n");
    for (tag, p) in [10, 13, 36, 2].iter().zip(square()) {
        b.ints(&[*tag]).doubles(&p.to_array());
    }
    b.text("\n$EndNodes\n$Elements\n4\n");
    b.ints(&[1, 1, 2]).ints(&[1, 5, 6, 10, 13]);
    b.ints(&[2, 2, 2]).ints(&[2, 10, 1, 10, 13, 36]).ints(&[3, 10, 1, 10, 36, 2]);
    b.ints(&[3, 1, 0]).ints(&[4, 10, 13, 36, 2]);
    b.text("\n$EndElements\n").out.clone()
}

fn binary_4(big: bool, size: usize) -> Vec<u8> {
    let mut b = Builder::new("4.1", big, size);
    b.text("$PhysicalNames\n1\n2 10 \"a b\"\n$EndPhysicalNames\n$Entities\n");
    b.sizes(&[0, 1, 2, 0]);
    b.ints(&[1]).doubles(&[0.0; 6]).sizes(&[1]).ints(&[5]).sizes(&[2]).ints(&[3, -4]);
    b.ints(&[1]).doubles(&[0.0; 6]).sizes(&[1]).ints(&[10]).sizes(&[0]);
    b.ints(&[2]).doubles(&[0.0; 6]).sizes(&[0]).sizes(&[0]);
    b.text("\n$EndEntities\n$Strange\n").doubles(&[3.5]).text("\n$EndStrange\n$Nodes\n");
    b.sizes(&[1, 4, 2, 36]).ints(&[1, 1, 1]).sizes(&[4, 10, 13, 36, 2]);
    for p in square() {
        b.doubles(&p.to_array()).doubles(&[0.25]);
    }
    b.text("\n$EndNodes\n$Elements\n").sizes(&[3, 4, 1, 4]);
    b.ints(&[1, 1, 1]).sizes(&[1]).sizes(&[1, 10, 13]);
    b.ints(&[2, 1, 2]).sizes(&[2]).sizes(&[2, 10, 13, 36]).sizes(&[3, 10, 36, 2]);
    b.ints(&[2, 2, 3]).sizes(&[1]).sizes(&[4, 10, 13, 36, 2]);
    b.text("\n$EndElements\n").out.clone()
}

#[test]
fn binary_files_in_both_byte_orders() {
    let files = [false, true].map(|big| [binary_2(big), binary_4(big, 8), binary_4(big, 4)]);
    for bytes in files.iter().flatten() {
        let mesh = read("msh", bytes).unwrap();
        assert_eq!(mesh.points, square());
        assert_eq!(faces(&mesh), [&[0, 1, 2][..], &[0, 2, 3], &[0, 1, 2, 3]]);
        assert_eq!(mesh.attributes.face["ref"], Column::Label(vec![10, 10, 0]));
        assert_eq!((&mesh.edges[..], &mesh.edge_tags[..]), (&[[0, 1]][..], &[5][..]));
        assert_eq!(mesh.attributes.names[&("ref".to_string(), 10)], "a b");
    }
}

/// Every way to end early is an error: the last section is needed.
#[test]
fn files_cut_anywhere_are_refused() {
    for bytes in [binary_2(false), binary_4(true, 8)] {
        let full = bytes.len() - "$EndElements\n".len();
        for length in 0..=full {
            assert!(read("msh", &bytes[..length]).is_err(), "{length} of {} bytes", bytes.len());
        }
    }
}

#[test]
fn names_of_references_are_written() {
    let mut mesh = RawMesh { points: square(), faces: Polygons::from_triangles(&[[0, 1, 2]]), ..RawMesh::default() };
    (mesh.edges, mesh.edge_tags) = (vec![[0, 1]], vec![3]);
    mesh.attributes.face.insert("region".into(), Column::Label(vec![3]));
    mesh.attributes.face.insert("other".into(), Column::Label(vec![3]));
    for (label, name) in [("region", "the \"wall\"\n"), ("edge", "rim"), ("other", "lost")] {
        mesh.attributes.names.insert((label.to_string(), 3), name.to_string());
    }
    for ascii in [false, true] {
        let (bytes, warnings) = written(&mesh, "msh", ascii);
        assert_eq!(
            warnings,
            [
                "MSH does not hold these face attributes: other",
                "MSH has no place for the names of labels: left out those of 'other'"
            ]
        );
        let back = read("msh", &bytes).unwrap();
        let names: Vec<_> = back.attributes.names.iter().map(|((c, _), n)| (c.as_str(), n.as_str())).collect();
        assert_eq!(names, [("edge", "rim"), ("ref", "the 'wall' ")]);
        assert_eq!(back.attributes.face["ref"], Column::Label(vec![3]));
    }
}

#[test]
fn a_mesh_without_elements_is_a_file_too() {
    for mesh in [RawMesh::default(), RawMesh { points: square(), ..RawMesh::default() }] {
        for ascii in [false, true] {
            assert_eq!(content(&read("msh", &written(&mesh, "msh", ascii).0).unwrap()), content(&mesh));
        }
    }
}

proptest! {
    #[test]
    fn damaged_files_do_no_harm(which in 0..4, damage in vec(damage(), 1..4)) {
        let mut bytes = match which {
            0 => binary_2(false),
            1 => binary_4(false, 8),
            2 => format!("{HEAD_2}{NODES_2}$Elements\n1\n1 2 2 3 4 7 3 12\n$EndElements\n").into_bytes(),
            _ => format!("{HEAD_4}{NODES_4}$Elements\n1 1 1 1\n2 5 2 1\n1 7 3 12\n$EndElements\n").into_bytes(),
        };
        damage.iter().for_each(|d: &Damage| d.apply(&mut bytes));
        let _ = read("msh", &bytes);
    }
}

/// A cell of second order: Gmsh's own order of its nodes, by where these are; its corners are read.
#[test]
fn cells_of_second_order_have_their_nodes_in_order() {
    use crate::mesh::test_models::bricks;
    use crate::mesh::{HexMesh, SecondOrder, boundary_faces};
    let (points, hexes) = bricks([1; 3]);
    let quads: Vec<[u32; 4]> = boundary_faces(&hexes).into_iter().map(|f| f.0).collect();
    let mesh = HexMesh { points, hexes, tags: vec![1; quads.len()], quads };
    let (nodes, middles) = SecondOrder::of(&mesh).unwrap();
    let at = |list: &[u32]| list.iter().map(|&v| mesh.points[v as usize]).sum::<DVec3>() / list.len() as f64;
    let edges = middles.edges.iter().map(|e| at(e));
    let places: Vec<DVec3> = edges.chain(middles.faces.iter().map(|f| at(f))).chain([DVec3::splat(0.5)]).collect();
    let raw = RawMesh::from(mesh).with_second_order(nodes, &places);
    let mut file = Vec::new();
    let warnings = super::write::write(&raw, true, &mut file);
    assert!(warnings.is_empty(), "{warnings:?}");
    let text = String::from_utf8(file).unwrap();
    let is_cell = |line: &&str| line.split(' ').count() == 28;
    let row: Vec<usize> = text.lines().find(is_cell).unwrap().split(' ').skip(1).map(|n| n.parse().unwrap()).collect();
    // The table of Gmsh's manual, "Hexahedron27": edges and faces by their corners.
    let edges = [[0, 1], [0, 3], [0, 4], [1, 2], [1, 5], [2, 3], [2, 6], [3, 7], [4, 5], [4, 7], [5, 6], [6, 7]];
    let faces = [[0, 1, 2, 3], [0, 1, 4, 5], [0, 3, 4, 7], [1, 2, 5, 6], [2, 3, 6, 7], [4, 5, 6, 7]];
    let node = |n: usize| raw.points[row[n] - 1];
    let middle = |corners: &[usize]| corners.iter().map(|&c| node(c)).sum::<DVec3>() / corners.len() as f64;
    for (k, edge) in edges.iter().enumerate() {
        assert_eq!(node(8 + k), middle(edge), "edge {k}");
    }
    for (k, face) in faces.iter().enumerate() {
        assert_eq!(node(20 + k), middle(face), "face {k}");
    }
    assert_eq!(node(26), DVec3::splat(0.5));
    let elements = text.split("$Elements\n").nth(1).unwrap();
    let faces = elements.lines().filter(|line| line.split(' ').count() == 10).count();
    assert_eq!(faces, 6);
    let back = read("msh", text.as_bytes()).unwrap();
    assert!(back.cells.hexes.len() == 1 && back.faces.len() == 6 && !back.notes.is_empty());
}
