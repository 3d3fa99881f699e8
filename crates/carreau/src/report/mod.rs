//! Pictures and pages for people to look at.
//!
//! | file | holds |
//! |---|---|
//! | `picture` | draws a mesh into a PNG file, without GPU or display |
//! | `figure` | the usual pictures of meshes, CAD models, curvatures, skeletons, hexahedra |
//! | `field` | the picture of a frame field |
//! | `graph` | the picture of a motorcycle graph |
//! | `page` | models in one HTML file that can be turned and queried |

mod field;
mod figure;
mod graph;
pub mod page;
pub mod picture;

pub use field::field_figure;
pub use figure::{cad_figure, curvature_figure, figure, hex_figure, skeleton_figure};
pub use graph::graph_figure;
