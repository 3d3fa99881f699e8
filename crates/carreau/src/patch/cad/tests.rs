//! Invariants of the export over many models, exact, fitted and trimmed.

use super::models::{self, Model};
use super::*;
use crate::brep::{Brep, Curve, Edge, EdgeUse, Face, Surface};
use crate::geometry::bspline::BSplineSurface;
use crate::io::{CadOptions, iges, step};
use crate::mesh::VertexId;
use glam::DVec3;
use proptest::prelude::*;
use std::collections::BTreeMap;

fn export(model: &Model, options: &BrepOptions) -> CadModel {
    to_brep(&model.mesh(), &model.patches, &model.leftover, options, &Context::new()).unwrap()
}

fn exact(model: &Model) -> CadModel {
    export(model, &BrepOptions { fit: Fit::Bilinear, ..Default::default() })
}

fn auto(model: &Model) -> CadModel {
    export(model, &BrepOptions::default())
}

fn bicubic(model: &Model, tolerance: f64) -> CadModel {
    export(model, &BrepOptions { fit: Fit::Bicubic, tolerance: Length::Absolute(tolerance) })
}

/// One polygon per patch.
fn polygons(model: &Model) -> Vec<QuadPolygon> {
    let polygon = |p: &Patch| {
        let (m, n) = (p.rows as i32, p.cols as i32);
        let id =
            |r: i32, c: i32| if (0..m).contains(&r) && (0..n).contains(&c) { (r * n + c) as u32 } else { u32::MAX };
        let cell = |(r, c): (i32, i32)| QuadCell {
            row: r,
            col: c,
            corners: p.cell(r as u32, c as u32),
            next: [id(r - 1, c), id(r, c + 1), id(r + 1, c), id(r, c - 1)],
        };
        QuadPolygon { cells: (0..m).flat_map(|r| (0..n).map(move |c| (r, c))).map(cell).collect() }
    };
    model.patches.iter().map(polygon).collect()
}

fn trimmed(model: &Model) -> CadModel {
    to_trimmed_brep(&model.mesh(), &polygons(model), &model.leftover, &Context::new()).unwrap()
}

fn splines(brep: &Brep) -> impl Iterator<Item = (&Face, &BSplineSurface)> {
    brep.faces.iter().filter_map(|f| if let Surface::Spline(s) = brep.surface(f) { Some((f, s)) } else { None })
}

fn edge_point(brep: &Brep, edge: &Edge, share: f64) -> DVec3 {
    assert!(edge.ends.iter().zip(edge.range).all(|(&v, t)| brep.point(v).distance(edge.curve.point(t)) < 1e-12));
    edge.point_at(share)
}

/// The point of the parameter plane at a share of an edge's parameter range.
fn parameter_point(brep: &Brep, of: &EdgeUse, share: f64) -> [f64; 2] {
    let n = of.parameters.len();
    let (k, s) = match (&brep.edges[of.edge as usize].curve, n) {
        (_, 2) => (0, share),
        (Curve::Spline(c), _) => {
            let breaks = c.knots().breaks();
            assert_eq!(breaks.len(), n);
            let t = share * breaks[n - 1];
            let k = breaks.partition_point(|&b| b <= t).clamp(1, n - 1) - 1;
            (k, (t - breaks[k]) / (breaks[k + 1] - breaks[k]))
        }
        _ => panic!("a line with {n} parameter points"),
    };
    let (a, b) = (of.parameters[k], of.parameters[k + 1]);
    [a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1])]
}

