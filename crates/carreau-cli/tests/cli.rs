//! The command line as a user meets it.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::print_stderr)] // a test fails by panicking

mod common;

use common::{carreau, record, text};
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;
use serde_json::Value;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// A folder with a sample model in it.
fn with_model(name: &str, file: &str) -> (TempDir, std::path::PathBuf) {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join(file);
    carreau().args(["sample", name, "-o", text(&path)]).assert().success();
    (folder, path)
}

fn layout(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

#[test]
fn help_names_every_verb_and_each_has_an_example() {
    let help = carreau().arg("--help").assert().success().get_output().stdout.clone();
    let help = String::from_utf8(help).unwrap();
    for verb in [
        "demo",
        "sample",
        "info",
        "convert",
        "repair",
        "compare",
        "curvature",
        "segment",
        "cad",
        "enrich",
        "simplify",
        "patch",
        "field",
        "motorcycle",
        "quad",
        "hex",
        "skeleton",
        "view",
        "completions",
        "man",
    ] {
        assert!(help.contains(verb), "{verb}");
        carreau().args([verb, "--help"]).assert().success().stdout(contains("Example"));
    }
    carreau().args(["completions", "bash"]).assert().success().stdout(contains("_carreau"));
    carreau().arg("man").assert().success().stdout(contains(".TH"));
}

#[test]
fn samples_are_sound_through_info() {
    let list = record(&["sample", "--list"]);
    let names: Vec<&str> = list["samples"].as_array().unwrap().iter().map(|s| s["name"].as_str().unwrap()).collect();
    assert!(names.len() >= 10);
    let folder = TempDir::new().unwrap();
    for name in names {
        let path = folder.path().join(format!("{name}.ply"));
        carreau().args(["sample", name, "-o", text(&path)]).assert().success();
        let info = record(&["info", text(&path)]);
        let topology = &info["topology"];
        assert_eq!(topology["manifold"], true, "{name}");
        assert_eq!(topology["consistently_oriented"], true, "{name}");
        for defect in [
            "degenerate_faces",
            "duplicate_faces",
            "coincident_vertices",
            "unreferenced_vertices",
            "inverted_components",
        ] {
            assert_eq!(topology[defect], 0, "{name}: {defect}");
        }
    }
}

#[test]
fn patch_writes_mesh_layout_picture_record_and_cad() {
    let (folder, model) = with_model("cube-cylinders", "m.ply");
    let at = |name: &str| folder.path().join(name);
    let json = record(&[
        "patch",
        text(&model),
        "-o",
        text(&at("q.obj")),
        "--layout",
        text(&at("l.json")),
        "--picture",
        text(&at("p.png")),
    ]);
    let layout = layout(&at("l.json"));
    let patches = layout["patches"].as_array().unwrap();
    assert_eq!(json["patches"], patches.len());
    let cells: u64 = patches.iter().map(|p| p["rows"].as_u64().unwrap() * p["cols"].as_u64().unwrap()).sum();
    let left = layout["leftover"].as_array().unwrap().len() as u64;
    assert_eq!(2 * cells + left, 2608);
    assert_eq!(json["faces"].as_u64(), Some(cells + left));
    let quads = record(&["info", text(&at("q.obj"))]);
    assert_eq!(quads["input"]["vertices"], 1306);
    assert_eq!(quads["topology"]["closed"], true);
    assert!(fs::read(at("p.png")).unwrap().starts_with(b"\x89PNG"));
    for name in ["m.step", "m.igs"] {
        let json = record(&["patch", text(&model), "-o", text(&at(name))]);
        assert!(json["faces"].as_u64().unwrap() >= json["patches"].as_u64().unwrap());
        assert!(fs::metadata(at(name)).unwrap().len() > 1000);
    }
}

#[test]
fn a_record_replays_its_run() {
    let (folder, model) = with_model("bracket", "m.ply");
    let at = |name: &str| folder.path().join(name);
    let first = ["patch", text(&model), "--strategy", "matching", "--min-cells", "1", "--q-max", "60"];
    carreau().args(first).args(["--layout", text(&at("a.json")), "--json", text(&at("r.json"))]).assert().success();
    carreau()
        .args(["patch", text(&model), "--options", text(&at("r.json")), "--layout", text(&at("b.json"))])
        .assert()
        .success();
    assert_eq!(fs::read(at("a.json")).unwrap(), fs::read(at("b.json")).unwrap());
    // A flag wins over the file; an unknown name and another verb's record are refused.
    let json = record(&["patch", text(&model), "--options", text(&at("r.json")), "--min-cells", "5"]);
    assert_eq!((&json["options"]["min_cells"], &json["options"]["strategy"]), (&5.into(), &"matching".into()));
    fs::write(at("wrong.json"), r#"{"min_sells": 3}"#).unwrap();
    let wrong = |verb: &str, file: &str, output: &str| {
        carreau().args([verb, text(&model), "--options", text(&at(file)), "-o", text(&at(output))]).assert().code(2)
    };
    wrong("patch", "wrong.json", "x.obj").stderr(contains("min_sells"));
    wrong("convert", "r.json", "x.obj").stderr(contains("patch"));
}

#[test]
fn outputs_do_not_depend_on_threads_or_runs() {
    let (folder, model) = with_model("noisy-torus", "m.ply");
    for end in ["obj", "step", "igs", "png", "json"] {
        let of = |threads: &str, run: &str| {
            let path = folder.path().join(format!("{run}.{end}"));
            let flag = match end {
                "png" => "--picture",
                "json" => "--layout",
                _ => "-o",
            };
            carreau().args(["patch", text(&model), "--threads", threads, flag, text(&path)]).assert().success();
            fs::read(path).unwrap()
        };
        let once = of("1", "a");
        assert!(once == of("2", "b") && once == of("1", "c"), "{end}");
    }
}

#[test]
fn failures_have_the_codes_of_the_contract_and_leave_nothing() {
    let (folder, model) = with_model("torus", "m.ply");
    let at = |name: &str| folder.path().join(name);
    fs::write(at("keep.obj"), "# mine\n").unwrap();
    fs::write(at("points.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\n").unwrap();
    fs::write(at("broken.off"), "OFF\n3 1 0\n0 0 0\n1 0 0\n").unwrap();
    let tet = "MeshVersionFormatted 2\nDimension 3\nVertices 4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\nTetrahedra 1\n1 2 3 4 0\nEnd\n";
    fs::write(at("tet.mesh"), tet).unwrap();
    let out = text(&at("keep.obj")).to_string();
    let run = |input: &str, more: &[&str]| carreau().args(["patch", text(&at(input)), "-o", &out]).args(more).assert();
    run("m.ply", &["--q-max", "-3"]).code(2);
    run("m.ply", &["--strategy", "magic"]).code(2);
    run("points.obj", &[]).code(3).stderr(contains("points.obj").and(contains("no faces")));
    run("tet.mesh", &[]).code(3).stderr(contains("convert --boundary"));
    run("broken.off", &[]).code(5).stderr(contains("broken.off").and(contains("line")));
    run("absent.ply", &[]).code(5).stderr(contains("absent.ply"));
    run("m.ply", &["--deadline", "0.000001"]).code(124);
    carreau().args(["convert", text(&model), "-o", text(&at("x.docx"))]).assert().code(5).stderr(contains("docx"));
    carreau().args(["convert", text(&model), "-o", text(&at("no/such/folder.obj"))]).assert().code(5);
    assert_eq!(fs::read_to_string(at("keep.obj")).unwrap(), "# mine\n");
    let names: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(names.len(), 5, "nothing is left behind: {names:?}");
}

#[test]
fn a_volume_mesh_gives_its_boundary() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    let hex = "MeshVersionFormatted 2\nDimension 3\nVertices 8\n0 0 0 0\n1 0 0 0\n1 1 0 0\n0 1 0 0\n0 0 1 0\n1 0 1 0\n1 1 1 0\n\
               0 1 1 0\nHexahedra 1\n1 2 3 4 5 6 7 8 0\nEnd\n";
    fs::write(at("cube.mesh"), hex).unwrap();
    carreau().args(["convert", text(&at("cube.mesh")), "--boundary", "-o", text(&at("skin.off"))]).assert().success();
    let info = record(&["info", text(&at("skin.off"))]);
    assert_eq!((&info["topology"]["quads"], &info["topology"]["closed"]), (&6.into(), &true.into()));
    assert_eq!(info["topology"]["volume"], 1.0);
    // Hexes survive a change of format.
    for end in ["vtu", "vtk", "msh", "meshb"] {
        let file = at(&format!("cube.{end}"));
        carreau().args(["convert", text(&at("cube.mesh")), "-o", text(&file)]).assert().success();
        assert_eq!(record(&["info", text(&file)])["cells"]["hexahedra"], 1, "{end}");
    }
}

#[test]
fn repair_and_compare_say_what_they_find() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    // A tetrahedron as a soup with one face turned and one twice.
    let corners = ["0 0 0", "1 0 0", "0 1 0", "0 0 1"];
    let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 2, 3], [0, 2, 1]];
    let mut soup = String::new();
    faces.iter().flatten().for_each(|&v: &usize| soup += &format!("v {}\n", corners[v]));
    (0..faces.len()).for_each(|k| soup += &format!("f {} {} {}\n", 3 * k + 1, 3 * k + 2, 3 * k + 3));
    fs::write(at("soup.obj"), soup).unwrap();
    let json = record(&["repair", text(&at("soup.obj")), "-o", text(&at("clean.ply"))]);
    assert!(!json["warnings"].as_array().unwrap().is_empty());
    let info = record(&["info", text(&at("clean.ply"))]);
    assert_eq!((&info["topology"]["closed"], &info["input"]["vertices"]), (&true.into(), &4.into()));
    assert!(info["topology"]["volume"].as_f64().unwrap() > 0.16);
    let same = record(&["compare", text(&at("clean.ply")), text(&at("clean.ply")), "--samples", "1000"]);
    assert!(same["distance"]["max"].as_f64().unwrap() < 1e-12);
    let moved = fs::read_to_string(at("soup.obj")).unwrap().replace("v 0 0 1", "v 0 0 2");
    fs::write(at("moved.obj"), moved).unwrap();
    let apart = record(&["compare", text(&at("clean.ply")), text(&at("moved.obj")), "--samples", "1000"]);
    assert!((apart["distance"]["max"].as_f64().unwrap() - 1.0).abs() < 1e-9);
}

