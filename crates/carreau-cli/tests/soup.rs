//! Files as people have them: every verb gives what it gives for the clean surface, and says what it did in one line.

#![allow(clippy::unwrap_used)] // a test fails by panicking

mod common;

use carreau::mesh::{Polygons, RawMesh, SurfaceMesh};
use carreau::{Context, DVec3, io, sample};
use common::{carreau, record, text};
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A surface as other programs would write it.
struct Variant {
    name: &'static str,
    mesh: SurfaceMesh,
    extension: &'static str,
    /// What the line says.
    says: &'static str,
    options: &'static [&'static str],
}

fn triangles(mesh: &SurfaceMesh) -> Vec<[u32; 3]> {
    mesh.faces().fan().0
}

fn with(points: Vec<DVec3>, faces: &[[u32; 3]]) -> SurfaceMesh {
    SurfaceMesh::new(points, Polygons::from_triangles(faces)).unwrap()
}

/// Two in one, nothing shared.
fn together(a: &SurfaceMesh, b: &SurfaceMesh) -> SurfaceMesh {
    let base = a.vertex_count() as u32;
    let second = triangles(b).into_iter().map(|t| t.map(|v| v + base));
    with([a.points(), b.points()].concat(), &triangles(a).into_iter().chain(second).collect::<Vec<_>>())
}

/// Vertices of their own wherever faces meet at more than 30°, as in files for rendering.
fn split(mesh: &SurfaceMesh) -> SurfaceMesh {
    let (mut points, mut faces) = (Vec::new(), Vec::new());
    let mut known: Vec<Vec<(DVec3, u32)>> = vec![Vec::new(); mesh.vertex_count()];
    for t in triangles(mesh) {
        let [a, b, c] = t.map(|v| mesh.points()[v as usize]);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        faces.push(t.map(|v| {
            let list = &mut known[v as usize];
            if let Some((_, id)) = list.iter().find(|(other, _)| other.dot(normal) > 0.866) {
                return *id;
            }
            points.push(mesh.points()[v as usize]);
            list.push((normal, points.len() as u32 - 1));
            points.len() as u32 - 1
        }));
    }
    with(points, &faces)
}

