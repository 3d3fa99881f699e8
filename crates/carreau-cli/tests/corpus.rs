//! The command on the corpus of real and broken models, where it is at hand; see `common::shared`.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::print_stderr)] // a test fails by panicking

mod common;

use common::{carreau, record, shared, text};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// Declared verdict by file name.
fn verdicts(data: &Path) -> BTreeMap<String, Value> {
    let manifest: Value = serde_json::from_slice(&fs::read(data.join("manifest.json")).unwrap()).unwrap();
    let files = manifest["files"].as_array().unwrap().iter();
    files.filter_map(|f| f["name"].as_str()?.strip_prefix("nasty/").map(|name| (name.to_string(), f.clone()))).collect()
}

#[test]
fn broken_files_meet_their_verdict() {
    let Some(data) = shared() else { return };
    let folder = TempDir::new().unwrap();
    let mut runs = 0;
    for (name, entry) in verdicts(&data).iter().filter(|(name, _)| !name.ends_with(".bin")) {
        let input = data.join("nasty").join(name);
        let expect = entry["expect"].as_str().unwrap_or("none");
        for (verb, end) in [("info", None), ("convert", Some("ply")), ("patch", Some("obj"))] {
            let output = end.map(|end| folder.path().join(format!("out.{end}")));
            let mut command = carreau();
            command.args([verb, text(&input), "--json", "-"]).timeout(std::time::Duration::from_secs(60));
            if let Some(output) = &output {
                command.args(["-o", text(output)]);
            }
            let out = command.output().unwrap();
            let code = out.status.code();
            let errors = String::from_utf8_lossy(&out.stderr);
            assert!(!errors.contains("panicked"), "{verb} {name}: {errors}");
            let allowed: &[i32] = match (expect, verb) {
                ("ok", "info" | "convert") => &[0],
                ("ok", _) => &[0, 3, 4],
                ("error", _) => &[0, 3, 5],
                (_, "patch") => &[0, 2, 3, 4, 5],
                _ => &[0, 2, 3, 5],
            };
            assert!(code.is_some_and(|c| allowed.contains(&c)), "{verb} {name} ({expect}): {code:?} {errors}");
            if code == Some(0) {
                let json: Value = serde_json::from_slice(&out.stdout).unwrap();
                let told = json["warnings"].as_array().is_some_and(|w| !w.is_empty());
                assert!(expect != "error" || told, "{verb} {name}: accepted without a word");
                if verb == "info" && expect == "ok" {
                    for (key, declared) in [("vertices", "declared_vertices"), ("faces", "declared_faces")] {
                        let declared = &entry[declared];
                        assert!(declared.is_null() || json["input"][key] == *declared, "{name}: {key}");
                    }
                }
            } else {
                assert!(output.is_none_or(|o| !o.exists()), "{verb} {name} left a file");
            }
            runs += 1;
        }
        for end in ["ply", "obj"] {
            let _ = fs::remove_file(folder.path().join(format!("out.{end}")));
        }
    }
    assert!(runs > 1000, "{runs} runs");
}

/// Coverage, patches, and the patches needed for the paper's coverage of the bunny.
fn figures(json: &Value) -> (f64, u64, u64) {
    let needed = json["patches_for"]["0.8998"].as_u64().unwrap_or(u64::MAX);
    (json["coverage"].as_f64().unwrap(), json["patches"].as_u64().unwrap(), needed)
}

#[test]
fn the_bunny_and_the_fandisk_reach_their_figures() {
    let Some(data) = shared() else { return };
    let bunny = data.join("scan/stanford-bunny.obj");
    let fandisk = data.join("cad/fandisk.obj");
    let (coverage, patches, needed) = figures(&record(&["patch", text(&bunny)]));
    assert!(coverage >= 0.974 && patches <= 1150 && needed <= 430, "{coverage} {patches} {needed}");
    let (coverage, patches, needed) = figures(&record(&["patch", text(&fandisk)]));
    assert!(coverage >= 0.987 && patches <= 140 && needed <= 50, "{coverage} {patches} {needed}");
    let (_, _, needed) = figures(&record(&["patch", text(&bunny), "--preset", "paper"]));
    assert!(needed <= 1740, "{needed}");
    let (_, _, needed) = figures(&record(&["patch", text(&bunny), "--convex-only"]));
    assert!(needed <= 480, "{needed}");
}

#[test]
fn matchings_reach_the_optimum() {
    let Some(data) = shared() else { return };
    for (file, most, weighted) in [("scan/stanford-bunny.obj", 0.9986, 0.992), ("cad/fandisk.obj", 0.9998, 0.9995)] {
        let input = data.join(file);
        let of = |strategy| record(&["patch", text(&input), "--strategy", strategy, "--min-cells", "1"]);
        assert!(figures(&of("matching-cardinality")).0 >= most, "{file}");
        let json = of("matching");
        assert!(figures(&json).0 >= weighted, "{file}");
        assert!(json["quality"]["q_mean_deg"].as_f64().unwrap() <= 8.4, "{file}");
    }
}

#[test]
fn the_paper_s_own_model_needs_few_patches() {
    let folder = TempDir::new().unwrap();
    let model = folder.path().join("m.ply");
    carreau().args(["sample", "cube-cylinders", "-o", text(&model)]).assert().success();
    let json = record(&["patch", text(&model)]);
    assert_eq!((&json["input"]["vertices"], &json["input"]["faces"]), (&1306.into(), &2608.into()));
    // The paper: 21 patches for 95.47 %.
    let needed = json["patches_for"]["0.9547"].as_u64();
    assert!(needed.is_some_and(|n| n <= 10), "{needed:?}");
}
