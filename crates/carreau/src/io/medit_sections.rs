//! What the text form (`medit`) and the binary form (`gmf`) of Medit meshes share: the keywords, how sections become a
//! mesh, and how a mesh becomes sections.
//!
//! Source: P. Frey, *MEDIT: an interactive mesh visualization software*, INRIA RT-0253 (2001); L. Maréchal, *Handling
//! unstructured meshes with the libMeshb library*. Ids in the files count from 1, every element ends with a reference
//! number.
//!
//! Corner orders are those of VTK (hexahedra: 1-2-3-4 below 5-6-7-8); of a prism, 1-2-3 is counter-clockwise seen from
//! 4-5-6. No corner is exchanged.
//!
//! What goes where in a [`RawMesh`]:
//!
//! | section | becomes |
//! |---|---|
//! | Vertices | `points` (z = 0 in dimension 2), vertex label `ref` |
//! | Triangles, Quadrilaterals | `faces` in file order, face label `ref` |
//! | Edges | `edges`, `edge_tags` |
//! | Tetrahedra, Hexahedra, Prisms, Pyramids | `cells` with `tags` |
//! | Corners, RequiredVertices | vertex labels `corner`, `required`: 1 where listed |
//! | Ridges, RequiredEdges | checked, not kept: every edge of a file counts as marked; a note says so |
//!
//! Labels that are zero everywhere are not kept. Anything else is skipped and noted.

use super::limits::words_left_out;
use super::medit_keywords::{Keyword, Kind};
use super::small_faces::{SmallFaces, face_references, keep_label, label, warn_unheld};
use super::source::Source;
use crate::error::{Error, Place, Result};
use crate::mesh::{Cells, RawMesh};
use glam::DVec3;
use std::borrow::Cow;

/// Where the rows of a section come from: words of a text or binary numbers.
pub(super) trait Numbers {
    fn index(&mut self) -> Result<i64>;
    fn reference(&mut self) -> Result<i64>;
    fn coordinate(&mut self) -> Result<f64>;
    fn error(&self, what: String) -> Error;
}

/// A section as read, its indices counted from 0 and not yet checked against what they refer to.
pub(super) struct Section {
    keyword: &'static Keyword,
    /// Byte offset of its first row.
    start: usize,
    indices: Vec<u32>,
    references: Vec<i32>,
}

/// Everything read from a file.
#[derive(Default)]
pub(super) struct Contents {
    vertices: Option<(Vec<DVec3>, Vec<i32>)>,
    sections: Vec<Section>,
    /// Names of the sections that were skipped.
    pub skipped: Vec<String>,
    /// References beyond 32 bits.
    unheld_references: usize,
    /// Whether the keyword `End` was met.
    pub ended: bool,
}

impl Contents {
    /// Reads the rows of `Vertices`; `count` has been checked against the size of the file.
    pub fn read_vertices(&mut self, numbers: &mut impl Numbers, dimension: usize, count: usize) -> Result<()> {
        if self.vertices.is_some() {
            return Err(numbers.error("this is a second section Vertices".into()));
        }
        let (mut points, mut references) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for _ in 0..count {
            let (x, y) = (numbers.coordinate()?, numbers.coordinate()?);
            let z = if dimension == 3 { numbers.coordinate()? } else { 0.0 };
            points.push(DVec3::new(x, y, z));
            references.push(self.read_reference(numbers)?);
        }
        self.vertices = Some((points, references));
        Ok(())
    }

    /// Reads the rows of a section that starts at byte `start`; `count` has been checked against the size of the file.
    pub fn read_section(
        &mut self,
        numbers: &mut impl Numbers,
        keyword: &'static Keyword,
        start: usize,
        count: usize,
    ) -> Result<()> {
        let mut indices = Vec::with_capacity(count * keyword.indices);
        let mut references = Vec::with_capacity(if keyword.reference { count } else { 0 });
        for _ in 0..count {
            for _ in 0..keyword.indices {
                let index = numbers.index()?;
                match u32::try_from(index.saturating_sub(1)) {
                    Ok(k) if k < u32::MAX => indices.push(k),
                    _ => {
                        return Err(
                            numbers.error(format!("{}: {index} is not an index (indices start at 1)", keyword.name()))
                        );
                    }
                }
            }
            if keyword.reference {
                references.push(self.read_reference(numbers)?);
            }
        }
        self.sections.push(Section { keyword, start, indices, references });
        Ok(())
    }

    fn read_reference(&mut self, numbers: &mut impl Numbers) -> Result<i32> {
        let reference = numbers.reference()?;
        Ok(i32::try_from(reference).unwrap_or_else(|_| {
            self.unheld_references += 1;
            0
        }))
    }

