//! Ids that may be missing.

use crate::mesh::surface::SurfaceMesh;
use crate::mesh::triangles::NONE;

/// The vertices that faces use.
pub fn used_vertices(mesh: &SurfaceMesh) -> Vec<bool> {
    let mut used = vec![false; mesh.vertex_count()];
    mesh.faces().corners().iter().for_each(|&v| used[v as usize] = true);
    used
}

/// The first element of a list, if any.
pub fn first<T: Copy>(list: &[T]) -> Option<T> {
    list.first().copied()
}

/// An id, if there is one.
pub fn some(id: u32) -> Option<u32> {
    (id != NONE).then_some(id)
}
