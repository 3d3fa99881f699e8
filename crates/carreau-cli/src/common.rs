//! Options that every verb has.

use crate::choice::choice;
use crate::host::Host;
use carreau::bounds::{positive, within};
use carreau::io::cad::Unit;
use carreau::{Length, Result};
use clap::Args;
use serde::{Deserialize, Serialize};
use std::ops::Bound;
use std::path::PathBuf;
use std::sync::Arc;

/// Options that every verb has.
#[derive(Args, Clone, Default)]
pub struct Common {
    /// Writes the result record (JSON) to a file, or to stdout with `-`
    #[arg(long, value_name = "FILE|-", help_heading = "Common options")]
    pub json: Option<PathBuf>,
    /// Draws the result (PNG)
    #[arg(long, value_name = "FILE.png", help_heading = "Common options")]
    pub picture: Option<PathBuf>,
    /// Writes an HTML page that shows input and result with their layers, quality, options, timings and warnings
    #[arg(long, value_name = "FILE.html", help_heading = "Common options")]
    pub report: Option<PathBuf>,
    /// Takes options from a JSON file, or replays the run of a record. Flags override the file
    #[arg(long, value_name = "FILE", help_heading = "Common options")]
    pub options: Option<PathBuf>,
    /// Number of threads (0: one per processor); results do not depend on it
    #[arg(long, value_name = "N", help_heading = "Common options")]
    pub threads: Option<usize>,
    /// Seed of pseudo-random choices
    #[arg(long, value_name = "N", help_heading = "Common options")]
    pub seed: Option<u64>,
    /// Gives up after this many seconds (exit code 124) and writes nothing
    #[arg(long, value_name = "SECONDS", value_parser = seconds, help_heading = "Common options")]
    pub deadline: Option<f64>,
    /// Unit of the input's lengths, written into CAD files
    #[arg(long, value_name = "UNIT", value_parser = choice::<Unit>(&["mm", "cm", "m", "in"]), help_heading = "Common options")]
    pub unit: Option<Unit>,
    /// Prints only errors
    #[arg(short, long, conflicts_with = "verbose", help_heading = "Common options")]
    pub quiet: bool,
    /// Prints the stages of the run (-vv: in detail)
    #[arg(short, long, action = clap::ArgAction::Count, help_heading = "Common options")]
    pub verbose: u8,
    /// The program that runs the verb, if it is not a terminal
    #[arg(skip)]
    pub host: Option<Arc<Host>>,
}

/// The common options that belong to a record: what replays a run.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct CommonValues {
    pub threads: usize,
    pub seed: u64,
    pub deadline: Option<f64>,
    pub unit: Unit,
}

impl Common {
    /// These flags laid over values from an options file.
    pub fn over(&self, values: CommonValues) -> CommonValues {
        CommonValues {
            threads: self.threads.unwrap_or(values.threads),
            seed: self.seed.unwrap_or(values.seed),
            deadline: self.deadline.or(values.deadline),
            unit: self.unit.unwrap_or(values.unit),
        }
    }
}

/// Longest deadline, in seconds: some thirty years. Beyond it, and below zero, there are no instants to wait for.
const LONGEST: f64 = 1e9;

impl CommonValues {
    /// Refuses values out of range, whether a flag or an options file gave them.
    ///
    /// # Errors
    /// [`carreau::Error::Options`].
    pub fn validate(&self) -> Result<()> {
        let range = (Bound::Excluded(0.0), Bound::Included(LONGEST));
        self.deadline.map_or(Ok(()), |seconds| within("deadline", seconds, range, "seconds"))
    }
}

/// Refuses a length of zero; others that are no lengths are not read as such.
pub fn positive_length(name: &str, length: Option<Length>) -> Result<()> {
    length.map_or(Ok(()), |length| positive(name, length.resolve(1.0)))
}

fn seconds(text: &str) -> std::result::Result<f64, String> {
    match text.parse::<f64>() {
        Ok(s) if s > 0.0 && s <= LONGEST => Ok(s),
        _ => Err("a positive number of seconds is expected".into()),
    }
}
