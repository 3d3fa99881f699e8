//! The values behind the header, into one table for each element.

use super::super::binary::Cursor;
use super::super::text::{Scanner, parse_float, parse_integer, shown};
use super::header::{Element, Property, Type};
use crate::error::{Error, Result};
use crate::mesh::Polygons;
use std::fmt::Display;

/// The values of one property.
pub enum Values {
    /// Of an integer type.
    Integers(Vec<i64>),
    /// Of a floating-point type.
    Floats(Vec<f64>),
    /// Lists of vertices.
    Faces(Polygons),
    /// The triangles of strips: lists of vertices in which negative numbers begin a new strip.
    Strips(Polygons),
    /// Not kept.
    Skipped,
}

/// What is kept of the rows of an element: one entry for each property.
pub type Table = Vec<(String, Values)>;

/// A stream of values, text or binary.
pub trait Body {
    /// The next value, of an integer type. Unsigned ones above the signed range become its largest.
    fn integer(&mut self, kind: Type) -> Result<i64>;
    /// The next value, of any type.
    fn float(&mut self, kind: Type) -> Result<f64>;
    /// Passes over values.
    fn skip(&mut self, kind: Type, count: usize) -> Result<()>;
    /// Fewest bytes that a value takes.
    fn size(kind: Type) -> usize;
    /// Number of bytes left.
    fn remaining(&self) -> usize;
    /// An error at the current place.
    fn error(&self, what: String) -> Error;
    /// Where the file goes on, if it does.
    fn rest(&self) -> Option<String>;

    /// Checks that the rest of the file can hold a number of values or rows.
    #[inline]
    fn room_for(&self, count: u64, size: usize, what: impl Display) -> Result<usize> {
        if count <= (self.remaining() / size.max(1)) as u64 {
            return Ok(count as usize);
        }
        Err(self.error(format!("{count} {what} are announced, the rest of the file is {} bytes", self.remaining())))
    }

    /// The id of a vertex, which must be below `vertices`.
    #[inline]
    fn vertex(&self, index: i64, vertices: u64) -> Result<u32> {
        match u32::try_from(index) {
            Ok(vertex) if u64::from(vertex) < vertices => Ok(vertex),
            _ => Err(self.error(format!("there is no vertex {index}, the file has {vertices} (counted from 0)"))),
        }
    }
}

impl Body for Cursor<'_> {
    #[inline]
    fn integer(&mut self, kind: Type) -> Result<i64> {
        Ok(match kind {
            Type::I8 => self.i8()?.into(),
            Type::U8 => self.u8()?.into(),
            Type::I16 => self.i16()?.into(),
            Type::U16 => self.u16()?.into(),
            Type::I32 => self.i32()?.into(),
            Type::U32 => self.u32()?.into(),
            Type::I64 => self.i64()?,
            Type::U64 => i64::try_from(self.u64()?).unwrap_or(i64::MAX),
            // `as` saturates.
            Type::F32 | Type::F64 => self.float(kind)? as i64,
        })
    }

    #[inline]
    fn float(&mut self, kind: Type) -> Result<f64> {
        Ok(match kind {
            Type::F32 => self.f32()?.into(),
            Type::F64 => self.f64()?,
            _ => self.integer(kind)? as f64,
        })
    }

    fn skip(&mut self, kind: Type, count: usize) -> Result<()> {
        self.take(count.saturating_mul(kind.size())).map(|_| ())
    }

    fn size(kind: Type) -> usize {
        kind.size()
    }

    fn remaining(&self) -> usize {
        self.remaining()
    }

    fn error(&self, what: String) -> Error {
        self.error(what)
    }

    fn rest(&self) -> Option<String> {
        (self.remaining() > 0).then(|| format!("{} bytes", self.remaining()))
    }
}

impl Body for Scanner<'_> {
    #[inline]
    fn integer(&mut self, _: Type) -> Result<i64> {
        let word = next_value(self)?;
        // Some writers give integers a fraction: 255.0.
        let whole = || parse_float(word).filter(|x| x.fract() == 0.0 && x.abs() < 9e15).map(|x| x as i64);
        parse_integer(word)
            .or_else(whole)
            .ok_or_else(|| self.error(format!("an integer is expected, found '{}'", shown(word))))
    }

    #[inline]
    fn float(&mut self, _: Type) -> Result<f64> {
        let word = next_value(self)?;
        parse_float(word).ok_or_else(|| self.error(format!("a number is expected, found '{}'", shown(word))))
    }

    fn skip(&mut self, _: Type, count: usize) -> Result<()> {
        (0..count).try_for_each(|_| next_value(self).map(|_| ()))
    }

    fn size(_: Type) -> usize {
        2
    }

    fn remaining(&self) -> usize {
        // The last value needs no blank behind it.
        self.remaining() + 1
    }

    fn error(&self, what: String) -> Error {
        self.error(what)
    }

    fn rest(&self) -> Option<String> {
        let mut ahead = self.clone();
        ahead.word().map(|_| format!("what follows from line {}", ahead.line_number()))
    }
}