/// Every edge lies on the surfaces of its faces, at the same parameter: no gap anywhere.
fn assert_edges_lie_on_surfaces(brep: &Brep, tolerance: f64) {
    for (k, face) in brep.faces.iter().enumerate() {
        for of in face.loops.iter().flatten() {
            let edge = &brep.edges[of.edge as usize];
            for share in (0..=24).map(|k| f64::from(k) / 24.0) {
                let p = edge_point(brep, edge, share);
                let off = match brep.surface(face) {
                    Surface::Plane { frame } => {
                        assert!((frame.z.length() - 1.0).abs() < 1e-12 && frame.z.dot(frame.x).abs() < 1e-12);
                        frame.local(p).z.abs()
                    }
                    Surface::Spline(s) => {
                        let [u, v] = parameter_point(brep, of, share);
                        s.point(u, v).distance(p)
                    }
                    other => panic!("a patch lies on a {}", other.kind().name()),
                };
                assert!(off <= tolerance, "face {k}, edge {}: {off:e} at {share}", of.edge);
            }
        }
    }
}

/// Loops run counter-clockwise in the parameter plane, holes clockwise.
fn assert_loop_senses(brep: &Brep) {
    for (face, _) in splines(brep) {
        for (k, uses) in face.loops.iter().enumerate() {
            let mut ring: Vec<[f64; 2]> = Vec::new();
            for of in uses {
                let mut points = of.parameters.clone();
                if of.reversed {
                    points.reverse();
                }
                assert!(ring.last().is_none_or(|last| *last == points[0]), "parameter curves do not meet");
                ring.extend(points);
            }
            assert_eq!(ring.first(), ring.last());
            let area: f64 = ring.windows(2).map(|w| w[0][0] * w[1][1] - w[1][0] * w[0][1]).sum();
            assert_eq!(area > 0.0, k == 0);
        }
    }
}

/// Number of shells of all closed components, outer ones and voids, by an independent count.
fn component_signs(model: &Model) -> BTreeMap<i32, usize> {
    let mesh = model.mesh();
    let n = mesh.face_count();
    let mut label: Vec<usize> = (0..n).collect();
    // Label propagation over all coinciding edges: slow, but nothing like the code under test.
    let mut faces_at: BTreeMap<[u32; 2], Vec<(usize, bool)>> = BTreeMap::new();
    for (f, t) in model.triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            faces_at.entry([a.min(b), a.max(b)]).or_default().push((f, a < b));
        }
    }
    loop {
        let mut changed = false;
        for faces in faces_at.values() {
            let least = faces.iter().map(|&(f, _)| label[f]).min().unwrap();
            for &(f, _) in faces {
                changed |= label[f] != least;
                label[f] = least;
            }
        }
        if !changed {
            break;
        }
    }
    let mut out: BTreeMap<i32, usize> = BTreeMap::new();
    for root in (0..n).filter(|&f| label[f] == f) {
        let regular = |faces: &Vec<(usize, bool)>| faces.len() == 2 && faces[0].1 != faces[1].1;
        let closed = faces_at.values().filter(|f| label[f[0].0] == root).all(regular);
        let volume: f64 = (0..n)
            .filter(|&f| label[f] == root)
            .map(|f| model.triangles[f].map(|v| model.points[v as usize]))
            .map(|[a, b, c]| a.dot(b.cross(c)) / 6.0)
            .sum();
        *out.entry(if closed { if volume > 0.0 { 1 } else { -1 } } else { 0 }).or_default() += 1;
    }
    out
}

#[test]
fn exact_models_are_the_mesh() {
    for (name, model) in models::all() {
        let CadModel { brep, mut warnings, .. } = exact(&model);
        // That faces with bends weigh wrong in other programs is said, too.
        warnings.retain(|what| !what.contains("default rule"));
        assert_edges_lie_on_surfaces(&brep, 1e-12);
        assert_loop_senses(&brep);
        // Every surface passes through the mesh vertices of its cells, bit for bit, and together they have them all.
        let mut seen = 0;
        for (_, s) in splines(&brep) {
            let [u, v] = s.knots();
            for (k, p) in s.points().iter().enumerate() {
                assert!(model.points.contains(p), "{name}");
                assert_eq!(s.point((k % u.count()) as f64, (k / u.count()) as f64), *p, "{name}");
            }
            seen += (u.count() - 1) * (v.count() - 1);
        }
        assert_eq!(seen, model.patches.iter().map(Patch::cells).sum::<usize>(), "{name}");
        assert_eq!(brep.faces.len() - splines(&brep).count(), model.leftover.len());
        let signs = component_signs(&model);
        let count = |sign: i32| signs.get(&sign).copied().unwrap_or(0);
        assert_eq!(brep.solids.len(), count(1), "{name}");
        let voids: usize = brep.solids.iter().map(|s| s.voids.len()).sum();
        assert_eq!(voids + usize::from(!warnings.is_empty()), count(-1), "{name}: {warnings:?}");
    }
}

