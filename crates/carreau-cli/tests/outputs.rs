//! What cannot be written is refused before the work begins: format, kind of result, folder, clashing names.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::print_stderr)] // a test fails by panicking

mod common;

use common::{carreau, text};
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// Every verb with an output, and an extension of each kind that does not fit it.
const VERBS: &[(&str, &[&str])] = &[
    ("convert", &["step", "cgr", "png", "xyz"]),
    ("repair", &["step", "cgr", "xyz"]),
    ("curvature", &["step", "cgr", "xyz"]),
    ("segment", &["step", "iges", "cgr", "xyz"]),
    ("enrich", &["step", "cgr", "xyz"]),
    ("simplify", &["igs", "cgr", "xyz"]),
    ("patch", &["cgr", "xyz"]),
    ("field", &["step", "cgr", "xyz"]),
    ("motorcycle", &["step", "cgr", "xyz"]),
    ("quad", &["step", "cgr", "xyz"]),
    ("skeleton", &["stl", "step", "xyz"]),
    ("hex", &["stl", "obj", "ply", "off", "glb", "3mf", "vtp", "step", "cgr", "xyz"]),
    ("view", &["ply", "png", "xyz"]),
];

struct Desk {
    folder: TempDir,
    /// A file that no reader accepts: whoever reads it before the check fails for another reason.
    input: PathBuf,
}

impl Desk {
    fn new() -> Self {
        let folder = TempDir::new().unwrap();
        let input = folder.path().join("part.ply");
        fs::write(&input, "this is no mesh").unwrap();
        Desk { folder, input }
    }

    fn at(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Runs a verb that must be refused with one of these codes, for a reason that names the word; nothing may appear.
    fn refused(&self, verb: &str, more: &[&str], codes: &[i32], word: &str) -> String {
        let before = fs::read_dir(self.folder.path()).unwrap().count();
        let out = carreau().arg(verb).arg(&self.input).args(more).output().unwrap();
        let told = String::from_utf8_lossy(&out.stderr).into_owned();
        assert!(codes.contains(&out.status.code().unwrap()), "{verb} {more:?}: {:?} {told}", out.status);
        assert!(told.contains(word), "{verb} {more:?}: '{word}' is not in: {told}");
        assert!(!told.contains("no mesh") && !told.contains("header"), "the input was read before: {told}");
        assert_eq!(fs::read_dir(self.folder.path()).unwrap().count(), before, "{verb} {more:?} left something");
        told
    }
}

#[test]
fn formats_and_kinds_that_do_not_fit() {
    let desk = Desk::new();
    for (verb, extensions) in VERBS {
        for extension in *extensions {
            let output = desk.at(&format!("out.{extension}"));
            desk.refused(verb, &["-o", text(&output)], &[2, 5], &format!("out.{extension}"));
        }
    }
    let told = desk.refused("segment", &["-o", text(&desk.at("out.step"))], &[5], "carreau patch");
    assert!(told.contains("carreau cad"), "{told}");
}

#[test]
fn places_that_cannot_be_written_to() {
    let desk = Desk::new();
    for (verb, _) in VERBS {
        let fit = match *verb {
            "skeleton" => "cgr",
            "hex" => "vtu",
            "view" => "html",
            _ => "ply",
        };
        let missing = desk.at("nowhere").join(format!("out.{fit}"));
        desk.refused(verb, &["-o", text(&missing)], &[5], "there is no folder");
        let folder = TempDir::with_suffix_in(format!(".{fit}"), desk.folder.path()).unwrap();
        desk.refused(verb, &["-o", text(folder.path())], &[5], "folder");
        let good = desk.at(&format!("out.{fit}"));
        for (option, name) in [("--json", "r.json"), ("--picture", "p.png"), ("--report", "p.html")] {
            let missing = desk.at("nowhere").join(name);
            desk.refused(verb, &["-o", text(&good), option, text(&missing)], &[5], "there is no folder");
        }
    }
    // The input of a user who has protected it, say.
    let kept = desk.at("kept.ply");
    fs::write(&kept, "mine").unwrap();
    let mut rights = fs::metadata(&kept).unwrap().permissions();
    rights.set_readonly(true);
    fs::set_permissions(&kept, rights).unwrap();
    for (verb, option) in [("convert", "-o"), ("info", "--json")] {
        desk.refused(verb, &[option, text(&kept)], &[5], "write-protected");
    }
    assert_eq!(fs::read_to_string(&kept).unwrap(), "mine");
    carreau().args(["demo", "-o", text(&kept)]).assert().code(5).stderr(predicates::str::contains("this is a file"));
    for verb in ["patch", "field", "motorcycle"] {
        desk.refused(verb, &["--layout", text(&desk.at("nowhere").join("l.json"))], &[5], "there is no folder");
    }
    for (option, name) in [("--picture", "p.jpg"), ("--report", "p.txt")] {
        desk.refused("info", &[option, text(&desk.at(name))], &[5], name);
    }
}

#[test]
fn names_that_clash() {
    let desk = Desk::new();
    let [same, input] = [desk.at("same.ply"), desk.input.clone()];
    let two = &["-o", text(&same), "--json", text(&same)];
    desk.refused("segment", two, &[2], "name the same file");
    // A result may replace its input, a record may not.
    desk.refused("info", &["--json", text(&input)], &[2], "would replace an input");
    let vtu = desk.at("part.vtu");
    fs::write(&vtu, "this is no mesh").unwrap();
    let out = carreau().args(["hex", text(&vtu), "-o", text(&vtu)]).assert().code(2).get_output().clone();
    assert!(String::from_utf8_lossy(&out.stderr).contains("would replace an input"));
    let dotted = desk.folder.path().join(".").join("part.ply");
    desk.refused("compare", &[text(&input), "--json", text(&dotted)], &[2], "would replace an input");
}

#[test]
fn files_that_are_not_read_say_what_to_do() {
    let folder = TempDir::new().unwrap();
    for (name, word) in [
        ("a.step", "mesh it first"),
        ("a.igs", "mesh it first"),
        ("a.inp", "meshio"),
        ("a.bdf", "meshio"),
        ("a.stl.gz", "unpack it first"),
        ("a.zip", "unpack it first"),
        ("a.fbx", "export it"),
        ("a.xyz", "points without faces"),
        ("a.unknown", "known are"),
    ] {
        let file = folder.path().join(name);
        fs::write(&file, "x").unwrap();
        let out = carreau().args(["info", text(&file)]).assert().code(5).get_output().clone();
        let told = String::from_utf8_lossy(&out.stderr).into_owned();
        assert!(told.contains(word) && told.contains(name), "{told}");
    }
}

/// A special file takes any content.
#[test]
#[cfg(unix)]
fn devices_are_written_to() {
    let folder = TempDir::new().unwrap();
    let model = folder.path().join("m.ply");
    carreau()
        .args(["sample", "torus", "-o", text(&model), "--picture", "/dev/null", "--json", "/dev/null"])
        .assert()
        .success();
    assert!(Path::new("/dev/null").exists());
}
