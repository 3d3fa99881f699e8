//! Polygons that are not plane: cut in two they would have a crease that nobody drew.
//!
//! ```text
//!   d───────c        d───────c
//!   │     ╱ │        │ ╲   ╱ │
//!   │   ╱   │   →    │   m   │     m: the mean of the corners, where the bilinear patch of a quad has its middle
//!   │ ╱     │        │ ╱   ╲ │
//!   a───────b        a───────b
//! ```
//!
//! With a vertex in the middle every edge within bends about half as much as a diagonal.

use crate::error::Result;
use crate::geometry::normals::{angle_between, unit};
use crate::mesh::{
    Attributes, Polygons, SurfaceMesh, area_vector, blend_columns, gather_columns, triangle_area_vector,
};
use glam::DVec3;

/// Polygons that fold by less are plane, in degrees.
const PLANE_DEG: f64 = 10.0;
/// Polygons that some fan folds by more are left alone.
pub const FOLDED_DEG: f64 = 60.0;

/// The mesh with a vertex in the middle of every polygon that is not plane; new vertices follow after all others.
pub fn with_middles(mesh: SurfaceMesh) -> Result<SurfaceMesh> {
    let warped: Vec<bool> = mesh.faces().iter().map(|face| is_warped(mesh.points(), face)).collect();
    if !warped.contains(&true) {
        return Ok(mesh);
    }
    let mut points = mesh.points().to_vec();
    let mut faces = Polygons::new();
    let mut parents = Vec::new();
    let mut mixtures: Vec<Vec<(u32, f64)>> = (0..points.len() as u32).map(|v| vec![(v, 1.0)]).collect();
    for ((face, &warped), f) in mesh.faces().iter().zip(&warped).zip(0u32..) {
        if !warped {
            faces.push(face);
            parents.push(f);
            continue;
        }
        let share = 1.0 / face.len() as f64;
        let middle = points.len() as u32;
        points.push(face.iter().map(|&v| share * points[v as usize]).sum());
        mixtures.push(face.iter().map(|&v| (v, share)).collect());
        for (k, &v) in face.iter().enumerate() {
            faces.push(&[v, face[(k + 1) % face.len()], middle]);
            parents.push(f);
        }
    }
    let mut out = SurfaceMesh::new(points, faces)?;
    out.attributes = Attributes {
        vertex: blend_columns(&mesh.attributes.vertex, &mixtures),
        face: gather_columns(&mesh.attributes.face, &parents),
        ..Attributes::words_of(&mesh.attributes)
    };
    out.tagged_edges = mesh.tagged_edges;
    Ok(out)
}

/// Whether a polygon is to get a middle: from whichever corner it is fanned its triangles fold, and about as much. Where one
/// fan folds far more than another, the polygon is nearly a triangle or a fold itself, and the flatter cut is the better.
fn is_warped(points: &[DVec3], face: &[u32]) -> bool {
    let n = face.len();
    if n < 4 {
        return false;
    }
    let whole = unit(area_vector(points, face));
    let normal = |a: usize, b: usize, c: usize| {
        let [a, b, c] = [a, b, c].map(|k| points[face[k % n] as usize]);
        unit(triangle_area_vector(a, b, c))
    };
    if (0..n).any(|k| !(normal(k, k + 1, k + 2).dot(whole) > 0.0)) {
        return false;
    }
    let fold_at = |s: usize, k: usize| angle_between(normal(s, s + k, s + k + 1), normal(s, s + k + 1, s + k + 2));
    let (mut least, mut most) = (f64::INFINITY, 0.0);
    for s in 0..n {
        let fold = (1..n - 2).map(|k| fold_at(s, k)).fold(0.0, f64::max).to_degrees();
        (least, most) = (fold.min(least), fold.max(most));
    }
    least > PLANE_DEG && most < FOLDED_DEG
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Column;

    /// A quad whose corners lie on z = ± h, beside a plane one.
    fn mesh(h: f64) -> SurfaceMesh {
        let points = [(0., 0., h), (1., 0., -h), (1., 1., h), (0., 1., -h), (2., 0., -h), (2., 1., h)];
        let points = points.map(|(x, y, z)| DVec3::new(x, y, z)).to_vec();
        let mut faces = Polygons::new();
        faces.push(&[0, 1, 2, 3]);
        faces.push(&[1, 4, 2]);
        faces.push(&[2, 4, 5]);
        let mut mesh = SurfaceMesh::new(points, faces).unwrap();
        mesh.attributes.vertex.insert("heat".into(), Column::Scalar((0..6).map(f64::from).collect()));
        mesh.attributes.face.insert("part".into(), Column::Label(vec![7, 8, 9]));
        mesh
    }

    #[test]
    fn a_warped_quad_gets_a_middle_and_its_attributes_come_along() {
        let out = with_middles(mesh(0.2)).unwrap();
        assert_eq!(out.points()[6..], [DVec3::new(0.5, 0.5, 0.0)]);
        assert!(out.is_triangular() && out.face_count() == 6);
        assert_eq!(out.attributes.vertex["heat"], Column::Scalar(vec![0., 1., 2., 3., 4., 5., 1.5]));
        assert_eq!(out.attributes.face["part"], Column::Label(vec![7, 7, 7, 7, 8, 9]));
    }

    #[test]
    fn plane_and_reflex_polygons_stay() {
        assert_eq!(with_middles(mesh(0.0)).unwrap().face_count(), 3);
        let points = [(0., 0., 0.), (1., 0., 0.), (0.2, 0.2, 0.3), (0., 1., 0.)];
        let mut faces = Polygons::new();
        faces.push(&[0, 1, 2, 3]);
        let arrow = SurfaceMesh::new(points.map(|(x, y, z)| DVec3::new(x, y, z)).to_vec(), faces).unwrap();
        assert_eq!(with_middles(arrow).unwrap().face_count(), 1);
    }
}
