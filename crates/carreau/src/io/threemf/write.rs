//! The writer: an object for each body.

use super::package::pack;
use super::words::{UNITS, text_of};
use crate::error::Result;
use crate::io::limits::{columns_left_out, edges_left_out, require_surface, words_left_out};
use crate::io::small_faces::{fan_corners, label};
use crate::io::source::WriteOptions;
use crate::io::text::{push_float, push_integer};
use crate::io::vtk_xml::escaped;
use crate::mesh::{BODIES, Column, LengthUnit, RawMesh};
use crate::words::counted;
use std::collections::BTreeMap;

/// The name of the format in warnings.
const FORMAT_3MF: &str = "3MF";
/// Number of the group of materials or colours.
const GROUP: u32 = 1;
/// What a model part begins with, up to its unit.
const HEAD: &str = concat!(
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n",
    "<model xml:lang=\"en-US\" xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" ",
    "xmlns:m=\"http://schemas.microsoft.com/3dmanufacturing/material/2015/02\" unit=\""
);

pub fn write(mesh: &RawMesh, _: &WriteOptions, out: &mut Vec<u8>) -> Result<Vec<String>> {
    require_surface(mesh, FORMAT_3MF)?;
    let mut warnings = Vec::new();
    let looks = Looks::of(mesh);
    let (triangles, parents) = mesh.faces.fan();
    let fan = Fan { triangles, corners: fan_corners(&mesh.faces), parents };
    if !mesh.faces.all_triangles() {
        warnings.push("3MF has triangles only: polygons are fanned from their first corners".into());
    }
    let mut text = Vec::new();
    let unit = mesh.attributes.unit.unwrap_or(LengthUnit::Millimeter);
    let unit = UNITS.iter().find(|(_, known)| *known == unit).map_or("millimeter", |(name, _)| name);
    text.extend_from_slice(format!("{HEAD}{unit}\">\n<resources>\n{}", looks.group).as_bytes());
    let body = BODIES.into_iter().find_map(|name| Some((name, label(&mesh.attributes.face, name)?)));
    let mut bodies: BTreeMap<i32, Vec<usize>> = BTreeMap::new();
    for (t, &face) in fan.parents.iter().enumerate() {
        bodies.entry(body.map_or(0, |(_, labels)| labels[face as usize])).or_default().push(t);
    }
    let mut flat = 0;
    let mut id = GROUP;
    let mut unused = 0;
    for (label, members) in &bodies {
        id += 1;
        let name = match body {
            Some((column, _)) => mesh.attributes.name(column, *label).map_or_else(|| label.to_string(), str::to_string),
            None => mesh.attributes.only_body().unwrap_or_default().to_string(),
        };
        let part = Part { id, name, members, whole: body.is_none() };
        let written = part.write(mesh, &fan, &looks, &mut text);
        flat += written.flat;
        unused += written.vertices;
    }
    text.extend_from_slice(b"</resources>\n<build>\n");
    for id in GROUP + 1..=id {
        text.extend_from_slice(format!("<item objectid=\"{id}\"/>\n").as_bytes());
    }
    text.extend_from_slice(b"</build>\n</model>\n");
    pack(&text, out)?;
    if flat > 0 {
        let faces = counted(flat, "triangle that uses", "triangles that use");
        warnings.push(format!("3MF: left out {faces} a vertex twice, which it does not allow"));
    }
    if body.is_some() && unused != mesh.points.len() {
        warnings.push(format!(
            "3MF: bodies have vertices of their own, {unused} in all; the mesh has {}",
            mesh.points.len()
        ));
    }
    warnings.extend(left_out(mesh, &looks, body.map(|(name, _)| name)));
    Ok(warnings)
}

