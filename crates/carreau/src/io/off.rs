//! Geomview OFF, read (text and binary) and written (text, since the binary form has single precision only).
//!
//! The keyword tells what each vertex has behind its coordinates: `N` a normal, `C` a colour, `ST` texture coordinates,
//! in this order; they become the vertex columns `normal`, `color`, `uv`. Numbers behind the corners of a face are its
//! colour and become the face column `color` where every face has one.
//!
//! Nearly all files have one vertex or face a line, and many have more on those lines than the keyword tells; therefore a
//! file is read line by line first, and as a stream of numbers only where that fails.
//!
//! The format: <http://www.geomview.org/docs/html/OFF.html>.

use super::binary::{Cursor, Endian};
use super::limits::{columns_left_out, drop_short_faces, edges_left_out, require_surface};
use super::text::{Scanner, parse_float, parse_integer, push_float, push_integer, shown};
use super::{Source, WriteOptions};
use crate::error::Result;
use crate::mesh::{Column, RawMesh};
use glam::DVec3;

/// Most numbers a vertex can have: position, normal, colour with opacity, texture coordinates.
const WIDEST: usize = 3 + 3 + 4 + 2;

pub(super) fn read(source: &Source) -> Result<RawMesh> {
    let mut scanner = Scanner::new(source, Some(b'#'));
    let keyword = Keyword::read(&mut scanner)?;
    if keyword.binary {
        scanner.next_line();
        return read_binary(source, scanner.position, keyword)?.finish();
    }
    let vertices = match keyword.glued_count {
        Some(count) => count,
        None => scanner.count(6, "the number of vertices")?,
    };
    let faces = scanner.count(2, "the number of faces")?;
    skip_edge_count(&mut scanner);
    let by_line = read_lines(&mut scanner.clone(), keyword, vertices, faces);
    // Where neither way works, the lines give the better message.
    by_line.or_else(|error| read_stream(&mut scanner, keyword, vertices, faces).map_err(|_| error))?.finish()
}

/// What the first word tells.
#[derive(Clone, Copy, Default)]
struct Keyword {
    normals: bool,
    colors: bool,
    uvs: bool,
    binary: bool,
    /// The number of vertices where it is glued to the keyword (`OFF8 6 0`), as some files have it.
    glued_count: Option<usize>,
}

impl Keyword {
    /// Reads the keyword; it may be missing.
    fn read(scanner: &mut Scanner) -> Result<Self> {
        let word = scanner.peek().ok_or_else(|| scanner.error("there are only comments in the file"))?;
        if parse_integer(word).is_some() {
            return Ok(Keyword::default());
        }
        scanner.word();
        let foreign = || scanner.error(format!("this does not look like OFF: it starts with '{}'", shown(word)));
        let at = word.windows(3).position(|w| w.eq_ignore_ascii_case(b"OFF")).ok_or_else(foreign)?;
        let (prefix, rest) = (&word[..at], &word[at + 3..]);
        // `nOFF` has points in n dimensions, `4OFF` homogeneous ones; an `n` among small letters is a normal.
        let small = word[at].is_ascii_lowercase();
        if prefix.contains(&b'4') || (prefix.contains(&b'n') && !small) {
            return Err(scanner.error(format!(
                "'{}' has points with another number of coordinates than 3, which is not supported",
                shown(word)
            )));
        }
        let mut keyword = Keyword::from_prefix(prefix).ok_or_else(foreign)?;
        if !rest.is_empty() {
            let count = parse_integer(rest).and_then(|n| usize::try_from(n).ok());
            keyword.glued_count = Some(count.filter(|&n| n <= scanner.remaining() / 6).ok_or_else(foreign)?);
        }
        keyword.binary = scanner.clone().word_on_line().is_some_and(|w| w.eq_ignore_ascii_case(b"BINARY"));
        Ok(keyword)
    }

    fn from_prefix(mut prefix: &[u8]) -> Option<Self> {
        let mut keyword = Keyword::default();
        loop {
            prefix = match prefix {
                [] => return Some(keyword),
                [b's' | b'S', b't' | b'T', rest @ ..] => {
                    keyword.uvs = true;
                    rest
                }
                [b'c' | b'C', rest @ ..] => {
                    keyword.colors = true;
                    rest
                }
                [b'n' | b'N', rest @ ..] => {
                    keyword.normals = true;
                    rest
                }
                _ => return None,
            };
        }
    }

