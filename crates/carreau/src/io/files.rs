//! Reads and writes whole mesh files.

use super::atomic::write_atomically;
use super::formats::{FORMATS, Format, format_of};
use super::outputs::{ResultKind, check_format, holds_second_order};
use super::source::{Source, WriteOptions, extension};
use super::{advice, obj};
use crate::error::{Error, Place, Result};
use crate::mesh::RawMesh;
use std::path::Path;

pub fn known_format(path: &Path) -> Result<&'static Format> {
    format_of(path).ok_or_else(|| {
        let known: Vec<&str> = FORMATS.iter().filter(|f| f.readable).flat_map(|f| f.extensions).copied().collect();
        let known = known.join(", ");
        let found = extension(path);
        let what = match advice::advice(&found) {
            Some(advice) => {
                format!("a '.{found}' file cannot be read as a mesh: {advice}. Formats that are read: {known}")
            }
            None if found.is_empty() => format!("the name has no extension; known are: {known}"),
            None => format!("unknown extension '.{found}'; known are: {known}"),
        };
        Error::read(path, Place::File, what)
    })
}

/// Reads a mesh file; the extension decides the format.
///
/// # Errors
/// [`Error::Read`] for a file that cannot be read or whose format is unknown,
/// [`Error::Input`] for a mesh that makes no sense.
pub fn read(path: &Path) -> Result<RawMesh> {
    let format = known_format(path)?;
    let bytes = std::fs::read(path).map_err(|e| Error::read(path, Place::File, e.to_string()))?;
    if bytes.is_empty() {
        return Err(Error::read(path, Place::File, "the file is empty"));
    }
    let mesh = (format.read)(&Source { path, bytes: &bytes })?;
    mesh.check()?;
    Ok(mesh)
}

/// Writes a mesh file, whole or not at all; the extension decides the format. Returns warnings about what the format
/// cannot hold.
///
/// # Errors
/// [`Error::Write`] for a file that cannot be written or whose format is unknown,
/// [`Error::Input`] for a mesh that the format cannot hold.
pub fn write(path: &Path, mesh: &RawMesh, options: &WriteOptions) -> Result<Vec<String>> {
    let Some(format) = format_of(path) else {
        check_format(path, ResultKind::Any)?;
        return Err(Error::write(path, "there is no such format"));
    };
    let straight = (mesh.second_order.is_some() && !holds_second_order(path)).then(|| mesh.first_order());
    let mesh = straight.as_ref().unwrap_or(mesh);
    let mut bytes = Vec::new();
    let library = (format.name == "OBJ").then(|| obj::library_beside(mesh, path));
    if let Some(library) = &library {
        bytes.extend_from_slice(library.statements.as_bytes());
    }
    let mut warnings = (format.write)(mesh, options, &mut bytes)?;
    if let Some(library) = library {
        if let Some((beside, materials)) = library.file {
            write_atomically(&beside, &materials)?;
        }
        warnings.extend(library.warnings);
    }
    write_atomically(path, &bytes)?;
    if straight.is_some() {
        warnings.push(format!("{} has no place for cells of second order: their corners are written", format.name));
    }
    Ok(warnings)
}