/// What colours the triangles.
struct Looks {
    /// The group, as it stands in the file.
    group: String,
    /// The column that it is made of.
    column: Option<(&'static str, On)>,
    /// The member of every face, of every corner or of every vertex.
    members: Vec<Option<u32>>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum On {
    Face,
    Corner,
    Vertex,
}

impl Looks {
    fn of(mesh: &RawMesh) -> Self {
        let a = &mesh.attributes;
        let none = Looks { group: String::new(), column: None, members: Vec::new() };
        if let Some(labels) = label(&a.face, "material") {
            let mut used: Vec<i32> = labels.iter().copied().filter(|&l| l >= 0).collect();
            used.sort_unstable();
            used.dedup();
            let mut group = format!("<basematerials id=\"{GROUP}\">\n");
            for &l in &used {
                let name = a.name("material", l).map_or_else(|| l.to_string(), str::to_string);
                let color = text_of(a.color("material", l).unwrap_or([0xCC, 0xCC, 0xCC, 0xFF]));
                group += &format!("<base name=\"{}\" displaycolor=\"{color}\"/>\n", escaped(&name));
            }
            group += "</basematerials>\n";
            let member = |l: &i32| used.binary_search(l).ok().map(|k| k as u32);
            let members = labels.iter().map(member).collect();
            return Looks { group, column: Some(("material", On::Face)), members };
        }
        let colors = [(On::Face, &a.face), (On::Corner, &a.corner), (On::Vertex, &a.vertex)];
        let found = colors.into_iter().find_map(|(on, columns)| match columns.get("color") {
            Some(Column::Color(colors)) => Some((on, colors)),
            _ => None,
        });
        let Some((on, colors)) = found else { return none };
        let mut used: Vec<[u8; 4]> = colors.clone();
        used.sort_unstable();
        used.dedup();
        let mut group = String::new();
        let base = on == On::Face;
        group += &if base {
            format!("<basematerials id=\"{GROUP}\">\n")
        } else {
            format!("<m:colorgroup id=\"{GROUP}\">\n")
        };
        for &color in &used {
            let code = text_of(color);
            group += &if base {
                format!("<base name=\"{code}\" displaycolor=\"{code}\"/>\n")
            } else {
                format!("<m:color color=\"{code}\"/>\n")
            };
        }
        group += if base { "</basematerials>\n" } else { "</m:colorgroup>\n" };
        let member = |color: &[u8; 4]| used.binary_search(color).ok().map(|k| k as u32);
        let members = colors.iter().map(member).collect();
        Looks { group, column: Some(("color", on)), members }
    }

    /// The members of the corners of a triangle.
    fn at(&self, face: u32, corners: [u32; 3], vertices: [u32; 3]) -> Option<[u32; 3]> {
        let of = |k: u32| self.members.get(k as usize).copied().flatten();
        match self.column?.1 {
            On::Face => of(face).map(|k| [k; 3]),
            On::Corner => Some([of(corners[0])?, of(corners[1])?, of(corners[2])?]),
            On::Vertex => Some([of(vertices[0])?, of(vertices[1])?, of(vertices[2])?]),
        }
    }
}

/// The triangles that the faces are fanned into: vertices, corners over all polygons, faces.
struct Fan {
    triangles: Vec<[u32; 3]>,
    corners: Vec<[u32; 3]>,
    parents: Vec<u32>,
}

/// An object.
struct Part<'a> {
    id: u32,
    name: String,
    members: &'a [usize],
    /// All vertices are its own.
    whole: bool,
}

struct Written {
    vertices: usize,
    flat: usize,
}

impl Part<'_> {
    fn write(&self, mesh: &RawMesh, fan: &Fan, looks: &Looks, out: &mut Vec<u8>) -> Written {
        let Fan { triangles, corners, parents } = fan;
        let mut own: Vec<u32> = match self.whole {
            true => (0..mesh.points.len() as u32).collect(),
            false => self.members.iter().flat_map(|&t| triangles[t]).collect(),
        };
        if !self.whole {
            own.sort_unstable();
            own.dedup();
        }
        let name = escaped(&self.name);
        let name = if name.is_empty() { String::new() } else { format!(" name=\"{name}\"") };
        out.extend_from_slice(
            format!("<object id=\"{}\" type=\"model\"{name}>\n<mesh>\n<vertices>\n", self.id).as_bytes(),
        );
        for &v in &own {
            let [x, y, z] = mesh.points[v as usize].to_array();
            for (k, value) in [("<vertex x=\"", x), ("\" y=\"", y), ("\" z=\"", z)] {
                out.extend_from_slice(k.as_bytes());
                push_float(out, value);
            }
            out.extend_from_slice(b"\"/>\n");
        }
        out.extend_from_slice(b"</vertices>\n<triangles>\n");
        let mut flat = 0;
        for &t in self.members {
            let [a, b, c] = triangles[t];
            if a == b || b == c || c == a {
                flat += 1;
                continue;
            }
            let place = |v: u32| if self.whole { v as usize } else { own.binary_search(&v).unwrap_or_default() };
            for (k, v) in [("<triangle v1=\"", a), ("\" v2=\"", b), ("\" v3=\"", c)] {
                out.extend_from_slice(k.as_bytes());
                push_integer(out, place(v));
            }
            if let Some(p) = looks.at(parents[t], corners[t], triangles[t]) {
                out.extend_from_slice(format!("\" pid=\"{GROUP}\" p1=\"{}", p[0]).as_bytes());
                if p[1] != p[0] || p[2] != p[0] {
                    out.extend_from_slice(format!("\" p2=\"{}\" p3=\"{}", p[1], p[2]).as_bytes());
                }
            }
            out.extend_from_slice(b"\"/>\n");
        }
        out.extend_from_slice(b"</triangles>\n</mesh>\n</object>\n");
        Written { vertices: own.len(), flat }
    }
}

fn left_out(mesh: &RawMesh, looks: &Looks, body: Option<&str>) -> Vec<String> {
    let a = &mesh.attributes;
    let held = |on: On, name: &str| looks.column.is_some_and(|(column, of)| column == name && of == on);
    let vertex = columns_left_out(FORMAT_3MF, "vertex", &a.vertex, |name, _| held(On::Vertex, name));
    let face = columns_left_out(FORMAT_3MF, "face", &a.face, |name, _| held(On::Face, name) || Some(name) == body);
    let corner = columns_left_out(FORMAT_3MF, "corner", &a.corner, |name, _| held(On::Corner, name));
    let named = |column: &str| column == "material" || Some(column) == body;
    let words = words_left_out(FORMAT_3MF, mesh, named, |column| column == "material");
    let library = a.libraries.iter().any(|library| !library.bytes.is_empty());
    let library =
        library.then(|| "3MF: of materials, name and colour are kept; textures and further values are left out".into());
    [vertex, face, corner, edges_left_out(FORMAT_3MF, mesh), library].into_iter().flatten().chain(words).collect()
}
