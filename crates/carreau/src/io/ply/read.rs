//! The reader: tables to mesh.

use super::super::binary::{Cursor, Endian};
use super::super::limits::drop_short_faces;
use super::super::source::Source;
use super::body::{Body, Table, Values, read_table};
use super::columns::columns;
use super::header::{Element, Encoding, Header};
use crate::error::{Place, Result};
use crate::mesh::{Polygons, RawMesh};
use glam::DVec3;

pub fn read(source: &Source) -> Result<RawMesh> {
    let (header, text) = Header::read(source)?;
    match header.encoding {
        Encoding::Text => read_elements(source, &header, text),
        Encoding::LittleEndian => read_elements(source, &header, Cursor::new(source, header.end, Endian::Little)),
        Encoding::BigEndian => read_elements(source, &header, Cursor::new(source, header.end, Endian::Big)),
    }
}

fn read_elements<B: Body>(source: &Source, header: &Header, mut body: B) -> Result<RawMesh> {
    let lacks = |what: String| source.error(Place::File, what);
    let vertex = header
        .elements
        .iter()
        .find(|e| e.name == "vertex")
        .ok_or_else(|| lacks("there is no element 'vertex'".into()))?;
    if let Some(axis) =
        ["x", "y", "z"].iter().find(|a| !vertex.properties.iter().any(|p| p.name == **a && p.list.is_none()))
    {
        return Err(lacks(format!("the vertices have no property '{axis}'")));
    }
    let mut mesh = RawMesh::default();
    let mut strips = Polygons::new();
    for element in &header.elements {
        note_what_is_left_out(element, &mut mesh.notes);
        let table = read_table(&mut body, element, vertex.count)?;
        match element.name.as_str() {
            "vertex" => store_vertices(&mut mesh, table),
            "face" => store_faces(&mut mesh, table),
            "edge" => store_edges(&mut mesh, table, &body, vertex.count)?,
            "tristrips" => strips = table.into_iter().find_map(|(_, v)| polygons(v)).unwrap_or_default(),
            _ => {}
        }
    }
    if let Some(rest) = body.rest() {
        mesh.notes.push(format!("left out {rest} behind the last element"));
    }
    append_strips(&mut mesh, strips);
    drop_short_faces(&mut mesh);
    Ok(mesh)
}

fn store_vertices(mesh: &mut RawMesh, mut table: Table) {
    let [x, y, z] = ["x", "y", "z"].map(|axis| take(&mut table, axis).map(numbers).unwrap_or_default());
    mesh.points = x.into_iter().zip(y).zip(z).map(|((x, y), z)| DVec3::new(x, y, z)).collect();
    mesh.attributes.vertex = columns(table);
}

fn store_faces(mesh: &mut RawMesh, mut table: Table) {
    match table.iter().position(|(_, values)| matches!(values, Values::Faces(_))) {
        Some(k) => {
            mesh.faces = polygons(table.swap_remove(k).1).unwrap_or_default();
            mesh.attributes.face = columns(table);
        }
        None => mesh.notes.push("left out the faces: they have no list 'vertex_indices'".into()),
    }
}

fn store_edges<B: Body>(mesh: &mut RawMesh, mut table: Table, body: &B, vertices: u64) -> Result<()> {
    let mut integers = |name| match take(&mut table, name) {
        Some(Values::Integers(values)) => Some(values),
        _ => None,
    };
    let (Some(starts), Some(ends)) = (integers("vertex1"), integers("vertex2")) else {
        mesh.notes.push("left out the edges: they have no integers 'vertex1' and 'vertex2'".into());
        return Ok(());
    };
    mesh.edges = starts
        .iter()
        .zip(&ends)
        .map(|(&a, &b)| Ok([body.vertex(a, vertices)?, body.vertex(b, vertices)?]))
        .collect::<Result<_>>()?;
    let tags = integers("tag").and_then(|tags| tags.iter().map(|&t| i32::try_from(t).ok()).collect());
    mesh.edge_tags = tags.unwrap_or_else(|| vec![0; mesh.edges.len()]);
    Ok(())
}

/// The triangles of strips come after the faces, which have columns that the strips lack.
fn append_strips(mesh: &mut RawMesh, strips: Polygons) {
    if strips.is_empty() {
        return;
    }
    if mesh.faces.is_empty() {
        mesh.faces = strips;
    } else {
        strips.iter().for_each(|triangle| mesh.faces.push(triangle));
    }
    if !mesh.attributes.face.is_empty() {
        mesh.attributes.face.clear();
        mesh.notes.push("left out the properties of the faces: triangle strips have none".into());
    }
}

fn note_what_is_left_out(element: &Element, notes: &mut Vec<String>) {
    let lists = element.properties.iter().filter(|p| p.list.is_some());
    match element.name.as_str() {
        "vertex" | "edge" => {
            notes.extend(lists.map(|p| format!("left out the list '{}' of element '{}'", p.name, element.name)))
        }
        "face" => {
            let others = lists.filter(|p| !matches!(p.name.as_str(), "vertex_indices" | "vertex_index"));
            notes.extend(others.map(|p| format!("left out the list '{}' of the faces", p.name)));
        }
        "tristrips" => {}
        other => notes.push(format!("left out the element '{other}'")),
    }
}

fn take(table: &mut Table, name: &str) -> Option<Values> {
    let k = table.iter().position(|(n, _)| n == name)?;
    Some(table.swap_remove(k).1)
}

fn numbers(values: Values) -> Vec<f64> {
    match values {
        Values::Floats(values) => values,
        Values::Integers(values) => values.into_iter().map(|x| x as f64).collect(),
        _ => Vec::new(),
    }
}

fn polygons(values: Values) -> Option<Polygons> {
    match values {
        Values::Faces(polygons) | Values::Strips(polygons) => Some(polygons),
        _ => None,
    }
}
