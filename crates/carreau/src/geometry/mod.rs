//! Geometry that several rooms share. It knows meshes, and no room.
//!
//! | file | holds |
//! |---|---|
//! | `normals` | normals of faces, vertices and corners; angles between them |
//! | `features` | feature edges: sharp, border, tagged, listed; signed dihedral angles |
//! | `curvature` | principal curvatures and directions |
//! | `planar` | filling a flat face with nearly equilateral triangles |
//! | `bspline` | B-spline curves and surfaces |
//! | `primitive` | planes, spheres, cylinders, cones, tori: distance and least-squares fit |
//! | `summary` | minimum, mean, percentiles, histogram of a list of numbers |
//! | `quadric` | sums of squared distances to planes |
//! | `quality` | mean ratio, aspect ratio, angles, scaled Jacobian |
//! | `hexes` | scaled Jacobian, volume and certificate of hexahedra |
//! | `search_tree` | closest points, neighbourhoods and rays over triangles |
//! | `closest`, `ray` | the same for one triangle |
//! | `slabs`, `slices` | contents of the tree's nodes: bounds along a normal; long triangles cut into slices |
//! | `intersections` | triangles of a surface that cut or touch each other, by exact predicates |
//! | `holes` | filling holes with faces that continue the surroundings |
//! | `thickness` | thin walls and narrow gaps |
//! | `transfer` | attributes carried to another mesh of the same surface |
//! | `winding` | inside or outside, also for broken surfaces |
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
