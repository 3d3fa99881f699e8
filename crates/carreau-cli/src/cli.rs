//! The command line as a whole, for the parser.

use crate::failure::Failure;
use crate::verb::AnyVerb;
use clap::{CommandFactory, Parser};

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
pub struct Cli {
    #[command(subcommand)]
    pub verb: AnyVerb,
}

impl Cli {
    /// Does what the command line says.
    pub fn run(&self) -> Result<(), Failure> {
        self.verb.run(command)
    }
}

/// The whole command, for completions and the manual page.
pub fn command() -> clap::Command {
    Cli::command()
}