fn variants(clean: &SurfaceMesh) -> Vec<Variant> {
    let all = triangles(clean);
    let soup = with(
        all.iter().flatten().map(|&v| clean.points()[v as usize]).collect(),
        &(0..all.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect::<Vec<_>>(),
    );
    let turned = with(clean.points().to_vec(), &all.iter().map(|&[a, b, c]| [a, c, b]).collect::<Vec<_>>());
    let (low, high) = clean.bounds();
    let size = clean.diagonal();
    let speck = |k: f64| {
        let at = high + 0.1 * k * (high - low);
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|d| at + 2e-3 * size * d);
        with(corners.to_vec(), &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    };
    let specks = together(&together(clean, &speck(1.0)), &speck(2.0));
    let variant = |name, mesh, says, options| Variant { name, mesh, extension: "obj", says, options };
    vec![
        variant("soup", soup, "welded", &[]),
        variant("split", split(clean), "welded", &[]),
        Variant { extension: "glb", ..variant("glb", split(clean), "welded", &[]) },
        variant("twice", together(clean, clean), "duplicate faces", &[]),
        variant("turned", turned, "turned 1 component that was inside out", &[]),
        variant("specks", specks, "left out 2 pieces of 8 faces", &["--keep", "largest"]),
    ]
}

fn written(folder: &Path, name: &str, mesh: &SurfaceMesh) -> PathBuf {
    written_as(folder, name, "obj", mesh)
}

fn written_as(folder: &Path, name: &str, extension: &str, mesh: &SurfaceMesh) -> PathBuf {
    let file = folder.join(format!("{name}.{extension}"));
    io::write(&file, &RawMesh::from(mesh.clone()), &io::WriteOptions::default()).unwrap();
    file
}

/// A run's output and what it said.
fn run(verb: &[&str], input: &Path, output: &Path, options: &[&str]) -> (Vec<u8>, String) {
    let done =
        carreau().arg(verb[0]).arg(input).arg("-o").arg(output).args(&verb[1..]).args(options).assert().success();
    let said = String::from_utf8(done.get_output().stderr.clone()).unwrap();
    (fs::read(output).unwrap(), said)
}

/// The surface with its vertices in the order of their first use, as welding numbers them, at places that every format holds.
fn in_order_of_use(mesh: &SurfaceMesh) -> SurfaceMesh {
    let (mut points, mut number) = (Vec::new(), vec![u32::MAX; mesh.vertex_count()]);
    let faces = triangles(mesh).into_iter().map(|t| {
        t.map(|v| {
            if number[v as usize] == u32::MAX {
                number[v as usize] = points.len() as u32;
                points.push(mesh.points()[v as usize].as_vec3().as_dvec3());
            }
            number[v as usize]
        })
    });
    let faces: Vec<[u32; 3]> = faces.collect();
    with(points, &faces)
}

#[test]
fn every_verb_gives_what_it_gives_for_the_clean_surface() {
    let folder = TempDir::new().unwrap();
    let context = Context::new();
    let cases: [(&str, u32, &[&[&str]]); 4] = [
        ("bracket", 20, &[&["patch"], &["simplify"], &["enrich", "--deviation", "20"]]),
        ("wedge", 8, &[&["quad", "--quads", "60"], &["field"], &["motorcycle"]]),
        ("tube-tree", 50, &[&["skeleton"], &["hex"]]),
        ("cylinder", 16, &[&["quad", "--quads", "80"], &["skeleton"], &["hex"]]),
    ];
    for (model, resolution, verbs) in cases {
        let clean = in_order_of_use(&sample::make(model, Some(resolution), &context).unwrap());
        let input = written(folder.path(), model, &clean);
        for verb in verbs {
            let extension = match verb[0] {
                "skeleton" => "cgr",
                "hex" => "mesh",
                "field" => "vtu",
                "motorcycle" => "vtp",
                _ => "obj",
            };
            let output = folder.path().join(format!("out.{extension}"));
            let (want, said) = run(verb, &input, &output, &[]);
            assert!(!said.contains("prepared"), "{said}");
            for Variant { name, mesh, extension, says, options } in variants(&clean) {
                let input = written_as(folder.path(), name, extension, &mesh);
                let (found, said) = run(verb, &input, &output, options);
                let lines: Vec<&str> = said.lines().filter(|l| l.contains("prepared the surface")).collect();
                assert!(lines.len() == 1 && lines[0].contains(says), "{model} {verb:?} {name}: {said}");
                assert!(found == want, "{model} {verb:?} {name}: the bytes differ");
            }
        }
    }
}

/// Labels, boundaries and curvatures of a soup are those of the file's own faces and vertices.
#[test]
fn results_refer_to_the_file() {
    let folder = TempDir::new().unwrap();
    let clean = in_order_of_use(&sample::make("bracket", Some(20), &Context::new()).unwrap());
    let soup = &variants(&clean)[0].mesh;
    let (a, b) = (written(folder.path(), "clean", &clean), written(folder.path(), "soup", soup));
    let out = folder.path().join("out.ply");
    let regions = |input: &Path| {
        let r = record(&["segment", text(input), "-o", text(&out)]);
        let mesh = io::read(&out).unwrap();
        let carreau::mesh::Column::Label(labels) = mesh.attributes.face["region"].clone() else { panic!("labels") };
        (labels, mesh, r)
    };
    let ((want, _, clean_record), (found, mesh, soup_record)) = (regions(&a), regions(&b));
    assert_eq!(found, want);
    assert_eq!((mesh.points.len(), mesh.points), (soup.vertex_count(), soup.points().to_vec()));
    assert_eq!(clean_record["prepared"]["welded_vertices"], 0);
    let welded = soup.vertex_count() - clean.vertex_count();
    assert_eq!(soup_record["prepared"]["welded_vertices"], welded);
    let at = |record: &serde_json::Value, points: &[DVec3]| -> Vec<Vec<[u64; 3]>> {
        let ids = |b: &serde_json::Value| {
            let ids = b["vertices"].as_array().unwrap().iter().map(|v| v.as_u64().unwrap() as usize);
            ids.map(|v| points[v].to_array().map(f64::to_bits)).collect()
        };
        record["boundaries"].as_array().unwrap().iter().map(ids).collect()
    };
    assert_eq!(at(&clean_record, clean.points()), at(&soup_record, soup.points()));
    // A layout names every triangle of the file once, in its sense.
    let layout = folder.path().join("layout.json");
    for variant in variants(&clean) {
        let input = written(folder.path(), "variant", &variant.mesh);
        record(&["patch", text(&input), "--layout", text(&layout)]);
        let layout: serde_json::Value = serde_json::from_slice(&fs::read(&layout).unwrap()).unwrap();
        let of = |v: &serde_json::Value| v.as_array().unwrap().iter().map(|t| t.as_u64().unwrap()).collect::<Vec<_>>();
        let patches = layout["patches"].as_array().unwrap();
        let mut all = of(&layout["leftover"]);
        patches.iter().for_each(|p| all.extend(of(&p["triangles"])));
        all.sort_unstable();
        assert_eq!(patches.is_empty(), variant.name == "soup", "{}", variant.name);
        // Every cell has the vertices that its two triangles have in the file, in their sense.
        let file = triangles(&variant.mesh);
        for patch in patches {
            let (vertices, ids, cols) =
                (of(&patch["vertices"]), of(&patch["triangles"]), patch["cols"].as_u64().unwrap());
            for (k, pair) in (0u64..).zip(ids.chunks(2)) {
                let (r, c) = (k / cols, k % cols);
                let at = |r: u64, c: u64| vertices[(r * (cols + 1) + c) as usize] as u32;
                let corners = [at(r, c), at(r, c + 1), at(r + 1, c + 1), at(r + 1, c)];
                let is_edge = |t: &[u32; 3], a: u32, b: u32| (0..3).any(|k| t[k] == a && t[(k + 1) % 3] == b);
                let cell = [pair[0], pair[1]].map(|t| file[t as usize]);
                for k in 0..4 {
                    let (a, b) = (corners[k], corners[(k + 1) % 4]);
                    assert!(cell.iter().any(|t| is_edge(t, a, b)), "{}: {corners:?} {cell:?}", variant.name);
                }
            }
        }
        assert_eq!(all, (0..variant.mesh.face_count() as u64).collect::<Vec<_>>(), "{}", variant.name);
    }
}

/// Quads that share two sides have fans that lie on each other: the model is as closed as the quads are, and with a layout, which
/// names every triangle of the file, it has them all.
#[test]
fn quads_whose_fans_fold_are_a_solid() {
    let folder = TempDir::new().unwrap();
    let [file, step, layout] = ["folded.obj", "out.step", "layout.json"].map(|name| folder.path().join(name));
    // A unit cube; its top is two quads that share both sides at the vertex beside its diagonal.
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\nv .3 .6 1\n";
    let faces = "f 1 3 4 2\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\nf 5 6 8 9\nf 5 9 8 7\n";
    fs::write(&file, format!("{corners}{faces}")).unwrap();
    let r = record(&["patch", text(&file), "-o", text(&step)]);
    assert_eq!((r["prepared"]["folded_faces"].as_u64(), r["faces"].as_u64()), (Some(2), Some(6)), "{r}");
    assert!(r["warnings"].to_string().contains("left out 2 faces folded onto each other"), "{r}");
    assert_eq!(fs::read_to_string(&step).unwrap().matches("MANIFOLD_SOLID_BREP").count(), 1);
    let r = record(&["patch", text(&file), "-o", text(&step), "--layout", text(&layout)]);
    assert!(r["warnings"].to_string().contains("folded onto others are taken as they are there"), "{r}");
    let told: serde_json::Value = serde_json::from_slice(&fs::read(&layout).unwrap()).unwrap();
    let in_patches = |p: &serde_json::Value| p["triangles"].as_array().unwrap().len();
    let patches: usize = told["patches"].as_array().unwrap().iter().map(in_patches).sum();
    assert_eq!(patches + told["leftover"].as_array().unwrap().len(), 14);
}

#[test]
fn surfaces_are_taken_as_they_are_where_that_is_asked_for() {
    let folder = TempDir::new().unwrap();
    let clean = in_order_of_use(&sample::make("bracket", Some(20), &Context::new()).unwrap());
    let soup = written(folder.path(), "soup", &variants(&clean)[0].mesh);
    let r = record(&["patch", text(&soup), "--as-is"]);
    assert_eq!((r["patches"].as_u64(), r["prepared"]["as_is"].as_bool()), (Some(0), Some(true)));
    assert!(r["warnings"].to_string().contains("coincident vertices: "));
    let file = folder.path().join("run.json");
    fs::write(&file, r.to_string()).unwrap();
    let again = record(&["patch", text(&soup), "--options", text(&file)]);
    assert_eq!(again["options"], r["options"]);
    assert_eq!(again["patches"], 0);
}
