//! Writes version 4.1: all nodes in one block, elements in one block per run of the same entity and type.
//!
//! Elements keep their order, which costs more than one block per entity where references alternate. Every reference
//! number becomes an entity with that physical tag; where the faces have a label `entity` that numbers parts of one
//! reference each, its numbers are the entities' own. Vertices with a reference become point elements.

use super::collector::NAMED_LABELS;
use super::elements::{HEX27, Shape};
use crate::io::limits::words_left_out;
use crate::io::small_faces::{COUNTED_FROM_ZERO, SmallFaces, face_references, label, warn_unheld};
use crate::io::text::{push_float, push_integer};
use crate::mesh::{Cells, RawMesh, SecondOrder};
use glam::DVec3;
use rustc_hash::FxHashMap;
use std::ops::Range;

/// Gmsh reads no longer names.
const LONGEST_NAME: usize = 127;

pub(super) fn write(mesh: &RawMesh, ascii: bool, out: &mut Vec<u8>) -> Vec<String> {
    const FORMAT: &str = "MSH";
    let mut warnings = Vec::new();
    let faces = SmallFaces::of(mesh, FORMAT, &mut warnings);
    let (reference_name, references) = face_references(mesh).unwrap_or(("ref", &[]));
    let shift = shift(reference_name, references);
    let references = &references.iter().map(|&r| r.saturating_add(shift)).collect::<Vec<i32>>();
    let entity_label = label(&mesh.attributes.face, "entity");
    let mut model = Model::default();
    model.add_points(label(&mesh.attributes.vertex, "ref").unwrap_or(&[]));
    model.add_lines(mesh);
    match &mesh.second_order {
        Some(nodes) => model.add_second_order(mesh, nodes, references),
        None => {
            model.add_faces(&faces, &faces.values(references), entity_label.map(|e| faces.values(e)).as_deref());
            model.add_cells(&mesh.cells);
        }
    }
    warn_unheld(mesh, FORMAT, &["ref"], &[reference_name, "entity"], &mut warnings);
    let names = physical_names(mesh, reference_name, shift);
    let named = |column: &str| dimension_of(column, reference_name).is_some();
    warnings.extend(words_left_out(FORMAT, mesh, named, |_| false));
    if shift != 0 {
        warnings.push(format!(
            "{FORMAT}: the face labels '{reference_name}' are written as physical groups that count from 1, each {shift} more"
        ));
    }
    if model.entities.iter().any(|e| e.physical < 0) {
        warnings.push("Gmsh takes a negative reference as the physical group of its absolute value, reversed".into());
    }
    Output { out, ascii }.file(&mesh.points, &model, &names);
    warnings
}

/// Elements of one type on one entity, one after the other.
struct Block {
    /// Index in `entities`.
    entity: usize,
    shape: Shape,
    /// Where its first element starts in `corners`.
    first: usize,
    /// Number of elements.
    len: usize,
}

/// What the elements lie on.
struct Entity {
    dimension: i32,
    tag: i32,
    physical: i32,
}

/// All elements, dimensions ascending.
#[derive(Default)]
struct Model {
    entities: Vec<Entity>,
    blocks: Vec<Block>,
    /// Vertices of all elements of all blocks.
    corners: Vec<u32>,
}

/// What an element is grouped by: reference, entity label (0 where there is none), type.
type Key = (i32, i32, Shape);

