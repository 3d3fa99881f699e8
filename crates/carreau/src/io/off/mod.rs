//! Geomview OFF, read (text and binary) and written (text, since the binary form has single precision only).
//!
//! The keyword tells what each vertex has behind its coordinates: `N` a normal, `C` a colour, `ST` texture
//! coordinates, in this order; they become the vertex columns `normal`, `color`, `uv`. Numbers behind the corners of a
//! face are its colour and become the face column `color` where every face has one.
//!
//! The format: <http://www.geomview.org/docs/html/OFF.html>.

mod color;
mod read;
mod write;

pub(super) use read::read;
pub(super) use write::write;

#[cfg(test)]
mod tests;