#[test]
fn bicubic_faces_keep_their_tolerance_and_are_smaller() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    carreau().args(["sample", "torus", "--resolution", "60", "-o", text(&at("t.ply"))]).assert().success();
    let bilinear = record(&["patch", text(&at("t.ply")), "-o", text(&at("a.step"))]);
    let json =
        record(&["patch", text(&at("t.ply")), "-o", text(&at("b.step")), "--fit", "bicubic", "--tolerance", "0.1%"]);
    let diagonal = record(&["info", text(&at("t.ply"))])["diagonal"].as_f64().unwrap();
    assert!(json["fit"]["deviation_max"].as_f64().unwrap() <= 0.001 * diagonal);
    assert!(json["fit"]["bicubic"].as_u64().unwrap() > 0);
    let size = |name: &str| fs::metadata(at(name)).unwrap().len();
    assert!(5 * size("b.step") <= size("a.step"), "{} against {}, {bilinear}", size("b.step"), size("a.step"));
}

#[test]
fn features_are_read_and_kept() {
    let (folder, model) = with_model("cube-cylinders", "m.ply");
    let list = folder.path().join("edges.txt");
    fs::write(&list, "# none of these exists\n0 1305\n").unwrap();
    carreau().args(["patch", text(&model), "--features", text(&list)]).assert().code(3).stderr(contains("0 1305"));
    fs::write(&list, "0 x\n").unwrap();
    carreau().args(["patch", text(&model), "--features", text(&list)]).assert().code(5).stderr(contains("line 1"));
}

