//! `man`: the manual pages.

use super::contract::Run;
use crate::console::print;
use crate::failure::Failure;
use crate::host::Host;
use carreau::{Error, io};
use clap::Args;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Writes the manual pages: one of carreau, one of each verb
#[derive(Args)]
#[command(after_help = "Examples:\n  carreau man | man -l -\n  carreau man -o ~/.local/share/man/man1")]
pub struct Man {
    /// A folder for all pages; without it the main page goes to stdout
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

impl Run for Man {
    fn run(&self, whole: fn() -> clap::Command) -> Result<(), Failure> {
        let page = |command: clap::Command| {
            let mut text = Vec::new();
            let rendered = clap_mangen::Man::new(command).render(&mut text);
            rendered.map(|()| text).map_err(|e| Error::write(Path::new("manual page"), e))
        };
        let command = whole();
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

    fn run_in(&mut self, _: &Arc<Host>) -> bool {
        false
    }
}
