//! Words and numbers of a file, one after the other.

use crate::error::{Error, Place, Result};
use crate::io::binary::{Cursor, Endian};
use crate::io::source::Source;
use crate::io::text::{Scanner, parse_integer, shown};
use crate::io::vtk_arrays::{Array, NumberType, Values};

/// A list of cells.
pub struct Block {
    pub(super) ends: Vec<usize>,
    pub(super) corners: Vec<u32>,
    pub(super) place: Place,
}

/// The words of a keyword line and where it is.
pub struct Line<'a> {
    pub(super) words: Vec<&'a [u8]>,
    pub(super) place: Place,
}

impl<'a> Line<'a> {
    /// The first word in capitals.
    pub(super) fn keyword(&self) -> String {
        self.words.first().map(|w| shown(w).to_ascii_uppercase()).unwrap_or_default()
    }

    pub(super) fn word(&self, k: usize) -> Option<&'a [u8]> {
        self.words.get(k).copied()
    }
}

/// Walks through the file line by line and block by block.
pub struct Walker<'a> {
    pub(super) source: &'a Source<'a>,
    pub(super) text: Scanner<'a>,
    pub(super) binary: bool,
}

impl<'a> Walker<'a> {
    /// Reads the head: the signature, a title, and ASCII or BINARY.
    pub(super) fn open(source: &'a Source<'a>) -> Result<Self> {
        let signature = b"# vtk DataFile";
        if !source.bytes.get(..signature.len()).is_some_and(|head| head.eq_ignore_ascii_case(signature)) {
            return Err(source.error(Place::Line(1), "a legacy VTK file starts with '# vtk DataFile Version'"));
        }
        let mut file = Walker { source, text: Scanner::new(source, None), binary: false };
        file.text.next_line();
        file.text.next_line();
        let mode = file.line().filter(|line| line.words.len() == 1);
        file.binary = match mode.map(|line| line.keyword()).as_deref() {
            Some("ASCII") => false,
            Some("BINARY") => true,
            _ => return Err(file.text.error("ASCII or BINARY is expected in the third line")),
        };
        Ok(file)
    }

    pub(super) fn place(&self) -> Place {
        if self.binary { Place::Byte(self.text.position as u64) } else { Place::Line(self.text.line_number()) }
    }

    pub(super) fn error(&self, line: &Line, what: impl Into<String>) -> Error {
        self.source.error(line.place, what)
    }

