//! The reader.

use super::super::binary::Endian;
use super::super::source::Source;
use super::super::text::shown;
use super::super::vtk_arrays::{Array, NumberType, Values};
use super::super::vtk_cells::{CellReader, kind};
use super::payload::{Appended, Compressor, Encoding, Payloads};
use crate::error::{Error, Place, Result};
use crate::mesh::RawMesh;
use glam::DVec3;
use roxmltree::{Document, Node, ParsingOptions};
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

/// Parts of polydata in the order of their cell data, and the attribute with the number of their cells.
const POLYDATA_PARTS: [(&str, &str, u8); 4] = [
    ("Verts", "NumberOfVerts", kind::POLY_VERTEX),
    ("Lines", "NumberOfLines", kind::POLY_LINE),
    ("Polys", "NumberOfPolys", kind::POLYGON),
    ("Strips", "NumberOfStrips", kind::TRIANGLE_STRIP),
];

/// Reads a `.vtu` or `.vtp` file.
pub fn read(source: &Source) -> Result<RawMesh> {
    let (text, appended) = cut_appended(source)?;
    // Without a document type there are no entities, so nothing in the text can expand.
    let options = ParsingOptions { allow_dtd: false, ..ParsingOptions::default() };
    let document = Document::parse_with_options(&text, options).map_err(|e| {
        let line = e.pos().row;
        let what = e.to_string().replace(char::is_control, "?");
        source.error(Place::Line(u64::from(line)), format!("no well-formed XML: {what}"))
    })?;
    Reader::new(source, &document, appended)?.mesh()
}

/// Cuts the appended section, which may be binary, out of the XML around it.
fn cut_appended<'a>(source: &'a Source) -> Result<(Cow<'a, str>, Appended<'a>)> {
    let bytes = source.bytes;
    let find = |from: usize, byte: u8| bytes.get(from..)?.iter().position(|&b| b == byte).map(|at| from + at);
    let mut tags = std::iter::successors(find(0, b'<'), |&at| find(at + 1, b'<'));
    let Some(start) = tags.find(|&at| bytes[at..].starts_with(b"<AppendedData")) else {
        return Ok((String::from_utf8_lossy(bytes), Appended::default()));
    };
    let head = find(start, b'>');
    let (Some(head), Some(underscore)) = (head, head.and_then(|end| find(end, b'_'))) else {
        return Err(source.error(Place::Byte(start as u64), "the appended data do not begin: no '_'"));
    };
    let tag = String::from_utf8_lossy(&bytes[start..head]);
    let raw = tag.contains("\"raw\"") || tag.contains("'raw'");
    let section = &bytes[underscore + 1..];
    let end = if raw { section.len() } else { section.iter().position(|&b| b == b'<').unwrap_or(section.len()) };
    let text = String::from_utf8_lossy(&bytes[..start]).into_owned() + "</VTKFile>";
    Ok((Cow::Owned(text), Appended { bytes: &section[..end], raw, offsets: Vec::new() }))
}

struct Reader<'a> {
    source: &'a Source<'a>,
    document: &'a Document<'a>,
    grid: Node<'a, 'a>,
    /// Polydata instead of an unstructured grid.
    polydata: bool,
    payloads: Payloads<'a>,
    notes: Vec<String>,
}

/// The arrays of one kind of element, over all pieces so far.
#[derive(Default)]
struct Attached {
    arrays: BTreeMap<String, Array>,
    /// Names of arrays that some piece lacks or has in another form.
    broken: BTreeSet<String>,
    pieces: usize,
}

impl<'a> Reader<'a> {
    fn new(source: &'a Source<'a>, document: &'a Document<'a>, mut appended: Appended<'a>) -> Result<Self> {
        let root = document.root_element();
        let dataset = root.attribute("type").unwrap_or_default();
        let grid = root.children().find(|node| node.has_tag_name(dataset));
        let (polydata, grid) = match (root.tag_name().name(), dataset, grid) {
            ("VTKFile", "UnstructuredGrid", Some(grid)) => (false, grid),
            ("VTKFile", "PolyData", Some(grid)) => (true, grid),
            ("VTKFile", "PUnstructuredGrid" | "PPolyData", _) => {
                return Err(
                    source.error(Place::File, "this is only the index of a file in parts; read the parts instead")
                );
            }
            (name, dataset, _) => {
                let found = format!("{} of type '{}'", shown(name.as_bytes()), shown(dataset.as_bytes()));
                return Err(
                    source.error(Place::File, format!("{found} is not read, only UnstructuredGrid and PolyData"))
                );
            }
        };
        let arrays = root.descendants().filter(|node| node.has_tag_name("DataArray"));
        appended.offsets = arrays.filter_map(|node| node.attribute("offset")?.trim().parse().ok()).collect();
        appended.offsets.sort_unstable();
        let payloads = Payloads::new(encoding(source, root)?, appended, source.bytes.len());
        Ok(Reader { source, document, grid, polydata, payloads, notes: Vec::new() })
    }