impl Model {
    /// Adds all elements of one dimension: a block for every run of the same key, so that elements keep their order,
    /// and an entity for every reference and label, in order of their first element.
    fn add<'e>(&mut self, elements: impl Iterator<Item = (Key, &'e [u32])>) {
        let first_entity = self.entities.len();
        let mut entity_of: FxHashMap<(i32, i32), usize> = FxHashMap::default();
        let mut last = None;
        for (key, corners) in elements {
            if last.replace(key) != Some(key) {
                let (physical, label, shape) = key;
                let entity = *entity_of.entry((physical, label)).or_insert_with(|| {
                    self.entities.push(Entity { dimension: shape.dimension(), tag: label, physical });
                    self.entities.len() - 1
                });
                self.blocks.push(Block { entity, shape, first: self.corners.len(), len: 0 });
            }
            self.corners.extend_from_slice(corners);
            self.blocks.last_mut().into_iter().for_each(|block| block.len += 1);
        }
        number_entities(&mut self.entities[first_entity..]);
    }

    fn add_points(&mut self, references: &[i32]) {
        let ids: Vec<u32> = (0..references.len() as u32).collect();
        let marked = references.iter().zip(&ids).filter(|&(&reference, _)| reference != 0);
        self.add(marked.map(|(&reference, id)| ((reference, 0, Shape::Point), std::slice::from_ref(id))));
    }

    fn add_lines(&mut self, mesh: &RawMesh) {
        let tags = mesh.edge_tags.iter().copied().chain(std::iter::repeat(0));
        self.add(mesh.edges.iter().zip(tags).map(|(edge, tag)| ((tag, 0, Shape::Line), &edge[..])));
    }

    fn add_faces(&mut self, faces: &SmallFaces, references: &[i32], entities: Option<&[i32]>) {
        let value = |list: &[i32], f: usize| list.get(f).copied().unwrap_or(0);
        let key = |f: usize, corners: &[u32]| {
            let shape = if corners.len() == 3 { Shape::Triangle } else { Shape::Quad };
            (value(references, f), value(entities.unwrap_or(&[]), f), shape)
        };
        self.add(faces.faces.iter().enumerate().map(|(f, corners)| (key(f, corners), corners)));
    }

    /// The faces and cells of a mesh of second order.
    fn add_second_order(&mut self, mesh: &RawMesh, nodes: &SecondOrder, references: &[i32]) {
        let value = |list: &[i32], k: usize| list.get(k).copied().unwrap_or(0);
        let of_faces = mesh.faces.iter().zip(&nodes.quads).map(|(face, middles)| [face, &middles[..]].concat());
        let faces: Vec<Vec<u32>> = of_faces.collect();
        self.add(faces.iter().enumerate().map(|(f, all)| ((value(references, f), 0, Shape::Quad9), &all[..])));
        let of_cells = mesh.cells.hexes.iter().zip(&nodes.hexes);
        let cells: Vec<[u32; 27]> =
            of_cells.map(|(cell, middles)| HEX27.map(|n| if n < 8 { cell[n] } else { middles[n - 8] })).collect();
        let tags = &mesh.cells.tags;
        self.add(cells.iter().enumerate().map(|(h, all)| ((value(tags, h), 0, Shape::Hex27), &all[..])));
    }

    fn add_cells(&mut self, cells: &Cells) {
        let tags = |range: Range<usize>| range.map(|k| cells.tags.get(k).copied().unwrap_or(0));
        let kinds = [
            (Shape::Tet, cells.tets.as_flattened()),
            (Shape::Hex, cells.hexes.as_flattened()),
            (Shape::Wedge, cells.wedges.as_flattened()),
            (Shape::Pyramid, cells.pyramids.as_flattened()),
        ];
        let mut first = 0;
        let all = kinds.into_iter().flat_map(|(shape, corners)| {
            let count = corners.len() / shape.corners();
            first += count;
            let tagged = tags(first - count..first).map(move |tag| (tag, 0, shape));
            tagged.zip(corners.chunks_exact(shape.corners()))
        });
        self.add(all);
    }

    /// Lower and upper corner of the box of every entity.
    fn boxes(&self, points: &[DVec3]) -> Vec<[DVec3; 2]> {
        let mut boxes = vec![[DVec3::INFINITY, DVec3::NEG_INFINITY]; self.entities.len()];
        for block in &self.blocks {
            let [low, high] = &mut boxes[block.entity];
            for p in self.corners_of(block).iter().filter_map(|&v| points.get(v as usize)) {
                *low = low.min(*p);
                *high = high.max(*p);
            }
        }
        boxes
    }

    fn corners_of(&self, block: &Block) -> &[u32] {
        let end = block.first + block.len * block.shape.corners();
        self.corners.get(block.first..end).unwrap_or_default()
    }

    fn element_count(&self) -> usize {
        self.blocks.iter().map(|block| block.len).sum()
    }
}

/// The labels are the tags where they can be: positive, each once. Otherwise 1, 2, 3 ….
fn number_entities(entities: &mut [Entity]) {
    let mut tags: Vec<i32> = entities.iter().map(|e| e.tag).collect();
    tags.sort_unstable();
    let usable = tags.first().is_some_and(|&t| t > 0) && tags.windows(2).all(|w| w[0] != w[1]);
    if !usable {
        (1..).zip(entities).for_each(|(tag, entity)| entity.tag = tag);
    }
}

/// What is added to labels that count from zero: physical group 0 is none.
fn shift(name: &str, labels: &[i32]) -> i32 {
    match labels.iter().min() {
        Some(&least) if least <= 0 && COUNTED_FROM_ZERO.contains(&name) => 1i32.saturating_sub(least),
        _ => 0,
    }
}

/// Dimension of the physical groups that a label becomes.
fn dimension_of(label: &str, reference_name: &str) -> Option<usize> {
    match label {
        _ if label == reference_name => Some(2),
        "ref" => None,
        _ => NAMED_LABELS.iter().position(|&name| name == label),
    }
}

/// Dimension, tag and name of the named references.
fn physical_names<'a>(mesh: &'a RawMesh, reference_name: &str, shift: i32) -> Vec<(usize, i32, &'a str)> {
    let names = mesh.attributes.names.iter();
    let named = |((label, tag), name): (&(String, i32), &'a String)| {
        let dimension = dimension_of(label, reference_name)?;
        let shift = if label == reference_name { shift } else { 0 };
        Some((dimension, tag.saturating_add(shift), name.as_str()))
    };
    let mut names: Vec<_> = names.filter_map(named).collect();
    names.sort_unstable();
    names
}