    /// How many numbers a vertex has, a colour being four.
    fn width(self) -> usize {
        3 + 3 * usize::from(self.normals) + 4 * usize::from(self.colors) + 2 * usize::from(self.uvs)
    }
}

/// The number of edges, which means nothing and is often missing: a third number on the line of the other two, or a
/// number alone on the next.
fn skip_edge_count(scanner: &mut Scanner) {
    if scanner.word_on_line().is_none() {
        let mut ahead = scanner.clone();
        if ahead.word().is_some() && ahead.word_on_line().is_none() {
            *scanner = ahead;
        }
    }
}

/// What has been read so far.
#[derive(Default)]
struct Body {
    mesh: RawMesh,
    normals: Vec<[f64; 3]>,
    colors: Colors,
    uvs: Vec<[f64; 2]>,
    face_colors: Colors,
    /// Vertices with more numbers than the keyword tells.
    overlong: usize,
    /// Corners of the current face.
    face: Vec<u32>,
}

fn read_lines(scanner: &mut Scanner, keyword: Keyword, vertices: usize, faces: usize) -> Result<Body> {
    let mut body = Body::default();
    body.mesh.points.reserve(vertices);
    body.mesh.faces.reserve(faces, 3 * faces);
    for _ in 0..vertices {
        let mut values = [0.0; WIDEST];
        values[0] = scanner.float("a coordinate")?;
        let count = 1 + scanner.floats_on_line(&mut values[1..], "a number")?;
        if count < 3 {
            return Err(scanner.error(format!("a vertex has only {count} of 3 coordinates")));
        }
        body.push_vertex(&values[..count], keyword);
        scanner.next_line();
    }
    for _ in 0..faces {
        body.start_face(scanner, vertices)?;
        let color = color_on_line(scanner);
        body.push_face(color);
        scanner.next_line();
    }
    if scanner.word().is_some() {
        body.mesh.notes.push(format!("left out what follows the last face, from line {}", scanner.line_number()));
    }
    Ok(body)
}

/// Numbers wherever they stand, without colours of faces, whose end could not be told; nothing may be left over.
fn read_stream(scanner: &mut Scanner, keyword: Keyword, vertices: usize, faces: usize) -> Result<Body> {
    let mut body = Body::default();
    for _ in 0..vertices {
        let mut values = [0.0; WIDEST];
        let values = &mut values[..keyword.width()];
        for value in values.iter_mut() {
            *value = scanner.float("a number of a vertex")?;
        }
        body.push_vertex(values, keyword);
    }
    for _ in 0..faces {
        let corners = scanner.count(2, "the number of corners")?;
        body.face.clear();
        for _ in 0..corners {
            body.face.push(scanner.index(0, vertices, "vertex")?);
        }
        body.push_face(None);
    }
    match scanner.word() {
        Some(word) => Err(scanner.error(format!("the end of the file is expected, found '{}'", shown(word)))),
        None => Ok(body),
    }
}

/// `OFF BINARY`: big-endian 32-bit integers and floats.
fn read_binary(source: &Source, start: usize, keyword: Keyword) -> Result<Body> {
    let mut cursor = Cursor::new(source, start, Endian::Big);
    let counts = [cursor.i32()?, cursor.i32()?, cursor.i32()?].map(i128::from);
    let width = keyword.width();
    let vertices = cursor.room_for(counts[0], 4 * width, "vertices")?;
    let mut body = Body::default();
    for _ in 0..vertices {
        let mut values = [0.0; WIDEST];
        for value in &mut values[..width] {
            *value = f64::from(cursor.f32()?);
        }
        body.push_vertex(&values[..width], keyword);
    }
    for _ in 0..cursor.room_for(counts[1], 8, "faces")? {
        let corners = i128::from(cursor.i32()?);
        body.face.clear();
        for _ in 0..cursor.room_for(corners, 4, "corners")? {
            let index = cursor.i32()?;
            match u32::try_from(index) {
                Ok(vertex) if (vertex as usize) < vertices => body.face.push(vertex),
                _ => {
                    return Err(
                        cursor.error(format!("vertex {index} does not exist, there are {vertices} (counted from 0)"))
                    );
                }
            }
        }
        let numbers = i128::from(cursor.i32()?);
        let numbers = cursor.room_for(numbers, 4, "colour components")?;
        let values: Vec<f64> = (0..numbers).map(|_| cursor.f32().map(f64::from)).collect::<Result<_>>()?;
        body.push_face(Color::new(&values));
    }
    Ok(body)
}