    /// The next line that is not blank; METADATA blocks, which end with a blank line, are passed over.
    pub(super) fn line(&mut self) -> Option<Line<'a>> {
        loop {
            let place = self.place();
            let words = self.words();
            let more = self.text.next_line();
            if words.first().is_some_and(|w| w.eq_ignore_ascii_case(b"METADATA")) {
                while !self.words().is_empty() && self.text.next_line() {}
            } else if !words.is_empty() {
                return Some(Line { words, place });
            }
            if !more {
                return None;
            }
        }
    }

    pub(super) fn words(&mut self) -> Vec<&'a [u8]> {
        std::iter::from_fn(|| self.text.word_on_line()).collect()
    }

    /// Whether the next word is this one.
    pub(super) fn comes(&mut self, word: &[u8]) -> bool {
        self.text.peek().is_some_and(|w| w.eq_ignore_ascii_case(word))
    }

    /// Word `k` of a line as a count.
    pub(super) fn count(&self, line: &Line, k: usize) -> Result<usize> {
        let word = line.word(k).unwrap_or_default();
        parse_integer(word).and_then(|n| usize::try_from(n).ok()).ok_or_else(|| {
            self.error(line, format!("a count is expected after {}, found '{}'", line.keyword(), shown(word)))
        })
    }

    /// Word `k` of a line as the width of an array.
    pub(super) fn width(&self, line: &Line, k: usize) -> Result<usize> {
        let width = self.count(line, k)?;
        if width > 0 { Ok(width) } else { Err(self.error(line, "an array without components")) }
    }

    /// `rows × width` values of the type named by word `k` of the line; the text types have no values.
    pub(super) fn array(&mut self, line: &Line, rows: usize, width: usize, k: usize) -> Result<Option<Array>> {
        let of_type = line.word(k).map(|w| w.to_ascii_lowercase()).unwrap_or_default();
        let n = rows
            .checked_mul(width)
            .ok_or_else(|| self.error(line, format!("{rows} × {width} values are announced")))?;
        if let b"string" | b"utf8_string" | b"unicode_string" = of_type.as_slice() {
            self.skip_strings(line, n)?;
            return Ok(None);
        }
        let values = if of_type == b"bit" { self.bits(line, n)? } else { self.values(line, n, number_type(&of_type))? };
        Ok(Some(Array { values, width }))
    }

    pub(super) fn values(&mut self, line: &Line, n: usize, of_type: Option<NumberType>) -> Result<Values> {
        let Some(of_type) = of_type else {
            return Err(self.error(line, format!("the values after {} are of an unknown type", line.keyword())));
        };
        if self.binary {
            let bytes = self.take(line, n, of_type.size())?;
            return Ok(of_type.decode(bytes, Endian::Big));
        }
        self.room_for_words(line, n)?;
        let mut values = of_type.empty();
        for _ in 0..n {
            let word = self.text.expect_word("a number")?;
            if values.push_word(word).is_none() {
                return Err(self.text.error(format!("'{}' is not a number of the announced type", shown(word))));
            }
        }
        Ok(values)
    }

    /// `n` records of `size` bytes.
    pub(super) fn take(&mut self, line: &Line, n: usize, size: usize) -> Result<&'a [u8]> {
        let mut cursor = Cursor::new(self.source, self.text.position, Endian::Big);
        let n = cursor.room_for(n as i128, size, &format!("values of {}", line.keyword()))?;
        let bytes = cursor.take(n * size)?;
        self.text.position = cursor.position;
        Ok(bytes)
    }

    pub(super) fn room_for_words(&self, line: &Line, n: usize) -> Result<()> {
        // The last word needs no blank after it.
        if n <= self.text.remaining().div_ceil(2) {
            return Ok(());
        }
        Err(self
            .error(line, format!("{n} values are announced, the rest of the file is {} bytes", self.text.remaining())))
    }

    /// Bits: eight to a byte in binary files, the highest first.
    pub(super) fn bits(&mut self, line: &Line, n: usize) -> Result<Values> {
        if !self.binary {
            return self.values(line, n, Some(NumberType::U8));
        }
        let bytes = self.take(line, n.div_ceil(8), 1)?;
        Ok(Values::Bytes((0..n).map(|k| bytes[k / 8] >> (7 - k % 8) & 1).collect()))
    }

    /// Texts: one to a line, in binary files after their length. The highest two bits of the first byte tell in how many
    /// bytes the length is: 3: one, 2: two, 1: four, 0: eight.
    pub(super) fn skip_strings(&mut self, line: &Line, n: usize) -> Result<()> {
        if !self.binary {
            for _ in 0..n {
                if !self.text.next_line() {
                    return Err(self.error(line, format!("{n} texts are announced, the file ends before the last")));
                }
            }
            return Ok(());
        }
        let mut cursor = Cursor::new(self.source, self.text.position, Endian::Big);
        for _ in 0..n {
            let first = cursor.u8()?;
            let more = [7, 3, 1, 0][usize::from(first >> 6)];
            let high = u64::from(first & 0x3f);
            let length = cursor.take(more)?.iter().fold(high, |length, &b| length << 8 | u64::from(b));
            let length = cursor.room_for(i128::from(length), 1, "letters")?;
            cursor.take(length)?;
        }
        self.text.position = cursor.position;
        Ok(())
    }

    /// The cells announced by 'keyword n size'. Up to version 5.0 rows 'k i1 … ik'; since 5.1 there are `n - 1` cells, given
    /// by the array OFFSETS (where each begins, and the end) and the array CONNECTIVITY.
    pub(super) fn cells(&mut self, line: &Line) -> Result<Block> {
        let (n, size) = (self.count(line, 1)?, self.count(line, 2)?);
        if self.comes(b"OFFSETS") {
            return self.offsets_and_connectivity(line, n, size);
        }
        let rows = self.values(line, size, Some(NumberType::I32))?;
        let rows: Vec<u32> =
            rows.indices().ok_or_else(|| self.error(line, "a negative corner or number of corners"))?;
        // The corners move to the front of their own list, where they have room: every row begins with its count.
        let mut block = Block { ends: Vec::new(), corners: rows, place: line.place };
        let (mut from, mut to) = (0, 0);
        for cell in 0..n {
            let count = block.corners.get(from).map(|&k| k as usize);
            let row = count.map(|k| from + 1..from + 1 + k).filter(|row| row.end <= size).ok_or_else(|| {
                self.error(line, format!("cell {cell} of {n} is beyond the {size} integers of its block"))
            })?;
            from = row.end;
            let length = row.len();
            block.corners.copy_within(row, to);
            to += length;
            block.ends.push(to);
        }
        if from != size {
            return Err(self.error(line, format!("the {n} cells take {from} integers, {size} are announced")));
        }
        block.corners.truncate(to);
        Ok(block)
    }

    pub(super) fn offsets_and_connectivity(&mut self, line: &Line, n: usize, size: usize) -> Result<Block> {
        let mut part = |length: usize, name: &str| -> Result<Values> {
            let head = self.line().filter(|l| l.keyword() == name && l.words.len() == 2);
            let head = head.ok_or_else(|| self.error(line, format!("{name} with a type is expected")))?;
            let of_type = number_type(&head.words[1].to_ascii_lowercase());
            self.values(&head, length, of_type)
        };
        let (offsets, corners) = (part(n, "OFFSETS")?, part(size, "CONNECTIVITY")?);
        let offsets: Vec<usize> = offsets.indices().ok_or_else(|| self.error(line, "an offset is not a count"))?;
        let corners = corners.indices().ok_or_else(|| self.error(line, "a corner is not an index"))?;
        match offsets.split_first() {
            None => Ok(Block { ends: Vec::new(), corners, place: line.place }),
            Some((0, ends)) => Ok(Block { ends: ends.to_vec(), corners, place: line.place }),
            Some((first, _)) => Err(self.error(line, format!("the first offset is {first}, not 0"))),
        }
    }
}

/// A type's name in the file (in small letters).
pub fn number_type(name: &[u8]) -> Option<NumberType> {
    Some(match name {
        b"char" | b"signed_char" | b"vtktypeint8" => NumberType::I8,
        b"unsigned_char" | b"vtktypeuint8" => NumberType::U8,
        b"short" | b"vtktypeint16" => NumberType::I16,
        b"unsigned_short" | b"vtktypeuint16" => NumberType::U16,
        // VTK writes its ids as 32-bit integers, whatever their size in memory.
        b"int" | b"vtktypeint32" | b"vtkidtype" => NumberType::I32,
        b"unsigned_int" | b"vtktypeuint32" => NumberType::U32,
        b"long" | b"long_long" | b"vtktypeint64" => NumberType::I64,
        b"unsigned_long" | b"unsigned_long_long" | b"vtktypeuint64" => NumberType::U64,
        b"float" => NumberType::F32,
        b"double" => NumberType::F64,
        _ => return None,
    })
}
