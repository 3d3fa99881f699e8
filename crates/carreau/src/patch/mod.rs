//! Room 3: quad patches on the vertices of a triangle mesh.

mod concave;
mod dissection;
mod grid;
mod polygon;
mod rectangles;
#[cfg(test)]
mod samples;

pub use dissection::minimum;
pub use grid::Patch;
pub use polygon::{Cell, NONE, Polygon, Rectangle};
pub use rectangles::{CornerRule, greedy};
