//! The page of a run (`--report`): its scenes while it goes on, the HTML at its end.

use carreau::report::page::{Page, Role, Scene};
use carreau::{Context, Error};
use serde_json::Value;
use std::cell::RefCell;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

thread_local! {
    /// The command line of the run on this thread.
    static COMMAND: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Remembers the command line of the run that follows on this thread.
pub fn remember_command(arguments: &[OsString]) {
    let words = arguments.iter().skip(1).map(|word| quoted(&word.to_string_lossy()));
    let line = std::iter::once("carreau".to_string()).chain(words).collect::<Vec<_>>().join(" ");
    COMMAND.set(line);
}

/// The command line of the run on this thread.
pub fn command_line() -> String {
    COMMAND.with_borrow(String::clone)
}

/// A word as a shell takes it.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "-_./=,:+@%^".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.into()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

/// The page of a run; empty where none was asked for.
#[derive(Default)]
pub struct Report {
    /// Where it goes, always the same.
    pub files: Vec<PathBuf>,
    /// What it shows, with the files the scenes came from or went to.
    scenes: Vec<(PathBuf, Scene)>,
}

impl Report {
    /// A page for this file, if any.
    pub fn to(file: Option<PathBuf>) -> Self {
        Report { files: file.into_iter().collect(), scenes: Vec::new() }
    }

    /// Adds a scene, where a page was asked for; the scene takes the name that `make` is given. A file that is there already
    /// is replaced.
    pub fn add(
        &mut self,
        file: &Path,
        role: Role,
        context: &Context,
        make: impl FnOnce(String, &Context) -> Result<Scene, Error> + Send,
    ) -> Result<(), Error> {
        if self.files.is_empty() {
            return Ok(());
        }
        let name = file.file_name().unwrap_or(file.as_os_str()).to_string_lossy().into_owned();
        let scene = context.install(|| {
            let _stage = context.stage("report");
            make(name, context)
        })?;
        let scene = scene.role(role);
        match self.scenes.iter_mut().find(|(shown, _)| shown == file) {
            Some(place) => place.1 = scene,
            None => self.scenes.push((file.to_path_buf(), scene)),
        }
        Ok(())
    }

    /// Whether a file is shown.
    pub fn has(&self, file: &Path) -> bool {
        self.scenes.iter().any(|(shown, _)| shown == file)
    }

    /// Puts the scenes of files in this order, none of them before or after another.
    pub fn equal(&mut self, files: &[&Path]) {
        let scenes = std::mem::take(&mut self.scenes);
        self.scenes = scenes.into_iter().map(|(file, scene)| (file, scene.role(Role::Other))).collect();
        self.scenes.sort_by_key(|(file, _)| files.iter().position(|f| f == file));
    }

    /// The HTML of a run with this record; its title names what the run was given. The scenes are gone then.
    pub fn html(&mut self, verb: &str, record: Value, context: &Context) -> Result<String, Error> {
        let scenes: Vec<Scene> = std::mem::take(&mut self.scenes).into_iter().map(|(_, scene)| scene).collect();
        let given: Vec<&str> = scenes.iter().filter(|s| s.as_role() != Role::After).map(Scene::name).collect();
        let title = format!("carreau {verb} {}", given.join(", "));
        let page = Page::new(title.trim_end()).command(command_line()).record(record).scenes(scenes);
        context.install(|| {
            let _stage = context.stage("report");
            page.html()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_quoted_as_a_shell_takes_them() {
        let words = ["/bin/carreau", "view", "a b.ply", "it's", "", "-o", "x=1%.html"].map(OsString::from);
        remember_command(&words);
        assert_eq!(command_line(), r"carreau view 'a b.ply' 'it'\''s' '' -o x=1%.html");
    }
}
