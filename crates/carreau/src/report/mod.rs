//! What people look at: pictures and pages.
//!
//! | file | holds |
//! |---|---|
//! | `picture` | a mesh drawn to a PNG file, without GPU or display |
//! | `figure` | the usual picture of a mesh |
//! | `field` | the picture of a frame field |
//! | `graph` | the picture of a motorcycle graph |
//! | `page` | models in one HTML file, to turn and to ask |

mod field;
mod figure;
mod graph;
pub mod page;
pub mod picture;

pub use field::field_figure;
pub use figure::{cad_figure, curvature_figure, figure, hex_figure, skeleton_figure};
pub use graph::graph_figure;