/// The colour on the rest of the line; `None` where something else stands there, such as an index into a colour map.
fn color_on_line(scanner: &mut Scanner) -> Option<Color> {
    let mut values = [0.0; 4];
    let mut count = 0;
    while let Some(word) = scanner.word_on_line() {
        *values.get_mut(count)? = parse_float(word)?;
        count += 1;
    }
    Color::new(&values[..count])
}

impl Body {
    /// `values` are at least the three coordinates.
    fn push_vertex(&mut self, values: &[f64], keyword: Keyword) {
        let [x, y, z, rest @ ..] = values else { return };
        self.mesh.points.push(DVec3::new(*x, *y, *z));
        let mut rest = rest;
        if let (true, [a, b, c, after @ ..]) = (keyword.normals, rest) {
            self.normals.push([*a, *b, *c]);
            rest = after;
        }
        if let (true, [before @ .., s, t]) = (keyword.uvs, rest) {
            self.uvs.push([*s, *t]);
            rest = before;
        }
        if keyword.colors {
            self.colors.push(Color::new(rest));
        } else if !rest.is_empty() {
            self.overlong += 1;
        }
    }

    /// The number of corners and the corners, all on one line.
    fn start_face(&mut self, scanner: &mut Scanner, vertices: usize) -> Result<()> {
        let corners = scanner.count(2, "the number of corners")?;
        self.face.clear();
        for k in 0..corners {
            let word = scanner
                .word_on_line()
                .ok_or_else(|| scanner.error(format!("a face with {corners} corners ends after {k} of them")))?;
            match parse_integer(word) {
                Some(v) if v >= 0 && (v as u64) < vertices as u64 => self.face.push(v as u32),
                _ => {
                    let what =
                        format!("vertex '{}' does not exist, there are {vertices} (counted from 0)", shown(word));
                    return Err(scanner.error(what));
                }
            }
        }
        Ok(())
    }

    fn push_face(&mut self, color: Option<Color>) {
        self.mesh.faces.push(&self.face);
        self.face_colors.push(color);
    }

    fn finish(self) -> Result<RawMesh> {
        let mut mesh = self.mesh;
        let vertices = mesh.points.len();
        if self.overlong > 0 {
            let what = "the keyword does not tell what the numbers behind the coordinates are: left out those of";
            mesh.notes.push(format!("{what} {} of {vertices} vertices", self.overlong));
        }
        if let Some(colors) = self.colors.finish(vertices, "vertices", &mut mesh.notes) {
            mesh.attributes.vertex.insert("color".into(), colors);
        }
        if let Some(colors) = self.face_colors.finish(mesh.faces.len(), "faces", &mut mesh.notes) {
            mesh.attributes.face.insert("color".into(), colors);
        }
        let columns = [
            ("normal", self.normals.len(), Column::Vector3(self.normals)),
            ("uv", self.uvs.len(), Column::Vector2(self.uvs)),
        ];
        for (name, count, column) in columns {
            if count == vertices && count > 0 {
                mesh.attributes.vertex.insert(name.into(), column);
            } else if count > 0 {
                mesh.notes.push(format!("left out '{name}': only {count} of {vertices} vertices have it"));
            }
        }
        drop_short_faces(&mut mesh);
        Ok(mesh)
    }
}

/// A colour as the file gives it: shares of 1 or of 255, with or without opacity.
#[derive(Clone, Copy)]
struct Color {
    rgb: [f64; 3],
    opacity: Option<f64>,
}

impl Color {
    fn new(values: &[f64]) -> Option<Self> {
        match *values {
            [r, g, b] => Some(Color { rgb: [r, g, b], opacity: None }),
            [r, g, b, a] => Some(Color { rgb: [r, g, b], opacity: Some(a) }),
            _ => None,
        }
    }

    fn values(&self) -> impl Iterator<Item = f64> {
        self.rgb.into_iter().chain(self.opacity)
    }
}

/// Colours of vertices or faces, kept while all have one.
#[derive(Default)]
struct Colors {
    values: Vec<Color>,
    without: usize,
}

impl Colors {
    fn push(&mut self, color: Option<Color>) {
        match color {
            Some(color) => self.values.push(color),
            None => self.without += 1,
        }
    }

