//! What can be written where, before anything is: whether a format holds a kind of result, whether a place can be written to;
//! and what to do about files that are not read.

use super::atomic::{create_beside, refuse_protected};
use super::formats::{FORMATS, format_of};
use super::source::extension;
use super::{CAD_EXTENSIONS, SKELETON_EXTENSIONS};
use crate::error::{Error, Result};
use std::path::Path;

/// What a method makes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResultKind {
    /// A surface: faces, no cells.
    Surface,
    /// A surface, or a CAD model of it.
    SurfaceOrCad,
    /// A CAD model.
    Cad,
    /// A volume mesh.
    Hexes,
    /// A net of curves with radii.
    Skeleton,
    /// What is in a mesh file, whatever that is.
    Any,
}

/// Extensions of formats that are written with cells of second order.
const SECOND_ORDER: &[&str] = &["vtu", "vtk", "msh", "inp"];
/// Extensions of mesh files whose lines may be a skeleton.
const POLYLINES: &[&str] = &["vtp", "vtk", "vtu", "obj"];

/// Refuses a file name whose extension names no format for this kind of result.
///
/// # Errors
/// [`Error::Write`]; the message names the formats that would do, or the verb that writes this one.
pub fn check_format(path: &Path, kind: ResultKind) -> Result<()> {
    let found = extension(path);
    let ending = found.as_str();
    let is_cad = CAD_EXTENSIONS.contains(&ending);
    let is_skeleton = SKELETON_EXTENSIONS.contains(&ending);
    let fits = match kind {
        ResultKind::Surface | ResultKind::Any => format_of(path).is_some(),
        ResultKind::SurfaceOrCad => is_cad || format_of(path).is_some(),
        ResultKind::Cad => is_cad,
        ResultKind::Hexes => format_of(path).is_some_and(|f| f.volumes),
        ResultKind::Skeleton => is_skeleton || POLYLINES.contains(&ending),
    };
    if fits {
        return Ok(());
    }
    let known = known(kind);
    let what = match kind {
        _ if ending.is_empty() => format!("the name has no extension, which says the format; known are: {known}"),
        ResultKind::Surface | ResultKind::Any if is_cad => format!(
            "'.{ending}' is a CAD format and this is a mesh: `carreau cad` makes a solid with few exact faces of it, \
             `carreau patch` quad patches; for a mesh take one of: {known}"
        ),
        ResultKind::Surface | ResultKind::SurfaceOrCad if is_skeleton => {
            format!("'.{ending}' holds skeletons and this is a surface; take one of: {known}")
        }
        ResultKind::Hexes if is_cad => {
            format!("'.{ending}' is a CAD format and this is a volume mesh; take one of: {known}")
        }
        ResultKind::Hexes if format_of(path).is_some() => {
            format!("'.{ending}' holds surfaces and this is a volume mesh; take one of: {known}")
        }
        ResultKind::Skeleton if format_of(path).is_some() || is_cad => {
            format!("'.{ending}' has no place for a skeleton; take one of: {known}")
        }
        ResultKind::Cad if format_of(path).is_some() => {
            format!("'.{ending}' holds meshes and this is a CAD model; take one of: {known}")
        }
        _ => format!("unknown extension '.{ending}'; known are: {known}"),
    };
    Err(Error::write(path, what))
}

/// The extensions of the formats for a kind of result.
fn known(kind: ResultKind) -> String {
    let meshes = |wanted: fn(&super::formats::Format) -> bool| -> Vec<&str> {
        FORMATS.iter().filter(|f| wanted(f)).flat_map(|f| f.extensions).copied().collect()
    };
    let all = match kind {
        ResultKind::Surface | ResultKind::Any => meshes(|_| true),
        ResultKind::SurfaceOrCad => [meshes(|_| true), CAD_EXTENSIONS.to_vec()].concat(),
        ResultKind::Cad => CAD_EXTENSIONS.to_vec(),
        ResultKind::Hexes => meshes(|f| f.volumes),
        ResultKind::Skeleton => [SKELETON_EXTENSIONS, POLYLINES].concat(),
    };
    all.join(", ")
}

/// Whether a format has a place for any numbers on vertices and faces.
pub fn holds_numbers(path: &Path) -> bool {
    matches!(extension(path).as_str(), "ply" | "vtk" | "vtu" | "vtp")
}

/// Whether a format is written with cells of second order.
pub fn holds_second_order(path: &Path) -> bool {
    SECOND_ORDER.contains(&extension(path).as_str())
}

/// Refuses a file name whose extension names a format that is not written with cells of second order.
///
/// # Errors
/// [`Error::Write`].
pub fn check_second_order(path: &Path) -> Result<()> {
    if holds_second_order(path) {
        return Ok(());
    }
    let what = format!(
        "'.{}' is not written with cells of second order; take one of: {}",
        extension(path),
        SECOND_ORDER.join(", ")
    );
    Err(Error::write(path, what))
}

/// Refuses a place that cannot be written to: a folder, a file that is write-protected, a name in a folder that does not exist or
/// may not be written to.
/// Leaves no trace.
///
/// # Errors
/// [`Error::Write`].
pub fn check_place(path: &Path) -> Result<()> {
    let Some(name) = path.file_name() else {
        return Err(Error::write(path, "this is not a file name"));
    };
    if path.is_dir() {
        return Err(Error::write(path, "this is a folder; give the name of a file in it"));
    }
    let target = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
    if let Ok(found) = std::fs::metadata(&target) {
        if !found.is_file() {
            // Devices and pipes are opened when there is something to write.
            return Ok(());
        }
        refuse_protected(path, &found)?;
    }
    let folder = target.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.exists() {
        return Err(Error::write(path, format!("there is no folder {}; make it first", folder.display())));
    }
    if !folder.is_dir() {
        return Err(Error::write(path, format!("{} is not a folder", folder.display())));
    }
    // The unfinished file is removed with its guard.
    create_beside(&target, &name.to_string_lossy()).map(drop).map_err(|e| Error::write(path, e))
}
