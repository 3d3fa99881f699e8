//! Geometry that several rooms need: knows meshes, knows no room.
//!
//! | file | holds |
//! |---|---|
//! | `normals` | normals of faces, vertices and corners; angles |
//! | `features` | feature edges: sharp, border, tagged, listed; signed dihedral angles |
//! | `bspline` | B-spline curves and surfaces |
//! | `brep` | boundary representation: what CAD files hold |

pub mod brep;
pub mod bspline;
pub mod features;
pub mod normals;
