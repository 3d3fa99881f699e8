//! What readers and writers are given.

use crate::error::{Error, Place};
use std::path::Path;

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

/// The extension of a path in lower case.
pub fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}
