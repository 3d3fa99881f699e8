//! The house: which part of the library may know which, how its modules stand on each other, and how large they are.
//!
//! Everything here is read from the sources. Where the house is not yet as it should be, a table says by how much; a number in it
//! may only go down.

#![allow(clippy::unwrap_used, clippy::panic)] // a test fails by panicking

mod constants;
mod imports;
mod sizes;
mod source;

use imports::Imports;
use source::{Module, modules_of};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Every part and what it may know, besides itself and the ground floor (`error`, `context`, `length`, `bounds`, `words`).
const MAY_KNOW: &[(&str, &[&str])] = &[
    ("context", &[]),
    ("mesh", &[]),
    ("numeric", &["mesh"]),
    ("geometry", &["mesh", "numeric"]),
    ("brep", &["mesh", "geometry", "numeric"]),
    ("skeleton", &["mesh", "geometry", "numeric"]),
    // Cells of a surface stand about its skeleton.
    ("hex", &["mesh", "geometry", "numeric", "skeleton"]),
    ("patch", &["mesh", "geometry", "brep", "numeric"]),
    ("remesh", &["mesh", "geometry", "numeric"]),
    ("segment", &["mesh", "geometry", "numeric"]),
    ("field", &["mesh", "geometry", "numeric"]),
    // Its rungs are made of other rooms: quads follow fields, and start from meshes of another size.
    ("quad", &["mesh", "geometry", "numeric", "field", "remesh"]),
    // Regions become faces, and blocks of quads.
    ("cad", &["mesh", "geometry", "numeric", "brep", "segment", "quad"]),
    ("io", &["mesh", "geometry", "brep", "patch"]),
    ("sample", &["mesh", "geometry", "brep", "patch"]),
    ("report", &["mesh", "geometry", "brep", "patch", "field", "quad"]),
];
const GROUND: &[&str] = &["error", "context", "length", "bounds", "words"];

/// Imports that run back up, by room: modules that use what is defined in a module above them (`use super::Options`).
const RUN_BACK_UP: &[(&str, usize)] = &[("brep", 25), ("cad", 3), ("field", 1), ("quad", 11), ("segment", 3)];

/// Modules that stand in a circle, by room: each uses what is defined in the next one.
const IN_CIRCLES: &[(&str, usize)] = &[("brep", 2), ("cad", 4), ("quad", 44), ("segment", 4)];

/// Most lines of a file; files of tests alone do not count.
const LONGEST_FILE: usize = 400;

/// Files that are longer, with their lines.
const LONG_FILES: &[(&str, usize)] = &[
    ("carreau/src/quad/graph/trace.rs", 512),
    ("carreau/src/segment/mod.rs", 639),
    ("carreau/src/segment/recognise.rs", 548),
];

/// Most lines of a function, from its signature to its closing brace.
const LONGEST_FUNCTION: usize = 60;

/// Files with functions that are longer, and the lines of all of these.
const LONG_FUNCTIONS: &[(&str, usize)] = &[
    ("carreau/src/brep/validate/distance.rs", 133),
    ("carreau/src/cad/model.rs", 73),
    ("carreau/src/cad/spline.rs", 62),
    ("carreau/src/cad/topology.rs", 61),
    ("carreau/src/field/relax.rs", 64),
    ("carreau/src/field/target.rs", 68),
    ("carreau/src/quad/coarse.rs", 67),
    ("carreau/src/quad/source.rs", 72),
    ("carreau/src/segment/boundaries.rs", 64),
    ("carreau/src/segment/noisy/ambiguous.rs", 63),
];

/// A crate of the workspace: its modules, and what its parts are called here.
struct Crate {
    name: &'static str,
    modules: Vec<Module>,
}

impl Crate {
    fn library() -> Self {
        Crate { name: "carreau", modules: modules_of(&crates().join("carreau/src/lib.rs")) }
    }

    fn command_line() -> Self {
        Crate { name: "carreau-cli", modules: modules_of(&crates().join("carreau-cli/src/lib.rs")) }
    }

    /// The room that a module belongs to: a part of the library, or the command line as a whole.
    fn room(&self, module: usize) -> String {
        match self.modules[module].part() {
            Some(part) if self.name == "carreau" => part.into(),
            _ => self.name.into(),
        }
    }

    fn file(&self, module: usize) -> String {
        format!("{}/src/{}", self.name, self.modules[module].file.display()).replace('\\', "/")
    }
}

/// The folder of all crates.
fn crates() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_path_buf()
}

