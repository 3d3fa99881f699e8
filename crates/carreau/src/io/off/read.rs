//! The reader.
//!
//! Nearly all files have one vertex or face a line, and many have more on those lines than the keyword tells;
//! therefore a text file is read line by line first, and as a stream of numbers only where that fails.

use super::super::binary::{Cursor, Endian};
use super::super::limits::drop_short_faces;
use super::super::source::Source;
use super::super::text::{Scanner, parse_float, parse_integer, shown};
use super::color::{Color, Colors};
use crate::error::Result;
use crate::mesh::{Column, RawMesh};
use glam::DVec3;

/// Most numbers a vertex can have: position, normal, colour with opacity, texture coordinates.
const WIDEST: usize = 3 + 3 + 4 + 2;

pub fn read(source: &Source) -> Result<RawMesh> {
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
