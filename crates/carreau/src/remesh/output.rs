//! The result as a surface mesh: cut vertices are joined again, attributes come along, every vertex has its size.

use super::features::POLYGON;
use super::support::Support;
use crate::error::Result;
use crate::mesh::{Attributes, Column, EditMesh, NONE, SurfaceMesh, blend_columns, gather_columns};
use glam::DVec3;

/// What a method has made.
pub struct Made<'a> {
    pub mesh: &'a EditMesh,
    /// A source triangle near a corner, on its side of all curves.
    pub seat: &'a dyn Fn(u32) -> u32,
    /// Size at a vertex.
    pub size: &'a dyn Fn(u32) -> f64,
    /// Stretch at every vertex; empty where sizes are isotropic.
    pub stretch: &'a [DVec3],
}

/// The surface mesh of what was made of a source.
pub fn assemble(source: &SurfaceMesh, support: &Support, made: &Made) -> Result<SurfaceMesh> {
    let compact = made.mesh.compact();
    let mut first = vec![NONE; source.vertex_count()];
    let mut id = vec![0u32; compact.vertices.len()];
    let mut kept = Vec::new();
    for (k, &v) in compact.vertices.iter().enumerate() {
        let origin = made.mesh.origin[v as usize];
        let known = if origin == NONE { NONE } else { first[origin as usize] };
        id[k] = if known != NONE { known } else { kept.len() as u32 };
        if known == NONE {
            if origin != NONE {
                first[origin as usize] = kept.len() as u32;
            }
            kept.push(v);
        }
    }
    let faces: Vec<[u32; 3]> = compact.faces.iter().map(|f| f.map(|v| id[v as usize])).collect();
    let points = kept.iter().map(|&v| made.mesh.points[v as usize]).collect();
    let mut out = SurfaceMesh::from_triangles(points, &faces)?;
    out.attributes = Attributes::words_of(&source.attributes);
    if !source.attributes.face.is_empty() {
        let under = |&t: &u32| {
            let [a, b, c] = made.mesh.positions(t);
            support.locate((made.seat)(3 * t), (a + b + c) / 3.0).0.triangle
        };
        let parents: Vec<u32> = compact.triangles.iter().map(under).collect();
        out.attributes.face = gather_columns(&source.attributes.face, &parents);
        out.attributes.face.remove(POLYGON);
    }
    if !source.attributes.vertex.is_empty() {
        let mixture = |&v: &u32| {
            let corner = made.mesh.around(v).next().unwrap_or(0);
            let seat = support.locate((made.seat)(corner), made.mesh.points[v as usize]).0;
            let corners = support.mesh.triangle(seat.triangle);
            [0, 1, 2].map(|k| (support.mesh.origin[corners[k] as usize], seat.weights[k]))
        };
        let mixtures: Vec<_> = kept.iter().map(mixture).collect();
        out.attributes.vertex = blend_columns(&source.attributes.vertex, &mixtures);
        // Normals of another surface: whoever wants some measures them anew.
        out.attributes.vertex.remove("normal");
    }
    let size = kept.iter().map(|&v| (made.size)(v)).collect();
    out.attributes.vertex.insert("size".into(), Column::Scalar(size));
    if !made.stretch.is_empty() {
        let stretch = kept.iter().map(|&v| made.stretch[v as usize].to_array()).collect();
        out.attributes.vertex.insert("stretch".into(), Column::Vector3(stretch));
    }
    Ok(out)
}
