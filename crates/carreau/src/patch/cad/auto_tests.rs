//! What every program shows: faces without bends, at creases only, as few planes as there are, the right area and volume.

use super::models::Model;
use super::*;
use crate::brep::{Edge, Face};
use crate::patch::decomposition::decompose;
use crate::patch::options::PatchOptions;
use crate::sample;
use glam::DVec3;
use rustc_hash::FxHashSet;

fn cad(mesh: &SurfaceMesh, fit: Fit) -> CadModel {
    let ctx = Context::new();
    let options = PatchOptions {
        feature_angle: Some(30.0),
        feature_edges: borders(mesh, &ctx).unwrap(),
        ..PatchOptions::default()
    };
    let layout = decompose(mesh, &options, &ctx).unwrap();
    let options = BrepOptions { fit, ..Default::default() };
    to_brep(mesh, &layout.patches, &layout.leftover, &options, &ctx).unwrap()
}

fn made(name: &str) -> SurfaceMesh {
    sample::make(name, None, &Context::new()).unwrap()
}

fn volume(mesh: &SurfaceMesh) -> f64 {
    let p = |v: u32| mesh.points()[v as usize];
    mesh.faces().iter().map(|f| p(f[0]).dot(p(f[1]).cross(p(f[2]))) / 6.0).sum()
}

#[test]
fn a_cube_has_six_faces_and_twelve_edges_however_it_is_meshed() {
    for cells in [1, 2, 5] {
        let mut model = Model::default();
        model.cube(cells, DVec3::new(3.0, -7.0, 0.1), 0.3, false);
        for fit in [Fit::Auto, Fit::Bicubic] {
            let CadModel { brep, faces, mass_error, .. } = cad(&model.mesh(), fit);
            assert_eq!((faces.planes, brep.faces.len(), brep.edges.len(), brep.vertices.len()), (6, 6, 12, 8));
            assert_eq!(brep.solids.len(), 1);
            assert!(mass_error.iter().all(|&e| e < 1e-12));
        }
    }
}

#[test]
fn parts_weigh_what_their_triangles_do() {
    for name in ["cube-cylinders", "bracket"] {
        let mesh = made(name);
        let CadModel { brep, mass_error, .. } = cad(&mesh, Fit::Auto);
        let seen = weigh::weigh(&brep);
        assert!(mass_error.iter().all(|&e| e < 1e-4), "{name} {mass_error:?}");
        let exact = volume(&mesh);
        assert!((seen.rule.volume - exact).abs() < 1e-3 * exact, "{name} {} {exact}", seen.rule.volume);
        assert_eq!(brep.solids.len(), 1);
    }
}

#[test]
fn creases_are_edges() {
    let mesh = made("bracket");
    let brep = cad(&mesh, Fit::Auto).brep;
    // Every edge is straight here, so a mesh edge on it has both its ends on it.
    let on_edge = |p: DVec3, e: &Edge| {
        let [a, b] = e.ends.map(|v| brep.point(v));
        let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        p.distance(a.lerp(b, t)) < 1e-5 * mesh.diagonal()
    };
    let triangles = crate::mesh::Triangles::of(&mesh).unwrap();
    let normal = |t: u32| {
        let [a, b, c] = triangles.triangle(t).map(|v| mesh.points()[v as usize]);
        (b - a).cross(c - a).normalize_or_zero()
    };
    let mut seen = FxHashSet::default();
    for c in 0..mesh.corner_count() as u32 {
        let o = triangles.opposite(c);
        if o == NONE || o < c || normal(c / 3).dot(normal(o / 3)) > 0.866 {
            continue;
        }
        let [p, q] = [c, triangles.next(c)].map(|c| triangles.point(c));
        assert!(brep.edges.iter().any(|e| on_edge(p, e) && on_edge(q, e)), "{p} {q}");
        seen.insert(c);
    }
    assert!(seen.len() > 20);
}

