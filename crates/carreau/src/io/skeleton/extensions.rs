//! Which files hold skeletons.

use crate::io::source::extension;
use std::path::Path;

/// Extensions of files that hold skeletons only.
pub const SKELETON_EXTENSIONS: &[&str] = &["cgr", "cg", "skel", "swc", "tgf"];
/// Extensions of mesh files whose lines may be a skeleton.
pub const POLYLINE_EXTENSIONS: &[&str] = &["vtp", "vtk", "vtu", "obj"];

/// Whether a path names a skeleton file by its extension alone.
pub fn is_skeleton_file(path: &Path) -> bool {
    SKELETON_EXTENSIONS.contains(&extension(path).as_str())
}