    /// The mesh. `place` tells where the n-th number behind a byte offset stands.
    pub fn into_mesh(mut self, source: &Source, place: impl Fn(usize, usize) -> Place) -> Result<RawMesh> {
        let Some((points, references)) = self.vertices.take() else {
            return Err(source.error(Place::File, "there is no section Vertices; the file may be cut"));
        };
        self.check(points.len(), source, place)?;
        let mut mesh = RawMesh { points, ..RawMesh::default() };
        keep_label(&mut mesh.attributes.vertex, "ref", references);
        self.mark_vertices(&mut mesh, Kind::Corners, "corner");
        self.mark_vertices(&mut mesh, Kind::RequiredVertices, "required");
        self.add_faces(&mut mesh);
        mesh.edges = self.rows(Kind::Edges);
        mesh.edge_tags = self.references(Kind::Edges);
        mesh.cells = self.cells();
        mesh.notes = self.notes();
        Ok(mesh)
    }

    /// Every index must exist.
    fn check(&self, vertices: usize, source: &Source, place: impl Fn(usize, usize) -> Place) -> Result<()> {
        let edges = self.of_kind(Kind::Edges).map(|s| s.references.len()).sum();
        for section in &self.sections {
            let keyword = section.keyword;
            let (what, limit) = match keyword.kind {
                Kind::Ridges | Kind::RequiredEdges => ("edge", edges),
                _ => ("vertex", vertices),
            };
            if let Some(k) = section.indices.iter().position(|&v| v as usize >= limit) {
                let (row, column) = (k / keyword.indices, k % keyword.indices);
                let at = place(section.start, row * keyword.width() + column);
                let (name, index) = (keyword.name(), u64::from(section.indices[k]) + 1);
                let message = format!("{name}, row {}: {what} {index} does not exist, there are {limit}", row + 1);
                return Err(source.error(at, message));
            }
        }
        Ok(())
    }

    fn of_kind(&self, kind: Kind) -> impl Iterator<Item = &Section> {
        self.sections.iter().filter(move |s| s.keyword.kind == kind)
    }

    fn rows<const N: usize>(&self, kind: Kind) -> Vec<[u32; N]> {
        self.of_kind(kind).flat_map(|s| s.indices.as_chunks::<N>().0).copied().collect()
    }

    fn references(&self, kind: Kind) -> Vec<i32> {
        self.of_kind(kind).flat_map(|s| &s.references).copied().collect()
    }

    fn mark_vertices(&self, mesh: &mut RawMesh, kind: Kind, name: &str) {
        let mut marks = vec![0; mesh.points.len()];
        for &v in self.of_kind(kind).flat_map(|s| &s.indices) {
            marks[v as usize] = 1;
        }
        keep_label(&mut mesh.attributes.vertex, name, marks);
    }

    fn add_faces(&self, mesh: &mut RawMesh) {
        let is_face = |s: &&Section| matches!(s.keyword.kind, Kind::Triangles | Kind::Quadrilaterals);
        let mut references = Vec::new();
        for section in self.sections.iter().filter(is_face) {
            mesh.faces.reserve(section.references.len(), section.indices.len());
            section.indices.chunks_exact(section.keyword.indices).for_each(|face| mesh.faces.push(face));
            references.extend_from_slice(&section.references);
        }
        keep_label(&mut mesh.attributes.face, "ref", references);
    }

    fn cells(&self) -> Cells {
        let order = [Kind::Tetrahedra, Kind::Hexahedra, Kind::Prisms, Kind::Pyramids];
        let mut tags: Vec<i32> = order.into_iter().flat_map(|kind| self.references(kind)).collect();
        if tags.iter().all(|&t| t == 0) {
            tags.clear();
        }
        Cells {
            tets: self.rows(Kind::Tetrahedra),
            hexes: self.rows(Kind::Hexahedra),
            wedges: self.rows(Kind::Prisms),
            pyramids: self.rows(Kind::Pyramids),
            tags,
        }
    }

    fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        for kind in [Kind::Ridges, Kind::RequiredEdges] {
            let listed: usize = self.of_kind(kind).map(|s| s.indices.len()).sum();
            if listed > 0 {
                let name = Keyword::of(kind).name();
                notes.push(format!("{name} ({listed}): all edges are kept with their references, this mark is not"));
            }
        }
        if !self.skipped.is_empty() {
            notes.push(format!("sections left out: {}", self.skipped.join(", ")));
        }
        if self.unheld_references > 0 {
            notes.push(format!("{} references do not fit 32 bits and became 0", self.unheld_references));
        }
        if !self.ended {
            notes.push("the keyword End is missing: the file may be cut".into());
        }
        notes
    }
}

/// A section to be written; indices count from 0.
pub(super) struct Block<'a> {
    pub keyword: &'static Keyword,
    pub indices: Cow<'a, [u32]>,
    /// One per row, missing ones are 0; none where the keyword has no reference.
    references: Cow<'a, [i32]>,
}

