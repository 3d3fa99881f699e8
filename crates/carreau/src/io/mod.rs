//! Reading and writing mesh files: one file per format, one table of formats.
//!
//! Readers take the bytes of a file and return a [`RawMesh`]; they never panic, never allocate by a number they have
//! not checked against the size of the file, and say at which line or byte they stopped. Writers fill a buffer, which
//! [`write()`] puts in place in one step.

mod atomic;
mod binary;
pub mod cad;
mod gltf;
mod gmf;
mod gmsh;
pub mod iges;
mod limits;
mod medit;
mod medit_sections;
mod names;
mod obj;
mod off;
mod percent;
mod ply;
#[cfg(test)]
mod round_trips;
mod skeleton;
mod small_faces;
pub mod step;
mod stl;
#[cfg(test)]
mod surface_tests;
mod text;
mod vtk_arrays;
mod vtk_cells;
mod vtk_legacy;
mod vtk_xml;

use crate::error::{Error, Place, Result};
use crate::mesh::RawMesh;
use std::path::Path;

pub use atomic::write_atomically;
pub use cad::{CAD_EXTENSIONS, CadOptions, IgesForm, StepSchema, Unit, write_cad};
pub use skeleton::{SKELETON_EXTENSIONS, is_skeleton_file, read_skeleton, write_skeleton};

/// The content of a file and where it came from.
pub struct Source<'a> {
    /// As the caller named it; formats that refer to other files look beside it.
    pub path: &'a Path,
    /// The whole file.
    pub bytes: &'a [u8],
}

impl Source<'_> {
    /// A read error in this file.
    pub fn error(&self, place: Place, what: impl Into<String>) -> Error {
        Error::read(self.path, place, what)
    }
}

/// Choices of a writer.
#[derive(Debug, Clone, Copy, Default)]
pub struct WriteOptions {
    /// Text instead of binary, in formats that have both (PLY, STL, VTK, VTU, MSH).
    pub ascii: bool,
}

type Reader = fn(&Source) -> Result<RawMesh>;
/// Appends the file's bytes; returns warnings about what the format cannot hold.
type Writer = fn(&RawMesh, &WriteOptions, &mut Vec<u8>) -> Result<Vec<String>>;

/// A file format.
pub struct Format {
    /// Its usual name.
    pub name: &'static str,
    /// Extensions in lower case, without the dot; the first is the preferred one.
    pub extensions: &'static [&'static str],
    read: Reader,
    write: Writer,
}

/// All mesh formats. CAD formats, which are only written, are in [`crate::io`] too but take another model.
pub const FORMATS: &[Format] = &[
    Format { name: "OBJ", extensions: &["obj"], read: obj::read, write: obj::write },
    Format { name: "OFF", extensions: &["off"], read: off::read, write: off::write },
    Format { name: "PLY", extensions: &["ply"], read: ply::read, write: ply::write },
    Format { name: "STL", extensions: &["stl"], read: stl::read, write: stl::write },
    Format { name: "Medit", extensions: &["mesh"], read: medit::read, write: medit::write },
    Format { name: "Medit binary (GMF)", extensions: &["meshb"], read: gmf::read, write: gmf::write },
    Format { name: "Gmsh", extensions: &["msh"], read: gmsh::read, write: gmsh::write },
    Format { name: "VTK legacy", extensions: &["vtk"], read: vtk_legacy::read, write: vtk_legacy::write },
    Format { name: "VTK XML unstructured grid", extensions: &["vtu"], read: vtk_xml::read, write: vtk_xml::write_vtu },
    Format { name: "VTK XML polydata", extensions: &["vtp"], read: vtk_xml::read, write: vtk_xml::write_vtp },
    Format { name: "glTF", extensions: &["gltf"], read: gltf::read, write: gltf::write_gltf },
    Format { name: "GLB", extensions: &["glb"], read: gltf::read, write: gltf::write_glb },
];

/// The extension of a path in lower case.
pub fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

/// The format that a path's extension names.
pub fn format_of(path: &Path) -> Option<&'static Format> {
    let wanted = extension(path);
    FORMATS.iter().find(|f| f.extensions.contains(&wanted.as_str()))
}

fn known_format(path: &Path) -> Result<&'static Format> {
    format_of(path).ok_or_else(|| {
        let known: Vec<&str> = FORMATS.iter().flat_map(|f| f.extensions).copied().collect();
        let found = extension(path);
        let found =
            if found.is_empty() { "the name has no extension".into() } else { format!("unknown extension '.{found}'") };
        Error::read(path, Place::File, format!("{found}; known are: {}", known.join(", ")))
    })
}

/// Reads a mesh file; the extension decides the format.
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
pub fn write(path: &Path, mesh: &RawMesh, options: &WriteOptions) -> Result<Vec<String>> {
    let format = known_format(path)?;
    let mut bytes = Vec::new();
    let warnings = (format.write)(mesh, options, &mut bytes)?;
    write_atomically(path, &bytes)?;
    Ok(warnings)
}
