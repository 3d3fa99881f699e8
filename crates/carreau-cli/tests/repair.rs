//! `repair` and what `info` says of it: bodies in contact, pieces, holes, walls.

#![allow(clippy::unwrap_used)] // a test fails by panicking

mod common;

use carreau::mesh::{Polygons, RawMesh, SurfaceMesh};
use carreau::{Context, DVec3, io, sample};
use common::{carreau, record, text};
use serde_json::Value;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A box between two corners as a body of an ASCII STL file.
fn stl_box(name: &str, low: [f64; 3], high: [f64; 3]) -> String {
    let at = |k: usize| [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { high[axis] } else { low[axis] });
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut out = format!("solid {name}\n");
    for t in quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]) {
        out += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in t.map(at) {
            writeln!(out, "vertex {x} {y} {z}").unwrap();
        }
        out += "endloop\nendfacet\n";
    }
    out + &format!("endsolid {name}\n")
}

fn topology(file: &Path) -> Value {
    record(&["info", text(file)])["topology"].clone()
}

fn written(file: PathBuf, points: Vec<DVec3>, faces: &[[u32; 3]]) -> PathBuf {
    let mesh = SurfaceMesh::new(points, Polygons::from_triangles(faces)).unwrap();
    io::write(&file, &RawMesh::from(mesh), &io::WriteOptions::default()).unwrap();
    file
}

#[test]
fn bodies_in_contact_are_closed_and_keep_their_names() {
    let folder = TempDir::new().unwrap();
    let (input, output) = (folder.path().join("two.stl"), folder.path().join("two.obj"));
    let (low, high) = (stl_box("housing", [0.0; 3], [4.0, 4.0, 2.0]), stl_box("lid", [0.0, 0.0, 2.0], [4.0, 4.0, 3.0]));
    fs::write(&input, low + &high).unwrap();
    let done = record(&["repair", text(&input), "-o", text(&output)]);
    assert_eq!(done["repair"]["after"]["closed"], true);
    let found = topology(&output);
    assert_eq!((found["closed"].as_bool(), found["components"].as_u64()), (Some(true), Some(2)));
    assert!((found["volume"].as_f64().unwrap() - 48.0).abs() < 1e-9 && found["vertices"] == 16, "{found}");
    let text = fs::read_to_string(&output).unwrap();
    assert!(text.contains("housing") && text.contains("lid"), "{text}");
}

#[test]
fn holes_are_filled_up_to_a_size_and_pieces_left_out() {
    let folder = TempDir::new().unwrap();
    let ball = sample::make("icosphere", Some(20), &Context::new()).unwrap();
    let all = ball.faces().fan().0;
    let place = |t: &[u32; 3]| t.iter().map(|&v| ball.points()[v as usize]).sum::<DVec3>() / 3.0;
    // A large hole at the top, a small one at the bottom, and a speck.
    let mut faces: Vec<[u32; 3]> =
        all.iter().filter(|t| (-0.97..0.7).contains(&(place(t).z / place(t).length()))).copied().collect();
    let (holed, base) = (faces.len(), ball.vertex_count() as u32);
    let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|d| DVec3::splat(2.0) + 0.02 * d);
    faces.extend([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]].map(|t| t.map(|v| v + base)));
    let input = written(folder.path().join("ball.obj"), [ball.points(), &corners].concat(), &faces);
    let output = folder.path().join("out.obj");
    let done = record(&["repair", text(&input), "-o", text(&output), "--fill-holes", "--keep", "largest"]);
    let filled = done["filled"].as_array().unwrap();
    assert_eq!((filled.len(), &done["left_out"]["faces"]), (2, &Value::from(4)));
    assert_eq!(filled[0]["faces"][0], holed);
    let found = topology(&output);
    assert_eq!((found["closed"].as_bool(), found["genus"].as_u64()), (Some(true), Some(0)));
    let warnings = done["warnings"].to_string();
    assert!(warnings.contains("was filled by the faces") && !warnings.contains("left\""), "{warnings}");
    assert!(!warnings.contains("meet others") && done["filled_intersections"]["pairs"] == 0, "{warnings}");
    // Only the small one.
    let small = filled.iter().map(|hole| hole["edges"].as_u64().unwrap()).min().unwrap();
    let done = record(&["repair", text(&input), "-o", text(&output), "--fill-holes", &small.to_string()]);
    assert_eq!(done["filled"].as_array().unwrap().len(), 1);
    assert!(done["warnings"].to_string().contains("1 boundary loop is left"), "{}", done["warnings"]);
    let found = record(&["info", text(&input), "--walls", "3", "--gaps", "0.001"]);
    assert!(found["walls"]["faces"].as_u64().unwrap() > 300 && found["gaps"]["faces"] == 0, "{}", found["walls"]);
    let least = found["walls"]["least"].as_f64().unwrap();
    assert!((0.5..2.0).contains(&least), "{least}");
}

#[test]
fn fills_that_meet_other_faces_are_told() {
    let folder = TempDir::new().unwrap();
    let corners = [DVec3::ZERO, DVec3::X, DVec3::ONE - DVec3::Z, DVec3::Y].to_vec();
    let plate = written(folder.path().join("plate.obj"), corners, &[[0, 1, 2], [0, 2, 3]]);
    let done = record(&["repair", text(&plate), "-o", text(&folder.path().join("out.obj")), "--fill-holes"]);
    assert_eq!(done["filled"].as_array().unwrap().len(), 1);
    assert!(done["filled_intersections"]["pairs"].as_u64().unwrap() > 0, "{}", done["filled_intersections"]);
    assert!(done["warnings"].to_string().contains("faces that fill holes meet others: "), "{}", done["warnings"]);
}

/// Files that STL programs write make no noise, and a result that is larger than its input is explained.
#[test]
fn warnings_are_few_and_say_why() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    let (part, out) = (at("part.stl"), at("out.ply"));
    carreau().args(["sample", "bracket", "--resolution", "8", "-q", "-o", text(&part)]).assert().success();
    for verb in ["segment", "field", "patch"] {
        let done = record(&[verb, text(&part), "-o", text(&out)]);
        assert!(!done["warnings"].to_string().contains("noise"), "{verb}: {}", done["warnings"]);
    }
    let done = record(&["simplify", text(&part), "-o", text(&out), "--deviation", "10"]);
    let warnings = done["warnings"].to_string();
    assert!(warnings.contains("more than the 320 before, because"), "{warnings}");
}
