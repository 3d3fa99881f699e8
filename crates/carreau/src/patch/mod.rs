//! Room 3: quad patches on the vertices of a triangle mesh.

mod grid;

pub use grid::Patch;