/// A property of all vertices in an ASCII or binary PLY file, by way of an ASCII one.
fn property(file: &Path, name: &str) -> Vec<f64> {
    let ascii = file.with_extension("ascii.ply");
    carreau().args(["convert", text(file), "--ascii", "-o", text(&ascii)]).assert().success();
    let content = fs::read_to_string(ascii).unwrap();
    let (header, body) = content.split_once("end_header\n").unwrap();
    let count = header.lines().find_map(|l| l.strip_prefix("element vertex ")).unwrap().parse().unwrap();
    let column =
        header.lines().filter(|l| l.starts_with("property")).position(|l| l.ends_with(&format!(" {name}"))).unwrap();
    let number = |line: &str| line.split(' ').nth(column).unwrap().parse().unwrap();
    body.lines().take(count).map(number).collect()
}

#[test]
fn simplify_meets_what_is_asked_for_and_says_so() {
    let (folder, model) = with_model("torus", "m.ply");
    let at = |name: &str| folder.path().join(name);
    let out = at("s.ply");
    let before = record(&["info", text(&model)])["input"]["faces"].as_u64().unwrap();
    let run = |extra: &[&str]| {
        let args = [&["simplify", text(&model), "-o", text(&out)], extra].concat();
        record(&args)
    };
    let json = run(&["--triangles", "1500"]);
    let faces = json["output"]["faces"].as_u64().unwrap();
    assert!(faces.abs_diff(1500) <= 15 && faces < before, "{faces}");
    let q = &json["quality"];
    assert!(q["shape_min"].as_f64().unwrap() > 0.4 && q["length_in_half_two"].as_f64().unwrap() > 0.99);
    assert!(q["distance_max"].as_f64().unwrap() >= q["distance_rms"].as_f64().unwrap());
    assert!(property(&out, "size").iter().all(|h| *h > 0.0));

    let json = run(&["--distance", "1%"]);
    assert!(json["quality"]["distance_max"].as_f64().unwrap() <= 0.01);

    // The curvature across the tube is larger than that along it.
    let json = run(&["--triangles", "1500", "--anisotropic"]);
    assert_eq!(json["options"]["anisotropic"], true);
    assert!(property(&out, "stretch_x").iter().any(|w| w.abs() > 0.3));
    carreau().args(["simplify", text(&model), "--anisotropic", "--geometric"]).assert().code(2);

    // Sizes of one run are the upper bound of the next.
    carreau().args(["simplify", text(&model), "-o", text(&out), "--deviation", "10"]).assert().success();
    let fine = record(&["simplify", text(&out), "--deviation", "40", "--sizes", "size"]);
    let coarse = record(&["simplify", text(&out), "--deviation", "40"]);
    let faces = |json: &Value| json["output"]["faces"].as_u64().unwrap();
    assert!(faces(&fine) > 2 * faces(&coarse));
    carreau().args(["simplify", text(&out), "--sizes", "none"]).assert().code(2).stderr(contains("none"));
}

