//! One run of a verb: its context, its input and output files, its record.

use crate::common::{Common, CommonValues};
use crate::host::{Found, Host, Input as HostInput};
use crate::progress::Bar;
use crate::record::Record;
use crate::report::Report;
use crate::timings::Timings;
use crate::verb::read_edges;
use carreau::context::MOST_THREADS;
use carreau::geometry::transfer::transfer;
use carreau::mesh::{Column, CurveNet, RawMesh, SurfaceMesh, VertexId};
use carreau::report::figure;
use carreau::report::page::{Role, Scene};
use carreau::report::picture::Image;
use carreau::words::agreed;
use carreau::{Context, Error, io};
use serde::Serialize;
use serde_json::json;
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

/// A run in progress.
pub struct Session {
    /// Threads, deadline, cancellation, progress.
    pub context: Context,
    /// What the run will tell.
    pub record: Record,
    json: Option<PathBuf>,
    picture: Option<PathBuf>,
    report: Report,
    quiet: bool,
    host: Option<Arc<Host>>,
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
            // A program that calls is handed the warnings with the record.
            (_, 0) if common.host.is_some() => LevelFilter::OFF,
            (true, _) => LevelFilter::ERROR,
            (_, 0) => LevelFilter::WARN,
            (_, 1) => LevelFilter::INFO,
            _ => LevelFilter::DEBUG,
        };
        let spans = if common.verbose > 0 { log::format::FmtSpan::CLOSE } else { log::format::FmtSpan::NONE };
        let stderr = log::layer()
            .with_writer(std::io::stderr)
            .with_ansi(std::io::stderr().is_terminal())
            .without_time()
            .with_target(false)
            .with_span_events(spans);
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
        values.validate()?;
        let host = common.host.clone();
        let cancel = host.as_ref().map_or_else(cancel_flag, |host| Arc::clone(&host.cancel));
        let mut context = Context::new().with_threads(values.threads)?.with_cancel(cancel);
        context.seed = values.seed;
        if let Some(seconds) = values.deadline {
            context = context.with_deadline(Instant::now() + Duration::from_secs_f64(seconds));
        }
        match &host {
            Some(host) => {
                if let Some(progress) = &host.progress {
                    context = context.with_progress(Arc::clone(progress));
                }
            }
            None if std::io::stderr().is_terminal() && !common.quiet => {
                context = context.with_progress(Arc::new(Bar::new()));
            }
            None => {}
        }
        let mut record = Record::new(verb);
        if values.threads > MOST_THREADS {
            let what =
                format!("{} threads were asked for, {MOST_THREADS} are used, which is the limit", values.threads);
            tracing::warn!("{what}");
            record.warnings.push(what);
        }
        Ok(Session {
            context,
            record,
            json: common.json.clone(),
            picture: common.picture.clone(),
            report: Report::to(common.report.clone()),
            quiet: common.quiet,
            host,
            timings,
            summary: Vec::new(),
        })
    }

    /// Adds a line for a person.
    pub fn say(&mut self, line: impl Into<String>) {
        self.summary.push(agreed(&line.into()));
    }

    /// Adds a warning.
    pub fn warn(&mut self, what: impl Into<String>) {
        let what = agreed(&what.into());
        tracing::warn!("{what}");
        self.record.warnings.push(what);
    }

    /// What a mesh file holds, or what the host holds in its place.
    pub fn load_mesh(&self, file: &Path) -> Result<RawMesh, Error> {
        match self.hosted(file) {
            Some(HostInput::Mesh(mesh)) => Ok(mesh.clone()),
            _ => io::read(file),
        }
    }

    /// What a skeleton file holds, or what the host holds in its place.
    pub fn load_skeleton(&self, file: &Path) -> Result<CurveNet, Error> {
        match self.hosted(file) {
            Some(HostInput::Skeleton(net)) => Ok(net.clone()),
            _ => io::read_skeleton(file),
        }
    }

    /// The edges that a file lists, or those the host holds in its place.
    pub fn load_edges(&self, file: &Path) -> Result<Vec<[VertexId; 2]>, Error> {
        match self.hosted(file) {
            Some(HostInput::Edges(edges)) => Ok(edges.clone()),
            _ => read_edges(file),
        }
    }

    /// Whether a file is a skeleton by its name, or the host holds one in its place.
    pub fn is_skeleton(&self, file: &Path) -> bool {
        match self.hosted(file) {
            Some(input) => matches!(input, HostInput::Skeleton(_)),
            None => io::is_skeleton_file(file),
        }
    }

    fn hosted(&self, file: &Path) -> Option<&HostInput> {
        self.host.as_ref().and_then(|host| host.input(file))
    }

    /// Hands the result to the host, if there is one.
    pub fn keep(&self, found: impl FnOnce() -> Found) {
        if let Some(host) = &self.host {
            host.keep(found());
        }
    }

    /// Reads a mesh file as it is; what the reader repaired or left out becomes warnings.
    pub fn read(&mut self, file: &Path) -> Result<RawMesh, Error> {
        let mut mesh = {
            let _stage = self.context.stage("read");
            self.load_mesh(file)?
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
            self.load_skeleton(file)?
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

    /// Carries what the source has over to the mesh that a method made of it; what cannot be carried is said.
    pub fn carry(&mut self, source: &SurfaceMesh, mesh: &mut RawMesh) -> Result<(), Error> {
        let context = self.context.clone();
        let said = context.install(|| {
            let _stage = context.stage("attributes");
            transfer(source, mesh, &context)
        })?;
        said.into_iter().for_each(|what| self.warn(what));
        if !matches!(self.record.verb(), "simplify" | "enrich") {
            // Columns that the methods make themselves.
            for name in
                ["region", "patch", "u", "v"].into_iter().filter(|name| source.attributes.face.contains_key(*name))
            {
                self.warn(format!(
                    "the method: the face property '{name}' of the input is replaced by that of the result"
                ));
            }
        }
        Ok(())
    }

    /// Says what of a surface the result of this method has no place for.
    pub fn leave_behind(&mut self, source: &SurfaceMesh, result: &str, kept: impl Fn(&Column) -> bool) {
        let a = &source.attributes;
        let columns = a.vertex.iter().chain(&a.corner).chain(a.face.iter().filter(|(_, column)| !kept(column)));
        let names: Vec<String> = columns.map(|(name, _)| format!("'{name}'")).collect();
        if !names.is_empty() {
            self.warn(format!(
                "the method: {result} has no place for what the surface carries: left out {}",
                names.join(", ")
            ));
        }
        if !source.tagged_edges.is_empty() {
            let count = source.tagged_edges.len();
            self.warn(format!(
                "the method: {result} has no place for the tagged edges of the surface: left out all {count}"
            ));
        }
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

    /// What most verbs end with: draws a mesh, writes it where that was asked for, and records what it has; with a scene of the
    /// verb's own. What is kept for a host is up to the verb.
    pub fn deliver_as(
        &mut self,
        mesh: &RawMesh,
        file: Option<&Path>,
        scene: impl FnOnce(String) -> Result<Scene, Error> + Send,
    ) -> Result<(), Error> {
        self.draw(mesh)?;
        self.show_result(file, |name, _| scene(name))?;
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
        self.report.files.push(file.to_path_buf());
    }

    /// Shows a scene on the page, where one was asked for; see [`Report::add`].
    pub fn show(
        &mut self,
        file: &Path,
        role: Role,
        make: impl FnOnce(String, &Context) -> Result<Scene, Error> + Send,
    ) -> Result<(), Error> {
        self.report.add(file, role, &self.context, make)
    }

    /// Shows the result of the verb on the page, under the name of its file where it has one.
    pub fn show_result(
        &mut self,
        file: Option<&Path>,
        make: impl FnOnce(String, &Context) -> Result<Scene, Error> + Send,
    ) -> Result<(), Error> {
        let name = format!("result of {}", self.record.verb());
        // A file that replaces the input is shown beside it.
        let file = file.filter(|file| !self.report.has(file));
        self.show(file.unwrap_or(Path::new(&name)), Role::After, make)
    }

    /// Shows files in this order, none of them before or after another.
    pub fn show_equal(&mut self, files: &[&Path]) {
        self.report.equal(files);
    }

    fn write_report(&mut self) -> Result<(), Error> {
        let files = std::mem::take(&mut self.report.files);
        if files.is_empty() {
            return Ok(());
        }
        let record = self.record.brief(&self.timings);
        let html = self.report.html(self.record.verb(), record, &self.context)?;
        for file in files {
            self.write_bytes(&file, html.as_bytes())?;
            self.say(format!("open {}", file.display()));
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<(), Error> {
        self.write_report()?;
        let record = self.record.to_json(&self.timings);
        if let Some(host) = &self.host {
            host.tell(&record, &self.summary);
        }
        match &self.json {
            Some(to) if to.as_os_str() == "-" => print(record.as_bytes()),
            other => {
                if let Some(file) = other {
                    io::write_atomically(file, record.as_bytes())?;
                }
                let text: String = self.summary.iter().map(|line| format!("{line}\n")).collect();
                if self.quiet || self.host.is_some() { Ok(()) } else { print(text.as_bytes()) }
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
pub fn print(text: &[u8]) -> Result<(), Error> {
    let mut stdout = std::io::stdout().lock();
    // What is left in the buffer at the end of the process would be lost without a word.
    match stdout.write_all(text).and_then(|()| stdout.flush()) {
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
