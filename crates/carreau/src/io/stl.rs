//! STL, binary and text, read and written.
//!
//! STL lists the corners of triangles without saying which are the same vertex: corners at exactly equal positions are
//! welded (0 equals -0), vertices being numbered in the order of first use. Normals and attribute bytes are not kept:
//! the corners tell the normal, and each program has its own use of the bytes. The solids of a text file with several
//! become the face column `solid`.
//!
//! The format: "StereoLithography Interface Specification", 3D Systems, 1989. It has no mark to tell binary from text;
//! many binary files start with `solid` as text files must. A file whose length is that of its triangle count is
//! binary.

use super::binary::{Cursor, Endian};
use super::limits::{columns_left_out, edges_left_out, moved_by_single_precision, require_surface, words_left_out};
use super::names::{FaceNames, labels, plain_name, written_name};
use super::source::{Source, WriteOptions};
use super::text::{Scanner, push_float};
use crate::error::{Error, Place, Result};
use crate::mesh::{Column, RawMesh};
use glam::DVec3;
use rustc_hash::FxHashMap;
use std::hash::Hash;

/// The header of a binary file: 80 bytes and the number of triangles.
const HEADER: usize = 84;
/// A triangle of a binary file: normal and three corners in single precision, two bytes of attributes.
const RECORD: usize = 50;

pub(super) fn read(source: &Source) -> Result<RawMesh> {
    let count = binary_count(source.bytes);
    let complete = count.is_some_and(|n| source.bytes.len() as u64 == HEADER as u64 + RECORD as u64 * u64::from(n));
    match count {
        _ if !complete && looks_like_text(source.bytes) => read_text(source),
        Some(count) => read_binary(source, count),
        None => {
            Err(source.error(Place::File, "this does not look like STL: no 'solid' and too short for a binary file"))
        }
    }
}

fn binary_count(bytes: &[u8]) -> Option<u32> {
    let count = bytes.get(80..HEADER)?;
    Some(u32::from_le_bytes(count.try_into().ok()?))
}

/// Whether the file starts with `solid` and goes on with words of the text format.
fn looks_like_text(bytes: &[u8]) -> bool {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let start = &bytes[..bytes.len().min(512)].trim_ascii_start();
    let contains = |part: &[u8], word: &[u8]| part.windows(word.len()).any(|w| w.eq_ignore_ascii_case(word));
    start.get(..5).is_some_and(|w| w.eq_ignore_ascii_case(b"solid"))
        && (contains(&bytes[..bytes.len().min(4096)], b"facet") || contains(bytes, b"endsolid"))
}

/// Gives equal positions one id, in the order of first use.
struct Welder<K> {
    ids: FxHashMap<K, u32>,
    points: Vec<DVec3>,
}

impl<K: Hash + Eq> Welder<K> {
    fn new() -> Self {
        Welder { ids: FxHashMap::default(), points: Vec::new() }
    }

    /// The id of a position; equal positions, and no others, have equal keys.
    #[inline]
    fn id(&mut self, key: K, point: DVec3) -> u32 {
        let next = self.points.len() as u32;
        let id = *self.ids.entry(key).or_insert(next);
        if id == next {
            self.points.push(point);
        }
        id
    }
}

fn read_binary(source: &Source, count: u32) -> Result<RawMesh> {
    let present = (source.bytes.len() - HEADER) / RECORD;
    let count = count as usize;
    if count > present {
        let printable = source.bytes[..HEADER].iter().all(|b| matches!(b, b'\t'..=b'\r' | b' '..=b'~'));
        let what = match printable {
            true => {
                "this does not look like STL: neither a text file that starts with 'solid' nor a binary one".to_string()
            }
            false => format!("{count} triangles are announced, the file holds {present}: it is cut off or no STL"),
        };
        return Err(source.error(Place::Byte(80), what));
    }
    let mut mesh = RawMesh::default();
    let mut welder = Welder::new();
    mesh.faces.reserve(count, 3 * count);
    let mut cursor = Cursor::new(source, HEADER, Endian::Little);
    for _ in 0..count {
        let record = cursor.take(RECORD)?;
        let (corners, _) = record[12..48].as_chunks::<4>();
        let mut face = [0; 3];
        for (id, [x, y, z]) in face.iter_mut().zip(corners.as_chunks::<3>().0) {
            let position = [x, y, z].map(|bytes| f32::from_le_bytes(*bytes));
            *id = welder.id(position.map(|x| (x + 0.0).to_bits()), DVec3::from_array(position.map(f64::from)));
        }
        mesh.faces.push(&face);
    }
    mesh.points = welder.points;
    if cursor.remaining() > 0 {
        mesh.notes
            .push(format!("left out {} bytes behind the {count} triangles that are announced", cursor.remaining()));
    }
    Ok(mesh)
}