#[test]
fn enrich_refines_and_replays_for_any_number_of_threads() {
    let (folder, model) = with_model("torus", "m.ply");
    let at = |name: &str| folder.path().join(name);
    carreau()
        .args(["enrich", text(&model), "--deviation", "3", "--json", text(&at("r.json"))])
        .args(["-o", text(&at("a.ply")), "--threads", "1", "--picture", text(&at("a.png"))])
        .assert()
        .success();
    carreau()
        .args(["enrich", text(&model), "--options", text(&at("r.json")), "--threads", "2", "-o", text(&at("b.ply"))])
        .assert()
        .success();
    assert_eq!(fs::read(at("a.ply")).unwrap(), fs::read(at("b.ply")).unwrap());
    assert!(fs::read(at("a.png")).unwrap().starts_with(b"\x89PNG"));
    let faces = |file: &Path| record(&["info", text(file)])["input"]["faces"].as_u64().unwrap();
    assert!(faces(&at("a.ply")) > faces(&model));
    carreau().args(["enrich", text(&model), "--deviation", "90"]).assert().code(2).stderr(contains("deviation"));
    carreau().args(["enrich", text(&model), "--gradation", "1"]).assert().code(2).stderr(contains("gradation"));
}

#[test]
fn curvature_writes_properties_picture_and_record() {
    let (folder, model) = with_model("torus", "m.ply");
    let at = |name: &str| folder.path().join(name);
    let out = at("k.ply");
    let json = record(&["curvature", text(&model), "-o", text(&out), "--picture", text(&at("k.png"))]);
    assert!(fs::read(at("k.png")).unwrap().starts_with(b"\x89PNG"));
    assert_eq!(json["options"]["estimator"], "corrected");
    assert_eq!(json["options"]["feature_angle"], 25.0);
    assert_eq!(json["warnings"].as_array().unwrap().len(), 0);
    let (kmin, kmax) = (property(&out, "kmin"), property(&out, "kmax"));
    // The tube's radius is 0.4: 2.5 everywhere.
    assert!(kmax.iter().all(|k| (k - 2.5).abs() < 0.1) && kmin.iter().zip(&kmax).all(|(a, b)| a < b));
    assert!((json["quality"]["kmax"]["p50"].as_f64().unwrap() - 2.5).abs() < 0.05);
    let length = |d: &str| {
        let [x, y, z] = ["x", "y", "z"].map(|c| property(&out, &format!("{d}_{c}")));
        x.iter().zip(y).zip(z).map(|((x, y), z)| (x * x + y * y + z * z).sqrt()).collect::<Vec<_>>()
    };
    assert!(["dmin", "dmax"].iter().all(|d| length(d).iter().all(|l| (l - 1.0).abs() < 1e-9)));
    for name in ["k.vtu", "k.vtk"] {
        carreau().args(["curvature", text(&model), "-o", text(&at(name))]).assert().success();
        assert_eq!(record(&["info", text(&at(name))])["attributes"]["vertex"]["dmin"], "vector3", "{name}");
    }
}

