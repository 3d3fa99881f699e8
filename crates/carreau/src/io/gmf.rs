//! Medit binary files (`.meshb`), the Gamma Mesh Format: a chain of keywords, each with the position of the next.
//!
//! ```text
//! 1, version                                     two 32-bit integers; the first tells the byte order
//! 3, position of the next keyword, dimension     keyword Dimension
//! 4, position, count, count × (x y z reference)  keyword Vertices
//! 6, position, count, count × (a b c reference)  keyword Triangles …
//! 54, 0                                          keyword End
//! ```
//!
//! | version | coordinates | positions | counts, indices, references |
//! |---|---|---|---|
//! | 1 | 32 bits | 32 bits | 32 bits |
//! | 2 | 64 bits | 32 bits | 32 bits |
//! | 3 | 64 bits | 64 bits | 32 bits |
//! | 4 | 64 bits | 64 bits | 64 bits |
//!
//! Keywords, version and dimension always take 32 bits. Source: L. Maréchal, *Handling unstructured meshes with the
//! libMeshb library*. What becomes of which section is said in [`super::medit_sections`]. Files are written in little
//! endian and in version 2, or 3 or 4 where their size asks for it.

#[cfg(test)]
mod tests;

use super::binary::{Cursor, Endian};
use super::medit_keywords::Keyword;
use super::medit_sections::{Block, Contents, Numbers, Sections};
use super::source::{Source, WriteOptions};
use crate::error::{Error, Place, Result};
use crate::mesh::RawMesh;

/// Code of the keyword `Dimension`.
const DIMENSION: i32 = 3;
/// Code of the keyword `Vertices`.
const VERTICES: i32 = 4;
/// Code of the keyword `End`.
const END: i32 = 54;

/// Names of sections that are skipped.
const SKIPPED: [(i32, &str); 13] = [
    (17, "RequiredTriangles"),
    (18, "RequiredQuadrilaterals"),
    (19, "TangentAtEdgeVertices"),
    (20, "NormalAtVertices"),
    (21, "NormalAtTriangleVertices"),
    (22, "NormalAtQuadrilateralVertices"),
    (23, "AngleOfCornerBound"),
    (24, "TrianglesP2"),
    (50, "BoundingBox"),
    (59, "Tangents"),
    (60, "Normals"),
    (61, "TangentAtVertices"),
    (62, "SolAtVertices"),
];

/// The versions of the format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Version {
    V1 = 1,
    V2,
    V3,
    V4,
}

impl Version {
    fn of(number: i32) -> Option<Version> {
        [Version::V1, Version::V2, Version::V3, Version::V4].into_iter().find(|&v| v as i32 == number)
    }

    /// Bytes of a coordinate.
    fn real(self) -> usize {
        if self == Version::V1 { 4 } else { 8 }
    }

    /// Bytes of a position in the file.
    fn position(self) -> usize {
        if self < Version::V3 { 4 } else { 8 }
    }

    /// Bytes of a count, an index, a reference.
    fn whole(self) -> usize {
        if self < Version::V4 { 4 } else { 8 }
    }
}

/// The file at the current number, read as its version asks.
struct Reader<'a> {
    cursor: Cursor<'a>,
    version: Version,
}

pub(super) fn read(source: &Source) -> Result<RawMesh> {
    let mut reader = Reader::open(source)?;
    let whole = reader.version.whole();
    let contents = reader.read_sections(source.bytes.len())?;
    contents.into_mesh(source, |start, number| Place::Byte((start + whole * number) as u64))
}

impl<'a> Reader<'a> {
    fn open(source: &'a Source<'a>) -> Result<Self> {
        let endian = match source.bytes.first_chunk() {
            Some([1, 0, 0, 0]) => Endian::Little,
            Some([0, 0, 0, 1]) => Endian::Big,
            _ => return Err(source.error(Place::Byte(0), "the number 1 is expected at the start of a .meshb file")),
        };
        let mut cursor = Cursor::new(source, 4, endian);
        let number = cursor.i32()?;
        let version = Version::of(number)
            .ok_or_else(|| source.error(Place::Byte(4), format!("version {number} is not one of 1 to 4")))?;
        Ok(Reader { cursor, version })
    }

    fn read_sections(&mut self, file_size: usize) -> Result<Contents> {
        let mut contents = Contents::default();
        let mut dimension = 3;
        while self.cursor.remaining() >= 4 {
            let code = self.cursor.i32()?;
            if code == END {
                contents.ended = true;
                break;
            }
            let next = self.next_keyword(code, file_size)?;
            if code == DIMENSION {
                dimension = self.dimension()?;
            } else if code == VERTICES {
                let count = self.count(dimension * self.version.real() + self.version.whole(), "vertices")?;
                contents.read_vertices(self, dimension, count)?;
            } else if let Some(keyword) = Keyword::coded(code) {
                let count = self.count(keyword.width() * self.version.whole(), keyword.name())?;
                let start = self.cursor.position;
                contents.read_section(self, keyword, start, count)?;
            } else {
                contents.skipped.push(name_of(code));
            }
            if self.cursor.position > next {
                return Err(self
                    .cursor
                    .error(format!("{} ends here, but the next section is announced at byte {next}", name_of(code))));
            }
            self.cursor.position = next;
        }
        Ok(contents)
    }

    /// Where the next keyword is; the end of the file after the last one. It must lie ahead, so that the chain ends.
    fn next_keyword(&mut self, code: i32, file_size: usize) -> Result<usize> {
        let next = if self.version.position() == 4 { i64::from(self.cursor.i32()?) } else { self.cursor.i64()? };
        match usize::try_from(next) {
            Ok(0) => Ok(file_size),
            Ok(next) if next >= self.cursor.position && next <= file_size => Ok(next),
            _ => Err(self.cursor.error(format!(
                "{} points to byte {next}, which does not lie between here and the end of the file ({file_size} bytes)",
                name_of(code)
            ))),
        }
    }

