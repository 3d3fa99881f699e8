//! The reader: the objects of the build, at their places, become one mesh.

use super::model::{Component, Look, Model, Object};
use super::package::{Package, parsed};
use super::words::{UNITS, text_of};
use crate::error::{Error, Place, Result};
use crate::io::names::FaceNames;
use crate::io::source::Source;
use crate::io::text::shown;
use crate::mesh::{Column, LengthUnit, RawMesh};
use glam::DMat4;
use std::collections::BTreeMap;

/// How deep components may be nested.
const DEEPEST: usize = 32;
/// Vertices and corners for each byte of the file: a file may use one object many times.
const USE_EXPANSION: usize = 64;

pub fn read(source: &Source) -> Result<RawMesh> {
    let mut package = Package::open(source)?;
    let start = package.model();
    let mut builder = Builder::new(source, package);
    let items = {
        let model = builder.model(&start)?;
        builder.unit.clone_from(&model.unit);
        std::mem::take(&mut builder.items)
    };
    for item in &items {
        builder.place(&start, item, DMat4::IDENTITY, 0)?;
    }
    if items.is_empty() {
        builder.notes.push("the file builds nothing: it has no items".into());
    }
    builder.finish()
}

struct Builder<'a> {
    source: &'a Source<'a>,
    package: Package<'a>,
    /// The parts that were read.
    models: BTreeMap<String, std::rc::Rc<Model>>,
    items: Vec<Component>,
    unit: String,
    mesh: RawMesh,
    objects: FaceNames,
    /// What every corner looks like, a number in `looks`; -1: nothing is said.
    looks_of: Vec<[i32; 3]>,
    looks: Vec<Look>,
    numbers: BTreeMap<(String, u32, u32), i32>,
    unread: usize,
    notes: Vec<String>,
    size: usize,
}

impl<'a> Builder<'a> {
    fn new(source: &'a Source<'a>, package: Package<'a>) -> Self {
        Builder {
            source,
            package,
            models: BTreeMap::new(),
            items: Vec::new(),
            unit: String::new(),
            mesh: RawMesh::default(),
            objects: FaceNames::new(""),
            looks_of: Vec::new(),
            looks: Vec::new(),
            numbers: BTreeMap::new(),
            unread: 0,
            notes: Vec::new(),
            size: 0,
        }
    }

    fn error(&self, what: impl Into<String>) -> Error {
        self.source.error(Place::File, what)
    }

    /// A part, read when it is first asked for.
    fn model(&mut self, part: &str) -> Result<std::rc::Rc<Model>> {
        if let Some(known) = self.models.get(part) {
            return Ok(std::rc::Rc::clone(known));
        }
        let text = self.package.part(part)?;
        let document = parsed(&text).map_err(|e| {
            let what = e.to_string().replace(char::is_control, "?");
            self.error(format!("part '{}' is not well-formed XML: {what}", shown(part.as_bytes())))
        })?;
        let mut model = Model::of(self.source, part, &document)?;
        self.unread += model.unread_groups;
        if self.models.is_empty() {
            self.items = std::mem::take(&mut model.items);
        }
        let model = std::rc::Rc::new(model);
        self.models.insert(part.to_string(), std::rc::Rc::clone(&model));
        Ok(model)
    }

    /// Adds an object of a part, with the objects that it is made of.
    fn place(&mut self, part: &str, of: &Component, outer: DMat4, depth: usize) -> Result<()> {
        if depth > DEEPEST {
            return Err(self.error(format!("objects are nested more than {DEEPEST} deep, or in themselves")));
        }
        let part = of.path.as_deref().unwrap_or(part);
        let model = self.model(part)?;
        let Some(object) = model.objects.get(&of.object) else {
            return Err(self.error(format!("object {} does not exist in '{}'", of.object, shown(part.as_bytes()))));
        };
        let transform = outer * of.transform;
        self.add(part, &model, object, of.object, transform)?;
        for component in &object.components {
            self.size += 1;
            self.place(part, component, transform, depth + 1)?;
            self.check_size()?;
        }
        Ok(())
    }

