//! Chooses the bodies that are kept: all of them, the largest, or those of some size.

use super::super::attributes::{Attributes, gather_columns};
use super::super::id::VertexId;
use super::super::polygons::Polygons;
use super::super::surface::{SurfaceMesh, TaggedEdge};
use super::super::triangles::NONE;
use super::bodies::Bodies;
use super::options::{Keep, Takes};
use super::report::Pieces;
use super::scan;
use super::trace::{Prepared, Trace};
use crate::error::Result;

/// Bodies with a smaller share of the largest one's area are small: specks, as segmentations and scanners leave them.
const SMALL: f64 = 0.01;

/// Leaves out the bodies that are not to stay, and counts the small ones.
pub(super) fn keep(mut prepared: Prepared, keep: Option<Keep>, takes: Takes) -> Result<Prepared> {
    let list = &prepared.bodies.list;
    // Of several that are as large, the first.
    let largest = (0..list.len()).fold(0, |best, b| if list[b].area > list[best].area { b } else { best });
    let Some(most) = list.get(largest).map(|body| body.area) else { return Ok(prepared) };
    let rule = keep.unwrap_or(if takes == Takes::OneBody { Keep::Largest } else { Keep::All });
    let stays: Vec<bool> = list
        .iter()
        .enumerate()
        .map(|(b, body)| match rule {
            Keep::All => true,
            Keep::Largest => b == largest,
            Keep::Share(share) => body.area >= share * most,
        })
        .collect();
    if stays.contains(&false) {
        prepared = without(prepared, &stays)?;
    } else if keep.is_none() {
        let is_small = |area: f64| area < SMALL * most;
        prepared.report.small = Pieces::of(list.iter().filter(|body| is_small(body.area)), |f| prepared.face(f));
    }
    Ok(prepared)
}

/// The surface without some bodies, and without the vertices that they alone used.
fn without(prepared: Prepared, stays: &[bool]) -> Result<Prepared> {
    let Prepared { mesh, bodies, mut report, trace } = prepared;
    let source = |f: u32| trace.as_ref().map_or(f, |trace| trace.face_source[f as usize]);
    report.left_out = Pieces::of((0..stays.len()).filter(|&b| !stays[b]).map(|b| &bodies.list[b]), source);
    let is_kept = |f: u32| stays[bodies.of_face[f as usize] as usize];
    let faces: Vec<u32> = (0..mesh.face_count() as u32).filter(|&f| is_kept(f)).collect();
    let mut lost = vec![false; mesh.vertex_count()];
    let mut mark = |kept: bool| {
        for (face, f) in mesh.faces().iter().zip(0u32..).filter(|&(_, f)| is_kept(f) == kept) {
            face.iter().for_each(|&v| lost[v as usize] = !kept);
            debug_assert!((f as usize) < bodies.of_face.len());
        }
    };
    mark(false);
    mark(true);
    let vertices: Vec<u32> = (0..mesh.vertex_count() as u32).filter(|&v| !lost[v as usize]).collect();
    let part = part_of(&mesh, &vertices, &faces)?;
    let trace = match trace {
        Some(trace) => trace.reduced(&vertices, &faces),
        None => Trace::identity(&mesh).reduced(&vertices, &faces).with(mesh),
    };
    let (component, components, shells) = scan::parts(&part);
    let bodies = Bodies::of(&part, &component, components, &shells);
    report.bodies = bodies.list.len();
    Ok(Prepared { mesh: part, bodies, report, trace: Some(Box::new(trace)) })
}

fn part_of(mesh: &SurfaceMesh, vertices: &[u32], faces: &[u32]) -> Result<SurfaceMesh> {
    let mut new_id = vec![NONE; mesh.vertex_count()];
    (0u32..).zip(vertices).for_each(|(new, &old)| new_id[old as usize] = new);
    let offsets = mesh.faces().offsets();
    let mut polygons = Polygons::new();
    for &f in faces {
        polygons.push_iter(mesh.faces().face(f as usize).iter().map(|&v| new_id[v as usize]));
    }
    let corners: Vec<u32> = faces.iter().flat_map(|&f| offsets[f as usize]..offsets[f as usize + 1]).collect();
    let points = vertices.iter().map(|&v| mesh.points()[v as usize]).collect();
    let mut part = SurfaceMesh::new(points, polygons)?;
    let from = &mesh.attributes;
    part.attributes = Attributes {
        vertex: gather_columns(&from.vertex, vertices),
        face: gather_columns(&from.face, faces),
        corner: gather_columns(&from.corner, &corners),
        ..Attributes::words_of(from)
    };
    let tagged = mesh.tagged_edges.iter().filter(|edge| edge.ends.iter().all(|v| new_id[v.index()] != NONE));
    let moved = |edge: &TaggedEdge| TaggedEdge { ends: edge.ends.map(|v| VertexId(new_id[v.index()])), ..*edge };
    part.tagged_edges = tagged.map(moved).collect();
    Ok(part)
}
