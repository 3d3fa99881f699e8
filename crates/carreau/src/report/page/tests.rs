//! What a page holds, read back as the viewer does.

use super::container::tests::{decoded, inflated};
use super::*;
use crate::context::Context;
use crate::field::{FieldOptions, field};
use crate::mesh::{Cells, Column, CurveNet, Polygons, RawMesh, SurfaceMesh};
use crate::sample;
use glam::DVec3;
use serde_json::json;

/// The text of a script element of a page.
fn element<'a>(html: &'a str, id: &str) -> &'a str {
    let open = format!("id=\"{id}\">");
    let from = html.find(&open).unwrap() + open.len();
    &html[from..from + html[from..].find("</script>").unwrap()]
}

/// Head and arrays of a page.
fn read(html: &str) -> (Value, Vec<u8>) {
    let head: Value = serde_json::from_str(element(html, "carreau-head")).unwrap();
    let arrays = inflated(element(html, "carreau-data"));
    assert_eq!(head["bytes"], arrays.len());
    (head, arrays)
}

fn bits(slot: &Value, arrays: &[u8]) -> Vec<u32> {
    let number = |key: &str| slot[key].as_u64().unwrap() as usize;
    decoded(arrays, number("at"), number("count"), number("stride"))
}

fn reals(slot: &Value, arrays: &[u8]) -> Vec<f64> {
    bits(slot, arrays).into_iter().map(|b| f64::from(f32::from_bits(b))).collect()
}

/// The points of a scene, in the unit of the file.
fn points(scene: &Value, arrays: &[u8]) -> Vec<DVec3> {
    let scale = scene["scale"].as_f64().unwrap();
    let centre: [f64; 3] = serde_json::from_value(scene["centre"].clone()).unwrap();
    let local = reals(&scene["points"], arrays);
    local.chunks_exact(3).map(|p| DVec3::from_slice(p) * scale + DVec3::from(centre)).collect()
}

fn layer<'a>(scene: &'a Value, name: &str) -> &'a Value {
    scene["layers"].as_array().unwrap().iter().find(|l| l["name"] == name).unwrap()
}

fn page_of(scene: Scene) -> String {
    Page::new("test").scene(scene).html().unwrap()
}

#[test]
fn a_mesh_comes_back_with_its_columns() {
    let mut mesh = RawMesh::from(sample::make("cube-cylinders", None, &Context::new()).unwrap());
    // Far from the origin and small: the centre keeps the digits.
    mesh.points.iter_mut().for_each(|p| *p = *p * 1e-3 + DVec3::new(5e5, -7e5, 1e6));
    let height: Vec<f64> = mesh.points.iter().map(|p| p.z).collect();
    mesh.attributes.vertex.insert("height".into(), Column::Scalar(height.clone()));
    let (head, arrays) = read(&page_of(Scene::of_mesh("model", &mesh).unwrap().role(Role::After)));
    let scene = &head["scenes"][0];
    assert_eq!((&scene["name"], &scene["role"], &scene["show"]), (&"model".into(), &"after".into(), &"truth".into()));
    assert_eq!(bits(&scene["faces"]["corners"], &arrays), mesh.faces.corners());
    assert_eq!(scene["faces"]["size"], 3);
    for (found, want) in points(scene, &arrays).iter().zip(&mesh.points) {
        assert!(found.distance(*want) < 1e-9, "{found} {want}");
    }
    let Column::Label(truth) = &mesh.attributes.face["truth"] else { panic!("labels") };
    let labels: Vec<i32> = bits(&layer(scene, "truth")["values"], &arrays).iter().map(|&b| b as i32).collect();
    assert_eq!(&labels, truth);
    let found = reals(&layer(scene, "height")["values"], &arrays);
    assert!(found.iter().zip(&height).all(|(a, b)| (a - b).abs() <= 1e-7 * b.abs()));
    let quality = reals(&layer(scene, "quality")["values"], &arrays);
    assert!(quality.len() == mesh.faces.len() && quality.iter().all(|q| (0.0..=1.0 + 1e-6).contains(q)));
}

#[test]
fn polygons_of_all_sizes_cells_and_nets_are_held() {
    let square = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(x, y)| (f64::from(x), f64::from(y)));
    let points = [0.0, 1.0].iter().flat_map(|&z| square.map(|(x, y)| DVec3::new(x, y, z))).collect();
    let faces: Polygons = [&[0, 1, 2][..], &[0, 2, 3, 7, 4]].into_iter().collect();
    let cells = Cells { tets: vec![[0, 1, 3, 4]], hexes: vec![[0, 1, 2, 3, 4, 5, 6, 7]], ..Cells::default() };
    let mesh = RawMesh { points, faces, cells, ..RawMesh::default() };
    let net = CurveNet::new(vec![DVec3::ZERO, DVec3::ONE], vec![0.25, f64::NAN], vec![[0, 1]]);
    let (head, arrays) = read(&page_of(Scene::of_mesh("m", &mesh).unwrap().net("axis", &net)));
    let scene = &head["scenes"][0];
    assert_eq!(bits(&scene["faces"]["sizes"], &arrays), [3, 5]);
    assert_eq!(bits(&scene["cells"]["sizes"], &arrays), [4, 8]);
    assert_eq!(bits(&scene["cells"]["corners"], &arrays)[4..], [0, 1, 2, 3, 4, 5, 6, 7]);
    let quality = reals(&layer(scene, "quality")["values"], &arrays);
    assert!(quality[0].is_nan() && (quality[1] - 1.0).abs() < 1e-6);
    let radii = reals(&scene["nets"][0]["radii"], &arrays);
    assert!((radii[0] * scene["scale"].as_f64().unwrap() - 0.25).abs() < 1e-6 && radii[1].is_nan());
}