    fn add(&mut self, part: &str, model: &Model, object: &Object, id: u32, transform: DMat4) -> Result<()> {
        self.size += object.vertices.len() + 3 * object.triangles.len();
        self.check_size()?;
        if object.triangles.is_empty() && object.vertices.is_empty() {
            return Ok(());
        }
        let name = if object.name.is_empty() { format!("object_{id}") } else { object.name.clone() };
        self.objects.name(name.as_bytes(), self.mesh.faces.len());
        let first = self.mesh.points.len() as u32;
        let still = transform == DMat4::IDENTITY;
        let placed = |p: &glam::DVec3| if still { *p } else { transform.transform_point3(*p) };
        self.mesh.points.extend(object.vertices.iter().map(placed));
        // A transform that mirrors turns the sense of the triangles over.
        let mirrored = transform.determinant() < 0.0;
        for triangle in &object.triangles {
            let [a, b, c] = triangle.corners.map(|v| first + v);
            self.mesh.faces.push(&if mirrored { [a, c, b] } else { [a, b, c] });
            self.objects.face();
            let look = triangle
                .look
                .map_or([-1; 3], |(group, members)| members.map(|member| self.number(part, model, group, member)));
            let [a, b, c] = look;
            self.looks_of.push(if mirrored { [a, c, b] } else { look });
        }
        Ok(())
    }

    /// The number of a member of a group; -1 where it does not exist or says nothing.
    fn number(&mut self, part: &str, model: &Model, group: u32, member: u32) -> i32 {
        let Some(look) = model.groups.get(&group).and_then(|looks| looks.get(member as usize)) else { return -1 };
        let next = self.looks.len() as i32;
        let number = *self.numbers.entry((part.to_string(), group, member)).or_insert(next);
        if number == next {
            self.looks.push(look.clone());
        }
        number
    }

    fn check_size(&self) -> Result<()> {
        let most = self.source.bytes.len().saturating_mul(USE_EXPANSION).min(u32::MAX as usize / 3);
        if self.size <= most {
            return Ok(());
        }
        Err(self.error("used many times, its objects make up more than a file of this size can mean"))
    }

    fn finish(self) -> Result<RawMesh> {
        let mut mesh = self.mesh;
        mesh.notes = self.notes;
        if self.unread > 0 {
            mesh.notes.push("textures and mixed materials are left out".into());
        }
        let unit = UNITS.iter().find(|(name, _)| *name == self.unit).map(|&(_, unit)| unit);
        match unit {
            None => mesh.notes.push(format!("the unit '{}' is not known", shown(self.unit.as_bytes()))),
            Some(LengthUnit::Millimeter) => {}
            Some(_) => {
                mesh.notes.push(format!("lengths are in the unit of the file: {}; numbers stay as they are", self.unit))
            }
        }
        let attributes = &mut mesh.attributes;
        attributes.unit = unit;
        match self.objects.only() {
            None => self.objects.store("object", attributes),
            Some(only) => drop(attributes.names.insert(("object".into(), 0), only)),
        }
        let code = |look: &Look| look.color.map(text_of);
        let is_color = |look: &Look| look.name.is_none() || look.name == code(look);
        if self.looks.is_empty() {
            return Ok(mesh);
        }
        if self.looks.iter().all(is_color) {
            // What nothing is said of is white.
            let color = |k: i32| usize::try_from(k).ok().and_then(|k| self.looks[k].color).unwrap_or([u8::MAX; 4]);
            if self.looks_of.iter().all(|[a, b, c]| a == b && b == c) {
                attributes
                    .face
                    .insert("color".into(), Column::Color(self.looks_of.iter().map(|l| color(l[0])).collect()));
            } else {
                let corners = self.looks_of.as_flattened().iter().map(|&k| color(k)).collect();
                attributes.corner.insert("color".into(), Column::Color(corners));
            }
            return Ok(mesh);
        }
        attributes.face.insert("material".into(), Column::Label(self.looks_of.iter().map(|l| l[0]).collect()));
        for (look, k) in self.looks.iter().zip(0..) {
            let key = ("material".to_string(), k);
            let name = look.name.clone().or_else(|| code(look)).unwrap_or_else(|| format!("material_{k}"));
            attributes.names.insert(key.clone(), name);
            attributes.colors.extend(look.color.map(|color| (key, color)));
        }
        Ok(mesh)
    }
}
