//! Values of options are checked alike, whether a flag or a file gives them.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::print_stderr)] // a test fails by panicking

mod common;

use common::{carreau, record, text};
use std::fs;
use tempfile::TempDir;

/// A verb, an option and values that make no sense, as they stand in an options file.
const WRONG: &[(&str, &str, &[&str])] = &[
    ("simplify", "deadline", &["-1", "0", "1e300"]),
    ("simplify", "max_size", &["\"0\"", "\"0%\""]),
    ("simplify", "min_size", &["\"30%\""]),
    ("simplify", "feature_angle", &["400", "-1"]),
    ("simplify", "triangles", &["0", "9999999999"]),
    ("simplify", "scale", &["0", "-1"]),
    ("simplify", "deviation", &["0", "90"]),
    ("simplify", "enrich", &["0", "95"]),
    ("simplify", "gradation", &["1", "0"]),
    ("simplify", "ridge_tolerance", &["-1"]),
    ("simplify", "distance", &["\"0\""]),
    ("enrich", "scale", &["0", "-1"]),
    ("quad", "quads", &["0", "1000000000"]),
    ("quad", "rung", &["0", "5"]),
    ("quad", "edge_length", &["\"0\""]),
    ("quad", "feature_angle", &["400"]),
    ("motorcycle", "quads", &["0"]),
    ("field", "lean_deg", &["90", "-1"]),
    ("field", "feature_angle", &["181"]),
    ("patch", "dihedral", &["181", "-1"]),
    ("patch", "min_cells", &["0"]),
    ("patch", "crease_angle", &["400"]),
    ("segment", "clusters", &["0", "1000"]),
    ("segment", "regions", &["0"]),
    ("segment", "min_area", &["1", "-1"]),
    ("segment", "radius", &["\"0\""]),
    ("curvature", "feature_angle", &["400", "-1"]),
    ("skeleton", "speed", &["0", "11"]),
    ("hex", "refine_along", &["100"]),
    ("hex", "edge_length", &["\"0\""]),
    ("hex", "hexes", &["0"]),
    ("compare", "samples", &["9999999999999"]),
    ("simplify", "no_such_option", &["1"]),
];

#[test]
fn values_in_a_file_are_checked_like_flags() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    // Nobody gets as far as reading it.
    let input = at("part.ply");
    fs::write(&input, "this is no mesh").unwrap();
    for (verb, option, values) in WRONG {
        for value in *values {
            let file = at("options.json");
            fs::write(&file, format!("{{\"{option}\": {value}}}")).unwrap();
            let mut command = carreau();
            command.args([verb, text(&input)]);
            if *verb == "compare" {
                command.arg(&input);
            }
            let out = command.args(["--options", text(&file)]).assert().get_output().clone();
            let told = String::from_utf8_lossy(&out.stderr).into_owned();
            assert_eq!(out.status.code(), Some(2), "{verb} {option} {value}: {told}");
            let words = [option.to_string(), option.replace('_', "-"), option.replace('_', " "), value.to_string()];
            let deg = option.trim_end_matches("_deg");
            assert!(words.iter().any(|w| told.contains(w)) || told.contains(deg), "{verb} {option} {value}: {told}");
        }
    }
}

#[test]
fn flags_that_make_no_sense() {
    let folder = TempDir::new().unwrap();
    let input = folder.path().join("part.ply");
    fs::write(&input, "this is no mesh").unwrap();
    for line in [
        "simplify --max-size 0",
        "simplify --feature-angle nan",
        "simplify --feature-angle inf",
        "simplify --feature-angle 400",
        "simplify --min-size 5% --max-size 1%",
        "simplify --triangles 0",
        "enrich --max-size 0",
        "quad --feature-angle nan",
        "field --feature-angle inf",
        "curvature --feature-angle nan",
        "patch --feature-angle nan",
        "segment --sharp-angle nan",
    ] {
        let mut words = line.split(' ');
        let verb = words.next().unwrap();
        carreau().arg(verb).arg(&input).args(words).assert().code(2);
    }
}

/// More threads than make sense are not started, and that is said.
#[test]
fn threads_are_capped() {
    let folder = TempDir::new().unwrap();
    let model = folder.path().join("m.ply");
    carreau().args(["sample", "torus", "-o", text(&model)]).assert().success();
    let found = record(&["info", text(&model), "--threads", "100000"]);
    let warnings = found["warnings"].to_string();
    assert!(warnings.contains("100000 threads"), "{warnings}");
}

#[test]
fn every_verb_takes_its_options_from_a_file() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    let (options, model, page, json) = (at("options.json"), at("torus.ply"), at("torus.html"), at("record.json"));
    let ran = |arguments: &[&str], given: &str| {
        fs::write(&options, given).unwrap();
        let run =
            carreau().args(arguments).args(["--options", text(&options), "--json", text(&json)]).output().unwrap();
        (run.status.code(), fs::read_to_string(&json).unwrap_or_default())
    };
    let sample = ["sample", "torus", "-o", text(&model)];
    let view = ["view", text(&model), "-o", text(&page)];
    let (code, record) = ran(&sample, "{\"resolution\": 12, \"threads\": 2}");
    assert_eq!(code, Some(0));
    let record: serde_json::Value = serde_json::from_str(&record).unwrap();
    assert_eq!((&record["options"]["resolution"], &record["options"]["threads"]), (&12.into(), &2.into()));
    assert_eq!(record["options"]["name"], "torus");
    let (code, record) = ran(&view, "{\"curvature\": false}");
    assert_eq!(code, Some(0));
    let record: serde_json::Value = serde_json::from_str(&record).unwrap();
    assert_eq!(record["options"]["curvature"], false);
    // A file that does not fit is refused by all of them.
    let demo = at("demo");
    for arguments in [&sample[..], &view[..], &["demo", "-o", text(&demo)]] {
        for wrong in ["{\"no_such_option\": 1}", "{\"deadline\": -1}", "no JSON"] {
            assert_eq!(ran(arguments, wrong).0, Some(2), "{arguments:?} {wrong}");
        }
    }
    assert!(!demo.exists());
}
