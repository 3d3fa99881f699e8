//! A triangle mesh that can be changed: collapse, flip, split, relocate.
//!
//! Everything about a corner lies in one record, everything about a triangle in three of them side by side, and nothing is
//! ever moved: removed elements leave tombstones, splits fill them again, [`EditMesh::compact`] sweeps them out.
//!
//! | file | holds |
//! |---|---|
//! | `collapse` | an edge becomes one of its ends, if the link condition allows |
//! | `flip` | an edge becomes the other diagonal |
//! | `split` | an edge gets a vertex |
//!
//! Half-edges are corners, as in [`Triangles`](super::Triangles). Each edge may lie on a *curve* (a ridge, a border), and
//! each corner belongs to a *wedge*: the corners around a vertex between two curves share one. Operations carry both along,
//! so that whoever keeps one normal per wedge finds the right one on either side of a ridge, whatever happened meanwhile.
//!
//! Only manifold meshes can be edited. Where the source is not (three faces on an edge, two fans at a vertex, faces that
//! run along an edge in the same direction), it is cut: the vertices there get one copy per fan, all with the same
//! [`EditMesh::origin`]. Who leaves them alone can weld them again; no flip joins two such copies, and
//! [`EditMesh::joins_copies`] tells whether a collapse would.

mod collapse;
mod edit_mesh;
mod flip;
mod split;
#[cfg(test)]
mod tests;

pub use collapse::{CollapseError, Keep};
pub use edit_mesh::{Compact, Corner, EditMesh, OutgoingHalfEdges, next, previous};
