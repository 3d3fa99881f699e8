//! What a sample is made as.

use super::shape::{Measure, Shape};
use crate::mesh::SurfaceMesh;

/// A mesh and what is known about it.
#[derive(Debug, Clone)]
pub struct Model {
    /// Triangles with the face column `truth`; the words for its labels are in the attributes' names.
    pub mesh: SurfaceMesh,
    /// The exact surface of every label.
    pub shapes: Vec<Shape>,
    /// Area and volume of the smooth model, where they are known.
    pub exact: Option<Measure>,
    /// How far vertices lie off their shapes at most, rounding aside; zero but for noisy models.
    pub noise: f64,
}
