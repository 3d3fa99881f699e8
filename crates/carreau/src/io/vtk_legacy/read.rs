//! The reader: a walk over keyword lines and blocks of values.

use super::super::percent;
use super::super::source::Source;
use super::super::text::shown;
use super::super::vtk_arrays::{Array, NumberType, Values};
use super::super::vtk_cells::{CellReader, kind};
use super::walker::{Block, Line, Walker};
use crate::error::{Place, Result};
use crate::mesh::RawMesh;
use glam::DVec3;

/// Reads a legacy file.
pub fn read(source: &Source) -> Result<RawMesh> {
    let mut file = Walker::open(source)?;
    let mut content = Content::default();
    while let Some(line) = file.line() {
        content.section(&mut file, &line)?;
    }
    content.into_mesh(source)
}

/// What the arrays that follow belong to.
#[derive(Clone, Copy, Default)]
enum DataOf {
    /// The dataset as a whole: field data, which are not kept.
    #[default]
    All,
    Points(usize),
    Cells(usize),
}

/// Parts of polydata in the order of their cell data.
const POLYDATA: [(&str, u8); 4] = [
    ("VERTICES", kind::POLY_VERTEX),
    ("LINES", kind::POLY_LINE),
    ("POLYGONS", kind::POLYGON),
    ("TRIANGLE_STRIPS", kind::TRIANGLE_STRIP),
];

/// What has been read so far.
#[derive(Default)]
struct Content {
    points: Option<Vec<DVec3>>,
    cells: Option<Block>,
    kinds: Option<Vec<u8>>,
    polydata: [Option<Block>; 4],
    data_of: DataOf,
    point_data: Vec<(String, Array)>,
    cell_data: Vec<(String, Array)>,
    notes: Vec<String>,
}

impl Content {
    /// One section of the file.
    fn section(&mut self, file: &mut Walker, line: &Line) -> Result<()> {
        let keyword = line.keyword();
        let part = POLYDATA.iter().position(|(name, _)| *name == keyword);
        let seen = match keyword.as_str() {
            "POINTS" => self.points.is_some(),
            "CELLS" => self.cells.is_some(),
            "CELL_TYPES" => self.kinds.is_some(),
            _ => part.is_some_and(|k| self.polydata[k].is_some()),
        };
        if seen {
            return Err(file.error(line, format!("{keyword} appears twice")));
        }
        match (keyword.as_str(), part) {
            ("DATASET", _) => check_dataset(file, line)?,
            ("POINTS", _) => self.points = Some(points(file, line)?),
            ("CELLS", _) => self.cells = Some(file.cells(line)?),
            ("CELL_TYPES", _) => {
                let n = file.count(line, 1)?;
                let kinds = file.values(line, n, Some(NumberType::I32))?;
                self.kinds = Some(kinds.indices().ok_or_else(|| file.error(line, "a cell type is not in 0..=255"))?);
            }
            (_, Some(part)) => self.polydata[part] = Some(file.cells(line)?),
            ("POINT_DATA", _) => self.data_of = DataOf::Points(file.count(line, 1)?),
            ("CELL_DATA", _) => self.data_of = DataOf::Cells(file.count(line, 1)?),
            ("FIELD", _) => self.field(file, line)?,
            _ => self.attribute(file, line, &keyword)?,
        }
        Ok(())
    }

    /// 'FIELD name n', then n times 'name width rows type' and the values.
    fn field(&mut self, file: &mut Walker, line: &Line) -> Result<()> {
        for _ in 0..file.count(line, 2)? {
            let Some(head) = file.line() else {
                return Err(file.error(line, "the file ends before the last array of the field"));
            };
            let (width, rows) = (file.width(&head, 1)?, file.count(&head, 2)?);
            let array = file.array(&head, rows, width, 3)?;
            self.keep(head.word(0), array);
        }
        Ok(())
    }