fn read_text(source: &Source) -> Result<RawMesh> {
    let mut scanner = Scanner::new(source, None);
    let mut mesh = RawMesh::default();
    let mut welder = Welder::new();
    let mut solids = FaceNames::new("");
    let mut corners = Vec::new();
    let mut open = false;
    let is = |word: &[u8], what: &str| word.eq_ignore_ascii_case(what.as_bytes());
    while let Some(word) = scanner.word() {
        if is(word, "vertex") {
            let position = [scanner.float("x")?, scanner.float("y")?, scanner.float("z")?];
            corners.push(welder.id(position.map(|x| (x + 0.0).to_bits()), DVec3::from_array(position)));
        } else if is(word, "facet") || is(word, "endfacet") {
            if !matches!(corners.len(), 0 | 3) {
                return Err(scanner.error(format!("a facet must have 3 corners, this one has {}", corners.len())));
            }
            if !corners.is_empty() {
                mesh.faces.push(&corners);
                solids.face();
                corners.clear();
            }
        } else if is(word, "solid") {
            open = true;
            solids.name(scanner.rest_of_line(), mesh.faces.len());
        } else if is(word, "endsolid") {
            open = false;
            scanner.rest_of_line();
        }
        // Normals and the words around them tell nothing that the corners do not.
    }
    if !corners.is_empty() {
        return Err(scanner.error("the file ends within a facet"));
    }
    if open {
        mesh.notes.push("the file has no 'endsolid': its end may be missing".into());
    }
    mesh.points = welder.points;
    if solids.count() > 1 {
        solids.store("solid", &mut mesh.attributes);
    } else if let Some(name) = solids.only().filter(|name| !name.is_empty()) {
        mesh.attributes.names.insert(("solid".into(), 0), name);
    }
    Ok(mesh)
}

pub(super) fn write(mesh: &RawMesh, options: &WriteOptions, out: &mut Vec<u8>) -> Result<Vec<String>> {
    require_surface(mesh, "STL")?;
    let (triangles, parent) = mesh.faces.fan();
    let mut warnings = warnings(mesh, options.ascii);
    if options.ascii {
        write_text(mesh, &triangles, &parent, out);
    } else {
        write_binary(mesh, &triangles, out)?;
        if let Some(moved) = moved_by_single_precision(mesh) {
            warnings.push(format!(
                "binary STL has single precision, which moves vertices by up to {moved:.1e}; the text form has double"
            ));
        }
    }
    Ok(warnings)
}

fn write_binary(mesh: &RawMesh, triangles: &[[u32; 3]], out: &mut Vec<u8>) -> Result<()> {
    let Ok(count) = u32::try_from(triangles.len()) else {
        return Err(Error::input(
            "binary STL cannot count more than 4,294,967,295 triangles",
            "",
            "use another format",
        ));
    };
    if let Some(v) = mesh.points.iter().position(|p| !p.as_vec3().is_finite()) {
        return Err(Error::input(
            "a coordinate is too large for the single precision of binary STL",
            format!("vertex {v}"),
            "write STL as text, or another format",
        ));
    }
    let mut header = *b"binary STL, written by carreau                                                  ";
    header[79] = b'\n';
    out.reserve(HEADER + RECORD * triangles.len());
    out.extend_from_slice(&header);
    out.extend_from_slice(&count.to_le_bytes());
    for triangle in triangles {
        let corners = triangle.map(|v| mesh.points[v as usize]);
        for vector in [normal(corners)].iter().chain(&corners) {
            vector.as_vec3().to_array().iter().for_each(|x| out.extend_from_slice(&x.to_le_bytes()));
        }
        out.extend_from_slice(&[0, 0]);
    }
    Ok(())
}

/// Text, one solid for each run of faces with the same label in the column `solid`.
fn write_text(mesh: &RawMesh, triangles: &[[u32; 3]], parent: &[u32], out: &mut Vec<u8>) {
    let solids = labels(mesh, "solid");
    let solid = |face: u32| solids.map(|labels| labels[face as usize]);
    let name = |label: Option<i32>| label.map_or(String::new(), |l| format!(" {}", written_name(mesh, "solid", l)));
    // A body that is alone has a name and no labels.
    let only = mesh.attributes.only_body().filter(|_| solids.is_none()).map(plain_name);
    let name = |label: Option<i32>| match &only {
        Some(only) => format!(" {only}"),
        None => name(label),
    };
    let mut current = parent.first().and_then(|&face| solid(face));
    out.extend_from_slice(format!("solid{}\n", name(current)).as_bytes());
    for (triangle, &face) in triangles.iter().zip(parent) {
        if solids.is_some() && solid(face) != current {
            let last = std::mem::replace(&mut current, solid(face));
            out.extend_from_slice(format!("endsolid{}\nsolid{}\n", name(last), name(current)).as_bytes());
        }
        let corners = triangle.map(|v| mesh.points[v as usize]);
        push_vector(out, "facet normal", normal(corners));
        out.extend_from_slice(b" outer loop\n");
        corners.into_iter().for_each(|corner| push_vector(out, "  vertex", corner));
        out.extend_from_slice(b" endloop\nendfacet\n");
    }
    out.extend_from_slice(format!("endsolid{}\n", name(current)).as_bytes());
}

