//! The reader: statement by statement, in one pass.

use super::super::names::FaceNames;
use super::super::source::Source;
use super::super::text::{Scanner, parse_integer, shown};
use super::library;
use super::values::{Colors, Corner, CornerValues, Largest, LeftOut, Reference};
use super::words::NAMES;
use crate::error::{Place, Result};
use crate::mesh::{Column, MaterialLibrary, RawMesh};
use glam::DVec3;

/// Statements that are passed over; they show that a file is OBJ at all.
const OTHER_STATEMENTS: &[&[u8]] = &[
    b"p",
    b"s",
    b"vp",
    b"mg",
    b"maplib",
    b"usemap",
    b"lod",
    b"bevel",
    b"c_interp",
    b"d_interp",
    b"shadow_obj",
    b"trace_obj",
    b"cstype",
    b"deg",
    b"bmat",
    b"step",
    b"curv",
    b"curv2",
    b"surf",
    b"parm",
    b"trim",
    b"hole",
    b"scrv",
    b"sp",
    b"end",
    b"con",
    b"ctech",
    b"stech",
    b"call",
    b"csh",
];

pub fn read(source: &Source) -> Result<RawMesh> {
    if source.bytes.contains(&0) {
        return Err(source.error(Place::File, "this does not look like OBJ: the file is binary"));
    }
    let mut reader = Reader::new(source);
    loop {
        if let Some(keyword) = reader.scanner.word_on_line() {
            reader.statement(keyword)?;
        }
        if !reader.scanner.next_line() {
            return reader.finish();
        }
    }
}

/// What has been read so far.
struct Reader<'a> {
    source: &'a Source<'a>,
    scanner: Scanner<'a>,
    mesh: RawMesh,
    colors: Colors,
    uvs: CornerValues<2>,
    normals: CornerValues<3>,
    /// In the order of [`NAMES`].
    names: [FaceNames; 3],
    /// The vertices that faces use: they may come later in the file.
    vertices: Largest,
    short_faces: LeftOut,
    /// Corners of the current face.
    face: Vec<Corner>,
    /// Line of the first statement that is none of OBJ, and whether there was one that is.
    unknown: Option<u64>,
    any_known: bool,
}

impl<'a> Reader<'a> {
    fn new(source: &'a Source<'a>) -> Self {
        Reader {
            source,
            scanner: Scanner::new(source, Some(b'#')).with_continuation(),
            mesh: RawMesh::default(),
            colors: Colors::default(),
            uvs: CornerValues::default(),
            normals: CornerValues::default(),
            names: [FaceNames::new(""), FaceNames::new("default"), FaceNames::new("")],
            vertices: Largest::default(),
            short_faces: LeftOut::default(),
            face: Vec::new(),
            unknown: None,
            any_known: false,
        }
    }

    fn statement(&mut self, keyword: &[u8]) -> Result<()> {
        match keyword {
            b"v" => self.vertex()?,
            b"f" => self.polygon()?,
            b"vn" => self.normals.read(&mut self.scanner, 3, "normal")?,
            b"vt" => self.uvs.read(&mut self.scanner, 1, "texture coordinate")?,
            b"l" => self.polyline()?,
            b"o" => self.name(0),
            b"g" => self.name(1),
            b"usemtl" => self.name(2),
            b"mtllib" => self.library(),
            other => {
                if !OTHER_STATEMENTS.contains(&other) {
                    self.unknown.get_or_insert(self.scanner.line_number());
                    self.pass_over();
                    return Ok(());
                }
                self.pass_over();
            }
        }
        self.any_known = true;
        Ok(())
    }

    /// Skips a statement with its continuation lines.
    fn pass_over(&mut self) {
        while self.scanner.word_on_line().is_some() {}
    }

    fn vertex(&mut self) -> Result<()> {
        let mut values = [0.0; 6];
        let count = self.scanner.floats_on_line(&mut values, "a coordinate")?;
        let [x, y, z, r, g, b] = values;
        if count < 3 {
            return Err(self.scanner.error(format!("a vertex has only {count} of 3 coordinates")));
        }
        self.mesh.points.push(DVec3::new(x, y, z));
        if count == 6 {
            self.colors.push([r, g, b], self.mesh.points.len());
        }
        Ok(())
    }

