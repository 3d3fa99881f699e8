//! One run of a verb: its context, its input and output files, its record.

use crate::common::{Common, CommonValues};
use crate::progress::Bar;
use crate::record::Record;
use crate::timings::Timings;
use carreau::mesh::{CurveNet, RawMesh, SurfaceMesh};
use carreau::report::figure;
use carreau::report::page::{Page, Role, Scene};
use carreau::report::picture::Image;
use carreau::{Context, Error, io};
use serde::Serialize;
use serde_json::json;
use std::cell::RefCell;
use std::ffi::OsString;
use std::fmt;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use tracing_subscriber::filter::LevelFilter;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::{Layer, fmt as log};

/// A failure with the file it is about.
pub struct Failure {
    file: Option<PathBuf>,
    error: Error,
}

impl Failure {
    /// The exit code of the contract.
    pub fn exit_code(&self) -> u8 {
        self.error.exit_code()
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

/// Set by Ctrl-C; every context of the process listens to it.
fn cancel_flag() -> Arc<AtomicBool> {
    use std::sync::OnceLock;
    static FLAG: OnceLock<Arc<AtomicBool>> = OnceLock::new();
    Arc::clone(FLAG.get_or_init(|| {
        let flag = Arc::new(AtomicBool::new(false));
        let set = Arc::clone(&flag);
        // Where a handler exists already (embedding in Python), that one decides.
        let _ = ctrlc::set_handler(move || set.store(true, Ordering::Relaxed));
        flag
    }))
}

thread_local! {
    /// The command line of the run on this thread, for pages.
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

/// A run in progress.
pub struct Session {
    /// Threads, deadline, cancellation, progress.
    pub context: Context,
    /// What the run will tell.
    pub record: Record,
    json: Option<PathBuf>,
    picture: Option<PathBuf>,
    /// Pages to write, all the same.
    reports: Vec<PathBuf>,
    /// What the page will show, with the files it came from or went to.
    scenes: Vec<(PathBuf, Scene)>,
    quiet: bool,
    timings: Timings,
    /// Lines for a person, printed when the record does not go to stdout.
    summary: Vec<String>,
}

impl Session {
    /// Runs the work of a verb; its record is written when it succeeds. `files` are the inputs, for messages.
    pub fn run(
        verb: &'static str,
        common: &Common,
        values: &CommonValues,
        file: Option<&Path>,
        work: impl FnOnce(&mut Session) -> Result<(), Error>,
    ) -> Result<(), Failure> {
        let timings = Timings::new();
        let level = match (common.quiet, common.verbose) {
            (true, _) => LevelFilter::ERROR,
            (_, 0) => LevelFilter::WARN,
            (_, 1) => LevelFilter::INFO,
            _ => LevelFilter::DEBUG,
        };
        let spans = if common.verbose > 0 { log::format::FmtSpan::CLOSE } else { log::format::FmtSpan::NONE };
        let stderr =
            log::layer().with_writer(std::io::stderr).without_time().with_target(false).with_span_events(spans);
        let subscriber = tracing_subscriber::registry().with(timings.clone()).with(stderr.with_filter(level));
        tracing::subscriber::with_default(subscriber, || {
            let finished = Self::start(verb, common, values, timings).and_then(|mut session| {
                work(&mut session)?;
                session.finish()
            });
            finished.map_err(|error| Failure { file: file.map(Path::to_path_buf), error })
        })
    }

    fn start(verb: &'static str, common: &Common, values: &CommonValues, timings: Timings) -> Result<Self, Error> {
        let mut context = Context::new().with_threads(values.threads)?.with_cancel(cancel_flag());
        context.seed = values.seed;
        if let Some(seconds) = values.deadline {
            context = context.with_deadline(Instant::now() + Duration::from_secs_f64(seconds));
        }
        if std::io::stderr().is_terminal() && !common.quiet {
            context = context.with_progress(Arc::new(Bar::new()));
        }
        let record = Record::new(verb);
        Ok(Session {
            context,
            record,
            json: common.json.clone(),
            picture: common.picture.clone(),
            reports: common.report.iter().cloned().collect(),
            scenes: Vec::new(),
            quiet: common.quiet,
            timings,
            summary: Vec::new(),
        })
    }

    /// Adds a line for a person.
    pub fn say(&mut self, line: impl Into<String>) {
        self.summary.push(line.into());
    }

    /// Adds a warning.
    pub fn warn(&mut self, what: impl Into<String>) {
        let what = what.into();
        tracing::warn!("{what}");
        self.record.warnings.push(what);
    }

    /// Reads a mesh file as it is; what the reader repaired or left out becomes warnings.
    pub fn read(&mut self, file: &Path) -> Result<RawMesh, Error> {
        let mut mesh = {
            let _stage = self.context.stage("read");
            io::read(file)?
        };
        self.context.check()?;
        let input = Input {
            file: file.to_string_lossy().into_owned(),
            vertices: mesh.points.len(),
            faces: mesh.faces.len(),
            edges: mesh.edges.len(),
            cells: mesh.cells.len(),
        };
        self.record.set("input", input);
        std::mem::take(&mut mesh.notes).into_iter().for_each(|note| self.warn(note));
        self.show(file, Role::Before, |name, _| Scene::of_mesh(name, &mesh))?;
        Ok(mesh)
    }

    /// Reads a skeleton; what the reader mended stands in its notes.
    pub fn read_skeleton(&mut self, file: &Path) -> Result<CurveNet, Error> {
        let net = {
            let _stage = self.context.stage("read");
            io::read_skeleton(file)?
        };
        self.context.check()?;
        let input = Input {
            file: file.to_string_lossy().into_owned(),
            vertices: net.points.len(),
            faces: 0,
            edges: net.edges.len(),
            cells: 0,
        };
        self.record.set("input", input);
        self.show(file, Role::Before, |name, _| Ok(Scene::of_net(name, &net)))?;
        Ok(net)
    }

    /// Reads a surface; polygons are fanned from their first corner.
    pub fn read_triangles(&mut self, file: &Path) -> Result<SurfaceMesh, Error> {
        self.read(file)?.into_surface()?.triangulated()
    }

    /// Writes a mesh file.
    pub fn write_mesh(&mut self, file: &Path, mesh: &RawMesh, options: &io::WriteOptions) -> Result<(), Error> {
        self.context.check()?;
        let warnings = {
            let _stage = self.context.stage("write");
            io::write(file, mesh, options)?
        };
        warnings.into_iter().for_each(|w| self.warn(w));
        Ok(())
    }

    /// What most verbs end with: draws a mesh, writes it where that was asked for, and records what it has.
    pub fn deliver(&mut self, mesh: &RawMesh, file: Option<&Path>) -> Result<(), Error> {
        self.draw(mesh)?;
        self.show_result(file, |name, _| Scene::of_mesh(name, mesh))?;
        let mut counts = json!({ "vertices": mesh.points.len(), "faces": mesh.faces.len() });
        if let Some(file) = file {
            counts["file"] = json!(file.to_string_lossy());
            self.write_mesh(file, mesh, &io::WriteOptions::default())?;
        }
        self.record.set("output", counts);
        Ok(())
    }

    /// Writes a skeleton.
    pub fn write_skeleton(&mut self, file: &Path, net: &CurveNet) -> Result<(), Error> {
        self.context.check()?;
        let warnings = {
            let _stage = self.context.stage("write");
            io::write_skeleton(file, net)?
        };
        warnings.into_iter().for_each(|w| self.warn(w));
        Ok(())
    }

    /// Writes any other file, whole or not at all.
    pub fn write_bytes(&mut self, file: &Path, bytes: &[u8]) -> Result<(), Error> {
        let _stage = self.context.stage("write");
        self.context.check()?;
        io::write_atomically(file, bytes)
    }

    /// Draws a mesh where a picture was asked for.
    pub fn draw(&mut self, mesh: &RawMesh) -> Result<(), Error> {
        self.draw_as(|| figure(mesh))
    }

    /// Draws a figure of a verb's own where a picture was asked for.
    pub fn draw_as(&mut self, figure: impl FnOnce() -> Image + Send) -> Result<(), Error> {
        let Some(file) = self.picture.clone() else { return Ok(()) };
        let context = self.context.clone();
        let png = context.install(|| {
            let _stage = context.stage("picture");
            figure().to_png()
        })?;
        self.write_bytes(&file, &png)
    }

    /// Writes the page to this file, too.
    pub fn report_to(&mut self, file: &Path) {
        self.reports.push(file.to_path_buf());
    }

    /// Shows a scene on the page, where one was asked for; the scene takes the name that `make` is given. A file that is
    /// there already is replaced.
    pub fn show(
        &mut self,
        file: &Path,
        role: Role,
        make: impl FnOnce(String, &Context) -> Result<Scene, Error> + Send,
    ) -> Result<(), Error> {
        if self.reports.is_empty() {
            return Ok(());
        }
        let name = file.file_name().unwrap_or(file.as_os_str()).to_string_lossy().into_owned();
        let context = self.context.clone();
        let scene = context.install(|| {
            let _stage = context.stage("report");
            make(name, &context)
        })?;
        let scene = scene.role(role);
        match self.scenes.iter_mut().find(|(shown, _)| shown == file) {
            Some(place) => place.1 = scene,
            None => self.scenes.push((file.to_path_buf(), scene)),
        }
        Ok(())
    }

    /// Shows the result of the verb on the page, under the name of its file where it has one.
    pub fn show_result(
        &mut self,
        file: Option<&Path>,
        make: impl FnOnce(String, &Context) -> Result<Scene, Error> + Send,
    ) -> Result<(), Error> {
        let name = format!("result of {}", self.record.verb());
        // A file that replaces the input is shown beside it.
        let file = file.filter(|file| self.scenes.iter().all(|(shown, _)| shown != file));
        self.show(file.unwrap_or(Path::new(&name)), Role::After, make)
    }

    /// Puts the scenes of files in this order, none of them before or after another.
    pub fn show_equal(&mut self, files: &[&Path]) {
        let place = |file: &PathBuf| files.iter().position(|f| *f == file);
        self.scenes.sort_by_key(|(file, _)| place(file));
        self.scenes =
            std::mem::take(&mut self.scenes).into_iter().map(|(file, s)| (file, s.role(Role::Other))).collect();
    }

    /// The page of the run; its title names what the run was given.
    fn page(&mut self) -> Page {
        let scenes: Vec<Scene> = std::mem::take(&mut self.scenes).into_iter().map(|(_, scene)| scene).collect();
        let given = scenes.iter().filter(|scene| scene.as_role() != Role::After);
        let names: Vec<&str> = given.map(Scene::name).collect();
        let title = format!("carreau {} {}", self.record.verb(), names.join(", "));
        Page::new(title.trim_end()).command(command_line()).record(self.record.brief(&self.timings)).scenes(scenes)
    }

    fn write_reports(&mut self) -> Result<(), Error> {
        if self.reports.is_empty() {
            return Ok(());
        }
        let page = self.page();
        let context = self.context.clone();
        let html = context.install(|| {
            let _stage = context.stage("report");
            page.html()
        })?;
        for file in std::mem::take(&mut self.reports) {
            self.write_bytes(&file, html.as_bytes())?;
            self.say(format!("open {}", file.display()));
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<(), Error> {
        self.write_reports()?;
        let record = self.record.to_json(&self.timings);
        match &self.json {
            Some(to) if to.as_os_str() == "-" => print(&record),
            other => {
                if let Some(file) = other {
                    io::write_atomically(file, record.as_bytes())?;
                }
                let text: String = self.summary.iter().map(|line| format!("{line}\n")).collect();
                if self.quiet { Ok(()) } else { print(&text) }
            }
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

/// Results go to stdout; a reader that has gone away is no failure.
fn print(text: &str) -> Result<(), Error> {
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::write(Path::new("stdout"), e)),
        _ => Ok(()),
    }
}

/// The record's `input`.
#[derive(Serialize)]
struct Input {
    file: String,
    vertices: usize,
    faces: usize,
    edges: usize,
    cells: usize,
}
