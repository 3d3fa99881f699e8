//! How far it is to the next sheet of the surface: the chords of curved sheets close to each other must not cross it.
//!
//! ```text
//!    ___-----___        the outer sheet's chords sag towards the inner one; with sizes that follow
//!   ╱ _-------_ ╲       from the angle alone they would cut through it
//! ```

use crate::context::Context;
use crate::error::Result;
use crate::geometry::normals::{face_normals, vertex_normals};
use crate::geometry::search_tree::TriangleTree;
use crate::mesh::SurfaceMesh;
use rayon::prelude::*;

/// Sheets lie beside each other where their normals are at most 60° apart, whatever their sense.
const BESIDE: f64 = 0.5;

/// The distance from every vertex to the next sheet along its normal, on either side, as far as it reaches; infinite where
/// there is none.
pub fn distances(mesh: &SurfaceMesh, reach: impl Fn(usize) -> f64 + Sync, context: &Context) -> Result<Vec<f64>> {
    let (triangles, face) = mesh.faces().fan();
    let tree = TriangleTree::new(mesh.points(), &triangles);
    let faces = face_normals(mesh);
    let normals = vertex_normals(mesh, &faces);
    let next = |v: usize| -> Result<f64> {
        context.check_every(v)?;
        let (p, normal) = (mesh.points()[v], normals[v]);
        let mut nearest = f64::INFINITY;
        for way in [normal, -normal] {
            tree.along_ray(p, way, reach(v), |hit| {
                let is_own = triangles[hit.triangle as usize].iter().any(|&w| mesh.points()[w as usize] == p);
                let is_beside = faces[face[hit.triangle as usize] as usize].dot(normal).abs() > BESIDE;
                if is_beside && !is_own {
                    nearest = nearest.min(hit.t);
                }
            });
        }
        Ok(nearest)
    };
    (0..mesh.vertex_count()).into_par_iter().map(next).collect()
}
