//! Geometry that knows no method: splines, boundary representations.

pub mod brep;
pub mod bspline;
