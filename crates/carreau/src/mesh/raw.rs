//! The content of a mesh file, before any judgement: the common ground of all readers and writers.

use super::attributes::Attributes;
use super::id::VertexId;
use super::middle_nodes::SecondOrder;
use super::polygons::Polygons;
use super::surface::{SurfaceMesh, TaggedEdge};
use crate::error::{Error, Result};
use glam::DVec3;

/// Volume cells in VTK corner order.
///
/// ```text
///      7────6        4
///     ╱│   ╱│       ╱│╲        tetrahedron 0123: 0-1-2 counter-clockwise seen from 3
///    4────5 │      3─│─2       pyramid 01234: base 0-1-2-3, apex 4
///    │ 3──│─2     ╱  │ ╱       wedge 012345: triangles 0-1-2 and 3-4-5
///    │╱   │╱     0───1
///    0────1
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Cells {
    /// Tetrahedra.
    pub tets: Vec<[u32; 4]>,
    /// Hexahedra.
    pub hexes: Vec<[u32; 8]>,
    /// Wedges (triangular prisms).
    pub wedges: Vec<[u32; 6]>,
    /// Pyramids.
    pub pyramids: Vec<[u32; 5]>,
    /// The file's reference number of every cell, in the order tets, hexes, wedges, pyramids; empty where there are none.
    pub tags: Vec<i32>,
}

impl Cells {
    /// Number of cells of all kinds.
    pub fn len(&self) -> usize {
        self.tets.len() + self.hexes.len() + self.wedges.len() + self.pyramids.len()
    }

    /// Whether there is no cell.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Everything carreau keeps of a mesh file.
#[derive(Debug, Clone, Default)]
pub struct RawMesh {
    /// Vertex positions, in file order.
    pub points: Vec<DVec3>,
    /// Faces, in file order.
    pub faces: Polygons,
    /// Lines and marked edges, as vertex indices.
    pub edges: Vec<[u32; 2]>,
    /// The file's reference number of every edge; as long as `edges`.
    pub edge_tags: Vec<i32>,
    /// Volume cells.
    pub cells: Cells,
    /// The nodes of hexahedra of second order; then all cells are such, and all faces are their sides.
    pub second_order: Option<SecondOrder>,
    /// Named columns on `points` and `faces`.
    pub attributes: Attributes,
    /// What the reader left out or repaired, for the record's `warnings`.
    pub notes: Vec<String>,
}

impl RawMesh {
    /// Checks that all indices exist and all coordinates are finite; readers call it last.
    ///
    /// # Errors
    /// [`Error::Input`] for a coordinate that is not finite, an id that does not exist, or more
    /// corners than can be numbered.
    pub fn check(&self) -> Result<()> {
        let n = self.points.len();
        if !self.faces.fits() {
            return Err(Error::input(
                "the faces have more corners than a mesh can number (about four thousand million)",
                format!("{} faces", self.faces.len()),
                "split the file",
            ));
        }
        if let Some(v) = self.points.iter().position(|p| !p.is_finite()) {
            return Err(Error::input("a coordinate is not finite", format!("vertex {v}"), "remove it and its faces"));
        }
        let beyond = |what: &str, k: usize, list: &[u32]| match list.iter().find(|&&v| v as usize >= n) {
            Some(v) => Err(Error::input(
                format!("a {what} uses vertex {v} (0-based), there are {n} vertices"),
                format!("{what} {k}"),
                "",
            )),
            None => Ok(()),
        };
        self.faces.iter().enumerate().try_for_each(|(k, f)| beyond("face", k, f))?;
        self.edges.iter().enumerate().try_for_each(|(k, e)| beyond("edge", k, e))?;
        self.cells.tets.iter().enumerate().try_for_each(|(k, c)| beyond("tetrahedron", k, c))?;
        self.cells.hexes.iter().enumerate().try_for_each(|(k, c)| beyond("hexahedron", k, c))?;
        self.cells.wedges.iter().enumerate().try_for_each(|(k, c)| beyond("wedge", k, c))?;
        self.cells.pyramids.iter().enumerate().try_for_each(|(k, c)| beyond("pyramid", k, c))?;
        let Some(nodes) = &self.second_order else { return Ok(()) };
        let counts = [nodes.hexes.len(), nodes.quads.len()];
        if counts != [self.cells.len(), self.faces.len()] || self.cells.hexes.len() != self.cells.len() {
            return Err(Error::input("not all cells and faces have nodes of second order", "", ""));
        }
        nodes.hexes.iter().enumerate().try_for_each(|(k, c)| beyond("hexahedron", k, c))?;
        nodes.quads.iter().enumerate().try_for_each(|(k, c)| beyond("face", k, c))
    }

    /// The surface in the file. A file with volume cells is refused: its surface has to be asked for.
    ///
    /// # Errors
    /// [`Error::Input`] for a mesh with volume cells, and as [`SurfaceMesh::new`].
    pub fn into_surface(self) -> Result<SurfaceMesh> {
        if !self.cells.is_empty() {
            return Err(Error::input(
                format!("this is a volume mesh ({} cells), a surface is expected", self.cells.len()),
                "",
                "extract its boundary first with `carreau convert --boundary`",
            ));
        }
        let tags = self.edge_tags.iter().copied().chain(std::iter::repeat(0));
        let tagged_edges =
            self.edges.iter().zip(tags).map(|(e, tag)| TaggedEdge { ends: e.map(VertexId), tag }).collect();
        let mut mesh = SurfaceMesh::new(self.points, self.faces)?;
        mesh.attributes = self.attributes;
        mesh.tagged_edges = tagged_edges;
        Ok(mesh)
    }
}

impl From<SurfaceMesh> for RawMesh {
    fn from(mesh: SurfaceMesh) -> Self {
        let (points, faces, attributes, tagged) = mesh.into_parts();
        RawMesh {
            points,
            faces,
            edges: tagged.iter().map(|e| e.ends.map(|v| v.0)).collect(),
            edge_tags: tagged.iter().map(|e| e.tag).collect(),
            attributes,
            ..RawMesh::default()
        }
    }
}