#[test]
fn curvature_replays_and_refuses() {
    let (folder, model) = with_model("open-cylinder", "m.ply");
    let at = |name: &str| folder.path().join(name);
    let ball = ["curvature", text(&model), "--estimator", "normal-cycle-ball", "--radius", "5%"];
    carreau()
        .args(ball)
        .args(["--json", text(&at("r.json")), "--threads", "1", "-o", text(&at("a.ply"))])
        .assert()
        .success();
    carreau()
        .args(["curvature", text(&model), "--options", text(&at("r.json")), "--threads", "3", "-o", text(&at("b.ply"))])
        .assert()
        .success();
    assert_eq!(fs::read(at("a.ply")).unwrap(), fs::read(at("b.ply")).unwrap());
    let json: Value = serde_json::from_slice(&fs::read(at("r.json")).unwrap()).unwrap();
    assert!(json["warnings"][0].as_str().unwrap().contains("border"));
    carreau()
        .args(["curvature", text(&model), "--radius", "1%"])
        .assert()
        .code(2)
        .stderr(contains("normal-cycle-ball"));
    carreau().args(["curvature", text(&model), "--feature-angle", "181"]).assert().code(2);
    carreau().args(["curvature", text(&model), "--estimator", "magic"]).assert().code(2);
}

#[test]
fn segment_tells_faces_surfaces_and_boundaries() {
    let (folder, model) = with_model("bracket", "bracket.ply");
    let output = folder.path().join("regions.ply");
    let told = record(&["segment", text(&model), "-o", text(&output)]);
    let regions = told["regions"].as_array().unwrap();
    let of_kind = |kind: &str| regions.iter().filter(|r| r["primitive"]["type"] == kind).count();
    assert_eq!((of_kind("plane"), of_kind("cylinder"), regions.len()), (8, 5, 13));
    assert_eq!(told["chosen"]["basis"], "surfaces");
    let triangles: u64 = regions.iter().map(|r| r["triangles"].as_u64().unwrap()).sum();
    assert_eq!(told["input"]["faces"], triangles);

    // OBJ knows groups, one for each region.
    let obj = folder.path().join("regions.obj");
    carreau().args(["segment", text(&model), "-o", text(&obj)]).assert().success();
    let written = fs::read_to_string(&obj).unwrap();
    let mut groups: Vec<&str> = written.lines().filter(|line| line.starts_with("g ")).collect();
    groups.sort_unstable();
    groups.dedup();
    assert_eq!((groups.len(), groups.iter().filter(|g| g.ends_with("_cylinder")).count()), (13, 5));

    // The labels that were written, taken as given, lead to the same regions.
    let again = record(&["segment", text(&output), "--labels", "region", "--rectify", "none"]);
    assert_eq!(again["regions"], told["regions"]);
    let file = folder.path().join("labels.txt");
    let lines: String = (0..triangles).map(|t| format!("{}\n", t % 2)).collect();
    fs::write(&file, lines).unwrap();
    let halves = record(&["segment", text(&model), "--labels", text(&file), "--rectify", "none"]);
    assert_eq!(halves["chosen"]["basis"], "labels");

    // A record replays its run.
    let kept = folder.path().join("record.json");
    carreau().args(["segment", text(&model), "--preset", "paper", "--json", text(&kept)]).assert().success();
    let first: Value = serde_json::from_slice(&fs::read(&kept).unwrap()).unwrap();
    let replayed = record(&["segment", text(&model), "--options", text(&kept)]);
    assert_eq!(replayed["regions"], first["regions"]);
    assert_eq!(replayed["options"], first["options"]);

    for wrong in [["--labels", "nowhere"], ["--clusters", "0"], ["--merge-threshold", "much"]] {
        carreau().args(["segment", text(&model)]).args(wrong).assert().code(2);
    }
    fs::write(&file, "1 2 3").unwrap();
    carreau().args(["segment", text(&model), "--labels", text(&file)]).assert().code(5);
}