#[test]
fn faces_are_patches_except_where_they_touch_themselves() {
    let faces: BTreeMap<&str, usize> =
        models::all().into_iter().map(|(n, m)| (n, exact(&m).brep.faces.len())).collect();
    let expected =
        [("cube", 6), ("torus", 4), ("cylinder", 4), ("fanned", 34), ("hollow", 18), ("open", 1), ("moebius", 2)];
    for (name, count) in expected {
        assert_eq!(faces[name], count, "{name}");
    }
}

#[test]
fn chains_between_nodes_are_one_shared_edge() {
    // Two patches of 2 × 4 and 2 × 2 + 2 × 2 cells, one above the other: T-nodes only in the middle.
    let mut model = Model::default();
    let at = |r: u32, c: u32| DVec3::new(c.into(), r.into(), 0.0);
    model.grid(2, 4, at);
    model.grid(2, 2, |r, c| at(r + 2, c));
    model.grid(2, 2, |r, c| at(r + 2, c + 2));
    let brep = exact(&model).brep;
    assert_eq!((brep.faces.len(), brep.vertices.len()), (3, 8));
    // Ten chains: the lower patch has five, the upper ones share one and have two more each.
    assert_eq!(brep.edges.len(), 10);
    let mut uses = vec![0; brep.edges.len()];
    brep.faces.iter().flat_map(|f| f.loops.iter().flatten()).for_each(|of| uses[of.edge as usize] += 1);
    assert_eq!(uses.iter().filter(|&&n| n == 2).count(), 3);
    assert!(!brep.shells[0].closed && brep.shells.len() == 1);
}

#[test]
fn a_void_goes_to_the_smallest_solid_around_it() {
    let model = models::all().into_iter().find(|(n, _)| *n == "hollow").unwrap().1;
    let brep = exact(&model).brep;
    // The outer cube, its cavity, and a cube that floats in it.
    assert_eq!(brep.solids.len(), 2);
    let voids: Vec<usize> = brep.solids.iter().map(|s| s.voids.len()).collect();
    assert_eq!(voids, [1, 0]);
    assert_eq!(brep.shells[brep.solids[0].outer as usize].faces[0], 0);
    assert!(brep.free_shells().is_empty());
}

#[test]
fn faces_on_irregular_edges_do_not_share_them() {
    for name in ["edge", "moebius"] {
        let model = models::all().into_iter().find(|(n, _)| *n == name).unwrap().1;
        let brep = exact(&model).brep;
        assert!(brep.solids.is_empty() && brep.shells.iter().all(|s| !s.closed), "{name}");
    }
}

#[test]
fn triangles_without_area_keep_their_faces_and_the_solid_closed() {
    for model in [models::flat_triangle(0.0), models::flat_triangle(1e-14), models::short_edge(0.0)] {
        let CadModel { brep, warnings, .. } = exact(&model);
        assert_eq!((brep.faces.len(), brep.solids.len(), warnings.len()), (6, 1, 1));
        assert_edges_lie_on_surfaces(&brep, 1e-12);
        for v in &brep.vertices {
            let nearest = model.points.iter().map(|q| q.distance(v.point)).fold(f64::INFINITY, f64::min);
            assert!(nearest < 2e-9);
        }
    }
    for model in [models::flat_triangle(1e-9), models::short_edge(1e-9)] {
        assert!(exact(&model).warnings.is_empty());
    }
    // A triangle that is an edge run twice: its neighbours meet without it.
    let mut model = Model::default();
    model.cube(1, DVec3::ZERO, 1.0, false);
    let [a, b] = [model.points[0], model.points[1]];
    model.triangle([a, b, b]);
    let CadModel { brep, warnings, .. } = exact(&model);
    assert_eq!((brep.faces.len(), brep.solids.len(), warnings.len()), (6, 1, 1));
}

