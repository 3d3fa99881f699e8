//! Geometry that several rooms need: knows meshes, knows no room.
//!
//! | file | holds |
//! |---|---|
//! | `normals` | normals of faces, vertices and corners; angles |
//! | `features` | feature edges: sharp, border, tagged, listed; signed dihedral angles |
//! | `curvature` | principal curvatures and directions |
//! | `planar` | fills a flat face with nearly equilateral triangles |
//! | `bspline` | B-spline curves and surfaces |
//! | `primitive` | planes, spheres, cylinders, cones, tori: distance and least-squares fit |
//! | `summary` | minimum, mean, percentiles, histogram |
//! | `quadric` | sums of squared distances to planes |
//! | `quality` | mean ratio, aspect ratio, angles, scaled Jacobian |
//! | `hexes` | scaled Jacobian, volume and certificate of hexahedra |
//! | `search_tree` | closest point, neighbourhood and rays over triangles |
//! | `closest`, `ray` | the same for one triangle |
//! | `slabs`, `slices` | what a node of the tree holds: slabs across a normal, long triangles in slices |
//! | `intersections` | triangles of a surface that cut or touch each other, by exact predicates |
//! | `holes` | holes filled by faces that follow the surroundings |
//! | `thickness` | thin walls and narrow gaps |
//! | `transfer` | what a mesh has on its elements, carried to another mesh of the same surface |
//! | `winding` | inside or outside, for broken surfaces too |
//! | `distance` | two-sided distance and normal deviation of two surfaces |

pub mod bspline;
pub(crate) mod closest;
pub mod curvature;
pub mod distance;
pub mod features;
pub mod hexes;
pub mod holes;
pub mod intersections;
pub mod normals;
pub(crate) mod planar;
pub mod primitive;
pub(crate) mod quadric;
pub mod quality;
mod ray;
pub mod search_tree;
pub mod second_order;
mod slabs;
mod slices;
pub mod summary;
pub mod thickness;
pub mod transfer;
pub mod winding;
