//! The sections of a Gmsh file and the numbers in them, be they text or binary.
//!
//! Headings, their ends and a few counts are text in both forms:
//!
//! ```text
//! $MeshFormat
//! 4.1 1 8            version, 0 text or 1 binary, bytes of a size_t (of a double in version 2)
//! <the integer 1>    only in binary files: tells the byte order
//! $EndMeshFormat
//! ```

use crate::error::{Error, Place, Result};
use crate::io::binary::{Cursor, Endian};
use crate::io::source::Source;
use crate::io::text::{Scanner, parse_float, parse_integer, shown};

/// The file at its current position.
pub(super) struct Stream<'a> {
    source: &'a Source<'a>,
    form: Form<'a>,
}

// One per file: its size does not matter.
#[allow(clippy::large_enum_variant)]
enum Form<'a> {
    Text(Scanner<'a>),
    /// With `long`, a size_t has 8 bytes, else 4.
    Binary {
        cursor: Cursor<'a>,
        long: bool,
    },
}

impl<'a> Stream<'a> {
    /// Reads the section `$MeshFormat`; returns the version as written.
    pub fn open(source: &'a Source<'a>) -> Result<(Self, &'a [u8])> {
        let mut stream = Stream { source, form: Form::Text(Scanner::new(source, None)) };
        loop {
            match stream.heading()? {
                Some(b"MeshFormat") => break,
                Some(b"Comments") => stream.skip(b"Comments")?,
                _ => return Err(stream.error("$MeshFormat is expected at the start of a .msh file")),
            }
        }
        let version = stream.word().unwrap_or_default();
        if parse_float(version).is_none() {
            return Err(stream.error(format!("the version of the format is expected, found '{}'", shown(version))));
        }
        let file_type = stream.int("the type of the file (0 text, 1 binary)")?;
        let size = stream.int("the size of numbers")?;
        match file_type {
            0 => {}
            1 => stream.form = binary_form(source, line_after(source, *stream.position()), size)?,
            other => {
                return Err(stream.error(format!("the type of the file is {other}, neither 0 (text) nor 1 (binary)")));
            }
        }
        stream.close(b"MeshFormat")?;
        Ok((stream, version))
    }

    /// An error here.
    pub fn error(&self, what: impl Into<String>) -> Error {
        match &self.form {
            Form::Text(text) => text.error(what),
            Form::Binary { cursor, .. } => cursor.error(what),
        }
    }

