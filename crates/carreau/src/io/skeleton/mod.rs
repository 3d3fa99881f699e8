//! Skeleton files: nets of curves with radii.
//!
//! | file | format |
//! |---|---|
//! | `cg` | `.cgr`, `.cg`: lines `v x y z [radius]` and `e i j`, counted from 0 |
//! | `skel` | `.skel`: `id x y z radius number-of-neighbours neighbours…` |
//! | `swc` | `.swc`: `id type x y z radius parent`, neurons |
//! | `tgf` | `.tgf`: `id x y z` lines, `#`, `i j` lines |
//! | `polylines` | the lines of `.vtp`, `.vtk`, `.vtu`, `.obj` files with a radius column |

mod cg;
mod extensions;
mod lines;
mod polylines;
mod skel;
mod swc;
#[cfg(test)]
mod tests;
mod tgf;

use super::source::{Source, extension};
use super::write_atomically;
use crate::error::{Error, Place, Result};
use crate::mesh::CurveNet;
use extensions::POLYLINE_EXTENSIONS;
use std::path::Path;

pub use extensions::{SKELETON_EXTENSIONS, is_skeleton_file};

/// Reads a skeleton; the extension decides the format. What was mended stands in the notes.
///
/// # Errors
/// [`Error::Read`] for a file that cannot be understood, [`Error::Input`] for one that says what no skeleton can be.
pub fn read_skeleton(path: &Path) -> Result<CurveNet> {
    let extension = extension(path);
    if POLYLINE_EXTENSIONS.contains(&extension.as_str()) {
        return polylines::read(path);
    }
    let reader = match extension.as_str() {
        "cgr" | "cg" => cg::read,
        "skel" => skel::read,
        "swc" => swc::read,
        "tgf" => tgf::read,
        _ => return Err(unknown(path)),
    };
    let bytes = std::fs::read(path).map_err(|e| Error::read(path, Place::File, e.to_string()))?;
    if let Some(zero) = bytes.iter().position(|&b| b == 0) {
        return Err(Error::read(path, Place::Byte(zero as u64), "a text file is expected, this byte is zero"));
    }
    reader(&Source { path, bytes: &bytes })
}

/// Writes a skeleton, whole or not at all; the extension decides the format. Returns warnings.
///
/// # Errors
/// [`Error::Input`] for a net that the format cannot hold, [`Error::Write`] when the file cannot be written.
pub fn write_skeleton(path: &Path, net: &CurveNet) -> Result<Vec<String>> {
    let extension = extension(path);
    if POLYLINE_EXTENSIONS.contains(&extension.as_str()) {
        return polylines::write(path, net);
    }
    let mut out = Vec::new();
    match extension.as_str() {
        "cgr" | "cg" => cg::write(net, &mut out),
        "skel" => skel::write(net, &mut out),
        "swc" => swc::write(net, &mut out)?,
        "tgf" => tgf::write(net, &mut out),
        _ => return Err(unknown(path)),
    }
    write_atomically(path, &out)?;
    Ok(Vec::new())
}

fn unknown(path: &Path) -> Error {
    let known = [SKELETON_EXTENSIONS, POLYLINE_EXTENSIONS].concat().join(", ");
    Error::read(path, Place::File, format!("'.{}' is not a skeleton format; known are: {known}", extension(path)))
}
