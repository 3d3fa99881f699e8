//! Edges worth drawing. Faces have to use existing vertices only, as those of a surface mesh do.

use crate::mesh::{HalfEdges, Polygons};
use glam::DVec3;

/// All edges.
pub fn mesh_edges(vertices: usize, faces: &Polygons) -> Vec<[u32; 2]> {
    HalfEdges::new(faces, vertices).groups().map(|e| e.ends).collect()
}

/// The edges of one face only.
pub fn border_edges(vertices: usize, faces: &Polygons) -> Vec<[u32; 2]> {
    HalfEdges::new(faces, vertices).groups().filter(|e| e.len() == 1).map(|e| e.ends).collect()
}

/// The edges between faces with different labels, and the border. Faces without a label count as different from all.
pub fn label_borders(vertices: usize, faces: &Polygons, labels: &[i32]) -> Vec<[u32; 2]> {
    select(vertices, faces, |f, g| labels.get(f).zip(labels.get(g)).is_none_or(|(a, b)| a != b))
}

/// The edges whose faces' normals differ by more than `angle` degrees, and the border.
pub fn crease_edges(points: &[DVec3], faces: &Polygons, angle: f64) -> Vec<[u32; 2]> {
    let normals: Vec<DVec3> = faces.iter().map(|face| normal(points, face)).collect();
    let limit = angle.to_radians().cos();
    select(points.len(), faces, |f, g| normals[f].dot(normals[g]) < limit)
}

/// The edges with two faces for which `chosen` holds, and those with any other number of faces.
fn select(vertices: usize, faces: &Polygons, chosen: impl Fn(usize, usize) -> bool) -> Vec<[u32; 2]> {
    let face_of: Vec<u32> =
        faces.iter().enumerate().flat_map(|(f, c)| std::iter::repeat_n(f as u32, c.len())).collect();
    let between = |corners: Vec<u32>| match corners[..] {
        [c, d] => chosen(face_of[c as usize] as usize, face_of[d as usize] as usize),
        _ => true,
    };
    HalfEdges::new(faces, vertices).groups().filter(|e| between(e.corners().collect())).map(|e| e.ends).collect()
}

/// Unit normal of a polygon by its area vector; zero without area.
fn normal(points: &[DVec3], face: &[u32]) -> DVec3 {
    let arms = || face.iter().map(|&v| points[v as usize] - points[face[0] as usize]);
    // Scaled, so that the area of a face of size 1e200 or 1e-200 is neither infinite nor zero.
    let size = arms().map(|d| d.abs().max_element()).fold(f64::MIN_POSITIVE, f64::max);
    let area: DVec3 = arms().zip(arms().skip(1)).map(|(u, v)| (u / size).cross(v / size)).sum();
    area.normalize_or_zero()
}
