//! The direction of knowledge: which part of the library may name which.

#![allow(clippy::unwrap_used)] // a test fails by panicking

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
