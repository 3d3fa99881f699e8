//! The XML of a model part: objects, the groups that colour them, the build.

use super::words::color_of;
use crate::error::{Error, Place, Result};
use crate::io::source::Source;
use crate::io::text::{parse_float, shown};
use glam::{DMat4, DVec3};
use roxmltree::{Document, Node};
use std::collections::BTreeMap;

/// A member of a group of properties: what a triangle refers to.
#[derive(Debug, Clone, PartialEq)]
pub struct Look {
    /// Of a material; colours have none.
    pub name: Option<String>,
    pub color: Option<[u8; 4]>,
}

/// A triangle with what colours its corners: a group and three members.
pub struct Triangle {
    pub corners: [u32; 3],
    pub look: Option<(u32, [u32; 3])>,
}

/// An object that an object is made of.
pub struct Component {
    /// Another part of the package.
    pub path: Option<String>,
    pub object: u32,
    pub transform: DMat4,
}

/// A mesh, or components.
pub struct Object {
    pub name: String,
    pub vertices: Vec<DVec3>,
    pub triangles: Vec<Triangle>,
    pub components: Vec<Component>,
}

/// What a part holds.
#[derive(Default)]
pub struct Model {
    pub unit: String,
    pub objects: BTreeMap<u32, Object>,
    pub groups: BTreeMap<u32, Vec<Look>>,
    pub items: Vec<Component>,
    /// Groups of textures and composites, which are not read.
    pub unread_groups: usize,
}

impl Model {
    pub fn of(source: &Source, part: &str, document: &Document) -> Result<Self> {
        let reader = Reader { source, part };
        let root = document.root_element();
        if root.tag_name().name() != "model" {
            return Err(reader.error(root, "a <model> is expected"));
        }
        let mut model = Model { unit: root.attribute("unit").unwrap_or("millimeter").into(), ..Model::default() };
        for resources in children(root, "resources") {
            for node in resources.children().filter(Node::is_element) {
                match node.tag_name().name() {
                    "object" => {
                        let (id, object) = reader.object(node)?;
                        if model.objects.insert(id, object).is_some() {
                            return Err(reader.error(node, &format!("a second object {id}")));
                        }
                    }
                    "basematerials" | "colorgroup" => {
                        model.groups.insert(reader.number(node, "id")?, looks(node));
                    }
                    "texture2dgroup" | "compositematerials" | "multiproperties" => model.unread_groups += 1,
                    _ => {}
                }
            }
        }
        for build in children(root, "build") {
            for item in children(build, "item") {
                model.items.push(reader.component(item)?);
            }
        }
        Ok(model)
    }
}

fn children<'a>(node: Node<'a, 'a>, name: &'static str) -> impl Iterator<Item = Node<'a, 'a>> {
    node.children().filter(move |child| child.tag_name().name() == name)
}

/// The members of a group.
fn looks(group: Node) -> Vec<Look> {
    let member = |node: Node| match node.tag_name().name() {
        "base" => Some(Look {
            name: Some(node.attribute("name").unwrap_or_default().to_string()),
            color: node.attribute("displaycolor").and_then(color_of),
        }),
        "color" => Some(Look { name: None, color: node.attribute("color").and_then(color_of) }),
        _ => None,
    };
    group.children().filter_map(member).collect()
}

struct Reader<'a> {
    source: &'a Source<'a>,
    part: &'a str,
}

