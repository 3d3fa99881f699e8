//! carreau turns triangle surfaces into structured models.

pub mod bounds;
pub mod brep;
pub mod cad;
pub mod context;
pub mod error;
pub mod field;
pub mod geometry;
pub mod hex;
pub mod io;
pub mod length;
pub mod mesh;
pub mod numeric;
pub mod patch;
pub mod quad;
pub mod remesh;
pub mod report;
pub mod sample;
pub mod segment;
pub mod skeleton;
pub mod words;

pub use context::Context;
pub use error::{Error, Place, Result};
/// The vector type of points and directions (three `f64`).
pub use glam::DVec3;
pub use length::Length;
