//! Help for the shell: completions and the manual page.

use crate::session::{Failure, print};
use carreau::{Error, io};
use clap::Args;
use clap_complete::Shell;
use std::path::{Path, PathBuf};

/// Writes a completion script for a shell to stdout
#[derive(Args)]
#[command(after_help = "Example:\n  carreau completions bash > ~/.local/share/bash-completion/completions/carreau")]
pub struct Completions {
    /// The shell
    shell: Shell,
}

impl Completions {
    /// Runs the verb.
    pub fn run(&self) -> Result<(), Failure> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut crate::command(), "carreau", &mut script);
        Ok(print(&script)?)
    }
}

/// Writes the manual pages: one of carreau, one of each verb
#[derive(Args)]
#[command(after_help = "Examples:\n  carreau man | man -l -\n  carreau man -o ~/.local/share/man/man1")]
pub struct Man {
    /// A folder for all pages; without it the main page goes to stdout
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

impl Man {
    /// Runs the verb.
    pub fn run(&self) -> Result<(), Failure> {
        let page = |command: clap::Command| {
            let mut text = Vec::new();
            let rendered = clap_mangen::Man::new(command).render(&mut text);
            rendered.map(|()| text).map_err(|e| Error::write(Path::new("manual page"), e))
        };
        let command = crate::command();
        let Some(folder) = &self.output else { return Ok(print(&page(command)?)?) };
        std::fs::create_dir_all(folder).map_err(|e| Error::write(folder, e))?;
        io::write_atomically(&folder.join("carreau.1"), &page(command.clone())?)?;
        for verb in command.get_subcommands().filter(|v| !v.is_hide_set()) {
            let name = format!("carreau-{}", verb.get_name());
            let text = page(verb.clone().name(name.clone()))?;
            io::write_atomically(&folder.join(format!("{name}.1")), &text)?;
        }
        Ok(())
    }
}
