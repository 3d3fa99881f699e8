//! The usual figure of a mesh: faces coloured by label where there are labels, edges faint, borders of labels bold.

use super::picture::{Colors, Image, Lines, Path, Picture, Scale, crease_edges, label_borders, mesh_edges, render};
use crate::geometry::summary::Summary;
use crate::mesh::{Column, RawMesh};

/// Face labels that a figure shows, the first one that a mesh has.
const LABELS: &[&str] = &["patch", "region", "truth", "ref", "group"];
/// Meshes with more faces are drawn without their edges, which would cover everything.
const MOST_FACES_WITH_EDGES: usize = 60_000;
/// Edges sharper than this are drawn bold where there are no labels, in degrees.
const CREASE: f64 = 35.0;

/// Draws a mesh as a person would expect to see it.
pub fn figure(mesh: &RawMesh) -> Image {
    let labels = LABELS.iter().find_map(|name| match mesh.attributes.face.get(*name) {
        Some(Column::Label(labels)) => Some(labels.as_slice()),
        _ => None,
    });
    let n = mesh.points.len();
    let edges = if mesh.faces.len() <= MOST_FACES_WITH_EDGES { mesh_edges(n, &mesh.faces) } else { Vec::new() };
    let bold = match labels {
        Some(labels) => label_borders(n, &mesh.faces, labels),
        None => crease_edges(&mesh.points, &mesh.faces, CREASE),
    };
    let mut picture = Picture::new(&mesh.points, &mesh.faces);
    if let Some(labels) = labels {
        picture.colors = Colors::Labels(labels);
    }
    // On a fine mesh lines of the usual width would hide the faces.
    let fine = mesh.faces.len() > MOST_FACES_WITH_EDGES / 4;
    picture.lines.push(Lines { opacity: if fine { 0.25 } else { 0.5 }, ..Lines::fine(Path::Edges(&edges)) });
    picture.lines.push(Lines { width: if fine { 1.2 } else { 1.8 }, ..Lines::bold(Path::Edges(&bold)) });
    render(&picture)
}

/// Draws a mesh coloured by a curvature per vertex: blue concave, white flat, red convex. Colours end at the 95th
/// percentile of the magnitudes, so that a few wild values do not bleach the rest.
pub fn curvature_figure(mesh: &RawMesh, values: &[f64]) -> Image {
    let bound = Summary::of(values.iter().map(|k| k.abs()).collect()).map_or(0.0, |s| s.p95);
    let bold = crease_edges(&mesh.points, &mesh.faces, CREASE);
    let mut picture = Picture::new(&mesh.points, &mesh.faces);
    picture.colors = Colors::VertexScalars(values, Scale::Diverging(Some(if bound > 0.0 { bound } else { 1.0 })));
    picture.lines.push(Lines { width: 1.2, ..Lines::bold(Path::Edges(&bold)) });
    render(&picture)
}