    /// The name of the next section; `None` at the end of the file.
    pub fn heading(&mut self) -> Result<Option<&'a [u8]>> {
        match self.word() {
            None => Ok(None),
            Some([b'$', name @ ..]) if !name.is_empty() => {
                self.start_numbers();
                Ok(Some(name))
            }
            Some(other) => {
                Err(self.error(format!("the heading of a section ($…) is expected, found '{}'", shown(other))))
            }
        }
    }

    /// The end of a section must come next.
    pub fn close(&mut self, name: &[u8]) -> Result<()> {
        match self.word() {
            Some(word) if word.strip_prefix(b"$End") == Some(name) => Ok(()),
            Some(word) => Err(self.error(format!("$End{} is expected, found '{}'", shown(name), shown(word)))),
            None => Err(self.error(format!("the file ends before $End{}", shown(name)))),
        }
    }

    /// Moves past the end of a section.
    pub fn skip(&mut self, name: &[u8]) -> Result<()> {
        let end = [b"$End", name].concat();
        let found = match &mut self.form {
            Form::Text(text) => loop {
                match text.word() {
                    Some(word) if word == end => break true,
                    Some(_) => _ = text.next_line(),
                    None => break false,
                }
            },
            Form::Binary { cursor, .. } => {
                let rest = self.source.bytes.get(cursor.position..).unwrap_or_default();
                let found = rest.windows(end.len()).position(|w| w == end);
                cursor.position += found.map_or(0, |k| k + end.len());
                found.is_some()
            }
        };
        if found { Ok(()) } else { Err(self.error(format!("the section ${} has no end", shown(name)))) }
    }

    /// An integer given as text on its own line, in binary files too.
    pub fn text_integer(&mut self, what: &str) -> Result<i64> {
        if let Form::Text(text) = &mut self.form {
            return text.integer(what);
        }
        let line = self.line(what)?;
        let number = parse_integer(line);
        let number = number.ok_or_else(|| self.error(format!("{what} is expected, found '{}'", shown(line))))?;
        self.start_numbers();
        Ok(number)
    }

    /// The next line that is not blank, without blanks around it and without its end.
    pub fn line(&mut self, what: &str) -> Result<&'a [u8]> {
        let Some(word) = self.word() else {
            return Err(self.error(format!("the file ends where {what} is expected")));
        };
        let position = self.position();
        let start = *position - word.len();
        let rest = self.source.bytes.get(start..).unwrap_or_default();
        let length = rest.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(rest.len());
        *self.position() = start + length;
        Ok(rest.get(..length).unwrap_or_default().trim_ascii())
    }

    /// The numbers of a binary section start right behind the line.
    fn start_numbers(&mut self) {
        if let Form::Binary { cursor, .. } = &mut self.form {
            cursor.position = line_after(self.source, cursor.position);
        }
    }

    fn position(&mut self) -> &mut usize {
        match &mut self.form {
            Form::Text(text) => &mut text.position,
            Form::Binary { cursor, .. } => &mut cursor.position,
        }
    }

    fn word(&mut self) -> Option<&'a [u8]> {
        let bytes = self.source.bytes;
        match &mut self.form {
            Form::Text(text) => text.word(),
            Form::Binary { cursor, .. } => {
                let blanks = bytes.get(cursor.position..)?.iter().take_while(|b| b.is_ascii_whitespace()).count();
                cursor.position += blanks;
                let rest = bytes.get(cursor.position..)?;
                let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
                cursor.position += length;
                rest.get(..length).filter(|word| !word.is_empty())
            }
        }
    }

    /// A C int.
    #[inline]
    pub fn int(&mut self, what: &str) -> Result<i32> {
        match &mut self.form {
            Form::Text(text) => {
                let number = text.integer(what)?;
                i32::try_from(number).map_err(|_| text.error(format!("{what} {number} does not fit 32 bits")))
            }
            Form::Binary { cursor, .. } => cursor.i32(),
        }
    }

    /// A C size_t.
    #[inline]
    pub fn size(&mut self, what: &str) -> Result<u64> {
        match &mut self.form {
            Form::Text(text) => {
                let number = text.integer(what)?;
                u64::try_from(number).map_err(|_| text.error(format!("{what} is {number}, it cannot be negative")))
            }
            Form::Binary { cursor, long: true } => cursor.u64(),
            Form::Binary { cursor, long: false } => cursor.u32().map(u64::from),
        }
    }

    /// A double.
    #[inline]
    pub fn double(&mut self, what: &str) -> Result<f64> {
        match &mut self.form {
            Form::Text(text) => text.float(what),
            Form::Binary { cursor, .. } => cursor.f64(),
        }
    }

    /// Checks that `count` rows can follow; returns `count` as an array length.
    pub fn room_for(&self, count: i128, row: Row, what: &str) -> Result<usize> {
        let (room, size) = match &self.form {
            // A number takes a digit and a blank, but the last one needs no blank.
            Form::Text(text) => (text.remaining() + 1, 2 * (row.ints + row.sizes + row.doubles)),
            Form::Binary { cursor, long } => {
                (cursor.remaining(), 4 * row.ints + if *long { 8 } else { 4 } * row.sizes + 8 * row.doubles)
            }
        };
        if count >= 0 && count <= (room / size.max(1)) as i128 {
            return Ok(count as usize);
        }
        Err(self.error(format!("{count} {what} are announced, the rest of the file is too short for them")))
    }

    /// Whether the file is binary.
    pub fn is_binary(&self) -> bool {
        matches!(self.form, Form::Binary { .. })
    }

    /// Whether the header says 4 and not 8 in a binary file.
    pub fn is_short(&self) -> bool {
        matches!(self.form, Form::Binary { long: false, .. })
    }
}

/// The numbers of a row, by type.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Row {
    pub ints: usize,
    pub sizes: usize,
    pub doubles: usize,
}

/// Where the next line starts.
fn line_after(source: &Source, position: usize) -> usize {
    let rest = source.bytes.get(position..).unwrap_or_default();
    position + rest.iter().position(|&b| b == b'\n').map_or(rest.len(), |k| k + 1)
}

/// The integer 1 tells the byte order.
fn binary_form<'a>(source: &'a Source<'a>, start: usize, size: i32) -> Result<Form<'a>> {
    let long = match size {
        4 => false,
        8 => true,
        other => return Err(source.error(Place::Byte(start as u64), format!("numbers of {other} bytes are not known"))),
    };
    let mut cursor = Cursor::new(source, start, Endian::Little);
    match cursor.take(4)? {
        [1, 0, 0, 0] => {}
        [0, 0, 0, 1] => cursor.endian = Endian::Big,
        _ => {
            return Err(
                source.error(Place::Byte(start as u64), "the binary number 1 is expected, which tells the byte order")
            );
        }
    }
    Ok(Form::Binary { cursor, long })
}
