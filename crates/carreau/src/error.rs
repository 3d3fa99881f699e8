//! What can go wrong, in one flat enum. Each kind has the exit code of the command line.

use std::fmt;
use std::path::{Path, PathBuf};

/// Every failure of the library. Messages say what is wrong, where, and what to do about it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be read: it does not exist, its extension is unknown, or its content is malformed.
    #[error("{}: {place}{what}", file.display())]
    Read {
        /// The file as the caller named it.
        file: PathBuf,
        /// Where in the file.
        place: Place,
        /// What was found and what was expected.
        what: String,
    },
    /// A file could not be written. Nothing was left behind.
    #[error("{}: {what}", file.display())]
    Write {
        /// The file as the caller named it.
        file: PathBuf,
        /// The reason.
        what: String,
    },
    /// The input was read but is not acceptable for what was asked.
    #[error("{what}{}{}", Clause("; at ", place), Clause("; ", remedy))]
    Input {
        /// What is wrong.
        what: String,
        /// Where: ids of vertices, edges or faces; may be empty.
        place: String,
        /// What the user can do about it; may be empty.
        remedy: String,
    },
    /// An option has a value that makes no sense, or two options contradict each other.
    #[error("{0}")]
    Options(String),
    /// The method could not reach what was asked.
    #[error("{0}")]
    Numeric(String),
    /// The user cancelled the run.
    #[error("cancelled")]
    Cancelled,
    /// The deadline passed before the work was done.
    #[error("the deadline passed before the work was done")]
    Deadline,
    /// A result failed its own validation: a defect of carreau, never of the input.
    #[error("internal error: {0}; please report it with the input file")]
    Bug(String),
}

/// `Result` with the library's [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

/// A place in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    File,
    /// A line of a text file, counted from 1.
    Line(u64),
    /// A byte offset of a binary file, counted from 0.
    Byte(u64),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::File => Ok(()),
            Place::Line(n) => write!(f, "line {n}: "),
            Place::Byte(n) => write!(f, "byte {n}: "),
        }
    }
}

/// An optional clause of a message: the separator is written only where there is something to separate.
struct Clause<'a>(&'static str, &'a str);

impl fmt::Display for Clause<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.1.is_empty() { Ok(()) } else { write!(f, "{}{}", self.0, self.1) }
    }
}

impl Error {
    /// An input error with all three parts; pass `""` for a part that does not apply.
    pub fn input(what: impl Into<String>, place: impl Into<String>, remedy: impl Into<String>) -> Self {
        Error::Input { what: what.into(), place: place.into(), remedy: remedy.into() }
    }

    /// A read error at a place of a file.
    pub fn read(file: &Path, place: Place, what: impl Into<String>) -> Self {
        Error::Read { file: file.to_path_buf(), place, what: what.into() }
    }

    /// A write error.
    pub fn write(file: &Path, what: impl fmt::Display) -> Self {
        Error::Write { file: file.to_path_buf(), what: what.to_string() }
    }

    /// The exit code of the command line for this error.
    pub fn exit_code(&self) -> u8 {
        match self {
            Error::Options(_) => 2,
            Error::Input { .. } => 3,
            Error::Numeric(_) => 4,
            Error::Read { .. } | Error::Write { .. } => 5,
            Error::Bug(_) => 70,
            Error::Deadline => 124,
            Error::Cancelled => 130,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_have_no_empty_clauses() {
        assert_eq!(Error::input("no faces", "", "").to_string(), "no faces");
        assert_eq!(Error::input("no faces", "", "add some").to_string(), "no faces; add some");
        assert_eq!(
            Error::read(Path::new("a.obj"), Place::Line(3), "bad number").to_string(),
            "a.obj: line 3: bad number"
        );
    }
}