impl Reader<'_> {
    fn error(&self, node: Node, what: &str) -> Error {
        let line = node.document().text_pos_at(node.range().start).row;
        let part = shown(self.part.as_bytes());
        self.source.error(Place::File, format!("part '{part}', line {line}: {what}"))
    }

    fn number(&self, node: Node, name: &str) -> Result<u32> {
        let value = node.attribute(name).and_then(|text| text.trim().parse().ok());
        value.ok_or_else(|| {
            let found = shown(node.attribute(name).unwrap_or_default().as_bytes());
            self.error(node, &format!("'{name}' must be a number, found '{found}'"))
        })
    }

    fn optional(&self, node: Node, name: &str) -> Result<Option<u32>> {
        node.attribute(name).map(|_| self.number(node, name)).transpose()
    }

    fn coordinate(&self, node: Node, name: &str) -> Result<f64> {
        let value = node.attribute(name).and_then(|text| parse_float(text.trim().as_bytes()));
        value.ok_or_else(|| {
            let found = shown(node.attribute(name).unwrap_or_default().as_bytes());
            self.error(node, &format!("'{name}' must be a coordinate, found '{found}'"))
        })
    }

    fn object(&self, node: Node) -> Result<(u32, Object)> {
        let id = self.number(node, "id")?;
        let (group, member) = (self.optional(node, "pid")?, self.optional(node, "pindex")?);
        let own = group.map(|group| (group, [member.unwrap_or(0); 3]));
        let name = node.attribute("name").unwrap_or_default().to_string();
        let mut object = Object { name, vertices: Vec::new(), triangles: Vec::new(), components: Vec::new() };
        for part in node.children() {
            match part.tag_name().name() {
                "mesh" => self.mesh(part, own, &mut object)?,
                "components" => {
                    for component in part.children().filter(|c| c.tag_name().name() == "component") {
                        object.components.push(self.component(component)?);
                    }
                }
                _ => {}
            }
        }
        Ok((id, object))
    }

    fn mesh(&self, mesh: Node, own: Option<(u32, [u32; 3])>, object: &mut Object) -> Result<()> {
        for list in mesh.children() {
            for node in list.children().filter(Node::is_element) {
                match node.tag_name().name() {
                    "vertex" => {
                        let x = |name| self.coordinate(node, name);
                        object.vertices.push(DVec3::new(x("x")?, x("y")?, x("z")?));
                    }
                    "triangle" => object.triangles.push(self.triangle(node, own)?),
                    _ => {}
                }
            }
        }
        let count = object.vertices.len();
        if let Some(k) = object.triangles.iter().position(|t| t.corners.iter().any(|&v| v as usize >= count)) {
            return Err(self.error(mesh, &format!("triangle {k} uses a vertex that does not exist, there are {count}")));
        }
        Ok(())
    }

    fn triangle(&self, node: Node, own: Option<(u32, [u32; 3])>) -> Result<Triangle> {
        let corners = [self.number(node, "v1")?, self.number(node, "v2")?, self.number(node, "v3")?];
        let group = self.optional(node, "pid")?.or(own.map(|(group, _)| group));
        let look = match (group, self.optional(node, "p1")?) {
            (Some(group), Some(first)) => {
                let other = |name| Ok::<_, Error>(self.optional(node, name)?.unwrap_or(first));
                Some((group, [first, other("p2")?, other("p3")?]))
            }
            _ => own,
        };
        Ok(Triangle { corners, look })
    }

    fn component(&self, node: Node) -> Result<Component> {
        // The production extension's attribute has a namespace of its own.
        let path = node.attributes().find(|a| a.name() == "path").map(|a| a.value().to_string());
        let transform = match node.attribute("transform") {
            Some(text) => transform(text).ok_or_else(|| self.error(node, "a transform has 12 numbers"))?,
            None => DMat4::IDENTITY,
        };
        Ok(Component { path, object: self.number(node, "objectid")?, transform })
    }
}

/// Twelve numbers: the images of the axes, then the translation.
fn transform(text: &str) -> Option<DMat4> {
    let numbers: Vec<f64> = text.split_whitespace().map(|w| parse_float(w.as_bytes())).collect::<Option<_>>()?;
    let column = |k: usize| DVec3::from_slice(&numbers[3 * k..3 * k + 3]);
    (numbers.len() == 12 && numbers.iter().all(|x| x.is_finite())).then(|| {
        DMat4::from_cols(column(0).extend(0.0), column(1).extend(0.0), column(2).extend(0.0), column(3).extend(1.0))
    })
}