#[test]
fn one_face_a_patch_is_told_to_weigh_wrong() {
    let mut model = Model::default();
    model.cylinder(16, 1, false);
    let told = |fit| cad(&model.mesh(), fit);
    let bilinear = told(Fit::Bilinear);
    assert!(bilinear.mass_error[1] > 1e-3 && bilinear.warnings.iter().any(|w| w.contains("default rule")));
    let auto = told(Fit::Auto);
    assert!(auto.mass_error.iter().all(|&e| e < 1e-9) && auto.warnings.is_empty());
    // Two lids and sixteen facets.
    assert_eq!((auto.brep.faces.len(), auto.faces.planes), (18, 18));
    let smooth = told(Fit::Bicubic);
    assert_eq!(smooth.faces.planes, 2);
    assert!(smooth.faces.bicubic >= 2 && smooth.faces.bilinear == 0, "{:?}", smooth.faces);
    assert!(smooth.mass_error.iter().all(|&e| e < 1e-4), "{:?}", smooth.mass_error);
}

#[test]
fn holes_and_pinches_of_flat_regions_are_loops_and_cuts() {
    // A plate of 4 × 4 cells: one inside missing is a hole; two that meet at a corner of it pinch the border.
    let plate = |missing: &[(u32, u32)]| {
        let mut model = Model::default();
        for (r, c) in (0..4).flat_map(|r| (0..4).map(move |c| (r, c))).filter(|p| !missing.contains(p)) {
            let at = |i: u32, j: u32| DVec3::new(f64::from(c + j), f64::from(r + i), 1.0);
            model.grid(1, 1, at);
        }
        to_brep(&model.mesh(), &model.patches, &[], &BrepOptions::default(), &Context::new()).unwrap().brep
    };
    let hole = plate(&[(1, 1)]);
    assert_eq!((hole.faces.len(), hole.faces[0].loops.len(), hole.edges.len()), (1, 2, 8));
    let pinched = plate(&[(1, 1), (2, 2)]);
    assert!(pinched.faces.len() > 1);
    for brep in [hole, pinched] {
        let seen = weigh::weigh(&brep);
        assert!(seen.errors()[0] < 1e-12);
    }
    assert!((weigh::weigh(&plate(&[(1, 1), (2, 2)])).rule.area - 14.0).abs() < 1e-12);
}

#[test]
fn bodies_and_groups_have_their_names_and_colours() {
    use crate::mesh::Column;
    let mut model = Model::default();
    model.cube(2, DVec3::ZERO, 1.0, false);
    model.cube(2, DVec3::new(3.0, 0.0, 0.0), 1.0, false);
    let mut mesh = model.mesh();
    let half = mesh.face_count() / 2;
    let bodies: Vec<i32> = (0..mesh.face_count()).map(|t| i32::from(t >= half)).collect();
    // One triangle of the first body's first side is red and in a group of its own.
    let red = |t: usize| t == 0;
    let colors = (0..mesh.face_count()).map(|t| if red(t) { [255, 0, 0, 255] } else { [9, 9, 9, 255] }).collect();
    let groups = (0..mesh.face_count()).map(|t| i32::from(red(t))).collect();
    mesh.attributes.face.insert("object".into(), Column::Label(bodies));
    mesh.attributes.face.insert("group".into(), Column::Label(groups));
    mesh.attributes.face.insert("color".into(), Column::Color(colors));
    for (column, label, word) in [("object", 0, "block"), ("object", 1, "lid"), ("group", 1, "spot")] {
        mesh.attributes.names.insert((column.into(), label), word.into());
    }
    let CadModel { brep, .. } = cad(&mesh, Fit::Auto);
    assert_eq!(brep.solids.iter().map(|s| s.name.as_str()).collect::<Vec<_>>(), ["block", "lid"]);
    assert_eq!(brep.faces.len(), 13);
    let spots: Vec<&Face> = brep.faces.iter().filter(|f| f.name == "spot").collect();
    assert_eq!(spots.len(), 1);
    assert_eq!(spots[0].color, Some([255, 0, 0]));
    assert_eq!(brep.faces.iter().filter(|f| f.color == Some([9, 9, 9])).count(), 12);
}
