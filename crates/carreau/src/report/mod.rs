//! What people look at: pictures.
//!
//! | file | holds |
//! |---|---|
//! | `picture` | a mesh drawn to a PNG file, without GPU or display |
//! | `figure` | the usual picture of a mesh |

mod figure;
pub mod picture;

pub use figure::{curvature_figure, figure, hex_figure};
