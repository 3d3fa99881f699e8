//! `completions`: what a shell completes.

use super::contract::Run;
use crate::console::print;
use crate::failure::Failure;
use crate::host::Host;
use clap::Args;
use clap_complete::Shell;
use std::sync::Arc;

/// Writes a completion script for a shell to stdout
#[derive(Args)]
#[command(after_help = "Example:\n  carreau completions bash > ~/.local/share/bash-completion/completions/carreau")]
pub struct Completions {
    /// The shell
    shell: Shell,
}

impl Run for Completions {
    fn run(&self, whole: fn() -> clap::Command) -> Result<(), Failure> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut whole(), "carreau", &mut script);
        Ok(print(&script)?)
    }

    fn run_in(&mut self, _: &Arc<Host>) -> bool {
        false
    }
}
