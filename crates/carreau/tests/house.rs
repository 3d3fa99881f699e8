//! The direction of knowledge: which part of the library may name which.

#![allow(clippy::unwrap_used)] // a test fails by panicking

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Every part and what it may know, besides itself and the ground floor (`error`, `context`, `length`, `bounds`, `words`).
const MAY_KNOW: &[(&str, &[&str])] = &[
    ("context", &[]),
    ("mesh", &[]),
    ("geometry", &["mesh", "numeric"]),
    ("numeric", &["mesh"]),
    ("brep", &["mesh", "geometry", "numeric"]),
    // Cells of a surface stand about its skeleton.
    ("hex", &["mesh", "geometry", "numeric", "skeleton"]),
    ("skeleton", &["mesh", "geometry", "numeric"]),
    ("patch", &["mesh", "geometry", "brep", "numeric"]),
    ("remesh", &["mesh", "geometry", "numeric"]),
    ("segment", &["mesh", "geometry", "numeric"]),
    // Regions become faces, and blocks of quads.
    ("cad", &["mesh", "geometry", "numeric", "brep", "segment", "quad"]),
    ("field", &["mesh", "geometry", "numeric"]),
    // Its rungs are made of other rooms: quads follow fields, and start from meshes of another size.
    ("quad", &["mesh", "geometry", "numeric", "field", "remesh"]),
    ("io", &["mesh", "geometry", "brep", "patch"]),
    ("sample", &["mesh", "geometry", "brep", "patch"]),
    ("report", &["mesh", "geometry", "brep", "patch", "field", "quad"]),
];
const GROUND: &[&str] = &["error", "context", "length", "bounds", "words"];
/// What the crate's root re-exports from the ground floor.
const ROOT: &[&str] = &["Context", "Error", "Result", "Place", "Length", "DVec3", "CornerId"];

fn rust_files(folder: &Path, into: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let path = entry.path();
        if path.is_dir() {
            rust_files(&path, into);
        } else if path.extension().is_some_and(|e| e == "rs") {
            into.push(path);
        }
    }
}

/// The parts named after `crate::` in a source text, test modules left out.
fn named_parts(text: &str) -> Vec<String> {
    let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or(text);
    let word = |rest: &str| rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
    let mut parts = Vec::new();
    for line in lines {
        for (at, _) in line.match_indices("crate::") {
            let rest = &line[at + "crate::".len()..];
            match rest.strip_prefix('{') {
                Some(list) => parts.extend(list.split(',').map(|item| word(item.trim()))),
                None => parts.push(word(rest)),
            }
        }
    }
    parts.retain(|p| !p.is_empty());
    parts
}

#[test]
fn every_part_knows_only_what_it_may() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut seen = 0;
    for (part, allowed) in MAY_KNOW {
        let mut files = Vec::new();
        rust_files(&source.join(part), &mut files);
        assert!(!files.is_empty(), "{part} has no files");
        for file in files.iter().filter(|f| !f.to_string_lossy().ends_with("tests.rs")) {
            for name in named_parts(&fs::read_to_string(file).unwrap()) {
                let fits = name == *part
                    || allowed.contains(&name.as_str())
                    || GROUND.contains(&name.as_str())
                    || ROOT.contains(&name.as_str());
                assert!(fits, "{} names `crate::{name}`, which {part} may not know", file.display());
                seen += 1;
            }
        }
    }
    assert!(seen > 100, "the test reads the `use` lines: {seen} found");
}

#[test]
fn every_folder_of_the_library_is_in_the_table() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let folders = fs::read_dir(source).unwrap().map(|e| e.unwrap().path()).filter(|p| p.is_dir());
    for folder in folders {
        let name = folder.file_name().unwrap().to_string_lossy().into_owned();
        assert!(MAY_KNOW.iter().any(|(part, _)| *part == name), "{name} has no place in the house");
    }
}

/// A constant of a module: its name, its file, and whether it has a comment of its own.
struct Constant {
    name: String,
    file: PathBuf,
    described: bool,
}

/// The name that a line declares as a constant of its module.
fn constant_of(line: &str) -> Option<&str> {
    let rest = match line.strip_prefix("pub") {
        // `pub `, `pub(crate) ` and the like.
        Some(rest) => {
            rest.trim_start_matches(|c: char| c == '(' || c == ')' || c == ':' || c.is_alphanumeric()).trim_start()
        }
        None => line,
    };
    let name = rest.strip_prefix("const ")?.split(':').next()?.trim();
    name.chars().all(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_').then_some(name)
}

/// The constants of the modules in a folder, test modules left out.
fn constants(folder: &Path) -> Vec<Constant> {
    let mut files = Vec::new();
    rust_files(folder, &mut files);
    files.sort();
    let mut found = Vec::new();
    for file in files.into_iter().filter(|f| !f.to_string_lossy().ends_with("tests.rs")) {
        let text = fs::read_to_string(&file).unwrap();
        let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
        let lines: Vec<&str> = code.lines().collect();
        for (k, line) in lines.iter().enumerate() {
            let Some(name) = constant_of(line) else { continue };
            let above = lines[..k].iter().rev().find(|l| !l.starts_with("#["));
            let described = above.is_some_and(|l| l.starts_with("///"));
            found.push(Constant { name: name.into(), file: file.clone(), described });
        }
    }
    found
}

#[test]
fn every_constant_of_a_module_is_described_and_has_a_name_of_its_own_in_its_room() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let (mut seen, mut wrong) = (0, Vec::new());
    for (part, _) in MAY_KNOW {
        let all = constants(&source.join(part));
        let mut first = BTreeMap::new();
        for constant in &all {
            let place = constant.file.strip_prefix(&source).unwrap().display().to_string();
            if !constant.described {
                wrong.push(format!("{place}: {} has no comment of its own: quantity, unit, reason", constant.name));
            }
            if let Some(other) = first.insert(constant.name.clone(), place.clone()) {
                wrong.push(format!("{place}: {} is also a constant of {other}", constant.name));
            }
            seen += 1;
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(seen > 500, "the test reads the constants: {seen} found");
}

#[test]
fn what_is_a_constant() {
    assert_eq!(constant_of("const NEAR: f64 = 0.3;"), Some("NEAR"));
    assert_eq!(constant_of("pub(super) const NEAR_2: f64 = 0.3;"), Some("NEAR_2"));
    assert_eq!(constant_of("pub const fn new() -> Self {"), None);
    assert_eq!(constant_of("    const INSIDE: f64 = 1.0;"), None);
}
