//! Medit text files (`.mesh`): keywords, each followed by a number of rows, in any order; `#` starts a comment.
//!
//! ```text
//! MeshVersionFormatted 2
//! Dimension 3
//! Vertices
//! 3
//! 0 0 0 0       x y z reference
//! 1 0 0 0
//! 0 1 0 0
//! Triangles
//! 1
//! 1 2 3 7       corners, counted from 1, and reference
//! End
//! ```
//!
//! What becomes of which section is said in [`super::medit_sections`]. Coordinates are read as written, in version 1
//! too; version 2 is written.

use super::medit_keywords::Keyword;
use super::medit_sections::{Contents, Numbers, Sections};
use super::source::{Source, WriteOptions};
use super::text::{Scanner, parse_float, parse_integer, push_float, push_integer, shown};
use crate::error::{Error, Place, Result};
use crate::mesh::RawMesh;

pub(super) fn read(source: &Source) -> Result<RawMesh> {
    let mut text = Scanner::new(source, Some(b'#'));
    read_header(&mut text)?;
    let mut contents = Contents::default();
    let mut dimension = 3;
    while let Some(word) = text.word() {
        if !is_keyword(word) {
            return Err(text.error(format!(
                "a keyword is expected, found '{}': are there more rows than announced?",
                shown(word)
            )));
        } else if word.eq_ignore_ascii_case(b"End") {
            contents.ended = true;
            break;
        } else if word.eq_ignore_ascii_case(b"Dimension") {
            dimension = read_dimension(&mut text)?;
        } else if word.eq_ignore_ascii_case(b"Vertices") {
            let count = text.count(2 * (dimension + 1), "the number of vertices")?;
            contents.read_vertices(&mut text, dimension, count)?;
        } else if let Some(keyword) = Keyword::named(word) {
            let count = text.count(2 * keyword.width(), &format!("the number of {}", keyword.name()))?;
            let start = text.position;
            contents.read_section(&mut text, keyword, start, count)?;
        } else {
            contents.skipped.push(shown(word));
            while text.peek().is_some_and(|w| !is_keyword(w)) {
                text.word();
            }
        }
    }
    contents.into_mesh(source, |start, number| place_of(source, start, number))
}

fn read_header(text: &mut Scanner) -> Result<()> {
    let word = text.expect_word("MeshVersionFormatted")?;
    if !word.eq_ignore_ascii_case(b"MeshVersionFormatted") {
        return Err(text.error(format!("MeshVersionFormatted is expected, found '{}'", shown(word))));
    }
    let version = text.integer("the version of the format")?;
    if (1..=4).contains(&version) { Ok(()) } else { Err(text.error(format!("version {version} is not one of 1 to 4"))) }
}

fn read_dimension(text: &mut Scanner) -> Result<usize> {
    match text.integer("the dimension")? {
        2 => Ok(2),
        3 => Ok(3),
        other => Err(text.error(format!("the dimension is {other}, only 2 and 3 are known"))),
    }
}

/// Keywords start with a letter, as `nan` and `inf` do.
fn is_keyword(word: &[u8]) -> bool {
    word.first().is_some_and(u8::is_ascii_alphabetic) && parse_float(word).is_none()
}

/// The line of the n-th word after a byte offset. Counting lines once more is cheaper than remembering all.
fn place_of(source: &Source, start: usize, number: usize) -> Place {
    let mut text = Scanner::new(source, Some(b'#'));
    while text.position < start && text.word().is_some() {}
    (0..=number).for_each(|_| _ = text.word());
    Place::Line(text.line_number())
}

impl Numbers for Scanner<'_> {
    fn index(&mut self) -> Result<i64> {
        self.integer("an index")
    }

    /// Some programs write references as fractions: `1.0`.
    fn reference(&mut self) -> Result<i64> {
        let word = self.expect_word("a reference number")?;
        let whole = |x: &f64| x.fract() == 0.0;
        let number = parse_integer(word).or_else(|| parse_float(word).filter(whole).map(|x| x as i64));
        number.ok_or_else(|| Scanner::error(self, format!("a reference number is expected, found '{}'", shown(word))))
    }

    fn coordinate(&mut self) -> Result<f64> {
        self.float("a coordinate")
    }

    fn error(&self, what: String) -> Error {
        Scanner::error(self, what)
    }
}

