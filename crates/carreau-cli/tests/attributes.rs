//! The table of docs/formats.md: every attribute of the input, through every verb, into every format, is in the output or
//! named by a warning. No cell is silent.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::print_stderr)] // a test fails by panicking

mod common;

use common::{carreau, record, text};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// Corners of a ring, and rings.
const SIDES: usize = 8;
const RINGS: usize = 10;

/// A closed tube with lids: groups, objects, materials with their library, texture coordinates and normals of corners, colours
/// of vertices, a line. Its quads make it fit for every verb.
fn tube() -> String {
    let mut out = String::from("mtllib scene 1.mtl\n");
    for ring in 0..RINGS {
        for side in 0..SIDES {
            let angle = 2.0 * std::f64::consts::PI * side as f64 / SIDES as f64;
            let red = ring as f64 / RINGS as f64;
            writeln!(out, "v {} {} {} {red} 0.5 0.25", angle.cos(), angle.sin(), ring as f64).unwrap();
        }
    }
    for k in 0..4 {
        writeln!(out, "vt {} {}\nvn 0 {} 1", k % 2, k / 2, f64::from(k)).unwrap();
    }
    let quad = |ids: [usize; 4], out: &mut String| {
        let corners: Vec<String> = ids.iter().zip(1..).map(|(v, k)| format!("{}/{k}/{k}", v + 1)).collect();
        writeln!(out, "f {}", corners.join(" ")).unwrap();
    };
    for ring in 0..RINGS - 1 {
        match ring {
            0 => out += "o lower half\ng left side\nusemtl red paint\n",
            5 => out += "o upper half\ng right side\nusemtl rubber\n",
            _ => {}
        }
        for side in 0..SIDES {
            let next = (side + 1) % SIDES;
            let at = |r: usize, s: usize| r * SIDES + s;
            quad([at(ring, side), at(ring, next), at(ring + 1, next), at(ring + 1, side)], &mut out);
        }
    }
    for ring in [0, RINGS - 1] {
        for k in (1..SIDES - 2).step_by(2) {
            let at = |s: usize| ring * SIDES + s;
            let ids = [at(0), at(k), at(k + 1), at(k + 2)];
            let [a, b, c, d] = ids;
            quad(if ring == 0 { [a, d, c, b] } else { ids }, &mut out);
        }
    }
    out + "l 1 9 17\n"
}

const LIBRARY: &str = "newmtl red paint\nKd 0.8 0.1 0.1\nnewmtl rubber\nKd 0.1 0.1 0.1\nmap_Kd skin.png\n";

/// Attributes of the tube, and a word that its names are known by.
const ATTRIBUTES: &[&str] = &["uv", "normal", "color", "group", "object", "material"];
const WORDS: &[(&str, &str)] = &[("group", "left side"), ("object", "lower half"), ("material", "red paint")];

/// Verbs with a surface as their result, and their further words.
const VERBS: &[(&str, &[&str])] = &[
    ("convert", &[]),
    ("repair", &[]),
    ("curvature", &[]),
    ("segment", &[]),
    ("enrich", &["--deviation", "20"]),
    ("simplify", &["--deviation", "25"]),
    ("patch", &[]),
    ("field", &[]),
    ("motorcycle", &["--quads", "100"]),
    ("quad", &["--quads", "100"]),
];
const SURFACES: &[&str] =
    &["obj", "off", "ply", "stl", "mesh", "meshb", "msh", "vtk", "vtu", "vtp", "gltf", "glb", "3mf", "inp", "bdf"];

/// The names of all columns of a file.
fn columns(file: &Path) -> BTreeSet<String> {
    let found = record(&["info", text(file)]);
    let all = found["attributes"].as_object().unwrap().values();
    all.flat_map(|columns| columns.as_object().unwrap().keys().cloned().collect::<Vec<_>>()).collect()
}

/// Text that has the names of a file in it.
fn names_in(file: &Path) -> String {
    let extension = file.extension().unwrap().to_str().unwrap();
    if extension == "3mf" {
        let plain = file.with_extension("plain.obj");
        carreau().args(["convert", text(file), "-o", text(&plain), "-q"]).assert().success();
        return fs::read_to_string(plain).unwrap();
    }
    String::from_utf8_lossy(&fs::read(file).unwrap()).into_owned()
}

