//! The triangles that fill a hole.

use glam::DVec3;

/// A patch on a hole: triangles on vertices of the mesh and on new ones after these.
pub struct Patch {
    pub(super) points: Vec<DVec3>,
    pub(super) triangles: Vec<[u32; 3]>,
}
