//! Reading and writing files: one file per format, one table of formats ([`FORMATS`]).
//!
//! A reader turns the bytes of a file into a [`RawMesh`]. It never panics, never allocates by a number that it has not checked
//! against the size of the file, and says at which line or byte it stopped. A writer fills a buffer, which [`write()`] puts in
//! place in one step: the file appears whole or not at all.
//!
//! | file | holds |
//! |---|---|
//! | `obj`, `off`, `ply`, `stl`, `gltf`, `threemf` | formats of surfaces |
//! | `medit`, `gmf`, `gmsh`, `vtk_legacy`, `vtk_xml` | formats of surfaces and volumes |
//! | `fem` | input of finite element programs, which is only written |
//! | `skeleton` | formats of skeletons |
//! | `cad`, `step`, `iges` | CAD models, which are only written |
//! | `text`, `binary`, `limits`, `names`, `percent` | what readers and writers share |
//! | `outputs`, `atomic` | checks of an output before any work; writing in one step |

mod atomic;
mod binary;
pub mod cad;
mod fem;

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
mod outputs;
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
mod threemf;
mod vtk_arrays;
mod vtk_cells;
mod vtk_legacy;
mod vtk_xml;

use crate::error::{Error, Place, Result};
use crate::mesh::RawMesh;
use std::path::Path;

pub use atomic::write_atomically;
pub use cad::{CAD_EXTENSIONS, CadOptions, IgesForm, StepSchema, Unit, write_cad};
pub use outputs::{ResultKind, check_format, check_place, check_second_order, holds_numbers, holds_second_order};
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
    /// Whether it holds volume cells.
    pub volumes: bool,
    /// Whether it is read, too; the reader of one that is not says what to do instead.
    pub readable: bool,
    read: Reader,
    write: Writer,
}

impl Format {
    const fn surfaces(name: &'static str, extensions: &'static [&'static str], read: Reader, write: Writer) -> Self {
        Format { name, extensions, volumes: false, readable: true, read, write }
    }

    const fn volumes(name: &'static str, extensions: &'static [&'static str], read: Reader, write: Writer) -> Self {
        Format { name, extensions, volumes: true, readable: true, read, write }
    }

    /// Input of finite element programs, which is only written.
    const fn decks(name: &'static str, extensions: &'static [&'static str], read: Reader, write: Writer) -> Self {
        Format { name, extensions, volumes: true, readable: false, read, write }
    }
}

/// All mesh formats. CAD formats, which are only written, are in [`crate::io`] too but take another model.
pub const FORMATS: &[Format] = &[
    Format::surfaces("OBJ", &["obj"], obj::read, obj::write),
    Format::surfaces("OFF", &["off"], off::read, off::write),
    Format::surfaces("PLY", &["ply"], ply::read, ply::write),
    Format::surfaces("STL", &["stl"], stl::read, stl::write),
    Format::volumes("Medit", &["mesh"], medit::read, medit::write),
    Format::volumes("Medit binary (GMF)", &["meshb"], gmf::read, gmf::write),
    Format::volumes("Gmsh", &["msh"], gmsh::read, gmsh::write),
    Format::volumes("VTK legacy", &["vtk"], vtk_legacy::read, vtk_legacy::write),
    Format::volumes("VTK XML unstructured grid", &["vtu"], vtk_xml::read, vtk_xml::write_vtu),
    Format::surfaces("VTK XML polydata", &["vtp"], vtk_xml::read, vtk_xml::write_vtp),
    Format::surfaces("glTF", &["gltf"], gltf::read, gltf::write_gltf),
    Format::surfaces("GLB", &["glb"], gltf::read, gltf::write_glb),
    Format::surfaces("3MF", &["3mf"], threemf::read, threemf::write),
    Format::decks("Abaqus and CalculiX", &["inp"], fem::read, fem::write_inp),
    Format::decks("Nastran", &["bdf", "nas"], fem::read, fem::write_bdf),
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
        let known: Vec<&str> = FORMATS.iter().filter(|f| f.readable).flat_map(|f| f.extensions).copied().collect();
        let known = known.join(", ");
        let found = extension(path);
        let what = match outputs::advice(&found) {
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