#[test]
fn nothing_in_a_name_can_end_the_script_or_open_an_element() {
    let evil = "</script><script>alert(1)</script><!--<img src=x onerror=alert(1)>&\u{2028}";
    let mut mesh = RawMesh::from(sample::make("torus", Some(12), &Context::new()).unwrap());
    mesh.attributes.face.insert(evil.into(), Column::Label(vec![0; mesh.faces.len()]));
    mesh.attributes.names.insert((evil.into(), 0), evil.into());
    let plain = Page::new("t").scene(Scene::of_mesh("m", &mesh).unwrap()).html().unwrap();
    let record = json!({ "input": { "file": evil } });
    let page = Page::new(evil).command(evil).record(record).scene(Scene::of_mesh(evil, &mesh).unwrap());
    let html = page.html().unwrap();
    for tag in ["<script", "</script", "<!--", "<img", "alert(1)</"] {
        assert_eq!(html.matches(tag).count(), plain.matches(tag).count(), "{tag}");
    }
    let (head, _) = read(&html);
    assert_eq!((&head["title"], &head["command"]), (&evil.into(), &evil.into()));
    assert_eq!((&head["scenes"][0]["name"], &head["record"]["input"]["file"]), (&evil.into(), &evil.into()));
    assert_eq!(layer(&head["scenes"][0], evil)["words"]["0"], evil);
}

#[test]
fn a_page_asks_for_nothing_from_outside() {
    let html = page_of(Scene::of_surface("m", &sample::make("torus", Some(12), &Context::new()).unwrap()).unwrap());
    // Addresses may stand in the texts of the bundle; none may be loaded.
    for load in ["src=", "<link rel=\"stylesheet\"", "@import", "url(http", "fetch(", "XMLHttpRequest(", "WebSocket("] {
        let head = &html[..html.find("id=\"carreau-head\"").unwrap()];
        assert!(!head.contains(load), "{load}");
    }
    assert_eq!(html.matches("<link").count(), 1, "the empty icon");
    assert_eq!(html.to_lowercase().matches("</script").count(), 3, "one end per script element");
    assert!(!STYLES.contains("url(") && !STYLES.to_lowercase().contains("</style"));
}

#[test]
fn the_same_scenes_give_the_same_bytes() {
    let context = Context::new();
    let mesh = sample::make("bracket", None, &context).unwrap();
    let page = || {
        let found = field(&mesh, &FieldOptions::default(), &context).unwrap();
        let surface = Scene::of_surface("m", &mesh).unwrap().with_curvature(&context).unwrap();
        Page::new("t").scene(surface).scene(Scene::of_field("field", &found).unwrap()).html().unwrap()
    };
    let first = page();
    assert!(first == page());
    let (head, arrays) = read(&first);
    let of_field = &head["scenes"][1];
    assert!(layer(&head["scenes"][0], "kmax")["range"] == "diverging" && of_field["show"] == "plain");
    let arms = of_field["lines"].as_array().unwrap().iter().find(|l| l["style"] == "field").unwrap();
    assert!(reals(&arms["segments"], &arrays).iter().all(|x| x.abs() < 1.01));
}

#[test]
fn extreme_and_empty_models_stay_finite() {
    for size in [1e-300, 1.0, 1e300] {
        let points = vec![DVec3::ZERO, DVec3::X * size, DVec3::Y * size];
        let mut mesh = RawMesh { points, faces: Polygons::from_triangles(&[[0, 1, 2]]), ..RawMesh::default() };
        mesh.attributes.vertex.insert("x".into(), Column::Scalar(vec![0.0, size, -size]));
        let (head, arrays) = read(&page_of(Scene::of_mesh("m", &mesh).unwrap()));
        let scene = &head["scenes"][0];
        assert!(reals(&scene["points"], &arrays).iter().all(|x| x.abs() <= 1.0));
        let x = layer(scene, "x");
        let back = reals(&x["values"], &arrays)[1] * x["unit"].as_f64().unwrap();
        assert!((back / size - 1.0).abs() < 1e-6);
    }
    let (head, _) = read(&page_of(Scene::of_mesh("none", &RawMesh::default()).unwrap()));
    assert_eq!((&head["scenes"][0]["scale"], &head["scenes"][0]["show"]), (&1.0.into(), &"plain".into()));
    let lost = RawMesh { faces: Polygons::from_triangles(&[[0, 1, 2]]), ..RawMesh::default() };
    assert!(Scene::of_mesh("lost", &lost).is_err());
    let none = SurfaceMesh::new(Vec::new(), Polygons::new()).unwrap();
    assert!(Scene::of_surface("none", &none).is_ok());
    assert!(Page::new("nothing").html().is_ok());
}