    /// The other arrays: 'KEYWORD name …', as long as the points or the cells.
    fn attribute(&mut self, file: &mut Walker, line: &Line, keyword: &str) -> Result<()> {
        if keyword == "LOOKUP_TABLE" {
            let n = file.count(line, 2)?;
            file.values(line, n.saturating_mul(4), Some(color_type(file)))?;
            self.notes.push(format!("the colour table '{}' is left out", shown(line.word(1).unwrap_or_default())));
            return Ok(());
        }
        let (width, of_type) = match keyword {
            "SCALARS" if line.words.len() > 3 => (file.width(line, 3)?, 2),
            "SCALARS" | "GLOBAL_IDS" | "PEDIGREE_IDS" | "EDGE_FLAGS" => (1, 2),
            "VECTORS" | "NORMALS" => (3, 2),
            "TENSORS" => (9, 2),
            "TENSORS6" => (6, 2),
            "TEXTURE_COORDINATES" => (file.width(line, 2)?, 3),
            "COLOR_SCALARS" => (file.width(line, 2)?, 0),
            _ => return Err(file.error(line, format!("unknown keyword '{}'", shown(line.word(0).unwrap_or_default())))),
        };
        let (DataOf::Points(rows) | DataOf::Cells(rows)) = self.data_of else {
            return Err(file.error(line, format!("{keyword} before POINT_DATA or CELL_DATA")));
        };
        if keyword == "SCALARS" && file.comes(b"LOOKUP_TABLE") {
            file.line();
        }
        let array = if keyword == "COLOR_SCALARS" {
            let n = rows.checked_mul(width).ok_or_else(|| file.error(line, "an impossible number of values"))?;
            let values = Values::Bytes(color_bytes(file.values(line, n, Some(color_type(file)))?));
            Some(Array { values, width })
        } else {
            file.array(line, rows, width, of_type)?
        };
        self.keep(line.word(1), array);
        Ok(())
    }

    /// Keeps an array where the data of the section belong.
    fn keep(&mut self, name: Option<&[u8]>, array: Option<Array>) {
        let name = percent::decode(name.unwrap_or_default());
        match (self.data_of, array) {
            (_, None) => {
                self.notes.push(format!("the array '{}' is left out: it holds texts", shown(name.as_bytes())));
            }
            (DataOf::All, _) => {
                let name = shown(name.as_bytes());
                self.notes.push(format!("the field '{name}' is left out: it is on no points or cells"));
            }
            (DataOf::Points(_), Some(array)) => self.point_data.push((name, array)),
            (DataOf::Cells(_), Some(array)) => self.cell_data.push((name, array)),
        }
    }

    fn into_mesh(self, source: &Source) -> Result<RawMesh> {
        let Some(points) = self.points else {
            return Err(source.error(Place::File, "the file has no POINTS"));
        };
        let mut cells = CellReader::default();
        let mut add = |block: &Block, kinds: &[u8]| {
            let added = cells.add(kinds, &block.ends, &block.corners, 0, points.len());
            added.map_err(|what| source.error(block.place, what))
        };
        if let Some(block) = &self.cells {
            add(block, self.kinds.as_deref().unwrap_or_default())?;
        }
        for (block, (_, kind)) in self.polydata.iter().zip(POLYDATA) {
            if let Some(block) = block {
                add(block, &vec![kind; block.ends.len()])?;
            }
        }
        Ok(cells.finish(points, self.point_data, self.cell_data, self.notes))
    }
}

fn check_dataset(file: &Walker, line: &Line) -> Result<()> {
    match line.word(1) {
        Some(kind) if kind.eq_ignore_ascii_case(b"POLYDATA") || kind.eq_ignore_ascii_case(b"UNSTRUCTURED_GRID") => {
            Ok(())
        }
        kind => {
            let kind = shown(kind.unwrap_or_default());
            Err(file.error(line, format!("the dataset '{kind}' is not read, only POLYDATA and UNSTRUCTURED_GRID")))
        }
    }
}

fn points(file: &mut Walker, line: &Line) -> Result<Vec<DVec3>> {
    let n = file.count(line, 1)?;
    match file.array(line, n, 3, 2)? {
        Some(array) => Ok(array.values.into_floats().as_chunks().0.iter().map(|&p| DVec3::from_array(p)).collect()),
        None => Err(file.error(line, "texts as coordinates")),
    }
}

/// Colours are bytes in binary files and shares of one in text.
fn color_type(file: &Walker) -> NumberType {
    if file.binary { NumberType::U8 } else { NumberType::F32 }
}

fn color_bytes(values: Values) -> Vec<u8> {
    match values {
        Values::Bytes(bytes) => bytes,
        // The cast saturates.
        other => other.into_floats().iter().map(|x| (255.0 * x).round() as u8).collect(),
    }
}