/// Fails unless what was found is what a table allows, neither more nor less.
fn compare(what: &str, found: &BTreeMap<String, usize>, allowed: &[(&str, usize)], list: &[String]) {
    let allowed: BTreeMap<String, usize> = allowed.iter().map(|(name, count)| (name.to_string(), *count)).collect();
    let names = found.keys().chain(allowed.keys());
    let count = |of: &BTreeMap<String, usize>, name: &String| of.get(name).copied().unwrap_or(0);
    let mut wrong: Vec<String> = names
        .filter(|name| count(found, name) != count(&allowed, name))
        .map(|name| {
            let (now, before) = (count(found, name), count(&allowed, name));
            let then =
                if now < before { "lower the number in the table" } else { "this is more than the table allows" };
            format!("{what}: (\"{name}\", {now}), {before} in the table: {then}")
        })
        .collect();
    wrong.dedup();
    assert!(wrong.is_empty(), "{}\n{}", list.join("\n"), wrong.join("\n"));
}

#[test]
fn every_part_knows_only_what_it_may() {
    let library = Crate::library();
    let imports = Imports::of(&library.modules);
    let mut seen = 0;
    for &(from, to) in &imports.arrows {
        let (Some(part), Some(other)) = (library.modules[from].part(), library.modules[to].part()) else { continue };
        let allowed = MAY_KNOW.iter().find(|(name, _)| *name == part).map_or(&[][..], |(_, allowed)| allowed);
        let fits = part == other || allowed.contains(&other) || GROUND.contains(&other);
        assert!(fits, "{} uses {}, which {part} may not know", library.file(from), library.file(to));
        seen += usize::from(part != other);
    }
    assert!(seen > 500, "the test reads the imports: {seen} found");
}

#[test]
fn every_folder_of_the_library_is_in_the_table_and_stands_on_earlier_ones() {
    let folders = std::fs::read_dir(crates().join("carreau/src")).unwrap().map(|e| e.unwrap().path());
    for folder in folders.filter(|p| p.is_dir()) {
        let name = folder.file_name().unwrap().to_string_lossy().into_owned();
        assert!(MAY_KNOW.iter().any(|(part, _)| *part == name), "{name} has no place in the house");
    }
    let at = |name: &str| MAY_KNOW.iter().position(|(part, _)| *part == name);
    for (k, (part, allowed)) in MAY_KNOW.iter().enumerate() {
        assert!(
            allowed.iter().all(|other| at(other).is_some_and(|j| j < k)),
            "{part} knows a part below it in the table"
        );
    }
}

#[test]
fn the_modules_of_a_room_stand_on_floors() {
    let (mut back_up, mut in_circles, mut list, mut seen) = (BTreeMap::new(), BTreeMap::new(), Vec::new(), 0);
    for house in [Crate::library(), Crate::command_line()] {
        let imports = Imports::of(&house.modules);
        seen += imports.arrows.len();
        for (from, to) in imports.back_up() {
            *back_up.entry(house.room(from)).or_insert(0) += 1;
            list.push(format!("back up: {} uses {}", house.file(from), house.file(to)));
        }
        for circle in imports.circles() {
            *in_circles.entry(house.room(circle[0])).or_insert(0) += circle.len();
            let files: Vec<String> = circle.iter().map(|&k| house.file(k)).collect();
            list.push(format!("circle: {}", files.join(" ")));
        }
    }
    compare("imports that run back up", &back_up, RUN_BACK_UP, &list);
    compare("modules in circles", &in_circles, IN_CIRCLES, &list);
    assert!(seen > 1500, "the test reads the imports: {seen} found");
}

#[test]
fn files_and_functions_are_short() {
    let (mut files, mut functions, mut list, mut seen) = (BTreeMap::new(), BTreeMap::new(), Vec::new(), 0);
    for house in [Crate::library(), Crate::command_line()] {
        for (k, module) in house.modules.iter().enumerate() {
            let lines = module.text.lines().count();
            if lines > LONGEST_FILE {
                files.insert(house.file(k), lines);
            }
            for function in sizes::functions(module) {
                seen += 1;
                if function.length > LONGEST_FUNCTION {
                    *functions.entry(house.file(k)).or_insert(0) += function.length;
                    list.push(format!(
                        "{}:{}: {} has {}",
                        house.file(k),
                        function.line,
                        function.name,
                        function.length
                    ));
                }
            }
        }
    }
    compare("lines of files", &files, LONG_FILES, &list);
    compare("lines of long functions", &functions, LONG_FUNCTIONS, &list);
    assert!(seen > 4000, "the test reads the functions: {seen} found");
}

#[test]
fn every_constant_of_a_module_is_described_and_has_a_name_of_its_own_in_its_room() {
    let (mut seen, mut wrong) = (0, Vec::new());
    let library = Crate::library();
    let mut first: BTreeMap<(String, String), String> = BTreeMap::new();
    for (k, module) in library.modules.iter().enumerate() {
        for constant in constants::constants(module) {
            let (name, file) = (constant.name, library.file(k));
            if !constant.described {
                wrong.push(format!("{file}: {name} has no comment of its own: quantity, unit, reason"));
            }
            if let Some(other) = first.insert((library.room(k), name.clone()), file.clone()) {
                wrong.push(format!("{file}: {name} is also a constant of {other}"));
            }
            seen += 1;
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(seen > 500, "the test reads the constants: {seen} found");
}
