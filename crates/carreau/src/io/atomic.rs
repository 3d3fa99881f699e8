//! Files that appear whole or not at all.

use crate::error::{Error, Result};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Characters of the target's name in that of the unfinished file: names are limited to 255 bytes.
const SHORT_NAME: usize = 50;
/// Unfinished files of earlier runs that are passed over.
const MOST_LEFTOVERS: u32 = 1000;

/// Removes the unfinished file when the writing fails or panics.
pub(super) struct Unfinished(Option<PathBuf>);

impl Drop for Unfinished {
    fn drop(&mut self) {
        if let Some(path) = self.0.take() {
            // Nothing more can be done about a file that cannot be removed.
            let _ = fs::remove_file(path);
        }
    }
}

/// Writes beside the target, then renames: an existing file is replaced only by a finished one.
///
/// # Errors
/// [`Error::Write`]; the old file is as it was then.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<()> {
    let failed = |e: std::io::Error| Error::write(path, e);
    let Some(name) = path.file_name() else {
        return Err(Error::write(path, "this is not a file name"));
    };
    if path.is_dir() {
        return Err(Error::write(path, "this is a folder"));
    }
    // Through a link the rename would replace the link instead of the file it points to.
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    if let Ok(found) = fs::metadata(&target) {
        if !found.is_file() {
            return fs::write(&target, bytes).map_err(failed);
        }
        refuse_protected(path, &found)?;
    }
    let (mut file, mut unfinished) = create_beside(&target, &name.to_string_lossy()).map_err(failed)?;
    file.write_all(bytes).map_err(failed)?;
    drop(file);
    if let Some(beside) = &unfinished.0 {
        fs::rename(beside, &target).map_err(failed)?;
    }
    unfinished.0 = None;
    Ok(())
}

/// Refuses to replace a file that is write-protected: a new name for the finished one asks for rights in the folder only.
pub(super) fn refuse_protected(path: &Path, found: &fs::Metadata) -> Result<()> {
    if found.permissions().readonly() {
        return Err(Error::write(path, "this file is write-protected; give another name, or lift its protection"));
    }
    Ok(())
}

/// A new file in the target's folder. A killed run leaves its own behind, and process ids come back, in containers soon.
pub(super) fn create_beside(target: &Path, name: &str) -> std::io::Result<(fs::File, Unfinished)> {
    let short: String = name.chars().take(SHORT_NAME).collect();
    let process = std::process::id();
    let mut attempt = 0;
    loop {
        let number = if attempt == 0 { String::new() } else { format!(".{attempt}") };
        let beside = target.with_file_name(format!(".{short}.{process}{number}.part"));
        match fs::OpenOptions::new().write(true).create_new(true).open(&beside) {
            Ok(file) => return Ok((file, Unfinished(Some(beside)))),
            Err(e) if e.kind() == std::io::ErrorKind::AlreadyExists && attempt < MOST_LEFTOVERS => attempt += 1,
            Err(e) => return Err(e),
        }
    }
}