#[test]
fn polygons_are_fans_where_results_name_triangles() {
    let folder = TempDir::new().expect("a folder");
    let (dart, off, layout) =
        (folder.path().join("dart.off"), folder.path().join("out.off"), folder.path().join("l.json"));
    // Two darts, each with its reflex corner second: a fan from the first corner has a turned triangle.
    fs::write(&dart, "OFF 5 2 0\n2 -1 0\n.5 0 0\n2 1 0\n0 0 0\n-2 0 0\n4 0 1 2 3\n4 0 3 2 4\n").expect("written");
    record(&["segment", text(&dart), "-o", text(&off)]);
    let written = fs::read_to_string(&off).expect("read");
    let faces: Vec<&str> = written.lines().filter(|l| l.starts_with("3 ")).map(str::trim).collect();
    assert_eq!(faces.len(), 4, "{written}");
    for (face, expected) in faces.iter().zip(["3 0 1 2", "3 0 2 3", "3 0 3 2", "3 0 2 4"]) {
        assert!(face.starts_with(expected), "{written}");
    }
    record(&["patch", text(&dart), "--layout", text(&layout), "-o", text(&folder.path().join("p.off"))]);
}

#[test]
fn field_writes_frames_layout_picture_and_record() {
    let (folder, model) = with_model("wedge", "m.ply");
    let at = |name: &str| folder.path().join(name);
    let run = |more: &[&str]| {
        let all = [&["field", text(&model)], more].concat();
        record(&all)
    };
    let json =
        run(&["-o", text(&at("f.vtu")), "--layout", text(&at("f.json")), "--picture", text(&at("f.png")), "--classic"]);
    assert!(fs::read(at("f.png")).unwrap().starts_with(b"\x89PNG"));
    assert_eq!(json["poles"], serde_json::json!({ "sectors": 0, "inner": 0 }));
    // The acute edge of the wedge is what the classic field has no room for.
    assert!(json["classic"]["sectors"].as_u64().unwrap() > 0);
    assert!(json["quality"]["energy"].as_f64() <= json["quality"]["energy_orthogonal"].as_f64());
    let layout = layout(&at("f.json"));
    let count = |name: &str| layout[name].as_array().unwrap().len();
    assert_eq!(json["output"]["faces"], count("triangles"));
    assert_eq!(json["output"]["singularities"], count("singularities"));
    assert_eq!((count("u"), count("v")), (count("triangles"), count("triangles")));
    let written = record(&["info", text(&at("f.vtu"))]);
    assert_eq!(written["attributes"]["face"]["u"], "vector3");
    let classic = run(&["--pin", "none", "--orthogonal"]);
    assert_eq!(
        classic["poles"],
        serde_json::json!({ "sectors": json["classic"]["sectors"], "inner": json["classic"]["inner"] })
    );
    for wrong in [["--pin", "30"], ["--propagation", "far"], ["--lean", "90"], ["--feature-angle", "181"]] {
        carreau().args(["field", text(&model)]).args(wrong).assert().code(2);
    }
}

