//! What a run fails with.

use carreau::Error;
use std::fmt;
use std::path::{Path, PathBuf};

/// A failure with the file it is about.
pub struct Failure {
    file: Option<PathBuf>,
    error: Error,
}

impl Failure {
    /// An error of a run that is about this file.
    pub fn about(file: Option<&Path>, error: Error) -> Self {
        Failure { file: file.map(Path::to_path_buf), error }
    }

    /// The exit code of the contract.
    pub fn exit_code(&self) -> u8 {
        self.error.exit_code()
    }

    /// The error, for a caller who knows which mesh it is about.
    pub fn into_error(self) -> Error {
        self.error
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Failure { file: None, error }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (&self.file, &self.error) {
            // These name their file themselves.
            (_, Error::Read { .. } | Error::Write { .. }) | (None, _) => write!(f, "{}", self.error),
            (Some(file), error) => write!(f, "{}: {error}", file.display()),
        }
    }
}

/// An error about one of several inputs, with the name of that file.
pub fn named(file: &Path, error: Error) -> Error {
    match error {
        Error::Input { what, place, remedy } => {
            Error::Input { what: format!("{}: {what}", file.display()), place, remedy }
        }
        other => other,
    }
}
