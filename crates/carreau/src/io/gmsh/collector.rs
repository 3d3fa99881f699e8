//! Elements of a Gmsh file, of either version, on their way to a [`RawMesh`].

use super::elements::{ElementType, Shape};
use super::nodes::NodeIndex;
use crate::io::limits::note_higher_order;
use crate::io::small_faces::keep_label;
use crate::io::text::shown;
use crate::mesh::{Cells, Polygons, RawMesh};
use crate::words::counted;
use glam::DVec3;
use rustc_hash::FxHashMap;

/// The tags of an element: physical group and elementary entity, 0 where there is none.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Tags {
    pub physical: i32,
    pub entity: i32,
}

/// The names of labels, by dimension.
pub(super) const NAMED_LABELS: [&str; 4] = ["vertex", "edge", "ref", "cell"];

/// What has been read so far.
#[derive(Default)]
pub(super) struct Collector {
    /// First physical tag of every entity, by dimension and tag.
    pub entities: FxHashMap<(i32, i32), i32>,
    /// Vertices, in file order.
    pub points: Vec<DVec3>,
    nodes: Option<NodeIndex>,
    has_elements: bool,
    vertex_references: Vec<(u32, i32)>,
    edges: Vec<[u32; 2]>,
    faces: Polygons,
    cells: Cells,
    tags: ElementTags,
    names: Vec<(usize, i32, String)>,
    skipped: Vec<String>,
    higher_order: usize,
    plain_points: usize,
    /// Remarks of the readers.
    pub notes: Vec<String>,
}

/// Tags of the elements, by what they become.
#[derive(Default)]
struct ElementTags {
    edges: Vec<Tags>,
    faces: Vec<Tags>,
    tets: Vec<Tags>,
    hexes: Vec<Tags>,
    wedges: Vec<Tags>,
    pyramids: Vec<Tags>,
}

impl Collector {
    pub fn has_nodes(&self) -> bool {
        self.nodes.is_some()
    }

    /// Ends the section of nodes: `tags[v]` is the tag of vertex `v`. The error says what is wrong.
    pub fn set_nodes(&mut self, tags: &[u64]) -> Result<(), String> {
        if tags.len() >= u32::MAX as usize {
            return Err(format!("{} nodes are more than 32 bits can number", tags.len()));
        }
        let index = NodeIndex::new(tags).map_err(|tag| format!("the node {tag} is defined twice"))?;
        self.nodes = Some(index);
        Ok(())
    }

    /// The vertex of a node.
    #[inline]
    pub fn vertex(&self, tag: u64) -> Option<u32> {
        self.nodes.as_ref().and_then(|nodes| nodes.vertex(tag))
    }

    pub fn has_elements(&self) -> bool {
        self.has_elements
    }

    /// Notes that a section of elements has been met.
    pub fn set_elements(&mut self) {
        self.has_elements = true;
    }

    /// Adds an element; `corners` are as many as its shape has.
    #[inline]
    pub fn add(&mut self, element: ElementType, corners: &[u32], tags: Tags) {
        self.higher_order += usize::from(element.nodes > corners.len());
        match (element.shape, corners) {
            (Shape::Point, &[v]) if tags.physical != 0 => self.vertex_references.push((v, tags.physical)),
            (Shape::Point, _) => self.plain_points += 1,
            (Shape::Line, _) => keep(&mut self.edges, &mut self.tags.edges, corners, tags),
            (Shape::Triangle | Shape::Quad, _) => {
                self.faces.push(corners);
                self.tags.faces.push(tags);
            }
            (Shape::Tet, _) => keep(&mut self.cells.tets, &mut self.tags.tets, corners, tags),
            (Shape::Hex, _) => keep(&mut self.cells.hexes, &mut self.tags.hexes, corners, tags),
            (Shape::Wedge, _) => keep(&mut self.cells.wedges, &mut self.tags.wedges, corners, tags),
            (Shape::Pyramid, _) => keep(&mut self.cells.pyramids, &mut self.tags.pyramids, corners, tags),
            // For the writer alone: read, they are a quad and a hexahedron with more nodes.
            (Shape::Quad9 | Shape::Hex27, _) => {}
        }
    }

    /// A physical name.
    pub fn name(&mut self, dimension: i32, tag: i32, name: &str) {
        self.names.push((dimension.clamp(0, 3) as usize, tag, name.to_string()));
    }

    /// A section that was skipped.
    pub fn skipped(&mut self, name: &[u8]) {
        let name = format!("${}", shown(name));
        if name != "$Comments" && !self.skipped.contains(&name) {
            self.skipped.push(name);
        }
    }

    /// The mesh. The error says what is missing.
    pub fn finish(mut self) -> Result<RawMesh, String> {
        if self.nodes.is_none() {
            return Err("there is no section $Nodes; the file may be cut".into());
        }
        if !self.has_elements {
            return Err("there is no section $Elements; the file may be cut".into());
        }
        let notes = self.final_notes();
        let mut mesh =
            RawMesh { points: self.points, faces: self.faces, edges: self.edges, notes, ..RawMesh::default() };
        let attributes = &mut mesh.attributes;
        let mut references = vec![0; mesh.points.len()];
        self.vertex_references.iter().for_each(|&(v, tag)| references[v as usize] = tag);
        keep_label(&mut attributes.vertex, "ref", references);
        keep_label(&mut attributes.face, "ref", self.tags.faces.iter().map(|t| t.physical).collect());
        if entities_are_finer(&self.tags.faces) {
            keep_label(&mut attributes.face, "entity", self.tags.faces.iter().map(|t| t.entity).collect());
        }
        for (dimension, tag, name) in self.names {
            attributes.names.insert((NAMED_LABELS[dimension].to_string(), tag), name);
        }
        mesh.edge_tags = self.tags.edges.iter().map(|t| t.physical).collect();
        mesh.cells = self.cells;
        let cell_tags = [&self.tags.tets, &self.tags.hexes, &self.tags.wedges, &self.tags.pyramids];
        if cell_tags.iter().any(|tags| tags.iter().any(|t| t.physical != 0)) {
            mesh.cells.tags = cell_tags.into_iter().flatten().map(|t| t.physical).collect();
        }
        note_higher_order(&mut mesh, self.higher_order);
        Ok(mesh)
    }

    fn final_notes(&mut self) -> Vec<String> {
        let mut notes = std::mem::take(&mut self.notes);
        if self.plain_points > 0 {
            let points = counted(self.plain_points, "point element", "point elements");
            notes.push(format!("{points} without a physical tag left out"));
        }
        if !self.skipped.is_empty() {
            notes.push(format!("sections left out: {}", self.skipped.join(", ")));
        }
        let cells = [&self.tags.tets, &self.tags.hexes, &self.tags.wedges, &self.tags.pyramids];
        if entities_are_finer(&self.tags.edges) || cells.into_iter().any(|tags| entities_are_finer(tags)) {
            notes.push("elementary entities of lines and cells were left out".into());
        }
        notes
    }
}

/// Appends a cell. The shape has told its number of corners; another number cannot come here.
#[inline]
fn keep<const N: usize>(cells: &mut Vec<[u32; N]>, all_tags: &mut Vec<Tags>, corners: &[u32], tags: Tags) {
    if let Ok(corners) = corners.try_into() {
        cells.push(corners);
        all_tags.push(tags);
    }
}

/// Whether two elements of the same physical group belong to different entities.
fn entities_are_finer(tags: &[Tags]) -> bool {
    let mut entity_of = FxHashMap::default();
    tags.iter().any(|t| *entity_of.entry(t.physical).or_insert(t.entity) != t.entity)
}
