//! The header: which elements follow, and of what types their properties are.

use super::super::source::Source;
use super::super::text::{Scanner, parse_integer, shown};
use crate::error::{Place, Result};

/// How the values behind the header are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    /// As text.
    Text,
    /// Least significant byte first.
    LittleEndian,
    /// Most significant byte first.
    BigEndian,
}

/// The type of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Type {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Type {
    fn named(word: &[u8]) -> Option<Self> {
        Some(match word {
            b"char" | b"int8" => Type::I8,
            b"uchar" | b"uint8" => Type::U8,
            b"short" | b"int16" => Type::I16,
            b"ushort" | b"uint16" => Type::U16,
            b"int" | b"int32" => Type::I32,
            b"uint" | b"uint32" => Type::U32,
            b"int64" => Type::I64,
            b"uint64" => Type::U64,
            b"float" | b"float32" => Type::F32,
            b"double" | b"float64" => Type::F64,
            _ => return None,
        })
    }

    /// Bytes of a value in a binary file.
    pub fn size(self) -> usize {
        match self {
            Type::I8 | Type::U8 => 1,
            Type::I16 | Type::U16 => 2,
            Type::I32 | Type::U32 | Type::F32 => 4,
            Type::I64 | Type::U64 | Type::F64 => 8,
        }
    }

    /// Whether it has fractions.
    pub fn is_float(self) -> bool {
        matches!(self, Type::F32 | Type::F64)
    }
}

/// One property of an element.
#[derive(Debug, Clone)]
pub struct Property {
    /// Its name.
    pub name: String,
    /// The type of its values.
    pub kind: Type,
    /// The type of the number of values, where it is a list.
    pub list: Option<Type>,
}

/// A table of the file.
#[derive(Debug, Clone)]
pub struct Element {
    /// Its name.
    pub name: String,
    /// Number of rows; not yet checked against the size of the file.
    pub count: u64,
    /// In the order of the file.
    pub properties: Vec<Property>,
}

/// What the header says.
#[derive(Debug)]
pub struct Header {
    /// How the values are written.
    pub encoding: Encoding,
    /// In the order of the file.
    pub elements: Vec<Element>,
    /// Byte offset of the first value of a binary file.
    pub end: usize,
}

impl Header {
    /// Reads the header of a file; the scanner stands behind it, where the values of a text file begin.
    pub fn read<'a>(source: &'a Source<'a>) -> Result<(Self, Scanner<'a>)> {
        let mut scanner = Scanner::new(source, None);
        if scanner.word_on_line() != Some(b"ply") {
            return Err(source.error(Place::Line(1), "this does not look like PLY: the first line is not 'ply'"));
        }
        // Where lines end with CR alone, a LF after the header is the first value.
        let lines_end_with_cr_alone =
            matches!(source.bytes.get(scanner.position..), Some([b'\r', next, ..]) if *next != b'\n');
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        while scanner.next_line() {
            match scanner.word_on_line() {
                None | Some(b"comment" | b"obj_info") => {}
                Some(b"format") => encoding = Some(read_encoding(&mut scanner)?),
                Some(b"element") => elements.push(read_element(&mut scanner, &elements)?),
                Some(b"property") => match elements.last_mut() {
                    Some(element) => element.properties.push(read_property(&mut scanner, element)?),
                    None => return Err(scanner.error("a property comes before the first element")),
                },
                Some(b"end_header") => {
                    let encoding = encoding.ok_or_else(|| scanner.error("the header has no line 'format'"))?;
                    while scanner.word_on_line().is_some() {}
                    let end = match &source.bytes[scanner.position..] {
                        [b'\r', b'\n', ..] if !lines_end_with_cr_alone => scanner.position + 2,
                        [] => scanner.position,
                        _ => scanner.position + 1,
                    };
                    return Ok((Header { encoding, elements, end }, scanner));
                }
                Some(other) => {
                    return Err(scanner.error(format!("'{}' is not a valid line of a PLY header", shown(other))));
                }
            }
        }
        Err(scanner.error("the header has no line 'end_header': the file is cut off"))
    }
}

fn read_encoding(scanner: &mut Scanner) -> Result<Encoding> {
    match scanner.word_on_line() {
        Some(b"ascii") => Ok(Encoding::Text),
        Some(b"binary_little_endian") => Ok(Encoding::LittleEndian),
        Some(b"binary_big_endian") => Ok(Encoding::BigEndian),
        other => Err(scanner.error(format!("'{}' is not a PLY format", shown(other.unwrap_or_default())))),
    }
}

fn read_element(scanner: &mut Scanner, before: &[Element]) -> Result<Element> {
    let name = read_name(scanner)?;
    if before.iter().any(|e| e.name == name) {
        return Err(scanner.error(format!("element '{name}' is declared twice")));
    }
    let word = scanner.word_on_line().unwrap_or_default();
    match parse_integer(word).and_then(|n| u64::try_from(n).ok()) {
        Some(count) => Ok(Element { name, count, properties: Vec::new() }),
        None => Err(scanner.error(format!("element '{name}' has the count '{}'", shown(word)))),
    }
}

fn read_property(scanner: &mut Scanner, element: &Element) -> Result<Property> {
    let is_list = scanner.clone().word_on_line() == Some(b"list");
    if is_list {
        scanner.word_on_line();
    }
    let list = if is_list { Some(read_type(scanner)?) } else { None };
    if list.is_some_and(Type::is_float) {
        return Err(scanner.error("the length of a list must be an integer"));
    }
    let kind = read_type(scanner)?;
    let name = read_name(scanner)?;
    if element.properties.iter().any(|p| p.name == name) {
        return Err(scanner.error(format!("property '{name}' is declared twice")));
    }
    Ok(Property { name, kind, list })
}

fn read_type(scanner: &mut Scanner) -> Result<Type> {
    let word = scanner.word_on_line().unwrap_or_default();
    Type::named(word).ok_or_else(|| scanner.error(format!("'{}' is not a PLY type", shown(word))))
}

fn read_name(scanner: &mut Scanner) -> Result<String> {
    match scanner.word_on_line() {
        Some(word) => Ok(String::from_utf8_lossy(word).into_owned()),
        None => Err(scanner.error("the line ends before the name")),
    }
}
