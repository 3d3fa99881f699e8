//! The carreau command line, also callable as a library (the Python package's console script calls [`run`]).
//!
//! One file per verb in `verb/`; each translates its arguments into the options of a room, calls it, and writes the
//! results. What all verbs share:
//!
//! | file | does |
//! |---|---|
//! | `common` | options that every verb has |
//! | `session` | one run: context, input, output, record |
//! | `prepare` | how surfaces are prepared, and what is told about it |
//! | `outputs` | what a run will write, checked before it begins |
//! | `record` | the result record of the contract |
//! | `replay` | options files |
//! | `report` | the page of a run |
//! | `progress` | progress bar on a terminal |
//! | `timings` | seconds per stage, from tracing spans |
//! | `host` | verbs inside another program, on meshes in memory |

mod choice;
mod common;
pub mod host;
mod outputs;
mod prepare;
mod progress;
mod record;
mod replay;
mod report;
mod session;
mod timings;
mod verb;

use carreau::Error;
use clap::{CommandFactory, FromArgMatches, Parser};
use session::Failure;
use std::ffi::OsString;
use std::io::ErrorKind;
use std::path::Path;

/// The command line.
#[derive(Parser)]
#[command(
    name = "carreau",
    version,
    about = "From triangle surfaces to structured models",
    long_about = "carreau turns triangle surfaces into structured models: regions, graded meshes, quad patches \
        and CAD faces, frame fields and quads, skeletons and hexes. Angles are in degrees; lengths are numbers in the unit of the file \
        (2.5) or shares of the bounding-box diagonal (1%).",
    after_help = "Exit codes: 0 done, 2 wrong usage, 3 input not acceptable, 4 method did not reach what was asked, \
        5 file not read or written, 70 a bug, 124 deadline, 130 cancelled.",
    subcommand_required = true,
    arg_required_else_help = true
)]
struct Cli {
    #[command(subcommand)]
    verb: verb::Verb,
}

/// The whole command, for completions and the manual page.
pub fn command() -> clap::Command {
    Cli::command()
}

/// Runs one command line; returns the exit code.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    report::remember_command(&arguments);
    let cli = match Cli::command().try_get_matches_from(arguments).and_then(|m| Cli::from_arg_matches(&m)) {
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
    match std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| cli.verb.run())) {
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
