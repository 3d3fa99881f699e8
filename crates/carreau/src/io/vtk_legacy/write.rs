//! The writer.

use super::super::binary::Endian;
use super::super::percent;
use super::super::source::WriteOptions;
use super::super::text::push_integer;
use super::super::vtk_arrays::{Numbers, numbers};
use super::super::vtk_cells::{CellTable, kind, warnings};
use crate::error::{Error, Result};
use crate::mesh::{Columns, RawMesh};

/// Writes a legacy file; returns warnings about what it cannot hold.
pub fn write(mesh: &RawMesh, options: &WriteOptions, out: &mut Vec<u8>) -> Result<Vec<String>> {
    let table = CellTable::new(mesh)?;
    let mut file = Writer { ascii: options.ascii, out };
    file.line(&["# vtk DataFile Version 4.2"]);
    file.line(&["written by carreau"]);
    file.line(&[if options.ascii { "ASCII" } else { "BINARY" }]);
    let volume = !mesh.cells.is_empty();
    file.line(&["DATASET", if volume { "UNSTRUCTURED_GRID" } else { "POLYDATA" }]);
    let coordinates: Vec<f64> = mesh.points.iter().flat_map(|p| p.to_array()).collect();
    file.line(&["POINTS", &mesh.points.len().to_string(), "double"]);
    file.numbers(Numbers::F64(&coordinates), 3);
    if volume {
        file.cells("CELLS", table.rows(|_| true)?);
        let kinds: Vec<i32> = table.kinds.iter().map(|&kind| i32::from(kind)).collect();
        file.line(&["CELL_TYPES", &kinds.len().to_string()]);
        file.numbers(Numbers::I32(&kinds), 1);
    } else {
        file.cells("LINES", table.rows(|kind| kind == kind::LINE)?);
        file.cells("POLYGONS", table.rows(|kind| kind != kind::LINE)?);
    }
    file.data("POINT_DATA", mesh.points.len(), &mesh.attributes.vertex);
    file.data("CELL_DATA", table.kinds.len(), &table.data);
    let mut warnings = warnings(mesh);
    if options.ascii {
        warnings.extend(not_finite(&mesh.attributes.vertex).chain(not_finite(&table.data)));
    }
    Ok(warnings)
}

/// Columns that VTK's own reader stumbles over in text.
fn not_finite(columns: &Columns) -> impl Iterator<Item = String> {
    let stumbles = |column| matches!(numbers(column).0, Numbers::F64(v) if v.iter().any(|x| !x.is_finite()));
    columns.iter().filter(move |(_, column)| stumbles(column)).map(|(name, _)| {
        format!("'{name}' has values that are not finite: VTK reads them from binary files but not from text")
    })
}

/// Cells as rows 'number of corners, corners'.
struct Rows {
    count: usize,
    integers: Vec<i32>,
}

impl CellTable {
    /// The cells of some kinds as rows of the 32-bit integers of this version of the format.
    fn rows(&self, wanted: impl Fn(u8) -> bool) -> Result<Rows> {
        let mut rows = Rows { count: 0, integers: Vec::new() };
        let mut start = 0;
        for (&kind, &end) in self.kinds.iter().zip(&self.ends) {
            if wanted(kind) {
                rows.count += 1;
                rows.integers.push((end - start) as i32);
                // Indices are below 2³²; those that do not fit become negative here and are found below.
                rows.integers.extend(self.corners[start as usize..end as usize].iter().map(|&v| v as i32));
            }
            start = end;
        }
        if rows.integers.len() > i32::MAX as usize || rows.integers.iter().any(|&k| k < 0) {
            return Err(Error::input("the mesh is too large for a legacy VTK file", "", "write .vtu instead"));
        }
        Ok(rows)
    }
}

struct Writer<'a> {
    ascii: bool,
    out: &'a mut Vec<u8>,
}

impl Writer<'_> {
    fn line(&mut self, words: &[&str]) {
        self.out.extend_from_slice(words.join(" ").as_bytes());
        self.out.push(b'\n');
    }

    fn numbers(&mut self, numbers: Numbers, width: usize) {
        if self.ascii {
            numbers.push_text(width, self.out);
        } else {
            numbers.push_bytes(Endian::Big, self.out);
            self.out.push(b'\n');
        }
    }

    fn cells(&mut self, keyword: &str, rows: Rows) {
        if rows.count == 0 {
            return;
        }
        self.line(&[keyword, &rows.count.to_string(), &rows.integers.len().to_string()]);
        if !self.ascii {
            return self.numbers(Numbers::I32(&rows.integers), 1);
        }
        let mut rest = rows.integers.as_slice();
        while let Some(&corners) = rest.first() {
            let (row, behind) = rest.split_at(1 + corners as usize);
            for (k, &x) in row.iter().enumerate() {
                if k > 0 {
                    self.out.push(b' ');
                }
                push_integer(self.out, x);
            }
            self.out.push(b'\n');
            rest = behind;
        }
    }

    fn data(&mut self, keyword: &str, count: usize, columns: &Columns) {
        if columns.is_empty() {
            return;
        }
        self.line(&[keyword, &count.to_string()]);
        self.line(&["FIELD FieldData", &columns.len().to_string()]);
        for (name, column) in columns {
            let (numbers, width) = numbers(column);
            self.line(&[&percent::encode(name), &width.to_string(), &count.to_string(), numbers.legacy_type()]);
            self.numbers(numbers, width);
        }
    }
}