impl Block<'_> {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.indices.len() / self.keyword.indices
    }

    /// Indices and reference number of every row.
    pub fn rows(&self) -> impl Iterator<Item = (&[u32], Option<i32>)> {
        let reference = |row| self.references.get(row).copied().unwrap_or(0);
        let rows = self.indices.chunks_exact(self.keyword.indices).enumerate();
        rows.map(move |(row, indices)| (indices, self.keyword.reference.then(|| reference(row))))
    }
}

/// A mesh as Medit sees it.
pub(super) struct Sections<'a> {
    points: &'a [DVec3],
    references: &'a [i32],
    pub blocks: Vec<Block<'a>>,
    pub warnings: Vec<String>,
}

impl<'a> Sections<'a> {
    /// All sections of a mesh that are not empty, and warnings about what they cannot hold.
    pub fn of(mesh: &'a RawMesh) -> Self {
        const FORMAT: &str = "Medit";
        let (mut blocks, mut warnings) = (Vec::new(), Vec::new());
        let columns = &mesh.attributes;
        add(&mut blocks, Kind::Corners, marked(label(&columns.vertex, "corner")), Cow::Borrowed(&[]));
        add(&mut blocks, Kind::RequiredVertices, marked(label(&columns.vertex, "required")), Cow::Borrowed(&[]));
        add(&mut blocks, Kind::Edges, mesh.edges.as_flattened().into(), mesh.edge_tags.as_slice().into());
        let faces = SmallFaces::of(mesh, FORMAT, &mut warnings);
        let (reference_name, references) = face_references(mesh).unwrap_or(("ref", &[]));
        add_faces(&mut blocks, &faces, &faces.values(references), &mut warnings);
        add_cells(&mut blocks, &mesh.cells);
        warn_unheld(mesh, FORMAT, &["ref", "corner", "required"], &[reference_name], &mut warnings);
        warnings.extend(words_left_out(FORMAT, mesh, |_| false, |_| false));
        Sections { points: &mesh.points, references: label(&columns.vertex, "ref").unwrap_or(&[]), blocks, warnings }
    }

    /// Number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.points.len()
    }

    /// Position and reference number of every vertex.
    pub fn vertices(&self) -> impl Iterator<Item = (DVec3, i32)> {
        self.points.iter().copied().zip(self.references.iter().copied().chain(std::iter::repeat(0)))
    }
}

fn add<'a>(blocks: &mut Vec<Block<'a>>, kind: Kind, indices: Cow<'a, [u32]>, references: Cow<'a, [i32]>) {
    if !indices.is_empty() {
        blocks.push(Block { keyword: Keyword::of(kind), indices, references });
    }
}

fn marked(marks: Option<&[i32]>) -> Cow<'static, [u32]> {
    let marks = (0u32..).zip(marks.unwrap_or(&[]));
    marks.filter(|&(_, &mark)| mark != 0).map(|(v, _)| v).collect()
}

/// One section per size of face. The size of the first face goes first, so that a file read and written again keeps its
/// order.
fn add_faces(blocks: &mut Vec<Block>, faces: &SmallFaces, references: &[i32], warnings: &mut Vec<String>) {
    let quads_first = faces.faces.iter().next().is_some_and(|f| f.len() == 4);
    let order = if quads_first { [4, 3] } else { [3, 4] };
    for size in order {
        let (mut indices, mut kept) = (Vec::new(), Vec::new());
        let references = references.iter().copied().chain(std::iter::repeat(0));
        for (face, reference) in faces.faces.iter().zip(references).filter(|(f, _)| f.len() == size) {
            indices.extend_from_slice(face);
            kept.push(reference);
        }
        let kind = if size == 3 { Kind::Triangles } else { Kind::Quadrilaterals };
        add(blocks, kind, indices.into(), kept.into());
    }
    if !faces.faces.iter().is_sorted_by_key(|f| f.len() != order[0]) {
        warnings.push("Medit lists triangles and quads apart: the order of the faces has changed".into());
    }
}

fn add_cells<'a>(blocks: &mut Vec<Block<'a>>, cells: &'a Cells) {
    let mut tags = cells.tags.as_slice();
    let mut add_kind = |kind, indices: &'a [u32]| {
        let count = indices.len() / Keyword::of(kind).indices;
        let (own, rest) = tags.split_at(count.min(tags.len()));
        tags = rest;
        add(blocks, kind, indices.into(), own.into());
    };
    add_kind(Kind::Tetrahedra, cells.tets.as_flattened());
    add_kind(Kind::Hexahedra, cells.hexes.as_flattened());
    add_kind(Kind::Prisms, cells.wedges.as_flattened());
    add_kind(Kind::Pyramids, cells.pyramids.as_flattened());
}
