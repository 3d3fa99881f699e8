//! Wavefront OBJ, read and written.
//!
//! | in the file | in the mesh |
//! |---|---|
//! | `v x y z`, `v x y z w` | points; weights mean nothing to polygons |
//! | `v x y z r g b` (a custom of many programs) | vertex column `color`, where every vertex has one |
//! | `f` | faces, with their polygons; relative indices and vertices that come later are understood |
//! | `vt`, `vn` | corner columns `uv` and `normal`, where every corner has one; vertices are never split |
//! | `g`, `o`, `usemtl` | face columns `group`, `object`, `material`: labels in order of first use, words in `names` |
//! | `l` | edges |
//! | `mtllib` | the library's bytes in `libraries`; its diffuse colours and opacities in `colors` of the label `material` |
//!
//! Other statements describe curves, points and shading and are passed over.
//!
//! | file | holds |
//! |---|---|
//! | `read` | the reader |
//! | `library` | material libraries (`.mtl`), read and written |
//! | `write` | the writer |
//!
//! The format: "Object Files (.obj)", appendix B1 of the Wavefront Advanced Visualizer manual. Beyond it, names may
//! contain blanks, since exporters write such.

mod library;
mod read;
#[cfg(test)]
mod tests;
mod values;
mod words;
mod write;

pub(super) use library::library_beside;
pub(super) use read::read;
pub(super) use write::write;
