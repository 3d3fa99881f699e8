//! The writer: one piece, inline arrays.

use super::super::binary::Endian;
use super::super::source::WriteOptions;
use super::super::vtk_arrays::{Numbers, numbers};
use super::super::vtk_cells::{CellTable, kind, warnings};
use crate::error::{Error, Result};
use crate::mesh::{Columns, RawMesh};
use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use rayon::prelude::*;
use std::io::Write;

/// Bytes that are compressed together.
const BLOCK: usize = 1 << 20;

/// Writes an unstructured grid; returns warnings about what it cannot hold.
pub fn write_vtu(mesh: &RawMesh, options: &WriteOptions, out: &mut Vec<u8>) -> Result<Vec<String>> {
    let table = CellTable::new(mesh)?;
    let mut file = Writer { ascii: options.ascii, out };
    file.open("UnstructuredGrid");
    let counts = [("NumberOfPoints", mesh.points.len()), ("NumberOfCells", table.kinds.len())];
    file.piece(mesh, &table, &counts, |file| {
        file.line("<Cells>");
        file.cells(&table.corners, &table.ends)?;
        file.array("types", Numbers::U8(&table.kinds), 1)?;
        file.line("</Cells>");
        Ok(())
    })?;
    file.close("UnstructuredGrid");
    Ok(warnings(mesh))
}

/// Writes polydata; returns warnings about what it cannot hold. A mesh with volume cells is refused.
pub fn write_vtp(mesh: &RawMesh, options: &WriteOptions, out: &mut Vec<u8>) -> Result<Vec<String>> {
    if !mesh.cells.is_empty() {
        return Err(Error::input(
            format!("polydata (.vtp) cannot hold the {} volume cells", mesh.cells.len()),
            "",
            "write .vtu instead, or extract the boundary with `carreau convert --boundary`",
        ));
    }
    let table = CellTable::new(mesh)?;
    let lines = table.kinds.iter().take_while(|&&kind| kind == kind::LINE).count();
    let corners_of_lines = 2 * lines;
    let mut file = Writer { ascii: options.ascii, out };
    file.open("PolyData");
    let counts = [
        ("NumberOfPoints", mesh.points.len()),
        ("NumberOfVerts", 0),
        ("NumberOfLines", lines),
        ("NumberOfStrips", 0),
        ("NumberOfPolys", table.kinds.len() - lines),
    ];
    file.piece(mesh, &table, &counts, |file| {
        file.line("<Lines>");
        file.cells(&table.corners[..corners_of_lines], &table.ends[..lines])?;
        file.line("</Lines>");
        file.line("<Polys>");
        let ends: Vec<i64> = table.ends[lines..].iter().map(|end| end - corners_of_lines as i64).collect();
        file.cells(&table.corners[corners_of_lines..], &ends)?;
        file.line("</Polys>");
        Ok(())
    })?;
    file.close("PolyData");
    Ok(warnings(mesh))
}

struct Writer<'a> {
    ascii: bool,
    out: &'a mut Vec<u8>,
}

impl Writer<'_> {
    fn line(&mut self, text: &str) {
        self.out.extend_from_slice(text.as_bytes());
        self.out.push(b'\n');
    }

    fn open(&mut self, dataset: &str) {
        let compressor = if self.ascii { "" } else { " compressor=\"vtkZLibDataCompressor\"" };
        self.line("<?xml version=\"1.0\"?>");
        self.line(&format!(
            "<VTKFile type=\"{dataset}\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\"{compressor}>"
        ));
        self.line(&format!("<{dataset}>"));
    }

    fn close(&mut self, dataset: &str) {
        self.line(&format!("</{dataset}>"));
        self.line("</VTKFile>");
    }

    /// The piece with its points and data; `cells` writes what lies between.
    fn piece(
        &mut self,
        mesh: &RawMesh,
        table: &CellTable,
        counts: &[(&str, usize)],
        cells: impl FnOnce(&mut Self) -> Result<()>,
    ) -> Result<()> {
        let counts: String = counts.iter().map(|(name, n)| format!(" {name}=\"{n}\"")).collect();
        self.line(&format!("<Piece{counts}>"));
        self.data("PointData", &mesh.attributes.vertex)?;
        self.data("CellData", &table.data)?;
        let coordinates: Vec<f64> = mesh.points.iter().flat_map(|p| p.to_array()).collect();
        self.line("<Points>");
        self.array("Points", Numbers::F64(&coordinates), 3)?;
        self.line("</Points>");
        cells(self)?;
        self.line("</Piece>");
        Ok(())
    }

    fn cells(&mut self, corners: &[i64], ends: &[i64]) -> Result<()> {
        self.array("connectivity", Numbers::I64(corners), 1)?;
        self.array("offsets", Numbers::I64(ends), 1)
    }

    fn data(&mut self, section: &str, columns: &Columns) -> Result<()> {
        self.line(&format!("<{section}>"));
        for (name, column) in columns {
            let (numbers, width) = numbers(column);
            self.array(name, numbers, width)?;
        }
        self.line(&format!("</{section}>"));
        Ok(())
    }

    fn array(&mut self, name: &str, numbers: Numbers, width: usize) -> Result<()> {
        let (of_type, format) = (numbers.xml_type(), if self.ascii { "ascii" } else { "binary" });
        let name = escaped(name);
        self.line(&format!(
            "<DataArray type=\"{of_type}\" Name=\"{name}\" NumberOfComponents=\"{width}\" format=\"{format}\">"
        ));
        if self.ascii {
            numbers.push_text(width, self.out);
        } else {
            let mut bytes = Vec::new();
            numbers.push_bytes(Endian::Little, &mut bytes);
            self.base64(&bytes)?;
        }
        self.line("</DataArray>");
        Ok(())
    }

    /// Base64 of the head, then base64 of the compressed blocks.
    fn base64(&mut self, bytes: &[u8]) -> Result<()> {
        let blocks = bytes.par_chunks(BLOCK).map(compressed).collect::<Result<Vec<_>>>()?;
        let mut head = vec![blocks.len() as u64, BLOCK as u64, (bytes.len() % BLOCK) as u64];
        head.extend(blocks.iter().map(|block| block.len() as u64));
        let head: Vec<u8> = head.iter().flat_map(|word| word.to_le_bytes()).collect();
        self.line(&(BASE64.encode(head) + &BASE64.encode(blocks.concat())));
        Ok(())
    }
}

/// Coordinates hardly shrink: higher levels cost several times the time for a few percent.
fn compressed(block: &[u8]) -> Result<Vec<u8>> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    let written = encoder.write_all(block).and_then(|()| encoder.finish());
    written.map_err(|e| Error::Bug(format!("compression in memory failed: {e}")))
}

/// A text as the value of an attribute; letters that XML cannot hold become underscores.
pub fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\t' | '\n' | '\r' => out.push_str(&format!("&#{};", c as u32)),
            '\0'..' ' | '\u{fffe}' | '\u{ffff}' => out.push('_'),
            c => out.push(c),
        }
    }
    out
}
