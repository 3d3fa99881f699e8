//! Every command that the documentation shows does what it shows: those in the code blocks and in the text of README,
//! CONTRIBUTING and `docs/`, and the examples of `--help`. Each page has a folder with the files that it speaks of. Links lead
//! somewhere, and pictures are small.

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stderr)] // a test fails by panicking

mod common;

use common::carreau;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use tempfile::TempDir;

/// Files that the pages begin with: name, model, resolution.
const MODELS: &[(&str, &str, &str)] = &[
    ("scan.ply", "noisy-torus", "24"),
    ("scan.stl", "noisy-torus", "16"),
    ("scan.obj", "noisy-torus", "16"),
    ("soup.obj", "noisy-torus", "16"),
    ("two.stl", "wedge", "10"),
    ("simplified.ply", "torus", "12"),
    ("coarse.ply", "torus", "12"),
    ("part.stl", "wedge", "10"),
    ("part.obj", "wedge", "10"),
    ("part.ply", "wedge", "10"),
    ("other.stl", "wedge", "12"),
    ("a.stl", "wedge", "8"),
    ("b.stl", "wedge", "12"),
    ("fandisk.obj", "wedge", "12"),
    ("vessel.stl", "cylinder", "12"),
    ("vessel.ply", "cylinder", "12"),
    ("cactus.obj", "cylinder", "12"),
    ("hand.obj", "cylinder", "12"),
];
const GRAPH: &str = "# D:3 NV:3 NE:2\nv 0 0 0 0.2\nv 1 0 0 0.3\nv 2 0 0.5 0.25\ne 0 1\ne 1 2\n";
const NEURON: &str = "1 1 0 0 0 0.5 -1\n2 3 0 0 2 0.4 1\n3 3 1 0 4 0.3 2\n4 3 -1 0 4 0.3 2\n";