#[test]
fn motorcycle_writes_its_graph_in_every_form_and_replays() {
    let (folder, model) = with_model("bracket", "m.ply");
    let at = |name: &str| folder.path().join(name);
    let run = |more: &[&str]| carreau().args(["motorcycle", text(&model)]).args(more).assert().success();
    let (graph, file, png) = (at("g.json"), at("g.vtp"), at("g.png"));
    run(&[
        "--quads",
        "900",
        "--threads",
        "1",
        "--layout",
        text(&graph),
        "-o",
        text(&file),
        "--picture",
        text(&png),
        "--json",
        text(&at("r.json")),
    ]);
    let (found, json) = (layout(&graph), layout(&at("r.json")));
    let list = |name: &str| found[name].as_array().unwrap().clone();
    assert!(fs::read(&png).unwrap().starts_with(b"\x89PNG"));
    assert_eq!(json["patches"], list("patches").len());
    assert_eq!((&json["nodes"], &json["arcs"]), (&list("nodes").len().into(), &list("arcs").len().into()));
    let kind = |kind: &str| list("tracks").iter().filter(|t| t["kind"] == kind).count();
    assert_eq!(json["tracks"]["motorcycle"], kind("motorcycle"));
    assert!(kind("motorcycle") > 0 && json["regular"].as_u64() <= json["discs"].as_u64());
    // The file has the triangles, and an edge for every piece of a track or a feature.
    let info = record(&["info", text(&file)]);
    assert_eq!(info["topology"]["faces"], list("triangles").len());
    let pieces: usize = list("tracks").iter().map(|t| t["vertices"].as_array().unwrap().len() - 1).sum();
    assert_eq!(info["input"]["edges"], pieces + list("features").len());
    for track in list("tracks") {
        let (nodes, vertices) = (track["nodes"].as_array().unwrap(), track["vertices"].as_array().unwrap());
        for (node, vertex) in nodes.iter().zip([vertices.first(), vertices.last()]) {
            assert_eq!(Some(&found["nodes"][node.as_u64().unwrap() as usize]["vertex"]), vertex);
        }
    }
    run(&["--options", text(&at("r.json")), "--threads", "2", "--layout", text(&at("again.json"))]);
    assert_eq!(fs::read(&graph).unwrap(), fs::read(at("again.json")).unwrap());
    for wrong in [["--quads", "0"], ["--edge-length", "-1"], ["--feature-angle", "181"]] {
        carreau().args(["motorcycle", text(&model)]).args(wrong).assert().code(2);
    }
    fs::write(at("empty.obj"), "v 0 0 0\n").unwrap();
    carreau().args(["motorcycle", text(&at("empty.obj"))]).assert().code(3).stderr(contains("empty.obj"));
}

#[test]
fn quad_writes_quads_alone_and_replays() {
    let (folder, model) = with_model("bracket", "m.ply");
    let at = |name: &str| folder.path().join(name);
    let run = |more: &[&str]| carreau().args(["quad", text(&model)]).args(more).assert().success();
    run(&["--quads", "900", "-o", text(&at("q.mesh")), "--json", text(&at("r.json")), "--threads", "1"]);
    let json = layout(&at("r.json"));
    let info = record(&["info", text(&at("q.mesh"))]);
    assert_eq!(info["topology"]["quads"], json["quads"]);
    assert_eq!(info["topology"]["closed"], true);
    assert!(info["input"]["edges"].as_u64().unwrap() > 0);
    assert_eq!(json["quality"]["inverted"], 0);
    let sum: u64 = json["rungs"].as_array().unwrap().iter().map(|r| r["quads"].as_u64().unwrap()).sum();
    assert_eq!(json["quads"], sum);
    run(&["--options", text(&at("r.json")), "--threads", "2", "-o", text(&at("again.mesh"))]);
    assert_eq!(fs::read(at("q.mesh")).unwrap(), fs::read(at("again.mesh")).unwrap());
    for wrong in [["--quads", "0"], ["--rung", "9"], ["--edge-length", "-1"]] {
        carreau().args(["quad", text(&model)]).args(wrong).assert().code(2);
    }
}

/// A fork of three tubes.
const FORK: &str = "# D:3 NV:4 NE:3\nv 0 0 0 1\nv 0 0 6 1\nv 5 0 -5 .8\nv -5 1 -5 .7\ne 0 1\ne 0 2\ne 0 3\n";

