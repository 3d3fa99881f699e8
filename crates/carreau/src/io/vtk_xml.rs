//! VTK XML files: unstructured grids (`.vtu`) and polydata (`.vtp`).
//!
//! After: *VTK File Formats*, Kitware (section "XML File Formats") and, for compressed data, what VTK's own writers do.
//!
//! | file | holds |
//! |---|---|
//! | `read` | pieces, cells and data arrays |
//! | `payload` | the bytes of a data array: base64 or raw, plain or compressed |
//! | `write` | the writer |
//!
//! Read: text, inline base64, appended raw and base64; uncompressed, zlib, lzma, lz4; both byte orders; several pieces,
//! which are joined. Written: version 1.0, little endian, 64-bit heads, inline base64 of zlib blocks, or text.

mod payload;
mod read;
mod write;

pub(super) use read::read;
pub(super) use write::escaped;
pub(super) use write::{write_vtp, write_vtu};

#[cfg(test)]
mod tests;
