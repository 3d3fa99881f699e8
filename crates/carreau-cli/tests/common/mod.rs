//! What the tests of the command share.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::print_stderr)] // a test fails by panicking
#![allow(dead_code)] // each test file uses its own part

use assert_cmd::Command;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The executable under test.
pub fn carreau() -> Command {
    Command::cargo_bin("carreau").expect("the binary of this package")
}

/// Runs a command line that must succeed; returns the record.
pub fn record(arguments: &[&str]) -> Value {
    let out = carreau().args(arguments).args(["--json", "-"]).assert().success().get_output().stdout.clone();
    serde_json::from_slice(&out).expect("stdout is one JSON object")
}

/// A path as a command-line argument.
pub fn text(path: &Path) -> &str {
    path.to_str().expect("test paths are UTF-8")
}

/// The corpus of real models, or `None`, said aloud, where it is absent. With `CI=true` absence is a failure.
pub fn shared() -> Option<PathBuf> {
    let default = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared");
    let folder = std::env::var_os("CARREAU_SHARED").map_or(default, PathBuf::from).join("data");
    if folder.is_dir() {
        return Some(folder);
    }
    assert!(std::env::var("CI").as_deref() != Ok("true"), "the corpus is missing: {}", folder.display());
    eprintln!("SKIPPED: no corpus at {} (set CARREAU_SHARED)", folder.display());
    None
}
