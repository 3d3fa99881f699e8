//! One run of a verb, from its start to its record.

use super::context::context;
use super::log::listener;
use crate::common::{Common, CommonValues};
use crate::console::print;
use crate::failure::Failure;
use crate::host::{Found, Host};
use crate::record::Record;
use crate::report::Report;
use crate::timings::Timings;
use carreau::context::MOST_THREADS;
use carreau::io::cad::Unit;
use carreau::words::agreed;
use carreau::{Context, Error, io};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A run in progress.
pub struct Session {
    /// Threads, deadline, cancellation, progress.
    pub context: Context,
    /// What the run will tell.
    pub record: Record,
    /// Unit of the input's lengths.
    pub unit: Unit,
    json: Option<PathBuf>,
    pub(super) picture: Option<PathBuf>,
    pub(super) report: Report,
    quiet: bool,
    pub(super) host: Option<Arc<Host>>,
    timings: Timings,
    /// Lines for a person, printed when the record does not go to stdout.
    summary: Vec<String>,
}

impl Session {
    /// Runs the work of a verb; its record is written when it succeeds. `file` is the input, for messages.
    pub fn run(
        verb: &'static str,
        common: &Common,
        values: &CommonValues,
        file: Option<&Path>,
        work: impl FnOnce(&mut Session) -> Result<(), Error>,
    ) -> Result<(), Failure> {
        let timings = Timings::new();
        tracing::subscriber::with_default(listener(common, &timings), || {
            let finished = Self::start(verb, common, values, timings).and_then(|mut session| {
                work(&mut session)?;
                session.finish()
            });
            finished.map_err(|error| Failure::about(file, error))
        })
    }

    fn start(verb: &'static str, common: &Common, values: &CommonValues, timings: Timings) -> Result<Self, Error> {
        let context = context(common, values)?;
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
            unit: values.unit,
            json: common.json.clone(),
            picture: common.picture.clone(),
            report: Report::to(common.report.clone()),
            quiet: common.quiet,
            host: common.host.clone(),
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

    /// Hands the result to the host, if there is one.
    pub fn keep(&self, found: impl FnOnce() -> Found) {
        if let Some(host) = &self.host {
            host.keep(found());
        }
    }

    /// Writes any other file, whole or not at all.
    pub fn write_bytes(&mut self, file: &Path, bytes: &[u8]) -> Result<(), Error> {
        let _stage = self.context.stage("write");
        self.context.check()?;
        io::write_atomically(file, bytes)
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
