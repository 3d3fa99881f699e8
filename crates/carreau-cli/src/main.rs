//! The `carreau` executable: see the library half of this crate.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(carreau_cli::run(std::env::args_os()))
}