/// Checks one cell for every attribute.
fn check(line: &str, file: &Path, found: &Value) {
    let extension = file.extension().unwrap().to_str().unwrap();
    let warnings = found["warnings"].to_string();
    let is_deck = matches!(extension, "inp" | "bdf");
    let there = if is_deck { BTreeSet::new() } else { columns(file) };
    let text = names_in(file);
    let says = |name: &str| {
        warnings.contains(&format!("'{name}'"))
            || warnings.contains(&format!("attributes: {name}"))
            || warnings.split([',', ':', ';']).any(|part| part.trim().trim_end_matches(['"', ']']) == name)
    };
    for &name in ATTRIBUTES {
        // One label column becomes the reference number of formats that have no other.
        let as_reference = matches!(extension, "mesh" | "meshb" | "msh") && name == "group" && there.contains("ref");
        let word = WORDS.iter().find(|(column, _)| *column == name).map(|(_, word)| *word);
        let as_set = is_deck && word.is_some_and(|word| text.contains(&word.replace(' ', "_")));
        let kept = there.contains(name) || as_reference || as_set;
        assert!(kept || says(name), "{line}: '{name}' vanished silently; columns {there:?}, warnings {warnings}");
        let Some(word) = word.filter(|_| kept) else { continue };
        let named = text.contains(word) || text.contains(&word.replace(' ', "_"));
        let said = warnings.contains("names of labels") || says(name);
        assert!(named || said, "{line}: the names of '{name}' vanished silently; warnings {warnings}");
    }
    let library = warnings.contains("textures") || warnings.contains("colours of labels") || says("material");
    assert!(
        library || file.with_extension("mtl").is_file(),
        "{line}: the library vanished silently; warnings {warnings}"
    );
}

#[test]
fn no_cell_of_the_table_is_silent() {
    let folder = TempDir::new().unwrap();
    let input = folder.path().join("tube.obj");
    fs::write(&input, tube()).unwrap();
    fs::write(folder.path().join("scene 1.mtl"), LIBRARY).unwrap();
    std::thread::scope(|scope| {
        for half in [0, 1] {
            let (input, folder) = (&input, folder.path());
            scope.spawn(move || {
                for (verb, more) in VERBS.iter().skip(half).step_by(2) {
                    for extension in SURFACES {
                        let file = folder.join(format!("{verb}-out.{extension}"));
                        let line = [&[*verb, text(input), "-o", text(&file), "-q"], *more].concat();
                        check(&line.join(" "), &file, &record(&line));
                    }
                }
            });
        }
    });
}

/// Methods whose results are no surfaces say what they leave behind.
#[test]
fn volumes_and_skeletons_say_what_they_leave_behind() {
    let folder = TempDir::new().unwrap();
    let input = folder.path().join("tube.obj");
    fs::write(&input, tube()).unwrap();
    fs::write(folder.path().join("scene 1.mtl"), LIBRARY).unwrap();
    for (verb, name) in [("skeleton", "s.cgr"), ("hex", "h.vtu")] {
        let found = record(&[verb, text(&input), "-o", text(&folder.path().join(name)), "-q"]);
        let warnings = found["warnings"].to_string();
        for name in ATTRIBUTES {
            assert!(warnings.contains(&format!("'{name}'")), "{verb}: '{name}' vanished silently: {warnings}");
        }
    }
}

/// The library goes along, and the second file has the colours of the first.
#[test]
fn materials_go_from_obj_to_obj_and_glb() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("tube.obj"), tube()).unwrap();
    fs::write(at("scene 1.mtl"), LIBRARY).unwrap();
    fs::create_dir(at("other")).unwrap();
    let out = at("other").join("b.obj");
    let found = record(&["convert", text(&at("tube.obj")), "-o", text(&out)]);
    assert!(found["warnings"].to_string().contains("1 texture"), "{}", found["warnings"]);
    assert_eq!(fs::read_to_string(at("other").join("b.mtl")).unwrap(), LIBRARY);
    assert!(fs::read_to_string(&out).unwrap().starts_with("mtllib b.mtl\n"));
    carreau().args(["convert", text(&out), "-o", text(&at("c.glb")), "-q"]).assert().success();
    carreau().args(["convert", text(&at("c.glb")), "-o", text(&at("d.obj")), "-q"]).assert().success();
    let made = fs::read_to_string(at("d.mtl")).unwrap();
    assert!(made.contains("newmtl red paint\nKd 0.8 0.1"), "{made}");
    // A library that is missing is told, its name is kept.
    fs::remove_file(at("scene 1.mtl")).unwrap();
    let found = record(&["convert", text(&at("tube.obj")), "-o", text(&at("e.obj"))]);
    assert!(found["warnings"].to_string().contains("'scene 1.mtl' is not beside"), "{}", found["warnings"]);
    assert!(fs::read_to_string(at("e.obj")).unwrap().contains("mtllib scene 1.mtl\n"));
}