    fn error(&self, node: Node, what: impl Into<String>) -> Error {
        let line = self.document.text_pos_at(node.range().start).row;
        self.source.error(Place::Line(u64::from(line)), what)
    }

    fn mesh(mut self) -> Result<RawMesh> {
        let mut points: Vec<DVec3> = Vec::new();
        let mut cells = CellReader::default();
        let (mut point_data, mut cell_data) = (Attached::default(), Attached::default());
        for piece in elements(self.grid, "Piece") {
            let shift = points.len();
            self.points(piece, &mut points)?;
            if self.polydata {
                for (name, count, kind) in POLYDATA_PARTS {
                    if let Some(part) = element(piece, name) {
                        self.cells(piece, part, Some(kind), count, (shift, points.len() - shift), &mut cells)?;
                    }
                }
            } else if let Some(part) = element(piece, "Cells") {
                self.cells(piece, part, None, "NumberOfCells", (shift, points.len() - shift), &mut cells)?;
            }
            self.attached(piece, "PointData", &mut point_data)?;
            self.attached(piece, "CellData", &mut cell_data)?;
        }
        if element(self.grid, "FieldData").is_some() {
            self.notes.push("the field data are left out: they are on no points or cells".to_string());
        }
        for name in point_data.broken.iter().chain(&cell_data.broken) {
            let name = shown(name.as_bytes());
            self.notes
                .push(format!("the array '{name}' is left out: the pieces have it in different forms, or not all"));
        }
        Ok(cells.finish(points, point_data.arrays, cell_data.arrays, self.notes))
    }

    /// Appends the points of a piece.
    fn points(&mut self, piece: Node<'a, 'a>, points: &mut Vec<DVec3>) -> Result<()> {
        let before = points.len();
        if let Some(node) = element(piece, "Points").and_then(|points| element(points, "DataArray")) {
            let coordinates = self.values(node)?.into_floats();
            let (found, rest) = coordinates.as_chunks();
            if !rest.is_empty() {
                return Err(self.error(node, format!("{} coordinates are not a multiple of 3", coordinates.len())));
            }
            points.extend(found.iter().map(|&p| DVec3::from_array(p)));
        }
        self.check_count(piece, "NumberOfPoints", points.len() - before)?;
        if u32::try_from(points.len()).is_err() {
            return Err(self.error(piece, "there are more than 2³² points"));
        }
        Ok(())
    }

    /// Adds the cells listed by 'connectivity' and 'offsets', all of one kind or of the kinds in 'types'.
    fn cells(
        &mut self,
        piece: Node<'a, 'a>,
        part: Node<'a, 'a>,
        kind: Option<u8>,
        count: &str,
        (shift, points): (usize, usize),
        cells: &mut CellReader,
    ) -> Result<()> {
        let corners = self.indices::<u32>(part, "connectivity")?;
        let ends = self.indices::<usize>(part, "offsets")?;
        let kinds = match kind {
            Some(kind) => vec![kind; ends.len()],
            None => self.indices::<u8>(part, "types")?,
        };
        self.check_count(piece, count, ends.len())?;
        cells.add(&kinds, &ends, &corners, shift, points).map_err(|what| self.error(part, what))
    }

    /// An array of indices by name; a part without arrays has no cells.
    fn indices<T: TryFrom<i64>>(&mut self, part: Node<'a, 'a>, name: &str) -> Result<Vec<T>> {
        let node = elements(part, "DataArray").find(|node| node.attribute("Name") == Some(name));
        match node {
            Some(node) => {
                let values = self.values(node)?;
                values.indices().ok_or_else(|| self.error(node, format!("a value of '{name}' is out of range")))
            }
            None if element(part, "DataArray").is_none() => Ok(Vec::new()),
            None => Err(self.error(part, format!("the array '{name}' is missing"))),
        }
    }

    fn check_count(&self, piece: Node, attribute: &str, found: usize) -> Result<()> {
        match piece.attribute(attribute) {
            Some(announced) if announced.trim().parse() != Ok(found) => {
                Err(self.error(piece, format!("{attribute} is '{}', there are {found}", shown(announced.as_bytes()))))
            }
            _ => Ok(()),
        }
    }