fn push_vector(out: &mut Vec<u8>, what: &str, vector: DVec3) {
    out.extend_from_slice(what.as_bytes());
    for x in vector.to_array() {
        out.push(b' ');
        push_float(out, x);
    }
    out.push(b'\n');
}

/// The unit normal; zero for a triangle without area, as is usual in STL.
fn normal(corners: [DVec3; 3]) -> DVec3 {
    let size = corners.iter().map(|c| c.abs().max_element()).fold(0.0, f64::max);
    if size == 0.0 {
        return DVec3::ZERO;
    }
    // Scaled, so that squares of extreme coordinates neither overflow nor vanish.
    let [a, b, c] = corners.map(|corner| corner / size);
    (b - a).cross(c - a).normalize_or_zero()
}

fn warnings(mesh: &RawMesh, ascii: bool) -> Vec<String> {
    let all = mesh.faces.len();
    let polygons = mesh.faces.iter().filter(|f| f.len() > 3).count();
    let polygons = (polygons > 0)
        .then(|| format!("STL has triangles only: fanned {polygons} of {all} faces from their first corners"));
    let mut used = vec![false; mesh.points.len()];
    mesh.faces.corners().iter().for_each(|&v| used[v as usize] = true);
    let unused = used.iter().filter(|&&u| !u).count();
    let all = mesh.points.len();
    let unused = (unused > 0)
        .then(|| format!("STL has no place for vertices without faces: left out {unused} of {all} vertices"));
    let columns = &mesh.attributes;
    let vertex = columns_left_out("STL", "vertex", &columns.vertex, |_, _| false);
    let face = columns_left_out("STL", "face", &columns.face, |name, column| {
        ascii && name == "solid" && matches!(column, Column::Label(_))
    });
    let corner = columns_left_out("STL", "corner", &columns.corner, |_, _| false);
    let words = words_left_out("STL", mesh, |column| ascii && column == "solid", |_| false);
    let ornaments = [polygons, unused, vertex, face, corner, edges_left_out("STL", mesh)];
    ornaments.into_iter().flatten().chain(words).collect()
}

#[cfg(test)]
mod tests {
    use super::super::surface_tests::{error_of, faces_of, read_as};
    use super::*;

    const FACET: &str = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";

    fn read(bytes: impl AsRef<[u8]>) -> RawMesh {
        read_as("a.stl", bytes).unwrap()
    }

    /// A binary file with this header and count.
    fn binary(header: &[u8], count: u32, triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
        let mut file = header.to_vec();
        file.resize(80, 0);
        file.extend(count.to_le_bytes());
        for corners in triangles {
            file.extend([0; 12]);
            corners.as_flattened().iter().for_each(|x| file.extend(x.to_le_bytes()));
            file.extend([0xff, 0x7f]);
        }
        file
    }

    const A: [f32; 3] = [0.0, 0.0, 0.0];
    const B: [f32; 3] = [0.1, 0.0, 0.0];
    const C: [f32; 3] = [0.0, 0.1, 0.0];

    #[test]
    fn text_in_any_layout() {
        let plain = read(format!("solid\n{FACET}endsolid\n"));
        assert_eq!((plain.points.len(), faces_of(&plain)), (3, vec![vec![0, 1, 2]]));
        for text in [
            format!("solid name of it\n{FACET}endsolid name of it\n"),
            format!("\u{feff}  SOLID x\r\n{}ENDSOLID", FACET.to_uppercase().replace('\n', "\r\n")),
            format!("solid vertex 1 2 facet\r{}endsolid vertex 9\r", FACET.replace('\n', "\r")),
            format!("solid\n{}endsolid", FACET.replace('\n', " ").replace("0 0 1", "nan -nan 1e999")),
            format!("solid a\n{FACET}endsolid a\nsolid b\nendsolid b\n"),
        ] {
            let mesh = read(&text);
            assert_eq!((&mesh.points, &mesh.faces), (&plain.points, &plain.faces), "{text}");
            assert!(mesh.notes.is_empty() && mesh.attributes.face.is_empty());
        }
        assert!(read("solid empty\nendsolid\n").faces.is_empty());
    }