#[test]
fn what_does_not_fit_the_mesh_is_refused() {
    let (_, good) = models::all().swap_remove(0);
    let refused = |change: &dyn Fn(&mut Model)| {
        let mut bad = good.clone();
        change(&mut bad);
        let options = BrepOptions { fit: Fit::Bilinear, ..Default::default() };
        let result = to_brep(&good.mesh(), &bad.patches, &bad.leftover, &options, &Context::new());
        matches!(result, Err(crate::Error::Input { .. }))
    };
    assert!(refused(&|m| m.patches[0].rows = 0));
    assert!(refused(&|m| m.patches[0].rows = u32::MAX));
    assert!(refused(&|m| m.patches[0].cols += 1));
    assert!(refused(&|m| m.patches[0].vertices[0] = VertexId(u32::MAX)));
    assert!(refused(&|m| m.patches[0].vertices[0] = m.patches[0].vertices[1]));
    assert!(refused(&|m| m.leftover.push(FaceId(u32::MAX))));
    assert!(!refused(&|_| {}));
    // The same patch twice: four faces meet at its border, the result is open but consistent.
    let twice: Vec<Patch> = good.patches.iter().chain(&good.patches[..1]).cloned().collect();
    let options = BrepOptions { fit: Fit::Bilinear, ..Default::default() };
    let model = to_brep(&good.mesh(), &twice, &[], &options, &Context::new()).unwrap();
    assert!(model.brep.solids.is_empty());
}

#[test]
fn damage_to_a_model_is_found() {
    let (_, model) = models::all().swap_remove(0);
    let good = exact(&model).brep;
    let found = |change: &dyn Fn(&mut Brep)| {
        let mut bad = good.clone();
        change(&mut bad);
        bad.check().is_err()
    };
    assert!(!found(&|_| {}));
    assert!(found(&|b| b.faces[0].loops[0][1].reversed ^= true));
    assert!(found(&|b| b.faces[0].loops[0].swap(0, 1)));
    assert!(found(&|b| b.faces[0].loops.clear()));
    assert!(found(&|b| b.edges[0].ends[0] = 99));
    assert!(found(&|b| b.vertices[0].point.x += 1e-9));
    assert!(found(&|b| b.shells[0].faces.truncate(5)));
    assert!(found(&|b| b.shells.push(b.shells[0].clone())));
    assert!(found(&|b| b.shells[0].closed = false));
    assert!(found(&|b| b.solids[0].outer = 1));
}

// Fitted ---------------------------------------------------------------------------------------------------------------

/// Largest distance of a mesh vertex from the surfaces, searched from a grid of starting points.
fn deviation(model: &Model, brep: &Brep) -> f64 {
    let exact =
        |p: DVec3| splines(brep).any(|(_, s)| s.knots().iter().all(|k| k.degree() == 1) && s.points().contains(&p));
    let near = |s: &BSplineSurface, p: DVec3| {
        let [du, dv] = s.knots().map(|k| k.domain());
        let grid = (0..=24).flat_map(|i| (0..=24).map(move |j| (f64::from(i) / 24.0, f64::from(j) / 24.0)));
        let at = |(a, b): (f64, f64)| [du[0] + a * (du[1] - du[0]), dv[0] + b * (dv[1] - dv[0])];
        let distance = |[u, v]: [f64; 2]| s.point(u, v).distance(p);
        let start = grid.map(at).min_by(|a, b| distance(*a).total_cmp(&distance(*b))).unwrap();
        distance(s.project(p, start))
    };
    let planes = || {
        brep.surfaces.iter().filter_map(|s| match s {
            Surface::Plane { frame } => Some((frame.origin, frame.z)),
            _ => None,
        })
    };
    let near_plane = |p: DVec3| planes().map(|(o, n)| (p - o).dot(n).abs()).fold(f64::INFINITY, f64::min);
    let on_patches = model.patches.iter().flat_map(|p| &p.vertices).map(|v| model.points[v.index()]);
    let searched = on_patches.filter(|&p| !exact(p));
    searched.map(|p| splines(brep).map(|(_, s)| near(s, p)).fold(near_plane(p), f64::min)).fold(0.0, f64::max)
}