#[test]
fn hex_writes_cells_boundary_picture_and_record() {
    let folder = TempDir::new().unwrap();
    let (graph, png) = (folder.path().join("fork.cgr"), folder.path().join("fork.png"));
    fs::write(&graph, FORK).unwrap();
    for extension in ["mesh", "vtu", "vtk", "msh"] {
        let out = folder.path().join(format!("fork.{extension}"));
        let rec = record(&["hex", text(&graph), "-o", text(&out), "--picture", text(&png)]);
        assert_eq!(rec["certified"], true);
        assert_eq!(rec["uncertified"].as_array().map(Vec::len), Some(0));
        assert!(rec["scaled_jacobian_min"].as_f64() > Some(0.4), "{rec}");
        let info = record(&["info", text(&out)]);
        assert_eq!(info["cells"]["hexahedra"], rec["hexes"]);
        assert_eq!(info["hexahedra"]["conforming"], true);
        assert_eq!(info["hexahedra"]["certified"], true);
        assert_eq!(info["hexahedra"]["irregular_edges"], rec["irregular_edges"]);
        let boundary = folder.path().join(format!("skin-{extension}.ply"));
        carreau().args(["convert", "--boundary", text(&out), "-o", text(&boundary)]).assert().success();
        assert_eq!(record(&["info", text(&boundary)])["topology"]["genus"], 0);
    }
    assert!(fs::read(&png).unwrap().starts_with(b"\x89PNG"));
}

#[test]
fn hex_base_mesh_has_the_counts_of_the_paper_and_replays() {
    let folder = TempDir::new().unwrap();
    let (graph, out) = (folder.path().join("fork.cgr"), folder.path().join("fork.mesh"));
    fs::write(&graph, FORK).unwrap();
    let (rec, again) = (folder.path().join("rec.json"), folder.path().join("again.mesh"));
    let line = ["hex", text(&graph), "--stage", "base", "--padding", "sides", "--refine-across", "1"];
    carreau().args(line).args(["-o", text(&out), "--json", text(&rec)]).assert().success();
    assert_eq!(layout(&rec)["hexes"], 12 * 3 * 4);
    carreau().args(["hex", text(&graph), "--options", text(&rec), "-o", text(&again)]).assert().success();
    assert_eq!(fs::read(&out).unwrap(), fs::read(&again).unwrap());
}

#[test]
fn a_surface_gets_a_skeleton_and_hexes() {
    let (folder, model) = with_model("torus", "m.ply");
    let at = |name: &str| folder.path().join(name);
    let found = record(&["skeleton", text(&model), "-o", text(&at("s.cgr")), "--picture", text(&at("s.png"))]);
    assert_eq!((&found["cycles"], &found["extremities"]), (&serde_json::json!(1), &serde_json::json!(0)));
    assert!(fs::read(at("s.png")).unwrap().starts_with(b"\x89PNG"));
    let rec =
        record(&["hex", text(&model), "--skeleton", text(&at("s.cgr")), "--hexes", "800", "-o", text(&at("h.mesh"))]);
    assert_eq!(rec["certified"], true);
    assert!(rec["hexes"].as_u64() <= Some(800) && rec["distance_max"].as_f64().is_some());
    let boundary = at("b.ply");
    carreau().args(["convert", "--boundary", text(&at("h.mesh")), "-o", text(&boundary)]).assert().success();
    assert_eq!(record(&["info", text(&boundary)])["topology"]["genus"], 1);
    // A tree format cannot hold a cycle.
    carreau().args(["skeleton", text(&model), "-o", text(&at("s.swc"))]).assert().code(3);
}

#[test]
fn hex_refuses_what_is_no_skeleton() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("bad.cgr");
    let out = folder.path().join("bad.mesh");
    for (graph, code, says) in [
        ("v 0 0 0 1\nv 1 0 0 1\ne 0 7\n", 3, "no node 7"),
        ("v 0 0 0 1\nv nan 0 0 1\ne 0 1\n", 3, "not a finite number"),
        ("v 0 0 0 1\nv x 0 0 1\ne 0 1\n", 5, "a number is expected"),
        ("", 3, "the skeleton is empty"),
    ] {
        fs::write(&path, graph).unwrap();
        let line = ["hex", text(&path), "-o", text(&out)];
        carreau().args(line).assert().code(code).stderr(contains(says).and(contains("bad.cgr")));
        assert!(!out.exists());
    }
    let (_folder, surface) = with_model("torus", "m.ply");
    let line = ["hex", text(&path), "--skeleton", text(&surface)];
    carreau().args(line).assert().code(2).stderr(contains("belongs to a surface"));
}

#[test]
fn a_log_that_no_terminal_shows_has_no_colours() {
    let folder = TempDir::new().unwrap();
    let out = carreau().args(["sample", "bracket", "-v", "-o", text(&folder.path().join("m.ply"))]).output().unwrap();
    assert!(!out.stderr.is_empty() && !out.stderr.contains(&0x1b), "{}", String::from_utf8_lossy(&out.stderr));
}