    /// A colour with a value larger than 1 is in shares of 255, one with a fraction in shares of 1; one of only zeros
    /// and ones is what the others of the file are.
    fn finish(self, count: usize, what: &str, notes: &mut Vec<String>) -> Option<Column> {
        if self.without > 0 && !self.values.is_empty() {
            notes.push(format!("left out the colours: only {} of {count} {what} have one", self.values.len()));
        }
        if self.without > 0 || self.values.is_empty() {
            return None;
        }
        let in_bytes = |c: &Color| c.values().any(|x| x > 1.0);
        let in_shares = |c: &Color| c.values().any(|x| x > 0.0 && x < 1.0);
        let any_in_bytes = self.values.iter().any(in_bytes);
        let quantised = self.values.iter().map(|c| {
            let full = if in_bytes(c) || (any_in_bytes && !in_shares(c)) { 255.0 } else { 1.0 };
            // `as` saturates, which suits values out of range.
            let byte = |x: f64| (x / full * 255.0).round() as u8;
            let [r, g, b] = c.rgb.map(byte);
            [r, g, b, c.opacity.map_or(255, byte)]
        });
        Some(Column::Color(quantised.collect()))
    }
}

pub(super) fn write(mesh: &RawMesh, _: &WriteOptions, out: &mut Vec<u8>) -> Result<Vec<String>> {
    require_surface(mesh, "OFF")?;
    let columns = VertexColumns::of(mesh);
    for (part, there) in
        [("ST", columns.uvs.is_some()), ("C", columns.colors.is_some()), ("N", columns.normals.is_some())]
    {
        out.extend_from_slice(if there { part.as_bytes() } else { b"" });
    }
    out.extend_from_slice(b"OFF\n");
    push_integer(out, mesh.points.len());
    out.push(b' ');
    push_integer(out, mesh.faces.len());
    out.extend_from_slice(b" 0\n");
    for (k, point) in mesh.points.iter().enumerate() {
        let [x, y, z] = point.to_array();
        push_float(out, x);
        push_floats(out, &[y, z]);
        columns.push(k, out);
        out.push(b'\n');
    }
    let colors = color_column(mesh.attributes.face.get("color"));
    for (f, face) in mesh.faces.iter().enumerate() {
        push_integer(out, face.len());
        for &v in face {
            out.push(b' ');
            push_integer(out, v);
        }
        if let Some(colors) = colors {
            push_color(out, colors[f]);
        }
        out.push(b'\n');
    }
    Ok(warnings(mesh))
}

/// The columns that OFF holds.
struct VertexColumns<'a> {
    normals: Option<&'a [[f64; 3]]>,
    colors: Option<&'a [[u8; 4]]>,
    uvs: Option<&'a [[f64; 2]]>,
}

impl<'a> VertexColumns<'a> {
    fn of(mesh: &'a RawMesh) -> Self {
        let columns = &mesh.attributes.vertex;
        VertexColumns {
            normals: match columns.get("normal") {
                Some(Column::Vector3(normals)) => Some(normals),
                _ => None,
            },
            colors: color_column(columns.get("color")),
            uvs: match columns.get("uv") {
                Some(Column::Vector2(uvs)) => Some(uvs),
                _ => None,
            },
        }
    }

    /// Appends what vertex `k` has.
    fn push(&self, k: usize, out: &mut Vec<u8>) {
        if let Some(normals) = self.normals {
            push_floats(out, &normals[k]);
        }
        if let Some(colors) = self.colors {
            push_color(out, colors[k]);
        }
        if let Some(uvs) = self.uvs {
            push_floats(out, &uvs[k]);
        }
    }
}

fn color_column(column: Option<&Column>) -> Option<&[[u8; 4]]> {
    match column {
        Some(Column::Color(colors)) => Some(colors),
        _ => None,
    }
}

fn push_floats(out: &mut Vec<u8>, values: &[f64]) {
    for &x in values {
        out.push(b' ');
        push_float(out, x);
    }
}

/// Shares of 1, always with a point: readers take integers for shares of 255.
fn push_color(out: &mut Vec<u8>, color: [u8; 4]) {
    for c in color {
        out.push(b' ');
        out.extend_from_slice(ryu::Buffer::new().format_finite(f64::from(c) / 255.0).as_bytes());
    }
}