pub(super) fn write(mesh: &RawMesh, _options: &WriteOptions, out: &mut Vec<u8>) -> Result<Vec<String>> {
    let sections = Sections::of(mesh);
    out.extend_from_slice(b"MeshVersionFormatted 2\nDimension 3\n");
    push_heading(out, "Vertices", sections.vertex_count());
    for (point, reference) in sections.vertices() {
        for x in point.to_array() {
            push_float(out, x);
            out.push(b' ');
        }
        push_integer(out, reference);
        out.push(b'\n');
    }
    for block in &sections.blocks {
        push_heading(out, block.keyword.name(), block.len());
        for (indices, reference) in block.rows() {
            for &index in indices {
                push_integer(out, u64::from(index) + 1);
                out.push(b' ');
            }
            match reference {
                Some(reference) => push_integer(out, reference),
                None => _ = out.pop(),
            }
            out.push(b'\n');
        }
    }
    out.extend_from_slice(b"\nEnd\n");
    Ok(sections.warnings)
}

fn push_heading(out: &mut Vec<u8>, name: &str, count: usize) {
    out.push(b'\n');
    out.extend_from_slice(name.as_bytes());
    out.push(b'\n');
    push_integer(out, count);
    out.push(b'\n');
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::round_trips::{content, read as read_as, written};
    use crate::mesh::Column;
    use glam::DVec3;

    const HEAD: &str = "MeshVersionFormatted 2\nDimension 3\n";
    const SQUARE: &str = "Vertices\n4\n0 0 0 0\n1 0 0 0\n1 1 0 0\n0 1 0 0\n";

    fn error_of(text: &str) -> String {
        read_as("mesh", text.as_bytes()).unwrap_err().to_string()
    }

    #[test]
    fn comments_case_line_ends_and_aliases() {
        let text = "# head\r\nmeshversionformatted\r\n1\r\nDIMENSION # two\r\n2\r\nVertices 3\r\n0 0 1\r1.5D0 +0 2 # b\n\
                    0 1e0 1.0 Triangles 1 1 2 3 4 Hexaedra 1 1 2 3 1 2 3 1 2 6 Pentahedra 1 1 2 3 1 2 3 5";
        let mesh = read_as("mesh", text.as_bytes()).unwrap();
        assert_eq!(mesh.points, [[0.0, 0.0, 0.0], [1.5, 0.0, 0.0], [0.0, 1.0, 0.0]].map(DVec3::from));
        assert_eq!(mesh.attributes.vertex["ref"], Column::Label(vec![1, 2, 1]));
        assert_eq!(mesh.attributes.face["ref"], Column::Label(vec![4]));
        assert_eq!(mesh.cells.hexes, [[0, 1, 2, 0, 1, 2, 0, 1]]);
        assert_eq!(mesh.cells.wedges, [[0, 1, 2, 0, 1, 2]]);
        assert_eq!(mesh.cells.tags, [6, 5]);
        assert_eq!(mesh.notes, ["the keyword End is missing: the file may be cut"]);
    }

    #[test]
    fn faces_keep_the_order_of_their_sections() {
        let text =
            format!("{HEAD}Quadrilaterals 1 1 2 3 4 7 {SQUARE} Triangles 1 1 2 3 0 Quadrilaterals 1 4 3 2 1 9 End");
        let mesh = read_as("mesh", text.as_bytes()).unwrap();
        let faces: Vec<&[u32]> = mesh.faces.iter().collect();
        assert_eq!(faces, [&[0, 1, 2, 3][..], &[0, 1, 2], &[3, 2, 1, 0]]);
        assert_eq!(mesh.attributes.face["ref"], Column::Label(vec![7, 0, 9]));
    }

    #[test]
    fn marks_and_sections_that_are_left_out() {
        let text = format!(
            "{HEAD}{SQUARE}Edges 2 1 2 5 2 3 0 Ridges 1 2 RequiredEdges 1 1 Corners 2 1 4 RequiredVertices 1 3\n\
             Normals 1 nan inf -1 NormalAtVertices 1 1 1 End"
        );
        let mesh = read_as("mesh", text.as_bytes()).unwrap();
        assert_eq!(mesh.attributes.vertex["corner"], Column::Label(vec![1, 0, 0, 1]));
        assert_eq!(mesh.attributes.vertex["required"], Column::Label(vec![0, 0, 1, 0]));
        assert_eq!((mesh.edges, mesh.edge_tags), (vec![[0, 1], [1, 2]], vec![5, 0]));
        assert_eq!(mesh.notes.len(), 3);
        assert_eq!(mesh.notes[2], "sections left out: Normals, NormalAtVertices");
    }

    #[test]
    fn references_may_be_whole_fractions_and_too_large() {
        let text = format!("{HEAD}Vertices 2 0 0 0 -3.0 0 0 0 3000000000 End");
        let mesh = read_as("mesh", text.as_bytes()).unwrap();
        assert_eq!(mesh.attributes.vertex["ref"], Column::Label(vec![-3, 0]));
        assert_eq!(mesh.notes, ["1 references do not fit 32 bits and became 0"]);
        assert!(
            error_of(&format!("{HEAD}Vertices 1 0 0 0 0.5")).contains("a reference number is expected, found '0.5'")
        );
    }

    #[test]
    fn errors_name_the_line() {
        for (tail, message) in [
            ("Triangles\n2\n1 2 3 0\n1 2 5 0\nEnd", "line 12: Triangles, row 2: vertex 5 does not exist, there are 4"),
            (
                "Triangles 3 1 2 3 0 1 2 3 0\n1 2\n9 0",
                "line 11: Triangles, row 3: vertex 9 does not exist, there are 4",
            ),
            ("Edges\n1\n1 2 0\nRidges\n1\n2\n", "line 14: Ridges, row 1: edge 2 does not exist, there are 1"),
            ("Triangles\n1\n1 0 3 0", "line 11: Triangles: 0 is not an index (indices start at 1)"),
            ("Triangles\n1\n1 2 x 0", "line 11: an index is expected, found 'x'"),
            (
                "Triangles\n1\n1 2 3 0\n1 2 3 0",
                "line 12: a keyword is expected, found '1': are there more rows than announced?",
            ),
            ("Triangles\n2\n1 2 3 1000000000 1", "line 11: the file ends where an index is expected"),
            ("Triangles\n-1", "line 10: the number of Triangles is -1, the rest of the file is 0 bytes"),
            (
                "Triangles\n99999999999",
                "line 10: the number of Triangles is 99999999999, the rest of the file is 0 bytes",
            ),
            ("Vertices 0", "line 9: this is a second section Vertices"),
        ] {
            assert_eq!(error_of(&format!("{HEAD}{SQUARE}{tail}")), format!("test: {message}"));
        }
        assert_eq!(error_of("solid x"), "test: line 1: MeshVersionFormatted is expected, found 'solid'");
        assert_eq!(error_of("MeshVersionFormatted 5"), "test: line 1: version 5 is not one of 1 to 4");
        assert_eq!(
            error_of("MeshVersionFormatted 2\nDimension 4"),
            "test: line 2: the dimension is 4, only 2 and 3 are known"
        );
        assert!(error_of(HEAD).contains("no section Vertices"));
    }

    /// A hexahedral mesh with its boundary: cell tags, and face references from whichever label there is.
    #[test]
    fn hexahedra_and_their_boundary_are_written() {
        let mut mesh = RawMesh { points: (0..8).map(|k| DVec3::splat(f64::from(k))).collect(), ..RawMesh::default() };
        mesh.cells.hexes = vec![[0, 1, 2, 3, 4, 5, 6, 7]];
        mesh.cells.tags = vec![4];
        mesh.faces.push(&[0, 3, 2, 1]);
        mesh.faces.push(&[4, 5, 6, 7]);
        mesh.attributes.face.insert("tag".into(), Column::Label(vec![1, 2]));
        for extension in ["mesh", "meshb"] {
            let (bytes, warnings) = written(&mesh, extension, false);
            assert!(warnings.is_empty());
            let back = read_as(extension, &bytes).unwrap();
            assert_eq!((&back.cells, &back.faces), (&mesh.cells, &mesh.faces));
            assert_eq!(back.attributes.face["ref"], Column::Label(vec![1, 2]));
        }
        mesh.attributes.face.insert("region".into(), Column::Label(vec![8, 9]));
        let (bytes, warnings) = written(&mesh, "mesh", false);
        assert_eq!(read_as("mesh", &bytes).unwrap().attributes.face["ref"], Column::Label(vec![8, 9]));
        assert_eq!(warnings, ["Medit does not hold these face attributes: tag"]);
    }

    #[test]
    fn what_does_not_fit_is_said() {
        let mut mesh = RawMesh { points: vec![DVec3::ZERO; 5], ..RawMesh::default() };
        mesh.faces.push(&[0, 1, 2, 3, 4]);
        mesh.attributes.face.insert("ref".into(), Column::Label(vec![3]));
        mesh.attributes.vertex.insert("size".into(), Column::Scalar(vec![1.0; 5]));
        mesh.attributes.names.insert(("ref".into(), 3), "wall".into());
        let (bytes, warnings) = written(&mesh, "mesh", false);
        assert_eq!(warnings.len(), 3, "{warnings:?}");
        let back = read_as("mesh", &bytes).unwrap();
        assert_eq!(back.faces, crate::mesh::Polygons::from_triangles(&[[0, 1, 2], [0, 2, 3], [0, 3, 4]]));
        assert_eq!(back.attributes.face["ref"], Column::Label(vec![3; 3]));
        assert_eq!(content(&back), content(&read_as("meshb", &written(&mesh, "meshb", false).0).unwrap()));
    }
}
