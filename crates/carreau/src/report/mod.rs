//! What people look at: pictures and pages.
//!
//! | file | holds |
//! |---|---|
//! | `picture` | a mesh drawn to a PNG file, without GPU or display |
//! | `figure` | the usual picture of a mesh |
//! | `field` | the picture of a frame field |
//! | `page` | models in one HTML file, to turn and to ask |

mod field;
mod figure;
pub mod page;
pub mod picture;

pub use field::field_figure;
pub use figure::{curvature_figure, figure, hex_figure, skeleton_figure};