fn bytes(brep: &Brep) -> usize {
    let mut out = Vec::new();
    step::write(brep, &CadOptions::default(), &mut out).unwrap();
    out.len()
}

#[test]
fn smooth_models_shrink_within_the_tolerance() {
    let mut torus = Model::default();
    torus.torus(64, 32, [2.0, 0.5]);
    let mut cylinder = Model::default();
    cylinder.cylinder(64, 32, false);
    for model in [torus, cylinder] {
        let tolerance = 1e-3 * model.mesh().diagonal();
        let CadModel { brep, faces, mass_error, .. } = bicubic(&model, tolerance);
        // Four points a span are few for a full turn of a torus: a warning says so.
        assert!(faces.bicubic > 0 && faces.bilinear == 0 && mass_error.iter().all(|&e| e < 1e-3), "{mass_error:?}");
        assert_eq!((brep.solids.len(), brep.free_shells().len()), (1, 0));
        assert_edges_lie_on_surfaces(&brep, 1e-12);
        assert_loop_senses(&brep);
        let told = faces.deviation_max;
        let measured = deviation(&model, &brep);
        assert!(measured <= told + 1e-9 && told <= tolerance, "{measured} {told} {tolerance}");
        assert!(5 * bytes(&brep) <= bytes(&exact(&model).brep));
    }
}

#[test]
fn flat_patches_are_planes_however_jagged_their_borders() {
    // Two blocks beside each other, with a zigzag far wider than the tolerance between them.
    let at = |r: u32, c: u32| {
        let zigzag = if c == 8 && r % 2 == 1 { 0.4 } else { 0.0 };
        DVec3::new(f64::from(c) + zigzag, f64::from(r), f64::from(r) * 0.25)
    };
    let mut model = Model::default();
    model.grid(12, 8, at);
    model.grid(12, 8, |r, c| at(r, c + 8));
    let CadModel { brep, faces, .. } = bicubic(&model, 1e-3);
    assert_eq!((brep.faces.len(), faces.planes), (1, 1));
    assert_edges_lie_on_surfaces(&brep, 1e-12);
    assert_loop_senses(&brep);
    assert!(3 * bytes(&brep) <= bytes(&exact(&model).brep));
}

#[test]
fn all_models_weigh_right() {
    for (name, model) in models::all() {
        let plain = exact(&model).brep;
        let tolerances = [0.0, 1e-6, 0.01, 0.1].map(|t| bicubic(&model, t));
        for CadModel { brep, mass_error, .. } in tolerances.into_iter().chain([auto(&model)]) {
            assert_edges_lie_on_surfaces(&brep, 1e-12);
            assert_loop_senses(&brep);
            assert!(mass_error.iter().all(|&e| e < 1e-4), "{name} {mass_error:?}");
            let voids = |b: &Brep| b.solids.iter().map(|s| s.voids.len()).collect::<Vec<_>>();
            assert_eq!((voids(&brep), brep.shells.len()), (voids(&plain), plain.shells.len()), "{name}");
        }
    }
}

fn height(x: f64, y: f64) -> f64 {
    0.1 * (5.0 * x).sin() * (4.0 * y).cos()
}

