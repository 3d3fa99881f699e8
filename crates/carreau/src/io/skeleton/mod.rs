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
mod polylines;
mod skel;
mod swc;
#[cfg(test)]
mod tests;
mod tgf;

use super::text::{Scanner, parse_float, parse_integer, shown};
use super::{Source, extension, write_atomically};
use crate::error::{Error, Place, Result};
use crate::mesh::CurveNet;
use std::path::Path;

/// Extensions of files that hold skeletons only.
pub const SKELETON_EXTENSIONS: &[&str] = &["cgr", "cg", "skel", "swc", "tgf"];
/// Extensions of mesh files whose lines may be a skeleton.
const POLYLINE_EXTENSIONS: &[&str] = &["vtp", "vtk", "vtu", "obj"];

/// Whether a path names a skeleton file by its extension alone.
pub fn is_skeleton_file(path: &Path) -> bool {
    SKELETON_EXTENSIONS.contains(&extension(path).as_str())
}

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

/// Line of a text file with its words.
struct Line<'a> {
    number: u64,
    words: Vec<&'a [u8]>,
}

/// The lines that hold anything, comments left out.
fn lines<'a>(source: &'a Source<'a>, comment: Option<u8>) -> Vec<Line<'a>> {
    let mut text = Scanner::new(source, comment);
    let mut lines = Vec::new();
    loop {
        let number = text.line_number();
        let words: Vec<&[u8]> = std::iter::from_fn(|| text.word_on_line()).collect();
        if !words.is_empty() {
            lines.push(Line { number, words });
        }
        if !text.next_line() {
            return lines;
        }
    }
}

impl Line<'_> {
    fn error(&self, source: &Source, what: impl Into<String>) -> Error {
        source.error(Place::Line(self.number), what)
    }

    fn has(&self, source: &Source, fields: usize, what: &str) -> Result<()> {
        match self.words.len() {
            n if n >= fields => Ok(()),
            n => Err(self.error(source, format!("{what} needs {fields} fields, there are {n}"))),
        }
    }

    /// The number in a field; NaN and infinity are numbers here, refused later with exit code 3.
    fn float(&self, source: &Source, field: usize) -> Result<f64> {
        let word = self.words.get(field).copied().unwrap_or_default();
        parse_float(word).ok_or_else(|| self.error(source, format!("a number is expected, found '{}'", shown(word))))
    }

    fn integer(&self, source: &Source, field: usize) -> Result<i64> {
        let word = self.words.get(field).copied().unwrap_or_default();
        parse_integer(word)
            .ok_or_else(|| self.error(source, format!("an integer is expected, found '{}'", shown(word))))
    }

    fn point(&self, source: &Source, first: usize) -> Result<glam::DVec3> {
        let x = |k: usize| self.float(source, first + k);
        Ok(glam::DVec3::new(x(0)?, x(1)?, x(2)?))
    }
}
