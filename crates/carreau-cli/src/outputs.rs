//! What a run will write, checked before it begins: nobody shall work for minutes to find that a name, a folder or a format
//! was wrong. Each verb declares its inputs and outputs ([`Outputs`]); the checks are the same for all.

use crate::common::Common;
use carreau::io::{self, ResultKind};
use carreau::{Error, Result};
use std::path::{Path, PathBuf};

/// What goes into a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Content {
    /// A result, in a format for it.
    Result(ResultKind),
    /// A picture: PNG.
    Picture,
    /// A page: HTML.
    Page,
    /// JSON: a record or a layout; any name will do.
    Json,
}

/// A file that is read, and what it holds where that is known.
struct Read {
    file: PathBuf,
    content: Option<Content>,
}

/// A file that is written.
struct Written {
    file: PathBuf,
    content: Content,
    /// The option that names it.
    option: &'static str,
}

/// The files of a run.
#[derive(Default)]
pub struct Outputs {
    read: Vec<Read>,
    written: Vec<Written>,
}

impl Outputs {
    /// The files that the common options name. What a host holds in place of a file is none.
    pub fn of(common: &Common) -> Self {
        let mut all = Outputs::default();
        if let Some(file) = &common.options {
            all.read.push(Read { file: file.clone(), content: Some(Content::Json) });
        }
        let json = common.json.as_ref().filter(|file| file.as_os_str() != "-");
        all.add("--json", json.map(PathBuf::as_path), Content::Json);
        all.add("--picture", common.picture.as_deref(), Content::Picture);
        all.add("--report", common.report.as_deref(), Content::Page);
        all
    }

    /// A file that is read; a result may replace it where it is of this kind.
    pub fn reads(mut self, file: &Path, kind: ResultKind) -> Self {
        self.read.push(Read { file: file.to_path_buf(), content: Some(Content::Result(kind)) });
        self
    }

    /// A file that is read and must not be replaced.
    pub fn needs(mut self, file: Option<&Path>) -> Self {
        self.read.extend(file.map(|file| Read { file: file.to_path_buf(), content: None }));
        self
    }

    /// The file that `-o` names.
    pub fn writes(self, file: Option<&Path>, kind: ResultKind) -> Self {
        self.also("--output", file, Content::Result(kind))
    }

    /// Another file that is written, and the option that names it.
    pub fn also(mut self, option: &'static str, file: Option<&Path>, content: Content) -> Self {
        self.add(option, file, content);
        self
    }

    fn add(&mut self, option: &'static str, file: Option<&Path>, content: Content) {
        self.written.extend(file.map(|file| Written { file: file.to_path_buf(), content, option }));
    }

    /// Refuses what cannot be written, and what would write over something that is needed.
    ///
    /// # Errors
    /// [`Error::Write`] for a format that does not fit, a folder that is missing or may not be written to;
    /// [`Error::Options`] for paths that clash.
    pub fn check(&self) -> Result<()> {
        self.written.iter().try_for_each(Written::check)?;
        let places: Vec<PathBuf> = self.written.iter().map(|w| place(&w.file)).collect();
        for (k, one) in self.written.iter().enumerate() {
            if is_special(&one.file) {
                continue;
            }
            if let Some(j) = places[..k].iter().position(|other| *other == places[k]) {
                let (file, other) = (one.file.display(), &self.written[j]);
                let what = format!("{file}: {} and {} name the same file; give each its own", other.option, one.option);
                return Err(Error::Options(what));
            }
            let same_place = |read: &&Read| place(&read.file) == places[k];
            let replaced = self.read.iter().find(|read| same_place(read) && read.content != Some(one.content));
            if let Some(read) = replaced {
                let (file, option) = (read.file.display(), one.option);
                return Err(Error::Options(format!(
                    "{file}: {option} would replace an input of the run by something else; give another name"
                )));
            }
        }
        Ok(())
    }
}

impl Written {
    fn check(&self) -> Result<()> {
        let refuse = |what: String| Err(Error::write(&self.file, what));
        let extension = io::extension(&self.file);
        let wrong = |wanted: &str| {
            refuse(format!("{} writes {wanted}, the name ends with '.{extension}': take .{wanted}", self.option))
        };
        match self.content {
            _ if is_special(&self.file) && !matches!(self.content, Content::Result(_)) => {}
            Content::Result(kind) => io::check_format(&self.file, kind)?,
            Content::Picture if extension != "png" => return wrong("png"),
            Content::Page if !matches!(extension.as_str(), "html" | "htm") => return wrong("html"),
            _ => {}
        }
        io::check_place(&self.file)
    }
}

/// Where a name leads: the same for all names of one file.
fn place(file: &Path) -> PathBuf {
    if let Ok(there) = file.canonicalize() {
        return there;
    }
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let folder = folder.canonicalize().unwrap_or_else(|_| folder.to_path_buf());
    folder.join(file.file_name().unwrap_or_default())
}

/// A device or a pipe, which takes any content.
fn is_special(file: &Path) -> bool {
    std::fs::metadata(file).is_ok_and(|found| !found.is_file() && !found.is_dir())
}
