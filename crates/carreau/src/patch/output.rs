//! A decomposition as a mesh: one quad per cell, then the triangles that are left over.

use super::result::PatchResult;
use crate::mesh::{Column, Polygons, RawMesh, SurfaceMesh};

/// Label of a left-over triangle in the face column `patch`.
const LEFTOVER: i32 = -1;

/// The quads of all patches, patch by patch and row by row, then the left-over triangles. Vertices and their columns
/// are those of the input; the face column `patch` holds the number of the patch, -1 for triangles left over.
pub fn quad_mesh(mesh: &SurfaceMesh, result: &PatchResult) -> RawMesh {
    let cells = result.figures.cells;
    let mut faces = Polygons::new();
    faces.reserve(cells + result.leftover.len(), 4 * cells + 3 * result.leftover.len());
    let mut labels = Vec::with_capacity(cells + result.leftover.len());
    for (patch, label) in result.patches.iter().zip(0..) {
        for (r, c) in patch.cell_places() {
            faces.push(&patch.cell(r, c).map(|v| v.0));
            labels.push(label);
        }
    }
    for &t in &result.leftover {
        faces.push(mesh.face(t));
        labels.push(LEFTOVER);
    }
    let mut out = RawMesh { points: mesh.points().to_vec(), faces, ..RawMesh::default() };
    out.attributes.vertex = mesh.attributes.vertex.clone();
    out.attributes.face.insert("patch".into(), Column::Label(labels));
    out.edges = mesh.tagged_edges.iter().map(|e| e.ends.map(|v| v.0)).collect();
    out.edge_tags = mesh.tagged_edges.iter().map(|e| e.tag).collect();
    out
}
