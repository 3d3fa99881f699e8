//! Meshes: their data structures, checks and repair.
//!
//! | file | holds |
//! |---|---|
//! | `id` | typed ids |
//! | `polygons` | faces in two flat arrays |
//! | `half_edges` | half-edges grouped by edge |
//! | `second_order` | [`MiddleNodes`]: nodes in the middle of the edges, faces and cells of hexahedra, as they are found |
//! | `hex_mesh` | [`HexMesh`]: hexahedra with tagged boundary faces |
//! | `surface` | [`SurfaceMesh`]: the input of every room |
//! | `triangles` | [`Triangles`]: a triangle mesh as raw arrays, for inner loops |
//! | `triangulate` | cutting polygons into triangles |
//! | `space_order` | numbering in which neighbours on the surface are neighbours in memory |
//! | `raw` | [`RawMesh`]: the content of a file, volume cells included |
//! | `attributes` | named columns |
//! | `area` | area vectors of faces |
//! | `weld` | merging vertices at one place, exactly or within a tolerance |
//! | `duplicates` | faces on the same vertices |
//! | `curve_net` | [`CurveNet`]: skeletons with radii |
//! | `disjoint_sets` | union-find |
//! | `edit` | [`EditMesh`]: collapse, flip, split, relocate |
//! | `connectivity` | components, irregular edges, consistent orientation, umbrellas |
//! | `nesting` | closed components: volume, nesting, which are inside out |
//! | `topology` | [`Topology`]: counts, genus, defects with their places |
//! | `repair` | [`repair`]: weld, drop, orient, split |
//! | `prepare` | [`prepare`]: how a file's surface is made ready for a room |
//! | `marks` | what stands for the opposite corner where there is none |
//! | `middle_nodes` | [`SecondOrder`]: these nodes as a mesh has them |
//! | `position` | the order of places |
//! | `unit_scale` | scaling by a power of two, so that results do not depend on the unit |

mod area;
mod attributes;
mod boundary;
pub(crate) mod connectivity;
mod curve_net;
mod disjoint_sets;
mod duplicates;
mod edit;
mod half_edges;
mod hex_mesh;
mod id;
mod marks;
mod middle_nodes;
mod nesting;
mod polygons;
mod position;
mod prepare;
mod raw;
mod repair;
mod second_order;
mod space_order;
mod surface;
#[cfg(test)]
pub(crate) mod test_models;
pub(crate) mod topology;
mod triangles;
mod triangulate;
mod unit_scale;
mod weld;

pub(crate) use area::unit_sized;
pub use area::{area_vector, mean_ratio, safe_length, triangle_area_vector};
pub use attributes::{Attributes, BODIES, Column, Columns, LengthUnit, MaterialLibrary, blend_columns, gather_columns};
pub use curve_net::{Branch, Chains, CurveNet, Incidence, NetBuilder, RepairedNet, branches};
pub(crate) use disjoint_sets::DisjointSets;
pub use edit::{CollapseError, Compact, Corner, EditMesh, Keep, OutgoingHalfEdges, next, previous};
pub use half_edges::{EdgeGroup, HalfEdges};
pub use hex_mesh::{HEX_EDGES, HEX_FACES, HexMesh, boundary_faces, irregular_hex_edges};
pub use id::{CornerId, FaceId, VertexId};
pub use middle_nodes::SecondOrder;
pub use polygons::Polygons;
pub(crate) use position::by_position;
pub use prepare::{
    Bodies, Body, Keep as KeepPieces, PrepareOptions, PreparePlaces, PrepareReport, Prepared, Takes, keep_pieces,
    prepare, prepare_fans,
};
pub use raw::{Cells, RawMesh};
pub use repair::{RepairOptions, RepairReport, Repaired, repair, sound};
pub(crate) use repair::{divided, is_flawed};
pub use second_order::{HEX_EDGE_NODES, MiddleNodes};
pub use surface::{Side, SurfaceMesh, TaggedEdge};
pub use topology::{BoundaryLoop, Places, Topology};
pub use triangles::{NONE, Triangles};
pub(crate) use triangulate::split_quad;
pub(crate) use unit_scale::UnitScale;
pub use weld::{first_at_same_position, leaders_within};