/// The file in the making. In text, numbers of a row are separated by blanks.
struct Output<'a> {
    out: &'a mut Vec<u8>,
    ascii: bool,
}

impl Output<'_> {
    fn file(&mut self, points: &[DVec3], model: &Model, names: &[(usize, i32, &str)]) {
        self.line("$MeshFormat");
        self.line(if self.ascii { "4.1 0 8" } else { "4.1 1 8" });
        if !self.ascii {
            self.int(1);
            self.end_row();
            self.out.push(b'\n');
        }
        self.line("$EndMeshFormat");
        if !names.is_empty() {
            self.physical_names(names);
        }
        if !model.entities.is_empty() {
            self.section("Entities", |o| o.entities(points, model));
        }
        self.section("Nodes", |o| o.nodes(points, model));
        self.section("Elements", |o| o.elements(model));
    }

    fn section(&mut self, name: &str, content: impl FnOnce(&mut Self)) {
        self.line(&format!("${name}"));
        content(self);
        if !self.ascii {
            self.out.push(b'\n');
        }
        self.line(&format!("$End{name}"));
    }

    fn physical_names(&mut self, names: &[(usize, i32, &str)]) {
        self.line("$PhysicalNames");
        self.line(&names.len().to_string());
        for (dimension, tag, name) in names {
            let clean = |c: char| {
                if c == '"' {
                    '\''
                } else if c.is_control() {
                    ' '
                } else {
                    c
                }
            };
            let mut name: String = name.chars().map(clean).collect();
            name.truncate(name.floor_char_boundary(LONGEST_NAME));
            self.line(&format!("{dimension} {tag} \"{name}\""));
        }
        self.line("$EndPhysicalNames");
    }

    fn entities(&mut self, points: &[DVec3], model: &Model) {
        for dimension in 0..4 {
            self.size(model.entities.iter().filter(|e| e.dimension == dimension).count());
        }
        self.end_row();
        // A tag is given to all or to none: readers take the lists of tags as a column.
        let tagged = model.entities.iter().any(|e| e.physical != 0);
        for (entity, [low, high]) in model.entities.iter().zip(model.boxes(points)) {
            self.int(entity.tag);
            self.point(low);
            if entity.dimension > 0 {
                self.point(high);
            }
            self.size(usize::from(tagged));
            if tagged {
                self.int(entity.physical);
            }
            if entity.dimension > 0 {
                self.size(0);
            }
            self.end_row();
        }
    }

    /// One block, on the last entity: the one of highest dimension.
    fn nodes(&mut self, points: &[DVec3], model: &Model) {
        let (dimension, tag) = model.entities.last().map_or((0, 1), |e| (e.dimension, e.tag));
        let count = points.len();
        self.row([1, count, count.min(1), count]);
        self.ints([dimension, tag, 0]);
        self.size(count);
        self.end_row();
        for node in 1..=count {
            self.size(node);
            self.end_row();
        }
        for &p in points {
            self.point(p);
            self.end_row();
        }
    }

    fn elements(&mut self, model: &Model) {
        let count = model.element_count();
        self.row([model.blocks.len(), count, count.min(1), count]);
        let mut element = 0;
        for block in &model.blocks {
            let Some(entity) = model.entities.get(block.entity) else { continue };
            self.ints([entity.dimension, entity.tag, block.shape.code()]);
            self.size(block.len);
            self.end_row();
            for corners in model.corners_of(block).chunks_exact(block.shape.corners()) {
                element += 1;
                self.size(element);
                corners.iter().for_each(|&v| self.size(v as usize + 1));
                self.end_row();
            }
        }
    }

    fn line(&mut self, text: &str) {
        self.out.extend_from_slice(text.as_bytes());
        self.out.push(b'\n');
    }

    fn int(&mut self, k: i32) {
        if self.ascii {
            push_integer(self.out, k);
            self.out.push(b' ');
        } else {
            self.out.extend_from_slice(&k.to_le_bytes());
        }
    }

    fn ints(&mut self, numbers: [i32; 3]) {
        numbers.into_iter().for_each(|k| self.int(k));
    }

    fn size(&mut self, k: usize) {
        if self.ascii {
            push_integer(self.out, k);
            self.out.push(b' ');
        } else {
            self.out.extend_from_slice(&(k as u64).to_le_bytes());
        }
    }

    fn row(&mut self, sizes: [usize; 4]) {
        sizes.into_iter().for_each(|k| self.size(k));
        self.end_row();
    }

    fn point(&mut self, p: DVec3) {
        for x in p.to_array() {
            if self.ascii {
                push_float(self.out, x);
                self.out.push(b' ');
            } else {
                self.out.extend_from_slice(&x.to_le_bytes());
            }
        }
    }

    /// In text, the blank after the last number becomes the end of the line.
    fn end_row(&mut self) {
        if self.ascii
            && let Some(last) = self.out.last_mut()
        {
            *last = b'\n';
        }
    }
}
