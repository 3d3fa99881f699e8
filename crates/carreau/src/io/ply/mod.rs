//! PLY (text, binary little and big endian), read and written.
//!
//! | in the file | in the mesh |
//! |---|---|
//! | element `vertex` with `x`, `y`, `z` | points |
//! | element `face` with a list `vertex_indices` or `vertex_index` | faces |
//! | element `tristrips` with a list | faces: the triangles of the strips |
//! | element `edge` with `vertex1`, `vertex2` and perhaps `tag` | edges and their tags |
//! | other scalar properties of vertices and faces | columns, as `columns` describes |
//! | everything else | left out |
//!
//! The format: "The PLY Polygon File Format", G. Turk, 1994. It is read here and not by the crate ply-rs-bw, which
//! knows no 64-bit integers, does not tell at which byte it stopped, rounds text to the declared single precision,
//! wants a line for every row of text, and reads text at a third of the speed.
//!
//! | file | does |
//! |---|---|
//! | `header` | elements, properties and types |
//! | `body` | the values behind the header, text or binary, into tables |
//! | `columns` | which properties make which column, both ways |
//! | `read`, `write` | tables to mesh, mesh to file |

mod body;
mod columns;
mod header;
mod read;
mod write;

pub(super) use read::read;
pub(super) use write::write;

#[cfg(test)]
mod tests;
