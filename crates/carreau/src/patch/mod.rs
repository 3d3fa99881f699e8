//! Room 3: quad patches on the vertices of a triangle mesh.

pub mod cad;
mod grid;

pub use grid::Patch;