/// A hilly square of several patches with T-nodes, and leftover triangles along one side.
fn hills(cells: u32) -> Model {
    let at = move |r: u32, c: u32| {
        let (x, y) = (f64::from(c) / f64::from(cells), f64::from(r) / f64::from(cells));
        DVec3::new(x, y, height(x, y))
    };
    let (half, third) = (cells / 2, cells / 3);
    let mut model = Model::default();
    model.grid(half, cells, at);
    model.grid(cells - half, third, |r, c| at(r + half, c));
    model.grid(cells - half, cells - third, |r, c| at(r + half, c + third));
    for c in 0..cells / 4 {
        model.triangle([at(0, c + 1), at(0, c), DVec3::new(f64::from(c) / f64::from(cells), -0.1, 0.0)]);
    }
    model
}

#[test]
fn fits_follow_t_nodes_and_shrink_with_the_tolerance() {
    let mut model = hills(24);
    model.leftover.clear();
    let mut last = usize::MAX;
    for tolerance in [1e-3, 1e-2] {
        let CadModel { brep, faces, .. } = bicubic(&model, tolerance);
        assert_edges_lie_on_surfaces(&brep, 1e-12);
        assert_eq!((faces.bicubic, brep.faces.len()), (3, 3), "{faces:?}");
        assert!(deviation(&model, &brep) <= tolerance + 1e-9);
        // Between the vertices, too: the mesh itself is up to 1.2e-3 off the function there.
        for (_, s) in splines(&brep) {
            let [du, dv] = s.knots().map(|k| k.domain()[1]);
            for k in 0..=50 * 50 {
                let p = s.point(f64::from(k % 51) / 50.0 * du, f64::from(k / 51) / 50.0 * dv);
                assert!((p.z - height(p.x, p.y)).abs() <= 1.5 * tolerance + 1.2e-3);
            }
        }
        let size = splines(&brep).map(|(_, s)| s.points().len()).sum();
        assert!(size <= last, "{tolerance}: {size} > {last}");
        last = size;
    }
    assert!(3 * last < model.points.len());
}

#[test]
fn cells_among_bicubic_faces_have_straight_sides() {
    // Triangles along one side: the patch beside them cannot be bicubic, and so cannot those beside it.
    let model = hills(24);
    let CadModel { brep, faces, mass_error, .. } = bicubic(&model, 1e-3);
    assert_eq!(faces.bicubic, 0);
    assert!(brep.edges.iter().all(|e| matches!(e.curve, Curve::Line { .. })) && mass_error[0] < 1e-4, "{mass_error:?}");
    assert!(deviation(&model, &brep) < 1e-12);
}

#[test]
fn threads_do_not_change_the_file() {
    let model = hills(24);
    let options = BrepOptions { fit: Fit::Bicubic, tolerance: Length::Absolute(1e-4) };
    let file = |threads: usize| {
        let ctx = Context::new().with_threads(threads).unwrap();
        let brep = to_brep(&model.mesh(), &model.patches, &model.leftover, &options, &ctx).unwrap().brep;
        let mut out = Vec::new();
        step::write(&brep, &CadOptions::default(), &mut out).unwrap();
        iges::write(&brep, &CadOptions::default(), &mut out).unwrap();
        out
    };
    assert_eq!(file(1), file(3));
}

#[test]
fn a_cancelled_run_stops() {
    let flag = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(true));
    let ctx = Context::new().with_cancel(flag);
    let model = hills(6);
    for fit in [Fit::Auto, Fit::Bilinear, Fit::Bicubic] {
        let options = BrepOptions { fit, ..Default::default() };
        let result = to_brep(&model.mesh(), &model.patches, &model.leftover, &options, &ctx);
        assert!(matches!(result, Err(crate::Error::Cancelled)));
    }
}

// Trimmed --------------------------------------------------------------------------------------------------------------