/// Commands that are not run here, and why.
const NOT_RUN: &[(&str, &str)] = &[
    ("carreau demo", "takes minutes in the build of the tests"),
    ("cargo run --release -- demo", "takes minutes in the build of the tests"),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A folder with the files that the pages speak of, and the command under its name.
fn desk() -> TempDir {
    static FILES: OnceLock<TempDir> = OnceLock::new();
    let folder = TempDir::new().unwrap();
    for entry in fs::read_dir(FILES.get_or_init(files).path()).unwrap().map(Result::unwrap) {
        fs::copy(entry.path(), folder.path().join(entry.file_name())).unwrap();
    }
    fs::create_dir_all(folder.path().join(".local/share/bash-completion/completions")).unwrap();
    fs::create_dir(folder.path().join(".bin")).unwrap();
    let command = folder.path().join(".bin/carreau");
    std::os::unix::fs::symlink(assert_cmd::cargo::cargo_bin("carreau"), command).unwrap();
    folder
}

fn files() -> TempDir {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    for (name, model, resolution) in MODELS {
        carreau().args(["sample", model, "--resolution", resolution, "-q", "-o"]).arg(at(name)).assert().success();
    }
    // A label that a CAD program would give.
    let part = fs::read(at("part.ply")).unwrap();
    let header = part.windows(7).position(|w| w == b" truth\n").unwrap();
    fs::write(at("part.ply"), [&part[..header], b" face_id\n", &part[header + 7..]].concat()).unwrap();
    for name in ["vessel.cgr", "tree.cgr"] {
        fs::write(at(name), GRAPH).unwrap();
    }
    fs::write(at("neuron.swc"), NEURON).unwrap();
    for name in ["vessel.vtu", "mesh.msh"] {
        carreau()
            .arg("hex")
            .arg(at("tree.cgr"))
            .args(["--refine-across", "0", "-q", "-o"])
            .arg(at(name))
            .assert()
            .success();
    }
    folder
}

/// A command, and where it stands.
#[derive(Debug)]
struct Shown {
    line: String,
    place: String,
}

/// A command without its remark; `None` for any other text.
fn command_in(text: &str) -> Option<String> {
    let text = text.trim().trim_start_matches("$ ");
    let text = text.split(" #").next().unwrap_or(text).trim();
    let is_command = text.starts_with("carreau ") || text.starts_with("cargo run --release -- ");
    // `carreau VERB --help`, `carreau segment …`: patterns of commands, not commands.
    let is_pattern = text
        .split_whitespace()
        .any(|w| w.contains(['…', '<', '[']) || (w.len() > 1 && w.chars().all(|c| c.is_ascii_uppercase())));
    (is_command && !is_pattern).then(|| text.to_string())
}

/// The commands in a page: lines of code blocks that are no program, and spans of code that name a file or an option.
fn commands(page: &Path) -> Vec<Shown> {
    let text = fs::read_to_string(page).unwrap();
    let name = page.file_name().unwrap().to_string_lossy().into_owned();
    let (mut found, mut fence) = (Vec::new(), None::<String>);
    for (number, line) in text.lines().enumerate() {
        let place = format!("{name}:{}", number + 1);
        if let Some(language) = line.trim_start().strip_prefix("```") {
            fence = if fence.is_some() { None } else { Some(language.to_string()) };
            continue;
        }
        match &fence {
            Some(language) if !matches!(language.as_str(), "" | "sh" | "bash" | "console") => {}
            Some(_) => found.extend(command_in(line).map(|line| Shown { line, place })),
            None if line.starts_with("    ") => found.extend(command_in(line).map(|line| Shown { line, place })),
            None => {
                let spans = line.split('`').skip(1).step_by(2).filter_map(command_in);
                // `carreau convert` alone is the name of a verb.
                let whole = spans.filter(|s| s.split_whitespace().count() > 2);
                found.extend(whole.map(|line| Shown { line, place: place.clone() }));
            }
        }
    }
    found
}

/// The examples of a verb's help.
fn examples(verb: &str) -> Vec<Shown> {
    let out = carreau().args([verb, "--help"]).output().unwrap();
    let help = String::from_utf8(out.stdout).unwrap();
    let section = help.lines().skip_while(|l| !l.starts_with("Example"));
    section.filter_map(command_in).map(|line| Shown { line, place: format!("carreau {verb} --help") }).collect()
}

/// A line whose pipe leads to a program that is not at hand ends before it.
fn runnable(line: &str) -> String {
    match line.split_once(" | ") {
        Some((first, next)) => {
            let program = next.split_whitespace().next().unwrap_or_default();
            let known = Command::new("sh").args(["-c", &format!("command -v {program}")]).output();
            if known.is_ok_and(|o| o.status.success()) { line.to_string() } else { first.to_string() }
        }
        None => line.to_string(),
    }
}

/// Runs the commands in their order, in one folder.
fn run_all(shown: &[Shown]) {
    let folder = desk();
    let path = format!("{}:{}", folder.path().join(".bin").display(), std::env::var("PATH").unwrap_or_default());
    for Shown { line, place } in shown {
        if let Some((_, why)) = NOT_RUN.iter().find(|(start, _)| line.starts_with(start)) {
            eprintln!("not run: {line} ({place}): {why}");
            continue;
        }
        let line = runnable(&line.replace("cargo run --release --", "carreau"));
        let mut shell = Command::new("sh");
        shell.args(["-c", &line]).current_dir(folder.path()).env("PATH", &path).env("HOME", folder.path());
        let out = shell.output().unwrap();
        assert!(out.status.success(), "{place}: {line}\n{}", String::from_utf8_lossy(&out.stderr));
        let words: Vec<&str> = line.split_whitespace().collect();
        for pair in words.windows(2).filter(|p| matches!(p[0], "-o" | "--layout" | "--picture" | "--report")) {
            let file = folder.path().join(pair[1].replace("~/", ""));
            assert!(fs::metadata(&file).is_ok_and(|m| m.len() > 0), "{place}: {line} wrote no {}", pair[1]);
        }
    }
}

#[test]
fn commands_of_the_pages() {
    let mut count = 0;
    for page in pages() {
        let shown = commands(&page);
        count += shown.len();
        if !shown.is_empty() {
            run_all(&shown);
        }
    }
    assert!(count >= 25, "only {count} commands were found in the pages");
}

#[test]
fn examples_of_the_help() {
    let help = String::from_utf8(carreau().arg("--help").output().unwrap().stdout).unwrap();
    let list = help.lines().skip_while(|l| !l.starts_with("Commands:")).skip(1).take_while(|l| l.starts_with("  "));
    let verbs: Vec<&str> = list.filter_map(|l| l.split_whitespace().next()).filter(|v| *v != "help").collect();
    assert!(verbs.len() >= 18, "{verbs:?}");
    for verb in verbs {
        let shown = examples(verb);
        assert!(!shown.is_empty(), "{verb} --help shows no example");
        // Each stands for itself.
        shown.chunks(1).for_each(run_all);
    }
}

/// All pages: those of `docs/`, README and CONTRIBUTING.
fn pages() -> Vec<PathBuf> {
    let docs = fs::read_dir(root().join("docs")).unwrap().map(|e| e.unwrap().path());
    let mut pages: Vec<PathBuf> = docs.filter(|p| p.extension().is_some_and(|e| e == "md")).collect();
    pages.extend(["README.md", "CONTRIBUTING.md"].map(|name| root().join(name)));
    pages.sort();
    pages
}

/// The anchor that a heading gets on a page.
fn anchor(heading: &str) -> String {
    let shown = heading.trim().to_lowercase();
    let kept = shown.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

/// Where the links of a text lead, those to other hosts left out.
fn links(text: &str) -> Vec<&str> {
    let targets = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    targets.filter(|target| !target.starts_with("http") && !target.contains(' ')).collect()
}

/// Links between the pages lead to files and headings that exist.
#[test]
fn links_of_the_pages() {
    let mut count = 0;
    for page in pages() {
        let text = fs::read_to_string(&page).unwrap();
        for link in links(&text) {
            let (path, heading) = link.split_once('#').unwrap_or((link, ""));
            let target = if path.is_empty() { page.clone() } else { page.parent().unwrap().join(path) };
            assert!(target.exists(), "{}: {link} leads nowhere", page.display());
            if !heading.is_empty() && target.extension().is_some_and(|e| e == "md") {
                let text = fs::read_to_string(&target).unwrap();
                let mut headings = text.lines().filter(|l| l.starts_with('#')).map(|l| l.trim_start_matches('#'));
                assert!(headings.any(|h| anchor(h) == heading), "{}: {link} leads to no heading", page.display());
            }
            count += 1;
        }
    }
    assert!(count > 100, "only {count} links were found in the pages");
}

/// Pictures are small: a clone carries them all, through its whole history.
#[test]
fn pictures_of_the_pages() {
    for folder in ["docs", "docs/gallery"] {
        for file in fs::read_dir(root().join(folder)).unwrap().map(|e| e.unwrap().path()) {
            if file.extension().is_some_and(|e| e == "png") {
                let bytes = fs::metadata(&file).unwrap().len();
                assert!(bytes < 150_000, "{} has {bytes} bytes: fewer colours or pixels will do", file.display());
            }
        }
    }
}

#[test]
fn what_is_a_command() {
    assert_eq!(command_in("    carreau info a.ply  # says").as_deref(), Some("carreau info a.ply"));
    assert_eq!(command_in("carreau VERB --help"), None);
    assert_eq!(command_in("carreau segment …"), None);
    assert_eq!(command_in("the carreau info"), None);
}