fn warnings(mesh: &RawMesh) -> Vec<String> {
    let columns = &mesh.attributes;
    let vertex = columns_left_out("OFF", "vertex", &columns.vertex, |name, column| {
        matches!(
            (name, column),
            ("normal", Column::Vector3(_)) | ("color", Column::Color(_)) | ("uv", Column::Vector2(_))
        )
    });
    let face = columns_left_out("OFF", "face", &columns.face, |name, column| {
        matches!((name, column), ("color", Column::Color(_)))
    });
    let corner = columns_left_out("OFF", "corner", &columns.corner, |_, _| false);
    [vertex, face, corner, edges_left_out("OFF", mesh)].into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::super::surface_tests::{error_of, faces_of, read_as};
    use super::*;

    const SQUARE: &str = "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n";

    fn read(text: impl AsRef<[u8]>) -> RawMesh {
        read_as("a.off", text).unwrap()
    }

    #[test]
    fn layout_does_not_matter() {
        let plain = read(SQUARE);
        assert_eq!(faces_of(&plain), [[0, 1, 2], [0, 2, 3]]);
        let body = &SQUARE[SQUARE.find("0 0 0").unwrap()..];
        for text in [
            SQUARE.replace('\n', "\r\n"),
            SQUARE.replace('\n', "\r"),
            SQUARE.replace('\n', " # comment\n\n"),
            SQUARE.replace(['\n', ' '], "\n"),
            SQUARE.replace('\n', " "),
            format!("\u{feff}off 4 2 0\n{body}"),
            format!("OFF4 2 0\n{body}"),
            format!("4 2 0\n{body}"),
            format!("OFF\n4 2\n{body}"),
            format!("OFF\n4\n2\n0\n{body}"),
            format!("OFF\n4 2\n7\n{body}"),
            "OFF\n4 2 0\n0 0 0 1 0 0\n1 1 0 0 1 0\n3 0 1\n2 3\n0 2 3".into(),
        ] {
            let mesh = read(&text);
            assert_eq!((&mesh.points, &mesh.faces), (&plain.points, &plain.faces), "{text:?}");
            assert!(mesh.notes.is_empty(), "{text:?}: {:?}", mesh.notes);
        }
    }

    #[test]
    fn the_keyword_tells_what_vertices_have() {
        let vertices = |keyword: &str, rest: &str| read(format!("{keyword}\n1 0 0\n1 2 3 {rest}\n")).attributes.vertex;
        let normal = Column::Vector3(vec![[0.0, 0.0, 1.0]]);
        let color = Column::Color(vec![[255, 0, 51, 255]]);
        let uv = Column::Vector2(vec![[0.25, 0.75]]);
        assert_eq!(vertices("NOFF", "0 0 1")["normal"], normal);
        assert_eq!(vertices("noff", "0 0 1")["normal"], normal);
        for values in ["1 0 0.2", "1.0 0.0 0.2 1.0", "255 0 51", "255 0 51 255"] {
            assert_eq!(vertices("COFF", values)["color"], color, "{values}");
            let all = vertices("STCNOFF", &format!("0 0 1 {values} .25 .75"));
            assert_eq!((&all["normal"], &all["color"], &all["uv"]), (&normal, &color, &uv));
        }
        assert_eq!(vertices("STOFF", ".25 .75")["uv"], uv);
        assert!(vertices("OFF", "1 0 0").is_empty());
    }

    #[test]
    fn columns_need_all_elements() {
        let mesh = read("CNOFF\n2 0 0\n0 0 0 0 0 1 1 0 0\n1 0 0\n");
        assert!(mesh.attributes.vertex.is_empty());
        assert_eq!(mesh.notes.len(), 2, "{:?}", mesh.notes);
        assert_eq!(read("OFF\n1 0 0\n0 0 0 1 2 3\n").notes.len(), 1);
    }

    #[test]
    fn colours_of_faces_in_shares_of_one_or_of_255() {
        let colors = |a: &str, b: &str| {
            let file =
                SQUARE.replace("3 0 1 2\n", &format!("3 0 1 2 {a}\n")).replace("3 0 2 3\n", &format!("3 0 2 3 {b}\n"));
            read(file).attributes.face.remove("color")
        };
        assert_eq!(colors("1 0 0", "0 .2 0 0"), Some(Column::Color(vec![[255, 0, 0, 255], [0, 51, 0, 0]])));
        assert_eq!(colors("1 0 0", "0 255 0 7"), Some(Column::Color(vec![[1, 0, 0, 255], [0, 255, 0, 7]])));
        assert_eq!(colors("0.2 0 0", "0 255 0"), Some(Column::Color(vec![[51, 0, 0, 255], [0, 255, 0, 255]])));
        for (a, b) in [("", "1 0 0"), ("7", "1 0 0"), ("red", "1 0 0"), ("", "")] {
            assert_eq!(colors(a, b), None);
        }
    }

    #[test]
    fn binary_files_with_colours() {
        let mut file = b"COFF BINARY\n".to_vec();
        let int = |file: &mut Vec<u8>, values: &[i32]| values.iter().for_each(|k| file.extend(k.to_be_bytes()));
        let float = |file: &mut Vec<u8>, values: &[f32]| values.iter().for_each(|x| file.extend(x.to_be_bytes()));
        int(&mut file, &[3, 2, 0]);
        for k in 0..3 {
            float(&mut file, &[k as f32, 0.1, 0.0, 1.0, 0.0, 0.0, 1.0]);
        }
        int(&mut file, &[3, 0, 1, 2, 3]);
        float(&mut file, &[0.0, 1.0, 0.0]);
        int(&mut file, &[3, 2, 1, 0, 4]);
        float(&mut file, &[0.0, 1.0, 0.0, 0.0]);
        let mesh = read(&file);
        assert_eq!(mesh.points[2], DVec3::new(2.0, f64::from(0.1f32), 0.0));
        assert_eq!(faces_of(&mesh), [[0, 1, 2], [2, 1, 0]]);
        assert_eq!(mesh.attributes.face["color"], Column::Color(vec![[0, 255, 0, 255], [0, 255, 0, 0]]));
        assert!(error_of("a.off", &file[..file.len() - 1]).contains("byte"));
        file[15] = 255;
        assert!(error_of("a.off", &file).contains("vertices are announced"));
    }

    #[test]
    fn short_faces_and_what_follows_are_left_out_and_noted() {
        let mesh = read("OFF\n3 3 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1 1 0 0\n3 0 1 2 0 1 0\n0 1 0 0\n3 0 1 2\n");
        assert_eq!(faces_of(&mesh), [[0, 1, 2]]);
        assert_eq!(mesh.attributes.face["color"], Column::Color(vec![[0, 255, 0, 255]]));
        assert_eq!(mesh.notes.len(), 2, "{:?}", mesh.notes);
        assert!(mesh.notes.iter().any(|n| n.contains("line 9")), "{:?}", mesh.notes);
    }

    #[test]
    fn what_is_wrong_is_told_with_its_line() {
        for (text, what) in [
            ("#\n".to_string(), "only comments"),
            ("ply\n".into(), "does not look like OFF"),
            ("OFFICE 1 2\n".into(), "does not look like OFF"),
            ("4OFF\n".into(), "'4OFF' has points with another number of coordinates"),
            ("nOFF\n3\n".into(), "'nOFF' has points"),
            (SQUARE.replace("4 2 0", "1000000000 2 0"), "line 2: the number of vertices is 1000000000"),
            (SQUARE.replace("4 2 0", "4 1000000000 0"), "line 2: the number of faces is 1000000000"),
            (SQUARE.replace("4 2 0", "4 -2 0"), "line 2: the number of faces is -2"),
            (SQUARE.replace("3 0 2 3", "3 0 2 4"), "line 8: vertex '4' does not exist"),
            (SQUARE.replace("3 0 2 3", "3 0 2 -1"), "line 8: vertex '-1' does not exist"),
            (SQUARE.replace("3 0 2 3", "3 0 2"), "line 8: a face with 3 corners ends after 2"),
            (SQUARE.replace("3 0 2 3", "999 0 2 3"), "line 8: the number of corners is 999"),
            (SQUARE.replace("1 1 0", "1 1"), "line 5: a vertex has only 2 of 3 coordinates"),
            (SQUARE.replace("1 1 0", "1 0,5 0"), "line 5: a number is expected, found '0,5'"),
            (SQUARE.replace("1 1 0", "1 1 inf"), "not finite"),
            (SQUARE[..SQUARE.len() - 8].into(), "the file ends"),
        ] {
            let message = error_of("a.off", &text);
            assert!(message.contains(what), "{text}: {message}");
        }
    }
}