/// The cells of a wavy grid that a mask keeps, as one mesh and its polygons; `wall(r, c)` separates cell (r, c) from the
/// one to its right.
fn masked(size: i32, keep: &dyn Fn(i32, i32) -> bool, wall: &dyn Fn(i32, i32) -> bool) -> (Model, QuadPolygon) {
    let mut model = Model::default();
    let at = |r: i32, c: i32| DVec3::new(c.into(), r.into(), 0.3 * f64::from(r * c % 5));
    let places: Vec<(i32, i32)> =
        (0..size).flat_map(|r| (0..size).map(move |c| (r, c))).filter(|&(r, c)| keep(r, c)).collect();
    let id = |r, c| places.iter().position(|&p| p == (r, c)).map_or(u32::MAX, |k| k as u32);
    let mut polygon = QuadPolygon::default();
    for &(r, c) in &places {
        model.grid(1, 1, |i, j| at(r + i as i32, c + j as i32));
        let joined = |walled: bool, k: u32| if walled { u32::MAX } else { k };
        polygon.cells.push(QuadCell {
            // Anywhere on the integer grid.
            row: r - 7,
            col: c + 1000,
            corners: model.patches[model.patches.len() - 1].cell(0, 0),
            next: [id(r - 1, c), joined(wall(r, c), id(r, c + 1)), id(r + 1, c), joined(wall(r, c - 1), id(r, c - 1))],
        });
    }
    (model, polygon)
}

fn trim(model: &Model, polygon: QuadPolygon) -> Brep {
    let brep = to_trimmed_brep(&model.mesh(), &[polygon], &[], &Context::new()).unwrap().brep;
    assert_edges_lie_on_surfaces(&brep, 1e-12);
    assert_loop_senses(&brep);
    brep
}

/// Area of a face's loops in the parameter plane: its number of cells.
fn cells(face: &Face) -> f64 {
    let segment = |of: &EdgeUse| {
        let twice: f64 = of.parameters.windows(2).map(|w| w[0][0] * w[1][1] - w[1][0] * w[0][1]).sum();
        twice * if of.reversed { -0.5 } else { 0.5 }
    };
    face.loops.iter().flatten().map(segment).sum()
}

#[test]
fn polygons_become_single_trimmed_faces() {
    let no = |_: i32, _: i32| false;
    let l = |r: i32, c: i32| r < 2 || c < 2;
    let ring = |r: i32, c: i32| !((1..3).contains(&r) && (1..4).contains(&c));
    for (keep, loops) in [(&l as &dyn Fn(i32, i32) -> bool, 1), (&ring, 2)] {
        let (model, polygon) = masked(5, keep, &no);
        let count = polygon.cells.len();
        let brep = trim(&model, polygon);
        assert_eq!((brep.faces.len(), brep.faces[0].loops.len()), (1, loops));
        assert!(brep.faces[0].trimmed);
        assert_eq!(cells(&brep.faces[0]), count as f64);
    }
    let (model, polygon) = masked(4, &|_, _| true, &no);
    assert!(!trim(&model, polygon).faces[0].trimmed);
}

#[test]
fn slits_and_pinches_and_thin_spirals_are_cut() {
    // A slit from the border and one inside; two cells that touch at a corner, joined elsewhere; a long diagonal.
    let (model, polygon) = masked(6, &|_, _| true, &|r, c| c == 2 && r != 3);
    assert!(trim(&model, polygon).faces.len() >= 2);
    let (model, polygon) = masked(5, &|r, c| r == 0 || c == 4 || (r, c) != (2, 2) && (r - c).abs() != 1, &|_, _| false);
    let total = polygon.cells.len() as f64;
    assert_eq!(trim(&model, polygon).faces.iter().map(cells).sum::<f64>(), total);
    let (model, polygon) = masked(60, &|r, c| r == c || r == c + 1, &|_, _| false);
    let brep = trim(&model, polygon);
    for (face, s) in splines(&brep) {
        let [u, v] = s.knots().map(|k| (k.count() - 1) as f64);
        assert!(u * v <= 16.0 * cells(face));
    }
}

#[test]
fn closed_models_stay_closed_when_trimmed() {
    for name in ["torus", "cylinder", "hollow", "fanned"] {
        let model = models::all().into_iter().find(|(n, _)| *n == name).unwrap().1;
        let brep = trimmed(&model).brep;
        assert_edges_lie_on_surfaces(&brep, 1e-12);
        assert_eq!(brep.solids, exact(&model).brep.solids);
    }
}

