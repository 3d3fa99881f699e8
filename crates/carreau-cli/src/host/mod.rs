//! A program that runs verbs in its own process, as the Python package does: meshes in memory take the place of files,
//! and the result is handed back instead of being written.
//!
//! Options, defaults, checks and the record are those of the command line, for they go through the same parser and the
//! same code.

mod memory;

use crate::cli::Cli;
use crate::failure::Failure;
use crate::report::remember_command;
use carreau::{Error, Result};
use clap::{ArgAction, CommandFactory, FromArgMatches};
use std::ffi::OsString;
use std::sync::Arc;

pub use memory::{Found, Host, Input, Outcome};

/// The value of an option: a number or a word is text, as on the command line.
pub enum Value {
    /// For flags, and options that are true or false.
    Bool(bool),
    /// For all others.
    Text(String),
}

/// The long names of a verb's options, without the dashes, in the order of its help; empty for an unknown verb.
pub fn option_names(verb: &str) -> Vec<String> {
    let command = Cli::command();
    let arguments = command.find_subcommand(verb).into_iter().flat_map(clap::Command::get_arguments);
    arguments.filter_map(|a| a.get_long().map(String::from)).collect()
}

/// Runs a verb on these inputs, which are files or names in the host's table.
///
/// # Errors
/// [`Error::Options`] for names and values that the command line would refuse, else the errors of the verb. Messages
/// name options as the command line does.
pub fn call(verb: &str, inputs: &[String], options: &[(String, Value)], host: Host) -> Result<Outcome> {
    let host = Arc::new(host);
    let arguments = arguments(verb, inputs, options)?;
    remember_command(&arguments.iter().map(OsString::from).collect::<Vec<_>>());
    // What the command line writes, a program is handed back.
    let command = Cli::command().mut_subcommand(verb, |c| {
        if c.get_arguments().any(|a| a.get_id() == "output") { c.mut_arg("output", |a| a.required(false)) } else { c }
    });
    let parsed = command.try_get_matches_from(arguments).and_then(|m| Cli::from_arg_matches(&m));
    let mut cli = parsed.map_err(|e| Error::Options(plain_message(&e.to_string())))?;
    if !cli.verb.run_in(&host) {
        return Err(Error::Options(format!("`{verb}` cannot be called")));
    }
    cli.run().map_err(Failure::into_error)?;
    Ok(host.take_outcome())
}

/// The words of the command line that runs a verb with these options, its own name first.
///
/// # Errors
/// [`Error::Options`] for verbs and options that do not exist, and for flags that are neither true nor false.
pub fn arguments(verb: &str, inputs: &[String], options: &[(String, Value)]) -> Result<Vec<String>> {
    let command = Cli::command();
    let verb_command =
        command.find_subcommand(verb).ok_or_else(|| Error::Options(format!("there is no verb '{verb}'")))?;
    let mut all = vec!["carreau".to_string(), verb.to_string()];
    for (name, value) in options {
        let known = verb_command.get_arguments().find(|a| a.get_long() == Some(name));
        let action = known.ok_or_else(|| Error::Options(format!("there is no option '{name}'")))?.get_action();
        match (action, value) {
            (ArgAction::SetTrue | ArgAction::Count, Value::Bool(false)) => {}
            (ArgAction::SetTrue | ArgAction::Count, Value::Bool(true)) => all.push(format!("--{name}")),
            (ArgAction::SetTrue, Value::Text(text)) => {
                return Err(Error::Options(format!("--{name} is true or false, not '{text}'")));
            }
            (ArgAction::Count, Value::Text(text)) => {
                let count: u8 =
                    text.parse().map_err(|_| Error::Options(format!("--{name} '{text}' is not a count")))?;
                all.extend((0..count).map(|_| format!("--{name}")));
            }
            (_, Value::Bool(value)) => all.push(format!("--{name}={value}")),
            (_, Value::Text(text)) => all.push(format!("--{name}={text}")),
        }
    }
    all.push("--".into());
    all.extend_from_slice(inputs);
    Ok(all)
}

/// The parser's message without its frame: neither "error:" nor the hint at `--help`.
fn plain_message(text: &str) -> String {
    let text = text.split("\n\nUsage:").next().unwrap_or(text);
    let text = text.split("\n\nFor more information").next().unwrap_or(text);
    let words: Vec<&str> = text.trim_start_matches("error: ").split_whitespace().collect();
    words.join(" ")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test fails by panicking
    use super::*;
    use carreau::Context;
    use std::collections::BTreeMap;

    fn host() -> Host {
        let mesh = carreau::sample::make("bracket", Some(20), &Context::new()).unwrap();
        let inputs = BTreeMap::from([("part".into(), Input::Mesh(mesh.into()))]);
        let mut host = Host::default();
        host.inputs = inputs;
        host
    }

    fn text(name: &str, value: &str) -> (String, Value) {
        (name.into(), Value::Text(value.into()))
    }

    #[test]
    fn a_verb_runs_on_a_mesh_in_memory() {
        let options = [text("min-cells", "1"), ("convex-only".into(), Value::Bool(true))];
        let outcome = call("patch", &["part".into()], &options, host()).unwrap();
        let Some(Found::Patches(mesh, layout)) = outcome.found else { panic!("patches are expected") };
        let record: serde_json::Value = serde_json::from_str(&outcome.record).unwrap();
        assert_eq!(record["patches"], layout.patches.len());
        assert_eq!(record["options"]["min_cells"], 1);
        assert_eq!(record["options"]["convex_only"], true);
        assert_eq!(mesh.faces.len(), layout.figures.cells + layout.leftover.len());
        assert!(!outcome.summary.is_empty());
    }

    #[test]
    fn wrong_options_are_told_without_the_parsers_frame() {
        let message = |options: &[(String, Value)]| {
            call("segment", &["part".into()], options, host()).err().map(|e| e.to_string()).unwrap_or_default()
        };
        let refused = message(&[text("rectify", "wild")]);
        assert!(refused.contains("'wild'") && refused.contains("paper") && !refused.contains("help"), "{refused}");
        assert!(message(&[text("regions", "3"), text("merge-threshold", "2")]).contains("--merge-threshold"));
        assert!(message(&[text("nonsense", "3")]).contains("'nonsense'"));
        assert!(message(&[("regions".into(), Value::Bool(true))]).contains("true"));
    }

    #[test]
    fn cancelled_runs_stop() {
        let host = host();
        host.cancel.store(true, std::sync::atomic::Ordering::Relaxed);
        assert!(matches!(call("quad", &["part".into()], &[], host), Err(Error::Cancelled)));
    }
}
