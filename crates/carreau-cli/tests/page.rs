//! Pages: `view`, and `--report` of every verb.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::print_stderr)] // a test fails by panicking

mod common;

use common::{carreau, record, text};
use predicates::str::contains;
use serde_json::Value;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// The JSON head of a page.
fn head(page: &Path) -> Value {
    let html = fs::read_to_string(page).unwrap();
    let from = html.find("id=\"carreau-head\">").unwrap() + "id=\"carreau-head\">".len();
    let json = &html[from..from + html[from..].find("</script>").unwrap()];
    serde_json::from_str(json).unwrap()
}

/// Names and roles of the scenes of a page.
fn scenes(head: &Value) -> Vec<(String, String)> {
    let word = |v: &Value| v.as_str().unwrap().to_string();
    head["scenes"].as_array().unwrap().iter().map(|s| (word(&s["name"]), word(&s["role"]))).collect()
}

/// Names of the layers of a scene.
fn layers(head: &Value, scene: usize) -> Vec<&str> {
    head["scenes"][scene]["layers"].as_array().unwrap().iter().map(|l| l["name"].as_str().unwrap()).collect()
}

fn pairs(list: &[(&str, &str)]) -> Vec<(String, String)> {
    list.iter().map(|(a, b)| (a.to_string(), b.to_string())).collect()
}

#[test]
fn every_verb_reports_its_input_its_result_and_its_run() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    let path = |name: &str| text(&at(name)).to_string();
    let report = |line: &[&str]| {
        let page = at(&format!("{}.html", line[0]));
        carreau().args(line).args(["--report", text(&page)]).assert().success().stdout(contains("open "));
        let head = head(&page);
        assert!(head["command"].as_str().unwrap().starts_with(&format!("carreau {}", line[0])), "{}", head["command"]);
        assert_eq!(head["record"]["verb"], line[0]);
        assert!(head["record"]["options"].is_object() && head["record"]["seconds"]["total"].as_f64().unwrap() > 0.0);
        assert!(head["record"]["warnings"].is_array());
        head
    };
    let (bracket, tree) = (path("bracket.ply"), path("tree.ply"));
    let made = report(&["sample", "bracket", "--resolution", "30", "-o", &bracket]);
    assert_eq!(scenes(&made), pairs(&[("bracket.ply", "after")]));
    carreau().args(["sample", "tube-tree", "--resolution", "50", "-o", &tree]).assert().success();

    let both = |after: &str| pairs(&[("bracket.ply", "before"), (after, "after")]);
    assert_eq!(scenes(&report(&["info", &bracket])), pairs(&[("bracket.ply", "before")]));
    assert_eq!(scenes(&report(&["convert", &bracket, "-o", &path("b.off")])), both("b.off"));
    assert_eq!(scenes(&report(&["repair", &bracket, "-o", &path("r.ply")])), both("r.ply"));
    assert_eq!(scenes(&report(&["patch", &bracket, "-o", &path("p.step")])), both("p.step"));
    assert_eq!(scenes(&report(&["enrich", &bracket, "-o", &path("e.ply")])), both("e.ply"));
    assert_eq!(scenes(&report(&["simplify", &bracket])), both("result of simplify"));

    let segmented = report(&["segment", &bracket, "-o", &path("s.ply")]);
    assert_eq!((scenes(&segmented), &segmented["scenes"][1]["show"]), (both("s.ply"), &"region".into()));
    for name in ["region", "primitive", "fit_error", "kmin", "kmax", "quality"] {
        assert!(layers(&segmented, 1).contains(&name), "{name}");
    }
    let curved = report(&["curvature", &bracket]);
    assert!(["kmin", "kmax", "dmin", "dmax"].iter().all(|name| layers(&curved, 1).contains(name)));
    let field = report(&["field", &bracket]);
    let lines: Vec<&Value> = field["scenes"][1]["lines"].as_array().unwrap().iter().map(|l| &l["style"]).collect();
    assert_eq!(lines, ["field", "feature"]);
    // The graph has a layer of lines: on its own page and where its file is viewed.
    let tracks = |head: &Value, scene: usize| {
        let lines = head["scenes"][scene]["lines"].as_array().unwrap().clone();
        let found: Vec<Value> = lines.into_iter().filter(|l| l["style"] == "track").collect();
        assert!(
            found.len() == 1 && found[0]["name"] == "motorcycle graph" && found[0]["edges"].is_object(),
            "{found:?}"
        );
    };
    let graph = report(&["motorcycle", &bracket, "--quads", "400", "-o", &path("g.vtp")]);
    tracks(&graph, 1);
    assert_eq!((scenes(&graph), &graph["scenes"][1]["show"]), (both("g.vtp"), &"patch".into()));
    carreau().args(["view", &path("g.vtp"), "-o", text(&at("g.html"))]).assert().success();
    tracks(&head(&at("g.html")), 0);
    let quads = report(&["quad", &bracket, "--quads", "400", "-o", &path("q.obj")]);
    assert_eq!((scenes(&quads), &quads["scenes"][1]["faces"]["size"]), (both("q.obj"), &4.into()));

    let skeleton = report(&["skeleton", &tree, "-o", &path("t.cgr")]);
    assert_eq!(skeleton["scenes"][1]["nets"].as_array().unwrap().len(), 1);
    let hexes = report(&["hex", &path("t.cgr"), "-o", &path("t.vtu")]);
    assert_eq!(scenes(&hexes), pairs(&[("t.cgr", "before"), ("t.vtu", "after")]));
    assert_eq!((&hexes["scenes"][1]["cells"]["size"], &hexes["scenes"][1]["show"]), (&8.into(), &"quality".into()));
    let compared = report(&["compare", &path("r.ply"), &bracket]);
    assert_eq!(scenes(&compared), pairs(&[("r.ply", "other"), ("bracket.ply", "other")]));
}