#[test]
fn polygons_that_contradict_themselves_are_refused() {
    let (model, good) = masked(3, &|_, _| true, &|_, _| false);
    let refused = |change: &dyn Fn(&mut QuadPolygon)| {
        let mut bad = good.clone();
        change(&mut bad);
        let result = to_trimmed_brep(&model.mesh(), &[bad], &[], &Context::new());
        matches!(result, Err(crate::Error::Input { .. }))
    };
    assert!(!refused(&|_| {}));
    assert!(refused(&|p| p.cells[0].corners[0] = VertexId(u32::MAX)));
    assert!(refused(&|p| p.cells[0].corners[0] = p.cells[0].corners[1]));
    assert!(refused(&|p| p.cells[0].col += 1));
    assert!(refused(&|p| p.cells[0].next[1] = 5));
    assert!(refused(&|p| p.cells[0].next[1] = 99));
    assert!(refused(&|p| p.cells[0].row = i32::MAX));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_polygon_is_covered_exactly(
        mask in prop::collection::vec(prop::bool::weighted(0.75), 49),
        walls in prop::collection::vec(prop::bool::weighted(0.2), 49),
    ) {
        let inside = |r: i32, c: i32| (0..7).contains(&r) && (0..7).contains(&c);
        let at = |list: &[bool], r: i32, c: i32| inside(r, c) && list[(7 * r + c) as usize];
        let (model, polygon) = masked(7, &|r, c| at(&mask, r, c), &|r, c| at(&walls, r, c));
        prop_assume!(!polygon.cells.is_empty());
        let total = polygon.cells.len();
        let brep = trim(&model, polygon);
        let counts: Vec<f64> = brep.faces.iter().map(cells).collect();
        prop_assert_eq!(counts.iter().sum::<f64>(), total as f64);
    }

    /// Triangles at random, some paired into single-cell patches: no panic, and a model that passes its check.
    #[test]
    fn any_pairing_gives_a_consistent_model(
        corners in prop::collection::vec((0u32..9, 0u32..9, 0u32..9), 1..30),
        flat in any::<bool>(),
    ) {
        let point = |k: u32| DVec3::new(f64::from(k % 3), f64::from(k / 3), if flat { 0.0 } else { f64::from(k * k % 7) });
        let mut model = Model::default();
        model.points = (0..9).map(point).collect();
        for (a, b, c) in corners {
            model.triangles.push([a, b, c]);
        }
        let mut used = vec![false; model.triangles.len()];
        let mesh = model.mesh();
        for c in (0..mesh.corner_count()).map(crate::mesh::CornerId::new) {
            let Some(o) = mesh.opposite(c) else { continue };
            let (s, t) = (mesh.face_of(c), mesh.face_of(o));
            let quad = [mesh.vertex(c), mesh.vertex(mesh.previous(o)), mesh.vertex(o), mesh.vertex(mesh.previous(c))];
            let distinct = (0..4).all(|k| (0..k).all(|j| quad[j] != quad[k]));
            if distinct && !used[s.index()] && !used[t.index()] {
                (used[s.index()], used[t.index()]) = (true, true);
                let vertices = vec![quad[0], quad[1], quad[3], quad[2]];
                model.patches.push(Patch { rows: 1, cols: 1, vertices, triangles: vec![s, t] });
            }
        }
        model.leftover = (0..used.len()).filter(|&t| !used[t]).map(FaceId::new).collect();
        for fit in [Fit::Auto, Fit::Bilinear, Fit::Bicubic] {
            let options = BrepOptions { fit, ..Default::default() };
            let made = export(&model, &options);
            let (mut step_file, mut iges_file) = (Vec::new(), Vec::new());
            step::write(&made.brep, &CadOptions::default(), &mut step_file).unwrap();
            iges::write(&made.brep, &CadOptions::default(), &mut iges_file).unwrap();
        }
    }
}
