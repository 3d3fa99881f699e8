//! The table of mesh formats.

use super::source::{Source, WriteOptions, extension};
use super::{fem, gltf, gmf, gmsh, medit, obj, off, ply, stl, threemf, vtk_legacy, vtk_xml};
use crate::error::Result;
use crate::mesh::RawMesh;
use std::path::Path;

pub type Reader = fn(&Source) -> Result<RawMesh>;
/// Appends the file's bytes; returns warnings about what the format cannot hold.
pub type Writer = fn(&RawMesh, &WriteOptions, &mut Vec<u8>) -> Result<Vec<String>>;

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
    pub(super) read: Reader,
    pub(super) write: Writer,
}

impl Format {
    pub(super) const fn surfaces(
        name: &'static str,
        extensions: &'static [&'static str],
        read: Reader,
        write: Writer,
    ) -> Self {
        Format { name, extensions, volumes: false, readable: true, read, write }
    }

    pub(super) const fn volumes(
        name: &'static str,
        extensions: &'static [&'static str],
        read: Reader,
        write: Writer,
    ) -> Self {
        Format { name, extensions, volumes: true, readable: true, read, write }
    }

    /// Input of finite element programs, which is only written.
    pub(super) const fn decks(
        name: &'static str,
        extensions: &'static [&'static str],
        read: Reader,
        write: Writer,
    ) -> Self {
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

/// The format that a path's extension names.
pub fn format_of(path: &Path) -> Option<&'static Format> {
    let wanted = extension(path);
    FORMATS.iter().find(|f| f.extensions.contains(&wanted.as_str()))
}