    #[test]
    fn solids_become_labels() {
        let mesh = read(format!("solid a\n{FACET}{FACET}endsolid\nsolid\n{FACET}endsolid\nsolid a\n{FACET}endsolid\n"));
        assert_eq!(mesh.attributes.face["solid"], Column::Label(vec![0, 0, 1, 0]));
        assert_eq!(mesh.attributes.names.values().collect::<Vec<_>>(), ["a", ""]);
    }

    #[test]
    fn corners_are_welded_in_the_order_of_first_use() {
        let mesh = read(binary(b"", 2, &[[A, B, C], [C, [0.1, -0.0, 0.0], [-0.0, 0.0, -0.0]]]));
        assert_eq!(faces_of(&mesh), [[0, 1, 2], [2, 1, 0]]);
        assert_eq!(mesh.points[1].x, f64::from(0.1f32));
        let nearby = f32::from_bits(0.1f32.to_bits() + 1);
        assert_eq!(read(binary(b"", 2, &[[A, B, C], [A, [nearby, 0.0, 0.0], C]])).points.len(), 4);
    }

    #[test]
    fn binary_whatever_the_header_says() {
        for header in [&b""[..], b"solid facet", b"solid endsolid", b"COLOR=\x01\x02\x03\x04"] {
            assert_eq!(faces_of(&read(binary(header, 1, &[[A, B, C]]))), [[0, 1, 2]]);
            assert!(read(binary(header, 0, &[])).faces.is_empty());
        }
    }

    #[test]
    fn a_count_that_is_too_small_is_believed_and_noted() {
        let mesh = read(binary(b"", 1, &[[A, B, C], [A, C, B]]));
        assert_eq!((mesh.faces.len(), mesh.notes.len()), (1, 1));
    }

    #[test]
    fn what_is_wrong_is_told_with_its_place() {
        let text = format!("solid a\n{FACET}endsolid\n");
        for (file, what) in [
            (binary(b"", 2, &[[A, B, C]]), "byte 80: 2 triangles are announced, the file holds 1"),
            (binary(b"", u32::MAX, &[[A, B, C]]), "4294967295 triangles are announced"),
            (binary(b"", 1, &[[A, B, [f32::NAN, 0.0, 0.0]]]), "not finite"),
            (b"solid".to_vec(), "does not look like STL"),
            ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".repeat(5).into_bytes(), "does not look like STL"),
            (text.replace("vertex 1 0 0\n", "").into_bytes(), "line 7: a facet must have 3 corners, this one has 2"),
            (
                text.replace("endloop", "vertex 5 5 5").into_bytes(),
                "line 8: a facet must have 3 corners, this one has 4",
            ),
            (text.replace("vertex 1 0 0", "vertex 1 0").into_bytes(), "line 6: z is expected, found 'vertex'"),
            (text.replace("vertex 1 0 0", "vertex 1 0,5 0").into_bytes(), "line 5: y is expected, found '0,5'"),
            (text[..text.find("endfacet").unwrap()].into(), "the file ends within a facet"),
        ] {
            let message = error_of("a.stl", &file);
            assert!(message.contains(what), "{}: {message}", String::from_utf8_lossy(&file));
        }
        assert_eq!(read(format!("solid\n{FACET}")).notes.len(), 1);
    }

    #[test]
    fn rounding_and_fans_are_told() {
        let mut mesh = RawMesh { points: vec![DVec3::ZERO, DVec3::X, DVec3::ONE, DVec3::Y], ..RawMesh::default() };
        mesh.faces.push(&[0, 1, 2, 3]);
        let write = |mesh: &RawMesh| write(mesh, &WriteOptions::default(), &mut Vec::new());
        assert!(matches!(&write(&mesh).unwrap()[..], [w] if w.contains("fanned 1 of 1 faces")));
        mesh.points[1].x = 0.1;
        mesh.points.push(DVec3::ONE);
        let warnings = write(&mesh).unwrap();
        assert_eq!(warnings.len(), 2, "rounding by a share of 1e-8 is not worth a word: {warnings:?}");
        let mut far = mesh.clone();
        far.points.iter_mut().for_each(|p| p.x += 1e7);
        assert!(write(&far).unwrap().iter().any(|w| w.contains("moves vertices by up to")));
        assert!(warnings.iter().any(|w| w.contains("left out 1 of 5 vertices")), "{warnings:?}");
        mesh.points[1].x = 1e300;
        assert!(matches!(write(&mesh), Err(Error::Input { place, .. }) if place == "vertex 1"));
    }

    #[test]
    fn normals_are_unit_or_zero_whatever_the_size() {
        for size in [1.0, 1e300, 1e-300, 5e-324, 1.7e308] {
            let n = normal([DVec3::ZERO, DVec3::X * size, DVec3::Y * size]);
            assert_eq!(n, DVec3::Z, "{size}");
            assert_eq!(normal([DVec3::ZERO, DVec3::X * size, DVec3::X * size]), DVec3::ZERO);
        }
    }
}