    fn polygon(&mut self) -> Result<()> {
        self.corners()?;
        let line = self.scanner.line_number();
        if self.face.len() < 3 {
            self.short_faces.count(line);
            return Ok(());
        }
        self.mesh.faces.push_iter(self.face.iter().map(|c| c.vertex));
        for corner in &self.face {
            self.vertices.see(corner.vertex, line);
            self.uvs.corner(corner.uv, line);
            self.normals.corner(corner.normal, line);
        }
        self.names.iter_mut().for_each(FaceNames::face);
        Ok(())
    }

    fn polyline(&mut self) -> Result<()> {
        self.corners()?;
        for pair in self.face.array_windows::<2>() {
            let ends = [pair[0].vertex, pair[1].vertex];
            ends.iter().for_each(|&v| self.vertices.see(v, self.scanner.line_number()));
            self.mesh.edges.push(ends);
            self.mesh.edge_tags.push(0);
        }
        Ok(())
    }

    /// The corners on the rest of the line, into `face`: `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    fn corners(&mut self) -> Result<()> {
        self.face.clear();
        while let Some(word) = self.scanner.word_on_line() {
            let Some([vertex, uv, normal]) = split_corner(word) else {
                let what = format!("a corner (1, 1/2, 1//3 or 1/2/3) is expected, found '{}'", shown(word));
                return Err(self.scanner.error(what));
            };
            let Reference::To(vertex) = Reference::new(vertex, self.mesh.points.len()) else {
                return Err(self.scanner.error(format!(
                    "there is no vertex '{}': indices count from 1, or from -1 backwards over the {} vertices so far",
                    shown(word),
                    self.mesh.points.len()
                )));
            };
            let uv = Reference::new(uv, self.uvs.values.len());
            let normal = Reference::new(normal, self.normals.values.len());
            self.face.push(Corner { vertex, uv, normal });
        }
        Ok(())
    }

    fn name(&mut self, kind: usize) {
        let name = self.scanner.rest_of_line();
        self.names[kind].name(name.strip_suffix(b"\\").unwrap_or(name), self.mesh.faces.len());
    }

    fn library(&mut self) {
        let name = String::from_utf8_lossy(self.scanner.rest_of_line()).into_owned();
        for library in library::read_beside(self.source.path, &name, &mut self.mesh.notes) {
            let known = |other: &MaterialLibrary| other.name == library.name;
            if !self.mesh.attributes.libraries.iter().any(known) {
                self.mesh.attributes.libraries.push(library);
            }
        }
    }

    fn finish(self) -> Result<RawMesh> {
        let mut mesh = self.mesh;
        if let (false, Some(line)) = (self.any_known, self.unknown) {
            let what = "this does not look like OBJ: no line of the file has a statement of the format";
            return Err(self.source.error(Place::Line(line), what));
        }
        if let Some(vertex) = self.vertices.beyond(mesh.points.len()) {
            let what = format!("there is no vertex {}, the file has {}", u64::from(vertex) + 1, mesh.points.len());
            return Err(self.source.error(Place::Line(self.vertices.line), what));
        }
        let LeftOut { count, first_line } = self.short_faces;
        if count > 0 {
            let all = mesh.faces.len() as u64 + count;
            mesh.notes.push(format!(
                "left out {count} of {all} faces: they have fewer than 3 corners, the first at line {first_line}"
            ));
        }
        if let Some(colors) = self.colors.finish(mesh.points.len(), &mut mesh.notes) {
            mesh.attributes.vertex.insert("color".into(), Column::Color(colors));
        }
        let corners = mesh.faces.corners().len();
        if let Some(values) = self.uvs.finish(corners, "texture coordinates", &mut mesh.notes) {
            mesh.attributes.corner.insert("uv".into(), Column::Vector2(values));
        }
        if let Some(values) = self.normals.finish(corners, "normals", &mut mesh.notes) {
            mesh.attributes.corner.insert("normal".into(), Column::Vector3(values));
        }
        for (names, (_, column)) in self.names.into_iter().zip(NAMES) {
            names.store(column, &mut mesh.attributes);
        }
        library::color_materials(&mut mesh.attributes);
        Ok(mesh)
    }
}

/// Splits `1/2/3` into its numbers; `None` where something else stands there.
#[inline]
fn split_corner(word: &[u8]) -> Option<[Option<i64>; 3]> {
    if let Some(vertex) = parse_integer(word) {
        return Some([Some(vertex), None, None]);
    }
    let mut out = [None; 3];
    for (k, part) in word.split(|&b| b == b'/').enumerate() {
        let slot = out.get_mut(k)?;
        if !part.is_empty() {
            *slot = Some(parse_integer(part)?);
        }
    }
    out[0].is_some().then_some(out)
}
