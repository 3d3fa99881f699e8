//! What people look at: pictures.
//!
//! | file | holds |
//! |---|---|
//! | `picture` | a mesh drawn to a PNG file, without GPU or display |

pub mod picture;