#[test]
fn view_shows_files_of_all_kinds() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    carreau().args(["sample", "tube-tree", "--resolution", "50", "-o", text(&at("t.ply"))]).assert().success();
    carreau().args(["skeleton", text(&at("t.ply")), "-o", text(&at("t.cgr"))]).assert().success();
    carreau().args(["convert", text(&at("t.ply")), "-o", text(&at("t.stl"))]).assert().success();
    let page = at("page.html");
    let files = ["t.stl", "t.cgr", "t.ply"].map(|name| text(&at(name)).to_string());
    let json = record(&["view", &files[0], &files[1], &files[2], "-o", text(&page)]);
    assert_eq!(json["output"]["scenes"], 3);
    let all = head(&page);
    assert_eq!(scenes(&all), pairs(&[("t.stl", "other"), ("t.cgr", "other"), ("t.ply", "other")]));
    assert_eq!(all["title"], "carreau view t.stl, t.cgr, t.ply");
    assert!(layers(&all, 0).contains(&"kmax"));
    carreau().args(["view", &files[0], "--no-curvature", "-o", text(&page)]).assert().success();
    assert_eq!(layers(&head(&page), 0), ["quality"]);
}

#[test]
fn a_page_that_cannot_be_written_is_a_failure_to_write() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    carreau().args(["sample", "torus", "--resolution", "12", "-o", text(&at("t.ply"))]).assert().success();
    let nowhere = at("no/such/page.html");
    let fails = |line: &[&str]| carreau().args(line).assert().code(5).stderr(contains("page.html"));
    fails(&["view", text(&at("t.ply")), "-o", text(&nowhere)]);
    fails(&["info", text(&at("t.ply")), "--report", text(&nowhere)]);
    carreau()
        .args(["view", text(&at("none.ply")), "-o", text(&at("p.html"))])
        .assert()
        .code(5)
        .stderr(contains("none.ply"));
    assert!(!at("p.html").exists());
    carreau().args(["view", "-o", text(&at("p.html"))]).assert().code(2);
}

#[test]
fn a_page_does_not_depend_on_threads() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    carreau().args(["sample", "noisy-torus", "-o", text(&at("t.ply"))]).assert().success();
    // The command and the seconds differ, the models do not.
    let models = |threads: &str| {
        let page = at(&format!("{threads}.html"));
        carreau().args(["view", text(&at("t.ply")), "--threads", threads, "-o", text(&page)]).assert().success();
        let html = fs::read_to_string(page).unwrap();
        html[html.find("id=\"carreau-data\"").unwrap()..].to_string()
    };
    assert!(models("1") == models("2"));
}
