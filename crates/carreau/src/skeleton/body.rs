//! The closed surface that a skeleton is tidied in.

use crate::geometry::search_tree::TriangleTree;
use crate::geometry::winding::WindingTree;
use crate::mesh::SurfaceMesh;
use glam::DVec3;

/// A closed surface, and what is asked of it.
pub struct Body<'a> {
    pub surface: &'a SurfaceMesh,
    /// The centre of the inner ball at every vertex.
    pub poles: &'a [DVec3],
    pub tree: &'a TriangleTree,
    /// Unit normals of its triangles.
    pub normals: &'a [DVec3],
    pub inside: &'a WindingTree,
}