    /// Appends the arrays of a piece's PointData or CellData to those of the pieces before.
    fn attached(&mut self, piece: Node<'a, 'a>, section: &str, into: &mut Attached) -> Result<()> {
        let mut seen = BTreeSet::new();
        let nodes = element(piece, section).into_iter().flat_map(|section| section.children());
        for node in nodes.filter(|node| node.has_tag_name("DataArray") || node.has_tag_name("Array")) {
            let name = node.attribute("Name").unwrap_or_default().to_string();
            if number_type(node).is_none() {
                self.notes.push(format!("the array '{}' is left out: it holds no numbers", shown(name.as_bytes())));
                continue;
            }
            if !seen.insert(name.clone()) {
                self.notes.push(format!("a second array '{}' is left out", shown(name.as_bytes())));
                continue;
            }
            let array = Array { width: self.width(node)?, values: self.values(node)? };
            let fits = match into.arrays.get_mut(&name) {
                Some(before) => before.append(array),
                None if into.pieces == 0 => into.arrays.insert(name.clone(), array).is_none(),
                None => false,
            };
            if !fits {
                into.broken.insert(name);
            }
        }
        into.pieces += 1;
        into.broken.extend(into.arrays.keys().filter(|&name| !seen.contains(name)).cloned());
        into.arrays.retain(|name, _| !into.broken.contains(name));
        Ok(())
    }

    fn width(&self, node: Node) -> Result<usize> {
        let width = node.attribute("NumberOfComponents").map_or(Some(1), |n| n.trim().parse().ok());
        width.filter(|&n| n > 0).ok_or_else(|| self.error(node, "NumberOfComponents is not a positive number"))
    }

    /// The numbers of a data array.
    fn values(&mut self, node: Node<'a, 'a>) -> Result<Values> {
        let Some(of_type) = number_type(node) else {
            let found = shown(node.attribute("type").unwrap_or_default().as_bytes());
            return Err(self.error(node, format!("a data array of unknown type '{found}'")));
        };
        let bytes = match node.attribute("format").unwrap_or("ascii") {
            "ascii" => return self.words(node, of_type),
            "binary" => self.payloads.inline(&text(node)),
            "appended" => match node.attribute("offset").and_then(|offset| offset.trim().parse().ok()) {
                Some(offset) => self.payloads.appended(offset),
                None => Err("an appended array without a valid offset".to_string()),
            },
            other => Err(format!("unknown format '{}'", shown(other.as_bytes()))),
        };
        let bytes = bytes.map_err(|what| self.error(node, what))?;
        if !bytes.len().is_multiple_of(of_type.size()) {
            return Err(self.error(node, format!("{} bytes are not a whole number of values", bytes.len())));
        }
        Ok(of_type.decode(&bytes, self.payloads.encoding.endian))
    }

    fn words(&self, node: Node, of_type: NumberType) -> Result<Values> {
        let mut values = of_type.empty();
        for word in text(node).split_ascii_whitespace() {
            if values.push_word(word.as_bytes()).is_none() {
                let what = format!("'{}' is not a number of the announced type", shown(word.as_bytes()));
                return Err(self.error(node, what));
            }
        }
        Ok(values)
    }
}

/// How binary arrays are written, from the attributes of the root element.
fn encoding(source: &Source, root: Node) -> Result<Encoding> {
    let unknown = |what: &str, value: &str| {
        Err(source.error(Place::File, format!("the {what} '{}' is not known", shown(value.as_bytes()))))
    };
    let endian = match root.attribute("byte_order") {
        None | Some("LittleEndian") => Endian::Little,
        Some("BigEndian") => Endian::Big,
        Some(other) => return unknown("byte order", other),
    };
    let wide = match root.attribute("header_type") {
        None | Some("UInt32") => false,
        Some("UInt64") => true,
        Some(other) => return unknown("header type", other),
    };
    let compressor = match root.attribute("compressor") {
        None | Some("") => None,
        Some("vtkZLibDataCompressor") => Some(Compressor::Zlib),
        Some("vtkLZMADataCompressor") => Some(Compressor::Lzma),
        Some("vtkLZ4DataCompressor") => Some(Compressor::Lz4),
        Some(other) => return unknown("compressor", other),
    };
    Ok(Encoding { endian, wide, compressor })
}

fn number_type(node: Node) -> Option<NumberType> {
    Some(match node.attribute("type")? {
        "Int8" => NumberType::I8,
        "UInt8" => NumberType::U8,
        "Int16" => NumberType::I16,
        "UInt16" => NumberType::U16,
        "Int32" => NumberType::I32,
        "UInt32" => NumberType::U32,
        "Int64" => NumberType::I64,
        "UInt64" => NumberType::U64,
        "Float32" => NumberType::F32,
        "Float64" => NumberType::F64,
        _ => return None,
    })
}

fn elements<'a>(parent: Node<'a, 'a>, name: &str) -> impl Iterator<Item = Node<'a, 'a>> {
    parent.children().filter(move |node| node.has_tag_name(name))
}

fn element<'a>(parent: Node<'a, 'a>, name: &str) -> Option<Node<'a, 'a>> {
    elements(parent, name).next()
}

/// The text of an element, without that of elements in it.
fn text<'a>(node: Node<'a, 'a>) -> Cow<'a, str> {
    let mut parts = node.children().filter(Node::is_text).filter_map(|part| part.text());
    let first = parts.next().unwrap_or_default();
    parts.fold(Cow::Borrowed(first), |text, part| text + part)
}
