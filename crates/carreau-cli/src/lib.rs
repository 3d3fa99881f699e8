//! The carreau command line, also callable as a library (the Python package's console script calls [`run`]).
//!
//! One file per verb in `verb/`; each translates its arguments into the options of a room, calls it, and writes the
//! results. What all verbs share:
//!
//! | file | does |
//! |---|---|
//! | `verb` | what a verb is, and all of them |
//! | `cli` | the command line as a whole, for the parser |
//! | `host` | verbs inside another program, on meshes in memory |
//! | `session` | one run: context, input, output, record |
//! | `common` | options that every verb has |
//! | `features`, `remesh` | options and words that several verbs have |
//! | `prepare` | how surfaces are prepared, and what is told about it |
//! | `edges`, `labels` | files that list edges, and labels of faces |
//! | `defects` | what is wrong with a surface, in words |
//! | `outputs` | what a run will write, checked before it begins |
//! | `record` | the result record of the contract |
//! | `replay` | options files |
//! | `report` | the page of a run |
//! | `progress` | progress bar on a terminal |
//! | `timings` | seconds per stage, from tracing spans |
//! | `choice` | words for the values of an option |
//! | `failure`, `console` | how a run fails, and where its results are printed |

mod choice;
mod cli;
mod common;
mod console;
mod defects;
mod edges;
mod failure;
mod features;
pub mod host;
mod labels;
mod outputs;
mod prepare;
mod progress;
mod record;
mod remesh;
mod replay;
mod report;
mod session;
mod timings;
mod verb;

use carreau::Error;
use clap::FromArgMatches;
use cli::Cli;
use failure::Failure;
use std::ffi::OsString;
use std::io::ErrorKind;
use std::path::Path;

pub use cli::command;

/// Runs one command line; returns the exit code.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    report::remember_command(&arguments);
    let cli = match command().try_get_matches_from(arguments).and_then(|m| Cli::from_arg_matches(&m)) {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version are no failures; clap knows which stream each belongs to.
            if let Err(e) = error.print()
                && e.kind() != ErrorKind::BrokenPipe
                && !error.use_stderr()
            {
                return report(&Error::write(Path::new("stdout"), e).into());
            }
            return u8::try_from(error.exit_code()).unwrap_or(2);
        }
    };
    // A panic is a bug in every case; it must not look like one of the other failures.
    match std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| cli.run())) {
        Ok(Ok(())) => 0,
        Ok(Err(failure)) => report(&failure),
        Err(_) => 70,
    }
}

#[allow(clippy::print_stderr)] // the one place where failures are told
fn report(failure: &Failure) -> u8 {
    eprintln!("carreau: {failure}");
    failure.exit_code()
}