/// The next word. Some files have comments among the values.
#[inline]
fn next_value<'a>(scanner: &mut Scanner<'a>) -> Result<&'a [u8]> {
    loop {
        match scanner.expect_word("a value")? {
            b"comment" => scanner.next_line(),
            word => return Ok(word),
        };
    }
}

/// Reads all rows of an element; indices of vertices must be below `vertices`.
pub fn read_table<B: Body>(body: &mut B, element: &Element, vertices: u64) -> Result<Table> {
    let smallest = element.properties.iter().map(|p| B::size(p.list.unwrap_or(p.kind))).sum();
    if smallest == 0 {
        return Ok(Table::new());
    }
    let count = body.room_for(element.count, smallest, format_args!("rows of element '{}'", element.name))?;
    let mut table: Table =
        element.properties.iter().map(|p| (p.name.clone(), empty_values(element, p, count))).collect();
    for (property, (_, values)) in element.properties.iter().zip(&mut table) {
        if let Values::Faces(faces) = values {
            faces.reserve(count, body.remaining().div_ceil(B::size(property.kind)).min(3 * count));
        }
    }
    let mut corners = Vec::new();
    for _ in 0..count {
        for (property, (_, values)) in element.properties.iter().zip(&mut table) {
            match values {
                Values::Integers(values) => values.push(body.integer(property.kind)?),
                Values::Floats(values) => values.push(body.float(property.kind)?),
                Values::Faces(faces) => {
                    read_face(body, property, vertices, &mut corners)?;
                    faces.push(&corners);
                }
                Values::Strips(triangles) => read_strips(body, property, vertices, triangles)?,
                Values::Skipped => {
                    let length = if property.list.is_some() { read_length(body, property)? } else { 1 };
                    body.skip(property.kind, length)?;
                }
            }
        }
    }
    Ok(table)
}

/// Room for the values of a property, of the kind in which they are kept.
fn empty_values(element: &Element, property: &Property, count: usize) -> Values {
    let has = |name: &str| element.properties.iter().any(|p| p.name == name && p.list.is_some());
    match (element.name.as_str(), property.list.is_some(), property.name.as_str()) {
        ("vertex" | "face" | "edge", false, _) if property.kind.is_float() => Values::Floats(Vec::with_capacity(count)),
        ("vertex" | "face" | "edge", false, _) => Values::Integers(Vec::with_capacity(count)),
        ("face", true, "vertex_indices") => Values::Faces(Polygons::new()),
        ("face", true, "vertex_index") if !has("vertex_indices") => Values::Faces(Polygons::new()),
        ("tristrips", true, name)
            if element.properties.iter().find(|p| p.list.is_some()).is_some_and(|p| p.name == name) =>
        {
            Values::Strips(Polygons::new())
        }
        _ => Values::Skipped,
    }
}

/// The number of values of a list, checked against the rest of the file.
fn read_length<B: Body>(body: &mut B, property: &Property) -> Result<usize> {
    let length = body.integer(property.list.unwrap_or(Type::U8))?;
    match u64::try_from(length) {
        Ok(length) => body.room_for(length, B::size(property.kind), format_args!("values of '{}'", property.name)),
        Err(_) => Err(body.error(format!("'{}' has {length} values", property.name))),
    }
}

/// The corners of a face.
fn read_face<B: Body>(body: &mut B, property: &Property, vertices: u64, corners: &mut Vec<u32>) -> Result<()> {
    corners.clear();
    for _ in 0..read_length(body, property)? {
        let index = body.integer(property.kind)?;
        corners.push(body.vertex(index, vertices)?);
    }
    Ok(())
}

/// The triangles of strips, every second one turned, without those that use a vertex twice.
///
/// ```text
/// 1───3───5
/// │ ╲ │ ╲ │     0 1 2 3 4 5: (0,1,2) (2,1,3) (2,3,4) (4,3,5)
/// 0───2───4
/// ```
fn read_strips<B: Body>(body: &mut B, property: &Property, vertices: u64, triangles: &mut Polygons) -> Result<()> {
    let mut last = [None, None];
    let mut turned = false;
    for _ in 0..read_length(body, property)? {
        let index = body.integer(property.kind)?;
        if index < 0 {
            (last, turned) = ([None, None], false);
            continue;
        }
        let c = body.vertex(index, vertices)?;
        if let [Some(a), Some(b)] = last {
            if a != b && b != c && a != c {
                triangles.push(&if turned { [b, a, c] } else { [a, b, c] });
            }
            turned = !turned;
        }
        last = [last[1], Some(c)];
    }
    Ok(())
}