    fn dimension(&mut self) -> Result<usize> {
        match self.cursor.i32()? {
            2 => Ok(2),
            3 => Ok(3),
            other => Err(self.cursor.error(format!("the dimension is {other}, only 2 and 3 are known"))),
        }
    }

    /// The number of rows of `size` bytes that follow.
    fn count(&mut self, size: usize, what: &str) -> Result<usize> {
        let count = self.whole()?;
        self.cursor.room_for(i128::from(count), size, what)
    }

    #[inline]
    fn whole(&mut self) -> Result<i64> {
        if self.version.whole() == 4 { self.cursor.i32().map(i64::from) } else { self.cursor.i64() }
    }
}

impl Numbers for Reader<'_> {
    #[inline]
    fn index(&mut self) -> Result<i64> {
        self.whole()
    }

    #[inline]
    fn reference(&mut self) -> Result<i64> {
        self.whole()
    }

    #[inline]
    fn coordinate(&mut self) -> Result<f64> {
        if self.version.real() == 4 { self.cursor.f32().map(f64::from) } else { self.cursor.f64() }
    }

    fn error(&self, what: String) -> Error {
        self.cursor.error(what)
    }
}

fn name_of(code: i32) -> String {
    let others = [(DIMENSION, "Dimension"), (VERTICES, "Vertices")];
    let other = others.iter().chain(&SKIPPED).find(|(c, _)| *c == code).map(|(_, name)| *name);
    let known = Keyword::coded(code).map(Keyword::name).or(other);
    known.map_or_else(|| format!("keyword {code}"), str::to_string)
}

pub(super) fn write(mesh: &RawMesh, _options: &WriteOptions, out: &mut Vec<u8>) -> Result<Vec<String>> {
    let sections = Sections::of(mesh);
    let version = version_for(&sections);
    write_version(&sections, version, out);
    Ok(sections.warnings)
}

fn version_for(sections: &Sections) -> Version {
    let largest_count = sections.blocks.iter().map(Block::len).max().unwrap_or(0).max(sections.vertex_count());
    smallest_version(largest_count, file_size(sections, Version::V2))
}

/// The first version that can hold the largest count (and so every index) and the positions. Version 1 apart: it would
/// round the coordinates.
fn smallest_version(largest_count: usize, size_in_version_2: usize) -> Version {
    let fits = |number: usize| i32::try_from(number).is_ok();
    match (fits(largest_count), fits(size_in_version_2)) {
        (true, true) => Version::V2,
        (true, false) => Version::V3,
        (false, _) => Version::V4,
    }
}

fn file_size(sections: &Sections, version: Version) -> usize {
    let keyword = 4 + version.position();
    let rows = |block: &Block| keyword + version.whole() * (1 + block.len() * block.keyword.width());
    let vertices = keyword + version.whole() + sections.vertex_count() * (3 * version.real() + version.whole());
    8 + (keyword + 4) + vertices + sections.blocks.iter().map(rows).sum::<usize>() + keyword
}

fn write_version(sections: &Sections, version: Version, out: &mut Vec<u8>) {
    let mut writer = Writer { version, start: out.len(), out };
    writer.out.reserve(file_size(sections, version));
    writer.push_i32(1);
    writer.push_i32(version as i32);
    writer.push_keyword(DIMENSION, 4);
    writer.push_i32(3);
    let row = 3 * version.real() + version.whole();
    writer.push_keyword(VERTICES, version.whole() + sections.vertex_count() * row);
    writer.push_whole(sections.vertex_count() as i64);
    for (point, reference) in sections.vertices() {
        point.to_array().into_iter().for_each(|x| writer.push_real(x));
        writer.push_whole(i64::from(reference));
    }
    for block in &sections.blocks {
        writer.push_keyword(block.keyword.code, version.whole() * (1 + block.len() * block.keyword.width()));
        writer.push_whole(block.len() as i64);
        for (indices, reference) in block.rows() {
            indices.iter().for_each(|&index| writer.push_whole(i64::from(index) + 1));
            reference.into_iter().for_each(|reference| writer.push_whole(i64::from(reference)));
        }
    }
    writer.push_i32(END);
    writer.push_position(0);
}

/// Appends numbers in little endian, as long as the version asks.
struct Writer<'a> {
    version: Version,
    /// Where the file starts in `out`.
    start: usize,
    out: &'a mut Vec<u8>,
}

impl Writer<'_> {
    /// A keyword that is followed by `size` bytes.
    fn push_keyword(&mut self, code: i32, size: usize) {
        self.push_i32(code);
        let next = self.out.len() - self.start + self.version.position() + size;
        self.push_position(next as i64);
    }

    fn push_position(&mut self, position: i64) {
        self.push_sized(position, self.version.position());
    }

    fn push_whole(&mut self, number: i64) {
        self.push_sized(number, self.version.whole());
    }

    /// The low bytes of a number: the version has been chosen so that no others are needed.
    fn push_sized(&mut self, number: i64, size: usize) {
        if size == 4 { self.push_i32(number as i32) } else { self.out.extend_from_slice(&number.to_le_bytes()) }
    }

    fn push_i32(&mut self, number: i32) {
        self.out.extend_from_slice(&number.to_le_bytes());
    }

    fn push_real(&mut self, x: f64) {
        if self.version.real() == 4 {
            self.out.extend_from_slice(&(x as f32).to_le_bytes());
        } else {
            self.out.extend_from_slice(&x.to_le_bytes());
        }
    }
}
